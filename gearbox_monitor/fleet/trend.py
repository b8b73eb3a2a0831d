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
Trend of the backlash of each gearbox from bag to bag, and the order of urgency.

Growth compares the newest bags with the oldest ones, so that late growth counts in full. Rate and
forecast are those of a line through all bags (monitoring.backlash.forecast).
"""
from collections.abc import Iterable, Sequence
import math
from typing import Any

import numpy as np

from gearbox_monitor.fleet.job import Row
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.monitoring.backlash.forecast import GrowthHistory, Trend

ENDS, SHARE = 5, 8  # at either end, one bag in SHARE is compared, at most ENDS
SCATTER = 4  # bags from which on their scatter is estimated
YEAR = 365.25 * 86400.0


def gearboxes(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """
    Summarise each gearbox of `rows` (of fleet_table.COLUMNS), most urgent first.

    A list of dicts: gearbox, unit, feature ('gap', or 'lost_motion' where backlash and compliance
    were never separable), bags (analysed), measured (bags with the feature), first, last (ns),
    width, width_std (of the newest), growth, growth_std (relative, None with one bag), per_year,
    per_year_std (relative, None without a trend), limit (of the growth), reach (s, earliest,
    latest until the growth is `limit`, or None), line (of the trend: width at the first and at the
    last bag, or None), trust, model_level, diagnosis, diagnosis_effect (of the newest bag),
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
        'limit': newest['gap_error'], 'reach': None, 'line': None,
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
    if count >= SCATTER:
        variance = variance * max(1.0, _scatter(start, value, variance))
    ends = min(ENDS, max(1, count // SHARE))
    old, new = (np.average(value[part], weights=1.0 / variance[part])
                for part in (slice(ends), slice(-ends, None)))
    old_std, new_std = (math.sqrt(1.0 / np.sum(1.0 / variance[part]))
                        for part in (slice(ends), slice(-ends, None)))
    if not old > 0.0:
        return {}
    growth = float(new / old - 1.0)
    change: dict[str, Any] = {
        'growth': growth, 'growth_std': math.hypot(new_std, new / old * old_std) / float(old)}
    history = GrowthHistory()
    for stamp_ns, y, v in zip(start.tolist(), value / old - 1.0, variance / old ** 2):
        history.add(stamp_ns, float(y), float(v))
    trend = history.trend(-1)
    if trend is not None:
        past = trend.growth - trend.slope * 1e-9 * float(trend.stamp_ns - start[0])
        change.update(per_year=trend.slope * YEAR, per_year_std=trend.slope_std * YEAR,
                      line=[float(old) * (1.0 + g) for g in (past, trend.growth)])
        # The forecast starts at the measured growth, not at the end of the line.
        newest = Trend(trend.stamp_ns, growth, change['growth_std'], trend.slope, trend.slope_std)
        change['reach'] = newest.reach(limit)
    return change


def _scatter(start: Integers, value: Array, variance: Array) -> float:
    """Return the ratio of the scatter from bag to bag to the stated `variance` [N]."""
    # Against the line between the neighbours: a steady trend is no scatter.
    distance = (start[2:] - start[:-2]).astype(float)
    share = np.where(distance > 0.0, (start[1:-1] - start[:-2]) / np.maximum(distance, 1.0), 0.5)
    deviation = value[1:-1] - (1.0 - share) * value[:-2] - share * value[2:]
    stated = variance[1:-1] + (1.0 - share) ** 2 * variance[:-2] + share ** 2 * variance[2:]
    return float(np.mean(deviation ** 2 / stated))
