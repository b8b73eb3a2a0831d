# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Repair a truncated bag: after kill -9, a power cut, on a full disk or a damaged medium.

All readable messages go to a new bag with index and metadata.yaml, unchanged: times, sequence
numbers, bytes, order, definitions, quality of service. The new bag gets its name only after it has
been read and compared. BAG itself is only read. For a complete bag nothing is written. MCAP only;
attachments, which rosbag2 does not write, are omitted. docs/recorder.md lists the losses of each
accident.

usage examples:
  gearbox_monitor recover gearbox_2026_11_21-10_00_00
  gearbox_monitor recover cut.mcap --out /media/usb/rescued
  gearbox_monitor recover BAG --json | jq .lost.seconds
"""
from argparse import Namespace
from collections.abc import Iterable, Mapping
import os
from pathlib import Path
from typing import Any

from gearbox_monitor.cli.options import show
from gearbox_monitor.errors import InputError
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.recordings.recovery import recover, Recovery

UNWRITTEN = ('Messages that the recorder had not written when it ended are not counted; this '
             "package's recorder writes every 0.25 s.")


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    source = Path(os.path.abspath(args.bag))
    if args.out == '':
        raise InputError("--out: '' is empty, expected the name of a new bag directory")
    name = source.stem if source.suffix == '.mcap' else source.name
    out = Path(args.out) if args.out else source.with_name(f'{name}_recovered')

    def progress(parts: Iterable[Any]) -> Any:
        """Show the progress through parts."""
        listed = list(parts)
        with count_bar('recover', len(listed)) as bar:
            for part in listed:
                yield part
                bar.update()

    recovery = recover(args.bag, out, progress)
    data = as_data(args.bag, recovery)
    show(args, data, lambda: as_text(data))
    return 0


def as_data(bag: str, recovery: Recovery) -> dict[str, Any]:
    """Return the `recovery` of `bag` as plain data."""
    topics = recovery.topics.values()
    return {
        'bag': str(bag), 'written': recovery.written and str(recovery.written),
        'notes': recovery.notes, 'cut': recovery.cut,
        'kept': {'seconds': recovery.recovered_s,
                 'messages': sum(topic.recovered for topic in topics)},
        'lost': {'seconds': recovery.lost_s, 'messages': sum(topic.lost for topic in topics)},
        'topics': [{
            'topic': name, 'type': topic.msgtype,
            'kept': {'seconds': topic.seconds, 'messages': topic.recovered},
            'lost': {'messages': topic.lost},
        } for name, topic in sorted(recovery.topics.items())]}


def as_text(data: Mapping[str, Any]) -> str:
    """Return the `data` of a recovery as lines for people."""
    if not data['written']:
        total = data['kept']
        return (f'{data["bag"]}: complete, {total["messages"]} messages in '
                f'{total["seconds"]:.3f} s; nothing to recover, nothing was written')
    width = max(len('all'), *(len(row['topic']) for row in data['topics']))
    kept, lost = data['kept'], data['lost']
    lines = [f'{data["written"]}: {kept["messages"]} messages in {kept["seconds"]:.3f} s are '
             f'rescued and read back; {lost["messages"]} are lost.', *data['notes'], '',
             f'{"topic":{width}s} {"kept":>10s} {"s":>10s} {"lost":>10s} {"s":>8s}']
    for row in [*data['topics'], {'topic': 'all', 'kept': kept, 'lost': lost}]:
        seconds = f'{row["lost"]["seconds"]:.3f}' if 'seconds' in row['lost'] else ''
        lines.append(f'{row["topic"]:{width}s} {row["kept"]["messages"]:10d} '
                     f'{row["kept"]["seconds"]:10.3f} {row["lost"]["messages"]:10d} {seconds:>8s}')
    return '\n'.join([*lines, *(['', UNWRITTEN] if data['cut'] else [])])
