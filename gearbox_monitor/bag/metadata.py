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

"""``metadata.yaml`` of a rosbag2 directory, in version 9 as ROS 2 Jazzy writes it."""
import yaml

VERSION = 9
FILE_NAME = 'metadata.yaml'
# The one in C is ten times as fast, where it was built.
YAML_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
FOREVER = {'sec': 9223372036, 'nsec': 854775807}


# What the numbers mean that rosbag2 wrote before version 9.
POLICIES = {
    'history': ('system_default', 'keep_last', 'keep_all', 'unknown'),
    'reliability': ('system_default', 'reliable', 'best_effort', 'unknown', 'best_available'),
    'durability': ('system_default', 'transient_local', 'volatile', 'unknown', 'best_available'),
    'liveliness': ('system_default', 'automatic', 'manual_by_node', 'manual_by_topic', 'unknown',
                   'best_available'),
}


def qos_profile(depth=10, reliability='reliable', durability='volatile', history='keep_last',
                deadline=FOREVER, lifespan=FOREVER, liveliness='automatic',
                liveliness_lease_duration=FOREVER):
    """Return one offered QoS profile as rosbag2 spells it; durations are sec and nsec."""
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


def read_qos(text):
    """Return the list of profiles that `text` holds, of any version of rosbag2; [] if damaged."""
    try:
        profiles = yaml.load(text, YAML_LOADER) or []
        return [{**profile, **{name: values[profile[name]] for name, values in POLICIES.items()
                               if isinstance(profile[name], int)}} for profile in profiles]
    except (yaml.YAMLError, KeyError, IndexError, TypeError):
        return []


def read_information(folder):
    """Return ``rosbag2_bagfile_information`` of the bag `folder`, {} where it cannot be read."""
    try:
        content = yaml.load((folder / FILE_NAME).read_text(encoding='utf-8'), YAML_LOADER)
        content = content['rosbag2_bagfile_information']
        return content if isinstance(content['relative_file_paths'], list) else {}
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, RecursionError):
        return {}


def bag_information(files, topics, custom_data):
    """
    Return the content of ``rosbag2_bagfile_information``.

    `files` are objects with path, start_ns, end_ns (None without messages), count; `topics` with
    name, msgtype, encoding, qos (list of :func:`qos_profile`), type_hash, count.
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


def _span(files):
    """Return time and messages of the `files` together."""
    times = [time for file in files if file.count for time in (file.start_ns, file.end_ns)]
    return {
        'duration': {'nanoseconds': max(times) - min(times) if times else 0},
        'starting_time': {'nanoseconds_since_epoch': min(times, default=0)},
        'message_count': sum(file.count for file in files),
    }


def to_yaml(value):
    """Return `value` as YAML text without anchors, in the given order."""
    return yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False)


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data):
        return True
