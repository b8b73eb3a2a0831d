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
Search over all candidates: fitted on the same windows, with the same effort, ranked by BIC.

Short windows (0.25 s) find the right contact of the backlash and rough values, windows of 1 s
carry the evidence. The score is -2 log likelihood of the training windows plus p log n (Schwarz
1978).
"""
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
import math
from typing import Any, TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood, model_error, window_states
from gearbox_monitor.identification.candidates import (
    CandidateModel, NOT_FITTED, ORDERS, PERIODIC, PHASED, replaced_value, Starts, with_effects)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.process_noise import fit_with_process_noise, levels
from gearbox_monitor.identification.shooting import shooting_windows, ShootingWindows, Simulator
from gearbox_monitor.identification.torque_domain import simulator
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.prescribed_motion import MOVES
from gearbox_monitor.quality.recording import UniformRecording

SHORT, LONG = 0.25, 1.0  # s
HELD_OUT = 0.3
KEEP_SCREENED, KEEP_REFINED = 6, 4
SETTLING, STILL = 4, 5.0  # further rounds at most; gain in BIC below which a fit stands still
STRAY = 50.0  # chi2 by which a window may be worse than without effect before it counts as lost
JAGGED_PROBE = 0.3  # of the scale, where what is made small is jagged (multiscale)
FINER = 4     # times as many steps, where long ones are suspected
FAR = 2.5     # tolerances from which on a nominal value is tried as an effect of its own
Item = TypeVar('Item')
Outcome = TypeVar('Outcome')
Trial: TypeAlias = tuple[str, int | None]  # id, N


def held_out(recording: UniformRecording, windows: ShootingWindows) -> tuple[Flags, list[int]]:
    """
    Return (train [W], samples of each joined recording before the held-out windows).

    Held out are the last windows of each recording, 30 %.
    """
    train, last = np.ones(len(windows), bool), []
    part = np.searchsorted(recording.cuts, windows.first, side='right') - 1
    for i, cut_at in enumerate(recording.cuts):
        own_windows = np.flatnonzero(part == i)
        validation = round(HELD_OUT * len(own_windows))
        if validation:
            train[own_windows[-validation:]] = False
        training = own_windows[:len(own_windows) - validation]
        end = windows.first[training[-1]] + windows.length if len(training) else cut_at
        last.append(int(end) - cut_at)
    return train, last


@dataclass
class Screened:
    """One start of an effect, roughly fitted: long windows, short ones, and what they promise."""

    long: CandidateFit
    short: likelihood.FitPoint
    long_gain: float
    short_gain: float

    @property
    def name(self) -> str:
        """Id of the effect."""
        return self.long.name


def _long_gain(screened: Screened) -> float:
    return screened.long_gain


def _short_gain(screened: Screened) -> float:
    return screened.short_gain


class Search:
    """
    All fits of one Recording under one DriveModel.

    sigma [2] rad; only, exclude: ids; jobs: threads; progress(done, total, text) is called as it
    goes on; colour [2]: see coloured_noise.
    """

    def __init__(self, recording: UniformRecording, model: DriveModel, sigma: Array,
                 ids: Iterable[str], jobs: int = 1, progress: Callable[..., object] | None = None,
                 colour: Array | None = None) -> None:
        self.recording, self.model, self.ids = recording, model, list(ids)
        self.simulator = simulator(recording, model)
        self.starts = Starts(model, recording)
        windows = shooting_windows(recording, LONG)
        train, last = held_out(recording, windows)
        weighing = model_error.weighing(recording, model, sigma)
        self.long = likelihood.WindowData(recording, self.simulator, windows, sigma, train,
                                          weighing, colour)
        # Where the motor's motion is put in, long windows hold no contact of the gap, either.
        length = SHORT if recording.motor is None else LONG
        self.short = likelihood.WindowData(recording, simulator(recording, model, coarse=True),
                                           shooting_windows(recording, length, last), sigma,
                                           weighing=weighing, colour=colour)
        self.jobs, self._progress = jobs, progress or (lambda *_: None)
        self._pool = ThreadPoolExecutor(jobs)
        self._done, self._total = 0, 1
        self.fitted: dict[str, CandidateFit] = {}
        self.short_none: likelihood.FitPoint = likelihood.UNSET
        self._orders: dict[str, list[int]] = {}

    # ------------------------------------------------------------------ helpers

    def map(self, function: Callable[[Item], Outcome], items: Sequence[Item],
            text: str) -> list[Outcome]:
        """
        Return [function(item)] of all items, in threads; says how far it is.

        Args:
            function: what is applied to each item.
            items: arguments of the function.
            text: what the progress reports.
        """
        self._total += len(items)

        def one(item: Item) -> Outcome:
            """Apply the function to `item` and report the progress."""
            out = function(item)
            self._done += 1
            name = getattr(item, 'name', item if isinstance(item, str) else '')
            leader = next(iter(self.ranked()), '')
            self._progress(self._done, self._total,
                           f'{text} {name}' + (f', best {leader}' if leader else ''))
            return out
        return list(self._pool.map(one, items))

    def report(self, text: str) -> None:
        """Report that `text` is under way."""
        self._total += 1
        self._done += 1
        self._progress(self._done, self._total, text)

    def use_orders(self, orders: dict[str, list[int]]) -> None:
        """Take over {id: orders N, best first} of periodic effects."""
        self._orders.update(orders)

    @property
    def half_gap(self) -> float:
        """Half gap of the model (rad), the scale on which windows are started elsewhere."""
        return max(self.model.transmission.half_gap, 0.01)

    def score(self, data: likelihood.WindowData, candidate: CandidateModel,
              point: likelihood.FitPoint) -> float:
        """
        Return the BIC (Schwarz 1978) of `point` on the training windows of `data`.

        Args:
            data: long or short windows.
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
        """
        plain = likelihood.objective(candidate, point, data.train.astype(float))
        return plain + candidate.n_effect * math.log(data.n_train)

    def as_fitted(self, candidate: CandidateModel, point: likelihood.FitPoint) -> CandidateFit:
        """Return the CandidateFit of `candidate` at `point`, scored."""
        return CandidateFit(candidate, point, self.score(self.long, candidate, point))

    def found_orders(self, name: str) -> list[int]:
        """Return the orders N that find_orders found for the periodic effect `name`."""
        return self._orders[name]

    # ------------------------------------------------------------------ none

    def none(self) -> CandidateFit:
        """Fit the model without effects; keeps the short windows' point, too."""
        candidate = self.starts.none()
        point = likelihood.fresh(self.short, candidate)
        index = np.arange(len(self.short.windows))
        point.states, _ = window_states.solve_states(
            self.short, candidate.model(point.z), point.states, point.memory, index)
        self.short.evaluate(candidate, point)
        for robust in (True, False):
            window_states.rescue(self.short, candidate, point, half_gap=self.half_gap)
            if candidate.coordinates:
                gauss_newton.fit(self.short, candidate, point, 6, robust=robust)
        self.short_none = point
        long = likelihood.FitPoint(point.z.copy(), self.long_states(point, candidate),
                                   np.zeros((len(self.long.windows), 4)))
        index = np.arange(len(self.long.windows))
        long.states, _ = window_states.solve_states(
            self.long, candidate.model(long.z), long.states, long.memory, index)
        self.long.evaluate(candidate, long)
        window_states.rescue(self.long, candidate, long, half_gap=self.half_gap)
        if candidate.coordinates:
            gauss_newton.fit(self.long, candidate, long, 4, robust=True)
            gauss_newton.fit(self.long, candidate, long, 4)
        self.fitted[''] = self.as_fitted(candidate, long)
        return self.fitted['']

    def long_states(self, short_point: likelihood.FitPoint, candidate: CandidateModel) -> Array:
        """
        Return states [W, 4] of the long windows: those of the short ones where they begin.

        Args:
            short_point: point of the short windows.
            candidate: model to be fitted, with its coordinates.
        """
        states = self.long.raw_states()
        at = {int(b): w for w, b in enumerate(self.short.windows.begin)}
        for w, begin in enumerate(self.long.windows.begin):
            if int(begin) in at:
                states[w] = short_point.states[at[int(begin)]]
        return states

    # ------------------------------------------------------------------ single effects

    def none_and_singles(self) -> None:
        """Fit the model without effects and with each single one."""
        self.none()
        self.refine(self.screen())

    def screen(self) -> dict[str, list[Screened]]:
        """Fit all single effects roughly; keeps the best of each id in `fitted`."""
        ids = [i for i in self.ids if i not in NOT_FITTED]
        candidates = []
        self.find_orders()
        for name in ids:
            if name in PERIODIC:
                for order in self._orders[name]:
                    candidates += self.starts.candidates(name, order)
            else:
                candidates += self.starts.candidates(name)
        by_id: dict[str, list[Screened]] = {}
        for screened in self.map(self._screen_one, candidates, 'screening'):
            by_id.setdefault(screened.long.name, []).append(screened)
        return by_id

    def _screen_one(self, candidate: CandidateModel) -> Screened:
        """Return the Screened `candidate`, fitted from where none stands."""
        none = self.fitted['']
        points = []
        starts = [(self.short, self.short_none), (self.long, none.point)]
        if self.recording.motor is not None:  # both have windows of the same length
            del starts[0]
        for data, start in starts:
            point = self.at_none(candidate, start)
            for _ in range(2):
                gauss_newton.fit(data, candidate, point, 4, robust=True, refresh=(0, 2))
                # Every candidate holds none in it: one that is worse is still on its way.
                if self.promise(data, candidate, point, start) > -1.0:
                    break
            points.append(point)
        short, long = points[0], points[-1]
        return Screened(self.as_fitted(candidate, long), short,
                        self.promise(self.long, candidate, long, none.point),
                        self.promise(starts[0][0], candidate, short, starts[0][1]))

    def promise(self, data: likelihood.WindowData, candidate: CandidateModel,
                point: likelihood.FitPoint, none_point: likelihood.FitPoint) -> float:
        """
        Return the gain in BIC over none that `point` promises.

        A window that went astray counts no more than STRAY: refining will bring it back.

        Args:
            data: long or short windows.
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
            none_point: point of the fit without effects.
        """
        bounded_loss = np.minimum(point.chi2, none_point.chi2 + STRAY) - none_point.chi2
        base = self.fitted[''].candidate
        prior = candidate.penalty(point.z) - base.penalty(none_point.z)
        return -(float(bounded_loss[data.train].sum()) + prior)

    def at_none(self, candidate: CandidateModel,
                point: likelihood.FitPoint) -> likelihood.FitPoint:
        """Return a FitPoint of `candidate` at its start, with states and nuisances of `point`."""
        return likelihood.copied(
            point, candidate.start_from(self.fitted[''].candidate, point.z))

    def refine(self, by_id: dict[str, list[Screened]]) -> None:
        """
        Fit the promising ids well, all of them and none with the same means.

        Args:
            by_id: screened starts of each effect.
        """
        cost = math.log(self.long.n_train)
        parts = [p for group in by_id.values() for p in group]
        if self.long.weighing is not None:
            self.reweigh([p.long for p in parts])
        # What another fit has found for a window that went astray is no merit of its effect.
        none = self.polish(self.fitted[''], [p.long.point for p in parts])
        self.fitted[''] = none
        for p in parts:
            p.long_gain = self.promise(self.long, p.long.candidate, p.long.point, none.point)

        def best_ids(by: Callable[[Screened], float]) -> list[str]:
            """Return the most promising ids by the key `by`."""
            gains = {i: max(by(p) - p.long.candidate.n_effect * cost for p in parts)
                     for i, parts in by_id.items()}
            return sorted(gains, key=gains.__getitem__, reverse=True)[:KEEP_SCREENED]
        for name, parts in by_id.items():
            self.fitted[name] = min((p.long for p in parts), key=lambda f: f.score)
        chosen = dict.fromkeys(best_ids(_long_gain) + best_ids(_short_gain) + self.far(none,
                                                                                       by_id))
        jobs = [(name, by_id[name]) for name in chosen]
        for name, refined in zip(chosen, self.map(self._refine_one, jobs, 'refining')):
            self.fitted[name] = min(refined, self.fitted[name], key=lambda f: f.score)
        for _ in range(2):
            self.cross()
        self.whiten(['', *self.ranked()[:KEEP_REFINED]])

    def far(self, fitted: CandidateFit, ids: Iterable[str]) -> list[str]:
        """Return those of `ids` whose value `fitted` has moved far beyond its tolerance."""
        shifted = {c.name for c, z in zip(fitted.candidate.coordinates, fitted.point.z)
                   if c.owner < 0 and abs(z) > FAR * c.prior}
        return [i for i in ids if i in EFFECTS and EFFECTS[i].replaces
                and EFFECTS[i].parameters[0].name in shifted]

    def _refine_one(self, job: tuple[str, list[Screened]]) -> CandidateFit:
        _, parts = job
        short = max(parts, key=_short_gain)
        candidate = short.long.candidate
        long = max(parts, key=_long_gain).long
        trials = [long, self.as_fitted(candidate, self.to_long(candidate, short.short)),
                  self.grown(long)]
        none = self.fitted[''].point
        return self.polish(max(trials, key=lambda f: self.promise(
            self.long, f.candidate, f.point, none)), [none])

    def to_long(self, candidate: CandidateModel,
                short_point: likelihood.FitPoint) -> likelihood.FitPoint:
        """
        Return the point of the long windows that starts where `short_point` ended.

        Args:
            candidate: model to be fitted, with its coordinates.
            short_point: point of the short windows.
        """
        point = likelihood.FitPoint(short_point.z.copy(), self.long_states(short_point, candidate),
                                    np.zeros((len(self.long.windows), 4)))
        index = np.arange(len(self.long.windows))
        point.states, _ = window_states.solve_states(
            self.long, candidate.model(point.z), point.states, point.memory, index, 4)
        return self.long.evaluate(candidate, point)

    def grown(self, fitted: CandidateFit) -> CandidateFit:
        """Return `fitted` found anew on windows that get longer."""
        if self.recording.motor is not None:  # runs whose begin is known do not go astray
            return fitted
        point = gauss_newton.grow(self.long, fitted.candidate, fitted.point, self.half_gap)
        return self.as_fitted(fitted.candidate, point)

    def polish(self, fitted: CandidateFit,
               rivals: Sequence[likelihood.FitPoint] = ()) -> CandidateFit:
        """
        Rescue and refit `fitted` on the long windows: robust, then plain.

        Args:
            fitted: fit on the long windows.
            rivals: points of other fits whose window states are tried.
        """
        candidate, point = fitted.candidate, likelihood.copied(fitted.point)
        window_states.rescue(self.long, candidate, point, rivals, half_gap=self.half_gap)
        if candidate.coordinates:
            gauss_newton.fit(self.long, candidate, point, 4, robust=True)
            gauss_newton.fit(self.long, candidate, point, 6)
        return min(self.as_fitted(candidate, point), fitted, key=lambda f: f.score)

    def on_shorter_steps(self) -> likelihood.WindowData | None:
        """Return the long windows run on steps as short as need be, None: they are already."""
        shorter = Simulator(self.recording, self.model, finer=FINER)
        if self.simulator.n == shorter.n:
            return None
        long = self.long
        return likelihood.WindowData(self.recording, shorter, long.windows, long.sigma, long.train,
                                     long.weighing, long.colour)

    def anew(self, fitted: CandidateFit) -> CandidateFit:
        """Return `fitted` refitted from where it is: long windows run otherwise than before."""
        point = self.long.evaluate(fitted.candidate, likelihood.copied(fitted.point))
        gauss_newton.fit(self.long, fitted.candidate, point, 4, robust=True)
        gauss_newton.fit(self.long, fitted.candidate, point, 6)
        return self.as_fitted(fitted.candidate, point)

    def cross(self, names: Sequence[str] | None = None) -> None:
        """
        Give the best fits and none each other's window states, and fit them again.

        Args:
            names: names of the fits.
        """
        names = names or ['', *self.ranked()[:KEEP_REFINED]]
        points = [self.fitted[n].point for n in names]
        jobs = [self.fitted[n] for n in names]
        fits = self.map(lambda f: self.polish(f, points), jobs, 'comparing')
        self.fitted.update(zip(names, fits))

    def rejoin(self) -> None:
        """Polish what fits worse than none from where none is: every candidate holds it."""
        none = self.fitted['']
        jobs = [f for f in map(self.fitted.__getitem__, self.ranked()) if f.score > none.score]
        for polished in self.map(lambda f: self.polish(f, [none.point]), jobs, 'comparing'):
            self.fitted[polished.name] = polished

    def settle(self, names: Sequence[str]) -> None:
        """Polish the fits `names` until they stand still: what they leave is to be judged."""
        for _ in range(SETTLING):
            scores = [self.fitted[n].score for n in names]
            self.cross(names)
            if all(b - self.fitted[n].score < STILL for b, n in zip(scores, names)):
                break

    @property
    def noisy(self) -> bool:
        """Whether torque noise on the motor is part of the likelihood."""
        model = self.model
        return (model.tolerance > 0.0 or bool(model.process_torque)
                or model.process_torque_time > 0.0)

    def whiten(self, names: Sequence[str]) -> None:
        """Fit `names` again with torque noise; all others stay behind them."""
        if not self.noisy or not names:
            return
        if self.long.weighing is not None:
            self._whiten_by_model_error(names)
            return
        fits = dict(zip(names, self.map(
            lambda n: self._whitened(self.fitted[n].candidate, self.fitted[n].point), names,
            'torque noise')))
        highest = max(f.score for f in fits.values())
        plain_highest = max(self.fitted[n].score for n in names)
        for name, fitted in self.fitted.items():
            if fitted.white is None and name not in fits:
                fitted.score = highest + max(fitted.score - plain_highest, 1.0)
        self.fitted.update(fits)

    def reweigh(self, fits: Sequence[CandidateFit]) -> None:
        """
        Weigh residuals by what the best of `fits` leaves; score all fits by it.

        One size for all: a model that leaves more has no right to more.
        """
        reference = min(fits, key=lambda f: f.score)
        weighing = model_error.weighing(self.recording, self.model, self.long.sigma,
                                        self._persistent(reference))
        for data in (self.long, self.short):
            data.weighing = weighing
        for fitted in {id(f): f for f in (*fits, *self.fitted.values())}.values():
            self.long.evaluate(fitted.candidate, fitted.point)
            fitted.score = self.score(self.long, fitted.candidate, fitted.point)
        self.short.evaluate(self.starts.none(), self.short_none)

    def _whiten_by_model_error(self, names: Sequence[str]) -> None:
        """Weigh residuals by what the best of `names` leaves; fit these and none again."""
        self.reweigh([self.fitted[n] for n in names] or [self.fitted['']])
        names = list(dict.fromkeys(['', *names, *self.ranked()[:len(names)]]))
        self.cross(names)
        for name in names:
            fitted = self.fitted[name]
            fitted.persistent, fitted.white = self._persistent(fitted), fitted.point.residual
            fitted.s = float(fitted.persistent[0])

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

    def in_sensor_units(self) -> 'Search':
        """Return the search with residuals in standard deviations of the encoders' noise."""
        if self.long.weighing is None and self.long.colour is None:
            return self
        out = copy(self)
        out.long, out.short = self.long.uncoloured(), self.short.uncoloured()
        out.fitted = {
            name: replace(f, white=None, point=out.long.evaluate(
                f.candidate, likelihood.copied(f.point))) for name, f in self.fitted.items()}
        return out

    def _whitened(self, candidate: CandidateModel, point: likelihood.FitPoint) -> CandidateFit:
        point, deviance, s, white = fit_with_process_noise(self.long, candidate, point,
                                                           levels(self.model, self.recording.u))
        return CandidateFit(candidate, point,
                            deviance + candidate.n_effect * math.log(self.long.n_train), s, white)

    def exempt(self, name: str) -> list[str]:
        """
        Fit `name` with each value that is far beyond its tolerance as an effect instead.

        They join `fitted` where they are better; returns their names. From where `name` is: that
        the value is another one is known already, and what it is as well.
        """
        if not self.noisy or self.long.weighing is not None:
            return []
        base = self.fitted[name]
        names = []
        for second in self.far(base, self.ids):
            single = self.starts.candidates(second)[0]
            c = EFFECTS[second].parameters[0].name
            nuisances = {k.name: v for k, v in zip(base.candidate.coordinates, base.point.z)
                         if k.owner < 0}
            value = (replaced_value(self.model, second) or 0.0) * (1.0 + nuisances[c])
            moved = np.where([k.owner < 0 for k in single.coordinates], 0.0, value)
            joint = self.starts.joint([(base.candidate, base.point.z), (single, moved)])
            z = joint.start_from(base.candidate, base.point.z)
            point = self.long.evaluate(joint, likelihood.copied(base.point, z))
            joint_fit = self._whitened(joint, point)
            rivals = [f for f in self.fitted.values()
                      if sorted(f.candidate.ids) == sorted(joint.ids)]
            for rival in rivals:
                del self.fitted[rival.name]
            joint_fit = min([joint_fit, *rivals], key=lambda f: f.score)
            self.fitted[joint_fit.name] = joint_fit
            names.append(joint_fit.name)
        return names

    def challenge(self, fitted: CandidateFit) -> None:
        """Fit none from where `fitted` is: what it found for nominal values is no merit of it."""
        if not self.noisy or self.long.weighing is not None:
            return
        none = self.fitted['']
        z = none.candidate.start_from(fitted.candidate, fitted.point.z)
        point = self.long.evaluate(none.candidate, likelihood.copied(fitted.point, z))
        window_states.rescue(self.long, none.candidate, point, [none.point],
                             half_gap=self.half_gap)
        null_fit = self._whitened(none.candidate, point)
        self.fitted[''] = min(null_fit, none, key=lambda f: f.score)

    def ranked(self, size: int = 1) -> list[str]:
        """Return the names of candidates with `size` effects, best first."""
        names = [n for n, f in list(self.fitted.items()) if len(f.candidate.ids) == size]
        return sorted(names, key=lambda n: self.fitted[n].score)

    # ------------------------------------------------------------------ signatures

    def probes(self, name: str, order: int | None = None) -> list[list[dict[str, Any]]]:
        """
        Return lists of effects (one per column) that stand for a little of effect `name`.

        Args:
            name: id of an effect, or name of a fit.
            order: order N of a periodic effect, None for the others.
        """
        effect = EFFECTS.get(name)
        a_little = None if self.recording.motor is None else JAGGED_PROBE
        if effect is not None and effect.replaces:
            value = replaced_value(self.model, name) or 0.0
            c = self.starts.candidates(name)[0].coordinates[-1]
            return [[{effect.parameters[0].name: value + (a_little or 0.02) * c.scale}]]
        out: list[list[dict[str, Any]]] = []
        for candidate in self.starts.candidates(name, order):
            group = [c for c in candidate.coordinates if c.owner == 0]
            z = {c.name: c.start if c.start else (a_little or 0.1) * c.scale for c in group}
            if name in PHASED:
                size = (a_little or 0.1) * group[0].scale
                fixed = {'N': order} if name in PERIODIC else {}
                out.append([{'A': size, 'phi': p, **fixed} for p in (0.0, 0.5 * math.pi)])
            else:
                out.append([z])
        return out

    def gains(self, data: likelihood.WindowData, base: CandidateModel, point: likelihood.FitPoint,
              ids: Iterable[str], orders: Iterable[int] | None = None) -> dict[Trial, float]:
        """
        Return {(id, N): linearised gain in chi2 of adding it to the Candidate `base` at `point`}.

        Window states and coordinates of `base` give way. N is None but for periodic effects, which
        are tried with `orders` (default: those found before).

        Args:
            data: long or short windows.
            base: candidate that the effects are added to.
            point: where the fit stands.
            ids: ids of the effects.
            orders: orders tried for periodic effects (default: those found before).
        """
        weight = likelihood.weights(data, point.chi2, True)
        s = likelihood.sensitivity(data, base, point)
        model = base.model(point.z)
        _, prior = base.prior(point.z)
        out: dict[Trial, float] = {}

        def one(job: tuple[Trial, list[dict[str, Any]]]) -> tuple[Trial, float]:
            """Return the trial of `job` and its linearised gain."""
            key, columns = job
            residuals = [(point.residual - data.residual(
                with_effects(model, [*model.effects, {'id': key[0], **column}]), point.states,
                point.memory)[0]) for column in columns]
            joint = likelihood.Sensitivity(s.Jx, np.concatenate(
                [s.Jz, np.stack(residuals, axis=2)], axis=2))
            S, g, _, _ = likelihood.normal_equations(joint, point.residual, weight)
            S[np.diag_indices(len(prior))] += prior
            return key, likelihood.gained(S, g, len(prior))
        jobs = []
        for name in ids:
            if name in base.ids or name in NOT_FITTED:
                continue
            tried = orders or self._orders.get(name) or ORDERS
            for order in tried if name in PERIODIC else [None]:
                jobs += [((name, order), columns) for columns in self.probes(name, order)]
        for key, gain in self._pool.map(one, jobs):
            out[key] = max(out.get(key, 0.0), gain)
        return out

    def find_orders(self, keep: int = 3) -> None:
        """
        Find the orders N of the periodic effects with the largest linearised gains.

        Long windows show the smallest ones; where the model is far off, only short ones follow.

        Args:
            keep: orders kept of each effect.
        """
        periodic = [i for i in PERIODIC if i in self.ids]
        none = self.fitted['']
        gain_tables = [self.gains(data, none.candidate, point, periodic, ORDERS)
                       for data, point in ((self.long, none.point), (self.short, self.short_none))]
        for name in periodic:
            strongest = [sorted(ORDERS,
                                key=lambda n: -gain[name, n])[:keep] for gain in gain_tables]
            self._orders[name] = list(dict.fromkeys(strongest[0] + strongest[1]))
