# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find bags behind paths, patterns and URLs (fsspec), and fetch them.

A folder is a bag if it holds ``metadata.yaml``, or only files named after it, as a killed recorder
leaves them. Any other folder is searched for bags.
"""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
import errno
import hashlib
import os
from pathlib import Path, PurePosixPath
import re
import shutil
import tempfile
from typing import Any, TypeAlias

import fsspec
from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem

from gearbox_monitor.bag.decompression import SPARE
from gearbox_monitor.bag.metadata import FILE_NAME
from gearbox_monitor.bag.read import natural
from gearbox_monitor.errors import InputError

SUFFIXES = ('.mcap', '.db3', '.bag')  # ROS 1 bags are found, too, to report them as foreign
BLOCK = 1 << 20
Entry: TypeAlias = Mapping[str, Any]  # name, type, size ... of a file or folder, from fsspec


@dataclass(frozen=True)
class FleetBag:
    """
    A bag to be analysed.

    url: a URL or path that opens it. size: bytes of its recordings, None if unknown. fingerprint:
    changes with each of its files. problem: why it cannot be read, or ''.
    """

    url: str
    size: int | None = None
    fingerprint: str = ''
    problem: str = ''


def find_bags(words: Iterable[str]) -> list[FleetBag]:
    """
    Return the FleetBags behind `words` (paths, patterns, URLs), each once, in their order.

    Raises InputError for a word without any bag.
    """
    bags: dict[str, FleetBag] = {}
    for word in words:
        fs, path = _opened(word)
        try:
            paths = [path]
            if not fs.exists(path):
                paths = _sorted(fs.glob(path)) if re.search(r'[*?\[]', path) else []
            matches = [bag for path in paths
                       for bag in _below(fs, fs.info(path), word, explicit=True)]
        except OSError as error:
            raise InputError(f'{word}: {error.strerror or error}, expected a readable path') \
                from None
        if not paths:
            raise InputError(f'{word}: no such file or directory, expected a bag, a folder of '
                             'bags, a pattern or a URL')
        if not matches:
            raise InputError(f'{word}: holds no bag, expected bag directories, .mcap or .db3 '
                             'files')
        bags.update((bag.url, bag) for bag in matches if bag.url not in bags)
    return list(bags.values())


def _sorted(paths: Iterable[str]) -> list[str]:
    """Return `paths` in natural order: file_2 precedes file_10."""
    return sorted(paths, key=natural)


def _opened(url: str) -> tuple[AbstractFileSystem, str]:
    """Return (file system, path in it) of a path or URL. Raises InputError."""
    try:
        fs, path = fsspec.core.url_to_fs(url)
    except (ValueError, ImportError, OSError) as error:
        raise InputError(f'{url}: {" ".join(str(error).split())}, expected a path or a URL that '
                         'fsspec can open') from None
    return fs, path


def _below(fs: AbstractFileSystem, entry: Entry, word: str, explicit: bool = False,
           parents: tuple[Path | str, ...] = ()) -> Iterator[FleetBag]:
    """
    Yield the FleetBags at and below `entry` of the file system `fs`.

    word: through which the user named it; explicit: whether the user named it itself; parents: the
    folders above it.
    """
    path = entry['name']
    if entry['type'] == 'file':
        if explicit or path.endswith(SUFFIXES):
            yield _bag(fs, path, word, [entry], [entry])
        return
    if entry['type'] != 'directory':  # a broken link, a pipe
        if explicit or path.endswith(SUFFIXES):
            yield FleetBag(_url(fs, path, word), problem='not a file, expected a bag')
        return
    real = Path(path).resolve() if isinstance(fs, LocalFileSystem) else path
    if real in parents:  # a link to a folder above
        return
    try:
        entries = fs.ls(path, detail=True)
    except OSError as error:
        yield FleetBag(_url(fs, path, word), problem=f'cannot be read: {error.strerror or error}')
        return
    entries = sorted((e for e in entries if e['name'].rstrip('/') != path.rstrip('/')),
                     key=lambda child: natural(child['name']))
    files = [e for e in entries if e['type'] != 'directory']
    if is_bag(_name(path), [_name(e['name']) for e in files]) or (not entries and not explicit):
        yield _bag(fs, path, word, files, [e for e in files if _is_recording(e['name'])])
        return
    for child in entries:
        if not _name(child['name']).startswith('.'):
            yield from _below(fs, child, word, parents=(*parents, real))


def is_bag(name: str, files: Sequence[str]) -> bool:
    """Return whether the folder `name` with these `files` is one bag."""
    recordings = [file for file in files if file.endswith(SUFFIXES)]
    return FILE_NAME in files or bool(recordings) and all(
        re.fullmatch(rf'{re.escape(name)}_\d+\.\w+', file) for file in recordings)


def _name(path: str) -> str:
    return PurePosixPath(path).name


def _is_recording(path: str) -> bool:
    """Return whether `path` is a recording of a bag; rosbag2 may have compressed it."""
    return bool(re.search(r'\.(mcap|db3|bag)(\.\w+)?$', path)) and \
        not _name(path).startswith('.')


def _bag(fs: AbstractFileSystem, path: str, word: str, files: Sequence[Entry],
         recordings: Sequence[Entry]) -> FleetBag:
    if any(entry['type'] == 'other' for entry in files):
        return FleetBag(_url(fs, path, word), problem='holds a pipe or device, expected files')
    sizes = [entry.get('size') for entry in recordings]
    content = [sorted((key, str(value)) for key, value in entry.items()) for entry in files]
    return FleetBag(_url(fs, path, word),
                    None if None in sizes else sum(size for size in sizes if size is not None),
                    hashlib.sha256(repr(content).encode()).hexdigest()[:32])


def _url(fs: AbstractFileSystem, path: str, word: str) -> str:
    """Return the URL that opens `path` of `fs`, which was found behind `word`."""
    if isinstance(fs, LocalFileSystem):
        return path
    first, chain, tail = word.partition('::')
    url: str = fs.unstrip_protocol(path)
    if not chain:
        return url
    # In zip://*.mcap::file.zip the path is that in the archive, in simplecache::s3://... the last.
    return f'{url}::{tail}' if '://' in first else f'{first}::{url}'


# ---------------------------------------------------------------------- content


@contextmanager
def fetched(url: str) -> Iterator[Path]:
    """
    Yield the local path of the bag `url`: itself, or a temporary copy.

    Raises OSError where the disk has no room for the copy.
    """
    fs, path = _opened(url)
    if isinstance(fs, LocalFileSystem):
        yield Path(path)
        return
    with tempfile.TemporaryDirectory(prefix='gearbox_monitor_') as folder:
        copy = Path(folder) / _name(path)
        entries = fs.ls(path, detail=True) if fs.isdir(path) else [fs.info(path)]
        entries = [entry for entry in entries if entry['name'] == path
                   or _is_recording(entry['name']) or _name(entry['name']) == FILE_NAME]
        size = sum(entry.get('size') or 0 for entry in entries)
        if size > shutil.disk_usage(folder).free - SPARE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if fs.isdir(path):
            copy.mkdir()
            for entry in entries:
                fs.get_file(entry['name'], str(copy / _name(entry['name'])))
        else:
            fs.get_file(path, str(copy))
        yield copy


def content_hash(url: str) -> str:
    """
    Return the SHA-256 of the recordings of the bag `url`, in their order, as hex digits.

    Names and ``metadata.yaml`` do not count: a bag that was renamed or moved keeps its hash.
    """
    fs, path = _opened(url)
    files = [path]
    if fs.isdir(path):
        files = _sorted(filter(_is_recording, fs.ls(path, detail=False)))
    digest = hashlib.sha256()
    for file in files:
        with fs.open(file, 'rb') as stream:
            while block := stream.read(BLOCK):
                digest.update(block)
    return digest.hexdigest()
