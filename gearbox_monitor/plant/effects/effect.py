# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What one effect is: a single object with everything that the package knows about it.

An equation is a compiled function that takes `c`, the effect's parameters by their names, and then
the arguments of its slot (see Effect). Kernels are composed of these functions, see composition.

In the balance of a whole robot it is columns of a linear regression. Their sign: torque that the
drive must supply beside what the model says.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.errors import expect_choice, InputError
from gearbox_monitor.kernels.types import Array, Flags, Values
from gearbox_monitor.presentation import on_axis

ANY, COMMAND, TORQUE, SETPOINT, SCALE = 'any', 'command', 'torque', 'setpoint', 'scale'


@dataclass(frozen=True, eq=False)
class JointMotion:
    """
    One joint of a moving robot.

    t s, q rad or m, v, sign (expected, of a noisy speed), load (torque of the rigid bodies without
    friction), model (all), effort (without noise): [N] each, N m. error (setpoint less q),
    setpoint_speed, compensation (torque that it adds for the weight) [N], kp, kd: of a servo.
    noise: of the effort, N m. coulomb, viscous, armature: of the model file. learnt: the file's
    friction is not known but from a reference. taught [N]: what a reference taught beside bodies
    and rotors; dry, wet: its parts that scale with direction and with speed; else 0. raw [N]:
    effort with its noise, for columns that must not be weaker than the effort at any frequency;
    bodies: load with the masses that a reference taught.
    """

    t: Array
    q: Array
    v: Array
    sign: Array
    load: Array
    model: Array
    effort: Array
    error: Array
    setpoint_speed: Array
    compensation: Array
    kp: float
    kd: float
    noise: float
    coulomb: float
    viscous: float
    armature: float
    learnt: bool
    taught: Array
    dry: Array
    wet: Array
    raw: Array
    bodies: Array


Named: TypeAlias = Mapping[str, float]


def one(name: str) -> Callable[[Array, float], Named]:
    """Return what makes of one coefficient the value `name`."""
    return lambda b, setting: {name: float(b[0])}


def wave_values(name: str, sign: float = 1.0) -> Callable[[Array, float], Named]:
    """Return what makes amplitude `name`, N and phi of coefficients; `sign` of the wave."""
    def values(b: Array, setting: float) -> Named:
        out = {name: math.hypot(b[0], b[1])}
        if setting:
            out['N'] = setting
        return {**out, 'phi': math.atan2(sign * b[1], sign * b[0])}
    return values


def waves(x: Array) -> Array:
    """Return sine and cosine [N, 2] of `x` [N]."""
    return np.stack([np.sin(x), np.cos(x)], axis=1)


def anything(m: JointMotion) -> float:
    """Return the bound of a coefficient that may have any sign in the JointMotion `m`."""
    return -math.inf


def unbounded(m: JointMotion) -> float:
    """Return the bound of the size of coefficients that may have any in the JointMotion `m`."""
    return math.inf


def not_negative(m: JointMotion) -> float:
    """Return the bound in `m` of what is not below 0; a difference from a reference may be."""
    return -math.inf if m.learnt else 0.0


def dissipated(m: JointMotion, column: Array) -> float:
    """
    Return the least coefficient of a `column` [N] of friction with which `m` is still braked.

    Friction never drives: what file and references know of it and what is found beside it take
    power from the motion together.
    """
    known = m.coulomb * m.sign + m.viscous * m.v + m.dry + m.wet
    power = float(column @ m.v)
    return -max(float(known @ m.v), 0.0) / power if power > 0.0 else -math.inf


def whole_friction(m: JointMotion) -> tuple[float, ...]:
    """Return settings of a change of friction in `m`: by its law (0), all that was taught (1)."""
    return (0.0, 1.0) if m.dry.any() and m.wet.any() else (0.0,)


def per_unit(x: Array, y: Array) -> Array:
    """Return `x` [N] as a column [N, 1] of the mean size that `y` [N] has."""
    return (x * (float(np.mean(np.abs(y))) / max(float(np.mean(np.abs(x))), 1e-12)))[:, None]


def moved(t: Array, x: Array, shift: float) -> Array:
    """
    Return (x(t + shift) - x(t - shift)) / (2 shift) [N, 1] of samples `x` [N] at `t` [N] (s).

    The odd part of a shift in time. Its even part has the phase of the noise that a model has from
    its positions, and would remove it: a column of x(t + shift) alone finds delays everywhere.
    """
    shift = max(shift, 1e-4)
    return ((np.interp(t + shift, t, x) - np.interp(t - shift, t, x)) / (2.0 * shift))[:, None]


@dataclass(frozen=True)
class BalanceColumn:
    """
    The columns of an effect.

    series(m, setting): torque [N, k] per unit of the coefficients of a JointMotion; with
    `momentum` its derivative counts. values(b, setting): the effect's parameters of the
    coefficients b [k]. setting: name of a nonlinear parameter, which grid(m) lists; `whole`: it
    is a whole number, else it is refined: in ratios, or with `place` in parts of the joint's
    motion; `fixed_point`: it is the first coefficient itself. low(m): bound of the first
    coefficient; high(m): of their size. dissipates: it is friction, which takes no less than no
    power. needs: kind of input that shows it: ANY, COMMAND (torque that is commanded, not
    measured), TORQUE, SETPOINT, or SCALE (a torque, or a part of it that servos add).
    twins: ids of effects with the same columns in motion.
    states: the value by which a report states it, '' for the effect's first parameter: a name in
    _change is a difference to the model, one in _factor a ratio.
    hides(m, setting): flags [N] of samples at which any input has the same effect, None for none.
    of_input: it acts on the setpoint of a servo, and is no torque.
    """

    series: Callable[[JointMotion, float], Array]
    values: Callable[[Array, float], Named]
    setting: str = ''
    grid: Callable[[JointMotion], Sequence[float]] = lambda m: (0.0,)
    whole: bool = False
    place: bool = False
    fixed_point: bool = False
    momentum: bool = False
    low: Callable[[JointMotion], float] = anything
    high: Callable[[JointMotion], float] = unbounded
    dissipates: bool = False
    needs: str = ANY
    twins: tuple[str, ...] = ()
    states: str = ''
    hides: Callable[[JointMotion, float], Flags] | None = None
    of_input: bool = False


LOCATIONS = ('motor_side', 'arm_side', 'transmission', 'controller', 'actuator', 'motor_sensor',
             'arm_sensor')
MAX_DELAY = 0.02  # s: longest dead time of torque or encoder
MAX_SETPOINT_DELAY = 0.1  # s
MAX_SERVO_DELAY = 0.05    # s: longer ones are no approximation of Pade, and no servo
# Factors of the model's value, a coarse logarithmic grid: the likelihood selects on it where the
# fit begins of a value that has several optima when it is far off, as a resonance does.
PROFILE = (1.0, 0.5, 0.7, 1.4, 2.0)
# The parameters of an effect as a named tuple, c.A, c.phi ...; each effect has a type of its own.
Coefficients: TypeAlias = Any
Three: TypeAlias = tuple[float, float, float]
# (t, x1, x2, x3, x4, u, tau_k, theta) -> torques, see Effect.
Torques: TypeAlias = Callable[[float, float, float, float, float, float, float, Array], Three]


class MotorFriction(NamedTuple):
    """Friction of the model: tau_f = viscous x3 + coulomb s(sharpness x3), s of the law."""

    viscous: float    # N m s/rad
    coulomb: float    # N m
    sharpness: float  # s/rad
    law: float        # friction_law.LAWS


class AtRest(NamedTuple):
    """
    An effect, linearised at rest.

    On the motor: damper (N m s/rad) and spring (N m/rad); on the arm: arm_damper.
    """

    damper: float
    spring: float = 0.0
    arm_damper: float = 0.0


@dataclass(frozen=True)
class Parameter:
    """
    A parameter of an effect: physical bounds `low` and `high` in `unit`.

    whole: an integer. default: its value if an effect omits it; None: an effect must state it.
    of_command: counts in the unit of the commanded torque, and is scaled with it. off_at_infinity:
    the effect vanishes as the parameter grows. choices: it is one of these words. listed: a list
    of such numbers. exclusive: it is larger than `low`.
    """

    name: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    whole: bool = False
    default: float | None = None
    of_command: bool = False
    off_at_infinity: bool = False
    choices: tuple[str, ...] = ()
    listed: bool = False
    exclusive: bool = False

    def _holds(self, value: Any) -> bool:
        """Return whether a value is a number within the bounds."""
        return bool(isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
                    and math.isfinite(value) and self.low <= value <= self.high
                    and not (self.exclusive and value == self.low)
                    and not (self.whole and value != int(value)))

    def expect(self, value: Any, place: str, axis: str) -> None:
        """
        Raise InputError unless it may have a value.

        Args:
            value: of a file.
            place: file and key, for the message.
            axis: of the drive, for the unit.
        """
        if self.choices:
            expect_choice(value, place.rpartition(': ')[2], place.rpartition(': ')[0],
                          self.choices)
        elif self.listed:
            if not isinstance(value, list):
                raise InputError(f'{place}: {value!r}, expected a list of numbers')
            for number in value:
                replace(self, listed=False).expect(number, place, axis)
        elif not self._holds(value):
            kind = ('a whole number' if self.whole else 'a number' if self.high < math.inf else
                    'a finite number')
            bounds = [f'{sign} {bound:g}' for sign, bound in (
                ('>' if self.exclusive else '>=', self.low), ('<=', self.high))
                if math.isfinite(bound)]
            raise InputError(f'{place}: {value!r}, expected '
                             + ' '.join([kind, ' and '.join(bounds)]).strip()
                             + f' ({on_axis(self.unit, axis)})')


class FreeParameter(NamedTuple):
    """
    One coordinate of a fit: where it starts, the size of a change that matters, its bounds.

    log: it moves on a logarithmic scale. A wave A sin(x + phi) has the coordinates As and Ac of
    As sin(x) + Ac cos(x), whatever the name of its amplitude.
    """

    name: str
    start: float
    scale: float
    low: float = -math.inf
    high: float = math.inf
    log: bool = False


@dataclass(frozen=True)
class Scales:
    """
    Sizes in one drive and one recording, from which fits take their start values.

    torque: standard deviation of the motor's torque; peak: its largest magnitude; friction: of the
    model, N m. speed: usual speed of the motor, rad/s. twist: usual twist of the transmission;
    angle: standard deviation of the motor's position, rad. swing: range of the measured twist
    where the motion of the motor is prescribed, else 0. values: {field: value} of DriveModel and
    Transmission. reach: largest twist from the middle of the backlash, rad; infinite if unknown.
    limits: levels of the torque, N m, each of which cuts off twice as much as the next higher.
    """

    torque: float
    peak: float
    friction: float
    speed: float
    twist: float
    angle: float
    swing: float
    values: Mapping[str, float]
    reach: float = math.inf
    limits: tuple[float, ...] = ()


Starts: TypeAlias = list[list[FreeParameter]]  # one list per start of a fit


@dataclass(frozen=True)
class Effect:
    """
    One effect: where it sits, its equation, its parameters, how fits treat it, what it means.

    What it is:
        id, location, meaning: its name, one of LOCATIONS ('': its parameter place says which),
            one line for reports. noun: its first parameter in words; shows: how it shows in
            data; since: version, the first unless stated. docs/effects.md and the command
            explain are made of these.
        equation: text in the symbols of docs/effects.md.
        parameters: in the order of the fields of `c`. The effect is off where the first one is
            `off`; where a kernel evaluates the effect, off must be 0.
        replaces: field of the model whose value its only parameter replaces; adds_to: field to
            which it is added. Such an effect has no equation.
        in_filters: the equations of the filters contain it, see DriveModel.pack.
        additive: a model may list it several times.
        packed(effect): the numbers that kernels take, `size` of them, where these are not its
            parameters; `c` is then an array and where in it they begin.
        problem(effect): what is wrong with its parameters together, '' for nothing.

    Its equation, a function with @inline in one of these slots:
        friction(c, t, x3, z, base): torque (N m) added to tau_f. base: MotorFriction.
        arm_torque(c, t, x2, x4, z): torque (N m) added to tau_arm.
        twist(c, x1, x2, z): angle (rad) added to the twist that acts.
        elastic(c, twist, z, half_gap): torque (N m) added to tau_K.
        motor_torque(c, x1, x3, u): torque (N m) that acts on the motor in place of u;
            motor_gain(c, x1): its derivative with respect to u, where that is not 1.
        command(c, u): torque (N m) that the actuator makes of the command u.
        encoder_error(c, x): (error, its first and second derivative) of a reading at position x.
        memory(c, z, x3, x4, h, base): z, its memory, h s later; z is 0 at rest.
        Effects in one slot act one after the other, those of lower `order` first.
        t in s; x1, x2 (rad) and x3, x4 (rad/s): position and speed of motor and arm.
    Outside of compiled code:
        arm_profile(effect, t, dt): torque [N] added to tau_arm in the steps of dt s from t [N].
        slip_profile(effect, t): angle [N], rad, by which the motor is ahead of the arm at t [N].
        lattice: its first parameter is the step to which readings are rounded.
        torques: of a plug-in, a function (t, x1, x2, x3, x4, u, tau_k, theta) -> torques (N m)
            added to the motor, taken from the arm, and added to the transmission.
        at_rest(effect, sharpness): AtRest, for the fastest eigenvalue.

    Its fit:
        starts: a function of Scales that returns the start values, or one number per parameter;
            None for what no fit finds. memory_starts: memories to start windows from.
        counterpart: id of the same effect on the other side of the gearbox.
        merges_if_rigid: a rigid transmission makes it the same as an effect on the motor.
        twin: id of an effect that no motion distinguishes from it. twin_alone: the same where
            one encoder is read and the torque is recorded.
        separated_by: {id of another effect: motion that distinguishes them}.
        rotary_only: a prismatic axis does not have it. needs_both_encoders: one does not show it.
        torque_only: it acts on a torque that is recorded, which that of a servo is not.
    In the balance of a whole robot:
        column: its BalanceColumn, None for what the balance of torques does not show.
    """

    id: str
    location: str
    equation: str
    parameters: tuple[Parameter, ...]
    replaces: str = ''
    torques: Torques | None = None
    starts: tuple[float, ...] | Callable[[Scales], Starts] | None = ()
    meaning: str = ''
    noun: str = ''
    shows: str = ''
    since: str = '0.1.0'
    adds_to: str = ''
    in_filters: bool = False
    additive: bool = False
    packed: Callable[[Values], list[float]] | None = None
    size: int = 0
    problem: Callable[[Values], str] | None = None
    off: float = 0.0
    order: int = 0
    friction: Callable[..., float] | None = None
    arm_torque: Callable[..., float] | None = None
    twist: Callable[..., float] | None = None
    elastic: Callable[..., float] | None = None
    motor_torque: Callable[..., float] | None = None
    motor_gain: Callable[..., float] | None = None
    command: Callable[..., float] | None = None
    encoder_error: Callable[..., Three] | None = None
    memory: Callable[..., float] | None = None
    arm_profile: Callable[[Values, Array, float], Array] | None = None
    slip_profile: Callable[[Values, Array], Array] | None = None
    lattice: bool = False
    at_rest: Callable[[Values, float], AtRest] | None = None
    memory_starts: tuple[float, ...] = ()
    counterpart: str = ''
    merges_if_rigid: bool = False
    twin: str = ''
    separated_by: Mapping[str, str] = field(default_factory=dict)
    rotary_only: bool = False
    needs_both_encoders: bool = False
    torque_only: bool = False
    column: BalanceColumn | None = None
    twin_alone: str = ''

    @property
    def phased(self) -> bool:
        """Whether it is a wave over an angle: an amplitude, its first parameter, and phi."""
        return any(p.name == 'phi' for p in self.parameters)

    @property
    def periodic(self) -> bool:
        """Whether it is a wave of N periods per turn, N whole and found by a search."""
        return self.phased and any(p.whole for p in self.parameters)

    @property
    def is_event(self) -> bool:
        """Whether it happens at times of its own: no motion repeats it."""
        return self.arm_profile is not None or self.slip_profile is not None

    @property
    def fitted(self) -> bool:
        """Whether fits of the motion find its parameters."""
        return self.starts is not None

    def free_parameters(self, scales: Scales) -> Starts:
        """Return the coordinates of a fit, one list per start, in the Scales `scales`."""
        if self.starts is None:
            raise ValueError(f'{self.id}: no fit of the motion finds this effect')
        if callable(self.starts):
            return self.starts(scales)
        return [[FreeParameter(p.name, float(v), max(abs(float(v)), 1e-3), p.low, p.high)
                 for p, v in zip(self.parameters, self.starts)]]


def positive(name: str, unit: str, high: float = math.inf) -> Parameter:
    """
    Return a Parameter that is not negative.

    Args:
        name: of the parameter.
        unit: its unit.
        high: upper bound.

    Returns:
        The Parameter.
    """
    return Parameter(name, unit, 0.0, high)


def of_model(parameter: Parameter, where: str, factors: tuple[float, ...] = (1.0,),
             usual: Callable[[Scales], float] = lambda scales: 0.0) -> Callable[[Scales], Starts]:
    """
    Return the `starts` of an effect that replaces a value of the model.

    Args:
        parameter: the effect's only Parameter.
        where: field of the model that it replaces.
        factors: on the value of the model, one per start.
        usual: scale of the parameter where the value of the model is 0.

    Returns:
        A function of Scales.
    """
    def starts(scales: Scales) -> Starts:
        value = scales.values[where]
        scale = value or usual(scales)
        return [[replaced(parameter, f * value, scale, value)] for f in factors]
    return starts


def replaced(parameter: Parameter, start: float, scale: float, value: float) -> FreeParameter:
    """
    Return the coordinate of a Parameter that replaces a value of the model.

    Args:
        parameter: of the effect.
        start: where the fit begins.
        scale: size of a change that matters.
        value: of the model; 2 % of it bound a coordinate from below that may not be 0.

    Returns:
        The FreeParameter.
    """
    low = parameter.low and max(parameter.low, 0.02 * value)
    return FreeParameter(parameter.name, start, scale, low, parameter.high)


def wave(size: Callable[[Scales], float],
         most: Callable[[Scales], float] = lambda scales: math.inf) -> Callable[[Scales], Starts]:
    """Return the `starts` of a wave: amplitude that matters, and the largest that is physical."""
    def starts(scales: Scales) -> Starts:
        return [[FreeParameter(name, 0.0, size(scales), -most(scales), most(scales))
                 for name in ('As', 'Ac')]]
    return starts


def logarithmic(name: str, start: float, low: float, high: float) -> FreeParameter:
    """
    Return a coordinate on a logarithmic scale.

    Args:
        name: of the parameter.
        start: where the fit begins.
        low: lower bound.
        high: upper bound.

    Returns:
        The FreeParameter.
    """
    return FreeParameter(name, start, start, low, high, log=True)


PERIOD = (Parameter('N', '1/rev', 1, 40, True), Parameter('phi', 'rad'))
