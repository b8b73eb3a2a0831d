# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Runs of a real drive with a torque sensor, and the fit of model and filter to that sensor.

Encoders are kinematic: without a reference torque, torque constant, inertia, friction and tau_K
share one unknown scale. So everything is fitted on the reference of the training runs, and judged
on runs that no fit has seen.
"""
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import os

import numpy as np
from scipy.optimize import brentq, least_squares

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.filter_kind import Belief, Reading, Scratch
from gearbox_monitor.estimation.filters import ekf
from gearbox_monitor.estimation.process_model import markers, P0, pack, state_names, TAU_K, X1, X2
from gearbox_monitor.estimation.sample_loop import Stream
from gearbox_monitor.estimation.step_record import record_size
from gearbox_monitor.kernels.jit import jit
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import model_from_dict

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
# Held: what the recordings do not tell, or what a fit would only use to chase the step size.
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
    stamps: np.ndarray
    current: np.ndarray
    outputs: np.ndarray
    reference: np.ndarray

    @property
    def period(self):
        """Median sample time, s."""
        return float(np.median(np.diff(self.stamps))) * 1e-9


def configure(values, arm_step, sharpness=SHARPNESS):
    """
    Return (DriveModel, checked estimator parameters) of the fitted `values`.

    arm_step: resolution of the arm encoder (rad). values: names of STARTS, and any of effects
    and the parameters of the estimator.
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
    return model, parameters


def estimate(values, run, arm_step, sharpness=SHARPNESS):
    """Return tau_K and its standard deviation (N m), each [N], of the EKF with these `values`."""
    model, parameters = configure(values, arm_step, sharpness)
    n = len(state_names(model, parameters))
    u = values['torque_constant'] * run.current
    torque, variance = np.zeros(len(u)), np.zeros(len(u))
    p = pack(model, parameters)
    belief = Belief(np.zeros(n), np.diag(p[P0:P0 + n]).ravel(), np.zeros(0))
    scratch = Scratch(np.zeros((1, n)), np.zeros((1, n * n)))
    _filter(markers(p, n), Stream(run.stamps, u, run.outputs), p, belief, scratch,
            np.zeros(record_size(n)), torque, variance)
    return torque, np.sqrt(variance + values.get('tau_k_model_std', 0.0) ** 2)


@jit
def _filter(states, stream, p, belief, scratch, record, torque, variance):
    """Write tau_K and its variance, each [N]; releases the GIL, so that runs go in parallel."""
    n, (stamps, u, outputs), (z, P, _) = len(states), stream, belief
    z[X1], z[X2] = outputs[0, 0], outputs[0, 1]
    variance[0] = P[TAU_K * n + TAU_K]
    for k in range(1, len(stamps)):
        dt = (stamps[k] - stamps[k - 1]) * 1e-9
        reading = Reading(dt, u[k - 1], 0.0, outputs[k, 0], outputs[k, 1])
        if not ekf.step(states, belief, reading, p, scratch, record):
            torque[k:] = np.inf
            break
        torque[k], variance[k] = z[TAU_K], P[TAU_K * n + TAU_K]


def _monitored(values, run, arm_step):
    monitor = Monitor(*configure(values, arm_step))
    motor = values['torque_constant'] * run.current
    u = np.column_stack([motor, np.full_like(motor, np.nan)])
    return monitor.run(Samples(run.stamps, u, run.outputs))


def replay(values, run, arm_step):
    """Return what `estimate` returns, from the Monitor that nodes and replay use."""
    estimates = _monitored(values, run, arm_step)
    torque, std = np.full((2, len(run.stamps)), np.nan)
    at = np.searchsorted(run.stamps, estimates.stamp_ns)
    torque[at], std[at] = estimates.tau_k, estimates.tau_k_std
    return torque, std


def errors(estimator, runs, burn_in):
    """Return [(error [N], standard deviation [N])] against the reference, burn-in left out."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        results = list(pool.map(estimator, runs))
    return [((torque - run.reference)[burn_in:], std[burn_in:])
            for run, (torque, std) in zip(runs, results)]


def rmse(pooled):
    """Return the root mean square of the pooled errors of `errors` (N m)."""
    return float(np.sqrt(np.mean(np.concatenate([e for e, _ in pooled]) ** 2)))


def coverage(pooled, sigmas=1.0):
    """Return the pooled share of errors within `sigmas` stated standard deviations."""
    return float(np.mean(np.concatenate([np.abs(e) < sigmas * s for e, s in pooled])))


def fit(runs, burn_in, arm_step, budget=(12, 12, 16), progress=None):
    """
    Return the values {name: value} with the least pooled error on `runs`.

    Names are those of STARTS, r_std_arm and tau_k_model_std.
    Gauss-Newton in a trust region, at each friction slope of APPROACH with `budget` steps at most.
    progress(done, total) counts passes over the runs. Positive parameters move in their logarithm,
    so no other bound is needed. The error knows only ratios of noises; a common factor then makes
    the mean NIS 2, and tau_k_model_std makes one standard deviation cover what it should.
    """
    names = list(STARTS)
    values = {name: start for name, (start, _) in STARTS.items()}
    scales = [POSITIVE[k][1] if k in POSITIVE else 1.0 for k in names]
    low = [np.log(LEAST_NOISE) if k == 'q_std_tau_k' else -np.inf for k in names]
    done, total = 0, sum(budget) * (1 + len(names))
    largest = max(np.abs(run.reference).max() for run in runs)  # for a filter that diverges

    def residuals(x, sharpness):
        nonlocal done
        done += 1
        if progress:
            progress(min(done, total - 1), total)
        trial = _values(names, x)
        try:
            trial_errors = errors(
                lambda run: estimate(trial, run, arm_step, sharpness), runs, burn_in)
        except InputError:  # outside what a model file admits
            trial_errors = [(np.full(len(run.stamps) - burn_in, largest), None) for run in runs]
        error = np.concatenate([e[::THIN] for e, _ in trial_errors])
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
        [_monitored(values, run, arm_step).nis[burn_in:] for run in runs]))
    for name in values:
        if name.startswith(('q_std', 'r_std')):
            values[name] *= float(np.sqrt(nis / 2.0))
    return {**values, 'tau_k_model_std': _model_std(
        errors(lambda run: estimate(values, run, arm_step), runs, burn_in))}


def _values(names, x):
    with np.errstate(over='ignore'):
        return {k: float(np.exp(v)) if k in POSITIVE else float(v * SIGNED[k][1])
                for k, v in zip(names, x)}


def _model_std(pooled):
    """Return what to add to the standard deviations in quadrature for a coverage of one sigma."""
    def excess(added):
        return coverage([(e, np.hypot(s, added)) for e, s in pooled]) - ONE_SIGMA
    high = 3.0 * rmse(pooled)
    return float(brentq(excess, 0.0, high, xtol=1e-6)) if excess(0.0) < 0.0 else 0.0
