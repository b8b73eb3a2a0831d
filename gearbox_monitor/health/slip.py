# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A slip: motor and arm have moved against each other by a step that the backlash does not allow.

Where a clutch, hub or coupling slips, both flanks move by the same angle, and with them the zero
of the twist; a wider gap, on one flank alone, moves the zero by half of what it grows. Encoders
that restart begin another comparison, and a whole turn of one is no slip.
"""
import math
from typing import NamedTuple

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.features import Backlash


class Slip(NamedTuple):
    """A step of the twist at `stamp_ns`, its size and standard deviation (rad), + of the motor."""

    stamp_ns: int
    size: float
    std: float


class Zero(NamedTuple):
    """
    Zero of the twist in the window that ends at `stamp_ns`, rad, with its deviation.

    gap: rad. room: by how much the zero may move with load and motion, rad.
    """

    stamp_ns: int
    value: float
    std: float
    gap: float
    room: float

    @classmethod
    def of(cls, window: Backlash) -> 'Zero':
        """Return the zero in a `window`."""
        return cls(window.stamp_ns, window.zero, window.gap_std, window.gap,
                   LIMITS.slip_room * (window.gap + window.load / window.stiffness))

    def moved(self, before: 'Zero', turn: float) -> bool:
        """Return whether it has moved since `before`, by no `turn` (rad) of an encoder, 0: any."""
        off = abs(self.value - before.value)
        doubt = LIMITS.slip_sure * math.hypot(self.std, before.std) + max(self.room, before.room)
        past = 0.5 * abs(self.gap - before.gap) + doubt
        return off > past and not any(
            abs(off - whole * t) <= past for t in (turn, 2.0 * math.pi) if t > 4.0 * past
            for whole in (max(round(off / t), 1),))


def found_in(zeros: tuple[Zero, ...], window: Backlash, turn: float
             ) -> tuple[tuple[Zero, ...], Slip | None]:
    """
    Return the zeros to compare the next window with, and the slip that `window` confirms, if any.

    Two windows in a row must be off on the same side: the window of the slip itself is mixed. It
    hardly knows its zero, and is no reference: that is one whose zero is known better than load
    and motion move it, or than the previous one.

    Args:
        zeros: the reference, and the newest one if it has moved.
        window: the newest one; its encoders count from where they did for `zeros`.
        turn: of the motor on the arm side, rad; 0: none.

    """
    new = Zero.of(window)
    if not (window.separable and math.isfinite(new.value + new.std)):
        return zeros, None
    if not zeros:
        return (new,), None
    if not new.moved(zeros[0], turn):
        known = LIMITS.slip_sure * new.std <= new.room or new.std <= zeros[0].std
        return (new,) if known else zeros[:1], None
    before, first = zeros[0], zeros[-1]
    size = new.value - before.value
    if first is before or size * (first.value - before.value) < 0.0:
        return (before, new), None
    return (new,), Slip((before.stamp_ns + first.stamp_ns) // 2, size,
                        math.hypot(new.std, before.std))
