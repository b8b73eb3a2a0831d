# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Read the snapshots of an estimator (state, parameters, input counter) from a bag."""
from collections.abc import Mapping
from dataclasses import dataclass
import json
import re
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.snapshot import expect_format, SnapshotError
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.recordings.joint_input import JointInput, snapshot_of
from gearbox_monitor.recordings.read import BagReader

NO_SERIAL = ('no gearbox_serial is recorded: taken for the same gearbox as all bags without one; '
             '--gearbox names gearboxes by the path')
NO_MODEL = ('the bag records no model and --model names none: the values of the packaged '
            'drive.yaml were used, which are wrong for any other drive')


@dataclass(frozen=True)
class RecordedSnapshot:
    """One recorded snapshot: `content` {name: text} (Monitor.snapshot) logged at `log_ns`."""

    content: Mapping[str, str]
    log_ns: int

    @property
    def stamp_ns(self) -> int:
        """Stamp of the sample that precedes it, 0 without one."""
        return int(self.content['stamp_ns'])

    @property
    def input_count(self) -> int:
        """Number of samples that the estimator had taken."""
        return int(self.content['input_count'])

    def settings(self, source: str) -> tuple[DriveModel, dict[str, Any]]:
        """
        Return (DriveModel, {parameter: value}) that the estimator used.

        Raises InputError, in which `source` names the bag.
        """
        try:
            model, parameters = (dict(json.loads(self.content[name]))
                                 for name in ('model', 'parameters'))
        except (KeyError, ValueError, TypeError, RecursionError):
            raise InputError(f'{source}: snapshot: no model and parameters, expected what an '
                             'estimator writes') from None
        return model_from_dict(model, f'{source}: snapshot'), parameters


def read_snapshots(reader: BagReader, joint_input: JointInput, is_needed: bool = True
                   ) -> list[RecordedSnapshot]:
    """
    Return the snapshots of an estimator.

    Args:
        reader: of the bag.
        joint_input: of the estimator.
        is_needed: whether the model comes from them: else those of another version are left out.

    Returns:
        The snapshots, [] without one.

    Raises:
        InputError: a snapshot is of another version, or a stamp or a counter is no whole number.
    """
    if joint_input.snapshots is None:
        return []
    contents = ((log_ns, snapshot_of(reader, raw))
                for _, log_ns, _, raw in reader.messages([joint_input.snapshots]))
    snapshots = [RecordedSnapshot(content, log_ns) for log_ns, content in contents if content]
    try:
        for snapshot in snapshots:
            expect_format(snapshot.content, f'{reader.path}: snapshot')
    except SnapshotError:
        if is_needed:
            raise
        return []
    for snapshot in snapshots:
        for name in ('stamp_ns', 'input_count'):
            value = snapshot.content.get(name, '')
            if not re.fullmatch('-?[0-9]{1,18}|[0-9]{19}', value):
                raise InputError(f'{reader.path}: snapshot: {name}: {value!r}, expected a whole '
                                 'number')
    return snapshots
