# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Windows of 1 s of each recording: data, states where they start, free runs and residuals.

The states are fitted by Levenberg-Marquardt; each recording has its own encoders.

The closed model, with what was identified: how far it reduces the misfit on windows that were not
fitted, and overlays. An overlay shows free runs over windows of 1 s, and one over the whole
recording.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, Starts
from gearbox_monitor.diagnosis.joint.innovations import (
    fitted, InnovationLikelihood, JointLikelihood, noise_floor, prewhitened, spectrum, unfitted)
from gearbox_monitor.diagnosis.joint.shooting import (
    N_MEMORY, shooting_windows, ShootingWindows, Simulator)
from gearbox_monitor.diagnosis.joint.torque_domain import driven, likelihood_of, simulator
from gearbox_monitor.diagnosis.settings import STATEMENTS
from gearbox_monitor.kernels.linear_least_squares import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.batch import Begin
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


@dataclass(frozen=True, eq=False)
class WindowData:
    """
    Readings of `windows` in units of sigma [2], and how they count.

    colour [2]: see encoder_noise; fixed_states: whether the states where windows begin stay as
    they are.
    """

    recording: UniformRecording
    simulator: Simulator
    windows: ShootingWindows
    sigma: Array
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
        return replace(self, windows=ShootingWindows(first, w.length, begin))

    @property
    def span(self) -> slice:
        """Samples that are evidence."""
        return slice(int(self.windows.begin[0]), len(self.recording.u))

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
    Return a recording in windows.

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
    return WindowData(recording, simulator(recording, model, finer), windows,
                      np.asarray(sigma, float), colour, seconds > SECONDS)


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
        data = replace(self.data, windows=self.data.windows.take(index))
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
                      sigma)
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


def misfit_of(runs: Sequence[WindowRuns]) -> float:
    """Return the root mean square of free `runs` against the readings, sigmas; 1 is the floor."""
    return math.sqrt(sum(float(run.chi2.sum()) for run in runs)
                     / max(sum(run.residual.size for run in runs), 1))


def typical_misfit(runs: Sequence[WindowRuns]) -> float:
    """Return the median misfit of windows of `runs`, sigmas: a burst or bad start counts less."""
    return math.sqrt(float(np.median(np.concatenate([
        run.chi2 / run.data.size for run in runs]))))


DRAWS = 2000
COVERAGE = (5.0, 95.0)  # percentiles
# Standard deviation of log sigma, by the median of fourth differences, about the root mean square
# of the noise in the same n readings: times 1 / sqrt(n). Simulated: 1.44 to 1.48.
SIGMA_ERROR = 1.45


def gap_of(chi2: Array, size: int) -> float:
    """Return the gap of windows with chi2 [W] over `size` readings each."""
    return float(math.sqrt(np.mean(chi2) / size))


def closed_of(gap_before: float, gap_after: float) -> float | None:
    """
    Return the closed fraction, None where there was no gap to speak of.

    Args:
        gap_before: misfit of the nominal model, in standard deviations.
        gap_after: misfit of the closed model, in standard deviations.
    """
    return (gap_before - gap_after) / (gap_before - 1.0) if gap_before >= STATEMENTS.gap else None


def closure(before: Sequence[WindowRuns], after: Sequence[WindowRuns], claims: bool,
            seed: int = 0) -> dict[str, Any]:
    """
    Return how far a model closes the gap, as plain data.

    gap_before, gap_after, closed_fraction; closed_fraction_ci [low, high], 90 % (both None where
    the gap before may be noise); gaps: of each reading {reading, before, after, closed}.

    Args:
        before: free runs of the model as published, of each recording.
        after: free runs of the model that closes the gap.
        claims: whether that model contains anything that repeats.
        seed: seed of the random numbers.
    """
    gaps = misfit_of(before), misfit_of(after)
    fraction = closed_of(*gaps) if claims else None
    interval = None
    if fraction is not None:
        per_reading = [np.concatenate([run.chi2 / run.data.size for run in runs])
                       for runs in (before, after)]
        readings = sum(len(run.data.channels) * len(run.recording.u) for run in after)
        interval = _interval(per_reading[0], per_reading[1], _noise(after), readings,
                             np.random.default_rng(seed))
        if interval is None:
            fraction = None
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'floor': 1.0, 'closed_fraction': fraction,
            'closed_fraction_ci': interval, 'gaps': _gaps(before, after)}


def file_closure(recordings: Sequence[UniformRecording], model: DriveModel, sigma: Array,
                 published: Sequence[WindowRuns], closed: Sequence[WindowRuns], seed: int = 0
                 ) -> dict[str, Any]:
    """
    Return how far the drive in a written file closes the gap, see closure.

    Args:
        recordings: that were diagnosed.
        model: of the drive in the file.
        sigma: noise of the encoders [2], rad.
        published: free runs of the model as published, of each recording.
        closed: of the model that closes the gap, near whose states those of the file begin.
        seed: seed of the random numbers.
    """
    runs = [open_loop(r, model, sigma, other.data) for r, other in zip(recordings, closed)]
    return closure(published, with_starts_of(runs, closed), True, seed)


def _noise(runs: Sequence[WindowRuns]) -> Array:
    """Return the power [W] of what runs leave above the frequencies of motion, mean 1."""
    out = []
    for run in runs:
        power, _, high = spectrum(run.residual, run.recording.dt)
        out.append(power[:, high].mean(axis=(1, 2)))
    noise = np.concatenate(out)
    return np.asarray(noise / noise.mean())


def _interval(chi2_before: Array, chi2_after: Array, noise: Array, readings: int,
              random: np.random.Generator) -> list[float] | None:
    """
    Return [low, high] of the closed fraction, None where it has no bounds.

    The fraction divides by what the gap before exceeds 1 by; where that may be nothing, no bound
    holds (Fieller).
    before, after [W]: chi2 per reading.

    noise [W]: power of the encoders' noise in the windows. sigma is measured in them as well: what
    is drawn of it moves gap and sigma alike.
    """
    count = len(chi2_before)
    draw = random.integers(0, count, (DRAWS, count))
    sigma = np.exp(random.standard_normal(DRAWS) * SIGMA_ERROR / math.sqrt(readings))
    sigma /= np.sqrt(noise[draw].mean(axis=1))
    gap0 = np.sqrt(chi2_before[draw].mean(axis=1)) * sigma
    gap1 = np.sqrt(chi2_after[draw].mean(axis=1)) * sigma

    def interval(drawn: Array) -> Array:
        """Return [low, high] of what was drawn; resampling few windows understates scatter."""
        middle = np.median(drawn)
        return np.asarray(middle + (np.percentile(drawn, COVERAGE) - middle) * math.sqrt(
            count / max(count - 1.0, 1.0)))
    if interval(gap0)[0] <= 1.0:
        return None
    return interval((gap0 - gap1) / np.maximum(gap0 - 1.0, 1e-3)).tolist()


def _gaps(before: Sequence[WindowRuns], after: Sequence[WindowRuns]) -> list[dict[str, Any]]:
    """Return the figures of each reading."""
    out = []
    for number, name in enumerate(after[0].recording.readings):
        gaps = []
        for runs in (before, after):
            powers = [run.residual[:, :, run.data.channels.index(number)].ravel() ** 2
                      for run in runs if number in run.data.channels]
            gaps += [math.sqrt(float(np.concatenate(powers).mean()))] if powers else []
        if gaps:
            out.append({'reading': name, 'before': gaps[0], 'after': gaps[1],
                        'closed': closed_of(*gaps)})
    return out


def with_starts_of(runs: Sequence[WindowRuns],
                   others: Sequence[WindowRuns]) -> tuple[WindowRuns, ...]:
    """
    Return runs whose windows begin where those of another model do, if they fit better.

    Which contact a window begins in must not count for or against a model.

    Args:
        runs: of each recording.
        others: of another model over the same windows.
    """
    out = []
    for run, source in zip(runs, others):
        states, chi2 = solve_states(run.data, run.model, source.states, run.memory)
        closer = (chi2 < run.chi2)[:, None]
        out.append(run if not closer.any() else runs_from(
            run.data, run.model, np.where(closer, states, run.states), run.memory))
    return tuple(out)


def open_loop(recording: UniformRecording, model: DriveModel, sigma: Array,
              like: WindowData | None = None, seconds: float = SECONDS) -> WindowRuns:
    """
    Return free runs of `model` over the windows of a recording; no value of it moves.

    Args:
        recording: recording of the drive.
        model: model of the drive.
        sigma: noise of the encoders [2], rad.
        like: data with these windows, None: all of the recording.
        seconds: length of the windows, s; longer ones begin in the smoothed states as they are.
    """
    plain = replace(model, tolerance=0.0, process_torque_time=0.0,
                    controller=model.controller and replace(model.controller, tolerance=0.0))
    data = window_data(recording, plain, sigma, seconds=seconds)
    if like is not None:
        data = replace(data, windows=like.windows)
    put_in = recording.motor is not None
    # No state of a window holds the zero of the encoders, which nobody knows.
    candidate = Starts(plain, [recording]).none() if put_in else CandidateModel(plain, (), ())
    likelihood = JointLikelihood([likelihood_of(
        recording, plain, sigma, [recording.span if put_in else data.span])])
    fit = fitted(likelihood, unfitted(likelihood, candidate))
    smooth, = likelihood.smoothed(likelihood.run(fit.model, fit.torque))
    return free_runs(data, fit.model, smooth)


def validate(recording: UniformRecording, nominal: DriveModel, closed: DriveModel,
             sigma: Array) -> dict[str, Any]:
    """
    Return how two DriveModels do on a Recording that was used for nothing else.

    {'recording', 'gap_before', 'gap_after', 'closed_fraction', 'windows', 'free_run': {'seconds',
    'before', 'after': {'motor' or 'torque', 'arm': rms from the first window on}}}; None: the run
    diverges.

    Args:
        recording: recording of the drive.
        nominal: model before the diagnosis.
        closed: model with the effects that were identified.
        sigma: noise of the encoders [2], rad.
    """
    laid = overlay(recording, {'before': nominal, 'after': closed}, sigma)
    gaps = [run.gap for run in laid.runs]
    readings = laid.recording.readings
    rows = {run.name: {name: float(v) if np.isfinite(v) else None for name, v in zip(
        readings, rms(laid.recording, run.free))} for run in laid.runs}
    return {'recording': recording.name, 'gap_before': gaps[0], 'gap_after': gaps[1],
            'closed_fraction': closed_of(*gaps), 'windows': len(laid.windows),
            'free_run': {'seconds': float(laid.recording.duration), **rows}}


def free_run(runs: WindowRuns) -> Array:
    """Return the readings [N, 2] of one run from the first of `runs` on, NaN before it."""
    data = runs.data
    n, begin = len(runs.recording.u), data.windows.begin[:1]
    whole = ShootingWindows(begin, n - int(begin[0]), begin)
    y, _ = data.simulator.run(whole, runs.model, runs.states[:1], np.zeros((1, N_MEMORY)))
    return np.concatenate([np.full((int(begin[0]), 2), np.nan), y[0]])


def rms(recording: UniformRecording, y: Array) -> Array:
    """Return [2] rad, rms against a free run `y` [N, 2]; NaN: it diverges, or is not read."""
    begin = int(np.isfinite(y).any(axis=1).argmax())
    with np.errstate(over='ignore', invalid='ignore'):
        deviation = np.sqrt(np.mean((recording.y[begin:] - y[begin:]) ** 2, axis=0))
    deviation[[i for i in (0, 1) if i not in recording.channels]] = np.nan
    return np.where(np.isfinite(deviation), deviation, np.nan)


@dataclass(frozen=True)
class ModelRun:
    """
    What one model gives: y [W, L, 2] rad in the windows, chi2 [W] of them, their gap.

    begin: states and memories from which the windows run. free [N, 2] rad: one run over the whole
    recording, from the states of the first window, NaN or huge where the model diverges.
    """

    name: str
    y: Array
    chi2: Array
    gap: float
    begin: Begin
    free: Array


@dataclass(frozen=True)
class Overlay:
    """
    A Recording and the Runs of models over its Windows.

    t [W, L] s of the log and measured [W, L, 2] rad; sigma [2] rad, noise of the encoders;
    channels: the encoders that there are.
    """

    recording: UniformRecording
    windows: ShootingWindows
    t: Array
    measured: Array
    sigma: Array
    channels: tuple[int, ...]
    runs: tuple[ModelRun, ...]


def overlay(recording: UniformRecording, models: Mapping[str, DriveModel],
            sigma: Array | None = None) -> Overlay:
    """
    Return the Overlay of a Recording and `models` {name: DriveModel}.

    sigma [2] rad: noise of the encoders (default: measured from the recording).

    Args:
        recording: recording of the drive.
        models: models by name.
        sigma: noise of the encoders [2], rad.
    """
    recording = driven(recording, next(iter(models.values())))
    if sigma is None:
        sigma, _ = noise_floor(recording, next(iter(models.values())))
    fits = tuple(open_loop(recording, model, sigma) for model in models.values())
    if len(fits) == 2:
        fits = with_starts_of(fits, fits[::-1])
    windows, runs = fits[0].data.windows, []
    for name, fit in zip(models, fits):
        y, _ = fit.data.simulator.run(windows, fit.model, fit.states, fit.memory)
        runs.append(ModelRun(name, y, fit.chi2, misfit_of([fit]), Begin(fit.states, fit.memory),
                             free_run(fit)))
    return Overlay(recording, windows, recording.begin + recording.t[windows.samples],
                   recording.y[windows.samples], np.asarray(sigma, float), recording.channels,
                   tuple(runs))
