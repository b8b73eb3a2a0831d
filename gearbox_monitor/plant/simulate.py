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

"""Simulate the drive: RK4 with zero-order-hold torque, effects, seeded noise."""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
import math
import types
from typing import Any

import numpy as np

from gearbox_monitor.kernels.jit import jit, jit_anew, jit_inline
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant import effects
from gearbox_monitor.plant.drive import (
    ALPHA, arm_acceleration, arm_load, CC, CV, DriveModel, fastest_eigenvalue, HALF_GAP, K_S, KIND,
    motor_acceleration, rigid_torque, STIFFNESS, substeps, WIDTH)
from gearbox_monitor.plant.effects import arm_profile, Effect, MAX_DELAY, quantised, Three, Torques
from gearbox_monitor.plant.effects.equations import (
    actuator, BRANCH_DS, BRANCH_H, bristle, DH, elastic_torque, friction_effects, loop_memory,
    motor_torque, reading, SIGMA0, TH)
from gearbox_monitor.plant.transmission import RIGID, transmission_torque

# State of a simulation: x1..x4, memory of the transmission, of lugre, bouc_wen and branch.
N_STATE = 8
MOTOR, ARM, TRANSMISSION = range(3)  # where a torque from outside acts
NO_TORQUE = np.zeros((0, 3))


@dataclass(frozen=True)
class Noise:
    """
    Standard deviations of the plant's noise.

    process: of each state per square root of a second, [4], in rad/sqrt(s), rad/s/sqrt(s).
    measurement: of each encoder, [2], rad.
    """

    process: Sequence[float] = (0.0, 0.0, 0.0, 0.0)
    measurement: Sequence[float] = (0.0, 0.0)


@dataclass(frozen=True)
class Trajectory:
    """
    Simulated samples, N of them, `dt` s apart.

    t [N] s; u [N] N m, held from t_k to t_k+1; y [N, 2] measured and x [N, 4] true states;
    tau_k, tau_arm [N] true torque of the transmission and load on the arm, N m.
    """

    t: np.ndarray
    u: np.ndarray
    y: np.ndarray
    x: np.ndarray
    tau_k: np.ndarray
    tau_arm: np.ndarray


@jit_inline
def plugged(t: float, x1: float, x2: float, x3: float, x4: float, u: float, tau_k: float,
            theta: Array) -> Three:
    """
    Return torques on motor, arm (its load) and in the transmission: none, see with_plugin.

    Arguments t, x1, x2, x3, x4, u, tau_k, theta: those of every plug-in (docs/plugins.md).
    """
    return 0.0, 0.0, 0.0


@jit_inline
def _torques(t: float, x1: float, x2: float, x3: float, x4: float, u: float, w: float, z: float,
             loop: float, branch: float, p: Array, e: Array, theta: Array) -> Three:
    """Return (tau_k, tau_arm, torque on the motor beyond equation (1)) in N m."""
    tau_k, _ = elastic_torque(x1, x2, w, loop, branch, int(p[KIND]), p[STIFFNESS], p[HALF_GAP],
                              p[WIDTH], p[K_S], e)
    motor = motor_torque(x1, u, e) - u - friction_effects(x3, z, t, p[CV], p[CC], p[ALPHA], e)
    m, a, k = plugged(t, x1, x2, x3, x4, u, tau_k, theta)
    return tau_k + k, arm_load(x2, x4, p) + a, motor + m


@jit_inline
def _constrained(x1: float, x3: float, u: float, extra: Three, tau_k: float, tau_arm: float,
                 motor: float, p: Array) -> float:
    """Return tau_K: of the constraint where the transmission is rigid, else with what is added."""
    if int(p[KIND]) == RIGID:
        return rigid_torque(x1, x3, u + motor + extra[0], tau_arm - extra[1], p)
    return tau_k + extra[2]


@jit_inline
def _derivative(t: float, x1: float, x2: float, x3: float, x4: float, u: float, extra: Three,
                w: float, z: float, loop: float, branch: float, p: Array, e: Array,
                theta: Array) -> tuple[float, float, float, float]:
    tau_k, tau_arm, motor = _torques(t, x1, x2, x3, x4, u, w, z, loop, branch, p, e, theta)
    tau_k = _constrained(x1, x3, u, extra, tau_k, tau_arm, motor, p)
    return (x3, x4, motor_acceleration(x1, x3, x4, u + motor + extra[0], tau_k, p),
            arm_acceleration(x3, x4, tau_k, tau_arm - extra[1], p))


@jit_inline
def _memories(x3: float, x4: float, z: float, loop: float, branch: float, h: float, p: Array,
              e: Array) -> Three:
    """Return the memories of lugre, bouc_wen and branch after `h` s at these speeds."""
    if e[SIGMA0] != 0.0:
        z = bristle(z, x3, h, p[CC], e)
    if e[TH] != 0.0:
        loop = loop_memory(loop, x3 - x4, e[DH], h)
    if e[BRANCH_H] != 0.0:
        branch = loop_memory(branch, x3 - x4, e[BRANCH_DS], h)
    return z, loop, branch


@jit
def advance(state: Array, t: float, u: Array, extra: Three, dt: float, n: int, noise: Array,
            process_std: Array, p: Array, e: Array, theta: Array) -> None:
    """
    Advance `state` [N_STATE] in place by `dt` s from time `t` in `n` RK4 substeps.

    u [n]: torque of the actuator in each substep. extra: torques (N m) from outside on motor, arm
    and in the transmission. noise: standard normal numbers [n, 4], process_std [4] per square
    root of a second. p, e, theta: packed model, effects, parameters of a plug-in. The memory of
    the transmission is updated once per substep, and clamped in every stage; the others relax
    over each stage as at its speed.
    """
    h = dt / n
    root_h, half = math.sqrt(h), 0.5 * h
    x1, x2, x3, x4, w = state[0], state[1], state[2], state[3], state[4]
    z, loop, branch = state[5], state[6], state[7]
    for i in range(n):
        a1, a2, a3, a4 = _derivative(t, x1, x2, x3, x4, u[i], extra, w, z, loop, branch, p, e,
                                     theta)
        m1, m2, m3 = _memories(a1, a2, z, loop, branch, half, p, e)
        b1, b2, b3, b4 = _derivative(
            t + half, x1 + half * a1, x2 + half * a2, x3 + half * a3, x4 + half * a4, u[i],
            extra, w, m1, m2, m3, p, e, theta)
        m1, m2, m3 = _memories(b1, b2, z, loop, branch, half, p, e)
        c1, c2, c3, c4 = _derivative(
            t + half, x1 + half * b1, x2 + half * b2, x3 + half * b3, x4 + half * b4, u[i],
            extra, w, m1, m2, m3, p, e, theta)
        m1, m2, m3 = _memories(c1, c2, z, loop, branch, h, p, e)
        d1, d2, d3, d4 = _derivative(
            t + h, x1 + h * c1, x2 + h * c2, x3 + h * c3, x4 + h * c4, u[i], extra, w, m1, m2,
            m3, p, e, theta)
        v1, v2 = (a1 + 2.0 * b1 + 2.0 * c1 + d1) / 6.0, (a2 + 2.0 * b2 + 2.0 * c2 + d2) / 6.0
        x1 += h * v1 + root_h * process_std[0] * noise[i, 0]
        x2 += h * v2 + root_h * process_std[1] * noise[i, 1]
        x3 += h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3) + root_h * process_std[2] * noise[i, 2]
        x4 += h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4) + root_h * process_std[3] * noise[i, 3]
        _, w = transmission_torque(
            x1 - x2, w, int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH], p[K_S])
        z, loop, branch = _memories(v1, v2, z, loop, branch, h, p, e)
        t += h
    state[0], state[1], state[2], state[3], state[4] = x1, x2, x3, x4, w
    state[5], state[6], state[7] = z, loop, branch


@jit
def _run(state: Array, t: Array, u: Array, extra: Array, dt: float, n: int, noise: Array,
         process_std: Array, p: Array, e: Array, theta: Array, x: Array, tau: Array) -> None:
    for k in range(u.shape[0]):
        for i in range(4):
            x[k, i] = state[i]
        outside = (extra[k, 0], extra[k, 1], extra[k, 2])
        tau_k, tau_arm, motor = _torques(t[k], state[0], state[1], state[2], state[3], u[k, 0],
                                         state[4], state[5], state[6], state[7], p, e, theta)
        tau[k, 0] = _constrained(state[0], state[2], u[k, 0], outside, tau_k, tau_arm, motor, p)
        tau[k, 1] = tau_arm - outside[1]
        advance(state, t[k], u[k], outside, dt, n, noise[k], process_std, p, e, theta)


def rebuilt(kernel: Any, **names: Any) -> Any:
    """Return `kernel` compiled anew with other functions under the global `names` it calls."""
    kernel = getattr(kernel, 'py_func', kernel)
    copy = types.FunctionType(kernel.__code__, {**kernel.__globals__, **names}, kernel.__name__)
    return jit_anew(copy)


@cache
def with_plugin(torques: Torques, *kernels: Any) -> tuple[Any, ...]:
    """
    Return the `kernels` of this module rebuilt around the `torques` of a plug-in effect.

    Compiled anew in each process, once; without a plug-in the cached ones stay as they are.
    """
    all_torques = rebuilt(_torques, plugged=torques)
    derivative = rebuilt(_derivative, _torques=all_torques)
    step = rebuilt(advance, _derivative=derivative)
    return tuple(rebuilt(kernel, _torques=all_torques, advance=step) for kernel in kernels)


@cache
def _sum(first: Torques, second: Torques, n: int) -> Torques:
    """Return the torques of two plug-ins together; the first has `n` parameters."""
    def torques(t: float, x1: float, x2: float, x3: float, x4: float, u: float, tau_k: float,
                theta: Array) -> Three:
        a, b, c = first(t, x1, x2, x3, x4, u, tau_k, theta[:n])
        d, e, f = second(t, x1, x2, x3, x4, u, tau_k, theta[n:])
        return a + d, b + e, c + f
    return jit_anew(torques)


def plugin_of(model: DriveModel) -> tuple[Effect | None, Array]:
    """Return (Effect or None, theta): the plug-in effect of `model`, several joined to one."""
    joined, theta = None, []
    for given in model.effects:
        if given['id'] in effects.EFFECTS:
            continue
        effect = effects.plugins()[given['id']]
        if joined is None:
            joined = effect
        else:
            joined = replace(joined, id=f'{joined.id}+{effect.id}',
                             torques=_sum(joined.torques, effect.torques, len(theta)))
        theta += [float(given[p.name]) for p in effect.parameters]
    return joined, np.array(theta, float)


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
        self._lagged = 0.0
        self.model = model

    @property
    def model(self) -> DriveModel:
        """The DriveModel in force."""
        return self._model

    @model.setter
    def model(self, model: DriveModel) -> None:
        plugin, self._theta = plugin_of(model)
        if plugin is None:
            self._kernel, self._plugin = _run, None
        elif plugin.id != getattr(self, '_plugin', None):
            self._kernel, self._plugin = with_plugin(plugin.torques, _run)[0], plugin.id
        self._model = model
        self._packed = model.pack()
        self._effects = effects.pack(model.effects)
        self._eigenvalue = fastest_eigenvalue(model)

    def run(self, u: Array, dt: float, t0: float = 0.0) -> Trajectory:
        """Apply u [N] (N m), one value per `dt` s, and return the Trajectory from `t0` s on."""
        u = np.ascontiguousarray(u, float)
        n = substeps(dt, self._eigenvalue)
        process = np.asarray(self.noise.process, float)
        shape = (len(u), n, 4)
        noise = self.process_random.standard_normal(shape) if process.any() else np.zeros(shape)
        first = t0 / dt  # counted in samples: then a run has the same times however it is cut
        first = round(first) if abs(first - round(first)) < 1e-6 else first
        t = (first + np.arange(len(u))) * dt
        x, tau, acting = np.empty((len(u), 4)), np.empty((len(u), 2)), np.empty((len(u), n))
        keep = math.ceil(MAX_DELAY / dt) + 2
        if len(self._past_u) != keep:
            self._past_u = np.zeros(keep)  # before the start there was no torque
        known = np.concatenate([self._past_u, u])
        self._lagged = actuator(known, keep, self._lagged, dt, n, self._effects, acting)
        self._past_u = known[-keep:]
        extra = np.zeros((len(u), 3))
        extra[:, ARM] = -arm_profile(self._model.effects, t, dt)
        self._kernel(self.state, t, acting, extra, dt, n, noise, process, self._packed,
                     self._effects, self._theta, x, tau)
        rows = np.concatenate([self._past_x, x])
        self._past_x = rows[-keep:]
        y = np.empty((len(u), 2))
        read_all(rows, len(rows) - len(u), dt, self._effects, y)
        y += self.measurement_random.standard_normal((len(u), 2)) * self.noise.measurement
        return Trajectory(t, u, quantised(y, self._model.effects), x, tau[:, 0], tau[:, 1])


@jit
def read_all(x: Array, begin: int, dt: float, e: Array, y: Array) -> None:
    """
    Fill y [N, 2] with what the encoders read, without noise, at x [begin:begin + N, 4].

    dt: s between rows; e: effects.pack.
    """
    for k in range(y.shape[0]):
        y[k, 0] = reading(x, begin + k, 0, dt, e)
        y[k, 1] = reading(x, begin + k, 1, dt, e)


def simulate(model: DriveModel, u: Array, dt: float, noise: Noise | None = None,
             seed: int = 0) -> Trajectory:
    """
    Return the Trajectory of the drive `model` from rest under u [N] (N m), `dt` s a sample.

    noise: Noise, None for none; seed: of that noise.
    """
    return Plant(model, noise, seed).run(u, dt)
