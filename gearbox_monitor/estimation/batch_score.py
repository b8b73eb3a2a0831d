# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The criterion of many candidates on one recording; EKFs that differ in Q and R run side by side.

Lanes process samples as sample_loop.run does, as long as it would refuse none and bridge no
dropout. A filter that diverges, or at which a position jumps, runs once more through
sample_loop.run, which restarts it.
"""
from collections.abc import Sequence
import math

import numpy as np

from gearbox_monitor.estimation import batch_ekf, sample_loop
from gearbox_monitor.estimation.batch_ekf import (
    BAD, begin, DETERMINANT, Drive, drive_of, ERROR_1, ERROR_2, LANES, N_ROWS, NIS, NOISE_1,
    NOISE_2, predict, S11, S22, update, Z)
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filters.ekf import LOG_TWO_PI
from gearbox_monitor.estimation.process_model import P0, pack, X1, X2, X3, X4
from gearbox_monitor.estimation.sample_loop import (
    first_speed, jumps, LoopSettings, Stream, usually)
from gearbox_monitor.estimation.score import run_score, settled
from gearbox_monitor.kernels.jit import COMPILED, jit
from gearbox_monitor.kernels.types import Array, States, Values
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

FEWEST = 3  # candidates from which on lanes are faster than one filter after the other
MAY_DIFFER = ('q_std_', 'r_std_')  # how names of parameters begin
# Rows of what lanes carry beside the filter.
USUAL_1, USUAL_2, SUM_NIS, SUM_LOG, PRODUCT, N_CARRIED = range(6)
MULTIPLIED = 4  # determinants, before their logarithm is taken: no vector unit has that
PATIENCE = 64   # steps after which it is looked whether any lane is still good


@jit
def _run(states: States, stream: Stream, delay: int, first: int, p: Array, drive: Drive, s: Array,
         c: Array) -> None:
    """
    Run LANES filters over N samples; c [N_CARRIED * LANES]: sums over samples from `first` on.

    stream, delay: as of sample_loop.run, without NaN; the others: see batch_ekf.
    """
    stamps, inputs, y = stream
    begin(states, p, y[0, 0], y[0, 1], s)
    c[:] = 0.0
    multiplied, last = 0, stamps.shape[0] - 1
    if last > 0:
        dt = (stamps[1] - stamps[0]) * 1e-9
        for i in range(LANES):
            s[LANES * (Z + X3) + i] = first_speed(
                y[1, 0] - y[0, 0], dt, p[i, P0 + X1] + s[LANES * NOISE_1 + i], p[i, P0 + X3])
            s[LANES * (Z + X4) + i] = first_speed(
                y[1, 1] - y[0, 1], dt, p[i, P0 + X2] + s[LANES * NOISE_2 + i], p[i, P0 + X4])
    for k in range(1, last + 1):
        acting = max(k - 1 - delay, 0)
        predict(states, (stamps[k] - stamps[k - 1]) * 1e-9, inputs[acting, 0], inputs[acting, 1],
                p[0], drive, s)
        update(states, y[k, 0], y[k, 1], s)
        for i in range(LANES):
            e1, e2 = s[LANES * ERROR_1 + i], s[LANES * ERROR_2 + i]
            usual1, usual2 = c[LANES * USUAL_1 + i], c[LANES * USUAL_2 + i]
            if (jumps(e1, s[LANES * S11 + i], usual1, s[LANES * NOISE_1 + i], k)
                    or jumps(e2, s[LANES * S22 + i], usual2, s[LANES * NOISE_2 + i], k)):
                s[LANES * BAD + i] = 1.0
            c[LANES * USUAL_1 + i] = usually(e1, usual1)
            c[LANES * USUAL_2 + i] = usually(e2, usual2)
        if k >= first:
            if multiplied == 0:
                for i in range(LANES):
                    c[LANES * PRODUCT + i] = 1.0
            for i in range(LANES):
                c[LANES * SUM_NIS + i] += s[LANES * NIS + i]
                c[LANES * PRODUCT + i] *= s[LANES * DETERMINANT + i]
            multiplied += 1
            if multiplied == MULTIPLIED or k == last:
                for i in range(LANES):
                    c[LANES * SUM_LOG + i] += math.log(c[LANES * PRODUCT + i])
                multiplied = 0
        if k % PATIENCE == 0:
            bad = 0.0
            for i in range(LANES):
                bad += s[LANES * BAD + i]
            if bad == LANES:
                break


def run(packed: Array, states: States, settings: LoopSettings, samples: Samples,
        first: int) -> Array:
    """
    Run EKFs that differ in Q and R only, side by side; suited says whether that is possible.

    Args:
        packed: process_model.pack of each [W, N_PACKED].
        states: process_model.markers.
        settings: of sample_loop.run.
        samples: the recording.
        first: number of the first sample that counts.

    Returns:
        Log-likelihoods [0] and sums of NIS [1] as [2, W]; NaN where a filter diverges or a
        position jumps.

    """
    stamps = np.ascontiguousarray(samples.stamp_ns, np.int64)
    inputs, y = np.array(samples.u, float, order='C'), np.ascontiguousarray(samples.y, float)
    if not settings.load_measured:
        inputs[:, 1] = 0.0
    drive, result = drive_of(packed[0]), np.empty((2, len(packed)))
    s, c = np.empty(N_ROWS * LANES), np.empty(N_CARRIED * LANES)
    for at in range(0, len(packed), LANES):
        chosen = np.minimum(np.arange(at, at + LANES), len(packed) - 1)
        _run(states, Stream(stamps, inputs, y), settings.delay, first, packed[chosen], drive, s, c)
        carried, bad = c.reshape(-1, LANES), s[LANES * BAD:LANES * (BAD + 1)]
        loglik = (-0.5 * (carried[SUM_NIS] + carried[SUM_LOG])
                  - (len(stamps) - first) * LOG_TWO_PI)
        scores = np.where(bad == 0.0, [loglik, carried[SUM_NIS]], math.nan)
        result[:, at:at + LANES] = scores[:, :len(packed) - at]
    return result


def suited(candidates: Sequence[EstimatorParameters], packed: Array, settings: LoopSettings,
           samples: Samples) -> bool:
    """
    Return whether `run` gives the criteria of all candidates.

    Args:
        candidates: W sets of parameters.
        packed: as of run.
        settings: as of run.
        samples: as of run.

    Returns:
        False if one of them differs from the others in more than Q and R, is no EKF or needs an
        equation that lanes leave out; if sample_loop.run would refuse a sample or bridge a
        dropout; or if the candidates are too few to gain time.

    """
    steps = np.diff(samples.stamp_ns)
    readings = [samples.y, samples.u[:, :2 if settings.load_measured else 1]]
    values = [candidate.to_dict() for candidate in candidates]
    shared = {name: value for name, value in values[0].items()
              if not name.startswith(MAY_DIFFER)}
    return bool(
        COMPILED and len(candidates) >= FEWEST and shared['filter'] == 'ekf'
        and all(shared == {name: of_candidate[name] for name in shared} for of_candidate in values)
        and batch_ekf.suited(packed[0])
        and len(steps) and samples.stamp_ns[0] > 0
        and ((steps > 0) & (steps <= settings.max_gap)).all()
        and all((np.abs(columns) <= sample_loop.HUGE).all() for columns in readings)
        and settled(samples.stamp_ns[1:]).any())


def criteria(model: DriveModel, candidates: Sequence[EstimatorParameters | Values],
             samples: Samples) -> list[tuple[float, int]]:
    """
    Score many candidates on one recording, side by side where that is possible.

    Args:
        model: of the drive.
        candidates: parameters of the estimator.
        samples: the recording.

    Returns:
        (Score.criterion, how often the filter diverged) of each, as score.run_score gives them.

    """
    complete = [EstimatorParameters.of(values) for values in candidates]
    estimator = Estimator(model, complete[0])
    packed = np.array([pack(estimator.drive, values) for values in complete])
    loglik = np.full(len(complete), math.nan)
    if suited(complete, packed, estimator.settings, samples):
        first = 1 + int(np.argmax(settled(samples.stamp_ns[1:])))
        loglik, _ = run(packed, estimator.states, estimator.settings, samples, first)
    single = {i: run_score(model, complete[i], samples)
              for i in np.flatnonzero(~np.isfinite(loglik)).tolist()}
    return [(single[i].criterion, single[i].diverged) if i in single else (value, 0)
            for i, value in enumerate(loglik.tolist())]
