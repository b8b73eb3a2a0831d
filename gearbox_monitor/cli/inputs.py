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

"""What commands that run filters over a bag share: its samples, model and parameters."""
from dataclasses import dataclass

from gearbox_monitor.bag.joint_input import find_input
from gearbox_monitor.bag.replay import read_samples, read_snapshots, RecordedSamples
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import load_model, load_parameters
from gearbox_monitor.parameters import (
    EstimatorParameters, FILTER_NAMES, MODEL, resolve, SETTINGS)
from gearbox_monitor.plant.drive import DriveModel


@dataclass(frozen=True)
class Inputs:
    """
    A recording, the DriveModel (from model_file, '' when none) and all parameters.

    model_values: those of the model that the parameter file gave besides.
    """

    recording: RecordedSamples
    model: DriveModel
    model_file: str
    parameters: EstimatorParameters
    model_values: dict

    @property
    def samples(self):
        """The Samples of the recording."""
        return self.recording.samples


def add_input_arguments(parser):
    """Declare the options that :func:`load` reads."""
    parser.add_argument('bag', help='bag directory or .mcap file, whole or cut')
    parser.add_argument('--model', metavar='FILE', help='model file of the drive')
    parser.add_argument('--params', metavar='FILE', help='ROS parameter file of the estimator')
    parser.add_argument('--topic', default='joint_states', help='topic of the inputs')


def check_filter(name, more=()):
    """Return `name` of a filter. Raises InputError."""
    names = (*FILTER_NAMES, *more)
    if name not in names:
        raise InputError(f'filter: {name!r}, expected one of {", ".join(names)}')
    return name


def load(args, reader, filter_name=None):
    """
    Return the Inputs of the bag `reader` under the options `args`.

    As replay does: model and parameters that an estimator has recorded, else defaults; files
    given replace what they name. Raises InputError.
    """
    given = (load_parameters(args.params, 'estimator', SETTINGS, args.topic)
             if args.params else {})
    model_file = args.model or given.pop('model', '')
    found = find_input(reader, args.topic)
    model, recorded = DriveModel(), {}
    snapshots = read_snapshots(reader, found)
    if snapshots:
        model, recorded = snapshots[0].used(reader.path)
    if model_file:
        model = load_model(model_file)
    values = {**recorded, **given}
    values.pop('model', None)
    if filter_name:
        values['filter'] = check_filter(filter_name)
    model, parameters = resolve(model, values, args.params or str(reader.path))
    recording = read_samples(reader, parameters.motor_joint, parameters.arm_joint, model,
                             found.topic)
    return Inputs(recording, model, model_file, parameters,
                  {name: given[name] for name in [row.name for row in MODEL] if name in given})
