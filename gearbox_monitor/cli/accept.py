# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Accept or reject a gearbox: check backlash and stiffness from a bag against limits.

The bag is run through the estimator as "replay" does; torque over twist is fitted on windows of
drift_window seconds, and the windows are combined. Gap and limits are at the output. A limit is
met or missed with probability --confidence; the uncertainty contains the spread of the windows and
the error of the method, 1 % of the gap and 2 % of the stiffness.

If the motion cannot distinguish backlash from compliance (slow motion against friction), the lost
motion is tested in its place: the gap is no larger, so the gearbox can pass, but not fail.

A lost-motion test counts as well: the input locked, a torque on the output that goes to and fro
and is recorded as effort of the arm (or as the motor's, where that holds the input).

usage examples:
  gearbox_monitor accept BAG --max-gap 0.21
  gearbox_monitor accept BAG --max-gap 30arcmin --min-stiffness 20 --confidence 0.99
  gearbox_monitor accept BAG --model drive.yaml --params estimator.yaml --max-gap 0.5deg --json
"""
from argparse import Namespace
from collections.abc import Mapping, Sequence
import math
import re
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.cli.options import (
    entries, estimator_options, opened, show, warn, wrapped)
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.features import (
    Backlash, combine, NotExcited, reason_of, separable_of)
from gearbox_monitor.health.backlash.locked_input import is_locked, locked_windows
from gearbox_monitor.health.wear_outcome import said_of_slips
from gearbox_monitor.presentation import number, on_axis, Quantity, Said, said
from gearbox_monitor.recordings.replay import Replay, replay
from gearbox_monitor.report.sentences import told

UNITS = {'rotary': {'rad': 1.0, 'mrad': 1e-3, 'deg': math.radians(1.0),
                    'arcmin': math.radians(1.0) / 60.0},
         'prismatic': {'m': 1.0, 'mm': 1e-3, 'um': 1e-6}}
INSEPARABLE = said('inseparable')
EXIT = {'pass': 0, 'fail': 1, 'not excited': 3, 'undecided': 3}


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    unit, max_gap = limit_of(args.max_gap) if args.max_gap else ('', None)
    limits = {'max_gap': max_gap, 'min_stiffness': args.min_stiffness}
    if args.min_stiffness is not None and not 0.0 < args.min_stiffness < math.inf:
        raise InputError(f'--min-stiffness: {args.min_stiffness:g}, expected a number > 0 (N m/'
                         'rad)')
    if not 0.5 <= args.confidence < 1.0:
        raise InputError(f'--confidence: {args.confidence:g}, expected a number >= 0.5 and < 1')
    if all(v is None for v in limits.values()):
        raise InputError('no limit, expected --max-gap or --min-stiffness')
    parameters, model_file = estimator_options(args)
    with opened(args) as reader:
        result = replay(reader, load_model(model_file) if model_file else None, parameters,
                        args.topic)
    notes = result.summary['notes']
    model = result.estimator.model
    if unit and unit not in UNITS[model.axis]:
        raise InputError(f'--max-gap: {args.max_gap!r}, expected a limit in '
                         f'{", ".join(UNITS[model.axis])}: the axis of the model is {model.axis}')
    data = {'bag': str(args.bag), 'unit': unit or next(iter(UNITS[model.axis])), **limits,
            'confidence': args.confidence,
            **judge(windows(result), limits, args.confidence,
                    said_of_slips(result.monitor.health)), 'notes': notes}
    data = {**told([says(data, model.axis)]), **data}
    warn(args, notes)
    show(args, data, lambda: text(data, model.axis))
    return EXIT[data['verdict']]


def limit_of(word: str) -> tuple[str, float]:
    """
    Return (unit, '' without one; limit in rad or m) of `word`.

    Raises InputError: no number above 0, or an unknown unit.
    """
    match = re.fullmatch(r'\s*([-+.0-9eE]+)\s*([a-z]*)\s*', word)
    factors = UNITS['rotary'] | UNITS['prismatic'] | {'': 1.0}
    unit = match[2] if match else ''
    try:
        value = float(match[1]) * factors.get(unit, math.nan) if match else math.nan
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        rotary, prismatic = (', '.join(units) for units in UNITS.values())
        raise InputError(f'--max-gap: {word!r}, expected a number > 0 with {rotary} (prismatic '
                         f'axis: {prismatic}), or nothing for rad (m)')
    return unit, value


def windows(result: Replay) -> Sequence[Backlash | NotExcited]:
    """Return the features of each window of the replay `result`, or of a lost-motion test."""
    if is_locked(result.samples):
        return locked_windows(result.samples)
    return result.monitor.all_features()


def judge(fits: Sequence[Any], limits: Mapping[str, float | None],
          confidence: float, slips: Sequence[Said] = ()) -> dict[str, Any]:
    """
    Return the verdict on a gearbox as plain data.

    Args:
        fits: Backlash or NotExcited of each window.
        limits: {'max_gap': rad or None, 'min_stiffness': N m/rad or None}.
        confidence: probability that a verdict needs.
        slips: of clutch, hub or coupling; no gearbox with one passes.

    Returns:
        'verdict', 'reason', the measured values with their deviations, probabilities.

    """
    used, separable = separable_of(fits)
    data: dict[str, Any] = {'windows': len(fits), 'windows_used': len(used)}
    if not used:
        reason = reason_of(fits)
        return {'verdict': 'not excited', 'reason': str(reason), 'codes': [reason.code], **data}
    gap = combine(used, 'gap', LIMITS.gap_error)
    stiffness = combine(used, 'stiffness', LIMITS.stiffness_error)
    hysteresis = combine(used, 'hysteresis')
    lost_motion = combine(used, 'lost_motion', LIMITS.gap_error)
    measured = {'gap_rad': gap, 'stiffness': stiffness, 'hysteresis': hysteresis,
                'lost_motion_rad': lost_motion}
    data |= {name + end: number for name, value in measured.items() if value
             for end, number in (('', value.value), ('_std', value.std))}
    data['gap_arcmin'] = math.degrees(data['gap_rad']) * 60.0
    data['gap_arcmin_std'] = math.degrees(data['gap_rad_std']) * 60.0
    data['separable'] = separable
    data['crossings'] = float(np.mean([w.coverage for w in used]))
    met, missed, reasons = [], [], list[Said]()
    tests = []  # key, noun, probability that the limit is met, may it pass, why not if inseparable
    if limits['max_gap'] is not None:
        width = gap if separable else lost_motion
        p = _below(width, limits['max_gap']) if width else 0.5
        tests.append(('gap', 'backlash', p, True, said('lost_motion_exceeds')))
    if limits['min_stiffness'] is not None:
        p = 1.0 - _below(stiffness, limits['min_stiffness'])
        tests.append(('stiffness', 'stiffness', p, separable, INSEPARABLE))
    for key, noun, p, may_pass, inseparable in tests:
        data[f'probability_{key}'] = p
        met.append(may_pass and p >= confidence)
        missed.append(separable and 1.0 - p >= confidence)
        if not met[-1] and not missed[-1]:
            reasons.append(said('too_close', noun=noun) if separable else inseparable)
    for slip in slips:
        met.append(False)
        missed.append(slip.code == 'slip')
        reasons.append(said('slipping', slip=slip, todo=slip.remedy))
    verdict = ('fail' if any(missed) else 'pass' if all(met) else
               'undecided' if separable else 'not excited')
    reasons = reasons or [INSEPARABLE] * (not separable)
    return {'verdict': verdict, 'reason': '; '.join(map(str, reasons)),
            'codes': [reason.code for reason in reasons], **data}


def _below(combined: Any, limit: float) -> float:
    """Return the probability that the value lies below `limit`."""
    if combined.std <= 0.0:
        return float(combined.value <= limit)
    return float(scipy.stats.norm.cdf((limit - combined.value) / combined.std))


SIZES = {  # whether the motion tells backlash from compliance: value, its code, its limit
    True: (('gap_rad', 'backlash_is', 'max_gap', 'at_most'),
           ('stiffness', 'stiffness_is', 'min_stiffness', 'at_least')),
    False: (('lost_motion_rad', 'lost_motion_is', 'max_gap', 'at_most'),)}


def says(data: Mapping[str, Any], axis: str = 'rotary') -> Said:
    """Return what the verdict `data` on a drive with `axis` says, with sizes and limits."""
    sizes = tuple(said(code, size=_measured(data, name, axis), bound=(said(
        bound, limit=_limit(data, limit, axis)),) if data[limit] else ())
        for name, code, limit, bound in SIZES[bool(data.get('separable'))] if name in data)
    reasons = (said('for_reasons', reasons=data['reason']),) if data['reason'] else ()
    return said('accept', verdict=data['verdict'].capitalize(), reasons=reasons, sizes=sizes)


def text(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the result `data` of a drive with `axis` as lines for people."""
    rows = [('gap_rad', 'backlash'), ('stiffness', 'stiffness'), ('hysteresis', 'hysteresis')
            ] if data.get('separable') else []
    return '\n'.join([*wrapped(data['summary']), '', *entries([
        ('bag', data['bag']), ('windows', f'{data["windows_used"]} used of {data["windows"]}'),
        *((noun, str(_measured(data, name, axis)))
          for name, noun in (*rows, ('lost_motion_rad', 'lost motion')) if name in data),
        *(('limit', f'{noun} {sign} {_limit(data, limit, axis)}: holds with probability '
           f'{data["probability_" + name]:.3f}, expected {data["confidence"]:g}')
          for name, noun, limit, sign in (('gap', 'backlash', 'max_gap', '<='),
                                          ('stiffness', 'stiffness', 'min_stiffness', '>='))
          if f'probability_{name}' in data),
        *(('note', note) for note in data['notes'])])])


def _measured(data: Mapping[str, Any], name: str, axis: str) -> Quantity:
    """Return the value `name` of `data`, an angle in the unit of the limit."""
    unit, factor = _unit(data, name, axis)
    return Quantity(data[name] / factor, data[f'{name}_std'] / factor, unit)


def _limit(data: Mapping[str, Any], name: str, axis: str) -> str:
    """Return the limit `name` of `data`, an angle in the unit in which it was given."""
    unit, factor = _unit(data, name, axis)
    return number(data[name] / factor, unit)


def _unit(data: Mapping[str, Any], name: str, axis: str) -> tuple[str, float]:
    """Return (unit of the value `name`, what it is of rad, N m and N m/rad)."""
    if 'stiffness' in name or name == 'hysteresis':
        return on_axis('N m/rad' if 'stiffness' in name else 'N m', axis), 1.0
    return data['unit'], UNITS[axis][data['unit']]
