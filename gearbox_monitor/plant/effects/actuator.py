# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects between the torque that is commanded and the torque that acts on the motor."""
import math

import numpy as np

from gearbox_monitor.kernels.elementary import sine
from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.effect import (
    BalanceColumn, Coefficients, COMMAND, Effect, FreeParameter, JointMotion, MAX_DELAY, moved,
    one, Parameter, PERIOD, SCALE, Scales, Starts, TORQUE, wave, wave_values, waves)


@inline
def scaled_command(c: Coefficients, u: float) -> float:
    """Return (1 + g) u for the command `u` (N m) and the parameter g of `c`."""
    return u * (1.0 + c.g)


@inline
def gain_of_command(c: Coefficients, x1: float) -> float:
    """Return 1 + g of `c`, at any position `x1` of the motor."""
    return 1.0 + c.g


# What no working drive exceeds: beyond it, a fit imitates something else.
GAIN_ERRORS = (-0.5, 1.0)  # of the torque: a factor of two either way
LEAST_LIMIT = 0.3          # of the largest command: who commands thrice the limit sees no motion

TORQUE_GAIN = Effect(
    'torque_gain', 'actuator', 'u_act = (1 + g) u', (Parameter('g', '-', -1.0),),
    noun='torque scale error',
    shows='All accelerations are too large or too small by one factor, and so is the torque '
          'against friction and weight.',
    meaning='torque is commanded in another scale, as by a wrong torque constant',
    command=scaled_command, motor_gain=gain_of_command,
    starts=lambda s: [[FreeParameter('g', 0.0, 0.1, *GAIN_ERRORS)]],
    separated_by={'motor_coulomb': 'dynamic torque instead of slow motion'},
    column=BalanceColumn(
        lambda m, _: m.model[:, None], lambda b, _: {'g': float(1.0 / (1.0 + b[0]) - 1.0)},
        low=lambda m: -0.5, high=lambda m: 1.0, needs=SCALE))  # half to double the scale

TORQUE_OFFSET = Effect(
    'torque_offset', 'actuator', 'u_act = u + u0', (Parameter('u0', 'N m'),),
    noun='torque offset',
    shows='The drive creeps, or needs a torque to stand still, the same at all angles and speeds.',
    meaning='torque has a constant offset', adds_to='torque_offset', in_filters=True,
    additive=True, twin='coulomb_asymmetry',
    starts=lambda s: [[FreeParameter('u0', 0.0, 0.1 * s.torque, -s.peak, s.peak)]],
    separated_by={
        'coulomb_asymmetry': 'no motion separates them: they differ only near standstill'},
    column=BalanceColumn(
        lambda m, _: np.ones((len(m.t), 1)), lambda b, _: {'u0': float(-b[0])},
        twins=('coulomb_asymmetry', 'load_torque')))

# Lag and delay act over the steps of a simulation: composition.actuator has their equations.
ACTUATOR_LAG = Effect(
    'actuator_lag', 'actuator', "T u_act' = u - u_act", (Parameter('T', 's', 0.0, 10.0),),
    noun='time constant of the torque',
    shows='Fast changes of the torque act later and smaller than commanded; slow ones fit.',
    meaning='torque follows the command with a lag', torque_only=True,
    starts=lambda s: [[FreeParameter('T', 0.001, 0.002, 0.0, 1.0)]],
    separated_by={'actuator_delay': 'a chirp or fast motion above 5 Hz'})

ACTUATOR_DELAY = Effect(
    'actuator_delay', 'actuator', 'u_act(t) = u(t - T)', (Parameter('T', 's', 0.0, MAX_DELAY),),
    noun='delay of the torque',
    shows='The torque acts later by the same time at all frequencies; the difference follows its '
          'rate of change.',
    meaning='torque follows the command with a dead time', torque_only=True,
    starts=lambda s: [[FreeParameter('T', 0.001, 0.002, 0.0, MAX_DELAY)]],
    column=BalanceColumn(
        lambda m, late: moved(m.t, m.raw, late), one('T'), setting='T',
        grid=lambda m: (0.005, 0.015), fixed_point=True, low=lambda m: 0.0,
        high=lambda m: 3.0 * MAX_DELAY, needs=COMMAND,
        twins=('actuator_lag', 'motor_encoder_delay')))


@inline
def clipped_command(c: Coefficients, u: float) -> float:
    """Return the command `u` (N m) within +-umax of `c`."""
    return min(max(u, -c.umax), c.umax)


def limits_below_peak(s: Scales) -> Starts:
    """Return the `starts` of a limit of the torque, in the Scales `s`."""
    return [[FreeParameter('umax', level, 0.1 * s.peak, LEAST_LIMIT * s.peak, s.peak)]
            for level in s.limits]


MOST_OVER = 300.0  # the usual command over the lowest limit that is tried
STEP_DOWN = 1.4   # a limit over the next lower one
ACTED = 0.9       # of the largest torque that the motion took: no limit is below


def limits_reached(m: JointMotion) -> list[float]:
    """
    Return levels (N m) that the effort of a JointMotion `m` exceeds by far more than its noise.

    A level inside the noise would rectify it: the column then explains noise by noise.
    """
    size = np.abs(m.effort)
    shares = (0.45, 0.6, 0.75, 0.82, 0.88, 0.92, 0.95, 0.97, 0.985)
    usual = np.quantile(size, shares).tolist()

    def beyond(level: float) -> Array:
        """Return what the effort has beyond `level`, where it has."""
        return size[size > level] - level
    levels = [x for x in usual if x > m.noise and len(beyond(x))
              and math.sqrt(float(np.mean(beyond(x) ** 2))) > 3.0 * m.noise]
    # The motion itself says which torque acted. Below it a limit is the sign of the command:
    # Coulomb friction in disguise.
    acted = ACTED * float(np.quantile(np.abs(m.model), 0.98))
    # Of a drive that is at its limit most of the time, in steps that a refinement reaches. What a
    # nearly constant command has beyond them hardly varies, and explains nothing.
    steps = math.log(max(usual[0], 1e-300) / max(acted, m.noise, usual[0] / MOST_OVER, 1e-300))
    lower = usual[0] * STEP_DOWN ** -np.arange(math.floor(steps / math.log(STEP_DOWN)), 0.0, -1.0)
    # From setpoints the torque has the scale of the model's gain, which that of the bodies lacks.
    return [x for x in lower.tolist() if float(np.std(beyond(x))) > 3.0 * m.noise] + [
        x for x in levels if x > acted or m.kp]


def limit_column(needs: str, twins: tuple[str, ...] = ()) -> BalanceColumn:
    """
    Return the BalanceColumn of a limit of the torque: what the effort has beyond it.

    needs, twins: of BalanceColumn.
    """
    return BalanceColumn(
        lambda m, u: (m.effort - np.clip(m.effort, -u, u))[:, None],
        lambda b, u: {'umax': u}, setting='umax', grid=limits_reached, low=lambda m: 0.85,
        high=lambda m: 1.15, needs=needs, twins=twins, hides=lambda m, u: np.abs(m.effort) > u,
        of_input=True)


SATURATION = Effect(
    'saturation', 'actuator', 'u_act = clip(u, -umax, umax)',
    (Parameter('umax', 'N m', 0.0, of_command=True),),
    noun='torque limit',
    shows='The model fits until the command exceeds a level; beyond it the drive accelerates as '
          'if the command stayed there.',
    meaning='torque is limited below the command', command=clipped_command, off=math.inf,
    order=-1, starts=limits_below_peak, torque_only=True,
    column=limit_column(COMMAND))


MOST_RIPPLE = 0.5  # of the torque: a motor with more would stop at some angles


@inline
def ripple_gain(c: Coefficients, x1: float) -> float:
    """Return the factor of torque ripple with the parameters `c` at the position `x1` (rad)."""
    return 1.0 + c.A * sine(c.N * x1 + c.phi)


@inline
def with_ripple(c: Coefficients, x1: float, x3: float, u: float) -> float:
    """
    Return the torque of the motor with ripple.

    Args:
        c: parameters A, N, phi.
        x1: position of the motor, rad.
        x3: its speed; not used.
        u: torque of the motor, N m.

    Returns:
        u (1 + A sin(N x1 + phi)), N m.
    """
    return u * ripple_gain(c, x1)


TORQUE_RIPPLE = Effect(
    'torque_ripple', 'actuator', 'u_act = u (1 + A sin(N x1 + phi))',
    (Parameter('A', '-'), *PERIOD),
    noun='ripple of the torque',
    shows='The difference repeats N times per turn of the motor and grows with the commanded '
          'torque.',
    meaning='torque is modulated with the angle of the motor', motor_torque=with_ripple,
    motor_gain=ripple_gain, order=-1, rotary_only=True,
    starts=wave(lambda s: 0.05, lambda s: MOST_RIPPLE),
    column=BalanceColumn(
        lambda m, n: m.model[:, None] * waves(n * m.q), wave_values('A', -1.0), setting='N',
        grid=lambda m: range(1, 9), whole=True, high=lambda m: MOST_RIPPLE, needs=TORQUE))
