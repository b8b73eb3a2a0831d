# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""An arm at work as a stream of joint states: its equations, and friction that no file knows."""
import numpy as np
from scipy.interpolate import CubicSpline

from gearbox_monitor.robot.chain import chain_of, inertial
from gearbox_monitor.robot.description import parse
from gearbox_monitor.watch.fold import step
from gearbox_monitor.watch.record import Cutter, SECOND

AXES, LENGTH, MASS = ('0 0 1', '0 1 0', '0 1 0'), (0.15, 0.4, 0.35), (8.0, 6.0, 3.0)
NAMES = ['joint1', 'joint2', 'joint3']
BLOCK, RATE, START = 20, 100, 1_700_000_000 * SECOND
DRY, WET = np.array([4.0, 6.0, 3.0]), np.array([3.0, 4.0, 2.0])
AT, PLACE = np.array([0.0, 0.02, 0.3]), np.array([0.05, 0.0, 0.8 * LENGTH[1]])


def urdf(masses=MASS):
    text = '<robot name="arm"><link name="base"/>'
    for k, (axis, length, mass) in enumerate(zip(AXES, LENGTH, masses)):
        side = mass * length ** 2 / 12.0 + 0.01
        text += (
            f'<link name="link{k + 1}"><inertial><origin xyz="0.01 0 {length / 2}"/>'
            f'<mass value="{mass}"/><inertia ixx="{side}" iyy="{side}" izz="0.01" ixy="0" ixz="0" '
            f'iyz="0"/></inertial></link><joint name="{NAMES[k]}" type="revolute"><parent '
            f'link="{f"link{k}" if k else "base"}"/><child link="link{k + 1}"/><origin '
            f'xyz="0 0 {LENGTH[k - 1] if k else 0.2}"/><axis xyz="{axis}"/><limit lower="-2.9" '
            'upper="2.9" effort="300" velocity="4"/></joint>')
    return text + '</robot>'


class Arm:
    """
    An arm that moves between postures; its load (kg), friction and gains may change.

    added: kg at PLACE of link 2; rotor: kg m^2 at each joint.
    """

    def __init__(self, seed=3):
        text = urdf([m * x for m, x in zip(MASS, (1.05, 0.96, 1.03))])
        self.chain = chain_of(parse(text, 'arm', {}))
        self.rng = np.random.default_rng(seed)
        self.load, self.friction, self.gain, self.still = 0.0, np.ones(3), np.ones(3), ()
        self.added, self.rotor = 0.0, np.zeros(3)
        self.goals, self.noise, self.number = self.rng.uniform(-1.0, 1.0, (5, 3)), 0.1, 0
        self.at = np.zeros(3)

    def block(self):
        """Return the messages of the next 20 s."""
        t = (np.arange(BLOCK * RATE) + 0.5) / RATE
        knots = np.arange(0.0, BLOCK + 1.0, 2.0)
        goals = self.goals[self.rng.integers(5, size=len(knots))]
        goals += self.rng.normal(0.0, 0.2, goals.shape)
        goals[:, list(self.still)] = self.at[list(self.still)]
        goals[0], self.at = self.at, goals[-1]
        curve = CubicSpline(knots, goals, bc_type='clamped')
        q, v, theta = curve(t), curve(t, 1), self.chain.theta.copy()
        theta[-1] += inertial(self.load, AT, np.zeros((3, 3))) if self.load else 0.0
        theta[1] += inertial(self.added, PLACE, np.zeros((3, 3)))
        momentum, effort = np.zeros_like(q), np.zeros_like(q)
        for r in self.chain.regressors(q, v):
            momentum[:, r.joint] += r.p @ theta[r.link]
            effort[:, r.joint] += (r.g - r.k) @ theta[r.link]
        effort += CubicSpline(t, momentum + self.rotor * v)(t, 1)
        effort += self.friction * (DRY * np.tanh(v / 0.01) + WET * v)
        effort = self.gain * effort + self.rng.normal(0.0, self.noise, q.shape)
        stamps = START + self.number * BLOCK * SECOND + np.round(t * SECOND).astype(np.int64)
        q = q + self.rng.normal(0.0, 2e-5, q.shape)
        self.number += 1
        return list(zip(stamps.tolist(), q, v, effort))


def messages(arm, blocks):
    return [m for _ in range(blocks) for m in arm.block()]


def watched(watch, stream, cutter=None):
    """Return the watch after messages, and what happened."""
    cutter, events = cutter or Cutter(), []
    for stamp, q, v, effort in stream:
        for block in cutter.take(stamp, NAMES, q, v, effort):
            watch, happened = step(watch, block)
            events += happened
    for block in cutter.end():
        watch, happened = step(watch, block)
        events += happened
    return watch, events
