# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The setpoints of a robot in a file of their own, beside that of its states.

The names of both differ only in words of the vocabulary (`meaning`): 'run3_state_motor.csv' and
'run3_control.csv', 'joint_states.csv' and 'joint_commands.csv'. Both have the same clock.
"""
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.importer.guess_time import found_time, FoundTime
from gearbox_monitor.recordings.importer.layout import JOINT_LIST, recognised_layout
from gearbox_monitor.recordings.importer.meaning import (
    meanings, POSITION, run_of, with_listed_names)

TABLES = ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')
OVERLAP = 0.5  # of the time of the states, in which setpoints of the same run stand


def _files_beside(path: Path, setpoints: bool) -> list[Path]:
    """Return the files with `setpoints`, or states, of the run whose other ones `path` holds."""
    own, run = run_of(_stem(path))
    return [] if own == setpoints else sorted(
        file for file in path.parent.iterdir()
        if file.suffixes == path.suffixes and run_of(_stem(file)) == (setpoints, run))


def states_beside(path: Path, time: FoundTime, joints: Mapping[str, Mapping[str, Any]]
                  ) -> str:
    """
    Return the name of a file with the states of the run whose setpoints `path` holds, '' for none.

    Args:
        path: of what is imported.
        time: of it.
        joints: {joint: {quantity: block of the mapping}} of it.
    """
    return next((file.name for file in _files_beside(path, False)
                 if _setpoints_in(file, time, joints) is not None), '')


def _stem(path: Path) -> str:
    return path.name.partition('.')[0]


def sibling_setpoints(path: Path, time: FoundTime, states: Mapping[str, Mapping[str, Any]]
                      ) -> list[dict[str, Any]]:
    """
    Return the blocks second_file of a mapping, one for each file with setpoints beside `path`.

    Args:
        path: of the states.
        time: of the states.
        states: {joint: {quantity: block of the mapping}} of the states.
    """
    return [block for file in _files_beside(path, True)
            if (block := _setpoints_in(file, time, states)) is not None]


def _setpoints_in(path: Path, time: FoundTime, states: Mapping[str, Mapping[str, Any]]
                  ) -> dict[str, Any] | None:
    """Return the block second_file for the file `path`, None: it has other joints or times."""
    try:
        layout = recognised_layout(path)
    except InputError:
        return None
    own = found_time(path, layout.series, {})
    if own is None or time.column is None or min(own.end, time.end) - max(
            own.start, time.start) < OVERLAP * (time.end - time.start):
        return None
    series = [column for column in layout.series if column.label not in own.labels]
    setpoints = {meaning.joint: column for meaning, column in zip(with_listed_names(meanings(
        [c.label for c in series], [c.unit for c in series]), layout.joints), series)
        if meaning.quantity == POSITION}
    if set(setpoints) != set(states):
        return None
    blocks = {}
    for joint, column in setpoints.items():
        scaling = {key: value for key, value in states[joint].get('position', {}).items()
                 if key in ('unit', 'scale', 'counts_per_rev')}
        blocks[joint] = {'setpoint': {**column.place, **(
            {'unit': column.unit} if column.unit else scaling)}}
    return {'path': path.name, 'lag': 0.0, **layout.blocks, 'time': own.block, 'joints': blocks}


def state_files(folder: Path) -> list[Path]:
    """Return the recordings in a folder: episodes, those with setpoints beside, or all tables."""
    episodes = sorted(folder.glob('data/**/*.parquet'))
    if episodes:
        return episodes
    tables = sorted(file for file in folder.iterdir() if file.is_file()
                    and file.name.endswith(TABLES) and file.name != JOINT_LIST)
    return [file for file in tables if _files_beside(file, True)] or tables
