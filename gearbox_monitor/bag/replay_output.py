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

"""Write a replay as a bag: the recording's own topics and the estimates, as if published live."""
import heapq
import json

import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.replay import DIAGNOSTIC_ARRAY, JOINT_STATE, signal_values
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.jit import KERNELS
from gearbox_monitor.monitor import Monitor
from gearbox_monitor.signals import ARM, MOTOR, SIGNALS, SNAPSHOT


def write_bag(path, reader, result):
    """
    Write `result` (replay.Replay) of the bag `reader` to the new bag `path`.

    A replay of that bag gives the same estimates: it holds the snapshots they started from.
    """
    namespace = result.recording.namespace
    ours = {f'{namespace}/{signal.topic}' for signal in SIGNALS}
    # What the live estimator said besides belongs to its estimates, not to these.
    said = {'/diagnostics', f'{namespace}/drift_alerts'}
    again = result.comparison is not None  # the recorded snapshots apply
    keep = [topic for topic in reader.topics if topic not in ours | said
            and (again or not topic.endswith('/snapshot'))]
    with BagWriter(path) as writer:
        writer.add_metadata('gearbox_monitor', {
            'version': __version__, 'replayed_from': str(reader.path),
            'parameters': json.dumps(result.monitor.parameters),
            'model': json.dumps(result.monitor.model.to_dict())})
        for topic in keep:
            writer.add_topic(topic, reader.topics[topic][0])
        for topic in sorted(ours):
            writer.add_topic(topic, JOINT_STATE)
        if not again:
            _write_snapshot(writer, reader, result)
        streams = [reader.messages(keep)] + [_messages(signal, result) for signal in SIGNALS]
        for topic, log_ns, publish_ns, raw in heapq.merge(*streams, key=lambda m: m[1]):
            writer.write(topic, log_ns, raw, publish_ns)


def _write_snapshot(writer, reader, result):
    """Write the state before the first sample."""
    topic = f'{result.recording.namespace}/estimator/{SNAPSHOT}'
    types = get_typestore(Stores.ROS2_JAZZY).types
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')
    content = {'reason': 'start', 'version': __version__, 'kernels': KERNELS,
               **Monitor(result.monitor.model, result.monitor.parameters).snapshot()}
    status = types['diagnostic_msgs/msg/DiagnosticStatus'](
        0, 'estimator: snapshot', 'what replay starts from',
        result.monitor.parameters['gearbox_serial'],
        [types['diagnostic_msgs/msg/KeyValue'](key, value) for key, value in content.items()])
    writer.add_topic(topic, DIAGNOSTIC_ARRAY)
    writer.write_message(topic, reader.start_ns or 0, types[DIAGNOSTIC_ARRAY](header, [status]))


def _messages(signal, result):
    """Yield (topic, log_ns, publish_ns, raw) of one signal, logged with the sample's message."""
    recording, parameters = result.recording, result.monitor.parameters
    stamps, values = signal_values(signal, result.estimates, result.monitor.model.gear_ratio)
    if not len(stamps):
        return
    names = {MOTOR: parameters['motor_joint'], ARM: parameters['arm_joint']}
    order = np.argsort(recording.samples.stamp_ns, kind='stable')
    place = np.searchsorted(recording.samples.stamp_ns[order], stamps)
    log_ns = np.maximum.accumulate(recording.log_ns[order][place])
    present = ~np.isnan(values['position'])
    encoded = [b''] * len(stamps)
    for pattern in np.unique(present, axis=0):
        rows = np.flatnonzero((present == pattern).all(axis=1))
        joints = [names.get(j, j) for j, there in zip(signal.joints, pattern) if there]
        fields = {name: array[rows][:, pattern] for name, array in values.items()}
        for row, raw in zip(rows, encode_joint_states(stamps[rows], joints, **fields)):
            encoded[row] = raw
    topic = f'{recording.namespace}/{signal.topic}'
    for log, raw in zip(log_ns.tolist(), encoded):
        yield topic, log, log, raw
