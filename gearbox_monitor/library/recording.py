# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings of all kinds of files, of DataFrames and arrays; a drive's with its model."""
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_log import jump
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.kernels.types import Array, column, Integers
from gearbox_monitor.library.simulator_file import expect_path
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.plant.simulate import Trajectory
from gearbox_monitor.presentation import FileLimits, NO_LIMITS, Paged, Said, said
from gearbox_monitor.recordings.from_bag import recorded_joints
from gearbox_monitor.recordings.joint_input import find_input
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.signals.examine import admitted, kind_of, require_samples
from gearbox_monitor.signals.jumps import counted_on
from gearbox_monitor.signals.recording import (
    ARM, drive_samples, JointSignals, MOTOR, NOT_MEASURED, Recording)
from gearbox_monitor.signals.uniform import prepare, UniformRecording, usable_rows

ROLES = ('motor', 'arm', 'setpoint')  # of joints in a bag
WORDS = {'t': 'time in s', 'u': 'torque in N m, or current in A with torque_constant in the model',
         'setpoint': 'setpoint in rad', 'motor': 'position of the motor in rad, on the arm side',
         'arm': 'position of the arm in rad', 'arm_torque': 'torque on the arm in N m'}
COLUMN = {'u': 'torque'}  # that a user is told of
EXPECTED = 't, torque (or u) or setpoint, motor or arm, arm_torque'
SECOND = 1_000_000_000


@dataclass(frozen=True, eq=False, repr=False)
class DriveRecording(Paged):
    """
    The recording of a drive, as its model refers it to the arm side.

    name: in messages. limits: of the simulator's file that the model is from. arm_side:
    the motor is at the output already, whatever the gear ratio of the model.
    """

    name: str
    recording: Recording
    model: DriveModel
    limits: FileLimits = NO_LIMITS
    arm_side: bool = False

    @cached_property
    def readings(self) -> Samples:
        """The samples [N], with setpoints in place of torques where the model has a controller."""
        model, name = self.model, self.recording.on_side(MOTOR)
        servo = model.controller is not None
        motor = self.recording.joints.get(name or '')
        has = (motor.has('setpoint'), motor.has('effort')) if motor is not None else (True, True)
        if has == (not servo, servo):
            raise InputError(
                f'{self.name}: no setpoint, expected one with the controller in the model; '
                'without the key controller (controller: null in --values) the torque is used'
                if servo
                else f'{self.name}: a setpoint and no torque, expected the key controller in the '
                'model: it makes a torque of the setpoint')
        samples = drive_samples(self.recording, replace(model, gear_ratio=1.0)
                                if self.arm_side else model)
        if model.controller is not None:
            low, high = self.limits.setpoints
            samples = replace(samples, u=np.column_stack(
                [np.clip(samples.u[:, 0], low, high), samples.u[:, 1]]))
        return samples

    def with_model(self, model: DriveModel) -> 'DriveRecording':
        """Return the recording as it is read for the drive `model`."""
        return self if model is self.model else replace(self, model=expect_model(model))

    def __len__(self) -> int:
        return len(self.stamp_ns)

    @property
    def t(self) -> Array:
        """Times [N] from the earliest sample, s."""
        return (self.stamp_ns - self.stamp_ns.min()) / SECOND

    @property
    def stamp_ns(self) -> Integers:
        """Stamps [N] as they are recorded, ns."""
        return self.readings.stamp_ns

    @property
    def torque(self) -> Array:
        """Torque of the motor [N] on the arm side, N m; NaN: a setpoint replaces it."""
        u = self.readings.u[:, 0]
        return u if self.model.controller is None else np.full(len(u), np.nan)

    @property
    def setpoint(self) -> Array:
        """Setpoint [N] of a model with a controller, rad; NaN: a torque drives the model."""
        u = self.readings.u[:, 0]
        return np.full(len(u), np.nan) if self.model.controller is None else u

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
        return self.readings.u[:, 1]

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about columns and values that are not used."""
        limits = self.limits
        notes: list[Said | str] = [*limits.notes, *self.recording.notes]
        motor = self.recording.joints.get(self.recording.on_side(MOTOR) or '')
        if motor is not None and motor.has('setpoint') and motor.has('effort') and (
                self.model.controller is None):
            notes.append(said('setpoint_idle'))
        low, high = limits.setpoints
        if motor is not None and self.model.controller is not None:
            beyond = int(np.count_nonzero((motor.setpoint < low) | (motor.setpoint > high)))
            if beyond:
                notes.append(said('beyond_ctrlrange', count=beyond, low=low, high=high))
        low, high = limits.travel
        with np.errstate(invalid='ignore'):
            y = self.readings.y
            stray = int(np.count_nonzero(((y < low) | (y > high)).any(axis=1)))
        if stray:
            notes.append(said('beyond_travel', count=stray, low=low, high=high))
        return tuple(map(str, notes))

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
        return self.readings

    def uniform(self, weigh: bool = False) -> tuple[UniformRecording, list[str]]:
        """
        Return (recording on even times, repaired and checked, notes).

        Args:
            weigh: whether a doubt about channels, signs and units, or a slip, is weighed, and no
                note.

        Raises:
            InputError: it allows no statement about the drive.
        """
        require_samples(self.name, self.stamp_ns, self.readings.y)
        u, y, turned = self._counted_on()
        rows, repeats = usable_rows(self.stamp_ns)
        recording, notes = admitted(self.stamp_ns[rows], u[rows, 0], y[rows], u[rows, 1],
                                    self.name, self.model, self.model.origin.name)
        remarks = [*self.notes, *turned, *map(str, (
            *repeats, *notes, *self._against_servo(recording, rows, y)))]
        if not weigh:
            remarks += [*map(str, recording.counted_on()), *(
                [recording.doubt.text] if recording.doubt is not None else [])]
        return recording, remarks

    def _against_servo(self, recording: UniformRecording, rows: Integers, y: Array) -> list[Said]:
        """Return what the torque at `rows` of y [N, 2] says of the model's servo, [] without."""
        motor = self.recording.joints.get(self.recording.on_side(MOTOR) or '')
        if recording.servo_torque is None or motor is None or not motor.has('effort'):
            return []
        kind = kind_of(self.model)._replace(setpoint=False)
        try:
            torque = prepare(self.stamp_ns[rows], motor.effort[rows] * self.model.effort_scale,
                             y[rows], kind=kind)[0].u
            servo = recording.servo_torque
            if not np.ptp(torque) or not np.ptp(servo):
                return [said('torque_idle')]
            correlation = float(np.corrcoef(torque, servo)[0, 1])
        except (InputError, ValueError):  # known too seldom, or elsewhere than the setpoint
            return [said('torque_idle')]
        return [said('servo_torque', ratio=float(torque @ servo / (servo @ servo)),
                     correlation=correlation)]

    def _counted_on(self) -> tuple[Array, Array, list[str]]:
        """Return (u, y) of the samples with turns of both encoders counted on, and notes."""
        u, y, notes = self.readings.u.copy(), self.readings.y.copy(), []
        for i, side in enumerate((MOTOR, ARM)):
            y[:, i], turns = counted_on(y[:, i], self.stamp_ns)
            for turn in turns:
                seconds = float(self.stamp_ns[turn.row] - self.stamp_ns[0]) / SECOND
                notes.append(str(jump(turn, seconds, side)))
                if side == MOTOR and self.model.controller is not None:
                    whole = np.abs(y[:, 0] - self.readings.y[:, 0])
                    period = np.min(whole[whole > 0.0])
                    u[:, 0] += period * np.round((y[:, 0] - u[:, 0]) / period)
        return u, y, notes


def load_recording(source: Any, model: Any = None, *, joints: Mapping[str, str] | None = None,
                   topic: str = JOINT_STATES, name: str | None = None,
                   reading: ReadOptions = BY_NAMES) -> Any:
    """
    Return a recording.

    Files of all kinds that docs/import.md lists are read. Arrays and DataFrames have the columns t
    (s), torque (N m, or A with a torque_constant in the model; also called u) or setpoint (rad,
    with a controller in the model), motor and arm (rad, both on the arm side; one of them is
    enough) and, where measured, arm_torque (N m).

    Args:
        source: path of a bag or another file; a mapping of arrays [N], a DataFrame with these
            columns; or a result of `simulate`.
        model: of the drive, or the robot of `load_robot`; None: the recording alone.
        joints: names of the joints in the file: {'motor': ..., 'arm': ..., 'setpoint': ...} of a
            drive, {joint: its name in the log} of a robot, where they are called otherwise; '' for
            an arm without encoder.
        topic: of the JointState, in bags.
        name: of the recording in messages, None for its file.
        reading: how columns are read whose names and units do not say it.

    Returns:
        A DriveRecording for a model of a drive, a RobotLog for a robot, else a Recording.

    Raises:
        InputError: naming file or column, value and the expectation.

    >>> import numpy as np
    >>> t = np.arange(1000) * 0.01
    >>> run = load_recording({'t': t, 'torque': np.sin(t), 'motor': 0 * t, 'arm': 0 * t},
    ...                      DriveModel(), name='run1')
    >>> run
    Recording('run1': 1000 samples, 9.99 s, 100 Hz; torque, motor, arm)
    """
    if not isinstance(joints, (Mapping, type(None))):
        raise InputError(f'joints: {joints!r}, expected names by role, as '
                         "{'motor': 'elbow_motor'}")
    if hasattr(model, 'read_log'):  # a robot
        return model.read_log(source, joints, topic, reading)
    for role in joints or {}:
        if role not in ROLES:
            raise InputError(f'joints: {role!r}, {unknown(role, ROLES)}')
    if model is not None:
        expect_model(model)
    recording, arm_side = _read(source, model, dict(joints or {}), topic, reading)
    if model is None:
        return recording if name is None else replace(recording, name=name)
    result = DriveRecording(name or recording.name, recording, model, model.origin.limits,
                            arm_side)
    if not len(result):
        raise InputError(f'{result.name}: no sample, expected some seconds of them')
    return result


def _read(source: Any, model: DriveModel | None, joints: dict[str, str], topic: str,
          reading: ReadOptions) -> tuple[Recording, bool]:
    """Return (recording of `source`, whether its motor is at the output whatever the model)."""
    if isinstance(source, Trajectory):
        driving = 'setpoint' if model is not None and model.controller is not None else 'u'
        source = {'t': source.t, driving: source.u, 'motor': source.y[:, 0],
                  'arm': source.y[:, 1]}
    if not isinstance(source, (str, Path)):
        return _of_arrays(source, model), True
    path = expect_path(source, 'source', 'a recording')
    with open_recording(path, reading, topic) as reader:
        name = find_input(reader, topic).topic
        names = {role: joints.get(role, role) for role in ROLES}
        whole = model is None and not joints
        present = reader.joint_names(name, None if whole else list(names.values()))
        if whole:
            return recorded_joints(reader, name, present), False
        if not joints and len(present) == 1:
            names.update(motor=present[0], arm='')
        setpoint = names['setpoint'] if names['setpoint'] in present or 'setpoint' in joints \
            else ''
        sides = [MOTOR, ARM] if names['arm'] else [MOTOR]
        return recorded_joints(reader, name, [names[side] for side in sides], sides,
                               setpoint), reader.arm_side


def _of_arrays(source: Any, model: DriveModel | None) -> Recording:
    """Return the recording in a mapping, a pyarrow table or a DataFrame."""
    names = list(source) if isinstance(source, Mapping) else getattr(
        source, 'column_names', None) or getattr(source, 'columns', None)
    if names is None or isinstance(source, np.ndarray):
        raise InputError(f'source: {type(source).__name__} {str(source)[:40]!r}, expected a path, '
                         f'or arrays by name: {EXPECTED}')
    columns = {str(name): source[name] for name in names}
    if 'torque' in columns and 'u' in columns:
        raise InputError('torque and u: both given, expected one of them')
    if 'torque' in columns:
        columns['u'] = columns.pop('torque')
    driving = 'u' if model is None or model.controller is None else 'setpoint'
    missing = [name for name in ('t', driving) if name not in columns]
    if not {'motor', 'arm'} & set(columns):
        missing.append('motor or arm')
    if missing:
        raise InputError(f'no column {", ".join(COLUMN.get(name, name) for name in missing)} in '
                         f'{", ".join(columns)[:80]!r}, expected {EXPECTED}')
    stamps = _stamps(columns['t'])
    values = {name: column(columns[name], COLUMN.get(name, name), WORDS[name], len(stamps))
              for name in WORDS if name in columns and name != 't'}
    sides = [name for name in ('motor', 'arm') if name in values]
    empty = [name for name in (driving, *sides) if np.isnan(values[name]).all()]
    if empty and (empty[0] == driving or empty == sides):
        raise InputError(f'{COLUMN.get(empty[0], empty[0])}: nan in all {len(stamps)} samples, '
                         f'expected {WORDS[empty[0]]}')
    ignored = [name for name in columns if name not in WORDS]
    notes = [f'ignored columns: {", ".join(ignored)}'] if ignored else []
    notes += [f'{name}: nan in all samples, taken as not measured' for name in empty]
    return Recording('recording', {
        'motor': JointSignals(stamps, values.get('motor', NOT_MEASURED), side=MOTOR,
                              setpoint=values.get('setpoint', NOT_MEASURED),
                              effort=values.get('u', NOT_MEASURED)),
        'arm': JointSignals(stamps, values.get('arm', NOT_MEASURED), side=ARM, measured=True,
                            effort=values.get('arm_torque', NOT_MEASURED))}, tuple(notes))


def _stamps(value: Any) -> Integers:
    """Return stamps [N] in ns of times in s or of dates. Raises InputError."""
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.empty(0, object)
    if array.dtype.kind == 'M':
        if np.isnat(array).any():
            raise InputError(f't: row {np.isnat(array).argmax()}: NaT, expected a date')
        return array.astype('datetime64[ns]').astype(np.int64)
    t = column(value, 't', WORDS['t'])
    if not len(t):
        raise InputError(f't: no value, expected some seconds of {WORDS["t"]}')
    bad = np.flatnonzero(~np.isfinite(t) | (np.abs(t) > 9e9))
    if len(bad):
        raise InputError(f't: row {bad[0]}: {t[bad[0]]:g}, expected a finite time in s')
    return np.rint((t - t.min()) * SECOND).astype(np.int64) + SECOND


def all_of(recordings: Any, model: DriveModel, argument: str = 'recordings'
           ) -> Iterator[DriveRecording | UniformRecording]:
    """
    Return recordings of `load_recording`, one or several, each read for a drive.

    Args:
        recordings: one recording or a sequence of them.
        model: of the drive.
        argument: name of the recordings in messages.

    Raises:
        InputError: something else, or none.
    """
    kinds = (DriveRecording, UniformRecording)
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
        yield item.with_model(model) if isinstance(item, DriveRecording) else item
