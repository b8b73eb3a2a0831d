# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Stamps of foreign recordings: epochs, ISO 8601, repeated and unordered ones, and plausible rates.

Times become whole nanoseconds at once: a double resolves today's date to 256 ns only.
"""
from collections.abc import Callable
from dataclasses import dataclass
from datetime import timedelta
from decimal import Decimal, InvalidOperation
from pathlib import Path
import re

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import AnyArray, Array, Integers
from gearbox_monitor.recordings.importer.mapping import TimeMapping
from gearbox_monitor.recordings.importer.raw_columns import MIN_SAMPLES
from gearbox_monitor.recordings.importer.unit_table import TIME
from gearbox_monitor.signals.stamps import evened

# Sample times of drives, s: bus and servo rates. Stamps read in a wrong unit are outside.
SHORTEST, LONGEST = 5e-6, 0.1
PAUSE = 1_000_000_000  # ns between recordings in one file: longer than what a filter bridges
LAST = 2 ** 31 * 1_000_000_000  # ns: the header of a message holds no later second
ZONE = re.compile(r'\s*(Z|[+-]\d\d:?\d\d)$')


@dataclass(frozen=True)
class Ordering:
    """
    What becomes of samples with repeated or unordered stamps: ``apply(values)`` of any signal.

    Made by `ordered`. `stamp_ns` is strictly increasing; `notices` are sentences for the user.
    """

    stamp_ns: Integers
    rows: Integers
    starts: Integers
    average: bool
    notices: tuple[str, ...]

    def apply(self, values: Array) -> Array:
        """Return `values` [N] at `stamp_ns` [M]."""
        values = values[self.rows]
        if not self.average:
            return values[self.starts]
        missing = np.isnan(values)
        count = np.add.reduceat((~missing).astype(float), self.starts)
        total = np.add.reduceat(np.where(missing, 0.0, values), self.starts)
        return np.where(count > 0, total / np.maximum(count, 1.0), np.nan)


def absolute_ns(path: str | Path, raw: AnyArray, time: TimeMapping,
                place: Callable[[int], str]) -> Integers:
    """
    Return stamps as whole nanoseconds of the recording's own clock.

    Args:
        path: of the recording, for messages.
        raw: times [N] as recorded: numbers, texts or datetime64.
        time: their unit and scale.
        place: names the place of a row, for messages.

    Returns:
        Stamps, int64 [N], in ns, in the order of the file.

    Raises:
        InputError: a time is not a number or date, or outside the range of stamps.
    """
    if raw.dtype.kind == 'M':
        nanoseconds: Integers = raw.astype('M8[ns]').astype(np.int64)
        return nanoseconds
    if raw.dtype.kind == 'U':
        convert = _date_ns if time.unit == 'iso8601' else _decimal_ns
        stamps = []
        for row, text in enumerate(raw.tolist()):
            try:
                stamps.append(convert(text, time))
            except (ValueError, InvalidOperation):
                expected = 'a date such as 2026-03-01T12:00:00.001' \
                    if time.unit == 'iso8601' else 'a number'
                raise InputError(f'{path}: {place(row)} value {text[:40]!r}: expected '
                                 f'{expected}') from None
            if not -LAST < stamps[-1] < LAST:
                _refuse_range(path, place(row), text, stamps[-1])
        return np.array(stamps, np.int64)
    if time.unit == 'iso8601':
        raise InputError(f'{path}: {place(0)} value {raw[0]:.12g}: expected a date such as '
                         '2026-03-01T12:00:00.001 (time.unit: iso8601)')
    bad = np.flatnonzero(~np.isfinite(raw))
    if len(bad):
        raise InputError(f'{path}: {place(int(bad[0]))} value {raw[bad[0]]}: expected a finite '
                         'number')
    factor = time.scale * TIME[time.unit]
    implausible = np.flatnonzero(np.abs(raw.astype(float)) * factor >= LAST)
    if len(implausible):
        row = int(implausible[0])
        _refuse_range(path, place(row), f'{raw[row]:.12g}', float(raw[row]) * factor)
    if raw.dtype.kind == 'i' and time.scale == 1.0:
        return raw * np.int64(TIME[time.unit])
    first = float(raw[0])
    relative: Integers = np.rint((raw - first) * factor).astype(np.int64)
    return relative + round(first * factor)


def _refuse_range(path: str | Path, place: str, value: str, ns: float) -> None:
    raise InputError(f'{path}: {place} value {value}: stamp {ns * 1e-9:.9g} s, expected one > 0 '
                     'and < 2^31 s (time.unit: ms, us or ns?)')


def _date_ns(text: str, _: TimeMapping) -> int:
    """Return ns since 1970 (UTC, or the recording's own zone if it names none)."""
    zone = ZONE.search(text)
    plain = text[:zone.start()] if zone and 'T' in text.replace(' ', 'T') else text
    stamp = np.datetime64(plain.strip().replace(' ', 'T').replace(',', '.'), 'ns')
    if np.isnat(stamp):
        raise ValueError('no date')
    ns = int(stamp.astype(np.int64))
    if zone and zone[1] != 'Z':
        digits = zone[1].replace(':', '')
        shift = timedelta(hours=int(digits[1:3]), minutes=int(digits[3:5])) // timedelta(seconds=1)
        ns -= (shift if digits[0] == '+' else -shift) * 1_000_000_000
    return ns


def _decimal_ns(text: str, time: TimeMapping) -> int:
    number = Decimal(text.replace(',', '.'))
    if not number.is_finite() or abs(number) > LAST:
        raise ValueError('no finite number')
    return round(number * TIME[time.unit])


def ordered(path: str | Path, stamp_ns: Integers, time: TimeMapping,
            place: Callable[[int], str]) -> Ordering:
    """
    Return the Ordering that makes stamps strictly increasing, as `time` states.

    Args:
        path: of the recording, for messages.
        stamp_ns: int64 [N] in the order of the file.
        time: `repeated` and `unordered`.
        place: names the place of a row and its value, for messages.

    Returns:
        The Ordering.

    Raises:
        InputError: stamps are repeated or unordered, and `time` states no policy.
    """
    rows: Integers = np.arange(len(stamp_ns))
    notices = []
    backward = np.flatnonzero(stamp_ns < np.maximum.accumulate(stamp_ns))
    step = np.diff(stamp_ns)
    if len(backward) and time.unordered == 'error' or \
            np.any(step == 0) and time.repeated == 'error':
        row = int(np.flatnonzero(step <= 0)[0]) + 1
        cure = 'unordered: sort or drop' if step[row - 1] < 0 else \
            'repeated: first, average or drop'
        raise InputError(f'{path}: {place(row)} after {place(row - 1).rpartition(" value ")[2]}: '
                         f'expected strictly increasing time (or time.{cure})')
    if len(backward):
        notices.append(f'time: {len(backward)} of {len(rows)} samples with an earlier stamp than '
                       'the previous one '
                       f'{"dropped" if time.unordered == "drop" else "sorted in"}')
        rows = np.argsort(stamp_ns, kind='stable') if time.unordered == 'sort' else \
            np.delete(rows, backward)
    stamp_ns = stamp_ns[rows]
    starts: Integers = np.flatnonzero(np.diff(stamp_ns, prepend=stamp_ns[0] - 1))
    counts = np.diff(starts, append=len(stamp_ns))
    repeated = int((counts > 1).sum())
    if repeated:
        if time.repeated == 'error':  # only sorting has brought them together
            raise InputError(f'{path}: {repeated} stamps repeated once sorted, expected strictly '
                             'increasing time (or time.repeated: first, average or drop)')
        notices.append(f'time: {repeated} stamps of more than one sample: '
                       + {'first': 'the first one counts', 'average': 'their mean counts',
                          'drop': 'dropped'}[time.repeated])
        if time.repeated == 'drop':
            starts = starts[counts == 1]
    return Ordering(stamp_ns[starts], rows, starts, time.repeated == 'average' and repeated > 0,
                    tuple(notices))


def require_plausible(path: str | Path, stamp_ns: Integers, unit: str) -> None:
    """
    Refuse a recording that is too short, or whose times were read in a wrong unit.

    Args:
        path: of the recording, for messages.
        stamp_ns: int64 [N], strictly increasing.
        unit: of the recorded time, for messages; '' for a constant rate.

    Raises:
        InputError: fewer than MIN_SAMPLES samples, or a sample time that no drive has.
    """
    count = len(stamp_ns)
    if count < MIN_SAMPLES:
        raise InputError(f'{path}: {count} samples, expected at least {MIN_SAMPLES}')
    step = float(np.median(np.diff(stamp_ns))) * 1e-9
    if not SHORTEST <= step < LONGEST:
        duration = (stamp_ns[-1] - stamp_ns[0]) * 1e-9
        cure = f'time read in {unit}: is time.unit right?' if unit else 'is time.rate right?'
        raise InputError(f'{path}: {count} samples in {duration:.6g} s, one per {step:.6g} s, '
                         f'expected one per {SHORTEST:g} to {LONGEST:g} s ({cure})')


def in_one_line(stamp_ns: Integers, segments: AnyArray) -> tuple[Integers, list[str]]:
    """
    Return stamps of recordings with times of their own, PAUSE after the end of the previous one.

    Args:
        stamp_ns: int64 [N], of each recording in its own time.
        segments: [N], another value where another recording begins.

    Returns:
        The stamps, and a sentence about it if there are several recordings.
    """
    starts = np.flatnonzero(segments[1:] != segments[:-1]) + 1
    if not len(starts):
        return stamp_ns, []
    shift: Integers = np.zeros(len(stamp_ns), np.int64)
    shift[starts] = stamp_ns[starts - 1] + PAUSE - stamp_ns[starts]
    return stamp_ns + np.cumsum(shift), [
        f'time: {len(starts) + 1} recordings one after another, each {PAUSE * 1e-9:g} s after the '
        'end of the previous one (time.only reads one of them)']


def even_stamps(path: str | Path, stamp_ns: Integers) -> tuple[Integers, list[str]]:
    """
    Return evenly spaced stamps: a line through those of each stretch without a dropout.

    For samples of a device with a steady clock, stamped late and in bursts by who received them.

    Args:
        path: of the recording, for messages.
        stamp_ns: int64 [N], not decreasing.

    Returns:
        The stamps, int64 [N], strictly increasing, and a sentence about it.

    Raises:
        InputError: a stamp goes back, or too many are alike.
    """
    step = np.diff(stamp_ns)
    if (step < 0).any() or len(step) < 2 or stamp_ns[-1] - stamp_ns[0] < len(step):
        raise InputError(f'{path}: time.stamps even: {int((step < 0).sum())} stamps go back and '
                         f'{int((step == 0).sum())} of {len(stamp_ns)} repeat, expected stamps '
                         'that grow on the whole')
    even = evened(stamp_ns)
    shift = float(np.abs(even - stamp_ns).max()) * 1e-9
    rate = (len(even) - 1) / (float(even[-1] - even[0]) * 1e-9)
    return even, [f'time: stamps laid on an even grid of {rate:.5g} Hz on average, moved by up to '
                  f'{shift:.3g} s']
