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

"""Publishers and subscriptions whose QoS a parameter file can override (``qos_overrides``)."""
from rcl_interfaces.msg import SetParametersResult
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions

from gearbox_monitor.errors import InputError

POLICIES = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY,
            QoSPolicyKind.DURABILITY)


def latched():
    """Return the QoS of what a late joiner still gets."""
    return QoSProfile(depth=16, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def best_effort(depth):
    """Return the QoS of a subscription that takes from every publisher."""
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)


def advertise(node, kind, topic, qos):
    """
    Return a publisher of `kind`; what of `qos` (QoSProfile or depth) is not overridden applies.

    rclpy changes the QoSProfile. Raises InputError for an override that cannot be.
    """
    return _made(node, node.create_publisher, kind, topic, qos=qos)


def subscribe(node, kind, topic, callback, qos, policies=POLICIES, **more):
    """Return a subscription, see advertise; `policies`: those that can be overridden."""
    return _made(node, node.create_subscription, kind, topic, callback, qos=qos,
                 policies=policies, **more)


def overridden(node, topic):
    """Return the QoSPolicyKinds that the user overrides for subscriptions to `topic`."""
    prefix = f'qos_overrides.{topic}.subscription.'
    return [policy for policy in POLICIES
            if prefix + policy.name.lower() in node._parameter_overrides]


def _made(node, create, kind, topic, *args, qos, policies=POLICIES, **more):
    qos = QoSProfile(depth=qos) if isinstance(qos, int) else qos
    try:
        return create(kind, topic, *args, qos, **more, qos_overriding_options=QoSOverridingOptions(
            policies, callback=_possible))
    except (RuntimeError, InvalidQosOverridesError) as error:
        if not isinstance(error, InvalidQosOverridesError) and 'QoS override' not in str(error):
            raise
        raise InputError(f'node {node.get_name()}: qos_overrides of {topic}: {error}, expected '
                         'a policy of ROS, like "reliability: reliable" or "depth: 10"') from None


def _possible(qos):
    good = 1 <= qos.depth < 2 ** 31
    return SetParametersResult(successful=good, reason='' if good else f'depth: {qos.depth}')
