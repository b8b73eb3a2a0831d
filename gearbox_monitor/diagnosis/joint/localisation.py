# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Localisation: the place where a free signal explains the residual best, and when it acts.

The free signal is an arbitrary input at one place, estimated in each window.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import StateProblems, WindowRuns
from gearbox_monitor.kernels.linear_least_squares import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel

SPACING = 0.04      # s between the peaks of the triangles
ITERATIONS = 10
LEAST_GAIN = 1e-4   # of the cost of a window, for another iteration
# Many attempts: a contact of the gap that is lost makes long steps useless.
RULE = Damping(1e-6, 30.0, 1e-4, attempts=8, absolute=1e-9)
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
    covariance by sensor noise; chi2 [W] of the rest; freedom [W]: readings less the numbers that
    the signal and the states amount to, by what the readings say of them.
    """

    signal: Array
    precision: Array
    chi2: Array
    freedom: Array

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


class InputEstimator(StateProblems):
    """
    Windows of `runs` with a free signal at one place: theta [W, H + 4] is signal and states.

    count: number H of values of the signal.
    """

    def __init__(self, runs: WindowRuns, place: str) -> None:
        super().__init__(runs.data, runs.model, runs.memory)
        self.states = runs.states
        windows, dt = runs.data.windows, runs.recording.dt
        lead = int((windows.first - windows.begin).max(initial=0))
        self.basis = triangles(windows.length, lead, dt)
        self.count = self.basis.shape[1]
        values = runs.recording.torque
        if place in TORQUES:
            # Windows begin in their neighbours: each has a torque of its own.
            rows = windows.begin[:, None] + np.arange(len(self.basis))
            extra = self.data.simulator.extra
            self.extra = extra[np.minimum(rows, len(extra) - 1)]
            shift = (lead - windows.first + windows.begin)[:, None]
            self.at = np.minimum(np.arange(len(self.basis)) + shift, len(self.basis) - 1)
            self.torque = TORQUES.index(place)
        else:
            sensor, channels = SENSORS.index(place), runs.data.channels
            values = runs.recording.y[:, sensor]
            known = np.zeros((windows.length, len(channels), self.count))
            known[:, channels.index(sensor)] = runs.data.white(
                self.basis[None, lead:] / runs.data.sigma[sensor], [sensor])[0]
            self.known = known.reshape(-1, self.count)
        self.scale = max(float(np.std(values)), 1e-9)
        self.steps = np.concatenate([np.full(self.count, 1e-3 * self.scale), self.steps])
        self.gram = np.empty((len(windows), self.count + 4, self.count + 4))

    def residual(self, theta: Array, index: Integers) -> Array:
        """Return the residual [M, L, C] of the windows `index` [M] at `theta` [M, H + 4]."""
        signal, states = np.split(theta, [self.count], axis=1)
        if self.known is not None:
            residual = super().residual(states, index)
            return residual - (signal @ self.known.T).reshape(residual.shape)
        extra = self.extra[index]
        extra[:, :, self.torque] += np.take_along_axis(
            signal @ self.basis.T, self.at[index], axis=1)
        return self.data.residual(self.model, states, self.memory[index], index, extra)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        self.gram[index], pull = super().linearised(theta, residual, index)
        return self.gram[index], pull

    def solve(self) -> InputEstimate:
        """Return the InputEstimate, by Levenberg-Marquardt with a damping for each window."""
        windows, count = len(self.states), self.count
        ridge = np.zeros(count + 4)
        ridge[:count] = self.scale ** -2  # weak: for values that the readings say nothing of
        both, residual, _ = minimise(
            self, np.hstack([np.zeros((windows, count)), self.states]), RULE, LEAST_GAIN,
            RULE.attempts * ITERATIONS, ITERATIONS, np.tile(ridge, (windows, 1)))
        A = self.gram + np.diag(ridge)
        own, cross, inner = A[:, :count, :count], A[:, :count, count:], A[:, count:, count:]
        precision = own - np.diag(ridge[:count]) - cross @ np.linalg.solve(
            inner + 1e-9 * np.eye(4), cross.transpose(0, 2, 1))
        # What the ridge holds is no unknown.
        share = np.linalg.solve(precision + ridge[0] * np.eye(count), precision)
        freedom = residual.shape[1] - 4.0 - np.einsum('wii->w', share)
        return InputEstimate(both[:, :count], precision,
                             np.einsum('wl,wl->w', residual, residual), freedom)


def reduced_chi2(estimates: Sequence[InputEstimate]) -> float:
    """
    Return chi2 per reading that is left, geometric mean of windows: one stuck counts less.

    Args:
        estimates: of a free signal at one place, in each recording.
    """
    per_reading = np.concatenate([np.maximum(free.chi2 / free.freedom, 1e-300)
                                  for free in estimates])
    return float(np.exp(np.mean(np.log(per_reading))))


DECIDING = 10     # windows of a single recording that decide on a place
ILLUSTRATING = 6  # windows of each recording, if an effect names the place


def free_forms(runs: WindowRuns, places: Sequence[str]) -> dict[str, InputEstimate]:
    """
    Return {place: InputEstimate} on the windows of one recording, on top of free runs.

    Args:
        runs: of the model that lacks something.
        places: places of the free signals.
    """
    return {place: InputEstimator(runs, place).solve() for place in places}


def visible_places(runs: WindowRuns) -> tuple[str, ...]:
    """Return the places that drive and encoders of the recording of `runs` tell apart."""
    recording = runs.recording
    # A motion that is put in takes no offset; one encoder alone takes whatever is asked of it.
    sensors = SENSORS if recording.motor is None else SENSORS[1:]
    both = len(recording.channels) == 2
    if runs.model.transmission.kind != 'rigid':
        return (*TORQUES, *sensors) if both or recording.motor is not None else TORQUES
    # Any torque moves both sides alike.
    return ('motor_side', *sensors) if both else ('motor_side',)


NOWHERE: Mapping[str, Any] = {'place': 'none', 'location': 'none', 'places': {}}


def some_windows(runs: WindowRuns, most: int) -> WindowRuns:
    """
    Return at most so many windows of a recording, evenly spread.

    Where enough windows lack something, only they say where.

    Args:
        runs: of the model that lacks something.
        most: number of windows.
    """
    data = runs.data
    if len(data.windows) <= most:
        return runs
    lacking = np.flatnonzero(runs.chi2 > THRESHOLDS.quiet * data.size)
    if len(lacking) < most:
        lacking = np.arange(len(data.windows))
    return runs.take(lacking[np.linspace(0, len(lacking) - 1, most).round().astype(int)])


def places(runs: Sequence[WindowRuns], illustrates: bool = False) -> dict[str, Any]:
    """
    Return how much of the gap that `runs` leave a free signal at each place explains.

    {'place', 'location': the best, 'places': {place: {'left': chi2 per reading,
    'explained': share}}}. Effects of the actuator show as motor_side. What a recording cannot
    tell apart is what all recordings tell.

    Args:
        runs: without effects, of each recording.
        illustrates: whether the place is known otherwise: fewer windows do.
    """
    limit = ILLUSTRATING if illustrates else max(DECIDING // len(runs), ILLUSTRATING)
    runs = [some_windows(run, limit) for run in runs]
    visible = [place for place in PLACES if all(place in visible_places(run) for run in runs)]
    estimates = [free_forms(run, visible) for run in runs]
    chi2_before = sum(float(run.chi2.sum()) for run in runs)
    floor = sum(run.data.size * len(run.chi2) for run in runs)
    table = {}
    for place in visible:
        reduced = reduced_chi2([estimate[place] for estimate in estimates])
        share = (chi2_before - reduced * floor) / max(chi2_before - floor,
                                                      1e-9) if chi2_before > floor else 0.0
        table[place] = {'left': reduced, 'explained': float(np.clip(share, 0.0, 1.0))}
    order = sorted(table, key=lambda p: table[p]['left'])
    return {'place': order[0], 'location': order[0], 'places': table}
