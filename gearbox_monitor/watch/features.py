# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The states of a robot in one block: shares by which joints, links and base are not as learnt.

All of them are coefficients of one balance of all joints; the references taught its other terms.
A block yields a vector of states with its covariance.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.knowledge import (
    another_day_of, farther, Knowledge, with_unvisited)
from gearbox_monitor.diagnosis.robot.likelihood import Prior, RobotFit, RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import BASE
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog
from gearbox_monitor.diagnosis.robot.rows import NuisanceColumn, RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import PER_LINK
from gearbox_monitor.watch.record import (
    Deviation, FRICTION, Levels, levels_of, RIPPLE, ROTOR, SCALE, TILT, WATCH_SETTINGS, WEIGHT)

# A weight without its inertia would be blamed on the next link, at whose axis a mass has one.
WIDTHS = {FRICTION: 2, SCALE: 1, ROTOR: 1, WEIGHT: PER_LINK, TILT: 2, RIPPLE: 2}
ORDERS = tuple(range(4, 41))  # of ripple, waves per turn: less come with links and loads


@dataclass(frozen=True)
class Group:
    """
    A state of a `kind` at a `place` (joint number `index`), with `width` coefficients.

    order: of a ripple, waves per turn.
    """

    kind: str
    place: str
    index: int
    width: int
    order: int = 0


def groups_of(robot: RobotModel) -> tuple[Group, ...]:
    """
    Return the states of a `robot`, ripples last.

    Only gravity tells a weight from a rotor where no other joint moves the link: the first joint
    needs more of it across (or, if it slides, along) its axis than a tilt that is no alarm gives.
    """
    chain, tips = robot.chain, robot.chain.tips
    joints, still = list(enumerate(chain.joints)), np.zeros((1, len(chain.joints)))
    weighed = {r.link for r in chain.regressors(still, still) if r.joint != r.link
               or np.linalg.norm(r.g) > WATCH_SETTINGS.kinds[TILT].limit}
    out = [Group(kind, name, j, WIDTHS[kind]) for j, name in joints
           for kind in (FRICTION, SCALE, ROTOR, WEIGHT)
           if kind != WEIGHT or (j in weighed and j not in tips and chain.links[j].mass > 0.0)]
    return (*out, Group(TILT, BASE, 0, WIDTHS[TILT]),
            *(Group(RIPPLE, name, j, WIDTHS[RIPPLE], n) for j, name in joints for n in ORDERS
              if not chain.links[j].slides))


def state_levels(robot: RobotModel, groups: Sequence[Group], effort: Array) -> Levels:
    """Return the Levels of `groups` as learnt, of joints with an `effort` (rms [J], N m)."""
    size = np.zeros((len(groups), max(WIDTHS.values())))
    for row, g in zip(size, groups):
        row[:g.width] = _unit(robot, g, effort[g.index])
    limits = [WATCH_SETTINGS.kinds[g.kind] for g in groups]
    jump, drift, apart = (np.array([getattr(x, name) for x in limits])[:, None] * size
                          for name in ('jump', 'drift', 'apart'))
    return levels_of(jump, drift, apart)


def _unit(robot: RobotModel, group: Group, effort: float) -> Array:
    """Return what a share of 1 of a state is [k], of a joint with an `effort` (rms, N m)."""
    link = robot.chain.links[group.index]
    if group.kind == WEIGHT:
        return np.array(link.mass * (link.reach + 0.05) ** np.repeat([0.0, 1.0, 2.0], [1, 3, 6]))
    return np.full(group.width, effort + 1e-9 if group.kind == RIPPLE else 1.0)


@dataclass(frozen=True, eq=False)
class Features:
    """
    The states of a robot as one block shows them.

    deviations: of each group, by how much its states exceed their level [k], and the covariance
    [k, k], as if all others were healthy, None where the block does not show them. gains: deviance
    that each group alone explains. sizes: of each group [k, k], so that x' sizes x is the mean
    square of the torque that states x make; own: states of all that is there [k]. load {link:
    (values [10], covariance [10, 10])}: what it holds. left [J]: power that remains unexplained
    of each joint, over what the references left.
    """

    deviations: tuple[Deviation | None, ...]
    gains: Array
    sizes: tuple[Array, ...]
    own: tuple[Array, ...]
    load: Mapping[str, Deviation]
    left: Array


def features_of(log: RobotLog, robot: RobotModel, knowledge: Knowledge, groups: Sequence[Group],
                level: Sequence[Deviation]) -> Features:
    """
    Return the Features of a block.

    Args:
        log: of the block.
        robot: its model.
        knowledge: taught by the references.
        groups: of `groups_of`.
        level: of the states of each group, mean [k] and covariance [k, k], while it is healthy.
    """
    carrying = replace(robot, carries=robot.chain.tips)
    rows = with_unvisited(rows_of(log, carrying, knowledge.shapes, knowledge.mean),
                          knowledge.visits, knowledge.sizes)
    away = max(farther([rows], knowledge.states) / SETTINGS.farther, 1.0)
    prior, variance = same_day(knowledge, rows), knowledge.variance * away
    rms = np.array([np.sqrt(np.mean(m.effort ** 2)) for m in rows.joints])
    efforts = _explained(RobotLikelihood([rows], prior, variance), rows)
    ripples = {j: _ripples(rows, j) for j in {g.index for g in groups if g.kind == RIPPLE}}
    candidates = [Candidate(
        g.kind, {g.index: ripples[g.index][g.order]} if g.kind == RIPPLE else
        columns_of(rows, g, efforts, rms[g.index]), joint=g.place,
        deviation=WATCH_SETTINGS.widest * _unit(robot, g, rms[g.index])) for g in groups]
    states, kept = list[NuisanceColumn](), [k for k, g in enumerate(groups) if g.kind != RIPPLE]
    for k in kept:
        states += [NuisanceColumn(
            f'{groups[k].kind} {groups[k].place} {i}',
            {j: x[:, i] for j, x in candidates[k].columns.items()},
            float(np.sqrt(level[k][1][i, i]))) for i in range(groups[k].width)]
    prior = Prior((*prior.labels, *(c.label for c in states)),
                  np.concatenate([prior.mean, *(level[k][0] for k in kept)]),
                  scipy.linalg.block_diag(prior.covariance, *(level[k][1] for k in kept)))
    rows = replace(rows, nuisance=(*rows.nuisance, *states))
    evidence = RobotLikelihood([rows], prior, variance)
    fit = evidence.fit()
    posterior = evidence.posterior(fit, knowledge.dispersion)
    load = {name: _load_on(name, posterior)
            for name in (robot.chain.links[k].name for k in carrying.carries)}
    deviations, gains = _deviations(evidence, fit, candidates)
    if any(b @ np.linalg.solve(c, b) > WATCH_SETTINGS.taken for b, c in load.values()):
        rival = max(x for x, g in zip(gains, groups) if g.kind != WEIGHT)
        weights = [c for c in candidates if c.effect == WEIGHT]
        if empty := _weight_instead(evidence, prior, fit, weights, rival):
            evidence, fit = empty, empty.fit()
            deviations, gains = _deviations(evidence, fit, candidates)
            load = {name: (np.zeros_like(b), c) for name, (b, c) in load.items()}
    # Blocks differ by more than their noise, as the references did; an unknown level is no noise.
    for k, (d, c) in enumerate(zip(deviations, candidates)):
        if d is not None:
            known = level[k][1] if k in kept else np.zeros_like(d[1])
            deviations[k] = d[0], dispersed(
                d[1], known, float(np.mean(knowledge.dispersion[list(c.columns)])))
    sizes, own = list[Array](), list[Array]()
    for g, c in zip(groups, candidates):
        simple = g.kind in (TILT, RIPPLE)
        sizes.append(np.eye(2) if simple else
                     sum(x.T @ x for x in c.columns.values()) + 1e-12 * np.eye(g.width))
        own.append(robot.chain.links[g.index].theta if g.kind == WEIGHT else
                   np.array([rms[g.index] if g.kind == RIPPLE else 1.0, 0.0]) if simple else
                   np.ones(g.width))
    left = [np.sum(a.count / w) / np.sum(a.count * of_joint[a.band])
            for a, w, of_joint in zip(evidence.at, fit.weights, variance)]
    return Features(tuple(deviations), gains, tuple(sizes), tuple(own), load, np.array(left))


def _load_on(link: str, posterior: Prior) -> Deviation:
    at = [i for i, label in enumerate(posterior.labels) if label.startswith(f'load {link} ')]
    return posterior.mean[at], posterior.covariance[np.ix_(at, at)]


def _weight_instead(evidence: RobotLikelihood, prior: Prior, fit: RobotFit,
                    weights: Sequence[Candidate], rival: float) -> RobotLikelihood | None:
    """
    Return the evidence without a load if a weight explains more than one, else None.

    A link near the end that weighs more passes for a load of another centre: both move alike but
    for the joints between. A true load explains far more than any weight.

    Args:
        evidence: with a load.
        prior: as of RobotLikelihood.
        fit: of `evidence`.
        weights: states.
        rival: deviance that a state of another kind explains in addition to a load.
    """
    rows, = evidence.recordings
    bare = replace(rows, nuisance=tuple(
        c for c in rows.nuisance if not c.label.startswith('load ')))
    empty = RobotLikelihood([bare], prior, evidence.variance)
    unexplained = empty.fit((), fit)
    gain = _deviations(empty, unexplained, weights)[1].max(initial=-np.inf)
    by_load = unexplained.deviance - fit.deviance - len(rows.nuisance) + len(bare.nuisance)
    return empty if gain - by_load > max(WATCH_SETTINGS.lead, rival) else None


def _deviations(evidence: RobotLikelihood, fit: RobotFit, candidates: Sequence[Candidate]
                ) -> tuple[list[Deviation | None], Array]:
    """
    Return values and covariance of each of `candidates`, added alone to a `fit`; and their gains.

    A gain is the deviance that a candidate explains, less what it would explain by chance.

    Where something has changed, all else is less certain than it will be with that explained: the
    likeliest candidates are fitted with the noise that they leave, and the right one stands out.
    """
    estimates = evidence.estimates(fit, candidates)
    deviations, k = [(e.values, e.covariance) for e in estimates], len(evidence.labels)
    gains = np.array([e.gain - c.size for e, c in zip(estimates, candidates)])
    for i in np.argsort(-gains, kind='stable')[:WATCH_SETTINGS.fitted].tolist():
        if gains[i] > WATCH_SETTINGS.clipped * candidates[i].width:
            own = evidence.fit([candidates[i]], fit)
            deviations[i] = own.values, own.covariance[k:, k:] / np.outer(own.scale, own.scale)
            gains[i] = fit.deviance - own.deviance - candidates[i].size
    return [d if c.acting.any() else None for c, d in zip(candidates, deviations)], gains


def dispersed(covariance: Array, known: Array, dispersion: float) -> Array:
    """Return a `covariance` [k, k], `dispersion` times as large but for what is not `known`."""
    size = covariance + np.diag(1e-9 * np.diag(covariance))
    share, vectors = scipy.linalg.eigh(known, size)
    share = np.clip(share, 0.0, 1.0)    # of what no block shows, less is known than is allowed
    basis = size @ vectors
    widened: Array = (basis * (share + (1.0 - share) * dispersion)) @ basis.T
    return widened


def _explained(evidence: RobotLikelihood, rows: Rows) -> list[Array]:
    """Return what is explained of the effort of each joint [R], with any load, without noise."""
    out = list[Array]()
    for a, target, model, left in zip(evidence.at, rows.target, rows.model,
                                      evidence.fit().residual):
        effort = np.zeros(len(target))
        effort[a.order] = (target + model)[a.order] - left
        out.append(effort)
    return out


def columns_of(rows: Rows, group: Group, efforts: Sequence[Array], rms: float
               ) -> dict[int, Array]:
    """
    Return the columns of the states of a group, without ripples.

    Args:
        rows: of the block.
        group: of states.
        efforts: of each joint without noise.
        rms: of the effort of its joint.
    """
    j, m = group.index, rows.joints[group.index]
    if group.kind == FRICTION:
        least = WATCH_SETTINGS.least_friction * (rms + 1e-9)
        parts = [x if np.sqrt(np.mean(x ** 2)) > least else least * shape
                 for x, shape in ((m.dry, m.sign), (m.wet, m.v))]
        return {j: rows.tested(j, np.stack(parts, axis=1))}
    if group.kind == SCALE:
        return {j: efforts[j][:, None]}
    if group.kind == ROTOR:
        inertia = float(np.mean(rows.inertia[:, j, j]))
        return {j: rows.tested(j, inertia * m.v[:, None], momentum=True)}
    if group.kind == TILT:
        return {k: x[:, :2] for k, x in rows.tilt.items()}
    return {k: rows.inertial[j, k] for k in rows.robot.chain.movers[j]}


def _ripples(rows: Rows, joint: int) -> dict[int, Array]:
    """Return {order: sine and cosine [R, 2]} of the angle of a joint."""
    turns = np.exp(1j * rows.motion.q[:, joint])
    powers = np.cumprod(np.column_stack(
        [turns ** ORDERS[0], *[turns] * (len(ORDERS) - 1)]), axis=1)
    tested = rows.tested(joint, np.concatenate([powers.imag, powers.real], axis=1))
    return {n: tested[:, [k, k + len(ORDERS)]] for k, n in enumerate(ORDERS)}


def same_day(knowledge: Knowledge, rows: Rows) -> Prior:
    """Return the prior of a `knowledge` for `rows` without what friction drifts by in days."""
    groups = {c.label: c.group for c in rows.nuisance}
    prior = knowledge.prior
    drift = another_day_of([groups.get(label) for label in prior.labels], prior.mean)
    return replace(prior, covariance=prior.covariance - drift)
