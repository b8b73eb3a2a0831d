# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
One recording, cut into windows of 1 s, and the residuals of runs over them.

Residuals are in standard deviations of the encoder noise. Each window has four states of its own
(position and speed of motor and arm where it starts). In shapes W counts windows, L samples and C
encoders.
"""
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gearbox_monitor.diagnosis.joint.noise_model import prewhitened
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, ShootingWindows, Simulator
from gearbox_monitor.diagnosis.joint.torque_domain import simulator
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MAX_SETPOINT_DELAY
from gearbox_monitor.signals.recording import UniformRecording

WORST = 1e6    # standard deviations
SECONDS = 1.0  # of a window
# s, after which what was commanded before a recording has acted: dead times of up to half of it,
# lags of a tenth of it down to 5e-5
SETTLING = 2.0 * MAX_SETPOINT_DELAY
BEGINNING = 0.1  # s, whose median is where a recording begins
MOVED = 6.0      # deviations of noise: one reading in 5e8 of a drive at rest
HELD_OUT = 0.3   # share of the windows of each recording, its last ones


@dataclass(frozen=True, eq=False)
class WindowData:
    """
    Readings of `windows` in units of sigma [2], and how they count.

    held_out [W]: windows that no fit may see; colour [2]: see encoder_noise; fixed_states:
    whether the states where windows begin stay as they are.
    """

    recording: UniformRecording
    simulator: Simulator
    windows: ShootingWindows
    sigma: Array
    held_out: Flags
    colour: Array | None = None
    fixed_states: bool = False

    @cached_property
    def channels(self) -> list[int]:
        """Numbers of the encoders that are read."""
        return list(self.recording.channels)

    @cached_property
    def y(self) -> Array:
        """Readings of the windows [W, L, C], rad."""
        readings: Array = self.recording.y[self.windows.samples][:, :, self.channels]
        return readings

    @property
    def size(self) -> int:
        """Number of readings in a window: L samples of C encoders."""
        return self.windows.length * len(self.channels)

    @property
    def span(self) -> slice:
        """Samples that are evidence."""
        return slice(int(self.windows.begin[0]), len(self.recording.u))

    @property
    def unseen(self) -> slice:
        """Samples that are held out."""
        first = self.windows.first[self.held_out]
        return slice(int(first[0]) if len(first) else self.span.stop, self.span.stop)

    @property
    def training(self) -> slice:
        """Samples before those that are held out."""
        return slice(self.span.start, self.unseen.start)

    def residual(self, model: DriveModel, states: Array, memory: Array,
                 index: Integers | None = None, extra: Array | None = None) -> Array:
        """
        Return the residual [M, L, C] of the windows `index` (default: all).

        Args:
            model: model of the drive.
            states: states of the drive where the windows start [M, 4].
            memory: memories of the effects where the windows start [M, 4].
            index: numbers of the windows [M]; repeats are allowed.
            extra: external torques on motor, arm and transmission, N m, [N, 3] of the recording or
                [M, R, 3] of each window, from where its run begins.
        """
        windows = self.windows if index is None else self.windows.take(index)
        y, _ = self.simulator.run(windows, model, states, memory, extra)
        measured = self.y if index is None else self.y[index]
        r: Array = (measured - y[:, :, self.channels]) / self.sigma[self.channels]
        # A run that diverges is as bad as can be, and still a number.
        return self.white(np.clip(np.nan_to_num(r, nan=WORST), -WORST, WORST), self.channels)

    def white(self, residual: Array, channels: list[int]) -> Array:
        """Return `residual` [W, L, C], in sigmas of the encoders `channels`, with white noise."""
        return residual if self.colour is None else prewhitened(residual, self.colour[channels])


def seconds_at_rest(recording: UniformRecording, sigma: Array) -> float:
    """
    Return how long it takes until a reading has moved beyond noise, s; 0 if none ever does.

    Args:
        recording: of one drive.
        sigma: noise of the encoders [2], rad.
    """
    channels = list(recording.channels)
    y = recording.y[:, channels]
    begin = np.median(y[:max(round(BEGINNING / recording.dt), 1)], axis=0)
    moved = (np.abs(y - begin) > MOVED * sigma[channels]).any(axis=1)
    return float(moved.argmax() * recording.dt) if moved.any() else 0.0


def window_data(recording: UniformRecording, model: DriveModel, sigma: Array,
                colour: Array | None = None, settling: float = SETTLING, finer: int = 1,
                seconds: float = SECONDS) -> WindowData:
    """
    Return a recording in windows, the last of which are held out.

    Args:
        recording: of one drive.
        model: its nominal model.
        sigma: noise of the encoders [2], rad.
        colour: correlation of neighbouring readings of each encoder [2], None: white.
        settling: s at the beginning that no window reads.
        finer: how many times as many steps the model takes as the nominal drive asks for.
        seconds: length of the windows, s; of longer ones than SECONDS, which free states would fit
            by many deviations, they are fixed.
    """
    windows = shooting_windows(recording, min(seconds, recording.duration), settling)
    held_out = np.arange(len(windows)) >= len(windows) - round(HELD_OUT * len(windows))
    return WindowData(recording, simulator(recording, model, finer), windows,
                      np.asarray(sigma, float), held_out, colour, seconds > SECONDS)
