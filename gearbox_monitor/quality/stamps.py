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

"""Are the stamps those of one clock that ticks evenly, and how long do they last."""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.quality.input_checks import RATES as DIAGNOSIS_RATES, SHORT
from gearbox_monitor.quality.line import BAD, everything, hurts, Line, OK, WARN
from gearbox_monitor.quality.recording import MAX_REPAIRED, MIN_DURATION

RATES = (100.0, 2000.0)  # Hz, of estimation
LEAST_RATE = 20.0        # Hz, below it nothing of a drive's motion is left
REFUSED = 0.05           # share of samples with unusable stamps that nothing should rest on
JITTER = (0.1, 1.0)      # of the period: worth a word; no clock of the measurement
LOST = (0.001, 0.1)      # share of samples
LENGTH = 5.0             # s, for R and Q
DRIFT_WINDOWS = (1, 6)   # none can be measured; few
_GROUP = 'stamps'


@dataclass(frozen=True)
class Clock:
    """
    The usable stamps.

    kept: mask [N] of the samples whose stamp is later than all before; seconds [K] from the first
    of these; period (s): their usual distance; gap (s): distances beyond it are gaps; jitter (s):
    standard deviation of the stamps about even spacing; lost: samples missing by the stamps.
    """

    kept: np.ndarray
    seconds: np.ndarray
    period: float
    gap: float
    jitter: float
    lost: int

    @property
    def duration(self):
        """From the first to the last usable stamp, s."""
        return float(self.seconds[-1])


def clock(stamps):
    """Return the Clock of stamps int64 [N] ns, or None where fewer than ten are usable."""
    latest = np.maximum.accumulate(stamps)
    kept = stamps > 0
    kept[1:] &= stamps[1:] > latest[:-1]
    good = stamps[kept]
    if len(good) < 10:
        return None
    seconds = (good - good[0]) * 1e-9
    step = np.diff(seconds)
    period = float(np.median(step))
    spread = 1.4826 * float(np.median(np.abs(step - period)))
    gap = max(1.5 * period, period + 4.0 * spread)
    even = step[step <= gap]
    period = float(even.mean())
    jitter = float(even.std()) / np.sqrt(2.0)  # a late stamp moves the step before and behind it
    lost = int(np.rint(step[step > gap] / period - 1.0).sum())
    return Clock(kept, seconds, period, gap, jitter, lost)


def lines(stamps, found, max_gap, drift_window):
    """
    Return Lines on stamps int64 [N] ns with their Clock `found`.

    max_gap, drift_window (s): the estimator's parameters of that name.
    """
    return [_order(stamps, found), _rate(found), _jitter(found), _gaps(found, max_gap),
            length(found.duration, drift_window)]


def _order(stamps, found):
    zero = int((stamps <= 0).sum())
    step = np.diff(stamps[stamps > 0])
    repeated, backward = int((step == 0).sum()), int((step < 0).sum())
    refused = int(len(stamps) - found.kept.sum())
    values = {'samples': len(stamps), 'zero': zero, 'repeated': repeated, 'backward': backward,
              'refused': refused}
    told = [f'{n} {word}' for n, word in ((zero, 'zero'), (repeated, 'repeated'),
                                          (backward, 'backward')) if n]
    if not told:
        return Line(_GROUP, 'order', f'{len(stamps)}, all increasing', values=values)
    share = refused / len(stamps)
    worst = BAD if share > REFUSED else WARN
    return Line(
        _GROUP, 'order', f'{", ".join(told)}; {refused} of {len(stamps)} samples are refused',
        'let one publisher stamp each message with the time of its measurement',
        hurts(worst, worst, BAD), values)


def _rate(found):
    rate = 1.0 / found.period
    estimation = OK if RATES[0] <= rate * 1.01 and rate <= RATES[1] * 1.01 else WARN
    if rate < LEAST_RATE:
        estimation = BAD
    fits = DIAGNOSIS_RATES[0] <= rate * 1.01 and rate <= DIAGNOSIS_RATES[1] * 1.01
    spoilt = hurts(estimation, estimation, OK if fits else BAD)
    advice = ''
    if spoilt:
        advice = (f'record {RATES[0]:g} to {RATES[1]:g} Hz, for diagnose {DIAGNOSIS_RATES[0]:g} '
                  f'to {DIAGNOSIS_RATES[1]:g} Hz')
    return Line(_GROUP, 'rate', f'{rate:.5g} Hz', advice, spoilt, {'rate_hz': rate})


def _jitter(found):
    share = found.jitter / found.period
    worst = BAD if share > JITTER[1] else WARN if share > JITTER[0] else OK
    advice = '' if worst == OK else \
        'stamp where the encoders are read, not where the message is made or received'
    told = 'below 1 us' if found.jitter < 1e-6 else \
        f'{found.jitter * 1e3:.2g} ms rms, {100 * share:.2g} % of the period'
    return Line(_GROUP, 'jitter', told, advice, everything(worst), {'jitter_s': found.jitter})


def _gaps(found, max_gap):
    step = np.diff(found.seconds)
    longest = float(step.max())
    gaps = step > found.gap
    values = {'gaps': int(gaps.sum()), 'lost': found.lost, 'longest_gap_s': longest}
    if not found.lost:
        return Line(_GROUP, 'gaps', f'none; longest step {longest * 1e3:.3g} ms', values=values)
    share = found.lost / (found.lost + len(found.seconds))
    restarts = int((step > max_gap).sum())
    worst = BAD if share > LOST[1] else WARN if share > LOST[0] or restarts else OK
    at = found.seconds[np.argmax(step)]
    told = (f'{gaps.sum()} with {found.lost} samples ({100 * share:.2g} %), the longest '
            f'{longest:.3g} s at {at:.4g} s')
    if restarts:
        told += f'; {restarts} restart the filter'
    advice = '' if worst == OK else \
        'look for a busy network or recorder: raise the depth of its queue, record locally'
    return Line(_GROUP, 'gaps', told, advice,
                hurts(worst, worst, BAD if share > MAX_REPAIRED else worst), values)


def length(seconds, drift_window):
    """Return the Line on a recording of so many `seconds`; drift_window (s): the estimator's."""
    windows = int(seconds / drift_window)
    estimation = OK if seconds >= LENGTH else WARN
    drift = BAD if windows < DRIFT_WINDOWS[0] else WARN if windows < DRIFT_WINDOWS[1] else OK
    diagnosis = BAD if seconds < MIN_DURATION * 0.999 else \
        WARN if seconds < SHORT else OK
    advice = []
    if drift:
        advice.append(f'for drift record {DRIFT_WINDOWS[1]} windows of {drift_window:g} s or more')
    if diagnosis or estimation:
        advice.append('for all else 10 s or more')
    return Line(_GROUP, 'length', f'{seconds:.4g} s', '; '.join(advice),
                hurts(estimation, drift, diagnosis), {'duration_s': seconds})
