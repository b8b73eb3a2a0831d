# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every limit of the watch in one place, with its reason."""
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

SECOND = 1_000_000_000
DATED = 10 ** 9 * 86400 * 365  # ns from which a stamp is a date
FRICTION, SCALE, ROTOR, WEIGHT, RIPPLE, TILT = KINDS = (
    'friction', 'torque_scale', 'rotor', 'weight', 'ripple', 'tilt')


@dataclass(frozen=True)
class KindLimits:
    """
    What is known of the states of a kind before any is seen.

    jump: deviation of a change; drift: of what temperature and wear do in the root of an hour;
    apart: of the healthy states of two days; limit: size of a change that is an alarm; slow: of
    one without a jump, from the state that was learnt. Friction, torque scale, weight and rotor
    are shares of what the joint has; tilt is m/s^2 of gravity, ripple a share of the effort.
    """

    jump: float
    drift: float
    apart: float
    limit: float
    slow: float


@dataclass(frozen=True)
class WatchSettings:
    """
    Limits of the watch.

    block, late, back s: length of a block; how much later its last message may come; by how much a
    clock is set back that starts a new block. parts: of three blocks each, which the first
    knowledge rests on; alike: power that a block may leave unexplained, of the median one's;
    least: blocks alike.
    moved s: in which a joint must have moved to be learnt; patience: blocks with motion after
    which joints that never moved are not waited for. share: of a block, from which it has motion.

    often: blocks between two changes of any state, as expected; sure: probability of a change that
    is taken. scatter: of blocks about a level, before any is seen, over the variance that they
    state; settle: blocks with a state before a change of it is judged.
    over: share of its limit below which a change has ended. power: share of its limit that the
    deviation of a state may have where the state is judged.
    """

    block: float = 20.0
    late: float = 1.0
    back: float = 60.0
    parts: int = 3
    alike: float = 6.0
    least: int = 7
    moved: float = 15.0
    patience: int = 30
    share: float = 0.1
    often: float = 20000.0
    sure: float = 0.99
    scatter: float = 1.0
    settle: int = 3
    over: float = 0.5
    power: float = 0.3
    kinds: Mapping[str, KindLimits] = field(default_factory=lambda: MappingProxyType({
        # Friction of gears halves between a cold and a warm robot, within an hour or two.
        FRICTION: KindLimits(0.5, 0.1, 0.03, 0.15, 0.5),
        SCALE: KindLimits(0.3, 0.002, 0.005, 0.06, 0.1),
        ROTOR: KindLimits(0.3, 0.01, 0.02, 0.05, 0.2),
        WEIGHT: KindLimits(0.5, 0.005, 0.01, 0.1, 0.2),
        RIPPLE: KindLimits(0.1, 0.003, 0.005, 0.02, 0.05),
        TILT: KindLimits(1.0, 0.01, 0.02, 0.2, 0.4)}))

    @property
    def block_ns(self) -> int:
        """Length of a block, ns."""
        return round(self.block * SECOND)

    @property
    def late_ns(self) -> int:
        """How much later than its end the last message of a block may come, ns."""
        return round(self.late * SECOND)

    @property
    def back_ns(self) -> int:
        """By how much a clock is set back that starts a new block, ns."""
        return round(self.back * SECOND)


WATCH_SETTINGS = WatchSettings()
