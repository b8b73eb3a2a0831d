# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one judgement of wear: Health and a window in, Health out.

The live node folds its windows with `judge`; replay, report, accept and fleet fold the windows
of recordings. A state file and a baseline are a Health as `to_data` writes it.
"""
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from typing import Any

from gearbox_monitor import plain_data
from gearbox_monitor.health.backlash.change import FeatureWear, Step, Tracker
from gearbox_monitor.health.backlash.change_tests import (
    COMPONENTS, FEATURES, GAP, LOST_MOTION, ModelFriction, TESTS)
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.backlash.operating_point import Bins, OperatingPoint
from gearbox_monitor.health.backlash.wear_data import History
from gearbox_monitor.health.health_record import (
    Alert, FeatureHealth, GROSS, HealthSettings, WARNED, Window)
from gearbox_monitor.health.slip import found_in, Slip, Zero
from gearbox_monitor.kernels.types import Values

RECORDINGS, SLIPS = 1000, 100  # that are kept
OVER_LIMIT = 'gap_limit'  # stage of a backlash above that parameter, whatever the baseline
SLIP = 'slip'  # and number of the newest one


@dataclass(frozen=True, eq=False)
class Health(Tracker):
    """
    Health of one gearbox after the window that ended at `stamp_ns`, 0 before any.

    cause: as a comparison of recordings named it, or ''. recordings: that it rests on. earlier:
    whether the baseline is from before this run or recording, or was saved. slips: since the
    baseline was saved, in order of time; zeros: of the twist, see slip.found_in.
    """

    cause: str = ''
    recordings: tuple[str, ...] = ()
    earlier: bool = False
    slips: tuple[Slip, ...] = ()
    zeros: tuple[Zero, ...] = ()

    @cached_property
    def features(self) -> tuple[FeatureHealth, ...]:
        """What is known about each of FEATURES."""
        return tuple(map(self.feature_health, range(len(FEATURES))))

    def feature(self, name: str) -> FeatureHealth:
        """Return the FeatureHealth of the feature `name`, one of FEATURES."""
        return self.features[FEATURES.index(name)]

    @property
    def baseline_ns(self) -> int:
        """The first window that the baseline rests on, 0 while there is none."""
        return int(self.data.stamps[0]) if len(self.data.stamps) else 0

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


def judge(health: Health, window: Window) -> Health:
    """
    Return the Health after one more window.

    Args:
        health: before the window; it stays unchanged.
        window: the newest window; one that was judged before changes nothing.
    """
    judged = health.update(window)
    if isinstance(window.features, Backlash) and window.stamp_ns != health.stamp_ns:
        zeros, slip = found_in(health.zeros if window.counts_on else (), window.features,
                               health.settings.motor_turn)
        judged = replace(judged, zeros=zeros, slips=(
            *judged.slips, slip)[-SLIPS:] if slip else judged.slips)
    return judged if judged.alerts else replace(judged, cause='')


def folded(health: Health, windows: Iterable[Window], recording: str = '') -> Health:
    """Return the `health` after all `windows`, in order of time, of a `recording` so called."""
    health = replace(health, earlier=health.earlier or health.baseline_ns > 0)
    after = reduce(judge, windows, health)
    names = (*after.recordings, recording)[-RECORDINGS:] if recording else after.recordings
    return replace(after, recordings=names)


def accepted(health: Health) -> tuple[Health, int]:
    """
    Return `health` with the present state as the healthy one, and its number of windows.

    The wear becomes 0 with its deviation, at all operating points; all alerts end.
    """
    after, windows = health.accept()
    return replace(after, cause='', earlier=True, slips=()), windows


def serviced(health: Health, stamp_ns: int, note: str) -> Health:
    """
    Return `health` after a service: the next windows are a new baseline.

    Args:
        health: before it.
        stamp_ns: of the service.
        note: on the service, or ''.

    """
    return replace(health.served(stamp_ns, note), cause='', slips=())


CLASSES = plain_data.classes_of(
    Alert, Backlash, Bins, FeatureWear, HealthSettings, History, ModelFriction,
    NotExcited, OperatingPoint, Slip, Step, Window, Zero)


def to_data(health: Health) -> Any:
    """Return all of `health` that no settings give, as plain data; floats read back exactly."""
    return plain_data.to_data(health, leave=('settings',))


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
    health = plain_data.from_data(data, {**CLASSES, 'Health': partial(Health, settings)})
    if not isinstance(health, Health) or len(health.wear) != len(FEATURES) or (
            health.data.where.max(initial=-1) >= len(health.data.points)):
        raise ValueError('features or operating points of another version')
    return health
