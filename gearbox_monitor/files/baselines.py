# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The files of drift: the baseline, the recording of the healthy gearbox, and the state.

The baseline says what was healthy; its recording tells later what changed; the state goes on after
a restart. One process writes a state, from a thread of its own.
"""
from collections.abc import Callable, Iterable
from dataclasses import dataclass
import fcntl
import json
import math
import os
from pathlib import Path
import socket
from threading import Condition, Thread
import time
from typing import Any, TextIO
from zlib import crc32

import yaml

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.health.backlash import drift_words
from gearbox_monitor.health.backlash.change import Tracker, TrackerSettings
from gearbox_monitor.kernels.types import Values

FORMAT, STATE_FORMAT = 3, 6  # version 0.2 wrote up to 2 and up to 5


class Damaged(InputError):
    """A file of drift is not what this package has written."""


def load_baseline(path: str | Path, gearbox_serial: str = '') -> list[dict[str, Any]]:
    """
    Return the baselines in the file `path`, as change.Tracker takes them.

    Raises Damaged, and InputError where the file cannot be read, is of another version or names
    another gearbox than `gearbox_serial`.
    """
    if not os.access(path, os.R_OK):
        load_yaml(path)  # says why
    try:
        data = load_yaml(path).content
    except InputError as error:
        raise Damaged(*error.args) from None
    if not isinstance(data, dict) or 'baseline' not in data:
        raise Damaged(f'{path}: {str(data)[:60]!r}, expected a block "baseline"')
    if data.get('format') != FORMAT:
        raise InputError(f'{path}: a baseline of another version (format '
                         f'{data.get("format")!r}), expected format {FORMAT}: save the baseline '
                         'again')
    serial = data.get('gearbox_serial')
    if gearbox_serial and serial != gearbox_serial:
        raise InputError(f'{path}: gearbox_serial: {serial!r}, expected {gearbox_serial!r}')
    points = data['baseline']
    if not isinstance(points, list):
        raise Damaged(f'{path}: baseline: {str(points)[:60]!r}, expected a list of operating '
                      'points')
    if data.get('points', len(points)) != len(points):
        raise Damaged(f'{path}: baseline: {len(points)} operating points, expected '
                      f'{data["points"]}: the file is truncated')
    for k, point in enumerate(points):
        _check_point(point, f'{path}: baseline[{k}]')
    try:
        return Tracker(TrackerSettings(), points).baseline_points()
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise Damaged(f'{path}: baseline: {error!r}, expected what ~/save_baseline '
                      'writes') from None


def _check_point(point: Any, source: str) -> None:
    """Raise Damaged that names `source` if `point` is no operating point."""
    if not isinstance(point, dict) or not isinstance(point.get('features'), dict):
        raise Damaged(f'{source}: {str(point)[:60]!r}, expected an operating point with '
                      'features')
    for name in ('angle', 'speed', 'load', 'scale'):
        _check_number(point.get(name), f'{source}.{name}', -math.inf)
    if point.get('temperature') is not None:
        _check_number(point['temperature'], f'{source}.temperature', -math.inf)
    for name, feature in point['features'].items():
        for key in ('windows', 'mean', 'std', 'stated_std'):
            value = feature.get(key) if isinstance(feature, dict) else None
            _check_number(value, f'{source}.{name}.{key}', 0.0 if key != 'mean' else -math.inf)


def _check_number(value: object, source: str, low: float) -> None:
    """Raise Damaged that names `source` if `value` is no finite number >= `low`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or \
            not math.isfinite(value) or value < low:
        raise Damaged(f'{source}: {value!r}, expected a number'
                      + (f' >= {low:g}' if low > -math.inf else ''))


def save_baseline(path: str | Path, points: list[dict[str, Any]], gearbox_serial: str,
                  parameters: dict[str, Any]) -> None:
    """
    Write baselines to a file, whole or not at all.

    Args:
        path: of the file; replaced if it exists.
        points: of Tracker.baseline_points.
        gearbox_serial: of the gearbox that they belong to.
        parameters: in force, for the record.

    Raises:
        InputError: if the file cannot be written.

    """
    text = '# What was healthy, per operating point; written by ~/save_baseline.\n' + \
        yaml.safe_dump({
            'format': FORMAT, 'gearbox_monitor': __version__, 'gearbox_serial': gearbox_serial,
            'date': _now(), 'points': len(points), 'baseline': points,
            'parameters': parameters}, sort_keys=False)
    write_whole(Path(path), text)


def state_text(tracker: Tracker, gearbox_serial: str, adaptation: Values | None = None,
               recording_ns: int = 0) -> str:
    """
    Return the state file of a `tracker`, the `gearbox_serial` and values of `adaptation`.

    recording_ns: stamp of the baseline recording, 0: none.
    """
    return json.dumps({
        'format': STATE_FORMAT, 'gearbox_monitor': __version__,
        'gearbox_serial': gearbox_serial, 'date': _now(), 'drift': tracker.to_dict(),
        'adaptation': adaptation or {}, 'recording_ns': recording_ns})


def load_state(path: str | Path, gearbox_serial: str) -> tuple[dict[str, Any] | None, str]:
    """
    Return (state or None, report or '') of the state file `path` of the gearbox `gearbox_serial`.

    The state: {'drift': what Tracker takes, 'adaptation': what Estimator.recall takes or {},
    'recording_ns': stamp of the baseline recording, 0: none}.
    There may be no file yet. One that is damaged, of another version or of another gearbox is
    renamed to PATH.corrupt-DATE. Raises InputError where it cannot be read or renamed.
    """
    path = Path(path)
    try:
        with open_file(path) as file:
            text = file.read().decode('utf-8', 'replace')
    except FileNotFoundError:
        return None, ''
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable file') from None
    try:
        data = json.loads(text)
        if data['format'] != STATE_FORMAT:
            raise ValueError(f'a state of another version (format {data["format"]!r}), expected '
                             f'format {STATE_FORMAT}')
        if data['gearbox_serial'] != gearbox_serial:
            raise ValueError(f'gearbox_serial {data["gearbox_serial"]!r}, expected '
                             f'{gearbox_serial!r}')
        drift_words.outcomes(Tracker(TrackerSettings(), data['drift']))
        adaptation = data['adaptation']
        if not isinstance(adaptation, dict):
            raise ValueError(f'adaptation {str(adaptation)[:60]!r}, expected a block')
        return {'drift': data['drift'], 'adaptation': adaptation,
                'recording_ns': int(data['recording_ns'])}, ''
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError,
            RecursionError) as error:
        reason = f'no {error}' if isinstance(error, KeyError) else str(error)
    return None, f'{path}: {reason}: {set_aside(path)}'


def set_aside(path: str | Path, reason: str = 'corrupt') -> str:
    """Rename `path` to PATH.`reason`-DATE; return what to report. Raises InputError."""
    path = Path(path)
    aside = path.with_name(f'{path.name}.{reason}-{time.strftime("%Y%m%d-%H%M%S")}')
    try:
        os.replace(path, aside)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a file that can be renamed') \
            from None
    return f'set aside as {aside.name}; drift detection starts again'


def _now() -> str:
    """Return the local time in ISO 8601."""
    return time.strftime('%Y-%m-%dT%H:%M:%S%z')


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace the file `path` by `content` at once. Raises InputError."""
    temporary = path.with_name(path.name + '.tmp')
    try:
        with open(temporary, 'wb') as file:
            file.write(content.encode('utf-8') if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a writable file') from None


RECORDING_FORMAT = 1
SUFFIX = '.recording'    # of the file, after the name of the state of drift
LARGEST = 64 << 20       # bytes of a file that is read


@dataclass(frozen=True)
class BaselineRecording:
    """
    Rows of a healthy gearbox, packed.

    stamp_ns: of the newest row; it names the recording. gearbox_serial, joints (motor, arm), model
    (plain values of the model file): of what. blocks: of RecordingBuffer.blocks.
    """

    stamp_ns: int
    gearbox_serial: str
    joints: tuple[str, str]
    model: dict[str, Any]
    blocks: tuple[bytes, ...]

    def to_bytes(self) -> bytes:
        """Return the content of the file."""
        rows = b''.join(self.blocks)
        head = {'format': RECORDING_FORMAT, 'gearbox_monitor': __version__,
                'stamp_ns': self.stamp_ns, 'gearbox_serial': self.gearbox_serial,
                'joints': self.joints, 'model': self.model,
                'blocks': [len(block) for block in self.blocks], 'crc32': crc32(rows)}
        return json.dumps(head).encode() + b'\n' + rows


def load_recording(path: str | Path) -> BaselineRecording | None:
    """
    Return the BaselineRecording in the file `path`, None without a file.

    Raises Damaged for what this package has not written, InputError where it cannot be read.
    """
    try:
        with open_file(path) as file:
            data = file.read(LARGEST + 1)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable file') from None
    if len(data) > LARGEST:
        raise Damaged(f'{path}: more than {LARGEST >> 20} MB, expected a baseline recording')
    first, _, rows = data.partition(b'\n')
    try:
        head = json.loads(first)
        if head['format'] != RECORDING_FORMAT:
            raise Damaged(f'{path}: format {head["format"]!r}, expected {RECORDING_FORMAT}')
        if crc32(rows) != head['crc32'] or sum(head['blocks']) != len(rows):
            raise Damaged(f'{path}: {len(rows)} bytes of rows, expected those that its first line '
                          'describes: the file is damaged')
        motor, arm = head['joints']
        return BaselineRecording(int(head['stamp_ns']), str(head['gearbox_serial']),
                                 (str(motor), str(arm)), dict(head['model']),
                                 tuple(split(rows, head['blocks'])))
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
        reason = f'no {error}' if isinstance(error, KeyError) else str(error)
        raise Damaged(f'{path}: {reason}, expected a baseline recording') from None


def split(data: bytes, sizes: Iterable[int]) -> list[bytes]:
    """Return the parts of `data` that have these `sizes` (bytes), one behind the other."""
    begin, parts = 0, []
    for size in sizes:
        parts.append(data[begin:begin + size])
        begin += size
    return parts


def check_belongs(path: str | Path, recording: BaselineRecording,
                  expected: BaselineRecording) -> None:
    """
    Refuse a recording of another gearbox, model file or baseline.

    Args:
        path: of its file.
        recording: what the file holds.
        expected: whose gearbox_serial, joints, model and stamp_ns it must have.

    Raises:
        InputError: naming what differs.
    """
    if recording.gearbox_serial != expected.gearbox_serial:
        raise InputError(f'{path}: gearbox_serial: {recording.gearbox_serial!r}, expected '
                         f'{expected.gearbox_serial!r}')
    if recording.joints != expected.joints:
        raise InputError(f'{path}: joints: {", ".join(recording.joints)}, expected '
                         f'{", ".join(expected.joints)}')
    for name in sorted({*recording.model, *expected.model}):
        value, own_value = recording.model.get(name), expected.model.get(name)
        if value != own_value:
            raise InputError(f'{path}: recorded with another model: {name}: {str(value)[:60]}, '
                             f'expected {str(own_value)[:60]}')
    if recording.stamp_ns != expected.stamp_ns:
        raise InputError(f'{path}: of another baseline, recorded until {recording.stamp_ns} ns, '
                         f'expected {expected.stamp_ns or "none"}')


PREDECESSOR = 2.0  # s that a process waits at its start for one that is just ending


class StateFile:
    """
    Writes the newest of the texts that it is given; a text that is overtaken is left out.

    path: of the file; owner: who writes it, for whom it refuses. recording: path of the baseline
    recording beside it. problem: why the file is not written now, '' while it is. held: whether
    the lock is ours: else nothing is written, and each text tries again. readable: whether the
    file is ours to read: no rival keeps its state there.
    """

    def __init__(self, path: str | Path, owner: str) -> None:
        self.path = Path(path)
        self.recording = self.path.with_name(self.path.name + SUFFIX)
        self.problem = ''
        self._change = Condition()
        self._text: str | None = None
        self._rows: Callable[[], bytes] | None = None
        self._ends = False
        self._owner = f'{owner} (process {os.getpid()} on {socket.gethostname()})'
        self._writer: Thread | None = None
        self.readable = True
        self._lock = self._locked()
        end = time.monotonic() + PREDECESSOR
        while not self.readable and time.monotonic() < end:
            time.sleep(0.05)
            self._lock = self._locked()
        self._unread = not (self.readable and self.path.exists())

    @property
    def held(self) -> bool:
        """Whether the lock is ours."""
        return self._lock is not None

    def _locked(self) -> TextIO | None:
        """Return the open lock file that is ours, None with a problem."""
        path = self.path.with_name(self.path.name + '.lock')
        try:
            file = open(path, 'a+', encoding='utf-8')
        except OSError as error:
            self.problem = f'{path}: {error.strerror}, expected a folder that can be written'
            self.readable = True
            return None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            rival = file.read(200).strip() or 'another process'
            file.close()
            self.problem = (f'{self.path}: {rival} keeps its state there, expected a '
                            'drift_state_file of its own for each gearbox')
            self.readable = False
            return None
        file.truncate(0)
        file.write(self._owner + '\n')
        file.flush()
        self.problem, self.readable = '', True
        return file

    def keep(self, text: str) -> str:
        """
        Let `text` be written soon; return what to report, '' for nothing.

        A lock that comes late may find files that this process has not read: they are set aside.
        """
        note = ''
        if not self.held:
            lock = self._locked()
            if lock is None:
                return ''
            paths = [p for p in (self.recording, self.path) if self._unread and p.exists()]
            try:
                note = '; '.join(f'{path}: not read at the start, {set_aside(path, "unread")}'
                                 for path in paths)
            except InputError as error:
                self.problem = str(error)
                lock.close()
                return ''
            self._lock = lock
        with self._change:
            self._text = text
            if self._writer is None:
                self._writer = Thread(target=self._write, daemon=True)
                self._writer.start()
            self._change.notify_all()
        return note

    def keep_recording(self, content: Callable[[], bytes]) -> None:
        """
        Let the baseline recording be written, before the next text that is kept.

        Args:
            content: returns its bytes; called in the thread that writes.
        """
        with self._change:
            self._rows = content

    def _write(self) -> None:
        """Write what comes; the thread."""
        while True:
            with self._change:
                while self._text is None and not self._ends:
                    self._change.wait()
                text, self._text = self._text, None
                rows, self._rows = self._rows, None
            if text is None:
                return
            try:
                if rows is not None:
                    write_whole(self.recording, rows())
                write_whole(self.path, text)
                self.problem = ''
            except InputError as error:  # a full disk must not stop the estimates
                self.problem = str(error)
                with self._change:  # the next text tries again
                    self._rows = self._rows or rows

    def close(self) -> None:
        """Write what waits, and let another process have the file."""
        with self._change:
            self._ends = True
            self._change.notify_all()
        if self._writer is not None:
            self._writer.join()
        if self._lock is not None:
            self._lock.close()
            self._lock = None
