# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``fit model``: values found again, values that nothing shows, a real drive."""
from dataclasses import replace
import json

import numpy as np
import pytest
from scipy.signal import lfilter
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.joint import nominal
from gearbox_monitor.files.user_files import load_model
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.plant.drive import Controller, DriveModel, Transmission
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

TRUE = DriveModel(torque_offset=0.1, position_gain=0.0)
WRONG = replace(TRUE, torque_offset=0.0, motor_inertia=0.008, arm_inertia=0.015,
                coulomb_friction=0.15, viscous_friction=0.15,
                transmission=Transmission('dead_zone', 15.0, 0.06))


def record(path, model, seed=1, zero=-0.02):
    t = np.arange(2000) * 2e-3
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1 + 0.1 * seed)).torque(t)
    y = simulate(model, u, 2e-3).x[:, :2] + (0.0, zero)
    y = y + 0.002 * np.random.default_rng(seed).standard_normal(y.shape)
    np.savetxt(path, np.column_stack([t, u, y]), '%.9g', ',', header='t,u,motor,arm', comments='')
    return str(path)


def model_file(path, model):
    path.write_text(yaml.safe_dump(model.to_dict()))
    return str(path)


def test_values_are_found_again(tmp_path, capsys):
    bag, other = record(tmp_path / 'a.csv', TRUE), record(tmp_path / 'b.csv', TRUE, 2)
    out = tmp_path / 'fitted.yaml'
    assert main(['fit', 'model', bag, '--model', model_file(tmp_path / 'd.yaml', WRONG),
                 '--validate', other, '--out', str(out), '--json', '-']) in (0, 1)
    data = json.loads(capsys.readouterr()[0])
    true = {'m1': TRUE.motor_inertia, 'm2': TRUE.arm_inertia, 'Cv': 0.1, 'Cc': 0.27, 'K': 25.0,
            'b': 0.1, 'u0': 0.1, 'zero': -0.02}
    for name, value in true.items():
        found = data['values'][name]
        assert found['determined'], name
        assert found['value'] == pytest.approx(value, rel=0.05), name
        assert abs(found['value'] - value) < 6.0 * found['error'], name
    assert data['gap_after'] < 1.05 and data['validation']['gap_after'] < 1.05
    assert data['validation']['gap_before'] > 5.0
    fitted = load_model(out)
    assert fitted.transmission.stiffness == pytest.approx(25.0, rel=0.05)
    assert fitted.torque_offset == pytest.approx(0.1, rel=0.05)


def test_torque_that_no_model_explains_is_not_put_into_the_values(tmp_path, capsys):
    """It lasts 0.3 s: deviations count it, and a value within them is determined all the same."""
    dt, noise = 2e-3, np.random.default_rng(5)
    t = np.arange(2500) * dt
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1)).torque(t)
    fade = np.exp(-dt / 0.3)
    unknown = lfilter([1.0], [1.0, -fade], 0.1 * np.sqrt(1.0 - fade * fade)
                      * noise.standard_normal(len(t)))
    y = simulate(TRUE, u + unknown, dt).x[:, :2] + 1e-3 * noise.standard_normal((len(t), 2))
    bag = tmp_path / 'a.csv'
    np.savetxt(bag, np.column_stack([t, u, y]), '%.9g', ',', header='t,u,motor,arm', comments='')
    main(['fit', 'model', str(bag), '--model', model_file(tmp_path / 'd.yaml', WRONG), '--json',
          '-'])
    data = json.loads(capsys.readouterr()[0])
    assert data['process_torque_time'] in (0.1, 0.3, 1.0)
    true = {'m1': TRUE.motor_inertia, 'm2': TRUE.arm_inertia, 'Cv': 0.1, 'K': 25.0, 'b': 0.1}
    for name, value in true.items():
        fitted = data['values'][name]
        assert abs(fitted['value'] - value) < 4.0 * fitted['error'] < 0.3 * value, name


@pytest.mark.system
def test_long_runs_weigh_what_drifts():
    """Two recordings of another length; the model lacks that friction differs by direction."""
    rigid = replace(TRUE, torque_offset=0.0, transmission=Transmission('rigid'),
                    position_gain=2.0)
    true = replace(rigid, effects=({'id': 'viscous_asymmetry', 'Cva': 0.04},))
    stated = replace(rigid, viscous_friction=0.15, coulomb_friction=0.2)
    recordings = []
    for seconds in (4.0, 6.0):
        t = np.arange(round(seconds / 2e-3)) * 2e-3
        u = 1.5 * np.sin(3.0 * t) + np.sin(8.0 * t)
        y = simulate(true, u, 2e-3).x[:, :2]
        y = y + 1e-3 * np.random.default_rng(6).standard_normal(y.shape)
        recordings.append(load_recording({'t': t, 'torque': u, 'motor': y[:, 0]}, stated,
                                         name='run').uniform()[0])
    fits = [nominal.fit_nominal(recordings, stated, ['m1', 'Cv', 'Cc'], seconds=seconds)
            for seconds in (None, np.inf)]
    assert fits[0].gap_before > fits[0].gap_after and fits[1].gap_before is None

    def error(model):
        """Return the rms error of free runs of a `model` from rest, rad."""
        return np.sqrt(np.mean([np.mean((simulate(model, r.u, r.dt).x[:, 0] - r.y[:, 0]) ** 2)
                                for r in recordings]))
    short, long = (fit.model for fit in fits)
    assert error(long) < error(short)
    for factor in (0.99, 1.01):  # no free run comes closer
        assert error(long) < error(long.with_(viscous_friction=factor * long.viscous_friction))


@pytest.mark.system
def test_a_weight_has_a_size_and_a_phase(tmp_path, capsys):
    rigid = replace(TRUE, torque_offset=0.0, transmission=Transmission('rigid'))
    bag = record(tmp_path / 'a.csv', replace(
        rigid, effects=({'id': 'gravity', 'G': 0.4, 'phi': 0.7},)), zero=0.0)
    stated = replace(rigid, effects=({'id': 'gravity', 'G': 0.3, 'phi': 0.4},))
    assert main(['fit', 'model', bag, '--model', model_file(tmp_path / 'd.yaml', stated),
                 '--free', 'Cv', 'gravity', '--json', '-']) == 0
    values = json.loads(capsys.readouterr()[0])['values']
    assert set(values) == {'Cv', 'gravity.G', 'gravity.phi'}
    for name, unit, start, true in (('G', 'N m', 0.3, 0.4), ('phi', 'rad', 0.4, 0.7)):
        fitted = values[f'gravity.{name}']
        assert fitted['determined'] and fitted['unit'] == unit
        assert fitted['start'] == pytest.approx(start)
        assert abs(fitted['value'] - true) < 4.0 * fitted['error'] < 0.1 * true


def test_what_the_data_do_not_determine_is_told(tmp_path, capsys):
    rigid = replace(TRUE, torque_offset=0.0, transmission=Transmission('rigid'))
    bag = record(tmp_path / 'a.csv', rigid, zero=0.0)
    assert main(['fit', 'model', bag, '--model', model_file(tmp_path / 'd.yaml', rigid),
                 '--free', 'm1', 'Cv', 'Cc', 'kt', '--json', '-']) == 1
    data = json.loads(capsys.readouterr()[0])
    # Torque, inertia and friction have one scale in common.
    assert not any(data['values'][name]['determined'] for name in ('Cv', 'Cc', 'kt'))
    assert {name for pair in data['correlated'] for name in pair[:2]} >= {'Cv', 'Cc', 'kt'}


def test_the_feedforward_of_a_servo_is_found_from_nothing(tmp_path, capsys):
    servo = Controller(kp=6.0, kd=0.15, feedforward=0.12, feedforward_inertia=0.02)
    drive = replace(TRUE, torque_offset=0.0, transmission=Transmission('rigid'), controller=servo)
    t = np.arange(600) * 1e-2
    r = 0.8 * np.sin(2.0 * t) + 0.2 * np.sin(7.0 * t)
    y = simulate(drive, r, 1e-2).x[:, :2]
    y = y + 1e-3 * np.random.default_rng(4).standard_normal(y.shape)
    bag = tmp_path / 'servo.csv'
    np.savetxt(bag, np.column_stack([t, r, y]), '%.9g', ',', header='t,setpoint,motor,arm',
               comments='')
    stated = replace(drive, controller=replace(servo, feedforward=0.0, feedforward_inertia=0.0))
    assert main(['fit', 'model', str(bag), '--model', model_file(tmp_path / 'd.yaml', stated),
                 '--free', 'kff', 'kaff', '--json', '-']) == 0
    data = json.loads(capsys.readouterr()[0])
    for name, unit, true in (('kff', 'N m s/rad', 0.12), ('kaff', 'kg m^2', 0.02)):
        fitted = data['values'][name]
        assert (fitted['start'], fitted['unit']) == (0.0, unit)
        assert abs(fitted['value'] - true) < 4.0 * fitted['error'] < 0.2 * true


BAD_USAGE = [
    (['--free', 'mass'], ("'mass'", 'expected one of m1')),
    (['--free', 'Cv', 'Cc', 'Cv'], ("'Cv' twice", 'expected each name once')),
    (['--windows', '0.5'], ('--windows', '0.5', 'at least 1 s')),
    (['--out', 'd.yaml'], ('d.yaml', 'exists')),
]


def test_bad_usage(tmp_path, capsys, monkeypatch):
    for words, parts in BAD_USAGE:
        monkeypatch.chdir(tmp_path)
        bag = record(tmp_path / 'a.csv', TRUE)
        model_file(tmp_path / 'd.yaml', TRUE)
        assert main(['fit', 'model', bag, '--model', 'd.yaml', *words]) == 2
        err = capsys.readouterr()[1]
        assert all(part in err for part in parts) and err.count('\n') == 1


@pytest.mark.parametrize('driven', [
    {}, {'driven_by': 'position', 'process_torque_time': 0.3}], ids=['torque', 'position'])
def test_a_delay_is_known_without_half_a_sample(driven):
    """By innovations and by the balance of the measured motion, in which searches begin."""
    dt, delay = 0.002, 0.008
    t = np.arange(0.0, 4.0, dt)
    u = 0.9 * np.sin(2.0 * np.pi * 0.4 * t) + 0.5 * np.sin(2.0 * np.pi * 3.1 * t)
    rigid = DriveModel().with_(kind='rigid', position_gain=0.0, arm_inertia=1e-6,
                               motor_inertia=0.03)
    true = rigid.with_(effects=({'id': 'actuator_delay', 'T': delay},))
    start = rigid.with_(effects=({'id': 'actuator_delay', 'T': 0.005},), viscous_friction=0.2,
                        **driven)
    run = simulate(true, u, dt, Noise(measurement=(2e-5, 2e-5)))
    recording = load_recording({'t': t, 'torque': u, 'motor': np.full(len(t), np.nan),
                                'arm': run.y[:, 1]}, start, name='run').uniform()[0]
    found = nominal.fit_nominal([recording], start, ['m1', 'Cv', 'Cc', 'actuator_delay'])
    values = {v.name: v for v in found.values}
    assert abs(values['actuator_delay.T'].value - delay) < 0.1 * dt
    assert abs(values['Cv'].value / true.viscous_friction - 1.0) < 0.01
    assert found.gap_after < 0.1 * found.gap_before
    assert found.covariance.shape == (4, 4)
    assert np.allclose(np.sqrt(np.diag(found.covariance)), [v.error for v in found.values])


def followed(frequencies, effects):
    """Return recordings of a servo that follows its setpoint, and its model with wrong values."""
    t, noise = np.arange(0.0, 5.0, 0.005), np.random.default_rng(3)
    true = DriveModel().with_(
        kind='rigid', position_gain=0.0, motor_inertia=0.02, arm_inertia=1e-6, tolerance=0.3,
        viscous_friction=0.06, coulomb_friction=0.08, effects=effects,
        controller={'kp': 5.0, 'kd': 0.05, 'tolerance': 0.5})
    stated = true.with_(motor_inertia=0.03, viscous_friction=0.1, coulomb_friction=0.05,
                        controller={'kp': 6.0, 'kd': 0.05, 'tolerance': 0.5})
    recordings = []
    for hertz in frequencies:
        r = 0.6 * np.sin(2.0 * np.pi * hertz * t) + 0.4 * np.sin(2.0 * np.pi * 1.3 * t + 1.0)
        q = simulate(true, r, 0.005).x[:, 0] + 5e-4 * noise.standard_normal(len(t))
        recordings.append(load_recording({'t': t, 'setpoint': r, 'motor': q}, stated,
                                         name='run').uniform()[0])
    return recordings, stated


def test_the_values_of_a_servo_with_a_known_load():
    recordings, stated = followed([0.4], ({'id': 'gravity', 'G': 0.5},))
    fit = nominal.fit_nominal(recordings, stated, ['m1', 'Cv', 'Cc', 'kp'])
    for value, at in zip(fit.values, (0.02, 0.06, 0.08, 5.0)):
        assert abs(value.value - at) < 3.0 * value.error < 0.02 * at, value


def test_a_servo_without_a_known_load_has_ratios_only():
    """A servo that is weaker throughout leaves less torque, and is no likelier."""
    recordings, stated = followed([0.4, 0.6], ())
    values = nominal.fit_nominal(recordings, stated, ['m1', 'kp', 'Cv', 'Cc']).values
    assert not any(value.determined for value in values)
    inertia, gain = values[:2]
    assert abs(gain.value - 5.0) < gain.error
    assert inertia.value / gain.value == pytest.approx(0.02 / 5.0, rel=0.02)
