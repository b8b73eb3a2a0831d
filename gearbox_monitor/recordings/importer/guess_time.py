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
from gearbox_monitor.recordings.importer.layout import Series
from gearbox_monitor.recordings.importer.mapping import TimeMapping
from gearbox_monitor.recordings.importer.meaning import (
    COUNTER, Meaning, meaning_of, TIMES, words_of)
from gearbox_monitor.recordings.importer.stamp_policy import absolute_ns, LONGEST, SHORTEST
from gearbox_monitor.recordings.importer.unit_table import TIME

EPOCH = 1_000_000_000_000_000_000  # ns: a stamp from 2001 on is a date
USUAL = (1e-4, 0.06)  # s: sample times of controllers and their logs
NANO = frozenset({'nsec', 'nsecs', 'nanosec', 'nanosecs', 'nanoseconds', 'nano'})
SECONDS = frozenset({'sec', 'secs', 'seconds', 's'})
MEASUREMENT = frozenset({'header', 'stamp', 'stamps'})  # words of when it was measured
EPISODES = ('episode_index', 'episode')
STEADY = 0.5  # of the mean step: spread of the steps of what grows like a time without a name


@dataclass(frozen=True)
class FoundTime:
    """
    Times [N] in s from 0, their block of the mapping, the labels of their columns and remarks.

    column: None where a rate stands in for it. start: first time on the recording's own clock, s.
    """

    t: Array
    block: dict[str, Any]
    labels: tuple[str, ...] = ()
    column: Series | None = None
    remarks: tuple[str, ...] = ()
    start: float = 0.0

    @property
    def end(self) -> float:
        """Return the last time on the recording's own clock, s."""
        return self.start + float(self.t[-1])


def found_time(path: str | Path, series: Sequence[Series], units: Mapping[str, str],
               name: str = '') -> FoundTime | None:
    """
    Return the FoundTime of a recording, None where no column grows like one.

    Dates come before names, a measurement's stamp before other times, and all of them before what
    only grows steadily; what counts rows is never a time.

    Args:
        path: of the recording, for messages.
        series: its columns.
        units: {label: unit} as the user states them.
        name: of the column, as the user states it; '' for none.
    """
    meanings = {id(column): meaning_of(column.label, column.unit) for column in series}
    episode = next((column for column in series if column.label in EPISODES
                    and len(np.unique(column.values)) > 1), None)
    candidates = [column for column in series if column.label == name or not name and (
        column.values.dtype.kind in 'UM' or meanings[id(column)].quantity not in (COUNTER,)
        and column is not episode)]
    candidates.sort(key=lambda column: -_rank(column, meanings[id(column)]))
    time: FoundTime | None = None
    for column in candidates:
        is_named = meanings[id(column)].quantity == TIMES or column.values.dtype.kind in 'UM' or (
            column.label == name)
        if time is not None and not is_named:
            break
        if set(words_of(column.label)) & NANO and not name:
            continue
        this = _as_time(path, column, series, units.get(column.label, ''), is_named, episode)
        if this is None:
            continue
        if time is not None:
            return replace(time, remarks=(
                *time.remarks, f'{column.label}: another time, not used.'))
        time = this
    return time


def _rank(column: Series, meaning: Meaning) -> float:
    """Return how much speaks for `column` as the time of the measurement."""
    words = set(words_of(column.label))
    rank = 4.0 if column.values.dtype.kind in 'UM' else 2.0 if meaning.quantity == TIMES else 0.0
    if words & MEASUREMENT:
        rank += 1.0 + 0.5 * len(words & MEASUREMENT)
    if words & {'received', 'receive', 'log', 'publish', 'bag', 'wall'}:
        rank -= 1.5
    return rank


def _as_time(path: str | Path, column: Series, series: Sequence[Series], stated: str,
             is_named: bool, episode: Series | None) -> FoundTime | None:
    """Return `column` as a time in the unit that makes sense, None: in none."""
    dates = column.values.dtype.kind == 'U'
    unit_of_name = stated or column.unit
    units = ['iso8601'] if dates else [unit for unit in (unit_of_name, *TIME) if unit in TIME]
    if not dates and not stated:
        units.sort(key=lambda unit: unit != unit_of_name and not _is_usual(column, unit))
    nano = None
    words = words_of(column.label)
    if set(words) & SECONDS and is_named and not dates:
        stem = _without(words, SECONDS)
        nano = next((other for other in series if set(words_of(other.label)) & NANO
                     and _without(words_of(other.label), NANO | SECONDS) == stem), None)
    for unit in units[:1] if stated else units:
        if nano is not None and unit != 's':
            continue
        stamps = _stamps(path, column, unit, nano)
        if stamps is None:
            continue
        starts = np.zeros(len(stamps) - 1, bool) if episode is None else \
            episode.values[1:] != episode.values[:-1]
        extra = _policies(stamps, starts, is_named)
        if extra is None:
            continue
        block = {**column.place, **({'unit': unit} if unit != 's' else {}), **extra}
        if nano is not None:
            block['nanosec'] = next(iter(nano.place.values()))
        if starts.any() and episode is not None:
            block['segment'] = next(iter(episode.place.values()))
        how = 'by its name' if is_named else 'by its steady growth'
        step = np.median(np.diff(stamps)[~starts]) * 1e-9
        remarks = [f'Time: {column.label}, {how}, in {unit}: one sample per {step:.6g} s.']
        if unit_of_name in TIME and unit != unit_of_name:
            remarks.append(f'Its name says {unit_of_name}, at which the sample time makes no '
                           'sense.')
        if extra:
            remarks.append(f'Time: {", ".join(f"{k} {v}" for k, v in extra.items())}.')
        labels = (column.label, *([nano.label] if nano is not None else []),
                  *([episode.label] if starts.any() and episode is not None else []))
        shift = np.zeros(len(stamps))
        shift[1:][starts] = -np.diff(stamps)[starts] + 1e9
        t = (stamps - stamps[0] + np.cumsum(shift)) * 1e-9
        return FoundTime(t, block, labels, column, tuple(remarks), float(stamps[0]) * 1e-9)
    return None


def _is_usual(column: Series, unit: str) -> bool:
    """Return whether the sample time is that of a controller, if `column` is in `unit`."""
    if column.values.dtype.kind not in 'iuf':
        return True
    step = np.diff(column.values[np.isfinite(column.values.astype(float))].astype(float))
    return len(step) > 0 and USUAL[0] <= float(np.median(step)) * TIME[unit] * 1e-9 <= USUAL[1]


def _without(words: Sequence[str], excluded: frozenset[str]) -> list[str]:
    return [word for word in words if word not in excluded]


def _stamps(path: str | Path, column: Series, unit: str, nano: Series | None) -> Array | None:
    """Return stamps [N] in ns of `column` read in `unit`; None: it holds none."""
    try:
        stamps = absolute_ns(path, column.values, TimeMapping(unit=unit), str)
        if nano is not None:
            stamps = stamps + absolute_ns(path, nano.values, TimeMapping(unit='ns'), str)
    except InputError:
        return None
    return stamps.astype(float)


def _policies(stamps: Array, starts: Flags, is_named: bool) -> dict[str, Any] | None:
    """Return further keys of the mapping for `stamps`, None: they are no times."""
    step = np.diff(stamps)[~starts]
    if not len(step):
        return None
    median = float(np.median(step)) * 1e-9
    bursts = is_named and median < SHORTEST and (step >= 0).all()
    if bursts:  # stamped on receipt: the mean tells the rate
        median = float(np.mean(step)) * 1e-9
    if not SHORTEST <= median < LONGEST * 1.001 or _unordered(stamps, starts) > 0.01 or (
            (step == 0).mean() > 0.3 and not bursts):
        return None
    if not is_named and np.std(step) > STEADY * np.mean(step):
        return None
    extra: dict[str, Any] = {}
    if (step < 0).any():
        extra['unordered'] = 'sort'
    if bursts:
        extra['stamps'] = 'even'
    elif (step == 0).any() or 'unordered' in extra and len(np.unique(stamps)) < len(stamps):
        extra['repeated'] = 'first'
    if stamps[0] >= EPOCH:
        extra['start_stamp_ns'] = 'recorded'
    return extra


def _unordered(stamps: Array, starts: Flags) -> float:
    """
    Return the share of the samples that are out of order: most of them if the time restarts.

    A late sample stands behind later ones; a stamp far in the future stands before earlier ones.
    The kind that is rarer is out of order.
    """
    t = np.append(0.0, np.cumsum(np.where(starts, 0.0, np.diff(stamps))))
    behind = t < np.maximum.accumulate(t)
    ahead = t > np.minimum.accumulate(t[::-1])[::-1]
    return float(min(behind.mean(), ahead.mean()))
