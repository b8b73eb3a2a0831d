# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one judgement of wear: Health and a window in, Health out.

The live node folds its windows with `judge`; replay, report, accept and fleet fold the windows
of recordings. A state file and a baseline are a Health as `to_data` writes it.

A slip: motor and arm have moved against each other by a step that the backlash does not allow.
Where a clutch, hub or coupling slips, both flanks move by the same angle, and with them the zero
of the twist; a wider gap, on one flank alone, moves the zero by half of what it grows. Encoders
that restart begin another comparison, and a whole turn of one is no slip.
"""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor import plain_data
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change import FeatureWear, Step, Tracker
from gearbox_monitor.health.backlash.change_tests import (
    COMPONENTS, FEATURES, GAP, LOST_MOTION, ModelFriction, TESTS)
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.backlash.operating_point import Bins, OperatingPoint
from gearbox_monitor.health.backlash.wear_data import History
from gearbox_monitor.health.health_record import (
    Alert, FeatureHealth, GROSS, HealthSettings, WARNED, Window)
from gearbox_monitor.kernels.types import Array, Values


class Slip(NamedTuple):
    """A step of the twist at `stamp_ns`, its size and standard deviation (rad), + of the motor."""

    stamp_ns: int
    size: float
    std: float


class Zero(NamedTuple):
    """
    Zero of the twist in the window that ends at `stamp_ns`, rad, with its deviation.

    gap: rad. room: by how much the zero may move with load and motion, rad.
    """

    stamp_ns: int
    value: float
    std: float
    gap: float
    room: float

    @classmethod
    def of(cls, window: Backlash) -> 'Zero':
        """Return the zero in a `window`."""
        return cls(window.stamp_ns, window.zero, window.gap_std, window.gap,
                   LIMITS.slip_room * (window.gap + window.load / window.stiffness))

    def moved(self, before: 'Zero', turn: float) -> bool:
        """Return whether it has moved since `before`, by no `turn` (rad) of an encoder, 0: any."""
        off = abs(self.value - before.value)
        past = 0.5 * abs(self.gap - before.gap) + max(self.room, before.room) \
            + LIMITS.contradicted * math.hypot(self.std, before.std)
        return off > past and not any(
            abs(off - whole * t) <= past for t in (turn, 2.0 * math.pi) if t > 4.0 * past
            for whole in (max(round(off / t), 1),))


def found_in(zeros: tuple[Zero, ...], window: Backlash, turn: float
             ) -> tuple[tuple[Zero, ...], Slip | None]:
    """
    Return the zeros to compare the next window with, and the slip that `window` confirms, if any.

    Two windows in a row must be off on the same side: the window of the slip itself is mixed. It
    hardly knows its zero, and is no reference: that is one whose zero is known better than load
    and motion move it, or than the previous one.

    Args:
        zeros: the reference, and the newest one if it has moved.
        window: the newest one; its encoders count from where they did for `zeros`.
        turn: of the motor on the arm side, rad; 0: none.

    """
    new = Zero.of(window)
    if not (window.separable and math.isfinite(new.value + new.std)):
        return zeros, None
    if not zeros:
        return (new,), None
    if not new.moved(zeros[0], turn):
        known = LIMITS.contradicted * new.std <= new.room or new.std <= zeros[0].std
        return (new,) if known else zeros[:1], None
    before, first = zeros[0], zeros[-1]
    size = new.value - before.value
    if first is before or size * (first.value - before.value) < 0.0:
        return (before, new), None
    return (new,), Slip((before.stamp_ns + first.stamp_ns) // 2, size,
                        math.hypot(new.std, before.std))


RECORDINGS, SLIPS = 1000, 100  # that are kept
OVER_LIMIT = 'gap_limit'  # stage of a backlash above that parameter, whatever the baseline
SLIP = 'slip'  # and number of the newest one


@dataclass(frozen=True, eq=False)
class Health(Tracker):
    """
    Health of one gearbox after the window that ended at `stamp_ns`, 0 before any.

    cause: as a comparison of recordings named it, or ''. recordings: that it rests on. earlier:
    whether the baseline is from before this run or recording, or was saved. slips: since the
    baseline was saved, in order of time; zeros: of the twist, see found_in.
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
    since = max((f.found[-1] for f in health.wear if f.found), default=-1)
    windows = sum(health.data.count(k, since) for k in range(len(health.data.points)))
    return replace(health.accepted(), cause='', earlier=True, slips=()), windows


def serviced(health: Health, stamp_ns: int, note: str) -> Health:
    """
    Return `health` after a service: the next windows are a new baseline.

    Args:
        health: before it.
        stamp_ns: of the service.
        note: on the service, or ''.

    """
    health = replace(health, cause='', slips=(), marks=(*health.marks, (
        stamp_ns, f'serviced, {note}' if note else 'serviced')))
    stamps = health.data.stamps
    return health.accepted(max(stamp_ns, int(stamps[-1]))) if len(stamps) else health


CLASSES = plain_data.classes_of(
    Alert, Backlash, Bins, FeatureWear, HealthSettings, History, ModelFriction,
    NotExcited, OperatingPoint, Slip, Step, Window, Zero)


def to_data(health: Health) -> Any:
    """Return all of `health` that no settings give, as plain data; floats read back exactly."""
    return {**plain_data.to_data(health, leave=('settings',)), 'features': list(FEATURES)}


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
    names = data.get('features', FEATURES)
    health = plain_data.from_data({key: part for key, part in data.items() if key != 'features'},
                                  {**CLASSES, 'Health': partial(Health, settings)})
    if not isinstance(health, Health) or len(health.wear) != len(names) or (
            health.data.where.max(initial=-1) >= len(health.data.points)):
        raise ValueError('features or operating points of another version')
    return health if tuple(names) == FEATURES else _by_name(health, names)


def _by_name(health: Health, names: Sequence[str]) -> Health:
    """Return a `health` of the features `names` as one of FEATURES; of others nothing is known."""
    column = [names.index(name) if name in names else -1 for name in FEATURES]  # -1: appended

    def row(values: Any, unknown: float = 0.0) -> Array:
        return np.append(values, unknown)[column]

    def table(values: Array) -> Array:
        return np.pad(values, ((0, 1), (0, 1)))[np.ix_(column, column)]

    data, keys = health.data, {test.key for test in TESTS}
    points = tuple(replace(
        p, previous=row(p.previous, math.nan), stated=row(p.stated), freedom=row(p.freedom),
        stated_count=row(p.stated_count), squares=row(p.squares)) for p in data.points)
    return replace(
        health, wear=tuple((*health.wear, FeatureWear())[k] for k in column),
        levels=tuple(row(health.levels, math.nan).tolist()),
        level_stds=tuple(row(health.level_stds, math.nan).tolist()),
        scores={key: health.scores.get(key, 0.0) for key in keys},
        alerts={key: alert for key, alert in health.alerts.items() if key in keys},
        data=replace(
            data, points=points, slopes=row(data.slopes), spread=row(data.spread, math.nan),
            sums=np.pad(data.sums, ((0, 0), (0, 0), (0, 1)))[:, :, column],
            reference=row(data.reference, math.nan), products=table(data.products),
            differences=table(data.differences)))
