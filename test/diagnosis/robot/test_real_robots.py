# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Real arms: unloaded pairs are none, a load is named; skipped where the recordings are absent."""
from dataclasses import replace

import numpy as np
import pytest
from six_axis_arm import CONSTANTS, controller_constants, DATA, samples, UNLOADED

from gearbox_monitor.diagnosis.robot.knowledge import learn
from gearbox_monitor.diagnosis.robot.robot_log import checked_log, RawLog
from gearbox_monitor.diagnosis.robot.rows import RobotModel, rows_of
from gearbox_monitor.diagnosis.robot.verdict import diagnose
from gearbox_monitor.robot.chain import chain_of, inertial
from gearbox_monitor.robot.description import parse
from gearbox_monitor.watch import fold
from gearbox_monitor.watch.record import Cutter

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason='needs ../shared/data')


def robot(name):
    """Return the RobotModel of a URDF whose friction is learnt."""
    path = DATA / name
    text = path.read_text()
    chain = chain_of(parse(text, path.name))
    return RobotModel(chain, np.full(len(chain.links), 0.4), 0.0, learnt=True)


def ur10e(name, joints, part=slice(None), constants=CONSTANTS):
    """Return a recording of the six-axis arm, without the rests at its ends."""
    x = samples(name)
    moving = np.flatnonzero(np.abs(x[:, 7:13]).max(axis=1) > 0.01)
    x = x[moving[0]:moving[-1]][part]
    return checked_log(RawLog(name, x[:, 0], dict(zip(joints, x[:, 1:7].T)),
                              dict(zip(joints, (x[:, 13:19] * constants).T)), 'torque', True),
                       joints)


def lwr4(number, joints):
    """Return a recording of the seven-axis arm."""
    x = np.genfromtxt(DATA / f'lwr4/measurements_{number}.csv.gz', delimiter=',', names=True)
    return checked_log(RawLog(f'lwr{number}', x['t'], {j: x['q_' + j] for j in joints},
                              {j: x['tau_' + j] for j in joints}, 'torque', True), joints)


def test_six_axis_arm_unloaded_and_loaded():
    """The authors state 2.8 kg; both halves of the recording have the same centre."""
    model, constants = robot('ur10e/ur10e.urdf'), controller_constants()
    joints = model.chain.joints
    knowledge = learn(model, [ur10e(UNLOADED[0], joints, constants=constants)])
    other_day = diagnose(model, [ur10e(UNLOADED[1], joints, constants=constants)], knowledge)
    # Of the first axis this motion shows no friction below twice its effort.
    assert other_day.kind == 'undecided' and not other_day.findings, other_day.findings
    assert other_day.questions[0].place == 'shoulder_pan_joint'
    centres = []
    for part in (slice(0, 1000), slice(1000, None)):
        verdict = diagnose(model, [ur10e('ur-20_01_31-load', joints, part, constants)], knowledge)
        first = verdict.findings[0]
        assert (first.effect, first.link) == ('payload', 'wrist_3_link')
        assert 2.6 < first.values['m'] < 3.0
        centres.append([first.values[c] for c in ('cx', 'cy', 'cz')])
    assert np.linalg.norm(np.subtract(*centres)) < 0.02


@pytest.mark.system
def test_a_load_added_to_a_real_recording_is_weighed():
    """Nothing of a mass is lost to what a reference taught: its scale is that of the currents."""
    model = robot('ur10e/ur10e.urdf')
    joints, links = model.chain.joints, model.chain.links
    body = inertial(3.0, np.array([0.04, 0.17, -0.18]), np.zeros((3, 3)))
    heavy = replace(model, chain=replace(model.chain, links=(
        *links[:-1], replace(links[-1], theta=links[-1].theta + body))))
    log = ur10e(UNLOADED[0], joints)
    rows, loaded = rows_of(log, model), rows_of(log, heavy)
    added = np.stack([b.load - a.load for a, b in zip(rows.joints, loaded.joints)], axis=1)
    section, = log.sections
    torque = np.column_stack([np.interp(section.t - section.t[0], rows.motion.t, x)
                              for x in added.T])
    log = replace(log, sections=(replace(section, input=section.input + torque),))
    knowledge = learn(model, [ur10e(UNLOADED[1], joints)])
    first = diagnose(model, [log], knowledge).findings[0]
    assert (first.effect, first.link) == ('payload', 'wrist_3_link')
    assert first.values['m'] == pytest.approx(3.0, rel=0.02)


@pytest.mark.system
@pytest.mark.parametrize('path, names, read', [
    ('lwr4/kuka_lwr4.urdf', (1, 2, 3), lwr4), ('ur10e/ur10e.urdf', UNLOADED, ur10e)])
def test_unloaded_recordings_are_none_in_every_pair(path, names, read):
    model = robot(path)
    logs = [read(name, model.chain.joints) for name in names]
    for i, reference in enumerate(logs):
        knowledge = learn(model, [reference])
        for k, log in enumerate(logs):
            if k != i:
                verdict = diagnose(model, [log], knowledge)
                assert not verdict.findings, (reference.name, log.name, verdict.findings)
                assert verdict.kind in ('none', 'undecided'), verdict.remainders


@pytest.mark.system
def test_a_watch_weighs_the_load_of_a_real_arm_and_raises_no_alarm():
    """The authors state 2.8 kg. The unloaded recordings come four times: three are too short."""
    text, constants = (DATA / 'ur10e/ur10e.urdf').read_text(), controller_constants()
    watch, cutter, begin = fold.begin(text), Cutter(), 1.0
    joints = robot('ur10e/ur10e.urdf').chain.joints
    for name in (*UNLOADED * 4, 'ur-20_01_31-load'):
        x = samples(name)
        x = x[np.isfinite(x[:, :7]).all(axis=1)]
        for t, row in zip(x[:, 0] - x[0, 0] + begin, x):
            for block in cutter.take(round(t * 1e9), joints, row[1:7], (),
                                     row[13:19] * constants):
                watch, _ = fold.step(watch, block)
                assert not watch.standing, (name, watch.standing)
        begin = t + 20.0
    for block in cutter.end():
        watch, _ = fold.step(watch, block)
    held, = watch.payloads
    assert held.mass == pytest.approx(2.8, abs=0.3) and held.mass_std < 0.25
