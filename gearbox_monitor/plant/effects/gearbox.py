# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects in the transmission: its stiffness, backlash, damping, hysteresis and errors of mesh."""
import math

import numpy as np

from gearbox_monitor.kernels.elementary import sine
from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.effect import (
    Coefficients, Effect, FreeParameter, logarithmic, MotorFriction, of_model, Parameter, PERIOD,
    positive, PROFILE, replaced, Scales, Starts, wave)
from gearbox_monitor.plant.effects.motor_side import relaxed
from gearbox_monitor.plant.transmission import dead_zone

BACKLASH_SHARES = (0.2, 0.45)  # of the swing of the measured twist: half gaps to start from
FARTHEST = 10.0  # times the twist: a wider loop never closes, and is like a constant torque
LOOP_STARTS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # the memory of a hysteresis goes from -1 to 1
_B, _K = positive('b', 'rad'), Parameter('K', 'N m/rad', 1e-9)
_D = positive('D', 'N m s/rad')


# ---------------------------------------------------------------------- values of the model


def _backlash_starts(s: Scales) -> Starts:
    value = s.values['half_gap']
    sizes, scale = [f * value for f in PROFILE], value
    if s.swing:
        sizes += [f * s.swing for f in BACKLASH_SHARES]
        scale = max(scale, 0.1 * s.swing)
    # A half gap beyond all twists is one whose flanks the motion never reached.
    return [[FreeParameter(_B.name, min(size, s.reach), scale, min(0.02 * value, s.reach),
                           s.reach)] for size in sizes]


BACKLASH_GAP = Effect(
    'backlash_gap', 'transmission', 'b differs from the model file', (_B,),
    noun='half backlash',
    shows='At a reversal the motor moves by another angle before the arm follows; the twist steps'
          ' by another width.',
    meaning='backlash differs from the model', replaces='half_gap', starts=_backlash_starts)


def _stiffness_starts(s: Scales) -> Starts:
    value = s.values['stiffness']
    sizes = [f * value for f in PROFILE]
    if s.swing:
        sizes.append(2.0 * s.torque / s.swing)
    return [[replaced(_K, size, value, value)] for size in sizes]


STIFFNESS = Effect(
    'stiffness', 'transmission', 'K differs from the model file', (_K,),
    noun='stiffness',
    shows='Under load the twist is larger or smaller than in the model in proportion to the '
          'torque, and the resonance shifts.',
    meaning='stiffness of the gearbox differs from the model', replaces='stiffness',
    starts=_stiffness_starts,
    separated_by={'hardening': 'several load amplitudes',
                  'backlash_gap': 'several load amplitudes on both flanks'})


# ---------------------------------------------------------------------- torque over twist


@inline
def hardening_torque(c: Coefficients, twist: float, z: float, half_gap: float) -> float:
    """
    Return the torque (N m) that hardening adds.

    Args:
        c: parameter K3.
        twist: that acts, rad.
        z: not used.
        half_gap: of the backlash, rad.

    Returns:
        K3 dz(twist, half_gap)^3.
    """
    out = dead_zone(twist, half_gap)
    return c.K3 * out * out * out


# The cubic part over the linear one, at the twist at which the linear one is the usual torque.
# With less, the torque falls before it reaches the usual one; with more, stiffness is tenfold.
CUBIC = (-4.0 / 27.0, 3.0)


def _hardening_starts(s: Scales) -> Starts:
    low, high = (x * s.values['stiffness'] ** 3 / s.torque ** 2 for x in CUBIC)
    return [[FreeParameter('K3', 0.0, 0.1 * s.torque / s.twist ** 3, low, high)]]


HARDENING = Effect(
    'hardening', 'transmission', 'tau_K += K3 dz(delta, b)^3', (Parameter('K3', 'N m/rad^3'),),
    noun='cubic stiffness',
    shows='Small loads fit; at large ones the twist is smaller (or larger) than in the model.',
    meaning='gearbox stiffens (or softens) with load', elastic=hardening_torque,
    starts=_hardening_starts)


@inline
def bouc_wen_torque(c: Coefficients, twist: float, z: float, half_gap: float) -> float:
    """
    Return the torque (N m) that the Bouc-Wen hysteresis adds.

    Args:
        c: parameters Th, dh.
        twist: not used.
        z: memory, from -1 to 1.
        half_gap: not used.

    Returns:
        Th z.
    """
    return c.Th * z


@inline
def loop_memory(c: Coefficients, z: float, x3: float, x4: float, h: float,
                base: MotorFriction) -> float:
    """
    Return the memory of z' = (delta' - |delta'| z) / d after a step.

    Args:
        c: parameters of a loop, the second one the twist d over which it turns.
        z: memory at the begin.
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        h: length of the step, s.
        base: not used.

    Returns:
        The memory at the end.
    """
    rate = x3 - x4
    return relaxed(z, math.copysign(1.0, rate), abs(rate) / c[1], h)


def _bouc_wen_starts(s: Scales) -> Starts:
    elastic = s.values['stiffness'] * s.twist
    low = 0.0 if s.swing else -math.inf  # of a real drive, no loop supplies energy
    return [[FreeParameter('Th', 0.0, 0.1 * elastic, low, s.peak),
             logarithmic('dh', f * s.twist, 1e-5, FARTHEST * s.twist)] for f in (0.03, 0.2, 1.0)]


BOUC_WEN = Effect(
    'hysteresis_bouc_wen', 'transmission',
    "tau_K += Th z, z' = (delta' - |delta'| z) / dh",
    (Parameter('Th', 'N m'), Parameter('dh', 'rad', 1e-6, 1e3)),
    noun='hysteresis torque',
    shows='Torque over twist is a loop: loading and unloading take different paths, also in slow '
          'motion.',
    meaning='gearbox loses energy: torque over twist is a loop with soft ends',
    elastic=bouc_wen_torque, memory=loop_memory, memory_starts=LOOP_STARTS,
    starts=_bouc_wen_starts)


@inline
def branch_twist(c: Coefficients, x1: float, x2: float, z: float) -> float:
    """
    Return the twist (rad) by which the branch of a loop is shifted.

    Args:
        c: parameters h, ds.
        x1: not used.
        x2: not used.
        z: memory, from -1 to 1.

    Returns:
        -h z.
    """
    return -(c.h * z)


def _branch_starts(s: Scales) -> Starts:
    high = 0.0 if s.swing else s.reach
    return [[FreeParameter('h', 0.0, 0.1 * s.twist, -s.reach, high),
             logarithmic('ds', f * s.twist, 1e-5, FARTHEST * s.twist)] for f in (0.03, 0.2, 1.0)]


BRANCH = Effect(
    'hysteresis_branch', 'transmission',
    "tau_K = K dz(delta - h s, b), s' = (delta' - |delta'| s) / ds",
    (Parameter('h', 'rad'), Parameter('ds', 'rad', 1e-6, 1e3)),
    noun='hysteresis angle',
    shows='Torque over twist has two parallel branches, and the drive jumps between them at '
          'reversals.',
    meaning='torque over twist has two branches, one per direction',
    twist=branch_twist, memory=loop_memory, memory_starts=LOOP_STARTS, starts=_branch_starts)

TRANSMISSION_DAMPING = Effect(
    'transmission_damping', 'transmission', 'D differs from the model file', (_D,),
    noun='damping',
    shows='Oscillations of the arm against the motor decay faster or slower than in the model.',
    meaning='damping of the gearbox differs from the model', replaces='damping',
    starts=of_model(_D, 'damping', usual=lambda s: 0.1 * s.torque / s.speed))


@inline
def mesh_twist(c: Coefficients, x1: float, x2: float, z: float) -> float:
    """
    Return the twist (rad) that the error of mesh adds.

    Args:
        c: parameters A, N, phi.
        x1: position of the motor, rad.
        x2: not used.
        z: not used.

    Returns:
        A sin(N x1 + phi).
    """
    return c.A * sine(c.N * x1 + c.phi)


MESH_ERROR = Effect(
    'mesh_error', 'transmission', 'delta -> delta + A sin(N x1 + phi) in tau_K',
    (Parameter('A', 'rad'), *PERIOD),
    noun='transmission error',
    shows='The twist has a wave of N periods per turn of the motor that is there in slow motion '
          'and without load.',
    meaning='transmission error that repeats with the angle of the motor', twist=mesh_twist,
    order=-1, rotary_only=True,
    starts=wave(lambda s: 0.25 * s.swing or 0.05 * s.twist, lambda s: s.reach))


def slipped(effect: Values, t: Array) -> Array:
    """
    Return the angle by which the motor has slipped ahead of the arm.

    Args:
        effect: values of t0 (s) and Ds (rad).
        t: times [N], s.

    Returns:
        Angle at these times [N], rad.
    """
    return np.where(t > effect['t0'], effect['Ds'], 0.0)


# Found as a zero of the twist that moves, see diagnosis.joint.localisation. Angles of the motor in
# other equations count on from before it.
SLIP = Effect(
    'slip', 'transmission', 'delta -> delta - Ds from t0 on, a few times',
    (Parameter('Ds', 'rad'), Parameter('t0', 's', 0.0)),
    noun='slip',
    shows='Motor and arm move apart by a step and stay so; before and after it the twist swings '
          'as far.',
    meaning='clutch, hub or coupling slips', since='0.3.0',
    slip_profile=slipped, additive=True, starts=None, needs_both_encoders=True)
