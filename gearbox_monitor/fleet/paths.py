# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find the bags behind paths and patterns.

A folder is a bag if it holds ``metadata.yaml``, or only files named after it, as a killed recorder
leaves them. Any other folder is searched for bags.
"""
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from glob import glob
import hashlib
import os
from pathlib import Path
import re

from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.read import natural
from gearbox_monitor.recordings.storage import FILE_NAME
from gearbox_monitor.removed import refusal

SUFFIXES = ('.mcap', '.db3', '.bag')  # ROS 1 bags are found, too, to report them as foreign


@dataclass(frozen=True)
class FleetBag:
    """
    A bag to be analysed.

    path: absolute. bytes: of its recordings. fingerprint: size and time of each of its files, in
    hex digits. problem: why it cannot be read, or ''.
    """

    path: str
    bytes: int | None = None
    fingerprint: str = ''
    problem: str = ''


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
        matches = [bag for path in paths for bag in _below(Path(os.path.abspath(path)), True)]
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
