# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free-form input estimation: an arbitrary signal at one place, fitted in each window.

The signal is piecewise linear (triangles of 40 ms): a torque on the motor, on the arm or in the
transmission, or an offset of one encoder.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.identification import window_data
from gearbox_monitor.identification.shooting import ShootingWindows
from gearbox_monitor.kernels.levenberg_marquardt import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel

SPACING = 0.04      # s between the peaks of the triangles
QUARTERS = 4        # short windows in a long one
ITERATIONS = 4
LEAST_GAIN = 1e-3   # of the cost of a window, for another iteration
RULE = Damping(1e-6, 30.0, 1e-4, attempts=4, absolute=1e-9)
SIDE_BY_SIDE = 64   # runs, which bounds the memory
TORQUES = ('motor_side', 'arm_side', 'transmission')   # in the order of Simulator.run's extra
SENSORS = ('motor_sensor', 'arm_sensor')
PLACES = (*TORQUES, *SENSORS)


def torque_places(model: DriveModel) -> tuple[str, ...]:
    """Return the places at which a torque can act in the drive of `model`."""
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

    def __init__(self, data: window_data.WindowData, model: DriveModel, place: str,
                 start: window_data.FitPoint) -> None:
        self.data, self.model, self.place = data, model, place
        self.memory = start.memory
        windows = data.windows
        self.lead = int((windows.first - windows.begin).max(initial=0))
        self.basis = triangles(windows.length, self.lead, data.recording.dt)
        self.torque = place in TORQUES
        if self.torque:
            # Windows begin in their neighbours: each has a torque of its own.
            rows = windows.begin[:, None] + np.arange(len(self.basis))
            extra = data.simulator.extra
            self.extra = extra[np.minimum(rows, len(extra) - 1)]
            shift = (self.lead - windows.first + windows.begin)[:, None]
            self.at = np.minimum(np.arange(len(self.basis)) + shift, len(self.basis) - 1)
            self.scale = max(float(np.std(data.recording.torque)), 1e-9)
        else:
            self.scale = max(float(np.std(data.recording.y[:, SENSORS.index(place)])), 1e-9)

    def residual(self, signal: Array, states: Array, index: Integers | None = None) -> Array:
        """
        Return the residual [M, 2L] with a signal at the place.

        Args:
            signal: free signal [M, H] at the peaks of the triangles, N m or rad.
            states: states of the drive where the windows start [M, 4].
            index: numbers of the windows [M], with repeats; None: each once.
        """
        data = self.data
        if index is None:
            index = np.arange(len(data.windows))
        if not self.torque:
            out, _ = data.residual(self.model, states, self.memory[index], index)
            sensor = SENSORS.index(self.place)
            offset = (signal @ self.basis[self.lead:].T / data.sigma[sensor])[:, :, None]
            out[:, data.channels.index(sensor)::len(data.channels)] -= data.white(
                offset, [sensor])[:, :, 0]
            return out
        extra = self.extra[index]
        extra[:, :, TORQUES.index(self.place)] += np.take_along_axis(
            signal @ self.basis.T, self.at[index], axis=1)
        return data.residual(self.model, states, self.memory[index], index, extra)[0]

    def sensitivity(self, signal: Array, states: Array, residual: Array,
                    index: Integers | None = None) -> Array:
        """
        Return d(-residual)/d(signal, states) [M, 2L, H + 4].

        Args:
            signal: free signal [M, H] at the peaks of the triangles, N m or rad.
            states: states of the drive where the windows start [M, 4].
            residual: residual of the windows [M, C L].
            index: numbers of the windows [M]; None: each once.
        """
        if index is None:
            index = np.arange(len(states))
        count = self.basis.shape[1]
        J = np.zeros((*residual.shape, count + 4))
        steps = np.array([1e-3 * self.scale] * count + [*window_data.STATE_STEPS])
        columns = np.arange(0 if self.torque else count, count + 4)
        if not self.torque:
            sensor, channels = SENSORS.index(self.place), self.data.channels
            J[:, channels.index(sensor)::len(channels), :count] = self.data.white(
                self.basis[None, self.lead:] / self.data.sigma[sensor], [sensor])
        # Runs of several columns side by side: lanes cost little more than one run.
        side_by_side = max(1, SIDE_BY_SIDE // len(index))
        for part in np.split(columns, range(side_by_side, len(columns), side_by_side)):
            moved = np.zeros((len(part), 1, count + 4))
            moved[np.arange(len(part)), 0, part] = steps[part]
            moved = (np.hstack([signal, states]) + moved).reshape(-1, count + 4)
            run = self.residual(moved[:, :count], moved[:, count:], np.tile(index, len(part)))
            J[:, :, part] = ((residual - run.reshape(len(part), *residual.shape))
                             / steps[part, None, None]).transpose(1, 2, 0)
        return J

    def solve(self, states: Array, signal: Array | None = None, iterations: int = ITERATIONS
              ) -> InputEstimate:
        """
        Return the InputEstimate, by Levenberg-Marquardt with a damping for each window.

        Args:
            states: states of the drive where the windows start [W, 4].
            signal: free signal [W, H] at the peaks of the triangles, N m or rad.
            iterations: largest number of iterations.
        """
        windows, count = len(states), self.basis.shape[1]
        both = np.hstack([np.zeros((windows, count)) if signal is None else signal, states])
        ridge = np.zeros(count + 4)
        ridge[:count] = self.scale ** -2  # weak: for values that the readings say nothing of
        gram = np.empty((windows, count + 4, count + 4))
        problems = _Inputs(self, gram)
        both, residual, _ = minimise(problems, both, RULE, LEAST_GAIN, RULE.attempts * iterations,
                                     iterations, np.tile(ridge, (windows, 1)))
        A = gram + np.diag(ridge)
        own, cross, inner = A[:, :count, :count], A[:, :count, count:], A[:, count:, count:]
        precision = own - np.diag(ridge[:count]) - cross @ np.linalg.solve(
            inner + 1e-9 * np.eye(4), cross.transpose(0, 2, 1))
        # What the ridge holds is no unknown.
        share = np.linalg.solve(precision + ridge[0] * np.eye(count), precision)
        unknowns = 4.0 + np.einsum('wii->w', share)
        return InputEstimate(self.place, both[:, :count], precision, residual,
                             window_data.squares(residual), unknowns, both[:, count:])


@dataclass(frozen=True, eq=False)
class _Inputs:
    """Signal and states of windows as problems; gram [W, P, P]: written."""

    estimator: InputEstimator
    gram: Array

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta` of the problems `index`."""
        residual = self.estimator.residual(theta[:, :-4], theta[:, -4:], index)
        return residual, window_data.squares(residual)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        J = self.estimator.sensitivity(theta[:, :-4], theta[:, -4:], residual, index)
        self.gram[index] = _gram(J)
        return self.gram[index], np.einsum('wl,wlj->wj', residual, J)


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
    arrays = {name: window_data.updated(getattr(first, name), use_second,
                                       getattr(second, name)[use_second])
              for name in ('signal', 'precision', 'residual', 'chi2', 'unknowns', 'states')}
    return InputEstimate(first.place, **arrays)
