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
One filter by itself, for a loop of one's own: a call per sample, and nothing but the recursion.

No check of stamps and readings, no smoother: those are the Estimator's, whose numbers are the same
as long as neither of them has anything to do.
"""
from functools import cache
import math
from typing import Any

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.filter_kind import (
    Belief, filter_kind, FilterKind, Reading, Scratch)
from gearbox_monitor.estimation.process_model import N_PACKED, torque_of
from gearbox_monitor.estimation.step_record import correction, record_size
from gearbox_monitor.kernels.jit import bound, jit_inline
from gearbox_monitor.kernels.types import Array, Pair, States, Values
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel


def _parts(states: States, n_vectors: int, n_matrices: int,
           room: Array) -> tuple[Belief, Array, Scratch, Array]:
    """Return belief, p, scratch and record, one behind the other in `room`."""
    n = len(states)
    m = n * n
    at_vectors = n + m + N_PACKED
    at_matrices = at_vectors + n_vectors * n
    at_record = at_matrices + n_matrices * m
    at_memory = at_record + record_size(n)
    return (Belief(room[:n], room[n:n + m], room[at_memory:]), room[n + m:at_vectors],
            Scratch(room[at_vectors:at_matrices].reshape(n_vectors, n),
                    room[at_matrices:at_record].reshape(n_matrices, m)), room[at_record:at_memory])


_split = jit_inline(_parts)  # compiled, it cannot be called from outside: it returns arrays
# What stands here for a filter; see _kernel_of.
N_VECTORS = N_MATRICES = 0
filter_step = sample_loop.filter_step


def _call(states: States, room: Array, dt: float, u: float, load: float, y1: float,
          y2: float) -> bool:
    """Step a filter: with one array, as what a call hands over costs more than a step."""
    belief, p, scratch, record = _split(states, N_VECTORS, N_MATRICES, room)
    return filter_step(states, belief, Reading(dt, u, load, y1, y2), p, scratch, record)


@cache
def _kernel_of(kind: FilterKind) -> Any:
    return bound(_call, kind.name, filter_step=kind.step, N_VECTORS=kind.n_vectors,
                 N_MATRICES=kind.n_matrices)


class Filter:
    """
    The filter that `parameters` choose (names as of Estimator) for the DriveModel `model`.

    names: of the n states. z [n], P [n, n]: belief, x1, x2 in rad, x3, x4 in rad/s, torques in
    N m. innovation [2] (rad), S [3] as s11, s12, s22, K [n, 2]: of the last step.
    Raises InputError as Estimator does.
    """

    def __init__(self, model: DriveModel,
                 parameters: EstimatorParameters | Values | None = None) -> None:
        estimator = Estimator(model, unsmoothed(parameters))
        self.names, self.parameters = estimator.names, estimator.parameters
        self._states = estimator.states
        n, kind = len(estimator.names), filter_kind(estimator.parameters.filter)
        self._room = np.zeros(n + n * n + N_PACKED + kind.n_vectors * n + kind.n_matrices * n * n
                              + record_size(n) + kind.memory_size(n))
        self._belief, self._packed, _, self._record = _parts(
            self._states, kind.n_vectors, kind.n_matrices, self._room)
        self.z, self.P = self._belief.z, self._belief.P.reshape(n, n)
        self._packed[:] = estimator.packed
        self.z[:] = math.nan  # until start
        self.innovation, self.S, self.K, self._scores = correction(self._record, n)
        self._kernel = _kernel_of(kind)

    def start(self, y1: float, y2: float) -> None:
        """Restart at the motor and arm position y1, y2 (rad on the arm side); NaN: unknown."""
        self._belief.memory[:] = 0.0
        sample_loop.start(self._states, self._belief, y1, y2, self._packed, self._record)

    def step(self, dt: float, u: float, y1: float, y2: float, load: float = 0.0) -> bool:
        """
        Predict and update.

        Args:
            dt: time since the last step or the start, s.
            u: motor torque over that time, N m.
            y1: motor and arm position at its end, rad on the arm side; NaN: unknown.
            y2: motor and arm position at its end, rad on the arm side; NaN: unknown.
            load: known torque on the arm, N m.

        Returns:
            False if the filter has diverged or is not started: then z and P mean nothing, and
            start() restarts it.

        """
        return bool(self._kernel(self._states, self._room, dt, u, load, y1, y2))

    @property
    def tau_k(self) -> float:
        """Transmission torque, N m."""
        return float(self._torque()[0])

    @property
    def tau_k_std(self) -> float:
        """Standard deviation of tau_k, N m."""
        return math.sqrt(self._torque()[1])

    def _torque(self) -> Pair:
        return torque_of(self._states, self.z, self._belief.P, self._packed)

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last step."""
        return float(self._scores[0])
