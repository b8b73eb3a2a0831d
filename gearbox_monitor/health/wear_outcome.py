# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The Outcomes of backlash and friction that a `Health` gives: levels, codes and numbers."""
from collections.abc import Iterable
from dataclasses import asdict
import math
from typing import Any

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change import RECENT
from gearbox_monitor.health.backlash.change_tests import (
    ChangeTest, COMPONENTS, FEATURES, FRICTION, GAP, LOST_MOTION, size_name, STIFFNESS,
    TESTS, tests_of, VISCOUS_SHARE, WEAR, WEAR_FEATURES)
from gearbox_monitor.health.backlash.features import Backlash, width_of
from gearbox_monitor.health.backlash.wear import span, when
from gearbox_monitor.health.checks.outcome import Group, Level, Outcome
from gearbox_monitor.health.health_record import GROSS
from gearbox_monitor.health.judgement import Health
from gearbox_monitor.presentation import percent, Quantity, Said

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
    level = Level(max(group[0].level for group in says))
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


def worst(states: Iterable[tuple[Any, ...]]) -> tuple[Level, str]:
    """Return (level, sentence) of the worst of `states` (level, component, message, ...)."""
    level, _, message, *_ = max(states, key=lambda state: (state[0], state[1] == 'backlash'))
    return Level(level), message.split('; ')[0]


def sentence(health: Health) -> tuple[Level, str]:
    """Return (level, sentence) of `health`: the same ones at every door."""
    return worst((outcome.level, name, outcome.message)
                 for name, outcome in outcomes(health).items())


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
