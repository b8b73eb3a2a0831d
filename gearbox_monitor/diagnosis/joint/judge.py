# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The decision: none, effects, effects that explain a part, or unknown.

One kind of evidence decides: the likelihood of innovations (BIC for what is better, adequacy
against noise for what is enough). Nothing here is written into: each step returns new fits.
"""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from gearbox_monitor.diagnosis.joint import localisation
from gearbox_monitor.diagnosis.joint.adequacy import Adequacy, adequacy_of, runs_of
from gearbox_monitor.diagnosis.joint.bursts import Bursts, bursts_beside
from gearbox_monitor.diagnosis.joint.candidates import (
    nuisances_of, origin, with_free_shape, with_law, ZERO)
from gearbox_monitor.diagnosis.joint.closed_model import SIGMA_ERROR
from gearbox_monitor.diagnosis.joint.effect_scan import mapped, Proposal, scan
from gearbox_monitor.diagnosis.joint.effect_search import EffectSearch, FitTable
from gearbox_monitor.diagnosis.joint.evidence import Evidence
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated, fitted, InnovationFit
from gearbox_monitor.diagnosis.joint.localisation import torque_places
from gearbox_monitor.diagnosis.joint.noise_model import MOTION, spectrum
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.effects.encoder import ENCODER_OFFSET
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP

COMPARED, PAIRS = 4, 3   # fits of one effect, of two, that are finished on short steps
SHAPED = 2               # best single effects that are tried with friction of another shape
# Locations whose torque acts on the motor: likelihood tells them apart, a free signal does not.
ON_MOTOR = ('motor_side', 'actuator', 'controller')
POLISH = 8               # iterations of a fit on short steps
FINER = 4                # times as many steps, where long ones show


@dataclass(frozen=True, eq=False)
class Decision:
    """
    What explains the recordings best.

    none: the fit without effects; fit: that of all effects that count; closed: the same, or with a
    torque map of the remainder, or whatever leaves least. adequacy: of `fit`. fits: all that were
    scored by one likelihood, best first. orders: of periodic effects, likeliest first. bursts:
    beside `fit`, None without. remains: whether `fit` leaves more than noise. notes: sentences.
    """

    evidence: Evidence
    none: InnovationFit
    fit: InnovationFit
    closed: InnovationFit
    adequacy: Adequacy
    none_adequacy: Adequacy
    fits: tuple[InnovationFit, ...]
    orders: tuple[tuple[str, list[int]], ...] = ()
    bursts: Bursts | None = None
    remains: bool = False
    notes: tuple[str, ...] = ()

    @property
    def ids(self) -> tuple[str, ...]:
        """Effects that count."""
        return (*self.fit.candidate.ids, *((DISTURBANCE.id,) if self.bursts else ()))

    @property
    def values(self) -> dict[str, Values]:
        """{effect: {parameter: value}} of the effects that count; of bursts, the largest one."""
        values: dict[str, Values] = dict(zip(
            self.fit.candidate.ids, self.fit.candidate.values(self.fit.z)[1]))
        values.pop(TORQUE_MAP.id, None)
        if self.bursts is not None:
            largest = self.bursts.bursts[0]
            values[DISTURBANCE.id] = {'t0': largest.t0, 'duration': largest.duration,
                                      'amplitude': largest.amplitude}
        return values

    @property
    def score(self) -> float:
        """BIC of all that counts."""
        own, bursts = self.evidence.score(self.fit), self.bursts
        if bursts is None:
            return own
        return own + bursts.price - (0.0 if self.fit is bursts.fit else bursts.gain)

    def gain(self, fit: InnovationFit) -> float:
        """Return by how much a fit beats none, in BIC."""
        return self.evidence.score(self.none) - self.evidence.score(fit)


class Judge:
    """Fits of candidates to one Evidence, each found once."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.search = EffectSearch(evidence)
        self._adequacies: dict[tuple[object, ...], Adequacy] = {}

    def score(self, fit: InnovationFit) -> float:
        """
        Return the BIC of a fit; of ties, what moves a value of the model is better.

        A gain of the servo that the model states is a simpler cause than a torque scale of its
        own, where the motion is the same.
        """
        model, candidate = self.evidence.model, fit.candidate
        return self.evidence.score(fit) + THRESHOLDS.tie * sum(
            not any(origin(model, name, candidate.orders.get(i)).values())
            for i, name in enumerate(candidate.ids))

    def polished(self, fit: InnovationFit, iterations: int = POLISH) -> InnovationFit:
        """Return `fit` on short steps, refitted in so many `iterations`."""
        return fitted(self.evidence.fine, fit, iterations)

    def cooled(self, fit: InnovationFit) -> InnovationFit:
        """
        Return `fit` from the least torque noise on, if that is likelier.

        Noise that was large while the model was wrong may hold a fit off its optimum. Free runs
        tell when it is worth a try: they miss by little.
        """
        adequacy = self.adequacy(fit)
        if adequacy.adequate or adequacy.vetoed:
            return fit
        cold = self.polished(replace(fit, torque=self.evidence.fine.least_noise))
        return min(cold, fit, key=lambda f: f.deviance)

    def steps_show(self, fit: InnovationFit) -> bool:
        """
        Return whether the error of the integration is what `fit` leaves.

        Steps are as long as the nominal drive allows; with an effect it may be a faster one.
        """
        evidence = self.evidence
        if evidence.finer > 1 or evidence.noisy or self.adequacy(fit).adequate:
            return False
        model, torque = fit.model, evidence.whole.least_noise
        shorter = replace(evidence, finer=FINER).whole.run(model, torque).deviance
        return bool(evidence.whole.run(model, torque).deviance - shorter > THRESHOLDS.noise_gain)

    def begins_show(self, fit: InnovationFit) -> bool:
        """Return whether filters that begin as another model does may be what `fit` leaves."""
        evidence, adequacy = self.evidence, self.adequacy(fit)
        return bool(fit.candidate.ids and evidence.reference is None and not adequacy.adequate
                    and not adequacy.vetoed and any(map(evidence.hides, evidence.recordings)))

    def rescored(self, fits: Iterable[InnovationFit]) -> list[InnovationFit]:
        """Return fits as the likelihood on short steps has them where they stand."""
        return [evaluated(self.evidence.fine, f).alone() for f in fits]

    def adequacy(self, fit: InnovationFit) -> Adequacy:
        """Return what `fit` leaves, evaluated once for each fit."""
        key = _key(fit)
        if key not in self._adequacies:
            self._adequacies[key] = adequacy_of(self.evidence, fit)
        return self._adequacies[key]

    def misfit(self, fit: InnovationFit) -> float:
        """Return how far off free runs of `fit` are, without the other tests of adequacy."""
        if self.evidence.balances or _key(fit) in self._adequacies:
            return self.adequacy(fit).misfit
        return typical_misfit(runs_of(self.evidence, evaluated(self.evidence.whole, fit)))

    def scatters(self, name: str) -> bool:
        """Return whether the effect `name` is a value that may scatter anyway."""
        effect = EFFECTS.get(name)
        value = ZERO if name == ENCODER_OFFSET.id else (
            effect.parameters[0].name if effect and effect.replaces else None)
        return value in nuisances_of(self.evidence.model)

    def price(self, ids: Sequence[str], beside: Sequence[str]) -> float:
        """
        Return the gain in BIC that the effects `ids` must exceed.

        Args:
            ids: effects that are added.
            beside: effects that are there.
        """
        if len(ids) == 1 and self.scatters(ids[0]):
            # A fit without it may move this value, too: what counts is how far.
            return THRESHOLDS.scatter_gain - math.log(self.evidence.fine.readings)
        return THRESHOLDS.further_effect_gain if beside else THRESHOLDS.effect_gain

    def worth(self, fit: InnovationFit, base: InnovationFit) -> bool:
        """Return whether `fit` beats the simpler `base` by the price of what it adds."""
        added = [i for i in fit.candidate.ids if i not in base.candidate.ids]
        return self.score(base) - self.score(fit) > self.price(added, base.candidate.ids)

    def holds(self, fit: InnovationFit, base: InnovationFit) -> bool:
        """
        Return whether readings that were not fitted prefer `fit` to the simpler `base`.

        They do not tell a value that `base` has moved as far: its tolerance does.
        """
        unseen = self.evidence.unseen
        added = set(fit.candidate.ids) - set(base.candidate.ids)
        if unseen is None or added and all(map(self.scatters, added)):
            return True
        return unseen.run(fit.model, fit.torque).deviance < unseen.run(
            base.model, base.torque).deviance

    def strays(self, fit: InnovationFit, base: InnovationFit) -> bool:
        """Return whether free runs of `fit` are farther off than those of the simpler `base`."""
        return not self.misfit(fit) <= THRESHOLDS.no_worse * self.misfit(base)

    def lacks(self, fit: InnovationFit) -> bool:
        """Return whether a further effect promises more than chance beside `fit`."""
        return any(p.gain > (THRESHOLDS.scatter_gain if self.scatters(p.name)
                             else THRESHOLDS.effect_gain)
                   for p in scan(self.evidence.fine, self.evidence.starts, fit,
                                 self.evidence.ids) if math.isfinite(p.gain))


def _key(fit: InnovationFit) -> tuple[object, ...]:
    """Return what tells `fit` from all others of the same evidence."""
    return (fit.candidate.name, fit.candidate.nominal.friction_law, fit.z.tobytes(),
            fit.torque.tobytes())


def decide(evidence: Evidence, table: FitTable | None = None) -> Decision:
    """
    Return what explains the recordings best.

    Args:
        evidence: the recordings and the likelihoods of their parts.
        table: fits of single effects on coarse steps, None: not yet fitted.
    """
    judge = Judge(evidence)
    coarse_none = judge.search.none() if table is None else table.none
    none = judge.polished(coarse_none)
    if table is None:
        table = judge.search.singles(coarse_none, judge.adequacy(none).adequate)
    singles = _finished(judge, table.singles, COMPARED)
    leader = singles[0] if singles else None
    chosen = none
    if leader is not None and judge.worth(leader, none):
        chosen = judge.cooled(simplest(judge, leader, singles))
        if judge.adequacy(none).adequate and not judge.holds(chosen, none):
            chosen = none  # nothing was missing, and readings that were not fitted say so
    if judge.steps_show(chosen):
        return decide(replace(evidence, finer=FINER), table)
    if judge.begins_show(chosen):
        return decide(replace(evidence, reference=chosen), table)
    fits = [none, *singles, *judge.rescored(table.singles[len(singles):])]
    if not judge.adequacy(chosen).adequate and singles:
        reshaped = _reshaped(judge, [chosen, *singles[:SHAPED], none])
        if reshaped is not None and judge.steps_show(reshaped):
            return decide(replace(evidence, finer=FINER), table)
        if reshaped is not None and judge.adequacy(reshaped).adequate:
            chosen, fits = reshaped, [*fits, reshaped]
    lacking = not judge.adequacy(chosen).adequate
    if singles and (lacking or chosen.candidate.ids and judge.lacks(chosen)):
        pairs = judge.search.pairs(table.singles)
        finished = _finished(judge, pairs, PAIRS)
        fits += [*finished, *judge.rescored(pairs[len(finished):])]
        for pair in finished:
            pair = judge.cooled(_canonical(judge, pair))
            if judge.worth(pair, chosen) and (lacking or judge.adequacy(pair).adequate):
                chosen, fits = pair, [*fits, pair]
                break
        if len(chosen.candidate.ids) > 1 and judge.steps_show(chosen):
            return decide(replace(evidence, finer=FINER), table)
    if evidence.balances and len(chosen.candidate.ids) == 2:
        thirds = _finished(judge, judge.search.third(chosen), PAIRS)
        fits += thirds
        chosen = next((third for third in thirds if judge.worth(third, chosen)
                       and judge.holds(third, chosen)), chosen)
    bursts, enough = None, judge.adequacy(chosen).adequate
    if not (enough or evidence.balances) and DISTURBANCE.id in evidence.ids:
        bursts = _bursts(judge, chosen, none)
        if bursts is not None:
            chosen, enough = bursts.fit, bursts.adequate
    closed = chosen
    if not enough:
        chosen, closed = _parts(judge, chosen, none, fits)
    unique: dict[tuple[str, ...], InnovationFit] = {}
    for fit in sorted([*fits, chosen], key=judge.score):
        unique.setdefault(fit.candidate.key, fit)
    return Decision(evidence, none, chosen, closed, judge.adequacy(chosen), judge.adequacy(none),
                    tuple(unique.values()), table.orders, bursts, not enough)


def _finished(judge: Judge, fits: Sequence[InnovationFit], most: int) -> list[InnovationFit]:
    """Return the leading `fits` on short steps, best first."""
    close = [fit for number, fit in enumerate(fits[:most]) if number < 2
             or fit.deviance < fits[0].deviance + THRESHOLDS.ranking_error]
    return sorted(map(judge.polished, close), key=judge.score)


def simplest(judge: Judge, leader: InnovationFit,
             singles: Sequence[InnovationFit]) -> InnovationFit:
    """
    Return the effect of fewest parameters that explains the recordings no worse than `leader`.

    Args:
        judge: of the recordings.
        leader: best fit of one effect.
        singles: fits of single effects.
    """
    rivals = [f for f in singles if judge.score(f) - judge.score(leader) < THRESHOLDS.bound_gain
              and f.candidate.n_effect < leader.candidate.n_effect]
    simple = min(rivals, key=lambda f: (f.candidate.n_effect, judge.score(f)), default=leader)
    return _canonical(judge, simple)


def _canonical(judge: Judge, fit: InnovationFit) -> InnovationFit:
    """
    Return `fit` with what an effect at a bound is instead of it.

    At the bound of a shape an effect is a simpler one: Stribeck friction that never falls is
    Coulomb friction, a loop of no width is friction in the gear. Of the simpler effects at the
    same place, the one that explains as much takes over.
    """
    bound = {part.partition('.')[0] for part in fit.candidate.at_bound(fit.z)}
    effects = library()
    for number, name in enumerate(fit.candidate.ids):
        if name not in bound or name == TORQUE_MAP.id:
            continue
        base = judge.search.reduced(fit, [i for i in range(len(fit.candidate.ids)) if i != number])
        count = sum(c.owner == number for c in fit.candidate.coordinates)
        trials = [i for i in judge.evidence.ids
                  if i not in fit.candidate.ids and effects[i].fitted
                  and effects[i].location == effects[name].location
                  and len(effects[i].parameters) < count]
        proposals: dict[str, Proposal] = {}
        for proposal in scan(judge.evidence.fine, judge.evidence.starts, base, trials):
            proposals.setdefault(proposal.name, proposal)
        simpler = [judge.polished(judge.search.begun(base, p)) for p in proposals.values()]
        if simpler:
            closest = min(simpler, key=judge.score)
            # It begins with the noise of a model without the effect, see Judge.cooled.
            cold = judge.polished(replace(closest, torque=fit.torque))
            closest = min(cold, closest, key=judge.score)
            if judge.score(closest) - judge.score(fit) < THRESHOLDS.bound_gain:
                return closest
        if len(fit.candidate.ids) > 1 and judge.score(base) - judge.score(
                fit) < THRESHOLDS.bound_gain:
            return judge.polished(base)
    return fit


def _reshaped(judge: Judge, fits: Sequence[InnovationFit]) -> InnovationFit | None:
    """
    Return the best fit with friction of another shape or law, None if that explains no more.

    Fits that leave noise alone come first. A shape or law that differs is no effect of its own,
    and must not find one a partner.
    """
    better: list[InnovationFit] = []
    unique = {fit.candidate.key: fit for fit in fits}
    for fit in unique.values():
        for candidate in (with_free_shape(fit.candidate),
                          with_law(fit.candidate, judge.evidence.step)):
            if candidate is None:
                continue
            freed = len(candidate.coordinates) - len(fit.z)
            z = np.concatenate([np.zeros(freed), fit.z])
            shaped = judge.polished(InnovationFit(candidate, z, fit.torque), 12)
            if fit.deviance - shaped.deviance > THRESHOLDS.scatter_gain:
                better.append(shaped)
    return min(better, default=None, key=lambda f: (
        not judge.adequacy(f).adequate,
        judge.score(f) + THRESHOLDS.effect_gain * bool(f.candidate.ids)))


def _bursts(judge: Judge, chosen: InnovationFit, none: InnovationFit) -> Bursts | None:
    """Return bursts on the arm that explain more than the effects do, None without."""
    for fit in [none] if chosen is none else [none, chosen]:
        bursts = bursts_beside(judge.evidence, fit, judge.adequacy(fit).runs)
        if bursts is None:
            continue
        base = judge.score(fit) - (bursts.gain - bursts.price)
        if judge.score(chosen) - base > THRESHOLDS.further_effect_gain and (
                bursts.adequate or fit is chosen):
            return bursts
    return None


def _at_one(fit: InnovationFit, locations: Sequence[str]) -> bool:
    """Return whether all effects of `fit` act at the same one of these `locations`."""
    own = {library()[name].location for name in fit.candidate.ids}
    return len(own) == 1 and own <= set(locations)


def _one_cause(judge: Judge, fit: InnovationFit, none: InnovationFit) -> list[str] | None:
    """
    Return the locations of the one cause that stands for `fit` and its remainder, or None.

    A free signal at one place that leaves as little alone as a free signal beside `fit` does is
    one unknown cause, which the effects of `fit` imitate unless they act there (Occam's razor).
    """
    evidence = judge.evidence
    # One encoder takes any signal; free runs do not know torque that lasts.
    if evidence.balances or evidence.lasting or any(
            len(recording.channels) == 1 for recording in evidence.recordings):
        return None
    of_none = localisation.places(judge.adequacy(none).runs)
    allowed = [*localisation.tied(of_none, judge.adequacy(none).dependence)]
    if set(allowed) & set(ON_MOTOR):
        allowed += ON_MOTOR
    if _at_one(fit, allowed):
        return allowed
    of_fit = localisation.places(judge.adequacy(fit).runs)
    none_left, fit_left = map(localisation.least_left, (of_none, of_fit))
    return None if THRESHOLDS.place_tie * fit_left < none_left else allowed


def _parts(judge: Judge, chosen: InnovationFit, none: InnovationFit,
           fits: Sequence[InnovationFit]) -> tuple[InnovationFit, InnovationFit]:
    """
    Return (effects that count, the model that leaves least) where more than noise remains.

    An effect counts if it is worth its price, readings that were not fitted prefer it, and free
    runs with it are no farther off: what imitates something else in single steps drifts. The
    closed model is the best of all that was fitted, with a torque map where that is worth it.
    """
    ranked = [chosen, *sorted(fits, key=judge.score)]

    def best(allowed: Sequence[str] | None = None) -> InnovationFit:
        """Return the first that counts, all effects at one of the `allowed` locations."""
        return next((
            fit for fit in ranked
            if fit.candidate.ids and (allowed is None or _at_one(fit, allowed))
            and judge.worth(fit, none) and judge.holds(fit, none)
            and not judge.strays(fit, none)), none)
    evidence = judge.evidence
    closed = counting = best()
    if counting is not none:
        counting = best(_one_cause(judge, counting, none))
    if evidence.with_map:
        for base in [none] if closed is none else [none, closed]:
            with_map = mapped(evidence.fine, base, torque_places(evidence.model), evidence.torque)
            if (with_map is not None and judge.holds(with_map, base) and judge.holds(
                    with_map, closed) and judge.score(closed) - judge.score(
                    with_map) > THRESHOLDS.further_effect_gain
                    and not judge.strays(with_map, closed)):
                closed = with_map
    return counting, closed


FITTED = 20.0     # Hz, above which a fitted effect leaves hardly anything
WIDTH, HIGHEST = 1.26, 490.0  # of a band; Hz
TRIED = np.linspace(0.0, 0.98, 99)


def measured(residual: Array, dt: float,
             lowest: float = MOTION) -> tuple[Array, Array] | None:
    """
    Return (phi [C], size [C]) of the noise of the encoders above `lowest`.

    size: its standard deviation, in sigmas. phi is 0 and size 1 for an encoder whose noise is
    white, or like nothing known. None where all are.

    Args:
        residual: residual [W, L, C], in standard deviations.
        dt: sample time, s.
        lowest: lowest frequency that counts, Hz.
    """
    power, at, _ = spectrum(residual, dt)
    edges = lowest * WIDTH ** np.arange(1 + int(np.log(HIGHEST / lowest) / np.log(WIDTH)))
    bands = [(at >= low) & (at < high) for low, high in zip(edges, edges[1:]) if high <= at[-1]]
    if len(bands) < 3:
        return None
    # Windows in the middle: those with impacts do not count.
    level = np.log(np.maximum(1e-300, [
        np.median(power[:, band].mean(axis=1), axis=0) for band in bands]))
    shape = (1.0 - TRIED ** 2) / (
        1.0 + TRIED ** 2 - 2.0 * TRIED * np.cos(2.0 * np.pi * dt * at)[:, None])
    line = np.log([shape[band].mean(axis=0) for band in bands])
    weight = np.array([band.sum() for band in bands]) / sum(band.sum() for band in bands)
    phi, size = np.zeros(level.shape[1]), np.ones(level.shape[1])
    for i, spectrum_levels in enumerate(level.T):
        ratio = spectrum_levels[:, None] - line
        middle = weight @ ratio
        off = np.sqrt(weight @ (ratio - middle) ** 2)
        closest = int(off.argmin())
        if TRIED[closest] >= THRESHOLDS.correlation and off[closest] < THRESHOLDS.colour:
            phi[i], size[i] = TRIED[closest], np.exp(0.5 * middle[closest])
    return (phi, size) if phi.any() else None


def measure(decision: Decision, lowest: float = MOTION) -> tuple[Array, Array] | None:
    """
    Return (sigma [2] rad, phi [2]) from what a decision leaves, None where the noise is white.

    The model without effects takes its place where it leaves less: torque noise hides wrong fits.

    Args:
        decision: of the judge.
        lowest: lowest frequency that counts, Hz.
    """
    of_fit, of_none = decision.adequacy.runs, decision.none_adequacy.runs
    runs = min(of_fit, of_none, key=lambda rows: typical_misfit(rows))
    sigma, phi, counts = decision.evidence.sigma.copy(), np.zeros(2), np.zeros(2)
    size = np.zeros(2)
    for run in runs:
        # The distances of the readings, in sigmas.
        residual = replace(run.data, colour=None).residual(run.model, run.states, run.memory)
        noise = measured(residual, run.recording.dt, lowest)
        channels = run.data.channels
        counts[channels] += 1
        phi[channels] += 0.0 if noise is None else noise[0]
        size[channels] += 1.0 if noise is None else noise[1]
    if not phi.any():
        return None
    read = counts > 0
    phi[read] /= counts[read]
    sigma[read] *= size[read] / counts[read]
    return sigma, phi


def with_level_of_innovations(decision: Decision) -> Decision:
    """
    Return the decision with the level of encoder noise that the innovations of its fit have.

    If a fit leaves white noise alone, its innovations measure the level more accurately than
    fourth differences did. A level that fourth differences exclude is not taken.

    Args:
        decision: of the judge.
    """
    evidence = decision.evidence
    if (decision.remains or decision.bursts is not None or evidence.colour is not None
            or evidence.balances or evidence.lasting or evidence.rough):
        return decision
    run = evaluated(evidence.whole, decision.fit).run
    sigma = evidence.sigma.copy()
    for channel in (0, 1):
        residual = run.residual[run.read[:, channel], channel]
        if len(residual):
            level = math.sqrt(float(np.mean(residual ** 2)))
            excluded = THRESHOLDS.noise_level * SIGMA_ERROR / math.sqrt(len(residual))
            if level > 0.0 and abs(math.log(level)) < excluded:
                sigma[channel] *= level
    evidence = replace(evidence, sigma=sigma)
    adequacies = []
    for fit, adequacy in ((decision.fit, decision.adequacy),
                          (decision.none, decision.none_adequacy)):
        runs = runs_of(evidence, evaluated(evidence.whole, fit))
        adequacies.append(replace(adequacy, runs=runs, misfit=typical_misfit(runs)))
    return replace(decision, evidence=evidence, adequacy=adequacies[0],
                   none_adequacy=adequacies[1])
