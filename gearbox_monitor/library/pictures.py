# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of results, by matplotlib."""
from functools import singledispatch
import textwrap
from typing import Any

from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.diagnosis.joint.nominal import NominalFit
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.library.estimation import BacklashWindows, RecordingEstimates
from gearbox_monitor.library.recording import DriveRecording, SECOND
from gearbox_monitor.library.robot import RobotDiagnosis
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report import plots
from gearbox_monitor.report.diagnosis_evidence import gather
from gearbox_monitor.report.plots import windows_figure
from gearbox_monitor.report.summary import summary

SETTLED = 1.0  # s at the start that a loop leaves out


@singledispatch
def picture(result: Any) -> Figure:
    """Return the Figure of the `result`."""
    raise NotImplementedError(type(result))


@picture.register
def _(recording: DriveRecording) -> Figure:
    axis = recording.model.axis
    driving = 'torque' if recording.model.controller is None else 'setpoint'
    sketch = Figure(figsize=(10, 5), layout='constrained')
    upper, lower = sketch.subplots(2, 1, sharex=True)
    upper.plot(recording.t, getattr(recording, driving), color=plots.BLACK, lw=0.8)
    upper.set_ylabel(f'{driving} ({on_axis("N m" if driving == "torque" else "rad", axis)})')
    for name, color in (('motor', plots.BLUE), ('arm', plots.ORANGE)):
        lower.plot(recording.t, getattr(recording, name), color=color, lw=0.8, label=name)
    lower.set_ylabel(on_axis('rad', axis))
    lower.set_xlabel('time (s)')
    lower.legend(fontsize=8)
    upper.set_title(recording.name, fontsize=10, loc='left')
    return sketch


@picture.register
def _(estimates: Estimates) -> Figure:
    first = int(estimates.stamp_ns[0]) if len(estimates.stamp_ns) else 0
    t = (estimates.stamp_ns - first) / SECOND
    smoothed_t = (estimates.smoothed_stamp_ns - first) / SECOND
    channels = [k for k, name in enumerate(('motor', 'arm'))
                if not np.isnan(getattr(estimates, f'innovation_{name}')).all()]
    settled = smoothed_t > SETTLED
    loop = [plots.Curve(estimates.smoothed_twist[settled], estimates.smoothed_tau_k[settled],
                        'smoothed')] if settled.any() and 1 in channels else []
    names = [('motor', 'arm')[k] for k in channels]
    return plots.overview(plots.RunCurves(
        estimates.recording.name if isinstance(estimates, RecordingEstimates) else 'Estimates',
        loop, plots.TorqueCurve(t, estimates.tau_k, estimates.tau_k_std),
        plots.TorqueCurve(smoothed_t, estimates.smoothed_tau_k, estimates.smoothed_tau_k_std)
        if len(smoothed_t) else None,
        backlash=_curve(estimates.backlash, first, estimates.parameters.drift_window)
        if isinstance(estimates, RecordingEstimates) and estimates.backlash else None,
        innovations=plots.Innovations(
            t, np.column_stack([getattr(estimates, f'innovation_{name}') for name in names]),
            np.column_stack([getattr(estimates, f'innovation_std_{name}') for name in names]),
            names) if names else None))


@picture.register
def _(windows: BacklashWindows) -> Figure:
    sketch = Figure(figsize=(9, 4), layout='constrained')
    fits = [fit for fit in windows.fits if isinstance(fit, Backlash)]
    axes = sketch.subplots()
    if fits:
        length = float(np.median(np.diff(windows.ends, prepend=0.0)))
        plots.draw_backlash(axes, _curve(fits, int(windows.recording.stamp_ns.min()), length),
                            windows.recording.name)
    else:
        axes.set_title(f'{windows.recording.name}: {windows.reason}', fontsize=10, loc='left')
    return sketch


def _curve(windows: Any, first: int, length: float) -> plots.BacklashCurve:
    """Return the gap of `windows` of a `length` (s) over the time from the stamp `first` on."""
    return plots.BacklashCurve(
        np.array([(fit.stamp_ns - first) / SECOND for fit in windows]),
        np.array([fit.gap for fit in windows]), np.array([fit.gap_std for fit in windows]),
        length)


@picture.register
def _(verdict: Verdict) -> Figure:
    evidence = gather(verdict, verdict.basis.model)
    title = textwrap.fill(summary(verdict.to_dict(), evidence.axis), 90)
    return windows_figure(evidence.overlay, evidence.windows, title,
                          on_axis('rad', evidence.axis))


@picture.register
def _(fit: NominalFit) -> Figure:
    sketch = Figure(figsize=(8, 0.4 * len(fit.values) + 1.5), layout='constrained')
    axes = sketch.subplots()
    for k, v in enumerate(fit.values):
        scale = abs(v.start) or abs(v.value) or 1.0
        axes.errorbar(v.value / scale, k, xerr=2.0 * v.error / scale, fmt='o', capsize=3,
                      color=plots.BLUE if v.determined else plots.GREY)
    axes.axvline(1.0, color=plots.GREY, lw=0.8, ls=':')
    axes.set_yticks(range(len(fit.values)), [v.name for v in fit.values])
    axes.set_xlabel('fitted value over that of the model, 2 standard errors; grey: not identified')
    axes.invert_yaxis()
    return sketch


@picture.register
def _(diagnosis: RobotDiagnosis) -> Figure:
    gaps = diagnosis.verdict.ranked
    sketch = Figure(figsize=(8, 0.5 * len(gaps) + 1.5), layout='constrained')
    axes = sketch.subplots()
    places = np.arange(len(gaps))
    for offset, words, color in ((-0.2, 'before', plots.RED), (0.2, 'after', plots.BLUE)):
        axes.barh(places + offset, [getattr(gap, words) for gap in gaps], 0.4, color=color,
                  label=words)
    axes.set_yticks(places, [gap.joint for gap in gaps])
    axes.set_xlabel('gap of the torque (rms in N m, of a slide in N)')
    axes.invert_yaxis()
    axes.legend(fontsize=8)
    return sketch
