# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Adapt a model file to one unit from recordings of its motion, without a torque sensor.

fit-nominal and tune in one: the values of the model are fitted to the recordings, the filter is
tuned with them, and the tolerances state what stays open. The folder --out then holds drive.yaml
and params.yaml for node and replay, with tau_k_model: mixed unless --params names another. A
torque constant cannot be identified without a known load: tau_K keeps its scale, and the stated
deviation covers torque_gain_tolerance.

usage examples:
  gearbox_monitor adapt BAG BAG2 --model drive.yaml --out unit7
  gearbox_monitor adapt BAG --model drive.yaml --params start.yaml --out unit7
  gearbox_monitor replay BAG3 --model unit7/drive.yaml --params unit7/params.yaml
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearbox_monitor.cli.fit_nominal import largest_change
from gearbox_monitor.cli.inputs import add_recording_arguments, load_recordings
from gearbox_monitor.cli.main import UNDECIDED
from gearbox_monitor.cli.options import show, wrapped
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.diagnosis.joint.unit_adaptation import Adapted
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import plain
from gearbox_monitor.files.yaml_files import expect_outside_of_bag, load_parameters
from gearbox_monitor.library.identify import adapt, write_adapted
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters, MIXED
from gearbox_monitor.presentation import number, Quantity
from gearbox_monitor.report.words import counted


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_recording_arguments(parser)
    parser.add_argument('--params', metavar='FILE',
                        help='ROS parameter file of the estimator that is tuned')
    parser.add_argument('--out', metavar='FOLDER', required=True, help='new folder for the files')
    parser.add_argument('--json', action='store_true', help='print the result as JSON')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    folder = Path(args.out)
    if folder.exists() or not folder.parent.is_dir():
        raise InputError(f'--out {folder}: expected a new folder in one that exists')
    expect_outside_of_bag(folder)
    values = load_parameters(args.params, 'estimator', ESTIMATOR) if args.params else {}
    values.pop('model', None)
    model, recordings, _, notes = load_recordings(args)
    parameters = EstimatorParameters.of({
        'motor_joint': args.motor_joint, 'arm_joint': args.arm_joint, 'tau_k_model': MIXED,
        **values})
    with progress_bar('adapt') as progress:
        result = adapt(recordings, model, parameters=parameters, progress=progress)
    names = ', '.join(Path(path).name for path in args.bag)
    write_adapted(folder, result, names)
    summary = plain({
        'values': {v.name: {k: x for k, x in vars(v).items() if k != 'name'}
                   for v in (result.fit.values if result.fit else ())},
        'covariance': result.fit.covariance if result.fit else None,
        'gap_after': result.fit.gap_after if result.fit else None,
        'tolerances': result.tolerances, 'parameters': result.parameters, 'open': result.open,
        'notes': notes})
    summary = {'summary': answer(result, summary), **summary}
    show(args, summary, lambda: text(result, summary, folder))
    if result.fit is None:
        return UNDECIDED
    return int(bool(result.kept) or bool(result.tuning.get('kept')))


def answer(result: Adapted, summary: Mapping[str, Any]) -> str:
    """Return the `result`, of which `summary` holds the figures, in words."""
    if result.fit is None:
        return f'Nothing was adapted: {"; ".join(result.open)}.'
    if result.kept:
        return 'Model file and parameters stay as they are: the adapted values are less likely.'
    sure = {name: v for name, v in summary['values'].items() if v['determined']}
    return ' '.join([f'{len(sure)} of {counted(len(summary["values"]), "value")} of the model are '
                     'now those of this unit.', *largest_change(sure),
                     f'Misfit {number(summary["gap_after"])}, where 1 is noise alone.'])


def text(result: Adapted, summary: dict[str, Any], folder: Path) -> str:
    """Return the `result`, of which `summary` holds the figures, written to `folder`, as lines."""
    lines = [*wrapped(summary['summary']), '',
             f'{"":22s}{"model file":>12s}{"this unit":>12s}{"±":>12s}  unit']
    for v in result.fit.values if result.fit else ():
        value, error = Quantity(v.value, v.error).digits()
        lines.append(f'{v.name:22s}{v.start:12.5g}{value:>12s}{error:>12s}  {v.unit:10s}'
                     + ('' if v.determined else 'not identified'))
    lines += [f'{name:22s}{start:12.4g}{now:12.4g}'
              for name, (start, now) in result.tolerances.items()]
    units = {row.name: row.unit for row in ESTIMATOR}
    previous = result.tuning.get('before_parameters', {})
    lines += [f'{name:22s}{previous.get(name, 0.0):12.5g}{value:12.5g}{"":12s}{units[name]}'
              for name, value in result.parameters.items() if not isinstance(value, str)]
    lines += [f'open: {sentence}' for sentence in result.open]
    lines += [f'note: {note}' for note in summary['notes']]
    lines.append(f'written: {folder / "drive.yaml"}, {folder / "params.yaml"}')
    return '\n'.join(lines)
