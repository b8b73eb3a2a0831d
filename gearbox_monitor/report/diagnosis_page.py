# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The page of a diagnosis, of a drive and of a robot: the answer, what to do, the evidence.

Sections that a verdict has no data for are left out: a drive has no sketch, a robot no ranking.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import re
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.diagnosis.joint.windows import Overlay, overlay
from gearbox_monitor.diagnosis.robot.verdict import EffortCurves
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.presentation import number, on_axis, percent, Quantity
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section, verdict_numbers)
from gearbox_monitor.report.chart import BarRow, Bars, Chart, Dot, Panel, sketch, Trace
from gearbox_monitor.report.words import (
    axis_of, finding_words, gain_text, ids_of, meaning, MEANINGS, next_steps, NOTHING,
    reading_unit, remainder_words, sentence, size_unit, subject_of, torque_map_of, unit_of,
    unstated_in, value_rows, VerdictData)
from gearbox_monitor.robot.chain import Chain
from gearbox_monitor.signals.uniform import UniformRecording

RUN_ROLES = ('nominal', 'closed')  # of curves, in the order of the runs
RANKED = 10
NOISE_RANGE = (0.9, 1.5)  # gaps that are always in view: noise must not look large
LISTED = 40  # lines of a difference; longer ones are folded
ROLES = {'none': 'good', 'effect': ''}  # others warn


@dataclass(frozen=True, eq=False)
class DiagnosisContext:
    """
    What accompanies a verdict on its page.

    charts: (words, recording and models over each other). recordings: (name, s, samples/s) of
    each. chain, posture: of a robot, and its usual positions [J], rad or m.
    """

    charts: Sequence[tuple[str, Chart]]
    recordings: Sequence[tuple[str, float, float]]
    chain: Chain | None = None
    posture: Array | None = None


def context_of(verdict: Verdict, model: DriveModel) -> DiagnosisContext:
    """
    Return what accompanies a verdict on a drive, of the recording with the largest gap.

    Args:
        verdict: of the search.
        model: the nominal model.
    """
    data = verdict.basis.data
    models = {'nominal model': model}
    if verdict.model != model:
        models[closed_name(verdict, model)] = verdict.model
    laid = overlay(data.recordings[verdict.basis.widest], models, data.level)
    charts = [(words, window_chart(laid, words, window, model.axis))
              for words, window in notable_windows(laid)]
    return DiagnosisContext(
        [*charts, ('whole recording, one run', whole_chart(laid, model.axis))],
        [(_short(r), r.duration, 1.0 / r.dt) for r in data.recordings])


def _short(recording: UniformRecording) -> str:
    """Return the name of `recording` without its folders."""
    return re.split(r'[\\/]', recording.name)[-1]


# ---------------------------------------------------------------------- models over a recording


def smoothed(residual: Array, dt: float, seconds: float = 0.02) -> Array:
    """
    Return the moving mean [N] of a residual [N] over `seconds`, which removes most of the noise.

    Args:
        residual: residual of one encoder [N].
        dt: sample time, s.
        seconds: length of the moving mean, s.
    """
    width = max(1, min(round(seconds / dt), len(residual)))
    ones = np.ones(width)
    return np.convolve(residual, ones, 'same') / np.convolve(np.ones(len(residual)), ones, 'same')


def clipped_to_range(y: Array, measured: Array) -> Array:
    """Return y [N], NaN where it is far off all that was measured [N]: fit to be drawn."""
    low, high = float(measured.min()), float(measured.max())
    with np.errstate(invalid='ignore'):
        return np.where(np.abs(y - 0.5 * (low + high)) < 2.0 * (high - low), y, np.nan)


def closed_name(verdict: Verdict, model: DriveModel) -> str:
    """Return the name of the model that closes the gap between a recording and `model`."""
    if verdict.verdict == 'effect':
        return f'with {verdict.effect}'
    closing = ['a torque map' if effect['id'] == TORQUE_MAP.id else str(effect['id'])
               for effect in verdict.model.effects if effect not in model.effects]
    return f'with {" and ".join(closing) or "estimated values"}'


def notable_windows(laid: Overlay) -> tuple[tuple[str, int], ...]:
    """Return (words, window) of the typical and the worst window of `laid`."""
    windows = np.arange(len(laid.windows))
    order = windows[np.argsort(laid.runs[0].chi2[windows])]
    typical, highest = int(order[(len(order) - 1) // 2]), int(order[-1])
    if typical == highest:
        return (('window', typical),)
    return ('typical window', typical), ('worst window', highest)


# ---------------------------------------------------------------------- models over a recording


def window_chart(overlay: Overlay, words: str, window: int, axis: str) -> Chart:
    """
    Return recording and models over each other in one window, residuals below.

    Args:
        overlay: models over the recording.
        words: name of the window.
        window: its number.
        axis: of the drive, for units.

    """
    t, panels = overlay.t[window], []
    for channel in overlay.channels:
        measured = overlay.measured[window, :, channel]
        readings = [Trace(t, measured, 'recording', 'recording')]
        residual = []
        for run, role in zip(overlay.runs, RUN_ROLES):
            y = run.y[window, :, channel]
            readings.append(Trace(t, y, run.name, role))
            residual += [Trace(t, measured - y, '', f'{role} faint'),
                         Trace(t, smoothed(measured - y, overlay.recording.dt), run.name,
                               f'{role} firm')]
        panels += _channel_panels(overlay.recording.readings[channel], readings, residual, axis)
    return Chart(f'{words.capitalize()}: {t[0]:.0f} to {t[-1]:.0f} s', panels, 'time (s)')


def whole_chart(overlay: Overlay, axis: str) -> Chart:
    """Return one free run of each model of `overlay` over the whole recording, by `axis`."""
    t, panels = overlay.recording.begin + overlay.recording.t, []
    for channel in overlay.channels:
        measured = overlay.recording.y[:, channel]
        readings = [Trace(t, measured, 'recording', 'recording')]
        readings += [Trace(t, clipped_to_range(run.free[:, channel], measured), run.name, role)
                     for run, role in zip(overlay.runs, RUN_ROLES)]
        residual = [Trace(t, measured - trace.y, trace.name, f'{trace.role} firm')
                    for trace in readings[1:]]
        panels += _channel_panels(overlay.recording.readings[channel], readings, residual, axis)
    return Chart('One free run over the whole recording, from the state of its first window; '
                 'errors add up', panels, 'time (s)')


def _channel_panels(name: str, readings: Sequence[Trace], residual: Sequence[Trace],
                    axis: str) -> list[Panel]:
    """Return the panels of one encoder: its readings and, below, the residual."""
    unit = reading_unit(name, 'rotary')
    quantity = f'{name}, angle' if unit == 'rad' else name
    return [Panel(on_axis(f'{quantity} ({unit})', axis), readings),
            Panel(on_axis(f'{name}, recording - model ({unit})', axis), residual, 0.0, 110)]


def effort_chart(curves: EffortCurves) -> Chart:
    """Return the chart of the `curves` of a joint: effort, recorded and by both models."""
    unit, t = on_axis('N m', curves.axis), curves.t
    return Chart(f'{curves.joint}, before and after', [
        Panel(f'effort ({unit})', [
            Trace(t, curves.recorded, 'recording', 'recording'),
            Trace(t, curves.recorded - curves.before, 'model', 'nominal'),
            Trace(t, curves.recorded - curves.after, 'with the findings', 'closed')]),
        Panel(f'recording - model ({unit})', [
            Trace(t, curves.before, 'model', 'nominal'),
            Trace(t, curves.after, 'with the findings', 'closed')], 0.0, 110)], 'time (s)')


# ---------------------------------------------------------------------- page


def diagnosis_page(data: VerdictData, context: DiagnosisContext) -> str:
    """
    Return the page of a diagnosis as HTML, one file that loads nothing.

    Args:
        data: the verdict as plain data.
        context: what accompanies it.
    """
    names = ', '.join(Path(name).name for name in data['logs'])
    sections = (advice([sentence(step) for step in next_steps(data)]), _picture(data, context),
                _gaps(data), Section('diagnosis/charts.html', {
                    'charts': context.charts, 'windows': 'axis' in data}, 'Before and after'),
                _findings(data), _values(data), _changes(data), _ranking(data), _visible(data),
                _doubts(data, context), verdict_numbers(data))
    return render_page(Page(f'Diagnosis of {names}', _summary(data), [
        section for section in sections if section is not None], axis_of(data)))


def _summary(data: VerdictData) -> Section:
    """Return the verdict in words, the main figures, and what the effects are."""
    if 'axis' in data:
        facts = [('gap before', number(data['gap_before']))]
        if data['verdict'] not in NOTHING:
            closed = data['closed_fraction']
            facts += [('gap after', number(data['gap_after'])),
                      ('closed', 'not defined' if closed is None else str(percent(closed)))]
    else:
        highest = (data['servos'] if data['servos'] and {
            f['place'] for f in data['findings']} == {'controller'} else by_effect(data))[0]
        unit = on_axis('N m', axis_of(data, highest['joint']))
        facts = [('worst joint', highest['joint']),
                 ('its gap before', f'{number(highest["before"], unit)} rms'),
                 ('after', f'{number(highest["after"], unit)} rms')]
    facts.append(('compared with', ', '.join(data.get('references') or [data['model']])))
    names = dict.fromkeys(f['effect'] for f in data['findings'])
    return page_summary(ROLES.get(data['verdict'], 'warn'), data['summary'], facts, [
        f'{name}: {meaning(name, axis_of(data))}.' for name in names if name in MEANINGS])


def _picture(data: VerdictData, context: DiagnosisContext) -> Section | None:
    """Return the robot from its side: a dot per joint as large as its gap, with findings."""
    if context.chain is None or context.posture is None:
        return None
    joint_of = {link.name: link.joint for link in context.chain.links}
    said, unstated = dict[str, list[str]](), unstated_in(data)
    for f in data['findings']:
        joint = f.get('joint') or joint_of.get(f.get('link') or '', '')
        said.setdefault(joint, []).extend([] if f in unstated else [finding_label(f, data)])
    gaps = {r['joint'] for r in data['remainders']}
    highest = max(map(_share, data['gaps']), default=1.0)
    dots = {}
    for gap in sorted(by_effect(data), key=lambda gap: gap['joint'] not in said):
        joint = gap['joint']
        share = _share(gap) / max(highest, 1e-9)
        role = 'hit' if joint in said else 'lost' if joint in gaps else 'calm'
        dots[joint] = Dot(joint, said.get(joint, ()), role, 4.0 + 7.0 * share)
    return Section('diagnosis/picture.html', sketch(context.chain, context.posture, dots), 'Where')


def finding_label(finding: Mapping[str, Any], data: VerdictData) -> str:
    """Return the size of a `finding` of the verdict `data` for a sketch, as "+2.0 kg"."""
    effect, values = finding['effect'], finding['values']
    name = 'm' if 'm' in values else subject_of(effect, values)[0]
    if effect in ('payload', 'base_tilt', 'link_inertia') and 'm' not in values:
        return effect.replace('_', ' ')
    is_factor = name.endswith('_factor')
    size, _ = Quantity(values[name], finding['deviations'].get(name)).digits('+' * (not is_factor))
    unit = 'kg' if name == 'm' else unit_of(effect, name, axis_of(data, finding.get('joint')))
    return f'\u00d7 {size}' if is_factor else f'{size} {unit}'.strip()


def by_effect(data: VerdictData) -> list[Mapping[str, Any]]:
    """Return the gaps of joints in a verdict `data`, those that change the motion most first."""
    runs = (data.get('rollouts') or {}).get('joints') or {}
    return sorted(data['gaps'], reverse=True, key=lambda gap: (
        runs[gap['joint']]['before'] if gap['joint'] in runs else _share(gap)))


def _share(gap: Mapping[str, Any]) -> float:
    """Return the `gap` of a joint as a share of its torque."""
    return float(gap['before'] / (gap['effort'] + 1e-9))


def _gaps(data: VerdictData) -> Section:
    """Return the gap before and after, as bars, with the share that is closed."""
    is_drive, runs = 'axis' in data, (data.get('rollouts') or {}).get('joints') or {}
    gaps = []
    for name, note, before, after, unit, closed in (
            _gaps_of_readings(data) if is_drive else _gaps_of_joints(data, runs)):
        gaps.append(BarRow(name, f'before{note}', before, number(before, unit), 'nominal'))
        if not is_drive or data['verdict'] not in NOTHING:
            gaps.append(BarRow('', f'after{closed}', after, number(after, unit), 'closed'))
    top = max([NOISE_RANGE[1], *(row.value for row in gaps if row.value is not None)])
    return Section('diagnosis/gap.html', {
        'is_drive': is_drive, 'runs': bool(runs),
        'gaps': Bars(gaps, True, top) if is_drive else Bars(gaps)}, 'The gap')


# Name, note, gap before and after, their unit, words on the closed share.
GapPart = tuple[str, str, float, float, str, str]


def _gaps_of_readings(data: VerdictData) -> list[GapPart]:
    """Return the gap of a drive in all and of each reading, in multiples of the noise."""
    names, low_high = [gap['reading'] for gap in data['gaps']], data['closed_fraction_ci']
    parts: list[GapPart] = [
        (' and '.join(names) or 'all', '', data['gap_before'], data['gap_after'], '',
         _closed(data['closed_fraction']) + (
             f' ({percent(low_high[0])} to {percent(low_high[1])})' if low_high else ''))]
    for gap in data['gaps'] if len(names) > 1 else ():
        name = gap['reading']
        parts.append((name if name == 'torque' else f'{name} encoder', '', gap['before'],
                      gap['after'], '', _closed(gap['closed'])))
    theirs, validation = data.get('simulator'), data.get('validation')
    for name, part in ((validation and f'validation, {validation["recording"]}', validation),
                       (theirs and f'in {theirs["name"]}', theirs)):
        if part:
            parts.append((str(name), '', part['gap_before'], part['gap_after'], '',
                          _closed(part['closed_fraction'])))
    return parts


def _closed(share: float | None) -> str:
    return '' if share is None else f', {percent(share)} closed'


def _gaps_of_joints(data: VerdictData, runs: Mapping[str, Any]) -> list[GapPart]:
    """Return the gap of each joint of a robot, of torque or, where there are any, of free runs."""
    parts: list[GapPart] = []
    for gap in by_effect(data):
        joint, axis = gap['joint'], axis_of(data, gap['joint'])
        if joint in runs:
            before, after = (1e3 * runs[joint][key] for key in ('before', 'after'))
            parts.append((joint, '', before, after, on_axis('mrad', axis), ''))
        else:
            note = f', {percent(_share(gap))} of its {on_axis("torque", axis)}'
            parts.append((joint, note, gap['before'], gap['after'], on_axis('N m', axis), ''))
    return parts


def _findings(data: VerdictData) -> Section:
    """Return the findings, one line each, and the remainders."""
    rows = [(finding_words(f, data), f['effect'],
             '-' if f['share'] is None else f'{100 * f["share"]:.0f} %',
             '-' if f['evidence'] is None else f'{f["evidence"]:.0f}') for f in data['findings']]
    header = ('finding', 'effect', 'share', 'evidence')
    return Section('diagnosis/findings.html', {
        'rows': PageTable(header, rows, (2, 3)),
        'remains': [f'{remainder_words(r, data)}.' for r in data['remainders']]}, 'Findings')


def _changes(data: VerdictData) -> Section | None:
    """Return what the findings change in the user's file, as lines of a difference."""
    lines, lacking = data.get('changes') or [], data.get('lacking') or []
    if not lines and not lacking:
        return None
    return Section('diagnosis/changes.html', {
        'lines': [(line, {'+': 'added', '-': 'removed'}.get(line[:1], '')) for line in lines],
        'lacking': lacking}, 'The file', folded=len(lines) > LISTED)


def _visible(data: VerdictData) -> Section | None:
    """Return the smallest size of each effect that the motion of a robot would have shown."""
    if 'visible' not in data:
        return None
    rows = []
    for effect, places in data['visible'].items():
        if places:
            low, high = min(places, key=places.get), max(places, key=places.get)
            ends = [(f'{places[place]:.2g} {size_unit(effect, axis_of(data, place))}', place)
                    for place in (low, high)]
            rows.append((MEANINGS.get(effect, effect), *ends[0], *ends[1]))
    return Section('diagnosis/visible.html', {
        'rows': PageTable(('effect', 'visible from', 'at', 'elsewhere up to', 'at'), rows),
        'untried': data['not_tried'].items()}, 'Smallest visible sizes', folded=True)


def _ranking(data: VerdictData) -> Section | None:
    """Return the gains of the effects of a drive, the best first."""
    gains: Mapping[str, float] = data.get('gains') or {}
    names, ids = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED], ids_of(data)
    return Section('diagnosis/ranking.html', {'gains': Bars([BarRow(
        name, meaning(name, axis_of(data)), max(gains[name], 0.0), gain_text(gains, name),
        'closed' if name == '+'.join(ids) else 'closed faint') for name in names])},
        'Which effect', folded=True) if gains else None


def _values(data: VerdictData) -> Section:
    """Return values of the effects with their equations, and of a drive as estimated along."""
    effects = library()
    words, knots = torque_map_of(data) or ('', [])
    return Section('diagnosis/values.html', {
        'torque_map': words,
        'parameters': PageTable(('effect', 'parameter', 'value', 'in the model', 'change'),
                                value_rows(data), (2, 3, 4)),
        'knots': PageTable(('at', on_axis('torque, N m', axis_of(data)), 'standard error'),
                           knots, (0, 1, 2)),
        'equations': [(name, effects[name].equation) for name in dict.fromkeys(
            f['effect'] for f in data['findings']) if name in effects],
        'nominal': PageTable(('value', 'estimate', 'off by tolerances'), [
            (name, number(data['nominal'][name]), f'{shift:+.1f}')
            for name, shift in (data.get('nominal_shift') or {}).items()], (1, 2))}, 'Values')


def _doubts(data: VerdictData, context: DiagnosisContext) -> Section:
    """Return the recordings, the noise of a drive, and the doubts about the verdict."""
    noise = '' if 'sigma' not in data else ', '.join(
        f'{gap["reading"]} {number(value, reading_unit(gap["reading"], axis_of(data)))}'
        for gap, value in zip(data['gaps'], [s for s in data['sigma'] if s is not None]))
    torque = data.get('process_torque')
    return Section('diagnosis/doubts.html', {
        'recordings': PageTable(('recording', 's', 'samples/s'), [
            (name, f'{seconds:.1f}', f'{rate:.0f}')
            for name, seconds, rate in context.recordings], (1, 2)),
        'noise': noise, 'torque_noise': '' if torque is None else number(torque),
        'warnings': [sentence(warning) for warning in data['warnings']]},
        'Recordings and doubts')
