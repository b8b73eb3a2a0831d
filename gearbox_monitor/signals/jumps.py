# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Positions that jump: turns not counted, rows of a stranger or repeated, outliers and slips.

A step between two readings is a jump if it is far longer than the usual steps, and than those
around it. Turns are counted on, rows of a second publisher are left out, single outliers count as
not measured; a slip, where the position stays elsewhere, changes nothing but is named. Rows that
repeat the previous one, as messages are lost, come before a jump of all joints that is none.
"""
from dataclasses import dataclass, field
import math

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.signals import finding

TURNS, OUTLIER, SLIP = 'turns', 'outlier', 'slip'  # kinds of jumps


@dataclass(frozen=True)
class JumpLimits:
    """
    What makes a step a jump, and a jump one of its kinds.

    usual: times the 70th percentile of the steps that are not 0: a joint that speeds up stays
    below. around: times the third longest step of the eight around: two of them may be jumps of
    the same outlier. near: relative distance from a turn. alike: times that jumps of one size,
    against the motion, have to come to be turns of an unknown period. away: rows that an outlier
    lasts at most. stranger: how often one value must come between the readings to be a second
    publisher's. wild: times the amount that all efforts stay below but a share that may be
    repaired: no motor reaches it, and even less for `away` rows alone. lively: share of the rows
    in which a reading changes that stands still only where no message came.
    """

    usual: float = 6.0
    around: float = 5.0
    near: float = 0.05
    alike: int = 3
    away: int = 5
    stranger: int = 5
    wild: float = 30.0
    lively: float = 0.9


LIMITS = JumpLimits()
PERIODS = (2.0 * math.pi, 360.0, 4.0 * math.pi)  # rad, degrees, two turns


@dataclass(frozen=True)
class JumpFinding:
    """
    Jumps of one kind in the positions of a joint.

    count: how many; row: where the first one is; size: by how much the position jumps there;
    rows: of all of them.
    """

    kind: str
    count: int
    row: int
    size: float
    rows: Integers = field(repr=False, compare=False)


def jumps(q: Array, t: Array | Integers) -> Integers:
    """
    Return the rows of positions before which they jump.

    Args:
        q: positions of a joint [N]; NaN: not measured.
        t: stamps [N]; over a dropout a joint may go as far as it would at its speed, and where the
            clock goes back another recording begins.
    """
    own = np.flatnonzero(np.isfinite(q))
    if len(own) < finding.LIMITS.least_changes:
        return own[:0]
    passed = np.diff(t[own])
    step = np.abs(np.diff(q[own])) * (passed > 0) / np.maximum(
        passed / max(float(np.median(passed)), 1e-12), 1.0)
    moving = step[step > 0.0]
    if not len(moving):
        return own[:0]
    usual = LIMITS.usual * float(np.percentile(moving, 70))
    candidates = np.flatnonzero(step > usual)
    if not len(candidates):
        return own[:0]
    padded = np.pad(step, 4, 'edge')
    around = np.stack([padded[4 + k:4 + k + len(step)] for k in (-4, -3, -2, -1, 1, 2, 3, 4)])
    third = np.sort(around[:, candidates], axis=0)[-3]
    return np.asarray(own[candidates[step[candidates] > LIMITS.around * third] + 1])


def without_jumps(q: Array, t: Array | Integers) -> tuple[Array, tuple[JumpFinding, ...]]:
    """
    Return positions with turns counted on and outliers as not measured, and what was found.

    Args:
        q: positions of a joint [N]; NaN: not measured.
        t: stamps [N].

    Returns:
        The positions [N]; findings of TURNS, OUTLIER and SLIP.
    """
    q, findings = counted_on(q, t)
    rows = jumps(q, t)
    away = _away(q, rows)
    for kind, at in ((OUTLIER, away), (SLIP, rows)):
        if kind == SLIP and len(away):
            q[away] = np.nan
            at = jumps(q, t)
        if len(at):
            findings.append(JumpFinding(kind, len(at), int(at[0]), _step(q, int(at[0])), at))
    return q, tuple(findings)


def _step(q: Array, row: int) -> float:
    """Return by how much the positions `q` [N] jump before `row`."""
    return float(q[row] - q[:row][np.isfinite(q[:row])][-1])


def counted_on(q: Array, t: Array | Integers) -> tuple[Array, list[JumpFinding]]:
    """Return positions `q` [N] at `t` [N] with turns counted on, and the finding of TURNS."""
    q = q.copy()
    period, at = turns(q, t)
    if not len(at):
        return q, []
    own = np.flatnonzero(np.isfinite(q))
    step = np.diff(q[own])
    whole = np.zeros(len(own))
    place = np.searchsorted(own, at)
    whole[place] = -np.sign(step[place - 1])
    q[own] += period * np.cumsum(whole)
    return q, [JumpFinding(TURNS, len(at), int(at[0]), float(step[place[0] - 1]), at)]


def turns(q: Array, t: Array | Integers) -> tuple[float, Integers]:
    """
    Return the period of turns that positions `q` [N] do not count, and the rows that begin one.

    The period is a turn in radians or degrees, or the size of jumps that are all alike, go against
    the motion and from one end of the range to the other.
    """
    own = np.flatnonzero(np.isfinite(q))
    if len(own) < finding.LIMITS.least_changes:
        return 0.0, own[:0]
    x = q[own]
    step = np.diff(x)
    usual = 5.0 * float(np.percentile(np.abs(step), 90))
    for period in PERIODS:
        at = np.flatnonzero(np.abs(np.abs(step) - period) < LIMITS.near * period)
        if len(at) and np.abs(step[at]).min() > usual and np.ptp(x) < 1.05 * period:
            return period, own[at + 1]
    rows = jumps(q, t)
    at = np.searchsorted(own, rows) - 1
    if len(at) < LIMITS.alike or at[0] < 1 or at[-1] > len(step) - 2 or (
            2 * np.isin(rows, _away(q, rows)).sum() >= len(rows)):  # outliers of one size
        return 0.0, own[:0]
    motion = 0.5 * (step[at - 1] + step[at + 1])
    period = float(np.median(np.abs(step[at] - motion)))
    alike = np.abs(np.abs(step[at] - motion) - period) < LIMITS.near * period
    if alike.all() and (motion * step[at] < 0.0).all() and np.ptp(x) < 1.05 * period:
        return period, own[at + 1]
    return 0.0, own[:0]


def _away(q: Array, rows: Integers) -> Integers:
    """Return the rows of `q` [N] that lie between two of the jumps before `rows`, out and back."""
    away: list[int] = []
    k = 0
    while k + 1 < len(rows):
        begin, end = int(rows[k]), int(rows[k + 1])
        size, back = _step(q, begin), _step(q, end)
        if end - begin <= LIMITS.away and abs(size + back) < 0.5 * abs(size):
            away += range(begin, end)
            k += 2
        else:
            k += 1
    return np.array(away, np.int64)


def wild_rows(effort: Array) -> Integers:
    """Return the rows of an effort [N] (NaN: not measured) alone and far beyond all others."""
    own = np.flatnonzero(np.isfinite(effort))
    if not len(own):
        return own
    off = np.abs(effort - np.median(effort[own]))
    rows = np.flatnonzero(off > LIMITS.wild * (
        np.quantile(off[own], 1.0 - finding.LIMITS.max_repaired) or math.inf))
    runs = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return np.concatenate([rows[:0], *(run for run in runs if len(run) <= LIMITS.away)])


def repeats(values: Array) -> Flags:
    """
    Return which rows [N] repeat the row before in all readings, as a message was lost.

    A few at a time, and only beside a reading that changes with almost every other row: a coarse
    encoder, or a robot at rest, repeats itself as well.

    Args:
        values: all readings of the rows [N, C]; NaN: not measured.
    """
    same = np.zeros(values.shape, bool)
    same[1:] = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    stale: Flags = np.asarray(same.all(axis=1))
    if not stale.any() or (~same[~stale]).mean(axis=0).max() < LIMITS.lively:
        return np.zeros(len(values), bool)
    rows = np.flatnonzero(stale)
    for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
        stale[run] = len(run) <= LIMITS.away
    return stale


def strangers(q: Array, t: Array | Integers) -> Flags:
    """
    Return which rows are of a second publisher: one constant posture between the readings.

    Args:
        q: positions of all joints of a message [N, J]; NaN: not measured.
        t: stamps [N].

    Returns:
        Rows [N] in which each joint that is measured has one and the same value, and to which and
        from which a joint jumps again and again.
    """
    none: Flags = np.zeros(len(q), bool)
    if len(q) < finding.LIMITS.least_changes:
        return none
    columns = [j for j in range(q.shape[1]) if np.isfinite(q[:, j]).any()]
    for j in columns:
        rows = jumps(q[:, j], t)
        values, counts = np.unique(q[rows, j], return_counts=True)
        if not len(values) or counts.max() < LIMITS.stranger:
            continue
        posture = q[rows[np.flatnonzero(q[rows, j] == values[counts.argmax()])[0]]]
        same: Flags = ((q == posture) | np.isnan(posture)).all(axis=1)
        # Out and back: as many jumps lead away from the posture as to it.
        if same.mean() <= 0.5 and same[rows].sum() >= 0.3 * len(rows):
            return same
    return none
