# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The arm of config/arm6.urdf at work: it repeats a program while the gap of one joint grows."""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.robot import example_arm
from gearbox_monitor.robot.arm_plant import ArmPlant, ArmRun, pick_and_place
from gearbox_monitor.robot.description import RobotDescription

SPREAD = 0.1    # how far masses and inertias of the arm are off, relative
MOVES = 3       # of the program
PROGRAM = 7     # its seed: all joints load both flanks but the second, which carries the weight


@dataclass(frozen=True)
class GapGrowth:
    """From `start` (s) the gap of a `joint` (number from 0) grows by `rate` (1/s) of its width."""

    joint: int = 0
    rate: float = 0.0
    start: float = 0.0

    def factor(self, t: float) -> float:
        """Return the width at `t` (s) over that at the start."""
        return 1.0 + self.rate * max(t - self.start, 0.0)


class MeasuredRun(NamedTuple):
    """An ArmRun and the measured positions of motors and arms [N, n], rad."""

    true: ArmRun
    motor: Array
    arm: Array


def program(dt: float) -> Array:
    """Return the references [N, 2, n] of ArmPlant.run, `dt` s apart; they end where they begin."""
    start = example_arm.MIDDLE
    for _ in range(2):  # the second time it begins where it ends
        references, _ = pick_and_place(
            np.random.default_rng(PROGRAM),
            (example_arm.LOW, example_arm.HIGH, example_arm.SPEED), start, MOVES, dt)
        start = references[-1, 0]
    return references


class WorkingArm:
    """
    An arm without payload whose masses and frictions are off within their tolerances.

    robot: as described. dt: length of a sample, s. seed: of what is off, and of the noise of the
    encoders.

    drives: as their model files describe them.
    """

    def __init__(self, robot: RobotDescription, dt: float, seed: int,
                 growth: GapGrowth = GapGrowth()) -> None:
        self._dt, self._growth, self._rng = dt, growth, np.random.default_rng(seed)
        self._references, self._count = program(dt), 0
        self.drives: Sequence[DriveModel] = example_arm.nominal_drives(robot)
        self._plant = ArmPlant(
            example_arm.as_built(robot, self._rng, SPREAD),
            example_arm.drives_as_built(list(self.drives), self._rng), self._references[-1, 0])

    def run(self, n: int) -> MeasuredRun:
        """Work for `n` samples; the gap is that at their begin."""
        joint, factor = self._growth.joint, self._growth.factor(self._count * self._dt)
        drive, healthy = self._plant.drives[joint], self.drives[joint].transmission
        self._plant.drives[joint] = replace(drive, transmission=replace(
            drive.transmission, half_gap=factor * healthy.half_gap))
        rows = (self._count + np.arange(n)) % len(self._references)
        run = self._plant.run(self._references[rows], np.zeros(n), self._dt)
        self._count += n
        motor, arm = (true + example_arm.ENCODER * self._rng.normal(size=true.shape)
                      for true in (run.motor, run.arm))
        return MeasuredRun(run, motor, arm)
