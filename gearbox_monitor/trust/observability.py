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
First trust indicator: the torque can be seen from these measurements, in this motion.

The paper's equation (6) looks at the Jacobian of [f; h] at a point; with raw units it ranks a lost
encoder above a healthy standstill. What decides the level is therefore the information share: how
much of the prior standard deviation of tau_K is left after 100 ms of measurements.
"""
import numpy as np

from gearbox_monitor.drive.model import substeps
from gearbox_monitor.filters.process import (
    EIGENVALUE, P0, propagate, R1, R2, tangent, TAU_K, X1, X2)
from gearbox_monitor.jit import jit
from gearbox_monitor.trust.level import Finding, Level

WINDOW = 0.1  # s
UNTRUSTED = 0.3
POSITION_SCALE = 1.0  # rad: prior standard deviation of the positions


@jit
def _gramian(states, inputs, dts, seen, p, gramian, phi, product, vectors, matrices):
    """Sum Phi' H' R^-1 H Phi over W samples [W, n], from the first state on."""
    n = states.shape[1]
    z = np.empty(n)
    for i in range(n):
        for j in range(n):
            product[i, j] = 1.0 if i == j else 0.0
            gramian[i, j] = 0.0
    for k in range(states.shape[0]):
        for c in range(2):
            if seen[k, c]:
                r = p[R1] if c == 0 else p[R2]
                for i in range(n):
                    for j in range(n):
                        gramian[i, j] += product[c, i] * product[c, j] / r
        for i in range(n):
            z[i] = states[k, i]
        propagate(z, phi, inputs[k, 0], inputs[k, 1], dts[k], substeps(dts[k], p[EIGENVALUE]), p,
                  vectors, matrices)
        for i in range(n):
            for j in range(n):
                s = 0.0
                for m in range(n):
                    s += phi[i, m] * product[m, j]
                matrices[0, i, j] = s
        for i in range(n):
            for j in range(n):
                product[i, j] = matrices[0, i, j]


def information_share(states, inputs, dts, seen, p):
    """
    Return [n]: posterior over prior standard deviation of each state after the window.

    states [W, n], inputs [W, 2] N m, dts [W] s, seen [W, 2] bool (measured), p: process.pack.
    sqrt(diag((S O S + I)^-1)) with the windowed Gramian O and the prior deviations S. 1 = nothing
    learnt, 0 = known.
    """
    n = states.shape[1]
    gramian, phi, product = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    _gramian(np.ascontiguousarray(states), np.ascontiguousarray(inputs),
             np.ascontiguousarray(dts), np.ascontiguousarray(seen), p, gramian, phi, product,
             np.empty((3, n)), np.empty((4, n, n)))
    scale = np.sqrt(p[P0:P0 + n])
    scale[[X1, X2]] = POSITION_SCALE
    information = scale[:, None] * gramian * scale + np.eye(n)
    return np.sqrt(np.clip(np.diag(np.linalg.inv(information)), 0.0, 1.0))


def condition(state, inputs, seen, p):
    """
    Return s_min / s_max of the Jacobian of [f; h] with respect to (x, tau_K), equation (6).

    Raw units, as the paper defines it: `state` [n], `inputs` [2], `seen` [2] bool. The row of
    tau_K' is left out: it is zero in the paper's model.
    """
    n = len(state)
    a = np.zeros((n, n))
    tangent(np.ascontiguousarray(state), np.eye(n), p, a)
    h = np.eye(n)[[i for i in (X1, X2) if seen[i]]]
    jacobian = np.vstack([a[:4], h])[:, :TAU_K + 1]
    s = np.linalg.svd(jacobian, compute_uv=False)
    return float(s[-1] / s[0]) if len(jacobian) > TAU_K and s[0] > 0.0 else 0.0


def check(share, speed_share, eps6):
    """Return the Finding for the information share of tau_K, that of the speed, and eq. (6)."""
    values = {
        'information_share_tau_k': share, 'information_share_threshold': UNTRUSTED,
        'information_share_motor_speed': speed_share, 'condition_eq6': eps6}
    if not share <= UNTRUSTED:  # NaN is untrusted, too
        return Finding(Level.ERROR, f'tau_K not observable: {100 * share:.0f} % of its prior '
                       'uncertainty is left; check the motor encoder', values)
    if speed_share > UNTRUSTED:
        return Finding(Level.OK, 'tau_K observable; speed not (standstill)', values)
    return Finding(Level.OK, 'tau_K observable', values)
