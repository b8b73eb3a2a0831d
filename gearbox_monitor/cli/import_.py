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
Convert a recording into a bag: text, .mat, JSON, HDF5, NumPy, Parquet or Feather, gzipped or not.

A mapping file names column or field, unit, sign and encoder zero of each signal. Packaged mappings
go by name: davinci_backend, emps, bam_servo_pendulum; their files in config/import show most keys
at work. --guess proposes a mapping from names, units and the motion itself; without BAG it prints
this mapping, to be edited.

The bag holds joint_states with the joints motor and arm (NaN = not measured). A reference torque
goes to reference/transmission_state, never into the estimator's input.

With --params, FILE is a bag whose motor and arm came on two topics: those of the estimator's
parameters arm_topic and pair_tolerance. They are joined as the live estimator does it, and the new
bag has paired_joint_states, which all commands take.

usage examples:
  gearbox_monitor import davinci_backend/00.TXT.gz --map davinci_backend run00
  gearbox_monitor import test_bench.csv --map my_bench.yaml bench
  gearbox_monitor import run7.csv --map my_bench.yaml --set signals.arm_position.zero=812 bench7
  gearbox_monitor import test_bench.csv --guess > my_bench.yaml    # then: look, edit, use it
  gearbox_monitor import two_topics --params joint3.yaml one_topic
  gearbox_monitor check bench                     # then: its contents, and what it suits
"""
from argparse import Action, ArgumentParser, Namespace
import json
from pathlib import Path
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import load_parameters
from gearbox_monitor.parameters import resolve, SETTINGS
from gearbox_monitor.plant.drive import DriveModel


class _Guess(Action):
    """Set the option, with which BAG need not follow."""

    def __call__(self, parser: ArgumentParser, namespace: Namespace, values: Any,
                 option_string: str | None = None) -> None:
        setattr(namespace, self.dest, True)
        for action in parser._actions:
            if action.dest == 'bag':
                action.required = False


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('file', metavar='FILE', help='recording, or with --params a bag')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--map', metavar='MAP',
                        help='mapping file, or the name of a packaged mapping')
    source.add_argument('--guess', action=_Guess, nargs=0, default=False,
                        help='propose a mapping; without BAG, print it and write nothing')
    source.add_argument('--params', metavar='PARAMS',
                        help='FILE is a bag: ROS parameter file of the estimator with arm_topic')
    parser.add_argument('--set', metavar='KEY=VALUE', action='append', default=[],
                        help='replace a value of the mapping, as gear_ratio=50; repeatable')
    parser.add_argument('--topic', default='joint_states',
                        help='with --params: topic of the motor')
    parser.add_argument('bag', metavar='BAG', help='bag to write; must not exist')
    parser.add_argument('--json', action='store_true', help='print what was written as JSON')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    from gearbox_monitor.bag.importer import load_mapping, read_recording, write_imported_bag
    if args.bag is not None and Path(args.bag).exists():
        raise InputError(f'{args.bag}: exists, expected the name of a new bag')
    if args.params:
        return _pair(args)
    assumptions: tuple[str, ...] = ()
    if args.guess:
        from gearbox_monitor.bag.importer.guess import guessed_mapping
        guess = guessed_mapping(args.file, args.set)
        if args.bag is None:
            print(guess.yaml_text, end='')
            return 0
        mapping, assumptions = guess.mapping(), guess.assumptions
    else:
        mapping = load_mapping(args.map, args.set)
    recording = read_recording(args.file, mapping)
    write_imported_bag(recording, args.bag, args.file, mapping)
    n = len(recording.stamp_ns)
    duration = (recording.stamp_ns[-1] - recording.stamp_ns[0]) * 1e-9
    signals = list(mapping.signals)
    signals += list(mapping.second_file.mapping.signals) if mapping.second_file else []
    data = {'bag': args.bag, 'samples': n, 'duration_s': duration, 'rate_hz': (n - 1) / duration,
            'signals': signals, 'assumptions': list(assumptions),
            'notes': list(recording.notices)}
    if args.json:
        print(json.dumps(data, indent=2))
        return 0
    for assumption in assumptions:
        print(f'assumed: {assumption}')
    print(f'{args.bag}: {n} samples, {duration:.3f} s, {data["rate_hz"]:.1f} Hz, signals '
          f'{", ".join(signals)}')
    for notice in recording.notices:
        print(f'note: {notice}')
    return 0


def _pair(args: Namespace) -> int:
    """Join motor and arm of a bag; return the exit code."""
    from gearbox_monitor.bag.paired_bag import write_paired
    from gearbox_monitor.bag.read import open_bag
    options = load_parameters(args.params, 'estimator', SETTINGS, args.topic)
    _, parameters = resolve(DriveModel(), options, args.params)
    with open_bag(args.file) as reader:
        topic, count, joiner = write_paired(reader, args.bag, parameters, args.topic)
        notice = reader.notice
    data = {'bag': args.bag, 'topic': topic, 'samples': count,
            'motor_without_arm': joiner.unpaired, 'arm_without_motor': joiner.dropped,
            'pair_tolerance_s': parameters.pair_tolerance,
            'notes': [notice] if notice else []}
    nearest = joiner.pop_distance()
    if nearest is not None:
        data['nearest_unpaired_s'] = nearest * 1e-9
    if args.json:
        print(json.dumps(data, indent=2))
        return 0
    print(f'{args.bag}: {count} samples on {topic}, {joiner.unpaired} without the arm; '
          f'{joiner.dropped} messages of the arm omitted'
          + (f'; the nearest unpaired stamps are {nearest * 1e-9:.6f} s apart, '
             f'pair_tolerance is {parameters.pair_tolerance:g} s' if nearest else ''))
    for note in data['notes']:
        print(f'note: {note}')
    return 0
