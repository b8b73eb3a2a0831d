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
What the clock of the computer adds to the stamps: whether anything usable still comes.

A stream that has stopped has no stamps to judge it by. The node asks once per second.
"""
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.monitoring.checks import usability
from gearbox_monitor.monitoring.checks.level import Finding, Level

MIN_SILENCE = 0.5  # s between two looks; a late timer is followed by one that comes too soon


class Silence:
    """
    Watches one Monitor: its stamps must advance from one look to the next.

    why: what kept samples away at the last look, '' where they came.
    """

    def __init__(self):
        # Stamp, inputs, clock and counters at the last look that found new stamps.
        self._seen = (0, 0, 0, None)
        self.why = ''

    def findings(self, monitor, now_ns, foreign=0, told=None):
        """
        Return {component: Finding} at `now_ns` of a steady clock; a dead stream is never good.

        monitor: Monitor. foreign: messages that named none of our joints. told: (reason, advice)
        of who takes the messages, where it knows why none becomes a sample.
        """
        stamp, inputs, since, before = self._seen
        if monitor.stamp_ns != stamp or not since:
            self._seen = (monitor.stamp_ns, monitor.input_count, now_ns, monitor.counts.copy())
            self.why = ''
            return dict(monitor.findings)
        silent = (now_ns - since) / sample_loop.SECOND
        if silent < MIN_SILENCE:
            return dict(monitor.findings)
        refused = monitor.input_count - inputs
        counts = {usability.key_of(reason): int(monitor.counts[code])
                  for code, reason in sample_loop.REASONS.items() if monitor.counts[code]}
        counts['messages_without_our_joints'] = foreign
        reason, advice, self.why = 'no samples came', usability.SILENT.advice, 'silent'
        if told:
            (reason, advice), self.why = told, 'joints'
        elif refused:
            causes = usability.refused({text: int(monitor.counts[code] - before[code])
                                        for code, text in sample_loop.REASONS.items()})
            self.why = '; '.join(cause.advice for cause in causes)
            advice = self.why or advice
            reason = (f'{refused} samples came, none was usable'
                      + ''.join(f', {cause.says}' for cause in causes))
        findings = {name: Finding(Level.WARN, f'no data for {silent:.1f} s', {})
                    for name in monitor.findings}
        # Discovery takes a while: before the first sample ever, silence is not yet an error.
        starting = not monitor.input_count and not foreign and silent < usability.START_TIME
        findings['input'] = Finding(Level.WARN if starting else Level.ERROR,
                                    f'{reason} for {silent:.1f} s: {advice}', counts)
        return findings
