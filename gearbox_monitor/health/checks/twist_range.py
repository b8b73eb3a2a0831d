# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Whether backlash and compliance of the model leave room for the twist that is measured."""
import numpy as np

from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.health.checks.row_check import middle, Result, RowCheck
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel


BEYOND = Condition('twist_range', 'prediction error', Level.ERROR, ('twist_range',),
                   ('twist_range_threshold',))


def check(rows: Array, drive: DriveModel) -> Result:
    """
    Return the Result of `rows` [N, N_SMOOTHED] against `drive`; None where they are too few.

    The zero of the encoders against each other does not matter: only the range of the twist does.
    """
    if len(rows) < LIMITS.twist_rows:
        return None
    shape = drive.folded().transmission
    torque = float(np.ptp(rows[:, S_TAU_K])
                   + 2.0 * LIMITS.twist_sure * middle(rows[:, S_TAU_K_NOISE_STD]))
    allowed = LIMITS.twist_room * (2.0 * (shape.half_gap + shape.hysteresis_width)
                                   + torque / shape.stiffness)
    twist = float(np.ptp(rows[:, S_TWIST]))
    return ([BEYOND.said()] if not twist <= allowed else [],
            {'twist_range': twist, 'twist_range_threshold': allowed})


CHECK = RowCheck('twist_range', LIMITS.twist_window, check, (BEYOND,), (
    ('twist_range', 'rad', 'range of the smoothed twist, 10 s'),
    ('twist_range_threshold', 'rad', 'ERROR above')), down=1)
