# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A Watch as plain data and arrays, and back: floats read back exactly."""
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, ReadingScore, RobotReading
from gearbox_monitor.diagnosis.robot.evidence import Prior
from gearbox_monitor.diagnosis.robot.knowledge import Knowledge, States, Visits
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.signals.convention import Convention
from gearbox_monitor.watch.block import Block
from gearbox_monitor.watch.levels import Levels
from gearbox_monitor.watch.record import Change, Held, JointWatch, HeldLoad, StateHealth, Watch

CLASSES = {c.__name__: c for c in (
    Block, Change, Convention, Held, JointWatch, Knowledge, Levels, NamedReading, HeldLoad, Prior,
    ReadingScore, RobotReading, StateHealth, States, Visits, Watch)}
KIND = '='  # key of the class of an object


def to_data(value: Any, arrays: dict[str, Array]) -> Any:
    """Return `value` (a Watch, or any of its parts) as plain data; arrays go into `arrays`."""
    if isinstance(value, np.ndarray):
        name = f'a{len(arrays)}'
        arrays[name] = value
        return {KIND: 'array', 'name': name}
    if isinstance(value, Level):
        return {KIND: 'Level', 'value': int(value)}
    if type(value).__name__ in CLASSES:
        names = [f.name for f in fields(value)] if is_dataclass(value) else value._fields
        return {KIND: type(value).__name__, **{
            name: to_data(getattr(value, name), arrays) for name in names}}
    if isinstance(value, tuple):
        return [to_data(v, arrays) for v in value]
    if isinstance(value, Mapping):
        return {KIND: 'table', 'rows': [[to_data(k, arrays), to_data(v, arrays)]
                                        for k, v in value.items()]}
    return value.item() if isinstance(value, np.generic) else value


def from_data(data: Any, arrays: Mapping[str, Array]) -> Any:
    """Return the value of `data` and `arrays`. Raises KeyError, TypeError or ValueError."""
    if isinstance(data, list):
        return tuple(from_data(v, arrays) for v in data)
    if not isinstance(data, dict):
        return data
    kind = data[KIND]
    if kind == 'array':
        return np.array(arrays[data['name']])
    if kind == 'table':
        return MappingProxyType({from_data(k, arrays): from_data(v, arrays)
                                 for k, v in data['rows']})
    if kind == 'Level':
        return Level(data['value'])
    return CLASSES[kind](**{k: from_data(v, arrays) for k, v in data.items() if k != KIND})
