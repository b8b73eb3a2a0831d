# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Stamps of a recording: order, rate, jitter, dropouts and length."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.noise_search import MIN_SECONDS
from gearbox_monitor.estimation.sample_loop import (
    BACKWARD, CONFIRM, DUPLICATE, ESTIMATE, JUMP, stamp_codes, START, ZERO_STAMP)
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.presentation import Said, said
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, Grade, hurts, judged, LIMITS, OK, WARN)
from gearbox_monitor.signals.uniform import absent_samples, UniformRecording, usual_step

_GROUP = 'stamps'


@dataclass(frozen=True)
class StampClock:
    """
    The usable stamps.

    usable: mask [N] of the samples that a filter takes by their stamps; seconds [K] from the first
    of these; period (s): their usual distance; jitter (s): standard deviation of the stamps about
    even spacing; absent [K - 1]: samples missing behind each, as diagnose counts them. restarts:
    rows of K at which the clock restarts; seconds go on there by one period. burst: samples that
    are stamped at once, on receipt; seconds are then even.
    """

    usable: Flags
    seconds: Array
    period: float
    jitter: float
    absent: Integers
    restarts: tuple[int, ...] = ()
    burst: int = 1

    @property
    def duration(self) -> float:
        """From the first to the last usable stamp, s."""
        return float(self.seconds[-1])


def clock(stamps: Integers, max_gap: float = LIMITS.max_gap) -> StampClock | None:
    """
    Return the StampClock of some stamps, None where fewer than ten are usable.

    Args:
        stamps: int64 [N], ns.
        max_gap: longest dropout that the filter bridges, s.
    """
    burst = burst_size(stamps)
    if burst > 1:
        usable = np.full(len(stamps), True)
        seconds = (evened(stamps) - stamps[0]) * 1e-9
        restarts: Integers = np.zeros(0, int)
    else:
        codes = stamp_codes(stamps, max_gap)
        usable = (codes == ESTIMATE) | (codes == START)
        good = stamps[usable]
        if len(good) < 10:
            return None
        step = np.diff(good)
        restarts = np.flatnonzero(step <= 0) + 1
        step[restarts - 1] = np.median(step)
        seconds = np.append(0.0, np.cumsum(step * 1e-9))
        if not len(restarts):
            seconds = (good - good[0]) * 1e-9
    step = np.diff(seconds)
    period, spread = usual_step(seconds)
    gap = max(1.5 * period, period + 4.0 * spread)
    even = step[step <= gap]
    period = float(even.mean())
    jitter = float(even.std()) / np.sqrt(2.0)  # a late stamp moves the step before and behind it
    return StampClock(usable, seconds, period, jitter, absent_samples(seconds),
                      tuple(restarts.tolist()), burst)


def unstamped(count: int) -> str:
    """Return what to say of `count` messages without a header stamp."""
    return (f'all {count} header stamps are 0: the driver does not stamp its messages, expected '
            'times of measurement; gearbox_monitor import BAG --stamps received NEW takes the '
            'times of receipt')


def require_stamps(name: str, stamps: Integers) -> None:
    """Raise InputError, naming the recording `name`, if several `stamps` [N] (ns) are all 0."""
    if len(stamps) > 1 and (stamps <= 0).all():
        raise InputError(f'{name}: {unstamped(len(stamps))}')


def segment(clock: StampClock, u: Array, y: Array) -> UniformRecording:
    """
    Return the longest part without a dropout on an even grid, with torque NaN where few are known.

    Args:
        clock: usable stamps.
        u: torque as recorded [N], N m; NaN: not measured.
        y: readings as recorded [N, 2], rad; NaN: not measured.
    """
    t, u, y = clock.seconds, u[clock.usable], y[clock.usable]
    edges = np.union1d(np.flatnonzero(np.diff(t) > LIMITS.stuck_samples * clock.period) + 1,
                       np.array(clock.restarts, int))
    starts, ends = np.append(0, edges), np.append(edges, len(t))
    longest = int(np.argmax(t[ends - 1] - t[starts]))
    keep = slice(starts[longest], ends[longest])
    t, u, y = t[keep], u[keep], y[keep]
    even = clock.jitter < LIMITS.quiet_jitter * clock.period and len(t) == round(
        (t[-1] - t[0]) / clock.period) + 1
    grid = t if even else np.arange(t[0], t[-1], clock.period)

    def on_grid(value: Array, smallest_share: float, hold: bool = False) -> Array:
        """Return a channel [N], NaN if less than a share is known; hold: not interpolated."""
        good = np.isfinite(value)
        if good.mean() < smallest_share:
            return np.full(len(grid), np.nan)
        if even and good.all():
            return value
        if hold:
            last = np.searchsorted(t[good], grid + 0.5 * clock.period, 'right') - 1
            return value[good][np.maximum(last, 0)]
        return np.interp(grid, t[good], value[good])
    readings = np.column_stack([on_grid(channel, LIMITS.least_share) for channel in y.T])
    channels = tuple(i for i in (0, 1) if np.isfinite(readings[:, i]).all())
    if len(channels) == 1:
        readings[:, 1 - channels[0]] = readings[:, channels[0]]
    return UniformRecording(grid - t[0], on_grid(u, 1.0 - LIMITS.lost_many, hold=True), readings,
                            clock.period, channels=channels, begin=float(t[0]))


def burst_size(stamps: Integers) -> int:
    """Return how many of `stamps` [N] (ns) come at once, on receipt of a packet; 1: each alone."""
    step = np.diff(stamps)
    if (len(step) < LIMITS.least_changes or (step < 0).any() or stamps[0] <= 0
            or stamps[-1] == stamps[0]):
        return 1
    mean = float(np.mean(np.minimum(step, LIMITS.dropout * np.percentile(step, 99.5))))
    at_once = step < LIMITS.at_once * mean
    if at_once.mean() < LIMITS.bursts:
        return 1
    return max(1, round(len(stamps) / (int((~at_once).sum()) + 1)))


def evened(stamps: Integers) -> Integers:
    """
    Return evenly spaced stamps: a line through those of each stretch without a dropout.

    Args:
        stamps: int64 [N], ns, not decreasing, at least two of them different.
    """
    step = np.diff(stamps)
    dropout = LIMITS.dropout * np.percentile(step[step > 0], 99.5)
    starts = np.append(0, np.flatnonzero(step > dropout) + 1)
    even = np.empty(len(stamps), np.int64)
    for first, last in zip(starts, np.append(starts[1:], len(stamps))):
        count = np.arange(last - first)
        part = (stamps[first:last] - stamps[first]).astype(float)
        slope, start = np.polyfit(count, part, 1) if len(count) > 2 else (
            part[-1] / max(len(count) - 1, 1), 0.0)
        even[first:last] = stamps[first] + np.rint(slope * count + start).astype(np.int64)
    count = np.arange(len(even))
    increasing: Integers = np.maximum.accumulate(even - count) + count
    return increasing


def lines(stamps: Integers, clock: StampClock, max_gap: float, drift_window: float
          ) -> list[DataFinding]:
    """
    Return the findings about order, rate, jitter or bursts, gaps and length of `stamps`.

    Args:
        stamps: stamps [N], ns.
        clock: usable stamps.
        max_gap: longest dropout that the filter bridges, s.
        drift_window: window of the drift estimate, s.
    """
    return [_order(stamps, clock, max_gap), _rate_of(1.0 / clock.period), _jitter(clock),
            _gaps(clock, max_gap), length(clock.duration, drift_window)]


def _order(stamps: Integers, clock: StampClock, max_gap: float) -> DataFinding:
    """Return the finding about stamps that a filter refuses; the counts are those of replay."""
    codes = stamp_codes(stamps, max_gap)
    zero, repeated, backward, jumps = (int((codes == code).sum()) for code in (
        ZERO_STAMP, DUPLICATE, BACKWARD, JUMP))
    refused, restarts = zero + repeated + backward + jumps, len(clock.restarts)
    values = {'samples': len(stamps), 'zero': zero, 'repeated': repeated, 'backward': backward,
              'refused': refused, 'restarts': restarts}
    share = refused / len(stamps)
    grade = BAD if share > LIMITS.least_share else WARN
    spoilt = {} if refused == jumps and not restarts else hurts(
        grade, grade, BAD if share > LIMITS.max_repaired else grade)
    return judged(_GROUP, 'order', _order_said(values), spoilt, values)


def _order_said(values: Mapping[str, Any]) -> Said:
    """Return what the counts `values` of `_order` say."""
    parts = [said(f'{key}_stamps', count=values[key]) for key in (
        'zero', 'repeated', 'backward') if values[key]]
    swapped = values['backward'] > (CONFIRM - 1) * values['restarts']
    if values['restarts']:
        parts.append(said('clock_restarts', count=values['restarts']))
    if not parts:
        after = (said('after_gaps', count=values['refused']),) if values['refused'] else ()
        return said('in_order', count=values['samples'], refused=after)
    stamped = not (values['zero'] or values['repeated'] or swapped)
    return said('order_of_runs' if stamped else 'order', counts=tuple(parts),
                refused=values['refused'], samples=values['samples'])


def held(clock: StampClock, y: Array, lowest: float = LIMITS.held_rate) -> list[DataFinding]:
    """
    Return findings about positions y [N, 2] (rad) that are repeated between their measurements.

    Args:
        clock: usable stamps.
        y: readings as recorded [N, 2], rad; NaN: not measured.
        lowest: rate of measurements that suits a diagnosis, Hz.
    """
    findings = []
    for name, values in zip(('motor', 'arm'), y[clock.usable].T):
        rows = held_rows(values)
        if rows > 1:
            rate = 1.0 / (rows * clock.period)
            findings.append(replace(
                _rate_of(rate, lowest), group=name, name='held', says=(said(
                    'held', rows=rows, rate=rate, stamped=1.0 / clock.period, lowest=lowest),)))
    return findings


def held_rows(values: Array) -> int:
    """Return for how many rows each of the readings `values` [N] is held, 1: they are not."""
    values = values[np.isfinite(values)]
    at = np.flatnonzero(np.diff(values)) + 1
    if len(at) < LIMITS.least_changes:
        return 1
    rows = np.diff(at)
    usual = int(np.median(rows))
    rhythmic = np.abs(rows - usual) <= max(0.1 * usual, usual > 2)
    size = np.abs(np.diff(values[at - 1]))
    if usual < 2 or rhythmic.mean() < LIMITS.held or size.std() < LIMITS.uneven * size.mean():
        return 1
    return usual


def _rate_of(rate: float, lowest: float = LIMITS.diagnosis_slowest) -> DataFinding:
    estimation = OK if LIMITS.slowest <= rate * 1.01 and rate <= LIMITS.fastest * 1.01 else WARN
    if rate < LIMITS.least_rate:
        estimation = BAD
    highest = LIMITS.diagnosis_fastest
    fits = lowest <= rate * 1.01 and rate <= highest * 1.01
    return judged(
        _GROUP, 'rate', said('rate_of_samples', rate=rate, lowest=lowest),
        hurts(estimation, estimation, OK if fits else BAD), {'rate_hz': rate})


def _jitter(clock: StampClock) -> DataFinding:
    if clock.burst > 1:
        return judged(_GROUP, 'bursts', said('bursts_of', rate=1.0 / clock.period,
                                             count=clock.burst),
                      everything(BAD), {'burst': clock.burst})
    share = clock.jitter / clock.period
    grade = BAD if share > 1.0 else WARN if share > LIMITS.jitter_notice else OK
    return judged(
        _GROUP, 'jitter', said('no_jitter' if clock.jitter < 1e-6 else 'jitter',
                               ms=1e3 * clock.jitter, percent=100.0 * share),
        everything(grade), {'jitter_s': clock.jitter})


def _gaps(clock: StampClock, max_gap: float) -> DataFinding:
    step = np.diff(clock.seconds)
    longest, lost = float(step.max()), clock.absent.sum()
    step[[row - 1 for row in clock.restarts]] = 0.0
    gaps = int((clock.absent > 0).sum())
    restarts = int((step > max_gap).sum())
    values = {'gaps': gaps, 'lost': int(lost), 'longest_gap_s': longest, 'restarts': restarts,
              'longest_gap_at_s': float(clock.seconds[np.argmax(step)]),
              'samples': len(clock.seconds)}
    share = lost / (lost + len(clock.seconds))
    grade = (BAD if share > LIMITS.lost_many
             else WARN if share > LIMITS.lost_notice or restarts else OK)
    return judged(_GROUP, 'gaps', _gaps_said(values), hurts(
        grade, grade, _for_diagnosis(clock)) if lost else {}, values)


def _gaps_said(values: Mapping[str, Any]) -> Said:
    """Return what the counts `values` of `_gaps` say."""
    longest, lost, restarts = (values[key] for key in ('longest_gap_s', 'lost', 'restarts'))
    share = lost / (lost + values['samples'])
    return said(
        'no_gaps' if not lost else 'gaps' if share > LIMITS.lost_notice or restarts else
        'few_gaps', count=values['gaps'], lost=lost, percent=100.0 * share, longest=longest,
        ms=1e3 * longest, at=values['longest_gap_at_s'],
        restarts=(said('restart_filter', count=restarts),) if restarts else ())


def counted(line: DataFinding, parts: Sequence[tuple[float, DataFinding]]) -> DataFinding:
    """
    Return the finding `line` about order or gaps with the counts of all parts of a recording.

    Args:
        line: of the part that decides.
        parts: (begin of the part from that of the recording in s, its finding), in order; each
            part begins with the last sample of the part before.
    """
    values = {key: sum(finding.values[key] for _, finding in parts) for key in line.values}
    values['samples'] -= len(parts) - 1
    if line.name == 'order':
        return replace(line, says=(_order_said(values),), values=values)
    begin, longest = max(parts, key=lambda pair: pair[1].values['longest_gap_s'])
    values['longest_gap_s'] = longest.values['longest_gap_s']
    values['longest_gap_at_s'] = begin + longest.values['longest_gap_at_s']
    return replace(line, says=(_gaps_said(values),), values=values)


def _for_diagnosis(clock: StampClock) -> Grade:
    """Return the Grade of the longest stretch, which a diagnosis uses, for its lost samples."""
    cuts = np.flatnonzero(clock.absent > LIMITS.max_run) + 1
    edges = [0, *cuts.tolist(), len(clock.seconds)]
    length, first, last = max((float(clock.seconds[b - 1] - clock.seconds[a]), a, b)
                              for a, b in zip(edges, edges[1:]))
    lost = clock.absent[first:last - 1].sum()
    if length + clock.period < 0.999 * LIMITS.min_duration or lost > LIMITS.max_repaired * (
            lost + last - first):
        return BAD
    return WARN if lost or len(cuts) else OK


def length(seconds: float, drift_window: float) -> DataFinding:
    """Return the finding about a recording of so many `seconds`; see `lines` on drift_window."""
    windows = int(seconds / drift_window)
    estimation = OK if seconds >= MIN_SECONDS else WARN
    drift = BAD if not windows else WARN if windows < LIMITS.drift_windows_few else OK
    diagnosis = BAD if seconds < LIMITS.min_duration * 0.999 else \
        WARN if seconds < 2.0 * LIMITS.min_duration else OK
    code = ('length_of_all' if drift and (diagnosis or estimation) else
            'length_of_drift' if drift else 'length')
    return judged(_GROUP, 'length', said(code, seconds=seconds, window=drift_window),
                  hurts(estimation, drift, diagnosis), {'duration_s': seconds})
