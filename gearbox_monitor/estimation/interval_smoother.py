# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fixed-interval smoothing of a whole recording (Rauch-Tung-Striebel), in bounded memory.

A first pass of the Estimator decides what becomes of each sample. A second one steps the same
filter through each stretch without a restart and keeps its belief every BLOCK steps. Then the
blocks are stepped once more, last block first, this time keeping the step records, and smoothed
backwards.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.estimation import model_bank, sample_loop
from gearbox_monitor.estimation.estimates import Samples, SMOOTHED_ARM_COLUMNS
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.filter_kind import Belief, filter_kind, sensitivities, updated
from gearbox_monitor.estimation.filter_setup import loop_arrays, settings_of
from gearbox_monitor.estimation.process_model import layout_of, pack, state_names
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, smooth, Span
from gearbox_monitor.estimation.sample_loop import LoopState, Output, part_of, run, Stream
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

BLOCK = 8192
_Carried = tuple[Belief, LoopState]


@dataclass(frozen=True)
class Smoothed:
    """L smoothed samples: stamp_ns int64 [L], rows [L, N_SMOOTHED] (columns rts_smoother.S_*)."""

    stamp_ns: Integers
    rows: Array


def smooth_interval(model: DriveModel, parameters: EstimatorParameters | Values,
                    samples: Samples) -> Smoothed:
    """
    Smooth a whole recording (Rauch-Tung-Striebel), but not across restarts of the filter.

    Args:
        model: of the drive.
        parameters: of the estimator, as they are.
        samples: the recording.

    Returns:
        The Smoothed values of each sample that an Estimator accepts, including those at which it
        starts.

    Raises:
        InputError: a parameter is unknown or out of range.

    """
    estimator = Estimator(model, unsmoothed(parameters))
    estimates = estimator.run(samples)
    accepted = np.flatnonzero(np.isin(estimates.codes, (sample_loop.START, sample_loop.ESTIMATE)))
    stream = Stream(np.asarray(samples.stamp_ns, np.int64)[accepted],
                    np.asarray(samples.u, float)[accepted],
                    np.asarray(samples.y, float)[accepted])
    started = estimates.codes[accepted] == sample_loop.START
    rows = _smoothed(estimator, stream, started)
    if estimator.members:
        weights = np.full((len(accepted), model_bank.M), 1.0 / model_bank.M)
        weights[~started, 1:] = np.column_stack(
            [estimates.elastic_weight, estimates.learned_weight])
        weights[:, 0] = 1.0 - weights[:, 1:].sum(axis=1)
        of_all = np.stack([rows, *(_smoothed(m, stream, started) for m in estimator.members)])
        for i, member in enumerate(estimator.members, 1):
            if not np.array_equal(member.counts, estimator.counts):  # it restarted elsewhere
                weights[:, i] = 0.0
        weights[:, 0] += 1.0 - weights.sum(axis=1)
        model_bank.mix_interval(weights, of_all, rows)
    if not estimator.parameters.arm_joint:
        rows[:, SMOOTHED_ARM_COLUMNS] = np.nan
    return Smoothed(stream.stamps, rows)


def _smoothed(estimator: Estimator, stream: Stream, started: Flags) -> Array:
    """Smooth accepted samples with one filter, between the starts of [L] samples: `started`."""
    pass_, starts = _Pass(estimator.drive, estimator.parameters), np.flatnonzero(started)
    rows = np.empty((len(started), N_SMOOTHED))
    for begin, end in zip(starts.tolist(), [*starts[1:].tolist(), len(started)]):
        rows[begin:end] = pass_.smooth(part_of(stream, begin, end))
    return rows


class _Pass:
    """Filter and smooth stretches without restart; the steps are those of the Estimator's."""

    def __init__(self, drive: DriveModel, parameters: EstimatorParameters) -> None:
        kind = filter_kind(parameters.filter)
        self.n = len(state_names(drive, parameters))
        self.packed = pack(drive, parameters)
        self.states, self.settings = layout_of(self.packed, self.n), settings_of(drive, parameters)
        self.start, self.scratch, self.state = loop_arrays(kind, self.n, BLOCK + 1, drive)
        self.output = Output(
            np.zeros(BLOCK + 1, np.int64), np.zeros((BLOCK + 1, sample_loop.N_ESTIMATE)),
            np.zeros(0, np.int64), np.zeros((0, N_SMOOTHED)))

    def advance(self, carried: _Carried, stream: Stream, begin: int, end: int) -> None:
        """
        Step the filter through a part of the stream, no longer than the ring.

        Args:
            carried: belief and state of the loop, changed.
            stream: accepted samples.
            begin: first sample of the part.
            end: one past its last sample.

        """
        belief, state = carried
        while begin < end:
            begin += run(self.states, self.settings, self.packed, part_of(stream, begin, end),
                         state, belief, self.scratch, self.output)[0]

    def smooth(self, stream: Stream) -> Array:
        """Return rows [M, N_SMOOTHED] of the M samples of `stream`; the first is a start."""
        n, m, ring = self.n, len(stream.stamps), self.state.ring
        size = len(ring)
        carried = self._copy((self.start, self.state))
        carried[1].gate[:] = 0
        carried[1].gate[sample_loop.STOP_AT] = sample_loop.NEVER
        self.advance(carried, stream, 0, 1)
        cuts, at_cuts = range(0, max(m - 1, 1), size - 1), []
        for cut in cuts:
            at_cuts.append((self._copy(carried), ring[cut % size, -1]))
            self.advance(carried, stream, cut + 1, min(cut + size, m))
        _, _, at_s, at_smoothed = sensitivities(n, ring.shape[1])
        rows, seam = np.empty((m, N_SMOOTHED)), None
        for cut, (carried, u) in zip(reversed(cuts), reversed(at_cuts)):
            last = min(cut + size, m) - 1
            z, P = updated(ring[cut % size], n)
            z[:], P[:], ring[cut % size, -1] = carried[0].z, carried[0].P.reshape(n, n), u
            ring[cut % size, at_s:at_smoothed] = carried[1].companions.s[:-1]
            self.advance(carried, stream, cut + 1, last + 1)
            if seam:  # it belongs to both blocks, and the later one has smoothed it
                z, P = updated(ring[last % size], n)
                z[:], P[:], ring[last % size, at_s:at_smoothed] = seam
            z = np.empty(n)
            smooth(self.states, ring, Span(last, cut, last), self.packed, z,
                   self.scratch.matrices, rows[cut:last + 1])
            seam = (z, self.scratch.matrices[0].reshape(n, n).copy(),
                    ring[cut % size, at_smoothed:-1].copy())
        return rows

    def _copy(self, carried: _Carried) -> _Carried:
        """Return a copy of what a stream carries; the ring and the scratch are shared."""
        belief, state = carried
        return Belief(*(a.copy() for a in belief)), state._replace(
            gate=state.gate.copy(), counts=state.counts.copy(), clock=state.clock.copy(),
            efforts=state.efforts.copy(),
            companions=state.companions._replace(s=state.companions.s.copy()))
