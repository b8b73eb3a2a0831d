# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Isolability: which effects a recording can distinguish, by the angles of their signatures."""
from collections.abc import Mapping, Sequence
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, NOT_FITTED, origin, PERIODIC)
from gearbox_monitor.diagnosis.joint.effect_scan import signature
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    coordinate_columns, evaluated, InnovationFit)
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP

Separations: TypeAlias = dict[str, tuple[float, dict[str, float]]]


def twins(alone: bool) -> list[tuple[str, str]]:
    """
    Return the pairs of effects of which no motion distinguishes the first from the second.

    Args:
        alone: whether one encoder is read and the torque is recorded: a drive moves as late as its
            torque comes.
    """
    return [pair for name, effect in EFFECTS.items() for pair in (
        (name, effect.twin), *((name, effect.twin_alone), (effect.twin_alone, name)) * alone)
        if all(pair)]


def share_left(a: Array, b: Array) -> float:
    """Return the share of the power of a [M, A] that the span of b [M, B] leaves."""
    total, cross = (a * a).sum(), b.T @ a
    if total <= 0.0:
        return 1.0
    imitated = (cross * (covariance(b.T @ b) @ cross)).sum()
    return float(np.clip(1.0 - imitated / total, 0.0, 1.0))


def remove(columns: Array, nuisances: Array, prior: Array) -> Array:
    """
    Return columns with what the nuisances [M, Q] imitate taken out, their prior [Q] as rows.

    The prior enters as one more reading of each nuisance.

    Args:
        columns: changes of the readings [M, C].
        nuisances: changes of the readings by the nuisances [M, Q].
        prior: weights of the prior [Q].
    """
    moved = covariance(nuisances.T @ nuisances + np.diag(prior)) @ (nuisances.T @ columns)
    return np.concatenate([columns - nuisances @ moved, -np.sqrt(prior)[:, None] * moved])


def direction(candidate: CandidateModel, z: Array, owner: int, own: Array) -> Array:
    """
    Return the change [M, 1] towards no effect number `owner` of a candidate.

    Args:
        candidate: with the effect.
        z: its coordinates [P].
        owner: index of the effect in the candidate.
        own: changes by each coordinate [M, P].
    """
    name = candidate.ids[owner]
    at_rest = origin(candidate.nominal, name, candidate.orders.get(owner))
    total, has_coordinates = np.zeros(len(own)), False
    for k, c in enumerate(candidate.coordinates):
        if c.owner != owner:
            continue
        if name in EFFECTS and any(p.name == c.name and p.off_at_infinity
                                   for p in EFFECTS[name].parameters):
            total -= own[:, k]
        elif not c.log:
            total += own[:, k] * ((z[k] - at_rest.get(c.name, 0.0)) or c.scale)
        has_coordinates = True
    return total[:, None] if has_coordinates else np.zeros((len(own), 0))


def evidence_for(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
                 owner: int) -> float:
    """
    Return d: 2 log likelihood that the effect `owner` of `fit` gains.

    Args:
        evidence: the recordings.
        fit: with the effect.
        fits: all that were scored; the best of those without the effect is what it is against.
        owner: index of the effect in the candidate.
    """
    remaining = {name for i, name in enumerate(fit.candidate.ids) if i != owner}
    without = min((f for f in fits if set(f.candidate.ids) <= remaining), key=evidence.score)
    return float(without.deviance - fit.deviance)


def separations(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
                orders: Mapping[str, int]) -> Separations:
    """
    Return {id of `fit`: (d, {other id: s2})}: how much of its evidence others cannot imitate.

    The other effects of `fit` and nominal values (with their prior) give way.

    Args:
        evidence: the recordings.
        fit: that is reported.
        fits: all that were scored.
        orders: {id: N} of periodic effects.
    """
    candidate = fit.candidate
    owners = [i for i, name in enumerate(candidate.ids)
              if name not in (*NOT_FITTED, TORQUE_MAP.id)]
    if not owners:
        return {}
    at = evaluated(evidence.fine, fit)
    own, prior = coordinate_columns(evidence.fine, at), candidate.prior(fit.z)[1]
    names = [n for n in evidence.ids if n not in NOT_FITTED and n not in candidate.ids]
    signatures = {name: signature(evidence.fine, at, evidence.starts.candidates(
        name, orders.get(name, 1) if name in PERIODIC else None)[0])[0] for name in names}
    out = {}
    for owner in owners:
        foreign = [k for k, c in enumerate(candidate.coordinates) if c.owner != owner]
        nuisances, weight = own[:, foreign], prior[foreign]
        effect = remove(direction(candidate, fit.z, owner, own), nuisances, weight)
        out[candidate.ids[owner]] = evidence_for(evidence, fit, fits, owner), {
            name: share_left(effect, remove(columns, nuisances, weight))
            for name, columns in signatures.items()}
    return out


def rivals(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
           separation_table: Separations) -> dict[str, list[str]]:
    """
    Return {id of `fit`: ids that these recordings cannot distinguish from this effect}.

    A rival imitates all but a little of the evidence for the effect (generalised likelihood ratio)
    and its own fit does not lag behind by more; or the fit in which it replaces the effect lags by
    less, linear or not. An effect that both fits have in common has no rival by that.

    Args:
        evidence: the recordings.
        fit: that is reported.
        fits: all that were scored.
        separation_table: result of `separations`.
    """
    ids, limit = fit.candidate.ids, THRESHOLDS.isolable
    if evidence.model.lasting:
        none = min((f for f in fits if not f.candidate.ids), key=evidence.score)
        limit = max(limit, THRESHOLDS.isolable_share * (
            evidence.score(none) - evidence.score(fit)))
    lag = {f.candidate.key: evidence.score(f) - evidence.score(fit) for f in fits}
    out: dict[str, list[str]] = {name: [] for name in ids}
    for name, (d, table) in separation_table.items():
        for rival, s2 in sorted(table.items(), key=lambda item: item[1]):
            lags = len(ids) == 1 and lag.get((rival,), -math.inf) > THRESHOLDS.isolable
            if d * s2 < THRESHOLDS.isolable and not lags:
                out[name].append(rival)
    for key, value in lag.items():
        if len(key) == len(ids) and value < limit and (len(ids) == 1 or set(key) & set(ids)):
            for name in set(ids) - set(key):
                out[name] += key
    alone = evidence.model.controller is None and all(
        len(r.channels) == 1 for r in evidence.recordings)
    for name, twin in twins(alone):
        if name in ids and twin in evidence.ids:
            out[name].append(twin)
    return {name: list(dict.fromkeys(i for i in others if i not in (*ids, TORQUE_MAP.id)))
            for name, others in out.items()}
