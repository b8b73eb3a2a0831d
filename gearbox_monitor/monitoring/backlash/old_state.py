# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Baselines from a file, and the state of drift as version 0.2 wrote it, as WearData."""
from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.monitoring.alert_limits import LIMITS
from gearbox_monitor.monitoring.backlash.change_tests import (
    FEATURES, GAP, PRIORS, SHARP, TESTS)
from gearbox_monitor.monitoring.backlash.operating_point import (
    N_COLUMNS, numbers, OperatingPoint)
from gearbox_monitor.monitoring.backlash.wear_data import (
    COUNT, KELVIN, KELVIN_2, PRODUCT, TOTAL, TRUSTED, WearBlock, WearData)

_SUMS = ('first', 'count', 'total', 'squares', 'stated', 'sum_complete')
_OLD = 6  # features of version 0.2: the first ones of FEATURES


def load_baselines(data: WearData, rows: Sequence[Values]) -> None:
    """
    Fill an empty `data` with the baselines `rows` of a file, of Tracker.baseline_points.

    Raises KeyError, TypeError or ValueError for rows that are none.
    """
    block = WearBlock(0, 0)
    moments, shared = np.zeros((len(FEATURES), len(FEATURES))), 0.0
    for row in rows:
        point = OperatingPoint.at(row)
        count, mean, std, stated = (np.full(len(FEATURES), np.nan) for _ in range(4))
        for name, feature in row['features'].items():
            i = FEATURES.index(name)
            count[i], mean[i] = int(feature['windows']), float(feature['mean'])
            std[i], stated[i] = float(feature['std']), float(feature['stated_std'])
        unit = _add(data, block, point, count, mean, std ** 2, stated ** 2)
        if 'together' in row:
            part, windows = _together(row['together'], unit)
            moments, shared = moments + part, shared + windows
        for name, value in row.get('couplings', {}).items():
            data.couplings[FEATURES.index(name)] = float(value)
            data.frozen = True
    _couple(data, block, moments, shared)
    if block.windows:
        data.blocks.append(block)


def _add(data: WearData, block: WearBlock, point: OperatingPoint, count: Array, mean: Array,
         variance: Array, stated: Array) -> Array:
    """
    Add an operating point with its sums; return the units [F] of its features.

    Args:
        data: to add to.
        block: that holds the sums.
        point: the operating point.
        count: windows of each feature [F], NaN or 0: none.
        mean: of the features [F].
        variance: of a window [F].
        stated: mean of the variances stated [F].

    """
    data.points.append(point)
    units, levels = np.ones(len(FEATURES)), np.full(len(FEATURES), np.nan)
    for i in range(len(FEATURES)):
        if not math.isfinite(mean[i]):
            continue
        unit = units[i] = max(
            abs(mean[i]) if PRIORS[i].logarithmic else point.unit(i), 1e-12)
        point.stated[i], point.stated_count[i] = stated[i] / unit ** 2, 1.0
        if not count[i] > 0.0:
            continue
        point.stated_count[i] = count[i]
        levels[i] = math.log(unit) if PRIORS[i].logarithmic else mean[i] / unit
        point.freedom[i] = max(count[i] - 1.0, 0.0)
        point.squares[i] = point.freedom[i] * variance[i] / unit ** 2
    data.reference = np.where(np.isnan(data.reference), levels, data.reference)
    kelvin = data.warmth(point.temperature)
    finite = np.isfinite(levels)
    number = np.append(np.where(finite, count, 0.0), 0.0)
    y = np.append(np.where(finite, levels - data.reference, 0.0), 0.0)
    sums = np.zeros((5, N_COLUMNS))
    sums[COUNT], sums[TOTAL] = number, number * y
    sums[KELVIN], sums[KELVIN_2] = number * kelvin, number * kelvin ** 2
    sums[PRODUCT] = number * y * kelvin
    block.add((len(data.points) - 1, TRUSTED), sums)
    block.windows += int(number.max())
    return units


def _together(row: Values, unit: Array) -> tuple[Array, float]:
    """Return (products [F, F] of relative deviations from the means, windows) of a `row`."""
    places = [FEATURES.index(name) for name in row['features']]
    windows = float(row['windows'])
    sums = numbers(row['sums'], len(places))
    products = numbers(row['products'], len(places) ** 2).reshape(len(places), -1)
    moments = np.zeros((len(FEATURES), len(FEATURES)))
    moments[np.ix_(places, places)] = products - np.outer(sums, sums) / max(windows, 1.0)
    return moments / np.outer(unit, unit), windows


def _couple(data: WearData, block: WearBlock, moments: Array, windows: float) -> None:
    """Take the couplings from `moments` [F, F] of `windows`, and SHARP's sums from the others."""
    used = [i for i in range(GAP + 1, len(FEATURES)) if moments[i, i] > 0.0]
    if windows >= LIMITS.min_complete and used and moments[GAP, GAP] > 0.0:
        stated = np.mean([p.stated[used] for p in data.points], axis=0)
        data.couplings[used] = np.linalg.solve(
            moments[np.ix_(used, used)] + LIMITS.ridge * np.diag(stated), moments[used, GAP])
        data.frozen = True
    if not data.couplings.any():
        return
    active = np.flatnonzero(data.couplings)
    direction = -data.couplings
    direction[GAP] = 1.0
    variance = max(float(direction @ moments @ direction), 0.0) / max(windows - 1.0, 1.0)
    for (k, _), sums in block.cells.items():
        point = data.points[k]
        if not (sums[COUNT, [GAP, *active]] > 0.0).all():
            continue
        number = sums[COUNT, [GAP, *active]].min()
        y = sums[TOTAL, :SHARP] / np.maximum(sums[COUNT, :SHARP], 1.0) @ direction
        kelvin = sums[KELVIN, GAP] / max(sums[COUNT, GAP], 1.0)
        sums[:, SHARP] = number * np.array([1.0, y, kelvin, kelvin ** 2, y * kelvin])
        point.freedom[SHARP] = max(number - 1.0, 0.0)
        point.squares[SHARP] = point.freedom[SHARP] * (
            variance if variance > 0.0 else _sharp_variance(point, direction))


def _sharp_variance(point: OperatingPoint, direction: Array) -> float:
    """Return the variance of SHARP that an upper bound gives: errors of the features add."""
    own = point.squares[:SHARP] / np.maximum(point.freedom[:SHARP], 1.0)
    return float(own[GAP] - min(own[GAP] * 0.9, float(direction[1:] ** 2 @ own[1:])))


def widened(state: Values) -> Values:
    """
    Return a state of Tracker.to_dict with the features that it was written before, unknown.

    Raises KeyError, TypeError, IndexError or ValueError for data that are no state.
    """
    n = len(state['wear'])
    new = [math.nan] * (len(FEATURES) - n)
    if not new:
        return state

    def with_sharp(row: Sequence[float], value: float = 0.0) -> list[float]:
        """Return `row` [n + 1] as [N_COLUMNS]: SHARP is the last of it."""
        return [*row[:n], *[value] * len(new), *row[n:]]

    none = [0.0] * len(new)
    return {
        **state, 'wear': [*state['wear'], *({} for _ in new)],
        'points': [{**p, 'stated': [*p['stated'], *none],
                    'stated_count': [*p['stated_count'], *none],
                    'squares': with_sharp(p['squares']), 'freedom': with_sharp(p['freedom']),
                    'previous': with_sharp(p['previous'], math.nan)} for p in state['points']],
        'blocks': [[*block[:3], [[*cell[:2], *(
            v for k in range(5) for v in with_sharp(cell[2:][k * (n + 1):(k + 1) * (n + 1)]))]
            for cell in block[3]]] for block in state['blocks']],
        'windows': [[*row, *new] for row in state['windows']],
        'reference': [*state['reference'], *new], 'couplings': [*state['couplings'], *none],
        'slopes': with_sharp(state['slopes']), 'spread': with_sharp(state['spread'], math.nan),
        'shift': with_sharp(state['shift']),
        'levels': [*state['levels'], *new], 'level_stds': [*state['level_stds'], *new]}


def converted(state: Values) -> dict[str, Any]:
    """
    Return the state of drift of version 0.2 as Tracker.to_dict gives it now.

    Raises KeyError, TypeError, IndexError or ValueError for data that are no state.
    """
    n = len(FEATURES)
    if isinstance(state['points'], list) and 'windows' not in state:
        raise KeyError('windows')
    data, block = WearData(), WearBlock(0, 0)
    rows = state['windows']
    where = [int(r[1]) for r in rows]
    if not all(0 <= k < len(state['points']) for k in where):
        raise ValueError('a window of an unknown operating point')
    new = n - _OLD
    values = np.pad(numbers([r[3:] for r in rows], len(rows) * _OLD).reshape(-1, _OLD),
                    ((0, 0), (0, new)), constant_values=math.nan)
    learned = np.array([bool(r[2]) for r in rows], bool)
    moments, shared = np.zeros((n, n)), 0.0
    for k, row in enumerate(state['points']):
        sums = {name: np.pad(numbers(row[name], _OLD), (0, new)) for name in _SUMS}
        own = values[learned & (np.array(where, int) == k)] if rows else values
        off = own - sums['first']
        finite = np.isfinite(off)
        off = np.where(finite, off, 0.0)
        count = np.maximum(sums['count'] - finite.sum(axis=0), 0.0)
        total = sums['total'] - off.sum(axis=0)
        number = np.maximum(count, 1.0)
        squares = np.maximum(sums['squares'] - (off ** 2).sum(axis=0) - total ** 2 / number, 0.0)
        # Without older windows the noise is that of the rows, and so is the level for the units.
        whole = np.maximum(sums['count'], 1.0)
        spread = np.maximum(sums['squares'] - sums['total'] ** 2 / whole, 0.0) / np.maximum(
            sums['count'] - 1.0, 1.0)
        variance = np.where(count > 1.0, squares / np.maximum(count - 1.0, 1.0), spread)
        mean = sums['first'] + np.where(count > 0.0, total / number, sums['total'] / whole)
        unit = _add(data, block, OperatingPoint.at(row), np.where(count > 0.0, count, np.nan),
                    mean, variance, sums['stated'])
        complete = float(row['complete'])
        if complete > 0.0:
            products = np.pad(
                numbers(row['products'], _OLD * _OLD).reshape(_OLD, _OLD), (0, new))
            part = products - np.outer(sums['sum_complete'], sums['sum_complete']) / complete
            used = np.pad(numbers(row['used'], _OLD), (0, new)) > 0.0
            moments += np.where(np.outer(used, used), part, 0.0) / np.outer(unit, unit)
            shared += complete
    _couple(data, block, moments, shared)
    if block.windows:
        data.blocks.append(block)
    temperature = state.get('temperature')
    for k, (row, point) in enumerate(zip(rows, where)):
        y = np.array([_logarithm(i, v, data.points[point].unit(i))
                      for i, v in enumerate(values[k])])
        data.add(int(row[0]), point, TRUSTED, data.warmth(data.points[point].temperature),
                 data.relative(y))
    steps: list[list[int]] = [[] for _ in FEATURES]
    for key, change in state['changes'].items():
        column = next((t.column for t in TESTS if t.key == key), None)
        if column is not None and column < n:
            steps[column].append(int(change['since_ns']))
    return {
        'wear': [{'steps': sorted(s), 'pending': []} for s in steps], **data.to_dict(),
        'scores': state['scores'], 'changes': state['changes'],
        'levels': [math.nan] * n, 'level_stds': [math.nan] * n, 'ended': {},
        'window': state['window'], 'point': state['point'],
        'friction': state.get('friction'), 'trusted': state['trusted'],
        'compared': state.get('compared', state['trusted']), 'temperature': temperature,
        'stamp_ns': state['stamp_ns'], 'pause': state['pause'], 'converted': True}


def _logarithm(column: int, value: float, unit: float) -> float:
    if not math.isfinite(value):
        return math.nan
    return math.log(max(value, 1e-12)) if PRIORS[column].logarithmic else value / unit
