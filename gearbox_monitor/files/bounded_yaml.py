# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one loader of YAML text: safe, and bounded before it builds anything.

Aliases and merge keys let half a kilobyte stand for billions of values; the events of the text are
counted first, each alias with all that it stands for. Numbers are those of YAML 1.2, which ROS
parameter files use: 1e-3 is one, 12:30:00 (sexagesimal) is none.
"""
from collections.abc import Iterator
import re
from typing import Any, TYPE_CHECKING, TypeAlias

import yaml

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
    sizes: dict[str, int] = {}  # of what an anchor names, once it is complete
    parents: list[tuple[str | None, int]] = []  # anchor of each, and the count at its begin
    count = 0
    for event in yaml.parse(text, BoundedLoader):
        problem = ''
        if isinstance(event, yaml.AliasEvent):
            if not aliases:
                problem = 'an alias'
            elif any(event.anchor == anchor for anchor, _ in parents):
                problem = 'an alias that contains itself'
            count += sizes.get(event.anchor, 1)
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, begin = parents.pop()
            if anchor:
                sizes[anchor] = count - begin
        elif isinstance(event, (yaml.ScalarEvent, yaml.CollectionStartEvent)):
            if isinstance(event, yaml.CollectionStartEvent):
                parents.append((event.anchor, count))
            elif event.anchor:
                sizes[event.anchor] = 1
            count += 1
        if len(parents) > MAX_DEPTH:
            problem = 'nested too deeply'
        elif count > MAX_NODES:
            problem = f'stands for more than {MAX_NODES} values (aliases of aliases?)'
        if problem:
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
