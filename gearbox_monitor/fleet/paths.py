# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Find bags behind paths, patterns and URLs (fsspec), and bring them to where they can be read.

A folder is a bag when it holds ``metadata.yaml``, or only files that are called after it, as a
recorder leaves them that was killed. Any other folder is searched for bags.
"""
from contextlib import contextmanager
from dataclasses import dataclass
import hashlib
from pathlib import Path, PurePosixPath
import re
import tempfile

import fsspec
from fsspec.implementations.local import LocalFileSystem

from gearbox_monitor.errors import InputError

METADATA = 'metadata.yaml'
SUFFIXES = ('.mcap', '.db3', '.bag')  # ROS 1 bags are found, too, to say that they are foreign
BLOCK = 1 << 20


@dataclass(frozen=True)
class FleetBag:
    """
    A bag to be analysed.

    url: what the user may call it again by. size: bytes of its recordings, None where that is not
    known. fingerprint: changes when one of its files does. problem: why it cannot be read, or ''.
    """

    url: str
    size: int | None = None
    fingerprint: str = ''
    problem: str = ''


def find_bags(words):
    """
    Return the FleetBags behind `words` (paths, patterns, URLs), each once, in their order.

    Raises InputError for a word without any bag.
    """
    bags = {}
    for word in words:
        fs, path = _opened(word)
        try:
            paths = [path]
            if not fs.exists(path):
                paths = sorted(fs.glob(path), key=natural) if re.search(r'[*?\[]', path) else []
            found = [bag for path in paths for bag in _below(fs, fs.info(path), word, given=True)]
        except OSError as error:
            raise InputError(f'{word}: {error.strerror or error}, expected a readable path') \
                from None
        if not paths:
            raise InputError(f'{word}: no such file or directory, expected a bag, a folder of '
                             'bags, a pattern or a URL')
        if not found:
            raise InputError(f'{word}: holds no bag, expected bag directories, .mcap or .db3 '
                             'files')
        bags.update((bag.url, bag) for bag in found if bag.url not in bags)
    return list(bags.values())


def natural(path):
    """Return a key that sorts file_2 before file_10."""
    return [int(part) if part.isdigit() else part for part in re.split(r'(\d+)', str(path))]


def _opened(url):
    """Return (file system, path in it) of a path or URL. Raises InputError."""
    try:
        return fsspec.core.url_to_fs(url)
    except (ValueError, ImportError, OSError) as error:
        raise InputError(f'{url}: {" ".join(str(error).split())}, expected a path or a URL that '
                         'fsspec can open') from None


def _below(fs, info, word, given=False, seen=()):
    """Yield the FleetBags at and below what `info` describes; given: by the user, as it is."""
    path = info['name']
    if info['type'] == 'file':
        if given or path.endswith(SUFFIXES):
            yield _bag(fs, path, word, [info], [info])
        return
    if info['type'] != 'directory':  # a broken link, a pipe
        if given or path.endswith(SUFFIXES):
            yield FleetBag(_url(fs, path, word), problem='is no file, expected a bag')
        return
    real = Path(path).resolve() if isinstance(fs, LocalFileSystem) else path
    if real in seen:  # a link to a folder above
        return
    try:
        entries = fs.ls(path, detail=True)
    except OSError as error:
        yield FleetBag(_url(fs, path, word), problem=f'cannot be read: {error.strerror or error}')
        return
    entries = sorted((e for e in entries if e['name'].rstrip('/') != path.rstrip('/')),
                     key=lambda entry: natural(entry['name']))
    files = [e for e in entries if e['type'] != 'directory']
    if is_bag(_name(path), [_name(e['name']) for e in files]) or (not entries and not given):
        yield _bag(fs, path, word, files, [e for e in files if _is_recording(e['name'])])
        return
    for entry in entries:
        if not _name(entry['name']).startswith('.'):
            yield from _below(fs, entry, word, seen=(*seen, real))


def is_bag(name, files):
    """Return whether the folder `name` with these `files` is one bag."""
    recordings = [file for file in files if file.endswith(SUFFIXES)]
    return METADATA in files or bool(recordings) and all(
        re.fullmatch(rf'{re.escape(name)}_\d+\.\w+', file) for file in recordings)


def _name(path):
    return PurePosixPath(path).name


def _is_recording(path):
    """Return whether `path` is part of a bag's content; rosbag2 may have compressed it."""
    return bool(re.search(r'\.(mcap|db3|bag)(\.\w+)?$', path)) and \
        not _name(path).startswith('.')


def _bag(fs, path, word, files, recordings):
    sizes = [info.get('size') for info in recordings]
    known = [sorted((key, str(value)) for key, value in info.items()) for info in files]
    return FleetBag(_url(fs, path, word), None if None in sizes else sum(sizes),
                    hashlib.sha256(repr(known).encode()).hexdigest()[:32])


def _url(fs, path, word):
    """Return what opens `path` of `fs`, which was found behind `word`."""
    if isinstance(fs, LocalFileSystem):
        return path
    first, chain, rest = word.partition('::')
    if not chain:
        return fs.unstrip_protocol(path)
    # In zip://*.mcap::file.zip the path is that in the archive, in simplecache::s3://... the last.
    return (f'{fs.unstrip_protocol(path)}::{rest}' if '://' in first else
            f'{first}::{fs.unstrip_protocol(path)}')


# ---------------------------------------------------------------------- content


@contextmanager
def fetched(url):
    """Give the local Path of the bag `url`: itself, or a copy for as long as it is needed."""
    fs, path = _opened(url)
    if isinstance(fs, LocalFileSystem):
        yield Path(path)
        return
    with tempfile.TemporaryDirectory(prefix='gearbox_monitor_') as folder:
        copy = Path(folder) / _name(path)
        if fs.isdir(path):
            copy.mkdir()
            for file in fs.ls(path, detail=False):
                if _is_recording(file) or _name(file) == METADATA:
                    fs.get_file(file, str(copy / _name(file)))
        else:
            fs.get_file(path, str(copy))
        yield copy


def content_hash(url):
    """
    Return the SHA-256 of the recordings of the bag `url`, in their order, as hex digits.

    Names and ``metadata.yaml`` do not count: a bag that was renamed or moved has the same.
    """
    fs, path = _opened(url)
    files = [path]
    if fs.isdir(path):
        files = sorted(filter(_is_recording, fs.ls(path, detail=False)), key=natural)
    digest = hashlib.sha256()
    for file in files:
        with fs.open(file, 'rb') as stream:
            while block := stream.read(BLOCK):
                digest.update(block)
    return digest.hexdigest()
