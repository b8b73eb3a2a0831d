# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Measure this package against its bars.

usage examples:
  gearbox_monitor benchmark paper --seeds 5
  gearbox_monitor benchmark speed
  gearbox_monitor benchmark trust --quick
  gearbox_monitor benchmark real path/to/davinci_backend
  gearbox_monitor benchmark real davinci_backend --split load --json
"""
import argparse
import importlib
from typing import Any

# name -> (module of gearbox_monitor.benchmarks, one line of help)
BENCHMARKS = {
    'paper': ('paper', "the paper's tables, by all filters, beside the published numbers"),
    'speed': ('speed', "CPU time of the filters' steps and of replay, beside filterpy, rosbags"),
    'trust': ('trust', 'false alarms of trust and drift, and how soon faults are detected'),
    'real': ('real', 'torque of a real drive against static current compensation'),
    'emps': ('emps', 'free run over a public test recording, beside published figures'),
    'bam': ('bam', 'servos by their setpoints, beside Better Actuator Models'),
    'wear': ('wear', 'backlash and its growth from the motor encoder alone'),
    'naming': ('naming', 'what changed between two recordings, named as after an alert'),
    'real_gap': ('real_gap', 'diagnosis of pairs of real logs whose truth stays sealed'),
    'blind': ('blind.runner', 'diagnosis of recordings whose effect only the scorer knows'),
}


class _LazyParser(argparse.ArgumentParser):
    """The parser of one benchmark, whose module is imported when its command line is parsed."""

    module = ''

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        if self.module:
            benchmark = importlib.import_module('gearbox_monitor.benchmarks.' + self.module)
            self.module = ''
            self.description = benchmark.__doc__
            benchmark.add_arguments(self)
            self.set_defaults(run_benchmark=benchmark.run)
        return super().parse_known_args(args, namespace)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add a subcommand for each of the BENCHMARKS to `parser`."""
    subparsers = parser.add_subparsers(dest='benchmark', metavar='NAME', required=True,
                                       parser_class=_LazyParser)
    for name, (module, summary) in BENCHMARKS.items():
        subparser = subparsers.add_parser(
            name, help=summary, formatter_class=argparse.RawDescriptionHelpFormatter)
        subparser.module = module


def run(args: argparse.Namespace) -> int:
    """Run the benchmark that `args` select; returns its exit code."""
    return args.run_benchmark(args)
