# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Watch a robot over recordings of joint_states: learn it, then say what changes, and its payload.

It is the fold of watch_node over bags. The description comes from the topic robot_description of
a bag, or from --model. With --state it goes on where the last run ended.

usage examples:
  gearbox_monitor watch monday tuesday
  gearbox_monitor watch today --state arm.watch
  gearbox_monitor watch BAG --model robot.urdf --out watch.html --json findings.json
"""
from argparse import ArgumentTypeError, Namespace
from pathlib import Path
import re

from gearbox_monitor.cli.main import UNDECIDED
from gearbox_monitor.cli.options import reading_of, show
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.files.knowledge_file import save_watch
from gearbox_monitor.files.user_files import expect_new_file, write_new
from gearbox_monitor.library.robot import watch_robot
from gearbox_monitor.report.watch_page import watch_page
from gearbox_monitor.report.watch_words import watch_data, watch_text


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_new_file(args.out)
    known = args.state if args.state and Path(args.state).exists() else None
    result = watch_robot(args.bag, args.model, state=known, topic=args.topic,
                         reading=reading_of(args))
    if args.state:
        save_watch(args.state, result)
    data = watch_data(result)
    if args.out:
        write_new(args.out, watch_page(data, result.description, f'Watch of {args.bag[-1]}'))
    show(args, data, lambda: watch_text(result))
    return UNDECIDED if result.level is None else int(result.level > 0)


NODE_NAME = r'/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*'


def live(args: Namespace) -> int:
    """
    Show a robot in the browser: joints and load (watch), torque, backlash and trust (estimator).

    The command serves one page for both nodes and draws it up to ten times per second. Only this
    machine can open the page, unless --host names an address of the network: then everybody who
    reaches that address can. ROS arguments, such as remappings, follow --ros-args.

    usage examples:
      gearbox_monitor live
      gearbox_monitor live --port 9000 --estimator /left/estimator
      gearbox_monitor live --ros-args -r __ns:=/left
    """
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
