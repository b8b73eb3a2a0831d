# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Checks of smoothed torque and twist, which abstain where the motion does not show a result."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD, S_X3, S_X4)
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said

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
    from the twist; earlier: how many windows before, of which it takes the values, too.
    """

    name: str
    window: float
    check: Callable[..., Result]
    conditions: tuple[Condition, ...] = ()
    keys: tuple[tuple[str, str, str], ...] = ()
    down: int = 5
    free_torque: bool = False
    earlier: int = 0


def thinned(rows: Array) -> Array:
    """Return MAX_ROWS, or up to twice as many, of the `rows` [N, M] of a window."""
    return rows[::max(1, len(rows) // MAX_ROWS)]


def middle(values: Array) -> float:
    """Return the median of `values` [N], the upper one of two."""
    at = len(values) // 2
    return float(np.partition(values, at)[at])


AGAINST = Condition(
    'against_twist', 'prediction error', Level.WARN,
    ('torque_twist_correlation', 'torque_twist_power'),
    ('torque_twist_correlation_threshold', 'torque_twist_power_threshold'))


def passivity(rows: Array, drive: DriveModel) -> Result:
    """
    Return whether torque and twist act like a transmission: it pushes back, and makes no power.

    A spring that is wound up at the beginning of a window gives back what it holds: that is no
    power made. An unknown load on the arm explains away what the prediction errors would tell: an
    encoder or a torque of wrong sign, a torque that is not what acts.

    Args:
        rows: [N, N_SMOOTHED].
        drive: of the filter.

    Returns:
        The Result; None if they do not show it.
    """
    if len(rows) < LIMITS.window_points:
        return None
    torque, twist, rate = rows[:, S_TAU_K], rows[:, S_TWIST], rows[:, S_X3] - rows[:, S_X4]
    moved = torque.std(), twist.std(), float(np.sqrt(np.mean(rate ** 2)))
    stds = S_TAU_K_NOISE_STD, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD
    if not all(size > LIMITS.deviations * middle(rows[:, std]) for size, std in zip(moved, stds)):
        return None
    correlation = float(np.mean((torque - torque.mean()) * (twist - twist.mean()))
                        / (moved[0] * moved[1]))
    steps = np.diff(twist)
    work = 0.5 * (torque[1:] + torque[:-1]) @ steps
    released = max(torque[0] ** 2 - torque[-1] ** 2, 0.0) / (
        2.0 * drive.folded().transmission.stiffness)
    power = float((work + released) / np.sqrt(np.mean(torque ** 2) * len(steps) * steps @ steps))
    values = {'torque_twist_correlation': correlation,
              'torque_twist_correlation_threshold': LIMITS.correlation,
              'torque_twist_power': power, 'torque_twist_power_threshold': LIMITS.power}
    against = correlation < LIMITS.correlation or power < LIMITS.power
    return [AGAINST.said()] if against else [], values


PASSIVITY = RowCheck('torque_twist', LIMITS.error_window, passivity, (AGAINST,), (
    ('torque_twist_correlation', '-', 'of smoothed torque and twist, 2 s'),
    ('torque_twist_correlation_threshold', '-', 'WARN below'),
    ('torque_twist_power', '-', 'mean of torque times twist rate, without what a spring gives '
     'back, over their rms'),
    ('torque_twist_power_threshold', '-', 'WARN below')))


BEYOND = Condition('twist_range', 'prediction error', Level.ERROR, ('twist_range',),
                   ('twist_range_threshold',))


def twist_range(rows: Array, drive: DriveModel) -> Result:
    """
    Return whether backlash and compliance of the model leave room for the twist that is measured.

    rows: [N, N_SMOOTHED]; drive: of the filter. None where they are too few. The zero of the
    encoders against each other does not matter: only the range of the twist does.
    """
    if len(rows) < LIMITS.window_points:
        return None
    shape = drive.folded().transmission
    torque = float(np.ptp(rows[:, S_TAU_K])
                   + 2.0 * LIMITS.deviations * middle(rows[:, S_TAU_K_NOISE_STD]))
    allowed = LIMITS.twist_room * (2.0 * (shape.half_gap + shape.hysteresis_width)
                                   + torque / shape.stiffness)
    twist = float(np.ptp(rows[:, S_TWIST]))
    return ([BEYOND.said()] if not twist <= allowed else [],
            {'twist_range': twist, 'twist_range_threshold': allowed})


TWIST_RANGE = RowCheck('twist_range', LIMITS.curve_window, twist_range, (BEYOND,), (
    ('twist_range', 'rad', 'range of the smoothed twist, 10 s'),
    ('twist_range_threshold', 'rad', 'ERROR above')), down=1)
