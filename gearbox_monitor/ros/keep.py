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

"""
Write what a Ring holds as bags ready to diagnose. No ROS here; slow, so call it from a thread.

The folder: `all`, the bag with everything that came; `bag`, the stretch of it to diagnose;
`drive.yaml`, the model beside it.
"""
from dataclasses import dataclass
import os
from pathlib import Path
import shlex
import shutil
import time

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.write import BagWriter, WriteError
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import save_model
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.ring import ARM_EFFORT, LEAST, SECOND, stretch

JOINT_STATE = 'sensor_msgs/msg/JointState'
PATTERN = 'kept_%Y_%m_%d-%H_%M_%S'
# The thread that estimates waits for this one no longer than a bunch takes.
BUNCH, PAUSE = 100, 1e-3


@dataclass(frozen=True)
class About:
    """
    Whose measurement it is: topic, joints (motor, arm), model, arm_load in force, parameters, why.

    parameters: of the estimator; model: the DriveModel as it was read.
    """

    topic: str
    joints: tuple
    model: DriveModel
    arm_load: str
    parameters: EstimatorParameters
    why: str


def keep(parent, rows, about, clock=time.localtime):
    """
    Write `rows` (Ring.rows) into a new folder in `parent`; return what to tell the user.

    Raises InputError where nothing could be written; then nothing of it is left.
    """
    folder = _new_folder(Path(os.path.abspath(os.path.expanduser(parent))), clock)
    try:
        part = stretch(rows, about.parameters.effort_delay)
        _write(folder / 'all', rows, about)
        text = f'{_seconds(rows):.1f} s kept in {folder / "all"}; '
        if not len(part):
            return text + (f'no {LEAST:g} s of them without a gap, with torque and positions, as '
                           'a diagnosis needs')
        _write(folder / 'bag', part, about)
        save_model(folder / 'drive.yaml', _model(part, about), [
            f'Model of the estimator whose measurement is in {folder.name}.',
            f'Written by gearbox_monitor {__version__}.'])
    except BaseException as error:
        shutil.rmtree(folder, ignore_errors=True)  # a full disk shall not stay full
        if isinstance(error, WriteError):  # it ends with what the bag still holds
            raise InputError(f'{str(error).rpartition(";")[0]}; removed again, the measurement '
                             'is still in memory') from None
        raise
    return text + f'the best {_seconds(part):.1f} s of it: {command(folder, about)}'


def command(folder, about):
    """Return the shell command that diagnoses what keep() has written to `folder`."""
    words = ['gearbox_monitor', 'diagnose', folder / 'bag', '--model', folder / 'drive.yaml']
    if not about.topic.endswith('/joint_states'):
        words += ['--topic', about.topic]
    for option, joint in zip(('motor', 'arm'), about.joints):
        words += [f'--{option}-joint', joint] if joint != option else []
    return shlex.join(map(str, words))


def _new_folder(parent, clock):
    """Return a folder that did not exist before."""
    name, path = time.strftime(PATTERN, clock()), None
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


def _seconds(rows):
    """Return the time between the first and the last good stamp."""
    stamps = rows['stamp_ns'][rows['good']]
    return float(stamps[-1] - stamps[0]) / SECOND if len(stamps) else 0.0


def _model(rows, about):
    """Return the model to diagnose with: a load is measured only where the rows have it."""
    told = (about.model.arm_load, about.arm_load)
    load = 'measured' if 'measured' in told else about.model.arm_load
    if load == 'measured' and not np.isfinite(rows['values'][:, ARM_EFFORT]).all():
        load = 'unknown'
    return about.model.with_(arm_load=load)


def _write(path, rows, about):
    """Write the new bag `path`: every row one message on the topic, logged at its stamp."""
    metadata = {'version': __version__, 'source': f'estimator: {about.why}',
                **{f'estimator.{name}': value for name, value
                   in about.parameters.to_dict().items()}}
    with BagWriter(path) as writer:
        writer.add_metadata('gearbox_monitor', metadata)
        writer.add_topic(about.topic, JOINT_STATE)
        for begin in range(0, len(rows), BUNCH):
            part = rows[begin:begin + BUNCH]
            messages = encode_joint_states(part['stamp_ns'], about.joints,
                                           part['values'][:, :2], effort=part['values'][:, 2:])
            for stamp_ns, message in zip(part['stamp_ns'].tolist(), messages):
                writer.write(about.topic, max(stamp_ns, 0), message)
            time.sleep(PAUSE)
