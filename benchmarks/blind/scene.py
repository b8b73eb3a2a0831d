# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""A drive, its nominal values and a motion: everything about a recording except effects."""
from dataclasses import dataclass

import numpy as np

from benchmarks.blind import draw, motions, plant
from benchmarks.blind.plant import DriveMotion, Effects
from gearbox_monitor.kernels.types import Array

DT = 1e-3
PERIOD = round(plant.HELD / DT)  # samples, from setpoint to setpoint and from reading to reading
GAIN_SPREAD = 0.1   # by which the gains of a servo that the diagnosis is given are off at most
MAX_TRAVEL = 60.0  # rad


@dataclass(frozen=True)
class Scene:
    """
    A drive that moves.

    nominal: values that the diagnosis is given; truth: those of the drive; scatter: tolerance of
    the nominal values; ids: of the effects to come; motion: see plant.DriveMotion; torque:
    standard deviation of the process torque, N m; seeds: of that torque and of the encoder noise.
    """

    nominal: dict[str, float]
    truth: dict[str, float]
    scatter: float
    ids: list[str]
    motion: DriveMotion
    torque: float
    seeds: list[int]

    def run(self, effects: Effects) -> tuple[Array, Array, Array, bool]:
        """Return (x [N, 4], y [N, 2], u [N], whether `effects` leave it within MAX_TRAVEL)."""
        push = None if not self.torque else self.torque * np.random.default_rng(
            self.seeds[0]).standard_normal(len(self.motion[0]))
        with np.errstate(all='ignore'):
            x, y, u = plant.simulate_motion(self.truth, effects, self.motion, DT, push)
        return x, y, u, bool(np.isfinite(x).all() and np.abs(x[:, :2]).max() < MAX_TRAVEL)


def drawn(ids: list[str], kind: str, random: np.random.Generator, scatter: float,
          torque: float, driver: str = 'torque', smooth: bool = False) -> Scene:
    """
    Draw a scene of 10 to 14 s, of 20 s with a setpoint.

    Args:
        ids: effects that it is for.
        kind: of the motion, see motions.KINDS.
        random: source of random numbers.
        scatter: relative tolerance of the nominal values.
        torque: standard deviation of the process torque, N m.
        driver: one of plant.INPUTS.
        smooth: whether the drive has no Coulomb friction.
    """
    nominal = draw.nominal(random)
    if smooth:
        nominal['Cc'] = 0.0
    truth = dict(nominal)
    replaced = {draw.REPLACES[i] for i in ids if i in draw.REPLACES}
    for name in draw.SCATTERED if scatter else ():
        shift = scatter * float(np.clip(random.standard_normal(), -3, 3))
        if name not in replaced:  # its change is the effect
            truth[name] *= 1.0 + shift
    if driver == 'setpoint':
        n = round(20.0 / DT)
        gains = (draw.log_uniform(random, 2.0, 10.0), float(random.uniform(0.03, 0.25)))
        for name, value in zip(plant.GAINS, gains):
            truth[name] = value
            shift = 1.0 + GAIN_SPREAD * float(random.uniform(-1.0, 1.0))
            nominal[name] = float(f'{value * shift:.4g}')
        nominal['limit'] = truth['limit'] = motions.LIMIT
        path = motions.setpoint(kind, random, n, DT, PERIOD)
        motion: DriveMotion = (np.zeros(n), (*gains, motions.LIMIT, 0),
                               np.column_stack([path, np.zeros(n)]))
    else:
        n = int(float(random.uniform(10.0, 14.0)) / DT)
        motion = motions.draw(kind, random, n, DT)
    seeds = [int(s) for s in random.integers(2 ** 31, size=2)]
    return Scene(nominal, truth, scatter, ids, motion, torque, seeds)


def moves(x: Array, half_gap: float) -> bool:
    """
    Return whether the drive moves, and both flanks of the backlash carry load several times.

    Args:
        x: states [N, 4].
        half_gap: half width of the backlash, rad.
    """
    twist = x[:, 0] - x[:, 1]
    side = np.sign(twist) * (np.abs(twist) > half_gap)
    side = side[side != 0]
    return bool(x[:, 1].std() > 0.1 and len(side) > 500 and np.sum(np.diff(side) != 0) >= 6)
