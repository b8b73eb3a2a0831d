# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""States where the windows start, fitted by Levenberg-Marquardt."""
import numpy as np

from gearbox_monitor.diagnosis.joint.window_data import WindowData
from gearbox_monitor.kernels.levenberg_marquardt import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel

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
