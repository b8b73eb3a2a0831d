# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The outcome of a contest on recordings of one drive: fits, free runs, where the rest acts."""
from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.contest import contest, Search
from gearbox_monitor.diagnosis.hypothesis import Hypothesis
from gearbox_monitor.diagnosis.joint.candidates import SHAPES
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings, likeliest_reading
from gearbox_monitor.diagnosis.joint.effect_scan import evidence_for, FreeFunction
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, JointLikelihood, Tested)
from gearbox_monitor.diagnosis.joint.localisation import (
    Burst, place_in, slip_events, SlipEvent, without_slips)
from gearbox_monitor.diagnosis.joint.windows import (
    misfit_of, open_loop, runs_from, SIGMA_ERROR, WindowRuns, with_starts_of)
from gearbox_monitor.diagnosis.settings import CONTEST, STATEMENTS
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.effects.gearbox import SLIP


class ComparedRuns(NamedTuple):
    """
    Free runs of models over the windows of each recording.

    published: of the nominal model; none: of the fit without effects; laws: of the effects;
    closed: of the model that closes the gap. Each begins where it fits best.
    """

    published: tuple[WindowRuns, ...]
    none: tuple[WindowRuns, ...]
    laws: tuple[WindowRuns, ...]
    closed: tuple[WindowRuns, ...]


@dataclass(frozen=True, eq=False)
class Decision:
    """
    What explains recordings of one drive best.

    model: of the model file. recordings: with the nuisances as they were settled; of a train of
    bursts, with their torque.
    none: the fit without effects; fit: that of the laws; closed: the same, or with the torque map
    of a function. fits: all that were scored by one likelihood, best first. bursts, the largest
    first. remains: whether the laws leave more than noise.
    unnamed: id of what remains, where it may not be named.
    """

    model: DriveModel
    recordings: DriveRecordings
    outcome: Search[InnovationEvidence]
    none: InnovationFit
    fit: InnovationFit
    closed: InnovationFit
    fits: tuple[InnovationFit, ...]
    bursts: tuple[Burst, ...] = ()
    remains: bool = False
    unnamed: str = ''

    @property
    def data(self) -> DriveRecordings:
        """The recordings with the nuisances as they were settled, without bursts."""
        return self.outcome.evidence.data

    @cached_property
    def bare(self) -> DriveRecordings:
        """The data as the recordings were read, with their slips."""
        return without_slips(self.data)

    @cached_property
    def slips(self) -> tuple[SlipEvent, ...]:
        """Slips of the drive, in order of time."""
        return slip_events(self.data, self.fit)

    @property
    def largest_slip(self) -> SlipEvent:
        """The slip of the largest size."""
        return max(self.slips, key=lambda slip: abs(slip.size))

    @property
    def ids(self) -> tuple[str, ...]:
        """Effects that count."""
        return (*self.fit.candidate.ids, *((SLIP.id,) if self.data.slips.size else ()),
                *((DISTURBANCE.id,) if self.bursts else ()))

    @property
    def values(self) -> dict[str, Values]:
        """{effect: {parameter: value}} of the effects that count; of events, the largest one."""
        values: dict[str, Values] = dict(zip(
            self.fit.candidate.ids, self.fit.candidate.values(self.fit.z)[1]))
        if self.bursts:
            largest = self.bursts[0]
            values[DISTURBANCE.id] = {'t0': largest.t0, 'duration': largest.duration,
                                      'amplitude': largest.amplitude}
        if self.slips:
            slip = self.largest_slip
            values[SLIP.id] = {'Ds': slip.size, 't0': slip.t0}
        return values

    @cached_property
    def runs(self) -> tuple[WindowRuns, ...]:
        """Free runs of the laws over the windows of each recording."""
        return self.recordings.runs(self.fit)

    @cached_property
    def compared(self) -> ComparedRuns:
        """Free runs of all models over the windows of each recording."""
        closed = self.runs if self.closed is self.fit else self.recordings.runs(self.closed)
        none = with_starts_of(self.data.calm(self.bare.runs(self.none)), closed)
        closed = with_starts_of(closed, none)
        published = none
        if self.none.model != self.model:
            published = with_starts_of([
                open_loop(r, self.model, self.data.level, run.data)
                for r, run in zip(self.bare.recordings, none)], none)
            if not self.data.balances:
                published = tuple(runs_from(other.data, self.model, run.states, run.memory)
                                  for run, other in zip(published, none))
        return ComparedRuns(published, none, closed if self.closed is self.fit else self.runs,
                            closed)

    @property
    def widest(self) -> int:
        """Number of the recording with the largest gap."""
        return int(np.argmax([misfit_of([run]) for run in self.compared.published]))

    @property
    def nuisances(self) -> dict[str, float]:
        """Relative changes {name: factor - 1} of nominal values, those of shapes if any."""
        return {name: value for name, value in self.closed.candidate.values(self.closed.z)[
            0].items() if value or name not in SHAPES}

    @property
    def orders(self) -> dict[str, int]:
        """{periodic effect: its likeliest N}."""
        return {f.candidate.ids[i]: order for f in reversed(self.fits)
                for i, order in f.candidate.orders.items()}

    @property
    def follows(self) -> FreeFunction | None:
        """The function of the motion that the remainder follows, None without either."""
        return self.function if self.remains else None

    @property
    def function(self) -> FreeFunction | None:
        """The function that explains most beside the laws, None where none explains anything."""
        remains, best = self.outcome.remains, self.outcome.best
        if best.function is not None:
            closed = self.closed.candidate
            table = closed.values(self.closed.z)[1][next(iter(closed.tables))]
            return FreeFunction(table, np.array(table['values']),
                                self.fit.deviance - self.closed.deviance, best.fit.occam)
        if remains.follows > 0.0 and remains.functions:
            found: FreeFunction = remains.functions[0].source
            return found
        return None

    @cached_property
    def place(self) -> str:
        """Location class of what remains: of the member that explains it, else by free signals."""
        best, function = self.outcome.best, self.function
        if self.unnamed:
            return library()[self.unnamed].location
        if best.train is not None:
            return best.train.place
        if function and best.function and self.outcome.remains.worth <= CONTEST.margin:
            return function.place
        # Beside what is missing, friction of another shape may imitate a part of it.
        return place_in(self.recordings.runs(unshaped(self.fit)))

    @property
    def gains(self) -> dict[str, float]:
        """{effects: gain over none in BIC} of all that were scored."""
        score, fit, best = self.data.score, self.fit, self.outcome.best
        none = score(self.none)
        paid = self.outcome.evidence.price_of_event * len(self.data.slips)
        slip = (SLIP.id,) if paid else ()
        out = {'+'.join((*f.candidate.ids, *slip)): none - paid - score(f) for f in self.fits
               if f.candidate.ids or slip and f is not self.none}
        if self.bursts:
            price = paid + len(self.bursts) * self.outcome.evidence.price_of_event
            out['+'.join(self.ids)] = none - price - score(replace(fit, deviance=best.deviance))
        return out

    def evidence_for(self, name: str) -> float | None:
        """Return 2 log likelihood that an effect `name` gains, None of a quantisation."""
        ids, fit = self.fit.candidate.ids, self.fit
        if name == DISTURBANCE.id and self.bursts:
            return evaluated(self.data.fine, fit).deviance - evaluated(
                self.recordings.fine, fit).deviance
        if name == SLIP.id:
            return fitted(self.bare.fine, fit).deviance - evaluated(
                self.data.fine, fit).deviance
        return evidence_for(self.data, fit, self.fits, ids.index(name)) if name in ids else None


def decide(recordings: DriveRecordings) -> Decision:
    """
    Return what explains recordings best.

    Args:
        recordings: of one drive.
    """
    recordings = likeliest_reading(recordings)
    outcome = contest(InnovationEvidence(recordings))
    best, data = outcome.best, outcome.evidence.data
    bare, plain = without_slips(data), outcome.none.fit.fit
    none = _plain(bare, plain if bare is data else fitted(bare.fine, plain))
    # A train beside which something remains is a torque over time without a law.
    bursts = () if outcome.lawless else best.fit.bursts
    loaded = best.fit.beside if bursts else data
    alone = best if bursts else _without_lawless(outcome.evidence, best)
    laws = none if not alone.fit.fit.candidate.ids and loaded is bare else _plain(
        loaded, alone.fit.fit)
    scored = [*(h.fit.fit for h in outcome.rivals), laws, *[none] * (bare is data)]
    unique: dict[tuple[str, ...], InnovationFit] = {}
    for fit in sorted(scored, key=data.score):
        if not fit.candidate.tables:
            unique.setdefault(fit.candidate.key, fit)
    return Decision(
        recordings.model, loaded, outcome, none, laws,
        laws if best.function is None else best.fit.fit, tuple(unique.values()), bursts,
        outcome.lawless)


def _without_lawless(evidence: InnovationEvidence, h: Hypothesis) -> Hypothesis:
    """Return the laws of a hypothesis alone, without those at a bound of physics without it."""
    if h.function is None:
        return h if h.train is None else evidence.moved(h)
    h = evidence.without(h, h.members.index(h.function))
    while any(m.bounded for m in h.members):
        h = evidence.without(h, next(i for i, m in enumerate(h.members) if m.bounded))
    return h


def unshaped(fit: InnovationFit) -> InnovationFit:
    """Return a fit with friction of the shape that the model file states."""
    shaped = np.array([c.owner < 0 and c.name in SHAPES for c in fit.candidate.coordinates], bool)
    return replace(fit, z=np.where(shaped, fit.candidate.start(), fit.z)) if shaped.any() else fit


def _plain(data: DriveRecordings, fit: InnovationFit) -> InnovationFit:
    """Return a fit with friction as the model file states it, unless the recordings deny that."""
    plain = unshaped(fit)
    if plain is fit:
        return fit
    plain = evaluated(data.fine, plain).alone()
    return plain if plain.deviance - evaluated(data.fine, fit).deviance < CONTEST.margin else fit


def with_level_of_innovations(decision: Decision) -> Decision:
    """
    Return the decision with the level of encoder noise that the innovations of its fit have.

    If a fit leaves white noise alone, its innovations measure the level more accurately than
    fourth differences did. A level that fourth differences exclude is not taken.

    Args:
        decision: of a contest.
    """
    data = decision.recordings
    if (decision.remains or decision.bursts or data.correlation is not None or data.balances
            or data.model.lasting or data.rough):
        return decision
    run = evaluated(data.fine, decision.fit).run
    sigma = data.sigma.copy()
    for channel in (0, 1):
        residual = run.residual[run.read[:, channel], channel]
        if len(residual):
            level = math.sqrt(float(np.mean(residual ** 2)))
            excluded = STATEMENTS.noise_level * SIGMA_ERROR / math.sqrt(len(residual))
            if level > 0.0 and abs(math.log(level)) < excluded:
                sigma[channel] *= level
    data = replace(data, sigma=sigma)
    evidence = replace(decision.outcome.evidence, data=data)
    return replace(decision, recordings=data, outcome=replace(decision.outcome, evidence=evidence))


def standard_errors(likelihood: JointLikelihood,
                    fit: InnovationFit) -> tuple[dict[str, dict[str, float]], float | None]:
    """
    Return ({id: {parameter: standard error}}, condition of the scaled normal matrix).

    From the Fisher information of the innovations, nominal values free within their prior; larger
    by the excess of the innovations where that is above 1.

    Args:
        likelihood: of the recordings.
        fit: by it.
    """
    candidate, z = fit.candidate, fit.z
    if not len(z):
        return {}, None
    tested = Tested.beside(likelihood, fit)
    run, S = tested.at.run, tested.own.T @ tested.own
    scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-300))
    misfit = max(1.0, float((run.residual[run.read] ** 2).mean()))
    jacobian = candidate.wave_jacobian(z)
    errors = np.sqrt(np.maximum(misfit * np.diag(jacobian @ tested.covariance @ jacobian.T), 0.0))
    return candidate.named_errors(z, errors), float(np.linalg.cond(S * np.outer(scale, scale)))
