# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Play a bag to a live estimator, in the time of the bag.

  ros2 launch gearbox_monitor replay.launch.py bag:=gearbox_bag rate:=2.0

To get the estimates of a bag quickly, without ROS, use: gearbox_monitor replay BAG.
"""
from launch import LaunchContext, LaunchDescription
from launch.actions import OpaqueFunction, Shutdown, TimerAction
from launch_ros.actions import Node

from gearbox_monitor.ros.launch_parts import (
    declared, FILTER, LOG_LEVEL, package_node, stated, typed)

LINGER = 1.5  # s
ARGUMENTS = declared(
    ('bag', None, 'bag directory or .mcap file to play'),
    ('rate', '1.0', 'times as fast as recorded'), ('loop', False, 'start again at the end'),
    ('namespace', '', 'namespace of the estimator: that of the recorded topics'),
    ('use_sim_time', True, 'take the time from /clock, which the player publishes'),
    ('params_file', '', 'YAML parameter file with the block estimator, in a namespace '
     '/NAMESPACE/estimator or /**; empty: the defaults'),
    ('model', '', "model file of the drive; empty: the parameter file's, else the packaged "
     'drive.yaml'), FILTER, LOG_LEVEL)


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    value = stated(context, ARGUMENTS)
    settings = {'use_sim_time': value['use_sim_time'] == 'true',
                'model': value['model'], 'filter': value['filter']}
    estimator = package_node(
        'estimator', value, [value['params_file'], typed(settings)], value['namespace'],
        on_exit=Shutdown(reason='the estimator has ended'))
    player = Node(
        package='gearbox_monitor', executable='gearbox_monitor', output='screen',
        emulate_tty=True, ros_arguments=['--log-level', value['log_level']],
        arguments=['play', value['bag'], '--rate', value['rate'],
                   *(['--loop'] if value['loop'] == 'true' else [])],
        on_exit=TimerAction(period=LINGER, actions=[Shutdown(reason='the bag has ended')]))
    return [estimator, player]
