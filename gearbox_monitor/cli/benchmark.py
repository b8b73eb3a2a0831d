# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Measure this package against its bars. Ends with exit code 1 when a bar is missed.

usage examples:
  gearbox_monitor benchmark paper --seeds 5
  gearbox_monitor benchmark speed
  gearbox_monitor benchmark trust --quick
  gearbox_monitor benchmark real path/to/davinci_backend
  gearbox_monitor benchmark real davinci_backend --split load --json
"""
import argparse
import importlib

# name -> (module of gearbox_monitor.benchmarks, one line of help)
BENCHMARKS = {
    'paper': ('paper', "the paper's tables, by all filters, beside the published numbers"),
    'speed': ('speed', "CPU time of the filters' steps and of replay, beside filterpy, rosbags"),
    'scale': ('scale', 'CPU time and memory against length and number of bags, and of candidates'),
    'trust': ('trust', 'false alarms of trust and drift, and how soon faults are found'),
    'faults': ('faults', 'bad streams of samples: is it told, what is lost, how soon all is well'),
    'recorder': ('recorder', 'recorders killed, power and disks lost: all but one second is kept'),
    'load': ('load', 'live estimators: drops, latency and CPU against rate and number'),
    'soak': ('soak', 'a long run of a live estimator: memory, handles, rate, false alerts'),
    'restart': ('restart', 'live nodes stopped and started at any time: residue, state'),
    'fuzz': ('fuzz', 'damaged files of every kind: read or refused in one line, never a crash'),
    'blind': ('blind', 'diagnosis of recordings whose effect only the scorer knows'),
    'fleet': ('fleet', 'CPU time of fleet runs: pool, Dask, number of bags, workers'),
    'motion': ('motion', 'motions that separate what a recording confused'),
    'real': ('real', 'torque of a real drive against static current compensation'),
}


def add_arguments(parser):
    subparsers = parser.add_subparsers(dest='benchmark', metavar='NAME', required=True)
    for name, (module, summary) in BENCHMARKS.items():
        benchmark = importlib.import_module('gearbox_monitor.benchmarks.' + module)
        sub = subparsers.add_parser(
            name, help=summary, description=benchmark.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter)
        benchmark.add_arguments(sub)
        sub.set_defaults(run_benchmark=benchmark.run)


def run(args):
    return args.run_benchmark(args)
