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
from dataclasses import replace

import numpy as np

from gearbox_monitor.identification.adequacy import misfit
from gearbox_monitor.identification.candidates import with_free_shape
from gearbox_monitor.identification.effect_scan import scan
from gearbox_monitor.identification.effect_search import EffectSearch
from gearbox_monitor.identification.innovation_fit import fitted, InnovationFit
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.noise_model import white_level
from gearbox_monitor.identification.remainder_map import by_innovations, closer_on_unseen
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.selection import (
    convincing, Evidence, scatters, worth)
from gearbox_monitor.identification.smoothed_windows import (
    on_windows, training_spans, unseen_spans)
from gearbox_monitor.identification.thresholds import THRESHOLDS

COMPARED = 4       # single effects on windows at most
SHAPED = 2         # best single effects that are tried with friction of another shape
PAIRS = 3          # pairs on windows at most
BEHIND = 100.0     # score by which fits that were not on windows stand behind those that were


class InnovationEvidence(Evidence):
    """Innovations of a Search, and the windows that begin in their smoothed states."""

    def __init__(self, search: Search, rough: bool = False) -> None:
        super().__init__(search, rough)
        recording, model = search.recording, search.model
        sigma = white_level(search.long.sigma, search.long.colour)
        spans = training_spans(search)
        self.coarse = InnovationLikelihood(recording, model, sigma, spans, coarse=True)
        self.fine = InnovationLikelihood(recording, model, sigma, spans)
        self.whole = InnovationLikelihood(recording, model, sigma, search.spans)
        self.unseen = InnovationLikelihood(
            recording, model, sigma, unseen) if (unseen := unseen_spans(search)) else None
        self.effects = EffectSearch(self.coarse, search.starts, search.ids, search.jobs,
                                    search.report)
        self.finished: dict[str, InnovationFit] = {}
        self._singles: tuple[InnovationFit, ...] = ()

    def finish(self, fit: InnovationFit) -> CandidateFit:
        """Finish `fit` on short steps and on windows; it joins the fits of the search."""
        fine = self.finished[fit.name] = fitted(self.fine, fit, 8)
        return self.search.keep(on_windows(self.search, fine, self.whole,
                                           self.effects.score(fine)))

    def shaped(self, fit: CandidateFit) -> CandidateFit | None:
        """
        Return the fit that friction of another shape makes complete, None if none does.

        A shape that differs is no effect of its own, and must not find one a partner: `fit`, the
        best single effects and none are fitted along with the sharpness before any pair. One that
        is complete but for what a large first misfit forgives keeps its name.

        Args:
            fit: that leaves more than noise.
        """
        complete: list[CandidateFit] = []
        names = {fit.name: None}
        if self.inadequate(fit):
            names.update(dict.fromkeys([*self.search.ranked()[:SHAPED], '']))
        else:
            excess, structure = misfit(self.search, fit)
            if self.search.noisy or self.rough or (
                    excess < THRESHOLDS.excess and structure < THRESHOLDS.structure):
                return None
        for name in [n for n in names if n in self.finished]:
            finished = self.finished[name]
            candidate = with_free_shape(finished.candidate)
            if candidate is None:
                continue
            freed = len(candidate.coordinates) - len(finished.z)
            z = np.concatenate([np.zeros(freed), finished.z])
            fine = fitted(self.fine, InnovationFit(candidate, z, finished.torque))
            if finished.deviance - fine.deviance < THRESHOLDS.scatter_gain:
                continue
            shaped = on_windows(self.search, fine, self.whole, self.effects.score(fine))
            if not self.inadequate(shaped):
                complete.append(shaped)
        if not complete:
            return None
        best = min(complete, key=lambda f: (
            f.score + THRESHOLDS.effect_gain * bool(f.candidate.ids)))
        return self.search.keep(best)

    def holds(self, fit: CandidateFit, base: CandidateFit) -> bool:
        """
        Return whether readings that were not fitted prefer `fit` to the simpler `base`.

        By their innovations, and by free runs as well where these have no torque noise to follow.

        Args:
            fit: on windows.
            base: of a simpler model.
        """
        of_fit, of_base = map(self.finished.get, (fit.name, base.name))
        if self.unseen is not None and of_fit is not None and of_base is not None:
            deviances = [self.unseen.run(f.candidate.model(f.z), f.torque).deviance
                         for f in (of_fit, of_base)]
            if not deviances[0] < deviances[1]:
                return False
        return self.search.noisy or closer_on_unseen(self.search, fit, base)

    def mapped(self, fit: CandidateFit) -> CandidateFit | None:
        """Return `fit` with a map of the torque that it leaves, None where none is worth it."""
        finished = self.finished.get(fit.name)
        best = finished and by_innovations(self.search, fit, finished, self.fine)
        if best is None:
            return None
        self.finished[best.name] = best
        return on_windows(self.search, best, self.whole, self.effects.score(best))

    def share_starts(self) -> None:
        """Try the window starts of each fit for all others: no start may favour an effect."""
        search = self.search
        if search.noisy:  # innovations decide
            return
        points = {name: fit.point for name, fit in search.fitted.items()}
        for name, fit in list(search.fitted.items()):
            search.keep(search.polish(
                fit, [point for other, point in points.items() if other != name]))

    def place_behind(self, fits: Iterable[InnovationFit]) -> None:
        """Let `fits` join the search behind those on windows, in their own order."""
        worst = max(f.score for f in self.search.fitted.values())
        none = self.search.fitted['']
        waiting = [f for f in fits if f.name not in self.search.fitted]
        for fit in waiting:
            score = worst + BEHIND + fit.deviance - waiting[0].deviance
            self.search.keep(CandidateFit(fit.candidate, replace(none.point, z=fit.z), score))

    def lacks(self, fit: CandidateFit) -> bool:
        """Return whether a further effect promises more than chance beside `fit`."""
        finished = self.finished.get(fit.name)
        if finished is None:
            return False
        return any(p.gain > (THRESHOLDS.scatter_gain if scatters(self.search, p.name)
                             else THRESHOLDS.effect_gain)
                   for p in scan(self.fine, self.search.starts, finished, self.search.ids)
                   if np.isfinite(p.gain))

    def convincing_single(self) -> CandidateFit | None:
        """Fit none and single effects; return the best one, None where it does not convince."""
        search, none = self.search, self.effects.none()
        table = self.effects.singles(none)
        self._singles = table.singles
        search.use_orders(dict(table.orders))
        self.finish(none)
        for number, fit in enumerate(table.singles[:COMPARED]):
            if number < 2 or fit.deviance < table.singles[0].deviance + THRESHOLDS.ranking_error:
                self.finish(fit)
        self.share_starts()
        self.place_behind(table.singles)
        leader = next((search.fitted[name] for name in search.ranked()), None)
        return leader if leader is not None and convincing(search, leader) else None

    def pair_beyond(self, fit: CandidateFit) -> CandidateFit:
        """Return the best fit of two effects that is worth more than `fit`, else `fit`."""
        lacking = self.inadequate(fit)
        pairs = self.effects.pairs(self._singles)
        finished = [self.finish(pair) for pair in pairs[:PAIRS]]
        self.place_behind(pairs)
        for pair in sorted(finished, key=lambda f: f.score):
            pair = self.search.finer(pair, self.inadequate)
            if worth(self.search, fit, pair) and (lacking or not self.inadequate(pair)):
                return pair
        return fit
