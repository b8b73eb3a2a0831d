# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Laws of every effect and every filter: a new one needs no test beyond its equation.

Two plants and the interpreted kernels are compared in test_effects and test_interpreted.
"""
import itertools
import json
import math

from drives import interrupted, part_of
import numpy as np
from plant.test_effects import DT, given, ON_TORQUE, U
import pytest

from gearbox_monitor.estimation.estimates import COLUMNS, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.process_model import (
    BESIDE, curve_count, EIGENVALUE, layout_of, N_LANE, pack, propagate, propagate_numeric,
    state_names, TAU_K)
from gearbox_monitor.kernels.kernel import Entry
from gearbox_monitor.parameters import EstimatorParameters, FILTER_NAMES
from gearbox_monitor.plant.drive import DriveModel, model_from_dict, substeps
from gearbox_monitor.plant.simulate import Plant

# Signs of angle, speed and torque mean nothing to an effect without one of its own.
ONE_SIDED = {'coulomb_asymmetry', 'viscous_asymmetry', 'cogging', 'gravity', 'load_torque',
             'disturbance', 'mesh_error', 'torque_offset', 'torque_ripple', 'encoder_offset',
             'motor_encoder_eccentricity', 'arm_encoder_eccentricity'}
TIMED = {'disturbance', 'viscous_drift'}  # what they do depends on the time since the start
LOAD_STATES = {'arm_load': 'unknown'}
KINDS = {
    **{name: {'filter': name, **LOAD_STATES} for name in FILTER_NAMES if name != 'aekf'},
    'aekf': {'filter': 'aekf', 'arm_load': 'none'},
    'statistical': {'friction_linearisation': 'statistical', **LOAD_STATES},
    **{name: {'tau_k_model': name} for name in ('elastic', 'learned', 'mixed')}}
# Process models: parameters beyond the default ones, and what the drive has.
STATES = [dict(zip(('arm_load', 'tau_k_stiffness', 'q_std_tau_k_speed', 'friction_error_std'), v))
          for v in itertools.product(('none', 'unknown'), (0.0, 5.0), (0.0, 0.5), (0.0, 0.05))]
LOADS = [{'id': 'gravity', 'G': 1.2, 'phi': 0.5}, {'id': 'arm_coulomb', 'Cac': 0.9},
         {'id': 'arm_viscous', 'Cav': 0.1}, {'id': 'load_torque', 'TL': 0.4}]
PROCESS_MODELS = [
    *((options, {'effects': [{'id': 'load_friction', 'Cl': 0.2}]}) for options in STATES),
    ({'tau_k_stiffness': 2.0, 'friction_error_std': 0.2, **LOAD_STATES}, {'effects': LOADS}),
    ({}, {'friction_law': {'kind': 'tanh'}, 'effects': LOADS[1:2],
          'arm_friction_sharpness': 60.0}),
    ({'tau_k_model': 'elastic'}, {}),
    ({'tau_k_model': 'elastic'}, {'kind': 'play', 'hysteresis_width': 0.03}),
    *(({'tau_k_model': 'learned', 'friction_error_std': 0.1, **LOAD_STATES},
       {'effects': LOADS[:1], 'kind': kind, 'hysteresis_width': 0.03})
      for kind in ('play', 'passive_play'))]
NUMERIC = Entry(propagate_numeric)


def run(model, u, **more):
    return Plant(model).run(u, DT, **more)


def model_of(name):
    return model_from_dict({'effects': given(name)}, 'test')


# ---------------------------------------------------------------------- effects


def test_each_effect_is_the_same_from_a_file_and_however_a_run_is_cut():
    for name in ON_TORQUE:
        model = model_of(name)
        assert model_from_dict(json.loads(json.dumps(model.to_dict())), 'again') == model
        whole, cut = run(model, U[:900]), Plant(model)
        parts = [cut.run(U[a:b], DT, a * DT) for a, b in ((0, 7), (7, 420), (420, 900))]
        for field in ('y', 'x', 'tau_k', 'tau_arm'):
            np.testing.assert_array_equal(
                np.concatenate([getattr(p, field) for p in parts]), getattr(whole, field), name)


def test_an_effect_without_a_side_of_its_own_mirrors_the_motion():
    for name in ON_TORQUE:
        ours, mirrored = run(model_of(name), U[:900]), run(model_of(name), -U[:900])
        same = np.array_equal(ours.y, -mirrored.y)
        assert same == (name not in ONE_SIDED), name


def test_an_effect_without_a_clock_is_the_same_at_any_time():
    for name in ON_TORQUE:
        now, later = (Plant(model_of(name)).run(U[:900], DT, begin).y for begin in (0.0, 0.75))
        assert np.array_equal(now, later) == (name not in TIMED), name


# ---------------------------------------------------------------------- process models


def test_the_tangent_of_every_process_model_is_that_of_its_map():
    """By differences of the map, of the fast and of the numeric propagation."""
    random = np.random.default_rng(1)
    # Both signs: load friction has a kink at zero.
    for (options, drive), (dt, torque) in itertools.product(
            PROCESS_MODELS, ((1e-3, 2.0), (7e-3, -3.0))):
        parameters = EstimatorParameters.from_mapping(options)
        model = DriveModel().with_(arm_load=parameters.arm_load, **drive)
        p, n = pack(model, parameters), len(state_names(model, parameters))
        states, counted = layout_of(p, n), substeps(dt, p[EIGENVALUE])
        at = n - curve_count(states.curve)

        def flow(z):
            z, phi = z.copy(), np.full(n * n, np.nan)
            propagate(states, z, phi, (1.0, 0.2), dt, counted, p)
            return z, phi.reshape(n, n)
        z = 0.3 * random.normal(size=n)
        z[1], z[TAU_K] = z[0] - 0.25 * random.normal(), torque
        if at < n:
            z[at] = z[0] - z[1] + 0.03 * random.normal()
        if at + 1 < n:
            z[at + 1:] = 30.0, 2.4, math.copysign(0.6, torque)
        after, phi = flow(z)
        steps = 1e-6 * np.eye(n)
        numeric = np.array([flow(z + h)[0] - flow(z - h)[0] for h in steps]).T / 2e-6
        np.testing.assert_allclose(phi, numeric, rtol=2e-6, atol=1e-7, err_msg=str(options))
        other, differences = z.copy(), np.empty(n * n)
        NUMERIC(states, other, differences, (1.0, 0.2), dt, counted, p,
                np.empty((n + N_LANE) * BESIDE))
        np.testing.assert_allclose(other, after, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(differences.reshape(n, n), phi, rtol=1e-3, atol=1e-3)


# ---------------------------------------------------------------------- filters


@pytest.fixture(scope='module')
def stream():
    return interrupted()


def test_every_filter_gives_the_same_bits_however_a_stream_is_cut_and_restored(stream):
    for kind, parameters in KINDS.items():
        whole = Estimator(DriveModel(), parameters).run(stream)
        cut, restored = (Estimator(DriveModel(), parameters) for _ in range(2))
        pieces, rows = [], []
        for begin in range(0, 2000, 250):
            samples = part_of(stream, begin, begin + 250)
            pieces.append(cut.run(samples))
            rows.append(restored.run(samples).rows)
            restored = Estimator.restore(json.loads(json.dumps(restored.snapshot())))
        for found in (rows, [piece.rows for piece in pieces]):
            np.testing.assert_array_equal(np.concatenate(found), whole.rows, kind)
        # A restart loses what the smoother was about to complete.
        np.testing.assert_array_equal(np.concatenate([piece.smoothed for piece in pieces]),
                                      whole.smoothed, kind)
        assert len(whole.rows) > 1900 and len(whole.smoothed) > 1500


def test_every_filter_goes_on_from_a_snapshot_through_a_change_of_parameters(stream):
    for kind, parameters in KINDS.items():
        live = Estimator(DriveModel(), parameters)
        live.run(part_of(stream, 0, 700))
        live.set_parameters({'r_std_motor': 0.006})
        restored = Estimator.restore(json.loads(json.dumps(live.snapshot())))
        a, b = (one.run(part_of(stream, 700, 2000)) for one in (live, restored))
        np.testing.assert_array_equal(a.rows, b.rows, kind)
        np.testing.assert_array_equal(a.smoothed, b.smoothed, kind)
        assert live.snapshot() == restored.snapshot(), kind


def test_every_filter_knows_no_hour_and_no_side(stream):
    """Estimates of a mirrored stream, and of one an hour later, are the same but for signs."""
    later = Samples(stream.stamp_ns + (stream.stamp_ns > 0) * 3600 * 10 ** 9, stream.u, stream.y)
    mirrored = Samples(stream.stamp_ns, -stream.u, -stream.y)
    signed = [COLUMNS[name] for name in ('x1', 'x2', 'x3', 'x4', 'tau_k', 'twist')]
    for kind, parameters in KINDS.items():
        rows, after, turned = (Estimator(DriveModel(), parameters).run(samples).rows
                               for samples in (stream, later, mirrored))
        np.testing.assert_array_equal(after, rows, kind)
        np.testing.assert_allclose(turned[:, signed], -rows[:, signed], rtol=1e-9, atol=1e-9,
                                   err_msg=kind)
        np.testing.assert_allclose(turned[:, COLUMNS['tau_k_std']], rows[:, COLUMNS['tau_k_std']],
                                   rtol=1e-9, err_msg=kind)
