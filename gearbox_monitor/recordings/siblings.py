# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The setpoints of a robot in a file of their own, beside that of its states.

The names of both differ only in words of the vocabulary: 'run3_state_motor.csv' and
'run3_control.csv', 'joint_states.csv' and 'joint_commands.csv'. Both have the same clock.
"""
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.log_units import POSITION
from gearbox_monitor.recordings.meaning import meanings, run_of, SETPOINT
from gearbox_monitor.recordings.table import Column, JOINT_LIST, load_table, Table
from gearbox_monitor.recordings.times import found_time, FoundTime

TABLES = ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')
OVERLAP = 0.5  # of the time of the states, in which setpoints of the same run stand
BESIDE = 'setpoint: '  # in front of the names of columns of such a file


def _files_beside(path: Path, setpoints: bool) -> list[Path]:
    """Return the files with `setpoints`, or states, of the run whose other ones `path` holds."""
    own, run = run_of(path.name.partition('.')[0])
    return [] if own == setpoints else sorted(
        file for file in path.absolute().parent.iterdir() if file.suffixes == path.suffixes
        and file.is_file() and run_of(file.name.partition('.')[0]) == (setpoints, run))


Motion: TypeAlias = tuple[Table, FoundTime, dict[str, Column]]  # position of each joint


def _motion_of(table: Table, foreign: str | None = None) -> Motion | None:
    """Return the positions in a table; None: no time, or one whose source is `foreign`."""
    time = found_time(table.path, table.columns, {})
    columns = [c for c in table.columns if c.values.dtype.kind in 'iuf'
               and (time is None or c.name not in time.labels)]
    listed = meanings([c.name for c in columns], [c.unit for c in columns], table.joints)
    positions = [(m, c) for m, c in zip(listed, columns) if m.quantity == POSITION]
    if time is None or not time.named or any(m.source == foreign for m, _ in positions):
        return None
    return table, time, {m.joint: c for m, c in positions}


def _motions_beside(table: Table, setpoints: bool) -> list[Motion]:
    """Return the motions of the same joints and time in files beside, of `setpoints` or states."""
    files, fitting = _files_beside(table.path, setpoints), []
    own = _motion_of(table, SETPOINT if setpoints else None) if files else None
    for file in files if own else ():
        try:
            other = _motion_of(load_table(file, whole=True))
        except InputError:
            continue
        if own and other and len(own[2]) > 1 and set(other[2]) == set(own[2]):
            (begin, end), (first, last) = (
                (time.start, time.start + float(time.t[-1])) for time in (own[1], other[1]))
            if min(last, end) - max(first, begin) >= OVERLAP * (end - begin):
                fitting.append(other)
    return fitting


def states_beside(table: Table) -> str:
    """Return the name of a file with the states whose setpoints a table holds, '' for none."""
    return next((other.path.name for other, *_ in _motions_beside(table, False)), '')


def with_setpoints(table: Table) -> Table:
    """
    Return the `table` of a robot's states with the setpoints in a file beside it, if there is one.

    The names of their columns begin with BESIDE. Raises Undecided: several files have them.
    """
    fitting = _motions_beside(table, True)
    names = ', '.join(other.path.name for other, *_ in fitting)
    if len(fitting) > 1:
        raise Undecided(f'{table.path}: {names}: setpoints of the same joints and time beside it, '
                        'expected --use setpoint=none, or one of the files')
    for other, time, positions in fitting:
        table = load_table(table.path, whole=True) if table.streamed else table
        table = replace(table, rows=None, streamed=False, columns=(
            *table.columns, *(replace(c, name=BESIDE + c.name) for c in other.columns
                              if c.name in time.labels),
            *(replace(c, name=BESIDE + c.name, clock=BESIDE + time.labels[0])
              for c in positions.values())),
            notes=(*table.notes, f'setpoints: {names} beside it, on the same clock'))
    return table


def file_in(path: Path) -> Path:
    """Return the file of a recording: `path`, or the only one in the folder `path`."""
    if not path.is_dir():
        return path
    files = sorted(path.glob('data/**/*.parquet'))
    if not files:  # episodes, those with setpoints beside, or all tables
        tables = sorted(file for file in path.iterdir() if file.is_file()
                        and file.name.endswith(TABLES) and file.name != JOINT_LIST)
        files = [file for file in tables if _files_beside(file, True)] or tables
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file and no log, expected a recording')
    if len(files) != 1:
        names = ', '.join(file.name for file in files[:12])
        raise Undecided(f'{path}: {len(files)} recordings, expected the path of one of them: '
                        f'{names}')
    return files[0]
