# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bags of other robots: ROS 1, messages of ros2_control, bursts, missing stamps, publishers."""
import json
import re
import shlex

from mcap.writer import Writer as McapWriter
import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.joint_input import find_topic
from gearbox_monitor.recordings.read import CONTROLLER, DEFINITIONS, DYNAMIC, JOINT_STATE, open_bag
from gearbox_monitor.recordings.write import BagWriter

T0, N, RATE = 1_700_000_000_000_000_000, 2400, 400.0
STAMPS = T0 + np.rint(np.arange(N) * 1e9 / RATE).astype(np.int64)
JOINTS = ('shoulder', 'elbow')
Q = np.column_stack([np.sin(2.0 * np.arange(N) / RATE), np.cos(3.0 * np.arange(N) / RATE)])
STORE = get_typestore(Stores.ROS2_JAZZY)
MULTI = 'sensor_msgs/msg/MultiDOFJointState'
OF_CONTROLLER = ('std_msgs/Header header\nstring[] joint_names\n'
                 'trajectory_msgs/JointTrajectoryPoint reference\n'
                 'trajectory_msgs/JointTrajectoryPoint feedback\n')


def header(stamp):
    time = STORE.types['builtin_interfaces/msg/Time'](stamp // 10 ** 9, stamp % 10 ** 9)
    return STORE.types['std_msgs/msg/Header'](time, '')


def states(path, stamps, names, position, effort, log):
    """Write a bag of joint states, received at `log`."""
    with BagWriter(path) as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        raws = encode_joint_states(stamps, names, position, effort=effort)
        for at, raw in zip(np.asarray(log).tolist(), raws):
            writer.write('/joint_states', at, raw)
    return str(path)


def drive(seconds=6.0, rate=RATE, seed=3):
    """Return (model, torque [N, 2], positions [N, 2]) of a simulated drive."""
    model = DriveModel()
    t = np.arange(int(seconds * rate)) / rate
    u = Excitation().torque(t)
    u[:300] = 0.0
    y = simulate(model, u, 1.0 / rate, Noise(measurement=(5e-3, 5e-3)), seed=seed).y
    return model, np.column_stack([u, np.full(len(t), np.nan)]), y


def imported(tmp_path, *options):
    assert main(['import', *map(str, options), str(tmp_path / 'new')]) == 0
    with open_bag(tmp_path / 'new') as reader:
        joints = reader.joint_names('/joint_states')
        return reader.joint_states('/joint_states', joints), dict(reader.topics)


@pytest.mark.parametrize('factor, verdict', [(1.0, 'ok'), (3.0, 'warn')])
def test_check_states_the_nis_of_any_filter(tmp_path, capsys, factor, verdict):
    """Of a flight controller's estimator, without joint states; matched by time."""
    kind = 'px4_msgs/msg/EstimatorInnovations'
    text = 'uint64 timestamp\nfloat32[2] gps_hvel\nfloat32 baro_vpos\n'
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(text, kind))
    random = np.random.default_rng(4)
    std = np.array([0.3, 0.5, 2.0])
    with BagWriter(tmp_path / 'flight') as writer:
        topics = [f'/fmu/out/estimator_innovation{name}' for name in ('s', '_variances')]
        for topic in topics:
            writer.add_topic(topic, kind, msgdef=text)
        for k in range(400):
            rows = std * random.standard_normal(3), std ** 2 / factor
            for topic, row, late in zip(topics, rows, (0, 1)):
                message = store.types[kind](k, row[:2].astype('f4'), float(row[2]))
                if not (late and k == 7):
                    writer.write(topic, T0 + 10 ** 6 * k,
                                 bytes(store.serialize_cdr(message, kind)))
    assert main(['check', str(tmp_path / 'flight'), '--json', '-']) == 0
    line, = json.loads(capsys.readouterr().out)['lines']
    assert line['verdict'] == verdict and f'over {3 * 399} readings' in line['figure']
    values = line['values']
    assert values['nis'] == pytest.approx(factor, rel=0.15)
    assert values['nis_baro_vpos'] == pytest.approx(factor, rel=0.25)
    assert ('too little noise' in line['advice']) == (factor > 1.0)


def test_ros1_bag(tmp_path, capsys):
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    with Writer1(tmp_path / 'old.bag') as writer:
        connection = writer.add_connection('/joint_states', JOINT_STATE, typestore=store)
        for k, stamp in enumerate(STAMPS.tolist()):
            time = types['builtin_interfaces/msg/Time'](stamp // 10 ** 9, stamp % 10 ** 9)
            message = types[JOINT_STATE](types['std_msgs/msg/Header'](k, time, ''), list(JOINTS),
                                         Q[k], np.zeros(0), 2.0 * Q[k])
            writer.write(connection, stamp, store.serialize_ros1(message, JOINT_STATE))
    main(['check', str(tmp_path / 'old.bag'), '--motor-joint', 'elbow', '--arm-joint', ''])
    assert '2400, all increasing' in capsys.readouterr().out
    found, _ = imported(tmp_path, tmp_path / 'old.bag')
    assert found.names == JOINTS
    np.testing.assert_array_equal(found.position, Q)
    np.testing.assert_array_equal(found.stamp_ns, STAMPS)
    np.testing.assert_array_equal(found.effort, 2.0 * Q)


def test_mcap_of_ros1_and_schemas_of_foxglove(tmp_path, capsys):
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    for name, schema, encoding, form in (
            ('old', 'sensor_msgs/JointState', 'ros1msg', 'ros1'),
            ('web', 'foxglove.JointStates', 'jsonschema', 'ros1'),
            ('page', JOINT_STATE, 'jsonschema', 'json')):
        with open(tmp_path / f'{name}.mcap', 'wb') as file:
            writer = McapWriter(file)
            writer.start()
            number = writer.register_schema(schema, encoding, b'{}' if name != 'old' else
                                            store.generate_msgdef(JOINT_STATE)[0].encode())
            channel = writer.register_channel('/joint_states', form, number)
            for k, stamp in enumerate(STAMPS.tolist()):
                time = types['builtin_interfaces/msg/Time'](stamp // 10 ** 9, stamp % 10 ** 9)
                message = types[JOINT_STATE](types['std_msgs/msg/Header'](k, time, ''),
                                             list(JOINTS), Q[k], np.zeros(0), 2.0 * Q[k])
                writer.add_message(channel, stamp, bytes(store.serialize_ros1(
                    message, JOINT_STATE)), stamp)
            writer.finish()
    found, _ = imported(tmp_path, tmp_path / 'old.mcap')
    np.testing.assert_array_equal(found.position, Q)
    np.testing.assert_array_equal(found.stamp_ns, STAMPS)
    assert main(['check', str(tmp_path / 'web.mcap')]) == 2
    assert '/joint_states (foxglove.JointStates): schemas of Foxglove' in capsys.readouterr().err
    assert main(['check', str(tmp_path / 'page.mcap')]) == 2
    assert f'has type {JOINT_STATE} in json, expected' in capsys.readouterr().err


def test_states_of_ros2_control_and_setpoints_of_a_controller(tmp_path, capsys):
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    state, interface = store.types[DYNAMIC], store.types['control_msgs/msg/InterfaceValue']
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/dynamic_joint_states', DYNAMIC)  # without definition, as many have it
        for k, stamp in enumerate(STAMPS.tolist()):
            values = [interface(['effort', 'position', 'temperature'],
                                np.array([3.0 * q, q, 30.0])) for q in Q[k]]
            message = state(header(stamp), list(JOINTS), values)
            writer.write('/dynamic_joint_states', stamp, bytes(store.serialize_cdr(
                message, DYNAMIC)))
    found, topics = imported(tmp_path, tmp_path / 'bag')
    np.testing.assert_array_equal(found.position, Q)
    np.testing.assert_array_equal(found.effort, 3.0 * Q)
    assert 'interfaces that are not used: temperature' in capsys.readouterr().out
    assert set(topics) == {'/joint_states'}


def publish(path, topics):
    """Write a bag of joint states, {topic: (joints, position [N, J], stamps)}."""
    with BagWriter(path) as writer:
        for topic, (joints, position, stamps) in topics.items():
            writer.add_topic(topic, JOINT_STATE)
            for stamp, raw in zip(stamps.tolist(), encode_joint_states(stamps, joints, position)):
                writer.write(topic, stamp, raw)
    return path


TELLING = [
    (('/joint_states', '/joint_commands'), (), '/joint_states'),
    (('/joint_states', '/joint_commands'), ('--topic', 'joint_commands'), '/joint_commands'),
    (('/joint_states', '/a/joint_states'), ('--topic', '/a/joint_states'), '/a/joint_states'),
    (('/r/joint_states', '/r/wrist/transmission_state'), ('--stamps', 'received'),
     '/r/joint_states'),
    (('/robot/states', '/joint_setpoints'), (), '/robot/states')]


def test_one_topic_tells_the_states(new_folder, capsys):
    for topics, options, kept in TELLING:
        folder = new_folder()
        publish(folder / 'bag', {name: (JOINTS, Q + k, STAMPS + k)
                                 for k, name in enumerate(topics)})
        recorded, _ = imported(folder, folder / 'bag', *options)
        k = topics.index(kept)
        np.testing.assert_array_equal(recorded.stamp_ns, STAMPS + k)
        np.testing.assert_array_equal(recorded.position, Q + k)
        topic = dict(zip(options[::2], options[1::2])).get('--topic', 'joint_states')
        with open_bag(folder / 'bag') as reader:
            assert find_topic(reader, topic) == kept  # as other commands and Python take it
        unused = topics[1 - k]
        notes = [line for line in capsys.readouterr().out.splitlines()
                 if line.startswith('note: ')]
        assert ('setpoints' in unused) != any(f'{unused}: 2400 messages left out' in note
                                              for note in notes)


SEVERAL = [
    (('/joint_states', '/b/joint_states'), (), '2 topics of joint states, expected one: '
     '--topic /b/joint_states or --topic /joint_states', 3),
    (('/sensor', '/goal'), (), '/goal, /sensor: 2 topics of joint states', 3),
    (('/sensor', '/goal'), ('--topic', 'goals'), '--topic goals: no topic of joints, expected '
     'one of /goal, /sensor', 2)]


def test_several_topics_of_states_are_asked_for(new_folder, capsys):
    for topics, options, says, code in SEVERAL:
        folder = new_folder()
        publish(folder / 'bag', {name: (JOINTS, Q, STAMPS) for name in topics})
        assert main(['import', str(folder / 'bag'), *options, str(folder / 'new')]) == code
        assert says in capsys.readouterr().err
        assert not (folder / 'new').exists()
        with open_bag(folder / 'bag') as reader, pytest.raises(
                Undecided if code == 3 else InputError, match=says if code == 3 else 'no topic'):
            find_topic(reader, options[-1] if options else 'joint_states')


def test_an_imported_robot_keeps_its_setpoints(tmp_path):
    publish(tmp_path / 'bag', {'/joint_states': (JOINTS, Q, STAMPS),
                               '/joint_setpoints': (JOINTS, 2.0 * Q, STAMPS)})
    _, topics = imported(tmp_path, tmp_path / 'bag', '--stamps', 'received')
    assert {name: count for name, (_, count) in topics.items()} == {
        '/joint_states': N, '/joint_setpoints': N}
    with open_bag(tmp_path / 'new') as reader:
        np.testing.assert_array_equal(
            reader.joint_states('/joint_setpoints', JOINTS).position, 2.0 * Q)
    for bag in ('bag', 'new'):  # a drive finds them, too
        servo = DriveModel().with_(controller={'kp': 40.0, 'kd': 1.0, 'torque_limit': 9.0})
        joint = load_recording(tmp_path / bag, servo, joints={'motor': 'elbow', 'arm': ''})
        np.testing.assert_array_equal(joint.setpoint, 2.0 * Q[:, 1])


def controller_states(writer, topic, positions, setpoints):
    """Write the states of a controller of JOINTS, `positions` and `setpoints` [N, J]."""
    text = get_typestore(Stores.ROS2_JAZZY)
    text.register(get_types_from_msg(OF_CONTROLLER, CONTROLLER))
    point = text.types['trajectory_msgs/msg/JointTrajectoryPoint']
    duration = text.types['builtin_interfaces/msg/Duration'](0, 0)
    none = np.zeros(0)
    writer.add_topic(topic, CONTROLLER, msgdef=text.generate_msgdef(CONTROLLER, ros_version=2)[0])
    for stamp, position, setpoint in zip(STAMPS.tolist(), positions, setpoints):
        message = text.types[CONTROLLER](header(stamp), list(JOINTS), *(
            point(values, none, none, none, duration) for values in (setpoint, position)))
        writer.write(topic, stamp, bytes(text.serialize_cdr(message, CONTROLLER)))


def test_a_controller_tells_the_setpoints_beside_the_joint_states(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        for stamp, raw in zip(STAMPS.tolist(), encode_joint_states(STAMPS, JOINTS, Q)):
            writer.write('/joint_states', stamp, raw)
        controller_states(writer, '/arm_controller/controller_state', Q + 5.0, 3.0 * Q)
    recorded, topics = imported(tmp_path, tmp_path / 'bag')
    np.testing.assert_array_equal(recorded.position, Q)
    assert topics['/joint_states'][1] == topics['/joint_setpoints'][1] == N
    assert ('/arm_controller/controller_state: states of shoulder, elbow left out: those of '
            '/joint_states count') in capsys.readouterr().out


def test_two_controllers_of_the_same_joints_are_asked_for(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        for topic in ('/a/controller_state', '/b/controller_state'):
            controller_states(writer, topic, Q, Q)
    assert main(['import', str(tmp_path / 'bag'), str(tmp_path / 'new')]) == 3
    assert '--topic /a/controller_state or --topic /b/controller_state' in capsys.readouterr().err
    recorded, _ = imported(tmp_path, tmp_path / 'bag', '--topic', '/b/controller_state')
    np.testing.assert_array_equal(recorded.position, Q)


UNUSED = [
    (('--use', 'motor=a', '--rate', '9'), '--use, --rate: no effect with a bag as FILE'),
    (('--set', 'a=1'), '--set: no effect with a bag as FILE, expected --topic or --stamps'),
    (('--joint', 'a'), '(commands read one joint with --recorded-motor NAME)'),
    (('--arm-topic', '/b', '--joint', 'a'), '--joint: no effect with --params or --arm-topic')]


def test_options_that_a_bag_does_not_use_are_refused(new_folder, capsys):
    for options, says in UNUSED:
        folder = new_folder()
        publish(folder / 'bag', {'/joint_states': (JOINTS, Q, STAMPS)})
        assert main(['import', str(folder / 'bag'), *options, str(folder / 'new')]) == 2
        assert says in capsys.readouterr().err


def test_poses_of_bodies_are_refused_by_name(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/multi', MULTI)
        writer.write('/multi', T0, bytes(STORE.serialize_cdr(STORE.types[MULTI](
            header(T0), [], [], [], []), MULTI)))
    assert main(['import', str(tmp_path / 'bag'), str(tmp_path / 'new')]) == 2
    assert 'MultiDOFJointState: poses of bodies' in capsys.readouterr().err


def bursts(stamps, size):
    """Return when packets of `size` samples were received, with a microsecond in between."""
    last = np.minimum(np.arange(len(stamps)) // size * size + size - 1, len(stamps) - 1)
    return stamps[last] + 1000 * (np.arange(len(stamps)) % size) + 400_000


SPOILT = [
    (lambda s: 0 * s, 2, 'all 2400 header stamps are 0'),
    (lambda s: bursts(s, 16), 1, '400 samples/s on average, stamped in bursts of 16 on receipt'),
    (lambda s: bursts(s, 16) // 10 ** 6 * 10 ** 6, 1, 'stamped in bursts of 16 on receipt')]


def test_what_check_recommends_for_stamps_makes_them_even(new_folder, capsys):
    for spoil, code, says in SPOILT:
        folder = new_folder()
        _, u, y = drive()
        path = states(folder / 'bag', spoil(STAMPS), ('motor', 'arm'), y, u, log=STAMPS + 200_000)
        assert main(['check', path]) == code
        out, err = capsys.readouterr()
        shown = ' '.join((out + err).split())
        assert says in shown
        words = re.search(r'gearbox_monitor (import BAG --stamps \w+ NEW)', shown)[1]
        words = words.replace('BAG', path).replace('NEW', str(folder / 'new'))
        assert main(shlex.split(words)) == 0
        with open_bag(folder / 'new') as reader:
            found = reader.joint_states('/joint_states', ('motor', 'arm'))
        steps = np.diff(found.stamp_ns) * 1e-9
        assert abs(steps.mean() * RATE - 1.0) < 1e-3 and steps.std() < 1e-5
        assert main(['check', str(folder / 'new'), '--for', 'estimation']) == 0, \
            capsys.readouterr().out


def test_two_publishers_on_one_topic_are_named_and_paired(tmp_path, capsys):
    _, u, y = drive()
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        motor = encode_joint_states(STAMPS, ['motor'], y[:, :1], effort=u[:, :1])
        arm = encode_joint_states(STAMPS[::2] + 100_000, ['arm'], y[::2, 1:])
        for k, stamp in enumerate(STAMPS.tolist()):
            writer.write('/joint_states', stamp + 200_000, motor[k])
            if k % 2 == 0:
                writer.write('/joint_states', stamp + 300_000, arm[k // 2])
    path = str(tmp_path / 'bag')
    assert main(['check', path]) == 1
    shown = ' '.join(capsys.readouterr().out.split())
    assert re.search(r'the motor at 400\.\d Hz, the arm at 200\.\d Hz', shown)
    assert 'cable' not in shown
    for command in ('fit noise', 'diagnose', 'fit model'):
        (tmp_path / 'drive.yaml').write_text('{}')
        options = ['--model', str(tmp_path / 'drive.yaml')]
        if command != 'diagnose':
            options += ['--out', str(tmp_path / 'out.yaml')]
        assert main([*command.split(), path, *options]) == 2
        assert 'arm_topic' in capsys.readouterr().err
    assert main(['import', path, '--arm-topic', 'joint_states', str(tmp_path / 'new')]) == 0
    assert '1199 samples without the arm; 0 messages of the arm' in capsys.readouterr().out
    assert main(['check', str(tmp_path / 'new'), '--for', 'estimation']) == 0


def test_resets_are_counted_as_replay_counts_them(tmp_path, capsys):
    _, u, y = drive()
    stamps = STAMPS - T0 + 1
    stamps[1000:] -= stamps[1000] - 1
    path = states(tmp_path / 'bag', stamps, ('motor', 'arm'), y, u, log=STAMPS)
    main(['check', path, '--json', '-'])
    order = next(line for line in json.loads(capsys.readouterr().out)['lines']
                 if line['name'] == 'order')
    assert order['values']['restarts'] == 1 and order['verdict'] == 'warn'
    assert main(['replay', path, '--json']) == 0
    refused = json.loads(capsys.readouterr().out)['refused']
    assert refused['backward stamps'] == order['values']['refused'] == 2
    assert refused['starts'] == 2


def test_turns_of_a_drive_are_counted_on(tmp_path, capsys):
    model, u, y = drive()
    plain = load_recording(states(tmp_path / 'plain', STAMPS, ('motor', 'arm'), y + 2.0, u,
                                  log=STAMPS), model)
    path = states(tmp_path / 'bag', STAMPS, ('motor', 'arm'), np.mod(y + 2.0, 2.0 * np.pi), u,
                  log=STAMPS)
    recording, notes = load_recording(path, model).uniform()
    np.testing.assert_allclose(recording.y, plain.uniform()[0].y, atol=1e-12)
    assert sum('turns are counted on' in note for note in notes) == 2
    main(['check', path, '--json', '-'])
    data = json.loads(capsys.readouterr().out)
    line = next(line for line in data['lines'] if line['name'] == 'wraps')
    assert line['hurts'] == {'estimation': 'bad', 'drift': 'bad', 'diagnosis': 'warn'}
    assert data['suits']['diagnosis']['verdict'] != 'no'
