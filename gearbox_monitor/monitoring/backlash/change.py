# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Follow the features of backlash and friction window by window: what has changed for good.

`Tracker` holds a baseline per operating point, tests every window against it (scan.Stretches) and
says what grew, by how much, since when, and when a limit will be reached.
"""
from dataclasses import asdict, dataclass, field
import math
from typing import Any, Self

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.monitoring.backlash import forecast, scan
from gearbox_monitor.monitoring.backlash.change_tests import (
    ADVICE, ALONE, ChangeTest, COMPONENTS, FEATURES, FRICTION, GAP, LOST_MOTION, size_name,
    STIFFNESS, TESTS)
from gearbox_monitor.monitoring.backlash.features import Backlash, Friction, NotExcited
from gearbox_monitor.monitoring.backlash.forecast import span, when
from gearbox_monitor.monitoring.backlash.operating_point import (
    numbers, OperatingPoint, OperatingPoints, Sums)
from gearbox_monitor.monitoring.checks.outcome import Level, Outcome
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

# A change is over when the newest so many windows show less than half of what was found.
RELEASE_WINDOWS = 12
# The size of a change is that of the newest so many windows where these differ from all since the
# change by so many standard deviations.
RECENT, DIFFERENT = (3, 12), 4.0
# A feature of a window whose estimates are not trusted is compared where its stated deviation is
# at most so many times that of the baseline, or this share of the change that requires a service:
# the fit holds then, whatever the filter expected.
STATED_RATIO, PRECISE = 3.0, 0.1
# A stage is left when the change is below this share of its limit.
RELEASE = 0.9
FOUND, WARNED, GROSS = 1, 2, 3  # stages of an alarm
# All else has stayed: its stretch scores less than this either way; and the gap as it was measured
# must speak for growth, too.
STAYED, AGREES = 3.5, 1.5

_COLUMNS = (np.array([t.column for t in TESTS]), np.array([t.sign for t in TESTS]),
            np.array([t.relative for t in TESTS]))
RAW, SHARP, *ELSE = (next(i for i, t in enumerate(TESTS) if t.key == key) for key in (
    'gap', ALONE, 'stiffness_loss', 'hysteresis', 'friction', 'torque_gain'))


@dataclass(frozen=True)
class TrackerSettings:
    """
    What a Tracker goes by.

    windows_per_false_alarm: mean number of windows between two false alarms, of all tests
    together. baseline_windows: how many a point learns. bins: see OperatingPoints.find.
    limits {test: (notice, warn, error)}: relative changes; below `notice` nothing is reported.
    gap_limit: rad, 0 = none. viscous (N m s/rad), coulomb (N m): friction of the model.
    """

    windows_per_false_alarm: float = 3.15e6
    baseline_windows: int = 720
    bins: tuple[float, float, float, float] = (3.2, 2.0, 2.0, 5.0)
    limits: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    gap_limit: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0

    @classmethod
    def of(cls, parameters: EstimatorParameters, model: DriveModel) -> Self:
        """Return the TrackerSettings of `parameters` and the DriveModel `model`."""
        p = parameters
        width = p.gap_notice, p.gap_warn, p.gap_error
        friction = 0.25 * p.friction_warn, p.friction_warn, p.friction_error
        stiffness = 0.2 * p.stiffness_warn, p.stiffness_warn, p.stiffness_error
        return cls(
            max(p.false_alarm_interval / p.drift_window, 20.0), p.baseline_windows,
            (p.angle_bin, p.speed_bin, p.load_bin, p.temperature_bin),
            {'gap': width, 'lost_motion': width, 'stiffness_loss': stiffness,
             'hysteresis': stiffness, 'hysteresis_down': stiffness,
             'friction': friction, 'friction_loss': friction,
             'torque_gain': stiffness, 'torque_gain_loss': stiffness},
            p.gap_limit, model.viscous_friction, model.coulomb_friction)

    def threshold(self, test: ChangeTest) -> float:
        """Return the normal score at which `test` fires."""
        return scan.threshold(self.windows_per_false_alarm / test.share)


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


class Tracker:
    """
    Baselines, sequential test, forecast and alarms of one gearbox; one `update` per window.

    settings: TrackerSettings. state: what to_dict or baseline gave, or None. Raises ValueError,
    KeyError or TypeError for a state that is none.
    """

    def __init__(self, settings: TrackerSettings, state: Any = None) -> None:
        self.settings = settings
        self._points = OperatingPoints(len(FEATURES))
        self._stamps: list[int] = []
        self._where: list[int] = []
        self._learned: list[bool] = []
        self._values: Array = np.empty((0, len(FEATURES)))
        self._scores = {test.key: 0.0 for test in TESTS}
        self.changes: dict[str, Change] = {}  # by test
        self._history = forecast.GrowthHistory()
        self._window: Backlash | None = None
        self._friction: Backlash | Friction | None = None
        self._point, self._trusted, self._compared = -1, False, False
        self._temperature: float | None = None  # of the newest window
        self._growth = math.nan  # of the newest window
        self._pause: NotExcited | None = None  # when the newest window was none
        self.stamp_ns = 0
        if state is not None:
            self._load(state)

    # ------------------------------------------------------------------ windows

    def update(self, window: Backlash | NotExcited, trusted: bool = True,
               temperature: float | None = None, comparable: bool = False
               ) -> dict[str, Outcome]:
        """
        Take a window of the sequential test.

        Args:
            window: features of the newest window, or why there are none.
            trusted: whether the estimates of the window were; if not, no baseline learns it.
            temperature: of the gearbox (deg C), None if unknown.
            comparable: whether a window that is not trusted is compared with the baseline where
                its fit is as good as those of the baseline; else it is only shown.

        Returns:
            {component: Outcome} in force.

        """
        if window.stamp_ns == self.stamp_ns:
            return self.outcomes()  # it has been taken before
        self.stamp_ns, self._temperature = window.stamp_ns, temperature
        features: Backlash | Friction
        if not isinstance(window, NotExcited):
            self._pause, self._window, features = None, window, window
        else:
            self._pause = window
            if window.friction is None:
                return self.outcomes()
            features = window.friction
        self._friction, self._trusted = features, bool(trusted)
        self._point = self._points.find(features, temperature, self.settings.bins)
        self._growth, self._compared = math.nan, False
        if self._point >= 0 and (trusted or comparable):
            values, variances = self._measure(features)
            if not trusted:
                values = np.where(self._fits(variances), values, math.nan)
            self._compared = bool(np.isfinite(values).any())
            if self._compared:
                self._take(values, variances, trusted)
        return self.outcomes()

    def _fits(self, variances: Array) -> Flags:
        """Return which features [F] of a window are as certain as comparing them requires."""
        sums = self._points[self._point].sums
        change = np.zeros(len(FEATURES))
        for test in TESTS:
            if test.column < len(FEATURES) and test.key in self.settings.limits:
                unit = abs(sums.mean()[test.column]) if test.relative else sums.scale
                change[test.column] = unit * self.settings.limits[test.key][1]
        with np.errstate(invalid='ignore'):
            certain = (variances <= STATED_RATIO ** 2 * sums.stated) \
                | (variances <= (PRECISE * change) ** 2)
            result: Flags = certain & (sums.count >= scan.MIN_BASELINE)
        return result

    def _measure(self, window: Backlash | Friction) -> tuple[Array, Array]:
        """Return (values [F], variances [F]) of a window's features."""
        w, nan = window, (math.nan, math.nan)
        gap, lost_motion, stiffness, hysteresis = (nan,) * 4
        if isinstance(w, Backlash):
            # A gap refined by other windows is not independent of them.
            gap = w.alone if w.separable else nan
            lost_motion = nan if w.separable else (w.lost_motion, w.lost_motion_std)
            stiffness = w.stiffness, w.stiffness_std
            hysteresis = w.hysteresis, w.hysteresis_std
        s = self.settings
        friction = s.viscous * w.speed + s.coulomb
        if not friction > 0.0:
            friction = w.load
        change = w.viscous * w.speed + w.coulomb
        rows = (gap, lost_motion, stiffness, hysteresis,
                (1.0 + change / friction if friction > 0.0 else math.nan,
                 math.hypot(w.viscous_std * w.speed, w.coulomb_std) / friction
                 if friction > 0.0 else math.nan),
                (1.0 + w.gain, w.gain_std))
        # Seven digits keep the state small, and say more than any measurement.
        values, std = (np.array([float(f'{v:.7g}') for v in column]) for column in zip(*rows))
        return values, std ** 2

    def _take(self, values: Array, variances: Array, trusted: bool) -> None:
        sums = self._points[self._point].sums
        sums.refer(values)
        learn = (trusted and not self.changes
                 and sums.count.max() < self.settings.baseline_windows)
        if learn:
            sums.add(values, variances)
        drop = max(len(self._stamps) + 1 - scan.HORIZON, 0)
        self._stamps = [*self._stamps, self.stamp_ns][drop:]
        self._where = [*self._where, self._point][drop:]
        self._learned = [*self._learned, learn][drop:]
        self._values = np.vstack([self._values, values])[drop:]
        self._note(values, variances)
        self._judge(self._stretches())

    def _note(self, values: Array, variances: Array) -> None:
        """Keep the growth of the width for the forecast."""
        sums = self._points[self._point].sums
        column = GAP if math.isfinite(values[GAP]) else LOST_MOTION
        base = sums.mean()[column]
        if sums.count[column] >= scan.MIN_BASELINE and base > 0.0:
            self._growth = float(f'{values[column] / base - 1.0:.7g}')
            variance = max(variances[column], sums.std()[column] ** 2) / base ** 2
            if math.isfinite(self._growth) and variance > 0.0:
                self._history.add(self.stamp_ns, self._growth, float(f'{variance:.6g}'))

    def _stretches(self) -> scan.Stretches:
        points = np.array(self._where)
        return scan.Stretches(
            self._values, points, np.array(self._learned, bool),
            {point: self._points[point].sums for point in set(self._where)}, _COLUMNS)

    def _judge(self, stretches: scan.Stretches) -> None:
        detected = {}
        for t, test in enumerate(TESTS):
            k = int(np.argmax(stretches.score[:, t]))
            score = self._scores[test.key] = float(stretches.score[k, t])
            if test.key == ALONE:
                if not self._all_else_equal(stretches, k):
                    continue
                key, grown = 'gap', min(stretches.growth[k, t], stretches.growth[k, RAW])
            else:
                key, grown = test.key, stretches.growth[k, t]
            notice = self.settings.limits.get(key, (0.0,))[0]
            if (key not in self.changes and key not in detected and grown >= notice
                    and score > self.settings.threshold(test)):
                detected[key] = (k, float(stretches.growth[k, t]), float(stretches.std[k, t]))
        for key, (k, growth, std) in detected.items():
            since = self._stamps[k - 1] if k else self._stamps[0]
            self.changes[key] = Change(since, self.stamp_ns, growth, growth, std)
        if detected:
            self._unlearn(min(k for k, _, _ in detected.values()))
            stretches = self._stretches()
        for t, test in enumerate(TESTS):
            if test.key in self.changes:
                self._follow(t, test, stretches)

    @staticmethod
    def _all_else_equal(stretches: scan.Stretches, k: int) -> bool:
        return bool(np.abs(stretches.score[k, ELSE]).max() < STAYED
                    and stretches.score[k, RAW] > AGREES)

    def _unlearn(self, first: int) -> None:
        """Take the windows from row `first` on out of the baselines: they are not healthy."""
        for k in range(first, len(self._stamps)):
            if self._learned[k]:
                # Their stated variances stay what they are on average.
                sums = self._points[self._where[k]].sums
                stated = sums.stated
                sums.add(self._values[k], stated, -1)
                self._learned[k] = False

    def _follow(self, t: int, test: ChangeTest, stretches: scan.Stretches) -> None:
        """Bring a Change up to date, or end it."""
        change = self.changes[test.key]
        follow_rows = [k for k, stamp in enumerate(self._stamps) if stamp > change.since_ns] or [0]
        if test.key == 'gap' and self._all_else_equal(stretches, follow_rows[0]):
            if math.isfinite(stretches.growth[follow_rows[0], SHARP]):
                t = SHARP
        growth, std = stretches.growth[follow_rows[0], t], stretches.std[follow_rows[0], t]
        if not math.isfinite(growth):
            return
        trend = self._history.trend(change.since_ns) if test.key in ('gap', 'lost_motion') \
            else None
        if trend is not None and trend.found:
            growth, std = trend.growth, math.hypot(trend.growth_std, self._baseline_error())
        for length in RECENT:  # it may have gone on in a way that is neither level nor line
            if length < len(follow_rows):
                recent_growth, doubt = stretches.growth[-length, t], stretches.std[-length, t]
                if abs(recent_growth - growth) > DIFFERENT * math.hypot(std, doubt):
                    growth, std = recent_growth, doubt
                    break
        change.growth, change.std = float(growth), float(std)
        _, warn, error = self._limits(test)
        stage = FOUND
        for at, limit in ((WARNED, warn), (GROSS, error)):
            if growth >= (limit if change.stage < at else RELEASE * limit):
                stage = at
        change.stage = stage
        if len(follow_rows) >= RELEASE_WINDOWS:
            recent = stretches.growth[-RELEASE_WINDOWS, t]
            if recent < 0.5 * change.found:
                del self.changes[test.key]
                self._stamps, self._where, self._learned = [], [], []
                self._values = self._values[:0]
                self._scores[test.key] = 0.0

    def _baseline_error(self) -> float:
        base = self.baseline
        return 0.0 if base is None or not base.gap > 0.0 else base.gap_std / base.gap

    def _limits(self, test: ChangeTest) -> tuple[float, float, float]:
        notice, warn, error = self.settings.limits.get(test.key, (0.0, math.inf, math.inf))
        base = self.baseline
        if test.key == 'gap' and self.settings.gap_limit > 0.0 and base and base.gap > 0.0:
            error = min(error, self.settings.gap_limit / base.gap - 1.0)
        return notice, warn, error

    # ------------------------------------------------------------------ what is known

    @property
    def baseline(self) -> Baseline | None:
        """The Baseline of the operating point of the newest window, None while not known."""
        if self._point < 0:
            return None
        sums = self._points[self._point].sums
        count = sums.count[GAP]
        if count < scan.MIN_BASELINE:
            return None
        mean, std = sums.mean(), sums.std() / math.sqrt(count)
        return Baseline(float(mean[GAP]), float(std[GAP]), float(mean[STIFFNESS]),
                        float(std[STIFFNESS]), int(count))

    @property
    def points(self) -> list[OperatingPoint]:
        """The operating points, a list of operating_point.OperatingPoint."""
        return list(self._points)

    def stages(self) -> dict[str, dict[str, int]]:
        """Return {component: {test: stage}}; an alert is given when that changes."""
        return {component: {t.key: self.changes[t.key].stage for t in TESTS
                            if t.component == component and t.key in self.changes}
                for component in COMPONENTS}

    def outcomes(self) -> dict[str, Outcome]:
        """Return {component: Outcome} in force."""
        return {component: self._outcome(component) for component in COMPONENTS}

    def _outcome(self, component: str) -> Outcome:
        window = self._window if component == 'backlash' else self._friction
        pause = self._pause
        if pause is not None and pause.friction is not None and component == 'friction':
            pause = None
        active = [t for t in TESTS if t.component == component and t.key in self.changes]
        if window is None and not active:
            message = 'backlash not measured yet' if component == 'backlash' else \
                'friction not measured yet'
            reason = f': {pause.reason}' if pause else ': no window has ended'
            return Outcome(Level.WARN, f'{message}{reason}; a baseline needs '
                           f'{scan.MIN_BASELINE} windows')
        values = self._measured(component, window) if window else {}
        active.sort(key=lambda t: -self.changes[t.key].stage)
        level, said = Level.OK, []
        for test in active:
            change = self.changes[test.key]
            level = max(level, Level.ERROR if change.stage == GROSS else Level.WARN)
            said.append(self._describe(test, change, values))
        if window is not None and not said:
            said.append(self._healthy(component, window))
        notes: list[str] = []
        if window is not None and self._point_windows() < scan.MIN_BASELINE:
            notes.append('no baseline at this operating point '
                         f'({self._point_windows()} of {scan.MIN_BASELINE} windows)'
                         + (', none is learnt during an alarm' if self.changes else ''))
        if window is not None and not self._compared:
            notes.append('not compared: the estimates are not trusted now, see the other '
                         'indicators')
        message = '; '.join(said + notes)
        values = {key: value for key, value in values.items()
                  if not isinstance(value, float) or math.isfinite(value)}
        if pause is not None:
            message = (f'not excited now ({pause.reason}); measured last: ' + message)
        return Outcome(level, message, values)

    def _point_windows(self) -> int:
        return int(self._points[self._point].sums.count.max()) if self._point >= 0 else 0

    def _healthy(self, component: str, window: Backlash | Friction) -> str:
        base = self.baseline
        learnt = ''
        if base and base.windows < self.settings.baseline_windows:
            learnt = f' (of {base.windows} windows, {self.settings.baseline_windows} wanted)'
        if isinstance(window, Backlash) and component == 'backlash':
            width = f'gap {window.gap:.4g} rad' if window.separable else \
                f'lost motion {window.lost_motion:.4g} rad'
            if math.isfinite(self._growth):
                return f'{width}, {100 * self._growth:+.1f} % against the baseline{learnt}'
            return width
        change = self._against(FRICTION)
        if not math.isfinite(change):
            return 'friction not compared' if math.isfinite(window.viscous) else \
                'friction not identifiable in this motion'
        return f'friction {100 * change:+.1f} % against the baseline{learnt}'

    def _against(self, column: int) -> float:
        """Return the relative change of a feature of the newest window."""
        if self._point < 0 or not self._compared or not len(self._values):
            return math.nan
        base = self._points[self._point].sums.mean()[column]
        return float(self._values[-1, column] / base - 1.0) if base else math.nan

    def _measured(self, component: str, window: Backlash | Friction) -> dict[str, Any]:
        base = self.baseline
        values: dict[str, Any]
        if isinstance(window, Backlash) and component == 'backlash':
            values = {
                'gap_rad': window.gap, 'gap_std_rad': window.gap_std,
                'gap_arcmin': math.degrees(window.gap) * 60.0,
                'stiffness': window.stiffness, 'stiffness_std': window.stiffness_std,
                'hysteresis': window.hysteresis, 'hysteresis_std': window.hysteresis_std,
                'lost_motion_rad': window.lost_motion, 'separable': window.separable,
                'flank': window.flank, 'coverage': window.coverage}
            if base:
                values['baseline_gap_rad'] = base.gap
                values['baseline_stiffness'] = base.stiffness
            values['growth'] = self._growth
        else:
            values = {'viscous_change': window.viscous, 'viscous_change_std': window.viscous_std,
                      'coulomb_change': window.coulomb, 'coulomb_change_std': window.coulomb_std,
                      'torque_gain_change': window.gain,
                      'friction_change': self._against(FRICTION)}
        if self._point >= 0:
            values['operating_point'] = self._points[self._point].text()
        values['baseline_windows'] = self._point_windows()
        for test in TESTS:
            if test.component == component:
                values[f'{test.key}_score'] = self._scores[test.key]
                values[f'{test.key}_score_threshold'] = self.settings.threshold(test)
                if test.key in self.settings.limits:
                    _, warn, error = self._limits(test)
                    name = size_name(test)
                    values[f'{name}_warn'], values[f'{name}_error'] = warn, error
        values['trusted'] = self._trusted
        return values

    def _describe(self, test: ChangeTest, change: Change, values: dict[str, Any]) -> str:
        """Return the words for a Change and add its figures to `values`."""
        name = size_name(test)
        values[name], values[f'{name}_std'] = change.growth, change.std
        values[f'{name}_since'] = when(change.since_ns)
        digits = 1 if change.std >= 0.001 else 2
        sign = '+' if test.sign > 0 else ''  # "dropped by" says the sign itself
        growth = max(change.growth, 0.0)
        text = (f'{test.words} {100 * growth:{sign}.{digits}f} % +- '
                f'{100 * change.std:.{digits}f} % since {when(change.since_ns)}')
        if change.growth < 0.0:
            text = (f'{test.words} {100 * change.found:{sign}.{digits}f} % at '
                    f'{when(change.found_ns)}; now {-100 * change.growth:.{digits}f} % the other '
                    'way')
        if test.column == FRICTION and self._temperature is None:
            text += ' (warm-up or lubrication: the temperature is not known)'
        _, _, error = self._limits(test)
        if test.key in ('gap', 'lost_motion') and change.stage < GROSS:
            trend = self._history.trend(change.since_ns)
            reach = trend.reach(error) if trend else None
            if reach:
                # What has passed since the newest block counts.
                values.update(zip(('forecast_s', 'forecast_earliest_s', 'forecast_latest_s'),
                                  reach))
                text += (f', limit {100 * error:+.0f} % in {span(reach[0])} ({span(reach[1])} to '
                         f'{span(reach[2])})')
            elif trend:
                text += ', steady now'
        return f'{text}: {ADVICE[test.key][change.stage - 1]}'

    # ------------------------------------------------------------------ healthy by decision

    def accept(self) -> int:
        """
        Make what is measured now the healthy state; return how many windows it rests on.

        Without an alarm the baselines stay as they were learnt, and a point that learnt nothing
        takes its newest windows. In an alarm the windows since the change make new baselines, and
        points without any lose theirs. Ends all alarms.
        """
        since = min((c.since_ns for c in self.changes.values()), default=None)
        used = 0
        for index, point in enumerate(self._points):
            if since is None and point.sums.count.max() > 0:
                used += int(point.sums.count.max())
                continue
            fresh = Sums.empty(len(FEATURES), point.sums.scale)
            rows = [k for k, where in enumerate(self._where)
                    if where == index and (since is None or self._stamps[k] > since)]
            for k in rows:
                fresh.refer(self._values[k])
                fresh.add(self._values[k], np.where(
                    np.isfinite(self._values[k]), point.sums.stated, math.nan))
            if rows and not (fresh.stated > 0.0).any() and self._window is not None:
                fresh.stated = np.nan_to_num(self._measure(self._window)[1])
            point.sums = fresh
            used += len(rows)
        self._stamps, self._where, self._learned = [], [], []
        self._values = self._values[:0]
        self.changes, self._history = {}, forecast.GrowthHistory()
        self._scores = {test.key: 0.0 for test in TESTS}
        return used

    # ------------------------------------------------------------------ state

    def baseline_points(self) -> list[dict[str, Any]]:
        """Return the baselines as plain data, a list with one mapping per operating point."""
        rows = ((point, point.sums.described(FEATURES)) for point in self._points)
        return [{**point.place(), **row} for point, row in rows if row['features']]

    def to_dict(self) -> dict[str, Any]:
        """Return all that the next outcomes depend on, as plain data; floats read back exactly."""
        return {
            'points': [{**p.place(), **p.sums.to_dict()} for p in self._points],
            'windows': [[stamp, where, int(learned), *map(float, values)] for
                        stamp, where, learned, values in
                        zip(self._stamps, self._where, self._learned, self._values)],
            'scores': self._scores,
            'changes': {key: asdict(change) for key, change in self.changes.items()},
            'history': [list(b) for b in self._history.blocks],
            'window': self._window and asdict(self._window), 'point': self._point,
            'friction': asdict(self._friction) if isinstance(self._friction, Friction) else None,
            'trusted': self._trusted, 'compared': self._compared, 'growth': self._growth,
            'temperature': self._temperature, 'stamp_ns': self.stamp_ns,
            'pause': self._pause and {
                'stamp_ns': self._pause.stamp_ns, 'reason': self._pause.reason,
                'friction': self._pause.friction and asdict(self._pause.friction)}}

    @classmethod
    def from_dict(cls, settings: TrackerSettings, state: Any) -> Self:
        """Return the Tracker with `settings` that continues `state` (to_dict, baseline_points)."""
        return cls(settings, state)

    def _load(self, state: Any) -> None:
        if isinstance(state, list):  # baselines alone
            state = {'points': state}
        n = len(FEATURES)
        for row in state['points']:
            read = Sums.from_described if 'features' in row else Sums.from_dict
            self._points.points.append(OperatingPoint.at(row, read(row, FEATURES)))
        if 'windows' not in state:
            return
        rows = state['windows']
        self._stamps = [int(r[0]) for r in rows]
        self._where = [int(r[1]) for r in rows]
        if not all(0 <= where < len(self._points) for where in self._where):
            raise ValueError('a window of an unknown operating point')
        self._learned = [bool(r[2]) for r in rows]
        self._values = numbers([r[3:] for r in rows], len(rows) * n).reshape(-1, n)
        self._scores.update({test.key: float(state['scores'][test.key]) for test in TESTS})
        self.changes = {key: Change(**value) for key, value in state['changes'].items()
                        if key in self._scores}
        self._history = forecast.GrowthHistory(state['history'])
        self._window = state['window'] and Backlash(**state['window'])
        friction = state.get('friction')  # older states hold none
        self._friction = Friction(**friction) if friction else self._window
        self._point, self._trusted = int(state['point']), bool(state['trusted'])
        self._compared = bool(state.get('compared', self._trusted))
        if self._point >= len(self._points):
            raise ValueError('an unknown operating point')
        self._growth, self._temperature = float(state['growth']), state.get('temperature')
        pause = state['pause']
        if pause:
            friction = pause.get('friction')
            pause = NotExcited(**{**pause, 'friction': friction and Friction(**friction)})
        self._pause = pause
        self.stamp_ns = int(state['stamp_ns'])
