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
Free-form input estimation: an arbitrary signal at one place, fitted in each window.

The signal is piecewise linear (triangles of 40 ms): a torque on the motor, on the arm or in the
transmission, or an offset of one encoder.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.identification import likelihood
from gearbox_monitor.identification.shooting import ShootingWindows
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel

SPACING = 0.04      # s between the peaks of the triangles
QUARTERS = 4        # short windows in a long one
ITERATIONS = 4
TORQUES = ('motor_side', 'arm_side', 'transmission')   # in the order of Simulator.run's extra
SENSORS = ('motor_sensor', 'arm_sensor')
PLACES = (*TORQUES, *SENSORS)


def torque_places(model: DriveModel) -> tuple[str, ...]:
    """Return the places at which a torque can act in a drive."""
    # In a rigid drive any torque moves both sides alike.
    return TORQUES if model.transmission.kind != 'rigid' else TORQUES[:1]


@dataclass(frozen=True, eq=False)
class InputEstimate:
    """
    A free signal at one place, fitted to all windows.

    signal [W, H] N m or rad at the peaks of the triangles, precision [W, H, H] its inverse
    covariance by sensor noise; residual [W, 2L] and chi2 [W] of the rest; unknowns [W]: how
    many numbers it and the window states [W, 4] amount to, by what the readings say of them.
    """

    place: str
    signal: Array
    precision: Array
    residual: Array
    chi2: Array
    unknowns: Array
    states: Array

    @property
    def evidence(self) -> Array:
        """Gain in chi2 that each value of the signal brings [W, H]; 1 on average by noise."""
        return self.signal * np.einsum('wij,wj->wi', self.precision, self.signal)


def triangles(length: int, lead: int, dt: float) -> Array:
    """
    Return the basis [lead + length, H]; before the window's first sample the first one holds.

    Rows sum to 1: linear interpolation between values SPACING s apart.

    Args:
        length: samples of a window.
        lead: samples that a run starts before its window.
        dt: sample time, s.
    """
    count = math.ceil((length - 1) * dt / SPACING - 1e-9) + 1
    at = np.clip((np.arange(lead + length) - lead) * dt, 0.0, None)
    at = np.minimum(at / SPACING, count - 1.0)
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(count)))


def _gram(J: Array) -> Array:
    """Return J'J [W, C, C] of J [W, M, C]."""
    count, rows, columns = J.shape
    # Small products: for large ones BLAS starts threads, which wait for each other on a busy
    # computer.
    size = max(1, 200000 // columns ** 2)
    out = np.zeros((count, columns, columns))
    for k in range(0, rows, size):
        part = J[:, k:k + size]
        out += part.transpose(0, 2, 1) @ part
    return out


class InputEstimator:
    """Windows with a free signal at one place."""

    def __init__(self, data: likelihood.WindowData, model: DriveModel, place: str,
                 start: likelihood.FitPoint) -> None:
        self.data, self.model, self.place = data.plain(), model, place
        data = self.data
        self.memory = start.memory
        windows = data.windows
        self.lead = int((windows.first - windows.begin).max(initial=0))
        self.basis = triangles(windows.length, self.lead, data.recording.dt)
        self.torque = place in TORQUES
        # Windows begin in their neighbours: even and odd ones take turns.
        self.turns = [np.arange(k, len(windows), 2) for k in (0, 1) if k < len(windows)]
        if self.torque:
            self.scale = max(float(np.std(data.recording.torque)), 1e-9)
        else:
            self.scale = max(float(np.std(data.recording.y[:, SENSORS.index(place)])), 1e-9)

    def residual(self, signal: Array, states: Array) -> Array:
        """
        Return the residual [W, 2L] with signal [W, H] at the place.

        Args:
            signal: free signal [W, H] at the peaks of the triangles, N m or rad.
            states: states of the drive where the windows start [W, 4].
        """
        data, windows = self.data, self.data.windows
        if not self.torque:
            out, _ = data.residual(self.model, states, self.memory)
            sensor = SENSORS.index(self.place)
            offset = (signal @ self.basis[self.lead:].T / data.sigma[sensor])[:, :, None]
            out[:, data.channels.index(sensor)::len(data.channels)] -= data.white(
                offset, [sensor])[:, :, 0]
            return out
        out = np.empty((len(windows), data.size))
        column = TORQUES.index(self.place)
        torque = np.einsum('wh,lh->wl', signal, self.basis)
        for turn in self.turns:
            extra = data.simulator.extra.copy()
            for w in turn:
                rows = slice(windows.begin[w], windows.first[w] + windows.length)
                extra[rows, column] += torque[w, self.lead - windows.first[w] + windows.begin[w]:]
            out[turn], _ = data.residual(
                self.model, states[turn], self.memory[turn], turn, extra)
        return out

    def sensitivity(self, signal: Array, states: Array, residual: Array) -> Array:
        """
        Return d(-residual)/d(signal, states) [W, 2L, H + 4].

        Args:
            signal: free signal [W, H] at the peaks of the triangles, N m or rad.
            states: states of the drive where the windows start [W, 4].
            residual: residual of the windows [W, C L].
        """
        count = self.basis.shape[1]
        J = np.empty((*residual.shape, count + 4))
        if self.torque:
            step = 1e-3 * self.scale
            for k in range(count):
                moved = signal.copy()
                moved[:, k] += step
                J[:, :, k] = (residual - self.residual(moved, states)) / step
        else:
            J[:, :, :count] = 0.0
            sensor, channels = SENSORS.index(self.place), self.data.channels
            J[:, channels.index(sensor)::len(channels), :count] = self.data.white(
                self.basis[None, self.lead:] / self.data.sigma[sensor], [sensor])
        for i, step in enumerate(likelihood.STATE_STEPS):
            moved = states.copy()
            moved[:, i] += step
            J[:, :, count + i] = (residual - self.residual(signal, moved)) / step
        return J

    def solve(self, states: Array, signal: Array | None = None, iterations: int = ITERATIONS,
              fixed: Flags | None = None) -> InputEstimate:
        """
        Return the InputEstimate, by Levenberg-Marquardt with a damping for each window.

        Args:
            states: states of the drive where the windows start [W, 4].
            signal: free signal [W, H] at the peaks of the triangles, N m or rad.
            iterations: largest number of iterations.
            fixed: values of the signal [W, H] that stay as they are.
        """
        count = self.basis.shape[1]
        states = states.copy()
        signal = np.zeros((len(states), count)) if signal is None else signal.copy()
        ridge = np.zeros(count + 4)
        ridge[:count] = self.scale ** -2  # weak: for values that the readings say nothing of
        residual = self.residual(signal, states)

        def cost(signal: Array, residual: Array) -> Array:
            """Return chi2 of `residual` and the ridge on `signal` in each window."""
            return (np.einsum('wl,wl->w', residual, residual)
                    + ridge[0] * np.einsum('wh,wh->w', signal, signal))
        cost_now = cost(signal, residual)
        damping = np.full(len(states), 1e-6)
        stale = True
        for _ in range(iterations):
            if stale:
                J = self.sensitivity(signal, states, residual)
                if fixed is not None:
                    J[:, :, :count] *= ~fixed[:, None, :]
                A = _gram(J)
                diagonal = np.einsum('wii->wi', A)
                A = A + np.diag(ridge)
            g = np.einsum('wl,wlj->wj', residual, J)
            g[:, :count] -= ridge[0] * signal if fixed is None else ridge[0] * signal * ~fixed
            gain = np.zeros(len(states))
            for _ in range(4):
                damped = A.copy()
                damped[:, range(count + 4), range(count + 4)] += (
                    damping[:, None] * diagonal + 1e-9)
                step = np.linalg.solve(damped, g[:, :, None])[:, :, 0]
                moved, at = signal + step[:, :count], states + step[:, count:]
                trial = self.residual(moved, at)
                trial_cost = cost(moved, trial)
                improved = trial_cost < cost_now
                gain = np.where(improved, gain + cost_now - trial_cost, gain)
                signal[improved], states[improved] = moved[improved], at[improved]
                residual[improved], cost_now[improved] = trial[improved], trial_cost[improved]
                damping = np.where(improved, 0.1 * damping, np.maximum(30.0 * damping, 1e-4))
                if improved.mean() > 0.7:
                    break
                g = np.where(improved[:, None], 0.0, g)  # those are done until the next J
            if gain.sum() < 1e-3 * cost_now.sum():
                break
        own, cross, inner = A[:, :count, :count], A[:, :count, count:], A[:, count:, count:]
        precision = own - np.diag(ridge[:count]) - cross @ np.linalg.solve(
            inner + 1e-9 * np.eye(4), cross.transpose(0, 2, 1))
        # What the ridge holds is no unknown.
        share = np.linalg.solve(precision + ridge[0] * np.eye(count), precision)
        unknowns = 4.0 + np.einsum('wii->w', share)
        return InputEstimate(self.place, signal, precision, residual,
                             np.einsum('wl,wl->w', residual, residual), unknowns, states)


def taken_over(windows: ShootingWindows, states: Array, targets: ShootingWindows,
               fallback: Array) -> Array:
    """
    Return states [W, 4] of the windows `targets`: of `windows` that begin there, else `fallback`.

    Args:
        windows: windows whose states are taken over.
        states: states of the drive where they start [V, 4].
        targets: windows that receive states.
        fallback: states of the drive where these start [W, 4].
    """
    at = {int(b): w for w, b in enumerate(windows.begin)}
    return np.array([states[at[int(begin)]] if int(begin) in at else own
                     for begin, own in zip(targets.begin, fallback)])


def reduced_chi2(estimates: Sequence[InputEstimate]) -> float:
    """
    Return chi2 per reading that is left, geometric mean of windows: one stuck counts less.

    Args:
        estimates: of a free signal at one place, in each recording.
    """
    per_reading = np.concatenate([
        np.maximum(free.chi2 / (free.residual.shape[1] - free.unknowns), 1e-300)
        for free in estimates])
    return float(np.exp(np.mean(np.log(per_reading))))


def better_of(first: InputEstimate, second: InputEstimate) -> InputEstimate:
    """
    Return an InputEstimate with the better of two in each window.

    Args:
        first: first estimate.
        second: second estimate.
    """
    use_second = first.chi2 / (first.residual.shape[1] - first.unknowns) > (
        second.chi2 / (second.residual.shape[1] - second.unknowns))
    arrays = {name: likelihood.updated(getattr(first, name), use_second,
                                       getattr(second, name)[use_second])
              for name in ('signal', 'precision', 'residual', 'chi2', 'unknowns', 'states')}
    return InputEstimate(first.place, **arrays)
