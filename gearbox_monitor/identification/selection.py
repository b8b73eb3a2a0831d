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
Which effect: none, one, two or one that is unknown.

search: Search with none and the single effects fitted; best: Fitted; singles: names of single
effects, best first; rough: an encoder has steps above its noise; lack: function that says whether
a CandidateFit leaves more than noise.
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
    """Return by how much `fitted` beats none, in BIC."""
    return search.fitted[''].score - fitted.score


def convincing(search: Search, fitted: CandidateFit) -> bool:
    """Return whether `fitted` (one effect) beats none by more than the search itself explains."""
    if scatters(search, fitted.candidate.ids[0]):
        return gain(search, fitted) > own_margin(search)
    return gain(search, fitted) > MARGIN


def scatters(search: Search, name: str) -> bool:
    """Return whether the effect `name` is a value that may scatter anyway."""
    effect = EFFECTS.get(name)
    value = ZERO if name == ENCODER_OFFSET.id else (
        effect.parameters[0].name if effect and effect.replaces else None)
    return value in nuisances_of(search.model)


def own_margin(search: Search) -> float:
    """
    Return the gain in BIC of an effect that is a value which may scatter anyway.

    A fit without it may move this value, too: what counts is how far beyond the tolerance.
    """
    return OWN_MARGIN - float(np.log(search.long.n_train))


def decide(search: Search, rough: bool = False) -> tuple[CandidateFit, str]:
    """
    Return (CandidateFit, 'effect' | 'none' | 'unknown'): what explains the recording best.

    rough: an encoder has steps above its noise.
    """
    known: dict[int, tuple[CandidateFit, bool]] = {}

    def lack(fitted: CandidateFit) -> bool:
        if id(fitted) not in known:
            known[id(fitted)] = fitted, incomplete(search, fitted, rough)
        return known[id(fitted)][1]

    search.exempt('')
    known_effects = bool(search.ranked())
    explained = by_bursts(search, rough, lack) if known_effects else None
    if explained is not None:
        return explained, 'effect'
    found = convinced(search, lack) if known_effects else None
    if found is None:
        none = finer(search, search.fitted[''], lack)
        return none, 'unknown' if lack(none) else 'none'
    best, singles = found, search.ranked()
    if not search.noisy:
        best = settled(search, best, lack)
    best = finer(search, simpler(search, best), lack)
    hints = forward_gains(search, best)
    if (lack(best) or max((g for g, _ in hints.values()), default=0.0) > PAIR_HINT
            or search.long.weighing is None and search.far(best, search.ids)):
        best = paired(search, singles, lack)
    best = finer(search, best, lack)
    return best, 'unknown' if lack(best) else 'effect'


def convinced(search: Search, lack: Callable[[CandidateFit], bool]) -> CandidateFit | None:
    """Return the best Fitted of one effect, None where it does not convince; lack: of decide."""
    best = search.fitted[search.ranked()[0]]
    if not convincing(search, best) and not search.noisy and lack(search.fitted['']):
        search.rejoin()
        search.settle(['', search.ranked()[0]])
        best = search.fitted[search.ranked()[0]]
    if convincing(search, best):
        search.challenge(best)
        search.exempt('')
        best = search.fitted[search.ranked()[0]]
    return best if convincing(search, best) else None


def settled(search: Search, best: CandidateFit,
            lack: Callable[[CandidateFit], bool]) -> CandidateFit:
    """Return the best Fitted of one effect once those near `best` stand still; lack: of decide."""
    singles = search.ranked()
    near = [n for n in singles if search.fitted[n].score - best.score < NEAR]
    if lack(best):
        search.fitted[best.name] = search.polish(search.grown(best), [best.point])
        near = singles[:2]
    if len(near) > 1:
        search.settle(near[:SETTLED])
    return search.fitted[search.ranked()[0]]


def by_bursts(search: Search, rough: bool,
              lack: Callable[[CandidateFit], bool]) -> CandidateFit | None:
    """
    Return the Fitted of bursts, or of a pair that explains them, None where there are none.

    rough, lack: as of decide.
    """
    if DISTURBANCE.id not in search.ids:
        return None
    if search.long.weighing is None and search.fitted[''].s > 0.0:
        return None  # torque noise on the motor is bursts, too
    burst = disturbance_fit(search)
    if burst is None or not _more(search, burst, rough) or lack(burst):
        return None
    # The very windows that look like bursts may be those in which an effect is stuck.
    search.rejoin()
    search.settle(['', *search.ranked()[:SETTLED]])
    if not _more(search, burst, rough):
        return None
    singles = search.ranked()
    best = search.fitted[singles[0]]
    search.fitted[DISTURBANCE.id] = burst
    if everywhere(search, best) < SHARE * gain(search, burst):
        return burst
    # One effect explains most of the bursts: two may explain them all, with less freedom.
    pairs = find_pairs(search, singles[:2])
    pair = search.fitted[pairs[0]] if pairs else best
    if lack(pair) or everywhere(search, pair) < gain(search, burst):
        return burst
    del search.fitted[DISTURBANCE.id]
    return pair


def _more(search: Search, burst: CandidateFit, rough: bool) -> bool:
    """Return whether bursts explain more than one effect does everywhere; rough: of decide."""
    known = everywhere(search, search.fitted[search.ranked()[0]])
    return gain(search, burst) > (ROUGH_MARGIN if rough else MARGIN) + max(0.0, known)


def paired(search: Search, singles: Sequence[str],
           lack: Callable[[CandidateFit], bool]) -> CandidateFit:
    """
    Return the best Fitted of one effect or two.

    singles: names of the best effects that a second one is added to; lack: as of decide.
    """
    white = search.long.weighing is None
    before = {n: f for n, f in search.fitted.items() if white and f.white is not None}
    pairs = find_pairs(search, singles[:2])
    careful = pairs[:2] if white else pairs
    search.whiten(list(dict.fromkeys([*before, search.ranked()[0], *careful])) if pairs else [])
    for name, fitted in before.items():  # a fit without torque noise has another scale
        search.fitted[name] = min(fitted, search.fitted[name], key=lambda f: f.score)
    best = search.fitted[search.ranked()[0]]
    pairs += search.exempt(best.name)
    pairs = sorted({*pairs} & {*search.fitted}, key=lambda n: search.fitted[n].score)
    if not pairs:
        return best
    pair = search.fitted[pairs[0]]
    if search.noisy:
        pair = next((p for p in map(search.fitted.__getitem__, pairs) if worth(search, best, p)),
                    pair)
    else:
        if lack(pair):
            # Where many windows are astray, they hold the values back that would free them.
            pair = search.fitted[pair.name] = search.polish(search.grown(pair), [pair.point])
            for name in pairs[:RESTARTED]:
                if lack(pair):
                    pair = min(restarted(search, search.fitted[name]), pair, key=lambda f: f.score)
        if worth(search, best, pair):
            # What the pair has found for windows is no merit of its second effect.
            best = search.fitted[best.name] = search.polish(search.grown(best), [pair.point])
    return pair if worth(search, best, pair) and (lack(best) or not lack(pair)) else best


def worth(search: Search, best: CandidateFit, pair: CandidateFit) -> bool:
    """Return whether `pair` beats `best` (one effect) by the price of its second one."""
    more = [i for i in pair.candidate.ids if i not in best.candidate.ids]
    own = len(more) == 1 and scatters(search, more[0])
    return best.score - pair.score > (own_margin(search) if own else PAIR_MARGIN)


def finer(search: Search, best: CandidateFit,
          lack: Callable[[CandidateFit], bool]) -> CandidateFit:
    """
    Return `best` on shorter steps, with which `search` then goes on, where it lacks but these.

    Steps are as long as the nominal drive allows; with the effect it may be a faster one, and the
    readings so good that the edges of its gap show. lack: as of decide.
    """
    if not lack(best) or search.noisy or search.recording.motor is not None:
        return best
    shorter = search.on_shorter_steps()
    if shorter is None:
        return best
    simulator, long, none = search.simulator, search.long, search.fitted['']
    search.simulator, search.long = shorter.simulator, shorter
    found = search.fitted[''] = search.anew(none)
    if best.candidate.ids:
        found = search.anew(best)
    if lack(found):
        search.simulator, search.long, search.fitted[''] = simulator, long, none
        return best
    if best.candidate.ids:
        search.fitted[found.name] = found
    return found


def simpler(search: Search, best: CandidateFit) -> CandidateFit:
    """
    Return an effect of fewer parameters instead of `best` that is at a bound and hardly better.

    Only where both move the drive alike, as in the limit: viscous_drift that has drifted from the
    first moment on is motor_viscous.
    """
    if not best.candidate.at_bound(best.point.z):
        return best
    alike = max(2.0 * BOUND_MARGIN, ALIKE * gain(search, best))
    for name in search.ranked()[1:]:
        other = search.fitted[name]
        if other.score - best.score > BOUND_MARGIN:
            break
        apart = ((other.point.residual - best.point.residual)[search.long.train] ** 2).sum()
        if other.candidate.n_effect < best.candidate.n_effect and apart < alike:
            return other
    return best


def everywhere(search: Search, fitted: CandidateFit) -> float:
    """Return by how much `fitted` beats none in BIC on all windows, held-out ones included."""
    n = search.long.size * len(search.long.windows)
    return float((search.fitted[''].point.chi2 - fitted.point.chi2).sum()
                 - fitted.candidate.n_effect * np.log(n))
