# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Parameters and equations of motion of a two-mass drive, the one truth for the whole package.

Equation (1) of Hovland, with everything referred to the arm side:

    x1' = x3                x1, x2  motor and arm position, rad
    x2' = x4                x3, x4  motor and arm speed, rad/s
    m1 x3' = u - D (x3 - x4) - tau_K - tau_f - K_r x1
    m2 x4' = D (x3 - x4) + tau_K - tau_arm
    tau_f  = Cv x3 + (Cc + Cl |tau_K|) (2/pi) atan(alpha x3)

Other laws of friction than the arctangent: friction_law. Kernels that are called ..._by_law take
any; those without cost less where a model has the arctangent.

Kernels take p, the model's parameters as DriveModel.pack lays them out, and tau_k (N m) for tau_K.

The paper has no torque on the arm (tau_arm = 0) and no friction that depends on the load (Cl = 0).
"""
import cmath
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.errors import expect_choice, expect_keys, InputError, Problems, unknown
from gearbox_monitor.kernels.elementary import arctan, cosine, sine
from gearbox_monitor.kernels.kernel import inline, kernel
from gearbox_monitor.kernels.types import Array, Packed, Values
from gearbox_monitor.plant.effects import Effect, EFFECTS, pack as packed, Parameter, plugins
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.arm_side import ARM_VISCOUS, GRAVITY
from gearbox_monitor.plant.effects.effect import AtRest, MAX_SERVO_DELAY
from gearbox_monitor.plant.effects.motor_side import LUGRE
from gearbox_monitor.plant.transmission import (
    ATAN, EXPLICIT_EULER, FrictionLaw, holding, IMPLICITFAST, INTEGRATORS, KINDS, LAWS, RIGID, RK4,
    side, side_slope, TANH, TWO_OVER_PI)
from gearbox_monitor.presentation import ModelOrigin, on_axis, Saved

# An explicit RK4 step is stable up to 2.785 on the negative real axis.
RK4_STABILITY = 2.7
# Of RK4 in one step of a filter, over the longest gap that it bridges: 0.1 s of computing time at
# most. A kernel takes no more, whatever an adaptive filter makes of the model.
MAX_SUBSTEPS = 100_000

# Places in the packed parameter array; of the inertias stand the inverses, kernels need no other.
(INVERSE_M1, INVERSE_M2, D, CV, CC, ALPHA, KR, OFFSET, KIND, STIFFNESS, HALF_GAP, WIDTH, K_S,
 CAV, CAC, ARM_ALPHA, G, PHI, TL, CL, LAW, SOFTNESS, RATE, STATIC, LEVEL, INTEGRATOR,
 N_PARAMETERS) = range(27)

# Parameters of effects that equations (1) have in the filters, too.
COEFFICIENTS = {'Cav': CAV, 'Cac': CAC, 'TL': TL, 'Cl': CL}

# Values that may make a drive too fast for an integrator.
FAST_VALUES = ('motor_inertia', 'arm_inertia', 'damping', 'viscous_friction', 'coulomb_friction',
               'friction_sharpness', 'position_gain', 'stiffness', 'hysteresis_stiffness',
               'half_gap', 'kp', 'kd')
UNSEEN_TIME = 0.1  # s in which an arm that is not measured would come to rest
ARM_LOAD_MODES = ('none', 'unknown', 'measured')
CONTROLLERS = ('pd',)
ARCTANGENT = FrictionLaw()
AXES = ('rotary', 'prismatic')  # prismatic: m, N and kg instead of rad, N m and kg m^2
DRIVEN_BY = ('torque', 'position')  # what of a recording moves the model in a diagnosis


@dataclass(frozen=True)
class Transmission:
    """Torque over twist: `kind` of transmission.KINDS, N m/rad and rad."""

    kind: str = 'dead_zone'
    stiffness: float = 25.0
    half_gap: float = 0.1
    hysteresis_width: float = 0.0
    hysteresis_stiffness: float = 0.0


@dataclass(frozen=True)
class Controller:
    """
    Servo of the motor: u = kp e + ki int e dt - kd q' + kff r' + kaff r'', e = r - q.

    Of a setpoint r and the motor's position q (rad). kp N m/rad, ki N m/(rad s), kd and
    feedforward kff N m s/rad, feedforward_inertia kaff kg m^2 act on the arm side; torque_limit
    N m of u and of its integral, None for none; delay s of u; rate Hz at which u is computed and
    then held, which is a delay by half a period, None for a continuous servo; tolerance of the
    gains: relative standard deviation. Slopes of r are differences of the recorded setpoints.
    """

    kind: str = 'pd'
    kp: float = 1.0
    kd: float = 0.0
    ki: float = 0.0
    feedforward: float = 0.0
    feedforward_inertia: float = 0.0
    delay: float = 0.0
    rate: float | None = None
    torque_limit: float | None = None
    tolerance: float = 0.0

    def torque(self, setpoint: Array, position: Array, speed: Array, dt: float) -> Array:
        """
        Return the torque [N] (N m) that the servo commands, without its delay.

        Args:
            setpoint: [N], rad.
            position: of the motor [N], rad.
            speed: of the motor [N], rad/s.
            dt: length of a sample, s.
        """
        limit = math.inf if self.torque_limit is None else self.torque_limit
        error = setpoint - position
        slope = np.diff(setpoint, prepend=setpoint[0]) / dt
        forward = (self.feedforward * slope
                   + self.feedforward_inertia * np.diff(slope, prepend=slope[0]) / dt)
        integral = np.clip(self.ki * np.cumsum(error) * dt, -limit, limit) if self.ki else 0.0
        u: Array = np.clip(self.kp * error + integral - self.kd * speed + forward, -limit, limit)
        return u


@dataclass(frozen=True)
class DriveModel(Saved):
    """A drive's parameters in SI units, reflected to the arm side (see the module's equations)."""

    motor_inertia: float = 0.006442
    arm_inertia: float = 0.023454
    damping: float = 0.01
    viscous_friction: float = 0.1
    coulomb_friction: float = 0.27
    friction_sharpness: float = 100.0
    arm_friction_sharpness: float | None = None
    friction_law: FrictionLaw = ARCTANGENT
    position_gain: float = 0.01
    torque_offset: float = 0.0
    gear_ratio: float = 1.0
    torque_constant: float = 1.0
    axis: str = 'rotary'
    arm_load: str = 'none'
    driven_by: str = 'torque'
    transmission: Transmission = Transmission()
    effects: tuple[Values, ...] = ()
    tolerance: float = 0.0
    sharpness_tolerance: float = 1.0
    zero_tolerance: float = 0.0
    process_torque: float | None = None
    process_torque_time: float = 0.0
    controller: Controller | None = None
    friction_tolerance: float = 0.3
    damping_tolerance: float = 0.3
    inertia_tolerance: float = 0.1
    torque_gain_tolerance: float = 0.1
    delay_tolerance: float = 0.002
    encoder_delay_tolerance: float = 0.002
    timestep: float | None = None
    integrator: str = INTEGRATORS[0]
    # No value: it goes along where a model is derived, and is neither compared nor written.
    origin: ModelOrigin = field(default=ModelOrigin(), compare=False, repr=False)

    def __post_init__(self) -> None:
        for name, usual, kind in _TYPES:  # searches make many: the usual type first
            value = getattr(self, name)
            if type(value) is not usual and not isinstance(value, kind):
                expected = 'a number' if kind is _NUMBER else usual.__name__
                hint = ("; load_model('drive.yaml') reads a file"
                        if isinstance(value, str) or hasattr(value, '__fspath__') else '')
                raise InputError(f'DriveModel: {name}: {str(value)[:40]!r}, expected {expected}'
                                 f'{hint}')

    @property
    def effort_scale(self) -> float:
        """Torque on the arm side (N m) for one unit of the motor's effort (N m, or A)."""
        return self.gear_ratio * self.torque_constant

    def with_torque_constant(self, constant: float) -> 'DriveModel':
        """
        Return the same drive for torques that are read with another torque `constant` (N m/A).

        What the two differ by becomes the effect torque_gain, which goes where nothing is left.
        """
        ratio = self.torque_constant / constant
        gain = ratio
        remaining: list[Values] = []
        for effect in self.effects:
            if effect['id'] == TORQUE_GAIN.id:
                gain *= 1.0 + effect['g']
            elif effect['id'] in EFFECTS:
                scaled = {p.name: effect[p.name] / ratio
                          for p in EFFECTS[effect['id']].parameters if p.of_command}
                remaining.append({**effect, **scaled})
            else:
                remaining.append(effect)
        if abs(gain - 1.0) > 1e-12:
            remaining.append({'id': TORQUE_GAIN.id, 'g': gain - 1.0})
        return replace(self, torque_constant=constant, effects=tuple(remaining))

    def folded(self) -> 'DriveModel':
        """Return the model with the effects in its values that only replace one of them."""
        changes: dict[str, float] = {}
        remaining = []
        for effect in self.effects:
            entry = EFFECTS.get(effect['id'])
            if entry and entry.adds_to:
                value = changes.get(entry.adds_to, self.value(entry.adds_to))
                changes[entry.adds_to] = value + effect[entry.parameters[0].name]
            elif entry and entry.replaces:
                changes[entry.replaces] = effect[entry.parameters[0].name]
            else:
                remaining.append(effect)
        if len(remaining) == len(self.effects):
            return self
        return replace(self.with_values(changes), effects=tuple(remaining))

    def value(self, name: str) -> float:
        """Return the value `name` of the model, its transmission or controller, 0 without one."""
        if name in _OF_CONTROLLER and self.controller is None:
            return 0.0
        value: float = getattr(self.transmission if name in _OF_TRANSMISSION else
                               self.controller if name in _OF_CONTROLLER else self, name)
        return value

    def with_values(self, values: Values) -> 'DriveModel':
        """Return the model with `values` {name of a field, also of a part: number}, unchecked."""
        shape = {k: v for k, v in values.items() if k in _OF_TRANSMISSION}
        gains = {k: v for k, v in values.items() if k in _OF_CONTROLLER}
        own = {k: v for k, v in values.items() if k not in shape and k not in gains}
        servo = replace(self.controller, **gains) if self.controller else None
        return replace(self, transmission=replace(self.transmission, **shape), controller=servo,
                       **own)

    @property
    def lasting(self) -> bool:
        """Whether torque that the model does not explain lasts, as on a real drive."""
        return self.process_torque_time > 0.0 or self.driven_by == 'position'

    def exact(self) -> 'DriveModel':
        """Return the model without tolerances of what filters compute with."""
        return self.with_(**dict.fromkeys(TOLERANCES, 0.0))

    def without_arm(self) -> 'DriveModel':
        """
        Return the model for filters that never see the arm: tau_K is all that the motor drives.

        Whatever loads it then, nothing flows back to the motor. Friction of its own keeps the
        arm's speed, which nothing corrects, within bounds.
        """
        effects = [e for e in self.effects if not loads_arm(e['id'])]
        return self.with_(arm_load='none', damping=0.0, effects=[
            *effects, {'id': ARM_VISCOUS.id, 'Cav': self.arm_inertia / UNSEEN_TIME}])

    def pack(self) -> Array:
        """
        Return the parameters as the float64 array [N_PARAMETERS] that kernels take.

        With the effects that the filters know; effects.pack has the others.
        """
        folded = self.folded()
        if folded is not self:
            return folded.pack()
        p = np.zeros(N_PARAMETERS)
        p[INVERSE_M1], p[INVERSE_M2] = 1.0 / self.motor_inertia, 1.0 / self.arm_inertia
        # A rigid transmission has one inertia: between its halves is no speed to damp.
        p[D] = 0.0 if self.transmission.kind == 'rigid' else self.damping
        p[CV], p[CC] = self.viscous_friction, self.coulomb_friction
        p[ALPHA], p[KR], p[OFFSET] = (
            self.friction_sharpness, self.position_gain, self.torque_offset)
        p[ARM_ALPHA] = self.arm_sharpness
        t = self.transmission
        p[KIND] = KINDS.index(t.kind)
        p[STIFFNESS], p[HALF_GAP] = t.stiffness, t.half_gap
        p[WIDTH], p[K_S] = t.hysteresis_width, t.hysteresis_stiffness
        for effect in self.effects:
            if effect['id'] in EFFECTS and EFFECTS[effect['id']].in_filters:
                for name, place in COEFFICIENTS.items():
                    p[place] += effect.get(name, 0.0)
        p[G], p[PHI] = weight_of(self.effects)
        p[LAW], p[STATIC] = self.friction_law.code, self.friction_law.static
        p[INTEGRATOR] = INTEGRATORS.index(self.integrator)
        if self.friction_law.constraint:
            self._pack_constraint(p)
        return p

    def _pack_constraint(self, p: Array) -> None:
        """Fill in what a friction that is a constraint needs in the packed model `p`."""
        p[SOFTNESS] = self.friction_law.softness
        p[RATE] = self.friction_law.rate(self.timestep or math.inf)
        # LuGre stands in place of Coulomb friction, and a rigid drive is one joint.
        p[LEVEL] = -p[CC] if any(e['id'] == LUGRE.id for e in self.effects) else 0.0
        inertias = [self.motor_inertia, self.arm_inertia]
        if self.transmission.kind == 'rigid':
            p[LEVEL] += p[CAC]
            p[CAC], inertias = 0.0, [sum(inertias)] * 2
        # Where effects ask for the sign of a speed: nearest to the ramp of the constraint.
        for place, level, inertia in zip((ALPHA, ARM_ALPHA), (p[CC], p[CAC]), inertias):
            if level > 0.0:
                p[place] = p[RATE] * inertia / (TWO_OVER_PI * level * max(p[SOFTNESS], 0.01))

    @property
    def arm_sharpness(self) -> float:
        """Sharpness of Coulomb friction on the arm, s/rad: that of the motor unless stated."""
        own = self.arm_friction_sharpness
        return self.friction_sharpness if own is None else own

    def friction_side(self, speed: Array, arm: bool = False) -> Array:
        """Return the share of Coulomb friction at `speed` (rad/s), of the motor or the `arm`."""
        v = self.pack()[ARM_ALPHA if arm else ALPHA] * speed
        if self.friction_law.constraint:
            ramp: Array = np.clip(TWO_OVER_PI * v, -1.0, 1.0)
            return ramp
        smooth: Array = (np.tanh(v) if self.friction_law.kind == 'tanh'
                         else TWO_OVER_PI * np.arctan(v))
        return smooth

    def pack_effects(self) -> Array:
        """Return effects and servo as the float64 array [N_EFFECTS] that kernels take."""
        servo = self.folded().controller
        # A simulator with steps of its own takes what a filter has reached as it is in a step.
        holds = self.friction_law.kind == 'mujoco' and self.integrator != INTEGRATORS[RK4]
        if servo is None:
            return packed(self.effects, held=holds)
        limit = math.inf if servo.torque_limit is None else servo.torque_limit
        hold = 0.5 / servo.rate if servo.rate else 0.0
        return packed(self.effects, (servo.kp, servo.kd, limit, servo.ki, servo.delay + hold,
                                     servo.feedforward, servo.feedforward_inertia), holds)

    def to_dict(self) -> dict[str, Any]:
        """Return plain values, as a model file holds them."""
        data = {name: getattr(self, name) for name in KEYS}
        if self.controller is None:
            del data['controller']
        else:
            data['controller'] = dict(vars(self.controller))
        data['transmission'] = dict(vars(self.transmission))
        law = self.friction_law
        data['friction_law'] = {'kind': law.kind, **{
            name: list(v) if isinstance(v := getattr(law, name), tuple) else v
            for name in _OF_LAW[law.kind]}}
        data['effects'] = [dict(e) for e in self.effects]
        return data

    def with_(self, **changes: Any) -> 'DriveModel':
        """Return a checked copy with `changes` (names of fields of the model or transmission)."""
        data = self.to_dict()
        for name, value in changes.items():
            (data['transmission'] if name in _OF_TRANSMISSION else data)[name] = value
        return replace(model_from_dict(data, 'model'), origin=self.origin)


KEYS = tuple(f.name for f in fields(DriveModel) if f.compare)  # of a model file
_NUMBER = (int, float, np.number)
_TYPES: tuple[tuple[str, type, Any], ...] = (
    *((f.name, float, _NUMBER) for f in fields(DriveModel) if f.type is float),
    ('transmission', Transmission, Transmission), ('friction_law', FrictionLaw, FrictionLaw),
    ('effects', tuple, (tuple, list)))
_OF_TRANSMISSION = {f.name for f in fields(Transmission)}
_OF_CONTROLLER = {'kp', 'kd', 'ki', 'feedforward', 'feedforward_inertia', 'delay', 'torque_limit'}
_PARTS: dict[str, tuple[Any, Sequence[str]]] = {  # of a model: dataclass, kinds
    'transmission': (Transmission, KINDS), 'friction_law': (FrictionLaw, LAWS),
    'controller': (Controller, CONTROLLERS)}
_OF_LAW: dict[str, Collection[str]] = {
    **dict.fromkeys(LAWS, ()), 'mujoco': ('solref', 'solimp'), 'physx': ('static',)}

# How far values may be off, either way, see estimation.consider; a file that states none has the
# defaults.
TOLERANCES = ('friction_tolerance', 'damping_tolerance', 'inertia_tolerance',
              'torque_gain_tolerance', 'delay_tolerance', 'encoder_delay_tolerance')

OPTIONAL = ('process_torque', 'arm_friction_sharpness', 'timestep')  # null in a file: not stated
RANGES = {parameter.name: parameter for parameter in (
    Parameter('motor_inertia', 'kg m^2', 0.0, 1e6, exclusive=True),
    Parameter('arm_inertia', 'kg m^2', 0.0, 1e6, exclusive=True),
    Parameter('damping', 'N m s/rad', 0.0, 1e9),
    # A negative slope has been identified on real drives whose Coulomb part falls with speed.
    Parameter('viscous_friction', 'N m s/rad', -1e9, 1e9),
    Parameter('coulomb_friction', 'N m', 0.0, 1e9),
    Parameter('friction_sharpness', 's/rad', 0.0, 1e9, exclusive=True),
    Parameter('arm_friction_sharpness', 's/rad', 0.0, 1e9, exclusive=True),
    Parameter('static', '-', 1.0, 1e3),
    Parameter('timestep', 's', 0.0, 1.0, exclusive=True),
    Parameter('position_gain', 'N m/rad', 0.0, 1e9),
    Parameter('torque_offset', 'N m', -1e9, 1e9),
    Parameter('gear_ratio', '-', -1e6, 1e6),
    Parameter('torque_constant', 'N m/A', 0.0, 1e9, exclusive=True),
    Parameter('tolerance', '-', 0.0, 1.0),
    Parameter('sharpness_tolerance', '-', 0.0, 10.0),
    Parameter('zero_tolerance', 'rad', 0.0, 1e3),
    Parameter('process_torque', 'N m', 0.0, 1e9),
    Parameter('process_torque_time', 's', 0.0, 1e3),
    Parameter('friction_tolerance', '-', 0.0, 1.0),
    Parameter('damping_tolerance', '-', 0.0, 1.0),
    Parameter('inertia_tolerance', '-', 0.0, 1.0),
    Parameter('torque_gain_tolerance', '-', 0.0, 1.0),
    Parameter('delay_tolerance', 's', 0.0, 1.0),
    Parameter('encoder_delay_tolerance', 's', 0.0, 1.0),
    Parameter('stiffness', 'N m/rad', 0.0, 1e12, exclusive=True),
    Parameter('half_gap', 'rad', 0.0, 1e3),
    Parameter('hysteresis_width', 'rad', 0.0, 1e3),
    Parameter('hysteresis_stiffness', 'N m/rad', 0.0, 1e12),
    Parameter('kp', 'N m/rad', 0.0, 1e9, exclusive=True),
    Parameter('kd', 'N m s/rad', 0.0, 1e9),
    Parameter('torque_limit', 'N m', 0.0, 1e9, exclusive=True),
    Parameter('ki', 'N m/(rad s)', 0.0, 1e9),
    Parameter('feedforward', 'N m s/rad', 0.0, 1e9),
    Parameter('feedforward_inertia', 'kg m^2', 0.0, 1e9),
    Parameter('delay', 's', 0.0, MAX_SERVO_DELAY),
    Parameter('rate', 'Hz', 20.0, 1e6))}


def expect_model(model: object) -> DriveModel:
    """Return `model`, an argument, with values of a file. Raises InputError."""
    if isinstance(model, DriveModel):
        model_from_dict(model.to_dict(), 'model')
        return model
    raise InputError(f'model: {type(model).__name__} {str(model)[:40]!r}, expected a DriveModel, '
                     "as load_model('drive.yaml') returns it")


def _number(value: Any, name: str, source: str, axis: str) -> float:
    RANGES[name].expect(value, f'{source}: {name}', axis)
    return float(value)


def _own_keys(data: Any, name: str, source: str, allowed: Collection[str], problems: Problems
              ) -> dict[str, Any]:
    """Return what of the block `name` is `allowed`; the rest goes into `problems`."""
    with problems:
        expect_keys(data, name, source, allowed, name == 'model')
    return {k: v for k, v in data.items() if k in allowed} if isinstance(data, dict) else {}


def _part(data: Any, name: str, source: str, axis: str) -> Any:
    """Return the part `name` of a model, of the dataclass and with a kind of _PARTS."""
    of, kinds = _PARTS[name]
    problems, own = Problems(), {f.name for f in fields(of)}
    values = _own_keys(data, name, source, own, problems)
    kind = values.setdefault('kind', kinds[0])
    with problems:
        expect_choice(kind, f'{name}.kind', source, kinds)
    if name == 'controller' and 'kp' not in values:
        problems.found.append(f'{source}: controller.kp: missing, expected a number > 0 '
                              f'({on_axis("N m/rad", axis)})')
    allowed = _OF_LAW[kind] if of is FrictionLaw and kind in LAWS else own
    where = source if of is Transmission else f'{source}: {name}'
    for key in values.keys() - {'kind'}:
        with problems:
            if key not in allowed:
                raise InputError(f'{source}: {name}.{key}: not of the law {kind}, expected only '
                                 + ', '.join(('kind', *allowed)))
            if key in ('solref', 'solimp'):
                values[key] = _pair(values[key], f'{source}: {name}.{key}')
            elif values[key] is not None or of is not Controller:
                values[key] = _number(values[key], key, where, axis)
    problems.raise_all()
    return of(**values)


def model_from_dict(data: Any, source: str) -> DriveModel:
    """
    Return a DriveModel from the mapping `data`; missing keys keep the paper's values.

    Raises InputError naming `source`, key, value and what was expected, of all that is wrong.
    """
    problems = Problems()
    values = _own_keys(data, 'model', source, KEYS, problems)
    axis = str(values.get('axis'))
    for name in _PARTS:
        if name in values and (name != 'controller' or values[name] is not None):
            with problems:
                values[name] = _part(values[name], name, source, axis)
    if 'effects' in values:
        with problems:
            values['effects'] = _effects(values['effects'], source, axis)
            _check_input(values['effects'], values.get('controller') is not None, source)
    for name, choices in (('arm_load', ARM_LOAD_MODES), ('axis', AXES), ('driven_by', DRIVEN_BY),
                          ('integrator', INTEGRATORS)):
        if name in values:
            with problems:
                expect_choice(values[name], name, source, choices)
    for name in values:
        if name in RANGES and not (name in OPTIONAL and values[name] is None):
            with problems:
                values[name] = _number(values[name], name, source, axis)
    if values.get('controller') is not None and values.get('driven_by') == 'position':
        problems.found.append(f'{source}: driven_by: position, expected torque with a controller, '
                              'whose setpoint drives the model')
    problems.found += _simulator_problems(values, source)
    if values.get('gear_ratio') == 0:
        problems.found.append(f'{source}: gear_ratio: 0, expected a number other than 0')
    problems.raise_all()
    return DriveModel(**values)


def _simulator_problems(values: dict[str, Any], source: str) -> list[str]:
    """Return what is wrong with friction law, timestep and integrator together."""
    law, problems = values.get('friction_law'), []
    constraint = isinstance(law, FrictionLaw) and law.constraint
    if values.get('timestep') is None:
        for name in ('friction_law',) * constraint + ('integrator',) * (
                values.get('integrator', INTEGRATORS[0]) != INTEGRATORS[0]):
            value = law.kind if name == 'friction_law' and law else values[name]
            problems.append(f'{source}: timestep: missing, expected that of the simulator (s) '
                            f'with {name}: {value}')
    if constraint and law and values.get('driven_by') == 'position':
        problems.append(f'{source}: friction_law: {law.kind}, expected atan or tanh with '
                        'driven_by: position')
    return problems


def _pair(value: Any, where: str) -> tuple[float, float]:
    good = isinstance(value, (list, tuple)) and len(value) >= 2 and all(
        isinstance(v, (int, float)) and math.isfinite(v) for v in value)
    if not good:
        raise InputError(f'{where}: {value!r}, expected two numbers, as in an MJCF file')
    return float(value[0]), float(value[1])


def _check_input(items: Collection[Values], servo: bool, source: str) -> None:
    """Raise InputError for effects of a servo without one, or of a torque with one."""
    for effect in items:
        entry = EFFECTS.get(effect['id'])
        if entry and entry.location == 'controller' and not servo:
            raise InputError(f'{source}: effects.{entry.id}: acts on a servo, expected the key '
                             'controller in the model')
        if entry and entry.torque_only and servo:
            raise InputError(f'{source}: effects.{entry.id}: acts on a recorded torque, expected '
                             'an effect of the controller, which takes a setpoint')


def _effects(items: Any, source: str, axis: str) -> tuple[Values, ...]:
    if not isinstance(items, (list, tuple)):
        raise InputError(f'{source}: effects: {items!r}, expected a list')
    result: list[Values] = []
    entries, problems = EFFECTS, Problems()
    for item in items:
        name = item.get('id') if isinstance(item, dict) else None
        if isinstance(name, str) and name not in entries:
            entries = {**EFFECTS, **plugins()}
        with problems:
            if not isinstance(name, str) or name not in entries:
                raise InputError(f'{source}: effects: {item!r}: unknown id, '
                                 f'{unknown(name, entries)}')
            if not entries[name].additive and any(name == e['id'] for e in result):
                raise InputError(f'{source}: effects.{name}: appears twice, expected each id once')
            result.append(_effect(item, entries[name], source, axis))
    problems.raise_all()
    return tuple(result)


def _effect(item: Any, effect: Effect, source: str, axis: str) -> Values:
    problems, name = Problems(), effect.id
    with problems:
        expect_keys(item, f'effects.{name}', source, {'id', *(p.name for p in effect.parameters)})
    for parameter in effect.parameters:
        with problems:
            parameter.expect(item.get(parameter.name, parameter.default),
                             f'{source}: effects.{name}.{parameter.name}', axis)
    problems.raise_all()
    if effect.problem and (problem := effect.problem(item)):
        raise InputError(f'{source}: effects.{name}.{problem}')
    return dict(item)


def expect_torque_input(model: DriveModel, source: str) -> None:
    """Raise InputError, which names the `source` of `model`, if a servo takes a setpoint."""
    if model.controller is not None:
        raise InputError(f'{source}: controller: takes a setpoint, expected a model without: this '
                         'command gives the motor a torque')


def loads_arm(name: str) -> bool:
    """Return whether the effect `name` is a load on the arm that the filters' equations have."""
    effect = EFFECTS.get(name)
    return effect is not None and effect.in_filters and effect.location == 'arm_side'


def weight_of(effects: Iterable[Values]) -> tuple[float, float]:
    """Return G (N m) and phi (rad) of the weight G sin(x2 + phi) that `effects` sum up to."""
    total = sum((e['G'] * cmath.exp(1j * e.get('phi', 0.0)) for e in effects
                 if e['id'] == GRAVITY.id), 0j)
    return (abs(total), cmath.phase(total)) if total.imag else (total.real, 0.0)


def _at_rest(effect: Values, sharpness: float) -> AtRest:
    entry = EFFECTS.get(effect['id'])
    return entry.at_rest(effect, sharpness) if entry and entry.at_rest else AtRest(0.0)


def fastest_eigenvalue(model: DriveModel) -> float:
    """
    Return the magnitude of the fastest eigenvalue (1/s) of the drive `model`, linearised at rest.

    In contact and in the gap, where strong damping is faster, and where the friction slopes
    Cv + Cc (2/pi) alpha of motor and arm are steepest. Friction that depends on the load counts
    with the torque of a twist by the half gap.
    """
    model = model.folded()
    p = model.pack()
    if not np.isfinite(p).all():
        return math.inf
    if model.transmission.kind == 'rigid':
        torque = abs(p[G]) + abs(p[TL])
    else:
        torque = model.transmission.stiffness * model.transmission.half_gap
    slope, spring = motor_friction_slope_by_law(0.0, torque, p), 0.0
    if model.controller is not None:
        slope, spring = slope + model.controller.kd, model.controller.kp
    arm_slope = arm_load_slopes(0.0, 0.0, p)[1]
    for effect in model.effects:
        at_rest = _at_rest(effect, p[ALPHA])
        slope += at_rest.damper
        arm_slope += at_rest.arm_damper
        spring += at_rest.spring
    if model.transmission.kind == 'rigid':
        inertia = model.motor_inertia + model.arm_inertia
        if model.timestep is not None and model.integrator != INTEGRATORS[RK4]:
            # Damping at the end of a step brakes it: what it does not take in acts as before.
            kd = model.controller.kd if model.controller is not None else 0.0
            share, _ = braked(model.timestep, kd, p)
            implicit = (1.0 / share - 1.0) * inertia / model.timestep
            slope, inertia = slope - min(implicit, slope + arm_slope), inertia / share
        return max((slope + arm_slope) / inertia, math.sqrt(spring / inertia))
    m1, m2, d = model.motor_inertia, model.arm_inertia, model.damping
    fastest = 0.0
    for k in (model.transmission.stiffness + model.transmission.hysteresis_stiffness, 0.0):
        a = np.array([
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-(k + model.position_gain + spring) / m1, k / m1, -(d + slope) / m1, d / m1],
            [k / m2, -(k + p[G]) / m2, d / m2, -(d + arm_slope) / m2]])
        if not np.isfinite(a).all():
            return math.inf
        fastest = max(fastest, float(np.abs(np.linalg.eigvals(a)).max()))
    return fastest


def fast_values(model: DriveModel) -> str:
    """Return which value or effect of the `model` makes it fast: without it, it is the slowest."""
    model, usual = model.folded(), DriveModel()
    slower = {f'{name}: {model.value(name):g}': model.with_values({name: usual.value(name)})
              for name in FAST_VALUES if model.value(name) != usual.value(name)}
    slower.update((f'effect {e["id"]}', replace(model, effects=tuple(
        other for other in model.effects if other is not e))) for e in model.effects)
    return min(slower, key=lambda name: fastest_eigenvalue(slower[name]), default='model')


def expect_integrable(model: DriveModel, dt: float, source: str,
                      most: int = MAX_SUBSTEPS) -> None:
    """
    Raise InputError if a step over the drive takes too many RK4 substeps to be computed in time.

    Args:
        model: the drive.
        dt: longest step, s.
        source: file or node that the message names.
        most: number of substeps that is allowed.

    Raises:
        InputError: names the values of the model that are too fast.

    """
    eigenvalue = fastest_eigenvalue(model)
    limit = most * RK4_STABILITY / dt
    if not eigenvalue <= limit:
        raise InputError(f'{source}: {fast_values(model)}: the drive moves at {eigenvalue:.3g} '
                         f'1/s, expected at most {limit:.3g} 1/s, {most} integration steps '
                         f'in {dt:g} s')


@kernel
def substeps(dt: float, eigenvalue: float) -> int:
    """
    Return the number of RK4 substeps for a step of `dt` s: n = ceil(dt eigenvalue / 2.7).

    At most MAX_SUBSTEPS, whatever the numbers are.
    """
    n = dt * eigenvalue / RK4_STABILITY
    if not n < MAX_SUBSTEPS:
        return MAX_SUBSTEPS
    return max(1, int(math.ceil(n)))


@inline
def braked(h: float, damper: float, p: Array) -> tuple[float, float]:
    """
    Return by which factors linear damping at its end changes accelerations in a step.

    MuJoCo's Euler has that of the joints there, its implicitfast all of a joint, and its Euler
    without eulerdamp none.

    Args:
        h: length of the step, s.
        damper: of a servo, N m s/rad.
        p: packed model.

    Returns:
        Factors for motor and arm; 0.0 where steps are those of the Runge-Kutta method.
    """
    if p[INTEGRATOR] == RK4:
        return 0.0, 0.0
    if p[INTEGRATOR] == EXPLICIT_EULER:
        return 1.0, 1.0
    motor, arm = p[CV], p[CAV]
    if p[INTEGRATOR] == IMPLICITFAST:
        motor, arm = motor + p[D] + damper, arm + p[D]
    if p[KIND] == RIGID:
        both = 1.0 / (1.0 + h * (motor + arm) / (1.0 / p[INVERSE_M1] + 1.0 / p[INVERSE_M2]))
        return both, both
    return 1.0 / (1.0 + h * motor * p[INVERSE_M1]), 1.0 / (1.0 + h * arm * p[INVERSE_M2])


def steps_of(model: DriveModel, dt: float, eigenvalue: float) -> int:
    """
    Return the number of integration steps in a sample.

    Args:
        model: the drive.
        dt: length of a sample, s.
        eigenvalue: of the drive, 1/s.

    Returns:
        Those of the simulator that `model` states, or a multiple if the drive is too fast for it;
        else as few as are stable.
    """
    own = max(1, round(dt / model.timestep)) if model.timestep else 1
    return own * substeps(dt / own, eigenvalue)


@inline
def motor_friction(x3: float, tau_k: float, p: Packed) -> float:
    """
    Return the friction of the motor, the last of equations (1).

    Args:
        x3: speed of the motor, rad/s.
        tau_k: torque of the transmission, N m.
        p: packed model.

    Returns:
        tau_f, N m.
    """
    return p[CV] * x3 + (p[CC] + p[CL] * abs(tau_k)) * TWO_OVER_PI * arctan(p[ALPHA] * x3)


@kernel
def motor_friction_slope(x3: float, tau_k: float, p: Packed) -> float:
    """
    Return the slope of the motor's friction over its speed.

    Args:
        x3: speed of the motor, rad/s.
        tau_k: torque of the transmission, N m.
        p: packed model.

    Returns:
        d tau_f / d x3, N m s/rad.
    """
    v = p[ALPHA] * x3
    return p[CV] + (p[CC] + p[CL] * abs(tau_k)) * TWO_OVER_PI * p[ALPHA] / (1.0 + v * v)


@kernel
def motor_friction_slope_by_law(x3: float, tau_k: float, p: Array) -> float:
    """Do as motor_friction_slope(x3, tau_k, p), any law; a constraint counts until it slips."""
    if p[LAW] > TANH:
        return p[CV] + p[RATE] / (p[INVERSE_M1] * (1.0 + p[SOFTNESS]))
    return p[CV] + (p[CC] + p[CL] * abs(tau_k)) * p[ALPHA] * side_slope(p[ALPHA] * x3, p[LAW])


@kernel
def motor_friction_load_slope(x3: float, tau_k: float, p: Array) -> float:
    """
    Return the slope of the motor's friction over the transmitted torque.

    Args:
        x3: speed of the motor, rad/s.
        tau_k: torque of the transmission, N m.
        p: packed model.

    Returns:
        d tau_f / d tau_K, N m per N m; at tau_K = 0 the mean of both sides, 0.
    """
    if p[CL] == 0.0:
        return 0.0  # spares an arctangent in each stage of each step
    sign = 1.0 if tau_k > 0.0 else (-1.0 if tau_k < 0.0 else 0.0)
    return p[CL] * sign * side(p[ALPHA] * x3, p[LAW])


@inline
def motor_acceleration(x1: float, x3: float, x4: float, u: float, tau_k: float,
                       p: Packed) -> float:
    """
    Return the acceleration of the motor, the third of equations (1).

    Args:
        x1: position of the motor, rad.
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        u: torque of the actuator, N m.
        tau_k: torque of the transmission, N m.
        p: packed model.

    Returns:
        x3', rad/s^2.
    """
    return (u + p[OFFSET] - p[D] * (x3 - x4) - tau_k - p[KR] * x1
            - motor_friction(x3, tau_k, p)) * p[INVERSE_M1]


@kernel
def motor_acceleration_by_law(x1: float, x3: float, x4: float, u: float, tau_k: float,
                              p: Packed) -> float:
    """
    Do as motor_acceleration for any law of friction.

    Args:
        x1: position of the motor, rad.
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        u: torque of the actuator, N m.
        tau_k: torque of the transmission, N m.
        p: packed model.

    Returns:
        x3', rad/s^2.
    """
    if p[LAW] == ATAN:
        return motor_acceleration(x1, x3, x4, u, tau_k, p)
    torque = u + p[OFFSET] - p[D] * (x3 - x4) - tau_k - p[KR] * x1 - p[CV] * x3
    level = p[CC] + p[LEVEL] + p[CL] * abs(tau_k)
    if p[LAW] == TANH:
        torque -= level * side(p[ALPHA] * x3, p[LAW])
    else:
        torque -= holding(torque, p[RATE] * x3 / p[INVERSE_M1], level, p[SOFTNESS], p[STATIC])
    return torque * p[INVERSE_M1]


@kernel
def arm_constraint(x3: float, x4: float, tau_k: float, tau_arm: float, p: Packed) -> float:
    """
    Return the Coulomb friction of the arm that is a constraint, which is no part of arm_load.

    Args:
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        tau_k: torque of the transmission, N m.
        tau_arm: other load on the arm, N m.
        p: packed model.

    Returns:
        Torque, N m; 0 where the law is another.
    """
    if p[LAW] <= TANH or p[CAC] == 0.0:
        return 0.0
    return holding(p[D] * (x3 - x4) + tau_k - tau_arm, p[RATE] * x4 / p[INVERSE_M2], p[CAC],
                   p[SOFTNESS], p[STATIC])


@inline
def arm_acceleration(x3: float, x4: float, tau_k: float, tau_arm: float, p: Packed) -> float:
    """
    Return the acceleration of the arm, the fourth of equations (1).

    Args:
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        tau_k: torque of the transmission, N m.
        tau_arm: load on the arm, N m.
        p: packed model.

    Returns:
        x4', rad/s^2.
    """
    return (p[D] * (x3 - x4) + tau_k - tau_arm) * p[INVERSE_M2]


@inline
def steady_arm_load(x4: float, p: Packed) -> float:
    """Return viscous friction at `x4` (rad/s) and constant load (N m) on the arm of `p`."""
    return p[CAV] * x4 + p[TL]


@kernel
def arm_load(x2: float, x4: float, p: Packed) -> float:
    """
    Return the load on the arm: viscous and Coulomb friction, gravity and a constant load.

    Args:
        x2: position of the arm, rad.
        x4: speed of the arm, rad/s.
        p: packed model.

    Returns:
        tau_arm, N m.
    """
    torque = steady_arm_load(x4, p)
    # Most drives have neither: this spares two transcendental functions in each stage of a step.
    if p[CAC] != 0.0 and p[LAW] <= TANH:
        torque += p[CAC] * side(p[ARM_ALPHA] * x4, p[LAW])
    if p[G] != 0.0:
        torque += gravity(x2, p)
    return torque


@inline
def gravity(x2: float, p: Packed) -> float:
    """Return the load (N m) of the weight of the arm of `p` at `x2` (rad)."""
    return p[G] * sine(x2 + p[PHI])


@kernel
def arm_load_slopes(x2: float, x4: float, p: Array) -> tuple[float, float]:
    """
    Return the slopes of arm_load over position and speed of the arm.

    Args:
        x2: position of the arm, rad.
        x4: speed of the arm, rad/s.
        p: packed model.

    Returns:
        d tau_arm / d x2 (N m/rad) and d tau_arm / d x4 (N m s/rad).
    """
    if p[LAW] > TANH:
        slope = p[RATE] / (p[INVERSE_M2] * (1.0 + p[SOFTNESS])) if p[CAC] != 0.0 else 0.0
    else:
        slope = p[CAC] * p[ARM_ALPHA] * side_slope(p[ARM_ALPHA] * x4, p[LAW])
    on_speed = p[CAV] + slope
    return p[G] * cosine(x2 + p[PHI]) if p[G] != 0.0 else 0.0, on_speed


@kernel
def rigid_torque(x1: float, x3: float, u: float, tau_arm: float, p: Array) -> float:
    """
    Return tau_K of a rigid transmission: with it motor and arm accelerate alike.

    Friction that grows with the transmitted torque makes tau + k |tau| = c of it, |k| < 1.

    Args:
        x1: position of the motor, rad.
        x3: speed of the motor, rad/s.
        u: all torques on the motor but friction, N m.
        tau_arm: load on the arm, N m.
        p: packed model.

    Returns:
        Torque, N m.
    """
    if p[LAW] > TANH:
        return _held_torque(x1, x3, u, tau_arm, p)
    both = 1.0 / (p[INVERSE_M1] + p[INVERSE_M2])
    friction = p[CV] * x3 + p[CC] * side(p[ALPHA] * x3, p[LAW])
    c = both * (p[INVERSE_M1] * (u + p[OFFSET] - friction - p[KR] * x1)
                + p[INVERSE_M2] * tau_arm)
    k = both * p[INVERSE_M1] * motor_friction_load_slope(x3, 1.0, p)
    return c / (1.0 + k) if c > 0.0 else c / (1.0 - k)


@kernel
def _held_torque(x1: float, x3: float, u: float, tau_arm: float, p: Array) -> float:
    """Return rigid_torque where friction is a constraint: the drive is one joint."""
    m2 = 1.0 / p[INVERSE_M2]
    both = 1.0 / p[INVERSE_M1] + m2
    driving = u + p[OFFSET] - p[KR] * x1 - p[CV] * x3 - tau_arm
    level, torque = p[CC] + p[LEVEL], 0.0
    for _ in range(2 if p[CL] != 0.0 else 1):  # friction that grows with the torque needs it first
        friction = holding(driving, p[RATE] * x3 * both, level + p[CL] * abs(torque), p[SOFTNESS],
                           p[STATIC])
        torque = m2 * (driving - friction) / both + tau_arm
    return torque
