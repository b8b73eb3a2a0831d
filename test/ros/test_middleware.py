# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A node starts on a machine where another was killed while it made its shared memory."""
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import pytest

from gearbox_monitor.ros.middleware import MEMORY, own_domain, remove_cut_ports

ROOT = Path(__file__).parents[2]


def test_only_cut_ports_are_removed(tmp_path):
    for name, size, age in (('fastrtps_port1', 0, 60), ('fastrtps_port2', 52400, 60),
                            ('fastrtps_port3', 0, 0), ('fastrtps_port4_el', 0, 60),
                            ('sem.fastrtps_port1_mutex', 0, 60), ('other', 0, 60)):
        (tmp_path / name).write_bytes(bytes(size))
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    assert remove_cut_ports(tmp_path) == ['fastrtps_port1']
    assert len(list(tmp_path.iterdir())) == 5
    assert remove_cut_ports(tmp_path / 'missing') == []


@pytest.mark.ros
@pytest.mark.skipif(not MEMORY.exists(), reason='no /dev/shm')
def test_a_node_starts_beside_a_cut_port(tmp_path):
    pytest.importorskip('rclpy')
    with own_domain() as domain:
        port = MEMORY / f'fastrtps_port{7400 + 250 * domain + 11}'  # of the first participant
        port.write_bytes(b'')
        os.utime(port, (time.time() - 60,) * 2)
        process = subprocess.Popen(
            [sys.executable, '-m', 'gearbox_monitor.ros.plant_node'], cwd=tmp_path, text=True,
            stderr=subprocess.PIPE,
            env={**os.environ, 'PYTHONPATH': str(ROOT), 'ROS_DOMAIN_ID': str(domain)})
        try:
            assert port.name in process.stderr.readline()  # it tells what it removed,
            assert 'plant' in process.stderr.readline()  # and runs
        finally:
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=60)
            port.unlink(missing_ok=True)
