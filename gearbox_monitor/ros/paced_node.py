# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Declare a table of parameters on a node, with units, ranges and what may change at run time."""
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
import math
import time
from typing import Any

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import (
    FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult)
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import FIXED, ParameterRow, ParameterValue, RESTART
from gearbox_monitor.recordings.topics import JOINT_STATES, PLANT_TRANSMISSION_STATE
from gearbox_monitor.removed import refusal
from gearbox_monitor.ros.runtime import advertise, finish, steady_timer


class TableNode(Node):
    """Node that tells what to do when it refuses a parameter that is read at the start only."""

    def set_parameters_atomically(
            self, parameter_list: list[RosParameter]) -> SetParametersResult:
        """Set the parameters of `parameter_list`, all or none, as rclpy does."""
        result = super().set_parameters_atomically(parameter_list)
        fixed = [p.name for p in parameter_list
                 if self.has_parameter(p.name) and self.describe_parameter(p.name).read_only]
        if fixed and not result.successful:
            result.reason = (f'{", ".join(fixed)}: read-only while the node runs; change it in '
                             f'the parameter file (or with -p) and start {self.get_name()} again')
        return result

    def warn_of_unknown(self) -> None:
        """Warn of parameters that the user sets and the node does not have: misspelt ones."""
        unknown = [name for name in self._parameter_overrides if not self.has_parameter(name)]
        if unknown:
            self.get_logger().warning(
                f'no parameters of this node, ignored: {", ".join(sorted(unknown))}')


def _descriptor(row: ParameterRow) -> ParameterDescriptor:
    unit = f' [{row.unit}]' if row.unit else ''
    constraints = ['expected ' + row.expected()] if row.choices or row.kind is tuple else []
    constraints += {FIXED: ['read at the start only'],
                    RESTART: ['a change restarts the filter']}.get(row.change, [])
    descriptor = ParameterDescriptor(
        description=f'{row.description}{unit}', read_only=row.change == FIXED,
        additional_constraints='; '.join(constraints))
    # Open ends would become NaN steps in a range message: leave the range out there.
    if math.isfinite(row.low) and math.isfinite(row.high):
        if row.kind is float:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(row.low), to_value=float(row.high))]
        elif row.kind is int:
            descriptor.integer_range = [
                IntegerRange(from_value=int(row.low), to_value=int(row.high))]
    return descriptor


def declare(node: Node, table: Iterable[ParameterRow]) -> dict[str, ParameterValue]:
    """
    Declare every row of `table` on `node` and return {name: value}.

    Raises InputError if an override has a wrong type, is out of range, or has a name that is gone.
    """
    table = list(table)
    names = {row.name for row in table}
    gone = [f'node {node.get_name()}: {name}: {text}' for name in node._parameter_overrides
            if name not in names and (text := refusal(name.rpartition('.')[2]))]
    if gone:
        raise InputError(*gone)
    values: dict[str, ParameterValue] = {}
    for row in table:
        default = row.default
        # An integer in a YAML file is a good float; rclpy would refuse its type.
        override = node._parameter_overrides.get(row.name)
        if override is not None:
            row.check(_plain(override.value), f'node {node.get_name()}')
            if row.kind is float and isinstance(override.value, int):
                node._parameter_overrides[row.name] = RosParameter(
                    row.name, RosParameter.Type.DOUBLE, float(override.value))
        try:
            value = node.declare_parameter(row.name, _plain(default), _descriptor(row)).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f'node {node.get_name()}: {row.name}: {error}, expected '
                             f'{row.expected()}') from None
        values[row.name] = row.check(_plain(value), f'node {node.get_name()}')
    return values


def on_change(node: Node, table: Iterable[ParameterRow],
              apply: Callable[[Mapping[str, ParameterValue]], None]) -> None:
    """
    Let parameters change at run time: check all of them, then apply them.

    Args:
        node: whose parameters they are.
        table: of the parameters.
        apply: takes {name: value}; the text of an InputError that it raises becomes the reason of
            the refusal.

    """
    rows = {row.name: row for row in table}

    def callback(parameters: list[RosParameter]) -> SetParametersResult:
        try:
            changes = {p.name: rows[p.name].check(_plain(p.value), node.get_name())
                       for p in parameters if p.name in rows}
            if changes:
                apply(changes)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(callback)


def _plain(value: Any) -> Any:
    """Return `value` with tuples, and arrays of the message layer, as lists."""
    return list(value) if isinstance(value, tuple) or hasattr(value, 'tolist') else value


SECOND = 1_000_000_000
BLOCK_TIME = 0.01     # s between two checks for services: the wait for a changed parameter
FREE_RUN_BLOCK = 50   # samples, when there is no pace
REPORT_PERIOD = 10.0  # s between two reports of overruns
ACKNOWLEDGED = Duration(seconds=5)
QUEUE = 1000          # messages kept for a slow subscriber


class PacedNode(TableNode):
    """
    Base of the simulated plants: calls `simulate` and `send` at the pace of `set_pace`.

    count: samples published; t0_ns: stamp of the first; dt, dt_ns: between two.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.count = self.t0_ns = 0
        self.overruns = 0        # samples published more than one period late
        self.max_delay = 0.0     # s
        self._reported, self._report_at = 0, 0.0
        self._start = 0  # ns of a steady clock, 0: not yet

    def set_pace(self, rate: float, duration: float, subscribers: int, speed: float = 1.0) -> None:
        """
        Set when samples are due.

        Args:
            rate: samples per simulated second.
            duration: simulated time after which the process ends, s; 0: never.
            subscribers: start once the outputs have so many together; 0: at once.
            speed: simulated seconds per second; 0: as fast as possible.

        """
        self.dt_ns = round(SECOND / rate)
        self.dt = self.dt_ns / SECOND
        self._speed, self._expected, self._awaited = speed, round(duration / self.dt), subscribers
        self.block = FREE_RUN_BLOCK if speed == 0 else max(1, round(BLOCK_TIME * rate * speed))

    def begin(self, joints: Sequence[str], truth: Sequence[str]) -> None:
        """Start to work: publish samples of `joints` and, of the names `truth`, the truth."""
        # Reused for every sample: making new ones costs more than sending them.
        self._states, self._truth = JointState(name=joints), JointState(name=truth)
        self._outputs = [advertise(self, JointState, topic, QUEUE)
                         for topic in (JOINT_STATES, PLANT_TRANSMISSION_STATE)]
        # A node timer would follow /clock, which may be this node's own.
        self._timer = steady_timer(self, 1e-3, self._work)

    def publish(self, states: Mapping[str, Sequence[float]], truth: Mapping[str, Sequence[float]]
                ) -> None:
        """Publish `states` and `truth`, {field of JointState: values}, stamped `stamp_ns`."""
        for output, message, fields in zip(
                self._outputs, (self._states, self._truth), (states, truth)):
            stamp(message.header.stamp, self.stamp_ns)
            for field, values in fields.items():
                setattr(message, field, array('d', values))
            output.publish(message)

    def simulate(self, n: int) -> Iterator[tuple[Any, ...]]:
        """Return the next `n` samples."""
        raise NotImplementedError

    def send(self, row: tuple[Any, ...]) -> None:
        """Publish a `row` of `simulate`, stamped `stamp_ns`."""
        raise NotImplementedError

    def begin_block(self) -> None:
        """Do what comes before a block of samples."""

    def most_at_once(self, n: int) -> int:
        """Return how many of `n` samples may be simulated ahead of their time."""
        return n

    @property
    def stamp_ns(self) -> int:
        """Stamp of the next sample."""
        return self.t0_ns + self.count * self.dt_ns

    def _work(self) -> None:
        """Simulate and publish one block of samples, each at its time."""
        if not self._start:
            if sum(out.get_subscription_count() for out in self._outputs) < self._awaited:
                return
            self._start = time.monotonic_ns()
            self.t0_ns = time.time_ns()
        self.begin_block()
        remaining, end = self.block, self._expected
        if end > 0:
            remaining = min(remaining, end - self.count)
        while remaining > 0:
            n = self.most_at_once(remaining)
            for row in self.simulate(n):
                self.wait()
                self.send(row)
                if self.count == 0 and self._awaited:
                    self._await_first()
                self.count += 1
            remaining -= n
        self._report()
        if 0 < end <= self.count:
            finish(self._timer, self._outputs)

    def wait(self) -> None:
        """Sleep until the time of the next sample, counted from the start: no drift."""
        if self._speed == 0:
            return
        deadline = self._start + int(self.count * self.dt_ns / self._speed)
        wait = (deadline - time.monotonic_ns()) / SECOND
        if wait > 0:
            time.sleep(wait)
        elif -wait > self.dt / self._speed:
            self.overruns += 1
            self.max_delay = max(self.max_delay, -wait)

    def _await_first(self) -> None:
        """Wait until all have the first sample: a publisher knows them up to 3 s before."""
        for publisher in self._outputs:
            publisher.wait_for_all_acked(ACKNOWLEDGED)
        self._start = time.monotonic_ns()

    def _report(self) -> None:
        time_s = time.monotonic()
        if self.overruns > self._reported and time_s > self._report_at:
            self.get_logger().warning(self._overrun_text())
            self._reported, self._report_at = self.overruns, time_s + REPORT_PERIOD

    def _overrun_text(self) -> str:
        return (f'{self.overruns} of {self.count} samples were more than a period late, at worst '
                f'{1e3 * self.max_delay:.1f} ms (stamps are not affected)')

    def close(self) -> None:
        """Report how many samples were published."""
        text = f'published {self.count} samples'
        # A logger without /rosout, which is gone when a signal has ended the context.
        get_logger(f'{self.get_name()}_node').info(
            f'{text}; {self._overrun_text()}' if self.overruns else text)


def stamp(time_message: Time, ns: int) -> None:
    """Set `time_message` to `ns`."""
    time_message.sec, time_message.nanosec = divmod(ns, SECOND)
