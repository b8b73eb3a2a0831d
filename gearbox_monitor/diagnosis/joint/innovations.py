# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The grey-box likelihood of a recording: innovations of an EKF of the drive with torque noise.

-2 log L is exact for the filter (Kristensen, Madsen and Jorgensen, 2004). White torque on motor
and arm, of a size that the likelihood itself finds, bears what a model does not explain: the
filter follows the drive however wrong the model is, and the torque vanishes as the model becomes
right. Noise of the encoders: its level, its colour, its spectrum above the frequencies of motion.

The maximum likelihood of a candidate: Levenberg-Marquardt on whitened innovations, coordinates and
logarithms of the torque noise in one Fisher step; the exact likelihood accepts it. The noise
anneals by itself: it is large where the model is wrong. One start is enough for most effects, that
without it.
"""
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from typing import Any, TypeAlias

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, zero_and_swing
from gearbox_monitor.diagnosis.joint.shooting import Simulator
from gearbox_monitor.estimation import innovation_filter as kernels
from gearbox_monitor.estimation.innovation_filter import (
    COLOURED, FilterInput, FilterStart, FilterTrace, LASTING, N_FILTER, SampleSchedule)
from gearbox_monitor.kernels.elementary import noise_levels, white_noise_std
from gearbox_monitor.kernels.linear_least_squares import (
    covariance, damped_solve, damped_step, Damping)
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.batch import LANES, N_LANE_STATE
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, MEMORIES
from gearbox_monitor.plant.effects.composition import DELAY1, DELAY2
from gearbox_monitor.plant.effects.registry import INTEGRAL, LATE_A, LATE_B, LATE_C
from gearbox_monitor.plant.simulate import N_STATE, packed_drive, PackedDrive, plugin_of
from gearbox_monitor.signals.uniform import UniformRecording

MOTION = 60.0  # Hz, above which motion has hardly anything
STILL = 0.05   # s, after which a reading that repeats stands still: slower encoders repeat less
LEAST = 1e-8   # of the travel: readings without any noise are no more accurate than the model
FINEST = 1e-4  # of the travel: on a real drive, differences below are no gap


def spectrum(residual: Array, dt: float) -> tuple[Array, Array, Flags]:
    """
    Return (power [W, L, C], frequencies [L] Hz, high [L]) of residuals [W, L, C], dt s apart.

    high: above the frequencies of motion; all of them at low sample rates.

    Args:
        residual: residual [W, L, C], in standard deviations.
        dt: sample time, s.
    """
    length = residual.shape[1]
    power = scipy.fft.dct(residual, axis=1, norm='ortho') ** 2
    at = np.arange(length) * 0.5 / (length * dt)
    return power, at, at > MOTION if at[-1] > 2.0 * MOTION else at >= 0.0


def prewhitened(residual: Array, phi: Array) -> Array:
    """
    Return `residual` [W, L, C] with the noise of the C encoders made white, as large.

    Args:
        residual: residual [W, L, C], in standard deviations.
        phi: correlation of neighbouring readings of each encoder.
    """
    out = residual.copy()
    out[:, 1:] = (residual[:, 1:] - phi * residual[:, :-1]) / np.sqrt(1.0 - phi * phi)
    return out


def variance_over_white(phi: float) -> float:
    """
    Return the variance of coloured noise over that of white noise of the same fourth differences.

    Args:
        phi: correlation of neighbouring readings.
    """
    # Coefficients of the autocorrelation of (1, -4, 6, -4, 1).
    return 70.0 / (70.0 - 112.0 * phi + 56.0 * phi ** 2 - 16.0 * phi ** 3 + 2.0 * phi ** 4)


def noise_floor(recording: UniformRecording, model: DriveModel) -> tuple[Array, Array]:
    """
    Return (sigma [2], quantum [2]) of a Recording, rad; sigma not below what matters.

    Args:
        recording: recording of the drive.
        model: model of the drive; one with lasting process torque is that of a real drive.
    """
    sigma, quantum = noise_levels(recording.y)
    for channel in np.flatnonzero(quantum == 0.0):
        # Noise never repeats: while a reading stands still, nothing is measured.
        y, count = recording.y[:, channel], max(4, round(STILL / recording.dt))
        begins = np.flatnonzero(np.convolve(np.diff(y) != 0.0, np.ones(count), 'valid') == 0.0)
        if len(begins):
            sigma[channel] = white_noise_std(np.delete(y, np.unique(
                begins[:, None] + np.arange(1, count + 1))))
    sigma = np.maximum(sigma, recording.floor)
    sigma = np.maximum(sigma, LEAST * np.ptp(recording.y, axis=0) + 1e-12)
    if model.lasting:
        sigma = np.maximum(sigma, FINEST * np.ptp(recording.y, axis=0))
    return sigma, quantum


FIRST_NOISE = 0.05  # of the standard deviation of the torque
BEGIN = 0.04        # s of readings from which the states at the begin of a part are taken
SPEED_ERROR = 0.3   # rad/s, by which a speed from so few readings may be off at least
MOVES = (1e-6, 1e-6, 1e-5, 1e-5)  # rad and rad/s, by which states are moved for the tangent
MEMORY_MOVE = 1e-5  # of the size of a memory
SPARSE = 0.02       # s from reading to reading where unexplained torque lasts: steps of less tell
# of friction within milliseconds alone, which no model of a real drive has
ONCE = 1e-6         # of a sample: events that are as close happen at once
STRAY = 0.1         # of the encoders' noise, by which the least torque noise moves a run of 1 s
WHITE = ((0.0, 1.0), (0.0, 1.0))  # colour of white noise, see FilterInput
DRIFT = 10.0        # s, in which a zero that drifts forgets: far longer than a slip
MOST = 50.0         # times the standard deviation of the torque: noise with which all is followed


@dataclass(frozen=True)
class Filtered:
    """
    The run of a filter under a DriveModel: its input, its record and -2 log L.

    innovation [N, 2], rad, 0 where nothing was read; variance [N, 2] of it, rad^2, else 1.
    """

    model: DriveModel
    drive: PackedDrive
    schedule: SampleSchedule
    data: FilterInput
    start: FilterStart
    trace: FilterTrace
    deviance: float
    innovation: Array
    variance: Array

    @property
    def read(self) -> Flags:
        """Whether an encoder was read [N, 2]."""
        return self.trace.slope != 0.0

    @property
    def residual(self) -> Array:
        """Innovations [N, 2] in their standard deviations, 0 where nothing was read."""
        return self.innovation / np.sqrt(self.variance)

    @property
    def deviances(self) -> Array:
        """-2 log L of each reading [N, 2], 0 where nothing was read."""
        return np.where(self.read, self.residual ** 2 - 1.0
                        + np.log(self.variance / self.data.variance), 0.0)


class InnovationLikelihood:
    """
    Likelihood of models for the parts `spans` of a Recording, noise `sigma` [2] rad.

    The parts are filtered side by side. coarse: on larger steps; finer: with so many times as many
    steps. begin_variance [4]: of the positions and speeds in which the parts begin.
    """

    def __init__(self, recording: UniformRecording, model: DriveModel, sigma: Array,
                 spans: Sequence[slice], coarse: bool = False, finer: int = 1) -> None:
        self.simulator = Simulator(recording, model, coarse, finer)
        self.recording, self.nominal = recording, model
        self.variance = np.asarray(sigma, float) ** 2
        self.begin = np.array([span.start for span in spans])
        self.end = np.array([span.stop for span in spans])
        self.y = np.ascontiguousarray(recording.y)
        self._states = np.zeros((len(spans), N_FILTER))
        lasts = model.process_torque_time
        self.fade = math.exp(-recording.dt / lasts) if lasts > 0.0 else 0.0
        self.every = max(1, round(SPARSE / recording.dt)) if lasts > 0.0 else 1
        self.colour = np.array(WHITE)
        self._torque = max(float(np.std(recording.torque)), 1e-9)
        variance = self.variance
        self._lanes = np.zeros(N_LANE_STATE)
        count = max(4, round(BEGIN / recording.dt))
        for c, k in enumerate(self.begin):
            t = (np.arange(min(count, self.end[c] - k))) * recording.dt
            line = np.polyfit(t, self.y[k:k + len(t)], 2)
            self._states[c, :2], self._states[c, 2:4] = line[2], line[1]
            off = self.y[k:k + len(t)] - np.stack([np.polyval(row, t) for row in line.T], axis=1)
            variance = np.maximum(variance, (off * off).mean(axis=0))
        # The same of all parts: a motion that no parabola follows may begin anywhere.
        self.begin_variance = np.concatenate([
            4.0 * variance + 1e-10, SPEED_ERROR ** 2 + variance / (0.25 * BEGIN) ** 2])
        for hidden in {0, 1} - set(recording.channels):
            # Readings of the other encoder stand in: off by the twist, in the gap by any speed.
            gear = model.transmission
            twist = gear.half_gap + float(np.std(recording.torque)) / gear.stiffness
            speed = float(np.std(np.gradient(self.y[:, hidden], recording.dt)))
            self.begin_variance[[hidden, 2 + hidden]] += twist ** 2, speed ** 2
        zero, swing = zero_and_swing(model, recording)
        if zero:
            self._states[:, 1] -= zero
            self.begin_variance[1] += swing * swing
        if model.transmission.kind == 'rigid':
            pairs = self._states[:, :4].reshape(-1, 2, 2)[:, :, list(recording.channels)]
            self._states[:, :4] = np.repeat(pairs.mean(axis=2), 2, axis=1)
            self.begin_variance = np.repeat(
                self.begin_variance.reshape(2, 2)[:, list(recording.channels)].max(axis=1), 2)

    def changed(self, **values: Any) -> 'InnovationLikelihood':
        """
        Return the likelihood with other values of attributes; it begins as before.

        every: of so many readings one counts. colour: of the encoders' noise, see FilterInput.
        simulator: with other torques from outside.
        """
        out = copy(self)
        vars(out).update(values)
        return out

    def drift(self, model: DriveModel, torque: Array) -> Array:
        """Return the zero of the motor's encoder [N], rad, as a smoothed state that drifts."""
        size = float(np.std(self.y[:, 0] - self.y[:, 1]))
        # Beside a coloured noise, the filter leaves a share of the variance white.
        variance, colour = self.variance * (1.0 / kernels.WHITE, 1.0), self.colour.copy()
        colour[0] = math.exp(-self.recording.dt / DRIFT), size * size / variance[0]
        out = self.changed(variance=variance, colour=colour)
        return out._smoothed(out.run(model, torque))[:, COLOURED]

    def begun(self, states: Array, deviation: Array) -> 'InnovationLikelihood':
        """
        Return the likelihood whose parts begin elsewhere.

        Args:
            states: positions and speeds of motor and arm where the parts begin [C, 4].
            deviation: standard deviation of each [4].
        """
        return self.changed(_states=np.column_stack([states, self._states[:, 4:]]),
                            begin_variance=np.asarray(deviation, float) ** 2)

    @property
    def least_noise(self) -> Array:
        """
        Least torque noise [2] on motor and arm, N m rms in a sample: what a free run cannot show.

        White torque s in samples of dt moves an inertia m in T = 1 s by s sqrt(dt T^3 / 3) / m
        rad rms. The least noise moves it by a share of the encoders' noise, as the steps of the
        integration may (shooting.STEP_EIGENVALUE).
        """
        model = self.nominal
        inertia = np.array([model.motor_inertia, model.arm_inertia])
        if model.transmission.kind == 'rigid':
            inertia[:] = inertia.sum()
        sigma = float(np.sqrt(self.variance[list(self.recording.channels)].min()))
        return np.asarray(STRAY * sigma * inertia * math.sqrt(3.0 / self.recording.dt))

    @property
    def most_noise(self) -> float:
        """Torque noise with which any recording is followed, N m rms in a sample."""
        return MOST * max(self._torque, 1e-3)

    @property
    def readings(self) -> int:
        """Number of readings that count."""
        count = int((self.end - self.begin - 1).sum()) // self.every
        return count * len(self.recording.channels)

    @property
    def first_noise(self) -> Array:
        """Torque noise [2] on motor and arm with which fits begin, N m rms in a sample."""
        return np.full(2, FIRST_NOISE * max(self._torque, 1e-3))

    def _start(self, model: DriveModel) -> FilterStart:
        t, sizes = model.transmission, self._sizes(model)
        covariance = np.diag([*self.begin_variance, *(size * size for size in sizes.values())])
        if t.kind == 'rigid':  # motor and arm are one
            covariance[[0, 1, 2, 3], [1, 0, 3, 2]] = np.diag(covariance)[:4]
        return FilterStart(self._states, np.array([0, 1, 2, 3, *sizes]), covariance, np.array(
            [*MOVES, *(MEMORY_MOVE * size for size in sizes.values())]))

    def _sizes(self, model: DriveModel) -> dict[int, float]:
        """Return {place of a state beyond positions and speeds: its size where it begins}."""
        t, servo = model.transmission, model.folded().controller
        sizes = {LASTING: self._torque} if self.fade else {}
        sizes.update({COLOURED + c: math.sqrt(self.variance[c] * self.colour[c, 1])
                      for c in self.recording.channels if self.colour[c, 0] > 0.0})
        for effect in model.effects:
            if effect['id'] in MEMORIES:
                begins = EFFECTS[effect['id']].memory_starts
                sizes[4 + MEMORIES[effect['id']]] = max(begins) if begins else (
                    model.coulomb_friction / effect['sigma0'])
        if t.kind in ('play', 'passive_play') and t.hysteresis_width > 0.0:
            sizes[4] = t.hysteresis_width * (t.stiffness if t.kind == 'play' else 1.0)
        if servo is not None:
            late = any((servo.delay, servo.rate))
            sizes.update({4 + place: self._torque for place, value in (
                (INTEGRAL, servo.ki), (LATE_A, late), (LATE_B, late), (LATE_C, late)) if value})
        return sizes

    def run(self, model: DriveModel, torque: Array) -> Filtered:
        """
        Return the Filtered recording under `model` with torque noise `torque` [2].

        Args:
            model: model of the drive.
            torque: noise of the torque on motor and arm, N m rms in a sample.
        """
        drive, (filtered, _) = _kernels_of(model)
        start = self._start(model)
        parts = schedule(drive.e, self.recording.dt, self.simulator.n, self.recording.channels)
        data = FilterInput(self.y, self.simulator.acting(drive.e), self.simulator.extra,
                           self.recording.dt, self.begin, self.end, self.variance,
                           np.asarray(torque, float), self.fade, self.every, self.colour)
        n, states, segments = len(self.y), len(start.places), len(parts.span)
        trace = FilterTrace(
            np.empty((n, segments, N_FILTER)), np.empty((n, segments, states)),
            np.empty((n, segments, states, states)), np.empty((n, states, states)),
            np.zeros((n, 2)), np.ones((n, 2)), np.zeros((n, 2, states)), np.zeros((n, 2)),
            np.zeros((n, 2)), np.zeros((n, 2)))
        groups = min(kernels.GROUPS, LANES // (states + 1))
        room = np.zeros((groups + 1, states + 1, N_FILTER))
        deviance = filtered(drive, parts, data, start, self._lanes.copy(), room, trace)
        return Filtered(model, drive, parts, data, start, trace, deviance, trace.innovation,
                        trace.variance)

    def change(self, run: Filtered, model: DriveModel) -> Array:
        """
        Return the change [N, 2] (rad) of the innovations when the model becomes `model`.

        Args:
            run: run of the filter.
            model: a model close to that of the run.
        """
        drive, (_, sensitivity) = _kernels_of(model)
        out = np.zeros_like(self.y)
        sensitivity(
            (run.drive, drive), run.schedule,
            run.data._replace(u=self.simulator.acting(drive.e)), run.start.places,
            self._lanes.copy(), run.trace, np.empty_like(run.trace.end), out)
        return out

    def with_noise(self, run: Filtered, torque: Array) -> tuple[float, Array, Array]:
        """
        Return (-2 log L, innovations [N, 2], their variance [N, 2]) of `run` under other noise.

        To first order: without another run.

        Args:
            run: filter that was run.
            torque: noise of the torque on motor and arm, N m rms in a sample.
        """
        n = len(run.start.places)
        change, variance = np.zeros_like(self.y), np.ones_like(self.y)
        deviance = kernels.with_noise(
            run.drive, run.schedule, run.data._replace(torque=np.asarray(torque, float)),
            run.start, run.trace, np.zeros((2 * n + 3, n)), change, variance)
        return deviance, run.trace.innovation + change, variance

    def motion(self, run: Filtered) -> dict[str, Array]:
        """Return {quantity: values} of the motion as the filter of `run` has it."""
        index = np.concatenate([np.arange(begin, end - 1)
                                for begin, end in zip(self.begin, self.end)])
        return named_motion(self.recording, run.trace.begin[:, 0], index)

    def shares(self, count: int) -> Integers:
        """Return in which of `count` equal parts of the recording each sample [N] is."""
        begin, end = int(self.begin.min()), int(self.end.max())
        return np.clip((np.arange(len(self.y)) - begin) * count // max(end - begin, 1),
                       0, count - 1)

    def smoothed(self, run: Filtered) -> Array:
        """Return the smoothed states [N, N_STATE] of `run`, NaN outside of its parts."""
        return self._smoothed(run)[:, :N_STATE]

    def _smoothed(self, run: Filtered) -> Array:
        states = np.full((len(self.y), N_FILTER), np.nan)
        kernels.smoothed(run.schedule, run.data, run.start.places, run.trace,
                         np.zeros(2 * len(run.start.places)), states)
        return states


def named_motion(recording: UniformRecording, states: Array, index: Integers) -> dict[str, Array]:
    """
    Return {quantity: values} of the motion in some samples.

    Args:
        recording: of one drive.
        states: positions and speeds of motor and arm, what else there is [N, 4 or more].
        index: numbers of the samples.
    """
    x1, x2, x3, x4 = states[index, :4].T
    return {'speed of the motor': x3, 'speed of the arm': x4, 'angle of the motor': x1,
            'angle of the arm': x2, 'twist': x1 - x2, 'torque': recording.torque[index],
            'time': index * recording.dt}


def halves(spans: Iterable[slice]) -> list[slice]:
    """Return the halves of `spans`: two lanes of a filter take as long as one."""
    return [half for span in spans for middle in [(span.start + span.stop) // 2]
            for half in (slice(span.start, middle), slice(middle, span.stop))]


@dataclass(frozen=True)
class JointlyFiltered:
    """
    Runs of a filter over several recordings, their rows one after the other.

    deviance: -2 log L of all. innovation [N, 2], rad, 0 where nothing was read, and residual [N,
    2], the same in its standard deviations; variance [N, 2] of the innovations, rad^2, 1 where
    nothing was read; read [N, 2]: whether an encoder was read.
    """

    runs: tuple[Any, ...]
    deviance: float
    innovation: Array
    variance: Array
    read: Flags
    residual: Array

    @classmethod
    def of(cls, runs: Sequence[Any]) -> 'JointlyFiltered':
        """Return the runs of all recordings."""
        return cls(tuple(runs), sum(run.deviance for run in runs), *(
            np.concatenate([getattr(run, name) for run in runs])
            for name in ('innovation', 'variance', 'read', 'residual')))


class JointLikelihood:
    """
    Likelihood of models for several recordings of one drive, each with encoders of its own.

    parts: likelihood of each recording.
    """

    def __init__(self, parts: Sequence[Any]) -> None:
        self.parts = tuple(parts)

    @property
    def readings(self) -> int:
        """Number of readings that count."""
        return sum(part.readings for part in self.parts)

    @property
    def least_noise(self) -> Array:
        """Least torque noise [2] on motor and arm, N m rms in a sample, of any recording."""
        return np.min([part.least_noise for part in self.parts], axis=0)

    @property
    def most_noise(self) -> float:
        """Torque noise with which any recording is followed, N m rms in a sample."""
        return max(part.most_noise for part in self.parts)

    @property
    def first_noise(self) -> Array:
        """Torque noise [2] on motor and arm with which fits begin, N m rms in a sample."""
        return np.max([part.first_noise for part in self.parts], axis=0)

    def run(self, model: DriveModel, torque: Array) -> JointlyFiltered:
        """
        Return all recordings filtered under `model` with torque noise `torque` [2].

        Args:
            model: model of the drive.
            torque: noise of the torque on motor and arm, N m rms in a sample.
        """
        return JointlyFiltered.of([part.run(model, torque) for part in self.parts])

    def change(self, run: JointlyFiltered, model: DriveModel) -> Array:
        """
        Return the change [N, 2] (rad) of the innovations when the model becomes `model`.

        Args:
            run: run of the filter.
            model: a model close to that of the run.
        """
        return np.concatenate([part.change(own, model)
                               for part, own in zip(self.parts, run.runs)])

    def with_noise(self, run: JointlyFiltered, torque: Array) -> tuple[float, Array, Array]:
        """
        Return (-2 log L, innovations [N, 2], their variance [N, 2]) of `run` under other noise.

        Args:
            run: filter that was run.
            torque: noise of the torque on motor and arm, N m rms in a sample.
        """
        rows = [part.with_noise(own, torque) for part, own in zip(self.parts, run.runs)]
        return (sum(row[0] for row in rows), np.concatenate([row[1] for row in rows]),
                np.concatenate([row[2] for row in rows]))

    def smoothed(self, run: JointlyFiltered) -> list[Array]:
        """Return smoothed states [N, N_STATE] of each recording of `run`, NaN between parts."""
        return [part.smoothed(own) for part, own in zip(self.parts, run.runs)]


# A run is a Filtered or more of them.
Likelihood: TypeAlias = InnovationLikelihood | JointLikelihood


def _kernels_of(model: DriveModel) -> tuple[PackedDrive, tuple[Any, Any]]:
    """Return the PackedDrive of `model` and the kernels `filtered` and `sensitivity` for it."""
    plugin, drive = plugin_of(model)[0], packed_drive(model)
    if plugin is None:
        return drive, (kernels.filtered, kernels.sensitivity)
    return drive, kernels.with_plugin(plugin.torques)


def schedule(e: Array, dt: float, parts: int, channels: Sequence[int]) -> SampleSchedule:
    """
    Return the SampleSchedule of a sample.

    Args:
        e: packed effects.
        dt: length of a sample, s.
        parts: number of parts of a sample in each of which the torque is constant.
        channels: encoders that are read.
    """
    lag = np.array([e[DELAY1], e[DELAY2]]) / dt
    shift = np.floor(lag + ONCE)
    at = 1.0 - np.clip(lag - shift, 0.0, None)
    at[at > 1.0 - ONCE] = 1.0
    segments = _apart([*at[list(channels)], 1.0])
    reads = np.zeros((len(segments), 2), np.int64)
    for channel in channels:
        reads[np.abs(segments - at[channel]).argmin(), channel] = 1
    edges = _apart([*segments, *(np.arange(1, parts + 1) / parts)])
    begins = np.append(0.0, edges[:-1])
    part = np.minimum(parts - 1, np.floor(0.5 * (begins + edges) * parts)).astype(np.int64)
    near = np.abs(edges[:, None] - segments) <= ONCE
    return SampleSchedule((edges - begins) * dt, part, np.where(
        near.any(axis=1), near.argmax(axis=1), -1), np.diff(segments, prepend=0.0) * dt, reads,
        shift.astype(np.int64))


def _apart(times: Sequence[float]) -> Array:
    """Return times within a sample in their order, without those that are as good as equal."""
    ordered = np.sort(times)
    return ordered[np.diff(ordered, prepend=-1.0) > ONCE]


FAR = 2.0                    # change of the logarithm of the noise in a step
LOG_STEP = 0.05              # of finite differences in that logarithm
COORDINATE_STEP = 0.1        # of the steps of a candidate: a single sample is nearly linear
REACH = 3.0                  # a step is not longer than so many times value or scale
LOG_REACH = 1.5              # the same of coordinates that are logarithms
FACTORS = (1.5, 4.0, 16.0)   # by which the noise is tried, the next one after each gain
ENOUGH = 1e-3                # gain in -2 log L of a step that is taken
RULE = Damping(1e-4, 20.0, 1e-3, smallest=1e-9, attempts=5)
RIDGE = 1e-9                 # of the power of a column that is tested
UNHELPFUL = 1e-2             # damping after steps that did not help


@dataclass(frozen=True)
class InnovationFit:
    """
    State of the fit of a candidate.

    z [P] coordinates; torque [2] noise on motor and arm, N m; deviance: -2 log L with the prior,
    as the likelihood counts it, infinite before it is evaluated.
    """

    candidate: CandidateModel
    z: Array
    torque: Array
    deviance: float = math.inf

    @property
    def name(self) -> str:
        """Ids joined by '+'."""
        return self.candidate.name

    @property
    def model(self) -> DriveModel:
        """The model where the fit stands."""
        return self.candidate.model(self.z)


@dataclass(frozen=True)
class FilteredFit(InnovationFit):
    """An InnovationFit with the run of its filter, which needs much memory."""

    run: Any = field(kw_only=True)

    def alone(self) -> InnovationFit:
        """Return the InnovationFit without the run."""
        return InnovationFit(self.candidate, self.z, self.torque, self.deviance)


def unfitted(likelihood: Likelihood, candidate: CandidateModel,
             z: Array | None = None) -> InnovationFit:
    """
    Return where the fit of a candidate begins.

    Args:
        likelihood: of the recording.
        candidate: model with its coordinates.
        z: coordinates [P], None: the candidate's own start.
    """
    return InnovationFit(candidate, candidate.start() if z is None else z, likelihood.first_noise)


def evaluated(likelihood: Likelihood, fit: InnovationFit) -> FilteredFit:
    """
    Return a fit where it stands, with the run of its filter.

    Args:
        likelihood: of the recording.
        fit: of a candidate.
    """
    run = likelihood.run(fit.model, fit.torque)
    return FilteredFit(fit.candidate, fit.z, fit.torque,
                       run.deviance + fit.candidate.penalty(fit.z), run=run)


def annealed(likelihood: Likelihood, fit: FilteredFit) -> Array:
    """Return the torque noise [2] that is likeliest at `fit`, by tangents of `likelihood`."""
    torque, deviance = fit.torque, fit.run.deviance
    smallest, largest = likelihood.least_noise, likelihood.most_noise
    tried = {tuple(torque): math.inf}
    for sides in ([0, 1], [0], [1]):
        number, sign, failures = 0, -1.0, 0
        while failures < 2:
            trial = torque.copy()
            trial[sides] = np.clip(trial[sides] * FACTORS[number] ** sign, smallest[sides],
                                   largest)
            key = tuple(trial)
            if key not in tried:
                tried[key] = likelihood.with_noise(fit.run, trial)[0]
            value = tried[key]
            if value < deviance - 0.02:
                torque, deviance, failures = trial, value, 0
                number = min(number + 1, len(FACTORS) - 1)
            elif number:
                number -= 1
            else:
                sign, failures = -sign, failures + 1
    return torque


def coordinate_columns(likelihood: Likelihood, fit: FilteredFit, central: bool = False) -> Array:
    """
    Return the derivatives of whitened innovations [2 N, P] by the coordinates of a fit.

    Args:
        likelihood: of the recording.
        fit: where the model stands.
        central: whether differences are central; one-sided ones see what is not determined.
    """
    candidate, z = fit.candidate, fit.z
    steps = COORDINATE_STEP * candidate.steps()
    scale = 1.0 / np.sqrt(fit.run.variance)
    columns = np.empty((scale.size, len(z)))
    for i, step in enumerate(steps):
        moved = z.copy()
        moved[i] += step
        if candidate.bounded(moved)[i] != moved[i]:
            step = -step
            moved[i] = z[i] + step
        change = likelihood.change(fit.run, candidate.model(moved))
        if central:
            moved[i] = z[i] - step
            change = 0.5 * (change - likelihood.change(fit.run, candidate.model(moved)))
        columns[:, i] = (change * scale).ravel() / step
    columns[~np.isfinite(columns)] = 0.0
    return columns


def remaining(columns: Array, own: Array) -> Array:
    """Return columns [M, C] less what columns `own` [M, P] imitate."""
    return np.asarray(columns - own @ (covariance(own.T @ own) @ (own.T @ columns)))


@dataclass(frozen=True, eq=False)
class Tested:
    """
    A fit whose filter was run, beside which columns of its innovations are tested.

    own: derivatives [M, P] by its coordinates, which give way; residual [M]; both in standard
    deviations. Their last P rows are the prior of the coordinates.
    """

    likelihood: JointLikelihood
    at: FilteredFit
    own: Array
    residual: Array

    @classmethod
    def beside(cls, likelihood: JointLikelihood, fit: InnovationFit) -> 'Tested':
        """Return what may be tested beside `fit` on a `likelihood`."""
        at = evaluated(likelihood, fit)
        pull, weight = fit.candidate.prior(fit.z)
        root = np.sqrt(weight)
        return cls(likelihood, at,
                   np.concatenate([coordinate_columns(likelihood, at), np.diag(root)]),
                   np.append(at.run.residual, pull / np.where(root > 0.0, root, 1.0)))

    @cached_property
    def covariance(self) -> Array:
        """Covariance [P, P] of the coordinates."""
        return covariance(self.own.T @ self.own)

    def _yielding(self, columns: Array) -> Array:
        """Return the change of the coordinates [P, C] beside columns [N, C]."""
        return np.asarray(-self.covariance @ (self.own[:len(columns)].T @ columns))

    def without(self, columns: Array) -> Array:
        """Return columns [M, C] of innovations less what the coordinates of the fit imitate."""
        X = np.asarray(self.own @ self._yielding(columns))
        X[:len(columns)] += columns
        return X

    def step(self, columns: Array) -> tuple[float, Array, Array]:
        """
        Return the test of one linear step along `columns` [N, C] of innovations.

        Returns:
            Gain in -2 log L, step [C], change [P, C] of the coordinates per unit of the step.
        """
        # Squares of what remains: a difference of sums would not hold what is nearly imitated.
        X = self.without(columns)
        S = X.T @ X
        S[np.diag_indices_from(S)] += RIDGE * (columns ** 2).sum(axis=0) + 1e-300
        h = X.T @ self.residual
        step = np.linalg.solve(S, h)
        return float(h @ step), -step, self._yielding(columns)


def _noise_columns(likelihood: Likelihood, fit: FilteredFit) -> tuple[Array, Array]:
    """Return derivatives of whitened innovations and of log variances [2 N, 2] by log noise."""
    run = fit.run
    scale = 1.0 / np.sqrt(run.variance)
    means, spreads = np.empty((2, scale.size, 2))
    for i in range(2):
        torque = fit.torque.copy()
        torque[i] *= np.exp(LOG_STEP)
        _, innovation, variance = likelihood.with_noise(run, torque)
        means[:, i] = ((innovation - run.innovation) * scale).ravel() / LOG_STEP
        spreads[:, i] = np.log(variance / run.variance).ravel() / LOG_STEP
    return means, spreads


def fitted(likelihood: Likelihood, fit: InnovationFit, iterations: int = 12,
           tolerance: float = 0.5, free_noise: bool = True) -> InnovationFit:
    """
    Return the fit of maximum likelihood that `fit` leads to.

    Args:
        likelihood: of the recording.
        fit: start of the iterations, one with its run of the same likelihood as it is.
        iterations: at most so many.
        tolerance: gain in -2 log L below which it stops.
        free_noise: whether the torque noise is fitted, too.
    """
    damping = RULE.start
    at = fit if isinstance(fit, FilteredFit) else evaluated(likelihood, fit)
    for _ in range(iterations):
        torque = annealed(likelihood, at) if free_noise else at.torque
        deviance = at.deviance
        if (torque != at.torque).any():
            moved = evaluated(likelihood, replace(at.alone(), torque=torque))
            at = moved if moved.deviance < at.deviance else at
        at, damping = _step(likelihood, at, damping, free_noise)
        if deviance - at.deviance < tolerance:
            break
    return at.alone()


def _step(likelihood: Likelihood, fit: FilteredFit, damping: float,
          free_noise: bool) -> tuple[FilteredFit, float]:
    """Return `fit` after a Fisher step on coordinates and noise, and the damping of the next."""
    candidate, count = fit.candidate, len(fit.z)
    read = fit.run.read.ravel()
    residual = fit.run.residual.ravel()
    means, spreads = (_noise_columns(likelihood, fit) if free_noise
                      else np.zeros((2, len(residual), 2)))
    J = np.concatenate([coordinate_columns(likelihood, fit), means], axis=1)
    pull, weight = candidate.prior(fit.z)
    H = J.T @ J
    H[count:, count:] += 0.5 * spreads.T @ spreads
    H[range(count), range(count)] += weight
    g = J.T @ residual
    g[count:] += 0.5 * spreads.T @ (read - residual ** 2)
    g[:count] += pull
    smallest, largest = likelihood.least_noise, likelihood.most_noise
    moves = free_noise & ~((fit.torque <= smallest * 1.001) & (g[count:] > 0.0))
    free = np.array([*range(count), *(count + np.flatnonzero(moves))], int)
    if not len(free):
        return fit, damping
    log = np.array([c.log for c in candidate.coordinates], bool)
    scale = np.array([c.scale for c in candidate.coordinates])
    reach = np.where(log, LOG_REACH, REACH * np.maximum(np.abs(fit.z), scale))

    tried = [fit]

    def trial_of(change: Array) -> FilteredFit:
        step = np.zeros(count + 2)
        step[free] = -change
        z = candidate.bounded(fit.z + np.clip(step[:count], -reach, reach))
        torque = np.clip(fit.torque * np.exp(np.clip(step[count:], -FAR, FAR)), smallest,
                         largest) if free_noise else fit.torque
        for earlier in tried:  # bounds lead from several steps to one place
            if (z == earlier.z).all() and (torque == earlier.torque).all():
                return earlier
        tried.append(evaluated(likelihood, InnovationFit(candidate, z, torque)))
        return tried[-1]

    def gain_of(trial: FilteredFit) -> float:
        return fit.deviance - ENOUGH - trial.deviance
    normal, right = H[np.ix_(free, free)], g[free]
    if right @ damped_solve(normal, right, RULE.smallest) < ENOUGH:  # the most a step promises
        return fit, damping
    return damped_step(normal, right, trial_of, gain_of, damping, RULE) or (fit, UNHELPFUL)
