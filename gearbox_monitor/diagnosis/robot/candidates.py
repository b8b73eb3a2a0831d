# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Candidates: every effect at every place as columns, and functions without a law beside them."""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.robot_effects import BASE, LINK, ROBOT_EFFECTS, RobotEffect
from gearbox_monitor.diagnosis.robot.rows import Rows
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.effect import (
    BalanceColumn, COMMAND, dissipated, JointMotion, SCALE, SETPOINT, TORQUE)

HYSTERESIS = (0.1, 0.3, 1.0)  # widths, of the deviation of the angle
SWINGS = tuple(0.5 * 1.3 ** k for k in range(8))  # Hz
SWING_DAMPING = 0.05
LEAST = 1e-9  # of a row: smaller is rounding

Columns = Mapping[int, Array]  # {joint: [R, k]} of all recordings, one behind the other


@dataclass(frozen=True, eq=False)
class Candidate:
    """
    An effect, or a function without a law (`free`), at a place.

    joint, link: where; both None is the base. columns: {joint: [R, k]}. setting: of its nonlinear
    parameter. at_setting(setting): the candidate for another one, None if there is none to refine.
    low, high: bounds of the first coefficient and of the size of all. possible(b, deviations):
    whether physics allows the coefficients b. values(b): parameters of them.
    twins: effects with the same columns. over: variable of a free function, or what tells an
    effect from another one of its id at the same place. next_setting(b): the setting that follows
    from the coefficients b, None if it is searched. span: of a setting that is a position, how far
    the joint moves (standard deviation); 0 for one that is refined in ratios. hidden: share of the
    joint's motion in which any input has the same effect. deviation [k]: of the coefficients by
    their prior, about 0; None: anything goes. of_input: it acts on a setpoint, and is no torque.
    """

    effect: str
    columns: Columns
    joint: str | None = None
    link: str | None = None
    setting: Any = None
    at_setting: Callable[[Any], 'Candidate'] | None = None
    low: float = -math.inf
    high: float = math.inf
    possible: Callable[[Array, Array], bool] | None = None
    values: Callable[[Array], Mapping[str, float]] | None = None
    twins: tuple[str, ...] = ()
    free: bool = False
    over: str = ''
    extra: int = 0
    next_setting: Callable[[Array], Any] | None = None
    span: float = 0.0
    hidden: float = 0.0
    deviation: Array | None = None
    of_input: bool = False

    @property
    def width(self) -> int:
        """Number of coefficients."""
        return next(iter(self.columns.values())).shape[1]

    @property
    def size(self) -> int:
        """Number of parameters; a coefficient without any torque is none."""
        return int(self.acting.sum()) + self.extra

    @cached_property
    def acting(self) -> Flags:
        """Which coefficients [k] have any torque."""
        return np.any([np.abs(x).max(axis=0) > LEAST for x in self.columns.values()], axis=0)

    def allows(self, b: Array, deviations: Array) -> bool:
        """
        Return whether physics allows coefficients, unsure only where they have a torque.

        Args:
            b: [k].
            deviations: [k].
        """
        return bool(self.low < b[0] and np.linalg.norm(b) < self.high) and (
            self.possible is None or self.possible(b, np.where(self.acting, deviations, 0.0)))

    @property
    def searched(self) -> bool:
        """Whether the setting is a number that was searched."""
        return self.at_setting is not None and self.next_setting is None

    @property
    def place(self) -> str:
        """Joint, link or base."""
        return self.joint or self.link or BASE

    @property
    def name(self) -> tuple[str, str, str]:
        """What it is, whatever its setting."""
        return self.effect, self.place, self.over


def _stacked(parts: Sequence[Columns]) -> Columns:
    return {j: np.concatenate([part[j] for part in parts]) for j in parts[0]}


def library(recordings: Sequence[Rows], effects: Sequence[str] | None = None) -> list[Candidate]:
    """
    Return all effects at all places that the recordings can show.

    Args:
        recordings: of one robot, of one kind of input.
        effects: ids to try, None for all.
    """
    out: list[Candidate] = []
    first = recordings[0]
    chain = first.robot.chain
    columns = [(e.id, '', e.column, e.rotary_only) for e in EFFECTS.values()
               if e.column is not None]
    columns += [(e.id, e.over, e.column, False) for e in ROBOT_EFFECTS if e.column is not None]
    for j, name in enumerate(chain.joints):
        for effect_id, over, column, rotary in columns:
            wished = effects is None or effect_id in effects
            if wished and visible_in(column, first) and not (rotary and chain.links[j].slides):
                out += _of_joint((effect_id, name, over), column, recordings, j)
    for effect in ROBOT_EFFECTS:
        if effect.column is None and (effects is None or effect.id in effects):
            out += of_robot(effect, recordings)
    return [c for c in out if any(np.abs(x).max() > LEAST for x in c.columns.values())]


def visible_in(column: BalanceColumn, rows: Rows) -> bool:
    """Return whether the input of the recording `rows` shows an effect with this `column`."""
    return {COMMAND: not rows.setpoint and not rows.measured, TORQUE: not rows.setpoint,
            SCALE: not rows.setpoint or rows.robot.compensated,
            SETPOINT: rows.setpoint}.get(column.needs, True)


def tries(column: BalanceColumn, setting: float, m: JointMotion, rate: float) -> bool:
    """Return whether a log `m` of `rate` (Hz) is fast enough for a `column` at its `setting`."""
    if column.setting == 'T' and column.needs == COMMAND and rate < SETTINGS.full_rate:
        return False
    if column.setting == 'N':
        return setting * float(np.quantile(np.abs(m.v), 0.5)) / (2.0 * math.pi) < 0.3 * rate
    return True


def _of_joint(name: tuple[str, str, str], column: BalanceColumn, recordings: Sequence[Rows],
              joint: int) -> list[Candidate]:
    """Return the candidates of a `name`, of one joint, for each setting of the grid."""
    motions = [rows.joints[joint] for rows in recordings]
    setting_of = max(motions, key=lambda m: float(np.std(m.effort)))
    # What repeats itself has to do so within the motion: a part of a wave follows any load.
    period = 2.0 * math.pi / max(1e-9, *(float(np.ptp(m.q)) for m in motions))

    def made(setting: float) -> Candidate:
        series = [column.series(m, setting) for m in motions]
        parts = [{joint: rows.tested(joint, x, column.momentum)}
                 for rows, x in zip(recordings, series)]
        low = max(column.low(m) for m in motions)
        if column.dissipates and motions[0].learnt:
            low = max(low, *(dissipated(m, x[:, 0]) for m, x in zip(motions, series)))
        hidden = 0.0 if column.hides is None else float(np.average(
            np.concatenate([column.hides(m, setting) for m in motions]),
            weights=np.concatenate([rows.tests.mask[:, joint] ** 2 + 1e-9
                                    for rows in recordings])))
        return Candidate(
            name[0], _stacked(parts), joint=name[1], hidden=hidden, of_input=column.of_input,
            setting=setting if column.setting else None,
            at_setting=made if column.setting and not column.whole else None,
            low=low, high=0.0 if column.setting == 'N' and setting < period else min(
                column.high(m) for m in motions),
            values=lambda b: column.values(b, setting), over=name[2], twins=tuple(
                t for t in column.twins if not (
                    (own := EFFECTS[t].column) and visible_in(own, recordings[0]))),
            span=float(np.std(setting_of.q)) if column.place else 0.0,
            extra=1 if column.setting and not column.fixed_point else 0,
            next_setting=(lambda b: float(np.clip(b[0], 1e-3, column.high(setting_of))))
            if column.fixed_point else None)
    rate = min(rows.rate for rows in recordings)
    return [made(setting) for setting in column.grid(setting_of)
            if tries(column, setting, setting_of, rate)]


def of_robot(effect: RobotEffect, recordings: Sequence[Rows]) -> list[Candidate]:
    """Return an effect of links, the base or joints at each place."""
    chain, columns, values = recordings[0].robot.chain, effect.columns, effect.values
    assert columns is not None and values is not None

    def made(index: int, setting: Array) -> Candidate:
        where: dict[str, Any] = {}
        if effect.place == LINK:
            where['link'] = chain.links[index].name
        elif effect.place != BASE:
            where['joint'] = chain.joints[index]
        high = effect.high
        if 'joint' in where and math.isfinite(high) and chain.links[index].slides:
            # Half a turn means nothing there: no farther than the travel that was recorded.
            high = max(float(np.ptp(rows.motion.q[:, index])) for rows in recordings)
        return Candidate(
            effect.id, _stacked([columns(rows, index, setting) for rows in recordings]),
            setting=setting,
            at_setting=(lambda x: made(index, x)) if effect.next_setting else None,
            low=-math.inf if recordings[0].robot.learnt else effect.low, high=high,
            possible=None if effect.possible is None else partial(
                effect.possible, recordings[0].robot, index),
            deviation=effect.deviation and effect.deviation(chain, index),
            values=lambda b: values(b, setting), next_setting=effect.next_setting, **where)
    if effect.place == LINK:
        indices = [i for i, link in enumerate(chain.links) if link.mass > 0.0]
    elif effect.place == BASE:
        indices = [0]
    else:
        indices = list(range(len(chain.links)))
    return [made(i, setting) for i in indices for setting in effect.starts(chain, i)]


def splines(x: Array, count: int = 8, robust: bool = True) -> Array:
    """
    Return `count` - 1 cubic B-splines of `x` [N] over its range, without their constant.

    robust: over the range without the outer 0.5 % at either end.
    """
    low, high = np.quantile(x, (0.005, 0.995)) if robust else (x.min(), x.max())
    if high - low < 1e-9:
        return np.zeros((len(x), 0))
    u = (np.clip(x, low, high) - low) / (high - low) * (1.0 - 1e-9)
    knots = np.r_[[0.0] * 3, np.linspace(0.0, 1.0, count - 2), [1.0] * 3]
    columns = scipy.interpolate.BSpline.design_matrix(u, knots, 3).toarray()
    return (columns - columns.mean(axis=0))[:, 1:]


def stops(x: Array, widths: Sequence[float]) -> Array:
    """
    Return stop operators [N, J, k] of `x` [N, J]: a hysteresis over x is a sum of them (Prandtl).

    Each follows x within +-`widths` [k] of its deviation, and stays at the edge beyond.
    """
    edge = np.std(x, axis=0)[:, None] * widths
    out = np.zeros((len(x), *edge.shape))
    state = out[0]
    for i, step in enumerate(np.diff(x, axis=0)[:, :, None], 1):
        out[i] = state = np.minimum(np.maximum(state + step, -edge), edge)
    return out


def swing(x: Array, period: float, frequency: float) -> Array:
    """
    Return the responses [N, 2] of a mass that swings in a joint to its acceleration and speed.

    Args:
        x: position [N].
        period: of its samples, s.
        frequency: of the mass, Hz.
    """
    w = 2.0 * math.pi * frequency
    poles = [1.0, 2.0 * SWING_DAMPING * w, w * w]
    return np.stack([scipy.signal.lfilter(*scipy.signal.bilinear(zeros, poles, 1.0 / period),
                                          x - x[0])
                     for zeros in ([1.0, 0.0, 0.0], [w, 0.0])], axis=1)


def _swinging(recordings: Sequence[Rows], j: int, frequency: float) -> Candidate:
    """Return the function of past speeds of joint `j` that a mass of a `frequency` needs."""
    # Between two sections nothing moved: their leap would set the mass swinging.
    parts = [rows.tested(j, np.concatenate([
        swing(rows.joints[j].q[s], rows.motion.step, frequency) for s in rows.motion.sections]))
        for rows in recordings]
    return Candidate('function', {j: np.concatenate(parts)}, free=True, setting=frequency,
                     joint=recordings[0].robot.chain.joints[j], over='past speeds', extra=1,
                     at_setting=partial(_swinging, recordings, j))


def swings(recordings: Sequence[Rows]) -> list[Candidate]:
    """Return the functions of past speeds in `recordings` that a swinging mass needs."""
    return [_swinging(recordings, j, frequency)
            for j in range(len(recordings[0].joints)) for frequency in SWINGS]


def free_functions(recordings: Sequence[Rows]) -> list[Candidate]:
    """Return functions of `recordings` without a law: if one wins, the cause is unknown."""
    joints = recordings[0].robot.chain.joints
    sizes = [len(rows.motion.t) for rows in recordings]
    ends = np.cumsum(sizes)[:-1]
    out: list[Candidate] = []

    def whole(get: Callable[[JointMotion], Array], j: int) -> Array:
        return np.concatenate([get(rows.joints[j]) for rows in recordings])

    def add(j: int, over: str, series: Array) -> None:
        if series.shape[1]:
            parts = [rows.tested(j, x) for rows, x in zip(recordings, np.split(series, ends))]
            out.append(Candidate('function', {j: np.concatenate(parts)}, joint=joints[j],
                                 free=True, over=over))
    past = stops(np.concatenate([rows.motion.q for rows in recordings]), HYSTERESIS)
    angles = [splines(whole(lambda m: m.q, k), 6) for k in range(len(joints))]
    speeds = [np.stack([whole(lambda m: m.v, k), whole(lambda m: m.sign, k)], axis=1)
              for k in range(len(joints))]
    for j in range(len(joints)):
        q, v, load, sign, t = (whole(get, j) for get in (
            lambda m: m.q, lambda m: m.v, lambda m: m.load, lambda m: m.sign, lambda m: m.t))
        add(j, 'angle', splines(q))
        add(j, 'speed', splines(v))
        add(j, 'load', splines(load))
        add(j, 'time', splines(t, 8, robust=False))
        add(j, 'friction over time', sign[:, None] * splines(t, 6, robust=False))
        add(j, 'friction over angle', sign[:, None] * splines(q, 6))
        add(j, 'past angles', past[:, j])
        for k, partner in enumerate(joints):
            if k != j:
                add(j, f'angle of {partner}', angles[k])
                add(j, f'speed of {partner}', speeds[k])
    return out
