# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How the torque acted between the stamps of a slow log, which its readings have to tell.

A controller as slow as the log holds its torque from stamp to stamp. One that is faster has moved
on: the log holds samples of its torque, which act later by up to half of the controller's period.
"""
from collections.abc import Sequence
from dataclasses import replace

import scipy

from gearbox_monitor.diagnosis.joint.evidence import Evidence, evidence_of
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    evaluated, fitted, InnovationFit, unfitted)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.recording import UniformRecording

SLOW = 198.0  # Hz: from 200 on, less what stamps wander, half a sample is within other tolerances
ITERATIONS = 8  # of a fit to recordings that are read in another way
TURNS = 6  # of reading and fitting
LEAST_GAIN = 1.0  # of a turn, in BIC
NEAR = 0.1  # relative: values of a model that was fitted to recordings read in another way
LATEST = 0.5  # sample times by which a torque that was sampled acts later at most


def is_open(recording: UniformRecording, model: DriveModel) -> bool:
    """Return whether `recording` leaves open how torque acted on `model` between its stamps."""
    return (recording.dt * SLOW > 1.0 and model.controller is None
            and model.driven_by == 'torque')


def likeliest(evidence: Evidence, fit: InnovationFit) -> tuple[Evidence, InnovationFit]:
    """
    Return (the recordings, read so that `fit` is likeliest; `fit`, fitted to them as read so).

    Args:
        evidence: the recordings, as they were read for `fit`.
        fit: of one model to all of them.
    """
    for _ in range(TURNS):
        score = evidence.score(fit)
        read = replace(evidence, recordings=tuple(
            _read(evidence, fit, number) for number in range(len(evidence.recordings))))
        refit = fitted(read.fine, fit, ITERATIONS)
        if read.score(refit) > score - LEAST_GAIN:
            break
        evidence, fit = read, refit
    return evidence, fit


def likeliest_reading(evidence: Evidence) -> Evidence:
    """Return the recordings, read so that the model without effects is likeliest."""
    none = unfitted(evidence.fine, evidence.starts.none())
    return likeliest(evidence, evaluated(evidence.fine, none))[0]


def read_for(recordings: Sequence[UniformRecording], model: DriveModel
             ) -> tuple[UniformRecording, ...]:
    """
    Return recordings, read so that `model` is likeliest, its values fitted along.

    Args:
        recordings: of the drive.
        model: of it.
    """
    return likeliest_reading(evidence_of(
        recordings, replace(model, tolerance=NEAR), ())).recordings


def _read(evidence: Evidence, fit: InnovationFit, number: int) -> UniformRecording:
    """Return one of the recordings, read so that `fit` as it stands is likeliest."""
    recording, model = evidence.recordings[number], fit.model
    if not is_open(recording, evidence.model):
        return recording

    def _deviance(shift: float | None) -> float:
        part = replace(evidence, recordings=(replace(recording, shift=shift),))
        return float(part.fine.run(model, fit.torque).deviance)
    sampled = scipy.optimize.minimize_scalar(
        _deviance, bounds=(0.0, LATEST), method='bounded', options={'xatol': 2e-3})
    return replace(recording, shift=None if _deviance(None) <= sampled.fun
                   else float(sampled.x))
