# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The setpoints of a robot in a file of their own, beside that of its states.

The names of both differ only in words of the vocabulary: 'run3_state_motor.csv' and
'run3_control.csv', 'joint_states.csv' and 'joint_commands.csv'. Both have the same clock.
"""
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.log_units import POSITION
from gearbox_monitor.recordings.meaning import meanings, run_of
from gearbox_monitor.recordings.table import JOINT_LIST, load_table
from gearbox_monitor.recordings.times import found_time, FoundTime

TABLES = ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')
OVERLAP = 0.5  # of the time of the states, in which setpoints of the same run stand
Joints = Mapping[str, Mapping[str, Any]]


def _files_beside(path: Path, setpoints: bool) -> list[Path]:
    """Return the files with `setpoints`, or states, of the run whose other ones `path` holds."""
    own, run = run_of(path.name.partition('.')[0])
    return [] if own == setpoints else sorted(
        file for file in path.absolute().parent.iterdir() if file.suffixes == path.suffixes
        and file.is_file() and run_of(file.name.partition('.')[0]) == (setpoints, run))


def states_beside(path: Path, time: FoundTime, joints: Joints) -> str:
    """
    Return the name of a file with the states of the run whose setpoints `path` holds, '' for none.

    Args:
        path: of what is read.
        time: of it.
        joints: {joint: {quantity: block of the mapping}} of it.
    """
    return next((file.name for file in _files_beside(path, False)
                 if _setpoints_in(file, time, joints) is not None), '')


def sibling_setpoints(path: Path, time: FoundTime, states: Joints) -> list[dict[str, Any]]:
    """
    Return the blocks second_file of a mapping, one for each file with setpoints beside `path`.

    Args:
        path: of the states.
        time: of the states.
        states: {joint: {quantity: block of the mapping}} of the states.
    """
    return [block for file in _files_beside(path, True)
            if (block := _setpoints_in(file, time, states)) is not None]


def _setpoints_in(path: Path, time: FoundTime, states: Joints) -> dict[str, Any] | None:
    """Return the block second_file for the file `path`, None: it has other joints or times."""
    try:
        table = load_table(path)
    except InputError:
        return None
    own = found_time(path, table.columns, {})
    if own is None or not time.named:
        return None
    end, own_end = time.start + float(time.t[-1]), own.start + float(own.t[-1])
    if min(own_end, end) - max(own.start, time.start) < OVERLAP * (end - time.start):
        return None
    columns = [c for c in table.columns if c.name not in own.labels
               and c.values.dtype.kind in 'iuf']
    setpoints = {meaning.joint: column for meaning, column in zip(meanings(
        [c.name for c in columns], [c.unit for c in columns], table.joints), columns)
        if meaning.quantity == POSITION}
    if set(setpoints) != set(states):
        return None
    blocks = {}
    for joint, column in setpoints.items():
        scaling = {key: value for key, value in states[joint].get('position', {}).items()
                   if key in ('unit', 'scale', 'counts_per_rev')}
        blocks[joint] = {'setpoint': {'column': column.name, **(
            {'unit': column.unit} if column.unit else scaling)}}
    return {'path': path.name, 'lag': 0.0, 'time': own.block, 'joints': blocks}


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
