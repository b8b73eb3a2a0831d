# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One joint with one encoder gets one answer, as a drive and as a robot of one link."""
import json

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.simulate import Noise, simulate

DT, WEIGHT, INERTIA = 0.005, 1.5, 0.07
DRIVE = {'motor_inertia': 0.02, 'arm_inertia': 0.05, 'viscous_friction': 0.05,
         'coulomb_friction': 0.12, 'friction_sharpness': 1000.0, 'position_gain': 0.0,
         'transmission': {'kind': 'rigid'},
         'effects': [{'id': 'gravity', 'G': WEIGHT}]}
REACH = WEIGHT / 9.80665  # m, of 1 kg
URDF = f"""<robot name="pendulum"><link name="base"/><link name="rod"><inertial>
<mass value="1"/><origin xyz="0 0 -{REACH}"/>
<inertia ixx="1e-3" iyy="{INERTIA - REACH ** 2}" izz="1e-3" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="motor" type="continuous"><parent link="base"/><child link="rod"/>
<axis xyz="0 1 0"/><dynamics damping="0.05" friction="0.12"/></joint></robot>"""


def log(path, seed, gain=1.0, **changes):
    """Write the log of a pendulum with `changes` of its drive."""
    random = np.random.default_rng(seed)
    t = np.arange(12000) * DT
    u = sum(a * np.sin(2.0 * np.pi * f * t + p) for a, f, p in zip(
        (1.0, 0.6, 0.5), np.array((0.21, 0.53, 1.1)) * random.uniform(0.9, 1.1, 3),
        random.uniform(0.0, 2.0 * np.pi, 3)))
    model = model_from_dict({**DRIVE, **changes}, 'test')
    y = simulate(model, gain * u, DT, Noise(measurement=(2e-4, 2e-4)), seed).y
    np.savetxt(path, np.column_stack([t, u, y[:, 0]]), delimiter=',', header='t,u,motor',
               comments='')
    return str(path)


def answers(tmp_path, capsys, path, *options):
    """Return (verdict, {effect: values, deviations}) of the drive and of the robot."""
    out = []
    for name, text in (('drive.yaml', yaml.safe_dump({**DRIVE, 'tolerance': 0.05})),
                       ('pendulum.urdf', URDF)):
        (tmp_path / name).write_text(text)
        main(['diagnose', path, '--model', str(tmp_path / name), *options, '--json', '-'])
        data = json.loads(capsys.readouterr().out)
        out.append((data['verdict'], {f['effect']: (f['values'], f['deviations'])
                                      for f in data['findings']}))
    return out


@pytest.mark.parametrize('changes, effect, value, size', [
    ({}, None, '', 0.0),
    ({'coulomb_friction': 0.2}, 'motor_coulomb', 'Cc_change', 0.08),
    pytest.param({'gain': 0.85}, 'torque_gain', 'g', -0.15, marks=pytest.mark.system)])
def test_a_reference_gives_one_answer_at_both_doors(tmp_path, capsys, changes, effect, value,
                                                    size):
    reference, path = log(tmp_path / 'reference.csv', 1), log(tmp_path / 'log.csv', 2, **changes)
    for verdict, found in answers(tmp_path, capsys, path, '--reference', reference):
        assert verdict == ('effect' if effect else 'none')
        assert list(found) == [effect] * bool(effect)
        for values, deviations in found.values():
            assert abs(values[value] - size) < max(3.0 * deviations[value], 0.1 * abs(size))


@pytest.mark.system
@pytest.mark.parametrize('changes, effect', [
    ({}, None), ({'gain': 0.85}, 'torque_gain'), ({'coulomb_friction': 0.2}, 'motor_coulomb')])
def test_a_model_file_gives_one_answer_at_both_doors(tmp_path, capsys, changes, effect):
    path = log(tmp_path / 'log.csv', 2, **changes)
    for verdict, found in answers(tmp_path, capsys, path):
        # Of a load, which a robot's link may carry, a motion may say too little.
        assert verdict in (('effect',) if effect else ('none', 'undecided'))
        assert list(found) == [effect] * bool(effect)


def test_a_reference_of_two_encoders_is_refused(tmp_path, capsys):
    (tmp_path / 'drive.yaml').write_text(yaml.safe_dump({**DRIVE, 'transmission': {
        'kind': 'play', 'stiffness': 5.0, 'half_gap': 0.1}}))
    t = np.arange(2000) * DT
    both = np.column_stack([t, np.sin(t), np.sin(t), np.sin(t) + 1e-3 * np.cos(7.0 * t)])
    np.savetxt(tmp_path / 'log.csv', both, delimiter=',', header='t,u,motor,arm', comments='')
    assert main(['diagnose', str(tmp_path / 'log.csv'), '--model', str(tmp_path / 'drive.yaml'),
                 '--reference', str(tmp_path / 'log.csv')]) == 2
    assert 'two encoders of a drive, expected one with a reference' in capsys.readouterr().err
