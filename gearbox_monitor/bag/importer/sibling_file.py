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

"""The setpoints of a robot in a file of their own, beside that of its states."""
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gearbox_monitor.bag.importer.layout import recognised_layout
from gearbox_monitor.errors import InputError

PAIRS = (('state_motor', 'control'), ('states', 'commands'), ('state', 'command'),
         ('state', 'control'))


def sibling_setpoints(path: Path, joints: Sequence[str], blocks: Mapping[str, Any]
                      ) -> dict[str, Any] | None:
    """
    Return the block second_file of a mapping, None where no setpoints stand beside `path`.

    Args:
        path: of the states, '..._state_motor.csv' beside '..._control.csv'.
        joints: of the robot, in the order of its lists.
        blocks: of the mapping that describe the format.
    """
    for states, commands in PAIRS:
        if states not in path.name:
            continue
        beside = path.with_name(path.name.replace(states, commands))
        if beside == path or not beside.is_file():
            continue
        try:
            series = recognised_layout(beside).series
        except InputError:
            continue
        columns = [column for column in series if str(column.label).partition('.')[0] in (
            'positions', 'position', 'q', 'joint_positions')]
        time = next((column for column in series if column.label in (
            'timestamp', 'time', 't')), None)
        if time is None or len(columns) != len(joints):
            continue
        return {'path': beside.name, 'lag': 0.0, **blocks,
                'time': {**time.place, 'unit': 'us'}, 'joints': {
                    joint: {'setpoint': dict(column.place)}
                    for joint, column in zip(joints, columns)}}
    return None


def state_files(folder: Path) -> list[Path]:
    """Return the recordings in a folder: '*state_motor*', those of a data set, or all tables."""
    states = sorted(file for file in folder.iterdir() if 'state_motor' in file.name)
    if states:
        return states
    episodes = sorted(folder.glob('data/**/*.parquet'))
    if episodes:
        return episodes
    return sorted(file for file in folder.iterdir() if file.is_file() and file.name.endswith(
        ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')))
