# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Convert a recording into a bag: text, .mat, JSON, HDF5, NumPy, Parquet, Feather, ROS 1 and 2 bags.

--guess reads columns by their names and units first, then by the motion. A table on stderr says
what became of each; what stays open is asked for, with the option that settles it, and nothing is
written (exit code 3). Without BAG it prints the mapping, to be edited and used with --map.

A file with several joints becomes a bag with all of them: joint_states, and joint_setpoints where
setpoints are recorded. --joint selects one, as the joints motor and arm (NaN = not measured). A
reference torque goes to reference/transmission_state, never into the estimator's input.

A bag as FILE needs no mapping: JointState, DynamicJointState and JointTrajectoryControllerState
are read, --stamps replaces their stamps. With --arm-topic, or --params that state arm_topic, motor
and arm come from two publishers: they are joined as the live estimator does it, and the new bag
has paired_joint_states, which all commands take.

usage examples:
  gearbox_monitor import davinci_backend/00.TXT.gz --map davinci_backend run00
  gearbox_monitor import run7.csv --map my_bench.yaml --set signals.arm_position.zero=812 bench7
  gearbox_monitor import test_bench.csv --guess > my_bench.yaml    # then: look, edit, use it
  gearbox_monitor import robot.csv --guess --joint 3 --torque-constant 0.12 joint3
  gearbox_monitor import ur.csv --guess --columns 't,q[6],dq[6],i[6]' --torque-constant 10,10,9 ur
  gearbox_monitor import old_robot.bag --stamps received robot
  gearbox_monitor import two_topics --params joint3.yaml one_topic
  gearbox_monitor check bench                     # then: its contents, and what it suits
"""
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Container, Sequence
from pathlib import Path
import shlex
import shutil
import sys
from typing import Any, TYPE_CHECKING

from gearbox_monitor.cli.options import show, stated
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.files.yaml_files import expect_outside_of_bag, load_parameters
from gearbox_monitor.parameters import resolve, SETTINGS
from gearbox_monitor.plant.drive import DriveModel

if TYPE_CHECKING:
    from gearbox_monitor.recordings.importer.guess import Answers, Guess


# Options that not all ways of importing use.
OPTIONS = ('guess', 'set', 'joint', 'topic', 'use', 'unit', 'torque_constant', 'counts_per_turn',
           'columns', 'rate', 'episode', 'stamps')


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
    parser.add_argument('file', metavar='FILE', help='recording, folder of one, or bag')
    source = parser.add_mutually_exclusive_group()
    source.add_argument('--map', metavar='MAP',
                        help='mapping file, or the name of a packaged mapping')
    source.add_argument('--guess', action=_Guess, nargs=0, default=False,
                        help='propose a mapping; without BAG, print it and write nothing')
    source.add_argument('--params', metavar='PARAMS',
                        help='FILE is a bag: ROS parameter file of the estimator with arm_topic')
    source.add_argument('--arm-topic', metavar='TOPIC',
                        help='FILE is a bag: topic of the arm, of two publishers')
    parser.add_argument('--set', metavar='KEY=VALUE', action='append', default=[],
                        help='replace a value of the mapping, as gear_ratio=50; repeatable')
    parser.add_argument('--joint', metavar='NAME', help='of several joints, the one to write')
    add_answer_arguments(parser)
    parser.add_argument('--topic', default='', help='of a bag: topic of the joint states, with '
                        '--params or --arm-topic that of the motor (default: joint_states)')
    parser.add_argument('bag', metavar='BAG', help='bag to write; must not exist')
    parser.add_argument('--json', action='store_true', help='print what was written as JSON')


def add_answer_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` the options that settle what --guess asks."""
    guess = parser.add_argument_group('what --guess asks for')
    guess.add_argument('--use', metavar='ROLE=COLUMN', action='append', default=[],
                       help='column of a role: time, position, motor, arm, velocity, effort, '
                       'setpoint, reference; COLUMN none for no such role; repeatable')
    guess.add_argument('--unit', metavar='ROLE=UNIT', action='append', default=[],
                       help='unit of a role or of a column, as position=deg; repeatable')
    guess.add_argument('--torque-constant', metavar='K,...', default='',
                       help='N m per A (or per unit of the effort), for each joint or for all')
    guess.add_argument('--counts-per-turn', metavar='N', type=float, help='of the encoders')
    guess.add_argument('--columns', metavar='NAMES', default='',
                       help="names of all columns of numbers, as 't [s],q[6],i[6]'; q[6] stands "
                       'for q_1 to q_6, - for a column that is not used')
    guess.add_argument('--rate', metavar='HZ', type=float, help='of a recording without time')
    guess.add_argument('--episode', metavar='N', type=int, help='of a data set, the only one')
    guess.add_argument('--stamps', choices=('recorded', 'received', 'even'), default='recorded',
                       help='stamps as recorded (default), an even grid through them, or of a '
                       'bag the times of receipt')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    from gearbox_monitor.recordings.importer import load_mapping, read_any, write_imported_bag
    from gearbox_monitor.recordings.importer.message_bag import import_bag, is_bag
    if args.bag is not None and Path(args.bag).exists():
        raise InputError(f'{args.bag}: exists, expected the name of a new bag')
    if args.bag is not None:
        expect_outside_of_bag(args.bag)
    if args.params or args.arm_topic:
        _refuse_others(args, ('topic',), '--params or --arm-topic', '--topic')
        return _pair(args)
    path = Path(args.file)
    if not args.map and is_bag(path):
        _refuse_others(args, ('topic', 'joint', 'stamps', 'guess'), 'a bag as FILE',
                       '--topic, --joint or --stamps')
        if args.bag is None:
            raise InputError(f'{path}: a bag, expected the name of a new bag behind it')
        data = import_bag(path, args.bag, args.topic, args.stamps, args.joint)
        single = args.joint is not None or 'motor' in data['signals']
        return _say(args, data, () if single else data['signals'])
    if not args.map and not args.guess:
        raise InputError(f'{path}: no bag, expected --guess or --map MAP' if path.exists() else
                         f'{path}: no such file, expected a bag or a log')
    if args.guess:
        _refuse_others(args, set(OPTIONS) - {'topic'}, '--guess', 'it with a bag as FILE')
    else:
        _refuse_others(args, ('set',), '--map', '--set KEY=VALUE of the mapping, or --guess')
    path = _file_in(path)
    guess: Guess | None = None
    if args.guess:
        from gearbox_monitor.recordings.importer.guess import guessed_mapping
        guess = guessed_mapping(path, args.set, answers_of(args))
        print(table_text(guess), file=sys.stderr)
        if args.bag is None:
            print(guess.yaml_text, end='')
            if guess.questions:
                raise Undecided(*(f'{path.name}: {question}' for question in guess.questions))
            return 0
        mapping = guess.mapping()
    else:
        mapping = load_mapping(args.map, args.set)
    recording = read_any(path, mapping)
    write_imported_bag(recording, args.bag, path, mapping)
    n = len(recording.stamp_ns)
    duration = (recording.stamp_ns[-1] - recording.stamp_ns[0]) * 1e-9
    signals = list(mapping.signals)
    signals += list(mapping.second_file.mapping.signals) if mapping.second_file else []
    data = {'bag': args.bag, 'samples': n, 'duration_s': duration, 'rate_hz': (n - 1) / duration,
            'signals': signals, 'assumptions': list(guess.assumptions if guess else ()),
            'notes': list(recording.notices)}
    return _say(args, data, mapping.joints)


def _refuse_others(args: Namespace, used: Container[str], way: str, expected: str) -> None:
    """Raise InputError: options are stated that this `way` of importing does not use."""
    others = stated(args, [name for name in OPTIONS if name not in used])
    if others:
        raise InputError(f'{", ".join(others)}: no effect with {way}, expected {expected}')


def _file_in(path: Path) -> Path:
    """Return the file of a recording: `path`, or the only one in the folder `path`."""
    if not path.is_dir():
        return path
    from gearbox_monitor.recordings.importer.sibling_file import state_files
    files = state_files(path)
    if len(files) != 1:
        names = ', '.join(file.name for file in files[:12]) or 'none'
        raise (Undecided if files else InputError)(
            f'{path}: {len(files)} recordings, expected the path of one of them: {names}')
    return files[0]


def answers_of(args: Namespace) -> 'Answers':
    """Return the Answers in the options `args`. Raises InputError."""
    from gearbox_monitor.recordings.importer.guess import Answers

    def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
        pairs = {}
        for text in texts:
            name, equals, value = text.partition('=')
            if not equals or not name or not value:
                raise InputError(f'{option}: {text!r}, expected ROLE=VALUE')
            pairs[name] = value
        return pairs
    try:
        constants = [float(text) for text in args.torque_constant.split(',') if text]
    except ValueError:
        raise InputError(f'--torque-constant: {args.torque_constant!r}, expected numbers > 0 '
                         'with commas between them') from None
    for option, values in (('--torque-constant', constants),
                           ('--counts-per-turn', [args.counts_per_turn]), ('--rate', [args.rate])):
        for value in values:
            if value is not None and not 0.0 < value < 1e300:
                raise InputError(f'{option}: {value:g}, expected > 0')
    if args.stamps == 'received':
        raise InputError('--stamps received: FILE is no bag, expected recorded or even')
    return Answers(_pairs('--use', args.use), _pairs('--unit', args.unit), constants,
                   args.counts_per_turn, args.joint, args.columns, args.rate, args.episode,
                   '' if args.stamps == 'recorded' else args.stamps)


def table_text(guess: 'Guess') -> str:
    """Return the table of the columns of a guess, as wide as the terminal."""
    width = max(80, min(shutil.get_terminal_size((120, 24)).columns, 160))
    rows = [('column', 'role', 'unit', 'why'),
            *((row.column, row.role or '-', row.unit or '-', row.why) for row in guess.table)]
    first, second, third = (min(max(len(row[k]) for row in rows), room)
                            for k, room in enumerate((44, 18, 9)))
    return '\n'.join(f'{a[:first]:{first}s}  {b[:second]:{second}s}  {c[:third]:{third}s}  {d}'
                     [:width].rstrip() for a, b, c, d in rows)


def _say(args: Namespace, data: dict[str, Any], joints: Sequence[str]) -> int:
    """Print what was written; return the exit code."""
    signals = f'joints {", ".join(joints)}' if joints else f'signals {", ".join(data["signals"])}'
    rate = f', {data["rate_hz"]:.1f} Hz' if data['rate_hz'] else ''
    lines = [*(f'assumed: {assumption}' for assumption in data['assumptions']),
             f'{args.bag}: {data["samples"]} samples, {data["duration_s"]:.3f} s{rate}, {signals}',
             *(f'note: {notice}' for notice in data['notes'])]
    if joints:
        lines.append(f'next: gearbox_monitor check {shlex.quote(args.bag)} --motor-joint '
                     f"{shlex.quote(joints[0])} --arm-joint ''")
    show(args, data, lambda: '\n'.join(lines))
    return 0


def _pair(args: Namespace) -> int:
    """Join motor and arm of a bag; return the exit code."""
    from gearbox_monitor.recordings.joint_input import write_paired
    from gearbox_monitor.recordings.read import open_bag
    motor = args.topic or 'joint_states'
    options = load_parameters(args.params, 'estimator', SETTINGS, motor) if args.params else \
        {'arm_topic': args.arm_topic}
    _, parameters = resolve(DriveModel(), options, args.params or '--arm-topic')
    with open_bag(args.file) as reader:
        topic, count, joiner = write_paired(reader, args.bag, parameters, motor)
        notice = reader.notice
    data = {'bag': args.bag, 'topic': topic, 'samples': count,
            'motor_without_arm': joiner.unpaired, 'arm_without_motor': joiner.dropped,
            'pair_tolerance_s': parameters.pair_tolerance,
            'notes': [notice] if notice else []}
    nearest = joiner.pop_distance()
    if nearest is not None:
        data['nearest_unpaired_s'] = nearest * 1e-9
    show(args, data, lambda: '\n'.join([
        f'{args.bag}: {count} samples on {topic}, {joiner.unpaired} without the arm; '
        f'{joiner.dropped} messages of the arm omitted'
        + (f'; the nearest unpaired stamps are {nearest * 1e-9:.6f} s apart, '
           f'pair_tolerance is {parameters.pair_tolerance:g} s' if nearest else ''),
        *(f'note: {note}' for note in data['notes'])]))
    return 0
