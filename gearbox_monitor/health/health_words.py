# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the `Health` of a gearbox says of backlash and friction: levels, words and values."""
from collections.abc import Iterable
from dataclasses import asdict
import math
from typing import Any

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change_tests import (
    ADVICE, ChangeTest, COMPONENTS, FEATURES, FRICTION, GAIN, GAP, HYSTERESIS, LOST_MOTION,
    size_name, STIFFNESS, TESTS, VISCOUS_SHARE, WEAR)
from gearbox_monitor.health.backlash.features import Backlash, Friction
from gearbox_monitor.health.backlash.wear import span, when
from gearbox_monitor.health.checks.outcome import Level, Outcome
from gearbox_monitor.health.health_record import active_tests, GROSS, Health, OVER_LIMIT, tests_of

NOT_SEPARABLE = 'not separable from the new motion'
NOTHING_EARLIER = 'no earlier recording to compare with'
NOUNS = ('backlash', 'lost motion', 'stiffness', 'hysteresis over load', 'friction', 'torque gain',
         'share of viscous friction')
NEVER_NS = 2 ** 62  # as late as a stamp can be
SHOWN = {'backlash': (STIFFNESS, HYSTERESIS), 'friction': (GAIN, VISCOUS_SHARE)}


def outcomes(health: Health) -> dict[str, Outcome]:
    """Return {component: Outcome} of `health`."""
    return {component: outcome(health, component) for component in COMPONENTS}


def outcome(health: Health, component: str) -> Outcome:
    """Return the Outcome of a `component` of COMPONENTS in `health`."""
    window = health.backlash if component == 'backlash' else health.friction
    active = active_tests(health, component)
    pause = health.pause
    if pause is not None and pause.friction is not None and component == 'friction':
        pause = None
    if window is None and not active:
        reason = f': {pause.reason}' if pause else ': no window has ended'
        return Outcome(Level.WARN, f'{component} not measured yet{reason}; a baseline needs '
                       f'{WEAR.min_baseline} windows')
    values = _measured(health, component, window) if window else {}
    level, texts = Level.OK, []
    if component == 'backlash' and health.over_limit:
        level, texts = Level.ERROR, [
            f'backlash {health.width.level:.4g} rad exceeds {OVER_LIMIT} '
            f'{health.settings.gap_limit:.4g} rad: service the gearbox']
    if component == 'backlash' and health.slips:
        slip, values['slips'] = health.slips[-1], len(health.slips)
        values.update(slip_rad=slip.size, slip_rad_std=slip.std, slip_at=when(slip.stamp_ns))
        level = max(level, Level.WARN)
        texts.append(f'slip of {abs(slip.size):.2g} rad +- {slip.std:.1g} rad at '
                     f'{when(slip.stamp_ns)}: check clutch, hub and couplings')
    for test in active:
        level = max(level, Level.ERROR if health.alerts[test.key].stage == GROSS else Level.WARN)
        texts.append(_described(health, test, values))
    column = _leading(health, component)
    doubt = _stale(health, column, pause.reason if pause else '') or (
        '' if active else _hidden(health, (column, *SHOWN[component])))
    if doubt:
        level = max(level, Level.WARN)
        texts.append(doubt)
    elif component == 'friction' and health.settings.follows_curve and not texts \
            and {'gap', 'lost_motion'} & health.alerts.keys():
        texts.append('friction not judged: the elastic curve of the model has the backlash of '
                     'before')
    elif not texts:
        level, text = _healthy(health, column, window)
        texts.append(text)
    if active and health.cause:
        values['cause'] = health.cause
    if component in health.ended:
        texts.append(health.ended[component])
    if component == 'backlash' and health.marks:
        texts.append(f'{when(health.marks[-1][0])}: {health.marks[-1][1]}')
    values = {key: value for key, value in values.items()
              if not isinstance(value, float) or math.isfinite(value)}
    return Outcome(level, '; '.join(texts), values)


def worst(states: Iterable[tuple[int, str, str]]) -> tuple[Level, str]:
    """Return (level, sentence) of the worst of `states` (level, component, message)."""
    level, _, message = max(states, key=lambda state: (state[0], state[1] == 'backlash'))
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


def _stale(health: Health, column: int, reason: str) -> str:
    """Return the words for a feature that is not compared any more, '' for one that is."""
    compared = health.features[column].compared_ns
    overdue = health.stamp_ns - compared > LIMITS.grace * health.settings.window * 1e9
    if compared == health.stamp_ns or compared and not overdue:
        return ''
    if not reason:
        reason = 'the estimates are not trusted, see the other indicators' \
            if not health.compared else 'not identifiable in this motion'
    since = f' since {when(compared)}' if compared else ' yet'
    return f'{NOUNS[column]} not compared{since}: {reason}'


def _hidden(health: Health, columns: tuple[int, ...]) -> str:
    """Return the words for a change that the new motion may hide, '' where it hides none."""
    for column in columns:
        feature, warn = health.features[column], health.limits(tests_of(column)[0])[1]
        if feature.is_open and abs(feature.change) > feature.change_std and abs(
                feature.change) + LIMITS.hides_std * feature.change_std >= warn:
            return (f'{NOUNS[column]} {_percent(feature.change, feature.change_std)}, '
                    f'{NOT_SEPARABLE}: drive the old one')
    return ''


def _percent(growth: float, std: float, sign: str = '+') -> str:
    digits = 1 if std >= 0.001 else 2
    return f'{100 * growth:{sign}.{digits}f} % +- {100 * std:.{digits}f} %'


def _healthy(health: Health, column: int, window: Backlash | Friction | None
             ) -> tuple[Level, str]:
    """Return (level, words) for a feature without a change."""
    feature, noun, size = health.features[column], NOUNS[column], ''
    if isinstance(window, Backlash) and column != FRICTION:
        size = f' {window.gap if column == GAP else window.lost_motion:.4g} rad'
    count, needed = health.point_windows, health.settings.baseline_windows
    learnt = f' ({count} of {needed} baseline windows)' if count < needed else ''
    warn = health.limits(tests_of(column)[0])[1]
    learning = bool(learnt) and not health.earlier
    if not LIMITS.open_std * feature.change_std < warn:
        if count >= LIMITS.resolved and feature.change_std < LIMITS.unknown_growth:
            return Level.WARN, (
                f'{noun}{size}: its change is not known to better than '
                f'{100 * feature.change_std:.0f} %: repeat the motion of the baseline')
        learning = True
    elif feature.newest:
        return Level.OK, (f'{noun}{size}, {100 * feature.newest:+.1f} % in the newest window: '
                          'the next one decides')
    if learning and size and not health.earlier:
        return Level.OK, _against_model(f'{noun}{size}', health, column)
    if learning:
        return Level.OK, f'{noun}{size}: learning the baseline{learnt}'
    return Level.OK, (f'{noun}{size}{"," * bool(size)} '
                      f'{_percent(feature.change, feature.change_std)} against the baseline: '
                      f'no wear detected so far{learnt}')


def _against_model(words: str, health: Health, column: int) -> str:
    """Return `words` and how far the backlash of the newest window is off the model file."""
    stated = 2.0 * health.settings.half_gap
    if column == GAP and stated > 0.0 and health.backlash:
        off = 100.0 * (health.backlash.gap / stated - 1.0)
        words += (', as in' if abs(off) < 0.5 else
                  f', {abs(off):.0f} % {"above" if off > 0.0 else "below"}') + ' the model file'
    return f'{words}: {NOTHING_EARLIER}'


def _measured(health: Health, component: str, window: Backlash | Friction) -> dict[str, Any]:
    values: dict[str, Any]
    if isinstance(window, Backlash) and component == 'backlash':
        values = {
            'gap_rad': window.gap, 'gap_std_rad': window.gap_std,
            'gap_arcmin': math.degrees(window.gap) * 60.0,
            'stiffness': window.stiffness, 'stiffness_std': window.stiffness_std,
            'hysteresis': window.hysteresis, 'hysteresis_std': window.hysteresis_std,
            'lost_motion_rad': window.lost_motion, 'separable': window.separable,
            'flank': window.flank, 'coverage': window.coverage,
            'baseline_gap_rad': health.features[GAP].baseline,
            'baseline_stiffness': health.features[STIFFNESS].baseline}
        values['growth'], values['growth_std'] = health.width.change, health.width.change_std
    else:
        values = {'viscous_change': window.viscous, 'viscous_change_std': window.viscous_std,
                  'coulomb_change': window.coulomb, 'coulomb_change_std': window.coulomb_std,
                  'torque_gain_change': window.gain}
        values['friction_change'], values['friction_change_std'] = health.growth(FRICTION)
        for name, change in zip(('viscous', 'coulomb'), health.coefficients):
            values[f'{name}_growth'], values[f'{name}_growth_std'] = change
    if health.point:
        values['operating_point'] = health.point
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


def _described(health: Health, test: ChangeTest, values: dict[str, Any]) -> str:
    """Return the words for an Alert and add its figures to `values`."""
    alert, feature = health.alerts[test.key], health.features[test.column]
    std, name = feature.change_std, size_name(test)
    values[name], values[f'{name}_std'] = alert.growth, std
    values[f'{name}_since'] = when(alert.since_ns)
    sign = '+' if test.sign > 0 else ''  # "dropped by" says the sign itself
    text = f'{test.words} {_percent(alert.growth, std, sign)} since {when(alert.since_ns)}'
    if feature.is_open and alert.growth < LIMITS.open_std * std:
        text += f', its size {NOT_SEPARABLE}'
    if test.column == VISCOUS_SHARE and health.coefficients:
        text += ' (viscous {}, Coulomb {})'.format(
            *(_percent(*change) for change in health.coefficients))
    if test.column == FRICTION and health.temperature is None:
        text += ' (warm-up?)'
    if test.key in ('gap', 'lost_motion') and alert.stage < GROSS:
        if feature.reach:
            reach = feature.reach
            values.update(zip(('forecast_s', 'forecast_earliest_s', 'forecast_latest_s'), reach))
            text += (f', limit {100 * health.limits(test)[2]:+.0f} % in {span(reach[0])} '
                     f'({span(reach[1])} to {span(reach[2])})')
        elif feature.steady:
            text += ', steady now'
    return f'{text}: {ADVICE[test.key][alert.stage - 1]}'
