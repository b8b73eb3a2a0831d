# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""From a healthy gearbox to the name of what changed in it, live: topic, diagnostics, restart."""
import json
import os

import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from harness import RELIABLE  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from test_change_naming import child_of, gone  # noqa: E402

pytestmark = [pytest.mark.ros, pytest.mark.system]
SETTINGS = {'arm_load': 'none', 'drift_window': 5.0, 'angle_bin': 0.0, 'speed_bin': 1.0,
            'load_bin': 1.0, 'r_std_motor': 0.002, 'r_std_arm': 0.002, 'use_sim_time': True,
            **RELIABLE}


def test_a_wider_gap_is_named_after_a_restart_and_nothing_before(graph, tmp_path):
    """Two things at once: the estimator is restarted, and a child is running when it ends."""
    told, named = [], []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', told.append, 10)
    graph.node.create_subscription(String, 'estimator/diagnosis', named.append, QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))

    def diagnosis():
        found = [s for array in told[-3:] for s in array.status
                 if s.name == 'estimator: diagnosis']
        return (found[-1], {v.key: v.value for v in found[-1].values}) if found else (None, {})

    def start():
        told.clear()
        return graph.start('estimator_node', drift_state_file=tmp_path / 'state.json', **SETTINGS)
    estimator = start()
    graph.until(lambda: told, 'the estimator')
    graph.start('plant_node', rate=250.0, speed=2.0, measurement_noise='[0.002, 0.002]',
                process_noise='[0.0, 0.0, 0.02, 0.02]')
    graph.until(lambda: 'baseline_recording' in diagnosis()[1], 'the baseline recording')
    status, values = diagnosis()
    healthy = values['baseline_recording']
    assert (ord(status.level), status.message) == (0, 'no alert, nothing to name')
    model, = (s for s in told[-1].status if s.name == 'estimator: model')
    values = {v.key: v.value for v in model.values}
    assert values['holds'] == '1' and values['since'] <= healthy
    graph.stop(estimator)
    estimator = start()
    graph.until(lambda: diagnosis()[1].get('baseline_recording') == healthy, 'the recording again')
    assert not named
    graph.set('plant', fault_gap=1.2)
    graph.until(lambda: diagnosis()[1].get('alert'), 'the alert')
    child = child_of(estimator.pid)
    graph.stop(estimator)
    assert gone(child) and not named
    estimator = start()
    graph.until(lambda: named, 'the name')
    verdict = json.loads(named[0].data)
    finding, = verdict['findings']
    value, = finding['values']
    assert (finding['effect'], value['name']) == ('backlash_gap', 'b')
    assert value['relative'] == pytest.approx(0.2, abs=0.02)
    assert verdict['model_held'] and not verdict['model_holds']
    graph.until(lambda: 'backlash_gap' in diagnosis()[0].message, 'the words')
    status, values = diagnosis()
    assert ord(status.level) == 1 and values['effect'] == 'backlash_gap'
    assert values['model_holds'] == '0' and float(values['cpu_s']) < 300.0
    graph.stop(estimator)
    assert os.path.exists(tmp_path / 'state.json.recording')
