# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Convert foreign recordings into samples in SI units, and these into a bag.

The bag holds ``joint_states`` with the joints ``motor`` and ``arm`` (NaN = not measured) and the
reference torque, if recorded, on ``reference/transmission_state``. A reference serves fits and
scores and is never an input of the estimator.
"""
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import AnyArray, Array, Flags, Integers
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.importer.clocks import estimated_lag, interpolated
from gearbox_monitor.recordings.importer.columns import read_columns
from gearbox_monitor.recordings.importer.mapping import (
    bound_to, FIRST_STAMP_NS, ImportMapping, load_mapping, signal_kind, SIGNALS, TimeMapping)
from gearbox_monitor.recordings.importer.raw_columns import MIN_SAMPLES, RawColumns
from gearbox_monitor.recordings.importer.robot_recording import (
    JOINT_TOPIC, robot_recording, RobotRecording, Topic, write_topics)
from gearbox_monitor.recordings.importer.stamp_policy import (
    absolute_ns, even_stamps, in_one_line, ordered, require_plausible)
from gearbox_monitor.recordings.importer.unit_table import standard_unit

__all__ = [
    'FIRST_STAMP_NS',
    'ImportedRecording',
    'RobotRecording',
    'load_mapping',
    'read_any',
    'read_recording',
    'write_imported_bag',
]

REFERENCE_TOPIC = '/reference/transmission_state'


@dataclass(frozen=True)
class ImportedRecording:
    """
    Samples [N] of one drive: rad (or m), rad/s (m/s) and N m (N); NaN where not measured.

    `stamp_ns` is int64 and strictly increasing. `reference_torque` is None when there is none.
    `notices` are sentences about the data that its owner should read.
    """

    stamp_ns: Integers
    motor_position: Array
    motor_effort: Array
    arm_position: Array
    arm_effort: Array
    reference_torque: Array | None
    motor_velocity: Array
    arm_velocity: Array
    motor_setpoint: Array
    notices: tuple[str, ...] = ()

    def messages(self) -> Iterator[Topic]:
        """Yield (topic, stamps, messages): joint states, and the reference torque if any."""
        none = np.full(len(self.stamp_ns), np.nan)
        columns = {'motor': (self.motor_position, self.motor_velocity, self.motor_effort),
                   'arm': (self.arm_position, self.arm_velocity, self.arm_effort)}
        if not np.isnan(self.motor_setpoint).all():
            columns['setpoint'] = self.motor_setpoint, none, none
        position, velocity, effort = map(np.column_stack, zip(*columns.values()))
        yield JOINT_TOPIC, self.stamp_ns, encode_joint_states(
            self.stamp_ns, list(columns), position,
            None if np.isnan(velocity).all() else velocity, effort)
        if self.reference_torque is not None:
            yield REFERENCE_TOPIC, self.stamp_ns, encode_joint_states(
                self.stamp_ns, ['transmission'], none[:, None],
                effort=self.reference_torque[:, None])


@dataclass(frozen=True)
class ClockSignals:
    """Signals in SI units that one clock has stamped: {name: float [N]}, stamps in its own ns."""

    stamp_ns: Integers
    values: Mapping[str, Array]


def read_recording(path: str | Path, mapping: ImportMapping) -> ImportedRecording:
    """
    Return the recording of a drive in the file `path` as `mapping` reads it.

    Raises InputError that names file, line or entry, value and expected value.
    """
    recording = read_any(path, mapping)
    if isinstance(recording, RobotRecording):
        raise InputError(f'{mapping.source}: joints: a robot, expected the signals of a drive')
    return recording


def read_any(path: str | Path, mapping: ImportMapping) -> ImportedRecording | RobotRecording:
    """
    Return the recording in the file `path` as `mapping` reads it: of a drive, or of a robot.

    Raises InputError that names file, line or entry, value and expected value.
    """
    mapping = bound_to(mapping, path)
    notices: list[str] = []
    stamps, values = _signals(path, mapping, notices)
    if mapping.joints:
        return robot_recording(mapping.joints, stamps, values, notices)
    return _of_drive(stamps, values, notices)


def _signals(path: str | Path, mapping: ImportMapping, notices: list[str]
             ) -> tuple[Integers, dict[str, Array]]:
    """Return (stamps [N], {signal: values [N]}) of a recording, all on its first clock."""
    first, *further = _signals_by_clock(path, mapping, notices)
    require_plausible(path, first.stamp_ns, '' if mapping.time.rate else mapping.time.unit)
    values = dict(first.values)
    for part in further:
        values.update(_on_stamps(path, first.stamp_ns, part, notices))
    if mapping.second_file:
        values.update(_of_second_file(path, mapping, ClockSignals(first.stamp_ns, values),
                                      notices))
    stamps = first.stamp_ns
    if mapping.time.start_stamp_ns != 'recorded':
        stamps = stamps - stamps[0] + int(mapping.time.start_stamp_ns)
    for stamp in (stamps[0], stamps[-1]):
        if not 1 <= stamp < 2 ** 31 * 1_000_000_000:
            raise InputError(f'{path}: time: stamp {stamp * 1e-9:.9g} s, expected one > 0 and < '
                             '2^31 s (time.start_stamp_ns)')
    notices += _described(values, stamps)
    return stamps, values


def _of_drive(stamps: Integers, values: dict[str, Array], notices: list[str]
              ) -> ImportedRecording:
    """Return the recording of one drive; a position that is missing is integrated."""
    for side in ('motor', 'arm'):
        velocity = values.get(f'{side}_velocity')
        if velocity is not None and f'{side}_position' not in values:
            values[f'{side}_position'] = _integrated(stamps, velocity)
            notices.append(f'{side}_position: integrated from {side}_velocity, from 0: its zero '
                           'is arbitrary and an offset of the velocity makes it drift')
    signals = {name: values.get(name, np.full(len(stamps), np.nan)) for name in SIGNALS
               if name != 'reference_torque'}
    return ImportedRecording(stamp_ns=stamps, reference_torque=values.get('reference_torque'),
                             notices=tuple(notices), **signals)


def _signals_by_clock(path: str | Path, mapping: ImportMapping, notices: list[str]
                      ) -> list[ClockSignals]:
    """Return the signals of a file: first those of its common time, then those with their own."""
    raw = read_columns(path, mapping)
    notices += raw.notices
    for name, unit in raw.units.items():
        stated = standard_unit(mapping.signals[name].unit) if name in mapping.signals else ''
        if unit and stated and unit != stated:
            notices.append(f'{name}: unit {stated} in the mapping, {unit} in the recording: the '
                           'mapping counts')
    clocks: list[tuple[str, TimeMapping, list[str]]] = [('time', mapping.time, [])]
    for name, signal in mapping.signals.items():
        if signal.time is None:
            clocks[0][2].append(name)
        else:
            clocks.append((f'{name}.time', signal.time, [name]))
    if not clocks[0][2]:
        del clocks[0]
    return [_clock_signals(path, mapping, raw, clock, notices) for clock in clocks]


def _clock_signals(path: str | Path, mapping: ImportMapping, raw: RawColumns,
                   clock: tuple[str, TimeMapping, list[str]], notices: list[str]) -> ClockSignals:
    """Return the signals `clock` (name of the time, its mapping, names) of `raw`, in order."""
    key, time, names = clock
    columns = {name: raw.values[name] for name in names}
    times = raw.values.get(key)
    count = len(next(iter(columns.values())) if times is None else times)
    rows: Integers = np.arange(count)
    if key != 'time' or len(columns) < len(mapping.signals):  # unequal lengths: empty cells
        filled = np.any([_measured(column) for column in columns.values() if len(column) == count]
                        or [np.full(count, True)], axis=0)
        rows = np.flatnonzero(filled if times is None else filled & _measured(times))
    segments = raw.values.get(f'{key}.segment')
    if time.only is not None and segments is not None:
        rows = rows[segments[rows] == time.only]
    for name, column in columns.items():
        if len(column) != count:
            raise InputError(f'{path}: {raw.place(0, name)}: {len(column)} values, expected '
                             f'{count} like its time')
    if count < 1 or not len(rows):
        raise InputError(f'{path}: {len(rows)} samples of {", ".join(names)}, expected at least '
                         f'{MIN_SAMPLES}')
    if times is None:
        assert time.rate is not None  # the mapping was checked
        stamps: Integers = np.rint(np.arange(len(rows)) * (1e9 / time.rate)).astype(np.int64)
    else:
        stamps = absolute_ns(path, times[rows], time, partial(_place, raw, rows, key))
    fraction = raw.values.get(f'{key}.nanosec')
    if fraction is not None:
        stamps = stamps + absolute_ns(path, fraction[rows], replace(time, unit='ns', scale=1.0),
                                      partial(_place, raw, rows, f'{key}.nanosec'))
    if segments is not None:
        stamps, notice = in_one_line(stamps, segments[rows])
        notices += notice
    if time.stamps == 'even':
        stamps, notice = even_stamps(path, stamps)
        notices += notice
    order = ordered(path, stamps, time, lambda row: (
        f'{raw.place(int(rows[row]), key)} value '
        f'{_written(times[rows[row]]) if times is not None else stamps[row]}'))
    notices += order.notices
    values: dict[str, Array] = {}
    for name, column in columns.items():
        place = partial(_place, raw, rows, name)
        values[name] = order.apply(_convert(path, mapping, name, column[rows], place))
    return ClockSignals(order.stamp_ns, values)


def _place(raw: RawColumns, rows: Integers, name: str, row: int) -> str:
    return raw.place(int(rows[row]), name)


def _written(time: object) -> str:
    return f'{time:.12g}' if isinstance(time, np.floating) else str(time)


def _measured(column: AnyArray) -> Flags:
    if column.dtype.kind == 'f':
        return ~np.isnan(column)
    return column != '' if column.dtype.kind == 'U' else np.full(len(column), True)


def _on_stamps(path: str | Path, stamps: Integers, part: ClockSignals, notices: list[str]
               ) -> Iterator[tuple[str, Array]]:
    """Yield (name, values) of `part` at `stamps`; say what was not covered."""
    for name, values in part.values.items():
        result = interpolated(stamps, part.stamp_ns, values)
        missing = int(np.isnan(result).sum())
        if len(stamps) - missing < MIN_SAMPLES:
            raise InputError(f'{path}: {name}: measured at {len(stamps) - missing} of '
                             f'{len(stamps)} stamps, expected clocks with at least {MIN_SAMPLES} '
                             'in common')
        if not np.array_equal(stamps, part.stamp_ns):
            notices.append(f'{name}: {len(values)} samples of another clock, interpolated')
        yield name, result


def _of_second_file(path: str | Path, mapping: ImportMapping, first: ClockSignals,
                    notices: list[str]) -> Iterator[tuple[str, Array]]:
    """Yield (name, values) of the second file at the stamps of the first."""
    second = mapping.second_file
    assert second is not None
    stem = Path(path).name.partition('.')[0]
    beside = Path(path).parent / second.path.replace('{stem}', stem)
    for part in _signals_by_clock(beside, second.mapping, notices):
        require_plausible(beside, part.stamp_ns, second.mapping.time.unit)
        lag = second.lag
        if isinstance(lag, str):
            origin = int(first.stamp_ns[0])
            estimate = estimated_lag(*_aligned_pair(mapping.source, first, part, origin),
                                     f'{mapping.source}: second_file.lag')
            lag = estimate.lag
            notices.append(f'{beside.name}: its clock is {lag:+.6g} s off, which explains '
                           f'{estimate.explained:.2%} of its variance')
        shifted = part.stamp_ns + round(lag * 1e9)
        yield from _on_stamps(beside, first.stamp_ns, ClockSignals(shifted, part.values), notices)


def _aligned_pair(source: str, first: ClockSignals, second: ClockSignals, origin: int
                  ) -> tuple[tuple[Array, Array], tuple[Array, Array], bool]:
    """Return (motion, response, whether it is a position) of two files, for estimated_lag."""
    seconds = [(part.stamp_ns - origin) * 1e-9 for part in (first, second)]
    position = next((values for name, values in first.values.items()
                     if signal_kind(name).quantity == 'position'), None)
    names = sorted(second.values, key=lambda name: signal_kind(name).quantity, reverse=True)
    if position is None or signal_kind(names[0]).quantity == 'velocity':
        raise InputError(f'{source}: second_file.lag: estimated: no position in the first file '
                         'and position or effort in the second, expected a number (s)')
    return ((seconds[0], position), (seconds[1], second.values[names[0]]),
            signal_kind(names[0]).quantity == 'position')


def _described(values: Mapping[str, Array], stamps: Integers) -> Iterator[str]:
    """Yield sentences on missing and constant values and on dropouts."""
    for name, column in values.items():
        missing = int(np.isnan(column).sum())
        if missing:
            yield f'{name}: {missing} of {len(column)} samples not measured'
        if missing < len(column) and np.nanmax(column) == np.nanmin(column):
            yield f'{name}: the same value in all samples'
    step = np.diff(stamps)
    dropouts = int((step > 3 * np.median(step)).sum())
    if dropouts:
        yield (f'time: {dropouts} dropouts of more than 3 sample times, longest '
               f'{step.max() * 1e-9:.3g} s')


def _integrated(stamps: Integers, velocity: Array) -> Array:
    """Return the integral of `velocity` [N] from 0 by the trapezoidal rule, NaN where it is."""
    valid = ~np.isnan(velocity)
    position = np.full(len(velocity), np.nan)
    if valid.any():
        step, v = np.diff(stamps[valid]) * 1e-9, velocity[valid]
        position[valid] = np.concatenate([[0.0], np.cumsum(step * (v[1:] + v[:-1]) / 2.0)])
    return position


def _convert(path: str | Path, mapping: ImportMapping, name: str, raw: AnyArray,
             place: Callable[[int], str]) -> Array:
    """Return the values of signal `name` in SI units on the arm side."""
    signal = mapping.signals[name]
    raw = raw.astype(float)

    def _refuse(wrong: Flags, expected: str) -> None:
        rows = np.flatnonzero(wrong)
        if len(rows):
            raise InputError(f'{path}: {place(int(rows[0]))} value {raw[rows[0]]:.12g}: '
                             f'expected {expected}')
    missing = np.isnan(raw)
    _refuse(np.isinf(raw), 'a finite number')
    if signal.missing == 'error':
        _refuse(missing, 'a number (missing: nan admits missing ones)')
    value: Array = raw
    if signal.bits:
        full = 2.0 ** signal.bits
        _refuse(~missing & ((raw < 0) | (raw >= full) | (raw != np.floor(raw))),
                f'an integer from 0 to {int(full) - 1}')
        negative = full / 2 - raw if signal.coding == 'sign_magnitude' else raw - full
        value = np.where(raw >= full / 2, negative, raw)
    zero = signal.zero
    if zero == 'first':
        zero = 0.0 if missing.all() else value[~missing][0]
    value = ((value - float(zero)) * signal.scale + signal.offset) * signal.factor()
    quantity, _, motor_side = signal_kind(name)
    if motor_side:
        ratio = mapping.gear_ratio
        value = value * ratio if quantity == 'effort' else value / ratio
    return value


def write_imported_bag(recording: ImportedRecording | RobotRecording, bag: str | Path,
                       source: str | Path, mapping: ImportMapping) -> None:
    """
    Write a recording and, as metadata record ``import``, its origin.

    Args:
        recording: the samples.
        bag: the new bag.
        source: the file they were read from; its name and SHA-256 are recorded.
        mapping: through which they were read; it is recorded.

    Raises:
        InputError: `bag` exists or cannot be written.
    """
    write_topics(bag, source, list(recording.messages()), recording.notices,
                 mapping=mapping.yaml_text, mapping_file=Path(mapping.source).name,
                 kind=mapping.kind)
