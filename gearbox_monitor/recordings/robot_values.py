# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a user states of a robot beside its file, and the logs of its joints read with it."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_log import (
    checked_log, continuous, CURRENT, RawLog, read_by, RobotLog, TORQUE)
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.errors import (
    expect, expect_choice, expect_keys, InputError, number_check, unknown)
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import said, Said
from gearbox_monitor.recordings.from_bag import NO_SERVO, robot_log
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.signals.recording import conventions_of
from gearbox_monitor.simulators.robot_model import ChainFile

BEYOND = 0.05  # rad or m: a joint that leaves its range by less is at its stop
OF_DEGREES = 3.0  # times the range: no wrong zero or turn leads radians so far
KEYS = ('tolerance', 'link_tolerance', 'friction_tolerance', 'torque_constants', 'effort', 'kp',
        'kd', 'gain_tolerance', 'torque_tolerance', 'compensated', 'locked')


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
    return _table(path, _content(path), 'locked', None, -math.inf)


def _content(path: str | None) -> dict[str, Any]:
    """Return what the YAML file `path` holds, with KEYS alone. Raises InputError."""
    content: dict[str, Any] = {} if path is None else load_yaml(path).content
    expect_keys(content, 'values', str(path), KEYS, whole=True)
    return content


def _number(path: str | None, where: str, value: Any, low: float) -> float:
    """Return the number of the key `where`. Raises InputError: it is less than `low`, or none."""
    expect(value, where, str(path), number_check('a number' + (
        f' of {low:g} or more' if low > -math.inf else ''), lambda x: x >= low))
    return float(value)


def _table(path: str | None, content: Mapping[str, Any], key: str, names: Sequence[str] | None,
           low: float = 0.0) -> dict[str, float]:
    """Return the numbers from `low` on by name of a `key`; names: that it may have, None: any."""
    value = content.get(key, {})
    if not isinstance(value, dict):
        raise InputError(f'{path}: {key}: {str(value)[:40]!r}, expected NAME: number')
    for name in value:
        if names is not None and name not in names:
            raise InputError(f'{path}: {key}: {unknown(str(name), names)}')
    return {str(name): _number(path, f'{key}.{name}', v, low) for name, v in value.items()}


def load_values(path: str | None, file: ChainFile) -> RobotValues:
    """Return the RobotValues of the YAML file `path` for the robot `file`. Raises InputError."""
    content = _content(path)
    joints = file.chain.joints
    links = [link.name for link in file.chain.links]
    effort = expect_choice(content.get('effort', 'commanded'), 'effort', str(path),
                           ('measured', 'commanded'))
    number, table = partial(_number, path, low=0.0), partial(_table, path, content)
    compensated = content.get('compensated', False)
    if not isinstance(compensated, bool):
        raise InputError(f'{path}: compensated: {compensated!r}, expected true or false')
    tolerance, kp = content.get('tolerance'), table('kp', joints)
    all_kp = _gains(kp, file.kp, file)
    lacking = [] if not kp or all_kp is None else [
        joint for joint, gain in zip(joints, all_kp) if not gain > 0.0]
    if lacking:
        raise InputError(f'{path}: kp: none of {", ".join(lacking)}, expected one of each joint')
    return RobotValues(
        None if tolerance is None else number('tolerance', tolerance),
        number('friction_tolerance', content.get('friction_tolerance', SETTINGS.tolerance)),
        table('link_tolerance', links), table('torque_constants', joints, 1e-9)
        if 'torque_constants' in content else None, kp, table('kd', joints),
        number('gain_tolerance', content.get('gain_tolerance', SETTINGS.gain_tolerance)),
        number('torque_tolerance', content.get('torque_tolerance', SETTINGS.torque_tolerance)),
        effort == 'measured', compensated)


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
    """Return the joints of a log that leave the range of the description, and how far."""
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
