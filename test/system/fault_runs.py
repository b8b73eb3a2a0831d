# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One fault, one run: what the estimator said, second by second, and what was true."""
from dataclasses import dataclass
from functools import lru_cache

from fault_stream import healthy, SECOND, SECONDS, START
import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.monitor import COMPONENTS, Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.monitored_gearbox import Silence

TRUST = (*COMPONENTS[:4], 'input')  # what speaks of the estimates of now
WRONG = 6.0  # stated standard deviations off the truth; in a healthy run none is
SETTLED = 5.0  # s after the first start: then all has been judged
GOOD_AGAIN, OK_AGAIN = 1.0, 12.0  # s
COST = 30  # samples that one event may cost beside those it spoils
# Absent states, learned curves of other models, and innovations of what was not measured, are NaN
# in a row; these never are.
ALWAYS = [c for c in range(sample_loop.N_ESTIMATE) if c not in (
    sample_loop.E_TAU_ARM, sample_loop.E_TAU_E, sample_loop.E_STD + 5, sample_loop.E_STD + 6,
    sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM, sample_loop.E_WHITE_1,
    sample_loop.E_WHITE_2, sample_loop.E_LOAD,
    *range(sample_loop.E_STIFFNESS, sample_loop.E_LEARNED_WEIGHT + 1))]
BARS = (FINITE, UNDER_OK, TOLD, GOOD, OK, LOST, BITS, QUIET) = (
    'only finite numbers', 'no wrong estimate under OK', 'told in time, and until the end',
    'good estimates soon after', 'levels OK soon after', 'few samples lost beside the spoilt',
    'same bits however cut', 'nothing told without fault')


@dataclass(frozen=True)
class Watched:
    """
    What a run gave.

    rows [M, N_ESTIMATE] estimates of the measurements `number` [M]; tick [M]: with which
    diagnostics they were judged. levels [T]: the worst of TRUST at the T-th second, by [T]: whose.
    finite: whether all numbers are; same: whether a run in one piece gives the same rows.
    """

    rows: np.ndarray
    number: np.ndarray
    tick: np.ndarray
    levels: np.ndarray
    by: list
    finite: bool
    same: bool


@lru_cache(maxsize=4)
def _healthy(rate, seed):
    return healthy(rate, seed)


def watch(messages, load):
    """Return what was Watched of a Monitor that takes Messages second by second, as the node."""
    monitor, whole, silence = (Monitor(DriveModel(), {'arm_load': load}),
                               Monitor(DriveModel(), {'arm_load': load}), Silence())
    rows, number, tick, levels, by, finite, begin = [], [], [], [], [], True, 0
    for k in range(round(SECONDS)):
        end = int(np.searchsorted(messages.at, k + 1.0 - 1e-9))
        part = slice(begin, end)
        found = monitor.run(Samples(messages.stamp_ns[part], messages.u[part], messages.y[part]))
        rows.append(found.rows)
        number.append(messages.number[part][found.codes == sample_loop.ESTIMATE])
        tick.append(np.full(len(found.rows), k))
        said = silence.outcomes(monitor, (k + 2) * SECOND)
        level = max(said[name].level for name in TRUST)
        levels.append(int(level))
        by.append([name for name in TRUST if said[name].level == level > Level.OK])
        finite &= bool(np.isfinite(found.rows[:, ALWAYS]).all()
                       and not np.isinf(found.rows).any() and np.isfinite(found.smoothed).all())
        finite &= all(np.isfinite(value) for outcome in said.values()
                      for value in outcome.values.values() if isinstance(value, float))
        begin = end
    rows = np.concatenate(rows)
    same = whole.run(Samples(messages.stamp_ns, messages.u, messages.y)).rows
    return Watched(rows, np.concatenate(number), np.concatenate(tick), np.array(levels), by,
                   finite, np.array_equal(rows, same, equal_nan=True))


def run_case(case, load, seed=0):
    """Return the row of `case` (fault_cases.Case) with this arm_load, as plain data."""
    base, truth = _healthy(case.rate, seed)
    messages = case.inject(base, np.random.default_rng([seed, 7]))
    watched = watch(messages, load)
    at = base.at[watched.number]
    moved = _moved(messages, base) if case.moves_zero else 0.0
    wrong = _wrong(watched, truth, at, moved)
    end = START + case.lasts
    limit = case.limit(load)
    late = START + (limit if limit else 0.0) * case.by_statistics(load)
    under_ok = wrong & (watched.levels[watched.tick] == Level.OK) & (at > late)
    seconds = 1.0 + np.arange(len(watched.levels))
    bad = watched.levels > Level.OK
    told = np.flatnonzero(bad & (seconds >= START))
    row = {
        'fault': case.name, 'load': load, 'wrong': int(wrong.sum()),
        'wrong_while_ok': int(under_ok.sum()),
        'lost': len(base.at) - len(at), 'spoilt': _spoilt(messages, base),
        'told': float(seconds[told[0]] - START) if len(told) else None,
        'by': watched.by[told[0]] if len(told) else [],
        'good_after': _good_after(at, wrong, end), 'ok_after': _ok_after(seconds, bad, end)}
    lasting = bad[(seconds >= START + (row['told'] or 0.0)) & (seconds < end)]
    broken = {
        FINITE: not watched.finite, UNDER_OK: row['wrong_while_ok'] > 0,
        TOLD: limit is not None and (row['told'] is None or row['told'] > limit
                                     or not lasting.all()),
        GOOD: row['good_after'] is None or row['good_after'] > GOOD_AGAIN,
        OK: case.quiet and (row['ok_after'] is None or row['ok_after'] > OK_AGAIN),
        LOST: row['lost'] - row['spoilt'] > COST * case.events,
        BITS: not watched.same,
        QUIET: case.quiet and case.name.startswith('none') and bool(
            bad[seconds >= SETTLED].any())}
    return {**row, 'missed': [bar for bar in BARS if broken[bar]]}


def _moved(messages, base):
    """Return by how much the twist of each measurement [N] is another, because its zero is."""
    moved = np.zeros(len(base.at))
    change = messages.y - base.y[messages.number]
    moved[messages.number] = change[:, 0] - change[:, 1]
    return moved


def _wrong(watched, truth, at, moved):
    """Return bool [M]: tau_K or twist is WRONG."""
    k, rows = watched.number, watched.rows
    torque = (rows[:, sample_loop.E_TAU_K] - truth.tau_k[k]) / rows[:, sample_loop.E_STD + 4]
    twist = rows[:, sample_loop.E_TWIST] - (truth.x[k, 0] - truth.x[k, 1]) - np.broadcast_to(
        moved, len(truth.x))[k]
    twist = twist / rows[:, sample_loop.E_TWIST_STD]
    return ~((np.abs(torque) < WRONG) & (np.abs(twist) < WRONG)) & (at > 1.0)


def _spoilt(messages, base):
    """Return how many measurements have not arrived in order and as they were measured."""
    k = messages.number
    changes = np.column_stack([messages.stamp_ns - base.stamp_ns[k], messages.y - base.y[k],
                               messages.u[:, 0] - base.u[k, 0]])
    # What has changed for good, a new zero or another time, is as good as it was.
    intact = ((changes == 0.0) | (np.abs(changes - changes[-1]) < 1e-9)).all(axis=1)
    k = k[intact]
    newest = np.maximum.accumulate(np.concatenate([[-1], k]))[:-1]
    return len(base.at) - int((k > newest).sum())


def _good_after(at, wrong, end):
    """Return s from `end` to the first estimate behind the last wrong one, None: never."""
    behind = at[at >= end]
    if not len(behind):
        return None
    last = at[wrong & (at >= end)]
    if not len(last):
        return float(behind[0] - end)
    later = behind[behind > last[-1]]
    return float(later[0] - end) if len(later) else None


def _ok_after(seconds, bad, end):
    """Return s from `end` to the first second from which on all is OK, None: never."""
    last = np.flatnonzero(bad)
    if not len(last):
        return 0.0
    if last[-1] + 1 == len(seconds):
        return None
    return float(max(seconds[last[-1] + 1] - end, 0.0))
