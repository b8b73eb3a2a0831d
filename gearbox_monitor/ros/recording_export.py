# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a RecordingBuffer as bags ready to diagnose. No ROS here; slow, so call it from a thread.

The folder holds `all`, the bag with all rows; `bag`, the stretch to diagnose; and `drive.yaml`,
the model.
"""
from collections.abc import Callable
from dataclasses import dataclass
import os
from pathlib import Path
import re
import shlex
import shutil
from threading import Lock
import time

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import save_model
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.write import BagWriter, WriteError
from gearbox_monitor.ros.recording_buffer import ARM_EFFORT, MIN_STRETCH, Rows, SECOND, stretch
from gearbox_monitor.signals.admission import prepared, weighed
from gearbox_monitor.signals.recording import UniformRecording

JOINT_STATE = 'sensor_msgs/msg/JointState'
PATTERN = 'kept_%Y_%m_%d-%H_%M_%S'
KEPT = re.compile(r'kept_\d{4}_\d\d_\d\d-\d\d_\d\d_\d\d(_\d+)?')
# No gearbox deletes what another one is writing.
TURN = Lock()
# The thread that estimates waits for this one only while a chunk is encoded.
CHUNK, PAUSE = 100, 1e-3
MB = 10 ** 6
ROW_BYTES = 200  # of a message in a bag, not compressed
SPARE = 500 * MB  # of the disk stay free


@dataclass(frozen=True)
class RecordingContext:
    """
    Where a recording comes from: `topic`, `joints` (motor, arm), `model` as it was read.

    arm_load: in force; parameters: of the estimator; reason: why the recording is kept.
    """

    topic: str
    joints: tuple[str, str]
    model: DriveModel
    arm_load: str
    parameters: EstimatorParameters
    reason: str


def export_recording(parent: str | Path, rows: Rows, context: RecordingContext,
                     clock: Callable[[], time.struct_time] = time.localtime) -> str:
    """
    Write a recording into a new folder; then delete the oldest ones beyond keep_newest.

    Args:
        parent: folder of all recordings.
        rows: of a RecordingBuffer.
        context: where the rows come from.
        clock: gives the time that the folder is named after.

    Returns:
        A text for the user: what was written, and the command that diagnoses it.

    Raises:
        InputError: nothing could be written; then the folder is removed again.

    """
    parent = Path(os.path.abspath(os.path.expanduser(parent)))
    with TURN:
        folder = _new_folder(parent, clock)
        try:
            text = _write_folder(folder, rows, context)
        except BaseException as error:
            shutil.rmtree(folder, ignore_errors=True)  # a full disk shall not stay full
            if isinstance(error, WriteError):  # it ends with what the bag still holds
                raise InputError(f'{str(error).rpartition(";")[0]}; removed again, the '
                                 'measurement is still in memory') from None
            raise
        _delete_oldest(folder, context.parameters.keep_newest)
    return text


def _write_folder(folder: Path, rows: Rows, context: RecordingContext) -> str:
    """Write all bags and files of a recording; see export_recording."""
    size, free = 2 * ROW_BYTES * len(rows), shutil.disk_usage(folder).free
    if size > free - SPARE:
        raise InputError(f'{folder.parent}: {free / MB:.0f} MB are free, expected '
                         f'{(size + SPARE) / MB:.0f} MB; the measurement is still in memory')
    part = stretch(rows, context.parameters.effort_delay)
    _write(folder / 'all', rows, context)
    text = f'{_seconds(rows):.1f} s kept in {folder / "all"}; '
    if not len(part):
        return text + (f'no {MIN_STRETCH:g} s of them without a dropout, with torque and '
                       'positions, as a diagnosis needs')
    _write(folder / 'bag', part, context)
    save_model(folder / 'drive.yaml', context.model.with_(
        arm_load=load_of(part, context.model, context.arm_load)), [
        f'Model of the estimator whose measurement is in {folder.name}.',
        f'Written by gearbox_monitor {__version__}.'])
    return text + f'the best {_seconds(part):.1f} s of it: {diagnosis_command(folder, context)}'


def _delete_oldest(newest: Path, count: int) -> None:
    """Delete the oldest recordings in the folder of `newest`, so that `count` remain."""
    others = [path for path in newest.parent.iterdir()
              if KEPT.fullmatch(path.name) and path != newest]
    others.sort(key=lambda path: path.stat().st_mtime_ns)
    for path in others[:len(others) + 1 - count]:
        shutil.rmtree(path, ignore_errors=True)


def diagnosis_command(folder: Path, context: RecordingContext) -> str:
    """Return the shell command that diagnoses the recording of `context` in `folder`."""
    words: list[str | Path] = ['gearbox_monitor', 'diagnose', folder / 'bag', '--model',
                               folder / 'drive.yaml']
    if not context.topic.endswith('/joint_states'):
        words += ['--topic', context.topic]
    for option, joint in zip(('motor', 'arm'), context.joints):
        words += [f'--recorded-{option}', joint] if joint != option else []
    return shlex.join(map(str, words))


def _new_folder(parent: Path, clock: Callable[[], time.struct_time]) -> Path:
    """Make and return a new folder in `parent`."""
    name, path = time.strftime(PATTERN, clock()), parent
    for number in range(1, 100):
        path = parent / (name if number == 1 else f'{name}_{number}')
        try:
            path.mkdir(parents=True)
            return path
        except FileExistsError:
            continue
        except OSError as error:
            raise InputError(f'{path}: {error.strerror}, expected a folder that can be made; '
                             'see parameter keep_folder') from None
    raise InputError(f'{path}: exists already, expected a new folder')


def _seconds(rows: Rows) -> float:
    """Return the time between the first and the last good stamp."""
    stamps = rows['stamp_ns'][rows['good']]
    return float(stamps[-1] - stamps[0]) / SECOND if len(stamps) else 0.0


def load_of(rows: Rows, model: DriveModel, arm_load: str) -> str:
    """
    Return the arm_load to diagnose with: a load counts as measured only if the rows have it.

    Args:
        rows: of the recording.
        model: of the model file.
        arm_load: in force.
    """
    load = 'measured' if 'measured' in (model.arm_load, arm_load) else model.arm_load
    if load == 'measured' and not np.isfinite(rows['values'][:, ARM_EFFORT]).all():
        return 'unknown'
    return load


def recording_of(rows: Rows, model: DriveModel, name: str) -> UniformRecording:
    """
    Return the rows of a stretch as a recording to diagnose.

    Args:
        rows: see recording_buffer.stretch.
        model: of the drive, with the load to diagnose with.
        name: of the recording in messages.

    Raises:
        InputError: the rows allow no statement about the drive.
    """
    motor, arm, effort, arm_effort = rows['values'].T
    recording, _ = prepared(
        rows['stamp_ns'], model.effort_scale * effort,
        np.column_stack([motor / model.gear_ratio, arm]), arm_effort, name, None, model,
        'the model file')
    return weighed(recording, model)[0]


def _write(path: Path, rows: Rows, context: RecordingContext) -> None:
    """Write the new bag `path`: every row one message on the topic, logged at its stamp."""
    metadata = {'version': __version__, 'source': f'estimator: {context.reason}',
                **{f'estimator.{name}': value for name, value
                   in context.parameters.to_dict().items()}}
    with BagWriter(path) as writer:
        writer.add_metadata('gearbox_monitor', metadata)
        writer.add_topic(context.topic, JOINT_STATE)
        joints = [joint for joint in context.joints if joint]
        n = len(joints)
        for begin in range(0, len(rows), CHUNK):
            part = rows[begin:begin + CHUNK]
            values = part['values']
            messages = encode_joint_states(part['stamp_ns'], joints, values[:, :n],
                                           effort=values[:, 2:2 + n])
            for stamp_ns, message in zip(part['stamp_ns'].tolist(), messages):
                writer.write(context.topic, max(stamp_ns, 0), message)
            time.sleep(PAUSE)
