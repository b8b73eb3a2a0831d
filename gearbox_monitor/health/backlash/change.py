# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Follow the wear of a gearbox window by window: what has changed for good.

`Tracker` holds the wear of each feature as a state (wear), finds its steps (wear.scan), and says
how large the wear is, since when, and when a limit will be reached: its `health`.
"""
from dataclasses import asdict, dataclass, field, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash import wear
from gearbox_monitor.health.backlash.change_tests import (
    ALONE, ALONE_LOSS, ChangeTest, FEATURES, FRICTION, GAP, LOST_MOTION, PRIORS, SHARP, TESTS,
    VISCOUS_SHARE)
from gearbox_monitor.health.backlash.features import Backlash, Friction
from gearbox_monitor.health.backlash.operating_point import find_point, OperatingPoint
from gearbox_monitor.health.backlash.wear import Trend
from gearbox_monitor.health.backlash.wear_data import excess, OTHERS, WearData
from gearbox_monitor.health.health_record import (
    Alert, FeatureHealth, FOUND, GROSS, Health, HealthSettings, tests_of, TRUSTED, WARNED, Window)
from gearbox_monitor.kernels.types import Array, Flags, Values

RECENT = 12         # windows whose mean is shown while there is no change
MAX_STEPS, MAX_PENDING = 6, 8
HOUR = 3600e9       # ns
LOSSES = {'gap_loss', 'lost_motion_loss'}  # tests of a backlash that became smaller


@dataclass
class FeatureWear:
    """
    The wear of a feature as it is known.

    steps, pending: stamps (ns) of its steps, and of motions with which one may have come. value,
    std: logarithm of the wear, or of the newest windows while there is no change; compared_ns:
    newest window that told it. slope, slope_std: per window; moving: probability of a slope.
    suspected, gone, lower: windows in a row in which one that is pending seems to be a step, a
    change seems to be over, or its stage to be left. newest: see FeatureHealth.
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
    newest: float = 0.0


class Tracker:
    """
    The wear of one gearbox, its sequential test, forecast and alarms; one `update` per window.

    settings: HealthSettings. state: what to_dict gave, None at the begin. Raises ValueError,
    KeyError or TypeError for data that are no state.
    """

    def __init__(self, settings: HealthSettings, state: Values | None = None) -> None:
        self.settings = settings
        self.data = WearData(settings.viscous, settings.coulomb)
        self.wear = [FeatureWear() for _ in FEATURES]
        self.scores = {test.key: 0.0 for test in TESTS}
        self.alerts: dict[str, Alert] = {}  # by test
        self.ended: dict[str, str] = {}  # by component: what was over with the newest window
        self.window: Window | None = None
        self.backlash: Backlash | None = None
        self.friction: Backlash | Friction | None = None
        self.point, self.trusted, self.compared, self.over_limit = -1, False, False, False
        self.stamp_ns = self.service_ns = 0  # of the newest window; of a service until it counts
        self.marks: list[tuple[int, str]] = []  # (stamp, words): where another baseline began
        self._counted = (0, -1), 0  # windows at a point, at a stamp
        self._levels: Array = np.full(len(FEATURES), np.nan)  # healthy, at the newest point
        self._level_stds: Array = np.full(len(FEATURES), np.nan)
        if state:
            self._load(state)

    # ------------------------------------------------------------------ windows

    def update(self, window: Window) -> None:
        """Take a `window`; `health` says what it changed."""
        if window.stamp_ns == self.stamp_ns:
            return  # it has been taken before
        if window.stamp_ns < self.stamp_ns:
            # The clock was set back, or is another one: what was before keeps its order.
            self._move(window.stamp_ns - self.stamp_ns - round(self.settings.window * 1e9))
        self.stamp_ns, self.window, self.ended = window.stamp_ns, window, {}
        features = window.friction
        self.compared = False
        if isinstance(window.features, Backlash):
            self.backlash = window.features
            self._compare_with_limit(window.features)
        if features is None:
            return
        self.friction, self.trusted = features, window.trust == TRUSTED
        if self.trusted or window.comparable:
            self._take(features, window)

    def _compare_with_limit(self, window: Backlash) -> None:
        """Compare the backlash of a `window` with gap_limit; what is not sure stays as it was."""
        size, std = (window.gap, window.gap_std) if window.separable else (
            window.lost_motion, window.lost_motion_std)
        off = size - (self.settings.gap_limit or math.inf)
        if not abs(off) < LIMITS.over_std * std:
            self.over_limit = bool(off > 0.0)

    def serve(self, stamp_ns: int, note: str) -> None:
        """Note a service at `stamp_ns`: the windows after it measure a new baseline."""
        self.marks.append((stamp_ns, f'serviced, {note}' if note else 'serviced'))
        if not self.data.stamps:
            return
        self.service_ns = max(stamp_ns, self.data.stamps[-1])
        self.alerts = {}
        for column in range(len(FEATURES)):
            self._add_step(column, self.service_ns)

    def _begin_baseline(self) -> None:
        """Begin a new baseline after a service, or once a smaller backlash has lasted a day."""
        since = np.array(self.data.stamps, np.int64) > self.service_ns
        if self.service_ns:
            if since.sum() >= LIMITS.min_baseline:
                self.service_ns = 0
                self.accept()
        elif self.alerts and self.alerts.keys() <= LOSSES and self.stamp_ns - max(
                alert.since_ns for alert in self.alerts.values()) > 1e9 * LIMITS.lasting:
            key, alert = max(self.alerts.items(), key=lambda item: item[1].growth)
            noun = 'backlash' if key == 'gap_loss' else 'lost motion'
            self.accept()
            self.marks.append((alert.since_ns, f'{noun} {100 * alert.growth:.1f} % smaller than '
                               'before, a new baseline'))

    def _move(self, by_ns: int) -> None:
        """Move all that was before by a time."""
        self.data.move(by_ns)
        for feature in self.wear:
            feature.steps, feature.pending = (
                [stamp + by_ns for stamp in stamps] for stamps in (feature.steps, feature.pending))
            feature.compared_ns += by_ns if feature.compared_ns else 0
        self.alerts = {key: replace(alert, since_ns=alert.since_ns + by_ns,
                                    found_ns=alert.found_ns + by_ns)
                       for key, alert in self.alerts.items()}

    def _take(self, features: Backlash | Friction, window: Window) -> None:
        data, settings, trust = self.data, self.settings, window.trust
        count = len(data.points)
        point = find_point(data.points, features, window.temperature, settings.bins)
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
        data.add(self.stamp_ns, point, trust, data.warmth(window.temperature),
                 data.relative(values))
        marks = self._marks()
        data.couple(marks)
        data.absorb(marks, settings.baseline_windows)
        self._judge()
        self._begin_baseline()

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
            gap = (w.gap, w.gap_std) if w.separable else nan
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
            estimate, scanned = results[column]
            # A window that contradicts those before is judged with the next one, not learnt.
            strays = not self.wear[_own(column)].steps and \
                abs(scanned.newest) > LIMITS.contradicted
            self._learn(column, estimate.fit, points, place, not strays)
            if column < len(FEATURES):
                self.wear[column].newest = self.relative(
                    column, float(scanned.size[-1]), 0.0)[0] if strays else 0.0
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
            if self.settings.follows_curve and column not in (GAP, LOST_MOTION) and any(
                    self.wear[c].steps for c in (GAP, LOST_MOTION)):
                # The torque follows a curve with the backlash of before: all else seems to change.
                told = True
                for test in tests_of(column):
                    self.alerts.pop(test.key, None)
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

    def _learn(self, column: int, fit: wear.Fit, points: list[int], place: int, level: bool
               ) -> None:
        """
        Keep what a fit says of temperature, spread of offsets and the healthy level.

        Args:
            column: of the feature.
            fit: the most probable course.
            points: that take part.
            place: of the newest point among them.
            level: whether the healthy level is kept, too.

        """
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
        if column < len(FEATURES) and level:
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
                self.alerts.pop(test.key, None)
            return
        standing = next((t for t in (up, down) if t.key in self.alerts), None)
        test, opposite = (up, down) if feature.value > 0.0 else (down, up)
        if standing is opposite and abs(feature.value) < LIMITS.over_std * feature.std:
            test, opposite = opposite, test  # nothing yet says that it goes the other way
        growth, std = self.relative(column, feature.value, feature.std)
        old = self.alerts.get(test.key) or self.alerts.get(opposite.key)
        if self._over(column, old):
            ended = up if up.key in self.alerts else down
            if ended.key in self.alerts:
                text = (f'over: {ended.words.replace(" has ", " had ")} '
                        f'{100 * self.alerts[ended.key].found:.1f} %')
                self.ended[ended.component] = '; '.join(filter(None, (
                    self.ended.get(ended.component), text)))
            self._end(column)
            return
        # Nothing is stated below its deviation.
        if old is None and (told or self.service_ns or abs(growth) < std):
            return
        self.alerts.pop(opposite.key, None)
        size = test.sign * growth
        alert = self.alerts.get(test.key) or Alert(
            feature.steps[-1 if old else 0], self.stamp_ns, size, size, std)
        since_ns = alert.since_ns if alert.since_ns in feature.steps else feature.steps[0]
        _, warn, error = self._limits(test)
        stage = FOUND
        for at, limit in ((WARNED, warn), (GROSS, error)):
            if size >= (limit if alert.stage < at else LIMITS.release * limit):
                stage = at
        # Not from one window alone, and not twice for one that wavers.
        feature.lower = feature.lower + 1 if stage < alert.stage else 0
        if stage > alert.stage or feature.lower >= LIMITS.over_windows:
            feature.lower = 0
        else:
            stage = alert.stage
        self.alerts[test.key] = replace(
            alert, since_ns=since_ns, growth=size, std=std, stage=stage)

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

    def _over(self, column: int, change: Alert | None) -> bool:
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
                self.alerts.pop(test.key, None)

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

    def _limits(self, test: ChangeTest) -> tuple[float, float, float]:
        """Return the sizes from which on a change is noticed, a warning, an error by `test`."""
        return self.settings.limits_of(test, self._baseline(GAP)[0])

    def growth(self, column: int) -> tuple[float, float]:
        """Return (growth, deviation) of the feature in `column` now, NaN while it is not known."""
        feature = self.wear[column]
        if not (math.isfinite(feature.value) and feature.compared_ns):
            return math.nan, math.nan
        growth, std = self.relative(column, feature.value, feature.std)
        # What has happened since it was measured is not known.
        idle = max(self.stamp_ns - feature.compared_ns, 0) / HOUR
        return growth, math.hypot(std, self.settings.notice(column) * math.sqrt(idle))

    def coefficients(self) -> tuple[tuple[float, float], ...]:
        """
        Return (growth, deviation) of viscous and of Coulomb friction, () while not known.

        By the wear of the friction and of its viscous share at the newest operating point.
        """
        (growth, growth_std), (shift, shift_std) = (
            self.growth(column) for column in (FRICTION, VISCOUS_SHARE))
        if self.point < 0 or not math.isfinite(growth + shift):
            return ()
        viscous = float(self._healthy_share(self.data.points[self.point].speed)
                        + self.data.reference[VISCOUS_SHARE] + self._levels[VISCOUS_SHARE])
        if not 0.0 < viscous < 1.0:
            return ()
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
                      if t.key in self.alerts}
        self.alerts, self._counted = {}, ((0, -1), 0)
        self.scores = dict.fromkeys(self.scores, 0.0)
        self._judge()
        return used

    # ------------------------------------------------------------------ state

    def health(self) -> Health:
        """Return what is known now."""
        data = self.data
        first = data.blocks[0].begin_ns if data.blocks else data.stamps[0] if data.stamps else 0
        return Health(
            self.settings, self.stamp_ns, tuple(map(self._feature, range(len(FEATURES)))),
            dict(self.alerts), dict(self.ended), self.window, self.backlash, self.friction,
            self.compared, self.over_limit,
            data.points[self.point].text() if self.point >= 0 else '',
            self.point_windows(), dict(self.scores), self.coefficients(), first,
            tuple(self.marks), statistics=self.to_dict())

    def _feature(self, column: int) -> FeatureHealth:
        """Return what is known about the feature in `column`."""
        feature, trend, name = self.wear[column], self.trend(column), FEATURES[column]
        level = getattr(self.backlash, name, math.nan), getattr(
            self.backlash, f'{name}_std', math.nan)
        reach = trend.reach(self._limits(tests_of(column)[0])[2]) if trend else None
        return FeatureHealth(
            *level, *self._baseline(column), *self.growth(column), feature.compared_ns,
            trend.slope if trend else 0.0, trend.slope_std if trend else 0.0, reach,
            self.steady(column), bool(feature.pending), feature.newest)

    def _baseline(self, column: int) -> tuple[float, float]:
        """Return (healthy value, deviation) at the newest operating point, NaN if unknown."""
        if self.point < 0 or not math.isfinite(self._levels[column]) \
                or self.point_windows() < LIMITS.min_baseline:
            return math.nan, math.nan
        return self._natural(column, self._levels[column], self._level_stds[column],
                             self.data.points[self.point].unit(column))

    def to_dict(self) -> dict[str, Any]:
        """Return all that the next outcomes depend on, as plain data; floats read back exactly."""
        return {
            'wear': [asdict(feature) for feature in self.wear], **self.data.to_dict(),
            'scores': self.scores,
            'alerts': {key: asdict(alert) for key, alert in self.alerts.items()},
            'levels': [float(v) for v in self._levels],
            'level_stds': [float(v) for v in self._level_stds], 'ended': self.ended,
            'window': self.window and self.window.to_dict(),
            'backlash': asdict(self.backlash) if self.backlash is not None and (
                self.window is None or self.backlash is not self.window.features) else None,
            'point': self.point,
            'friction': asdict(self.friction) if isinstance(self.friction, Friction) else None,
            'trusted': self.trusted, 'compared': self.compared, 'over_limit': self.over_limit,
            'stamp_ns': self.stamp_ns, 'service_ns': self.service_ns, 'marks': self.marks[:]}

    def _load(self, state: Values) -> None:
        self.data.load(state)
        if len(state['wear']) != len(FEATURES):
            raise ValueError(f'{len(state["wear"])} features, expected {len(FEATURES)}')
        self.wear = [FeatureWear(**{**row, 'steps': list(row['steps']),
                                    'pending': list(row['pending'])}) for row in state['wear']]
        self.scores.update({test.key: float(state['scores'].get(test.key, 0.0))
                            for test in TESTS})
        self.alerts = {key: Alert(**value) for key, value in state['alerts'].items()
                       if key in self.scores}
        self._levels, self._level_stds = (
            np.array(state[name], float) for name in ('levels', 'level_stds'))
        self.ended = dict(state['ended'])
        self.window = state['window'] and Window.from_dict(state['window'])
        newest = self.window and self.window.features
        self.backlash = newest if isinstance(newest, Backlash) else \
            state['backlash'] and Backlash(**state['backlash'])
        friction = state['friction']
        self.friction = Friction(**friction) if friction else self.backlash
        self.point, self.trusted = int(state['point']), bool(state['trusted'])
        self.compared, self.over_limit = bool(state['compared']), bool(state['over_limit'])
        if self.point >= len(self.data.points):
            raise ValueError('an unknown operating point')
        self.stamp_ns, self.service_ns = int(state['stamp_ns']), int(state['service_ns'])
        self.marks = [(int(stamp), str(words)) for stamp, words in state['marks']]


def _own(column: int) -> int:
    """Return the feature that a `column` tells: SHARP tells the gap."""
    return GAP if column == SHARP else column
