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
from gearbox_monitor import stream
from gearbox_monitor.trust.level import Finding, Level
from gearbox_monitor.trust.usable import SILENT, START_TIME

MIN_SILENCE = 0.5  # s between two looks; a late timer is followed by one that comes too soon


class Silence:
    """Watches one Monitor: its stamps must advance from one look to the next."""

    def __init__(self):
        self._seen = (0, 0, 0)  # stamp, inputs and clock at the last look that found new stamps

    def findings(self, monitor, now_ns, foreign=0, joints=''):
        """
        Return {component: Finding} at `now_ns` of a steady clock; a dead stream is never good.

        monitor: Monitor. foreign: messages that named none of the `joints` (text).
        """
        stamp, inputs, since = self._seen
        if monitor.stamp_ns != stamp:
            self._seen = (monitor.stamp_ns, monitor.input_count, now_ns)
            return dict(monitor.findings)
        if not since:
            self._seen = (stamp, inputs, now_ns)
            return dict(monitor.findings)
        silent = (now_ns - since) / stream.SECOND
        if silent < MIN_SILENCE:
            return dict(monitor.findings)
        refused = monitor.input_count - inputs
        counts = {text: int(monitor.counts[code]) for code, text in stream.REASONS.items()
                  if monitor.counts[code]}
        counts['messages_without_our_joints'] = foreign
        reason = f'{refused} samples came, none was usable' if refused else 'no samples came'
        if foreign and not monitor.input_count:
            reason = f'{foreign} messages named neither {joints}; set motor_joint and arm_joint'
        findings = {name: Finding(Level.WARN, f'no data for {silent:.1f} s', {})
                    for name in monitor.findings}
        # Discovery takes a while: before the first sample ever, silence is not yet an error.
        starting = not monitor.input_count and not foreign and silent < START_TIME
        findings['input'] = Finding(Level.WARN if starting else Level.ERROR,
                                    f'{reason} for {silent:.1f} s: {SILENT.advice}', counts)
        return findings
