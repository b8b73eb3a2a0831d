# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.


"""A drive, the values that its diagnosis is told, and a motion: all of a recording but effects."""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.benchmarks.blind import draw, motions, plant, stress

DT = 1e-3
MAX_TRAVEL = 60.0  # rad


@dataclass(frozen=True)
class Scene:
    """
    What moves, and how.

    told, truth: nominal values; scatter: tolerance of those told; ids: of the effects to come;
    motion: (u, control, reference); torque: standard deviation of its noise, N m; seeds: of that
    noise and of the encoders'.
    """

    told: dict
    truth: dict
    scatter: float
    ids: list
    motion: tuple
    torque: float
    seeds: list

    def run(self, effects):
        """Return (x [N, 4], y [N, 2], u [N], whether it stays within MAX_TRAVEL)."""
        u, control, reference = self.motion
        with np.errstate(all='ignore'):
            x, y, u = plant.simulate(self.truth, effects, u, DT, torque_std=self.torque,
                                     rng=np.random.default_rng(self.seeds[0]), control=control,
                                     reference=reference)
        return x, y, u, np.isfinite(x).all() and np.abs(x[:, :2]).max() < MAX_TRAVEL


def drawn(ids, kind, random, scatter, torque):
    """Return a Scene for effects `ids` with a motion of `kind`, 10 to 14 s."""
    told = draw.nominal(random)
    truth = dict(told)
    replaced = {draw.REPLACES[i] for i in ids if i in draw.REPLACES}
    for name in stress.SCATTERED if scatter else ():
        shift = scatter * float(np.clip(random.standard_normal(), -3, 3))
        if name not in replaced:  # its change is the effect
            truth[name] *= 1.0 + shift
    n = int(float(random.uniform(10.0, 14.0)) / DT)
    motion = motions.draw(kind, random, n, DT)
    seeds = [int(s) for s in random.integers(2 ** 31, size=2)]
    return Scene(told, truth, scatter, ids, motion, torque, seeds)


def moves(x, gap):
    """Return whether the drive moves, and both flanks of the gap carry load several times."""
    twist = x[:, 0] - x[:, 1]
    side = np.sign(twist) * (np.abs(twist) > gap)
    side = side[side != 0]
    return x[:, 1].std() > 0.1 and len(side) > 500 and np.sum(np.diff(side) != 0) >= 6
