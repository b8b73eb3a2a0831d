# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot: the worst joint first, its backlash as a line, in a browser."""
import re

import numpy as np
from pages import overflowing
import pytest
from test_live_page import gearbox, judged

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.live_page import LivePage
from gearbox_monitor.report.recording_page import robot_page
from gearbox_monitor.report.timeline import (
    recorded_timeline, RecordingFacts, State, Timeline, WindowBacklash)
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import WorkingArm

T0, SECOND = 1_700_000_000_000_000_000, 1_000_000_000
GROWN = 'backlash has grown by 12 %'


def timeline(level=0, growth=0.0, windows=30, separable=True):
    """Return what a recording of 300 s showed of a joint whose backlash grows by a share."""
    joint, stamps = Timeline(60.0), T0 + np.arange(300) * SECOND
    joint.add_inputs(stamps, np.zeros(300))
    torque = 5.0 * np.sin(np.arange(300.0))
    nothing = np.full(300, np.nan)
    joint.torque.add(joint.seconds(stamps), torque, np.full(300, 0.1), nothing)
    for k in range(windows):
        gap = 0.02 * (1.0 + growth * k / windows)
        joint.add_window(T0 + 10 * k * SECOND, WindowBacklash(
            0.0, gap, 1e-4, 1.5 * gap, separable))
    if windows:
        for t, now in ((0, 0), (250, level), (299, level)):
            joint.add_states(T0 + t * SECOND, (
                State(0, 'model', 'fits'), State(now, 'backlash', GROWN if now else 'no growth')))
    joint.finish()
    return joint, RecordingFacts(
        DriveModel(), EstimatorParameters(), notes=['a note'])


def page(**joints):
    return robot_page(joints, {name: f'r.{name}.html' for name in joints}, 'r',
                      {name: f'r --topic {name}' for name in joints})


def rows(html):
    """Return {joint: cells without tags} in the order of the page."""
    table = html[html.index('<tbody>'):html.index('</tbody>')]
    cells = [[re.sub(r'<[^>]+>', '', cell).strip() for cell in re.findall(r'<td.*?</td>', row)]
             for row in table.split('<tr>')[1:]]
    return {row[0]: row[1:] for row in cells}


def test_the_worst_joint_comes_first():
    html, headline = page(base=timeline(), elbow=timeline(2, 0.12), wrist=timeline(windows=0),
                          hand=timeline(1, 0.05, separable=False))
    assert headline == 'elbow: Backlash has grown by 12 % (1 more joint).'
    found = rows(html)
    assert list(found) == ['elbow', 'hand', 'base', 'wrist']
    assert found['elbow'][:3] == ['ERROR', '-5 to 5', '0.0223 ± 0.0002']
    assert found['hand'][2] == '0.0315 (lost motion)' and found['base'][4] == '100 %'
    assert found['wrist'][:1] + found['wrist'][2:5] == [
        '-', 'not measured', '-', 'not evaluated']
    assert ('elbow: Test the gearbox against its specification: gearbox_monitor accept r '
            '<span class="whole">--topic</span> elbow') in html
    assert html.count('A note.') == 1 and 'href="r.elbow.html"' in html
    # The line rises from the bottom to the top of its box; one that stays lies in the middle.
    lines = [[tuple(map(float, point.split(','))) for point in line[1:].split('L')]
             for line in re.findall(r'class="spark".*?d="([^"]+)"', html)]
    grown, same = lines[0], lines[2]
    assert grown[0] == (2.0, 22.0) and grown[-1] == (118.0, 2.0) and len(grown) == 30
    assert {y for _, y in same} == {12.0}


def test_wear_comes_before_a_lack_of_trust_of_the_same_level():
    doubtful, missing = timeline(), State(2, 'model', 'misses something')
    doubtful[0].add_states(T0 + 300 * SECOND, (missing,))
    doubtful[0].add_states(T0 + 900 * SECOND, (missing,))
    doubtful[0].finish()
    html, headline = page(base=doubtful, elbow=timeline(2, 0.12))
    found = rows(html)
    assert [row[0] for row in found.values()] == ['ERROR', 'ERROR']
    assert list(found) == ['elbow', 'base'] and headline.startswith('elbow: Backlash has grown')


def test_where_nothing_is_raised():
    assert page(base=timeline(), elbow=timeline())[1] == 'Nothing is raised.'
    nothing = page(base=timeline(windows=0), elbow=timeline(windows=0))
    assert nothing[1].startswith('Nothing was evaluated') and 'badge' not in nothing[0][
        nothing[0].index('<main>'):]


def test_live_page_has_the_rows_of_several_joints():
    base, elbow = gearbox('base'), judged(gearbox('elbow'), 1)
    joints = LivePage().parts([base, elbow], '/estimator', 700.0)
    assert list(joints)[:3] == ['watch', 'summary', 'joints']
    found = rows(joints['joints'])
    assert list(found) == ['elbow', 'base'] and found['elbow'][0] == 'WARN'
    assert found['elbow'][5] == 'model: so it is' and found['base'][0] == '-'
    assert found['base'][1] == '-5 to 5' and 'class="spark"' in joints['joints']
    assert not LivePage().parts([elbow], '/estimator', 700.0)['joints'].strip()


def test_a_replayed_page_has_the_load_by_the_description(tmp_path):
    file = str(config_path('arm6.urdf'))
    robot = load_robot(file)
    arm = WorkingArm(robot, 2e-3, 1)
    run = arm.run(1000)
    stamps = T0 + np.round(run.true.t * SECOND).astype(np.int64)
    names = [*(f'motor{k + 1}' for k in range(6)), *robot.joints]
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for stamp, message in zip(stamps, encode_joint_states(
                stamps, names, np.hstack([run.motor, run.arm]),
                effort=np.hstack([run.true.u, np.full((1000, 6), np.nan)]))):
            writer.write('/joint_states', int(stamp), message)
    parameters = {**arm_plant.parameters_of(2), 'robot_description': file}
    with open_bag(tmp_path / 'bag') as reader:
        timeline, facts = recorded_timeline(reader, 'joint_states', arm.drives[2], parameters)
    assert facts.notes == [] and timeline.samples == 1000
    low, high, _ = timeline.torque.of(0)
    monitor = Monitor(arm.drives[2], parameters, robot=robot)
    tau_k = monitor.run(Samples(stamps, np.column_stack([run.true.u[:, 2], np.full(1000, np.nan)]),
                                np.column_stack([run.motor[:, 2], run.arm[:, 2]]), run.arm)).tau_k
    assert (np.nanmin(low), np.nanmax(high)) == (tau_k.min(), tau_k.max())


@pytest.mark.parametrize('width', [1400, 390])
def test_page_in_a_browser(browser, tmp_path, width):
    file = tmp_path / 'r.html'
    file.write_text(page(base=timeline(), shoulder_lift_joint=timeline(2, 0.12),
                         wrist=timeline(windows=0))[0], encoding='utf-8')
    assert not overflowing(browser, file.as_uri(), width)
