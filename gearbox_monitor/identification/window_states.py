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

"""States where the windows begin: fitted, and freed from wrong contacts of the gap."""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.identification.candidates import Candidate
from gearbox_monitor.identification.likelihood import (
    carried, FitPoint, shortened, squares, state_sensitivity, WindowData)
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, MEMORIES

RIVAL = 6.0  # chi2 by which another fit of a window is better, from which on its start is tried
ROUGH, KEPT_STARTS = 2, 3  # iterations from all starts; how many go on
SHARES = (0.1, 0.2, 0.4, 0.7, 1.0)  # of the windows, on which states are found step by step
STUCK = 1.15   # times the median chi2: windows above are tried from elsewhere


def solve_states(data: WindowData, model: DriveModel, states: Array, memory: Array,
                 index: Integers, iterations: int = 6) -> tuple[Array, Array]:
    """
    Fit only the states of the windows `index` [M]; return (states [M, 4], chi2 [M]).

    Levenberg-Marquardt, each window with a damping of its own; those that have arrived wait.
    """
    states, index = states.copy(), np.asarray(index)
    residual, _ = data.residual(model, states, memory, index)
    chi2 = squares(residual)
    if data.simulator.begins_known:
        return states, chi2
    damping = np.full(len(states), 1e-3)
    A, g = np.empty((len(states), 4, 4)), np.empty((len(states), 4))
    moved = active = np.arange(len(states))
    for _ in range(iterations):
        if len(moved):
            J = state_sensitivity(data, model, states[moved], memory[moved], residual[moved],
                                  index[moved])
            A[moved] = np.einsum('wli,wlj->wij', J, J)
            g[moved] = np.einsum('wli,wl->wi', J, residual[moved])
        damped = A[active]
        diagonal = np.einsum('wii->wi', damped)
        damped[:, range(4), range(4)] += diagonal * damping[active, None] + 1e-9
        trial = states[active] + np.linalg.solve(damped, g[active, :, None])[:, :, 0]
        r, _ = data.residual(model, trial, memory[active], index[active])
        after = squares(r)
        gain = chi2[active] - after
        better = gain > 0.0
        damping[active] = np.where(better, damping[active] * 0.1,
                                   np.minimum(damping[active] * 20.0, 1e6))
        arrived = np.where(better, gain < 1e-3 * chi2[active], damping[active] > 1.0)
        moved = active[better]
        states[moved], residual[moved], chi2[moved] = trial[better], r[better], after[better]
        moved, active = active[better & ~arrived], active[~arrived]
        if not len(active):
            break
    return states, chi2


def grown_states(data: WindowData, model: DriveModel, memory: Array, index: Integers,
                 half_gap: float, last: float = 1.0) -> Array:
    """
    Return states [M, 4] of the windows `index`, found on their beginnings, which get longer.

    Over a long window states far off lead to runs that have nothing to do with the readings; over
    a short one every start arrives. last: the share of the windows to end with.
    """
    raw = data.raw_states()[index]
    starts = [raw]
    for i, size in ((3, 1.5), (3, -1.5), (1, 0.6 * half_gap), (1, -0.6 * half_gap)):
        moved = raw.copy()
        moved[:, i] += size
        starts.append(moved)
    tried = np.stack(starts, axis=1)
    every = np.repeat(index, tried.shape[1])
    states, chi2 = solve_states(shortened(data, SHARES[0]), model, tried.reshape(-1, 4),
                                memory[every], every)
    best = chi2.reshape(len(index), -1).argmin(axis=1)
    states = states.reshape(len(index), -1, 4)[np.arange(len(index)), best]
    for share in SHARES[1:]:
        if share <= last:
            states, _ = solve_states(shortened(data, share), model, states, memory[index], index)
    return states


def rescue(data: WindowData, candidate: Candidate, point: FitPoint,
           others: Sequence[FitPoint] = (), half_gap: float = 0.05) -> int:
    """
    Try other starts for windows that stand out; return how many became better.

    others: Points of other fits. Where one of them is better, its start is tried, too: one that
    only one candidate has found must not be its merit.
    """
    if data.simulator.begins_known:
        return 0
    better = _try_memories(data, candidate, point)
    stuck = point.chi2 > max(STUCK * float(np.median(point.chi2)), 1.12 * data.size)
    behind = np.zeros(len(stuck), bool)
    for other in others:
        behind |= other.chi2 < point.chi2 - RIVAL
    for windows, anywhere in ((np.flatnonzero(stuck), True),
                              (np.flatnonzero(behind & ~stuck), False)):
        if not len(windows):
            continue
        starts = _rival_states(others, windows)
        if anywhere:
            starts.append(grown_states(data, candidate.model(point.z), point.memory, windows,
                                       half_gap))
            if point.carry is not None:
                starts.append(np.where(windows[:, None] > 0,
                                       point.carry[np.maximum(windows - 1, 0), :4], starts[-1]))
        better += _try_starts(data, candidate, point, windows, np.stack(starts, axis=1))
    if better:
        data.evaluate(candidate, point)
    return better


def _try_memories(data: WindowData, candidate: Candidate, point: FitPoint) -> int:
    """
    Try other memories of a hysteresis where windows begin; return how many became better.

    What a fit that was still far off handed over may hold a window back for ever.
    """
    starts = {MEMORIES[i]: EFFECTS[i].memory_starts for i in candidate.ids
              if i in MEMORIES and EFFECTS[i].memory_starts}
    every, better = np.arange(len(point.states)), np.zeros(len(point.states), bool)
    for values in zip(*starts.values()):
        memory = point.memory.copy()
        memory[:, list(starts)] = values
        states, chi2 = solve_states(data, candidate.model(point.z), point.states, memory, every)
        use = chi2 < point.chi2 - RIVAL
        point.states[use], point.memory[use], point.chi2[use] = states[use], memory[use], chi2[use]
        better |= use
    return int(better.sum())


def _rival_states(others: Sequence[FitPoint], windows: Integers) -> list[Array]:
    """Return the states [M, 4] of the Points `others` that fit `windows` best, as a list."""
    if not others:
        return []
    found = np.stack([other.chi2[windows] for other in others])
    states = np.stack([other.states[windows] for other in others])
    return [states[best, np.arange(len(windows))]
            for best in np.argsort(found, axis=0)[:KEPT_STARTS]]


def _try_starts(data: WindowData, candidate: Candidate, point: FitPoint, windows: Integers,
                starts: Array) -> int:
    """Move the states of `windows` [M] to the best of `starts` [M, S, 4]; return how many."""
    model = candidate.model(point.z)
    for iterations, kept in ((ROUGH, KEPT_STARTS), (6 - ROUGH, 1)):
        index = np.repeat(windows, starts.shape[1])
        states, chi2 = solve_states(data, model, starts.reshape(-1, 4), point.memory[index],
                                    index, iterations)
        chi2 = chi2.reshape(len(windows), -1)
        order = np.argsort(chi2, axis=1)[:, :kept]
        starts = np.take_along_axis(states.reshape(len(windows), -1, 4), order[:, :, None], axis=1)
    chi2 = chi2.min(axis=1)
    better = chi2 < point.chi2[windows] * (1 - 1e-4) - 1e-3
    point.states[windows[better]] = starts[better, 0]
    return int(better.sum())


def hand_over(data: WindowData, candidate: Candidate, point: FitPoint) -> None:
    """Give windows the memory with which their predecessor ends, where they can live with it."""
    moved = data.evaluate(candidate, FitPoint(
        point.z, point.states, carried(point.memory, point.carry)))
    # Near a reversal a little change elsewhere turns a memory over; then the last one is better.
    use = moved.chi2 < point.chi2 + RIVAL
    for name in ('memory', 'residual', 'chi2', 'carry'):
        getattr(point, name)[use] = getattr(moved, name)[use]
