# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A drive with a gap, with any effect and several at once, written from the equations alone.

    x1' = x3, x2' = x4, delta = x1 - x2
    m1 x3' = u_act - D (x3 - x4) - tau_K - tau_f - Kr x1 + cogging
    m2 x4' = D (x3 - x4) + tau_K - tau_arm
    tau_f = Cv x3 + Cc s(x3), s(v) = 2/pi atan(alpha v), tau_K = K dz(delta, b)

It shares no code with the simulator that the diagnosis uses, so that a wrong equation shows.
RK4 at 0.1 ms and finer where a memory (bristle, hysteresis) is faster than that. Torque chain:
command -> delay -> saturation -> lag -> gain -> ripple -> offset. Before t = 0 the drive stood
still with u = 0.

A servo, if the recording has its setpoint, computes the command at each integration step, 10 kHz,
from its own encoder: u = clip(kp e + ki int e dt - kd q' + kff r', limit), e = dz(r - q, d). The
integral is within the limit, too; what is computed acts T later. r' is the difference of two
setpoints, HELD after each other.
"""
from collections.abc import Collection, Iterable, Mapping, Sequence
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.types import Array, Integers, Matrix, Vector

Nominal = Mapping[str, float]          # value of each name in NOMINAL
Effects = Sequence[Mapping[str, Any]]  # {'id': .., parameter: value} each
# u [N] in N m, y [N, 2] in rad, dt in s; setpoint [N] of a servo in rad, if there is one.
MotionRecord = Mapping[str, Any]
# Feed-forward torque [N] (N m), controller (kp N m/rad, kd N m s/rad, limit N m, position that it
# follows: 0 motor, 1 arm) and its reference [N, 2] (rad, rad/s).
DriveMotion = tuple[Array, tuple[float, float, float, float], Array]
NOMINAL = {'m1': 0.006442, 'm2': 0.023454, 'D': 0.01, 'Cv': 0.1, 'Cc': 0.27, 'alpha': 100.0,
           'Kr': 0.01, 'K': 25.0, 'b': 0.1}
ENCODERS = ('both', 'motor', 'arm')  # that a recording has
INPUTS = ('torque', 'setpoint')      # that drives it
GAINS = ('kp', 'kd', 'limit')        # of a servo, among the nominal values of its drive
# Places in the numbers of a controller: whether it is a servo in a loop of its own, its ki, ticks
# by which it is late, and the commands of the last ticks.
LOOP, KI, TICKS, LINE = 9, 10, 11, 12
TICK, LONGEST = 1e-4, 600  # s; ticks
HELD = 0.01     # s from setpoint to setpoint
SUBSTEPS = 10   # per sample of 1 ms
FASTEST = 0.4   # largest product of substep and rate of a memory

# id -> (place, values by which a test compares it with the library, lowest and highest size that
# is drawn, see draw.effect). OUTSIDE: effects that no vocabulary names.
Row = tuple[str, Collection[str], tuple[float, float]]
EFFECTS: dict[str, Row] = {
    'motor_viscous': ('motor_side', {'Cv': 0.13}, (0.02, 1.0)),
    'motor_coulomb': ('motor_side', {'Cc': 0.35}, (0.02, 0.8)),
    'stribeck': ('motor_side', {'Cs': 0.15, 'vs': 0.5}, (0.01, 0.4)),
    'lugre': ('motor_side', {'sigma0': 60.0, 'sigma1': 0.2, 'Cs': 0.1, 'vs': 0.5}, (0.01, 0.3)),
    'coulomb_asymmetry': ('motor_side', {'Ca': 0.1}, (0.005, 0.2)),
    'viscous_asymmetry': ('motor_side', {'Cva': 0.05}, (0.005, 0.3)),
    'load_friction': ('motor_side', {'Cl': 0.1}, (0.01, 0.4)),
    'motor_inertia': ('motor_side', {'m1': 0.008}, (0.01, 0.7)),
    'viscous_drift': ('motor_side', {'r': 0.5, 'T': 1.0}, (0.05, 1.0)),
    'cogging': ('motor_side', {'A': 0.3, 'N': 7, 'phi': 0.4}, (0.01, 0.5)),
    'arm_viscous': ('arm_side', {'Cav': 0.05}, (0.0005, 0.1)),
    'arm_coulomb': ('arm_side', {'Cac': 0.1}, (0.002, 0.3)),
    'gravity': ('arm_side', {'G': 0.5, 'phi': 0.6}, (0.01, 1.5)),
    'load_torque': ('arm_side', {'TL': 0.3}, (0.005, 0.5)),
    'arm_inertia': ('arm_side', {'m2': 0.03}, (0.01, 1.5)),
    'disturbance': ('arm_side', {}, (0.1, 3.0)),
    'backlash_gap': ('transmission', {'b': 0.12}, (0.01, 0.8)),
    'stiffness': ('transmission', {'K': 32.0}, (0.02, 0.8)),
    'hardening': ('transmission', {'K3': 60.0}, (0.02, 2.0)),
    'hysteresis_bouc_wen': ('transmission', {'Th': 0.5, 'dh': 0.03}, (0.01, 0.5)),
    'hysteresis_branch': ('transmission', {'h': 0.03, 'ds': 0.04}, (0.01, 0.8)),
    'transmission_damping': ('transmission', {'D': 0.05}, (0.1, 10.0)),
    'mesh_error': ('transmission', {'A': 0.02, 'N': 5, 'phi': 1.0}, (0.0005, 0.05)),
    'torque_gain': ('actuator', {'g': 0.1}, (0.005, 0.4)),
    'torque_offset': ('actuator', {'u0': 0.2}, (0.005, 0.3)),
    'actuator_lag': ('actuator', {'T': 0.004}, (0.0005, 0.03)),
    'actuator_delay': ('actuator', {'T': 0.0036}, (0.0005, 0.018)),
    'saturation': ('actuator', {'umax': 3.0}, (0.05, 0.6)),
    'torque_ripple': ('actuator', {'A': 0.1, 'N': 6, 'phi': 0.3}, (0.01, 0.5)),
    'motor_encoder_eccentricity': ('motor_sensor', {'A': 0.02, 'phi': 0.5}, (0.001, 0.15)),
    'motor_encoder_quantisation': ('motor_sensor', {'q': 0.003}, (0.7, 8.0)),
    'motor_encoder_delay': ('motor_sensor', {'T': 0.0034}, (0.0003, 0.018)),
    'arm_encoder_eccentricity': ('arm_sensor', {'A': 0.02, 'phi': -0.5}, (0.001, 0.15)),
    'arm_encoder_quantisation': ('arm_sensor', {'q': 0.004}, (0.7, 8.0)),
    'arm_encoder_delay': ('arm_sensor', {'T': 0.0027}, (0.0003, 0.018)),
    'encoder_offset': ('arm_sensor', {'c': 0.03}, (0.001, 0.15)),
    'servo_gain': ('controller', {'kp': 4.5}, (0.02, 1.5)),
    'servo_limit': ('controller', {'umax': 2.0}, (0.05, 0.6)),
    'servo_deadband': ('controller', {'d': 0.05}, (0.001, 0.2)),
    'servo_integrator': ('controller', {'ki': 12.0}, (0.1, 20.0)),
    'servo_delay': ('controller', {'T': 0.012}, (0.001, 0.03)),
    'servo_feedforward': ('controller', {'kff': 0.3}, (0.002, 0.4)),
    'setpoint_delay': ('controller', {'T': 0.03}, (0.001, 0.08)),
    'setpoint_lag': ('controller', {'T': 0.02}, (0.001, 0.08)),
}
# Of a torque that is recorded; within the loop of a servo they are other effects.
TORQUE_ONLY = ('actuator_lag', 'actuator_delay', 'saturation')
OUTSIDE: dict[str, Row] = {
    'motor_quadratic': ('motor_side', ('C2',), (0.0003, 0.02)),  # tau_f += C2 x3 |x3|
    'motor_friction_angle': ('motor_side', ('a', 'phi'), (0.05, 0.9)),  # Cc (1 + a sin(x1 + phi))
    'arm_spring': ('arm_side', ('k',), (0.01, 1.5)),  # tau_arm += k x2
    'arm_quadratic': ('arm_side', ('C2',), (0.0001, 0.01)),  # tau_arm += C2 x4 |x4|
    'arm_fan': ('arm_side', ('A', 'f', 'phi'), (0.01, 0.5)),  # tau_arm += A sin(2 pi f t + phi)
    'stiffness_angle': ('transmission', ('a', 'phi'), (0.05, 0.7)),  # K (1 + a sin(2 x1 + phi))
    'gap_angle': ('transmission', ('a', 'phi'), (0.03, 0.7)),  # b (1 + a sin(3 x1 + phi))
    'stiffness_sides': ('transmission', ('a',), (0.05, 1.0)),  # K (1 + a) where delta > b
    'contact_damping': ('transmission', ('Dc',), (0.003, 0.3)),  # tau_K += Dc (x3 - x4) in contact
    'torque_cubic': ('actuator', ('c',), (0.001, 0.05)),  # u + c u^3
    'torque_rate': ('actuator', ('rate',), (0.05, 0.9)),  # |u'| <= rate, N m/s
    'motor_encoder_harmonic': ('motor_sensor', ('A', 'phi'), (0.001, 0.15)),  # y1 + A sin(2 x1)
    'arm_encoder_harmonic': ('arm_sensor', ('A', 'phi'), (0.001, 0.15)),  # y2 + A sin(2 x2)
}
PLACES = ('motor_side', 'arm_side', 'transmission', 'controller', 'actuator', 'motor_sensor',
          'arm_sensor')

# Places in the packed parameters: nominal values, then what the kernel has of each effect.
_OWN = [(name, parameter) for name, (place, parameters, _) in {**EFFECTS, **OUTSIDE}.items()
        if place != 'controller' and not place.endswith('_sensor')
        for parameter in parameters if parameter not in NOMINAL]
_PLACE: dict[Any, int] = {key: i for i, key in enumerate([*NOMINAL, *_OWN])}
(M1, M2, D, CV, CC, ALPHA, KR, K, B, CS, VS, SIGMA0, SIGMA1, LCS, LVS, CA, CVA, CL, DRIFT,
 DRIFT_T, COG_A, COG_N, COG_PHI, CAV, CAC, G, G_PHI, TL, K3, TH, DH, H, DS, MESH_A, MESH_N,
 MESH_PHI, GAIN, U0, LAG, DELAY, UMAX, RIP_A, RIP_N, RIP_PHI, C2, CCA, CCPHI, SPRING, AC2, FAN_A,
 FAN_F, FAN_PHI, KA, KPHI, BA, BPHI, SIDE, DC, CUBIC, RATE, LUGRE) = range(len(_PLACE) + 1)
SENSORS = {name for name, (place, *_) in {**EFFECTS, **OUTSIDE}.items()
           if place.endswith('_sensor')}
SERVO = {name for name, (place, *_) in EFFECTS.items() if place == 'controller'}


class PackedPlant(NamedTuple):
    """
    A drive as the kernels take it.

    p: parameters, see _PLACE; bursts [m, 3]: t0 (s), duration (s), amplitude (N m) of
    each disturbance; dt: sample time, s; min_substeps: integration steps per sample, at least.
    """

    p: Vector
    bursts: Matrix
    dt: float
    min_substeps: int


def place_of(effect: str) -> str:
    """Return the place of the id `effect`, of the vocabulary or outside of it."""
    return {**EFFECTS, **OUTSIDE}[effect][0]


def shown(effects: Iterable[str], encoders: str = 'both', driver: str = 'torque') -> list[str]:
    """
    Return those ids of `effects` that readings can show.

    Args:
        effects: ids.
        encoders: one of ENCODERS: those that are read.
        driver: one of INPUTS.
    """
    absent = SERVO if driver == 'torque' else TORQUE_ONLY
    unread = {'motor': 'arm_sensor', 'arm': 'motor_sensor'}.get(encoders)
    return [i for i in effects if i not in absent and place_of(i) != unread
            and not (unread and i == 'encoder_offset')]


def pack(nominal: Nominal, effects: Effects, dt: float,
         min_substeps: int = SUBSTEPS) -> PackedPlant:
    """
    Pack a drive for the kernels.

    Args:
        nominal: values by name; NOMINAL stands in for missing ones.
        effects: what the drive has besides.
        dt: sample time, s.
        min_substeps: integration steps per sample, at least.
    """
    p = np.zeros(LUGRE + 1)
    p[VS] = p[LVS] = p[DRIFT_T] = p[DH] = p[DS] = 1.0
    p[UMAX] = p[RATE] = np.inf
    for name, value in NOMINAL.items():
        p[_PLACE[name]] = nominal.get(name, value)
    bursts = np.zeros((0, 3))
    for effect in effects:
        if effect['id'] == 'lugre':
            p[LUGRE] = 1.0
        if effect['id'] == 'disturbance':
            bursts = np.array([[b['t0'], b['duration'], b['amplitude']]
                               for b in effect.get('bursts', [])]).reshape(-1, 3)
            continue
        for name, value in effect.items():
            if name != 'id' and effect['id'] not in SENSORS | SERVO:
                p[_PLACE.get((effect['id'], name)) or _PLACE[name]] = value
    return PackedPlant(p, bursts, dt, min_substeps)


@kernel
def _sign(v: float, alpha: float) -> float:
    return 2.0 / math.pi * math.atan(alpha * v)


@kernel
def _rates(state: tuple[float, float, float, float, float, float, float], t: float, u: float,
           push: float, p: Array, bursts: Array) -> tuple[float, float, float, float, float]:
    """Return d/dt of (x3, x4, z, w, s); u: after the lag; push: process torque on the motor."""
    x1, x2, x3, x4, z, w, s = state
    delta, speed = x1 - x2, x3 - x4
    torque = u * (1.0 + p[GAIN])
    if p[RIP_A] != 0.0:
        torque *= 1.0 + p[RIP_A] * math.sin(p[RIP_N] * x1 + p[RIP_PHI])
    torque += p[U0] + push

    twist = delta
    if p[MESH_A] != 0.0:
        twist += p[MESH_A] * math.sin(p[MESH_N] * x1 + p[MESH_PHI])
    ds = 0.0
    if p[H] != 0.0:
        twist -= p[H] * s
        ds = (speed - abs(speed) * s) / p[DS]
    half = p[B]
    if p[BA] != 0.0:
        half *= 1.0 + p[BA] * math.sin(3.0 * x1 + p[BPHI])
    beyond = 0.0
    if twist > half:
        beyond = twist - half
    elif twist < -half:
        beyond = twist + half
    stiffness = p[K]
    if p[KA] != 0.0:
        stiffness *= 1.0 + p[KA] * math.sin(2.0 * x1 + p[KPHI])
    if beyond > 0.0:
        stiffness *= 1.0 + p[SIDE]
    tau_k = stiffness * beyond + p[K3] * beyond * beyond * beyond
    if beyond != 0.0:
        tau_k += p[DC] * speed
    dw = 0.0
    if p[TH] != 0.0:
        tau_k += p[TH] * w
        dw = (speed - abs(speed) * w) / p[DH]

    sign = _sign(x3, p[ALPHA])
    cv = p[CV]
    if p[DRIFT] != 0.0:
        cv *= 1.0 + p[DRIFT] * (1.0 - math.exp(-max(t, 0.0) / p[DRIFT_T]))
    friction = (cv * x3 + p[CA] * abs(sign) + p[CVA] * abs(x3) + p[CL] * abs(tau_k) * sign
                + p[C2] * x3 * abs(x3))
    cc = p[CC]
    if p[CCA] != 0.0:
        cc *= 1.0 + p[CCA] * math.sin(x1 + p[CCPHI])
    dz = 0.0
    if p[LUGRE] != 0.0:
        g = cc + p[LCS] * math.exp(-(x3 / p[LVS]) * (x3 / p[LVS]))
        dz = x3 - p[SIGMA0] * abs(x3) * z / g
        friction += p[SIGMA0] * z + p[SIGMA1] * dz
    else:
        if p[CS] != 0.0:
            cc += p[CS] * math.exp(-(x3 / p[VS]) * (x3 / p[VS]))
        friction += cc * sign

    load = p[CAV] * x4 + p[TL] + p[SPRING] * x2 + p[AC2] * x4 * abs(x4)
    if p[CAC] != 0.0:
        load += p[CAC] * _sign(x4, p[ALPHA])
    if p[G] != 0.0:
        load += p[G] * math.sin(x2 + p[G_PHI])
    if p[FAN_A] != 0.0:
        load += p[FAN_A] * math.sin(2.0 * math.pi * p[FAN_F] * t + p[FAN_PHI])
    for i in range(bursts.shape[0]):  # half a sine each
        since = t - bursts[i, 0]
        if 0.0 <= since <= bursts[i, 1]:
            load += bursts[i, 2] * math.sin(math.pi * since / bursts[i, 1])

    transmitted = p[D] * speed + tau_k
    cog = 0.0
    if p[COG_A] != 0.0:
        cog = p[COG_A] * math.sin(p[COG_N] * x1 + p[COG_PHI])
    a3 = (torque - transmitted - friction - p[KR] * x1 + cog) / p[M1]
    return a3, (transmitted - load) / p[M2], dz, dw, ds


@kernel
def _substeps(x3: float, x4: float, plant: PackedPlant) -> int:
    """Return the number of substeps of a sample: more than the minimum for fast memories."""
    p = plant.p
    rate, speed = 0.0, abs(x3 - x4)
    if p[LUGRE] != 0.0:
        g = p[CC] + p[LCS] * math.exp(-(x3 / p[LVS]) * (x3 / p[LVS]))
        rate = max(rate, p[SIGMA0] * abs(x3) / g, p[SIGMA1] / p[M1])
    if p[TH] != 0.0:
        rate = max(rate, speed / p[DH])
    if p[H] != 0.0:
        rate = max(rate, speed / p[DS])
    return min(max(plant.min_substeps, int(math.ceil(rate * plant.dt / FASTEST))), 400)


@kernel
def _command(u: float, previous: float, p: Array, dt: float) -> float:
    """Return the command behind the drive's electronics; `previous`: that of the last sample."""
    u = u + p[CUBIC] * (u * u * u)
    return min(max(u, previous - p[RATE] * dt), previous + p[RATE] * dt)


@kernel
def _delayed(command: Array, begin: float, end: float, dt: float, p: Array) -> float:
    """Return the mean of the held command, saturated, over `begin` .. `end` (s), 0 before 0."""
    i = int(math.floor(begin / dt + 1e-9))
    j = int(math.floor(end / dt - 1e-9))
    n = command.shape[0]
    first = 0.0 if i < 0 else command[min(i, n - 1)]
    first = min(max(first, -p[UMAX]), p[UMAX])
    if j <= i:
        return first
    second = 0.0 if j < 0 else command[min(j, n - 1)]
    second = min(max(second, -p[UMAX]), p[UMAX])
    share = (j * dt - begin) / (end - begin)
    return share * first + (1.0 - share) * second


@kernel
def _servo(reference: Array, x1: float, x3: float, integral: float, control: Array
           ) -> tuple[float, float]:
    """
    Return command and error of a servo with the `reference` [2] at the motor's x1 and x3.

    reference: setpoint, rad, and torque that goes ahead, N m.
    control: kp, kd, limit, position that it follows (0 motor, 1 arm), deadband (rad), A, phi of
    the first and of the second harmonic of its encoder, then LOOP and what follows it.
    """
    q, v = x1, x3
    for i in range(2):
        a, phi, n = control[5 + 2 * i], control[6 + 2 * i], 1.0 + i
        q += a * math.sin(n * x1 + phi)
        v += a * n * math.cos(n * x1 + phi) * x3
    error = reference[0] - q
    if control[4] > 0.0:
        error = math.copysign(max(abs(error) - control[4], 0.0), error)
    u = control[0] * error + integral - control[1] * v + reference[1]
    return min(max(u, -control[2]), control[2]), error


@kernel
def _advance(state: Array, lagged: float, k: int, command: Array, push: float,
             plant: PackedPlant, control: Array, reference: Array) -> float:
    """
    Carry state [8] from sample k to k + 1, in place; returns the lagged torque (N m).

    A servo that follows `reference` [N, 2], see _servo, puts its last command into command[k].
    """
    p, bursts, dt = plant.p, plant.bursts, plant.dt
    n = _substeps(state[2], state[3], plant)
    h = dt / n
    half = 0.5 * h
    decay = math.exp(-half / p[LAG]) if p[LAG] > 0.0 else 0.0
    x1, x2, x3, x4, z, w, s = (state[0], state[1], state[2], state[3], state[4], state[5],
                               state[6])
    integral = state[7]
    for i in range(n):
        t = k * dt + i * h
        if control[LOOP] != 0.0 and k >= 0:
            u, error = _servo(reference[k], x1, x3, integral, control)
            integral = min(max(integral + h * control[KI] * error, -control[2]), control[2])
            if control[TICKS] > 0.0:
                tick = int(t / TICK + 1e-6)
                control[LINE + tick % LONGEST] = u
                u = control[LINE + (tick - int(control[TICKS])) % LONGEST]
            earlier = command[k] if i > 0 else command[max(k - 1, 0)]
            command[k] = _command(u, earlier, p, h)
            u = min(max(command[k], -p[UMAX]), p[UMAX])
        elif p[DELAY] > 0.0:
            u = _delayed(command, t - p[DELAY], t + h - p[DELAY], dt, p)
        else:
            u = command[k] if k >= 0 else 0.0
            u = min(max(u, -p[UMAX]), p[UMAX])
        ua, ub, uc = u, u, u
        if p[LAG] > 0.0:
            ua = lagged
            ub = u + (ua - u) * decay
            uc = u + (ub - u) * decay
        a3, a4, az, aw, as_ = _rates((x1, x2, x3, x4, z, w, s), t, ua, push, p, bursts)
        y1, y2, y3, y4 = x1 + half * x3, x2 + half * x4, x3 + half * a3, x4 + half * a4
        b3, b4, bz, bw, bs = _rates((y1, y2, y3, y4, z + half * az, w + half * aw, s + half * as_),
                                    t + half, ub, push, p, bursts)
        v1, v2, v3, v4 = x1 + half * y3, x2 + half * y4, x3 + half * b3, x4 + half * b4
        c3, c4, cz, cw, cs = _rates((v1, v2, v3, v4, z + half * bz, w + half * bw, s + half * bs),
                                    t + half, ub, push, p, bursts)
        w1, w2, w3, w4 = x1 + h * v3, x2 + h * v4, x3 + h * c3, x4 + h * c4
        d3, d4, dz, dw, ds = _rates((w1, w2, w3, w4, z + h * cz, w + h * cw, s + h * cs),
                                    t + h, uc, push, p, bursts)
        x1 += h / 6.0 * (x3 + 2.0 * y3 + 2.0 * v3 + w3)
        x2 += h / 6.0 * (x4 + 2.0 * y4 + 2.0 * v4 + w4)
        x3 += h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3)
        x4 += h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4)
        z += h / 6.0 * (az + 2.0 * bz + 2.0 * cz + dz)
        w += h / 6.0 * (aw + 2.0 * bw + 2.0 * cw + dw)
        s += h / 6.0 * (as_ + 2.0 * bs + 2.0 * cs + ds)
        lagged = uc
    state[0], state[1], state[2], state[3] = x1, x2, x3, x4
    state[4], state[5], state[6], state[7] = z, w, s, integral
    return lagged


def servo_of(nominal: Nominal, effects: Effects, setpoint: Array, dt: float
             ) -> tuple[Array, Array]:
    """
    Return (control, reference [N, 2]) of the servo of a drive, see _servo.

    Args:
        nominal: values with GAINS.
        effects: of the drive; those of the servo and of its encoder count.
        setpoint: recorded one [N], rad.
        dt: sample time, s.
    """
    control = np.zeros(LINE + LONGEST)
    control[:3], control[LOOP] = [nominal[name] for name in GAINS], 1.0
    reference, kff = np.array(setpoint, float), 0.0
    for effect in effects:
        name = effect['id']
        if name == 'servo_gain':
            control[0] = effect['kp']
        elif name == 'servo_limit':
            control[2] = min(control[2], effect['umax'])
        elif name == 'servo_deadband':
            control[4] = effect['d']
        elif name == 'servo_integrator':
            control[KI] = effect['ki']
        elif name == 'servo_delay':
            control[TICKS] = round(effect['T'] / TICK)
        elif name == 'servo_feedforward':
            kff = effect['kff']
        elif name in ('motor_encoder_eccentricity', 'motor_encoder_harmonic'):
            at = 5 if name == 'motor_encoder_eccentricity' else 7
            control[at:at + 2] = effect['A'], effect['phi']
        elif name == 'setpoint_delay':  # the servo looks once per sample
            late = math.ceil(effect['T'] / dt - 1e-9)
            reference = np.concatenate([np.zeros(late), reference[:len(reference) - late]])
        elif name == 'setpoint_lag':
            keep, filtered = math.exp(-dt / effect['T']), 0.0
            for k, wish in enumerate(reference):
                reference[k] = wish + (filtered - wish) * math.sqrt(keep)  # in its middle
                filtered = wish + (filtered - wish) * keep
    past = round(HELD / dt)
    earlier = np.concatenate([np.full(past, reference[0]), reference[:-past]])
    return control, np.column_stack([reference, kff * (reference - earlier) / HELD])


@entry
def _run(u: Vector, command: Vector, push: Vector, x: Matrix, state: Vector, plant: PackedPlant,
         control: Vector, reference: Matrix) -> None:
    """
    Fill x [N, 4], and u [N] and command [N] if a controller makes them.

    control: see _servo; without its LOOP the controller adds to u once per sample, and kp = kd = 0
    leaves u as it is.
    reference [N, 2]: position and speed.
    """
    lagged, previous = 0.0, 0.0
    for k in range(u.shape[0]):
        for i in range(4):
            x[k, i] = state[i]
        if control[LOOP] == 0.0:
            if control[0] != 0.0 or control[1] != 0.0:
                torque = (u[k] + control[0] * (reference[k, 0] - state[int(control[3])])
                          + control[1] * (reference[k, 1] - state[2]))
                u[k] = min(max(torque, -control[2]), control[2])
            previous = _command(u[k], previous, plant.p, plant.dt)
            command[k] = previous
        lagged = _advance(state, lagged, k, command, push[k], plant, control, reference)
        if control[LOOP] != 0.0:
            u[k] = command[k]


@entry
def _window(x: Matrix, state: Vector, first: int, lagged: float, command: Vector,
            plant: PackedPlant, control: Vector, reference: Matrix) -> None:
    """
    Fill x [n, 4] from `state` [8] at sample `first`, which may be negative.

    control, reference: see _advance. What a late servo computed before is that of `state`.
    """
    if control[TICKS] > 0.0:
        torque, _ = _servo(reference[max(first, 0)], state[0], state[2], state[7], control)
        control[LINE:] = torque
    for k in range(x.shape[0]):
        for i in range(4):
            x[k, i] = state[i]
        lagged = _advance(state, lagged, first + k, command, 0.0, plant, control, reference)


@entry
def _integrals(q: Vector, dt: float, control: Vector, reference: Matrix,
               out: Vector) -> None:
    """Fill out [N] with a servo's integral by readings q [N]: their noise hardly shows in it."""
    integral, limit = 0.0, control[2]
    for k in range(len(out)):
        out[k] = integral
        error = reference[k, 0] - q[k]
        error = math.copysign(max(abs(error) - control[4], 0.0), error)
        integral = min(max(integral + dt * control[KI] * error, -limit), limit)


@entry
def _commands(u: Vector, command: Vector, dt: float, p: Vector) -> None:
    previous = 0.0
    for k in range(u.shape[0]):
        previous = _command(u[k], previous, p, dt)
        command[k] = previous


@entry
def _lagged(command: Vector, out: Vector, dt: float, p: Vector) -> None:
    """Fill out [N] with the lagged torque at each sample, from rest."""
    value = 0.0
    parts = 20
    h = dt / parts
    decay = math.exp(-h / p[LAG])
    for k in range(out.shape[0]):
        out[k] = value
        for i in range(parts):
            t = k * dt + i * h - p[DELAY]
            u = _delayed(command, t, t + h, dt, p)
            value = u + (value - u) * decay


def sensor_delays(effects: Effects) -> list[float]:
    """Return the delays (s) that `effects` give to the two encoders."""
    delays = [0.0, 0.0]
    for effect in effects:
        if effect['id'] in ('motor_encoder_delay', 'arm_encoder_delay'):
            delays[effect['id'] == 'arm_encoder_delay'] = effect['T']
    return delays


def lead_of(effects: Effects, dt: float) -> int:
    """Return how many samples of `dt` s before a window its run starts: `effects` may delay."""
    late = [effect['T'] for effect in effects if effect['id'] == 'servo_delay']
    return int(math.ceil(max(*sensor_delays(effects), *late) / dt - 1e-9))


def read_encoders(x: Array, effects: Effects, dt: float, lead: int = 0) -> Array:
    """
    Return encoder readings without noise and without rounding.

    Before the first state the drive stood still.

    Args:
        x: states [..., N, 4].
        effects: effects of the drive.
        dt: sample time, s.
        lead: samples that are left out at the beginning.

    Returns:
        y [..., N - lead, 2], rad.
    """
    n = x.shape[-2]
    y = []
    for channel, delay in enumerate(sensor_delays(effects)):
        position, speed = x[..., channel], x[..., 2 + channel]
        if delay > 0.0:  # cubic Hermite between samples
            at = np.arange(n) - delay / dt
            i = np.clip(np.floor(at).astype(int), 0, n - 2)
            f = np.clip(at - i, 0.0, 1.0)
            position = ((1 + 2 * f) * (1 - f) ** 2 * position[..., i]
                        + f * (1 - f) ** 2 * dt * speed[..., i]
                        + f * f * (3 - 2 * f) * position[..., i + 1]
                        - f * f * (1 - f) * dt * speed[..., i + 1])
        out = position
        for effect in effects:
            name = effect['id']
            if name.startswith(('motor_', 'arm_')[channel]):
                if name.endswith('_encoder_eccentricity'):
                    out = out + effect['A'] * np.sin(position + effect['phi'])
                elif name.endswith('_encoder_harmonic'):
                    out = out + effect['A'] * np.sin(2.0 * position + effect['phi'])
            elif name == 'encoder_offset' and channel == 1:
                out = out + effect['c']
        y.append(out[..., lead:])
    return np.stack(y, axis=-1)


def quantise(y: Array, effects: Effects) -> Array:
    """Return readings `y` [N, 2], noise included, rounded to the encoder steps of `effects`."""
    y = np.array(y, float)
    for effect in effects:
        if effect['id'].endswith('_encoder_quantisation'):
            channel = int(effect['id'].startswith('arm'))
            y[:, channel] = effect['q'] * np.round(y[:, channel] / effect['q'])
    return y


def simulate(nominal: Nominal, effects: Effects, u: Array, dt: float,
             x0: Iterable[float] = (0.0, 0.0, 0.0, 0.0)) -> tuple[Array, Array]:
    """
    Simulate a drive under a given torque, without noise.

    Args:
        nominal: values by name, see NOMINAL.
        effects: effects of the drive.
        u: commanded torque [N], N m, held over each sample.
        dt: sample time, s.
        x0: initial positions (rad) and speeds (rad/s).

    Returns:
        States x [N, 4] and encoder readings y [N, 2].
    """
    motion = u, (0.0, 0.0, 0.0, 0.0), np.zeros((len(u), 2))
    x, y, _ = simulate_motion(nominal, effects, motion, dt, x0=x0)
    return x, y


def simulate_motion(nominal: Nominal, effects: Effects, motion: DriveMotion, dt: float,
                    push: Array | None = None, x0: Iterable[float] = (0.0, 0.0, 0.0, 0.0)
                    ) -> tuple[Array, Array, Array]:
    """
    Simulate a drive whose controller adds feedback of a position to the torque, without noise.

    Args:
        nominal: values by name, see NOMINAL.
        effects: effects of the drive.
        motion: feed-forward torque, controller and reference.
        dt: sample time, s.
        push: process torque on the motor [N], N m.
        x0: initial positions (rad) and speeds (rad/s).

    Returns:
        States x [N, 4], encoder readings y [N, 2] and commanded torque u [N].
    """
    u, gains, reference = motion
    u, control = np.array(u, float), np.array([*gains, *np.zeros(LINE + LONGEST - 4)])
    if 'kp' in nominal:
        control, reference = servo_of(nominal, effects, reference[:, 0], dt)
    n = len(u)
    x, state = np.empty((n, 4)), np.zeros(8)
    state[:4] = tuple(x0)
    _run(u, np.zeros(n), np.zeros(n) if push is None else push, x, state,
         pack(nominal, effects, dt), control, np.ascontiguousarray(reference, float))
    return x, read_encoders(x, effects, dt), u


class WindowRuns:
    """Free runs of one model over windows of a recording, each from its own state."""

    def __init__(self, nominal: Nominal, effects: Effects, recording: MotionRecord,
                 starts: Integers, length: int, substeps: int = SUBSTEPS, lead: int = 0) -> None:
        """
        Prepare the runs.

        Args:
            nominal: values by name, see NOMINAL.
            effects: effects of the drive.
            recording: of the windows.
            starts: first sample of each window [W].
            length: samples of a window.
            substeps: integration steps per sample, at least.
            lead: samples that a run starts earlier, at least.
        """
        u, dt = recording['u'], recording['dt']
        self.effects, self.dt, self.length = effects, dt, int(length)
        self.packed = pack(nominal, effects, dt, substeps)
        self.substeps = substeps
        # A delayed encoder sees samples before the window: start that much earlier.
        self.lead = max(lead, lead_of(effects, dt))
        self.servo: tuple[Array, Array] = np.zeros(LINE + LONGEST), np.zeros((0, 2))
        if 'setpoint' in recording:
            self.servo = servo_of(nominal, effects, recording['setpoint'], dt)
        self.firsts = np.asarray(starts, int) - self.lead
        self.command = np.empty(len(u))
        _commands(np.ascontiguousarray(u, float), self.command, dt, self.packed.p)
        self.lagged = np.zeros(len(u))
        if self.packed.p[LAG] > 0.0:
            _lagged(self.command, self.lagged, dt, self.packed.p)
        self.memory = np.zeros((len(self.firsts), 4))
        if self.servo[0][KI] > 0.0:
            integral = np.zeros(len(u))
            control, reference = self.servo
            _integrals(recording['y'][:, 0], dt, control, reference, integral)
            self.memory[:, 3] = integral[np.maximum(self.firsts, 0)]

    def run(self, states: Array, chosen: Sequence[int] | Integers | None = None,
            keep: bool = False) -> Array:
        """
        Run the model freely through the windows.

        Args:
            states: initial states [W, 4], `lead` samples before the windows start.
            chosen: windows that `states` belong to; None: all.
            keep: let the memories (bristle, hysteresis) at the end of each window start the next.

        Returns:
            Encoder readings y [W, length, 2], rad.
        """
        chosen = range(len(self.firsts)) if chosen is None else chosen
        y = np.empty((len(chosen), self.length, 2))
        x, state = np.empty((self.lead + self.length, 4)), np.empty(8)
        for row, w in enumerate(chosen):
            state[:4], state[4:] = states[row], self.memory[w]
            first = int(self.firsts[w])
            _window(x, state, first, self.lagged[max(first, 0)], self.command, self.packed,
                    *self.servo)
            y[row] = read_encoders(x, self.effects, self.dt, self.lead)
            if keep and w + 1 < len(self.memory):
                self.memory[w + 1] = np.clip(np.nan_to_num(state[4:]), -1e3, 1e3)
        return y
