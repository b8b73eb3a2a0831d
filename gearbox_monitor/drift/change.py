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

"""Judge whether the gap has grown against its baseline."""
from dataclasses import dataclass
import math

from gearbox_monitor.trust.level import Finding, Level

# An automatic baseline is the mean of this many first windows.
BASELINE_WINDOWS = 3
SIGNIFICANT = 4.0  # standard deviations


@dataclass(frozen=True)
class Baseline:
    """Healthy values: gap (rad) and stiffness (N m/rad) with their standard deviations."""

    gap: float
    gap_std: float
    stiffness: float
    stiffness_std: float


def baseline_of(windows):
    """Return the Baseline of the list `windows` of Backlash."""
    n = len(windows)

    def mean(name):
        return sum(getattr(w, name) for w in windows) / n

    def std(name):
        return math.sqrt(sum(getattr(w, name) ** 2 for w in windows)) / n

    return Baseline(mean('gap'), std('gap_std'), mean('stiffness'), std('stiffness_std'))


def check(now, baseline, warn, error):
    """
    Return the Finding for the Backlash `now` against `baseline`, each None while not known.

    warn, error: relative growth of the gap.
    """
    if now is None:
        return Finding(Level.WARN, 'backlash not measured yet: the motion must load both flanks')
    values = {
        'gap_rad': now.gap, 'gap_std_rad': now.gap_std,
        'gap_arcmin': math.degrees(now.gap) * 60.0,
        'stiffness': now.stiffness, 'stiffness_std': now.stiffness_std, 'flank': now.flank}
    if baseline is None:
        return Finding(Level.OK, f'gap {now.gap:.4g} rad; baseline not complete yet', values)
    growth = now.gap / baseline.gap - 1.0 if baseline.gap > 0.0 else math.inf
    spread = math.hypot(now.gap_std, baseline.gap_std)
    sigmas = (now.gap - baseline.gap) / spread if spread > 0.0 else math.inf
    values.update({
        'baseline_gap_rad': baseline.gap, 'growth': growth, 'growth_warn': warn,
        'growth_error': error, 'growth_sigmas': sigmas, 'growth_sigmas_threshold': SIGNIFICANT})
    text = f'gap {now.gap:.4g} rad, {100 * growth:+.1f} % against the baseline'
    if sigmas > SIGNIFICANT and growth > error:
        return Finding(Level.ERROR, f'{text}: backlash has grown, plan a service', values)
    if sigmas > SIGNIFICANT and growth > warn:
        return Finding(Level.WARN, f'{text}: backlash is growing, watch it', values)
    return Finding(Level.OK, text, values)
