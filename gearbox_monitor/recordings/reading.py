# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Open a recording of any kind, as a bag: the one way in of all commands."""
from dataclasses import dataclass
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file
from gearbox_monitor.recordings.guess import Answers, Guess, guessed, NO_ANSWERS, Unsettled
from gearbox_monitor.recordings.mapping import load_mapping, Mapping, mapping_of, text_of
from gearbox_monitor.recordings.messages import converted_bag, needs_conversion
from gearbox_monitor.recordings.read import BagReader, FORMATS, is_ros1, open_bag, ROS1
from gearbox_monitor.recordings.roles import NONE
from gearbox_monitor.recordings.si_signals import bag_of_table, Signals, signals_of
from gearbox_monitor.recordings.table import load_table, Table
from gearbox_monitor.recordings.times import BESIDE, file_in, with_setpoints
from gearbox_monitor.recordings.topics import JOINT_STATES

MAGIC = (b'\x89MCAP0\r\n', b'SQLite format 3\x00', ROS1)


@dataclass(frozen=True)
class ReadOptions:
    """
    How a user says that a recording is read.

    map: mapping file, or the name of a packaged one; settings: ``KEY=VALUE`` that replace values
    of it; answers: to the questions of a guess, where there is no mapping. conventions:
    ``JOINT=RULE`` by which joints of a robot count unlike its description.
    """

    map: str = ''
    settings: tuple[str, ...] = ()
    answers: Answers = NO_ANSWERS
    conventions: tuple[str, ...] = ()


BY_NAMES = ReadOptions()


def is_bag(path: Path) -> bool:
    """Return whether `path` is a ROS bag: a folder with one, or a file of a ROS 1 or 2 bag."""
    if path.is_dir():
        return any(file.name == 'metadata.yaml' or any(part in FORMATS for part in file.suffixes)
                   for file in path.iterdir())
    if any(part in FORMATS for part in path.suffixes):
        return True
    try:
        with open_file(path) as stream:
            return stream.read(16).startswith(MAGIC)
    except OSError:
        return False


def open_recording(path: str | Path, reading: ReadOptions = BY_NAMES, topic: str = ''
                   ) -> BagReader:
    """
    Return a recording of any kind as a bag.

    Args:
        path: of a bag, a table or a folder with one of them.
        reading: how the user says that it is read.
        topic: of the joint states, where a bag has to be converted; '' for the usual one.

    Raises:
        InputError: it cannot be read; Undecided: something about it is open.
    """
    path, topic = Path(path), '' if topic == JOINT_STATES else topic
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a recording')
    if is_bag(path):
        return _opened_bag(path, reading, topic)
    table, mapping, _ = read_mapping(path, reading, False)  # a model may have the constants
    return bag_of_table(table, mapping)


def _opened_bag(path: Path, reading: ReadOptions, topic: str) -> BagReader:
    stamps = reading.answers.stamps or 'recorded'
    if reading != ReadOptions(answers=Answers(stamps=reading.answers.stamps)):
        raise InputError(f'{path}: a bag, which states what its columns are, expected no --map, '
                         '--set, --use, --unit and the like')
    if is_ros1(path) or stamps != 'recorded':
        return converted_bag(path, topic, stamps)
    reader = open_bag(path)
    if not needs_conversion(reader):
        return reader
    reader.close()
    return converted_bag(path, topic)


def read_mapping(path: Path, reading: ReadOptions = BY_NAMES, constants: bool = True
                 ) -> tuple[Table, Mapping, Guess | None]:
    """
    Return (table, how it is read, what was guessed of it) of a file that is no bag.

    Args:
        path: of the file, or of a folder with one.
        reading: how the user says that it is read.
        constants: whether a current needs a constant here.

    Raises:
        InputError: it cannot be read; Undecided: something about it is open.
    """
    path = file_in(path)
    if reading.map:
        if reading.answers != NO_ANSWERS:
            raise InputError('--map: with --use, --unit and the like, expected --set KEY=VALUE of '
                             'the mapping, or no --map')
        data, source = load_mapping(reading.map, reading.settings)
        mapping_of(data, source, None)  # its own problems before those of the file
        table = load_table(path, text_of(data, source))
        if BESIDE in str(data.get('joints')):
            table = with_setpoints(table)
        return table, mapping_of(data, source, table.header), None
    if reading.answers.stamps == 'received':
        raise InputError(f'--stamps received: {path} is no bag, expected recorded or even')
    table = load_table(path)
    if reading.answers.use.get('setpoint') != NONE:
        table = with_setpoints(table)
    guess = guessed(table, reading.settings, reading.answers, constants)
    if guess.questions:
        raise Unsettled(guess)
    return table, mapping_of(guess.data, f'guess of {path.name}', table.header), guess


def read_signals(path: str | Path, reading: ReadOptions = BY_NAMES) -> Signals:
    """Return the Signals in the file `path`, which is no bag, as `reading` has it."""
    table, mapping, _ = read_mapping(Path(path), reading)
    return signals_of(table, mapping)
