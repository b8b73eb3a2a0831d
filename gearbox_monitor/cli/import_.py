# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a recording of any kind as a bag, or print how it is read.

All other commands read the same files by themselves; a bag is for ros2 and for keeping. A log's
columns are read by their names and units. A table on stderr says what became of each, and what
stays open is asked for, with the option that settles it (exit code 3). With --guess and without
BAG the mapping is printed, to be edited and used with --map, here or by another command.

A file with several joints becomes a bag with all of them: joint_states, and joint_setpoints where
setpoints are recorded. --joint selects one of a log, as joints motor and arm (NaN: no value). A
reference torque goes to reference/transmission_state, never into the estimator's input.

Of bags JointState, DynamicJointState and JointTrajectoryControllerState are read, of ROS 1 and 2.
With --arm-topic, or --params that state arm_topic, motor and arm come from two publishers: the new
bag has both in joint_states, joined as the live estimator does it.

usage examples:
  gearbox_monitor import davinci_backend/00.TXT.gz --map davinci_backend run00
  gearbox_monitor import run7.csv --map my_bench.yaml --set signals.arm_position.zero=812 bench7
  gearbox_monitor import test_bench.csv --guess > my_bench.yaml    # then: look, edit, use it
  gearbox_monitor import robot.csv --joint 3 --torque-constant 0.12 joint3
  gearbox_monitor import ur.csv --columns 't,q[6],dq[6],i[6]' --torque-constant 10,10,9,9,9,10 ur
  gearbox_monitor import old_robot.bag --stamps received robot
  gearbox_monitor import two_topics --params joint3.yaml one_topic
"""
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Container, Iterable, Mapping, Sequence
import hashlib
import os
from pathlib import Path
import shlex
import sys
from typing import Any

import yaml

from gearbox_monitor import __version__
from gearbox_monitor.cli.options import reading_of, show, stated, table_text
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_outside_of_bag, load_parameters
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.parameters import resolve, SETTINGS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.guess import Unsettled
from gearbox_monitor.recordings.read import BagReader, open_bag
from gearbox_monitor.recordings.reading import converted_bag, is_bag, paired_bag, read_mapping
from gearbox_monitor.recordings.si_signals import bag_of_table
from gearbox_monitor.recordings.write import BagWriter, recover, Recovery

# Options that not all ways of importing use.
OPTIONS = ('guess', 'map', 'set', 'joint_of_log', 'topic', 'use', 'unit', 'torque_constant',
           'counts_per_turn', 'columns', 'rate', 'episode', 'stamps')


class GuessOption(Action):
    """Set the option, with which BAG need not follow."""

    def __call__(self, parser: ArgumentParser, namespace: Namespace, values: Any,
                 option_string: str | None = None) -> None:
        setattr(namespace, self.dest, True)
        for action in parser._actions:
            if action.dest == 'bag':
                action.required = False


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    path = Path(args.file)
    if args.bag is not None:
        if Path(args.bag).exists():
            raise InputError(f'{args.bag}: exists, expected the name of a new bag')
        expect_outside_of_bag(args.bag)
    if args.params or args.arm_topic:
        _refuse_others(args, ('topic',), '--params or --arm-topic', '--topic')
        return _pair(args)
    if not path.exists():
        raise InputError(f'{path}: no such file, expected a bag or a log')
    if not is_bag(path):
        return _of_log(args, path)
    _refuse_others(args, ('topic', 'stamps', 'guess'), 'a bag as FILE', '--topic or --stamps '
                   '(commands read one joint with --recorded-motor NAME)')
    if args.bag is None:
        raise InputError(f'{path}: a bag, expected the name of a new bag behind it')
    return _written(args, converted_bag(path, args.topic, args.stamps), path)


def _of_log(args: Namespace, path: Path) -> int:
    """Write the log `path` as a bag, or print how it is read; return the exit code."""
    reading = reading_of(args)
    if args.map:
        _refuse_others(args, ('map', 'set'), '--map', '--set KEY=VALUE, or no --map')
    else:
        _refuse_others(args, set(OPTIONS) - {'topic'}, 'a log as FILE', 'a bag as FILE')
    try:
        table, mapping, guess = read_mapping(path, reading)
    except Unsettled as error:
        if args.bag is None:
            print(error.guess.yaml_text, end='')
        raise
    if guess is not None and guess.rows:
        print(table_text(guess), file=sys.stderr)
    text = guess.yaml_text if guess is not None else yaml.safe_dump(
        dict(mapping.data), sort_keys=False)
    if args.bag is None:
        print(text, end='')
        return 0
    return _written(args, bag_of_table(table, mapping), table.path,
                    guess.assumptions if guess else (), kind=mapping.kind, mapping=text,
                    mapping_file=Path(mapping.source).name)


def _refuse_others(args: Namespace, used: Container[str], way: str, expected: str) -> None:
    """Raise InputError: options are stated that this `way` of importing does not use."""
    others = stated(args, [name for name in OPTIONS if name not in used])
    if others:
        raise InputError(f'{", ".join(others)}: no effect with {way}, expected {expected}')


def _written(args: Namespace, reader: BagReader, source: Path, assumptions: Sequence[str] = (),
             **origin: str) -> int:
    """Write what `reader` holds, with its origin as metadata; return the exit code."""
    digest = ''
    if source.is_file():
        with source.open('rb') as stream:
            digest = hashlib.file_digest(stream, 'sha256').hexdigest()
    with reader, BagWriter(args.bag) as writer:
        for topic, (kind, _) in reader.topics.items():
            writer.add_topic(topic, kind)
        writer.add_metadata('import', {
            'source': source.name, 'source_sha256': digest, **origin,
            'notices': '\n'.join(reader.notes), 'gearbox_monitor_version': __version__})
        main = next(iter(reader.topics))
        decode = reader.decoder(main, ())
        first = last = 0
        for block in reader.blocks():
            decode(block.of(main))
            writer.write_block(block)
            if len(block):
                first, last = first or int(block.log_ns[0]), int(block.log_ns[-1])
        samples, seconds = writer.topics[main][1], (last - first) * 1e-9
    joints = list(decode.joints)
    data = {'bag': args.bag, 'samples': samples, 'duration_s': seconds,
            'rate_hz': (samples - 1) / seconds if seconds > 0.0 else None,
            'joints': joints, 'topics': list(reader.topics),
            'assumptions': list(assumptions), 'notes': list(reader.notes)}
    rate = f', {data["rate_hz"]:.1f} Hz' if data['rate_hz'] else ''
    show(args, data, lambda: '\n'.join([
        f'{args.bag}: {samples} samples, {seconds:.3f} s{rate}, joints {", ".join(joints)}',
        *(f'assumed: {assumption}' for assumption in assumptions),
        *(f'note: {note}' for note in reader.notes),
        *[f'next: gearbox_monitor check {shlex.quote(args.bag)} --motor-joint '
          f"{shlex.quote(joints[0])} --arm-joint ''"] * ('motor' not in joints)]))
    return 0


def _pair(args: Namespace) -> int:
    """Join motor and arm of a bag; return the exit code."""
    motor = args.topic or 'joint_states'
    options = load_parameters(args.params, 'estimator', SETTINGS, motor) if args.params else \
        {'arm_topic': args.arm_topic}
    _, parameters = resolve(DriveModel(), options, args.params or '--arm-topic')
    with open_bag(args.file) as reader:
        return _written(args, paired_bag(reader, parameters, motor), Path(args.file))


UNWRITTEN = ('Messages that the recorder had not written when it ended are not counted; this '
             "package's recorder writes every 0.25 s.")


def recover_bag(args: Namespace) -> int:
    """
    Repair a truncated bag: after kill -9, a power cut, on a full disk or a damaged medium.

    All readable messages go to a new bag with index and metadata.yaml, unchanged: times, sequence
    numbers, bytes, order, definitions, quality of service. The new bag gets its name only after it
    has been read and compared. BAG itself is only read. For a complete bag nothing is written.
    MCAP only; attachments, which rosbag2 does not write, are omitted. docs/recorder.md lists the
    losses of each accident.

    usage examples:
      gearbox_monitor recover gearbox_2026_11_21-10_00_00
      gearbox_monitor recover cut.mcap --out /media/usb/rescued
      gearbox_monitor recover BAG --json | jq .lost.seconds
    """
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
    data = recovery_data(args.bag, recovery)
    show(args, data, lambda: recovery_text(data))
    return 0


def recovery_data(bag: str, recovery: Recovery) -> dict[str, Any]:
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


def recovery_text(data: Mapping[str, Any]) -> str:
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
