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

"""The page of a recording: loop, backlash, prediction errors, trust, input, parameters."""
from html import escape
import json

import numpy as np

from gearbox_monitor.monitoring.backlash.forecast import when
from gearbox_monitor.monitoring.checks.innovation import NIS_HIGH, NIS_LOW
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report import page
from gearbox_monitor.report.builder import render_page
from gearbox_monitor.report.timeline import LEVELS
from gearbox_monitor.report.words import number

JUDGED = ('observability', 'prediction error', 'covariance', 'model', 'input')
WORN = ('backlash', 'friction')
UNKNOWN = 'no data'  # so begins what was never judged
TRUSTED = 0.9      # share of the time below which that is the headline
MINUTES = 600.0    # s: longer recordings are shown in minutes
LISTED = 200       # changes of level
CHANNELS = ('motor', 'arm')
ROLES = ('good', 'warn', 'error')  # of alerts, by level
GROUP = 'time'


def report(line, facts, name, out=''):
    """
    Return the page, HTML.

    line: Timeline; facts: sources.Facts; name: of the recording; out: '' or a sentence about it.
    """
    axis = facts.model.axis
    scale, unit = (60.0, 'min') if line.last > MINUTES else (1.0, 's')
    time = _Time(line.last / scale, scale, unit)
    sections = [('Torque over twist', _loops(line, axis)),
                ('Backlash', _backlash(line, time, axis)),
                ('Trust', _trust(line, time)),
                ('Prediction errors', _errors(line, time, axis)),
                ('Torque', _torque(line, time, axis)),
                ('Input', _input(line, facts, time)),
                ('Parameters and versions', _parameters(facts))]
    return render_page(f'Recording {name}', sections, _lead(line, facts, axis) + (
        page.paragraph(out) if out else ''))


class _Time:
    """The axis of time: last value, s per unit, and its labels."""

    def __init__(self, last, scale, unit):
        self.last, self.scale, self._name = max(last, 1e-9), scale, unit
        self.label, self.unit = f'time ({unit})', f't ({unit})'

    def at(self, t):
        """Return the time `t` s in words."""
        return f'{t / self.scale:.4g} {self._name}'

    def chart(self, title, panels, marks=()):
        """Return a chart on this axis; all of them zoom together."""
        return page.chart(title, panels, self.label, self.unit, marks=marks, group=GROUP,
                          span=(0.0, self.last))


def figures(line, facts):
    """Return what the page says as {name: value}, for programs; None: not known."""
    widths = [w for w in line.windows if w.separable and np.isfinite(w.gap)]
    _, _, nis = line.nis.of(0)
    nis = nis[np.isfinite(nis)]
    return {
        'samples': line.samples, 'duration_s': line.last, 'live': facts.live,
        'filter': facts.parameters.filter, 'loops': len(line.loops),
        'nis_over_dof': float(nis.mean()) if len(nis) else None,
        'within_2_sigma': {name: float(within / count) if count else None for name, (count, within)
                           in zip(CHANNELS, line.inside)},
        'windows': len(line.windows),
        'gap_rad': [w.gap for w in widths], 'gap_std_rad': [w.gap_std for w in widths],
        'levels': {name: dict(zip(LEVELS, spans.shares())) for name, spans in line.spans.items()},
        'alerts': [{'t': a.t, 'component': a.component, 'level': LEVELS[a.level],
                    'message': a.message} for a in line.alerts],
        'counts': facts.counts, 'notes': facts.notes}


def headline(line):
    """Return (sentence, 'good', 'warn' or '') about the recording."""
    worn = [(s.levels[-1], s.messages[-1]) for name, s in line.spans.items()
            if name in WORN and s.levels[-1] and not s.messages[-1].startswith(UNKNOWN)
            and 'not measured' not in s.messages[-1]]
    if worn:
        message = max(worn)[1].split(' (for ')[0]
        return f'{message[0].upper()}{message[1:]}.', 'warn'
    share = trusted(line)
    if share is None:
        return 'Nothing was judged: the recording is too short, or holds no estimates.', ''
    if share < TRUSTED:
        return (f'The estimates were trusted {100 * share:.0f} % of the time: '
                f'{_doubt(line)}.'), 'warn'
    if not line.windows:
        return f'Trusted {100 * share:.0f} % of the time; backlash was not measured.', ''
    return f'No growth of the backlash; trusted {100 * share:.0f} % of the time.', 'good'


def _doubt(line):
    """Return what was said against the estimates for longest."""
    alarms = [(level, end - begin, message) for name in JUDGED if name in line.spans
              for s in (line.spans[name],) for begin, end, level, message in zip(
                  s.begins, (*s.begins[1:], s.end), s.levels, s.messages)
              if level and not message.startswith(UNKNOWN)]
    return max(alarms)[2].split(': ')[0].split(' (for ')[0]  # the advice stands in the section


def trusted(line):
    """Return the share of the judged time in which no indicator of trust had an alarm, or None."""
    spans = [line.spans[name] for name in JUDGED if name in line.spans]
    edges = np.unique([t for s in spans for t in (*s.begins, s.end)])
    if len(edges) < 2:
        return None
    known, alarmed = np.zeros((2, len(edges) - 1), bool)
    for s in spans:
        at = np.maximum(np.searchsorted(s.begins, edges[:-1], 'right') - 1, 0)
        judged = ~np.array([message.startswith(UNKNOWN) for message in s.messages])[at]
        known |= judged
        alarmed |= judged & (np.array(s.levels)[at] > 0)
    lengths = np.diff(edges)
    total = float(lengths[known].sum())
    return float(lengths[known & ~alarmed].sum()) / total if total > 0.0 else None


def _lead(line, facts, axis):
    words, kind = headline(line)
    told = figures(line, facts)
    items = [('from', when(line.first_ns or 0)), ('duration', f'{line.last:.4g} s'),
             ('samples', str(line.samples)), ('filter', told['filter'])]
    if told['nis_over_dof'] is not None:
        items.append(('NIS per reading (1 expected)', f'{told["nis_over_dof"]:.3f}'))
    if told['gap_rad']:
        items.append(('gap, newest', on_axis(
            f'{told["gap_rad"][-1]:.4g} ± {told["gap_std_rad"][-1]:.1g} rad', axis)))
    items.append(('alerts', str(len(line.alerts))))
    how = ('Estimates as they were published live.' if facts.live else
           'The estimator was run on the recorded samples for this page.')
    notes = page.bullets(facts.notes)
    return (f'<div class="verdict {kind}"><p class="lead">{escape(words)}</p>'
            f'{page.paragraph(how, soft=True)}{page.facts(items)}</div>{notes}')


def _loops(line, axis):
    if not line.loops:
        return page.paragraph('The twist was not measured, or never changed, or not for long '
                              'enough.')
    minutes = line.slice_seconds >= 60.0
    slices = [page.Slice(_clock(loop, minutes), loop.cloud, (loop.up, loop.down))
              for loop in line.loops]
    what = 'minute' if line.slice_seconds == 60.0 else f'{line.slice_seconds:g} s'
    return page.paragraph(
        'Torque through the gearbox over its twist, smoothed: two lines per slice of time, the '
        'mean while the twist grows and while it falls. The flat part is the gap, the slope the '
        'stiffness, the height between the lines hysteresis. Choose a slice to see its points '
        'against all others; the first one stays, dashed.') + page.loops(
            f'One loop per {what}', slices, on_axis('twist, motor - arm (rad)', axis),
            on_axis('torque (N m)', axis))


def _clock(loop, minutes):
    scale, unit = (60.0, 'min') if minutes else (1.0, 's')
    return f'{loop.begin / scale:.0f} to {np.ceil(loop.end / scale):.0f} {unit}'


def _backlash(line, time, axis):
    marks, listed = [], []
    for k, alert in enumerate(line.alerts):
        marks.append(page.Mark(alert.t / time.scale, str(k + 1), ROLES[alert.level]))
        listed.append(f'{k + 1}, {time.at(alert.t)}: {alert.component} {LEVELS[alert.level]}: '
                      f'{alert.message}')
    spans = line.spans.get('backlash')
    if not line.windows:
        why = spans.messages[-1] if spans else 'nothing was judged'
        return page.paragraph(f'Not measured: {why}.')
    clear = [w for w in line.windows if w.separable]
    shown = clear if 2 * len(clear) >= len(line.windows) else line.windows
    lost = shown is not clear
    t = np.array([w.t for w in shown]) / time.scale
    value = np.array([w.lost_motion if lost else w.gap for w in shown])
    lines = []
    if not lost:
        for name, role, style in (('baseline', 'limit', 'baseline'), ('plan a service', 'warn',
                                  'warn'), ('service it', 'error', 'error')):
            level = np.array([getattr(w, style) for w in shown])
            if np.isfinite(level).any():
                lines.append(page.Line(t, level, name, role))
        std = np.array([w.gap_std for w in shown])
        lines.append(page.Line(t, value, 'gap, ± 2 sigma', 'closed', dots=True,
                               band=(value - 2.0 * std, value + 2.0 * std)))
    else:
        lines.append(page.Line(t, value, 'lost motion', 'closed', dots=True))
    finite = value[np.isfinite(value)]
    levels = np.concatenate([line_.y[np.isfinite(line_.y)] for line_ in lines[:-1]] or [finite])
    top = max([*finite, *levels], default=1.0)
    low = min([*finite, *levels], default=0.0)
    room = 0.15 * (top - low) or 0.5 * abs(top) or 1.0
    panel = page.Panel(on_axis(f'{"lost motion" if lost else "gap"} (rad)', axis), tuple(lines),
                       height=240, limits=(low - room, top + room))
    html = page.paragraph(
        'Motion and load do not tell gap and compliance apart here: the lost motion stands for '
        'the gap.' if lost else
        'Width of the gap, one point per window of drift, with the baseline of the operating '
        'point and the limits from which on a service is advised.')
    html += time.chart('Width of the gap' if not lost else 'Lost motion', [panel], marks)
    if listed:
        html += '<h3>Alerts</h3>' + page.bullets(listed)
    else:
        html += page.paragraph('No alert on backlash or friction.')
    if spans and spans.messages:
        html += page.paragraph(f'At the end: {spans.messages[-1]}', soft=True)
    return html


def _trust(line, time):
    names = [n for n in (*JUDGED, *WORN) if n in line.spans]
    if not names:
        return page.paragraph('Nothing was judged.')
    lanes, rows = [], []
    for name in names:
        spans = line.spans[name]
        shares = spans.shares()
        told = ', '.join(f'{level} {100 * share:.3g} %' for level, share in zip(LEVELS, shares)
                         if share)
        lanes.append(page.Lane(
            f'{name}: {told}', tuple(b / time.scale for b in spans.begins), spans.end / time.scale,
            tuple(spans.levels), tuple(f'{name} {LEVELS[level]}' for level in spans.levels)))
        rows += [(t, name, level, message) for t, level, message in zip(
            spans.begins, spans.levels, spans.messages)]
    rows.sort(key=lambda row: row[0])
    listed = [f'{time.at(t)}: {name} {LEVELS[level]}: {message}'
              for t, name, level, message in rows[:LISTED]]
    more = f', the first {LISTED} of {len(rows)}' if len(rows) > LISTED else ''
    return page.paragraph(
        'What was in force when. Thin: OK. Half high: WARN, also while nothing has been judged '
        'yet. Full height: ERROR. Under the pointer stands what it was.') + time.chart(
            'Levels', lanes) + page.details(f'every change of level{more}', page.bullets(listed))


def _errors(line, time, axis):
    t = line.errors.t / time.scale
    if not len(t):
        return page.paragraph('No estimates.')
    panels = []
    for k, name in enumerate(CHANNELS):
        low, high, mean = line.errors.of(k)
        _, _, std = line.errors.of(k + 2)
        count, within = line.inside[k]
        if not count:
            continue
        top = 3.0 * float(np.nanmedian(2.0 * std))
        panels.append(page.Panel(
            on_axis(f'{name}, rad: {100 * within / count:.1f} % within 2 sigma', axis),
            (page.Line(t, mean, 'mean, lowest, highest', 'closed', band=(low, high)),
             page.Line(t, 2.0 * std, '2 sigma as stated', 'nominal firm'),
             page.Line(t, -2.0 * std, '', 'nominal firm')), 0.0, 150, limits=(-top, top)))
    html = page.paragraph(
        'Measured less predicted position. Where the model is right, the errors have no mean and '
        '95 % of them lie between the lines. Values beyond three times the lines are cut off.')
    html += time.chart('Prediction errors of the encoders', panels)
    _, _, nis = line.nis.of(0)
    if np.isfinite(nis).any():
        edges = np.array([0.0, time.last])
        known = np.isfinite(nis)  # once per second where it comes from diagnostics
        at, nis = _coarser(line.nis.t[known] / time.scale, nis[known])
        top = max(1.6, min(4.0, float(np.nanpercentile(nis, 99)) * 1.2))
        html += time.chart('Size of the prediction errors: NIS over its degrees of freedom', [
            page.Panel('1 is expected', (
                page.Line(edges, np.full(2, NIS_HIGH), 'limits of the alarm', 'warn'),
                page.Line(edges, np.full(2, NIS_LOW), '', 'warn'),
                page.Line(at, nis, 'NIS', 'closed')), 1.0, 140, limits=(0.0, top))])
    return html


def _coarser(t, values, most=400):
    """Return means of neighbours, no more than `most`: what scatters bin by bin."""
    size = -(-len(t) // most)
    count = len(t) // size
    return tuple(v[:count * size].reshape(count, size).mean(axis=1) for v in (t, values))


def _torque(line, time, axis):
    t = line.torque.t / time.scale
    low, high, mean = line.torque.of(0)
    _, _, std = line.torque.of(1)
    u_low, u_high, u_mean = line.torque.of(2)
    panels = []
    if np.isfinite(mean).any():
        panels.append(page.Panel(on_axis('through the gearbox (N m)', axis), (page.Line(
            t, mean, 'mean, lowest, highest', 'closed', band=(low, high)),), 0.0))
        panels.append(page.Panel(on_axis('its stated deviation (N m)', axis), (
            page.Line(t, std, 'deviation', 'nominal firm'),), height=90, shown=(0.0,)))
    panels.append(page.Panel(on_axis('commanded (N m)', axis), (page.Line(
        t, u_mean, 'commanded', 'recording', band=(u_low, u_high)),), 0.0, 120))
    return time.chart('Torque, filtered', panels)


def _input(line, facts, time):
    t, rate, step = line.rates()
    counted = [(name, count) for name, count in facts.counts.items() if count and name != 'starts']
    panels = [page.Panel('samples/s', (page.Line(t / time.scale, rate, 'rate', 'closed'),), None,
                         110, (0.0,)),
              page.Panel('longest step (ms)', (
                  page.Line(t / time.scale, 1e3 * step, 'longest step between stamps',
                            'nominal firm'),), None, 110, (0.0,))]
    html = time.chart('Samples by their stamps', panels)
    html += page.table(('counter', ''), counted, (1,)) if counted else page.paragraph(
        'No sample was refused, none is missing.')
    return html


def _parameters(facts):
    values = facts.parameters.to_dict()
    changed = [(row.name, _shown(values[row.name]), _shown(row.default), row.unit)
               for row in ESTIMATOR if getattr(facts.parameters, row.name) != row.default]
    every = [(row.name, _shown(values[row.name]), row.unit, row.description)
             for row in ESTIMATOR]
    html = '<h3>Parameters that are not the default</h3>' + (
        page.table(('parameter', 'value', 'default', 'unit'), changed) if changed else
        page.paragraph('None.'))
    html += page.details('all parameters', page.table(
        ('parameter', 'value', 'unit', 'what'), every))
    html += page.details('model', '<pre>' + escape(json.dumps(
        facts.model.to_dict(), indent=1)) + '</pre>')
    return html + '<h3>Versions</h3>' + page.table(('of', 'version'), facts.versions)


def _shown(value):
    return number(value) if isinstance(value, float) else str(value)
