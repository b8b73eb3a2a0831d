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
Model adequacy: whether a fit leaves more of a recording than noise.

The residual is tested for excess chi2, for coloured bands of its spectrum, and for dependence on
the motion (residual analysis, Ljung, System Identification, ch. 16).
"""
from dataclasses import replace

import numpy as np

from gearbox_monitor.identification import closed_model, model_error, noise_model
from gearbox_monitor.identification.candidates import NOT_FITTED
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.residual_dependence import (
    ResidualDependence, strongest_dependence)
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE

BANDS = (0.0, 3.0, 8.0, 20.0, noise_model.MOTION)  # Hz


def sharpened(search: Search, fitted: CandidateFit) -> tuple[Search, CandidateFit]:
    """
    Return (search, fitted) with sigma as the residual of `fitted` has it at high frequencies.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    long, none = search.long, search.fitted['']
    power, _, high = noise_model.spectrum(
        long.parted(fitted.point.residual), search.recording.dt)
    factor = np.sqrt(power[:, high].mean(axis=(0, 1)))
    if not (np.abs(factor - 1.0) < THRESHOLDS.sharpening).all():
        return search, fitted
    sigma = long.sigma.copy()
    sigma[long.channels] *= factor
    scale = np.tile(factor, long.windows.length)

    def scaled(fit: CandidateFit) -> CandidateFit:
        """Return `fit` with residuals that follow sigma."""
        residual = fit.point.residual / scale
        return replace(fit, white=None if fit.white is None else fit.white / scale, point=replace(
            fit.point, residual=residual, chi2=(residual ** 2).sum(axis=1)))
    rescaled = scaled(fitted)
    fits = {name: rescaled if fit is fitted else scaled(fit) if fit is none else fit
            for name, fit in search.fitted.items()}
    return search.with_data(replace(long, sigma=sigma), fits), rescaled


def misfit(search: Search, fitted: CandidateFit, spared: int = 0) -> tuple[float, float]:
    """
    Return (excess, structure) of the residual of `fitted` on the training windows.

    The structure is a spectral whiteness test: it does not depend on how well sigma is known.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        spared: number of worst windows that are ignored.

    Returns:
        excess: chi2 per reading - 1. structure: by how many standard deviations the most
            conspicuous frequency band exceeds white noise of the power above BANDS.
    """
    train = search.long.train
    r = fitted.point.residual if fitted.white is None else fitted.white
    r = search.long.parted(r[train])
    structure = spectral_excess(r, search.recording.dt)
    chi2 = np.sort((r ** 2).mean(axis=(1, 2)))
    return float(chi2[:max(1, len(chi2) - spared)].mean() - 1.0), structure


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
        # Without the worst window: one that found no good start is no unknown effect.
        ratio = np.sort(band_power.mean(axis=(1, 2)))[:max(1, len(band_power) - 1)].mean()
        structure = max(structure, (ratio - 1.0) / np.sqrt(2.0 / band_power.size))
    return float(structure)


def on_all(search: Search, fitted: CandidateFit) -> tuple[Search, CandidateFit]:
    """
    Return (search, fitted) with no window held out: what is missing may show in those more.

    The same where noise of the torque, what lasts or bursts make windows differ.
    """
    if (search.long.train.all() or search.noisy or search.recording.motor is not None
            or search.model.process_torque_time > 0.0
            or set(fitted.candidate.ids) & set(NOT_FITTED)):
        return search, fitted
    whole = search.trained_on(np.ones_like(search.long.train), search.fitted)
    return whole, closed_model.settled(search, fitted, [])


def leaves_more_than_noise(search: Search, fitted: CandidateFit, rough: bool = False) -> bool:
    """
    Return whether `fitted` leaves more than noise; rough: an encoder has steps above noise.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        rough: whether an encoder is quantised more coarsely than its noise.
    """
    if search.model.process_torque_time > 0.0:
        # No model of a real drive explains everything: the torque that is left tells.
        if fitted.persistent is not None:
            return bool((fitted.persistent > THRESHOLDS.lasting_torque * model_error.scales(
                search.recording)).any())
        return bool(fitted.s > THRESHOLDS.lasting_torque * np.std(search.recording.torque))
    noise = max(THRESHOLDS.torque_noise * float(np.std(search.recording.torque)),
                search.model.process_torque or 0.0)
    if search.noisy and fitted.s > noise:
        return True
    # A hard burst throws the arm to where a free signal does not find it.
    excess, structure = misfit(search, fitted, int(DISTURBANCE.id in fitted.candidate.ids))
    null_excess, _ = misfit(search, search.fitted[''])
    readings = len(search.recording.u) * len(search.long.channels)
    chance = 2.0 * THRESHOLDS.level_errors * THRESHOLDS.level_error / readings ** 0.5
    lack = THRESHOLDS.rough_excess if rough else max(THRESHOLDS.excess, chance)
    limit = (THRESHOLDS.rough_structure if rough else
             THRESHOLDS.noisy_structure if search.noisy else
             THRESHOLDS.pair_structure if len(fitted.candidate.ids) > 1 else THRESHOLDS.structure)
    return (excess > max(lack, THRESHOLDS.excess_relative * null_excess)
            or structure > limit + THRESHOLDS.structure_relative * null_excess)


def residual_law(search: Search, fitted: CandidateFit) -> ResidualDependence | None:
    """
    Return what `fitted` leaves as a function of the motion, None where that is chance.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    if search.noisy or search.recording.motor is not None:
        return None  # not white
    if DISTURBANCE.id in fitted.candidate.ids:
        return None  # a free signal, of which the motion has been asked
    gain = (search.fitted[''].point.chi2 - fitted.point.chi2).sum()
    # A motion that the fit misses is better taken from the readings.
    dependence = strongest_dependence(search, fitted,
                                      modelled=not leaves_more_than_noise(search, fitted))
    limit = THRESHOLDS.dependence + THRESHOLDS.dependence_relative * max(0.0, gain)
    return dependence if dependence.gain > limit else None


def incomplete(search: Search, fitted: CandidateFit, rough: bool = False) -> bool:
    """
    Return whether `fitted` leaves more than noise, or a law of the motion; rough: of lacks.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        rough: whether an encoder is quantised more coarsely than its noise.
    """
    return leaves_more_than_noise(search, fitted, rough) or (
        not rough and residual_law(search, fitted) is not None)
