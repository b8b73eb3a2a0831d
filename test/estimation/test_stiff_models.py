# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Models too fast to be computed in time are refused by name, before a kernel sees them."""
import math

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.parameters import FILTER_NAMES, MODEL
from gearbox_monitor.plant.drive import (
    DriveModel, expect_integrable, fastest_eigenvalue, MAX_SUBSTEPS, RK4_STABILITY, substeps)

PACKAGED = DriveModel()
TOO_FAST = [
    ({'motor_inertia': 1e-9}, 'motor_inertia: 1e-09'),
    ({'motor_inertia': 5e-324}, 'motor_inertia: 4.94066e-324'),
    ({'arm_inertia': 1e-12}, 'arm_inertia: 1e-12'),
    ({'friction_sharpness': 1e9}, 'friction_sharpness: 1e\\+09'),
    ({'coulomb_friction': 1e9}, 'coulomb_friction: 1e\\+09'),
    ({'viscous_friction': 1e9}, 'viscous_friction: 1e\\+09'),
    ({'viscous_friction': -1e9}, 'viscous_friction: -1e\\+09'),
    ({'damping': 1e9}, 'damping: 1e\\+09'),
    ({'stiffness': 1e12}, 'stiffness: 1e\\+12')]


def test_a_model_that_is_too_fast_is_refused_by_name():
    for values, words in TOO_FAST:
        with pytest.raises(InputError, match=words):
            Estimator(PACKAGED.with_(**values))


def test_a_change_that_is_too_fast_leaves_all_as_it_was():
    estimator = Estimator(PACKAGED)
    with pytest.raises(InputError, match='friction_sharpness: 1e'):
        estimator.set_parameters({'friction_sharpness': 1e9})
    with pytest.raises(InputError, match='tau_k_stiffness'):
        estimator.set_parameters({'tau_k_stiffness': 1e12})
    assert estimator.model == PACKAGED and estimator.parameters.tau_k_stiffness == 0.0


def test_every_range_is_accepted_or_refused():
    """At the bounds of its range a value is refused, or a step over max_gap is affordable."""
    for kind in FILTER_NAMES:
        for name in [row.name for row in MODEL]:
            row = next(row for row in MODEL if row.name == name)
            for value in (row.low, row.high):
                parameters = {'filter': kind, 'max_gap': 60.0, name: value}
                try:
                    drive = Estimator(PACKAGED, parameters).drive
                except InputError as error:
                    assert len(str(error)) < 300
                else:
                    assert substeps(60.0, fastest_eigenvalue(drive)) <= MAX_SUBSTEPS


def test_the_number_of_substeps_is_bounded():
    for eigenvalue in (1e12, 1e300, math.inf, math.nan):
        assert substeps(0.25, eigenvalue) == MAX_SUBSTEPS
    assert substeps(1e-3, 2700.0) == 1 and substeps(1e-3, 27_001.0) == 11
    limit = MAX_SUBSTEPS * RK4_STABILITY / 0.25
    slow, fast = (PACKAGED.with_(damping=d) for d in (0.9e-2 * limit / 250, 1.3e-2 * limit / 250))
    assert fastest_eigenvalue(slow) < fastest_eigenvalue(fast)
    expect_integrable(PACKAGED, 0.25, 'model')
    with pytest.raises(InputError, match='expected at most'):
        expect_integrable(PACKAGED, 1e3, 'model')


def test_damping_that_is_fastest_in_the_gap_leaves_the_deviations_stable():
    """In contact this joint of an arm is slower: one substep at 500 Hz would not be stable."""
    model = PACKAGED.with_(
        motor_inertia=0.15, arm_inertia=1.7e-3, damping=3.0, viscous_friction=0.6,
        coulomb_friction=1.2, position_gain=0.0, stiffness=3e3, half_gap=5e-4)
    assert fastest_eigenvalue(model) > 3.0 / 1.7e-3 > math.sqrt(3e3 / 1.7e-3)
    count = 1000
    y = 2e-5 * np.random.default_rng(1).normal(size=(count, 2))
    estimates = Estimator(model, {
        'arm_load': 'none', 'smoother_lag': 0.0, 'r_std_motor': 2e-5, 'r_std_arm': 2e-5,
        'q_std_motor_speed': 0.01, 'q_std_arm_speed': 0.01, 'q_std_tau_k': 0.3}).run(Samples(
            (1 + np.arange(count, dtype=np.int64)) * 2_000_000,
            np.column_stack([np.zeros(count), np.full(count, np.nan)]), y))
    assert np.median(estimates.tau_k_std[-100:]) < 3.0 * estimates.tau_k_noise_std[-1]
