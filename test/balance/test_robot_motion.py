# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The motion that suggest --robot proposes: within limits, clear of contacts, and telling."""
import numpy as np
import pytest
import yaml

import gearbox_monitor as gm
from gearbox_monitor.balance import robot_experiment
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.export.robot_limits import contacts_in, limits_in
from gearbox_monitor.recordings.robot_values import robot_model

mujoco = pytest.importorskip('mujoco')
ARM = """<mujoco><compiler angle="radian"/><worldbody>
<geom name="wall" type="box" size=".1 .5 .5" pos=".45 0 .4"/>
<body name="upper" pos="0 0 .6"><joint name="shoulder" axis="0 1 0" range="-2 2" armature=".05"
damping=".3" frictionloss=".4"/><geom type="capsule" fromto="0 0 0 0 0 -.25" size=".03" mass="1.5"
/><body name="fore" pos="0 0 -.28"><joint name="elbow" axis="0 1 0" range="-2 2" armature=".02"
damping=".2" frictionloss=".2"/><geom type="capsule" fromto="0 0 0 0 0 -.2" size=".025" mass=".8"/>
</body></body></worldbody><actuator><motor joint="shoulder" ctrlrange="-12 12"/>
<motor joint="elbow" ctrlrange="-5 5"/></actuator></mujoco>"""


@pytest.fixture(scope='module')
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp('robot') / 'arm.xml'
    path.write_text(ARM, encoding='utf-8')
    return path


def test_the_motion_keeps_its_limits_and_shows_a_smaller_payload(file, tmp_path, monkeypatch):
    """By the command: both files, limits of the MJCF, no contact, rest at both ends."""
    monkeypatch.setattr(robot_experiment, 'DRAWN', 8)
    monkeypatch.setattr(robot_experiment, 'CHANGED', 16)
    out, csv, data = (tmp_path / name for name in ('m.yaml', 'm.csv', 'm.json'))
    assert main(['suggest', '--robot', str(file), '--max-speed', '2', '--seconds', '8', '--out',
                 str(out), '--csv', str(csv), '--json', str(data)]) == 0
    goal, = yaml.safe_load(data.read_text())['goals']
    assert goal['place'] == 'fore' and goal['size'] < 0.7 * goal['usual']
    monkeypatch.setattr(robot_experiment, 'CHANGED', 0)  # the best of 8 random motions
    drawn, = gm.suggest_robot(gm.load_robot(file), speed=2.0, seconds=8.0).design.goals.values()
    assert goal['size'] < 0.8 * drawn
    rows = np.loadtxt(csv, delimiter=',', skiprows=1)
    q, v, tau = rows[:, 1:3], rows[:, 3:5], rows[:, 5:]
    assert csv.read_text().startswith('t,q_shoulder,q_elbow,v_shoulder')
    assert np.abs(q).max() < 2.0 and np.abs(v).max() < 2.0 and q.std() > 0.1
    assert (np.abs(tau).max(axis=0) < [12.0, 5.0]).all() and not v[[0, -1]].any()
    touches, note = contacts_in(gm.load_robot(file).file, 20.0)
    assert not note and not touches(q) and touches(np.array([[-1.6, 0.0]]))
    message = yaml.safe_load(out.read_text())
    assert message['joint_names'] == ['shoulder', 'elbow'] and len(message['points']) == 81
    assert message['points'][-1]['time_from_start'] == {'sec': 8, 'nanosec': 0}


def test_the_file_is_a_message(file, monkeypatch):
    messages = pytest.importorskip('trajectory_msgs.msg')
    time = pytest.importorskip('builtin_interfaces.msg').Duration
    monkeypatch.setattr(robot_experiment, 'DRAWN', 3)
    monkeypatch.setattr(robot_experiment, 'CHANGED', 1)
    motion = gm.suggest_robot(gm.load_robot(file), ['motor_coulomb', 'motor_viscous'], speed=2.0,
                              seconds=8.0)
    assert {(a, b) for a, _, b in motion.design.goals} == {
        ('motor_coulomb', 'motor_viscous'), ('motor_viscous', 'motor_coulomb')}
    fields = yaml.safe_load(yaml.safe_dump(motion.trajectory))
    points = [messages.JointTrajectoryPoint(**{**p, 'time_from_start': time(**p[
        'time_from_start'])}) for p in fields['points']]
    message = messages.JointTrajectory(joint_names=fields['joint_names'], points=points)
    assert message.points[10].time_from_start.sec == 1


def test_a_motion_in_which_friction_may_stick_shows_less(file):
    """Below creep it is any torque up to Coulomb's: small torques of slow motion show nothing."""
    robot = gm.load_robot(file)
    model = robot_model(robot.file, robot.values, True)
    experiment = robot_experiment._Experiment(
        model, limits_in(robot.file), [('payload', None)], 'fore', 20.0, lambda q: False)
    t, w, sizes = experiment.t, 2.0 * np.pi * np.array([0.23, 0.31]), []
    for peak in (0.03, 0.3):
        q = [1.2, 0.3] + peak / w * np.sin(w * t[:, None])
        v = np.gradient(q, t, axis=0)
        torque = robot_experiment.model_torque(model.chain, t, q, v)
        sizes += experiment.seen(q, v, torque).values()
    assert sizes[0] > 2.0 * sizes[1]


def test_the_last_point_is_at_rest_whatever_the_length(file, monkeypatch):
    monkeypatch.setattr(robot_experiment, 'DRAWN', 3)
    monkeypatch.setattr(robot_experiment, 'CHANGED', 1)
    motion = gm.suggest_robot(gm.load_robot(file), speed=2.0, seconds=8.013, travel=0.4)
    assert np.abs(motion.design.q).max() < 0.4  # tighter than the range of the file
    last = motion.trajectory['points'][-1]
    assert last['time_from_start'] == {'sec': 8, 'nanosec': 0}
    assert not any(last['velocities'] + last['accelerations'])
    assert last['positions'] == np.round(motion.design.q[-1], 5).tolist()


def test_an_effect_that_no_motion_shows_is_refused_by_name(file, monkeypatch):
    monkeypatch.setattr(robot_experiment, 'DRAWN', 3)
    robot = gm.load_robot(file)
    for effects in (['torque_gain', 'saturation'], ['saturation'], ['payload', 'servo_gain']):
        with pytest.raises(InputError, match=f'effects: {effects[-1]}: no motion'):
            gm.suggest_robot(robot, effects, speed=2.0, seconds=8.0)


def test_files_are_refused_before_the_search(file, tmp_path, capsys):
    taken = tmp_path / 'taken.yaml'
    taken.write_text('kept', encoding='utf-8')
    for words, says in ((['--out', str(taken)], 'exists'), (['--csv', str(tmp_path)], 'a folder'),
                        (['--out', str(tmp_path / 'm'), '--csv', str(tmp_path / 'm')], 'twice'),
                        (['--effects', ','], "effects: ''")):
        assert main(['suggest', '--robot', str(file), '--max-speed', '1', *words]) == 2
        line, = capsys.readouterr().err.splitlines()
        assert says in line
    assert taken.read_text(encoding='utf-8') == 'kept'


def test_limits_that_lack_and_words_that_are_wrong(file, tmp_path, capsys):
    robot = gm.load_robot(file)
    assert limits_in(robot.file).torque.tolist() == [12.0, 5.0]
    for call, words in (
            (lambda: gm.suggest_robot(robot), 'speed: joint shoulder: no limit in the file'),
            (lambda: gm.suggest_robot(robot, ['paylod']), "effects: 'paylod'"),
            (lambda: gm.suggest_robot(robot, link='hand', speed=1.0), "link: 'hand'"),
            (lambda: gm.suggest_robot(robot, seconds=3.0), 'seconds: 3')):
        with pytest.raises(InputError, match=words):
            call()
    assert main(['suggest', '--robot', str(file), '--pair', 'lugre', 'stribeck']) == 2
    assert main(['suggest', '--link', 'hand', '--model', 'd.yaml', '--max-torque', '3']) == 2
    urdf = tmp_path / 'one.urdf'
    urdf.write_text('<robot name="r"><link name="base"/><link name="l"><inertial><mass value="1"/>'
                    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
                    '<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis '
                    'xyz="0 1 0"/><limit lower="-1" upper="2" effort="7" velocity="3"/></joint>'
                    '</robot>', encoding='utf-8')
    limits = limits_in(gm.load_robot(urdf).file)
    assert [x[0] for x in vars(limits).values()] == [-1.0, 2.0, 3.0, 7.0]
    for old, new, words in (('effort="7"', 'effort="0"', 'torque: joint j: 0 by file'),
                            ('lower="-1"', 'lower="2"', 'travel: joint j: 0 by file'),
                            ('mass value="1"', 'mass value="0"', 'no link has a mass')):
        other = tmp_path / 'other.urdf'
        other.write_text(urdf.read_text(encoding='utf-8').replace(old, new), encoding='utf-8')
        with pytest.raises(InputError, match=words):
            gm.suggest_robot(gm.load_robot(other), torque=3.0)
