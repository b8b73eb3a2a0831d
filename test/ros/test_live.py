# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""`gearbox_monitor live` beside a real estimator node: its events over HTTP, its end."""
from array import array
import http.client
import json
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import (  # noqa: E402, I100, I202
    DiagnosticArray)
from drives import driven  # noqa: E402
from harness import RELIABLE  # noqa: E402
from processes import DOMAIN, put_down, ROOT  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from gearbox_monitor.cli.main import main  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 2_000_000  # 500 Hz
NAMES = ('base', 'elbow')
RELIABLE_QOS = {key.rpartition('.')[2]: value for key, value in RELIABLE.items()}
LIVE_TOPIC = 'qos_overrides./transmission_state_smoothed.subscription'


def live(*options):
    """Start the command; return the process."""
    return subprocess.Popen(
        [sys.executable, '-m', 'gearbox_monitor', 'live', *options],
        env={**os.environ, 'PYTHONPATH': str(ROOT), 'ROS_DOMAIN_ID': str(DOMAIN)}, cwd=ROOT,
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def send(publisher, end):
    """Publish both gearboxes, about as fast as real time, until `end` is set or 120 s are sent."""
    drives = [driven(DriveModel(), 120.0, seed=k, dt=DT * 1e-9) for k in range(2)]
    begin = time.monotonic()
    for k, t in enumerate(drives[0].t.tolist()):
        message = JointState(name=[f'{name}_{j}' for name in NAMES for j in ('motor', 'arm')])
        message.header.stamp = to_time(T0 + k * DT)
        message.position = array('d', [v for drive in drives for v in drive.y[k]])
        message.effort = array('d', [v for drive in drives for v in (drive.u[k], np.nan)])
        publisher.publish(message)
        if end.wait(max(begin + t - time.monotonic(), 0.0)):
            return


def test_events_of_a_robot(graph, tmp_path, capsys):
    file = tmp_path / 'robot.yaml'
    file.write_text(json.dumps({'estimator': {'ros__parameters': {
        'gearboxes': list(NAMES), 'arm_load': 'none', **{
            name: {'motor_joint': f'{name}_motor', 'arm_joint': f'{name}_arm'} for name in NAMES},
        'qos_overrides': {
            '/joint_states': {'subscription': RELIABLE_QOS},
            '/transmission_state_smoothed': {'publisher': RELIABLE_QOS}}}}}))
    # Lossless: a starved machine may be late.
    process = live('--port', '0', '--ros-args', *(word for key, value in RELIABLE_QOS.items()
                   for word in ('-p', f'{LIVE_TOPIC}.{key}:={value}')))
    sent = threading.Event()
    try:
        address = process.stdout.readline().split()[0]
        assert address.startswith('http://127.0.0.1:'), process.communicate(timeout=10)
        assert main(['live', '--port', address.strip('/').rpartition(':')[2]]) == 2
        errors = capsys.readouterr().err
        assert len(errors.splitlines()) == 1
        assert errors.startswith('gearbox_monitor live: 127.0.0.1:'), errors
        connection = http.client.HTTPConnection(address.split('/')[2], timeout=60)
        connection.request('GET', '/events')
        events = connection.getresponse()
        estimator = graph.start('estimator_node', '--params-file', str(file))
        publisher = graph.node.create_publisher(JointState, 'joint_states', 10_000)
        heard = set()
        graph.node.create_subscription(
            DiagnosticArray, '/diagnostics',
            lambda message: heard.update(status.name for status in message.status), 50)
        graph.until(lambda: heard and publisher.get_subscription_count() and
                    graph.node.count_subscribers('/transmission_state_smoothed'), 'matching')
        sender = threading.Thread(target=send, args=(publisher, sent))
        sender.start()
        page, end = {}, time.monotonic() + 240.0

        def read(condition):
            """Take events until condition() is true."""
            while not condition():
                assert time.monotonic() < end, page
                line = events.readline()
                if line.startswith(b'data: '):
                    page.update(json.loads(line[6:]))
        # Slices of 2 s that have a line: more than one, so time has colours.
        read(lambda: all(page.get(f'motion{k}', '').count('class="mean" d="M') >= 2
                         and 'OK' in page[f'condition{k}'] for k in range(2)))
        assert list(page) == [
            'watch', 'summary', 'joints', 'motion0', 'condition0', 'motion1', 'condition1']
        assert all(f'<h2>{name}</h2>' in page['motion0'] + page['motion1'] for name in NAMES)
        for k in range(2):
            assert '<dt>samples per second</dt><dd>500</dd>' in page[f'motion{k}']
            assert 'prediction error: ' in page[f'condition{k}']
        sent.set()
        sender.join()
        graph.stop(estimator)
        read(lambda: 'silent for' in page['summary'])
        connection.close()  # while it is sent to
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=30)
        assert process.returncode == 0 and errors == '', errors
    finally:
        sent.set()
        put_down([process])
