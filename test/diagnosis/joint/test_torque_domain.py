# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Diagnosis with `driven_by: position`: the motor's motion is put in, its torque comes out."""
import json
import math
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.joint import nominal
from gearbox_monitor.diagnosis.joint.drive_recordings import evidence_of
from gearbox_monitor.diagnosis.joint.torque_domain import BalanceSimulator, driven
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.files.user_files import config_path, load_model
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.recordings.reading import read_mapping, ReadOptions
from gearbox_monitor.recordings.si_signals import signals_of
from gearbox_monitor.signals.uniform import UniformRecording

DATA = Path(__file__).resolve().parents[4] / 'shared' / 'data' / 'davinci_backend'
DT = 1e-3
CUBIC = 3  # samples on either side, that the arm's acceleration comes from
GAP = {'kind': 'dead_zone', 'stiffness': 25.0, 'half_gap': 0.05}
KERNELS = {
    'dead_zone': {'transmission': GAP},
    'passive_play': {'transmission': {**GAP, 'kind': 'passive_play', 'hysteresis_width': 0.02,
                                      'hysteresis_stiffness': 5.0}},
    'rigid': {'transmission': {'kind': 'rigid'}},
    'arm': {'transmission': GAP, 'effects': [
        {'id': 'arm_coulomb', 'Cac': 0.05}, {'id': 'gravity', 'G': 0.1},
        {'id': 'arm_viscous', 'Cav': 0.02}]},
    'transmission': {'transmission': GAP, 'effects': [
        {'id': 'mesh_error', 'A': 0.02, 'N': 5, 'phi': 0.3},
        {'id': 'hysteresis_bouc_wen', 'Th': 0.05, 'dh': 0.01},
        {'id': 'hysteresis_branch', 'h': 0.01, 'ds': 0.02}]},
    'friction': {'transmission': GAP, 'effects': [
        {'id': 'stribeck', 'Cs': 0.1, 'vs': 0.3}, {'id': 'load_friction', 'Cl': 0.1}]},
    'actuator': {'transmission': GAP, 'effects': [
        {'id': 'torque_gain', 'g': 0.1}, {'id': 'actuator_lag', 'T': 0.01},
        {'id': 'torque_ripple', 'A': 0.1, 'N': 3, 'phi': 0.0}]},
    'encoders': {'transmission': GAP, 'effects': [
        {'id': 'motor_encoder_eccentricity', 'A': 0.02, 'phi': 0.4},
        {'id': 'motor_encoder_delay', 'T': 0.0035}, {'id': 'arm_encoder_delay', 'T': 0.0035}]},
}
# A light motor behind much friction moves a load that a sensor on the arm measures.
SERVO = {
    'driven_by': 'position', 'process_torque_time': 0.3, 'zero_tolerance': 0.2,
    'arm_load': 'measured', 'motor_inertia': 6e-4, 'arm_inertia': 1e-3, 'damping': 0.02,
    'viscous_friction': 0.01, 'coulomb_friction': 0.02, 'friction_sharpness': 300.0,
    'position_gain': 0.0,
    'transmission': {'kind': 'dead_zone', 'stiffness': 30.0, 'half_gap': 0.001}}
LOAD = ({'id': 'arm_viscous', 'Cav': 0.04}, {'id': 'gravity', 'G': 0.06})
FEW = ('backlash_gap', 'stiffness', 'mesh_error', 'motor_coulomb', 'stribeck')


def compared(model, seconds):
    """Return the surplus of torque (N m) and twist (rad) [2, N]; where a contact closes [N]."""
    t = np.arange(round(seconds / DT)) * DT
    u = 0.8 * np.sin(2 * np.pi * 0.7 * t) + 0.5 * np.sin(2 * np.pi * 1.9 * t + 1.0)
    plant = simulate(model, u, DT)
    motor = plant.y[:, 0]
    speed = np.gradient(motor, DT)
    path = np.column_stack([motor, speed, np.gradient(speed, DT), np.ones(len(t)), u])
    recording = UniformRecording(t, u, np.column_stack([u, plant.y[:, 1]]), DT, motor=path)
    bend = np.abs(np.diff(plant.tau_k, 2, prepend=plant.tau_k[0], append=plant.tau_k[-1]))
    return (BalanceSimulator(recording, model).surplus(model).T,
            np.convolve(bend > 0.005, np.ones(2 * CUBIC + 3), 'same') > 0.5)


def expect_need(name):
    (torque, arm), contact = compared(model_from_dict(KERNELS[name], name), 0.5)
    # rad, of a gap of 0.1; a cubic through the readings rounds off what a contact does to the arm.
    # Beside hysteresis, a contact of little torque bends nothing.
    off = np.flatnonzero(np.abs(arm) > 5e-4)
    assert contact.mean() < 0.16 and np.abs(arm).max() < 4e-3
    assert len(np.setdiff1d(off, np.flatnonzero(contact))) <= (4 if name == 'transmission' else 0)
    # Where the speed changes its sign, differences of the position are no acceleration; of what
    # acted before the recording, a delayed or lagged signal knows nothing.
    assert np.percentile(np.abs(torque[100:]), 95.0) < 0.01  # N m, of 0.67 rms


def test_it_needs_the_torque_that_moved_it():
    for name in KERNELS:
        expect_need(name)


def sampled():
    """Return some numbers of two driven runs, as their bits are."""
    return [float(v).hex() for name in ('transmission', 'arm') for v in np.ravel(
        compared(model_from_dict(KERNELS[name], name), 0.05)[0][:, ::7])]


@pytest.mark.system
def test_interpreted_is_compiled():
    code = ('import sys; sys.path[:0] = sys.argv[1:]; import test_torque_domain as t; '
            'print(*t.sampled())')
    here = Path(__file__).parent
    folders = [str(folder) for folder in (here.parents[2], here.parents[1], here)]
    out = [subprocess.run([sys.executable, '-c', code, *folders], check=True,
                          capture_output=True, text=True,
                          env={**os.environ, 'GEARBOX_MONITOR_KERNELS': kernels}).stdout
           for kernels in ('', 'python')]
    one, other = (text.split() for text in out)
    assert len(one) > 20 and one == other


def recorded(path, *effects, seconds=4.5):
    """Write a recording of SERVO with `effects`; returns its path."""
    t = np.arange(round(seconds / DT)) * DT
    u = Excitation('multisine', (0.12, 0.05, 0.03), (0.3, 0.8, 1.7)).torque(t)
    plant = simulate(model_from_dict({**SERVO, 'effects': [*LOAD, *effects]}, 'plant'), u, DT)
    random = np.random.default_rng(3)
    y = plant.x[:, :2] + 2e-4 * random.standard_normal((len(t), 2)) + (0.0, 0.1)
    measured = u + 0.005 * random.standard_normal(len(t))
    np.savetxt(path, np.column_stack([t, measured, y, plant.tau_arm]), '%.9g', ',',
               header='t,u,motor,arm,arm_torque', comments='')
    return str(path)


def diagnosed(folder, recording, capsys, *words, model=SERVO):
    """Return the verdict on `recording`."""
    (folder / 'drive.yaml').write_text(yaml.safe_dump(model))
    main(['diagnose', recording, '--model', str(folder / 'drive.yaml'), '--only', *FEW,
          '--json', '-', *words])
    return json.loads(capsys.readouterr()[0])


@pytest.mark.parametrize('effect', [
    *(pytest.param(effect, marks=pytest.mark.system) for effect in (
        {'id': 'backlash_gap', 'b': 0.013}, {'id': 'mesh_error', 'A': 0.004, 'N': 7, 'phi': 0.4})),
    {'id': 'motor_coulomb', 'Cc': 0.03}], ids=lambda effect: effect['id'])
def test_an_effect_of_the_plant_is_found(tmp_path, capsys, effect):
    """The residual of balances has no size and no duration of its own: null, not demanded."""
    recording = recorded(tmp_path / 'a.csv', effect)
    data, lasting = (diagnosed(tmp_path, recording, capsys, model={
        **SERVO, 'process_torque_time': time}) for time in (0.0, 0.3))
    assert data == lasting and data['process_torque'] is None
    assert (data['verdict'], data['effect']) == ('effect', effect['id'])
    found = data['params'][effect['id']]
    for name, value in effect.items():
        if name != 'id':
            assert found[name] == pytest.approx(value, rel=0.05), name
    assert data['gap_after'] < 0.7 * data['gap_before'] and data['gap_after'] < 2.0


def test_values_and_parameters_of_effects_are_fitted(tmp_path, capsys):
    def effects(b, A, phi):
        return [{'id': 'backlash_gap', 'b': b}, {'id': 'mesh_error', 'A': A, 'N': 7, 'phi': phi}]

    bag = recorded(tmp_path / 'a.csv', *effects(0.013, 0.004, 0.4))
    (tmp_path / 'near.yaml').write_text(
        yaml.safe_dump({**SERVO, 'effects': effects(0.011, 0.003, 0.0)}))
    main(['fit', 'model', bag, '--model', str(tmp_path / 'near.yaml'), '--free', 'b', 'zero',
          'mesh_error', '--windows', '5', '--out', str(tmp_path / 'fitted.yaml'), '--json', '-'])
    values = json.loads(capsys.readouterr()[0])['values']
    assert values['zero']['value'] == pytest.approx(0.1, abs=5e-4)
    assert (tmp_path / 'fitted.yaml').read_text().startswith('# Fitted with gearbox_monitor')
    fitted = load_model(tmp_path / 'fitted.yaml')
    assert fitted.transmission.half_gap == pytest.approx(0.013, rel=0.03)
    mesh, = (e for e in fitted.effects if e['id'] == 'mesh_error')
    assert mesh['A'] == pytest.approx(0.004, rel=0.05)
    assert mesh['phi'] == pytest.approx(0.4, abs=0.05)


@pytest.mark.system
def test_three_effects_from_one_command(tmp_path, capsys):
    effects = [{'id': 'backlash_gap', 'b': 0.013}, {'id': 'motor_coulomb', 'Cc': 0.03},
               {'id': 'mesh_error', 'A': 0.004, 'N': 7, 'phi': 0.4}]
    bag = recorded(tmp_path / 'a.csv', *effects, seconds=10.0)
    data = diagnosed(tmp_path, bag, capsys)
    assert data['verdict'] == 'effect'
    assert sorted(data['effect'].split('+')) == sorted(e['id'] for e in effects)
    assert data['params']['mesh_error']['N'] == 7
    assert data['params']['mesh_error']['A'] == pytest.approx(0.004, rel=0.08)
    assert {e['effect'] for e in data['findings']} == {e['id'] for e in effects}


def test_friction_is_fitted_to_balances(tmp_path):
    t, u, motor, arm, load = np.loadtxt(recorded(
        tmp_path / 'a.csv', {'id': 'motor_coulomb', 'Cc': 0.05}), delimiter=',', skiprows=1).T
    model = model_from_dict(SERVO, 'test')
    recording = driven(
        UniformRecording(t, u, np.column_stack([motor, arm]), DT, arm_torque=load), model)
    evidence = evidence_of([recording], model, ())
    candidate = nominal._free_candidate(evidence.starts, model, model, ['Cc', 'zero'])
    evidence, fit = nominal._searched(evidence, candidate, lambda *_: None)
    assert fit.model.coulomb_friction == pytest.approx(0.05, rel=0.05)


def test_a_fit_whose_free_runs_are_farther_off_is_not_written():
    """Of a servo, the misfit went from 31 to 176."""
    for before, after in ((31.0, 176.0), (31.0, math.nan), (1.0, math.inf)):
        with pytest.raises(Undecided, match='of the fit .*: no solution'):
            nominal._expect_no_farther(before, after)
    for before, after in ((31.0, 1.0), (31.0, 31.2), (math.nan, 5.0), (math.inf, 5.0)):
        nominal._expect_no_farther(before, after)


def test_nothing_is_found_where_nothing_is(tmp_path, capsys):
    """Either way, although the encoders share no zero."""
    recording = recorded(tmp_path / 'a.csv')
    for driven_by, first in (('position', 'torque'), ('torque', 'motor')):
        data = diagnosed(tmp_path, recording, capsys, model={**SERVO, 'driven_by': driven_by})
        assert data['verdict'] == 'none' and data['effect'] is None
        assert {gap['reading'] for gap in data['gaps']} == {first, 'arm'}


def test_bad_model_files():
    says = "drive.yaml: driven_by: 'speed', expected one of torque, position"
    with pytest.raises(InputError, match=says):
        model_from_dict({**SERVO, 'driven_by': 'speed'}, 'drive.yaml')


@pytest.mark.system
@pytest.mark.skipif(not DATA.exists(), reason='no recordings of the davinci_backend')
def test_a_real_gearbox_has_a_dead_zone(tmp_path, capsys):
    """8 s of one run, from a model with hardly any gap."""
    raw = signals_of(*read_mapping(DATA / '20.TXT.gz', ReadOptions('davinci_backend'))[:2])
    rows = np.column_stack([np.arange(8000) * DT, *(values[:8000] for values in (
        raw['motor_effort'], raw['motor_position'], raw['arm_position'], raw['arm_effort']))])
    np.savetxt(tmp_path / 'run.csv', rows, '%.9g', ',', header='t,u,motor,arm,arm_torque',
               comments='')
    model = yaml.safe_load(config_path('davinci_backend_nominal.yaml').read_text())
    data = diagnosed(tmp_path, str(tmp_path / 'run.csv'), capsys, model=model)
    named = (data['effect'] or '').split('+')
    assert data['verdict'] == 'effect' and 'backlash_gap' in named
    assert not {'stiffness', 'stribeck'} & set(named)
    # Lost motion of 1.7 deg, as its users know it; compliance takes a part of it.
    assert 1.2 < 2.0 * np.degrees(data['params']['backlash_gap']['b']) < 1.9
    arm = data['gaps'][-1]
    assert arm['reading'] == 'arm' and arm['after'] < 0.5 * arm['before']
