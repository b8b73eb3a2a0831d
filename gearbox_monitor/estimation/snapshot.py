# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Snapshots: the state of a filter as text, from which it goes on bit for bit."""
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import json

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Integers, Values


FORMAT = '3'  # of version 0.2: none


class SnapshotError(InputError):
    """A snapshot cannot be read: damaged, or of another version."""


@contextmanager
def snapshot_errors(source: str) -> Iterator[None]:
    """Raise SnapshotError, naming `source`, for what a damaged snapshot raises in the block."""
    try:
        yield
    except InputError:
        raise
    except (KeyError, ValueError, TypeError, AttributeError, OverflowError, IndexError,
            RecursionError) as error:
        raise SnapshotError(f'{source}: not a snapshot of this version ({error})') from None


def expect_format(snapshot: Values, source: str) -> None:
    """Raise SnapshotError, naming `source`, for a snapshot of another version."""
    if snapshot.get('format') != FORMAT:
        raise SnapshotError(f'{source}: of another version, expected format {FORMAT}: state the '
                            'model (--model), and the parameters (--params)')


def numbers_text(a: Array) -> str:
    """Return the elements of `a` as text that reads back bit for bit."""
    return json.dumps([float(v).hex() for v in np.ravel(a)])


def read_numbers(snapshot: Values, arrays: Mapping[str, Array]) -> None:
    """Fill `arrays` {name: of any shape} with what numbers_text wrote; see snapshot_errors."""
    for name, array in arrays.items():
        values = [float.fromhex(v) for v in json.loads(snapshot[name])]
        array[:] = np.array(values).reshape(array.shape)


def integers_text(a: Integers) -> str:
    """Return the elements of `a` as text."""
    return json.dumps([int(v) for v in a])


def read_integers(snapshot: Values, arrays: Mapping[str, Integers]) -> None:
    """Fill `arrays` {name: [N]} with what integers_text wrote; see snapshot_errors."""
    for name, array in arrays.items():
        values = json.loads(snapshot[name])
        if len(values) != len(array) or any(type(value) is not int for value in values):
            raise ValueError(f'{name}: {str(values)[:60]}, expected {len(array)} whole numbers')
        array[:] = values
