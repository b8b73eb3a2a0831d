# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Alarms: every limit that decides one, its outcome, and the state machine that debounces it.

All limits of alerts are in LIMITS, each with its meaning, and nowhere else. Settings of a fit,
grids of a search and sizes of buffers, which change how soon a result arrives and not what counts
as one, stand where they are used. Limits of wear and priors of features stand in
backlash.change_tests. A command that a comment names shows what the indicators detect with all
limits together; no command derives a limit alone. Deviations are standard deviations.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import enum
from importlib import import_module
from types import MappingProxyType
from typing import Self, TypeAlias

from gearbox_monitor.kernels.types import Values
from gearbox_monitor.presentation import Said


@dataclass(frozen=True)
class AlertLimits:
    """Limits that decide an alert, or whether a window may be compared."""

    # --- Evaluation, once per second
    # s after a start that are not judged: the transient of the filter.
    settle: float = 2.0
    # Samples of a window that may be lost or bad: its features lose a hundredth of their weight.
    missing_share: float = 0.01
    # Evaluations in a row that raise and that lower a level: one flag is chance, and a fault that
    # comes and goes stays visible.
    debounce_up: int = 3
    debounce_down: int = 5
    # s between two looks: a late timer is followed by one that comes too soon.
    min_silence: float = 0.5
    # s before the first sample ever in which silence is no error: discovery takes as long.
    start_time: float = 5.0
    # Stated deviations beyond which a value is not chance, which is so in 0.3 %: torque,
    # twist and its rate move, a torque loads a flank, friction at a speed is certain, a
    # learned value is beyond what is allowed, a slope is a trend, neighbours differ by a
    # change. And beyond which a window contradicts those before, or the zero of the twist the
    # reference, and within which a hidden twist may be on either flank: 6e-5.
    deviations: float = 3.0
    contradicted: float = 4.0
    # Share from which on something holds most of the time, or is likelier than all else.
    most: float = 0.5

    # --- Prediction errors
    # s that the mean and, but for single errors, which are those since the last evaluation, all
    # else of the prediction errors are judged over; the latter of torque against twist, too.
    mean_window: float = 0.5
    error_window: float = 2.0
    # Of each of the three tests on one window, were the filter's model exact. So small because it
    # never is: a random walk for tau_K, a friction linearised at standstill leave traces.
    error_significance: float = 1e-6
    # Share of an innovation that those before it predict, beyond chance, to be called not white.
    predictable: float = 0.2
    # NIS over its expectation: a noise that is 12 % off; twice is no noise but another model.
    nis_low: float = 0.75
    nis_high: float = 1.25
    nis_gross: float = 2.0
    # Squared innovation over predicted variance of one encoder: a noise that is 18 % off.
    variance_low: float = 0.7
    variance_high: float = 1.4
    # Predicted deviations of one error: 6e-7 by chance.
    gate: float = 5.0

    # --- Uncertainty of tau_K
    # Of the reference: lower, measurements are hardly used; higher, they are missing. Detections
    # and false alarms: `python -m benchmarks trust`.
    covariance_low: float = 0.8
    covariance_high: float = 1.3
    # Evaluations whose median is the reference, where none was given: a median outlives two.
    reference_evaluations: int = 5

    # --- Observability
    # s of samples whose information is judged: so few that a passing loss shows.
    information_window: float = 0.1
    # Share of the prior deviation that remains: more is a state that readings hardly tell.
    # Detections and false alarms: `python -m benchmarks trust`.
    untrusted: float = 0.3
    # Share of the prior deviation of tau_K: the filter knows no more than before it began.
    unknown: float = 1.0

    # --- Torque against twist
    # Correlation of torque and twist, and power over their rms, below which a sign is wrong: a
    # transmission pushes back and makes no power, both are 0 or more but for noise and friction.
    correlation: float = -0.15
    power: float = -0.5

    # --- Range of the twist
    # Times the twist that the model allows. A drive that has worn, or a stiffness that was
    # guessed, may twist so much more; two encoders of different shafts twist by turns.
    twist_room: float = 4.0

    # --- Slip
    # Share of backlash and elastic twist that the zero of the twist may move by: load and runout
    # of the teeth move it by a tenth.
    slip_room: float = 0.2

    # --- Elastic curve
    # s of a window, of the range of the twist, too, and those of it that must be there.
    curve_window: float = 10.0
    curve_shortest: float = 4.0
    # Share of the rows that a flank must hold, or no stiffness is seen.
    curve_contact: float = 0.05
    # Share of the rows that may be beyond `deviations`.
    curve_share: float = 0.01
    # Probability of an error of torque or twist by chance, by Student's t over blocks.
    curve_significance: float = 1e-3
    # So many whole windows before it make an error certain by how little all differ, too; up to
    # twice as many count.
    curve_earlier: int = 3
    # A locked input moves by so many noises of its encoder at most: a brake yields a little; the
    # output turns by as many at least, and the input by at most this share of its travel.
    locked_noise: float = 20.0
    locked_share: float = 0.1
    # Standard errors by which a lasting misfit is more than that of a block or two: Student's t of
    # 19 degrees of freedom at 0.95.
    curve_often: float = 1.7291328115213682
    # Weight that rows keep at standstill, where friction is uncertain.
    curve_standstill_weight: float = 0.05
    # Deviations expected before a window is seen: of stiffness and of half gap and play relative
    # to the model's, by wear; of the friction, too; scale; delay (s); gain.
    curve_stiffness: float = 0.1
    curve_gap: float = 0.5
    curve_friction: float = 1.0
    curve_scale: float = 0.5
    curve_delay: float = 0.05
    curve_gain: float = 1.0
    # Deviation of what has no tolerance: too small to explain anything.
    curve_fixed: float = 1e-4

    # --- Model
    # Relative deviation of a value that counts as learned.
    learned_std: float = 0.1

    # --- Elastic curve and features of a window
    # Residuals beyond so many deviations count less: 96 % efficient for normal ones.
    huber: float = 1.5

    # --- Features of a window
    # Points that a fit or a check of smoothed rows needs: eight parameters and blocks of them.
    window_points: int = 50
    # Share of a window that each flank must hold: three of its 300 groups.
    flank: float = 0.01
    # Crossings of the gap: there and back.
    traversals: int = 2
    # Deviations expected of changes: friction relative to the model's, and to the torque for a
    # model that has none; torque gain.
    friction_prior: float = 0.3
    torque_share: float = 0.02
    gain_prior: float = 0.05
    # Share of what was expected to which a window narrows what it identifies.
    identified: float = 0.6
    # Smallest deviation of the viscous share: no motion shows Coulomb friction of a thousandth.
    share_error: float = 1e-3
    # Correlation of twist and torque on each flank that tells gap and compliance apart: half of
    # the torque's variance.
    flank_correlation: float = 0.7
    # Share of the samples in which the twist answers to the direction, or lost motion is none.
    one_sided: float = 0.9
    # Relative deviation of a hidden gap: beyond, the motion does not show it.
    hidden_std: float = 0.3
    # Of the twist by the load: a hidden gap below is none.
    hidden_gap: float = 1e-3

    # --- Words and forecast
    # Windows without one that can be compared before an outcome says so.
    grace: int = 3
    # Deviations within which a size is not known, and within which a change that requires a
    # service is said to hide behind a new motion: 5 % and 10 % of the chance.
    open_std: float = 2.0
    hides_std: float = 1.28
    # What averaging over windows does not remove, relative: of a width, not of its growth.
    gap_error: float = 0.01
    stiffness_error: float = 0.02


LIMITS = AlertLimits()


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
