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
from argparse import Namespace
from pathlib import Path

from gearbox_monitor.cli.main import UNDECIDED
from gearbox_monitor.cli.options import reading_of, show
from gearbox_monitor.files.knowledge_file import save_watch
from gearbox_monitor.files.opening import write_new
from gearbox_monitor.files.yaml_files import expect_new_file
from gearbox_monitor.library.watch import watch_robot
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
