# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""From a drive with an effect to its name: diagnostics, ~/keep_recording, the command it gives."""
import json
import resource
import shlex

import numpy as np
import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from harness import RELIABLE  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.cli.main import main  # noqa: E402
from gearbox_monitor.files.baselines import health_text, STATE, write_whole  # noqa: E402
from gearbox_monitor.health.backlash.features import Backlash  # noqa: E402
from gearbox_monitor.health.health_record import HealthSettings, Window  # noqa: E402
from gearbox_monitor.health.judgement import Health, judge  # noqa: E402
from gearbox_monitor.parameters import EstimatorParameters  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402

pytestmark = pytest.mark.ros
LIMITS = resource.getrlimit(resource.RLIMIT_FSIZE)


def healthy(path):
    """Return the new file `path` of drift's state: a drive with half the gap."""
    health = Health(HealthSettings.of(
        EstimatorParameters(angle_bin=0.0, speed_bin=1.0, load_bin=1.0), DriveModel()))
    random = np.random.default_rng(0)
    for k in range(40):
        health = judge(health, Window(Backlash(
            10**9 * (1 + k), 0.1 + 1e-3 * random.standard_normal(), 1e-3, 25.0, 0.1, angle=0.0,
            speed=18.0, load=3.6, flank=0.4)))
    write_whole(path, health_text(STATE, health, 'gearbox', recording_ns=0))
    return path


@pytest.mark.system
def test_a_drive_with_an_effect_is_told_kept_and_named(graph, tmp_path):
    folder, told, efforts = tmp_path / 'kept', [], []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', told.append, 10)
    graph.node.create_subscription(JointState, 'joint_states', efforts.append, 10000)
    estimator = graph.start('estimator_node', arm_load='none', model_gap_after=5.0,
                            keep_folder=folder, **RELIABLE)
    asked = Trigger.Request()
    effect = tmp_path / 'effect.yaml'
    effect.write_text('effects: [{id: torque_offset, u0: 0.6}]')
    graph.start('plant_node', rate=500.0, model=effect,
                process_noise='[0.0, 0.0, 0.02, 0.02]')

    def status(name):
        return next((s for s in told[-1].status if s.name == f'estimator: {name}'), None)

    graph.until(lambda: told and 'model mismatch' in status('model').message, 'the notice')
    values = {v.key: v.value for v in status('model').values}
    assert values['command'] == 'ros2 service call /estimator/keep_recording std_srvs/srv/Trigger'
    assert float(values['systematic_s']) > float(values['systematic_s_threshold']) == 2.5
    graph.until(lambda: len(efforts) > 500 * 15, 'a recording that is long enough')
    client = graph.node.create_client(Trigger, 'estimator/keep_recording')
    graph.until(client.service_is_ready, 'service')
    both = [client.call_async(asked) for _ in range(2)]
    graph.until(lambda: all(future.done() for future in both), 'the answers')
    good, = (f.result() for f in both if f.result().success)
    refused, = (f.result() for f in both if not f.result().success)
    assert 'is being written' in refused.message
    kept, = folder.iterdir()
    with open_bag(kept / 'bag') as bag:
        states = bag.joint_states('/joint_states', ('motor', 'arm'))
    # What both saw is the same; either may have joined the plant later than the other.
    sent = {m.header.stamp.sec * 10**9 + m.header.stamp.nanosec: m.effort[0] for m in efforts}
    both_saw = [k for k, stamp in enumerate(states.stamp_ns) if stamp in sent]
    assert len(both_saw) > 5000
    assert all(states.effort[k, 0] == sent[states.stamp_ns[k]] for k in both_saw)
    # The estimates go on meanwhile.
    count = len(efforts)
    graph.until(lambda: len(efforts) > count + 1000, 'more samples')
    values = {v.key: v.value for v in status('input').values}
    assert values['messages_lost'] == '0' and 'no samples' not in status('input').message

    words = shlex.split(good.message.split(' s kept: ')[1])
    assert words[:2] == ['gearbox_monitor', 'diagnose']
    graph.stop(estimator)
    code = main([*words[1:], '--only', 'torque_offset', 'load_torque',
                 '--json', str(tmp_path / 'verdict.json')])
    verdict = json.loads((tmp_path / 'verdict.json').read_text())
    assert code == 1 and verdict['effect'] == 'torque_offset', verdict
    assert verdict['params']['torque_offset']['u0'] == pytest.approx(0.6, abs=0.1)


def test_an_alert_keeps_its_recording_once_the_disk_has_room(graph, tmp_path):
    """The gap is larger than the saved baseline, and at that moment no file may be written."""
    folder, told = tmp_path / 'kept', []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', told.append, 10)
    estimator = graph.start('estimator_node', arm_load='none', keep_folder=folder,
                            drift_window=2.0, drift_state_file=healthy(tmp_path / 'state.json'),
                            angle_bin=0.0, speed_bin=1.0, load_bin=1.0, temperature_bin=0.0,
                            **RELIABLE)
    answer = graph.call(Trigger, 'estimator/keep_recording', Trigger.Request())
    assert not answer.success and 'no samples yet on /joint_states' in answer.message
    resource.prlimit(estimator.pid, resource.RLIMIT_FSIZE, (10_000, LIMITS[1]))
    graph.start('plant_node', rate=125.0, process_noise='[0.0, 0.0, 0.02, 0.02]')

    def recording():
        status = next((s for s in told[-1].status if s.name == 'estimator: backlash'), None)
        return {v.key: v.value for v in status.values}.get('recording', 'no alert')

    graph.until(lambda: told and recording().startswith('failed, tried every 10 s: '), 'a failure')
    assert 'File too large' in recording() and not [*folder.iterdir()]
    answer = graph.call(Trigger, 'estimator/keep_recording', Trigger.Request())
    assert not answer.success and 'still in memory' in answer.message
    resource.prlimit(estimator.pid, resource.RLIMIT_FSIZE, LIMITS)
    graph.until(lambda: ' s kept: ' in recording(), 'a recording')
    by_itself, = folder.iterdir()
    assert ' s after the alert: ' in recording() and str(by_itself / 'bag') in recording()
    with open_bag(by_itself / 'bag') as bag:
        stamps = bag.joint_states('/joint_states', ('motor', 'arm')).stamp_ns
        source = bag.metadata['gearbox_monitor']['source']
    assert len(stamps) > 500 and source.startswith('estimator: backlash: backlash has grown by ')
    errors = graph.stop(estimator)
    assert errors.count('backlash became ERROR: failed') == 1
    assert errors.count('backlash became ERROR: ') == 2
