# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""States where the windows start: fitted by Levenberg-Marquardt, and freed from wrong contacts."""
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.window_data import (
    FitPoint, shortened, squares, state_sensitivity, updated, WindowData)
from gearbox_monitor.kernels.levenberg_marquardt import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, MEMORIES

RIVAL = 6.0  # chi2 by which another fit of a window is better, from which on its start is tried
ROUGH, KEPT_STARTS = 2, 3  # iterations from all starts; how many go on
SHARES = (0.1, 0.2, 0.4, 0.7, 1.0)  # of the windows, on which states are found step by step
SPEED = 1.5    # rad/s by which an arm may be faster or slower than its motor, in the gap
RULE = Damping(1e-3, 20.0, largest=1e6, hopeless=1.0, absolute=1e-9)
TOLERANCE = 1e-3  # of chi2, for another step
STUCK = 1.15   # times the median chi2: windows above are tried from elsewhere


def solve_states(data: WindowData, model: DriveModel, states: Array, memory: Array,
                 index: Integers, iterations: int = 6) -> tuple[Array, Array]:
    """
    Fit only the states of the windows `index`; return (states [M, 4], chi2 [M]).

    Levenberg-Marquardt, each window with its own damping; windows that have converged wait.

    Args:
        data: windows of readings and how residuals are weighted.
        model: model of the drive.
        states: states of the drive where the windows start [W, 4].
        memory: memories of the effects where the windows start [W, 4].
        index: numbers of the windows [M]; repeats are allowed.
        iterations: largest number of iterations.
    """
    index = np.asarray(index)
    if data.begins_known:
        return states.copy(), squares(data.residual(model, states, memory, index)[0])
    states, _, chi2 = minimise(_States(data, model, memory, index), states, RULE, TOLERANCE,
                               iterations)
    return states, chi2


@dataclass(frozen=True)
class _States:
    """States of windows as problems side by side, see solve_states."""

    data: WindowData
    model: DriveModel
    memory: Array
    index: Integers

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta` of the problems `index`."""
        residual, _ = self.data.residual(self.model, theta, self.memory[index], self.index[index])
        return residual, squares(residual)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        J = state_sensitivity(self.data, self.model, theta, self.memory[index], residual,
                              self.index[index])
        return np.einsum('wli,wlj->wij', J, J), np.einsum('wli,wl->wi', J, residual)


def solved(data: WindowData, candidate: CandidateModel, point: FitPoint) -> FitPoint:
    """
    Return `point` with the states that fit each window best from where they are.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model to be fitted, with its coordinates.
        point: where the fit stands: coordinates, window states and memories.
    """
    states, _ = solve_states(data, candidate.model(point.z), point.states, point.memory,
                             np.arange(len(data.windows)))
    return data.evaluate(candidate, replace(point, states=states))


def grown_states(data: WindowData, model: DriveModel, memory: Array, index: Integers,
                 half_gap: float) -> Array:
    """
    Return states [M, 4] of the windows `index`, fitted on their beginnings, which get longer.

    Over a long window distant states lead to runs unrelated to the readings; over a short one
    every start converges.

    Args:
        data: windows of readings and how residuals are weighted.
        model: model of the drive.
        memory: memories of the effects where the windows start [W, 4].
        index: numbers of the windows [M]; repeats are allowed.
        half_gap: half backlash on which states are started elsewhere, rad.
    """
    raw = data.raw_states()[index]
    starts = [raw]
    for i, size in ((3, SPEED), (3, -SPEED), (1, 0.6 * half_gap), (1, -0.6 * half_gap)):
        moved = raw.copy()
        moved[:, i] += size
        starts.append(moved)
    tried = np.stack(starts, axis=1)
    repeated = np.repeat(index, tried.shape[1])
    states, chi2 = solve_states(shortened(data, SHARES[0]), model, tried.reshape(-1, 4),
                                memory[repeated], repeated)
    winner = chi2.reshape(len(index), -1).argmin(axis=1)
    states = states.reshape(len(index), -1, 4)[np.arange(len(index)), winner]
    for share in SHARES[1:]:
        states, _ = solve_states(shortened(data, share), model, states, memory[index], index)
    return states


def hidden_states(data: WindowData, states: Array, half_gap: float) -> list[Array]:
    """
    Return states [M, 4] with the side that no encoder reads on either flank, faster and slower.

    Args:
        data: windows of readings and how residuals are weighted.
        states: states of the drive where windows start [M, 4].
        half_gap: half backlash, rad.
    """
    if len(data.channels) == 2:
        return []
    hidden, out = 1 - data.channels[0], []
    for flank in (-1.0, 0.0, 1.0):
        for faster in (-SPEED, 0.0, SPEED):
            moved = states.copy()
            moved[:, hidden] = states[:, data.channels[0]] + flank * half_gap
            moved[:, 2 + hidden] = states[:, 2 + data.channels[0]] + faster
            out.append(moved)
    return out


def rescue(data: WindowData, candidate: CandidateModel, point: FitPoint,
           half_gap: float) -> FitPoint:
    """
    Return `point` with other starts of windows that stand out; itself where none is better.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model with its coordinates.
        point: where the windows stand: coordinates, window states and memories.
        half_gap: half backlash on which states are started elsewhere, rad.
    """
    start = point
    point = _with_memories(data, candidate, point)
    stuck = np.flatnonzero(point.chi2 > max(
        STUCK * float(np.median(point.chi2)), THRESHOLDS.quiet * data.size))
    if len(stuck):
        starts = [grown_states(data, candidate.model(point.z), point.memory, stuck, half_gap),
                  *hidden_states(data, point.states[stuck], half_gap)]
        point = _with_starts(data, candidate, point, stuck, np.stack(starts, axis=1))
    return point if point is start else data.evaluate(candidate, point)


def _with_memories(data: WindowData, candidate: CandidateModel, point: FitPoint) -> FitPoint:
    """
    Return `point` with other memories of a hysteresis where windows begin, if they fit better.

    States handed over by a poor fit may hold a window back permanently.
    """
    starts = {MEMORIES[i]: EFFECTS[i].memory_starts for i in candidate.ids
              if i in MEMORIES and EFFECTS[i].memory_starts}
    index = np.arange(len(point.states))
    for values in zip(*starts.values()):
        memory = point.memory.copy()
        memory[:, list(starts)] = values
        states, chi2 = solve_states(data, candidate.model(point.z), point.states, memory, index)
        use = chi2 < point.chi2 - RIVAL
        if use.any():
            point = replace(point, states=updated(point.states, use, states[use]),
                            memory=updated(point.memory, use, memory[use]),
                            chi2=updated(point.chi2, use, chi2[use]))
    return point


def _with_starts(data: WindowData, candidate: CandidateModel, point: FitPoint,
                 windows: Integers, starts: Array) -> FitPoint:
    """Return `point`, the states of `windows` [M] the best of `starts` [M, S, 4] if better."""
    model = candidate.model(point.z)
    for iterations, survivors in ((ROUGH, KEPT_STARTS), (6 - ROUGH, 1)):
        index = np.repeat(windows, starts.shape[1])
        states, chi2 = solve_states(data, model, starts.reshape(-1, 4), point.memory[index],
                                    index, iterations)
        chi2 = chi2.reshape(len(windows), -1)
        order = np.argsort(chi2, axis=1)[:, :survivors]
        starts = np.take_along_axis(states.reshape(len(windows), -1, 4), order[:, :, None], axis=1)
    improved = chi2.min(axis=1) < point.chi2[windows] * (1 - 1e-4) - 1e-3
    if not improved.any():
        return point
    return replace(point, states=updated(point.states, windows[improved], starts[improved, 0]))
