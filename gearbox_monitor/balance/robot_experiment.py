# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Experiment design for a robot: the motion in which the smallest visible effects are smallest.

A motion is a sum of sines of each joint about a posture, begun and ended at rest, as large as
position and speed allow, and smaller until torques and contacts do (Swevers et al., 1997, with
free frequencies). Its torque by the model, with noise, is a recording in which nothing is wrong:
what would have been a finding there is what the diagnosis says of a real one (`visible`). Where a
joint creeps, its friction is part of the noise: small torques of slow motion seem to show much,
but the joint sticks. To tell an effect from a rival, the rival has free coefficients beside it
(the D_s criterion). Random motions are drawn first, then parts of the best ones are changed.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.balance.candidates import Candidate, library
from gearbox_monitor.balance.contest import ContestScales, scales_of
from gearbox_monitor.balance.evidence import RobotEvidence, RobotFit
from gearbox_monitor.balance.knowledge import another_day
from gearbox_monitor.balance.local_cosines import local_cosines
from gearbox_monitor.balance.motion import RobotMotion
from gearbox_monitor.balance.robot_effects import PAYLOAD
from gearbox_monitor.balance.rows import RobotModel, tested
from gearbox_monitor.balance.settings import SETTINGS
from gearbox_monitor.balance.verdict import smallest_visible, visible_size
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.robot.chain import Chain

RATE = 50.0                # Hz, of the motion and of its rows
SINES, SLOWEST, FASTEST = 4, 0.05, 1.0  # of a joint; Hz
RAMP = 1.0                 # s, over which a motion begins and ends
DRAWN, CHANGED, BEST = 60, 240, 6  # random motions, changes, motions that are changed
ALLOWED = 0.95             # of a limit: a controller overshoots
SHRINK, TRIALS = 0.8, 10   # a motion that needs too much, or touches, is made smaller
TORQUE_NOISE = 0.01        # of the rms torque of random motions
ENCODER_NOISE = 2e-4       # rad, m
CUT_OFF = 15.0             # Hz, of the smoother of a recording
RIPPLE, ORDER = 0.1, 11.0  # of the friction over the angle, which no law has; per rad
FRICTION = 0.1             # of the rms torque, where the file states less
UNSEEN = 1e6               # size of what a motion does not show
Visible: TypeAlias = Mapping[str, Mapping[str, float]]  # {effect: {place: size}}
Target: TypeAlias = tuple[str, str | None]  # effect and its rival


@dataclass(frozen=True, eq=False)
class RobotLimits:
    """Of each joint [J]: low, high rad or m; speed rad/s or m/s; torque N m or N, either way."""

    low: Array
    high: Array
    speed: Array
    torque: Array


@dataclass(frozen=True, eq=False)
class RobotMotionDesign:
    """
    A motion, and what it would show.

    t [N] s; q, v, a [N, J] rad, rad/s, rad/s^2 (m); torque [N, J] by the model, N m (N).
    goals {(effect, place, rival or ''): smallest size that would be a finding}; usual: the same in
    random motions of the same length within the same limits, median. visible: of all effects.
    gain: geometric mean of usual over goals.
    """

    t: Array
    q: Array
    v: Array
    a: Array
    torque: Array
    goals: Mapping[tuple[str, str, str], float]
    usual: Mapping[tuple[str, str, str], float]
    visible: Visible

    @property
    def gain(self) -> float:
        """By how much smaller an effect is seen than in a random motion."""
        return math.exp(float(np.mean([math.log(self.usual[k] / v)
                                       for k, v in self.goals.items()])))


@dataclass(frozen=True, eq=False)
class _Sines:
    """middle, share [J] of the allowed range and size; size, rate (Hz), phase [J, K] of sines."""

    middle: Array
    share: Array
    size: Array
    rate: Array
    phase: Array

    @staticmethod
    def drawn(random: np.random.Generator, joints: int) -> '_Sines':
        """Return random sines of `joints`."""
        k = (joints, SINES)
        rate = np.exp(random.uniform(math.log(SLOWEST), math.log(FASTEST), k))
        return _Sines(random.uniform(0.2, 0.8, joints), random.uniform(0.5, 1.0, joints),
                      random.uniform(0.3, 1.0, k) / (1.0 + 4.0 * rate), rate,
                      random.uniform(0.0, 2.0 * math.pi, k))

    def changed(self, random: np.random.Generator, spread: float) -> '_Sines':
        """Return sines of which some joints are changed by `spread`."""
        joints, k = len(self.middle), self.size.shape
        picked: Flags = random.uniform(size=joints) < max(0.35, 1.0 / joints)
        picked[random.integers(joints)] = True
        on, each = picked * spread, picked[:, None] * spread
        return _Sines(
            np.clip(self.middle + 0.3 * on * random.standard_normal(joints), 0.05, 0.95),
            np.clip(self.share + 0.3 * on * random.standard_normal(joints), 0.1, 1.0),
            self.size * np.exp(each * random.standard_normal(k)),
            np.clip(self.rate * np.exp(each * random.standard_normal(k)), SLOWEST, FASTEST),
            self.phase + 2.0 * each * random.standard_normal(k))

    def path(self, t: Array, limits: RobotLimits) -> tuple[Array, Array]:
        """
        Return the posture [J] and the way from it [N, J], as large as the limits allow.

        Args:
            t: times [N], s.
            limits: of position and speed.
        """
        s = np.clip(np.minimum(t, t[-1] - t) / RAMP, 0.0, 1.0)
        bell = s ** 3 * (10.0 - 15.0 * s + 6.0 * s ** 2)
        waves = np.sin(2.0 * math.pi * self.rate[:, :, None] * t + self.phase[:, :, None])
        way = bell[:, None] * np.einsum('jk,jkn->nj', self.size, waves)
        middle = limits.low + self.middle * (limits.high - limits.low)
        room = np.minimum((limits.high - middle) / np.maximum(way.max(axis=0), 1e-9),
                          (middle - limits.low) / np.maximum(-way.min(axis=0), 1e-9))
        fast = limits.speed / np.maximum(np.abs(np.gradient(way, t, axis=0)).max(axis=0), 1e-9)
        return middle, way * self.share * np.minimum(room, fast)


class _Experiment:
    """The robot, its limits and what a motion must show."""

    def __init__(self, robot: RobotModel, limits: RobotLimits, targets: Sequence[Target],
                 link: str, seconds: float, touches: Callable[[Array], bool]) -> None:
        self.robot, self.targets, self.link, self.touches = robot, targets, link, touches
        edge = 0.5 * (1.0 - ALLOWED) * (limits.high - limits.low)
        self.limits = RobotLimits(limits.low + edge, limits.high - edge, ALLOWED * limits.speed,
                                  ALLOWED * limits.torque)
        self.t = np.arange(round(seconds * RATE) + 1) / RATE
        joints = len(robot.chain.links)
        self.noise = np.random.default_rng(0).standard_normal((len(self.t), joints))
        self.size: Array = np.ones(joints)
        sigma = np.full(joints, ENCODER_NOISE)
        self.sigma = sigma, sigma * math.sqrt(2.0 / RATE * (2.0 * math.pi) ** 2 * CUT_OFF ** 3
                                              / 3.0)

    def motion(self, sines: _Sines) -> tuple[Array, Array, Array, Array] | None:
        """Return q, v, a and torque [N, J] of a motion within all limits, None without one."""
        middle, way = sines.path(self.t, self.limits)
        factor = 1.0
        for _ in range(TRIALS):
            q = middle + factor * way
            v = np.gradient(q, self.t, axis=0)
            torque = model_torque(self.robot.chain, self.t, q, v)
            if (np.abs(torque) <= self.limits.torque).all() and not self.touches(q):
                a = np.gradient(v, self.t, axis=0)
                v[[0, -1]] = a[[0, -1]] = 0.0  # differences at the ends are one-sided
                return q, v, a, torque
            factor *= SHRINK
        return None

    def seen(self, q: Array, v: Array, torque: Array) -> dict[tuple[str, str, str], float]:
        """Return the smallest size of each target that a motion shows, of those below UNSEEN."""
        evidence, fit = self._evidence(q, v, torque)
        ids = list(dict.fromkeys(i for target in self.targets for i in target if i))
        laws = library(evidence.recordings, ids)
        scales = scales_of(laws, (), None, evidence.joints)
        out: dict[tuple[str, str, str], float] = {}
        for effect, rival in self.targets:
            for c in laws:
                if c.effect != effect or effect == PAYLOAD.id and c.link != self.link:
                    continue
                rivals = [r for r in laws if r.effect == rival]
                close = [r for r in rivals if r.place == c.place] or rivals
                size = max(self._size(evidence, fit, c, both, scales)
                           for both in [_beside(c, r) for r in close] or [c])
                if size < UNSEEN:
                    key = effect, c.place, rival or ''
                    out[key] = min(out.get(key, UNSEEN), size)
        return out

    def _size(self, evidence: RobotEvidence, fit: RobotFit, c: Candidate, both: Candidate,
              scales: ContestScales) -> float:
        covariance = evidence.estimates(fit, [both])[0].covariance[:c.width, :c.width]
        size = visible_size(evidence, fit, c, covariance, scales)
        return UNSEEN if size is None else size

    def visible(self, q: Array, v: Array, torque: Array) -> Visible:
        """Return the smallest visible size of all effects at all places."""
        evidence, fit = self._evidence(q, v, torque)
        laws = library(evidence.recordings)
        return smallest_visible(evidence, fit, laws,
                                scales_of(laws, (), None, evidence.joints))

    def _evidence(self, q: Array, v: Array, torque: Array) -> tuple[RobotEvidence, RobotFit]:
        """Return the evidence of a recording of a motion in which nothing is wrong, and a fit."""
        friction = np.maximum(self.robot.chain.coulomb, FRICTION * self.size)
        sticking = np.exp(-(v / SETTINGS.creep) ** 2)  # with any torque up to its friction
        effort = (torque + (TORQUE_NOISE * self.size + sticking * friction) * self.noise
                  + RIPPLE * friction * np.sin(ORDER * q))
        motion = RobotMotion(self.t, q, v, effort, np.zeros_like(v), self.sigma[1], self.sigma[0],
                             1.0 / RATE, (slice(0, len(self.t)),))
        rows = tested(motion, local_cosines(motion, SETTINGS.highest_share * RATE),
                      self.robot)
        recordings = [replace(rows, rate=RATE)]
        reference = RobotEvidence(recordings)
        fit = reference.fit()
        prior = another_day(reference, fit, np.ones(reference.joints))
        evidence = RobotEvidence(recordings, prior)
        return evidence, evidence.fit()


def model_torque(chain: Chain, t: Array, q: Array, v: Array) -> Array:
    """
    Return the torque [N, J] that a motion needs by the file, N m (N).

    Args:
        chain: of the robot.
        t: times [N], s.
        q: positions [N, J], rad (m).
        v: speeds [N, J], rad/s (m/s).
    """
    momentum, out = chain.armature * v, chain.viscous * v + chain.spring * (
        q - chain.spring_zero) + chain.coulomb * np.tanh(v / SETTINGS.slow)
    for r in chain.regressors(q, v):
        theta = chain.links[r.link].theta
        momentum[:, r.joint] += r.p @ theta
        out[:, r.joint] += (r.g - r.k) @ theta
    return np.asarray(out + np.gradient(momentum, t, axis=0))


def _beside(c: Candidate, rival: Candidate) -> Candidate:
    """Return a candidate with the columns of `c`, then those of a `rival`."""
    rows = len(next(iter(c.columns.values())))

    def of(x: Candidate, joint: int) -> Array:
        return x.columns.get(joint, np.zeros((rows, x.width)))
    return replace(c, columns={j: np.hstack([of(c, j), of(rival, j)])
                               for j in sorted({*c.columns, *rival.columns})})


def design(robot: RobotModel, limits: RobotLimits, targets: Sequence[Target], link: str,
           seconds: float, touches: Callable[[Array], bool] = lambda q: False, *,
           progress: Callable[[int, int], object] = lambda done, total: None
           ) -> RobotMotionDesign:
    """
    Return the motion that shows the targets at the smallest size.

    Args:
        robot: its model.
        limits: of its joints.
        targets: (effect, None): seen at all; (effect, rival): beside a rival free at its place.
        link: that a payload is at.
        seconds: length of the motion.
        touches: whether a path [N, J] collides.
        progress: called with (done, total).

    Raises:
        InputError: no random motion of this robot shows an effect.
        Undecided: no motion was within the limits.
    """
    experiment = _Experiment(robot, limits, targets, link, seconds, touches)
    random = np.random.default_rng(0)
    drawn = []
    for k in range(DRAWN):
        sines = _Sines.drawn(random, len(robot.chain.links))
        motion = experiment.motion(sines)
        if motion is not None:
            drawn.append((sines, motion))
        progress(k // 2, DRAWN + CHANGED)
    if not drawn:
        raise Undecided(f'no motion of {DRAWN} stays within the limits of torque and clear of '
                        'contacts, expected wider limits')
    experiment.size = np.median([np.std(m[3], axis=0) for _, m in drawn], axis=0) + 1e-9
    shown_by = [experiment.seen(q, v, torque) for _, (q, v, _, torque) in drawn]
    usual = {key: float(np.median([sizes.get(key, UNSEEN) for sizes in shown_by]))
             for key in dict.fromkeys(key for sizes in shown_by for key in sizes)}
    lacking = dict.fromkeys(effect for effect, _ in targets
                            if all(effect != key[0] for key in usual))
    if lacking:
        raise InputError(f'effects: {", ".join(lacking)}: no motion of this robot shows them in '
                         'a log of torques, expected others')

    def worth(sizes: Mapping[tuple[str, str, str], float]) -> float:
        return -float(np.mean([math.log(sizes.get(key, UNSEEN) / usual[key]) for key in usual]))
    leaders = sorted(((worth(s), sines, motion, s) for (sines, motion), s in zip(drawn, shown_by)),
                  key=lambda row: -row[0])[:BEST]
    for k in range(CHANGED):
        spread = 1.0 - 0.8 * k / CHANGED
        sines = leaders[k % len(leaders) if k < CHANGED // 2 else 0][1].changed(random, spread)
        motion = experiment.motion(sines)
        if motion is not None:
            q, v, _, torque = motion
            sizes = experiment.seen(q, v, torque)
            leaders = sorted([*leaders, (worth(sizes), sines, motion, sizes)],
                          key=lambda row: -row[0])[:BEST]
        progress(DRAWN + k, DRAWN + CHANGED)
    _, _, (q, v, a, torque), sizes = leaders[0]
    return RobotMotionDesign(experiment.t, q, v, a, torque,
                             {key: sizes.get(key, UNSEEN) for key in usual}, usual,
                             experiment.visible(q, v, torque))
