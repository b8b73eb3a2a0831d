# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What processes of one machine share: ROS domains, and the shared memory of Fast DDS."""
from collections.abc import Iterator, Mapping, Sequence
import contextlib
import ctypes
import fcntl
import json
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import tempfile
import time
from types import FrameType
from typing import Self

import gearbox_monitor
from gearbox_monitor.errors import InputError

MEMORY = Path('/dev/shm')
AGE_S = 2.0
DOMAINS = range(60, 102)  # the ports of higher domains are those that Linux gives away


def remove_cut_ports(folder: Path = MEMORY) -> list[str]:
    """
    Remove ports of Fast DDS in `folder` that killed processes left empty; return their names.

    A process that dies between making the file of a port and sizing it leaves the file empty for
    good, and each node on the machine that comes to this port blocks in its constructor. A live
    process sizes the file within microseconds: an empty file older than AGE_S is an orphan.
    """
    removed = []
    for port in folder.glob('fastrtps_port*'):
        with contextlib.suppress(OSError):  # gone, or another user's
            status = port.stat()
            if status.st_size == 0 and not port.name.endswith('_el') \
                    and time.time() - status.st_mtime > AGE_S:
                port.unlink()
                removed.append(port.name)
    if removed:
        print(f'removed what a killed process left of shared memory: {" ".join(sorted(removed))}',
              file=sys.stderr)
    return sorted(removed)


@contextlib.contextmanager
def own_domain() -> Iterator[int]:
    """
    Yield the number of a ROS domain that nobody else uses while the block runs.

    A lock on a file in the temporary directory keeps other runs of this package out; the lock
    ends with the process, however the process ends. Raises InputError when all domains are taken.
    """
    for domain in DOMAINS:
        if str(domain) == os.environ.get('ROS_DOMAIN_ID') or _in_use(domain):
            continue
        path = Path(tempfile.gettempdir()) / f'gearbox_monitor_domain_{domain}.lock'
        with contextlib.ExitStack() as stack:
            try:
                fcntl.flock(stack.enter_context(path.open('w')), fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:  # another process has it, or another user once had
                continue
            yield domain
            return
    raise InputError(f'ROS domains {DOMAINS[0]} to {DOMAINS[-1]}: all are in use, expected a free '
                     'one (is another demo still running?)')


def _in_use(domain: int) -> bool:
    """Return whether the first participant of `domain` has its port on this machine."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('', 7410 + 250 * domain))
        except OSError:
            return True
    return False


PARENT = 'GEARBOX_MONITOR_PARENT'  # process id of a parent that the node must not outlive
PR_SET_PDEATHSIG = 1
LOG_LINES = 10


def child_environment(env: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return `env` for a process of this package, whose matrices want no threads of BLAS."""
    root = str(Path(gearbox_monitor.__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, [root, env.get('PYTHONPATH')]))
    return {**env, 'PYTHONPATH': path, 'OPENBLAS_NUM_THREADS': '1'}


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
        with open(self.log, 'xb') as output:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                env={**child_environment(env), PARENT: str(os.getpid())},
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
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return f'{self.name} did not end within {seconds:g} s and was killed'
        return ''


def _ended(code: int) -> str:
    return f'was ended by signal {-code}' if code < 0 else f'ended with exit code {code}'
