# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a diagnosis has to go by: recordings, model, noise, and likelihoods of their parts.

Each recording is cut to windows of 1 s, with data, states where they start, free runs and
residuals. The states are fitted by Levenberg-Marquardt; each recording has its own encoders.
"""
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
import math

import numpy as np
import scipy

from gearbox_monitor.diagnosis.contest import CONTEST, THRESHOLDS
from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, InnovationLikelihood, JointLikelihood, noise_floor,
    prewhitened, SPARSE, unfitted, WHITE)
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, ShootingWindows, Simulator
from gearbox_monitor.diagnosis.joint.torque_domain import likelihood_of, simulator
from gearbox_monitor.kernels.linear_least_squares import Damping, minimise
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library, MAX_SETPOINT_DELAY
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
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


# s, how long torque that no model explains may last on a real drive; iterations of a fit with each
LASTING_TIMES, TIME_ITERATIONS = (0.1, 0.3, 1.0), 8
BEFORE, AFTER, LEAST = 0.1, 0.4, 0.2  # s, about a slip that no likelihood sees; least part


def silent(text: str) -> None:
    """Report nothing of `text`."""


@dataclass(frozen=True, eq=False)
class DriveRecordings:
    """
    Recordings of one drive under one nominal model.

    sigma [2]: noise of the encoders, rad; colour [2, 2]: correlation of neighbouring readings of
    each, 0: white, and variance of coloured noise over that of `sigma`. ids: effects that may be
    named. quantum [2]: quantisation steps of the encoders, rad.
    all_trained: whether no window is held out. with_map: whether a torque map of
    the remainder may be fitted. finer: how many times as many steps the model takes as the
    nominal drive asks for. reference: fit in whose free runs filters begin where an encoder is
    missing, None: the nominal model. progress(text) is called as the search goes on. slips: time
    (s) and size (rad) of those over which the motor counts on here [B, 2]; slip_owner [B]: number
    of the recording.
    """

    recordings: tuple[UniformRecording, ...]
    model: DriveModel
    sigma: Array
    ids: tuple[str, ...]
    colour: Array = field(default_factory=lambda: np.array(WHITE))
    quantum: Array = field(default_factory=lambda: np.zeros(2))
    all_trained: bool = False
    with_map: bool = True
    finer: int = 1
    reference: InnovationFit | None = None
    jobs: int = 1
    progress: Callable[[str], object] = silent
    slips: Array = field(default_factory=lambda: np.zeros((0, 2)))
    slip_owner: Integers = field(default_factory=lambda: np.zeros(0, int))

    @cached_property
    def segments(self) -> tuple[WindowData, ...]:
        """The recordings with their windows."""
        # At rest, nothing tells where the side is that no encoder reads.
        parts = [window_data(r, self.model, self.level, self.correlation,
                             SETTLING if not self.hides(r) else max(
                                 SETTLING, seconds_at_rest(r, self.sigma)), self.finer)
                 for r in self.recordings]
        if self.all_trained:
            parts = [replace(part, held_out=np.zeros_like(part.held_out)) for part in parts]
        return tuple(parts)

    @property
    def level(self) -> Array:
        """Standard deviation [2] of the encoders' noise, rad."""
        return self.sigma * np.sqrt(self.colour[:, 1])

    @property
    def correlation(self) -> Array | None:
        """Correlation [2] of neighbouring readings of the encoders, None where all are white."""
        return self.colour[:, 0] if self.colour[:, 0].any() else None

    @property
    def noise_time(self) -> list[float | None]:
        """Correlation times [2] of the encoders' noise, s; None: white."""
        dt = self.recordings[0].dt
        return [float(-dt / np.log(phi)) if phi > 0.0 else None for phi in self.colour[:, 0]]

    @property
    def rough(self) -> bool:
        """Whether an encoder is quantised more coarsely than its noise."""
        return bool((self.quantum > THRESHOLDS.rough_lattice * self.sigma).any())

    @cached_property
    def starts(self) -> Starts:
        """Where fits of effects begin."""
        return Starts(self.model, self.recordings, [part.training for part in self.segments])

    def _likelihood(self, spans: Sequence[slice], coarse: bool = False) -> JointLikelihood:
        sigma = self.sigma
        parts = []
        for number, (recording, span) in enumerate(zip(self.recordings, spans)):
            if span.stop > span.start:
                part = likelihood_of(recording, self.model, sigma,
                                     self._between_slips(number, span), coarse, self.finer)
                if self.hides(recording) and isinstance(part, InnovationLikelihood):
                    fit = self.reference or unfitted(part, self.starts.none())
                    part = hidden_begins(part, fit.model, sigma)
                if self.correlation is not None and isinstance(part, InnovationLikelihood):
                    part = part.changed(colour=self.colour)
                parts.append(part)
        return JointLikelihood(parts)

    def calm(self, runs: Iterable[WindowRuns]) -> tuple[WindowRuns, ...]:
        """Return `runs` without the windows in which the drive slips: no model repeats that."""
        out = []
        for number, run in enumerate(runs):
            t, kept = run.data.windows.samples * run.recording.dt, np.ones(len(run.states), bool)
            for t0, _ in self.slips[self.slip_owner == number]:
                kept &= ~((t > t0 - BEFORE) & (t < t0 + AFTER)).any(axis=1)
            out.append(run.take(np.flatnonzero(kept)) if kept.any() and not kept.all() else run)
        return tuple(out)

    def _between_slips(self, number: int, span: slice) -> list[slice]:
        """Return the parts of the `span` of a recording in which nothing slips: all but a blow."""
        dt, begin, out = self.recordings[number].dt, span.start, list[slice]()
        for t0, _ in self.slips[self.slip_owner == number]:
            out.append(slice(begin, min(span.stop, int((t0 - BEFORE) / dt))))
            begin = max(begin, int((t0 + AFTER) / dt))
        out.append(slice(begin, span.stop))
        return [part for part in out if part.stop - part.start > LEAST / dt] or [span]

    def hides(self, recording: UniformRecording) -> bool:
        """Return whether a side moves on its own that no encoder of the `recording` reads."""
        return len(recording.channels) == 1 and self.model.transmission.kind != 'rigid'

    @cached_property
    def coarse(self) -> JointLikelihood:
        """Likelihood of the training parts, on larger steps; usual ones where short ones show."""
        return replace(self, finer=1)._likelihood(
            [part.training for part in self.segments], coarse=self.finer == 1)

    @cached_property
    def fine(self) -> JointLikelihood:
        """Likelihood of the training parts."""
        return self._likelihood([part.training for part in self.segments])

    @cached_property
    def whole(self) -> JointLikelihood:
        """Likelihood of all that is evidence."""
        return self._likelihood([part.span for part in self.segments])

    @cached_property
    def unseen(self) -> JointLikelihood | None:
        """Likelihood of what is held out, None if nothing is."""
        spans = [part.unseen for part in self.segments]
        return self._likelihood(spans) if any(s.stop > s.start for s in spans) else None

    def lasting_for(self, seconds: float) -> 'DriveRecordings':
        """Return the evidence where unexplained torque lasts so long."""
        if seconds == self.model.process_torque_time:
            return self
        return replace(self, model=replace(self.model, process_torque_time=seconds))

    @property
    def sparse(self) -> JointLikelihood:
        """Likelihood of all that is evidence, of as few readings as where torque lasts."""
        return JointLikelihood([part.changed(every=max(1, round(SPARSE / part.recording.dt)))
                                for part in self.whole.parts])

    @property
    def step(self) -> float:
        """Length of an integration step, s."""
        return min(part.recording.dt / part.simulator.n for part in self.whole.parts)

    @property
    def balances(self) -> bool:
        """Whether the motion is put in, so that the balance of torques is the evidence."""
        return self.recordings[0].motor is not None

    @property
    def noisy(self) -> bool:
        """Whether the model file says that values or the torque are not exact."""
        model = self.model
        return model.tolerance > 0.0 or bool(model.process_torque) or model.lasting

    def asked(self, effect: str) -> tuple[tuple[str, str, str], tuple[float, float]]:
        """Return where a Question about `effect` is, and the motion: usual speed, rad/s, and s."""
        speeds = [np.quantile(np.abs(np.diff(r.positions[::10, r.channels[0]])), 0.9) / (
            10.0 * r.dt) for r in self.recordings]
        return ((effect, library()[effect].location, self.recordings[0].readings[0]),
                (float(max(speeds)), sum(float(r.duration) for r in self.recordings)))

    @property
    def torque(self) -> float:
        """Standard deviation of the torque, N m."""
        return max(float(np.std(np.concatenate([r.torque for r in self.recordings]))), 1e-9)

    @property
    def scales(self) -> Array:
        """Size [2] of torque, N m, and twist, rad."""
        return np.array([self.torque, max(float(np.std(r.positions[:, 0] - r.positions[:, 1]))
                                          for r in self.recordings) + 1e-12])

    @property
    def allowed_noise(self) -> Array:
        """Torque noise [2] on motor and arm that is no model error, N m rms in a sample."""
        allowed = self.whole.least_noise
        if self.model.process_torque:
            allowed = np.maximum(allowed, self.model.process_torque)
        if self.model.lasting:
            allowed = np.maximum(allowed, THRESHOLDS.lasting_torque * self.torque)
        elif self.noisy:
            allowed = np.maximum(allowed, THRESHOLDS.torque_noise * self.torque)
        return allowed

    def runs(self, fit: InnovationFit, overlapping: bool = False) -> tuple[WindowRuns, ...]:
        """Return free runs of a `fit` over windows, or `overlapping` ones, of each recording."""
        at, model = evaluated(self.whole, fit), fit.model
        return self.calm(
            free_runs(segment.overlapping if overlapping else segment, model, smooth)
            for segment, smooth in zip(self.segments, self.whole.smoothed(at.run)))

    def beyond_share(self, fit: InnovationFit) -> float:
        """
        Return the gain in -2 log L of more torque than a model of a real drive may leave.

        Where the motion is put in, what remains is the noise of the balance.
        """
        at = evaluated(self.whole, fit)
        left = np.sqrt(np.mean([run.left ** 2 for run in at.run.runs], axis=0))
        ratio = float((left / self.scales).max() / THRESHOLDS.lasting_torque) ** 2
        return self.whole.readings * max(0.0, ratio - 1.0 - math.log(max(ratio, 1.0)))

    def unexplained_by_free_runs(self, fit: InnovationFit) -> float:
        """
        Return the gain in -2 log L of torque noise beyond the allowed.

        A filter is linearised about one state. Of a side that no encoder reads it may lose track
        in the gap, and noise stands for that: what a free run explains there, the model explains.
        """
        at = evaluated(self.whole, fit)
        quiet = self.whole.run(at.model, np.minimum(at.torque, self.allowed_noise))
        gain = quiet.deviance - at.run.deviance
        for run, filtered in zip(self.runs(fit), quiet.runs):
            if self.hides(run.recording):
                rows = np.maximum(run.data.windows.samples - 1, 0)
                explained = filtered.deviances[rows].sum(axis=(1, 2)) - (
                    run.chi2 - run.data.size + run.states.shape[1])
                gain -= float(np.maximum(explained, 0.0).sum())
        return gain

    def score(self, fit: InnovationFit) -> float:
        """Return the BIC (Schwarz 1978) of a fit to the training parts."""
        return fit.deviance + fit.candidate.n_effect * float(np.log(self.fine.readings))


def lasting_time(evidence: DriveRecordings, fit: InnovationFit, *times: float) -> float:
    """
    Return how long unexplained torque lasts beside a fit, s: as stated, or what pays its price.

    The model file states what lasts beside the model without members; an effect that is missing
    lasts a stroke, and passes for such a torque. A fit for each time: with torque that lasts,
    values move, and a friction may go into it. All times see the same readings.

    Args:
        evidence: recordings that the torque drives.
        fit: with whose values fits begin.
        times: tried beside LASTING_TIMES, s; 0: white noise.
    """
    stated, deviances = evidence.model.process_torque_time, dict[float, float]()
    for time in sorted({stated, *LASTING_TIMES, *times}):
        likelihood = evidence.lasting_for(time).sparse
        start = unfitted(likelihood, fit.candidate, fit.z)
        deviances[time] = fitted(likelihood, start, TIME_ITERATIONS).deviance
    best = min(deviances, key=lambda time: deviances[time])
    price = CONTEST.margin + 2.0 * math.log(len(deviances))
    return stated if deviances[stated] - deviances[best] < price else best


def evidence_of(recordings: Sequence[UniformRecording], model: DriveModel, ids: Sequence[str],
                jobs: int = 1, progress: Callable[[str], object] = silent) -> DriveRecordings:
    """
    Return the DriveRecordings of one drive.

    Args:
        recordings: of one drive.
        model: its nominal model.
        ids: effects that may be named.
        jobs: number of threads.
        progress: called with a text.
    """
    levels, steps = zip(*(noise_floor(recording, model) for recording in recordings))
    sigma, quantum = np.zeros(2), np.zeros(2)
    for channel in (0, 1):
        # Of a hidden encoder the copy stands in.
        own = [i for i, r in enumerate(recordings) if channel in r.channels] or [0]
        sigma[channel] = max(levels[i][channel] for i in own)
        quantum[channel] = max(steps[i][channel] for i in own)
    with_map = TORQUE_MAP.id in ids and not any(
        effect['id'] == TORQUE_MAP.id for effect in model.effects)
    return DriveRecordings(tuple(recordings), model, sigma,
                           tuple(i for i in ids if i != TORQUE_MAP.id), quantum=quantum,
                           with_map=with_map, jobs=jobs, progress=progress)


ITERATIONS = 8  # of a fit to recordings that are read in another way
LATEST, CLOSE = 0.5, 2e-3  # sample times by which a torque that was sampled acts later at most


def is_open(recording: UniformRecording, model: DriveModel) -> bool:
    """Return whether `recording` leaves open how torque acted on `model` between its stamps."""
    return (recording.dt * THRESHOLDS.slow_rate > 1.0 and model.controller is None
            and model.driven_by == 'torque')


def likeliest(evidence: DriveRecordings,
              fit: InnovationFit) -> tuple[DriveRecordings, InnovationFit]:
    """
    Return (the recordings, `fit`), both as they were where another reading gains nothing.

    How torque acted between the stamps of a slow log is a nuisance: held, or sampled a share of a
    sample before each stamp. Values of the fit move along with it.

    Args:
        evidence: the recordings, as they were read so far.
        fit: of one model to all of them.
    """
    for number, recording in enumerate(evidence.recordings):
        if is_open(recording, evidence.model):
            evidence, fit = _read(evidence, fit, number)
    return evidence, fit


def likeliest_reading(evidence: DriveRecordings) -> DriveRecordings:
    """Return the recordings, read so that the model without effects is likeliest."""
    return likeliest(evidence, unfitted(evidence.fine, evidence.starts.none()))[0]


def _read(evidence: DriveRecordings, fit: InnovationFit, number: int
          ) -> tuple[DriveRecordings, InnovationFit]:
    """Return (the recordings, fit), one of them read so that the fit is likeliest."""
    tried: dict[float | None, tuple[DriveRecordings, InnovationFit]] = {}
    recordings = evidence.recordings

    def score(shift: float | None) -> float:
        read = replace(evidence, recordings=(
            *recordings[:number], replace(recordings[number], shift=shift),
            *recordings[number + 1:]))
        tried[shift] = read, fitted(read.fine, fit, ITERATIONS)
        return read.score(tried[shift][1])
    scores = {shift: score(shift) for shift in {recordings[number].shift, None}}
    sampled = scipy.optimize.minimize_scalar(
        score, bounds=(0.0, LATEST), method='bounded', options={'xatol': CLOSE})
    scores[float(sampled.x)] = float(sampled.fun)
    best = min(scores, key=lambda shift: scores[shift])
    return tried[best] if scores[best] < scores[recordings[number].shift] - CONTEST.margin else (
        evidence, fit)
