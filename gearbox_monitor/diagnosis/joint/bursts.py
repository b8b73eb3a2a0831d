# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Bursts: torque on the arm at times of its own, such as contacts.

A free-form torque is estimated in each window (input estimation) and reduced to one interval per
window, as far as its price allows: that tells about where bursts may be. Begin, duration and
amplitude are those of the largest likelihood of innovations with their torque put in, which knows
no windows, and says what they are worth as for any effect.
"""
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gearbox_monitor.diagnosis.joint import localisation
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    evaluated, fitted, InnovationFit)
from gearbox_monitor.diagnosis.joint.innovations import (
    JointLikelihood, JointlyFiltered, named_motion)
from gearbox_monitor.diagnosis.joint.localisation import InputEstimate, SPACING
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import WindowRuns
from gearbox_monitor.kernels.linear_least_squares import damped_step, Damping
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.effects.arm_side import burst
from gearbox_monitor.signals.uniform import UniformRecording

REFITTED = 6      # iterations of the fit beside bursts
ITERATIONS = 8    # of each fit of bursts
ANNEALED = 3      # fits of bursts, each with less torque noise, before one with the least
APART = 3         # s, after which a filter has forgotten a burst
FAR = 1e9         # s, from one recording to the next
LITTLE = 0.02     # of the largest step: of finite differences
EDGES = 5.0       # percent of the time of bursts about either end of a range of the motion
ENOUGH = 0.5      # gain in -2 log L for another iteration
RULE = Damping(1e-2, 20.0, 1e-3, smallest=1e-9, attempts=5)


@dataclass(frozen=True)
class Burst:
    """One burst: the recording it is in, begin and duration (s), largest torque (N m, signed)."""

    recording: str
    t0: float
    duration: float
    amplitude: float


def with_bursts(evidence: DriveRecordings, theta: Array, owner: Integers) -> DriveRecordings:
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


def sharpened(evidence: DriveRecordings, fit: InnovationFit, theta: Array, owner: Integers,
              least: float) -> tuple[Array, InnovationFit]:
    """
    Return (bursts [B, 3], fit beside them) of largest likelihood, searched from `theta` on.

    Torque noise as large as the remainder smooths the likelihood; it shrinks as the bursts fit.

    Args:
        evidence: the recordings.
        fit: that leaves the bursts.
        theta: bursts to begin with, see with_bursts.
        owner: see with_bursts.
        least: gain in -2 log L of the first round, without which the bursts are given up.
    """
    fits, begin = [], evaluated(evidence.whole, fit).deviance
    for cold in (False,) * ANNEALED + (True,):
        torque = evidence.whole.least_noise if cold else fit.torque
        theta = _likeliest(evidence, replace(fit, torque=torque), theta, owner)
        fit = fitted(with_bursts(evidence, theta, owner).whole, fit, REFITTED)
        fits.append((theta, fit))
        if begin - fit.deviance < least:
            break
    return min(fits, key=lambda pair: pair[1].deviance)


def _likeliest(evidence: DriveRecordings, fit: InnovationFit, theta: Array,
               owner: Integers) -> Array:
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


def follows_motion(whole: JointLikelihood, fit: InnovationFit, theta: Array, owner: Integers
                   ) -> bool:
    """
    Return whether bursts fill the time in which one quantity of the motion is in one range.

    Bursts at times of their own leave the range that the quantity has during several of them to
    most other times, too.

    Args:
        whole: likelihood of the recordings.
        fit: of the model without bursts.
        theta: bursts, see with_bursts.
        owner: see with_bursts.
    """
    if len(theta) < 2:
        return False
    acts: list[Flags] = []
    moved: dict[str, list[Array]] = {}
    for i, (part, states) in enumerate(zip(whole.parts, whole.smoothed(
            evaluated(whole, fit).run))):
        index = np.flatnonzero(np.isfinite(states[:, 0]))
        acts.append(torque_of(theta[owner == i], part.recording)[index] != 0.0)
        for name, x in named_motion(part.recording, states, index).items():
            moved.setdefault(name, []).append(x)
    inside = np.concatenate(acts)
    if not inside.any():
        return False
    for name in moved.keys() - {'time'}:
        x = np.concatenate(moved[name])
        low, high = np.percentile(x[inside], (EDGES, 100.0 - EDGES))
        elsewhere = ((x > low) & (x < high) & ~inside).sum()
        if elsewhere < THRESHOLDS.followed * inside.sum():
            return True
    return False


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


def pulses_in(runs: WindowRuns, price: float) -> Array:
    """
    Return the bursts [B, 3] that free runs lack, see with_bursts.

    Args:
        runs: free runs over the windows of one recording.
        price: chi2 that a burst must gain in addition to the price of its place.
    """
    if 'arm_side' not in localisation.visible_places(runs):
        return np.zeros((0, 3))
    free = localisation.free_forms(runs, ('arm_side',))['arm_side']
    bursts, windows, gains = rectangles(free, price)
    bursts[:, 0] += runs.data.windows.first[windows] * runs.recording.dt
    # Windows overlap: one burst is found in several of them, best in the middle of one.
    apart: list[int] = []
    for number in np.argsort(-gains):
        if (np.abs(bursts[apart, 0] - bursts[number, 0]) > THRESHOLDS.longest_burst).all():
            apart.append(int(number))
    return bursts[sorted(apart)]


def rectangles(free: InputEstimate, price: float) -> tuple[Array, Integers, Array]:
    """
    Return the bursts in a free-form torque to first order, their windows and gains in chi2.

    At most one in each window: that of the largest likelihood ratio (Willsky and Jones, 1976),
    the torque elsewhere being 0.

    Args:
        free: free-form input estimate.
        price: chi2 that a burst must gain in addition to the price of its place.

    Returns:
        Bursts [B, 3], their begin from that of the window, the numbers [B] of the windows, and
        the gains [B].
    """
    values = free.signal.shape[1]
    price += 2.0 * float(np.log(values * (values + 1) / 2))
    bursts, windows, gains = [], [], []
    for window, (precision, signal) in enumerate(zip(free.precision, free.signal)):
        force = precision @ signal
        highest, amplitude, begin, end = price, 0.0, 0, 0
        for first in range(values):
            longest = round(THRESHOLDS.longest_burst / SPACING)
            for last in range(first, min(first + longest, values)):
                run = slice(first, last + 1)
                along, power = float(force[run].sum()), float(precision[run, run].sum())
                if along ** 2 > highest * power:
                    highest, amplitude = along ** 2 / power, along / power
                    begin, end = first, last + 1
        if end:
            windows.append(window)
            gains.append(highest)
            bursts.append(((begin - 0.5) * SPACING, (end - begin) * SPACING, amplitude))
    return np.array(bursts).reshape(-1, 3), np.array(windows, int), np.array(gains)
