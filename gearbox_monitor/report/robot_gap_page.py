# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot's gap: its joints with the worst first, the findings, the next steps."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section, verdict_numbers)
from gearbox_monitor.report.chart import BarRow, Bars
from gearbox_monitor.report.robot_words import (
    axes_of, finding_words, MEANINGS, next_steps, remainder_words, size_unit)
from gearbox_monitor.report.words import sentence
from gearbox_monitor.robot.chain import Chain
from gearbox_monitor.robot.description import rotations

VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a robot's verdict
WIDTH, HEIGHT, MARGIN = 460.0, 300.0, 46.0
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


@dataclass(frozen=True)
class Dot:
    """A joint in the picture: place in px, radius, role, name, words, rank."""

    x: float
    y: float
    r: float
    role: str
    name: str
    words: str
    rank: int
    text_left: bool


def _picture(data: VerdictData, chain: Chain, posture: Array) -> Section:
    """Return the robot from its side: a line per link, a dot per joint as large as its gap."""
    places = joint_places(chain, posture)
    flat = places - places.mean(axis=0)
    turned = np.arctan2(*np.linalg.svd(flat[:, :2], full_matrices=False)[2][0][::-1])
    across = flat[:, 0] * np.cos(turned) + flat[:, 1] * np.sin(turned)
    points = np.column_stack([across, -flat[:, 2]])
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    scale = float(min((WIDTH - 2 * MARGIN) / max(size[0], 1e-3),
                      (HEIGHT - 2 * MARGIN) / max(size[1], 1e-3), 600.0))
    shift = np.array([WIDTH, HEIGHT]) / 2 - scale * (low + size / 2)
    xy = points * scale + shift
    lines = [(*xy[link.parent + 1], *xy[i + 1]) for i, link in enumerate(chain.links)]
    place_of = {link.joint: i for i, link in enumerate(chain.links)}
    joint_of = {link.name: link.joint for link in chain.links}
    hit = {f.get('joint') or joint_of.get(f.get('link') or '', '') for f in data['findings']}
    gaps = {r['joint'] for r in data['remainders']}
    highest = max((g['before'] / (g['effort'] + 1e-9) for g in data['ranked']), default=1.0)
    dots, axes = [], axes_of(data)
    for rank, gap in enumerate(data['ranked'], 1):
        x, y = xy[place_of[gap['joint']] + 1]
        share = gap['before'] / (gap['effort'] + 1e-9) / max(highest, 1e-9)
        role = 'hit' if gap['joint'] in hit else 'lost' if gap['joint'] in gaps else 'calm'
        dots.append(Dot(float(x), float(y), 4.0 + 7.0 * share, role, gap['joint'],
                        f'{gap["before"]:.2g} {on_axis("N m", axes[gap["joint"]])}', rank,
                        bool(x > 0.6 * WIDTH)))
    return Section('robot_gap/picture.html', {'lines': lines, 'dots': apart(dots)}, 'Where')


def apart(dots: Sequence[Dot]) -> list[Dot]:
    """Return `dots` without overlap: one that covers another moves down."""
    out: list[Dot] = []
    for dot in dots:
        while any(abs(dot.y - d.y) < 15.0 and abs(dot.x - d.x) < 110.0 for d in out):
            dot = replace(dot, y=dot.y + 5.0)
        out.append(dot)
    return out


def joint_places(chain: Chain, posture: Array) -> Array:
    """Return places [J + 1, 3] m of base and joints of `chain` at positions `posture` [J]."""
    turns: list[Array] = []
    places: list[Array] = []
    for i, link in enumerate(chain.links):
        turn = turns[link.parent] if link.parent >= 0 else np.eye(3)
        at = places[link.parent] if link.parent >= 0 else np.zeros(3)
        place, turn = at + turn @ link.origin, turn @ link.rotation
        q = float(posture[i] - np.broadcast_to(chain.zero, len(chain.links))[i])
        if link.slides:
            place = place + turn @ link.axis * q
        else:
            turn = turn @ rotations(link.axis, np.array([q]))[0]
        turns.append(turn)
        places.append(place)
    return np.vstack([np.zeros(3), *places])


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
