# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Linear least squares by normal equations, with one rule of rank.

Parameters differ by ten orders of magnitude: a normal matrix is taken at unit diagonal, where
directions with less than RANK of the largest eigenvalue count as undetermined. A prior is part of
the matrix: 1 over its variance on the diagonal. Elsewhere stand, on purpose: bounded least squares
(signals.wiring), noise profiled per band (diagnosis.robot.evidence), noise in the columns
(diagnosis.joint.torque_regression) and a roughness penalty with its own cutoff
(diagnosis.joint.basis_functions).
"""
import numpy as np

from gearbox_monitor.kernels.types import Array

RANK = 1e-12
LEAST = 1e-100  # of a diagonal: below it no row has the parameter


def covariance(normal: Array) -> Array:
    """Return the inverse [P, P] of a `normal` matrix, 0 of what no row determines."""
    diagonal = np.diag(normal)
    scale = np.where(diagonal > LEAST, 1.0 / np.sqrt(np.maximum(diagonal, LEAST)), 0.0)
    unit = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(normal * unit, RANK) * unit)


def solution(normal: Array, right: Array) -> Array:
    """Return the solution [P] of `normal` x = `right`, the shortest at unit diagonal."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    return np.asarray(scale * np.linalg.lstsq(
        normal * scale[:, None] * scale, right * scale, rcond=RANK)[0])
