# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Figures of a replay for people and machines."""
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.estimation.sample_loop import ESTIMATE, REASONS, stamp_codes, START
from gearbox_monitor.kernels.types import Flags, Integers
from gearbox_monitor.recordings.comparison import Comparison
from gearbox_monitor.recordings.player import EstimatePlayer, ReplayPart
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.stamp_matching import StampMatcher
from gearbox_monitor.recordings.topics import PLANT_TRANSMISSION_STATE, TRANSMISSION

BURN_IN = 1_000_000_000  # ns at the start that do not count


class ReplaySummary:
    """
    Takes the parts of a replay by `player`; `data` is complete after `finish`.

    Errors are root mean squares in N m against the true torque, if the bag holds it.
    """

    def __init__(self, player: EstimatePlayer) -> None:
        self._player = player
        self._truth = truth_of(player.reader, player.topic.rsplit('/', 1)[0],
                               player.input.transmission)
        self.topics = (self._truth.topic,) if self._truth else ()
        if self._truth:
            self._decode = player.reader.decoder(self._truth.topic, (self._truth.joint,))
        self._samples = self._estimates = 0
        self._duration, self._last = 0, 0  # ns, of all runs of the clock; last stamp taken
        self._burnt_in: int | None = None  # stamp from which on estimates count
        self._first_counted: int | None = None
        self._nis, self._nis_expected, self._counted = 0.0, 0.0, 0
        self._filtered, self._smoothed = StampMatcher(2, 1), StampMatcher(1, 1)
        # Of pairs: number, squared error, squared truth, how many within one deviation.
        self._sums, self._smoothed_sums = np.zeros(4), np.zeros(2)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        stamps, estimates = part.samples.stamp_ns, part.estimates
        self._samples += len(stamps)
        self._estimates += len(estimates.stamp_ns)
        self._add_duration(stamps)
        if self._burnt_in is None and len(estimates.stamp_ns):
            self._burnt_in = int(estimates.stamp_ns[0]) + BURN_IN
        settled = estimates.stamp_ns >= (self._burnt_in or 0)
        rows: slice | Flags = slice(None) if settled.all() else settled
        counted = estimates.stamp_ns[rows]
        if len(counted):
            self._nis += float(estimates.nis[rows].sum())
            self._nis_expected += float(estimates.dof[rows].sum())
            self._counted += len(counted)
            if self._first_counted is None:
                self._first_counted = int(counted[0])
        if self._truth:
            self._compare(part, self._truth.topic, estimates, counted, rows)

    def _add_duration(self, stamps: Integers) -> None:
        """Add the time between those of `stamps` (ns) that the estimator takes."""
        stamps = np.append(self._last, stamps)
        codes = stamp_codes(stamps, self._player.estimator.parameters.max_gap)
        stamps = stamps[(codes == ESTIMATE) | (codes == START)]
        step = np.diff(stamps)
        self._duration += int(step[step > 0].sum())  # at a step back the clock restarts
        self._last = int(stamps[-1]) if len(stamps) else 0

    def _compare(self, part: ReplayPart, topic: str, estimates: Estimates, counted: Integers,
                 rows: slice | Flags) -> None:
        states = self._decode(part.block.of(topic))
        reference = states.stamp_ns, states.effort
        self._filtered.put(part.end_ns, (counted, np.column_stack(
            [estimates.tau_k[rows], estimates.tau_k_std[rows]])), reference)
        _, ours, true = self._filtered.pairs()
        error = ours[:, 0] - true[:, 0]
        self._sums += (len(error), (error ** 2).sum(), (true ** 2).sum(),
                       (np.abs(error) <= ours[:, 1]).sum())
        settled = (estimates.smoothed_stamp_ns >= self._first_counted
                   if self._first_counted is not None
                   else np.zeros(len(estimates.smoothed_stamp_ns), bool))
        self._smoothed.put(part.end_ns, (estimates.smoothed_stamp_ns[settled],
                                         estimates.smoothed[settled, S_TAU_K][:, None]), reference)
        _, ours, true = self._smoothed.pairs()
        self._smoothed_sums += (len(ours), ((ours - true) ** 2).sum())
        for matcher in (self._filtered, self._smoothed):
            matcher.expired(part.end_ns)

    def finish(self) -> None:
        """Raise InputError if the topic of the true torque has no transmission."""
        if self._truth:
            self._player.reader.require_joints(self._truth.topic, (self._truth.joint,),
                                               self._decode.joints)

    def data(self, comparison: Comparison | None = None) -> dict[str, Any]:
        """Return {name: value}, with the figures of `comparison` if it is not None."""
        player, estimator = self._player, self._player.estimator
        span = self._duration * 1e-9
        counted = self._counted
        data = {
            'bag': str(player.reader.path), 'samples': self._samples,
            'estimates': self._estimates, 'duration_s': span,
            'rate_hz': (self._samples - 1) / span if span > 0 else 0.0,
            'filter': estimator.parameters.filter,
            'adapted': estimator.adapted(),
            'adaptation_guards': estimator.adaptation_guards(),
            'refused': {text: int(estimator.counts[code]) for code, text in REASONS.items()
                        if estimator.counts[code]},
            'nis': self._nis / counted if counted else None,
            'nis_expected': self._nis_expected / counted if counted else None,
            'gap_rad': [round(w.gap, 6) for w in player.monitor.windows] if player.monitor else [],
            'levels': {k: f.level.name for k, f in player.monitor.outcomes.items()}
            if player.monitor else {},
        }
        if self._truth and counted:
            n, error, true, covered = self._sums
            data['tau_k_rms'] = _rms(true, n)
            data['tau_k_error'] = _rms(error, n)
            data['coverage_1_sigma'] = covered / n if n else None
            data['tau_k_error_smoothed'] = _rms(self._smoothed_sums[1], self._smoothed_sums[0])
        if comparison:
            data['replay_identical'] = comparison.verdict
            data['comparison'] = asdict(comparison)
        data['notes'] = (player.notes + estimator.warnings + estimator.divergence_notes()
                         + ([player.reader.notice] if player.reader.notice else []))
        return data


class TorqueSource(NamedTuple):
    """Where a bag holds the true or reference torque: `joint` of `topic`."""

    topic: str
    joint: str


def truth_of(reader: BagReader, namespace: str, transmission: str) -> TorqueSource | None:
    """
    Return where the true or reference torque is, or None.

    A simulated plant publishes plant/transmission_state, an imported recording with a torque
    sensor reference/transmission_state.

    Args:
        reader: the bag.
        namespace: of the joint states.
        transmission: name in the estimates; a plant of several gearboxes has the same names.

    """
    for name in (PLANT_TRANSMISSION_STATE, 'reference/transmission_state'):
        topic = f'{namespace}/{name}'
        if reader.count(topic):
            _, _, _, raw = next(reader.messages([topic]))
            names = reader.decode(JOINT_STATE, raw).name
            return TorqueSource(topic, transmission if transmission in names else TRANSMISSION)
    return None


def _rms(squares: float, n: float) -> float | None:
    return float(np.sqrt(squares / n)) if n else None
