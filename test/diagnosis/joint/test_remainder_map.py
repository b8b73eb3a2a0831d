# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Torque maps of what no effect explains, on recordings of a plant that shares no code."""
import numpy as np
import pytest

from benchmarks.blind import plant as own
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.signals.uniform import UniformRecording

DT, NOISE = 1e-3, 2e-3


def recorded(*effects, seconds=9.0, seed=0):
    t = DT * np.arange(round(seconds / DT))
    u = Excitation().torque(t) * (0.6 + 0.4 * np.sin(2.0 * np.pi * 0.13 * t))
    _, y = own.simulate(own.NOMINAL, effects, u, DT)
    noise = NOISE * np.random.default_rng(seed).standard_normal(y.shape)
    return UniformRecording(t, u, y + noise, DT)


@pytest.mark.system
@pytest.mark.parametrize('effect, place, variable, law', [
    ({'id': 'arm_spring', 'k': 0.8}, 'arm_side', 'angle', lambda x: -0.8 * x),
    ({'id': 'motor_quadratic', 'C2': 0.004}, 'motor_side', 'speed',
     lambda x: -0.004 * x * np.abs(x))],
    ids=['spring', 'quadratic'])
def test_map_is_the_law_that_the_library_lacks(effect, place, variable, law):
    model = model_from_dict({}, 'test')
    verdict = diagnose([recorded(effect)], model, validate=recorded(effect, seconds=4.0, seed=1),
                       only=['torque_map'])
    data, table = verdict.data, verdict.data['remainders'][0]['torque_map']
    assert (data['verdict'], data['effect'], data['findings']) == ('unknown', None, [])
    assert (table['place'], table['variable']) == (place, variable)
    assert data['misfit']['follows']['gain'] > 100.0
    knots, values, deviations = (np.array(table[k]) for k in ('knots', 'values', 'deviations'))
    inner = slice(1, -1)  # the outermost knots have readings on one side only
    assert np.abs(values - law(knots))[inner].max() < 0.05 * np.abs(law(knots)).max()
    assert (deviations > 0.0).all()
    assert data['closed_fraction'] > 0.9 and data['validation']['closed_fraction'] > 0.9
    assert [e['id'] for e in verdict.model.effects] == ['torque_map']


def test_no_map_of_noise():
    """Nothing is missing: neither an effect nor a map, and the model stays as it is."""
    model = model_from_dict({}, 'test')
    verdict = diagnose([recorded()], model, only=['torque_map'])
    assert verdict.data['verdict'] == 'none' and verdict.data['remainders'] == []
    assert verdict.model == model


@pytest.mark.system
def test_excluded_or_already_there():
    """Without a map the gap stays; a model has one map at most."""
    spring = recorded({'id': 'arm_spring', 'k': 0.8}, seconds=4.0)
    data = diagnose([spring], model_from_dict({}, 'test'), only=['motor_inertia']).data
    assert data['verdict'] == 'unknown' and data['remainders'][0]['torque_map'] is None
    assert data['closed_fraction'] is None or data['closed_fraction'] >= 0.0
