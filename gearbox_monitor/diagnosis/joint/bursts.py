# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Bursts: torque on the arm at times of its own, such as contacts.

A free-form torque is estimated in each window (input estimation) and reduced to one interval per
window, as far as BIC allows: that tells whether there are bursts, and about where. Begin, duration
and amplitude are those of the largest likelihood of innovations with their torque put in, which
knows no windows, and says what they are worth as for any effect.
"""
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint import basis_functions, localisation
from gearbox_monitor.diagnosis.joint.adequacy import adequacy_of
from gearbox_monitor.diagnosis.joint.evidence import Evidence
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated, fitted, InnovationFit
from gearbox_monitor.diagnosis.joint.innovations import JointLikelihood, JointlyFiltered
from gearbox_monitor.diagnosis.joint.localisation import (
    InputEstimate, reduced_chi2, SPACING, TORQUES, triangles)
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import WindowRuns
from gearbox_monitor.kernels.linear_least_squares import damped_step, Damping
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.effects.arm_side import burst
from gearbox_monitor.signals.uniform import UniformRecording

REFITTED = 6      # iterations of the fit beside bursts
ROUNDS = 3        # searches, each in the remainder of the previous one
ITERATIONS = 8    # of each fit of bursts
ANNEALED = 3      # fits of bursts, each with less torque noise, before one with the least
APART = 3         # s, after which a filter has forgotten a burst
FAR = 1e9         # s, from one recording to the next
LONGEST = 0.24    # s, of one burst where it is found
LITTLE = 0.02     # of the largest step: of finite differences
ENOUGH = 0.5      # gain in -2 log L for another iteration
RULE = Damping(1e-2, 20.0, 1e-3, smallest=1e-9, attempts=5)
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
    theta: Array = np.zeros((0, 3))
    owner: Integers = np.zeros(0, int)
    at, adequate, beside = fit, False, evidence
    for number in range(ROUNDS):
        rows = [pulses_in(run, number > 0) for run in runs]
        if not any(map(len, rows)):
            break
        theta = np.concatenate([theta, *rows])
        owner = np.concatenate([owner, *(np.full(len(own), i) for i, own in enumerate(rows))])
        theta, at = sharpened(evidence, at, theta, owner)
        beside = with_bursts(evidence, theta, owner)
        adequacy = adequacy_of(beside, at)
        adequate, runs = adequacy.adequate, adequacy.runs
        if adequate:
            break
    if not len(theta):
        return None
    gain = evaluated(evidence.whole, fit).deviance - evaluated(beside.whole, at).deviance
    bursts = [Burst(evidence.recordings[i].name, *map(float, row)) for i, row in zip(owner, theta)]
    return Bursts(at, tuple(sorted(bursts, key=lambda b: -abs(b.amplitude) * b.duration)), gain,
                  theta.size * float(np.log(evidence.whole.readings)), adequate)


def with_bursts(evidence: Evidence, theta: Array, owner: Integers) -> Evidence:
    """
    Return the evidence of recordings in which bursts act on the arm.

    Args:
        evidence: the recordings.
        theta: begin (s), duration (s) and amplitude (N m) of each burst [B, 3].
        owner: number of its recording [B].
    """
    # Beside a load that was measured.
    return replace(evidence, recordings=tuple(
        replace(r, arm_torque=(0.0 if r.arm_torque is None else r.arm_torque)
                - torque_of(theta[owner == i], r)) for i, r in enumerate(evidence.recordings)))


def torque_of(theta: Array, recording: UniformRecording) -> Array:
    """Return the torque [N], N m, of the bursts `theta` [B, 3] of a recording."""
    t = np.arange(len(recording.u)) * recording.dt
    return sum((burst(dict(zip(('t0', 'duration', 'amplitude'), row)), t, recording.dt)
                for row in theta), np.zeros(len(t)))


def sharpened(evidence: Evidence, fit: InnovationFit, theta: Array,
              owner: Integers) -> tuple[Array, InnovationFit]:
    """
    Return (bursts [B, 3], fit beside them) of largest likelihood, searched from `theta` on.

    Torque noise as large as the remainder smooths the likelihood; it shrinks as the bursts fit.

    Args:
        evidence: the recordings.
        fit: that leaves the bursts.
        theta: bursts to begin with, see with_bursts.
        owner: see with_bursts.
    """
    fits = []
    for cold in (False,) * ANNEALED + (True,):
        torque = evidence.whole.least_noise if cold else fit.torque
        theta = _likeliest(evidence, replace(fit, torque=torque), theta, owner)
        fit = fitted(with_bursts(evidence, theta, owner).fine, fit, REFITTED)
        fits.append((theta, fit))
    return min(fits, key=lambda pair: pair[1].deviance)


def _likeliest(evidence: Evidence, fit: InnovationFit, theta: Array, owner: Integers) -> Array:
    """Return the bursts [B, 3] of largest likelihood beside `fit` as it is, from `theta` on."""
    model, damping = fit.model, RULE.start
    shortest = min(recording.dt for recording in evidence.recordings)
    amplitude = LITTLE * evidence.torque

    def beside(theta: Array) -> tuple[Array, JointlyFiltered]:
        """Return bursts and the filter with them, which begins as without."""
        loaded = JointLikelihood([part.loaded(torque_of(theta[owner == i], part.recording))
                                  for i, part in enumerate(evidence.whole.parts)])
        return theta, loaded.run(model, fit.torque)

    def moved_by(theta: Array, reach: Array, change: Array) -> tuple[Array, JointlyFiltered]:
        """Return where a step leads to, at most `reach` [B, 3] away."""
        theta = theta - np.clip(change.reshape(-1, 3), -reach, reach)
        theta[:, 1] = np.maximum(theta[:, 1], shortest)
        return beside(theta)
    run = beside(theta)[1]
    times = np.concatenate([number * FAR + np.repeat(np.arange(len(recording.u)) * recording.dt, 2)
                            for number, recording in enumerate(evidence.recordings)])
    for _ in range(ITERATIONS):
        reach = np.full(theta.shape, SPACING)
        reach[:, 2] = np.maximum(np.abs(theta[:, 2]), amplitude)
        steps, J = LITTLE * reach, np.zeros((run.variance.size, theta.size))
        for members in _apart(theta, owner):
            begins = owner[members] * FAR + theta[members, 0] - SPACING
            cause = np.searchsorted(begins, times) - 1
            for i in range(3):
                moved = theta.copy()
                moved[members, i] += steps[members, i]
                change = (beside(moved)[1].innovation - run.innovation) / np.sqrt(run.variance)
                for number, member in enumerate(members):
                    J[cause == number, 3 * member + i] = (
                        change.ravel()[cause == number] / steps[member, i])
        enough = run.deviance - ENOUGH
        step = damped_step(
            J.T @ J, J.T @ run.residual.ravel(), partial(moved_by, theta, reach),
            partial(_gain, enough), damping, RULE)
        if step is None:
            break
        (theta, run), damping = step
    return theta


def _gain(enough: float, trial: tuple[Array, JointlyFiltered]) -> float:
    """Return by how much a trial is below a -2 log L that is enough."""
    return enough - trial[1].deviance


def _apart(theta: Array, owner: Integers) -> list[Integers]:
    """Return numbers of bursts in the order of time, in groups of those that are APART."""
    begins = owner * FAR + theta[:, 0]
    order = np.argsort(begins)
    groups = next(count for count in range(1, len(order) + 1)
                  if (begins[order[count:]] - begins[order[:-count]] > APART).all())
    return [order[first::groups] for first in range(groups)]


def pulses_in(runs: WindowRuns, beside: bool = False) -> Array:
    """
    Return the bursts [B, 3] that free runs lack, see with_bursts.

    Args:
        runs: free runs over the windows of one recording.
        beside: whether bursts act that have passed the checks: any window may hold another one.
    """
    data, size = runs.data, runs.data.size
    places = localisation.visible_places(runs)
    if 'arm_side' not in places or (
            runs.chi2 < THRESHOLDS.quiet * size).mean() < THRESHOLDS.quiet_share:
        return np.zeros((0, 3))
    free = localisation.free_forms(runs, ('arm_side',))['arm_side']
    bursts, bursting = rectangles(free, 3.0 * float(np.log(size)),
                                  beside | (runs.chi2 > THRESHOLDS.quiet * size))
    use = bursting.any(axis=1)
    if not use.any() or (~use).mean() < THRESHOLDS.quiet_share or not beside and (
            motion_share(runs, free, bursting) > THRESHOLDS.burst_law
            or at_ends_of_travel(runs, free, bursting) < THRESHOLDS.burst_chance
            or sine_share(runs, free) > THRESHOLDS.burst_sine
            or advantage_of_other_places(runs, free) > THRESHOLDS.elsewhere):
        return np.zeros((0, 3))
    bursts[:, 0] += data.windows.first[use] * runs.recording.dt
    return bursts


def rectangles(free: InputEstimate, price: float, lacking: Flags) -> tuple[Array, Flags]:
    """
    Return the bursts in a free-form torque to first order, and which values [W, H] they cover.

    At most one in each window: that of the largest likelihood ratio (Willsky and Jones, 1976),
    the torque elsewhere being 0.

    Args:
        free: free-form input estimate.
        price: chi2 that a burst must gain (BIC), beside that of its place.
        lacking: windows [W] that may have one.

    Returns:
        Bursts [B, 3], their begin from that of the window, and the values [W, H] that they cover.
    """
    windows, values = free.signal.shape
    price += 2.0 * float(np.log(values * (values + 1) / 2))
    bursts, covered = [], np.zeros((windows, values), bool)
    for window in np.flatnonzero(lacking):
        precision, signal = free.precision[window], free.signal[window]
        force = precision @ signal
        highest, amplitude, begin, end = price, 0.0, 0, 0
        for first in range(values):
            for last in range(first, min(first + round(LONGEST / SPACING), values)):
                run = slice(first, last + 1)
                along, power = float(force[run].sum()), float(precision[run, run].sum())
                if along ** 2 > highest * power:
                    highest, amplitude = along ** 2 / power, along / power
                    begin, end = first, last + 1
        if end:
            covered[window, begin:end] = True
            bursts.append(((begin - 0.5) * SPACING, (end - begin) * SPACING, amplitude))
    return np.array(bursts).reshape(-1, 3), covered


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
    at, positions = windows.samples, runs.positions
    moved = {**basis_functions.motion(positions, recording.dt),
             'torque': recording.torque,
             'speed of the arm': basis_functions.motion(
                 positions[:, ::-1], recording.dt)['speed']}
    del moved['time']
    # A burst across the edge of two windows is one.
    bursting = mask.any(axis=1)
    across = mask[:-1, -2:].any(axis=1) & mask[1:, :2].any(axis=1)
    number = np.cumsum(bursting & ~np.concatenate([[False], across]))
    quiet = number[-1] + np.arange(len(mask)) % basis_functions.FOLDS
    fold = np.where(bursting, number - 1, quiet)
    basis, share = triangles(windows.length, 0, recording.dt), 0.0
    for name, value in moved.items():
        x = value[at]
        shares, overall = basis_functions.shares_foretold(
            x, free.signal, free.precision, basis, basis_functions.edges_over(name, x), fold)
        each = np.quantile(shares[:, :number[-1]], QUARTILE, axis=1, method='lower')
        share = max(share, float(each[overall > 0.0].max(initial=0.0)))
    return share


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
    arm = runs.positions[:, 1]
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


def advantage_of_other_places(runs: WindowRuns, free: InputEstimate) -> float:
    """
    Return by how much chi2 a free torque at another place explains more than `free`.

    Args:
        runs: free runs over the windows of one recording.
        free: free-form torque on the arm.
    """
    places = [place for place in localisation.visible_places(runs)
              if place in TORQUES and place != 'arm_side']
    smallest = min((reduced_chi2([f]) for f in localisation.free_forms(runs, places).values()),
                   default=np.inf)
    return float(reduced_chi2([free]) - smallest) * runs.residual.size
