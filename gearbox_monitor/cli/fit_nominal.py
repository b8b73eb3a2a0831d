# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Identify the values of a model file from recordings, and report which of them the data determine.

All values of the drive are fitted (or those named with --free), each within physical bounds and
held weakly at the value of the model file, which must be right within a factor of about ten.
Values that the recordings do not determine are listed as such and stay near their start.

A regression of the torque comes first. A search by the innovations of a filter, as in diagnose,
begins at its values and at those of the model file. Where the search does not arrive, or is
less likely than the regression on the last 30 % of the recordings, which are not fitted, the
values of the regression are the result, and the output says so. If neither is better than the
model file, the command writes nothing. Torque that no model explains is fitted along and widens
the deviations; with --windows free runs are fitted, in which such torque counts as misfit.

names: m1 m2 (inertias) D (damping) Cv Cc (friction) K (stiffness) b (half gap), kt
(torque_constant: torque per A of effort, 1 if the effort is a torque), u0 (torque offset), zero
(of the encoders), kp ki kd kff kaff (gains of a servo), and ids of effects that the model file
has (all their parameters; torque_gain goes into torque_constant). Without a known load, torque
constant, inertia, friction and stiffness share one scale: fix one of them.

usage examples:
  gearbox_monitor fit-nominal BAG --model drive.yaml --out drive.fitted.yaml
  gearbox_monitor fit-nominal BAG BAG2 --model drive.yaml --free m1 Cv Cc u0 --validate BAG3
  gearbox_monitor fit-nominal BAG --model drive.yaml --windows 20   # weigh what drifts slowly
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
import math
from pathlib import Path
from typing import Any

from gearbox_monitor.cli.inputs import add_recording_arguments, load_recordings, time_limit
from gearbox_monitor.cli.options import show, wrapped
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import plain
from gearbox_monitor.files.yaml_files import expect_folder_of, expect_new_file, save_model
from gearbox_monitor.presentation import change, number, Quantity

SECONDS = 1.0
CERTAIN = 3.0  # errors by which a value differs from the model file


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_recording_arguments(parser)
    parser.add_argument('--free', metavar='NAME', nargs='+',
                        help='values that are fitted (default: all of this drive but kt)')
    parser.add_argument('--validate', metavar='BAG2',
                        help='another recording of the drive, to test the model on')
    parser.add_argument('--windows', metavar='S', type=float, default=SECONDS,
                        help='if above %(default)g: fit free runs of this length, s; longer than '
                        'the recording: all of it (default: %(default)g)')
    parser.add_argument('--time-limit', metavar='S', type=float, default=math.inf,
                        help='give up after this many seconds (default: none)')
    parser.add_argument('--out', metavar='FILE', help='write the model file, a new one')
    parser.add_argument('--json', metavar='FILE', help='write all figures as JSON; - prints them')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if not args.windows >= SECONDS:
        raise InputError(f'--windows: {args.windows:g}, expected at least {SECONDS:g} s')
    if not args.time_limit > 0.0:
        raise InputError(f'--time-limit: {args.time_limit:g}, expected a number > 0 (s)')
    expect_new_file(args.out)
    expect_folder_of(args.json)
    model, recordings, validate, notes = load_recordings(args)
    with progress_bar('fit') as progress, time_limit(args.time_limit, '--time-limit'):
        result = fit_nominal(
            recordings, model, args.free, validate=validate,
            seconds=args.windows if args.windows > SECONDS else None, progress=progress)
    if args.out:
        save_model(args.out, result.model, ['Fitted with gearbox_monitor fit-nominal to '
                                            + ', '.join(Path(path).name for path in args.bag)])
    data = plain({
        'values': {v.name: {k: x for k, x in vars(v).items() if k != 'name'}
                   for v in result.values},
        'correlated': result.correlated, 'covariance': result.covariance,
        'gap_before': result.gap_before,
        'gap_after': result.gap_after, 'method': result.method,
        'process_torque_time': None if model.driven_by == 'position' else (
            result.model.process_torque_time), 'validation': result.validation,
        'notes': notes})
    data = {'summary': summary(data), **data}
    show(args, data, lambda: text(data, args), replaces=True)
    return 0 if all(v.determined for v in result.values) else 1


def summary(data: Mapping[str, Any]) -> str:
    """Return the fit `data` in words: what it determines, what changes most, its misfit."""
    values = data['values']
    sure = {name: v for name, v in values.items() if v['determined']}
    part = 'all' if len(sure) == len(values) else f'{len(sure)} of'
    first = (f'The recordings {"" if sure else "do not "}determine the value.'
             if len(values) == 1 else f'The recordings determine {part} {len(values)} values.')
    start = '' if data['gap_before'] is None else f'{number(data["gap_before"])} -> '
    return ' '.join([first, *largest_change(sure), f'Misfit {start}{number(data["gap_after"])}, '
                     'where 1 is noise alone.'])


def largest_change(values: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the sentence on which of `values` changed most in its errors, none without change."""
    moved = {name: abs(v['value'] - v['start']) / v['error'] for name, v in values.items()
             if v['error'] and v['value'] != v['start']}
    name = max(moved, key=lambda n: moved[n], default=None)
    if name is None or moved[name] < CERTAIN:
        return ['None of them differs from the model file by more than its error.']
    v = values[name]
    by = f' ({change(v["value"], v["start"])})' if v['start'] else ''
    return [f'{name} is {Quantity(v["value"], v["error"], v["unit"])}, not '
            f'{number(v["start"])}{by}.']


def text(data: Mapping[str, Any], args: Namespace) -> str:
    """Return the figures `data` under the options `args` as lines of at most 80 columns."""
    wide = max(6, *(len(name) + 1 for name in data['values']))
    lines = [*wrapped(data['summary']), '',
             f'{"":{wide}s}{"model file":>12s}{"fitted":>12s}{"±":>12s}  unit']
    for name, v in data['values'].items():
        value, error = Quantity(v['value'], v['error']).digits()
        lines.append(f'{name:{wide}s}{v["start"]:12.5g}{value:>12s}{error:>12s}  '
                     f'{v["unit"]:10s}' + ('' if v['determined'] else 'not identified'))
    for first, second, r in data['correlated']:
        lines.append(f'{first} and {second} are hardly distinguishable (correlation {r:.2f})')
    if data['method'] == 'regression':
        lines.append('values of a regression of the torque: a search did not beat them')
    if data['process_torque_time']:
        lines.append(f'torque that the model lacks lasts {data["process_torque_time"]:g} s '
                     '(likeliest process_torque_time)')
    gap = f'misfit {number(data["gap_after"])}'
    if data['gap_before'] is not None:
        gap += f' after, {number(data["gap_before"])} before'
    lines.append(f'{gap} (in standard deviations of the encoders, runs of '
                 f'{args.windows:g} s)')
    validation = data['validation']
    if validation:
        runs = validation['free_run']
        lines.append(f'{Path(args.validate).name}: misfit '
                     f'{number(validation["gap_before"])} before, '
                     f'{number(validation["gap_after"])} after')
        for name in runs['before']:
            start, fitted = runs['before'][name], runs['after'][name]
            if start is not None or fitted is not None:
                lines.append(f'  one free run of {runs["seconds"]:.0f} s, {name}: '
                             f'{_rms(start)} before, {_rms(fitted)} after')
    lines += [f'note: {note}'[:80] for note in data['notes']]
    if args.out:
        lines.append(f'written: {args.out}')
    return '\n'.join(lines)


def _rms(value: float | None) -> str:
    return 'diverges' if value is None or not math.isfinite(value) else f'{number(value)} rms'
