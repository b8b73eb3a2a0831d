# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a drive into an MJCF file: the smallest edits that make the file move like the model.

Two joints in the file take the model as it is. One joint takes a rigid model; for one with a
transmission it becomes the joint of the arm, and a body without shape, the rotor, gets that of the
motor: the actuator moves there, and a tendon holds both together.
"""
import cmath
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.transmission import FrictionLaw, IMPEDANCES
from gearbox_monitor.robot.compiled_model import moved_by, mujoco_module
from gearbox_monitor.simulators.file_edits import (
    about_axis, across, balanced, compiled_body, MjcfEdits, number, SAME, same, Splice, titled,
    TURN)
from gearbox_monitor.simulators.mjcf import (
    ARM, COGGING, constant_load, Exported, LUGRE, MjcfValues, MOTOR, Passive, steady, TENDON)
from gearbox_monitor.simulators.mjcf_file import (
    drive_of, MjcfActuator, MjcfDrive, MjcfJoint, values_in, weight)
from gearbox_monitor.simulators.xml_edit import behind, words_of, XmlElement

# Regularised Coulomb friction: a ramp up to this many 1 / sharpness is nearest to the arctangent
# over motions of some hundred of them.
RAMP = {'atan': 5.0, 'tanh': 1.5}
IMPEDANCE = 1e-3  # of the friction constraint: at small ones it is a function of speed alone
ROTOR = 'mass="1e-6" diaginertia="1e-12 1e-12 1e-12"'


@dataclass(frozen=True)
class Patch:
    """The bytes of a patched file, its changes, and what the model's effects became."""

    data: bytes
    changes: tuple[Splice, ...]
    exported: tuple[Exported, ...]
    joints: tuple[str, str | None]


def patched(drive: MjcfDrive, values: MjcfValues, exported: Sequence[Exported]) -> Patch:
    """
    Return the Patch that gives a drive in a file the values of a model.

    Args:
        drive: in the file.
        values: of the model.
        exported: what the effects of the model became.

    Returns:
        The Patch; MuJoCo has compiled it, and its joints have the values of the model.

    Raises:
        InputError: the file and the model do not fit each other.

    """
    if drive.document.root.tag != 'mujoco':
        raise InputError(f'{drive.path}: a URDF file, expected MJCF with --to mjcf')
    if values.rigid and drive.arm is not None:
        raise InputError(f'{drive.path}: joints {drive.motor.name}, {drive.arm.name}: two, '
                         'expected one joint for a model with transmission.kind: rigid')
    patch = _patch(drive, values, exported)
    compiled = _again(patch, drive)
    if not _actuators_agree(drive, values, compiled):
        # The compiler derives gains from the inertia (dampratio): write them out.
        patch = _patch(drive, values, exported, pinned=True)
        compiled = _again(patch, drive)
    _verify(compiled, drive, values)
    return patch


def _patch(drive: MjcfDrive, values: MjcfValues, exported: Sequence[Exported],
           pinned: bool = False) -> Patch:
    """Return the Patch, see patched; `pinned` writes out the gains of the actuator."""
    edits = MjcfEdits(drive.document, drive.compiled)
    names: tuple[str, str | None] = (drive.motor.name, drive.arm.name if drive.arm else None)
    if values.rigid:
        _one_joint(edits, drive, values)
    elif drive.arm is None:
        names = _with_rotor(edits, drive, values)
    else:
        _two_joints(edits, drive, values)
    _inertial(edits, drive, values)
    _tendons(edits, drive, values, names)
    _actuator(edits, drive, values, names[0], pinned)
    _passives(edits, drive, values, names)
    _sensors(edits, drive, values, names)
    return Patch(edits.patched(), tuple(edits.changes), tuple(exported), names)


def _again(patch: Patch, drive: MjcfDrive) -> MjcfDrive:
    """Return the drive in a patched file."""
    return drive_of(patch.data, drive.path, patch.joints, drive.keyframe,
                    drive.actuator.name or None if drive.actuator else None)


# ---------------------------------------------------------------------- joints


def _friction(drive: MjcfDrive, friction: float, values: MjcfValues, inertia: float,
              on_arm: bool = False) -> dict[str, str]:
    """
    Return the attributes of Coulomb friction: a constraint that is nearly a function of speed.

    MuJoCo's force is d (tau + M b v) within +-frictionloss, d the impedance, tau all other torque.
    Other laws that are constraints have their own d and b.
    """
    law, sharpness = values.law, values.sharpness[on_arm]
    if friction == 0.0:
        return {'frictionloss': '0'}
    if law.constraint:
        if law.kind != 'mujoco':  # the joint stands after a step
            law = FrictionLaw('mujoco', (2.0 * drive.timestep, 1.0), (IMPEDANCES[1],) * 2)
        return {'frictionloss': number(friction), 'solreffriction': number(*law.solref),
                'solimpfriction': number(*law.solimp)}
    # The constraint is explicit in the speed: within a step it must not reverse it.
    speed = max(RAMP[law.kind] / sharpness, friction * drive.timestep / inertia)
    slope = friction / (inertia * speed)
    return {'frictionloss': number(friction), 'solreffriction': f'-1 {number(-slope)}',
            'solimpfriction': number(IMPEDANCE, IMPEDANCE)}


def _put_joint(edits: MjcfEdits, drive: MjcfDrive, joint: MjcfJoint, target: Mapping[str, float],
               of: MjcfValues, on_arm: bool = False) -> None:
    """Edit what of a joint differs from `target` {armature, damping, frictionloss, stiffness}."""
    current = {'armature': joint.armature, 'damping': joint.damping,
               'stiffness': joint.stiffness}
    own = {'armature': target['armature'], 'damping': target['damping'] - joint.actuator_damping,
           'stiffness': target['stiffness'] - joint.actuator_stiffness}
    where = f'{drive.path}: joint {joint.name}'
    inertia = (of.motor_inertia + of.arm_inertia if of.rigid
               else of.arm_inertia if on_arm else of.motor_inertia)
    if own['armature'] < -SAME * inertia:
        raise InputError(f'{where}: armature: would be {own["armature"]:.4g}, expected a model '
                         'whose inertia is at least that of the body and of the actuator')
    if own['damping'] < 0.0:
        raise InputError(f'{where}: damping: would be {own["damping"]:.4g}, expected at least 0: '
                         'the model has less viscous friction than the actuator in the file')
    m = drive.compiled
    # Higher coefficients stay.
    higher = {'armature': (), 'damping': m.dof_dampingpoly[m.jnt_dofadr[joint.index]],
              'stiffness': m.jnt_stiffnesspoly[joint.index]}
    values = {name: number(max(0.0, value), *(higher[name] if np.any(higher[name]) else ()))
              for name, value in own.items() if not same(target[name], current[name])}
    values |= _friction(drive, target['frictionloss'], of, inertia, on_arm)
    if same(target['frictionloss'], joint.frictionloss):
        del values['frictionloss']
    if joint.law == of.law:
        values.pop('solreffriction', None)
        values.pop('solimpfriction', None)
    if values:
        edits.put(edits.joint(joint.index), values)


def _one_joint(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues) -> None:
    """Edit the one joint of a rigid drive, whose inertias count in sum."""
    joint, armature = drive.motor, values.motor_inertia
    if drive.half_of_inertia:
        armature = max(0.0, values.motor_inertia - values_in(drive).motor_inertia)
    _put_joint(edits, drive, joint, {
        'armature': armature, 'damping': values.motor_damping + values.arm_damping,
        'frictionloss': values.motor_friction + values.arm_friction,
        'stiffness': values.motor_stiffness}, values)


def _two_joints(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues) -> None:
    motor, arm = drive.motor, drive.arm_joint
    _put_joint(edits, drive, motor, {
        'armature': values.motor_inertia - motor.inertia, 'damping': values.motor_damping,
        'frictionloss': values.motor_friction, 'stiffness': values.motor_stiffness}, values)
    _put_joint(edits, drive, arm, _of_arm(values, arm.armature, arm.stiffness), values,
               on_arm=True)


def _of_arm(values: MjcfValues, armature: float, stiffness: float) -> dict[str, float]:
    return {'armature': armature, 'damping': values.arm_damping,
            'frictionloss': values.arm_friction, 'stiffness': stiffness}


def _with_rotor(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues) -> tuple[str, str]:
    """Add the rotor's body and joint; return the names of the joints of motor and arm."""
    joint = drive.motor
    document, m = drive.document, drive.compiled
    body = edits.body(m.jnt_bodyid[joint.index])
    if len(body.all('joint')) != 1:
        raise InputError(f'{drive.path}: line {body.line}: {titled(body)}: several joints, '
                         'expected one for a rotor beside it')
    name = f'{joint.name}_motor'
    names = {e.attributes.get('name') for e in document.root.walk()}
    if name in names:
        raise InputError(f'{drive.path}: {name}: the name is taken, expected it to be free for '
                         'the joint of the motor')
    _put_joint(edits, drive, joint, _of_arm(values, 0.0, 0.0), values, on_arm=True)
    place = ''.join(f' {key}="{value}"' for key, value in body.attributes.items()
                    if key in ('pos', *TURN))
    friction = words_of(_friction(drive, values.motor_friction, values, values.motor_inertia))
    kind = 'slide' if joint.slide else 'hinge'
    edits.insert(behind(document, body, f"""\
<body name="{name}"{place}>
  <inertial pos="0 0 0" {ROTOR}/>
  <joint name="{name}" type="{kind}" pos="{number(*m.jnt_pos[joint.index])}"
         axis="{number(*m.jnt_axis[joint.index])}" limited="false" ref="0" springref="0"
         armature="{number(values.motor_inertia)}" damping="{number(values.motor_damping)}"
         stiffness="{number(values.motor_stiffness)}"
         {friction}/>
</body>"""), f'body "{name}"', 'new, with the joint of the motor')
    _keyframes(edits, drive, joint)
    return name, joint.name


def _keyframes(edits: MjcfEdits, drive: MjcfDrive, joint: MjcfJoint) -> None:
    """Give the postures in keyframes the value of the motor's joint."""
    m = drive.compiled
    last = np.flatnonzero(moved_by(m, joint.index)[m.jnt_bodyid])[-1]
    place, own = m.jnt_qposadr[last] + 1, m.jnt_qposadr[joint.index]
    if m.jnt_type[last] == int(mujoco_module().mjtJoint.mjJNT_BALL):
        place += 3
    for part in drive.document.root.all('keyframe'):
        for key in part.all('key'):
            row = key.attributes.get('qpos', '').split()
            if row:
                row += ['0'] * (m.nq - len(row))  # as MuJoCo fills it up
                edits.put(key, {'qpos': ' '.join([*row[:place], row[own], *row[place:]])})
            if key.attributes.get('qvel') or key.attributes.get('act'):
                raise InputError(f'{drive.path}: line {key.line}: {titled(key)}: qvel or act, '
                                 'expected only qpos where a joint is added')


# ---------------------------------------------------------------------- inertia and weight


def _inertial(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues) -> None:
    """Give the arm's body the inertia about its joint, and the weight, of the model."""
    joint = drive.arm_joint
    # What the joint's own armature adds stays with it, unless it was that of the motor.
    own = joint.armature if drive.arm is not None else 0.0
    heavier = values.arm_inertia - own - joint.inertia
    if drive.half_of_inertia and values.rigid:
        present = values_in(drive)
        heavier = values.arm_inertia - present.arm_inertia + min(
            0.0, values.motor_inertia - present.motor_inertia)
    own_weight = None  # over what the joint reads now, before its zero moves
    if values.weight is not None:
        own_weight = values.weight * cmath.rect(1.0, -values_in(drive).zero)
    moved = own_weight is not None and not same(own_weight, weight(drive))
    if abs(heavier) <= SAME * values.arm_inertia and not moved:
        return
    m, index = drive.compiled, int(drive.compiled.jnt_bodyid[joint.index])
    axis, anchor, body = m.jnt_axis[joint.index], m.jnt_pos[joint.index], compiled_body(m, index)
    if joint.slide:
        factor = (body.mass + heavier) / body.mass
        body = body._replace(mass=body.mass + heavier, tensor=body.tensor * factor)
    else:
        target = about_axis(body, axis, anchor) + heavier
        if target <= 0.0:
            raise InputError(f'{drive.path}: joint {joint.name}: inertia: what the body carries '
                             f'has more than the {values.arm_inertia:.4g} kg m^2 of the model')
        moment = None
        if moved and own_weight is not None:
            moment = body.mass * across(body.centre - anchor, axis) + _added_moment(
                drive, own_weight)
        body = balanced(body, axis, anchor, target, moment)
    edits.put_body(index, body)


def _added_moment(drive: MjcfDrive, target: complex) -> Array:
    """Return mass times lever (kg m) that the body lacks for the weight `target` (N m)."""
    mujoco, m, joint = mujoco_module(), drive.compiled, drive.arm_joint
    state = mujoco.MjData(m)
    state.qpos[:] = drive.posture
    state.qpos[m.jnt_qposadr[joint.index]] = 0.0
    mujoco.mj_forward(m, state)
    body = m.jnt_bodyid[joint.index]
    turn = state.xmat[body].reshape(3, 3)
    down = turn.T @ m.opt.gravity
    axis = m.jnt_axis[joint.index]
    down = across(down, axis)
    size = float(np.linalg.norm(down))
    if size < 1e-6:
        raise InputError(f'{drive.path}: joint {joint.name}: gravity acts along its axis or is '
                         'off, expected one that the weight of the model can come from')
    com = turn.T @ (state.subtree_com[body] - state.xanchor[joint.index])
    present = float(m.body_subtreemass[body]) * across(com, axis)
    return (target.real * down + target.imag * np.cross(axis, down)) / size ** 2 - present


# ---------------------------------------------------------------------- tendon, actuator, sensors


def _tendons(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues,
             names: tuple[str, str | None]) -> None:
    if values.rigid:
        return
    tendon = drive.tendon
    sign = tendon.sign if tendon else 1.0
    ends = sorted(sign * (edge - values.zero) for edge in (-values.half_gap, values.half_gap))
    attributes = {'springlength': number(*ends),
                  'stiffness': number(values.stiffness, 0.0, values.cubic) if values.cubic
                  else number(values.stiffness), 'damping': number(values.damping)}
    joints = f'  <joint joint="{names[0]}" coef="1"/>\n  <joint joint="{names[1]}" coef="-1"/>\n'
    if tendon is None:
        edits.add('tendon', f'tendon "{names[1]}_gearbox"',
                  f'<fixed name="{names[1]}_gearbox" {words_of(attributes)}>\n{joints}</fixed>')
    else:
        if same(ends[0], tendon.low) and same(ends[1], tendon.high):
            del attributes['springlength']
        if all(map(same, (values.stiffness, 0.0, values.cubic), tendon.stiffness)):
            del attributes['stiffness']
        if same(values.damping, tendon.damping):
            del attributes['damping']
        if attributes:
            edits.put(edits.listed('tendon', tendon.index), attributes)
    present = values_in(drive).yielding
    if values.yielding and present:
        elastic = drive.hysteresis
        if elastic is not None and not all(map(same, values.yielding, present)):
            edits.put(edits.listed('tendon', elastic.index), {
                'stiffness': number(values.yielding[0]),
                'springyield': number(values.yielding[1])})
    elif values.yielding:
        edits.add('tendon', f'tendon "{names[1]}_hysteresis"',
                  f'<fixed name="{names[1]}_hysteresis" springlength="0 0" '
                  f'stiffness="{number(values.yielding[0])}" '
                  f'springyield="{number(values.yielding[1])}">\n{joints}</fixed>')


class _Force(NamedTuple):
    """
    Force of an actuator before its gear: gain c + bias, its limits, what c passes before.

    bias: constant, over length and speed; span: limit of the force beside its constant; control:
    of c; lag, delay: s.
    """

    gain: float
    bias: tuple[float, float, float]
    span: float
    control: float
    lag: float
    delay: float


def _forces(drive: MjcfDrive, values: MjcfValues) -> tuple[_Force, _Force]:
    """Return the force of the actuator in the file, and the one that `values` ask for."""
    a = drive.actuator
    assert a is not None
    present, size = values_in(drive), abs(a.gear)
    passive = present.offset - a.gear * a.bias[0]  # springs, other actuators, a slide's weight
    constant = (values.offset - passive) / a.gear
    gain, bias = a.gain * values.gain, (a.bias[1], a.bias[2])
    law = a.law
    span, control = math.inf, math.inf
    if values.servo is not None:
        kp, kd, limit = values.servo
        gain = values.gain * kp / size ** 2
        bias, span = (-gain, -values.gain * kd / size ** 2), values.gain * limit / size
    elif a.setpoint and law is not None and law.setpoint:
        # A torque was measured, and the servo that made it is scaled as a whole.
        bias = values.gain * a.bias[1], values.gain * a.bias[2]
        span = values.gain * (present.servo.limit if present.servo else math.inf) / size
    elif values.lag:
        control = values.limit / (size * a.gain)
    else:
        span = values.gain * values.limit / size
    was = present.servo.limit if present.servo else present.limit
    existing = _Force(a.gain, a.bias, math.inf if present.lag and not present.servo
                      else was / size, was / (size * a.gain) if present.lag and not present.servo
                      else math.inf, law.lag if law else 0.0, law.delay if law else 0.0)
    return existing, _Force(gain, (constant, *bias), span, control, values.lag,
                            values.delay)


def _agree(first: _Force, second: _Force) -> bool:
    """Return whether two forces are the same but for rounding."""
    small = 1e-9 * max(abs(first.gain), 1.0)
    return all(same(a, b) or math.isfinite(a - b) and abs(a - b) <= small for a, b in zip(
        (first.gain, *first.bias, *first[2:]), (second.gain, *second.bias, *second[2:])))


def _actuators_agree(drive: MjcfDrive, values: MjcfValues, again: MjcfDrive) -> bool:
    """Return whether the actuator of a patched drive is what `values` ask for."""
    if drive.actuator is None or again.actuator is None:
        return True
    target = _forces(drive, values)[1]
    return all(same(a, b) or abs(a - b) <= 1e-6 * max(1.0, abs(a)) for a, b in zip(
        (target.gain, *target.bias), (again.actuator.gain, *again.actuator.bias)))


def _actuator(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues, motor: str,
              pinned: bool) -> None:
    a = drive.actuator
    if a is None:
        plain = (values.gain == 1.0 and not values.lag and not values.delay
                 and math.isinf(values.limit) and values.servo is None)
        if plain and same(values.offset, values_in(drive).offset):
            return
        raise InputError(f'{drive.path}: joint {drive.motor.name}: no actuator acts on it, '
                         'expected one')
    present, target = _forces(drive, values)
    attributes: dict[str, str | None] = {}
    moved = motor != drive.motor.name
    changed = pinned or not _agree(present, target) or (
        moved and math.isfinite(drive.motor.force[1]))
    late = a.setpoint and values.servo is None and bool(values.lag or values.delay)
    if not (moved or changed or late):
        return
    element = edits.listed('actuator', a.index)
    where = _place(drive, element, a)
    if late:
        raise InputError(f'{where}: follows a setpoint, and lag or delay of a torque would act on '
                         'that; expected a motor')
    if moved:
        attributes |= {'joint': motor}
        attributes |= _inherited(drive, element, a)
    if changed:
        attributes |= _of_actuator(drive, element, (present, target), pinned)
        if math.isfinite(drive.motor.force[1]) and not same(present.span, target.span):
            limit = target.span * abs(a.gear)
            edits.put(edits.joint(drive.motor.index), {
                'actuatorfrcrange': number(-limit, limit) if math.isfinite(limit) else None})
    general = {'gainprm', 'biasprm', 'dyntype'} & set(attributes)
    if general and element.tag in ('dcmotor', 'pid'):
        raise InputError(f'{where}: a {element.tag}, whose force is not that of the model, '
                         'expected motor, general or position')
    if general:
        attributes['inheritrange'] = None
    edits.put(element, attributes, 'general' if general else '')


def _place(drive: MjcfDrive, element: XmlElement, a: MjcfActuator) -> str:
    """Return the place of an actuator, for messages."""
    return f'{drive.path}: line {element.line}: actuator {a.name}'


def _inherited(drive: MjcfDrive, element: XmlElement, a: MjcfActuator) -> dict[str, str | None]:
    """Return the range of controls that an actuator has from its joint, which it leaves."""
    m = drive.compiled
    place = int(m.actuator_ctrladr[a.index])
    if element.tag not in ('position', 'intvelocity') or not m.actuator_ctrllimited[place]:
        return {}
    span = number(*m.actuator_ctrlrange[place])
    return {'inheritrange': '0', 'ctrllimited': 'true', 'ctrlrange': span}


def _of_actuator(drive: MjcfDrive, element: XmlElement, forces: tuple[_Force, _Force],
                 pinned: bool) -> dict[str, str | None]:
    """Return the attributes that turn the force of an actuator into the second of `forces`."""
    a, (present, target) = drive.actuator, forces
    assert a is not None
    where = _place(drive, element, a)
    servo = target.bias[1] != 0.0
    if a.dynamics not in ('none', 'filter', 'filterexact'):
        raise InputError(f'{where}: dyntype {a.dynamics}, expected none for a lag')
    out: dict[str, str | None] = {}
    gains = (present.gain, *present.bias), (target.gain, *target.bias)
    lags = same(present.lag, target.lag)
    if pinned or not lags or not all(map(same, *gains)):
        if element.tag == 'position' and servo and lags and not target.lag and (
                abs(target.bias[0]) <= SAME * target.gain) and same(target.gain, -target.bias[1]):
            out = {'kp': number(target.gain), 'kv': number(-target.bias[2]), 'dampratio': None}
        else:
            out = _general(drive, target)
    if not same(present.control, target.control):
        out |= _limits('ctrl', -target.control, target.control)
    if not same(present.span, target.span) or (
            math.isfinite(target.span) and not same(present.bias[0], target.bias[0])):
        out |= _limits('force', target.bias[0] - target.span, target.bias[0] + target.span)
    if not same(present.delay, target.delay):
        out |= (_delayed(drive, target.delay, where) if target.delay
                else {'delay': None, 'nsample': None, 'interp': None})
    return out


def _limits(kind: str, low: float, high: float) -> dict[str, str | None]:
    """Return the attributes of the limits of a `kind`, ctrl or force."""
    if math.isinf(high):
        return {f'{kind}limited': 'false', f'{kind}range': None}
    return {f'{kind}limited': 'true', f'{kind}range': number(low, high)}


def _general(drive: MjcfDrive, target: _Force) -> dict[str, str | None]:
    """Return the attributes of an actuator general with a force and its lag."""
    affine = bool(target.bias[0] or target.bias[1] or target.bias[2])
    out: dict[str, str | None] = {
        'gainprm': number(target.gain) if target.gain != 1.0 else None, 'biasprm': None,
        # Of the shortcuts that general replaces.
        'kp': None, 'kv': None, 'dampratio': None, 'timeconst': None}
    if affine:
        out |= {'biastype': 'affine', 'biasprm': number(*target.bias)}
    if any(e.tag in ('default', 'include') for e in drive.document.root.children):
        # general inherits what a shortcut sets by itself.
        out |= {'gaintype': 'fixed', 'gainprm': number(target.gain),
                'biastype': 'affine' if affine else 'none'}
    if target.lag:
        out |= {'dyntype': 'filterexact', 'dynprm': number(target.lag)}
    elif drive.actuator is not None and drive.actuator.dynamics != 'none':
        out |= {'dyntype': 'none', 'dynprm': None}
    return out


def _delayed(drive: MjcfDrive, delay: float, where: str) -> dict[str, str | None]:
    """Return the attributes of a delay (s): between steps it is interpolated."""
    if delay < drive.timestep:
        raise InputError(f'{where}: a delay of {delay:.4g} s, expected a timestep of at most that '
                         f'in the file, which has {drive.timestep:g} s')
    return {'delay': number(delay), 'interp': 'linear',
            'nsample': str(math.ceil(delay / drive.timestep - 1e-9) + 1)}


def _passives(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues,
              names: tuple[str, str | None]) -> None:
    """Add the passive torques of `values` that the file lacks, take out those that it has."""
    present = values_in(drive)
    load = constant_load(values) - constant_load(present)
    for where in (MOTOR, ARM, TENDON):
        for kind in (LUGRE, COGGING):
            if (where, kind) == (ARM, COGGING):
                continue
            own, file = values.passives(where, kind), present.passives(where, kind)
            if len(own) == len(file) and all(all(map(same, a, b)) for a, b in zip(own, file)):
                continue
            for passive, i in drive.passive:
                if (passive.where, passive.kind) == (where, kind):
                    edits.put(edits.listed('actuator', i), {kind: None},
                              title=f'dcmotor ({kind})')
            for numbers in own:
                _passive(edits, drive, Passive(where, kind, numbers), names)
    if abs(load) > SAME * max(1.0, abs(constant_load(values))):
        _passive(edits, drive, steady(-load), names)


def _passive(edits: MjcfEdits, drive: MjcfDrive, passive: Passive,
             names: tuple[str, str | None]) -> None:
    place = {MOTOR: ('joint', names[0]), ARM: ('joint', names[1] or names[0]),
             TENDON: ('tendon', drive.tendon.name if drive.tendon
                      else f'{names[1]}_gearbox')}[passive.where]
    title = f'dcmotor ({passive.kind} on {place[1]})'
    edits.add('actuator', title,
              f'<dcmotor {place[0]}="{place[1]}" input="none" motorconst="0" resistance="1" '
              f'{passive.kind}="{number(*passive.numbers)}"/>')


def _sensors(edits: MjcfEdits, drive: MjcfDrive, values: MjcfValues,
             names: tuple[str, str | None]) -> None:
    shift = values.zero - values_in(drive).zero
    if shift:
        _shift_zero(edits, drive, shift)
    if values.rigid and values.late[0] and values.late[1]:
        raise InputError(f'{drive.path}: joint {names[0]}: two delays of its reading, expected '
                         'one where motor and arm are one joint')
    present = values_in(drive).late
    for delay, was, name in zip(values.late, present, (names[0], names[1] or names[0])):
        if not delay or same(delay, was):
            continue
        where = f'{drive.path}: sensor of joint {name}'
        delays = _delayed(drive, delay, where)
        own = [e for part in drive.document.root.all('sensor') for e in part.all('jointpos')
               if e.attributes.get('joint') == name]
        if own:
            edits.put(own[0], delays)
        else:
            edits.add('sensor', f'sensor "{name}_encoder"', f'<jointpos name="{name}_encoder" '
                      f'joint="{name}" {words_of(delays)}/>')


def _shift_zero(edits: MjcfEdits, drive: MjcfDrive, zero: float) -> None:
    """Let the arm's joint read `zero` rad more; its limits move with it."""
    joint = drive.arm_joint
    m = drive.compiled
    unit = 180.0 / math.pi if drive.degrees and not joint.slide else 1.0
    values: dict[str, str | None] = {'ref': number((joint.ref + zero) * unit)}
    if m.jnt_limited[joint.index]:
        values['range'] = number(*((m.jnt_range[joint.index] + zero) * unit))
    if joint.stiffness:
        values['springref'] = number((joint.springref + zero) * unit)
    edits.put(edits.joint(joint.index), values)


def _verify(again: MjcfDrive, drive: MjcfDrive, values: MjcfValues) -> None:
    """Raise InputError unless MuJoCo compiles a patch to `values`, in the posture of `drive`."""
    v, arm = values, again.arm
    whole = v.arm_inertia + (v.motor_inertia if arm is None else 0.0)
    rows: list[tuple[str, complex, complex]] = [
        ('inertia', again.arm_joint.inertia + again.arm_joint.armature, whole)]
    if v.weight is not None:
        rows.append(('weight', weight(again) * cmath.rect(1.0, v.zero), v.weight))
    sides = [('joint', again.motor, v.motor_damping + v.arm_damping,
              v.motor_friction + v.arm_friction)] if arm is None else [
        ('motor', again.motor, v.motor_damping, v.motor_friction),
        ('arm', arm, v.arm_damping, v.arm_friction)]
    for side, joint, damping, friction in sides:
        rows += [(f'{side} damping', joint.damping, damping),
                 (f'{side} friction', joint.frictionloss, friction)]
    if drive.actuator is not None and again.actuator is not None:
        force = _forces(drive, values)[1]
        rows += zip(('actuator gain', 'actuator bias', 'actuator kp', 'actuator kv'),
                    (again.actuator.gain, *again.actuator.bias), (force.gain, *force.bias))
    for name, present, target in rows:
        if not cmath.isclose(present, target, rel_tol=1e-5, abs_tol=1e-6 * abs(whole)
                             if name in ('inertia', 'weight') else 1e-9):
            raise InputError(
                f'{drive.path}: {name}: MuJoCo makes {present:.6g} of {target:.6g}, '
                'expected a file where the attributes of joint and inertial count (no '
                'springdamper, compiler inertiafromgeom auto)')
