# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Disturbance pulses: torque on the arm at irregular times, such as contacts.

A free-form torque is estimated in each window (input estimation) and reduced to one interval per
window, as far as BIC allows.
"""
from dataclasses import replace

import numpy as np
from scipy.stats import combine_pvalues

from gearbox_monitor.identification import (
    basis_functions, input_estimation, likelihood, localisation)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE


def disturbance_fit(search: Search) -> CandidateFit | None:
    """
    Return the fit of pulses on the arm, None if the recording does not look like it.

    Args:
        search: fits of all candidates to one recording.
    """
    none = search.fitted['']
    length = search.long.size
    if (none.point.chi2 < THRESHOLDS.quiet * length).mean() < THRESHOLDS.quiet_share:
        return None
    free = localisation.free_forms(search, none, search.jobs, places=('arm_side',))['arm_side']
    price = float(np.log(length))
    runs, cost = best_pulses(free, price)
    if not runs.any():
        return None
    worth, chi2 = _worth(search.long, none, free, runs, cost, price)
    use = runs.any(axis=1) & (worth > 0.0)
    if (not use.any() or (~use).mean() < THRESHOLDS.quiet_share
            or motion_share(search, free) > THRESHOLDS.burst_law
            or at_ends_of_travel(search, free, use[:, None] & runs) < THRESHOLDS.burst_chance
            or sine_share(search, free) > THRESHOLDS.burst_sine
            or advantage_of_other_places(search, free) > THRESHOLDS.elsewhere):
        return None
    shorter = search.on_shorter_steps()
    if shorter is not None:  # impacts in steps too long are little bursts
        shorter_worth, _ = _worth(shorter, none, free, runs, cost, price)
        worth = np.where(use, np.minimum(worth, shorter_worth), 0.0)
        use &= worth > 0.0
        if not use.any():
            return None
    point = replace(none.point, chi2=np.where(use, chi2, none.point.chi2),
                    residual=np.where(use[:, None], free.residual, none.point.residual))
    # Bursts are not repeated: those in held-out windows are evidence like the others.
    score = none.score - float(worth[use].sum())
    return CandidateFit(replace(none.candidate, ids=(DISTURBANCE.id,)), point, score)


def _worth(data: likelihood.WindowData, none: CandidateFit, free: input_estimation.InputEstimate,
           runs: Flags, cost: Array, price: float) -> tuple[Array, Array]:
    """
    Return (gain in chi2 less its cost [W], chi2 [W]) of a free signal.

    In `runs` [W, H] alone at their `cost` [W] or, where hard bursts want it, anywhere at the price
    of each value. Against none, from the same states as well: what these are worth is no merit of
    a burst.
    """
    fit = input_estimation.InputEstimator(data, none.candidate.model(none.point.z), free.place,
                                          none.point)
    pulse = fit.solve(free.states, free.signal * runs, fixed=~runs)
    unconstrained = fit.solve(free.states, free.signal)
    quiet = fit.solve(free.states, fixed=np.ones_like(runs))
    start = fit.solve(none.point.states, fixed=np.ones_like(runs))
    price_of_all = price * unconstrained.unknowns
    without = np.minimum(quiet.chi2, start.chi2)
    sparse = pulse.chi2 + cost < unconstrained.chi2 + price_of_all
    chi2 = np.where(sparse, pulse.chi2, unconstrained.chi2)
    return without - chi2 - np.where(sparse, cost, price_of_all), chi2


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
    weak = 1e-9 * np.trace(free.precision, axis1=1, axis2=2)[:, None, None] / values
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


def motion_share(search: Search, free: input_estimation.InputEstimate) -> float:
    """
    Return the largest share of a InputEstimate that is a function of what the drive does.

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
    """
    recording, windows = search.recording, search.long.windows
    at = windows.first[:, None] + np.arange(windows.length)
    none = search.fitted['']
    positions = search.long.positions(none.candidate.model(none.point.z), none.point)
    moved = {**basis_functions.motion(positions, recording.dt, recording.cuts),
             'torque': recording.torque,
             'speed of the arm': basis_functions.motion(
                 positions[:, ::-1], recording.dt, recording.cuts)['speed']}
    del moved['time']
    laws = localisation.laws(search, free, {name: value[at] for name, value in moved.items()})
    return max(law.explained for law in laws.values())


def at_ends_of_travel(search: Search, free: input_estimation.InputEstimate, runs: Flags) -> float:
    """
    Return the probability that bursts at times of their own push the arm back where it turns.

    What the arm cannot pass (a stop, a contact) acts where the travel ends. Of a burst at a time
    of its own, the share of the samples that lie farther in the direction which it opposes is
    uniform; those of all bursts are combined (Fisher's method).

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
        runs: values in a burst [W, H].
    """
    recording, windows = search.recording, search.long.windows
    none = search.fitted['']
    arm = search.long.positions(none.candidate.model(none.point.z), none.point)[:, 1]
    beyond = []
    for w in np.flatnonzero(runs.any(axis=1)):
        h = int(np.argmax(np.abs(free.signal[w]) * runs[w]))
        at = int(windows.first[w]) + round(h * input_estimation.SPACING / recording.dt)
        side = -np.sign(free.signal[w, h])
        beyond.append(float(np.mean(side * arm >= side * arm[min(at, len(arm) - 1)])))
    return float(combine_pvalues(np.maximum(beyond, 1.0 / len(arm))).pvalue)


def sine_share(search: Search, free: input_estimation.InputEstimate) -> float:
    """
    Return the largest share of `free`, beyond noise, that one sine over time explains.

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
    """
    first = search.long.windows.first[:, None] * search.recording.dt
    t = first + np.arange(free.signal.shape[1]) * input_estimation.SPACING
    finest = 0.25 / np.ptp(t)
    pulls = np.einsum('whk,wk->wh', free.precision, free.signal)
    gain = 0.0
    for frequency in np.arange(finest, 0.5 / input_estimation.SPACING, finest):
        wave = np.exp(2j * np.pi * frequency * t)
        columns = np.stack([wave.real, wave.imag], axis=2)
        gram = np.einsum('whc,whd->cd', columns, free.precision @ columns)
        pull = np.einsum('whc,wh->c', columns, pulls)
        gain = max(gain, float(pull @ np.linalg.lstsq(gram, pull, rcond=None)[0]))
    beyond = float((pulls * free.signal).sum()) - free.signal.size
    return gain / beyond if beyond > 0.0 else 0.0


def advantage_of_other_places(search: Search, free: input_estimation.InputEstimate) -> float:
    """
    Return by how much chi2 a free torque at another place explains more than `free`.

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
    """
    places = [place for place in localisation.visible_places(search)
              if place in input_estimation.TORQUES and place != free.place]
    estimates = localisation.free_forms(search, search.fitted[''], search.jobs, places)
    smallest = min((input_estimation.reduced_chi2(f) for f in estimates.values()), default=np.inf)
    return float(input_estimation.reduced_chi2(free) - smallest) * free.residual.size
