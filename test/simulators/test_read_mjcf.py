# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A joint is read whole or refused by name: MuJoCo's run of a file is the oracle of its model."""
import os
from pathlib import Path

from mjcf_arrays import decision
import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.robot.compiled_model import undecided
from gearbox_monitor.simulators import compiling
from gearbox_monitor.simulators.mjcf_file import compiled_file, drive_of, model_of, read_mjcf

mujoco = pytest.importorskip('mujoco')
XML = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="{integrator}"{option}/>
  {section}
  <worldbody>
    <body name="upper"{body}>
      <joint name="elbow" type="{kind}" axis="0 1 1" {joint}/>
      <inertial pos="0.12 0.02 0" mass="1.4" diaginertia="0.004 0.012 0.012"/>
      <body name="hand" pos="0.3 0 0"><joint name="wrist" axis="1 0 0" {wrist}/><site name="s"/>
        <inertial pos="0.05 0 0" mass="0.3" diaginertia="0.001 0.001 0.001"/></body>
    </body>
    <body name="other"><joint name="other" axis="0 1 0"/>
      <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body>
  </worldbody>
  <actuator>{actuator}</actuator>
</mujoco>"""
PLAIN = {'integrator': 'implicitfast', 'option': '', 'section': '', 'body': '', 'kind': 'hinge',
         'joint': 'armature="0.03" damping="0.3" frictionloss="0.4"', 'wrist': '',
         'actuator': '<motor name="m" joint="elbow"/>'}
JOINT, SERVO = PLAIN['joint'], '<position name="m" joint="elbow" kp="40" kv="1.5" {}/>'
READ = {
    'plain': {}, 'no armature': {'joint': 'damping="0.3"'},
    'no actuator': {'actuator': ''},
    'gravcomp': {'body': ' gravcomp="0.7"'},
    'gravcomp by actuators': {'body': ' gravcomp="1"',
                              'joint': JOINT + ' actuatorgravcomp="true"'},
    'spring': {'joint': JOINT + ' stiffness="6" springref="0.8" ref="0.2"'},
    'gain and gear': {'actuator': '<general name="m" joint="elbow" gear="3" gainprm="2"/>'},
    'bias': {'actuator': '<general name="m" joint="elbow" biastype="affine" biasprm="0.5"/>'},
    'force limit': {'actuator': '<motor name="m" joint="elbow" gear="2" forcerange="-1 1"/>'},
    'control limit': {'actuator': '<motor name="m" joint="elbow" ctrlrange="-2 2"/>'},
    'limit of the joint': {'joint': JOINT + ' actuatorfrcrange="-2 2"'},
    'lag': {'actuator': '<general name="m" joint="elbow" dyntype="filterexact" dynprm="0.03"/>'},
    'delay': {'actuator': '<motor name="m" joint="elbow" delay="0.008" nsample="9" '
              'interp="linear"/>'},
    'held delay': {'actuator': '<motor name="m" joint="elbow" delay="0.007" nsample="9"/>'},
    'lag in Euler steps': {'actuator': '<general name="m" joint="elbow" dyntype="filter" '
                           'dynprm="0.03"/>', 'integrator': 'Euler'},
    **{f'{kind} in Runge-Kutta steps': {'integrator': 'RK4', 'actuator': (
        f'<general name="m" joint="elbow" {words}/>')} for kind, words in (
            ('filter', 'dyntype="filter" dynprm="0.03"'),
            ('exact filter', 'dyntype="filterexact" dynprm="0.03"'),
            ('delay', 'delay="0.008" nsample="9" interp="linear"'),
            ('held delay', 'delay="0.0075" nsample="9"'))},
    'actuator damping': {'actuator': '<motor name="m" joint="elbow" gear="2" damping="0.1" '
                         'armature="0.01"/>'},
    'dcmotor': {'actuator': '<dcmotor name="m" joint="elbow" motorconst="0.5" resistance="1"/>'},
    'velocity': {'actuator': '<velocity name="m" joint="elbow" kv="2"/>'},
    'cogging': {'actuator': PLAIN['actuator'] + '<dcmotor joint="elbow" input="none" '
                'motorconst="0" resistance="1" cogging="0.8 6 0.3"/>'},
    'lugre': {'joint': 'armature="0.03"', 'actuator': PLAIN['actuator'] + (
        '<dcmotor joint="elbow" input="none" motorconst="0" resistance="1" '
        'lugre="30 0.3 0.4 0.6 0.2"/>')},
    'second actuator': {'actuator': PLAIN['actuator'] + '<velocity name="b" joint="elbow" '
                        'kv="0.7"/>'},
    'servo': {'actuator': SERVO.format('')},
    'servo with a gear': {'actuator': SERVO.format('gear="2"')},
    'servo at its limit': {'actuator': SERVO.format('forcerange="-3 3"')},
    'servo in Euler steps': {'actuator': SERVO.format(''), 'integrator': 'Euler'},
    'servo with a filter': {'actuator': SERVO.format('').replace('kv="1.5"', 'kv="1.5" '
                                                                 'timeconst="0.02"')},
    'dampratio': {'actuator': SERVO.format('').replace('kv="1.5"', 'dampratio="0.6"')},
    'pid': {'actuator': '<pid name="m" joint="elbow" kp="40" kv="1.5" input="pos"/>'},
    'explicit damping': {'integrator': 'Euler', 'section': '<option><flag '
                         'eulerdamp="disable"/></option>'},
    'slide': {'kind': 'slide'}, 'Runge-Kutta': {'integrator': 'RK4'},
    'forces off': {'section': '<option><flag frictionloss="disable" damper="disable"/></option>'},
    'springs off': {'joint': JOINT + ' stiffness="6"',
                    'section': '<option><flag spring="disable"/></option>'},
    'gravity off': {'section': '<option><flag gravity="disable"/></option>'},
    'defaults': {'section': '<default><joint damping="0.9" stiffness="2"/>'
                 '<position kp="60" dampratio="1"/></default>', 'joint': 'armature="0.1"',
                 'actuator': '<position name="m" joint="elbow"/>'},
    'loop elsewhere': {'section': '<equality><joint joint1="wrist"/></equality>'},
}
REFUSED = {
    'stiffness: 0.5 0 of higher order': {'joint': JOINT + ' stiffness="6 0.5"'},
    'damping: 0.2 0 of higher order': {'joint': 'damping="0.3 0.2"'},
    'springyield: 0.3: the spring yields': {'joint': 'stiffness="5" springyield="0.3"'},
    'density: 1000 in option': {'option': ' density="1000"'},
    'viscosity: 0.1 in option': {'option': ' viscosity="0.1"'},
    'equality number 0: couples it with other': {
        'section': '<equality><joint joint1="other" joint2="elbow"/></equality>'},
    'holds hand to other: a closed loop': {
        'section': '<equality><connect body1="hand" body2="other" anchor="0 0 0"/></equality>'},
    'tendon t: stiffness: joins it to other': {
        'section': '<tendon><fixed name="t" stiffness="5"><joint joint="elbow" coef="1"/>'
        '<joint joint="other" coef="2"/></fixed></tendon>'},
    'tendon t: frictionloss, limited: acts on it': {
        'section': '<tendon><fixed name="t" frictionloss="0.1" range="-1 1"><joint joint="elbow" '
        'coef="1"/></fixed></tendon>'},
    'actuator p: pulls at the tendon t': {
        'section': '<tendon><fixed name="t"><joint joint="elbow" coef="1"/></fixed></tendon>',
        'actuator': '<motor name="p" tendon="t"/>'},
    'actuator p: acts on a site': {'actuator': '<general name="p" site="s"/>'},
    'm: forcerange: -1 3 N m': {'actuator': '<motor name="m" joint="elbow" forcerange="-1 3"/>'},
    'm: ctrlrange: 0 3, expected': {'actuator': '<motor name="m" joint="elbow" ctrlrange="0 3"/>'},
    'm: dyntype: integrator': {
        'actuator': '<intvelocity name="m" joint="elbow" kp="9" actrange="-1 1"/>'},
    'm: gaintype: affine': {'actuator': '<damper name="m" joint="elbow" kv="3" ctrlrange="0 1"/>'},
    'm: gaintype: muscle': {'joint': 'range="-1 1"', 'actuator': '<muscle name="m" joint="elbow" '
                            'force="10" lengthrange="-1 1"/>'},
    'm: gainprm: 20 beside biasprm -40': {'actuator': '<general name="m" joint="elbow" '
                                          'gainprm="20" biastype="affine" biasprm="0 -40 0"/>'},
    'm: inductance': {'actuator': '<dcmotor name="m" joint="elbow" motorconst="0.5" '
                      'resistance="1" inductance="0.01 0"/>'},
    'm: delay: 0.008 s ends at a time at which controls are read': {
        'actuator': '<motor name="m" joint="elbow" delay="0.008" nsample="9"/>'},
    'm: pid': {'actuator': '<pid name="m" joint="elbow" kp="40" ki="3"/>'},
    'm: kv: 9 N m s/rad in Euler steps': {
        'integrator': 'Euler', 'actuator': '<velocity name="m" joint="elbow" kv="9"/>'},
    'sleep: enabled': {'section': '<option><flag sleep="enable"/></option>'},
    'noslip_iterations: 3': {'option': ' noslip_iterations="3"'},
    'ls_iterations: 5': {'option': ' ls_iterations="5"'},
}


def xml_of(changes):
    return XML.format(**{**PLAIN, **changes}).encode()


def drive_with(changes):
    return drive_of(xml_of(changes), Path('robot.xml'), ('elbow', None),
                    actuator='m' if 'name="m"' in {**PLAIN, **changes}['actuator'] else None)


def run_of(drive, controls, torque):
    """Return the elbow's positions in MuJoCo [N], rad, all other joints at rest."""
    m, joint = drive.compiled, drive.motor.index
    dof, place = m.jnt_dofadr[joint], m.jnt_qposadr[joint]
    others = [v for v in range(m.nv) if v != dof]
    m.dof_armature[others] = 1e5
    data, y = mujoco.MjData(m), np.empty(len(controls))
    data.qpos[:] = drive.posture
    for k, control in enumerate(controls):
        y[k] = data.qpos[place]
        if drive.actuator is None:
            data.qfrc_applied[dof] = torque[k]
        else:
            data.ctrl[m.actuator_ctrladr[drive.actuator.index]] = control
        mujoco.mj_step(m, data)
        q, v = data.qpos[place], data.qvel[dof]
        data.qpos[:], data.qvel[:] = drive.posture, 0.0
        data.qpos[place], data.qvel[dof] = q, v
    return y


def expect_motion_of_the_file(name):
    drive = drive_with(READ[name])
    model = model_of(drive)
    t = np.arange(400) * drive.timestep
    wave = np.sin(9.0 * t) + 0.7 * np.sin(4.0 * t)
    u = 0.5 * wave if model.controller else 4.0 * wave
    controls = u * model.gear_ratio if model.controller else u / model.effort_scale
    start = float(drive.posture[drive.compiled.jnt_qposadr[drive.motor.index]])
    ours = Plant(model, state=np.array([start, start, 0.0, 0.0])).run(u, drive.timestep).y[:, 0]
    theirs = run_of(drive, controls, u)
    assert np.ptp(theirs) > 0.05
    assert np.abs(ours - theirs).max() < 5e-4 * max(1.0, np.ptp(theirs))


def test_the_model_moves_as_the_file_does():
    for name in READ:
        expect_motion_of_the_file(name)


def test_what_acts_besides_is_refused_by_name():
    for words in REFUSED:
        with pytest.raises(InputError) as error:
            model_of(drive_with(REFUSED[words]))
        assert words in str(error.value) and 'joint elbow' in str(error.value)


def test_every_array_of_the_compiled_model_is_decided_about():
    m = mujoco.MjModel.from_xml_string('<mujoco/>')
    names = [name for name in dir(m)
             if not name.startswith('_') and not callable(getattr(m, name))]
    names += [f'opt.{name}' for name in dir(m.opt) if not name.startswith('_')
              and name not in ('disableflags', 'enableflags')]
    for kind, bits in (('disable.mjDSBL_', mujoco.mjtDisableBit),
                       ('enable.mjENBL_', mujoco.mjtEnableBit)):
        first, _, prefix = kind.partition('.')
        names += [f'{first}.{name.removeprefix(prefix)}' for name in bits.__members__
                  if name.startswith(prefix)]
    assert len(names) > 500
    assert [name for name in names if decision(name) is None] == []


def test_all_joints_of_a_robot_at_once():
    """What joins two joints that both move is named at each of them."""
    m = compiled_file(xml_of({'section': '<equality><joint joint1="other" joint2="elbow"/>'
                              '</equality>'}), Path('robot.xml')).compiled
    problems = undecided(m, range(m.njnt))
    assert {(p.joint, p.attribute) for p in problems} == {
        ('elbow', 'equality number 0'), ('other', 'equality number 0')}
    assert undecided(compiled_file(xml_of({}), Path('robot.xml')).compiled, [0, 1, 2]) == []


def test_setpoints_of_a_joint_with_measured_torques():
    drive = drive_with({'actuator': SERVO.format('forcerange="-3 3"')})
    model = model_of(drive, {'controller': None})
    assert model.controller is None and model.torque_constant == 1.0


def test_parts_in_other_files_are_read(tmp_path):
    """Included and attached parts, defaults in a class of their own, and a missing mesh."""
    (tmp_path / 'parts').mkdir()
    (tmp_path / 'parts/motors.xml').write_text(
        '<mujocoinclude><actuator><position class="drive" name="m" joint="a_elbow"/></actuator>'
        '</mujocoinclude>')
    (tmp_path / 'parts/arm.xml').write_text(
        '<mujoco><compiler angle="radian"/><asset><mesh name="skin" file="absent.stl"/></asset>'
        '<worldbody><body name="arm">'
        '<joint name="elbow" axis="0 1 0" damping="0.2" armature="0.02" range="-2 1"/>'
        '<geom type="mesh" mesh="skin"/>'
        '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody>'
        '</mujoco>')
    robot = tmp_path / 'robot.xml'
    robot.write_text(
        '<mujoco><default><default class="drive"><position kp="30" dampratio="1" '
        'inheritrange="1" forcerange="-5 5"/></default></default>'
        '<asset><model name="arm" file="parts/arm.xml"/></asset>'
        '<worldbody><attach model="arm" body="arm" prefix="a_"/></worldbody>'
        '<include file="parts/motors.xml"/></mujoco>')
    drive = read_mjcf(robot, 'a_elbow')
    model = model_of(drive)
    assert (model.viscous_friction, model.controller.kp, model.controller.torque_limit) == (
        0.2, 30.0, 5.0)
    assert model.controller.kd == pytest.approx(2.0 * np.sqrt(30.0 * 0.04), rel=1e-6)
    assert drive.actuator.control == (-2.0, 1.0)


def test_files_that_must_not_be_opened(tmp_path):
    """A pipe, and what lies outside of the file's folder unless the root says otherwise."""
    (tmp_path / 'robots').mkdir()
    robot = tmp_path / 'robots/robot.xml'
    part = xml_of({}).replace(b'mujoco>', b'mujocoinclude>')
    (tmp_path / 'part.xml').write_bytes(part)
    robot.write_text('<mujoco><include file="../part.xml"/></mujoco>')
    with pytest.raises(InputError, match=r'part.xml: lies outside of .*robots, expected .*--root'):
        read_mjcf(robot, 'elbow')
    assert read_mjcf(robot, 'elbow', root=tmp_path).motor.armature == 0.03
    (tmp_path / 'robots/link.xml').symlink_to(tmp_path / 'part.xml')
    robot.write_text('<mujoco><include file="link.xml"/></mujoco>')
    with pytest.raises(InputError, match='link.xml: lies outside'):
        read_mjcf(robot, 'elbow')
    os.mkfifo(tmp_path / 'robots/pipe.xml')
    robot.write_text('<mujoco><include file="pipe.xml"/></mujoco>')
    with pytest.raises(InputError, match='pipe.xml: a pipe, device or folder'):
        read_mjcf(robot, 'elbow')


COSTLY = [
    '<worldbody><replicate count="100000000"><body><joint/><geom size=".1"/></body></replicate>'
    '</worldbody>',
    '<asset><hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/></asset>',
    '<size nkey="1000000000"/>']


def expect_end(text, tmp_path, monkeypatch):
    monkeypatch.setattr(compiling, 'CPU_SECONDS', 1)
    robot = tmp_path / 'robot.xml'
    robot.write_text(f'<mujoco>{text}</mujoco>')
    with pytest.raises(InputError, match='takes more than 1 s of CPU time or 1024 MB'):
        read_mjcf(robot, 'elbow')


def test_a_small_file_that_costs_much_ends(tmp_path, monkeypatch):
    for text in COSTLY:
        expect_end(text, tmp_path, monkeypatch)


@pytest.mark.system
@pytest.mark.parametrize('name', ['gravcomp', 'spring', 'lag', 'servo at its limit', 'dcmotor',
                                  'force limit'])
def test_a_run_of_the_file_has_no_gap(name, tmp_path, monkeypatch):
    """MuJoCo's run, diagnosed with the file that it is of, says none."""
    monkeypatch.chdir(tmp_path)
    Path('robot.xml').write_bytes(xml_of(READ[name]))
    drive = read_mjcf('robot.xml', 'elbow')
    model = model_of(drive)
    t = np.arange(5000) * drive.timestep
    u = sum(np.sin(rate * t + k) for k, rate in enumerate((2.6, 5.1, 9.0, 14.3)))
    servo = model.controller is not None
    u *= 0.25 if servo else 2.0
    y = run_of(drive, u if servo else u / model.effort_scale, u)
    random = np.random.default_rng(3)
    y += 0.004 * np.std(y) * random.standard_normal(len(y))
    column = 'setpoint' if servo else 'u'
    np.savetxt('run.csv', np.column_stack([t, u if servo else u / model.torque_constant, y]),
               '%.9g', ',', header=f't,{column},motor', comments='')
    assert main(['diagnose', 'run.csv', '--model', 'robot.xml', '--joint', 'elbow']) == 0
