# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Numbers that no sensor gives: one rule for all commands, that of the filter's loop.

What is infinite or beyond HUGE was not measured. A channel of which nothing exceeds `unphysical`,
without being 0 throughout, is memory that nobody wrote: it counts as 0.
"""
import numpy as np

from gearbox_monitor.estimation.sample_loop import HUGE
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.signals.recording_limits import LIMITS


def is_uninitialised(values: Array) -> bool:
    """Return whether `values` [N] (NaN: not measured) are memory that nobody wrote."""
    amounts = np.abs(values[np.isfinite(values)])
    return bool(len(amounts)) and 0.0 < float(amounts.max()) < LIMITS.unphysical


def physical(values: Array) -> tuple[Array, int]:
    """
    Return values as they count, and how many of them are unphysical.

    Args:
        values: of one channel [N]; NaN: not measured.

    Returns:
        The values, NaN in place of those that are infinite or beyond HUGE, 0 throughout where the
        channel is uninitialised; the number of values replaced.
    """
    wild = np.abs(values) > HUGE
    count = int(wild.sum())
    if count:
        values = np.where(wild, np.nan, values)
    if is_uninitialised(values):
        count += int((np.abs(values) > 0.0).sum())
        values = np.where(np.isnan(values), np.nan, 0.0)
    return values, count


def physical_columns(values: Array) -> tuple[Array, int]:
    """Return `values` [N, C] with each column as `physical` returns it, and the count of all."""
    columns = [physical(column) for column in values.T]
    count = sum(number for _, number in columns)
    return (np.column_stack([column for column, _ in columns]) if count else values), count
