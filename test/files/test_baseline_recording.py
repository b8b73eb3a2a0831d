# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The recording of a healthy gearbox beside the state of drift: kept, damaged, of another one."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import (
    BaselineRecording, check_belongs, Damaged, load_recording, StateFile)
from gearbox_monitor.ros.recording_export import RecordingBuffer, SECOND, unpacked_rows

T0 = 1_700_000_000 * SECOND


def recording(n=3000, first=0):
    """Return the last 2 s of `n` rows at 500 Hz in blocks of 64, and those rows."""
    buffer = RecordingBuffer(600.0, 64)
    for k in range(first, first + n):
        buffer.add(T0 + k * 2_000_000, k % 7 > 0, (0.1 * k, np.nan, -k, 1e-300))
    return BaselineRecording(
        buffer.newest_ns, 'A-17', ('m', 'a'), {'damping': 0.01, 'effects': []},
        tuple(buffer.blocks(2.0)())), buffer.rows()()


def test_rows_come_back_bit_for_bit_and_no_more_than_the_span(tmp_path):
    healthy, rows = recording()
    path = tmp_path / 'state.json.recording'
    path.write_bytes(healthy.to_bytes())
    back = load_recording(path)
    assert back == healthy
    found = unpacked_rows(back.blocks)
    assert found.tobytes() == rows[-len(found):].tobytes()
    assert 1000 <= len(found) < 1000 + 2 * 64
    later = unpacked_rows(back.blocks, int(rows['stamp_ns'][-10]))
    assert later.tobytes() == rows[-10:].tobytes()
    assert load_recording(tmp_path / 'none') is None


DAMAGES = [
    lambda data: data[:-1], lambda data: data + b'x', lambda data: b'', lambda data: b'[1, 2]\n',
    lambda data: data.replace(b'"format": 1', b'"format": 9'),
    lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
    lambda data: data.replace(b'"joints"', b'"joint"'), lambda data: b'[' * 100_000]


def test_a_damaged_file_is_refused_by_name(tmp_path):
    for damage in DAMAGES:
        path = tmp_path / 'state.json.recording'
        path.write_bytes(damage(recording()[0].to_bytes()))
        with pytest.raises(Damaged, match='state.json.recording: .*expected') as error:
            load_recording(path)
        assert '\n' not in str(error.value)


OTHERS = [
    ({'gearbox_serial': 'B-2'}, 'gearbox_serial: A-17, expected B-2'),
    ({'joints': ('m', '')}, r"joints: \('m', 'a'\), expected \('m', ''\)"),
    ({'model': {'damping': 0.02, 'effects': []}}, 'model: damping: 0.01, expected 0.02'),
    ({'stamp_ns': 5}, 'of another .* stamp_ns: [0-9]+, expected 5')]


def test_a_recording_of_another_gearbox_is_refused_by_name():
    for change, words in OTHERS:
        healthy = recording()[0]
        check_belongs('f', healthy, replace(healthy, blocks=()))
        with pytest.raises(InputError, match=words):
            check_belongs('f', healthy, replace(healthy, **change))


def test_the_newest_recording_is_on_disk_before_the_state_that_names_it(tmp_path, monkeypatch):
    """Also where the disk was full in between: the next text tries again."""
    from gearbox_monitor.files import baselines
    write, full, order = baselines.write_whole, [True], []

    def limited(path, content):
        if full[0] and isinstance(content, bytes):
            full[0] = False
            raise InputError(f'{path}: No space left on device, expected a writable file')
        order.append(path.name)
        write(path, content)
    monkeypatch.setattr(baselines, 'write_whole', limited)
    file = StateFile(tmp_path / 'state.json', 'estimator')
    old, new = recording()[0], recording(first=5000)[0]
    file.keep_recording(old.to_bytes)
    file.keep('{"recording_ns": 1}')
    file.close()
    assert 'No space' in file.problem and not order
    file = StateFile(tmp_path / 'state.json', 'estimator')
    for healthy in (old, new):
        file.keep_recording(healthy.to_bytes)
    file.keep('{"recording_ns": 2}')
    file.close()
    assert order == ['state.json.recording', 'state.json']
    assert load_recording(file.recording) == new
