# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Replay a bag with everything in memory, and smooth it over the whole recording."""
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.interval_smoother import smooth_interval
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_TAU_K, smoother_parameters
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.comparison import Comparer, Comparison
from gearbox_monitor.recordings.player import EstimatePlayer, joined_estimates, Player, ReplayPart
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import joined_samples, NO_SAMPLES, RecordedSamples
from gearbox_monitor.recordings.replay_summary import BURN_IN, ReplaySummary, truth_of
from gearbox_monitor.recordings.stamp_matching import match_stamps


@dataclass(frozen=True)
class Replay:
    """
    All samples and estimates of a replay, and the Estimator and Monitor at its end.

    comparison: with the recorded estimates, or None. summary: {name: value}, see
    ReplaySummary.data, or None.
    """

    recording: RecordedSamples
    estimates: Estimates
    estimator: Estimator
    monitor: Monitor | None
    comparison: Comparison | None
    summary: dict[str, Any] | None


def replay(reader: BagReader, model: DriveModel | None = None,
           parameters: Mapping[str, Any] | None = None, topic: str = 'joint_states') -> Replay:
    """
    Run a bag through the estimator and compare with the recorded estimates where possible.

    Args:
        reader: the bag.
        model: replaces the recorded model.
        parameters: {name: value} that replace recorded or default parameters of the estimator.
        topic: see find_input.

    Returns:
        The Replay.

    Raises:
        InputError: the bag cannot be replayed.
    """
    player = Player(reader, model, parameters, topic)
    collector, summary = ReplayCollector(player), ReplaySummary(player)
    comparer = Comparer(player) if player.compared else None
    player.run([collector, summary, *([comparer] if comparer else [])])
    comparison = comparer.comparison if comparer else None
    return collector.replay(comparison, summary.data(comparison))


class ReplayCollector:
    """Takes the parts of `player` and keeps all samples and estimates."""

    topics = ()

    def __init__(self, player: EstimatePlayer) -> None:
        self._player = player
        self._samples, self._log_ns = [NO_SAMPLES], [np.empty(0, np.int64)]
        self._estimates: list[Estimates] = []

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        self._samples.append(part.samples)
        self._log_ns.append(part.log_ns)
        self._estimates.append(part.estimates)

    def finish(self) -> None:
        """Do nothing: all parts were added."""

    def replay(self, comparison: Comparison | None = None, summary: dict[str, Any] | None = None
               ) -> Replay:
        """Return the Replay with its `comparison` and `summary`."""
        player = self._player
        recording = RecordedSamples(joined_samples(self._samples), np.concatenate(self._log_ns),
                                    player.topic, player.input.transmission)
        estimates = joined_estimates(self._estimates or [player.estimator.run(NO_SAMPLES)])
        return Replay(recording, estimates, player.estimator, player.monitor, comparison, summary)


def truth(reader: BagReader, recording: RecordedSamples) -> tuple[Integers, Array] | None:
    """
    Return (stamp_ns, tau_k) of the true or reference torque beside `recording`, or None.

    `reader`: the bag; see replay_summary.truth_of.
    """
    source = truth_of(reader, recording.namespace, recording.transmission)
    if source is None:
        return None
    states = reader.joint_states(source.topic, (source.joint,))
    return states.stamp_ns, states.effort[:, 0]


def smoothed(result: Replay) -> Array:
    """
    Return rows [M, N_SMOOTHED] for the estimates of `result`, smoothed over the whole recording.

    Uses the last parameters in force, changed for a smoother. NaN where a run from the first
    sample, without snapshots, has no estimate.
    """
    interval = smooth_interval(
        result.estimator.model, smoother_parameters(result.estimator.parameters),
        result.recording.samples)
    rows = np.full((len(result.estimates.stamp_ns), N_SMOOTHED), np.nan)
    i, j = match_stamps(result.estimates.stamp_ns, interval.stamp_ns)
    rows[i] = interval.rows[j]
    return rows


def interval_error(reader: BagReader, result: Replay, rows: Array) -> float | None:
    """
    Return the rms error of the smoothed transmission torque.

    Args:
        reader: the bag.
        result: its Replay.
        rows: smoothed rows [M, N_SMOOTHED], see `smoothed`.

    Returns:
        The error in N m; None if the bag holds no true torque.
    """
    reference, stamps = truth(reader, result.recording), result.estimates.stamp_ns
    if reference is None or not len(stamps):
        return None
    counted = (stamps >= stamps[0] + BURN_IN) & np.isfinite(rows[:, S_TAU_K])
    i, j = match_stamps(stamps[counted], reference[0])
    if not len(i):
        return None
    return float(np.sqrt(np.mean((rows[counted, S_TAU_K][i] - reference[1][j]) ** 2)))
