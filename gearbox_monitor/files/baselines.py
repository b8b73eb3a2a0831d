# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The files of drift: the baseline, the recording of the healthy gearbox, and the state.

The baseline says what was healthy; its recording shows later what changed; the state goes on after
a restart. One process writes a state, from a thread of its own.
"""
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
import fcntl
import json
import os
from pathlib import Path
import socket
from threading import Condition, Thread
import time
from typing import Any, TextIO
from zlib import crc32

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import open_file, read_bytes
from gearbox_monitor.health.health_record import HealthSettings
from gearbox_monitor.health.judgement import from_data, Health, to_data

BASELINE, STATE = 'baseline', 'state'  # kinds of files
FORMAT = 8  # of both; version 0.2 wrote up to 5


AGAIN = 'drift detection starts again'


class Damaged(InputError):
    """A file of drift is not what this package has written."""


def health_text(kind: str, health: Health, gearbox_serial: str, **more: Any) -> str:
    """
    Return the file of a Health: a line of JSON, and a line with its checksum.

    Args:
        kind: BASELINE or STATE.
        health: to keep.
        gearbox_serial: of the gearbox.
        more: plain data that the file holds, too.

    """
    body = json.dumps({
        'kind': kind, 'format': FORMAT, 'gearbox_monitor': __version__,
        'gearbox_serial': gearbox_serial, 'date': time.strftime('%Y-%m-%dT%H:%M:%S%z'),
        **more, 'health': to_data(health)})
    return f'{body}\n{crc32(body.encode()):08x}\n'


def _read(path: Path) -> str:
    """Return the text of a file. Raises FileNotFoundError, and InputError for any other reason."""
    try:
        with open_file(path) as file:
            return file.read().decode('utf-8', 'replace')
    except FileNotFoundError:
        raise
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable file') from None


def _content(path: Path, text: str, kind: str, gearbox_serial: str) -> dict[str, Any]:
    """
    Return the content of the file of a Health.

    Args:
        path: of the file.
        text: in it.
        kind: BASELINE or STATE.
        gearbox_serial: of the gearbox that it must belong to, '' for any.

    Raises:
        InputError: it is of another version or gearbox; Damaged: it is not as it was written.

    """
    body, _, end = text.rstrip('\n').rpartition('\n')
    if f'{crc32(body.encode()):08x}' != end:
        if 'format' in text and '"kind"' not in text:
            raise InputError(f'{path}: a {kind} of another version: save the baseline again')
        raise Damaged(f'{path}: the checksum does not fit, expected a {kind} as it was written')
    data: dict[str, Any] = json.loads(body)
    if data['format'] != FORMAT or data['kind'] != kind:
        raise InputError(f'{path}: a {data["kind"]} of format {data["format"]}, expected a {kind} '
                         f'of format {FORMAT}: save the baseline again')
    if gearbox_serial and data['gearbox_serial'] != gearbox_serial:
        raise InputError(f'{path}: gearbox_serial: {data["gearbox_serial"]!r}, expected '
                         f'{gearbox_serial!r}')
    try:
        from_data(HealthSettings(), data['health'])
    except (KeyError, TypeError, ValueError) as error:
        raise Damaged(f'{path}: {error!r}, expected a {kind} of this version') from None
    return data


def load_baseline(path: str | Path, gearbox_serial: str = '') -> dict[str, Any]:
    """
    Return the Health in the baseline `path`, as a Monitor takes it.

    Raises FileNotFoundError, Damaged, and InputError where the file cannot be read, is of another
    version or names another gearbox than `gearbox_serial`.
    """
    path = Path(path)
    health: dict[str, Any] = _content(path, _read(path), BASELINE, gearbox_serial)['health']
    return health


def earlier(parameters: Mapping[str, Any]) -> tuple[dict[str, Any] | None, str]:
    """
    Return (what was known of a gearbox before a recording, as a Monitor takes it; note or '').

    Args:
        parameters: of the estimator, by name; the baseline that baseline_file names counts.

    Raises:
        Damaged, InputError: that file cannot be used.

    """
    path = str(parameters.get('baseline_file') or '')
    if not path:
        return None, ''
    try:
        return load_baseline(path, str(parameters.get('gearbox_serial') or '')), ''
    except FileNotFoundError:
        return None, f'baseline_file: {path}: no such file, so there is nothing to compare with'


def save_baseline(path: str | Path, health: Health, gearbox_serial: str,
                  parameters: dict[str, Any]) -> None:
    """
    Write a baseline to a file, whole or not at all.

    Args:
        path: of the file; replaced if it exists.
        health: of judgement.accepted.
        gearbox_serial: of the gearbox that it belongs to.
        parameters: in force, for the record.

    Raises:
        InputError: if the file cannot be written.

    """
    write_whole(Path(path), health_text(BASELINE, health, gearbox_serial, parameters=parameters))


def load_state(path: str | Path, gearbox_serial: str) -> tuple[dict[str, Any] | None, str]:
    """
    Return (state or None, report or '') of the state file `path` of the gearbox `gearbox_serial`.

    The state: {'health': what a Monitor takes, 'recording_ns': stamp of the baseline recording, 0:
    none}.
    There may be no file yet. One that is damaged, of another version or of another gearbox is
    renamed to PATH.corrupt-DATE. Raises InputError where it cannot be read or renamed.
    """
    path = Path(path)
    try:
        text = _read(path)
    except FileNotFoundError:
        return None, ''
    try:
        return _content(path, text, STATE, gearbox_serial), ''
    except InputError as error:
        return None, f'{error}: {set_aside(path)}; {AGAIN}'


def set_aside(path: str | Path, reason: str = 'corrupt') -> str:
    """Rename `path` to PATH.`reason`-DATE; return what to report. Raises InputError."""
    path = Path(path)
    aside = path.with_name(f'{path.name}.{reason}-{time.strftime("%Y%m%d-%H%M%S")}')
    try:
        os.replace(path, aside)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a file that can be renamed') \
            from None
    return f'set aside as {aside.name}'


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
        first, _, rows = read_bytes(path, LARGEST).partition(b'\n')
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
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable file') from None
    except InputError:
        raise
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
    pairs = [(name, getattr(recording, name), getattr(expected, name))
             for name in ('gearbox_serial', 'joints', 'stamp_ns')]
    pairs += [(f'model: {name}', recording.model.get(name), expected.model.get(name))
              for name in sorted({*recording.model, *expected.model})]
    for name, value, own_value in pairs:
        if value != own_value:
            raise InputError(f'{path}: of another gearbox, model or baseline: {name}: '
                             f'{str(value)[:60]}, expected {str(own_value)[:60]}')


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
        with suppress(OSError):  # on a full disk: the lock holds without the name of its owner
            os.write(file.fileno(), f'{self._owner}\n'.encode())
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
                note = '; '.join([*(f'{path}: not read at the start, {set_aside(path, "unread")}'
                                    for path in paths), *[AGAIN] * bool(paths)])
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
