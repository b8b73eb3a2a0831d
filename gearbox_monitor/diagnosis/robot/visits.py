# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What references visited: a shape is certain only at the angles, speeds and loads they had.

Beyond, the prior returns: hat functions over each variable where no reference was are nuisance,
with the size that the taught torque of the joint has.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.rows import NuisanceColumn, Rows
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.effects.balance_column import JointMotion

VARIABLES = ('angle', 'speed', 'load')
# Of half the range of a slide (a hinge: by the turn); of the largest; of the deviation.
SPACING = {'angle': 0.3, 'speed': 0.3, 'load': 0.5}
# m, rad/s and N m: of a joint that stands, noise is no range.
LEAST_SPACING = {'angle': 0.01, 'speed': 0.02, 'load': 1e-6}
TURN = 21         # knots of a turn: the torque of a hinge is the same in every turn
SECONDS = 0.5     # spent at a knot from which it is visited
LEAST_LOAD = 0.2  # of the effort's deviation: a load that is less matters to no friction
UNSURE = 0.3      # of the taught torque: what it may be elsewhere
EVERY = 0.05      # s between the states that are kept, unless they are more than MOST
MOST = 2000


@dataclass(frozen=True)
class Visits:
    """Seconds spent at the knots k spacing of one variable, {k: s}."""

    spacing: float
    seconds: Mapping[int, float]


@dataclass(frozen=True, eq=False)
class States:
    """
    Angles and speeds of all joints at once, as references had them.

    points [N, K]: cosine and sine of each hinge, position of each slide, speeds, over their
    deviations [K]. apart: median distance of a point from the nearest one of another part.
    """

    points: Array
    deviations: Array
    apart: float


def _value(m: JointMotion, variable: str) -> Array:
    return {'angle': m.q, 'speed': m.v, 'load': m.load}[variable]


def _hats(x: Array, spacing: float, turns: bool) -> tuple[Integers, Integers, Array]:
    """Return the knots [N] below and above each value and the weight [N] of the one above."""
    u = x / spacing
    low = np.floor(u)
    lower, upper = low.astype(np.int64), low.astype(np.int64) + 1
    return (lower % TURN, upper % TURN, u - low) if turns else (lower, upper, u - low)


def _turns(rows: Rows, joint: int, variable: str) -> bool:
    return variable == 'angle' and not rows.robot.chain.links[joint].slides


def visits_of(recordings: Sequence[Rows], joint: int) -> dict[str, Visits]:
    """Return the Visits of a joint's variables in `recordings`."""
    out = {}
    for variable in VARIABLES:
        values = [_value(rows.joints[joint], variable) for rows in recordings]
        whole = np.concatenate(values)
        slides = recordings[0].robot.chain.links[joint].slides
        size = {'angle': 0.5 * float(np.ptp(whole)) if slides else 1.0,
                'speed': float(np.abs(whole).max()),
                'load': max(float(np.std(whole)), LEAST_LOAD * max(
                    float(np.std(rows.joints[joint].effort)) for rows in recordings))}[variable]
        turns = _turns(recordings[0], joint, variable)
        spacing = 2.0 * np.pi / TURN if turns else max(
            SPACING[variable] * size, LEAST_SPACING[variable])
        seconds: dict[int, float] = {}
        for rows, x in zip(recordings, values):
            low, high, share = _hats(x, spacing, turns)
            for k, weight in ((low, 1.0 - share), (high, share)):
                for knot in np.unique(k):
                    spent = float(weight[k == knot].sum()) * rows.motion.step
                    seconds[int(knot)] = seconds.get(int(knot), 0.0) + spent
        out[variable] = Visits(spacing, seconds)
    return out


def _features(rows: Rows) -> Array:
    slides = np.array([link.slides for link in rows.robot.chain.links])
    q, keep = rows.motion.q, max(round(EVERY / rows.motion.step), 1)
    return np.hstack([np.where(slides, q, np.cos(q)), np.where(slides, 0.0, np.sin(q)),
                      rows.motion.v])[::keep]


def states_of(recordings: Sequence[Rows]) -> States:
    """Return the States of `recordings`."""
    count = len(recordings[0].joints)
    x = np.concatenate([_features(rows) for rows in recordings])
    parts = max(round(len(x) * EVERY / SETTINGS.part), 2)
    part = np.arange(len(x)) * parts // len(x)
    keep = np.arange(0, len(x), -(-len(x) // MOST))
    x, part = x[keep], part[keep]
    angle = np.hypot(x[:, :count].std(axis=0), x[:, count:2 * count].std(axis=0))
    deviations = np.maximum(np.r_[angle, angle, x[:, 2 * count:].std(axis=0)], SETTINGS.slow)
    x = x / deviations
    nearest = np.concatenate([scipy.spatial.cKDTree(x[part != p]).query(x[part == p])[0]
                            for p in range(parts)])
    return States(x, deviations, float(np.median(nearest)))


def farther(recordings: Sequence[Rows], states: States) -> float:
    """
    Return how far `recordings` are from the references' `states`, over these from themselves.

    Parts of one swing that is repeated are near each other, and say nothing of another motion.
    """
    x = np.concatenate([_features(rows) for rows in recordings]) / states.deviations
    distance = scipy.spatial.cKDTree(states.points).query(x)[0]
    return float(np.median(distance)) / max(states.apart, 1e-9)


def unvisited(rows: Rows, joint: int, variable: str, visits: Visits
              ) -> tuple[tuple[int, ...], Array, float]:
    """
    Return knots [k] where no reference was, hats [N, k] on them, their share of the motion.

    rows: of the recording. variable: of the motion of `joint` (index), which `visits` counts.
    """
    x = _value(rows.joints[joint], variable)
    low, high, share = _hats(x, visits.spacing, _turns(rows, joint, variable))
    knots, hats = [], []
    for knot in np.unique(np.concatenate([low, high])).tolist():
        if visits.seconds.get(knot, 0.0) < SECONDS:
            hat = np.where(low == knot, 1.0 - share, 0.0) + np.where(high == knot, share, 0.0)
            if hat.any():
                knots.append(knot)
                hats.append(hat)
    series = np.stack(hats, axis=1) if hats else np.zeros((len(x), 0))
    return tuple(knots), series, float(series.sum(axis=1).mean()) if hats else 0.0


def unvisited_shares(recordings: Sequence[Rows], visits: Mapping[str, Mapping[str, Visits]]
                     ) -> list[dict[str, float]]:
    """Return of each joint {variable: share of the motion of `recordings` without `visits`}."""
    return [{variable: float(np.mean([unvisited(rows, j, variable, of)[2]
                                      for rows in recordings]))
             for variable, of in visits[name].items()}
            for j, name in enumerate(recordings[0].robot.chain.joints)]


def with_unvisited(rows: Rows, visits: Mapping[str, Mapping[str, Visits]], sizes: Array) -> Rows:
    """
    Return `rows` with nuisance where no reference was, and which segments that are.

    Args:
        rows: of a recording.
        visits: {joint: {variable: Visits}} of the references.
        sizes: taught torque [J], N m.
    """
    columns, tests = list(rows.nuisance), rows.tests
    strange = np.zeros((len(tests.starts), len(sizes)))
    for j, name in enumerate(rows.robot.chain.joints):
        for variable, of in visits[name].items():
            knots, series, _ = unvisited(rows, j, variable, of)
            if knots:
                strange[:, j] = np.maximum(strange[:, j], tests.mean_in_motion(
                    series.sum(axis=1), j))
                shapes = {'': series}
                if variable != 'speed':  # whose sign is in it: its friction is a torque
                    shapes['friction '] = rows.sign[:, j, None] * series
                for kind, x in shapes.items():
                    columns += [NuisanceColumn(f'beyond {name} {kind}{variable} {knot}',
                                               {j: tested}, UNSURE * sizes[j])
                                for knot, tested in zip(knots, rows.tested(j, x).T)]
    return replace(rows, nuisance=tuple(columns), strange=strange)
