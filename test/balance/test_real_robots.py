# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Real arms: unloaded pairs are none, a load is named; skipped where the recordings are absent."""
import csv
import gzip
from pathlib import Path
import re

import numpy as np
import pytest

from gearbox_monitor.balance.knowledge import learn
from gearbox_monitor.balance.robot_log import checked_log, RawLog
from gearbox_monitor.balance.rows import RobotModel
from gearbox_monitor.balance.verdict import diagnose
from gearbox_monitor.robot.chain import chain_of, joint_losses
from gearbox_monitor.robot.description import parse

DATA = Path(__file__).parents[2].parent / 'shared/data'
CONSTANTS = np.array([10.0, 10.7, 8.46, 9.0, 9.48, 10.12])  # N m/A, as published
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason='needs ../shared/data')


def robot(name):
    """Return the RobotModel of a URDF whose friction is learnt."""
    path = DATA / name
    text = path.read_text()
    chain = chain_of(parse(text, path.name), joint_losses(text), path.name)
    return RobotModel(chain, np.full(len(chain.links), 0.4), 0.0, learnt=True)


def ur10e(name, joints, part=slice(None)):
    """Return a recording of the six-axis arm, without the rests at its ends."""
    with gzip.open(DATA / f'ur10e/{name}.csv.gz', 'rt') as file:
        rows = [row for row in csv.reader(file) if len(row) == 31]
    x = np.array([[float(v) if re.fullmatch(r'[-+.\deE]+', v) else np.nan for v in row]
                  for row in rows])
    x = x[np.abs(x[:, 0] - np.median(x[:, 0])) < 200]
    moving = np.flatnonzero(np.abs(x[:, 7:13]).max(axis=1) > 0.01)
    x = x[moving[0]:moving[-1]][part]
    return checked_log(RawLog(name, x[:, 0], dict(zip(joints, x[:, 1:7].T)),
                              dict(zip(joints, (x[:, 13:19] * CONSTANTS).T)), 'torque', True),
                       joints)


def test_six_axis_arm_unloaded_and_loaded():
    model = robot('ur10e/ur10e.urdf')
    joints = model.chain.joints
    knowledge = learn(model, [ur10e('ur-20_01_31-unload', joints)])
    other_day = diagnose(model, [ur10e('ur-20_02_10-30sec_12harm', joints)], knowledge)
    assert other_day.kind == 'none', other_day.findings
    centres = []
    for part in (slice(0, 1000), slice(1000, None)):
        verdict = diagnose(model, [ur10e('ur-20_01_31-load', joints, part)], knowledge)
        first = verdict.findings[0]
        assert (first.effect, first.link) == ('payload', 'wrist_3_link')
        assert 2.2 < first.values['m'] < 3.4
        centres.append([first.values[c] for c in ('cx', 'cy', 'cz')])
    assert np.linalg.norm(np.subtract(*centres)) < 0.02


@pytest.mark.system
def test_arm_with_torque_sensors_is_none_in_every_pair():
    model = robot('lwr4/kuka_lwr4.urdf')
    logs = []
    for k in (1, 2, 3):
        x = np.genfromtxt(DATA / f'lwr4/measurements_{k}.csv.gz', delimiter=',', names=True)
        logs.append(checked_log(RawLog(
            f'lwr{k}', x['t'], {j: x['q_' + j] for j in model.chain.joints},
            {j: x['tau_' + j] for j in model.chain.joints}, 'torque', True), model.chain.joints))
    for i, reference in enumerate(logs):
        knowledge = learn(model, [reference])
        for k, log in enumerate(logs):
            if k != i:
                verdict = diagnose(model, [log], knowledge)
                assert verdict.kind == 'none', (reference.name, log.name, verdict.findings)
