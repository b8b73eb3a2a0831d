# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The estimator against static compensation on the recordings of a real drive."""
from pathlib import Path

import numpy as np
import pytest

from benchmarks import real, real_fit
from benchmarks.__main__ import main
from benchmarks.static_compensation import fit_static

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data' / 'davinci_backend'
BURN_IN = 1000
# What "benchmarks real" finds on the training runs of split orig.
FITTED = {
    'torque_constant': 0.9302, 'motor_inertia': 8.743e-4, 'coulomb_friction': 0.02259,
    'viscous_friction': -7.869e-4, 'torque_offset': -0.008554, 'q_std_motor_speed': 0.5773,
    'q_std_arm_speed': 0.396, 'q_std_tau_k': 2.717e-4, 'q_std_tau_k_speed': 0.02447,
    'r_std_motor': 1.62e-4, 'r_std_arm': 6.014e-4, 'tau_k_stiffness': 2.447,
    'tau_k_model_std': 0.002928,
}


@pytest.fixture(scope='module')
def recordings():
    if not DATA.is_dir():
        pytest.skip(f'{DATA} is not here')
    return real.load_runs(DATA)


def test_static_compensation_is_tuned_well(recordings):
    runs, _ = recordings
    train = [runs[n] for n in real.SPLITS['orig']]
    test = [r for n, r in runs.items() if n not in real.SPLITS['orig']]
    static = fit_static(train, BURN_IN)

    def error(part):
        return real_fit.rmse(real_fit.errors(
            lambda run: (static.torque(run), np.ones(len(run.stamps))), part, BURN_IN))
    assert error(train) < 6.4e-3 and error(test) < 5.7e-3


def test_estimator_tracks_the_sensor(recordings):
    runs, step = recordings
    found = real_fit.errors(
        lambda run: real_fit.replay(FITTED, run, step), [runs['11'], runs['32']], BURN_IN)
    assert real_fit.rmse(found) < 3.2e-3
    assert 0.6 < real_fit.coverage(found) < 0.86
    # The fit runs its own loop over the same filter step.
    for a, b in zip(real_fit.estimate(FITTED, runs['11'], step),
                    real_fit.replay(FITTED, runs['11'], step)):
        np.testing.assert_array_equal(a[1:], b[1:])


def test_command_fits_judges_and_says_what_is_missing(recordings, tmp_path, capsys, monkeypatch):
    for name in ('00', '11'):
        (tmp_path / f'{name}.TXT.gz').symlink_to(DATA / f'{name}.TXT.gz')
    fit = real_fit.fit
    monkeypatch.setattr(real_fit, 'fit', lambda *a, **k: fit(*a, **{**k, 'budget': (2, 1, 1)}))
    code = main(['real', str(tmp_path)])
    lines = capsys.readouterr().out.splitlines()
    assert code == any(line.startswith('MISSED') for line in lines)
    assert 'split orig: fitted on 00' in lines[0] and lines[1].startswith('missing: 01 02')
    assert sum(line.startswith(('met', 'MISSED')) for line in lines) == 4
    assert max(map(len, lines)) <= 80


def test_folder_without_recordings(tmp_path, capsys):
    assert main(['real', str(tmp_path)]) == 2
    assert 'no training run of split orig, expected recordings' in capsys.readouterr().err
