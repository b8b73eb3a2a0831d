# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Follow the wear of a gearbox window by window: what has changed for good.

`Tracker` holds the wear of each feature as a state (wear), finds its steps (wear.scan), and says
how large the wear is, since when, and when a limit will be reached (drift_words).
"""
from dataclasses import asdict, dataclass, field, replace
import math
from typing import Any, Self

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash import wear, wear_data
from gearbox_monitor.health.backlash.change_tests import (
    ALONE, ALONE_LOSS, ChangeTest, COMPONENTS, FEATURES, FRICTION, GAP, limits_of, PRIORS, SHARP,
    STIFFNESS, TESTS, VISCOUS_SHARE)
from gearbox_monitor.health.backlash.features import Backlash, Friction, NotExcited
from gearbox_monitor.health.backlash.operating_point import Bins, find_point, OperatingPoint
from gearbox_monitor.health.backlash.wear import Trend
from gearbox_monitor.health.backlash.wear_data import excess, OTHERS, TRUSTED, WearData
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

FOUND, WARNED, GROSS = 1, 2, 3  # stages of an alarm
RECENT = 12         # windows whose mean is shown while there is no change
MAX_STEPS, MAX_PENDING = 6, 8
HOUR = 3600e9       # ns


@dataclass(frozen=True)
class TrackerSettings:
    """
    What a Tracker goes by.

    windows_per_false_alarm: mean number of windows between two false alarms, of all tests
    together. baseline_windows: how many a point learns. bins: of operating points.
    limits {test: (notice, warn, error)}: relative changes; below `notice` nothing is reported.
    gap_limit: rad, 0 = none. viscous (N m s/rad), coulomb (N m): friction of the model. window:
    s.
    """

    windows_per_false_alarm: float = 3.15e6
    baseline_windows: int = 720
    bins: Bins = field(default_factory=Bins)
    limits: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    gap_limit: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    window: float = 10.0

    @classmethod
    def of(cls, parameters: EstimatorParameters, model: DriveModel) -> Self:
        """Return the TrackerSettings of `parameters` and the DriveModel `model`."""
        p = parameters
        return cls(
            max(p.false_alarm_interval / p.drift_window, 20.0), p.baseline_windows,
            Bins(p.angle_bin, p.speed_bin, p.load_bin, p.temperature_bin, model.axis == 'rotary'),
            limits_of(p), p.gap_limit, model.viscous_friction, model.coulomb_friction,
            p.drift_window)

    def threshold(self, test: ChangeTest) -> float:
        """Return the normal score at which `test` fires."""
        return wear.threshold(self.windows_per_false_alarm / test.share)

    def notice(self, column: int) -> float:
        """Return the smallest change (logarithm) of the feature in `column` that is reported."""
        key = next(t.key for t in TESTS if t.column == column)
        return math.log1p(self.limits.get(key, (0.0,))[0])


@dataclass
class Change:
    """
    A change that was found, and stays until it is over.

    since_ns: where it began, found_ns: where it was found; found: its relative size then;
    growth, std: now; stage: FOUND, WARNED (above the limit for a warning) or GROSS (for an error).
    """

    since_ns: int
    found_ns: int
    found: float
    growth: float
    std: float
    stage: int = FOUND


@dataclass(frozen=True)
class Baseline:
    """Healthy values of one operating point, their standard deviations, from so many windows."""

    gap: float
    gap_std: float
    stiffness: float
    stiffness_std: float
    windows: int


@dataclass
class FeatureWear:
    """
    The wear of a feature as it is known.

    steps, pending: stamps (ns) of its steps, and of motions with which one may have come. value,
    std: logarithm of the wear, or of the newest windows while there is no change; compared_ns:
    newest window that told it. slope, slope_std: per window; moving: probability of a slope.
    suspected, gone, lower: windows in a row in which one that is pending seems to be a step, a
    change seems to be over, or its stage to be left.
    """

    steps: list[int] = field(default_factory=list)
    pending: list[int] = field(default_factory=list)
    value: float = math.nan
    std: float = math.nan
    compared_ns: int = 0
    slope: float = 0.0
    slope_std: float = 0.0
    moving: float = 0.0
    suspected: int = 0
    gone: int = 0
    lower: int = 0


class Tracker:
    """
    The wear of one gearbox, its sequential test, forecast and alarms; one `update` per window.

    settings: TrackerSettings. state: what to_dict or baseline_points gave, or None. Raises
    ValueError, KeyError or TypeError for data that are no state.
    """

    def __init__(self, settings: TrackerSettings, state: Any = None) -> None:
        self.settings = settings
        self.data = WearData(settings.viscous, settings.coulomb)
        self.wear = [FeatureWear() for _ in FEATURES]
        self.scores = {test.key: 0.0 for test in TESTS}
        self.changes: dict[str, Change] = {}  # by test
        self.ended: dict[str, str] = {}  # by component: what was over with the newest window
        self.window: Backlash | None = None
        self.friction: Backlash | Friction | None = None
        self.point, self.trusted, self.compared = -1, False, False
        self.temperature: float | None = None  # of the newest window
        self.pause: NotExcited | None = None  # when the newest window was none
        self.stamp_ns = 0
        self._counted = (0, -1), 0  # windows at a point, at a stamp
        self._levels: Array = np.full(len(FEATURES), np.nan)  # healthy, at the newest point
        self._level_stds: Array = np.full(len(FEATURES), np.nan)
        if state is not None:
            self._load(state)

    # ------------------------------------------------------------------ windows

    def update(self, window: Backlash | NotExcited, trust: int = TRUSTED,
               temperature: float | None = None, comparable: bool = False
               ) -> None:
        """
        Take a window; `drift_words.outcomes` says what it changed.

        Args:
            window: features of the newest window, or why there are none.
            trust: in the estimates of the window, see wear_data; those of one level below TRUSTED
                may be off together.
            temperature: of the gearbox (deg C), None if unknown.
            comparable: whether a window that is not trusted is compared where its fit is as good
                as those of the baseline; else it is only shown.
        """
        if window.stamp_ns == self.stamp_ns:
            return  # it has been taken before
        self.stamp_ns, self.temperature = window.stamp_ns, temperature
        self.ended = {}
        features: Backlash | Friction
        if not isinstance(window, NotExcited):
            self.pause, self.window, features = None, window, window
        else:
            self.pause = window
            if window.friction is None:
                self.compared = False
                return
            features = window.friction
        self.friction, self.trusted, self.compared = features, trust == TRUSTED, False
        if self.trusted or comparable:
            self._take(features, int(trust))

    def _take(self, features: Backlash | Friction, trust: int) -> None:
        data, settings = self.data, self.settings
        count = len(data.points)
        point = find_point(data.points, features, self.temperature, settings.bins)
        place = data.points[point]
        values, variances = self._measure(features, place)
        usual = variances / excess(trust)
        if trust != TRUSTED:
            values = np.where(self._fits(variances, usual, place), values, math.nan)
        place.state(np.where(np.isfinite(values), usual, math.nan))
        self.point = point
        self.compared = bool(np.isfinite(values).any())
        if not self.compared:
            return
        if len(data.points) > count and self._windows() >= LIMITS.settled_windows:
            stamp = data.stamps[-1] if data.stamps else self.stamp_ns - 1
            for column, feature in enumerate(self.wear):
                if np.isfinite(values[column]):
                    pending = [*feature.pending, stamp]
                    # A change that came with one that is dropped shows at its neighbours.
                    feature.pending = pending[:1] + pending[1:][1 - MAX_PENDING:]
        data.add(self.stamp_ns, point, trust, data.warmth(self.temperature),
                 data.relative(values))
        marks = self._marks()
        data.couple(marks)
        data.absorb(marks, settings.baseline_windows)
        self._judge()

    def _windows(self) -> int:
        return len(self.data) + sum(block.windows for block in self.data.blocks)

    def _marks(self) -> list[int]:
        return sorted({stamp for feature in self.wear
                       for stamp in (*feature.steps, *feature.pending)})

    def _fits(self, variances: Array, usual: Array, place: OperatingPoint) -> Flags:
        """
        Return which features [F] of a window are as certain as comparing them requires.

        Args:
            variances: that it states [F].
            usual: these without what larger prediction errors explain [F].
            place: its operating point.

        Returns:
            The flags.

        """
        warn = np.zeros(len(FEATURES))
        for test in TESTS:
            if test.column < len(FEATURES) and test.key in self.settings.limits:
                warn[test.column] = self.settings.limits[test.key][1]
        with np.errstate(invalid='ignore'):
            result: Flags = (usual <= LIMITS.stated_ratio ** 2 * place.stated) \
                | (variances <= (LIMITS.precise * warn) ** 2)
        return result & (self._windows() >= LIMITS.min_baseline)

    def _measure(self, window: Backlash | Friction, place: OperatingPoint
                 ) -> tuple[Array, Array]:
        """Return (values [F], variances [F]) of a window's features, as WearData takes them."""
        w, nan = window, (math.nan, math.nan)
        gap, lost_motion, stiffness, hysteresis = (nan,) * 4
        if isinstance(w, Backlash):
            # A gap refined by other windows is not independent of them.
            gap = w.alone if w.separable else nan
            lost_motion = nan if w.separable else (w.lost_motion, w.lost_motion_std)
            stiffness = w.stiffness, w.stiffness_std
            hysteresis = w.hysteresis, w.hysteresis_std
        friction = self.healthy_friction(w)
        change = w.viscous * w.speed + w.coulomb
        rows = (gap, lost_motion, stiffness, hysteresis,
                (1.0 + change / friction if friction > 0.0 else math.nan,
                 math.hypot(w.viscous_std * w.speed, w.coulomb_std) / friction
                 if friction > 0.0 else math.nan),
                (1.0 + w.gain, w.gain_std), self._viscous_share(w))
        values, std = np.full(len(FEATURES), np.nan), np.full(len(FEATURES), np.nan)
        for column, ((value, deviation), prior) in enumerate(zip(rows, PRIORS)):
            if not (math.isfinite(value) and math.isfinite(deviation)):
                continue
            if not prior.logarithmic:
                unit = place.unit(column)
                values[column], std[column] = value / unit, deviation / unit
                continue
            reference = self.data.reference[column]
            lowest = math.exp(reference
                              - LIMITS.value_floor) if math.isfinite(reference) else 1e-12
            value = max(value, lowest)
            values[column], std[column] = math.log(value), deviation / value
        return values, std ** 2

    def healthy_friction(self, window: Backlash | Friction) -> float:
        """Return the friction of the model (N m) at the speed of a window, or its load."""
        friction = self.settings.viscous * window.speed + self.settings.coulomb
        return friction if friction > 0.0 else window.load

    def _healthy_share(self, speed: float) -> float:
        """Return the viscous share of the model's friction at a `speed`, NaN without friction."""
        viscous = self.settings.viscous * speed
        friction = viscous + self.settings.coulomb
        return viscous / friction if friction > 0.0 else math.nan

    def _viscous_share(self, window: Backlash | Friction) -> tuple[float, float]:
        """Return (viscous share of a window's friction less that of the model, deviation)."""
        w, change = window, window.viscous * window.speed
        friction = self.healthy_friction(w) + change + w.coulomb
        if not friction > 0.0:
            return math.nan, math.nan
        share = (self.settings.viscous * w.speed + change) / friction
        return share - self._healthy_share(w.speed), math.hypot(
            (1.0 - share) * w.viscous_std * w.speed / friction, share * w.coulomb_std / friction,
            LIMITS.share_error)

    # ------------------------------------------------------------------ inference

    def _prior(self, column: int, columns: int, points: int) -> Array:
        """Return the variances of `columns` columns of a design, see wear.Observations."""
        prior = PRIORS[_own(column)]
        spread = self.data.spread[column]
        offset = prior.offset ** 2 if not math.isfinite(spread) else spread
        common = (LIMITS.level_std ** 2, prior.temperature ** 2, prior.coulomb ** 2,
                  prior.distrust ** 2, self.data.shift[column])
        larger = columns - len(common) - points
        return np.concatenate([common, np.full(points, offset), np.full(
            larger, prior.distrust ** 2)])

    def _course(self, column: int) -> wear.Course:
        feature = self.wear[_own(column)]
        length = self.settings.window * 1e9
        return wear.Course(*(tuple(wear.ages(stamps, self.stamp_ns, length).tolist())
                             for stamps in (feature.steps, feature.pending)))

    def _judge(self) -> None:
        """Find new steps, and bring the wear of all features up to date."""
        data = self.data
        observed, points = data.observations(self.stamp_ns, self.settings.window * 1e9)
        place = points.index(data.newest)
        results: dict[int, tuple[wear.Wear, wear.Scan]] = {}
        for column in range(SHARP + 1):
            if column == SHARP:
                observed[SHARP] = self._without_others(observed[SHARP], results)
            o = observed[column] = self._widened(column, observed[column])
            if not o.weight.any() or (column == SHARP and o.count.sum() < LIMITS.min_complete):
                continue
            results[column] = self._estimated(column, o, len(points))
            self._learn(column, results[column][0].fit, points, place)
        scores = {column: self._scored(column, observed[column], result[1])
                  for column, result in results.items()}
        for column in range(len(FEATURES)):
            if column not in results:
                continue
            source = SHARP if column == GAP and SHARP in results \
                and self._all_else_equal(scores, results) else column
            if self._step(column, results, scores) or self._moved(
                    column, source, observed[source], len(points)):
                for c in {column, source}:
                    results[c] = self._estimated(c, observed[c], len(points))
            coupled = math.hypot(*(
                self.data.couplings[c] * math.hypot(w.std, LIMITS.coupled * w.value)
                for c, (w, _) in results.items() if c in OTHERS and self.wear[c].steps)
            ) if source == SHARP else 0.0
            told = column == VISCOUS_SHARE and self._told_by_friction(results)
            self._follow(column, observed[column], results[source], coupled, told)

    def _widened(self, column: int, o: wear.Observations) -> wear.Observations:
        """Return `o` with the noise that a smaller feature has: it does not shrink with it."""
        feature = self.wear[_own(column)]
        if not (feature.steps and PRIORS[_own(column)].logarithmic
                and feature.value < 0.0):
            return o
        since = wear.ages(feature.steps[:1], self.stamp_ns, self.settings.window * 1e9)[0]
        return replace(o, weight=np.where(
            o.age < since, o.weight * math.exp(2.0 * feature.value), o.weight))

    def _without_others(self, o: wear.Observations, results: dict[
            int, tuple[wear.Wear, wear.Scan]]) -> wear.Observations:
        """Return SHARP without what the known wear of the other features does to it."""
        y = o.y
        for column in OTHERS:
            if self.data.couplings[column] and self.wear[column].steps and column in results:
                y = y + self.data.couplings[column] * results[column][0].fit.wear(o.age)
        return replace(o, y=y)

    def _estimated(self, column: int, o: wear.Observations, points: int
                   ) -> tuple[wear.Wear, wear.Scan]:
        prior, course = self._prior(column, o.design.shape[1], points), self._course(column)
        noise = math.sqrt(self.data.points[self.data.newest].variance()[column])
        estimate = wear.estimate(o, prior, course, noise)
        return estimate, wear.scan(o, estimate.fit)

    def _learn(self, column: int, fit: wear.Fit, points: list[int], place: int) -> None:
        """Keep what a fit says of temperature, spread of offsets and the healthy level."""
        data, first = self.data, wear.N_COMMON
        share = data.shares([points[place]], column)[0]
        data.slopes[column] = fit.mean[wear.TEMPERATURES] @ share
        variance = np.diag(fit.covariance)
        offsets = slice(first, first + len(points))
        stated = PRIORS[_own(column)].offset ** 2
        feature = self.wear[_own(column)]
        if len(points) > 1 and not feature.steps and not feature.pending:
            squares = fit.mean[offsets] ** 2 + variance[offsets]
            data.spread[column] = (LIMITS.offset_windows * stated + float(squares.sum())) / (
                LIMITS.offset_windows + len(points))
        if column < len(FEATURES):
            at = np.zeros(len(fit.mean))
            at[[wear.LEVEL, first + place]] = 1.0
            at[wear.TEMPERATURES] = data.kelvin[-1] * share
            self._levels[column] = at @ fit.mean
            self._level_stds[column] = math.sqrt(max(float(at @ fit.covariance @ at), 0.0))

    def _scored(self, column: int, o: wear.Observations, scanned: wear.Scan
                ) -> tuple[Array, Array]:
        """Return (up, down): normal scores [M] of stretches that have enough before them."""
        m = o.rows
        required = LIMITS.min_complete if column == SHARP else LIMITS.min_baseline
        windows = o.count[:-m].sum() + np.concatenate([[0.0], np.cumsum(o.count[-m:])[:-1]])
        # Only the noise is known by so many windows, not what priors add (Satterthwaite).
        dof = self.data.points[self.data.newest].dof(column) / np.maximum(scanned.noise, 1e-3) ** 2
        up, down = (np.where(windows >= required, wear.normal_score(score, dof), 0.0)
                    for score in (scanned.up, scanned.down))
        return up, down

    def _step(self, column: int, results: dict[int, tuple[wear.Wear, wear.Scan]],
              scores: dict[int, tuple[Array, Array]]) -> bool:
        """Add the step of a feature that its tests find; return whether anything is new."""
        data = self.data
        notice = self.settings.notice(column)
        detected: list[tuple[float, int]] = []
        for test in TESTS:
            source = test.column
            if _own(source) != column or source not in scores:
                continue
            score = scores[source][0 if test.sign > 0 else 1]
            k = int(np.argmax(score))
            self.scores[test.key] = float(score[k])
            scanned, threshold = results[source][1], self.settings.threshold(test)
            smallest = test.sign * scanned.size - scanned.std
            if test.key in (ALONE, ALONE_LOSS):
                raw = scores[GAP][0 if test.sign > 0 else 1][k]
                if not (self._stayed(scores, results, k) and raw > LIMITS.agrees):
                    continue
                smallest = np.where(np.arange(len(score)) == k, np.fmin(
                    smallest, test.sign * results[GAP][1].size), math.nan)
            smallest = smallest - PRIORS[column].crosstalk * self._moves(column, results, scores)
            with np.errstate(invalid='ignore'):
                significant = np.flatnonzero((score > threshold) & (smallest >= notice))
            if len(significant):
                # The likeliest: the score of a long stretch rests on more windows.
                gain = scanned.up if test.sign > 0 else scanned.down
                k = int(significant[np.argmax(gain[significant])])
                detected.append((float(score[k]) - threshold, k))
        if detected:
            _, k = max(detected)
            self._add_step(column, data.stamps[k - 1] if k else data.stamps[0] - 1)
            return True
        return self._suspected(column, results)

    def _moves(self, column: int, results: dict[int, tuple[wear.Wear, wear.Scan]],
               scores: dict[int, tuple[Array, Array]]) -> float:
        """Return the largest change of other features, known or only suspected."""
        largest = 0.0
        for c, (estimate, scanned) in results.items():
            if c in (column, SHARP):
                continue
            if self.wear[c].steps:
                largest = max(largest, abs(estimate.value))
            for side in scores[c]:
                k = int(np.argmax(side))
                if side[k] > LIMITS.stayed:
                    largest = max(largest, abs(float(scanned.size[k])))
        return largest

    def _stayed(self, scores: dict[int, tuple[Array, Array]],
                results: dict[int, tuple[wear.Wear, wear.Scan]], k: int) -> bool:
        """Return whether what SHARP is made of has stayed since row k, or is known."""
        for c in OTHERS:
            if c not in scores or not self.data.couplings[c]:
                continue
            estimate, scanned = results[c]
            certain = not self.wear[c].pending and (
                not self.wear[c].steps or estimate.moving < LIMITS.moving
                and self.wear[c].steps[-1]
                < self.data.stamps[max(len(self.data) - LIMITS.step_settle, 0)])
            if not certain or max(scores[c][0][k], scores[c][1][k]) > LIMITS.stayed \
                    or abs(scanned.newest) > LIMITS.stayed:
                return False
        return True

    def _all_else_equal(self, scores: dict[int, tuple[Array, Array]],
                        results: dict[int, tuple[wear.Wear, wear.Scan]]) -> bool:
        """Return whether SHARP tells the gap: no stretch of what it is made of has changed."""
        return all(self._stayed(scores, results, int(np.argmax(scores[c][side])))
                   for c in OTHERS if c in scores and self.data.couplings[c]
                   for side in (0, 1))

    def _add_step(self, column: int, stamp_ns: int) -> None:
        feature = self.wear[column]
        feature.steps = sorted({*feature.steps, stamp_ns})
        feature.pending = [p for p in feature.pending if p != stamp_ns]
        while len(feature.steps) > MAX_STEPS:  # what was between the oldest two is history
            begin = feature.steps.pop(0)
            self.data.drop(column, begin, feature.steps[0])

    def _suspected(self, column: int, results: dict[int, tuple[wear.Wear, wear.Scan]]) -> bool:
        """Judge a step that may have come with a new motion: found, resolved, or still open."""
        feature = self.wear[column]
        if not feature.pending:
            return False
        if feature.steps:
            return self._resolved(column, results[column][0].fit)
        estimate = results[column][0]
        stamps = np.array(self.data.stamps, np.int64)
        since = stamps > feature.pending[0]
        measured = since & np.isfinite(self.data.values[:, column])
        sign = 1 if estimate.value > 0.0 else -1
        test = next(t for t in TESTS if t.column == column and t.sign == sign)
        std = max(estimate.std, 1e-12)
        share = self.data.points[self.data.newest].variance()[column] / (
            max(int(measured.sum()), 1) * std ** 2)
        dof = self.data.points[self.data.newest].dof(column) / min(max(share, 1e-3), 1.0) ** 2
        score = float(wear.normal_score(np.array(abs(estimate.value) / std), np.array(dof)))
        notice = self.settings.notice(column)
        suspected = score > self.settings.threshold(test) and abs(estimate.value) >= notice
        # Not from one window alone, wherever it lies.
        feature.suspected = feature.suspected + 1 if suspected else 0
        if feature.suspected > 1:
            feature.suspected = 0
            self._add_step(column, feature.pending[-1])
            feature.pending = []
            return True
        older = np.array([self.data.points[p].since_ns <= feature.pending[0]
                          for p in self.data.where])
        if estimate.std <= LIMITS.over * notice and abs(estimate.value) < notice \
                or (measured & older).sum() >= LIMITS.resolved and score < LIMITS.stayed:
            feature.pending = []
            return True
        return False

    def _resolved(self, column: int, fit: wear.Fit) -> bool:
        """Settle what may have come with a new motion, beside a step that is known."""
        feature, notice = self.wear[column], self.settings.notice(column)
        begin = fit.first + len(fit.course.steps)
        for k, stamp in enumerate(tuple(feature.pending)):
            value = float(fit.mean[begin + k])
            std = math.sqrt(max(float(fit.covariance[begin + k, begin + k]), 0.0))
            if std <= LIMITS.over * notice:
                feature.pending = [p for p in feature.pending if p != stamp]
                if abs(value) >= notice + std:
                    self._add_step(column, stamp)
                return True
        return False

    def _moved(self, column: int, source: int, o: wear.Observations, points: int) -> bool:
        """
        Search the place of the only step again, now that more windows tell it.

        Args:
            column: of the feature.
            source: the column that tells it.
            o: observations of `source`.
            points: how many take part.

        Returns:
            Whether it moved.

        """
        feature, data = self.wear[column], self.data
        if len(feature.steps) != 1 or feature.pending or feature.steps[0] < data.stamps[0] or \
                feature.steps[0] <= data.stamps[max(len(data) - LIMITS.step_settle, 0)]:
            return False
        first, feature.steps = feature.steps[0], []
        scanned = wear.scan(o, wear.fit(
            o, self._prior(source, o.design.shape[1], points), self._course(source)))
        k = int(np.argmax(np.maximum(scanned.up, scanned.down)))
        feature.steps = [data.stamps[k - 1] if k else data.stamps[0] - 1]
        return feature.steps[0] != first

    def _follow(self, column: int, o: wear.Observations,
                result: tuple[wear.Wear, wear.Scan], coupled: float, told: bool) -> None:
        """
        Bring the wear of a feature up to date: its size, stage, and whether it is over.

        Args:
            column: of the feature.
            o: its observations.
            result: what tells its wear.
            coupled: standard deviation that the wear of other features adds.
            told: whether another feature tells a change of this one.

        """
        feature, (estimate, scanned) = self.wear[column], result
        if o.weight[-1] > 0.0:
            feature.compared_ns = self.stamp_ns
        feature.value, feature.std = estimate.value, math.hypot(estimate.std, coupled)
        feature.slope, feature.slope_std, feature.moving = (
            estimate.slope, estimate.slope_std, estimate.moving)
        if not feature.steps and not feature.pending:
            recent = np.flatnonzero(o.weight[-o.rows:] > 0.0)
            if len(recent):
                # Windows at odds with the drive may be off together: all against those before.
                trusted = np.flatnonzero(np.array(self.data.trust) == TRUSTED)
                begin = trusted[-1] + 1 if len(trusted) else 0
                k = begin if begin <= recent[-1] else \
                    recent[-min(RECENT, (len(recent) + 1) // 2)]
                feature.value, feature.std = float(scanned.size[k]), float(scanned.std[k])
        up, down = (next(t for t in TESTS if t.column == column and t.sign == sign)
                    for sign in (1, -1))
        if not feature.steps:
            for test in (up, down):
                self.changes.pop(test.key, None)
            return
        standing = next((t for t in (up, down) if t.key in self.changes), None)
        test, opposite = (up, down) if feature.value > 0.0 else (down, up)
        if standing is opposite and abs(feature.value) < LIMITS.over_std * feature.std:
            test, opposite = opposite, test  # nothing yet says that it goes the other way
        growth, std = self.relative(column, feature.value, feature.std)
        old = self.changes.get(test.key) or self.changes.get(opposite.key)
        if self._over(column, old):
            ended = up if up.key in self.changes else down
            if ended.key in self.changes:
                text = (f'over: {ended.words.replace(" has ", " had ")} '
                        f'{100 * self.changes[ended.key].found:.1f} %')
                self.ended[ended.component] = '; '.join(filter(None, (
                    self.ended.get(ended.component), text)))
            self._end(column)
            return
        if told and old is None:
            return
        if test.key not in self.changes:
            self.changes.pop(opposite.key, None)
            self.changes[test.key] = Change(
                feature.steps[-1 if old else 0], self.stamp_ns, test.sign * growth,
                test.sign * growth, std)
        change = self.changes[test.key]
        if change.since_ns not in feature.steps:
            change.since_ns = feature.steps[0]
        change.growth, change.std = test.sign * growth, std
        _, warn, error = self.limits(test)
        stage = FOUND
        for at, limit in ((WARNED, warn), (GROSS, error)):
            if change.growth >= (limit if change.stage < at else LIMITS.release * limit):
                stage = at
        # Not from one window alone, and not twice for one that wavers.
        feature.lower = feature.lower + 1 if stage < change.stage else 0
        if stage > change.stage or feature.lower >= LIMITS.over_windows:
            change.stage, feature.lower = stage, 0

    def _told_by_friction(self, results: dict[int, tuple[wear.Wear, wear.Scan]]) -> bool:
        """
        Return whether a change of the friction tells that of its viscous share.

        The share changes by no more than the friction does, relative to it, unless viscous and
        Coulomb friction go opposite ways. A slow change of it may be found that much later.
        """
        feature = self.wear[VISCOUS_SHARE]
        if FRICTION not in results or not feature.steps:
            return False
        estimate, scanned = results[FRICTION]
        if self.wear[FRICTION].steps:
            age = wear.ages(feature.steps[:1], self.stamp_ns, self.settings.window * 1e9)[0]
            growth, earlier = np.expm1(estimate.fit.wear(np.array([0.0, age + LIMITS.horizon])))
        else:
            k = int(np.searchsorted(self.data.stamps[:-1], feature.steps[-1], 'right'))
            growth, earlier = np.expm1(np.nan_to_num(scanned.size[k])), 0.0
        share = results[VISCOUS_SHARE][0]
        return bool(abs(share.value) - share.std - abs(growth - earlier)
                    < self.settings.notice(VISCOUS_SHARE))

    def _over(self, column: int, change: Change | None) -> bool:
        """Return whether a change has gone, for some windows in a row by now."""
        feature, notice = self.wear[column], self.settings.notice(column)
        size = abs(change.found) if change else 0.0
        gone = (abs(feature.value) < max(LIMITS.over * notice, LIMITS.over_std * feature.std)
                and feature.std <= max(LIMITS.over * notice, LIMITS.over_share * size))
        feature.gone = feature.gone + 1 if gone else 0
        return feature.gone >= LIMITS.over_windows

    def _end(self, column: int) -> None:
        """Forget a change that is over, and the windows in which it lasted."""
        feature = self.wear[column]
        end = feature.steps[-1] if len(feature.steps) > 1 else \
            self.data.stamps[max(len(self.data) - RECENT, 0)] - 1
        self.data.drop(column, feature.steps[0], end)
        feature.steps, feature.pending, feature.gone = [], [], 0
        for test in TESTS:
            if test.column == column:
                self.changes.pop(test.key, None)

    # ------------------------------------------------------------------ what is known

    def relative(self, column: int, value: float, std: float) -> tuple[float, float]:
        """Return (growth, deviation) of `value` +- `std` in `column`: of logarithms, relative."""
        prior = PRIORS[column]
        missed = prior.crosstalk * max((abs(feature.value) for c, feature in enumerate(self.wear)
                                        if c != column and feature.steps), default=0.0)
        if not prior.logarithmic:
            return value, math.hypot(std, prior.scale * value, missed)
        growth = math.expm1(value)
        return growth, math.hypot((1.0 + growth) * std, prior.scale * growth, missed)

    def limits(self, test: ChangeTest) -> tuple[float, float, float]:
        """Return the sizes from which on a change is noticed, a warning, an error by `test`."""
        notice, warn, error = self.settings.limits.get(test.key, (0.0, math.inf, math.inf))
        base = self.baseline
        if test.key == 'gap' and self.settings.gap_limit > 0.0 and base and base.gap > 0.0:
            error = min(error, self.settings.gap_limit / base.gap - 1.0)
        return notice, warn, error

    def growth(self, column: int) -> tuple[float, float]:
        """Return (growth, deviation) of the feature in `column` now, NaN while it is not known."""
        feature = self.wear[column]
        if not (math.isfinite(feature.value) and feature.compared_ns):
            return math.nan, math.nan
        growth, std = self.relative(column, feature.value, feature.std)
        # What has happened since it was measured is not known.
        idle = max(self.stamp_ns - feature.compared_ns, 0) / HOUR
        return growth, math.hypot(std, self.settings.notice(column) * math.sqrt(idle))

    def coefficients(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """
        Return (growth, deviation) of viscous and of Coulomb friction; None while not known.

        By the wear of the friction and of its viscous share at the newest operating point.
        """
        (growth, growth_std), (shift, shift_std) = (
            self.growth(column) for column in (FRICTION, VISCOUS_SHARE))
        if self.point < 0 or not math.isfinite(growth + shift):
            return None
        viscous = float(self._healthy_share(self.data.points[self.point].speed)
                        + self.data.reference[VISCOUS_SHARE] + self._levels[VISCOUS_SHARE])
        if not 0.0 < viscous < 1.0:
            return None
        rows = [((1.0 + growth) * (share + change) / share - 1.0,
                 math.hypot((share + change) * growth_std, (1.0 + growth) * shift_std) / share)
                for share, change in ((viscous, shift), (1.0 - viscous, -shift))]
        return rows[0], rows[1]

    def trend(self, column: int) -> Trend | None:
        """Return the Trend of the feature in `column` since its last step, None without one."""
        feature = self.wear[column]
        if not feature.steps or feature.moving < LIMITS.moving or \
                abs(feature.slope) < LIMITS.significant_slope * feature.slope_std:
            return None
        growth, std = self.growth(column)
        unit = (1.0 + growth if PRIORS[column].logarithmic else 1.0) / self.settings.window
        return Trend(self.stamp_ns, growth, std, feature.slope * unit, feature.slope_std * unit)

    def steady(self, column: int) -> bool:
        """Return whether the feature has moved by less than is reported since its last step."""
        feature = self.wear[column]
        if not feature.steps or feature.moving >= LIMITS.moving:
            return False
        windows = (self.stamp_ns - feature.steps[-1]) * 1e-9 / self.settings.window
        fastest = abs(feature.slope) + LIMITS.steady_std * feature.slope_std
        return fastest * windows < self.settings.notice(column)

    @property
    def baseline(self) -> Baseline | None:
        """The Baseline of the operating point of the newest window, None while not known."""
        if self.point < 0 or not math.isfinite(self._levels[GAP]):
            return None
        count = self.point_windows()
        if count < LIMITS.min_baseline:
            return None
        (gap, gap_std), (stiffness, stiffness_std) = (
            self._natural(column, self._levels[column], self._level_stds[column])
            for column in (GAP, STIFFNESS))
        return Baseline(gap, gap_std, stiffness, stiffness_std, count)

    def _natural(self, column: int, level: float, std: float, unit: float = 1.0
                 ) -> tuple[float, float]:
        """Return (value, deviation) in units of the feature; unit: of a point."""
        if not PRIORS[column].logarithmic:
            return float((self.data.reference[column] + level) * unit), float(std * unit)
        value = math.exp(self.data.reference[column] + level)
        return value, float(std * value)

    def point_windows(self) -> int:
        """Return the number of windows at the operating point of the newest one."""
        if self._counted[0] != (self.stamp_ns, self.point):
            count = self.data.count(self.point) if self.point >= 0 else 0
            self._counted = (self.stamp_ns, self.point), count
        return self._counted[1]

    def stages(self) -> dict[str, dict[str, int]]:
        """Return {component: {test: stage}}; an alert is given when that changes."""
        return {component: {t.key: self.changes[t.key].stage for t in TESTS
                            if t.component == component and t.key in self.changes}
                for component in COMPONENTS}

    # ------------------------------------------------------------------ healthy by decision

    def accept(self) -> int:
        """
        Make what is measured now the healthy state; return how many windows it rests on.

        The wear becomes 0 with its deviation, at all operating points. Ends all alarms.
        """
        data, length = self.data, self.settings.window * 1e9
        used = sum(data.count(k) for k in range(len(data.points)))
        if not data.stamps:
            return used
        since = max((f.steps[-1] for f in self.wear if f.steps), default=0)
        if since:
            observed, points = data.observations(self.stamp_ns, length)
            estimates = {column: self._estimated(column, observed[column], len(points))[0]
                         for column, feature in enumerate(self.wear) if feature.steps}
            # What others seem to have changed by stays, too.
            largest = max(abs(w.value) for w in estimates.values())
            data.shift_by({c: w.value - w.fit.wear(wear.ages(
                data.middles(), self.stamp_ns, length)) for c, w in estimates.items()},
                {c: estimates[c].std ** 2 if c in estimates
                 else (prior.crosstalk * largest) ** 2 for c, prior in enumerate(PRIORS)}, since)
            used = int((np.array(data.stamps, np.int64) > since).sum())
        for feature in self.wear:
            feature.steps, feature.pending = [], []
        self.ended = {t.component: 'over: saved as the baseline' for t in TESTS
                      if t.key in self.changes}
        self.changes, self._counted = {}, ((0, -1), 0)
        self.scores = dict.fromkeys(self.scores, 0.0)
        self._judge()
        return used

    # ------------------------------------------------------------------ state

    def baseline_points(self) -> list[dict[str, Any]]:
        """Return the baselines as plain data, a list with one mapping per operating point."""
        data = self.data
        if not data.stamps and not data.blocks:
            return []
        length = self.settings.window * 1e9
        rows: list[dict[str, Any]] = [
            {**p.place(), 'scale': p.scale, 'features': {}} for p in data.points]
        observed, points = data.observations(max(self.stamp_ns, 1), length)
        for column, name in enumerate(FEATURES):
            o = observed[column]
            if not o.weight.any():
                continue
            fit = wear.fit(o, self._prior(column, o.design.shape[1], len(points)),
                           self._course(column))
            for k, point in enumerate(points):
                index, place = wear.N_COMMON + k, data.points[point]
                at_point = o.design[:, index] > 0.0
                count = int(round(float(o.count[at_point].sum())))
                if count:
                    level = fit.mean[wear.LEVEL] + fit.mean[index]
                    if place.temperature is not None and data.first_kelvin is not None:
                        level += fit.mean[wear.TEMPERATURES] @ data.shares(
                            [point], column)[0] * (place.temperature - data.first_kelvin)
                    variance, unit = place.variance()[column], place.unit(column)
                    mean, std = self._natural(column, level, math.sqrt(variance), unit)
                    _, stated = self._natural(
                        column, level, math.sqrt(place.stated[column]), unit)
                    rows[point]['features'][name] = {
                        'windows': count, 'mean': mean, 'std': std, 'stated_std': stated}
        if data.couplings.any():
            for row in rows:
                row['couplings'] = {name: float(v) for name, v in zip(FEATURES, data.couplings)
                                    if v}
        return [row for row in rows if row['features']]

    def to_dict(self) -> dict[str, Any]:
        """Return all that the next outcomes depend on, as plain data; floats read back exactly."""
        return {
            'wear': [asdict(feature) for feature in self.wear], **self.data.to_dict(),
            'scores': self.scores,
            'changes': {key: asdict(change) for key, change in self.changes.items()},
            'levels': [float(v) for v in self._levels],
            'level_stds': [float(v) for v in self._level_stds], 'ended': self.ended,
            'window': self.window and asdict(self.window), 'point': self.point,
            'friction': asdict(self.friction) if isinstance(self.friction, Friction) else None,
            'trusted': self.trusted, 'compared': self.compared,
            'temperature': self.temperature, 'stamp_ns': self.stamp_ns,
            'pause': self.pause and {
                'stamp_ns': self.pause.stamp_ns, 'reason': self.pause.reason,
                'friction': self.pause.friction and asdict(self.pause.friction)}}

    def _load(self, state: Any) -> None:
        if isinstance(state, list):  # baselines alone
            wear_data.load_baselines(self.data, state)
            return
        self.data.load(state)
        if len(state['wear']) != len(FEATURES):
            raise ValueError(f'{len(state["wear"])} features, expected {len(FEATURES)}')
        self.wear = [FeatureWear(**row) for row in state['wear']]
        self.scores.update({test.key: float(state['scores'].get(test.key, 0.0))
                            for test in TESTS})
        self.changes = {key: Change(**value) for key, value in state['changes'].items()
                        if key in self.scores}
        self._levels, self._level_stds = (
            np.array(state[name], float) for name in ('levels', 'level_stds'))
        self.ended = dict(state['ended'])
        self.window = state['window'] and Backlash(**state['window'])
        friction = state['friction']
        self.friction = Friction(**friction) if friction else self.window
        self.point, self.trusted = int(state['point']), bool(state['trusted'])
        self.compared = bool(state['compared'])
        if self.point >= len(self.data.points):
            raise ValueError('an unknown operating point')
        self.temperature = state['temperature']
        pause = state['pause']
        if pause:
            friction = pause['friction']
            pause = NotExcited(**{**pause, 'friction': friction and Friction(**friction)})
        self.pause = pause
        self.stamp_ns = int(state['stamp_ns'])


def _own(column: int) -> int:
    """Return the feature that a `column` tells: SHARP tells the gap."""
    return GAP if column == SHARP else column
