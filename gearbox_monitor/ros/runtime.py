# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What nodes share: start and stop of the process, parameters by their table, topics with QoS."""
import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
import contextlib
import gc
import math
import os
from pathlib import Path
import signal
import sys
import time
from typing import Any, NoReturn

from rcl_interfaces.msg import (
    FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult)
import rclpy
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import (
    InvalidParameterTypeException, InvalidParameterValueException, ParameterException)
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from rclpy.utilities import remove_ros_args

from gearbox_monitor.errors import InputError, refusal
from gearbox_monitor.parameters import FIXED, ParameterRow, ParameterValue, RESTART
from gearbox_monitor.ros.middleware import end_with, PARENT, remove_cut_ports

POLICIES = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY,
            QoSPolicyKind.DURABILITY)


def latched() -> QoSProfile:
    """Return the QoS of messages that a late joiner still receives."""
    return QoSProfile(depth=16, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def best_effort(depth: int) -> QoSProfile:
    """Return the QoS of a subscription to any publisher; `depth`: messages that may wait."""
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)


def advertise(node: Node, kind: type, topic: str, qos: QoSProfile | int) -> Publisher:
    """
    Return a publisher whose QoS a parameter file can override.

    Args:
        node: that publishes.
        kind: class of the messages.
        topic: name, resolved by the node.
        qos: profile or depth, which applies where it is not overridden; rclpy changes the profile.

    Returns:
        The publisher.

    Raises:
        InputError: an override is impossible.

    """
    return _made(node, node.create_publisher, kind, topic, qos=qos)


def subscribe(node: Node, kind: type, topic: str, callback: Callable[..., None],
              qos: QoSProfile | int, policies: Iterable[QoSPolicyKind] = POLICIES,
              **options: Any) -> Subscription:
    """
    Return a subscription whose QoS a parameter file can override.

    Args:
        node: that subscribes.
        kind: class of the messages.
        topic: name, resolved by the node.
        callback: takes each message.
        qos: profile or depth, see advertise.
        policies: that can be overridden.
        options: of Node.create_subscription.

    Returns:
        The subscription.

    Raises:
        InputError: an override is impossible.

    """
    return _made(node, node.create_subscription, kind, topic, callback, qos=qos,
                 policies=policies, **options)


def overridden(node: Node, topic: str) -> list[QoSPolicyKind]:
    """Return the QoS policies that the user of `node` overrides for subscriptions to `topic`."""
    prefix = f'qos_overrides.{topic}.subscription.'
    return [policy for policy in POLICIES
            if prefix + policy.name.lower() in node._parameter_overrides]


def _made(node: Node, create: Callable[..., Any], kind: type, topic: str, *args: Any,
          qos: QoSProfile | int, policies: Iterable[QoSPolicyKind] = POLICIES,
          **options: Any) -> Any:
    qos = QoSProfile(depth=qos) if isinstance(qos, int) else qos
    try:
        return create(kind, topic, *args, qos, **options, qos_overriding_options=(
            QoSOverridingOptions(policies, callback=_possible)))
    except (RuntimeError, InvalidQosOverridesError) as error:
        if not isinstance(error, InvalidQosOverridesError) and 'QoS override' not in str(error):
            raise
        raise InputError(f'node {node.get_name()}: qos_overrides of {topic}: {error}, expected '
                         'a policy of ROS, like "reliability: reliable" or "depth: 10"') from None


def _possible(qos: QoSProfile) -> SetParametersResult:
    good = 1 <= qos.depth < 2 ** 31
    return SetParametersResult(successful=good, reason='' if good else f'depth: {qos.depth}')


RCLError = rclpy_implementation.RCLError
RMWError = rclpy_implementation.RMWError
UnknownROSArgsError = rclpy_implementation.UnknownROSArgsError


EVENT_PERIOD, EVENT_WINDOW = 0.25, 0.01  # s


class PolledCallbackGroup(CallbackGroup):
    """
    Group whose subscriptions the executor leaves alone; :func:`drain` takes their messages.

    Waking an executor costs about 200 us of CPU per message, taking one in a loop about 10 us.
    Event handlers of the subscriptions (message lost, incompatible QoS) run for EVENT_WINDOW
    every EVENT_PERIOD: while the executor waits for an event, each message wakes it, too.
    """

    def __init__(self) -> None:
        super().__init__()
        self._open_until = 0.0

    def can_execute(self, entity: object) -> bool:
        """Return whether the executor may wait for `entity`."""
        if isinstance(entity, Subscription):
            return False
        time_s = time.monotonic()
        if time_s > self._open_until + EVENT_PERIOD:
            self._open_until = time_s + EVENT_WINDOW
        return time_s < self._open_until

    def beginning_execution(self, entity: object) -> bool:
        """Allow the execution of `entity`."""
        return True

    def ending_execution(self, entity: object) -> None:
        """Do nothing after the execution of `entity`."""


def subscribe_polled(node: Node, kind: type, topic: str, qos: QoSProfile | int, **options: Any
                     ) -> Subscription:
    """
    Return a subscription of a PolledCallbackGroup.

    Args:
        node: that subscribes.
        kind: class of the messages.
        topic: name, resolved by the node.
        qos: profile or depth, see qos.subscribe.
        options: of Node.create_subscription.
    """
    return subscribe(node, kind, topic, lambda message: None, qos,
                     callback_group=PolledCallbackGroup(), **options)


def steady_timer(node: Node, period: float, callback: Callable[[], None]) -> Timer:
    """Return the timer that calls `callback` of a `node` every `period` s, whatever its clock."""
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def drain(subscription: Subscription,
          limit: int = 100_000) -> Iterator[tuple[Any, dict[str, Any]]]:
    """
    Yield the waiting messages of a polled `subscription`, oldest first, at most `limit`.

    Yields (message, info): a message object, or its CDR bytes with ``raw=True``; info is a dict
    with ``source_timestamp`` and ``received_timestamp`` in ns.
    """
    handle = subscription.handle
    with handle:
        take, msg_type, raw = handle.take_message, subscription.msg_type, subscription.raw
        for _ in range(limit):
            message_and_info = take(msg_type, raw)
            if message_and_info is None:
                return
            yield message_and_info


class Arrivals:
    """
    Waits for messages of a few `subscriptions` in `context`, instead of the executor.

    A wake-up of the executor goes through all entities of the node, services and events included:
    0.4 ms with seven gearboxes. This one takes 0.02 ms.
    """

    def __init__(self, subscriptions: Sequence[Subscription], context: Context) -> None:
        self._handles, self._context = [s.handle for s in subscriptions], context
        self._wait_set = rclpy_implementation.WaitSet(
            len(self._handles), 0, 0, 0, 0, 0, context.handle)

    def wait(self, seconds: float) -> bool:
        """Wait at most `seconds` for a message; return whether there may be one."""
        with contextlib.ExitStack() as stack:
            for handle in self._handles:
                stack.enter_context(handle)
            self._wait_set.clear_entities()
            for handle in self._handles:
                self._wait_set.add_subscription(handle)
            self._wait_set.wait(round(1e9 * seconds))
            return self._context.ok() and bool(
                self._wait_set.get_ready_entities('subscription'))


def finish(timer: Timer, publishers: Iterable[Publisher]) -> NoReturn:
    """End the process, after all messages of `publishers` have arrived; `timer` called it."""
    timer.cancel()
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=2))
    raise ExternalShutdownException


def alone(node: Node) -> bool:
    """Return whether nothing but the `node` itself waits while one of its callbacks runs."""
    executor = node.executor
    return isinstance(executor, SingleThreadedExecutor) and len(executor.get_nodes()) == 1


def spin_node(factory: Callable[[], Node | list[Node]], args: Sequence[str] | None = None,
              doc: str | None = None,
              make_executor: Callable[[], Executor] = SingleThreadedExecutor) -> int:
    """
    Run nodes until SIGINT, SIGTERM or shutdown; call it from the main thread of the process.

    A node may have ``close()``: it is called once, after spinning, before the node is destroyed;
    it can still take messages then but no longer publish. Bad input (InputError, a parameter or
    argument that rclpy refuses) is one line on stderr. SIGINT stays ignored when this returns.

    Args:
        factory: makes the node, or a list of nodes.
        args: command line (default: that of the process).
        doc: text of ``--help``.
        make_executor: makes the executor that spins them.

    Returns:
        The exit code: 0, or 2 for bad input.

    """
    args = sys.argv if args is None else args
    name = Path(args[0]).stem
    parser = argparse.ArgumentParser(
        prog=name, description=doc, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='ROS arguments follow --ros-args, for example --ros-args --params-file FILE.')
    nodes: list[Node] = []
    code = 0
    _die_with_parent()

    def on_interrupt(*_: object) -> None:
        # Once the node is there rclpy's own handler ends the spinning; an exception on top could
        # hit any line, even of a destructor.
        if not nodes:
            raise KeyboardInterrupt
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_interrupt)  # rclpy calls what it finds here at its start
    sys.unraisablehook = _without_signals
    try:
        _init(args, parser)
        product = factory()
        nodes = product if isinstance(product, list) else [product]
        executor = make_executor()
        for node in nodes:
            executor.add_node(node)
        # Full collections would hold up samples: imports leave many objects.
        gc.collect()
        gc.freeze()
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (InputError, ParameterException) as error:
        code = _refuse(name, error)
    except RCLError as error:
        code = _ended_by(error, name)
    finally:
        # A terminal and ros2 launch send SIGINT twice: the second must not interrupt the end.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        try:
            for node in nodes:
                if hasattr(node, 'close'):
                    node.close()
        except InputError as error:
            code = _refuse(name, error)
        finally:
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return code


def _ended_by(error: Exception, name: str) -> int:
    """Return the exit code after an RCLError, which is raised again if input is not the reason."""
    if not rclpy.ok():  # a signal has ended the context while the node was being made
        return 0
    if 'error creating node' not in str(error):
        raise error
    return _refuse(name, _plain(error))


def _without_signals(unraisable: Any) -> None:
    """
    Ignore errors of operations that a signal has interrupted.

    OSError: of a signal that comes just as it is set to be ignored. AttributeError: of the
    destructor of an object of rclpy that was incomplete when the context ended.
    """
    if rclpy.ok() or not isinstance(unraisable.exc_value, (OSError, AttributeError)):
        sys.__unraisablehook__(unraisable)


def _die_with_parent() -> None:
    """Let Linux send SIGTERM when the parent that the environment names, if any, dies."""
    parent = os.environ.get(PARENT, '')
    if parent.isdigit() and not end_with(int(parent), signal.SIGTERM):
        sys.exit(1)


def _init(args: Sequence[str], parser: argparse.ArgumentParser) -> None:
    """Start rclpy; an argument or parameter file that it cannot read is an InputError."""
    try:
        parser.parse_args(remove_ros_args(args)[1:])
        remove_cut_ports()
        rclpy.init(args=args)
    except UnknownROSArgsError as error:
        raise InputError(f'unknown ROS arguments: {error}') from None
    except RCLError as error:
        raise InputError(_plain(error)) from None


def _plain(error: Exception) -> str:
    """Return the text of an RCLError without the lines of its sources."""
    return str(error).split(', at /')[0]


def _refuse(name: str, error: object) -> int:
    """Print `error` as one line; return the exit code for bad input."""
    print(f'{name}: {" ".join(str(error).split())}', file=sys.stderr)
    return 2


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
            row.check(_listed(override.value), f'node {node.get_name()}')
            if row.kind is float and isinstance(override.value, int):
                node._parameter_overrides[row.name] = RosParameter(
                    row.name, RosParameter.Type.DOUBLE, float(override.value))
        try:
            value = node.declare_parameter(row.name, _listed(default), _descriptor(row)).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f'node {node.get_name()}: {row.name}: {error}, expected '
                             f'{row.expected()}') from None
        values[row.name] = row.check(_listed(value), f'node {node.get_name()}')
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
            changes = {p.name: rows[p.name].check(_listed(p.value), node.get_name())
                       for p in parameters if p.name in rows}
            if changes:
                apply(changes)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(callback)


def _listed(value: Any) -> Any:
    """Return `value` with tuples, and arrays of the message layer, as lists."""
    return list(value) if isinstance(value, tuple) or hasattr(value, 'tolist') else value
