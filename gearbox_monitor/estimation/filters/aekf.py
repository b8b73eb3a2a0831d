# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Adaptive extended Kalman filter: recursive prediction-error method with a sensitivity model.

Adapts theta, logarithms of the entries of p that process_model.SLOTS names, so that innovations
become as likely as can be (Ljung; Bohn and Unbehauen). Carried for each theta_i: s_i = d z / d
theta_i and P_i = d P / d theta_i. They come from differences: each theta_i has a second step of
the same EKF, from (z + D s_i, P + D P_i) with theta_i + D. By how much its belief, its innovation
e and the covariance S of that differ, divided by D, are the derivatives after the step.

    score     g_i = e_i' S^-1 e - e' S^-1 S_i S^-1 e / 2 + tr(S^-1 S_i) / 2
              M_ij: forgetting mean of e_i' S^-1 e_j + tr(S^-1 S_i S^-1 S_j) / 2
    adapt     theta <- theta - gain (M + gain R I)^-1 g,  gain <- gain / (gain + lambda)

A one-sided difference is the slope D / 2 further on, far less than theta is ever known to.

Forgetting counts samples with a measurement, not seconds. `gain R I` is the information of a prior
on each theta (R = RIDGE): where the motion says nothing, theta rests.
"""
import math

from gearbox_monitor.estimation.filter_kind import (
    Adaptation, Belief, FilterKind, places, Reading, record_size, Scratch)
from gearbox_monitor.estimation.filters import ekf
from gearbox_monitor.estimation.process_model import (
    ADAPT_AT, ADAPT_COUNT, ADAPT_FORGETTING, ADAPT_RATE, ADAPT_START, EIGENVALUE, K_P, N_MAX,
    N_PACKED, SLOTS)
from gearbox_monitor.kernels.kernel import apart, inline, kernel
from gearbox_monitor.kernels.types import Array, Layout, Vector
from gearbox_monitor.plant.drive import ALPHA, CC, CV, INVERSE_M1, INVERSE_M2
from gearbox_monitor.plant.transmission import TWO_OVER_PI

MAX_THETA = 6
D = 2.0 ** -24  # far above rounding, and so small that friction is linear over it
FIRST = 200  # samples before the first adaptation
STEP_LIMIT = 0.05  # of theta in one sample
RIDGE = 20.0  # a prior of 1 / sqrt(20) e-folds: tames the start, where all is wrong at once
NOISE_RANGE, MODEL_RANGE = math.log(1e6), math.log(30.0)  # of theta around its start
GROWN = math.exp(D)
S_LIMIT, P_LIMIT = 1e5, 1e7  # a sensitivity of a norm beyond them has run away

# Places in the memory: flags and counters, then theta [6], its start [6], M (lower triangle, by
# rows), the parameters in use [N_PACKED], s [6, n], P_i [6, n, n].
(STARTED, SAMPLES, GAIN, FORGETTING, RESETS, STEPS_LIMITED, AT_BOUND, NOT_SOLVED,
 THETA) = range(9)
START = THETA + MAX_THETA
INFORMATION = START + MAX_THETA
IN_USE = INFORMATION + MAX_THETA * (MAX_THETA + 1) // 2
SENSITIVITY = IN_USE + N_PACKED
GUARDS = {'sensitivity_resets': RESETS, 'limited_steps': STEPS_LIMITED,
          'steps_held_at_bound': AT_BOUND, 'unsolvable_steps': NOT_SOLVED}

# Rows of the scratch vectors: of each theta the whitened e_i and S_i, its gradient and its step;
# then the record of the step beside.
_SCORE, _GRADIENT, _BESIDE = 0, MAX_THETA, 2 * MAX_THETA
N_VECTORS = _BESIDE + 3 * N_MAX + 6


def memory_size(n: int) -> int:
    """Return how many numbers the filter carries besides z and P of `n` states."""
    return SENSITIVITY + MAX_THETA * (n + n * n)


def adapted(memory: Array, p: Array) -> dict[str, float]:
    """Return {name: value in use} of the adapted parameters in `memory`; p: process_model.pack."""
    names = {slot: name for name, slot in SLOTS.items()}
    result = {}
    for i in range(int(p[ADAPT_COUNT])):
        slot = int(p[ADAPT_AT + i])
        value = float(memory[IN_USE + slot] if memory[STARTED] else p[slot])
        result[names[slot]] = math.sqrt(value) if '_std_' in names[slot] else value
    return result


def guards(memory: Array) -> dict[str, int]:
    """Return {guard: how often it acted}, from the filter's `memory`."""
    return {name: int(memory[place]) for name, place in GUARDS.items()}


def at_bound(memory: Array, p: Array) -> list[str]:
    """Return the names of parameters at the bound of their range; memory, p: as of adapted."""
    return [name for i, name in enumerate(adapted(memory, p)) if memory[STARTED] and
            abs(memory[THETA + i] - memory[START + i]) >= 0.999 * _range(int(p[ADAPT_AT + i]))]


def in_use(memory: Array, p: Array) -> Array:
    """Return the packed parameters [N_PACKED] of the next step; memory, p: as of adapted."""
    return memory[IN_USE:IN_USE + N_PACKED].copy() if memory[STARTED] else p


@inline
def used(memory: Array, p: Array) -> Array:
    """Return in_use without a copy."""
    return p if memory[STARTED] == 0.0 else memory[IN_USE:IN_USE + N_PACKED]


@kernel
def resume(memory: Array) -> None:
    """Restart the filter with the parameters in `memory`."""
    memory[SAMPLES] = 0.0
    memory[SENSITIVITY:] = 0.0


@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
         record: Vector) -> bool:
    """
    Predict, update and adapt.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    if p[ADAPT_COUNT] == 0.0:
        return ekf.step(layout, belief, reading, p, scratch, record)
    if belief.memory[STARTED] == 0.0:
        begin(belief.memory, p)
    if not differentiate(layout, belief, reading, p, scratch, record):
        return False
    _adapt(layout, belief.memory, p, scratch.vectors, scratch.matrices, record)
    return True


@kernel
def _range(slot: int) -> float:
    """Return how far theta of that place in p may go from its start, either way."""
    return MODEL_RANGE if slot == CV or slot == CC or slot == K_P else NOISE_RANGE


@kernel
def begin(memory: Array, p: Array) -> None:
    """Set `memory`, all zero, to the parameters `p`; sensitivities start at zero."""
    memory[STARTED] = 1.0
    memory[GAIN], memory[FORGETTING] = 1.0, p[ADAPT_START]
    memory[IN_USE:IN_USE + N_PACKED] = p
    for i in range(int(p[ADAPT_COUNT])):
        memory[THETA + i] = math.log(p[int(p[ADAPT_AT + i])])
        memory[START + i] = memory[THETA + i]
        memory[INFORMATION + i * (i + 1) // 2 + i] = 1.0


@inline
def information(vectors: Array, i: int, j: int) -> float:
    """Return what the innovation of `differentiate` tells of theta `i` and `j` (Fisher)."""
    a, b = vectors[_SCORE + i], vectors[_SCORE + j]
    return a[0] * b[0] + a[1] * b[1] + 0.5 * (a[2] * b[2] + 2.0 * a[3] * b[3] + a[4] * b[4])


@apart
def differentiate(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
                  record: Vector) -> bool:
    """
    Predict and update belief and sensitivities with the theta in the memory.

    The arguments layout, belief, reading, p, scratch and record are as of step.

    Returns:
        False if the belief is unusable.

    """
    n, (z, P, memory), vectors, count = layout.n, belief, scratch.vectors, int(p[ADAPT_COUNT])
    current = memory[IN_USE:IN_USE + N_PACKED]
    current[EIGENVALUE] = _eigenvalue(current, p)
    s = memory[SENSITIVITY:SENSITIVITY + MAX_THETA * n].reshape(MAX_THETA, n)
    P_s = memory[SENSITIVITY + MAX_THETA * n:].reshape(MAX_THETA, n * n)
    beside = vectors.reshape(N_VECTORS * n)[_BESIDE * n:_BESIDE * n + record_size(n)]
    for i in range(count):
        _along(z, D, s[i])
        _along(P, D, P_s[i])
    if not ekf.step(layout, belief, reading, current, scratch, record):
        return False
    for i in range(count):
        slot = int(p[ADAPT_AT + i])
        value = current[slot]
        current[slot] = value * GROWN
        good = ekf.step(layout, Belief(s[i], P_s[i], memory), reading, current, scratch, beside)
        current[slot] = value
        good = good and _slope(z, s[i], S_LIMIT) and _slope(P, P_s[i], P_LIMIT)
        _score(n, record, beside, vectors[_SCORE + i], vectors[_GRADIENT + i])
        if not good:
            memory[RESETS] += 1.0
            s[i] = 0.0
            P_s[i] = 0.0
            vectors[_GRADIENT + i, 0] = 0.0
            vectors[_SCORE + i, :5] = 0.0
    return True


@inline
def _along(start: Array, step: float, slope: Array) -> None:
    """Replace `slope` by where it leads to from `start` in a `step`."""
    for a in range(len(slope)):
        slope[a] = start[a] + step * slope[a]


@inline
def _slope(start: Array, moved: Array, limit: float) -> bool:
    """Replace `moved` by its slope from `start`; return whether its norm is within `limit`."""
    total = 0.0
    for a in range(len(moved)):
        moved[a] = (moved[a] - start[a]) / D
        total += moved[a] * moved[a]
    return total <= limit * limit  # NaN is not


@inline
def _score(n: int, record: Array, beside: Array, score: Array, gradient: Array) -> None:
    """
    Write J e_i and J S_i J' to `score`, J' J = S^-1 over what was measured, and the gradient.

    Args:
        n: number of states.
        record: of the step.
        beside: of the step beside.
        score: [>= 5], written.
        gradient: its first number is written.

    """
    _, _, _, _, _, at_e, at_S, _, _ = places(n)
    e1, e2 = record[at_e], record[at_e + 1]
    have1, have2 = math.isfinite(e1), math.isfinite(e2)
    S11, S12, S22 = record[at_S], record[at_S + 1], record[at_S + 2]
    j11 = j21 = j22 = 0.0
    if have1 and have2:
        root, root_det = math.sqrt(S11), math.sqrt(S11 * S22 - S12 * S12)
        j11, j21, j22 = 1.0 / root, -S12 / (root * root_det), root / root_det
    elif have1:
        j11 = 1.0 / math.sqrt(S11)
    elif have2:
        j22 = 1.0 / math.sqrt(S22)
    e1, e2 = e1 if have1 else 0.0, e2 if have2 else 0.0
    d1 = (beside[at_e] - e1) / D if have1 else 0.0
    d2 = (beside[at_e + 1] - e2) / D if have2 else 0.0
    s11, s12, s22 = ((beside[at_S] - S11) / D, (beside[at_S + 1] - S12) / D,
                     (beside[at_S + 2] - S22) / D)
    white1, white2 = j11 * e1, j21 * e1 + j22 * e2
    f1, f2 = j11 * d1, j21 * d1 + j22 * d2
    t1, t2 = j21 * s11 + j22 * s12, j21 * s12 + j22 * s22
    v11, v12, v22 = j11 * j11 * s11, j11 * t1, j21 * t1 + j22 * t2
    score[0], score[1], score[2], score[3], score[4] = f1, f2, v11, v12, v22
    gradient[0] = f1 * white1 + f2 * white2 + 0.5 * (v11 + v22) - 0.5 * (
        white1 * white1 * v11 + 2.0 * white1 * white2 * v12 + white2 * white2 * v22)


@kernel
def _eigenvalue(current: Array, p: Array) -> float:
    """Return a bound on the fastest eigenvalue with the parameters in use."""
    slope = current[CV] - p[CV] + TWO_OVER_PI * p[ALPHA] * (current[CC] - p[CC])
    stiffer = max(current[K_P] - p[K_P], 0.0)
    return (p[EIGENVALUE] + max(slope, 0.0) * p[INVERSE_M1]
            + math.sqrt(stiffer * (p[INVERSE_M1] + p[INVERSE_M2])))


@inline
def _adapt(layout: Layout, memory: Array, p: Array, vectors: Array, matrices: Array,
           record: Array) -> None:
    """Move theta by one Gauss-Newton step on the likelihood of the present innovation."""
    _, _, _, _, _, _, _, _, at_scores = places(layout.n)
    if record[at_scores + 2] == 0.0:
        return  # nothing measured, nothing learnt
    count = int(p[ADAPT_COUNT])
    gain = memory[GAIN]
    for i in range(count):
        for j in range(i + 1):
            place = INFORMATION + i * (i + 1) // 2 + j
            memory[place] += gain * (information(vectors, i, j) - memory[place])
    gain = gain / (gain + memory[FORGETTING])
    memory[GAIN] = gain
    memory[FORGETTING] += (1.0 - p[ADAPT_RATE]) * (p[ADAPT_FORGETTING] - memory[FORGETTING])
    memory[SAMPLES] += 1.0
    if memory[SAMPLES] <= FIRST:
        return
    if not _solve(memory, count, gain * RIDGE, vectors, matrices[0]):
        memory[NOT_SOLVED] += 1.0
        return
    limited = clipped = False
    for i in range(count):
        change = -gain * vectors[_GRADIENT + i, 1]
        if abs(change) > STEP_LIMIT:
            change = STEP_LIMIT if change > 0.0 else -STEP_LIMIT
            limited = True
        slot = int(p[ADAPT_AT + i])
        width = _range(slot)
        theta = memory[THETA + i] + change
        if abs(theta - memory[START + i]) > width:
            theta = memory[START + i] + (width if theta > memory[START + i] else -width)
            clipped = True
        memory[THETA + i] = theta
        memory[IN_USE + slot] = math.exp(theta)
    memory[STEPS_LIMITED] += 1.0 if limited else 0.0
    memory[AT_BOUND] += 1.0 if clipped else 0.0


@inline
def _solve(memory: Array, count: int, ridge: float, vectors: Array, factor: Array) -> bool:
    """
    Solve (M + ridge I) x = g by L D L'; g stands in column 0 of the gradient rows, x goes to 1.

    factor [>= 21]: scratch, below the diagonal L D, on it 1 / D. False when the matrix is not
    positive definite or x is not finite.
    """
    for j in range(count):
        at_j = j * (j + 1) // 2
        for i in range(j, count):
            at_i = i * (i + 1) // 2
            total = memory[INFORMATION + at_i + j] + (ridge if i == j else 0.0)
            for k in range(j):
                total -= factor[at_i + k] * factor[at_j + k] * factor[k * (k + 1) // 2 + k]
            if i == j and not total > 0.0:
                return False
            factor[at_i + j] = 1.0 / total if i == j else total
    for i in range(count):
        total = vectors[_GRADIENT + i, 0]
        for k in range(i):
            total -= factor[i * (i + 1) // 2 + k] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] = total * factor[i * (i + 1) // 2 + i]
    for i in range(count - 1, -1, -1):
        total = 0.0
        for k in range(i + 1, count):
            total += factor[k * (k + 1) // 2 + i] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] -= total * factor[i * (i + 1) // 2 + i]
    for i in range(count):
        if not math.isfinite(vectors[_GRADIENT + i, 1]):
            return False
    return True


FILTER = FilterKind(step, N_VECTORS, 1, memory_size, resume, used, adaptation=Adaptation(
    adapted, in_use, at_bound, guards))
