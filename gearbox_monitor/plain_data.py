# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Frozen values as plain data for JSON, and back: all numbers read back exactly."""
import base64
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
import enum
from types import MappingProxyType
from typing import Any
import zlib

import numpy as np

KIND = '='  # key of the class of an object
ARRAY, TABLE = 'array', 'table'


def to_data(value: Any, arrays: dict[str, Any] | None = None, leave: tuple[str, ...] = ()) -> Any:
    """
    Return `value` as plain data.

    Args:
        value: a dataclass, a named tuple, a mapping, an array or a number, and so on inside.
        arrays: takes the arrays, by name; None: they are part of the data.
        leave: names of the fields of `value` itself that are left out.
    """
    if isinstance(value, np.ndarray):
        if arrays is None:
            packed = base64.b64encode(zlib.compress(np.ascontiguousarray(value).tobytes()))
            return {KIND: ARRAY, 'type': value.dtype.str, 'shape': list(value.shape),
                    'bytes': packed.decode()}
        arrays[f'a{len(arrays)}'] = value
        return {KIND: ARRAY, 'name': f'a{len(arrays) - 1}'}
    if isinstance(value, enum.Enum):
        return {KIND: type(value).__name__, 'value': value.value}
    if is_dataclass(value) or hasattr(value, '_fields'):
        names = [f.name for f in fields(value)] if is_dataclass(value) else value._fields
        return {KIND: type(value).__name__, **{
            name: to_data(getattr(value, name), arrays) for name in names if name not in leave}}
    if isinstance(value, tuple):
        return [to_data(v, arrays) for v in value]
    if isinstance(value, Mapping):
        return {KIND: TABLE, 'rows': [[to_data(k, arrays), to_data(v, arrays)]
                                      for k, v in value.items()]}
    return value.item() if isinstance(value, np.generic) else value


def from_data(data: Any, classes: Mapping[str, Callable[..., Any]],
              arrays: Mapping[str, Any] | None = None) -> Any:
    """
    Return the value that to_data gave.

    Args:
        data: of to_data.
        classes: of the objects in it, by name.
        arrays: as to_data took them.

    Raises:
        KeyError, TypeError, ValueError: `data` are none.
    """
    if isinstance(data, list):
        return tuple(from_data(v, classes, arrays) for v in data)
    if not isinstance(data, dict):
        return data
    kind = data[KIND]
    if kind == ARRAY:
        if arrays is not None:
            return np.array(arrays[data['name']])
        try:
            content = zlib.decompress(base64.b64decode(data['bytes']))
        except zlib.error as error:
            raise ValueError(str(error)) from None
        return np.frombuffer(content, data['type']).reshape(data['shape']).copy()
    if kind == TABLE:
        return MappingProxyType({from_data(k, classes, arrays): from_data(v, classes, arrays)
                                 for k, v in data['rows']})
    return classes[kind](**{name: from_data(v, classes, arrays)
                            for name, v in data.items() if name != KIND})


def classes_of(*classes: type) -> dict[str, type]:
    """Return `classes` by name, as from_data takes them."""
    return {c.__name__: c for c in classes}
