# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""What is read of each joint in a robot's file, and what is refused and why."""
from dataclasses import dataclass
import math
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.robot.compiled_model import kind_of, mujoco_module, name_of, scalar_joints
from gearbox_monitor.simulators.mjcf_file import (
    drive_in, MjcfDrive, posture_of, RobotFile, values_in)

NONE, TORQUE, SPEED, SERVO = ('none', 'torque', 'speed', 'position')  # what a control is
# value of a JointReading -> its unit on a rotary axis
UNITS = {
    'inertia': 'kg m^2', 'armature': 'kg m^2', 'viscous_friction': 'N m s/rad',
    'coulomb_friction': 'N m', 'weight': 'N m', 'stiffness': 'N m/rad', 'offset': 'N m',
    'gear': '-', 'gain': 'N m per unit of control', 'kp': 'N m/rad', 'kd': 'N m s/rad',
    'limit': 'N m', 'lag': 's', 'delay': 's', 'low': 'rad', 'high': 'rad'}


@dataclass(frozen=True)
class JointReading:
    """
    What is read of a joint: its values, SI units on the joint's side, or why it is refused.

    kind: hinge, slide, ball or free; control: what its actuator takes, of NONE, TORQUE, SPEED,
    SERVO; values {name of UNITS: number}, without those that are off; refusals: one line each;
    notes: what was taken for granted.
    """

    name: str
    kind: str
    control: str
    values: dict[str, float]
    refusals: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def read(self) -> bool:
        """Whether commands take the joint."""
        return not self.refusals

    def units(self) -> dict[str, str]:
        """Return {name of a value: its unit}."""
        axis = 'prismatic' if self.kind == 'slide' else 'rotary'
        return {name: on_axis(UNITS[name], axis) for name in self.values}


def joint_readings(file: RobotFile, keyframe: str | None = None) -> list[JointReading]:
    """
    Return what is read of each joint of a robot's file.

    Args:
        file: compiled.
        keyframe: posture in which the others rest, None for that of the file.

    Returns:
        JointReadings, in the order of the file.

    Raises:
        InputError: no such keyframe.

    """
    m, readings = file.compiled, []
    scalar = scalar_joints(m)
    if scalar:
        posture_of(m, keyframe, file.path)
    for joint in range(m.njnt):
        name = name_of(m, 'joint', joint)
        kind = kind_of(mujoco_module().mjtJoint, m.jnt_type[joint])
        if joint not in scalar:
            readings.append(JointReading(name, kind, NONE, {}, (
                f'type: {kind}, expected hinge or slide',), ()))
        elif not m.joint(joint).name:
            readings.append(JointReading(name, kind, NONE, {}, (
                'name: has none, expected one for --joint',), ()))
        else:
            readings.append(_reading(file, name, kind, keyframe))
    return readings


def _reading(file: RobotFile, name: str, kind: str, keyframe: str | None) -> JointReading:
    try:
        drive = drive_in(file, (name, None), keyframe)
    except InputError as error:
        return JointReading(name, kind, NONE, {}, tuple(
            problem.removeprefix(f'{file.path}: ').removeprefix(f'joint {name}: ')
            for problem in error.args), ())
    refusals = tuple(map(str, drive.refusals()))
    notes = tuple(note.partition(f'joint {name}: ')[2] for note in drive.notes
                  if f'joint {name}: ' in note)
    return JointReading(name, kind, _control(drive), _values(drive), refusals, notes)


def _control(drive: MjcfDrive) -> str:
    own = drive.actuator
    if own is None:
        return NONE
    if own.law is None:
        return TORQUE
    return SERVO if own.law.setpoint else SPEED if own.law.speed else TORQUE


def _values(drive: MjcfDrive) -> dict[str, float]:
    """Return the values of a drive that are not off."""
    values, joint, own = values_in(drive), drive.motor, drive.actuator
    readings = {
        'inertia': joint.inertia, 'armature': joint.armature,
        'viscous_friction': values.motor_damping, 'coulomb_friction': values.motor_friction,
        'weight': abs(values.weight or 0.0), 'stiffness': values.motor_stiffness,
        'offset': values.offset, 'lag': values.lag, 'delay': values.delay,
        'limit': values.servo.limit if values.servo else values.limit}
    if own is not None:
        readings['gear'] = own.gear
        if own.law is not None and not own.law.setpoint:
            readings['gain'] = own.law.gain
    if values.servo is not None:
        readings |= {'kp': values.servo.kp, 'kd': values.servo.kd}
    low, high = joint.travel
    numbers: dict[str, Any] = {name: float(v) for name, v in readings.items()
                               if math.isfinite(v) and abs(v) > 1e-12}
    if math.isfinite(low) and math.isfinite(high):
        numbers |= {'low': low, 'high': high}
    return numbers
