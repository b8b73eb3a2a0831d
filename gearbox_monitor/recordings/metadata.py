# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""``metadata.yaml`` of a rosbag2 directory, in version 9 as ROS 2 Jazzy writes it."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import yaml

from gearbox_monitor.files.bounded_yaml import parse_yaml
from gearbox_monitor.files.opening import read_text
from gearbox_monitor.kernels.types import Values

VERSION = 9
FILE_NAME = 'metadata.yaml'
MAX_BYTES = 16 << 20  # of it: thousands of files and topics are a tenth of that
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
QosProfile: TypeAlias = dict[str, Any]

# Names of the numbers that rosbag2 wrote before version 9.
POLICIES = {
    'history': ('system_default', 'keep_last', 'keep_all', 'unknown'),
    'reliability': ('system_default', 'reliable', 'best_effort', 'unknown', 'best_available'),
    'durability': ('system_default', 'transient_local', 'volatile', 'unknown', 'best_available'),
    'liveliness': ('system_default', 'automatic', 'manual_by_node', 'manual_by_topic', 'unknown',
                   'best_available'),
}


class BagFile(Protocol):
    """One file of a bag."""

    path: Path

    @property
    def span(self) -> tuple[int, int] | None:
        """First and last log time, None without a message."""

    @property
    def count(self) -> int:
        """Number of messages."""


@dataclass
class BagTopic:
    """A topic of a bag; schema: definition of its type; channel_metadata: of its channel."""

    name: str
    msgtype: str
    qos: list[QosProfile]
    type_hash: str
    schema: bytes
    channel_metadata: Mapping[str, str]
    schema_encoding: str = 'ros2msg'
    encoding: str = 'cdr'
    count: int = 0


def qos_profile(depth: int = 10, reliability: str = 'reliable', durability: str = 'volatile',
                history: str = 'keep_last', deadline: Mapping[str, int] = FOREVER,
                lifespan: Mapping[str, int] = FOREVER, liveliness: str = 'automatic',
                liveliness_lease_duration: Mapping[str, int] = FOREVER) -> QosProfile:
    """
    Return one offered QoS profile as rosbag2 spells it.

    Args:
        depth: length of the queue.
        reliability: 'reliable' or 'best_effort'.
        durability: 'volatile' or 'transient_local'.
        history: 'keep_last' or 'keep_all'.
        deadline: longest time between two messages, {'sec', 'nsec'}.
        lifespan: time after which a message expires, {'sec', 'nsec'}.
        liveliness: 'automatic' or 'manual_by_topic'.
        liveliness_lease_duration: time within which a publisher shows that it is alive.

    Returns:
        Plain data for ``metadata.yaml`` and the metadata of an MCAP channel.
    """
    return {
        'history': history,
        'depth': depth,
        'reliability': reliability,
        'durability': durability,
        'deadline': dict(deadline),
        'lifespan': dict(lifespan),
        'liveliness': liveliness,
        'liveliness_lease_duration': dict(liveliness_lease_duration),
        'avoid_ros_namespace_conventions': False,
    }


def read_qos(text: str) -> list[QosProfile]:
    """Return the profiles in `text`, as any version of rosbag2 wrote them; [] if damaged."""
    try:
        profiles = parse_yaml(text, aliases=False)[0] or []
        return [{**profile, **{name: values[profile[name]] for name, values in POLICIES.items()
                               if isinstance(profile[name], int)}} for profile in profiles]
    except (yaml.YAMLError, ValueError, KeyError, IndexError, TypeError):
        return []


def read_information(folder: Path) -> dict[str, Any]:
    """
    Return ``rosbag2_bagfile_information`` of the bag `folder`, {} if it cannot be read.

    Its paths, files, topics, duration and start are of the types that rosbag2 writes.
    """
    try:
        content, _ = parse_yaml(read_text(folder / FILE_NAME, MAX_BYTES), aliases=False)
        content = content['rosbag2_bagfile_information']
        entries = [*(content.get('files') or ()), content]
        times = [entry[name][key] for entry in entries for name, key in (
            ('duration', 'nanoseconds'), ('starting_time', 'nanoseconds_since_epoch'))]
        counts = [content['message_count'], *(
            entry['message_count'] for entry in content['topics_with_message_count'])]
        sound = (isinstance(content['relative_file_paths'], list)
                 and all(isinstance(name, str) for name in content['relative_file_paths'])
                 and isinstance(content.get('custom_data') or {}, dict)
                 and all(isinstance(number, int) and 0 <= number < 1 << 63
                         for number in (*times, *counts)))
        return content if sound else {}
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        return {}


def bag_information(files: Sequence[BagFile], topics: Iterable[BagTopic],
                    custom_data: Mapping[str, str]) -> dict[str, Any]:
    """
    Describe a bag as ``metadata.yaml`` does.

    Args:
        files: the files of the bag, in order.
        topics: its topics.
        custom_data: {key: text} that the bag carries besides.

    Returns:
        The content of ``rosbag2_bagfile_information``.
    """
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        **_span(files),
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name,
                'type': topic.msgtype,
                'serialization_format': topic.encoding,
                'offered_qos_profiles': topic.qos,
                'type_description_hash': topic.type_hash,
            },
            'message_count': topic.count,
        } for topic in topics],
        'compression_format': '',  # of rosbag2's own compression; MCAP compresses its chunks
        'compression_mode': '',
        'relative_file_paths': [file.path.name for file in files],
        'files': [{'path': file.path.name, **_span([file])} for file in files],
        'custom_data': dict(custom_data) or None,
        'ros_distro': 'jazzy',
    }


def _span(files: Sequence[BagFile]) -> dict[str, Any]:
    """Return time and messages of the `files` together."""
    times = [time for file in files for time in file.span or ()]
    return {
        'duration': {'nanoseconds': max(times) - min(times) if times else 0},
        'starting_time': {'nanoseconds_since_epoch': min(times, default=0)},
        'message_count': sum(file.count for file in files),
    }


def to_yaml(value: Values | Sequence[Values]) -> str:
    """Return `value` as YAML text without anchors, keys in their order."""
    return str(yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False))


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True
