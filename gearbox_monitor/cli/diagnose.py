# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Identify the unmodelled effect behind the sim-to-real gap: its place, its size, its share.

The model is run freely over windows of 1 s of the recording. Its residual against the encoders is
the gap. Every effect of the library (docs/effects.md) is fitted to all of it; --validate tests the
answer on another recording. Only torque, positions and the model file are read, nothing else in
the recording. Record 10 to 14 s at 1 kHz in which the drive reverses often and loads both flanks.

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
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
import time
from typing import Any

import numpy as np

from gearbox_monitor.cli.options import (
    ids_in, joint_of, load_recordings, names_of, reading_of_robot, refuse, robot_of,
    robot_options, show, write_folder, written_options)
from gearbox_monitor.diagnosis.hypothesis import NONE, UNDECIDED
from gearbox_monitor.diagnosis.joint import windows
from gearbox_monitor.diagnosis.joint.diagnose import chosen_ids
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.errors import expect_whole, InputError
from gearbox_monitor.files.knowledge_file import save_knowledge, SUFFIX
from gearbox_monitor.files.user_files import dump, expect_new_file, plain
from gearbox_monitor.library import robot as library
from gearbox_monitor.library.identify import diagnose, Diagnosis
from gearbox_monitor.library.progress import progress_bar
from gearbox_monitor.library.robot import robot_effects
from gearbox_monitor.library.simulator_file import export_model, written_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.diagnosis_page import diagnosis_page
from gearbox_monitor.report.sentences import entries
from gearbox_monitor.report.words import counted, headline, LABEL, verdict_text
from gearbox_monitor.robot.description import SUFFIXES
from gearbox_monitor.ros.middleware import cores
from gearbox_monitor.signals.uniform import UniformRecording
from gearbox_monitor.simulators.user_simulator import confirmation, user_simulator, UserSimulator

PAGE, VERDICT, CLOSED = 'report.html', 'verdict.json', 'drive.closed.yaml'
OF_RECORDINGS = ('topic', 'motor_joint', 'arm_joint', 'setpoint_joint')
CORES = cores()
OF_JOINTS = ('joint', 'model_arm_joint', 'keyframe', 'actuator', 'root')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_whole(args.jobs, '--jobs', 1)
    expect_whole(args.seed, '--seed')
    robot = is_robot(args)
    for attribute, reason in OF_ONE_JOINT.items() if robot else ():
        refuse(args, [attribute], f'of one joint, expected --joint with it ({reason})')
    only, exclude = ids_in(args.only or ()) or None, ids_in(args.exclude or ())
    chosen_ids(only, exclude, ('--only', '--exclude'), sorted(robot_effects()) if robot else None)
    expect_new_file(args.out)
    diagnosis, data = (_of_robot if robot else _of_drive)(
        args, {'only': only, 'exclude': exclude})
    _show(args, data, _write(args, diagnosis, data) if args.out else [])
    return 1 if data.get('readings') else {NONE: 0, UNDECIDED: 3}.get(diagnosis.kind, 1)


def _of_drive(args: Namespace, chosen: dict[str, Any]) -> tuple[Diagnosis, dict[str, Any]]:
    """Return (the diagnosis of a drive, its data with what the command adds)."""
    model, recordings, validate, notes = load_recordings(args, weigh=True)
    simulator = _user_simulator(args.simulator, recordings, model) if args.simulator else None
    diagnosis = diagnose(recordings, model, validate=validate, **chosen, seed=args.seed,
                         jobs=args.jobs)
    verdict, data = diagnosis.verdict, dict(diagnosis.data)
    assert isinstance(verdict, Verdict)
    data['warnings'] = [*notes, *(data.get('warnings') or [])]
    if verdict.findings and args.joint is not None:
        _put_file(args, verdict, validate, data)
    data = {**data, 'summary': headline(data), **_of_command(args)}
    if simulator is not None:
        basis, sigma = verdict.basis, np.array([1.0 if s is None else s for s in data['sigma']])
        try:
            with progress_bar(simulator.name) as progress:
                data['simulator'] = plain(confirmation(
                    simulator, basis.data.recordings[basis.widest], (model, verdict.model),
                    sigma, progress))
        except InputError as error:  # the diagnosis is complete without it
            data['warnings'].append(str(error))
    return diagnosis, data


def _of_robot(args: Namespace, chosen: dict[str, Any]) -> tuple[Diagnosis, dict[str, Any]]:
    """Return (the diagnosis of a robot, its data with what the command adds)."""
    began, robot = time.process_time(), robot_of(args)
    diagnosis = diagnose(args.bag, robot, reference=args.reference or None, **chosen,
                         recorded=names_of(args), reading=reading_of_robot(args),
                         topic=args.topic)
    return diagnosis, {**diagnosis.data, 'options': robot_options(args),
                       'cpu_s': round(time.process_time() - began, 2)}


def _write(args: Namespace, diagnosis: Diagnosis, data: dict[str, Any]) -> list[Path]:
    """Write verdict, page and the model with the findings into the new folder --out."""
    files = dict[str, str]()
    if diagnosis.file_text is not None:
        path = Path(args.model)
        name = f'{path.stem}.closed{path.suffix}' if is_robot(args) else CLOSED
        files[name] = diagnosis.file_text
        data['closed'] = str(Path(args.out) / name)
    return write_folder(args.out, {
        VERDICT: dump(data) + '\n', PAGE: diagnosis_page(data, diagnosis.context()), **files})


def _show(args: Namespace, data: dict[str, Any], written: Sequence[Path]) -> None:
    """Print the verdict `data` and which files were `written`, or write them as JSON."""
    names = ', '.join(path.name for path in written)
    show(args, data, lambda: '\n'.join([verdict_text(data, args.verbose), *entries(
        [('written', f'{args.out}: {names}')] if written else [], LABEL)]))


def _user_simulator(name: str, recordings: Sequence[UniformRecording], model: DriveModel
                    ) -> UserSimulator:
    """Return the user's simulator `name` after a try. Raises InputError."""
    if model.controller is not None or model.driven_by == 'position':
        raise InputError(f'--simulator {name}: takes torques, expected a model without controller '
                         'and with driven_by: torque')
    simulator = user_simulator(name)
    simulator.probe(recordings[0], model)
    return simulator


def _of_command(args: Namespace) -> dict[str, Any]:
    """Return what data of a verdict tell of the command with `args`, for further commands."""
    joint = written_options(args, OF_JOINTS)
    return {'logs': args.bag, 'model': args.model, 'joint': joint, 'options': ' '.join(filter(
        None, (joint, written_options(args, ('values', *OF_RECORDINGS))))), 'closed': None}


def _put_file(args: Namespace, verdict: Verdict, validation: UniformRecording | None,
              data: dict[str, Any]) -> None:
    """
    Put into `data` what the closed model changes in the simulator's file --model.

    The gap after becomes that of the written file; one that cannot take it leaves a warning.
    """
    closed, basis = verdict.model, verdict.basis
    try:
        to = 'urdf' if Path(args.model).suffix.lower() == '.urdf' else 'mjcf'
        file = export_model(closed, to, args.model, **joint_of(args))
        written = written_model(file, closed, **joint_of(args))
    except InputError as error:
        data['warnings'].append(f'not in the file of the simulator: {error}')
        return
    data |= plain(windows.file_closure(
        basis.data.recordings, written, basis.data.level, basis.compared.published,
        basis.compared.closed, args.seed))
    if validation is not None:
        data['validation'] = plain(windows.validate(
            validation, basis.model, written, basis.data.level))
    data['changes'] = file.diff.splitlines()
    data['lacking'] = [f'{row.id}: {row.words}' for row in file.lacking]


# Options of one joint: why a whole robot has no use for each.
OF_ONE_JOINT = {
    'model_arm_joint': 'a robot has one encoder per joint',
    'keyframe': 'the log says where all joints are',
    'actuator': 'the position actuators of all joints are read',
    'motor_joint': 'map a name with --recorded NAME=LOGNAME',
    'arm_joint': 'map a name with --recorded NAME=LOGNAME',
    'setpoint_joint': 'setpoints are those of all joints: setpoint_NAME or joint_setpoints',
    'validate': 'give a second log to a command of its own',
    'simulator': 'with an MJCF, MuJoCo runs it'}


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of diagnose are about a whole robot."""
    if args.joint is None and (args.reference or Path(args.model).suffix.lower() in SUFFIXES):
        return True
    refuse(args, ('reference', 'recorded', 'prefix', 'convention'),
           'of a whole robot or with a --reference, expected no --joint')
    return False


def learn(args: Namespace) -> int:
    """
    Learn a healthy robot from its logs: friction, rotors, ripple, how much healthy parts differ.

    The file that it writes is a reference for diagnose: a comparison then takes about a second.
    Record 30 s or more of a motion like the one to compare, better two motions, without a load.

    usage examples:
      gearbox_monitor learn june1 june2 --model robot.xml --out robot.knowledge
      gearbox_monitor learn log.csv --model arm.urdf --values values.yaml --out arm.knowledge
      gearbox_monitor diagnose today --model robot.xml --reference robot.knowledge
    """
    if not args.out.endswith(SUFFIX):
        raise InputError(f'--out: {args.out}, expected a name that ends with {SUFFIX}')
    learnt = [path for path in args.log if path.endswith(SUFFIX)]
    if learnt:
        raise InputError(f'{", ".join(learnt)}: written by learn, expected logs')
    expect_new_file(args.out)
    knowledge, notes = library.learn(args.log, robot_of(args), topic=args.topic,
                                   recorded=names_of(args), reading=reading_of_robot(args))
    save_knowledge(args.out, knowledge)
    rows = {joint: (float(d), [name for j, name in knowledge.shapes if j == i])
            for i, (joint, d) in enumerate(zip(knowledge.joints, knowledge.dispersion))}
    data = {'out': args.out, 'seconds': knowledge.seconds, 'parts': knowledge.parts,
            'kind': knowledge.kind, 'rate': knowledge.rate, 'warnings': notes,
            'joints': {joint: {'dispersion': d, 'shapes': names}
                       for joint, (d, names) in rows.items()}}
    show(args, data, lambda: '\n'.join([
        f'{args.out}: {knowledge.seconds:.0f} s of {counted(len(args.log), "log")}, '
        f'{knowledge.parts} parts compared', *(f'  note: {note}' for note in notes),
        *(f'  {joint}: parts differ by {dispersion ** 0.5:.1f} times the noise; '
          f'{", ".join(names) or "no further shape"}'
          for joint, (dispersion, names) in rows.items())]))
    return 0
