# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find the bags behind paths and patterns.

A folder is a bag if it holds ``metadata.yaml``, or only files named after it, as a killed recorder
leaves them. Any other folder is searched for bags.
"""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from glob import glob
import hashlib
import json
import math
import os
from pathlib import Path
import re
import threading
from typing import Any, TypeAlias

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, refusal
from gearbox_monitor.files.knowledge_file import watch_bytes, watch_from
from gearbox_monitor.health.backlash.change_tests import MEASURED
from gearbox_monitor.health.backlash.features import combine, reason_of, separable_of
from gearbox_monitor.health.health_record import Window
from gearbox_monitor.health.judgement import to_data as health_data
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.library.robot import description_in, watch_robot
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plain_data import to_data
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.joint_input import NO_MODEL, NO_SERIAL
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import natural
from gearbox_monitor.recordings.reading import open_recording
from gearbox_monitor.recordings.storage import FILE_NAME
from gearbox_monitor.report.watch_words import watch_data
from gearbox_monitor.watch.fold import begin

SUFFIXES = ('.mcap', '.db3', '.bag')  # ROS 1 bags are found, too, to report them as foreign


@dataclass(frozen=True)
class FleetBag:
    """
    A bag to be analysed.

    path: absolute. bytes: of its recordings. fingerprint: size and time of each of its files, in
    hex digits. problem: why it cannot be read, or ''. root: folder that was searched for it, ''
    for a bag that was named itself.
    """

    path: str
    bytes: int | None = None
    fingerprint: str = ''
    problem: str = ''
    root: str = ''


@dataclass(frozen=True)
class RobotBag(FleetBag):
    """
    A bag of a robot, whose fingerprint counts those before it, too.

    robot: its name. state: content of the file of what the bags before taught, b'' for nothing.
    """

    robot: str = ''
    state: bytes = b''


def find_bags(words: Iterable[str]) -> list[FleetBag]:
    """
    Return the FleetBags behind `words` (paths, patterns), each once, in their order.

    Raises InputError for a word without any bag.
    """
    bags: dict[str, FleetBag] = {}
    for word in words:
        if '://' in word:
            raise InputError(f'{word}: {refusal("://")}')
        paths = [word] if os.path.lexists(word) else sorted(glob(word, recursive=True),
                                                            key=natural)
        if not paths:
            raise InputError(f'{word}: no such file or directory, expected a bag, a folder of '
                             'bags or a pattern')
        matches = [bag if bag.path == root else replace(bag, root=root)
                   for root in map(os.path.abspath, paths) for bag in _below(Path(root), True)]
        if not matches:
            raise InputError(f'{word}: holds no bag, expected bag directories, .mcap or .db3 '
                             'files')
        bags.update((bag.path, bag) for bag in matches if bag.path not in bags)
    return list(bags.values())


def _below(path: Path, explicit: bool = False, parents: tuple[Path, ...] = ()
           ) -> Iterator[FleetBag]:
    """
    Yield the FleetBags at and below `path`.

    explicit: whether the user named it; parents: the folders above it, as they really are.
    """
    try:
        if not path.is_dir():
            if explicit or path.suffix in SUFFIXES:
                yield _bag(path, [path], [path]) if path.is_file() else FleetBag(
                    str(path), problem='not a file, expected a bag')  # a broken link, a pipe
            return
        real = path.resolve()
        if real in parents:  # a link to a folder above
            return
        entries = sorted(path.iterdir(), key=natural)
        files = [entry for entry in entries if not entry.is_dir()]
        if is_bag(path.name, [file.name for file in files]) or not (entries or explicit):
            yield _bag(path, files, list(filter(is_recording, files)))
            return
    except OSError as error:
        yield FleetBag(str(path), problem=f'cannot be read: {error.strerror or error}')
        return
    for entry in entries:
        if not entry.name.startswith('.'):
            yield from _below(entry, False, (*parents, real))


def is_bag(name: str, files: Sequence[str]) -> bool:
    """Return whether the folder `name` with these `files` is one bag."""
    recordings = [file for file in files if file.endswith(SUFFIXES)]
    return FILE_NAME in files or bool(recordings) and all(
        re.fullmatch(rf'{re.escape(name)}_\d+\.\w+', file) for file in recordings)


def is_recording(path: Path) -> bool:
    """Return whether `path` is a recording of a bag; rosbag2 may have compressed it."""
    return bool(re.fullmatch(r'[^.].*\.(mcap|db3|bag)(\.\w+)?', path.name))


def _bag(path: Path, files: Sequence[Path], recordings: Sequence[Path]) -> FleetBag:
    if not all(file.is_file() for file in files):
        return FleetBag(str(path), problem='holds a pipe or device, expected files')
    states = {file: file.stat() for file in files}
    content = repr([(file.name, state.st_size, state.st_mtime_ns)
                    for file, state in states.items()])
    return FleetBag(str(path), sum(states[file].st_size for file in recordings),
                    hashlib.sha256(content.encode()).hexdigest()[:16])


def content_hash(path: Path) -> str:
    """
    Return the SHA-256 of the recordings of the bag `path`, in their order, as hex digits.

    Names and ``metadata.yaml`` do not count: a bag that was renamed or moved keeps its hash.
    """
    files = sorted(filter(is_recording, path.iterdir()), key=natural) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        with open(file, 'rb') as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


FORMAT = 9  # of the rows and of the states of a watch in them
TRUST = ('observability', 'prediction error', 'covariance', 'input')
Row: TypeAlias = dict[str, Any]  # plain data, some of fleet_run.SCHEMA


@dataclass(frozen=True)
class JobSettings:
    """
    Settings under which every bag of a run is analysed.

    model: None: the one recorded in the bag; model_name: its name in messages. parameters: of the
    estimator, by name; they replace the recorded ones. topic: of the inputs. gearbox: pattern
    whose first group, in the path, names the gearbox; '': the recorded serial. max_seconds: that
    one bag may take. robot: text of the URDF of robots, '' for the one recorded in their bags.
    """

    model: DriveModel | None = None
    model_name: str = ''
    parameters: Mapping[str, Any] = field(default_factory=dict)
    topic: str = 'joint_states'
    gearbox: str = ''
    max_seconds: float = math.inf
    robot: str = ''
    version: str = __version__

    @property
    def key(self) -> str:
        """Sixteen hex digits: a bag is not analysed twice under the same ones."""
        content = {**vars(self), 'format': FORMAT, 'model': self.model and self.model.to_dict(),
                   'model_name': '', 'max_seconds': 0.0}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def analyse(bag: FleetBag, settings: JobSettings) -> Row:
    """
    Return the row of `bag` under `settings`, after settings.max_seconds at the latest.

    The row of a bag that cannot be analysed states the reason; retry: whether it may pass.
    """
    rows: list[Row] = []
    # A thread can be left behind wherever it is; the process of a worker at home ends with it.
    thread = threading.Thread(target=lambda: rows.append(_row(bag, settings)), daemon=True)
    thread.start()
    thread.join(min(settings.max_seconds, threading.TIMEOUT_MAX))
    return rows[0] if rows else failed(
        bag, settings, f'took more than {settings.max_seconds:g} s (--max-seconds)')


def failed(bag: FleetBag, settings: JobSettings, reason: str) -> Row:
    """Return the row of a `bag` with `settings` to be tried again, for a passing `reason`."""
    return {'path': bag.path, 'bytes': bag.bytes, 'settings': settings.key,
            'version': __version__, 'status': 'failed', 'retry': True,
            'reason': f'{bag.path}: {reason}'}


def _row(bag: FleetBag, settings: JobSettings) -> Row:
    if settings.version != __version__:
        return failed(bag, settings, f'the worker has gearbox_monitor {__version__}, expected '
                      f'{settings.version}')
    row = {**failed(bag, settings, ''), 'kernels': KERNELS, 'retry': False}
    if isinstance(bag, RobotBag):
        row |= {'gearbox': bag.robot, 'state': bag.state}
    try:
        path = Path(bag.path)
        row['content'] = content_hash(path)
        result = (_watched(path, bag, settings) if isinstance(bag, RobotBag) else
                  _analysed(path, settings))
        return {**row, **result, 'status': 'done', 'reason': None}
    except InputError as error:
        return {**row, 'reason': str(error)}
    except OSError as error:
        return {**row, 'retry': True, 'reason': f'{bag.path}: {error}'}
    except MemoryError:
        return {**row, 'retry': True, 'reason': f'{bag.path}: out of memory (--max-memory)'}
    except Exception as error:  # a bag must not end the run of all others
        return {**row, 'reason': f'{bag.path}: {type(error).__name__} '
                                 f'{" ".join(str(error).split())}'}


def _analysed(path: Path, settings: JobSettings) -> Row:
    """Return the results for the row of the bag `path`."""
    with open_recording(path) as reader:
        player = Player(reader, settings.model, settings.parameters, settings.topic)
        monitor, known = player.monitor, player.monitor.health
        gearbox, named = name_of(path, player.namespace, monitor.parameters.gearbox_serial,
                                 settings.gearbox)
        judged: list[Window] = []
        count = 0
        start: int | None = None
        end = 0
        for part in player.parts():
            judged += player.judged()
            stamps = part.samples.stamp_ns
            if len(stamps):
                start, end = int(stamps[0]) if start is None else start, int(stamps[-1])
                count += len(stamps)
        if start is None:
            raise InputError(f'{path}: topic {player.topic} has no message, expected at least one')
        monitor = player.monitor
        rest = monitor.all_features()[-1:]  # the window in progress
        judged += player.judged()
        windows = [window.features for window in judged]
        windows += [window for window in rest if window not in windows]
        row = {
            'gearbox': gearbox, 'named': named,
            'judged': json.dumps([
                to_data((monitor.health.settings, tuple(judged))),
                health_data(known) if known.stamp_ns else None]),
            **_times(start, end), 'samples': count, 'filter': monitor.parameters.filter,
            'unit': 'm' if monitor.model.axis == 'prismatic' else 'rad',
            'trust': max(monitor.outcomes[name].level for name in TRUST).name,
            'model_level': monitor.outcomes['model'].level.name,
            **_features(windows)}
        notes = monitor.estimator.warnings + monitor.estimator.divergence_notes()
        notes += [reader.notice] if reader.notice else []
        notes += [NO_MODEL] if NO_MODEL in player.notes else []
        notes += [] if named else [NO_SERIAL]
        row['notes'] = '; '.join(notes)
    return row


def _watched(path: Path, bag: RobotBag, settings: JobSettings) -> Row:
    """Return the results for the row of a robot's `bag` at `path`."""
    _, named = name_of(path, '', '', settings.gearbox)
    known, notes = watch_from(bag.state, path) if bag.state else None, list[str]()
    text = settings.robot or description_in([path])
    if known is not None and text not in (None, known.description):
        known, notes = None, ['another robot_description: the robot is learnt again']
    if known is None and text is not None:
        known = begin(text)
    watch = watch_robot(path, state=known, topic=settings.topic)
    with open_recording(path) as reader:
        start, end = reader.start_ns or 0, reader.end_ns or 0
        notes += [reader.notice] if reader.notice else []
    return {'named': named, **_times(start, end), 'state': watch_bytes(watch),
            'judged': json.dumps(watch_data(watch)), 'notes': '; '.join([*notes, *watch.notes])}


def _times(start: int, end: int) -> Row:
    """Return begin, length and date of a recording from `start` to `end` (ns)."""
    return {'start': start, 'duration_s': (end - start) * 1e-9,
            'date': datetime.fromtimestamp(start // 10 ** 9, timezone.utc).strftime('%Y-%m-%d')}


def name_of(path: Path, namespace: str, serial: str, pattern: str) -> tuple[str, bool]:
    """
    Return the name of a gearbox or robot, and whether it is more than the folder of the bag.

    Args:
        path: of the bag.
        namespace: of its topic, or ''.
        serial: recorded in it, or ''.
        pattern: see JobSettings.gearbox.
    """
    usual = EstimatorParameters().gearbox_serial
    if pattern:
        match = re.search(pattern, str(path))
        if match is None:
            raise InputError(f'{path}: does not match --gearbox {pattern!r}')
        if not match[1]:
            raise InputError(f"{path}: gearbox: '', expected a name")
        return match[1], True
    if serial in ('', usual):  # nobody has named it
        serial = namespace.strip('/')
    return serial or path.parent.name or usual, bool(serial)


def _features(windows: Sequence[Any]) -> Row:
    """Return the features that all windows give together."""
    used, separable = separable_of(windows)
    row: Row = {'windows': len(windows), 'windows_used': len(used)}
    if used:
        row['separable'] = separable
    else:
        row['not_excited'] = str(reason_of(windows))
    for name in MEASURED:
        # Lost motion needs no torque: every window counts that shows it.
        combined = combine(windows if name == 'lost_motion' else used, name)
        if combined:
            row[name], row[f'{name}_std'] = combined.value, combined.std
    return row
