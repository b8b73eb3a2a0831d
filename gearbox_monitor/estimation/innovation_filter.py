# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Kernels of the grey-box likelihood: an EKF of the whole drive, and what its innovations depend on.

The state is that of a simulation: positions and speeds, and the memories of the transmission and
of effects. Steps are those of plant.batch, composed of the same equations: in LANES, beside the
estimate, runs one copy of it for each state, a little moved: their differences are the tangent of
the step. Up to GROUPS parts of a recording are filtered at once, side by side. An encoder that
reads late is taken into account at the time of which it reads: steps end there.

White torque on motor and arm is the process noise (Kristensen, Madsen and Jorgensen, 2004). On
real drives, torque on the motor that lasts is a state, an Ornstein-Uhlenbeck process.
Sensitivities keep the gains of the filter, as in Bohn's adaptive EKF; by them a moved parameter
needs steps from the estimates alone, which do not wait for each other.
"""
from functools import cache
import math
from typing import Any, NamedTuple

from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import (
    Array, Block, Cube, IntegerMatrix, Integers, Matrix, Vector)
from gearbox_monitor.plant.batch import (
    IN_GEARBOX, LANES, ON_ARM, ON_MOTOR, step_lanes, steps_by_term, steps_with_plugin, T, U)
from gearbox_monitor.plant.drive import INVERSE_M1, INVERSE_M2, KIND
from gearbox_monitor.plant.effects.composition import arm_error, DELAY1, DELAY2, motor_error
from gearbox_monitor.plant.effects.effect import Torques
from gearbox_monitor.plant.simulate import N_STATE, PackedDrive, rebuilt
from gearbox_monitor.plant.transmission import RIGID

# Parts of a recording that are filtered side by side where the lanes suffice: each needs one for
# the estimate, and a moved one for each state.
GROUPS = 2
FARTHEST = 1e6               # rad, beyond which a filter has diverged
NO_ERROR = (0.0, 0.0, 0.0)
LASTING = N_STATE            # place of the torque on the motor that lasts
COLOURED = N_STATE + 1       # places of the coloured noise of the encoders
N_FILTER = N_STATE + 3       # state of a simulation, that torque and that noise
WHITE = 1e-3                 # variance of white noise beside coloured noise, over that


class SampleSchedule(NamedTuple):
    """
    Integration steps and readings within one sample, the same in all samples.

    Q steps: length [Q] s; part [Q] of the sample whose torque acts; ends [Q]: number of the
    segment that ends with the step, or -1. M segments: span [M] s; reads [M, 2]: 1 where an
    encoder is read at the end. shift [2]: samples by which a reading comes later than the first
    sample after the time of which it reads.
    """

    length: Vector
    part: Integers
    ends: Integers
    span: Vector
    reads: IntegerMatrix
    shift: Integers


class FilterInput(NamedTuple):
    """
    Input of a filter.

    y [N, 2] readings, rad; u [N, n] torque of the actuator in parts of a sample, N m; extra [N, 3]
    torque from outside on motor (0), arm and in the transmission, N m; dt s; begin, end [C] of the
    parts that are filtered; variance [2] of the encoders, rad^2; torque [2]: standard deviation
    of white torque on motor and arm in a sample, N m; fade: of a torque on the motor that lasts,
    in a sample: then torque [0] is that of it, and 0 where the noise is white; every: samples of
    which one is read.
    """

    y: Matrix
    u: Matrix
    extra: Matrix
    dt: float
    begin: Integers
    end: Integers
    variance: Vector
    torque: Vector
    fade: float
    every: int
    colour: Matrix  # [2, 2]: correlation of neighbouring readings, and variance over `variance`


class FilterStart(NamedTuple):
    """
    Start of the filters, with A estimated states.

    states [C, N_FILTER]; places [A] of what is estimated in them; covariance [A, A]; moves [A]: by
    how much states are moved for the tangent.
    """

    states: Matrix
    places: Integers
    covariance: Matrix
    moves: Vector


class FilterTrace(NamedTuple):
    """
    Record of a filter run, one row for the step from sample k to k + 1.

    begin [N, M, N_FILTER] and end [N, M, A]: states at the begin of each segment, and predicted at
    its end; tangent [N, M, A, A]; covariance [N, A, A] at the begin of the step. At each reading
    of the encoders: innovation [N, 2] rad, variance [N, 2] of it, gain [N, 2, A], slope [N, 2] of
    the reading over the position, position [N, 2] rad and speed [N, 2] rad/s. Where nothing is
    read, the innovation, gain and slope are 0 and the variance 1.
    """

    begin: Cube
    end: Cube
    tangent: Block
    covariance: Cube
    innovation: Matrix
    variance: Matrix
    gain: Cube
    slope: Matrix
    position: Matrix
    speed: Matrix


@inline
def _error(channel: int, e: Array, x: float) -> tuple[float, float, float]:
    return motor_error(NO_ERROR, e, x) if channel == 0 else arm_error(NO_ERROR, e, x)


@inline
def _noise_of(side: int, F: Array, torque: Array, p: Array) -> float:
    """Return the speed (rad/s) that torque noise gives to a side in 1 s, F [A, A] the tangent."""
    inverse, slope = p[INVERSE_M1] if side == 0 else p[INVERSE_M2], F[2 + side, 2 + side]
    size = torque[side]
    if int(p[KIND]) == RIGID:  # one inertia: the noise on the motor moves it
        inverse = p[INVERSE_M1] * p[INVERSE_M2] / (p[INVERSE_M1] + p[INVERSE_M2])
        slope, size = F[2, 2] + F[2, 3], torque[0]
    # Friction damps what the torque has moved: on average over half of the segment.
    return size * inverse * 0.5 * (1.0 + slope)


@inline
def _predict(F: Array, P: Array, product: Array, span: float, data: FilterInput,
             drive: PackedDrive, places: Integers) -> None:
    """Replace P [A, A] by F P F' + Q after a segment of `span` s."""
    n = F.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += F[i, k] * P[k, j]
            product[i, j] = total
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += product[i, k] * F[j, k]
            P[i, j] = total
            P[j, i] = total
    rigid, first = int(drive.p[KIND]) == RIGID, 0
    if data.fade > 0.0:
        P[4, 4] += data.torque[0] * data.torque[0] * (
            1.0 - math.pow(data.fade, 2.0 * span / data.dt))
        first = 2 if rigid else 1
    for i in range(n):
        if places[i] >= COLOURED:
            k = places[i] - COLOURED
            P[i, i] += data.variance[k] * data.colour[k, 1] * (
                1.0 - math.pow(data.colour[k, 0], 2.0 * span / data.dt))
    for i in range(first, 2):
        for j in range(first, 2):
            if i == j or rigid:
                v = (_noise_of(i, F, data.torque, drive.p) * _noise_of(j, F, data.torque, drive.p)
                     * data.dt * span)
                P[2 + i, 2 + j] += v
                P[i, 2 + j] += 0.5 * v * span
                P[2 + i, j] += 0.5 * v * span
                P[i, j] += v * span * span / 3.0


@inline
def _own(places: Integers, channel: int) -> int:
    """Return which of the estimated states is the coloured noise of an encoder, or -1."""
    for i in range(len(places)):
        if places[i] == COLOURED + channel:
            return i
    return -1


@inline
def _correct(P: Array, channel: int, slope: float, variance: float, gain: Array,
             own: int) -> float:
    """Fill in gain [A] of a reading and take it into P [A, A]; return its variance."""
    n = P.shape[0]
    s = variance + slope * slope * P[channel, channel]
    if own >= 0:
        s = variance * WHITE + slope * slope * P[channel, channel] + (
            2.0 * slope * P[channel, own] + P[own, own])
    for i in range(n):
        gain[i] = P[i, channel] * slope / s
        if own >= 0:
            gain[i] += P[i, own] / s
    for i in range(n):
        for j in range(i + 1):
            P[i, j] -= gain[i] * gain[j] * s
            P[j, i] = P[i, j]
    return s


@entry
def filtered(drive: PackedDrive, schedule: SampleSchedule, data: FilterInput, start: FilterStart,
             s: Vector, room: Cube, trace: FilterTrace) -> float:
    """
    Filter a recording.

    Args:
        drive: PackedDrive.
        schedule: SampleSchedule of its encoders.
        data: FilterInput.
        start: FilterStart.
        s: workspace [N_LANE_STATE].
        room: workspace [G + 1, A + 1, N_FILTER] for G groups: rows of the covariance, and the
            state.
        trace: is filled in.

    Returns:
        -2 log L, less what it is for white readings as they are expected; infinite where the
        filter diverges.
    """
    e = drive.e
    places, moves = start.places, start.moves
    n, last, groups = len(places), len(data.begin) - 1, len(room) - 1
    width = n + 1
    by_term = steps_by_term(drive)
    result = 0.0
    product = room[groups, :n, :n]
    for pair in range(0, last + 1, groups):
        steps = 0
        for g in range(groups):
            c = min(pair + g, last)
            steps = max(steps, data.end[c] - data.begin[c] - 1)
            room[g, n], room[g, :n, :n] = start.states[c], start.covariance
        for k in range(steps + 1):
            for g in range(groups):
                c = min(pair + g, last)
                at = min(data.begin[c] + k, data.end[c] - 1)
                if data.begin[c] + k < data.end[c] and pair + g <= last:
                    trace.begin[at, 0], trace.covariance[at] = room[g, n], room[g, :n, :n]
                on_arm, in_gearbox = data.extra[at, 1], data.extra[at, 2]
                for i in range(width * g, width * (g + 1)):
                    s[T + i], s[ON_ARM + i], s[IN_GEARBOX + i] = at * data.dt, on_arm, in_gearbox
                _spread(g, room, start, s)
            if k == steps:
                break
            for q in range(len(schedule.length)):
                for g in range(groups):
                    c = min(pair + g, last)
                    at = min(data.begin[c] + k, data.end[c] - 1)
                    u = data.u[at, schedule.part[q]]
                    for i in range(width * g, width * (g + 1)):
                        s[U + i] = u
                step_lanes(s, schedule.length[q], width * groups, by_term, drive)
                m = schedule.ends[q]
                if m < 0:
                    continue
                for g in range(groups):
                    c = min(pair + g, last)
                    at = data.begin[c] + k
                    if at >= data.end[c] - 1 or pair + g > last:
                        continue
                    base = width * g
                    F = trace.tangent[at, m]
                    for i in range(n):
                        if places[i] >= LASTING:
                            fade = data.fade if places[i] == LASTING else (
                                data.colour[places[i] - COLOURED, 0])
                            fade = math.pow(fade, schedule.span[m] / data.dt)
                            for j in range(n):
                                F[i, j] = fade if i == j else 0.0
                            room[g, n, places[i]] *= fade
                            trace.end[at, m, i] = room[g, n, places[i]]
                            continue
                        row = LANES * places[i] + base
                        for j in range(n):
                            F[i, j] = (s[row + 1 + j] - s[row]) / moves[j]
                        trace.end[at, m, i] = s[row]
                    for i in range(N_STATE):
                        room[g, n, i] = s[LANES * i + base]
                    if not abs(s[base]) < FARTHEST or not abs(s[LANES + base]) < FARTHEST:
                        return math.inf
                    _predict(F, room[g, :n, :n], product, schedule.span[m], data, drive, places)
                    for channel in range(2):
                        reading = at + 1 + schedule.shift[channel]
                        if (schedule.reads[m, channel] == 0 or reading >= data.end[c]
                                or reading % data.every != 0):
                            continue
                        x = room[g, n, channel]
                        error, slope, _ = _error(channel, e, x)
                        slope += 1.0
                        trace.position[at, channel] = x
                        trace.speed[at, channel] = room[g, n, 2 + channel]
                        trace.slope[at, channel] = slope
                        gain = trace.gain[at, channel]
                        own = _own(places, channel)
                        variance = _correct(room[g, :n, :n], channel, slope,
                                            data.variance[channel], gain, own)
                        innovation = data.y[reading, channel] - x - error
                        if own >= 0:
                            innovation -= room[g, n, COLOURED + channel]
                        for i in range(n):
                            room[g, n, places[i]] += gain[i] * innovation
                        trace.innovation[at, channel] = innovation
                        trace.variance[at, channel] = variance
                        result += (innovation * innovation / variance - 1.0
                                   + math.log(variance / data.variance[channel]))
                    if m < len(schedule.span) - 1:
                        trace.begin[at, m + 1] = room[g, n]
                        _spread(g, room, start, s)
    return result if math.isfinite(result) else math.inf


@inline
def _spread(g: int, room: Array, start: FilterStart, s: Array) -> None:
    """Put the state of the group `g` into its lanes, one of them moved for each state."""
    n = len(start.places)
    base = (n + 1) * g
    for i in range(LASTING + 1):
        row, value = (ON_MOTOR if i == LASTING else LANES * i) + base, room[g, n, i]
        for j in range(n + 1):
            s[row + j] = value
    for j in range(n):
        i = start.places[j]
        if i <= LASTING:
            s[(ON_MOTOR if i == LASTING else LANES * i) + base + 1 + j] += start.moves[j]


@entry
def sensitivity(drives: tuple[PackedDrive, PackedDrive], schedule: SampleSchedule,
                data: FilterInput, places: Integers, s: Vector, trace: FilterTrace, ends: Cube,
                change: Matrix) -> None:
    """
    Find how a small change of the drive changes the innovations while the gains stay.

    Args:
        drives: the drive that was filtered, and the changed one.
        schedule: of the first.
        data: FilterInput, with the torque of the actuator of the changed drive.
        places: of the states that are estimated [A].
        s: workspace [N_LANE_STATE].
        trace: FilterTrace of the first drive.
        ends: workspace [N, M, A].
        change: is filled in [N, 2], rad.
    """
    drive = drives[1]
    n = len(places)
    by_term = steps_by_term(drive)
    for c in range(len(data.begin)):
        for first in range(data.begin[c], data.end[c] - 1, LANES):
            elapsed, m = 0.0, -1
            for q in range(len(schedule.length)):
                if q == 0 or schedule.ends[q - 1] >= 0:
                    m += 1
                    for i in range(LANES):
                        at = min(first + i, data.end[c] - 2)
                        for j in range(N_STATE):
                            s[LANES * j + i] = trace.begin[at, m, j]
                        s[T + i] = at * data.dt + elapsed
                        for j in range(3):
                            s[ON_MOTOR + LANES * j + i] = data.extra[at, j]
                        s[ON_MOTOR + i] = trace.begin[at, m, LASTING]
                for i in range(LANES):
                    s[U + i] = data.u[min(first + i, data.end[c] - 2), schedule.part[q]]
                step_lanes(s, schedule.length[q], min(LANES, data.end[c] - 1 - first), by_term,
                           drive)
                elapsed += schedule.length[q]
                if schedule.ends[q] >= 0:
                    for i in range(min(LANES, data.end[c] - 1 - first)):
                        for j in range(n):
                            ends[first + i, m, j] = 0.0 if places[j] >= LASTING else (
                                s[LANES * places[j] + i] - trace.end[first + i, m, j])
    _along(drives, schedule, data, places, trace, ends, s[:2 * n], change)


@inline
def _carry(F: Array, d: Array, moved: Array) -> None:
    """Replace d [A] by moved + F d; moved [A] is overwritten."""
    n = F.shape[0]
    for i in range(n):
        for j in range(n):
            moved[i] += F[i, j] * d[j]
    d[:] = moved


@kernel
def _along(drives: tuple[PackedDrive, PackedDrive], schedule: SampleSchedule, data: FilterInput,
           places: Integers, trace: FilterTrace, ends: Array, room: Array, change: Array) -> None:
    """Fill in change [N, 2] of the innovations by changes `ends` [N, M, A] of each segment."""
    n = ends.shape[2]
    d, moved = room[:n], room[n:]
    delays = (drives[1].e[DELAY1] - drives[0].e[DELAY1],
              drives[1].e[DELAY2] - drives[0].e[DELAY2])
    for c in range(len(data.begin)):
        d[:] = 0.0
        for at in range(data.begin[c], data.end[c] - 1):
            for m in range(len(schedule.span)):
                moved[:] = ends[at, m]
                _carry(trace.tangent[at, m], d, moved)
                for channel in range(2):
                    if schedule.reads[m, channel] == 0:
                        continue
                    slope = trace.slope[at, channel]
                    if slope == 0.0:
                        continue
                    x = trace.position[at, channel]
                    reading = (_error(channel, drives[1].e, x)[0]
                               - _error(channel, drives[0].e, x)[0]
                               + slope * (d[channel] - delays[channel] * trace.speed[at, channel]))
                    own = _own(places, channel)
                    if own >= 0:
                        reading += d[own]
                    change[at, channel] = -reading
                    for i in range(n):
                        d[i] -= trace.gain[at, channel, i] * reading


@entry
def with_noise(drive: PackedDrive, schedule: SampleSchedule, data: FilterInput, start: FilterStart,
               trace: FilterTrace, room: Matrix, change: Matrix, variance: Matrix) -> float:
    """
    Find innovations under other noise, to first order: by the tangents of a filter that was run.

    Args:
        drive: PackedDrive that was filtered.
        schedule: its SampleSchedule.
        data: FilterInput with the other noise.
        start: FilterStart.
        trace: FilterTrace of the run.
        room: workspace [2 A + 3, A].
        change: of the innovations, is filled in [N, 2], rad.
        variance: of the innovations, is filled in [N, 2], rad^2.

    Returns:
        -2 log L as filtered() counts it.
    """
    n = len(start.places)
    P, product = room[:n], room[n:2 * n]
    d, moved, gain = room[2 * n], room[2 * n + 1], room[2 * n + 2]
    result = 0.0
    for c in range(len(data.begin)):
        d[:] = 0.0
        P[:] = start.covariance
        for at in range(data.begin[c], data.end[c] - 1):
            for m in range(len(schedule.span)):
                F = trace.tangent[at, m]
                moved[:] = 0.0
                _carry(F, d, moved)
                _predict(F, P, product, schedule.span[m], data, drive, start.places)
                for channel in range(2):
                    if schedule.reads[m, channel] == 0:
                        continue
                    slope = trace.slope[at, channel]
                    if slope == 0.0:
                        continue
                    own = _own(start.places, channel)
                    v = _correct(P, channel, slope, data.variance[channel], gain, own)
                    old = trace.innovation[at, channel]
                    new = old - slope * d[channel]
                    if own >= 0:
                        new -= d[own]
                    for i in range(n):
                        d[i] += gain[i] * new - trace.gain[at, channel, i] * old
                    change[at, channel], variance[at, channel] = new - old, v
                    result += new * new / v - 1.0 + math.log(v / data.variance[channel])
    return result if math.isfinite(result) else math.inf


@entry
def smoothed(schedule: SampleSchedule, data: FilterInput, places: Integers, trace: FilterTrace,
             room: Vector, states: Matrix) -> None:
    """
    Smooth the states of a filter run by the adjoint recursion of Bryson and Frazier (1963).

    Args:
        schedule: SampleSchedule of the run.
        data: its FilterInput.
        places: of the states that were estimated [A].
        trace: its FilterTrace.
        room: workspace [2 A].
        states: smoothed states [N, N_FILTER], filled in within the parts that were filtered.
    """
    n = len(places)
    adjoint, moved = room[:n], room[n:2 * n]
    for c in range(len(data.begin)):
        adjoint[:] = 0.0
        for at in range(data.end[c] - 1, data.begin[c] - 1, -1):
            if at < data.end[c] - 1:
                for m in range(len(schedule.span) - 1, -1, -1):
                    for channel in range(1, -1, -1):
                        slope = trace.slope[at, channel]
                        if schedule.reads[m, channel] == 0 or slope == 0.0:
                            continue
                        total = trace.innovation[at, channel] / trace.variance[at, channel]
                        for i in range(n):
                            total -= trace.gain[at, channel, i] * adjoint[i]
                        adjoint[channel] += slope * total
                        own = _own(places, channel)
                        if own >= 0:
                            adjoint[own] += total
                    for j in range(n):
                        total = 0.0
                        for i in range(n):
                            total += trace.tangent[at, m, i, j] * adjoint[i]
                        moved[j] = total
                    adjoint[:] = moved
            states[at] = trace.begin[at, 0]
            for i in range(n):
                for j in range(n):
                    states[at, places[i]] += trace.covariance[at, i, j] * adjoint[j]


@cache
def with_plugin(added: Torques) -> tuple[Any, Any]:
    """Return `filtered` and `sensitivity` around a plug-in, the torques of its Effect `added`."""
    steps = steps_with_plugin(added)
    return rebuilt(filtered, step_lanes=steps), rebuilt(sensitivity, step_lanes=steps)
