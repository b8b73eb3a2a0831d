# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The windows of a gearbox: the newest one by one, older ones as sums, and what makes the gap sharp.

Errors of the features of a window go together: where the stiffness came out too large, the gap
did. The gap less what the other features of its window say (SHARP) scatters far less, and is as
large where they have stayed.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash import wear
from gearbox_monitor.health.backlash.change_tests import (
    FEATURES, FRICTION, GAIN, GAP, HYSTERESIS, SHARP, STIFFNESS, VISCOUS_SHARE)
from gearbox_monitor.health.backlash.operating_point import N_COLUMNS, numbers, OperatingPoint
from gearbox_monitor.health.health_record import ERRORS_LARGER, TRUSTED
from gearbox_monitor.kernels.types import Array, Values

OTHERS = (STIFFNESS, HYSTERESIS, FRICTION, GAIN)  # what comes out of the fit beside the gap
PER_SIZE = 16      # blocks of one size, before the two oldest of them become one
MAX_ACTIVE = 48    # points that take part in a fit, beside those of the newest windows
COUNT, TOTAL, KELVIN, KELVIN_2, PRODUCT = range(5)  # rows of the sums of a cell


def excess(trust: int) -> float:
    """Return the variance of a window over that of one whose prediction errors are not larger."""
    return 2.0 ** (0.5 * min(max(ERRORS_LARGER - trust, 0), 99))


@dataclass
class WearBlock:
    """Windows of the past, as sums: cells {(point, trust): [5, F + 1]}, see COUNT and after."""

    begin_ns: int
    end_ns: int
    windows: int = 0
    cells: dict[tuple[int, int], Array] = field(default_factory=dict)

    @property
    def stamp_ns(self) -> int:
        """Middle of the block."""
        return (self.begin_ns + self.end_ns) // 2

    def add(self, key: tuple[int, int], sums: Array) -> None:
        """Add `sums` [5, F + 1] to the cell `key`."""
        self.cells[key] = self.cells[key] + sums if key in self.cells else sums


class WearData:
    """
    Points, newest windows (rows) and blocks of older ones, of a drive with a law of friction.

    viscous (N m s/rad), coulomb (N m): of the model file.

    stamps [M] ns, where [M]: point, trust [M], kelvin [M]: temperature less the first known,
    values [M, F]: logarithms of the features less those of the first window (of hysteresis: over
    load). reference [F]: these. couplings [F]: what to subtract from the gap per unit of the
    others; frozen: whether they stay. shift_ns, shift [F + 1]: windows until then were moved to
    the wear of that moment by save_baseline, whose variances these are.
    """

    def __init__(self, viscous: float = 0.0, coulomb: float = 0.0) -> None:
        n = len(FEATURES)
        self.viscous, self.coulomb = viscous, coulomb
        self.points: list[OperatingPoint] = []
        self.blocks: list[WearBlock] = []
        self.stamps: list[int] = []
        self.where: list[int] = []
        self.trust: list[int] = []
        self.kelvin: list[float] = []
        self.values: Array = np.empty((0, n))
        self.reference: Array = np.full(n, np.nan)
        self.first_kelvin: float | None = None
        self.couplings: Array = np.zeros(n)
        self.frozen = False
        self.slopes: Array = np.zeros(N_COLUMNS)  # temperature coefficients, as known so far
        self.spread: Array = np.full(N_COLUMNS, np.nan)  # variances of offsets, as known so far
        self.shift_ns = 0
        self.shift: Array = np.zeros(N_COLUMNS)

    def __len__(self) -> int:
        return len(self.stamps)

    # ------------------------------------------------------------------ windows

    def relative(self, values: Array) -> Array:
        """Return values [F] less the reference, which the first of each feature becomes."""
        self.reference = np.where(np.isnan(self.reference), values, self.reference)
        return np.array([float(f'{v:.7g}') for v in values - self.reference])

    def warmth(self, temperature: float | None) -> float:
        """Return `temperature` (deg C) less the first known one; 0 where it is unknown."""
        if temperature is None:
            return 0.0
        if self.first_kelvin is None:
            self.first_kelvin = temperature
        return temperature - self.first_kelvin

    def add(self, stamp_ns: int, point: int, trust: int, kelvin: float, values: Array) -> None:
        """
        Take a window.

        Args:
            stamp_ns: its end.
            point: its operating point.
            trust: TRUSTED or less.
            kelvin: of warmth.
            values: of relative [F].

        """
        self.stamps.append(stamp_ns)
        self.where.append(point)
        self.trust.append(trust)
        self.kelvin.append(kelvin)
        self.values = np.vstack([self.values, values])
        place = self.points[point]
        place.since_ns = place.since_ns or stamp_ns
        place.last_ns = stamp_ns
        place.scatter(self.sharpened(values[None])[0], kelvin, self.slopes, excess(trust))

    def sharpened(self, values: Array) -> Array:
        """Return values [N, F] with SHARP beside them, NaN where that is not known."""
        active = self.couplings != 0.0
        if not active.any():
            sharp = np.full(len(values), np.nan)
        else:
            sharp = values[:, GAP] - values[:, active] @ self.couplings[active]
        return np.column_stack([values, sharp])

    def move(self, by_ns: int) -> None:
        """Move all stamps by `by_ns`."""
        self.stamps = [stamp + by_ns for stamp in self.stamps]
        self.shift_ns += by_ns if self.shift_ns else 0
        for block in self.blocks:
            block.begin_ns, block.end_ns = block.begin_ns + by_ns, block.end_ns + by_ns
        for point in self.points:
            point.since_ns, point.last_ns = point.since_ns + by_ns, point.last_ns + by_ns

    def couple(self, boundaries: Sequence[int]) -> None:
        """Learn the couplings from the rows; `boundaries` (ns): where features changed."""
        if self.frozen or len(self) < LIMITS.min_complete:
            return
        used = [i for i in OTHERS if np.isfinite(self.values[:, i]).mean() > 0.9]
        complete = np.isfinite(self.values[:, [GAP, *used]]).all(axis=1)
        if not used or complete.sum() < LIMITS.min_complete:
            return
        groups: dict[tuple[int, int], list[int]] = {}
        segment = np.searchsorted(np.sort(np.array(boundaries, np.int64)), self.stamps)
        for k in np.flatnonzero(complete):
            groups.setdefault((self.where[k], int(segment[k])), []).append(int(k))
        columns = [GAP, *used]
        off = self.values[:, columns] - np.outer(self.kelvin, self.slopes[columns])
        parts = [off[rows] - off[rows].mean(axis=0) for rows in groups.values() if len(rows) > 2]
        if not parts or sum(map(len, parts)) < LIMITS.min_complete:
            return
        x = np.concatenate(parts)
        stated = np.mean([p.stated[used] for p in self.points if p.stated_count[GAP]], axis=0)
        try:
            coupling = np.linalg.solve(x[:, 1:].T @ x[:, 1:] + LIMITS.ridge * np.diag(stated),
                                       x[:, 1:].T @ x[:, 0])
        except np.linalg.LinAlgError:
            return
        self.couplings = np.zeros(len(FEATURES))
        self.couplings[used] = coupling
        self._scatter_again()

    def _scatter_again(self) -> None:
        """Take the noise of SHARP, which is defined again, from all rows."""
        rows = self.sharpened(self.values)
        rows[:, :SHARP] = np.nan
        for point in self.points:
            point.forget_sharp()
        for k, where in enumerate(self.where):
            self.points[where].scatter(
                rows[k], self.kelvin[k], self.slopes, excess(self.trust[k]))

    def count(self, point: int) -> int:
        """Return the number of windows of a `point`, of the feature with most of them."""
        total = sum((cell[COUNT] for block in self.blocks for key, cell in block.cells.items()
                     if key[0] == point), np.zeros(N_COLUMNS))
        rows = np.array(self.where) == point
        total[:-1] += np.isfinite(self.values[rows]).sum(axis=0)
        return int(total.max())

    def absorb(self, boundaries: Iterable[int], limit: int) -> None:
        """
        Put rows beyond the horizon into blocks.

        Args:
            boundaries: stamps (ns) of steps of any feature, over which blocks do not reach.
            limit: windows of a point that blocks hold while no feature has changed.

        """
        marks = sorted(boundaries)
        while len(self) > LIMITS.horizon:
            self.frozen = True
            stamp, key = self.stamps[0], (self.where[0], self.trust[0])
            values = self.sharpened(self.values[:1])[0]
            finite = np.isfinite(values)
            y, kelvin = np.where(finite, values, 0.0), self.kelvin[0] * finite
            sums = np.array([finite.astype(float), y, kelvin, kelvin * self.kelvin[0],
                             y * self.kelvin[0]])
            moving = bool(marks) and marks[0] < stamp
            cell = self.blocks[0].cells.get(key) if self.blocks else None
            full = cell is not None and cell[COUNT].max() >= limit
            if moving or not self.blocks:
                self.blocks.append(WearBlock(stamp, stamp))
            if moving or not full:
                block = self.blocks[-1]
                block.end_ns, block.windows = stamp, block.windows + 1
                block.add(key, sums)
            del self.stamps[0], self.where[0], self.trust[0], self.kelvin[0]
            self.values = self.values[1:]
            self._merge(marks)

    def _merge(self, marks: Sequence[int]) -> None:
        """Merge neighbouring blocks without a mark between: fine where new, coarse where old."""
        while True:
            sizes: dict[int, list[int]] = {}
            for i, (a, b) in enumerate(zip(self.blocks, self.blocks[1:])):
                if any(a.end_ns <= mark < b.begin_ns for mark in marks):
                    continue
                size = max(a.windows, b.windows).bit_length()
                if not marks or marks[0] >= b.end_ns:
                    size = -1  # before any change: one block
                sizes.setdefault(size, []).append(i)
            pairs = [rows[0] for size, rows in sizes.items() if size < 0 or len(rows) > PER_SIZE]
            if not pairs:
                return
            i = min(pairs)
            a, b = self.blocks[i], self.blocks.pop(i + 1)
            a.end_ns, a.windows = b.end_ns, a.windows + b.windows
            for key, sums in b.cells.items():
                a.add(key, sums)

    def drop(self, column: int, begin_ns: int, end_ns: int) -> None:
        """
        Forget a feature in the windows after `begin_ns` until `end_ns`: they were not healthy.

        column: of the feature; with the gap goes SHARP.
        """
        columns = [column, SHARP] if column == GAP else [column]
        for block in self.blocks:
            if begin_ns < block.stamp_ns <= end_ns:
                for sums in block.cells.values():
                    sums[:, columns] = 0.0
        stamps = np.array(self.stamps, np.int64)
        self.values[(stamps > begin_ns) & (stamps <= end_ns), column] = np.nan

    def middles(self) -> list[int]:
        """Return the stamps (ns) of the blocks and of the rows."""
        return [block.stamp_ns for block in self.blocks] + self.stamps

    def shift_by(self, steps: Mapping[int, Array], variances: Mapping[int, float],
                 since_ns: int) -> None:
        """
        Move all windows to the wear of now, which is healthy from now on.

        Args:
            steps: {feature: what is added to each of middles()}.
            variances: {feature: of what is added to windows before `since_ns`}.
            since_ns: where the present state began.

        """
        for k, block in enumerate(self.blocks):
            by = np.zeros((1, len(FEATURES)))
            for column, step in steps.items():
                by[0, column] = step[k]
            whole = np.nan_to_num(self.sharpened(by)[0])
            for sums in block.cells.values():
                sums[TOTAL] += whole * sums[COUNT]
                sums[PRODUCT] += whole * sums[KELVIN]
        for column, step in steps.items():
            self.values[:, column] += step[len(self.blocks):]
        self.shift_ns = max(self.shift_ns, since_ns)
        for column, variance in variances.items():
            self.shift[column] += variance
            if column == GAP or self.couplings[column]:
                factor = 1.0 if column == GAP else self.couplings[column] ** 2
                self.shift[SHARP] += factor * variance

    # ------------------------------------------------------------------ for a fit

    def shares(self, points: Sequence[int], column: int) -> Array:
        """Return the shares [N, 2] of both temperature coefficients of a `column` at `points`."""
        parts = np.tile((1.0, 0.0), (len(points), 1))
        if column in (FRICTION, VISCOUS_SHARE) and self.viscous + self.coulomb > 0.0:
            parts[:] = [(self.viscous * self.points[k].speed, self.coulomb) for k in points]
            parts /= np.maximum(parts.sum(axis=1, keepdims=True), 1e-300)
        if column == VISCOUS_SHARE:  # the derivative of the share v / (v + c)
            parts = parts.prod(axis=1, keepdims=True) * (1.0, -1.0)
        return parts

    @property
    def newest(self) -> int:
        """
        The operating point of the newest row.

        A newer window that was not compared, at another point perhaps, has no row.
        """
        return self.where[-1]

    def active(self) -> list[int]:
        """Return the points that take part: those of the rows, and the newest of the others."""
        rows = set(self.where)
        older = {key[0] for block in self.blocks for key in block.cells} - rows
        newest = sorted(older, key=lambda k: -self.points[k].last_ns)[:MAX_ACTIVE]
        return sorted(rows | set(newest))

    def observations(self, now_ns: int, window_ns: float
                     ) -> tuple[list[wear.Observations], list[int]]:
        """Return the Observations of each of the F + 1 columns at `now_ns`, and their points."""
        points = self.active()
        place = {point: wear.N_COMMON + k for k, point in enumerate(points)}
        cells = [(block.stamp_ns, key, sums) for block in self.blocks
                 for key, sums in block.cells.items() if key[0] in place]
        n, m = len(cells), len(self)
        keys = [key for _, key, _ in cells] + list(zip(self.where, self.trust))
        larger = {key: wear.N_COMMON + len(points) + k for k, key in enumerate(sorted({
            key for key in keys if key[1] <= ERRORS_LARGER}))}
        design = np.zeros((n + m, wear.N_COMMON + len(points) + len(larger)))
        design[:, wear.LEVEL] = 1.0
        stamps = np.array([stamp for stamp, _, _ in cells] + self.stamps, np.int64)
        sums = np.array([s for _, _, s in cells]) if cells else np.zeros((0, 5, N_COLUMNS))
        counts = np.concatenate([
            sums[:, COUNT], np.isfinite(rows := self.sharpened(self.values)).astype(float)])
        largest = np.maximum(sums[:, COUNT].max(axis=1, initial=0.0), 1.0)
        warmth = sums[:, KELVIN].max(axis=1, initial=-np.inf)
        coldness = sums[:, KELVIN].min(axis=1, initial=np.inf)
        design[:n, wear.TEMPERATURE] = np.where(
            np.abs(warmth) > np.abs(coldness), warmth, coldness) / largest
        design[n:, wear.TEMPERATURE] = self.kelvin
        for k, key in enumerate(keys):
            design[k, place[key[0]]] = 1.0
            if key[1] != TRUSTED:
                design[k, larger.get(key, wear.DISTRUST)] = 1.0
        design[:, wear.SHIFT] = stamps <= self.shift_ns
        variances = {point: self.points[point].variance() for point in points}
        noise = np.array([variances[point] * excess(trust) for point, trust in keys]).reshape(
            n + m, N_COLUMNS)
        age = wear.ages(stamps, now_ns, window_ns)
        safe = np.maximum(sums[:, COUNT], 1.0)
        mean = np.concatenate([sums[:, TOTAL] / safe, np.nan_to_num(rows)])
        weight = np.where((counts > 0.0) & (noise > 0.0), counts / np.where(
            noise > 0.0, noise, 1.0), 0.0)
        spread = (sums[:, KELVIN_2] - sums[:, KELVIN] ** 2 / safe) / np.where(
            noise[:n] > 0.0, noise[:n], np.inf)
        product = (sums[:, PRODUCT] - sums[:, KELVIN] * sums[:, TOTAL] / safe) / np.where(
            noise[:n] > 0.0, noise[:n], np.inf)
        result = []
        for f in range(N_COLUMNS):
            part = self.shares([point for point, _ in keys], f)
            own = design.copy()
            own[:, wear.TEMPERATURES] = part * design[:, [wear.TEMPERATURE]]
            result.append(wear.Observations(
                own, mean[:, f], weight[:, f], counts[:, f], age, m,
                ((part[:n] * spread[:, [f]]).T @ part[:n], product[:, f] @ part[:n])))
        return result, points

    # ------------------------------------------------------------------ state

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain data; floats read back exactly."""
        return {
            'points': [p.to_dict() for p in self.points],
            'blocks': [[b.begin_ns, b.end_ns, b.windows, [
                [point, trust, *map(float, sums.ravel())]
                for (point, trust), sums in b.cells.items()]] for b in self.blocks],
            'windows': [[stamp, where, trust, kelvin, *map(float, values)] for
                        stamp, where, trust, kelvin, values in zip(
                            self.stamps, self.where, self.trust, self.kelvin, self.values)],
            'reference': [float(v) for v in self.reference], 'first_kelvin': self.first_kelvin,
            'couplings': [float(v) for v in self.couplings], 'frozen': self.frozen,
            'slopes': [float(v) for v in self.slopes], 'spread': [float(v) for v in self.spread],
            'shift_ns': self.shift_ns, 'shift': [float(v) for v in self.shift]}

    def load(self, state: Values) -> None:
        """Take over what to_dict gave. Raises KeyError, TypeError or ValueError."""
        n = len(FEATURES)
        self.points = [OperatingPoint.from_dict(row) for row in state['points']]
        for begin, end, windows, rows in state['blocks']:
            block = WearBlock(int(begin), int(end), int(windows))
            for row in rows:
                block.cells[self._point(row[0]), _trust(row[1])] = numbers(
                    row[2:], 5 * N_COLUMNS).reshape(5, N_COLUMNS)
            self.blocks.append(block)
        rows = state['windows']
        self.stamps, self.where = [int(r[0]) for r in rows], [self._point(r[1]) for r in rows]
        self.trust, self.kelvin = [_trust(r[2]) for r in rows], [float(r[3]) for r in rows]
        self.values = numbers([r[4:] for r in rows], len(rows) * n).reshape(-1, n)
        self.reference, self.couplings = (
            numbers(state[name], n) for name in ('reference', 'couplings'))
        self.slopes, self.spread, self.shift = (
            numbers(state[name], N_COLUMNS) for name in ('slopes', 'spread', 'shift'))
        self.first_kelvin, self.frozen = state['first_kelvin'], bool(state['frozen'])
        self.shift_ns = int(state['shift_ns'])

    def _point(self, index: Any) -> int:
        if not 0 <= int(index) < len(self.points):
            raise ValueError('a window of an unknown operating point')
        return int(index)


def _trust(level: Any) -> int:
    if not (isinstance(level, int) and level <= TRUSTED):
        raise ValueError(f'trust {level!r}, expected an integer up to {TRUSTED}')
    return int(level)
