# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Child processes that name what changed: one at a time, with limits, none that outlives its node.

No ROS here. A thread waits for the child; it exists only while there is work.
"""
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from threading import Lock, Thread
from typing import Any

import gearbox_monitor
from gearbox_monitor.files.baseline_recording import BaselineRecording
from gearbox_monitor.ros.naming_child import FAILED, SHORT_OF_MEMORY

MB = 1 << 20
PATIENCE, SLOWEST = 60.0, 20.0  # s, and times the CPU limit, that a child may take in all
# What allocators and loaders say where memory is short.
SHORT_WORDS = ('memory', 'allocate', 'failed to map', "can't start new thread")


@dataclass(frozen=True)
class Order:
    """
    What to compare: baseline recording and later one, both packed, and how.

    arm_load: in force; effort_delay: samples; since_ns: rows of the later recording before it do
    not count; seconds: of each that are used. cpu_seconds, memory (MB): limits of the child.
    """

    reference: BaselineRecording
    later: Callable[[], list[bytes]]
    arm_load: str
    effort_delay: int
    since_ns: int
    seconds: float
    cpu_seconds: int
    memory: int

    def to_bytes(self) -> bytes:
        """Return what the child reads."""
        later = self.later()
        data = {name: getattr(self, name) for name in (
            'arm_load', 'effort_delay', 'since_ns', 'seconds', 'cpu_seconds')}
        data |= {'model': self.reference.model, 'memory': self.memory * MB,
                 'parent': os.getpid(), 'reference': list(map(len, self.reference.blocks)),
                 'later': list(map(len, later))}
        return json.dumps(data).encode() + b'\n' + b''.join((*self.reference.blocks, *later))


@dataclass
class NamingJob:
    """An Order, and what became of it: a verdict as plain data, or why there is none."""

    order: Order
    verdict: dict[str, Any] | None = None
    problem: str = ''
    done: bool = False


class ChangeNamer:
    """Runs NamingJobs one after the other; those beyond `capacity` that wait are refused."""

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._lock = Lock()
        self._waiting: deque[NamingJob] = deque()
        self._thread: Thread | None = None
        self._child: subprocess.Popen[bytes] | None = None
        self._ends = False

    def submit(self, order: Order) -> NamingJob:
        """Return the NamingJob of an `order`, done at once if too many wait."""
        job = NamingJob(order)
        with self._lock:
            if self._ends or len(self._waiting) >= self._capacity:
                job.problem, job.done = f'{self._capacity} diagnoses wait already', True
                return job
            self._waiting.append(job)
            if self._thread is None:
                self._thread = Thread(target=self._run, daemon=True)
                self._thread.start()
        return job

    def _run(self) -> None:
        """Run what waits; the thread."""
        while True:
            with self._lock:
                if self._ends or not self._waiting:
                    self._thread = None
                    return
                job = self._waiting.popleft()
            try:
                job.verdict = self._named(job.order)
            except Exception as error:  # whatever it is, the estimates must go on
                job.problem = str(error) or type(error).__name__
            job.done = True

    def _named(self, order: Order) -> dict[str, Any]:
        """Return the verdict of a child. Raises RuntimeError with what ended it."""
        content = order.to_bytes()
        root = str(Path(gearbox_monitor.__file__).resolve().parents[1])
        path = os.pathsep.join(filter(None, [root, os.environ.get('PYTHONPATH')]))
        with self._lock:
            if self._ends:
                raise RuntimeError('the node ends')
            child = self._child = subprocess.Popen(
                [sys.executable, '-m', 'gearbox_monitor.ros.naming_child'],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                env={**os.environ, 'PYTHONPATH': path, 'OPENBLAS_NUM_THREADS': '1'},
                start_new_session=True)
        seconds = PATIENCE + SLOWEST * order.cpu_seconds
        try:
            output, errors = child.communicate(content, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f'the diagnosis took more than {seconds:.0f} s, expected '
                               'processor time for it') from None
        finally:
            child.kill()
            child.wait()
            with self._lock:
                self._child = None
        if child.returncode == 0:
            verdict: dict[str, Any] = json.loads(output)
            return verdict
        raise RuntimeError(self._reason(order, child.returncode,
                                        errors.decode('utf-8', 'replace').splitlines()))

    def _reason(self, order: Order, code: int, lines: list[str]) -> str:
        """Return why a child ended with `code`, having written the error `lines`."""
        if self._ends:
            return 'the node ends'
        if code == -signal.SIGXCPU:
            return (f'the diagnosis took more than {order.cpu_seconds} s of CPU time '
                    '(name_changes_cpu)')
        last = lines[-1] if lines else ''
        if code == FAILED and last:
            return last
        if code == SHORT_OF_MEMORY or any(
                word in line.lower() for word in SHORT_WORDS for line in lines):
            return f'the diagnosis took more than {order.memory} MB (name_changes_memory)'
        ended = f'signal {-code}' if code < 0 else f'exit code {code}'
        return f'the diagnosis ended with {ended}: {last}'.rstrip(': ')

    def close(self) -> None:
        """Kill the child that runs, and wait for its end."""
        with self._lock:
            self._ends = True
            thread = self._thread
            if self._child is not None:
                self._child.kill()
        if thread is not None:
            thread.join()
