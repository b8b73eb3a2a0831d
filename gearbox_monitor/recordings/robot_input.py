# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Read a log of all joints of a robot: a bag with joint_states, or a table of columns.

A table (CSV, gzipped or not, or Parquet) has t (s) and of each joint q_NAME (rad or m) and one of
tau_NAME (N m or N), i_NAME (A) and setpoint_NAME (rad or m). v_NAME is not needed: speeds come
from the positions.
"""
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
import re

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_log import CURRENT, RawLog, SETPOINT, TORQUE
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.csv import header_of, text_columns, TEXTS
from gearbox_monitor.recordings.importer.containers import opened_table, readable
from gearbox_monitor.recordings.importer.mapping import TextFormat
from gearbox_monitor.recordings.importer.text_file import sample_rows, split_line
from gearbox_monitor.recordings.joint_input import find_topic, topics_called
from gearbox_monitor.recordings.read import open_bag

TABLES = ('.parquet', '.pq')
PREFIXES = {'tau_': TORQUE, 'i_': CURRENT, 'setpoint_': SETPOINT}
SETPOINTS = 'joint_setpoints'
NO_SERVO = 'the model has none'
NEEDED = 'setpoints need position actuators of all joints in the model, or gains in --values'
STILL = 'of a joint that stands still, its position: locked in --values'
UNSIGNED = 'no value is below 0: sizes without a direction'
COLUMNS = 't, q_NAME and tau_NAME, i_NAME or setpoint_NAME of each joint'


def read_robot_log(path: str | Path, joints: Sequence[str], recorded: Mapping[str, str],
                   constants: Mapping[str, float] | None = None, no_servo: str = NO_SERVO,
                   topic: str = 'joint_states', locked: Mapping[str, float] | None = None
                   ) -> RawLog:
    """
    Return the RawLog of a file.

    Args:
        path: of a bag, CSV or Parquet file.
        joints: of the model.
        recorded: {joint: its name in the log}, where they differ.
        constants: torque per current, N m/A, of each joint; None where they are not known.
        no_servo: why setpoints make no torque with the model, '' where they do.
        topic: of the joint states in a bag.
        locked: {joint that the model holds still: its position}; where the log has it is a note.

    Raises:
        InputError: it cannot be read, or lacks a joint.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a bag, a CSV or a Parquet '
                         'file')
    name = path.name.lower()
    if name.endswith(TEXTS):
        columns = _text_columns(path)
    elif name.endswith(TABLES):
        table = opened_table(path, 'parquet')
        columns = {c: np.asarray(table[c].to_numpy(), float) for c in table.column_names
                   if c == 't' or c.startswith(('q_', *PREFIXES))}
    else:
        return _from_bag(path, joints, recorded, no_servo, topic, locked or {})
    raw = _from_columns(path, columns, joints, recorded, constants, no_servo)
    return replace(raw, notes=(*raw.notes, *_locked_notes(locked or {}, {
        name: columns[f'q_{name}'] for name in locked or {} if f'q_{name}' in columns})))


def numbered_names(path: str | Path, joints: Sequence[str], topic: str = 'joint_states'
                   ) -> dict[str, str]:
    """
    Return {joint: its name in a bag whose joints have only numbers, one for each joint}, else {}.

    The only joint of a robot is the motor in the bag of a drive.

    Args:
        path: of the log.
        joints: of the model, in the order of a chain.
        topic: of the joint states.
    """
    path = Path(path)
    if not path.exists() or path.name.lower().endswith((*TEXTS, *TABLES)):
        return {}
    with open_bag(path) as reader:
        names = reader.joint_names(find_topic(reader, topic))
    if len(joints) == 1 and 'motor' in names and joints[0] not in names:
        return {joints[0]: 'motor'}
    numbers = {int(match[1]): name for name in names
               if (match := re.fullmatch(r'joint_(\d+)', name))}
    if len(numbers) != len(names) or set(names) & set(joints) or set(numbers) not in (
            set(range(len(joints))), set(range(1, len(joints) + 1))):
        return {}
    return dict(zip(joints, (numbers[k] for k in sorted(numbers))))


def unsigned(efforts: Array) -> bool:
    """
    Return whether `efforts` [N, J] are sizes: none is below 0, but one comes to 0 and rises again.

    A joint may always push one way, against a weight; but then it does not turn around at 0.
    """
    return not (efforts < 0.0).any() and any((np.trim_zeros(x) == 0.0).any() for x in efforts.T)


def _or_setpoints(no_servo: str) -> str:
    return f', or setpoints; {NEEDED} ({no_servo})' if no_servo else ', or setpoints'


def _text_columns(path: Path) -> dict[str, Array]:
    """Return {column: values} of a text with a header row; an empty value is NaN."""
    header, delimiter = header_of(path, COLUMNS)
    with readable(path):
        text = TextFormat(delimiter=delimiter, header=True)
        for number, line in islice(sample_rows(path, text)[1], 1):
            count = len(split_line(line, text))
            if count != len(header):
                raise InputError(f'{path}: line {number}: {count} values, expected {len(header)}')
    return text_columns(path, header, delimiter, header).values


def _from_columns(path: Path, columns: Mapping[str, Array], joints: Sequence[str],
                  recorded: Mapping[str, str], constants: Mapping[str, float] | None,
                  no_servo: str) -> RawLog:
    if 't' not in columns:
        raise InputError(f'{path}: no column t in {", ".join(columns)[:80]!r}, expected {COLUMNS}')
    names = {joint: recorded.get(joint, joint) for joint in joints}
    _expect_all(path, names, [c.partition('_')[2] for c in columns])
    position = {joint: columns[f'q_{name}'] for joint, name in names.items()
                if f'q_{name}' in columns}
    whole = [p for p in PREFIXES if (p != 'setpoint_' or not no_servo)
             and all(p + name in columns for name in names.values())]
    sizes = [p for p in whole if p != 'setpoint_'
             and unsigned(np.column_stack([columns[p + name] for name in names.values()]))]
    prefix = next((p for p in whole if p not in sizes), None)
    if prefix is None and sizes:
        raise InputError(f'{path}: {sizes[0]}NAME: {UNSIGNED}, expected a torque or current with '
                         f'its sign{_or_setpoints(no_servo)}')
    if prefix is None:
        listed = [c for c in columns if c.startswith(tuple(PREFIXES))]
        hint = f'; {NEEDED} ({no_servo})' if any(
            c.startswith('setpoint_') for c in listed) else ''
        raise InputError(f'{path}: no torque of all joints ({", ".join(listed)[:120] or "none"}), '
                         f'expected tau_NAME, i_NAME or setpoint_NAME of {", ".join(joints)}'
                         f'{hint} (--recorded NAME=LOGNAME maps a name)')
    kind, notes = PREFIXES[prefix], [f'{p}NAME: {UNSIGNED}; not used' for p in sizes]
    inputs = {joint: columns[prefix + name] for joint, name in names.items()}
    if kind == CURRENT and constants is not None:
        lacking = [joint for joint in joints if joint not in constants]
        if lacking:
            raise InputError(f'{path}: torque_constants: none of {", ".join(lacking)}, expected '
                             'N m/A of each joint')
        inputs = {joint: x * constants[joint] for joint, x in inputs.items()}
        notes.append('torque is current times its constant: masses come in the scale of the '
                     'constants (m / K)')
    unused = [c for c in columns if c != 't' and not c.startswith('v_') and c not in {
        f'q_{n}' for n in names.values()} | {prefix + n for n in names.values()}]
    if unused:
        notes.append(f'columns that are not used: {", ".join(unused)[:200]}')
    return RawLog(path.name, columns['t'], position, inputs, kind, kind == CURRENT, tuple(notes))


def _expect_all(path: Path, names: Mapping[str, str], present: Sequence[str]) -> None:
    """Raise InputError if a log with joints `present` has only some of `names` {joint: name}."""
    lacking = [joint for joint, name in names.items() if name not in present]
    if 0 < len(lacking) < len(names):
        raise InputError(f'{path}: no {", ".join(lacking)} in the log, expected all joints of the '
                         f'model (--recorded NAME=LOGNAME maps a name); {STILL}')


def _locked_notes(locked: Mapping[str, float], positions: Mapping[str, Array]) -> list[str]:
    """Return where a log has joints that are `locked`, by their `positions` {joint: [N]}."""
    return [f'{joint}: locked at {locked[joint]:g}; the log has it from {np.nanmin(q):.3g} to '
            f'{np.nanmax(q):.3g}' for joint, q in positions.items() if np.isfinite(q).any()]


def _from_bag(path: Path, joints: Sequence[str], recorded: Mapping[str, str], no_servo: str,
              topic: str, locked: Mapping[str, float]) -> RawLog:
    names = [recorded.get(joint, joint) for joint in joints]
    with open_bag(path) as reader:
        topic = find_topic(reader, topic)
        present = reader.joint_names(topic)
        _expect_all(path, dict(zip(joints, names)), present)
        states = reader.joint_states(topic, names)
        notes = [reader.notice] if reader.notice else []
        unused = [name for name in present if name not in names]
        if unused:
            notes.append(f'joints that are not used: {", ".join(unused)[:200]}')
        seen = [name for name in unused if name in locked]
        if seen:
            notes += _locked_notes(locked, dict(zip(
                seen, reader.joint_states(topic, seen).position.T)))
        t = (states.stamp_ns - states.stamp_ns[0]) * 1e-9
        setpoints = topics_called(reader, SETPOINTS)
        position = dict(zip(joints, states.position.T))
        sizes = unsigned(states.effort)
        if np.isfinite(states.effort).any(axis=0).all() and not sizes:
            return RawLog(path.name, t, position, dict(zip(joints, states.effort.T)), TORQUE,
                          notes=tuple(notes))
        if sizes and (no_servo or not setpoints):
            raise InputError(f'{path}: effort: {UNSIGNED}, expected torques with their sign'
                             f'{_or_setpoints(no_servo)}')
        if sizes:
            notes.append(f'effort: {UNSIGNED}; {SETPOINTS} are used')
        elif no_servo or not setpoints:
            without = [j for j, e in zip(joints, states.effort.T) if not np.isfinite(e).any()]
            raise InputError(
                f'{path}: no effort of {", ".join(without)}, expected the torque of all joints, '
                f'or {SETPOINTS}' + (f'; {NEEDED} ({no_servo})' if no_servo else '')
                + f'; {STILL}')
        goal = reader.joint_states(setpoints[0], names)
        at = (goal.stamp_ns - states.stamp_ns[0]) * 1e-9
        inputs = {}
        for joint, x in zip(joints, goal.position.T):
            good = np.isfinite(x)
            # A servo holds the setpoint until the next one comes.
            row = np.searchsorted(at[good], t, 'right') - 1
            inputs[joint] = np.concatenate([[np.nan], x[good]])[row + 1]
    return RawLog(path.name, t, position, inputs, SETPOINT, notes=tuple(notes))
