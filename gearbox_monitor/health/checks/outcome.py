# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The one state machine of every alarm: debounced, clamped on both sides, with hysteresis."""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import enum
from typing import NamedTuple

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.kernels.types import Values


class Level(enum.IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


class LevelWords(NamedTuple):
    """What a level says, and what to do then."""

    means: str
    advice: str


LEVELS = {
    Level.OK: LevelWords('the component was judged and nothing is wrong: its values can be used',
                         'nothing'),
    Level.WARN: LevelWords('something is doubtful, or nothing was judged yet: estimates go on, '
                           'with less trust',
                           'read the message: it names the condition and its remedy'),
    Level.ERROR: LevelWords('the values of the component must not be used, or a change of the '
                            'gearbox exceeds its limit', 'stop relying on it, and follow the '
                            'remedy of the message')}


@dataclass(frozen=True)
class Outcome:
    """
    What one check says now.

    level, message in plain words, and values {name: number or text} that stand beside it; every
    value that was judged comes with its threshold.
    """

    level: Level
    message: str
    values: Values = field(default_factory=dict)


@dataclass(frozen=True)
class Condition:
    """
    One reason to leave OK. Messages and `explain` are made of these.

    says: what is wrong, as the message puts it; when: the exact condition, its thresholds
    formatted from the constants that the check compares with; window: what it looks at; advice:
    what to do. value and threshold: names of the key/values that show them.
    """

    component: str
    level: Level
    says: str
    when: str
    window: str
    advice: str
    value: tuple[str, ...] = ()
    threshold: tuple[str, ...] = ()


def outcome_of(broken: Sequence[Condition], fine: str, values: Values) -> Outcome:
    """
    Return the Outcome of one check.

    Args:
        broken: the conditions that do not hold.
        fine: the message if all hold.
        values: {key: value} to publish beside the message.

    Returns:
        OK and `fine`; with broken conditions their highest level, all words, and the advice of the
        first of that level.

    """
    if not broken:
        return Outcome(Level.OK, fine, values)
    worst = max(broken, key=lambda condition: condition.level)
    return Outcome(worst.level, ', '.join(c.says for c in broken) + f': {worst.advice}', values)


def joined(outcomes: Sequence[Outcome]) -> Outcome:
    """Return one Outcome at the highest level of `outcomes`, the first one's words last."""
    first, *further = outcomes
    raised = [outcome for outcome in further if outcome.level > Level.OK]
    texts = [max(raised, key=lambda outcome: outcome.level).message] if raised else []
    if not raised or first.level > Level.OK:
        texts.append(first.message)
    return Outcome(max(outcome.level for outcome in outcomes), '; '.join(texts), first.values)


def with_more(outcome: Outcome, broken: Sequence[Condition], values: Values) -> Outcome:
    """
    Return a Outcome extended by the result of another check of the same component.

    Args:
        outcome: to extend.
        broken: conditions that do not hold, one or more.
        values: {key: value} to add.

    Returns:
        The Outcome at the higher level of both; the added words come first.

    """
    combined = outcome_of(broken, '', {**outcome.values, **values})
    if outcome.level == Level.OK:
        return combined
    return Outcome(max(outcome.level, combined.level), f'{combined.message}; {outcome.message}',
                   combined.values)


# Component -> evaluations in a row that raise and that lower its level. One evaluation per second
# of stamps; of backlash and friction one per drift window: their sequential test debounces.
_PER_SECOND = LIMITS.debounce_up, LIMITS.debounce_down
DEBOUNCE = {'observability': _PER_SECOND, 'prediction error': _PER_SECOND,
            'covariance': _PER_SECOND, 'model': _PER_SECOND, 'backlash': (1, 1),
            'friction': (1, 1), 'input': _PER_SECOND}


class Alarm:
    """
    Turn raw levels, one per evaluation, into a level that neither flaps nor sticks.

    A level is raised after `up` consecutive evaluations at or above it and lowered after `down`
    consecutive ones below it, so the latency is at most `up` or `down` evaluations, whatever came
    before: the counters are clamped. At a start the level is WARN ("no data yet"), never OK, until
    the first evaluation that finds nothing clears it, or `up` in a row confirm it. judged: whether
    an evaluation has come.
    """

    def __init__(self, up: int = 3, down: int = 5) -> None:
        self.up, self.down = up, down
        self.level = Level.WARN
        self.since_ns: int | None = None
        self._above = [0, 0]  # evaluations in a row at or above WARN, ERROR
        self._below = [0, 0]
        self.judged = False
        self._decided = False  # whether the start is over
        self._said: dict[Level, str] = {}  # level: what was found last at it

    def update(self, raw: int, stamp_ns: int) -> Level:
        """Take the raw level found at `stamp_ns`; return the debounced level."""
        for i, at in enumerate((Level.WARN, Level.ERROR)):
            reached = raw >= at
            self._above[i] = min(self._above[i] + 1, self.up) if reached else 0
            self._below[i] = 0 if reached else min(self._below[i] + 1, self.down)
        new = self.level if self._decided else min(Level(raw), Level.WARN)
        for i, at in enumerate((Level.WARN, Level.ERROR)):
            if self._above[i] >= self.up:
                new = max(new, at)
            if self._below[i] >= self.down and new >= at:
                new = Level(at - 1)
                break
        if new != self.level or self.since_ns is None:
            self.since_ns = stamp_ns
        self._decided = self._decided or raw == Level.OK or self._above[0] >= self.up
        self.level, self.judged = new, True
        return new

    def doubt(self) -> None:
        """Take back the level OK: the next evaluation decides, as the first of all does."""
        if self.level == Level.OK:
            self.level, self.since_ns, self.judged = Level.WARN, None, False
            self._decided = False

    def judge(self, outcome: Outcome, stamp_ns: int) -> Outcome:
        """
        Return the raw `outcome` at its debounced level at stamp_ns; lasts_s: how long it has.

        The message fits the level in force: while a raw level is not believed yet, or not
        forgotten yet, it is what was found last at the level that stands.
        """
        level = self.update(outcome.level, stamp_ns)
        self._said[Level.OK if outcome.level == Level.OK else Level.WARN] = outcome.message
        if outcome.level == Level.ERROR:
            self._said[Level.ERROR] = outcome.message
        self._said.setdefault(level, outcome.message)
        return replace(self.standing(), values={
            **outcome.values, **({'lasts_s': self.lasted(stamp_ns)} if level else {})})

    def standing(self) -> Outcome:
        """Return the level in force, with what was found last at it."""
        return Outcome(self.level, self._said.get(self.level, ''))

    def lasted(self, stamp_ns: int) -> float:
        """Return how long the level has lasted at `stamp_ns` (s); 0 where time went backwards."""
        return 0.0 if self.since_ns is None else max((stamp_ns - self.since_ns) * 1e-9, 0.0)
