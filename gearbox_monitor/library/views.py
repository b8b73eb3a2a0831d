# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What results show: a line, words, a table, a page, a file; one entry per result."""
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from html import escape
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.diagnosis.joint.nominal import Adapted, NominalFit
from gearbox_monitor.diagnosis.joint.parameter_ranges import ParameterRanges
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import COLUMNS, Estimates, SMOOTHED_COLUMNS
from gearbox_monitor.files.knowledge_file import save_watch
from gearbox_monitor.files.user_files import save_model, write_new, write_parameters
from gearbox_monitor.health.backlash.change_tests import MEASURED
from gearbox_monitor.health.backlash.features import Backlash, NotExcited, width_of
from gearbox_monitor.library.estimation import BacklashWindows, RecordingEstimates
from gearbox_monitor.library.identify import Diagnosis, TunedParameters, write_adapted
from gearbox_monitor.library.ranges import ranges_yaml
from gearbox_monitor.library.recording import DriveRecording
from gearbox_monitor.library.recording_report import ReportPages
from gearbox_monitor.library.simulator_file import expect_path, SimulatorFile
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.presentation import credible, number, on_axis, Quantity
from gearbox_monitor.recordings.joint_input import match_stamps
from gearbox_monitor.report.builder import Page, page_summary, render_page, Section
from gearbox_monitor.report.chart import Chart, Drawing, Panel, Plane, Trace
from gearbox_monitor.report.diagnosis_page import diagnosis_page
from gearbox_monitor.report.recording_page import backlash_chart, overview, raised, ROLES
from gearbox_monitor.report.sentences import of_fit, of_noise, of_unit, told
from gearbox_monitor.report.timeline import measured, State, Timeline, timeline_of
from gearbox_monitor.report.watch_words import watch_headline, watch_text
from gearbox_monitor.report.words import sentence, verdict_text
from gearbox_monitor.watch.record import Watch

ROWS = 10  # of a long table in a notebook
Columns = Mapping[str, Any]  # {name: values [N]}
Entry = TypeVar('Entry')


# ---------------------------------------------------------------------- a line, and words

def brief(result: Any) -> str:
    """Return the `result` in one line, as repr shows it."""
    return f'{NAMES.get(type(result), type(result).__name__)}({_entry(BRIEFS, result)(result)})'


def words(result: Any) -> str:
    """Return the `result` in some lines, as print shows it."""
    written = next((WORDS[kind] for kind in type(result).__mro__ if kind in WORDS), None)
    return '\n'.join([brief(result)] if written is None else written(result))


def _notes(notes: Iterable[object]) -> list[str]:
    return [f'note: {note}' for note in notes]


def _recorded_in_brief(recording: DriveRecording) -> str:
    driving = 'torque' if recording.model.controller is None else 'setpoint'
    measured = [name for name in (driving, 'motor', 'arm', 'arm_torque')
                if not np.isnan(getattr(recording, name)).all()]
    return (f'{len(recording)} samples, {recording.duration:.2f} s, '
            f'{recording.rate:.4g} Hz; {", ".join(measured)}')


def _estimated_in_brief(estimates: Estimates) -> str:
    n = len(estimates.stamp_ns)
    span = (estimates.stamp_ns.max() - estimates.stamp_ns.min()) * 1e-9 if n else 0.0
    rms = f'; tau_k {number(_rms(estimates.tau_k), "N m")} rms' if n else ''
    return f'{n} in {span:.2f} s{rms}'


def _estimated_in_words(estimates: RecordingEstimates) -> list[str]:
    lines = [f'{estimates.recording.name}: {brief(estimates)}']
    if estimates.backlash:
        newest = estimates.backlash[-1]
        unit = on_axis('rad', estimates.recording.model.axis)
        lines.append(f'backlash {width_of(newest.gap, newest.gap_std, unit)} in the newest of '
                     f'{len(estimates.backlash)} windows')
    return [*lines, *(f'{name}: {outcome.level.name}: {outcome.message}'
                      for name, outcome in estimates.outcomes.items()), *_notes(estimates.notes)]


def _windows_in_brief(windows: BacklashWindows) -> str:
    unit, gap, lost = on_axis('rad', windows.model.axis), windows.gap, windows.lost_motion
    if gap is None:
        text = windows.reason
    elif windows.separable or lost is None:
        text = f'backlash {Quantity(gap.value, gap.std, unit)}'
    else:
        text = (f'lost motion {Quantity(lost.value, lost.std, unit)}, backlash and compliance '
                'are not separable')
    return f'{len(windows.fits)} windows; {text}'


def _fitted(fit: NominalFit) -> list[str]:
    return [f'{v.name} {credible(v.value, v.error, v.unit)}' for v in fit.values if v.determined]


NAMES = {DriveRecording: 'Recording'}
BRIEFS: dict[type, Callable[[Any], str]] = {
    DriveRecording: lambda r: f'{r.name!r}: {_recorded_in_brief(r)}',
    Estimates: _estimated_in_brief,
    BacklashWindows: lambda w: f'{w.recording.name!r}: {_windows_in_brief(w)}',
    Diagnosis: lambda d: d.data['summary'],
    NominalFit: lambda f: told(of_fit(f))['summary'],
    TunedParameters: lambda t: told(of_noise(t.figures, t.model.axis))['summary'],
    Adapted: lambda a: told(of_unit(a))['summary'],
    ParameterRanges: lambda r: ', '.join(
        f'{name} {number(low)} to {number(high)}' for name, low, high in zip(
            r.names, r.low, r.high)),
    SimulatorFile: lambda f: f'{f.to}: changes in {f.into}' + '; lacking ' * bool(
        f.lacking) + ', '.join(row.id for row in f.lacking),
    Watch: watch_headline,
    ReportPages: lambda p: f'{p.page}: {p.extent}'}
# Lines of print where they are more than those of repr.
WORDS: dict[type, Callable[[Any], list[str]]] = {
    RecordingEstimates: _estimated_in_words, Diagnosis: lambda d: [verdict_text(d.data)],
    Watch: lambda w: [watch_text(w)],
    ReportPages: lambda p: [p.headline, f'{p.page}: {p.extent}'],
    DriveRecording: lambda r: [brief(r), *_notes(r.notes)],
    NominalFit: lambda f: [_entry(BRIEFS, f)(f), *_fitted(f)],
    TunedParameters: lambda t: [_entry(BRIEFS, t)(t), *(
        f'{name} {value if isinstance(value, str) else number(value)}'
        for name, value in t.values.items()), *_notes(t.notes)],
    ParameterRanges: lambda r: [brief(r), *map(str, r.combinations), *_notes(r.notes)],
    Adapted: lambda a: [_entry(BRIEFS, a)(a), *(_fitted(a.fit) if a.fit else ()),
                        *(f'open: {sentence}' for sentence in a.open)],
    SimulatorFile: lambda f: [brief(f), *(f'{row.id}: {row.kind}: {row.words}'
                                          for row in f.exported), *f.notes]}


# ---------------------------------------------------------------------- tables

def columns(result: Any) -> Columns:
    """Return the `result` as a table, {name: values [N]}."""
    return _entry(TABLES, result)(result)


def _recorded(recording: DriveRecording) -> Columns:
    names = ['t', 'torque' if recording.model.controller is None else 'setpoint', 'motor', 'arm']
    if not np.isnan(recording.arm_torque).all():
        names.append('arm_torque')
    return {name: getattr(recording, name) for name in names}


def _estimated(estimates: Estimates) -> Columns:
    table = {'stamp_ns': estimates.stamp_ns, **{name: getattr(estimates, name)
                                                for name in COLUMNS}}
    i, j = match_stamps(estimates.stamp_ns, estimates.smoothed_stamp_ns)
    for name in SMOOTHED_COLUMNS:
        table[name] = np.full(len(estimates.stamp_ns), np.nan)
        table[name][i] = getattr(estimates, name)[j]
    return table


def _windows(windows: BacklashWindows) -> Columns:
    names = (*(name + std for name in MEASURED for std in ('', '_std')), 'separable')
    usual = dict.fromkeys(names, np.nan) | {'separable': False}
    return {'end': windows.ends, **{
        name: [getattr(fit, name, usual[name]) for fit in windows.fits] for name in names},
        'reason': [str(fit.said) if isinstance(fit, NotExcited) else ''
                   for fit in windows.fits]}


def _adapted(adapted: Adapted) -> Columns:
    fitted = adapted.fit.values if adapted.fit else ()
    rows: list[tuple[Any, ...]] = [(v.name, v.start, v.value, v.error) for v in fitted]
    rows += [(name, *pair, None) for name, pair in adapted.tolerances.items()]
    rows += [(name, getattr(adapted.estimator, name), value, None)
             for name, value in adapted.parameters.items()]
    return _by_name(rows, 'name', 'before', 'value', 'error')


def _by_name(rows: Iterable[tuple[Any, ...]], *names: str) -> Columns:
    listed = list(rows)
    return {name: [row[k] for row in listed] for k, name in enumerate(names)}


TABLES: dict[type, Callable[[Any], Columns]] = {
    DriveRecording: _recorded, Estimates: _estimated, BacklashWindows: _windows,
    Adapted: _adapted,
    RecordingEstimates: lambda estimates: {'t': estimates.t, **_estimated(estimates)},
    Diagnosis: lambda diagnosis: _by_name(
        ((f.effect, f.joint or f.link or f.place, name, value, f.deviations.get(name), f.share)
         for f in diagnosis.findings for name, value in f.values.items()),
        'effect', 'place', 'parameter', 'value', 'deviation', 'share'),
    NominalFit: lambda fit: {name: [getattr(v, name) for v in fit.values] for name in (
        'name', 'unit', 'start', 'value', 'error', 'determined')},
    TunedParameters: lambda tuned: _by_name(
        ((name, getattr(tuned.before, name), value, tuned.errors[name])
         for name, value in tuned.values.items()), 'parameter', 'before', 'value',
        'relative_error'),
    ParameterRanges: lambda ranges: {
        'name': ranges.names, 'unit': ranges.units, 'low': ranges.low, 'median': ranges.centre,
        'high': ranges.high, 'between': ranges.between},
    SimulatorFile: lambda file: _by_name(
        ((c.element, c.attribute, c.before, c.after) for c in file.patch.changes),
        'element', 'attribute', 'before', 'after'),
    ReportPages: lambda pages: _by_name(pages.pages.items() or [('', pages.page)], 'gearbox',
                                        'page'),
    Watch: lambda watch: _by_name(
        ((j.name, s.kind, s.size, s.std, s.judged) for j in watch.joints for s in j.states),
        'joint', 'state', 'size', 'deviation', 'judged')}


def frame(result: Any) -> Any:
    """Return the table of the `result` as a pandas DataFrame. Raises InputError without pandas."""
    try:
        import pandas as pd
    except ImportError:
        raise InputError('to_frame: pandas is not installed, expected '
                         f'{installed_by("frames")}') from None
    return pd.DataFrame(dict(columns(result)))


def html(result: Any) -> str:
    """Return words and table of the `result` as HTML, and its page, for a notebook."""
    table = columns(result)
    names = [name for name in table if not isinstance(result, Estimates) or name in (
        't', 'stamp_ns', 'tau_k', 'tau_k_std', 'twist', 'nis')]
    count = len(next(iter(table.values()), ()))
    rows = [''.join(f'<td>{escape(_cell(table[name][k]))}</td>' for name in names)
            for k in range(min(count, ROWS))]
    body = ''.join(f'<tr>{row}</tr>' for row in rows)
    head = ''.join(f'<th>{escape(name)}</th>' for name in names)
    footer = f'<p>{count} rows</p>' if count > ROWS else ''
    text = '<br>'.join(escape(line) for line in words(result).splitlines())
    pages = (PAGES[kind](result) for kind in type(result).__mro__ if kind in PAGES)
    framed = ''.join(f'<iframe srcdoc="{escape(page)}" style="width:100%;height:40em;border:0">'
                     '</iframe>' for page in islice(pages, 1))
    return f'<p>{text}</p><table><tr>{head}</tr>{body}</table>{footer}{framed}'


def _cell(value: Any) -> str:
    if value is None or isinstance(value, (float, np.floating)):
        return number(None if value is None else float(value))
    return str(value)


def _rms(value: Any) -> float:
    return float(np.sqrt(np.nanmean(np.square(value))))


# ---------------------------------------------------------------------- pages and files

def page(result: Any) -> str:
    """Return the page of the `result` as HTML."""
    return _entry(PAGES, result)(result)


def _charts_page(title: str, answer: Section, axis: str, charts: Iterable[Drawing | None]
                 ) -> str:
    parts = [Section('recording/loops.html', {'plane': chart}, chart.title)
             if isinstance(chart, Plane) else
             Section('recording/chart.html', {'chart': replace(chart, title='')}, chart.title)
             for chart in charts if chart is not None]
    return render_page(Page(title, answer, parts, axis))


def _recorded_page(recording: DriveRecording) -> str:
    axis = recording.model.axis
    driving = 'torque' if recording.model.controller is None else 'setpoint'
    unit = on_axis('N m' if driving == 'torque' else 'rad', axis)
    answer = page_summary('', sentence(_recorded_in_brief(recording)))
    return _charts_page(recording.name, answer, axis, [Chart('Signals', [
        Panel(f'{driving} ({unit})', [
            Trace(recording.t, getattr(recording, driving), driving, 'recording')]),
        Panel(on_axis('position (rad)', axis), [
            Trace(recording.t, recording.motor, 'motor', 'closed'),
            Trace(recording.t, recording.arm, 'arm', 'signal')])], 'time (s)')])


def _estimated_page(estimates: RecordingEstimates) -> str:
    recording = estimates.recording
    line = timeline_of(estimates, estimates.backlash, estimates.outcomes['backlash'].values,
                       estimates.parameters)
    states = raised(State.of(*named) for named in estimates.outcomes.items())
    answer = page_summary(ROLES[states[0].level], sentence(states[0].first)) if states else \
        page_summary('', sentence(f'estimates: {_estimated_in_brief(estimates)}'))
    return _charts_page(recording.name, answer, recording.model.axis,
                        overview(line, recording.model.axis))


def _windows_page(windows: BacklashWindows) -> str:
    line, stamps = Timeline(1.0), windows.recording.stamp_ns
    line.add_inputs(stamps, np.full(len(stamps), np.nan))
    for fit in windows.fits:
        if isinstance(fit, Backlash):
            line.add_window(fit.stamp_ns, measured(fit, {}))
    axis = windows.model.axis
    answer = page_summary('', sentence(_windows_in_brief(windows)))
    return _charts_page(windows.recording.name, answer, axis, [backlash_chart(line, axis)])


PAGES: dict[type, Callable[[Any], str]] = {
    DriveRecording: _recorded_page, RecordingEstimates: _estimated_page,
    BacklashWindows: _windows_page,
    Diagnosis: lambda diagnosis: diagnosis_page(diagnosis.data, diagnosis.context())}


def write_page(result: Any, path: str | Path) -> Path:
    """
    Write the page of a result to a new file. Raises InputError.

    Args:
        result: that has a page.
        path: of the file.
    """
    return write_new(expect_path(path, 'path', 'a new file'), page(result))


def save(result: Any, path: str | Path) -> Path:
    """
    Write the `result` to a new file, and return that. Raises InputError.

    Args:
        result: that a file can hold.
        path: of the file.
    """
    _entry(WRITERS, result)(result, path)
    return Path(path)


def _write_closed(diagnosis: Diagnosis, path: str | Path) -> None:
    if diagnosis.file_text is None:
        raise InputError(f'{path}: the file of the robot can hold no finding, expected one')
    write_new(path, diagnosis.file_text)


WRITERS: dict[type, Callable[[Any, str | Path], object]] = {
    DriveModel: lambda model, path: save_model(
        path, expect_model(model), [f'Written by gearbox_monitor {__version__}.']),
    TunedParameters: lambda tuned, path: write_parameters(
        path, tuned.before, ('', {}), tuned.figures),
    ParameterRanges: lambda ranges, path: write_new(path, ranges_yaml(ranges)),
    Adapted: lambda adapted, path: write_adapted(path, adapted, 'recordings'),
    SimulatorFile: lambda file, path: write_new(path, file.text),
    Watch: lambda watch, path: save_watch(path, watch), Diagnosis: _write_closed}


def _entry(views: Mapping[type, Entry], result: Any) -> Entry:
    """Return the entry of the type of `result`, or of the nearest one above it."""
    return next(views[kind] for kind in type(result).__mro__ if kind in views)
