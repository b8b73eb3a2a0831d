# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the errors of the model add to the stated deviations: consider parameters (Schmidt 1966).

The model file states how far its values may be off: each tolerance is a bound either way, any
error within it as likely as another, so its standard deviation is the bound over the root of 3.
The errors c are constant and not estimated. Beside the filter run companions, one for each c_i:
the same filter, with the same gain, on a drive whose value is off by one standard deviation. By
how much its state differs is the sensitivity s_i:

    predict   s_i <- f(z + s_i; c_i) - f(z; 0)
    update    s_i <- (I - K H) s_i
    state     P + sum of s_i s_i'

With a linear f this is the covariance of the filter whose state has c added and whose gain has
zero rows for it, cross-covariances included: P_xc is the column s_i times the deviation of c_i.
A companion takes the whole deviation and no derivative, as friction around standstill has none
that holds for more than a few mrad/s. The gain stays the filter's own: estimates do not depend on
the tolerances, and its innovations still tell when the model is wrong.

The smoother carries s_i as it carries the state (see rts_smoother).

A delay of one encoder behind the other is no matter of the drive: the twist is off by that delay
times the speed (encoder_delay_tolerance).
"""
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.estimation.filter_kind import places, Reading, sensitivities
from gearbox_monitor.estimation.process_model import (
    advance_beside, BESIDE, curve_count, EIGENVALUE, ENCODER_DELAY_STD, FACTOR_DELAY, FACTOR_GAIN,
    FACTORS, N_FACTORS, N_LANE, TAU_K, torque_slopes, UNIFORM, USUAL, X1, X2, X3, X4)
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.types import Array, Layout, Triple, Vector
from gearbox_monitor.plant.drive import (
    CAC, CAV, CC, CL, CV, D, DriveModel, INVERSE_M1, INVERSE_M2, substeps)
from gearbox_monitor.plant.effects.arm_side import ARM_COULOMB, ARM_VISCOUS
from gearbox_monitor.plant.effects.motor_side import LOAD_FRICTION

FACTOR_NAMES = ('motor_inertia', 'arm_inertia', 'damping', 'viscous_friction', 'coulomb_friction',
                ARM_VISCOUS.id, ARM_COULOMB.id, LOAD_FRICTION.id)  # of FACTORS
ERROR_NAMES = (*FACTOR_NAMES, 'torque_gain', 'torque_delay')


class Companions(NamedTuple):
    """
    The c filters beside a filter of n states; their arrays are changed in place.

    number: c. s [c * n + 1]: sensitivities one by one, and the last motor torque, NaN after a
    start. lanes: as of process_model.advance_beside, the c drives, then the filter's own.
    """

    number: int
    s: Vector
    lanes: Vector

    @property
    def factors(self) -> Array:
        """View of the factors [N_FACTORS, BESIDE] of the drives in lanes."""
        return self.lanes[-N_FACTORS * BESIDE:].reshape(N_FACTORS, BESIDE)


def _changes(drive: DriveModel) -> list[tuple[str, int, float]]:
    """
    Return (name, row of the factors, value) of what may be off in the `drive`.

    Values are changed to where the drive is slower: its substeps then do for all.
    """
    p = drive.pack()
    less_friction = 1.0 - UNIFORM * drive.friction_tolerance
    less_damping = 1.0 - UNIFORM * drive.damping_tolerance
    heavier = 1.0 / (1.0 + UNIFORM * drive.inertia_tolerance)
    changed = {INVERSE_M1: heavier, INVERSE_M2: heavier, CC: less_friction, CAC: less_friction,
               CL: less_friction, CV: less_damping, CAV: less_damping, D: less_damping}
    changes = [(name, row, changed[place])
               for row, (name, place) in enumerate(zip(FACTOR_NAMES, FACTORS))
               if p[place] != 0.0 and changed[place] != 1.0]
    if drive.torque_gain_tolerance > 0.0:
        changes.append(('torque_gain', FACTOR_GAIN, 1.0 + UNIFORM * drive.torque_gain_tolerance))
    if drive.delay_tolerance > 0.0:
        changes.append(('torque_delay', FACTOR_DELAY, UNIFORM * drive.delay_tolerance))
    return changes


def companions_of(drive: DriveModel, n: int) -> Companions:
    """Return the companions of a filter of `n` states for the `drive`; none without tolerances."""
    changes = _changes(drive)
    s = np.zeros(n * len(changes) + 1)
    s[-1] = math.nan
    companions = Companions(len(changes), s, np.ones((n + N_LANE + N_FACTORS) * BESIDE))
    companions.factors[FACTOR_DELAY] = 0.0
    for lane, (_, row, value) in enumerate(changes):
        companions.factors[row, lane] = value
    return companions


def torque_errors_at_tolerance(drive: DriveModel, n: int, records: Array) -> dict[str, float]:
    """
    Return by how much tau_K errs (rms, N m) for each value that is off by its whole tolerance.

    Args:
        drive: that states the tolerances.
        n: number of states.
        records: of the steps [M, record_size(n, c)].

    """
    names = [name for name, _, _ in _changes(drive)]
    _, _, at_s, _ = sensitivities(n, records.shape[1])
    errors = records[:, at_s + TAU_K + n * np.arange(len(names))]
    return dict(zip(names, (np.sqrt(np.mean(errors ** 2, axis=0)) / UNIFORM).tolist()))


@inline
def restart(companions: Companions) -> None:
    """Let the `companions` begin where their filter begins: a start depends on no parameter."""
    companions.s[:] = 0.0
    companions.s[-1] = math.nan


@folded(*USUAL)
@apart
def accompany(layout: Layout, companions: Companions, z: Array, reading: Reading,
              p: Array, record: Array) -> bool:
    """
    Take the step that a filter has taken.

    Args:
        layout: of the n states.
        companions: changed in place.
        z: state before the step [>= n].
        reading: of the step.
        p: packed parameters in use.
        record: of the step; its sensitivities are written.

    Returns:
        False if a companion has diverged.

    """
    n, (count, s, lanes) = layout.n, companions
    last, s[-1] = s[-1], reading.u
    if count == 0:
        return True
    rate = (reading.u - last) / reading.dt if math.isfinite(last) else 0.0
    for j in range(n):
        lanes[j * BESIDE:(j + 1) * BESIDE] = z[j]
        for i in range(count):
            lanes[j * BESIDE + i] += s[i * n + j]
    advance_beside(layout, lanes, count + 1, True, (reading.u, reading.load, rate), reading.dt,
                   substeps(reading.dt, p[EIGENVALUE]), p)
    _, _, _, _, _, _, _, at_K, _ = places(n)
    _, at_predicted, at_updated, _ = sensitivities(n, record.shape[0])
    good = True
    for i in range(count):
        at, rest = i * n, 0.0
        e1, e2 = lanes[X1 * BESIDE + i] - lanes[X1 * BESIDE + count], (
            lanes[X2 * BESIDE + i] - lanes[X2 * BESIDE + count])
        for j in range(n):
            value = lanes[j * BESIDE + i] - lanes[j * BESIDE + count]
            record[at_predicted + at + j] = value
            value -= record[at_K + 2 * j] * e1 + record[at_K + 2 * j + 1] * e2
            record[at_updated + at + j] = value
            s[at + j] = value
            rest += value - value
        good = good and rest == 0.0  # all are finite
    return good


@inline
def variance_of(n: int, record: Array, place: tuple[int, int], i: int) -> float:
    """
    Return what the model's errors add to the variance of a state.

    Args:
        n: number of states.
        record: of the step.
        place: number of its sensitivities (filtered or smoothed), and where they begin.
        i: number of the state.

    """
    (count, at), total = place, 0.0
    for c in range(count):
        total += record[at + c * n + i] * record[at + c * n + i]
    return total


@inline
def variances_of(layout: Layout, z: Array, record: Array, place: tuple[int, int],
                 p: Array) -> Triple:
    """
    Return what the model's errors add to the variances of twist, twist rate and tau_K.

    Args:
        layout: of the n states.
        z: state [n].
        record: of the step.
        place: as of variance_of.
        p: process_model.pack.

    """
    n, curve, (count, at) = layout.n, layout.curve, place
    late = p[ENCODER_DELAY_STD] * z[X4]
    of_twist, of_rate, of_torque = late * late, 0.0, 0.0
    slopes = torque_slopes(layout, z, p)
    for c in range(count):
        of_c = at + c * n
        twist, rate = record[of_c + X1] - record[of_c + X2], record[of_c + X3] - record[of_c + X4]
        torque = record[of_c + TAU_K]
        if curve >= 0:
            torque += slopes[0] * twist
            for i in range(curve_count(curve)):
                torque += slopes[1 + i] * record[of_c + n - curve_count(curve) + i]
        of_twist += twist * twist
        of_rate += rate * rate
        of_torque += torque * torque
    return of_twist, of_rate, of_torque
