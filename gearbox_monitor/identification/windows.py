# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free runs of a model over windows of 1 s, each recording with its own encoders.

A window begins in the smoothed states of the filter, refined to fit the window: a drive that
sticks and slips forgets nothing, so that its best initial state is not found from afar. No value
of the model moves here; the misfit of these runs is what a simulator user sees.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.identification import window_data, window_states
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.shooting import shooting_windows, ShootingWindows
from gearbox_monitor.identification.torque_domain import simulator
from gearbox_monitor.identification.window_data import FitPoint, WindowData
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MAX_SETPOINT_DELAY
from gearbox_monitor.quality.recording import UniformRecording

SECONDS = 1.0  # of a window
# s, after which what was commanded before a recording has acted: dead times of up to half of it,
# lags of a tenth of it down to 5e-5
SETTLING = 2.0 * MAX_SETPOINT_DELAY
BEGINNING = 0.1  # s, whose median is where a recording begins
MOVED = 6.0      # deviations of noise: one reading in 5e8 of a drive at rest
LESS_CERTAIN = 5.0  # times their deviation: states in which a filter begins
HELD_OUT = 0.3  # share of the windows of each recording, its last ones


@dataclass(frozen=True, eq=False)
class Segment:
    """
    One recording, cut into windows: what is evidence, what is held out.

    data: its windows; span: samples that are evidence; unseen: first sample that is held out.
    """

    data: WindowData
    span: slice
    unseen: int

    @property
    def recording(self) -> UniformRecording:
        """The recording."""
        return self.data.recording

    @property
    def training(self) -> slice:
        """Samples before those that are held out."""
        return slice(self.span.start, self.unseen)

    @property
    def held_out(self) -> slice:
        """Samples that are held out."""
        return slice(self.unseen, self.span.stop)


def seconds_at_rest(recording: UniformRecording, sigma: Array) -> float:
    """
    Return how long it takes until a reading has moved beyond noise, s; 0 if none ever does.

    Args:
        recording: of one drive.
        sigma: noise of the encoders [2], rad.
    """
    channels = list(recording.channels)
    y = recording.y[:, channels]
    begin = np.median(y[:max(round(BEGINNING / recording.dt), 1)], axis=0)
    moved = (np.abs(y - begin) > MOVED * sigma[channels]).any(axis=1)
    return float(moved.argmax() * recording.dt) if moved.any() else 0.0


def segment_of(recording: UniformRecording, model: DriveModel, sigma: Array,
               colour: Array | None = None, settling: float = SETTLING,
               finer: int = 1, seconds: float = SECONDS) -> Segment:
    """
    Return a recording as a Segment.

    Args:
        recording: of one drive.
        model: its nominal model.
        sigma: noise of the encoders [2], rad.
        colour: correlation of neighbouring readings of each encoder [2], None: white.
        settling: s at the beginning that no window reads.
        finer: how many times as many steps the model takes as the nominal drive asks for.
        seconds: length of the windows, s; of longer ones than SECONDS, which free states would fit
            by many deviations, they are fixed.
    """
    windows = shooting_windows(recording, min(seconds, recording.duration), settling)
    train = np.ones(len(windows), bool)
    held_out = round(HELD_OUT * len(windows))
    stop = len(recording.u)
    unseen = stop
    if held_out:
        train[-held_out:] = False
        unseen = int(windows.first[-held_out])
    data = WindowData(recording, simulator(recording, model, finer), windows,
                      np.asarray(sigma, float), train, colour, seconds > SECONDS)
    return Segment(data, slice(int(windows.begin[0]), stop), unseen)


@dataclass(frozen=True, eq=False)
class WindowRuns:
    """
    Free runs of one model over the windows of one recording.

    data: the windows; candidate: the model, at the coordinates of point; smooth [N, N_STATE]:
    smoothed states of the filter in which windows began, None where there is no filter.
    """

    data: WindowData
    candidate: CandidateModel
    point: FitPoint
    smooth: Array | None = None

    @property
    def model(self) -> DriveModel:
        """The model of the runs."""
        return self.candidate.model(self.point.z)

    @property
    def recording(self) -> UniformRecording:
        """The recording."""
        return self.data.recording

    @property
    def chi2(self) -> Array:
        """chi2 [W] of the windows."""
        return self.point.chi2

    @property
    def residual(self) -> Array:
        """Readings less runs [W, L, C], in standard deviations."""
        return self.data.parted(self.point.residual)


def free_runs(segment: Segment, candidate: CandidateModel, z: Array,
              smooth: Array) -> WindowRuns:
    """
    Return free runs of a model over the windows of one recording.

    The states where they begin are fitted on the beginnings of the windows first, which get
    longer.

    Args:
        segment: windows of the recording.
        candidate: model with its coordinates.
        z: coordinates [P].
        smooth: smoothed states [N, N_STATE].
    """
    return WindowRuns(segment.data, candidate,
                      smoothed_point(segment.data, candidate, z, smooth), smooth)


def smoothed_point(data: WindowData, candidate: CandidateModel, z: Array,
                   smooth: Array) -> FitPoint:
    """
    Return the evaluated FitPoint whose window states are fitted from smoothed ones.

    On the beginnings of the windows first, which get longer.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model with its coordinates.
        z: coordinates [P].
        smooth: smoothed states [N, N_STATE].
    """
    begun, memory = np.split(smooth[data.windows.begin], [4], axis=1)
    states, model, index = begun, candidate.model(z), np.arange(len(data.windows))
    for share in window_states.SHARES:
        states, chi2 = window_states.solve_states(
            window_data.shortened(data, share), model, states, memory, index)
    if len(data.channels) == 1:
        # The beginning of a window says little of a side that no encoder reads.
        whole, at_once = window_states.solve_states(data, model, begun, memory, index)
        states = np.where((at_once < chi2)[:, None], whole, states)
    return data.evaluate(candidate, FitPoint(z, states, memory))


def hidden_begins(likelihood: InnovationLikelihood, candidate: CandidateModel, z: Array,
                  sigma: Array) -> InnovationLikelihood:
    """
    Return a likelihood whose parts begin in the states that fit their first second best.

    With one encoder, the beginning says little of the other side: a filter that begins on the
    wrong flank of the gap does not return without torque noise. Free runs tell the flank. As these
    readings count again in the filter, the states are taken as less certain than they are.

    Args:
        likelihood: of a recording with one encoder.
        candidate: model with its coordinates.
        z: coordinates [P].
        sigma: noise of the encoders [2], rad.
    """
    recording, model = likelihood.recording, candidate.model(z)
    length = min(round(SECONDS / recording.dt), int((likelihood.end - likelihood.begin).min()) - 1)
    begin = likelihood.begin
    data = WindowData(recording, likelihood.simulator, ShootingWindows(
        begin, length, begin, begin + length), sigma, np.ones(len(begin), bool))
    smooth = likelihood.smoothed(likelihood.run(model, likelihood.first_noise))
    point = smoothed_point(data, candidate, z, smooth)
    point = window_states.rescue(data, candidate, point,
                                 max(model.transmission.half_gap, 0.01))
    J = window_data.state_sensitivity(data, model, point.states, point.memory, point.residual)
    A = np.einsum('wli,wlj->wij', J, J)
    # What nothing tells stays as uncertain as it was.
    A[:, range(4), range(4)] += 1.0 / np.maximum(likelihood.begin_variance, 1e-300)
    # A model that misses the readings knows as much less of the states.
    misfit = np.maximum(point.chi2 / data.size, 1.0)
    variance = (misfit[:, None] * np.diagonal(np.linalg.inv(A), axis1=1, axis2=2)).max(axis=0)
    return likelihood.begun(point.states, LESS_CERTAIN * np.sqrt(variance))


def misfit_of(runs: Sequence[WindowRuns], held_out: bool = False) -> float:
    """
    Return the root mean square of free runs against the readings, in sigmas; 1 is the floor.

    Args:
        runs: of each recording.
        held_out: whether only windows that are held out count; all where none is.
    """
    held_out = held_out and any((~run.data.train).any() for run in runs)
    chi2, readings = 0.0, 0
    for run in runs:
        use = ~run.data.train if held_out else np.ones_like(run.data.train)
        chi2 += float(run.chi2[use].sum())
        readings += int(use.sum()) * run.data.size
    return math.sqrt(chi2 / max(readings, 1))


def typical_misfit(runs: Sequence[WindowRuns]) -> float:
    """Return the median misfit of windows of `runs`, sigmas: a burst or bad start counts less."""
    return math.sqrt(float(np.median(np.concatenate([
        run.chi2 / run.data.size for run in runs]))))
