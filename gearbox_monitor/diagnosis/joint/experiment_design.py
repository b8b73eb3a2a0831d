# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Experiment design: the motion that best separates effects, by the angle between their signatures.

With an effect a of known size, d s2 is the evidence for it that another effect b cannot imitate
(see isolability). Motions are simulated with the effect within limits of torque, speed and travel;
the one with the largest smallest d s2 of all pairs is proposed (max-min design).
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, NOT_FITTED, origin, Starts
from gearbox_monitor.diagnosis.joint.evidence import Evidence
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated, InnovationFit
from gearbox_monitor.diagnosis.joint.isolability import InnovationSpace, twins
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.signals.recording import UniformRecording

DT = 1e-3
SHARES = (1.0, 0.6, 0.35)  # of the torque limit
SHRINK, TRIALS = 0.7, 5    # a motion that goes too far is tried with less torque
CHANGES, BEST, SPREAD = 60, 4, 0.5  # further trials near the best ones; of the logarithms
Pair: TypeAlias = tuple[str, str]
KINDS = (
    *(('multisine', weights, frequencies) for weights, frequencies in product(
        ((0.75, 0.25), (0.5, 0.5)), ((0.9, 2.3), (0.3, 1.1), (1.7, 5.1), (3.3, 9.7)))),
    ('multisine', (0.4, 0.3, 0.3), (0.4, 1.7, 6.3)),
    *(('chirp', (1.0,), sweep) for sweep in ((0.1, 3.0), (0.5, 8.0), (1.0, 20.0), (5.0, 40.0))),
    *(('square', (1.0,), (f,)) for f in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)),
    *(('triangle', (1.0,), (f,)) for f in (0.1, 0.2, 0.5, 1.0, 2.5)))


@dataclass(frozen=True)
class Limits:
    """Largest torque (N m), speed (rad/s) and travel (rad, either side of the start) allowed."""

    torque: float
    speed: float = math.inf
    travel: float = math.inf


@dataclass(frozen=True)
class SuggestedMotion:
    """
    One motion: parameters of drive.excitation.Excitation, and what it would tell.

    separation {(a, b): d s2}; reached: Limits that the simulation took up.
    """

    kind: str
    amplitudes: tuple[float, ...]
    frequencies: tuple[float, ...]
    seconds: float
    separation: dict[Pair, float]
    reached: Limits

    @property
    def least(self) -> float:
        """The smallest d s2 of all pairs."""
        return min(self.separation.values())

    def torque(self, dt: float = DT) -> tuple[Array, Array]:
        """
        Return (t [N], u [N]) in s and N m.

        Args:
            dt: sample time, s.
        """
        t = np.arange(round(self.seconds / dt)) * dt
        return t, Excitation(self.kind, self.amplitudes, self.frequencies,
                             self.seconds).torque(t)


def sized(starts: Starts, name: str, values: Values | None = None) -> CandidateModel:
    """
    Return the Candidate of effect `name` at `values` {parameter: value}, or at a usual size.

    Args:
        starts: of effects in one recording.
        name: id of an effect.
        values: parameters of the effect by name, None for a usual size.
    """
    if values:
        return starts.at(name, values)
    candidate = starts.candidates(name, 1)[0]
    at_rest = origin(starts.model, name, 1)
    return replace(candidate, coordinates=tuple(
        replace(c, start=c.start + 0.1 * c.scale)
        if c.owner == 0 and not c.log and c.start == at_rest.get(c.name, 0.0) else c
        for c in candidate.coordinates))


def separations(model: DriveModel, effects: Mapping[str, Values | None], u: Array, sigma: Array,
                pairs: Sequence[Pair]) -> tuple[dict[Pair, float], Limits] | tuple[None, None]:
    """
    Return ({(a, b): d s2}, limits reached) for a torque, (None, None) if a run diverges.

    d s2 is the evidence for effect a that effect b cannot imitate (see isolability).

    Args:
        model: nominal model of the drive.
        effects: parameters by id of the effect; None for a usual size.
        u: torque of the motor [N], N m, DT apart.
        sigma: noise of the encoders [2], rad.
        pairs: pairs (a, b) of ids, a present and b its rival.
    """
    out, reached = {}, Limits(0.0, 0.0, 0.0)
    plain = simulate(model, u, DT)
    if not np.isfinite(plain.x).all():
        return None, None
    probe = UniformRecording(plain.t, u, plain.y, DT)
    for a in dict.fromkeys(a for a, _ in pairs):
        candidate = sized(Starts(model, (probe,)), a, effects.get(a))
        run = simulate(candidate.model(candidate.start()), u, DT)
        if not np.isfinite(run.x).all():
            return None, None
        reached = Limits(float(np.abs(u).max()),
                         max(reached.speed, float(np.abs(run.x[:, 2:]).max())),
                         max(reached.travel, float(np.abs(run.x[:, :2]).max())))
        rivals = [b for effect, b in pairs if effect == a]
        evidence = Evidence((replace(probe, y=run.y),), model, sigma, ())
        at = evaluated(evidence.fine, InnovationFit(
            candidate, candidate.start(), evidence.fine.least_noise))
        orders = {b: int((effects.get(b) or effects.get(a) or {}).get('N', 1)) for b in rivals}
        space = InnovationSpace(evidence.fine, at, evidence.starts, orders)
        d, shares = space.separation(0, {b: space.signature(b) for b in rivals})
        out.update({(a, b): d * share for b, share in shares.items()})
    return out, reached


def suggest(model: DriveModel, effects: Mapping[str, Values | None], pairs: Sequence[Pair],
            limits: Limits, sigma: Array, seconds: float = 12.0,
            progress: Callable[..., object] | None = None) -> list[SuggestedMotion]:
    """
    Return the motions that separate `pairs` within `limits`, best first.

    A list of motions is tried first, then random changes of the best ones.

    Args:
        model: nominal model of the drive.
        effects: {parameter: value} by id of the effect, None for a usual size.
        pairs: pairs (a, b) of ids: separate a from b.
        limits: largest torque, speed and travel allowed.
        sigma: noise of the encoders [2], rad.
        seconds: duration, s.
        progress: callback with (done, total).

    Raises:
        InputError: no pair that a motion could separate.
    """
    # Twins differ near standstill only, by less than any model of friction is good for.
    pairs = [(a, b) for a, b in pairs
             if not {a, b} & set(NOT_FITTED) and (a, b) not in twins()]
    if not pairs:
        raise InputError('motion: no pair of effects that a motion could separate')
    random = np.random.default_rng(0)
    motions, done, total = [], 0, len(KINDS) * len(SHARES) + CHANGES

    def tried(kind: str, amplitudes: Iterable[float], frequencies: Iterable[float],
              trials: int = TRIALS) -> None:
        """
        Add the motion to `motions`, with less torque until it stays within the limits.

        Args:
            kind: kind of the excitation.
            amplitudes: amplitudes of its components, N m.
            frequencies: their frequencies, Hz.
            trials: largest number of reductions.
        """
        motion = SuggestedMotion(kind, tuple(map(float, amplitudes)),
                                 tuple(map(float, frequencies)), seconds, {}, limits)
        for _ in range(trials):
            separation, reached = separations(
                model, effects, motion.torque()[1], sigma, pairs)
            if separation is not None and reached is not None and (
                    reached.speed <= limits.speed and reached.travel <= limits.travel):
                motions.append(replace(motion, separation=separation, reached=reached))
                return
            motion = replace(motion, amplitudes=tuple(SHRINK * a for a in motion.amplitudes))
    for (kind, weights, frequencies), share in product(KINDS, SHARES):
        tried(kind, share * limits.torque * np.array(weights), frequencies)
        done += 1
        if progress:
            progress(done, total)
    for k in range(CHANGES if motions else 0):
        motions.sort(key=lambda m: -m.least)
        motion = motions[min(k % BEST, len(motions) - 1)]
        spread = SPREAD * (1.0 - k / CHANGES) + 0.05
        amplitudes = np.array(motion.amplitudes) * np.exp(
            spread * random.standard_normal(len(motion.amplitudes)))
        amplitudes *= min(1.0, limits.torque / amplitudes.sum())
        changed = np.array(motion.frequencies) * np.exp(
            spread * random.standard_normal(len(motion.frequencies)))
        tried(motion.kind, amplitudes, changed, 1)
        if progress:
            progress(done + k + 1, total)
    return sorted(motions, key=lambda m: -m.least)
