# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The samples, model and parameters of a bag that filters run over."""
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from gearbox_monitor.bag.joint_input import find_input
from gearbox_monitor.bag.read import BagReader
from gearbox_monitor.bag.recorded_samples import read_samples, RecordedSamples
from gearbox_monitor.bag.recorded_snapshots import NO_MODEL, read_snapshots
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.parameters import EstimatorParameters, MODEL, resolve
from gearbox_monitor.plant.drive import DriveModel


class StatedInputs(NamedTuple):
    """
    What a user states beside a bag, which replaces what is recorded in it.

    topic: of the inputs. values {name: value} of the estimator, from the file `source`, '' for
    none. model_file: of the drive, '' for none.
    """

    topic: str
    values: Values
    source: str
    model_file: str


@dataclass(frozen=True)
class FilterInputs:
    """
    A recording, the DriveModel (from model_file, '' for none) and all parameters.

    model_values: values of the model that the parameter file sets besides. notes: sentences for
    the user.
    """

    recording: RecordedSamples
    model: DriveModel
    model_file: str
    parameters: EstimatorParameters
    model_values: dict[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def samples(self) -> Samples:
        """The Samples of the recording."""
        return self.recording.samples


def load_filter_inputs(reader: BagReader, stated: StatedInputs,
                       usual: Values = MappingProxyType({})) -> FilterInputs:
    """
    Return the inputs of a bag, as replay reads them.

    Model and parameters are those that an estimator has recorded, else defaults; files replace
    what they name.

    Args:
        reader: of the bag.
        stated: by the user.
        usual: {name: value} of parameters that neither the bag nor a file states.

    Returns:
        What a filter is run on and with.

    Raises:
        InputError: a parameter or the bag is unusable.

    """
    source = find_input(reader, stated.topic)
    model, recorded = DriveModel(), dict[str, Any]()
    snapshots = read_snapshots(reader, source)
    if snapshots:
        model, recorded = snapshots[0].settings(str(reader.path))
    if stated.model_file:
        model = load_model(stated.model_file)
    values = {**usual, **recorded, **stated.values}
    values.pop('model', None)
    model, parameters = resolve(model, values, stated.source or str(reader.path))
    recording = read_samples(reader, parameters.motor_joint, parameters.arm_joint, model,
                             source.topic, source.transmission)
    notes = [] if snapshots or stated.model_file else [NO_MODEL]
    notes += [reader.notice] if reader.notice else []
    changed = {row.name: stated.values[row.name] for row in MODEL if row.name in stated.values}
    return FilterInputs(recording, model, stated.model_file, parameters, changed, tuple(notes))
