# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Run a bag through the estimator, offline, and compare with what was published live.

Without options the recorded parameters and snapshots apply, and every recorded estimate is
compared bit for bit. --filter, --params and --model replace what is recorded.
The bag is read block by block: memory does not grow with its length. --estimates-only omits
smoother, trust and drift: the same estimates in a fraction of the time.

usage examples:
  gearbox_monitor replay gearbox_2026_11_21-10_00_00
  gearbox_monitor replay BAG --out estimates.parquet --estimates-only
  gearbox_monitor replay BAG --model drive.yaml --params estimator.yaml --out estimates.csv
  gearbox_monitor replay BAG --filter ekf --out BAG2 --json
"""
from argparse import Namespace
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gearbox_monitor.cli.options import (
    entries, estimator_options, labelled, opened, show, warn, wrapped)
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import expect_new_file, load_model
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.presentation import as_written, on_axis, Said, said
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.replay import Comparison, summarised
from gearbox_monitor.recordings.replay_output import BagOutput, CsvTable, ParquetTable
from gearbox_monitor.report import words
from gearbox_monitor.report.sentences import told
from gearbox_monitor.robot.description import SUFFIXES

OUTPUTS: dict[str, type[CsvTable] | type[BagOutput]] = {
    '.csv': CsvTable, '.parquet': ParquetTable}  # others: a bag


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if args.model is not None and Path(args.model).suffix.lower() in SUFFIXES:
        raise InputError(f'--model {args.model}: a whole robot, expected the model file of a '
                         f'drive; gearbox_monitor watch {args.bag} --model {args.model} states '
                         'what the robot holds')
    parameters, model_file = estimator_options(args)
    if args.filter:
        parameters['filter'] = args.filter
    expect_new_file(args.out)
    with opened(args) as reader:
        model = load_model(model_file) if model_file else None
        player = Player(reader, model, parameters, args.topic, not args.estimates_only)
        data, comparison = _play(args, player)
        data = {**told(says(data, player.estimator.model.axis)), **data}
    warn(args, data['notes'])
    show(args, data, lambda: text(data, player.estimator.model.axis))
    return 1 if comparison and comparison.different else 0


def _play(args: Namespace, player: Player) -> tuple[dict[str, Any], Comparison | None]:
    """Run `player` into the output of the options; return the summary and the comparison."""
    output = OUTPUTS.get(Path(args.out).suffix, BagOutput)(args.out, player) if args.out else None
    try:
        with count_bar('replay', player.reader.topics[player.topic][1]) as bar:
            result = summarised(player, [output] if output else [], bar.update)
        if output:
            output.close()
    except BaseException:
        if output:
            output.abandon()
        raise
    return result


def says(data: Mapping[str, Any], axis: str = 'rotary') -> Iterator[Said]:
    """Yield what a replay (its `data`, of a drive with `axis`) says: what it repeats, shows."""
    if 'comparison' in data:
        compared = data['comparison']
        yield said('differs_from' if compared['different'] else 'repeats', **compared)
    if data['wear']:
        yield as_written(on_axis(words.sentence(data['wear']['summary']), axis))
    if data['levels']:
        raised = ', '.join(f'{name} {level}' for name, level in data['levels'].items()
                           if level != Level.OK.name)
        yield said('trust_at_end', levels=raised or 'all OK')
    if data['nis'] is not None:
        yield said('mean_nis', **data)
    elif not ('comparison' in data or data['wear'] or data['levels']):
        yield said('estimates', count=data['estimates'])


def text(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the summary `data` of a drive with `axis` as lines for people."""
    return '\n'.join([*wrapped(data['summary']), '', *entries(
        [('bag', data['bag']), *labelled(_rows(data, axis)),
         *(('note', note) for note in data['notes'])])])


def _rows(data: Mapping[str, Any], axis: str) -> Iterator[Said]:
    """Yield the lines about a replay of a drive with `axis`."""
    def named(values: Mapping[str, Any]) -> str:
        """Return what of `values` is not 0, with their names."""
        return ', '.join(f'{v} {k.replace("_", " ")}' for k, v in values.items() if v)
    yield said('samples_row', **data)
    yield said('noticed_row', noticed=named(
        {k: v for k, v in data['refused'].items() if k != 'starts'}))
    if data['nis'] is not None:
        yield said('nis_row', **data)
    if data.get('tau_k_error') is not None:
        late = data['tau_k_error_smoothed']
        yield said('error_row', unit=on_axis('N m', axis), percent=100 * data['coverage_1_sigma'],
                   smoothed='none' if late is None else f'{late:.4g}', **data)
    yield said('adapted_row', words=', '.join(f'{k} {v:.4g}' for k, v in data['adapted'].items()))
    yield said('adapted_row', words=named(data['adaptation_guards']))
    if data['gap_rad']:
        yield said('gap_row', unit=on_axis('rad', axis),
                   gaps=', '.join(f'{gap:.4g}' for gap in data['gap_rad'][-8:]))
    yield said('trust_row', levels=', '.join(f'{k} {v}' for k, v in data['levels'].items()))
    if c := data.get('comparison'):
        yield said('identical_row', verdict=data['replay_identical'], **c)
        if c['explained'] or c['lost_inputs'] or c['lost_outputs']:
            yield said('missing_row', **c)
        if c['early_inputs']:
            yield said('early_row', **c)
        if c['different']:
            yield said('difference_row', **c)
