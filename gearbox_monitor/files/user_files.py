# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The files of a user: model of the drive, parameters of a node, baselines; in YAML.

One loader reads YAML text: safe, and bounded before it builds anything.

Files are opened within limits and written whole; those of ``config/`` are found. A pipe or device
is refused, never waited for. A file may be gzipped: four kilobytes can stand for four megabytes.
"""
from collections.abc import Iterator, Mapping, Sequence
import contextlib
from dataclasses import dataclass, field
import errno
import gzip
import io
import json
import math
import os
from pathlib import Path
import re
import stat
import sys
from typing import Any, BinaryIO, cast, IO, TYPE_CHECKING, TypeAlias

import numpy as np
import yaml

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, Problems
from gearbox_monitor.parameters import check_values, EstimatorParameters, SETTINGS, Table
from gearbox_monitor.plant.drive import DriveModel, KEYS, model_from_dict
from gearbox_monitor.presentation import percent
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


MAX_NODES = 500_000  # values and keys that a text stands for
MAX_DEPTH = 64       # of a mapping or list in others
MAX_DIGITS = 60      # of a whole number

if TYPE_CHECKING:
    _Base: TypeAlias = yaml.SafeLoader
else:  # the one in C is ten times as fast, if PyYAML was built with it
    _Base = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)

_INT, _FLOAT = 'tag:yaml.org,2002:int', 'tag:yaml.org,2002:float'


class BoundedLoader(_Base):
    """
    Safe loader of numbers as ROS reads them; a key that stands twice is an error.

    lines: {id of a mapping: {key: line}}.
    """

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.lines: dict[int, dict[Any, int]] = {}

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return the mapping of `node` (`deep`: with what is inside); note lines of its keys."""
        keys = [key for key, _ in node.value]
        result: dict[Any, Any] = super().construct_mapping(node, deep)
        lines: dict[Any, int] = {}
        for key in keys:
            if key.tag == 'tag:yaml.org,2002:merge':
                continue
            name, line = self.construct_object(key), key.start_mark.line + 1
            if name in lines:
                raise yaml.constructor.ConstructorError(
                    None, None, f'key {name!r} stands in line {lines[name]}, too', key.start_mark)
            lines[name] = line
        self.lines[id(node)] = lines
        return result

    def construct_yaml_map(self, node: yaml.MappingNode) -> Iterator[dict[Any, Any]]:
        """Yield the mapping of `node` before it is filled, as aliases need it."""
        data: dict[Any, Any] = {}
        yield data
        data.update(self.construct_mapping(node))
        self.lines[id(data)] = self.lines.pop(id(node), {})

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Return the whole number of `node`, also of one that a tag calls so."""
        return super().construct_yaml_int(_short(node, MAX_DIGITS + 3))

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        """Return the number of `node`, also of one that a tag calls so."""
        return super().construct_yaml_float(_short(node, MAX_NODES))


def _short(node: yaml.ScalarNode, length: int) -> yaml.ScalarNode:
    """Return `node`; raises ConstructorError if it is sexagesimal or longer than `length`."""
    if ':' in node.value or len(node.value) > length:
        raise yaml.constructor.ConstructorError(
            None, None, f'{node.value[:20]!r} is not a number', node.start_mark)
    return node


BoundedLoader.add_constructor('tag:yaml.org,2002:map', BoundedLoader.construct_yaml_map)
BoundedLoader.add_constructor(_INT, BoundedLoader.construct_yaml_int)
BoundedLoader.add_constructor(_FLOAT, BoundedLoader.construct_yaml_float)
BoundedLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in (_INT, _FLOAT)]
    for first, resolvers in _Base.yaml_implicit_resolvers.items()}
BoundedLoader.add_implicit_resolver(_FLOAT, re.compile(
    r'[-+]?(\.[0-9][0-9_]*|[0-9][0-9_]*\.[0-9_]*)([eE][-+]?[0-9]+)?$|[-+]?[0-9]+[eE][-+]?[0-9]+$'
    r'|[-+]?\.(inf|Inf|INF)$|\.(nan|NaN|NAN)$'), list('-+.0123456789'))
BoundedLoader.add_implicit_resolver(_INT, re.compile(
    rf'[-+]?(0b[01_]{{1,{MAX_DIGITS}}}|0x[0-9a-fA-F_]{{1,{MAX_DIGITS}}}|0[0-7_]{{0,{MAX_DIGITS}}}'
    rf'|[1-9][0-9_]{{0,{MAX_DIGITS}}})$'), list('-+0123456789'))


def parse_yaml(text: str, aliases: bool = True) -> tuple[Any, dict[int, dict[Any, int]]]:
    """
    Return (content, {id of a mapping: {key: line}}) of the one document `text`.

    Raises yaml.YAMLError and ValueError; also for aliases unless `aliases` admits them.
    """
    _check_size(text, aliases)
    loader = BoundedLoader(text)
    try:
        return loader.get_single_data(), loader.lines
    except (AttributeError, LookupError, TypeError):  # of the constructors of PyYAML
        raise ValueError('a tag that its value does not fit') from None
    finally:
        loader.dispose()


def _check_size(text: str, aliases: bool) -> None:
    """Raise MarkedYAMLError if `text` stands for more than the limits allow."""
    sizes: dict[str | None, int] = {}  # of what an anchor names, once it is complete
    parents: list[tuple[str | None, int]] = []  # anchor of each, and the count at its begin
    count = 0
    for event in yaml.parse(text, BoundedLoader):
        problem = ''
        if isinstance(event, yaml.AliasEvent):
            problem = 'an alias' if not aliases else 'an alias that contains itself' if (
                event.anchor in dict(parents)) else ''
            count += sizes.get(event.anchor, 1)
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, begin = parents.pop()
            sizes[anchor] = count - begin
        elif isinstance(event, yaml.CollectionStartEvent):
            parents.append((event.anchor, count))
            count += 1
        elif isinstance(event, yaml.ScalarEvent):
            sizes[event.anchor] = 1
            count += 1
        if len(parents) > MAX_DEPTH:
            problem = 'nested too deeply'
        elif count > MAX_NODES:
            problem = f'stands for more than {MAX_NODES} values (aliases of aliases?)'
        if problem:
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)


MAX_BYTES = 64 << 20  # of a file: baselines of a thousand operating points are a tenth of it
# Parameters that every node has.
OF_ROS = ('qos_overrides', 'start_type_description_service', 'use_sim_time')


@dataclass(frozen=True)
class Yaml:
    """The `content` of a YAML file, its `text`, and where keys stand: {dotted key: line}."""

    path: str | Path
    content: Any
    text: str
    lines: dict[str, int] = field(default_factory=dict)

    @contextlib.contextmanager
    def located(self, block_name: str = '') -> Iterator[None]:
        """Put the line into each InputError of this file; look keys up in block `block_name`."""
        try:
            yield
        except InputError as error:
            raise type(error)(*(
                self._located(text, block_name) for text in error.args)) from None

    def _located(self, problem: str, block_name: str) -> str:
        """Return `problem` with the line of the key that it names."""
        head, _, tail = problem.partition(': ')
        key = tail.partition(': ')[0]
        if head != str(self.path) or not key:
            return problem
        while key:  # what is missing is looked for where it should stand
            for name, line in self.lines.items():
                if name.startswith(block_name) and (name == key or name.endswith('.' + key)):
                    return f'{head}: line {line}: {tail}'
            key = key.rpartition('.')[0]
        return problem


def load_yaml(path: str | Path) -> Yaml:
    """Return the Yaml of the file `path`; raises InputError with file and line."""
    try:
        text = read_text(path, MAX_BYTES)
        content, lines = parse_yaml(text)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable YAML file') from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        where = getattr(error, 'problem_mark', None)
        line = f' line {where.line + 1}:' if where else ''
        problem = getattr(error, 'problem', None) or (
            'not text' if isinstance(error, (UnicodeDecodeError, yaml.reader.ReaderError))
            else str(error))
        raise InputError(f'{path}:{line} {problem}, expected YAML') from None
    return Yaml(path, content, text, _lines(content, lines))


def _lines(content: Any, lines_by_id: dict[int, dict[Any, int]]) -> dict[str, int]:
    """Return {dotted key: line} of all mappings in `content`."""
    positions: dict[str, int] = {}
    pending = [('', content)]
    while pending:
        prefix, value = pending.pop()
        if isinstance(value, dict):
            own_lines = lines_by_id.get(id(value), {})
            for key, inner in value.items():
                name = f'{prefix}{key}'
                if key in own_lines:
                    positions.setdefault(name, own_lines[key])
                pending.append((name + '.', inner))
        elif isinstance(value, (list, tuple, set)):
            for item in value:  # named by their id, as effects are
                name = prefix
                if isinstance(item, dict) and 'id' in item:
                    name = f'{prefix}{item["id"]}'
                    own_lines = lines_by_id.get(id(item), {})
                    positions.setdefault(name, min(own_lines.values(), default=1))
                    name += '.'
                pending.append((name, item))
    return positions


def expect_new_file(*paths: str | Path | None) -> None:
    """Raise InputError if one of `paths` exists or its folder does not; None and '-' never do."""
    expect_new(*paths)
    for path in paths:
        expect_folder_of(path)


def expect_new(*paths: str | Path | None) -> None:
    """Raise InputError if one of `paths` exists; None and '-' (standard output) never do."""
    for path in paths:
        if path and path != '-' and Path(path).exists():
            raise InputError(f'{path}: exists, expected a new file')


def expect_folder_of(path: str | Path | None) -> None:
    """Raise InputError where `path` has no folder, or that of a bag; None and '-' need none."""
    if not path or path == '-':
        return
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise InputError(f'{path}: no such folder, expected a new name in an existing one')
    expect_outside_of_bag(path)


def expect_outside_of_bag(path: str | Path) -> None:
    """Raise InputError where the new file or folder `path` would stand in the folder of a bag."""
    folder = Path(path).absolute().parent
    if (folder / 'metadata.yaml').is_file() and any(
            any(folder.glob(f'*{suffix}')) for suffix in ('.mcap', '.mcap.*', '.db3', '.db3.*')):
        raise InputError(f'{path}: in the folder of a bag, which stays as it was recorded, '
                         'expected a name outside of it')


def load_model(path: str | Path) -> DriveModel:
    """Return the DriveModel of the model file `path`. Raises InputError."""
    data = load_yaml(path)
    if data.content is None:
        raise InputError(f'{path}: empty, expected a model file: motor_inertia: ...')
    if (name := _first_parameter_block(data.content)) is not None:
        raise InputError(f'{path}: {name}: a block of a parameter file, expected a model file: '
                         'motor_inertia: ...')
    with data.located():
        return model_from_dict(data.content, str(path))


def _first_parameter_block(content: Any) -> str | None:
    """Return the name of the first block of parameters in `content`, None without one."""
    return next((str(name) for name, block in content.items()
                 if isinstance(block, dict) and 'ros__parameters' in block), None) \
        if isinstance(content, dict) else None


def save_model(path: str | Path, model: DriveModel, comment: Sequence[str]) -> None:
    """
    Write a model file.

    Args:
        path: of the new file.
        model: see load_model.
        comment: lines that precede it.

    Raises:
        InputError: if the file exists or cannot be written.

    """
    write_new(path, model_text(model, comment))


def model_text(model: DriveModel, comment: Sequence[str]) -> str:
    """Return the model file of `model`, which lines of `comment` precede."""
    lines = [f'# {line}'.rstrip() for line in comment]
    return '\n'.join(lines) + '\n' + yaml.safe_dump(
        model.to_dict(), sort_keys=False, default_flow_style=None)


def load_parameters(path: str | Path, node: str, table: Table, of: str = '') -> dict[str, Any]:
    """
    Return the parameters that a ROS parameter file gives to a node.

    Takes the blocks ``/**``, ``/**/node`` and ``node`` (with or without a namespace), in this
    order. A file that sets none of its parameters is not meant for it: an error.

    Args:
        path: of the file.
        node: name of the node.
        table: rows of its parameters.
        of: a topic or node, whose namespace counts if the file has several; of several
            gearboxes: NODE/GEARBOX.

    Returns:
        {name: value} of the parameters in the file.

    Raises:
        InputError: for all problems in the file, with their lines.

    """
    file = load_yaml(path)
    data, problems = file.content, Problems()
    if not isinstance(data, dict):
        raise InputError(f'{path}: {str(data)[:40]!r}, expected "{node}: ros__parameters: ..."')
    model_keys = {*KEYS} & set(map(str, data))
    if model_keys:
        raise InputError(f'{path}: {min(model_keys)}: a key of a model file, expected '
                         f'"{node}: ros__parameters: ..."; use --model for a model file')
    blocks = [block for block in data if isinstance(block, str)]
    addressed = False
    names, values, several = {row.name for row in table}, {}, [
        block.rsplit('/', 1)[0] or '/' for block in blocks
        if re.fullmatch(rf'/([^*]*/)?{node}', block)]
    for block in sorted(blocks, key=lambda name: ('/**' not in name, '/**/' in name)):
        if block.rsplit('/', 1)[-1] not in ('**', node):
            continue
        if len(several) > 1 and '/**' not in block:
            whose = re.sub(rf'/{node}/\w+$', f'/{node}', of)
            namespace = '/' + whose.rpartition('/')[0].strip('/')
            if namespace not in several:
                raise InputError(
                    f'{path}: blocks for {node} in {", ".join(several)}, expected to know whose: '
                    f'choose it with --topic {several[0]}/{node}')
            if (block.rsplit('/', 1)[0] or '/') != namespace:
                continue
        inner = None
        with problems, file.located():
            inner = data[block].get('ros__parameters') if isinstance(data[block], dict) else None
            if not isinstance(inner, dict):
                raise InputError(f'{path}: {block}: expected a block ros__parameters')
        if not isinstance(inner, dict):
            continue
        own: dict[Any, Any] = {}
        with problems, file.located(block + '.'):
            own = _of_gearbox(inner, of, f'{path}: {block}')
        # /** addresses every node: what this one does not have belongs to another.
        ours = {k: v for k, v in own.items() if k in names
                or block.rsplit('/', 1)[-1] == node and str(k).partition('.')[0] not in OF_ROS}
        with problems, file.located(block + '.'):
            check_values(table, ours, str(path))
        values.update(ours)
        addressed |= bool(ours) or block.rsplit('/', 1)[-1] == node
    problems.raise_all()
    if not addressed:
        raise InputError(f'{path}: sets nothing of node {node} (blocks: '
                         f'{", ".join(map(str, data)) or "none"}), expected '
                         f'"{node}: ros__parameters: ..."')
    return values


def gearboxes_of(path: str | Path, node: str) -> list[str]:
    """Return the gearboxes that the ROS parameter file `path` lists for a `node`, [] for none."""
    data, names = load_yaml(path).content, dict[str, None]()
    for block, content in data.items() if isinstance(data, dict) else ():
        own = content.get('ros__parameters') if isinstance(content, dict) else None
        if str(block).rsplit('/', 1)[-1] in ('**', node) and isinstance(own, dict):
            listed = own.get('gearboxes')  # load_parameters refuses what is no list
            names.update(dict.fromkeys(map(str, listed)) if isinstance(listed, list) else {})
    return [name for name in names if name]


def _of_gearbox(block: Mapping[Any, Any], of: str, source: str) -> dict[Any, Any]:
    """
    Return the parameters of one gearbox of a node.

    Args:
        block: parameters of the node; with `gearboxes`, those of a gearbox stand in a block.
        of: ends with the name of the gearbox.
        source: what a problem names.

    Returns:
        {name: value} of the common parameters and its own; all of `block` without `gearboxes`.

    Raises:
        InputError: `of` names none of the gearboxes, or its block is none.

    """
    gearboxes = block.get('gearboxes', [''])
    if gearboxes == ['']:
        return {key: value for key, value in block.items() if key != 'gearboxes'}
    if not isinstance(gearboxes, list):
        raise InputError(f'{source}: gearboxes: {gearboxes!r}, expected a list of names')
    name = of.rpartition('/')[2]
    if name not in gearboxes:
        raise InputError(f'{source}: gearboxes: {", ".join(map(str, gearboxes))}, expected to '
                         f'know which: choose it with --topic joint_states/{gearboxes[0]}')
    own = block.get(name) or {}
    if not isinstance(own, dict):
        raise InputError(f'{source}: {name}: {str(own)[:40]!r}, expected a block of parameters')
    return {**{key: value for key, value in block.items()
               if key != 'gearboxes' and key not in gearboxes}, **own}


def write_parameters(path: str | Path, parameters: EstimatorParameters,
                     model: tuple[str, dict[str, Any]], data: Mapping[str, Any]) -> None:
    """
    Write the parameter file that node and replay load.

    Args:
        path: of the new file.
        parameters: before.
        model: its file, '' for none, and values that replace those in it.
        data: result of the tuning.

    Raises:
        InputError: the file cannot be written.

    """
    rows = {row.name: row for row in SETTINGS}
    values = parameters.changes()
    values.update(model[1], **data['parameters'], filter=data['filter'])
    if model[0]:
        values['model'] = str(Path(model[0]).resolve())
    lines = [
        f'# Written by gearbox_monitor {__version__} {data.get("command", "fit noise")} from '
        f'{data["bag"]}.']
    if data['after']:
        lines.append(f'# Mean NIS {data["after"]["nis"]:.3f}, '
                     f'log-likelihood {data["after"]["loglik"]:.1f}.')
    lines += ['estimator:', '  ros__parameters:']
    for name in rows:
        if name in values:
            comment = [rows[name].unit] if rows[name].unit not in ('', '-') else []
            if name in data['parameters']:
                error = data['relative_error'].get(name)
                comment.append('not determined by the recording: as before'
                               if name in data.get('undetermined', ()) else
                               'tuned' + error_words(error))
            entry = f'    {name}: {_yaml(values[name])}'
            lines.append(f'{entry:40s} # {", ".join(comment)}' if comment else entry)
    write_new(path, '\n'.join(lines) + '\n')


def _yaml(value: object) -> str:
    """Return `value` as YAML 1.1 reads it back: 1e-05 would be a string."""
    if isinstance(value, float):
        digits = repr(value)
        mantissa, e, exponent = digits.partition('e')
        return f'{mantissa if "." in mantissa else mantissa + ".0"}e{exponent}' if e else digits
    return json.dumps(value)


def error_words(error: float | None) -> str:
    """Return the relative standard `error` of a tuned value in words, '' for none."""
    if not error:
        return ''
    return f' ± {percent(error, error).digits()[1]} %' if error < 1.0 else ', undetermined'
