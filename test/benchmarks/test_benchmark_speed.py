# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of speed: its Eigen reference is our EKF, and what cannot be measured is told."""
from contextlib import nullcontext
import re

import numpy as np
import pytest

from benchmarks import eigen_reference, free_run, replay_cost, speed
from benchmarks.__main__ import main
from benchmarks.paper import drive, DT, T0
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.simulate import simulate


@pytest.fixture(scope='module')
def compiled():
    try:
        context = eigen_reference.library()
        found = context.__enter__()
    except InputError as error:
        pytest.skip(f'no Eigen reference: {error}')
    yield found
    context.__exit__(None, None, None)


@pytest.mark.parametrize('name, dt, within', [
    ('Eigen EKF, exact', DT, 1e-9),
    ('Eigen EKF', DT, None),  # the usual tangent is far off where a step is long ...
    ('Eigen EKF', 1e-6, 1e-2),  # ... and right where it is short
])
def test_eigen_reference_is_our_filter(compiled, name, dt, within):
    model, noise, u = drive('A')
    run = simulate(model, u[:3000], dt, noise, 0)
    samples = Samples(T0 + round(dt * 1e9) * np.arange(3000),
                      np.column_stack([run.u, np.full(3000, np.nan)]), run.y)
    parameters = {'arm_load': 'none', 'smoother_lag': 0.0}
    ours = Monitor(model, parameters).run(samples)
    steppers = eigen_reference.steppers(compiled, model, parameters, run.u, run.y, dt)
    states, nis = steppers[name]()
    expected = np.column_stack([ours.x1, ours.x2, ours.x3, ours.x4, ours.tau_k])
    apart = (np.abs(states[1:] - expected) / expected.std(axis=0)).max()
    if within is None:
        assert apart > 1.0
    else:
        assert apart < within
        np.testing.assert_allclose(nis[1:], ours.nis, rtol=within, atol=within)


def test_eigen_reference_refuses_what_it_does_not_know():
    model, _, u = drive('A')
    for changes, dt in (({'arm_load': 'unknown'}, DT), ({'tau_k_stiffness': 1.0}, DT), ({}, 0.01)):
        with pytest.raises(InputError, match='expected five states'):
            eigen_reference.steppers(None, model, {'arm_load': 'none', **changes}, u,
                                     np.zeros((len(u), 2)), dt)


@pytest.mark.system
def test_what_cannot_be_measured_is_told(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(speed, 'SAMPLES', 50)
    monkeypatch.setattr(speed, 'FILTERS', {'EKF': speed.FILTERS['EKF']})
    monkeypatch.setattr(speed, 'LAWS', {})
    monkeypatch.setattr(speed, 'BARS', {name: bar for name, bar in speed.BARS.items()
                                        if 'Eigen' in name or 'start' in name})
    monkeypatch.setattr(replay_cost, 'steppers', lambda: nullcontext(({}, {})))
    monkeypatch.setattr(free_run, 'steppers', lambda: ({}, {}))
    monkeypatch.setattr(speed, 'FEW', 3)
    monkeypatch.setenv(eigen_reference.VARIABLE, str(tmp_path))
    main(['speed', '--rounds', '1'])
    out = capsys.readouterr().out
    assert f'skipped EKF / Eigen EKF: {tmp_path}: no Eigen/Core there, expected it from' in out
    assert '  EKF   ' in out and '  Eigen EKF' not in out
    ratio = re.search(r' start and first step / import scipy.optimize +([\d.]+) ', out)
    assert float(ratio[1]) > 1.0
    # What was asked for is not skipped.
    assert main(['speed', '--eigen', str(tmp_path / 'other')]) == 2
    assert 'other: no Eigen/Core there' in capsys.readouterr().err


def test_too_old_an_eigen_is_told(tmp_path):
    (tmp_path / 'Eigen').mkdir()
    (tmp_path / 'Eigen/LU').touch()
    (tmp_path / 'Eigen/Core').write_text('#define EIGEN_VERSION_AT_LEAST(x, y, z) (x < 3)\n')
    with pytest.raises(InputError, match=r'expected 3\.3 or newer.*eigen_ekf\.cpp|not found'):
        with eigen_reference.library(tmp_path):
            pass


def test_solvers_that_simulate_is_compared_with_reach_the_same_motion():
    rows, _ = free_run.steppers()
    held = np.append(np.repeat(free_run.torque()[:free_run.FEW], 16), 0.0)
    exact = simulate(free_run.MODEL, held, free_run.DT / 16).x[-1]
    ours = rows['simulate']().x[free_run.FEW]
    assert np.abs(ours - exact)[:2].max() < 0.2 * free_run.ERROR
    for name in free_run.SETTINGS:
        end = rows[f'solve_ivp {name}']().y[:2, -1]
        assert np.abs(end - exact[:2]).max() < free_run.ERROR, name
