# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The samples, model and parameters of a bag that commands run filters over."""
from argparse import Namespace
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from gearbox_monitor.cli.options import check_filter, estimator_options
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.parameters import EstimatorParameters, MODEL, resolve
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.joint_input import find_input, JointInput
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import (
    NO_MODEL, read_samples, read_snapshots, RecordedSamples)


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


def settings_of(args: Namespace, reader: BagReader, source: JointInput, stated: Values,
                model_file: str, usual: Values = MappingProxyType({})
                ) -> tuple[DriveModel, EstimatorParameters, bool]:
    """
    Return (model, parameters, whether the model is that of a file or of the bag).

    Both are those that an estimator has recorded, else defaults.

    Args:
        args: options of add_estimator_arguments.
        reader: of the bag.
        source: the estimator's inputs in it.
        stated: {name: value} that replace recorded parameters.
        model_file: that replaces the recorded model, '' for none.
        usual: {name: value} of parameters that neither the bag nor `stated` has.

    Raises:
        InputError: a parameter or a value of the model is unusable.

    """
    model, recorded = None, dict[str, Any]()
    snapshots = read_snapshots(reader, source, not model_file)
    if snapshots:
        model, recorded = snapshots[0].settings(str(reader.path))
    if model_file:
        model = load_model(model_file)
    values = {**usual, **recorded, **stated}
    values.pop('model', None)
    changed, parameters = resolve(model or DriveModel(), values, args.params or str(reader.path))
    return changed, parameters, model is not None


def load_filter_inputs(args: Namespace, reader: BagReader, filter_name: str | None = None,
                       usual: Values = MappingProxyType({})) -> FilterInputs:
    """
    Return the inputs of a bag, as replay reads them.

    Model and parameters are those that an estimator has recorded, else defaults; files replace
    what they name.

    Args:
        args: options of add_estimator_arguments.
        reader: of the bag.
        filter_name: filter to run, None: that of the parameters.
        usual: {name: value} of parameters that neither the bag nor a file states.

    Returns:
        What a filter is run on and with.

    Raises:
        InputError: an option, a parameter or the bag is unusable.

    """
    stated, model_file = estimator_options(args)
    if filter_name:
        stated['filter'] = check_filter(filter_name)
    source = find_input(reader, args.topic)
    model, parameters, is_known = settings_of(args, reader, source, stated, model_file, usual)
    recording = read_samples(reader, parameters.motor_joint, parameters.arm_joint, model,
                             source.topic, source.transmission)
    notes = [] if is_known else [NO_MODEL]
    notes += [reader.notice] if reader.notice else []
    changed = {row.name: stated[row.name] for row in MODEL if row.name in stated}
    return FilterInputs(recording, model, model_file, parameters, changed, tuple(notes))
