# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one judgement of wear: Health and a window in, Health and events out.

The live node folds its windows with `judge`; replay, report, accept and fleet fold the windows
of recordings. A state file and a baseline are a Health as `to_data` writes it.
"""
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

from gearbox_monitor.health.backlash.change import Tracker
from gearbox_monitor.health.backlash.change_tests import (
    ChangeTest, COMPONENTS, FEATURES, GAP, LOST_MOTION, TESTS)
from gearbox_monitor.health.backlash.features import Backlash, Friction, NotExcited
from gearbox_monitor.health.health_record import (
    Alert, FeatureHealth, GROSS, HealthSettings, WARNED, Window)
from gearbox_monitor.health.slip import found_in, Slip, Zero
from gearbox_monitor.kernels.types import Values

KEPT = ('cause', 'recordings', 'earlier', 'slips', 'zeros')  # unchanged by a window
RECORDINGS, SLIPS = 1000, 100  # that are kept
OVER_LIMIT = 'gap_limit'  # stage of a backlash above that parameter, whatever the baseline
SLIP = 'slip'  # and number of the newest one


@dataclass(frozen=True)
class Health:
    """
    Health of one gearbox after the window that ended at `stamp_ns`, 0 before any.

    features: of FEATURES, in their order. alerts {test: Alert}. ended {component: ((test, size),
    ...)}: what was over with the newest window, ('', 0) of a baseline that was saved. window: the
    newest one; backlash, friction: the newest that showed them. compared: whether the newest
    window was. over_limit: whether the backlash surely exceeds gap_limit. point: its operating
    point in words, point_windows: windows there. scores {test: log10 of its odds}. coefficients:
    (growth, deviation) of viscous and Coulomb friction. baseline_ns: first window that the
    baseline rests on, 0 while there is none. marks: (stamp, words) of services and of baselines
    that were adopted. cause: as a comparison of recordings named it, or ''. recordings:
    that it rests on. earlier: whether the baseline is from before this run or recording, or was
    saved. slips: since the baseline was saved, in order of time; zeros: of the twist, see
    slip.found_in. tracker: all else that the next judgement depends on, None before the first
    window.
    """

    settings: HealthSettings
    stamp_ns: int = 0
    features: tuple[FeatureHealth, ...] = (FeatureHealth(),) * len(FEATURES)
    alerts: Mapping[str, Alert] = field(default_factory=dict)
    ended: Mapping[str, tuple[tuple[str, float], ...]] = field(default_factory=dict)
    window: Window | None = None
    backlash: Backlash | None = None
    friction: Backlash | Friction | None = None
    compared: bool = False
    over_limit: bool = False
    point: str = ''
    point_windows: int = 0
    scores: Mapping[str, float] = field(default_factory=dict)
    coefficients: tuple[tuple[float, float], ...] = ()
    baseline_ns: int = 0
    marks: tuple[tuple[int, str], ...] = ()
    cause: str = ''
    recordings: tuple[str, ...] = ()
    earlier: bool = False
    slips: tuple[Slip, ...] = ()
    zeros: tuple[Zero, ...] = ()
    tracker: Tracker | None = field(default=None, repr=False, compare=False)

    def feature(self, name: str) -> FeatureHealth:
        """Return the FeatureHealth of the feature `name`, one of FEATURES."""
        return self.features[FEATURES.index(name)]

    def growth(self, column: int) -> tuple[float, float]:
        """Return (change, deviation) of the feature in `column`, NaN while it is not known."""
        feature = self.features[column]
        return feature.change, feature.change_std

    @property
    def separable(self) -> bool:
        """Whether the newest backlash is distinguished from compliance."""
        return self.backlash is None or self.backlash.separable

    @property
    def width(self) -> FeatureHealth:
        """The backlash; the lost motion where backlash is not distinguished from compliance."""
        return self.features[GAP if self.separable else LOST_MOTION]

    @property
    def pause(self) -> NotExcited | None:
        """The newest window if it did not show the gap."""
        features = self.window and self.window.features
        return features if isinstance(features, NotExcited) else None

    @property
    def temperature(self) -> float | None:
        """Temperature (deg C) of the gearbox in the newest window, None if unknown."""
        return self.window.temperature if self.window else None

    @property
    def trusted(self) -> bool:
        """Whether the estimates of the newest window that showed anything were trusted."""
        return self.tracker is not None and self.tracker.trusted

    @property
    def statistics(self) -> dict[str, Any]:
        """What the next judgement depends on as plain data, {} before the first window."""
        return self.tracker.to_dict() if self.tracker else {}

    def limits(self, test: ChangeTest) -> tuple[float, float, float]:
        """Return the sizes from which on a change is noticed, a warning, an error by `test`."""
        return self.settings.limits_of(test, self.features[GAP].baseline)

    def stages(self) -> dict[str, dict[str, int]]:
        """Return {component: {test: stage}}; an alert is given when that changes."""
        stages: dict[str, dict[str, int]] = {component: {} for component in COMPONENTS}
        for test in TESTS:
            if test.key in self.alerts:
                stages[test.component][test.key] = self.alerts[test.key].stage
        if self.over_limit:
            stages['backlash'][OVER_LIMIT] = GROSS
        if self.slips:
            stages['backlash'][f'{SLIP} {len(self.slips)}'] = WARNED
        return stages


@dataclass(frozen=True)
class Event:
    """The alerts of a `component` have changed to `stages` {test: stage}: raised, worse, over."""

    component: str
    stages: Mapping[str, int]


def judge(health: Health, window: Window) -> tuple[Health, tuple[Event, ...]]:
    """
    Return the Health after one more window, and the alerts that changed with it.

    Args:
        health: before the window; it stays unchanged.
        window: the newest window; one that was judged before changes nothing.
    """
    judged = _following(health, _tracker(health).update(window))
    if isinstance(window.features, Backlash) and window.stamp_ns != health.stamp_ns:
        zeros, slip = found_in(health.zeros if window.counts_on else (), window.features,
                               health.settings.motor_turn)
        judged = replace(judged, zeros=zeros, slips=(
            *judged.slips, slip)[-SLIPS:] if slip else judged.slips)
    if not judged.alerts:
        judged = replace(judged, cause='')
    return judged, events(health, judged)


def events(previous: Health, present: Health) -> tuple[Event, ...]:
    """Return the Events that lead from the `previous` Health to the `present` one."""
    old, new = previous.stages(), present.stages()
    return tuple(Event(component, new[component]) for component in COMPONENTS
                 if new[component] != old[component])


def folded(health: Health, windows: Iterable[Window], recording: str = '') -> Health:
    """Return the Health after all `windows`, in order of time, of the `recording` so called."""
    health = replace(health, earlier=health.earlier or health.baseline_ns > 0)
    after = reduce(lambda known, window: judge(known, window)[0], windows, health)
    names = (*after.recordings, recording)[-RECORDINGS:] if recording else after.recordings
    return replace(after, recordings=names)


def accepted(health: Health) -> tuple[Health, int]:
    """
    Return `health` with the present state as the healthy one, and its number of windows.

    The wear becomes 0 with its deviation, at all operating points; all alerts end.
    """
    tracker, windows = _tracker(health).accept()
    return replace(_following(health, tracker), cause='', earlier=True, slips=()), windows


def serviced(health: Health, stamp_ns: int, note: str) -> Health:
    """
    Return `health` after a service: the next windows are a new baseline.

    Args:
        health: before it.
        stamp_ns: of the service.
        note: on the service, or ''.

    """
    return replace(_following(health, _tracker(health).served(stamp_ns, note)), cause='', slips=())


def under(health: Health, settings: HealthSettings) -> Health:
    """Return `health` as it is judged by other `settings` from now on."""
    return _following(health, _tracker(health).under(settings))


def _tracker(health: Health) -> Tracker:
    return health.tracker or Tracker.of(health.settings)


def _following(health: Health, tracker: Tracker) -> Health:
    return _shown(tracker, **{name: getattr(health, name) for name in KEPT})


def _shown(tracker: Tracker, **kept: Any) -> Health:
    """Return the Health that a `tracker` knows, with what is `kept` outside of it."""
    data, point = tracker.data, tracker.point
    return Health(
        tracker.settings, tracker.stamp_ns, tuple(map(tracker.feature, range(len(FEATURES)))),
        tracker.alerts, tracker.ended, tracker.window, tracker.backlash, tracker.friction,
        tracker.compared, tracker.over_limit, data.points[point].text() if point >= 0 else '',
        tracker.point_windows, tracker.scores, tracker.coefficients(),
        int(data.stamps[0]) if len(data.stamps) else 0, tracker.marks, tracker=tracker, **kept)


def to_data(health: Health) -> dict[str, Any]:
    """Return all of `health` that no settings give, as plain data; floats read back exactly."""
    return {'statistics': health.statistics,
            **{name: getattr(health, name) for name in KEPT}}


def from_data(settings: HealthSettings, data: Values | None) -> Health:
    """
    Return the Health that to_data gave; None: nothing is known yet.

    Args:
        settings: for the next judgements.
        data: of to_data.

    Raises:
        KeyError, TypeError, ValueError: `data` are none.
    """
    if data is None:
        return Health(settings)
    health = Health(settings)
    if data['statistics']:  # none before the first window
        health = _shown(Tracker.of(settings, data['statistics']))
    return replace(health, cause=str(data['cause']), earlier=bool(data['earlier']),
                   recordings=tuple(map(str, data['recordings'])),
                   slips=tuple(Slip(int(s), *map(float, row)) for s, *row in data['slips']),
                   zeros=tuple(Zero(int(s), *map(float, row)) for s, *row in data['zeros']))
