# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A state file that one process writes, from a thread of its own.

Who keeps the state holds a lock on PATH.lock (flock), so that two estimators cannot share a file
without a word. A disk may take seconds to confirm a write: samples do not wait for it.
"""
from collections.abc import Callable
import fcntl
import os
from pathlib import Path
import socket
from threading import Condition, Thread
import time
from typing import TextIO

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baseline_recording import SUFFIX
from gearbox_monitor.files.baselines import set_aside, write_whole

PREDECESSOR = 2.0  # s that a process waits at its start for one that is just ending


class StateFile:
    """
    Writes the newest of the texts that it is given; a text that is overtaken is left out.

    path: of the file; owner: who writes it, for whom it refuses. recording: path of the baseline
    recording beside it. problem: why the file is not written now, '' while it is. held: whether
    the lock is ours: else nothing is written, and each text tries again. readable: whether the
    file is ours to read: no rival keeps its state there.
    """

    def __init__(self, path: str | Path, owner: str) -> None:
        self.path = Path(path)
        self.recording = self.path.with_name(self.path.name + SUFFIX)
        self.problem = ''
        self._change = Condition()
        self._text: str | None = None
        self._rows: Callable[[], bytes] | None = None
        self._ends = False
        self._owner = f'{owner} (process {os.getpid()} on {socket.gethostname()})'
        self._writer: Thread | None = None
        self.readable = True
        self._lock = self._locked()
        end = time.monotonic() + PREDECESSOR
        while not self.readable and time.monotonic() < end:
            time.sleep(0.05)
            self._lock = self._locked()
        self._unread = not (self.readable and self.path.exists())

    @property
    def held(self) -> bool:
        """Whether the lock is ours."""
        return self._lock is not None

    def _locked(self) -> TextIO | None:
        """Return the open lock file that is ours, None with a problem."""
        path = self.path.with_name(self.path.name + '.lock')
        try:
            file = open(path, 'a+', encoding='utf-8')
        except OSError as error:
            self.problem = f'{path}: {error.strerror}, expected a folder that can be written'
            self.readable = True
            return None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            rival = file.read(200).strip() or 'another process'
            file.close()
            self.problem = (f'{self.path}: {rival} keeps its state there, expected a '
                            'drift_state_file of its own for each gearbox')
            self.readable = False
            return None
        file.truncate(0)
        file.write(self._owner + '\n')
        file.flush()
        self.problem, self.readable = '', True
        return file

    def keep(self, text: str) -> str:
        """
        Let `text` be written soon; return what to report, '' for nothing.

        A lock that comes late may find files that this process has not read: they are set aside.
        """
        note = ''
        if not self.held:
            lock = self._locked()
            if lock is None:
                return ''
            paths = [p for p in (self.recording, self.path) if self._unread and p.exists()]
            try:
                note = '; '.join(f'{path}: not read at the start, {set_aside(path, "unread")}'
                                 for path in paths)
            except InputError as error:
                self.problem = str(error)
                lock.close()
                return ''
            self._lock = lock
        with self._change:
            self._text = text
            if self._writer is None:
                self._writer = Thread(target=self._write, daemon=True)
                self._writer.start()
            self._change.notify_all()
        return note

    def keep_recording(self, content: Callable[[], bytes]) -> None:
        """
        Let the baseline recording be written, before the next text that is kept.

        Args:
            content: returns its bytes; called in the thread that writes.
        """
        with self._change:
            self._rows = content

    def _write(self) -> None:
        """Write what comes; the thread."""
        while True:
            with self._change:
                while self._text is None and not self._ends:
                    self._change.wait()
                text, self._text = self._text, None
                rows, self._rows = self._rows, None
            if text is None:
                return
            try:
                if rows is not None:
                    write_whole(self.recording, rows())
                write_whole(self.path, text)
                self.problem = ''
            except InputError as error:  # a full disk must not stop the estimates
                self.problem = str(error)
                with self._change:  # the next text tries again
                    self._rows = self._rows or rows

    def close(self) -> None:
        """Write what waits, and let another process have the file."""
        with self._change:
            self._ends = True
            self._change.notify_all()
        if self._writer is not None:
            self._writer.join()
        if self._lock is not None:
            self._lock.close()
            self._lock = None
