# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Play a bag to a live estimator, in the time of the bag.

  ros2 launch gearbox_monitor replay.launch.py bag:=gearbox_bag rate:=2.0

To get the estimates of a bag quickly, without ROS, use: gearbox_monitor replay BAG.
"""
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown, TimerAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# Time for the estimator to process the last samples of the bag.
LINGER = 1.5  # s
ARGUMENTS = [
    DeclareLaunchArgument('bag', description='bag directory or .mcap file to play'),
    DeclareLaunchArgument('rate', default_value='1.0',
                          description='times as fast as recorded'),
    DeclareLaunchArgument('loop', default_value='false', choices=['true', 'false'],
                          description='start again at the end'),
    DeclareLaunchArgument('namespace', default_value='',
                          description='namespace of the estimator: that of the recorded topics'),
    DeclareLaunchArgument('use_sim_time', default_value='true', choices=['true', 'false'],
                          description='take the time from /clock, which the player publishes'),
    DeclareLaunchArgument(
        'params_file', default_value='',
        description='YAML parameter file with the block estimator, in a namespace '
                    '/NAMESPACE/estimator or /**; empty: the defaults'),
    DeclareLaunchArgument('model', default_value='',
                          description="model file of the drive; empty: the parameter file's, else "
                                      'the packaged drive.yaml'),
    DeclareLaunchArgument('filter', default_value='',
                          description="name of the filter; empty: the parameter file's, else ekf"),
    DeclareLaunchArgument('log_level', default_value='info',
                          description='debug, info, warn, error or fatal'),
]


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = {a.name: LaunchConfiguration(a.name).perform(context) for a in ARGUMENTS}
    settings = {'use_sim_time': value['use_sim_time'] == 'true',
                'model': value['model'], 'filter': value['filter']}
    overrides = {key: ParameterValue(setting, value_type=type(setting))
                 for key, setting in settings.items() if setting != ''}
    parameters = [value['params_file']] if value['params_file'] else []
    level = ['--log-level', value['log_level']]
    estimator = Node(
        package='gearbox_monitor', executable='estimator_node', name='estimator',
        namespace=value['namespace'], output='screen', emulate_tty=True,
        parameters=[*parameters, overrides], ros_arguments=level,
        on_exit=Shutdown(reason='the estimator has ended'))
    player = Node(
        package='gearbox_monitor', executable='gearbox_monitor', output='screen',
        emulate_tty=True, ros_arguments=level,
        arguments=['play', value['bag'], '--rate', value['rate'],
                   *(['--loop'] if value['loop'] == 'true' else [])],
        on_exit=TimerAction(period=LINGER, actions=[Shutdown(reason='the bag has ended')]))
    return [estimator, player]
