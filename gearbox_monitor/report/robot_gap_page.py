# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot's gap: its joints with the worst first, the findings, the next steps."""
from collections.abc import Mapping
from typing import Any, TypeAlias

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section, verdict_numbers)
from gearbox_monitor.report.chart import BarRow, Bars
from gearbox_monitor.report.robot_words import (
    axes_of, finding_words, MEANINGS, next_steps, remainder_words, size_unit)
from gearbox_monitor.report.sketch import Dot, sketch
from gearbox_monitor.report.words import sentence
from gearbox_monitor.robot.chain import Chain

VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a robot's verdict
ROLES = {'none': 'good', 'effect': '', 'incomplete': 'warn', 'unknown': 'warn',
         'undecided': 'warn'}


def robot_gap_page(data: VerdictData, chain: Chain, posture: Array) -> str:
    """
    Return the page of a robot's verdict as HTML.

    Args:
        data: the verdict as plain data.
        chain: the robot.
        posture: usual positions [J].

    Returns:
        One file that loads nothing.
    """
    return render_page(Page(
        f'The gap of {", ".join(data["logs"])}', _summary(data), (
            advice([sentence(step) for step in next_steps(data)]),
            _picture(data, chain, posture), _findings(data), _gaps(data), _visible(data),
            verdict_numbers(data))))


def _summary(data: VerdictData) -> Section:
    """Return the verdict in one line, and the main figures."""
    highest = data['ranked'][0]
    unit = on_axis('N m', axes_of(data)[highest['joint']])
    facts = [('verdict', data['verdict']), ('worst joint', highest['joint']),
             ('its gap before', f'{highest["before"]:.3g} {unit} rms'),
             ('after', f'{highest["after"]:.3g} {unit} rms'),
             ('compared with', ', '.join(data['references']) or data['model'])]
    return page_summary(ROLES[data['verdict']], data['summary'], facts,
                        [f'{x}.' for x in (*data['cautions'], *data['warnings'])])


def _picture(data: VerdictData, chain: Chain, posture: Array) -> Section:
    """Return the robot from its side: a dot per joint as large as its gap, the worst first."""
    joint_of = {link.name: link.joint for link in chain.links}
    hit = {f.get('joint') or joint_of.get(f.get('link') or '', '') for f in data['findings']}
    gaps = {r['joint'] for r in data['remainders']}
    highest = max((g['before'] / (g['effort'] + 1e-9) for g in data['ranked']), default=1.0)
    dots, axes = {}, axes_of(data)
    for rank, gap in enumerate(data['ranked'], 1):
        joint = gap['joint']
        share = gap['before'] / (gap['effort'] + 1e-9) / max(highest, 1e-9)
        dots[joint] = Dot(
            f'{rank}. {joint} {gap["before"]:.2g} {on_axis("N m", axes[joint])}',
            role='hit' if joint in hit else 'lost' if joint in gaps else 'calm',
            r=4.0 + 7.0 * share)
    return Section('robot_gap/picture.html', sketch(chain, posture, dots), 'Where')


def _findings(data: VerdictData) -> Section:
    """Return the findings, one line each, and the remainders."""
    axes = axes_of(data)
    rows = [(finding_words(f, axes), f['effect'], f'{100 * (f["share"] or 0.0):.0f} %',
             f'{f["evidence"]:.0f}', ', '.join(f['confusable']) or '-')
            for f in data['findings']]
    header = ('finding', 'effect', 'share', 'evidence', 'indistinguishable from')
    return Section('robot_gap/findings.html', {
        'rows': PageTable(header, rows, (2, 3)),
        'remains': [f'{remainder_words(r, axes)}.' for r in data['remainders']],
        'meanings': [f'{f["effect"]}: {MEANINGS[f["effect"]]}.' for f in data['findings']
                     if f['effect'] in MEANINGS]}, 'Findings')


def _gaps(data: VerdictData) -> Section:
    """Return how far the file is off at each joint, as it was and with the findings."""
    rows, axes = [], axes_of(data)
    runs = (data.get('rollouts') or {}).get('joints') or {}
    for gap in data['ranked']:
        joint, rotary = gap['joint'], axes[gap['joint']] == 'rotary'
        sizes, unit = gap, 'N m' if rotary else 'N'
        if joint in runs:
            sizes, unit = {k: 1e3 * v for k, v in runs[joint].items()}, 'mrad' if rotary else 'mm'
        for title, when, kind in ((joint, 'before', 'nominal'), ('', 'after', 'closed')):
            rows.append(BarRow(title, when, sizes[when], f'{sizes[when]:.3g} {unit}', kind))
    return Section('robot_gap/gaps.html', {
        'gaps': Bars(rows), 'runs': bool(runs), 'lacking': data.get('lacking') or []},
        'The gap of each joint')


def _visible(data: VerdictData) -> Section:
    """Return the smallest size of each effect that this motion would have shown."""
    rows, axes = [], axes_of(data)
    for effect, places in data['visible'].items():
        if places:
            low, high = min(places, key=places.get), max(places, key=places.get)
            ends = [(f'{places[place]:.2g} '
                     f'{size_unit(effect, axes.get(place, "rotary"))}', place)
                    for place in (low, high)]
            rows.append((MEANINGS.get(effect, effect), *ends[0], *ends[1]))
    return Section('robot_gap/visible.html', {
        'rows': PageTable(('effect', 'visible from', 'at', 'elsewhere up to', 'at'), rows),
        'untried': data['not_tried'].items()}, 'Smallest visible sizes', folded=True)
