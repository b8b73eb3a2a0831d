# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Find the topic that an estimator took its samples from, and the names of its other topics."""
from collections.abc import Mapping
from dataclasses import dataclass, field
import json
from pathlib import Path
import shlex

from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.topics import (
    JOINT_STATES, PAIRED_JOINT_STATES, SNAPSHOT, TRANSMISSION)

DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
PAYLOAD_CHANGE = 'payload'  # reason of a snapshot: what the robot carries
GEARBOX = 'gearbox'  # key of a snapshot: its name, where an estimator has several


@dataclass(frozen=True)
class JointInput:
    """
    A topic of joint states in a bag and the estimator that took it, if any.

    namespace: of the estimator; snapshots: its topic of snapshots, None without one. names {topic
    as in signals: name in the bag}: topics that were remapped differ from the namespace's.
    transmission: its name in the estimates, that of the gearbox where an estimator has several.
    """

    topic: str
    namespace: str
    snapshots: str | None = None
    names: Mapping[str, str] = field(default_factory=dict)
    transmission: str = TRANSMISSION

    @property
    def joints(self) -> dict[str, str]:
        """Names of the joints of a signal in messages, where they differ."""
        return {TRANSMISSION: self.transmission}

    def name(self, topic: str) -> str:
        """Return the name in the bag of the estimator's `topic`."""
        return self.names.get(topic, f'{self.namespace}/{topic}')


def bag_arguments(bag: str | Path, topic: str) -> str:
    """Return the recording `bag` with its `topic` of inputs as arguments of a command."""
    return shlex.quote(str(bag)) + (
        '' if topic == JOINT_STATES else f' --topic {shlex.quote(topic)}')


def find_input(reader: BagReader, name: str = JOINT_STATES) -> JointInput:
    """
    Return the JointInput called `name` in the bag `reader`, in whatever namespace.

    `name` is a topic, as recorded or as the estimator called it before it was remapped or paired,
    or an estimator, /NAMESPACE/NODE; of several gearboxes TOPIC/GEARBOX or
    /NAMESPACE/NODE/GEARBOX. Raises InputError unless exactly one fits.
    """
    inputs = recorded_inputs(reader, name)
    if len(inputs) > 1:
        nodes = sorted(inputs)
        raise InputError(f'{reader.path}: topic {name}: taken by {", ".join(nodes)}, expected '
                         f'one; choose it with --topic {nodes[0]}')
    if inputs:
        (recorded,) = inputs.values()
        reader.require(recorded.topic, JOINT_STATE)
        return recorded
    of_robot = name.rpartition('/')[0]  # where no estimator was recorded: TOPIC/GEARBOX
    if of_robot and not topics_called(reader, name) and topics_called(reader, of_robot):
        name = of_robot
    topic = find_topic(reader, name)
    namespace = topic.rsplit('/', 1)[0]
    paired = f'{namespace}/{PAIRED_JOINT_STATES}'
    if topic == f'{namespace}/{JOINT_STATES}' and reader.count(paired):
        topic = paired
    return JointInput(topic, namespace)


def recorded_inputs(reader: BagReader, name: str = JOINT_STATES) -> dict[str, JointInput]:
    """Return {estimator: JointInput} of the estimators in `reader` that took a topic `name`."""
    candidates: dict[str, JointInput] = {}  # by node
    for snapshots, content in _estimators(reader).items():
        names, gearbox = _recorded_names(content.get('topics', '{}')), content.get(GEARBOX)
        node = snapshots.removesuffix(f'/{SNAPSHOT}')
        namespace = node.rsplit('/', 2 if gearbox else 1)[0]
        original = f'{namespace}/{JOINT_STATES}'
        topic = names.get(JOINT_STATES, original)
        aliases = [topic, original, node]
        if gearbox:
            aliases += [f'{topic}/{gearbox}', f'{original}/{gearbox}']
        if any(_is_called(alias, name) for alias in aliases):
            candidates[node] = JointInput(topic, namespace, snapshots, names,
                                          gearbox or TRANSMISSION)
    return candidates


def _is_called(topic: str, name: str) -> bool:
    """Return whether `topic` is `name`; relative names are in any namespace."""
    return topic == name or not name.startswith('/') and topic.endswith('/' + name)


def topics_called(reader: BagReader, name: str) -> list[str]:
    """Return the topics of joint states in `reader` that are called `name`, in any namespace."""
    return [topic for topic, (kind, _) in reader.topics.items()
            if kind == JOINT_STATE and _is_called(topic, name)]


def find_topic(reader: BagReader, name: str) -> str:
    """Return the topic of joint states called `name` in `reader`. Raises InputError."""
    if name.startswith('/'):
        reader.require(name, JOINT_STATE)
        return name
    topics = topics_called(reader, name)
    if len(topics) > 1:
        raise InputError(f'{reader.path}: topic {name}: {", ".join(sorted(topics))}, expected '
                         'one; choose it with --topic')
    if not topics:
        reader.require('/' + name, JOINT_STATE)  # raises and lists the topics
    return topics[0]


def _estimators(reader: BagReader) -> dict[str, dict[str, str]]:
    """Return {topic of snapshots: content of the first one, {} if it is damaged}."""
    topics = [topic for topic, (kind, count) in reader.topics.items()
              if kind == DIAGNOSTIC_ARRAY and topic.endswith(f'/{SNAPSHOT}') and count]
    contents: dict[str, dict[str, str]] = {}
    for topic, _, _, raw in reader.messages(topics) if topics else ():
        content = snapshot_of(reader, raw)
        if topic not in contents and content:
            contents[topic] = content
            if len(contents) == len(topics):
                break
    return contents


def _recorded_names(text: str) -> dict[str, str]:
    """Return {topic: name} in the JSON `text` of a snapshot, {} if it is damaged."""
    try:
        names = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return {key: str(name) for key, name in names.items()} if isinstance(names, dict) else {}


def snapshot_of(reader: BagReader, raw: bytes) -> dict[str, str]:
    """Return {name: text} of a snapshot in the CDR bytes `raw` of `reader`, {} if it is none."""
    for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
        content: dict[str, str] = {value.key: value.value for value in status.values}
        if 'z' in content and 'stamp_ns' in content:
            return content
    return {}
