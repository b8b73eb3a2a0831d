# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""A model in an MJCF file moves in MuJoCo as it does in our simulator."""
import cmath
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.library.simulator_file import export_model, with_backlash, written_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.simulators.drive_patch import patched
from gearbox_monitor.simulators.mjcf import values_of
from gearbox_monitor.simulators.mjcf_file import (
    compiled_model, drive_of, model_of, read_mjcf, values_in, weight)

mujoco = pytest.importorskip('mujoco')
HERE = Path(__file__).parent
PAIR, ROBOT, LEG = HERE / 'pair.xml', HERE / 'robot.xml', HERE / 'leg.xml'
DT, BOUND = 1e-3, 2e-3  # s, rad rms
T = np.arange(0.0, 1.0, DT)
U = 6.0 * np.cos(2.0 * np.pi * 0.9 * T) + 2.0 * np.cos(2.0 * np.pi * 2.3 * T)
# Of each effect that MJCF expresses: values under which the motion differs.
CASES = {
    'motor_viscous': {'Cv': 0.15}, 'motor_coulomb': {'Cc': 0.35},
    'lugre': {'sigma0': 30.0, 'sigma1': 0.1, 'Cs': 0.1, 'vs': 0.2},
    'coulomb_asymmetry': {'Ca': 0.1}, 'motor_inertia': {'m1': 0.008},
    'cogging': {'A': 0.5, 'N': 4, 'phi': 0.3}, 'arm_viscous': {'Cav': 0.05},
    'arm_coulomb': {'Cac': 0.3}, 'gravity': {'G': 1.5}, 'load_torque': {'TL': 0.5},
    'arm_inertia': {'m2': 0.033}, 'backlash_gap': {'b': 0.14}, 'stiffness': {'K': 17.0},
    'hardening': {'K3': 200.0}, 'hysteresis_bouc_wen': {'Th': 0.5, 'dh': 0.02},
    'hysteresis_branch': {'h': -0.02, 'ds': 0.02}, 'transmission_damping': {'D': 0.03},
    'torque_gain': {'g': 0.1}, 'torque_offset': {'u0': 0.2}, 'actuator_lag': {'T': 0.01},
    'actuator_delay': {'T': 0.0053}, 'saturation': {'umax': 4.0},
    'motor_encoder_delay': {'T': 0.0053}, 'arm_encoder_delay': {'T': 0.0028},
    'encoder_offset': {'c': 0.05}}


def nominal(**changes):
    """Return the model of the drive in PAIR."""
    return model_of(read_mjcf(PAIR, 'motor', 'arm')).with_(**changes)


def free_run(patch, u=U):
    """Return what the joints of motor and arm read in MuJoCo [N, 2], rad, under controls `u`."""
    m = compiled_model(patch.data, PAIR)
    d = mujoco.MjData(m)
    joints = [mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_JOINT, name or patch.joints[0])
              for name in patch.joints]
    d.qpos[:] = m.qpos0
    places, y = m.jnt_qposadr[joints], np.empty((len(u), 2))
    # Those of a step are from before it.
    sensors = {m.sensor_objid[i]: m.sensor_adr[i] for i in range(m.nsensor)}
    for k, torque in enumerate(u):
        if sensors:
            mujoco.mj_forward(m, d)
        y[k] = [d.sensordata[sensors[j]] if j in sensors else d.qpos[place]
                for j, place in zip(joints, places)]
        d.ctrl[0] = torque
        mujoco.mj_step(m, d, nstep=round(DT / m.opt.timestep))
    return y


def compared(model, path=PAIR, joints=('motor', 'arm')):
    """Return rms deviations of MuJoCo from our simulator, rad, and the Patch."""
    patch = patched(read_mjcf(path, *joints), *values_of(model))
    return np.sqrt(np.mean((free_run(patch) - simulate(model, U, DT).y) ** 2, axis=0)), patch


def assert_read_back(model, patch, u):
    """Assert that a file is the model again, and needs no further edit."""
    drive = drive_of(patch.data, PAIR, patch.joints)
    again = model_of(drive)
    factor = again.effort_scale / model.effort_scale if model.controller is None else 1.0
    difference = simulate(again, factor * u, DT).y - simulate(model, u, DT).y
    # coulomb_asymmetry comes back as its twin
    same = BOUND if any(e['id'] == 'coulomb_asymmetry' for e in model.effects) else 1e-8
    assert np.sqrt(np.mean(difference ** 2)) < same
    assert not patched(drive, *values_of(again)).changes


SERVOS = [
    'inheritrange="0.9" kp="80" dampratio="1"', 'class="servo" kp="80"']


def test_a_servo_keeps_its_range_and_damping():
    """A gearbox takes the actuator to a joint without range, and changes what dampratio means."""
    for attributes in SERVOS:
        data = ROBOT.read_bytes().replace(b'<motor name="elbow" joint="elbow" gear="50"/>',
                                          f'<position name="elbow" joint="elbow" {attributes}/>'
                                          .encode())
        data = data.replace(b'axis="0 0 1"', b'axis="0 0 1" range="-90 60"')
        data = data.replace(b'</default>', b'<default class="servo"><position dampratio="1" '
                            b'inheritrange="0.9"/></default></default>')
        drive = drive_of(data, ROBOT, ('elbow', None))
        model = model_of(drive).with_(kind='dead_zone', stiffness=900.0, half_gap=0.005,
                                      damping=0.5, arm_inertia=0.05)
        patch = patched(drive, *values_of(model))
        again = drive_of(patch.data, ROBOT, patch.joints)
        assert again.actuator.control == pytest.approx(drive.actuator.control)
        servo, stated = (m.controller for m in (model_of(again), model))
        assert (servo.kp, servo.kd) == pytest.approx((stated.kp, stated.kd), rel=1e-6)


def test_without_an_effect_the_file_stays():
    _, patch = compared(nominal())
    assert not patch.changes and patch.data == PAIR.read_bytes()


def test_another_law_of_friction_is_written():
    for law in ('atan', 'tanh'):
        rms, patch = compared(nominal(friction_law={'kind': law}))
        assert rms.max() < BOUND
        assert {(c.element, c.attribute) for c in patch.changes} == {
            ('joint "motor"', 'solreffriction'), ('joint "motor"', 'solimpfriction')}


def test_passive_play_yields():
    rms, _ = compared(nominal(kind='passive_play', hysteresis_width=0.02,
                              hysteresis_stiffness=20.0))
    assert rms.max() < BOUND


def test_one_joint_gets_a_rotor_beside_it():
    model = DriveModel().with_(position_gain=0.0, gear_ratio=50.0)
    drive = read_mjcf(ROBOT, 'elbow')
    patch = patched(drive, *values_of(model))
    assert patch.joints == ('elbow_motor', 'elbow')
    m = compiled_model(patch.data, ROBOT)
    assert m.nu == 1 and list(m.key_qpos[0]) == [0.2, 0.2] and m.nq == 2
    text = patch.data.decode()
    for kept in ('<!-- identified by hand in 2019 -->', '<!-- ranges in degrees -->',
                 'fromto="0 0 0 0.3 0 0" size="0.03" density="500"/>'):
        assert kept in text
    after = model_of(read_patched(patch))
    for name in ('motor_inertia', 'arm_inertia', 'damping', 'viscous_friction',
                 'coulomb_friction', 'gear_ratio'):
        assert getattr(after, name) == pytest.approx(getattr(model, name), rel=1e-6)
    assert after.transmission == model.transmission
    again = patched(read_patched(patch), *values_of(model))
    assert not again.changes and again.data == patch.data


def read_patched(patch):
    return drive_of(patch.data, ROBOT, patch.joints)


def test_rigid_model_in_one_joint():
    drive = read_mjcf(ROBOT, 'elbow')
    before = model_of(drive)
    assert before.transmission.kind == 'rigid' and before.gear_ratio == 50.0
    # About the joint: the link of 0.25 m and the hand at its end.
    link = 0.8 * (0.29 / 2.0) ** 2 / 3.0
    assert before.arm_inertia == pytest.approx(link + 0.8 * 0.125 ** 2 + 0.1 * 0.25 ** 2, rel=0.05)
    model = before.with_(arm_inertia=0.7 * before.arm_inertia, motor_inertia=0.008,
                         viscous_friction=0.2)
    after = model_of(drive_of(patched(drive, *values_of(model)).data, ROBOT, ('elbow', None)))
    assert after.arm_inertia == pytest.approx(model.arm_inertia, rel=1e-6)
    assert (after.motor_inertia, after.viscous_friction) == pytest.approx((0.008, 0.2))


def test_weight_of_a_light_arm_keeps_its_inertia():
    """More weight than mass and inertia of the file allow: heavier and nearer to the axis."""
    model = nominal(effects=[{'id': 'gravity', 'G': 6.0}])
    rms, patch = compared(model)
    assert rms.max() < BOUND
    drive = drive_of(patch.data, PAIR, patch.joints)
    assert weight(drive) == pytest.approx(6.0, rel=1e-6)
    assert drive.arm.inertia == pytest.approx(model.arm_inertia, rel=1e-6)


def test_weight_with_a_phase_is_patched_and_read():
    """The arm does not hang at angle 0; the free run in MuJoCo is the oracle of the equation."""
    model = nominal(effects=[{'id': 'gravity', 'G': 2.0, 'phi': 0.7}])
    rms, patch = compared(model)
    assert rms.max() < BOUND
    assert weight(drive_of(patch.data, PAIR, patch.joints)) == pytest.approx(
        cmath.rect(2.0, 0.7), rel=1e-6)
    load, = (e for e in model_of(drive_of(patch.data, PAIR, patch.joints), {}).effects
             if e['id'] == 'gravity')
    assert (load['G'], load['phi']) == pytest.approx((2.0, 0.7), rel=1e-6)


def test_setpoints_are_neither_late_nor_slow():
    data = PAIR.read_bytes().replace(b'<motor joint="motor"/>',
                                     b'<position joint="motor" kp="50" kv="2"/>')
    drive = drive_of(data, PAIR, ('motor', 'arm'))
    gain = nominal().with_(effects=[*nominal().effects, {'id': 'torque_gain', 'g': -0.2}])
    patch = patched(drive, *values_of(gain))
    m = compiled_model(patch.data, PAIR)
    assert m.actuator_gainprm[0, 0] == 40.0 and list(m.actuator_biasprm[0, :3]) == [0, -40, -1.6]
    lag = nominal().with_(effects=[*nominal().effects, {'id': 'actuator_lag', 'T': 0.01}])
    with pytest.raises(InputError, match='line 22: actuator : follows a setpoint'):
        patched(drive, *values_of(lag))


UNFIT = [
    ({'effects': [{'id': 'actuator_delay', 'T': 5e-5}]},
     'a delay of 5e-05 s, expected a timestep of at most that'),
    ({'motor_inertia': 1e-13}, 'armature: would be'),
    ({'kind': 'rigid'}, 'two, expected one joint')]


def test_what_does_not_fit_is_one_line():
    for changes, problem in UNFIT:
        model = nominal(**changes)
        with pytest.raises(InputError, match=problem):
            patched(read_mjcf(PAIR, 'motor', 'arm'), *values_of(model))


def test_one_joint_has_one_reading():
    late = [{'id': f'{side}_encoder_delay', 'T': 0.004} for side in ('motor', 'arm')]
    drive = read_mjcf(ROBOT, 'elbow')
    with pytest.raises(InputError, match='two delays of its reading'):
        patched(drive, *values_of(model_of(drive).with_(effects=late)))


def test_unknown_names_are_one_line():
    with pytest.raises(InputError, match="joint: 'knee' is not in this file"):
        read_mjcf(ROBOT, 'knee')
    with pytest.raises(InputError, match="keyframe: 'up' is not in the file"):
        read_mjcf(ROBOT, 'elbow', keyframe='up')
    with pytest.raises(InputError, match='no fixed tendon'):
        model_of(drive_of(PAIR.read_bytes().replace(b'stiffness="25"', b''), PAIR,
                          ('motor', 'arm')))


def test_the_command_lists_what_it_cannot_express(tmp_path, capsys):
    (tmp_path / 'closed.yaml').write_text(
        'gear_ratio: 50\neffects: [{id: torque_gain, g: 0.1}, {id: mesh_error, A: 0.01, N: 3, '
        'phi: 0.0}]\n')
    words = ['export', str(tmp_path / 'closed.yaml'), '--to', 'mjcf', '--into', str(ROBOT),
             '--joint', 'elbow']
    assert main([*words, '--out', str(tmp_path / 'out.xml')]) == 1
    out = capsys.readouterr().out
    assert 'mesh_error: refused: no length' in out and 'torque_gain: native' in out
    assert mujoco.MjModel.from_xml_path(str(tmp_path / 'out.xml')).nq == 2
    assert 'note: one unit of effort' not in out
    (tmp_path / 'closed.yaml').write_text('gear_ratio: 1\n')
    assert main(words) == 0
    assert 'one of control 50 N m in robot.xml' in ' '.join(capsys.readouterr().out.split())
    (tmp_path / 'closed.yaml').write_text('effects: [{id: torque_gain, g: 0.1}]\n')
    assert main(words) == 0
    assert '+    <general name="elbow" joint="elbow_motor"' in capsys.readouterr().out


URDF = b"""<robot name="arm">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0 0 -0.1"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="elbow" type="continuous"><parent link="base"/><child link="arm"/>
    <axis xyz="0 1 0"/><dynamics damping="0.3" friction="0.2"/></joint>
  <transmission name="t"><joint name="elbow"/>
    <actuator name="m"><mechanicalReduction>80</mechanicalReduction></actuator></transmission>
</robot>"""


def test_urdf_asks_for_what_it_lacks(tmp_path):
    path = tmp_path / 'arm.urdf'
    path.write_bytes(URDF)
    drive = read_mjcf(path, 'elbow')
    assert model_of(drive).motor_inertia == pytest.approx(0.5 * (0.02 + 2.0 * 0.1 ** 2))
    with pytest.raises(InputError, match='armature: 0, expected .* or motor_inertia in a file'):
        model_of(drive, {'damping': 0.2, 'transmission': {'stiffness': 900.0}})
    with pytest.raises(InputError, match='expected its damping beside transmission'):
        model_of(drive, {'motor_inertia': 0.01, 'transmission': {'stiffness': 900.0}})
    model = model_of(drive, {'motor_inertia': 0.01, 'damping': 0.2,
                             'transmission': {'stiffness': 900.0, 'half_gap': 0.001}})
    assert (model.viscous_friction, model.coulomb_friction) == (0.3, 0.2)
    assert model.arm_inertia == pytest.approx(0.02 + 2.0 * 0.1 ** 2) and model.gear_ratio == 1.0
    assert model.effects == ({'id': 'gravity', 'G': pytest.approx(2.0 * 9.81 * 0.1)},)
    with pytest.raises(InputError, match='expected MJCF'):
        patched(drive, *values_of(model))


def test_an_xml_model_needs_a_joint(capsys):
    assert main(['fit', 'model', 'run', '--model', str(PAIR)]) == 2
    assert 'expected joint (--joint)' in capsys.readouterr().err


def test_included_files_lie_beside_the_file_and_are_not_edited(tmp_path):
    text = ROBOT.read_text(encoding='utf-8')
    begin, end = text.index('<actuator>'), text.index('</actuator>') + len('</actuator>')
    (tmp_path / 'motors.xml').write_text(f'<mujocoinclude>{text[begin:end]}</mujocoinclude>')
    (tmp_path / 'robot.xml').write_text(text[:begin] + '<include file="motors.xml"/>' + text[end:])
    drive = read_mjcf(tmp_path / 'robot.xml', 'elbow')
    model = model_of(drive)
    assert model == model_of(read_mjcf(ROBOT, 'elbow'))
    patched(drive, *values_of(model.with_(viscous_friction=0.3)))
    gain = model.with_(effects=[*model.effects, {'id': 'torque_gain', 'g': 0.1}])
    with pytest.raises(InputError, match='actuator elbow: is not in this file itself'):
        patched(drive, *values_of(gain))


def test_a_short_keyframe_is_filled_up():
    data = LEG.read_bytes().replace(b'0 0 1 1 0 0 0 0.5 -1', b'0 0 1 1 0 0 0 0.5')
    drive = drive_of(data, LEG, ('knee', None))
    model = model_of(drive).with_(kind='dead_zone', stiffness=900.0, half_gap=0.005, damping=0.5)
    patch = patched(drive, *values_of(model))
    assert list(compiled_model(patch.data, LEG).key_qpos[0]) == [0, 0, 1, 1, 0, 0, 0, 0.5, 0, 0]


def test_what_overrules_an_edit_is_one_line():
    """A springdamper replaces damping; coefficients of higher order stay."""
    data = PAIR.read_bytes().replace(b'damping="0.1"', b'damping="0.1 0.02 0" springdamper="1 1"')
    with pytest.raises(InputError, match='motor damping: MuJoCo makes'):
        patched(drive_of(data, PAIR, ('motor', 'arm')), *values_of(nominal()))
    data = PAIR.read_bytes().replace(b'damping="0.1"', b'damping="0.3 0.02 0"')
    patch = patched(drive_of(data, PAIR, ('motor', 'arm')), *values_of(nominal()))
    assert b'damping="0.1 0.02 0"' in patch.data


def test_classes_frames_and_a_floating_base():
    """The inertia about the hip depends on the knee: that of the keyframe counts."""
    for joint in ('hip', 'knee'):
        drive = read_mjcf(LEG, joint, keyframe='stand')
        torque = {'controller': None}
        nominal_model, upright = model_of(drive, torque), model_of(read_mjcf(LEG, joint), torque)
        assert (nominal_model.arm_inertia < 0.99 * upright.arm_inertia) == (joint == 'hip')
        assert nominal_model.motor_inertia == {'hip': 0.09, 'knee': 0.02}[joint]
        model = nominal_model.with_(arm_inertia=0.9 * nominal_model.arm_inertia, effects=[
            *(e for e in nominal_model.effects if e['id'] not in ('gravity', 'saturation')),
            {'id': 'torque_gain', 'g': -0.2}, {'id': 'saturation', 'umax': 30.0}])
        if joint == 'knee':
            model = model.with_(kind='dead_zone', stiffness=900.0, half_gap=0.005, damping=0.5)
        patch = patched(drive, *values_of(model))
        m = compiled_model(patch.data, LEG)
        again = drive_of(patch.data, LEG, patch.joints, 'stand')
        assert again.arm_joint.inertia == pytest.approx(model.arm_inertia, rel=1e-6)
        assert m.nu == 2 and m.nq == (10 if joint == 'knee' else 9)
        i = again.actuator.index
        if joint == 'hip':
            assert list(m.actuator_biasprm[i, :3]) == pytest.approx([0.0, -64.0, -2.4])
        else:
            assert list(m.key_qpos[0][-2:]) == [-1.0, -1.0]
            assert m.actuator_gainprm[i, 0] == 0.8


WIDTHS = [
    (ROBOT.read_text(), {}), (ROBOT.read_text(), {'stiffness': 40.0}), (PAIR.read_text(), {})]


def test_backlash_by_its_width(tmp_path):
    """All that a joint had it has with the backlash, and MuJoCo compiles it to its width."""
    for text, change in WIDTHS:
        path = tmp_path / 'robot.xml'
        path.write_text(text)
        names = ('elbow', None) if 'elbow' in text else ('motor', 'arm')
        file = with_backlash(path, 0.012, joint=names[0], arm_joint=names[1], **change)
        before, after = (values_in(drive_of(*of)) for of in (
            (file.before, path, names), (file.patch.data, path, file.patch.joints)))
        assert 2.0 * after.half_gap == pytest.approx(0.012) and not after.rigid
        assert after.stiffness == pytest.approx(change.get('stiffness') or before.stiffness
                                                or after.stiffness) and after.stiffness > 0.0
        assert bool(file.notes) is not bool(change or before.stiffness)
        for name in ('motor_inertia', 'arm_inertia', 'motor_damping', 'motor_friction', 'weight',
                     'gain', 'offset', 'limit', 'servo'):
            new, old = getattr(after, name), getattr(before, name)
            assert new == old if old is None else new == pytest.approx(old, rel=1e-6), name


NO_BACKLASH = [
    ({'backlash': -0.1}, '', 'backlash: -0.1, expected a width of 0 or more'),
    ({'backlash': float('nan')}, '', 'backlash: nan'),
    ({'stiffness': 1e12}, '', 'expected at most'),
    ({}, '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia '
     'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="elbow" '
     'type="continuous"><parent link="a"/><child link="b"/></joint></robot>', 'a URDF file'),
    ({}, ROBOT.read_text().replace('armature=', 'user='), 'armature: 0, expected')]


def test_backlash_that_no_file_can_have(tmp_path):
    for change, text, problem in NO_BACKLASH:
        path = tmp_path / 'robot.xml'
        path.write_text(text or ROBOT.read_text())
        with pytest.raises(InputError, match=problem):
            with_backlash(path, **{'backlash': 0.012, 'joint': 'elbow', **change})


def test_the_gap_after_is_that_of_the_written_file():
    """What the file cannot hold is not in its run; recorded efforts keep their unit."""
    nominal_model = model_of(read_mjcf(ROBOT, 'elbow'))
    held = [{'id': 'motor_coulomb', 'Cc': 0.4}, {'id': 'torque_gain', 'g': -0.2}]
    model = nominal_model.with_(effects=[
        *nominal_model.effects, *held, {'id': 'viscous_asymmetry', 'Cva': 0.05}])
    file = export_model(model, 'mjcf', ROBOT, joint='elbow')
    written = written_model(file, model)
    expected = nominal_model.with_(effects=[*nominal_model.effects, *held])
    np.testing.assert_allclose(simulate(written, U, DT).y, simulate(expected, U, DT).y, atol=1e-8)
    assert written.effort_scale == nominal_model.effort_scale
    assert [row.id for row in file.lacking] == ['viscous_asymmetry']
