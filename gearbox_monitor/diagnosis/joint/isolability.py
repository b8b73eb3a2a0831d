# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Isolability: which effects a recording can distinguish, and the motion that separates them best.

Both go by the angles between the signatures of the effects.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, NOT_FITTED, origin, PERIODIC, Starts)
from gearbox_monitor.diagnosis.joint.effect_scan import signature
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    coordinate_columns, evaluated, FilteredFit, InnovationFit)
from gearbox_monitor.diagnosis.joint.innovations import Likelihood
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.signals.uniform import UniformRecording

Separations: TypeAlias = dict[str, tuple[float, dict[str, float]]]


def twins(alone: bool = False) -> list[tuple[str, str]]:
    """
    Return the pairs of effects of which no motion distinguishes the first from the second.

    Args:
        alone: whether one encoder is read and the torque is recorded: a drive moves as late as its
            torque comes.
    """
    return [pair for name, effect in EFFECTS.items() for pair in (
        (name, effect.twin), *((name, effect.twin_alone), (effect.twin_alone, name)) * alone)
        if all(pair)]


class InnovationSpace:
    """
    Changes of whitened innovations about one fit.

    own [M, P]: by its coordinates; orders {id: N} of periodic effects.
    """

    def __init__(self, likelihood: Likelihood, at: FilteredFit, starts: Starts,
                 orders: Mapping[str, int]) -> None:
        self.likelihood, self.at, self.starts, self.orders = likelihood, at, starts, orders
        self.own = coordinate_columns(likelihood, at)

    def signature(self, name: str) -> Array:
        """Return the changes [M, C] by a little of effect `name`, one column per way."""
        order = self.orders.get(name, 1) if name in PERIODIC else None
        return signature(self.likelihood, self.at, self.starts.candidates(name, order)[0])[0]

    def separation(self, owner: int,
                   signatures: Mapping[str, Array]) -> tuple[float, dict[str, float]]:
        """
        Return (power of the signature of an effect of the fit, {id: share of it that is left}).

        The other coordinates of the fit, with their prior, give way.

        Args:
            owner: index of the effect in the candidate.
            signatures: changes [M, C] by each other effect, by its id.
        """
        candidate, z = self.at.candidate, self.at.z
        foreign = [k for k, c in enumerate(candidate.coordinates) if c.owner != owner]
        nuisances, weight = self.own[:, foreign], candidate.prior(z)[1][foreign]
        own = remove(direction(candidate, z, owner, self.own), nuisances, weight)
        return float((own ** 2).sum()), {
            name: share_left(own, remove(columns, nuisances, weight))
            for name, columns in signatures.items()}


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
    space = InnovationSpace(evidence.fine, evaluated(evidence.fine, fit), evidence.starts, orders)
    names = [n for n in evidence.ids if n not in NOT_FITTED and n not in candidate.ids]
    signatures = {name: space.signature(name) for name in names}
    return {candidate.ids[owner]: (evidence_for(evidence, fit, fits, owner),
                                   space.separation(owner, signatures)[1]) for owner in owners}


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
    if evidence.lasting:
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


DT = 1e-3
SHARES = (1.0, 0.6, 0.35)  # of the torque limit
SHRINK, TRIALS = 0.7, 5    # a motion that goes too far is tried with less torque
CHANGES, BEST, SPREAD = 60, 4, 0.5  # further trials near the best ones; of the logarithms
Pair: TypeAlias = tuple[str, str]
KINDS = (
    *(('multisine', weights, frequencies) for weights, frequencies in product(
        ((0.75, 0.25), (0.5, 0.5)), ((0.9, 2.3), (0.3, 1.1), (1.7, 5.1), (3.3, 9.7)))),
    ('multisine', (0.4, 0.3, 0.3), (0.4, 1.7, 6.3)),
    *(('chirp', (1.0,), sweep) for sweep in ((0.1, 3.0), (0.5, 8.0), (1.0, 20.0), (5.0, 40.0))),
    *(('square', (1.0,), (f,)) for f in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)),
    *(('triangle', (1.0,), (f,)) for f in (0.1, 0.2, 0.5, 1.0, 2.5)))


@dataclass(frozen=True)
class Limits:
    """Largest torque (N m), speed (rad/s) and travel (rad, either side of the start) allowed."""

    torque: float
    speed: float = math.inf
    travel: float = math.inf


@dataclass(frozen=True)
class SuggestedMotion:
    """
    One motion: parameters of drive.excitation.Excitation, and what it would tell.

    separation {(a, b): d s2}; reached: Limits that the simulation took up.
    """

    kind: str
    amplitudes: tuple[float, ...]
    frequencies: tuple[float, ...]
    seconds: float
    separation: dict[Pair, float]
    reached: Limits

    @property
    def least(self) -> float:
        """The smallest d s2 of all pairs."""
        return min(self.separation.values())

    def torque(self, dt: float = DT) -> tuple[Array, Array]:
        """
        Return (t [N], u [N]) in s and N m.

        Args:
            dt: sample time, s.
        """
        t = np.arange(round(self.seconds / dt)) * dt
        return t, Excitation(self.kind, self.amplitudes, self.frequencies,
                             self.seconds).torque(t)


def sized(starts: Starts, name: str, values: Values | None = None) -> CandidateModel:
    """
    Return the Candidate of effect `name` at `values` {parameter: value}, or at a usual size.

    Args:
        starts: of effects in one recording.
        name: id of an effect.
        values: parameters of the effect by name, None for a usual size.
    """
    if values:
        return starts.at(name, values)
    candidate = starts.candidates(name, 1)[0]
    at_rest = origin(starts.model, name, 1)
    return replace(candidate, coordinates=tuple(
        replace(c, start=c.start + 0.1 * c.scale)
        if c.owner == 0 and not c.log and c.start == at_rest.get(c.name, 0.0) else c
        for c in candidate.coordinates))


def motion_separations(
        model: DriveModel, effects: Mapping[str, Values | None], u: Array, sigma: Array,
        pairs: Sequence[Pair]) -> tuple[dict[Pair, float], Limits] | tuple[None, None]:
    """
    Return ({(a, b): d s2}, limits reached) for a torque, (None, None) if a run diverges.

    d s2 is the evidence for effect a that effect b cannot imitate (see isolability).

    Args:
        model: nominal model of the drive.
        effects: parameters by id of the effect; None for a usual size.
        u: torque of the motor [N], N m, DT apart.
        sigma: noise of the encoders [2], rad.
        pairs: pairs (a, b) of ids, a present and b its rival.
    """
    out, reached = {}, Limits(0.0, 0.0, 0.0)
    plain = simulate(model, u, DT)
    if not np.isfinite(plain.x).all():
        return None, None
    probe = UniformRecording(plain.t, u, plain.y, DT)
    for a in dict.fromkeys(a for a, _ in pairs):
        candidate = sized(Starts(model, (probe,)), a, effects.get(a))
        run = simulate(candidate.model(candidate.start()), u, DT)
        if not np.isfinite(run.x).all():
            return None, None
        reached = Limits(float(np.abs(u).max()),
                         max(reached.speed, float(np.abs(run.x[:, 2:]).max())),
                         max(reached.travel, float(np.abs(run.x[:, :2]).max())))
        rivals = [b for effect, b in pairs if effect == a]
        evidence = DriveRecordings((replace(probe, y=run.y),), model, sigma, ())
        at = evaluated(evidence.fine, InnovationFit(
            candidate, candidate.start(), evidence.fine.least_noise))
        orders = {b: int((effects.get(b) or effects.get(a) or {}).get('N', 1)) for b in rivals}
        space = InnovationSpace(evidence.fine, at, evidence.starts, orders)
        d, shares = space.separation(0, {b: space.signature(b) for b in rivals})
        out.update({(a, b): d * share for b, share in shares.items()})
    return out, reached


def suggest(model: DriveModel, effects: Mapping[str, Values | None], pairs: Sequence[Pair],
            limits: Limits, sigma: Array, seconds: float = 12.0,
            progress: Callable[..., object] | None = None) -> list[SuggestedMotion]:
    """
    Return the motions that separate `pairs` within `limits`, best first.

    A list of motions is tried first, then random changes of the best ones.

    Args:
        model: nominal model of the drive.
        effects: {parameter: value} by id of the effect, None for a usual size.
        pairs: pairs (a, b) of ids: separate a from b.
        limits: largest torque, speed and travel allowed.
        sigma: noise of the encoders [2], rad.
        seconds: duration, s.
        progress: callback with (done, total).

    Raises:
        InputError: no pair that a motion could separate.
    """
    # Twins differ near standstill only, by less than any model of friction is good for.
    pairs = [(a, b) for a, b in pairs
             if not {a, b} & set(NOT_FITTED) and (a, b) not in twins()]
    if not pairs:
        raise InputError('motion: no pair of effects that a motion could separate')
    random = np.random.default_rng(0)
    motions, done, total = [], 0, len(KINDS) * len(SHARES) + CHANGES

    def tried(kind: str, amplitudes: Iterable[float], frequencies: Iterable[float],
              trials: int = TRIALS) -> None:
        """
        Add the motion to `motions`, with less torque until it stays within the limits.

        Args:
            kind: kind of the excitation.
            amplitudes: amplitudes of its components, N m.
            frequencies: their frequencies, Hz.
            trials: largest number of reductions.
        """
        motion = SuggestedMotion(kind, tuple(map(float, amplitudes)),
                                 tuple(map(float, frequencies)), seconds, {}, limits)
        for _ in range(trials):
            separation, reached = motion_separations(
                model, effects, motion.torque()[1], sigma, pairs)
            if separation is not None and reached is not None and (
                    reached.speed <= limits.speed and reached.travel <= limits.travel):
                motions.append(replace(motion, separation=separation, reached=reached))
                return
            motion = replace(motion, amplitudes=tuple(SHRINK * a for a in motion.amplitudes))
    for (kind, weights, frequencies), share in product(KINDS, SHARES):
        tried(kind, share * limits.torque * np.array(weights), frequencies)
        done += 1
        if progress:
            progress(done, total)
    for k in range(CHANGES if motions else 0):
        motions.sort(key=lambda m: -m.least)
        motion = motions[min(k % BEST, len(motions) - 1)]
        spread = SPREAD * (1.0 - k / CHANGES) + 0.05
        amplitudes = np.array(motion.amplitudes) * np.exp(
            spread * random.standard_normal(len(motion.amplitudes)))
        amplitudes *= min(1.0, limits.torque / amplitudes.sum())
        changed = np.array(motion.frequencies) * np.exp(
            spread * random.standard_normal(len(motion.frequencies)))
        tried(motion.kind, amplitudes, changed, 1)
        if progress:
            progress(done + k + 1, total)
    return sorted(motions, key=lambda m: -m.least)
