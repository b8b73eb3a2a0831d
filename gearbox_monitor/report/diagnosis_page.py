# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a diagnosis: the effect, its place, how certain it is, and what it closes."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
import re
from typing import Any, TypeAlias

from gearbox_monitor.identification.model_overlay import Overlay
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.quality.recording import UniformRecording
from gearbox_monitor.report.builder import Page, render_page, Section
from gearbox_monitor.report.diagnosis_evidence import (
    DiagnosisEvidence, explained_by, MissingSignal)
from gearbox_monitor.report.figures import (
    BarRow, bars, BarView, chart, ChartView, heat_maps, HeatAxis, HeatMapsView, PageTable, Panel,
    Span, Trace)
from gearbox_monitor.report.residual_views import clipped_to_range, smoothed
from gearbox_monitor.report.shared_sections import VerdictNumbers
from gearbox_monitor.report.words import (
    dense_regions, gain_text, ids_of, meaning, MEANINGS, NAMING, next_steps, NO_FILES, number,
    percent, place_text, sentence, torque_map_of, undefined, unit_of, UserFiles, value_rows,
    value_text)

VerdictData: TypeAlias = Mapping[str, Any]  # the JSON of a verdict
ROLES = ('nominal', 'closed')
RANKED = 10
RIVALS = 6
LONGEST = 12  # characters of a value in the summary: a number, no table
NOISE_RANGE = (0.9, 1.5)  # gaps that are always in view: noise must not look large


@dataclass(frozen=True)
class PageContext:
    """
    What accompanies a verdict on its page.

    files: of the user; command: parts of the command that finds a better motion, see
    report.suggestion; changes: of the simulator's file, in words.
    """

    files: UserFiles = NO_FILES
    command: Sequence[str] = ()
    changes: Sequence[str] = ()


def diagnosis_page(data: VerdictData, evidence: DiagnosisEvidence,
                   recordings: Sequence[UniformRecording],
                   context: PageContext | None = None) -> str:
    """
    Return the page of a diagnosis as HTML.

    Args:
        data: the verdict as plain data.
        evidence: arrays behind it.
        recordings: those it is about.
        context: what accompanies it.

    Returns:
        One file that loads nothing.

    """
    context = context or PageContext()
    names = ', '.join(short_name(recording) for recording in recordings)
    return render_page(Page(f'Diagnosis of {names}', VerdictSummary.of(data, evidence.axis), (
        DiagnosisSteps.of(data, context, evidence.axis),
        GapClosure.of(data, context.files.validated),
        Overlays.of(evidence), GapLocation.of(data, evidence), EffectRanking.of(data, evidence),
        FittedValues.of(data, evidence.axis), RecordingDoubts.of(data, recordings, evidence),
        VerdictNumbers(json.dumps(data, indent=1))), evidence.axis))


def short_name(recording: UniformRecording) -> str:
    """Return the name of `recording` without its folders."""
    return re.split(r'[\\/]', recording.name)[-1]


@dataclass(frozen=True)
class VerdictSummary(Section):
    """
    The verdict in one sentence, its effects, the main figures.

    meanings: id, meaning and values of each effect.
    """

    template = 'diagnosis/summary.html'
    kind: str
    headline: str
    meanings: Sequence[tuple[str, str, str]]
    facts: Sequence[tuple[str, str]]

    @classmethod
    def of(cls, data: VerdictData, axis: str) -> 'VerdictSummary':
        """Return it for the verdict `data` on a drive with `axis`."""
        facts = [('gap before', number(data['gap_before']))]
        if data['verdict'] != 'none':
            facts.append(('gap after', number(data['gap_after'])))
            facts.append(('closed', percent(data.get('closed_fraction'))))
        if data['verdict'] in NAMING:
            facts.append(('indistinguishable from it', ', '.join(data['confusable']) or 'nothing'))
        colour = {'none': 'good', 'unknown': 'warn', 'incomplete': 'warn'}
        rows = value_rows(data, axis)
        sizes = {name: ', '.join(value_text(row) for row in rows
                                 if row.effect == name and len(row.value) <= LONGEST)
                 for name in ids_of(data)}
        return cls(colour.get(data['verdict'], ''), data['summary'],
                   [(name, meaning(name, axis), sizes[name]) for name in ids_of(data)
                    if name in MEANINGS], facts)


@dataclass(frozen=True)
class DiagnosisSteps(Section):
    """
    Advice and what goes with it.

    changes: of the simulator's file; command: that finds a better motion, '' for none; files:
    beside the page.
    """

    heading = 'What to do next'
    template = 'diagnosis/next.html'
    steps: Sequence[str]
    changes: Sequence[str]
    command: str
    files: Sequence[str]

    @classmethod
    def of(cls, data: VerdictData, context: PageContext, axis: str) -> 'DiagnosisSteps':
        """
        Return the next steps.

        Args:
            data: the verdict.
            context: what accompanies it.
            axis: of the drive.

        """
        steps = next_steps(data, context.files, axis)
        files = ['verdict.json', *(['drive.closed.yaml'] if context.files.closed else [])]
        return cls([sentence(step) for step in steps], context.changes,
                   ' \\\n    '.join(context.command), files)


@dataclass(frozen=True)
class FreeRun:
    """One run over the whole second recording: its name, seconds, unit, rms before and after."""

    name: str
    seconds: float
    unit: str
    rms: PageTable


@dataclass(frozen=True)
class GapClosure(Section):
    """
    The gap before and after, as bars; the share that is closed.

    undefined: why there is no share, '' if there is one or no gap; free_run: on the second
    recording, or None; regions: of the motion.
    """

    heading = 'The gap'
    template = 'diagnosis/gap.html'
    gaps: Sequence[BarView]
    closed: Sequence[BarView]
    undefined: str
    free_run: FreeRun | None
    regions: PageTable

    @classmethod
    def of(cls, data: VerdictData, validated: str | None) -> 'GapClosure':
        """Return it for the verdict `data` and the name `validated` of the second recording."""
        gaps, closed = [], []
        for name, nominal, closed_gap, share, interval in _gap_parts(data):
            gaps.append(BarRow(name, 'before', nominal, number(nominal), 'nominal'))
            if data['verdict'] == 'none':
                continue
            gaps.append(BarRow('', 'after', closed_gap, number(closed_gap), 'closed'))
            if share is not None:
                note = (f'90 % interval {percent(interval[0])} to {percent(interval[1])}'
                        if interval else '')
                closed.append(BarRow(name, note, share, percent(share), 'closed', interval))
        top = max([NOISE_RANGE[1], *(row.value for row in gaps if row.value is not None)])
        whole = max([1.0, *(v for row in closed for v in (row.value, *(row.interval or ()))
                            if v is not None)])
        return cls(bars(gaps, True, top), bars(closed, top=whole),
                   '' if closed or data['verdict'] == 'none' else undefined(data),
                   _free_run(data, validated), PageTable(('region', 'part', 'before', 'after'), [
                       (name.replace('_', ' '), part.replace('_', ' '), number(v['before']),
                        number(v['after']))
                       for name, bins in (data.get('regions') or {}).items()
                       for part, v in bins.items() if v], (2, 3)))


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


def _free_run(data: VerdictData, validated: str | None) -> FreeRun | None:
    """Return the free run on the second recording, None without one."""
    run = (data.get('validation') or {}).get('free_run')
    if not run:
        return None
    units = ', '.join(dict.fromkeys(unit_of(name, 'rad') for name in run['before']))
    return FreeRun(str(validated), run['seconds'], units, PageTable(('', 'before', 'after'), [
        (name, number(run['before'][name]), number(run['after'][name]))
        for name in run['before']], (1, 2)))


@dataclass(frozen=True)
class Overlays(Section):
    """Recording and models over each other: (name, chart) of typical windows and of all."""

    heading = 'Before and after'
    template = 'diagnosis/overlays.html'
    charts: Sequence[tuple[str, ChartView]]

    @classmethod
    def of(cls, evidence: DiagnosisEvidence) -> 'Overlays':
        """Return it for `evidence`."""
        overlay, charts = evidence.overlay, []
        for words, window in evidence.windows:
            panels = []
            for channel in overlay.channels:
                angle, residual = window_traces(overlay, window, channel)
                panels += _channel_panels(overlay.recording.readings[channel], angle, residual,
                                          evidence.axis)
            title = (f'{words.capitalize()} among those held out: {overlay.t[window, 0]:.0f} to '
                     f'{overlay.t[window, -1]:.0f} s')
            charts.append((words, chart(title, panels, 'time (s)', 't (s)')))
        return cls([*charts, ('whole recording, one run', _whole(overlay, evidence.axis))])


def window_traces(overlay: Overlay, window: int, channel: int) -> tuple[list[Trace], list[Trace]]:
    """
    Return the curves of one window and encoder.

    Args:
        overlay: models over the recording.
        window: its number.
        channel: column of the readings.

    Returns:
        Curves of the angle and of the residual, rad or N m.

    """
    t, measured = overlay.t[window], overlay.measured[window, :, channel]
    angle = [Trace(t, measured, 'recording', 'recording')]
    residual = []
    for run, role in zip(overlay.runs, ROLES):
        y = run.y[window, :, channel]
        angle.append(Trace(t, y, run.name, role))
        residual += [Trace(t, measured - y, '', f'{role} faint'),
                     Trace(t, smoothed(measured - y, overlay.recording.dt), run.name,
                           f'{role} firm')]
    return angle, residual


def _channel_panels(name: str, traces: Sequence[Trace], residual: Sequence[Trace],
                    axis: str) -> list[Panel]:
    """Return the panels of one encoder: readings and, below, the residual."""
    unit = unit_of(name, 'rad')
    quantity = f'{name}, angle' if unit == 'rad' else name
    return [Panel(on_axis(f'{quantity} ({unit})', axis), traces),
            Panel(on_axis(f'{name}, recording - model ({unit})', axis), residual, 0.0, 110)]


def _whole(overlay: Overlay, axis: str) -> ChartView:
    """Return the chart of one run over the whole recording."""
    t, panels = overlay.recording.t, []
    for channel in overlay.channels:
        measured = overlay.recording.y[:, channel]
        traces = [Trace(t, measured, 'recording', 'recording')]
        traces += [Trace(t, clipped_to_range(run.free[:, channel], measured), run.name, role)
                   for run, role in zip(overlay.runs, ROLES)]
        residual = [Trace(trace.x, measured - trace.y, trace.name, f'{trace.role} firm')
                    for trace in traces[1:]]
        panels += _channel_panels(overlay.recording.readings[channel], traces, residual, axis)
    return chart('One free run over the whole recording, from the state of its first window; '
                 'errors add up', panels, 'time (s)', 't (s)')


@dataclass(frozen=True)
class MissingCurves:
    """The missing signal as functions of the motion: its quantity, place and charts."""

    quantity: str
    place: str
    charts: Sequence[ChartView]


@dataclass(frozen=True)
class GapLocation(Section):
    """
    Where the gap is: places, regions of the motion, the missing signal, maps.

    placed: whether the recording shows the place; places: bars, empty where it does not or there
    is no gap; effects: how many the verdict names.
    """

    heading = 'Where'
    folded = True
    template = 'diagnosis/where.html'
    placed: bool
    places: Sequence[BarView]
    regions: Sequence[str]
    effects: int
    missing: MissingCurves | None
    charts: Sequence[ChartView]
    planes: HeatMapsView

    @classmethod
    def of(cls, data: VerdictData, evidence: DiagnosisEvidence) -> 'GapLocation':
        """Return it for the verdict `data` and its `evidence`."""
        rows, regions = [], []
        if data['verdict'] != 'none' and evidence.placed:
            for place, part in data['where']['places'].items():
                role = 'closed' if place == data['where']['place'] else 'closed faint'
                rows.append(BarRow(place_text(place), '', part['explained'],
                                   percent(part['explained']), role))
        if data['verdict'] != 'none':
            regions = dense_regions(data['where'].get('region') or {}, 'twist' in evidence.labels)
        charts = []
        for name, maps in evidence.maps.items():
            label = evidence.labels[name]
            traces = [Trace(residual.edges, residual.rms, run.name, role, step=True)
                      for run, role, residual in zip(evidence.overlay.runs, ROLES, maps)]
            panel = Panel('gap', traces, 1.0, 130, NOISE_RANGE)
            charts.append(chart(f'over {name}', [panel], label, label, False))
        planes = evidence.planes
        return cls(evidence.placed, bars(rows, top=1.0), regions, len(ids_of(data)),
                   _missing(evidence.missing, evidence.labels), charts,
                   heat_maps(f'Gap over {planes.x} and {planes.y}',
                             [(run.name, values) for run, values in zip(evidence.overlay.runs,
                                                                        planes.values)],
                             HeatAxis(planes.x_edges, evidence.labels[planes.x]),
                             HeatAxis(planes.y_edges, evidence.labels[planes.y]), '= gap'))


def _missing(missing: MissingSignal | None, labels: Mapping[str, str]) -> MissingCurves | None:
    """Return the charts of the signal that is missing at one place, None without a gap."""
    if missing is None:
        return None
    quantity = {'N m': 'torque', 'N': 'force'}.get(missing.unit, 'offset')
    charts = []
    for name, law in missing.laws.items():
        margin: Array = 2.0 * law.error
        trace = Trace(law.centers, law.value, f'missing {quantity}', 'signal',
                      band=(law.value - margin, law.value + margin))
        charts.append(chart(explained_by(name, law), [
            Panel(f'{quantity} ({missing.unit})', (trace,), 0.0, 130)], labels[name],
            labels[name], False))
    return MissingCurves(quantity, place_text(missing.place), charts)


@dataclass(frozen=True)
class Imitators:
    """Effects that could imitate one: its id, its evidence d, what they leave of it."""

    effect: str
    evidence: float
    shares: PageTable


@dataclass(frozen=True)
class MatrixView:
    """Shares [N, N] in percent that effects leave of each other; small ones stand out."""

    names: Sequence[str]
    shares: Sequence[Sequence[float]]


@dataclass(frozen=True)
class EffectRanking(Section):
    """
    Gains of the effects, and what the recording can distinguish.

    has_effect: whether the verdict names an effect; rivals: effects that are indistinguishable
    from it; close: those that explain the recording nearly as well; limit: evidence that
    distinguishes.
    """

    heading = 'Which effect'
    folded = True
    template = 'diagnosis/ranking.html'
    gains: Sequence[BarView]
    has_effect: bool
    rivals: Sequence[str]
    close: Sequence[str]
    imitators: Sequence[Imitators]
    matrix: MatrixView | None
    limit: float = THRESHOLDS.isolable

    @classmethod
    def of(cls, data: VerdictData, evidence: DiagnosisEvidence) -> 'EffectRanking':
        """Return it for the verdict `data` and its `evidence`."""
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
        matrix = evidence.matrix and MatrixView(
            evidence.matrix[0], (100.0 * evidence.matrix[1]).tolist())
        return cls(bars(rows), has_effect, rivals, close, _imitators(evidence.separations), matrix)


def _imitators(separations: Mapping[str, tuple[float, Mapping[str, float]]]) -> list[Imitators]:
    """Return the nearest imitators of each effect."""
    imitators = []
    for name, (d, shares) in separations.items():
        nearest = sorted(shares.items(), key=lambda item: item[1])[:RIVALS]
        if nearest:
            imitators.append(Imitators(name, d, PageTable(('effect', 's2', 'd s2', ''), [
                (rival, f'{s2:.3f}', number(d * s2),
                 '' if d * s2 > THRESHOLDS.isolable else 'too close')
                for rival, s2 in nearest], (1, 2))))
    return imitators


@dataclass(frozen=True)
class FittedValues(Section):
    """Values of the effects, their equations, values of the model that were estimated, too."""

    heading = 'Values'
    template = 'diagnosis/values.html'
    nearest_only: bool
    parameters: PageTable
    torque_map: str
    knots: PageTable
    equations: Sequence[tuple[str, str]]
    nominal: PageTable

    @classmethod
    def of(cls, data: VerdictData, axis: str) -> 'FittedValues':
        """Return it for the verdict `data` on a drive with `axis`."""
        effects, params = library(), data.get('params') or {}
        words, knots = torque_map_of(data) or ('', [])
        return cls(
            data['verdict'] == 'incomplete',
            PageTable(('effect', 'parameter', 'value', 'standard error', 'unit', 'in the model',
                       'change'), value_rows(data, axis), (2, 3, 5, 6)),
            words, PageTable(('at', f'torque, {on_axis("N m", axis)}', 'standard error'), knots,
                             (0, 1, 2)),
            [(name, effects[name].equation) for name in params if name in effects],
            PageTable(('value', 'estimate', 'off by tolerances'), [
                (name, number(data['nominal'][name]), f'{shift:+.1f}')
                for name, shift in (data.get('nominal_shift') or {}).items()], (1, 2)))


@dataclass(frozen=True)
class RecordingDoubts(Section):
    """
    Recordings, their noise, and what speaks against the verdict.

    misfit: chi2 per reading and deviations from white noise, or None; torque_noise, condition: ''
    if unknown.
    """

    heading = 'Recording and doubts'
    template = 'diagnosis/doubts.html'
    recordings: PageTable
    noise: str
    torque_noise: str
    misfit: tuple[float, float] | None
    condition: str
    warnings: Sequence[str]

    @classmethod
    def of(cls, data: VerdictData, recordings: Sequence[UniformRecording],
           evidence: DiagnosisEvidence) -> 'RecordingDoubts':
        """
        Return the doubts.

        Args:
            data: the verdict.
            recordings: those it is about.
            evidence: arrays behind it.

        """
        noise = ', '.join(
            f'{name} {number(value)} {unit_of(name, "rad")}' for name, value in
            zip(evidence.overlay.recording.readings, data['sigma']) if value is not None)
        misfit = data.get('misfit') or {}
        excess, structure = misfit.get('excess'), misfit.get('structure')
        return cls(
            PageTable(('recording', 's', 'samples/s'), [
                (short_name(r), f'{r.duration:.1f}', f'{1.0 / r.dt:.0f}')
                for r in recordings], (1, 2)),
            noise, '' if data['process_torque'] is None else number(data['process_torque']),
            None if excess is None or structure is None else (1.0 + excess, structure),
            number(data['condition']) if data.get('condition') else '',
            [sentence(warning) for warning in data.get('warnings') or ()])
