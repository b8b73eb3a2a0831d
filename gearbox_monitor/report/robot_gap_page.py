# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a robot's gap: its joints with the worst first, the findings, the next steps."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from gearbox_monitor.diagnosis.robot.verdict import EffortCurves
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import number, on_axis, percent, Quantity
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section, verdict_numbers)
from gearbox_monitor.report.chart import BarRow, Bars, Chart, Panel, Trace
from gearbox_monitor.report.robot_words import (
    axes_of, finding_words, MEANINGS, next_steps, remainder_words, size_unit, SUBJECTS, unit_of)
from gearbox_monitor.report.svg import Dot, sketch
from gearbox_monitor.report.words import sentence
from gearbox_monitor.robot.chain import Chain

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
