# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings by MuJoCo: what is drawn, what stays sealed, baselines, scores."""
import json

import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.blind import mujoco_baselines, mujoco_drives, mujoco_set, real_joints
from gearbox_monitor.plant.simulate import Plant, simulate
from gearbox_monitor.simulators.mjcf_file import model_of, read_mjcf

pytest.importorskip('mujoco')
NOMINAL = {**mujoco_drives.drawn_nominal(np.random.default_rng(3)), 'K': 25.0, 'b': 0.1, 'G': 0.4,
           'timestep': 2e-3, 'integrator': 'implicitfast'}
U = 5.0 * np.cos(5.0 * np.arange(2500) * mujoco_drives.DT) + 2.0 * np.cos(
    13.0 * np.arange(2500) * mujoco_drives.DT)


@pytest.mark.parametrize('name', [*mujoco_drives.INSIDE, *mujoco_drives.OUTSIDE])
def test_every_effect_changes_the_motion(name):
    peak = 7.0 if name == 'saturation' else 1.0
    changed = mujoco_drives.changed(NOMINAL, name, 0.3, 1.0, peak)
    plain, other = (mujoco_drives.simulated(v, U[:800])[0] for v in (NOMINAL, changed))
    assert np.abs(plain - other).max() > 1e-3


def test_the_nominal_file_is_the_nominal_drive(tmp_path):
    """What the diagnosis reads moves as the plant that makes recordings."""
    path = tmp_path / 'robot.xml'
    path.write_text(mujoco_drives.xml_of(NOMINAL), encoding='utf-8')
    model = model_of(read_mjcf(path, 'motor', 'arm'))
    ours = simulate(model, U[:500], mujoco_drives.DT).x[:, :2]
    theirs, _ = mujoco_drives.simulated(NOMINAL, U[:500])
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 1e-4


def real(robot):
    """Return values of the first joint of a `robot`, its inputs, angles and speeds."""
    index = next(i for i, j in enumerate(real_joints.JOINTS) if j.robot == robot)

    class Fixed(np.random.Generator):

        def integers(self, *_):
            return index
    v = real_joints.nominal(Fixed(np.random.PCG64(4)))
    u = real_joints.inputs(v, np.random.default_rng(5), np.arange(2500) * mujoco_drives.DT)
    q, w = mujoco_drives.simulated(v, u)
    return {**v, 'scale': real_joints.scaled(v, u, q[:, 0], w[:, 0])}, u, q, w


@pytest.mark.parametrize('robot', ['cassie', 'go2', 'panda', 'sawyer', 'shadow hand'])
def test_the_file_of_a_real_joint_is_read_as_the_joint(robot, tmp_path):
    """Ours repeats MuJoCo's run, and every effect of the joint moves it otherwise."""
    v, u, q, w = real(robot)
    (tmp_path / 'robot.xml').write_text(mujoco_drives.xml_of(v), encoding='utf-8')
    model = model_of(read_mjcf(tmp_path / 'robot.xml', 'joint'))
    plant = Plant(model, state=np.array([q[0, 0], q[0, 0]]))
    ours = plant.run(u[:500], mujoco_drives.DT).x[:, 0]
    np.testing.assert_allclose(ours, q[:500, 0], rtol=0.0, atol=2e-3 * max(np.ptp(q), 0.1))
    for name, (key, _) in real_joints.names_of(v).items():
        peak = np.abs(real_joints.efforts(v, u, q[:, 0], w[:, 0])).max()
        changed = mujoco_drives.changed(v, name, 0.5 if key not in ('lag', 'delay') else 0.02,
                                        1.0, peak)
        assert np.abs(mujoco_drives.simulated(changed, u)[0] - q).max() > 1e-5, name


def test_labels_are_sealed(tmp_path):
    names = mujoco_drives.generate(5, tmp_path / 'set', 7, tmp_path / 'labels.json',
                                   lambda done, total: None)
    labels = json.loads((tmp_path / 'labels.json').read_text())
    assert list(labels) == names and {len(v['ids']) for v in labels.values()} == {0, 1, 2}
    for name, label in labels.items():
        place = tmp_path / 'set/recordings' / name
        assert sorted(p.name for p in place.iterdir()) == ['recording.csv', 'robot.xml']
        assert (place / 'robot.xml').read_text() == mujoco_drives.xml_of(label['nominal'])


@pytest.mark.parametrize('law', ['M1', 'M3'])
def test_friction_models_fit_friction(monkeypatch, law):
    monkeypatch.setattr(mujoco_baselines, 'LAWS', {law: mujoco_baselines.LAWS[law]})
    truth = mujoco_drives.changed(NOMINAL, 'motor_coulomb', 0.5, 1.0, 1.0)
    q, _ = mujoco_drives.simulated(truth, U)
    y = q + 0.003 * np.random.default_rng(0).standard_normal(q.shape)
    fit = mujoco_baselines.friction_models(NOMINAL, U, y)
    assert fit['named'] is None and fit['law'] == law and fit['closed'] > 0.97


def test_baselines_and_scores(monkeypatch):
    truth = mujoco_drives.changed(NOMINAL, 'arm_inertia', 0.5, 1.0, 1.0)
    q, _ = mujoco_drives.simulated(truth, U)
    y = q + 0.003 * np.random.default_rng(0).standard_normal(q.shape)
    fit = mujoco_baselines.least_squares_by_bic(NOMINAL, U, y, ('stiffness', 'arm_inertia'))
    assert fit['named'] == 'arm_inertia' and fit['closed'] > 0.9
    assert fit['values']['m2'] == pytest.approx(truth['m2'], rel=0.02)
    assert mujoco_baselines.black_box(NOMINAL, U, y)['closed'] < 0.9
    label = {'ids': ['arm_inertia'], 'nominal': NOMINAL, 'truth': truth, 'evidence': 9.0}
    right = {'verdict': 'effect', 'effect': 'arm_inertia', 'location': 'arm_side',
             'params': {'arm_inertia': {'m2': truth['m2']}}, 'ranked': ['arm_inertia']}
    wrong = {**right, 'effect': 'stiffness', 'location': 'transmission',
             'params': {'stiffness': {'K': 20.0}}}
    values = mujoco_set.diagnosed_values(NOMINAL, right)
    assert values['m2'] == truth['m2']
    assert mujoco_set.diagnosed_values(NOMINAL, {**right, 'effect': 'stribeck'}) is None
    assert mujoco_baselines.closed_of(NOMINAL, values, U, y) == pytest.approx(1.0, abs=0.02)
    monkeypatch.setattr(mujoco_baselines, 'BASELINES', {})
    rows = [mujoco_set.scored(label, verdict, (U, y)) for verdict in (right, wrong, None)]
    assert [r['top1'] for r in rows] == [True, False, False]
    assert rows[0]['diagnose'] == pytest.approx(rows[0]['true']) and rows[1]['diagnose'] < 0.9


def test_runs_that_diverge_leave_no_trace(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with mujoco_set.unwarned():
        q, _ = mujoco_drives.simulated({**NOMINAL, 'K': 1e9}, U[:100])
    assert np.abs(q).max() > 1e3
    assert not list(tmp_path.iterdir()) and capfd.readouterr() == ('', '')


@pytest.mark.parametrize('name', ['actuator_lag', 'actuator_delay'])
def test_true_values_close_everything_in_windows_too(name):
    """What acts late in a window was commanded before it."""
    truth = mujoco_drives.changed(NOMINAL, name, 0.01, 1.0, 1.0)
    q, _ = mujoco_drives.simulated(truth, U)
    y = q + 1e-4 * np.random.default_rng(1).standard_normal(q.shape)
    assert mujoco_baselines.closed_of(NOMINAL, truth, U, y) > 0.99


def test_other_options_are_refused(capsys):
    assert main(['blind', '--plant', 'mujoco', '--input', 'setpoint']) == 2
    assert 'expected neither' in capsys.readouterr().err
