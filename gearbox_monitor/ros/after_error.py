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

"""When the estimator keeps its recording by itself. No ROS, no clock, no disk here."""
import math


class AfterError:
    """
    Tells when to keep the recording: `seconds` after a component became ERROR, once per alert.

    Two such recordings are at least `span` (s) apart, the time that a recording reaches back: an
    alert that comes sooner waits, and is in the next one. `wrong`: components that are ERROR
    already, from before the start; they are no alert until they were well again.

    texts: {component: text} of what became of its newest alert.
    """

    def __init__(self, seconds, span, wrong=()):
        self._seconds, self._span, self._wrong = seconds, span, set(wrong)
        self._due = {}  # {component: when its recording is to be kept}
        self._kept = -math.inf
        self.texts = {}

    def look(self, wrong, now, busy=False):
        """
        Return the components whose alert is to be kept now, [] mostly.

        wrong: components that are ERROR at `now` (s, of a clock that only goes forward). busy:
        nothing can be kept now.
        """
        for component in set(wrong) - self._wrong:
            self._due.setdefault(component, now + self._seconds)
        self._wrong = set(wrong)
        wait = min(self._due.values(), default=math.inf)
        wait = max(wait, self._kept + self._span) - now
        if wait <= 0.0 and not busy:
            self._kept = now
            return self.waiting()
        self.texts.update({component: f'due in {max(wait, 0.0):.0f} s' for component in self._due})
        return []

    def waiting(self):
        """Return the components whose alert was not kept yet; they are taken for kept now."""
        components, self._due = sorted(self._due), {}
        return components

    def tell(self, components, text):
        """Note what became of the recording of the alerts of `components`."""
        self.texts.update(dict.fromkeys(components, text))
