# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Baselines from a file as WearData."""
from collections.abc import Sequence
import math

import numpy as np

from gearbox_monitor.health.backlash.change_tests import FEATURES, GAP, PRIORS, SHARP
from gearbox_monitor.health.backlash.operating_point import N_COLUMNS, OperatingPoint
from gearbox_monitor.health.backlash.wear_data import (
    COUNT, KELVIN, KELVIN_2, PRODUCT, TOTAL, TRUSTED, WearBlock, WearData)
from gearbox_monitor.kernels.types import Array, Values


def load_baselines(data: WearData, rows: Sequence[Values]) -> None:
    """
    Fill an empty `data` with the baselines `rows` of a file, of Tracker.baseline_points.

    Raises KeyError, TypeError or ValueError for rows that are none.
    """
    block = WearBlock(0, 0)
    for row in rows:
        point = OperatingPoint.at(row)
        count, mean, std, stated = (np.full(len(FEATURES), np.nan) for _ in range(4))
        for name, feature in row['features'].items():
            i = FEATURES.index(name)
            count[i], mean[i] = int(feature['windows']), float(feature['mean'])
            std[i], stated[i] = float(feature['std']), float(feature['stated_std'])
        _add(data, block, point, count, mean, std ** 2, stated ** 2)
        for name, value in row.get('couplings', {}).items():
            data.couplings[FEATURES.index(name)] = float(value)
            data.frozen = True
    if data.couplings.any():
        _sharpen(data, block)
    if block.windows:
        data.blocks.append(block)


def _add(data: WearData, block: WearBlock, point: OperatingPoint, count: Array, mean: Array,
         variance: Array, stated: Array) -> None:
    """
    Add an operating point with its sums.

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
    levels = np.full(len(FEATURES), np.nan)
    for i in range(len(FEATURES)):
        if not math.isfinite(mean[i]):
            continue
        unit = max(abs(mean[i]) if PRIORS[i].logarithmic else point.unit(i), 1e-12)
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


def _sharpen(data: WearData, block: WearBlock) -> None:
    """Take the sums of SHARP in `block` from those of the other features."""
    active = np.flatnonzero(data.couplings)
    direction = -data.couplings
    direction[GAP] = 1.0
    for (k, _), sums in block.cells.items():
        point = data.points[k]
        if not (sums[COUNT, [GAP, *active]] > 0.0).all():
            continue
        number = sums[COUNT, [GAP, *active]].min()
        y = sums[TOTAL, :SHARP] / np.maximum(sums[COUNT, :SHARP], 1.0) @ direction
        kelvin = sums[KELVIN, GAP] / max(sums[COUNT, GAP], 1.0)
        sums[:, SHARP] = number * np.array([1.0, y, kelvin, kelvin ** 2, y * kelvin])
        point.freedom[SHARP] = max(number - 1.0, 0.0)
        point.squares[SHARP] = point.freedom[SHARP] * _sharp_variance(point, direction)


def _sharp_variance(point: OperatingPoint, direction: Array) -> float:
    """Return the variance of SHARP that an upper bound gives: errors of the features add."""
    own = point.squares[:SHARP] / np.maximum(point.freedom[:SHARP], 1.0)
    return float(own[GAP] - min(own[GAP] * 0.9, float(direction[1:] ** 2 @ own[1:])))
