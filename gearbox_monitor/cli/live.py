# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Show a running estimator in the browser: torque over twist, backlash, trust and alerts.

The command serves one page for all gearboxes of the node and draws it ten times per second. Only
this machine can open the page, unless --host names an address of the network: then everybody who
reaches that address can. With --foxglove it serves the topics to Foxglove instead of a page; open
config/foxglove.json as layout there. With --rerun it sends them to a Rerun viewer that is running.
ROS arguments, such as remappings, follow --ros-args.

usage examples:
  gearbox_monitor live
  gearbox_monitor live --port 9000 --estimator /left/estimator
  gearbox_monitor live --foxglove
  gearbox_monitor live --rerun
  gearbox_monitor live --ros-args -r __ns:=/left
"""
import argparse
from argparse import ArgumentParser, Namespace
import importlib.util
import re

from gearbox_monitor.cli.ros_option import add_ros_option, rclpy_required, ros_words
from gearbox_monitor.errors import InputError, installed_by

NODE_NAME = r'/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*'
PAGE_PORT, FOXGLOVE_PORT, RERUN_PORT = 8808, 8765, 9876


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('--host', metavar='ADDRESS', default='127.0.0.1',
                        help='address to listen on, with --rerun that of the viewer (default: '
                        '127.0.0.1, this machine only)')
    parser.add_argument('--port', type=_port, metavar='N',
                        help='port to listen on, 0: any that is free; with --rerun that of the '
                        f'viewer (default: {PAGE_PORT}, with --foxglove {FOXGLOVE_PORT}, with '
                        f'--rerun {RERUN_PORT})')
    parser.add_argument('--estimator', metavar='NODE', default='estimator',
                        help='name of the estimator node (default: estimator)')
    viewer = parser.add_mutually_exclusive_group()
    viewer.add_argument('--foxglove', action='store_true',
                        help='serve Foxglove instead of a page; needs the extra [foxglove]')
    viewer.add_argument('--rerun', action='store_true',
                        help='send to a Rerun viewer instead; needs the extra [rerun]')
    add_ros_option(parser)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    words = ros_words(args)
    if not re.fullmatch(NODE_NAME, args.estimator):
        raise InputError(f'--estimator: {args.estimator!r}, expected the name of a node, such as '
                         'estimator or /left/estimator')
    if args.foxglove:
        _require('--foxglove', 'foxglove', 'foxglove-sdk')
        with rclpy_required():
            from gearbox_monitor.ros import foxglove_node
        return foxglove_node.serve(args.host, _port_of(args, FOXGLOVE_PORT), words)
    if args.rerun:
        _require('--rerun', 'rerun', 'rerun-sdk')
        with rclpy_required():
            from gearbox_monitor.ros import rerun_node
        return rerun_node.serve(args.host, _port_of(args, RERUN_PORT), words)
    with rclpy_required():
        from gearbox_monitor.ros import live_node
    return live_node.serve(args.host, _port_of(args, PAGE_PORT), args.estimator, words)


def _port_of(args: Namespace, default: int) -> int:
    """Return the port of `args`, or `default`."""
    return default if args.port is None else int(args.port)


def _require(option: str, module: str, package: str) -> None:
    """Raise InputError if `module`, which `option` needs, is not installed."""
    if importlib.util.find_spec(module) is None:
        raise InputError(f'{option}: {package} is not installed, expected '
                         f'{installed_by(module)}')


def _port(text: str) -> int:
    value = int(text) if text.isdecimal() else -1
    if not 0 <= value <= 65535:
        raise argparse.ArgumentTypeError(f'{text!r}, expected a whole number from 0 to 65535')
    return value
