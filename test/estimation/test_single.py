# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A filter by itself gives the numbers of the Monitor, and says when it cannot go on."""
import math

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filter import Filter
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

DT, N = 1e-3, 600
LOADED = DriveModel().with_(effects=({'id': 'gravity', 'G': 0.3},))


SINGLE = [
    ('srukf', 'unknown', DriveModel()), ('aekf', 'none', DriveModel()), ('ekf', 'none', LOADED)]


def test_numbers_are_those_of_the_monitor():
    for name, load, model in SINGLE:
        run = simulate(model, Excitation().torque(np.arange(N) * DT), DT,
                       Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)))
        y = run.y.copy()
        y[N // 3:N // 3 + 5, 1] = np.nan
        parameters = {'filter': name, 'smoother_lag': 0.0, 'narrow_std': False, 'arm_load': load}
        estimator = Estimator(model, parameters)
        stamps = 10 ** 9 + np.round(np.arange(N) * DT * 1e9).astype(np.int64)
        expected = estimator.run(Samples(stamps, np.column_stack([run.u, np.full(N, np.nan)]), y))
        f = Filter(model, parameters)
        assert f.names == estimator.names
        f.start(*y[0])
        for k in range(1, N):
            assert f.step(DT, run.u[k - 1], *y[k])
            assert f.tau_k == expected.tau_k[k - 1]
        assert f.tau_k_std == expected.tau_k_std[-1]
        np.testing.assert_array_equal(f.innovation, [expected.innovation_motor[-1],
                                                     expected.innovation_arm[-1]])
        assert f.nis == expected.nis[-1]


def test_a_filter_that_cannot_go_on_says_so_and_begins_anew():
    f = Filter(DriveModel())
    assert not f.step(DT, 0.0, 0.0, 0.0) and math.isnan(f.tau_k)  # not started
    for u in (math.nan, 1e300):
        f.start(0.0, 0.0)
        assert f.step(DT, 0.1, 1e-3, 0.0)
        assert not (f.step(DT, u, 0.0, 0.0) and f.step(DT, u, 0.0, 0.0))
    f.start(0.0, math.nan)
    assert f.step(DT, 0.1, 0.0, math.nan) and math.isnan(f.innovation[1])


def test_parameters_are_checked():
    with pytest.raises(InputError, match='r_std_motr: unknown parameter'):
        Filter(DriveModel(), {'r_std_motr': 1.0})
    with pytest.raises(InputError, match=r'transmission\.kind: rigid'):
        Filter(DriveModel().with_(kind='rigid'))
