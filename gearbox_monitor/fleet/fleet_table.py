# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The history of each gearbox: its bags in order of time, folded into one Health.

The windows of a bag are those that its replay judged, in the same way as the live node. So a
jump between two bags is a jump, all features are watched, and dates agree with the node.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any
from uuid import uuid4

import pyarrow as pa
from pyarrow import dataset, parquet

from gearbox_monitor.errors import InputError, refusal
from gearbox_monitor.fleet.job import FleetBag, RobotBag, Row
from gearbox_monitor.health.backlash.change_tests import FEATURES, MEASURED
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.health.health_record import HealthSettings
from gearbox_monitor.health.judgement import CLASSES, folded, Health, serviced
from gearbox_monitor.health.wear_outcome import figures, sentence
from gearbox_monitor.plain_data import from_data
from gearbox_monitor.watch.record import WATCH

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


def joints(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """
    Return the joints of robots as plain data, those with findings first.

    Args:
        rows: of the table of bags (fleet_table.SCHEMA), of robots.

    Returns:
        Dicts: robot, joint ('' for the robot as a whole), level (None: not judged), summary (its
        finding, or why it is not judged), finding, states (as of watch_data), bags (analysed),
        first, last (ns); points: of each bag, {start (ns), states}.

    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row['gearbox'], []).append(row)
    out = [joint for robot, own in groups.items() if robot is not None
           for joint in _joints_of(robot, [row for row in own if row['status'] == 'done'])]
    return sorted(out, key=lambda j: (1 if j['level'] is None else -j['level'], j['robot']))


def _joints_of(robot: str, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the joints of a `robot` after the bags of `rows`."""
    if not rows:
        return [{'robot': robot, 'joint': '', 'level': None, 'summary': 'no bag could be read',
                 'finding': None, 'states': {}, 'bags': 0, 'first': 0, 'last': 0, 'points': []}]
    rows = sorted(rows, key=lambda row: (row['start'], row['path']))
    known = [json.loads(row['judged']) for row in rows]
    newest, out = known[-1], []
    for joint in (*newest['joints'], ''):
        own = newest['joints'].get(joint) or {'level': 0, 'states': {}}
        found = [f for f in newest['findings'] if (f['joint'] or '') == joint]
        if not joint and not found:
            continue        # of the whole robot there is nothing to say
        out.append({
            'robot': robot, 'joint': joint, 'level': int(Level.WARN) if found else own['level'],
            'summary': '; '.join(f['words'].partition(': ')[2] for f in found) or (
                own['words'] if newest['phase'] == WATCH else newest['summary']),
            'finding': found[0] if found else None, 'states': own['states'], 'bags': len(rows),
            'first': rows[0]['start'], 'last': rows[-1]['start'],
            'points': [{'start': row['start'], 'states': data['joints'][joint]['states']}
                       for row, data in zip(rows, known) if joint in data['joints']]})
    return out


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
        settings, windows = from_data(json.loads(row['judged']), CLASSES)
        known = health.baseline_ns
        health = folded(replace(health, settings=settings), windows, row['path'])
        compared = compared or bool(known and health.compared)
        means = {feature: (row[feature], row[f'{feature}_std']) for feature in MEASURED
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
        'level': level.name if compared or health.alerts or health.slips else None,
        'bags': len(rows), 'first': rows[0]['start'], 'last': rows[-1]['start'], 'points': points,
        **{key: rows[-1][key] for key in COPIED},
        **{key: diagnosed.get(key) for key in ('diagnosis', 'diagnosis_effect')}}


PARTS, BAGS, PAGE = 'parts', 'bags.parquet', 'fleet.html'
OF_0_2 = ('features/', 'bags.journal')
NUMBER, COUNT, TEXT, FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()
SCHEMA = pa.schema({
    'path': TEXT, 'status': TEXT, 'reason': TEXT, 'retry': FLAG, 'duplicate_of': TEXT,
    'gearbox': TEXT, 'named': FLAG, 'date': TEXT,
    'start': pa.timestamp('us', 'UTC'), 'duration_s': NUMBER, 'samples': COUNT,
    'filter': TEXT, 'unit': TEXT, 'windows': COUNT, 'windows_used': COUNT, 'not_excited': TEXT,
    'separable': FLAG, **{name + std: NUMBER for name in MEASURED for std in ('', '_std')},
    'trust': TEXT, 'model_level': TEXT, 'diagnosis': TEXT, 'diagnosis_effect': TEXT,
    'diagnosis_place': TEXT, 'diagnosis_confusable': TEXT, 'diagnosis_gap': NUMBER,
    'diagnosis_closed': NUMBER, 'diagnosis_reason': TEXT, 'notes': TEXT, 'content': TEXT,
    'bytes': COUNT, 'settings': TEXT, 'version': TEXT, 'kernels': TEXT, 'judged': TEXT,
})
# Of a Row, and between the two: of ns, Python makes dates with pandas only.
IN_NS, DATED = (SCHEMA.set(SCHEMA.get_field_index('start'), pa.field('start', kind))
                for kind in (COUNT, pa.timestamp('ns', 'UTC')))


class FleetFolder:
    """
    The output folder `folder` of a fleet, new or from an earlier run.

    Raises InputError if it holds other files, those of version 0.2, too, or is not writable.
    """

    def __init__(self, folder: str | Path) -> None:
        self.path = Path(folder).absolute()
        self._parts = self.path / PARTS
        try:
            for name in OF_0_2:
                if (self.path / name).exists():
                    raise InputError(f'{self.path / name}: {refusal(name)}')
            if self.path.is_dir() and any(self.path.iterdir()) and not self._parts.is_dir():
                raise InputError(f'{self.path}: holds other files, expected a new folder or one '
                                 'of an earlier fleet run')
            self._parts.mkdir(parents=True, exist_ok=True)
            # {path in hex: name of the file}
            self._names = {part.name[:32]: part.name for part in self._parts.glob('[!.]*.parquet')}
        except OSError as error:
            raise InputError(f'{error.filename or self.path}: {error.strerror}, expected a new '
                             'or writable folder') from None

    def has(self, bag: FleetBag, key: str) -> bool:
        """Return whether `bag`, as it is now, was analysed under the settings `key`."""
        name = _name_of(bag, key)
        return self._names.get(name[:32]) == name

    def put(self, bag: FleetBag, row: Row) -> None:
        """Write the final `row` of `bag` in place of an earlier one. Raises InputError."""
        name = _name_of(bag, row['settings'])
        if isinstance(bag, RobotBag):   # the state before it goes when both are there
            state = _state_of(bag, row['settings'])
            self._write(f'{PARTS}/{state}', lambda part: part.write_bytes(row['state']))
        self._write(f'{PARTS}/{name}', lambda part: _write_table([row], part))
        if isinstance(bag, RobotBag):
            for old in self._parts.glob(f'{state[:32]}-*.watch'):
                if old.name != state:
                    old.unlink(missing_ok=True)
        earlier = self._names.get(name[:32], name)
        self._names[name[:32]] = name
        if earlier != name:
            (self._parts / earlier).unlink(missing_ok=True)

    def state(self, bag: RobotBag, key: str) -> bytes | None:
        """Return what is known after a robot's `bag` with settings `key`, None if it is lost."""
        path = self._parts / _state_of(bag, key)
        return path.read_bytes() if path.is_file() else None

    def finish(self, retried: Iterable[Row]) -> list[Row]:
        """
        Write the table of bags and return its rows, sorted by path.

        Args:
            retried: rows of bags that are to be tried again.

        Raises:
            InputError: the table cannot be written, or a part of it cannot be read.
        """
        try:
            parts = dataset.dataset(
                [str(self._parts / name) for name in self._names.values()], SCHEMA
            ).to_table().cast(DATED).cast(IN_NS)
        except (OSError, pa.ArrowException) as error:
            raise InputError(f'{self._parts}: {" ".join(str(error).split())}, expected files '
                             'written by fleet; delete a damaged one') from None
        again = {row['path']: {name: row.get(name) for name in SCHEMA.names} for row in retried}
        rows = [row for row in parts.to_pylist() if row['path'] not in again]
        rows = sorted([*rows, *again.values()], key=lambda row: row['path'])
        originals: dict[tuple[str, str], str] = {}  # (content, settings): path
        for row in rows:
            if row['status'] == 'done':
                originals.setdefault((row['content'], row['settings']), row['path'])
        for row in rows:    # the copy of a robot's bag fails: its time has been taken
            original = originals.get((row['content'], row['settings']), row['path'])
            if original != row['path']:
                kept = {name: row[name] for name in (
                    'path', 'content', 'bytes', 'settings', 'version')}
                row.update({**dict.fromkeys(row), **kept, 'status': 'duplicate',
                            'duplicate_of': original})
        self._write(BAGS, lambda part: _write_table(rows, part))
        return rows

    def write_page(self, text: str, name: str = PAGE) -> Path:
        """Write the `text` of the file `name`; return its path. Raises InputError."""
        self._write(name, lambda part: part.write_text(text, encoding='utf-8'))
        return self.path / name

    def _write(self, name: str, write: Callable[[Path], object]) -> None:
        """Let write(path) make the file `name`, completely or not at all."""
        part = (self.path / name).with_name(f'.{uuid4().hex}')
        try:
            write(part)
            with open(part, 'rb') as file:
                os.fsync(file.fileno())
            os.replace(part, self.path / name)
        except OSError as error:
            raise InputError(f'{self.path}: cannot write: {error.strerror or error}; what is done '
                             'is kept, run the same command again to continue') from None
        finally:
            part.unlink(missing_ok=True)


def _name_of(bag: FleetBag, key: str) -> str:
    """Return the name of the file of `bag`, as it is now, under the settings `key`."""
    return f'{_hex(bag.path)[:32]}-{_hex(f"{bag.fingerprint} {key}")[:16]}.parquet'


def _state_of(bag: RobotBag, key: str) -> str:
    """Return the name of the file of what is known of a robot after its `bag`."""
    return f'{_hex(bag.robot)[:32]}-{_hex(f"{bag.fingerprint} {key}")[:16]}.watch'


def _hex(text: str) -> str:
    return hashlib.sha256(text.encode('utf-8', 'surrogateescape')).hexdigest()


def _write_table(rows: Iterable[Row], path: Path) -> None:
    table = pa.Table.from_pylist([{name: row.get(name) for name in SCHEMA.names} for row in rows],
                                 IN_NS)
    parquet.write_table(table.cast(DATED).cast(SCHEMA, safe=False), path, compression='zstd')
