# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Publish a bag to live nodes, with /clock, as "ros2 bag play --clock" would.

Without --topics the inputs are played: joint_states and, of a simulated drive, the truth
plant/transmission_state. Nodes that follow this clock need use_sim_time:=true. ROS arguments, such
as remappings, follow --ros-args.

usage examples:
  gearbox_monitor play gearbox_bag
  gearbox_monitor play gearbox_bag --rate 5 --loop
  gearbox_monitor play gearbox_bag --topics joint_states --ros-args -r joint_states:=/arm/states
"""
import argparse
from argparse import ArgumentParser, Namespace
import math

from gearbox_monitor.cli.options import add_ros_option, rclpy_required, ros_words


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('bag', metavar='BAG', help='bag directory or .mcap file')
    parser.add_argument('--rate', type=_rate, default=1.0, metavar='R',
                        help='times as fast as recorded (default: 1)')
    selection = parser.add_mutually_exclusive_group()
    selection.add_argument('--topics', nargs='+', metavar='TOPIC', help='play these topics')
    selection.add_argument('--all', action='store_true',
                           help="play all topics, the estimator's own included")
    parser.add_argument('--loop', action='store_true', help='restart at the end')
    parser.add_argument('--no-clock', action='store_true', help='do not publish /clock')
    add_ros_option(parser)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    with rclpy_required():
        from gearbox_monitor.ros.playback import play
    code: int = play(args.bag, args.rate, args.topics, args.all, args.loop, not args.no_clock,
                     ros_words(args))
    return code


def _rate(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and 0 < value <= 1e6):
        raise argparse.ArgumentTypeError(f'{text!r}, expected a number > 0 and <= 1e6')
    return value
