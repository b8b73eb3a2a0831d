# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Adequacy of fits to windows where the measured motion of the motor drives the model."""
from dataclasses import replace

import numpy as np

from gearbox_monitor.identification import noise_model
from gearbox_monitor.identification.adequacy import spectral_excess
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.position import model_error
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS


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


def misfit(search: Search, fitted: CandidateFit) -> tuple[float, float]:
    """
    Return (excess, structure) of the residual of `fitted` on the training windows.

    The structure is a spectral whiteness test: it does not depend on how well sigma is known.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.

    Returns:
        excess: chi2 per reading - 1. structure: by how many standard deviations the most
            conspicuous frequency band exceeds white noise of the power above BANDS.
    """
    train = search.long.train
    r = fitted.point.residual if fitted.white is None else fitted.white
    r = search.long.parted(r[train])
    structure = spectral_excess(r, search.recording.dt)
    return float((r ** 2).mean() - 1.0), structure


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
    if search.noisy and fitted.s > max(
            THRESHOLDS.torque_noise * float(np.std(search.recording.torque)),
            search.model.process_torque or 0.0):
        return True
    excess, structure = misfit(search, fitted)
    null_excess, _ = misfit(search, search.fitted[''])
    readings = len(search.recording.u) * len(search.long.channels)
    chance = 2.0 * THRESHOLDS.level_errors * THRESHOLDS.level_error / readings ** 0.5
    lack = THRESHOLDS.rough_excess if rough else max(THRESHOLDS.excess, chance)
    limit = (THRESHOLDS.rough_structure if rough else
             THRESHOLDS.noisy_structure if search.noisy else
             THRESHOLDS.pair_structure if len(fitted.candidate.ids) > 1 else THRESHOLDS.structure)
    return (excess > max(lack, THRESHOLDS.excess_relative * null_excess)
            or structure > limit + THRESHOLDS.structure_relative * null_excess)
