# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Open files of a user within limits, write new ones whole, and find those of ``config/``.

A pipe or device is refused, never waited for. A file may be gzipped: four kilobytes can stand for
four megabytes.
"""
import errno
import gzip
import io
import json
import math
import os
from pathlib import Path
import stat
import sys
from typing import Any, BinaryIO, cast, IO

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.robot.description import LONGEST, parse, RobotDescription


def open_file(path: str | Path, buffering: int = -1) -> BinaryIO:
    """Return the file `path`, opened for bytes; `buffering` as of open. Raises OSError."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return open(descriptor, 'rb', buffering)
    os.close(descriptor)
    code = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
    reason = os.strerror(code) if stat.S_ISDIR(mode) else 'a pipe or device, not a file'
    raise OSError(code, reason, str(path))


def read_bytes(path: str | Path, limit: int) -> bytes:
    """
    Return the content of the file `path`, of at most `limit` bytes.

    Raises OSError, and ValueError for a larger file.
    """
    with open_file(path) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise ValueError(f'more than {limit >> 20} MB')
    return data


def read_text(path: str | Path, limit: int) -> str:
    """
    Return the text (UTF-8) of the file `path`, of at most `limit` bytes.

    Raises OSError, and ValueError for a larger file or one that is not a text.
    """
    return read_bytes(path, limit).decode('utf-8')


def write_new(path: str | Path, content: str | bytes) -> Path:
    """Write `content` to the new file `path`, and return that. Raises InputError."""
    try:
        with open(path, 'xb') as file:
            file.write(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a new, writable file') from None
    return Path(path)


EXPANSION = 256  # times its size; a text of measurements unpacks to a tenth of that
LONGEST_LINE = 1 << 20    # characters, of a compressed file
PIECE = 1 << 20


class BoundedGzip(gzip.GzipFile):
    """The gzip file `path`, open as `stream`; an InputError when it unpacks to too much."""

    def __init__(self, path: str | Path, stream: BinaryIO) -> None:
        super().__init__(fileobj=stream)
        size = stream.seek(0, io.SEEK_END)
        stream.seek(0)
        self._path, self._left = path, max(EXPANSION * size, PIECE)

    def read1(self, size: int = -1) -> bytes:
        """Return up to `size` bytes."""
        return self._counted(super().read1(size))

    def read(self, size: int | None = -1) -> bytes:
        """Return `size` bytes; -1: all."""
        return self._counted(super().read(size))

    def _counted(self, data: bytes) -> bytes:
        self._left -= len(data)
        if self._left < 0:
            raise InputError(f'{self._path}: unpacks to more than {EXPANSION} times its size, '
                             'expected a compressed recording')
        return data


def open_unpacked(path: str | Path) -> IO[bytes]:
    """Open `path` for reading bytes, unpacked if its first bytes are those of gzip."""
    stream = open_file(path)
    packed = stream.read(2) == b'\x1f\x8b'
    stream.seek(0)
    return cast(IO[bytes], BoundedGzip(path, stream)) if packed else stream


MAX_JSON = 1 << 26  # bytes of a file


def plain(value: Any) -> Any:
    """Return `value` of plain Python types; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def dump(data: Any) -> str:
    """Return the plain `data` as JSON."""
    return json.dumps(data, indent=2, allow_nan=False)


def read_json(path: str | Path, expected: str) -> Any:
    """
    Return the content of a JSON file.

    Args:
        path: of the file.
        expected: what the file should be, for the message.

    Raises:
        InputError: no such file, or no JSON.
    """
    try:
        return json.loads(read_text(path, MAX_JSON))
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected {expected}') from None
    except (ValueError, RecursionError):
        raise InputError(f'{path}: no JSON, expected {expected}') from None


def config_path(name: str) -> Path:
    """
    Return the path of the packaged configuration file `name`, for example ``drive.yaml``.

    Raises InputError when no installation holds it.
    """
    package = Path(__file__).resolve().parents[1]
    checkout = package.parent
    roots = [checkout / 'config'] if (checkout / 'package.xml').is_file() else []
    # The prefix that this package is installed in comes first: another may hold another version.
    prefixes: list[str | Path] = [
        *package.parents, *os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    shares = [Path(p) / 'share/gearbox_monitor/config' for p in prefixes if p]
    roots += [share for share in dict.fromkeys(shares) if share.is_dir()]
    for root in roots:
        if (root / name).is_file():
            return root / name
    places = ', '.join(map(str, roots)) or 'share/gearbox_monitor/config, which is not installed'
    raise InputError(f'{name}: not found, expected in {places}')


TOPIC = 'topic:'  # begins a robot_description that names a topic


def load_robot(path: str) -> RobotDescription:
    """Return the robot of the URDF file `path`, a robot_description. Raises InputError."""
    if path.startswith(TOPIC):
        raise InputError(f'robot_description: {path}: a topic, which only a node can read; '
                         'expected a file')
    try:
        text = read_text(path, LONGEST)
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise InputError(f'robot_description: {path}: {reason}, expected a URDF file') from None
    return parse(text, path)
