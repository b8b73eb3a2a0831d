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
from functools import cached_property
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.robot.motion import (
    local_cosines, motion_of, RobotMotion, smooth_sign, TestFunctions)
from gearbox_monitor.diagnosis.robot.robot_log import (
    LogSection, RawLog, read_by, RobotLog, SETPOINT)
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.zeros import excerpt, zeros_in
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.robot.chain import PER_LINK
from gearbox_monitor.signals.recording import AS_RECORDED, Convention


@dataclass(frozen=True)
class ConventionLimits:
    """
    What decides about a reading of a robot's log, each with its reason.

    margin: 2 log likelihood that another reading must gain; none of the effects of random robots
    gives it to a wrong one (test/system/robot_conventions.py). samples: independent ones of a
    joint at most: the error of a model does not average out. accuracy: share of a joint's effort
    (rms) that no description is better than; least: the same of the largest effort of the robot,
    for a light wrist. explained: share of the effort's power that an accepted reading leaves at
    most, of the joints that it changes. doubtful: residual of a joint relative to the accuracy,
    from which on a log as recorded is doubted. apart: 2 log likelihood by which a reading of
    another joint has to be worse, or both are named.

    Deviations of the priors. load: mass on any link, of the mass of the robot; links: of the mass
    of a link itself; gain: of a motor; tilt: of gravity, of 9.81 m/s^2; friction, offset, bent: of
    the rms effort of the joint (bent: sine and cosine of its angle); rotor: kg m^2 per N m.

    highest: Hz of the test functions, below resonances and delays. rate: of the motion that is
    fitted. turned: rad, the least zero that the weight names
    within the tolerances of the description: a smaller one is an effect of a calibration.
    factor: least factor of an effort that is another unit and no motor of another gain. An effort
    that a factor of UNRELATED explains as well is friction: its unit stays unknown.
    """

    margin: float = 30.0
    samples: float = 20.0
    accuracy: float = 0.1
    least: float = 0.01
    explained: float = 0.5
    doubtful: float = 2.0
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
    rate: float = 20.0
    turned: float = 0.08
    factor: float = 2.0


LIMITS = ConventionLimits()
DEGREE, GRAVITY = math.pi / 180.0, 9.81
READ_AGAIN = 5  # times at most that a log is read with the zeros found so far
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
                   settled: Collection[int] = (), left: float = 0.0) -> list[NamedReading]:
    """
    Return the readings that explain a log far better than any effect, the strongest first.

    Args:
        log: of the robot.
        robot: its model.
        limits: lowest and highest position [J] of the joints in the description; None: unknown.
        settled: joints whose convention a user has stated.
        left: misfit that remains where the robot is read rightly, as of its reference.

    Returns:
        One after the other: each is read with those before it.
    """
    motion, setpoint = thinned(log), log.kind == SETPOINT
    recorded, found = motion, list[NamedReading]()
    while len(settled) < len(robot.chain.links):
        named = ConventionBalance(robot, motion, setpoint, limits, settled).named(left)
        if not named:
            break
        found += named
        for reading in (n.reading for n in named):
            motion = as_read(motion, reading, setpoint)
            settled = {*settled, *(reading.swapped or reading.joints)}
    if len(found) > 1 and not any(n.reading.swapped for n in found):
        # Each was found while others were wrong: its zero or factor follows.
        for k, named_one in enumerate(found):
            motion = recorded
            for other in (n.reading for i, n in enumerate(found) if i != k):
                motion = as_read(motion, other, setpoint)
            reading, score = ConventionBalance(robot, motion, setpoint, limits).refined(
                named_one.reading)
            found[k] = named_one._replace(reading=reading, score=score)
    return found or _turned(log, robot, settled)


def _turned(log: RobotLog, robot: RobotModel, settled: Collection[int]) -> list[NamedReading]:
    """Return readings of zeros of tenths of a rad in a log, but for joints that are `settled`."""
    zeros: dict[int, float] = {}
    for _ in range(READ_AGAIN):
        read = log_as_read(log, _zero_readings(zeros))
        found = zeros_in(read, robot, settled)
        j = found.joint
        if j is None or found.rival or j not in zeros and abs(found.zero) < LIMITS.turned:
            break
        zeros[j] = zeros.get(j, 0.0) + found.zero
        if abs(found.zero) < LIMITS.turned:
            settled = {*settled, j}
    if not zeros:
        return []
    recorded = ConventionBalance(robot, thinned(log), log.kind == SETPOINT).score()
    score = ConventionBalance(robot, thinned(read), log.kind == SETPOINT).score()
    return [NamedReading(r, score, recorded) for r in _zero_readings(zeros)]


def _zero_readings(zeros: Mapping[int, float]) -> list[RobotReading]:
    """Return the readings of `zeros` {number of a joint: rad}."""
    return [RobotReading({j: Convention(zero=c)}) for j, c in zeros.items()]


def misfit(log: RobotLog, robot: RobotModel, limits: tuple[Array, Array] | None = None) -> float:
    """Return what a log leaves as it is recorded; arguments as of named_readings."""
    motion = thinned(log)
    return ConventionBalance(robot, motion, log.kind == SETPOINT, limits).misfit


def least_explained(log: RobotLog, robot: RobotModel, limits: tuple[Array, Array] | None = None
                    ) -> tuple[int, float] | None:
    """
    Return the joint that the model explains least, and the unexplained share of its rms effort.

    None if no joint is in doubt. Arguments as of named_readings.
    """
    balance = ConventionBalance(robot, thinned(log), log.kind == SETPOINT, limits)
    recorded = balance.score()
    rest = balance.rest(recorded)
    if balance.misfit < LIMITS.margin or rest.max() <= LIMITS.doubtful:
        return None
    j = int(np.argmax(rest))
    return j, math.sqrt(float(recorded.unexplained[j]))


def as_read(motion: RobotMotion, reading: RobotReading, setpoint: bool = False) -> RobotMotion:
    """
    Return a motion as `reading` has it.

    Args:
        motion: as recorded.
        reading: how it is read.
        setpoint: whether its input is a setpoint.
    """
    order, scale = _order(motion.q, reading), np.ones(motion.q.shape[1])
    for j, convention in reading.joints.items():
        scale[j] = convention.sign * convention.unit
    q, given = _columns(motion.q, motion.input, reading, setpoint)
    return replace(motion, q=q, v=scale * motion.v[:, order], input=given,
                   input_speed=scale * motion.input_speed[:, order],
                   sigma_v=np.abs(scale) * motion.sigma_v[order],
                   sigma_q=np.abs(scale) * motion.sigma_q[order])


def _order(q: Array, reading: RobotReading) -> Integers:
    """Return which column of `q` [N, J] each joint reads."""
    order = np.arange(q.shape[1])
    if reading.swapped:
        order[list(reading.swapped)] = reading.swapped[::-1]
    return order


def _columns(q: Array, given: Array, reading: RobotReading, setpoint: bool
             ) -> tuple[Array, Array]:
    """Return positions and input [N, J] as `reading` has them."""
    order = _order(q, reading)
    q, given = q[:, order], given[:, order]
    for j, convention in reading.joints.items():
        q[:, j] = convention.position(q[:, j])
        given[:, j] = (convention.position if setpoint else convention.torque)(given[:, j])
    return q, given


def columns_as_read(raw: RawLog, readings: Sequence[RobotReading]) -> RawLog:
    """Return the columns of a log as `readings` have them, one after the other."""
    joints = list(raw.position)
    for reading in readings:
        raw = read_by(raw, {joints[j]: c for j, c in reading.joints.items()})
        if reading.swapped:
            first, second = (joints[j] for j in reading.swapped)
            other = {first: second, second: first}
            raw = replace(raw, position={j: raw.position[other.get(j, j)] for j in joints},
                          input={j: raw.input[other.get(j, j)] for j in joints},
                          setpoint={j: raw.setpoint[other.get(j, j)] for j in raw.setpoint})
    return raw


def log_as_read(log: RobotLog, readings: Sequence[RobotReading]) -> RobotLog:
    """Return a log as `readings` have it, one after the other."""
    for reading in readings:
        log = replace(log, sections=tuple(
            LogSection(x.t, *_columns(x.position, x.input, reading, log.kind == SETPOINT),
                       None if x.setpoint is None else
                       _columns(x.position, x.setpoint, reading, True)[1])
            for x in log.sections))
    return log


class _Products(NamedTuple):
    """
    Products of the columns of V readings of a motion, for each joint: all that a fit needs.

    gram of each joint [V, C, C]: of the columns of the links from its own on, of gravity, of the
    joint alone, each for a deviation of its prior, and of its effort. rows: of one joint. own
    [V, J, OWN]: deviations of what a joint has alone; floor [V, J]: share of the power that no
    description explains; outside [V, J]: share of samples beyond the limits.
    """

    gram: tuple[Array, ...]
    rows: int
    own: Array
    floor: Array
    outside: Array


# Columns of a joint alone: friction by direction and speed, 1, sine, cosine, rotor, model (a
# motor of another gain).
BRAKES, GAIN, OWN = 2, 6, 7
NONE = 1e12     # weight of a prior that lets a column be nothing


class ConventionBalance:
    """
    The balance of a robot's motion, in which readings of its log compete.

    shared [K]: deviations of the inertial parameters of the links, a load on each included, and
    of gravity; unloaded [K]: how much surer these are without a load. largest [J]: power of the
    largest effort of a joint of its kind, the same for all readings that are compared: one that
    makes an effort small would leave the others a model without error.
    """

    def __init__(self, robot: RobotModel, motion: RobotMotion, setpoint: bool = False,
                 limits: tuple[Array, Array] | None = None,
                 settled: Collection[int] = ()) -> None:
        self.robot, self.setpoint, self.settled = robot, setpoint, settled
        self.motion, self.tests = motion, local_cosines(motion, LIMITS.highest)
        chain = robot.chain
        self.limits = limits or (np.full(len(chain.links), -math.inf),
                                 np.full(len(chain.links), math.inf))
        self.slides = np.array([link.slides for link in chain.links])
        mass = float(chain.theta[:, 0].sum())
        reach = 0.05 + np.mean([np.linalg.norm(link.origin) + link.reach for link in chain.links])
        bodies = np.concatenate([
            *(LIMITS.links * link.mass * np.repeat([1.0, reach, reach ** 2], [1, 3, 6]) + 1e-9
              for link in chain.links), np.full(3, LIMITS.tilt * GRAVITY)])
        load = LIMITS.load * mass * np.repeat([1.0, 0.3 * reach, 0.0], [1, 3, PER_LINK - 4])
        self.shared = np.hypot(bodies, np.append(np.tile(load, len(chain.links)), np.zeros(3)))
        self.unloaded = (self.shared / bodies) ** 2
        power = np.mean(self._effort(motion) ** 2, axis=0)
        self.largest = np.array([power[self.slides == slide].max() for slide in self.slides])

    @property
    def misfit(self) -> float:
        """What better readings can gain at most, in 2 log likelihood."""
        return self.score().deviance - LIMITS.samples * float(
            np.log(self._recorded.floor).sum())

    def rest(self, score: ReadingScore) -> Array:
        """Return the residual rms [J] of a `score`, relative to the accuracy of a description."""
        return np.asarray(np.sqrt(score.unexplained / self._recorded.floor[0]))

    def named(self, left: float = 0.0) -> list[NamedReading]:
        """Return the reading that explains the motion instead of the recorded one, or two."""
        scored = sorted(self._scored(), key=lambda pair: pair[1].deviance) if (
            self.misfit >= LIMITS.margin + left) else ()
        if not scored:
            return []
        recorded, (reading, score) = self.score(), self.refined(scored[0][0])
        if reading.swapped and (len(set(self.slides[list(reading.swapped)])) > 1 or np.abs(
                self.motion.v[:, list(reading.swapped)]).max() < SETTINGS.slow):
            return []  # a slide is in m, a hinge in rad; joints that stand have offsets alone
        if self._accepted(reading, score, recorded):
            rivals = {tuple(other.swapped or other.joints): other for other, its in scored[::-1]
                      if its.deviance < score.deviance + LIMITS.apart
                      and (other.swapped or set(other.joints)) != (
                          reading.swapped or set(reading.joints))}
            return [NamedReading(reading, score, recorded, tuple(rivals.values()))]
        exact = [pair for pair in scored if _is_exact(pair[0])]
        return self._with_another(recorded, *exact[0]) if exact else []

    def _with_another(self, recorded: ReadingScore, reading: RobotReading, score: ReadingScore
                      ) -> list[NamedReading]:
        """
        Return `reading` and another one that explain the motion together, [] without.

        The first alone, with its `score`, may explain the second joint worse than `recorded`
        does. Zeros and factors are left out: two free values can imitate two effects.
        """
        settled = {*self.settled, *(reading.swapped or reading.joints)}
        if (self.rest(recorded) <= LIMITS.doubtful).all():
            return []
        balance = ConventionBalance(self.robot, as_read(self.motion, reading, self.setpoint),
                                    self.setpoint, self.limits, settled)
        another, both = min((pair for pair in balance._scored() if _is_exact(pair[0])),
                            key=lambda pair: pair[1].deviance, default=(AS_IT_IS, score))
        return [NamedReading(r, both, recorded) for r in (reading, another)] if (
            self._accepted(another, both, score)) else []

    @staticmethod
    def _accepted(reading: RobotReading, score: ReadingScore, other: ReadingScore) -> bool:
        """Return whether a reading is a convention, better than another one, and explains all."""
        changed = list(reading.swapped or reading.joints)
        # A command beyond a motor's limit looks like another unit, and contradicts other joints.
        worse = score.unexplained > np.maximum(2.0 * other.unexplained, LIMITS.accuracy)
        worse[changed] = float(np.mean(score.unexplained[changed])) > LIMITS.explained
        return (other.deviance - score.deviance >= LIMITS.margin and _is_large(reading)
                and not worse.any())

    def score(self, reading: RobotReading = AS_IT_IS) -> ReadingScore:
        """Return the score of a `reading` of the log."""
        return self._scores([reading])[0]

    def _scores(self, readings: Sequence[RobotReading]) -> list[ReadingScore]:
        """Return the scores of `readings`."""
        scores: list[ReadingScore] = []
        for begin in range(0, len(readings), AT_ONCE):
            part = readings[begin:begin + AT_ONCE]
            scale = np.ones((len(part), self.motion.q.shape[1]))
            for row, reading in zip(scale, part):
                for j, convention in reading.joints.items():
                    row[j] = convention.effort
            only_efforts = all(not r.swapped and all(
                replace(c, effort=1.0) == AS_RECORDED for c in r.joints.values()) for r in part)
            scores += _least_squares(
                self, self._recorded if only_efforts else self._products(part), scale)
        return scores

    def _scored(self) -> Iterator[tuple[RobotReading, ReadingScore]]:
        """Yield readings of one joint, of two that are swapped, of all joints, and their score."""
        links, joints = self.robot.chain.links, range(self.motion.q.shape[1])
        groups = [[j] for j in joints if j not in self.settled]
        groups += [list(joints)] if len(joints) > 1 and not self.settled else []
        for group in [] if self.setpoint else groups:
            readings = [RobotReading(dict.fromkeys(group, Convention(effort=factor)))
                        for factor in (*UNRELATED, -1.0, *_factors())]
            tiny, huge, negative, *scores = self._scores(readings)
            yield readings[2], negative
            for factor, reading, score in zip(_factors(), readings[3:], scores):
                unrelated = (tiny if factor < 1.0 else huge).deviance
                # Removing the model costs 1 / gain^2 by its prior: a true factor keeps most of it.
                if score.deviance < unrelated - 0.5 * len(group) / LIMITS.gain ** 2:
                    yield reading, score
        readings = [RobotReading(swapped=(k, j)) for j in joints for k in range(j)
                    if not {j, k} & set(self.settled)]
        for group in groups:
            slide = [links[j].slides for j in group]
            if all(np.abs(self.motion.q[:, j]).max() > 1.0 or links[j].slides for j in group):
                unit = 1e-3 if all(slide) else DEGREE
                readings.append(RobotReading({j: Convention(unit=unit) for j in group
                                              if unit != DEGREE or not links[j].slides}))
            if len(group) == 1:
                readings += [RobotReading({group[0]: Convention(True, effort=sign)})
                             for sign in ((1.0,) if self.setpoint else (1.0, -1.0))]
            if len(group) == 1 and not slide[0]:
                readings += [RobotReading({group[0]: Convention(zero=float(c))}) for c in ZEROS]
        yield from zip(readings, self._scores(readings))

    def refined(self, reading: RobotReading) -> tuple[RobotReading, ReadingScore]:
        """Return a reading with the zero or the factor that explains most, and its score."""
        score = self.score(reading)
        (convention, *_) = (*reading.joints.values(), AS_RECORDED)
        width, changed = (math.pi / 12, 'zero') if convention.zero else (
            0.2, 'effort') if abs(convention.effort) != 1.0 else (0.0, '')
        while width > 4e-3:
            value = getattr(convention, changed)
            trials = [replace(convention, **{changed: value + step if changed == 'zero'
                                             else value * math.exp(step)})
                      for step in (-width, width)]
            others = [RobotReading(dict.fromkeys(reading.joints, trial)) for trial in trials]
            results = self._scores(others)
            k = int(np.argmin([result.deviance for result in results]))
            if results[k].deviance < score.deviance:
                reading, score, convention = others[k], results[k], trials[k]
            else:
                width *= 0.5
        return reading, score

    @cached_property
    def _recorded(self) -> _Products:
        """Products of the columns as recorded."""
        return self._products([AS_IT_IS])

    @cached_property
    def _as_recorded(self) -> Array:
        """Shared columns [1, J, R, K] as recorded."""
        motion, tests = self.motion, self.tests
        return self._shared(motion.q[None], motion.v[None], tests.mask[None],
                            tests.mask_slope[None])

    def _products(self, readings: Sequence[RobotReading]) -> _Products:
        """Return the products of columns of `readings`, whose factors of effort do not count."""
        motion, tests = self.motion, self.tests
        chain = self.robot.chain
        orders = np.stack([_order(motion.q, reading) for reading in readings])
        read = [as_read(motion, RobotReading({
            j: replace(convention, effort=1.0) for j, convention in reading.joints.items()},
            reading.swapped), self.setpoint) for reading in readings]
        q, v, sigma = (np.stack([getattr(m, name) for m in read]) for name in ('q', 'v',
                                                                               'sigma_v'))
        effort = np.stack([self._effort(m) for m in read])
        mask, slope = (x[:, orders].transpose(1, 0, 2) for x in (tests.mask, tests.mask_slope))
        changed = {j for reading in readings for j in (*(reading.swapped or ()), *reading.joints)}
        shared = self._shared(q, v, mask, slope, changed) if changed else self._as_recorded
        power = np.mean(effort ** 2, axis=1)
        size, one = np.sqrt(power) + 1e-9, np.ones(power.shape)
        own = np.stack([
            LIMITS.friction * size, LIMITS.friction * size / (np.sqrt(np.mean(v ** 2, axis=1))
                                                              + 1e-9),
            LIMITS.offset * size, LIMITS.bent * size, LIMITS.bent * size, LIMITS.rotor * size,
            LIMITS.gain * one], axis=2)
        spring, grams = chain.spring * (q - chain.spring_zero), []
        for j in range(q.shape[2]):
            links = shared[:, j, :, :-3].reshape(*shared.shape[:1], tests.rows, -1, PER_LINK)
            at = v[:, :, j]
            sign = smooth_sign(at[..., None], sigma[:, None, j, None])[..., 0]
            passive = chain.coulomb[j] * sign + chain.viscous[j] * at + spring[:, :, j]
            x = _tested(np.stack([
                sign, at, np.ones_like(at), np.sin(q[:, :, j]), np.cos(q[:, :, j]), passive,
                effort[:, :, j]], axis=-1), tests, mask[:, :, j])
            rotor = _tested_rate(at[..., None], tests, mask[:, :, j], slope[:, :, j])
            model = (np.einsum('vrlp,lp->vr', links, chain.theta)
                     + chain.armature[j] * rotor[..., 0] + x[..., GAIN - 1])
            begin = min(chain.moved_by(j)) * PER_LINK
            columns = np.concatenate([
                shared[:, j, :, begin:] * self.shared[begin:], np.concatenate([
                    x[..., :GAIN - 1], rotor, model[..., None]], axis=-1) * own[:, j, None],
                x[..., -1:]], axis=-1)
            grams.append(columns.transpose(0, 2, 1) @ columns)
        low, high = self.limits
        outside = ((q < low - SETTINGS.zero_shown) | (q > high + SETTINGS.zero_shown)
                   ).mean(axis=1)
        floor = LIMITS.accuracy ** 2 + LIMITS.least ** 2 * self.largest / (power + 1e-12)
        return _Products(tuple(grams), tests.rows, own, floor, outside)

    def _shared(self, q: Array, v: Array, mask: Array, slope: Array,
                changed: Collection[int] | None = None) -> Array:
        """
        Return the columns [V, J, R, K] of links and gravity of V motions.

        Args:
            q: positions [V, N, J].
            v: speeds [V, N, J].
            mask: of each motion [V, N, J].
            slope: derivative of the mask.
            changed: joints in which the motions differ from the recorded one, None: in all.
        """
        size, samples, count = q.shape
        chain, tests = self.robot.chain, self.tests
        if changed is None:
            links, out = set(range(count)), np.zeros(
                (size, count, tests.rows, count * PER_LINK + 3))
        else:
            links = {link for j in changed for link in chain.moved_by(j)}
            out = np.repeat(self._as_recorded, size, axis=0)
        flat = q.reshape(-1, count), v.reshape(-1, count)
        for r in chain.regressors(*flat, links=links):
            p, load = (x.reshape(size, samples, PER_LINK) for x in (r.p, r.g - r.k))
            out[:, r.joint, :, r.link * PER_LINK:(r.link + 1) * PER_LINK] = _tested_rate(
                p, tests, mask[:, :, r.joint], slope[:, :, r.joint], load)
        weights = chain.weights(flat[0]).reshape(size, samples, count, 3)
        for j in range(count):
            out[:, j, :, -3:] = _tested(weights[:, :, j], tests, mask[:, :, j])
        return out

    def _effort(self, motion: RobotMotion) -> Array:
        """Return the torque [N, J] that was commanded, or that a servo makes of its setpoint."""
        if not self.setpoint or self.robot.kp is None:
            return motion.input
        kd = np.zeros(len(self.robot.kp)) if self.robot.kd is None else self.robot.kd
        effort = self.robot.kp * (motion.input - motion.q) - kd * motion.v
        if self.robot.compensated:
            effort = effort + self.robot.chain.weights(motion.q) @ self.robot.chain.gravity
        return effort


AT_ONCE = 12  # readings that are evaluated together
UNRELATED = (1e-6, 1e6)  # factors of an effort that make it and the model unrelated


def _blocks(x: Array, tests: TestFunctions) -> Array:
    """Return the samples [V, S, 2 hop, K] of the segments of `x` [V, N, K]."""
    return x[:, tests.starts[:, None] + np.arange(len(tests.value))]


def _tested(x: Array, tests: TestFunctions, mask: Array) -> Array:
    """Return the integrals [V, R, K] of phi mu x, `x` [V, N, K], `mask` [V, N]."""
    return (tests.value.T @ _blocks(x * mask[..., None], tests)).reshape(
        len(x), -1, x.shape[-1])


def _tested_rate(x: Array, tests: TestFunctions, mask: Array, slope: Array,
                 more: Array | None = None) -> Array:
    """
    Return the integrals [V, R, K] of phi mu (dx/dt + more), by parts.

    Args:
        x: is not differentiated [V, N, K].
        tests: test functions phi.
        mask: mu [V, N].
        slope: derivative of the mask [V, N].
        more: what is added [V, N, K].
    """
    rest = -x * slope[..., None]
    if more is not None:
        rest += more * mask[..., None]
    out = tests.value.T @ _blocks(rest, tests)
    out -= tests.slope.T @ _blocks(x * mask[..., None], tests)
    return out.reshape(len(x), -1, x.shape[-1])


def _least_squares(balance: ConventionBalance, products: _Products, scale: Array
                   ) -> list[ReadingScore]:
    """
    Return the scores of V readings in the balance, with all effects.

    A joint's own columns are eliminated.

    Args:
        balance: with the deviations of the priors.
        products: of the columns of each reading, or of one for all.
        scale: factors of the efforts [V, J].
    """
    chain, rows = balance.robot.chain, products.rows
    (versions, count), known = scale.shape, len(balance.shared)
    sure = np.ones((versions, count, OWN)) / scale[:, :, None] ** 2
    sure[:, :, GAIN] = 1.0
    target, square, power = [], np.empty(scale.shape), np.empty(scale.shape)
    for j, gram in enumerate(products.gram):  # of the effort less the model's
        s, gain = scale[:, j], products.own[:, j, GAIN]
        model = gram.shape[1] - 1 - OWN + GAIN
        target.append(s[:, None] * gram[:, :-1, -1] - gram[:, :-1, model] / gain[:, None])
        square[:, j] = (s ** 2 * gram[:, -1, -1] - 2.0 * s * gram[:, model, -1] / gain
                        + gram[:, model, model] / gain ** 2) / rows
        power[:, j] = s ** 2 * gram[:, -1, -1] / rows + 1e-12
    floor = products.floor * power
    variance, residual = power + floor, np.empty_like(power)
    loaded = np.ones((versions, count), bool)
    for _ in range(4):
        prior = np.where(np.append(np.repeat(loaded, PER_LINK, axis=1), np.ones((versions, 3)), 1),
                         1.0, balance.unloaded)
        matrix, right, solved = prior[:, :, None] * np.eye(known), np.zeros(prior.shape), []
        weight = LIMITS.samples / rows / variance
        for j, gram in enumerate(products.gram):
            k, w = gram.shape[1] - 1 - OWN, weight[:, j, None]
            shared, begin = gram[:, :k, k:-1], known - k
            alone = np.linalg.solve(
                gram[:, k:-1, k:-1] + (sure[:, j] / w)[:, :, None] * np.eye(OWN),
                np.concatenate([np.broadcast_to(gram[:, k:-1, :k], (versions, OWN, k)),
                                target[j][:, k:, None]], axis=2))
            reduced = shared @ alone
            matrix[:, begin:, begin:] += w[:, :, None] * (gram[:, :k, :k] - reduced[:, :, :k])
            right[:, begin:] += w * (target[j][:, :k] - reduced[:, :, k])
            solved.append(alone)
        x = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        cost = (prior * x ** 2).sum(axis=1)
        for j, (gram, alone) in enumerate(zip(products.gram, solved)):
            z = x[:, known - alone.shape[2] + 1:]
            own = alone[:, :, -1] - (alone[:, :, :-1] @ z[:, :, None])[:, :, 0]
            z = np.concatenate([z, own], axis=1)
            image = (gram[:, :-1, :-1] @ z[:, :, None])[:, :, 0] - 2.0 * target[j]
            residual[:, j] = np.maximum(square[:, j] + (z * image).sum(axis=1) / rows, 0.0)
            cost += (sure[:, j] * own ** 2).sum(axis=1)
            # Friction that pushes is none.
            pushes = own[:, :BRAKES] * products.own[:, j, :BRAKES] < [-chain.coulomb[j],
                                                                      -chain.viscous[j]]
            sure[:, j, :BRAKES][pushes] = NONE
        variance = residual + floor
        loaded &= x[:, :-3:PER_LINK] >= 0.0  # nor is a load that lifts
    deviance = LIMITS.samples * (np.log(variance / power) + products.outside).sum(axis=1) + cost
    return [ReadingScore(float(d), share) for d, share in zip(deviance, residual / power)]


def _is_large(reading: RobotReading) -> bool:
    """Return whether a reading is a convention and no small effect."""
    return all(c.reversed or c.unit != 1.0 or c.effort < 0.0 or abs(c.zero) >= SETTINGS.zero_shown
               or LIMITS.factor <= max(c.effort, 1.0 / c.effort) <= max(_factors()) ** 2
               for c in reading.joints.values())  # beyond them a fit ignores the effort


def _is_exact(reading: RobotReading) -> bool:
    """Return whether a reading has no free value."""
    return all(c.zero == 0.0 and abs(c.effort) == 1.0 for c in reading.joints.values())


def _factors() -> list[float]:
    """Return the factors of an effort that are tried: of other units, currents above all."""
    powers = 10.0 ** np.arange(-2.5, 2.51, 0.5)
    return [float(x) for x in powers if abs(math.log(x)) > math.log(LIMITS.factor)]


def thinned(log: RobotLog) -> RobotMotion:
    """Return the motion of a log, or of pieces of a long one, at a lower rate."""
    motion = motion_of(excerpt(log))
    every = max(1, round(1.0 / motion.step / LIMITS.rate))
    rows, sections, begin = [], [], 0
    for section in motion.sections:
        count = (section.stop - section.start) // every
        rows.append(section.start + every * np.arange(count))
        sections.append(slice(begin, begin + count))
        begin += count
    at = np.concatenate(rows)
    weights = np.ones(every) / every
    given = np.column_stack([np.convolve(x, weights, 'same') for x in motion.input.T])
    return replace(motion, t=motion.t[at], q=motion.q[at], v=motion.v[at], input=given[at],
                   input_speed=motion.input_speed[at], step=motion.step * every,
                   sections=tuple(sections))
