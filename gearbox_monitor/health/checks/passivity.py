# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether torque and twist act like a transmission: it pushes back, and it makes no power.

A spring that is wound up at the beginning of a window gives back what it holds: that is no power
made.

An unknown load on the arm explains away what the prediction errors would tell: an encoder or a
torque of wrong sign, a torque that is not what acts. Torque over twist does not lie then.
"""
import numpy as np

from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD, S_X3, S_X4)
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.health.checks.row_check import middle, Result, RowCheck
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel


AGAINST = Condition(
    'against_twist', 'prediction error', Level.WARN,
    ('torque_twist_correlation', 'torque_twist_power'),
    ('torque_twist_correlation_threshold', 'torque_twist_power_threshold'))


def check(rows: Array, drive: DriveModel) -> Result:
    """Return the Result of `rows` [N, N_SMOOTHED] of a `drive`; None if they do not show it."""
    if len(rows) < LIMITS.passivity_rows:
        return None
    torque, twist, rate = rows[:, S_TAU_K], rows[:, S_TWIST], rows[:, S_X3] - rows[:, S_X4]
    moved = torque.std(), twist.std(), float(np.sqrt(np.mean(rate ** 2)))
    stds = S_TAU_K_NOISE_STD, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD
    if not all(size > LIMITS.moved * middle(rows[:, std]) for size, std in zip(moved, stds)):
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


CHECK = RowCheck('torque_twist', LIMITS.passivity_window, check, (AGAINST,), (
    ('torque_twist_correlation', '-', 'of smoothed torque and twist, 2 s'),
    ('torque_twist_correlation_threshold', '-', 'WARN below'),
    ('torque_twist_power', '-', 'mean of torque times twist rate, without what a spring gives '
     'back, over their rms'),
    ('torque_twist_power_threshold', '-', 'WARN below')))
