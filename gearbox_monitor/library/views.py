# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What results show: a line, words, a table, a picture, a page, a file; one entry per result."""
from collections.abc import Callable, Iterable, Mapping
from functools import singledispatch
from html import escape
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.diagnosis.joint.nominal import NominalFit
from gearbox_monitor.diagnosis.joint.parameter_ranges import ParameterRanges
from gearbox_monitor.diagnosis.joint.unit_adaptation import Adapted
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.errors import expect_matplotlib, InputError, installed_by
from gearbox_monitor.estimation.estimates import COLUMNS, Estimates, SMOOTHED_COLUMNS
from gearbox_monitor.files.opening import plain, write_new
from gearbox_monitor.files.watch_file import save_watch
from gearbox_monitor.files.yaml_files import save_model, write_parameters
from gearbox_monitor.library.estimation import BacklashWindows, RecordingEstimates
from gearbox_monitor.library.identify import TunedParameters, write_adapted
from gearbox_monitor.library.recording import DriveRecording
from gearbox_monitor.library.recording_report import ReportPages
from gearbox_monitor.library.robot import RobotDiagnosis
from gearbox_monitor.library.simulator_file import expect_path, SimulatorFile
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.recordings.joint_input import match_stamps
from gearbox_monitor.report.diagnosis_evidence import gather
from gearbox_monitor.report.diagnosis_page import diagnosis_page
from gearbox_monitor.report.robot_gap_page import robot_gap_page
from gearbox_monitor.report.robot_words import robot_text
from gearbox_monitor.report.summary import summary
from gearbox_monitor.report.watch_words import watch_headline, watch_text
from gearbox_monitor.report.words import number, value_rows, value_text, width_and_std
from gearbox_monitor.simulators.randomisation import randomisation
from gearbox_monitor.watch.record import Watch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROWS = 10  # of a long table in a notebook
Columns = Mapping[str, Any]  # {name: values [N]}


# ---------------------------------------------------------------------- a line, and words

@singledispatch
def brief(result: Any) -> str:
    """Return the `result` in one line, as repr shows it."""
    raise NotImplementedError(type(result))


# Lines that follow the first one, of results whose words are their brief and these.
REMARKS: dict[type, Callable[[Any], Iterable[str]]] = {
    DriveRecording: lambda r: _notes(r.notes), TunedParameters: lambda t: _notes(t.notes),
    ParameterRanges: lambda r: [*map(str, r.combinations), *_notes(r.notes)],
    Adapted: lambda a: [f'open: {sentence}' for sentence in a.open],
    SimulatorFile: lambda f: [*(f'{row.id}: {row.kind}: {row.words}' for row in f.exported),
                              *f.notes]}


@singledispatch
def words(result: Any) -> str:
    """Return the `result` in some lines, as print shows it."""
    return '\n'.join([brief(result), *REMARKS.get(type(result), lambda _: ())(result)])


def _notes(notes: Iterable[str]) -> list[str]:
    return [f'note: {note}' for note in notes]


@brief.register
def _(recording: DriveRecording) -> str:
    driving = 'torque' if recording.model.controller is None else 'setpoint'
    measured = [name for name in (driving, 'motor', 'arm', 'arm_torque')
                if not np.isnan(getattr(recording, name)).all()]
    return (f'Recording({recording.name!r}: {len(recording)} samples, '
            f'{recording.duration:.2f} s, {recording.rate:.4g} Hz; {", ".join(measured)})')


@brief.register
def _(estimates: Estimates) -> str:
    n = len(estimates.stamp_ns)
    span = (estimates.stamp_ns.max() - estimates.stamp_ns.min()) * 1e-9 if n else 0.0
    rms = f'; tau_k {_rms(estimates.tau_k):.3g} N m rms' if n else ''
    return f'{type(estimates).__name__}({n} in {span:.2f} s{rms})'


@words.register
def _(estimates: RecordingEstimates) -> str:
    lines = [f'{estimates.recording.name}: {brief(estimates)}']
    if estimates.backlash:
        newest = estimates.backlash[-1]
        unit = on_axis('rad', estimates.recording.model.axis)
        lines.append(f'gap {width_and_std(newest.gap, newest.gap_std, unit)} in the newest of '
                     f'{len(estimates.backlash)} windows')
    lines += [f'{name}: {outcome.level.name}: {outcome.message}'
              for name, outcome in estimates.outcomes.items()]
    return '\n'.join([*lines, *_notes(estimates.notes)])


@brief.register
def _(windows: BacklashWindows) -> str:
    unit, gap, lost = on_axis('rad', windows.model.axis), windows.gap, windows.lost_motion
    if gap is None:
        text = windows.reason
    elif windows.separable or lost is None:
        text = f'gap {width_and_std(gap.value, gap.std, unit)}'
    else:
        text = (f'lost motion {width_and_std(lost.value, lost.std, unit)}, gap and compliance '
                'are not separable')
    return f'BacklashWindows({windows.recording.name!r}: {len(windows.fits)} windows; {text})'


@brief.register
def _(verdict: Verdict) -> str:
    text = verdict.effect or verdict.location
    closed = verdict.closed_fraction
    return (f'Verdict({verdict.verdict!r}' + ('' if verdict.verdict == 'none' else f': {text}')
            + f'; gap {number(verdict.gap_before)} before, {number(verdict.gap_after)} after'
            + ('' if closed is None else f', {100 * closed:.1f} % closed') + ')')


@words.register
def _(verdict: Verdict) -> str:
    data, axis = plain(verdict.to_dict()), verdict.basis.model.axis
    return '\n'.join([summary(data, axis), *(
        f'{row[0]} {value_text(row)}' for row in value_rows(data, axis)),
        f'gap {number(verdict.gap_before)} before, {number(verdict.gap_after)} after, in standard '
        'deviations of the noise; 1 is the floor', *_notes(verdict.warnings)])


@brief.register
def _(fit: NominalFit) -> str:
    start = '' if fit.gap_before is None else f'{fit.gap_before:.4g} -> '
    values = ', '.join(f'{v.name} {v.value:.4g}' for v in fit.values if v.determined)
    return f'NominalFit({values or "no value determined"}; gap {start}{fit.gap_after:.4g})'


@brief.register
def _(tuned: TunedParameters) -> str:
    values = ', '.join(f'{name} {value:.4g}' for name, value in tuned.values.items()
                       if not isinstance(value, str))
    note = '; nothing is more likely than those before' if tuned.kept else ''
    return f'TunedParameters({tuned.parameters.filter}: {values}{note})'


@brief.register
def _(adapted: Adapted) -> str:
    fitted = brief(adapted.fit) if adapted.fit else 'no value identified'
    return f'Adapted({"values before kept" if adapted.kept else fitted})'


@brief.register
def _(ranges: ParameterRanges) -> str:
    rows = ', '.join(f'{name} {low:.4g} to {high:.4g}' for name, low, high in zip(
        ranges.names, ranges.low, ranges.high))
    return f'ParameterRanges({rows})'


@brief.register
def _(file: SimulatorFile) -> str:
    lacking = ', '.join(row.id for row in file.lacking)
    return (f'SimulatorFile({file.to}: changes in {file.into}'
            + (f'; lacking {lacking}' if lacking else '') + ')')


@brief.register
def _(diagnosis: RobotDiagnosis) -> str:
    causes = ', '.join(f'{f.effect} at {f.joint or f.link}' for f in diagnosis.findings)
    return f'RobotDiagnosis({diagnosis.kind!r}' + (f': {causes})' if causes else ')')


@words.register
def _(diagnosis: RobotDiagnosis) -> str:
    return robot_text(diagnosis.data)


@brief.register
def _(watch: Watch) -> str:
    return f'Watch({watch.phase!r}: {watch_headline(watch)})'


@words.register
def _(watch: Watch) -> str:
    return watch_text(watch)


@brief.register
def _(pages: ReportPages) -> str:
    return f'ReportPages({pages.page}: {pages.extent})'


@words.register
def _(pages: ReportPages) -> str:
    return f'{pages.headline}\n{pages.page}: {pages.extent}'


# ---------------------------------------------------------------------- tables

@singledispatch
def columns(result: Any) -> Columns:
    """Return the `result` as a table, {name: values [N]}."""
    raise NotImplementedError(type(result))


@columns.register
def _(recording: DriveRecording) -> Columns:
    names = ['t', 'torque' if recording.model.controller is None else 'setpoint', 'motor', 'arm']
    if not np.isnan(recording.arm_torque).all():
        names.append('arm_torque')
    return {name: getattr(recording, name) for name in names}


@columns.register
def _(estimates: Estimates) -> Columns:
    table = {'stamp_ns': estimates.stamp_ns, **{name: getattr(estimates, name)
                                                for name in COLUMNS}}
    i, j = match_stamps(estimates.stamp_ns, estimates.smoothed_stamp_ns)
    for name in SMOOTHED_COLUMNS:
        table[name] = np.full(len(estimates.stamp_ns), np.nan)
        table[name][i] = getattr(estimates, name)[j]
    return table


@columns.register
def _(estimates: RecordingEstimates) -> Columns:
    return {'t': estimates.t, **columns.dispatch(Estimates)(estimates)}


@columns.register
def _(windows: BacklashWindows) -> Columns:
    names = ('gap', 'gap_std', 'stiffness', 'stiffness_std', 'hysteresis', 'hysteresis_std',
             'lost_motion', 'lost_motion_std', 'separable', 'reason')
    usual = dict.fromkeys(names, np.nan) | {'separable': False, 'reason': ''}
    return {'end': windows.ends, **{
        name: [getattr(fit, name, usual[name]) for fit in windows.fits] for name in names}}


@columns.register
def _(verdict: Verdict) -> Columns:
    rows = [(f.effect, f.place, name, value, f.deviations.get(name), f.share)
            for f in verdict.findings for name, value in f.values.items()]
    return _by_name(rows, ('effect', 'place', 'parameter', 'value', 'deviation', 'share'))


@columns.register
def _(fit: NominalFit) -> Columns:
    names = ('name', 'unit', 'start', 'value', 'error', 'determined')
    return {name: [getattr(v, name) for v in fit.values] for name in names}


@columns.register
def _(tuned: TunedParameters) -> Columns:
    rows = [(name, getattr(tuned.before, name), value, tuned.errors[name])
            for name, value in tuned.values.items()]
    return _by_name(rows, ('parameter', 'before', 'value', 'relative_error'))


@columns.register
def _(ranges: ParameterRanges) -> Columns:
    return {'name': ranges.names, 'unit': ranges.units, 'low': ranges.low,
            'median': ranges.centre, 'high': ranges.high, 'between': ranges.between}


@columns.register
def _(adapted: Adapted) -> Columns:
    fitted = adapted.fit.values if adapted.fit else ()
    rows: list[tuple[Any, ...]] = [(v.name, v.start, v.value, v.error) for v in fitted]
    rows += [(name, *pair, None) for name, pair in adapted.tolerances.items()]
    rows += [(name, getattr(adapted.estimator, name), value, None)
             for name, value in adapted.parameters.items()]
    return _by_name(rows, ('name', 'before', 'value', 'error'))


@columns.register
def _(file: SimulatorFile) -> Columns:
    rows = [(c.element, c.attribute, c.before, c.after) for c in file.patch.changes]
    return _by_name(rows, ('element', 'attribute', 'before', 'after'))


@columns.register
def _(diagnosis: RobotDiagnosis) -> Columns:
    rows = [(f.effect, f.joint or f.link, name, value, f.deviations.get(name))
            for f in diagnosis.findings for name, value in f.values.items()]
    return _by_name(rows, ('effect', 'at', 'parameter', 'value', 'deviation'))


@columns.register
def _(watch: Watch) -> Columns:
    rows = [(j.name, s.kind, s.size, s.std, s.judged) for j in watch.joints for s in j.states]
    return _by_name(rows, ('joint', 'state', 'size', 'deviation', 'judged'))


@columns.register
def _(pages: ReportPages) -> Columns:
    rows = list(pages.pages.items()) or [('', pages.page)]
    return _by_name(rows, ('gearbox', 'page'))


def frame(result: Any) -> Any:
    """Return the table of the `result` as a pandas DataFrame. Raises InputError without pandas."""
    try:
        import pandas as pd
    except ImportError:
        raise InputError('to_frame: pandas is not installed, expected '
                         f'{installed_by("frames")}') from None
    return pd.DataFrame(dict(columns(result)))


def html(result: Any) -> str:
    """Return words and table of the `result` as HTML, for a notebook."""
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
    return f'<p>{text}</p><table><tr>{head}</tr>{body}</table>{footer}'


def _cell(value: Any) -> str:
    if value is None or isinstance(value, (float, np.floating)):
        return number(None if value is None else float(value))
    return str(value)


def _by_name(rows: list[tuple[Any, ...]], names: tuple[str, ...]) -> Columns:
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def _rms(value: Any) -> float:
    return float(np.sqrt(np.nanmean(np.square(value))))


# ---------------------------------------------------------------------- pictures

def figure(result: Any) -> 'Figure':
    """Return the picture of the `result`. Raises InputError without matplotlib."""
    expect_matplotlib('plot')
    from gearbox_monitor.library import pictures
    return pictures.picture(result)


# ---------------------------------------------------------------------- pages and files

@singledispatch
def page(result: Any) -> str:
    """Return the page of the `result` as HTML."""
    raise NotImplementedError(type(result))


@page.register
def _(verdict: Verdict) -> str:
    data, model = plain(verdict.to_dict()), verdict.basis.model
    return diagnosis_page({'summary': summary(data, model.axis), **data}, gather(verdict, model),
                          verdict.basis.recordings)


@page.register
def _(diagnosis: RobotDiagnosis) -> str:
    return robot_gap_page(diagnosis.data, diagnosis.robot.file.chain, diagnosis.posture)


def write_page(result: Any, path: str | Path) -> Path:
    """
    Write the page of a result to a new file. Raises InputError.

    Args:
        result: that has a page.
        path: of the file.
    """
    return write_new(expect_path(path, 'path', 'a new file'), page(result))


@singledispatch
def save(result: Any, path: str | Path) -> Path:
    """
    Write what the `result` is to a new file. Raises InputError.

    Args:
        result: that a file can hold.
        path: of the file.
    """
    raise NotImplementedError(type(result))


@save.register
def _(model: DriveModel, path: str | Path) -> Path:
    save_model(path, expect_model(model), [f'Written by gearbox_monitor {__version__}.'])
    return Path(path)


@save.register
def _(tuned: TunedParameters, path: str | Path) -> Path:
    write_parameters(path, tuned.before, ('', {}), tuned.figures)
    return Path(path)


@save.register
def _(ranges: ParameterRanges, path: str | Path) -> Path:
    return write_new(path, randomisation(ranges, 'yaml'))


@save.register
def _(adapted: Adapted, path: str | Path) -> Path:
    return write_adapted(path, adapted, 'recordings')


@save.register
def _(file: SimulatorFile, path: str | Path) -> Path:
    return write_new(path, file.text)


@save.register
def _(diagnosis: RobotDiagnosis, path: str | Path) -> Path:
    if diagnosis.closed is None:
        raise InputError(f'{path}: no finding can stand in the file of the robot, expected one')
    return write_new(path, diagnosis.closed)


@save.register
def _(watch: Watch, path: str | Path) -> Path:
    save_watch(path, watch)
    return Path(path)
