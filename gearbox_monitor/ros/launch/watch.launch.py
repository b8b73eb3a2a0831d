# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Watch a robot as it is: its joint_states and robot_description; with plant:=true a simulated arm.

  ros2 launch gearbox_monitor watch.launch.py
"""
from launch import LaunchContext, LaunchDescription
from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from gearbox_monitor.ros.launch_parts import (
    declared, ENCLAVE, lasting, LOG_LEVEL, package_node, stated, typed)

ARGUMENTS = declared(
    ('namespace', '', 'namespace of the robot, with its joint_states and robot_description'),
    ('plant', False, 'start a simulated arm, too'),
    ('use_sim_time', False, 'take the time from /clock'),
    ('params_file', '', 'YAML parameter file with a block watch; empty: the defaults'), ENCLAVE,
    LOG_LEVEL)
ARM = {'encoders': 'arm', 'rate': 100.0, 'faulty_joint': 2}


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = stated(context, ARGUMENTS)

    clock, file = typed({'use_sim_time': value['use_sim_time'] == 'true'}), value['params_file']
    nodes = [package_node('watch', value, [file, clock], **lasting())]
    if value['plant'] == 'true':
        nodes.append(package_node('arm_plant', value, [ARM, file]))
    return nodes
