# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
EKF and UKF of filterpy as a user writes them: the model in numpy, Jacobian by hand.

The reference for speed.
"""
from collections.abc import Callable, Sequence
import math
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel


def steppers(model: DriveModel, std: Sequence[float], u: Array, y: Array,
             dt: float) -> dict[str, Callable[[], None]]:
    """
    Return functions that run the filters of filterpy over a recording.

    Args:
        model: drive with the states x1..x4, tau_K.
        std: standard deviations of the encoders [2], rad.
        u: motor torque [N], N m.
        y: encoder readings [N, 2], rad.
        dt: sample time, s.

    Raises:
        InputError: if filterpy is not installed.
    """
    try:
        from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints
        from filterpy.kalman import UnscentedKalmanFilter
    except ImportError:
        raise InputError('filterpy is not installed, expected "pip install filterpy"') from None
    m1, m2, d = model.motor_inertia, model.arm_inertia, model.damping
    cv, cc, alpha = model.viscous_friction, model.coulomb_friction, model.friction_sharpness
    kr = model.position_gain
    R, Q, H = np.diag(np.square(std)), np.diag([1e-6, 1e-6, 1e-4, 1e-4, 0.1]), np.eye(2, 5)

    def f(x: Array, u: float) -> Array:
        """Return d/dt of the state `x` under the motor torque `u`."""
        friction = cv * x[2] + cc * 2.0 / math.pi * math.atan(alpha * x[2])
        return np.array([
            x[2], x[3], (u - d * (x[2] - x[3]) - x[4] - friction - kr * x[0]) / m1,
            (d * (x[2] - x[3]) + x[4]) / m2, 0.0])

    def jacobian(x: Array) -> Array:
        """Return the derivative of f at the state `x`."""
        slope = cv + cc * 2.0 / math.pi * alpha / (1.0 + (alpha * x[2]) ** 2)
        return np.array([
            [0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0],
            [-kr / m1, 0.0, -(d + slope) / m1, d / m1, -1.0 / m1],
            [0.0, 0.0, d / m2, -d / m2, 1.0 / m2], [0.0, 0.0, 0.0, 0.0, 0.0]])

    def move(x: Array, dt: float, u: float = 0.0) -> Array:
        """Return the state `x` after one RK4 step of `dt` s under the motor torque `u`."""
        k1 = f(x, u)
        k2 = f(x + 0.5 * dt * k1, u)
        k3 = f(x + 0.5 * dt * k2, u)
        k4 = f(x + dt * k3, u)
        return x + dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)

    class ExtendedDrive(ExtendedKalmanFilter):
        x: Array

        def predict_x(self, u: float = 0.0) -> None:
            """Predict the mean with the motor torque `u`."""
            self.x = move(self.x, dt, u)

    def initialised(kf: Any) -> Any:
        """Set the start of the filter `kf` and return it."""
        kf.x, kf.P, kf.R, kf.Q = np.zeros(5), np.eye(5), R, Q
        return kf

    def ekf() -> None:
        kf = initialised(ExtendedDrive(5, 2))
        for k in range(1, len(u)):
            a = jacobian(kf.x)
            kf.F = np.eye(5) + dt * a + 0.5 * dt * dt * a @ a
            kf.predict(u[k - 1])
            kf.update(y[k], lambda x: H, lambda x: x[:2])

    def ukf() -> None:
        kf = initialised(UnscentedKalmanFilter(5, 2, dt, lambda x: x[:2], move,
                                               MerweScaledSigmaPoints(5, 1.0, 2.0, 0.0)))
        for k in range(1, len(u)):
            kf.predict(u=u[k - 1])
            kf.update(y[k])

    return {'filterpy EKF': ekf, 'filterpy UKF': ukf}
