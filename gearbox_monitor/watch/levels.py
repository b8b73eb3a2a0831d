# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Levels of states, which drift; and steps of one of them that last.

Each state has a few coefficients. The last blocks, three to nine, are compared with the level that
those before them had. A step is taken for sure only by odds against all states and times at which
one may begin, and it may rest on no single block. The errors of blocks correlate: posture
and load stay.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.watch.settings import SECOND, WATCH_SETTINGS

Deviation: TypeAlias = tuple[Array, Array]   # values [k] and covariance [k, k]


@dataclass(frozen=True, eq=False)
class Levels:
    """
    What is known of F states with up to W coefficients.

    level [F, W], covariance [F, W, W]: by the blocks before the recent ones; scatter [F], seen
    [F]: squared deviation of those blocks from the level, over what each states, and their number;
    values [T, F, W], precision [T, F, W, W]: of recent blocks, 0 where one shows nothing; gains
    [T, F]: deviance that each state alone explains; begin_ns [T]: of these blocks. jump, drift
    [F, W]: deviation of a step, of a change in an hour.
    """

    level: Array
    covariance: Array
    scatter: Array
    seen: Array
    values: Array
    precision: Array
    gains: Array
    begin_ns: tuple[int, ...]
    jump: Array
    drift: Array


class LevelStep(NamedTuple):
    """
    A step that is sure: of which state, since when, and the level before [W].

    rival: the state that explains nearly as much, None if none does.
    """

    state: int
    since_ns: int
    before: Array
    rival: int | None = None


def levels_of(jump: Array, drift: Array, apart: Array) -> Levels:
    """
    Return the Levels of states that are as learnt.

    Args:
        jump: deviation [F, W] of a step.
        drift: of a change in an hour.
        apart: of what was learnt; 0: no coefficient.
    """
    count, width = apart.shape
    covariance = np.where(apart > 0.0, apart ** 2, 1.0)[:, :, None] * np.eye(width)
    return Levels(np.zeros_like(apart), covariance, np.full(count, WATCH_SETTINGS.scatter),
                  np.zeros(count), np.zeros((0, count, width)),
                  np.zeros((0, count, width, width)), np.zeros((0, count)), (), jump, drift)


def level_of(levels: Levels, state: int, width: int) -> Deviation:
    """Return mean and covariance of a state with `width` coefficients in its `levels`."""
    return levels.level[state, :width], levels.covariance[state, :width, :width]


def now(levels: Levels, state: int, width: int) -> Deviation:
    """Return mean and covariance of a state, `width` numbers, in the recent blocks of `levels`."""
    precision = levels.precision[:, state, :width, :width]
    score = np.einsum('tij,tj->i', precision, levels.values[:, state, :width])
    covariance = np.linalg.inv(precision.sum(axis=0) + 1e-12 * np.eye(width))
    inflation = _inflation(len(precision)) * levels.scatter[state]
    return covariance @ score, covariance * inflation


def with_block(levels: Levels, deviations: Sequence[Deviation | None], gains: Array,
               begin_ns: int) -> Levels:
    """
    Return the levels after a block.

    Args:
        levels: before it.
        deviations: of each state from its level; None where the block does not show it.
        gains: deviance [F] that each state alone would explain.
        begin_ns: of the block.
    """
    count, width = levels.level.shape
    values, precision = np.zeros((count, width)), np.zeros((count, width, width))
    for f, estimate in enumerate(deviations):
        if estimate is not None:
            k = len(estimate[0])
            values[f, :k] = levels.level[f, :k] + estimate[0]
            precision[f, :k, :k] = np.linalg.inv(estimate[1])
    out = replace(levels, values=np.r_[levels.values, values[None]],
                  precision=np.r_[levels.precision, precision[None]],
                  gains=np.r_[levels.gains, gains[None]],
                  begin_ns=(*levels.begin_ns, begin_ns))
    return _aged(out) if len(out.begin_ns) > WATCH_SETTINGS.recent else out


def step_in(levels: Levels) -> LevelStep | None:
    """
    Return the step that the recent blocks in `levels` make sure, if there is one.

    The usual scatter of the states decides whether something stepped. The state that stepped is
    the one that explains most of the blocks since then, less the deviance that its freedom costs
    (Occam factor): a weight can imitate any rotor.
    """
    s, blocks = WATCH_SETTINGS, len(levels.begin_ns)
    if blocks < s.lasting:
        return None
    odds = np.array([_evidence(levels, np.ones(age))[0] for age in range(1, blocks + 1)])
    odds[:, levels.seen < s.lasting] = -np.inf
    age = 1 + int(np.unravel_index(np.argmax(odds), odds.shape)[0])
    gain = levels.gains[-age:].sum(axis=0) - _evidence(levels, np.ones(age))[1]
    f = int(np.argmax(gain))
    prior = math.log(s.often * len(levels.level))
    unsure = odds[age - 1, f] - prior < math.log(s.sure / (1.0 - s.sure))
    second = int(np.argsort(gain)[-2])
    ambiguous = gain[f] - gain[second] < s.lead
    if age < s.lasting or unsure or (ambiguous and age < s.recent):
        return None
    least = min(float(_evidence(levels, np.arange(age) != t)[0][f]) for t in range(age))
    return LevelStep(f, levels.begin_ns[-age], levels.level[f], second if ambiguous else None) if (
        least > s.alone * odds[age - 1, f]) else None


def stepped(levels: Levels, step: LevelStep) -> Levels:
    """Return the levels after a step, which makes the recent values of all other states void."""
    level, covariance = levels.level.copy(), levels.covariance.copy()
    f, begin = step.state, levels.begin_ns.index(step.since_ns)
    own = replace(levels, values=levels.values[begin:], precision=levels.precision[begin:])
    width = int(np.sum(levels.jump[f] > 0.0))
    level[f, :width], covariance[f, :width, :width] = now(own, f, width)
    return replace(levels, level=level, covariance=covariance, values=levels.values[:0],
                   precision=levels.precision[:0], gains=levels.gains[:0], begin_ns=())


def _inflation(blocks: float) -> float:
    """Return how many times as uncertain `blocks` are as if they erred independently."""
    return 1.0 + WATCH_SETTINGS.correlation * max(blocks - 1.0, 0.0)


def _evidence(levels: Levels, use: Array) -> tuple[Array, Array]:
    """
    Return the evidence for a step of each state [F] in the last blocks, of those in `use` [T].

    It is the log likelihood ratio, and the deviance that the freedom costs (the Occam factor).
    """
    share = use / (_inflation(float(np.sum(use))) * levels.scatter[:, None])     # [F, T]
    precision = levels.precision[-len(use):]
    information = np.einsum('ft,tfij->fij', share, precision)
    score = np.einsum('ft,tfij,tfj->fi', share, precision,
                      levels.values[-len(use):] - levels.level)
    still = levels.covariance       # what is not known of the level is no step
    eye = np.eye(still.shape[1])

    def gain_and_cost(prior: Array) -> Array:
        inner = np.linalg.inv(prior) + information
        gain = np.einsum('fi,fi->f', score, np.linalg.solve(inner, score[..., None])[..., 0])
        return np.array([gain, np.linalg.slogdet(eye + prior @ information)[1]])
    gain, cost = gain_and_cost(still + eye * levels.jump[:, :, None] ** 2) - gain_and_cost(still)
    return 0.5 * (gain - cost), cost


def _aged(levels: Levels) -> Levels:
    """Return `levels` with their oldest block in the level, which drifts."""
    s = WATCH_SETTINGS
    hours = max(levels.begin_ns[1] - levels.begin_ns[0], 0) / SECOND / 3600.0
    eye = np.eye(levels.level.shape[1])
    before = levels.covariance + eye * levels.drift[:, :, None] ** 2 * hours
    own = levels.precision[0]
    shown = np.trace(own, axis1=1, axis2=2) > 0.0
    error = levels.values[0] - levels.level
    inner = np.linalg.inv(eye + own @ before) @ own     # inverse of the innovation's covariance
    width = np.maximum((levels.jump > 0.0).sum(axis=1), 1)
    whole = np.einsum('fi,fij,fj->f', error, inner, error) / width
    square = np.minimum(whole, s.clipped)
    seen = levels.seen + shown
    gain = np.where(shown, 1.0 / np.minimum(seen + s.belief, s.memory), 0.0)
    scatter = np.maximum(levels.scatter + gain * (square - levels.scatter), s.calm)
    # A block far off the level counts less: what did not last does not belong to the level.
    outlying = np.maximum(whole / (s.clipped * scatter), 1.0) ** 2
    information = own / (outlying * scatter * _inflation(2.0))[:, None, None]
    covariance = np.linalg.inv(np.linalg.inv(before) + information)
    level = levels.level + np.einsum('fij,fjk,fk->fi', covariance, information, error)
    return replace(levels, level=level, covariance=covariance, scatter=scatter, seen=seen,
                   values=levels.values[1:], precision=levels.precision[1:],
                   gains=levels.gains[1:],
                   begin_ns=levels.begin_ns[1:])
