# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Admission of a recording to the diagnosis: repaired and checked against the model."""
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.signals.input_checks import check
from gearbox_monitor.signals.jumps import strangers
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.stamps import burst_size
from gearbox_monitor.signals.uniform import Doubt, prepare, RecordingKind, UniformRecording
from gearbox_monitor.signals.unphysical import is_uninitialised, physical_columns

# Faults of channels, signs and units, which say how the data would have to be read.
READ_OTHERWISE = ('sign', 'swapped', 'units')
# What the model file of a drive with one encoder must have.
ONE_ENCODER = ('transmission.kind: rigid, or dead_zone with driven_by: torque and '
               'process_torque_time: 0')


def require_samples(name: str, stamp_ns: Integers, y: Array) -> None:
    """
    Refuse messages that are no samples of one drive, with what makes them some.

    Args:
        name: name of the recording in messages.
        stamp_ns: header stamps, int64 [N].
        y: readings of motor and arm [N, 2], rad; NaN: not measured.

    Raises:
        InputError: no message is stamped, or motor and arm never stand in one message.
    """
    if len(stamp_ns) > 1 and (stamp_ns <= 0).all():
        raise InputError(f'{name}: {unstamped(len(stamp_ns))}')
    foreign = strangers(y, stamp_ns)
    if foreign.any():
        first = float(stamp_ns[foreign][0] - stamp_ns[0]) * 1e-9
        raise InputError(f'{name}: the positions jump to one posture and back {foreign.sum()} '
                         f'times, first at {first:.4g} s: two publishers on one topic, expected '
                         'those of the drive alone: stop the second one, then record')
    if two_publishers(y):
        raise InputError(f'{name}: motor and arm are never in one message: two publishers on one '
                         'topic, expected arm_topic (docs/ros.md), or for this recording '
                         'gearbox_monitor import BAG --arm-topic joint_states NEW')


def measured_samples(samples: Samples, name: str) -> tuple[Samples, list[str]]:
    """
    Return the samples of a recording without unphysical numbers, and notes about them.

    Args:
        samples: of one drive.
        name: name of the recording in messages.

    Raises:
        InputError: they are no samples of one drive.
    """
    require_samples(name, samples.stamp_ns, samples.y)
    u, of_efforts = physical_columns(samples.u)
    y, of_positions = physical_columns(samples.y)
    if is_uninitialised(samples.u[:, 0]):
        raise InputError(f'{name}: effort of the motor: uninitialised memory, the largest amount '
                         f'is {np.nanmax(np.abs(samples.u[:, 0])):.2g}, expected a torque')
    if not of_efforts + of_positions:
        return samples, []
    return Samples(samples.stamp_ns, u, y, samples.joints), [
        f'{of_efforts} efforts and {of_positions} positions are infinite, beyond 1e9 or '
        'uninitialised memory: they count as not measured']


def unstamped(count: int) -> str:
    """Return what to say of `count` messages without a header stamp."""
    return (f'all {count} header stamps are 0: the driver does not stamp its messages, expected '
            'times of measurement; gearbox_monitor import BAG --stamps received NEW takes the '
            'times of receipt')


def two_publishers(y: Array) -> bool:
    """Return whether motor and arm, y [N, 2] (NaN: not measured), come in separate messages."""
    motor, arm = np.isfinite(y).T
    few = max(LIMITS.least_apart, LIMITS.one_message * len(motor))
    return bool(min(motor.sum(), arm.sum()) >= few and (motor & arm).sum()
                <= LIMITS.one_message * len(
        motor))


def takes_one_encoder(model: DriveModel) -> bool:
    """
    Return whether a diagnosis of the drive `model` can do without one of the encoders.

    Behind an elastic gear it takes the filter of the innovations, which carries the hidden side.
    """
    return model.transmission.kind == 'rigid' or (
        model.transmission.kind == 'dead_zone' and model.driven_by == 'torque'
        and model.process_torque_time == 0.0)


def kind_of(model: DriveModel) -> RecordingKind:
    """Return what a recording of the drive `model` is."""
    return RecordingKind(takes_one_encoder(model), model.axis, model.controller is not None)


def admitted(t: Array | Integers, u: Array, y: Array, arm_torque: Array | None, name: str,
             place: Callable[[int, str], str] | None, model: DriveModel,
             model_name: str) -> tuple[UniformRecording, list[str]]:
    """
    Return (Recording, notes) of readings that suit a verdict on the drive.

    Args:
        t: stamps [N], s, or integer ns.
        u: torque [N], N m, or setpoint, rad, of a model with a controller; NaN: not measured.
        y: readings of motor and arm [N, 2], rad.
        arm_torque: torque measured on the arm [N], N m, or None.
        name: name of the recording in messages.
        place: function (row, field) that says where a value stands.
        model: model of the drive.
        model_name: name of the model in messages.

    Raises:
        InputError: see prepared; or channels, signs, units or motion allow no verdict.
    """
    recording, notes = prepared(t, u, y, arm_torque, name, place, model, model_name)
    problems = check(recording, model)
    fatal = [problem.text for problem in problems if problem.fatal]
    if fatal:
        raise InputError(f'{name}: ' + '; '.join(fatal))
    return recording, [*notes, *(problem.text for problem in problems)]


def prepared(t: Array | Integers, u: Array, y: Array, arm_torque: Array | None, name: str,
             place: Callable[[int, str], str] | None, model: DriveModel,
             model_name: str) -> tuple[UniformRecording, list[str]]:
    """
    Return (Recording, notes) of readings; see recording.prepare.

    arm_torque: [N] N m as measured, used with arm_load: measured in the DriveModel `model` only;
    None or NaN = not measured. name, model_name: what messages call the recording and the model.
    Raises InputError, also where no verdict on the drive is possible.

    Args:
        t: stamps [N], s, or integer ns.
        u: torque [N], N m, or setpoint, rad, of a model with a controller; NaN: not measured.
        y: readings of motor and arm [N, 2], rad.
        arm_torque: torque measured on the arm [N], N m, or None.
        name: name of the recording in messages.
        place: function (row, field) that says where a value stands.
        model: model of the drive.
        model_name: name of the model in messages.
    """
    notes = []
    stamps = np.asarray(t)
    burst = burst_size(stamps.astype(np.int64)) if stamps.dtype.kind == 'i' and len(t) else 1
    if burst > 1:
        raise InputError(f'{name}: stamped in bursts of {burst} on receipt, expected even stamps: '
                         'gearbox_monitor import BAG --stamps even NEW lays an even grid through '
                         'them')
    measured = arm_torque is not None and np.isfinite(arm_torque).any()
    if model.arm_load == 'measured' and not measured:
        raise InputError(f'{name}: no {on_axis("torque", model.axis)} measured on the arm, '
                         f'expected one (effort of the arm), as {model_name} states arm_load: '
                         'measured')
    if model.arm_load != 'measured':
        if measured and arm_torque is not None and np.nanmax(np.abs(arm_torque)) > 0.0:
            notes.append(on_axis('the torque measured on the arm is not used: ', model.axis)
                         + f'arm_load in {model_name} is {model.arm_load}, not measured')
        arm_torque = None
    missing = [side for side, column in zip(('motor', 'arm'), np.asarray(y, float).T)
               if np.isnan(column).all()]
    if len(missing) == 1 and not takes_one_encoder(model):
        raise InputError(f'{name}: {missing[0]}: never measured, expected both encoders, or in '
                         f'{model_name} {ONE_ENCODER}')
    recording, repaired = prepare(t, u, y, arm_torque, name, place, kind_of(model))
    return recording.with_servo(model.controller), [*notes, *repaired]


def weighed(recording: UniformRecording, model: DriveModel
            ) -> tuple[UniformRecording, list[str]]:
    """
    Return (recording with what speaks for another reading of it, notes).

    A strong effect may look like a wrong sign or unit. What channels, signs and units look like
    is a doubt here: the diagnosis refuses a recording only if it is likelier as the doubt reads
    it than with any effect.

    Args:
        recording: of the drive, as prepared has it.
        model: model of the drive.

    Raises:
        InputError: other defects allow no verdict.
    """
    problems = check(recording, model)
    fatal = [p.text for p in problems
             if p.fatal and p.code not in (*READ_OTHERWISE, 'implausible')]
    if fatal:
        raise InputError(f'{recording.name}: ' + '; '.join(fatal))
    doubts = [Doubt(p.text, bool(p.values.get('swap', 0.0)),
                    (p.values.get('motor', 1.0), p.values.get('arm', 1.0)),
                    p.values.get('torque', 1.0)) for p in problems if p.code in READ_OTHERWISE]
    return (replace(recording, doubt=doubts[0] if doubts else None),
            [p.text for p in problems if p.code not in READ_OTHERWISE])
