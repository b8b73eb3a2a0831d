# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The library of effects: all that stand in the files of this folder, and those of plug-ins.

Other packages add effects by the entry point group ``gearbox_monitor.effects``: each entry is an
Effect with `torques`, see docs/extend.md.
"""
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points, EntryPoint
import math
from types import ModuleType

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Values
import gearbox_monitor.plant.effects.actuator as actuator
import gearbox_monitor.plant.effects.arm_side as arm_side
import gearbox_monitor.plant.effects.controller as controller
from gearbox_monitor.plant.effects.effect import Effect, LOCATIONS, Parameter
import gearbox_monitor.plant.effects.encoder as encoder
import gearbox_monitor.plant.effects.gearbox as gearbox
import gearbox_monitor.plant.effects.motor_side as motor_side
import gearbox_monitor.plant.effects.torque_map as torque_map

PLUGIN_GROUP = 'gearbox_monitor.effects'


def _standing_in(*modules: ModuleType) -> Iterator[tuple[str, Effect]]:
    """Yield (id, Effect) of all effects in `modules`, in their order."""
    for module in modules:
        for value in vars(module).values():
            if isinstance(value, Effect):
                yield value.id, value


EFFECTS = dict(_standing_in(motor_side, arm_side, gearbox, controller, actuator, encoder,
                            torque_map))


def _has_places(effect: Effect) -> bool:
    return not (effect.replaces or effect.adds_to or effect.in_filters or effect.is_event)


def _places() -> tuple[dict[str, int], int]:
    """Return ({id: place of its first parameter in the packed array}, size of this array)."""
    places, end = {}, 0
    for effect in EFFECTS.values():
        if _has_places(effect):
            places[effect.id] = end
            end += effect.size or len(effect.parameters)
    return places, end


PLACES, _END = _places()
# Behind them stands the servo: kp (0 without one), kd, limit of its torque, ki, delay, and its
# feedforward of speed and acceleration; then whether what a lag has reached is held for a step.
(SERVO_KP, SERVO_KD, SERVO_TORQUE, SERVO_KI, SERVO_LATE, SERVO_SPEED, SERVO_ACCELERATION, HELD,
 N_EFFECTS) = range(_END, _END + 9)
NO_SERVO = (0.0, 0.0, math.inf, 0.0, 0.0, 0.0, 0.0)


def in_slot(slot: str) -> list[Effect]:
    """Return the effects with an equation in `slot`, in the order in which they act."""
    effects = [effect for effect in EFFECTS.values() if getattr(effect, slot) is not None]
    return sorted(effects, key=lambda effect: effect.order)


# Memories of a window or a state: that of the transmission itself, then those of effects, then
# torque of the servo's integrator and the three filtered torques of a servo that is late, N m.
MEMORIES = {effect.id: place for place, effect in enumerate(in_slot('memory'), 1)}
INTEGRAL, LATE_A, LATE_B, LATE_C, N_MEMORY = range(1 + len(MEMORIES), 6 + len(MEMORIES))


def pack(effects: Sequence[Values], servo: Sequence[float] = NO_SERVO, held: bool = False
         ) -> Array:
    """
    Return effects as the float64 array [N_EFFECTS] of the kernels.

    Args:
        effects: dicts of a model.
        servo: kp (N m/rad), kd (N m s/rad), limit (N m), ki (N m/rad/s), delay (s) and
            feedforward (N m s/rad, kg m^2) of the servo that takes a setpoint.
        held: what a lag has reached at the begin of a step acts throughout, as in MuJoCo.
    """
    e = np.zeros(N_EFFECTS)
    e[SERVO_KP:HELD] = servo
    e[HELD] = held
    for name, place in PLACES.items():
        e[place] = EFFECTS[name].off
    for values in effects:
        if values['id'] in PLACES:
            place, effect = PLACES[values['id']], EFFECTS[values['id']]
            numbers = (effect.packed(values) if effect.packed else
                       [values.get(parameter.name, parameter.default)
                        for parameter in effect.parameters])
            e[place:place + len(numbers)] = numbers
    return e


def arm_profile(effects: Sequence[Values], t: Array, dt: float) -> Array:
    """
    Return the torque on the arm that follows a profile over time, such as bursts.

    Args:
        effects: dicts of a model.
        t: begins of steps [N], s.
        dt: length of the steps, s.

    Returns:
        Mean torque in each step [N], N m.
    """
    load = np.zeros(len(t))
    for values in effects:
        effect = EFFECTS.get(values['id'])
        if effect is not None and effect.arm_profile is not None:
            load += effect.arm_profile(values, t, dt)
    return load


def slip_profile(effects: Sequence[Values], t: Array) -> Array | None:
    """
    Return the angle by which the motor is ahead of the arm, None where nothing slips.

    Args:
        effects: dicts of a model.
        t: times [N], s.

    Returns:
        Angle [N], rad.
    """
    angles = [effect.slip_profile(values, t) for values in effects
              if (effect := EFFECTS.get(values['id'])) is not None
              and effect.slip_profile is not None]
    return sum(angles, np.zeros(len(t))) if angles else None


def quantised(y: Array, effects: Sequence[Values]) -> Array:
    """Round the readings `y` [N, 2] (rad) in place as `effects` (dicts) say; return them."""
    for values in effects:
        effect = EFFECTS.get(values['id'])
        step = values[effect.parameters[0].name] if effect and effect.lattice else 0.0
        if effect and step > 0.0:
            i = LOCATIONS.index(effect.location) - LOCATIONS.index('motor_sensor')
            y[:, i] = step * np.round(y[:, i] / step)
    return y


def not_in_filters(effects: Sequence[Values]) -> list[str]:
    """Return the ids of `effects` (dicts of a model) that filters leave out."""
    return [e['id'] for e in effects if not (
        e['id'] in EFFECTS and (EFFECTS[e['id']].in_filters or EFFECTS[e['id']].replaces))]


# ---------------------------------------------------------------------- plug-ins


def library() -> dict[str, Effect]:
    """Return {id: Effect}: those of this package and of plug-ins."""
    return {**EFFECTS, **plugins()}


@cache
def plugins() -> dict[str, Effect]:
    """
    Return {id: Effect} of the effects that installed packages add, their torques compiled.

    Looks once in a process. Raises InputError that names the plug-in.
    """
    effects: dict[str, Effect] = {}
    for entry in entry_points(group=PLUGIN_GROUP):
        effect = _plugin(entry)
        if effect.id in EFFECTS or effect.id in effects:
            raise InputError(f'plug-in {entry.value}: id {effect.id!r} is taken')
        effects[effect.id] = effect
    return effects


def _plugin(entry: EntryPoint) -> Effect:
    """Return the checked Effect of an entry point."""
    source = f'plug-in {entry.value}'
    try:
        effect = entry.load()
    except Exception as error:  # whatever its module does
        raise InputError(f'{source}: {_first_line(error)}, expected an Effect to import') from None
    if not isinstance(effect, Effect):
        raise InputError(f'{source}: {str(effect)[:60]}, expected an Effect')
    if effect.torques is None or not callable(effect.torques):
        raise InputError(f'{source}: torques: {effect.torques!r}, expected a function')
    if effect.location not in LOCATIONS:
        raise InputError(f'{source}: location: {effect.location!r}, expected one of '
                         f'{", ".join(LOCATIONS)}')
    if not all(isinstance(p, Parameter) for p in effect.parameters):
        raise InputError(f'{source}: parameters: {str(effect.parameters)[:60]}, expected a tuple '
                         'of Parameter')
    good = (isinstance(effect.starts, tuple) and len(effect.starts) == len(effect.parameters)
            and all(isinstance(v, (int, float)) and p.low <= v <= p.high
                    for v, p in zip(effect.starts, effect.parameters)))
    if not good:
        raise InputError(f'{source}: starts: {effect.starts!r}, expected one number within the '
                         f'bounds for each of the {len(effect.parameters)} parameters')
    torques = effect.torques
    try:
        result = torques(0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, np.array(effect.starts, float))
    except Exception as error:  # whatever the function does
        raise InputError(f'{source}: torques: {_first_line(error)}, expected a function '
                         '(t, x1, x2, x3, x4, u, tau_k, theta)') from None
    if not isinstance(result, tuple) or len(result) != 3 or not all(
            isinstance(v, float) and math.isfinite(v) for v in result):
        raise InputError(f'{source}: torques: returns {result!r}, expected three finite floats')
    return replace(effect, torques=torques)


def _first_line(error: Exception) -> str:
    """Return type and text of an exception in one short line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return f'{type(error).__name__}: {(lines or [""])[0][:120]}'
