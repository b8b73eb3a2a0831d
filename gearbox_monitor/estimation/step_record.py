# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The step record: what every filter writes at every step, and all that trust and smoother read.

One float64 row: z_pred [n], P_pred [n, n], C [n, n], z [n], P [n, n], innovation [2], S (s11,
s12, s22), K [n, 2], nis, loglik, dof. C = cov(z_k+1 predicted, z_k), for an EKF Phi P. An absent
measurement has an innovation of NaN and a zero column of K; dof counts the measurements used.
Behind it, where the model has tolerances (see consider), stand the sensitivities, each [c, n]:
predicted, updated and, behind a smoother, smoothed. Last of all the stream notes the motor torque
that acted over the step.
"""
from gearbox_monitor.kernels.kernel import inline, kernel
from gearbox_monitor.kernels.types import Array


@kernel
def record_size(n: int, considered: int = 0) -> int:
    """Return the length of a step record with `n` states and as many sensitivities as stated."""
    return 4 * n + 3 * n * n + 9 + 3 * n * considered


@inline
def sensitivities(n: int, length: int) -> tuple[int, int, int, int]:
    """
    Return the number of sensitivities, and the places of the predicted, updated, smoothed ones.

    Args:
        n: number of states.
        length: of the record.

    """
    begin = 4 * n + 3 * n * n + 8
    size = (length - begin - 1) // 3
    return size // n, begin, begin + size, begin + 2 * size


@inline
def places(n: int) -> tuple[int, int, int, int, int, int, int, int, int]:
    """
    Return the places of z_pred, P_pred, C, z, P, innovation, S, K and (nis, loglik, dof).

    n: number of states. For kernels, which index the record itself.
    """
    m = n * n
    begin = 2 * n + 3 * m
    return (0, n, n + m, n + 2 * m, 2 * n + 2 * m, begin, begin + 2, begin + 5, begin + 5 + 2 * n)


def predicted(record: Array, n: int) -> tuple[Array, Array, Array]:
    """Return views (z_pred [n], P_pred [n, n], C [n, n]) of the `record` of `n` states."""
    m = n * n
    return (record[:n], record[n:n + m].reshape(n, n), record[n + m:n + 2 * m].reshape(n, n))


def updated(record: Array, n: int) -> tuple[Array, Array]:
    """Return views (z [n], P [n, n]) of the `record` of `n` states."""
    start = n + 2 * n * n
    return record[start:start + n], record[start + n:start + n + n * n].reshape(n, n)


def correction(record: Array, n: int) -> tuple[Array, Array, Array, Array]:
    """
    Return views of the `record` of `n` states.

    innovation [2], S [3] as s11, s12, s22, K [n, 2], [nis, loglik, dof].
    """
    start = 2 * n + 3 * n * n
    return (record[start:start + 2], record[start + 2:start + 5],
            record[start + 5:start + 5 + 2 * n].reshape(n, 2),
            record[start + 5 + 2 * n:start + 8 + 2 * n])
