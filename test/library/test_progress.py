# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What commands show: a bar at a terminal, lines in a pipe."""
import io
import os
import subprocess
import sys
import time

from gearbox_monitor.library import progress


class Terminal(io.StringIO):
    """A text stream that claims to be a terminal."""

    def isatty(self):
        """Return True."""
        return True


def terminal(monkeypatch):
    """Return what stands in for stderr; called in a test, as pytest sets stderr before each."""
    stream = Terminal()
    monkeypatch.setattr(sys, 'stderr', stream)
    return stream


def test_time_of_a_bar_goes_on_without_steps(monkeypatch):
    stream = terminal(monkeypatch)
    with progress.shown_time('fit'), progress.progress_bar('fit'):
        while '00:01' not in stream.getvalue():  # as long as a busy machine needs
            time.sleep(0.1)


def test_a_terminal_of_unknown_size_shows_the_bar():
    """Such as a serial console, or one that a program opens."""
    code = 'from gearbox_monitor.library import progress; progress.count_bar("tune", 100).close()'
    ours, theirs = os.openpty()
    assert tuple(os.get_terminal_size(theirs)) == (0, 0)
    subprocess.run([sys.executable, '-c', code], stderr=theirs, check=True)
    os.close(theirs)
    assert b'tune   0 %' in os.read(ours, 1000)
    os.close(ours)


def test_a_pipe_gets_lines_with_the_share(monkeypatch, capsys):
    monkeypatch.setattr(progress, 'EVERY', 0.05)
    with progress.shown_time('fit'):
        time.sleep(0.12)
        with progress.progress_bar('fit') as move:
            move(1, 4)
            time.sleep(0.12)
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first == 'fit: running for 0 s'
    assert last == 'fit: 25 %, running for 0 s'
    with progress.shown_time('fit'):  # ended at once, with nothing to say
        assert not progress.Bar.shown
    assert capsys.readouterr().err == ''


def test_lines_are_about_the_bar_that_is_open():
    """Two in sequence, of which the first is deleted late, and one within another."""
    for _ in range(2):
        with progress.count_bar('fit', 100) as bar:
            bar.update(40)
            assert [b.state()[:4] for b in progress.Bar.shown] == ['40 %']
    with progress.count_bar('fit', 100) as outer, progress.count_bar('part', 100):
        outer.update(30)
    assert progress.Bar.shown == []
    with progress.count_bar('fit', 100) as outer:
        with progress.count_bar('part', 100):
            pass
        assert len(progress.Bar.shown) == 1 and progress.Bar.shown[0] is outer


def test_a_closed_stderr_does_not_send_notes_to_stdout():
    """Where the shell closes stderr, Python has none, and print writes to stdout instead."""
    code = ('import sys; from gearbox_monitor.cli.main import main; '
            'sys.exit(main(["explain", "no_such_effect"]))')
    done = subprocess.run(['sh', '-c', 'exec "$@" 2>&-', 'sh', sys.executable, '-c', code],
                          stdout=subprocess.PIPE, check=False)
    assert (done.returncode, done.stdout) == (2, b'')


def test_a_call_from_python_reports_once_and_to_whom_the_user_says(monkeypatch, capsys):
    monkeypatch.setattr(progress, 'EVERY', 0.05)
    heard = []
    with progress.reported('adapt', lambda *args: heard.append(args)) as report:
        report(1, 4, 'tune')
    assert heard == [(1, 4, 'tune')] and capsys.readouterr().err == ''
    with progress.reported('adapt', None) as report:  # in a pipe
        report(1, 2)
        time.sleep(0.12)
    assert capsys.readouterr().err.splitlines()[0] == 'adapt: 50 %, running for 0 s'
    with progress.shown_time('fit'), progress.reported('adapt', None) as report:  # in a command
        report(3, 4)
        time.sleep(0.12)
    assert set(capsys.readouterr().err.splitlines()) == {'fit: 75 %, running for 0 s'}


def test_a_notebook_shows_the_bar(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'ipykernel', sys)
    with progress.reported('diagnose', None) as report:
        time.sleep(0.12)  # tqdm draws no more than ten times per second
        report(1, 4, 'fits')
    assert 'fits  25 %' in capsys.readouterr().err
