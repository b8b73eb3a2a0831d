# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Windows of one recording, with scores by BIC (Schwarz 1978), for fits of values.

Windows of 1 s carry the evidence; the last 30 % of each recording are held out.
"""
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.identification import likelihood
from gearbox_monitor.identification.balance_likelihood import BalanceLikelihood
from gearbox_monitor.identification.candidates import (
    CandidateModel, probes, replaced_value, Starts)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.shooting import shooting_windows, ShootingWindows
from gearbox_monitor.identification.torque_domain import simulator
from gearbox_monitor.kernels.types import Array, Flags, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.recording import UniformRecording

LONG = 1.0  # s
HELD_OUT = 0.3
PROBE, VALUE_PROBE = 0.1, 0.02  # share of the scale in which an effect is tried; of a value less


def held_out(recording: UniformRecording, windows: ShootingWindows) -> tuple[Flags, list[int]]:
    """
    Return (train [W], samples of each joined recording before the held-out windows).

    Held out are the last windows of each recording, 30 %.
    """
    train, last = np.ones(len(windows), bool), []
    part = np.searchsorted(recording.cuts, windows.first, side='right') - 1
    for i, cut_at in enumerate(recording.cuts):
        own_windows = np.flatnonzero(part == i)
        validation = round(HELD_OUT * len(own_windows))
        if validation:
            train[own_windows[-validation:]] = False
        training = own_windows[:len(own_windows) - validation]
        end = windows.first[training[-1]] + windows.length if len(training) else cut_at
        last.append(int(end) - cut_at)
    return train, last


class Search:
    """
    What a fit of values to one recording goes by.

    sigma [2]: noise of the encoders, rad. spans: parts of the recording that are evidence; last:
    samples of each joined recording before the held-out windows; long: windows of 1 s.
    """

    def __init__(self, recording: UniformRecording, model: DriveModel, sigma: Array) -> None:
        self.recording, self.model = recording, model
        self.starts = Starts(model, recording)
        windows = shooting_windows(recording, LONG)
        skipped = int(windows.begin[0])
        self.spans = [slice(part.start + skipped, part.stop) for part in recording.segments]
        train, self.last = held_out(recording, windows)
        self.long = likelihood.WindowData(
            recording, simulator(recording, model), windows, np.asarray(sigma, float), train)

    @cached_property
    def balance(self) -> BalanceLikelihood | None:
        """The balances of a recording whose motion is put in, None where its torque is."""
        return None if self.recording.motor is None else BalanceLikelihood(
            self.recording, self.model, self.long.sigma, self.spans)

    @property
    def half_gap(self) -> float:
        """Half gap of the model (rad), the scale on which windows are started elsewhere."""
        return max(self.model.transmission.half_gap, 0.01)

    def score(self, data: likelihood.WindowData, candidate: CandidateModel,
              point: likelihood.FitPoint) -> float:
        """
        Return the BIC (Schwarz 1978) of `point` on the training windows of `data`.

        Args:
            data: windows of readings and how residuals are weighted.
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
        """
        plain = likelihood.objective(candidate, point, data.train.astype(float))
        return plain + candidate.n_effect * math.log(data.n_train)

    def as_fitted(self, candidate: CandidateModel, point: likelihood.FitPoint,
                  smooth: Array | None = None) -> CandidateFit:
        """
        Return the CandidateFit of `candidate` at `point`, scored.

        Args:
            candidate: model to be fitted, with its coordinates.
            point: where the fit stands.
            smooth: smoothed states in which its windows began [N, N_STATE].
        """
        return CandidateFit(candidate, point, self.score(self.long, candidate, point),
                            smooth=smooth)

    @property
    def noisy(self) -> bool:
        """Whether torque noise on the motor is part of the likelihood."""
        model = self.model
        return model.tolerance > 0.0 or bool(model.process_torque) or model.lasting

    def probes(self, name: str, order: int | None = None) -> list[list[Values]]:
        """
        Return lists of effects, one per column, that are a little of effect `name`, per start.

        Args:
            name: id of an effect.
            order: order N of a periodic effect, None for the others.
        """
        value = replaced_value(self.model, name)
        candidates = self.starts.candidates(name, order)
        share = VALUE_PROBE if value is not None else PROBE
        return [[effect for effect, _ in probes(candidate, share, value)]
                for candidate in (candidates if value is None else candidates[:1])]
