# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Publishers and subscriptions whose QoS a parameter file can override (``qos_overrides``)."""
from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription

from gearbox_monitor.errors import InputError

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
