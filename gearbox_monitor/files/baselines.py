# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The files of drift: the baseline (what was healthy) and the state (what goes on after a restart).

Both are written atomically. A damaged file is set aside and reported, and drift detection starts
again, also for a state of another version or gearbox. Such a baseline is an error: it is intact,
but not the intended one. No file of version 0.2 is read.
"""
import json
import math
import os
from pathlib import Path
import time
from typing import Any

import yaml

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.health.backlash import drift_words
from gearbox_monitor.health.backlash.change import Tracker, TrackerSettings
from gearbox_monitor.kernels.types import Values

FORMAT, STATE_FORMAT = 3, 6  # version 0.2 wrote up to 2 and up to 5


class Damaged(InputError):
    """A file of drift is not what this package has written."""


def load_baseline(path: str | Path, gearbox_serial: str = '') -> list[dict[str, Any]]:
    """
    Return the baselines in the file `path`, as change.Tracker takes them.

    Raises Damaged, and InputError where the file cannot be read, is of another version or names
    another gearbox than `gearbox_serial`.
    """
    if not os.access(path, os.R_OK):
        load_yaml(path)  # says why
    try:
        data = load_yaml(path).content
    except InputError as error:
        raise Damaged(*error.args) from None
    if not isinstance(data, dict) or 'baseline' not in data:
        raise Damaged(f'{path}: {str(data)[:60]!r}, expected a block "baseline"')
    if data.get('format') != FORMAT:
        raise InputError(f'{path}: a baseline of another version (format '
                         f'{data.get("format")!r}), expected format {FORMAT}: save the baseline '
                         'again')
    serial = data.get('gearbox_serial')
    if gearbox_serial and serial != gearbox_serial:
        raise InputError(f'{path}: gearbox_serial: {serial!r}, expected {gearbox_serial!r}')
    points = data['baseline']
    if not isinstance(points, list):
        raise Damaged(f'{path}: baseline: {str(points)[:60]!r}, expected a list of operating '
                      'points')
    if data.get('points', len(points)) != len(points):
        raise Damaged(f'{path}: baseline: {len(points)} operating points, expected '
                      f'{data["points"]}: the file is truncated')
    for k, point in enumerate(points):
        _check_point(point, f'{path}: baseline[{k}]')
    try:
        return Tracker(TrackerSettings(), points).baseline_points()
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise Damaged(f'{path}: baseline: {error!r}, expected what ~/save_baseline '
                      'writes') from None


def _check_point(point: Any, source: str) -> None:
    """Raise Damaged that names `source` if `point` is no operating point."""
    if not isinstance(point, dict) or not isinstance(point.get('features'), dict):
        raise Damaged(f'{source}: {str(point)[:60]!r}, expected an operating point with '
                      'features')
    for name in ('angle', 'speed', 'load', 'scale'):
        _check_number(point.get(name), f'{source}.{name}', -math.inf)
    if point.get('temperature') is not None:
        _check_number(point['temperature'], f'{source}.temperature', -math.inf)
    for name, feature in point['features'].items():
        for key in ('windows', 'mean', 'std', 'stated_std'):
            value = feature.get(key) if isinstance(feature, dict) else None
            _check_number(value, f'{source}.{name}.{key}', 0.0 if key != 'mean' else -math.inf)


def _check_number(value: object, source: str, low: float) -> None:
    """Raise Damaged that names `source` if `value` is no finite number >= `low`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or \
            not math.isfinite(value) or value < low:
        raise Damaged(f'{source}: {value!r}, expected a number'
                      + (f' >= {low:g}' if low > -math.inf else ''))


def save_baseline(path: str | Path, points: list[dict[str, Any]], gearbox_serial: str,
                  parameters: dict[str, Any]) -> None:
    """
    Write baselines to a file, whole or not at all.

    Args:
        path: of the file; replaced if it exists.
        points: of Tracker.baseline_points.
        gearbox_serial: of the gearbox that they belong to.
        parameters: in force, for the record.

    Raises:
        InputError: if the file cannot be written.

    """
    text = '# What was healthy, per operating point; written by ~/save_baseline.\n' + \
        yaml.safe_dump({
            'format': FORMAT, 'gearbox_monitor': __version__, 'gearbox_serial': gearbox_serial,
            'date': _now(), 'points': len(points), 'baseline': points,
            'parameters': parameters}, sort_keys=False)
    write_whole(Path(path), text)


def state_text(tracker: Tracker, gearbox_serial: str, adaptation: Values | None = None,
               recording_ns: int = 0) -> str:
    """
    Return the state file of a `tracker`, the `gearbox_serial` and values of `adaptation`.

    recording_ns: stamp of the baseline recording, 0: none.
    """
    return json.dumps({
        'format': STATE_FORMAT, 'gearbox_monitor': __version__,
        'gearbox_serial': gearbox_serial, 'date': _now(), 'drift': tracker.to_dict(),
        'adaptation': adaptation or {}, 'recording_ns': recording_ns})


def load_state(path: str | Path, gearbox_serial: str) -> tuple[dict[str, Any] | None, str]:
    """
    Return (state or None, report or '') of the state file `path` of the gearbox `gearbox_serial`.

    The state: {'drift': what Tracker takes, 'adaptation': what Estimator.recall takes or {},
    'recording_ns': stamp of the baseline recording, 0: none}.
    There may be no file yet. One that is damaged, of another version or of another gearbox is
    renamed to PATH.corrupt-DATE. Raises InputError where it cannot be read or renamed.
    """
    path = Path(path)
    try:
        with open_file(path) as file:
            text = file.read().decode('utf-8', 'replace')
    except FileNotFoundError:
        return None, ''
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable file') from None
    try:
        data = json.loads(text)
        if data['format'] != STATE_FORMAT:
            raise ValueError(f'a state of another version (format {data["format"]!r}), expected '
                             f'format {STATE_FORMAT}')
        if data['gearbox_serial'] != gearbox_serial:
            raise ValueError(f'gearbox_serial {data["gearbox_serial"]!r}, expected '
                             f'{gearbox_serial!r}')
        drift_words.outcomes(Tracker(TrackerSettings(), data['drift']))
        adaptation = data['adaptation']
        if not isinstance(adaptation, dict):
            raise ValueError(f'adaptation {str(adaptation)[:60]!r}, expected a block')
        return {'drift': data['drift'], 'adaptation': adaptation,
                'recording_ns': int(data['recording_ns'])}, ''
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError,
            RecursionError) as error:
        reason = f'no {error}' if isinstance(error, KeyError) else str(error)
    return None, f'{path}: {reason}: {set_aside(path)}'


def set_aside(path: str | Path, reason: str = 'corrupt') -> str:
    """Rename `path` to PATH.`reason`-DATE; return what to report. Raises InputError."""
    path = Path(path)
    aside = path.with_name(f'{path.name}.{reason}-{time.strftime("%Y%m%d-%H%M%S")}')
    try:
        os.replace(path, aside)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a file that can be renamed') \
            from None
    return f'set aside as {aside.name}; drift detection starts again'


def _now() -> str:
    """Return the local time in ISO 8601."""
    return time.strftime('%Y-%m-%dT%H:%M:%S%z')


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace the file `path` by `content` at once. Raises InputError."""
    temporary = path.with_name(path.name + '.tmp')
    try:
        with open(temporary, 'wb') as file:
            file.write(content.encode('utf-8') if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a writable file') from None
