# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The EKF and UKF of filterpy on the same process model: an independent cross-check.

filterpy is no dependency of this package; it comes with the extra "compare".
"""
from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.filter_kind import Belief, Reading
from gearbox_monitor.estimation.process_model import (
    advance, EIGENVALUE, layout_of, noise, P0, pack, propagate, R1, R2, state_names, TAU_K,
    TAU_K_MODEL_STD)
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED
from gearbox_monitor.estimation.sample_loop import aim
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, substeps

NAMES = ('filterpy-ekf', 'filterpy-ukf')


@dataclass(frozen=True)
class ReferenceEstimates:
    """M estimates with the columns of estimates.Estimates that scores and pictures read."""

    stamp_ns: Integers
    x: Array
    tau_k_std: Array
    innovations: Array
    white: Array
    nis: Array
    loglik: Array
    dof: Array
    smoothed_stamp_ns: Integers
    smoothed: Array

    def __getattr__(self, name: str) -> Array:
        """Return the column `name` of Estimates."""
        column = {'innovation_motor': ('innovations', 0), 'innovation_arm': ('innovations', 1),
                  'white_1': ('white', 0), 'white_2': ('white', 1)}.get(name)
        if column:
            values: Array = getattr(self, column[0])[:, column[1]]
            return values
        if name == 'tau_k':
            return self.x[:, TAU_K]
        if name == 'twist':
            return self.x[:, 0] - self.x[:, 1]
        raise AttributeError(name)


def run(name: str, model: DriveModel, parameters: EstimatorParameters | Mapping[str, object],
        samples: Samples) -> ReferenceEstimates:
    """
    Run a filter of filterpy.

    Args:
        name: one of NAMES.
        model: of the drive.
        parameters: of the estimator.
        samples: in order and complete in the torque (and in a measured load).

    Returns:
        Estimates from the second sample on.

    Raises:
        InputError: filterpy is not installed, or a sample is incomplete or out of order.

    """
    try:
        from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints
        from filterpy.kalman import UnscentedKalmanFilter
    except ImportError:
        raise InputError(f'{name}: filterpy is not installed, expected '
                         f'{installed_by("compare")}') from None
    parameters = EstimatorParameters.of(parameters).replace(filter='ekf')
    if parameters.arm_load != 'model':
        model = model.with_(arm_load=parameters.arm_load)
    _check(name, model, parameters, samples)
    p, n = pack(model, parameters), len(state_names(model, parameters))
    layout = layout_of(p, n)
    load = samples.u[:, 1] if model.arm_load == 'measured' else np.zeros(len(samples.u))

    def move(z: Array, dt: float, u: float = 0.0, load: float = 0.0) -> Array:
        """
        Advance a state.

        Args:
            z: the state [n].
            dt: length of the step, s.
            u: motor torque, N m.
            load: measured load on the arm, N m.

        Returns:
            The state [n] at the end of the step.

        """
        z = np.array(z)
        advance(layout, z, (u, load), dt, substeps(dt, p[EIGENVALUE]), p)
        return z

    z0 = np.zeros(n)
    z0[:2] = samples.y[0]
    if name == 'filterpy-ekf':
        kf = ExtendedKalmanFilter(n, 2)
    else:
        points = MerweScaledSigmaPoints(n, parameters.ukf_alpha, parameters.ukf_beta,
                                        parameters.ukf_kappa)
        kf = UnscentedKalmanFilter(n, 2, None, lambda z: z[:2], move, points)
    kf.x, kf.P = z0, np.diag(p[P0:P0 + n])
    first = Reading((samples.stamp_ns[1] - samples.stamp_ns[0]) * 1e-9, 0.0, 0.0, *samples.y[1])
    aim(layout, Belief(z0, kf.P.ravel(), np.zeros(0)), first, p)
    kf.R = np.diag([p[R1], p[R2]])
    H = np.eye(2, n)
    count = len(samples.stamp_ns) - 1
    x, std, innovation = np.empty((count, n)), np.empty(count), np.empty((count, 2))
    white, nis, loglik = np.empty((count, 2)), np.empty(count), np.empty(count)
    for k in range(count):
        dt = (samples.stamp_ns[k + 1] - samples.stamp_ns[k]) * 1e-9
        u, load_k, y = samples.u[k, 0], load[k], samples.y[k + 1]
        half = np.diag([0.5 * dt * noise(kf.x, p, i) for i in range(n)])
        if name == 'filterpy-ekf':
            z, phi = np.array(kf.x), np.empty((n, n))
            propagate(layout, z, phi.reshape(-1), (u, load_k), dt,
                      substeps(dt, p[EIGENVALUE]), p)
            half_at_end = np.diag([0.5 * dt * noise(z, p, i) for i in range(n)])
            kf.F, kf.Q = phi, phi @ half @ phi.T + half_at_end
            kf.predict_x = lambda u=0, z=z: setattr(kf, 'x', z)
            kf.predict()
            kf.update(y, lambda z: H, lambda z: z[:2])
        else:
            kf.P = kf.P + half
            kf.Q = half
            kf.predict(dt, u=u, load=load_k)
            kf.update(y)
        x[k], innovation[k] = kf.x, kf.y
        std[k] = math.sqrt(kf.P[TAU_K, TAU_K] + p[TAU_K_MODEL_STD] ** 2)
        white[k] = np.linalg.solve(np.linalg.cholesky(kf.S), kf.y)
        nis[k] = white[k] @ white[k]
        loglik[k] = -0.5 * (nis[k] + math.log(np.linalg.det(kf.S)) + 2.0 * math.log(2.0 * math.pi))
    return ReferenceEstimates(
        samples.stamp_ns[1:], x, std, innovation, white, nis, loglik, np.full(count, 2.0),
        np.empty(0, np.int64), np.empty((0, N_SMOOTHED)))


def _check(name: str, model: DriveModel, parameters: EstimatorParameters,
           samples: Samples) -> None:
    """Raise InputError if the plain loop of run does not suffice."""
    needed = np.column_stack([samples.u[:, :1], samples.y])
    if model.arm_load == 'measured':
        needed = np.column_stack([needed, samples.u[:, 1]])
    bad: Flags = np.asarray(~np.isfinite(needed).all(axis=1))
    bad[1:] |= np.diff(samples.stamp_ns) <= 0
    if len(bad) < 2 or bad.any():
        at = int(np.argmax(bad)) if bad.any() else len(bad)
        raise InputError(f'{name}: sample {at} is incomplete or out of order, expected two or '
                         'more complete samples in order')
    if parameters.effort_delay:
        raise InputError(f'{name}: effort_delay {parameters.effort_delay}, expected 0')
