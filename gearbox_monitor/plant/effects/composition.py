# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What all effects together do to the drive: kernels composed of the equations in the registry.

Each equation becomes a term: a closure over the place of its parameters in the packed array e
(registry.pack) that is skipped where the effect is off. The terms of a slot are chained, each
around the one that acts before it, and compiled into the kernels that call the chain: an effect is
written once, and where a model does not have it, it costs a comparison.
"""
from collections import namedtuple
from collections.abc import Callable, Sequence
from functools import reduce
import math
from typing import Any, NamedTuple

from gearbox_monitor.kernels.elementary import exponential
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import Array, Matrix, Vector
from gearbox_monitor.plant.drive import (
    ALPHA, CC, CV, HALF_GAP, K_S, KIND, LAW, STIFFNESS, WIDTH)
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY, ACTUATOR_LAG
from gearbox_monitor.plant.effects.controller import (
    SERVO_DEADBAND, SERVO_LIMIT, SETPOINT_DELAY, SETPOINT_LAG)
from gearbox_monitor.plant.effects.effect import Coefficients, Effect, MotorFriction, Three
from gearbox_monitor.plant.effects.encoder import ARM_ENCODER_DELAY, MOTOR_ENCODER_DELAY
from gearbox_monitor.plant.effects.motor_side import LUGRE
from gearbox_monitor.plant.effects.registry import (
    HELD, in_slot, INTEGRAL, LATE_A, LATE_B, LATE_C, MEMORIES, N_MEMORY, PLACES,
    SERVO_ACCELERATION, SERVO_KD, SERVO_KI, SERVO_KP, SERVO_LATE, SERVO_SPEED, SERVO_TORQUE)
from gearbox_monitor.plant.transmission import dead_zone, transmission_torque

LAG, DELAY = PLACES[ACTUATOR_LAG.id], PLACES[ACTUATOR_DELAY.id]
SERVO_LAG, SERVO_DELAY = PLACES[SETPOINT_LAG.id], PLACES[SETPOINT_DELAY.id]
DEADBAND, LIMIT = PLACES[SERVO_DEADBAND.id], PLACES[SERVO_LIMIT.id]
BRISTLES = PLACES[LUGRE.id]
DELAY1, DELAY2 = PLACES[MOTOR_ENCODER_DELAY.id], PLACES[ARM_ENCODER_DELAY.id]
# What happens between command and actuator, or setpoint and servo, depends on these alone.
COMMAND_PLACES = [*(PLACES[effect.id] for effect in (
    *in_slot('command'), ACTUATOR_LAG, ACTUATOR_DELAY, SETPOINT_LAG, SETPOINT_DELAY)),
    SERVO_KP, SERVO_KI, SERVO_SPEED, SERVO_ACCELERATION, HELD]
NO_ERROR = (0.0, 0.0, 0.0)
# Approximation of Pade of exp(-s), third order: -1 + (240 + 24 s^2) / (120 + 60 s + 12 s^2 + s^3),
# by its poles, a real one and a complex pair, and their residues.
LATE_POLE = -4.644370709252172
LATE_REAL, LATE_IMAGINARY = -3.6778146453739153, 3.5087619195674447
_SHARES = [(240.0 + 24.0 * p ** 2) / (60.0 + 24.0 * p + 3.0 * p ** 2)
           for p in (complex(LATE_POLE), complex(LATE_REAL, LATE_IMAGINARY))]
LATE_SHARE, SHARE_REAL, SHARE_IMAGINARY = _SHARES[0].real, _SHARES[1].real, _SHARES[1].imag
INVERSE_REAL, INVERSE_IMAGINARY = (
    part / (LATE_REAL ** 2 + LATE_IMAGINARY ** 2) for part in (LATE_REAL, -LATE_IMAGINARY))
Kernel = Callable[..., Any]


class Term(NamedTuple):
    """What the term of an effect is built of: its equation, and how it finds its parameters."""

    equation: Kernel                       # of the slot
    read: Callable[[Array], Coefficients]  # the parameters by name, from a packed array
    place: int                             # of the first parameter in a packed array
    memory: int                            # place of its memory, 0 for an effect without


def term_of(effect: Effect, slot: str) -> Term:
    """Return the Term of `effect` in `slot`."""
    make_type: Any = namedtuple  # made at run time: no type for mypy
    coefficients = make_type(effect.id, [p.name for p in effect.parameters])
    k = PLACES[effect.id]

    places = tuple(range(k, k + len(effect.parameters)))

    def _array(e: Array) -> Coefficients:
        return e, k

    def _named(e: Array) -> Coefficients:
        return coefficients(*(e[place] for place in places))
    return Term(getattr(effect, slot), _array if effect.size else _named, k,
                MEMORIES.get(effect.id, 0))


def chained(terms: Sequence[Kernel]) -> Kernel:
    """Return the function (value, *arguments) -> value that applies `terms` one by one."""
    def _unchanged(value: Any, *arguments: Any) -> Any:
        return value

    def _joined(first: Kernel, second: Kernel) -> Kernel:
        def _both(value: Any, *arguments: Any) -> Any:
            return second(first(value, *arguments), *arguments)
        return _both
    return reduce(_joined, terms) if terms else _unchanged


def _chain(slot: str, applied: Kernel, effects: Sequence[Effect] | None = None) -> Kernel:
    """
    Return the function (value, e, *arguments) -> value of a slot: of each effect that is on.

    Args:
        slot: of the equations.
        applied: (equation, its parameters, place of its memory, value, *arguments) -> value.
        effects: in their order, None for all in the slot.
    """
    def _of(effect: Effect) -> Kernel:
        equation, read, place, memory = term_of(effect, slot)
        off = effect.off

        def _term(value: Any, e: Array, *arguments: Any) -> Any:
            if e[place] != off:
                value = applied(equation, read(e), memory, value, *arguments)
            return value
        return _term
    return chained([_of(effect) for effect in (in_slot(slot) if effects is None else effects)])


def _memory(effect: Effect) -> Kernel:
    equation, read, place, memory = term_of(effect, 'memory')

    def _term(advanced: Any, e: Array, m: Any, x3: float, x4: float, h: float, base: Any) -> Any:
        z = m[memory]
        if e[place] != 0.0:
            z = equation(read(e), z, x3, x4, h, base)
        return advanced + (z,)
    return _term


def _stored(place: int) -> Kernel:
    def _term(memories: Any, state: Array) -> Any:
        return memories + (state[4 + place],)
    return _term


@inline
def _plus(a: Three, b: Three) -> Three:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _of_encoder(place: str) -> tuple[Kernel, Kernel, Kernel]:
    """Return the reading of a position, the position of a reading, and the error of an encoder."""
    own = [effect for effect in in_slot('encoder_error') if effect.location == place]
    return (_chain('encoder_error', lambda f, c, k, x: x + f(c, x)[0], own),
            _chain('encoder_error', lambda f, c, k, x: x - f(c, x)[0], own[::-1]),
            _chain('encoder_error', lambda f, c, k, total, x: _plus(total, f(c, x)), own))


# (value, e, ...) -> value, see the terms above; m: the memories, a tuple of N_MEMORY numbers, of
# which the first is that of the transmission.
friction_effects = _chain(
    'friction', lambda f, c, k, value, m, t, x3, base: value + f(c, t, x3, m[k], base))
arm_effects = _chain(
    'arm_torque', lambda f, c, k, value, m, t, x2, x4: value + f(c, t, x2, x4, m[k]))
twist_effects = _chain('twist', lambda f, c, k, value, m, x1, x2: value + f(c, x1, x2, m[k]))
elastic_effects = _chain(
    'elastic', lambda f, c, k, value, m, twist, half_gap: value + f(c, twist, m[k], half_gap))
torque_effects = _chain('motor_torque', lambda f, c, k, u, x1, x3: f(c, x1, x3, u))
motor_gain = _chain('motor_gain', lambda f, c, k, gain, x1: gain * f(c, x1))
command_effects = _chain('command', lambda f, c, k, u: f(c, u))
motor_read, motor_corrected, motor_error = _of_encoder('motor_sensor')
arm_read, arm_corrected, arm_error = _of_encoder('arm_sensor')
_advanced = chained([_memory(effect) for effect in in_slot('memory')])
memories_of = chained([_stored(place) for place in range(1, N_MEMORY)])


@inline
def _limited(u: float, e: Array) -> float:
    limit = min(e[SERVO_TORQUE], e[LIMIT])
    return min(max(u, -limit), limit)


@inline
def _control_law(r: float, e: Array, x1: float, x3: float, integral: float) -> float:
    """Return the torque (N m) that the servo computes of setpoint and motion, see servo."""
    error, slope, _ = motor_error(NO_ERROR, e, x1)
    return _limited(e[SERVO_KP] * dead_zone(r - x1 - error, e[DEADBAND]) + integral
                    - e[SERVO_KD] * x3 * (1.0 + slope), e)


@inline
def servo(r: float, e: Array, x1: float, x3: float, memory: Any) -> float:
    """
    Return the torque that a servo and the actuator behind it make of a setpoint.

    The servo reads its own encoder, with its eccentricity, without noise. Its delay T is an
    approximation of Pade in its modal form T w' = p w + u, p the poles.

    Args:
        r: setpoint, rad; without a servo a torque, which is returned.
        e: packed effects.
        x1: position of the motor, rad.
        x3: its speed, rad/s.
        memory: torque of the integrator, real and imaginary part of w of the complex pole, w of
            the real one, N m.

    Returns:
        Torque, N m.
    """
    if e[SERVO_KP] == 0.0:
        return r
    integral, a, b, c = memory
    u = _control_law(r, e, x1, x3, integral)
    if e[SERVO_LATE] > 0.0:
        u = _limited(LATE_SHARE * c + 2.0 * (SHARE_REAL * a - SHARE_IMAGINARY * b) - u, e)
    return command_effects(u, e)


@inline
def step_damper(r: float, e: Array, x1: float, x3: float, m: Any) -> float:
    """
    Return the damping that MuJoCo's implicitfast has at the end of a step beside the model's own.

    That of bristles, and that of a servo whose torque is not at its limit.

    Args:
        r: setpoint, rad.
        e: packed effects.
        x1: position of the motor, rad.
        x3: its speed, rad/s.
        m: memories.

    Returns:
        N m s/rad.
    """
    bristles = e[BRISTLES + 1] if e[BRISTLES] != 0.0 else 0.0
    if e[SERVO_KP] == 0.0 or e[SERVO_KD] == 0.0:
        return bristles
    limit = min(e[SERVO_TORQUE], e[LIMIT])
    free = abs(_control_law(r, e, x1, x3, m[INTEGRAL])) < limit
    return bristles + e[SERVO_KD] if free else bristles


@inline
def late_fade(h: float, e: Array) -> Any:
    """
    Return h / T of the servo's delay T, and exp(p h / T): real, imaginary part; real pole.

    Args:
        h: length of a step, s.
        e: packed effects.
    """
    if e[SERVO_LATE] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    spans = h / e[SERVO_LATE]
    fade = exponential(LATE_REAL * spans)
    return (spans, fade * math.cos(LATE_IMAGINARY * spans),
            fade * math.sin(LATE_IMAGINARY * spans), exponential(LATE_POLE * spans))


@inline
def advanced_servo(memory: Any, begin: Three, x3: float, h: float, late: Any, e: Array) -> Any:
    """
    Return the memory of the servo after a step, exact for a torque that changes evenly.

    Args:
        memory: of the servo at the begin, see servo.
        begin: setpoint, rad, position of the motor, rad, and its speed, rad/s, at the begin.
        x3: mean speed of the motor, rad/s.
        h: length of the step, s.
        late: late_fade of it.
        e: packed effects.

    Returns:
        The memory at the end.
    """
    integral, a, b, c = memory
    r, x1, v = begin
    if e[SERVO_KI] > 0.0:
        middle = x1 + 0.5 * h * x3
        error, _, _ = motor_error(NO_ERROR, e, middle)
        integral = _limited(
            integral + h * e[SERVO_KI] * dead_zone(r - middle - error, e[DEADBAND]), e)
    if e[SERVO_LATE] > 0.0:
        spans, cosine, sine, fade = late
        first = _control_law(r, e, x1, v, memory[0])
        last = _control_law(r, e, x1 + h * x3, 2.0 * x3 - v, integral)
        # w = f + g t / T + (w(0) - f) exp(p t / T), g = -u' T / p, f = (g - u(0)) / p
        slope = (last - first) / spans
        ga, gb = -slope * INVERSE_REAL, -slope * INVERSE_IMAGINARY
        fa = (ga - first) * INVERSE_REAL - gb * INVERSE_IMAGINARY
        fb = (ga - first) * INVERSE_IMAGINARY + gb * INVERSE_REAL
        gc = -slope / LATE_POLE
        fc = (gc - first) / LATE_POLE
        a, b = (fa + ga * spans + (a - fa) * cosine - (b - fb) * sine,
                fb + gb * spans + (a - fa) * sine + (b - fb) * cosine)
        c = fc + gc * spans + (c - fc) * fade
    return integral, a, b, c


@inline
def motor_effects(u: float, e: Array, x1: float, x3: float, m: Any) -> float:
    """
    Return the torque that acts on the motor.

    Args:
        u: torque of the actuator, N m, or setpoint of the servo, rad.
        e: packed effects.
        x1: position of the motor, rad.
        x3: its speed, rad/s.
        m: memories.

    Returns:
        Torque, N m.
    """
    return torque_effects(servo(
        u, e, x1, x3, (m[INTEGRAL], m[LATE_A], m[LATE_B], m[LATE_C])), e, x1, x3)


@inline
def advanced_memories(m: Any, begin: Three, x3: float, x4: float, h: float, base: Any,
                      e: Array) -> Any:
    """
    Return the memories of servo and effects after a step.

    Args:
        m: memories at the begin [N_MEMORY]; the first, of the transmission, stays.
        begin: of advanced_servo.
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        h: length of the step, s.
        base: MotorFriction of the model.
        e: packed effects.

    Returns:
        The memories at the end.
    """
    return _advanced((m[0],), e, m, x3, x4, h, base) + advanced_servo(
        (m[INTEGRAL], m[LATE_A], m[LATE_B], m[LATE_C]), begin, x3, h, late_fade(h, e), e)


@inline
def base_friction(p: Array) -> MotorFriction:
    """Return the friction of the model `p`, packed, that effects act beside."""
    return MotorFriction(p[CV], p[CC], p[ALPHA], p[LAW])


@inline
def stored_memories(state: Array) -> Any:
    """Return the memories in `state` [4 + N_MEMORY] as a tuple."""
    return memories_of((state[4],), state)


@inline
def elastic_torque(x1: float, x2: float, m: Any, p: Array, e: Array) -> float:
    """
    Return tau_K of a transmission that is not rigid, with all effects in it.

    Args:
        x1: position of the motor, rad.
        x2: position of the arm, rad.
        m: memories.
        p: packed model.
        e: packed effects.

    Returns:
        Torque, N m.
    """
    twist = twist_effects(x1 - x2, e, m, x1, x2)
    tau_k, _ = transmission_torque(twist, m[0], int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH],
                                   p[K_S])
    return elastic_effects(tau_k, e, m, twist, p[HALF_GAP])


@entry
def steady_command(u: float, e: Vector) -> float:
    """Return the torque (N m) of an actuator at rest under the command `u`, `e` packed effects."""
    return u if e[SERVO_KP] != 0.0 else command_effects(u, e)


@entry
def lead(r: Vector, past: Vector, dt: float, e: Vector) -> None:
    """
    Move setpoints ahead so that a servo without feedforward does what one with it does.

    By h, with kp h + ki int h dt = kff r' + kaff r''. The slopes r' and r'' are differences of the
    last setpoints.

    Args:
        r: setpoints [N], rad, moved in place; without a servo torques, which stay.
        past: setpoint before the first one, that before it, rad, and int h dt, rad s [3]; carried
            on to the next one.
        dt: length of a sample, s.
        e: packed effects.
    """
    if e[SERVO_SPEED] == 0.0 and e[SERVO_ACCELERATION] == 0.0:
        return
    kp, ki = e[SERVO_KP], e[SERVO_KI]
    for k in range(len(r)):
        slope, earlier = (r[k] - past[0]) / dt, (past[0] - past[1]) / dt
        torque = e[SERVO_SPEED] * slope + e[SERVO_ACCELERATION] * (slope - earlier) / dt
        past[1], past[0] = past[0], r[k]
        ahead = (torque - ki * past[2]) / (kp + 0.5 * ki * dt)
        past[2] += ahead * dt
        r[k] += ahead


@entry
def actuator(u: Vector, past: int, act: float, dt: float, e: Vector, out: Matrix) -> float:
    """
    Fill `out` with the mean torque of the actuator in each part of each sample.

    In this order: dead time, effects on the command, lag. With a servo, u and out are setpoints,
    and the effects on the command act behind it.

    Args:
        u: commanded torque [past + N], held over a sample, N m.
        past: number of samples of the past at the front of u.
        act: torque at the begin, N m.
        dt: length of a sample, s.
        e: packed effects.
        out: torque [N, n], N m.

    Returns:
        The torque at the end, N m.
    """
    n = out.shape[1]
    h = dt / n
    lag, delay = e[LAG] + e[SERVO_LAG], e[DELAY] + e[SERVO_DELAY]
    fade = math.exp(-h / lag) if lag > 0.0 else 0.0
    share = lag / h * (1.0 - fade)
    for k in range(out.shape[0]):
        for i in range(n):
            command = u[past + k]
            if delay > 0.0:
                begin = (i * h - delay) / dt
                first = math.floor(begin)
                last = math.floor(begin + 1.0 / n)
                command = u[max(0, past + k + int(first))]
                if last > first:
                    over = (begin + 1.0 / n - last) * n
                    command += over * (u[max(0, past + k + int(last))] - command)
            if e[SERVO_KP] == 0.0:
                command = command_effects(command, e)
            if lag > 0.0:
                out[k, i] = act if e[HELD] != 0.0 else command + (act - command) * share
                act = command + (act - command) * fade
            else:
                out[k, i] = act = command
    return act


@kernel
def reading(x: Array, k: int, i: int, dt: float, e: Array) -> float:
    """
    Return what an encoder reads, without noise.

    Delayed between samples by a cubic through positions and speeds; before row 0 the drive stood.

    Args:
        x: states [N, 4].
        k: row of x.
        i: 0 for the encoder of the motor, 1 for that of the arm.
        dt: time from row to row, s.
        e: packed effects.

    Returns:
        The reading, rad.
    """
    delay = (e[DELAY1] if i == 0 else e[DELAY2]) / dt
    position = x[k, i]
    if delay > 0.0:
        # Parts of the delay, not of the row: then the numbers do not depend on where x begins.
        f = math.ceil(delay) - delay
        j = k - int(math.ceil(delay))
        if j < 0:
            position = x[0, i]
        else:
            a, b = x[j, i], x[j + 1, i]
            va, vb = x[j, 2 + i] * dt, x[j + 1, 2 + i] * dt
            position = (a + f * (va + f * (3.0 * (b - a) - 2.0 * va - vb
                                           + f * (2.0 * (a - b) + va + vb))))
    return motor_read(position, e) if i == 0 else arm_read(position, e)
