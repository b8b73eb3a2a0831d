# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Parameters of a drive in the names and units of other simulators."""
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.export.parameter_list import parameter_list, TARGETS
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.effects import EFFECTS

MODEL = model_from_dict({
    'transmission': {'kind': 'rigid'}, 'gear_ratio': 50.0, 'position_gain': 0.0, 'effects': [
        {'id': 'motor_inertia', 'm1': 0.008}, {'id': 'stribeck', 'Cs': 0.1, 'vs': 0.3},
        {'id': 'arm_coulomb', 'Cac': 0.05}, {'id': 'saturation', 'umax': 4.0}]}, 'test')


@pytest.mark.parametrize('target, values, lacking', [
    ('urdf', {'dynamics friction': 0.32, 'limit effort': 4.0}, {'stribeck', 'motor_inertia'}),
    ('sdf', {'axis/dynamics/damping': 0.1}, {'stribeck', 'motor_inertia'}),
    ('isaac', {'armature': 0.008, 'effort_limit_sim': 4.0}, {'stribeck'}),
    ('drake', {'drake:rotor_inertia': 0.008 / 2500.0},
     {'stribeck', 'coulomb_friction', 'arm_coulomb'}),
    ('bam', {'friction_stribeck': 0.1, 'dtheta_stribeck': 0.3}, {'saturation'})])
def test_values_and_what_is_lacking(target, values, lacking):
    entries, refused = parameter_list(MODEL, target)
    found = {entry.name: entry.value for entry in entries}
    for name, value in values.items():
        assert found[name] == pytest.approx(value)
    assert {row.id for row in refused} == lacking


@pytest.mark.parametrize('target', TARGETS)
@pytest.mark.parametrize('name', ['mesh_error', 'lugre', 'actuator_lag', 'arm_encoder_delay'])
def test_an_effect_that_a_target_lacks_is_named(target, name):
    values = {p.name: max(p.low, 0.01) for p in EFFECTS[name].parameters}
    model = MODEL.with_(effects=[{'id': name, **values}])
    assert name in {row.id for row in parameter_list(model, target)[1]}


def test_the_command(tmp_path, capsys):
    (tmp_path / 'm.yaml').write_text('transmission: {kind: rigid}\nposition_gain: 0\n')
    assert main(['export', str(tmp_path / 'm.yaml'), '--to', 'isaac']) == 0
    assert 'armature' in capsys.readouterr().out
    assert main(['export', str(tmp_path / 'm.yaml'), '--to', 'isaac', '--into', 'robot.xml']) == 2
    capsys.readouterr()
    assert main(['export', str(tmp_path / 'm.yaml'), '--to', 'mjcf']) == 0
    assert '<mujoco' in capsys.readouterr().out
