# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free runs of the drive over the windows of a recording: what every part of the diagnosis rests on.

Each window starts from states of its own (motor and arm position and speed); memories (hysteresis,
bristle) go over from window to window.
"""
from copy import copy
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant import batch
from gearbox_monitor.plant.batch import Begin, Driving, RunResult, RunSpans
from gearbox_monitor.plant.drive import DriveModel, fastest_eigenvalue, steps_of
from gearbox_monitor.plant.effects import MAX_DELAY, MAX_SETPOINT_DELAY
from gearbox_monitor.plant.effects.composition import (
    actuator, COMMAND_PLACES, lead, steady_command)
from gearbox_monitor.plant.simulate import N_STATE, packed_drive, plugin_of
from gearbox_monitor.signals.uniform import UniformRecording

N_MEMORY = N_STATE - 4
# Accuracy, not stability, sets the step: h lambda <= 1.2 keeps free runs of 1 s within 0.01 sigma.
STEP_EIGENVALUE = 1.2
COARSE_EIGENVALUE = 2.0  # for finding a place to start from


@dataclass(frozen=True)
class ShootingWindows:
    """
    Windows of one length in a recording.

    first [W]: first sample of each; length: samples; begin [W]: where its run starts, a little
    earlier, so that delayed readings have a past.
    """

    first: Integers
    length: int
    begin: Integers

    def __len__(self) -> int:
        return len(self.first)

    @property
    def samples(self) -> Integers:
        """Numbers of the samples [W, L]."""
        return np.asarray(self.first[:, None] + np.arange(self.length))

    def take(self, index: Integers) -> 'ShootingWindows':
        """Return the windows `index` (with repeats, in any order)."""
        return ShootingWindows(self.first[index], self.length, self.begin[index])


def shooting_windows(recording: UniformRecording, seconds: float,
                     settling: float = 0.0) -> ShootingWindows:
    """
    Return the windows of a recording.

    Args:
        recording: recording of the drive.
        seconds: length of a window, s; a little less where that makes room for `settling`.
        settling: s at the beginning that no window reads.
    """
    dt = recording.dt
    length, lead, skip = round(seconds / dt), math.ceil(MAX_DELAY / dt), math.ceil(settling / dt)
    count = len(recording.u) // length
    if count:
        length = min(length, (len(recording.u) - skip) // count)
    first = skip + np.arange(count) * length
    return ShootingWindows(first, length, np.maximum(0, first - lead))


def between_stamps(recording: UniformRecording, parts: int) -> Array:
    """
    Return the mean torque [N parts] in each part of each sample, N m.

    Args:
        recording: its torque is held, or with a shift sampled: then it is what is interpolated.
        parts: of a sample, of equal length.
    """
    if recording.shift is None:
        return np.repeat(np.ascontiguousarray(recording.u, float), parts)
    u = recording.u
    at = np.arange(len(u))
    ends = np.clip(np.arange(len(u) * parts + 1) / parts - recording.shift, 0.0, at[-1])
    # Outside of the stamps the first and the last torque act.
    total = scipy.interpolate.Akima1DInterpolator(at, u).antiderivative()(ends)
    beyond = np.arange(len(ends)) / parts - recording.shift - ends
    return np.asarray(parts * np.diff(total + np.where(beyond < 0.0, u[0], u[-1]) * beyond))


class Simulator:
    """
    Free runs over a Recording for any model.

    u [N] N m, dt s. extra: torques (N m) [N, 3] from outside on motor, arm, in the transmission.
    coarse: with larger steps; finer: with so many times as many.
    """

    begins_known = False  # whether states where windows begin are those of the readings

    def __init__(self, recording: UniformRecording, model: DriveModel, coarse: bool = False,
                 finer: int = 1) -> None:
        self.u, self.dt = np.ascontiguousarray(recording.u), recording.dt
        # One number of steps for all candidates: otherwise a difference in accuracy is evidence.
        eigenvalue = fastest_eigenvalue(model)
        self.n = finer * max(1, math.ceil(self.dt * eigenvalue / (
            COARSE_EIGENVALUE if coarse else STEP_EIGENVALUE)))
        if model.timestep:
            own = steps_of(model, self.dt, eigenvalue)
            # Short steps of the Runge-Kutta method do what longer ones do.
            self.n = min(self.n, own) if model.integrator == 'rk4' else own
        self.extra = np.zeros((len(self.u), 3))
        if recording.arm_torque is not None:
            self.extra[:, 1] = -recording.arm_torque
        self._keep = math.ceil(MAX_SETPOINT_DELAY / self.dt) + 2
        # A torque that changes within a sample is held for a step of it.
        self._parts = 1 if recording.shift is None else self.n
        u, past = between_stamps(recording, self._parts), self._keep * self._parts
        self._padded = np.concatenate([np.full(past, u[0]), u])
        self._acting: dict[Any, Array] = {}

    def loaded(self, torque: Array) -> 'Simulator':
        """Return the simulator with more `torque` [N], N m, on the arm."""
        out = copy(self)
        out.extra = self.extra + torque[:, None] * (0.0, 1.0, 0.0)
        return out

    def acting(self, e: Array) -> Array:
        """Return the torque of the actuator [N, n] for packed effects `e`."""
        key = tuple(e[COMMAND_PLACES])
        torque = self._acting.get(key)
        if torque is None:
            substep = self.dt / self._parts
            torque = np.empty((len(self.u) * self._parts, self.n // self._parts))
            u = self._padded.copy()
            lead(u, np.array([u[0], u[0], 0.0]), substep, e)
            actuator(u, self._keep * self._parts, steady_command(self.u[0], e), substep, e, torque)
            torque = torque.reshape(len(self.u), self.n)
            if len(self._acting) > 4:
                self._acting.clear()
            self._acting[key] = torque
        return torque

    def run(self, windows: ShootingWindows, model: DriveModel, states: Array, memory: Array,
            extra: Array | None = None) -> tuple[Array, Array]:
        """
        Return (y [W, L, 2], states [W, 8]): readings, and states and memories at the end.

        states [W, 4], memory [W, 4]: where each window begins.

        Args:
            windows: windows to simulate.
            model: model of the drive.
            states: states of the drive where the windows start [W, 4].
            memory: memories of the effects where the windows start [W, 4].
            extra: external torques on motor, arm and transmission, N m, [N, 3] of the recording or
                [W, R, 3] of each window, from where its run begins.
        """
        e, w, length = model.pack_effects(), len(windows), windows.length
        extra = self.extra if extra is None else extra
        extra_at = windows.begin if extra.ndim == 2 else np.arange(w) * extra.shape[1]
        plugin, _ = plugin_of(model)
        if model.transmission.kind == 'rigid':
            states = states[:, [0, 0, 2, 2]]
        result = RunResult(np.empty((w, length, 2)), np.empty((w, N_STATE)))
        spans = RunSpans(windows.begin, windows.first, length, windows.first + length, extra_at)
        start = Begin(*map(np.ascontiguousarray, (states, memory)))
        driving = Driving(self.acting(e), extra.reshape(-1, 3), self.dt)
        kernel = batch.runs if plugin is None else batch.runs_with_plugin(plugin.torques)
        kernel(spans, start, driving, packed_drive(model, e), np.empty(batch.N_LANE_STATE),
               np.empty((batch.LANES, length + self._keep, 4)), result)
        return result.y, result.carry
