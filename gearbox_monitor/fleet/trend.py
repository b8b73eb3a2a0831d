# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Trend of the backlash of each gearbox from bag to bag, and the order of urgency.

Growth compares the newest bags with the oldest ones, so that late growth counts in full. An
excursion is a growth that has ended: bags above those before them and above those after them. Rate
and forecast are those of a line through all bags outside of excursions
(health.backlash.wear); without a significant slope there is no forecast.
"""
from collections.abc import Iterable, Sequence
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.fleet.job import Row
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.wear import GrowthHistory, Trend
from gearbox_monitor.kernels.types import Array, Flags, Integers

ENDS, SHARE = 5, 8  # at either end, one bag in SHARE is compared, at most ENDS
SCATTER = 4  # bags from which on their scatter is estimated
YEAR = 365.25 * 86400.0
FALSE_ALARM = 0.001  # probability that scatter alone makes an excursion of a gearbox
MAD = 1.4826  # standard deviation of a normal distribution over its median deviation


def gearboxes(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """
    Summarise each gearbox of `rows` (of fleet_table.COLUMNS), most urgent first.

    A list of dicts: gearbox, unit, feature ('gap', or 'lost_motion' where backlash and compliance
    were never separable), bags (analysed), measured (bags with the feature), first, last (ns),
    width, width_std (of the newest), growth, growth_std (relative, None with one bag), per_year,
    per_year_std (relative, None without a trend), limit (of the growth), reach (s, earliest,
    latest until the growth is `limit`, or None), line (of the trend: width at the first and at the
    last bag, or None), excursion (growth that has ended: growth, growth_std, start and end in ns,
    bags; or None), trust, model_level, diagnosis, diagnosis_effect (of the newest bag),
    not_excited (why never measured), notes (bags with one), start, value, std (lists over the
    bags, oldest first).

    Most urgent is the largest growth less two standard deviations.
    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row['status'] == 'done':
            groups.setdefault(row['gearbox'], []).append(row)
    boxes = [_gearbox(name, sorted(group, key=lambda row: (row['start'], row['path'])))
             for name, group in groups.items()]
    return sorted(boxes, key=_order)


def _order(box: dict[str, Any]) -> tuple[bool, bool, float, str]:
    has_growth = box['growth'] is not None
    return (not box['measured'], not has_growth,
            2.0 * box['growth_std'] - box['growth'] if has_growth else -(box['width'] or 0.0),
            box['gearbox'])


def _gearbox(name: str, rows: Sequence[Row]) -> dict[str, Any]:
    newest = rows[-1]
    feature = 'gap' if any(row['separable'] for row in rows) else 'lost_motion'
    measured = [row for row in rows if row[feature] is not None
                and row[f'{feature}_std'] is not None
                and (feature == 'lost_motion' or row['separable'])]
    start = [row['start'] for row in measured]
    value, std = ([row[column] for row in measured] for column in (feature, f'{feature}_std'))
    box = {
        'gearbox': name, 'unit': newest['unit'], 'feature': feature, 'bags': len(rows),
        'measured': len(measured), 'first': rows[0]['start'], 'last': newest['start'],
        'width': value[-1] if measured else None, 'width_std': std[-1] if measured else None,
        'growth': None, 'growth_std': None, 'per_year': None, 'per_year_std': None,
        'limit': newest['gap_error'], 'reach': None, 'line': None, 'excursion': None,
        'not_excited': None if measured else newest['not_excited'],
        **{key: newest[key] for key in ('trust', 'model_level')},
        **_diagnosed(rows), 'notes': sum(bool(row['notes']) for row in rows),
        'start': start, 'value': value, 'std': std}
    if len(measured) > 1:
        box.update(_change(np.array(start), np.array(value), np.array(std), box['limit']))
    return box


def _diagnosed(rows: Sequence[Row]) -> dict[str, Any]:
    last = next((row for row in reversed(rows) if row['diagnosis'] in (
        'effect', 'none', 'unknown')), {})
    return {key: last.get(key) for key in ('diagnosis', 'diagnosis_effect')}


def _change(start: Integers, value: Array, std: Array, limit: float) -> dict[str, Any]:
    """Return growth and trend of `value` [N] with deviations `std` [N], stamped `start` [N] ns."""
    count, floor = len(value), 1e-9 * float(np.abs(value).max()) + 1e-300
    variance = np.maximum(std, floor) ** 2
    change: dict[str, Any] = {}
    usual = np.full(count, True)
    excursion = _excursion(start, value, variance)
    if excursion is not None:
        begin, end, ratio = excursion
        usual[begin:end] = False
        change['excursion'] = _described(start, value, variance * ratio, usual)
    if usual.sum() >= SCATTER:
        variance = variance * max(1.0, _scatter(start[usual], value[usual], variance[usual]))
    ends = min(ENDS, max(1, count // SHARE))
    old, new = (np.average(value[part], weights=1.0 / variance[part])
                for part in (slice(ends), slice(-ends, None)))
    old_std, new_std = (math.sqrt(1.0 / np.sum(1.0 / variance[part]))
                        for part in (slice(ends), slice(-ends, None)))
    if not old > 0.0:
        return {}
    growth = float(new / old - 1.0)
    change.update(growth=growth,
                  growth_std=math.hypot(new_std, new / old * old_std) / float(old))
    history = GrowthHistory()
    for stamp_ns, y, v in zip(start[usual].tolist(), value[usual] / old - 1.0,
                              variance[usual] / old ** 2):
        history.add(stamp_ns, float(y), float(v))
    trend = history.trend(-1)
    if trend is not None:
        past = trend.growth - trend.slope * 1e-9 * float(trend.stamp_ns - start[0])
        change.update(per_year=trend.slope * YEAR, per_year_std=trend.slope_std * YEAR,
                      line=[float(old) * (1.0 + g) for g in (past, trend.growth)])
        # The forecast starts at the measured growth, not at the end of the line. The scatter that
        # the slope is judged by comes from few bags: Student's t instead of the normal law.
        tail = scipy.stats.norm.sf(LIMITS.trend_deviations)
        quantile = scipy.stats.t.isf(tail, int(usual.sum()) - 2)
        if trend.slope > quantile * trend.slope_std:
            newest = Trend(trend.stamp_ns, growth, change['growth_std'], trend.slope,
                           trend.slope_std)
            change['reach'] = newest.reach(limit)
    return change


def _excursion(start: Integers, value: Array, variance: Array) -> tuple[int, int, float] | None:
    """
    Return (begin, end) of bags that are surely above those before and after, None without any.

    The third value is the ratio of the scatter from bag to bag to the stated variance, or 1.

    A scan over stretches of 1, 2, 4, ... bags; the level is shared among all of them (Bonferroni).

    Args:
        start: stamps [N], ns.
        value: widths [N].
        variance: stated variances [N]; the scatter from bag to bag counts where it is larger.
    """
    count = len(value)
    if count < SCATTER:
        return None
    deviation, stated = _second_differences(start, value, variance)
    # The median: the excursion itself is no scatter.
    ratio = max(1.0, (MAD * float(np.median(np.abs(deviation) / np.sqrt(stated)))) ** 2)
    weight = 1.0 / (variance * ratio)
    total, moment = (np.concatenate([[0.0], np.cumsum(x)]) for x in (weight, weight * value))
    stretches: list[tuple[float, int, int]] = []
    size = 1
    while size <= count - 2:
        first = np.arange(1, count - size)
        last = first + size
        step = total[last] - total[first]
        mean = (moment[last] - moment[first]) / step
        score = np.full(len(first), np.inf)
        for w, m in ((total[first], moment[first]),
                     (total[-1] - total[last], moment[-1] - moment[last])):
            score = np.minimum(score, (mean - m / w) / np.sqrt(1.0 / step + 1.0 / w))
        stretches += [(float(z), int(i), int(i) + size) for z, i in zip(score, first)]
        size *= 2
    score_max, begin, end = max(stretches)
    if score_max < scipy.stats.t.isf(FALSE_ALARM / len(stretches), count - 2):
        return None
    # The stretch has the size of a power of two: it ends where the bags are half as high.
    middle = 0.5 * (float(np.average(value[begin:end], weights=weight[begin:end]))
                    + max(moment[begin] / total[begin],
                          (moment[-1] - moment[end]) / (total[-1] - total[end])))
    while value[begin] <= middle:
        begin += 1
    while value[end - 1] <= middle:
        end -= 1
    while begin > 1 and value[begin - 1] > middle:
        begin -= 1
    while end < count - 1 and value[end] > middle:
        end += 1
    return begin, end, ratio


def _described(start: Integers, value: Array, variance: Array, usual: Flags) -> dict[str, Any]:
    """Return growth, its deviation, start, end and number of the bags that are not `usual`."""
    weight = 1.0 / variance
    base, high = (float(np.average(value[part], weights=weight[part])) for part in (usual, ~usual))
    base_std, high_std = (math.sqrt(1.0 / weight[part].sum()) for part in (usual, ~usual))
    return {'growth': high / base - 1.0,
            'growth_std': math.hypot(high_std, high / base * base_std) / base,
            'start': int(start[~usual][0]), 'end': int(start[~usual][-1]),
            'bags': int((~usual).sum())}


def _scatter(start: Integers, value: Array, variance: Array) -> float:
    """Return the ratio of the scatter from bag to bag to the stated `variance` [N]."""
    deviation, stated = _second_differences(start, value, variance)
    return float(np.mean(deviation ** 2 / stated))


def _second_differences(start: Integers, value: Array, variance: Array) -> tuple[Array, Array]:
    """Return each value's deviation from the line between its neighbours, and its variance."""
    # Against that line, because a steady trend is no scatter.
    distance = (start[2:] - start[:-2]).astype(float)
    share = np.where(distance > 0.0, (start[1:-1] - start[:-2]) / np.maximum(distance, 1.0), 0.5)
    deviation = value[1:-1] - (1.0 - share) * value[:-2] - share * value[2:]
    stated = variance[1:-1] + (1.0 - share) ** 2 * variance[:-2] + share ** 2 * variance[2:]
    return deviation, stated
