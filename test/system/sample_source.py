# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A simulated drive that feeds live estimators, and takes back what they publish."""
from dataclasses import dataclass
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
from std_srvs.srv import Trigger

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.health.checks.observability import key_of
from gearbox_monitor.parameters import EstimatorParameters, PlantParameters, with_model_values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.topics import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, MOTOR, SNAPSHOT)
from gearbox_monitor.ros.convert import stamp_of
from gearbox_monitor.ros.live_node import level_of
from gearbox_monitor.ros.runtime import drain, PolledCallbackGroup

SECOND = 1_000_000_000
SUITS = 500.0    # Hz: slower, the packaged drive moves too far from one sample to the next
CHUNK = 500      # samples that are simulated at once
ESTIMATES = 'transmission_state'
DEPTH = 20_000   # estimates that may wait here
PAUSE = 0.4      # s
STALL = 0.5      # s
TAKE = 0.01      # s between two looks at them
FEW, SLOWLY = 50, 0.005  # samples; s between two of them
LOOK = 0.2       # s between two looks at diagnostics
LATCHED = QoSProfile(depth=16, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SILENCE = 2.0    # s without an estimate: those that wait were lost
PATIENCE = 10.0  # s without an estimate: no more will come
# What an estimator counts where a sample gives no estimate.
COUNTERS = ('messages_lost', *(key_of(sample_loop.REASONS[code]) for code in (
    sample_loop.START, sample_loop.ZERO_STAMP, sample_loop.DUPLICATE, sample_loop.BACKWARD,
    sample_loop.JUMP, sample_loop.NO_EFFORT, sample_loop.NO_MEASUREMENT, sample_loop.DIVERGED,
    sample_loop.POSITION_JUMP)))
STAMP = struct.Struct('<iI')


def slowness(rate):
    """Return how many times slower than the packaged drive one is that `rate` (Hz) suits."""
    return max(1.0, SUITS / rate)


def parameters_of(slow):
    """
    Return {name: value} of an estimator of the packaged drive, `slow` times slower.

    All times of the drive, and of its tuning, are stretched alike.
    """
    s, model, usual = slow, DriveModel(), EstimatorParameters()
    return {
        'arm_load': 'none', 'drift_window': s * usual.drift_window,
        'q_std_tau_k': usual.q_std_tau_k / s ** 0.5,
        'p0_std_speed': usual.p0_std_speed / s,
        'q_std_motor_speed': usual.q_std_motor_speed / s ** 1.5,
        'q_std_arm_speed': usual.q_std_arm_speed / s ** 1.5,
        **{name: getattr(model, name) * s ** power for name, power in (
            ('motor_inertia', 2), ('arm_inertia', 2), ('damping', 1), ('viscous_friction', 1),
            ('friction_sharpness', 1))}}


def simulated(rate, slow=1.0, seed=0, changes=None):
    """
    Yield (u [N], y [N, 2]) of that drive without end, CHUNK samples at a time.

    changes {name: value} of its model: what they hold counts from the next chunk on.
    """
    values, s = PlantParameters(), slow
    model, _ = with_model_values(DriveModel(), parameters_of(slow))
    position, speed = values.process_noise[:2], values.process_noise[2:]
    noise = Noise((*(q / s ** 0.5 for q in position), *(q / s ** 1.5 for q in speed)),
                  values.measurement_noise)
    plant, excitation = Plant(model, noise, seed), Excitation()
    for begin in itertools.count(0, CHUNK):
        plant.model = model.with_(**(changes or {}))
        run = plant.run(excitation.torque((begin + np.arange(CHUNK)) / (s * rate)), 1.0 / rate,
                        begin / rate)
        yield run.u, run.y


@dataclass(frozen=True)
class Said:
    """A status of diagnostics: stamp_ns, message, values {key: text}."""

    stamp_ns: int
    message: str
    values: dict


NOTHING_SAID = Said(0, '', {})


class SampleSource:
    """
    Publishes the same samples in each of `namespaces`, and takes the estimates made of them.

    For each namespace, since measure(): taken, how many estimates have come; unseen, how many more
    were published and did not come here; latencies, s from sending a sample to publishing its
    estimate. sent: samples, to each namespace. late: those sent over a period too late. outcomes
    {status name: Said} of the newest diagnostics; not_ok [(stamp ns, status name,
    message)] of all; alerts: texts of drift alerts above OK. pauses [(from, to)]: clock ns without
    a published estimate, where longer than PAUSE. changes: of the drive, see simulated.
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
        self._ready, self.outcomes, self.not_ok, self.alerts = set(), {}, [], []
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
        self._stamp, self.changes = time.time_ns(), {}
        self.pauses, self._published = [], time.time_ns()
        self.begin(1000.0)

    # ------------------------------------------------------------------ what comes back

    def _on_alert(self, message):
        self.alerts += [f'{s.name}: {s.message}' for s in message.status if level_of(s)]

    def _on_diagnostics(self, message):
        for status in message.status:
            self.outcomes[status.name] = Said(
                stamp_of(message), status.message,
                {value.key: value.value for value in status.values})
            if level_of(status):
                self.not_ok.append((stamp_of(message), status.name, status.message))

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

    def save_baseline(self, name):
        """Have the estimator in the namespace `name` take the drive for healthy."""
        client = self._node.create_client(Trigger, f'{name}/estimator/save_baseline')
        client.wait_for_service()
        answer = client.call_async(Trigger.Request())
        self._executor.spin_until_future_complete(answer)
        self._node.destroy_client(client)
        assert answer.result().success, answer.result().message

    def told(self):
        """Return how many samples without estimate the estimators have counted, in all."""
        return sum(int(said.values.get(counter, 0)) for name, said in self.outcomes.items()
                   if name.endswith('estimator: input') for counter in COUNTERS)

    def take(self):
        """Take the estimates that wait."""
        for k, estimates in enumerate(self._inputs):
            numbers, latencies, sent = self._numbers, self.latencies[k], self._sent[k]
            for data, info in drain(estimates):
                seconds, nanoseconds = STAMP.unpack_from(data, 4)
                number = info['publication_sequence_number']
                n = round((seconds * SECOND + nanoseconds - self._start) / self._period)
                if numbers[k] is not None and n > self._first:
                    self.unseen[k] += number - numbers[k] - 1
                numbers[k], self._newest[k] = number, n
                if info['source_timestamp'] - self._published > PAUSE * SECOND:
                    self.pauses.append((self._published, info['source_timestamp']))
                self._published = info['source_timestamp']
                if n in sent:
                    self.taken[k] += 1
                    latencies.append(1e-9 * (info['source_timestamp'] - sent.pop(n)))

    # ------------------------------------------------------------------ what is sent

    def begin(self, rate, slow=1.0):
        """
        Let the drive begin anew, at `rate` (Hz); a filter needs some samples to start.

        slow: how many times slower than the packaged one it is.
        """
        self._rows, self._period = self._messages(rate, slow), SECOND / rate
        self.rate = rate
        # Later than all before, far enough for a new start of the filter.
        self._start = max(time.time_ns(), self._stamp + SECOND)
        self._n, self._newest = 0, [-1] * len(self.namespaces)  # samples sent since, estimated
        self._numbers = [None] * len(self.namespaces)
        self.measure()

    def measure(self):
        """Measure from the next sample on."""
        count, self._first, self.sent, self.late = len(self.namespaces), self._n, 0, 0
        self.taken, self.unseen = [0] * count, [0] * count
        self.latencies, self._sent = [[] for _ in range(count)], [{} for _ in range(count)]

    def _messages(self, rate, slow):
        n = 0
        for u, y in simulated(rate, slow, changes=self.changes):
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
            sent[self._n] = time.time_ns()
            output.publish(message)
        self._n += 1
        self.sent += 1

    def in_real_time(self, seconds, tick=None, every=1.0):
        """Send for `seconds`, each sample at its time; tick() is called `every` so many s."""
        begin, count, period = time.monotonic(), round(seconds * self.rate), 1.0 / self.rate
        first, take_at, besides = self.sent, begin, self._besides(tick, every)
        while self.sent - first < count:
            due = begin + (self.sent - first) * period
            wait = due - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            elif -wait > period:
                self.late += 1
                if -wait > STALL:  # this process stood still: no burst of what it has missed
                    begin -= wait
            self._send()
            now = time.monotonic()
            if now >= take_at:
                self.take()
                take_at = now + TAKE
            besides(now)

    def slowly(self):
        """Send so few samples so slowly that every node takes them."""
        for _ in range(FEW):
            self._send()
            time.sleep(SLOWLY)
        self.take()

    def as_fast_as_taken(self, count, window, tick=None, every=1.0):
        """Send `count` samples; at most `window` of them wait for their estimate."""
        last, heard, besides = self.sent + count, time.monotonic(), self._besides(tick, every)
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
            besides(now)

    def _besides(self, tick, every):
        """Return f(now) that takes some diagnostics and calls tick(), when it is time to."""
        look_at = time.monotonic()
        tick_at = look_at + every

        def besides(now):
            nonlocal look_at, tick_at
            if now >= look_at:
                for _ in range(3):
                    self._executor.spin_once(timeout_sec=0.0)
                look_at = now + LOOK
            if tick and now >= tick_at:
                tick()
                tick_at += every
        return besides

    def give_up(self):
        """Wait no more for the estimates of what was sent."""
        for sent in self._sent:
            sent.clear()

    def finish(self):
        """Take what still comes, until all estimators say that nothing came since."""
        heard, before = time.monotonic(), -1
        while min(self._newest) < self._n - 1 and time.monotonic() < heard + PATIENCE:
            if sum(self.taken) != before:
                heard, before = time.monotonic(), sum(self.taken)
            self.spin(0.05)
            self.take()
        # With silence come the counters of now; those with samples are of the last evaluation.
        ended, end = time.time_ns(), time.monotonic() + PATIENCE
        while time.monotonic() < end and not all(
                said.message.startswith('no data') and said.stamp_ns > ended
                for said in self._said()):
            self.spin(0.05)

    def _said(self):
        names = [f'{name}/estimator: covariance' for name in self.namespaces]
        return [self.outcomes.get(name, NOTHING_SAID) for name in names]

    def missing(self):
        """Return how many samples have given no estimate since measure()."""
        return sum(self.sent - taken - unseen
                   for taken, unseen in zip(self.taken, self.unseen))

    def close(self):
        """Leave the domain."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)
