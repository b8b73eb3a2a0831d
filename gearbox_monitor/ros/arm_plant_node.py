# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate an arm of six joints and publish the readings of its sensors: the node ``arm_plant``.

Publishes joint_states (measured positions and the torques in force from that stamp on),
robot_description (config/arm6.urdf) and plant/transmission_state (the truth, same stamps). The arm
repeats a program while the gap of one joint may grow. Parameters are those of
parameters.ARM_PLANT; payload and rubbing can be changed while it runs.
"""
from collections.abc import Iterator, Mapping, Sequence
import math
import sys
from typing import Any

from std_msgs.msg import String

from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.parameters import ARM_PLANT, ArmPlantParameters
from gearbox_monitor.recordings.topics import ROBOT_DESCRIPTION
from gearbox_monitor.robot.arm_plant import GapGrowth, WorkingArm
from gearbox_monitor.ros.plant_node import PacedNode
from gearbox_monitor.ros.runtime import advertise, declare, latched, on_change, spin_node


class ArmPlantNode(PacedNode):
    """An arm in real time."""

    def __init__(self) -> None:
        super().__init__('arm_plant')
        v = self._values = ArmPlantParameters.from_mapping(declare(self, ARM_PLANT))
        self.set_pace(v.rate, v.duration, v.wait_for_subscribers)
        path = config_path('arm6.urdf')
        robot = load_robot(str(path))
        growth = GapGrowth(v.faulty_joint - 1, v.gap_growth_rate, v.gap_growth_start)
        WorkingArm(robot, self.dt, v.seed).run(2)  # loads kernels
        self._arm = WorkingArm(robot, self.dt, v.seed, growth)
        motors = [f'motor{k + 1}' for k in range(len(robot.joints))]
        self._no_load = [math.nan] * len(motors)
        on_change(self, ARM_PLANT, self._change)
        self._description = advertise(self, String, ROBOT_DESCRIPTION, latched())
        self._description.publish(String(data=path.read_text(encoding='utf-8')))
        self.begin([*(motors if v.encoders == 'both' else []), *robot.joints], list(robot.joints))
        self.warn_of_unknown()
        self.get_logger().info(f'{v.rate:g} Hz, {len(robot.joints)} joints, seed {v.seed}')

    def _change(self, changes: Mapping[str, object]) -> None:
        self._values = self._values.replace(**changes)

    def simulate(self, n: int) -> Iterator[tuple[Any, ...]]:
        """Return n rows (motor, arm, effort, twist, tau_k), lists with a value for each joint."""
        run = self._arm.run(n, self._values.payload, self._values.rubbing)
        return zip(run.motor.tolist(), run.arm.tolist(), run.true.u.tolist(),
                   (run.true.motor - run.true.arm).tolist(), run.true.tau_k.tolist())

    def send(self, row: tuple[Any, ...]) -> None:
        """Publish a `row` of `simulate`."""
        motor, arm, effort, twist, tau_k = row
        self.publish({'position': arm, 'effort': effort} if self._values.encoders == 'arm' else
                     {'position': motor + arm, 'effort': effort + self._no_load},
                     {'position': twist, 'effort': tau_k})


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(ArmPlantNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
