# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The column, or the two columns, that hold the time of a recording, and the unit they are in."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.recordings.log_units import TIME, units_of
from gearbox_monitor.recordings.mapping import TimeMapping
from gearbox_monitor.recordings.meaning import COUNTER, Meaning, meaning_of, words_of
from gearbox_monitor.recordings.si_signals import absolute_ns, LONGEST, SHORTEST
from gearbox_monitor.recordings.table import Column

USUAL = (1e-4, 0.06)  # s: sample times of controllers and their logs
NANO = frozenset('nsec nsecs nanosec nanosecs nanoseconds nano nanos'.split())
SECONDS = frozenset('sec secs seconds s'.split())
MEASUREMENT = frozenset('header stamp stamps'.split())  # words of when it was measured
RECEIPT = frozenset('received receive log publish bag wall'.split())
EPISODES = ('episode_index', 'episode')
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
    meaning = {c.name: meaning_of(c.name, c.unit) for c in columns}
    episode = next((c for c in columns if c.name in EPISODES and len(np.unique(c.values)) > 1),
                   None)
    candidates = [c for c in columns if c.name == name or not name and (
        _is_date(c) or c.values.dtype.kind in 'iuf' and meaning[c.name].quantity != COUNTER
        and c is not episode)]
    candidates.sort(key=lambda c: -_rank(c, meaning[c.name]))
    time: FoundTime | None = None
    for column in candidates:
        is_named = meaning[column.name].quantity == TIME or _is_date(column) or (
            column.name == name)
        if time is not None and not is_named:
            break
        if set(words_of(column.name)) & NANO and not name:
            continue
        this = _as_time(path, column, columns, units.get(column.name, ''), is_named, episode)
        if this is not None and time is not None:
            return replace(time, remarks=(*time.remarks,
                                          f'{column.name}: another time, not used.'))
        time = time or this
    return time


def _is_date(column: Column) -> bool:
    return column.values.dtype.kind in 'UM'


def _rank(column: Column, meaning: Meaning) -> float:
    """Return how much speaks for `column` as the time of the measurement."""
    words = set(words_of(column.name))
    rank = 4.0 if _is_date(column) else 2.0 if meaning.quantity == TIME else 0.0
    if words & MEASUREMENT:
        rank += 1.0 + 0.5 * len(words & MEASUREMENT)
    return rank - 1.5 * bool(words & RECEIPT)


def _as_time(path: Path, column: Column, columns: Sequence[Column], stated: str, is_named: bool,
             episode: Column | None) -> FoundTime | None:
    """Return `column` as a time in the unit that makes sense, None: in none."""
    dates = column.values.dtype.kind == 'U'
    unit_of_name = stated or column.unit
    units = ['iso8601'] if dates else list(dict.fromkeys(
        unit for unit in (unit_of_name, *units_of(TIME)) if unit in units_of(TIME)))
    if not dates and not stated:
        units.sort(key=lambda unit: unit != unit_of_name and not _is_usual(column, unit))
    nano, words = None, words_of(column.name)
    if set(words) & SECONDS and is_named and not dates:
        stem = [word for word in words if word not in SECONDS]
        nano = next((other for other in columns if set(words_of(other.name)) & NANO and [
            w for w in words_of(other.name) if w not in NANO | SECONDS] == stem), None)
    for unit in units[:1] if stated else units:
        if nano is not None and unit != 's':
            continue
        found = _stamps(path, column, unit, nano)
        if found is None or len(found[0]) < 3:
            continue
        stamps, rows = found
        starts = np.zeros(len(stamps) - 1, bool)
        if episode is not None and len(episode.values) == len(rows):
            starts = np.diff(episode.values[rows]) != 0
        even = _is_even(stamps, starts, is_named)
        if even is None:
            continue
        block: dict[str, Any] = {'column': column.name, **({'unit': unit} if unit != 's' else {}),
                                 **({'stamps': 'even'} if even else {})}
        if nano is not None:
            block['nanosec'] = nano.name
        if starts.any() and episode is not None:
            block['segment'] = episode.name
        how = 'by its name' if is_named else 'by its steady growth'
        step = np.median(np.diff(stamps)[~starts]) * 1e-9
        remarks = [f'Time: {column.name}, {how}, in {unit}: one sample per {step:.6g} s.']
        if unit_of_name in units_of(TIME) and unit != unit_of_name:
            remarks.append(f'Its name says {unit_of_name}, at which the sample time makes no '
                           'sense.')
        labels = (column.name, *([nano.name] if nano is not None else []),
                  *([episode.name] if starts.any() and episode is not None else []))
        shift = np.zeros(len(stamps))
        shift[1:][starts] = -np.diff(stamps)[starts] + 1e9
        t = np.interp(np.arange(len(rows)), np.flatnonzero(rows), (
            stamps - stamps[0] + np.cumsum(shift)) * 1e-9)
        return FoundTime(t, block, labels, tuple(remarks), float(stamps[0]) * 1e-9)
    return None


def _is_usual(column: Column, unit: str) -> bool:
    """Return whether the sample time is that of a controller, if `column` is in `unit`."""
    if column.values.dtype.kind not in 'iuf':
        return True
    step = np.diff(column.values[np.isfinite(column.values.astype(float))].astype(float))
    return len(step) > 0 and USUAL[0] <= float(np.median(step)) * units_of(TIME)[
        unit] * 1e-9 <= USUAL[1]


def _stamps(path: Path, column: Column, unit: str, nano: Column | None
            ) -> tuple[Array, Flags] | None:
    """Return (stamps in ns of `column` read in `unit`, the rows that have one); None: no times."""
    values = column.values
    rows = np.isfinite(values) if values.dtype.kind == 'f' else np.full(len(values), True)
    if rows.mean() < 0.5 or nano is not None and len(nano.values) != len(values):
        return None
    try:
        stamps = absolute_ns(path, values[rows], TimeMapping(unit=unit), str)
        if nano is not None:
            stamps = stamps + absolute_ns(path, nano.values[rows], TimeMapping(unit='ns'), str)
    except InputError:
        return None
    return stamps.astype(float), rows


def _is_even(stamps: Array, starts: Flags, is_named: bool) -> bool | None:
    """Return whether `stamps` want an even grid, as if stamped on receipt; None: no times."""
    step = np.diff(stamps)[~starts]
    if not len(step):
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
    if not SHORTEST <= median < LONGEST * 1.001 or unordered > 0.01 or (
            (step == 0).mean() > 0.3 and not bursts):
        return None
    if not is_named and np.std(step) > STEADY * np.mean(step):
        return None
    return bursts
