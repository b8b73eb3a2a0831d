# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The motion of a robot that shows a payload or tells effects apart, and its trajectory."""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np

from gearbox_monitor.balance.robot_effects import PAYLOAD
from gearbox_monitor.balance.robot_experiment import (
    design, RATE, RobotLimits, RobotMotionDesign, Target)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.robot_limits import contacts_in, limits_in
from gearbox_monitor.library.robot import expect_robot, Robot, robot_effects
from gearbox_monitor.recordings.robot_values import robot_model

SHORTEST, LONGEST = 8.0, 60.0  # s
POINTS = 10.0                  # Hz, of a trajectory; with speed and acceleration of each point


@dataclass(frozen=True, eq=False)
class SuggestedRobotMotion:
    """A motion: design, joints, the limits it keeps, and notes on what was not tested."""

    design: RobotMotionDesign
    joints: tuple[str, ...]
    limits: RobotLimits
    notes: tuple[str, ...]

    @property
    def trajectory(self) -> dict[str, Any]:
        """The fields of a trajectory_msgs/JointTrajectory, as plain data."""
        d, stride = self.design, round(RATE / POINTS)
        points = [{'positions': np.round(q, 5).tolist(), 'velocities': np.round(v, 5).tolist(),
                   'accelerations': np.round(a, 4).tolist(),
                   'time_from_start': {'sec': int(t), 'nanosec': round(t % 1.0 * 1e9)}}
                  for t, q, v, a in zip(*(x[::stride] for x in (d.t, d.q, d.v, d.a)))]
        return {'joint_names': list(self.joints), 'points': points}

    @property
    def table(self) -> tuple[list[str], Any]:
        """Names and columns [N, 1 + 3 J]: t s, q, v and tau (by the model) of each joint."""
        d = self.design
        names = [f'{x}_{j}' for x in ('q', 'v', 'tau') for j in self.joints]
        return ['t', *names], np.column_stack([d.t, d.q, d.v, d.torque])


def suggest_robot(robot: Robot, effects: Sequence[str] | None = None, *, seconds: float = 20.0,
                  link: str = '', speed: float = math.inf, torque: float = math.inf,
                  travel: float = math.inf,
                  progress: Callable[[int, int], object] = lambda done, total: None
                  ) -> SuggestedRobotMotion:
    """
    Return the motion in which a robot shows a payload, or effects, at the smallest size.

    For a diagnosis against a reference: the robot repeats the motion, healthy and later. The
    motion keeps the limits of the file, and in an MJCF keeps clear of contacts.

    Args:
        robot: of `load_robot`.
        effects: ids, to be distinguished from each other; None for a payload.
        seconds: length, 8 to 60 s, rounded to 0.1 s.
        link: that a payload is at, '' for the last one.
        speed: largest of every joint, rad/s (m/s), beside that of the file.
        torque: largest of every joint, N m (N), beside that of the file.
        travel: largest to either side of 0, rad (m), beside the range of the file.
        progress: called with (done, total).

    Returns:
        The motion: `trajectory` is a JointTrajectory, `design` says what it shows.

    Raises:
        InputError: unknown effects or link, a joint without a limit.
        Undecided: no motion stays within the limits.
    """
    file, joints = expect_robot(robot).file, robot.joints
    ids = [PAYLOAD.id] if effects is None else list(effects)
    for name in ids:
        if name not in robot_effects():
            raise InputError(f'effects: {name!r}: {unknown(name, robot_effects())}')
    if len(set(ids)) < len(ids):
        raise InputError(f'effects: {", ".join(ids)}: one of them twice, expected each once')
    if not ids:
        raise InputError('effects: none, expected one or several')
    if not SHORTEST <= seconds <= LONGEST:
        raise InputError(f'seconds: {seconds:g}, expected {SHORTEST:g} to {LONGEST:g}')
    links = [x.name for x in file.chain.links if x.mass > 0.0]
    if link and link not in links:
        raise InputError(f'link: {link!r}: {unknown(link, links)}')
    if not links:
        raise InputError(f'{file.path}: no link has a mass, expected the masses of its links')
    limits = _limits(joints, limits_in(file), speed, torque, travel)
    touches, note = contacts_in(file, RATE)
    targets: list[Target] = [(a, b) for a in ids for b in ids if a != b] or [(ids[0], None)]
    motion = design(robot_model(file, robot.values, True), limits, targets, link or links[-1],
                   round(seconds * POINTS) / POINTS, touches, progress=progress)
    return SuggestedRobotMotion(motion, joints, limits, (note,) if note else ())


def _limits(joints: Sequence[str], stated: RobotLimits, speed: float, torque: float,
            travel: float) -> RobotLimits:
    """Return the tighter of the limits of file and user. Raises InputError where one lacks."""
    for name, value in (('speed', speed), ('torque', torque), ('travel', travel)):
        if not value > 0.0:
            raise InputError(f'{name}: {value:g}, expected a number > 0')
    limits = RobotLimits(np.maximum(stated.low, -travel), np.minimum(stated.high, travel),
                         np.minimum(stated.speed, speed), np.minimum(stated.torque, torque))
    for option, values in (('travel', limits.high - limits.low), ('speed', limits.speed),
                           ('torque', limits.torque)):
        for joint, value in zip(joints, values):
            if math.isinf(value):
                raise InputError(f'{option}: joint {joint}: no limit in the file, expected '
                                 f'{option} (--max-{option})')
            if not value > 0.0:
                raise InputError(f'{option}: joint {joint}: {value:g} by file and options, '
                                 'expected more than 0')
    return limits


def goal_lines(motion: RobotMotionDesign, units: Mapping[str, str]) -> list[str]:
    """Return a line for each goal of a `motion`, with the `units` {effect: unit} of sizes."""
    lines = []
    for (effect, place, rival), size in motion.goals.items():
        beside = f' beside {rival}' if rival else ''
        lines.append(f'{effect} at {place}{beside}: {size:.3g} {units[effect]}, in random motions '
                     f'{motion.usual[effect, place, rival]:.3g}')
    return lines
