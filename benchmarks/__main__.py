# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Measure this package against its bars.

usage examples:
  python -m benchmarks paper --seeds 5
  python -m benchmarks speed
  python -m benchmarks trust --quick
  python -m benchmarks real path/to/davinci_backend
  python -m benchmarks real davinci_backend --split load --json
"""
import argparse
from collections.abc import Sequence
import importlib
import os
import sys
from typing import Any

from gearbox_monitor.cli.main import exit_code_text, OneLineParser, parsed_whole, run_parsed

EXIT_CODES = {0: 'all bars are met', 1: 'a bar is missed'}
# name -> (module of benchmarks, one line of help)
BENCHMARKS = {
    'paper': ('paper', "the paper's tables, by all filters, beside the published numbers"),
    'speed': ('speed', "CPU time of the filters' steps and of replay, beside filterpy, rosbags"),
    'trust': ('trust', 'false alarms of trust and drift, and how soon faults are detected'),
    'real': ('real', 'torque of a real drive against static current compensation'),
    'emps': ('emps', 'free run over a public test recording, beside published figures'),
    'bam': ('bam', 'servos by their setpoints, beside Better Actuator Models'),
    'wear': ('wear', 'backlash and its growth from the motor encoder alone'),
    'watch': ('watch_robots', 'watch of random arms: false alarms, changes in the right joint'),
    'histories': ('histories', 'wear over drawn histories: pairs of events, jumps, health'),
    'naming': ('naming', 'what changed between two recordings, named as after an alert'),
    'real_gap': ('real_gap', 'diagnosis of pairs of real logs whose truth stays sealed'),
    'actuators': ('actuators', 'an entry of the catalogue of actuators from public recordings'),
    'startup': ('startup', 'CPU time of first commands'),
    'robot_cost': ('robot_cost', 'CPU time and memory of the diagnosis of whole robots'),
    'ranges': ('ranges', 'how often new simulated drives lie in the ranges of others'),
    'closed_loop': ('closed_loop', 'a controller tuned in a corrected simulator, in the true one'),
    'traces': ('traces', 'what ten small recordings give, beside what they gave before'),
    'blind': ('blind.runner', 'diagnosis of recordings whose effect only the scorer knows'),
}


class _LazyParser(OneLineParser):
    """The parser of one benchmark, whose module is imported when its command line is parsed."""

    module = ''

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        if self.module:
            benchmark = importlib.import_module('benchmarks.' + self.module)
            self.module = ''
            self.description = benchmark.__doc__
            benchmark.add_arguments(self)
            self.set_defaults(run=benchmark.run)
        return super().parse_known_args(args, namespace)


def _parse(argv: Sequence[str]) -> argparse.Namespace:
    """Return the parsed `argv`; only the module of the selected benchmark is imported."""
    # Small matrices, and fits in own threads: threads of BLAS would only slow them down.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    parser = OneLineParser(
        prog='python -m benchmarks', description=__doc__, epilog=exit_code_text(EXIT_CODES),
        formatter_class=argparse.RawDescriptionHelpFormatter)
    subparsers = parser.add_subparsers(dest='benchmark', metavar='NAME', required=True,
                                       parser_class=_LazyParser)
    for name, (module, summary) in BENCHMARKS.items():
        subparser = subparsers.add_parser(
            name, help=summary, formatter_class=argparse.RawDescriptionHelpFormatter)
        subparser.module = module
    return parsed_whole(parser, subparsers, argv)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one benchmark with `argv`, or the arguments of the process; returns its exit code."""
    words = sys.argv[1:] if argv is None else argv
    return run_parsed('python -m benchmarks', lambda: _parse(words))


if __name__ == '__main__':
    sys.exit(main())
