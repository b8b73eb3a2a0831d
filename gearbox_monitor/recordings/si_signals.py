# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Signals in SI units of a Table, as a Mapping reads it: in blocks, or all at once.

Times become whole nanoseconds at once: a double resolves today's date to 256 ns only. Stamps are
kept as they are recorded, repeated and unordered ones, too.
"""
from collections.abc import Callable, Iterable, Iterator, Mapping as Dict, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
import re

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import AnyArray, Array, Flags, Integers
from gearbox_monitor.recordings.cdr import FIELDS
from gearbox_monitor.recordings.mapping import (
    key_of, kind_of, Mapping, SignalMapping, TimeMapping)
from gearbox_monitor.recordings.meaning import EFFORT, standard_unit, TIME, units_of
from gearbox_monitor.recordings.read import Frames, VirtualBag
from gearbox_monitor.recordings.table import Table
from gearbox_monitor.recordings.text import MIN_SAMPLES, RowBlock
from gearbox_monitor.signals.stamps import evened

FIRST_STAMP_NS = 1_000_000_000  # stamp 0 means "no stamp" to ROS and to the estimator
EPOCH = 10 ** 18  # ns: a stamp from 2001 on is a date
SHORTEST, LONGEST = 5e-6, 0.5  # s, sample times that are read
ROWS = 1 << 16  # that become messages at once
PAUSE = 1_000_000_000  # ns between recordings in one file: longer than what a filter bridges
LAST = 2 ** 31 * 1_000_000_000  # ns: the header of a message holds no later second
EXACT = 2.0 ** 53  # ns from which on a double rounds
DROPOUT = 3.0      # sample times between two samples that are not interpolated
LARGEST = 1e15     # of a value: no signal of a drive is beyond it
ZONE = re.compile(r'\s*(Z|[+-]\d\d:?\d\d)$')


@dataclass(frozen=True)
class Signals:
    """Stamps [N] in ns, values {name: float [N]} in SI units at them, NaN: not measured."""

    stamp_ns: Integers
    values: Dict[str, Array]
    notes: tuple[str, ...] = ()

    def parts(self) -> Iterator['Signals']:
        """Yield the samples in parts of ROWS."""
        for k in range(0, len(self.stamp_ns), ROWS):
            rows = slice(k, k + ROWS)
            yield Signals(self.stamp_ns[rows], {name: x[rows] for name, x in self.values.items()})

    def __getitem__(self, name: str) -> Array:
        """Return the signal `name` [N], NaN throughout where it is not recorded."""
        return self.values.get(name, np.full(len(self.stamp_ns), np.nan))


def is_streamed(table: Table, mapping: Mapping) -> bool:
    """Return whether `mapping` reads the text `table` block by block, without all of its rows."""
    return (table.streamed and mapping.time.segment is None
            and mapping.time.stamps == 'recorded'
            and all(signal.time is None for signal in mapping.signals.values())
            and not set(_integrated_names(mapping)))


def signals_of(table: Table, mapping: Mapping) -> Signals:
    """
    Return the Signals of a recording, all on its first clock.

    Args:
        table: of the file.
        mapping: how it is read.

    Raises:
        InputError: it names line or row, column, value and what was expected.
    """
    notes: list[str] = []
    first, *further = [_one_clock(table, mapping, time, names, notes)
                       for time, names in _clocks(mapping)]
    _require_plausible(table.path, first.stamp_ns, mapping.time)
    values = dict(first.values)
    for part in further:
        values.update(_at(table.path, first.stamp_ns, part, notes))
    for name, velocity in _integrated_names(mapping).items():
        values[name] = _integrated(first.stamp_ns, values[velocity])
        notes.append(f'{name}: integrated from {velocity}, from 0: its zero is arbitrary and an '
                     'offset of the velocity makes it drift')
    stamps = _begun(first.stamp_ns)
    return Signals(stamps, values, (*table.notes, *notes))


def signal_blocks(table: Table, mapping: Mapping) -> Iterator[Signals]:
    """Yield the Signals of a table that `is_streamed`, block by block. Raises InputError."""
    shift: int | None = None
    for part, *_ in _parts(table, mapping, *_clocks(mapping)[0]):
        if not len(part.stamp_ns):
            continue
        if shift is None:
            _require_plausible(table.path, part.stamp_ns, mapping.time)
            shift = int(_begun(part.stamp_ns[:1])[0] - part.stamp_ns[0])
        yield Signals(part.stamp_ns + shift, part.values)


def _clocks(mapping: Mapping) -> list[tuple[TimeMapping, list[str]]]:
    """Return [(time, names of its signals)]: first those of the common time."""
    common = [name for name, signal in mapping.signals.items() if signal.time is None]
    own = [(signal.time, [name]) for name, signal in mapping.signals.items()
           if signal.time is not None]
    return [*([(mapping.time, common)] if common else []), *own]


def _read(table: Table, mapping: Mapping, time: TimeMapping, names: Iterable[str]
          ) -> Iterator[tuple[RowBlock, dict[str, str]]]:
    """Yield (block, {signal, 'time', 'nanosec' or 'segment': column in it})."""
    columns = {name: table.find(mapping.signals[name].column, f'{key_of(name)}.column')
               for name in names}
    texts = set()
    for part in ('column', 'nanosec', 'segment'):
        place = getattr(time, part)
        if place is None:
            continue
        column = columns['time' if part == 'column' else part] = table.find(place, f'time.{part}')
        if column.values.dtype.kind == 'U' or part != 'segment' and table.rows is not None and (
                time.scale == 1.0 and time.unit != 'iso8601' and np.nanmax(np.abs(
                    column.values), initial=0.0) * units_of(TIME)[
                        'ns' if part == 'nanosec' else time.unit] > EXACT):
            texts.add(column.name)
    for name in set(columns) - {'time', 'nanosec', 'segment'}:
        if columns[name].values.dtype.kind not in 'iuf':
            raise InputError(f'{table.path}: column {columns[name].name} ({key_of(name)}): no '
                             'numbers, expected a column of numbers')
    numbers = {column.name for column in columns.values()} - texts
    for block in table.blocks(numbers, texts):
        yield block, {name: column.name for name, column in columns.items()}


def _parts(table: Table, mapping: Mapping, time: TimeMapping, names: list[str]
           ) -> Iterator[tuple[Signals, AnyArray, int]]:
    """Yield (signals `names` of one clock, segment of each row, rows so far), block by block."""
    zeros: dict[str, float] = {}
    count, sparse = 0, len(_clocks(mapping)) > 1
    for block, columns in _read(table, mapping, time, names):
        converted = {name: _converted(table.path, mapping, name, block, columns[name], zeros)
                     for name in names}
        stamps, rows = _stamps(table.path, block, columns, time, count, mapping)
        count += len(block.numbers)
        keep = np.full(len(rows), True)
        if sparse:  # empty cells where another curve has its samples
            keep = np.any([np.isfinite(converted[name]) for name in names], axis=0)[rows]
        segments = block.values[columns['segment']] if 'segment' in columns else np.zeros(
            len(block.numbers))
        if time.only is not None:
            keep = keep & (segments[rows] == time.only)
        yield Signals(stamps[keep], {name: x[rows[keep]] for name, x in converted.items()}), \
            segments[rows[keep]], count


def _one_clock(table: Table, mapping: Mapping, time: TimeMapping, names: list[str],
               notes: list[str]) -> Signals:
    """Return the signals `names` of one clock."""
    parts, segments, counts = zip(*_parts(table, mapping, time, names))
    stamps = np.concatenate([part.stamp_ns for part in parts])
    if len(stamps) < MIN_SAMPLES:
        raise InputError(f'{table.path}: {len(stamps)} samples of {", ".join(names)[:200]}, '
                         f'expected at least {MIN_SAMPLES}')
    if time.segment is not None:
        stamps, note = in_one_line(stamps, np.concatenate(segments))
        notes += note
    if time.stamps == 'even':
        stamps, note = even_stamps(table.path, stamps)
        notes += note
    lost = counts[-1] - len(stamps)
    if lost and len(_clocks(mapping)) < 2 and time.only is None:
        notes.append(f'time: {lost} rows without a time are left out')
    return Signals(stamps, {name: np.concatenate([part.values[name] for part in parts])
                            for name in names})


# --- times --------------------------------------------------------------------------------------
def _stamps(path: Path, block: RowBlock, columns: Dict[str, str], time: TimeMapping, begun: int,
            mapping: Mapping) -> tuple[Integers, Integers]:
    """Return (stamps in ns, rows of `block` that have one); begun: rows before it."""
    if time.rate is not None:
        rows: Integers = np.arange(len(block.numbers))
        return np.rint((rows + begun) * (1e9 / time.rate)).astype(np.int64), rows
    raw = block.values[columns['time']]
    if raw.dtype.kind == 'M':
        rows = np.flatnonzero(~np.isnat(raw))
    elif raw.dtype.kind == 'U':
        rows = np.flatnonzero(raw != '')
    else:
        rows = np.flatnonzero(~np.isnan(raw.astype(float)))

    def place(row: int, name: str = columns['time']) -> str:
        return block.place(int(rows[row]), name)
    stamps = absolute_ns(path, raw[rows], time, place)
    if 'nanosec' in columns:
        stamps = stamps + absolute_ns(path, block.values[columns['nanosec']][rows], replace(
            time, unit='ns', scale=1.0), lambda row: place(row, columns['nanosec']))
    return stamps, rows


def absolute_ns(path: Path, raw: AnyArray, time: TimeMapping, place: Callable[[int], str]
                ) -> Integers:
    """
    Return stamps, int64 [N], as whole nanoseconds of the recording's own clock.

    Args:
        path: of the recording, for messages.
        raw: times [N] as recorded: numbers, texts or datetime64.
        time: their unit and scale.
        place: names the place of a row, for messages.

    Raises:
        InputError: a time is not a number or date, or outside the range of stamps.
    """
    def refused(row: int, ns: float) -> InputError:
        return InputError(f'{path}: {place(row)}: {raw[row]}: stamp {ns * 1e-9:.9g} s, expected '
                          'one > 0 and < 2^31 s (time.unit: ms, us or ns?)')
    if raw.dtype.kind == 'M':
        nanoseconds: Integers = raw.astype('M8[ns]').astype(np.int64)
        return nanoseconds
    if raw.dtype.kind == 'U':
        stamps = []
        for row, text in enumerate(raw.tolist()):
            try:
                stamps.append(_date_ns(text) if time.unit == 'iso8601' else _decimal_ns(
                    text, units_of(TIME)[time.unit], time.scale))
            except (ValueError, InvalidOperation):
                expected = 'a date such as 2026-03-01T12:00:00.001' \
                    if time.unit == 'iso8601' else 'a number'
                raise InputError(f'{path}: {place(row)}: {text[:40]!r}, expected '
                                 f'{expected}') from None
            if not -LAST < stamps[-1] < LAST:
                raise refused(row, stamps[-1])
        return np.array(stamps, np.int64)
    if time.unit == 'iso8601':
        raise InputError(f'{path}: {place(0)}: {raw[0]:.12g}, expected a date such as '
                         '2026-03-01T12:00:00.001 (time.unit: iso8601)')
    factor = time.scale * units_of(TIME)[time.unit]
    with np.errstate(over='ignore', invalid='ignore'):
        implausible = np.flatnonzero(~(np.abs(raw.astype(float)) * factor < LAST))
    if len(implausible):
        raise refused(int(implausible[0]), float(raw[implausible[0]]) * factor)
    if raw.dtype.kind == 'i' and time.scale == 1.0:
        return raw * np.int64(units_of(TIME)[time.unit])
    if not len(raw):
        return np.empty(0, np.int64)
    first = float(raw[0])
    relative: Integers = np.rint((raw - first) * factor).astype(np.int64)
    return relative + round(first * factor)


def _date_ns(text: str) -> int:
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


def _decimal_ns(text: str, unit: float, scale: float) -> int:
    number = Decimal(text.replace(',', '.'))
    if not number.is_finite() or abs(number) > LAST:
        raise ValueError('no finite number')
    return round(number * Decimal(scale) * int(unit))


def _begun(stamps: Integers) -> Integers:
    """Return dates as they are, other times from FIRST_STAMP_NS on."""
    low = int(stamps.min())
    return stamps if low >= EPOCH else stamps - (low - FIRST_STAMP_NS)


def _require_plausible(path: Path, stamp_ns: Integers, time: TimeMapping) -> None:
    """Refuse times that were read in a wrong unit. Raises InputError."""
    step = float(np.median(np.abs(np.diff(stamp_ns)))) * 1e-9
    if not SHORTEST <= step <= LONGEST and len(np.unique(stamp_ns)) > 0.5 * len(stamp_ns):
        cure = 'is time.rate right?' if time.rate else \
            f'time read in {time.unit}: is time.unit right?'
        raise InputError(f'{path}: {len(stamp_ns)} samples, one per {step:.6g} s, expected one '
                         f'per {SHORTEST:g} to {LONGEST:g} s ({cure})')


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
        'end of the previous one (--episode N reads one of them)']


def even_stamps(path: Path, stamp_ns: Integers) -> tuple[Integers, list[str]]:
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
        raise InputError(f'{path}: --stamps even: {int((step < 0).sum())} stamps go back and '
                         f'{int((step == 0).sum())} of {len(stamp_ns)} repeat, expected stamps '
                         'that grow on the whole')
    even = evened(stamp_ns)
    shift = float(np.abs(even - stamp_ns).max()) * 1e-9
    rate = (len(even) - 1) / (float(even[-1] - even[0]) * 1e-9)
    return even, [f'time: stamps laid on an even grid of {rate:.5g} Hz on average, moved by up to '
                  f'{shift:.3g} s']


# --- values -------------------------------------------------------------------------------------
def _converted(path: Path, mapping: Mapping, name: str, block: RowBlock, column: str,
               zeros: dict[str, float]) -> Array:
    """Return the values of signal `name` in SI units on the arm side; zeros: those of 'first'."""
    signal, raw = mapping.signals[name], block.values[column].astype(float)

    def refuse(wrong: Flags, expected: str) -> None:
        rows = np.flatnonzero(wrong)
        if len(rows):
            raise InputError(f'{path}: {block.place(int(rows[0]), column)} ({key_of(name)}): '
                             f'{raw[rows[0]]:.12g}, expected {expected}')
    missing = np.isnan(raw)
    refuse(np.abs(raw) > LARGEST, 'a finite number')
    value: Array = raw
    if signal.bits:
        full = 2.0 ** signal.bits
        refuse(~missing & ((raw < 0) | (raw >= full) | (raw != np.floor(raw))),
               f'an integer from 0 to {int(full) - 1}')
        negative = full / 2 - raw if signal.coding == 'sign_magnitude' else raw - full
        value = np.where(raw >= full / 2, negative, raw)
    zero = signal.zero
    if zero == 'first':
        if name not in zeros and not missing.all():
            zeros[name] = float(value[~missing][0])
        zero = zeros.get(name, 0.0)
    value = ((value - float(zero)) * signal.scale + signal.offset) * signal.factor()
    kind = kind_of(name)
    if kind.motor_side:
        ratio = mapping.gear_ratio
        value = value * ratio if kind.quantity == EFFORT else value / ratio
    return value


def effort_unit(signal: SignalMapping | None) -> str:
    """Return the unit of an effort that no constant has made a torque, '' of a torque."""
    return '' if signal is None or signal.complete else standard_unit(signal.unit)


def interpolated(stamp_ns: Integers, own_ns: Integers, values: Array) -> Array:
    """
    Return a signal at other stamps, linearly interpolated.

    Args:
        stamp_ns: int64 [N], of the samples that are asked for.
        own_ns: int64 [M], of the signal; of samples in disorder or with one stamp the first count.
        values: float [M], NaN = not measured.

    Returns:
        float [N], NaN outside of the signal and within its dropouts.
    """
    own_ns, rows = np.unique(own_ns, return_index=True)
    values = values[rows]
    valid = ~np.isnan(values)
    if valid.sum() < 2:
        return np.full(len(stamp_ns), np.nan)
    own, y = (own_ns[valid] - own_ns[0]).astype(float), values[valid]
    at = (stamp_ns - own_ns[0]).astype(float)
    following = np.clip(np.searchsorted(own, at), 1, len(own) - 1)
    step = np.median(np.diff(own_ns))
    hole = (own[following] - own[following - 1] > DROPOUT * step) & (at != own[following]) & (
        at != own[following - 1])
    result: Array = np.interp(at, own, y)
    result[(at < own[0]) | (at > own[-1]) | hole] = np.nan
    return result


def _at(path: Path, stamps: Integers, part: Signals, notes: list[str]
        ) -> Iterator[tuple[str, Array]]:
    """Yield (name, values) of `part` at `stamps`; say what was not covered."""
    for clock in (stamps, part.stamp_ns):
        if np.diff(clock).min(initial=0) < -PAUSE and not np.array_equal(stamps, part.stamp_ns):
            raise InputError(f'{path}: {", ".join(part.values)}: the time starts again, expected '
                             'one run where signals have clocks of their own')
    for name, values in part.values.items():
        result = interpolated(stamps, part.stamp_ns, values)
        count = int(np.isfinite(result).sum())
        if count < MIN_SAMPLES:
            raise InputError(f'{path}: {name}: measured at {count} of {len(stamps)} stamps, '
                             f'expected clocks with at least {MIN_SAMPLES} in common')
        if not np.array_equal(stamps, part.stamp_ns):
            notes.append(f'{name}: {len(values)} samples of another clock, interpolated')
        yield name, result


def _integrated_names(mapping: Mapping) -> dict[str, str]:
    """Return {position that is missing: the velocity that it is integrated from} of a drive."""
    every = mapping.signals
    return {f'{side}_position': f'{side}_velocity' for side in ('motor', 'arm')
            if f'{side}_velocity' in every and f'{side}_position' not in every}


def _integrated(stamps: Integers, velocity: Array) -> Array:
    """Return the integral of `velocity` [N] from 0 by the trapezoidal rule, NaN where it is."""
    valid = ~np.isnan(velocity)
    position = np.full(len(velocity), np.nan)
    if valid.any():
        step, v = np.diff(stamps[valid]) * 1e-9, velocity[valid]
        position[valid] = np.concatenate([[0.0], np.cumsum(step * (v[1:] + v[:-1]) / 2.0)])
    return position


# --- the bag of a table ------------------------------------------------------------------------
JOINT_TOPIC, SETPOINT_TOPIC = '/joint_states', '/joint_setpoints'
REFERENCE_TOPIC = '/reference/transmission_state'


def bag_of_table(table: Table, mapping: Mapping) -> VirtualBag:
    """Return the bag of a table as `mapping` reads it. Raises InputError."""
    topics = _signals_of_topics(mapping)
    if is_streamed(table, mapping):
        parts: Callable[[], Iterator[Signals]] = partial(signal_blocks, table, mapping)
        notes, (count, begin, end) = table.notes, _extent(table, mapping)
    else:
        signals = signals_of(table, mapping)
        parts, notes, count = signals.parts, signals.notes, len(signals.stamp_ns)
        begin, end = int(signals.stamp_ns[0]), int(signals.stamp_ns.max())

    def chunks() -> Iterator[Sequence[Frames]]:
        latest = 0
        for part in parts():
            frames = _frames(part, topics, latest)
            latest = int(frames[0].log_ns[-1])
            yield frames
    bag = VirtualBag(table.path, dict.fromkeys(topics, count), chunks, (begin, end), notes)
    bag.arm_side, bag.axis = True, mapping.kind  # whatever the model's gear ratio
    bag.effort_units = {
        name.rpartition(':')[0] or 'motor': unit for name, signal in mapping.signals.items()
        if name.endswith((':effort', 'motor_effort')) and (unit := effort_unit(signal))}
    return bag


def _signals_of_topics(mapping: Mapping) -> dict[str, dict[str, dict[str, str]]]:
    """Return {topic: {joint: {field: signal}}} of the topics that `mapping` reads signals of."""
    if mapping.joints:
        topics = {JOINT_TOPIC: {joint: {field: f'{joint}:{field}' for field in FIELDS}
                                for joint in mapping.joints},
                  SETPOINT_TOPIC: {joint: {'position': f'{joint}:setpoint'}
                                   for joint in mapping.joints}}
    else:
        sides = {side: {field: f'{side}_{field}' for field in FIELDS} for side in ('motor', 'arm')}
        if 'motor_setpoint' in mapping.signals:
            sides['setpoint'] = {'position': 'motor_setpoint'}
        topics = {JOINT_TOPIC: sides,
                  REFERENCE_TOPIC: {'transmission': {'effort': 'reference_torque'}}}
    return {topic: joints for topic, joints in topics.items()
            if any(name in mapping.signals for own in joints.values() for name in own.values())}


def _extent(table: Table, mapping: Mapping) -> tuple[int, int, int]:
    """Return (number of rows, first and last stamp) of a text that is read in blocks."""
    first = next(signal_blocks(table, mapping)).stamp_ns
    per_row = (int(first[-1]) - int(first[0])) / max(len(first) - 1, 1)
    with table.path.open('rb') as stream:
        count = sum(piece.count(b'\n') for piece in iter(lambda: stream.read(1 << 20), b''))
    return count, int(first[0]), int(first[0] + count * per_row)


def _frames(part: Signals, topics: Dict[str, Dict[str, Dict[str, str]]], latest: int
            ) -> list[Frames]:
    """Return the messages of signals; their log times are not before `latest`."""
    log_ns: Integers = np.maximum(np.maximum.accumulate(part.stamp_ns), latest)
    none = np.broadcast_to(np.nan, len(log_ns))
    return [Frames(topic, tuple(joints), part.stamp_ns, log_ns, {
        field: np.column_stack([part.values.get(own.get(field, ''), none)
                                for own in joints.values()]) for field in FIELDS})
            for topic, joints in topics.items()]
