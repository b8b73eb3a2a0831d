# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free runs of a model over windows of 1 s, each recording with its own encoders.

A window begins in the smoothed states of the filter, refined to fit the window: a drive that
sticks and slips forgets nothing, so that its best initial state is not found from afar. No value
of the model moves here; the misfit of these runs is what a simulator user sees.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.innovations import InnovationLikelihood
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows
from gearbox_monitor.diagnosis.joint.window_data import SECONDS, WindowData
from gearbox_monitor.diagnosis.joint.window_states import SHARES, solve_states, StateProblems
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.recording import UniformRecording

LESS_CERTAIN = 5.0  # times their deviation: states in which a filter begins
FASTER = (-1.5, 0.0, 1.5)  # rad/s by which an arm may be faster than its motor, in the gap
FLANKS = (-1.0, 0.0, 1.0)
LEAST_GAP = 0.01    # rad, half of the gap in which a hidden side may be at least


@dataclass(frozen=True, eq=False)
class WindowRuns:
    """
    Free runs of one model over the windows of one recording.

    data: the windows; states, memory [W, 4]: where they begin; residual: readings less runs
    [W, L, C], in standard deviations.
    """

    data: WindowData
    model: DriveModel
    states: Array
    memory: Array
    residual: Array

    @property
    def recording(self) -> UniformRecording:
        """The recording."""
        return self.data.recording

    @cached_property
    def chi2(self) -> Array:
        """chi2 [W] of the windows."""
        return np.einsum('wlc,wlc->w', self.residual, self.residual)

    @property
    def positions(self) -> Array:
        """Positions of motor and arm [N, 2], rad: as measured, else as the model has them."""
        data, recording = self.data, self.recording
        positions = recording.positions.copy()
        hidden = [i for i in (0, 1) if i not in data.channels]
        if hidden and recording.motor is None:
            y, _ = data.simulator.run(data.windows, self.model, self.states, self.memory)
            for first, rows in zip(data.windows.first, y):
                positions[first:first + len(rows), hidden] = rows[:, hidden]
        return positions

    def take(self, index: Integers) -> 'WindowRuns':
        """Return the runs of the windows `index` alone."""
        data = replace(self.data, windows=self.data.windows.take(index),
                       held_out=self.data.held_out[index])
        return replace(self, data=data, states=self.states[index], memory=self.memory[index],
                       residual=self.residual[index])


def runs_from(data: WindowData, model: DriveModel, states: Array, memory: Array) -> WindowRuns:
    """
    Return the free runs of a model from given states.

    Args:
        data: windows of the recording.
        model: model of the drive.
        states: states of the drive where the windows start [W, 4].
        memory: memories of the effects there [W, 4].
    """
    return WindowRuns(data, model, states, memory, data.residual(model, states, memory))


def free_runs(data: WindowData, model: DriveModel, smooth: Array) -> WindowRuns:
    """
    Return free runs of a model over the windows of one recording, from fitted states.

    Args:
        data: windows of the recording.
        model: model of the drive.
        smooth: smoothed states [N, N_STATE].
    """
    begun, memory = np.split(smooth[data.windows.begin], [4], axis=1)
    return runs_from(data, model, _grown(data, model, begun, memory)[0], memory)


def _grown(data: WindowData, model: DriveModel, begun: Array,
           memory: Array) -> tuple[Array, Array]:
    """Return (states [W, 4], chi2 [W]), fitted on beginnings of the windows, which get longer."""
    states = begun
    for share in SHARES:
        length = round(share * data.windows.length)
        states, chi2 = solve_states(replace(data, windows=replace(
            data.windows, length=max(length, min(8, data.windows.length)))), model, states, memory)
    if len(data.channels) == 1:
        # The beginning of a window says little of a side that no encoder reads.
        whole, at_once = solve_states(data, model, begun, memory)
        states = np.where((at_once < chi2)[:, None], whole, states)
        chi2 = np.minimum(at_once, chi2)
    return states, chi2


def hidden_begins(likelihood: InnovationLikelihood, model: DriveModel,
                  sigma: Array) -> InnovationLikelihood:
    """
    Return a likelihood whose parts begin in the states that fit their first second best.

    With one encoder, the beginning says little of the other side: a filter that begins on the
    wrong flank of the gap does not return without torque noise. Free runs tell the flank: they
    begin on either one and between them, faster and slower. As these readings count again in the
    filter, the states are taken as less certain than they are.

    Args:
        likelihood: of a recording with one encoder.
        model: of the drive.
        sigma: noise of the encoders [2], rad.
    """
    recording = likelihood.recording
    length = min(round(SECONDS / recording.dt), int((likelihood.end - likelihood.begin).min()) - 1)
    smooth = likelihood.smoothed(likelihood.run(model, likelihood.first_noise))
    begun, memory = np.split(smooth[likelihood.begin], [4], axis=1)
    starts, read = [begun], recording.channels[0]
    for flank in FLANKS:
        for faster in FASTER:
            moved = begun.copy()
            moved[:, 1 - read] = begun[:, read] + flank * max(
                model.transmission.half_gap, LEAST_GAP)
            moved[:, 3 - read] = begun[:, 2 + read] + faster
            starts.append(moved)
    first = np.tile(likelihood.begin, len(starts))
    data = WindowData(recording, likelihood.simulator, ShootingWindows(first, length, first),
                      sigma, np.zeros(len(first), bool))
    memory = np.tile(memory, (len(starts), 1))
    tried, chi2 = _grown(data, model, np.concatenate(starts), memory)
    parts = np.arange(len(begun))
    likeliest = chi2.reshape(-1, len(begun)).argmin(axis=0) * len(begun) + parts
    problems = StateProblems(data, model, memory)
    residual, chi2 = problems.evaluated(tried[likeliest], likeliest)
    A, _ = problems.linearised(tried[likeliest], residual, likeliest)
    # What nothing tells stays as uncertain as it was.
    A[:, range(4), range(4)] += 1.0 / np.maximum(likelihood.begin_variance, 1e-300)
    # A model that misses the readings knows as much less of the states.
    misfit = np.maximum(chi2 / data.size, 1.0)
    variance = (misfit[:, None] * np.diagonal(np.linalg.inv(A), axis1=1, axis2=2)).max(axis=0)
    return likelihood.begun(tried[likeliest], LESS_CERTAIN * np.sqrt(variance))


def misfit_of(runs: Sequence[WindowRuns], held_out: bool = False) -> float:
    """
    Return the root mean square of free runs against the readings, in sigmas; 1 is the floor.

    Args:
        runs: of each recording.
        held_out: whether only windows that are held out count; all where none is.
    """
    held_out = held_out and any(run.data.held_out.any() for run in runs)
    chi2, readings = 0.0, 0
    for run in runs:
        use = run.data.held_out | (not held_out)
        chi2 += float(run.chi2[use].sum())
        readings += int(use.sum()) * run.data.size
    return math.sqrt(chi2 / max(readings, 1))


def typical_misfit(runs: Sequence[WindowRuns]) -> float:
    """Return the median misfit of windows of `runs`, sigmas: a burst or bad start counts less."""
    return math.sqrt(float(np.median(np.concatenate([
        run.chi2 / run.data.size for run in runs]))))
