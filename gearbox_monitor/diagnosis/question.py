# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Questions that a motion leaves open, and the motion that would answer each."""
from dataclasses import dataclass
import math

from gearbox_monitor.diagnosis.contest import CONTEST

UNSEEN = 10.0  # times the plausible size, beyond which a change counts as never shown
SHORTEST, LONGEST = 20.0, 600.0  # s, of a motion that is asked for


@dataclass(frozen=True)
class Question:
    """
    A change that a motion does not show, or not apart from a rival, and the motion that would.

    effect, place: of the change. joint: to move, at some speed (rad/s or m/s), for some seconds.
    evidence: 2 log likelihood to expect of that, None where it depends on how the motion differs.
    smallest: size that would have been a finding, infinite for none; plausible: size that should
    be one. rival: effect that explains a recording as well, '' where none is a finding.
    """

    effect: str
    place: str
    joint: str
    speed: float
    seconds: float
    evidence: float | None
    smallest: float | None = None
    plausible: float | None = None
    rival: str = ''


def _rounded(seconds: float) -> float:
    return min(max(10.0 * round(0.1 * seconds), SHORTEST), LONGEST)


def of_size(where: tuple[str, str, str], motion: tuple[float, float],
            sizes: tuple[float, float], price: float) -> Question:
    """
    Return the Question of a change of plausible size that a motion does not show.

    Its evidence grows with the time and with the square of the size.

    Args:
        where: effect, place and joint.
        motion: speed of the joint and length, s.
        sizes: smallest one that would have been a finding, and plausible one.
        price: of the effect in a contest.
    """
    (effect, place, joint), (speed, time), (smallest, plausible) = where, motion, sizes
    longer = min(smallest / plausible, UNSEEN) ** 2
    seconds = _rounded(time * longer)
    return Question(effect, place, joint, speed, seconds,
                    (CONTEST.margin + price) * seconds / (time * longer),
                    smallest if smallest < UNSEEN * plausible else math.inf, plausible)


def of_rival(where: tuple[str, str, str], motion: tuple[float, float], rival: str,
             lag: float) -> Question:
    """
    Return the Question whether an effect or its rival is the cause.

    Args:
        where: effect, place and joint.
        motion: speed of the joint and length, s.
        rival: the other effect.
        lag: 2 log likelihood by which it lags so far, 0 where only another motion decides.
    """
    (effect, place, joint), (speed, time) = where, motion
    seconds = _rounded(time * min(CONTEST.margin / lag, UNSEEN) if lag > 0.0 else 2.0 * time)
    return Question(effect, place, joint, speed, seconds,
                    lag * seconds / time if lag > 0.0 else None, rival=rival)
