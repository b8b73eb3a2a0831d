# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A check of smoothed torque and twist, which abstains where the motion does not show a result."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gearbox_monitor.health.checks.outcome import Condition, Said
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel

MAX_ROWS = 500  # of a window that are looked at: neighbours are alike

# What conditions that are broken say and {key: value}; None: the check abstains.
Result: TypeAlias = tuple[Sequence[Said], dict[str, float]] | None


@dataclass(frozen=True)
class RowCheck:
    """
    One check of the newest smoothed rows, registered in monitor.ROW_CHECKS.

    name: what the keys of its counters begin with; window: s of rows that it looks at; check:
    takes `thinned` rows [N, N_SMOOTHED] in order of time (columns rts_smoother.S_*) and the drive
    of the filter; conditions: that it can break, of `prediction error`; keys: of its values, with
    unit and meaning, see diagnostic_keys; down: results in a row that lower its level, 1 where the
    windows overlap by far; free_torque: whether it needs a tau_K that the filter does not take
    from the twist.
    """

    name: str
    window: float
    check: Callable[[Array, DriveModel], Result]
    conditions: tuple[Condition, ...] = ()
    keys: tuple[tuple[str, str, str], ...] = ()
    down: int = 5
    free_torque: bool = False


def thinned(rows: Array) -> Array:
    """Return MAX_ROWS, or up to twice as many, of the `rows` [N, M] of a window."""
    return rows[::max(1, len(rows) // MAX_ROWS)]


def middle(values: Array) -> float:
    """Return the median of `values` [N], the upper one of two."""
    at = len(values) // 2
    return float(np.partition(values, at)[at])
