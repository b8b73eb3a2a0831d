# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Conventions of a robot's log: direction, zero, unit and order of joints against its description.

Evidence is the weight and the inertia that the description states. Every reading of the log is
fitted to the balance of all joints at once,

    effort = (1 + gain) model + links + tilt of gravity + friction + rotor + offset

by least squares with priors that are wide enough for any effect (a payload, other masses, another
mounting, friction of any size, a motor of another gain), and that no payload of tons passes. A
reading is named if it is better than the log as recorded, with all effects, by the log likelihood
of `margin`, and leaves little unexplained.
"""
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.robot.motion import (
    local_cosines, motion_of, RobotMotion, smooth_sign, TestFunctions)
from gearbox_monitor.diagnosis.robot.robot_log import (
    LogSection, RawLog, read_by, RobotLog, SETPOINT)
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import PER_LINK
from gearbox_monitor.signals.convention import AS_RECORDED, Convention


@dataclass(frozen=True)
class ConventionLimits:
    """
    What decides about a reading of a robot's log, each with its reason.

    margin: 2 log likelihood that another reading must gain; none of the effects of random robots
    gives it to a wrong one (test/system/robot_conventions.py). samples: independent ones of a
    joint at most: the error of a model does not average out. accuracy: share of a joint's effort
    (rms) that no description is better than; least: the same of the largest effort of the robot,
    for a light wrist. explained: share of the effort's power that an accepted reading leaves at
    most, of the joints that it changes. apart: 2 log likelihood by which a reading of another
    joint has to be worse, or both are named.

    Deviations of the priors. load: mass on any link, of the mass of the robot; links: of the mass
    of a link itself; gain: of a motor; tilt: of gravity, of 9.81 m/s^2; friction, offset, bent: of
    the rms effort of the joint (bent: sine and cosine of its angle); rotor: kg m^2 per N m.

    highest: Hz of the test functions, below resonances and delays. seconds, rate: of the motion
    that is fitted. zero: least offset, rad, that is a convention and no effect of a calibration.
    factor: least factor of an effort that is another unit and no motor of another gain.
    """

    margin: float = 30.0
    samples: float = 20.0
    accuracy: float = 0.1
    least: float = 0.01
    explained: float = 0.5
    apart: float = 6.0
    load: float = 0.1
    links: float = 0.2
    gain: float = 0.2
    tilt: float = 0.3
    friction: float = 0.3
    offset: float = 0.15
    bent: float = 0.05
    rotor: float = 0.05
    highest: float = 2.0
    seconds: int = 30
    rate: float = 20.0
    zero: float = 0.2
    factor: float = 2.0


LIMITS = ConventionLimits()
DEGREE, GRAVITY = math.pi / 180.0, 9.81
ZEROS = np.arange(-5, 7) * math.pi / 6
ZEROS = ZEROS[np.abs(ZEROS) > 1e-9]


class RobotReading(NamedTuple):
    """
    How a robot's log may have to be read.

    joints {number of a joint: Convention}; swapped: two joints whose columns are exchanged.
    """

    joints: Mapping[int, Convention] = {}
    swapped: tuple[int, int] | None = None


AS_IT_IS = RobotReading()


class ReadingScore(NamedTuple):
    """Deviance of a reading, and the share [J] of each joint's power that stays unexplained."""

    deviance: float
    unexplained: Array


class NamedReading(NamedTuple):
    """
    A reading that explains a log, with its score and that of the log as recorded.

    rivals: readings of other joints that explain it as well: of two parallel joints either may
    count the other way, which is the mirror image.
    """

    reading: RobotReading
    score: ReadingScore
    recorded: ReadingScore
    rivals: tuple[RobotReading, ...] = ()


def named_readings(log: RobotLog, robot: RobotModel, limits: tuple[Array, Array] | None = None,
                   settled: Collection[int] = ()) -> list[NamedReading]:
    """
    Return the readings that explain a log far better than any effect, the strongest first.

    Args:
        log: of the robot.
        robot: its model.
        limits: lowest and highest position [J] of the joints in the description; None: unknown.
        settled: joints whose convention a user has stated.

    Returns:
        One after the other: each is read with those before it.
    """
    motion = thinned(motion_of(log))
    found: list[NamedReading] = []
    while len(settled) < len(robot.chain.links):
        balance = ConventionBalance(robot, log.kind == SETPOINT, limits, settled)
        named = balance.named(motion)
        if named is None:
            break
        found.append(named)
        motion = as_read(motion, named.reading, balance.setpoint)
        settled = {*settled, *(named.reading.swapped or named.reading.joints)}
    return found


def as_read(motion: RobotMotion, reading: RobotReading, setpoint: bool = False) -> RobotMotion:
    """
    Return a motion as `reading` has it.

    Args:
        motion: as recorded.
        reading: how it is read.
        setpoint: whether its input is a setpoint.
    """
    columns = np.arange(motion.q.shape[1])
    if reading.swapped:
        columns[list(reading.swapped)] = reading.swapped[::-1]
    q, v, given, speed = (x[:, columns].copy() for x in (
        motion.q, motion.v, motion.input, motion.input_speed))
    sigma_v, sigma_q = motion.sigma_v[columns], motion.sigma_q[columns]
    for j, convention in reading.joints.items():
        scale = convention.sign * convention.unit
        q[:, j], v[:, j], speed[:, j] = convention.position(q[:, j]), scale * v[:, j], \
            scale * speed[:, j]
        sigma_v[j], sigma_q[j] = abs(scale) * sigma_v[j], abs(scale) * sigma_q[j]
        given[:, j] = convention.position(given[:, j]) if setpoint else convention.torque(
            given[:, j])
    return replace(motion, q=q, v=v, input=given, input_speed=speed, sigma_v=sigma_v,
                   sigma_q=sigma_q)


def columns_as_read(raw: RawLog, readings: Sequence[RobotReading]) -> RawLog:
    """Return the columns of a log as `readings` have them, one after the other."""
    joints = list(raw.position)
    for reading in readings:
        raw = read_by(raw, {joints[j]: c for j, c in reading.joints.items()})
        if reading.swapped:
            first, second = (joints[j] for j in reading.swapped)
            other = {first: second, second: first}
            raw = replace(raw, position={j: raw.position[other.get(j, j)] for j in joints},
                          input={j: raw.input[other.get(j, j)] for j in joints})
    return raw


def log_as_read(log: RobotLog, readings: Sequence[RobotReading]) -> RobotLog:
    """Return a log as `readings` have it, one after the other."""
    for reading in readings:
        sections = []
        for section in log.sections:
            order = np.arange(section.position.shape[1])
            if reading.swapped:
                order[list(reading.swapped)] = reading.swapped[::-1]
            q, given = section.position[:, order], section.input[:, order]
            for j, convention in reading.joints.items():
                q[:, j] = convention.position(q[:, j])
                given[:, j] = convention.position(given[:, j]) if log.kind == SETPOINT else \
                    convention.torque(given[:, j])
            sections.append(LogSection(section.t, q, given))
        log = replace(log, sections=tuple(sections))
    return log


class _Terms(NamedTuple):
    """
    What the balance of a motion holds, whatever the effort is.

    tests: test functions; model [J, R]: effort by the description; shared [J, R, K]: columns of
    links and of gravity; local [J, R, 7]: of each joint alone: direction, speed, 1, sine, cosine,
    rotor, model. fast [J]: rms speed; outside [J]: share of the samples beyond the limits;
    floor [J]: share of each joint's power that no description explains.
    """

    tests: TestFunctions
    model: Array
    shared: Array
    local: Array
    fast: Array
    outside: Array
    floor: Array


BRAKES = (0, 1)  # columns of a joint alone that are friction
LOAD = 4  # columns of a load: its mass and its first moment


class ConventionBalance:
    """
    The balance of a robot in which readings of a log compete.

    body [14 J]: deviations of the inertial parameters of the links, and of loads on them.
    """

    def __init__(self, robot: RobotModel, setpoint: bool,
                 limits: tuple[Array, Array] | None, settled: Collection[int] = ()) -> None:
        self.robot, self.setpoint, self.settled = robot, setpoint, settled
        chain = robot.chain
        self.limits = limits or (np.full(len(chain.links), -math.inf),
                                 np.full(len(chain.links), math.inf))
        self.slides = np.array([link.slides for link in chain.links])
        mass = float(chain.theta[:, 0].sum())
        reach = 0.05 + np.mean([np.linalg.norm(link.origin) + link.reach for link in chain.links])
        self.body = np.concatenate([
            *(LIMITS.links * link.mass * np.repeat(
                [1.0, reach, reach ** 2], [1, 3, 6]) + 1e-9 for link in chain.links),
            *(LIMITS.load * mass * np.repeat([1.0, 0.3 * reach], [1, LOAD - 1])
              for _ in chain.links)])

    def named(self, motion: RobotMotion) -> NamedReading | None:
        """Return the reading that explains `motion` instead of the one as recorded, or None."""
        tests = local_cosines(motion, LIMITS.highest)
        recorded = self.score(motion, tests)
        count = motion.q.shape[1]
        if recorded.deviance < LIMITS.margin + count * LIMITS.samples * math.log(
                LIMITS.accuracy ** 2):
            return None
        scored = sorted(self._scored(motion, tests), key=lambda pair: pair[1].deviance)
        reading, score = self._refined(motion, tests, *scored[0])
        if recorded.deviance - score.deviance < LIMITS.margin or not _is_large(reading):
            return None
        changed = list(reading.swapped or reading.joints)
        if float(np.mean(score.unexplained[changed])) > LIMITS.explained:
            return None
        rivals = {tuple(other.swapped or other.joints): other for other, its in scored[::-1]
                  if its.deviance < score.deviance + LIMITS.apart
                  and (other.swapped or set(other.joints)) != (
                      reading.swapped or set(reading.joints))}
        return NamedReading(reading, score, recorded, tuple(rivals.values()))

    def score(self, motion: RobotMotion, tests: TestFunctions,
              reading: RobotReading = AS_IT_IS) -> ReadingScore:
        """
        Return the score of a `reading`.

        Args:
            motion: as recorded.
            tests: test functions of it.
            reading: of the log.
        """
        if reading.swapped:
            order = np.arange(motion.q.shape[1])
            order[list(reading.swapped)] = reading.swapped[::-1]
            tests = replace(tests, mask=tests.mask[:, order],
                            mask_slope=tests.mask_slope[:, order])
        scale = np.ones(motion.q.shape[1])  # of efforts, whose power as recorded is the measure
        for j, convention in reading.joints.items():
            scale[j] = convention.effort
        read = as_read(motion, RobotReading({
            j: replace(convention, effort=1.0) for j, convention in reading.joints.items()},
            reading.swapped), self.setpoint)
        return self._fitted(self._terms(read, tests), scale * self._effort(read))

    def _scored(self, motion: RobotMotion, tests: TestFunctions
                ) -> Iterator[tuple[RobotReading, ReadingScore]]:
        """Yield readings of one joint, of two that are swapped, of all joints, and their score."""
        chain, joints = self.robot.chain, range(motion.q.shape[1])
        turned = [{j} for j in joints if j not in self.settled]
        turned += [set(joints)] if len(joints) > 1 and not self.settled else []
        terms, effort = self._terms(motion, tests), self._effort(motion)
        for group in turned:
            for factor in (-1.0, *_factors()) if not self.setpoint else ():
                scale = np.array([factor if j in group else 1.0 for j in joints])
                yield (RobotReading({j: Convention(effort=factor) for j in group}),
                       self._fitted(terms, scale * effort))
        for group in turned:
            alone = len(group) == 1
            slides = [chain.links[j].slides for j in group]
            conventions = [Convention(reversed=True)] * alone
            if all(np.abs(motion.q[:, j]).max() > 1.0 or slide for j, slide in zip(group, slides)):
                conventions.append(Convention(unit=1e-3 if all(slides) else DEGREE))
            conventions += [Convention(zero=float(c)) for c in ZEROS] * (alone and not slides[0])
            for convention in conventions:
                reading = RobotReading({j: convention for j in group
                                        if convention.unit != DEGREE
                                        or not chain.links[j].slides})
                read = as_read(motion, reading, self.setpoint)
                terms, effort = self._terms(read, tests), self._effort(read)
                yield reading, self._fitted(terms, effort)
                if convention.reversed and not self.setpoint:
                    scale = np.array([-1.0 if j in group else 1.0 for j in joints])
                    yield (RobotReading({j: replace(convention, effort=-1.0) for j in group}),
                           self._fitted(terms, scale * effort))
        for j in joints:
            for k in range(j) if j not in self.settled else ():
                if k in self.settled:
                    continue
                reading = RobotReading(swapped=(k, j))
                yield reading, self.score(motion, tests, reading)

    def _refined(self, motion: RobotMotion, tests: TestFunctions, reading: RobotReading,
                 score: ReadingScore) -> tuple[RobotReading, ReadingScore]:
        """Return a reading with the zero or the factor that explains most."""
        (convention, *_) = (*reading.joints.values(), AS_RECORDED)
        width, changed = (math.pi / 12, 'zero') if convention.zero else (
            0.2, 'effort') if abs(convention.effort) != 1.0 else (0.0, '')
        while width > 4e-3:
            for step in (-width, width):
                value = getattr(convention, changed)
                trial = replace(convention, **{changed: value + step if changed == 'zero'
                                               else value * math.exp(step)})
                other = RobotReading(dict.fromkeys(reading.joints, trial), reading.swapped)
                result = self.score(motion, tests, other)
                if result.deviance < score.deviance:
                    reading, score, convention = other, result, trial
                    break
            else:
                width *= 0.5
        return reading, score

    def _fitted(self, terms: _Terms, effort: Array) -> ReadingScore:
        """Return the score of an `effort` [N, J] in the balance of a motion, with all effects."""
        count, _, shared = terms.shared.shape
        size = np.sqrt(np.mean(effort ** 2, axis=0)) + 1e-9
        chain, each = self.robot.chain, terms.local.shape[2]
        own = np.stack([
            LIMITS.friction * size, LIMITS.friction * size / terms.fast, LIMITS.offset * size,
            LIMITS.bent * size, LIMITS.bent * size, LIMITS.rotor * size,
            np.full(count, LIMITS.gain)], axis=1)
        deviation = np.concatenate([self.body, np.full(3, LIMITS.tilt * GRAVITY), own.ravel()])
        columns = np.zeros((count, terms.tests.rows, len(deviation)))
        columns[:, :, :shared] = terms.shared
        least = np.full(len(deviation), -np.inf)
        loads = count * PER_LINK + np.arange(count * LOAD).reshape(count, LOAD)
        target = np.empty((count, terms.tests.rows))
        for j in range(count):
            begin = shared + j * each
            columns[j, :, begin:begin + each] = terms.local[j]
            least[[begin + k for k in BRAKES]] = -chain.coulomb[j], -chain.viscous[j]
            target[j] = terms.tests.of(effort[:, j, None], j)[:, 0]
        power = np.mean(target ** 2, axis=1) + 1e-12
        floor = terms.floor * power
        target = target - terms.model
        columns *= deviation
        gram = np.einsum('jrk,jrl->jkl', columns, columns, optimize=True)
        right = np.einsum('jrk,jr->jk', columns, target)
        variance, free = power + floor, np.ones(len(deviation), bool)
        for _ in range(4):
            weight = LIMITS.samples / target.shape[1] / variance
            matrix = np.tensordot(weight, gram, 1)[np.ix_(free, free)]
            x = np.zeros(len(free))
            x[free] = np.linalg.solve(matrix + np.eye(len(matrix)), (weight @ right)[free])
            residual = np.mean((target - columns @ x) ** 2, axis=1)
            variance = residual + floor
            free &= x * deviation >= least  # friction that pushes is none
            free[loads[x[loads[:, 0]] < 0.0]] = False  # nor a load that lifts
        return ReadingScore(float(LIMITS.samples * (np.log(variance / power) + terms.outside).sum()
                                  + x @ x), residual / power)

    def _terms(self, motion: RobotMotion, tests: TestFunctions) -> _Terms:
        """Return what the balance of a motion holds, tested by the functions `tests`."""
        chain, count = self.robot.chain, motion.q.shape[1]
        shared = np.zeros((count, tests.rows, count * (PER_LINK + LOAD) + 3))
        for r in chain.regressors(motion.q, motion.v):
            shared[r.joint, :, r.link * PER_LINK:(r.link + 1) * PER_LINK] = tests.of_rate(
                r.p, r.joint) + tests.of(r.g - r.k, r.joint)
        bodies = shared[:, :, :count * PER_LINK]
        for link in range(count):
            begin, own = count * PER_LINK + link * LOAD, link * PER_LINK
            shared[:, :, begin:begin + LOAD] = bodies[:, :, own:own + LOAD]
        model = bodies @ chain.theta.ravel()
        weights = chain.weights(motion.q)
        sign, local = smooth_sign(motion.v, motion.sigma_v), []
        spring = chain.spring * (motion.q - chain.spring_zero)
        for j in range(count):
            shared[j, :, -3:] = tests.of(weights[:, j], j)
            rotor = tests.of_rate(motion.v[:, j, None], j)
            x = tests.of(np.column_stack([
                sign[:, j], motion.v[:, j], np.ones(len(sign)), np.sin(motion.q[:, j]),
                np.cos(motion.q[:, j]), spring[:, j]]), j)
            model[j] += chain.armature[j] * rotor[:, 0] + x @ [
                chain.coulomb[j], chain.viscous[j], 0.0, 0.0, 0.0, 1.0]
            local.append(np.column_stack([x[:, :5], rotor, model[j]]))
        outside = ((motion.q < self.limits[0] - LIMITS.zero)
                   | (motion.q > self.limits[1] + LIMITS.zero)).mean(axis=0)
        return _Terms(tests, model, shared, np.stack(local),
                      np.sqrt(np.mean(motion.v ** 2, axis=0)) + 1e-9, outside,
                      self._floor(motion))

    def _floor(self, motion: RobotMotion) -> Array:
        """Return the share of each joint's power [J] that no description explains."""
        power = np.mean(self._effort(motion) ** 2, axis=0) + 1e-12
        largest = np.array([power[self.slides == slide].max() for slide in self.slides])
        return LIMITS.accuracy ** 2 + LIMITS.least ** 2 * largest / power

    def _effort(self, motion: RobotMotion) -> Array:
        """Return the torque [N, J] that was commanded, or that a servo makes of its setpoint."""
        if not self.setpoint or self.robot.kp is None:
            return motion.input
        kd = np.zeros(len(self.robot.kp)) if self.robot.kd is None else self.robot.kd
        effort = self.robot.kp * (motion.input - motion.q) - kd * motion.v
        if self.robot.compensated:
            effort = effort + self.robot.chain.weights(motion.q) @ self.robot.chain.gravity
        return effort


def _is_large(reading: RobotReading) -> bool:
    """Return whether a reading is a convention and no small effect."""
    return all(c.reversed or c.unit != 1.0 or c.effort < 0.0 or abs(c.zero) >= LIMITS.zero
               or abs(math.log(c.effort)) >= math.log(LIMITS.factor)
               for c in reading.joints.values())


def _factors() -> list[float]:
    """Return the factors of an effort that are tried: of other units, currents above all."""
    powers = 10.0 ** np.arange(-2.7, 2.71, 0.3)
    return [float(x) for x in powers if abs(math.log(x)) > math.log(LIMITS.factor)]


def thinned(motion: RobotMotion) -> RobotMotion:
    """Return a motion of lower rate and of `seconds` at most, spread over all of it."""
    every = max(1, round(1.0 / motion.step / LIMITS.rate))
    size = int(round(10.0 / motion.step))
    pieces = [slice(a, min(a + size, s.stop)) for s in motion.sections
              for a in range(s.start, s.stop, size)]
    pieces = [p for p in pieces if p.stop - p.start >= 3.0 / motion.step] or list(motion.sections)
    most = max(1, round(LIMITS.seconds / 10.0))
    pieces = [pieces[i] for i in np.unique(np.linspace(0, len(pieces) - 1, most).astype(int))]
    rows, sections, begin = [], [], 0
    for piece in pieces:
        count = (piece.stop - piece.start) // every
        rows.append(piece.start + every * np.arange(count))
        sections.append(slice(begin, begin + count))
        begin += count
    at = np.concatenate(rows)
    weights = np.ones(every) / every
    given = np.column_stack([np.convolve(x, weights, 'same') for x in motion.input.T])
    return replace(motion, t=motion.t[at], q=motion.q[at], v=motion.v[at], input=given[at],
                   input_speed=motion.input_speed[at], step=motion.step * every,
                   sections=tuple(sections))
