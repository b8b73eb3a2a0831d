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

"""Simulate the drive: RK4 with zero-order-hold torque, seeded process and measurement noise."""
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.drive.model import (
    arm_acceleration, arm_load, fastest_eigenvalue, HALF_GAP, K_S, KIND, motor_acceleration,
    STIFFNESS, substeps, WIDTH)
from gearbox_monitor.drive.transmission import transmission_torque
from gearbox_monitor.jit import jit

# State of the plant: x1 x2 x3 x4 and the memory of the transmission.
N_STATE = 5


@dataclass(frozen=True)
class Noise:
    """
    Standard deviations of the plant's noise.

    process: of each state per square root of a second, [4], in rad/sqrt(s), rad/s/sqrt(s).
    measurement: of each encoder, [2], rad.
    """

    process: tuple = (0.0, 0.0, 0.0, 0.0)
    measurement: tuple = (0.0, 0.0)


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


@jit
def _derivative(x1, x2, x3, x4, u, memory, p):
    tau_k, _ = transmission_torque(
        x1 - x2, memory, int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH], p[K_S])
    return (x3, x4, motor_acceleration(x1, x3, x4, u, tau_k, p),
            arm_acceleration(x3, x4, tau_k, arm_load(x2, x4, p), p))


@jit
def advance(state, u, dt, n, noise, process_std, p):
    """
    Advance `state` [5] in place by `dt` s in `n` RK4 substeps under the torque `u` (N m).

    noise: standard normal numbers [n, 4]; process_std [4] per square root of a second.
    The memory of the transmission is updated once per substep, and clamped in every stage.
    """
    h = dt / n
    root_h = math.sqrt(h)
    x1, x2, x3, x4, w = state[0], state[1], state[2], state[3], state[4]
    for i in range(n):
        a1, a2, a3, a4 = _derivative(x1, x2, x3, x4, u, w, p)
        b1, b2, b3, b4 = _derivative(
            x1 + 0.5 * h * a1, x2 + 0.5 * h * a2, x3 + 0.5 * h * a3, x4 + 0.5 * h * a4, u, w, p)
        c1, c2, c3, c4 = _derivative(
            x1 + 0.5 * h * b1, x2 + 0.5 * h * b2, x3 + 0.5 * h * b3, x4 + 0.5 * h * b4, u, w, p)
        d1, d2, d3, d4 = _derivative(
            x1 + h * c1, x2 + h * c2, x3 + h * c3, x4 + h * c4, u, w, p)
        x1 += h / 6.0 * (a1 + 2.0 * b1 + 2.0 * c1 + d1) + root_h * process_std[0] * noise[i, 0]
        x2 += h / 6.0 * (a2 + 2.0 * b2 + 2.0 * c2 + d2) + root_h * process_std[1] * noise[i, 1]
        x3 += h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3) + root_h * process_std[2] * noise[i, 2]
        x4 += h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4) + root_h * process_std[3] * noise[i, 3]
        _, w = transmission_torque(
            x1 - x2, w, int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH], p[K_S])
    state[0], state[1], state[2], state[3], state[4] = x1, x2, x3, x4, w


@jit
def true_torques(state, p):
    """Return (tau_k, tau_arm) in N m at `state` [5]."""
    tau_k, _ = transmission_torque(
        state[0] - state[1], state[4], int(p[KIND]), p[STIFFNESS], p[HALF_GAP], p[WIDTH], p[K_S])
    return tau_k, arm_load(state[1], state[3], p)


@jit
def _run(state, u, dt, n, noise, process_std, p, x, tau):
    for k in range(u.shape[0]):
        for i in range(4):
            x[k, i] = state[i]
        tau[k, 0], tau[k, 1] = true_torques(state, p)
        advance(state, u[k], dt, n, noise[k], process_std, p)


class Plant:
    """A simulated drive that keeps its state between calls; `model` may be replaced meanwhile."""

    def __init__(self, model, noise=None, seed=0, state=None):
        self.noise = noise or Noise()
        # One generator each: then the numbers do not depend on how a run is cut into calls.
        self.process_random, self.measurement_random = (
            np.random.default_rng(sequence) for sequence in np.random.SeedSequence(seed).spawn(2))
        self.state = np.zeros(N_STATE) if state is None else np.array(state, float)
        self.model = model

    @property
    def model(self):
        """The DriveModel in force."""
        return self._model

    @model.setter
    def model(self, model):
        self._model = model
        self._packed = model.pack()
        self._eigenvalue = fastest_eigenvalue(model)

    def run(self, u, dt, t0=0.0):
        """Apply u [N] (N m), one value per `dt` s, and return the Trajectory from `t0` s on."""
        u = np.ascontiguousarray(u, float)
        n = substeps(dt, self._eigenvalue)
        process = np.asarray(self.noise.process, float)
        shape = (len(u), n, 4)
        noise = self.process_random.standard_normal(shape) if process.any() else np.zeros(shape)
        x, tau = np.empty((len(u), 4)), np.empty((len(u), 2))
        _run(self.state, u, dt, n, noise, process, self._packed, x, tau)
        y = x[:, :2] + (self.measurement_random.standard_normal((len(u), 2))
                        * self.noise.measurement)
        return Trajectory(t0 + dt * np.arange(len(u)), u, y, x, tau[:, 0], tau[:, 1])


def simulate(model, u, dt, noise=None, seed=0):
    """Return the Trajectory of the drive `model` from rest under u [N] (N m), `dt` s a sample."""
    return Plant(model, noise, seed).run(u, dt)
