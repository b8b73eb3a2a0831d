# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Open recordings of all formats: bytes (gzipped or not), trees of fields, tables of columns.

A tree is a Mapping of Mappings, lists and arrays: MATLAB, JSON, HDF5 and NumPy files.
"""
from collections.abc import Iterator, Mapping
import contextlib
import csv
import gzip
import io
import json
from pathlib import Path
import struct
from types import ModuleType
from typing import Any, IO
import zipfile
import zlib

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import PIECE, read_unpacked

HDF5 = b'\x89HDF\r\n\x1a\n'
MAX_VALUES = 1 << 29  # bytes of all values of a compressed recording
MAT_COMPRESSED = 15   # type of an element in a MATLAB file
MATLAB_HEADER = 512  # bytes before the HDF5 content of a MATLAB 7.3 file


@contextlib.contextmanager
def readable(path: str | Path, encoding: str = 'utf-8') -> Iterator[None]:
    """Turn errors of reading the file `path` (text: in `encoding`) into InputErrors."""
    try:
        yield
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise InputError(f'{path}: {error}, expected a whole gzip file') from None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected a readable file') from None
    except csv.Error as error:
        raise InputError(f'{path}: {error}, expected a table of text with cells of numbers: is it '
                         'binary?') from None
    except UnicodeDecodeError as error:
        raise InputError(f'{path}: byte {error.object[error.start]:#04x} is not '
                         f'{error.encoding}, expected text in the encoding of the mapping '
                         f'({encoding})') from None


@contextlib.contextmanager
def opened_tree(path: str | Path, kind: str) -> Iterator[Any]:
    """
    Yield the tree of a file; large arrays of HDF5 are read when they are asked for.

    Args:
        path: of the file.
        kind: 'mat', 'json', 'hdf5' or 'numpy'.

    Raises:
        InputError: the file is damaged or of another format.
    """
    with readable(path):
        content = io.BytesIO(read_unpacked(path))
    head = content.getbuffer()[:MATLAB_HEADER + 8].tobytes()
    if kind == 'hdf5' or kind == 'mat' and HDF5 in (head[:8], head[MATLAB_HEADER:]):
        with _hdf5(path, content) as file:
            yield file
    elif kind == 'mat':
        _check_unpacked_size(path, content.getvalue())
        with _foreign(path, 'a MATLAB file'):
            tree = scipy.io.loadmat(content, simplify_cells=True)
        yield {name: value for name, value in tree.items() if not name.startswith('__')}
    elif kind == 'numpy':
        with _foreign(path, 'a NumPy file (.npy or .npz) without objects'):
            if head.startswith(b'PK'):
                with zipfile.ZipFile(content) as archive:
                    _expect_size(path, sum(entry.file_size for entry in archive.infolist()))
            loaded = np.load(content, allow_pickle=False)
            tree = dict(loaded) if isinstance(loaded, Mapping) else loaded
        yield tree
    else:
        yield _json(path, content.getvalue())


@contextlib.contextmanager
def _foreign(path: str | Path, expected: str) -> Iterator[None]:
    """Turn whatever a library raises for a foreign or a cut file into an InputError."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        raise InputError(f'{path}: {type(error).__name__} {error}, expected {expected}') from None


@contextlib.contextmanager
def _hdf5(path: str | Path, content: IO[bytes]) -> Iterator[Any]:
    h5py = reader_package('h5py', path)
    with _foreign(path, 'an HDF5 file'):
        file = h5py.File(content, 'r')
    with file:
        with _foreign(path, 'an HDF5 file'):  # a dataset may state any size and store nothing
            file.visititems(lambda _, entry: _expect_size(path, getattr(entry, 'nbytes', 0)))
        yield file


def _expect_size(path: str | Path, size: int) -> None:
    """Raise InputError if `size` bytes are more than is unpacked of the file `path`."""
    if size > MAX_VALUES:
        raise InputError(f'{path}: unpacks to more than {MAX_VALUES >> 20} MB, expected a smaller '
                         'recording')


def _check_unpacked_size(path: str | Path, content: bytes) -> None:
    """Raise InputError if the compressed variables of a MATLAB file unpack to too much."""
    order, offset, size = '<' if content[126:128] == b'IM' else '>', 128, 0
    while offset + 8 <= len(content):
        kind, length = struct.unpack_from(order + 'II', content, offset)
        offset += 8
        if kind == MAT_COMPRESSED:
            unpacker, packed = zlib.decompressobj(), content[offset:offset + length]
            with contextlib.suppress(zlib.error):  # scipy says so, too
                while packed:
                    size += len(unpacker.decompress(packed, PIECE))
                    packed = unpacker.unconsumed_tail
                    _expect_size(path, size)
        offset += length


def reader_package(name: str, path: str | Path) -> ModuleType:
    """Return the module `name`, which the file `path` needs. Raises InputError: not installed."""
    from importlib import import_module
    try:
        return import_module(name)
    except ModuleNotFoundError:
        package = name.partition('.')[0]
        raise InputError(f'{path}: {package} is not installed, expected it for this format: '
                         f'pip install {package}') from None


def _json(path: str | Path, content: bytes) -> Any:
    """Return the value of a JSON text, or the list of those on its lines (JSON lines)."""
    try:
        try:
            return json.loads(content)
        except json.JSONDecodeError as error:
            # The first value ends where its line ends: one value per line.
            if not error.msg.startswith('Extra data') or error.colno != 1 or error.lineno != 2:
                raise
            return [json.loads(line) for line in content.splitlines() if line.strip()]
    except json.JSONDecodeError as error:
        raise InputError(f'{path}: line {error.lineno} column {error.colno}: {error.msg}, '
                         'expected JSON') from None
    except (ValueError, RecursionError) as error:  # an endless number, nested too deeply
        raise InputError(f'{path}: {error}, expected JSON') from None


def opened_table(path: str | Path, kind: str) -> Any:
    """Return the pyarrow.Table of the file `path`, `kind` 'parquet' or 'feather'."""
    reader = reader_package(f'pyarrow.{kind}', path)
    with readable(path):
        content = read_unpacked(path)
    from pyarrow import BufferReader
    with _foreign(path, f'a {kind.capitalize()} file'):
        if kind == 'parquet':
            stated = reader.ParquetFile(BufferReader(content)).metadata
            _expect_size(path, 8 * stated.num_rows * stated.num_columns)
        table = reader.read_table(BufferReader(content))
        # A struct becomes columns 'name.part'.
        while any(str(field.type).startswith('struct') for field in table.schema):
            table = table.flatten()
        for k, field in enumerate(table.schema):  # categories become their names
            if str(field.type).startswith('dictionary'):
                table = table.set_column(k, field.name, table[k].cast(field.type.value_type))
        return table


def table_metadata(path: str | Path, kind: str) -> dict[str, str]:
    """Return the metadata of the Parquet or Feather file `path` (`kind`)."""
    metadata = opened_table(path, kind).schema.metadata or {}
    return {key.decode('utf-8', 'replace'): value.decode('utf-8', 'replace')
            for key, value in metadata.items()}


def attribute(tree: Any, name: str) -> Any:
    """Return field or attribute `name` (dotted: inside others) of a `tree`, None without it."""
    is_whole = isinstance(tree, Mapping) and name in tree  # a name with dots
    parts = [name] if is_whole else name.replace('/', '.').split('.')
    for part in parts[:-1]:
        if not isinstance(tree, Mapping) or part not in tree:
            return None
        tree = tree[part]
    if isinstance(tree, Mapping) and parts[-1] in tree:
        value = tree[parts[-1]]
        return None if isinstance(value, Mapping) else value
    return getattr(tree, 'attrs', {}).get(parts[-1])
