# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one judgement of wear: Health and a window in, Health and its Outcomes out.

The live node folds its windows with `judge`; replay, report, accept and fleet fold the windows
of recordings. A state file and a baseline are a Health as `to_data` writes it.

A slip: motor and arm have moved against each other by a step that the backlash does not allow.
Where a clutch, hub or coupling slips, both flanks move by the same angle, and with them the zero
of the twist; a wider gap, on one flank alone, moves the zero by half of what it grows. Encoders
that restart begin another comparison, and a whole turn of one is no slip.

`outcomes` makes of a Health what is said: levels, codes and numbers.
"""
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial, reduce
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor import plain_data
from gearbox_monitor.health.alarms import Group, Level, LIMITS, Outcome
from gearbox_monitor.health.backlash.change import FeatureWear, RECENT, Step, Tracker
from gearbox_monitor.health.backlash.change_tests import (
    ChangeTest, COMPONENTS, FEATURES, FRICTION, GAP, LOST_MOTION, ModelFriction, size_name,
    STIFFNESS, TESTS, tests_of, VISCOUS_SHARE, WEAR, WEAR_FEATURES)
from gearbox_monitor.health.backlash.features import Backlash, NotExcited, width_of
from gearbox_monitor.health.backlash.wear import History, span, when
from gearbox_monitor.health.health_record import (
    Alert, Bins, FeatureHealth, GROSS, HealthSettings, OperatingPoint, WARNED, Window)
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.presentation import percent, Quantity, Said


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
# Codes of messages that something has changed for good.
CHANGED = frozenset((OVER_LIMIT, SLIP, *(f'{test.key}_{stage}' for test in TESTS
                                         for stage in (1, 2, 3))))


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


NOUNS = tuple(feature.noun for feature in WEAR_FEATURES)
OF_WINDOWS = {component: tuple(  # features, published by the names of their fields
    feature for feature in WEAR_FEATURES
    if feature.component == component and feature.unit not in ('', 'rad'))
    for component in COMPONENTS}
NEVER_NS = 2 ** 62  # as late as a stamp can be
LEADING = (GAP, LOST_MOTION, FRICTION)  # the others of a component stand beside
SHOWN = {component: tuple(
    column for column, feature in enumerate(WEAR_FEATURES)
    if feature.component == component and column not in LEADING) for component in COMPONENTS}


def outcomes(health: Health) -> dict[str, Outcome]:
    """Return {component: Outcome} of `health`."""
    return {component: outcome(health, component) for component in COMPONENTS}


def outcome(health: Health, component: str) -> Outcome:
    """Return the Outcome of a `component` of COMPONENTS in `health`."""
    window = health.backlash if component == 'backlash' else health.friction
    active = sorted((test for test in TESTS
                     if test.component == component and test.key in health.alerts),
                    key=lambda test: -health.alerts[test.key].stage)    # the worst first
    pause = health.pause
    if pause is not None and pause.friction is not None and component == 'friction':
        pause = None
    if window is None and not active:
        return Outcome.of(Level.WARN, f'{component}_unmeasured', needed=WEAR.min_baseline,
                          why=(pause.said if pause else Said('no_window'),))
    values = _measured(health, component, window) if window else {}
    says: list[Group] = []
    if component == 'backlash':
        says = _of_width_and_slips(health, values)
    says += [(_described(health, test, values),) for test in active]
    column = _leading(health, component)
    doubt = _stale(health, column, (pause.said,) if pause else ()) or (
        None if active else _hidden(health, (column, *SHOWN[component])))
    if doubt:
        says.append((doubt,))
    elif component == 'friction' and health.settings.follows_curve and not says \
            and {'gap', 'lost_motion'} & health.alerts.keys():
        says.append((Said('follows_curve'),))
    elif not says:
        says.append((_healthy(health, column, window),))
    says.sort(key=lambda group: -group[0].level)
    level = Level(says[0][0].level)
    if active and health.cause:
        values['cause'] = health.cause
    says += _of_the_past(health, component)
    values = {key: value for key, value in values.items()
              if not isinstance(value, float) or math.isfinite(value)}
    return Outcome(level, tuple(says), values)


def _of_the_past(health: Health, component: str) -> list[Group]:
    """Return the ended alerts of a `component`, and the newest mark beside its backlash."""
    says: list[Group] = [(Said(f'{test}_over' if test else 'saved', {'size': percent(size)}),)
                         for test, size in health.ended.get(component, ())]
    marks = health.marks[-1:] if component == 'backlash' else ()
    return says + [(Said('mark', {'since': when(stamp_ns), 'note': note}),)
                   for stamp_ns, note in marks]


def _of_width_and_slips(health: Health, values: dict[str, Any]) -> list[Group]:
    """Return what the limit of the backlash and slips say; put the newest into `values`."""
    says: list[Group] = []
    if health.over_limit:
        width = health.width
        says.append((Said('over_limit', {
            'size': width_of(width.level, width.level_std),
            'limit': health.settings.gap_limit}, Level.ERROR),))
    if health.slips:
        slip, values['slips'] = health.slips[-1], len(health.slips)
        values.update(slip_rad=slip.size, slip_rad_std=slip.std, slip_at=when(slip.stamp_ns))
    return says + [(slip,) for slip in said_of_slips(health)]


def said_of_slips(health: Health) -> list[Said]:
    """Return the newest slip in `health`, and one that its newest window alone shows."""
    says = [Said('slip', {'size': Quantity(abs(slip.size), slip.std, 'rad'),
                          'at': when(slip.stamp_ns)}, Level.WARN) for slip in health.slips[-1:]]
    if len(health.zeros) > 1:
        before, after = health.zeros
        says.append(Said('slip_unsure', {
            'size': Quantity(abs(after.value - before.value), math.hypot(after.std, before.std),
                             'rad'), 'since': when(before.stamp_ns)}, Level.WARN))
    return says


def sentence(health: Health) -> tuple[Level, str]:
    """Return (level, sentence) of `health`: the same ones at every door."""
    _, worst = max(outcomes(health).items(), key=lambda item: (
        item[1].level, not CHANGED.isdisjoint(item[1].codes), item[0] == 'backlash'))
    return worst.level, worst.message.split('; ')[0]


def figures(health: Health) -> dict[str, Any]:
    """Return `health` as plain data, with None for what is not known."""
    def known(value: float) -> float | None:
        return float(value) if math.isfinite(value) else None
    level, summary = sentence(health)
    return {
        'level': level.name, 'summary': summary,
        'feature': 'gap' if health.separable else 'lost_motion',
        'features': {name: {
            **{key: known(getattr(feature, key)) for key in (
                'level', 'level_std', 'baseline', 'baseline_std', 'change', 'change_std', 'rate',
                'rate_std')},
            'compared_ns': feature.compared_ns,
            'limit_ns': [min(health.stamp_ns + round(s * 1e9), NEVER_NS) if math.isfinite(s) else
                         None for s in feature.reach or ()]}
            for name, feature in zip(FEATURES, health.features)},
        'alerts': {test: asdict(alert) for test, alert in health.alerts.items()},
        'limit': health.limits(tests_of(GAP)[0])[2], 'marks': [list(m) for m in health.marks],
        'slips': [list(slip) for slip in health.slips],
        'cause': health.cause, 'baseline_ns': health.baseline_ns, 'stamp_ns': health.stamp_ns,
        'recordings': list(health.recordings)}


def _leading(health: Health, component: str) -> int:
    """Return the feature that a component stands for."""
    if component == 'friction':
        return FRICTION
    return GAP if health.separable else LOST_MOTION


def _stale(health: Health, column: int, reason: Group) -> Said | None:
    """Return the Said of a feature that is no longer compared, None for one that is."""
    compared = health.features[column].compared_ns
    overdue = health.stamp_ns - compared > LIMITS.grace * health.settings.window * 1e9
    if compared == health.stamp_ns or compared and not overdue:
        return None
    reasons = reason or (Said('not_identifiable' if health.compared else 'untrusted'),)
    since = f' since {when(compared)}' if compared else ' yet'
    return Said('not_compared', {'noun': NOUNS[column], 'since': since, 'why': reasons},
                Level.WARN)


def _hidden(health: Health, columns: tuple[int, ...]) -> Said | None:
    """Return the Said of a change that the new motion may hide, None for none."""
    for column in columns:
        feature, warn = health.features[column], health.limits(tests_of(column)[0])[1]
        if feature.is_open and abs(feature.change) > feature.change_std and abs(
                feature.change) + LIMITS.hides_std * feature.change_std >= warn:
            return Said('may_hide', {
                'noun': NOUNS[column], 'size': percent(feature.change, feature.change_std)},
                Level.WARN)
    return None


def _healthy(health: Health, column: int, window: Backlash | None) -> Said:
    """Return the Said of a feature without a change."""
    feature = health.features[column]
    size: tuple[Said, ...] = ()
    if isinstance(window, Backlash) and column != FRICTION:
        size = (Said('width', {'size': width_of(window.gap, window.gap_std) if column == GAP else
                               width_of(window.lost_motion, window.lost_motion_std)}),)
    numbers = {'noun': NOUNS[column], 'width': size, 'comma': ',' * bool(size)}
    count, needed = health.point_windows, health.settings.baseline_windows
    learnt = (Said('learnt', {'count': count, 'needed': needed}),) if count < needed else ()
    warn = health.limits(tests_of(column)[0])[1]
    learning = bool(learnt) and not health.earlier
    if not LIMITS.open_std * feature.change_std < warn:
        if count >= RECENT and feature.change_std < WEAR.step_std:
            return Said('unresolved', {**numbers, 'std': percent(feature.change_std)}, Level.WARN)
        learning = True
    elif feature.newest:
        return Said('newest', {**numbers, 'size': percent(feature.newest)})
    if learning and size and not health.earlier:
        return Said('alone', {**numbers, 'model': _against_model(health, column)})
    if learning:
        return Said('learning', {**numbers, 'learnt': learnt})
    return Said('unchanged', {**numbers, 'learnt': learnt,
                              'size': percent(feature.change, feature.change_std)})


def _against_model(health: Health, column: int) -> tuple[Said, ...]:
    """Return how far the backlash of the newest window is off the model file."""
    stated = 2.0 * health.settings.half_gap
    if column != GAP or not stated > 0.0 or not health.backlash:
        return ()
    off = health.backlash.gap / stated - 1.0
    std = math.hypot(health.backlash.gap_std / stated, LIMITS.gap_error)
    if abs(off) < 0.5 * LIMITS.gap_error:
        return (Said('as_model'),)
    return (Said('off_model', {'size': percent(abs(off), std),
                               'side': 'above' if off > 0.0 else 'below'}),)


def _measured(health: Health, component: str, window: Backlash) -> dict[str, Any]:
    values: dict[str, Any] = {
        f.name + std: getattr(health.backlash, f.name + std)
        for f in OF_WINDOWS[component] if health.backlash for std in ('', '_std')}
    if isinstance(window, Backlash) and component == 'backlash':
        values |= {
            'gap_rad': window.gap, 'gap_std_rad': window.gap_std,
            'gap_arcmin': math.degrees(window.gap) * 60.0, 'lost_motion_rad': window.lost_motion,
            **{name: getattr(window, name) for name in ('separable', 'flank', 'coverage')},
            'baseline_gap_rad': health.features[GAP].baseline,
            'baseline_stiffness': health.features[STIFFNESS].baseline,
            'growth': health.width.change, 'growth_std': health.width.change_std}
    else:
        values |= {'viscous_change': window.viscous, 'viscous_change_std': window.viscous_std,
                   'coulomb_change': window.coulomb, 'coulomb_change_std': window.coulomb_std,
                   'torque_gain_change': window.gain}
        values['friction_change'], values['friction_change_std'] = health.growth(FRICTION)
        for name, change in zip(('viscous', 'coulomb'), health.coefficients):
            values[f'{name}_growth'], values[f'{name}_growth_std'] = change
    if health.point >= 0:
        values['operating_point'] = health.data.points[health.point].text()
    values['baseline_windows'] = health.point_windows
    if health.baseline_ns:
        values['baseline_since'] = when(health.baseline_ns)
    for test in TESTS:
        if test.component == component:
            values[f'{test.key}_score'] = health.scores.get(test.key, 0.0)
            values[f'{test.key}_score_threshold'] = health.settings.threshold
            if test.key in health.settings.limits:
                _, warn, error = health.limits(test)
                name = size_name(test)
                values[f'{name}_warn'], values[f'{name}_error'] = warn, error
    values['trusted'] = health.trusted
    return values


def _described(health: Health, test: ChangeTest, values: dict[str, Any]) -> Said:
    """Return the Said of an Alert, and add its figures to `values`."""
    alert, feature = health.alerts[test.key], health.features[test.column]
    std, name, additions = feature.change_std, size_name(test), list[Said]()
    values[name], values[f'{name}_std'] = alert.growth, std
    values[f'{name}_since'] = when(alert.since_ns)
    if feature.is_open and alert.growth < LIMITS.open_std * std:
        additions.append(Said('open_size'))
    if test.column == VISCOUS_SHARE and health.coefficients:
        additions.append(Said('parts', {part: percent(*change) for part, change in zip(
            ('viscous', 'coulomb'), health.coefficients)}))
    if test.column == FRICTION and health.temperature is None:
        additions.append(Said('warm_up'))
    if test.key in ('gap', 'lost_motion') and alert.stage < GROSS:
        if feature.reach:
            reach = feature.reach
            values.update(zip(('forecast_s', 'forecast_earliest_s', 'forecast_latest_s'), reach))
            additions.append(Said('reach' if reach[1] >= 1.0 else 'reach_soon', {
                'limit': percent(health.limits(test)[2]),
                **dict(zip(('expected', 'earliest', 'latest'), map(span, reach)))}))
        elif feature.steady:
            additions.append(Said('steady'))
    return Said(f'{test.key}_{alert.stage}', {
        'size': percent(abs(alert.growth), std), 'since': when(alert.since_ns),
        'more': tuple(additions)}, Level.ERROR if alert.stage == GROSS else Level.WARN)
