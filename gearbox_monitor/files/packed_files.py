# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Files that may be gzipped, read within limits: four kilobytes can stand for four megabytes."""
from collections.abc import Iterator
import gzip
import io
from itertools import count
from pathlib import Path
import sys
from typing import BinaryIO, cast, IO

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file

EXPANSION = 256  # times its size; a text of measurements unpacks to a tenth of that
LONGEST_LINE = 1 << 20    # characters, of a compressed file
MAX_ROWS = 1 << 23        # lines of a compressed file, two hours at 1 kHz
MAX_WHOLE = 1 << 28       # bytes of a compressed file that is read as a whole, unpacked
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


def read_unpacked(path: str | Path) -> bytes:
    """Return all bytes of the file `path`, unpacked. Raises InputError."""
    with open_unpacked(path) as stream:
        if not isinstance(stream, BoundedGzip):
            return stream.read()
        pieces: list[bytes] = []
        while piece := stream.read(PIECE):
            pieces.append(piece)
            if len(pieces) * PIECE > MAX_WHOLE:
                raise InputError(f'{path}: unpacks to more than {MAX_WHOLE >> 20} MB, expected '
                                 'less, or the file unpacked: gunzip')
        return b''.join(pieces)


def lines_of(path: str | Path, encoding: str) -> Iterator[str]:
    """Yield the lines of the text file `path` in `encoding`, unpacked. Raises InputError."""
    source = open_unpacked(path)
    packed = isinstance(source, BoundedGzip)
    longest, rows = (LONGEST_LINE, MAX_ROWS) if packed else (-1, sys.maxsize)
    with io.TextIOWrapper(source, encoding=encoding, newline=None) as stream:
        for number in count():
            if not (line := stream.readline(longest)):
                return
            if len(line) == longest or number == rows:
                raise InputError(f'{path}: more than {rows} lines, or one of more than {longest} '
                                 'characters, in a compressed file, expected less, or the file '
                                 'unpacked: gunzip')
            yield line
