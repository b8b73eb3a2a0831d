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
What becomes of one bag, wherever it runs: replayed, its features fitted, perhaps diagnosed.

Runs in a worker and returns plain data; only the process that started the fleet run writes files.
"""
from dataclasses import dataclass, field
from datetime import datetime, timezone
import errno
import hashlib
import json
import re
import tempfile
import time
from urllib.parse import quote

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.replay import Player, samples_of
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.fleet.paths import content_hash, fetched
from gearbox_monitor.identification.diagnose import diagnose
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.monitoring.backlash.features import Backlash
from gearbox_monitor.monitoring.backlash.recording_windows import (
    combine, reason_of, RecordingWindows, separable_of)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.admission import admitted

FORMAT = 1  # of the tables
DIAGNOSED = 14_000_000_000  # ns of a bag that are diagnosed
LONGEST_NAME = 200  # of a gearbox, bytes of its folder's name
COMBINED = ('gap', 'lost_motion', 'stiffness', 'hysteresis')
TRUST = ('observability', 'prediction error', 'covariance', 'input')
FULL = (errno.ENOSPC, errno.EDQUOT)


@dataclass(frozen=True)
class JobSettings:
    """
    What every bag of a run is analysed with.

    model: DriveModel, or None: that recorded in the bag. model_name: what messages call it.
    parameters: of the estimator, by name; they replace the recorded ones. topic: of the inputs.
    gearbox: pattern whose first group, in the path, names the gearbox; '': the recorded serial.
    diagnose: whether to. only: effects that are tried, () = all.
    """

    model: DriveModel | None = None
    model_name: str = ''
    parameters: dict = field(default_factory=dict)
    topic: str = 'joint_states'
    gearbox: str = ''
    diagnose: bool = False
    only: tuple = ()
    version: str = __version__

    @property
    def key(self):
        """Sixteen hex digits: what was analysed with the same ones is not analysed again."""
        content = {'format': FORMAT, 'model': self.model and self.model.to_dict(),
                   'parameters': self.parameters, 'topic': self.topic, 'gearbox': self.gearbox,
                   'diagnose': self.diagnose, 'only': self.only, 'version': self.version}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def digest(url):
    """Return (content hash, '') of the bag `url`, ('', reason) where it cannot be read."""
    try:
        return content_hash(url), ''
    except OSError as error:
        return '', f'cannot be read: {error.strerror or error}'


def analyse(url, settings):
    """
    Return (row, windows) of the bag `url` under JobSettings.

    row: plain data, some of fleet_table.COLUMNS; windows: list of Backlash and NotExcited. A bag
    that cannot be analysed has a row, too, with the reason; retry: whether that may pass.
    Raises InputError where the disk for copies of bags is full.
    """
    began = time.process_time()
    row = {'version': __version__, 'kernels': KERNELS, 'status': 'failed', 'retry': False}
    windows = []
    try:
        if settings.version != __version__:
            row['retry'] = True
            raise InputError(f'the worker has gearbox_monitor {__version__}, expected '
                             f'{settings.version}')
        row['content'] = content_hash(url)
        with fetched(url) as path:
            try:
                found, windows = _analysed(path, url, settings)
            except InputError as error:  # says where a copy lay
                raise InputError(str(error).replace(str(path), url)) from None
        row.update(found, status='done')
    except InputError as error:
        row['reason'] = str(error)
    except (OSError, MemoryError) as error:
        if getattr(error, 'errno', None) in FULL:
            raise InputError(f'{tempfile.gettempdir()}: {error.strerror}, expected room for a '
                             f'copy of {url}; what is done is kept, the same command goes on '
                             'from there') from None
        row.update(retry=True, reason=f'{url}: {type(error).__name__} {error}')
    except Exception as error:  # a bag must not end the run of all others
        row['reason'] = f'{url}: {type(error).__name__} {" ".join(str(error).split())}'
    row['cpu_s'] = round(time.process_time() - began, 3)
    return row, windows


def _analysed(path, url, settings):
    """Return (what the row says, windows) of the local bag `path`."""
    with open_bag(path) as reader:
        player = Player(reader, settings.model, settings.parameters, settings.topic)
        monitor = player.monitor
        gearbox = _gearbox(url, player.namespace, monitor.parameters.gearbox_serial,
                           settings.gearbox)
        windows = RecordingWindows(monitor.estimator.drive, monitor.parameters)
        count, start = 0, None
        for part in player.parts():
            windows.add(part.estimates.smoothed_stamp_ns, part.estimates.smoothed)
            stamps = part.samples.stamp_ns
            if len(stamps):
                start, end, count = int(stamps[0]) if start is None else start, int(stamps[-1]), \
                    count + len(stamps)
        if not count:
            raise InputError(f'{path}: topic {player.topic} has no message, expected some')
        windows, monitor = windows.finish(), player.monitor
        row = {
            'gearbox': gearbox, 'start': start, 'duration_s': (end - start) * 1e-9,
            'date': datetime.fromtimestamp(start // 10 ** 9, timezone.utc).strftime('%Y-%m-%d'),
            'samples': count, 'filter': monitor.parameters.filter,
            'unit': 'm' if monitor.model.axis == 'prismatic' else 'rad',
            'trust': max(monitor.findings[name].level for name in TRUST).name,
            'model_level': monitor.findings['model'].level.name,
            'gap_error': monitor.parameters.gap_error, **_features(windows)}
        if settings.diagnose:
            row.update(_diagnosis(player, windows, start, end, settings))
        notes = monitor.estimator.warnings + monitor.estimator.divergence_notes()
        notes += [reader.notice] if reader.notice else []
        if settings.model is None and not _records_a_model(player):
            notes.append('no model of the drive is recorded or given: analysed with that of '
                         'drive.yaml')
        row['notes'] = '; '.join(note.replace(str(path), url) for note in notes)
    return row, windows


def _records_a_model(player):
    """Return whether the bag holds snapshots of an estimator, and so its model."""
    return player.input.snapshots is not None


def _gearbox(url, namespace, serial, pattern):
    """Return the name of the gearbox."""
    name, usual = serial, EstimatorParameters().gearbox_serial
    if pattern:
        match = re.search(pattern, url)
        if match is None:
            raise InputError(f'{url}: does not match --gearbox {pattern!r}')
        name = match[1] if match.re.groups else match[0]
    elif name in ('', usual):  # nobody has named it
        name = namespace.strip('/') or usual
    if not 0 < len(quote(name, safe='')) <= LONGEST_NAME:
        raise InputError(f'{url}: gearbox: {name!r}, expected a name of 1 to {LONGEST_NAME} '
                         'characters')
    return name


def _features(windows):
    """Return what all windows say together."""
    used, separable = separable_of(windows)
    row = {'windows': len(windows), 'windows_used': len(used)}
    if not used:
        return {**row, 'not_excited': reason_of(windows)}
    row['separable'] = separable
    for name in COMBINED:
        combined = combine(used, name)
        if combined:
            row[name], row[f'{name}_std'] = combined.value, combined.std
    return row


def _diagnosis(player, windows, start, end, settings):
    """Return the verdict on the liveliest part of the bag, or why there is none."""
    seen = [w for w in windows if isinstance(w, Backlash)]
    last = max(seen, key=lambda w: w.coverage).stamp_ns if seen else start + DIAGNOSED
    begin = max(min(last, end) - DIAGNOSED, start)
    model = player.monitor.model
    samples = _between(player, begin, begin + DIAGNOSED)
    try:
        recording, _ = admitted(samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1],
                                str(player.reader.path), None, model, settings.model_name or
                                'the recorded model')
        found = diagnose([recording], model, only=settings.only or None).to_dict()
    except InputError as error:
        return {'diagnosis': 'none possible', 'diagnosis_reason': str(error)}
    place = found['location']
    return {'diagnosis': found['verdict'], 'diagnosis_effect': found['effect'],
            'diagnosis_place': place if isinstance(place, str) else '+'.join(place),
            'diagnosis_confusable': ', '.join(found['confusable']),
            'diagnosis_gap': _number(found['gap_before']),
            'diagnosis_closed': _number(found['closed_fraction'])}


def _number(value):
    return None if value is None or not np.isfinite(value) else float(value)


def _between(player, begin, end):
    """Return the Samples of a bag that are stamped within begin <= stamp < end (ns)."""
    p, parts = player.monitor.parameters, []
    decode = player.reader.decoder(player.topic, (p.motor_joint, p.arm_joint))
    for block in player.reader.blocks((player.topic,)):
        samples, _ = samples_of(decode(block), player.monitor.model)
        inside = (samples.stamp_ns >= begin) & (samples.stamp_ns < end)
        parts.append((samples.stamp_ns[inside], samples.u[inside], samples.y[inside]))
    return Samples(*(np.concatenate(column) for column in zip(*parts)))
