# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Age of the newest values of a monitor."""
from gearbox_monitor.estimation.sample_loop import REASONS, SECOND
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks import usability
from gearbox_monitor.health.checks.outcome import Level, Outcome
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Integers
from gearbox_monitor.presentation import Said


class Silence:
    """
    Watches one Monitor: its stamps must advance from one look to the next.

    why: codes of the reason why no usable sample arrived before the last look, '' if some did.
    """

    def __init__(self) -> None:
        # At the last look that found new stamps: stamp, inputs, clock, and counters.
        self._stamp = self._inputs = self._since = 0
        self._counts: Integers | None = None
        self.why = ''

    def outcomes(self, monitor: Monitor, now_ns: int, foreign: int = 0,
                 cause: Said | None = None) -> dict[str, Outcome]:
        """
        Return the outcomes of a monitor, replaced where its stream is dead.

        Args:
            monitor: the Monitor that takes the samples.
            now_ns: time of a steady clock, ns.
            foreign: number of messages that named none of our joints.
            cause: what the receiver of messages says, if it knows why none of them becomes a
                sample.

        Returns:
            {component: Outcome}; a dead stream is never OK.

        """
        if self._counts is None or monitor.stamp_ns != self._stamp:
            self._stamp, self._inputs, self._since = monitor.stamp_ns, monitor.input_count, now_ns
            self._counts, self.why = monitor.counts.copy(), ''
            return dict(monitor.outcomes)
        silent = (now_ns - self._since) / SECOND
        if silent < LIMITS.min_silence:
            return dict(monitor.outcomes)
        refused = monitor.input_count - self._inputs
        counts = {usability.key_of(reason): int(monitor.counts[code])
                  for code, reason in REASONS.items() if monitor.counts[code]}
        counts['messages_without_our_joints'] = foreign
        says = [cause or usability.SILENT.said()]
        if refused and not cause:
            new = monitor.counts - self._counts
            causes = usability.refused({text: int(new[code]) for code, text in REASONS.items()})
            says = [Said('unusable', {'count': refused}, Level.OK if causes else Level.ERROR),
                    *causes]
        self.why = ' '.join(said.code for said in says)
        outcomes = {name: Outcome.of(Level.WARN, 'no_data', {'lasts_s': silent})
                    for name in monitor.outcomes}
        # Discovery takes a while: before the first sample ever, silence is not yet an error.
        starting = not monitor.input_count and not foreign and silent < LIMITS.start_time
        outcomes['input'] = Outcome(Level.WARN if starting else Level.ERROR,
                                    (tuple(says),), {**counts, 'lasts_s': silent})
        return outcomes
