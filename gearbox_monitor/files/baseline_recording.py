# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The recording of a healthy gearbox, kept beside the state of drift: to tell later what changed.

A line of JSON says what it is of; packed rows follow. It is written whole, and belongs to one
gearbox, one model file and one baseline, which the state of drift names.
"""
from collections.abc import Iterable
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any
from zlib import crc32

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import Damaged
from gearbox_monitor.files.opening import open_file

FORMAT = 1
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
        head = {'format': FORMAT, 'gearbox_monitor': __version__, 'stamp_ns': self.stamp_ns,
                'gearbox_serial': self.gearbox_serial, 'joints': self.joints, 'model': self.model,
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
        if head['format'] != FORMAT:
            raise Damaged(f'{path}: format {head["format"]!r}, expected {FORMAT}')
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
