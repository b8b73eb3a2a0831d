# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The joints of a robot's file as a table: what is read of each, what is refused and why."""
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
import textwrap
from typing import Any

from gearbox_monitor.cli.options import show
from gearbox_monitor.robot.plausibility import implausible, implausible_limits
from gearbox_monitor.simulators.mjcf_file import compiled_file, read_file, RobotFile
from gearbox_monitor.simulators.user_simulator import (
    joint_readings, JointReading, NONE, SERVO, SPEED, TORQUE)

WIDTH = 100
COLUMNS = ('inertia', 'armature', 'viscous_friction', 'coulomb_friction', 'weight', 'stiffness')
TITLES = ('inertia', 'armature', 'viscous', 'Coulomb', 'weight', 'spring')
UNIT_LINE = ('kg m^2', 'kg m^2', 'N m s/rad', 'N m', 'N m', 'N m/rad')


def show_table(args: Namespace) -> int:
    """Show the joints of the file that the options `args` name; return the exit code."""
    path = Path(args.bag)
    file = compiled_file(read_file(path), path, root=Path(args.root) if args.root else None)
    readings = joint_readings(file, args.keyframe)
    doubts = doubts_of(file)
    show(args, {**as_data(file, readings), 'doubts': doubts}, lambda: '\n'.join([
        text(file, readings), *(line for d in doubts for line in _wrapped(f'doubt: {d}'))]))
    return 0 if all(reading.read for reading in readings) and not doubts else 1


def doubts_of(file: RobotFile) -> list[str]:
    """Return a line for each value of a robot's `file` that cannot be true."""
    document, path = file.document, str(file.path)
    return implausible(file.compiled) + (
        implausible_limits(document.data, path) if document.root.tag == 'robot' else [])


def as_data(file: RobotFile, readings: Sequence[JointReading]) -> dict[str, Any]:
    """Return the table as plain data; `file` is the robot's, `readings` are of its joints."""
    return {
        'robot': str(file.path), 'timestep': float(file.compiled.opt.timestep),
        'read': sum(reading.read for reading in readings), 'notes': list(file.notes),
        'joints': [{
            'joint': r.name, 'type': r.kind, 'read': r.read, 'control': r.control,
            'values': r.values, 'units': r.units(), 'refused': list(r.refusals),
            'notes': list(r.notes)} for r in readings]}


def text(file: RobotFile, readings: Sequence[JointReading]) -> str:
    """Return the table as lines for people; `file` is the robot's, `readings` of its joints."""
    count = sum(reading.read for reading in readings)
    name = max([5, *(len(r.name) for r in readings)])
    head = [f'{file.path.name}: {count} of {len(readings)} joints are read '
            '(diagnose --model ' f'{file.path} --joint NAME)', '',
            f'{"joint":<{name}}' + ''.join(f'{title:>10}' for title in TITLES) + '  control',
            f'{"":<{name}}' + ''.join(f'{unit:>10}' for unit in UNIT_LINE)]
    lines = []
    for reading in readings:
        cells = ''.join(f'{_cell(reading.values.get(k)):>10}' for k in COLUMNS)
        lines.append(f'{reading.name:<{name}}' + (
            f'{cells}  {_drive(reading)}' if reading.read else '  refused'))
        for refusal in reading.refusals:
            lines += textwrap.wrap(refusal, WIDTH, initial_indent=' ' * (name + 2),
                                   subsequent_indent=' ' * (name + 4), break_on_hyphens=False)
    if any(r.kind == 'slide' for r in readings):
        lines.append('(of a slide: kg, N s/m, N and N/m)')
    notes = dict.fromkeys([*file.notes, *(note for r in readings for note in r.notes)])
    for note in notes:
        count = sum(note in r.notes for r in readings)
        lines += _wrapped(f'note: {note}' + (f' ({count} joints)' if count > 1 else ''))
    return '\n'.join([*head, *lines])


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(line, WIDTH, break_on_hyphens=False)


def _cell(value: float | None) -> str:
    return '-' if value is None else f'{value:.4g}'


def _drive(reading: JointReading) -> str:
    """Return words about what drives a joint."""
    v = reading.values
    parts = {
        NONE: ['no actuator'], TORQUE: [f'torque, x {v.get("gear", 1.0) * v.get("gain", 1.0):g}'],
        SPEED: [f'speed, x {v.get("gear", 1.0) * v.get("gain", 1.0):g}'],
        SERVO: [f'position, kp {v.get("kp", 0.0):g} kd {v.get("kd", 0.0):g}']}[reading.control]
    if 'limit' in v:
        parts.append(f'+-{v["limit"]:g}')
    parts += [f'{name} {1e3 * v[name]:g} ms' for name in ('lag', 'delay') if name in v]
    if 'offset' in v:
        parts.append(f'offset {v["offset"]:.4g}')
    return ', '.join(parts)
