# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Estimates of compiled kernels are those of the same Python, bit for bit, on a damaged stream.

C takes all samples. Python takes the damaged ones, and stretches of the others from the states
that C has come to: each step from the same state gives the same bits.
"""
import json
import os
from pathlib import Path
import subprocess
import sys

import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

N = 3000
PARTS = [(0, 40), *((begin, begin + 6) for begin in range(220, N, 2000))]  # that Python takes
LOADED = [{'id': 'gravity', 'G': 0.4}, {'id': 'arm_coulomb', 'Cac': 0.05}]
PLAY = {'kind': 'play', 'hysteresis_width': 0.02}
NONE = {'arm_load': 'none'}
# What differs from an estimator with an unknown load and a short smoother, and from the default
# model; a mixture holds a walk by the EKF, a fixed and a learned curve.
VARIANTS = {
    'mixed': ({'tau_k_model': 'mixed'}, PLAY), 'elastic': ({'tau_k_model': 'elastic'}, {}),
    'mixed, no load': ({'tau_k_model': 'mixed', **NONE}, PLAY),
    'elastic, no load': ({'tau_k_model': 'elastic', **NONE}, {}),
    'srukf': ({'filter': 'srukf'}, {}), 'ukf': ({'filter': 'ukf', **NONE}, {}),
    'ukf, tanh': ({'filter': 'ukf'}, {'friction_law': {'kind': 'tanh'}}),
    'aekf': ({'filter': 'aekf', 'adapt': ['q_std_tau_k', 'r_std_motor', 'coulomb_friction',
                                          'viscous_friction'], **NONE}, {'effects': LOADED}),
    'statistical': ({'friction_linearisation': 'statistical', 'friction_error_std': 0.1}, {}),
    'held': ({}, {'friction_law': {'kind': 'ode'}, 'timestep': 1e-3})}


def samples():
    """Return samples with what a stream can do to a filter."""
    out = simulate(DriveModel(), Excitation().torque(1e-3 * np.arange(N)), 1e-3,
                   Noise(measurement=(0.005, 0.005)), 3)
    stamps = 10 ** 9 + np.arange(N) * 10 ** 6
    stamps[18:] += 10 ** 8
    stamps[32:] += 10 ** 10
    stamps[24], stamps[26], stamps[28] = 0, stamps[25], stamps[21]
    y, u = out.y.copy(), np.stack([out.u, np.zeros(N)], axis=1)
    y[6:10, 0], y[8:12, 1], y[15], y[36:, 0] = np.nan, np.nan, np.inf, y[36:, 0] + 300.0
    u[20:23], u[30] = np.nan, 1e10
    return Samples(stamps, u, y)


def part(given, begin, end):
    return Samples(*(column[begin:end] for column in (given.stamp_ns, given.u, given.y)))


def snapshots(given):
    """Return {variant: the states before PARTS}, as estimators of all samples come to them."""
    found = {}
    for name, (parameters, changes) in VARIANTS.items():
        estimator, at = Estimator(DriveModel().with_(**changes), {
            'arm_load': 'unknown', 'smoother_lag': 0.004, **parameters}), 0
        found[name] = []
        for begin, _ in PARTS:
            estimator.run(part(given, at, begin))
            found[name].append(estimator.snapshot())
            at = begin
    return found


def run(states, given):
    """Return {variant, part and array: what an estimator gives of PARTS from these states}."""
    found = {}
    for name, of_parts in states.items():
        for (begin, end), snapshot in zip(PARTS, of_parts, strict=True):
            estimator = Estimator.restore(snapshot)
            result = estimator.run(part(given, begin, end))
            assert len(result.rows) > (end - begin) // 2 and len(result.smoothed)
            found.update({f'{name} {begin}: {key}': array for key, array in (
                ('rows', result.rows), ('smoothed', result.smoothed), ('codes', result.codes),
                ('state', [*estimator.snapshot().values()]))})
    return found


def test_interpreted_equals_compiled(tmp_path):
    here, given = Path(__file__).parent, samples()
    states = snapshots(given)
    np.savez(tmp_path / 'in.npz', u=given.u, y=given.y, stamp_ns=given.stamp_ns)
    (tmp_path / 'states.json').write_text(json.dumps(states))
    code = ('import sys; sys.path.insert(0, sys.argv[1]); import json; import numpy as np; '
            'import test_interpreted as t; given = t.Samples(**np.load("in.npz")); '
            'np.savez("out.npz", **t.run(json.load(open("states.json")), given))')
    subprocess.run([sys.executable, '-c', code, here], check=True, timeout=200, cwd=tmp_path, env={
        **os.environ, 'GEARBOX_MONITOR_KERNELS': 'python', 'PYTHONPATH': str(here.parents[1])})
    interpreted = np.load(tmp_path / 'out.npz')
    for key, values in run(states, given).items():
        np.testing.assert_array_equal(values, interpreted[key], key)
