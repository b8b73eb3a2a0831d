# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Laws of Coulomb friction: the smooth ones of this package, and those of simulators.

atan, tanh: Coulomb friction times a function of the speed. mujoco, physx, ode: a constraint holds
the joint with what it needs to, up to Coulomb friction F: of all other torque tau on an inertia M
that moves at the speed v,

    f = clip((tau + M b v) / (1 + r), -F, F),

which decelerates at the rate b and lets the share r / (1 + r) of tau pass. MuJoCo: r = (1 - d) / d
of the impedance d, and b of its solver parameters; PhysX and ODE: r = 0, b = 1 / timestep, so that
the joint stands after a step. PhysX asks for more to break away than to slide.
"""
from dataclasses import dataclass
import math

from gearbox_monitor.kernels.elementary import arctan, exponential
from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.kernels.types import Curve, Slopes

TWO_OVER_PI = 2.0 / math.pi
LAWS = ('atan', 'tanh', 'mujoco', 'physx', 'ode')
ATAN, TANH, MUJOCO, PHYSX, ODE = range(len(LAWS))
# Of steps; the others as MuJoCo has them: explicit_euler is its Euler without eulerdamp.
INTEGRATORS = ('rk4', 'euler', 'implicitfast', 'explicit_euler')
RK4, EULER, IMPLICITFAST, EXPLICIT_EULER = range(len(INTEGRATORS))
IMPEDANCES = (1e-4, 0.9999)  # between which MuJoCo keeps them
FAR = 20.0  # from where on tanh is 1


@dataclass(frozen=True)
class FrictionLaw:
    """
    Law of Coulomb friction on motor and arm: `kind` of LAWS.

    solref, solimp: of mujoco, the first two of its solreffriction and solimpfriction. static: of
    physx, friction at breakaway over that in sliding.
    """

    kind: str = 'atan'
    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float] = (0.9, 0.95)
    static: float = 1.0

    @property
    def code(self) -> int:
        """The law's number, as kernels take it."""
        return LAWS.index(self.kind)

    @property
    def constraint(self) -> bool:
        """Whether friction depends on the other torques on a joint."""
        return self.code >= MUJOCO

    @property
    def softness(self) -> float:
        """Share of the other torque that passes a joint, over the share that does not: r."""
        if self.kind != 'mujoco':
            return 0.0
        low, high = IMPEDANCES
        impedance = min(max(self.solimp[0], low), high)
        return (1.0 - impedance) / impedance

    def rate(self, timestep: float) -> float:
        """Return the rate b (1/s) at which the constraint decelerates; timestep: s."""
        if self.kind != 'mujoco':
            return 1.0 / timestep
        low, high = IMPEDANCES
        impedance = min(max(self.solimp[1], low), high)
        if self.solref[0] <= 0.0:
            return -self.solref[1] / impedance
        return 2.0 / (impedance * max(self.solref[0], 2.0 * timestep))


@inline
def side(v: float, law: float) -> float:
    """
    Return the share of Coulomb friction that acts at a speed.

    Args:
        v: speed times sharpness.
        law: TANH, else that of the arctangent.

    Returns:
        Between -1 and 1.
    """
    if law == TANH:
        # exponential, not math.tanh: lanes of a vector unit take no call
        return 1.0 - 2.0 / (1.0 + exponential(2.0 * min(max(v, -FAR), FAR)))
    return TWO_OVER_PI * arctan(v)


@inline
def side_slope(v: float, law: float) -> float:
    """
    Return the slope of `side` over v.

    Args:
        v: speed times sharpness.
        law: as of side.

    Returns:
        At most 1.
    """
    if law == TANH:
        share = side(v, law)
        return 1.0 - share * share
    return TWO_OVER_PI / (1.0 + v * v)


@inline
def holding(torque: float, moving: float, limit: float, softness: float,
            static: float) -> float:
    """
    Return the friction of a constraint, see the module's equation.

    Args:
        torque: all other torque on the joint, N m.
        moving: M b v, N m.
        limit: Coulomb friction, N m.
        softness: r.
        static: breakaway over limit.

    Returns:
        Torque, N m.
    """
    needed = (torque + moving) / (1.0 + softness)
    return needed if abs(needed) <= static * limit else math.copysign(limit, needed)


# The order is the code that kernels switch on.
KINDS = ('dead_zone', 'play', 'passive_play', 'rigid')
DEAD_ZONE, PLAY, PASSIVE_PLAY, RIGID = range(4)


@inline
def dead_zone(twist: float, half_gap: float) -> float:
    """Return the part of `twist` (rad) that lies outside a gap of +-`half_gap` (rad)."""
    if twist > half_gap:
        return twist - half_gap
    if twist < -half_gap:
        return twist + half_gap
    return 0.0


@inline
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


@inline
def play(twist: float, memory: float, width: float) -> tuple[float, float]:
    """
    Return the memory of a play, and which of its ends carries it along.

    Args:
        twist: x1 - x2, rad.
        memory: at the begin, rad; it follows the twist at the distance `width` or less.
        width: half the play, rad.

    Returns:
        (memory, rad; 1.0 while the twist carries it up, -1.0 down, 0.0 while it rests).
    """
    if twist - memory > width:
        return twist - width, 1.0
    if memory - twist > width:
        return twist + width, -1.0
    return memory, 0.0


@inline
def dead_zone_torque(twist: float, stiffness: float, offset: float) -> tuple[float, Slopes]:
    """
    Return what elastic_torque does without hysteresis, without a branch.

    Args:
        twist: x1 - x2, rad.
        stiffness: K, N m/rad.
        offset: K b, N m.

    Returns:
        (torque in N m; its slopes over twist, memory, K, c, g).
    """
    stretched = stiffness * twist
    torque = stretched - min(max(stretched, -offset), offset)
    side = math.copysign(1.0, torque) if torque != 0.0 else 0.0
    return torque, (stiffness * abs(side), 0.0, abs(side) * twist, -side, 0.0)


@inline
def elastic_torque(twist: float, memory: float, curve: Curve) -> tuple[float, Slopes]:
    """
    Return the torque of a dead zone with play, and its slopes.

    tau = dz(K a, c) + k_s (twist - w) with c = K b, w the memory of a play of half width |g| / K:
    k_s = 0, g > 0: a = w, generalised play, lower branch while the twist grows (kind play);
    k_s = 0, g < 0: a = 2 twist - w, the upper branch while it grows;
    k_s > 0: a = twist (kind passive_play). g = 0: the dead zone alone.
    On a branch of the first two K a = K twist - g or + g, so that the torque on a flank is linear
    in K, c and g. The memory is in rad; the torque is that of transmission_torque.

    Args:
        twist: x1 - x2, rad.
        memory: before the twist came there, rad.
        curve: (K, c, g, k_s), N m/rad and N m.

    Returns:
        (torque in N m; its slopes over twist, memory, K, c, g).
    """
    stiffness, offset, shift, added = curve
    width = abs(shift) / stiffness
    _, end = play(twist, memory, width)
    sign = 1.0 if shift >= 0.0 else -1.0
    free = 1.0 if end == 0.0 and width != 0.0 else 0.0
    stretch = end * width + free * (twist - memory)  # twist less memory
    share = 0.0 if added > 0.0 else sign
    shifted = twist - share * stretch
    torque = dead_zone(stiffness * shifted, offset)
    side = 1.0 if torque > 0.0 else (-1.0 if torque < 0.0 else 0.0)
    slope = stiffness * abs(side)
    of_stretch = added - share * slope
    of_width = of_stretch * end / stiffness
    return torque + added * stretch, (
        slope + of_stretch * free, -of_stretch * free, abs(side) * shifted - of_width * width,
        -side, of_width * sign)
