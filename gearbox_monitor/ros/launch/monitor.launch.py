# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Estimate and record; with plant:=true beside a simulated drive.

  ros2 launch gearbox_monitor monitor.launch.py params_file:=joint3.yaml model:=joint3_drive.yaml
  ros2 launch gearbox_monitor monitor.launch.py plant:=true record:=false
"""
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from gearbox_monitor.ros.launch_parts import (
    BAG, declared, ENCLAVE, FILTER, lasting, LOG_LEVEL, package_node, stated, typed)

ARGUMENTS = declared(
    ('namespace', '', 'namespace of all nodes'),
    ('joint_states', '', 'topic to take the joints from, like /joint_states; empty: joint_states '
     'in the namespace'),
    ('use_sim_time', False, 'take the time from /clock'),
    ('params_file', '', 'YAML parameter file with blocks estimator, recorder and plant; in a '
     'namespace the blocks are called /NAMESPACE/estimator or /**. Empty: the defaults, which '
     'config/*.yaml of this package show'),
    ('model', '', "model file of the drive, for estimator and plant; empty: the parameter file's, "
     'else the packaged drive.yaml'),
    FILTER, ('record', True, 'record all topics into a bag'), BAG,
    ('plant', False, 'start a simulated drive, too'), ENCLAVE, LOG_LEVEL)


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = stated(context, ARGUMENTS)
    remappings = [('joint_states', value['joint_states'])] if value['joint_states'] else []

    def node(name: str, settings: dict[str, str | bool], **options: Any) -> Node:
        return package_node(name, value, [value['params_file'], typed(settings)],
                            remappings=remappings, **options)

    clock = {'use_sim_time': value['use_sim_time'] == 'true'}
    nodes = [node('estimator', {**clock, 'model': value['model'], 'filter': value['filter']},
                  **lasting())]
    if value['record'] == 'true':
        nodes.append(node('recorder', {**clock, 'output': value['bag']}, **lasting()))
    if value['plant'] == 'true':
        nodes.append(node('plant', {'model': value['model']}))
    return nodes
