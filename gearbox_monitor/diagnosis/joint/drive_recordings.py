# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a diagnosis has to go by: recordings, model, noise, and likelihoods of their parts."""
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, InnovationLikelihood, JointLikelihood, noise_floor, SPARSE,
    unfitted, WHITE)
from gearbox_monitor.diagnosis.joint.torque_domain import likelihood_of
from gearbox_monitor.diagnosis.joint.windows import (
    free_runs, hidden_begins, seconds_at_rest, SETTLING, window_data, WindowData, WindowRuns)
from gearbox_monitor.diagnosis.settings import CONTEST, THRESHOLDS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.signals.uniform import UniformRecording

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
    named. quantum [2]: quantisation steps of the encoders, rad. with_map: whether a torque map of
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
        return tuple(window_data(r, self.model, self.level, self.correlation,
                                 SETTLING if not self.hides(r) else max(
                                     SETTLING, seconds_at_rest(r, self.sigma)), self.finer)
                     for r in self.recordings)

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
        return Starts(self.model, self.recordings)

    def _likelihood(self, coarse: bool = False) -> JointLikelihood:
        sigma = self.sigma
        parts = []
        for number, (recording, segment) in enumerate(zip(self.recordings, self.segments)):
            part = likelihood_of(recording, self.model, sigma,
                                 self._between_slips(number, segment.span), coarse, self.finer)
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
        """Likelihood of the recordings, on larger steps; usual ones where short ones show."""
        return replace(self, finer=1)._likelihood(coarse=self.finer == 1)

    @cached_property
    def fine(self) -> JointLikelihood:
        """Likelihood of all that is evidence."""
        return self._likelihood()

    def lasting_for(self, seconds: float) -> 'DriveRecordings':
        """Return the evidence where unexplained torque lasts so long."""
        if seconds == self.model.process_torque_time:
            return self
        return replace(self, model=replace(self.model, process_torque_time=seconds))

    @property
    def sparse(self) -> JointLikelihood:
        """Likelihood of all that is evidence, of as few readings as where torque lasts."""
        return JointLikelihood([part.changed(every=max(1, round(SPARSE / part.recording.dt)))
                                for part in self.fine.parts])

    @property
    def step(self) -> float:
        """Length of an integration step, s."""
        return min(part.recording.dt / part.simulator.n for part in self.fine.parts)

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
        allowed = self.fine.least_noise
        if self.model.process_torque:
            allowed = np.maximum(allowed, self.model.process_torque)
        if self.model.lasting:
            allowed = np.maximum(allowed, THRESHOLDS.lasting_torque * self.torque)
        elif self.noisy:
            allowed = np.maximum(allowed, THRESHOLDS.torque_noise * self.torque)
        return allowed

    def runs(self, fit: InnovationFit, overlapping: bool = False) -> tuple[WindowRuns, ...]:
        """Return free runs of a `fit` over windows, or `overlapping` ones, of each recording."""
        at, model = evaluated(self.fine, fit), fit.model
        return self.calm(
            free_runs(segment.overlapping if overlapping else segment, model, smooth)
            for segment, smooth in zip(self.segments, self.fine.smoothed(at.run)))

    def beyond_share(self, fit: InnovationFit) -> float:
        """
        Return the gain in -2 log L of more torque than a model of a real drive may leave.

        Where the motion is put in, what remains is the noise of the balance.
        """
        at = evaluated(self.fine, fit)
        left = np.sqrt(np.mean([run.left ** 2 for run in at.run.runs], axis=0))
        ratio = float((left / self.scales).max() / THRESHOLDS.lasting_torque) ** 2
        return self.fine.readings * max(0.0, ratio - 1.0 - math.log(max(ratio, 1.0)))

    def unexplained_by_free_runs(self, fit: InnovationFit) -> float:
        """
        Return the gain in -2 log L of torque noise beyond the allowed.

        A filter is linearised about one state. Of a side that no encoder reads it may lose track
        in the gap, and noise stands for that: what a free run explains there, the model explains.
        """
        at = evaluated(self.fine, fit)
        quiet = self.fine.run(at.model, np.minimum(at.torque, self.allowed_noise))
        gain = quiet.deviance - at.run.deviance
        for run, filtered in zip(self.runs(fit), quiet.runs):
            if self.hides(run.recording):
                rows = np.maximum(run.data.windows.samples - 1, 0)
                explained = filtered.deviances[rows].sum(axis=(1, 2)) - (
                    run.chi2 - run.data.size + run.states.shape[1])
                gain -= float(np.maximum(explained, 0.0).sum())
        return gain

    def score(self, fit: InnovationFit) -> float:
        """Return the BIC (Schwarz 1978) of a fit."""
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
EARLY, HALF, LATE = SHIFTS = 0.0, 0.25, 0.5  # sample times by which a sampled torque acts later


def is_open(recording: UniformRecording, model: DriveModel) -> bool:
    """Return whether `recording` is so slow that torque of `model` may hide between its stamps."""
    return (recording.dt * THRESHOLDS.slow_rate > 1.0 and model.controller is None
            and model.driven_by == 'torque')


def likeliest(evidence: DriveRecordings, fit: InnovationFit,
              slow: bool = True) -> tuple[DriveRecordings, InnovationFit]:
    """
    Return (the recordings, `fit`), both as they were where another reading gains nothing.

    How torque acted between the stamps of a log is a nuisance: held, or sampled a share of a
    sample before each stamp. Values of the fit move along with it.

    Args:
        evidence: the recordings, as they were read so far.
        fit: of one model to all of them.
        slow: whether logs are read again that are slow, or those that are not.
    """
    torque = evidence.model.controller is None and evidence.model.driven_by == 'torque'
    for number, recording in enumerate(evidence.recordings if torque else ()):
        if is_open(recording, evidence.model) == slow:
            evidence, fit = _read(evidence, fit, number)
    return evidence, fit


def likeliest_reading(evidence: DriveRecordings) -> DriveRecordings:
    """Return the recordings, read so that the model without effects is likeliest."""
    return likeliest(evidence, unfitted(evidence.fine, evidence.starts.none()))[0]


def _read(evidence: DriveRecordings, fit: InnovationFit, number: int
          ) -> tuple[DriveRecordings, InnovationFit]:
    """Return (the recordings, fit), one of them read so that the fit is likeliest."""
    tried: dict[float | None, tuple[float, DriveRecordings, InnovationFit]] = {}
    recordings = evidence.recordings
    now = recordings[number].shift

    def read(shift: float | None) -> float:
        if shift not in tried:
            data = replace(evidence, recordings=(
                *recordings[:number], replace(recordings[number], shift=shift),
                *recordings[number + 1:]))
            moved = fitted(data.fine, fit, ITERATIONS)
            tried[shift] = data.score(moved), data, moved
        return tried[shift][0]
    if now is None and not is_open(recordings[number], evidence.model) and (
            read(HALF) > evidence.score(fit) - CONTEST.margin):
        return evidence, fit  # half way gains most of what there is
    # About its minimum the score is a parabola of the shift.
    square, slope, _ = np.polyfit(SHIFTS, [read(shift) for shift in SHIFTS], 2)
    best = [float(np.clip(-0.5 * slope / square, EARLY, LATE))] if square > 0.0 else []
    for shift in (now, None, *best):
        read(shift)
    score, data, moved = min(tried.values(), key=lambda found: found[0])
    return (data, moved) if score < tried[now][0] - CONTEST.margin else (evidence, fit)
