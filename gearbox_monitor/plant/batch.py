# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free runs of the drive over windows of a recording, side by side in the lanes of a vector unit.

Each lane has the bits of a run by itself (simulate.advance).
"""
from collections.abc import Callable
from functools import cache, reduce
from typing import Any, NamedTuple, TypeAlias

from gearbox_monitor.kernels.kernel import apart, entry, inline, kernel
from gearbox_monitor.kernels.types import Array, Cube, Integers, Matrix, Vector
from gearbox_monitor.plant.drive import (
    arm_acceleration, ARM_ALPHA, CAC, G, gravity, HALF_GAP, INTEGRATOR, KIND, LAW,
    motor_acceleration, steady_arm_load, STIFFNESS)
from gearbox_monitor.plant.effects.composition import (
    advanced_servo, base_friction, late_fade, reading, servo, stored_memories, term_of)
from gearbox_monitor.plant.effects.effect import Effect, MotorFriction, Torques
from gearbox_monitor.plant.effects.registry import (
    in_slot, INTEGRAL, N_MEMORY, SERVO_KI, SERVO_KP, SERVO_LATE)
from gearbox_monitor.plant.simulate import PackedDrive, play_after, rebuilt, step, with_plugin
from gearbox_monitor.plant.transmission import ATAN, DEAD_ZONE, dead_zone, RK4, side


class RunSpans(NamedTuple):
    """
    Windows of one length in a recording, in samples.

    first: first sample of each window [W]; length: of all; begin: where its run starts [W], a
    little earlier, so that delayed readings have a past; carry_at: where the next begins [W];
    extra_at: row of Driving.extra where each begins [W], so that windows may overlap and still be
    driven each by its own torque from outside.
    """

    begin: Integers
    first: Integers
    length: int
    carry_at: Integers
    extra_at: Integers


class Begin(NamedTuple):
    """Where runs begin: states [W, 4] (rad, rad/s) and memories [W, N_MEMORY]."""

    states: Matrix
    memory: Matrix


class Driving(NamedTuple):
    """
    What drives a recording of N samples.

    u: torque of the actuator [N, n] in each of n substeps, N m. extra: torque from outside [M, 3]
    on motor, arm and in the transmission, N m. dt: length of a sample, s.
    """

    u: Matrix
    extra: Matrix
    dt: float


class RunResult(NamedTuple):
    """Room for readings y [W, L, 2] and for states where the next window begins [W, N_STATE]."""

    y: Cube
    carry: Matrix


LANES = 16
OWN = -1  # row of the memory of an effect, for _added
# State: motion, then memories, time. Then torque of the actuator and torques from outside.
X1, X2, X3, X4, M = (LANES * i for i in range(5))
T, U, ON_MOTOR, ON_ARM, IN_GEARBOX = (M + LANES * (N_MEMORY + i) for i in range(5))
# A stage of a step with effects: where it is, its memories.
Y1, Y2, Y3, Y4, YM = (IN_GEARBOX + LANES * (1 + i) for i in range(5))
# Its time, accelerations, sums over stages, parts of torques.
YT, RATE3, RATE4, SUM1, SUM2, SUM3, SUM4, TWIST, TAU_K, LOAD, MOTOR, FRICTION = (
    YM + LANES * (N_MEMORY + i) for i in range(12))
N_LANE_STATE = FRICTION + LANES
Loop: TypeAlias = Callable[..., None]


def _loops(slot: str, term: Callable[[Effect], Loop]) -> Loop:
    """Return the function that runs the loop over the lanes of each effect in `slot`."""
    def joined(first: Loop, second: Loop) -> Loop:
        def both(*arguments: Any) -> None:
            first(*arguments)
            second(*arguments)
        return both

    def nothing(*arguments: Any) -> None:
        pass
    return reduce(joined, [term(effect) for effect in in_slot(slot)], nothing)


def _added(slot: str, total: int, *rows: int) -> Callable[[Effect], Loop]:
    """
    Return what makes loops of a `slot` whose equations add to the row `total`, or replace it.

    rows: of the arguments of the equation; OWN stands for the memory of the effect. What takes the
    row `total` itself replaces it.
    """
    def of(effect: Effect) -> Loop:
        equation, read, place, memory = term_of(effect, slot)
        own = tuple(YM + LANES * memory if row == OWN else row for row in rows)
        kept = 0.0 if total in rows else 1.0

        def term(s: Array, lanes: int, e: Array, *more: Any) -> None:
            if e[place] != 0.0:
                c = read(e)
                for i in range(lanes):
                    s[total + i] = kept * s[total + i] + equation(
                        c, *(tuple(s[row + i] for row in own) + more))
        return term
    return of


def _memory(effect: Effect) -> Loop:
    equation, read, place, memory = term_of(effect, 'memory')
    row, begin = YM + LANES * memory, M + LANES * memory

    def term(s: Array, lanes: int, x3: int, x4: int, h: float, base: MotorFriction,
             e: Array) -> None:
        if e[place] != 0.0:
            c = read(e)
            for i in range(lanes):
                s[row + i] = equation(c, s[begin + i], s[x3 + i], s[x4 + i], h, base)
    return term


_friction_loops = _loops('friction', _added('friction', FRICTION, YT, Y3, OWN))
_arm_loops = _loops('arm_torque', _added('arm_torque', LOAD, YT, Y2, Y4, OWN))
_twist_loops = _loops('twist', _added('twist', TWIST, Y1, Y2, OWN))
_elastic_loops = _loops('elastic', _added('elastic', TAU_K, TWIST, OWN))
_motor_loops = _loops('motor_torque', _added('motor_torque', MOTOR, Y1, Y3, MOTOR))
# Memories of a stage: h s after the begin of the step at the speeds s[x3], s[x4].
_effect_memories = _loops('memory', _memory)
IN_SERVO, OF_SERVO = YM + LANES * INTEGRAL, M + LANES * INTEGRAL  # rows in a stage, at its begin


@inline
def _memory_loops(s: Array, lanes: int, x3: int, x4: int, h: float, p: Array, e: Array) -> None:
    _effect_memories(s, lanes, x3, x4, h, base_friction(p), e)
    if e[SERVO_KI] > 0.0 or e[SERVO_LATE] > 0.0:
        fade = late_fade(h, e)
        for i in range(lanes):
            (s[IN_SERVO + i], s[IN_SERVO + LANES + i], s[IN_SERVO + 2 * LANES + i],
             s[IN_SERVO + 3 * LANES + i]) = advanced_servo(
                (s[OF_SERVO + i], s[OF_SERVO + LANES + i], s[OF_SERVO + 2 * LANES + i],
                 s[OF_SERVO + 3 * LANES + i]),
                (s[U + i], s[X1 + i], s[X3 + i]), s[x3 + i], h, fade, e)


@kernel
def _rates(s: Array, lanes: int, elapsed: float, p: Array, e: Array) -> None:
    """Fill in the accelerations of a stage, `elapsed` s after the begin of the step."""
    for i in range(lanes):
        s[TWIST + i] = s[Y1 + i] - s[Y2 + i]
        s[FRICTION + i] = 0.0
        s[MOTOR + i] = s[U + i]
        s[LOAD + i] = steady_arm_load(s[Y4 + i], p)
        s[YT + i] = s[T + i] + elapsed
    _twist_loops(s, lanes, e)
    for i in range(lanes):
        s[TAU_K + i] = p[STIFFNESS] * dead_zone(s[TWIST + i], p[HALF_GAP])
    _elastic_loops(s, lanes, e, p[HALF_GAP])
    if e[SERVO_KP] != 0.0:
        for i in range(lanes):
            s[MOTOR + i] = servo(s[U + i], e, s[Y1 + i], s[Y3 + i],
                                 (s[IN_SERVO + i], s[IN_SERVO + LANES + i],
                                  s[IN_SERVO + 2 * LANES + i], s[IN_SERVO + 3 * LANES + i]))
    _motor_loops(s, lanes, e)
    _friction_loops(s, lanes, e, base_friction(p))
    if p[CAC] != 0.0:
        for i in range(lanes):
            s[LOAD + i] += p[CAC] * side(p[ARM_ALPHA] * s[Y4 + i], ATAN)
    if p[G] != 0.0:
        for i in range(lanes):
            s[LOAD + i] += gravity(s[Y2 + i], p)
    _arm_loops(s, lanes, e)
    for i in range(lanes):
        u, tau_k = s[U + i], s[TAU_K + i] + s[IN_GEARBOX + i]
        motor = s[MOTOR + i] - u - s[FRICTION + i]
        s[RATE3 + i] = motor_acceleration(s[Y1 + i], s[Y3 + i], s[Y4 + i],
                                          u + motor + s[ON_MOTOR + i], tau_k, p)
        s[RATE4 + i] = arm_acceleration(s[Y3 + i], s[Y4 + i], tau_k, s[LOAD + i] - s[ON_ARM + i],
                                        p)


@apart
def _step_by_term(s: Array, lanes: int, h: float, p: Array, e: Array) -> None:
    """
    Advance the first `lanes` states in `s` by one step of `h` s, as runge_kutta does.

    Stage by stage: each term of `p` and `e` is a loop of its own, so that what an effect needs is
    decided once for all lanes.
    """
    half = 0.5 * h
    for i in range(lanes):
        s[Y1 + i], s[Y2 + i], s[Y3 + i], s[Y4 + i] = s[X1 + i], s[X2 + i], s[X3 + i], s[X4 + i]
    s[YM:YM + N_MEMORY * LANES] = s[M:M + N_MEMORY * LANES]
    for stage in range(4):
        elapsed = 0.0 if stage == 0 else (half if stage < 3 else h)
        _rates(s, lanes, elapsed, p, e)
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
            span = half if stage < 2 else h
            _memory_loops(s, lanes, Y3, Y4, span, p, e)
            for i in range(lanes):
                s[Y1 + i] = s[X1 + i] + span * s[Y3 + i]
                s[Y2 + i] = s[X2 + i] + span * s[Y4 + i]
                s[Y3 + i] = s[X3 + i] + span * s[RATE3 + i]
                s[Y4 + i] = s[X4 + i] + span * s[RATE4 + i]
    for i in range(lanes):
        s[SUM1 + i], s[SUM2 + i] = s[SUM1 + i] / 6.0, s[SUM2 + i] / 6.0
    _memory_loops(s, lanes, SUM1, SUM2, h, p, e)
    for i in range(lanes):
        s[X1 + i] += h * s[SUM1 + i]
        s[X2 + i] += h * s[SUM2 + i]
        s[X3 + i] += h / 6.0 * s[SUM3 + i]
        s[X4 + i] += h / 6.0 * s[SUM4 + i]
        s[T + i] += h
    s[M:M + N_MEMORY * LANES] = s[YM:YM + N_MEMORY * LANES]


@apart
def _step_each(s: Array, h: float, taken: int, drive: PackedDrive) -> None:
    """Advance the first `taken` states in `s` by one step of `h` s as simulate.advance does."""
    for i in range(taken):
        state = s[i::LANES]
        change, m = step(s[T + i], (state[0], state[1], state[2], state[3]),
                         stored_memories(state), h,
                         (s[U + i], (s[ON_MOTOR + i], s[ON_ARM + i], s[IN_GEARBOX + i]), drive))
        for j in range(4):
            state[j] += change[j]
        for j in range(1, N_MEMORY):
            state[4 + j] = m[j]
        state[4] = play_after((state[0], state[1], state[2], state[3]), m, drive.p)
        s[T + i] += h


@inline
def steps_by_term(drive: PackedDrive) -> bool:
    """Return whether step_lanes steps all lanes of a drive term by term, and not one by one."""
    p = drive.p
    return p[KIND] == DEAD_ZONE and p[LAW] == ATAN and p[INTEGRATOR] == RK4


@inline
def step_lanes(s: Array, h: float, taken: int, by_term: bool, drive: PackedDrive) -> None:
    """
    Advance the LANES states in `s` by one Runge-Kutta step.

    Args:
        s: states and what acts on them [N_LANE_STATE].
        h: length of the step, s.
        taken: number of states that count; the others may stay.
        by_term: see steps_by_term.
        drive: PackedDrive.
    """
    if by_term:
        # Whole vectors of at most 4.
        _step_by_term(s, (taken + 3) // 4 * 4, h, drive.p, drive.e)
    else:
        _step_each(s, h, taken, drive)


@cache
def steps_with_plugin(added: Torques) -> Loop:
    """Return step_lanes for drives with a plug-in; `added` are the torques of its Effect."""
    step_each, = with_plugin(added, _step_each)

    def plugged_lanes(s: Array, h: float, taken: int, by_term: bool, drive: PackedDrive) -> None:
        step_each(s, h, taken, drive)
    return plugged_lanes


@entry
def runs(spans: RunSpans, start: Begin, driving: Driving, drive: PackedDrive, s: Vector,
         path: Cube, result: RunResult) -> None:
    """
    Run windows side by side.

    Args:
        spans: the windows.
        start: where they begin.
        driving: what acts on the drive.
        drive: PackedDrive.
        s: room to work in [N_LANE_STATE].
        path: room to work in [LANES, longest run, 4].
        result: is filled in.
    """
    begin, first, length, carry_at, extra_at = spans
    u, extra, dt = driving
    n = u.shape[1]
    h, last = dt / n, len(begin) - 1
    by_term = steps_by_term(drive)
    for group in range(0, len(begin), LANES):
        longest, taken = 0, min(LANES, last + 1 - group)
        for i in range(LANES):
            w = min(group + i, last)
            longest = max(longest, first[w] - begin[w])
            s[X1 + i:M:LANES] = start.states[w]
            s[M + i:T:LANES] = start.memory[w]
        for k in range(longest + length + 1):
            for i in range(LANES):
                w = min(group + i, last)
                at = begin[w] + k
                if i < taken and at == carry_at[w]:
                    result.carry[w] = s[X1 + i:T:LANES]
                s[T + i] = at * dt
                at = min(extra_at[w] + k, len(extra) - 1)
                s[ON_MOTOR + i:Y1:LANES] = extra[at]
            if k == longest + length:
                break
            for i in range(taken):
                path[i, k] = s[X1 + i:M:LANES]
            for part in range(n):
                for i in range(LANES):
                    s[U + i] = u[min(begin[min(group + i, last)] + k, len(u) - 1), part]
                step_lanes(s, h, taken, by_term, drive)
        for w in range(group, group + taken):
            rows, lead = path[w - group], first[w] - begin[w]
            for k in range(length):
                result.y[w, k, 0] = reading(rows, lead + k, 0, dt, drive.e)
                result.y[w, k, 1] = reading(rows, lead + k, 1, dt, drive.e)


@cache
def runs_with_plugin(added: Torques) -> Any:
    """Return `runs` around a plug-in, the torques of its Effect `added`."""
    return rebuilt(runs, step_lanes=steps_with_plugin(added))
