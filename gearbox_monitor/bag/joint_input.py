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

"""Which topic of a bag an estimator took its samples from, and how its other topics are called."""
from dataclasses import dataclass, field
import json

from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.signals import JOINT_STATES, PAIRED_JOINT_STATES, SNAPSHOT

JOINT_STATE = 'sensor_msgs/msg/JointState'
DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'


@dataclass(frozen=True)
class JointInput:
    """
    A topic of joint states in a bag and the estimator that took it, if any.

    namespace: of the estimator; snapshots: its topic of snapshots, None without one. names {topic
    as of signals: name in the bag}: topics that were remapped differ from the namespace's.
    """

    topic: str
    namespace: str
    snapshots: str | None = None
    names: dict = field(default_factory=dict)

    def name(self, topic):
        """Return what the estimator's `topic` is called in the bag."""
        return self.names.get(topic, f'{self.namespace}/{topic}')


def find_input(reader, name=JOINT_STATES):
    """
    Return the JointInput called `name` in the bag `reader`, in whatever namespace.

    name: a topic, as recorded or as the estimator called it before it was remapped or paired; or
    an estimator, /NAMESPACE/NODE. Raises InputError when there is none, or more than one.
    """
    found = []
    for snapshots, names in _estimators(reader).items():
        node = snapshots.removesuffix(f'/{SNAPSHOT}')
        namespace = node.rsplit('/', 1)[0]
        usual = f'{namespace}/{JOINT_STATES}'
        topic = names.get(JOINT_STATES, usual)
        if any(_called(known, name) for known in (topic, usual, node)):
            found.append((node, JointInput(topic, namespace, snapshots, names)))
    if len(found) > 1:
        nodes = sorted(node for node, _ in found)
        raise InputError(f'{reader.path}: topic {name}: taken by {", ".join(nodes)}, expected '
                         f'one; choose it with --topic {nodes[0]}')
    if found:
        reader.require(found[0][1].topic, JOINT_STATE)
        return found[0][1]
    topic = find_topic(reader, name)
    namespace = topic.rsplit('/', 1)[0]
    paired = f'{namespace}/{PAIRED_JOINT_STATES}'
    if topic == f'{namespace}/{JOINT_STATES}' and reader.topics.get(paired, ('', 0))[1]:
        topic = paired
    return JointInput(topic, namespace)


def _called(topic, name):
    """Return whether `topic` is `name`; absolute names as they are, others in any namespace."""
    return topic == name or not name.startswith('/') and topic.endswith('/' + name)


def find_topic(reader, name):
    """Return the topic of joint states called `name`, in whatever namespace. Raises InputError."""
    if name.startswith('/'):
        reader.require(name, JOINT_STATE)
        return name
    found = [topic for topic, (kind, _) in reader.topics.items()
             if kind == JOINT_STATE and _called(topic, name)]
    if len(found) > 1:
        raise InputError(f'{reader.path}: topic {name}: {", ".join(sorted(found))}, expected one; '
                         'choose it with --topic')
    if not found:
        reader.require('/' + name, JOINT_STATE)  # says what there is
    return found[0]


def _estimators(reader):
    """Return {topic of snapshots: names of the topics of the estimator, where it tells them}."""
    topics = [topic for topic, (kind, count) in reader.topics.items()
              if kind == DIAGNOSTIC_ARRAY and topic.endswith(f'/{SNAPSHOT}') and count]
    found = {}
    for topic, _, _, raw in reader.messages(topics) if topics else ():
        content = snapshot_of(reader, raw)
        if topic not in found and content:
            found[topic] = json.loads(content.get('topics', '{}'))
            if len(found) == len(topics):
                break
    return found


def snapshot_of(reader, raw):
    """Return {name: text} of the CDR bytes `raw` of a snapshot, {} where they are none."""
    for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
        content = {value.key: value.value for value in status.values}
        if 'z' in content and 'stamp_ns' in content:
            return content
    return {}
