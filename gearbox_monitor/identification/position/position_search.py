# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Search where the measured motion of the motor drives the model: all candidates on windows.

Every candidate is fitted from where the model without effects stands, with the same effort; the
promising ones go on. Residuals are weighed by the model error that the best fit leaves.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
import math

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood
from gearbox_monitor.identification.candidates import CandidateModel, NOT_FITTED, PERIODIC
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.position import model_error
from gearbox_monitor.identification.search import KEEP_REFINED, Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.prescribed_motion import MOVES

KEEP_SCREENED = 6
SETTLING, STILL = 4, 5.0  # further rounds at most; gain in BIC below which a fit stands still
STRAY = 50.0  # chi2 by which a window may be worse than without effect before it counts as lost


class PositionSearch(Search):
    """The fits of a Recording that holds the motor's motion."""

    def none(self) -> CandidateFit:
        """Fit the model without effects."""
        candidate = self.starts.none()
        point = gauss_newton.robust_then_plain(
            self.long, candidate, likelihood.fresh(self.long, candidate), (8, 8))
        return self.keep(self.as_fitted(candidate, point))

    def none_and_singles(self) -> None:
        """Fit the model without effects and with each single one."""
        self.none()
        self.refine(self.screen())

    def screen(self) -> dict[str, list[CandidateFit]]:
        """Return the rough fits of each single effect, one for each start and order."""
        candidates = [candidate for name in self.ids if name not in NOT_FITTED
                      for order in (self.found_orders(name) if name in PERIODIC else (None,))
                      for candidate in self.starts.candidates(name, order)]
        by_id: dict[str, list[CandidateFit]] = {}
        for screened in self.map(self._screen_one, candidates, 'screening'):
            by_id.setdefault(screened.name, []).append(screened)
        return by_id

    def _screen_one(self, candidate: CandidateModel) -> CandidateFit:
        """Return the rough fit of `candidate` from where none stands."""
        point = self.at_none(candidate, self.fitted[''].point)
        for _ in range(2):
            point = gauss_newton.fit(self.long, candidate, point, 4, robust=True, refresh=(0, 2))
            # Every candidate holds none in it: one that is worse is still on its way.
            if self.promise(candidate, point) > -1.0:
                break
        return self.as_fitted(candidate, point)

    def promise(self, candidate: CandidateModel, point: likelihood.FitPoint) -> float:
        """
        Return the gain in chi2 over none that `point` promises.

        A window that went astray counts no more than STRAY: refining will bring it back.

        Args:
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
        """
        none = self.fitted['']
        bounded_loss = np.minimum(point.chi2, none.point.chi2 + STRAY) - none.point.chi2
        prior = candidate.penalty(point.z) - none.candidate.penalty(none.point.z)
        return -(float(bounded_loss[self.long.train].sum()) + prior)

    def at_none(self, candidate: CandidateModel,
                point: likelihood.FitPoint) -> likelihood.FitPoint:
        """Return a FitPoint of `candidate` at its start, with states and nuisances of `point`."""
        return point.at(candidate.start_from(self.fitted[''].candidate, point.z))

    def refine(self, by_id: Mapping[str, Sequence[CandidateFit]]) -> None:
        """
        Fit the promising ids well, all of them and none with the same means.

        Args:
            by_id: rough fits of each effect.
        """
        cost = math.log(self.long.n_train)
        self.reweigh(min((fit for group in by_id.values() for fit in group),
                         key=lambda f: f.score))
        by_id = {name: [self.rescored(fit) for fit in group] for name, group in by_id.items()}
        none = self.keep(self.polish(self.fitted['']))
        gains = {}
        for name, group in by_id.items():
            self.keep(min(group, key=lambda f: f.score))
            gains[name] = max(self.promise(f.candidate, f.point) - f.candidate.n_effect * cost
                              for f in group)
        ranked = sorted(gains, key=gains.__getitem__, reverse=True)[:KEEP_SCREENED]
        chosen = list(dict.fromkeys([*ranked, *(i for i in self.far(none) if i in by_id)]))
        begun = [max(by_id[name], key=lambda f: self.promise(f.candidate, f.point))
                 for name in chosen]
        for refined in self.map(self.polish, begun, 'refining'):
            self.keep_better(refined)
        for _ in range(2):
            self.cross()
        self.weigh_by_error(['', *self.ranked()[:KEEP_REFINED]])

    def far(self, fitted: CandidateFit) -> list[str]:
        """Return the ids whose value `fitted` has moved far beyond its tolerance."""
        shifted = {c.name for c, z in zip(fitted.candidate.coordinates, fitted.point.z)
                   if c.owner < 0 and abs(z) > THRESHOLDS.far_value * c.prior}
        return [i for i in self.ids if i in EFFECTS and EFFECTS[i].replaces
                and EFFECTS[i].parameters[0].name in shifted]

    def cross(self, names: Sequence[str] | None = None) -> None:
        """
        Fit the best fits and none again.

        Args:
            names: names of the fits.
        """
        names = names or ['', *self.ranked()[:KEEP_REFINED]]
        for name, fit in zip(names, self.map(
                self.polish, [self.fitted[n] for n in names], 'comparing')):
            self.keep(fit, name)

    def settle(self, names: Sequence[str]) -> None:
        """Polish the fits `names` until they stand still: what they leave is to be judged."""
        for _ in range(SETTLING):
            scores = [self.fitted[n].score for n in names]
            self.cross(names)
            if all(b - self.fitted[n].score < STILL for b, n in zip(scores, names)):
                break

    def reweigh(self, reference: CandidateFit) -> None:
        """
        Weigh residuals by what `reference` leaves; score all fits by it.

        One size for all: a model that leaves more has no right to more.
        """
        self.long = replace(self.long, weighing=model_error.weighing(
            self.recording, self.model, self.long.sigma, self._persistent(reference)))
        for name, fit in self.fitted.items():
            self.keep(self.rescored(fit), name)

    def rescored(self, fit: CandidateFit) -> CandidateFit:
        """Return `fit` as its residuals count."""
        point = self.long.evaluate(fit.candidate, fit.point)
        return replace(fit, point=point, score=self.score(self.long, fit.candidate, point))

    def weigh_by_error(self, names: Iterable[str]) -> None:
        """Weigh residuals by what the best of `names` leaves; fit these and none again."""
        names = list(names)
        self.reweigh(min((self.fitted[n] for n in names), key=lambda f: f.score))
        names = list(dict.fromkeys(['', *names, *self.ranked()[:len(names)]]))
        self.cross(names)
        for name in names:
            fit = self.fitted[name]
            persistent = self._persistent(fit)
            self.keep(replace(fit, persistent=persistent, white=fit.point.residual,
                              s=float(persistent[0])), name)

    def _persistent(self, fitted: CandidateFit) -> Array:
        """Return the size [2], N m and rad, of what lasts in the residual of `fitted`."""
        data, point = self.long.plain(), fitted.point
        motor = data.recording.motor
        assert motor is not None
        residual, _ = data.residual(fitted.candidate.model(point.z), point.states, point.memory)
        r = data.parted(residual)[data.train]
        at = data.windows.first[:, None] + np.arange(data.windows.length)
        moving = np.ones(r.shape, bool)
        moving[:, :, 0] = motor[at[data.train], MOVES] != 0.0
        sizes = np.zeros(2)
        sizes[data.channels] = model_error.persistent_sizes(
            r, moving, data.recording.dt) * data.sigma[data.channels]
        return sizes
