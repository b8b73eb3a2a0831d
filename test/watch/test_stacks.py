# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Joint states as stacks publish them: the process of the live node and a bag give one answer."""
import json

from arm_at_work import Arm, messages, NAMES, RATE, START, urdf
import numpy as np
import pytest
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.files.knowledge_file import watch_bytes
from gearbox_monitor.library.robot import watch_robot
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import JOINT_STATE
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.ros.watch_child import DESCRIPTION, ROWS, Watching
from gearbox_monitor.watch.record import DATED, SECOND

STRING, NONE = 'std_msgs/msg/String', np.array([])
FINGER = """<link name="{0}"><inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5"
izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="{0}" type="prismatic"><parent
link="link3"/><child link="{0}"/><origin xyz="0 0.02 0.35"/><axis xyz="0 1 0"/><limit lower="0"
upper="0.04" effort="40" velocity="1"/>{1}</joint>"""
WHEEL = """<link name="wheel"/><joint name="wheel" type="continuous"><parent link="base"/><child
link="wheel"/></joint>"""


def stream(blocks=3, begin=START):
    """Return rows (time of arrival, stamp, names, position, velocity, effort) of an arm."""
    return [(START + k * SECOND // 50, begin - START + stamp, NAMES, q, v, effort)
            for k, (stamp, q, v, effort) in enumerate(messages(Arm(), blocks)[::RATE // 50])]


def with_a_gripper():
    """Fingers of which one mimics the other, a wheel, in messages of their own."""
    rows = stream()
    rows += [(t + 3_000_000, stamp + 3_000_000, ['finger', 'wheel', 'camera'],
              np.array([0.02 + 0.01 * np.sin(k / 50), k / 10.0, 0.0]), NONE,
              np.array([np.nan, np.cos(k), np.nan])) for k, (t, stamp, *_) in enumerate(rows)]
    text = urdf().replace('</robot>', FINGER.format('finger', '') + FINGER.format(
        'other', '<mimic joint="finger"/>') + WHEEL + '</robot>')
    return rows, [(0, text)]


def of_two_arms():
    """Two prefixes in one description; each arm has a publisher with stamps of its own."""
    rows, text = [], '<robot name="two"><link name="world"/>'
    for k, side in enumerate(('left_', 'right_')):
        rows += [(t + k, stamp + 4_000_000 * k, [side + n for n in names], q, v, effort)
                 for t, stamp, names, q, v, effort in stream()]
        own = urdf().removeprefix('<robot name="arm">').removesuffix('</robot>')
        for word in ('link', 'joint', 'base'):
            own = own.replace(f'"{word}', f'"{side}{word}')
        text += (f'{own}<joint name="{side}mount" type="fixed"><parent link="world"/><child '
                 f'link="{side}base"/><origin xyz="0 {k} 0.5"/></joint>')
    return rows, [(0, text + '</robot>')]


def described_late():
    """Describe the arm after half a minute, and replace that."""
    return stream(), [(START + 30 * SECOND, urdf()), (START + 45 * SECOND, urdf([2.0, 2.0, 2.0]))]


def all_together():
    """Two arms and a gripper, in any order, by a clock that is set back to 0, described late."""
    (rows, ((_, text),)), (hand, _) = of_two_arms(), with_a_gripper()
    rng, out = np.random.default_rng(2), []
    for t, stamp, names, q, v, effort in rows + [row for row in hand if 'finger' in row[2]]:
        order = rng.permutation(len(names))
        stamp = (stamp - START) % (40 * SECOND)
        out.append((t, stamp, [names[i] for i in order], q[order], NONE, effort[order]))
    text = text.replace('</robot>', FINGER.replace('link3', 'left_link3').format(
        'finger', '') + FINGER.replace('link3', 'left_link3').format(
        'other', '<mimic joint="finger"/>') + WHEEL.replace('"base"', '"left_base"') + '</robot>')
    return out, [(START + 5 * SECOND, text)]


def both_doors(folder, rows, described):
    """Return the watch of the live node's process, and that of a bag of the same messages."""
    items = sorted([*((t, DESCRIPTION, text) for t, text in described),
                    *((t, ROWS, row) for t, *row in rows)], key=lambda item: item[0])
    store, child = get_typestore(Stores.ROS2_JAZZY), Watching(folder / 'state')
    with BagWriter(folder / 'bag') as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        writer.add_topic('/robot_description', STRING)
        for t, order, content in items:
            if order == ROWS:
                stamp, names, q, v, effort = content
                raw, = encode_joint_states(np.array([stamp]), names, q[None], **{
                    key: x[None] for key, x in (('velocity', v), ('effort', effort)) if len(x)})
                content = [(stamp, names, q.tolist(), v.tolist(), effort.tolist())]
            else:
                raw = bytes(store.serialize_cdr(store.types[STRING](content), STRING))
            writer.write('/joint_states' if order == ROWS else '/robot_description', t, raw)
            child.take(*json.loads(json.dumps((order, content))))
    child.blocks(child.cutter.end())
    assert not child.cutter.dropped
    return child.watch, watch_robot(folder / 'bag')


@pytest.mark.parametrize('made', [described_late, all_together])
def test_live_and_from_a_bag_are_one(tmp_path, made):
    rows, described = made()
    live, offline = both_doors(tmp_path, rows, described)
    assert watch_bytes(live) == watch_bytes(offline)
    known = {j.name: (j.has, j.why) for j in live.joints}
    if made is described_late:
        assert live.description == described[1][1] and len(live.kept) == 1
        return
    assert len(known) == 8 and live.others == ('camera',)
    assert set(live.locked) == {'finger', 'wheel'}
    assert known.pop('finger') == (('position',), 'other joints mimic it')
    assert known.pop('wheel') == (('position', 'effort'), 'moves no mass in the description')
    assert set(known.values()) == {(('position', 'effort'), 'learns')}
    assert len(live.kept) == 3 and live.stamp_ns < DATED and live.phase == 'learn'
