# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate, estimate, record and check one gearbox whose backlash grows, on this machine only.

Plant, estimator and recorder run as separate ROS 2 nodes. At the end the recording is replayed and
compared, and DIR holds: bag/ (for gearbox_monitor replay, ros2 bag, mcap), demo.png, summary.json
and the log of each node. Ctrl-C ends early and leaves a readable bag.
If samples are lost at 1000 Hz, the run is repeated at 500 Hz, then at 250 Hz.

With --robot the plant is an arm of six joints that repeats a program. One estimator watches all
of its gearboxes, and the backlash of one joint grows. DIR then holds robot.yaml and a model file
of each joint instead of demo.png.

usage examples:
  gearbox_monitor demo
  gearbox_monitor demo --robot
  gearbox_monitor demo --no-fault --duration 60 --out healthy
  gearbox_monitor demo --json > summary.json
"""
from argparse import ArgumentParser, Namespace
import contextlib
import json
import sys

from gearbox_monitor.cli.demo_run import Demo, Interrupted, MIN_DURATION, ROBOT_MIN_DURATION
from gearbox_monitor.ros.middleware import ChildFailed, Interrupt, own_domain


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('--out', metavar='DIR',
                        help='directory to create (default: gearbox_demo_ and the time)')
    parser.add_argument('--robot', action='store_true',
                        help='an arm of six joints instead of one gearbox')
    parser.add_argument('--duration', metavar='S', type=float,
                        help=f'simulated time in s, at least {MIN_DURATION:g} (default: 30); '
                        f'with --robot {ROBOT_MIN_DURATION:g} (60)')
    parser.add_argument('--filter', metavar='F', default='ekf',
                        help='filter of the estimator (default: ekf)')
    parser.add_argument('--no-fault', action='store_true', help='keep the backlash constant')
    parser.add_argument('--json', action='store_true',
                        help='print the summary as JSON, and nothing else')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    output = sys.stdout
    # With --json, standard output gets nothing else: progress goes to standard error.
    with contextlib.redirect_stdout(sys.stderr if args.json else output), \
            Interrupt() as interrupt:
        try:
            demo = _demo(args, interrupt)
            with own_domain() as domain:
                demo.live_at_best_rate(domain)
            interrupt.at_once()
            demo.check_interrupt()
            data, text = demo.evaluate()
            print(json.dumps(data, indent=2) if args.json else text, file=output)
            for problem in data['problems']:
                print(f'problem: {problem}', file=sys.stderr)
            return 1 if data['problems'] else 0
        except Interrupted:
            print('interrupted', flush=True)
            return 130
        except ChildFailed as error:
            print(f'gearbox_monitor demo: {error}', file=sys.stderr)
            return int(error.code)


def _demo(args: Namespace, interrupt: Interrupt) -> Demo:
    """Return the demo that the options `args` choose; `interrupt` ends it early."""
    if not args.robot:
        return Demo(args, interrupt)
    from gearbox_monitor.cli.demo_run import RobotDemo
    return RobotDemo(args, interrupt)
