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
