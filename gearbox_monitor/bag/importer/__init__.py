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
Convert foreign recordings (text, MATLAB, JSON) into samples in SI units, and these into a bag.

The bag holds ``joint_states`` with the joints ``motor`` and ``arm`` (NaN = not measured) and the
reference torque, if recorded, on ``reference/transmission_state``. A reference serves fits and
scores and is never an input of the estimator.
"""
from collections.abc import Callable
from dataclasses import dataclass
import hashlib
from pathlib import Path

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.importer.columns import read_columns
from gearbox_monitor.bag.importer.mapping import (
    FIRST_STAMP_NS, ImportMapping, load_mapping, SIGNALS)
from gearbox_monitor.bag.read import JOINT_STATE
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags, Integers

__all__ = ['FIRST_STAMP_NS', 'ImportedRecording', 'load_mapping', 'read_recording',
           'write_imported_bag']

JOINT_TOPIC = '/joint_states'
REFERENCE_TOPIC = '/reference/transmission_state'


@dataclass(frozen=True)
class ImportedRecording:
    """
    Samples [N] of one drive: rad (or m) and N m (or N); NaN where not measured.

    `stamp_ns` is int64 and strictly increasing. `reference_torque` is None when there is none.
    `notices` are sentences about the data that its owner should read.
    """

    stamp_ns: Integers
    motor_position: Array
    motor_effort: Array
    arm_position: Array
    arm_effort: Array
    reference_torque: Array | None
    notices: tuple[str, ...] = ()


def read_recording(path: str | Path, mapping: ImportMapping) -> ImportedRecording:
    """
    Return the ImportedRecording in the file `path` as `mapping` reads it.

    Raises InputError that names file, line or entry, value and expected value.
    """
    columns, place = read_columns(path, mapping)
    n = len(next(iter(columns.values())))
    if n < 2:
        raise InputError(f'{path}: {n} samples, expected at least two')
    stamps = _stamps(path, mapping, columns.pop('time', None), n, place)
    values: dict[str, Array] = {}
    notices = []
    for name, raw in columns.items():
        values[name] = _convert(path, mapping, name, raw, place)
        missing = int(np.isnan(raw).sum())
        if missing:
            notices.append(f'{name}: {missing} of {n} samples not measured')
        if missing < n and np.nanmax(raw) == np.nanmin(raw):
            notices.append(f'{name}: the same value in all samples')
    step = np.diff(stamps)
    dropouts = int((step > 3 * np.median(step)).sum())
    if dropouts:
        notices.append(f'time: {dropouts} dropouts of more than 3 sample times, longest '
                       f'{step.max() * 1e-9:.3g} s')
    motor_position, motor_effort, arm_position, arm_effort = (
        values[name] if name in values else np.full(n, np.nan)
        for name in ('motor_position', 'motor_effort', 'arm_position', 'arm_effort'))
    return ImportedRecording(stamps, motor_position, motor_effort, arm_position, arm_effort,
                             values.get('reference_torque'), tuple(notices))


def _stamps(path: str | Path, mapping: ImportMapping, raw: Array | None, n: int,
            place: Callable[[int, str], str]) -> Integers:
    """Return the stamps (ns) of `n` samples from raw time (None: a constant rate)."""
    time = mapping.time
    recorded = time.start_stamp_ns == 'recorded'
    start = FIRST_STAMP_NS if recorded else int(time.start_stamp_ns)
    if raw is None:
        assert time.rate is not None  # the mapping was checked
        constant: Integers = np.rint(np.arange(n) * (1e9 / time.rate)).astype(np.int64)
        return start + constant
    bad = np.flatnonzero(~np.isfinite(raw))
    if len(bad):
        raise InputError(f'{path}: {place(bad[0], "time")} value {raw[bad[0]]}: expected a finite '
                         'number')
    # Whole numbers from here on: a double resolves today's date to 256 ns only.
    ns = np.rint((raw if recorded else raw - raw[0]) * (time.scale * 1e9))
    back = np.flatnonzero(np.diff(ns) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise InputError(f'{path}: {place(row, "time")} value {raw[row]:.12g} after '
                         f'{raw[row - 1]:.12g}: expected strictly increasing time')
    first = 0 if recorded else start
    for row in (0, -1):
        if not 1 <= ns[row] + first < 2 ** 31 * 1e9:
            raise InputError(f'{path}: {place(row % n, "time")} value {raw[row]:.12g}: stamp '
                             f'{(ns[row] + first) * 1e-9:.9g} s, expected one > 0 and < 2^31 s')
    stamps: Integers = ns.astype(np.int64)
    return stamps + first


def _convert(path: str | Path, mapping: ImportMapping, name: str, raw: Array,
             place: Callable[[int, str], str]) -> Array:
    """Return the values of signal `name` in SI units on the arm side."""
    signal = mapping.signals[name]

    def refuse(wrong: Flags, expected: str) -> None:
        rows = np.flatnonzero(wrong)
        if len(rows):
            raise InputError(f'{path}: {place(rows[0], name)} value {raw[rows[0]]:.12g}: '
                             f'expected {expected}')
    missing = np.isnan(raw)
    refuse(np.isinf(raw), 'a finite number')
    if signal.missing == 'error':
        refuse(missing, 'a number (missing: nan admits missing ones)')
    value = raw
    if signal.bits:
        full = 2.0 ** signal.bits
        refuse(~missing & ((raw < 0) | (raw >= full) | (raw != np.floor(raw))),
               f'an integer from 0 to {int(full) - 1}')
        value = np.where(raw >= full / 2, raw - full, raw)
    zero = signal.zero
    if zero == 'first':
        zero = 0.0 if missing.all() else value[~missing][0]
    value = (value - float(zero)) * signal.factor()
    position, _, motor_side = SIGNALS[name]
    if motor_side:
        value = value / mapping.gear_ratio if position else value * mapping.gear_ratio
    return value


def write_imported_bag(recording: ImportedRecording, bag: str | Path, source: str | Path,
                       mapping: ImportMapping) -> None:
    """
    Write a recording and, as metadata record ``import``, its origin.

    Args:
        recording: the samples.
        bag: the new bag.
        source: the file they were read from; its name and SHA-256 are recorded.
        mapping: through which they were read; it is recorded.

    Raises:
        InputError: `bag` exists or cannot be written.
    """
    r = recording
    messages = [(JOINT_TOPIC, encode_joint_states(
        r.stamp_ns, ['motor', 'arm'], np.column_stack([r.motor_position, r.arm_position]),
        effort=np.column_stack([r.motor_effort, r.arm_effort])))]
    if r.reference_torque is not None:
        messages.append((REFERENCE_TOPIC, encode_joint_states(
            r.stamp_ns, ['transmission'], np.full((len(r.stamp_ns), 1), np.nan),
            effort=r.reference_torque[:, None])))
    with BagWriter(bag) as writer:
        for topic, _ in messages:
            writer.add_topic(topic, JOINT_STATE)
        writer.add_metadata('import', {
            'source': Path(source).name,
            'source_sha256': hashlib.sha256(Path(source).read_bytes()).hexdigest(),
            'mapping': mapping.yaml_text,
            'mapping_file': Path(mapping.source).name,
            'kind': mapping.kind,
            'notices': '\n'.join(r.notices),
            'gearbox_monitor_version': __version__,
        })
        for i, stamp in enumerate(r.stamp_ns.tolist()):
            for topic, data in messages:
                writer.write(topic, stamp, data[i])
