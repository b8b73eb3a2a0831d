# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Replay of bags through the command line, no ROS needed."""
import csv
import json

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.joint_input import RecordedSnapshot
from gearbox_monitor.recordings.player import recorded_robot
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import replay, truth_of
from gearbox_monitor.recordings.write import BagWriter

JOINT_STATE = 'sensor_msgs/msg/JointState'
T0 = 1_700_000_000_000_000_000
N = 4000


@pytest.fixture(scope='module')
def drive():
    return simulate(DriveModel(), Excitation().torque(1e-3 * np.arange(N)), 1e-3,
                    Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=5)


@pytest.fixture
def bag(tmp_path, drive):
    """Return a user's bag: three joints, a namespace, motor (A) on its side of a gear of -20."""
    path = tmp_path / 'bag'
    stamps = T0 + np.arange(N) * 1_000_000
    nothing = np.full(N, np.nan)
    position = np.column_stack([nothing, drive.y[:, 1], -20.0 * drive.y[:, 0]])
    effort = np.column_stack([nothing, nothing, drive.u / -20.0 / 0.5])
    with BagWriter(path) as writer:
        writer.add_topic('/left/joint_states', JOINT_STATE)
        writer.add_topic('/left/plant/transmission_state', JOINT_STATE)
        messages = encode_joint_states(stamps, ['x', 'a', 'm'], position, effort=effort)
        truth = encode_joint_states(stamps, ['transmission'], drive.x[:, :1] - drive.x[:, 1:2],
                                    effort=drive.tau_k[:, None])
        others = encode_joint_states(stamps, ['gripper'], position[:, :1])
        for k in range(N):
            writer.write('/left/joint_states', int(stamps[k]), messages[k])
            writer.write('/left/joint_states', int(stamps[k]), others[k])
            writer.write('/left/plant/transmission_state', int(stamps[k]), truth[k])
    return path


@pytest.fixture
def options(tmp_path):
    """Return options that a user gives for that bag."""
    model = tmp_path / 'drive.yaml'
    model.write_text(yaml.safe_dump({'gear_ratio': -20.0, 'torque_constant': 0.5}))
    params = tmp_path / 'estimator.yaml'
    params.write_text(yaml.safe_dump({'/**': {'ros__parameters': {'rate': 3.0}}, 'estimator': {
        'ros__parameters': {'motor_joint': 'm', 'arm_joint': 'a', 'arm_load': 'model'}}}))
    return ['--model', str(model), '--params', str(params)]


def test_the_true_torque_of_a_gearbox_is_under_its_name(tmp_path):
    stamps = T0 + np.arange(3)
    with BagWriter(tmp_path / 'bag') as writer:
        for namespace, names in (('', ['base', 'elbow']), ('/left', ['transmission'])):
            topic = f'{namespace}/plant/transmission_state'
            writer.add_topic(topic, JOINT_STATE)
            values = np.tile(np.arange(len(names), dtype=float), (3, 1))
            for stamp, message in zip(stamps, encode_joint_states(stamps, names, values,
                                                                  effort=values)):
                writer.write(topic, int(stamp), message)
    with open_bag(tmp_path / 'bag') as reader:
        assert truth_of(reader, '', 'elbow') == ('/plant/transmission_state', 'elbow')
        assert truth_of(reader, '/left', 'elbow') == (  # a plant of a single drive
            '/left/plant/transmission_state', 'transmission')
        assert truth_of(reader, '/right', 'elbow') is None


def test_duration_is_that_of_all_runs_without_stamps_that_stray(tmp_path, drive, capsys):
    stamps = T0 + np.tile(np.arange(N // 2) * 1_000_000, 2)  # the clock restarts
    stamps[500] -= 5_000_000_000
    stamps[3000] += 100_000_000_000_000_000
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        for k, message in enumerate(encode_joint_states(stamps, ['motor', 'arm'], drive.y,
                                                        effort=drive.u[:, None] * [1.0, np.nan])):
            writer.write('/joint_states', T0 + k * 1_000_000, message)
    assert main(['replay', str(tmp_path / 'bag'), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['duration_s'] == pytest.approx(N * 1e-3, abs=0.01)
    assert told['rate_hz'] == pytest.approx(1000.0, abs=2.0)


def test_csv_and_json_hold_what_the_monitor_says(bag, options, drive, tmp_path, capsys):
    file = tmp_path / 'out.csv'
    assert main(['replay', str(bag), *options, '--out', str(file), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    expected = Monitor(DriveModel(), {'arm_load': 'none'}).run(Samples(
        T0 + np.arange(N) * 1_000_000, np.column_stack([drive.u, np.full(N, np.nan)]), drive.y))
    with open(file, newline='') as stream:
        rows = list(csv.reader(stream))
    assert rows[0] == ['stamp_ns', 'x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_k_std',
                       'innovation_motor', 'innovation_arm', 'nis']
    assert [int(row[0]) for row in rows[1:]] == expected.stamp_ns.tolist()
    np.testing.assert_allclose([float(row[5]) for row in rows[1:]], expected.tau_k, atol=1e-6)
    error = expected.tau_k[1000:] - drive.tau_k[1001:]
    assert told['samples'] == N and told['refused'] == {'starts': 1}
    assert told['tau_k_error'] == pytest.approx(np.sqrt((error ** 2).mean()), rel=0.01)
    assert told['tau_k_error_smoothed'] < 0.5 * told['tau_k_error']


def test_a_written_replay_replays_to_the_same_bits(bag, options, tmp_path, capsys):
    out, again = tmp_path / 'out', tmp_path / 'again'
    assert main(['replay', str(bag), *options, '--out', str(out)]) == 0
    assert main(['replay', str(out), '--out', str(again), '--json']) == 0
    told = json.loads(capsys.readouterr().out.partition('\n{')[2].join(['{', '']))
    assert told['replay_identical'] == 'yes' and told['comparison']['compared'] > 6 * (N - 200)
    with open_bag(out) as reader, open_bag(again) as second:
        assert {t: n for t, (_, n) in reader.topics.items()} == {
            t: n for t, (_, n) in second.topics.items()}
        states = reader.joint_states('/left/innovations_stddev', ('m', 'a'))
        assert (states.position > 0).all()


def test_a_changed_recording_is_told(bag, options, tmp_path, capsys):
    """Replay must be able to say no."""
    out = tmp_path / 'out'
    assert main(['replay', str(bag), *options, '--out', str(out)]) == 0
    changed = tmp_path / 'changed'
    with open_bag(out) as reader, BagWriter(changed) as writer:
        for topic, (kind, _) in reader.topics.items():
            writer.add_topic(topic, kind)
        for k, (topic, log_ns, _, raw) in enumerate(reader.messages()):
            if topic == '/left/transmission_state' and k > 9000:
                raw = raw[:-1] + bytes([raw[-1] ^ 1])  # last byte of tau_K
            writer.write(topic, log_ns, raw)
    capsys.readouterr()
    assert main(['replay', str(changed)]) == 1
    assert 'identical    no' in capsys.readouterr().out


def test_lost_samples_are_explained_not_blamed(bag, options, tmp_path):
    out, holed = tmp_path / 'out', tmp_path / 'holed'
    assert main(['replay', str(bag), *options, '--out', str(out)]) == 0
    with open_bag(out) as reader, BagWriter(holed) as writer:
        for topic, (kind, _) in reader.topics.items():
            writer.add_topic(topic, kind)
        for topic, log_ns, _, raw in reader.messages():
            lost = T0 + 2_000_000_000 <= log_ns < T0 + 2_005_000_000
            if not (lost and topic == '/left/joint_states'):
                writer.write(topic, log_ns, raw)
    with open_bag(holed) as reader:
        comparison = replay(reader).comparison
    assert comparison.lost_inputs == 5 and comparison.different == 0
    assert comparison.explained > 1000 and comparison.verdict == 'yes'


def test_a_snapshot_of_another_version_is_told_and_replayed(bag, options, tmp_path, capsys):
    out, other = tmp_path / 'out', tmp_path / 'other'
    assert main(['replay', str(bag), *options, '--out', str(out)]) == 0
    with open_bag(out) as reader, BagWriter(other) as writer:
        for topic, (kind, _) in reader.topics.items():
            writer.add_topic(topic, kind)
        for topic, log_ns, _, raw in reader.messages():
            writer.write(topic, log_ns, raw.replace(b'efforts\x00', b'effortz\x00')
                         if topic.endswith('/snapshot') else raw)
    capsys.readouterr()
    assert main(['replay', str(other), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['estimates'] == N - 1 and 'replay_identical' not in told
    assert 'not a snapshot of this version' in told['notes'][0]


@pytest.mark.parametrize('robot', ['[', '{}', '{"=": "RobotDescription"}'])
def test_a_damaged_robot_in_a_snapshot_is_refused(robot):
    settings = {'robot_description': 'arm.urdf'}
    with pytest.raises(InputError, match='^bag: not a snapshot of this version'):
        recorded_robot(settings, [RecordedSnapshot({
            'robot': robot, 'model': '{}', 'parameters': json.dumps(settings)}, 0)], 'bag')


WRONG = [
    (['--filter', 'kalman9'], "filter: 'kalman9', expected one of"),
    (['--topic', 'motor_states'], 'no topic /motor_states, the bag has /left/joint_states'),
    (['--params', 'DIR/wrong.yaml'], 'q_tau: unknown parameter, did you mean'),
    (['--params', 'DIR/joint.yaml'], "has no joint 'elbow', it has x, a, m, gripper"),
    (['--model', 'DIR/drive_wrong.yaml'], "arm_inertia: 'heavy', expected a number > 0"),
    (['--model', 'DIR/drive_typo.yaml'],
     "line 1: arm_inertai: unknown key, did you mean 'arm_inertia'?"),
    (['--out', 'DIR'], 'exists, expected a new file'),
    (['--out', 'DIR/no/where.csv'], 'where.csv: no such folder'),
]


def test_bad_input_is_one_line(bag, options, tmp_path, capsys):
    for extra, told in WRONG:
        for name, content in {
                'wrong.yaml': {'estimator': {'ros__parameters': {'q_tau': 1.0}}},
                'joint.yaml': {'estimator': {'ros__parameters': {'motor_joint': 'elbow'}}},
                'drive_wrong.yaml': {'arm_inertia': 'heavy'},
                'drive_typo.yaml': {'arm_inertai': 1.0}}.items():
            (tmp_path / name).write_text(yaml.safe_dump(content))
        extra = [word.replace('DIR', str(tmp_path)) for word in extra]
        assert main(['replay', str(bag), *options, *extra]) == 2
        errors = capsys.readouterr().err.splitlines()
        assert len(errors) == 1 and told in errors[0], errors
