# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The drive against analytic cases, the published figures, and its model file."""
from dataclasses import replace
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path, load_model
from gearbox_monitor.plant.drive import DriveModel, fastest_eigenvalue, substeps, Transmission
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant, simulate, TOLERANCE
from gearbox_monitor.plant.transmission import DEAD_ZONE, PASSIVE_PLAY, PLAY, transmission_torque


FREE = {'damping': 0.0, 'viscous_friction': 0.0, 'coulomb_friction': 0.0, 'position_gain': 0.0}
CASE_A = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)
CASE_B = DriveModel().with_(stiffness=5.0, half_gap=0.6)
CASES = {'A': CASE_A, 'B': CASE_B}
STATE_STD = {'A': (3.29, 4.16, 19.3, 23.9), 'B': (3.06, 4.14, 17.9, 23.6)}


def run(model, seconds, dt=1e-3, **kwargs):
    t = dt * np.arange(round(seconds / dt))
    return simulate(model, Excitation().torque(t), dt, **kwargs)


def test_oscillator_frequency_and_energy():
    model = DriveModel().with_(**FREE, stiffness=5.0, half_gap=0.0)
    plant = Plant(model, state=[0.3, -0.1, 0.0, 0.0, 0.0])
    out = plant.run(np.zeros(20000), 1e-4)
    twist = out.x[:, 0] - out.x[:, 1]
    m1, m2 = model.motor_inertia, model.arm_inertia
    omega = math.sqrt(5.0 * (1.0 / m1 + 1.0 / m2))
    np.testing.assert_allclose(twist, 0.4 * np.cos(omega * out.t), atol=1e-6)
    energy = 0.5 * (m1 * out.x[:, 2] ** 2 + m2 * out.x[:, 3] ** 2 + 5.0 * twist ** 2)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)
    np.testing.assert_allclose(m1 * out.x[:, 2] + m2 * out.x[:, 3], 0.0, atol=1e-12)


def test_rk4_is_of_fourth_order_on_a_smooth_case():
    model = DriveModel().with_(half_gap=0.0, friction_sharpness=1.0, stiffness=5.0)

    def error(dt):
        plant = Plant(model, state=[0.3, -0.1, 2.0, 0.0, 0.0])
        plant.run(np.full(round(0.2 / dt), 0.5), dt)
        return np.abs(plant.state - reference).max()

    plant = Plant(model, state=[0.3, -0.1, 2.0, 0.0, 0.0])
    plant.run(np.full(20000, 0.5), 1e-5)
    reference = plant.state.copy()
    order = math.log2(error(2e-3) / error(1e-3))
    assert 3.7 < order < 4.4


def equals_a_stock_solver(name):
    model = CASE_B if name == 'B' else CASE_B.with_(
        arm_load='unknown', torque_offset=0.2, effects=[
            {'id': 'gravity', 'G': 1.0}, {'id': 'arm_coulomb', 'Cac': 0.2},
            {'id': 'arm_viscous', 'Cav': 0.03}, {'id': 'load_torque', 'TL': 0.4}])
    loaded = name == 'A'

    def f(t, x):
        twist = x[0] - x[1]
        tau = 5.0 * (np.sign(twist) * max(abs(twist) - 0.6, 0.0))
        friction = 0.1 * x[2] + 0.27 * 2 / np.pi * np.arctan(100 * x[2])
        arm = loaded * (np.sin(x[1]) + 0.2 * 2 / np.pi * np.arctan(100 * x[3])
                        + 0.03 * x[3] + 0.4)
        relative = 0.01 * (x[2] - x[3])
        return [x[2], x[3],
                (1.5 + 0.2 * loaded - relative - tau - friction - 0.01 * x[0]) / 0.006442,
                (relative + tau - arm) / 0.023454]

    plant = Plant(model)
    plant.run(np.full(2500, 1.5), 2e-4)
    stock = solve_ivp(f, (0.0, 0.5), [0, 0, 0, 0], 'LSODA', rtol=1e-10, atol=1e-12, max_step=2e-4)
    np.testing.assert_allclose(plant.state[:4], stock.y[:, -1], rtol=2e-5, atol=1e-5)


def test_trajectory_equals_a_stock_solver():
    """Equations retyped for scipy; the play is left out, as it has no state equation."""
    for name in CASES:
        equals_a_stock_solver(name)


def test_equilibrium_without_torque():
    out = Plant(DriveModel()).run(np.zeros(1000), 1e-3)
    assert not out.x.any() and not out.tau_k.any()
    # Inside the gap nothing pulls, wherever it stands.
    free = DriveModel().with_(position_gain=0.0)
    out = Plant(free, state=[1.05, 1.0, 0.0, 0.0, 0.0]).run(np.zeros(1000), 1e-3)
    np.testing.assert_array_equal(out.x, np.tile([1.05, 1.0, 0.0, 0.0], (1000, 1)))


def torques(twist, *arguments):
    memory, out = 0.0, []
    for value in twist:
        tau, memory = transmission_torque(value, memory, *arguments)
        out.append(tau)
    return np.array(out)


def test_dead_zone():
    twist = np.array([-0.7, -0.6, 0.0, 0.3, 0.6, 0.8])
    np.testing.assert_allclose(
        torques(twist, DEAD_ZONE, 5.0, 0.6, 0.0, 0.0), [-0.5, 0.0, 0.0, 0.0, 0.0, 1.0], atol=1e-12)


def test_orientation_of_the_loop():
    """Work absorbed per cycle: none, negative (the paper's orientation), positive (physical)."""
    for kind, sign in ((DEAD_ZONE, 0), (PLAY, -1), (PASSIVE_PLAY, 1)):
        phase = np.linspace(0.0, 4 * np.pi, 40001)
        twist = 1.5 * np.sin(phase)
        tau = torques(twist, kind, 5.0, 0.3, 0.3, 5.0)
        last = phase >= 2 * np.pi
        work = np.trapezoid(tau[last], twist[last]) if hasattr(np, 'trapezoid') else np.trapz(
            tau[last], twist[last])
        if sign == 0:
            assert abs(work) < 1e-9
        elif kind == PLAY:
            # Height 2 K c on both flanks, as high as tau reaches: +-K (1.5 - c - b).
            assert work == pytest.approx(-2 * 0.3 * 2 * 5.0 * (1.5 - 0.3 - 0.3), rel=1e-3)
        else:
            # A friction element of force k_s r, slipping over 2 (2 A - 2 r).
            assert work == pytest.approx(5.0 * 0.3 * 2 * (2 * 1.5 - 2 * 0.3), rel=1e-3)


def test_a_rigid_drive_is_the_limit_of_a_stiff_one():
    loads = ({'id': 'gravity', 'G': 0.3}, {'id': 'load_friction', 'Cl': 0.2})
    t = 1e-3 * np.arange(1000)
    u = Excitation().torque(t)
    rigid = replace(DriveModel(effects=loads), transmission=Transmission('rigid'))
    # Damped: friction that grows with the torque would brake what vibrates.
    stiff = replace(rigid, damping=5.0, transmission=Transmission('dead_zone', 2e4, 0.0))
    found, near = simulate(rigid, u, 1e-3), simulate(stiff, u, 1e-3)
    np.testing.assert_allclose(found.x[:, 0], found.x[:, 1], atol=1e-12)
    np.testing.assert_allclose(found.x[:, :2], near.x[:, :2], atol=0.02)
    assert np.ptp(found.x[:, 0]) > 1.0
    # The arm's own equation: what is transmitted moves it.
    acceleration = np.gradient(found.x[:, 3], 1e-3)
    error = (found.tau_k - found.tau_arm - rigid.arm_inertia * acceleration)[5:-5]
    assert np.quantile(np.abs(error), 0.99) < 0.15  # differences smear reversals


def test_a_rigid_drive_has_one_inertia():
    """However it is divided between motor and arm, and whatever damps a twist that is not."""
    u = Excitation().torque(1e-3 * np.arange(2000))
    one = DriveModel(motor_inertia=0.03, arm_inertia=1e-6, transmission=Transmission('rigid'))
    other = replace(one, motor_inertia=0.020001, arm_inertia=0.01, damping=0.0)
    x = simulate(one, u, 1e-3).x
    assert np.ptp(x[:, 0]) > 1.0
    np.testing.assert_allclose(x, simulate(other, u, 1e-3).x, atol=1e-9)


def test_noise_moves_a_rigid_drive_as_one():
    """Impulses on motor and arm add up: of the speed remains their share of both inertias."""
    model = DriveModel(viscous_friction=0.0, coulomb_friction=0.0, position_gain=0.0,
                       transmission=Transmission('rigid'))
    noise = Noise(process=(0.0, 0.0, 0.3, 0.4))
    x = simulate(model, np.zeros(20_000), 1e-3, noise, 5).x
    np.testing.assert_array_equal(x[:, [0, 2]], x[:, [1, 3]])
    size = np.hypot(0.3 * model.motor_inertia, 0.4 * model.arm_inertia) / (
        model.motor_inertia + model.arm_inertia)
    assert np.std(np.diff(x[:, 2])) == pytest.approx(size * 1e-3 ** 0.5, rel=0.03)


STEPS = [
    ({}, TOLERANCE), ({'timestep': 1e-3}, 0.0), ({'integrator': 'euler', 'timestep': 1e-3}, 0.0)]


def test_steps_are_those_of_the_simulator_or_accurate():
    for changes, tolerance in STEPS:
        plant = Plant(replace(DriveModel(), **changes))
        assert plant.tolerance == tolerance
        plant.noise = Noise(measurement=(0.0, 1e-5))
        assert plant.tolerance == min(tolerance, 1e-8)


def test_eigenvalue_and_substeps():
    eigenvalue = fastest_eigenvalue(DriveModel())
    assert eigenvalue == pytest.approx(2685, abs=1)
    assert [substeps(dt, eigenvalue) for dt in (1e-6, 5e-4, 1e-3, 2e-3, 1e-2, 0.25)] == [
        1, 1, 1, 2, 10, 249]
    # Dry friction on the arm is stiff, too.
    loaded = DriveModel().with_(effects=[{'id': 'arm_coulomb', 'Cac': 3.0}])
    assert fastest_eigenvalue(loaded) == pytest.approx(
        3.0 * 2 / np.pi * 100 / 0.023454, rel=0.01)


def test_state_spread_of_the_reference_cases():
    for name in CASES:
        out = run(CASES[name], 20.0)
        np.testing.assert_allclose(out.x[500:].std(axis=0), STATE_STD[name], rtol=0.01)


def test_noise_is_seeded_and_of_the_stated_size():
    noise = Noise((0.0, 0.0, 0.3, 0.5), (0.01, 0.02))
    one, same, other = (run(CASE_B, 2.0, noise=noise, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.y, same.y)
    assert np.abs(one.y - other.y).max() > 0.01
    error = one.y - one.x[:, :2]
    # 2000 normal numbers: the standard deviation is good to 1.6 %, the mean to 0.022 sd (1 sigma).
    np.testing.assert_allclose(error.std(axis=0), [0.01, 0.02], rtol=0.07)
    assert (np.abs(error.mean(axis=0)) < 0.1 * np.array([0.01, 0.02])).all()
    # Process noise per square root of a second, whatever the step: free masses spread as sqrt(t).
    free = DriveModel().with_(**FREE, half_gap=1000.0)
    for dt in (1e-3, 1e-2):
        out = simulate(free, np.zeros(round(50 / dt)), dt, Noise(noise.process), seed=3)
        steps = np.diff(out.x[:, 2:], axis=0)
        np.testing.assert_allclose(steps.std(axis=0) / math.sqrt(dt), [0.3, 0.5], rtol=0.05)


def test_chunks_and_changes_while_running():
    whole = Plant(CASE_A).run(np.full(600, 2.0), 1e-3)
    plant = Plant(CASE_A)
    parts = [plant.run(np.full(n, 2.0), 1e-3) for n in (100, 1, 499)]
    np.testing.assert_array_equal(np.concatenate([p.x for p in parts]), whole.x)
    plant.model = CASE_A.with_(half_gap=0.5)
    assert plant.run(np.full(300, 2.0), 1e-3).tau_k.std() > 0.0


def test_excitation():
    for kind in ('multisine', 'chirp', 'square', 'triangle', 'none'):
        torque = Excitation(kind, (2.0,), (0.5, 3.0), 10.0).torque(np.linspace(0, 20, 20001))
        assert torque.shape == (20001,) and np.abs(torque).max() <= 2.0 + 1e-12
        assert abs(torque.mean()) < 0.2
        if kind != 'none':
            assert torque.max() == pytest.approx(2.0, rel=0.01)
            # The chirp is there and back: it has the period that was asked for.
            np.testing.assert_allclose(torque[:10001:100], torque[10000::100], atol=1e-6)


BAD_EXCITATIONS = [
    {'kind': 'noise'}, {'kind': 'multisine', 'amplitudes': (1, 2), 'frequencies': (1,)},
    {'kind': 'square', 'amplitudes': ()}, {'kind': 'chirp', 'frequencies': (1.0,)}]


def test_bad_excitation():
    for arguments in BAD_EXCITATIONS:
        with pytest.raises(InputError):
            Excitation(**arguments)


def test_model_file(tmp_path):
    path = tmp_path / 'drive.yaml'
    path.write_text('motor_inertia: 1e-2\ntransmission: {kind: play, stiffness: 7}\n'
                    'effects: [{id: gravity, G: 2.0}]\nprocess_torque: null\n')
    model = load_model(path)
    assert (model.motor_inertia, model.transmission.stiffness) == (0.01, 7.0)
    assert model.arm_inertia == 0.023454 and model.process_torque is None
    assert model.with_(stiffness=8.0).transmission.stiffness == 8.0
    assert load_model(config_path('drive.yaml')) == DriveModel()


def test_another_torque_constant_is_the_same_drive():
    drive = DriveModel(torque_constant=0.05, torque_offset=0.3, effects=(
        {'id': 'torque_gain', 'g': 0.2}, {'id': 'saturation', 'umax': 4.0}))
    current, dt = 120.0 * np.sin(0.02 * np.arange(500)), 1e-3
    runs = [simulate(m, m.torque_constant * current, dt).y for m in (
        drive, drive.with_torque_constant(0.06), drive.with_torque_constant(0.08))]
    assert [e['id'] for e in drive.with_torque_constant(0.06).effects] == ['saturation']
    for run in runs[1:]:
        np.testing.assert_allclose(run, runs[0], rtol=1e-9, atol=1e-12)


BAD_FILES = [
    ('motor_inertia: 0', ('motor_inertia', '0', '> 0')),
    ('arm_inertia: -1.5', ('arm_inertia', '-1.5', '> 0')),
    ('damping: .nan', ('damping', 'nan', '>= 0')),
    ('viscous_friction: .inf', ('viscous_friction', 'inf', 'number')),
    ('coulomb_friction: lots', ('coulomb_friction', "'lots'", '>= 0')),
    ('friction_sharpness: true', ('friction_sharpness', 'True', '> 0')),
    ('position_gain: null', ('position_gain', 'None', '>= 0')),
    ('gear_ratio: 0', ('gear_ratio', '0', 'other than 0')),
    ('torque_constant: 0', ('torque_constant', '0', '> 0')),
    ('tolerance: 2', ('tolerance', '2', '<= 1')),
    ('process_torque: -1', ('process_torque', '-1', '>= 0')),
    ('arm_load: heavy', ('arm_load', "'heavy'", 'none, unknown, measured')),
    ('transmission: 3', ('transmission', '3', 'keys and values')),
    ('transmission: {kind: rubber}', ('transmission.kind', "'rubber'", 'dead_zone')),
    ('transmission: {stiffness: 0}', ('stiffness', '0', '> 0')),
    ('transmission: {half_gap: -0.1}', ('half_gap', '-0.1', '>= 0')),
    ('transmission: {backlash: 1}', ('transmission.backlash', 'unknown', 'half_gap')),
    ('motor_inertai: 1', ('line 1', 'motor_inertai', "mean 'motor_inertia'")),
    ('[1, 2]', ('model', '[1, 2]', 'keys and values')),
    ('a: [', ('line', 'YAML')),
]


def test_bad_model_file(tmp_path):
    for text, parts in BAD_FILES:
        path = tmp_path / 'drive.yaml'
        path.write_text(text)
        with pytest.raises(InputError) as error:
            load_model(path)
        message = str(error.value)
        assert '\n' not in message
        for part in (str(path), *parts):
            assert part in message


def test_missing_model_file(tmp_path):
    with pytest.raises(InputError, match='nowhere.yaml.*expected'):
        load_model(tmp_path / 'nowhere.yaml')
    (tmp_path / 'binary.yaml').write_bytes(b'\xff\xfe\x00\x81')
    with pytest.raises(InputError, match='binary.yaml.*expected YAML'):
        load_model(tmp_path / 'binary.yaml')
