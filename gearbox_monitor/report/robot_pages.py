# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The pages of a whole robot: that of its sim-to-real gap, and that of its watch.

The page of the gap shows the joints with the worst first, the findings and the next steps. That of
a watch shows the answer, the robot with what was found at its joints, states and changes, from the
data of watch_data and the description, live and offline alike.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.robot.verdict import EffortCurves
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import number, on_axis, percent, Quantity
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, render_section, Section, verdict_numbers)
from gearbox_monitor.report.chart import BarRow, Bars, Chart, Dot, Lane, Panel, sketch, Trace, View
from gearbox_monitor.report.robot_words import (
    axes_of, finding_words, MEANINGS, next_steps, NO_CHANGE, NOT_JUDGED, problem_words,
    remainder_words, services_words, since_words, size_unit, STATE_TITLES, SUBJECTS, unit_of)
from gearbox_monitor.report.timeline import LEVELS
from gearbox_monitor.report.words import sentence
from gearbox_monitor.robot.chain import Chain, chain_of
from gearbox_monitor.robot.description import parse
from gearbox_monitor.watch.record import SECOND

VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a robot's verdict
LISTED = 40  # lines of a difference; longer ones are folded
ROLES = {'none': 'good', 'effect': '', 'incomplete': 'warn', 'unknown': 'warn',
         'undecided': 'warn'}


@dataclass(frozen=True, eq=False)
class RobotContext:
    """
    What accompanies a verdict on its page.

    chain: the robot; posture: usual positions [J], rad or m; curves: of the joint that changes the
    motion most; changes: lines of the difference between the user's file and the closed one.
    """

    chain: Chain
    posture: Array
    curves: EffortCurves
    changes: Sequence[str]


def robot_gap_page(data: VerdictData, context: RobotContext) -> str:
    """
    Return the page of a robot's verdict as HTML.

    Args:
        data: the verdict as plain data.
        context: what accompanies it.

    Returns:
        One file that loads nothing.
    """
    return render_page(Page(
        f'The gap of {", ".join(data["logs"])}', _summary(data), (
            advice([sentence(step) for step in next_steps(data)]), _picture(data, context),
            _gaps(data), _curves(context.curves), _findings(data), _changes(context.changes),
            _visible(data), verdict_numbers(data))))


def _summary(data: VerdictData) -> Section:
    """Return the verdict in one line, and the main figures."""
    of_servos = data.get('servos') and {f['place'] for f in data['findings']} == {'controller'}
    highest = (data['servos'] if of_servos else by_effect(data))[0]
    unit = on_axis('N m', axes_of(data)[highest['joint']])
    facts = [('worst joint', highest['joint']),
             ('its gap before', f'{number(highest["before"], unit)} rms'),
             ('after', f'{number(highest["after"], unit)} rms'),
             ('compared with', ', '.join(data['references']) or data['model'])]
    return page_summary(ROLES[data['verdict']], data['summary'], facts,
                        [f'{x}.' for x in (*data['cautions'], *data['warnings'])])


def _picture(data: VerdictData, context: RobotContext) -> Section:
    """Return the robot from its side: a dot per joint as large as its gap, with findings."""
    joint_of = {link.name: link.joint for link in context.chain.links}
    axes, said = axes_of(data), dict[str, list[str]]()
    for f in data['findings']:
        joint = f.get('joint') or joint_of.get(f.get('link') or '', '')
        said.setdefault(joint, []).append(finding_label(f, axes))
    gaps = {r['joint'] for r in data['remainders']}
    highest = max(map(_share, data['ranked']), default=1.0)
    dots = {}
    for gap in sorted(by_effect(data), key=lambda gap: gap['joint'] not in said):
        joint = gap['joint']
        share = _share(gap) / max(highest, 1e-9)
        role = 'hit' if joint in said else 'lost' if joint in gaps else 'calm'
        dots[joint] = Dot(joint, said.get(joint, ()), role, 4.0 + 7.0 * share)
    return Section('robot_gap/picture.html', sketch(context.chain, context.posture, dots), 'Where')


def finding_label(finding: Mapping[str, Any], axes: Mapping[str, str]) -> str:
    """Return the size of a `finding` for a sketch, as "+2.0 kg"; `axes`: of the joints."""
    effect, values = finding['effect'], finding['values']
    name = 'm' if 'm' in values else SUBJECTS.get(effect, (next(iter(values)), ''))[0]
    if effect in ('payload', 'base_tilt', 'link_inertia') and 'm' not in values:
        return effect.replace('_', ' ')
    is_factor = name.endswith('_factor')
    size, _ = Quantity(values[name], finding['deviations'].get(name)).digits('+' * (not is_factor))
    unit = 'kg' if name == 'm' else unit_of(effect, name, axes.get(
        finding.get('joint') or '', 'rotary'))
    return f'\u00d7 {size}' if is_factor else f'{size} {unit}'.strip()


def by_effect(data: VerdictData) -> list[Mapping[str, Any]]:
    """Return the gaps of the joints, those that change the motion most first."""
    runs = (data.get('rollouts') or {}).get('joints') or {}
    return sorted(data['ranked'], reverse=True, key=lambda gap: (
        runs[gap['joint']]['before'] if gap['joint'] in runs else _share(gap)))


def _share(gap: Mapping[str, Any]) -> float:
    """Return the `gap` of a joint as a share of its torque."""
    return float(gap['before'] / (gap['effort'] + 1e-9))


def _curves(curves: EffortCurves) -> Section:
    """Return the effort of the worst joint, recorded and by both models."""
    unit, t = on_axis('N m', curves.axis), curves.t
    chart = Chart(f'{curves.joint}, before and after', [
        Panel(f'effort ({unit})', [
            Trace(t, curves.recorded, 'recording', 'recording'),
            Trace(t, curves.recorded - curves.before, 'model', 'nominal'),
            Trace(t, curves.recorded - curves.after, 'with the findings', 'closed')]),
        Panel(f'recording - model ({unit})', [
            Trace(t, curves.before, 'model', 'nominal'),
            Trace(t, curves.after, 'with the findings', 'closed')], 0.0, 110)], 'time (s)')
    return Section('recording/chart.html', {'chart': chart}, 'The worst joint')


def _changes(lines: Sequence[str]) -> Section:
    """Return what the findings change in the user's file, as `lines` of a difference."""
    return Section('robot_gap/changes.html', {
        'lines': [(line, {'+': 'added', '-': 'removed'}.get(line[:1], '')) for line in lines]},
        'The file', folded=len(lines) > LISTED)


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
    for gap in by_effect(data):
        joint, rotary = gap['joint'], axes[gap['joint']] == 'rotary'
        sizes, unit = gap, 'N m' if rotary else 'N'
        share = f', {percent(_share(gap))} of its {on_axis("torque", axes[joint])}'
        if joint in runs:
            sizes, unit = {k: 1e3 * v for k, v in runs[joint].items()}, 'mrad' if rotary else 'mm'
            share = ''
        rows += [BarRow(joint, f'before{share}', sizes['before'], number(sizes['before'], unit),
                        'nominal'),
                 BarRow('', 'after', sizes['after'], number(sizes['after'], unit), 'closed')]
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


WatchData = Mapping[str, Any]   # of watch_data
SOURCE = 'robot_description'
LEVEL_ROLES = {None: '', 0: 'good', 1: 'warn', 2: 'error'}
LANES, NOTES = 3, 3             # changes over time, sentences below the answer
NAMED, LONG = 12, 9             # joints up to which the sketch names each; letters of a long name
SHORTEST = 600.0                # s that the time line shows
UNITS = ((3 * 86400.0, 86400.0, 'd'), (3 * 3600.0, 3600.0, 'h'), (0.0, 60.0, 'min'))


def watch_page(data: WatchData, description: str, title: str) -> str:
    """
    Return the page of a watch as HTML, one file that loads nothing.

    Args:
        data: of watch_data.
        description: URDF of the robot.
        title: of the page.
    """
    return render_page(Page(title, _whole(data, description, 'watch', ''), ()))


def watch_part(data: WatchData, description: str, node: str, problem: str = '') -> str:
    """
    Return the same as a part of the live page.

    Args:
        data: of watch_data; empty before any came.
        description: URDF of the robot.
        node: name of the node that watches.
        problem: of its stream, in words; what is shown is old then.
    """
    return render_section(_whole(data, description, node, problem), 'rotary')


def _whole(data: WatchData, description: str, node: str, problem: str) -> Section:
    """Return the answer in words, then sketch, table and time line."""
    if problem or not data:
        kind, headline = 'warn', problem_words(problem)
    else:
        kind, headline = LEVEL_ROLES[data['level']], data['summary']
    whole = {'kind': kind, 'headline': headline, 'notes': (), 'rows': (), 'old': bool(problem)}
    if not data:
        return Section('watch.html', whole)
    held = [p['words'] for p in data['payloads'] if p['label']]
    notes = [f'{words}.' for words in (*held, *data['readings'], *data['cautions'])][:NOTES]
    return Section('watch.html', {
        **whole, 'notes': notes, 'sketch': _sketch(data, description),
        'titles': STATE_TITLES.values(), 'rows': [_row(data, name) for name in data['joints']],
        'long': max(map(len, data['joints']), default=0) > LONG, 'changes': _over_time(data),
        'no_change': NO_CHANGE, 'services': services_words(node)})


# --- sketch -------------------------------------------------------------------------------------
def _sketch(data: WatchData, description: str) -> View | None:
    """Return the robot with what was found at its joints; None: there is no description."""
    try:
        chain = chain_of(parse(description, SOURCE))
    except InputError:
        return None
    posture = np.array([(data['joints'].get(link.joint) or {}).get('position') or 0.0
                        for link in chain.links])
    marks = _marks(data, chain)
    names = sorted((link.joint for link in chain.links), key=lambda name: name not in marks)
    return sketch(chain, posture, {
        name: marks.get(name) or Dot(name, needed=False)
        for name in (names if len(names) <= NAMED else marks)})


def _marks(data: WatchData, chain: Chain) -> dict[str, Dot]:
    """Return {joint: its dot} of those at which something is found or held."""
    joint_of = {link.name: link.joint for link in chain.links}
    out = dict[str, Dot]()
    for found in data['findings']:
        joint = found['joint'] or chain.links[0].joint      # the base carries the first one
        before = out.get(joint, Dot(joint, role='hit', r=8.0))
        out[joint] = replace(before, lines=(*before.lines, found['label']))
    for load in data['payloads']:
        joint = joint_of.get(load['link'], '')
        if joint and load['label']:
            before = out.get(joint, Dot(joint, role='held', r=8.0))
            out[joint] = replace(before, lines=(*before.lines, load['label']))
    return out


# --- table --------------------------------------------------------------------------------------
def _row(data: WatchData, name: str) -> dict[str, Any]:
    """Return the row of the joint `name`: level, states in words, what is found, or why not."""
    joint = data['joints'][name]
    found = [f for f in data['findings'] if f['joint'] == name]
    bad = {f['state']: f['share'] for f in found}
    states = {kind: state['words'] for kind, state in joint['states'].items() if state['judged']}
    states |= bad
    cells = [('warn' if kind in bad else '', states.get(kind, '-').removesuffix(' %'))
             for kind in STATE_TITLES]
    level = joint['level']
    return {
        'name': name, 'level': '' if level is None else LEVELS[level], 'kind': LEVEL_ROLES[level],
        'cells': cells, 'found': '; '.join(
            since_words(f['label'], f['since_ns']) for f in found),
        'why': f'{NOT_JUDGED}: {joint["words"]}' if level is None else ''}


# --- changes over time --------------------------------------------------------------------------
def _over_time(data: WatchData) -> Chart | None:
    """Return what changed over time, as lanes, and what was held, as curves; None: nothing."""
    now, changes = data['stamp_ns'], data['changes'][-LANES:]
    loads = [*data['earlier'], *data['payloads']]
    links = [link for link in dict.fromkeys(p['link'] for p in loads)
             if any(p['label'] for p in loads if p['link'] == link)]
    if not changes and not links:
        return None
    begins = [c['since_ns'] for c in (*changes, *(p for p in loads if p['link'] in links))]
    span = max((now - min(begins)) / SECOND * 1.05, SHORTEST)
    _, unit, name = next(u for u in UNITS if span >= u[0])

    def before(stamp_ns: int) -> float:
        """Return the time of a stamp before the newest block."""
        return (stamp_ns - now) / SECOND / unit
    panels: list[Panel | Lane] = [Lane(
        f'{c["joint"] or c["link"]}: {c["label"]}',
        [-span / unit, before(c['since_ns']), *([before(c['over_ns'])] if c['over_ns'] else [])],
        0.0, [0, 1, 0][:3 if c['over_ns'] else 2], [c['words']] * 3) for c in changes]
    for link in links:
        own = [p for p in loads if p['link'] == link]
        edges = np.array([*(before(p['since_ns']) for p in own), 0.0])
        mass, std = (np.array([*(p[key] for p in own), own[-1][key]]) for key in ('m', 'm_std'))
        panels.append(Panel(f'{link} (kg)', [_held(edges, mass, std)], 0.0, 56))
    return Chart('Changes', panels, f'time before the newest block ({name})',
                 span=(-span / unit, 0.0), zoom=False)


def _held(edges: Array, mass: Array, std: Array) -> Trace:
    """Return a curve that keeps each mass until the next edge, with two deviations."""
    return Trace(np.repeat(edges, 2)[1:], np.repeat(mass, 2)[:-1], '', 'closed').around(
        np.repeat(std, 2)[:-1])
