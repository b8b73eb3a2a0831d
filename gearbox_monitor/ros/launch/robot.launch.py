# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Monitor the gearboxes of a robot, all from one parameter file.

The file is an ordinary ROS parameter file. Its block `estimator` starts one node for all gearboxes
that its parameter `gearboxes` names. Each further block /NAMESPACE/estimator starts a node in that
namespace, each block /NAMESPACE/plant a simulated drive, each block /NAMESPACE/arm_plant a
simulated arm. One recorder in the root namespace records all of them into one bag. See
config/robot.yaml.

  ros2 launch gearbox_monitor robot.launch.py params_file:=robot.yaml joint_states:=/joint_states
"""
from collections.abc import Iterable, Sequence
import re
from typing import Any, NamedTuple

from launch import LaunchContext, LaunchDescription
from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_yaml
from gearbox_monitor.parameters import RecorderParameters
from gearbox_monitor.recordings.topics import SNAPSHOT
from gearbox_monitor.ros.launch_parts import (
    BAG, declared, ENCLAVE, lasting, LOG_LEVEL, package_node, stated, typed)

ARGUMENTS = declared(
    ('params_file', None, 'YAML parameter file with a block estimator, or a block '
     '/NAMESPACE/estimator for each robot or gearbox, see config/robot.yaml of this package'),
    ('joint_states', '', 'topic that all gearboxes take their joints from, like /joint_states of '
     'a joint_state_broadcaster; empty: joint_states in the namespace of each'),
    ('record', True, 'record the topics of all gearboxes into one bag'), BAG,
    ('use_sim_time', False, 'take the time from /clock'), ENCLAVE, LOG_LEVEL)


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


class NodeBlock(NamedTuple):
    """A `node` of the file, in its `namespace`; the gearboxes that it names."""

    namespace: str
    node: str
    gearboxes: tuple[str, ...]


def node_blocks(path: str) -> list[NodeBlock]:
    """Return the blocks of the file `path`; raises RuntimeError."""
    try:
        data = load_yaml(path).content
    except InputError as error:
        raise RuntimeError(str(error)) from None
    blocks = [(match[1], match[2]) for name in (data if isinstance(data, dict) else ())
              if (match := re.fullmatch(r'(|/|/[\w/]*\w/)(estimator|plant|arm_plant)', str(name)))]
    if not any(node == 'estimator' for _, node in blocks):
        raise RuntimeError(f'{path}: no block estimator or /NAMESPACE/estimator, expected one')
    return [NodeBlock(namespace.rstrip('/') or '/', node, _names(data[namespace + node]))
            for namespace, node in blocks]


def _names(block: Any) -> tuple[str, ...]:
    """Return the gearboxes that the `block` of a node names, () if it has one without a name."""
    parameters = block.get('ros__parameters') if isinstance(block, dict) else None
    names = parameters.get('gearboxes') if isinstance(parameters, dict) else None
    return tuple(filter(None, map(str, names))) if isinstance(names, list) else ()


def topics(blocks: Iterable[NodeBlock]) -> list[str]:
    """Return the names of all topics of the estimators among `blocks`."""
    names: list[str] = []
    for block in blocks:
        if block.node == 'estimator':
            namespace = block.namespace.rstrip('/')
            names += [name if name.startswith('/') else f'{namespace}/{name}'
                      for name in RecorderParameters().topics]
            names += [f'{namespace}/estimator/{gearbox}/{SNAPSHOT}' for gearbox in block.gearboxes]
    return [*dict.fromkeys(names)]


def _nodes(context: LaunchContext) -> list[Node]:
    value = stated(context, ARGUMENTS)
    clock = {'use_sim_time': value['use_sim_time'] == 'true'}

    def node(name: str, namespace: str, settings: dict[str, Any],
             remappings: Sequence[tuple[str, str]] = (), **options: Any) -> Node:
        return package_node(name, value, [settings, value['params_file']], namespace,
                            remappings=remappings, **options)

    blocks = node_blocks(value['params_file'])
    shared = value['joint_states']
    nodes = [node(name, namespace, clock if name == 'estimator' else {},
                  [('joint_states', shared)] if shared and name == 'estimator' else [],
                  **(lasting() if name == 'estimator' else {}))
             for namespace, name, _ in blocks]
    if value['record'] == 'true':
        names = [*([shared] if shared else []), *topics(blocks)]
        nodes.append(node('recorder', '/', {
            **clock, 'topics': [*dict.fromkeys(names)], **typed({'output': value['bag']})},
            **lasting()))
    return nodes
