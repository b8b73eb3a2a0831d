# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Estimate and record; with plant:=true beside a simulated drive.

  ros2 launch gearbox_monitor monitor.launch.py params_file:=joint3.yaml model:=joint3_drive.yaml
  ros2 launch gearbox_monitor monitor.launch.py plant:=true record:=false
"""
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

YES_NO = ['true', 'false']
ARGUMENTS = [
    DeclareLaunchArgument('namespace', default_value='', description='namespace of all nodes'),
    DeclareLaunchArgument('joint_states', default_value='',
                          description='topic to take the joints from, like /joint_states; empty: '
                                      'joint_states in the namespace'),
    DeclareLaunchArgument('use_sim_time', default_value='false', choices=YES_NO,
                          description='take the time from /clock'),
    DeclareLaunchArgument(
        'params_file', default_value='',
        description='YAML parameter file with blocks estimator, recorder and plant; in a '
                    'namespace the blocks are called /NAMESPACE/estimator or /**. Empty: the '
                    'defaults, which config/*.yaml of this package show'),
    DeclareLaunchArgument('model', default_value='',
                          description='model file of the drive, for estimator and plant; empty: '
                                      "the parameter file's, else the packaged drive.yaml"),
    DeclareLaunchArgument('filter', default_value='',
                          description="name of the filter; empty: the parameter file's, else ekf"),
    DeclareLaunchArgument('record', default_value='true', choices=YES_NO,
                          description='record all topics into a bag'),
    DeclareLaunchArgument('bag', default_value='',
                          description='bag directory to create; empty: gearbox_DATE-TIME here'),
    DeclareLaunchArgument('plant', default_value='false', choices=YES_NO,
                          description='start a simulated drive, too'),
    DeclareLaunchArgument('enclave', default_value='',
                          description='security enclave above those of the nodes, like '
                                      '/gearbox_monitor, see docs/security.md; empty: none'),
    DeclareLaunchArgument('log_level', default_value='info',
                          description='debug, info, warn, error or fatal'),
]


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = {a.name: LaunchConfiguration(a.name).perform(context) for a in ARGUMENTS}

    remappings = [('joint_states', value['joint_states'])] if value['joint_states'] else []

    def node(name: str, settings: dict[str, str | bool], **options: Any) -> Node:
        parameters = [value['params_file']] if value['params_file'] else []
        overrides = {key: ParameterValue(setting, value_type=type(setting))
                     for key, setting in settings.items() if setting != ''}
        enclave = ['--enclave', f'{value["enclave"]}/{name}'] if value['enclave'] else []
        return Node(
            package='gearbox_monitor', executable=f'{name}_node', name=name,
            namespace=value['namespace'], output='screen', emulate_tty=True,
            parameters=parameters + ([overrides] if overrides else []), remappings=remappings,
            ros_arguments=['--log-level', value['log_level'], *enclave], **options)

    clock = {'use_sim_time': value['use_sim_time'] == 'true'}
    nodes = [node('estimator', {**clock, 'model': value['model'], 'filter': value['filter']},
                  on_exit=Shutdown(reason='the estimator has ended'))]
    if value['record'] == 'true':
        nodes.append(node('recorder', {**clock, 'output': value['bag']}))
    if value['plant'] == 'true':
        nodes.append(node('plant', {'model': value['model']}))
    return nodes
