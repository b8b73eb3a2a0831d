# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Show a robot in the browser: its joints and load (watch), torque, backlash and trust (estimator).

The command serves one page for both nodes and draws it up to ten times per second. Only
this machine can open the page, unless --host names an address of the network: then everybody who
reaches that address can. ROS arguments, such as remappings, follow --ros-args.

usage examples:
  gearbox_monitor live
  gearbox_monitor live --port 9000 --estimator /left/estimator
  gearbox_monitor live --ros-args -r __ns:=/left
"""
from argparse import ArgumentTypeError, Namespace
import re

from gearbox_monitor.errors import InputError, installed_by

NODE_NAME = r'/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*'


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for option in ('estimator', 'watch'):
        if not re.fullmatch(NODE_NAME, name := getattr(args, option)):
            raise InputError(f'--{option}: {name!r}, expected the name of a node, such as '
                             f'{option} or /left/{option}')
    try:
        from gearbox_monitor.ros import live_node
    except ImportError as error:
        raise InputError(f'rclpy: not installed here ({error}), expected a sourced ROS 2 or '
                         f'{installed_by("ros")}') from None
    return live_node.serve(args.host, args.port, (args.estimator, args.watch),
                           ['--ros-args', *args.ros_args] if args.ros_args else [])


def port(text: str) -> int:
    """Return the port in `text`. Raises ArgumentTypeError."""
    value = int(text) if text.isdecimal() else -1
    if not 0 <= value <= 65535:
        raise ArgumentTypeError(f'{text!r}, expected a whole number from 0 to 65535')
    return value
