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
FOREVER = {'sec': 9223372036, 'nsec': 854775807}


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


def bag_information(file_name, topics, start_ns, end_ns, custom_data):
    """
    Return the content of ``rosbag2_bagfile_information``.

    `topics` are objects with name, msgtype, qos (list of :func:`qos_profile`), type_hash, count.
    """
    count = sum(topic.count for topic in topics)
    start = {'nanoseconds_since_epoch': start_ns if count else 0}
    duration = {'nanoseconds': end_ns - start_ns if count else 0}
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        'duration': duration,
        'starting_time': start,
        'message_count': count,
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name,
                'type': topic.msgtype,
                'serialization_format': 'cdr',
                'offered_qos_profiles': topic.qos,
                'type_description_hash': topic.type_hash,
            },
            'message_count': topic.count,
        } for topic in topics],
        'compression_format': '',  # of rosbag2's own compression; MCAP compresses its chunks
        'compression_mode': '',
        'relative_file_paths': [file_name],
        'files': [{
            'path': file_name,
            'starting_time': start,
            'duration': duration,
            'message_count': count,
        }],
        'custom_data': dict(custom_data) or None,
        'ros_distro': 'jazzy',
    }


def to_yaml(value):
    """Return `value` as YAML text without anchors, in the given order."""
    return yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False)


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data):
        return True
