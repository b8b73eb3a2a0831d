# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Model adequacy: whether a fit leaves more of the recordings than noise.

Four tests, each against noise alone. Torque noise that the likelihood wants beyond what is allowed
(a right model needs none: the noise anneals to its floor). Whiteness of the innovations by bands
of frequency (Ljung, System Identification, ch. 16). A score test of free functions of the motion.
And free runs of 1 s, which no filter corrects: a fit after which they miss by more than the noise
itself explains a part at most, however likely its innovations are.
"""
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.diagnosis.joint import noise_model
from gearbox_monitor.diagnosis.joint.effect_scan import Dependence, dependences
from gearbox_monitor.diagnosis.joint.evidence import Evidence
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    evaluated, FilteredFit, fitted, InnovationFit)
from gearbox_monitor.diagnosis.joint.innovations import Filtered, STRAY
from gearbox_monitor.diagnosis.joint.localisation import torque_places
from gearbox_monitor.diagnosis.joint.noise_model import prewhitened, white_level
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import (
    free_runs, typical_misfit, WindowData, WindowRuns)
from gearbox_monitor.kernels.types import Array

REFIT = 8  # iterations of a fit to all that is evidence
BANDS = (0.0, 3.0, 8.0, 20.0, noise_model.MOTION)  # Hz


@dataclass(frozen=True, eq=False)
class Adequacy:
    """
    What `fit` leaves of `evidence`.

    noise_gain: in -2 log L, of torque noise beyond the allowed. excess: chi2 of innovations per
    reading - 1. structure: deviations by which a band of frequencies exceeds white noise.
    misfit: of a typical window of 1 s in free runs, in sigmas; misfit_limit: what noise and the
    fitted torque noise explain of it.
    """

    evidence: Evidence
    fit: InnovationFit
    noise_gain: float
    excess: float
    structure: float
    structure_limit: float
    misfit: float
    misfit_limit: float
    runs: tuple[WindowRuns, ...]

    @cached_property
    def dependence(self) -> Dependence | None:
        """Strongest free function of the motion, None where too few readings or steps count."""
        evidence = self.evidence
        if evidence.balances or evidence.lasting or evidence.rough:
            return None
        tested = dependences(evidence.whole, evaluated(evidence.whole, self.fit),
                             torque_places(evidence.model))
        return next(iter(tested), None)

    @property
    def vetoed(self) -> bool:
        """Whether free runs miss by more than the noise itself."""
        return not self.misfit <= self.misfit_limit

    @property
    def adequate(self) -> bool:
        """Whether all that is left is noise."""
        return not (self.noise_gain > THRESHOLDS.noise_gain or self.vetoed
                    or self.structure > self.structure_limit
                    or self.dependence is not None and self.dependence.beyond_chance)


def adequacy_of(evidence: Evidence, fit: InnovationFit) -> Adequacy:
    """
    Return what a fit leaves of all that is evidence.

    Free runs are those of the fit to the training parts. The other tests doubt the effects, not
    their values: the held-out parts may determine a value far better. If these tests fail, they
    are repeated with a fit to all parts.

    Args:
        evidence: the recordings and the likelihoods of their parts.
        fit: of the training parts.
    """
    whole = evidence.whole
    at = evaluated(whole, fit)
    if evidence.balances:
        # No model of a real drive explains everything: the share that is left tells.
        left = np.sqrt(np.mean([run.left ** 2 for run in at.run.runs], axis=0))
        return Adequacy(evidence, fit, 0.0, 0.0, -math.inf, THRESHOLDS.structure,
                        float((left / evidence.scales).max()), THRESHOLDS.lasting_torque,
                        runs_of(evidence, at))
    runs = runs_of(evidence, at)
    stray = STRAY * float((fit.torque / whole.least_noise).max())
    limit = THRESHOLDS.misfit * math.hypot(1.0, stray)
    left = _left(evidence, at, runs, limit)
    if left.adequate or left.vetoed or not len(fit.z):
        return left
    refitted = fitted(whole, at.alone(), REFIT)
    return _left(evidence, evaluated(whole, refitted), runs, limit)


def _left(evidence: Evidence, at: FilteredFit, runs: tuple[WindowRuns, ...],
          misfit_limit: float) -> Adequacy:
    """
    Return what a fit leaves.

    Args:
        evidence: the recordings.
        at: fit whose filter was run over all of them.
        runs: free runs of the fit.
        misfit_limit: what noise and the fitted torque noise explain of their misfit, in sigmas.
    """
    excess, structure = 0.0, -math.inf
    limit = THRESHOLDS.rough_structure if evidence.rough else (
        THRESHOLDS.noisy_structure if evidence.noisy else THRESHOLDS.structure)
    if not evidence.lasting:  # few readings count
        white = [_whitened(segment, run, evidence.sigma, evidence.colour)
                 for segment, run in zip(evidence.segments, at.run.runs)]
        excess = float(np.mean([(w ** 2).mean() for w in white])) - 1.0
        structure = max(spectral_excess(w, segment.recording.dt)
                        for w, segment in zip(white, evidence.segments))
    return Adequacy(evidence, at.alone(), _noise_gain(evidence, at, runs), excess, structure,
                    limit, typical_misfit(runs), misfit_limit, runs)


def _noise_gain(evidence: Evidence, at: FilteredFit, runs: Sequence[WindowRuns]) -> float:
    """
    Return the gain in -2 log L of torque noise beyond the allowed.

    A filter is linearised about one state. Of a side that no encoder reads it may lose track in
    the gap, and noise stands for that: what a free run explains there, the model explains.

    Args:
        evidence: the recordings.
        at: fit whose filter was run over all of them.
        runs: free runs of the fit.
    """
    allowed = np.minimum(at.torque, evidence.allowed_noise)
    if not (allowed < at.torque).any():
        return 0.0
    quiet = evidence.whole.run(at.model, allowed)
    gain = quiet.deviance - at.run.deviance
    for run, filtered in zip(runs, quiet.runs):
        if evidence.hides(run.recording):
            rows = np.maximum(run.data.windows.samples - 1, 0)
            explained = filtered.deviances[rows].sum(axis=(1, 2)) - (
                run.chi2 - run.data.size + run.states.shape[1])
            gain -= float(np.maximum(explained, 0.0).sum())
    return gain


def runs_of(evidence: Evidence, at: FilteredFit) -> tuple[WindowRuns, ...]:
    """
    Return the free runs of a fit over the windows of each recording.

    Args:
        evidence: the recordings.
        at: fit whose filter was run over all of them.
    """
    model = at.model
    return tuple(free_runs(segment, model, smooth) for segment, smooth in zip(
        evidence.segments, evidence.whole.smoothed(at.run)))


def _whitened(segment: WindowData, run: Filtered, sigma: Array, colour: Array | None) -> Array:
    """Return the innovations of the windows of a recording [W, L, C], coloured noise undone."""
    channels = segment.channels
    white: Array = run.residual[np.maximum(segment.windows.samples - 1, 0)][:, :, channels]
    if colour is not None:  # the filter takes it for white noise of its power at rest
        level = white_level(sigma, colour) / sigma
        white = prewhitened(white * level[channels], colour[channels])
    return white


def spectral_excess(residual: Array, dt: float) -> float:
    """
    Return by how many standard deviations a frequency band exceeds white noise, of the worst one.

    Args:
        residual: residual [W, L, C], in standard deviations.
        dt: sample time, s.
    """
    power, at, high = noise_model.spectrum(residual, dt)
    white = power[:, high].mean(axis=(0, 1))
    structure = -np.inf
    for low, top in zip(BANDS, BANDS[1:]):
        band_power = power[:, (at > low) & (at <= top)] / white
        if not band_power.size:
            continue
        # Without the worst window: one burst is no unknown effect.
        ratio = np.sort(band_power.mean(axis=(1, 2)))[:max(1, len(band_power) - 1)].mean()
        # Both the band's power and that of the white noise are measured.
        deviation = np.sqrt(2.0 / band_power.size + 2.0 / power[:, high].size)
        structure = max(structure, (ratio - 1.0) / deviation)
    return float(structure)
