# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The smoothers in the setting in which the filters' errors are known: cases A and B."""
from drives import driven, samples_of
import numpy as np
from scipy.optimize import least_squares

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import (
    LAG, S_TAU_K, S_TAU_K_STD, S_TWIST, smoother_parameters)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise

# Torque curve, encoder noise (rad), standard deviation of the states.
CASES = {
    'A': ({'kind': 'play', 'half_gap': 0.3, 'hysteresis_width': 0.3}, (0.0658, 0.0833),
          (3.29, 4.16, 19.3, 23.9)),
    'B': ({'half_gap': 0.6}, (0.0612, 0.0828), (3.06, 4.14, 17.9, 23.6)),
}
START = 500


def case(name, seconds=20.0, seed=1):
    """Return (model, parameters, Samples, true tau_K, true twist)."""
    curve, encoders, spread = CASES[name]
    model = DriveModel().with_(stiffness=5.0, **curve)
    process = tuple(0.02 * s for s in spread)
    out = driven(model, seconds, Noise(process, encoders), seed)
    names = ('motor_position', 'arm_position', 'motor_speed', 'arm_speed')
    parameters = EstimatorParameters(
        **{f'q_std_{n}': q for n, q in zip(names, process)}, q_std_tau_k=10.0, arm_load='none',
        r_std_motor=encoders[0], r_std_arm=encoders[1])
    return model, parameters, samples_of(out), out.tau_k, out.x[:, 0] - out.x[:, 1]


def rms(values):
    return float(np.sqrt(np.mean(values ** 2)))


def test_a_lag_beyond_what_samples_tell():
    """Twice of it changes less than a fiftieth of the error."""
    for name, bound in (('A', 0.23), ('B', 0.20)):
        model, parameters, samples, tau_k, _ = case(name)
        parameters = smoother_parameters(parameters)
        found, longer = (Estimator(model, parameters.replace(smoother_lag=lag)).run(samples)
                         for lag in (LAG, 2.0 * LAG))
        at = np.searchsorted(samples.stamp_ns, found.smoothed_stamp_ns)
        assert 0.9 * len(tau_k) < len(longer.smoothed) < len(at)
        np.testing.assert_allclose(
            found.smoothed_tau_k[:len(longer.smoothed)], longer.smoothed_tau_k, atol=4e-3)
        error = (found.smoothed_tau_k - tau_k[at])[START:]
        assert rms(error) < bound
        # Somewhat pessimistic: the true tau_K is smoother than a random walk.
        assert 0.68 < np.mean(np.abs(error) < found.smoothed[START:, S_TAU_K_STD]) < 0.97


def test_lag_of_40_ms():
    for name in CASES:
        model, parameters, samples, tau_k, _ = case(name)
        found = Estimator(model, parameters.replace(smoother_lag=0.04)).run(samples)
        at = np.searchsorted(samples.stamp_ns, found.smoothed_stamp_ns)
        assert rms((found.smoothed[:, S_TAU_K] - tau_k[at])[at >= START]) < 0.34


def test_no_false_hysteresis():
    """The filtered loop looks like hysteresis where there is none; the smoothed one does not."""
    model, parameters, samples, _, _ = case('B')

    def width(twist, tau_k):
        way = np.sign(np.gradient(twist))

        def error(x):
            stiffness, half_gap, c = x
            shifted = twist - c * way
            dead = np.sign(shifted) * np.maximum(np.abs(shifted) - half_gap, 0.0)
            return stiffness * dead - tau_k
        return least_squares(error, (5.0, 0.5, 0.05)).x[2]
    filtered = Estimator(model, parameters).run(samples)
    smoothed = Estimator(model, smoother_parameters(parameters)).run(samples).smoothed
    assert width(filtered.twist[START:], filtered.tau_k[START:]) > 0.1
    assert abs(width(smoothed[START:, S_TWIST], smoothed[START:, S_TAU_K])) < 0.01


def test_restarts_and_what_was_not_measured():
    """A long gap splits the recording; one encoder, a refused stamp and a short gap do not."""
    model, parameters, samples, _, _ = case('A', seconds=1.0)
    stamps, y = samples.stamp_ns.copy(), samples.y.copy()
    stamps[500:] += 400_000_000           # longer than max_gap: a restart
    y[100:150, 1] = np.nan
    y[200:220] = np.nan
    stamps[300] = stamps[299]             # refused
    found = Estimator(model, parameters).run(Samples(stamps, samples.u, y))
    codes, at = found.codes, np.searchsorted(stamps, found.smoothed_stamp_ns)
    assert np.isfinite(found.smoothed).all() and 300 not in at and at[-1] > 800
    assert np.count_nonzero(codes == codes[0]) == 2  # starts
    # The parts know nothing of each other.
    alone = Estimator(model, parameters).run(
        Samples(stamps[:500], samples.u[:500], y[:500])).smoothed
    np.testing.assert_array_equal(found.smoothed[at < 500], alone)
