# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The Recording of a drive or of a robot, from an open recording of any kind.

Joints of a robot are read as its description counts them, with what a user states beside its file.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import repeat
import math
import re
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_log import (
    checked_log, continuous, CURRENT, raw_log, RawLog, read_by, RobotLog, SETPOINT, TORQUE)
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import (
    expect, expect_choice, expect_keys, expect_values, InputError, number_check, Undecided)
from gearbox_monitor.files.user_files import load_yaml
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.presentation import as_written, Said, said
from gearbox_monitor.recordings.joint_input import find_topic, topics_called
from gearbox_monitor.recordings.meaning import EFFORT, units_of
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_SETPOINTS
from gearbox_monitor.signals.recording import (
    ARM, conventions_of, CURRENT as OF_CURRENT, JOINT, JointSignals, NOT_MEASURED, Recording,
    UNKNOWN)
from gearbox_monitor.simulators.robot_model import ChainFile

ANY = '*'  # in place of a joint: all of them, with a prefix in the log
NO_SERVO = 'the model has none'
NEEDED = 'setpoints need position actuators of all joints in the model, or gains in --values'
STILL = 'of a joint that stands still, its position: locked in --values'
UNSIGNED = 'no value is below 0: sizes without a direction'
HINT = '--recorded NAME=LOGNAME maps a name'


def recorded_joints(reader: BagReader, topic: str, joints: Sequence[str],
                    sides: Sequence[str] = (), setpoint: str = '') -> Recording:
    """
    Return the Recording of `joints`; setpoints on a topic of their own hold until the next one.

    Args:
        reader: of it.
        topic: of its joint states.
        joints: names in the recording.
        sides: of a drive: MOTOR, ARM.
        setpoint: joint whose position is the setpoint of the first one; '' for a topic
            joint_setpoints, if there is one.

    Raises:
        InputError: there is no such joint.
    """
    states = reader.joint_states(topic, [*joints, *([setpoint] if setpoint else [])]).of_named()
    setpoints = {joints[0]: states.position[:, -1]} if setpoint else _setpoints(
        reader, topic, joints, states.stamp_ns)
    return Recording(str(reader.path) if sides else reader.path.name, {joint: JointSignals(
        states.stamp_ns, states.position[:, k], states.velocity[:, k],
        setpoints.get(joint, NOT_MEASURED), states.effort[:, k], side, _kind(reader, joint),
        side == ARM) for k, (joint, side) in enumerate(zip(joints, sides or repeat(JOINT)))},
        (reader.notice,) if reader.notice else ())


def _kind(reader: BagReader, joint: str) -> str:
    """Return what the effort of a joint is, one of signals.recording.EFFORTS."""
    unit = reader.effort_units.get(joint, '')
    return OF_CURRENT if unit in units_of(EFFORT, 'input') else UNKNOWN


def _setpoints(reader: BagReader, topic: str, joints: Sequence[str], stamp_ns: Integers
               ) -> dict[str, Array]:
    """Return the setpoints of `joints` at `stamp_ns` [N] on a topic other than `topic`, if any."""
    others = [name for name in topics_called(reader, JOINT_SETPOINTS) if name != topic]
    named = [joint for joint in joints if others
             and joint in reader.joint_names(others[0], joints)]
    if not named:
        return {}
    goal = reader.joint_states(others[0], named)
    setpoints = {}
    for joint, x in zip(named, goal.position.T):
        good = np.isfinite(x)
        order = np.argsort(goal.stamp_ns[good], kind='stable')
        row = np.searchsorted(goal.stamp_ns[good][order], stamp_ns, 'right') - 1
        setpoints[joint] = np.concatenate([[np.nan], x[good][order]])[row + 1]
    return setpoints


# --- names --------------------------------------------------------------------------------------
def names_in_log(path: str, present: Sequence[str], joints: Sequence[str],
                 recorded: Mapping[str, str], serial: bool = True, hint: str = HINT
                 ) -> tuple[dict[str, str], list[str]]:
    """
    Return ({joint of the model: its name in the log}, notes about what was assumed).

    Args:
        path: of the log, for messages.
        present: names in the log.
        joints: of the model, in the order of a chain.
        recorded: {joint: its name in the log} as stated; ANY: a prefix of all names.
        serial: whether the joints are one chain, so that numbers count from its base.
        hint: how to state names.

    Raises:
        InputError: the log has some of the joints only.
        Undecided: several prefixes fit.
    """
    prefix = recorded.get(ANY, '')
    names = {joint: recorded.get(joint, prefix + joint) for joint in joints}
    lacking = [joint for joint, name in names.items() if name not in present]
    if not lacking:
        return names, []
    if not recorded:
        fitting = {name.removesuffix(joints[0]) for name in present if name.endswith(joints[0])}
        fitting = {p for p in fitting if p and all(p + joint in present for joint in joints)}
        if len(fitting) == 1:
            prefix = fitting.pop()
            return {joint: prefix + joint for joint in joints}, [
                f'the joints of the log begin with {prefix}, those of the model do not']
        if fitting:
            first = sorted(fitting)[0]
            raise Undecided(f'{path}: {", ".join(sorted(fitting))}: {len(fitting)} robots with '
                            f'these joints, expected one: --prefix {first}')
        short = {joint: joint.removesuffix('_joint') for joint in joints}
        if all(name in present for name in short.values()):    # as of position_NAME_joint
            return short, ['names of the log are those of the model without _joint']
        if numbers := _by_number(present, joints) if serial else {}:
            why = 'a drive' if 'motor' in numbers.values() else \
                'its joints have only numbers, taken from the base on'
            return numbers, [f'{why}: ' + ', '.join(
                f'{name} is {joint}' for joint, name in numbers.items())
                + f' (others: {hint})' * bool(hint)]
    raise InputError(f'{path}: no {", ".join(lacking)} in the log, which has '
                     f'{", ".join(present)[:200] or "none"}, expected all joints of the model '
                     f'({HINT}); {STILL}')


def _by_number(present: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Return {joint: its name in a log whose joints have only numbers, one for each joint}, else {}.

    The only joint of a robot is the motor in the bag of a drive.
    """
    if len(joints) == 1 and 'motor' in present:
        return {joints[0]: 'motor'}
    numbers = {int(match[1]): name for name in present
               if (match := re.fullmatch(r'(?:joint_?|axis_?|[aj])?(\d+)', name))}
    if len(numbers) != len(present) or set(present) & set(joints) or set(numbers) not in (
            set(range(len(joints))), set(range(1, len(joints) + 1))):
        return {}
    return dict(zip(joints, (numbers[k] for k in sorted(numbers))))


# --- the log of a robot -------------------------------------------------------------------------
def unsigned(efforts: Array) -> bool:
    """
    Return whether `efforts` [N, J] are sizes: none is below 0, but one comes to 0 and rises again.

    A joint may always push one way, against a weight; but then it does not turn around at 0.
    """
    return not (efforts < 0.0).any() and any((np.trim_zeros(x) == 0.0).any() for x in efforts.T)


def robot_log(reader: BagReader, joints: Sequence[str], recorded: Mapping[str, str],
              constants: Mapping[str, float] | None = None, no_servo: str = NO_SERVO,
              topic: str = 'joint_states', locked: Mapping[str, float] | None = None,
              serial: bool = True) -> RawLog:
    """
    Return the columns of a robot's recording that its model takes.

    Args:
        reader: of it.
        joints: of the model.
        recorded: {joint: its name in the log}, where they differ.
        constants: torque per current, N m/A, of each joint; None where they are not known.
        no_servo: why setpoints make no torque with the model, '' where they do.
        topic: of the joint states.
        locked: {joint that the model holds still: its position}; where the log has it is a note.
        serial: whether the joints are one chain.

    Raises:
        InputError: the recording has no such joint, or no torque of it.
    """
    path, locked = str(reader.path), locked or {}
    topic = find_topic(reader, topic)
    present = reader.joint_names(topic)
    names, assumed = names_in_log(path, present, joints, recorded, serial)
    notes = list(map(as_written, assumed))
    held = [joint for joint in locked if joint in present]
    recording = recorded_joints(reader, topic, [*names.values(), *held])
    unused = [name for name in present if name not in (*names.values(), *held)]
    if unused:
        notes.append(as_written(f'joints that are not used: {", ".join(unused)[:200]}'))
    for joint in held:
        q = recording[joint].position
        if np.isfinite(q).any():
            notes.append(said('locked_joint', place=joint, at=locked[joint],
                              low=np.nanmin(q), high=np.nanmax(q)))
    signals = [recording[name] for name in names.values()]
    efforts = np.column_stack([s.effort for s in signals])
    has_effort = [s.has('effort') for s in signals]
    has_setpoints = any(s.has('setpoint') for s in signals)
    sizes = all(has_effort) and unsigned(efforts)
    or_setpoints = ', or setpoints' + (f'; {NEEDED} ({no_servo})' if no_servo else '')
    kind = CURRENT if any(s.effort_is == OF_CURRENT for s in signals) else TORQUE
    if sizes and (no_servo or not has_setpoints):
        raise InputError(f'{path}: effort: {UNSIGNED}, expected torques with their '
                         f'sign{or_setpoints}')
    if not all(has_effort) or sizes:
        if no_servo or not has_setpoints:
            without = [j for j, has in zip(joints, has_effort) if not has]
            raise InputError(f'{path}: no effort of {", ".join(without)}, expected the torque of '
                             f'all joints{or_setpoints}; {STILL}')
        kind = SETPOINT
        notes += [as_written(f'effort: {UNSIGNED}; the setpoints are used')] * sizes
    elif has_setpoints and no_servo:
        notes.append(said('setpoints_unused', why=no_servo))
    if kind == CURRENT and constants is not None:
        lacking = [joint for joint in joints if joint not in constants]
        if lacking:
            raise InputError(f'{path}: torque_constants: none of {", ".join(lacking)}, expected '
                             'N m/A of each joint')
        notes.append(said('scaled_current'))
    raw = raw_log(recording, names, kind, constants)
    return replace(raw, notes=(*raw.notes, *notes), measured=kind == CURRENT,
                   setpoint={} if no_servo else raw.setpoint)


BEYOND = 0.05  # rad or m: a joint that leaves its range by less is at its stop
OF_DEGREES = 3.0  # times the range: no wrong zero or turn leads radians so far
NUMBERS = ('tolerance', 'friction_tolerance', 'gain_tolerance', 'torque_tolerance')
KEYS = (*NUMBERS, 'link_tolerance', 'torque_constants', 'effort', 'kp', 'kd', 'compensated',
        'locked')
SIZE = number_check('a number of 0 or more', lambda x: x >= 0.0)
CONSTANT = number_check('a number of 1e-09 or more', lambda x: x >= 1e-9)


@dataclass(frozen=True, eq=False)
class RobotValues:
    """
    What --values says of a robot.

    tolerance, friction_tolerance, gain_tolerance, torque_tolerance: relative, None for the
    usual. links {name: tolerance}; constants {joint: N m/A}, None if not stated; kp, kd {joint:
    gain}; measured: the effort is measured, not commanded; compensated: the servo adds the
    weight.
    """

    tolerance: float | None
    friction_tolerance: float
    links: Mapping[str, float]
    constants: Mapping[str, float] | None
    kp: Mapping[str, float]
    kd: Mapping[str, float]
    gain_tolerance: float
    torque_tolerance: float
    measured: bool
    compensated: bool


def load_locked(path: str | None) -> dict[str, float]:
    """Return {joint that stands still: rad or m} of the YAML file `path`. Raises InputError."""
    locked = _content(path).get('locked', {})
    expect_values(locked, 'locked', str(path), dict.fromkeys(
        locked if isinstance(locked, dict) else (), number_check()))
    return {str(joint): float(at) for joint, at in locked.items()}


def _content(path: str | None) -> dict[str, Any]:
    """Return what the YAML file `path` holds, with KEYS alone. Raises InputError."""
    content: dict[str, Any] = {} if path is None else load_yaml(path).content
    expect_keys(content, 'values', str(path), KEYS, whole=True)
    return content


def load_values(path: str | None, file: ChainFile) -> RobotValues:
    """Return the RobotValues of the YAML file `path` for the robot `file`. Raises InputError."""
    content, joints = _content(path), file.chain.joints
    for key in (key for key in NUMBERS if key in content):
        expect(content[key], key, str(path), SIZE)
    for key, names in (('link_tolerance', [link.name for link in file.chain.links]),
                       ('kp', joints), ('kd', joints), ('torque_constants', joints)):
        expect_values(content.get(key, {}), key, str(path), dict.fromkeys(
            names, CONSTANT if key == 'torque_constants' else SIZE))
    effort = expect_choice(content.get('effort', 'commanded'), 'effort', str(path),
                           ('measured', 'commanded'))
    compensated = content.get('compensated', False)
    expect(compensated, 'compensated', str(path),
           lambda value: '' if isinstance(value, bool) else 'true or false')
    kp = content.get('kp', {})
    all_kp = _gains(kp, file.kp, file)
    lacking = [] if not kp or all_kp is None else [
        joint for joint, gain in zip(joints, all_kp) if not gain > 0.0]
    if lacking:
        raise InputError(f'{path}: kp: none of {", ".join(lacking)}, expected one of each joint')
    return RobotValues(
        content.get('tolerance'), content.get('friction_tolerance', SETTINGS.tolerance),
        content.get('link_tolerance', {}), content.get('torque_constants'), kp,
        content.get('kd', {}), content.get('gain_tolerance', SETTINGS.gain_tolerance),
        content.get('torque_tolerance', SETTINGS.torque_tolerance), effort == 'measured',
        compensated)


def robot_model(file: ChainFile, values: RobotValues, learnt: bool) -> RobotModel:
    """
    Return the RobotModel of a file.

    Args:
        file: of the simulator.
        values: of the user.
        learnt: whether references teach its friction.
    """
    usual = values.tolerance
    if usual is None:
        usual = SETTINGS.tolerance_learnt if learnt else SETTINGS.tolerance
    tolerance = np.array([values.links.get(link.name, usual) for link in file.chain.links])
    # All inertia of a drive belongs to its joint, whose tolerance is otherwise that for friction.
    friction = usual if file.drive else 0.0 if learnt else values.friction_tolerance
    return RobotModel(file.chain, tolerance, friction, learnt,
                      _gains(values.kp, file.kp, file), _gains(values.kd, file.kd, file),
                      values.compensated, values.gain_tolerance, values.torque_tolerance)


def _gains(stated: Mapping[str, float], of_file: Array | None, file: ChainFile) -> Array | None:
    """Return the gains of all joints: as stated, those of the file, or 0; None without any."""
    if not stated:
        return of_file
    base = np.zeros(len(file.chain.joints)) if of_file is None else of_file
    return np.array([stated.get(joint, gain) for joint, gain in zip(file.chain.joints, base)])


def load_columns(path: str, file: ChainFile, values: RobotValues, recorded: Mapping[str, str],
                 topic: str, reading: ReadOptions, no_servo: str = NO_SERVO) -> RawLog:
    """
    Return the columns of a robot's log as its description counts them, without jumps.

    Args:
        path: of a recording of any kind.
        file: of the robot.
        values: of the user.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joint states, in bags.
        reading: how columns and joints are read.
        no_servo: why setpoints make no torque with the model, '' where they do.

    Raises:
        InputError: it cannot be read, or lacks a joint.
    """
    joints = file.chain.joints
    conventions = conventions_of(reading.conventions, joints)
    with open_recording(path, reading, topic) as reader:
        raw = robot_log(reader, joints, recorded, values.constants, no_servo, topic, file.locked,
                        bool(file.chain.serial))
    return continuous(read_by(raw, conventions))


def beyond_range(raw: RawLog, file: ChainFile) -> list[Said]:
    """Return the joints of a log `raw` that leave the range in the `file`, and how far."""
    notes = []
    for joint, low, high in zip(file.chain.joints, file.low, file.high):
        q = raw.position[joint][np.isfinite(raw.position[joint])]
        if len(q) and joint not in raw.turned and (
                q.min() < low - BEYOND or q.max() > high + BEYOND):
            share = float(((q < low) | (q > high)).mean())
            room = float(high - low)
            degrees = OF_DEGREES * room < float(np.ptp(q)) < math.degrees(room)
            notes.append(said(
                'beyond_range', place=joint, low=q.min(), high=q.max(), percent=100.0 * share,
                lowest=low, highest=high, degrees=(said('of_degrees', place=joint),) * degrees))
    return notes


def load_log(path: str, file: ChainFile, robot: RobotModel, values: RobotValues,
             recorded: Mapping[str, str], topic: str = 'joint_states',
             reading: ReadOptions = BY_NAMES) -> RobotLog:
    """
    Return the checked log in the file `path`. Raises InputError.

    Args:
        path: of a recording of any kind.
        file: of the robot.
        robot: its model.
        values: of the user.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joint states, in bags.
        reading: how columns are read whose names and units do not say it.
    """
    servo = robot.kp is not None and bool(np.all(robot.kp > 0.0))
    raw = load_columns(path, file, values, recorded, topic, reading, '' if servo else
                       file.no_servo)
    if raw.kind == CURRENT and values.constants is None:
        raise InputError(f'{path}: current without torque_constants, expected N m/A of each joint '
                         'in --values: a rough one does, masses come in its scale')
    if values.measured and raw.kind == TORQUE:
        raw = replace(raw, measured=True)
    return checked_log(replace(raw, notes=(*raw.notes, *beyond_range(raw, file))),
                       file.chain.joints)
