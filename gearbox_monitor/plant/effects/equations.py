# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Equations of the effects in the kernels, e: registry.pack(effects)."""
import math

from gearbox_monitor.kernels.elementary import arctan, exponential, sine
from gearbox_monitor.kernels.jit import jit, jit_inline
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.transmission import dead_zone, transmission_torque

TWO_OVER_PI = 2.0 / math.pi
(CS, VS, SIGMA0, SIGMA1, LUGRE_CS, LUGRE_VS, CA, DRIFT_R, DRIFT_T, COG_A, COG_N, COG_PHI, K3, TH,
 DH, BRANCH_H, BRANCH_DS, MESH_A, MESH_N, MESH_PHI, GAIN, LAG, DELAY, UMAX, RIPPLE_A, RIPPLE_N,
 RIPPLE_PHI, ECC1_A, ECC1_PHI, Q1, DELAY1, ECC2_A, ECC2_PHI, Q2, DELAY2, OFFSET2) = range(36)


@jit_inline
def relaxed(memory: float, target: float, rate: float, h: float) -> float:
    """Return a memory after `h` s of memory' = rate (target - memory), rate in 1/s."""
    return target + (memory - target) * exponential(-rate * h)


@jit_inline
def bristle(z: float, x3: float, h: float, cc: float, e: Array) -> float:
    """Return z, the deflection (rad) of LuGre's bristles, after `h` s at speed x3."""
    g = lugre_level(x3, cc, e)
    if x3 == 0.0 or g <= 0.0:
        return z
    return relaxed(z, math.copysign(g / e[SIGMA0], x3), e[SIGMA0] * abs(x3) / g, h)


@jit_inline
def lugre_level(x3: float, cc: float, e: Array) -> float:
    """Return g (N m), LuGre's friction in steady sliding at speed x3."""
    v = x3 / e[LUGRE_VS]
    return cc + e[LUGRE_CS] * exponential(-v * v)


@jit_inline
def loop_memory(z: float, rate: float, width: float, h: float) -> float:
    """Return z after `h` s of z' = (rate - |rate| z) / width: both hystereses."""
    return relaxed(z, math.copysign(1.0, rate), abs(rate) / width, h)


@jit_inline
def friction_side(x3: float, alpha: float) -> float:
    """Return the sign of x3 as Coulomb friction has it: smooth around standstill."""
    return TWO_OVER_PI * arctan(alpha * x3)


@jit_inline
def stribeck(x3: float, side: float, e: Array) -> float:
    """Return the torque (N m) of stribeck, `side` of friction_side."""
    v = x3 / e[VS]
    return e[CS] * exponential(-v * v) * side


@jit_inline
def lugre(x3: float, z: float, side: float, cc: float, e: Array) -> float:
    """Return what lugre with bristles at `z` adds to Coulomb friction `cc` (N m)."""
    g = lugre_level(x3, cc, e)
    slip = abs(x3) * z / g if g > 0.0 else 0.0
    return e[SIGMA0] * z + e[SIGMA1] * (x3 - e[SIGMA0] * slip) - cc * side


@jit_inline
def viscous_drift(x3: float, t: float, cv: float, e: Array) -> float:
    """Return what viscous_drift adds to the friction (N m) at time `t`."""
    return cv * e[DRIFT_R] * (1.0 - exponential(-t / e[DRIFT_T])) * x3


@jit_inline
def friction_effects(x3: float, z: float, t: float, cv: float, cc: float, alpha: float,
                     e: Array) -> float:
    """Return what stribeck, lugre, asymmetry and drift add to tau_f (N m)."""
    torque = 0.0
    if e[CS] != 0.0 or e[SIGMA0] != 0.0 or e[CA] != 0.0:
        side = friction_side(x3, alpha)
        if e[CS] != 0.0:
            torque += stribeck(x3, side, e)
        if e[SIGMA0] != 0.0:
            torque += lugre(x3, z, side, cc, e)
        torque += e[CA] * abs(side)
    if e[DRIFT_R] != 0.0:
        torque += viscous_drift(x3, t, cv, e)
    return torque


@jit_inline
def mesh_error(x1: float, e: Array) -> float:
    """Return the twist (rad) that mesh_error adds."""
    return e[MESH_A] * sine(e[MESH_N] * x1 + e[MESH_PHI])


@jit_inline
def hardening(twist: float, half_gap: float, e: Array) -> float:
    """Return the torque (N m) that hardening adds at `twist` (rad)."""
    out = dead_zone(twist, half_gap)
    return e[K3] * out * out * out


@jit_inline
def elastic_torque(x1: float, x2: float, w: float, z: float, s: float, kind: int, stiffness: float,
                   half_gap: float, width: float, k_s: float, e: Array) -> tuple[float, float]:
    """
    Return (tau_k (N m), twist that acts (rad)) with mesh error, branch, hardening, Bouc-Wen.

    w: memory of the transmission; z, s: those of hysteresis_bouc_wen and hysteresis_branch.
    """
    twist = x1 - x2
    if e[MESH_A] != 0.0:
        twist += mesh_error(x1, e)
    if e[BRANCH_H] != 0.0:
        twist -= e[BRANCH_H] * s
    tau_k, _ = transmission_torque(twist, w, kind, stiffness, half_gap, width, k_s)
    if e[K3] != 0.0:
        tau_k += hardening(twist, half_gap, e)
    return tau_k + e[TH] * z, twist


@jit_inline
def ripple(x1: float, e: Array) -> float:
    """Return the factor of torque_ripple on the torque."""
    return 1.0 + e[RIPPLE_A] * sine(e[RIPPLE_N] * x1 + e[RIPPLE_PHI])


@jit_inline
def cogging(x1: float, e: Array) -> float:
    """Return the torque (N m) that cogging adds."""
    return e[COG_A] * sine(e[COG_N] * x1 + e[COG_PHI])


@jit_inline
def motor_torque(x1: float, u: float, e: Array) -> float:
    """Return u_act (N m) with ripple and, added, cogging; what acts on u alone is in actuator."""
    if e[RIPPLE_A] != 0.0:
        u *= ripple(x1, e)
    if e[COG_A] != 0.0:
        u += cogging(x1, e)
    return u


@jit
def actuator(u: Array, before: int, act: float, dt: float, n: int, e: Array, out: Array) -> float:
    """
    Fill out [N, n] with the mean torque (N m) in each of the `n` parts of each sample.

    In this order: dead time, saturation, gain, lag. u [before + N]: commanded, held over `dt` s,
    with `before` samples of the past in front. act: lagged torque at the start; returns it at the
    end.
    """
    h = dt / n
    fade = math.exp(-h / e[LAG]) if e[LAG] > 0.0 else 0.0
    share = e[LAG] / h * (1.0 - fade)
    for k in range(out.shape[0]):
        for i in range(n):
            now = u[before + k]
            if e[DELAY] > 0.0:
                begin = (i * h - e[DELAY]) / dt
                first = math.floor(begin)
                last = math.floor(begin + 1.0 / n)
                now = u[max(0, before + k + int(first))]
                if last > first:
                    over = (begin + 1.0 / n - last) * n
                    now += over * (u[max(0, before + k + int(last))] - now)
            now = min(max(now, -e[UMAX]), e[UMAX]) * (1.0 + e[GAIN])
            if e[LAG] > 0.0:
                out[k, i] = now + (act - now) * share
                act = now + (act - now) * fade
            else:
                out[k, i] = act = now
    return act


@jit
def reading(x: Array, k: int, i: int, dt: float, e: Array) -> float:
    """
    Return what encoder `i` (0 motor, 1 arm) reads at row `k` of x [N, 4], without noise.

    Delayed between samples by a cubic through positions and speeds; before row 0 the drive stood.
    """
    late = (e[DELAY1] if i == 0 else e[DELAY2]) / dt
    position = x[k, i]
    if late > 0.0:
        # Parts of the delay, not of the row: then the numbers do not depend on where x begins.
        f = math.ceil(late) - late
        j = k - int(math.ceil(late))
        if j < 0:
            position = x[0, i]
        else:
            a, b = x[j, i], x[j + 1, i]
            va, vb = x[j, 2 + i] * dt, x[j + 1, 2 + i] * dt
            position = (a + f * (va + f * (3.0 * (b - a) - 2.0 * va - vb
                                           + f * (2.0 * (a - b) + va + vb))))
    amplitude = e[ECC1_A] if i == 0 else e[ECC2_A]
    if amplitude != 0.0:
        position += amplitude * math.sin(position + (e[ECC1_PHI] if i == 0 else e[ECC2_PHI]))
    return position + (e[OFFSET2] if i == 1 else 0.0)
