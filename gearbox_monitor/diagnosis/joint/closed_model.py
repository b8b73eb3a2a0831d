# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The closed model: how far it reduces the misfit on windows that were not fitted, and overlays.

An overlay shows free runs over windows of 1 s, and one over the whole recording.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.contest import STATEMENTS
from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, Starts
from gearbox_monitor.diagnosis.joint.drive_recordings import (
    free_runs, misfit_of, runs_from, SECONDS, solve_states, window_data, WindowData, WindowRuns)
from gearbox_monitor.diagnosis.joint.innovations import (
    fitted, JointLikelihood, noise_floor, spectrum, unfitted)
from gearbox_monitor.diagnosis.joint.shooting import N_MEMORY, ShootingWindows
from gearbox_monitor.diagnosis.joint.torque_domain import driven, likelihood_of
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.batch import Begin
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.uniform import UniformRecording

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

    gap_before, gap_after, closed_fraction on the held-out windows; closed_fraction_ci [low, high],
    90 %, of all windows (both None where the gap before may be noise); channels:
    {name: {before, after, closed}}.

    Args:
        before: free runs of the model as published, of each recording.
        after: free runs of the model that closes the gap.
        claims: whether that model contains anything that repeats.
        seed: seed of the random numbers.
    """
    gaps = misfit_of(before, held_out=True), misfit_of(after, held_out=True)
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
        else:  # it judges all windows, the fraction the held-out ones
            interval = [min(interval[0], fraction), max(interval[1], fraction)]
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'floor': 1.0, 'closed_fraction': fraction,
            'closed_fraction_ci': interval, 'channels': _channels(before, after)}


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


def _channels(before: Sequence[WindowRuns], after: Sequence[WindowRuns]
              ) -> dict[str, dict[str, float | None]]:
    """Return {channel: figures} of the windows that are held out."""
    every = not any(run.data.held_out.any() for run in after)
    out: dict[str, dict[str, float | None]] = {}
    for number, name in enumerate(after[0].recording.readings):
        gaps = []
        for runs in (before, after):
            powers = [run.residual[run.data.held_out | every][
                :, :, run.data.channels.index(number)].ravel() ** 2
                for run in runs if number in run.data.channels]
            gaps += [math.sqrt(float(np.concatenate(powers).mean()))] if powers else []
        if gaps:
            out[name] = {'before': gaps[0], 'after': gaps[1], 'closed': closed_of(*gaps)}
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
        data = replace(data, windows=like.windows, held_out=like.held_out)
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

    {'gap_before', 'gap_after', 'closed_fraction', 'windows', 'free_run': {'seconds', 'before',
    'after': {'motor' or 'torque', 'arm': rms from the first window on}}}; None: the run diverges.

    Args:
        recording: recording of the drive.
        nominal: model before the diagnosis.
        closed: model with the effects that were identified.
        sigma: noise of the encoders [2], rad.
    """
    recording = driven(recording, nominal)
    plain = [open_loop(recording, model, sigma) for model in (nominal, closed)]
    fits = with_starts_of(plain, plain[::-1])
    gaps = [misfit_of([run]) for run in fits]
    runs = []
    for run in fits:
        off = rms(recording, free_run(run))
        runs.append({name: float(v) if np.isfinite(v) else None
                     for name, v in zip(recording.readings, off)})
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'closed_fraction': closed_of(*gaps),
            'windows': len(fits[0].chi2),
            'free_run': {'seconds': float(recording.duration), 'before': runs[0],
                         'after': runs[1]}}


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

    t [W, L] s and measured [W, L, 2] rad; validation [W]: whether a diagnosis holds the window
    out; sigma [2] rad, noise of the encoders; channels: the encoders that there are.
    """

    recording: UniformRecording
    windows: ShootingWindows
    t: Array
    measured: Array
    validation: Flags
    sigma: Array
    channels: tuple[int, ...]
    runs: tuple[ModelRun, ...]

    def residual(self, run: ModelRun) -> Array:
        """
        Return measured less modelled [W, L, C] of the encoders `channels`, in sigma.

        Args:
            run: simulated readings of one model.
        """
        use = list(self.channels)
        return ((self.measured - run.y) / self.sigma)[:, :, use]


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
    return Overlay(recording, windows, recording.t[windows.samples], recording.y[windows.samples],
                   fits[0].data.held_out, np.asarray(sigma, float), recording.channels,
                   tuple(runs))
