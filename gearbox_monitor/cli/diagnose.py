# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Identify the unmodelled effect behind the sim-to-real gap: its place, its size, what it closes.

The model is run freely over windows of 1 s of the recording. Its residual against the encoders is
the gap. Every effect of the library (docs/effects.md) is fitted on the first windows and tested on
the last ones. Only torque, positions and the model file are read, nothing else in the recording.
Record 10 to 14 s at 1 kHz in which the drive reverses often and loads both flanks.

BAG is a bag, or a CSV file with the columns t,u,motor,arm[,arm_torque] (s, N m, rad, N m, all on
the arm side; u may be a current, see torque_constant in the model file). Several recordings of one
drive are diagnosed together. arm_torque, or effort[arm] in the bag, is the known load if the model
file has arm_load: measured. One of motor and arm is enough: leave the other column out. With a
controller in the model file, setpoint (rad) takes the place of u. Rates from 30 Hz to 4 kHz.

usage examples:
  gearbox_monitor diagnose BAG --model drive.yaml
  gearbox_monitor diagnose BAG --model drive.yaml --out found     # and the model that closes it,
                                                                  # and a page about all of it
  gearbox_monitor diagnose BAG --model drive.yaml --validate BAG2 --json verdict.json
  gearbox_monitor diagnose run1.csv run2.csv --model drive.yaml --exclude lugre viscous_drift
  gearbox_monitor diagnose BAG --model drive.yaml --json - | jq .effect
  gearbox_monitor diagnose BAG --model robot.xml --joint elbow --simulator my_arm:simulate
  gearbox_monitor diagnose LOG --model robot.urdf --reference healthy.csv    # all joints at once
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
import sys
from typing import Any, TYPE_CHECKING, TypeAlias

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.cli import diagnose_robot
from gearbox_monitor.cli.diagnose_report import text
from gearbox_monitor.cli.drive_recordings import (
    add_recording_arguments, load_recordings, written_options)
from gearbox_monitor.cli.options import expect_new_files, ids_in, JSON_FILE_HELP, write_files
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.cli.robot_inputs import add_robot_arguments
from gearbox_monitor.diagnosis.joint.diagnose import chosen_ids
from gearbox_monitor.diagnosis.joint.findings import NONE
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.errors import expect_whole, has_matplotlib, InputError, installed_by
from gearbox_monitor.files.plain_data import dump, plain
from gearbox_monitor.files.yaml_files import model_text
from gearbox_monitor.kernels.jit import COMPILED
from gearbox_monitor.library.identify import diagnose, expect_ids
from gearbox_monitor.library.simulator_file import export_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report.diagnosis_evidence import gather
from gearbox_monitor.report.diagnosis_page import diagnosis_page, PageContext
from gearbox_monitor.report.suggestion import suggestion
from gearbox_monitor.report.summary import summary
from gearbox_monitor.report.words import UserFiles
from gearbox_monitor.ros.child_processes import cores
from gearbox_monitor.signals.recording import UniformRecording
from gearbox_monitor.simulators.mjcf import refused
from gearbox_monitor.simulators.user_simulator import confirmation, user_simulator, UserSimulator

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN = ('report.html', 'overlay.png', 'where.png', 'ranking.png')
CLOSED = 'drive.closed.yaml'
OF_RECORDINGS = ('topic', 'motor_joint', 'arm_joint', 'setpoint_joint', 'repeated')
OF_JOINTS = ('joint', 'model_arm_joint', 'keyframe', 'actuator', 'root')
Drawn: TypeAlias = Mapping[str, 'str | Figure']  # {file of --out: HTML or picture}


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_recording_arguments(parser)
    add_robot_arguments(parser, values=False)
    parser.add_argument('--validate', metavar='BAG2',
                        help='second recording of the drive, to test the result on')
    parser.add_argument('--out', metavar='DIR',
                        help='write verdict.json, report.html, pictures and drive.closed.yaml: '
                        'the model with what was identified')
    parser.add_argument('--json', metavar='FILE',
                        help='write the verdict as JSON' + JSON_FILE_HELP)
    parser.add_argument('--exclude', metavar='ID', nargs='+', default=[],
                        help='effects to leave out; a gap that only they explain is then unknown')
    parser.add_argument('--only', metavar='ID', nargs='+', help='effects to try, and no others')
    parser.add_argument('--simulator', metavar='MODULE:FUNCTION',
                        help='repeat nominal and closed model in your simulator, see '
                        'docs/simulator.md')
    parser.add_argument('--seed', metavar='N', type=int, default=0,
                        help='seed of the intervals (default: 0); same seed, same answer')
    parser.add_argument('--jobs', metavar='N', type=int, default=cores(),
                        help='threads (default: one per core); does not change the answer')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_whole(args.jobs, '--jobs', 1)
    expect_whole(args.seed, '--seed')
    if diagnose_robot.is_robot(args):
        return diagnose_robot.run(args)
    only, exclude = ids_in(args.only or ()) or None, ids_in(args.exclude)
    expect_ids('--only', only)
    expect_ids('--exclude', exclude)
    chosen_ids(only, exclude)  # one at least remains
    expect_new_files(args.out, (*DRAWN, 'verdict.json', CLOSED), args.json)
    model, recordings, validate, notes = load_recordings(args, weigh=True)
    if not COMPILED:
        print('diagnose: without numba this takes about a hundred times longer', file=sys.stderr)
    simulator = _simulator(args.simulator, recordings, model) if args.simulator else None
    with progress_bar('diagnose') as progress:
        verdict = diagnose(recordings, model, validate=validate, only=only, exclude=exclude,
                           seed=args.seed, jobs=args.jobs, progress=progress)
    data = plain(verdict.to_dict())
    data['warnings'] = [*notes, *(data.get('warnings') or [])]
    data = {'summary': summary(data, model.axis), **data}
    closed = verdict.model
    if simulator is not None:
        sigma = np.array([1.0 if s is None else s for s in data['sigma']])
        try:
            with progress_bar(simulator.name) as progress:
                data['simulator'] = plain(confirmation(
                    simulator, verdict.basis.recordings[verdict.basis.widest], (model, closed),
                    sigma, progress))
        except InputError as error:  # the diagnosis stands without it
            data['warnings'].append(str(error))
    # Motions of a torque are found, for model files.
    command = [] if args.joint or model.controller else suggestion(
        data, recordings, args.model, args.out)
    changes = _changes(args, closed, data) if verdict.findings else []
    files = user_files(args)
    drawn: Drawn = {}
    if args.out:
        drawn = draw(verdict, data, recordings, model, PageContext(files, command, changes))
    written = write(args, data, closed, drawn)
    print(dump(data) if args.json == '-' else
          text(data, recordings, model, written, files, command, changes))
    return 0 if verdict.verdict == NONE else 1


def _simulator(name: str, recordings: Sequence[UniformRecording], model: DriveModel
               ) -> UserSimulator:
    """Return the user's simulator `name` after a try. Raises InputError."""
    if model.controller is not None or model.driven_by == 'position':
        raise InputError(f'--simulator {name}: takes torques, expected a model without controller '
                         'and with driven_by: torque')
    simulator = user_simulator(name)
    simulator.probe(recordings[0], model)
    return simulator


def user_files(args: Namespace) -> UserFiles:
    """Return the UserFiles of the options `args`, as further commands have them."""
    closed = str(Path(args.out) / CLOSED) if args.out else ''
    reading = written_options(args, OF_RECORDINGS)
    return UserFiles(args.model, args.bag, reading, closed, args.validate,
                     args.model if args.joint else '', written_options(args, OF_JOINTS),
                     args.values)


def _changes(args: Namespace, closed: DriveModel, data: dict[str, Any]) -> list[str]:
    """
    Return what the closed model changes in the simulator's file --model, in words.

    It goes into `data` as well, as `file_changes`; a file that cannot take it leaves a warning.
    """
    if args.joint is None:
        return []
    try:
        to = 'urdf' if Path(args.model).suffix.lower() == '.urdf' else 'mjcf'
        patch = export_model(closed, to, args.model, joint=args.joint,
                             arm_joint=args.model_arm_joint, keyframe=args.keyframe,
                             actuator=args.actuator, root=args.root).patch
    except InputError as error:
        data['warnings'].append(f'not in the file of the simulator: {error}')
        return []
    data['file_changes'] = [change._asdict() for change in patch.changes]
    return [*(f'{Path(args.model).name}: {change.words}' for change in patch.changes),
            *(f'not in it: {row.id}: {row.words}' for row in refused(patch.exported))]


def draw(verdict: Verdict, data: Mapping[str, Any],
         recordings: Sequence[UniformRecording], model: DriveModel,
         context: PageContext) -> 'dict[str, str | Figure]':
    """
    Return page and pictures of a diagnosis.

    Args:
        verdict: with what the search found.
        data: the verdict as plain data.
        recordings: those it is about.
        model: the nominal model.
        context: what accompanies the verdict on its page.

    Returns:
        {file of --out: HTML or Figure}.

    """
    evidence = gather(verdict, model)
    title = data['summary']
    drawn: dict[str, str | Figure] = {
        'report.html': diagnosis_page(data, evidence, recordings, context)}
    if not has_matplotlib():
        print('diagnose: no pictures, matplotlib is not installed, expected '
              f'{installed_by("pictures")}', file=sys.stderr)
        return drawn
    from gearbox_monitor.report import overlay_plot
    drawn |= {
        'overlay.png': overlay_plot.windows_figure(evidence.overlay, evidence.windows, title,
                                                   on_axis('rad', model.axis)),
        'where.png': overlay_plot.maps_figure(evidence, title)}
    if data['gains']:
        drawn['ranking.png'] = overlay_plot.ranking_figure(data['gains'], data['effect'], title)
    return drawn


def write(args: Namespace, data: Mapping[str, Any], closed: DriveModel | None,
          drawn: Drawn) -> list[Path]:
    """
    Write all files or none; return their paths.

    Args:
        args: options of the command.
        data: the verdict as plain data.
        closed: model with the effect, or None.
        drawn: page and pictures.

    Raises:
        InputError: a file cannot be written.

    """
    contents: dict[Path, str | Figure] = {}
    if args.json and args.json != '-':
        contents[Path(args.json)] = dump(data) + '\n'
    if args.out:
        contents[Path(args.out, 'verdict.json')] = dump(data) + '\n'
        if closed is not None:
            contents[Path(args.out, CLOSED)] = model_text(closed, [
                f'Written by gearbox_monitor {__version__} diagnose from '
                f'{", ".join(args.bag)} and {args.model}.', data['summary']])
        contents |= {Path(args.out, name): content for name, content in drawn.items()}
    return write_files(contents, args.out)
