# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of results, by matplotlib."""
from functools import singledispatch
from typing import Any

from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.library.estimation import BacklashWindows, RecordingEstimates
from gearbox_monitor.library.recording import DriveRecording
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.chart import Chart, Panel, Trace
from gearbox_monitor.report.diagnosis_page import gather, window_chart
from gearbox_monitor.report.plots import figure
from gearbox_monitor.report.recording_page import backlash_chart, overview
from gearbox_monitor.report.sentences import summary
from gearbox_monitor.report.timeline import measured, Timeline, timeline_of


@singledispatch
def picture(result: Any) -> Figure:
    """Return the Figure of the `result`."""
    raise NotImplementedError(type(result))


@picture.register
def _(recording: DriveRecording) -> Figure:
    axis = recording.model.axis
    driving = 'torque' if recording.model.controller is None else 'setpoint'
    unit = on_axis('N m' if driving == 'torque' else 'rad', axis)
    return figure([[Chart(recording.name, [
        Panel(f'{driving} ({unit})', [
            Trace(recording.t, getattr(recording, driving), driving, 'recording')]),
        Panel(on_axis('position (rad)', axis), [
            Trace(recording.t, recording.motor, 'motor', 'closed'),
            Trace(recording.t, recording.arm, 'arm', 'signal')])], 'time (s)')]])


@picture.register
def _(estimates: Estimates) -> Figure:
    return figure(overview(timeline_of(estimates, (), {})), 'Estimates')


@picture.register
def _(estimates: RecordingEstimates) -> Figure:
    line = timeline_of(estimates, estimates.backlash, estimates.outcomes['backlash'].values,
                       estimates.parameters)
    recording = estimates.recording
    return figure(overview(line, recording.model.axis), recording.name)


@picture.register
def _(windows: BacklashWindows) -> Figure:
    name, line, stamps = windows.recording.name, Timeline(1.0), windows.recording.stamp_ns
    line.add_inputs(stamps, np.full(len(stamps), np.nan))
    for fit in windows.fits:
        if isinstance(fit, Backlash):
            line.add_window(fit.stamp_ns, measured(fit, {}))
    chart = backlash_chart(line, windows.model.axis)
    return figure([[chart]], name) if chart else figure([], f'{name}: {windows.reason}')


@picture.register
def _(verdict: Verdict) -> Figure:
    evidence = gather(verdict, verdict.basis.model)
    return figure([[window_chart(evidence.overlay, words, window, evidence.axis)
                    for words, window in evidence.windows]],
                  summary(verdict.to_dict(), evidence.axis))
