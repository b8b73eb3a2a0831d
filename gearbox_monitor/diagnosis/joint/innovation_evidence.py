# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The evidence of a drive with its encoders: the likelihood of innovations of an EKF.

It implements hypothesis.Evidence. Nuisances with a derivative (values with tolerances, shape of
friction, torque noise) are coordinates of every fit; those without one are set about a hypothesis:
length of the steps, states in which hidden sides begin, colour of the encoders' noise, duration of
unexplained torque, torque between the stamps.
"""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
import math
from typing import ClassVar

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import (
    FUNCTION, Hypothesis, LAW, Member, MemberEstimate, of_size, Question, Remains, TRAIN)
from gearbox_monitor.diagnosis.joint import effect_scan
from gearbox_monitor.diagnosis.joint.candidates import NOT_FITTED, origin, PERIODIC, with_law
from gearbox_monitor.diagnosis.joint.drive_recordings import (
    DriveRecordings, lasting_time, likeliest)
from gearbox_monitor.diagnosis.joint.effect_scan import Proposal, raced, scan, signature
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, JointLikelihood, Tested, unfitted, variance_over_white,
    WHITE)
from gearbox_monitor.diagnosis.joint.localisation import (
    Burst, follows_motion, pulses_in, sharpened, slipping, SPACING, torque_places, with_bursts)
from gearbox_monitor.diagnosis.settings import CONTEST, THRESHOLDS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.arm_side import ARM_INERTIA, DISTURBANCE
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA
from gearbox_monitor.plant.effects.torque_map import QUANTITIES, TORQUE_MAP

POLISH, TRIMMED = 8, 6   # iterations of a fit on short steps; without a member
CLOSE = 60.0             # -2 log L by which short steps may turn a ranking on long ones round
FINER = 4                # times as many steps, where long ones show
STEPS = 0.1              # share of the remaining torque below which their error waits
LONG = 9                 # recordings, from which on functions are tested beside free torque
SIDES = 2                # places of a free torque
TIE = 1.0                # -2 log L up to which fits tie: twice the gain for which one stops
TRAINS = 3               # searches for bursts, each in the remainder of the previous one
CORRELATIONS = (0.3, 0.6, 0.8, 0.9)  # of neighbouring readings: tried
REACHES = (0.5, 0.5, 0.2, 0.05)      # by which colour and level of the noise are moved
ENOUGH = 0.1             # gain in -2 log L of a move


@dataclass(frozen=True, eq=False)
class DriveFit:
    """
    The fit of a hypothesis to recordings of a drive.

    fit: of the laws, and of a function as a torque map. occam: price of the function. slips: how
    many the recordings have. bursts, the largest first, and the recordings in which they act.
    """

    fit: InnovationFit
    occam: float = 0.0
    slips: int = 0
    bursts: tuple[Burst, ...] = ()
    beside: DriveRecordings | None = None


@dataclass(frozen=True, eq=False)
class InnovationEvidence:
    """
    Recordings of one drive as Evidence.

    data: recordings, model, noise and likelihoods. dispersion: between parts of the recordings.
    about: names of the hypotheses about which the nuisances were set.
    """

    shown: ClassVar[float] = 1.0
    unstated: ClassVar[frozenset[Member]] = frozenset()

    data: DriveRecordings
    dispersion: float = 1.0
    about: frozenset[str] = field(default_factory=frozenset)

    # --- prices

    @property
    def unit(self) -> float:
        """Price of a parameter: the logarithm of the effective number of readings."""
        return math.log(max(self.data.fine.readings / self.dispersion, 3.0))

    @cached_property
    def rivals(self) -> int:
        """Number of laws, those of a periodic effect by their order."""
        return max(1, sum(len(self.data.starts.orders) if name in PERIODIC else 1
                          for name in self.data.ids if name not in NOT_FITTED))

    @property
    def places(self) -> tuple[str, ...]:
        """Places of functions: where one encoder hides the twist, nothing shows one of it."""
        seen = not all(map(self.data.hides, self.data.recordings))
        return torque_places(self.data.model)[:3 if seen else 2]

    @cached_property
    def choice(self) -> float:
        """Price of a function among all others, of all sizes."""
        count = max(1, sum(place in self.places for place, _ in QUANTITIES))
        return 2.0 * math.log(count * len(effect_scan.SIZES))

    def _price_of_laws(self, fit: InnovationFit) -> float:
        c = fit.candidate
        count = sum(x.owner >= 0 and x.owner not in c.tables for x in c.coordinates)
        # Of ties, what moves a value of the model is the simpler cause.
        own = sum(not any(origin(self.data.model, name, c.orders.get(i)).values())
                  for i, name in enumerate(c.ids) if i not in c.tables)
        return count * self.unit + TIE * own + (
            len(c.ids) - len(c.tables)) * 2.0 * math.log(self.rivals)

    def price(self, h: Hypothesis) -> float:
        """Return the price of all members of `h`."""
        out, known = self._price_of_laws(h.fit.fit), h.fit
        if h.function is not None:
            out += known.occam + self.choice
        return out + (len(known.bursts) + known.slips) * self.price_of_event

    @property
    def price_of_event(self) -> float:
        """Price of a burst or slip: of its begin, duration and size, among all places in time."""
        places = sum(len(r.u) * r.dt for r in self.data.recordings) / SPACING
        return 3.0 * self.unit + 2.0 * math.log(places)

    def gain(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return by how much `more` beats `less`, over the dispersion."""
        return (less.deviance - more.deviance) / self.dispersion

    def likeness(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return what `more` gains over `less` beyond its price."""
        return self.gain(less, more) - self.price(more) + self.price(less)

    def reach(self, h: Hypothesis) -> float:
        """
        Return what any other explanation gains over `h` at most: its torque noise.

        That is the logarithm of the variances of its innovations over those that the least noise
        leaves.
        """
        data = h.fit.beside or self.data
        if data.balances:
            return math.inf
        at = evaluated(data.fine, h.fit.fit).run
        least = data.fine.with_noise(at, data.fine.least_noise)[2]
        return float(np.log(at.variance / least).sum()) / self.dispersion

    def dispersed(self, dispersion: float | None) -> 'InnovationEvidence':
        """Return the evidence with another dispersion; None changes nothing."""
        return self if dispersion is None else replace(self, dispersion=dispersion)

    # --- fits

    def hypothesis(self, fit: InnovationFit) -> Hypothesis:
        """Return the hypothesis of a fit on short steps."""
        c = fit.candidate
        members = tuple(
            Member(FUNCTION, name, str(c.tables[i]['place']), str(c.tables[i]['variable']))
            if i in c.tables else Member(LAW, name, library()[name].location,
                                         bounded=c.beyond(fit.z, i))
            for i, name in enumerate(c.ids))
        occam = effect_scan.occam(self.data.fine, fit, self.data.torque) if c.tables else 0.0
        return Hypothesis(members, fit.deviance, DriveFit(fit, occam, len(self.data.slips)))

    def none(self) -> Hypothesis:
        """Return the fit without members."""
        coarse = self.data.coarse
        fit = fitted(coarse, unfitted(coarse, self.data.starts.none()))
        return self.hypothesis(fitted(self.data.fine, fit, POLISH))

    def with_unstated(self, none: Hypothesis) -> Hypothesis:
        """Return `none`: the model of a drive states all its values."""
        return none

    def without(self, h: Hypothesis, number: int) -> Hypothesis:
        """Return `h` without its member `number`, refitted."""
        fit = h.fit.fit
        kept = [i for i in range(len(fit.candidate.ids)) if i != number]
        reduced, z = self.data.starts.reduced(fit.candidate, fit.z, kept)
        return self.hypothesis(fitted(
            self.data.fine, InnovationFit(reduced, z, fit.torque), TRIMMED))

    def moved(self, h: Hypothesis) -> Hypothesis:
        """Return a hypothesis `h` of other evidence on the same recordings, fitted here."""
        starts, fit = self.data.starts, h.fit.fit
        candidate = starts.joint([(fit.candidate, fit.z)]) if fit.candidate.ids else starts.none()
        z = candidate.start_from(fit.candidate, fit.z)
        return self.hypothesis(fitted(
            self.data.fine, InnovationFit(candidate, z, fit.torque), POLISH))

    def estimates(self, h: Hypothesis) -> list[MemberEstimate]:
        """Return the laws that may be added to `h`, each at its starts, the best first."""
        data = self.data
        price = self.unit + 2.0 * math.log(self.rivals)
        return [MemberEstimate(Member(LAW, p.name, library()[p.name].location),
                               p.gain / self.dispersion, price, p)
                for p in scan(data.coarse, data.starts, h.fit.fit, data.ids)]

    def grown(self, h: Hypothesis, added: Sequence[MemberEstimate]) -> list[Hypothesis]:
        """Return `h` with each of `added`: functions, and the finalists of a race of laws."""
        data, starts = self.data, []
        fit = h.fit.fit
        for e in added if data.with_map else ():
            if e.member.kind == FUNCTION:
                c = effect_scan.with_map(fit.candidate, e.source.table, data.torque)
                starts.append(InnovationFit(c, np.concatenate([fit.z, e.source.values]),
                                            fit.torque))
        proposals: list[Proposal] = [e.source for e in added if e.member.kind == LAW]
        if proposals:
            data.progress(f'effects beside {h.name}')
            starts += self._finalists(fit, raced(
                data, fit, proposals, lambda f: f.deviance + self._price_of_laws(f)))
        return [self.hypothesis(fitted(data.fine, start, POLISH)) for start in starts]

    def _finalists(self, fit: InnovationFit, fits: Sequence[InnovationFit]
                   ) -> list[InnovationFit]:
        """Return the best of the `fits` of a race that began at `fit`, the first first."""
        near = [f for i, f in enumerate(fits[:CONTEST.finalists])
                if not i or f.deviance < fits[0].deviance + CLOSE]
        if not fit.candidate.ids:
            placed = {library()[f.candidate.ids[0]].location: f for f in reversed(fits)}
            near += [f for f in placed.values() if f not in near]
        return near

    # --- what remains

    def remains(self, h: Hypothesis, thorough: bool = False) -> Remains:
        """Return what remains beside `h`; thorough: functions are tested beside free torque."""
        data = h.fit.beside or self.data
        fit, torque = h.fit.fit, self._free_torque(h)
        tested = Tested.beside(data.fine, fit)
        # What a coarse lattice adds to readings goes on from one to the next.
        memory = -math.inf if data.balances or data.rough else effect_scan.memory(tested)
        # Free torque, as large as what is missing, hides a function from a linear step.
        if h.train is not None or not (thorough or h.members or torque < CONTEST.margin
                                       or len(data.recordings) > LONG):
            return Remains(torque, memory)
        functions, dispersion = effect_scan.functions_beside(tested, self.places, data.torque)
        if data.balances and torque <= CONTEST.margin:
            functions = ()  # as much as no model of such a drive explains
        estimates = tuple(MemberEstimate(
            Member(FUNCTION, TORQUE_MAP.id, str(f.table['place']), str(f.table['variable'])),
            f.gain / dispersion, f.occam + self.choice, f) for f in functions)
        follows = max((f.gain - f.occam - self.choice for f in functions), default=-math.inf)
        return Remains(torque, memory, follows, estimates, dispersion)

    def _free_torque(self, h: Hypothesis) -> float:
        """Return what torque noise beyond the allowed is worth."""
        data, fit = h.fit.beside or self.data, h.fit.fit
        if data.balances:
            return data.beyond_share(fit)
        allowed = np.minimum(fit.torque, data.allowed_noise)
        beyond = int((allowed < fit.torque).sum())
        if not beyond:
            return 0.0
        gain = data.fine.run(fit.model, allowed).deviance - data.fine.run(
            fit.model, fit.torque).deviance
        price = beyond * self.unit + 2.0 * math.log(SIDES)
        if gain - price > CONTEST.margin and any(map(data.hides, data.recordings)):
            # A filter loses a hidden side in the gap: what free runs explain there is explained.
            gain = min(gain, data.unexplained_by_free_runs(fit))
        return gain - price

    # --- nuisances without a derivative

    def settled(self, h: Hypothesis, remains: Remains) -> 'InnovationEvidence | None':
        """Return the evidence with nuisances set about `h` by what `remains`, None: no change."""
        data, fit = self.data, h.fit.fit
        if data.balances or h.name in self.about:
            return None
        data = likeliest(data, fit)[0]
        if data.model.lasting:
            data = data.lasting_for(lasting_time(data, fit))
        left = remains.worth > CONTEST.margin
        # Before the first law: one may imitate the error of the steps.
        if left or not h.members:
            data = self._with_steps(data, fit, remains)
        if left and fit.candidate.ids and any(map(data.hides, data.recordings)):
            data = replace(data, reference=fit)
        return None if data is self.data else replace(self, data=data,
                                                      about=self.about | {h.name})

    def _with_steps(self, data: DriveRecordings, fit: InnovationFit, remains: Remains
                    ) -> DriveRecordings:
        """Return the recordings with shorter steps, where long ones make up what remains."""
        if data.finer > 1:
            return data
        # Torque noise takes up the error of the steps, too.
        shorter, torque = replace(data, finer=FINER), np.minimum(fit.torque, data.allowed_noise)
        change = data.fine.run(fit.model, torque).deviance - shorter.fine.run(
            fit.model, torque).deviance
        # Where nothing remains, the error has to pay the price of a law to pass for one.
        left = remains.worth > CONTEST.margin
        least = 0.0 if left else self.unit + 2.0 * math.log(self.rivals)
        return shorter if abs(change) > max(
            CONTEST.margin + least, STEPS * remains.torque) else data

    def _slipping(self, fit: InnovationFit) -> DriveRecordings | None:
        """Return the recordings with more slips, None where none pays beside `fit`."""
        return slipping(self.data, fit, self.dispersion * self.price_of_event) \
            if SLIP.id in self.data.ids else None

    def variants(self, h: Hypothesis, remains: Remains) -> 'list[InnovationEvidence]':
        """Return evidence with slips, another reading, friction or colour, as `remains` asks."""
        data, fit = self.data, h.fit.fit
        if data.balances:
            return []
        out = []
        slips = self._slipping(fit) if remains.worth > CONTEST.margin else None
        out += [slips] if slips is not None else []
        variant = with_law(fit.candidate, data.step)
        if variant is not None:
            out.append(replace(data, model=variant.nominal))
        # What a missing member leaves may pass for torque between the stamps: they compete.
        if remains.worth > CONTEST.margin and (
                read := likeliest(data, fit, False)[0]) is not data:
            out.append(read)
        # Of coloured noise, past innovations foretell the next ones.
        if remains.memory > CONTEST.margin:
            colour = self._colour(fit)
            if colour is not None:
                out.append(replace(data, colour=colour))
        return [replace(self, data=other, about=frozenset()) for other in out]

    def _colour(self, fit: InnovationFit) -> Array | None:
        """
        Return the colour of the encoders' noise that pays beside `fit`, None where none does.

        Correlation and size are coordinates of the likelihood, in which the noise is a state. The
        search begins where the noise has the fourth differences that were measured.
        """
        data = self.data
        channels = sorted({c for r in data.recordings for c in r.channels})

        def deviance(trial: Array) -> float:
            return JointLikelihood([p.changed(colour=trial) for p in data.fine.parts]).run(
                fit.model, fit.torque).deviance
        colour = np.array(WHITE)
        begin, lowest = deviance(data.colour), deviance(colour)

        def tried(channel: int, correlations: Sequence[float], factors: Sequence[float]) -> None:
            nonlocal lowest, colour
            for phi, factor in product(correlations, factors):
                trial = colour.copy()
                trial[channel] = phi, factor * variance_over_white(phi)
                value = deviance(trial)
                if value < lowest - ENOUGH:
                    lowest, colour = value, trial
        for c in channels:
            tried(c, CORRELATIONS, (1.0,))
        for reach in REACHES if colour[:, 0].any() else ():
            for c in channels:
                phi, factor = colour[c, 0], colour[c, 1] / variance_over_white(colour[c, 0])
                tried(c, (phi ** (1.0 + reach), phi, phi ** (1.0 / (1.0 + reach))) if phi
                      else CORRELATIONS, (factor * (1.0 + reach), factor, factor / (1.0 + reach)))
        added = int((colour[:, 0] > 0.0).sum() - (data.colour[:, 0] > 0.0).sum())
        pays = (begin - lowest) / self.dispersion - 2.0 * added * self.unit
        return colour if pays > CONTEST.margin else None

    # --- power

    def hidden(self, none: Hypothesis) -> list[Question]:
        """
        Return the changes of plausible size that would not show, and the motions that would.

        Of friction, gain and inertia. The smallest size that pays its price and the margin follows
        from the information about it, values with tolerances given way, over the dispersion by
        which the contest divides.

        Args:
            none: the fit without effects.
        """
        data, share = self.data, THRESHOLDS.plausible
        model, tested = data.model, Tested.beside(data.fine, none.fit.fit)
        # What a drive of this torque may have: half of its torque, of its gain, twice its inertia.
        sizes = {MOTOR_COULOMB.id: share * data.torque, TORQUE_GAIN.id: share,
                 SERVO_GAIN.id: share * model.value('kp') if model.controller else 0.0,
                 MOTOR_INERTIA.id: 2.0 * share * model.motor_inertia,
                 ARM_INERTIA.id: 2.0 * share * model.arm_inertia}
        price = self.unit + 2.0 * math.log(self.rivals)
        limit = self.dispersion * (CONTEST.margin + price)
        out = []
        for name in data.ids:
            if sizes.get(name):
                columns, change = signature(data.fine, tested.at, data.starts.candidates(name)[0])
                information = float((tested.without(columns[:, :1] / change[0]) ** 2).sum())
                smallest = math.sqrt(limit / max(information, 1e-300))
                if not smallest < sizes[name]:
                    out.append(of_size(*data.asked(name), (smallest, sizes[name]), price))
        return out

    # --- bursts

    def trains(self, h: Hypothesis, best: Hypothesis) -> Iterator[Hypothesis]:
        """Yield `h` with bursts that may beat `best`, each search in what the previous leaves."""
        data, fit = self.data, h.fit.fit
        if DISTURBANCE.id not in data.ids or data.balances or h.function is not None:
            return
        theta: Array = np.zeros((0, 3))
        owner: Integers = np.zeros(0, int)
        runs, at = data.runs(fit, overlapping=True), fit
        payable = (self.reach(best) + self.price(best) - self.price(h)
                   - CONTEST.margin) / self.price_of_event
        for _ in range(TRAINS):
            found = [pulses_in(run, 3.0 * self.unit) for run in runs]
            if not any(map(len, found)):
                return
            theta = np.concatenate([theta, *found])
            if len(theta) > payable:
                return
            owner = np.concatenate([owner, *(np.full(len(o), i) for i, o in enumerate(found))])
            least = self.dispersion * CONTEST.close * len(theta) * self.price_of_event
            theta, at = sharpened(data, at, theta, owner, least)
            if follows_motion(data.fine, fit, theta, owner):
                return
            beside = with_bursts(data, theta, owner)
            deviance = evaluated(beside.fine, at).deviance
            if h.deviance - deviance < least:
                return
            recordings = [data.recordings[i] for i in owner]
            bursts = sorted((Burst(r.name, r.begin + float(t0), float(duration), float(size))
                             for r, (t0, duration, size) in zip(recordings, theta)),
                            key=lambda b: -abs(b.amplitude) * b.duration)
            member = Member(TRAIN, DISTURBANCE.id, EFFECTS[DISTURBANCE.id].location)
            yield Hypothesis((*h.members, member), deviance,
                             DriveFit(at, h.fit.occam, h.fit.slips, tuple(bursts), beside))
            runs = beside.runs(at, overlapping=True)
