# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a fleet: backlash of each gearbox over time, the most worn first; failed bags."""
from collections.abc import Iterable, Mapping, Sequence
import math
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.health.backlash.wear import span, when
from gearbox_monitor.report.builder import advice, Page, page_summary, render_page, Section
from gearbox_monitor.report.figures import BarRow, bars, chart, PageTable, Panel, Trace
from gearbox_monitor.report.words import counted, width_and_std

Gearbox: TypeAlias = Mapping[str, Any]  # a row of fleet.trend.gearboxes
Bag: TypeAlias = Mapping[str, Any]      # a row of the table of bags
RANKED = 30   # gearboxes with a bar
DRAWN = 24    # with a curve
LISTED = 500  # bags in the table of those that need a look
DAY = 86400e9
SIGNIFICANT = 2.0  # standard deviations: less growth is none
NOTABLE = 0.005    # relative growth that is worth a word
FEATURES = {'gap': 'backlash', 'lost_motion': 'lost motion'}


def fleet_page(gearboxes: Sequence[Gearbox], bags: Sequence[Bag], counts: Mapping[str, int],
               other_settings: int) -> str:
    """
    Return the page of a fleet as HTML.

    Args:
        gearboxes: fleet.trend.gearboxes(bags), the most worn first.
        bags: rows of the table of bags.
        counts: {status: bags}.
        other_settings: analysed bags with other settings than the last run.

    Returns:
        One file that loads nothing.

    """
    sections: list[Section] = [
        advice(next_steps(gearboxes, bags)), _ranking(gearboxes), _curves(gearboxes),
        _table(gearboxes)]
    if any(gearbox['diagnosis'] for gearbox in gearboxes):
        sections.append(_diagnoses(gearboxes))
    sections.append(bag_problems(bags, other_settings))
    return render_page(Page('Fleet', _summary(gearboxes, counts), sections))


def next_steps(gearboxes: Sequence[Gearbox], bags: Sequence[Bag]) -> list[str]:
    """Return advice about `gearboxes` and their `bags`."""
    worn = growing(gearboxes)
    steps = [f'Inspect {", ".join(gearbox["gearbox"] for gearbox in worn)}; open the newest bag: '
             'gearbox_monitor report BAG --out page.html'] if worn else []
    if any(bag['status'] == 'failed' and bag['retry'] for bag in bags):
        steps.append('Run the same command again: some bags failed for reasons that may pass')
    if any(gearbox['measured'] < 2 for gearbox in gearboxes):
        steps.append('Record gearboxes that were measured in fewer than two bags, with motion in '
                     'both directions; gearbox_monitor check BAG names what a recording lacks')
    return steps or ['Nothing now. Run the same command when there are new bags: it analyses '
                     'only these']


def growing(gearboxes: Iterable[Gearbox]) -> list[Gearbox]:
    """Return those of `gearboxes` whose growth is significant and notable."""
    return [gearbox for gearbox in gearboxes if gearbox['growth'] is not None
            and gearbox['growth'] - SIGNIFICANT * gearbox['growth_std'] > NOTABLE]


def headline(gearboxes: Sequence[Gearbox]) -> str:
    """Return the most important fact about `gearboxes` in one sentence."""
    worn, compared = growing(gearboxes), sum(box['growth'] is not None for box in gearboxes)
    passed = [f' {box["gearbox"]} {excursion_text(box)}.' for box in gearboxes
              if excursion_text(box)]
    ended = passed[0] + (f' So had {len(passed) - 1} more.' if passed[1:] else '') \
        if passed else ''
    if not compared:
        return ('No gearbox was measured twice: growth needs two bags, each with a window '
                'in which it moves both ways.')
    if not worn:
        doubtful = [box for box in gearboxes if box['growth'] is not None
                    and box['growth'] > box['growth_std'] and box['growth'] > NOTABLE]
        doubt = f' {_not_significant(max(doubtful, key=lambda box: box["growth"]))}' \
            if doubtful else ''
        return (f'No significant growth: {counted(compared, "gearbox")} '
                f'{"was" if compared == 1 else "were"} measured more than once.{doubt}{ended}')
    first = worn[0]
    many = FEATURES[first['feature']].capitalize()
    return (f'{many} has grown in {len(worn)} of {counted(compared, "gearbox")}'
            f', most in {first["gearbox"]}: {growth_text(first)} '
            f'since {day(first["start"][0])}.{ended}')


def _not_significant(gearbox: Gearbox) -> str:
    """Return the words for a growth that is more than its deviation, and what would settle it."""
    growth, std = gearbox['growth'], gearbox['growth_std']
    times = math.ceil((SIGNIFICANT * std / (growth - NOTABLE)) ** 2)
    return (f'{growth_text(gearbox)} of {gearbox["gearbox"]} is not significant: record '
            f'{max(times, 2)} times as long.')


def growth_text(gearbox: Gearbox) -> str:
    """Return the growth of `gearbox` in words."""
    if gearbox['growth'] is None:
        return 'one bag' if gearbox['measured'] else 'not measured'
    digits = 1 if gearbox['growth_std'] >= 0.001 else 2
    return (f'{100 * gearbox["growth"]:+.{digits}f} ± '
            f'{100 * gearbox["growth_std"]:.{digits}f} %')


def excursion_text(gearbox: Gearbox) -> str:
    """Return the growth of `gearbox` that has ended in words, '' if there was none."""
    excursion = gearbox['excursion']
    if not excursion or excursion['growth'] < NOTABLE:
        return ''
    days = [day(excursion[key]) for key in ('start', 'end')]
    return (f'was {growth_text({**gearbox, **excursion})} from {days[0]} to {days[1]} '
            f'({counted(excursion["bags"], "bag")}), which has ended')


def day(stamp_ns: float) -> str:
    """Return the date of `stamp_ns`, or its seconds if the clock was a simulated one."""
    text = when(int(stamp_ns))
    return text if text.startswith('t =') else text[:10]


def width_text(gearbox: Gearbox) -> str:
    """Return the newest measurement of `gearbox` in words."""
    if gearbox['width'] is None:
        return 'not measured'
    return width_and_std(gearbox['width'], gearbox['width_std'], gearbox['unit'])


def limit_text(gearbox: Gearbox) -> str:
    """Return when `gearbox` will reach its limit, '' if no trend says so."""
    if not gearbox['reach']:
        return ''
    expected, low, high = gearbox['reach']
    return f'{100 * gearbox["limit"]:+.0f} % in {span(expected)} ({span(low)} to {span(high)})'


def _summary(gearboxes: Sequence[Gearbox], counts: Mapping[str, int]) -> Section:
    """Return headline and figures of the `gearboxes` and the `counts` {status: bags}."""
    facts = [('gearboxes', str(len(gearboxes))), ('bags', str(sum(counts.values())))]
    facts += [(name, str(counts[status])) for status, name in (
        ('done', 'analysed'), ('failed', 'failed'), ('duplicate', 'duplicates'))
        if counts.get(status)]
    if gearboxes:
        facts.append(('newest bag', day(max(gearbox['last'] for gearbox in gearboxes))))
    worn = growing(gearboxes)
    kind = 'good' if any(box['growth'] is not None for box in gearboxes) else ''
    if worn:
        kind = 'error' if any(box['growth'] >= box['limit'] for box in worn) else 'warn'
    return page_summary(kind, headline(gearboxes), facts)


def _ranking(gearboxes: Sequence[Gearbox]) -> Section:
    """Return the growth of each gearbox as a bar."""
    worn = {gearbox['gearbox'] for gearbox in growing(gearboxes)}
    rows = []
    for gearbox in gearboxes[:RANKED]:
        growth = gearbox['growth']
        interval = None if growth is None else (
            growth - SIGNIFICANT * gearbox['growth_std'],
            growth + SIGNIFICANT * gearbox['growth_std'])
        note = '; '.join(filter(None, (
            width_text(gearbox), limit_text(gearbox), excursion_text(gearbox))))
        rows.append(BarRow(gearbox['gearbox'], note, growth, growth_text(gearbox),
                           'nominal' if gearbox['gearbox'] in worn else 'closed faint', interval))
    top = max([0.05, *(row.interval[1] for row in rows if row.interval)])
    return Section('fleet/ranking.html', {
        'bars': bars(rows, top=top), 'unlisted': len(gearboxes) - RANKED}, 'Worst first')


def _curves(gearboxes: Sequence[Gearbox]) -> Section:
    """Return a chart per measured gearbox."""
    measured = [gearbox for gearbox in gearboxes if gearbox['measured']]
    first = min((gearbox['start'][0] for gearbox in measured), default=0.0)
    last = max((gearbox['start'][-1] for gearbox in measured), default=0.0)
    days = max((last - first) / DAY, 1.0)
    label = f'days since {day(first)}'
    charts = [chart(
        f'{gearbox["gearbox"]}: {growth_text(gearbox)}', [Panel(
            f'{FEATURES[gearbox["feature"]]} ({gearbox["unit"]})', _traces(gearbox, first),
            height=150)],
        label, label, False, span=(-0.01 * days, 1.01 * days)) for gearbox in measured[:DRAWN]]
    return Section('fleet/curves.html', {
        'charts': charts, 'unlisted': len(measured) - DRAWN}, 'Over time')


def _traces(gearbox: Gearbox, first: float) -> list[Trace]:
    """Return the curves of one gearbox over the days since `first`."""
    x = (np.array(gearbox['start'], float) - first) / DAY
    y, std = np.array(gearbox['value']), np.array(gearbox['std'])
    traces = [Trace(x, y, 'each bag', 'closed', dots=True,
                    band=(y - SIGNIFICANT * std, y + SIGNIFICANT * std))]
    if gearbox['line']:
        traces.append(Trace(x[[0, -1]], np.array(gearbox['line']), 'line', 'nominal'))
    return traces


def _table(gearboxes: Sequence[Gearbox]) -> Section:
    """Return all gearboxes, and those that were never measured with the reason."""
    rows = []
    for gearbox in gearboxes:
        pace = '' if gearbox['per_year'] is None else \
            f'{100 * gearbox["per_year"]:+.1f} ± {100 * gearbox["per_year_std"]:.1f}'
        feature = 'lost motion ' if gearbox['measured'] and gearbox['feature'] != 'gap' else ''
        days = f'{day(gearbox["first"])} to {day(gearbox["last"])}'.replace('-', '\u2011')
        rows.append([
            gearbox['gearbox'], feature + _unbroken(width_text(gearbox)),
            *(_unbroken(text) for text in (
                growth_text(gearbox), gearbox['trust'], gearbox['model_level'],
                f'{gearbox["measured"]} of {gearbox["bags"]}')),
            limit_text(gearbox), _unbroken(pace), days])
    return Section('fleet/table.html', {
        'gearboxes': PageTable(('gearbox', 'newest backlash', 'growth', 'trust', 'model',
                                'measured in bags', 'limit', '% per year', 'recorded'), rows),
        'unmeasured': PageTable(('never measured', 'missing in the newest bag'), [
            (gearbox['gearbox'], gearbox['not_excited']) for gearbox in gearboxes
            if gearbox['not_excited']])}, 'All gearboxes')


def _unbroken(text: str) -> str:
    """Return `text` so that lines do not break in it."""
    return text.replace(' ', '\u00a0')


def _diagnoses(gearboxes: Sequence[Gearbox]) -> Section:
    """Return the newest verdict of each diagnosed gearbox."""
    return Section('fleet/diagnoses.html', {
        'verdicts': PageTable(('gearbox', 'verdict', 'effect'), [
            (gearbox['gearbox'], gearbox['diagnosis'], gearbox['diagnosis_effect'] or '')
            for gearbox in gearboxes if gearbox['diagnosis']])}, 'Diagnoses')


def bag_problems(bags: Sequence[Bag], other_settings: int) -> Section:
    """Return those of `bags` that failed, duplicates, notes; `other_settings`: see fleet_page."""
    rows = [(bag['path'], 'failed, will be tried again' if bag['retry'] else 'failed',
             bag['reason'].removeprefix(bag['path'] + ': '))
            for bag in bags if bag['status'] == 'failed']
    rows += [(bag['path'], 'duplicate', f'of {bag["duplicate_of"]}')
             for bag in bags if bag['status'] == 'duplicate']
    rows += _notes(bags)
    return Section('fleet/bags.html', {
        'other_settings': other_settings, 'unlisted': len(rows) - LISTED,
        'bags': PageTable(('bag', '', 'reason'), rows[:LISTED])}, 'Bags that need a look')


def _notes(bags: Iterable[Bag]) -> list[tuple[str, str, str]]:
    """Return rows about analysed bags, one for all bags with the same note."""
    paths_by_note: dict[str, list[str]] = {}
    for bag in bags:
        for note in (bag['notes'], bag['diagnosis_reason']):
            if bag['status'] == 'done' and note:
                note = note.replace(bag['path'] + ': ', '')
                paths_by_note.setdefault(note, []).append(bag['path'])
    return [(paths[0] + (f' and {len(paths) - 1} more' if paths[1:] else ''), 'note', note)
            for note, paths in paths_by_note.items()]
