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

"""The verdict of a diagnosis in words: what was found, where, how sure, what to do next."""
import textwrap

from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report.words import (
    dense_regions, headline, ids_of, meaning, next_steps, number, percent, place_text, SUGGESTED,
    undefined, unit_of)

WIDTH = 80
LABEL = 15
SHOWN = 8  # lines of the ranking


def text(data, recordings, model, written=(), validated=None, command=()):
    """
    Return the verdict `data` as lines for people, at most 80 columns.

    recordings: gap.recording.Recording of it; model: nominal DriveModel; written: files;
    command: parts of the one that looks for a better motion.
    """
    lines = []
    for recording in recordings:
        lines += _entry('recording', f'{recording.name}: {recording.duration:.1f} s, '
                        f'{1.0 / recording.dt:.0f} samples/s')
    sigma = data['sigma']
    unit = on_axis('rad', model.axis)
    first = 'torque' if model.driven_by == 'position' else 'motor'
    lines += _entry('noise', ', '.join(f'{name} {value:.3g} {unit_of(name, unit)}' for name, value
                                       in zip((first, 'arm'), sigma) if value is not None))
    lines += ['', *textwrap.wrap(headline(data), WIDTH)]
    lines += [line for name in ids_of(data) for line in _meaning(name, model.axis)]
    lines += ['', *_gap(data), *_parameters(data, model), *_ranking(data), *_where(data)]
    lines += _nominal(data, model)
    lines += _validation(data, validated, unit)
    lines += [line for warning in data.get('warnings', ()) for line in _entry('note', warning)]
    closed = any(path.name == 'drive.closed.yaml' for path in written)
    for advice in next_steps(data, closed, validated, model.axis):
        lines += _entry('next', advice)
    if command:
        lines += _entry('next', f'{SUGGESTED}:')
        lines.append(' \\\n'.join(
            ' ' * (LABEL + 2 * (k > 0)) + part for k, part in enumerate(command)))
    lines += [line for path in written for line in _entry('written', str(path))]
    return '\n'.join(lines)


def _entry(label, words):
    """Return `words` as lines beside `label`."""
    return textwrap.wrap(words, WIDTH, initial_indent=f'{label:<{LABEL}s}',
                         subsequent_indent=' ' * LABEL, break_on_hyphens=False) or [label]


def _meaning(name, axis):
    effect = library().get(name)
    means = meaning(name, axis)
    lines = textwrap.wrap(f'{means[0].upper()}{means[1:]}.', WIDTH - 2) if means else []
    lines += textwrap.wrap(effect.equation, WIDTH - 2) if effect else []
    return [f'  {line}' for line in lines]


def _gap(data):
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


def _parameters(data, model):
    lines, known = [], library()
    errors = data.get('standard_errors') or {}
    if data['verdict'] == 'unknown' and data.get('params'):
        lines += _entry('nearest', ' + '.join(data['params']) + ', which leaves the gap "after"')
    for name, values in (data.get('params') or {}).items():
        units = {p.name: p.unit for p in known[name].parameters} if name in known else {}
        for parameter, value in values.items():
            if not isinstance(value, (int, float)):
                value, error = str(value), None
            else:
                value, error = number(value), (errors.get(name) or {}).get(parameter)
            pm = f' +- {error:.2g}' if error else ''
            unit = on_axis(units.get(parameter, ''), model.axis)
            first = not any(line.startswith('values') for line in lines)
            lines.append(f'{"values" if first else "":<{LABEL}s}{name} {parameter} = '
                         f'{value}{pm}{" " + unit if unit not in ("", "-") else ""}')
    return lines


def _ranking(data):
    gains = data.get('gains') or {}
    best = sorted(gains, key=gains.get, reverse=True)[:SHOWN]
    lines = [f'{"" if k else "ranking":<{LABEL}s}{k + 1}. {name:<44s}{gains[name]:12.1f}'
             for k, name in enumerate(best)]
    if lines:
        lines += _entry('', 'gain: by how much it beats the plain model, in 2 log likelihood less '
                        'a price per parameter')
    if data.get('confusable') and data['verdict'] == 'effect':
        lines += _entry('not separable', ', '.join(data['confusable'])
                        + ': this recording cannot tell it from the effect named')
    return lines


def _where(data):
    if data['verdict'] == 'none':
        return []
    lines = []
    found = data['where']
    for place, part in found['places'].items():
        lines.append(f'{"" if lines else "where":<{LABEL}s}{place_text(place):<18s}a free signal '
                     f'there explains {100 * part["explained"]:5.1f} %')
    words = dense_regions(found.get('region') or {})
    return lines + (_entry('gap sits at', ', '.join(words)) if words else [])


def _nominal(data, model):
    shifts = data.get('nominal_shift')
    if not shifts:
        return []
    words = [f'{name} {number(data["nominal"][name])} ({shift:+.1f})'
             for name, shift in shifts.items()]
    lines = _entry('model values', ', '.join(words) + '; in brackets: off by so many tolerances')
    if model.tolerance:
        lines += _entry(on_axis('torque noise', model.axis), f'{number(data["process_torque"])} '
                        f'{on_axis("N m", model.axis)} rms per sample')
    return lines


def _validation(data, validated, unit):
    found = data.get('validation')
    if not found:
        return []
    lines = _entry('validation', f'{validated}: gap {number(found.get("gap_before"))} before, '
                   f'{number(found.get("gap_after"))} after, closed '
                   f'{percent(found.get("closed_fraction"))}')
    run = found.get('free_run')
    if run:
        one, other = (', '.join(
            f'{name} {number(value)}' for name, value in run[when].items())
            for when in ('before', 'after'))
        units = ', '.join(dict.fromkeys(unit_of(name, unit) for name in run['before']))
        lines += _entry('', f'one free run of {run["seconds"]:.0f} s, rms in {units}: {one} '
                        f'before; {other} after')
    return lines
