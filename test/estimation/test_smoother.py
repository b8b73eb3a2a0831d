# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The smoothers in the setting in which the filters' errors are known: cases A and B."""
import numpy as np
from scipy.optimize import least_squares

from gearbox_monitor.estimation import interval_smoother
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.interval_smoother import smooth_interval
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_STD, S_TWIST, smoother_parameters)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

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
    u = Excitation().torque(np.arange(round(1e3 * seconds)) * 1e-3)
    out = simulate(model, u, 1e-3, Noise(process, encoders), seed)
    stamps = (1 + np.arange(len(u), dtype=np.int64)) * 1_000_000
    names = ('motor_position', 'arm_position', 'motor_speed', 'arm_speed')
    parameters = EstimatorParameters(
        **{f'q_std_{n}': q for n, q in zip(names, process)}, q_std_tau_k=10.0, arm_load='none',
        r_std_motor=encoders[0], r_std_arm=encoders[1])
    return (model, parameters,
            Samples(stamps, np.column_stack([u, np.full_like(u, np.nan)]), out.y), out.tau_k,
            out.x[:, 0] - out.x[:, 1])


def rms(values):
    return float(np.sqrt(np.mean(values ** 2)))


def test_whole_recording():
    for name, bound in (('A', 0.23), ('B', 0.20)):
        model, parameters, samples, tau_k, _ = case(name)
        found = smooth_interval(model, smoother_parameters(parameters), samples)
        np.testing.assert_array_equal(found.stamp_ns, samples.stamp_ns)
        error = (found.rows[:, S_TAU_K] - tau_k)[START:]
        assert rms(error) < bound
        # Somewhat pessimistic: the true tau_K is smoother than a random walk.
        assert 0.68 < np.mean(np.abs(error) < found.rows[START:, S_TAU_K_STD]) < 0.97


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
    smoothed = smooth_interval(model, smoother_parameters(parameters), samples).rows
    assert width(filtered.twist[START:], filtered.tau_k[START:]) > 0.1
    assert abs(width(smoothed[START:, S_TWIST], smoothed[START:, S_TAU_K])) < 0.01


def test_blocks_do_not_show(monkeypatch):
    model, parameters, samples, _, _ = case('A', seconds=0.4)
    whole = smooth_interval(model, parameters, samples).rows
    for block in (1, 77, 399):
        monkeypatch.setattr(interval_smoother, 'BLOCK', block)
        np.testing.assert_array_equal(smooth_interval(model, parameters, samples).rows, whole)
    # With a lag beyond its length the fixed-lag smoother sees the same future.
    live = Estimator(model, parameters.replace(smoother_lag=0.1)).run(samples)
    assert len(live.smoothed) and np.abs(live.smoothed[:, S_TWIST] - whole[
        :len(live.smoothed), S_TWIST]).max() < 0.02


def test_restarts_and_what_was_not_measured():
    """A long gap splits the recording; one encoder, a refused stamp and a short gap do not."""
    model, parameters, samples, _, _ = case('A', seconds=1.0)
    stamps, y = samples.stamp_ns.copy(), samples.y.copy()
    stamps[500:] += 400_000_000           # longer than max_gap: a restart
    y[100:150, 1] = np.nan
    y[200:220] = np.nan
    stamps[300] = stamps[299]             # refused
    found = smooth_interval(model, parameters, Samples(stamps, samples.u, y))
    accepted = Estimator(model, parameters)
    codes = accepted.run(Samples(stamps, samples.u, y)).codes
    assert len(found.stamp_ns) == len(found.rows) < len(stamps)
    assert np.isfinite(found.rows).all() and 300 not in np.searchsorted(stamps, found.stamp_ns)
    assert np.count_nonzero(codes == codes[0]) == 2  # starts
    # The parts know nothing of each other.
    end = np.searchsorted(found.stamp_ns, stamps[499]) + 1
    alone = smooth_interval(model, parameters, Samples(stamps[:500], samples.u[:500], y[:500]))
    np.testing.assert_array_equal(found.rows[:end], alone.rows)
    empty = smooth_interval(model, parameters, Samples(
        stamps[:0], samples.u[:0], y[:0]))
    assert empty.rows.shape == (0, found.rows.shape[1])
