# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One estimator node for several gearboxes: as single ones, as replay, with bad blocks."""
from array import array
from itertools import chain
import json
import math
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from drives import driven, samples_of  # noqa: E402
from harness import RELIABLE  # noqa: E402
from processes import refusals  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from rclpy.serialization import deserialize_message  # noqa: E402
from rosbags.typesys import get_typestore, Stores  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.cli.main import main  # noqa: E402
from gearbox_monitor.errors import InputError  # noqa: E402
from gearbox_monitor.estimation.estimates import Sample  # noqa: E402
from gearbox_monitor.files.user_files import config_path, load_parameters  # noqa: E402
from gearbox_monitor.health.monitor import Monitor  # noqa: E402
from gearbox_monitor.parameters import resolve, SETTINGS  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.recordings.cdr import encode_joint_states, FIELDS  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.recordings.replay import replay  # noqa: E402
from gearbox_monitor.recordings.topics import joint_values, signal_values, SIGNALS  # noqa: E402
from gearbox_monitor.recordings.write import BagWriter  # noqa: E402
from gearbox_monitor.ros.convert import (  # noqa: E402
    GearboxNames, JointReader, stamp_of, to_joint_states, to_time)

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 4_000_000  # 250 Hz
N = 1500
DEEP = QoSProfile(depth=20_000)
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NAMES = ('base', 'elbow', 'wrist')
SILENT = slice(500, 700)  # the elbow says nothing: longer than max_gap
PARAMETERS = {
    'gearboxes': list(NAMES), 'snapshot_period': 1.5,
    **{name: {'motor_joint': f'{name}_motor', 'arm_joint': f'{name}_arm'} for name in NAMES},
    'qos_overrides': {'/joint_states': {'subscription': {
        key.rpartition('.')[2]: value for key, value in RELIABLE.items()}}}}
PARAMETERS['elbow'].update(q_std_tau_k=4.0, coulomb_friction=0.2, gearbox_serial='G-2')
PARAMETERS['wrist'].update(filter='ukf', r_std_arm=0.01)


def written(tmp_path, **changes):
    file = tmp_path / 'robot.yaml'
    file.write_text(json.dumps({'estimator': {'ros__parameters': {**PARAMETERS, **changes}}}))
    return file


def robot():
    """Return {gearbox: Samples} of N samples; the elbow is silent for a while."""
    dt = DT * 1e-9
    samples = {name: samples_of(driven(DriveModel(), N * dt, seed=seed, dt=dt), dt, T0)
               for seed, name in enumerate(NAMES)}
    samples['elbow'].u[SILENT] = samples['elbow'].y[SILENT] = np.nan
    return samples


def sent(graph, publisher, samples):
    """Publish `samples` of all gearboxes, in one message each, faster than real time."""
    names = [f'{name}_{joint}' for name in NAMES for joint in ('motor', 'arm')]
    begin = time.monotonic()
    for k in range(N):
        message = JointState(name=names)
        message.header.stamp = to_time(T0 + k * DT)
        message.position = array('d', [v for s in samples.values() for v in s.y[k]])
        message.effort = array('d', [v for s in samples.values() for v in (s.u[k, 0], math.nan)])
        publisher.publish(message)
        if k % 10 == 9:
            graph.executor.spin_once(timeout_sec=0.0)
            time.sleep(max(0.0, begin + k / 500.0 - time.monotonic()))


def test_each_gearbox_is_as_a_single_one_and_as_its_replay(graph, tmp_path, capsys):
    """The same bits, though one of them is silent for a while; services, names of diagnostics."""
    file, samples = written(tmp_path), robot()
    snapshots = [f'/estimator/{name}/snapshot' for name in NAMES]
    recorder = graph.start(
        'recorder_node', output=tmp_path / 'bag', queue_depth=20_000,
        topics=str(['joint_states', *(signal.topic for signal in SIGNALS), *snapshots]))
    estimator = graph.start('estimator_node', '--params-file', str(file))
    publisher = graph.node.create_publisher(JointState, 'joint_states', DEEP)
    statuses, begun, stamps = {}, set(), [0]
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', lambda message: [
        statuses.update({s.name: s}) for s in message.status], 50)

    graph.node.create_subscription(
        JointState, 'transmission_state', lambda message: stamps.append(stamp_of(message)), DEEP)
    for topic in snapshots:
        graph.node.create_subscription(
            DiagnosticArray, topic, lambda m, topic=topic: begun.add(topic), LATCHED)
    graph.until(lambda: len(begun) == 3 and publisher.get_subscription_count() == 2
                and graph.node.count_subscribers('/innovations'), 'matching')
    sent(graph, publisher, samples)
    graph.until(lambda: stamps[-1] == T0 + (N - 1) * DT, 'all samples')
    graph.spin(1.0)
    answer = graph.call(Trigger, 'estimator/elbow/reset', Trigger.Request())
    assert answer.success and answer.message == 'elbow: filter restarts with the next sample'
    answer = graph.call(Trigger, 'estimator/save_baseline', Trigger.Request())
    assert not answer.success and [part.split(':')[0] for part in answer.message.split('; ')] == [
        *NAMES]
    graph.stop(estimator)
    graph.stop(recorder)
    assert {name for name in statuses if name.endswith(': input')} == {
        f'estimator/{name}: input' for name in NAMES}
    assert statuses['estimator/elbow: input'].hardware_id == 'G-2'
    assert statuses['estimator/base: input'].hardware_id == 'base'
    with open_bag(tmp_path / 'bag') as bag:
        recorded, taken = bag.topics['/joint_states'][1], {}
        with pytest.raises(InputError, match='taken by /estimator/base, .* --topic'):
            replay(bag)
        assert main(['check', str(tmp_path / 'bag')]) == 2  # whose innovations are no whole bag
        assert 'taken by /estimator/base, ' in capsys.readouterr().err
        for name in NAMES:
            replayed = replay(bag, topic=name)
            comparison, taken[name] = replayed.comparison, replayed.summary['samples']
            # A starved recorder misses messages: as many as the comparison says.
            assert comparison.verdict == 'yes' and comparison.compared, (name, comparison)
            assert comparison.lost_inputs or not comparison.explained
            single = Monitor(*resolve(DriveModel(), load_parameters(
                file, 'estimator', SETTINGS, f'/estimator/{name}')))
            estimates = single.run(samples[name])
            joints = {'transmission': name, 'motor': f'{name}_motor', 'arm': f'{name}_arm'}
            for signal in SIGNALS:
                live = bag.joint_states(f'/{signal.topic}', [joints[j] for j in signal.joints])
                live = live.of_named()
                expected_ns, values = signal_values(signal, estimates, 1.0)
                rows = np.searchsorted(expected_ns, live.stamp_ns)
                np.testing.assert_array_equal(live.stamp_ns, expected_ns[rows])
                assert len(rows)
                for field, expected in values.items():
                    np.testing.assert_array_equal(
                        getattr(live, field), expected[rows], f'{name} {signal.topic}')
    page, figures = tmp_path / 'robot.html', tmp_path / 'robot.json'
    assert main(['report', str(tmp_path / 'bag'), '--out', str(page), '--json',
                 str(figures)]) == 0
    joints = json.loads(figures.read_text())['joints']
    assert {name: joint['samples'] for name, joint in joints.items()} == taken
    assert 0.9 * recorded < min(taken.values()) <= max(taken.values()) <= recorded
    for name in NAMES:
        assert f'href="robot.{name}.html"' in page.read_text(encoding='utf-8')
        assert (tmp_path / f'robot.{name}.html').exists()


def test_a_bag_of_joint_states_alone_is_evaluated_with_the_parameters_of_the_robot(
        tmp_path, capsys):
    """As ros2 bag records it: a gearbox is TOPIC/GEARBOX, and the page has a row for each."""
    file, samples = written(tmp_path), robot()
    raws = encode_joint_states(
        samples['base'].stamp_ns,
        [f'{name}_{joint}' for name in NAMES for joint in ('motor', 'arm')],
        np.hstack([samples[name].y for name in NAMES]),
        effort=np.hstack([samples[name].u for name in NAMES]))
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/arm/joint_states', 'sensor_msgs/msg/JointState')
        for stamp, raw in zip(samples['base'].stamp_ns.tolist(), raws):
            bag.write('/arm/joint_states', stamp, raw)
    words = [str(tmp_path / 'bag'), '--params', str(file),
             '--model', str(config_path('drive.yaml'))]
    assert main(['replay', *words]) == 2
    assert 'choose it with --topic joint_states/base' in capsys.readouterr().err
    assert main(['replay', *words, '--topic', 'joint_states/wrist', '--json']) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data['samples'], data['filter']) == (N, 'ukf')
    assert main(['report', *words, '--out', str(tmp_path / 'r.html'), '--json', '-']) == 0
    joints = json.loads(capsys.readouterr().out)['joints']
    assert {name: joint['filter'] for name, joint in joints.items()} == {
        'base': 'ekf', 'elbow': 'ekf', 'wrist': 'ukf'}
    assert (tmp_path / 'r.wrist.html').exists()
    assert main(['report', *words, '--topic', 'joint_states/hand']) == 2
    assert 'gearboxes: base, elbow, wrist' in capsys.readouterr().err
    written(tmp_path, gearboxes=5)
    assert main(['report', *words, '--out', str(tmp_path / 'q.html')]) == 2
    assert 'gearboxes: 5, expected a list of names' in capsys.readouterr().err


def test_messages_hold_the_values_of_each_gearbox():
    """For a drive with a gear that turns the other way; with a joint that is not measured, too."""
    robots = robot()
    models = {name: DriveModel(gear_ratio=ratio)
              for name, ratio in zip(NAMES, (1.0, -50.0, 100.0))}
    monitors = {name: Monitor(model, {'arm_load': 'none'}) for name, model in models.items()}
    names = {name: GearboxNames({'transmission': name, 'motor': f'{name}_m', 'arm': f'{name}_a'},
                                model.gear_ratio) for name, model in models.items()}
    read, lengths, store = JointReader(), set(), get_typestore(Stores.ROS2_JAZZY)
    for k in range(400, 700):  # from 500 on the elbow has no measurement
        estimates = [(names[name], estimate) for name, monitor in monitors.items()
                     if (estimate := monitor.step(Sample(
                         T0 + k * DT, tuple(robots[name].u[k]), tuple(robots[name].y[k]))))]
        for signal in SIGNALS:
            for raw in to_joint_states(signal, estimates):
                message = deserialize_message(raw, JointState)
                # As another writer has it, to the byte: some readers refuse what is left over.
                kind = 'sensor_msgs/msg/JointState'
                assert store.serialize_cdr(store.deserialize_cdr(raw, kind), kind) == raw
                expected = [joint_values(signal, row, own.joints, own.gear_ratio)
                            for own, estimate in estimates for stamp, row in (
                                estimate.smoothed if signal.smoothed
                                else [(estimate.stamp_ns, estimate.row)])
                            if stamp == stamp_of(message)]
                assert [message.name, *(getattr(message, field).tolist() for field in FIELDS)] == [
                    [*chain(*parts)] for parts in zip(*expected)]
                for _ in range(2):  # as any message, and as one that is known
                    stamp, joints, *values = read(raw)
                    assert stamp == stamp_of(message) and list(joints) == message.name
                    assert [*map(list, values)] == [
                        message.position.tolist(), message.effort.tolist()]
                lengths.add(len(message.name))
    assert lengths == {2, 3, 4, 6}


def test_a_bad_block_is_named(tmp_path):
    cases = [
        ({'elbow': {'motor_joint': 'm2', 'max_gap': -1.0}},
         'elbow.max_gap: -1.0, expected a number'),
        ({'elbow': {}}, "elbow.motor_joint: 'motor', expected another than that of base"),
        ({'elbow': {'motor_joint': 'm2', 'model': 'nowhere.yaml'}},
         'elbow: nowhere.yaml: No such'),
        ({'gearboxes': ['base', 'filter']}, "gearboxes: 'filter', expected different names")]
    words = []
    for k, (changes, _) in enumerate(cases):
        base = {'motor_joint': 'm1' if changes.get('elbow', True) else 'motor',
                'arm_joint': 'a1'}
        file = tmp_path / f'{k}.yaml'
        file.write_text(json.dumps({'estimator': {'ros__parameters': {
            'gearboxes': ['base', 'elbow'], 'base': base, **changes}}}))
        words.append(['--params-file', str(file)])
    for (code, lines), (_, said) in zip(refusals('estimator_node', words, tmp_path), cases):
        assert code == 2 and len(lines) == 1 and said in lines[0], lines
