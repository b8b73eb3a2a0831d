# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What effects are in an MJCF file, a row each, for MuJoCo 4.0, which writes and reads it.

An effect is native where MJCF has an attribute or an element with its law, a construct where other
elements come close to it, and refused where nothing in a file does what it does, which is true of
all without a row. MjcfValues stand between a model and a file: `values_of` makes them of a model,
`model_values` a model of them.
"""
import cmath
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any, NamedTuple

from gearbox_monitor.kernels.types import Values
from gearbox_monitor.plant.drive import CAV, DriveModel, G, OFFSET, PHI
from gearbox_monitor.plant.effects import (
    actuator, arm_side, controller, EFFECTS, encoder, gearbox, motor_side, torque_map)
from gearbox_monitor.plant.transmission import FrictionLaw

NATIVE, CONSTRUCT, REFUSED = KINDS = ('native', 'construct', 'refused')
MOTOR, ARM, TENDON = ('motor', 'arm', 'tendon')  # where a passive torque acts
LUGRE, COGGING = motor_side.LUGRE.id, motor_side.COGGING.id  # the attributes of dcmotor, too


class Inexpressible(Exception):
    """An effect, with these values, that MJCF cannot express: the reason."""


class Passive(NamedTuple):
    """A passive torque, an element dcmotor: where it acts, `lugre` or `cogging`, its numbers."""

    where: str
    kind: str
    numbers: tuple[float, ...]


class Servo(NamedTuple):
    """A servo on the joint: kp (N m/rad), kd (N m s/rad) and the limit of its torque (N m)."""

    kp: float
    kd: float
    limit: float


@dataclass(frozen=True)
class MjcfValues:
    """
    A drive in the quantities of MJCF, SI units on the arm side.

    motor_inertia, arm_inertia: kg m^2. motor_damping, arm_damping: N m s/rad. motor_friction,
    arm_friction: N m, of a `law` and of `sharpness` (s/rad, of motor and arm). motor_stiffness:
    N m/rad, to the ground. weight: G e^(j phi), N m; None leaves that of the file. rigid: without
    transmission; stiffness (N m/rad), cubic (N m/rad^3), half_gap (rad), damping of the
    transmission; yielding: stiffness and yield (rad) of an elasto-plastic spring beside it.
    gain (1), offset, limit (N m), lag, delay (s) of the actuator, limit before the lag.
    With a servo, lag and delay are those of its setpoint.
    late: delay of the readings of motor and arm, s; zero: offset of that of the arm, rad.
    """

    motor_inertia: float
    arm_inertia: float
    motor_damping: float
    arm_damping: float
    motor_friction: float
    arm_friction: float
    sharpness: tuple[float, float]
    law: FrictionLaw
    motor_stiffness: float
    weight: complex | None
    rigid: bool
    stiffness: float
    half_gap: float
    damping: float
    cubic: float = 0.0
    yielding: tuple[float, float] | None = None
    gain: float = 1.0
    offset: float = 0.0
    limit: float = math.inf
    lag: float = 0.0
    delay: float = 0.0
    passive: tuple[Passive, ...] = ()
    late: tuple[float, float] = (0.0, 0.0)
    zero: float = 0.0
    servo: Servo | None = None

    def passives(self, where: str, kind: str) -> list[tuple[float, ...]]:
        """Return the numbers of the passive torques of one `kind` at the place `where`."""
        return [p.numbers for p in self.passive if (p.where, p.kind) == (where, kind)]


class Expression(NamedTuple):
    """
    What an effect becomes: its kind, in which words, how it changes MjcfValues, how it is read.

    change(values, effect) is None where MjcfValues hold the effect already: it is a value of the
    model. It may raise Inexpressible. read(values) returns the parameters of the effect in them,
    empty where it is off; None where it is a value of the model, or of another row.
    """

    kind: str
    words: str
    change: Callable[[MjcfValues, Values], MjcfValues] | None = None
    read: Callable[[MjcfValues], Values] | None = None


class Exported(NamedTuple):
    """What one effect or value of a model became."""

    id: str
    kind: str
    words: str


# ---------------------------------------------------------------------- changes


def _with(values: MjcfValues, passive: Passive) -> MjcfValues:
    return replace(values, passive=(*values.passive, passive))


def _lugre(values: MjcfValues, e: Values) -> MjcfValues:
    level = values.motor_friction
    if level <= 0.0:
        raise Inexpressible('coulomb_friction: 0, expected more: MuJoCo divides by it')
    return _with(replace(values, motor_friction=0.0), Passive(MOTOR, LUGRE, (
        e['sigma0'], e['sigma1'], level, level + e['Cs'], e['vs'])))


def steady(torque: float) -> Passive:
    """Return a constant `torque` (N m) on the arm: cogging with no pole, at a quarter turn."""
    return Passive(ARM, COGGING, (torque, 0.0, 0.5 * math.pi))


def _elastic(values: MjcfValues, effect: str) -> None:
    if values.rigid:
        raise Inexpressible(f'{effect}: the model is rigid, expected a transmission')


def _hardening(values: MjcfValues, e: Values) -> MjcfValues:
    _elastic(values, e['id'])
    return replace(values, cubic=values.cubic + e['K3'])


def _bouc_wen(values: MjcfValues, e: Values) -> MjcfValues:
    """Return `values` with the loop: LuGre friction of the twist without a Stribeck part."""
    _elastic(values, e['id'])
    if e['Th'] < 0.0:
        raise Inexpressible('Th < 0: the loop supplies energy, LuGre friction of a tendon cannot')
    return _with(values, Passive(TENDON, LUGRE, (e['Th'] / e['dh'], 0.0, e['Th'], e['Th'], 1.0)))


def _branch(values: MjcfValues, e: Values) -> MjcfValues:
    """Return `values` with the branches: without a gap, K (delta - h s) is a Bouc-Wen loop."""
    if values.half_gap > 0.0:
        raise Inexpressible('the branch shifts the backlash with the direction: no attribute of a '
                            'tendon moves springlength; without backlash it is a Bouc-Wen loop')
    return _bouc_wen(values, {'id': e['id'], 'Th': -values.stiffness * e['h'], 'dh': e['ds']})


def _lag(values: MjcfValues, e: Values) -> MjcfValues:
    return replace(values, lag=e['T'])


def _delay(values: MjcfValues, e: Values) -> MjcfValues:
    return replace(values, delay=e['T'])


def _late(values: MjcfValues, e: Values) -> MjcfValues:
    motor = EFFECTS[e['id']].location == 'motor_sensor'
    return replace(values, late=(e['T'], values.late[1]) if motor else (values.late[0], e['T']))


def _zero(values: MjcfValues, e: Values) -> MjcfValues:
    _elastic(values, e['id'])
    return replace(values, zero=values.zero + e['c'])


def _servo_limit(values: MjcfValues, e: Values) -> MjcfValues:
    servo = values.servo
    if servo is None:
        raise Inexpressible('the model has no servo')
    return replace(values, servo=servo._replace(limit=min(servo.limit, e['umax'])))


# ---------------------------------------------------------------------- reading


def _off_or(**parameters: float) -> Values:
    """Return `parameters` unless the first of them is 0 or infinite: the effect is off."""
    size = next(iter(parameters.values()))
    return parameters if size and math.isfinite(size) else {}


def _read_lugre(values: MjcfValues) -> Values:
    for sigma0, sigma1, level, static, speed in values.passives(MOTOR, LUGRE)[:1]:
        return {'sigma0': sigma0, 'sigma1': sigma1, 'Cs': static - level, 'vs': speed}
    return {}


def _read_cogging(values: MjcfValues) -> Values:
    for size, order, phase in values.passives(MOTOR, COGGING):
        if order:
            return {'A': size, 'N': order, 'phi': phase}
    return {}


def constant_load(values: MjcfValues) -> float:
    """Return the constant torque (N m) on the arm of `values`, a load."""
    return -math.fsum(size * math.sin(phase) for size, order, phase in
                      values.passives(ARM, COGGING) if not order)


def _read_bouc_wen(values: MjcfValues) -> Values:
    for sigma0, _, level, _, _ in values.passives(TENDON, LUGRE)[:1]:
        return {'Th': level, 'dh': level / sigma0}
    return {}


def _read_gravity(values: MjcfValues) -> Values:
    load = values.weight
    if load is None or abs(load) <= 1e-9:
        return {}
    if abs(load.imag) > 1e-6 * abs(load.real) + 1e-9:
        return {'G': abs(load), 'phi': cmath.phase(load)}
    return {'G': load.real}


# ---------------------------------------------------------------------- the table


_PHASE = 'no sensor has it; add it to the reading in your code: y = q + A sin(q + phi)'
_SERVO = 'change the servo in your code'
_LATTICE = 'no sensor has a resolution; round the reading in your code'
EXPRESSIONS = {effect.id: expression for effect, expression in (
    (motor_side.MOTOR_VISCOUS, Expression(NATIVE, 'joint damping')),
    (motor_side.MOTOR_COULOMB, Expression(NATIVE, 'joint frictionloss')),
    (motor_side.STRIBECK, Expression(
        REFUSED, 'friction that falls with speed stands in MJCF only as lugre, which sticks where '
        'this law creeps: diagnose with lugre, without stribeck')),
    (motor_side.LUGRE, Expression(
        NATIVE, 'passive dcmotor: lugre, in place of frictionloss', _lugre, _read_lugre)),
    (motor_side.COULOMB_ASYMMETRY, Expression(
        CONSTRUCT, 'actuator biasprm, its twin: they differ only near standstill',
        lambda v, e: replace(v, offset=v.offset - e['Ca']))),
    (motor_side.VISCOUS_ASYMMETRY, Expression(
        REFUSED, 'no damping depends on the direction: set dof_damping from your code')),
    (motor_side.LOAD_FRICTION, Expression(
        REFUSED, 'no friction of a joint depends on a load: a callback')),
    (motor_side.MOTOR_INERTIA, Expression(NATIVE, 'joint armature')),
    (motor_side.VISCOUS_DRIFT, Expression(
        REFUSED, 'no attribute changes with time: set dof_damping from your code')),
    (motor_side.COGGING, Expression(
        NATIVE, 'passive dcmotor: cogging', lambda v, e: _with(
            v, Passive(MOTOR, COGGING, (e['A'], e['N'], e['phi']))), _read_cogging)),
    (arm_side.ARM_VISCOUS, Expression(
        NATIVE, 'joint damping', None, lambda v: _off_or(Cav=v.arm_damping))),
    (arm_side.ARM_COULOMB, Expression(
        NATIVE, 'joint frictionloss', None, lambda v: _off_or(Cac=v.arm_friction))),
    (arm_side.GRAVITY, Expression(
        NATIVE, 'body inertial: mass and pos, its inertia about the joint kept', None,
        _read_gravity)),
    (arm_side.LOAD_TORQUE, Expression(
        NATIVE, 'passive dcmotor: cogging with 0 poles, a constant torque',
        lambda v, e: _with(v, steady(-e['TL'])), lambda v: _off_or(TL=constant_load(v)))),
    (arm_side.ARM_INERTIA, Expression(NATIVE, 'body inertial: inertia about the joint')),
    (arm_side.DISTURBANCE, Expression(
        REFUSED, 'a profile over time: set qfrc_applied from your code')),
    (gearbox.BACKLASH_GAP, Expression(NATIVE, 'tendon springlength')),
    (gearbox.STIFFNESS, Expression(NATIVE, 'tendon stiffness')),
    (gearbox.HARDENING, Expression(
        NATIVE, 'tendon stiffness: cubic coefficient', _hardening, lambda v: _off_or(K3=v.cubic))),
    (gearbox.BOUC_WEN, Expression(
        NATIVE, 'passive dcmotor on the tendon: lugre', _bouc_wen, _read_bouc_wen)),
    (gearbox.BRANCH, Expression(
        CONSTRUCT, 'without backlash: passive dcmotor on the tendon, lugre', _branch)),
    (gearbox.TRANSMISSION_DAMPING, Expression(NATIVE, 'tendon damping')),
    (gearbox.MESH_ERROR, Expression(
        REFUSED, 'no length of a tendon is a wave of an angle: a callback')),
    (gearbox.SLIP, Expression(
        REFUSED, 'a profile over time: move the joint of the motor from your code')),
    (actuator.TORQUE_GAIN, Expression(
        NATIVE, 'actuator gainprm', lambda v, e: replace(v, gain=v.gain * (1.0 + e['g'])))),
    (actuator.TORQUE_OFFSET, Expression(NATIVE, 'actuator biasprm')),
    (actuator.ACTUATOR_LAG, Expression(
        NATIVE, 'actuator dyntype, dynprm', _lag,
        lambda v: {} if v.servo else _off_or(T=v.lag))),
    (actuator.ACTUATOR_DELAY, Expression(
        NATIVE, 'actuator delay, nsample, interp linear', _delay,
        lambda v: {} if v.servo else _off_or(T=v.delay))),
    (actuator.SATURATION, Expression(
        NATIVE, 'actuator forcerange; ctrlrange where it lags',
        lambda v, e: replace(v, limit=e['umax']),
        lambda v: {} if v.servo else _off_or(umax=v.limit))),
    (actuator.TORQUE_RIPPLE, Expression(
        REFUSED, 'no gain depends on an angle: multiply ctrl in your code')),
    (controller.SERVO_GAIN, Expression(NATIVE, 'actuator position: kp')),
    (controller.SERVO_LIMIT, Expression(NATIVE, 'actuator position: forcerange', _servo_limit)),
    (controller.SETPOINT_DELAY, Expression(
        NATIVE, 'actuator position: delay, nsample, interp linear', _delay,
        lambda v: _off_or(T=v.delay) if v.servo else {})),
    (controller.SETPOINT_LAG, Expression(
        NATIVE, 'actuator position: dyntype, dynprm', _lag,
        lambda v: _off_or(T=v.lag) if v.servo else {})),
    *((effect, Expression(REFUSED, _SERVO)) for effect in (
        controller.SERVO_DEADBAND, controller.SERVO_INTEGRATOR, controller.SERVO_FEEDFORWARD,
        controller.SERVO_DELAY)),
    (encoder.MOTOR_ENCODER_ECCENTRICITY, Expression(REFUSED, _PHASE)),
    (encoder.MOTOR_ENCODER_QUANTISATION, Expression(REFUSED, _LATTICE)),
    (encoder.MOTOR_ENCODER_DELAY, Expression(
        NATIVE, 'sensor jointpos: delay, nsample, interp', _late,
        lambda v: _off_or(T=v.late[0]))),
    (encoder.ARM_ENCODER_ECCENTRICITY, Expression(REFUSED, _PHASE)),
    (encoder.ARM_ENCODER_QUANTISATION, Expression(REFUSED, _LATTICE)),
    (encoder.ARM_ENCODER_DELAY, Expression(
        NATIVE, 'sensor jointpos: delay, nsample, interp', _late,
        lambda v: _off_or(T=v.late[1]))),
    (encoder.ENCODER_OFFSET, Expression(
        NATIVE, 'joint ref, and tendon springlength', _zero, lambda v: _off_or(c=v.zero))),
    (torque_map.TORQUE_MAP, Expression(
        REFUSED, 'no attribute takes a table: add its torque to qfrc_applied of the joint in your '
        'code')),
)}

OTHER = Expression(REFUSED, 'no attribute has its law: add its torque in your code')


def expression_of(effect: str) -> Expression:
    """Return what the `effect` so called becomes, of this package or of a plug-in."""
    return EXPRESSIONS.get(effect, OTHER)


def values_of(model: DriveModel) -> tuple[MjcfValues, list[Exported]]:
    """Return the MjcfValues of `model`, and what each of its effects became."""
    folded = model.folded()
    p, shape = folded.pack(), folded.transmission
    rigid, law = shape.kind == 'rigid', folded.friction_law
    arm_coulomb = sum(effect['Cac'] for effect in folded.effects
                      if effect['id'] == arm_side.ARM_COULOMB.id)
    listed = {effect['id'] for effect in model.effects}
    values = MjcfValues(
        folded.motor_inertia, folded.arm_inertia, folded.viscous_friction, float(p[CAV]),
        folded.coulomb_friction, arm_coulomb,
        (folded.friction_sharpness, folded.arm_sharpness), folded.friction_law,
        folded.position_gain,
        cmath.rect(p[G], p[PHI]) if arm_side.GRAVITY.id in listed else None, rigid,
        shape.stiffness, shape.half_gap, folded.damping, offset=float(p[OFFSET]))
    exported = []
    if shape.kind == 'passive_play':
        values = replace(values, yielding=(shape.hysteresis_stiffness, shape.hysteresis_width))
    elif shape.kind == 'play':
        exported.append(Exported('transmission.kind', REFUSED,
                                 'play supplies energy: no spring of a tendon does'))
    if law.kind == 'physx' and law.static != 1.0:
        exported.append(Exported('friction_law.static', REFUSED,
                                 'friction at rest and in sliding are one in MuJoCo'))
    servo = folded.controller
    if servo is not None:
        values = replace(values, servo=Servo(
            servo.kp, servo.kd, math.inf if servo.torque_limit is None else servo.torque_limit))
        exported.append(Exported('controller', NATIVE, 'actuator position: kp, kv, forcerange'))
        exported += [Exported(f'controller.{name}', REFUSED, _SERVO) for name in (
            'ki', 'feedforward', 'feedforward_inertia', 'delay', 'rate') if getattr(servo, name)]
    for effect in sorted(model.effects, key=lambda e: e['id'] == LUGRE):
        # LuGre is last: it replaces all Coulomb friction.
        values, row = _expressed(values, effect)
        exported.append(row)
    return values, exported


def model_values(values: MjcfValues) -> dict[str, Any]:
    """
    Return a drive with the quantities of MJCF as values of a model file, see DriveModel.

    The inverse of values_of, up to the gain of the actuator, which is a torque constant.
    """
    if values.rigid:
        values = replace(
            values, motor_damping=values.motor_damping + values.arm_damping, arm_damping=0.0,
            motor_friction=values.motor_friction + values.arm_friction, arm_friction=0.0)
    lugre = values.passives(MOTOR, LUGRE)
    data: dict[str, Any] = {
        'motor_inertia': values.motor_inertia, 'arm_inertia': values.arm_inertia,
        'viscous_friction': values.motor_damping,
        'coulomb_friction': lugre[0][2] if lugre else values.motor_friction,
        'position_gain': values.motor_stiffness, 'torque_offset': values.offset,
        'damping': values.damping}
    if values.rigid:
        data['transmission'] = {'kind': 'rigid'}
    else:
        data['transmission'] = {'kind': 'dead_zone', 'stiffness': values.stiffness,
                                'half_gap': values.half_gap}
    if values.yielding is not None:
        data['transmission'] |= {
            'kind': 'passive_play', 'hysteresis_stiffness': values.yielding[0],
            'hysteresis_width': values.yielding[1]}
    if values.servo is not None:
        kp, kd, limit = values.servo
        data['controller'] = {'kind': 'pd', 'kp': kp, 'kd': kd,
                              'torque_limit': limit if math.isfinite(limit) else None}
    data['effects'] = [{'id': name, **parameters} for name, row in EXPRESSIONS.items()
                       if row.read is not None and (parameters := row.read(values))]
    return data


def _expressed(values: MjcfValues, effect: Values) -> tuple[MjcfValues, Exported]:
    expression = expression_of(effect['id'])
    try:
        if expression.change is not None:
            values = expression.change(values, effect)
    except Inexpressible as reason:
        return values, Exported(effect['id'], REFUSED, str(reason))
    return values, Exported(effect['id'], expression.kind, expression.words)


def refused(exported: Sequence[Exported]) -> list[Exported]:
    """Return those of `exported` that the file does not express."""
    return [row for row in exported if row.kind == REFUSED]
