# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The gearboxes of an estimator node and their settings, from the parameters of the node."""
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
import re
import time
from typing import Any

from rclpy.node import Node
from std_msgs.msg import String

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.filter_setup import described
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.robot_files import load_robot, TOPIC
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.parameters import (
    ESTIMATOR, EstimatorParameters, FIXED, MODEL, ROBOT, RobotParameters, SETTINGS, Table)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.robot.description import parse, RobotDescription
from gearbox_monitor.ros.node_parameters import declare, TableNode
from gearbox_monitor.ros.qos import latched
from gearbox_monitor.ros.runtime import drain, subscribe_polled

# What two gearboxes may not share: names in messages, files of their own.
OWN = ('motor_joint', 'arm_joint', 'baseline_file', 'drift_state_file')
PATIENCE = 15.0  # s until a latched description of the robot must have come


@dataclass(frozen=True)
class GearboxSettings:
    """
    Settings of one gearbox.

    name: '' for the only one of a node; parameters; model: of its drive, with the values that
    `changed` {name: value} puts in place of those in `model_file`; robot: of robot_description.
    """

    name: str
    parameters: EstimatorParameters
    model: DriveModel
    model_file: str
    changed: Mapping[str, Any]
    robot: RobotDescription | None = None

    @property
    def prefix(self) -> str:
        """What precedes the names of its parameters on the node."""
        return f'{self.name}.' if self.name else ''

    def rows(self, table: Table) -> Table:
        """Return the rows of `table` under the names that they have on the node."""
        return tuple(replace(row, name=self.prefix + row.name) for row in table)


def declare_gearboxes(node: TableNode) -> list[GearboxSettings]:
    """
    Declare the parameters of all gearboxes on `node` and return their settings.

    Without `gearboxes` the node has one, without a name. Raises InputError that names the gearbox.
    """
    robots: dict[str, RobotDescription] = {}  # read once each
    names = RobotParameters.from_mapping(declare(node, ROBOT)).gearboxes
    if names == RobotParameters.gearboxes:
        return [_declared(node, '', {}, robots)]
    source = f'node {node.get_name()}: gearboxes'
    used = {row.name for row in SETTINGS + ROBOT} | {'use_sim_time', 'qos_overrides'}
    for k, name in enumerate(names):
        if not re.fullmatch(r'[A-Za-z][A-Za-z0-9_]*', name) or name in used or name in names[:k]:
            raise InputError(f'{source}: {name!r}, expected different names of letters, digits '
                             'and _ that are no parameters')
    common = declare(node, [replace(row, change=FIXED) for row in ESTIMATOR])
    gearboxes = [_declared(node, name, {**common, 'gearbox_serial': name}, robots)
                 for name in names]
    _expect_own(f'node {node.get_name()}', gearboxes)
    return gearboxes


def _declared(node: TableNode, name: str, common: Mapping[str, Any],
              robots: dict[str, RobotDescription]) -> GearboxSettings:
    """
    Declare the gearbox `name` with the defaults `common` {parameter: value}.

    robots: {robot_description: its robot} so far.
    """
    prefix = f'{name}.' if name else ''

    def declared(table: Sequence[Any]) -> dict[str, Any]:
        values = declare(node, [replace(row, name=prefix + row.name) for row in table])
        return {key.removeprefix(prefix): value for key, value in values.items()}

    parameters = EstimatorParameters.from_mapping(declared(
        [replace(row, default=common.get(row.name, row.default)) for row in ESTIMATOR]))
    with located(name):
        model_file = parameters.model or config_path('drive.yaml')
        model = load_model(model_file)
        source = parameters.robot_description if described(parameters) else ''
        if source and parameters.arm_topic:
            raise InputError(f'arm_topic: {parameters.arm_topic!r}, expected none with '
                             'robot_description: all joints come in one message')
        if source and source not in robots:
            robots[source] = _robot_of(node, source)
    changed = declared([replace(row, default=getattr(model, row.name)) for row in MODEL])
    return GearboxSettings(name, parameters, model.with_(**changed), str(model_file), changed,
                           robots.get(source))


def _robot_of(node: Node, source: str) -> RobotDescription:
    """
    Return the robot of the parameter robot_description of a `node`.

    source: its value, a file or topic:TOPIC. Waits for the topic. Raises InputError if it is no
    URDF, or does not come.
    """
    if not source.startswith(TOPIC):
        return load_robot(source)
    subscription = subscribe_polled(node, String, source.removeprefix(TOPIC), latched())
    topic = subscription.topic_name
    node.get_logger().info(f'waiting for the robot description on {topic}')
    try:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and node.context.ok():
            for message, _ in drain(subscription):
                return parse(message.data, topic)
            time.sleep(0.05)
    finally:
        node.destroy_subscription(subscription)
    raise InputError(f'robot_description: {topic}: nothing came in {PATIENCE:g} s, expected a '
                     'robot description, as robot_state_publisher gives it')


def _expect_own(source: str, gearboxes: Sequence[GearboxSettings]) -> None:
    """Raise InputError that begins with `source` for what `gearboxes` may not have in common."""
    for gearbox in gearboxes:
        if arm_topic := gearbox.parameters.arm_topic:
            raise InputError(f'{source}: {gearbox.name}.arm_topic: {arm_topic!r}, expected none '
                             'with several gearboxes: the arm comes with the motor')
    for key in OWN:
        owners: dict[str, str] = {}
        for gearbox in gearboxes:
            value = getattr(gearbox.parameters, key)
            if value and owners.setdefault(value, gearbox.name) != gearbox.name:
                raise InputError(f'{source}: {gearbox.name}.{key}: {value!r}, expected another '
                                 f'than that of {owners[value]}')


@contextmanager
def located(name: str) -> Iterator[None]:
    """Let an InputError name the gearbox `name`, if it has a name."""
    try:
        yield
    except InputError as error:
        if not name:
            raise
        raise InputError(f'{name}: {error}') from None
