# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What every reader of a foreign recording returns, and how its messages name things."""
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from gearbox_monitor.kernels.types import AnyArray
from gearbox_monitor.recordings.importer.mapping import key_of, Place

__all__ = ['MIN_SAMPLES', 'Places', 'RawColumns', 'key_of', 'label_of', 'names_of']
MIN_SAMPLES = 100  # of a recording; a matrix with fewer rows and more columns has rows of samples
Places: TypeAlias = Mapping[str, Place]  # by name of the signal, 'time' and 'SIGNAL.time'


@dataclass(frozen=True)
class RawColumns:
    """
    Columns of a recording as it holds them.

    values: {name: [N]} floats (NaN: an admitted missing value), whole numbers, or of a time also
    texts and datetime64; N may differ between signals with a time of their own. place(row, name):
    the place of a value, for messages. notices: sentences for the user. units: {name: standard
    name of the unit that the recording itself states}.
    """

    values: dict[str, AnyArray]
    place: Callable[[int, str], str]
    notices: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


def label_of(name: str) -> str:
    """Return the `name` of a signal as messages write it."""
    return name.replace('_', ' ').replace('.', ' ').replace(':', ' ')


def names_of(value: object) -> str:
    """Return the names in `value`, a mapping, for messages."""
    return ', '.join(sorted(map(str, value))) if isinstance(value, Mapping) and value else \
        'no fields'
