# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Model selection: no effect, one, two or an unknown one.

Gains are differences of BIC; margins cover what the search over all candidates gains by chance.
"""
from collections.abc import Callable, Sequence

import numpy as np

from gearbox_monitor.identification.adequacy import incomplete
from gearbox_monitor.identification.candidates import nuisances_of, ZERO
from gearbox_monitor.identification.disturbance_pulses import disturbance_fit
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.pair_search import (
    find_pairs, forward_gains, restarted, SETTLED)
from gearbox_monitor.identification.search import Search
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.effects.encoder import ENCODER_OFFSET

MARGIN = 25.0        # gain in BIC of one effect over none: covers the search over some 35
ROUGH_MARGIN = 250.0  # the same of bursts, where an encoder has steps above its noise
OWN_MARGIN = 16.0    # gain in -2 log L where the effect is a value that may scatter anyway
BOUND_MARGIN = 10.0  # gain in BIC that a parameter at its bound must bring
ALIKE = 1e-3         # share of the gain by which models are apart that move the drive alike
NEAR = 40.0          # difference in BIC that settling may turn round
PAIR_MARGIN = 40.0   # gain in BIC of a second effect
PAIR_HINT = 60.0     # linearised gain of a second effect from which on pairs are fitted
RESTARTED = 2        # pairs whose effects start again where the best of them lacks
SHARE = 0.5          # of what bursts explain, from which on one effect is a part of the answer


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
    return gain(search, fitted) > MARGIN


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
    return OWN_MARGIN - float(np.log(search.long.n_train))


def decide(search: Search, rough: bool = False) -> tuple[CandidateFit, str]:
    """
    Return (fit, 'effect' | 'none' | 'unknown'): what explains the recording best.

    Args:
        search: fits of all candidates to one recording.
        rough: whether an encoder is quantised more coarsely than its noise.
    """
    judged: dict[int, tuple[CandidateFit, bool]] = {}

    def inadequate(fitted: CandidateFit) -> bool:
        """Return whether `fitted` leaves more than noise, judged once for each fit."""
        if id(fitted) not in judged:
            judged[id(fitted)] = fitted, incomplete(search, fitted, rough)
        return judged[id(fitted)][1]

    search.exempt('')
    known_effects = bool(search.ranked())
    explained = explained_by_pulses(search, rough, inadequate) if known_effects else None
    if explained is not None:
        return explained, 'effect'
    convincing_fit = convinced(search, inadequate) if known_effects else None
    if convincing_fit is None:
        none = finer(search, search.fitted[''], inadequate)
        return none, 'unknown' if inadequate(none) else 'none'
    best_fit, singles = convincing_fit, search.ranked()
    if not search.noisy:
        best_fit = settled(search, best_fit, inadequate)
    best_fit = finer(search, simpler(search, best_fit), inadequate)
    hints = forward_gains(search, best_fit)
    if (inadequate(best_fit) or max((g for g, _ in hints.values()), default=0.0) > PAIR_HINT
            or search.long.weighing is None and search.far(best_fit, search.ids)):
        best_fit = paired(search, singles, inadequate)
    best_fit = finer(search, best_fit, inadequate)
    return best_fit, 'unknown' if inadequate(best_fit) else 'effect'


def convinced(search: Search, inadequate: Callable[[CandidateFit], bool]) -> CandidateFit | None:
    """
    Return the best CandidateFit of one effect, None where it does not convince; lack: of decide.

    Args:
        search: fits of all candidates to one recording.
        inadequate: function that tells whether a fit leaves more than noise.
    """
    best_fit = search.fitted[search.ranked()[0]]
    if not convincing(search, best_fit) and not search.noisy and inadequate(search.fitted['']):
        search.rejoin()
        search.settle(['', search.ranked()[0]])
        best_fit = search.fitted[search.ranked()[0]]
    if convincing(search, best_fit):
        search.challenge(best_fit)
        search.exempt('')
        best_fit = search.fitted[search.ranked()[0]]
    return best_fit if convincing(search, best_fit) else None


def settled(search: Search, best_fit: CandidateFit,
            inadequate: Callable[[CandidateFit], bool]) -> CandidateFit:
    """
    Return the best CandidateFit of one effect once those near `best` stand still; lack: of decide.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that explains the recording best.
        inadequate: function that tells whether a fit leaves more than noise.
    """
    singles = search.ranked()
    neighbours = [n for n in singles if search.fitted[n].score - best_fit.score < NEAR]
    if inadequate(best_fit):
        search.fitted[best_fit.name] = search.polish(search.grown(best_fit), [best_fit.point])
        neighbours = singles[:2]
    if len(neighbours) > 1:
        search.settle(neighbours[:SETTLED])
    return search.fitted[search.ranked()[0]]


def explained_by_pulses(search: Search, rough: bool,
                        inadequate: Callable[[CandidateFit], bool]) -> CandidateFit | None:
    """
    Return the fit of pulses, or of a pair that explains them, None if there are none.

    Args:
        search: fits of all candidates to one recording.
        rough: whether an encoder is quantised more coarsely than its noise.
        inadequate: function that tells whether a fit leaves more than noise.
    """
    if DISTURBANCE.id not in search.ids:
        return None
    if search.long.weighing is None and search.fitted[''].s > 0.0:
        return None  # torque noise on the motor is bursts, too
    pulses = disturbance_fit(search)
    if pulses is None or not _more(search, pulses, rough) or inadequate(pulses):
        return None
    # The very windows that look like bursts may be those in which an effect is stuck.
    search.rejoin()
    search.settle(['', *search.ranked()[:SETTLED]])
    if not _more(search, pulses, rough):
        return None
    singles = search.ranked()
    best_fit = search.fitted[singles[0]]
    search.fitted[DISTURBANCE.id] = pulses
    if gain_on_all_windows(search, best_fit) < SHARE * gain(search, pulses):
        return pulses
    # One effect explains most of the bursts: two may explain them all, with less freedom.
    pairs = find_pairs(search, singles[:2])
    pair = search.fitted[pairs[0]] if pairs else best_fit
    if inadequate(pair) or gain_on_all_windows(search, pair) < gain(search, pulses):
        return pulses
    del search.fitted[DISTURBANCE.id]
    return pair


def _more(search: Search, pulses: CandidateFit, rough: bool) -> bool:
    """Return whether bursts explain more than one effect does everywhere; rough: of decide."""
    single_gain = gain_on_all_windows(search, search.fitted[search.ranked()[0]])
    return gain(search, pulses) > (ROUGH_MARGIN if rough else MARGIN) + max(0.0, single_gain)


def paired(search: Search, singles: Sequence[str],
           inadequate: Callable[[CandidateFit], bool]) -> CandidateFit:
    """
    Return the best fit of one effect or two.

    Args:
        search: fits of all candidates to one recording.
        singles: names of the best effects that a second one is added to.
        inadequate: function that tells whether a fit leaves more than noise.
    """
    white = search.long.weighing is None
    whitened_fits = {n: f for n, f in search.fitted.items() if white and f.white is not None}
    pairs = find_pairs(search, singles[:2])
    careful = pairs[:2] if white else pairs
    search.whiten(list(dict.fromkeys([*whitened_fits, search.ranked()[0],
                                      *careful])) if pairs else [])
    for name, fitted in whitened_fits.items():  # a fit without torque noise has another scale
        search.fitted[name] = min(fitted, search.fitted[name], key=lambda f: f.score)
    best_fit = search.fitted[search.ranked()[0]]
    pairs += search.exempt(best_fit.name)
    pairs = sorted({*pairs} & {*search.fitted}, key=lambda n: search.fitted[n].score)
    if not pairs:
        return best_fit
    pair = search.fitted[pairs[0]]
    if search.noisy:
        pair = next(
            (p for p in map(search.fitted.__getitem__, pairs) if worth(search, best_fit, p)), pair)
    else:
        if inadequate(pair):
            # Where many windows are astray, they hold the values back that would free them.
            pair = search.fitted[pair.name] = search.polish(search.grown(pair), [pair.point])
            for name in pairs[:RESTARTED]:
                if inadequate(pair):
                    pair = min(restarted(search, search.fitted[name]), pair, key=lambda f: f.score)
        if worth(search, best_fit, pair):
            # What the pair has found for windows is no merit of its second effect.
            best_fit = search.fitted[best_fit.name] = search.polish(search.grown(best_fit),
                                                                    [pair.point])
    return pair if worth(search, best_fit,
                         pair) and (inadequate(best_fit) or not inadequate(pair)) else best_fit


def worth(search: Search, single: CandidateFit, pair: CandidateFit) -> bool:
    """
    Return whether `pair` beats `best` (one effect) by the price of its second one.

    Args:
        search: fits of all candidates to one recording.
        single: fit of one effect.
        pair: fit of two effects.
    """
    added = [i for i in pair.candidate.ids if i not in single.candidate.ids]
    own = len(added) == 1 and scatters(search, added[0])
    return single.score - pair.score > (own_margin(search) if own else PAIR_MARGIN)


def finer(search: Search, best_fit: CandidateFit,
          inadequate: Callable[[CandidateFit], bool]) -> CandidateFit:
    """
    Return `best` on shorter steps, with which `search` then goes on, where it lacks but these.

    Steps are as long as the nominal drive allows; with the effect it may be a faster one, and the
    readings so good that the edges of its gap show.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that explains the recording best.
        inadequate: function that tells whether a fit leaves more than noise.
    """
    if not inadequate(best_fit) or search.noisy or search.recording.motor is not None:
        return best_fit
    shorter = search.on_shorter_steps()
    if shorter is None:
        return best_fit
    simulator, long, none = search.simulator, search.long, search.fitted['']
    search.simulator, search.long = shorter.simulator, shorter
    refitted = search.fitted[''] = search.anew(none)
    if best_fit.candidate.ids:
        refitted = search.anew(best_fit)
    if inadequate(refitted):
        search.simulator, search.long, search.fitted[''] = simulator, long, none
        return best_fit
    if best_fit.candidate.ids:
        search.fitted[refitted.name] = refitted
    return refitted


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
    similar = max(2.0 * BOUND_MARGIN, ALIKE * gain(search, best_fit))
    for name in search.ranked()[1:]:
        rival = search.fitted[name]
        if rival.score - best_fit.score > BOUND_MARGIN:
            break
        distance = ((rival.point.residual - best_fit.point.residual)[search.long.train] ** 2).sum()
        if rival.candidate.n_effect < best_fit.candidate.n_effect and distance < similar:
            return rival
    return best_fit


def gain_on_all_windows(search: Search, fitted: CandidateFit) -> float:
    """
    Return by how much `fitted` beats none in BIC on all windows, held-out ones included.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    n = search.long.size * len(search.long.windows)
    return float((search.fitted[''].point.chi2 - fitted.point.chi2).sum()
                 - fitted.candidate.n_effect * np.log(n))
