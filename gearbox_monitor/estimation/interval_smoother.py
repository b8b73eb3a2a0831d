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
Fixed-interval smoothing of a whole recording (Rauch-Tung-Striebel), in bounded memory.

A first pass of the Monitor decides what becomes of each sample. A second one steps the same filter
through each stretch without a restart and keeps its belief every BLOCK steps. Then the blocks are
stepped once more, last block first, this time keeping the step records, and smoothed backwards.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.filter_registry import FILTERS
from gearbox_monitor.estimation.process_model import markers, pack, state_names, TAU_K_MODEL_STD
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, smooth
from gearbox_monitor.estimation.step_record import record_size, updated
from gearbox_monitor.monitoring.monitor import Monitor, SECOND, SMOOTHED_OF_ARM
from gearbox_monitor.parameters import resolve

BLOCK = 8192


@dataclass(frozen=True)
class Smoothed:
    """L smoothed samples: stamp_ns int64 [L], rows [L, N_SMOOTHED] (columns smoother.S_*)."""

    stamp_ns: np.ndarray
    rows: np.ndarray


def smooth_interval(model, parameters, samples):
    """
    Return the Smoothed values of `samples` under the DriveModel `model` and `parameters`.

    What a Monitor accepts is smoothed, the sample of each (re)start included; nothing is smoothed
    across a restart. `parameters` apply as they are, see smoother.smoother_parameters.
    """
    model, parameters = resolve(model, parameters)
    monitor = Monitor(model, parameters.replace(smoother_lag=0.0))
    estimates = monitor.run(samples)
    pass_ = _Pass(monitor.drive, monitor.parameters)
    accepted = np.flatnonzero(np.isin(estimates.codes, (sample_loop.START, sample_loop.ESTIMATE)))
    given = (np.asarray(samples.stamp_ns, np.int64)[accepted],
             np.asarray(samples.u, float)[accepted], np.asarray(samples.y, float)[accepted])
    rows = np.empty((len(accepted), N_SMOOTHED))
    starts = np.flatnonzero(estimates.codes[accepted] == sample_loop.START)
    for begin, end in zip(starts, np.append(starts[1:], len(accepted))):
        rows[begin:end] = pass_.smooth([a[begin:end] for a in given])
    if not monitor.parameters.arm_joint:
        rows[:, SMOOTHED_OF_ARM] = np.nan
    return Smoothed(given[0], rows)


class _Pass:
    """Filter and smooth stretches without restart; the steps are those of the Monitor's stream."""

    def __init__(self, drive, parameters):
        p = parameters
        self.n, module = len(state_names(drive, p)), FILTERS[p.filter]
        self.packed, self.kind = pack(drive, p), sample_loop.KINDS[p.filter]
        self.states = markers(self.packed, self.n)
        self.settings = np.array([round(p.max_gap * SECOND), p.effort_delay, 0,
                                  drive.arm_load == 'measured'], np.int64)
        self.memory_size = module.memory_size(self.n)
        self.kept = np.zeros(self.n + self.n ** 2 + self.memory_size)
        self.vectors = np.zeros((module.N_VECTORS, self.n))
        self.matrices = np.zeros((max(module.N_MATRICES, 5), self.n ** 2))
        self.ring = np.zeros((BLOCK + 1, record_size(self.n)))
        self.ring_stamps = np.zeros(BLOCK + 1, np.int64)
        self.codes = np.zeros(BLOCK + 1, np.int64)
        self.estimates = np.zeros((BLOCK + 1, sample_loop.N_ESTIMATE))
        self.nothing = np.zeros(0, np.int64), np.zeros((0, N_SMOOTHED))

    def advance(self, state, given, begin, end):
        """Step `state` through the accepted samples begin .. end - 1, no more than the ring's."""
        gate, clock, efforts, z, P, memory = state
        counts = np.zeros(sample_loop.N_COUNTS, np.int64)
        while begin < end:
            taken, _ = sample_loop.run(
                self.states, *(a[begin:end] for a in given), *self.kind, self.packed,
                self.settings, gate, counts, clock, efforts, z, P, memory, self.kept, self.ring,
                self.ring_stamps, self.vectors, self.matrices, self.codes, self.estimates,
                *self.nothing)
            begin += taken
            gate[sample_loop.EVALUATE_AT] = gate[sample_loop.LAST] + SECOND

    def smooth(self, given):
        """Return rows [M, N_SMOOTHED] of M accepted samples, of which the first is a start."""
        n, m, size = self.n, len(given[0]), len(self.ring)
        state = (np.zeros(sample_loop.N_GATE, np.int64), np.zeros(sample_loop.N_CLOCK),
                 np.zeros((sample_loop.N_EFFORTS, 2)), np.zeros(n), np.zeros(n * n),
                 np.zeros(self.memory_size))
        self.advance(state, given, 0, 1)
        kept, cuts = [], range(0, max(m - 1, 1), size - 1)
        for cut in cuts:
            u = self.ring[cut % size, -1]
            kept.append([a.copy() for a in state] + [u])
            self.advance(state, given, cut + 1, min(cut + size, m))
        rows, later = np.empty((m, N_SMOOTHED)), None
        for cut, (*state, u) in zip(reversed(cuts), reversed(kept)):
            last = min(cut + size, m) - 1
            z, P = updated(self.ring[cut % size], n)
            z[:], P.flat, self.ring[cut % size, -1] = *state[3:5], u
            self.advance(state, given, cut + 1, last + 1)
            if later:  # the seam belongs to both blocks, and the later one knows it smoothed
                z, P = updated(self.ring[last % size], n)
                z[:], P.flat = later
            z = np.empty(n)
            smooth(self.states, self.ring, last, cut, last, self.packed[TAU_K_MODEL_STD] ** 2, z,
                   self.matrices, rows[cut:last + 1])
            later = z, self.matrices[0].copy()
        return rows
