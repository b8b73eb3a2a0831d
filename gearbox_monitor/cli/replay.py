# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Run a bag through the estimator, offline, and compare with what was published live.

Without options the recorded parameters and snapshots apply, and every recorded estimate is
compared bit for bit. --filter, --params and --model replace what is recorded.
The bag is read block by block: memory does not grow with its length. --estimates-only omits
smoother, trust and drift: the same estimates in a fraction of the time.

usage examples:
  gearbox_monitor replay gearbox_2026_11_21-10_00_00
  gearbox_monitor replay BAG --out estimates.parquet --estimates-only
  gearbox_monitor replay BAG --model drive.yaml --params estimator.yaml --out estimates.csv
  gearbox_monitor replay BAG --filter ekf --out BAG2 --json
"""
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
import math
from pathlib import Path
import re
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.cli.options import estimator_options, opened, show, warn
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_new_file, load_model
from gearbox_monitor.health.alarms import Level, LIMITS
from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.health.backlash.features import (
    Backlash, combine, is_locked, locked_windows, NotExcited, reason_of, separable_of)
from gearbox_monitor.health.judgement import said_of_slips
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.presentation import as_written, number, on_axis, Quantity, Said, said
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.replay import (
    BagOutput, Comparison, CsvTable, ParquetTable, Replay, replay, summarised)
from gearbox_monitor.report import words
from gearbox_monitor.report.sentences import entries, labelled, told, wrapped
from gearbox_monitor.robot.description import SUFFIXES

OUTPUTS: dict[str, type[CsvTable] | type[BagOutput]] = {
    '.csv': CsvTable, '.parquet': ParquetTable}  # others: a bag


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if args.model is not None and Path(args.model).suffix.lower() in SUFFIXES:
        raise InputError(f'--model {args.model}: a whole robot, expected the model file of a '
                         f'drive; gearbox_monitor watch {args.bag} --model {args.model} states '
                         'what the robot holds')
    parameters, model_file = estimator_options(args)
    if args.filter:
        parameters['filter'] = args.filter
    expect_new_file(args.out)
    with opened(args) as reader:
        model = load_model(model_file) if model_file else None
        player = Player(reader, model, parameters, args.topic, not args.estimates_only)
        data, comparison = _play(args, player)
        data = {**told(says(data, player.estimator.model.axis)), **data}
    warn(args, data['notes'])
    show(args, data, lambda: text(data, player.estimator.model.axis))
    return 1 if comparison and comparison.different else 0


def _play(args: Namespace, player: Player) -> tuple[dict[str, Any], Comparison | None]:
    """Run `player` into the output of the options; return the summary and the comparison."""
    output = OUTPUTS.get(Path(args.out).suffix, BagOutput)(args.out, player) if args.out else None
    try:
        with count_bar('replay', player.reader.topics[player.topic][1]) as bar:
            result = summarised(player, [output] if output else [], bar.update)
        if output:
            output.close()
    except BaseException:
        if output:
            output.abandon()
        raise
    return result


def says(data: Mapping[str, Any], axis: str = 'rotary') -> Iterator[Said]:
    """Yield what a replay (its `data`, of a drive with `axis`) says: what it repeats, shows."""
    if 'comparison' in data:
        compared = data['comparison']
        yield said('differs_from' if compared['different'] else 'repeats', **compared)
    raised = _raised(data['levels'])
    trust = [said('trust_at_end', levels=', '.join(raised.values()) or 'all OK')
             ] if data['levels'] else []
    wear = [as_written(on_axis(words.sentence(data['wear']['summary']), axis))
            ] if data['wear'] else []
    changed = wear and (data['wear']['alerts'] or data['wear']['slips'])
    yield from [*wear, *trust] if changed or raised.keys() <= set(COMPONENTS) else [*trust, *wear]
    if data['nis'] is not None:
        yield said('mean_nis', **data)
    elif not ('comparison' in data or data['wear'] or data['levels']):
        yield said('estimates', count=data['estimates'])


def _raised(levels: Mapping[str, str]) -> dict[str, str]:
    """Return {component: its name and level} of those among `levels` that are not OK."""
    return {k: f'{k} {level}' for k, level in levels.items() if level != Level.OK.name}


def text(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the summary `data` of a drive with `axis` as lines for people."""
    return '\n'.join([*wrapped(data['summary']), '', *entries(
        [('bag', data['bag']), *labelled(_rows(data, axis)),
         *(('note', note) for note in data['notes'])])])


def _rows(data: Mapping[str, Any], axis: str) -> Iterator[Said]:
    """Yield the lines about a replay of a drive with `axis`."""
    def named(values: Mapping[str, Any]) -> str:
        """Return what of `values` is not 0, with their names."""
        return ', '.join(f'{v} {k.replace("_", " ")}' for k, v in values.items() if v)
    yield said('samples_row', **data)
    yield said('noticed_row', noticed=named(
        {k: v for k, v in data['refused'].items() if k != 'starts'}))
    if data['nis'] is not None:
        yield said('nis_row', **data)
    if data.get('tau_k_error') is not None:
        late = data['tau_k_error_smoothed']
        yield said('error_row', unit=on_axis('N m', axis), percent=100 * data['coverage_1_sigma'],
                   smoothed='none' if late is None else f'{late:.4g}', **data)
    yield said('adapted_row', words=', '.join(f'{k} {v:.4g}' for k, v in data['adapted'].items()))
    yield said('adapted_row', words=named(data['adaptation_guards']))
    if data['gap_rad']:
        yield said('gap_row', unit=on_axis('rad', axis),
                   gaps=', '.join(f'{gap:.4g}' for gap in data['gap_rad'][-8:]))
    yield said('trust_row', levels=', '.join(f'{k} {v}' for k, v in data['levels'].items()))
    if c := data.get('comparison'):
        yield said('identical_row', verdict=data['replay_identical'], **c)
        if c['explained'] or c['lost_inputs'] or c['lost_outputs']:
            yield said('missing_row', **c)
        if c['early_inputs']:
            yield said('early_row', **c)
        if c['different']:
            yield said('difference_row', **c)


UNITS = {'rotary': {'rad': 1.0, 'mrad': 1e-3, 'deg': math.radians(1.0),
                    'arcmin': math.radians(1.0) / 60.0},
         'prismatic': {'m': 1.0, 'mm': 1e-3, 'um': 1e-6}}
# Codes of a twist that no gearbox shows: of a swapped, late or wrongly scaled encoder.
CONTRADICTED = ('no_curve', 'other_twist', 'against_twist')
INSEPARABLE = said('inseparable')
EXIT = {'pass': 0, 'fail': 1, 'not excited': 3, 'undecided': 3}


def accept(args: Namespace) -> int:
    """
    Accept or reject a gearbox: check backlash and stiffness from a bag against limits.

    The bag is run through the estimator as "replay" does; torque over twist is fitted on windows
    of drift_window seconds, and the windows are combined. Gap and limits are at the output. A
    limit is met or missed with probability --confidence; the uncertainty contains the spread of
    the windows and the error of the method, 1 % of the gap and 2 % of the stiffness.

    If the motion cannot distinguish backlash from compliance (slow motion against friction), the
    lost motion is tested in its place: the gap is no larger, so the gearbox can pass, but not
    fail.

    A lost-motion test counts as well: the input locked, a torque on the output that goes to and
    fro and is recorded as effort of the arm (or as the motor's, where that holds the input).

    usage examples:
      gearbox_monitor accept BAG --max-gap 0.21
      gearbox_monitor accept BAG --max-gap 30arcmin --min-stiffness 20 --confidence 0.99
      gearbox_monitor accept BAG --model drive.yaml --params estimator.yaml --max-gap 0.5deg --json
    """
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
    doubts = [words for component, words in _raised(result.summary['levels']).items()
              if component not in COMPONENTS]
    notes = [*result.summary['notes'],
             *(str(said('trust_at_end', levels=', '.join(doubts))) for _ in doubts[:1])]
    model = result.estimator.model
    if unit and unit not in UNITS[model.axis]:
        raise InputError(f'--max-gap: {args.max_gap!r}, expected a limit in '
                         f'{", ".join(UNITS[model.axis])}: the axis of the model is {model.axis}')
    data = {'bag': str(args.bag), 'unit': unit or next(iter(UNITS[model.axis])), **limits,
            'confidence': args.confidence,
            **judge(windows(result), limits, args.confidence, _doubts(result)), 'notes': notes}
    data = {**told([verdict_said(data, model.axis)]), **data}
    warn(args, notes)
    show(args, data, lambda: verdict_text(data, model.axis))
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
    """
    Return the features of each window of the replay `result`, or of a lost-motion test.

    If the gearbox changed during the recording, the windows since then count.
    """
    if is_locked(result.samples):
        return locked_windows(result.samples)
    changed = max((alert.since_ns for alert in result.monitor.health.alerts.values()), default=0)
    return [fit for fit in result.monitor.all_features() if fit.stamp_ns > changed]


def _doubts(result: Replay) -> list[Said]:
    """Return slips in a replay, and in what encoders and torque contradict each other."""
    health, outcome = result.monitor.health, result.monitor.outcomes['prediction error']
    says = () if is_locked(result.samples) else outcome.says
    return [*said_of_slips(health), *(part for group in says for part in group
                                      if part.code in CONTRADICTED)]


def judge(fits: Sequence[Any], limits: Mapping[str, float | None],
          confidence: float, doubts: Sequence[Said] = ()) -> dict[str, Any]:
    """
    Return the verdict on a gearbox as plain data.

    Args:
        fits: Backlash or NotExcited of each window.
        limits: {'max_gap': rad or None, 'min_stiffness': N m/rad or None}.
        confidence: probability that a verdict needs.
        doubts: slips of clutch, hub or coupling, contradictions; no gearbox with one passes.

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
    slips, more = ([said('doubtful', doubt=doubt, todo=doubt.remedy) for doubt in doubts
                    if (doubt.code == 'slip') is is_slip] for is_slip in (True, False))
    verdict = ('fail' if slips or any(missed) else 'pass' if all(met) and not more else
               'undecided' if separable else 'not excited')
    reasons = slips if verdict == 'fail' else [*reasons, *more] or [INSEPARABLE] * (not separable)
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


def verdict_said(data: Mapping[str, Any], axis: str) -> Said:
    """Return what the verdict `data` on a drive with `axis` says, with sizes and limits."""
    sizes = tuple(said(code, size=_measured(data, name, axis), bound=(said(
        bound, limit=_limit(data, limit, axis)),) if data[limit] else ())
        for name, code, limit, bound in SIZES[bool(data.get('separable'))] if name in data)
    reasons = (said('for_reasons', reasons=data['reason']),) if data['reason'] else ()
    return said('accept', verdict=data['verdict'].capitalize(), reasons=reasons, sizes=sizes)


def verdict_text(data: Mapping[str, Any], axis: str) -> str:
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
