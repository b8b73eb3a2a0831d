# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
All gearboxes of a robot in one estimator node, against a node for each in one process.

With --events the one node is measured with rclpy's EventsExecutor, too.

Simulated drives feed real nodes over DDS, on this machine only, in a ROS domain of its own: all
joints in one message. The nodes have the last core, the source the others. Latency: from sending a
message to publishing the estimate of its last gearbox. The estimates are compared, bit for bit,
with those of a Monitor for each gearbox.

usage examples:
  .venv/bin/python test/system/robot.py
  .venv/bin/python test/system/robot.py --runs 7x1000 20x200 --seconds 20 --json robot.json
"""
import json
import os
import re
import sys
import time

from node_processes import live_nodes, usage
import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from sample_source import parameters_of, simulated, slowness
from script import run_script
from sensor_msgs.msg import JointState

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import resolve
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.ros.convert import stamp_of
from gearbox_monitor.ros.runtime import drain, PolledCallbackGroup

SECOND = 1_000_000_000
ONE, EVENTS, EACH = 'one node', 'one, events', 'a node each'
RUNS, SECONDS = ('7x1000', '20x200'), 10.0
P99, MEMORY, CPU = 0.010, 350e6, 0.5  # s; bytes; of what an estimate costs in a node each
LEAD = 200      # messages before those that count, slowly: filters start
TAKE = 0.01     # s between two looks at the estimates
PATIENCE = 5.0  # s without an estimate: no more will come


def add_arguments(parser):
    parser.add_argument('--runs', nargs='+', default=list(RUNS), metavar='NxHZ',
                        help=f'gearboxes and rate (default: {" ".join(RUNS)})')
    parser.add_argument('--seconds', type=float, default=SECONDS, metavar='S',
                        help='length of each run (default: %(default)s)')
    parser.add_argument('--events', action='store_true',
                        help='measure the EventsExecutor, too')
    add_json_option(parser)


class _Robot:
    """Messages of `number` drives at `rate` (Hz), and what a Monitor makes of each."""

    def __init__(self, number, rate, seconds):
        self.names, self.rate = [f'g{k}' for k in range(number)], rate
        self.settings = parameters_of(slowness(rate))
        n = LEAD + round(seconds * rate)
        self.stamps = time.time_ns() + np.round(np.arange(n) * SECOND / rate).astype(np.int64)
        self.samples = []
        for seed in range(number):
            rows = []
            for u, y in simulated(rate, slowness(rate), seed):
                rows.append((u, y))
                if sum(len(part) for part, _ in rows) >= n:
                    break
            u, y = (np.concatenate(parts)[:n] for parts in zip(*rows))
            self.samples.append(Samples(
                self.stamps, np.column_stack([u, np.full(n, np.nan)]), y))

    def messages(self):
        """Return the serialised messages, all joints in each."""
        joints = [f'{name}_{joint}' for name in self.names for joint in ('motor', 'arm')]
        return encode_joint_states(
            self.stamps, joints, np.hstack([s.y for s in self.samples]),
            effort=np.hstack([s.u for s in self.samples]))

    def parameters(self, layout):
        """Return the blocks of a parameter file."""
        own = {name: {'motor_joint': f'{name}_motor', 'arm_joint': f'{name}_arm'}
               for name in self.names}
        if layout != EACH:
            return {'/estimator': {'ros__parameters': {
                'gearboxes': self.names, **self.settings_of_node(), **{
                    name: {**block, **self.model_values()} for name, block in own.items()}}}}
        return {f'/{name}/estimator': {'ros__parameters': {**self.settings, **block}}
                for name, block in own.items()}

    def model_values(self):
        """Return the values of the model among the settings."""
        return {k: v for k, v in self.settings.items() if hasattr(DriveModel(), k)
                and k != 'arm_load'}

    def settings_of_node(self):
        """Return the others."""
        return {k: v for k, v in self.settings.items() if k not in self.model_values()}

    def tau_k(self):
        """Return [{stamp: tau_K}] of a Monitor for each gearbox."""
        rows = []
        for samples in self.samples:
            estimates = Monitor(*resolve(DriveModel(), self.settings)).run(samples)
            rows.append(dict(zip(estimates.stamp_ns.tolist(), estimates.tau_k.tolist())))
        return rows


class _Source:
    """Publishes the messages of a robot and takes the estimates, in `topics`, of each gearbox."""

    def __init__(self, domain, topics):
        self._context = rclpy.Context()
        rclpy.init(args=['--ros-args', '--disable-external-lib-logs'], context=self._context,
                   domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node('source', context=self._context, enable_rosout=False,
                         start_parameter_services=False)
        polled = PolledCallbackGroup()
        self.output = self.node.create_publisher(JointState, JOINT_STATES, 100)
        self.inputs = [self.node.create_subscription(
            JointState, topic, lambda message: None, 20_000, raw=True, callback_group=polled)
            for topic in topics]
        self.taken = [[] for _ in topics]  # (bytes, source timestamp)

    def ready(self):
        """Return whether the nodes are connected both ways."""
        return self.output.get_subscription_count() == len(self.inputs) and all(
            estimates.get_publisher_count() for estimates in self.inputs)

    def take(self):
        """Take the estimates that wait; return how many came."""
        before = sum(map(len, self.taken))
        for rows, estimates in zip(self.taken, self.inputs):
            rows += [(raw, info['source_timestamp']) for raw, info in drain(estimates)]
        return sum(map(len, self.taken)) - before

    def send(self, messages, rate):
        """Publish `messages` at `rate` (Hz); return the time at which each was sent, ns."""
        sent, begin, take_at = [], time.monotonic(), 0.0
        for k, message in enumerate(messages):
            wait = begin + k / rate - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            sent.append(time.time_ns())
            self.output.publish(message)
            if time.monotonic() > take_at:
                self.take()
                take_at = time.monotonic() + TAKE
        return sent

    def rest(self):
        """Take what still comes."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            time.sleep(0.05)
            if self.take():
                end = time.monotonic() + 1.0

    def close(self):
        """Leave the domain."""
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)


def measured(layout, number, rate, seconds):
    """Return the row of one run."""
    robot = _Robot(number, rate, seconds)
    messages, cores = robot.messages(), sorted(os.sched_getaffinity(0))
    with live_nodes() as nodes:
        file = nodes.folder / 'robot.yaml'
        file.write_text(json.dumps(robot.parameters(layout)))
        ros = ['--ros-args', '--params-file', str(file), '-r', f'joint_states:=/{JOINT_STATES}',
               '--']
        arguments = {ONE: ['/'], EVENTS: ['--events', '/'], EACH: robot.names}[layout]
        child = nodes.start('estimators', 'load_estimators', {}, [*arguments, *ros],
                            cores=cores[-1:])
        source = _Source(nodes.domain, [f'{name}/transmission_state' for name in robot.names]
                         if layout == EACH else ['transmission_state'])
        try:
            os.sched_setaffinity(0, cores[:-1] or cores)
            nodes.until(source.ready, 'a start', lambda: time.sleep(0.1))
            time.sleep(1.0)  # they know the source a while after it knows them
            source.send(messages[:LEAD], 100.0)
            before, began = usage(child.process.pid).cpu, time.monotonic()
            sent = source.send(messages[LEAD:], rate)
            took = time.monotonic() - began
            source.rest()
            used = usage(child.process.pid)
        finally:
            os.sched_setaffinity(0, cores)
            source.close()
    return {'layout': layout, 'number': number, 'rate': rate, 'sent': len(sent) * number,
            'behind': took - seconds, 'cpu': (used.cpu - before) / seconds,
            'memory': used.memory, **_compared(robot, source.taken, sent)}


def _compared(robot, taken, sent):
    """Return what came of the messages `sent`: dropped, different, p50, p99, max."""
    sent_at = dict(zip(robot.stamps[LEAD:].tolist(), sent))
    expected, came, different, last = robot.tau_k(), 0, 0, {}
    for k, rows in enumerate(taken):
        for raw, published in rows:
            message = deserialize_message(raw, JointState)
            stamp = stamp_of(message)
            if stamp not in sent_at:
                continue
            last[stamp] = max(last.get(stamp, 0), published)
            for name, tau_k in zip(message.name, message.effort):
                gearbox = k if len(taken) > 1 else robot.names.index(name)
                came += 1
                different += tau_k != expected[gearbox].get(stamp)
    latency = np.array([1e-9 * (published - sent_at[stamp]) for stamp, published in last.items()])
    p50, p99, most = np.quantile(latency, (0.5, 0.99, 1.0)) if len(latency) else [np.nan] * 3
    return {'dropped': len(sent) * len(robot.names) - came, 'different': different,
            'p50': float(p50), 'p99': float(p99), 'max': float(most)}


def _cpu_per_estimate(row):
    """Return the CPU seconds that an estimate takes: a saturated core makes fewer of them."""
    estimates, seconds = row['sent'] - row['dropped'], row['sent'] / (row['number'] * row['rate'])
    return row['cpu'] * seconds / estimates if estimates else np.inf


def bars(rows):
    """Return the rows of a BarTable for the runs `rows`."""
    table = BarTable()
    for one, each in ((row, other) for row in rows for other in rows if row['layout'] == ONE
                      and other['layout'] == EACH
                      and (row['number'], row['rate']) == (other['number'], other['rate'])):
        run = f'{one["number"]} gearboxes, {one["rate"]:g} Hz'
        share = _cpu_per_estimate(one) / _cpu_per_estimate(each)
        for what, value, limit, good in (
                ('samples dropped', f'{one["dropped"]}', '0', not one['dropped']),
                ('estimates that differ', f'{one["different"]}', '0', not one['different']),
                ('p99 of latency', f'{1e3 * one["p99"]:.2f} ms', f'<= {1e3 * P99:g} ms',
                 one['p99'] <= P99),
                ('memory', f'{1e-6 * one["memory"]:.0f} MB', f'<= {1e-6 * MEMORY:g} MB',
                 one['memory'] <= MEMORY),
                ('CPU per estimate, share of a node each', f'{share:.2f}', f'<= {CPU:g}',
                 share <= CPU)):
            table.check(f'{run}: {what}', value, limit, good)
    return table.rows


def text(data):
    """Return the figures as a table for the terminal."""
    lines = ['  layout         number    Hz   dropped   differ    p50 ms    p99 ms    max ms'
             '  CPU s/s data memory MB  behind s']
    lines += [f'  {row["layout"]:<12}{row["number"]:9d}{row["rate"]:6g}{row["dropped"]:10d}'
              f'{row["different"]:9d}{1e3 * row["p50"]:10.2f}{1e3 * row["p99"]:10.2f}'
              f'{1e3 * row["max"]:10.1f}{row["cpu"]:13.2f}{1e-6 * row["memory"]:11.0f}'
              f'{row["behind"]:10.1f}' for row in data['runs']]
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    matches = [re.fullmatch(r'([1-9]\d?)x([1-9]\d{0,3})', run) for run in args.runs]
    if not all(matches):
        raise InputError(f'--runs: {" ".join(args.runs)}, expected texts like 7x1000')
    if not 0.0 < args.seconds < np.inf:
        raise InputError(f'--seconds: {args.seconds:g}, expected > 0')
    expect_folder_of(args.json)
    rows = [measured(layout, int(match[1]), float(match[2]), args.seconds)
            for match in matches
            for layout in (ONE, *([EVENTS] if args.events else []), EACH)]
    data = {'seconds': args.seconds, 'cores': os.cpu_count(), 'runs': rows, 'bars': bars(rows)}
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
