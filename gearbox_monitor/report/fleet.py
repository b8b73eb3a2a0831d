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

"""The page of a fleet: gap width of each gearbox over time, the worst first; what failed."""
from html import escape

import numpy as np

from gearbox_monitor.monitoring.backlash.forecast import span, when
from gearbox_monitor.report import page
from gearbox_monitor.report.builder import render_page

RANKED = 30   # gearboxes with a bar
DRAWN = 24    # with a curve
LISTED = 500  # bags in the table of those that need a look
DAY = 86400e9
SURE = 2.0     # standard deviations: less growth is none
NOTICED = 0.005  # relative growth that is worth a word
FEATURES = {'gap': 'gap', 'lost_motion': 'lost motion'}


def report(boxes, rows, counts, other_settings):
    """
    Return the page, HTML.

    boxes: fleet.trend.gearboxes(rows), worst first; rows: of the table of bags (dicts); counts
    {status: bags}; other_settings: done bags that were analysed with other settings than the last.
    """
    sections = [('Worst first', _ranking(boxes)), ('Over time', _curves(boxes)),
                ('All gearboxes', _table(boxes))]
    if any(box['diagnosis'] for box in boxes):
        sections.append(('Diagnoses', _diagnoses(boxes)))
    sections.append(('Bags that need a look', _bags(rows, other_settings)))
    return render_page('Fleet', sections, _lead(boxes, counts))


def growing(boxes):
    """Return those of `boxes` that have surely grown."""
    return [box for box in boxes if box['growth'] is not None
            and box['growth'] - SURE * box['growth_std'] > NOTICED]


def headline(boxes):
    """Return what is to be known first, in one sentence."""
    worn, seen = growing(boxes), sum(box['growth'] is not None for box in boxes)
    if not seen:
        return 'No gearbox was measured twice: growth needs two bags in which it moves both ways.'
    if not worn:
        return f'No growth: {seen} gearboxes were measured more than once, none has surely grown.'
    worst = worn[0]
    has = 'has' if len(worn) == 1 else 'have'
    return (f'{len(worn)} of {seen} gearboxes {has} grown; most of all {worst["gearbox"]}: '
            f'{FEATURES[worst["feature"]]} {grown(worst)} since {day(worst["start"][0])}.')


def grown(box):
    """Return the growth of `box` in words."""
    if box['growth'] is None:
        return 'one bag' if box['measured'] else 'not measured'
    digits = 1 if box['growth_std'] >= 0.001 else 2
    return f'{100 * box["growth"]:+.{digits}f} +- {100 * box["growth_std"]:.{digits}f} %'


def day(stamp_ns):
    """Return the date of a stamp, or its seconds where the clock was a simulated one."""
    text = when(stamp_ns)
    return text if text.startswith('t =') else text[:10]


def width(box):
    """Return what was measured last."""
    if box['width'] is None:
        return 'not measured'
    return f'{box["width"]:.4g} +- {box["width_std"]:.1g} {box["unit"]}'


def reached(box):
    """Return when the limit will be reached, '' where no trend says so."""
    if not box['reach']:
        return ''
    left, early, late = box['reach']
    return f'{100 * box["limit"]:+.0f} % in {span(left)} ({span(early)} to {span(late)})'


def _lead(boxes, counts):
    kind = 'warn' if growing(boxes) else 'good' if boxes else ''
    facts = [('gearboxes', str(len(boxes))), ('bags', str(sum(counts.values())))]
    facts += [(name, str(counts[status])) for status, name in (
        ('done', 'analysed'), ('failed', 'failed'), ('duplicate', 'duplicates'))
        if counts.get(status)]
    if boxes:
        facts.append(('newest bag', day(max(box['last'] for box in boxes))))
    return (f'<div class="verdict {kind}"><p class="lead">{escape(headline(boxes))}</p>'
            f'{page.facts(facts)}</div>')


def _ranking(boxes):
    rows, worn = [], {box['gearbox'] for box in growing(boxes)}
    for box in boxes[:RANKED]:
        growth = box['growth']
        interval = None if growth is None else (
            growth - SURE * box['growth_std'], growth + SURE * box['growth_std'])
        note = '; '.join(filter(None, (width(box), reached(box))))
        rows.append((box['gearbox'], note, growth, grown(box),
                     'nominal' if box['gearbox'] in worn else 'closed faint', interval))
    if not rows:
        return page.paragraph('No bag could be analysed.')
    return page.paragraph(
        'Growth of the gap width: the newest bags (five at most) against the oldest ones. First '
        'is what has surely grown most: growth less two standard deviations, which the whiskers '
        'show. Where no motion tells gap and compliance apart, the lost motion stands for the '
        'gap.') + page.bars(rows, top=max([0.05, *(row[5][1] for row in rows if row[5])])) + _more(
            boxes, RANKED)


def _more(items, shown):
    left = len(items) - shown
    return page.paragraph(f'And {left} more in the table below.', soft=True) if left > 0 else ''


def _curves(boxes):
    seen = [box for box in boxes if box['measured']]
    if not seen:
        return page.paragraph('Nothing was measured.')
    first = min(box['start'][0] for box in seen)
    last = max(box['start'][-1] for box in seen)
    days = max((last - first) / DAY, 1.0)
    label = f'days since {day(first)}'
    charts = [page.chart(
        f'{box["gearbox"]}: {grown(box)}', [page.Panel(
            f'{FEATURES[box["feature"]]} ({box["unit"]})', _lines(box, first), height=150)],
        label, label, False, span=(-0.01 * days, 1.01 * days)) for box in seen[:DRAWN]]
    return page.paragraph(
        'Each bag with two standard deviations, and a straight line through all of them, where '
        'four bags or more allow one.') + page.grid(*charts) + _more(seen, DRAWN)


def _lines(box, first):
    """Return the Lines of one gearbox over the days since `first`."""
    x = (np.array(box['start'], float) - first) / DAY
    y, std = np.array(box['value']), np.array(box['std'])
    lines = [page.Line(x, y, 'each bag', 'closed', band=(y - SURE * std, y + SURE * std),
                       dots=True)]
    if box['line']:
        lines.append(page.Line(x[[0, -1]], np.array(box['line']), 'line', 'nominal'))
    return tuple(lines)


def _table(boxes):
    rows = []
    for box in boxes:
        pace = '' if box['per_year'] is None else \
            f'{100 * box["per_year"]:+.1f} +- {100 * box["per_year_std"]:.1f}'
        lost = 'lost motion ' if box['measured'] and box['feature'] != 'gap' else ''
        span_ = f'{day(box["first"])} to {day(box["last"])}'.replace('-', '\u2011')
        rows.append([_whole(text) for text in (
            box['gearbox'], lost + width(box), grown(box), box['trust'], box['model_level'],
            f'{box["measured"]} of {box["bags"]}', reached(box), pace, span_)])
    html = page.table(
        ('gearbox', 'newest gap', 'growth', 'trust', 'model', 'measured in bags', 'limit',
         '% per year', 'recorded'), rows) + page.paragraph(
        'Trust and model: the worst indicator at the end of the newest bag. Where the model is '
        'not OK the widths of different bags can still be compared, as long as it is the same '
        'model.', soft=True)
    why = [(box['gearbox'], box['not_excited']) for box in boxes if box['not_excited']]
    return html + (page.table(('never measured', 'what the newest bag lacks'), why) if why else '')


def _whole(text):
    """Return `text` so that lines do not break in it."""
    return text.replace('+-', '\u00b1').replace(' ', '\u00a0')


def _diagnoses(boxes):
    rows = [(box['gearbox'], box['diagnosis'], box['diagnosis_effect'] or '')
            for box in boxes if box['diagnosis']]
    return page.paragraph('What the newest diagnosed bag of each gearbox differs by from the '
                          'model of its drive.') + page.table(
        ('gearbox', 'verdict', 'effect'), rows)


def _bags(rows, other_settings):
    html = ''
    if other_settings:
        html += page.paragraph(f'{other_settings} bags were analysed with other settings (model, '
                               'parameters, version) than the last run: compare with care.')
    told = []
    for row in rows:
        if row['status'] == 'failed':
            what = 'failed, to be tried again' if row['retry'] else 'failed'
            told.append((row['path'], what, row['reason'].removeprefix(row['path'] + ': ')))
    for row in rows:
        if row['status'] == 'duplicate':
            told.append((row['path'], 'duplicate', f'of {row["duplicate_of"]}'))
    told += _notes(rows)
    if not told:
        return html + page.paragraph('None.')
    html += page.table(('bag', '', 'reason'), told[:LISTED])
    if len(told) > LISTED:
        html += page.paragraph(f'And {len(told) - LISTED} more in bags.parquet.', soft=True)
    return html


def _notes(rows):
    """Return lines about bags that were analysed, those with one and the same note together."""
    same = {}
    for row in rows:
        for note in (row['notes'], row['diagnosis_reason']):
            if row['status'] == 'done' and note:
                note = note.replace(row['path'] + ': ', '')
                same.setdefault(note, []).append(row['path'])
    return [(paths[0] + (f' and {len(paths) - 1} more' if paths[1:] else ''), 'note', note)
            for note, paths in same.items()]
