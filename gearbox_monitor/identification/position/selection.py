# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Selection among fits to windows where the measured motion of the motor drives the model.

Gains are differences of BIC; margins cover what the search over all candidates gains by chance.
"""
from collections.abc import Callable
from functools import cache

import numpy as np

from gearbox_monitor.identification.candidates import nuisances_of, ZERO
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.position import remainder_map
from gearbox_monitor.identification.position.adequacy import leaves_more_than_noise
from gearbox_monitor.identification.position.pair_search import (
    find_pairs, gains_beside, with_third)
from gearbox_monitor.identification.position.position_search import PositionSearch
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.encoder import ENCODER_OFFSET
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP


def gain(search: Search, fitted: CandidateFit) -> float:
    """
    Return by how much `fitted` beats none, in BIC.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    return search.fitted[''].score - fitted.score


def convincing(search: Search, fitted: CandidateFit) -> bool:
    """Return whether `fitted` (one effect) beats none by more than the search itself explains."""
    if scatters(search, fitted.candidate.ids[0]):
        return gain(search, fitted) > own_margin(search)
    return gain(search, fitted) > THRESHOLDS.effect_gain


def scatters(search: Search, name: str) -> bool:
    """
    Return whether the effect `name` is a value that may scatter anyway.

    Args:
        search: fits of all candidates to one recording.
        name: id of an effect.
    """
    effect = EFFECTS.get(name)
    value = ZERO if name == ENCODER_OFFSET.id else (
        effect.parameters[0].name if effect and effect.replaces else None)
    return value in nuisances_of(search.model)


def own_margin(search: Search) -> float:
    """
    Return the gain in BIC of an effect that is a value which may scatter anyway.

    A fit without it may move this value, too: what counts is how far beyond the tolerance.

    Args:
        search: fits of all candidates to one recording.
    """
    return THRESHOLDS.scatter_gain - float(np.log(search.long.n_train))


class PositionEvidence:
    """Evidence of windows alone, where the motion of the motor drives the model."""

    def __init__(self, search: PositionSearch, rough: bool = False) -> None:
        self.search = self.windows = search
        self.inadequate: Callable[[CandidateFit], bool] = cache(
            lambda fit: leaves_more_than_noise(search, fit, rough))

    def convincing_single(self) -> CandidateFit | None:
        """Fit none and single effects; return the best one, None where it does not convince."""
        self.windows.none_and_singles()
        leader = next((self.search.fitted[name] for name in self.search.ranked()), None)
        return leader if leader is not None and convincing(self.search, leader) else None

    def lacks(self, fit: CandidateFit) -> bool:
        """Return whether a further effect promises more than chance beside `fit`."""
        gains = gains_beside(self.windows, self.search.long, fit.candidate, fit.point)
        return any(value > THRESHOLDS.pair_hint for (value, _), *_ in gains.values())

    def pair_beyond(self, fit: CandidateFit) -> CandidateFit:
        """Return the best fit of two or three effects that is worth more than `fit`, else it."""
        search = self.windows
        if not fit.candidate.ids:
            return fit
        names = find_pairs(search, search.ranked()[:2])
        if names:
            search.weigh_by_error(dict.fromkeys([search.ranked()[0], *names]))
        single = search.fitted[search.ranked()[0]]
        pairs = sorted((search.fitted[n] for n in names), key=lambda f: f.score)
        pair = next((p for p in pairs if worth(search, single, p)), None)
        if pair is None or self.inadequate(pair) and not self.inadequate(single):
            return single
        third = with_third(search, pair)
        if third is None or third.score > pair.score:
            return pair
        # By what the better of both leaves, as every comparison.
        search.weigh_by_error([pair.name, third.name])
        pair, third = search.fitted[pair.name], search.fitted[third.name]
        if worth(search, pair, third) and self.holds(third, pair):
            return third
        search.weigh_by_error([pair.name])
        return search.fitted[pair.name]

    def holds(self, fit: CandidateFit, base: CandidateFit) -> bool:
        """Return whether readings that were not fitted prefer `fit` to the simpler `base`."""
        return remainder_map.closer_on_unseen(self.search, fit, base)

    def mapped(self, fit: CandidateFit) -> CandidateFit | None:
        """Return `fit` with a map of the torque that it leaves, None where none is worth it."""
        return remainder_map.on_measured_motion(self.windows, fit)


def decide(evidence: PositionEvidence) -> tuple[CandidateFit, str]:
    """Return (fit, 'effect' | 'none' | 'unknown'): what explains the recording best."""
    search, inadequate = evidence.search, evidence.inadequate
    chosen = evidence.convincing_single()
    if chosen is None:
        chosen = search.fitted['']
        if not inadequate(chosen):
            return chosen, 'none'
    else:
        chosen = simpler(search, chosen)
    if search.ranked() and (inadequate(chosen) or evidence.lacks(chosen)):
        chosen = evidence.pair_beyond(chosen)
    return chosen, 'unknown' if inadequate(chosen) else 'effect'


def parts(evidence: 'PositionEvidence', fit: CandidateFit,
          with_map: bool = True) -> tuple[CandidateFit, CandidateFit]:
    """
    Return (effects that count, the same with a torque map) where the verdict is unknown.

    Effects that readings do not prefer once they are not fitted explain nothing. Beside a map that
    takes up the remainder, effects that only imitated it have no gain left: by BIC they go.

    Args:
        evidence: of the search.
        fit: fit that explains the recording best.
        with_map: whether a map may be fitted; a model has one at most.
    """
    search = evidence.search
    none = search.fitted['']
    effects = [search.fitted[i] for i in fit.candidate.ids if i in search.fitted and i != fit.name]
    effects = sorted(effects, key=lambda f: f.score)
    if fit.candidate.ids:
        effects.insert(0, fit)
    nearest = next((f for f in effects if evidence.holds(f, none)), none)
    if not with_map or any(e['id'] == TORQUE_MAP.id for e in search.model.effects):
        return nearest, nearest
    chosen: tuple[CandidateFit, CandidateFit] | None = None
    for base in sorted((none, *effects), key=lambda f: len(f.candidate.ids)):
        mapped = evidence.mapped(base)
        if mapped is None or not evidence.holds(mapped, base):
            continue
        if chosen is None or (chosen[1].score - mapped.score > THRESHOLDS.further_effect_gain
                              and evidence.holds(mapped, chosen[1])):
            chosen = base, mapped
    if chosen and nearest.score < chosen[1].score and evidence.holds(nearest, chosen[1]):
        chosen = None  # effects alone explain more than the map
    return chosen or (nearest, nearest)


def worth(search: Search, single: CandidateFit, pair: CandidateFit) -> bool:
    """
    Return whether `pair` beats `single` by the price of the effect that it adds.

    Args:
        search: fits of all candidates to one recording.
        single: fit of one effect, or of two.
        pair: fit of one effect more.
    """
    added = [i for i in pair.candidate.ids if i not in single.candidate.ids]
    own = len(added) == 1 and scatters(search, added[0])
    margin = own_margin(search) if own else THRESHOLDS.further_effect_gain
    return single.score - pair.score > margin


def simpler(search: Search, best_fit: CandidateFit) -> CandidateFit:
    """
    Return an effect of fewer parameters instead of `best` that is at a bound and hardly better.

    Only where both move the drive alike, as in the limit: viscous_drift that has drifted from the
    first moment on is motor_viscous.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that explains the recording best.
    """
    if not best_fit.candidate.at_bound(best_fit.point.z):
        return best_fit
    similar = max(2.0 * THRESHOLDS.bound_gain, THRESHOLDS.same_motion * gain(search, best_fit))
    for name in search.ranked()[1:]:
        rival = search.fitted[name]
        if rival.score - best_fit.score > THRESHOLDS.bound_gain:
            break
        distance = ((rival.point.residual - best_fit.point.residual)[search.long.train] ** 2).sum()
        if rival.candidate.n_effect < best_fit.candidate.n_effect and distance < similar:
            return rival
    return best_fit
