# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Noise of the encoders as a decision leaves it: its level, and its colour.

Coloured noise is a first-order autoregression, r_k = phi r_(k-1) + e_k with white e. Treated as
white, it looks like motion that no effect explains. phi is estimated from the spectrum above the
frequencies of motion; with the best effect fitted, somewhat lower frequencies can be used, too.
"""
from dataclasses import replace
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.adequacy import runs_of
from gearbox_monitor.diagnosis.joint.closed_model import SIGMA_ERROR
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated
from gearbox_monitor.diagnosis.joint.judge import Decision
from gearbox_monitor.diagnosis.joint.noise_model import MOTION, spectrum
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.kernels.types import Array

FITTED = 20.0     # Hz, above which a fitted effect leaves hardly anything
WIDTH, HIGHEST = 1.26, 490.0  # of a band; Hz
TRIED = np.linspace(0.0, 0.98, 99)


def measured(residual: Array, dt: float,
             lowest: float = MOTION) -> tuple[Array, Array] | None:
    """
    Return (phi [C], size [C]) of the noise of the encoders above `lowest`.

    size: its standard deviation, in sigmas. phi is 0 and size 1 for an encoder whose noise is
    white, or like nothing known. None where all are.

    Args:
        residual: residual [W, L, C], in standard deviations.
        dt: sample time, s.
        lowest: lowest frequency that counts, Hz.
    """
    power, at, _ = spectrum(residual, dt)
    edges = lowest * WIDTH ** np.arange(1 + int(np.log(HIGHEST / lowest) / np.log(WIDTH)))
    bands = [(at >= low) & (at < high) for low, high in zip(edges, edges[1:]) if high <= at[-1]]
    if len(bands) < 3:
        return None
    # Windows in the middle: those with impacts do not count.
    level = np.log(np.maximum(1e-300, [
        np.median(power[:, band].mean(axis=1), axis=0) for band in bands]))
    shape = (1.0 - TRIED ** 2) / (
        1.0 + TRIED ** 2 - 2.0 * TRIED * np.cos(2.0 * np.pi * dt * at)[:, None])
    line = np.log([shape[band].mean(axis=0) for band in bands])
    weight = np.array([band.sum() for band in bands]) / sum(band.sum() for band in bands)
    phi, size = np.zeros(level.shape[1]), np.ones(level.shape[1])
    for i, spectrum_levels in enumerate(level.T):
        ratio = spectrum_levels[:, None] - line
        middle = weight @ ratio
        off = np.sqrt(weight @ (ratio - middle) ** 2)
        closest = int(off.argmin())
        if TRIED[closest] >= THRESHOLDS.correlation and off[closest] < THRESHOLDS.colour:
            phi[i], size[i] = TRIED[closest], np.exp(0.5 * middle[closest])
    return (phi, size) if phi.any() else None


def measure(decision: Decision, lowest: float = MOTION) -> tuple[Array, Array] | None:
    """
    Return (sigma [2] rad, phi [2]) from what a decision leaves, None where the noise is white.

    The model without effects takes its place where it leaves less: torque noise hides wrong fits.

    Args:
        decision: of the judge.
        lowest: lowest frequency that counts, Hz.
    """
    of_fit, of_none = decision.adequacy.runs, decision.none_adequacy.runs
    runs = min(of_fit, of_none, key=lambda rows: typical_misfit(rows))
    sigma, phi, counts = decision.evidence.sigma.copy(), np.zeros(2), np.zeros(2)
    size = np.zeros(2)
    for run in runs:
        # The distances of the readings, in sigmas.
        residual = replace(run.data, colour=None).residual(run.model, run.states, run.memory)
        noise = measured(residual, run.recording.dt, lowest)
        channels = run.data.channels
        counts[channels] += 1
        phi[channels] += 0.0 if noise is None else noise[0]
        size[channels] += 1.0 if noise is None else noise[1]
    if not phi.any():
        return None
    read = counts > 0
    phi[read] /= counts[read]
    sigma[read] *= size[read] / counts[read]
    return sigma, phi


def with_level_of_innovations(decision: Decision) -> Decision:
    """
    Return the decision with the level of encoder noise that the innovations of its fit have.

    If a fit leaves white noise alone, its innovations measure the level more accurately than
    fourth differences did. A level that fourth differences exclude is not taken.

    Args:
        decision: of the judge.
    """
    evidence = decision.evidence
    if (decision.remains or decision.bursts is not None or evidence.colour is not None
            or evidence.balances or evidence.lasting or evidence.rough):
        return decision
    run = evaluated(evidence.whole, decision.fit).run
    sigma = evidence.sigma.copy()
    for channel in (0, 1):
        residual = run.residual[run.read[:, channel], channel]
        if len(residual):
            level = math.sqrt(float(np.mean(residual ** 2)))
            excluded = THRESHOLDS.noise_level * SIGMA_ERROR / math.sqrt(len(residual))
            if level > 0.0 and abs(math.log(level)) < excluded:
                sigma[channel] *= level
    evidence = replace(evidence, sigma=sigma)
    adequacies = []
    for fit, adequacy in ((decision.fit, decision.adequacy),
                          (decision.none, decision.none_adequacy)):
        runs = runs_of(evidence, evaluated(evidence.whole, fit))
        adequacies.append(replace(adequacy, runs=runs, misfit=typical_misfit(runs)))
    return replace(decision, evidence=evidence, adequacy=adequacies[0],
                   none_adequacy=adequacies[1])
