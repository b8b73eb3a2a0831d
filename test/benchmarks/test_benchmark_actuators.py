# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A joint of the catalogue: its own values beside the link that it moves, judged by other days."""
import gzip
import json

import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.actuators import _log, _of_joint, _with_guesses
from gearbox_monitor.diagnosis.joint.parameter_ranges import ranges_of
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, simulate

PENDULUM = """<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial>
    <origin xyz="0 0 -0.2"/><mass value="0.5"/>
    <inertia ixx="0.001" iyy="0.001" izz="1e-5" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <joint name="joint" type="continuous"><parent link="base"/><child link="rod"/>
    <axis xyz="0 -1 0"/></joint>
</robot>"""
TRUE = {'m1': 0.03, 'Cv': 0.15, 'Cc': 0.4}


def test_joint_has_its_values_beside_a_link_and_is_judged_by_other_days(tmp_path):
    path = tmp_path / 'pendulum.urdf'
    path.write_text(PENDULUM)
    drive = DriveModel().with_(
        kind='rigid', position_gain=0.0, motor_inertia=TRUE['m1'], arm_inertia=0.021,
        viscous_friction=TRUE['Cv'], coulomb_friction=TRUE['Cc'],
        effects=({'id': 'gravity', 'G': 0.5 * 9.80665 * 0.2},))
    chain, t = _with_guesses(path, 0.02, 0.1, 0.2), np.arange(0.0, 25.0, 5e-3)
    days = {}
    for seed, day in enumerate(('monday', 'tuesday')):
        phase = np.random.default_rng(seed).uniform(0.0, 6.3, 3)
        u = sum(a * np.sin(2 * np.pi * f * t + p)
                for a, f, p in zip((1.2, 0.8, 0.5), (0.3, 1.1, 2.7), phase))
        run = simulate(drive, u, 5e-3, Noise(measurement=(1e-5, 1e-5)), seed)
        days[day] = [_log(chain, day, t, run.y[:, 1:], np.asarray(u)[:, None])]
    measured = _of_joint(days, chain, 0)
    ranges = ranges_of(measured.estimates)
    for name, low, value, high in zip(ranges.names, ranges.low, ranges.centre, ranges.high):
        assert value == pytest.approx(TRUE[name], rel=0.1), name
        assert low < TRUE[name] < high
    judged = measured.judged(ranges)
    assert all(error < 0.1 * without
               for error, without in zip(judged['error'], judged['without']))


def test_a_servo_without_a_motion_to_fit_is_one_line(tmp_path, capsys):
    (tmp_path / 'xl330').mkdir()
    row = {'timestamp': 0.0, 'position': 0.0, 'goal_position': 0.0, 'torque_enable': True}
    for name in 'ab':
        with gzip.open(tmp_path / f'xl330/{name}.json.gz', 'wt', encoding='utf-8') as file:
            json.dump({'mass': 0.5, 'length': 0.1, 'kp': 200, 'trajectory': 'lift_and_drop',
                       'entries': [row, {**row, 'timestamp': 1.0}]}, file)
    assert main(['actuators', 'xl330', str(tmp_path)]) == 2
    shown = capsys.readouterr().err
    assert '0 recordings to fit and 2 to judge' in shown and shown.count('\n') == 1
