# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A robot's balance of momentum, linear in the inertial parameters of its links.

The equation of motion of joint j, in a form in which no acceleration occurs:

    effort_j = d/dt p_j - k_j + g_j,   p_j = dT/dv_j,  k_j = dT/dq_j,  g_j = dU/dq_j

Kinetic energy T and potential energy U are linear in ten numbers of each link, theta = (m, m c,
Ixx, Iyy, Izz, Ixy, Ixz, Iyz) at the origin of its frame. So p, k and g are regressors times theta
(Gautier and Khalil, 1988). All samples of a recording are computed at once.
"""
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.description import (
    RobotDescription, rotations)
from gearbox_monitor.robot.dynamics import GRAVITY

PER_LINK = 10
OFF_DIAGONAL = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True, eq=False)
class Link:
    """
    A joint and all that is fixed to what it moves.

    name: of the body; joint: of the joint that moves it; parent: index of the link that carries
    it, -1 the base. rotation [3, 3], origin [3] m: the joint's frame in that of the parent at
    position 0; axis [3]: unit vector in it; slides: prismatic. theta [10]: inertial parameters.
    """

    name: str
    joint: str
    parent: int
    rotation: Array
    origin: Array
    axis: Array
    slides: bool
    theta: Array

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return float(self.theta[0])

    @property
    def reach(self) -> float:
        """Distance of the centre of mass from the joint's frame, m."""
        return float(np.linalg.norm(self.theta[1:4])) / self.mass if self.mass > 0.0 else 0.0


class Regressor(NamedTuple):
    """What link `link` gives to joint `joint`: momentum p, dT/dq k and weight g, each [N, 10]."""

    link: int
    joint: int
    p: Array
    k: Array
    g: Array


@dataclass(frozen=True, eq=False)
class Chain:
    """
    A robot on a fixed base, one link per joint, a parent before its children.

    armature [J] kg m^2, viscous [J] N m s/rad, coulomb [J] N m: of the joints, from the file.
    gravity [3]: m/s^2. zero [J]: position in which the links' frames are as they say. spring [J]
    N m/rad, relaxed at spring_zero [J].
    """

    links: tuple[Link, ...]
    armature: Array
    viscous: Array
    coulomb: Array
    gravity: Array
    zero: Array = field(default_factory=lambda: np.zeros(1))
    spring: Array = field(default_factory=lambda: np.zeros(1))
    spring_zero: Array = field(default_factory=lambda: np.zeros(1))

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(link.joint for link in self.links)

    @property
    def serial(self) -> bool:
        """Whether each link carries the next one, without branches."""
        return [link.parent for link in self.links] == list(range(-1, len(self.links) - 1))

    @property
    def theta(self) -> Array:
        """Inertial parameters [J, 10]."""
        return np.array([link.theta for link in self.links])

    @property
    def tips(self) -> tuple[int, ...]:
        """Numbers of the links that carry no other one."""
        parents = {link.parent for link in self.links}
        return tuple(k for k in range(len(self.links)) if k not in parents)

    @cached_property
    def movers(self) -> tuple[tuple[int, ...], ...]:
        """Of each link the joints that move it, from the base outwards."""
        rows: list[tuple[int, ...]] = []
        for index, link in enumerate(self.links):
            rows.append((*(rows[link.parent] if link.parent >= 0 else ()), index))
        return tuple(rows)

    def extent(self, link: int) -> float:
        """Return how far `link` and all behind it reach from its frame, m: bars of even mass."""
        return max([2.0 * self.links[link].reach, *(
            float(np.linalg.norm(own.origin)) + self.extent(k)
            for k, own in enumerate(self.links) if own.parent == link)])

    def moved_by(self, joint: int) -> list[int]:
        """Return the links that `joint` moves."""
        return [link for link, movers in enumerate(self.movers) if joint in movers]

    def regressors(self, q: Array, v: Array, gravity: Array | None = None,
                   links: Collection[int] | None = None) -> Iterator[Regressor]:
        """
        Yield the Regressor of every link and joint that moves it.

        Args:
            q: positions [N, J], rad or m.
            v: speeds [N, J].
            gravity: [3] m/s^2, None for that of the chain.
            links: those that are wanted, None for all.
        """
        gravity = self.gravity if gravity is None else gravity
        turns, places, axes, anchors = self.poses(q)
        for index, movers in enumerate(self.movers):
            if links is not None and index not in links:
                continue
            turn = turns[index]
            down = _into(turn, np.broadcast_to(gravity, (len(q), 3)))
            columns = []
            for joint in movers:
                axis = axes[joint]
                if self.links[joint].slides:
                    columns.append((np.zeros_like(axis), _into(turn, axis)))
                else:
                    arm = _cross(axis, places[index] - anchors[joint])
                    columns.append((_into(turn, axis), _into(turn, arm)))
            steps = [(w * v[:, j, None], s * v[:, j, None]) for j, (w, s) in zip(movers, columns)]
            spin = np.sum([step[0] for step in steps], axis=0)
            speed = np.sum([step[1] for step in steps], axis=0)
            spin_up, speed_up = np.zeros_like(down), np.zeros_like(down)
            for joint, (w, s), step in zip(movers, columns, steps):
                # Twist of the joint's link, seen from this link's frame: dV/dq_j = -ad(J_j) V_j.
                spin_up, speed_up = spin_up + step[0], speed_up + step[1]
                turned = -_cross(w, spin_up)
                moved = -_cross(w, speed_up) - _cross(s, spin_up)
                weight = np.zeros((len(q), PER_LINK))
                weight[:, 0] = -np.einsum('ni,ni->n', down, s)
                weight[:, 1:4] = -_cross(down, w)
                yield Regressor(index, joint, _kinetic(w, s, spin, speed),
                                _kinetic(turned, moved, spin, speed), weight)

    def inertia(self, q: Array) -> Array:
        """Return the matrices [N, J, J] of inertia at the positions `q` [N, J] (rad or m)."""
        out = np.zeros((len(q), *(len(self.links),) * 2)) + np.diag(self.armature)
        for k, unit in enumerate(np.eye(len(self.links))):
            for r in self.regressors(q, np.broadcast_to(unit, q.shape)):
                out[:, r.joint, k] += r.p @ self.theta[r.link]
        return out

    def weight_slopes(self, q: Array) -> Array:
        """
        Return the slopes [N, J, J] of the weights at the joints by the positions, N m/rad.

        A turn of a joint turns gravity against all that it moves; slopes are symmetric.

        Args:
            q: positions [N, J], rad or m.
        """
        axes, pulls = self._pulls(q)
        count = len(self.links)
        out = np.zeros((len(q), count, count))
        for k, movers in enumerate(self.movers):
            for j in movers:
                if not self.links[j].slides:
                    turned = _cross(np.broadcast_to(self.gravity, axes[j].shape), axes[j])
                    out[:, k, j] = out[:, j, k] = -np.einsum('ni,ni->n', turned, pulls[k])
        return out

    def weights(self, q: Array) -> Array:
        """
        Return the torques [N, J, 3] at the joints by a gravity of 1 m/s^2 along each axis.

        Args:
            q: positions [N, J], rad or m.
        """
        return -np.stack(self._pulls(q)[1], axis=1)

    def _pulls(self, q: Array) -> tuple[list[Array], list[Array]]:
        """Return axes [N, 3], and what gravity is multiplied by to pull each joint back."""
        turns, places, axes, anchors = self.poses(q)
        count, theta = len(self.links), self.theta
        masses = [float(mass) for mass in theta[:, 0]]
        moments = [mass * place + turn @ own
                   for mass, place, turn, own in zip(masses, places, turns, theta[:, 1:4])]
        for index in reversed(range(count)):
            parent = self.links[index].parent
            if parent >= 0:
                masses[parent] += masses[index]
                moments[parent] = moments[parent] + moments[index]
        return axes, [masses[k] * axes[k] if link.slides else
                      _cross(axes[k], moments[k] - masses[k] * anchors[k])
                      for k, link in enumerate(self.links)]

    def poses(self, q: Array) -> tuple[list[Array], list[Array], list[Array], list[Array]]:
        """
        Return rotation, origin, axis and anchor of each link in the base's frame.

        Args:
            q: positions [N, J], rad or m.
        """
        q = q - self.zero
        turns: list[Array] = []
        places: list[Array] = []
        axes: list[Array] = []
        anchors: list[Array] = []
        for index, link in enumerate(self.links):
            base = turns[link.parent] if link.parent >= 0 else np.broadcast_to(
                np.eye(3), (len(q), 3, 3))
            at = places[link.parent] if link.parent >= 0 else np.zeros((len(q), 3))
            turn, place = base @ link.rotation, at + base @ link.origin
            axes.append(turn @ link.axis)
            anchors.append(place)
            if link.slides:
                place = place + axes[-1] * q[:, index, None]
            else:
                turn = turn @ rotations(link.axis, q[:, index])
            turns.append(turn)
            places.append(place)
        return turns, places, axes, anchors


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products [N, 3] of `a` and `b` [N, 3], with the bits of numpy.cross."""
    out = np.empty(a.shape)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(a[:, j] * b[:, k], a[:, k] * b[:, j], out=out[:, i])
    return out


def _into(turn: Array, x: Array) -> Array:
    """Return vectors of the base `x` [N, 3] in the frames `turn` [N, 3, 3]."""
    return np.einsum('nji,nj->ni', turn, x)


def _kinetic(w1: Array, v1: Array, w2: Array, v2: Array) -> Array:
    """Return d(kinetic energy)/d(theta) [N, 10] as a bilinear form of two twists."""
    out = np.empty((len(w1), PER_LINK))
    out[:, 0] = np.einsum('ni,ni->n', v1, v2)
    out[:, 1:4] = _cross(v1, w2) + _cross(v2, w1)
    for i in range(3):
        out[:, 4 + i] = w1[:, i] * w2[:, i]
    for column, (i, j) in enumerate(OFF_DIAGONAL, 7):
        out[:, column] = w1[:, i] * w2[:, j] + w1[:, j] * w2[:, i]
    return out


def inertial(mass: float, com: Array, inertia: Array) -> Array:
    """
    Return theta [10] of a body.

    Args:
        mass: kg.
        com: centre of mass [3] in the link's frame, m.
        inertia: [3, 3] about the centre, along the link's axes, kg m^2.
    """
    at = inertia + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return np.array([mass, *(mass * com), at[0, 0], at[1, 1], at[2, 2],
                     *(at[i, j] for i, j in OFF_DIAGONAL)])


def pseudo_inertia(theta: Array) -> Array:
    """Return the pseudo-inertia [4, 4] of `theta` [10]: of a body it is positive definite."""
    at = np.diag(theta[4:7])
    for value, (i, j) in zip(theta[7:], OFF_DIAGONAL):
        at[i, j] = at[j, i] = value
    out = np.empty((4, 4))
    out[:3, :3] = 0.5 * np.trace(at) * np.eye(3) - at
    out[:3, 3] = out[3, :3] = theta[1:4]
    out[3, 3] = theta[0]
    return out


def level_frame(gravity: Array) -> Array:
    """Return two level axes and the one up [3, 3], as rows, for `gravity` [3] in any frame."""
    size = float(np.linalg.norm(gravity))
    up = -gravity / size if size > 0.0 else np.eye(3)[2]
    level = np.eye(3)[int(abs(up[0]) > 0.9)]
    first = level - (level @ up) * up
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(up, first), up])


def body_of(theta: Array) -> tuple[float, Array, Array]:
    """Return mass, centre [3] and inertia about it [3, 3] of `theta` [10], with m > 0."""
    mass, com = float(theta[0]), theta[1:4] / theta[0]
    at = np.diag(theta[4:7])
    for value, (i, j) in zip(theta[7:], OFF_DIAGONAL):
        at[i, j] = at[j, i] = value
    return mass, com, at - mass * (com @ com * np.eye(3) - np.outer(com, com))


def chain_of(description: RobotDescription) -> Chain:
    """Return the Chain of a `description` that is parsed as a whole."""
    order = [int(i) for i in description.source]     # row of the tree -> joint
    names: dict[int, str] = {}
    for name, (row, _, _) in description.links.items():
        names.setdefault(row, name)
    links = []
    for row, joint in enumerate(order):
        own = [i for i, of in enumerate(description.body_joint) if of == row]
        theta = sum((inertial(float(description.mass[i]), description.com[i],
                              description.inertia[i]) for i in own), np.zeros(PER_LINK))
        links.append(Link(names[row], description.joints[joint], int(description.parent[row]),
                          description.rotation[row], description.origin[row],
                          description.axis[row], bool(description.prismatic[row]), theta))
    viscous, coulomb = description.losses.T
    return Chain(tuple(links), np.zeros(len(links)), viscous, coulomb, np.array(GRAVITY))
