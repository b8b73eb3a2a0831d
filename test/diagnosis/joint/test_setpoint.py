# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Diagnosis of a servo by its setpoint: effects before, in and behind the loop, gains in doubt."""

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.candidates import nuisances_of, Starts
from gearbox_monitor.diagnosis.joint.diagnose import diagnose, visible
from gearbox_monitor.diagnosis.joint.innovations import noise_floor
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.diagnosis.joint.windows import validate
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import UniformRecording

DT = 0.01
STATED = {'kp': 6.3, 'kd': 0.145, 'torque_limit': 8.0, 'tolerance': 0.06}  # the true ones: 6, 0.15
MODEL = model_from_dict({'controller': STATED}, 'stated')


def recorded(*effects, columns=(0, 1), noise=0.003, true=None, stated=MODEL):
    """
    Return 6 s at 100 Hz of the true drive with `effects`, these encoders and `noise` (rad).

    true: its servo. stated: the model that is given.
    """
    t = DT * np.arange(600)
    setpoint = (1.5 * np.sin(2 * np.pi * 0.7 * t) + 0.4 * np.sin(2 * np.pi * 2.1 * t)
                + np.repeat(np.random.default_rng(7).uniform(-0.6, 0.6, 12), 50))
    servo = true or {**STATED, 'kp': 6.0, 'kd': 0.15}
    drive = model_from_dict({'controller': servo, 'effects': list(effects)}, 'true')
    y = Plant(drive).run(setpoint, DT).y
    y += noise * np.random.default_rng(5).standard_normal(y.shape)
    y[:, [i for i in (0, 1) if i not in columns]] = np.nan
    return admitted(t, setpoint, y, None, 'servo', stated, 'stated')[0]


@pytest.mark.parametrize('effect, columns', [
    ({'id': 'setpoint_delay', 'T': 0.025}, (0, 1)),
    *(pytest.param(effect, columns, marks=pytest.mark.system) for effect, columns in (
        ({'id': 'servo_gain', 'kp': 4.0}, (0,)), ({'id': 'servo_delay', 'T': 0.01}, (0, 1)),
        ({'id': 'servo_integrator', 'ki': 8.0}, (0,)),
        ({'id': 'servo_feedforward', 'kff': 0.12}, (0,)),
        ({'id': 'stiffness', 'K': 15.0}, (1,))))])
def test_effect_is_named_with_gains_in_doubt(effect, columns):
    only = {'setpoint_delay', 'servo_delay', 'servo_gain', 'motor_viscous', effect['id']}
    verdict = diagnose([recorded(effect, columns=columns)], MODEL, only=sorted(only)).to_dict()
    assert (verdict['verdict'], verdict['effect']) == ('effect', effect['id'])
    assert verdict['location'] == EFFECTS[effect['id']].location
    name = EFFECTS[effect['id']].parameters[0].name
    assert verdict['params'][effect['id']][name] == pytest.approx(effect[name], rel=0.05)
    if effect['id'] != 'servo_gain':
        assert verdict['nominal']['kp'] == pytest.approx(6.0, rel=0.01)


@pytest.mark.parametrize('effects', [
    (), pytest.param(({'id': 'motor_viscous', 'Cv': 0.12},), marks=pytest.mark.system)])
def test_of_ties_the_gain_that_the_model_states_is_named(effects):
    """Without damping and limit of the servo, a torque scale is the same motion."""
    stated = {**STATED, 'kd': 0.0, 'tolerance': 0.0, 'torque_limit': 50.0}
    recording = recorded({'id': 'servo_gain', 'kp': 4.0}, *effects, true=stated,
                         stated=model_from_dict({'controller': stated}, 'stated'))
    verdict = diagnose([recording], model_from_dict({'controller': stated}, 'stated'),
                       only=['torque_gain', 'servo_gain', 'motor_viscous']).to_dict()
    assert set(verdict['params']) == {'servo_gain', *(e['id'] for e in effects)}
    assert 'torque_gain' in verdict['confusable']


def test_right_model_with_gains_in_doubt_has_no_effect():
    verdict = diagnose([recorded()], MODEL, only=['servo_deadband']).to_dict()
    assert verdict['verdict'] == 'none'
    assert verdict['nominal']['kp'] == pytest.approx(6.0, rel=0.01)


@pytest.mark.system
def test_unknown_gains_of_a_late_servo_are_fitted():
    true = {'kp': 6.0, 'kd': 0.15, 'ki': 8.0, 'feedforward': 0.1, 'delay': 0.004, 'rate': 500.0,
            'torque_limit': 8.0}
    stated = model_from_dict(
        {'controller': {**true, 'kp': 11.0, 'kd': 0.25, 'ki': 3.0, 'feedforward': 0.2,
                        'tolerance': 1.0}}, 'stated')
    verdict = diagnose([recorded(true=true, stated=stated)], stated,
                       only=['servo_deadband', 'motor_inertia']).to_dict()
    assert verdict['verdict'] == 'none'
    for name, key in (('kp', 'kp'), ('kd', 'kd'), ('ki', 'ki'), ('kff', 'feedforward')):
        assert verdict['nominal'][name] == pytest.approx(true[key], rel=0.03)


def test_models_are_compared_with_their_own_gains():
    effect = {'id': 'servo_gain', 'kp': 4.0}
    recording, closed = recorded(effect), model_from_dict(
        {'controller': {**STATED, 'kd': 0.15}, 'effects': [effect]}, 'closed')
    sigma, _ = noise_floor(recording, MODEL)
    figures = validate(recording, MODEL, closed, sigma)
    assert figures['gap_before'] > 50.0 and figures['gap_after'] < 1.1


def test_gains_scatter_by_their_own_tolerance():
    assert nuisances_of(MODEL) == {'kp': 0.06, 'kd': 0.06}
    both = model_from_dict({'controller': STATED, 'tolerance': 0.02}, 'both')
    assert nuisances_of(both)['kp'] == 0.06 and nuisances_of(both)['m1'] == 0.02
    assert 'kp' not in nuisances_of(model_from_dict({'tolerance': 0.02}, 'torque'))


def test_effects_fit_what_is_recorded():
    recording = recorded()
    for name, effect in EFFECTS.items():
        assert visible(name, MODEL, recording) == (not effect.torque_only)
        assert visible(name, model_from_dict({}, 'torque'), recording) == (
            effect.location != 'controller')
    scales = Starts(MODEL, [recording]).scales
    assert 0.5 < scales.torque < 8.0 and scales.values['kp'] == 6.3


def test_fit_nominal_finds_the_gain_of_a_servo_that_swings_a_weight_it_knows():
    effects = [{'id': 'gravity', 'G': 1.0}, {'id': 'load_friction', 'Cl': 0.3}]
    truth = model_from_dict({'transmission': {'kind': 'rigid'}, 'effects': effects,
                             'controller': {'kp': 6.0, 'torque_limit': 3.0}}, 'true')
    t = np.arange(800) * 0.01
    setpoint = 0.9 * np.sin(2.0 * t) + 0.4 * np.sin(7.0 * t)
    run = Plant(truth).run(setpoint, 0.01)
    y = run.y + 1e-3 * np.random.default_rng(1).standard_normal((len(t), 2))
    recording = UniformRecording(t, setpoint, y, 0.01).with_servo(truth.controller)
    stated = model_from_dict({
        'transmission': {'kind': 'rigid'}, 'viscous_friction': 0.2, 'coulomb_friction': 0.1,
        'effects': [effects[0], {'id': 'load_friction', 'Cl': 0.1}],
        'controller': {'kp': 4.5, 'torque_limit': 3.0, 'tolerance': 1.0}}, 'stated')
    fit = fit_nominal([recording], stated, ['m1', 'Cv', 'Cc', 'kp', 'load_friction'], seconds=9.0)
    assert fit.model.controller.kp == pytest.approx(6.0, rel=0.02)
    assert fit.model.effects[1]['Cl'] == pytest.approx(0.3, rel=0.1)
