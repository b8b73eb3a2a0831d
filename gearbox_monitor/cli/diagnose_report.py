# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The verdict of a diagnosis in words: effect, place, certainty, next steps."""
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from gearbox_monitor.cli.options import wrapped
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report.diagnosis_evidence import measures_twist, shows_place
from gearbox_monitor.report.summary import PLACES, with_deviation
from gearbox_monitor.report.words import (
    dense_regions, ids_of, meaning, NAMING, next_steps, NO_FILES, number, percent, place_text,
    SUGGESTED, torque_map_of, undefined, unit_of, UserFiles, value_rows, value_text)
from gearbox_monitor.signals.recording import UniformRecording

VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a verdict
LABEL = 15
RANKED = 8  # lines of the ranking


def text(data: VerdictData, recordings: Sequence[UniformRecording], model: DriveModel,
         written: Sequence[Path] = (), files: UserFiles = NO_FILES,
         command: Sequence[str] = (), changes: Sequence[str] = ()) -> str:
    """
    Return a verdict as lines for people, at most 80 columns.

    Args:
        data: the verdict as plain data.
        recordings: those it is about.
        model: the nominal model.
        written: files.
        files: of the user.
        command: parts of the command that finds a more informative motion.
        changes: of the simulator's file, in words.

    """
    lines = wrapped(data['summary'])
    lines += [line for name in ids_of(data) for line in _meaning(name, model.axis)]
    lines.append('')
    for recording in recordings:
        lines += _entry('recording', f'{recording.name}: {recording.duration:.1f} s, '
                        f'{1.0 / recording.dt:.0f} samples/s')
    sigma = data['sigma']
    unit = on_axis('rad', model.axis)
    first = 'torque' if model.driven_by == 'position' else 'motor'
    lines += _entry('noise', ', '.join(f'{name} {value:.3g} {unit_of(name, unit)}' for name, value
                                       in zip((first, 'arm'), sigma) if value is not None))
    lines += [*_gap(data), *_parameters(data, model), *_ranking(data),
              *_where(data, recordings, model)]
    lines += _nominal(data, model)
    slow = [name for name, reason in data.get('not_tried', {}).items() if 'samples/s' in reason]
    if slow:
        lines += _entry('not tried', f'{", ".join(slow)}: {data["not_tried"][slow[0]]}')
    lines += _simulator(data)
    lines += _validation(data, files.validated, unit)
    lines += [line for warning in data.get('warnings', ()) for line in _entry('note', warning)]
    for change in changes:
        lines += _entry('change', change)
    for advice in next_steps(data, files, model.axis):
        lines += _entry('next', advice)
    if command:
        lines += _entry('next', f'{SUGGESTED}:')
        lines.append(' \\\n'.join(
            ' ' * (LABEL + 2 * (k > 0)) + part for k, part in enumerate(command)))
    lines += [line for path in written for line in _entry('written', str(path))]
    return '\n'.join(lines)


def _entry(label: str, words: str) -> list[str]:
    """Return `words` as lines beside `label`."""
    return wrapped(words, f'{label:<{LABEL}s}', ' ' * LABEL) or [label]


def _meaning(name: str, axis: str) -> list[str]:
    effect = library().get(name)
    if effect is None:
        return []
    return wrapped(f'{name} ({PLACES.get(effect.location, "")}): {meaning(name, axis)}: '
                   f'{effect.equation}', '  ', '    ')


def _gap(data: VerdictData) -> list[str]:
    lines = _entry('gap', f'{number(data["gap_before"])} before, {number(data["gap_after"])} '
                   'after, in standard deviations of the noise; 1 is the floor')
    closed, interval = data.get('closed_fraction'), data.get('closed_fraction_ci')
    if data['verdict'] == 'none':
        return lines
    words = percent(closed)
    if closed is not None and interval:
        words += f' (90 % interval {percent(interval[0])} to {percent(interval[1])})'
    if closed is None:
        words += f': {undefined(data)}'
    lines += _entry('closed', words)
    for channel, part in (data.get('channels') or {}).items():
        lines.append(f'  {channel:<{LABEL - 2}s}{number(part["before"])} before, '
                     f'{number(part["after"])} after')
    return lines


def _parameters(data: VerdictData, model: DriveModel) -> list[str]:
    lines = [f'{"" if k else "values":<{LABEL}s}{row.effect} {value_text(row, "+-")}'
             for k, row in enumerate(value_rows(data, model.axis))]
    for name, ranges in (data.get('between_recordings') or {}).items():
        for parameter, part in ranges.items():
            lines += _entry('', f'{name} {parameter} in {len(part["recordings"])} recordings: '
                            f'{number(part["mean"])}, 90 % range {number(part["low"])} to '
                            f'{number(part["high"])}; it differs between them by '
                            f'{part["between"]:.2g}')
    for burst in data.get('bursts') or ():
        lines += _entry('' if burst is not data['bursts'][0] else 'bursts',
                        f'{burst["t0"]:.2f} to {burst["t0"] + burst["duration"]:.2f} s: '
                        f'{number(burst["amplitude"])} {on_axis("N m", model.axis)}')
    for sentence in data.get('equivalent') or ():
        lines += _entry('the same as', sentence)
    torque_map = torque_map_of(data)
    if torque_map is not None:
        words, rows = torque_map
        lines += _entry('torque map', f'{words}, for what no effect explains: '
                        + ', '.join(f'{x}: {torque} +- {error}' for x, torque, error in rows)
                        + f' {on_axis("N m", model.axis)}')
    return lines


def _ranking(data: VerdictData) -> list[str]:
    gains: Mapping[str, float] = data.get('gains') or {}
    ranking = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED]
    lines = [f'{"" if k else "ranking":<{LABEL}s}{k + 1}. {name:<44s}{gains[name]:12.1f}'
             for k, name in enumerate(ranking)]
    if lines:
        lines += _entry('', 'gain over the nominal model: 2 log likelihood less a penalty per '
                        'parameter')
    if data.get('confusable') and data['verdict'] in NAMING:
        lines += _entry('not separable', ', '.join(data['confusable'])
                        + ': this recording does not distinguish it from the effect')
    return lines


def _where(data: VerdictData, recordings: Sequence[UniformRecording], model: DriveModel
           ) -> list[str]:
    if data['verdict'] == 'none':
        return []
    lines: list[str] = []
    placed = any(shows_place(recording, model) for recording in recordings)
    if not placed:
        lines = _entry('where', 'one encoder does not show it: record both')
    for place, part in data['where']['places'].items() if placed else ():
        lines.append(f'{"" if lines else "where":<{LABEL}s}{place_text(place):<18s}a free signal '
                     f'there explains {100 * part["explained"]:5.1f} %')
    words = dense_regions(data['where'].get('region') or {}, any(
        measures_twist(recording, model) for recording in recordings))
    return lines + (_entry('largest at', ', '.join(words)) if words else [])


def _nominal(data: VerdictData, model: DriveModel) -> list[str]:
    shifts = data.get('nominal_shift')
    if not shifts:
        return []
    words = [f'{name} {number(data["nominal"][name])} ({shift:+.1f})'
             for name, shift in shifts.items()]
    lines = _entry('model values', ', '.join(words) + '; in brackets: deviation in tolerances')
    if model.tolerance and data['process_torque'] is not None:
        lines += _entry(on_axis('torque noise', model.axis), f'{number(data["process_torque"])} '
                        f'{on_axis("N m", model.axis)} rms per sample')
    return lines


def _simulator(data: VerdictData) -> list[str]:
    theirs = data.get('simulator')
    if not theirs:
        return []
    lines: list[str] = []
    for words, part in ((theirs['name'], theirs), ('this package', theirs['here'])):
        closed = percent(part['closed_fraction'])
        lines += _entry('' if lines else 'simulator', f'{words}: gap '
                        f'{number(part["gap_before"])} before, {number(part["gap_after"])} after, '
                        f'closed {closed}')
    ways = ', '.join(f'{name} as {way}' for name, way in theirs['passed'].items())
    fitted = ', '.join(f'{name} {key} = {with_deviation(value, deviation, "+-")}'
                       for name, values in theirs['values'].items()
                       for key, (value, deviation) in values.items())
    for words, row in (('passed to it', ways), ('values in it', fitted)):
        lines += _entry('', f'{words}: {row}') if row else []
    return lines


def _validation(data: VerdictData, validated: str | None, unit: str) -> list[str]:
    result = data.get('validation')
    if not result:
        return []
    lines = _entry('validation', f'{validated}: gap {number(result.get("gap_before"))} before, '
                   f'{number(result.get("gap_after"))} after, closed '
                   f'{percent(result.get("closed_fraction"))}')
    run = result.get('free_run')
    if run:
        nominal, closed = (', '.join(
            f'{name} {number(value)}' for name, value in run[when].items())
            for when in ('before', 'after'))
        units = ', '.join(dict.fromkeys(unit_of(name, unit) for name in run['before']))
        lines += _entry('', f'one free run of {run["seconds"]:.0f} s, rms in {units}: {nominal} '
                        f'before; {closed} after')
    return lines
