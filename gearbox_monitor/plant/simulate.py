# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Integrators of the drive, in one place for its kernels.

The classical Runge-Kutta method of fourth order, and the semi-implicit steps of simulators.

`equivalent_torque` makes one drive move like another (computed torque): run the drive C and ask at
each of its states which torque on motor and arm gives the drive E the accelerations of C: M_E (x''
of C less x'' of E). Nothing of C is needed where this torque acts.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from itertools import pairwise
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.errors import expect_whole, InputError
from gearbox_monitor.kernels.kernel import (
    address_of, apart, bound, called_back, compilable, entry, inline, kernel)
from gearbox_monitor.kernels.types import Array, column, Cube, Matrix, Vector
from gearbox_monitor.plant import effects
from gearbox_monitor.plant.drive import (
    arm_acceleration, arm_constraint, arm_load, braked, DriveModel, expect_model,
    fastest_eigenvalue, HALF_GAP, INVERSE_M1, INVERSE_M2, K_S, KIND, LAW,
    motor_acceleration_by_law, rigid_torque, steps_of, STIFFNESS, WIDTH)
from gearbox_monitor.plant.effects import (
    arm_profile, Effect, MAX_SETPOINT_DELAY, quantised, slip_profile, Three, Torques)
from gearbox_monitor.plant.effects.composition import (
    actuator, advanced_memories, arm_corrected, arm_effects, arm_error, base_friction, DELAY,
    DELAY1, DELAY2, elastic_torque, friction_effects, LAG, lead, motor_corrected, motor_effects,
    motor_error, motor_gain, reading, SERVO_DELAY, SERVO_LAG, step_damper, stored_memories)
from gearbox_monitor.plant.effects.registry import in_slot, MEMORIES, PLACES
from gearbox_monitor.plant.transmission import INTEGRATORS, RIGID, RK4, TANH, transmission_torque

Four: TypeAlias = tuple[float, float, float, float]


def integrator(derivative: Callable[..., Four], memories: Callable[..., Any],
               brake: Callable[..., tuple[float, float]]) -> Callable[..., tuple[Four, Any]]:
    """
    Return a compiled step: of the classical Runge-Kutta method (Kutta, 1901), or semi-implicit.

    Memories of effects are stiff, and exact for a constant speed: in each stage they are advanced
    by `memories` from the begin of the step at the speed of the stage before.

    A semi-implicit step has the accelerations of its begin, with linear damping at its end, and
    moves with the speeds of its end.

    Args:
        derivative: (t, x, m, inputs) -> (x1', x2', x3', x4') at time t (s), state x, memories m.
        memories: (m, x, x3, x4, h, inputs) -> m after h s from state x at the speeds x3, x4.
        brake: (h, x, m, inputs) -> factors on the accelerations of motor and arm by damping in a
            semi-implicit step; 0.0 for the Runge-Kutta method.

    Returns:
        A function (t, x, m, h, inputs) -> (changes of the four states, m after the step).
    """
    def step(t: float, x: Four, m: Any, h: float, inputs: Any) -> tuple[Four, Any]:
        x1, x2, x3, x4 = x
        half = 0.5 * h
        a1, a2, a3, a4 = derivative(t, x, m, inputs)
        motor, arm = brake(h, x, m, inputs)
        if motor != 0.0:
            v1, v2 = x3 + h * motor * a3, x4 + h * arm * a4
            change = (h * v1, h * v2, h * motor * a3, h * arm * a4)
            return change, memories(m, x, v1, v2, h, inputs)
        b1, b2, b3, b4 = derivative(
            t + half, (x1 + half * a1, x2 + half * a2, x3 + half * a3, x4 + half * a4),
            memories(m, x, a1, a2, half, inputs), inputs)
        c1, c2, c3, c4 = derivative(
            t + half, (x1 + half * b1, x2 + half * b2, x3 + half * b3, x4 + half * b4),
            memories(m, x, b1, b2, half, inputs), inputs)
        d1, d2, d3, d4 = derivative(
            t + h, (x1 + h * c1, x2 + h * c2, x3 + h * c3, x4 + h * c4),
            memories(m, x, c1, c2, h, inputs), inputs)
        v1, v2 = (a1 + 2.0 * b1 + 2.0 * c1 + d1) / 6.0, (a2 + 2.0 * b2 + 2.0 * c2 + d2) / 6.0
        change = (h * v1, h * v2, h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3),
                  h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4))
        return change, memories(m, x, v1, v2, h, inputs)
    return step


# State of a simulation: x1..x4, then the memories of the transmission and of effects.
N_STATE = 4 + effects.N_MEMORY
MOTOR, ARM, TRANSMISSION = range(3)  # where a torque from outside acts
# Of one step, rad and rad/s: in 30 s of motion that turns round, positions are then off by less
# than a tenth of this.
TOLERANCE = 1e-6
OF_NOISE = 1e-3         # of the encoders: the same, where that is finer
SHORTEST = 256          # parts of a step at most, a power of 2
# Steps of a sample in which the command changes or hysteresis turns round: an error control that
# looks at the ends of a step sees neither.
CHANGING = 32
DOUBLED = 2.0 ** -5     # of the tolerance: the error of a part that may be twice as long


class PackedDrive(NamedTuple):
    """
    A drive as kernels take it: DriveModel.pack, effects.pack, parameters of a plug-in.

    call: where kernels call the plug-in's torques back; 0: they are in the kernels, or there is
    none.
    """

    p: Vector
    e: Vector
    theta: Vector
    call: int = 0


class ProcessNoise(NamedTuple):
    """Standard normal numbers [N, n, 4] and their standard deviations [4] per sqrt(s)."""

    numbers: Cube
    std: Vector


class Schedule(NamedTuple):
    """
    What drives a run of N samples.

    t: times [N], s. u: torque of the actuator [N, n] in each of n substeps, N m. extra: torque
    from outside [N, 3] on motor, arm and in the transmission, N m. dt: length of a sample, s.
    """

    t: Vector
    u: Matrix
    extra: Matrix
    dt: float


Inputs: TypeAlias = tuple[float, Three, PackedDrive]  # of a substep: u, extra, drive


@dataclass(frozen=True)
class Noise:
    """
    Standard deviations of the plant's noise.

    process: of each state per square root of a second, [4], in rad/sqrt(s), rad/s/sqrt(s).
    measurement: of each encoder, [2], rad.
    """

    process: Sequence[float] = (0.0, 0.0, 0.0, 0.0)
    measurement: Sequence[float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name, count in (('process', 4), ('measurement', 2)):
            value = column(getattr(self, name), f'Noise: {name}', f'{count} standard deviations')
            if len(value) != count or not np.all((0.0 <= value) & (value < math.inf)):
                raise InputError(f'Noise: {name}: {value}, expected {count} finite values >= 0')


@dataclass(frozen=True)
class Trajectory:
    """
    Simulated samples, N of them, `dt` s apart.

    t [N] s; u [N] N m, or setpoint, rad, held from t_k to t_k+1; y [N, 2] measured and x [N, 4]
    true states; tau_k, tau_arm [N] true torque of the transmission and load on the arm, N m.
    """

    t: np.ndarray
    u: np.ndarray
    y: np.ndarray
    x: np.ndarray
    tau_k: np.ndarray
    tau_arm: np.ndarray


@inline
def plugged(t: float, x1: float, x2: float, x3: float, x4: float, u: float, tau_k: float,
            theta: Array) -> Three:
    """
    Return the torques of a plug-in: none, see with_plugin.

    Args:
        t: time, s.
        x1: position of the motor, rad.
        x2: position of the arm, rad.
        x3: speed of the motor, rad/s.
        x4: speed of the arm, rad/s.
        u: torque of the actuator, N m.
        tau_k: torque of the transmission without plug-ins, N m.
        theta: parameters of the plug-ins.

    Returns:
        Torques on the motor, on the arm (its load) and in the transmission, N m.
    """
    return 0.0, 0.0, 0.0


@inline
def torques(t: float, x: Four, m: Any, u: float, drive: PackedDrive) -> Three:
    """
    Return the torques of effects and of the transmission.

    Args:
        t: time, s.
        x: positions and speeds of motor and arm, rad and rad/s.
        m: memories [N_MEMORY].
        u: torque of the actuator, N m.
        drive: PackedDrive.

    Returns:
        (tau_k, tau_arm, torque on the motor beyond equation (1)) in N m.
    """
    x1, x2, x3, x4 = x
    p, e = drive.p, drive.e
    tau_k = elastic_torque(x1, x2, m, p, e)
    motor = motor_effects(u, e, x1, x3, m) - u - friction_effects(
        0.0, e, m, t, x3, base_friction(p))
    tau_arm = arm_effects(arm_load(x2, x4, p), e, m, t, x2, x4)
    on_motor, on_arm, in_gearbox = plugged(t, x1, x2, x3, x4, u, tau_k, drive.theta)
    if drive.call != 0:
        on_motor, on_arm, in_gearbox = called_back(
            drive.call, (t, x1, x2, x3, x4, u, tau_k), drive.theta)
    return tau_k + in_gearbox, tau_arm + on_arm, motor + on_motor


@inline
def constrained(x: Four, u: float, extra: Three, acting: Three, p: Array) -> float:
    """
    Return tau_K: of the constraint in a rigid transmission, else with what is added.

    Args:
        x: state, see torques.
        u: torque of the actuator, N m.
        extra: torques from outside on motor, arm and in the transmission, N m.
        acting: see torques.
        p: packed model.

    Returns:
        Torque, N m.
    """
    if int(p[KIND]) == RIGID:
        return rigid_torque(x[0], x[2], u + acting[2] + extra[0], acting[1] - extra[1], p)
    return acting[0] + extra[2]


@apart
def derivative(t: float, x: Four, m: Any, inputs: Inputs) -> Four:
    """
    Return the slopes of positions and speeds.

    Args:
        t: time, s.
        x: positions and speeds of motor and arm, rad and rad/s.
        m: memories [N_MEMORY].
        inputs: torque of the actuator, torques from outside, drive.

    Returns:
        Speeds and accelerations of motor and arm, rad/s and rad/s^2.
    """
    u, extra, drive = inputs
    acting = torques(t, x, m, u, drive)
    tau_k = constrained(x, u, extra, acting, drive.p)
    p, tau_arm = drive.p, acting[1] - extra[1]
    tau_arm += arm_constraint(x[2], x[3], tau_k, tau_arm, p)
    arm = arm_acceleration(x[2], x[3], tau_k, tau_arm, p)
    if p[LAW] > TANH and int(p[KIND]) == RIGID:
        return x[2], x[3], arm, arm  # friction is in tau_k
    return (x[2], x[3], motor_acceleration_by_law(
        x[0], x[2], x[3], u + acting[2] + extra[0], tau_k, p), arm)


@inline
def _memories(m: Any, x: Four, x3: float, x4: float, h: float, inputs: Inputs) -> Any:
    u, _, drive = inputs
    return advanced_memories(m, (u, x[0], x[2]), x3, x4, h, base_friction(drive.p), drive.e)


@inline
def _brake(h: float, x: Four, m: Any, inputs: Inputs) -> tuple[float, float]:
    u, _, drive = inputs
    return braked(h, step_damper(u, drive.e, x[0], x[2], m), drive.p)


step = integrator(derivative, _memories, _brake)


@inline
def play_after(x: Four, m: Any, p: Array) -> float:
    """Return the memory of the transmission in `p` after a step to `x`; `m`: all at its begin."""
    return transmission_torque(
        x[0] - x[1], m[0], int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH], p[K_S])[1]


@kernel
def advance(state: Array, t: float, dt: float, u: Array, extra: Three,
            noise: tuple[Array, Array], drive: PackedDrive, tolerance: float) -> None:
    """
    Advance `state` in place by one sample, in n steps of the Runge-Kutta method.

    The memory of the transmission is updated once per step, and clamped in every stage; those of
    effects relax over each stage at its speed. With a tolerance, a step is halved until two halves
    differ from the whole by no more (Hairer, Norsett and Wanner, Solving Ordinary Differential
    Equations I, II.4): where friction turns round and where the gap closes. Noise acts at the end
    of each of the n steps.

    Args:
        state: [N_STATE].
        t: time at the begin, s.
        dt: length of the sample, s.
        u: torque of the actuator in each step [n], N m.
        extra: torques from outside on motor, arm and in the transmission, N m.
        noise: of a ProcessNoise, numbers in each step [n, 4] and std [4].
        drive: PackedDrive.
        tolerance: error of a step, rad and rad/s; 0: steps are as long as they are.
    """
    n, p, (numbers, std) = u.shape[0], drive.p, noise
    h = dt / n
    root_h = math.sqrt(h)
    x = (state[0], state[1], state[2], state[3])
    m = stored_memories(state)
    for i in range(n):
        inputs = (u[i], extra, drive)
        at, size = 0, SHORTEST  # in the shortest lengths of a part of the step
        while at < SHORTEST:
            begin, length = t + h * at / SHORTEST, h * size / SHORTEST
            whole, y, w = x, x, m
            for part in range(3 if tolerance > 0.0 else 1):  # the whole, then half by half
                if part == 1:
                    whole, y, w, length = y, x, m, 0.5 * length
                elif part == 2:
                    begin += length
                change, w = step(begin, y, w, length, inputs)
                y = (y[0] + change[0], y[1] + change[1], y[2] + change[2], y[3] + change[3])
                w = (play_after(y, w, p),) + w[1:]
            error = 0.0
            if tolerance > 0.0:
                error = max(abs(y[0] - whole[0]), abs(y[1] - whole[1]),
                            abs(y[2] - whole[2]), abs(y[3] - whole[3]))
            if size > 1 and not error <= tolerance:
                size //= 2
                continue
            x, m = y, w
            at += size
            if error <= DOUBLED * tolerance and at % (2 * size) == 0:
                size *= 2
        if std[0] + std[1] + std[2] + std[3] > 0.0:
            x = (x[0] + root_h * std[0] * numbers[i, 0],
                 x[1] + root_h * std[1] * numbers[i, 1],
                 x[2] + root_h * std[2] * numbers[i, 2],
                 x[3] + root_h * std[3] * numbers[i, 3])
            m = (play_after(x, m, p),) + m[1:]
        t += h
    state[0], state[1], state[2], state[3] = x
    for i in range(N_STATE - 4):
        state[4 + i] = m[i]


@entry
def _run(state: Vector, schedule: Schedule, noise: ProcessNoise, drive: PackedDrive, x: Matrix,
         tau: Matrix, tolerance: float) -> None:
    t, u, extra, dt = schedule
    for k in range(u.shape[0]):
        x[k] = state[:4]
        external = (extra[k, 0], extra[k, 1], extra[k, 2])
        at = (state[0], state[1], state[2], state[3])
        acting = torques(t[k], at, stored_memories(state), u[k, 0], drive)
        tau[k, 0] = constrained(at, u[k, 0], external, acting, drive.p)
        tau[k, 1] = acting[1] - external[1]
        tau[k, 1] += arm_constraint(at[2], at[3], tau[k, 0], tau[k, 1], drive.p)
        advance(state, t[k], dt, u[k], external, (noise.numbers[k], noise.std), drive, tolerance)


def rebuilt(kernel: Any, **names: Any) -> Any:
    """Return a copy of `kernel` that calls the functions `names` under these global names."""
    return bound(kernel, 'rebuilt', **names)


@cache
def call_of(added: Torques) -> int:
    """Return PackedDrive.call of a plug-in: 0 if its torques can be compiled into kernels."""
    return 0 if compilable(added, *(float,) * 7, Vector) else address_of(added)


@cache
def with_plugin(added: Torques, *kernels: Any) -> tuple[Any, ...]:
    """
    Return `kernels` that call torques, step or advance, rebuilt around a plug-in.

    They are compiled at their first call and kept by their content. As they are where that cannot
    be: then they call the plug-in back (see call_of).

    Args:
        added: the `torques` of the plug-in's Effect.
        kernels: compiled functions.

    Returns:
        As many compiled functions.
    """
    if call_of(added):
        return kernels
    with_added = rebuilt(torques, plugged=added)
    added_step = integrator(rebuilt(derivative, torques=with_added), _memories, _brake)
    sample = rebuilt(advance, step=added_step)
    return tuple(rebuilt(kernel, torques=with_added, step=added_step, advance=sample)
                 for kernel in kernels)


@cache
def _sum(first: Torques, second: Torques, n: int) -> Torques:
    """Return the torques of two plug-ins together; the first has `n` parameters."""
    def torques(t: float, x1: float, x2: float, x3: float, x4: float, u: float, tau_k: float,
                theta: Array) -> Three:
        a, b, c = first(t, x1, x2, x3, x4, u, tau_k, theta[:n])
        d, e, f = second(t, x1, x2, x3, x4, u, tau_k, theta[n:])
        return a + d, b + e, c + f
    return torques


def plugin_of(model: DriveModel) -> tuple[Effect | None, Array]:
    """Return (Effect or None, theta): the plug-in effect of `model`, several joined to one."""
    joined: Effect | None = None
    theta: list[float] = []
    for values in model.effects:
        if values['id'] in effects.EFFECTS:
            continue
        effect = effects.plugins()[values['id']]
        if joined is None:
            joined = effect
        else:
            joined = replace(joined, id=f'{joined.id}+{effect.id}',
                             torques=_sum(joined.torques, effect.torques, len(theta)))
        theta += [float(values.get(p.name, p.default)) for p in effect.parameters]
    return joined, np.array(theta, float)


def packed_drive(model: DriveModel, e: Array | None = None) -> PackedDrive:
    """Return the drive `model` as kernels take it, with its plug-in; e: other packed effects."""
    plugin, theta = plugin_of(model)
    return PackedDrive(model.pack(), model.pack_effects() if e is None else e, theta,
                       call_of(plugin.torques) if plugin else 0)


def _changes_within(model: DriveModel, e: Array) -> bool:
    """
    Return whether the torque depends on what happens within a sample, not at its ends alone.

    Args:
        model: the drive.
        e: its packed effects.
    """
    delayed = any(e[place] > 0.0 for place in (LAG, DELAY, SERVO_LAG, SERVO_DELAY))
    hysteretic = any(
        e[PLACES[effect.id]] != 0.0 for slot in ('elastic', 'twist') for effect in in_slot(slot)
        if effect.id in MEMORIES)
    return delayed or hysteretic or model.transmission.kind in ('play', 'passive_play')


class Plant:
    """
    A simulated drive that keeps its state between calls; `model` may be replaced meanwhile.

    noise: Noise, None for none; seed: of that noise; state: positions and speeds to start from.
    """

    def __init__(self, model: DriveModel, noise: Noise | None = None, seed: int = 0,
                 state: Array | None = None) -> None:
        self.noise = noise or Noise()
        # One generator each: then the numbers do not depend on how a run is cut into calls.
        self.process_random, self.measurement_random = (
            np.random.default_rng(sequence) for sequence in np.random.SeedSequence(seed).spawn(2))
        self.state = np.zeros(N_STATE)
        if state is not None:
            self.state[:len(state)] = state
        self._past_u, self._past_x = np.zeros(0), np.zeros((0, 4))
        self._lagged, self._setpoints = 0.0, np.zeros(0)
        self._slipped = 0.0  # rad, by which the kernel counts the motor less
        self.model = model

    @property
    def model(self) -> DriveModel:
        """The `model` in force."""
        return self._model

    @model.setter
    def model(self, model: DriveModel) -> None:
        plugin, _ = plugin_of(model)
        if plugin is None:
            self._kernel, self._plugin = _run, None
        elif plugin.id != getattr(self, '_plugin', None):
            self._kernel, self._plugin = with_plugin(plugin.torques, _run)[0], plugin.id
        self._model = model
        self._drive = packed_drive(model)
        self._eigenvalue = fastest_eigenvalue(model)

    @property
    def tolerance(self) -> float:
        """
        Error of an integration step, rad and rad/s: far below the noise of the encoders.

        0 where the model is that of a simulator, which steps as it does.
        """
        if self._model.timestep or self._model.integrator != INTEGRATORS[RK4]:
            return 0.0
        return min([TOLERANCE, *(OF_NOISE * s for s in self.noise.measurement if s > 0.0)])

    def _common(self, numbers: Array, std: Array) -> ProcessNoise:
        """Return the ProcessNoise of a drive; in a rigid one motor and arm move as one."""
        if self._model.transmission.kind != 'rigid' or not std.any():
            return ProcessNoise(numbers, std)
        inertias = np.array([self._model.motor_inertia, self._model.arm_inertia])
        impulse = (numbers * std).reshape(*numbers.shape[:2], 2, 2) @ (inertias / inertias.sum())
        return ProcessNoise(np.repeat(impulse, 2, axis=2), np.ones(4))

    def run(self, u: Array, dt: float, t0: float = 0.0) -> Trajectory:
        """
        Apply a torque and return what the drive does.

        Args:
            u: torque [N], held over a sample, N m; setpoint, rad, if the model has a controller.
            dt: length of a sample, s.
            t0: time at the begin, s.

        Returns:
            The Trajectory.
        """
        u = np.ascontiguousarray(u, float)
        first = t0 / dt  # counted in samples: then a run has the same times however it is cut
        first = round(first) if abs(first - round(first)) < 1e-6 else first
        t = (first + np.arange(len(u))) * dt
        slip = slip_profile(self._model.effects, t)
        if slip is None or not len(u):
            return self._run(u, dt, t)
        cuts, parts = [0, *(np.flatnonzero(np.diff(slip)) + 1), len(u)], []
        for a, b in pairwise(cuts):
            self._slip_by(slip[a] - self._slipped)
            parts.append(self._run(u[a:b], dt, t[a:b]))
        return Trajectory(**{column.name: np.concatenate([getattr(part, column.name)
                                                          for part in parts])
                             for column in fields(Trajectory)})

    def _slip_by(self, angle: float) -> None:
        """Let the motor slip by `angle`, rad, against the arm."""
        self._slipped += angle
        self.state[0] -= angle
        self._past_x[:, 0] -= angle
        if self._model.controller is not None:
            self._past_u -= angle
            self._lagged -= angle

    def _run(self, u: Array, dt: float, t: Array) -> Trajectory:
        """Run as run() does, at times `t` [N], s; nothing slips meanwhile."""
        n = steps_of(self._model, dt, self._eigenvalue)
        if self.tolerance > 0.0 and _changes_within(self._model, self._drive.e):
            n = max(n, CHANGING)
        process = np.asarray(self.noise.process, float)
        shape = (len(u), n, 4)
        noise = self.process_random.standard_normal(shape) if process.any() else np.zeros(shape)
        x, tau, acting = np.empty((len(u), 4)), np.empty((len(u), 2)), np.empty((len(u), n))
        keep = math.ceil(MAX_SETPOINT_DELAY / dt) + 2
        if len(self._past_u) != keep and len(u):
            self._past_u = np.zeros(keep)  # before the start there was no torque
            self._setpoints = np.array([u[0], u[0], 0.0])
        commanded = np.concatenate([self._past_u, u])
        lead(commanded[keep:], self._setpoints, dt, self._drive.e)
        if self._model.controller is not None:
            commanded[keep:] -= self._slipped
        self._lagged = actuator(commanded, keep, self._lagged, dt, self._drive.e, acting)
        self._past_u = commanded[-keep:]
        extra = np.zeros((len(u), 3))
        extra[:, ARM] = -arm_profile(self._model.effects, t, dt)
        self._kernel(self.state, Schedule(t, acting, extra, dt), self._common(noise, process),
                     self._drive, x, tau, self.tolerance)
        rows = np.concatenate([self._past_x, x])
        self._past_x = rows[-keep:]
        y = np.empty((len(u), 2))
        read_all(rows, len(rows) - len(u), dt, self._drive.e, y)
        y[:, 0] += self._slipped
        x[:, 0] += self._slipped
        y += self.measurement_random.standard_normal((len(u), 2)) * self.noise.measurement
        return Trajectory(t, u, quantised(y, self._model.effects), x, tau[:, 0], tau[:, 1])


@entry
def read_all(x: Matrix, begin: int, dt: float, e: Vector, y: Matrix) -> None:
    """
    Fill `y` [N, 2] (rad) with what the encoders read, without noise.

    Args:
        x: states [begin + N, 4].
        begin: row of x of the first reading.
        dt: time from row to row, s.
        e: packed effects.
        y: room for the readings.
    """
    for k in range(y.shape[0]):
        y[k, 0] = reading(x, begin + k, 0, dt, e)
        y[k, 1] = reading(x, begin + k, 1, dt, e)


def simulate(model: DriveModel, u: Array, dt: float, noise: Noise | None = None,
             seed: int = 0) -> Trajectory:
    """
    Simulate the drive from rest.

    Args:
        model: DriveModel.
        u: torque [N], held over a sample, N m; setpoint, rad, if the model has a controller.
        dt: length of a sample, s.
        noise: Noise, None for none.
        seed: of that noise.

    Returns:
        The Trajectory.

    Raises:
        InputError: an argument is of another type or shape, or the torque is not finite.

    >>> import numpy as np
    >>> run = simulate(DriveModel(), np.ones(100), 1e-3)
    >>> run.y.shape, bool(run.y[-1, 0] > 0.0)
    ((100, 2), True)
    """
    u = column(u, 'u', 'torque in N m, or setpoint in rad')
    bad = np.flatnonzero(~np.isfinite(u))
    if len(bad):
        raise InputError(f'u: {u[bad[0]]:g} in sample {bad[0]} ({len(bad)} of {len(u)} are not '
                         'finite), expected a torque in N m')
    if isinstance(dt, bool) or not isinstance(dt, (int, float, np.number)) or not 0.0 < dt < 1e3:
        raise InputError(f'dt: {dt!r}, expected the length of a sample in s, > 0')
    if not isinstance(noise, (Noise, type(None))):
        raise InputError(f'noise: {noise!r}, expected a Noise')
    expect_whole(seed, 'seed')
    return Plant(expect_model(model), noise, seed).run(u, float(dt))


TANGENT = 0.1        # of the twist, over which a stiffness is taken
TORQUE_SHARE = 0.1   # of the torque, by which it may be off where the twist is off by its size
HALVINGS = 12        # of a range for the twist
NO_SETPOINT = (0.0, 0.0, 0.0)  # of a servo, which a measured motion has not


@kernel
def torque_difference(t: float, state: Array, u: float, extra: Three,
                      drives: tuple[PackedDrive, PackedDrive]) -> tuple[float, float]:
    """
    Return the torque that drive E lacks at a state.

    Args:
        t: time, s.
        state: [N_STATE] of C.
        u: torque of the actuator, N m.
        extra: torques from outside on motor, arm and in the transmission, N m.
        drives: C and E.

    Returns:
        Torques on motor and arm, N m.
    """
    closed, expressed = drives
    x, m = (state[0], state[1], state[2], state[3]), stored_memories(state)
    target = derivative(t, x, m, (u, extra, closed))
    own = derivative(t, x, m, (u, extra, expressed))
    return ((target[2] - own[2]) / expressed.p[INVERSE_M1],
            (target[3] - own[3]) / expressed.p[INVERSE_M2])


@entry
def _torque_run(state: Vector, schedule: Schedule, noise: ProcessNoise,
         drives: tuple[PackedDrive, PackedDrive], torque: Matrix) -> None:
    t, u, extra, dt = schedule
    n = u.shape[1]
    h = dt / n
    for k in range(u.shape[0]):
        external = (extra[k, 0], extra[k, 1], extra[k, 2])
        torque[k, 0], torque[k, 1] = external[0], external[1]
        for i in range(n):
            at = t[k] + i * h
            first = torque_difference(at, state, u[k, i], external, drives)
            advance(state, at, h, u[k, i:i + 1], external, (noise.numbers[0], noise.std),
                    drives[0], 0.0)
            second = torque_difference(at + h, state, u[k, i], external, drives)
            torque[k, 0] += (u[k, i] + 0.5 * (first[0] + second[0])) / n
            torque[k, 1] += 0.5 * (first[1] + second[1]) / n


@kernel
def lacking_twist(lacks: float, x1: float, x2: float, m: Any, sizes: tuple[float, float],
                  drive: PackedDrive) -> float:
    """
    Return how far a twist is from the curve of torque over twist, rad.

    Along the twist, or along the tangent where that is nearer: in the gap, a little torque is no
    reason to be at its end.

    Args:
        lacks: torque that the transmission does not have, N m.
        x1: position of the motor, rad.
        x2: position of the arm, rad.
        m: memories.
        sizes: of the twist in a recording, rad, and of its torque, N m.
        drive: PackedDrive.
    """
    p, e = drive.p, drive.e
    size, torque = sizes
    sign = 1.0 if lacks > 0.0 else -1.0
    here, near = elastic_torque(x1, x2, m, p, e), TANGENT * size
    slope = (elastic_torque(x1, x2 - near, m, p, e)
             - elastic_torque(x1, x2 + near, m, p, e)) / (2.0 * near)
    secant = TORQUE_SHARE * torque / size
    # Which is as far as it is worth looking.
    low, high = 0.0, sign * lacks / math.sqrt(slope * slope + secant * secant)
    if sign * (elastic_torque(x1, x2 - sign * high, m, p, e) - here - lacks) < 0.0:
        return sign * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if sign * (elastic_torque(x1, x2 - sign * middle, m, p, e) - here - lacks) < 0.0:
            low = middle
        else:
            high = middle
    return sign * 0.5 * (low + high)


@entry
def imbalance(path: tuple[Vector, Matrix], step: float, sizes: tuple[float, float],
              torque: Vector, extra: Matrix, drive: PackedDrive, state: Vector,
              out: Matrix) -> None:
    """
    Fill in the torques that move a drive beyond what its equations say.

    Args:
        path: times [M], s, and positions, speeds and accelerations of motor and arm [M, 6].
        step: time from row to row, s, over which memories advance; 0: they stay.
        sizes: of the twist in the recording, rad, and of its torque, N m.
        torque: of the actuator [M], N m.
        extra: torques from outside [M, 3], N m.
        drive: PackedDrive.
        state: workspace [N_STATE].
        out: torques [M, 2] on the whole drive and on the arm, N m; with a step [M, 3]:
            the lacking twist, rad.
    """
    (t, motion), p, e = path, drive.p, drive.e
    base = base_friction(p)
    for k in range(len(t)):
        m = stored_memories(state)
        x = (motion[k, 0], motion[k, 1], motion[k, 2], motion[k, 3])
        if step > 0.0 and k > 0:
            m = advanced_memories(m, NO_SETPOINT, 0.5 * (motion[k - 1, 2] + x[2]),
                                  0.5 * (motion[k - 1, 3] + x[3]), step, base, e)
            state[4] = play_after(x, m, p)
            for i in range(1, len(state) - 4):
                state[4 + i] = m[i]
            m = stored_memories(state)
        rate = derivative(t[k], x, m, (torque[k], (extra[k, 0], extra[k, 1], extra[k, 2]), drive))
        out[k, 1] = (motion[k, 5] - rate[3]) / p[INVERSE_M2]
        out[k, 0] = (motion[k, 4] - rate[2]) / p[INVERSE_M1] + out[k, 1]
        if step > 0.0 and int(p[KIND]) != RIGID:
            out[k, 2] = lacking_twist(out[k, 1], x[0], x[1], m, sizes, drive)


@entry
def true_motion(read: Matrix, dt: float, e: Vector, out: Matrix) -> None:
    """
    Fill in the motion that encoders with their effects read.

    Args:
        read: positions, speeds and accelerations of motor and arm as read [N, 6].
        dt: time from row to row, s.
        e: packed effects.
        out: the same [N, 6] of the drive.
    """
    n = read.shape[0]
    for side in range(2):
        late = e[DELAY1 if side == 0 else DELAY2] / dt
        for k in range(n):
            i = min(int(k + late), n - 1)
            h = (k + late - i) * dt if k + late < n else 0.0
            y, v, a = read[i, side], read[i, 2 + side], read[i, 4 + side]
            y, v = y + h * (v + 0.5 * h * a), v + h * a
            a += h / dt * (read[min(i + 1, n - 1), 4 + side] - a)
            if side == 0:
                error, slope, curvature = motor_error(NO_SETPOINT, e, motor_corrected(y, e))
            else:
                error, slope, curvature = arm_error(NO_SETPOINT, e, arm_corrected(y, e))
            out[k, side], out[k, 2 + side] = y - error, v * (1.0 - slope)
            out[k, 4 + side] = a * (1.0 - slope) - curvature * v * v


@entry
def gains(x1: Vector, e: Vector, out: Vector) -> None:
    """
    Fill in the torque that acts over the torque that is logged.

    Args:
        x1: positions of the motor [N], rad.
        e: packed effects.
        out: ratios [N].
    """
    for k in range(len(x1)):
        out[k] = motor_gain(1.0, e, x1[k])


@cache
def imbalance_with(added: Torques) -> Any:
    """Return imbalance rebuilt around the torques `added` by a plug-in."""
    return rebuilt(imbalance, derivative=rebuilt(
        derivative, torques=rebuilt(torques, plugged=added)))


def equivalent_torque(schedule: Schedule, state: Array, closed: PackedDrive,
                      expressed: PackedDrive) -> Array:
    """
    Return the torques that move a drive E as C moves.

    Args:
        schedule: what drives C.
        state: [N_STATE] where C begins.
        closed: C.
        expressed: E.

    Returns:
        Mean torques on motor and arm over each sample [N, 2], N m: those of the actuator and from
        outside, and what E lacks.
    """
    torque = np.empty((len(schedule.u), 2))
    _torque_run(state.copy(), schedule, ProcessNoise(np.zeros((1, 1, 4)), np.zeros(4)),
         (closed, expressed), torque)
    return torque
