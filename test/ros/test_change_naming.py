# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The child that names a change: its limits, its queue, its end; no ROS."""
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from gearbox_monitor.files.baselines import BaselineRecording
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.ros.change_watch import ChangeNamer, Order
from gearbox_monitor.ros.recording_export import RecordingBuffer, SECOND

T0 = 1_700_000_000 * SECOND
FILE = DriveModel(gear_ratio=50.0, torque_constant=0.2)


def recorded(model=FILE, seed=1, seconds=6.0, first=0):
    """Return a buffer of the motor's side at 250 Hz."""
    t = np.arange(round(250 * seconds)) * 0.004
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1 + 0.1 * seed)).torque(t)
    y = simulate(model, u, 0.004, Noise(measurement=(0.002, 0.002)), seed).y
    buffer = RecordingBuffer(300.0)
    for k, (torque, (motor, arm)) in enumerate(zip(u.tolist(), y.tolist())):
        buffer.add(T0 + (first + k) * 4_000_000, True, (
            50.0 * motor, arm, torque / FILE.effort_scale, np.nan))
    return buffer


def order(**changes):
    healthy = recorded()
    worn = changes.pop('worn', None) or recorded(
        FILE.with_values({'half_gap': 0.12}), 2, first=10_000)
    return Order(**{
        'reference': BaselineRecording(
            healthy.newest_ns, 'A', ('motor', 'arm'), json.loads(json.dumps(FILE.to_dict())),
            tuple(healthy.blocks(60.0)())),
        'later': worn.blocks(60.0), 'arm_load': 'none', 'effort_delay': 0,
        'since_ns': 0, 'seconds': 5.0, 'cpu_seconds': 300, 'memory': 4000, **changes})


def gone(number):
    """Return whether the process does not run any more."""
    try:
        with open(f'/proc/{number}/stat', encoding='utf-8') as stat:
            return stat.read().rpartition(')')[2].split()[0] == 'Z'
    except FileNotFoundError:
        return True


def child_of(parent):
    """Return the process id of the one child of a process that names changes."""
    while True:
        with open(f'/proc/{parent}/task/{parent}/children', encoding='utf-8') as children:
            numbers = children.read().split()
        for thread in os.listdir(f'/proc/{parent}/task'):
            with open(f'/proc/{parent}/task/{thread}/children', encoding='utf-8') as children:
                numbers += children.read().split()
        for number in numbers:
            with open(f'/proc/{number}/cmdline', encoding='utf-8') as words:
                if 'ros.change_watch' in words.read():
                    return int(number)
        time.sleep(0.01)


def test_a_change_is_named_from_raw_rows_of_both_sides_of_the_gear():
    verdict = ChangeNamer().submit(order()).result()
    (finding,) = verdict['findings']
    assert finding['effect'] == 'backlash_gap'
    assert finding['values'][0]['relative'] == pytest.approx(0.2, abs=0.01)
    assert verdict['text'].startswith('transmission: half backlash 0.100 to 0.120 rad, +')
    assert verdict['text'].endswith('the model file no longer holds')
    begin, end = verdict['recording']
    assert (begin, end) == pytest.approx((1_700_000_041.0, 1_700_000_045.996), abs=0.01)


def test_limits_end_the_child_by_name_and_the_next_order_is_tried():
    """Two wait while one runs, and each fails in its own way."""
    namer = ChangeNamer()
    jobs = [namer.submit(one) for one in (
        order(cpu_seconds=1), order(memory=270), order(since_ns=T0 + 100 * SECOND))]
    said = [str(job.exception()) for job in jobs]
    assert said[0] == 'the diagnosis took more than 1 s of CPU time (name_changes_cpu)'
    assert said[1] == 'the diagnosis took more than 270 MB (name_changes_memory)'
    assert said[2] == 'recording: no samples, expected them: nothing is named'
    namer.close()


def test_no_child_outlives_the_namer():
    namer = ChangeNamer()
    jobs = [namer.submit(order()) for _ in range(2)]
    child = child_of(os.getpid())
    namer.close()
    assert gone(child) and str(jobs[0].exception()) == 'the node ends' and jobs[1].cancelled()


def test_no_child_outlives_a_killed_process():
    code = ('import sys, time\n'
            f'sys.path.insert(0, {os.path.dirname(__file__)!r})\n'
            'import test_change_naming as t\n'
            'namer = t.ChangeNamer()\n'
            'job = namer.submit(t.order())\n'
            'time.sleep(600)\n')
    parent = subprocess.Popen([sys.executable, '-c', code])
    child = child_of(parent.pid)
    # It may not have asked for the signal yet: it looks for its parent afterwards.
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    end = time.monotonic() + 30.0
    while not gone(child) and time.monotonic() < end:
        time.sleep(0.01)
    assert gone(child)
