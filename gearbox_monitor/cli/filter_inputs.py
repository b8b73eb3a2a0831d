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
