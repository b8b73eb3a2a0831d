# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Unpack zstd and lz4 in bounded memory: what is packed may state and yield any size.

Four bytes of zstd can stand for 128 kB. The limits follow from the packed size, not from the
stated one.
"""
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
import shutil
import tempfile
from typing import Any

import lz4.frame
import zstandard

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file

PACKED = '.zstd'     # suffix of a file that rosbag2 has compressed
PIECE = 1 << 24      # bytes unpacked at a time; so many are always unpacked
EXPANSION = 256      # no whole chunk of data unpacks to more times its size, lz4 to 255 at most
MAX_UNPACKED = 1 << 27  # bytes in memory at once; writers of bags end chunks at 1 to 4 MB
HEAD = 18            # bytes of a zstd frame that may state its size
SPARE = 1 << 28      # bytes of a disk that stay free
DAMAGE = (zstandard.ZstdError, RuntimeError, EOFError, MemoryError)


def unpacked_limit(size: int) -> int:
    """Return to how many bytes in memory `size` packed bytes may unpack."""
    return min(max(PIECE, EXPANSION * size), MAX_UNPACKED)


def unpack(packed: bytes, compression: str, size: int) -> tuple[bytes, str | None]:
    """
    Unpack a chunk, complete, damaged or cut.

    Args:
        packed: the packed bytes.
        compression: 'zstd', 'lz4' or '' (not packed).
        size: bytes that it shall unpack to.

    Returns:
        (As many of them as can be unpacked within `unpacked_limit`, the problem or None).
    """
    if compression == '':
        return packed[:size], None
    if compression not in ('zstd', 'lz4'):
        return b'', f'unknown compression {compression!r}'
    if 0 < size <= min(PIECE, EXPANSION * len(packed)):
        data = _unpack_whole(packed, compression, size)
        if data is not None:
            return data, None
    return _unpack_piecewise(packed, compression, min(size, unpacked_limit(len(packed))))


def unpack_message(packed: bytes) -> bytes:
    """Return what the zstd frame `packed` of one message unpacks to. Raises InputError."""
    limit = unpacked_limit(len(packed))
    data, problem = _unpack_piecewise(packed, 'zstd', limit + 1)
    if len(data) > limit:
        problem = f'{len(packed)} bytes unpack to more than {limit >> 20} MB'
    if problem:
        raise InputError(f'cannot unpack a message: {problem}')
    return data


@contextmanager
def unpacked_files(files: Sequence[Path]) -> Iterator[list[Path]]:
    """
    Yield `files`, those that rosbag2 has compressed unpacked into a temporary folder.

    Raises InputError if one is no zstd file, or unpacks to more than any recording does or than
    the disk has room for.
    """
    if not any(file.suffix == PACKED for file in files):
        yield list(files)
        return
    with tempfile.TemporaryDirectory(prefix='gearbox_monitor_') as folder:
        result = []
        for number, file in enumerate(files):
            result.append(file)
            if file.suffix == PACKED:
                result[-1] = Path(folder) / str(number) / file.stem
                result[-1].parent.mkdir()
                _unpack_file(file, result[-1])
        yield result


def _unpack_file(source: Path, target: Path) -> None:
    """Unpack the zstd file `source` to `target`; of a truncated one, its beginning. See above."""
    limit = max(PIECE, EXPANSION * source.stat().st_size)
    free = shutil.disk_usage(target.parent).free - SPARE
    total = 0

    def check(size: int) -> None:
        """Raise InputError if `size` bytes are more than may be unpacked."""
        if size > limit:
            raise InputError(f'{source}: unpacks to more than {EXPANSION} times its size, '
                             'expected a compressed recording')
        if size > free:
            raise InputError(f'{source}: unpacks to more than the {max(free, 0) >> 20} MB to '
                             f'spare in {tempfile.gettempdir()}, expected more free space')
    try:
        with open_file(source) as packed, open(target, 'wb') as file:
            check(zstandard.frame_content_size(packed.read(HEAD)))  # -1: it does not say
            packed.seek(0)
            stream = zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True)
            while piece := stream.read(PIECE >> 4):
                total += len(piece)
                check(total)
                file.write(piece)
    except zstandard.ZstdError as error:
        if not total:
            raise InputError(f'{source}: cannot unpack: {error}') from None
    except OSError as error:
        raise InputError(f'{source}: cannot unpack: {error.strerror}') from None


def _unpack_whole(packed: bytes, compression: str, size: int) -> bytes | None:
    """Return the `size` bytes that a complete frame unpacks to, None if it is no such frame."""
    data: bytes
    try:
        if compression == 'lz4':
            data = lz4.frame.LZ4FrameDecompressor().decompress(packed, size)
        elif zstandard.frame_content_size(packed) in (size, -1):  # -1: it does not say
            data = zstandard.ZstdDecompressor().decompress(packed, size)
        else:
            return None
    except DAMAGE:
        return None
    return data if len(data) == size else None


def _unpack_piecewise(packed: bytes, compression: str, size: int) -> tuple[bytes, str | None]:
    """Return what `unpack` does, of damaged and cut frames, too."""
    pieces: list[bytes] = []
    total = 0
    read: Any
    try:
        if compression == 'zstd':
            read = zstandard.ZstdDecompressor().stream_reader(packed).read
        else:
            read = lz4.frame.LZ4FrameFile(BytesIO(packed)).read1
        while total < size:
            piece = read(min(PIECE, size - total))
            if not piece:
                break
            pieces.append(piece)
            total += len(piece)
    except DAMAGE as error:
        return b''.join(pieces), str(error) or type(error).__name__
    return b''.join(pieces), None
