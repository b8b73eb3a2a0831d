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
Convert a recording into a bag: CSV-like text, .mat or JSON, gzipped or not.

A mapping file names column or field, unit, sign and encoder zero of each signal. Packaged mappings
go by name: davinci_backend, emps, bam_servo_pendulum; their files in
config/import show every key at work.

The bag holds joint_states with the joints motor and arm (NaN = not measured). A reference torque
goes to reference/transmission_state, never into the estimator's input.

With --params, FILE is a bag whose motor and arm came on two topics: those of the estimator's
parameters arm_topic and pair_tolerance. They are joined as the live estimator does it, and the new
bag has paired_joint_states, which all commands take.

usage examples:
  gearbox_monitor import davinci_backend/00.TXT.gz --map davinci_backend run00
  gearbox_monitor import test_bench.csv --map my_bench.yaml bench
  gearbox_monitor import two_topics --params joint3.yaml one_topic
  gearbox_monitor check bench                     # then: its contents, and what it suits
"""
from argparse import ArgumentParser, Namespace
import json
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import load_parameters
from gearbox_monitor.parameters import resolve, SETTINGS
from gearbox_monitor.plant.drive import DriveModel


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('file', metavar='FILE', help='recording: text, .mat or JSON; or a bag')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--map', metavar='MAP',
                        help='mapping file, or the name of a packaged mapping')
    source.add_argument('--params', metavar='PARAMS',
                        help='FILE is a bag: ROS parameter file of the estimator with arm_topic')
    parser.add_argument('--topic', default='joint_states',
                        help='with --params: topic of the motor')
    parser.add_argument('bag', metavar='BAG', help='bag to write; must not exist')
    parser.add_argument('--json', action='store_true', help='print what was written as JSON')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    from gearbox_monitor.bag.importer import load_mapping, read_recording, write_imported_bag
    if Path(args.bag).exists():
        raise InputError(f'{args.bag}: exists, expected the name of a new bag')
    if args.params:
        return _pair(args)
    mapping = load_mapping(args.map)
    recording = read_recording(args.file, mapping)
    write_imported_bag(recording, args.bag, args.file, mapping)
    n = len(recording.stamp_ns)
    duration = (recording.stamp_ns[-1] - recording.stamp_ns[0]) * 1e-9
    data = {'bag': args.bag, 'samples': n, 'duration_s': duration, 'rate_hz': (n - 1) / duration,
            'signals': list(mapping.signals), 'notes': list(recording.notices)}
    if args.json:
        print(json.dumps(data, indent=2))
        return 0
    print(f'{args.bag}: {n} samples, {duration:.3f} s, {data["rate_hz"]:.1f} Hz, signals '
          f'{", ".join(data["signals"])}')
    for notice in data['notes']:
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
