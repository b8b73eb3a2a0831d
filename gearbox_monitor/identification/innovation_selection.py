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
Model selection by innovations, with the evidence of windows.

The likelihood of innovations finds and fits effects however wrong the model is; its smoothed
states begin the windows of 1 s, which then need no search for starts of their own. Windows carry
more evidence where the torque is exact, so that they decide; with torque noise, innovations do.
"""
from collections.abc import Iterable

import numpy as np

from gearbox_monitor.identification import gauss_newton, window_states
from gearbox_monitor.identification.adequacy import incomplete
from gearbox_monitor.identification.disturbance_pulses import disturbance_fit
from gearbox_monitor.identification.effect_scan import scan
from gearbox_monitor.identification.effect_search import EffectSearch, FitTable
from gearbox_monitor.identification.innovation_fit import fitted, InnovationFit
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.search import held_out, Search
from gearbox_monitor.identification.selection import (
    convincing, finer, gain, gain_on_all_windows, MARGIN, OWN_MARGIN, ROUGH_MARGIN, scatters,
    SHARE, simpler, worth)
from gearbox_monitor.identification.smoothed_windows import (
    filterable, smoothed_point, states_of)
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE

NEAR = 60.0        # -2 log L by which windows, which weigh more, may turn a ranking round
COMPARED = 4       # single effects on windows at most
PAIRS = 3          # pairs on windows at most
BEHIND = 100.0     # score by which fits that were not on windows stand behind those that were


def suits_innovations(search: Search) -> bool:
    """Return whether `search` is one of a drive that the filter of the innovations knows."""
    return (filterable(search.recording, search.model) and search.long.colour is None
            and all(name in EFFECTS for name in search.ids))


class WindowEvidence:
    """Innovations of a Search, and the windows that begin in their smoothed states."""

    def __init__(self, search: Search, spans: Iterable[slice], rough: bool) -> None:
        recording, model, sigma = search.recording, search.model, search.long.sigma
        self.search, self.rough = search, rough
        spans = list(spans)
        self.coarse = InnovationLikelihood(recording, model, sigma, spans, coarse=True)
        self.fine = InnovationLikelihood(recording, model, sigma, spans)
        self.whole = InnovationLikelihood(recording, model, sigma, recording.segments)
        self.effects = EffectSearch(self.coarse, search.starts, search.ids, search.jobs,
                                    search.report)
        self.finished: dict[str, InnovationFit] = {}
        self._judged: dict[int, tuple[CandidateFit, bool]] = {}

    def finish(self, fit: InnovationFit) -> CandidateFit:
        """Finish `fit` on short steps and on windows; it joins the fits of the search."""
        fine = fitted(self.fine, fit, 8)
        self.finished[fit.name if fit.candidate.ids else ''] = fine
        out = self.on_windows(fine)
        self.search.fitted[fit.name if fit.candidate.ids else ''] = out
        return out

    def on_windows(self, fit: InnovationFit) -> CandidateFit:
        """Return the CandidateFit on the long windows that begins where `fit` was."""
        search, data, candidate = self.search, self.search.long, fit.candidate
        run = self.whole.run(candidate.model(fit.z), fit.torque)
        smooth = self.whole.smoothed(run)
        point = smoothed_point(data, candidate, fit.z, smooth)
        if not candidate.ids:
            search.short_none = states_of(search.short.windows, fit.z, smooth)
        if search.noisy:
            at = data.windows.first[:, None] + np.arange(data.windows.length) - 1
            white = run.residual[np.maximum(at, 0)][:, :, data.channels]
            return CandidateFit(candidate, point, self.effects.score(fit), float(fit.torque[0]),
                                white.reshape(len(at), -1))
        window_states.rescue(data, candidate, point, half_gap=search.half_gap)
        if candidate.coordinates:
            gauss_newton.fit(data, candidate, point, 3, robust=True)
            gauss_newton.fit(data, candidate, point, 6)
        return search.as_fitted(candidate, point)

    def place_behind(self, fits: Iterable[InnovationFit]) -> None:
        """Let `fits` join the search behind those on windows, in their own order."""
        last = max(f.score for f in self.search.fitted.values())
        none = self.search.fitted['']
        rest = [f for f in fits if f.name not in self.search.fitted]
        for fit in rest:
            score = last + BEHIND + fit.deviance - rest[0].deviance
            self.search.fitted[fit.name] = CandidateFit(fit.candidate, none.point, score)

    def inadequate(self, fit: CandidateFit) -> bool:
        """Return whether `fit` leaves more than noise, judged once for each fit."""
        if id(fit) not in self._judged:
            self._judged[id(fit)] = fit, incomplete(self.search, fit, self.rough)
        return self._judged[id(fit)][1]

    def lacks(self, fit: CandidateFit) -> bool:
        """Return whether a further effect promises more than chance beside `fit`."""
        finished = self.finished.get(fit.name)
        if finished is None:
            return False
        return any(p.gain > (OWN_MARGIN if scatters(self.search, p.name) else MARGIN)
                   for p in scan(self.fine, self.search.starts, finished, self.search.ids)
                   if np.isfinite(p.gain))

    def singles(self) -> FitTable:
        """Fit none and single effects; the best of them on windows."""
        none = self.effects.none()
        table = self.effects.singles(none)
        self.search.use_orders(dict(table.orders))
        self.finish(none)
        for number, fit in enumerate(table.singles[:COMPARED]):
            if number < 2 or fit.deviance < table.singles[0].deviance + NEAR:
                self.finish(fit)
        self.place_behind(table.singles)
        return table

    def pairs(self, table: FitTable) -> list[CandidateFit]:
        """Fit pairs, the best of them on windows; return these, best first."""
        fits = self.effects.pairs(table).pairs
        done = [self.finish(fit) for fit in fits[:PAIRS]]
        self.place_behind(fits)
        return sorted(done, key=lambda f: f.score)


def decide_by_innovations(search: Search, rough: bool = False,
                          whole: bool = False) -> tuple[CandidateFit, str]:
    """
    Return (fit, 'effect' | 'none' | 'unknown'): what explains the recording best.

    Args:
        search: of the recording, for which suits_innovations holds; it takes up all fits.
        rough: whether an encoder is quantised more coarsely than its noise.
        whole: whether windows that are held out elsewhere are fitted, too.
    """
    _, last = held_out(search.recording, search.long.windows)
    spans = search.recording.segments if whole else [
        slice(cut, cut + n) for cut, n in zip(search.recording.cuts, last) if n]
    evidence = WindowEvidence(search, spans, rough)
    table = evidence.singles()
    singles = search.ranked()
    best = search.fitted[singles[0]] if singles else None
    if best is None or not convincing(search, best):
        none = finer(search, search.fitted[''], evidence.inadequate)
        if not evidence.inadequate(none):
            return none, 'none'
        best = none
    else:
        best = finer(search, simpler(search, best), evidence.inadequate)
    lacking = evidence.inadequate(best)
    if lacking:
        pulses = explained_by_pulses(search, rough, evidence)
        if pulses is not None:
            return pulses, 'effect'
    if table.singles and (lacking or evidence.lacks(best)):
        for pair in evidence.pairs(table):
            pair = finer(search, pair, evidence.inadequate)
            if worth(search, best, pair) and (lacking or not evidence.inadequate(pair)):
                best = pair
                break
    return best, 'unknown' if evidence.inadequate(best) else 'effect'


def explained_by_pulses(search: Search, rough: bool,
                        evidence: WindowEvidence) -> CandidateFit | None:
    """
    Return the fit of pulses, None if there are none or one effect explains as much.

    Args:
        search: fits of all candidates to one recording.
        rough: whether an encoder is quantised more coarsely than its noise.
        evidence: that the search was filled from.
    """
    if DISTURBANCE.id not in search.ids or search.noisy:
        return None
    pulses = disturbance_fit(search)
    if pulses is None or evidence.inadequate(pulses):
        return None
    single = search.fitted[search.ranked()[0]]
    explained = max(0.0, gain_on_all_windows(search, single))
    margin = ROUGH_MARGIN if rough else MARGIN
    if gain(search, pulses) < margin + explained / SHARE:
        return None
    search.fitted[DISTURBANCE.id] = pulses
    return pulses
