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
    """Limits of the watch, by the room's modules; `kinds` are those of each kind of state."""

    # Blocks: length; how much later its last message may come; by how much a clock is set back
    # that starts a new block (s).
    block: float = 20.0
    late: float = 1.0
    back: float = 60.0
    # Motion: s over which a speed is taken; share of a block from which it has motion.
    speed_step: float = 0.1
    share: float = 0.1
    # Learning: blocks of a part of the knowledge; parts that it rests on; power that a block may
    # leave unexplained, over the median one's; blocks alike in this; s in which a joint must have
    # moved; blocks with motion after which the others wait no longer for it.
    part: int = 3
    parts: int = 3
    alike: float = 6.0
    least: int = 7
    moved: float = 15.0
    patience: int = 15
    # Estimates of a block: friction less than this share of a joint's effort was not learnt;
    # shares that no change exceeds, so that coefficients which a block does not show stay finite;
    # candidates that are fitted whole if they gain `clipped` for each coefficient.
    least_friction: float = 1e-3
    widest: float = 10.0
    fitted: int = 8
    # Steps begin in as many blocks as are learnt from. Blocks that one must have lasted, and
    # with a state before it; blocks between two changes of any state, as expected;
    # probability of one that is taken; deviance by which its state explains more than any
    # other; share of the evidence that remains without any one block.
    lasting: int = 3
    often: float = 20000.0
    sure: float = 0.99
    lead: float = 6.0
    alone: float = 0.5
    # Scatter of blocks about a level, over the variance that they state: before any is seen, the
    # blocks that this belief is worth, the blocks of its memory, and its least value (other
    # postures differ by more); largest squared deviation that counts; correlation of the errors
    # of two blocks, which share posture and load.
    scatter: float = 1.0
    belief: float = 4.0
    memory: float = 60.0
    calm: float = 0.2
    clipped: float = 9.0
    correlation: float = 0.5
    # Changes: share of its limit that the deviation of a state may have where it is judged;
    # deviations by which an alarm exceeds its limit (99 %, one side); share of its limit
    # below which a change has ended.
    power: float = 0.3
    certain: float = 2.33
    over: float = 0.5
    # Loads: deviations by which a mass was taken or put down; chi squared of mass and first
    # moments from which another load is held; share of link and load by which all torques
    # together may be off without a sign; earlier loads that are remembered.
    noticed: float = 5.0
    taken: float = 35.0
    scaled: float = 0.02
    remembered: int = 40
    kinds: Mapping[str, KindLimits] = field(default_factory=lambda: MappingProxyType({
        # Friction of gears halves between a cold and a warm robot, within an hour or two.
        FRICTION: KindLimits(0.5, 0.1, 0.03, 0.15, 0.5),
        SCALE: KindLimits(0.3, 0.002, 0.005, 0.06, 0.1),
        ROTOR: KindLimits(0.3, 0.01, 0.02, 0.05, 0.2),
        WEIGHT: KindLimits(0.5, 0.005, 0.01, 0.1, 0.2),
        RIPPLE: KindLimits(0.1, 0.003, 0.005, 0.02, 0.05),
        TILT: KindLimits(1.0, 0.01, 0.02, 0.2, 0.4)}))

    @property
    def recent(self) -> int:
        """Blocks in which a step may have begun."""
        return self.part * self.parts

    @property
    def block_ns(self) -> int:
        """Length of a block, ns."""
        return round(self.block * SECOND)


WATCH_SETTINGS = WatchSettings()
