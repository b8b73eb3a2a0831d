# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The edits that make a drive in an MJCF or URDF file move like a model: the fewest.

Two joints in an MJCF file take the model as it is. One joint takes a rigid model; for one with a
transmission it becomes the joint of the arm, and a body without shape, the rotor, gets that of the
motor: the actuator moves there, and a tendon holds both together.

A URDF has no rotors, no transmissions and no actuators: friction and effort limit of the joint and
inertia of the link are written, and what it has no parameter for is listed.
"""
import cmath
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
import math
from operator import or_
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side
from gearbox_monitor.plant.transmission import FrictionLaw, IMPEDANCES
from gearbox_monitor.robot.chain import inertial
from gearbox_monitor.robot.compiled_model import ActuatorLaw, moved_by, mujoco_module, runge_kutta
from gearbox_monitor.simulators.file_edits import (
    about_axis, across, balanced, compiled_body, differing, FileEdits, mjcf_element, NewElement,
    number, Patch, SAME, same, titled, TURN, write_mjcf, write_urdf)
from gearbox_monitor.simulators.mjcf import (
    ARM, COGGING, constant_load, CONSTRUCT, Exported, LUGRE, MjcfValues, MOTOR, NATIVE, Passive,
    REFUSED, steady, TENDON, values_of)
from gearbox_monitor.simulators.mjcf_file import drive_of, MjcfDrive, MjcfJoint, values_in, weight
from gearbox_monitor.simulators.xml_edit import parse_xml, words_of

# Regularised Coulomb friction: a ramp up to this many 1 / sharpness is nearest to the arctangent
# over motions of some hundred of them.
RAMP = {'atan': 5.0, 'tanh': 1.5}
IMPEDANCE = 1e-3  # of the friction constraint: at small ones it is a function of speed alone
ROTOR = 'mass="1e-6" diaginertia="1e-12 1e-12 1e-12"'


def patched(drive: MjcfDrive, values: MjcfValues, exported: Sequence[Exported]) -> Patch:
    """
    Return the Patch that gives a drive in an MJCF file the values of a model.

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
    names: tuple[str, str | None] = (drive.motor.name, drive.arm.name if drive.arm else None)
    if not values.rigid and drive.arm is None:  # the joint in the file becomes that of the arm
        names = (f'{drive.motor.name}_motor', drive.motor.name)
    edits = reduce(or_, (part(drive, values, names) for part in (
        _joints, _tendons, _passives, _sensors)), inertial_edits(drive, values))
    edits |= _actuator(drive, values, names[0], bool(edits.attributes or edits.bodies))
    patch = replace(write_mjcf(drive.document, drive.compiled, edits), exported=tuple(exported),
                    joints=names)
    verify(patch, drive, values)
    return patch


# ---------------------------------------------------------------------- joints


def _friction(drive: MjcfDrive, friction: float, values: MjcfValues, inertia: float,
              on_arm: bool = False) -> dict[str, str | None]:
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


def _joint(drive: MjcfDrive, joint: MjcfJoint, target: Mapping[str, float], of: MjcfValues,
           on_arm: bool = False) -> FileEdits:
    """Edit what of a joint differs from `target` {armature, damping, frictionloss, stiffness}."""
    where, m = f'{drive.path}: joint {joint.name}', drive.compiled
    inertia = (of.motor_inertia + of.arm_inertia if of.rigid
               else of.arm_inertia if on_arm else of.motor_inertia)
    added = {'armature': 0.0, 'damping': joint.actuator_damping,
             'stiffness': joint.actuator_stiffness}
    # Higher coefficients stay.
    higher = {'armature': (), 'damping': m.dof_dampingpoly[m.jnt_dofadr[joint.index]],
              'stiffness': m.jnt_stiffnesspoly[joint.index]}
    values: dict[str, str | None] = {}
    for name, actuators in added.items():
        own = target[name] - actuators
        if own < (-SAME * inertia if name == 'armature' else 0.0) and name != 'stiffness':
            raise InputError(f'{where}: {name}: would be {own:.4g}, expected at least 0: the '
                             'model has less than body and actuator in the file')
        if not same(target[name], getattr(joint, name)):
            values[name] = number(max(0.0, own), *(higher[name] if np.any(higher[name]) else ()))
    values |= _friction(drive, target['frictionloss'], of, inertia, on_arm)
    if same(target['frictionloss'], joint.frictionloss):
        del values['frictionloss']
    if joint.law == of.law:
        values = {k: v for k, v in values.items() if not k.startswith('sol')}
    return FileEdits({('joint', joint.index): values} if values else {})


def _joints(drive: MjcfDrive, values: MjcfValues, names: tuple[str, str | None]) -> FileEdits:
    """Return the edits of the joints; one joint gets a rotor for a model with a transmission."""
    motor, arm = drive.motor, drive.arm_joint
    if values.rigid:
        armature = values.motor_inertia
        if drive.half_of_inertia:
            armature = max(0.0, armature - values_in(drive).motor_inertia)
        return _joint(drive, motor, {
            'armature': armature, 'damping': values.motor_damping + values.arm_damping,
            'frictionloss': values.motor_friction + values.arm_friction,
            'stiffness': values.motor_stiffness}, values)
    alone = drive.arm is None
    edits = _joint(drive, arm, {
        'armature': 0.0 if alone else arm.armature, 'damping': values.arm_damping,
        'frictionloss': values.arm_friction, 'stiffness': 0.0 if alone else arm.stiffness},
        values, on_arm=True)
    if alone:
        return edits | _rotor(drive, values, names[0])
    return edits | _joint(drive, motor, {
        'armature': values.motor_inertia - motor.inertia, 'damping': values.motor_damping,
        'frictionloss': values.motor_friction, 'stiffness': values.motor_stiffness}, values)


def _rotor(drive: MjcfDrive, values: MjcfValues, name: str) -> FileEdits:
    """Return the body and joint `name` of a rotor beside the joint of a drive."""
    joint, document, m = drive.motor, drive.document, drive.compiled
    index = int(m.jnt_bodyid[joint.index])
    body = mjcf_element(document, m, 'body', index)
    if len(body.all('joint')) != 1:
        raise InputError(f'{drive.path}: line {body.line}: {titled(body)}: several joints, '
                         'expected one for a rotor beside it')
    if name in {e.attributes.get('name') for e in document.root.walk()}:
        raise InputError(f'{drive.path}: {name}: the name is taken, expected it to be free for '
                         'the joint of the motor')
    place = ''.join(f' {key}="{value}"' for key, value in body.attributes.items()
                    if key in ('pos', *TURN))
    friction = words_of(_friction(drive, values.motor_friction, values, values.motor_inertia))
    kind = 'slide' if joint.slide else 'hinge'
    return FileEdits(_keyframes(drive, joint), rotor=(index, NewElement(
        'body', f'body "{name}" with the joint of the motor', f"""\
<body name="{name}"{place}>
  <inertial pos="0 0 0" {ROTOR}/>
  <joint name="{name}" type="{kind}" pos="{number(*m.jnt_pos[joint.index])}"
         axis="{number(*m.jnt_axis[joint.index])}" limited="false" ref="0" springref="0"
         armature="{number(values.motor_inertia)}" damping="{number(values.motor_damping)}"
         stiffness="{number(values.motor_stiffness)}"
         {friction}/>
</body>""")))


def _keyframes(drive: MjcfDrive, joint: MjcfJoint
               ) -> dict[tuple[str, int | str], dict[str, str | None]]:
    """Give the postures in keyframes the value of the motor's joint."""
    m = drive.compiled
    last = np.flatnonzero(moved_by(m, joint.index)[m.jnt_bodyid])[-1]
    place, own = m.jnt_qposadr[last] + 1, m.jnt_qposadr[joint.index]
    if m.jnt_type[last] == int(mujoco_module().mjtJoint.mjJNT_BALL):
        place += 3
    edits: dict[tuple[str, int | str], dict[str, str | None]] = {}
    keys = [key for part in drive.document.root.all('keyframe') for key in part.children]
    for i, key in enumerate(keys):
        if row := key.attributes.get('qpos', '').split():
            row += ['0'] * (m.nq - len(row))  # as MuJoCo fills it up
            edits['keyframe', i] = {'qpos': ' '.join([*row[:place], row[own], *row[place:]])}
        if key.attributes.get('qvel') or key.attributes.get('act'):
            raise InputError(f'{drive.path}: line {key.line}: {titled(key)}: qvel or act, '
                             'expected only qpos where a joint is added')
    return edits


# ---------------------------------------------------------------------- inertia and weight


def inertial_edits(drive: MjcfDrive, values: MjcfValues) -> FileEdits:
    """Return the edit of the arm's body in the file of `drive`: inertia and weight of `values`."""
    joint, present = drive.arm_joint, values_in(drive)
    # What the joint's own armature adds stays with it, unless it was that of the motor.
    own = joint.armature if drive.arm is not None else 0.0
    heavier = values.arm_inertia - own - joint.inertia
    if drive.document.root.tag == 'robot':
        heavier += values.motor_inertia   # a link holds all of it
    elif drive.half_of_inertia and values.rigid:
        heavier = values.arm_inertia - present.arm_inertia + min(
            0.0, values.motor_inertia - present.motor_inertia)
    own_weight = None  # over what the joint reads now, before its zero moves
    if values.weight is not None:
        own_weight = values.weight * cmath.rect(1.0, -present.zero)
    moved = own_weight is not None and not same(own_weight, weight(drive))
    if abs(heavier) <= SAME * values.arm_inertia and not moved:
        return FileEdits()
    m, index = drive.compiled, int(drive.compiled.jnt_bodyid[joint.index])
    axis, anchor, body = m.jnt_axis[joint.index], m.jnt_pos[joint.index], compiled_body(m, index)
    if joint.slide:
        changed = body._replace(mass=body.mass + heavier,
                                tensor=body.tensor * (body.mass + heavier) / body.mass)
    else:
        target = about_axis(body, axis, anchor) + heavier
        if target <= 0.0:
            raise InputError(f'{drive.path}: joint {joint.name}: inertia: what the body carries '
                             f'has more than the {values.arm_inertia:.4g} kg m^2 of the model')
        moment = None
        if moved and own_weight is not None:
            moment = body.mass * across(body.centre - anchor, axis) + _added_moment(
                drive, own_weight)
        changed = balanced(body, axis, anchor, target, moment)
    return FileEdits(bodies={index: inertial(*changed) - inertial(*body)})


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


def _tendons(drive: MjcfDrive, values: MjcfValues, names: tuple[str, str | None]) -> FileEdits:
    """Return the edits of the gearbox, and of the tendon that yields beside it."""
    if values.rigid:
        return FileEdits()
    tendon, elastic = drive.tendon, drive.hysteresis
    sign = tendon.sign if tendon else 1.0
    ends = sorted(sign * (edge - values.zero) for edge in (-values.half_gap, values.half_gap))
    wanted = [('gearbox', tendon, {
        'springlength': number(*ends), 'damping': number(values.damping),
        'stiffness': number(values.stiffness, *((0.0, values.cubic) if values.cubic else ()))})]
    if values.yielding:
        wanted.append(('hysteresis', elastic, {
            'springlength': '0 0', 'stiffness': number(values.yielding[0]),
            'springyield': number(values.yielding[1])}))
    edits = FileEdits()
    for name, present, attributes in wanted:
        if present is None:
            edits |= FileEdits(new=(NewElement('tendon', f'tendon "{names[1]}_{name}"', (
                f'<fixed name="{names[1]}_{name}" {words_of(attributes)}>\n'
                f'  <joint joint="{names[0]}" coef="1"/>\n'
                f'  <joint joint="{names[1]}" coef="-1"/>\n</fixed>')),))
        elif other := differing(attributes, {
                'springlength': number(present.low, present.high),
                'damping': number(present.damping), 'springyield': number(present.springyield),
                'stiffness': number(*present.stiffness[:3 if any(present.stiffness[1:]) else 1])}):
            edits |= FileEdits({('tendon', present.index): other})
    return edits


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
    span, control = math.inf, math.inf
    if values.servo is not None:
        kp, kd, limit = values.servo
        gain = values.gain * kp / size ** 2
        bias, span = (-gain, -values.gain * kd / size ** 2), values.gain * limit / size
    elif a.setpoint:
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
                      else math.inf, a.lag, a.delay)
    small = 1e-9 * max(abs(a.gain), 1.0)   # rounding alone is no change

    def near(old: float, new: float) -> float:
        """Return the `new` number, or the `old` one that it equals but for rounding."""
        return old if same(old, new) or abs(old - new) <= small else new
    return existing, _Force(near(a.gain, gain), (
        near(a.bias[0], constant), near(a.bias[1], bias[0]), near(a.bias[2], bias[1])), *map(
            near, existing[2:], (span, control, values.lag, values.delay)))


def _actuator(drive: MjcfDrive, values: MjcfValues, motor: str, changed: bool) -> FileEdits:
    """Return the edits of the actuator; `changed`: inertias did, of which gains may be made."""
    a = drive.actuator
    if a is None:
        plain = (values.gain == 1.0 and not values.lag and not values.delay
                 and math.isinf(values.limit) and values.servo is None)
        if plain and same(values.offset, values_in(drive).offset):
            return FileEdits()
        raise InputError(f'{drive.path}: joint {drive.motor.name}: no actuator acts on it, '
                         'expected one')
    present, target = _forces(drive, values)
    moved, changed = motor != drive.motor.name, changed and b'dampratio' in drive.document.data
    late = (a.spring or a.damper) and values.servo is None and (values.lag or values.delay)
    if not (moved or changed or late or present != target):
        return FileEdits()
    element = mjcf_element(drive.document, drive.compiled, 'actuator', a.index)
    where = f'{drive.path}: line {element.line}: actuator {a.name}'
    if late:
        raise InputError(f'{where}: follows a setpoint, and lag or delay of a torque would act on '
                         'that; expected a motor')
    joints: dict[tuple[str, int | str], dict[str, str | None]] = {}
    attributes = {'joint': motor, **_inherited(drive, element.tag, a)} if moved else {}
    bounded = math.isfinite(drive.motor.force[1])
    if present != target or changed or moved and bounded:
        attributes |= _of_actuator(drive, element.tag, where, (present, target), changed)
        if bounded and present.span != target.span:
            limit = target.span * abs(a.gear)
            joints['joint', drive.motor.index] = {
                'actuatorfrcrange': number(-limit, limit) if math.isfinite(limit) else None}
    if '' in attributes and element.tag in ('dcmotor', 'pid'):
        raise InputError(f'{where}: a {element.tag}, whose force is not that of the model, '
                         'expected motor, general or position')
    return FileEdits({('actuator', a.index): attributes, **joints})


def _inherited(drive: MjcfDrive, tag: str, a: ActuatorLaw) -> dict[str, str | None]:
    """Return the range of controls that an actuator has from its joint, which it leaves."""
    m = drive.compiled
    place = int(m.actuator_ctrladr[a.index])
    if tag not in ('position', 'intvelocity') or not m.actuator_ctrllimited[place]:
        return {}
    span = number(*m.actuator_ctrlrange[place])
    return {'inheritrange': '0', 'ctrllimited': 'true', 'ctrlrange': span}


def _of_actuator(drive: MjcfDrive, tag: str, where: str, forces: tuple[_Force, _Force],
                 explicit: bool) -> dict[str, str | None]:
    """Return the attributes that turn the force of an actuator into the second of `forces`."""
    a, (present, target) = drive.actuator, forces
    assert a is not None
    if a.dynamics not in ('none', 'filter', 'filterexact'):
        raise InputError(f'{where}: dyntype {a.dynamics}, expected none for a lag')
    out: dict[str, str | None] = {}
    if explicit or present[:2] != target[:2] or present.lag != target.lag:
        lagging = present.lag != target.lag or bool(target.lag)
        plain = tag == 'position' and not lagging
        out = (plain and servo_gains(tag, target.gain, target.bias)) or _general(drive, target)
    if present.control != target.control:
        out |= _limits('ctrl', -target.control, target.control)
    if present.span != target.span or (
            math.isfinite(target.span) and present.bias[0] != target.bias[0]):
        out |= _limits('force', target.bias[0] - target.span, target.bias[0] + target.span)
    if present.delay != target.delay:
        early = 0.5 if runge_kutta(drive.compiled) else 0.0   # it reads ahead within a step
        out |= (_delayed(drive, target.delay, where, early) if target.delay
                else {'delay': None, 'nsample': None, 'interp': None})
    return out


def servo_gains(tag: str, gain: float, bias: Sequence[float]) -> dict[str, str | None]:
    """
    Return the attributes of an actuator with the force gain c + bias, {} where it has none.

    Args:
        tag: of its element.
        gain: of the control c.
        bias: constant, over length and speed.
    """
    if tag == 'general':
        return {'gainprm': number(gain), 'biasprm': number(*bias)}
    if tag == 'position' and bias[1] and abs(bias[0]) <= SAME * gain and same(gain, -bias[1]):
        return {'kp': number(gain), 'kv': number(-bias[2]), 'dampratio': None}
    return {}


def _limits(kind: str, low: float, high: float) -> dict[str, str | None]:
    """Return the attributes of the limits of a `kind`, ctrl or force."""
    if math.isinf(high):
        return {f'{kind}limited': 'false', f'{kind}range': None}
    return {f'{kind}limited': 'true', f'{kind}range': number(low, high)}


def _general(drive: MjcfDrive, target: _Force) -> dict[str, str | None]:
    """Return the attributes of an actuator general with a force and its lag."""
    affine = any(target.bias)
    out: dict[str, str | None] = {
        '': 'general', 'inheritrange': None,
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
        # The one that is exact in steps of the file.
        out |= {'dyntype': 'filter' if runge_kutta(drive.compiled) else 'filterexact',
                'dynprm': number(target.lag)}
    elif drive.actuator is not None and drive.actuator.dynamics != 'none':
        out |= {'dyntype': 'none', 'dynprm': None}
    return out


def _delayed(drive: MjcfDrive, delay: float, where: str, early: float = 0.0
             ) -> dict[str, str | None]:
    """Return the attributes of a `delay` (s) of what is read `early` by so many timesteps."""
    if delay < drive.timestep:
        raise InputError(f'{where}: a delay of {delay:.4g} s, expected a timestep of at most that '
                         f'in the file, which has {drive.timestep:g} s')
    delay += early * drive.timestep
    return {'delay': number(delay), 'interp': 'linear',
            'nsample': str(math.ceil(delay / drive.timestep - 1e-9) + 1)}


def _passives(drive: MjcfDrive, values: MjcfValues, names: tuple[str, str | None]) -> FileEdits:
    """Add the passive torques of `values` that the file lacks, take out those that it has."""
    present, removed, new = values_in(drive), FileEdits(), list[NewElement]()
    load = constant_load(values) - constant_load(present)
    for where, kind in ((MOTOR, LUGRE), (MOTOR, COGGING), (ARM, LUGRE), (TENDON, LUGRE),
                        (TENDON, COGGING)):
        own, file = values.passives(where, kind), present.passives(where, kind)
        if len(own) == len(file) and all(all(map(same, a, b)) for a, b in zip(own, file)):
            continue
        removed |= FileEdits({('actuator', i): {kind: None} for passive, i in drive.passive
                              if (passive.where, passive.kind) == (where, kind)})
        new += [_passive(drive, Passive(where, kind, numbers), names) for numbers in own]
    if abs(load) > SAME * max(1.0, abs(constant_load(values))):
        new.append(_passive(drive, steady(-load), names))
    return removed | FileEdits(new=tuple(new))


def _passive(drive: MjcfDrive, passive: Passive, names: tuple[str, str | None]) -> NewElement:
    kind, name = {MOTOR: ('joint', names[0]), ARM: ('joint', names[1] or names[0]),
                  TENDON: ('tendon', drive.tendon.name if drive.tendon
                           else f'{names[1]}_gearbox')}[passive.where]
    return NewElement('actuator', f'dcmotor ({passive.kind} on {name})', (
        f'<dcmotor {kind}="{name}" input="none" motorconst="0" resistance="1" '
        f'{passive.kind}="{number(*passive.numbers)}"/>'))


def _sensors(drive: MjcfDrive, values: MjcfValues, names: tuple[str, str | None]) -> FileEdits:
    """Return the edits of zero and delays of the readings."""
    present, edits = values_in(drive), FileEdits()
    if values.zero != present.zero:
        edits = _shifted_zero(drive, values.zero - present.zero)
    if values.rigid and values.late[0] and values.late[1]:
        raise InputError(f'{drive.path}: joint {names[0]}: two delays of its reading, expected '
                         'one where motor and arm are one joint')
    sensors = [e for part in drive.document.root.all('sensor') for e in part.children]
    for delay, was, name in zip(values.late, present.late, (names[0], names[1] or names[0])):
        if not delay or same(delay, was):
            continue
        delays = _delayed(drive, delay, f'{drive.path}: sensor of joint {name}')
        own = [i for i, e in enumerate(sensors)
               if (e.tag, e.attributes.get('joint')) == ('jointpos', name)]
        edits |= FileEdits({('sensor', own[0]): delays}) if own else FileEdits(new=(NewElement(
            'sensor', f'sensor "{name}_encoder"',
            f'<jointpos name="{name}_encoder" joint="{name}" {words_of(delays)}/>'),))
    return edits


def _shifted_zero(drive: MjcfDrive, zero: float) -> FileEdits:
    """Let the arm's joint read `zero` rad more; its limits move with it."""
    joint = drive.arm_joint
    m = drive.compiled
    unit = 180.0 / math.pi if drive.degrees and not joint.slide else 1.0
    values: dict[str, str | None] = {'ref': number((joint.ref + zero) * unit)}
    if m.jnt_limited[joint.index]:
        values['range'] = number(*((m.jnt_range[joint.index] + zero) * unit))
    if joint.stiffness:
        values['springref'] = number((joint.springref + zero) * unit)
    return FileEdits({('joint', joint.index): values})


def verify(patch: Patch, drive: MjcfDrive, values: MjcfValues) -> None:
    """Raise InputError unless MuJoCo compiles a `patch` of `drive` to `values`, in its posture."""
    again = drive_of(patch.data, drive.path, patch.joints, drive.keyframe,
                     drive.actuator.name or None if drive.actuator else None)
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


ROOT = 'robot'
LINK_INERTIA = 'inertia of the link that the joint moves'
# What an effect becomes in a URDF file.
EXPRESSED = {
    motor_side.MOTOR_INERTIA.id: LINK_INERTIA, arm_side.ARM_INERTIA.id: LINK_INERTIA,
    arm_side.GRAVITY.id: 'mass and origin of the link that the joint moves',
    motor_side.MOTOR_VISCOUS.id: 'dynamics damping', arm_side.ARM_VISCOUS.id: 'dynamics damping',
    motor_side.MOTOR_COULOMB.id: 'dynamics friction',
    arm_side.ARM_COULOMB.id: 'dynamics friction', actuator.SATURATION.id: 'limit effort'}
RIGID = ('a joint is rigid there: two joints with a spring between them, or a model with '
         'transmission.kind: rigid')


def in_urdf(effect: Effect) -> str:
    """Return what an `effect` of the library becomes in a URDF file, or why nothing."""
    if effect.id in EXPRESSED:
        return EXPRESSED[effect.id]
    of_place = {'transmission': RIGID, 'controller': 'set its gains in your code'}
    return f'none: {of_place.get(effect.location) or _reason(effect)}'


def _reason(effect: Effect | None) -> str:
    """Return why URDF has no parameter for an `effect`; None: of a plug-in."""
    if effect is not None and effect.location.endswith('sensor'):
        return 'no sensor has it: change the reading in your code'
    return 'no parameter has its law: apply it in your code'


def _not_in_urdf(model: DriveModel) -> list[Exported]:
    """Return what of a model URDF has no parameter for."""
    folded, out = model.folded(), dict[str, str]()
    if folded.transmission.kind != 'rigid':
        out['transmission'] = RIGID
    if folded.position_gain:
        out['position_gain'] = 'no spring to the ground: add it in your code'
    if folded.torque_offset:
        out['torque_offset'] = 'add it to the commanded torque'
    if model.controller is not None:
        out['controller'] = 'set its gains in your code'
    for effect in model.effects:
        name = effect['id']
        entry = EFFECTS.get(name)
        of_transmission = entry is not None and entry.location == 'transmission' and (
            entry.replaces or entry.adds_to)
        if name not in EXPRESSED and not of_transmission:
            out.setdefault(name, _reason(entry))
    return [Exported(name, REFUSED, reason) for name, reason in out.items()]


def patched_urdf(data: bytes, path: Path, joint: str, model: DriveModel) -> Patch:
    """
    Return the Patch that gives a joint in a URDF file the values of a model.

    Args:
        data: bytes of the file.
        path: of the file.
        joint: its name.
        model: of the drive.

    Returns:
        The Patch; `exported` has what is not native there, with the reason.

    Raises:
        InputError: another format, no such joint, or a file that MuJoCo does not read.
    """
    document = parse_xml(data, str(path))
    if document.root.tag != ROOT:
        raise InputError(f'{path}: line {document.root.line}: <{document.root.tag}>, expected '
                         f'<{ROOT}> with --to urdf')
    drive, exported, folded = drive_of(data, path, (joint, None)), _not_in_urdf(model), \
        model.folded()
    values = replace(values_of(model)[0], rigid=True, motor_friction=folded.coulomb_friction)
    wanted: dict[str, str | None] = {
        'damping': number(values.motor_damping + values.arm_damping),
        'frictionloss': number(values.motor_friction + values.arm_friction)}
    if math.isfinite(values.limit):
        wanted['effort'] = number(values.limit)
        if not any(e.attributes.get('name') == joint and e.all('limit')
                   for e in document.root.all('joint')):
            exported.append(Exported(
                actuator.SATURATION.id, REFUSED, 'no <limit> in the joint, which needs a '
                f'velocity: add one with effort="{wanted.pop("effort")}"'))
    edits = FileEdits({('joint', joint): wanted})
    moved = (f'the joint moves {values.motor_inertia + values.arm_inertia:.6g} '
             f'{"kg" if drive.motor.slide else "kg m^2"}')
    try:
        bodies = {drive.compiled.body(int(body)).name: added
                  for body, added in inertial_edits(drive, values).bodies.items()}
        patch = write_urdf(document, edits | FileEdits(bodies=bodies))
        verify(replace(patch, joints=(joint, None)), drive, replace(
            values, weight=weight(drive) if values.weight is None else values.weight))
        exported.append(Exported(motor_side.MOTOR_INERTIA.id, CONSTRUCT, (
            f'in the inertia of its link, as there is no armature: {moved} in the posture 0')))
        if values.weight is not None:
            exported.append(Exported(arm_side.GRAVITY.id, NATIVE, 'mass and centre of its link: '
                                     'the weight at 9.81 m/s^2, the other joints at 0'))
    except InputError as error:
        patch = write_urdf(document, edits)
        exported.append(Exported('inertia', REFUSED, f'{error}; {moved} in the model'))
    return replace(patch, exported=tuple(exported), joints=(joint, None))
