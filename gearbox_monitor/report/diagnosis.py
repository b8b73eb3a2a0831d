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

"""The page of a diagnosis: what was found, where, how sure, and what it closes."""
from html import escape
import json
import re

from gearbox_monitor.identification.isolability import LIMIT
from gearbox_monitor.identification.model_overlay import clipped_to_range, smoothed
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report import page
from gearbox_monitor.report.builder import render_page
from gearbox_monitor.report.evidence import explained_by
from gearbox_monitor.report.words import (
    behind, dense_regions, headline, ids_of, meaning, MEANINGS, next_steps, number, percent,
    PLACES, SUGGESTED, undefined, unit_of)

ROLES = ('nominal', 'closed')
RANKED = 10
RIVALS = 6
AROUND = (0.9, 1.5)  # gaps that are in view anyway: noise must not look large


def report(data, evidence, recordings, closed_written=False, validated=None, command=()):
    """
    Return the HTML page of a diagnosis.

    data: plain data of the verdict; evidence: Evidence; recordings: [Recording] it is on;
    closed_written: whether drive.closed.yaml was written beside it; validated: name of the second
    recording, or None; command: parts of the one that looks for a better motion, see
    report.suggestion.
    """
    steps = next_steps(data, closed_written, validated, evidence.axis)
    sections = [
        ('What to do next', page.bullets([_sentence(step) for step in steps])
         + _suggested(command) + _beside(closed_written)),
        ('The gap', _gap(data, validated, evidence.axis)),
        ('Before and after', _overlays(data, evidence)),
        ('Where', _where(data, evidence)),
        ('Which effect', _which(data, evidence)),
        ('Values', _values(data, evidence.axis)),
        ('Recording and doubts', _doubts(data, recordings, evidence)),
        ('All numbers', page.details('the verdict as JSON', '<pre>' + escape(
            json.dumps(data, indent=1)) + '</pre>')),
    ]
    names = ', '.join(_short(recording) for recording in recordings)
    return render_page(f'Diagnosis of {names}', sections, _lead(data, evidence.axis))


def _suggested(command):
    """Return the command with the parts `command` to be copied, '' without any."""
    return page.paragraph(f'{_sentence(SUGGESTED)[:-1]}:') + '<pre>' + escape(
        ' \\\n    '.join(command)) + '</pre>' if command else ''


def _beside(closed_written):
    """Return links to the files that stand beside the page."""
    names = ['verdict.json', *(['drive.closed.yaml'] if closed_written else [])]
    return '<p class="soft">Beside this page: ' + ', '.join(
        f'<a href="{name}">{name}</a>' for name in names) + '</p>'


def _short(recording):
    """Return the name of a Recording without its folders."""
    return re.split(r'[\\/]', recording.name)[-1]


def _sentence(words):
    return f'{words[0].upper()}{words[1:]}.'.replace('..', '.')


def _lead(data, axis):
    kind = 'good' if data['verdict'] == 'none' else 'warn' if data['verdict'] == 'unknown' else ''
    words = ''
    for name in ids_of(data):
        if name in MEANINGS:
            words += page.paragraph(f'{name}: {meaning(name, axis)}.')
    facts = [('gap before', number(data['gap_before']))]
    if data['verdict'] != 'none':
        facts.append(('gap after' if data['verdict'] == 'effect' else 'gap, nearest effect',
                      number(data['gap_after'])))
        facts.append(('closed', percent(data.get('closed_fraction'))))
    if data['verdict'] == 'effect':
        facts.append(('cannot be told from it', ', '.join(data['confusable']) or 'nothing'))
    return (f'<div class="verdict {kind}"><p class="lead">{escape(headline(data))}</p>{words}'
            f'{page.facts(facts)}</div>')


def _gap(data, validated, axis):
    html = page.paragraph(
        'Gap: root mean square of recording less model over windows of 1 s, in standard '
        'deviations of the encoder noise, on windows held out of the fit. 1 is the floor: only '
        'noise is left. Bars are logarithmic and begin at 1.')
    rows, closed = [], []
    channels = data.get('channels') or {}
    parts = [(' and '.join(channels) or 'all', data['gap_before'], data['gap_after'],
              data.get('closed_fraction'), data.get('closed_fraction_ci'))]
    for name, part in channels.items() if len(channels) > 1 else ():
        parts.append((name if name == 'torque' else f'{name} encoder', part['before'],
                      part['after'], part['closed'], None))
    found = data.get('validation')
    if found:
        parts.append(('second recording', found['gap_before'], found['gap_after'],
                      found['closed_fraction'], None))
    for name, before, after, share, interval in parts:
        rows.append((name, 'before', before, number(before), 'nominal', None))
        if data['verdict'] != 'none':
            rows.append(('', 'after', after, number(after), 'closed', None))
            if share is not None:
                note = '90 % interval' if interval else ''
                shown = percent(share)
                closed.append((name, note and f'{note} {percent(interval[0])} to '
                               f'{percent(interval[1])}', share, shown, 'closed', interval))
    html += page.bars(rows, log=True, top=max([AROUND[1], *(row[2] for row in rows)]))
    if closed:
        html += '<h3>Share of the gap that is closed</h3>' + page.bars(closed, top=max(
            [1.0, *(v for row in closed for v in (row[2], *(row[5] or ())))]))
    elif data['verdict'] != 'none':
        html += page.paragraph(f'No closed share: {undefined(data)}.')
    run = found and found.get('free_run')
    if run:
        units = ', '.join(dict.fromkeys(unit_of(name, 'rad') for name in run['before']))
        html += f'<h3>Second recording: {escape(str(validated))}</h3>' + page.paragraph(
            f'One free run over all {run["seconds"]:.0f} s, rms in {on_axis(units, axis)}:'
        ) + page.table(
            ('', 'before', 'after'), [(n, number(run['before'][n]), number(run['after'][n]))
                                      for n in run['before']], (1, 2))
    regions = [(name.replace('_', ' '), part.replace('_', ' '), number(v['before']),
                number(v['after']))
               for name, bins in (data.get('regions') or {}).items()
               for part, v in bins.items() if v]
    if regions:
        html += page.details('gap by region of the motion', page.table(
            ('region', 'part', 'before', 'after'), regions, (2, 3)))
    return html


def window_lines(evidence, window, channel):
    """Return (Lines of the angle, Lines of the residual, rad or N m) of one window and encoder."""
    laid = evidence.overlay
    t, measured = laid.t[window], laid.measured[window, :, channel]
    angle = [page.Line(t, measured, 'recording', 'recording')]
    left = []
    for run, role in zip(laid.runs, ROLES):
        y = run.y[window, :, channel]
        angle.append(page.Line(t, y, run.name, role))
        left += _residual(t, measured - y, run.name, role, laid.recording.dt)
    return angle, left


def _residual(t, residual, name, role, dt):
    return (page.Line(t, residual, '', f'{role} faint'),
            page.Line(t, smoothed(residual, dt), name, f'{role} firm'))


def _overlays(data, evidence):
    laid = evidence.overlay
    html = page.paragraph(
        'In each window a model runs freely from the initial state that fits best. Below, what it '
        'leaves: faint as it is, firm the mean over 20 ms, in which the noise is smaller. Drag '
        'over a part to zoom, double click for all of it.')
    items = []
    for words, window in evidence.shown:
        panels = []
        for channel in laid.channels:
            angle, left = window_lines(evidence, window, channel)
            panels += _pair(laid.recording.readings[channel], angle, left, evidence.axis)
        title = f'{words.capitalize()} among those held out: {laid.t[window, 0]:.0f} to ' \
                f'{laid.t[window, -1]:.0f} s'
        items.append((words, page.chart(title, panels, 'time (s)', 't (s)')))
    whole = _whole(laid, evidence.axis)
    if whole:
        items.append(('whole recording, one run', whole))
    return html + page.tabs(items)


def _pair(name, lines, left, axis):
    """Return the Panels of one encoder: readings and, below, what is left."""
    unit = unit_of(name, 'rad')
    what = f'{name}, angle' if unit == 'rad' else name
    return [page.Panel(on_axis(f'{what} ({unit})', axis), tuple(lines)),
            page.Panel(on_axis(f'{name}, recording - model ({unit})', axis), tuple(left), 0.0,
                       110)]


def _whole(laid, axis):
    if any(run.free is None for run in laid.runs):
        return ''
    t, panels = laid.recording.t, []
    for channel in laid.channels:
        measured = laid.recording.y[:, channel]
        lines = [page.Line(t, measured, 'recording', 'recording')]
        lines += [page.Line(t, clipped_to_range(run.free[:, channel], measured), run.name, role)
                  for run, role in zip(laid.runs, ROLES)]
        left = [page.Line(line.x, measured - line.y, line.name, f'{line.role} firm')
                for line in lines[1:]]
        panels += _pair(laid.recording.readings[channel], lines, left, axis)
    return page.chart('One free run over the whole recording, from the state of its first window; '
                      'errors add up', panels, 'time (s)', 't (s)')


def _where(data, evidence):
    html = ''
    if data['verdict'] != 'none':
        rows = []
        for place, part in data['where']['places'].items():
            name = 'motor, actuator' if place == 'motor_side' else PLACES[place]
            best = place == data['where']['place']
            rows.append((name, '', part['explained'], percent(part['explained']),
                         'closed' if best else 'closed faint', None))
        html += page.paragraph(
            on_axis('A free signal, torque or encoder offset, was put at each place in place of '
                    'an effect. ', evidence.axis)
            + ('Two encoders determine two signals: only at the right place does one signal '
               'explain both. Bars: share of the gap that it explains.'
               if len(rows) > 1 else 'Here no other place can be told from it.')
        ) + page.bars(rows, top=1.0)
        dense = dense_regions(data['where'].get('region') or {})
        if dense:
            html += page.paragraph(f'The gap sits at {", ".join(dense)}.')
        if len(ids_of(data)) > 1:
            html += page.paragraph('With two effects no single place can be right.')
        html += _missing(evidence)
    charts = []
    for name, over in evidence.maps.items():
        label = evidence.labels[name]
        lines = tuple(page.Line(found.edges, found.rms, run.name, role, step=True)
                      for run, role, found in zip(evidence.overlay.runs, ROLES, over))
        panel = page.Panel('gap', lines, 1.0, 130, AROUND)
        charts.append(page.chart(f'over {name}', [panel], label, label, False))
    html += '<h3>Gap over the motion</h3>' + page.grid(*charts)
    one, other, columns, rows, planes = evidence.planes
    return html + page.heat_maps(
        f'Gap over {one} and {other}',
        [(run.name, values) for run, values in zip(evidence.overlay.runs, planes)],
        columns, rows, evidence.labels[one], evidence.labels[other], '= gap')


def _missing(evidence):
    """Return the charts of the signal that is missing at one place."""
    missing = evidence.missing
    what = {'N m': 'torque', 'N': 'force'}.get(missing.unit, 'offset')
    at = 'motor, actuator' if missing.place == 'motor_side' else PLACES[missing.place]
    charts = []
    for name, law in missing.laws.items():
        label = evidence.labels[name]
        line = page.Line(law.centers, law.value, f'missing {what}', 'signal',
                         band=(law.value - 2.0 * law.error, law.value + 2.0 * law.error))
        title = explained_by(name, law)
        charts.append(page.chart(title, [
            page.Panel(f'{what} ({missing.unit})', (line,), 0.0, 130)], label, label, False))
    return (f'<h3>Missing {what}: {at}</h3>' + page.paragraph(
        f'The {what} that the nominal model lacks there, as a function of one thing at a time, '
        'with two standard errors. Explains: how much of it such a function foretells in windows '
        'it was not fitted to. Where it is much, the shape says what kind of effect it is.'
    ) + page.grid(*charts))


def _which(data, evidence):
    gains = data.get('gains') or {}
    named = data.get('effect')
    rivals = set(data.get('confusable') or ())
    best = sorted(gains, key=gains.get, reverse=True)[:RANKED]
    rows = []
    for name in best:
        note = ('named' if name == named else 'cannot be told from the effect named'
                if name in rivals else meaning(name, evidence.axis))
        rows.append((name, note, max(gains[name], 0.0), behind(gains, name),
                     'closed' if name == named else 'closed faint', None))
    if not rows:
        return page.paragraph('No effect was tried.')
    html = page.paragraph(
        'By how much each effect beats the plain model, in 2 log likelihood less a price per '
        'parameter, on the windows of the fit; in brackets, how far it is behind. A gain below '
        '25 is chance; less than 20 behind is no clear difference.') + page.bars(rows)
    if data['verdict'] == 'effect':
        html += page.paragraph(
            'This recording cannot tell these from the effect named: '
            f'{", ".join(data["confusable"])}. Read the verdict as "one of these".'
            if data['confusable'] else
            'No other effect that was tried has the same signature in this recording.')
        close = [name for name in best if name != named and name not in rivals
                 and gains.get(named, 0.0) - gains[name] < LIMIT]
        if close:
            html += page.paragraph(
                f'Hardly behind: {", ".join(close)}. That explains the recording nearly as well.')
    for name, (d, shares) in evidence.separations.items():
        nearest = sorted(shares.items(), key=lambda item: item[1])[:RIVALS]
        if nearest:
            html += f'<h3>What could imitate {escape(name)}</h3>' + page.paragraph(
                f'Its evidence is d = {number(d)}. An effect that leaves the share s2 of it '
                f'unexplained is told apart where d s2 is above {LIMIT:g}.') + page.table(
                ('effect', 's2', 'd s2', ''),
                [(other, f'{s2:.3f}', number(d * s2), '' if d * s2 > LIMIT else 'too close')
                 for other, s2 in nearest], (1, 2))
    if evidence.matrix is not None:
        ids, s2 = evidence.matrix
        html += '<h3>What this motion tells apart</h3>' + page.paragraph(
            'Share (%) of what the effect of the row does to the readings that the one of the '
            'column cannot imitate. Orange: hardly to be told apart by this motion, whatever the '
            'verdict.') + page.matrix(ids, s2.tolist())
    return html


def _values(data, axis):
    known, rows = library(), []
    errors = data.get('standard_errors') or {}
    for name, values in (data.get('params') or {}).items():
        units = {p.name: p.unit for p in known[name].parameters} if name in known else {}
        for parameter, value in values.items():
            error = (errors.get(name) or {}).get(parameter)
            simple = isinstance(value, (int, float))
            rows.append((name, parameter, number(value) if simple else str(value),
                         f'{error:.2g}' if error else '', on_axis(units.get(parameter, ''), axis)))
    html = ''
    if data['verdict'] == 'unknown' and rows:
        html += page.paragraph('Of the effect that comes nearest, and does not explain the gap:')
    if rows:
        html += page.table(('effect', 'parameter', 'value', 'standard error', 'unit'), rows,
                           (2, 3))
        html += ''.join(f'<p class="soft"><code>{escape(name)}: {escape(known[name].equation)}'
                        '</code></p>' for name in data.get('params') or {} if name in known)
    shifts = data.get('nominal_shift') or {}
    if shifts:
        html += '<h3>Values of the model, estimated along</h3>' + page.table(
            ('value', 'estimate', 'off by tolerances'),
            [(name, number(data['nominal'][name]), f'{shift:+.1f}')
             for name, shift in shifts.items()], (1, 2))
    return html or page.paragraph('The values of the model file stand.')


def _doubts(data, recordings, evidence):
    rows = [(_short(r), f'{r.duration:.1f}', f'{1.0 / r.dt:.0f}') for r in recordings]
    sigma = data['sigma']
    noise = ', '.join(f'{name} {number(value)} {unit_of(name, "rad")}' for name, value in
                      zip(evidence.overlay.recording.readings, sigma) if value is not None)
    html = page.table(('recording', 's', 'samples/s'), rows, (1, 2)) + page.paragraph(on_axis(
        f'Noise of the readings: {noise}, measured from the recording. Torque noise: '
        f'{number(data["process_torque"])} N m rms per sample.', evidence.axis))
    warnings = list(data.get('warnings') or ())
    misfit = data.get('misfit') or {}
    if misfit.get('excess') is not None and misfit.get('structure') is not None:
        html += page.paragraph(
            f'What the verdict leaves: chi2 per reading {1.0 + misfit["excess"]:.3f} (1 is '
            f'noise), {misfit["structure"]:.1f} standard deviations from white noise.')
    if data.get('condition'):
        html += page.paragraph('Condition of the scaled normal matrix: '
                               f'{number(data["condition"])}.')
    return html + (page.bullets([_sentence(w) for w in warnings])
                   or page.paragraph('No warnings.'))
