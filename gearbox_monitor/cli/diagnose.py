# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Identify the unmodelled effect behind the sim-to-real gap: its place, its size, its share.

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
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
import time
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.cli.options import (
    entries, ids_in, joint_of, labelled, load_recordings, names_of, reading_of_robot, refuse,
    robot_of, robot_options, show, wrapped, write_folder, written_options)
from gearbox_monitor.diagnosis.hypothesis import NONE, UNDECIDED
from gearbox_monitor.diagnosis.joint import windows
from gearbox_monitor.diagnosis.joint.diagnose import chosen_ids
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.errors import expect_whole, InputError
from gearbox_monitor.files.knowledge_file import save_knowledge, SUFFIX
from gearbox_monitor.files.user_files import dump, expect_new_file, model_text, plain
from gearbox_monitor.library.identify import diagnose
from gearbox_monitor.library.progress import progress_bar
from gearbox_monitor.library.robot import (
    diagnose_robot, learn_robot, robot_effects, RobotDiagnosis)
from gearbox_monitor.library.simulator_file import export_model, written_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import number, on_axis, percent, Quantity, Said, said
from gearbox_monitor.report.diagnosis_page import diagnosis_page, gather, shows_place
from gearbox_monitor.report.robot_pages import robot_gap_page
from gearbox_monitor.report.robot_words import robot_text
from gearbox_monitor.report.sentences import summary
from gearbox_monitor.report.words import (
    counted, NAMING, next_steps, NO_FILES, NOTHING, place_text, torque_map_of, undefined, unit_of,
    UserFiles, value_rows)
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
    if is_robot(args):
        return run_robot(args)
    only, exclude = ids_in(args.only or ()) or None, ids_in(args.exclude)
    chosen_ids(only, exclude, ('--only', '--exclude'))
    expect_new_file(args.out)
    model, recordings, validate, notes = load_recordings(args, weigh=True)
    simulator = _user_simulator(args.simulator, recordings, model) if args.simulator else None
    verdict = diagnose(recordings, model, validate=validate, only=only, exclude=exclude,
                       seed=args.seed, jobs=args.jobs)
    data = plain(verdict.to_dict())
    data['warnings'] = [*notes, *(data.get('warnings') or [])]
    closed, basis = verdict.model, verdict.basis
    changes = _changes(args, verdict, validate, data) if verdict.findings else []
    data = {'summary': summary(data, model.axis), **data}
    if simulator is not None:
        sigma = np.array([1.0 if s is None else s for s in data['sigma']])
        try:
            with progress_bar(simulator.name) as progress:
                data['simulator'] = plain(confirmation(
                    simulator, basis.data.recordings[basis.widest], (model, closed),
                    sigma, progress))
        except InputError as error:  # the diagnosis is complete without it
            data['warnings'].append(str(error))
    files = replace(user_files(args), changes=changes)
    written = [] if not args.out else write_folder(args.out, {
        VERDICT: dump(data) + '\n',
        PAGE: diagnosis_page(data, gather(verdict, model), recordings, files),
        CLOSED: model_text(closed, [
            f'Written by gearbox_monitor {__version__} diagnose from {", ".join(args.bag)} and '
            f'{args.model}.', data['summary']])})
    show(args, data, lambda: text(data, recordings, model, written, files, args.verbose))
    return {NONE: 0, UNDECIDED: 3}.get(verdict.verdict, 1)


def _user_simulator(name: str, recordings: Sequence[UniformRecording], model: DriveModel
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


def _changes(args: Namespace, verdict: Verdict, validation: UniformRecording | None,
             data: dict[str, Any]) -> list[str]:
    """
    Return what the closed model changes in the simulator's file --model, in words.

    It goes into `data` as well, as `file_changes` and `lacking`, and the gap after becomes that of
    the written file; a file that cannot take it leaves a warning.
    """
    if args.joint is None:
        return []
    closed, basis = verdict.model, verdict.basis
    try:
        to = 'urdf' if Path(args.model).suffix.lower() == '.urdf' else 'mjcf'
        file = export_model(closed, to, args.model, **joint_of(args))
        written = written_model(file, closed, **joint_of(args))
    except InputError as error:
        data['warnings'].append(f'not in the file of the simulator: {error}')
        return []
    data |= plain(windows.file_closure(
        basis.data.recordings, written, basis.data.level, basis.compared.published,
        basis.compared.closed, args.seed))
    if validation is not None:
        data['validation'] = plain(windows.validate(
            validation, basis.model, written, basis.data.level))
    data['file_changes'] = [change._asdict() for change in file.patch.changes]
    data['lacking'] = [f'{row.id}: {row.words}' for row in file.lacking]
    return [*(f'{Path(args.model).name}: {change.words}' for change in file.patch.changes),
            *(f'not in it: {row}' for row in data['lacking'])]


VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a verdict
Rows: TypeAlias = Iterator[Said]  # of a line, whose label is the name of the code
LABEL = 15
RANKED = 8  # lines of the ranking
NEXT = 1    # steps that are printed without -v


def text(data: VerdictData, recordings: Sequence[UniformRecording], model: DriveModel,
         written: Sequence[Path] = (), files: UserFiles = NO_FILES, verbose: bool = False) -> str:
    """
    Return a verdict as lines for people, at most 80 columns.

    Args:
        data: the verdict as plain data.
        recordings: those it is about.
        model: the nominal model.
        written: files.
        files: of the user.
        verbose: whether all that is known is printed, not only answer, values and next step.

    """
    says = [*_gap(data), *_parameters(data, model.axis)]
    if verbose:
        says += [*_ranking(data), *_where(data, recordings, model), *_nominal(data, model)]
    says += [*_simulator(data), *_validation(data, files.validated, on_axis('rad', model.axis))]
    rows = [*labelled(says, model.axis), *_notes(data, verbose), *_changed(data, files, verbose),
            *(('next', advice) for advice in next_steps(data, files, model.axis)[
                 :None if verbose else NEXT]),
            *(('written', words) for words in _written(written))]
    return '\n'.join([*wrapped(data['summary']), *entries(rows, LABEL)])


def _notes(data: VerdictData, verbose: bool) -> Iterator[tuple[str, str]]:
    """Yield the notes, unless `verbose` the first one and how many follow it."""
    notes = list(data.get('warnings', ()))
    if len(notes) > 1 and not verbose:
        notes = [f'{notes[0]} (-v prints {counted(len(notes) - 1, "more note")})']
    return (('note', note) for note in notes)


def _changed(data: VerdictData, files: UserFiles, verbose: bool) -> Iterator[tuple[str, str]]:
    """Yield the changes of a simulator's file, unless `verbose` their number, and the rest."""
    rows, count = list(files.changes), len(data.get('file_changes') or ())
    if count and not verbose:
        rows[:count] = [f'{counted(count, "change")} of {Path(files.robot).name}: -v prints them']
    return (('' if k else 'change', row) for k, row in enumerate(rows))


def _written(written: Sequence[Path]) -> Iterator[str]:
    """Yield the files `written`, all of a folder together."""
    for folder in sorted({path.parent for path in written}):
        names = [path.name for path in written if path.parent == folder]
        yield str(folder / names[0]) if len(names) == 1 else f'{folder}: {", ".join(names)}'


def _gap(data: VerdictData) -> Rows:
    """Yield the line on the misfit before and after."""
    share, closed = data.get('closed_fraction'), tuple[Said, ...]()
    if data['verdict'] not in NOTHING:
        closed = (said('closed_undefined', why=undefined(data)) if share is None else
                  said('closed_share', share=percent(share)),)
    yield said('misfit_row', before=number(data['gap_before']), after=number(data['gap_after']),
               closed=closed)


def _parameters(data: VerdictData, axis: str) -> Rows:
    for row in value_rows(data, axis):
        yield said('value_row', effect=row.effect, value=row)
    for name, ranges in (data.get('between_recordings') or {}).items():
        for parameter, part in ranges.items():
            yield said('between_row', name=name, parameter=parameter,
                       count=len(part['recordings']), **{key: number(part[key]) for key in (
                           'mean', 'low', 'high', 'between')})
    for burst in data.get('bursts') or ():
        yield said('burst_row', begin=burst['t0'], end=burst['t0'] + burst['duration'],
                   size=number(burst['amplitude'], on_axis('N m', axis)))
    for slip in data.get('slips') or ():
        yield said('slip_row', begin=slip['t0'],
                   size=Quantity(slip['size'], slip['std'], on_axis('rad', axis)))
    for words in data.get('equivalent') or ():
        yield said('same_row', words=words)
    torque_map = torque_map_of(data)
    if torque_map is not None:
        place, knots = torque_map
        yield said('torque_map_row', place=place, unit=on_axis('N m', axis), knots=', '.join(
            f'{x}: {torque} ± {error}' for x, torque, error in knots))


def _ranking(data: VerdictData) -> Rows:
    gains: Mapping[str, float] = data.get('gains') or {}
    ranking = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED]
    for place, name in enumerate(ranking, 1):
        yield said('ranking_row', place=place, name=name, gain=gains[name])
    if ranking:
        yield said('gain_row')
    if data.get('confusable') and data['verdict'] in NAMING:
        yield said('rivals_row', names=', '.join(data['confusable']))


def _where(data: VerdictData, recordings: Sequence[UniformRecording], model: DriveModel) -> Rows:
    if data['verdict'] in NOTHING:
        return
    if not any(shows_place(recording, model) for recording in recordings):
        yield said('no_where_row')
        return
    for place, part in data['where']['places'].items():
        yield said('where_row', place=place_text(place), share=percent(part['explained']))


def _nominal(data: VerdictData, model: DriveModel) -> Rows:
    shifts = data.get('nominal_shift')
    if shifts:
        yield said('nominal_row', values=', '.join(
            f'{name} {number(data["nominal"][name])} ({shift:+.1f})'
            for name, shift in shifts.items()))
    if shifts and model.tolerance and data['process_torque'] is not None:
        yield said('noise_row', noise=number(data['process_torque'], on_axis('N m', model.axis)))


def _closed(code: str, name: str | None, part: Mapping[str, Any]) -> Said:
    return said(code, name=name, before=number(part.get('gap_before')),
                after=number(part.get('gap_after')), share=percent(part.get('closed_fraction')))


def _simulator(data: VerdictData) -> Rows:
    theirs = data.get('simulator')
    if not theirs:
        return
    yield _closed('simulator_row', theirs['name'], theirs)
    yield _closed('simulator_row', 'this package', theirs['here'])
    if theirs['passed']:
        yield said('passed_row', effects=', '.join(
            f'{name} as {way}' for name, way in theirs['passed'].items()))
    if theirs['values']:
        yield said('values_row', values=', '.join(
            f'{name} {key} = {Quantity(value, deviation)}'
            for name, values in theirs['values'].items()
            for key, (value, deviation) in values.items()))


def _validation(data: VerdictData, validated: str | None, unit: str) -> Rows:
    result = data.get('validation')
    if not result:
        return
    yield _closed('validation_row', validated, result)
    if run := result.get('free_run'):
        yield said('free_run_row', seconds=run['seconds'], units=', '.join(dict.fromkeys(
            unit_of(name, unit) for name in run['before'])), **{when: ', '.join(
                f'{name} {number(value)}' for name, value in run[when].items())
                for when in ('before', 'after')})


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


def run_robot(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for attribute, reason in OF_ONE_JOINT.items():
        refuse(args, [attribute], f'of one joint, expected --joint with it ({reason})')
    named, exclude = ids_in(args.only or ()), ids_in(args.exclude or ())
    effects = chosen_ids(named or None, exclude, ('--only', '--exclude'), sorted(
        robot_effects())) if named or exclude else None
    expect_new_file(args.out)
    began = time.process_time()
    diagnosis = diagnose_robot(
        args.bag, robot_of(args), reference=args.reference or None, effects=effects,
        recorded=names_of(args), reading=reading_of_robot(args), topic=args.topic)
    data = {**diagnosis.data, 'options': robot_options(args),
            'cpu_s': round(time.process_time() - began, 2)}
    if args.out:
        _write(args, diagnosis, data)
    show(args, data, lambda: robot_text(data))
    if data['readings']:
        return 1
    return {NONE: 0, UNDECIDED: 3}.get(data['verdict'], 1)


def _write(args: Namespace, diagnosis: RobotDiagnosis, data: dict[str, Any]) -> None:
    """Write verdict, page and the model with the findings into the new folder --out."""
    path, files = diagnosis.robot.file.path, dict[str, str]()
    if diagnosis.closed is not None:
        files[name := f'{path.stem}.closed{path.suffix}'] = diagnosis.closed
        data['closed'] = f'{args.out}/{name}'
    if diagnosis.lacking:
        data['warnings'].append('not in the file that closes the gap: '
                                + ', '.join(diagnosis.lacking))
    write_folder(args.out, {VERDICT: dump(data) + '\n',
                            PAGE: robot_gap_page(data, diagnosis.context()), **files})


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
    knowledge, notes = learn_robot(args.log, robot_of(args), topic=args.topic,
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
