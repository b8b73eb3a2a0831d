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

No check of stamps and readings, no trust, no smoother: those are monitor.Monitor's, whose numbers
are the same as long as none of them has anything to do.
"""
import math

import numpy as np

from gearbox_monitor.estimation import aekf, ekf, sample_loop, srukf, ukf
from gearbox_monitor.estimation.filter_registry import FILTERS
from gearbox_monitor.estimation.process_model import N_PACKED, pack, TAU_K
from gearbox_monitor.estimation.step_record import correction, record_size
from gearbox_monitor.kernels.jit import jit, jit_inline
from gearbox_monitor.monitoring.monitor import Monitor


def _parts(states, n_vectors, n_matrices, room):
    """Return z, P, memory, p, vectors, matrices, record, one behind the other in `room`."""
    n = len(states)
    m = n * n
    at_vectors = n + m + N_PACKED
    at_matrices = at_vectors + n_vectors * n
    at_record = at_matrices + n_matrices * m
    at_memory = at_record + record_size(n)
    return (room[:n], room[n:n + m], room[at_memory:], room[n + m:at_vectors],
            room[at_vectors:at_matrices].reshape(n_vectors, n),
            room[at_matrices:at_record].reshape(n_matrices, m), room[at_record:at_memory])


_split = jit_inline(_parts)  # compiled, it cannot be called from outside: it returns arrays


# One kernel each, with one array: what a call hands over costs more than a step of the EKF.

@jit
def _ekf(states, room, dt, u, load, y1, y2):
    z, P, memory, p, vectors, matrices, record = _split(
        states, ekf.N_VECTORS, ekf.N_MATRICES, room)
    return ekf.step(states, z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record)


@jit
def _ukf(states, room, dt, u, load, y1, y2):
    z, P, memory, p, vectors, matrices, record = _split(
        states, ukf.N_VECTORS, ukf.N_MATRICES, room)
    return ukf.step(states, z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record)


@jit
def _srukf(states, room, dt, u, load, y1, y2):
    z, P, memory, p, vectors, matrices, record = _split(
        states, srukf.N_VECTORS, srukf.N_MATRICES, room)
    return srukf.step(states, z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record)


@jit
def _aekf(states, room, dt, u, load, y1, y2):
    z, P, memory, p, vectors, matrices, record = _split(
        states, aekf.N_VECTORS, aekf.N_MATRICES, room)
    return aekf.step(states, z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record)


STEPS = {'ekf': _ekf, 'ukf': _ukf, 'srukf': _srukf, 'aekf': _aekf}


class Filter:
    """
    The filter that `parameters` choose (names as of Monitor) for the DriveModel `model`.

    names: of the n states. z [n], P [n, n]: belief, x1, x2 in rad, x3, x4 in rad/s, torques in
    N m. innovation [2] (rad), S [3] as s11, s12, s22, K [n, 2]: of the last step.
    Raises InputError as Monitor does.
    """

    def __init__(self, model, parameters=None):
        one = Monitor(model, parameters, judged=False, smoothed=False)
        self.names, self.parameters, self._states = one.names, one.parameters, one.states
        n, module = len(one.names), FILTERS[one.parameters.filter]
        sizes = (module.N_VECTORS, module.N_MATRICES)
        self._room = np.zeros(n + n * n + N_PACKED + sizes[0] * n + sizes[1] * n * n
                              + record_size(n) + module.memory_size(n))
        self.z, P, self._memory, self._packed, _, _, self._record = _parts(
            self._states, *sizes, self._room)
        self.P = P.reshape(n, n)
        self._packed[:] = pack(one.drive, one.parameters)
        self.z[:] = math.nan  # until start
        self.innovation, self.S, self.K, self._scores = correction(self._record, n)
        self._kernel = STEPS[one.parameters.filter]

    def start(self, y1, y2):
        """Begin anew at the motor and arm position y1, y2 (rad on the arm side); NaN: unknown."""
        self._memory[:] = 0.0
        sample_loop.start(self._states, self.z, self.P.reshape(-1), y1, y2, self._packed,
                          self._record)

    def step(self, dt, u, y1, y2, load=0.0):
        """
        Predict over `dt` s under the torque u (N m) and update with y1, y2 (rad); NaN: unknown.

        load: known torque on the arm (N m). False where the filter has diverged, or has not been
        started: then z and P mean nothing, and start() begins anew.
        """
        return self._kernel(self._states, self._room, dt, u, load, y1, y2)

    @property
    def tau_k(self):
        """Transmission torque, N m."""
        return float(self.z[TAU_K])

    @property
    def tau_k_std(self):
        """Standard deviation of tau_k, N m."""
        return math.sqrt(self.P[TAU_K, TAU_K])

    @property
    def nis(self):
        """Normalised innovation squared of the last step."""
        return float(self._scores[0])
