# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
An independent extended Kalman filter in plain numpy, written from the equations.

It imports nothing from the package, so that an error there cannot hide here. The tangent of the
RK4 step comes from complex steps, not from variational equations.
"""
import math

import numpy as np


def arctangent(v):
    """Arctangent of a complex number near the real axis, to first order in its imaginary part."""
    return math.atan(v.real) + 1j * v.imag / (1.0 + v.real ** 2)


def sine(v):
    """Sine of a complex number near the real axis, to first order in its imaginary part."""
    return math.sin(v.real) + 1j * v.imag * math.cos(v.real)


def derivative(z, u, load, c):
    """
    Equations (1), (2), with tau_K as state 4 and optional states for load and friction error.

    c: dict of constants; c['load_at'], c['friction_at'] are indices or None.
    """
    x1, x2, x3, x4, tau = z[:5]
    load = (load + c.get('TL', 0.0) + c.get('Cav', 0.0) * x4 + c.get('G', 0.0) * sine(
                x2 + c.get('phi', 0.0))
            + c.get('Cac', 0.0) * 2.0 / math.pi * arctangent(c['alpha'] * x4))
    friction = c['Cv'] * x3 + c['Cc'] * 2.0 / math.pi * arctangent(c['alpha'] * x3)
    out = np.zeros_like(z)
    if c.get('load_at'):
        load = load + z[c['load_at']]
    if c.get('friction_at'):
        friction = friction + z[c['friction_at']]
        out[c['friction_at']] = -z[c['friction_at']] / c['T']
    out[0], out[1] = x3, x4
    out[2] = (u - c['D'] * (x3 - x4) - tau - friction - c['Kr'] * x1) / c['m1']
    out[3] = (c['D'] * (x3 - x4) + tau - load) / c['m2']
    out[4] = c.get('k_p', 0.0) * (x3 - x4)
    return out


def rk4(z, u, load, dt, substeps, c):
    """Advance complex `z` by `dt` s."""
    h = dt / substeps
    for _ in range(substeps):
        k1 = derivative(z, u, load, c)
        k2 = derivative(z + 0.5 * h * k1, u, load, c)
        k3 = derivative(z + 0.5 * h * k2, u, load, c)
        k4 = derivative(z + h * k3, u, load, c)
        z = z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return z


def flow(z, u, load, dt, substeps, c):
    """Return (advanced state, exact tangent) by complex steps."""
    n, step = len(z), 1e-30
    columns = [rk4(z + 1j * step * np.eye(n)[i], u, load, dt, substeps, c) for i in range(n)]
    return columns[0].real, np.stack([column.imag / step for column in columns], axis=1)


def ekf(start, inputs, y, noise, substeps, c):
    """
    Run the filter from `start` (z, P) with `inputs` (dts, u, load) [N]; NaN in y = missing.

    noise: (spectral densities [n], variances [2]).

    Returns (z [N, n], P [N, n, n], innovation [N, 2], nis [N], z_pred, P_pred, Phi).
    """
    rows, (dts, u, load), (Q, R) = ([], [], [], [], [], [], []), inputs, noise
    z, P, half = *(np.array(a, float) for a in start), 0.5 * np.diag(Q)
    for k, dt in enumerate(dts):
        z, phi = flow(z, u[k], load[k], dt, substeps, c)
        P = phi @ (P + half * dt) @ phi.T + half * dt
        z_pred, P_pred = z, P
        seen = np.flatnonzero(np.isfinite(y[k]))
        H = np.eye(len(z))[seen]
        e = y[k] - z[:2]
        S = H @ P @ H.T + np.diag(R)[np.ix_(seen, seen)]
        K = P @ H.T @ np.linalg.inv(S)
        z = z + K @ e[seen]
        P = P - K @ S @ K.T
        P = 0.5 * (P + P.T)
        nis = float(e[seen] @ np.linalg.solve(S, e[seen])) if len(seen) else 0.0
        for row, value in zip(rows, (z, P, e, nis, z_pred, P_pred, phi)):
            row.append(value)
    return tuple(np.array(row) for row in rows)


def rts(z, P, z_pred, P_pred, phi):
    """Rauch-Tung-Striebel over the output of ekf; cov(z_k+1, z_k) = Phi P_k. Returns (z, P)."""
    z, P = z.copy(), P.copy()
    for k in range(len(z) - 2, -1, -1):
        G = P[k] @ phi[k + 1].T @ np.linalg.inv(P_pred[k + 1])
        z[k] = z[k] + G @ (z[k + 1] - z_pred[k + 1])
        P[k] = P[k] + G @ (P[k + 1] - P_pred[k + 1]) @ G.T
    return z, P


def correction(record, n):
    """
    Return views of the `record` of `n` states.

    innovation [2], S [3] as s11, s12, s22, K [n, 2], [nis, loglik, dof].
    """
    start = 2 * n + 3 * n * n
    return (record[start:start + 2], record[start + 2:start + 5],
            record[start + 5:start + 5 + 2 * n].reshape(n, 2),
            record[start + 5 + 2 * n:start + 8 + 2 * n])
