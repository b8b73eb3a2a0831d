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

"""What a replay has shown, in figures for people and machines."""
from dataclasses import asdict

import numpy as np

from gearbox_monitor.bag.stamp_matching import StampMatcher
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.estimation.sample_loop import REASONS

BURN_IN = 1_000_000_000  # ns at the start that do not count


class ReplaySummary:
    """
    Takes the parts of a replay.Player; `data` is complete after `finish`.

    Errors are root mean squares in N m against the truth in the bag, where there is one.
    """

    def __init__(self, player):
        self._player = player
        self._truth = truth_topic(player.reader, player.topic.rsplit('/', 1)[0])
        self.topics = (self._truth,) if self._truth else ()
        if self._truth:
            self._decode = player.reader.decoder(self._truth, ('transmission',))
        self._samples = self._estimates = 0
        self._span = []  # lowest and highest stamp
        self._after = None  # from here on estimates count
        self._first_counted = None
        self._nis = [0.0, 0, 0.0]  # sum, how many, sum of what is expected
        self._filtered, self._smoothed = StampMatcher(2, 1), StampMatcher(1, 1)
        # Of pairs: number, squared error, squared truth, how many within one deviation.
        self._sums, self._smoothed_sums = np.zeros(4), np.zeros(2)

    def add(self, part):
        """Take a ReplayPart."""
        stamps, estimates = part.samples.stamp_ns, part.estimates
        self._samples += len(stamps)
        self._estimates += len(estimates.stamp_ns)
        if len(stamps):
            self._span = [min([stamps.min(), *self._span[:1]]),
                          max([stamps.max(), *self._span[1:]])]
        if self._after is None and len(estimates.stamp_ns):
            self._after = estimates.stamp_ns[0] + BURN_IN
        after = estimates.stamp_ns >= (self._after or 0)
        chosen = slice(None) if after.all() else after
        counted = estimates.stamp_ns[chosen]
        if len(counted):
            self._nis[0] += float(estimates.nis[chosen].sum())
            self._nis[1] += len(counted)
            self._nis[2] += float(estimates.dof[chosen].sum())
            if self._first_counted is None:
                self._first_counted = counted[0]
        if self._truth:
            self._compare(part, estimates, counted, chosen)

    def _compare(self, part, estimates, counted, chosen):
        states = self._decode(part.block.of(self._truth))
        right = states.stamp_ns, states.effort
        self._filtered.put(part.now, (counted, np.column_stack(
            [estimates.tau_k[chosen], estimates.tau_k_std[chosen]])), right)
        _, ours, known = self._filtered.pairs()
        error = ours[:, 0] - known[:, 0]
        self._sums += (len(error), (error ** 2).sum(), (known ** 2).sum(),
                       (np.abs(error) <= ours[:, 1]).sum())
        late = (estimates.smoothed_stamp_ns >= self._first_counted
                if self._first_counted is not None
                else np.zeros(len(estimates.smoothed_stamp_ns), bool))
        self._smoothed.put(part.now, (estimates.smoothed_stamp_ns[late],
                                      estimates.smoothed[late, S_TAU_K][:, None]), right)
        _, ours, known = self._smoothed.pairs()
        self._smoothed_sums += (len(ours), ((ours - known) ** 2).sum())
        for pairing in (self._filtered, self._smoothed):
            pairing.expired(part.now)

    def finish(self):
        """Check that the truth was what it seemed."""
        if self._truth:
            self._player.reader.require_joints(self._truth, ('transmission',), self._decode.there)

    def data(self, comparison=None):
        """Return {name: value}; `comparison`: the Comparison, or None."""
        player, estimator = self._player, self._player.estimator
        span = float(self._span[1] - self._span[0]) * 1e-9 if self._span else 0.0
        total, counted, expected = self._nis
        data = {
            'bag': str(player.reader.path), 'samples': self._samples,
            'estimates': self._estimates, 'duration_s': span,
            'rate_hz': (self._samples - 1) / span if span > 0 else 0.0,
            'filter': estimator.parameters.filter,
            'adapted': estimator.adapted(),
            'adaptation_guards': estimator.adaptation_guards(),
            'refused': {text: int(estimator.counts[code]) for code, text in REASONS.items()
                        if estimator.counts[code]},
            'nis': total / counted if counted else None,
            'nis_expected': expected / counted if counted else None,
            'gap_rad': [round(w.gap, 6) for w in player.monitor.windows] if player.monitor else [],
            'levels': {k: f.level.name for k, f in player.monitor.findings.items()}
            if player.monitor else {},
        }
        if self._truth and counted:
            n, error, known, within = self._sums
            data['tau_k_rms'] = _rms(known, n)
            data['tau_k_error'] = _rms(error, n)
            data['coverage_1_sigma'] = within / n if n else None
            data['tau_k_error_smoothed'] = _rms(self._smoothed_sums[1], self._smoothed_sums[0])
        if comparison:
            data['replay_identical'] = comparison.verdict
            data['comparison'] = asdict(comparison)
        data['notes'] = (player.notes + estimator.warnings + estimator.divergence_notes()
                         + ([player.reader.notice] if player.reader.notice else []))
        return data


def truth_topic(reader, namespace):
    """
    Return the topic of the true or reference torque in the bag `reader`, or None.

    A simulated plant publishes plant/transmission_state, an imported recording with a torque
    sensor reference/transmission_state.
    """
    for name in ('plant/transmission_state', 'reference/transmission_state'):
        topic = f'{namespace}/{name}'
        if topic in reader.topics and reader.topics[topic][1]:
            return topic
    return None


def _rms(squares, n):
    return float(np.sqrt(squares / n)) if n else None
