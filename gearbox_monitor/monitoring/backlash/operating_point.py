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
Operating points, and what was healthy at each.

A window belongs to the known point whose centre is nearest, if it lies within half a bin of it in
every coordinate; otherwise it founds a new point with itself as the centre. So a drive that works
around one point has one point, not two halves of neighbouring bins.
"""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math
from typing import Any, Self

import numpy as np

from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.monitoring.backlash.features import Backlash, Friction

MAX_POINTS = 64
GAP, OTHERS = 0, (2, 3, 4, 5)  # columns of the features: see watched.FEATURES
MIN_COMPLETE = 60  # windows, before the gap is compared with the others being equal
RIDGE = 2.0  # windows
TINY = 1e-9
_COLUMNS = ('first', 'count', 'total', 'squares', 'stated', 'sum_complete')


@dataclass
class Sums:
    """
    What a baseline holds of each of F features, as sums over its windows.

    first [F]: the value the sums refer to; count, total, squares [F] of value - first; stated [F]:
    mean of the variances the windows state. scale: what changes of features that are not relative
    are divided by. companions [F]: what comes out of the fit beside the gap; used [F]: what of it
    the first window with a gap had, and the gap. complete, sum_complete [F], products [F, F]:
    number, sums and sums of products over the windows that had all of these.
    """

    first: np.ndarray
    count: np.ndarray
    total: np.ndarray
    squares: np.ndarray
    stated: np.ndarray
    scale: float
    companions: np.ndarray
    used: np.ndarray
    complete: float
    sum_complete: np.ndarray
    products: np.ndarray

    @classmethod
    def empty(cls, n: int, scale: float) -> Self:
        """Return the Sums of no window, of `n` features; `scale`: see Sums."""
        companions = np.zeros(n, bool)
        companions[list(OTHERS)] = True
        return cls(np.full(n, np.nan), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), scale,
                   companions, np.zeros(n, bool), 0.0, np.zeros(n), np.zeros((n, n)))

    def refer(self, values: Array) -> None:
        """Let features seen for the first time be referred to `values` [F]."""
        if not self.used.any() and math.isfinite(values[GAP]):
            self.used = np.isfinite(values) & self.companions
            self.used[GAP] = True
        self.first = np.where(np.isnan(self.first), values, self.first)

    def add(self, values: Array, variances: Array, times: int = 1) -> None:
        """
        Add a window to the sums.

        Args:
            values: features [F], NaN if not measured.
            variances: of the values [F].
            times: 1, or -1 to take the window back.

        """
        finite = np.isfinite(values) & np.isfinite(variances)
        x = np.where(finite, values - self.first, 0.0)
        count = self.count + times * finite
        stated = self.stated * self.count + times * np.where(finite, variances, 0.0)
        self.stated = np.where(count > 0, stated / np.maximum(count, 1), 0.0)
        self.count = count
        self.total = self.total + times * x
        self.squares = self.squares + times * x * x
        if self.used.any() and finite[self.used].all():
            x = np.where(self.used, x, 0.0)
            self.complete += times
            self.sum_complete = self.sum_complete + times * x
            self.products = self.products + times * np.outer(x, x)

    def couplings(self) -> Array:
        """
        Return [F]: what to subtract from the gap per unit of the other features.

        All come out of one fit, and their errors go together: where the stiffness came out too
        large, the gap did. Regression of the gap on the others over the windows of the baseline;
        zeros while these are few.
        """
        c = np.zeros(len(self.count))
        active = np.flatnonzero(self.used & self.companions)
        n = self.complete
        if n < MIN_COMPLETE or not len(active):
            return c
        moments = self.products - np.outer(self.sum_complete, self.sum_complete) / n
        normal = moments[np.ix_(active, active)] + RIDGE * np.diag(self.stated[active])
        try:
            c[active] = np.linalg.solve(normal, moments[active, GAP])
        except np.linalg.LinAlgError:
            pass
        return c

    def extended(self) -> tuple[Array, ...]:
        """Return (count, total, squares, stated), each [F+1]: last the gap, the others equal."""
        v = -self.couplings()
        v[GAP] = 1.0
        own = (self.complete if self.complete >= MIN_COMPLETE else 0.0, v @ self.sum_complete,
               v @ self.products @ v, 0.1 * self.stated[GAP])
        return tuple(np.append(a, e) for a, e in zip(
            (self.count, self.total, self.squares, self.stated), own))

    def alone(self, x: Array) -> Array:
        """Return the gap, the others being equal, of rows x [n, F] of deviations from first."""
        c = self.couplings()
        active = c != 0.0
        with np.errstate(invalid='ignore'):
            return x[:, GAP] - x[:, active] @ c[active]

    def mean(self) -> Array:
        """Return the means [F], NaN where nothing is known."""
        with np.errstate(invalid='ignore'):
            return np.where(self.count > 0, self.first + self.total / np.maximum(self.count, 1),
                            np.nan)

    def std(self) -> Array:
        """Return the standard deviation [F] of one window, NaN where nothing is known."""
        n = np.maximum(self.count, 1)
        squares = np.maximum(self.squares - self.total ** 2 / n, 0.0)
        with np.errstate(invalid='ignore'):
            return np.where(self.count > 1, np.sqrt(squares / np.maximum(self.count - 1, 1)),
                            np.sqrt(np.where(self.count > 0, self.stated, np.nan)))

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain data; floats read back exactly."""
        return {
            'scale': self.scale, 'used': [int(v) for v in self.used], 'complete': self.complete,
            'products': [float(v) for v in self.products.ravel()],
            **{name: [float(v) for v in getattr(self, name)] for name in _COLUMNS}}

    @classmethod
    def from_dict(cls, row: Values, features: Sequence[str]) -> Self:
        """Return the Sums of `row`, which to_dict gave; `features`: their names."""
        n = len(features)
        sums = cls.empty(n, float(row['scale']))
        for name in _COLUMNS:
            setattr(sums, name, numbers(row[name], n))
        sums.used = numbers(row['used'], n) > 0.0
        sums.complete = float(row['complete'])
        sums.products = numbers(row['products'], n * n).reshape(n, n)
        return sums

    def described(self, features: Sequence[str]) -> dict[str, Any]:
        """Return mean and deviation by name of `features`, and their products, as plain data."""
        mean, std = self.mean(), self.std()
        row: dict[str, Any] = {'scale': self.scale, 'features': {}}
        if self.complete > 0:
            # How the errors go together: sums of products of deviations from the means.
            off = mean - self.first
            moments = (self.products - np.outer(off, self.sum_complete)
                       - np.outer(self.sum_complete, off) + self.complete * np.outer(off, off))
            sums = self.sum_complete - self.complete * off
            row['together'] = {
                'features': [name for name, used in zip(features, self.used) if used],
                'windows': int(self.complete), 'sums': [float(v) for v in sums[self.used]],
                'products': [float(v) for v in moments[np.ix_(self.used, self.used)].ravel()]}
        for i, name in enumerate(features):
            if self.count[i] > 0:
                row['features'][name] = {
                    'windows': int(self.count[i]), 'mean': float(mean[i]), 'std': float(std[i]),
                    'stated_std': float(math.sqrt(self.stated[i]))}
        return row

    @classmethod
    def from_described(cls, row: Values, features: Sequence[str]) -> Self:
        """
        Return the Sums of a `row` of described(features).

        Raises KeyError, TypeError or ValueError for a row that is none.
        """
        sums = cls.empty(len(features), float(row['scale']))
        for name, feature in row['features'].items():
            i, count = features.index(name), int(feature['windows'])
            sums.first[i], sums.count[i] = feature['mean'], count
            sums.squares[i] = (count - 1) * feature['std'] ** 2
            sums.stated[i] = feature['stated_std'] ** 2
        if 'together' in row:
            block = row['together']
            places = [features.index(name) for name in block['features']]
            sums.used[places] = True
            sums.complete = float(block['windows'])
            sums.sum_complete[places] = numbers(block['sums'], len(places))
            sums.products[np.ix_(places, places)] = numbers(
                block['products'], len(places) ** 2).reshape(len(places), -1)
        return sums


@dataclass
class OperatingPoint:
    """
    An operating point and its baseline.

    angle (rad), speed (rad/s), load (N m), temperature (deg C, None = not measured): its centre.
    """

    angle: float
    speed: float
    load: float
    temperature: float | None
    sums: Sums

    @classmethod
    def at(cls, row: Values, sums: Sums) -> Self:
        """Return the OperatingPoint with `sums` whose centre `row` names, see place."""
        temperature = row['temperature']
        return cls(float(row['angle']), float(row['speed']), float(row['load']),
                   None if temperature is None else float(temperature), sums)

    def place(self) -> dict[str, float | None]:
        """Return the centre as plain data."""
        return {'angle': self.angle, 'speed': self.speed, 'load': self.load,
                'temperature': self.temperature}

    def text(self) -> str:
        """Return the point in words."""
        text = f'{self.angle:.2g} rad, {self.speed:.2g} rad/s, {self.load:.2g} N m'
        return text + ('' if self.temperature is None else f', {self.temperature:.0f} deg C')


class OperatingPoints:
    """All operating points seen, in the order in which they were; n_features: F of Sums."""

    def __init__(self, n_features: int) -> None:
        self.n_features = n_features
        self.points: list[OperatingPoint] = []

    def __getitem__(self, index: int) -> OperatingPoint:
        return self.points[index]

    def __len__(self) -> int:
        return len(self.points)

    def __iter__(self) -> Iterator[OperatingPoint]:
        return iter(self.points)

    def find(self, window: Backlash | Friction, temperature: float | None, bins: Sequence[float],
             create: bool = True) -> int:
        """
        Return the index of the operating point of a window.

        Args:
            window: its features.
            temperature: of the gearbox (deg C), None if unknown.
            bins: widths (angle in rad, speed ratio, load ratio, temperature in K); 0: one bin.
            create: whether to add a point if none is near.

        Returns:
            The index, -1 if no point is near and none was added.

        """
        nearest_index, nearest = -1, 0.5 + TINY
        for index, point in enumerate(self.points):
            offset = distance(point, window, temperature, bins)
            if offset < nearest:
                nearest_index, nearest = index, offset
        if nearest_index < 0 and create and len(self.points) < MAX_POINTS:
            self.points.append(OperatingPoint(
                _number(window.angle), _number(window.speed), _number(window.load), temperature,
                Sums.empty(self.n_features, max(_number(window.load), TINY))))
            nearest_index = len(self.points) - 1
        return nearest_index


def distance(point: OperatingPoint, window: Backlash | Friction, temperature: float | None,
             bins: Sequence[float]) -> float:
    """
    Return how far a window lies from an operating point, in bins: the largest of its coordinates.

    Args:
        point: with its centre.
        window: features of the window.
        temperature: of the gearbox (deg C), None if unknown.
        bins: see OperatingPoints.find.

    Returns:
        The distance; inf if only one of both temperatures is known.

    """
    angle, speed, load, kelvin = bins
    offsets = [0.0]
    if angle > 0.0:
        turn = (_number(window.angle) - point.angle) % (2 * math.pi)
        offsets.append(min(turn, 2 * math.pi - turn) / angle)
    for ratio, value, centre in ((speed, window.speed, point.speed),
                                 (load, window.load, point.load)):
        if ratio > 1.0:
            offsets.append(abs(math.log(max(_number(value), TINY) / max(centre, TINY)))
                           / math.log(ratio))
    if kelvin > 0.0:
        if temperature is not None and point.temperature is not None:
            offsets.append(abs(temperature - point.temperature) / kelvin)
        elif (temperature is None) != (point.temperature is None):
            return math.inf
    return max(offsets)


def _number(value: float) -> float:
    return float(value) if math.isfinite(value) else 0.0


def numbers(values: Any, size: int) -> Array:
    """Return `values` as an array [size]; raises ValueError."""
    array = np.array(values, float)
    if array.size != size:
        raise ValueError(f'{array.size} numbers, expected {size}')
    return array.ravel()
