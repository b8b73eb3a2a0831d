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

"""
Free runs of many windows side by side: lanes of a vector unit instead of one after the other.

The equations are those of drive.simulate, bit for bit, for models with a dead zone and without a
plug-in: the most of all runs of a diagnosis. Effects with an equation of their own take a step in
which each of their terms is a loop over the lanes.

p, e, plugin: model, effects and plug-in, packed; begin, first [W]: samples where runs and their
windows begin; n: steps in a sample of dt seconds; carry_at [W]: samples whose states are kept;
states, memory [W, 4]: where runs begin; u [N]: torque; extra: free-form signals; s: the lanes.
"""
from collections.abc import Sized

from gearbox_monitor.kernels.jit import COMPILED, jit, jit_inline
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import (
    ALPHA, arm_acceleration, arm_friction, CAC, CC, CV, G, gravity, HALF_GAP, KIND,
    motor_acceleration, steady_arm_load, STIFFNESS)
from gearbox_monitor.plant.effects.equations import (
    BRANCH_DS, BRANCH_H, bristle, CA, COG_A, cogging, CS, DH, DRIFT_R, friction_side, hardening,
    K3, loop_memory, lugre, MESH_A, mesh_error, reading, ripple, RIPPLE_A, SIGMA0, stribeck, TH,
    viscous_drift)
from gearbox_monitor.plant.transmission import DEAD_ZONE, dead_zone

LANES = 16
FEWEST = 3  # windows from which on lanes are faster than one run after the other
OWN_EQUATIONS = (CS, SIGMA0, CA, DRIFT_R, COG_A, K3, TH, BRANCH_H, MESH_A, RIPPLE_A)
PARTS = 31
# State: motion, memories of lugre, bouc_wen and branch, time. Then torques from outside.
(X1, X2, X3, X4, Z, LOOP, BRANCH, T, U, ON_MOTOR, ON_ARM, WITHIN,
 # A stage of a step with effects: where it is, what comes out, sums over stages, parts of torques.
 Y1, Y2, Y3, Y4, YZ, YLOOP, YBRANCH, RATE3, RATE4, SUM1, SUM2, SUM3, SUM4, TWIST, TAU_K, LOAD,
 MOTOR, FRICTION, SIDE) = (LANES * i for i in range(PARTS))
N_LANE_STATE = PARTS * LANES


def suited(windows: Sized, p: Array, plugin: object) -> bool:
    """Return whether `runs` gives what these windows and the packed model ask for."""
    return bool(COMPILED and len(windows) >= FEWEST and plugin is None and p[KIND] == DEAD_ZONE)


@jit_inline
def _derivative(x1: float, x2: float, x3: float, x4: float, u: float, on_motor: float,
                on_arm: float, within: float, p: Array) -> tuple[float, float, float, float]:
    tau_k = p[STIFFNESS] * dead_zone(x1 - x2, p[HALF_GAP]) + within
    return (x3, x4, motor_acceleration(x1, x3, x4, u + on_motor, tau_k, p),
            arm_acceleration(x3, x4, tau_k, steady_arm_load(x4, p) - on_arm, p))


@jit
def _step(s: Array, h: float, p: Array) -> None:
    """Advance the LANES states in s [N_LANE_STATE] by one RK4 step of `h` s."""
    half = 0.5 * h
    for i in range(LANES):
        x1, x2, x3, x4 = s[X1 + i], s[X2 + i], s[X3 + i], s[X4 + i]
        u, on_motor, on_arm, within = s[U + i], s[ON_MOTOR + i], s[ON_ARM + i], s[WITHIN + i]
        a1, a2, a3, a4 = _derivative(x1, x2, x3, x4, u, on_motor, on_arm, within, p)
        b1, b2, b3, b4 = _derivative(x1 + half * a1, x2 + half * a2, x3 + half * a3,
                                     x4 + half * a4, u, on_motor, on_arm, within, p)
        c1, c2, c3, c4 = _derivative(x1 + half * b1, x2 + half * b2, x3 + half * b3,
                                     x4 + half * b4, u, on_motor, on_arm, within, p)
        d1, d2, d3, d4 = _derivative(x1 + h * c1, x2 + h * c2, x3 + h * c3, x4 + h * c4, u,
                                     on_motor, on_arm, within, p)
        s[X1 + i] = x1 + h * ((a1 + 2.0 * b1 + 2.0 * c1 + d1) / 6.0)
        s[X2 + i] = x2 + h * ((a2 + 2.0 * b2 + 2.0 * c2 + d2) / 6.0)
        s[X3 + i] = x3 + h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3)
        s[X4 + i] = x4 + h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4)


@jit
def _rates(s: Array, late: float, p: Array, e: Array) -> None:
    """Fill in the accelerations of a stage, `late` s after the step's begin."""
    lanes = len(s) // PARTS  # LANES: known to the compiler, it would unroll loops lane by lane
    for i in range(lanes):
        s[TWIST + i] = s[Y1 + i] - s[Y2 + i]
        s[FRICTION + i] = 0.0
        s[MOTOR + i] = s[U + i]
        s[LOAD + i] = steady_arm_load(s[Y4 + i], p)
    if e[MESH_A] != 0.0:
        for i in range(lanes):
            s[TWIST + i] += mesh_error(s[Y1 + i], e)
    if e[BRANCH_H] != 0.0:
        for i in range(lanes):
            s[TWIST + i] -= e[BRANCH_H] * s[YBRANCH + i]
    for i in range(lanes):
        s[TAU_K + i] = p[STIFFNESS] * dead_zone(s[TWIST + i], p[HALF_GAP])
    if e[K3] != 0.0:
        for i in range(lanes):
            s[TAU_K + i] += hardening(s[TWIST + i], p[HALF_GAP], e)
    if e[TH] != 0.0:
        for i in range(lanes):
            s[TAU_K + i] += e[TH] * s[YLOOP + i]
    if e[RIPPLE_A] != 0.0:
        for i in range(lanes):
            s[MOTOR + i] *= ripple(s[Y1 + i], e)
    if e[COG_A] != 0.0:
        for i in range(lanes):
            s[MOTOR + i] += cogging(s[Y1 + i], e)
    if e[CS] != 0.0 or e[SIGMA0] != 0.0 or e[CA] != 0.0:
        for i in range(lanes):
            s[SIDE + i] = friction_side(s[Y3 + i], p[ALPHA])
        if e[CS] != 0.0:
            for i in range(lanes):
                s[FRICTION + i] += stribeck(s[Y3 + i], s[SIDE + i], e)
        if e[SIGMA0] != 0.0:
            for i in range(lanes):
                s[FRICTION + i] += lugre(s[Y3 + i], s[YZ + i], s[SIDE + i], p[CC], e)
        for i in range(lanes):
            s[FRICTION + i] += e[CA] * abs(s[SIDE + i])
    if e[DRIFT_R] != 0.0:
        for i in range(lanes):
            s[FRICTION + i] += viscous_drift(s[Y3 + i], s[T + i] + late, p[CV], e)
    if p[CAC] != 0.0:
        for i in range(lanes):
            s[LOAD + i] += arm_friction(s[Y4 + i], p)
    if p[G] != 0.0:
        for i in range(lanes):
            s[LOAD + i] += gravity(s[Y2 + i], p)
    for i in range(lanes):
        u, tau_k = s[U + i], s[TAU_K + i] + s[WITHIN + i]
        motor = s[MOTOR + i] - u - s[FRICTION + i]
        s[RATE3 + i] = motor_acceleration(s[Y1 + i], s[Y3 + i], s[Y4 + i],
                                          u + motor + s[ON_MOTOR + i], tau_k, p)
        s[RATE4 + i] = arm_acceleration(s[Y3 + i], s[Y4 + i], tau_k, s[LOAD + i] - s[ON_ARM + i],
                                        p)


@jit
def _remember(s: Array, x3: int, x4: int, h: float, p: Array, e: Array) -> None:
    """Fill in the memories of a stage: `h` s after the step's begin at the speeds s[x3], s[x4]."""
    lanes = len(s) // PARTS
    if e[SIGMA0] != 0.0:
        for i in range(lanes):
            s[YZ + i] = bristle(s[Z + i], s[x3 + i], h, p[CC], e)
    if e[TH] != 0.0:
        for i in range(lanes):
            s[YLOOP + i] = loop_memory(s[LOOP + i], s[x3 + i] - s[x4 + i], e[DH], h)
    if e[BRANCH_H] != 0.0:
        for i in range(lanes):
            s[YBRANCH + i] = loop_memory(s[BRANCH + i], s[x3 + i] - s[x4 + i], e[BRANCH_DS], h)


@jit
def _step_with_effects(s: Array, h: float, p: Array, e: Array) -> None:
    """Advance the LANES states in s [N_LANE_STATE] by one RK4 step of `h` s, as _step does."""
    lanes = len(s) // PARTS
    half = 0.5 * h
    for i in range(lanes):
        s[Y1 + i], s[Y2 + i], s[Y3 + i], s[Y4 + i] = s[X1 + i], s[X2 + i], s[X3 + i], s[X4 + i]
        s[YZ + i], s[YLOOP + i], s[YBRANCH + i] = s[Z + i], s[LOOP + i], s[BRANCH + i]
    for stage in range(4):
        late = 0.0 if stage == 0 else (half if stage < 3 else h)
        _rates(s, late, p, e)
        if stage == 0:
            for i in range(lanes):
                s[SUM1 + i], s[SUM2 + i] = s[Y3 + i], s[Y4 + i]
                s[SUM3 + i], s[SUM4 + i] = s[RATE3 + i], s[RATE4 + i]
        else:
            factor = 1.0 if stage == 3 else 2.0
            for i in range(lanes):
                s[SUM1 + i] += factor * s[Y3 + i]
                s[SUM2 + i] += factor * s[Y4 + i]
                s[SUM3 + i] += factor * s[RATE3 + i]
                s[SUM4 + i] += factor * s[RATE4 + i]
        if stage < 3:
            ahead = half if stage < 2 else h
            _remember(s, Y3, Y4, ahead, p, e)
            for i in range(lanes):
                s[Y1 + i] = s[X1 + i] + ahead * s[Y3 + i]
                s[Y2 + i] = s[X2 + i] + ahead * s[Y4 + i]
                s[Y3 + i] = s[X3 + i] + ahead * s[RATE3 + i]
                s[Y4 + i] = s[X4 + i] + ahead * s[RATE4 + i]
    for i in range(lanes):
        s[SUM1 + i], s[SUM2 + i] = s[SUM1 + i] / 6.0, s[SUM2 + i] / 6.0
        s[X1 + i] += h * s[SUM1 + i]
        s[X2 + i] += h * s[SUM2 + i]
        s[X3 + i] += h / 6.0 * s[SUM3 + i]
        s[X4 + i] += h / 6.0 * s[SUM4 + i]
        s[T + i] += h
    _remember(s, SUM1, SUM2, h, p, e)
    for i in range(lanes):
        s[Z + i], s[LOOP + i], s[BRANCH + i] = s[YZ + i], s[YLOOP + i], s[YBRANCH + i]


@jit
def runs(begin: Integers, first: Integers, length: int, carry_at: Integers, states: Array,
         memory: Array, dt: float, n: int, u: Array, extra: Array, p: Array, e: Array, s: Array,
         path: Array, y: Array, carry: Array) -> None:
    """
    Run windows as windows.Simulator.run does; fill y [W, length, 2] and carry [W, 8].

    s [N_LANE_STATE], path [LANES, longest lead + length, 4]: room to work in.
    """
    h, last = dt / n, len(begin) - 1
    plain = p[CAC] == 0.0 and p[G] == 0.0
    for i in OWN_EQUATIONS:
        plain = plain and e[i] == 0.0
    for group in range(0, len(begin), LANES):
        longest = 0
        for i in range(LANES):
            w = min(group + i, last)
            longest = max(longest, first[w] - begin[w])
            for j in range(4):
                s[X1 + LANES * j + i] = states[w, j]
            for j in range(3):
                s[Z + LANES * j + i] = memory[w, 1 + j]
        for k in range(longest + length + 1):
            for i in range(LANES):
                w = min(group + i, last)
                at = begin[w] + k
                if at == carry_at[w]:
                    for j in range(4):
                        carry[w, j] = s[X1 + LANES * j + i]
                    carry[w, 4] = memory[w, 0]
                    for j in range(3):
                        carry[w, 5 + j] = s[Z + LANES * j + i]
                s[T + i] = at * dt
                at = min(at, len(u) - 1)
                for j in range(3):
                    s[ON_MOTOR + LANES * j + i] = extra[at, j]
            if k == longest + length:
                break
            for i in range(LANES):
                for j in range(4):
                    path[i, k, j] = s[X1 + LANES * j + i]
            for part in range(n):
                for i in range(LANES):
                    s[U + i] = u[min(begin[min(group + i, last)] + k, len(u) - 1), part]
                if plain:
                    _step(s, h, p)
                else:
                    _step_with_effects(s, h, p, e)
        for w in range(group, min(group + LANES, last + 1)):
            rows, late = path[w - group], first[w] - begin[w]
            for k in range(length):
                y[w, k, 0] = reading(rows, late + k, 0, dt, e)
                y[w, k, 1] = reading(rows, late + k, 1, dt, e)
