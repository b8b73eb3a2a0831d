# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
Read a file of arrays in a process of its own, which has limits: started by recordings.table.

Arguments: the file, its kind, the NumPy archive to write, CPU seconds, bytes of memory. In it
are arrays [N] in the order of 'index', JSON with their names and units, names of joints and
numbers of the header. A file that cannot be read is one line on the standard error with exit code
3, and 4 where memory is short. Needs nothing of the package.
"""
from collections import Counter
from collections.abc import Iterator, Mapping
import gzip
from importlib import import_module
import io
import json
import math
import os
import re
import resource
import sys
from typing import Any
import zipfile

import numpy as np

FAILED, TOO_LARGE = 3, 4
MIN_SAMPLES = 100   # a matrix with fewer rows and more columns has a row for each signal
MOST_COLUMNS = 4096
MAX_DEPTH = 12
MODULES = {'hdf5': 'h5py', 'mat': 'scipy.io', 'parquet': 'pyarrow.parquet',
           'feather': 'pyarrow.feather'}
JOINT_LISTS = ('joint_names', 'joint_sequence', 'dof_names', 'joints', 'names')
EPISODE = re.compile(r'(?i)(demo|episode|ep|traj|trajectory|rollout|trial|run)[_-]?\d+')
DATE = re.compile(r'\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d')
Leaf = tuple[str, Any, str]  # name, array, unit


class Unreadable(Exception):
    """The file cannot be read: the reason and what was expected."""


def limited(cpu_seconds: int, memory: int) -> None:
    """Limit this process to `cpu_seconds`, and to `memory` bytes beyond what it has now."""
    with open('/proc/self/status', encoding='ascii') as status:
        own = next(int(line.split()[1]) << 10 for line in status if line.startswith('VmData'))
    resource.setrlimit(resource.RLIMIT_DATA, (own + memory, own + memory))
    spent = math.ceil(sum(resource.getrusage(resource.RUSAGE_SELF)[:2]))
    resource.setrlimit(resource.RLIMIT_CPU, (spent + cpu_seconds, spent + cpu_seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def opened(path: str, memory: int) -> Any:
    """Return the file `path` as a stream, unpacked in half of `memory` where it is gzipped."""
    stream = open(path, 'rb')
    if stream.read(2) != b'\x1f\x8b':
        stream.seek(0)
        return stream
    stream.seek(0)
    with gzip.open(stream) as packed:
        data = packed.read(memory // 2 + 1)
    if len(data) > memory // 2:
        raise MemoryError
    return io.BytesIO(data)


# --- trees --------------------------------------------------------------------------------------
def tree_of(module: Any, stream: Any, kind: str, memory: int) -> Any:
    """Return the tree of mappings, lists and arrays in a file of a `kind`, read by a `module`."""
    if kind == 'hdf5':
        return module.File(stream, 'r')
    if kind == 'mat':
        tree = module.loadmat(stream, simplify_cells=True)
        return {name: value for name, value in tree.items() if not name.startswith('__')}
    if kind == 'numpy':
        if zipfile.is_zipfile(stream):
            with zipfile.ZipFile(stream) as archive:
                if sum(entry.file_size for entry in archive.infolist()) > memory:
                    raise MemoryError
        stream.seek(0)
        loaded = np.load(stream, allow_pickle=False)
        return dict(loaded) if isinstance(loaded, Mapping) else loaded
    content = stream.read()
    try:
        return json.loads(content)
    except json.JSONDecodeError as error:
        # The first value ends where its line ends: one value per line.
        if not error.msg.startswith('Extra data') or error.colno != 1 or error.lineno != 2:
            raise Unreadable(f'line {error.lineno} column {error.colno}: {error.msg}, expected '
                             'JSON') from None
        return [json.loads(line) for line in content.splitlines() if line.strip()]


def link_of(group: Any, name: str) -> str:
    """Return the kind of the link `name` of an HDF5 group, '' for an entry of its own."""
    kind = type(group.get(name, getlink=True)).__name__ if hasattr(group, 'id') else 'HardLink'
    return '' if kind == 'HardLink' else kind


def leaves_of(tree: Any, prefix: str = '', depth: int = 0) -> Iterator[Leaf]:
    """Yield (dotted name behind `prefix`, value, unit) of all arrays in a tree, at a `depth`."""
    if depth > MAX_DEPTH:
        raise Unreadable(f'{prefix}: groups more than {MAX_DEPTH} deep, expected fewer')
    if isinstance(tree, Mapping):
        for name in list(tree):
            if link_of(tree, name):
                NOTES.append(f'{prefix}{name}: a {link_of(tree, name)}, not followed')
                continue
            yield from leaves_of(tree[name], f'{prefix}{name}.', depth + 1)
        return
    name, attributes = prefix[:-1], getattr(tree, 'attrs', {})
    expect_values(tree, name)
    if fields := getattr(getattr(tree, 'dtype', None), 'names', None):
        yield from leaves_of({field: np.asarray(tree[field]) for field in fields}, prefix, depth)
        return
    value = array_of(tree[()] if hasattr(tree, 'attrs') else tree, name)
    if value.dtype.kind == 'O' and value.ndim == 1 and len(value) and all(
            isinstance(part, Mapping) for part in value):  # structures of MATLAB
        yield from entry_leaves(list(value), prefix) if len(value) >= MIN_SAMPLES else leaves_of(
            {str(k): part for k, part in enumerate(value, 1)}, prefix, depth)
        return
    stated = attributes.get('units', attributes.get('unit', ''))
    yield name, value.T if 'MATLAB_class' in attributes else value, (  # stores columns as rows
        stated.decode('utf-8', 'replace') if isinstance(stated, bytes) else str(stated))


def expect_values(tree: Any, name: str) -> None:
    """Raise Unreadable or MemoryError for a `tree`, called `name`, that is not safe to read."""
    if getattr(tree, 'is_virtual', False):
        raise Unreadable(f'{name}: a virtual dataset, expected one that holds its values')
    if getattr(tree, 'external', None):
        raise Unreadable(f'{name}: values in another file, expected a dataset that holds them')
    if getattr(tree, 'nbytes', 0) > LIMITS[1]:
        raise MemoryError


def episodes_of(tree: Any, depth: int = 0) -> dict[str, list[Leaf]]:
    """Return {name of an episode: its leaves} of a tree whose groups are episodes, else {}."""
    if not isinstance(tree, Mapping) or depth > 3:
        return {}
    own = [name for name in tree if not link_of(tree, name)]
    groups = [name for name in own if EPISODE.fullmatch(name) and isinstance(
        tree[name], Mapping)]
    groups.sort(key=lambda name: int(re.findall(r'\d+', name)[-1]))
    return {name: list(leaves_of(tree[name])) for name in groups} or next(filter(
        None, (episodes_of(tree[name], depth + 1) for name in own)), {})


def joined(episodes: Mapping[str, list[Leaf]]) -> Iterator[Leaf]:
    """Yield the leaves of all episodes, one after the other, and the number of each row's."""
    lengths = [Counter(len(value) for _, value, _ in leaves if value.ndim)
               for leaves in episodes.values()]
    counts = [own.most_common(1)[0][0] if own else 0 for own in lengths]
    parts = [{leaf[0]: leaf for leaf in leaves if leaf[1].ndim and len(leaf[1]) == count}
             for leaves, count in zip(episodes.values(), counts)]
    whole = [name for name, (_, value, _) in parts[0].items() if all(
        name in own and own[name][1].shape[1:] == value.shape[1:] for own in parts)]
    for name in whole:
        yield name, np.concatenate([own[name][1] for own in parts]), parts[0][name][2]
    others = dict.fromkeys(leaf[0] for leaves in episodes.values() for leaf in leaves
                           if leaf[1].ndim and leaf[0] not in whole)
    if others:
        NOTES.append(f'of another length than its episode, not used: {", ".join(others)[:200]}')
    numbers = [int(re.findall(r'\d+', name)[-1]) for name in episodes]
    yield 'episode', np.repeat(numbers, counts), ''


# --- entries: a list of mappings or of rows -----------------------------------------------------
def entries_in(tree: Any, depth: int = 0) -> list[Any] | None:
    """Return the list of mappings or rows in the `tree` of JSON, at a `depth`; None: none."""
    if isinstance(tree, list):
        rows = len(tree) >= MIN_SAMPLES or tree and isinstance(tree[0], list)
        return tree if rows and isinstance(tree[0], (dict, list)) else None
    for value in tree.values() if isinstance(tree, dict) and depth < 4 else ():
        entries = entries_in(value, depth + 1)
        if entries is not None:
            return entries
    return None


def entry_leaves(entries: list[Any], prefix: str = '') -> Iterator[Leaf]:
    """Yield the columns of a list of entries, behind `prefix`."""
    if isinstance(entries[0], list):
        yield '', array_of(entries, 'rows'), ''
        return
    flat = [dict(flattened(entry)) for entry in entries if isinstance(entry, Mapping)]
    for field in dict.fromkeys(key for entry in flat[:MIN_SAMPLES] for key in entry):
        values = [entry.get(field) for entry in flat]
        lists = [value for value in values if isinstance(value, list)]
        if field in ('name', 'joint_names') and lists and all(
                isinstance(name, str) for name in lists[0]):
            if any(value != lists[0] for value in values):
                raise Unreadable(f'{field}: other joints in some entries, expected the same')
            JOINTS.extend(lists[0])
        elif not lists or len(lists) == len(values) and len(set(map(len, lists))) == 1:
            yield prefix + field, array_of(values, prefix + field), ''


def flattened(entry: Mapping[str, Any], prefix: str = '', depth: int = 0
              ) -> Iterator[tuple[str, Any]]:
    """Yield (dotted name behind `prefix`, value) of an entry, at a `depth`."""
    for name, value in entry.items():
        if isinstance(value, Mapping) and depth < MAX_DEPTH:
            yield from flattened(value, f'{prefix}{name}.', depth + 1)
        else:
            yield f'{prefix}{name}', value


def table_leaves(module: Any, stream: Any, kind: str) -> Iterator[Leaf]:
    """Yield the columns of a Parquet or Feather file; structures and lists by their parts."""
    import pyarrow as pa
    table = module.ParquetFile(stream).read(use_threads=False) if kind == 'parquet' else \
        module.read_table(stream, use_threads=False)
    for key, value in (table.schema.metadata or {}).items():
        put_number(key.decode('utf-8', 'replace'), value.decode('utf-8', 'replace'))
    for _ in range(MAX_DEPTH):
        table = table.flatten()
    for name, column in zip(table.column_names, table.columns):
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        if not hasattr(column.type, 'value_type'):
            yield name, array_of(column.to_numpy(), name), ''
        elif not column.null_count:
            rows = column.to_pylist()
            for k in range(min(map(len, rows), default=0)):
                yield f'{name}.{k + 1}', array_of([row[k] for row in rows], name), ''


# --- result -------------------------------------------------------------------------------------
NOTES: list[str] = []
HEADER: dict[str, float] = {}
JOINTS: list[str] = []
LIMITS = [20, 1 << 30]


def put_number(name: str, value: Any) -> None:
    """Note `value`, a number, text or an array of one number, in the header as `name`."""
    try:
        number = float(np.squeeze(np.asarray(value)))
    except (TypeError, ValueError, OverflowError):
        return
    if math.isfinite(number):
        HEADER[name] = number


def array_of(values: Any, name: str) -> Any:
    """Return the `values` of a leaf `name` as numbers, NaN for None, texts, times or objects."""
    try:
        value = np.asarray(values)
    except ValueError:
        raise Unreadable(f'{name}: rows of unequal length, expected a matrix') from None
    kind = value.dtype.kind
    if kind == 'S':
        return np.char.decode(value, 'utf-8', 'replace')
    if kind == 'O':
        kinds = {type(x) for x in value.flat} - {type(None)}
        if kinds <= {str, bytes}:
            return np.array([x.decode('utf-8', 'replace') if isinstance(x, bytes) else x or ''
                             for x in value.flat]).reshape(value.shape)
        try:
            return value.astype(float) if kinds <= {int, float, bool} else value
        except OverflowError:
            raise Unreadable(f'{name}: a number beyond all floats, expected numbers') from None
    if kind in 'bu':
        return value.astype(float if kind == 'u' and value.itemsize == 8 else np.int64)
    return value


def columns_of(leaves: Iterator[Leaf]) -> Iterator[Leaf]:
    """Yield the columns [N] of `leaves`; matrices by column, with numbers from 1."""
    for name, value, unit in leaves:
        kind = value.dtype.kind
        if kind == 'U' and name.rpartition('.')[2] in JOINT_LISTS and not JOINTS:
            JOINTS.extend(map(str, value.flat))
        if value.ndim == 0 or value.size == 1:
            put_number(name, value)
        elif kind in 'ifUM' and value.size >= MIN_SAMPLES:
            value = np.squeeze(value)
            if value.ndim == 1:
                yield name, value, unit
            elif value.ndim == 2 and kind in 'if':
                yield from matrix_columns(name, value, unit)


def matrix_columns(name: str, value: Any, unit: str) -> Iterator[Leaf]:
    """Yield columns of the matrix `value` of a `unit`, called `name`; its rows if signals."""
    if value.shape[0] < MIN_SAMPLES <= value.shape[1]:
        NOTES.append(f'{name or "matrix"}: one row per signal ({value.shape[0]} rows of '
                     f'{value.shape[1]} samples): column numbers count its rows')
        value = value.T
    for k in range(min(value.shape[1], MOST_COLUMNS)):
        yield f'{name} {k + 1}'.strip(), value[:, k], unit


def attributes_of(tree: Any, prefix: str = '', depth: int = 0) -> None:
    """Note the numbers among the attributes of an HDF5 group and its parts."""
    for name, value in getattr(tree, 'attrs', {}).items():
        put_number(prefix + name, value)
    if depth < 3 and isinstance(tree, Mapping):
        for name in tree:
            if not link_of(tree, name):
                attributes_of(tree[name], f'{prefix}{name}.', depth + 1)


def read(path: str, kind: str, memory: int) -> list[Leaf]:
    """Return all columns of the file `path`."""
    os.environ['ARROW_DEFAULT_MEMORY_POOL'] = 'system'  # others reserve memory in advance
    module = import_module(MODULES[kind]) if kind in MODULES else None
    stream = opened(path, memory)
    limited(LIMITS[0], memory)
    if kind in ('parquet', 'feather'):
        return list(columns_of(table_leaves(module, stream, kind)))
    tree = tree_of(module, stream, kind, memory)
    attributes_of(tree)
    if kind == 'hdf5' and (episodes := episodes_of(tree)):
        return list(columns_of(joined(episodes)))
    if isinstance(tree, (list, dict)):
        entries = entries_in(tree) if kind == 'json' else None
        if entries is not None:
            return list(columns_of(entry_leaves(entries)))
        if not isinstance(tree, dict):
            raise Unreadable(f'a list of {len(tree)} values, expected entries or rows of numbers')
    return list(columns_of(leaves_of(tree)))


def main() -> int:
    """Read the file of the arguments; return the exit code."""
    path, kind, out, cpu_seconds, memory = sys.argv[1:]
    LIMITS[:] = int(cpu_seconds), int(memory)
    names = {'hdf5': 'an HDF5 file', 'mat': 'a MATLAB file', 'json': 'JSON',
             'numpy': 'a NumPy file (.npy or .npz) without objects',
             'parquet': 'a Parquet file', 'feather': 'a Feather file'}
    try:
        columns = read(path, kind, LIMITS[1])
        index = json.dumps({'columns': [(name, unit) for name, _, unit in columns],
                            'joints': JOINTS, 'header': HEADER, 'notes': NOTES})
        np.savez(out, index=np.frombuffer(index.encode(), np.uint8), **{
            f'c{k}': value for k, (_, value, _) in enumerate(columns)})
    except MemoryError:
        return TOO_LARGE
    except ModuleNotFoundError as error:
        why = (f'{error.name} is not installed, expected it for this format: pip install '
               f'{error.name}')
    except Unreadable as error:
        why = str(error)
    except RecursionError:
        why = 'groups inside each other without an end, expected fewer'
    except Exception as error:  # of a library, for a damaged file
        if re.search('(?i)cannot allocate|malloc', str(error)):
            return TOO_LARGE
        why = (f'{type(error).__name__} {" ".join(str(error).split())[:300]}, expected '
               f'{names[kind]}')
    else:
        return 0
    print(why, file=sys.stderr)
    return FAILED


if __name__ == '__main__':
    sys.exit(main())
