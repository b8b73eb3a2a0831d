# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The page of a diagnosis: the effect, its place, its certainty, and the share it explains.

The evidence comes first: residuals binned over the motion, charts of models over a recording.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import re
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.contest import CONTEST, THRESHOLDS
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.diagnosis.joint.windows import Overlay, overlay
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.presentation import number, on_axis, percent
from gearbox_monitor.report.builder import Page, PageTable, render_page, Section, verdict_numbers
from gearbox_monitor.report.chart import BarRow, Bars, Chart, Panel, Span, Trace
from gearbox_monitor.report.words import (
    gain_text, ids_of, meaning, MEANINGS, NAMING, next_steps, NO_FILES, NOTHING, place_text,
    sentence, torque_map_of, undefined, unit_of, UserFiles, value_rows)
from gearbox_monitor.signals.uniform import UniformRecording

BINS = 24
BRIEF = 0.01      # s, over which positions are smoothed
TAIL = 0.5        # percent of the samples on either end that share the outermost bins
FEWEST = 0.002    # share of the samples below which a bin says nothing


def binned(x: Array, value: Array, edges: Array) -> Array:
    """
    Return the rms [B] of `value` [...] over x [...], or of value [..., C]; NaN: few samples.

    What lies beyond the edges counts in the outermost bins.

    Args:
        x: motion variable in each sample.
        value: quantity to average, of the shape of `x`, or with channels as a last axis.
        edges: edges of the bins [B + 1], in the unit of the motion variable.
    """
    bins = len(edges) - 1
    at = np.clip(np.searchsorted(edges, np.ravel(x), side='right') - 1, 0, bins - 1)
    power = (np.asarray(value, float).reshape(len(at), -1) ** 2).mean(axis=-1)
    count = np.bincount(at, minlength=bins)
    populated = count >= max(1.0, FEWEST * len(at))
    total = np.bincount(at, power, minlength=bins)
    return np.sqrt(np.where(populated, total / np.where(populated, count, 1), np.nan))


def edges_of(x: Array) -> Array:
    """Return the edges [BINS + 1] of bins, evenly spaced over all of `x` but its tails."""
    low, high = np.percentile(x, [TAIL, 100.0 - TAIL])
    if not high > low:
        low, high = low - 0.5, low + 0.5
    return np.linspace(low, high, BINS + 1)


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


QUANTITIES = {'speed': 'speed of the motor (rad/s)', 'angle': 'angle of the arm (rad)',
              'twist': 'twist, motor - arm (rad)', 'time': 'time (s)'}  # and units, rotary
RUN_ROLES = ('nominal', 'closed')  # of curves, in the order of the runs


@dataclass(frozen=True)
class DiagnosisEvidence:
    """
    Arrays behind a verdict.

    axis: of the model; labels {quantity: words with unit}; overlay: nominal model first; windows:
    (words, window) of those to show; maps {quantity: (edges [B + 1] of bins, rms [B] of the
    residual in sigma of each run)}; placed: whether the recording shows where an effect acts: both
    encoders, or one of a rigid drive.
    """

    axis: str
    labels: Mapping[str, str]
    overlay: Overlay
    windows: Sequence[tuple[str, int]]
    maps: Mapping[str, tuple[Array, Sequence[Array]]]
    placed: bool


def gather(verdict: Verdict, model: DriveModel) -> DiagnosisEvidence:
    """
    Return the evidence behind a verdict, of the recording with the largest gap.

    Args:
        verdict: of the search.
        model: the nominal model.

    Returns:
        Arrays that the page shows.

    """
    data = verdict.basis.data
    recording = data.recordings[verdict.basis.widest]
    models = {'nominal model': model}
    if verdict.model != model:
        models[closed_name(verdict, model)] = verdict.model
    laid = overlay(recording, models, data.level)
    motion = _motion(recording, model, laid.windows)
    residuals = [laid.residual(run) for run in laid.runs]
    maps = {name: (edges, [binned(value, r, edges) for r in residuals])
            for name, value in motion.items() for edges in (edges_of(value),)}
    return DiagnosisEvidence(
        model.axis, {name: on_axis(_label(name, recording), model.axis) for name in motion}, laid,
        notable_windows(laid), maps, shows_place(recording, model))


def shows_place(recording: UniformRecording, model: DriveModel) -> bool:
    """Return whether a recording of `model` shows the side of an effect: one encoder does not."""
    return model.transmission.kind == 'rigid' or _both_sides(recording)


def _both_sides(recording: UniformRecording) -> bool:
    """Return whether motor and arm of a recording were measured."""
    return len(recording.channels) > 1 or recording.readings[0] == 'torque'


def _label(quantity: str, recording: UniformRecording) -> str:
    """Return the name of a quantity with its unit; one encoder shows its own side alone."""
    words = QUANTITIES[quantity]
    if _both_sides(recording):
        return words
    side = recording.readings[recording.channels[0]]
    return words.replace('of the motor', f'of the {side}').replace('of the arm', f'of the {side}')


def _motion(recording: UniformRecording, model: DriveModel, windows: ShootingWindows
            ) -> dict[str, Array]:
    """Return {quantity: [W, L]} of a recording; the twist only where it exists and is measured."""
    (motor, arm), dt = recording.positions.T, recording.dt
    values = {'speed': np.gradient(smoothed(motor, dt), dt), 'angle': smoothed(arm, dt, BRIEF),
              'time': np.arange(len(arm)) * dt}
    if model.transmission.kind != 'rigid' and _both_sides(recording):
        values['twist'] = smoothed(motor - arm, dt, BRIEF)
    return {name: values[name][windows.samples] for name in QUANTITIES if name in values}


def closed_name(verdict: Verdict, model: DriveModel) -> str:
    """Return the name of the model that closes the gap between a recording and `model`."""
    if verdict.verdict == 'effect':
        return f'with {verdict.effect}'
    closing = ['a torque map' if effect['id'] == TORQUE_MAP.id else str(effect['id'])
               for effect in verdict.model.effects if effect not in model.effects]
    return f'with {" and ".join(closing) or "estimated values"}'


def notable_windows(laid: Overlay) -> tuple[tuple[str, int], ...]:
    """Return (words, window) of the typical and the worst held-out window of `laid`."""
    windows = np.flatnonzero(laid.validation)
    windows = windows if len(windows) else np.arange(len(laid.validation))
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
    t, panels = overlay.recording.t, []
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
    unit = unit_of(name, 'rad')
    quantity = f'{name}, angle' if unit == 'rad' else name
    return [Panel(on_axis(f'{quantity} ({unit})', axis), readings),
            Panel(on_axis(f'{name}, recording - model ({unit})', axis), residual, 0.0, 110)]


VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a verdict
RANKED = 10
NOISE_RANGE = (0.9, 1.5)  # gaps that are always in view: noise must not look large


def diagnosis_page(data: VerdictData, evidence: DiagnosisEvidence,
                   recordings: Sequence[UniformRecording],
                   files: UserFiles = NO_FILES) -> str:
    """
    Return the page of a diagnosis as HTML.

    Args:
        data: the verdict as plain data.
        evidence: arrays behind it.
        recordings: those it is about.
        files: of the user.

    Returns:
        One file that loads nothing.

    """
    names = ', '.join(short_name(recording) for recording in recordings)
    return render_page(Page(f'Diagnosis of {names}', _summary(data, evidence.axis), (
        _steps(data, files, evidence.axis), _gaps(data, files.validated),
        _overlays(evidence), _location(data, evidence), _ranking(data, evidence),
        _values(data, evidence.axis), _doubts(data, recordings, evidence),
        verdict_numbers(data)), evidence.axis))


def short_name(recording: UniformRecording) -> str:
    """Return the name of `recording` without its folders."""
    return re.split(r'[\\/]', recording.name)[-1]


def _summary(data: VerdictData, axis: str) -> Section:
    """Return the verdict in one sentence, its effects, the main figures."""
    facts = [('gap before', number(data['gap_before']))]
    if data['verdict'] not in NOTHING:
        facts.append(('gap after', number(data['gap_after'])))
        closed = data.get('closed_fraction')
        facts.append(('closed', 'not defined' if closed is None else str(percent(closed))))
    if data['verdict'] in NAMING:
        facts.append(('indistinguishable from it', ', '.join(data['confusable']) or 'nothing'))
    colour = {'none': 'good', 'undecided': 'warn', 'unknown': 'warn', 'incomplete': 'warn'}
    rows = value_rows(data, axis)
    sizes = {name: ', '.join(str(row) for row in rows
                             if row.effect == name and row.size is not None)
             for name in ids_of(data)}
    return Section('diagnosis/summary.html', {
        'kind': colour.get(data['verdict'], ''), 'headline': data['summary'], 'facts': facts,
        'meanings': [(name, meaning(name, axis), sizes[name]) for name in ids_of(data)
                     if name in MEANINGS]})


def _steps(data: VerdictData, files: UserFiles, axis: str) -> Section:
    """Return advice, with the changes of a file and further files."""
    return Section('diagnosis/next.html', {
        'steps': [sentence(step) for step in next_steps(data, files, axis)],
        'changes': files.changes,
        'files': ['verdict.json', *(['drive.closed.yaml'] if files.closed else [])]},
        'What to do next')


def _gaps(data: VerdictData, validated: str | None) -> Section:
    """Return the gap before and after, as bars, and the share that is closed, or why none is."""
    gaps, closed = [], []
    for name, nominal, closed_gap, share, interval in _gap_parts(data):
        gaps.append(BarRow(name, 'before', nominal, number(nominal), 'nominal'))
        if data['verdict'] in NOTHING:
            continue
        gaps.append(BarRow('', 'after', closed_gap, number(closed_gap), 'closed'))
        if share is not None:
            note = (f'90 % interval {percent(interval[0])} to {percent(interval[1])}'
                    if interval else '')
            closed.append(BarRow(name, note, share, str(percent(share)), 'closed', interval))
    top = max([NOISE_RANGE[1], *(row.value for row in gaps if row.value is not None)])
    whole = max([1.0, *(v for row in closed for v in (row.value, *(row.interval or ()))
                        if v is not None)])
    return Section('diagnosis/gap.html', {
        'gaps': Bars(gaps, True, top), 'closed': Bars(closed, top=whole),
        'undefined': '' if closed or data['verdict'] in NOTHING else undefined(data),
        'free_run': _free_run(data, validated)}, 'The gap')


GapPart: TypeAlias = tuple[str, float, float, float | None, Span | None]


def _gap_parts(data: VerdictData) -> list[GapPart]:
    """Return (name, gap before, after, closed share, its interval) in all and of each reading."""
    channels = data.get('channels') or {}
    parts: list[GapPart] = [
        (' and '.join(channels) or 'all', data['gap_before'], data['gap_after'],
         data.get('closed_fraction'), data.get('closed_fraction_ci'))]
    for name, part in channels.items() if len(channels) > 1 else ():
        parts.append((name if name == 'torque' else f'{name} encoder', part['before'],
                      part['after'], part['closed'], None))
    validation = data.get('validation')
    if validation:
        parts.append(('second recording', validation['gap_before'], validation['gap_after'],
                      validation['closed_fraction'], None))
    theirs = data.get('simulator')
    if theirs:
        parts.append((f'in {theirs["name"]}', theirs['gap_before'], theirs['gap_after'],
                      theirs['closed_fraction'], None))
    return parts


def _free_run(data: VerdictData, validated: str | None) -> dict[str, Any] | None:
    """Return name, seconds, unit and rms of the free run on the second recording, or None."""
    run = (data.get('validation') or {}).get('free_run')
    if not run:
        return None
    units = ', '.join(dict.fromkeys(unit_of(name, 'rad') for name in run['before']))
    return {'name': str(validated), 'seconds': run['seconds'], 'unit': units,
            'rms': PageTable(('', 'before', 'after'), [
                (name, number(run['before'][name]), number(run['after'][name]))
                for name in run['before']], (1, 2))}


def _overlays(evidence: DiagnosisEvidence) -> Section:
    """Return charts of recording and models over each other, of typical windows and of all."""
    charts = [(words, window_chart(evidence.overlay, words, window, evidence.axis))
              for words, window in evidence.windows]
    charts.append(('whole recording, one run', whole_chart(evidence.overlay, evidence.axis)))
    return Section('diagnosis/overlays.html', {'charts': charts}, 'Before and after')


def _location(data: VerdictData, evidence: DiagnosisEvidence) -> Section:
    """Return where the gap is: places and maps."""
    rows = []
    if data['verdict'] not in NOTHING and evidence.placed:
        for place, part in data['where']['places'].items():
            role = 'closed' if place == data['where']['place'] else 'closed faint'
            rows.append(BarRow(place_text(place), '', part['explained'],
                               str(percent(part['explained'])), role))
    charts = []
    for name, (edges, maps) in evidence.maps.items():
        panel = Panel('gap', [
            Trace(edges, rms, run.name, role, step=True)
            for run, role, rms in zip(evidence.overlay.runs, RUN_ROLES, maps)],
            1.0, 130, NOISE_RANGE)
        charts.append(Chart(f'over {name}', [panel], evidence.labels[name], zoom=False))
    return Section('diagnosis/where.html', {
        'placed': evidence.placed, 'places': Bars(rows, top=1.0), 'charts': charts},
        'Where', folded=True)


def _ranking(data: VerdictData, evidence: DiagnosisEvidence) -> Section:
    """Return the gains of the effects, and the rivals of the verdict."""
    gains: Mapping[str, float] = data.get('gains') or {}
    effect, rivals = data.get('effect'), data.get('confusable') or ()
    ranking = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED]
    rows = []
    for name in ranking:
        note = ('the verdict' if name == effect else 'indistinguishable from the verdict'
                if name in rivals else meaning(name, evidence.axis))
        rows.append(BarRow(name, note, max(gains[name], 0.0), gain_text(gains, name),
                           'closed' if name == effect else 'closed faint'))
    has_effect = data['verdict'] in NAMING
    close = [name for name in ranking if name != effect and name not in rivals
             and gains.get(effect or '', 0.0) - gains[name] < THRESHOLDS.isolable
             ] if has_effect else []
    return Section('diagnosis/ranking.html', {
        'gains': Bars(rows), 'has_effect': has_effect, 'rivals': rivals, 'close': close},
        'Which effect', folded=True)


def _values(data: VerdictData, axis: str) -> Section:
    """Return values of the effects, their equations, values of the model that were estimated."""
    effects, params = library(), data.get('params') or {}
    words, knots = torque_map_of(data) or ('', [])
    return Section('diagnosis/values.html', {
        'nearest_only': data['verdict'] == 'incomplete', 'torque_map': words,
        'parameters': PageTable(('effect', 'parameter', 'value', 'in the model', 'change'), [
            row.cells for row in value_rows(data, axis)], (2, 3, 4)),
        'knots': PageTable(('at', f'torque, {on_axis("N m", axis)}', 'standard error'), knots,
                           (0, 1, 2)),
        'equations': [(name, effects[name].equation) for name in params if name in effects],
        'nominal': PageTable(('value', 'estimate', 'off by tolerances'), [
            (name, number(data['nominal'][name]), f'{shift:+.1f}')
            for name, shift in (data.get('nominal_shift') or {}).items()], (1, 2))}, 'Values')


def _doubts(data: VerdictData, recordings: Sequence[UniformRecording],
            evidence: DiagnosisEvidence) -> Section:
    """Return the recordings, their noise, and the doubts about the verdict."""
    noise = ', '.join(
        f'{name} {number(value, unit_of(name, "rad"))}' for name, value in
        zip(evidence.overlay.recording.readings, data['sigma']) if value is not None)
    misfit = data.get('misfit') or {}
    torque, memory = misfit.get('torque'), misfit.get('memory')
    return Section('diagnosis/doubts.html', {
        'recordings': PageTable(('recording', 's', 'samples/s'), [
            (short_name(r), f'{r.duration:.1f}', f'{1.0 / r.dt:.0f}')
            for r in recordings], (1, 2)),
        'noise': noise,
        'torque_noise': '' if data['process_torque'] is None else number(data['process_torque']),
        'misfit': None if torque is None or memory is None else (
            f'{torque:.1f}', f'{memory:.1f}', f'{CONTEST.margin:g}'),
        'condition': number(data['condition']) if data.get('condition') else '',
        'warnings': [sentence(warning) for warning in data.get('warnings') or ()]},
        'Recording and doubts')
