# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Analyse one bag: replay it, fit its features and diagnose it if required.

Runs in a worker and returns plain data; only the process that started the fleet run writes files.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
import errno
import hashlib
import json
from pathlib import Path
import re
import tempfile
import time
from typing import Any, TypeAlias
from urllib.parse import quote

from gearbox_monitor import __version__
from gearbox_monitor.bag.player import Player
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.recorded_samples import joined_samples, samples_of
from gearbox_monitor.bag.recorded_snapshots import NO_MODEL, NO_SERIAL
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.plain_data import plain
from gearbox_monitor.fleet.paths import content_hash, fetched
from gearbox_monitor.identification.diagnose import diagnose
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.monitoring.backlash.features import Backlash, NotExcited
from gearbox_monitor.monitoring.backlash.recording_windows import (
    combine, reason_of, RecordingWindows, separable_of)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.admission import admitted

FORMAT = 2  # of the tables
DIAGNOSED = 14_000_000_000  # ns of a bag that are diagnosed
LONGEST_NAME = 200  # of a gearbox, bytes of the name of its folder
COMBINED = ('gap', 'lost_motion', 'stiffness', 'hysteresis')
TRUST = ('observability', 'prediction error', 'covariance', 'input')
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
Row: TypeAlias = dict[str, Any]  # plain data, some of fleet_table.COLUMNS
Window: TypeAlias = Backlash | NotExcited


@dataclass(frozen=True)
class JobSettings:
    """
    Settings under which every bag of a run is analysed.

    model: None: the one recorded in the bag; model_name: its name in messages. parameters: of the
    estimator, by name; they replace the recorded ones. topic: of the inputs. gearbox: pattern
    whose first group, in the path, names the gearbox; '': the recorded serial. diagnose: whether
    to diagnose. only: ids of the effects to try, () = all.
    """

    model: DriveModel | None = None
    model_name: str = ''
    parameters: Mapping[str, Any] = field(default_factory=dict)
    topic: str = 'joint_states'
    gearbox: str = ''
    diagnose: bool = False
    only: tuple[str, ...] = ()
    version: str = __version__

    @property
    def key(self) -> str:
        """Sixteen hex digits: a bag is not analysed twice under the same ones."""
        content = {'format': FORMAT, 'model': self.model and self.model.to_dict(),
                   'parameters': self.parameters, 'topic': self.topic, 'gearbox': self.gearbox,
                   'diagnose': self.diagnose, 'only': self.only, 'version': self.version}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def digest(url: str) -> tuple[str, str]:
    """Return (content hash, '') of the bag `url`, ('', reason) if it cannot be read."""
    try:
        return content_hash(url), ''
    except OSError as error:
        return '', f'cannot be read: {error.strerror or error}'


def analyse(url: str, settings: JobSettings) -> tuple[Row, list[Window]]:
    """
    Return (row, windows) of the bag `url` under `settings`.

    The row of a bag that cannot be analysed states the reason; retry: whether it may pass. Raises
    InputError if the disk for copies of bags is full.
    """
    began = time.process_time()
    row: Row = {'version': __version__, 'kernels': KERNELS, 'status': 'failed',
                'retry': False}
    windows: list[Window] = []
    try:
        if settings.version != __version__:
            row['retry'] = True
            raise InputError(f'the worker has gearbox_monitor {__version__}, expected '
                             f'{settings.version}')
        row['content'] = content_hash(url)
        with fetched(url) as path:
            try:
                results, windows = _analysed(path, url, settings)
            except InputError as error:  # it names the copy
                raise InputError(str(error).replace(str(path), url)) from None
        row.update(results, status='done')
    except InputError as error:
        row['reason'] = str(error)
    except (OSError, MemoryError) as error:
        if isinstance(error, OSError) and error.errno in DISK_FULL:
            raise InputError(f'{tempfile.gettempdir()}: {error.strerror}, expected room for a '
                             f'copy of {url}; what is done is kept, run the same '
                             'command again to continue') from None
        row.update(retry=True, reason=f'{url}: {error}' if isinstance(error, OSError) else
                   f'{url}: out of memory (--max-memory)')
    except Exception as error:  # a bag must not end the run of all others
        row['reason'] = f'{url}: {type(error).__name__} {" ".join(str(error).split())}'
    row['cpu_s'] = round(time.process_time() - began, 3)
    return row, windows


def _analysed(path: Path, url: str, settings: JobSettings) -> tuple[Row, list[Window]]:
    """Return (results for the row, windows) of the local bag `path`."""
    with open_bag(path) as reader:
        player = Player(reader, settings.model, settings.parameters, settings.topic)
        monitor = player.monitor
        gearbox = _gearbox(url, player.namespace, monitor.parameters.gearbox_serial,
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
        row['notes'] = '; '.join(note.replace(str(path), url) for note in notes)
    return row, windows


def _gearbox(url: str, namespace: str, serial: str, pattern: str) -> str:
    """Return the name of the gearbox."""
    name, usual = serial, EstimatorParameters().gearbox_serial
    if pattern:
        match = re.search(pattern, url)
        if match is None:
            raise InputError(f'{url}: does not match --gearbox {pattern!r}')
        name = match[1]
    elif name in ('', usual):  # nobody has named it
        name = namespace.strip('/') or usual
    if not 0 < len(quote(name, safe='')) <= LONGEST_NAME:
        raise InputError(f'{url}: gearbox: {name!r}, expected a name of 1 to {LONGEST_NAME} '
                         'characters')
    return name


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


def _diagnosis(player: Player, windows: Sequence[Window], start: int, end: int,
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
