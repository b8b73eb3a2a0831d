# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What makes a module of estimation/filters a filter, and how it is found by its name.

The step record is what every filter writes at every step, and all that trust and smoother read.
One float64 row: z_pred [n], P_pred [n, n], C [n, n], z [n], P [n, n], innovation [2], S (s11,
s12, s22), K [n, 2], nis, loglik, dof. C = cov(z_k+1 predicted, z_k), for an EKF Phi P. An absent
measurement has an innovation of NaN and a zero column of K; dof counts the measurements used.
Behind it, where the model has tolerances (see consider), stand the sensitivities, each [c, n]:
predicted, updated and, behind a smoother, smoothed. Last of all the stream notes the motor torque
that acted over the step.
"""
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import NamedTuple

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.estimation import filters
from gearbox_monitor.kernels.kernel import inline, kernel
from gearbox_monitor.kernels.types import Array, Layout, Matrix, Vector
from gearbox_monitor.parameters import EstimatorParameters, FILTER_NAMES, RANDOM_WALK


class Belief(NamedTuple):
    """
    What a filter knows of the state; its arrays are changed in place.

    z [n]: mean; P [n * n]: covariance, by rows; memory [memory_size(n)]: whatever else the filter
    carries, all zero at a start and after a change of parameters, then to be made from z, P and p.
    """

    z: Vector
    P: Vector
    memory: Vector


class Reading(NamedTuple):
    """
    What a step is given.

    dt: time since the last step, s. u, load: motor torque and known load on the arm over that
    time, N m. y1, y2: motor and arm position at its end, rad; NaN = not measured.
    """

    dt: float
    u: float
    load: float
    y1: float
    y2: float


class Scratch(NamedTuple):
    """Room for intermediate results: vectors [n_vectors, n] and matrices [n_matrices, n * n]."""

    vectors: Matrix
    matrices: Matrix


# Of (states, belief, reading, p, scratch, record); see filters.ekf.step.
Step = Callable[[Layout, Belief, Reading, Array, Scratch, Array], bool]


class Adaptation(NamedTuple):
    """
    What an adaptive filter tells of its memory and p (process_model.pack).

    values: {parameter: value in use}. packed: the packed parameters of the next step. at_bound:
    the adapted parameters at the bound of their range. guards: {guard: how often it acted}, of
    the memory alone.
    """

    values: Callable[[Array, Array], dict[str, float]]
    packed: Callable[[Array, Array], Array]
    at_bound: Callable[[Array, Array], list[str]]
    guards: Callable[[Array], dict[str, int]]


@inline
def unchanged(memory: Array, p: Array) -> Array:
    """Return `p`, whatever the `memory` of the filter holds."""
    return p


@inline
def forget(memory: Array) -> None:
    """Clear the `memory` at a start."""
    memory[:] = 0.0


@dataclass(frozen=True)
class FilterKind:
    """
    A filter as the sample loop and the Estimator use it.

    step: kernel of one step, see filters.ekf.step. n_vectors, n_matrices: the Scratch it needs.
    memory_size: of the number of states, how many numbers it carries besides z and P. resume:
    kernel that prepares this memory for a start. in_use: kernel of the memory and p
    (process_model.pack): the packed parameters in use. warnings: of the number of states and the
    parameters, sentences for the user. adaptation: of an adaptive filter, else None.
    tau_k_models: the laws of tau_K that it can take, see estimation.torque_model.
    """

    step: Step
    n_vectors: int = 1
    n_matrices: int = 1
    memory_size: Callable[[int], int] = lambda n: 0
    resume: Callable[[Array], None] = forget
    in_use: Callable[[Array, Array], Array] = unchanged
    warnings: Callable[[int, EstimatorParameters], list[str]] = lambda n, parameters: []
    adaptation: Adaptation | None = None
    tau_k_models: tuple[str, ...] = (RANDOM_WALK,)


@cache
def filter_kind(name: str) -> FilterKind:
    """Return the filter called `name`, one of FILTER_NAMES. Raises InputError."""
    if name not in FILTER_NAMES:
        raise InputError(f'filter: {name!r}, {unknown(name, FILTER_NAMES)}')
    kind: FilterKind = import_module(f'{filters.__name__}.{name}').FILTER
    return kind


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
    size = max(length - begin - 1, 0) // 3
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
