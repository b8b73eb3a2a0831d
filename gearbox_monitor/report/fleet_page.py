# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a fleet: backlash of each gearbox over time, the most worn first; failed bags."""
from collections.abc import Iterable, Mapping, Sequence
import csv
from io import StringIO
import shlex
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.health.backlash.change_tests import MEASURED, WEAR_FEATURES
from gearbox_monitor.health.backlash.features import width_of
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.presentation import on_axis, percent
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section)
from gearbox_monitor.report.chart import Chart, Mark, Panel, range_of, SIGMAS, Span, Trace
from gearbox_monitor.report.sentences import say
from gearbox_monitor.report.words import answer, counted, GEARBOXES, JOINTS

Gearbox: TypeAlias = Mapping[str, Any]  # of fleet.fleet_run.gearboxes
Joint: TypeAlias = Mapping[str, Any]    # of fleet.fleet_run.joints
Bag: TypeAlias = Mapping[str, Any]      # a row of the table of bags
DRAWN = 24    # with a chart
LISTED = 500  # bags in the table of those that need a look
DAY, YEAR = 86400e9, 365.25 * 86400.0
# Features with a curve: noun, unit of a rotary axis.
CURVES = {name: ('backlash' if name == 'gap' else name.replace('_', ' '), unit)
          for name, unit in MEASURED.items()}
# Whose change is relative to the healthy value.
GROWING = {feature.name for feature in WEAR_FEATURES if feature.prior.logarithmic}
# States of a robot's joint with a column and a curve.
STATES = {'friction': 'friction', 'torque_scale': 'torque scale', 'weight': 'weight',
          'rotor': 'rotor'}
SHOP = ('gearbox', 'level', 'what', 'since', 'limit about', 'limit earliest', 'serviced')
CSV_NAME = 'fleet.csv'
RAISED = ('WARN', 'ERROR')
KINDS = {None: '', 'OK': 'good', 'WARN': 'warn', 'ERROR': 'error'}


def fleet_page(boxes: Sequence[Gearbox | Joint], bags: Sequence[Bag], counts: Mapping[str, int],
               other_settings: int, robots: bool = False) -> str:
    """
    Return the page of a fleet as HTML.

    Args:
        boxes: fleet_run.gearboxes(bags), the most urgent first; of robots fleet_run.joints(bags).
        bags: rows of the table of bags.
        counts: {status: bags}.
        other_settings: analysed bags with other settings than the last run.
        robots: whether the fleet is one of robots.

    Returns:
        One file that loads nothing.

    """
    sections = [_joints(boxes), *_joint_curves(boxes)] if robots else [
        _shop(boxes), _curves(boxes), _table(boxes)]
    return render_page(Page('Fleet', _summary(boxes, counts, robots), [
        advice(next_steps(boxes, bags, robots)), *sections, bag_problems(bags, other_settings)]))


def _joints(joints: Sequence[Joint]) -> Section:
    """Return the table of all joints."""
    return Section('fleet/joints.html', {'joints': PageTable(
        ('robot', 'joint', 'state', *STATES.values(), 'recorded', 'bags'), [
            (j['robot'], j['joint'], j['summary'], *(_share(j['states'].get(k)) for k in STATES),
             _days(j), str(j['bags'])) for j in joints])}, 'All joints')


def name_of(box: Gearbox | Joint) -> str:
    """Return the name of a gearbox, or of a joint among those of all robots."""
    if 'gearbox' in box:
        return str(box['gearbox'])
    return f'{box["joint"]} of {box["robot"]}' if box['joint'] else str(box['robot'])


def _share(state: Mapping[str, Any] | None) -> str:
    """Return the size of a `state` in words, '' if it is not known well enough."""
    return '' if not state or not state['judged'] else f'{percent(state["size"], state["std"]):+}'


def _joint_curves(joints: Sequence[Joint]) -> list[Section]:
    """Return the section with a chart of each joint that was judged in two bags or more."""
    drawn = []
    first = min((j['first'] for j in joints if j['bags']), default=0)
    for j in joints:
        panels = []
        for kind, noun in STATES.items():
            known = [(p['start'], p['states'][kind]) for p in j['points']
                     if p['states'].get(kind, {}).get('judged')]
            if len(known) > 1:
                panels.append(Panel(f'{noun} (%)', [_each_bag(
                    [(start - first, 100.0 * state['size'], 100.0 * state['std'])
                     for start, state in known])], height=90))
        if panels:
            label = f'days since {day(first)}'
            drawn.append(Chart(f'{name_of(j)}: {j["summary"]}', panels, label, zoom=False))
    return [Section('fleet/curves.html', {
        'charts': drawn[:DRAWN], 'unlisted': len(drawn) - DRAWN, 'judged': ''},
                    'Over time')] if drawn else []


def _each_bag(points: Sequence[tuple[float, float, float]]) -> Trace:
    """Return the dots of bags at `points` (ns, value, its deviation)."""
    ns, y, std = np.array(points, float).T
    return Trace(ns / DAY, y, 'each bag', 'closed', dots=True).around(std)


def next_steps(boxes: Sequence[Gearbox | Joint], bags: Sequence[Bag], robots: bool) -> list[str]:
    """Return advice about gearboxes, or about joints of `robots`, and their `bags`."""
    worn = [name_of(box) for box in boxes if box['level'] in RAISED]
    own = [bag for bag in bags if bag['status'] == 'done' and bag['gearbox'] in worn[:1]]
    newest = max(own, key=lambda bag: bag['start'], default={'path': 'BAG'})['path']
    steps = [say('inspect' if robots else 'inspect_newest', names=', '.join(worn), first=worn[0],
                 bag=shlex.quote(newest))] if worn else []
    if failed := [bag['retry'] for bag in bags if bag['status'] == 'failed']:
        steps.append(say('run_again' if any(failed) else 'see_failed'))
    if any(box['level'] is None for box in boxes):
        steps.append(say('let_move' if robots else 'record_again'))
    return steps or [say('nothing_new')]


def headline(boxes: Sequence[Gearbox | Joint], robots: bool = False, failed: int = 0) -> str:
    """Return the most important fact about gearboxes, or joints of `robots`; `failed`: bags."""
    words = answer([f'{name_of(box)}: {box["summary"]}' for box in boxes
                    if box['level'] in RAISED], [box['level'] for box in boxes],
                   JOINTS if robots else GEARBOXES)
    return f'{words} {say("bags_failed", count=counted(failed, "bag"))}' if failed else words


def growth_text(feature: Mapping[str, Any]) -> str:
    """Return the change of a `feature` in words."""
    if feature['change'] is None or feature['change_std'] is None:
        return 'not compared'
    return f'{percent(feature["change"], feature["change_std"]):+}'


def day(stamp_ns: float) -> str:
    """Return the date of `stamp_ns`, or its seconds if the clock was a simulated one."""
    text = when(int(stamp_ns))
    return text if text.startswith('t =') else text[:10]


def width_text(gearbox: Gearbox) -> str:
    """Return the newest backlash of `gearbox` in words."""
    width = gearbox['features'][gearbox['feature']]
    if width['level'] is None:
        return 'not measured'
    return str(width_of(width['level'], width['level_std'] or 0.0, gearbox['unit']))


def shop_rows(gearboxes: Sequence[Gearbox]) -> list[tuple[str, ...]]:
    """Return who, what, since when, until when and serviced when of each of `gearboxes`."""
    rows = []
    for gearbox in gearboxes:
        since = [alert['since_ns'] for alert in gearbox['alerts'].values()]
        marks = [f'{day(stamp)} {words.removeprefix("serviced, ")}'
                 for stamp, words in gearbox['marks'][-1:]]
        expected, earliest = [*gearbox['features'][gearbox['feature']]['limit_ns'], None,
                              None][:2]
        rows.append((gearbox['gearbox'], gearbox['level'] or '', gearbox['summary'],
                     day(min(since)) if since else '',
                     day(expected) if expected is not None else '',
                     day(earliest) if earliest is not None else '', *(marks or [''])))
    return rows


def fleet_csv(gearboxes: Sequence[Gearbox]) -> str:
    """Return the table of `gearboxes` for the shop as CSV."""
    out = StringIO()
    csv.writer(out, lineterminator='\n').writerows([SHOP, *shop_rows(gearboxes)])
    return out.getvalue()


def _shop(gearboxes: Sequence[Gearbox]) -> Section:
    """Return the table for the shop."""
    return Section('fleet/shop.html', {
        'table': PageTable(SHOP, shop_rows(gearboxes)), 'file': CSV_NAME},
        'For the shop')


def _summary(boxes: Sequence[Gearbox | Joint], counts: Mapping[str, int], robots: bool
             ) -> Section:
    """Return headline and figures of gearboxes or joints and the `counts` {status: bags}."""
    facts = [('robots', str(len({joint['robot'] for joint in boxes}))) if robots else
             ('gearboxes', str(len(boxes))), ('bags', str(sum(counts.values())))]
    facts += [(name, str(counts[status])) for status, name in (
        ('done', 'analysed'), ('failed', 'failed'), ('duplicate', 'duplicates'))
        if counts.get(status)]
    failed, last = counts.get('failed', 0), max((box['last'] for box in boxes), default=0)
    kinds = {KINDS[box['level']] for box in boxes} | ({''} if failed else set())
    kind = next((kind for kind in ('error', 'warn', '', 'good') if kind in kinds), '')
    return page_summary(kind, headline(boxes, robots, failed),
                        [*facts, ('newest bag', day(last))] if last else facts)


def _curves(gearboxes: Sequence[Gearbox]) -> Section:
    """Return a chart per measured gearbox."""
    measured = [gearbox for gearbox in gearboxes if gearbox['points']]
    first = min((gearbox['points'][0]['start'] for gearbox in measured), default=0.0)
    last = max((gearbox['points'][-1]['start'] for gearbox in measured), default=0.0)
    days = max((last - first) / DAY, 1.0)
    label = f'days since {day(first)}'
    scales = {feature: _growth_span(measured, feature) for feature in CURVES}
    charts = [Chart(
        f'{gearbox["gearbox"]}: {gearbox["summary"]}',
        [panel for feature in CURVES for panel in _panel(
            gearbox, feature, first, scales[feature])], label,
        [Mark((stamp - first) / DAY, words.split(',')[0], 'good')
         for stamp, words in gearbox['marks']], (-0.01 * days, 1.01 * days), zoom=False)
        for gearbox in measured[:DRAWN]]
    return Section('fleet/curves.html', {
        'charts': charts, 'unlisted': len(measured) - DRAWN,
        'judged': ', and the size as judged after it. Equal growth is equally high in all '
                  'charts'}, 'Over time')


def _growth_span(gearboxes: Sequence[Gearbox], feature: str) -> Span:
    """Return the least and largest growth of a `feature`: the scale of all its panels."""
    growths = [0.0]
    for gearbox in gearboxes:
        healthy = gearbox['features'][feature]['baseline']
        if feature == gearbox['feature']:
            growths.append(gearbox['limit'])
        if healthy:
            growths += [(mean + side * SIGMAS * std) / healthy - 1.0
                        for point in gearbox['points'] if feature in point['means']
                        for mean, std in (point['means'][feature],) for side in (-1.0, 1.0)]
    return range_of(np.array(growths))


def _panel(gearbox: Gearbox, feature: str, first: float, growth: Span) -> list[Panel]:
    """
    Return the panel of a feature, none if no bag shows it.

    Args:
        gearbox: whose feature.
        feature: of CURVES.
        first: ns at which the axis of days begins.
        growth: least and largest, the scale of the panel.

    """
    points = [point for point in gearbox['points'] if feature in point['means']]
    if not points or feature != gearbox['feature'] and feature in ('gap', 'lost_motion'):
        return []
    traces = [_each_bag([(point['start'] - first, *point['means'][feature])
                         for point in points])]
    x = traces[0].x
    healthy, limits = gearbox['features'][feature]['baseline'], None
    if healthy is not None and feature in GROWING:  # held until the next bag: a jump is one
        judged = healthy * (1.0 + np.array([point['changes'][feature] for point in points]))
        traces.append(Trace(np.append(x, x[-1]), judged, 'as judged', 'nominal', step=True))
    if healthy:
        low, high = sorted(healthy * (1.0 + side) for side in growth)
        limits = low, high
    if healthy and feature == gearbox['feature']:
        traces.append(Trace(x[[0, -1]], np.full(2, healthy * (1.0 + gearbox['limit'])),
                            'limit', 'error'))
    noun, unit = CURVES[feature]
    unit = on_axis(unit, 'prismatic' if gearbox['unit'] == 'm' else 'rotary')
    return [Panel(f'{noun} ({unit})', traces, limits=limits,
                  height=150 if feature == gearbox['feature'] else 90)]


def _table(gearboxes: Sequence[Gearbox]) -> Section:
    """Return all gearboxes, and those that were never measured with the reason."""
    rows = []
    for gearbox in gearboxes:
        width = gearbox['features'][gearbox['feature']]
        pace = '' if not width['rate'] else \
            f'{percent(width["rate"] * YEAR, width["rate_std"] * YEAR):+}'
        feature = 'lost motion ' if gearbox['feature'] != 'gap' else ''
        rows.append([
            gearbox['gearbox'], feature + width_text(gearbox),
            *(growth_text(gearbox['features'][name]) for name in (
                gearbox['feature'], 'stiffness', 'friction')),
            gearbox['trust'], gearbox['model_level'],
            f'{len(gearbox["points"])} of {gearbox["bags"]}', pace, _days(gearbox)])
    return Section('fleet/table.html', {
        'gearboxes': PageTable((
            'gearbox', 'newest backlash', 'growth', 'stiffness', 'friction', 'trust', 'model',
            'measured in bags', 'per year', 'recorded'), rows),
        'unmeasured': PageTable(('never measured', 'missing in the newest bag'), [
            (gearbox['gearbox'], gearbox['not_excited']) for gearbox in gearboxes
            if gearbox['not_excited']])}, 'All gearboxes', folded=True)


def _days(box: Gearbox | Joint) -> str:
    """Return from when to when a gearbox or joint was recorded."""
    return f'{day(box["first"])} to {day(box["last"])}'


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
        if bag['status'] == 'done' and bag['notes']:
            note = bag['notes'].replace(bag['path'] + ': ', '')
            paths_by_note.setdefault(note, []).append(bag['path'])
    return [(paths[0] + (f' and {len(paths) - 1} more' if paths[1:] else ''), 'note', note)
            for note, paths in paths_by_note.items()]
