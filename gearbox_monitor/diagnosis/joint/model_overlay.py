# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Models laid over a recording: free runs over windows of 1 s, and one over all of it.

Window states are fitted; no value of a model moves but an unknown zero of the encoders.
"""
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.diagnosis.joint.closed_model import crossed, free_run, open_loop
from gearbox_monitor.diagnosis.joint.noise_model import noise_floor
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows
from gearbox_monitor.diagnosis.joint.torque_domain import driven
from gearbox_monitor.diagnosis.joint.windows import misfit_of
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.free_runs import Begin
from gearbox_monitor.signals.recording import UniformRecording


@dataclass(frozen=True)
class ModelRun:
    """
    What one model gives: y [W, L, 2] rad in the windows, chi2 [W] of them, their gap.

    begin: states and memories from which the windows run. free [N, 2] rad: one run over the whole
    recording, from the states of the first window, NaN or huge where the model diverges.
    """

    name: str
    y: Array
    chi2: Array
    gap: float
    begin: Begin
    free: Array


@dataclass(frozen=True)
class Overlay:
    """
    A Recording and the Runs of models over its Windows.

    t [W, L] s and measured [W, L, 2] rad; validation [W]: whether a diagnosis holds the window
    out; sigma [2] rad, noise of the encoders; channels: the encoders that there are.
    """

    recording: UniformRecording
    windows: ShootingWindows
    t: Array
    measured: Array
    validation: Flags
    sigma: Array
    channels: tuple[int, ...]
    runs: tuple[ModelRun, ...]

    def residual(self, run: ModelRun) -> Array:
        """
        Return measured less modelled [W, L, C] of the encoders `channels`, in sigma.

        Args:
            run: simulated readings of one model.
        """
        use = list(self.channels)
        return ((self.measured - run.y) / self.sigma)[:, :, use]


def overlay(recording: UniformRecording, models: Mapping[str, DriveModel],
            sigma: Array | None = None) -> Overlay:
    """
    Return the Overlay of a Recording and `models` {name: DriveModel}.

    sigma [2] rad: noise of the encoders (default: measured from the recording).

    Args:
        recording: recording of the drive.
        models: models by name.
        sigma: noise of the encoders [2], rad.
    """
    recording = driven(recording, next(iter(models.values())))
    if sigma is None:
        sigma, _ = noise_floor(recording, next(iter(models.values())))
    fits = tuple(open_loop(recording, model, sigma) for model in models.values())
    if len(fits) == 2:
        fits = crossed(fits)
    windows, runs = fits[0].data.windows, []
    for name, fit in zip(models, fits):
        y, _ = fit.data.simulator.run(windows, fit.model, fit.states, fit.memory)
        runs.append(ModelRun(name, y, fit.chi2, misfit_of([fit]), Begin(fit.states, fit.memory),
                             free_run(fit)))
    return Overlay(recording, windows, recording.t[windows.samples], recording.y[windows.samples],
                   fits[0].data.held_out, np.asarray(sigma, float), recording.channels,
                   tuple(runs))
