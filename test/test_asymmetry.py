# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Fixtures without symmetry: what belongs to one encoder, test or step is not that of another."""
from types import SimpleNamespace

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.estimation import process_model, sample_loop
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.kernels.types import Layout
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals import checks


def test_noise_at_rest_is_that_of_its_own_encoder():
    stds, rng = np.array([0.002, 0.011]), np.random.default_rng(5)
    y = stds * rng.standard_normal((4000, 2))
    found = checks.noise(1_000_000 * (1 + np.arange(4000)), y, [(s, 0.0) for s in stds], None,
                         stds)
    noises = {line.group: line.values['noise_at_rest_rad'] for line in found
              if line.name == 'noise'}
    assert noises == pytest.approx(dict(zip(checks.NAMES, stds)), rel=0.1)


def test_each_speed_starts_with_the_noise_of_its_own_encoder():
    """Variances of the first step are as large as that of the speed: the weights differ."""
    p = np.zeros(200)
    p[process_model.R1], p[process_model.R2] = 0.02, 0.5
    dt, covariance = 0.3, np.diag([0.01, 0.04, 2.0, 5.0])
    belief = SimpleNamespace(z=np.array([0.1, -0.2, 0.0, 0.0]), P=covariance.ravel())
    reading = SimpleNamespace(y1=0.7, y2=0.5, dt=dt)
    sample_loop.aim(Layout(4, False, -1, False), belief, reading, p)
    assert belief.z[2:] == pytest.approx([2.0 / (2.0 + 0.03 / dt ** 2) * 0.6 / dt,
                                          5.0 / (5.0 + 0.54 / dt ** 2) * 0.7 / dt], rel=1e-12)


def test_the_smoother_waits_for_its_lag_and_not_for_a_sample_more():
    dt_ns, lag, n = 3_000_000, 0.1, 200
    dt = dt_ns * 1e-9
    u = Excitation().torque(dt * np.arange(n))
    y = simulate(DriveModel(), u, dt, Noise(measurement=(1e-3, 4e-3)), seed=2).y
    stamps = 1_000_000_000 + dt_ns * np.arange(n)
    estimator = Estimator(DriveModel(), EstimatorParameters(smoother_lag=lag))
    newest = []

    def judge(batch):
        if len(batch.smoothed_stamps):
            newest.append((batch.stamp_ns, int(batch.smoothed_stamps[-1])))

    samples = Samples(stamps, np.column_stack([u, np.full(n, np.nan)]), y)
    for k in range(n):
        estimator.run(Samples(samples.stamp_ns[k:k + 1], samples.u[k:k + 1],
                              samples.y[k:k + 1]), judge)
    assert len(newest) > 3
    lags = {now - smoothed for now, smoothed in newest[1:]}
    assert lags == {-(-round(lag * 1e9) // dt_ns) * dt_ns}


def test_an_effect_pays_the_whole_penalty_of_schwarz():
    evidence = SimpleNamespace(fine=SimpleNamespace(readings=700))
    fit = SimpleNamespace(deviance=31.0, candidate=SimpleNamespace(n_effect=3))
    assert DriveRecordings.score(evidence, fit) == pytest.approx(31.0 + 3.0 * np.log(700.0))
