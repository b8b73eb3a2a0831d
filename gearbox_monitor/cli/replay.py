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
Run a bag through the estimator, offline, and compare with what was published live.

Without options the recorded parameters and snapshots apply, and every recorded estimate is
compared bit for bit. With --filter, --params or --model the given ones replace the recorded.
--smooth adds columns to the CSV: estimates that know the whole recording (fixed-interval smoother,
with the filter's parameters but for a fifth of the noise density of tau_K and softened friction).

usage examples:
  gearbox_monitor replay gearbox_2026_11_21-10_00_00
  gearbox_monitor replay BAG --model drive.yaml --params estimator.yaml --csv estimates.csv
  gearbox_monitor replay BAG --filter ekf --out BAG2 --json
  gearbox_monitor replay BAG --smooth --csv smoothed.csv

exit code: 0 done, 1 the recorded estimates came out differently, 2 bad usage or input.
"""
import json
from pathlib import Path

import numpy as np

from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.replay import interval_error, replay, smoothed, summary
from gearbox_monitor.bag.replay_output import write_bag
from gearbox_monitor.errors import InputError
from gearbox_monitor.files import load_model, load_parameters
from gearbox_monitor.filters.smoother import S_TAU_K, S_TAU_K_STD, S_TWIST
from gearbox_monitor.parameters import ESTIMATOR, FILTER_NAMES

CSV_COLUMNS = ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_k_std', 'innovation_motor',
               'innovation_arm', 'nis')
SMOOTHED_COLUMNS = {'tau_k_smoothed': S_TAU_K, 'tau_k_smoothed_std': S_TAU_K_STD,
                    'twist_smoothed': S_TWIST}


def add_arguments(parser):
    """Declare the options."""
    parser.add_argument('bag', help='bag directory or .mcap file, whole or cut')
    parser.add_argument('--filter', help=f'filter to use: {", ".join(FILTER_NAMES)}')
    parser.add_argument('--params', metavar='FILE', help='ROS parameter file of the estimator')
    parser.add_argument('--model', metavar='FILE', help='model file of the drive')
    parser.add_argument('--topic', default='joint_states', help='topic of the inputs')
    parser.add_argument('--out', metavar='BAG2', help='write inputs and estimates to a new bag')
    parser.add_argument('--csv', metavar='FILE', help='write the estimates as CSV')
    parser.add_argument('--smooth', action='store_true',
                        help='smooth over the whole recording; columns for --csv')
    parser.add_argument('--json', action='store_true', help='print the summary as JSON')


def run(args):
    """Run the command; returns the exit code."""
    parameters = load_parameters(args.params, 'estimator', ESTIMATOR) if args.params else {}
    # In a parameter file the model is a path; replay takes the model itself.
    model_file = args.model or parameters.pop('model', '')
    if args.filter:
        parameters['filter'] = args.filter
    for path in (args.out, args.csv):
        if path and Path(path).exists():
            raise InputError(f'{path}: exists, expected a new file')
    with open_bag(args.bag) as reader:
        model = load_model(model_file) if model_file else None
        result = replay(reader, model, parameters, args.topic)
        whole = smoothed(result) if args.smooth else None
        if args.csv:
            write_csv(args.csv, result.estimates, whole)
        if args.out:
            write_bag(args.out, reader, result)
        data = summary(reader, result)
        if args.smooth:
            data['tau_k_error_whole'] = interval_error(reader, result, whole)
    print(json.dumps(data, indent=2) if args.json else text(data))
    return 1 if result.comparison and result.comparison.different else 0


def write_csv(path, estimates, whole=None):
    """
    Write the estimates to `path`; numbers read back bit for bit.

    whole: rows [M, N_SMOOTHED] of the same samples, smoothed over the recording, or None.
    """
    names = CSV_COLUMNS
    columns = [getattr(estimates, name) for name in names]
    if whole is not None:
        names = (*names, *SMOOTHED_COLUMNS)
        columns += [whole[:, column] for column in SMOOTHED_COLUMNS.values()]
    table = np.column_stack(columns)
    try:
        with open(path, 'x', encoding='utf-8') as file:
            file.write(','.join(('stamp_ns', *names)) + '\n')
            for stamp, row in zip(estimates.stamp_ns.tolist(), table.tolist()):
                file.write(f'{stamp},{",".join(map(repr, row))}\n')
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a new, writable file') from None


def text(data):
    """Return the summary as lines for people."""
    lines = [
        f'bag          {data["bag"]}',
        f'samples      {data["samples"]} in {data["duration_s"]:.2f} s '
        f'({data["rate_hz"]:.1f} Hz), {data["estimates"]} estimates, filter {data["filter"]}']
    refused = {k: v for k, v in data['refused'].items() if k != 'starts'}
    if refused:
        lines.append('noticed      ' + ', '.join(f'{v} {k}' for k, v in refused.items()))
    if data['nis'] is not None:
        lines.append(f'NIS          {data["nis"]:.3f} (2 when the model is right)')
    if data.get('tau_k_error') is not None:
        lines.append(
            f'tau_K error  {data["tau_k_error"]:.4g} N m rms of {data["tau_k_rms"]:.4g}, '
            f'smoothed {_number(data["tau_k_error_smoothed"])}; '
            f'{100 * data["coverage_1_sigma"]:.0f} % within 1 sigma')
    if data.get('tau_k_error_whole') is not None:
        lines.append(f'             {data["tau_k_error_whole"]:.4g} smoothed over the whole '
                     'recording')
    if data['adapted']:
        lines.append('adapted      ' + ', '.join(
            f'{name} {value:.4g}' for name, value in data['adapted'].items()))
        acted = {k: v for k, v in data['adaptation_guards'].items() if v}
        if acted:
            lines.append('             ' + ', '.join(
                f'{v} {k.replace("_", " ")}' for k, v in acted.items()))
    if data['gap_rad']:
        lines.append('gap          ' + ', '.join(f'{gap:.4g}' for gap in data['gap_rad'][-8:])
                     + ' rad (windows, newest last)')
    lines.append('trust        ' + ', '.join(f'{k} {v}' for k, v in data['levels'].items()))
    if 'comparison' in data:
        c = data['comparison']
        lines.append(f'identical    {data["replay_identical"]}: {c["identical"]} of '
                     f'{c["compared"]} recorded values bit for bit')
        if c['explained'] or c['lost_inputs'] or c['lost_outputs']:
            lines.append(
                f'             missing in the bag: {c["lost_inputs"]} inputs, '
                f'{c["lost_outputs"]} outputs; {c["explained"]} values differ behind such a '
                'loss, up to the next snapshot')
        if c['early_inputs']:
            lines.append(f'             {c["early_inputs"]} samples came before the estimator was '
                         'ready')
        if c['different']:
            lines.append(f'             first difference: {c["first"]}')
    lines += [f'note         {note}' for note in data['notes']]
    return '\n'.join(lines)


def _number(value):
    return 'none' if value is None else f'{value:.4g}'
