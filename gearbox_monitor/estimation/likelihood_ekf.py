# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The EKF that adds up slopes of its log-likelihood; not for users, see estimation.slopes."""
from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, Reading, Scratch
from gearbox_monitor.estimation.filters import aekf
from gearbox_monitor.estimation.filters.aekf import (
    IN_USE, INFORMATION, MAX_THETA, SAMPLES, SENSITIVITY, STARTED, THETA)
from gearbox_monitor.estimation.process_model import (
    ADAPT_AT, ADAPT_COUNT, N_PACKED, R1, R2, WALKS, X1, X2, X3, X4)
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.types import Array, Layout


@folded(*WALKS)
@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Array, scratch: Scratch,
         record: Array) -> bool:
    """
    Do as filters.ekf.step, and add up gradient and information in the memory.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    memory, vectors = belief.memory, scratch.vectors
    if memory[STARTED] == 0.0:
        memory[STARTED] = 1.0
        for i in range(N_PACKED):
            memory[IN_USE + i] = p[i]
    if memory[SAMPLES] == 0.0:
        memory[SAMPLES] = 1.0
        for i in range(int(p[ADAPT_COUNT])):
            if p[ADAPT_AT + i] == R1:
                _begin(belief, i, (X1, X3), p[R1], reading.dt)
            elif p[ADAPT_AT + i] == R2:
                _begin(belief, i, (X2, X4), p[R2], reading.dt)
    if not aekf.differentiate(layout, belief, reading, p, scratch, record):
        return False
    for i in range(int(p[ADAPT_COUNT])):
        memory[THETA + i] += aekf.gradient(vectors, i)
        for j in range(i + 1):
            memory[INFORMATION + i * (i + 1) // 2 + j] += aekf.information(vectors, i, j)
    return True


@inline
def _begin(belief: Belief, i: int, places: tuple[int, int], r: float, dt: float) -> None:
    """
    Write how a start answers to the noise of an encoder, see sample_loop.start and first_speed.

    Args:
        belief: before the first step of `dt` s.
        i: number of theta.
        places: of position and speed.
        r: variance of the encoder, rad^2.
        dt: s.

    """
    (z, P, memory), (x, v) = belief, places
    n = z.shape[0]
    of_P = r if P[x * n + x] == r else 0.0  # else not measured at the start
    memory[SENSITIVITY + MAX_THETA * n + (i * n + x) * n + x] = of_P
    memory[SENSITIVITY + i * n + v] = -z[v] * (of_P + r) / (
        P[v * n + v] * dt * dt + P[x * n + x] + r)


FILTER = FilterKind(step, aekf.N_VECTORS, aekf.N_MATRICES, aekf.memory_size, aekf.resume)
