# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Values of a mapping that differ from recording to recording: from options or from its header.

A number of a mapping may be ``{from_header: NAME, scale: 1.0}``: in text a comment or preamble
line ``NAME = VALUE``, elsewhere the field, attribute or metadata NAME.
"""
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from copy import deepcopy
from itertools import islice
from pathlib import Path
import re
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_unpacked
from gearbox_monitor.recordings.importer.containers import (
    attribute, opened_tree, readable, table_metadata)

FROM_HEADER = 'from_header'
HEADER_LINES = 1000  # of a text file
References: TypeAlias = Mapping[str, tuple[str, float]]  # dotted key: name in the header, scale


def with_settings(data: Any, settings: Sequence[str]) -> Any:
    """Return a copy of `data` with the values of the ``KEY=VALUE`` in `settings`."""
    result = deepcopy(data)
    for setting in settings:
        key, equals, text = setting.partition('=')
        if not equals or not key:
            raise InputError(f'--set: {setting!r}, expected KEY=VALUE such as '
                             'signals.arm_position.zero=12')
        _put(result, key.split('.'), _plain(text), setting)
    return result


def _plain(text: str) -> int | float | bool | str:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return {'true': True, 'false': False}.get(text, text)


def _put(data: Any, parts: Sequence[str], value: Any, setting: str) -> None:
    for part in parts[:-1]:
        data = data.setdefault(part, {}) if isinstance(data, dict) else None
    if not isinstance(data, dict):
        raise InputError(f'--set: {setting!r}, expected a dotted key of the mapping')
    data[parts[-1]] = value


def header_references(data: Any, prefix: str = '') -> dict[str, tuple[str, float]]:
    """Return {dotted key behind `prefix`: (name in the header, scale)} of references in `data`."""
    references: dict[str, tuple[str, float]] = {}
    if isinstance(data, dict):
        for key, value in data.items():
            if isinstance(value, dict) and FROM_HEADER in value:
                name, scale = value[FROM_HEADER], value.get('scale', 1.0)
                if not isinstance(name, str) or not isinstance(scale, (int, float)) or \
                        set(value) - {FROM_HEADER, 'scale'}:
                    raise InputError(f'{prefix}{key}: {value!r}, expected {{{FROM_HEADER}: NAME, '
                                     'scale: NUMBER}')
                references[f'{prefix}{key}'] = name, scale
            else:
                references.update(header_references(value, f'{prefix}{key}.'))
    return references


def with_header(data: Any, references: References, values: Mapping[str, float], path: str) -> Any:
    """
    Return a copy of a mapping with numbers for its references.

    Args:
        data: plain values, as in the mapping file.
        references: of header_references.
        values: {name in the header: number}.
        path: of the recording, for messages.

    Returns:
        The copy.

    Raises:
        InputError: the header lacks one of them.
    """
    result = deepcopy(data)
    for key, (name, scale) in references.items():
        if name not in values:
            raise InputError(f'{path}: header: no {name!r} ({key}), expected '
                             f'a line {name} = NUMBER, a field or an attribute of this name')
        value = values[name] * scale
        _put(result, key.split('.'), int(value) if key.endswith('_ns') else value, key)
    return result


def header_values(path: str | Path, data: Any, names: Sequence[str]) -> dict[str, float]:
    """
    Return the numbers of a recording's header.

    Args:
        path: of the recording.
        data: plain values of its mapping: format and text block.
        names: in the header.

    Returns:
        {name: number} of those that stand there.

    Raises:
        InputError: the file cannot be read.
    """
    kind, text = data.get('format'), data.get('text')
    encoding = str(text.get('encoding', 'utf-8')) if isinstance(text, dict) else 'utf-8'
    with readable(path, encoding):
        if kind == 'text':
            return _of_lines(path, encoding, names)
        with nullcontext(table_metadata(path, kind)) if kind in ('parquet', 'feather') else \
                opened_tree(path, str(kind)) as tree:
            return {name: value for name in names
                    if (value := _number_of(attribute(tree, name))) is not None}


def _of_lines(path: str | Path, encoding: str, names: Sequence[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    with open_unpacked(path) as stream:
        for raw in islice(stream, HEADER_LINES):
            line = raw[:10_000].decode(encoding, 'replace')
            for name in names:
                match = re.match(rf'\W*{re.escape(name)}\W*?[=:,;\t ]\s*'
                                 r'([-+]?[\d.]+(?:[eE][-+]?\d+)?)', line)
                value = _number_of(match[1]) if match else None
                if value is not None:
                    values.setdefault(name, value)
    return values


def _number_of(value: Any) -> float | None:
    """Return `value`, a number, text or an array of one number, as a float; None: it is none."""
    try:
        number = float(np.squeeze(np.asarray(value)))
    except (TypeError, ValueError):
        return None
    return number if np.isfinite(number) else None
