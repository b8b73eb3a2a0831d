# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The column, or the two columns, that hold the time of a recording, and the unit they are in.

A robot's setpoints may be in a separate file next to its states, on the same clock. Both names
differ only in words of the vocabulary: 'run3_state_motor.csv' and
'run3_control.csv', 'joint_states.csv' and 'joint_commands.csv'.
"""
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.recordings.mapping import TimeMapping
from gearbox_monitor.recordings.meaning import (
    COUNTER, meaning_of, meanings, POSITION, run_of, SETPOINT, TIME, units_of, words_of)
from gearbox_monitor.recordings.si_signals import absolute_ns, LONGEST, SHORTEST
from gearbox_monitor.recordings.table import Column, JOINT_LIST, load_table, Table

ISO = 'iso8601'
USUAL = (1e-4, 0.06)  # s: sample times of controllers and their logs
NANO = frozenset('nsec nsecs nanosec nanosecs nanoseconds nano nanos'.split())
SECONDS = frozenset('sec secs seconds s'.split())
MEASUREMENT = frozenset('header stamp stamps'.split())  # words of when it was measured
RECEIPT = frozenset('received receive log publish bag wall'.split())
EPISODES = ('episode_index', 'episode')
TABLES = ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')
OVERLAP = 0.5  # of the time of the states, in which setpoints of the same run stand
BESIDE = 'setpoint: '  # in front of the names of columns of such a file
STEADY = 0.5  # of the mean step: spread of the steps of what grows like a time without a name


@dataclass(frozen=True)
class FoundTime:
    """
    Times [N] in s from 0, their block of the mapping, the labels of their columns and remarks.

    start: first time on the recording's own clock, s; named: a column holds them, no rate.
    """

    t: Array
    block: dict[str, Any]
    labels: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    start: float = 0.0
    named: bool = True

    @property
    def end(self) -> float:
        """Last time on the recording's own clock, s."""
        return self.start + float(self.t[-1])


def found_time(path: Path, columns: Sequence[Column], units: Mapping[str, str], name: str = ''
               ) -> FoundTime | None:
    """
    Return the FoundTime of a recording, None where no column grows like one.

    Dates come before names, a measurement's stamp before other times, and all of them before what
    only grows steadily; what counts rows is never a time.

    Args:
        path: of the recording, for messages.
        columns: of it.
        units: {label: unit} as the user states them.
        name: of the column, as the user states it; '' for none.
    """
    quantity = {c.name: meaning_of(c.name, c.unit).quantity for c in columns}
    episode = _episode(columns)
    candidates = [c for c in columns if c.name == name or not name and (
        _is_date(c) or c.values.dtype.kind in 'iuf' and quantity[c.name] != COUNTER
        and c is not episode and not NANO & set(words_of(c.name)))]
    time: FoundTime | None = None
    for column in sorted(candidates, key=lambda c: -_rank(c, quantity[c.name])):
        is_named = quantity[column.name] == TIME or _is_date(column) or column.name == name
        if time is None or is_named:
            this = _as_time(path, column, columns, units.get(column.name, ''), is_named, episode)
            if this and time:
                return replace(time, remarks=(*time.remarks,
                                              f'{column.name}: another time, not used.'))
            time = time or this
    return time


def at_rate(rate: float, columns: Sequence[Column]) -> FoundTime:
    """Return the FoundTime of `columns` [N] that are sampled at a constant `rate`, Hz."""
    episode = _episode(columns)
    labels = () if episode is None else (episode.name,)
    return FoundTime(np.arange(len(columns[0].values)) / rate,
                     {'rate': rate, **dict(zip(['segment'], labels))}, labels, named=False)


def _episode(columns: Sequence[Column]) -> Column | None:
    """Return the column that tells episodes apart, None without several."""
    return next((c for c in columns if c.name in EPISODES and len(np.unique(c.values)) > 1), None)


def _is_date(column: Column) -> bool:
    return column.values.dtype.kind in 'UM'


def _rank(column: Column, quantity: str) -> float:
    """Return how much speaks for `column` as the time of the measurement."""
    words = set(words_of(column.name))
    stamp = 1.0 + 0.5 * len(words & MEASUREMENT) if words & MEASUREMENT else 0.0
    return stamp - 1.5 * bool(words & RECEIPT) + (
        4.0 if _is_date(column) else 2.0 if quantity == TIME else 0.0)


def _as_time(path: Path, column: Column, columns: Sequence[Column], stated: str, is_named: bool,
             episode: Column | None) -> FoundTime | None:
    """Return `column` as a time in the unit that makes sense, None: in none."""
    values = column.values
    rows = np.isfinite(values) if values.dtype.kind == 'f' else np.full(len(values), True)
    if rows.mean() < 0.5:
        return None
    units, others = _units(column, rows, stated), dict[str, str]()
    nano = _nanoseconds_of(column, columns) if is_named and units != [ISO] else None
    if nano is not None:
        units, others['nanosec'] = ['s'], nano.name
    starts = np.zeros(rows.sum() - 1, bool)
    if episode is not None and len(episode.values) == len(rows):
        starts = np.diff(episode.values[rows]) != 0
        if starts.any():
            others['segment'] = episode.name
    for unit in units:
        with suppress(InputError):
            stamps = _stamps_in(path, unit, column, nano, rows)
            even = _is_even(stamps, starts, is_named)
            if even is not None:
                break
    else:
        return None
    block = {'column': column.name, **({'unit': unit} if unit != 's' else {}),
             **({'stamps': 'even'} if even else {}), **others}
    how = 'name' if is_named else 'steady growth'
    remarks = [f'Time: {column.name}, by its {how}, in {unit}: one sample per '
               f'{np.median(np.diff(stamps)[~starts]) * 1e-9:.6g} s.']
    own = stated or column.unit
    if own in units_of(TIME) and unit != own:
        remarks.append(f'Its name says {own}, at which the sample time makes no sense.')
    steps = np.where(starts, 1e9, np.diff(stamps))
    t = np.interp(np.arange(len(rows)), np.flatnonzero(rows),
                  np.append(0.0, np.cumsum(steps)) * 1e-9)
    return FoundTime(t, block, (column.name, *others.values()), tuple(remarks),
                     float(stamps[0]) * 1e-9)


def _units(column: Column, rows: Flags, stated: str) -> list[str]:
    """Return the unit `stated`, else all, first those that a controller would have."""
    values, known = column.values, units_of(TIME)
    if values.dtype.kind == 'U':
        return [ISO]
    if stated in known:
        return [stated]
    step = float(np.median(np.diff(values[rows].astype(float)))) if (
        values.dtype.kind in 'iuf' and rows.sum() > 1) else np.nan
    return sorted(known, key=lambda unit: 0 if unit == (stated or column.unit) else 2 - (
        USUAL[0] <= step * known[unit] * 1e-9 <= USUAL[1]))


def _stamps_in(path: Path, unit: str, column: Column, nano: Column | None, rows: Flags) -> Array:
    """Return the `rows` of a column in a unit, with nanoseconds, in ns. Raises InputError."""
    stamps = absolute_ns(path, column.values[rows], TimeMapping(unit=unit), str)
    if nano is not None:
        stamps = stamps + absolute_ns(path, nano.values[rows], TimeMapping(unit='ns'), str)
    return stamps.astype(float)


def _nanoseconds_of(column: Column, columns: Sequence[Column]) -> Column | None:
    """Return the column of the nanoseconds that belong to the seconds in `column`, if any."""
    words = set(words_of(column.name))
    return next((other for other in columns if words & SECONDS
                 and len(other.values) == len(column.values) and NANO & set(words_of(other.name))
                 and set(words_of(other.name)) - NANO - SECONDS == words - SECONDS), None)


def _is_even(stamps: Array, starts: Flags, is_named: bool) -> bool | None:
    """Return whether `stamps` want an even grid, as if stamped on receipt; None: no times."""
    step = np.diff(stamps)[~starts]
    if len(stamps) < 3 or not len(step):
        return None
    median = float(np.median(step)) * 1e-9
    bursts = bool(is_named and median < SHORTEST and (step >= 0).all())
    if bursts:  # stamped on receipt: the mean tells the rate
        median = float(np.mean(step)) * 1e-9
    t = np.append(0.0, np.cumsum(np.where(starts, 0.0, np.diff(stamps))))
    # A late sample stands behind later ones, a stamp far in the future before earlier ones; the
    # kind that is rarer is out of order. Most of them are if the time restarts.
    unordered = min(float((t < np.maximum.accumulate(t)).mean()),
                    float((t > np.minimum.accumulate(t[::-1])[::-1]).mean()))
    refused = not SHORTEST <= median < LONGEST * 1.001 or unordered > 0.01 or (
        (step == 0).mean() > 0.3 and not bursts) or (
        not is_named and np.std(step) > STEADY * np.mean(step))
    return None if refused else bursts


# --- setpoints of a robot in a file of their own, on the same clock ----------------------------
def _files_beside(path: Path, setpoints: bool) -> list[Path]:
    """Return the files with `setpoints`, or states, of the run whose other ones `path` holds."""
    own, run = run_of(path.name.partition('.')[0])
    return [] if own == setpoints else sorted(
        file for file in path.absolute().parent.iterdir() if file.suffixes == path.suffixes
        and file.is_file() and run_of(file.name.partition('.')[0]) == (setpoints, run))


Motion: TypeAlias = tuple[Table, FoundTime, dict[str, Column]]  # position of each joint


def _motion_of(table: Table, foreign: str | None = None) -> Motion | None:
    """Return the positions in a table; None: no time, or one whose source is `foreign`."""
    time = found_time(table.path, table.columns, {})
    if time is None or not time.named:
        return None
    columns = [c for c in table.columns if c.values.dtype.kind in 'iuf'
               and c.name not in time.labels]
    listed = meanings([c.name for c in columns], [c.unit for c in columns], table.joints)
    positions = [(m, c) for m, c in zip(listed, columns) if m.quantity == POSITION]
    return None if any(m.source == foreign for m, _ in positions) else (
        table, time, {m.joint: c for m, c in positions})


def _motions_beside(table: Table, setpoints: bool) -> list[Motion]:
    """Return the motions of the same joints and time in files beside, of `setpoints` or states."""
    files, fitting = _files_beside(table.path, setpoints), []
    own = _motion_of(table, SETPOINT if setpoints else None) if files else None
    for file in files if own and len(own[2]) > 1 else ():
        with suppress(InputError):
            sibling = _motion_of(load_table(file, whole=True))
            if own and sibling and set(sibling[2]) == set(own[2]) and min(
                    own[1].end, sibling[1].end) - max(own[1].start, sibling[1].start) >= (
                    OVERLAP * (own[1].end - own[1].start)):
                fitting.append(sibling)
    return fitting


def states_beside(table: Table) -> str:
    """Return the name of a file with the states whose setpoints a table holds, '' for none."""
    return next((sibling.path.name for sibling, *_ in _motions_beside(table, False)), '')


def with_setpoints(table: Table) -> Table:
    """
    Return the `table` of a robot's states with the setpoints in a file beside it, if there is one.

    The names of their columns begin with BESIDE. Raises Undecided: several files have them.
    """
    fitting = _motions_beside(table, True)
    names = ', '.join(sibling.path.name for sibling, *_ in fitting)
    if len(fitting) > 1:
        raise Undecided(f'{table.path}: {names}: setpoints of the same joints and time beside it, '
                        'expected --use setpoint=none, or one of the files')
    for sibling, time, positions in fitting:
        table = load_table(table.path, whole=True) if table.streamed else table
        clocks = [c for c in sibling.columns if c.name in time.labels]
        table = replace(table, rows=None, streamed=False, columns=(*table.columns, *(
            replace(c, name=BESIDE + c.name) for c in clocks), *(
            replace(c, name=BESIDE + c.name, clock=BESIDE + time.labels[0])
            for c in positions.values())),
            notes=(*table.notes, f'setpoints: {names} beside it, on the same clock'))
    return table


def file_in(path: Path) -> Path:
    """Return the file of a recording: `path`, or the only one in the folder `path`."""
    if not path.is_dir():
        return path
    files = sorted(path.glob('data/**/*.parquet'))
    if not files:  # episodes, those with setpoints beside, or all tables
        tables = sorted(file for file in path.iterdir() if file.is_file()
                        and file.name.endswith(TABLES) and file.name != JOINT_LIST)
        files = [file for file in tables if _files_beside(file, True)] or tables
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file and no log, expected a recording')
    if len(files) != 1:
        names = ', '.join(file.name for file in files[:12])
        raise Undecided(f'{path}: {len(files)} recordings, expected the path of one of them: '
                        f'{names}')
    return files[0]
