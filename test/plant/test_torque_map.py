# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A torque map: what a law of the library says, said as a table, moves the drive alike."""
import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_model, save_model
from gearbox_monitor.plant.drive import fastest_eigenvalue, model_from_dict
from gearbox_monitor.plant.effects.torque_map import interpolated, packed, QUANTITIES
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Plant

DT = 1e-3
U = Excitation().torque(DT * np.arange(1500))
WIDE = [-1e3, 0.0, 1e3]  # a line through 0, which all laws below are


def torque_map(place, variable, knots, values):
    return {'id': 'torque_map', 'place': place, 'variable': variable, 'knots': list(knots),
            'values': list(values), 'deviations': [0.0] * len(values)}


def line(place, variable, slope):
    return torque_map(place, variable, WIDE, [slope * x for x in WIDE])


def run(model, *effects):
    return Plant(model_from_dict({**model, 'effects': list(effects)}, 'test')).run(U, DT)


LINES = [
    (line('motor_side', 'speed', -0.04), {}, {'id': 'motor_viscous', 'Cv': 0.14}),
    (line('motor_side', 'angle', -0.3), {}, {'position_gain': 0.31}),
    (line('motor_side', 'torque', 0.1), {}, {'id': 'torque_gain', 'g': 0.1}),
    (torque_map('motor_side', 'time', [0.0, 9.0], [0.2, 0.2]), {},
     {'id': 'torque_offset', 'u0': 0.2}),
    (line('arm_side', 'speed', -0.03), {}, {'id': 'arm_viscous', 'Cav': 0.03}),
    (torque_map('arm_side', 'time', [0.0, 9.0], [-0.2, -0.2]), {},
     {'id': 'load_torque', 'TL': 0.2}),
    (torque_map('arm_side', 'angle', [-1.0, 1.0], [-0.2, -0.2]), {},
     {'id': 'load_torque', 'TL': 0.2}),
    (line('transmission', 'twist', 4.0), {'transmission': {'half_gap': 0.0}},
     {'id': 'stiffness', 'K': 29.0})]


def test_a_line_is_the_law_that_is_one():
    for as_map, model, law in LINES:
        mapped = run(model, as_map)
        exact = run(model, law) if 'id' in law else run({**model, **law})
        assert np.abs(run(model).x - exact.x).max() > 1e-3
        np.testing.assert_allclose(mapped.x, exact.x, atol=2e-7 * np.abs(exact.x).max())


def test_is_linear_between_knots_and_constant_beyond():
    knots, values = np.array([-2.0, -0.5, 0.1, 3.0]), np.array([1.0, -1.0, 0.5, 2.0])
    c = np.array(packed(torque_map('arm_side', 'angle', knots, values)))
    x = np.linspace(-4.0, 5.0, 91)
    np.testing.assert_allclose([interpolated(c, 0, v) for v in x], np.interp(x, knots, values),
                               atol=1e-12)


def test_covers_each_place_and_variable():
    for place, variable in QUANTITIES:
        model = model_from_dict({'effects': [line(place, variable, 0.1)]}, 'test')
        assert np.count_nonzero(model.pack_effects()) > 3


def test_steep_maps_shorten_the_steps():
    steep = [model_from_dict({'effects': [line(place, 'speed', -500.0)]}, 'test')
             for place in ('motor_side', 'arm_side')]
    plain = fastest_eigenvalue(model_from_dict({}, 'test'))
    assert all(fastest_eigenvalue(model) > 1.1 * plain for model in steep)


def test_survives_a_model_file(tmp_path):
    model = model_from_dict({'effects': [line('arm_side', 'angle', 0.1)]}, 'test')
    save_model(tmp_path / 'drive.yaml', model, ['a map'])
    assert load_model(tmp_path / 'drive.yaml') == model


NO_MAPS = [
    ({'place': 'elbow'}, r'effects.torque_map.place: .elbow., expected one of motor_side'),
    ({'variable': 'twist'}, r'variable: .twist., expected one of speed, time, angle with place'),
    ({'knots': [0.0, 0.0]}, 'knots: .*expected numbers that rise'),
    ({'knots': [0.0]}, 'knots: 1 numbers, expected 2 to 16'),
    ({'values': [1.0]}, 'values: 1 numbers, expected one for each of the 2 knots'),
    ({'values': 'x'}, 'values: .x., expected a list'),
    ({'values': [1.0, float('nan')]}, 'values: nan, expected a finite number'),
    ({'deviations': [-1.0, 0.0]}, 'deviations: -1.0, expected a finite number >= 0')]


def test_refuses_what_is_no_map():
    for change, message in NO_MAPS:
        item = {**torque_map('arm_side', 'angle', [0.0, 1.0], [0.0, 1.0]), **change}
        with pytest.raises(InputError, match=message):
            model_from_dict({'effects': [item]}, 'model.yaml')
