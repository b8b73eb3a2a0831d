# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The watch of an arm whose torques follow from its equations; no file knows its friction."""
from copy import deepcopy
from dataclasses import replace
from hashlib import sha256
import json
from pathlib import Path
import shutil

from arm_at_work import Arm, AT, BLOCK, MASS, messages, NAMES, PLACE, START, urdf, watched
import numpy as np
from pyarrow import parquet
import pytest
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.robot.knowledge import farther, states_of
from gearbox_monitor.diagnosis.robot.robot_log import checked_log
from gearbox_monitor.diagnosis.robot.rows import rows_of
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.knowledge_file import load_watch, save_watch, watch_bytes
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.library.robot import watch_robot
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import JOINT_STATE
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.watch_words import change_words, watch_data
from gearbox_monitor.robot.chain import inertial
from gearbox_monitor.ros.watch_child import DESCRIPTION, Watching
from gearbox_monitor.watch.features import columns_of, dispersed, Group, groups_of
from gearbox_monitor.watch.fold import begin, learn_again, robot_of, save_baseline, step, tare
from gearbox_monitor.watch.record import (
    Change, Cutter, levels_of, raw_log, ROTOR, SECOND, step_in, WATCH, WEIGHT, with_block)

LEARN, SETTLED = 9, 24  # blocks
LOAD = 1.5


@pytest.fixture(scope='module')
def settled():
    """Return (arm, watch) after it has learnt with a load that came, and compared some blocks."""
    arm = Arm()
    stream = messages(arm, 5)
    arm.load = 0.8
    stream += messages(arm, 4)
    arm.load = 0.0
    watch, events = watched(begin(urdf()), stream + messages(arm, SETTLED - LEARN))
    assert [e.kind for e in events if e.kind != 'payload'] == ['phase', 'phase']
    assert watch.phase == WATCH and watch.level == Level.OK, watch.joints
    return arm, watch


@pytest.fixture
def arm(settled):
    """Return an arm at work where the watch of `settled` ended."""
    out = Arm(seed=8)
    out.number, out.goals, out.at = settled[0].number, settled[0].goals, settled[0].at
    return out


def test_loads_that_come_and_go_are_weighed_and_raise_no_alarm(settled, arm):
    """Nor do other postures, with friction that follows temperature."""
    watch = settled[1]
    for number in range(8):
        arm.load = (0.0, LOAD, 0.7)[number // 2 % 3]
        arm.friction = np.ones(3) * (1.0 - 0.015 * number)
        if number == 4:
            arm.goals = arm.rng.uniform(-1.0, 1.0, (5, 3))
        watch, _ = watched(watch, arm.block())
        held, = watch.payloads
        assert held.link == 'link3' and held.mass_std < 0.1
        assert abs(held.mass - arm.load) < 3.0 * held.mass_std + 0.01
        if arm.load:
            assert np.all(np.abs(held.centre - AT) < 3.0 * np.array(held.centre_std) + 0.01)
            taken = START + (arm.number - 1 - number % 2) * BLOCK * SECOND
            assert held.since_ns == taken
    assert not watch.changes and watch.level == Level.OK


CHANGES = [('friction', 'friction', 1, 1.4, 0.4), ('torque_scale', 'gain', 2, 0.85, -0.15)]


@pytest.mark.parametrize('kind, attribute, joint, factor, size', CHANGES)
def test_a_change_that_lasts_is_raised_at_its_joint_and_ends(
        settled, arm, kind, attribute, joint, factor, size):
    begun = arm.number
    getattr(arm, attribute)[joint] = factor
    watch, events = watched(settled[1], messages(arm, 6))
    raised, = (e for e in events if e.kind == 'raised')
    change, = watch.standing
    assert (change.kind, change.place, raised.place) == (kind, NAMES[joint], NAMES[joint])
    assert abs(change.size - size) < 3.0 * change.std + 0.002 and change.std < 0.06
    assert change.since_ns == START + begun * BLOCK * SECOND
    assert [j.level for j in watch.joints] == [
        Level.WARN if k == joint else Level.OK for k in range(3)] and watch.level == Level.WARN
    assert not save_baseline(watch).standing
    getattr(arm, attribute)[joint] = 1.0
    watch, events = watched(watch, messages(arm, 6))
    assert [e.place for e in events if e.kind == 'over'] == [NAMES[joint]] and not watch.standing


def test_a_weight_near_the_end_is_no_load(settled, arm):
    """A load of another centre explains nearly as much of it; a true load is one all the same."""
    arm.added = 0.6
    watch, events = watched(settled[1], messages(arm, 5))
    change, = watch.standing
    assert (change.kind, change.place) == (WEIGHT, NAMES[1]) and change.size > 0.1
    assert not [e for e in events if e.kind == 'payload']
    arm.load = LOAD
    watch, _ = watched(watch, messages(arm, 4))
    held, = watch.payloads
    assert abs(held.mass - LOAD) < 3.0 * held.mass_std + 0.01 and watch.standing == (
        replace(change, size=watch.standing[0].size, std=watch.standing[0].std),)


def test_a_rotor_is_no_weight_of_a_link_that_could_do_the_same(settled, arm):
    """Of ten numbers of a body one, its inertia about the axis, is the rotor's."""
    arm.rotor[1] = 0.3
    watch, _ = watched(settled[1], messages(arm, 5))
    change, = watch.standing
    assert (change.kind, change.place) == (ROTOR, NAMES[1])
    own = np.mean([arm.chain.inertia(arm.rng.uniform(-1.0, 1.0, (50, 3)))[:, 1, 1]])
    assert abs(change.size - 0.3 / own) < 0.2 * change.size


def test_the_columns_of_a_weight_make_all_of_its_torque():
    """Without its inertia the next link, at whose axis a mass has one, would explain it better."""
    rows = []
    for added in (0.0, 2.0):
        arm, cutter = Arm(), Cutter()
        arm.added, arm.noise = added, 0.0
        for stamp, q, v, effort in arm.block():
            assert not cutter.take(stamp, NAMES, q, v, effort)
        log = checked_log(raw_log(cutter.end(), NAMES, 'one block'), NAMES)
        rows.append(rows_of(log, robot_of(urdf(), ())[0]))
    columns = columns_of(rows[0], Group(WEIGHT, 'joint2', 1, 10), (), 1.0)
    theta = inertial(2.0, PLACE, np.zeros((3, 3)))
    for j, x in columns.items():
        torque = rows[1].target[j] - rows[0].target[j]
        error = np.abs(x @ theta - torque).max()
        assert error < 0.02 * np.abs(torque).max()
        assert j == 0 or error < 0.2 * np.abs(x[:, :4] @ theta[:4] - torque).max()


def test_a_program_that_is_repeated_exactly_is_near_itself():
    """Else all that was not repeated so would count as unknown, and no load were weighed."""
    stream, rows = Arm().block(), []
    for begin_ in (0, 7):
        cutter = Cutter()
        for stamp, q, v, effort in stream[begin_:]:
            assert not cutter.take(stamp, NAMES, q, v, effort)
        log = checked_log(raw_log(cutter.end(), NAMES, 'one block'), NAMES)
        rows.append(rows_of(log, robot_of(urdf(), ())[0]))
    assert farther(rows[1:], states_of(3 * rows[:1])) < 3.0


WEIGHED = [
    (0.0, 'revolute', '0 1 0', NAMES[1:2]), (0.002, 'revolute', '0 1 0', NAMES[1:2]),
    (1.57, 'revolute', '0 1 0', NAMES[:2]), (0.0, 'revolute', '0 0 1', NAMES[1:2]),
    (0.0, 'prismatic', '0 1 0', NAMES[:2]), (1.57, 'prismatic', '0 1 0', NAMES[1:2])]


def test_only_gravity_tells_a_weight_from_a_rotor_at_the_first_joint():
    """Without it both have one column: its drift was a false weight of healthy arms."""
    for roll, kind, axis, weighed in WEIGHED:
        text = urdf().replace('revolute', kind).replace('"0 1 0"', f'"{axis}"').replace(
            'xyz="0 0 0.2"', f'xyz="0 0 0.2" rpy="{roll} 0 0"')
        states = groups_of(robot_of(text, ())[0])
        assert [g.place for g in states if g.kind == WEIGHT] == weighed
        assert [g.place for g in states if g.kind == ROTOR] == NAMES


@pytest.mark.parametrize('gains, found', [((100.0, 50.0), (3, 0, None)),
                                          ((100.0, 99.5), (9, 0, 1))])
def test_states_that_explain_alike_are_both_named_after_longer(gains, found):
    levels = levels_of(*(np.full((2, 1), x) for x in (0.5, 0.001, 0.01)))
    for k in range(24):
        value = np.array([0.5 * (k >= 15)]), np.full((1, 1), 0.03 ** 2)
        levels = with_block(levels, [value, value], np.array(gains) * (k >= 15), k)
        step_ = step_in(levels)
        assert k >= 14 + found[0] or step_ is None
        if step_:
            break
    assert (k - 14, step_.state, step_.rival) == found
    change = Change(WEIGHT, 'joint2', 0.3, 0.01, 0, 0, rival=(WEIGHT, 'joint3'))
    assert change_words(change).endswith(', or at joint3')


def test_a_level_that_is_not_known_does_not_scatter_with_the_blocks():
    noise, level = np.diag([1.0, 2.0]), np.array([[0.5, 0.2], [0.2, 1.0]])
    np.testing.assert_allclose(dispersed(noise + level, level, 5.0), level + 5.0 * noise, 1e-7)
    np.testing.assert_allclose(dispersed(noise, 1e12 * np.eye(2), 5.0), noise, 1e-7)


def test_a_step_that_does_not_last_is_no_change(settled, arm):
    """A block with a collision, or two with a cable in the way."""
    watch = settled[1]
    for length in (1, 2):
        arm.friction[1] = 2.0
        watch, _ = watched(watch, messages(arm, length))
        arm.friction[1] = 1.0
        watch, _ = watched(watch, messages(arm, 4))
    assert not watch.changes


def test_what_does_not_move_or_drowns_in_noise_is_not_judged(settled, arm):
    arm.still = (0,)
    watch, _ = watched(settled[1], messages(arm, 9))
    assert [j.level for j in watch.joints] == [None, Level.OK, Level.OK] and watch.level is None
    assert watch_data(watch)['summary'] == '2 joints as learnt; 1 not judged.'
    arm.still, arm.noise = (), 40.0
    watch, _ = watched(watch, messages(arm, 6))
    assert [j.level for j in watch.joints] == [None] * 3 and watch.level is None
    assert not watch.changes


@pytest.mark.parametrize('quantity, value', [('effort', 7.5), ('position', 0.3)])
def test_a_dead_sensor_of_a_joint_is_never_ok(settled, arm, quantity, value):
    """An effort without noise, or an encoder that says the joint stands still."""
    watch = settled[1]
    for _ in range(3):
        stream = arm.block()
        for _, q, _, effort in stream:
            (q if quantity == 'position' else effort)[1] = value
        watch, _ = watched(watch, stream)
        assert watch.level is None
    assert quantity == 'position' or watch.notes == ('no position or no effort of joint2',)
    watch, _ = watched(watch, messages(arm, 6))
    assert watch.level == Level.OK and not watch.changes


def test_a_friction_that_comes_and_goes_is_never_ok(settled, arm):
    watch = settled[1]
    for number in range(7):
        arm.friction[1] = 1.0 if number % 3 else 1.8
        watch, _ = watched(watch, arm.block())
        assert watch.level != Level.OK or number in (1, 2)


def test_a_joint_whose_effort_goes_or_comes_is_described_again():
    """One that is always 0, as of a gripper, is none; whether the joint rests does not matter."""
    arm, watch, told = Arm(), begin(urdf()), []
    for number in range(11):
        arm.still = (2,) if number < 3 or number == 6 else ()
        stream = arm.block()
        for _, _, _, effort in stream:
            effort[2] = effort[2] if number > 7 else 0.0
        watch, _ = watched(watch, stream)
        told.append((watch.phase[0], len(watch.kept), [*watch.locked]))
    assert told == [
        ('d', 1, []), ('d', 2, []), ('l', 3, []), ('d', 1, []), ('d', 2, []),
        *(('l', kept, NAMES[2:]) for kept in (3, 4, 5)), ('d', 1, []), ('d', 2, []), ('l', 3, [])]


def test_same_bits_however_messages_arrive_and_after_a_restart(settled, arm, tmp_path):
    """Late by less than a second, twice, in other portions, saved and loaded in the middle."""
    arm.friction[1] = 1.4
    stream = messages(arm, 5)
    once, events = watched(settled[1], stream)
    late = [stream[k] for k in np.argsort(np.arange(len(stream)) // 50 * 50
                                          + arm.rng.uniform(0.0, 50.0, len(stream)))]
    save_watch(tmp_path / 'state', settled[1])
    again, cutter = load_watch(tmp_path / 'state'), Cutter()
    happened = []
    for number, (stamp, q, v, effort) in enumerate([*late, *late[-30:]]):
        for block in cutter.take(stamp, NAMES[::-1], q[::-1], v[::-1], effort[::-1]):
            again, more = step(again, block)
            happened += more
            save_watch(tmp_path / 'state', again)
            again = load_watch(tmp_path / 'state')
    for block in cutter.end():
        again, more = step(again, block)
        happened += more
    assert happened == events and watch_bytes(again) == watch_bytes(once)


def test_a_load_counts_from_the_first_block_although_others_taught():
    """It was empty and noisy; all blocks from which the robot is learnt carry a load."""
    arm = Arm(seed=5)
    arm.noise = 2.0
    stream = messages(arm, 2)
    arm.noise, arm.load = 0.1, LOAD
    watch, _ = watched(begin(urdf()), stream + messages(arm, 8))
    held, = watch.payloads
    assert watch.empty[0].covariance.any() and not watch.changes
    assert abs(held.mass - LOAD) < 3.0 * held.mass_std < 0.5 * LOAD


def test_a_joint_that_counts_the_other_way_is_named_and_read_so():
    arm, sign = Arm(), np.array([1.0, -1.0, 1.0])
    stream = [(stamp, sign * q, sign * v, sign * effort)
              for stamp, q, v, effort in messages(arm, 4)]
    watch, _ = watched(begin(urdf()), stream)
    words, = watch_data(watch)['readings']
    assert watch.phase == 'learn' and words.startswith('joint2 counts the other way')


def test_tare_and_learning_again(settled, arm):
    arm.load = LOAD
    watch, _ = watched(settled[1], messages(arm, 3))
    assert abs(tare(watch).payloads[0].mass) < 1e-9 < LOAD / 2 < watch.payloads[0].mass
    assert learn_again(watch).level is None and learn_again(watch).knowledge is None


def test_a_damaged_state_is_refused(settled, tmp_path):
    content = bytearray(watch_bytes(settled[1]))
    for place in np.random.default_rng(1).integers(len(content), size=20).tolist():
        damaged = bytes(content[:place]) + bytes([content[place] ^ 1]) + bytes(
            content[place + 1:])
        (tmp_path / 'state').write_bytes(damaged)
        try:
            assert watch_bytes(load_watch(tmp_path / 'state')) == bytes(content)
        except InputError:
            pass


def test_a_state_that_is_damaged_or_of_another_robot_is_set_aside(settled, tmp_path, capsys):
    path = tmp_path / 'arm.state'
    save_watch(path, settled[1])
    child = Watching(path)
    child.take(DESCRIPTION, urdf())
    assert child.watch.phase == WATCH and not child.problem
    assert not json.loads(capsys.readouterr().out)['events']
    child.take(DESCRIPTION, urdf([2.0 * m for m in MASS]).replace('effort="300"', 'effort="0"', 1))
    doubt, = json.loads(capsys.readouterr().out)['events']
    assert doubt.startswith('joint joint1: effort limit 0')
    assert child.watch.knowledge is None and 'another robot_description' in child.problem
    replaced, = tmp_path.glob('*.replaced-*')
    assert watch_bytes(load_watch(replaced)) == watch_bytes(settled[1]) and not path.exists()
    path.write_bytes(replaced.read_bytes()[:-200])
    child = Watching(path)
    assert child.watch is None and 'the robot is learnt again' in child.problem
    child.take(DESCRIPTION, urdf())
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert told[-1]['problem'] == child.problem and len([*tmp_path.glob('*.corrupt-*')]) == 1


def write_bag(path, stream, description=None):
    with BagWriter(path) as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        if description:
            store = get_typestore(Stores.ROS2_JAZZY)
            kind = 'std_msgs/msg/String'
            writer.add_topic('/robot_description', kind)
            writer.write('/robot_description', stream[0][0], bytes(store.serialize_cdr(
                store.types[kind](description), kind)))
        stamps, q, v, effort = (np.array(x) for x in zip(*stream))
        for stamp, raw in zip(stamps.tolist(), encode_joint_states(
                stamps, NAMES, q, velocity=v, effort=effort)):
            writer.write('/joint_states', stamp, raw)
    return str(path)


def test_the_command_goes_on_from_its_state_and_says_what_changed(settled, arm, tmp_path, capsys):
    """Two bags are one stream, wherever the robot was cut off."""
    state, data = str(tmp_path / 'arm.watch'), tmp_path / 'findings.json'
    first = write_bag(tmp_path / 'first', messages(Arm(), 3), urdf())
    assert main(['watch', first]) == 3
    assert 'Learning the robot' in capsys.readouterr().out
    save_watch(state, settled[1])
    arm.gain[1] = 0.8
    stream = messages(arm, 4)
    once, _ = watched(settled[1], stream)
    bags = [write_bag(tmp_path / f'bag{k}', part) for k, part in enumerate(
        (stream[:3100], stream[3100:]))]
    assert main(['watch', *bags, '--state', state, '--json', str(data)]) == 1
    assert watch_bytes(load_watch(state)) == watch_bytes(once)
    found = json.loads(data.read_text())
    assert found['verdict'] == 'effect' and found['findings'][0]['joint'] == 'joint2'
    assert found['summary'] == found['findings'][0]['words'] + '.'
    assert 'joint2: torque scale -' in found['summary'] and found['joints']['joint1']['level'] == 0
    again = watch_robot(bags, state=settled[1])
    assert str(again) == capsys.readouterr().out.strip()
    assert repr(again) == f"Watch({found['summary']})"
    assert watch_bytes(load_watch(again.save(state))) == watch_bytes(once)
    for words, error in (([], 'no message on robot_description'),
                         (['--state', state], 'expected a time after what was taken')):
        assert main(['watch', bags[0], *words]) == 2
        assert error in capsys.readouterr().err


def test_a_text_file_without_a_date_follows_what_was_taken(settled, arm, tmp_path, capsys):
    state, log = str(tmp_path / 'arm.watch'), tmp_path / 'log.csv'
    save_watch(state, settled[1])
    arm.gain[1] = 0.8
    stamps, q, _, effort = (np.array(x) for x in zip(*messages(arm, 4)))
    for seconds, names in ((80, NAMES), (160, range(1, len(NAMES) + 1))):  # from the base
        header = ','.join(['t', *(f'q_{n}' for n in names), *(f'tau_{n}' for n in names)])
        np.savetxt(log, np.column_stack([(stamps - stamps[0]) / SECOND, q, effort]), '%.9g', ',',
                   header=header, comments='')
        assert main(['watch', str(log), '--state', state]) == 1
        assert capsys.readouterr().out.startswith('joint2: torque scale -')
        assert load_watch(state).stamp_ns >= settled[1].stamp_ns + seconds * SECOND
    assert 'joints have only numbers' in load_watch(state).notes[-1]
    for k, other in enumerate(('hip', 'knee', 'toe'), 1):
        log.write_text(log.read_text().replace(f'q_{k},', f'q_{other},').replace(
            f'tau_{k}', f'tau_{other}'))
    assert main(['watch', str(log), '--state', state]) == 2
    assert 'hip, knee, toe, expected those of the description: joint1' in capsys.readouterr().err


def fleet(capsys, folder, *words):
    """Run fleet over the robots in a folder; return its JSON and the rows of its table."""
    assert main(['fleet', str(folder), '--out', str(folder.parent / 'out'), '--robots', '--json',
                 *words]) == 0
    data = json.loads(capsys.readouterr().out)
    return data, {f'{Path(row["path"]).parent.name}/{Path(row["path"]).name}': row
                  for row in parquet.read_table(folder.parent / 'out/bags.parquet').to_pylist()}


def test_a_fleet_has_a_row_for_each_joint_and_goes_on_where_it_ended(
        settled, arm, tmp_path, capsys):
    """One robot rubs, one is healthy, one learns still; a bag is damaged, one is a copy."""
    folder = tmp_path / 'robots'
    for seed, name in enumerate(('arm7', 'arm8', 'new')):
        write_bag(folder / name / 'monday', messages(Arm(seed), 1), urdf())
    (folder / 'arm7/broken.mcap').write_bytes(b'no bag')
    data, rows = fleet(capsys, folder)
    failed = ' 1 bag could not be evaluated.'
    assert data['summary'] == f'No joint could be judged.{failed}' and len(data['joints']) == 9
    assert all(j['level'] is None and 'Waiting' in j['summary'] for j in data['joints'])
    assert rows['arm7/broken.mcap']['status'] == 'failed' and data['done'] == 3
    for name in ('arm7', 'arm8'):   # as if both had been at work since
        state, = (tmp_path / 'out/parts').glob(f'{sha256(name.encode()).hexdigest()[:32]}-*')
        state.write_bytes(watch_bytes(settled[1]))
    write_bag(folder / 'arm8/tuesday', messages(deepcopy(arm), 3))
    shutil.copytree(folder / 'arm8/tuesday', folder / 'arm8/tuesday_copy')
    arm.friction[1] = 1.4
    stream = messages(arm, 4)
    write_bag(folder / 'arm7/tuesday', stream)
    data, rows = fleet(capsys, folder)
    once, _ = watched(settled[1], stream)
    assert json.loads(rows['arm7/tuesday']['judged']) == json.loads(json.dumps(watch_data(once)))
    assert (data['done'], data['skipped'], rows['arm8/tuesday_copy']['status']) == (
        2, 4, 'duplicate')
    worst, *others = data['joints']
    assert (worst['robot'], worst['joint'], worst['level']) == ('arm7', 'joint2', 'WARN')
    assert data['summary'] == f'joint2 of arm7: {worst["summary"]}.{failed}'
    assert worst['summary'].startswith('friction +') and ' since 2023-11-14' in worst['summary']
    assert [(j['robot'], j['level']) for j in others] == [
        *[('arm7', 'OK')] * 2, *[('arm8', 'OK')] * 3, *[('new', None)] * 3]
    page = (tmp_path / 'out/fleet.html').read_text()
    assert data['summary'] in page and 'broken.mcap' in page
    assert fleet(capsys, folder)[0]['skipped'] == 7
    assert main(['fleet', str(folder), '--out', 'x', '--robots', '--serviced', 'x']) == 2
