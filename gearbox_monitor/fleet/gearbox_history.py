# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The history of each gearbox: its bags in order of time, folded into one Health.

The windows of a bag are those that its replay judged; the judgement is that of the live node. So a
jump between two bags is a jump, all features are watched, and a date is that of the node.
"""
from collections.abc import Iterable, Mapping, Sequence
import json
import math
from typing import Any

from gearbox_monitor.fleet.job import COMBINED, Row
from gearbox_monitor.health.backlash.change_tests import FEATURES
from gearbox_monitor.health.backlash.operating_point import Bins
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.health.health_record import Health, HealthSettings, Window
from gearbox_monitor.health.health_words import figures, sentence
from gearbox_monitor.health.judgement import folded, serviced, under

Services = Mapping[str, Sequence[tuple[int, str]]]  # gearbox: (stamp in ns, note) of each service
COPIED = ('trust', 'model_level', 'not_excited', 'unit')  # of the newest bag
VERDICTS = ('effect', 'none', 'unknown')


def gearboxes(rows: Iterable[Row], services: Services | None = None) -> list[dict[str, Any]]:
    """
    Return the history of each gearbox as plain data, the most urgent first.

    Args:
        rows: of the table of bags (fleet_table.SCHEMA).
        services: of the gearboxes; a new baseline begins with each.

    Returns:
        Dicts: gearbox, level (None: nothing is compared), summary, the `figures` of its health;
        unit, bags (analysed), first, last (ns), trust, model_level, diagnosis, diagnosis_effect,
        not_excited; points: of each bag that shows a feature, {start (ns), means {feature: (mean,
        deviation)}, changes {feature: as judged then}}.

    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row['status'] == 'done':
            groups.setdefault(row['gearbox'], []).append(row)
    boxes = [_history(name, sorted(group, key=lambda row: (row['start'], row['path'])),
                      sorted((services or {}).get(name, ()))) for name, group in groups.items()]
    return sorted(boxes, key=_order)


def _order(box: dict[str, Any]) -> tuple[int, bool, float, str]:
    level = -1 if box['level'] is None else int(Level[box['level']])
    width = box['features'][box['feature']]
    sure = 2.0 * width['change_std'] - width['change'] if width['change'] is not None else 0.0
    return -level, not box['points'], sure, box['gearbox']


def _history(name: str, rows: Sequence[Row], services: list[tuple[int, str]]) -> dict[str, Any]:
    """Fold the windows of the bags `rows`, and the `services` between them."""
    health, points, compared = Health(HealthSettings()), [], False
    for row in rows:
        while services and services[0][0] <= row['start']:
            health = serviced(health, *services.pop(0))
        judged = json.loads(row['judged'])
        settings = _settings(judged['settings'])
        if settings != health.settings:
            health = under(health, settings)
        known = health.baseline_ns
        health = folded(health, map(Window.from_dict, judged['windows']), row['path'])
        compared = compared or bool(known and health.compared)
        means = {feature: (row[feature], row[f'{feature}_std']) for feature in COMBINED
                 if row.get(feature) is not None and math.isfinite(row[f'{feature}_std'])}
        if means:
            points.append({'start': row['start'], 'means': means, 'changes': {
                name: feature.change for name, feature in zip(FEATURES, health.features)}})
    for service in services:
        health = serviced(health, *service)
    level, summary = sentence(health)
    diagnosed = next((row for row in reversed(rows) if row['diagnosis'] in VERDICTS), {})
    return {
        'gearbox': name, **figures(health), 'summary': summary,
        'level': level.name if compared or health.alerts else None, 'bags': len(rows),
        'first': rows[0]['start'], 'last': rows[-1]['start'], 'points': points,
        **{key: rows[-1][key] for key in COPIED},
        **{key: diagnosed.get(key) for key in ('diagnosis', 'diagnosis_effect')}}


def _settings(data: Mapping[str, Any]) -> HealthSettings:
    """Return the HealthSettings that were written as plain `data`."""
    return HealthSettings(**{**data, 'bins': Bins(**data['bins']), 'limits': {
        test: tuple(sizes) for test, sizes in data['limits'].items()}})
