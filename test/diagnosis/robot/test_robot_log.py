# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Logs of robots: sections, rates, stamps; what the files hold and what is refused."""
import gzip

import numpy as np
import pytest

from gearbox_monitor.diagnosis.robot.robot_log import checked_log, continuous, RawLog
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.from_bag import names_in_log, robot_log
from gearbox_monitor.recordings.read import JOINT_STATE
from gearbox_monitor.recordings.reading import open_recording
from gearbox_monitor.recordings.write import BagWriter

JOINTS = ('a', 'b')


def read_robot_log(path, joints, recorded, constants=None, **options):
    with open_recording(path) as reader:
        return robot_log(reader, joints, recorded, constants, **options)


def raw(t, **changes):
    """Return a RawLog of two joints at the times `t`."""
    x = np.sin(t)
    return RawLog(**{'name': 'log', 't': t, 'position': {'a': x, 'b': 2 * x},
                     'input': {'a': x, 'b': x}, 'kind': 'torque', **changes})


def test_gaps_make_sections_and_short_ones_are_counted():
    t = np.arange(0, 20, 0.01)
    log = checked_log(raw(np.delete(t, slice(800, 830))), JOINTS)
    assert [len(s.t) for s in log.sections] == [800, 1170]
    short = checked_log(raw(np.delete(t, slice(100, 130))), JOINTS)
    assert [len(s.t) for s in short.sections] == [1870]
    assert any('1870 of 1970 samples' in str(note) for note in short.notes)


def test_a_slip_ends_a_section():
    """As motion it was an acceleration of 10^3 rad/s^2, which took the friction's place."""
    t = np.arange(0, 20, 0.01)
    position = {'a': np.where(t < 7.995, np.sin(t), np.sin(t) + 0.2), 'b': 2 * np.sin(t)}
    log = checked_log(continuous(raw(t, position=position)), JOINTS)
    assert [len(s.t) for s in log.sections] == [800, 1200]
    assert '1 slips of positions: 2000 of 2000 samples are used' in map(str, log.notes)


def test_lost_samples_make_no_gap():
    """Left out or repeated: a jump of all joints behind repeats took half of a log."""
    whole = np.arange(0, 20, 0.01)
    assert len(checked_log(raw(np.delete(whole, [300, 301, 900])), JOINTS).sections) == 1
    held = whole.copy()
    held[300:304] = held[299]
    log = checked_log(continuous(raw(whole, **{key: {'a': np.sin(held), 'b': 2 * np.sin(held)}
                                               for key in ('position', 'input')})), JOINTS)
    assert [len(s.t) for s in log.sections] == [1996] and len(log.notes) == 1
    assert '4 of 2000 samples are left out: they repeat' in str(log.notes[0])


def test_stamps_on_top_of_each_other_are_left_out():
    """A spline through stamps 1 ns apart named a payload of -6.6 kg."""
    t = np.repeat(np.arange(0, 10, 0.01), 2)
    t[1::2] += 1e-9
    log = checked_log(raw(t), JOINTS)
    assert np.diff(log.sections[0].t).min() > 0.009
    assert any('1000 of 2000 samples' in str(note) for note in log.notes)


def expect_one_clock(kind):
    first = np.arange(0, 20, 0.01)
    second = np.delete(np.arange(0.003, 20, 0.004), slice(1500, 1600))
    t = np.sort(np.concatenate([first, second]))

    def column(own, x):
        return np.where(np.isin(t, own), x, np.nan)
    log = checked_log(raw(t, kind=kind, position={'a': column(first, np.sin(t)),
                                                  'b': column(second, np.cos(3 * t))},
                          input={'a': column(first, t), 'b': column(second, 5 * t)}), JOINTS)
    assert any(str(note).startswith('b: messages of their own, interpolated to the stamps of a')
               for note in log.notes)
    assert len(log.sections) == 2 and log.rate == pytest.approx(100.0)
    for s in log.sections:
        assert np.isin(s.t, first).all()
        np.testing.assert_allclose(s.position, np.column_stack([np.sin(s.t), np.cos(3 * s.t)]),
                                   atol=1e-6)
        behind = 0.0 if kind == 'torque' else (s.t - 0.003 + 1e-12) % 0.004 - 1e-12
        np.testing.assert_allclose(s.input, np.column_stack([s.t, 5 * (s.t - behind)]), atol=1e-6)


def test_joints_in_messages_of_their_own_come_to_one_clock():
    """At another rate, with a gap in one of them; a table with blanks is the same."""
    for kind in ('torque', 'setpoint'):
        expect_one_clock(kind)


def test_slow_logs_are_refused_below_30_hz():
    for rate, refused in ((29, True), (31, False)):
        t = np.arange(0, 20, 1 / rate)
        if refused:
            with pytest.raises(InputError, match='29 samples/s, expected 30'):
                checked_log(raw(t), JOINTS)
        else:
            assert checked_log(raw(t), JOINTS).rate == pytest.approx(rate)


def test_missing_joint_names_what_the_log_has():
    with pytest.raises(InputError, match='joint c: no position.*has a, b'):
        checked_log(raw(np.arange(0, 10, 0.01)), ('a', 'c'))


def table(path, header, columns, opener=open):
    """Write a CSV file."""
    rows = '\n'.join(','.join(f'{x:.6g}' for x in row) for row in np.column_stack(columns))
    with opener(path, 'wt') as file:
        file.write(header + '\n' + rows + '\n')
    return path


def test_table_with_mapped_names_and_current(tmp_path):
    t = np.arange(0, 5, 0.01)
    path = table(tmp_path / 'log.csv.gz', 't,q_a,q_motor2,i_a,i_motor2,v_a',
                 [t, t, 2 * t, 3 * t, 4 * t, t], gzip.open)
    log = read_robot_log(path, JOINTS, {'b': 'motor2'}, {'a': 10.0, 'b': 2.0})
    assert log.kind == 'current' and log.measured
    np.testing.assert_allclose(log.position['b'], 2 * t, atol=1e-5)
    np.testing.assert_allclose(log.input['a'], 30 * t, atol=1e-4)
    np.testing.assert_allclose(log.input['b'], 8 * t, atol=1e-4)


def test_where_a_log_has_locked_joints_is_said(tmp_path):
    """One that moves all the same would be a load that nobody knows."""
    t = np.arange(0, 5, 0.01)
    path = table(tmp_path / 'log.csv', 't,q_a,q_b,q_grip,tau_a,tau_b', [t, t, t, t, -t, t])
    stamps = np.rint((1.0 + t) * 1e9).astype(np.int64)
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        for stamp, message in zip(stamps.tolist(), encode_joint_states(
                stamps, (*JOINTS, 'grip'), np.column_stack([t, t, t]),
                effort=np.column_stack([-t, t, np.nan * t]))):
            writer.write('/joint_states', stamp, message)
    for log in (path, tmp_path / 'bag'):
        notes = read_robot_log(log, JOINTS, {}, locked={'grip': 0.5, 'thumb': 0.0}).notes
        assert 'grip: locked at 0.5; the log has it from 0 to 4.99' in map(str, notes)
        assert not any('thumb' in str(note) for note in notes)


def test_an_effort_without_a_direction_is_no_torque(tmp_path):
    """The load of hobby servos: taken for a torque, it was a limit of 0.02 N m at each joint."""
    t = np.arange(0, 5, 0.01)
    columns = [t, np.sin(t), np.cos(t), *np.abs([np.sin(t), np.cos(t)]).round(2)]
    header = 't,q_a,q_b,tau_a,tau_b'
    path = table(tmp_path / 'log.csv', header, columns)
    with pytest.raises(InputError, match='effort: no value is below 0'):
        read_robot_log(path, JOINTS, {}, no_servo='')
    path = table(tmp_path / 'goal.csv', header + ',setpoint_a,setpoint_b', [*columns, t, t])
    assert read_robot_log(path, JOINTS, {}, no_servo='').kind == 'setpoint'
    stamps = np.rint((1.0 + t) * 1e9).astype(np.int64)
    efforts = {'sizes': np.column_stack(columns[3:]), 'signed': np.column_stack(columns[1:3])}
    for name, effort in efforts.items():
        with BagWriter(tmp_path / name) as writer:
            for topic in ('/joint_states', '/joint_setpoints'):
                writer.add_topic(topic, JOINT_STATE)
                for stamp, message in zip(stamps.tolist(), encode_joint_states(
                        stamps, JOINTS, np.column_stack(columns[1:3]), effort=effort)):
                    writer.write(topic, stamp, message)
    log = read_robot_log(tmp_path / 'sizes', JOINTS, {}, no_servo='')
    assert log.kind == 'setpoint' and any('no value is below 0' in str(n) for n in log.notes)
    assert read_robot_log(tmp_path / 'signed', JOINTS, {}, no_servo='').kind == 'torque'
    with pytest.raises(InputError, match='effort: no value is below 0'):
        read_robot_log(tmp_path / 'sizes', JOINTS, {})


BAD_TABLES = [
    ('t,q_a,q_b,tau_a', '{t},{t},0,{t}', 'no effort of b, expected the torque of all joints'),
    ('t,q_a,tau_a', '{t},{t},{t}', 'no b in the log.*stands still, its position: locked in --val'),
    ('t,q_a,q_b,setpoint_a,setpoint_b', '{t},{t},{t},{t},{t}', 'need position actuators'),
    ('t,q_a,q_b,tau_a,tau_b', '{t},{t},{t}', 'line 102: 3 columns, expected at least 5')]


def test_bad_tables_are_refused_with_their_place(tmp_path):
    for header, row, words in BAD_TABLES:
        path = tmp_path / 'log.csv'
        good = ','.join(['{t}'] * len(header.split(',')))
        path.write_text(header + '\n' + ''.join(good.format(t=0.01 * k) + '\n' for k in range(100))
                        if 'line' in words else header + '\n' + ''.join(
                            row.format(t=0.01 * k) + '\n' for k in range(200)))
        if 'line' in words:
            path.write_text(path.read_text() + row.format(t=9.0) + '\n')
        with pytest.raises(InputError, match=words):
            read_robot_log(path, JOINTS, {})


def test_a_joint_without_a_single_number_is_named(tmp_path):
    t = np.arange(0, 10, 0.01)
    with pytest.raises(InputError, match='joint b: torque: none of 1000 samples is a number'):
        checked_log(raw(t, input={'a': t, 'b': np.full(len(t), np.nan)}), JOINTS)
    stamps = np.rint((1.0 + t) * 1e9).astype(np.int64)
    setpoint = np.column_stack([t, np.full(len(t), np.nan)])
    with BagWriter(tmp_path / 'bag') as writer:
        for topic, values in (('/joint_states', np.column_stack([t, t])),
                              ('/joint_setpoints', setpoint)):
            writer.add_topic(topic, JOINT_STATE)
            for stamp, message in zip(stamps.tolist(), encode_joint_states(
                    stamps, JOINTS, values)):
                writer.write(topic, stamp, message)
    log = read_robot_log(tmp_path / 'bag', JOINTS, {}, no_servo='')
    np.testing.assert_array_equal(log.input['a'], t)
    with pytest.raises(InputError, match='joint b: setpoint: none of 1000 samples is a number'):
        checked_log(log, JOINTS)


NAMES = [
    (('joint_2', 'joint_1'), JOINTS, {}, {'a': 'joint_1', 'b': 'joint_2'}),
    (('1', '2'), JOINTS, {}, {'a': '1', 'b': '2'}),
    (('left_a', 'left_b', 'x'), JOINTS, {}, {'a': 'left_a', 'b': 'left_b'}),
    (('left_a', 'left_b', 'right_a', 'right_b'), JOINTS, {'*': 'right_'},
     {'a': 'right_a', 'b': 'right_b'}),
    (('m', 'b'), JOINTS, {'a': 'm'}, {'a': 'm', 'b': 'b'}),
    (('lift', 'pan'), ['pan_joint', 'lift_joint'], {}, {'pan_joint': 'pan', 'lift_joint': 'lift'}),
    (('motor', 'arm'), ['elbow'], {}, {'elbow': 'motor'}),
    (('motor', 'arm'), ['arm'], {}, {'arm': 'arm'})]


def expect_names(present, joints, recorded, expected):
    assert names_in_log('log', present, joints, recorded)[0] == expected


def test_names_map_by_number_prefix_and_statement():
    for present, joints, recorded, expected in NAMES:
        expect_names(present, joints, recorded, expected)


UNFIT = [
    (('left_a', 'left_b', 'right_a', 'right_b'), Undecided, '2 robots.*--prefix left_'),
    (('joint_1', 'joint_2', 'joint_3'), InputError, 'no a, b in the log'),
    (('joint_1', 'b'), InputError, '--recorded NAME=LOGNAME')]


def test_names_that_fit_no_joints_are_asked_for():
    for present, kind, words in UNFIT:
        with pytest.raises(kind, match=words):
            names_in_log('log', present, JOINTS, {})
