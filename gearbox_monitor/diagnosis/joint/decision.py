# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The outcome of a contest on recordings of one drive: fits, free runs, where the rest acts."""
from dataclasses import dataclass, replace
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.diagnosis.contest import CONTEST, contest, Search
from gearbox_monitor.diagnosis.joint.bursts import Burst
from gearbox_monitor.diagnosis.joint.candidates import SHAPES
from gearbox_monitor.diagnosis.joint.closed_model import SIGMA_ERROR
from gearbox_monitor.diagnosis.joint.drive_recordings import (
    DriveRecordings, is_open, likeliest_reading)
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated, InnovationFit
from gearbox_monitor.diagnosis.joint.lawless import FreeFunction
from gearbox_monitor.diagnosis.joint.localisation import places, tied
from gearbox_monitor.diagnosis.joint.thresholds import STATEMENTS
from gearbox_monitor.diagnosis.joint.windows import WindowRuns
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE


ALL_TRAINED = ('only the held-out windows show the model error: all windows were fitted, so '
               'gap_after is not from unseen ones; validate with a second recording')


@dataclass(frozen=True, eq=False)
class Decision:
    """
    What explains recordings of one drive best.

    model: of the model file. recordings: with the nuisances as they were settled; of a train of
    bursts, with their torque.
    none: the fit without effects; fit: that of the laws; closed: the same, or with the torque map
    of a function. fits: all that were scored by one likelihood, best first. bursts, the largest
    first. remains: whether the laws leave more than noise. notes: sentences.
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
        if self.bursts:
            largest = self.bursts[0]
            values[DISTURBANCE.id] = {'t0': largest.t0, 'duration': largest.duration,
                                      'amplitude': largest.amplitude}
        return values

    @cached_property
    def runs(self) -> tuple[WindowRuns, ...]:
        """Free runs of the laws over the windows of each recording."""
        return self.recordings.runs(self.fit)

    @cached_property
    def none_runs(self) -> tuple[WindowRuns, ...]:
        """Free runs without effects."""
        return self.outcome.evidence.data.runs(self.none)

    @property
    def function(self) -> FreeFunction | None:
        """The function that what remains follows, None where it follows none."""
        remains, best = self.outcome.remains, self.outcome.best
        if best.function is not None:
            table = self.closed.candidate.values(self.closed.z)[1][
                best.members.index(best.function)]
            return FreeFunction(table, np.array(table['values']),
                                self.fit.deviance - self.closed.deviance, best.fit.occam)
        if remains.follows > 0.0 and remains.functions:
            found: FreeFunction = remains.functions[0].source
            return found
        return None

    @cached_property
    def place(self) -> str:
        """Location class of what remains: of the member that takes it up, else by free signals."""
        if self.outcome.best.train is not None:
            return self.outcome.best.train.place
        if self.function is not None:
            return self.function.place
        # Beside what is missing, friction of another shape may imitate a part of it.
        return tied(places(self.recordings.runs(unshaped(self.fit))))[0]

    def gain(self, fit: InnovationFit) -> float:
        """Return by how much a fit beats none, in BIC."""
        data = self.outcome.evidence.data
        return float(data.score(self.none) - data.score(fit))


def decide(recordings: DriveRecordings) -> Decision:
    """
    Return what explains recordings best.

    Args:
        recordings: of one drive.
    """
    if any(is_open(recording, recordings.model) for recording in recordings.recordings):
        recordings = likeliest_reading(recordings)
    outcome = contest(InnovationEvidence(recordings))
    evidence, best, data = outcome.evidence, outcome.best, outcome.evidence.data
    none = _plain(data, outcome.none.fit.fit)
    # A train beside which something remains is a torque over time without a law.
    bursts = () if outcome.lawless else best.fit.bursts
    laws = closed = best.fit.fit
    if best.function is not None:
        alone = evidence.without(best, best.members.index(best.function))
        while (number := next((i for i, m in enumerate(alone.members) if m.bounded), None)
               ) is not None:
            alone = evidence.without(alone, number)
        laws = alone.fit.fit
    elif best.train is not None and not bursts:
        laws = closed = evidence.moved(best).fit.fit
    same = laws is closed
    laws = none if not laws.candidate.ids and not bursts else _plain(
        best.fit.beside if bursts else data, laws)
    closed = laws if same else closed
    unique: dict[tuple[str, ...], InnovationFit] = {}
    for fit in sorted([h.fit.fit for h in outcome.rivals] + [laws, none], key=data.score):
        if not fit.candidate.tables:
            unique.setdefault(fit.candidate.key, fit)
    notes = (ALL_TRAINED,) if data.all_trained and not recordings.all_trained else ()
    return Decision(
        recordings.model, best.fit.beside if bursts else data, outcome, none, laws, closed,
        tuple(unique.values()), bursts, outcome.lawless, notes)


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
            or data.lasting or data.rough):
        return decision
    run = evaluated(data.whole, decision.fit).run
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
