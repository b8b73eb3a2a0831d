# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Servos that swing a weight: a diagnosis by the setpoints, beside Better Actuator Models.

DATA holds the folders xl330 and sts3250 with recordings *.json.gz of BAM's test bench (Duclusaud
et al., arXiv 2410.08650, github.com/Rhoban/bam). The weight is exact; inertia, friction and torque
of the servo are guesses. Two motions of one firmware gain are diagnosed together, then the named
model is fitted to whole recordings. Recordings of another gain judge, or of another motion where
all have one gain: mean absolute error of one run from the setpoints alone, BAM's own metric, on
BAM's time grid. Motions that switch the torque off are left out.

With the package better-actuator-models (Python 3.12) its richest model M6 runs beside ours: with
its published parameters, and fitted to the same recordings by its own simulator.

usage examples:
  python -m benchmarks bam path/to/bam_servo_pendulum
  python -m benchmarks bam bam_servo_pendulum --servo xl330 --json bam.json
"""
import argparse
from dataclasses import dataclass, replace
import gzip
from importlib.util import find_spec
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution

from benchmarks.harness import (
    add_json_option, bar_lines, BarTable, finish, progress_line, require_whole)
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import Controller, DriveModel, Transmission
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.recordings.reading import read_signals, ReadOptions
from gearbox_monitor.robot.dynamics import GRAVITY
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import at_one_rate, UniformRecording

DT = 5e-3                    # s, BAM's time grid
WHOLE = 1000.0               # s: longer than the recordings
TRAINED = ('sin_sin', 'sin_time_square')  # motions that are fitted
FITTED = ('m1', 'Cv', 'Cc', 'kt', 'u0')
EXACT_OR_FITTED = ('gravity', 'torque_gain', 'torque_offset')  # the last two as kt and u0
GENERATIONS, POPULATION = 150, 8  # of the evolution that fits M6


@dataclass(frozen=True)
class BenchServo:
    """
    A servo of position by duty: its firmware, and guesses of its values.

    error_gain: duty per unit of the firmware's gain and rad; torque: at full duty and standstill,
    N m; inertia: of the motor, kg m^2; viscous N m s/rad, with the motor's own voltage; coulomb
    N m; actuator: its name in BAM; published: whether BAM has parameters of M6 for it.
    """

    error_gain: float
    torque: float
    inertia: float
    viscous: float
    coulomb: float
    actuator: str
    published: bool


SERVOS = {
    'xl330': BenchServo(4096.0 / (2.0 * math.pi * 256.0 * 885.0), 0.8, 0.002, 0.03, 0.01, 'xl330',
                        True),
    'sts3250': BenchServo(0.166, 10.0, 0.02, 1.0, 0.3, 'sts3215', False)}


@dataclass(frozen=True)
class ServoLog:
    """
    A recording on BAM's grid [N], rad; `raw` as stored, without rows.

    setpoint: in force, as the servo holds it; interpolated: between setpoints, as BAM takes it.
    """

    path: Path
    raw: dict[str, Any]
    setpoint: Array
    interpolated: Array
    position: Array
    speed: float

    @property
    def kp(self) -> float:
        """Gain of the firmware."""
        return float(self.raw['kp'])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('data', metavar='DATA', help='folder with xl330 and sts3250')
    parser.add_argument('--servo', choices=SERVOS, help='only this servo')
    parser.add_argument('--jobs', metavar='N', type=int, default=1, help='threads (default: 1)')
    add_json_option(parser)


def read_logs(folder: Path) -> list[ServoLog]:
    """Return the recordings in `folder` whose torque is never off."""
    logs = []
    for path in sorted(folder.glob('*.json.gz')):
        with gzip.open(path, 'rt', encoding='utf-8') as file:
            raw = json.load(file)
        rows = raw.pop('entries')
        if not all(row['torque_enable'] for row in rows):
            continue
        t = np.array([row['timestamp'] for row in rows])
        grid = np.arange(0.0, t[-1], DT)
        goal = np.array([row['goal_position'] for row in rows])
        held = goal[np.maximum(np.searchsorted(t, grid, side='right') - 1, 0)]
        position = np.interp(grid, t, [row['position'] for row in rows])
        logs.append(ServoLog(path, raw, held, np.interp(grid, t, goal), position,
                             float(rows[0].get('speed', 0.0))))
    return logs


def stated_model(servo: BenchServo, log: ServoLog) -> DriveModel:
    """Return the model file of `servo` with its guesses, and the exact weight of `log`."""
    mass, length = log.raw['mass'], log.raw['length']
    return DriveModel(
        transmission=Transmission('rigid'), motor_inertia=servo.inertia,
        arm_inertia=mass * length ** 2, viscous_friction=servo.viscous,
        coulomb_friction=servo.coulomb, friction_sharpness=100.0, position_gain=0.0,
        effects=({'id': 'gravity', 'G': -mass * GRAVITY[2] * length},), tolerance=0.5,
        controller=Controller(kp=log.kp * servo.error_gain * servo.torque,
                              torque_limit=servo.torque, tolerance=1.0))


def recording_of(log: ServoLog, model: DriveModel) -> UniformRecording:
    """Return the recording of `log` as diagnose reads it for `model`."""
    raw = read_signals(log.path, ReadOptions('bam_servo_pendulum'))
    readings = np.column_stack([raw['motor_position'], raw['arm_position']])
    return admitted(raw.stamp_ns, raw['motor_setpoint'], readings, None, str(log.path), model,
                    'the model')[0]


def run_error(log: ServoLog, model: DriveModel, servo: BenchServo) -> float:
    """
    Return the mean absolute error (rad) of one run of `model` from the setpoints of `log`.

    Args:
        log: recording on BAM's grid.
        model: of the drive; its servo takes the firmware's gain of the recording.
        servo: the servo.
    """
    own = stated_model(servo, log).controller
    state = np.array([log.position[0], log.position[0], log.speed, log.speed])
    run = Plant(replace(model, controller=own), state=state).run(log.setpoint, DT)
    return float(np.mean(np.abs(run.y[:, 1] - log.position)))


def measure(name: str, logs: list[ServoLog], jobs: int) -> dict[str, Any]:
    """
    Diagnose, fit and judge one servo; returns figures as plain data.

    Args:
        name: key of SERVOS.
        logs: its recordings.
        jobs: number of threads.
    """
    servo, gain, show = SERVOS[name], min(log.kp for log in logs), progress_line()
    train = [log for log in logs if log.kp == gain and log.raw['trajectory'] in TRAINED]
    test = [log for log in logs if log.kp != gain] or [log for log in logs if log not in train]
    if not train or not test:
        raise InputError(f'{logs[0].path.parent}: {len(train)} recordings to fit and {len(test)} '
                         f'to judge, expected some of {", ".join(TRAINED)} and some others')
    model = stated_model(servo, train[0])
    recordings = at_one_rate([recording_of(log, model) for log in train])
    show(f'{name}: diagnose')
    try:
        verdict = diagnose(recordings, model, jobs=jobs)
        kind, effect, confusable = verdict.verdict, verdict.effect, verdict.confusable
        parts = [finding.effect for finding in verdict.findings]
    except Undecided:
        kind, effect, confusable, parts = 'undecided', None, [], []
    show(f'{name}: fit model')
    starts = {'stated model, fitted': (model, ())}
    if parts:  # what the diagnosis closes its model with, named or nearest
        # The firmware's gain and limit are exact: what they are multiplied by is the motor's, kt.
        closed = replace(verdict.model.folded(), controller=model.controller)
        starts[f'with {"+".join(parts)}, fitted'] = (closed, tuple(
            e['id'] for e in closed.effects if e['id'] not in EXACT_OR_FITTED))
    models = {label: fit_nominal(recordings, start, (*FITTED, *ids), seconds=WHOLE).model
              for label, (start, ids) in starts.items()}
    label = list(models)[-1]
    errors = {key: {'fitted': [run_error(log, m, servo) for log in train],
                    'held out': [run_error(log, m, servo) for log in test]}
              for key, m in models.items()}
    if (spec := find_spec('bam')) and spec.origin:
        show(f'{name}: M6')
        errors.update(errors_of_m6(servo, train, test))
    show('')
    return {'servo': name, 'verdict': kind, 'effect': effect, 'confusable': confusable,
            'identified': list(parts),
            'effects': models[label].effects, 'judged': label,
            'held out': [log.path.name for log in test], 'errors': errors}


class _Unchanged(np.ndarray):
    """An array of parameters that a sum in place leaves as it is: BAM adds to its numbers."""

    def __iadd__(self, other: Any) -> Any:  # type: ignore[misc]
        return np.asarray(self) + other


def errors_of_m6(servo: BenchServo, train: list[ServoLog], test: list[ServoLog]) -> dict[str, Any]:
    """
    Return the errors (rad) of BAM's M6: published, and fitted to `train` by BAM's own simulator.

    Args:
        servo: the servo.
        train: recordings that are fitted.
        test: recordings that are judged.
    """
    from bam.actuators import actuators
    from bam.model import load_model as published_model, models
    from bam.simulate import Simulator

    def batch(logs: list[ServoLog], members: int) -> dict[str, Any]:
        """Return `logs` side by side as BAM takes them, for `members`; longer ones end early."""
        n = min(len(log.position) for log in logs)
        rows = [{'goal_position': np.array([log.interpolated[k] for log in logs]),
                 'torque_enable': True} for k in range(n)]
        rows[0].update(position=np.tile([log.position[0] for log in logs], (members, 1)),
                       speed=np.tile([log.speed for log in logs], (members, 1)))
        return {'dt': DT, 'entries': rows, 'arm_mass': 0.0, **{
            key: np.array([log.raw[key] for log in logs]) for key in (
                'kp', 'vin', 'mass', 'length')}}

    def errors(model: Any, logs: list[ServoLog], members: int = 1) -> Array:
        """Return the errors [S, L] of `members` of a population in each of `logs`."""
        simulator = Simulator(model)
        run = np.array(simulator.rollout_log(batch(logs, members), simulate_control=True)[0])
        measured = np.array([log.position[:len(run)] for log in logs]).T
        return np.mean(np.abs(run - measured[:, None]), axis=0)
    out = {}
    if servo.published:
        model = published_model(motor_name=servo.actuator, model='m6')
        out['M6, published'] = {part: errors(model, logs)[0].tolist() for part, logs in (
            ('fitted', train), ('held out', test))}
    model = models['m6']()
    model.set_actuator(actuators[servo.actuator]())
    free = [p for p in model.get_parameters().values() if p.optimize]

    def objective(values: Array) -> Array:
        """Return the mean error of each member [S] with `values` [P, S]."""
        for parameter, value in zip(free, values):
            parameter.value = value[:, None].view(_Unchanged)
        return errors(model, train, values.shape[1]).mean(axis=1)
    best = differential_evolution(
        objective, [(p.min, p.max) for p in free], maxiter=GENERATIONS, popsize=POPULATION, seed=0,
        tol=1e-6, polish=False, vectorized=True, updating='deferred')
    for parameter, value in zip(free, best.x):
        parameter.value = value
    out['M6, fitted'] = {part: errors(model, logs)[0].tolist() for part, logs in (
        ('fitted', train), ('held out', test))}
    return out


def table(results: list[dict[str, Any]]) -> list[str]:
    """Return the `results` of measure() as lines."""
    lines = []
    for data in results:
        nearest = f', nearest {"+".join(data["identified"])}' if data['identified'] else ''
        named = ' or '.join([data['effect'], *data['confusable']]) if data['effect'] else (
            data['verdict'] + nearest)
        lines += [f'{data["servo"]}: {named}', '',
                  f'{"mean absolute error, mrad":<28}{"fitted":>9}{"held out":>10}  each']
        for label, parts in data['errors'].items():
            each = ' '.join(f'{1e3 * error:.1f}' for error in parts['held out'])
            lines.append(f'{label:<28}{1e3 * np.mean(parts["fitted"]):9.1f}'
                         f'{1e3 * np.mean(parts["held out"]):10.1f}  {each}')
        lines.append('')
    return lines


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--jobs', args.jobs)
    results, bars = [], BarTable()
    for name in [args.servo] if args.servo else SERVOS:
        logs = read_logs(Path(args.data) / name)
        if not logs:
            raise InputError(f'{Path(args.data) / name}: no *.json.gz with the torque on, '
                             'expected recordings of Better Actuator Models')
        try:
            data = measure(name, logs, args.jobs)
        except InputError as error:
            if args.servo:
                raise
            bars.skip(f'{name}: held out, mrad', str(error))
            continue
        results.append(data)
        own = 1e3 * float(np.mean(data['errors'][data['judged']]['held out']))
        bars.check(f'{name}: an effect is named', data['effect'] or data['verdict'], 'effect',
                   data['verdict'] == 'effect')
        of_m6 = {k: v for k, v in data['errors'].items() if k.startswith('M6')}
        for label, parts in of_m6.items():
            bars.judge(f'{name}: held out, mrad, against {label}', own,
                       high=1e3 * float(np.mean(parts['held out'])))
        if not of_m6:
            bars.skip(f'{name}: held out, mrad, against M6', 'better-actuator-models is not '
                      'installed', own)
    return finish({'servos': results, 'bars': bars.rows},
                  '\n'.join([*table(results), *bar_lines(bars.rows)]), args.json)
