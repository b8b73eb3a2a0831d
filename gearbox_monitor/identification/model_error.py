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

"""
What no model of a real drive explains, where the motor's motion drives the model: it lasts.

Friction varies with the position, gears are not round: torque and twist that are left last some
tenths of a second. A reading then tells little beyond the one before it. So residuals count in the
size of what lasts, once for each `process_torque_time`.

search: Search; data: fit.Data; recording: Recording.
"""
from collections.abc import Sequence
import copy
from dataclasses import dataclass, replace
import math
from typing import TYPE_CHECKING

import numpy as np

from gearbox_monitor.identification import fit as fitting
from gearbox_monitor.identification.noise import MAD_TO_SIGMA
from gearbox_monitor.identification.recording import Recording
from gearbox_monitor.identification.torque_domain import parts
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.prescribed_motion import MOVES

if TYPE_CHECKING:
    from gearbox_monitor.identification.search import Fitted, Search

SHARE = 0.1      # of torque and twist that lasts unexplained, until a fit tells
LEAST = 0.02     # of torque and twist that it is never below
SLOW = 0.04      # s: what is left of means over so long lasts, the rest is noise


def scales(recording: Recording) -> Array:
    """Return the standard deviations [2] of torque (N m) and twist (rad) of a driven Recording."""
    positions = recording.positions
    twist = positions[:, 0] - positions[:, 1]
    size = math.sqrt(np.mean([np.var(twist[part]) for part in parts(recording)]))
    return np.maximum([float(np.std(recording.u)), size], 1e-12)


@dataclass(frozen=True)
class Weighing:
    """
    How residuals count: sizes [2] N m and rad of what is left, shares [2] that a reading counts.

    robust: those that are larger count by their size, not by its square. A gap that is crossed
    some milliseconds late is no matter of the twist before and after it.
    """

    sizes: Array
    shares: Array
    robust: bool = True

    def __call__(self, residual: Array, data: fitting.Data) -> Array:
        """Return `residual` [W, L, C] in standard deviations of the noise as it counts."""
        r = residual * (data.sigma / self.sizes)[data.channels]
        shares = self.shares[data.channels]
        if not self.robust:
            return np.sqrt(shares) * r
        return np.copysign(np.sqrt(shares * 2.0 * (np.sqrt(1.0 + r * r) - 1.0)), r)


def weighing(recording: Recording, model: DriveModel, sigma: Array,
             levels: Array | None = None) -> Weighing | None:
    """
    Return the Weighing of a Recording under the DriveModel `model`.

    sigma [2] N m, rad: noise; levels [2]: size of what lasts, by default that before any fit. None
    where nothing lasts or the torque drives.
    """
    if recording.motor is None or model.process_torque_time <= 0.0:
        return None
    if levels is None:
        levels = SHARE * scales(recording)
    lasting = np.maximum(levels, LEAST * scales(recording)) ** 2
    white, share = sigma ** 2, min(1.0, recording.dt / model.process_torque_time)
    # What lasts counts once in its time, white noise at each reading.
    return Weighing(np.sqrt(white + lasting),
                    share * (white + lasting) / (share * white + lasting))


def left_by(data: fitting.Data, residual: Array) -> Array:
    """Return the size [2], N m and rad, of what lasts in a plain `residual` [W, C L]."""
    assert data.recording.motor is not None
    at = data.windows.first[:, None] + np.arange(data.windows.length)
    r = data.parted(residual)[data.train]
    told = np.ones(r.shape, bool)
    told[:, :, 0] = data.recording.motor[at[data.train], MOVES] != 0.0
    width = max(1, round(SLOW / data.recording.dt))
    count = r.shape[1] // width
    r, told = (x[:, :count * width].reshape(len(r), count, width, -1) for x in (r, told))
    mean = (r * told).sum(axis=2) / np.maximum(told.sum(axis=2), 1)
    enough = told.mean(axis=2) > 0.5
    out = np.zeros(2)
    for i, channel in enumerate(data.channels):
        if enough[:, :, i].any():
            # Large ones count in no square: see Weighing.
            typical = np.median(np.abs(mean[:, :, i][enough[:, :, i]]))
            out[channel] = MAD_TO_SIGMA * typical * data.sigma[channel]
    return out


def weigh_anew(search: 'Search', fits: Sequence['Fitted']) -> None:
    """
    Weigh residuals of a Search by what the best of `fits` (Fitted) leaves; score all fits by it.

    One size for all: a model that leaves more has no right to more.
    """
    best = min(fits, key=lambda f: f.score)
    weigh = weighing(search.recording, search.model, search.long.sigma, _left(search, best))
    for data in (search.long, search.short):
        data.weighing = weigh
    for fitted in {id(f): f for f in (*fits, *search.fitted.values())}.values():
        search.long.evaluate(fitted.candidate, fitted.point)
        fitted.score = search.score(search.long, fitted.candidate, fitted.point)
    search.short.evaluate(search.starts.none(), search.short_none)


def measure(search: 'Search', names: Sequence[str]) -> None:
    """Weigh residuals by what the best of `names` leaves; fit these and none again."""
    weigh_anew(search, [search.fitted[n] for n in names] or [search.fitted['']])
    names = list(dict.fromkeys(['', *names, *search.ranked()[:len(names)]]))
    search.cross(names)
    for name in names:
        fitted = search.fitted[name]
        fitted.left, fitted.white = _left(search, fitted), fitted.point.residual
        fitted.s = float(fitted.left[0])


def _left(search: 'Search', fitted: 'Fitted') -> Array:
    plain, point = search.long.plain(), fitted.point
    model = fitted.candidate.model(point.z)
    return left_by(plain, plain.residual(model, point.states, point.memory)[0])


def plain(search: 'Search') -> 'Search':
    """Return `search` with residuals in standard deviations of the noise, as they are reported."""
    if search.long.weighing is None and search.long.colour is None:
        return search
    out = copy.copy(search)
    out.long, out.short = search.long.uncoloured(), search.short.uncoloured()
    out.fitted = {
        name: replace(f, point=out.long.evaluate(f.candidate, fitting.copied(f.point)), white=None)
        for name, f in search.fitted.items()}
    return out
