# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every kernel that a monitor calls, compiled or loaded before its first sample."""
import math

from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.health import elastic_regression
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.robot.description import RobotDescription

SECOND = 1_000_000_000


def warm_up(model: DriveModel, parameters: EstimatorParameters,
            robot: RobotDescription | None = None) -> None:
    """
    Compile every kernel before the node is ready: the first sample must not wait for it.

    model, parameters, robot: as of Monitor.
    """
    window = 0.5 if parameters.arm_joint else 4.0  # the shortest that is fitted
    monitor = Monitor(model, parameters.replace(drift_window=window), robot=robot)
    rest = tuple(0.0 for _ in monitor.estimator.robot_joints)
    if parameters.arm_joint:  # the fit of a window, which this motion does not excite
        elastic_regression.warm_up()
    for k in range(2200):  # 4.4 s: trust is judged from the third second on
        angle = 0.5 * math.sin(0.02 * k)
        monitor.step(Sample(SECOND + k * 2_000_000, (0.0, 0.0), (angle, -angle), rest))
