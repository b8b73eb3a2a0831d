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

"""
Several estimators in one process, in a namespace each: what load.py and soak.py measure.

  python -m load_estimators g0 g1 --ros-args -p arm_load:=none
  python -m load_estimators --events / --ros-args -p arm_load:=none   # by the EventsExecutor
"""
import sys

from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor

from gearbox_monitor.ros.estimator_node import EstimatorNode
from gearbox_monitor.ros.runtime import spin_node


def main():
    """Run one in each namespace that stands before --ros-args; returns the exit code."""
    end = sys.argv.index('--ros-args')
    names = [name for name in sys.argv[1:end] if name != '--events']
    return spin_node(
        lambda: [EstimatorNode(namespace=name) for name in names], [sys.argv[0], *sys.argv[end:]],
        make_executor=EventsExecutor if '--events' in sys.argv[1:end] else SingleThreadedExecutor)


if __name__ == '__main__':
    sys.exit(main())
