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

The equations are those of drive.simulate, bit for bit, for models with a dead zone and without the
effects that have an equation of their own: the most of all runs of a diagnosis.

p, e, plugin: model, effects and plug-in, packed; begin, first [W]: samples where runs and their
windows begin; n: steps in a sample of dt seconds; carry_at [W]: samples whose states are kept;
states, memory [W, 4]: where runs begin; u [N]: torque; extra: free-form signals.
"""
from collections.abc import Sized

from gearbox_monitor.arrays import Array, Integers
from gearbox_monitor.drive.effects import (
    BRANCH_H, CA, COG_A, CS, DRIFT_R, K3, MESH_A, reading, RIPPLE_A, SIGMA0, TH)
from gearbox_monitor.drive.model import (
    arm_acceleration, CAC, G, HALF_GAP, KIND, motor_acceleration, steady_arm_load, STIFFNESS)
from gearbox_monitor.drive.transmission import DEAD_ZONE, dead_zone
from gearbox_monitor.jit import COMPILED, jit, jit_inline

LANES = 16
FEWEST = 3  # windows from which on lanes are faster than one run after the other
OWN_EQUATIONS = [CS, SIGMA0, CA, DRIFT_R, COG_A, K3, TH, BRANCH_H, MESH_A, RIPPLE_A]
X1, X2, X3, X4, U, ON_MOTOR, ON_ARM, WITHIN = (LANES * i for i in range(8))
N_LANE_STATE = 8 * LANES


def suited(windows: Sized, p: Array, e: Array, plugin: object) -> bool:
    """Return whether `runs` gives what these windows and the packed model and effects ask for."""
    return (COMPILED and len(windows) >= FEWEST and plugin is None and p[KIND] == DEAD_ZONE
            and p[G] == 0.0 and p[CAC] == 0.0 and not e[OWN_EQUATIONS].any())


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
def runs(begin: Integers, first: Integers, length: int, carry_at: Integers, states: Array,
         memory: Array, dt: float, n: int, u: Array, extra: Array, p: Array, e: Array, s: Array,
         path: Array, y: Array, carry: Array) -> None:
    """
    Run windows as windows.Simulator.run does; fill y [W, length, 2] and carry [W, 8].

    s [N_LANE_STATE], path [LANES, longest lead + length, 4]: room to work in.
    """
    h, last = dt / n, len(begin) - 1
    for group in range(0, len(begin), LANES):
        longest = 0
        for i in range(LANES):
            w = min(group + i, last)
            longest = max(longest, first[w] - begin[w])
            for j in range(4):
                s[LANES * j + i] = states[w, j]
        for k in range(longest + length + 1):
            for i in range(LANES):
                w = min(group + i, last)
                at = begin[w] + k
                if at == carry_at[w]:
                    for j in range(4):
                        carry[w, j] = s[LANES * j + i]
                        carry[w, 4 + j] = memory[w, j]
                at = min(at, len(u) - 1)
                for j in range(3):
                    s[ON_MOTOR + LANES * j + i] = extra[at, j]
            if k == longest + length:
                break
            for i in range(LANES):
                for j in range(4):
                    path[i, k, j] = s[LANES * j + i]
            for part in range(n):
                for i in range(LANES):
                    s[U + i] = u[min(begin[min(group + i, last)] + k, len(u) - 1), part]
                _step(s, h, p)
        for w in range(group, min(group + LANES, last + 1)):
            rows, late = path[w - group], first[w] - begin[w]
            for k in range(length):
                y[w, k, 0] = reading(rows, late + k, 0, dt, e)
                y[w, k, 1] = reading(rows, late + k, 1, dt, e)
