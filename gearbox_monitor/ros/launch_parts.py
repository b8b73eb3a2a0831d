# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the launch files share: how they declare arguments, and start nodes of the package."""
from collections.abc import Mapping, Sequence
from typing import Any

from launch import LaunchContext
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

BAG = ('bag', '', 'bag directory to create; empty: gearbox_DATE-TIME here')
FILTER = ('filter', '', "name of the filter; empty: the parameter file's, else ekf")
ENCLAVE = ('enclave', '', 'security enclave above those of the nodes, like /gearbox_monitor, see '
           'docs/security.md; empty: none')
BAD_INPUT, RESPAWN = 2, 2.0  # exit code of a node; s before it is started again
LOG_LEVEL = ('log_level', 'info', 'debug, info, warn, error or fatal')


def declared(*rows: tuple[str, str | bool | None, str]) -> list[DeclareLaunchArgument]:
    """Return the arguments of `rows`: name, default, description; None: it must be stated."""
    return [DeclareLaunchArgument(
        name, default_value=str(usual).lower() if isinstance(usual, bool) else usual,
        choices=['true', 'false'] if isinstance(usual, bool) else None, description=description)
        for name, usual, description in rows]


def stated(context: LaunchContext, arguments: Sequence[DeclareLaunchArgument]) -> dict[str, str]:
    """Return {name: value} of the `arguments` in a `context`."""
    return {a.name: LaunchConfiguration(a.name).perform(context) for a in arguments}


def typed(settings: Mapping[str, str | bool]) -> dict[str, ParameterValue]:
    """Return the `settings` {parameter: value, '' to leave it} as parameters of a Node."""
    return {key: ParameterValue(setting, value_type=type(setting))
            for key, setting in settings.items() if setting != ''}


def lasting() -> dict[str, Any]:
    """Return the options of a node that is started again when it ends, unless its input is bad."""
    def ended(event: ProcessExited, _: LaunchContext) -> list[Shutdown]:
        """End all where another start would end alike."""
        return [Shutdown(reason='a node has refused its parameters')] \
            if event.returncode == BAD_INPUT else []
    return {'respawn': True, 'respawn_delay': RESPAWN, 'on_exit': ended}


def package_node(name: str, value: Mapping[str, str], parameters: Sequence[Any],
                 namespace: str | None = None, **options: Any) -> Node:
    """
    Return a node of the package.

    Args:
        name: of the node.
        value: {name: value} of the launch arguments.
        parameters: files and mappings; empty ones are left out.
        namespace: of the node, below which its security enclave is; None: that of `value`.
        options: further ones of Node.
    """
    enclave = f'{value["enclave"]}{(namespace or "").rstrip("/")}/{name}'
    return Node(
        package='gearbox_monitor', executable=f'{name}_node', name=name,
        namespace=value['namespace'] if namespace is None else namespace,
        output='screen', emulate_tty=True, parameters=list(filter(None, parameters)),
        ros_arguments=['--log-level', value['log_level'],
                       *(['--enclave', enclave] if value['enclave'] else [])], **options)
