# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The inputs of commands that run filters over a bag, by their options."""
from argparse import Namespace
from types import MappingProxyType

from gearbox_monitor.bag.read import BagReader
from gearbox_monitor.cli.options import check_filter, estimator_options
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.library import filter_inputs
from gearbox_monitor.library.filter_inputs import FilterInputs, StatedInputs


def load_filter_inputs(args: Namespace, reader: BagReader, filter_name: str | None = None,
                       usual: Values = MappingProxyType({})) -> FilterInputs:
    """
    Return the inputs of a bag, as replay reads them.

    Args:
        args: options of add_estimator_arguments.
        reader: of the bag.
        filter_name: filter to run, None: that of the parameters.
        usual: {name: value} of parameters that neither the bag nor a file states.

    Returns:
        What a filter is run on and with.

    Raises:
        InputError: an option or the bag is unusable.

    """
    options, model_file = estimator_options(args)
    if filter_name:
        options['filter'] = check_filter(filter_name)
    return filter_inputs.load_filter_inputs(
        reader, StatedInputs(args.topic, options, args.params or '', model_file), usual)
