# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
EMPS, a positioning system of motor, screw and carriage: one free run beside published ones.

DATA is the folder with DATA_EMPS.mat and DATA_EMPS_PULSES.mat of nonlinearbenchmark.org (Janot,
Gautier, Brunot, 2019). From a model file with guesses the command does what a user would do:
fit, diagnose and fit again over the whole of the first recording, with the effect.
The second recording judges: one free run from the recorded force alone over all 24.8 s, from
position and speed in its first 20 samples, as the benchmark permits. Published figures: Champneys,
Beintema, Toth, Schoukens, Rogers, arXiv 2405.10779, table 3, and dynoNet as quoted there.

usage examples:
  python -m benchmarks emps path/to/emps
  python -m benchmarks emps emps --jobs 2 --json emps.json
"""
import argparse
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import (
    add_json_option, bar_lines, BarTable, finish, progress_line, require_whole)
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.recordings.reading import read_signals, ReadOptions
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import UniformRecording

FILES = ('DATA_EMPS.mat', 'DATA_EMPS_PULSES.mat')  # identification, test
START = 20           # samples from which the state of the test recording may be taken
WHOLE = 1000.0       # s: longer than the recordings
DRIVE_VALUES = ('m1', 'Cv', 'Cc')
# Root mean square of the error of the free run on the test recording, mm.
PUBLISHED = {
    'dynoNet, as quoted': 0.452, 'polynomial NARX': 5.17, 'linear state space': 5.53,
    'linear ARX': 12.6, 'LSTM': 74.1, 'RNN': 89.2, 'optimised LSTM': 111.0, 'MLP FIR': 121.0,
    'MLP NARX': 133.0, 'GRU': 220.0, 'GP NARX': 1690.0}
BAR = 6.0            # mm
# Guesses, right within a factor of two or three.
GUESSED = DriveModel(
    axis='prismatic', transmission=Transmission('rigid'), motor_inertia=60.0, arm_inertia=0.1,
    viscous_friction=100.0, coulomb_friction=10.0, friction_sharpness=1000.0, position_gain=0.0,
    tolerance=0.05, process_torque_time=0.3)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('data', metavar='DATA', help=f'folder with {" and ".join(FILES)}')
    parser.add_argument('--jobs', metavar='N', type=int, default=1, help='threads (default: 1)')
    add_json_option(parser)


def recording_of(path: Path) -> UniformRecording:
    """Return the recording in the file `path`, admitted as diagnose admits it."""
    raw = read_signals(path, ReadOptions('emps'))
    readings = np.column_stack([raw['motor_position'], raw['arm_position']])
    return admitted(raw.stamp_ns, raw['motor_effort'], readings, None, str(path), GUESSED,
                    'the model')[0]


def free_run_error(recording: UniformRecording, model: DriveModel) -> float:
    """
    Return the rms error (mm) of one free run of `model` over a `recording`.

    It begins in the position and speed of a parabola through the first START readings.
    """
    position = recording.y[:, 0]
    _, speed, start = np.polyfit(np.arange(START) * recording.dt, position[:START], 2)
    run = Plant(model, state=np.array([start, start, speed, speed])).run(
        recording.u, recording.dt)
    return 1e3 * float(np.sqrt(np.mean((run.y[:, 0] - position) ** 2)))


def measure(train: UniformRecording, test: UniformRecording, jobs: int) -> dict[str, Any]:
    """
    Identify the drive on `train` and judge on `test`; returns figures and bars as plain data.

    Args:
        train: recording that is fitted.
        test: recording that is judged.
        jobs: number of threads.
    """
    show = progress_line()
    show('fit model')
    rigid = fit_nominal([train], GUESSED, DRIVE_VALUES).model
    show('diagnose')
    verdict = diagnose([train], rigid, jobs=jobs)
    effects = verdict.effect.split('+') if verdict.effect else []
    show('fit model over the whole recording')
    models = {'without effect': fit_nominal(
        [train], rigid, DRIVE_VALUES, seconds=WHOLE).model}
    models['with effect'] = fit_nominal(
        [train], verdict.model, (*DRIVE_VALUES, *effects), seconds=WHOLE).model
    show('')
    errors = {name: {'train': free_run_error(train, model), 'test': free_run_error(test, model)}
              for name, model in models.items()}
    error = errors['with effect']['test']
    bars = BarTable()
    bars.judge('free run on the second recording, mm', error, high=BAR)
    return {'verdict': verdict.verdict, 'effect': verdict.effect,
            'confusable': verdict.confusable, 'effects': models['with effect'].effects,
            'errors': errors, 'published': PUBLISHED,
            'place': 1 + sum(value < error for value in PUBLISHED.values()), 'bars': bars.rows}


def table(data: dict[str, Any]) -> str:
    """Return the figures `data` of measure() as lines."""
    named = ' or '.join([data['effect'] or data['verdict'], *data['confusable']])
    own = {f'gearbox_monitor, {name}': values['test'] for name, values in data['errors'].items()}
    rows = sorted({**data['published'], **own}.items(), key=lambda row: row[1])
    fits = ', '.join(f'{values["train"]:.2f} mm {name}' for name, values in data['errors'].items())
    return '\n'.join([
        f'diagnosis of the first recording: {named}', f'fit of the first recording: {fits}',
        '', f'{"free run on the second recording":<36}{"rms, mm":>9}', '',
        *(f'{name:<36}{value:9.3g}' for name, value in rows), '',
        f'place {data["place"]} of {len(data["published"]) + 1}', *bar_lines(data['bars'])])


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--jobs', args.jobs)
    paths = [Path(args.data) / name for name in FILES]
    for path in paths:
        if not path.is_file():
            raise InputError(f'{path}: no such file, expected that of nonlinearbenchmark.org')
    train, test = map(recording_of, paths)
    data = measure(train, test, args.jobs)
    return finish(data, table(data), args.json)
