# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Child processes that run nodes: started, watched and stopped in order, never left behind."""
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import gearbox_monitor

PARENT = 'GEARBOX_MONITOR_PARENT'  # read by nodes.runtime: a node ends with this process
LOG_LINES = 10


def cores():
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()


class ChildFailed(Exception):
    """A child process could not be used; `code` is the exit code for the user."""

    def __init__(self, message, code=1):
        super().__init__(message)
        self.code = code


class Interrupt:
    """
    Ctrl-C, SIGTERM and SIGHUP as a flag, so that they break nothing off half-way.

    ``with Interrupt() as interrupt``: `interrupt.requested` is set by the first signal; all
    further ones change nothing. After :meth:`at_once` a signal ends the process with 130.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self):
        self.requested = False
        self._at_once = False

    def __enter__(self):
        self._before = {number: signal.signal(number, self._handle) for number in self.SIGNALS}
        return self

    def __exit__(self, *_):
        for number, handler in self._before.items():
            # The process is about to end: a second Ctrl-C must not break that off.
            signal.signal(number, signal.SIG_IGN if self.requested else handler)

    def at_once(self):
        """Let a signal end the process from now on: no child runs any more."""
        self._at_once = True

    def _handle(self, *_):
        self.requested = True
        if self._at_once:
            os.write(1, b'interrupted\n')
            os._exit(130)


class Child:
    """
    One node in a process and session of its own; its output goes to the file `log`.

    module: to run with ``python -m``, with these `arguments`. parameters: {name: bool, number,
    text or list}. Only the parent gets the terminal's Ctrl-C; it stops its children in order.
    """

    def __init__(self, name, module, parameters, log, env, arguments=()):
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
    def running(self):
        return self.process.poll() is None

    def check(self):
        """Raise ChildFailed when the process has ended with an error."""
        code = self.process.poll()
        if code:
            raise ChildFailed(f'{self.name} {_ended(code)}:\n{self.tail()}', 2 if code == 2 else 1)

    def tail(self):
        """Return the last lines of the log."""
        lines = self.log.read_text(encoding='utf-8', errors='replace').splitlines()
        return '\n'.join('  ' + line for line in lines[-LOG_LINES:]) or '  (it said nothing)'

    def stop(self, seconds):
        """
        Ask the process to end, kill it when it has not after `seconds`.

        Returns a line about what went wrong, or ''.
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


def _ended(code):
    return f'was ended by signal {-code}' if code < 0 else f'ended with exit code {code}'
