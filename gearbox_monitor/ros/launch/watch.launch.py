# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Watch a robot as it is: its joint_states and robot_description, nothing else.

  ros2 launch gearbox_monitor watch.launch.py
"""
from launch import LaunchContext, LaunchDescription
from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from gearbox_monitor.ros.launch_parts import (
    declared, ENCLAVE, lasting, LOG_LEVEL, package_node, stated, typed)

ARGUMENTS = declared(
    ('namespace', '', 'namespace of the robot, with its joint_states and robot_description'),
    ('use_sim_time', False, 'take the time from /clock'),
    ('params_file', '', 'YAML parameter file with a block watch; empty: the defaults'), ENCLAVE,
    LOG_LEVEL)


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = stated(context, ARGUMENTS)
    enclave = f'{value["enclave"]}/watch' if value['enclave'] else ''
    return [package_node('watch', value, [
        value['params_file'], typed({'use_sim_time': value['use_sim_time'] == 'true'})],
        value['namespace'], enclave, **lasting())]
