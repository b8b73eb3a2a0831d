# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What an effect of a joint is in the balance of a whole robot: columns of a linear regression.

Their sign: torque that the drive must supply beside what the model says.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags

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


def wave(name: str, sign: float = 1.0) -> Callable[[Array, float], Named]:
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
