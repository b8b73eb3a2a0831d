# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the wear of a gearbox is, in words and values: one condition, its size, one remedy."""
import math
from typing import Any

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change import GROSS, Tracker
from gearbox_monitor.health.backlash.change_tests import (
    ADVICE, ChangeTest, COMPONENTS, FRICTION, GAP, LOST_MOTION, size_name, TESTS, VISCOUS_SHARE)
from gearbox_monitor.health.backlash.features import Backlash, Friction
from gearbox_monitor.health.backlash.wear import span, when
from gearbox_monitor.health.checks.outcome import Level, Outcome


def outcomes(tracker: Tracker) -> dict[str, Outcome]:
    """Return {component: Outcome} in force of `tracker`."""
    return {component: outcome(tracker, component) for component in COMPONENTS}


def outcome(tracker: Tracker, component: str) -> Outcome:
    """Return the Outcome of a `component` of COMPONENTS in `tracker`."""
    window = tracker.window if component == 'backlash' else tracker.friction
    active = sorted((t for t in TESTS if t.component == component and t.key in tracker.changes),
                    key=lambda t: -tracker.changes[t.key].stage)
    pause = tracker.pause
    if pause is not None and pause.friction is not None and component == 'friction':
        pause = None
    if window is None and not active:
        reason = f': {pause.reason}' if pause else ': no window has ended'
        return Outcome(Level.WARN, f'{component} not measured yet{reason}; a baseline needs '
                       f'{LIMITS.min_baseline} windows')
    values = _measured(tracker, component, window) if window else {}
    level, texts = Level.OK, []
    for test in active:
        level = max(level, Level.ERROR if tracker.changes[test.key].stage == GROSS else Level.WARN)
        texts.append(_described(tracker, test, values))
    column = _leading(tracker, component)
    stale = _stale(tracker, column, pause.reason if pause else '')
    if stale:
        level = max(level, Level.WARN)
        texts.append(stale)
    elif not active:
        hidden = _hidden(tracker, column)
        if hidden:
            level = Level.WARN
            texts.append(hidden)
        else:
            texts.append(_healthy(tracker, column, window))
    if component in tracker.ended:
        texts.append(tracker.ended[component])
    values = {key: value for key, value in values.items()
              if not isinstance(value, float) or math.isfinite(value)}
    return Outcome(level, '; '.join(texts), values)


def _leading(tracker: Tracker, component: str) -> int:
    """Return the feature that a component stands for."""
    if component == 'friction':
        return FRICTION
    window = tracker.window
    return LOST_MOTION if window is not None and not window.separable else GAP


NOT_SEPARABLE = 'not separable from the new motion'
NOUN = {GAP: 'backlash', LOST_MOTION: 'lost motion', FRICTION: 'friction'}


def _stale(tracker: Tracker, column: int, reason: str) -> str:
    """Return the words for a feature that is not compared any more, '' for one that is."""
    compared = tracker.wear[column].compared_ns
    overdue = tracker.stamp_ns - compared > LIMITS.grace * tracker.settings.window * 1e9
    if compared == tracker.stamp_ns or compared and not overdue:
        return ''
    if not reason:
        reason = 'the estimates are not trusted, see the other indicators' \
            if not tracker.compared else 'not identifiable in this motion'
    since = f' since {when(compared)}' if compared else ' yet'
    return f'{NOUN[column]} not compared{since}: {reason}'


def _hidden(tracker: Tracker, column: int) -> str:
    """Return the words for a change that the new motion may hide, '' where it hides none."""
    if not tracker.wear[column].pending:
        return ''
    test = next(t for t in TESTS if t.column == column)
    growth, std = tracker.growth(column)
    if not (abs(growth) > std and abs(growth) + LIMITS.open_std * std >= tracker.limits(test)[1]):
        return ''
    return f'{NOUN[column]} {_percent(growth, std)}, {NOT_SEPARABLE}: drive the old one'


def _percent(growth: float, std: float, sign: str = '+') -> str:
    digits = 1 if std >= 0.001 else 2
    return f'{100 * growth:{sign}.{digits}f} % +- {100 * std:.{digits}f} %'


def _healthy(tracker: Tracker, column: int, window: Backlash | Friction | None) -> str:
    size = ''
    if isinstance(window, Backlash) and column != FRICTION:
        size = f' {window.gap if column == GAP else window.lost_motion:.4g} rad,'
    growth, std = tracker.growth(column)
    count, needed = tracker.point_windows(), tracker.settings.baseline_windows
    learnt = f' ({count} of {needed} baseline windows)' if count < needed else ''
    if not std < LIMITS.unknown_growth:
        return f'{NOUN[column]}{size.rstrip(",")}: learning the baseline{learnt}'
    return (f'{NOUN[column]}{size} {_percent(growth, std)} against the baseline: '
            f'no wear detected so far{learnt}')


def _measured(tracker: Tracker, component: str, window: Backlash | Friction) -> dict[str, Any]:
    base = tracker.baseline
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
        values['growth'], values['growth_std'] = tracker.growth(
            GAP if window.separable else LOST_MOTION)
    else:
        values = {'viscous_change': window.viscous, 'viscous_change_std': window.viscous_std,
                  'coulomb_change': window.coulomb, 'coulomb_change_std': window.coulomb_std,
                  'torque_gain_change': window.gain}
        values['friction_change'], values['friction_change_std'] = tracker.growth(FRICTION)
        for name, change in zip(('viscous', 'coulomb'), tracker.coefficients() or ()):
            values[f'{name}_growth'], values[f'{name}_growth_std'] = change
    if tracker.point >= 0:
        values['operating_point'] = tracker.data.points[tracker.point].text()
    values['baseline_windows'] = tracker.point_windows()
    for test in TESTS:
        if test.component == component:
            values[f'{test.key}_score'] = tracker.scores[test.key]
            values[f'{test.key}_score_threshold'] = tracker.settings.threshold(test)
            if test.key in tracker.settings.limits:
                _, warn, error = tracker.limits(test)
                name = size_name(test)
                values[f'{name}_warn'], values[f'{name}_error'] = warn, error
    values['trusted'] = tracker.trusted
    return values


def _described(tracker: Tracker, test: ChangeTest, values: dict[str, Any]) -> str:
    """Return the words for a Change and add its figures to `values`."""
    change = tracker.changes[test.key]
    _, std = tracker.growth(test.column)
    name = size_name(test)
    values[name], values[f'{name}_std'] = change.growth, std
    values[f'{name}_since'] = when(change.since_ns)
    sign = '+' if test.sign > 0 else ''  # "dropped by" says the sign itself
    text = f'{test.words} {_percent(change.growth, std, sign)} since {when(change.since_ns)}'
    if tracker.wear[test.column].pending and change.growth < LIMITS.over_std * std:
        text += f', its size {NOT_SEPARABLE}'
    coefficients = tracker.coefficients() if test.column == VISCOUS_SHARE else None
    if coefficients:
        text += ' (viscous {}, Coulomb {})'.format(*(_percent(*c) for c in coefficients))
    if test.column == FRICTION and tracker.temperature is None:
        text += ' (warm-up?)'
    _, _, error = tracker.limits(test)
    trend = tracker.trend(test.column)
    if test.key in ('gap', 'lost_motion') and change.stage < GROSS:
        reach = trend.reach(error) if trend else None
        if reach:
            values.update(zip(('forecast_s', 'forecast_earliest_s', 'forecast_latest_s'), reach))
            text += (f', limit {100 * error:+.0f} % in {span(reach[0])} ({span(reach[1])} to '
                     f'{span(reach[2])})')
        elif tracker.steady(test.column):
            text += ', steady now'
    return f'{text}: {ADVICE[test.key][change.stage - 1]}'
