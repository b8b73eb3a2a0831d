# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Show the contents of a recording, and whether it suits estimation, drift and diagnosis.

Looks at the stamps, the torque, both encoders and the motion, without running a filter: seconds
for an hour of recording. Each line has a verdict (ok, warn, bad), the figure behind it and advice.
A model file is not needed; with --model, or in a bag of the estimator, signs, units and motion are
checked against it as well. With the file of a whole robot (--model robot.urdf) all joints are
checked: stamps, jumps, ranges, and whether they count as the file says. docs/check.md explains
each line.

In place of BAG, the MJCF or URDF file of a robot lists its joints, each with all others at rest,
in the posture of --keyframe: what acts on it in the simulation is a value in the table, or it is
refused by name, with what to do. Joints that are read can be given to diagnose, fit and export as
--model ROBOT --joint NAME. Values that no robot has, such as a wrist of 7 g between two links of 2
kg, are doubted.

usage examples:
  gearbox_monitor check BAG
  gearbox_monitor check BAG --model drive.yaml --params joint3.yaml
  gearbox_monitor check BAG --motor-joint joint3_motor --arm-joint joint3 --for estimation
  gearbox_monitor check log.csv --model robot.urdf
  gearbox_monitor check BAG --json | jq .suits
  gearbox_monitor check robot.xml --keyframe home
"""
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
import shlex
import textwrap
from typing import Any

import numpy as np

from gearbox_monitor.cli.options import (
    estimator_options, names_of, opened, reading_of_robot, refuse, robot_of, settings_of, show)
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.noise_search import MIN_SAMPLES, MIN_SECONDS
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.library.robot import check_robot
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import on_axis, Said, said
from gearbox_monitor.recordings.cdr import JointStates, MessageBlock
from gearbox_monitor.recordings.joint_input import (
    bag_arguments, find_input, innovation_topics, nis_of, sample_parts, topics_called)
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.table import is_log_of_xml
from gearbox_monitor.report.sentences import told, wrapped
from gearbox_monitor.robot.compiled_model import (
    implausible_limits, implausible_links, implausible_ranges)
from gearbox_monitor.robot.description import SUFFIXES
from gearbox_monitor.signals.examine import (
    Examination, examine, examined, joined, SAMPLES, WINDOWS)
from gearbox_monitor.signals.finding import BAD, DataFinding, hurts, judged, OK, PURPOSES, WARN
from gearbox_monitor.simulators.mjcf_file import compiled_file, read_file, RobotFile
from gearbox_monitor.simulators.robot_model import links_of_compiled
from gearbox_monitor.simulators.user_simulator import (
    joint_readings, JointReading, NONE, SERVO, SPEED, TORQUE)

WIDTH = 80
INDENT = 24  # of the figures
TUNED = 0.5  # share of missing readings up to which fit noise takes a recording
SUITS = {OK: 'yes', WARN: 'with care', BAD: 'no'}
_OF = {words: verdict.name.lower() for verdict, words in SUITS.items()}


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if Path(args.bag).suffix.lower() in SUFFIXES and not is_log_of_xml(args.bag):
        refuse(args, (*OF_DRIVE, *OF_ROBOT[:1], *OF_ROBOT[2:], 'model', 'topic'),
               f'of a recording, but {args.bag} is a robot')
        return show_table(args)
    refuse(args, ['keyframe'], 'of a robot, expected its MJCF or URDF file as BAG')
    if is_robot(args):
        return run_robot(args)
    with opened(args) as reader:
        filters = of_filters(reader)
        try:
            source = find_input(reader, args.topic)
        except InputError:
            if not filters or topics_called(reader, args.topic):
                raise
            _show_lines(args, said('only_filters', name=args.bag), filters)
            return 0
        topic = source.topic
        stated, model_file = estimator_options(args)
        stated.update({name: getattr(args, name) for name in ('motor_joint', 'arm_joint')
                       if getattr(args, name) is not None})
        drive, parameters, is_known = settings_of(args, reader, source, stated, model_file)
        model = drive if is_known else None
        servo = model is not None and model.controller is not None
        found, notes, joints = _examined(reader, topic, model, parameters,
                                         [args.setpoint_joint] * servo)
        data = {'bag': str(args.bag), 'topic': topic,
                'joints': {'there': joints, 'motor': parameters.motor_joint,
                           'arm': parameters.arm_joint},
                'model': model is not None, 'topics': _topics(reader), 'notes': notes,
                'options': {'model': args.model, 'topic': args.topic, 'params': args.params}}
    found = examined([*found.lines, *filters], found.begin, found.seconds)
    axis = model.axis if model is not None else reader.axis
    data['lines'] = _plain(found.lines, args.purposes, axis)
    data['suits'] = {purpose: {'verdict': SUITS[verdict], 'because': list(names)}
                     for purpose, (verdict, names) in found.suits.items()
                     if purpose in args.purposes}
    data = {**told([says(data)]), **data}
    show(args, data, lambda: text(data))
    return int(any(found.suits[purpose][0] == BAD for purpose in args.purposes))


def of_filters(reader: BagReader) -> list[DataFinding]:
    """Return whether filters in `reader`, of any kind, state the variance of their errors."""
    found = []
    for topic, spreads in innovation_topics(reader).items():
        ratios = nis_of(reader, topic, spreads)
        if not ratios:
            continue
        total = sum(count for _, count in ratios.values())
        nis = sum(mean * count for mean, count in ratios.values()) / total
        each = ', '.join(f'{name} {mean:.3g}' for name, (mean, _) in ratios.items())
        right = LIMITS.nis_low <= nis <= LIMITS.nis_high
        found.append(judged(
            'filter', 'NIS', said('nis_small' if nis < 1.0 else 'nis_large', topic=topic,
                                  nis=nis, count=total, each=each), {} if right else hurts(WARN),
            {'nis': nis, **{f'nis_{name}': mean for name, (mean, _) in ratios.items()}}))
    return found


def _show_lines(args: Namespace, head: Said, findings: Sequence[DataFinding], **more: Any
                ) -> None:
    """Show what a recording is, its findings, and `more` of it as JSON."""
    lines = _plain(findings)
    data = {**told([head]), 'bag': str(args.bag), **more, 'lines': lines}
    show(args, data, lambda: '\n'.join([*wrapped(data['summary']), *_findings(lines)]))


def _examined(reader: BagReader, topic: str, model: DriveModel | None,
              parameters: EstimatorParameters, setpoint: Sequence[str] = ()
              ) -> tuple[Examination, list[str], list[str]]:
    """Return findings, notes and joints of a recording, examined part by part."""
    motor, arm = parameters.motor_joint, parameters.arm_joint
    decode, torques = reader.decoder(topic, (motor, arm, *setpoint)), list[bool]()

    def decoded(block: MessageBlock) -> JointStates:
        states = decode(block)
        torques[:] = [any(torques) or bool(np.isfinite(states.effort[:, 0]).any())]
        return states
    parts: list[Examination | InputError] = []
    with count_bar('check', reader.topics[topic][1]) as bar:
        for samples in sample_parts(reader, topic, decoded, model or DriveModel(),
                                    _min_samples(reader, topic, parameters), bar.update):
            if motor in decode.joints:
                try:
                    parts.append(examine(samples, parameters, model, any(torques) if setpoint
                                         else 'setpoint' in decode.joints))
                except InputError as error:
                    parts.append(error)
    reader.require_joints(topic, [motor, *setpoint], decode.joints,
                          "one of these (--motor-joint NAME --arm-joint ''), or --model "
                          'ROBOT.urdf for all of them')
    evaluated = [part for part in parts if isinstance(part, Examination)]
    if not evaluated:
        raise InputError(f'{reader.path}: {topic}: {parts[0]}')
    notes = [reader.notice] if reader.notice else []
    if unit := reader.effort_units.get(motor):
        notes.append(f'the effort is in {unit}, without a constant: so are its figures')
    notes += [f'part {k} of {len(parts)} is not evaluated: {part}'
              for k, part in enumerate(parts, 1) if isinstance(part, InputError)]
    if len(parts) > 1:
        notes.append(f'evaluated in {len(parts)} parts: each line shows the first of the worst '
                     'parts, refused and lost samples are counted in all')
    if arm and arm not in decode.joints:  # it was never measured
        notes.append(f'{topic} has no joint {arm!r}, only {", ".join(decode.joints)}: name it '
                     "with --arm-joint, '' where there is no arm encoder")
    return joined(evaluated, parameters.drift_window), notes, list(decode.joints)


def _min_samples(reader: BagReader, topic: str, parameters: EstimatorParameters) -> int:
    """Return the smallest number of samples in a part of a recording."""
    rates = {row['topic']: row['rate_hz'] or 0.0 for row in _topics(reader)}
    return max(SAMPLES, int(WINDOWS * parameters.drift_window * rates[topic]))


def _topics(reader: BagReader) -> list[dict[str, Any]]:
    begin, end = reader.start_ns, reader.end_ns
    seconds = (end - begin) * 1e-9 if begin is not None and end else 0.0
    return [{'topic': topic, 'type': kind, 'messages': count,
             'rate_hz': (count - 1) / seconds if seconds > 0.0 and count > 1 else None}
            for topic, (kind, count) in sorted(reader.topics.items())]


def says(data: Mapping[str, Any]) -> Said:
    """Return what the recording of the findings `data` suits."""
    of: dict[str, list[str]] = {words: [] for words in SUITS.values()}
    for purpose, part in data['suits'].items():
        because = f' ({", ".join(part["because"])})' if part['because'] else ''
        of[part['verdict']].append(purpose + because)
    parts = list[Said]()
    for code, names in zip(('suits_well', 'suits_with_care', 'suits_not'), of.values()):
        if names:
            parts.append(said(code, comma='; ' if parts else '', purposes=', '.join(names)))
    return said('suits', name=data['bag'], parts=tuple(parts))


def text(data: Mapping[str, Any]) -> str:
    """Return the findings `data` as lines of at most 80 columns."""
    joints = data['joints']
    suits = [{'group': 'suits', 'name': purpose, 'advice': '', 'verdict': _OF[part['verdict']],
              'figure': part['verdict'] + (f': {", ".join(part["because"])}' if part['because']
                                           else '')}
             for purpose, part in data['suits'].items()]
    return '\n'.join([
        *wrapped(data['summary']), '', *_table(data['topics']), '',
        *wrapped(f'evaluated: {data["topic"]}, motor joint {joints["motor"]}, arm joint '
                 f'{joints["arm"] or "none"}, {"with" if data["model"] else "without"} a '
                 'model file'),
        *_findings([*data['lines'], *suits]),
        *(part for note in data['notes'] for part in wrapped(f'note: {note}')), '',
        *(f'next: {command}' for command in _next(data))]).rstrip()


def _next(data: Mapping[str, Any]) -> list[str]:
    """Return the commands that take the recording as it is, joints and files included."""
    motor, arm, options = data['joints']['motor'], data['joints']['arm'], data['options']
    values = {(line['group'], line['name']): line['values'] for line in data['lines']}
    few = any(values.get((side, 'readings'), {}).get('missing_share', 0.0) > TUNED
              for side in ('motor', 'arm'))
    short = values.get(('stamps', 'length'), {}).get('duration_s', MIN_SECONDS) < MIN_SECONDS or (
        values.get(('stamps', 'order'), {}).get('samples', MIN_SAMPLES) < MIN_SAMPLES)
    model, params = (shlex.quote(name) if name else 'FILE' for name in (
        options['model'], options['params']))
    bag = bag_arguments(data['bag'], options['topic'])
    usual = motor == 'motor' and arm in ('arm', '')
    source = f'--model {model}' if arm else f'--params {params}'
    joints = '' if usual or options['params'] else (
        f'  # FILE: motor_joint: {motor}, arm_joint: {arm or repr("")}')
    further = f' --params {params}' * bool(arm and (options['params'] or not usual)) + joints
    tuned = arm and not few and not short  # else enough for a filter, too little for fit noise
    commands = {
        'estimation': (f'fit noise {bag} {source} --out params.yaml{further}' if tuned else
                       f'replay {bag} --params {params}{joints}'),
        'drift': f'accept {bag} {source} --max-gap RAD{further}',
        'diagnosis': f'diagnose {bag} --model {model}'
        + f' --recorded-motor {shlex.quote(motor)}' * (not usual)
        + f' --recorded-arm {shlex.quote(arm)}' * (not usual or not arm)}
    return [f'gearbox_monitor {commands[purpose]}' for purpose, part in data['suits'].items()
            if part['verdict'] != 'no']


def _table(topics: Sequence[Mapping[str, Any]]) -> list[str]:
    room = min(31, max((len(row['topic']) for row in topics), default=0))
    lines = [f'{"topic":{room}s} {"type":31s} {"messages":>8s} {"Hz":>7s}']
    for row in topics:
        rate = '' if row['rate_hz'] is None else f'{row["rate_hz"]:.5g}'
        name = row['topic']
        if len(name) > room:
            lines.append(name)
            name = ''
        kind = row['type'].replace('/msg/', '/')
        lines.append(f'{name:{room}s} {kind[:31]:31s} {row["messages"]:8d} {rate:>7s}')
    return lines


def _findings(lines: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the findings `lines` below their groups."""
    rows = list[str]()
    for k, line in enumerate(lines):
        if not k or line['group'] != lines[k - 1]['group']:
            rows += ['', line['group']]
        first, *further = textwrap.wrap(line['figure'], WIDTH - INDENT, break_on_hyphens=False)
        rows.append(f'  {line["name"]:16s} {line["verdict"]:5s}{first}')
        further += textwrap.wrap(f'-> {line["advice"]}', WIDTH - INDENT, subsequent_indent='   ',
                                 break_on_hyphens=False) if line['advice'] else []
        rows += [' ' * INDENT + part for part in further]
    return rows


OF_DRIVE = ('params', 'motor_joint', 'arm_joint', 'setpoint_joint', 'purposes')
OF_ROBOT = ('values', 'root', 'recorded', 'prefix', 'convention')


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of check are about a whole robot. Raises InputError."""
    robot = args.model is not None and Path(args.model).suffix.lower() in SUFFIXES
    refuse(args, OF_DRIVE if robot else OF_ROBOT,
           f'of a single drive, but --model {args.model} is a whole robot' if robot else
           'of a whole robot, expected its MJCF or URDF file as --model')
    return robot


def run_robot(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    findings = check_robot(args.bag, robot_of(args), recorded=names_of(args), topic=args.topic,
                           reading=reading_of_robot(args))
    _show_lines(args, robot_says(str(args.bag), findings), findings, model=str(args.model))
    return int(any(f.verdict() == BAD for f in findings))


def _plain(findings: Sequence[DataFinding], purposes: Sequence[str] = PURPOSES,
           axis: str = 'rotary') -> list[dict[str, Any]]:
    return [{
        'group': f.group, 'name': f.name, 'verdict': f.verdict_word(purposes),
        'figure': on_axis(f.figure, axis),
        'advice': on_axis(f.advice, axis) if f.verdict(purposes) > OK else '', 'values': f.values,
        'hurts': {purpose: verdict.name.lower() for purpose, verdict in f.hurts.items()}}
        for f in findings]


def robot_says(log: str, findings: Sequence[DataFinding]) -> Said:
    """Return whether a `log` with these findings suits a diagnosis, and what speaks against it."""
    worst = max((f.verdict() for f in findings), default=OK)
    lines = ', '.join(dict.fromkeys(
        f'{f.name} ({f.group})' for f in findings if f.verdict() == worst > OK))
    code = {BAD: 'robot_suits_not', WARN: 'robot_suits_with_care'}.get(worst, 'robot_suits')
    return said(code, name=log, lines=lines)


WIDE = 100
COLUMNS = ('inertia', 'armature', 'viscous_friction', 'coulomb_friction', 'weight', 'stiffness')
TITLES = ('inertia', 'armature', 'viscous', 'Coulomb', 'weight', 'spring')
UNIT_LINE = ('kg m^2', 'kg m^2', 'N m s/rad', 'N m', 'N m', 'N m/rad')


def show_table(args: Namespace) -> int:
    """Show the joints of the file that the options `args` name; return the exit code."""
    path = Path(args.bag)
    file = compiled_file(read_file(path), path, root=Path(args.root) if args.root else None)
    readings = joint_readings(file, args.keyframe)
    doubts = doubts_of(file)
    show(args, {**robot_data(file, readings), 'doubts': doubts}, lambda: '\n'.join([
        robot_text(file, readings), *(line for d in doubts for line in _wrapped(f'doubt: {d}'))]))
    return 0 if all(reading.read for reading in readings) and not doubts else 1


def doubts_of(file: RobotFile) -> list[str]:
    """Return a line for each value of a robot's `file` that cannot be true."""
    document, path = file.document, str(file.path)
    return [*implausible_links(links_of_compiled(file.compiled)), *(
        implausible_limits(document.data, path) if document.root.tag == 'robot' else []),
        *implausible_ranges(file.compiled)]


def robot_data(file: RobotFile, readings: Sequence[JointReading]) -> dict[str, Any]:
    """Return the table as plain data; `file` is the robot's, `readings` are of its joints."""
    return {
        'robot': str(file.path), 'timestep': float(file.compiled.opt.timestep),
        'read': sum(reading.read for reading in readings), 'notes': list(file.notes),
        'joints': [{
            'joint': r.name, 'type': r.kind, 'read': r.read, 'control': r.control,
            'values': r.values, 'units': r.units(), 'refused': list(r.refusals),
            'notes': list(r.notes)} for r in readings]}


def robot_text(file: RobotFile, readings: Sequence[JointReading]) -> str:
    """Return the table as lines for people; `file` is the robot's, `readings` of its joints."""
    count = sum(reading.read for reading in readings)
    name = max([5, *(len(r.name) for r in readings)])
    head = [f'{file.path.name}: {count} of {len(readings)} joints are read '
            '(diagnose --model ' f'{file.path} --joint NAME)', '',
            f'{"joint":<{name}}' + ''.join(f'{title:>10}' for title in TITLES) + '  control',
            f'{"":<{name}}' + ''.join(f'{unit:>10}' for unit in UNIT_LINE)]
    lines = []
    for reading in readings:
        cells = ''.join(f'{_cell(reading.values.get(k)):>10}' for k in COLUMNS)
        lines.append(f'{reading.name:<{name}}' + (
            f'{cells}  {_drive(reading)}' if reading.read else '  refused'))
        for refusal in reading.refusals:
            lines += textwrap.wrap(refusal, WIDE, initial_indent=' ' * (name + 2),
                                   subsequent_indent=' ' * (name + 4), break_on_hyphens=False)
    if any(r.kind == 'slide' for r in readings):
        lines.append('(of a slide: kg, N s/m, N and N/m)')
    notes = dict.fromkeys([*file.notes, *(note for r in readings for note in r.notes)])
    for note in notes:
        count = sum(note in r.notes for r in readings)
        lines += _wrapped(f'note: {note}' + (f' ({count} joints)' if count > 1 else ''))
    return '\n'.join([*head, *lines])


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(line, WIDE, break_on_hyphens=False)


def _cell(value: float | None) -> str:
    return '-' if value is None else f'{value:.4g}'


def _drive(reading: JointReading) -> str:
    """Return words about what drives a joint."""
    v = reading.values
    parts = {
        NONE: ['no actuator'], TORQUE: [f'torque, x {v.get("gear", 1.0) * v.get("gain", 1.0):g}'],
        SPEED: [f'speed, x {v.get("gear", 1.0) * v.get("gain", 1.0):g}'],
        SERVO: [f'position, kp {v.get("kp", 0.0):g} kd {v.get("kd", 0.0):g}']}[reading.control]
    if 'limit' in v:
        parts.append(f'+-{v["limit"]:g}')
    parts += [f'{name} {1e3 * v[name]:g} ms' for name in ('lag', 'delay') if name in v]
    if 'offset' in v:
        parts.append(f'offset {v["offset"]:.4g}')
    return ', '.join(parts)
