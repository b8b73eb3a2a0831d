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
The criterion of many candidates on one recording; EKFs that differ in Q and R run side by side.

In lanes samples go as in sample_loop.run, as long as it would refuse none and hold nothing. A
filter that diverges, or at which a position jumps, runs once more through sample_loop.run, which
restarts it.
"""
import math

import numpy as np

from gearbox_monitor.estimation import batch_ekf, sample_loop
from gearbox_monitor.estimation.batch_ekf import (
    BAD, begin, DETERMINANT, Drive, drive_of, ERROR_1, ERROR_2, LANES, N_ROWS, NIS, NOISE_1,
    NOISE_2, predict, S11, S22, update)
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filters.ekf import LOG_TWO_PI
from gearbox_monitor.estimation.process_model import pack
from gearbox_monitor.estimation.sample_loop import jumps, Stream, usually
from gearbox_monitor.estimation.score import run_score, settled
from gearbox_monitor.kernels.jit import COMPILED, jit
from gearbox_monitor.kernels.types import Array, States
from gearbox_monitor.parameters import EstimatorParameters

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


def run(packed, states, settings, samples, first):
    """
    Return (log-likelihood, sum of NIS) [W] of EKFs over the Samples from number `first` on.

    packed: process_model.pack of each [W, N_PACKED]; states: process_model.markers; settings: of
    sample_loop.run.
    All as suited wants it. NaN where a filter diverges or a position jumps.
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
        found = np.where(bad == 0.0, [loglik, carried[SUM_NIS]], math.nan)
        result[:, at:at + LANES] = found[:, :len(packed) - at]
    return result


def suited(candidates, packed, settings, samples):
    """
    Return whether `run` gives what these candidates (EstimatorParameters) ask for on `samples`.

    packed, settings: see run.
    """
    ahead = np.diff(samples.stamp_ns)
    seen = [samples.y, samples.u[:, :2 if settings.load_measured else 1]]
    values = [candidate.to_dict() for candidate in candidates]
    shared = {name: value for name, value in values[0].items()
              if not name.startswith(MAY_DIFFER)}
    return bool(
        COMPILED and len(candidates) >= FEWEST and shared['filter'] == 'ekf'
        and all(shared == {name: of_candidate[name] for name in shared} for of_candidate in values)
        and batch_ekf.suited(packed[0])
        and len(ahead) and samples.stamp_ns[0] > 0
        and ((ahead > 0) & (ahead <= settings.max_gap)).all()
        and all((np.abs(values) <= sample_loop.HUGE).all() for values in seen)
        and settled(samples.stamp_ns[1:]).any())


def criteria(model, candidates, samples):
    """
    Return [(criterion, how often it diverged)] of score.run_score for each of `candidates`.

    model: DriveModel; candidates: EstimatorParameters or mappings; samples: Samples.
    """
    candidates = [EstimatorParameters.of(values) for values in candidates]
    one = Estimator(model, candidates[0])
    packed = np.array([pack(one.drive, values) for values in candidates])
    found = np.full(len(candidates), math.nan)
    if suited(candidates, packed, one.settings, samples):
        first = 1 + int(np.argmax(settled(samples.stamp_ns[1:])))
        found, _ = run(packed, one.states, one.settings, samples, first)
    alone = {i: run_score(model, candidates[i], samples)
             for i in np.flatnonzero(~np.isfinite(found)).tolist()}
    return [(alone[i].criterion, alone[i].diverged) if i in alone else (value, 0)
            for i, value in enumerate(found.tolist())]
