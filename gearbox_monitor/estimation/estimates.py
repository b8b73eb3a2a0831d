# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What goes into an Estimator and what comes out of it: samples, estimates, divergences."""
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import rts_smoother, sample_loop
from gearbox_monitor.estimation.process_model import X2, X4
from gearbox_monitor.estimation.rts_smoother import (
    S_TWIST, S_TWIST_RATE, S_TWIST_RATE_STD, S_TWIST_STD, S_X2, S_X4)
from gearbox_monitor.kernels.types import Array, Integers, table
from gearbox_monitor.presentation import Shown

# Columns that mean nothing without an arm encoder.
ARM_COLUMNS = [sample_loop.E_X2, sample_loop.E_X4, sample_loop.E_TWIST, sample_loop.E_TWIST_RATE,
               sample_loop.E_TWIST_STD, sample_loop.E_TWIST_RATE_STD,
               sample_loop.E_STD + X2, sample_loop.E_STD + X4]
SMOOTHED_ARM_COLUMNS = [S_TWIST, S_TWIST_RATE, S_TWIST_STD, S_TWIST_RATE_STD, S_X2, S_X4]
# Name of a column of an estimate row -> its place.
COLUMNS = {name[2:].lower(): value for name, value in vars(sample_loop).items()
           if name.startswith('E_') and name != 'E_STD'}
COLUMNS.update({f'{name}_std': sample_loop.E_STD + i for i, name in enumerate(
    ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_arm', 'tau_e'))})

SMOOTHED_COLUMNS = {f'smoothed_{name[2:].lower()}': value
                    for name, value in vars(rts_smoother).items() if name.startswith('S_')}


@dataclass(frozen=True)
class Sample:
    """
    One stamped measurement; NaN = not measured.

    stamp_ns: int. u: (motor torque, measured load on the arm), N m. y: (motor, arm) position, rad
    on the arm side. joints: positions of all joints of a robot, in the order of its description,
    where that gives the load on the arm.
    """

    stamp_ns: int
    u: tuple[float, float]
    y: tuple[float, float]
    joints: tuple[float, ...] = ()


@dataclass(frozen=True)
class Samples:
    """N samples as arrays: stamp_ns int64 [N], u, y [N, 2], joints [N, n]; see Sample."""

    stamp_ns: Integers
    u: Array
    y: Array
    joints: Array | None = None


@dataclass(frozen=True, repr=False)
class Estimates(Shown):
    """
    M estimates: stamp_ns int64 [M], rows [M, sample_loop.N_ESTIMATE] (columns sample_loop.E_*).

    smoothed_stamp_ns int64 [L], smoothed [L, N_SMOOTHED] (columns rts_smoother.S_*). codes
    int64 [N]: what became of each input sample (sample_loop.ESTIMATE, START, a refusal ...).
    """

    stamp_ns: Integers
    rows: Array
    smoothed_stamp_ns: Integers
    smoothed: Array
    codes: Integers

    def __getattr__(self, name: str) -> Array:
        """
        Give columns by `name`: e.tau_k, e.tau_k_std, e.nis, e.x1, e.innovation_motor ...

        Those of `smoothed` begin with smoothed_: e.smoothed_tau_k, e.smoothed_twist ...
        """
        if name in COLUMNS:
            return self.rows[:, COLUMNS[name]]
        if name in SMOOTHED_COLUMNS:
            return self.smoothed[:, SMOOTHED_COLUMNS[name]]
        raise AttributeError(name)


class Estimate(NamedTuple):
    """
    The estimate of one accepted sample.

    x [n] state (see process_model) and P [n, n]; row: all columns (sample_loop.E_*), also by name:
    tau_k and tau_k_std (N m), nis with dof degrees of freedom ...; smoothed: pairs (stamp_ns, row
    [N_SMOOTHED] with columns rts_smoother.S_*) that the fixed-lag smoother completed.
    """

    stamp_ns: int
    x: Array
    P: Array
    row: Array
    smoothed: tuple[tuple[int, Array], ...]

    @property
    def innovation(self) -> Array:
        """Innovation y - yhat of motor and arm, [2] rad; NaN = not measured."""
        return self.row[[sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM]]

    @property
    def S(self) -> Array:
        """Covariance of the innovation, [2, 2] rad^2."""
        motor, arm, both = self.row[[sample_loop.E_INNOVATION_STD_MOTOR,
                                     sample_loop.E_INNOVATION_STD_ARM,
                                     sample_loop.E_INNOVATION_COVARIANCE]]
        return np.array([[motor ** 2, both], [both, arm ** 2]])

    def __getattr__(self, name: str) -> Any:
        """Give columns by `name`, as Estimates does."""
        column = COLUMNS.get(name)
        if column is None:
            raise AttributeError(name)
        return self.row[column]


class Batch(NamedTuple):
    """
    What a run of the sample loop gave up to its stop: M estimates and L smoothed rows.

    stamp_ns and code: of the last sample, which may have been refused. The arrays are as in
    Estimates.
    """

    stamp_ns: int
    code: int
    stamps: Integers
    rows: Array
    smoothed_stamps: Integers
    smoothed: Array


@dataclass(frozen=True)
class Divergence:
    """
    A failure of the filter, which then restarts.

    step: since the (re)start; smallest_eigenvalue: of the covariance, NaN where it is not finite.
    """

    step: int
    stamp_ns: int
    reason: str
    smallest_eigenvalue: float

    def __str__(self) -> str:
        return (f'the filter diverged at step {self.step}, stamp {self.stamp_ns * 1e-9:.9f} s: '
                f'{self.reason} (smallest eigenvalue {self.smallest_eigenvalue:.3g})')


def checked(samples: Samples) -> tuple[Integers, Array, Array]:
    """Return (stamps [N], u [N, 2], y [N, 2]) of `samples`. Raises InputError for others."""
    if not isinstance(samples, Samples):
        raise InputError(f'samples: {type(samples).__name__} {str(samples)[:40]!r}, expected '
                         'Samples')
    stamps = np.asarray(samples.stamp_ns)
    if stamps.ndim != 1 or stamps.dtype.kind not in 'iu':
        raise InputError(f'stamp_ns: {stamps.dtype} of shape {stamps.shape}, expected whole '
                         'numbers of ns [N]')
    n = len(stamps)
    return (np.ascontiguousarray(stamps, np.int64), np.ascontiguousarray(table(
        samples.u, 'u', 'torque of the motor and load on the arm, N m', n)),
        np.ascontiguousarray(table(samples.y, 'y', 'motor and arm position, rad', n)))
