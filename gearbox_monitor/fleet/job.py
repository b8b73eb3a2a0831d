# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Analyse one bag: replay it, fit its features and diagnose it if required.

`analyse` runs in a worker, on this machine or another one, and returns plain data: only the
process that started the fleet run writes files.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
import hashlib
import json
import math
from pathlib import Path
import re
import threading
from typing import Any, TypeAlias

from gearbox_monitor import __version__
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.opening import plain
from gearbox_monitor.fleet.paths import content_hash, FleetBag
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.backlash.recording_windows import (
    combine, reason_of, RecordingWindows, separable_of)
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.reading import open_recording
from gearbox_monitor.recordings.recorded_samples import (
    joined_samples, NO_MODEL, NO_SERIAL, samples_of)
from gearbox_monitor.signals.admission import admitted

FORMAT = 3  # of the rows
DIAGNOSED = 14_000_000_000  # ns of a bag that are diagnosed
COMBINED = ('gap', 'lost_motion', 'stiffness', 'hysteresis')
TRUST = ('observability', 'prediction error', 'covariance', 'input')
Row: TypeAlias = dict[str, Any]  # plain data, some of fleet_table.SCHEMA


@dataclass(frozen=True)
class JobSettings:
    """
    Settings under which every bag of a run is analysed.

    model: None: the one recorded in the bag; model_name: its name in messages. parameters: of the
    estimator, by name; they replace the recorded ones. topic: of the inputs. gearbox: pattern
    whose first group, in the path, names the gearbox; '': the recorded serial. diagnose: whether
    to diagnose. only: ids of the effects to try, () = all. max_seconds: that one bag may take.
    """

    model: DriveModel | None = None
    model_name: str = ''
    parameters: Mapping[str, Any] = field(default_factory=dict)
    topic: str = 'joint_states'
    gearbox: str = ''
    diagnose: bool = False
    only: tuple[str, ...] = ()
    max_seconds: float = math.inf
    version: str = __version__

    @property
    def key(self) -> str:
        """Sixteen hex digits: a bag is not analysed twice under the same ones."""
        content = {'format': FORMAT, 'model': self.model and self.model.to_dict(),
                   'parameters': self.parameters, 'topic': self.topic, 'gearbox': self.gearbox,
                   'diagnose': self.diagnose, 'only': self.only, 'version': self.version}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def analyse(bag: FleetBag, settings: JobSettings) -> Row:
    """
    Return the row of `bag` under `settings`, after settings.max_seconds at the latest.

    The row of a bag that cannot be analysed states the reason; retry: whether it may pass.
    """
    rows: list[Row] = []
    # A thread can be left behind wherever it is; the process of a worker at home ends with it.
    thread = threading.Thread(target=lambda: rows.append(_row(bag, settings)), daemon=True)
    thread.start()
    thread.join(min(settings.max_seconds, threading.TIMEOUT_MAX))
    return rows[0] if rows else failed(
        bag, settings, f'took more than {settings.max_seconds:g} s (--max-seconds)')


def failed(bag: FleetBag, settings: JobSettings, reason: str) -> Row:
    """Return the row of a `bag` that is to be tried again, for a `reason` that may pass."""
    return {'path': bag.path, 'bytes': bag.bytes, 'settings': settings.key,
            'version': __version__, 'status': 'failed', 'retry': True,
            'reason': f'{bag.path}: {reason}'}


def _row(bag: FleetBag, settings: JobSettings) -> Row:
    if settings.version != __version__:
        return failed(bag, settings, f'the worker has gearbox_monitor {__version__}, expected '
                      f'{settings.version}')
    row = {**failed(bag, settings, ''), 'kernels': KERNELS, 'retry': False}
    try:
        path = Path(bag.path)
        row['content'] = content_hash(path)
        return {**row, **_analysed(path, settings), 'status': 'done', 'reason': None}
    except InputError as error:
        return {**row, 'reason': str(error)}
    except OSError as error:
        return {**row, 'retry': True, 'reason': f'{bag.path}: {error}'}
    except MemoryError:
        return {**row, 'retry': True, 'reason': f'{bag.path}: out of memory (--max-memory)'}
    except Exception as error:  # a bag must not end the run of all others
        return {**row, 'reason': f'{bag.path}: {type(error).__name__} '
                                 f'{" ".join(str(error).split())}'}


def _analysed(path: Path, settings: JobSettings) -> Row:
    """Return the results for the row of the bag `path`."""
    with open_recording(path) as reader:
        player = Player(reader, settings.model, settings.parameters, settings.topic)
        monitor = player.monitor
        gearbox = _gearbox(path, player.namespace, monitor.parameters.gearbox_serial,
                           settings.gearbox)
        fits, count = RecordingWindows(monitor.estimator), 0
        start: int | None = None
        end = 0
        for part in player.parts():
            fits.add(part.estimates)
            stamps = part.samples.stamp_ns
            if len(stamps):
                start, end = int(stamps[0]) if start is None else start, int(stamps[-1])
                count += len(stamps)
        if start is None:
            raise InputError(f'{path}: topic {player.topic} has no message, expected at least one')
        windows, monitor = fits.finish(), player.monitor
        row = {
            'gearbox': gearbox, 'start': start, 'duration_s': (end - start) * 1e-9,
            'date': datetime.fromtimestamp(start // 10 ** 9, timezone.utc).strftime('%Y-%m-%d'),
            'samples': count, 'filter': monitor.parameters.filter,
            'unit': 'm' if monitor.model.axis == 'prismatic' else 'rad',
            'trust': max(monitor.outcomes[name].level for name in TRUST).name,
            'model_level': monitor.outcomes['model'].level.name,
            'gap_error': monitor.parameters.gap_error, **_features(windows)}
        if settings.diagnose:
            row.update(_diagnosis(player, windows, start, end, settings))
        notes = monitor.estimator.warnings + monitor.estimator.divergence_notes()
        notes += [reader.notice] if reader.notice else []
        notes += [NO_MODEL] if NO_MODEL in player.notes else []
        unnamed = not settings.gearbox and gearbox == EstimatorParameters().gearbox_serial
        notes += [NO_SERIAL] if unnamed else []
        row['notes'] = '; '.join(notes)
    return row


def _gearbox(path: Path, namespace: str, serial: str, pattern: str) -> str:
    """Return the name of the gearbox."""
    usual = EstimatorParameters().gearbox_serial
    if pattern:
        match = re.search(pattern, str(path))
        if match is None:
            raise InputError(f'{path}: does not match --gearbox {pattern!r}')
        serial = match[1]
    elif serial in ('', usual):  # nobody has named it
        serial = namespace.strip('/') or usual
    if not serial:
        raise InputError(f"{path}: gearbox: '', expected a name")
    return serial


def _features(windows: Sequence[Any]) -> Row:
    """Return the features that all windows give together."""
    used, separable = separable_of(windows)
    row: Row = {'windows': len(windows), 'windows_used': len(used)}
    if used:
        row['separable'] = separable
    else:
        row['not_excited'] = reason_of(windows)
    for name in COMBINED:
        # Lost motion needs no torque: every window counts that shows it.
        combined = combine(windows if name == 'lost_motion' else used, name)
        if combined:
            row[name], row[f'{name}_std'] = combined.value, combined.std
    return row


def _diagnosis(player: Player, windows: Sequence[Backlash | NotExcited], start: int, end: int,
               settings: JobSettings) -> Row:
    """Return the verdict on the part of the bag with the best coverage, or why there is none."""
    excited = [w for w in windows if isinstance(w, Backlash)]
    last = max(excited, key=lambda w: w.coverage).stamp_ns if excited else start + DIAGNOSED
    begin = max(min(last, end) - DIAGNOSED, start)
    model = replace(player.monitor.model, controller=None)  # the estimator takes torques
    samples = _between(player, begin, begin + DIAGNOSED)
    try:
        recording, _ = admitted(samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1],
                                str(player.reader.path), None, model, settings.model_name or
                                'the recorded model')
        verdict = diagnose([recording], model, only=settings.only or None).to_dict()
    except InputError as error:
        return {'diagnosis': 'none possible', 'diagnosis_reason': str(error)}
    place = verdict['location']
    return {'diagnosis': verdict['verdict'], 'diagnosis_effect': verdict['effect'],
            'diagnosis_place': place if isinstance(place, str) else '+'.join(place),
            'diagnosis_confusable': ', '.join(verdict['confusable']),
            'diagnosis_gap': plain(verdict['gap_before']),
            'diagnosis_closed': plain(verdict['closed_fraction'])}


def _between(player: Player, begin: int, end: int) -> Samples:
    """Return the Samples of a bag with begin <= stamp < end (ns)."""
    parameters, parts = player.monitor.parameters, []
    decode = player.reader.decoder(player.topic, (parameters.motor_joint, parameters.arm_joint))
    for block in player.reader.blocks((player.topic,)):
        samples, _ = samples_of(decode(block), player.monitor.model)
        rows = (samples.stamp_ns >= begin) & (samples.stamp_ns < end)
        parts.append(Samples(samples.stamp_ns[rows], samples.u[rows], samples.y[rows]))
    return joined_samples(parts)
