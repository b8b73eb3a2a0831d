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

"""Stamps of a recording: order, rate, jitter, dropouts and length."""
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.quality.finding import BAD, everything, Finding, hurts, OK, WARN
from gearbox_monitor.quality.recording import DIAGNOSIS_RATES, MAX_REPAIRED, MIN_DURATION, SHORT

RATES = (100.0, 2000.0)  # Hz, of estimation
LEAST_RATE = 20.0        # Hz, below it nothing of a drive's motion is left
REFUSED = 0.05           # share of samples with unusable stamps that nothing should rest on
JITTER = (0.1, 1.0)      # of the period: worth a word; no clock of the measurement
LOST = (0.001, 0.1)      # share of samples
LENGTH = 5.0             # s, for R and Q
DRIFT_WINDOWS = (1, 6)   # none can be measured; few
LEAST_CHANGES = 50       # of a value, to see a rhythm
HELD = 0.8               # share of changes that come in one rhythm, if values are held
UNEVEN = 0.3             # of the size of their steps: steps of a lattice are all of one size
_GROUP = 'stamps'


@dataclass(frozen=True)
class StampClock:
    """
    The usable stamps.

    usable: mask [N] of the samples whose stamp is later than all before; seconds [K] from the
    first of these; period (s): their usual distance; gap (s): distances beyond it are gaps; jitter
    (s): standard deviation of the stamps about even spacing; missing: samples missing by the
    stamps.
    """

    usable: Flags
    seconds: Array
    period: float
    gap: float
    jitter: float
    missing: int

    @property
    def duration(self) -> float:
        """From the first to the last usable stamp, s."""
        return float(self.seconds[-1])


def clock(stamps: Integers) -> StampClock | None:
    """Return the Clock of stamps int64 [N] ns, or None where fewer than ten are usable."""
    latest = np.maximum.accumulate(stamps)
    usable = stamps > 0
    usable[1:] &= stamps[1:] > latest[:-1]
    good = stamps[usable]
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
    missing = int(np.rint(step[step > gap] / period - 1.0).sum())
    return StampClock(usable, seconds, period, gap, jitter, missing)


def lines(stamps: Integers, clock: StampClock, max_gap: float, drift_window: float,
          rates: tuple[float, float] = DIAGNOSIS_RATES) -> list[Finding]:
    """
    Return Lines on stamps int64 [N] ns with their Clock `found`.

    max_gap, drift_window (s): the estimator's parameters of that name.

    Args:
        stamps: stamps [N], ns.
        clock: usable stamps.
        max_gap: longest dropout that the filter bridges, s.
        drift_window: window of the drift estimate, s.
        rates: lowest and highest of a diagnosis, Hz.
    """
    return [_order(stamps, clock), _rate_of(1.0 / clock.period, rates), _jitter(clock),
            _gaps(clock, max_gap), length(clock.duration, drift_window)]


def _order(stamps: Integers, clock: StampClock) -> Finding:
    zero = int((stamps <= 0).sum())
    step = np.diff(stamps[stamps > 0])
    repeated, backward = int((step == 0).sum()), int((step < 0).sum())
    refused = int(len(stamps) - clock.usable.sum())
    values = {'samples': len(stamps), 'zero': zero, 'repeated': repeated, 'backward': backward,
              'refused': refused}
    counts = [f'{n} {word}' for n, word in ((zero, 'zero'), (repeated, 'repeated'),
                                            (backward, 'backward')) if n]
    if not counts:
        return Finding(_GROUP, 'order', f'{len(stamps)}, all increasing', values=values)
    share = refused / len(stamps)
    grade = BAD if share > REFUSED else WARN
    return Finding(
        _GROUP, 'order', f'{", ".join(counts)}; {refused} of {len(stamps)} samples are refused',
        'let one publisher stamp each message with the time of its measurement',
        hurts(grade, grade, BAD if zero or backward or share > MAX_REPAIRED else grade), values)


def held(clock: StampClock, y: Array,
         rates: tuple[float, float] = DIAGNOSIS_RATES) -> list[Finding]:
    """
    Return findings about positions y [N, 2] (rad) that are repeated between their measurements.

    Args:
        clock: usable stamps.
        y: readings as recorded [N, 2], rad; NaN: not measured.
        rates: lowest and highest of a diagnosis, Hz.
    """
    findings = []
    for name, values in zip(('motor', 'arm'), y[clock.usable].T):
        rows = held_rows(values)
        if rows > 1:
            rate = 1.0 / (rows * clock.period)
            findings.append(replace(
                _rate_of(rate, rates), group=name, name='held',
                figure=f'each value is held for {rows} rows: '
                f'measured at {rate:.4g} Hz, not at {1.0 / clock.period:.5g} Hz'))
    return findings


def held_rows(values: Array) -> int:
    """Return for how many rows each of the readings [N] is held, 1 if they are not."""
    values = values[np.isfinite(values)]
    at = np.flatnonzero(np.diff(values)) + 1
    if len(at) < LEAST_CHANGES:
        return 1
    rows = np.diff(at)
    usual = int(np.median(rows))
    rhythmic = np.abs(rows - usual) <= max(0.1 * usual, usual > 2)
    size = np.abs(np.diff(values[at - 1]))
    if usual < 2 or rhythmic.mean() < HELD or size.std() < UNEVEN * size.mean():
        return 1
    return usual


def _rate_of(rate: float, rates: tuple[float, float]) -> Finding:
    estimation = OK if RATES[0] <= rate * 1.01 and rate <= RATES[1] * 1.01 else WARN
    if rate < LEAST_RATE:
        estimation = BAD
    fits = rates[0] <= rate * 1.01 and rate <= rates[1] * 1.01
    spoilt = hurts(estimation, estimation, OK if fits else BAD)
    advice = ''
    if spoilt:
        advice = (f'record {RATES[0]:g} to {RATES[1]:g} Hz, for diagnose {rates[0]:g} '
                  f'to {rates[1]:g} Hz')
    return Finding(_GROUP, 'rate', f'{rate:.5g} Hz', advice, spoilt, {'rate_hz': rate})


def _jitter(clock: StampClock) -> Finding:
    share = clock.jitter / clock.period
    grade = BAD if share > JITTER[1] else WARN if share > JITTER[0] else OK
    advice = '' if grade == OK else \
        'stamp where the encoders are read, not where the message is made or received'
    figure = 'below 1 us' if clock.jitter < 1e-6 else \
        f'{clock.jitter * 1e3:.2g} ms rms, {100 * share:.2g} % of the period'
    return Finding(_GROUP, 'jitter', figure, advice, everything(grade), {'jitter_s': clock.jitter})


def _gaps(clock: StampClock, max_gap: float) -> Finding:
    step = np.diff(clock.seconds)
    longest = float(step.max())
    gaps = step > clock.gap
    values = {'gaps': int(gaps.sum()), 'lost': clock.missing, 'longest_gap_s': longest}
    if not clock.missing:
        return Finding(_GROUP, 'gaps', f'none; longest step {longest * 1e3:.3g} ms', values=values)
    share = clock.missing / (clock.missing + len(clock.seconds))
    restarts = int((step > max_gap).sum())
    grade = BAD if share > LOST[1] else WARN if share > LOST[0] or restarts else OK
    at = clock.seconds[np.argmax(step)]
    figure = (f'{gaps.sum()} with {clock.missing} samples ({100 * share:.2g} %), the longest '
              f'{longest:.3g} s at {at:.4g} s')
    if restarts:
        figure += f'; {restarts} restart the filter'
    advice = '' if grade == OK else \
        'look for a busy network or recorder: raise the depth of its queue, record locally'
    return Finding(_GROUP, 'gaps', figure, advice,
                   hurts(grade, grade, BAD if share > MAX_REPAIRED else grade), values)


def length(seconds: float, drift_window: float) -> Finding:
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
    return Finding(_GROUP, 'length', f'{seconds:.4g} s', '; '.join(advice),
                   hurts(estimation, drift, diagnosis), {'duration_s': seconds})
