# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

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
