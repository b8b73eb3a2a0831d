# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Declare a table of parameters on a node, with units, ranges and what may change at run time."""
from collections.abc import Callable, Iterable, Mapping
import math
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import FIXED, ParameterRow, ParameterValue, RESTART
from gearbox_monitor.removed import refusal


class TableNode(Node):
    """Node that tells what to do when it refuses a parameter that is read at the start only."""

    def set_parameters_atomically(
            self, parameter_list: list[RosParameter]) -> SetParametersResult:
        """Set the parameters of `parameter_list`, all or none, as rclpy does."""
        result = super().set_parameters_atomically(parameter_list)
        fixed = [p.name for p in parameter_list
                 if self.has_parameter(p.name) and self.describe_parameter(p.name).read_only]
        if fixed and not result.successful:
            result.reason = (f'{", ".join(fixed)}: read-only while the node runs; change it in '
                             f'the parameter file (or with -p) and start {self.get_name()} again')
        return result

    def warn_of_unknown(self) -> None:
        """Warn of parameters that the user sets and the node does not have: misspelt ones."""
        unknown = [name for name in self._parameter_overrides if not self.has_parameter(name)]
        if unknown:
            self.get_logger().warning(
                f'no parameters of this node, ignored: {", ".join(sorted(unknown))}')


def _descriptor(row: ParameterRow) -> ParameterDescriptor:
    unit = f' [{row.unit}]' if row.unit else ''
    constraints = ['expected ' + row.expected()] if row.choices or row.kind is tuple else []
    constraints += {FIXED: ['read at the start only'],
                    RESTART: ['a change restarts the filter']}.get(row.change, [])
    descriptor = ParameterDescriptor(
        description=f'{row.description}{unit}', read_only=row.change == FIXED,
        additional_constraints='; '.join(constraints))
    # Open ends would become NaN steps in a range message: leave the range out there.
    if math.isfinite(row.low) and math.isfinite(row.high):
        if row.kind is float:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(row.low), to_value=float(row.high))]
        elif row.kind is int:
            descriptor.integer_range = [
                IntegerRange(from_value=int(row.low), to_value=int(row.high))]
    return descriptor


def declare(node: Node, table: Iterable[ParameterRow]) -> dict[str, ParameterValue]:
    """
    Declare every row of `table` on `node` and return {name: value}.

    Raises InputError if an override has a wrong type, is out of range, or has a name that is gone.
    """
    table = list(table)
    names = {row.name for row in table}
    gone = [f'node {node.get_name()}: {name}: {text}' for name in node._parameter_overrides
            if name not in names and (text := refusal(name.rpartition('.')[2]))]
    if gone:
        raise InputError(*gone)
    values: dict[str, ParameterValue] = {}
    for row in table:
        default = row.default
        # An integer in a YAML file is a good float; rclpy would refuse its type.
        override = node._parameter_overrides.get(row.name)
        if override is not None:
            row.check(_plain(override.value), f'node {node.get_name()}')
            if row.kind is float and isinstance(override.value, int):
                node._parameter_overrides[row.name] = RosParameter(
                    row.name, RosParameter.Type.DOUBLE, float(override.value))
        try:
            value = node.declare_parameter(row.name, _plain(default), _descriptor(row)).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f'node {node.get_name()}: {row.name}: {error}, expected '
                             f'{row.expected()}') from None
        values[row.name] = row.check(_plain(value), f'node {node.get_name()}')
    return values


def on_change(node: Node, table: Iterable[ParameterRow],
              apply: Callable[[Mapping[str, ParameterValue]], None]) -> None:
    """
    Let parameters change at run time: check all of them, then apply them.

    Args:
        node: whose parameters they are.
        table: of the parameters.
        apply: takes {name: value}; the text of an InputError that it raises becomes the reason of
            the refusal.

    """
    rows = {row.name: row for row in table}

    def callback(parameters: list[RosParameter]) -> SetParametersResult:
        try:
            changes = {p.name: rows[p.name].check(_plain(p.value), node.get_name())
                       for p in parameters if p.name in rows}
            if changes:
                apply(changes)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(callback)


def _plain(value: Any) -> Any:
    """Return `value` with tuples, and arrays of the message layer, as lists."""
    return list(value) if isinstance(value, tuple) or hasattr(value, 'tolist') else value
