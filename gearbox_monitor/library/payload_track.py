# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot held over a log, and the external torque on its joints."""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gearbox_monitor.balance.conventions import columns_as_read, named_readings
from gearbox_monitor.balance.knowledge import Knowledge
from gearbox_monitor.balance.payload import PayloadTracker, SECOND
from gearbox_monitor.balance.robot_log import checked_log, SETPOINT
from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.signals import JOINT_STATES
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.drive_file import expect_path
from gearbox_monitor.library.robot import expect_robot, learn_robot, Robot
from gearbox_monitor.presentation import Drawn
from gearbox_monitor.recordings.reading import BY_NAMES, ReadOptions
from gearbox_monitor.recordings.robot_values import load_columns, robot_model
from gearbox_monitor.report.robot_words import reading_words
from gearbox_monitor.signals.convention import conventions_of


@dataclass(frozen=True, eq=False, repr=False)
class PayloadTrack(Drawn):
    """
    Payload and external torque over a log, ten times a second.

    t [N] s from the first sample; mass, mass_std [N] kg; centre, centre_std [N, 3] m in the frame
    of `link`, NaN where the mass is too uncertain; since [N] s: last change of the payload, NaN
    before one; external, external_std [N, J] of `joints`: torque by no model, positive where it
    helps the motor, N m. notes: of the log.
    """

    log: str
    link: str
    joints: tuple[str, ...]
    t: Array
    mass: Array
    mass_std: Array
    centre: Array
    centre_std: Array
    since: Array
    external: Array
    external_std: Array
    notes: tuple[str, ...]


def payload_tracker(robot: Robot, link: str = '', knowledge: Knowledge | None = None,
                    empty: bool = False) -> PayloadTracker:
    """
    Return the PayloadTracker of a robot.

    Args:
        robot: of `load_robot`.
        link: that carries, '' for the last one.
        knowledge: what references taught, None for none.
        empty: nothing is held at the beginning.
    """
    return PayloadTracker(robot_model(robot.file, robot.values, False), link, knowledge, empty)


def track_payload(log: str | Path, robot: Robot, *,
                  reference: str | Path | Sequence[str | Path] | None = None, link: str = '',
                  empty: bool = False, recorded: Mapping[str, str] | None = None,
                  topic: str = JOINT_STATES, reading: ReadOptions = BY_NAMES,
                  progress: Callable[[int, int], None] = lambda done, total: None
                  ) -> PayloadTrack:
    """
    Return what a robot held over a log, and who pushed it (balance.payload).

    Args:
        log: bag, CSV or Parquet file with positions and torques of all joints.
        robot: of `load_robot`.
        reference: logs of the healthy robot without a load, or one file of the command learn;
            None: the file of the robot with its tolerances.
        link: that carries, '' for the last one.
        empty: nothing is held at the beginning; what seems held then is the model's error.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joints, in bags.
        reading: how columns are read whose names and units do not say it.
        progress: called with (done, total) samples.

    Raises:
        InputError: the log cannot be read, lacks a joint or its torque, or is too short.
    """
    values, joints = expect_robot(robot).values, robot.joints
    path = expect_path(log, 'log', 'a log of all joints')
    knowledge = learn_robot(
        reference, robot, recorded=recorded, topic=topic, reading=reading)[0] if (
        reference is not None) else None
    raw = load_columns(str(path), robot.file, values, recorded or {}, topic, reading)
    named = named_readings(
        checked_log(raw, joints), robot_model(robot.file, values, False),
        (robot.file.low, robot.file.high),
        [joints.index(j) for j in conventions_of(reading.conventions, joints)]) if (
            raw.kind != SETPOINT) else []
    raw = columns_as_read(raw, [n.reading for n in named])
    raw = replace(raw, notes=(*(reading_words(n, joints) for n in named), *raw.notes))
    if raw.kind == SETPOINT:
        raise InputError(f'{path}: setpoints, expected the torque or current of all joints')
    lacking = [joint for joint in joints if joint not in raw.position]
    if lacking:
        raise InputError(f'{path}: joint {lacking[0]}: no position, expected all joints of the '
                         'model (--recorded NAME=LOGNAME maps a name)')
    q, u = (np.column_stack([x[j] for j in joints]) for x in (raw.position, raw.input))
    tracker = payload_tracker(robot, link, knowledge, empty)
    good = np.isfinite(raw.t)
    stamps = np.round((raw.t[good] - raw.t[good][:1]) * SECOND).astype(np.int64)
    estimates, total = [], len(stamps)
    for k, (stamp, position, effort) in enumerate(zip(stamps.tolist(), q[good], u[good])):
        estimates += tracker.take(stamp, position, effort)
        if k % 1000 == 0:
            progress(k, total)
    progress(total, total)
    if not estimates:
        raise InputError(f'{path}: {stamps[-1] / SECOND if total else 0.0:.3g} s without an '
                         'estimate, expected 3 s or more with positions and torques of all joints')

    def column(name: str) -> Array:
        return np.array([getattr(e, name) for e in estimates], float)
    since = column('since_ns') / SECOND
    return PayloadTrack(
        path.name, tracker.link, tuple(joints), column('stamp_ns') / SECOND, column('mass'),
        column('mass_std'), column('centre'), column('centre_std'),
        np.where(since > 0.0, since, np.nan), column('external'), column('external_std'),
        tuple(raw.notes))
