# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Runs of a real drive with a torque sensor, and the fit of model and filter to that sensor.

Encoders are kinematic: without a reference torque, torque constant, inertia, friction and tau_K
share one unknown scale. So everything is fitted on the reference of the training runs, and judged
on runs that no fit has seen.
"""
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import os
from typing import TypeAlias

import numpy as np
from scipy.optimize import brentq, least_squares

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.filter_kind import Belief, Reading, record_size, Scratch
from gearbox_monitor.estimation.filters import ekf
from gearbox_monitor.estimation.filters.ukf import N_LANES
from gearbox_monitor.estimation.process_model import (
    layout_of, P0, pack, state_names, TAU_K, X1, X2)
from gearbox_monitor.estimation.sample_loop import Stream
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.types import Array, Integers, Layout, Vector
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, model_from_dict

# tau_K and its standard deviation, N m; or an error of tau_K and the deviation stated for it.
TorqueAndDeviation: TypeAlias = tuple[Array, Array]

# Parameters that the fit moves: start and scale, relative where the parameter is positive (and
# moved in its logarithm), absolute where it may have either sign.
POSITIVE = {
    'torque_constant': (1.0, 0.1),        # N m per A, at the output
    'motor_inertia': (1e-3, 0.4),         # kg m^2
    'coulomb_friction': (0.02, 0.3),      # N m
    'q_std_motor_speed': (0.2, 0.6),      # rad/s/sqrt(s)
    'q_std_arm_speed': (3.0, 0.6),        # rad/s/sqrt(s)
    'q_std_tau_k': (0.03, 1.0),           # N m/sqrt(s)
    'q_std_tau_k_speed': (0.03, 1.0),     # N m/sqrt(s) per rad/s
    'r_std_motor': (3e-4, 0.8),           # rad
    'tau_k_stiffness': (1.0, 0.6),        # N m/rad
}
SIGNED = {
    'viscous_friction': (0.0, 2e-3),      # N m s/rad; friction can fall with speed
    'torque_offset': (0.0, 4e-3),         # N m; the sensor's zero
}
STARTS = {**POSITIVE, **SIGNED}
# Fixed: recordings do not identify these, or a fit would only use them to fit the step size.
ARM_INERTIA = 5e-3                        # kg m^2
STIFFNESS = 3.0                           # N m/rad; only in the choice of substeps
SHARPNESS = 1000.0                        # s/rad
# The fit approaches it: soft friction leads from a poor start, and costs a third of the time.
APPROACH = (100.0, 300.0, SHARPNESS)
# The fit would send it to zero, and what does nothing there wanders off for good.
LEAST_NOISE = 1e-4                        # N m/sqrt(s)
DIFFERENCE = 0.02                         # step of the fit's derivatives, relative
THIN = 4                                  # every so many samples of the errors enter the fit
ONE_SIGMA = 0.6827
MODEL_KEYS = ('motor_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset',
              'effects')


@dataclass(frozen=True)
class DriveRecording:
    """One recording: stamps int64 [N] ns, current [N] A, outputs [N, 2] rad, reference [N] N m."""

    name: str
    stamps: Integers
    current: Array
    outputs: Array
    reference: Array

    @property
    def period(self) -> float:
        """Median sample time, s."""
        return float(np.median(np.diff(self.stamps))) * 1e-9


def configure(values: Mapping[str, float], arm_step: float,
              sharpness: float = SHARPNESS) -> tuple[DriveModel, EstimatorParameters]:
    """
    Return the model of the drive and the parameters of the filter for fitted values.

    Args:
        values: value by name of STARTS; also effects and any parameter of the estimator.
        arm_step: resolution of the arm encoder, rad.
        sharpness: slope of Coulomb friction at rest, s/rad.

    Returns:
        The drive and the checked parameters of the estimator.

    Raises:
        InputError: if a value is outside its permitted range.
    """
    model = model_from_dict({
        **{k: values[k] for k in MODEL_KEYS if k in values}, 'arm_inertia': ARM_INERTIA,
        'damping': 0.0, 'friction_sharpness': sharpness, 'position_gain': 0.0, 'arm_load': 'none',
        'transmission': {'kind': 'dead_zone', 'stiffness': STIFFNESS, 'half_gap': 0.01},
    }, 'real drive')
    estimator_values = {k: v for k, v in values.items()
                        if k not in MODEL_KEYS and k != 'torque_constant'}
    parameters = EstimatorParameters.from_mapping({
        'r_std_arm': arm_step / np.sqrt(12.0), **estimator_values, 'arm_load': 'none',
        'smoother_lag': 0.0,
        'p0_std_speed': 0.1, 'p0_std_torque': 0.03}, 'real drive')
    return model.exact(), parameters


def estimate(values: Mapping[str, float], run: DriveRecording, arm_step: float,
             sharpness: float = SHARPNESS) -> TorqueAndDeviation:
    """
    Estimate the torque of a recording with the EKF alone.

    Args:
        values: as of configure().
        run: the recording, N samples.
        arm_step: resolution of the arm encoder, rad.
        sharpness: slope of Coulomb friction at rest, s/rad.

    Returns:
        tau_K and its standard deviation [N], N m; infinite from a divergence on.
    """
    model, parameters = configure(values, arm_step, sharpness)
    n = len(state_names(model, parameters))
    u = values['torque_constant'] * run.current
    torque, variance = np.zeros(len(u)), np.zeros(len(u))
    p = pack(model, parameters)
    belief = Belief(np.zeros(n), np.diag(p[P0:P0 + n]).ravel(), np.zeros(0))
    scratch = Scratch(np.zeros((1, n)), np.zeros((1 + N_LANES, n * n)))
    _filter(layout_of(p, n), Stream(run.stamps, np.column_stack([u, u]), run.outputs), p,
            belief, scratch, np.zeros(record_size(n)), torque, variance)
    return torque, np.sqrt(variance + values.get('tau_k_model_std', 0.0) ** 2)


@entry
def _filter(layout: Layout, stream: Stream, p: Vector, belief: Belief, scratch: Scratch,
            record: Vector, torque: Vector, variance: Vector) -> None:
    """Write tau_K and its variance, each [N]; releases the GIL, so that runs go in parallel."""
    n, (stamps, u, outputs), (z, P, _) = layout.n, stream, belief
    z[X1], z[X2] = outputs[0, 0], outputs[0, 1]
    variance[0] = P[TAU_K * n + TAU_K]
    for k in range(1, len(stamps)):
        dt = (stamps[k] - stamps[k - 1]) * 1e-9
        reading = Reading(dt, u[k - 1, 0], 0.0, outputs[k, 0], outputs[k, 1])
        if not ekf.step(layout, belief, reading, p, scratch, record):
            torque[k:] = np.inf
            break
        torque[k], variance[k] = z[TAU_K], P[TAU_K * n + TAU_K]


def _estimates(model: DriveModel, parameters: EstimatorParameters, constant: float,
               run: DriveRecording) -> Estimates:
    monitor = Monitor(model, parameters)
    motor = constant * run.current
    u = np.column_stack([motor, np.full_like(motor, np.nan)])
    return monitor.run(Samples(run.stamps, u, run.outputs))


def replay(values: Mapping[str, float], run: DriveRecording,
           arm_step: float) -> TorqueAndDeviation:
    """
    Estimate the torque of a recording with the Monitor that nodes and replay use.

    Args:
        values: as of configure().
        run: the recording, N samples.
        arm_step: resolution of the arm encoder, rad.

    Returns:
        tau_K and its standard deviation [N], N m; NaN without an estimate.
    """
    return monitored(*configure(values, arm_step), values['torque_constant'], run)


def monitored(model: DriveModel, parameters: EstimatorParameters, constant: float,
              run: DriveRecording) -> TorqueAndDeviation:
    """
    Estimate the torque of a recording with a Monitor.

    Args:
        model: of the drive.
        parameters: of the estimator.
        constant: torque per current, N m/A.
        run: the recording, N samples.

    Returns:
        tau_K and its standard deviation [N], N m; NaN without an estimate.
    """
    estimates = _estimates(model, parameters, constant, run)
    torque, std = np.full((2, len(run.stamps)), np.nan)
    at = np.searchsorted(run.stamps, estimates.stamp_ns)
    torque[at], std[at] = estimates.tau_k, estimates.tau_k_std
    return torque, std


def errors(estimator: Callable[[DriveRecording], TorqueAndDeviation],
           runs: Sequence[DriveRecording], burn_in: int) -> list[TorqueAndDeviation]:
    """
    Compare estimates with the torque sensor, one thread per run.

    Args:
        estimator: returns tau_K and its standard deviation for a recording.
        runs: recordings with a reference.
        burn_in: samples at the start of each run that do not count.

    Returns:
        Error and stated standard deviation [N - burn_in] of each run, N m.
    """
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        results = list(pool.map(estimator, runs))
    return [((torque - run.reference)[burn_in:], std[burn_in:])
            for run, (torque, std) in zip(runs, results)]


def rmse(pooled: Sequence[TorqueAndDeviation]) -> float:
    """Return the root mean square of the `pooled` errors of errors(), N m."""
    return float(np.sqrt(np.mean(np.concatenate([e for e, _ in pooled]) ** 2)))


def coverage(pooled: Sequence[TorqueAndDeviation], sigmas: float = 1.0) -> float:
    """Return the share of `pooled` errors within `sigmas` stated standard deviations."""
    return float(np.mean(np.concatenate([np.abs(e) < sigmas * s for e, s in pooled])))


def fit(runs: Sequence[DriveRecording], burn_in: int, arm_step: float,
        budget: Sequence[int] = (12, 12, 16),
        progress: Callable[[int, int], None] | None = None) -> dict[str, float]:
    """
    Fit the drive and the filter to the torque sensor: least pooled squared error.

    Trust-region Gauss-Newton over a sequence of friction slopes (APPROACH). Positive parameters
    are fitted as logarithms and need no bounds. The error depends only on ratios of noises:
    afterwards a common factor makes the mean NIS 2, and tau_k_model_std makes the pooled coverage
    of one standard deviation 68 %.

    Args:
        runs: training runs with a reference.
        burn_in: samples at the start of each run that do not count.
        arm_step: resolution of the arm encoder, rad.
        budget: most steps of the optimiser at each slope of APPROACH.
        progress: called with the numbers of passes over the runs: done, and in all.

    Returns:
        Value by name: those of STARTS, r_std_arm and tau_k_model_std.
    """
    names = list(STARTS)
    values = {name: start for name, (start, _) in STARTS.items()}
    scales = [POSITIVE[k][1] if k in POSITIVE else 1.0 for k in names]
    low = [np.log(LEAST_NOISE) if k == 'q_std_tau_k' else -np.inf for k in names]
    done, total = 0, sum(budget) * (1 + len(names))
    largest = max(np.abs(run.reference).max() for run in runs)  # for a filter that diverges

    def residuals(x: Array, sharpness: float) -> Array:
        """Return the scaled errors with the vector `x` at a friction slope of `sharpness`."""
        nonlocal done
        done += 1
        if progress:
            progress(min(done, total - 1), total)
        trial = _values(names, x)
        try:
            trial_errors = [error for error, _ in errors(
                lambda run: estimate(trial, run, arm_step, sharpness), runs, burn_in)]
        except InputError:  # outside the range that a model file permits
            trial_errors = [np.full(len(run.stamps) - burn_in, largest) for run in runs]
        error = np.concatenate([e[::THIN] for e in trial_errors])
        return np.nan_to_num(error, nan=largest, posinf=largest, neginf=largest) / largest

    for sharpness, steps in zip(APPROACH, budget):
        x0 = np.array([np.log(values[k]) if k in POSITIVE else values[k] / SIGNED[k][1]
                       for k in names])
        values = _values(names, least_squares(
            residuals, x0, bounds=(low, np.inf), diff_step=DIFFERENCE, x_scale=scales,
            max_nfev=steps, args=(sharpness,)).x)
    if progress:
        progress(total, total)
    values['r_std_arm'] = arm_step / np.sqrt(12.0)
    nis = np.mean(np.concatenate(
        [_estimates(*configure(values, arm_step), values['torque_constant'], run).nis[burn_in:]
         for run in runs]))
    for name in values:
        if name.startswith(('q_std', 'r_std')):
            values[name] *= float(np.sqrt(nis / 2.0))
    return {**values, 'tau_k_model_std': _model_std(
        errors(lambda run: estimate(values, run, arm_step), runs, burn_in))}


def _values(names: Sequence[str], x: Array) -> dict[str, float]:
    with np.errstate(over='ignore'):
        return {k: float(np.exp(v)) if k in POSITIVE else float(v * SIGNED[k][1])
                for k, v in zip(names, x)}


def _model_std(pooled: Sequence[TorqueAndDeviation]) -> float:
    """Return the deviation (N m) whose addition in quadrature gives a coverage of one sigma."""
    def excess(model_std: float) -> float:
        """Return the coverage with `model_std` added, less that of one sigma."""
        return coverage([(e, np.hypot(s, model_std)) for e, s in pooled]) - ONE_SIGMA
    high = 3.0 * rmse(pooled)
    return float(brentq(excess, 0.0, high, xtol=1e-6)) if excess(0.0) < 0.0 else 0.0
