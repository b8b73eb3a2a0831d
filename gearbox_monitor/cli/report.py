# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write one page about a recording: the state of the gearbox, and the trust in its estimates.

One HTML file that loads nothing, for a screen, a phone or paper: torque over twist minute by
minute, backlash with alarms, prediction errors with two sigma, NIS, levels of trust over time,
rate and dropouts of the input, parameters and versions. Drag in a chart to zoom.

The estimator is run on the recorded samples, from its recorded snapshots on, as replay does;
--model, --params and --filter replace what is recorded. Signals over time are thinned to envelopes
of lowest and highest value, so that an hour makes a page of some MB.

A recording of several gearboxes gets a page of the robot, one row per joint, the worst first, and
a page of each joint. --topic GEARBOX writes the page of one joint alone; of a bag
without estimates that is --topic joint_states/GEARBOX.

usage examples:
  gearbox_monitor report gearbox_2026_11_21-10_00_00
  gearbox_monitor report BAG --model drive.yaml --params joint3.yaml --out joint3.html
  gearbox_monitor report BAG --filter ukf --out ukf.html
  gearbox_monitor report BAG --json - | jq .gap_rad
"""
from argparse import Namespace

from gearbox_monitor.cli.options import reading_of, show, warn
from gearbox_monitor.library.recording_report import write_report


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    pages = write_report(args.bag, args.out, topic=args.topic, model=args.model,
                         parameters=args.params, filter=args.filter, reading=reading_of(args))
    warn(args, pages.notes)
    size = pages.page.stat().st_size / 1e6
    show(args, pages.figures,
         lambda: f'{pages.headline}\n{pages.page}: {size:.1f} MB, {pages.extent}')
    return 0
