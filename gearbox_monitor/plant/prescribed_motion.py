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
The drive when the motion of its motor is known: the arm runs free, the motor tells its torque.

A light motor behind much friction follows no open-loop run: small torques add up to large motions
of it. With its measured motion put in, equations (1) leave two unknowns: the motion of the arm,
which is simulated, and the torque that the motor needs for this motion,

    u = m1 x3' + D (x3 - x4) + tau_K + tau_f + K_r x1 - u0.

Its difference to the torque that acts is what the model lacks. While the motor stands, friction
takes any value and the torque tells nothing.
"""
from functools import cache
import math
from typing import Any

from gearbox_monitor.kernels.elementary import arctan
from gearbox_monitor.kernels.jit import jit, jit_inline
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import (
    ARM_ALPHA, CAC, CAV, D, DriveModel, HALF_GAP, INVERSE_M1, INVERSE_M2, K_S, KIND,
    motor_acceleration, STIFFNESS, TWO_OVER_PI, WIDTH)
from gearbox_monitor.plant.effects import Three, Torques
from gearbox_monitor.plant.effects.equations import (
    BRANCH_H, DELAY1, ECC1_A, ECC1_PHI, elastic_torque, GAIN, reading, RIPPLE_A, RIPPLE_N,
    RIPPLE_PHI, TH)
from gearbox_monitor.plant.simulate import _memories, _torques, rebuilt
from gearbox_monitor.plant.transmission import RIGID, transmission_torque

X1, X3, A1, MOVES, SMOOTH_U = range(5)  # columns of the motor's motion; SMOOTH_U acts on it
STEP_EIGENVALUE = 0.5         # step of time times the eigenfrequency of the arm on the spring
MAX_STEPS = 8                 # per sample; beyond, the spring is stiff and damped by THETA
THETA = 0.55                  # weight of a step's end: a little above the trapezoidal rule
DIFFERENCE = 1e-4             # rad/s, for the slope of the elastic torque
ITERATIONS, CLOSE = 4, 1e-9   # of Newton's method for the arm's speed; rad/s
FRICTION_ITERATIONS = 30
LEAST_GAIN = 0.05


def steps(model: DriveModel, dt: float) -> int:
    """Return the number of steps per sample of `dt` s that the arm of `model` asks for."""
    if model.transmission.kind == 'rigid':
        return 1
    t = model.folded().transmission
    fastest = math.sqrt((t.stiffness + t.hysteresis_stiffness) / model.folded().arm_inertia)
    return min(MAX_STEPS, max(1, math.ceil(dt * fastest / STEP_EIGENVALUE)))


@jit_inline
def motor_motion(motor: Array, at: float, dt: float, e: Array) -> Three:
    """
    Return position (rad), speed and acceleration of the motor at the row `at` of motor [N, 5].

    motor holds what its encoder says, `dt` s a row, parts of a row count; effects of the encoder,
    packed in e, are taken out.
    """
    at += e[DELAY1] / dt
    k = min(int(at), len(motor) - 2)
    f = min(at - k, 1.0)
    a, b = motor[k, X1], motor[k + 1, X1]
    va, vb = motor[k, X3] * dt, motor[k + 1, X3] * dt
    c2, c3 = 3.0 * (b - a) - 2.0 * va - vb, 2.0 * (a - b) + va + vb
    x = a + f * (va + f * (c2 + f * c3))
    v = (va + f * (2.0 * c2 + 3.0 * f * c3)) / dt
    acceleration = motor[k, A1] + f * (motor[k + 1, A1] - motor[k, A1])
    if e[ECC1_A] != 0.0:
        at = x + e[ECC1_PHI] - e[ECC1_A] * math.sin(x + e[ECC1_PHI])
        s, c = e[ECC1_A] * math.sin(at), e[ECC1_A] * math.cos(at)
        x, v, acceleration = x - s, v * (1.0 - c), acceleration * (1.0 - c) + s * v * v
    return x, v, acceleration


@jit_inline
def _elastic(x1: float, x2: float, w: float, z: float, s: float, p: Array, e: Array) -> float:
    tau_k, _ = elastic_torque(x1, x2, w, z, s, int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH],
                              p[K_S], e)
    return tau_k


@jit_inline
def _with_friction(slope: float, push: float, friction: float, alpha: float,
                   near: float) -> float:
    """Return v of slope v + friction s(v) = push: Newton's method, from below; near: a guess."""
    if friction == 0.0:
        return push / slope
    size, near = abs(push), math.copysign(1.0, push) * near
    v = max(0.0, (size - friction) / slope)
    if near > v and slope * near + friction * TWO_OVER_PI * arctan(alpha * near) < size:
        v = near
    for _ in range(FRICTION_ITERATIONS):
        av = alpha * v
        off = size - slope * v - friction * TWO_OVER_PI * arctan(av)
        step = off / (slope + friction * TWO_OVER_PI * alpha / (1.0 + av * av))
        v += step
        if abs(step) < CLOSE:
            break
    return math.copysign(v, push)


@jit
def advance_arm(state: Array, t: float, h: float, ahead_x1: float, ahead_x3: float, outside: Three,
                p: Array, e: Array, theta: Array) -> None:
    """
    Advance `state` [N_STATE] in place by `h` s from time `t`, the motor to the motion given.

    ahead_x1, ahead_x3: motor at the end, rad, rad/s. outside: `extra` as of simulate.advance.
    Implicit in the arm's speed: light arms, stiff springs and dry friction on the arm take no
    smaller steps.
    """
    x1, x2, x3, x4, w = state[0], state[1], state[2], state[3], state[4]
    z, loop, branch = state[5], state[6], state[7]
    tau_k, tau_arm, _ = _torques(t, x1, x2, x3, x4, 0.0, w, z, loop, branch, p, e, theta)
    begun = _elastic(x1, x2, w, loop, branch, p, e)
    load = tau_arm - outside[1]
    if p[CAC] != 0.0:
        load -= p[CAC] * TWO_OVER_PI * arctan(p[ARM_ALPHA] * x4)
    force = tau_k + outside[2] - THETA * begun - load + p[D] * (1.0 - THETA) * (x3 - x4)
    force += p[D] * THETA * ahead_x3 + p[CAV] * THETA * x4
    remembers = e[TH] != 0.0 or e[BRANCH_H] != 0.0
    inertia, v = 1.0 / p[INVERSE_M2], x4
    end, there = loop, branch
    for _ in range(ITERATIONS):
        lack = slope = 0.0
        for shift in (DIFFERENCE, 0.0):
            moved = v + shift
            if remembers:
                _, end, there = _memories(0.5 * (x3 + ahead_x3), 0.5 * (x4 + moved), z, loop,
                                          branch, h, p, e)
            tau = _elastic(ahead_x1, x2 + 0.5 * h * (x4 + moved), w, end, there, p, e)
            slope = lack
            lack = inertia * (moved - x4) - h * (
                force + THETA * (tau - (p[D] + p[CAV]) * moved))
        slope = max((slope - lack) / DIFFERENCE, inertia)
        found = _with_friction(slope, slope * v - lack, h * p[CAC], p[ARM_ALPHA], v)
        near = abs(found - v) < CLOSE
        v = found
        if near:
            break
    mean1, mean2 = 0.5 * (x3 + ahead_x3), 0.5 * (x4 + v)
    x2 += h * mean2
    _, w = transmission_torque(ahead_x1 - x2, w, int(p[KIND]), p[STIFFNESS], p[HALF_GAP],
                               p[WIDTH], p[K_S])
    z, loop, branch = _memories(mean1, mean2, z, loop, branch, h, p, e)
    state[0], state[1], state[2], state[3], state[4] = ahead_x1, x2, ahead_x3, v, w
    state[5], state[6], state[7] = z, loop, branch


@jit
def lacking(state: Array, t: float, acceleration: float, u: float, outside: Three, p: Array,
            e: Array, theta: Array) -> float:
    """
    Return the torque (N m) that acts on the motor beyond what its motion needs.

    state, t, outside, p, e, theta: see advance_arm. acceleration (rad/s^2) of the motor; u: torque
    of the actuator. In a rigid drive, of both.
    """
    x1, x2, x3, x4 = state[0], state[1], state[2], state[3]
    tau_k, tau_arm, motor = _torques(t, x1, x2, x3, x4, u, state[4], state[5], state[6],
                                     state[7], p, e, theta)
    if int(p[KIND]) == RIGID:
        tau_k = acceleration / p[INVERSE_M2] + tau_arm - outside[1]
    else:
        tau_k += outside[2]
    found = motor_acceleration(x1, x3, x4, u + motor + outside[0], tau_k, p)
    return (found - acceleration) / p[INVERSE_M1]


@jit_inline
def _gain(x1: float, e: Array) -> float:
    """Return d u_act / d u: what is lacking counts as torque that was logged."""
    gain = 1.0 + e[GAIN]
    if e[RIPPLE_A] != 0.0:
        gain *= 1.0 + e[RIPPLE_A] * math.sin(e[RIPPLE_N] * x1 + e[RIPPLE_PHI])
    return max(gain, LEAST_GAIN)


@jit
def driven_runs(begin: Integers, first: Integers, length: int, carry_at: Integers, states: Array,
                memory: Array, dt: float, n: int, u: Array, logged: Array, extra: Array,
                motor: Array, p: Array, e: Array, theta: Array, rows: Array, y: Array,
                carry: Array) -> None:
    """
    Fill y [W, L, 2], N m and rad: the torque that the motor needs, the reading of the arm.

    begin, first, length, carry_at: the Windows of gap.windows, which start at states [W, 4] with
    memory [W, 4]; carry [W, 8]: where the next window begins. dt, n, u [N, n], extra [N, 3], p, e,
    theta: as of simulate.advance. logged [N]: torque of the recording. motor [N, 5]: its motion,
    columns as above; where it stands, the torque that is needed counts as the logged one. rows
    [R, 8]: room to work in.
    """
    h = dt / n
    for w in range(len(begin)):
        state = rows[0]
        state[1], state[3] = states[w, 1], states[w, 3]
        for i in range(4):
            state[4 + i] = memory[w, i]
        path = rows[1:]
        late = first[w] - begin[w]
        for k in range(begin[w], first[w] + length):
            x1, x3, acceleration = motor_motion(motor, float(k), dt, e)
            state[0], state[2] = x1, x3
            if int(p[KIND]) == RIGID:
                state[1], state[3] = x1, x3
            for i in range(8):
                path[k - begin[w], i] = state[i]
            if k == carry_at[w]:
                for i in range(8):
                    carry[w, i] = state[i]
            outside = (extra[k, 0], extra[k, 1], extra[k, 2])
            if k >= first[w]:
                y[w, k - first[w], 0] = logged[k]
                if motor[k, MOVES] != 0.0:
                    y[w, k - first[w], 0] -= lacking(
                        state, k * dt, acceleration, u[k, 0], outside, p, e,
                        theta) / _gain(x1, e)
            if int(p[KIND]) == RIGID:
                continue
            for i in range(n):
                x1, x3, _ = motor_motion(motor, k + (i + 1.0) / n, dt, e)
                advance_arm(state, k * dt + i * h, h, x1, x3, outside, p, e, theta)
        if carry_at[w] == first[w] + length:
            for i in range(8):
                carry[w, i] = state[i]
        for k in range(length):
            y[w, k, 1] = reading(path, late + k, 1, dt, e)


@cache
def with_plugin(torques: Torques) -> Any:
    """Return driven_runs rebuilt around the `torques` of a plug-in effect."""
    all_torques = rebuilt(_torques, plugged=torques)
    return rebuilt(driven_runs, advance_arm=rebuilt(advance_arm, _torques=all_torques),
                   lacking=rebuilt(lacking, _torques=all_torques))
