# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fits of one recording: their windows, their scores by BIC (Schwarz 1978), linearised gains.

Windows of 1 s carry the evidence; the last 30 % of each recording are held out.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import replace
import math
from typing import TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood, window_states
from gearbox_monitor.identification.candidates import (
    CandidateModel, NOT_FITTED, ORDERS, PERIODIC, probes, replaced_value, Starts)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.position import model_error
from gearbox_monitor.identification.shooting import shooting_windows, ShootingWindows, Simulator
from gearbox_monitor.identification.torque_domain import simulator
from gearbox_monitor.kernels.types import Array, Flags, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MAX_SETPOINT_DELAY
from gearbox_monitor.quality.recording import UniformRecording

LONG = 1.0  # s
SETTLING = MAX_SETPOINT_DELAY  # s, after which what was commanded before a recording has acted
HELD_OUT = 0.3
KEEP_REFINED, KEPT_ORDERS = 4, 3
# Share of the scale in which an effect is tried: of a value that it replaces less; more where
# what is made small is jagged (multiscale).
PROBE, VALUE_PROBE, JAGGED_PROBE = 0.1, 0.02, 0.3
FINER = 4     # times as many steps, where long ones are suspected
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


class Search:
    """
    All fits of one Recording under one DriveModel.

    sigma [2] rad; only, exclude: ids; jobs: threads; progress(done, total, text) is called as it
    goes on; colour [2]: see coloured_noise. settling: s at the beginning of each joined recording
    that are no evidence, because commands from before the recording may still act. spans: parts
    of the recording that are evidence. long: windows of 1 s. fitted: fits by name, '' without
    effects.
    """

    def __init__(self, recording: UniformRecording, model: DriveModel, sigma: Array,
                 ids: Iterable[str], jobs: int = 1, progress: Callable[..., object] | None = None,
                 colour: Array | None = None, settling: float = 0.0) -> None:
        self.recording, self.model, self.ids = recording, model, list(ids)
        self.starts = Starts(model, recording)
        windows = shooting_windows(recording, LONG, settling)
        skipped = int(windows.begin[0])
        self.spans = [slice(part.start + skipped, part.stop) for part in recording.segments]
        train, self.last = held_out(recording, windows)
        self.long = likelihood.WindowData(
            recording, simulator(recording, model), windows, np.asarray(sigma, float), train,
            model_error.weighing(recording, model, sigma), colour)
        self.jobs, self._progress = jobs, progress or (lambda *_: None)
        self._pool = ThreadPoolExecutor(jobs)
        self._done, self._total = 0, 1
        self._fitted: dict[str, CandidateFit] = {}
        self._orders: dict[str, list[int]] = {}

    @property
    def fitted(self) -> Mapping[str, CandidateFit]:
        """Fits by name, '' without effects."""
        return self._fitted

    def keep(self, fit: CandidateFit, name: str | None = None) -> CandidateFit:
        """Let `fit` be the one of its name, or of another `name`; return it."""
        self._fitted[fit.name if name is None else name] = fit
        return fit

    def keep_better(self, fit: CandidateFit) -> CandidateFit:
        """Keep `fit` or the one that has the same effects in any order; return the better one."""
        same = [name for name, rival in self._fitted.items()
                if rival.candidate.key == fit.candidate.key]
        return self.keep(min([*map(self._fitted.pop, same), fit], key=lambda f: f.score))

    def with_data(self, long: likelihood.WindowData,
                  fitted: Mapping[str, CandidateFit]) -> 'Search':
        """Return the Search on windows `long` that count in another way, with fits `fitted`."""
        out = copy(self)
        out.long, out._fitted = long, dict(fitted)
        return out

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

    @property
    def half_gap(self) -> float:
        """Half gap of the model (rad), the scale on which windows are started elsewhere."""
        return max(self.model.transmission.half_gap, 0.01)

    def score(self, data: likelihood.WindowData, candidate: CandidateModel,
              point: likelihood.FitPoint) -> float:
        """
        Return the BIC (Schwarz 1978) of `point` on the training windows of `data`.

        Args:
            data: windows of readings and how residuals are weighted.
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
        """
        plain = likelihood.objective(candidate, point, data.train.astype(float))
        return plain + candidate.n_effect * math.log(data.n_train)

    def as_fitted(self, candidate: CandidateModel, point: likelihood.FitPoint,
                  smooth: Array | None = None) -> CandidateFit:
        """
        Return the CandidateFit of `candidate` at `point`, scored.

        Args:
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
            smooth: smoothed states in which its windows began [N, N_STATE].
        """
        return CandidateFit(candidate, point, self.score(self.long, candidate, point),
                            smooth=smooth)

    def found_orders(self, name: str) -> list[int]:
        """Return the orders N of the periodic effect `name` that find_orders found."""
        if name not in self._orders:
            self.find_orders()
        return self._orders[name]

    def polish(self, fitted: CandidateFit,
               rivals: Sequence[likelihood.FitPoint] = ()) -> CandidateFit:
        """
        Rescue and refit `fitted` on the long windows: robust, then plain.

        Args:
            fitted: fit on the long windows.
            rivals: points of other fits whose window states are tried.
        """
        candidate = fitted.candidate
        point = window_states.rescue(self.long, candidate, fitted.point, rivals,
                                     half_gap=self.half_gap)
        if candidate.coordinates:
            point = gauss_newton.robust_then_plain(self.long, candidate, point)
        return min(self.as_fitted(candidate, point, fitted.smooth), fitted, key=lambda f: f.score)

    def on_shorter_steps(self) -> likelihood.WindowData | None:
        """Return the long windows run on steps as short as need be, None: they are already."""
        if self.recording.motor is not None:
            return None
        shorter = Simulator(self.recording, self.model, finer=FINER)
        if self.long.simulator.n == shorter.n:
            return None
        return replace(self.long, simulator=shorter)

    def finer(self, best_fit: CandidateFit,
              inadequate: Callable[[CandidateFit], bool]) -> CandidateFit:
        """
        Return `best_fit` on shorter steps, with which the search goes on, where it needs them.

        Steps are as long as the nominal drive allows; with the effect it may be a faster one, and
        the readings so good that the edges of its gap show.

        Args:
            best_fit: fit that explains the recording best.
            inadequate: function that tells whether a fit leaves more than noise.
        """
        if not inadequate(best_fit) or self.noisy:
            return best_fit
        shorter = self.on_shorter_steps()
        if shorter is None:
            return best_fit
        long, none = self.long, self.fitted['']
        self.long = shorter
        refitted = self.keep(self._refitted(none))
        if best_fit.candidate.ids:
            refitted = self._refitted(best_fit)
        if inadequate(refitted):
            self.long = long
            self.keep(none)
            return best_fit
        return self.keep(refitted)

    def _refitted(self, fitted: CandidateFit) -> CandidateFit:
        """Return `fitted` refitted from where it is: windows run otherwise than they did."""
        point = gauss_newton.robust_then_plain(
            self.long, fitted.candidate, self.long.evaluate(fitted.candidate, fitted.point))
        return self.as_fitted(fitted.candidate, point, fitted.smooth)

    @property
    def noisy(self) -> bool:
        """Whether torque noise on the motor is part of the likelihood."""
        model = self.model
        return (model.tolerance > 0.0 or bool(model.process_torque)
                or model.process_torque_time > 0.0)

    def in_sensor_units(self) -> 'Search':
        """Return the search with residuals in standard deviations of the encoders' noise."""
        if self.long.weighing is None and self.long.colour is None:
            return self
        long = self.long.uncoloured()
        return self.with_data(long, {
            name: replace(f, white=None, point=long.evaluate(f.candidate, f.point))
            for name, f in self.fitted.items()})

    def ranked(self, size: int = 1) -> list[str]:
        """Return the names of candidates with `size` effects, best first."""
        names = [n for n, f in list(self.fitted.items()) if len(f.candidate.ids) == size]
        return sorted(names, key=lambda n: self.fitted[n].score)

    def probes(self, name: str, order: int | None = None) -> list[list[Values]]:
        """
        Return lists of effects, one per column, that are a little of effect `name`, per start.

        Args:
            name: id of an effect.
            order: order N of a periodic effect, None for the others.
        """
        value = replaced_value(self.model, name)
        candidates = self.starts.candidates(name, order)
        share = VALUE_PROBE if value is not None else PROBE
        if self.recording.motor is not None:
            share = JAGGED_PROBE
        return [[effect for effect, _ in probes(candidate, share, value)]
                for candidate in (candidates if value is None else candidates[:1])]

    def gains(self, data: likelihood.WindowData, base: CandidateModel, point: likelihood.FitPoint,
              ids: Iterable[str], orders: Iterable[int] | None = None) -> dict[Trial, float]:
        """
        Return {(id, N): linearised gain in chi2 of adding it to the Candidate `base` at `point`}.

        Window states and coordinates of `base` give way. N is None but for periodic effects, which
        are tried with `orders` (default: those found before).

        Args:
            data: windows of readings and how residuals are weighted.
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

        def one(job: tuple[Trial, list[Values]]) -> tuple[Trial, float]:
            """Return the trial of `job` and its linearised gain."""
            key, effects = job
            columns = likelihood.effect_columns(data, model, point, effects)
            return key, likelihood.linear_gain(s, columns, point.residual, weight, prior)
        jobs = []
        for name in ids:
            if name in base.ids or name in NOT_FITTED:
                continue
            tried = orders or self._orders.get(name) or ORDERS
            for order in tried if name in PERIODIC else [None]:
                jobs += [((name, order), effects) for effects in self.probes(name, order)]
        for key, gain in self._pool.map(one, jobs):
            out[key] = max(out.get(key, 0.0), gain)
        return out

    def find_orders(self) -> None:
        """Find the orders N of the periodic effects with the largest linearised gains."""
        periodic, none = [i for i in PERIODIC if i in self.ids], self.fitted['']
        gain = self.gains(self.long, none.candidate, none.point, periodic, ORDERS)
        for name in periodic:
            self._orders[name] = sorted(ORDERS, key=lambda n: -gain[name, n])[:KEPT_ORDERS]
