# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Residuals of free runs over windows, and their sensitivity to the states where windows begin.

Residuals are in standard deviations of the encoder noise. Each window has four states of its own
(position and speed of motor and arm where it starts). In shapes W counts windows, L samples,
C encoders and P coordinates.
"""
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.noise_model import prewhitened
from gearbox_monitor.identification.shooting import ShootingWindows, Simulator
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.recording import UniformRecording


STATE_STEPS = np.array([1e-5, 1e-5, 1e-3, 1e-3])
WORST = 1e6  # standard deviations
UNSET: Any = None  # of a FitPoint that is not evaluated
Reduced: TypeAlias = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class FitPoint:
    """
    Where a fit stands: coordinates z [P], states [W, 4] and memory [W, 4] of the windows.

    residual [W, 2L] in standard deviations, chi2 [W] its square sum, carry [W, 8] the states where
    the next window begins.
    """

    z: Array
    states: Array
    memory: Array
    residual: Array = UNSET
    chi2: Array = UNSET
    carry: Array = UNSET


@dataclass(frozen=True, eq=False)
class WindowData:
    """
    Readings of `windows` in units of sigma [2], and how they count.

    train [W]: windows that may move the coordinates; colour [2]: see coloured_noise;
    fixed_states: whether the states where windows begin stay as they are.
    """

    recording: UniformRecording
    simulator: Simulator
    windows: ShootingWindows
    sigma: Array
    train: Flags
    colour: Array | None = None
    fixed_states: bool = False

    @cached_property
    def channels(self) -> list[int]:
        """Numbers of the encoders that are read."""
        return list(self.recording.channels)

    @cached_property
    def y(self) -> Array:
        """Readings of the windows [W, L, C], rad."""
        index = self.windows.first[:, None] + np.arange(self.windows.length)
        readings: Array = self.recording.y[index][:, :, self.channels]
        return readings

    @property
    def begins_known(self) -> bool:
        """Whether no state of a window is fitted."""
        return self.fixed_states or self.simulator.begins_known

    @property
    def size(self) -> int:
        """Number of readings in a window: L samples of C encoders."""
        return self.windows.length * len(self.channels)

    def parted(self, residual: Array) -> Array:
        """Return `residual` [W, C L] as [W, L, C]."""
        return residual.reshape(len(residual), self.windows.length, len(self.channels))

    def residual(self, model: DriveModel, states: Array, memory: Array,
                 index: Integers | None = None, extra: Array | None = None) -> tuple[Array, Array]:
        """
        Return (residual [W, 2L], carry [W, 8]) of the windows `index` (default: all).

        Args:
            model: model of the drive.
            states: states of the drive where the windows start [W, 4].
            memory: memories of the effects where the windows start [W, 4].
            index: numbers of the windows [M]; repeats are allowed.
            extra: external torques on motor, arm and transmission, N m, [N, 3] of the recording or
                [W, R, 3] of each window, from where its run begins.
        """
        windows = self.windows if index is None else self.windows.take(index)
        y, carry = self.simulator.run(windows, model, states, memory, extra)
        measured = self.y if index is None else self.y[index]
        r: Array = (measured - y[:, :, self.channels]) / self.sigma[self.channels]
        # A run that diverges is as bad as can be, and still a number.
        r = self.white(np.clip(np.nan_to_num(r, nan=WORST), -WORST, WORST), self.channels)
        return r.reshape(len(y), -1), carry

    def positions(self, model: DriveModel, point: 'FitPoint') -> Array:
        """
        Return positions of motor and arm [N, 2], rad: as measured, else as `model` has them.

        Args:
            model: model of the drive.
            point: where its windows begin.
        """
        positions = self.recording.positions.copy()
        hidden = [i for i in (0, 1) if i not in self.channels]
        if hidden and self.recording.motor is None:
            y, _ = self.simulator.run(self.windows, model, point.states, point.memory)
            for first, rows in zip(self.windows.first, y):
                positions[first:first + len(rows), hidden] = rows[:, hidden]
        return positions

    def white(self, residual: Array, channels: list[int]) -> Array:
        """Return `residual` [W, L, C], in sigmas of the encoders `channels`, with white noise."""
        return residual if self.colour is None else prewhitened(residual, self.colour[channels])

    def uncoloured(self) -> 'WindowData':
        """Return the WindowData whose residuals are the distances of the readings, in sigmas."""
        return replace(self, colour=None)

    def evaluate(self, candidate: CandidateModel, point: FitPoint) -> FitPoint:
        """
        Return `point` with its residual, chi2 and carry.

        Args:
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands: coordinates, window states and memories.
        """
        residual, carry = self.residual(candidate.model(point.z), point.states, point.memory)
        return replace(point, residual=residual, chi2=squares(residual), carry=carry)

    def raw_states(self) -> Array:
        """Return states [W, 4] where the windows begin, from straight lines through readings."""
        y, dt, n = self.recording.y, self.recording.dt, len(self.recording.y)
        half = max(2, round(0.006 / dt))
        states = np.empty((len(self.windows), 4))
        for w, k in enumerate(self.windows.begin):
            low, high = max(0, k - half), min(n, k + half + 1)
            t = (np.arange(low, high) - k) * dt
            line = np.polyfit(t, y[low:high], 2 if high - low > 4 else 1)
            states[w, :2], states[w, 2:] = line[-1], line[-2]
        return states


def updated(array: Array, index: Integers | Flags, values: Array) -> Array:
    """
    Return a copy of `array` with other values in some windows.

    Args:
        array: a row for each window [W, ...].
        index: numbers [M] or mask [W] of the windows.
        values: their rows [M, ...].
    """
    out = array.copy()
    out[index] = values
    return out


def squares(residual: Array) -> Array:
    """Return chi2 [W], the square sums of a residual [W, 2L]."""
    return np.einsum('wl,wl->w', residual, residual)


def carried(memory: Array, carry: Array) -> Array:
    """
    Return memory [W, 4] with that of each window's predecessor.

    Args:
        memory: memories of the effects where the windows start [W, 4].
        carry: states where the next window starts [W, 8].
    """
    moved = memory.copy()
    moved[1:] = carry[:-1, 4:]
    return moved


def state_sensitivity(data: WindowData, model: DriveModel, states: Array, memory: Array,
                      residual: Array, index: Integers | None = None) -> Array:
    """
    Return d(-residual)/d(states) [W, 2L, 4].

    Args:
        data: windows of readings and how residuals are weighted.
        model: model of the drive.
        states: states of the drive where the windows start [W, 4].
        memory: memories of the effects where the windows start [W, 4].
        residual: residual of the windows [W, C L], in standard deviations of the encoder noise.
        index: numbers of the windows [M]; repeats are allowed.
    """
    if data.begins_known:
        return np.zeros((*residual.shape, 4))
    index = np.arange(len(states)) if index is None else index
    # All in one call: the more windows side by side, the faster.
    moved = (states + np.diag(STATE_STEPS)[:, None]).reshape(-1, 4)
    r, _ = data.residual(model, moved, np.tile(memory, (4, 1)), np.tile(index, 4))
    change = residual - r.reshape(4, *residual.shape)
    return np.moveaxis(change / STATE_STEPS[:, None, None], 0, -1)


def shortened(data: WindowData, share: float) -> WindowData:
    """
    Return WindowData of the first `share` of each window.

    Args:
        data: windows of readings and how residuals are weighted.
        share: share of each window.
    """
    if share == 1.0:
        return data
    w = data.windows
    length = max(round(share * w.length), 8)
    return replace(data, windows=ShootingWindows(w.first, length, w.begin, w.first + length))
