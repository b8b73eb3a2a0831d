# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate an arm of six joints and publish the readings of its sensors: the node ``arm_plant``.

Publishes joint_states (measured positions of motors and arms, and the torques in force from that
stamp on) and plant/transmission_state (the truth, same stamps). The arm is that of
config/arm6.urdf; it repeats a program while the gap of one joint may grow. Parameters are those of
parameters.ARM_PLANT.
"""
from collections.abc import Iterator, Sequence
import math
import sys
from typing import Any

import numpy as np

from gearbox_monitor.files.opening import config_path, load_robot
from gearbox_monitor.parameters import ARM_PLANT, ArmPlantParameters
from gearbox_monitor.robot.arm_plant import GapGrowth, WorkingArm
from gearbox_monitor.ros.paced_node import declare, PacedNode
from gearbox_monitor.ros.runtime import spin_node


class ArmPlantNode(PacedNode):
    """An arm in real time."""

    def __init__(self) -> None:
        super().__init__('arm_plant')
        v = ArmPlantParameters.from_mapping(declare(self, ARM_PLANT))
        self.set_pace(v.rate, v.duration, v.wait_for_subscribers)
        robot = load_robot(str(config_path('arm6.urdf')))
        growth = GapGrowth(v.faulty_joint - 1, v.gap_growth_rate, v.gap_growth_start)
        WorkingArm(robot, self.dt, v.seed).run(2)  # loads kernels
        self._arm = WorkingArm(robot, self.dt, v.seed, growth)
        self._no_load = [math.nan] * len(robot.joints)
        self.begin([*(f'motor{k + 1}' for k in range(len(robot.joints))), *robot.joints],
                   list(robot.joints))
        self.warn_of_unknown()
        self.get_logger().info(f'{v.rate:g} Hz, {len(robot.joints)} joints, seed {v.seed}')

    def simulate(self, n: int) -> Iterator[tuple[Any, ...]]:
        """Return n rows (position, effort, twist, tau_k), lists with a value for each joint."""
        run = self._arm.run(n)
        return zip(np.hstack([run.motor, run.arm]).tolist(), run.true.u.tolist(),
                   (run.true.motor - run.true.arm).tolist(), run.true.tau_k.tolist())

    def send(self, row: tuple[Any, ...]) -> None:
        """Publish a `row` of `simulate`."""
        position, effort, twist, tau_k = row
        self.publish({'position': position, 'effort': effort + self._no_load},
                     {'position': twist, 'effort': tau_k})


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(ArmPlantNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
