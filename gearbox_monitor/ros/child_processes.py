# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Child processes that run nodes: started, watched and stopped in order, never orphaned."""
from collections.abc import Mapping, Sequence
import ctypes
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from types import FrameType
from typing import Self

import gearbox_monitor

PARENT = 'GEARBOX_MONITOR_PARENT'  # process id of a parent that the node must not outlive
PR_SET_PDEATHSIG = 1
LOG_LINES = 10


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else (
        os.cpu_count() or 1)


def end_with(parent: int, number: signal.Signals) -> bool:
    """Let Linux send the signal `number` when `parent` ends; return whether it still runs."""
    if sys.platform.startswith('linux'):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
    return os.getppid() == parent  # it may have ended before the call


class ChildFailed(Exception):
    """A child process failed, as `message` tells; `code` is the exit code for the user."""

    def __init__(self, message: str, code: int = 1) -> None:
        super().__init__(message)
        self.code = code


class Interrupt:
    """
    Ctrl-C, SIGTERM and SIGHUP as a flag, so that they interrupt nothing half-way.

    ``with Interrupt() as interrupt``: `interrupt.requested` is set by the first signal; all
    further ones change nothing. After :meth:`at_once` a signal ends the process with 130.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self) -> None:
        self.requested = False
        self._at_once = False

    def __enter__(self) -> Self:
        self._handlers = {number: signal.signal(number, self._handle) for number in self.SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            # The process is about to end: a second Ctrl-C must not interrupt that.
            signal.signal(number, signal.SIG_IGN if self.requested else handler)

    def at_once(self) -> None:
        """Let each further signal end the process: no child runs any more."""
        self._at_once = True

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if self._at_once:
            os.write(1, b'interrupted\n')
            os._exit(130)


class Child:
    """
    One node in its own process and session, called `name`; its output goes to the file `log`.

    module: to run with ``python -m`` in the environment `env`, with these `arguments`. parameters:
    {name: bool, number, text or list}. Only the parent gets the terminal's Ctrl-C; it stops its
    children in order.
    """

    def __init__(self, name: str, module: str, parameters: Mapping[str, object],
                 log: str | Path, env: Mapping[str, str],
                 arguments: Sequence[str] = ()) -> None:
        self.name, self.log = name, Path(log)
        # No log files of ROS beside ours: their directory may be missing or read-only.
        command = [sys.executable, '-m', module, *arguments, '--ros-args',
                   '--disable-external-lib-logs']
        for key, value in parameters.items():
            command += ['-p', f'{key}:={json.dumps(value)}']
        root = str(Path(gearbox_monitor.__file__).resolve().parents[1])
        path = os.pathsep.join(filter(None, [root, env.get('PYTHONPATH')]))
        with open(self.log, 'xb') as output:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                env={**env, 'PYTHONPATH': path, PARENT: str(os.getpid())},
                start_new_session=True)

    @property
    def running(self) -> bool:
        """Whether the process has not ended."""
        return self.process.poll() is None

    def check(self) -> None:
        """Raise ChildFailed if the process has ended with an error."""
        code = self.process.poll()
        if code:
            raise ChildFailed(f'{self.name} {_ended(code)}:\n{self.tail()}', 2 if code == 2 else 1)

    def tail(self) -> str:
        """Return the last lines of the log."""
        lines = self.log.read_text(encoding='utf-8', errors='replace').splitlines()
        return '\n'.join('  ' + line for line in lines[-LOG_LINES:]) or '  (no output)'

    def stop(self, seconds: float) -> str:
        """
        Ask the process to end; kill it if it has not ended after `seconds`.

        Returns a line about the problem, or ''.
        """
        if self.running:
            # Nodes take both alike, but during its imports Python ends quietly on this one only.
            self.process.send_signal(signal.SIGTERM)
        end = time.monotonic() + seconds
        while self.running:
            if time.monotonic() > end:
                self.process.kill()
                self.process.wait()
                return f'{self.name} did not end within {seconds:g} s and was killed'
            time.sleep(0.01)
        return ''


def _ended(code: int) -> str:
    return f'was ended by signal {-code}' if code < 0 else f'ended with exit code {code}'
