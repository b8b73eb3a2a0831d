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
Make a whole bag of one that was cut: kill -9, power cut, full disk, damaged medium.

All messages that can be read go to a new bag with index and metadata.yaml, as they were: times,
sequence numbers, bytes, order, definitions, quality of service. It is read again, and has its name
only when it holds the same. BAG itself is only read. Of a whole bag nothing is written. MCAP
only; attachments, which rosbag2 does not write, are left out. docs/recorder.md says what is lost
in which accident.

usage examples:
  gearbox_monitor recover gearbox_2026_11_21-10_00_00
  gearbox_monitor recover cut.mcap --out /media/usb/rescued
  gearbox_monitor recover BAG --json | jq .lost.seconds

exit code: 0 the new bag is there or not needed, 2 bad usage or input, nothing was written.
"""
import json
import os
from pathlib import Path

from tqdm import tqdm

from gearbox_monitor.bag.recover import recover
from gearbox_monitor.errors import InputError

UNSEEN = 'What the recorder had not written yet when it ended is not counted; ours waits 0.25 s.'


def add_arguments(parser):
    """Declare the options."""
    parser.add_argument('bag', metavar='BAG', help='bag directory or .mcap file')
    parser.add_argument('--out', metavar='DIR', help='bag to write; must not exist '
                        '(default: BAG_recovered)')
    parser.add_argument('--json', action='store_true', help='print kept and lost as JSON')


def run(args):
    """Run the command; returns the exit code."""
    source = Path(os.path.abspath(args.bag))
    if args.out == '':
        raise InputError("--out: '' is empty, expected the name of a new bag directory")
    name = source.stem if source.suffix == '.mcap' else source.name
    out = Path(args.out) if args.out else source.with_name(f'{name}_recovered')

    def progress(parts):
        return tqdm(parts, desc='recover', unit=' chunks', disable=None, leave=False)

    found = recover(args.bag, out, progress)
    print(json.dumps(as_data(args.bag, found), indent=2) if args.json else
          as_text(args.bag, found))
    return 0


def as_data(bag, found):
    """Return the Recovery `found` of `bag` as plain data."""
    topics = found.topics.values()
    return {
        'bag': str(bag), 'written': found.written and str(found.written), 'notes': found.notes,
        'cut': found.cut,
        'kept': {'seconds': found.kept_s, 'messages': sum(topic.kept for topic in topics)},
        'lost': {'seconds': found.lost_s, 'messages': sum(topic.lost for topic in topics),
                 'about': any(topic.about for topic in topics)},
        'topics': [{
            'topic': name, 'type': topic.msgtype,
            'kept': {'seconds': (topic.last_ns - topic.first_ns) * 1e-9 if topic.kept else 0.0,
                     'messages': topic.kept},
            'lost': {'seconds': topic.lost * topic.period if topic.period else None,
                     'messages': topic.lost, 'about': topic.about},
        } for name, topic in sorted(found.topics.items())]}


def as_text(bag, found):
    """Return what as_data gives as lines for people."""
    data = as_data(bag, found)
    if not data['written']:
        kept = data['kept']
        return (f'{bag}: whole, {kept["messages"]} messages in {kept["seconds"]:.3f} s; nothing '
                'to recover, nothing was written')
    width = max(len('all'), *(len(row['topic']) for row in data['topics']))
    lines = [*data['notes'], '',
             f'{"topic":{width}s} {"kept":>10s} {"s":>10s} {"lost":>14s} {"s":>8s}']
    rows = [*data['topics'], {'topic': 'all', 'kept': data['kept'], 'lost': data['lost']}]
    for row in rows:
        lost = row['lost']
        count = ('about ' if lost['about'] else '') + str(lost['messages'])
        seconds = '-' if lost['seconds'] is None else f'{lost["seconds"]:.3f}'
        lines.append(f'{row["topic"]:{width}s} {row["kept"]["messages"]:10d} '
                     f'{row["kept"]["seconds"]:10.3f} {count:>14s} {seconds:>8s}')
    return '\n'.join([*lines, '', *([UNSEEN] if found.cut else []),
                      f'{data["written"]}: written, read again, the same messages'])
