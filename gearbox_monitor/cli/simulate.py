# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate a recording: overlay the recording, its model and the closed model.

Over windows of 1 s each model starts from the state that fits best: its residual is the gap, in
standard deviations of the encoder noise, 1 is the floor. Over the whole recording it runs once,
from the state of the first window, with the recorded torque alone: errors add up, as in a
simulator. Nothing else is fitted.

BAG is read as by diagnose. Take a recording that was not used to find the model.

usage examples:
  gearbox_monitor simulate --model drive.yaml --against BAG
  gearbox_monitor simulate --model drive.yaml --closed drive.closed.yaml --against BAG2 --out pics
  gearbox_monitor simulate --model drive.yaml --against run.csv --json - | jq .gap_before
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.cli.inputs import add_drive_arguments, load_drive, load_recording
from gearbox_monitor.cli.options import expect_new_files, JSON_FILE_HELP, wrapped, write_files
from gearbox_monitor.diagnosis.joint.closed_model import closed_of, Overlay, overlay, rms
from gearbox_monitor.errors import expect_matplotlib
from gearbox_monitor.files.opening import dump, plain
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.presentation import number, on_axis, percent
from gearbox_monitor.report.diagnosis_evidence import (
    notable_windows, whole_chart, window_chart)
from gearbox_monitor.report.words import unit_of
from gearbox_monitor.signals.uniform import UniformRecording

PICTURES = ('windows.png', 'free_run.png')


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_drive_arguments(parser)
    parser.add_argument('--closed', metavar='FILE',
                        help='model file with the effect, as diagnose writes it')
    parser.add_argument('--against', metavar='BAG', required=True,
                        help='bag directory, .mcap file or CSV file with the recorded drive')
    parser.add_argument('--out', metavar='DIR',
                        help='write windows.png and free_run.png: recording, models, residuals')
    parser.add_argument('--json', metavar='FILE',
                        help='write the numbers as JSON' + JSON_FILE_HELP)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_new_files(args.out, PICTURES, args.json)
    if args.out:
        expect_matplotlib('--out')
    models = {'nominal model': load_drive(args)}
    if args.closed:
        # The recording is read once, with the torque constant of the first.
        models['closed model'] = load_model(args.closed).with_torque_constant(
            models['nominal model'].torque_constant)
    recording, notes = load_recording(args.against, models['nominal model'], args)
    laid = overlay(recording, models)
    data = plain(figures(laid))
    data['notes'] = notes
    data = {'summary': summary(data), **data}
    unit = on_axis('rad', models['nominal model'].axis)
    written = write(laid, data, args, models['nominal model'].axis)
    print(dump(data) if args.json == '-' else text(data, recording, written, unit))
    return 0


def figures(laid: Overlay) -> dict[str, Any]:
    """
    Return the numbers of an overlay `laid` of one or two runs, as plain data.

    {'gap_before', 'gap_after', 'closed_fraction', 'channels' {name: {before, after}}, 'windows',
    'sigma', 'free_run' {'seconds', 'before', 'after' {name: rad rms}}}; after: None without a
    closed model, rms None if a run diverges.
    """
    gaps = [run.gap for run in laid.runs]
    channels: dict[str, Any] = {}
    free: list[dict[str, float]] = [{}, {}]
    names = laid.recording.readings
    for column, k in enumerate(laid.channels):
        parts = [float(np.sqrt(np.mean(laid.residual(run)[:, :, column] ** 2)))
                 for run in laid.runs]
        channels[names[k]] = {'before': parts[0], 'after': parts[1] if parts[1:] else None}
    for run, values_by_name in zip(laid.runs, free):
        values = rms(laid.recording, run.free)
        values_by_name.update({names[k]: float(values[k]) for k in laid.channels})
    both = len(gaps) > 1
    return {'gap_before': gaps[0], 'gap_after': gaps[1] if both else None,
            'closed_fraction': closed_of(*gaps) if both else None, 'channels': channels,
            'windows': len(laid.windows), 'sigma': laid.sigma,
            'free_run': {'seconds': float(laid.recording.duration), 'before': free[0],
                         'after': free[1] if both else None}}


def summary(data: Mapping[str, Any]) -> str:
    """Return the overlay `data` in one sentence: how far the models are from the recording."""
    misfit = f'misfit {number(data["gap_before"])} in windows of 1 s, where 1 is noise alone'
    if data['gap_after'] is None:
        return f'The model leaves a {misfit}.'
    return (f'The closed model closes {percent(data["closed_fraction"])} of the gap: {misfit}, '
            f'becomes {number(data["gap_after"])}.')


def text(data: Mapping[str, Any], recording: UniformRecording, written: Sequence[Path] = (),
         unit: str = 'rad') -> str:
    """
    Return the numbers as lines for people, at most 80 columns.

    Args:
        data: of figures.
        recording: of the drive.
        written: files.
        unit: of the encoders.

    """
    both = data['gap_after'] is not None
    sigma = ', '.join(
        f'{name} {number(data["sigma"][name == "arm"], unit_of(name, unit))}'
        for name in data['channels'])
    lines = wrapped(data['summary'])
    lines += wrapped(f'{recording.name}: {recording.duration:.1f} s, '
                     f'{1.0 / recording.dt:.0f} samples/s, noise {sigma}')
    lines += ['', f'{"":<34s}{"nominal":>12s}' + (f'{"closed":>12s}' if both else '')]

    def row(words: str, *values: float | None) -> None:
        """Add a line of words with the values of one model or both."""
        cells = values if both else values[:1]
        lines.append(f'{words:<34s}' + ''.join(f'{_cell(v):>12s}' for v in cells))
    row(f'gap in {data["windows"]} windows of 1 s', data['gap_before'], data['gap_after'])
    for name, part in data['channels'].items():
        row(f'  {name}', part['before'], part['after'])
    free = data['free_run']
    units = ', '.join(dict.fromkeys(unit_of(name, unit) for name in free['before']))
    lines.append(f'one free run of {free["seconds"]:.0f} s, rms in {units}')
    for name in free['before']:
        row(f'  {name}', free['before'][name], (free['after'] or {}).get(name))
    if free['before'] and None in (*free['before'].values(), *(free['after'] or {}).values()):
        lines += wrapped('diverges: the values of the run overflow.')
    for note in data['notes']:
        lines += wrapped(f'note: {note}')
    return '\n'.join([*lines, *(f'written {path}' for path in written)])


def _cell(value: float | None) -> str:
    return 'diverges' if value is None else number(value)


def write(laid: Overlay, data: Mapping[str, Any], args: Namespace, axis: str = 'rotary'
          ) -> list[Path]:
    """
    Write pictures and JSON.

    Args:
        laid: models over the recording.
        data: of figures.
        args: options of the command.
        axis: of the drive, for units.

    Returns:
        The files.

    """
    contents: dict[Path, Any] = {}
    if args.out:
        title = f'{Path(laid.recording.name).name}: gap {number(data["gap_before"])}'
        if data['gap_after'] is not None:
            title += f', closed {number(data["gap_after"])}'
        from gearbox_monitor.report.plots import figure
        drawn = (figure([[window_chart(laid, words, window, axis)
                          for words, window in notable_windows(laid, False)]], title),
                 figure([[whole_chart(laid, axis)]], title))
        contents |= {Path(args.out, name): figure for name, figure in zip(PICTURES, drawn)}
    if args.json and args.json != '-':
        contents[Path(args.json)] = dump(data) + '\n'
    return write_files(contents, args.out)
