# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A drive as the parameters of simulators whose files this package does not edit.

Each list has names and units of its target, on the side of the joint; what the target lacks is
listed with the reason. Drake's rotor inertia alone is that of the motor itself.
"""
from typing import Any, NamedTuple

from gearbox_monitor.export.mjcf import Exported, REFUSED
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side

TARGETS = ('urdf', 'sdf', 'isaac', 'drake', 'bam')
# Effects that a target has a parameter for; those on the arm join those of the motor.
_INERTIA = {motor_side.MOTOR_INERTIA.id}
_BODY = {arm_side.ARM_INERTIA.id, arm_side.GRAVITY.id}
_VISCOUS = {motor_side.MOTOR_VISCOUS.id, arm_side.ARM_VISCOUS.id}
_COULOMB = {motor_side.MOTOR_COULOMB.id, arm_side.ARM_COULOMB.id}
_LIMIT = {actuator.SATURATION.id}
EXPRESSED = {
    'urdf': _BODY | _VISCOUS | _COULOMB | _LIMIT, 'sdf': _BODY | _VISCOUS | _COULOMB | _LIMIT,
    'isaac': _INERTIA | _BODY | _VISCOUS | _COULOMB | _LIMIT | {actuator.ACTUATOR_DELAY.id},
    'drake': _INERTIA | _BODY | _VISCOUS | _LIMIT,
    'bam': _INERTIA | _VISCOUS | _COULOMB | {motor_side.STRIBECK.id, actuator.TORQUE_GAIN.id}}
_NO_FRICTION = 'joints have no Coulomb friction: apply it as a force element'


class Entry(NamedTuple):
    """A parameter of a target: its name there, value and unit."""

    name: str
    value: float
    unit: str


def parameter_list(model: DriveModel, target: str) -> tuple[list[Entry], list[Exported]]:
    """Return the parameters of `model` in `target`, one of TARGETS, and what it lacks."""
    folded = model.folded()
    of = {effect['id']: effect for effect in model.effects}
    viscous = folded.viscous_friction + sum(
        e['Cav'] for e in folded.effects if e['id'] == arm_side.ARM_VISCOUS.id)
    coulomb = folded.coulomb_friction + sum(
        e['Cac'] for e in folded.effects if e['id'] == arm_side.ARM_COULOMB.id)
    limit = [of[name]['umax'] for name in _LIMIT & set(of)]
    slide = folded.axis == 'prismatic'
    torque, damping, inertia = ('N', 'N s/m', 'kg') if slide else (
        'N m', 'N m s/rad', 'kg m^2')
    weight, phase = weight_of(model.effects)
    body = [Entry('inertia of all that it moves, about the joint', folded.arm_inertia, inertia),
            *([Entry('mass times lever of it times 9.81', weight, torque)] if weight else []),
            *([Entry('angle at which it hangs', -phase, 'rad')] if phase else [])]
    static = folded.friction_law.static if folded.friction_law.kind == 'physx' else 1.0
    rows = {
        'urdf': [Entry('dynamics damping', viscous, damping),
                 Entry('dynamics friction', coulomb, torque),
                 *(Entry('limit effort', v, torque) for v in limit), *body],
        'sdf': [Entry('axis/dynamics/damping', viscous, damping),
                Entry('axis/dynamics/friction', coulomb, torque),
                Entry('axis/dynamics/spring_stiffness', folded.position_gain,
                      torque if slide else 'N m/rad'),
                *(Entry('axis/limit/effort', v, torque) for v in limit), *body],
        'isaac': [Entry('armature', folded.motor_inertia, inertia),
                  Entry('friction', static * coulomb, torque),
                  Entry('dynamic_friction', coulomb, torque),
                  Entry('viscous_friction', viscous, damping),
                  *(Entry('effort_limit_sim', v, torque) for v in limit),
                  *(Entry('delay of DelayedPDActuator, in physics steps of this', e['T'], 's')
                    for e in of.values() if e['id'] == actuator.ACTUATOR_DELAY.id), *body],
        'drake': [Entry('drake:rotor_inertia', folded.motor_inertia / folded.gear_ratio ** 2,
                        inertia),
                  Entry('drake:gear_ratio', folded.gear_ratio, '-'),
                  Entry('dynamics damping', viscous, damping),
                  *(Entry('limit effort', v, torque) for v in limit), *body],
        'bam': [Entry('armature', folded.motor_inertia, inertia),
                Entry('friction_base', coulomb, torque),
                Entry('friction_viscous', viscous, damping),
                *(Entry(name, value, unit) for e in of.values()
                  if e['id'] == motor_side.STRIBECK.id for name, value, unit in (
                      ('friction_stribeck', e['Cs'], torque),
                      ('dtheta_stribeck', e['vs'], 'rad/s'), ('alpha', 2.0, '-'))),
                *(Entry('kt, times this', 1.0 + e['g'], '-') for e in of.values()
                  if e['id'] == actuator.TORQUE_GAIN.id)]}[target]
    return rows, _lacking(folded, model, target)


def expressed_as(effect: Effect, target: str) -> str:
    """
    Return what an effect becomes in a target: the names of its parameters there, or why none.

    Args:
        effect: of the library.
        target: one of TARGETS.
    """
    rigid = effect.location not in ('transmission', 'arm_sensor')
    plain = DriveModel().with_(kind='rigid') if rigid else DriveModel()
    if effect.location == 'controller':
        plain = plain.with_(controller={'kp': 20.0, 'kd': 0.5})
    model = plain.with_(effects=[{'id': effect.id, **example_values(effect)}])
    own = parameter_list(plain, target)[0]
    entries, lacking = parameter_list(model, target)
    names = [entry.name for entry in entries if entry not in own]
    if names:
        return ', '.join(names)
    reasons = {row.id: row.words for row in lacking}
    for name in ('controller', effect.id, effect.adds_to, effect.replaces, 'transmission'):
        if name in reasons:
            return f'none: {reasons[name]}'
    return 'none'


def example_values(effect: Effect) -> dict[str, Any]:
    """Return values of the parameters of an effect that a model takes, unlike usual ones."""
    return {p.name: p.choices[0] if p.choices else [0.1, 0.2] if p.listed else
            2 if p.whole else min(max(0.013, p.low), p.high) for p in effect.parameters}


def _lacking(folded: DriveModel, model: DriveModel, target: str) -> list[Exported]:
    """Return what of a model `target` has no parameter for; `folded`: without replaced values."""
    out: dict[str, str] = {}
    if folded.transmission.kind != 'rigid':
        out['transmission'] = ('a joint is rigid there: two joints with a spring between them, or '
                               'a model with transmission.kind: rigid')
    if target in ('urdf', 'sdf'):
        out['motor_inertia'] = (f'no armature: add {folded.motor_inertia:.6g} to the inertia '
                                'about the axis of the body that the joint moves')
    if target == 'drake' and folded.coulomb_friction:
        out['coulomb_friction'] = _NO_FRICTION
    if folded.position_gain and target != 'sdf':
        out['position_gain'] = 'no spring to the ground: add it in your code'
    if folded.torque_offset:
        out['torque_offset'] = 'add it to the commanded torque'
    if model.controller is not None:
        out['controller'] = 'set its gains in your code'
    for effect in model.effects:
        name = effect['id']
        entry = EFFECTS.get(name)
        if name in EXPRESSED[target] or name in out or (
                entry and (entry.replaces or entry.adds_to)
                and entry.location == 'transmission'):
            continue  # said above
        where = entry.location if entry else ''
        out[name] = ('BAM describes the actuator alone' if (target, where) == ('bam', 'arm_side')
                     else 'no sensor has it: change the reading in your code'
                     if where.endswith('sensor') else _NO_FRICTION
                     if target == 'drake' and name in _COULOMB
                     else 'no parameter has its law: apply it in your code')
    return [Exported(name, REFUSED, reason) for name, reason in out.items()]
