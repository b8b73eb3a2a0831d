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

"""A simulated drive that feeds live estimators, and takes back what they publish."""
import itertools
import struct
import time

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.drive.excitation import Excitation
from gearbox_monitor.drive.model import DriveModel
from gearbox_monitor.drive.simulate import Noise, Plant
from gearbox_monitor.monitor import Samples
from gearbox_monitor.nodes.runtime import drain, PolledCallbackGroup
from gearbox_monitor.nodes.watcher import level_of
from gearbox_monitor.parameters import defaults, PLANT
from gearbox_monitor.signals import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, MOTOR, SNAPSHOT)

SECOND = 1_000_000_000
CHUNK = 500      # samples that are simulated at once
ESTIMATES = 'transmission_state'
DEPTH = 20_000   # estimates that may wait here
TAKE = 0.01      # s between two looks at them
LATCHED = QoSProfile(depth=16, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SILENCE = 2.0    # s without an estimate: no more will come
STAMP = struct.Struct('<iI')


def simulated(rate, seed=0):
    """Yield (u [N], y [N, 2]) of the packaged drive without end, CHUNK samples at a time."""
    values = defaults(PLANT)
    plant = Plant(DriveModel(), Noise(tuple(values['process_noise']),
                                      tuple(values['measurement_noise'])), seed)
    for begin in itertools.count(0, CHUNK):
        run = plant.run(Excitation().torque((begin + np.arange(CHUNK)) / rate), 1.0 / rate,
                        begin / rate)
        yield run.u, run.y


def recording(rate, seconds):
    """Return Samples of what simulated() yields."""
    chunks = itertools.islice(simulated(rate), int(np.ceil(seconds * rate / CHUNK)))
    u, y = (np.concatenate(column) for column in zip(*chunks))
    stamps = SECOND + np.round(np.arange(len(u)) * SECOND / rate).astype(np.int64)
    return Samples(stamps, np.column_stack([u, np.full(len(u), np.nan)]), y)


class Source:
    """
    Publishes the same samples in each of `namespaces`, and takes the estimates made of them.

    For each namespace: taken, how many estimates have come; unseen, how many more were published
    and did not come here; latencies, s from sending a sample to publishing its estimate. sent:
    samples, of each namespace. late: samples sent more than a period after their time. findings
    {status name: (level, {key: text})} of the newest diagnostics; not_ok [(clock, status name,
    message)] of all; alerts: texts of drift alerts above OK.
    """

    def __init__(self, domain, namespaces):
        self.namespaces = namespaces
        self._context = rclpy.Context()
        rclpy.init(args=['--ros-args', '--disable-external-lib-logs'], context=self._context,
                   domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node('source', context=self._context, enable_rosout=False,
                          start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._ready, self.findings, self.not_ok, self.alerts = set(), {}, [], []
        polled, subscribe = PolledCallbackGroup(), self._node.create_subscription
        self._outputs, self._inputs = [], []
        for name in namespaces:
            self._outputs.append(self._node.create_publisher(
                JointState, f'{name}/{JOINT_STATES}', 100))
            self._inputs.append(subscribe(
                JointState, f'{name}/{ESTIMATES}', lambda message: None, DEPTH, raw=True,
                callback_group=polled))
            subscribe(DiagnosticArray, f'{name}/estimator/{SNAPSHOT}',
                      lambda message, name=name: self._ready.add(name), LATCHED)
            subscribe(DiagnosticArray, f'{name}/{DRIFT_ALERTS}', self._on_alert, LATCHED)
        subscribe(DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, 10 * len(namespaces))
        self._stamp = time.time_ns()
        self.sent = self.late = 0
        self.begin(1000.0)

    # ------------------------------------------------------------------ what comes back

    def _on_alert(self, message):
        self.alerts += [f'{s.name}: {s.message}' for s in message.status if level_of(s)]

    def _on_diagnostics(self, message):
        for status in message.status:
            self.findings[status.name] = (
                level_of(status), {value.key: value.value for value in status.values})
            if level_of(status):
                self.not_ok.append((time.monotonic(), status.name, status.message))

    def spin(self, seconds):
        """Take diagnostics for `seconds`."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def ready(self):
        """Return whether all estimators are there and connected both ways."""
        return len(self._ready) == len(self.namespaces) and all(
            output.get_subscription_count() and estimates.get_publisher_count()
            for output, estimates in zip(self._outputs, self._inputs))

    def lost(self):
        """Return how many messages the estimators say were lost, in all."""
        return sum(int(values.get('messages_lost', 0)) for name, (_, values)
                   in self.findings.items() if name.endswith('estimator: input'))

    def take(self):
        """Take the estimates that wait."""
        for k, estimates in enumerate(self._inputs):
            numbers, latencies, sent = self._numbers, self.latencies[k], self._sent[k]
            for data, info in drain(estimates):
                seconds, nanoseconds = STAMP.unpack_from(data, 4)
                number = info['publication_sequence_number']
                if numbers[k] is not None:
                    self.unseen[k] += number - numbers[k] - 1
                numbers[k] = number
                n = round((seconds * SECOND + nanoseconds - self._start) / self._period)
                if n in sent:
                    self.taken[k] += 1
                    latencies.append(1e-9 * (info['source_timestamp'] - sent.pop(n)))

    # ------------------------------------------------------------------ what is sent

    def begin(self, rate):
        """Begin a measurement at `rate` (Hz): counters at zero, the drive at rest."""
        count = len(self.namespaces)
        self._rows, self._period = self._messages(rate), SECOND / rate
        self.rate = rate
        # Later than all before, far enough for a new start of the filter.
        self._start = max(time.time_ns(), self._stamp + SECOND)
        self.sent = self.late = 0
        self._numbers, self.taken, self.unseen = [None] * count, [0] * count, [0] * count
        self.latencies, self._sent = [[] for _ in range(count)], [{} for _ in range(count)]

    def _messages(self, rate):
        n = 0
        for u, y in simulated(rate):
            stamps = self._start + np.round((n + np.arange(len(u))) * SECOND / rate).astype(
                np.int64)
            n += len(u)
            self._stamp = int(stamps[-1])
            yield from encode_joint_states(
                stamps, (MOTOR, ARM), y,
                effort=np.column_stack([u, np.full(len(u), np.nan)]))

    def _send(self):
        message = next(self._rows)
        for sent, output in zip(self._sent, self._outputs):
            sent[self.sent] = time.time_ns()
            output.publish(message)
        self.sent += 1

    def in_real_time(self, seconds, tick=None):
        """Send for `seconds`, each sample at its time; tick() is called once per second."""
        begin, count, period = time.monotonic(), round(seconds * self.rate), 1.0 / self.rate
        first, take_at, tick_at = self.sent, begin, begin + 1.0
        while self.sent - first < count:
            due = begin + (self.sent - first) * period
            wait = due - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            elif -wait > period:
                self.late += 1
            self._send()
            now = time.monotonic()
            if now >= take_at:
                self.take()
                self._executor.spin_once(timeout_sec=0.0)
                take_at = now + TAKE
            if tick and now >= tick_at:
                tick()
                tick_at += 1.0

    def as_fast_as_taken(self, count, window, tick=None):
        """Send `count` samples; at most `window` of them wait for their estimate."""
        last, tick_at = self.sent + count, time.monotonic() + 1.0
        heard = time.monotonic()
        while self.sent < last:
            before = sum(self.taken)
            while self.sent < last and len(self._sent[0]) < window:
                self._send()
            self.take()
            now = time.monotonic()
            if sum(self.taken) != before:
                heard = now
            elif now > heard + SILENCE:  # they were lost: go on without them
                self.give_up()
            else:
                time.sleep(0.001)
            if now >= tick_at:
                self._executor.spin_once(timeout_sec=0.0)
                if tick:
                    tick()
                tick_at += 1.0

    def give_up(self):
        """Wait no more for the estimates of what was sent."""
        for sent in self._sent:
            sent.clear()

    def finish(self):
        """Take what still comes, and the diagnostics that tell of it."""
        heard, before = time.monotonic(), -1
        while time.monotonic() < heard + SILENCE:
            if sum(self.taken) + sum(self.unseen) != before:
                heard, before = time.monotonic(), sum(self.taken) + sum(self.unseen)
            self.spin(0.05)
            self.take()

    def missing(self):
        """Return how many samples have given no estimate, but for the first of each start."""
        return sum(self.sent - 1 - taken - unseen
                   for taken, unseen in zip(self.taken, self.unseen))

    def close(self):
        """Leave the domain."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)
