# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Windows of 1 s of each recording: data, states where they start, free runs and residuals.

The states are fitted by Levenberg-Marquardt; each recording has its own encoders.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.innovations import InnovationLikelihood, prewhitened
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, ShootingWindows, Simulator
from gearbox_monitor.diagnosis.joint.torque_domain import simulator
from gearbox_monitor.kernels.linear_least_squares import Damping, minimise
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MAX_SETPOINT_DELAY
from gearbox_monitor.signals.uniform import UniformRecording

WORST = 1e6    # standard deviations
SECONDS = 1.0  # of a window
# s, after which what was commanded before a recording has acted: dead times of up to half of it,
# lags of a tenth of it down to 5e-5
SETTLING = 2.0 * MAX_SETPOINT_DELAY
BEGINNING = 0.1  # s, whose median is where a recording begins
MOVED = 6.0      # deviations of noise: one reading in 5e8 of a drive at rest
HELD_OUT = 0.3   # share of the windows of each recording, its last ones


@dataclass(frozen=True, eq=False)
class WindowData:
    """
    Readings of `windows` in units of sigma [2], and how they count.

    held_out [W]: windows that no fit may see; colour [2]: see encoder_noise; fixed_states:
    whether the states where windows begin stay as they are.
    """

    recording: UniformRecording
    simulator: Simulator
    windows: ShootingWindows
    sigma: Array
    held_out: Flags
    colour: Array | None = None
    fixed_states: bool = False

    @cached_property
    def channels(self) -> list[int]:
        """Numbers of the encoders that are read."""
        return list(self.recording.channels)

    @cached_property
    def y(self) -> Array:
        """Readings of the windows [W, L, C], rad."""
        readings: Array = self.recording.y[self.windows.samples][:, :, self.channels]
        return readings

    @property
    def size(self) -> int:
        """Number of readings in a window: L samples of C encoders."""
        return self.windows.length * len(self.channels)

    @cached_property
    def overlapping(self) -> 'WindowData':
        """The same with windows half a window apart."""
        w = self.windows
        first, begin = (np.sort(np.append(x, x[:-1] + w.length // 2)) for x in (w.first, w.begin))
        return replace(self, windows=ShootingWindows(first, w.length, begin),
                       held_out=np.repeat(self.held_out, 2)[:len(first)])

    @property
    def span(self) -> slice:
        """Samples that are evidence."""
        return slice(int(self.windows.begin[0]), len(self.recording.u))

    @property
    def unseen(self) -> slice:
        """Samples that are held out."""
        first = self.windows.first[self.held_out]
        return slice(int(first[0]) if len(first) else self.span.stop, self.span.stop)

    @property
    def training(self) -> slice:
        """Samples before those that are held out."""
        return slice(self.span.start, self.unseen.start)

    def residual(self, model: DriveModel, states: Array, memory: Array,
                 index: Integers | None = None, extra: Array | None = None) -> Array:
        """
        Return the residual [M, L, C] of the windows `index` (default: all).

        Args:
            model: model of the drive.
            states: states of the drive where the windows start [M, 4].
            memory: memories of the effects where the windows start [M, 4].
            index: numbers of the windows [M]; repeats are allowed.
            extra: external torques on motor, arm and transmission, N m, [N, 3] of the recording or
                [M, R, 3] of each window, from where its run begins.
        """
        windows = self.windows if index is None else self.windows.take(index)
        y, _ = self.simulator.run(windows, model, states, memory, extra)
        measured = self.y if index is None else self.y[index]
        r: Array = (measured - y[:, :, self.channels]) / self.sigma[self.channels]
        # A run that diverges is as bad as can be, and still a number.
        return self.white(np.clip(np.nan_to_num(r, nan=WORST), -WORST, WORST), self.channels)

    def white(self, residual: Array, channels: list[int]) -> Array:
        """Return `residual` [W, L, C], in sigmas of the encoders `channels`, with white noise."""
        return residual if self.colour is None else prewhitened(residual, self.colour[channels])


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


def window_data(recording: UniformRecording, model: DriveModel, sigma: Array,
                colour: Array | None = None, settling: float = SETTLING, finer: int = 1,
                seconds: float = SECONDS) -> WindowData:
    """
    Return a recording in windows, the last of which are held out.

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
    held_out = np.arange(len(windows)) >= len(windows) - round(HELD_OUT * len(windows))
    return WindowData(recording, simulator(recording, model, finer), windows,
                      np.asarray(sigma, float), held_out, colour, seconds > SECONDS)


SHARES = (0.1, 0.2, 0.4, 0.7, 1.0)  # of the windows, on which states are found step by step
STATE_STEPS = (1e-5, 1e-5, 1e-3, 1e-3)  # rad and rad/s, of finite differences
RULE = Damping(1e-3, 20.0, largest=1e6, hopeless=1.0, absolute=1e-9)
TOLERANCE = 1e-3   # of chi2, for another step
STEPS = 6
SIDE_BY_SIDE = 64  # runs, which bounds the memory


class StateProblems:
    """
    Windows side by side as LeastSquaresProblems: their states, or what a subclass adds to them.

    steps [P]: of finite differences; known [R, P]: derivatives of -residual that need none.
    """

    known: Array | None = None

    def __init__(self, data: WindowData, model: DriveModel, memory: Array) -> None:
        self.data, self.model, self.memory = data, model, memory
        self.steps = np.array(STATE_STEPS)

    def residual(self, theta: Array, index: Integers) -> Array:
        """Return the residual [M, L, C] of the windows `index` [M] that begin in `theta`."""
        return self.data.residual(self.model, theta, self.memory[index], index)

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta` of the problems `index`."""
        residual = self.residual(theta, index).reshape(len(index), -1)
        return residual, np.einsum('wl,wl->w', residual, residual)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        J, count = np.zeros((*residual.shape, theta.shape[1])), len(index)
        free = np.arange(theta.shape[1])
        if self.known is not None:
            J[:, :, :self.known.shape[1]] = self.known
            free = free[self.known.shape[1]:]
        # Runs of several columns side by side: lanes cost little more than one run.
        lanes = max(1, SIDE_BY_SIDE // count)
        for part in np.split(free, range(lanes, len(free), lanes)):
            moved = (theta + np.diag(self.steps)[part, None]).reshape(-1, theta.shape[1])
            run = self.residual(moved, np.tile(index, len(part)))
            J[:, :, part] = ((residual - run.reshape(len(part), *residual.shape))
                             / self.steps[part, None, None]).transpose(1, 2, 0)
        return _gram(J), np.einsum('wl,wlj->wj', residual, J)


def _gram(J: Array) -> Array:
    """Return J'J [W, P, P] of J [W, M, P]."""
    # Small products: for large ones BLAS starts threads, which wait for each other on a busy
    # computer.
    size = max(1, 200000 // J.shape[2] ** 2)
    return np.sum([J[:, k:k + size].transpose(0, 2, 1) @ J[:, k:k + size]
                   for k in range(0, J.shape[1], size)], axis=0)


def solve_states(data: WindowData, model: DriveModel, states: Array,
                 memory: Array) -> tuple[Array, Array]:
    """
    Fit the states of the windows; return (states [W, 4], chi2 [W]).

    Each window has its own damping; windows that have converged wait.

    Args:
        data: windows of readings and how residuals are weighted.
        model: model of the drive.
        states: states of the drive where the windows start [W, 4].
        memory: memories of the effects where the windows start [W, 4].
    """
    problems = StateProblems(data, model, memory)
    if data.fixed_states or data.simulator.begins_known:
        return states.copy(), problems.evaluated(states, np.arange(len(states)))[1]
    states, _, chi2 = minimise(problems, states, RULE, TOLERANCE, STEPS)
    return states, chi2


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
