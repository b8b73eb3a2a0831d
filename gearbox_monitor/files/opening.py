# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Open a file of a user: a pipe or device is refused, never waited for; write a new one."""
import errno
import os
from pathlib import Path
import stat
from typing import BinaryIO

from gearbox_monitor.errors import InputError


def open_file(path: str | Path) -> BinaryIO:
    """Return the file `path`, opened for reading bytes. Raises OSError."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return open(descriptor, 'rb')
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
