# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Random effects: one value of a drive from several recordings between which it differs.

Load, temperature and wear change from run to run by more than the noise of a fit says. Each
recording is fitted alone; its value scatters about that of the drive by both (DerSimonian and
Laird, 1986; variance between recordings by Paule and Mandel, 1982; interval by Hartung and Knapp,
2001, which holds for few recordings).
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.balance_likelihood import likelihood_of
from gearbox_monitor.diagnosis.joint.candidates import CandidateModel
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    coordinate_columns, COORDINATE_STEP, evaluated, fitted, unfitted)
from gearbox_monitor.diagnosis.joint.innovations import JointLikelihood
from gearbox_monitor.diagnosis.joint.parameter_ranges import mixture
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.signals.recording import UniformRecording

CONFIDENCE = 0.9
EXACT = 1e-9   # relative error of a value that has none


@dataclass(frozen=True)
class RandomEffect:
    """
    A value of a drive: mean over recordings with its 90 % range `low` to `high`.

    between: standard deviation from recording to recording. recordings, errors: value and standard
    error of each alone.
    """

    mean: float
    low: float
    high: float
    between: float
    recordings: list[float]
    errors: list[float]


def pooled(values: Sequence[float], errors: Sequence[float]) -> RandomEffect:
    """
    Return the RandomEffect of a value that was measured several times.

    Args:
        values: of each recording [N], N >= 2.
        errors: their standard errors [N].
    """
    y, variance = np.array(values, float), np.array(errors, float) ** 2
    variance = np.maximum(variance, (EXACT * max(float(np.abs(y).max()), EXACT)) ** 2)
    between = mixture(y, variance)[3]
    weight = 1.0 / (variance + between ** 2)
    mean = float(weight @ y / weight.sum())
    scatter = float(weight @ (y - mean) ** 2) / (len(y) - 1)  # 1 where drives differ
    reach = float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(y) - 1)) * math.sqrt(
        scatter / weight.sum())
    return RandomEffect(mean, mean - reach, mean + reach, between, y.tolist(),
                        [float(e) for e in errors])


def _numbers(candidate: CandidateModel, z: Array) -> dict[tuple[str, str], float]:
    """Return {(id, parameter): value} of the effects at z, without whole and listed ones."""
    return {(name, key): value for name, values in zip(candidate.ids, candidate.values(z)[1])
            for key, value in values.items() if isinstance(value, float)}


def between_recordings(recordings: Sequence[UniformRecording], candidate: CandidateModel, z: Array,
                       sigma: Array) -> dict[str, dict[str, RandomEffect]]:
    """
    Return {id: {parameter: RandomEffect}} of the effects of a candidate.

    Args:
        recordings: of one drive, which the torque or a setpoint drives; two or more.
        candidate: model with its coordinates.
        z: coordinates [P] of the fit to all recordings.
        sigma: noise of the encoders [2], rad.
    """
    measured: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for recording in recordings:
        likelihood = JointLikelihood([likelihood_of(recording, candidate.nominal, sigma,
                                                    [recording.span])])
        fit = evaluated(likelihood, fitted(likelihood, unfitted(likelihood, candidate, z)))
        columns = coordinate_columns(likelihood, fit)
        inverse = covariance(columns.T @ columns + np.diag(candidate.prior(fit.z)[1]))
        steps = COORDINATE_STEP * candidate.steps()
        moved = [_numbers(candidate, fit.z + step) for step in np.diag(steps)]
        for key, value in _numbers(candidate, fit.z).items():
            slope = np.array([(other[key] - value) / step for other, step in zip(moved, steps)])
            measured.setdefault(key, []).append(
                (value, math.sqrt(max(float(slope @ inverse @ slope), 0.0))))
    out: dict[str, dict[str, RandomEffect]] = {}
    for (name, parameter), pairs in measured.items():
        values, errors = zip(*pairs)
        out.setdefault(name, {})[parameter] = pooled(values, errors)
    return out
