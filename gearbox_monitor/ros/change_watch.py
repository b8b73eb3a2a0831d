# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Name what changed in a gearbox: when, against which baseline, and by a child process with limits.

No ROS here. One child at a time is started, a thread waits for it, and none outlives its node. As
a program, this module is the child: it reads an Order, pickled, from the standard input and writes
the verdict as JSON. An error is one line on the standard error, with exit code 3.
"""
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
import json
import math
import os
from pathlib import Path
import pickle
import resource
import signal
import subprocess
import sys
from threading import Lock
from typing import Any

from gearbox_monitor.diagnosis.hypothesis import kind_of, NONE
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import (
    BaselineRecording, check_belongs, load_recording, set_aside, StateFile)
from gearbox_monitor.health.alarms import Level, Outcome
from gearbox_monitor.health.backlash.change_tests import FRICTION
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.health.judgement import SLIP
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_VISCOUS
from gearbox_monitor.report.sentences import CHANGES
from gearbox_monitor.ros.middleware import child_environment, end_with
from gearbox_monitor.ros.recording_export import (
    load_of, recording_of, RecordingBuffer, unpacked_rows, with_effort_moved)

FAILED, NICE = 3, 19     # exit code of a child, and how it gives way to all others
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
        return pickle.dumps({**vars(self), 'reference': self.reference.blocks, 'later':
                             self.later(), 'model': self.reference.model, 'parent': os.getpid()})


class ChangeNamer:
    """Carries out Orders in child processes, one after the other."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1)
        self._lock = Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._ends = False

    def submit(self, order: Order) -> Future[dict[str, Any]]:
        """Return the verdict to come of an `order`, as plain data; or RuntimeError: why not."""
        return self._pool.submit(self._named, order)

    def _named(self, order: Order) -> dict[str, Any]:
        """Return the verdict of a child. Raises RuntimeError with what ended it."""
        content = order.to_bytes()
        with self._lock:
            if self._ends:
                raise RuntimeError('the node ends')
            child = self._child = subprocess.Popen(
                [sys.executable, '-m', 'gearbox_monitor.ros.change_watch'],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                env=child_environment(), start_new_session=True)
        seconds = PATIENCE + SLOWEST * order.cpu_seconds
        try:
            output, errors = child.communicate(content, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f'the diagnosis took more than {seconds:.0f} s, expected '
                               'processor time for it') from None
        finally:
            child.kill()
            child.wait()
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
        if any(word in line.lower() for word in SHORT_WORDS for line in lines):
            return f'the diagnosis took more than {order.memory} MB (name_changes_memory)'
        ended = f'signal {-code}' if code < 0 else f'exit code {code}'
        return f'the diagnosis ended with {ended}: {last}'.rstrip(': ')

    def close(self) -> None:
        """Kill the child that runs, and wait for its end."""
        with self._lock:
            self._ends = True
            if self._child is not None:
                self._child.kill()
        self._pool.shutdown(cancel_futures=True)


SECOND = 1_000_000_000
HEALTHY = 60.0      # s of healthy windows that a baseline recording takes, and its length
COMPARED = 8.0      # s of each recording that are compared
# s between two diagnoses of a mismatch of the model alone, which may come and go. It doubles, up
# to the longer one, until a diagnosis names something.
MISMATCH_INTERVAL, LONGEST_INTERVAL = 600.0, 7200.0
MISMATCH = 'model mismatch'
# Temperature changes it, too: the wear model tells that from wear, two recordings do not.
WARMTH = frozenset((MOTOR_VISCOUS.id, MOTOR_COULOMB.id))
_CHANGES = {test: words[0].removesuffix(' by') for test, words in CHANGES.items()}


@dataclass(frozen=True)
class NamingAlert:
    """Why a change is named: its tests, since which stamp (ns), and the tests that stand."""

    reason: str
    since_ns: int
    causes: frozenset[str]


class ChangeWatch:
    """
    Keeps the baseline recording of one gearbox, and has its changes named by a ChangeNamer.

    monitor: of the gearbox; buffer: its newest rows, None: none are kept; state_file: beside which
    the recording is kept, None: in memory alone; recording_ns: the recording that the state of
    drift names, 0 for none.
    """

    def __init__(self, monitor: Monitor, buffer: RecordingBuffer | None, namer: ChangeNamer,
                 state_file: StateFile | None, recording_ns: int = 0) -> None:
        self._monitor, self._buffer, self._namer = monitor, buffer, namer
        self._file = state_file
        self.note = ''  # why a recording was refused
        self._reference = self._loaded(recording_ns)
        self._healthy = 0  # windows in a row
        self._window_ns = monitor.health.stamp_ns
        self._stages: dict[str, int] = {}
        self._mismatch_ns, self._mismatch_named_ns = 0, 0
        self._interval = MISMATCH_INTERVAL
        self._due: NamingAlert | None = None
        self._job: tuple[Order, Future[dict[str, Any]]] | None = None
        self._alert: NamingAlert | None = None  # the newest one that had its turn
        self._problem = ''
        self._verdict: dict[str, Any] | None = None

    @property
    def recording_ns(self) -> int:
        """Stamp of the baseline recording, 0 without one."""
        return 0 if self._reference is None else self._reference.stamp_ns

    def _recording(self, stamp_ns: int, blocks: tuple[bytes, ...] = ()) -> BaselineRecording:
        """Return a recording of this gearbox until `stamp_ns`."""
        p, model = self._monitor.parameters, self._monitor.model
        return BaselineRecording(stamp_ns, p.gearbox_serial, (p.motor_joint, p.arm_joint),
                                 json.loads(json.dumps(model.to_dict())), blocks)

    def _loaded(self, recording_ns: int) -> BaselineRecording | None:
        """Return the recording beside the state of drift, None without one that belongs to it."""
        if self._file is None or not self._file.readable:
            return None
        path = self._file.recording
        try:
            recording = load_recording(path)
            if recording is not None:
                check_belongs(path, recording, self._recording(recording_ns))
            return recording
        except InputError as error:
            self.note = f'{error}: {_aside(path)}'
            return None

    # ------------------------------------------------------------------ the baseline recording

    def window(self) -> None:
        """Take the newest window of drift: keep a recording once windows were healthy so long."""
        health = self._monitor.health
        if health.stamp_ns == self._window_ns:
            return
        self._window_ns = health.stamp_ns
        if health.alerts or health.pause is None and not (health.trusted and health.compared):
            self._healthy = 0
        elif health.pause is None:
            self._healthy += 1
        needed = math.ceil(HEALTHY / self._monitor.parameters.drift_window)
        if self._reference is None and self._healthy >= needed:
            self._keep()

    def accept(self) -> None:
        """
        Take the drive for healthy, as a saved baseline does.

        The newest rows become the baseline recording, unless the drive rests: then the next
        healthy minute does. An alert that waits for its rows is dropped.
        """
        self._due, self._reference, self._healthy = None, None, 0
        self._interval = MISMATCH_INTERVAL
        pause = self._monitor.health.pause
        if pause is None or pause.friction is not None:
            self._keep()

    def _keep(self) -> None:
        """Keep the newest rows as the baseline recording."""
        if self._buffer is None or not self._buffer.newest_ns:
            return
        self._reference = self._recording(self._buffer.newest_ns,
                                          tuple(self._buffer.blocks(HEALTHY)()))
        self.note = ''
        if self._file is not None:
            self._file.keep_recording(self._reference.to_bytes)

    # ------------------------------------------------------------------ naming

    def look(self) -> tuple[Outcome, dict[str, Any] | None]:
        """Return what to say now, and the verdict if it has just come."""
        self._find_alert()
        new = self._finished()
        if self._due is not None and (self._job is None or self._job[1].done()):
            self._begin(self._due)
        return self._outcome(), new

    def _find_alert(self) -> None:
        health, p = self._monitor.health, self._monitor.parameters
        stages = {test: stage for tests in health.stages().values()
                  for test, stage in tests.items()}
        grown = [test for test, stage in stages.items()
                 if stage > self._stages.get(test, 0) and not test.startswith(SLIP)]
        self._stages = stages
        if grown:
            self._due = NamingAlert(', '.join(grown), max(
                health.alerts[test].since_ns if test in health.alerts else health.stamp_ns
                for test in grown), frozenset(stages))
            return
        level, since_ns = self._monitor.model_lasts
        stamp_ns = self._monitor.stamp_ns
        lasts = level > Level.OK and stamp_ns - since_ns >= p.name_changes_after * SECOND
        if lasts and since_ns != self._mismatch_ns and not 0 <= stamp_ns - \
                self._mismatch_named_ns < self._interval * SECOND:
            self._mismatch_ns, self._mismatch_named_ns = since_ns, stamp_ns
            self._due = self._due or NamingAlert(MISMATCH, since_ns, frozenset((MISMATCH,)))

    def _begin(self, alert: NamingAlert) -> None:
        """Have a change named, once there are enough rows since it came."""
        p, buffer, reference = self._monitor.parameters, self._buffer, self._reference
        if buffer is None or reference is None:
            self._due, self._alert, self._verdict = None, alert, None
            self._problem = f'its cause cannot be named: {self._lacking()}'
            return
        newest_ns = buffer.newest_ns
        since_ns = buffer.first_ns
        if alert.since_ns <= newest_ns:  # else it is from before a clock was set back
            since_ns = max(alert.since_ns, since_ns)
        if newest_ns - since_ns < COMPARED * SECOND:
            return
        self._due, self._alert, self._problem = None, alert, ''
        self._mismatch_ns = self._monitor.model_lasts[1]  # one that stands is named with it
        # When a change began is an estimate; the newest rows show it for certain.
        since_ns = max(since_ns, newest_ns - round(HEALTHY * SECOND))
        order = Order(
            reference, buffer.blocks(60.0 * p.keep_minutes),
            self._monitor.estimator.drive.arm_load, p.effort_delay, since_ns, COMPARED,
            round(p.name_changes_cpu), p.name_changes_memory)
        self._job = order, self._namer.submit(order)

    def _finished(self) -> dict[str, Any] | None:
        """Return the verdict of a job that has just ended, None without."""
        alert = self._alert
        if self._job is None or alert is None or not self._job[1].done():
            return None
        (order, future), self._job = self._job, None
        if alert.reason == MISMATCH:
            self._interval = min(2.0 * self._interval, LONGEST_INTERVAL)
        if (error := future.exception()) is not None:  # whatever it is, the estimates go on
            self._verdict, self._problem = None, str(error) or type(error).__name__
            return None
        verdict = future.result()
        self._verdict = {
            'gearbox_serial': order.reference.gearbox_serial, 'alert': alert.reason,
            'since': when(alert.since_ns), 'since_ns': alert.since_ns,
            'baseline_recording_ns': order.reference.stamp_ns, **verdict}
        if alert.reason == MISMATCH and self._warmth_alone(verdict, order.since_ns):
            words = '(warm-up?)' if self._monitor.health.temperature is None else \
                'as temperature has it'
            self._verdict |= {
                'verdict': kind_of(False, verdict['remainder'] is not None), 'findings': [],
                'text': f'no wear, friction {words}: {verdict["text"]}'}
        if self._verdict['findings']:
            self._interval = MISMATCH_INTERVAL
        return self._verdict

    def _warmth_alone(self, verdict: Mapping[str, Any], since_ns: int) -> bool:
        """
        Return whether all that a verdict names is friction, which has not worn.

        Args:
            verdict: with its findings.
            since_ns: first stamp of the rows it rests on; a window since then told the friction.
        """
        health, effects = self._monitor.health, {f['effect'] for f in verdict['findings']}
        return (bool(effects) and effects <= WARMTH and not health.stages()['friction']
                and health.features[FRICTION].compared_ns >= since_ns)

    def _lacking(self) -> str:
        """Return why there is nothing to compare with."""
        if self._buffer is None:
            return 'keep_minutes is 0, expected more'
        return ('no healthy minute was recorded before; after a repair call '
                '~/save_baseline') + (f' ({self.note})' if self.note else '')

    def _stands(self) -> bool:
        """Return whether a cause of the newest alert is still there."""
        present = {*self._stages}
        if self._monitor.model_lasts[0] > Level.OK:
            present.add(MISMATCH)
        return self._alert is not None and not present.isdisjoint(self._alert.causes)

    def _outcome(self) -> Outcome:
        values: dict[str, Any] = {}
        if self._reference is not None:
            values['baseline_recording'] = when(self._reference.stamp_ns)
        if self._alert is not None:
            values |= {'alert': self._alert.reason, 'since': when(self._alert.since_ns)}
        over = '' if self._stands() else 'over: '
        if self._due is not None:
            return Outcome.of(Level.OK, 'change_due', values, change=_in_words(self._due),
                              seconds=COMPARED)
        if self._job is not None:
            return Outcome.of(Level.OK, 'change_naming', values, change=_in_words(self._alert))
        if self._problem:
            return Outcome.of(Level.OK if over else Level.WARN, 'change_problem', values,
                              over=over, change=_in_words(self._alert), problem=self._problem)
        if self._verdict is not None:
            return _named(self._verdict, over, values)
        if self._buffer is None:
            return Outcome.of(Level.OK, 'changes_not_named', values, why=self._lacking())
        if self._reference is None:
            outcome = Outcome.of(Level.WARN if self.note else Level.OK, 'needs_baseline', values,
                                 seconds=HEALTHY)
            return outcome.followed_by('as_written', text=self.note) if self.note else outcome
        return Outcome.of(Level.OK, 'no_alert', values)


def _named(verdict: Mapping[str, Any], over: str, values: dict[str, Any]) -> Outcome:
    values |= {
        'verdict': verdict['verdict'],
        'effect': '+'.join(f['effect'] for f in verdict['findings']),
        'model_holds': int(verdict['model_holds']), 'cpu_s': float(verdict['cpu_s'])}
    none = bool(over) or verdict['verdict'] == NONE
    return Outcome.of(Level.OK if none else Level.WARN, 'change_named', values, over=over,
                      text=verdict['text'], since='' if none else f', since {verdict["since"]}')


def _in_words(alert: NamingAlert | None) -> str:
    return '' if alert is None else ', '.join(
        _CHANGES.get(test, test) for test in alert.reason.split(', '))


def _aside(path: Path) -> str:
    """Set a recording aside; return what to report."""
    try:
        return set_aside(path, 'refused')
    except InputError as error:
        return str(error)


# ---------------------------------------------------------------------- the child


def limit(order: Mapping[str, Any]) -> None:
    """Give way to all others, within the limits of an `order`, and end with its parent."""
    if not end_with(order['parent'], signal.SIGKILL):
        sys.exit(FAILED)
    os.nice(NICE)
    cpu, memory = order['cpu_seconds'], order['memory'] << 20
    for kind, soft, hard in ((resource.RLIMIT_CORE, 0, 0), (resource.RLIMIT_CPU, cpu, cpu + 5),
                             (resource.RLIMIT_AS, memory, memory)):
        _, ceiling = resource.getrlimit(kind)
        if ceiling != resource.RLIM_INFINITY:
            soft, hard = min(soft, ceiling), min(hard, ceiling)
        resource.setrlimit(kind, (soft, hard))


def verdict_of(order: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return the verdict on the recordings of an `order`, as plain data.

    Raises:
        InputError: a recording allows no statement; Undecided: none is possible.
    """
    from gearbox_monitor.diagnosis.joint.diagnose import diagnose_change
    from gearbox_monitor.report.words import change_sentence
    parts = []
    for name, blocks, since_ns in (('baseline recording', order['reference'], 0),
                                   ('recording', order['later'], order['since_ns'])):
        rows = with_effort_moved(unpacked_rows(blocks, since_ns), order['effort_delay'])
        if not rows['good'].any():
            raise InputError(f'{name}: no samples, expected them: nothing is named')
        parts.append((name, rows))
    model = model_from_dict(order['model'], 'model')
    loads = {load_of(rows, model, order['arm_load']) for _, rows in parts}
    model = model.with_(arm_load=loads.pop() if len(loads) == 1 else 'unknown')
    baseline, later = (recording_of(rows, model, name, order['seconds']) for name, rows in parts)
    verdict = diagnose_change(baseline, later, model).to_dict()
    usage, rows = resource.getrusage(resource.RUSAGE_SELF), parts[1][1]
    begin = float(rows['stamp_ns'][rows['good']][0]) / SECOND + later.begin
    return {**verdict, 'text': change_sentence(verdict), 'cpu_s': usage.ru_utime + usage.ru_stime,
            'recording': [begin, begin + later.duration]}


def main() -> int:
    """Name what the standard input asks for."""
    order = pickle.load(sys.stdin.buffer)  # noqa: S301 - of the node, whose child this is
    limit(order)
    try:
        verdict = verdict_of(order)
    except InputError as error:
        print(' '.join(str(error).split()), file=sys.stderr)
        return FAILED
    json.dump(verdict, sys.stdout)
    return 0


if __name__ == '__main__':
    sys.exit(main())
