# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A filter that starts while the drive moves: accurate, or with a large stated deviation."""
import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate


FILTERS = [
    ('ekf', 'none'), ('aekf', 'none'), ('ekf', 'unknown'), ('ukf', 'unknown'),
    ('srukf', 'unknown')]


def test_start_within_a_motion_is_stated_honestly():
    for name, load in FILTERS:
        u = Excitation().torque(np.arange(4400) * 1e-3)
        motion = simulate(DriveModel(), u, 1e-3, Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), 1)
        assert np.abs(motion.x[300:, 2]).max() > 20.0
        ratios = []
        estimator = Estimator(DriveModel().exact(), {
            'filter': name, 'arm_load': load, 'smoother_lag': 0.0})
        for begin in range(300, 4300, 23):
            part = slice(begin, begin + 60)
            samples = Samples((1 + np.arange(60, dtype=np.int64)) * 1_000_000,
                              np.column_stack([u[part], np.full(60, np.nan)]), motion.y[part])
            estimator.reset()
            estimates = estimator.run(samples)
            ratios.append((estimates.tau_k - motion.tau_k[part][1:]) / estimates.tau_k_std)
            assert estimates.tau_k_std[-1] < 1.0
        ratios = np.abs(ratios)
        assert ratios.max() < 6.0  # of 10 000; where the speed reverses, friction bends within P
        assert (ratios < 1.0).mean() > 0.6 and (ratios < 2.0).mean() > 0.93
