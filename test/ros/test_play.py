# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Playing a bag as a real process: what is published, when, /clock and the end."""
from functools import partial
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from processes import put_down  # noqa: E402, I100, I202
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from gearbox_monitor.cli.main import main  # noqa: E402
from gearbox_monitor.recordings.cdr import encode_joint_states  # noqa: E402
from gearbox_monitor.recordings.read import JOINT_STATE  # noqa: E402
from gearbox_monitor.recordings.write import BagWriter  # noqa: E402

pytestmark = pytest.mark.ros
ROOT = Path(__file__).parents[2]
DOMAIN = 1 + os.getpid() % 100
BASE_NS = 1_700_000_000_000_000_000
STEP_NS = 1_000_000
COUNT = 800
TOPICS = ('/joint_states', '/plant/transmission_state', '/transmission_state')


@pytest.fixture
def bag(tmp_path):
    """Return (path, {topic: raw messages}): inputs, truth and one output of the estimator."""
    stamps = BASE_NS + STEP_NS * np.arange(COUNT)
    values = np.random.default_rng(0).normal(size=(COUNT, 2))
    raws = {topic: encode_joint_states(stamps, ('motor', 'arm'), position=values + i)
            for i, topic in enumerate(TOPICS)}
    with BagWriter(tmp_path / 'bag') as writer:
        for topic in TOPICS:
            writer.add_topic(topic, JOINT_STATE)
        for k in range(COUNT):
            for topic in TOPICS:
                writer.write(topic, int(stamps[k]), raws[topic][k])
    return tmp_path / 'bag', raws


class Listener:
    """Keeps raw messages of all topics and the times of /clock."""

    def __init__(self, context):
        self.node = rclpy.create_node('listener', context=context)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.raws, self.clock = {topic: [] for topic in TOPICS}, []
        self.published = []  # ns, of each raw message
        for topic in TOPICS:
            self.node.create_subscription(
                JointState, topic, partial(self._on_raw, topic), QoSProfile(depth=10000),
                raw=True)
        self.node.create_subscription(Clock, '/clock', self._on_clock, QoSProfile(depth=10000))

    def _on_raw(self, topic, raw, info):
        self.raws[topic].append(raw)
        self.published.append(info['source_timestamp'])

    def _on_clock(self, message):
        self.clock.append(message.clock.sec * 10**9 + message.clock.nanosec)

    def until(self, condition, timeout=60.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, 'nothing came'
            self.executor.spin_once(timeout_sec=0.05)


@pytest.fixture
def listener(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    listener = Listener(context)
    yield listener
    listener.executor.shutdown()
    listener.node.destroy_node()
    rclpy.shutdown(context=context)


@pytest.fixture
def play(tmp_path):
    started = []

    def start(*arguments):
        env = {**os.environ, 'PYTHONPATH': str(ROOT), 'ROS_DOMAIN_ID': str(DOMAIN),
               'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_LOG_DIR': str(tmp_path)}
        process = subprocess.Popen(
            [sys.executable, '-m', 'gearbox_monitor', 'play', *map(str, arguments)], env=env,
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        started.append(process)
        return process

    yield start
    put_down(started)


def test_publishes_the_inputs_as_recorded(bag, listener, play):
    path, raws = bag
    process = play(path)
    listener.until(lambda: process.poll() is not None)
    assert process.returncode == 0, process.communicate()[1]
    listener.until(lambda: all(len(listener.raws[t]) == COUNT for t in TOPICS[:2]))
    for topic in TOPICS[:2]:
        assert [bytes(raw) for raw in listener.raws[topic]] == list(map(bytes, raws[topic]))
    assert not listener.raws[TOPICS[2]]
    clock = np.array(listener.clock)
    assert len(clock) > 10
    assert (np.diff(clock) > 0).all()
    assert clock[0] >= BASE_NS
    assert (clock < BASE_NS + STEP_NS * COUNT + 10**8).sum() > 10


def test_rate_topics_and_remapping(bag, listener, play):
    path, raws = bag
    process = play(path, '--rate', 0.5, '--topics', 'joint_states', '--no-clock',
                   '--ros-args', '-r', '/joint_states:=/transmission_state')
    received = listener.raws[TOPICS[2]]
    listener.until(lambda: process.poll() is not None and len(received) == COUNT)
    assert process.returncode == 0
    assert list(map(bytes, received)) == list(map(bytes, raws[TOPICS[0]]))
    # The first may be late on a starved machine, the last is never early.
    assert listener.published[-1] - listener.published[0] > 0.75 * (COUNT - 1) * STEP_NS / 0.5
    assert not listener.clock


def test_loop_until_interrupted(bag, listener, play):
    process = play(bag[0], '--loop', '--all', '--rate', 2)
    listener.until(lambda: len(listener.raws[TOPICS[2]]) > COUNT + 50)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 0, errors
    assert 'Traceback' not in errors
    assert (np.diff(listener.clock) < 0).any()


def test_bad_input_is_one_line(bag, tmp_path, capsys):
    with BagWriter(tmp_path / 'empty') as writer:
        writer.add_topic('/other', JOINT_STATE)
    for arguments, words in (
            ([bag[0], '--topics', '/speed'], ['/speed', '/joint_states']),
            ([bag[0], '--rate', '0'], ['--rate', 'expected']),
            ([tmp_path / 'empty'], ['joint_states', '/other'])):
        try:
            code = main(['play', *map(str, arguments)])
        except SystemExit as end:  # of argparse
            code = end.code
        assert code == 2
        errors = capsys.readouterr().err.strip()
        assert '\n' not in errors and all(word in errors for word in words)


def test_says_when_rclpy_is_missing(bag):
    code = ('import sys; sys.modules["rclpy"] = None; from gearbox_monitor.cli.main import main; '
            f'sys.exit(main(["play", {str(bag[0])!r}]))')
    done = subprocess.run([sys.executable, '-c', code], cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert 'rclpy: not installed' in done.stderr
