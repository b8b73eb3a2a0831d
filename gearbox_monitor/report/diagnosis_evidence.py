# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Evidence of a diagnosis: residuals binned over the motion, charts of models over a recording.

edges: of the bins of an axis.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.diagnosis.joint.closed_model import Overlay, overlay
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.chart import Chart, Panel, Trace
from gearbox_monitor.report.words import unit_of
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
        Arrays that the page and the pictures show.

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
