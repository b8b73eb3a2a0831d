# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Estimates of compiled kernels are those of the same Python, bit for bit, on a damaged stream."""
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

N, MANY = 130, 5000  # of MANY, 261 CPU s; the default suite interprets 2000 of a walk
LOADED = [{'id': 'gravity', 'G': 0.4}, {'id': 'arm_coulomb', 'Cac': 0.05}]
PLAY = {'kind': 'play', 'hysteresis_width': 0.02}
# What differs from a default estimator with an unknown load, and from the default model.
VARIANTS = {  # each kernel once: a mixture holds a walk by the EKF, a fixed and a learned curve
    'mixed': ({'tau_k_model': 'mixed'}, PLAY), 'srukf': ({'filter': 'srukf'}, {}),
    'ukf': ({'filter': 'ukf'}, {'friction_law': {'kind': 'tanh'}}),
    'aekf': ({'filter': 'aekf', 'adapt': ['q_std_tau_k', 'r_std_motor', 'coulomb_friction',
                                          'viscous_friction'], 'arm_load': 'none'},
             {'effects': LOADED}),
    'statistical': ({'friction_linearisation': 'statistical', 'friction_error_std': 0.1}, {}),
    'held': ({}, {'friction_law': {'kind': 'ode'}, 'timestep': 1e-3})}
WALK = {'walk': ({'arm_load': 'none', 'smoother_lag': 0.0}, dict.fromkeys((
    'friction_tolerance', 'damping_tolerance', 'inertia_tolerance', 'torque_gain_tolerance',
    'delay_tolerance'), 0.0))}


def samples(count):
    """Return samples with what a stream can do to a filter."""
    out = simulate(DriveModel(), Excitation().torque(1e-3 * np.arange(count)), 1e-3,
                   Noise(measurement=(0.005, 0.005)), 3)
    stamps = 10 ** 9 + np.arange(count) * 10 ** 6
    stamps[60:] += 10 ** 8
    stamps[80], stamps[85] = 0, stamps[84]
    y, u = out.y.copy(), np.stack([out.u, np.zeros(count)], axis=1)
    y[25:35, 0], y[30:40, 1], y[50], y[115:, 0] = np.nan, np.nan, np.inf, y[115:, 0] + 3.0
    u[70:76], u[100] = np.nan, 1e10
    return Samples(stamps, u, y)


def run(variants, count):
    """Return {variant and name of an array: what its estimator gives of `count` samples}."""
    found = {}
    for name, (parameters, changes) in globals()[variants].items():
        estimator = Estimator(DriveModel().with_(**changes), {'arm_load': 'unknown', **parameters})
        result = estimator.run(samples(count))
        assert len(result.rows) > count // 2
        assert len(result.smoothed) > 0 or variants == 'WALK'
        found.update({f'{name}: rows': result.rows, f'{name}: smoothed': result.smoothed,
                      f'{name}: codes': result.codes, f'{name}: counts': estimator.counts})
    return found


@pytest.mark.parametrize('variants, count', [
    ('VARIANTS', N), ('WALK', 2000), pytest.param('VARIANTS', MANY, marks=pytest.mark.system)])
def test_interpreted_equals_compiled(tmp_path, variants, count):
    here = Path(__file__).parent
    code = ('import sys; sys.path.insert(0, sys.argv[1]); import numpy as np; '
            'import test_interpreted as t; '
            'np.savez(sys.argv[2], **t.run(sys.argv[3], int(sys.argv[4])))')
    subprocess.run([sys.executable, '-c', code, here, tmp_path / 'out.npz', variants, str(count)],
                   check=True, timeout=800, env={
                       **os.environ, 'GEARBOX_MONITOR_KERNELS': 'python',
                       'PYTHONPATH': str(here.parents[1])})
    interpreted = np.load(tmp_path / 'out.npz')
    for key, values in run(variants, count).items():
        np.testing.assert_array_equal(values, interpreted[key], key)
