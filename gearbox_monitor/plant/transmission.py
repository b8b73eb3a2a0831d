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

"""Torque of the transmission over its twist: dead zone, two kinds of hysteresis, rigid."""
from gearbox_monitor.kernels.jit import jit_inline

# The order is the code that kernels switch on.
KINDS = ('dead_zone', 'play', 'passive_play', 'rigid')
DEAD_ZONE, PLAY, PASSIVE_PLAY, RIGID = range(4)


@jit_inline
def dead_zone(twist: float, half_gap: float) -> float:
    """Return the part of `twist` (rad) that lies outside a gap of +-`half_gap` (rad)."""
    if twist > half_gap:
        return twist - half_gap
    if twist < -half_gap:
        return twist + half_gap
    return 0.0


@jit_inline
def transmission_torque(twist: float, memory: float, kind: int, stiffness: float, half_gap: float,
                        width: float, hysteresis_stiffness: float) -> tuple[float, float]:
    """
    Return the torque of the transmission and the memory that it keeps.

    dead_zone: tau = K dz(twist, b); no memory.
    play: generalised play in the paper's orientation, lower branch while the twist grows:
    w <- min(max(w, K dz(twist - c, b)), K dz(twist + c, b)), tau = w. Memory: w in N m.
    This orientation supplies energy; it stays bounded only through friction.
    passive_play: tau = K dz(twist, b) + k_s (twist - w), w <- min(max(w, twist - r), twist + r):
    upper branch while the twist grows, as physics wants it. Memory: w in rad.
    rigid: 0; the torque is that of the constraint, drive.rigid_torque.

    Args:
        twist: x1 - x2, rad.
        memory: w at the begin.
        kind: place in KINDS.
        stiffness: K, N m/rad.
        half_gap: b, rad.
        width: c or r, rad.
        hysteresis_stiffness: k_s, N m/rad.

    Returns:
        (tau_k in N m, memory).
    """
    if kind == PLAY:
        lower = stiffness * dead_zone(twist - width, half_gap)
        upper = stiffness * dead_zone(twist + width, half_gap)
        memory = min(max(memory, lower), upper)
        return memory, memory
    if kind == RIGID:
        return 0.0, memory
    tau_k = stiffness * dead_zone(twist, half_gap)
    if kind == PASSIVE_PLAY:
        memory = min(max(memory, twist - width), twist + width)
        tau_k += hysteresis_stiffness * (twist - memory)
    return tau_k, memory
