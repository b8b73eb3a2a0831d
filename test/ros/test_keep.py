# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The last minutes kept in memory, and what is written of them; no ROS."""
from pathlib import Path
import resource
import time
import tracemalloc

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_model
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.joint_input import samples_of
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.storage import next_free
from gearbox_monitor.ros import recording_export
from gearbox_monitor.ros.recording_export import (
    BLOCK, diagnosis_command, DTYPE, export_recording, load_of, MAX_RATE, recording_of,
    RecordingBuffer, RecordingContext, SECOND, with_effort_moved)

T0 = 1_700_000_000 * SECOND
PERIOD = 2_000_000


def filled(n, seconds=10.0, block=64, begin=0, ring=None, good=lambda k: True, step=PERIOD):
    ring = ring or RecordingBuffer(seconds, block)
    for k in range(begin, begin + n):
        ring.add(T0 + k * step, good(k), (0.1 * k, 0.2 * k, 0.3 * k, np.nan))
    return ring


def about(**changes):
    model = changes.pop('model', DriveModel(gear_ratio=50.0))
    parameters = EstimatorParameters.of(changes.pop('parameters', {}))
    return RecordingContext(**{
        'topic': '/left/joint_states', 'joints': ('m7', 'arm'), 'model': model,
        'arm_load': 'unknown', 'parameters': parameters, 'reason': 'backlash: grown', **changes})


def moving(n, first=0, motion=0.5):
    """Return rows at 500 Hz of a drive that swings."""
    ring, k = RecordingBuffer(600.0), np.arange(first, first + n)
    motor = motion * np.sin(2 * np.pi * k * 0.002)
    for i, y in zip(k.tolist(), motor.tolist()):
        ring.add(T0 + i * PERIOD, True, (y, 0.9 * y, float(i), np.nan))
    return ring.rows()()


def test_ring_holds_the_last_seconds_in_order():
    for n in (0, 1, 63, 64, 65, 4999, 5000, 5001, 5064, 20001):
        rows = filled(n).rows()()
        assert len(rows) == min(n, 5000)  # 10 s at 500 Hz
        expected = np.arange(n - len(rows), n)
        np.testing.assert_array_equal(rows['stamp_ns'], T0 + expected * PERIOD)
        np.testing.assert_array_equal(rows['values'][:, 1], 0.2 * expected)


def test_ring_is_bounded_and_what_was_read_stays():
    ring = filled(3000, seconds=1.0, step=10)  # far beyond any rate
    assert len(ring) <= MAX_RATE + 2 * 64
    ring = filled(100)
    rows = ring.rows()
    filled(10000, begin=100, ring=ring)
    np.testing.assert_array_equal(rows()['stamp_ns'], T0 + np.arange(100) * PERIOD)
    assert len(ring) < 5000 + 3 * 64


def test_packed_rows_keep_every_bit_in_less_memory():
    rng, n = np.random.default_rng(0), 50_000
    values = rng.normal(size=(n, 4))
    values[:, 3] = np.nan
    values[100:104, 0] = -0.0, np.inf, -np.nan, 5e-324
    good, added = rng.random(n) < 0.9, list(map(tuple, values.tolist()))
    tracemalloc.start()
    try:
        ring = RecordingBuffer(600.0)
        for k, row in enumerate(added):
            ring.add(T0 + k * PERIOD, bool(good[k]), row)
        size, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    rows = ring.rows()()
    assert size < 0.6 * rows.nbytes + BLOCK * DTYPE.itemsize  # of noise, the worst case
    assert rows['values'].tobytes() == values.tobytes()
    np.testing.assert_array_equal(rows['good'], good)


def test_irregular_stamps_refused_samples_and_a_clock_set_back():
    rng = np.random.default_rng(0)
    ring, stamps = RecordingBuffer(2.0, 64), T0 + np.cumsum(rng.integers(1, 40_000_000, 3000))
    for k, stamp in enumerate(stamps.tolist()):
        ring.add(stamp, True, (k, k, k, k))
        if k % 3 == 0:
            ring.add(0, False, (k, k, k, k))
    rows = ring.rows()()
    good = rows[rows['good']]
    np.testing.assert_array_equal(good['stamp_ns'], stamps[stamps > stamps[-1] - 2 * SECOND])
    assert 0.3 < (~rows['good']).sum() / len(good) < 0.37
    for k in range(300):  # a simulation that begins anew
        ring.add(10 * SECOND + k * PERIOD, True, (k, k, k, k))
    rows = ring.rows()()
    np.testing.assert_array_equal(rows['stamp_ns'], 10 * SECOND + np.arange(300) * PERIOD)


def test_a_diagnosis_takes_the_newest_rows_that_move_between_gaps():
    def used(rows, seconds=14.0):
        recording = recording_of(rows, DriveModel(), 'rows', seconds)
        first = rows['stamp_ns'][rows['good']][0] - T0
        begin = round((first / SECOND + recording.begin) * 500)
        return begin, begin + len(recording.u)
    rows = moving(30000)
    assert used(rows) == (23000, 30000)
    still = rows.copy()
    still['values'][12000:, :2] = 0.0  # the drive has stopped
    begin, end = used(still)
    assert end - begin == 7000 and 11000 < end < 14000
    holed = np.delete(still, [*range(9000, 9050), 5000])  # a gap, and one lost sample
    holed['values'][300:400, 1] = np.nan  # without arm: as a gap
    holed['good'][600:610] = False
    begin, end = used(holed)
    assert begin >= 610 and end <= 9000 and end - begin == 7000
    rows['values'][:, 2] = np.nan
    with pytest.raises(InputError, match='u: never measured'):
        used(rows)


def test_effort_moves_to_where_it_acts():
    for delay in (-1, 0, 3):
        rows = with_effort_moved(moving(5000), delay)
        k = (rows['stamp_ns'] - T0) // PERIOD
        np.testing.assert_array_equal(rows['values'][:, 2], k - delay)
        assert len(rows) == 5000 - abs(delay)


def test_folder_holds_everything_as_received_and_the_model(tmp_path):
    rows, clock = moving(10000), lambda: time.struct_time((2026, 3, 4, 5, 6, 7, 0, 0, 0))
    text = export_recording(tmp_path / 'new', rows, about(), clock)
    folder = tmp_path / 'new' / 'kept_2026_03_04-05_06_07'
    assert text == f'20.0 s kept: {diagnosis_command(folder, about())}'
    assert '--recorded-motor m7' in text
    with open_bag(folder / 'bag') as bag:
        assert not bag.truncated
        assert bag.metadata['gearbox_monitor']['source'] == 'estimator: backlash: grown'
        states = bag.joint_states('/left/joint_states', ('m7', 'arm'))
    got, _ = samples_of(states, DriveModel())
    np.testing.assert_array_equal(got.stamp_ns, rows['stamp_ns'])
    np.testing.assert_array_equal(got.y, rows['values'][:, :2])
    np.testing.assert_array_equal(got.u, rows['values'][:, 2:])
    assert (folder / 'bag' / 'metadata.yaml').exists()
    assert load_model(folder / 'drive.yaml') == about().model
    late = about(parameters={'effort_delay': 3})
    again = export_recording(tmp_path / 'new', rows, late, clock)  # never over another
    assert '_2/bag' in again
    with open_bag(folder.with_name(folder.name + '_2') / 'bag') as bag:
        assert bag.metadata['gearbox_monitor']['estimator.effort_delay'] == '0'
        states = bag.joint_states('/left/joint_states', ('m7', 'arm'))
    assert samples_of(states, DriveModel())[0].u[0, 0] == 0.0  # that of 3 samples earlier
    assert len(list((tmp_path / 'new').iterdir())) == 2


def test_two_processes_that_keep_in_the_same_second_have_a_folder_each(tmp_path, monkeypatch):
    def clock():
        return time.struct_time((2026, 3, 4, 5, 6, 7, 0, 0, 0))

    def taken_by_another(path):
        monkeypatch.undo()
        free = next_free(path)
        free.mkdir()
        return free

    export_recording(tmp_path, moving(100), about(), clock)
    monkeypatch.setattr(recording_export, 'next_free', taken_by_another)
    assert '_3/bag' in export_recording(tmp_path, moving(100), about(), clock)


def test_command_finds_another_topic_and_folder():
    words = diagnosis_command(Path('/a b'), about(topic='/j7', joints=('motor', 'x')))
    assert words == ("gearbox_monitor diagnose '/a b/bag' --model '/a b/drive.yaml' --topic /j7 "
                     '--recorded-arm x')


def test_model_says_measured_only_where_the_load_is_in_the_bag():
    for in_file, in_force, given, written in (
            ('none', 'unknown', False, 'none'), ('none', 'measured', True, 'measured'),
            ('measured', 'unknown', True, 'measured'), ('measured', 'measured', False, 'unknown')):
        rows = moving(2500)
        if given:
            rows['values'][:, 3] = 0.5
        assert load_of(rows, DriveModel(arm_load=in_file), in_force) == written


def test_a_full_disk_leaves_nothing_and_deletes_nothing(tmp_path, monkeypatch):
    """The limit of the system on the size of files, as a quota sets it."""
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match='keep_folder'):
        export_recording(tmp_path / 'file', moving(2500), about())
    export_recording(tmp_path, moving(100), about(parameters={'keep_newest': 1}))
    before = sorted(tmp_path.iterdir())
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        with pytest.raises(InputError, match='File too large; removed again'):
            export_recording(tmp_path, moving(2500), about(parameters={'keep_newest': 1}))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    monkeypatch.setattr(recording_export, 'SPARE', 10 ** 18)
    with pytest.raises(InputError, match='MB are free, expected'):
        export_recording(tmp_path, moving(2500), about())
    assert sorted(tmp_path.iterdir()) == before


def test_the_newest_recordings_stay_and_nothing_else_is_deleted(tmp_path):
    others = {tmp_path / name for name in ('kept_for_the_meeting', 'kept_2026_03_04.txt', 'log')}
    for path in others:
        path.mkdir()
    folders = []
    for minute in range(5):
        clock = time.struct_time((2026, 3, 4, 5, 50 - minute, 7, 0, 0, 0))  # a clock set back
        export_recording(tmp_path, moving(50), about(parameters={'keep_newest': 3}),
                         lambda: clock)
        folders += set(tmp_path.iterdir()) - others - set(folders)
    assert set(tmp_path.iterdir()) == others | set(folders[2:])
