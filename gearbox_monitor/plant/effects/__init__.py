# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Library of effects that equation (1) of the drive does not have, one line of truth for each.

Plant, simulator and diagnosis use this table and these equations; a model file switches effects on
by its key ``effects``. s(v) = (2/pi) atan(alpha v) is the sign of equation (1), dz the dead zone,
delta = x1 - x2 the twist. An effect that only replaces a value of the model (`replaces`) is folded
into it (model.DriveModel.folded) and has no equation here.

Arguments of the equations: t s; x1, x2 rad and x3, x4 rad/s of motor and arm; u N m; h, dt s;
e: pack(effects); cv, cc, alpha: friction of the model; kind, stiffness, half_gap, width, k_s: as
of transmission_torque; w, z, s: memories; side: of friction_side.

Other packages add effects by the entry point group ``gearbox_monitor.effects``: each entry is an
Effect with `torques`, see docs/plugins.md.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import entry_points, EntryPoint
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.elementary import arctan, exponential, sine
from gearbox_monitor.kernels.jit import jit, jit_anew, jit_inline
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.transmission import dead_zone, transmission_torque

LOCATIONS = ('motor_side', 'arm_side', 'transmission', 'actuator', 'motor_sensor', 'arm_sensor')
PLUGIN_GROUP = 'gearbox_monitor.effects'
MAX_DELAY = 0.02  # s: longest dead time of torque or encoder
TWO_OVER_PI = 2.0 / math.pi
# (t, x1, x2, x3, x4, u, tau_k, theta) -> torques, see Effect.
Three: TypeAlias = tuple[float, float, float]
Torques: TypeAlias = Callable[[float, float, float, float, float, float, float, Array], Three]


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect: physical bounds `low` and `high` in `unit`."""

    name: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    whole: bool = False  # an integer


@dataclass(frozen=True)
class Effect:
    """
    One effect: where it sits, its equation in words of the model, its parameters.

    replaces: field of the model whose value it replaces. torques: of a plug-in, a function
    (t, x1, x2, x3, x4, u, tau_k, theta) -> torques (N m) added to the motor, taken from the arm,
    and added to the transmission; it must compile with numba. starts: of a plug-in, values of its
    parameters from where fits begin.
    """

    id: str
    location: str
    equation: str
    parameters: tuple[Parameter, ...]
    replaces: str = ''
    torques: Torques | None = None
    starts: tuple[float, ...] = ()


def _positive(name: str, unit: str, high: float = math.inf) -> Parameter:
    return Parameter(name, unit, 0.0, high)


_PERIOD = (Parameter('N', '1/rev', 1, 40, True), Parameter('phi', 'rad'))
_TABLE = (
    Effect('motor_viscous', 'motor_side', 'Cv replaced',
           (_positive('Cv', 'N m s/rad'),), 'viscous_friction'),
    Effect('motor_coulomb', 'motor_side', 'Cc replaced',
           (_positive('Cc', 'N m'),), 'coulomb_friction'),
    Effect('stribeck', 'motor_side', 'Cc -> Cc + Cs exp(-(x3/vs)^2)',
           (_positive('Cs', 'N m'), Parameter('vs', 'rad/s', 1e-3, 1e3))),
    Effect('lugre', 'motor_side', "Cc s(x3) replaced by sigma0 z + sigma1 z', "
           "z' = x3 - sigma0 |x3| z / g, g = Cc + Cs exp(-(x3/vs)^2)",
           (Parameter('sigma0', 'N m/rad', 1e-3, 1e6), _positive('sigma1', 'N m s/rad'),
            _positive('Cs', 'N m'), Parameter('vs', 'rad/s', 1e-3, 1e3))),
    Effect('coulomb_asymmetry', 'motor_side', 'tau_f += Ca |s(x3)|', (Parameter('Ca', 'N m'),)),
    Effect('load_friction', 'motor_side', 'tau_f += Cl |tau_K| s(x3)',
           (_positive('Cl', 'N m per N m', 1.0),)),
    Effect('motor_inertia', 'motor_side', 'm1 replaced',
           (Parameter('m1', 'kg m^2', 1e-9),), 'motor_inertia'),
    Effect('viscous_drift', 'motor_side', 'Cv -> Cv (1 + r (1 - exp(-t/T))), t from the start',
           (Parameter('r', '-', -1.0), Parameter('T', 's', 1e-2, 1e5))),
    Effect('cogging', 'motor_side', "m1 x3' += A sin(N x1 + phi)",
           (Parameter('A', 'N m'), *_PERIOD)),
    Effect('arm_viscous', 'arm_side', 'tau_arm += Cav x4', (_positive('Cav', 'N m s/rad'),)),
    Effect('arm_coulomb', 'arm_side', 'tau_arm += Cac s(x4)', (_positive('Cac', 'N m'),)),
    Effect('gravity', 'arm_side', 'tau_arm += G sin(x2)', (Parameter('G', 'N m'),)),
    Effect('load_torque', 'arm_side', 'tau_arm += TL', (Parameter('TL', 'N m'),)),
    Effect('arm_inertia', 'arm_side', 'm2 replaced',
           (Parameter('m2', 'kg m^2', 1e-9),), 'arm_inertia'),
    Effect('disturbance', 'arm_side', 'tau_arm += amplitude from t0 for duration, a few times',
           (Parameter('t0', 's', 0.0), _positive('duration', 's'), Parameter('amplitude', 'N m'))),
    Effect('backlash_gap', 'transmission', 'b replaced',
           (_positive('b', 'rad'),), 'half_gap'),
    Effect('stiffness', 'transmission', 'K replaced',
           (Parameter('K', 'N m/rad', 1e-9),), 'stiffness'),
    Effect('hardening', 'transmission', 'tau_K += K3 dz(delta, b)^3',
           (Parameter('K3', 'N m/rad^3'),)),
    Effect('hysteresis_bouc_wen', 'transmission',
           "tau_K += Th z, z' = (delta' - |delta'| z) / dh",
           (Parameter('Th', 'N m'), Parameter('dh', 'rad', 1e-6, 1e3))),
    Effect('hysteresis_branch', 'transmission',
           "tau_K = K dz(delta - h s, b), s' = (delta' - |delta'| s) / ds",
           (Parameter('h', 'rad'), Parameter('ds', 'rad', 1e-6, 1e3))),
    Effect('transmission_damping', 'transmission', 'D replaced',
           (_positive('D', 'N m s/rad'),), 'damping'),
    Effect('mesh_error', 'transmission', 'delta -> delta + A sin(N x1 + phi) in tau_K',
           (Parameter('A', 'rad'), *_PERIOD)),
    Effect('torque_gain', 'actuator', 'u_act = (1 + g) u', (Parameter('g', '-', -1.0),)),
    Effect('torque_offset', 'actuator', 'u_act = u + u0', (Parameter('u0', 'N m'),)),
    Effect('actuator_lag', 'actuator', "T u_act' = u - u_act",
           (Parameter('T', 's', 0.0, 10.0),)),
    Effect('actuator_delay', 'actuator', 'u_act(t) = u(t - T)',
           (Parameter('T', 's', 0.0, MAX_DELAY),)),
    Effect('saturation', 'actuator', 'u_act = clip(u, -umax, umax)',
           (_positive('umax', 'N m'),)),
    Effect('torque_ripple', 'actuator', 'u_act = u (1 + A sin(N x1 + phi))',
           (Parameter('A', '-'), *_PERIOD)),
    Effect('motor_encoder_eccentricity', 'motor_sensor', 'y1 = x1 + A sin(x1 + phi)',
           (Parameter('A', 'rad'), Parameter('phi', 'rad'))),
    Effect('motor_encoder_quantisation', 'motor_sensor', 'y1 = q round((x1 + n1) / q)',
           (_positive('q', 'rad'),)),
    Effect('motor_encoder_delay', 'motor_sensor', 'y1(t) = x1(t - T)',
           (Parameter('T', 's', 0.0, MAX_DELAY),)),
    Effect('arm_encoder_eccentricity', 'arm_sensor', 'y2 = x2 + A sin(x2 + phi)',
           (Parameter('A', 'rad'), Parameter('phi', 'rad'))),
    Effect('arm_encoder_quantisation', 'arm_sensor', 'y2 = q round((x2 + n2) / q)',
           (_positive('q', 'rad'),)),
    Effect('arm_encoder_delay', 'arm_sensor', 'y2(t) = x2(t - T)',
           (Parameter('T', 's', 0.0, MAX_DELAY),)),
    Effect('encoder_offset', 'arm_sensor', 'y2 = x2 + c', (Parameter('c', 'rad'),)),
)
EFFECTS = {effect.id: effect for effect in _TABLE}
# What model.arm_load has; then what filters know besides effects that replace a model's value.
ARM_LOADS = ('arm_viscous', 'arm_coulomb', 'gravity', 'load_torque')
IN_FILTERS = (*ARM_LOADS, 'load_friction', 'torque_offset')
ADDITIVE = (*IN_FILTERS, 'disturbance')  # may be given several times

# Places in the packed array of effects: those that model.pack does not hold already.
_PACKED = {
    'stribeck': ('Cs', 'vs'), 'lugre': ('sigma0', 'sigma1', 'Cs', 'vs'),
    'coulomb_asymmetry': ('Ca',), 'viscous_drift': ('r', 'T'), 'cogging': ('A', 'N', 'phi'),
    'hardening': ('K3',), 'hysteresis_bouc_wen': ('Th', 'dh'), 'hysteresis_branch': ('h', 'ds'),
    'mesh_error': ('A', 'N', 'phi'), 'torque_gain': ('g',), 'actuator_lag': ('T',),
    'actuator_delay': ('T',), 'saturation': ('umax',), 'torque_ripple': ('A', 'N', 'phi'),
    'motor_encoder_eccentricity': ('A', 'phi'), 'arm_encoder_eccentricity': ('A', 'phi'),
    'motor_encoder_delay': ('T',), 'arm_encoder_delay': ('T',), 'encoder_offset': ('c',),
    'motor_encoder_quantisation': ('q',), 'arm_encoder_quantisation': ('q',)}
(CS, VS, SIGMA0, SIGMA1, LUGRE_CS, LUGRE_VS, CA, DRIFT_R, DRIFT_T, COG_A, COG_N, COG_PHI, K3, TH,
 DH, BRANCH_H, BRANCH_DS, MESH_A, MESH_N, MESH_PHI, GAIN, LAG, DELAY, UMAX, RIPPLE_A, RIPPLE_N,
 RIPPLE_PHI, ECC1_A, ECC1_PHI, ECC2_A, ECC2_PHI, DELAY1, DELAY2, OFFSET2, Q1, Q2,
 N_EFFECTS) = range(37)


def pack(effects: Sequence[Values]) -> Array:
    """Return the effects (dicts of a model) as the float64 array [N_EFFECTS] of the kernels."""
    e = np.zeros(N_EFFECTS)
    e[UMAX] = math.inf
    place = 0
    given = {effect['id']: effect for effect in effects}
    for name, parameters in _PACKED.items():
        for parameter in parameters:
            if name in given:
                e[place] = given[name][parameter]
            place += 1
    return e


@cache
def plugins() -> dict[str, Effect]:
    """
    Return {id: Effect} of the effects that installed packages add, their torques compiled.

    Looks once in a process. Raises InputError that names the plug-in.
    """
    found = {}
    for entry in entry_points(group=PLUGIN_GROUP):
        effect = _plugin(entry)
        if effect.id in EFFECTS or effect.id in found:
            raise InputError(f'plug-in {entry.value}: id {effect.id!r} is taken')
        found[effect.id] = effect
    return found


def _plugin(entry: EntryPoint) -> Effect:
    """Return the checked Effect of an entry point."""
    source = f'plug-in {entry.value}'
    try:
        effect = entry.load()
    except Exception as error:  # whatever its module does
        raise InputError(f'{source}: {_first_line(error)}, expected an Effect to import') from None
    if not isinstance(effect, Effect):
        raise InputError(f'{source}: {str(effect)[:60]}, expected an Effect')
    if not callable(effect.torques):
        raise InputError(f'{source}: torques: {effect.torques!r}, expected a function')
    if effect.location not in LOCATIONS:
        raise InputError(f'{source}: location: {effect.location!r}, expected one of '
                         f'{", ".join(LOCATIONS)}')
    if not all(isinstance(p, Parameter) for p in effect.parameters):
        raise InputError(f'{source}: parameters: {str(effect.parameters)[:60]}, expected a tuple '
                         'of Parameter')
    good = len(effect.starts) == len(effect.parameters) and all(
        isinstance(v, (int, float)) and p.low <= v <= p.high
        for v, p in zip(effect.starts, effect.parameters))
    if not good:
        raise InputError(f'{source}: starts: {effect.starts!r}, expected one number within the '
                         f'bounds for each of the {len(effect.parameters)} parameters')
    torques = jit_anew(effect.torques)
    try:
        result = torques(0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, np.array(effect.starts, float))
    except Exception as error:  # numba has many kinds
        raise InputError(f'{source}: torques: {_first_line(error)}, expected a function '
                         '(t, x1, x2, x3, x4, u, tau_k, theta) that numba compiles') from None
    if not isinstance(result, tuple) or len(result) != 3 or not all(
            isinstance(v, float) and math.isfinite(v) for v in result):
        raise InputError(f'{source}: torques: returns {result!r}, expected three finite floats')
    return replace(effect, torques=torques)


def _first_line(error: Exception) -> str:
    """Return type and text of an exception in one short line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    # numba tells the cause last, under the step that failed.
    told = [line for line in lines if not line.startswith(('Failed in', 'File', 'During'))]
    return f'{type(error).__name__}: {(told or lines or [""])[0][:120]}'


def library() -> dict[str, Effect]:
    """Return {id: Effect}: the table and the plug-ins."""
    return {**EFFECTS, **plugins()}


def not_in_filters(effects: Sequence[Values]) -> list[str]:
    """Return the ids of `effects` (dicts of a model) that filters leave out."""
    return [e['id'] for e in effects if e['id'] not in IN_FILTERS
            and not (e['id'] in EFFECTS and EFFECTS[e['id']].replaces)]


# ---------------------------------------------------------------------- equations


@jit_inline
def relaxed(memory: float, target: float, rate: float, h: float) -> float:
    """Return a memory after `h` s of memory' = rate (target - memory), rate in 1/s."""
    return target + (memory - target) * exponential(-rate * h)


@jit_inline
def bristle(z: float, x3: float, h: float, cc: float, e: Array) -> float:
    """Return z, the deflection (rad) of LuGre's bristles, after `h` s at speed x3."""
    g = lugre_level(x3, cc, e)
    if x3 == 0.0 or g <= 0.0:
        return z
    return relaxed(z, math.copysign(g / e[SIGMA0], x3), e[SIGMA0] * abs(x3) / g, h)


@jit_inline
def lugre_level(x3: float, cc: float, e: Array) -> float:
    """Return g (N m), LuGre's friction in steady sliding at speed x3."""
    v = x3 / e[LUGRE_VS]
    return cc + e[LUGRE_CS] * exponential(-v * v)


@jit_inline
def loop_memory(z: float, rate: float, width: float, h: float) -> float:
    """Return z after `h` s of z' = (rate - |rate| z) / width: both hystereses."""
    return relaxed(z, math.copysign(1.0, rate), abs(rate) / width, h)


@jit_inline
def friction_side(x3: float, alpha: float) -> float:
    """Return the sign of x3 as Coulomb friction has it: smooth around standstill."""
    return TWO_OVER_PI * arctan(alpha * x3)


@jit_inline
def stribeck(x3: float, side: float, e: Array) -> float:
    """Return the torque (N m) of stribeck, `side` of friction_side."""
    v = x3 / e[VS]
    return e[CS] * exponential(-v * v) * side


@jit_inline
def lugre(x3: float, z: float, side: float, cc: float, e: Array) -> float:
    """Return what lugre with bristles at `z` adds to Coulomb friction `cc` (N m)."""
    g = lugre_level(x3, cc, e)
    slip = abs(x3) * z / g if g > 0.0 else 0.0
    return e[SIGMA0] * z + e[SIGMA1] * (x3 - e[SIGMA0] * slip) - cc * side


@jit_inline
def viscous_drift(x3: float, t: float, cv: float, e: Array) -> float:
    """Return what viscous_drift adds to the friction (N m) at time `t`."""
    return cv * e[DRIFT_R] * (1.0 - exponential(-t / e[DRIFT_T])) * x3


@jit_inline
def friction_effects(x3: float, z: float, t: float, cv: float, cc: float, alpha: float,
                     e: Array) -> float:
    """Return what stribeck, lugre, asymmetry and drift add to tau_f (N m)."""
    torque = 0.0
    if e[CS] != 0.0 or e[SIGMA0] != 0.0 or e[CA] != 0.0:
        side = friction_side(x3, alpha)
        if e[CS] != 0.0:
            torque += stribeck(x3, side, e)
        if e[SIGMA0] != 0.0:
            torque += lugre(x3, z, side, cc, e)
        torque += e[CA] * abs(side)
    if e[DRIFT_R] != 0.0:
        torque += viscous_drift(x3, t, cv, e)
    return torque


@jit_inline
def mesh_error(x1: float, e: Array) -> float:
    """Return the twist (rad) that mesh_error adds."""
    return e[MESH_A] * sine(e[MESH_N] * x1 + e[MESH_PHI])


@jit_inline
def hardening(twist: float, half_gap: float, e: Array) -> float:
    """Return the torque (N m) that hardening adds at `twist` (rad)."""
    out = dead_zone(twist, half_gap)
    return e[K3] * out * out * out


@jit_inline
def elastic_torque(x1: float, x2: float, w: float, z: float, s: float, kind: int, stiffness: float,
                   half_gap: float, width: float, k_s: float, e: Array) -> tuple[float, float]:
    """
    Return (tau_k (N m), twist that acts (rad)) with mesh error, branch, hardening, Bouc-Wen.

    w: memory of the transmission; z, s: those of hysteresis_bouc_wen and hysteresis_branch.
    """
    twist = x1 - x2
    if e[MESH_A] != 0.0:
        twist += mesh_error(x1, e)
    if e[BRANCH_H] != 0.0:
        twist -= e[BRANCH_H] * s
    tau_k, _ = transmission_torque(twist, w, kind, stiffness, half_gap, width, k_s)
    if e[K3] != 0.0:
        tau_k += hardening(twist, half_gap, e)
    return tau_k + e[TH] * z, twist


@jit_inline
def ripple(x1: float, e: Array) -> float:
    """Return the factor of torque_ripple on the torque."""
    return 1.0 + e[RIPPLE_A] * sine(e[RIPPLE_N] * x1 + e[RIPPLE_PHI])


@jit_inline
def cogging(x1: float, e: Array) -> float:
    """Return the torque (N m) that cogging adds."""
    return e[COG_A] * sine(e[COG_N] * x1 + e[COG_PHI])


@jit_inline
def motor_torque(x1: float, u: float, e: Array) -> float:
    """Return u_act (N m) with ripple and, added, cogging; what acts on u alone is in actuator."""
    if e[RIPPLE_A] != 0.0:
        u *= ripple(x1, e)
    if e[COG_A] != 0.0:
        u += cogging(x1, e)
    return u


@jit
def actuator(u: Array, before: int, act: float, dt: float, n: int, e: Array, out: Array) -> float:
    """
    Fill out [N, n] with the mean torque (N m) in each of the `n` parts of each sample.

    In this order: dead time, saturation, gain, lag. u [before + N]: commanded, held over `dt` s,
    with `before` samples of the past in front. act: lagged torque at the start; returns it at the
    end.
    """
    h = dt / n
    fade = math.exp(-h / e[LAG]) if e[LAG] > 0.0 else 0.0
    share = e[LAG] / h * (1.0 - fade)
    for k in range(out.shape[0]):
        for i in range(n):
            now = u[before + k]
            if e[DELAY] > 0.0:
                begin = (i * h - e[DELAY]) / dt
                first = math.floor(begin)
                last = math.floor(begin + 1.0 / n)
                now = u[max(0, before + k + int(first))]
                if last > first:
                    over = (begin + 1.0 / n - last) * n
                    now += over * (u[max(0, before + k + int(last))] - now)
            now = min(max(now, -e[UMAX]), e[UMAX]) * (1.0 + e[GAIN])
            if e[LAG] > 0.0:
                out[k, i] = now + (act - now) * share
                act = now + (act - now) * fade
            else:
                out[k, i] = act = now
    return act


@jit
def reading(x: Array, k: int, i: int, dt: float, e: Array) -> float:
    """
    Return what encoder `i` (0 motor, 1 arm) reads at row `k` of x [N, 4], without noise.

    Delayed between samples by a cubic through positions and speeds; before row 0 the drive stood.
    """
    late = (e[DELAY1] if i == 0 else e[DELAY2]) / dt
    position = x[k, i]
    if late > 0.0:
        # Parts of the delay, not of the row: then the numbers do not depend on where x begins.
        f = math.ceil(late) - late
        j = k - int(math.ceil(late))
        if j < 0:
            position = x[0, i]
        else:
            a, b = x[j, i], x[j + 1, i]
            va, vb = x[j, 2 + i] * dt, x[j + 1, 2 + i] * dt
            position = (a + f * (va + f * (3.0 * (b - a) - 2.0 * va - vb
                                           + f * (2.0 * (a - b) + va + vb))))
    amplitude = e[ECC1_A] if i == 0 else e[ECC2_A]
    if amplitude != 0.0:
        position += amplitude * math.sin(position + (e[ECC1_PHI] if i == 0 else e[ECC2_PHI]))
    return position + (e[OFFSET2] if i == 1 else 0.0)


def quantised(y: Array, effects: Sequence[Values]) -> Array:
    """Return readings y [N, 2] (rad) on the lattices of the encoders."""
    e = pack(effects)
    for i, q in enumerate((e[Q1], e[Q2])):
        if q > 0.0:
            y[:, i] = q * np.round(y[:, i] / q)
    return y


def bursts(effects: Sequence[Values], t: Array, dt: float) -> Array:
    """Return the mean torque on the arm [N] (N m) of disturbances from t [N] on for `dt` s."""
    load = np.zeros(len(t))
    for effect in effects:
        if effect['id'] == 'disturbance':
            begin, end = effect['t0'], effect['t0'] + effect['duration']
            inside = np.minimum(t + dt, end) - np.maximum(t, begin)
            load += effect['amplitude'] * np.clip(inside / dt, 0.0, 1.0)
    return load
