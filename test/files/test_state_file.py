# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The state file: its owner, a writer that does not hold up samples, and what it cannot write."""
import os
import subprocess
import sys
from threading import Event, Timer


from gearbox_monitor.errors import InputError
from gearbox_monitor.files import baselines
from gearbox_monitor.files.baselines import StateFile


def test_the_newest_text_is_written_at_the_end(tmp_path):
    path = tmp_path / 'state.json'
    file = StateFile(path, 'estimator/elbow')
    assert file.held and not file.problem
    for k in range(100):
        file.keep(str(k))
    file.close()
    assert path.read_text() == '99' and not list(tmp_path.glob('*.tmp'))


def test_two_cannot_share_a_file_without_a_word(tmp_path):
    path = tmp_path / 'state.json'
    first, second = StateFile(path, 'estimator/elbow'), StateFile(path, 'estimator/wrist')
    second.keep('second')
    first.keep('first')
    for file in (second, first):
        file.close()
    assert path.read_text() == 'first' and not second.held
    assert f'{path}: estimator/elbow (process {os.getpid()} on ' in second.problem
    assert 'expected a drift_state_file of its own for each gearbox' in second.problem
    code = ('import sys; from gearbox_monitor.files.baselines import StateFile; '
            'print(StateFile(sys.argv[1], "another").problem)')
    third = StateFile(path, 'again')  # the lock ends with its owner
    assert third.held
    told = subprocess.run([sys.executable, '-c', code, path], capture_output=True, text=True,
                          check=True).stdout
    assert 'again (process' in told
    third.close()


def test_a_disk_that_waits_does_not_hold_up_samples(tmp_path, monkeypatch):
    goes_on, written = Event(), []

    def slow(path, text):
        goes_on.wait()
        written.append(text)
        if len(written) == 1:
            raise InputError(f'{path}: No space left on device, expected a writable file')

    monkeypatch.setattr(baselines, 'write_whole', slow)
    file = StateFile(tmp_path / 'state.json', 'estimator')
    for k in range(50):
        file.keep(str(k))  # returns, while the first write waits
    assert not written
    goes_on.set()
    file.close()
    # What was overtaken is left out; the problem ends with the next text that is written.
    assert written[-1] == '49' and len(written) <= 3
    assert not file.problem if len(written) > 1 else 'No space' in file.problem


def test_what_cannot_be_written_is_told(tmp_path):
    file = StateFile(tmp_path / 'none' / 'state.json', 'estimator')
    assert not file.held and 'No such file or directory' in file.problem
    (tmp_path / 'state.json').mkdir()
    file = StateFile(tmp_path / 'state.json', 'estimator')
    file.keep('x')
    file.close()
    assert 'expected a writable file' in file.problem


def test_a_folder_that_comes_late_gets_the_state_and_loses_none(tmp_path):
    """As a drive that is mounted after the node has started, with an older state on it."""
    path = tmp_path / 'late' / 'state.json'
    file = StateFile(path, 'estimator')
    assert not file.held and file.keep('first') == ''
    path.parent.mkdir()
    path.write_text('of another run')
    note = file.keep('second')
    file.close()
    assert path.read_text() == 'second' and not file.problem
    unread, = path.parent.glob('state.json.unread-*')
    assert unread.read_text() == 'of another run' and unread.name in note


def test_a_predecessor_that_ends_is_waited_for(tmp_path):
    path = tmp_path / 'state.json'
    first = StateFile(path, 'estimator')
    first.keep('its state')
    Timer(0.3, first.close).start()
    second = StateFile(path, 'estimator')
    assert second.held and second.readable and path.read_text() == 'its state'
    second.close()


def test_a_rival_that_ends_later_leaves_its_state(tmp_path, monkeypatch):
    monkeypatch.setattr(baselines, 'PREDECESSOR', 0.0)
    path = tmp_path / 'state.json'
    first, second = StateFile(path, 'estimator/elbow'), StateFile(path, 'estimator/wrist')
    assert not second.readable and not second.held
    first.keep_recording(lambda: b'rows of the elbow')
    first.keep('elbow')
    first.close()
    second.keep_recording(lambda: b'rows of the wrist')
    note = second.keep('wrist')
    second.close()
    assert (path.read_text(), second.recording.read_bytes()) == ('wrist', b'rows of the wrist')
    for name, content in (('state.json', b'elbow'),
                          ('state.json.recording', b'rows of the elbow')):
        unread, = tmp_path.glob(f'{name}.unread-*')
        assert unread.read_bytes() == content and unread.name in note
