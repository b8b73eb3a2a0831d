# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The one state machine of every alarm: debounced, clamped on both sides, with hysteresis."""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import enum
from importlib import import_module
from types import MappingProxyType
from typing import Self, TypeAlias

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.presentation import Said

NOTHING: Values = MappingProxyType({})


class Level(enum.IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


Group: TypeAlias = tuple[Said, ...]


@dataclass(frozen=True)
class Outcome:
    """
    What one check says now.

    level; says: groups of Said, the first one first; values {name: number or text}: every value
    that was judged, with its threshold.
    """

    level: Level
    says: tuple[Group, ...]
    values: Values = field(default_factory=dict)

    @classmethod
    def of(cls, level: Level, code: str, values: Values = NOTHING, **numbers: object) -> Self:
        """Return the Outcome at a `level` that says a `code` with `numbers`, and has `values`."""
        return cls(level, ((Said(code, numbers),),), values)

    @property
    def message(self) -> str:
        """What it says, in the words of the table of sentences."""
        return str(import_module('gearbox_monitor.report.sentences').message(self.says))

    @property
    def codes(self) -> tuple[str, ...]:
        """The codes of all that it says."""
        return tuple(said.code for group in self.says for said in group)

    @property
    def figures(self) -> Values:
        """Its values and, under `codes`, the codes of what it says, as nodes publish them."""
        return {**self.values, 'codes': ' '.join(self.codes)}

    def followed_by(self, code: str, **numbers: object) -> 'Outcome':
        """Return it with a `code` and its `numbers` at the end of what it says."""
        return replace(self, says=(*self.says, (Said(code, numbers),)))


@dataclass(frozen=True)
class Condition:
    """
    One reason to leave OK: its code in the table of sentences, its component and its level.

    value and threshold: names of the key/values that show it.
    """

    code: str
    component: str
    level: Level
    value: tuple[str, ...] = ()
    threshold: tuple[str, ...] = ()

    def said(self, **numbers: object) -> Said:
        """Return that it is broken, with its `numbers`."""
        return Said(self.code, numbers, self.level)


def outcome_of(broken: Sequence[Said], fine: Said | None, values: Values) -> Outcome:
    """
    Return the Outcome of one check.

    Args:
        broken: of the conditions that do not hold.
        fine: that all hold.
        values: {key: value} to publish with the message.
    """
    if not broken:
        return Outcome(Level.OK, ((fine,),) if fine else (), values)
    return Outcome(Level(max(said.level for said in broken)), (tuple(broken),), values)


def joined(outcomes: Sequence[Outcome]) -> Outcome:
    """Return one Outcome at the highest level of `outcomes`, what the first one says last."""
    first, *added = outcomes
    raised = [outcome for outcome in added if outcome.level > Level.OK]
    says = max(raised, key=lambda outcome: outcome.level).says if raised else ()
    if not raised or first.level > Level.OK:
        says += first.says
    return Outcome(max(outcome.level for outcome in outcomes), says, first.values)


def with_more(outcome: Outcome, broken: Sequence[Said], values: Values) -> Outcome:
    """
    Return an Outcome extended by the result of another check of the same component.

    Args:
        outcome: to extend.
        broken: of the conditions that do not hold, one or more; they come first.
        values: {key: value} to add.
    """
    combined = outcome_of(broken, None, {**outcome.values, **values})
    if outcome.level == Level.OK:
        return combined
    return Outcome(max(outcome.level, combined.level), combined.says + outcome.says,
                   combined.values)


class Alarm:
    """
    Turn raw levels, one per evaluation, into a level that neither flaps nor sticks.

    A level is raised after `up` consecutive evaluations at or above it and lowered after `down`
    consecutive ones below it, so the latency is at most `up` or `down` evaluations, whatever came
    before: the counters are clamped. At a start the level is WARN ("no data yet"), never OK, until
    the first evaluation that finds nothing clears it, or `up` in a row confirm it. judged: whether
    an evaluation has come.
    """

    def __init__(self, up: int = LIMITS.debounce_up, down: int = LIMITS.debounce_down) -> None:
        self.up, self.down = up, down
        self.level = Level.WARN
        self.since_ns: int | None = None
        self._above = [0, 0]  # evaluations in a row at or above WARN, ERROR
        self._below = [0, 0]
        self.judged = False
        self._decided = False  # whether the start is over
        self._said: dict[Level, tuple[Group, ...]] = {}  # level: what was found last at it

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

        What it says fits the level in force: while a raw level is not believed yet, or not
        forgotten yet, it is what was found last at the level that stands.
        """
        level = self.update(outcome.level, stamp_ns)
        self._said[Level.OK if outcome.level == Level.OK else Level.WARN] = outcome.says
        if outcome.level == Level.ERROR:
            self._said[Level.ERROR] = outcome.says
        self._said.setdefault(level, outcome.says)
        return replace(self.standing(), values={
            **outcome.values, **({'lasts_s': self.lasted(stamp_ns)} if level else {})})

    def standing(self) -> Outcome:
        """Return the level in force, with what was found last at it."""
        return Outcome(self.level, self._said.get(self.level, ()))

    def lasted(self, stamp_ns: int) -> float:
        """Return how long the level has lasted at `stamp_ns` (s); 0 where time went backwards."""
        return 0.0 if self.since_ns is None else max((stamp_ns - self.since_ns) * 1e-9, 0.0)
