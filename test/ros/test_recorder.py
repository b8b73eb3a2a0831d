# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The recorder as a real process, fed over DDS: accidents, signals, QoS, any type."""
from pathlib import Path
import re
import resource
import signal
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402, I100, I202
from geometry_msgs.msg import PolygonStamped  # noqa: E402
from processes import refusals  # noqa: E402
from rclpy.duration import Duration  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402
from rosbags.typesys import get_types_from_msg, get_typestore, Stores  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402

from gearbox_monitor.recordings.cdr import encode_joint_states  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.ros.convert import message_definition  # noqa: E402

pytestmark = pytest.mark.ros
BEST_EFFORT = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def node(graph):
    return graph.node


@pytest.fixture
def recorder(graph):
    """Return a function of (topics, **parameters) that starts a recorder."""
    return lambda topics=('joint_states',), **parameters: graph.start(
        'recorder_node', **{'output': graph.tmp_path / 'bag', 'topics': f'[{",".join(topics)}]',
                            **parameters})


def wait_for(condition, what, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f'{what} did not happen'
        time.sleep(0.02)


def wait_matched(*publishers):
    wait_for(lambda: all(p.get_subscription_count() for p in publishers), 'matching')


def waited_for_a_core(pid):
    """Return for how long (ns) the threads of process `pid` were ready and had no core."""
    return sum(int(file.read_text().split()[1])
               for file in Path(f'/proc/{pid}/task').glob('*/schedstat'))


def stop(process, sig=signal.SIGINT):
    process.send_signal(sig)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert 'Traceback' not in errors and 'Failed' not in errors, errors
    return errors


def publish_at(publishers, rate, seconds):
    """Publish numbered joint states on all `publishers`; return the time of each, ns."""
    count = int(rate * seconds)
    values = np.arange(count)[:, None] * [1.0, -1.0]
    raws = encode_joint_states(np.arange(count), ['motor', 'arm'], values, effort=values)
    times, begin = [], time.monotonic()
    for k, raw in enumerate(raws):
        times.append(time.time_ns())
        for publisher in publishers:
            publisher.publish(raw)
        time.sleep(max(0.0, begin + (k + 1) / rate - time.monotonic()))
    return np.array(times)


@pytest.mark.parametrize('rate, seconds, topics', [
    (1000, 2.5, ['joint_states', 'innovations', 'one', 'two']),
    (2, 3.6, ['joint_states']),
])
def test_kill_loses_one_second_at_most(node, recorder, tmp_path, rate, seconds, topics):
    publishers = [node.create_publisher(JointState, topic, 1000) for topic in topics]
    process = recorder(topics)
    wait_matched(*publishers)
    times = publish_at(publishers, rate, seconds)
    starved_ns = waited_for_a_core(process.pid)
    process.kill()
    killed_ns = time.time_ns()
    process.wait()
    needed = np.flatnonzero(times < killed_ns - 1_000_000_000 - starved_ns)
    with open_bag(tmp_path / 'bag') as bag:
        assert bag.truncated and bag.metadata['gearbox_monitor']['version']
        for topic in topics:
            found = bag.joint_states('/' + topic, ['motor', 'arm'])
            assert np.isin(needed, found.stamp_ns).all()
            np.testing.assert_array_equal(found.position[:, 0], found.stamp_ns)
            np.testing.assert_array_equal(found.effort[:, 1], -found.position[:, 0])
            assert (np.abs(found.log_ns - times[found.stamp_ns]) < 10**9).all()


def test_a_new_start_records_beside_the_bag_of_a_killed_recorder(node, recorder, tmp_path):
    publisher = node.create_publisher(JointState, 'joint_states', 1000)
    process = recorder()
    wait_matched(publisher)
    publish_at([publisher], 500, 1.0)
    process.kill()
    process.wait()
    before = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    process = recorder()
    wait_for(lambda: (tmp_path / 'bag_2').exists(), 'a second bag')
    time.sleep(1.0)  # the node is up, and a signal ends it as it should
    assert f'to {tmp_path / "bag_2"}; lost' in stop(process)
    assert (tmp_path / 'bag' / 'bag_0.mcap').read_bytes() == before
    with open_bag(tmp_path / 'bag_2') as bag:
        assert not bag.truncated


def test_qos_types_and_late_topics(node, recorder, tmp_path):
    """Best effort, latched and late publishers, and types that nobody has told of."""
    snapshot = node.create_publisher(DiagnosticArray, 'estimator/snapshot', LATCHED)
    snapshot.publish(DiagnosticArray(status=[DiagnosticStatus(name='first')]))
    sensor = node.create_publisher(JointState, 'joint_states', BEST_EFFORT)
    recorder_process = recorder(
        ['joint_states', 'estimator/snapshot', 'polygon', 'late', '/diagnostics'])
    wait_matched(sensor, snapshot)
    polygon = node.create_publisher(PolygonStamped, 'polygon', 10)
    late = node.create_publisher(String, 'late', LATCHED)
    late.publish(String(data='before'))
    wait_matched(polygon, late)
    message = PolygonStamped()
    message.header.frame_id = 'here'
    polygon.publish(message)
    publish_at([sensor], 50, 0.5)
    snapshot.publish(DiagnosticArray(status=[DiagnosticStatus(name='second')]))
    time.sleep(1.2)
    errors = stop(recorder_process)
    lost = int(re.search(r'lost (\d+) messages', errors)[1])
    with open_bag(tmp_path / 'bag') as bag:
        assert not bag.truncated
        names = [bag.decode('diagnostic_msgs/msg/DiagnosticArray', raw).status[0].name
                 for *_, raw in bag.messages(['/estimator/snapshot'])]
        assert names == ['first', 'second']
        texts = [bag.decode('std_msgs/msg/String', raw).data
                 for *_, raw in bag.messages(['/late'])]
        assert texts == ['before']
        (raw,) = [raw for *_, raw in bag.messages(['/polygon'])]
        assert bag.decode('geometry_msgs/msg/PolygonStamped', raw).header.frame_id == 'here'
        assert 0 < bag.topics['/joint_states'][1] <= 25 - lost  # best effort
        own = [bag.decode('diagnostic_msgs/msg/DiagnosticArray', raw).status[0]
               for *_, raw in bag.messages(['/diagnostics'])][-1]
        assert (own.name, own.hardware_id) == ('recorder: recording', 'gearbox')
        assert own.level == (1 if lost else 0)
    info = (tmp_path / 'bag' / 'metadata.yaml').read_text()
    assert 'best_effort' in info and 'transient_local' in info and 'recorder.topics' in info


def test_losses_are_counted(node, recorder, tmp_path):
    publisher = node.create_publisher(JointState, 'joint_states', 2000)
    process = recorder(queue_depth=5)
    wait_matched(publisher)
    time.sleep(0.5)
    publish_at([publisher], 100, 0.3)
    process.send_signal(signal.SIGSTOP)  # a stalled machine
    publish_at([publisher], 2000, 0.1)
    process.send_signal(signal.SIGCONT)
    publish_at([publisher], 100, 1.0)  # only later messages show a loss
    assert publisher.wait_for_all_acked(Duration(seconds=120))
    errors = stop(process, signal.SIGTERM)
    with open_bag(tmp_path / 'bag') as bag:
        missing = 330 - bag.topics['/joint_states'][1]
    assert missing > 0 and f'lost {missing} messages' in errors


def test_a_full_disk_is_told_and_recording_goes_on_with_room(graph, node, recorder, tmp_path):
    """The limit of the system on the size of files, as a quota sets it, and lifted again."""
    publisher = node.create_publisher(JointState, 'joint_states', 1000)
    told = []
    node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda m: told.append(m.status[0]), 10)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    process = recorder(compression='none')
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (60_000, limits[1]))
    wait_matched(publisher)

    def until(level):
        told.clear()
        graph.until(lambda: told and told[-1].level == level, 'the level')

    publish_at([publisher], 1000, 1)
    until(DiagnosticStatus.ERROR)
    assert 'cannot write: File too large' in told[-1].message
    assert process.poll() is None
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, limits)
    until(DiagnosticStatus.WARN)
    assert told[-1].message == 'messages were lost'
    publish_at([publisher], 1000, 0.5)
    assert publisher.wait_for_all_acked(Duration(seconds=120))
    errors = stop(process)
    assert errors.count('recording has stopped') == errors.count('recording goes on in') == 1
    with open_bag(tmp_path / 'bag') as bag:
        first = bag.joint_states('/joint_states', ['motor']).stamp_ns
        assert bag.truncated and len(first) > 100
        np.testing.assert_array_equal(first, np.arange(len(first)))
    with open_bag(tmp_path / 'bag_2') as bag:
        second = bag.joint_states('/joint_states', ['motor']).stamp_ns
        assert not bag.truncated
        np.testing.assert_array_equal(second, np.arange(500))
    written, dropped = len(first) + len(second), 1500 - len(first) - len(second)
    assert f'recorded {written} messages' in errors and f'not written {dropped}' in errors


def test_bad_input_is_one_line(tmp_path):
    (tmp_path / 'bag').mkdir()
    new = f'output:={tmp_path / "new"}'
    said = {
        (f'output:={tmp_path / "bag"}',): 'bag: exists already',
        (new, 'compression:=rar'): "'rar', expected one",
        (new, 'topics:=[a b]'): "'a b' not a topic name", (new, 'queue_depth:=0'): 'queue_depth'}
    runs = refusals('recorder_node', [
        [word for parameter in parameters for word in ('-p', parameter)] for parameters in said],
        tmp_path)
    for (code, lines), words in zip(runs, said.values()):
        assert code == 2 and len(lines) == 1 and words in lines[0], lines
    assert not (tmp_path / 'new').exists()


def test_two_interrupts_end_well(node, recorder, tmp_path):
    """A terminal and ``ros2 launch`` both send SIGINT; the last messages are in the bag."""
    publisher = node.create_publisher(JointState, 'joint_states', 1000)
    process = recorder()
    wait_matched(publisher)
    publish_at([publisher], 500, 0.5)
    assert publisher.wait_for_all_acked(Duration(seconds=120))
    process.send_signal(signal.SIGINT)
    time.sleep(0.02)
    stop(process)
    with open_bag(tmp_path / 'bag') as bag:
        assert not bag.truncated and bag.topics['/joint_states'][1] == 250


def test_definitions_from_classes_are_the_real_ones():
    store = get_typestore(Stores.ROS2_JAZZY)
    for msgtype in (
            'geometry_msgs/msg/PolygonStamped', 'sensor_msgs/msg/BatteryState',
            'rcl_interfaces/msg/ParameterEvent', 'geometry_msgs/msg/PoseWithCovariance',
            'diagnostic_msgs/msg/DiagnosticStatus', 'sensor_msgs/msg/Image',
            'shape_msgs/msg/SolidPrimitive'):
        types = get_types_from_msg(message_definition(msgtype), msgtype)
        for name, (_, fields) in types.items():
            assert fields == store.fielddefs[name][1], (msgtype, name)


def test_first_message_comes_with_the_signal(recorder, node, tmp_path):
    """What arrives while the recorder ends is in a whole bag, with its topic."""
    process = recorder()
    publisher = node.create_publisher(JointState, 'joint_states', 100)
    wait_matched(publisher)
    time.sleep(0.5)
    process.send_signal(signal.SIGSTOP)
    publisher.publish(JointState(name=['motor']))
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGCONT)
    stop(process)
    with open_bag(tmp_path / 'bag') as bag:
        assert not bag.truncated
