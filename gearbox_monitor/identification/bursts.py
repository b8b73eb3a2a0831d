# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Bursts: torque on the arm at times of its own, such as contacts.

A free-form torque is estimated in each window (input estimation) and reduced to one interval per
window, as far as BIC allows. What the bursts are worth is then said by the same likelihood as
that of any effect: innovations with their torque put in.
"""
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.identification import basis_functions, input_estimation, localisation
from gearbox_monitor.identification.adequacy import adequacy_of
from gearbox_monitor.identification.evidence import Evidence
from gearbox_monitor.identification.innovation_fit import evaluated, fitted, InnovationFit
from gearbox_monitor.identification.input_estimation import InputEstimate, SPACING, triangles
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.windows import WindowRuns
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.quality.recording import UniformRecording

REFITTED = 6      # iterations of the fit beside bursts
QUARTILE = 0.25   # of the bursts: the law misses one of five or more


@dataclass(frozen=True)
class Burst:
    """One burst: the recording it is in, begin and duration (s), largest torque (N m, signed)."""

    recording: str
    t0: float
    duration: float
    amplitude: float


@dataclass(frozen=True, eq=False)
class Bursts:
    """
    Bursts beside a fit.

    fit: refitted beside them; bursts, the largest first; gain: in -2 log L of all that is
    evidence, price: of the values of their torque; adequate: whether noise alone is left.
    """

    fit: InnovationFit
    bursts: tuple[Burst, ...]
    gain: float
    price: float
    adequate: bool


def bursts_beside(evidence: Evidence, fit: InnovationFit,
                  runs: tuple[WindowRuns, ...]) -> Bursts | None:
    """
    Return the bursts that a fit leaves, None if the recordings do not look like it.

    Args:
        evidence: the recordings.
        fit: that leaves more than noise.
        runs: its free runs over the windows.
    """
    pulses = [pulses_in(run, evidence.jobs) for run in runs]
    if all(torque is None for torque, _, _ in pulses):
        return None
    recordings = tuple(
        recording if torque is None else with_arm_torque(recording, torque)
        for recording, (torque, _, _) in zip(evidence.recordings, pulses))
    beside = replace(evidence, recordings=recordings)
    at = fitted(beside.fine, fit, REFITTED)
    deviance = evaluated(beside.whole, at.candidate, at.z, at.torque).deviance
    gain = evaluated(evidence.whole, fit.candidate, fit.z, fit.torque).deviance - deviance
    bursts = sorted((burst for _, _, rows in pulses for burst in rows),
                    key=lambda b: -abs(b.amplitude) * b.duration)
    return Bursts(at, tuple(bursts), gain, sum(price for _, price, _ in pulses),
                  adequacy_of(beside, at).adequate)


def with_arm_torque(recording: UniformRecording, torque: Array) -> UniformRecording:
    """
    Return a recording in which `torque` acts on the arm, beside a load that was measured.

    Args:
        recording: of one drive.
        torque: in the direction of the motion [N], N m.
    """
    load = np.zeros(len(recording.u)) if recording.arm_torque is None else recording.arm_torque
    return replace(recording, arm_torque=load - torque)


def pulses_in(runs: WindowRuns, jobs: int) -> tuple[Array | None, float, list[Burst]]:
    """
    Return (torque [N] on the arm, N m, its price in BIC, bursts), (None, 0, []) without bursts.

    Args:
        runs: free runs over the windows of one recording.
        jobs: number of threads.
    """
    nothing: tuple[Array | None, float, list[Burst]] = None, 0.0, []
    data, size = runs.data, runs.data.size
    places = localisation.visible_places(runs)
    if 'arm_side' not in places or (
            runs.chi2 < THRESHOLDS.quiet * size).mean() < THRESHOLDS.quiet_share:
        return nothing
    free = localisation.free_forms(runs, jobs, places=('arm_side',))['arm_side']
    price = float(np.log(size))
    mask, cost = best_pulses(free, price)
    if not mask.any():
        return nothing
    fit = input_estimation.InputEstimator(data, runs.model, free.place, runs.point)
    pulse = fit.solve(free.states, free.signal * mask, fixed=~mask)
    # From the same states: what these are worth is no merit of a burst.
    quiet = fit.solve(free.states, fixed=np.ones_like(mask))
    use = mask.any(axis=1) & (np.minimum(quiet.chi2, runs.chi2) - pulse.chi2 > cost)
    bursting = use[:, None] & mask
    if (not use.any() or (~use).mean() < THRESHOLDS.quiet_share
            or motion_share(runs, free, bursting) > THRESHOLDS.burst_law
            or at_ends_of_travel(runs, free, bursting) < THRESHOLDS.burst_chance
            or sine_share(runs, free) > THRESHOLDS.burst_sine
            or advantage_of_other_places(runs, free, jobs) > THRESHOLDS.elsewhere):
        return nothing
    recording = runs.recording
    basis = triangles(data.windows.length, 0, recording.dt)
    signal = np.where(bursting, pulse.signal, 0.0)
    torque = np.zeros(len(recording.u))
    bursts = []
    for first, row in zip(data.windows.first, signal):
        torque[first:first + data.windows.length] = basis @ row
        own = np.flatnonzero(row)
        if len(own):
            bursts.append(Burst(recording.name, float(first * recording.dt + own[0] * SPACING),
                                float((own[-1] - own[0] + 1) * SPACING),
                                float(row[np.argmax(np.abs(row))])))
    return torque, float(cost[use].sum()), bursts


def best_pulses(free: input_estimation.InputEstimate, price: float) -> tuple[Flags, Array]:
    """
    Return (mask [W, H] of the values in a pulse, cost [W] of the pulse), to first order.

    Each window holds one interval of values or none; its position costs two more numbers.

    Args:
        free: free-form input estimate.
        price: chi2 that one value of the signal must gain (BIC).
    """
    windows, values = free.signal.shape
    b = np.einsum('wij,wj->wi', free.precision, free.signal)
    # A window in which nothing moves says nothing of a torque: its precision may be all 0.
    trace = np.trace(free.precision, axis1=1, axis2=2)
    weak = np.maximum(1e-9 * trace, 1e-300)[:, None, None]
    place = 2.0 * np.log(values * (values + 1) / 2)
    runs, cost, highest = np.zeros((windows, values), bool), np.zeros(windows), np.zeros(windows)
    for size in range(1, values + 1):
        for first in range(values + 1 - size):
            run = slice(first, first + size)
            gain = np.einsum('wi,wi->w', b[:, run], np.linalg.solve(
                free.precision[:, run, run] + weak * np.eye(size), b[:, run, None])[:, :, 0])
            improved = gain - price * size - place > highest
            highest[improved] = (gain - price * size - place)[improved]
            cost[improved] = price * size + place
            runs[improved] = False
            runs[improved, run] = True
    return runs, cost


def motion_share(runs: WindowRuns, free: InputEstimate, mask: Flags) -> float:
    """
    Return the largest share of bursts that a function of what the drive does foretells.

    A law acts whenever its condition is met: it must foretell a burst from all the others, and no
    torque where there is none. Of few bursts a law that is fitted to them explains all.

    Args:
        runs: free runs over the windows of one recording.
        free: free-form input estimate.
        mask: values in a burst [W, H].
    """
    recording, windows = runs.recording, runs.data.windows
    at = windows.first[:, None] + np.arange(windows.length)
    positions = runs.data.positions(runs.model, runs.point)
    moved = {**basis_functions.motion(positions, recording.dt),
             'torque': recording.torque,
             'speed of the arm': basis_functions.motion(
                 positions[:, ::-1], recording.dt)['speed']}
    del moved['time']
    # A burst across the edge of two windows is one.
    burst, across = mask.any(axis=1), mask[:-1, -2:].any(axis=1) & mask[1:, :2].any(axis=1)
    number = np.cumsum(burst & ~np.concatenate([[False], across]))
    fold = np.where(burst, number - 1, number[-1] + np.arange(len(burst)) % basis_functions.FOLDS)
    basis, most = triangles(windows.length, 0, recording.dt), 0.0
    for name, value in moved.items():
        x = value[at]
        shares, overall = basis_functions.shares_foretold(
            x, free.signal, free.precision, basis, basis_functions.edges_over(name, x), fold)
        each = np.quantile(shares[:, :number[-1]], QUARTILE, axis=1, method='lower')
        most = max(most, float(each[overall > 0.0].max(initial=0.0)))
    return most


def at_ends_of_travel(runs: WindowRuns, free: InputEstimate, mask: Flags) -> float:
    """
    Return the probability that bursts at times of their own push the arm back where it turns.

    What the arm cannot pass (a stop, a contact) acts where the travel ends. Of a burst at a time
    of its own, the share of the samples that lie farther in the direction which it opposes is
    uniform; those of all bursts are combined (Fisher's method).

    Args:
        runs: free runs over the windows of one recording.
        free: free-form input estimate.
        mask: values in a burst [W, H].
    """
    recording, windows = runs.recording, runs.data.windows
    arm = runs.data.positions(runs.model, runs.point)[:, 1]
    beyond = []
    for w in np.flatnonzero(mask.any(axis=1)):
        h = int(np.argmax(np.abs(free.signal[w]) * mask[w]))
        at = int(windows.first[w]) + round(h * SPACING / recording.dt)
        side = -np.sign(free.signal[w, h])
        beyond.append(float(np.mean(side * arm >= side * arm[min(at, len(arm) - 1)])))
    return float(scipy.stats.combine_pvalues(np.maximum(beyond, 1.0 / len(arm))).pvalue)


def sine_share(runs: WindowRuns, free: InputEstimate) -> float:
    """
    Return the largest share of `free`, beyond noise, that one sine over time explains.

    Args:
        runs: free runs over the windows of one recording.
        free: free-form input estimate.
    """
    first = runs.data.windows.first[:, None] * runs.recording.dt
    t = first + np.arange(free.signal.shape[1]) * SPACING
    finest = 0.25 / np.ptp(t)
    pulls = np.einsum('whk,wk->wh', free.precision, free.signal)
    gain = 0.0
    for frequency in np.arange(finest, 0.5 / SPACING, finest):
        wave = np.exp(2j * np.pi * frequency * t)
        columns = np.stack([wave.real, wave.imag], axis=2)
        gram = np.einsum('whc,whd->cd', columns, free.precision @ columns)
        pull = np.einsum('whc,wh->c', columns, pulls)
        gain = max(gain, float(pull @ np.linalg.lstsq(gram, pull, rcond=None)[0]))
    beyond = float((pulls * free.signal).sum()) - free.signal.size
    return gain / beyond if beyond > 0.0 else 0.0


def advantage_of_other_places(runs: WindowRuns, free: InputEstimate, jobs: int) -> float:
    """
    Return by how much chi2 a free torque at another place explains more than `free`.

    Args:
        runs: free runs over the windows of one recording.
        free: free-form input estimate.
        jobs: number of threads.
    """
    places = [place for place in localisation.visible_places(runs)
              if place in input_estimation.TORQUES and place != free.place]
    estimates = localisation.free_forms(runs, jobs, places)
    smallest = min((input_estimation.reduced_chi2([f]) for f in estimates.values()),
                   default=np.inf)
    return float(input_estimation.reduced_chi2([free]) - smallest) * free.residual.size
