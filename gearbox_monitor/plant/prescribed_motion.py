# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

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
from typing import Any, NamedTuple

from gearbox_monitor.kernels.jit import jit, jit_inline
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import (
    ALPHA, ARM_ALPHA, arm_friction, CAC, CAV, CC, CV, D, DriveModel, HALF_GAP, INVERSE_M1,
    INVERSE_M2, K_S, KIND, LAW, motor_acceleration_by_law, STIFFNESS, WIDTH)
from gearbox_monitor.plant.effects import Three, Torques
from gearbox_monitor.plant.effects.composition import (
    advanced_memories, DELAY1, elastic_torque, motor_corrected, motor_error, motor_gain, reading,
    stored_memories)
from gearbox_monitor.plant.effects.effect import MotorFriction
from gearbox_monitor.plant.free_runs import Begin, Driving, RunResult, RunSpans
from gearbox_monitor.plant.friction_law import side, side_slope
from gearbox_monitor.plant.simulate import N_STATE, PackedDrive, rebuilt, torques
from gearbox_monitor.plant.transmission import RIGID, transmission_torque

X1, X3, A1, MOVES, SMOOTH_U = range(5)  # columns of the motor's motion; SMOOTH_U acts on it
STEP_EIGENVALUE = 0.5         # step of time times the eigenfrequency of the arm on the spring
MAX_STEPS = 8                 # per sample; beyond, the spring is stiff and damped by THETA
NO_SETPOINT = (0.0, 0.0, 0.0)  # of a servo, which a motor whose motion is put in has not
THETA = 0.55                  # weight of a step's end: a little above the trapezoidal rule
DIFFERENCE = 1e-4             # rad/s, for the slope of the elastic torque
ITERATIONS, CLOSE = 4, 1e-9   # of Newton's method for the arm's speed; rad/s
FRICTION_ITERATIONS = 30
MIN_GAIN = 0.05  # of the torque that acts over the torque that is logged


def steps(model: DriveModel, dt: float) -> int:
    """Return the number of steps per sample of `dt` s that the arm of `model` asks for."""
    if model.transmission.kind == 'rigid':
        return 1
    t = model.folded().transmission
    fastest = math.sqrt((t.stiffness + t.hysteresis_stiffness) / model.folded().arm_inertia)
    return min(MAX_STEPS, max(1, math.ceil(dt * fastest / STEP_EIGENVALUE)))


class MotorMotion(NamedTuple):
    """
    A recording whose motor drives the model.

    logged: torque of the recording [N], N m. motor: motion of the motor [N, 5], columns X1, X3,
    A1, MOVES, SMOOTH_U; where it does not move, the torque that it needs counts as the logged one.
    """

    logged: Array
    motor: Array


@jit_inline
def motor_motion(motor: Array, at: float, dt: float, e: Array) -> Three:
    """
    Return the motion of the motor between samples.

    Args:
        motor: motion by the encoder [N, 5].
        at: row of `motor`, parts of a row count.
        dt: time from row to row, s.
        e: packed effects; those of the encoder are taken out.

    Returns:
        Position (rad), speed (rad/s) and acceleration (rad/s^2).
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
    error, slope, curvature = motor_error((0.0, 0.0, 0.0), e, motor_corrected(x, e))
    return (x - error, v * (1.0 - slope), acceleration * (1.0 - slope) - curvature * v * v)


@jit_inline
def _with_friction(slope: float, push: float, friction: float, alpha: float, law: float,
                   guess: float) -> float:
    """
    Return v of slope v + friction s(alpha v) = push: Newton's method, from below or a `guess`.

    s: side of the law.
    """
    if friction == 0.0:
        return push / slope
    size, guess = abs(push), math.copysign(1.0, push) * guess
    v = max(0.0, (size - friction) / slope)
    if guess > v and slope * guess + friction * side(alpha * guess, law) < size:
        v = guess
    for _ in range(FRICTION_ITERATIONS):
        av = alpha * v
        off = size - slope * v - friction * side(av, law)
        change = off / (slope + friction * alpha * side_slope(av, law))
        v += change
        if abs(change) < CLOSE:
            break
    return math.copysign(v, push)


@jit
def advance_arm(state: Array, t: float, h: float, end_x1: float, end_x3: float, external: Three,
                drive: PackedDrive) -> None:
    """
    Advance the arm by one step of the theta method, the motor to a prescribed motion.

    Implicit in the arm's speed, solved by Newton's method: light arms, stiff springs and dry
    friction on the arm take no smaller steps.

    Args:
        state: [N_STATE], changed in place.
        t: time at the begin, s.
        h: length of the step, s.
        end_x1: position of the motor at the end, rad.
        end_x3: its speed there, rad/s.
        external: torques from outside on motor, arm and in the transmission, N m.
        drive: PackedDrive.
    """
    p, e = drive.p, drive.e
    x1, x2, x3, x4 = state[0], state[1], state[2], state[3]
    m = stored_memories(state)
    base = MotorFriction(p[CV], p[CC], p[ALPHA], p[LAW])
    tau_k, tau_arm, _ = torques(t, (x1, x2, x3, x4), m, 0.0, drive)
    elastic = elastic_torque(x1, x2, m, p, e)
    load = tau_arm - external[1]
    if p[CAC] != 0.0:
        load -= arm_friction(x4, p)
    force = tau_k + external[2] - THETA * elastic - load + p[D] * (1.0 - THETA) * (x3 - x4)
    force += p[D] * THETA * end_x3 + p[CAV] * THETA * x4
    inertia, v = 1.0 / p[INVERSE_M2], x4
    for _ in range(ITERATIONS):
        residual = slope = 0.0
        for shift in (DIFFERENCE, 0.0):
            moved = v + shift
            end = advanced_memories(m, NO_SETPOINT, 0.5 * (x3 + end_x3), 0.5 * (x4 + moved), h,
                                    base, e)
            tau = elastic_torque(end_x1, x2 + 0.5 * h * (x4 + moved), end, p, e)
            slope = residual
            residual = inertia * (moved - x4) - h * (
                force + THETA * (tau - (p[D] + p[CAV]) * moved))
        slope = max((slope - residual) / DIFFERENCE, inertia)
        last = v
        v = _with_friction(slope, slope * v - residual, h * p[CAC], p[ARM_ALPHA], p[LAW], v)
        if abs(v - last) < CLOSE:
            break
    mean1, mean2 = 0.5 * (x3 + end_x3), 0.5 * (x4 + v)
    x2 += h * mean2
    _, w = transmission_torque(end_x1 - x2, m[0], int(p[KIND]), p[STIFFNESS], p[HALF_GAP],
                               p[WIDTH], p[K_S])
    m = advanced_memories(m, NO_SETPOINT, mean1, mean2, h, base, e)
    state[0], state[1], state[2], state[3], state[4] = end_x1, x2, end_x3, v, w
    for i in range(1, N_STATE - 4):
        state[4 + i] = m[i]


@jit
def torque_surplus(state: Array, t: float, acceleration: float, u: float, external: Three,
                   drive: PackedDrive) -> float:
    """
    Return the torque that acts on the motor beyond what its motion needs.

    In a rigid drive, on motor and arm.

    Args:
        state: [N_STATE].
        t: time, s.
        acceleration: of the motor, rad/s^2.
        u: torque of the actuator, N m.
        external: torques from outside on motor, arm and in the transmission, N m.
        drive: PackedDrive.

    Returns:
        Torque, N m.
    """
    p = drive.p
    x = (state[0], state[1], state[2], state[3])
    tau_k, tau_arm, motor = torques(t, x, stored_memories(state), u, drive)
    if int(p[KIND]) == RIGID:
        tau_k = acceleration / p[INVERSE_M2] + tau_arm - external[1]
    else:
        tau_k += external[2]
    modelled = motor_acceleration_by_law(x[0], x[2], x[3], u + motor + external[0], tau_k, p)
    return (modelled - acceleration) / p[INVERSE_M1]


@jit
def driven_runs(spans: RunSpans, start: Begin, driving: Driving, motion: MotorMotion,
                drive: PackedDrive, rows: Array, result: RunResult) -> None:
    """
    Run windows with the motor on its measured motion.

    Args:
        spans: the windows.
        start: where they begin; states of the motor do not count.
        driving: torques, with n steps in each sample.
        motion: of the motor, and its torque.
        drive: PackedDrive.
        rows: room to work in [longest run + 1, N_STATE].
        result: is filled in; y has the torque that the motor needs (N m) and the reading of the
            arm (rad).
    """
    begin, first, length, carry_at, extra_at = spans
    u, extra, dt = driving
    motor, p, e = motion.motor, drive.p, drive.e
    y, carry = result
    n = u.shape[1]
    h = dt / n
    for w in range(len(begin)):
        state = rows[0]
        state[1], state[3] = start.states[w, 1], start.states[w, 3]
        for i in range(N_STATE - 4):
            state[4 + i] = start.memory[w, i]
        path = rows[1:]
        lead = first[w] - begin[w]
        for k in range(begin[w], first[w] + length):
            x1, x3, acceleration = motor_motion(motor, float(k), dt, e)
            state[0], state[2] = x1, x3
            if int(p[KIND]) == RIGID:
                state[1], state[3] = x1, x3
            for i in range(N_STATE):
                path[k - begin[w], i] = state[i]
            if k == carry_at[w]:
                for i in range(N_STATE):
                    carry[w, i] = state[i]
            row = extra[extra_at[w] + k - begin[w]]
            external = (row[0], row[1], row[2])
            if k >= first[w]:
                y[w, k - first[w], 0] = motion.logged[k]
                if motor[k, MOVES] != 0.0:
                    # What is missing counts as torque that was logged.
                    y[w, k - first[w], 0] -= torque_surplus(
                        state, k * dt, acceleration, u[k, 0], external, drive) / max(
                            motor_gain(1.0, e, x1), MIN_GAIN)
            if int(p[KIND]) == RIGID:
                continue
            for i in range(n):
                x1, x3, _ = motor_motion(motor, k + (i + 1.0) / n, dt, e)
                advance_arm(state, k * dt + i * h, h, x1, x3, external, drive)
        if carry_at[w] == first[w] + length:
            for i in range(N_STATE):
                carry[w, i] = state[i]
        for k in range(length):
            y[w, k, 1] = reading(path, lead + k, 1, dt, e)


@cache
def with_plugin(added: Torques) -> Any:
    """Return driven_runs rebuilt around the torques `added` by a plug-in."""
    with_added = rebuilt(torques, plugged=added)
    return rebuilt(driven_runs, advance_arm=rebuilt(advance_arm, torques=with_added),
                   torque_surplus=rebuilt(torque_surplus, torques=with_added))
