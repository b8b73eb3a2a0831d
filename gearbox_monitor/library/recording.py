# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A recording of one drive: of a bag, a table, a DataFrame or arrays."""
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.kernels.array_input import column
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.library.drive_file import expect_path
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.plant.origin import FileLimits, NO_LIMITS
from gearbox_monitor.plant.simulate import Trajectory
from gearbox_monitor.presentation import Drawn
from gearbox_monitor.recordings.cdr import JointStates
from gearbox_monitor.recordings.csv import COLUMNS, CsvColumns, ENCODERS, read_csv, TEXTS
from gearbox_monitor.recordings.importer.containers import opened_table
from gearbox_monitor.recordings.joint_input import find_input
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.recorded_samples import samples_of
from gearbox_monitor.recordings.robot_input import TABLES
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.signals.admission import admitted, prepared, require_samples, weighed
from gearbox_monitor.signals.uniform import merged, REPEATED, UniformRecording

FIELDS = {'t': 'stamp', 'u': 'effort of the motor', 'setpoint': 'position of the setpoint',
          'motor': 'position of the motor',
          'arm': 'position of the arm', 'arm_torque': 'effort of the arm'}
ROLES = ('motor', 'arm', 'setpoint')  # of joints in a bag
WORDS = {'t': 'time in s', 'u': 'torque in N m, or current in A with torque_constant in the model',
         'setpoint': 'setpoint in rad', 'motor': 'position of the motor in rad, on the arm side',
         'arm': 'position of the arm in rad', 'arm_torque': 'torque on the arm in N m'}
EXPECTED = 't, torque (or u) or setpoint, motor or arm, arm_torque'
SECOND = 1_000_000_000


class Readings(NamedTuple):
    """
    Columns of a recording; place(row, field): where a value stands in the file, in words.

    u: torque, N m, or setpoint, rad, of a model with a controller.
    """

    t: Array | Integers
    u: Array
    y: Array
    arm_torque: Array | None
    place: Callable[[int, str], str]
    notes: list[str]


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Drawn):
    """
    A recording of one drive, as `load_recording` returns it.

    name: what messages call it. model: the drive whose gear ratio, torque constant and controller
    refer it to the arm side. read: what gives the readings for such a model. limits: of the
    simulator's file that the model is from. repeated: what is used of samples with one stamp.
    """

    name: str
    model: DriveModel
    read: Callable[[DriveModel], Readings]
    limits: FileLimits = NO_LIMITS
    repeated: str = REPEATED[0]

    @cached_property
    def readings(self) -> Readings:
        """The readings on the arm side, with setpoints that the simulator takes."""
        return _within_limits(self.read(self.model), self.limits, self.model)

    def with_model(self, model: DriveModel) -> 'Recording':
        """Return the recording as it is read for the drive `model`."""
        return self if model is self.model else replace(self, model=expect_model(model))

    def __len__(self) -> int:
        return len(self.readings.t)

    @property
    def stamp_ns(self) -> Integers:
        """Stamps int64 [N], ns; of a table, whose times begin anywhere, from 1 s on."""
        t = self.readings.t
        if t.dtype.kind in 'iu':
            return t.astype(np.int64)
        return SECOND + np.round((t - np.nanmin(t)) * SECOND).astype(np.int64)

    @property
    def t(self) -> Array:
        """Times [N] from the first sample, s."""
        stamps = self.stamp_ns
        return (stamps - stamps.min()) / SECOND

    @property
    def torque(self) -> Array:
        """Torque of the motor [N] on the arm side, N m; NaN with a controller in the model."""
        nothing = np.full(len(self), np.nan)
        return self.readings.u if self.model.controller is None else nothing

    @property
    def setpoint(self) -> Array:
        """Setpoint [N], rad; NaN without a controller in the model."""
        nothing = np.full(len(self), np.nan)
        return nothing if self.model.controller is None else self.readings.u

    @property
    def motor(self) -> Array:
        """Position of the motor [N] on the arm side, rad; NaN: not measured."""
        return self.readings.y[:, 0]

    @property
    def arm(self) -> Array:
        """Position of the arm [N], rad; NaN: not measured."""
        return self.readings.y[:, 1]

    @property
    def arm_torque(self) -> Array:
        """Torque measured on the arm [N], N m; NaN: not measured."""
        arm = self.readings.arm_torque
        return np.full(len(self), np.nan) if arm is None else arm

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about what was read and what was not."""
        return (*self.limits.notes, *self.readings.notes)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return float(self.t.max())

    @property
    def rate(self) -> float:
        """Samples per second: 1 over the median step, Hz."""
        steps = np.diff(self.t)
        return float(1.0 / np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0

    def samples(self) -> Samples:
        """Return the Samples that filters take, as recorded. Raises InputError for a setpoint."""
        if self.model.controller is not None:
            raise InputError(f'{self.name}: controller in the model, expected a torque: an '
                             'estimator takes no setpoints')
        require_samples(self.name, self.stamp_ns, self.readings.y)
        return Samples(self.stamp_ns, np.column_stack([self.torque, self.arm_torque]),
                       self.readings.y)

    def uniform(self, weigh: bool = False) -> tuple[UniformRecording, list[str]]:
        """
        Return (recording on even times, repaired and checked, notes without those of the limits).

        Args:
            weigh: whether a wrong look of channels, signs and units is a doubt, and no refusal.

        Raises:
            InputError: it allows no statement about the drive.
        """
        readings = self.readings
        arm = self.arm_torque
        rows, values, repeats = merged(readings.t, np.column_stack([readings.u, readings.y, arm]),
                                       self.repeated)

        def place(row: int, field: str) -> str:
            """Return where the value of field in a row that is left stands."""
            return readings.place(int(rows[row]), field)
        columns = (readings.t[rows], values[:, 0], values[:, 1:3], values[:, 3])
        words = (self.name, place, self.model, self.model.origin.name)
        if weigh:
            recording, notes = prepared(*columns, *words)
            recording, doubts = weighed(recording, self.model)
            notes += doubts
        else:
            recording, notes = admitted(*columns, *words)
        return recording, [*readings.notes, *([repeats] if repeats else []), *notes]


def load_recording(source: Any, model: DriveModel, *, joints: Mapping[str, str] | None = None,
                   topic: str = JOINT_STATES, repeated: str = REPEATED[0],
                   name: str | None = None) -> Recording:
    """
    Return a recording of one drive.

    A table has the columns t (s), torque (N m, or A with a torque_constant in the model; also
    called u) or setpoint (rad, with a controller in the model), motor and arm (rad, both on the
    arm side; one of them is enough) and, where measured, arm_torque (N m). A bag has them as
    JointState, referred to the arm side by the gear ratio of the model.

    Args:
        source: path of a bag folder, an MCAP, CSV or Parquet file; a mapping of arrays [N], a
            DataFrame with these columns; or what `simulate` returns.
        model: of the drive.
        joints: names of the joints in a bag, {'motor': ..., 'arm': ..., 'setpoint': ...}, where
            they are called otherwise; '' for an arm without encoder.
        topic: of the JointState, in bags.
        repeated: what is used of samples with one stamp: first, average or drop.
        name: what messages call the recording, None for its file.

    Returns:
        The recording; `notes` say what of it is not used.

    Raises:
        InputError: naming file or column, value and what was expected.

    >>> import numpy as np
    >>> t = np.arange(1000) * 0.01
    >>> run = load_recording({'t': t, 'torque': np.sin(t), 'motor': 0 * t, 'arm': 0 * t},
    ...                      DriveModel(), name='run1')
    >>> run
    Recording('run1': 1000 samples, 9.99 s, 100 Hz; torque, motor, arm)
    """
    expect_model(model)
    if repeated not in REPEATED:
        raise InputError(f'repeated: {repeated!r}, expected one of {", ".join(REPEATED)}')
    if not isinstance(joints, (Mapping, type(None))):
        raise InputError(f'joints: {joints!r}, expected names by role, as '
                         "{'motor': 'elbow_motor'}")
    for role in joints or {}:
        if role not in ROLES:
            raise InputError(f'joints: {role!r}, {unknown(role, ROLES)}')
    read, usual = _reader(source, model, joints or {}, topic)
    recording = Recording(name or usual, model, read, model.origin.limits, repeated)
    if not len(recording):
        raise InputError(f'{recording.name}: no sample, expected some seconds of them')
    return recording


def _reader(source: Any, model: DriveModel, joints: Mapping[str, str], topic: str
            ) -> tuple[Callable[[DriveModel], Readings], str]:
    """Return (what reads `source` for a model, its name)."""
    if isinstance(source, Trajectory):
        driving = 'u' if model.controller is None else 'setpoint'
        source = {'t': source.t, driving: source.u, 'motor': source.y[:, 0],
                  'arm': source.y[:, 1]}
    if not isinstance(source, (str, Path)):
        return _of_table(_table_columns(source, '', model), ''), 'recording'
    path = expect_path(source, 'source', 'a recording')
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a bag or a CSV file')
    ending = path.name.lower() if path.is_file() else ''
    if ending.endswith(TEXTS):
        return _of_table(read_csv(path), f'{path}: '), str(path)
    if ending.endswith(TABLES):
        table = opened_table(path, 'parquet')
        return _of_table(_table_columns(table, f'{path}: ', model), f'{path}: '), str(path)
    return _of_bag(path, model, joints, topic), str(path)


def _columns_of(source: Any) -> dict[str, Any]:
    """Return {column: values} of a mapping, a pyarrow table or a DataFrame."""
    if isinstance(source, Mapping):
        return {str(name): values for name, values in source.items()}
    names = getattr(source, 'column_names', None) or getattr(source, 'columns', None)
    if names is None or isinstance(source, np.ndarray):
        raise InputError(f'source: {type(source).__name__} {str(source)[:40]!r}, expected a path, '
                         f'or arrays by name: {EXPECTED}')
    return {str(name): source[name] for name in names}


def _table_columns(source: Any, where: str, model: DriveModel) -> CsvColumns:
    """Return the checked columns of a mapping or table; where: its file, in messages."""
    columns = _columns_of(source)
    if 'torque' in columns and 'u' in columns:
        raise InputError(f'{where}torque: beside u, expected one of them')
    if 'torque' in columns:
        columns['u'] = columns.pop('torque')
    driving = 'u' if model.controller is None else 'setpoint'
    missing = [name for name in ('t', driving) if name not in columns]
    if not set(ENCODERS) & set(columns):
        missing.append('motor or arm')
    if missing:
        words = ['torque' if name == 'u' else name for name in missing]
        raise InputError(f'{where}no column {", ".join(words)} in '
                         f'{", ".join(columns)[:80]!r}, expected {EXPECTED}')
    t = _times(columns['t'], f'{where}t')
    values = {name: column(columns[name], where + ('torque' if name == 'u' else name), WORDS[name],
                           len(t)) if name in columns else np.full(len(t), np.nan)
              for name in COLUMNS if name != 't'}
    unseen = all(np.isnan(values[name]).all() for name in ENCODERS)
    for name in (driving, *(name for name in ENCODERS if unseen and name in columns)):
        if np.isnan(values[name]).all():
            raise InputError(f'{where}{"torque" if name == "u" else name}: nan in all {len(t)} '
                             f'samples, expected {WORDS[name]}')
    ignored = [name for name in columns if name not in COLUMNS]
    notes = [f'ignored columns: {", ".join(ignored)}'] if ignored else []
    notes += [f'{name}: nan in all samples, taken as not measured' for name in ENCODERS
              if name in columns and np.isnan(values[name]).all()]

    def place(row: int, name: str) -> str:
        return f'row {row}, column {name}'
    return CsvColumns(t, values['u'], values['setpoint'], values['motor'], values['arm'],
                      values['arm_torque'], place, tuple(notes))


def _times(value: Any, name: str) -> Array:
    """Return times [N] in s, or int64 ns of dates. Raises InputError."""
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.empty(0, object)
    if array.dtype.kind == 'M':
        if np.isnat(array).any():
            raise InputError(f'{name}: row {np.isnat(array).argmax()}: NaT, expected a date')
        return array.astype('datetime64[ns]').astype(np.int64)
    t = column(value, name, WORDS['t'])
    if not len(t):
        raise InputError(f'{name}: no value, expected some seconds of {WORDS["t"]}')
    bad = np.flatnonzero(~np.isfinite(t))
    if len(bad):
        raise InputError(f'{name}: row {bad[0]}: {t[bad[0]]:g}, expected a finite time in s')
    return t


def _of_table(columns: CsvColumns, where: str) -> Callable[[DriveModel], Readings]:
    """Return what gives the readings of `columns` for a model; where: their file, in messages."""
    def read(model: DriveModel) -> Readings:
        notes = list(columns.notices)
        if model.controller is None:
            u = columns.u * model.torque_constant
            if np.isnan(u).all() and not np.isnan(columns.setpoint).all():
                raise InputError(f'{where}column setpoint without u, expected the key controller '
                                 'in the model: it makes a torque of the setpoint')
            if not np.isnan(columns.setpoint).all():
                notes.append('column setpoint is not used: the model has no controller')
        else:
            u = columns.setpoint
            if np.isnan(u).all():
                raise InputError(f'{where}no column setpoint, expected one with the controller in '
                                 'the model; without the key controller (controller: null in '
                                 '--values) the torque u is used')
            if not np.isnan(columns.u).all():
                notes.append('column u is not used: the setpoint drives the controller of the '
                             'model')
        return Readings(columns.t, u, np.column_stack([columns.motor, columns.arm]),
                        columns.arm_torque, columns.place, notes)
    return read


def _of_bag(path: Path, model: DriveModel, names: Mapping[str, str], topic: str
            ) -> Callable[[DriveModel], Readings]:
    """Return what gives the readings of a bag, t in ns, from its measurement topic alone."""
    joints = [names.get(role, role) for role in ROLES]
    with open_bag(path) as reader:
        topic = find_input(reader, topic).topic
        states = reader.joint_states(topic, joints if model.controller else joints[:2])
        notes = [reader.notice] if reader.notice else []

    def place(row: int, field: str) -> str:
        """Return where the value of field in a row stands."""
        return f'{topic}, sample {row}, {FIELDS[field]}'

    def read(drive: DriveModel) -> Readings:
        samples, _ = samples_of(_driving(states, drive, path), drive)
        require_samples(str(path), samples.stamp_ns, samples.y)
        return Readings(samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1], place,
                        list(notes))
    return read


def _driving(states: JointStates, model: DriveModel, path: Path) -> JointStates:
    """Return the joint states with the setpoint for a `model` with a controller, else without."""
    setpoint = len(states.names) > 2
    if model.controller is not None and not setpoint:
        raise InputError(f'{path}: read without setpoint, expected load_recording with the model '
                         'that has a controller')
    if setpoint and model.controller is None:
        return JointStates(states.names[:2], states.stamp_ns, states.log_ns, states.named[:, :2],
                           states.position[:, :2], states.velocity[:, :2], states.effort[:, :2])
    return states


def _within_limits(readings: Readings, limits: FileLimits, model: DriveModel) -> Readings:
    """Return readings with the setpoints that the simulator takes, and notes about limits."""
    notes, (low, high), u = list[str](), limits.setpoints, readings.u
    if model.controller is not None:
        beyond = int(np.count_nonzero((u < low) | (u > high)))
        if beyond:
            u = np.clip(u, low, high)
            notes.append(f'{beyond} setpoints lie beyond ctrlrange ({low:g} to {high:g} rad): '
                         'taken as its ends, as MuJoCo does')
    low, high = limits.travel
    with np.errstate(invalid='ignore'):
        stray = int(np.count_nonzero(((readings.y < low) | (readings.y > high)).any(axis=1)))
    if stray:
        notes.append(f'{stray} samples lie beyond the range of the joint ({low:g} to {high:g} '
                     'rad): its end stops are no part of the model, leave them out')
    return readings._replace(u=u, notes=[*notes, *readings.notes])


def all_of(recordings: Any, model: DriveModel, argument: str = 'recordings'
           ) -> Iterator[Recording | UniformRecording]:
    """
    Return what `load_recording` gave, one or several, each read for a drive.

    Args:
        recordings: one recording or a sequence of them.
        model: of the drive.
        argument: what messages call the recordings.

    Raises:
        InputError: something else, or none.
    """
    kinds = (Recording, UniformRecording)
    if isinstance(recordings, (*kinds, str, bytes, Mapping)) or not hasattr(
            recordings, '__iter__'):
        recordings = (recordings,)
    sequence = tuple(recordings)
    if not sequence:
        raise InputError(f'{argument}: none, expected at least one of load_recording')
    for number, item in enumerate(sequence):
        if not isinstance(item, kinds):
            raise InputError(f'{argument}: {number}: {type(item).__name__} {str(item)[:40]!r}, '
                             'expected a recording, as load_recording returns it')
        yield item.with_model(model) if isinstance(item, Recording) else item
