# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Follow the wear of a gearbox window by window: what has changed for good.

A Tracker is a value: `update` returns the next one. It keeps the windows (wear_data.History) and,
of each feature, the steps of the likeliest explanation; each window weighs all explanations with
one step more (wear.evidence), moves the newest steps to where they fit best, and says how large
the wear is, since when, and when a limit will be reached.
"""
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from typing import NamedTuple, Self

import numpy as np
import scipy

from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.backlash import wear
from gearbox_monitor.health.backlash.change_tests import (
    ChangeTest, FEATURES, FRICTION, GAP, LOST_MOTION, PRIORS, TESTS, tests_of, VISCOUS_SHARE, WEAR,
    WEAR_FEATURES)
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.backlash.wear import Columns, excess, FIRST, Fit, History, SECOND_ONE
from gearbox_monitor.health.health_record import (
    Alert, FeatureHealth, find_point, FOUND, GROSS, HealthSettings, OperatingPoint, TRUSTED,
    WARNED, Window)
from gearbox_monitor.kernels.types import Array, Flags

RECENT = 12         # windows whose mean is shown while there is no change
MAX_STEPS, MAX_OPEN = 6, 8
HOUR, DAY = 3600e9, 86400e9  # ns
LOSSES = {'gap_loss', 'lost_motion_loss'}  # tests of a backlash that became smaller


class Step(NamedTuple):
    """A step of the wear after the window at `stamp_ns`; std: prior deviation of its logarithm."""

    stamp_ns: int
    kind: str = 'found'
    std: float = WEAR.step_std


OPEN, ACCEPTED = 'open', 'accepted'  # may have come with a new motion; before a saved baseline


@dataclass(frozen=True)
class FeatureWear:
    """
    The wear of a feature as it is known.

    steps: in order of time. value, std: logarithm of the wear, or of the newest windows while
    there is no change; compared_ns: newest window that shows it. slope, slope_std: per window;
    moving: probability of a slope. course: the most probable of WearLimits.courses. newest: see
    FeatureHealth.
    """

    steps: tuple[Step, ...] = ()
    value: float = math.nan
    std: float = math.nan
    compared_ns: int = 0
    slope: float = 0.0
    slope_std: float = 0.0
    moving: float = 0.0
    course: int = 0
    newest: float = 0.0

    @property
    def found(self) -> list[int]:
        """Stamps (ns) of the steps that were found."""
        return [s.stamp_ns for s in self.steps if s.kind == 'found']

    @property
    def pending(self) -> list[int]:
        """Stamps (ns) of motions with which a step may have come."""
        return [s.stamp_ns for s in self.steps if s.kind == OPEN]

    def with_step(self, step: Step) -> Self:
        """Return it with one `step` more, in place of one that may have come then."""
        steps = [s for s in self.steps if s.stamp_ns != step.stamp_ns or s.kind == ACCEPTED]
        return replace(self, steps=tuple(sorted([*steps, step])))

    def without(self, *steps: Step) -> Self:
        """Return it without `steps`."""
        return replace(self, steps=tuple(s for s in self.steps if s not in steps))


@dataclass(frozen=True, eq=False)
class Tracker:
    """
    The wear of one gearbox, its alerts and all that they rest on; `update` takes a window.

    alerts: by test. ended: by component, (test, its size) of what was over with the newest window,
    ('', 0) of a baseline that was saved. scores: by test, logarithm (base 10) of the odds of a
    change. backlash, friction: of the newest windows that
    show them; point: where, -1: none; trusted, compared: whether it is. over_limit: see Health.
    marks: (stamp, words), where another baseline began. levels, level_stds: healthy, of the
    features at the newest point.
    """

    settings: HealthSettings
    data: History = field(default_factory=History)
    wear: tuple[FeatureWear, ...] = (FeatureWear(),) * len(FEATURES)
    scores: Mapping[str, float] = field(default_factory=lambda: {t.key: 0.0 for t in TESTS})
    alerts: Mapping[str, Alert] = field(default_factory=dict)
    ended: Mapping[str, tuple[tuple[str, float], ...]] = field(default_factory=dict)
    window: Window | None = None
    backlash: Backlash | None = None
    friction: Backlash | None = None
    point: int = -1
    trusted: bool = False
    compared: bool = False
    over_limit: bool = False
    stamp_ns: int = 0
    marks: tuple[tuple[int, str], ...] = ()
    levels: tuple[float, ...] = (math.nan,) * len(FEATURES)
    level_stds: tuple[float, ...] = (math.nan,) * len(FEATURES)

    # ------------------------------------------------------------------ windows

    def update(self, window: Window) -> Self:
        """Return the Tracker after a `window`."""
        if window.stamp_ns == self.stamp_ns:
            return self  # it has been taken before
        tracker = self
        if window.stamp_ns < self.stamp_ns:
            # The clock was set back, or is another one: what was before keeps its order.
            tracker = self._moved(
                window.stamp_ns - self.stamp_ns - round(self.settings.window * 1e9))
        tracker = replace(
            tracker, stamp_ns=window.stamp_ns, window=window, ended={}, compared=False)
        if isinstance(window.features, Backlash):
            tracker = replace(tracker, backlash=window.features,
                              over_limit=self._exceeds(window.features))
        features = window.friction
        if features is None:
            return tracker
        tracker = replace(tracker, friction=features, trusted=window.trust == TRUSTED)
        if not (tracker.trusted or window.comparable):
            return tracker
        return tracker._taken(features, window)._with_smaller_baseline()

    def _exceeds(self, window: Backlash) -> bool:
        """Return whether a `window` exceeds gap_limit; what is not sure stays as it was."""
        size, std = (window.gap, window.gap_std) if window.separable else (
            window.lost_motion, window.lost_motion_std)
        off = size - (self.settings.gap_limit or math.inf)
        return self.over_limit if abs(off) < LIMITS.open_std * std else bool(off > 0.0)

    def _with_smaller_baseline(self) -> Self:
        """Return it with a smaller backlash as the baseline, once it has lasted a day."""
        if not (self.alerts and self.alerts.keys() <= LOSSES and all(
                self.stamp_ns - alert.since_ns > DAY for alert in self.alerts.values())):
            return self
        key, alert = max(self.alerts.items(), key=lambda item: item[1].growth)
        noun = 'backlash' if key == 'gap_loss' else 'lost motion'
        return replace(self.accepted(), marks=(*self.marks, (
            alert.since_ns, f'{noun} {100 * alert.growth:.1f} % smaller than before, a new '
            'baseline')))

    def _moved(self, by_ns: int) -> Self:
        """Return it with all that was before moved by a time."""
        return replace(self, data=self.data.moved(by_ns), wear=tuple(replace(
            f, compared_ns=f.compared_ns + (by_ns if f.compared_ns else 0), steps=tuple(
                step._replace(stamp_ns=step.stamp_ns + by_ns) for step in f.steps))
            for f in self.wear), alerts={
                key: replace(alert, since_ns=alert.since_ns + by_ns,
                             found_ns=alert.found_ns + by_ns)
                for key, alert in self.alerts.items()})

    def _taken(self, features: Backlash, window: Window) -> Self:
        data, trust = self.data, window.trust
        points, point = find_point(data.points, features, window.temperature, self.settings.bins)
        values, variances = self._measure(features, points[point])
        place, usual = points[point], variances / excess(trust)
        fits, most = self._fits(variances, usual, place), math.nan
        if trust == TRUSTED:  # what is usual has to be learnt first, and may become so later
            fits |= (place.stated_count < WEAR.min_baseline)
            most = np.minimum(usual, WEAR.stated_ratio ** 2 * place.stated)
        values = np.where(fits, values, math.nan)
        is_new, measured = len(points) > len(data.points), np.isfinite(values)
        place = place.with_stated(np.where(fits, usual, most))
        tracker = replace(self, point=point, compared=bool(measured.any()), data=replace(
            data, points=(*points[:point], place, *points[point + 1:])))
        if not tracker.compared:
            return tracker
        if is_new and data.windows >= WEAR.settled_windows:
            step = Step(int(data.stamps[-1]), OPEN, WEAR.open_std)
            tracker = replace(tracker, wear=tuple(
                _opened(feature, step) if measured[f] else feature
                for f, feature in enumerate(self.wear)))
        return replace(tracker, data=tracker.data.with_window(
            self.stamp_ns, point, trust, window.temperature, values))._judged()

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
        warn = np.array([self.settings.limits.get(feature.up, (0.0, 0.0))[1]
                         for feature in WEAR_FEATURES])
        with np.errstate(invalid='ignore'):
            result: Flags = (usual <= WEAR.stated_ratio ** 2 * place.stated) \
                | (variances <= (WEAR.precise * warn) ** 2)
        return result & (self.data.windows >= WEAR.min_baseline)

    def _measure(self, window: Backlash, place: OperatingPoint
                 ) -> tuple[Array, Array]:
        """Return (values [F], variances [F]) of a window's features, as History takes them."""
        values, std = np.full(len(FEATURES), np.nan), np.full(len(FEATURES), np.nan)
        for column, feature in enumerate(WEAR_FEATURES):
            value, deviation = feature.measure(window, self.settings.friction)
            if not (math.isfinite(value) and math.isfinite(deviation)):
                continue
            if not feature.prior.logarithmic:
                unit = place.unit(column)
                values[column], std[column] = value / unit, deviation / unit
                continue
            reference = self.data.reference[column]
            lowest = math.exp(reference - WEAR.value_floor) if math.isfinite(reference) else 1e-12
            value = max(value, lowest)
            values[column], std[column] = math.log(value), deviation / value
        return values, std ** 2

    # ------------------------------------------------------------------ inference

    def _judged(self) -> Self:
        """Return it with the steps that explain all windows best, and what follows from them."""
        began = [f.found[0] for f in self.wear if f.found]
        marks = sorted({s.stamp_ns for f in self.wear for s in f.steps})
        data = self.data.merged(marks, min(began, default=self.stamp_ns),
                                self.settings.baseline_windows)
        features = list(self.wear)
        for f, feature in enumerate(features):  # what was between the oldest two is history
            if len(feature.found) > MAX_STEPS:
                data = data.without(f, *feature.found[:2])
                features[f] = feature.without(next(
                    s for s in feature.steps if s.kind == 'found'))
        tracker = replace(self, data=data, wear=tuple(features))
        search = _Search(tracker)
        search.move()
        search.settle()
        search.look()
        search.estimate()
        tracker = replace(tracker, wear=tuple(search.wear), scores=search.scores)
        tracker = tracker._learnt(search)
        for column in range(len(FEATURES)):
            tracker = tracker._followed(column, search)
        return tracker

    def _learnt(self, search: '_Search') -> Self:
        """Keep what the fit says of temperature, spread of offsets and the healthy level."""
        fit, o = search.fit, search.base.observations
        data, point = self.data, int(self.data.where[-1])
        place = o.points.index(point)
        mean, variance = fit.without_wear()
        slopes, spread = data.slopes.copy(), data.spread.copy()
        levels, stds = list(self.levels), list(self.level_stds)
        temperature = self.window.temperature if self.window else None
        kelvin, offsets = data.warmth(temperature), slice(
            wear.N_COMMON, wear.N_COMMON + len(o.points))
        accepted = search.accepted(fit)
        for f, prior in enumerate(PRIORS):
            if not o.counts[:, f].any():
                continue
            share = data.shares([point], f, self.settings.friction)[0]
            slopes[f] = mean[f, wear.TEMPERATURES] @ share
            if len(o.points) > 1 and all(s.kind == ACCEPTED for s in self.wear[f].steps):
                squares = mean[f, offsets] ** 2 + variance[f, offsets]
                spread[f] = (WEAR.offset_windows * prior.offset ** 2 + float(squares.sum())) / (
                    WEAR.offset_windows + len(o.points))
            at = np.zeros_like(mean)
            at[f, [wear.LEVEL, wear.N_COMMON + place]] = 1.0
            at[f, wear.TEMPERATURES] = kelvin * share
            if not self.wear[f].newest:  # it is judged with the next one, not learnt
                levels[f], stds[f] = fit.combined(
                    at.ravel(), accepted * (fit.columns.feature == f))
        return replace(self, levels=tuple(levels), level_stds=tuple(stds),
                       data=replace(data, slopes=slopes, spread=spread))

    def _followed(self, column: int, search: '_Search') -> Self:
        """Return it with the change of a feature as it is now: new, its stage, or over."""
        feature = self.wear[column]
        up, down = tests_of(column)
        standing = next((t for t in (up, down) if t.key in self.alerts), None)
        alerts = {key: value for key, value in self.alerts.items()
                  if key not in (up.key, down.key)}
        # The torque follows a curve with the backlash of before: all else seems to change.
        follows = self.settings.follows_curve and column not in (GAP, LOST_MOTION) and any(
            self.wear[c].found for c in (GAP, LOST_MOTION))
        if not feature.found or follows:
            return replace(self, alerts=alerts)
        old = self.alerts.get(standing.key) if standing else None
        if old and (self._over(column, old, feature.value, feature.std)
                    or self._over(column, old, *search.steady[column])):
            assert standing
            ended = (*self.ended.get(standing.component, ()), (standing.key, old.found))
            return replace(self._cleared(column), alerts=alerts,
                           ended={**self.ended, standing.component: ended})
        growth, std = self.relative(column, feature.value, feature.std)
        test = up if growth > 0.0 else down
        if standing and standing is not test and abs(growth) < 2.0 * std:
            test = standing  # nothing yet says that it goes the other way
        # Nothing is stated below its deviation.
        if old is None and (abs(growth) < std or not search.reportable(column)):
            return self
        growth *= test.sign
        change = old or Alert(feature.found[0], self.stamp_ns, growth, growth, std)
        since = change.since_ns if change.since_ns in feature.found else feature.found[0]
        if standing and standing is not test:
            since = feature.found[-1]
            change = replace(change, found_ns=self.stamp_ns, found=growth, stage=FOUND)
        stage = FOUND
        for at, limit in zip((WARNED, GROSS), self.limits(test)[1:]):
            needed = 0.5 if change.stage < at else 1.0 - WEAR.sure
            if scipy.special.ndtr((growth - limit) / max(std, 1e-12)) >= needed:
                stage = at
        return replace(self, alerts={**alerts, test.key: replace(
            change, since_ns=since, growth=growth, std=std, stage=stage)})

    def _over(self, column: int, change: Alert, value: float, std: float) -> bool:
        """
        Return whether a change has gone: as good as nothing is left, or nothing is far likelier.

        Args:
            column: of the feature.
            change: as it was found.
            value: of the wear now, logarithm.
            std: its deviation.

        """
        half, std = 0.5 * self.settings.notice(column), max(std, 1e-9)
        negligible = np.diff(scipy.special.ndtr((np.array([-half, half]) - value) / std))[0]
        nothing = math.log(max(abs(change.found), std) / std) - 0.5 * (value / std) ** 2
        return bool(negligible >= WEAR.sure or nothing >= math.log(WEAR.sure / (1.0 - WEAR.sure)))

    def _cleared(self, column: int) -> Self:
        """Return it without the steps of a feature, and the windows in which it had changed."""
        feature = self.wear[column]
        # A change that ends with a new motion ends at the step of that motion.
        end = max(feature.found[-1] if len(feature.found) > 1 else self.data.recent_ns(RECENT),
                  *(s.stamp_ns for s in feature.steps if s.kind == OPEN), 0)
        cleared = replace(feature, steps=tuple(s for s in feature.steps if s.kind == ACCEPTED))
        return replace(self, data=self.data.without(column, feature.found[0], end), wear=(
            *self.wear[:column], cleared, *self.wear[column + 1:]))

    # ------------------------------------------------------------------ what is known

    def relative(self, column: int, value: float, std: float) -> tuple[float, float]:
        """Return (growth, deviation) of `value` +- `std` in `column`: of logarithms, relative."""
        prior = PRIORS[column]
        growth = math.expm1(value) if prior.logarithmic else value
        slope = 1.0 + growth if prior.logarithmic else 1.0
        return growth, math.hypot(slope * std, prior.scale * growth, self.missed(column))

    def missed(self, column: int) -> float:
        """Return what changes of other features may seem to be one of `column`."""
        return PRIORS[column].crosstalk * max((
            abs(w.value) for c, w in enumerate(self.wear) if c != column and w.found), default=0.0)

    def limits(self, test: ChangeTest) -> tuple[float, float, float]:
        """Return the sizes from which on a change is noticed, a warning, an error by `test`."""
        notice, warn, error = self.settings.limits.get(test.key, (0.0, math.inf, math.inf))
        healthy = self._baseline(GAP)[0]
        if test.key == 'gap' and self.settings.gap_limit > 0.0 and healthy > 0.0:
            error = min(error, self.settings.gap_limit / healthy - 1.0)
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

    @property
    def coefficients(self) -> tuple[tuple[float, float], ...]:
        """
        (growth, deviation) of viscous and of Coulomb friction, () while not known.

        By the wear of the friction and of its viscous share at the newest operating point.
        """
        (growth, growth_std), (shift, shift_std) = (
            self.growth(column) for column in (FRICTION, VISCOUS_SHARE))
        if not math.isfinite(growth + shift):
            return ()
        viscous = float(self.settings.friction.share(self.data.points[self.point].speed)
                        + self.data.reference[VISCOUS_SHARE] + self.levels[VISCOUS_SHARE])
        if not 0.0 < viscous < 1.0:
            return ()
        rows = [((1.0 + growth) * (share + change) / share - 1.0,
                 math.hypot((share + change) * growth_std, (1.0 + growth) * shift_std) / share)
                for share, change in ((viscous, shift), (1.0 - viscous, -shift))]
        return rows[0], rows[1]

    @cached_property
    def point_windows(self) -> int:
        """Number of windows at the operating point of the newest one."""
        return self.data.count(self.point)

    # ------------------------------------------------------------------ healthy by decision

    def accepted(self, served_ns: int = 0) -> Self:
        """
        Return it with its steps as what is healthy by decision: they are not known any better.

        The wear becomes 0, at all operating points. Ends all alerts.
        served_ns: when every feature may have changed, 0: none but those that have.
        """
        data, features = self.data, []
        since = max((f.found[-1] for f in self.wear if f.found), default=0)
        largest = max((abs(f.value) for f in self.wear if f.found), default=0.0)
        for column, feature in enumerate(self.wear):
            steps = [s for s in feature.steps if s.kind == ACCEPTED]
            begin = served_ns
            if feature.found:
                if not served_ns:
                    begin = feature.found[-1] if feature.moving < WEAR.sure else max(
                        feature.found[-1], data.recent_ns(RECENT))
                data = data.without(column, feature.found[0], begin)
            if feature.found or served_ns:
                steps.append(Step(begin, ACCEPTED))
            elif largest:  # what others seem to have changed by stays, too
                steps.append(Step(since, ACCEPTED, PRIORS[column].crosstalk * largest))
            features.append(replace(feature, steps=tuple(steps[-MAX_STEPS:])))
        ended = {t.component: (('', 0.0),) for t in TESTS if t.key in self.alerts}
        tracker = replace(self, data=data, wear=tuple(features), alerts={}, ended=ended)
        return tracker._judged() if len(data.stamps) else tracker

    # ------------------------------------------------------------------ what is shown

    def feature_health(self, column: int) -> FeatureHealth:
        """Return what is known about the feature in `column`."""
        feature, name, limit = self.wear[column], FEATURES[column], tests_of(column)[0]
        level = getattr(self.backlash, name, math.nan), getattr(
            self.backlash, f'{name}_std', math.nan)
        growth, std = self.growth(column)
        moves, rate, rate_std, reach = bool(feature.found), 0.0, 0.0, None
        if moves and feature.moving >= WEAR.sure:
            if abs(feature.slope) >= LIMITS.deviations * feature.slope_std:
                unit = (1.0 + growth if PRIORS[column].logarithmic else 1.0) / self.settings.window
                rate, rate_std = feature.slope * unit, feature.slope_std * unit
                reach = wear.reach(growth, std, rate, rate_std, self.limits(limit)[2])
        elif moves:  # by less than is reported since its last step?
            windows = (self.stamp_ns - feature.found[-1]) * 1e-9 / self.settings.window
            fastest = abs(feature.slope) + 2.0 * feature.slope_std
            moves = fastest * windows >= self.settings.notice(column)
        return FeatureHealth(
            *level, *self._baseline(column), growth, std, feature.compared_ns, rate, rate_std,
            reach, bool(feature.found) and not moves, bool(feature.pending), feature.newest)

    def _baseline(self, column: int) -> tuple[float, float]:
        """Return (healthy value, deviation) at the newest operating point, NaN if unknown."""
        if self.point_windows < WEAR.min_baseline:
            return math.nan, math.nan
        value = float(self.data.reference[column] + self.levels[column])
        unit = self.data.points[self.point].unit(column)
        value = math.exp(value) if PRIORS[column].logarithmic else value * unit
        return value, self.level_stds[column] * (value if PRIORS[column].logarithmic else unit)


def _opened(feature: FeatureWear, step: Step) -> FeatureWear:
    """Return a feature with a step that may have come with a new motion."""
    opened = feature.with_step(step)
    # A change that came with one that is dropped shows at its neighbours.
    surplus = [s for s in opened.steps if s.kind == OPEN][1:][:-(MAX_OPEN - 1)]
    return opened.without(*surplus)


class _Search:
    """The steps that explain the windows of a Tracker, while they are searched."""

    def __init__(self, tracker: Tracker) -> None:
        self.tracker, data = tracker, tracker.data
        self.wear = list(tracker.wear)
        self.scores = dict(tracker.scores)
        self.steady: dict[int, Array] = {}  # (value, deviation) were there no slope and no walk
        self.length = tracker.settings.window * 1e9
        growth = np.ones((len(data.stamps), len(FEATURES)))
        for f, feature in enumerate(self.wear):
            # The noise of a feature does not shrink with it.
            if feature.found and PRIORS[f].logarithmic and feature.value < 0.0:
                growth[data.stamps > feature.found[0], f] = math.exp(-feature.value)
        self.base = wear.Posterior(data.observations(growth, tracker.settings.friction))
        o = self.base.observations
        self.rows = o.stamps[len(o.stamps) - o.rows:]
        self.age = np.append((tracker.stamp_ns - o.stamps) / self.length, 0.0)  # windows
        point = int(data.where[-1])  # a newer window that was not compared has no row
        self.dof = data.dof(point)
        self.noise = np.sqrt(data.points[point].variance())
        # Of a window whose other features are known.
        precise = np.diag(o.weight[-1])
        self.sharp = np.where(precise > 0.0, np.maximum(precise, 1e-300) ** -0.5, self.noise)
        self.fit = self._fit()

    def _fit(self, course: dict[int, int] | None = None, closed: bool = False) -> Fit:
        """
        Return the Fit of all steps.

        Args:
            course: of features; else the known one, but for a walk: that would hide steps.
            closed: whether those that may have come with a new motion did not.

        """
        parts = []
        for f, feature in enumerate(self.wear):
            if feature.steps:
                slope, walk = WEAR.courses[(course or {}).get(f, feature.course)]
                steps = [(float((self.tracker.stamp_ns - s.stamp_ns) / self.length),
                          1e-6 if closed and s.kind == OPEN else s.std, s.kind == 'found')
                         for s in feature.steps]
                parts.append((f, *wear.wear_columns(
                    self.age, steps, slope, walk * float(self.sharp[f]) * bool(course))))
        return self.base.fit(Columns.of(parts, self.age))

    def _steps(self, fit: Fit) -> Iterator[tuple[int, Step, int]]:
        """Yield (feature, step, its column of a `fit`) of all steps."""
        for f, feature in enumerate(self.wear):
            begin = int(np.searchsorted(fit.columns.feature, f))
            for k, step in enumerate(feature.steps):
                yield f, step, begin + k

    def accepted(self, fit: Fit) -> Flags:
        """Return which columns [T] of a `fit` belong to steps before a saved baseline."""
        flags = np.zeros(len(fit.mean), bool)
        flags[[column for _, step, column in self._steps(fit) if step.kind == ACCEPTED]] = True
        return flags

    def _odds(self) -> Array:
        """Return the logarithmic odds [R, H] of one more step, the chance of one included."""
        scanned = closed = self.fit.scan
        if any(feature.pending for feature in self.wear):
            closed = self._fit(closed=True).scan
        odds = wear.limited_evidence(self.base, scanned, closed, self.dof)
        o = self.base.observations
        windows = (np.cumsum(o.counts, axis=0) - o.counts)[len(o.y) - o.rows:]
        comparable = windows >= WEAR.min_baseline
        odds = np.where(comparable[:, FIRST] & comparable[:, SECOND_ONE], odds, -math.inf)
        chance = 10.0 ** -self.tracker.settings.threshold
        # The window before that of a row is where a step has its stamp.
        earlier = np.append(self.rows[0] - 1, self.rows[:-1])
        marked = np.isin(earlier, [stamp for f in self.wear for stamp in f.found])
        changed = np.array([bool(feature.found) for feature in self.wear])
        both_changed = changed[FIRST] & changed[SECOND_ONE]
        result: Array = odds + np.log(np.where(
            marked[:, None] | both_changed, max(chance, WEAR.together), chance))
        return result

    def _stamp(self, row: int) -> int:
        return int(self.rows[row - 1]) if row else int(self.rows[0]) - 1

    def move(self) -> None:
        """Search the places of the newest steps again, now that more windows show them."""
        for f, feature in enumerate(self.wear):
            if not feature.found or feature.found[-1] < self.rows[0]:
                continue
            step, before = next(s for s in feature.steps[::-1] if s.kind == 'found'), self.fit
            self.wear[f] = feature.without(step)
            self.fit = self._fit()
            odds = self._odds()
            row = int(odds[:, f].argmax())
            if np.isfinite(odds[row, f]):
                step = Step(self._stamp(row))
            self.wear[f] = self.wear[f].with_step(step)
            self.fit = self._fit()
            if feature.course and self.fit.likelihood < before.likelihood:
                self.wear[f], self.fit = feature, before  # a slope began earlier

    def settle(self) -> None:
        """Settle what may have come with a new motion; forget what nothing speaks for any more."""
        settings = self.tracker.settings
        steps = list(self._steps(self.fit))
        for f, step, k in steps:
            mean, variance = float(self.fit.mean[k]), float(self.fit.covariance[k, k])
            deviation, prior, begin_ns = math.sqrt(variance), step.std ** 2, step.stamp_ns
            size = mean
            if step.kind == OPEN:
                # A change may be spread over motions that came together: all of it counts once,
                # for the motion that explains most of it.
                open_steps = [(s, c) for g, s, c in steps if g == f and s.kind == OPEN]
                columns = [c for _, c in open_steps]
                if k == max(columns, key=lambda c: abs(self.fit.mean[c])):
                    mean = float(self.fit.mean[columns].sum())
                    variance = float(self.fit.covariance[np.ix_(columns, columns)].sum())
                    prior = sum(s.std ** 2 for s, _ in open_steps)
                    begin_ns = open_steps[0][0].stamp_ns
            newer = int((self.base.observations.counts[-len(self.rows):, f][
                self.rows > begin_ns]).sum())
            # Only the noise is known by so many windows, not what priors add (Satterthwaite).
            share = min(float(self.noise[f]) ** 2 / max(newer, 1) / variance, 1.0)
            odds = wear.step_odds(mean, variance, prior,
                                  float(self.dof[f]) / max(share, 1e-3) ** 2)
            notice = settings.notice(f)
            if step.kind == OPEN:
                chance = PRIORS[f].share * 10.0 ** -settings.threshold
                if odds + math.log(chance) >= 0.0 and newer > 1:
                    self.wear[f] = self.wear[f].with_step(Step(step.stamp_ns))
                elif deviation <= 0.5 * notice and abs(size) < notice:
                    self.wear[f] = self.wear[f].without(step)
            elif step.kind == 'found' and step.stamp_ns >= self.rows[0] and odds < 0.0 \
                    and self.wear[f].course == 0:
                self.wear[f] = self.wear[f].without(step)
        self.fit = self._fit()

    def look(self) -> None:
        """Add the steps that the newest windows make likelier than none and all others."""
        new: set[int] = set()
        for turn in range(len(FEATURES)):
            odds = self._odds()
            odds[:, np.isin(FIRST, list(new)) | np.isin(SECOND_ONE, list(new))] = -math.inf
            total = np.logaddexp.reduce(odds, axis=0)
            likelier = {}
            for f in range(len(FEATURES)):
                with_f = (FIRST == f) | (SECOND_ONE == f)
                alarm = float(np.logaddexp.reduce(total[with_f]))
                without_f = float(np.logaddexp(0.0, np.logaddexp.reduce(total[~with_f])))
                likelier[f] = alarm - without_f
            f = max(likelier, key=lambda f: likelier[f])
            if turn == 0:
                self._score(likelier)
            if likelier[f] < 0.0:
                return
            with_f = (FIRST == f) | (SECOND_ONE == f)
            row, h = np.unravel_index(int(np.where(with_f, odds, -math.inf).argmax()), odds.shape)
            for feature in {int(FIRST[h]), int(SECOND_ONE[h])}:
                if likelier[feature] >= 0.0:
                    new.add(feature)
                    self.wear[feature] = self.wear[feature].with_step(Step(self._stamp(int(row))))
            self.fit = self._fit()

    def _score(self, likelier: dict[int, float]) -> None:
        """Keep the odds of a change of each feature, on the side to which it goes."""
        pull = self.fit.scan.pull
        threshold = self.tracker.settings.threshold
        for test in TESTS:
            side = test.sign * float(pull[max(len(pull) - RECENT, 0), test.column])
            score = likelier[test.column] / math.log(10.0) + threshold
            self.scores[test.key] = max(score, 0.0) if side > 0.0 else 0.0

    def estimate(self) -> None:
        """Bring value, slope and course of each feature up to date."""
        for f, feature in enumerate(self.wear):
            if self.base.observations.weight[-1, f, f] > 0.0:
                feature = replace(feature, compared_ns=self.tracker.stamp_ns)
            if not feature.found:
                off = float(self.fit.scan.residual[-1, f])
                strays = self.base.observations.weight[-1, f, f] > 0.0 and abs(off) > \
                    LIMITS.contradicted * self.noise[f]
                feature = replace(
                    feature, course=0, slope=0.0, slope_std=0.0, moving=0.0,
                    newest=self.tracker.relative(f, off, 0.0)[0] if strays else 0.0)
                self.wear[f] = feature if feature.pending else self._recent(f, feature)
                continue
            courses = {c: w.course for c, w in enumerate(self.wear)}
            fits = [self._fit({**courses, f: c}) for c in range(len(WEAR.courses))]
            logs = np.array([fit.likelihood for fit in fits]) + np.log(WEAR.course_prior)
            share = np.exp(logs - logs.max())
            share /= share.sum()
            pairs = np.array([self._now(fit, f) for fit in fits])
            self.steady[f] = pairs[0]
            value = float(share @ pairs[:, 0])
            std = math.sqrt(float(share @ (pairs[:, 1] ** 2 + (pairs[:, 0] - value) ** 2)))
            sloped = 1 + int(share[1:].argmax())
            fit = fits[sloped]
            at = int(np.searchsorted(fit.columns.feature, f)) + len(feature.steps) \
                + len(feature.found) - 1
            self.wear[f] = replace(
                feature, newest=0.0, value=value, std=std, course=int(share.argmax()),
                moving=float(1.0 - share[0]), slope=float(fit.mean[at]),
                slope_std=math.sqrt(max(float(fit.covariance[at, at]), 0.0)))
        self.fit = self._fit({c: w.course for c, w in enumerate(self.wear)})
        for f, feature in enumerate(self.wear):
            if feature.pending and not feature.found:
                value, std = self._now(self.fit, f)
                self.wear[f] = replace(feature, value=value, std=std)

    def _now(self, fit: Fit, f: int) -> tuple[float, float]:
        """Return (value, deviation) of the wear of a feature now, since the baseline was saved."""
        own = (fit.columns.feature == f) & ~self.accepted(fit)
        return fit.combined(np.zeros(len(self.base.mean)), np.where(own, fit.columns.now, 0.0))

    def _recent(self, f: int, feature: FeatureWear) -> FeatureWear:
        """Return a feature with what a change of its newest windows would be."""
        data = self.tracker.data
        newest_step = max((step.stamp_ns for step in feature.steps), default=-1)
        measured = np.flatnonzero((self.base.observations.counts[-len(self.rows):, f] > 0.0)
                                  & (self.rows > newest_step))
        if not len(measured):
            return feature
        # Windows at odds with the drive may be off together: all against those before.
        trusted = np.flatnonzero(data.trust[-len(self.rows):] == TRUSTED)
        begin = trusted[-1] + 1 if len(trusted) else 0
        k = begin if begin <= measured[-1] else measured[-min(RECENT, (len(measured) + 1) // 2)]
        value, std = self.fit.scan.size(int(k), f)
        return replace(feature, value=value, std=std)

    def reportable(self, column: int) -> bool:
        """Return whether a change of a feature is large enough, and explained by no other one."""
        tracker, feature = self.tracker, self.wear[column]
        tracker_now = replace(tracker, wear=tuple(self.wear))
        smallest = tracker.settings.notice(column) + tracker_now.missed(column)
        sizes = [abs(feature.value) - feature.std]
        sizes += [abs(float(self.fit.mean[k])) - math.sqrt(float(self.fit.covariance[k, k]))
                  for f, step, k in self._steps(self.fit) if f == column and step.kind == 'found']
        if max(sizes) < smallest:
            return False
        if column != VISCOUS_SHARE:
            return True
        # The share changes by no more than the friction does, relative to it, unless viscous and
        # Coulomb friction go opposite ways.
        k = min(int(np.searchsorted(self.rows, feature.found[-1], 'right')), len(self.rows) - 1)
        friction = tracker_now.wear[FRICTION]
        growth = math.expm1(friction.value if friction.found else np.nan_to_num(
            self.fit.scan.size(k, FRICTION)[0]))
        return abs(feature.value) - feature.std - abs(growth) >= tracker.settings.notice(column)
