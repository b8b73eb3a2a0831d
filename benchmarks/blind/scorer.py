# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Score verdicts against the sealed labels. Opens the labels; nothing here runs before all verdicts.

Top-1: the verdict is `effect` and names exactly the drawn ids; top-2: the drawn id is among the
first two of `ranked` (and the verdict is not `none`); location: the place is right, whether the
effect was named or called unknown. A missing verdict is a miss everywhere.
"""
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.blind import draw, motions, plant, window_fit
from benchmarks.blind.plant import Effects, Nominal
from benchmarks.blind.scene import DT
from benchmarks.harness import bar_lines, BarTable
from gearbox_monitor.kernels.types import Array

Label = Mapping[str, Any]        # of a recording, see generate.make
Judgement = Mapping[str, Any]    # of a diagnosis: the content of its verdict.json
ScoredRow = dict[str, Any]

TWINS = {'coulomb_asymmetry': 'torque_offset'}  # the same torque: one class
PLACES = {'torque_offset': {'motor_side', 'actuator'},
          'encoder_offset': {'arm_sensor', 'motor_sensor'}}
NO_CLOSURE = {'disturbance', *draw.QUANTISATION}
CLOSE = 0.05            # of a closed fraction
SIGMA_NEAR = 0.02
CLEAR_MISFIT = 1.03        # of the true misfit: above, a verdict must state a closed fraction
FRESH_WINDOWS = 24      # of a new motion, on which an interval is checked
IMITABLE = 40.0         # left by the best imitator, in units of 2 log likelihood
ACCURACY = {'stiffness': ('K', 0.10), 'backlash_gap': ('b', 0.20)}  # of what one encoder shows
COVERED = 2.0           # standard errors within which a value lies
BINS = (8.0, 60.0, 250.0, 1e3, 1e4, 1e5, np.inf)
MAX_SECONDS = 60.0


def canonical(effect: str | None) -> frozenset[str]:
    """Return the ids of a verdict's `effect` as a set of classes."""
    return frozenset(TWINS.get(i, i) for i in str(effect or '').split('+') if i)


def _places(ids: Sequence[str]) -> list[set[str]]:
    """Return, for each id, the set of places that count as right."""
    return [PLACES.get(TWINS.get(i, i), {plant.place_of(i)}) for i in ids]


def located(location: str | Sequence[str] | None, ids: Sequence[str]) -> bool:
    """Return whether `location` (class, or two) is the place on which `ids` act."""
    locations = [location] if isinstance(location, str) or location is None else list(location)
    allowed = _places(ids)
    if not allowed:
        return locations in (['none'], [None], [])
    # Two effects at one place are one place, drawn or found.
    if len(allowed) == 1:
        return bool(locations) and set(locations) <= allowed[0]
    if len(locations) == 1:
        locations = locations * 2
    if len(locations) != 2:
        return False
    return any(all(place in places for place, places in zip(order, allowed))
               for order in (locations, locations[::-1]))


def judge(label: Label, verdict: Judgement | None) -> ScoredRow:
    """Compare one `verdict` (None: missing) with its `label`, without simulating anything."""
    ids = label['ids']
    verdict = verdict or {}
    kind = verdict.get('verdict', 'missing')
    named_ids = canonical(verdict.get('effect'))
    truth = canonical('+'.join(ids))
    ranked = [canonical(r) for r in verdict.get('ranked') or []][:2]
    return {
        'verdict': kind, 'named': '+'.join(sorted(named_ids)) if named_ids else kind,
        'top1': named_ids == truth if ids else kind == 'none',
        'top2': bool(ids) and kind not in ('none', 'missing') and (
            named_ids == truth or truth in ranked),
        'located': located(verdict.get('location'), ids) and (kind != 'none' or not ids)
        and kind != 'missing',
        'both': len(ids) == 2 and truth <= named_ids, 'one': bool(truth & named_ids),
        'unknown': kind in ('unknown', 'incomplete'),
        'false_alarm': not ids and kind != 'none',
        'confusable': len(verdict.get('confusable') or []),
        'admitted': bool(ids) and truth <= named_ids | canonical(
            '+'.join(verdict.get('confusable') or []))}


def reported_model(label: Label,
                   verdict: Judgement) -> tuple[Nominal, list[dict[str, Any]]] | None:
    """Return (nominal, effects) that a `verdict` on `label` describes, None without effect."""
    params = verdict.get('params') or {}
    ids = [i for i in str(verdict.get('effect') or '').split('+') if i]
    effects: list[dict[str, Any]] = []
    for name in ids:
        if name not in plant.EFFECTS or name not in params:
            return None
        values = {k: v for k, v in params[name].items() if k in plant.EFFECTS[name][1]}
        if set(values) != set(plant.EFFECTS[name][1]):
            return None
        effects.append({'id': name, **{k: float(v) for k, v in values.items()}})
    nominal = dict(label['told'])
    for name, value in (verdict.get('nominal') or {}).items():
        if label['scatter'] and name in nominal and value is not None:
            nominal[name] = float(value)
    return nominal, effects


def _simulated(label: Label, verdict: Judgement | None
               ) -> tuple[Nominal, list[dict[str, Any]]] | None:
    """Return reported_model() of a verdict of effects that repeat, else None."""
    if not verdict or verdict.get('verdict') != 'effect' or set(
            verdict['effect'].split('+')) & NO_CLOSURE:
        return None
    return reported_model(label, verdict)


def _chi2(nominal: Nominal, effects: Effects, recording: plant.MotionRecord,
          sigma: Sequence[float], label: Label, true: bool = False) -> Array:
    starts = window_fit.cut(len(recording['u']))
    start_states = np.array(label['states'])[:len(starts)]
    lead = plant.lead_of(effects, recording['dt'])
    start_states[:, :2] -= lead * recording['dt'] * start_states[:, 2:]
    chi2, *_ = window_fit.fit_windows(nominal, effects, recording, np.asarray(sigma), starts,
                                      start_states if true else None,
                                      alternatives=(start_states,))
    return chi2


def fresh_closure(label: Label, model: tuple[Nominal, Effects]) -> float | None:
    """
    Return the closed fraction of a `model` of `label` on a new motion of the same kind.

    Free of chance: the misfit to noise-free data plus the expected contribution of the noise.
    """
    seeds = label['seeds']
    n = FRESH_WINDOWS * window_fit.LENGTH
    random = np.random.default_rng([*seeds, 5])
    sigma = np.array(label['sigma'])
    motion = motions.draw(label['kind'], random, n, DT)
    x, y, u = plant.simulate_motion(label['truth'], label['effects'], motion, DT)
    if not np.isfinite(x).all():
        return None
    recording = {'u': u, 'y': y, 'dt': DT}
    starts = window_fit.cut(n)
    floor = 2 * window_fit.LENGTH - 4
    misfits = []
    for nominal, chosen in ((label['told'], []), model):
        lead = plant.lead_of(chosen, DT)
        chi2, *_ = window_fit.fit_windows(nominal, chosen, recording, sigma,
                                          states=x[np.maximum(starts - lead, 0)],
                                          alternatives=None)
        chi2 = np.minimum(chi2, 1e9)
        misfits.append(window_fit.misfit(chi2 + floor))
    return window_fit.closed(*misfits)


def closures(label: Label, verdict: Judgement | None, recording: plant.MotionRecord,
             fresh: bool = True) -> dict[str, Any]:
    """
    Return closed fractions: of the true model, as reported, recomputed, on a new motion.

    Args:
        label: what was drawn.
        verdict: of the diagnosis, None: missing.
        recording: u [N], y [N, 2], dt.
        fresh: whether to simulate a new motion.
    """
    out: dict[str, Any] = {'before': None, 'true': None, 'reported': None, 'recomputed': None,
                           'fresh': None, 'interval': None}
    if not label['ids'] or set(label['ids']) & NO_CLOSURE or set(label['ids']) & set(
            plant.OUTSIDE) or label['exclude'] or partial(label):
        return out
    verdict = verdict or {}
    # In units of the noise that the verdict states: this compares models. The noise itself has a
    # bar of its own.
    sigma = verdict.get('sigma') or label['sigma']
    nominal_misfit = window_fit.misfit(
        _chi2(label['told'], [], recording, sigma, label))
    true_misfit = window_fit.misfit(_chi2(
        label['truth'], label['effects'], recording, sigma, label, True))
    out['before'], out['true'] = nominal_misfit, window_fit.closed(nominal_misfit, true_misfit)
    out['reported'], out['interval'] = verdict.get('closed_fraction'), verdict.get(
        'closed_fraction_ci')
    model = _simulated(label, verdict)
    if model is not None and out['reported'] is not None:
        reported_misfit = window_fit.misfit(_chi2(*model, recording, sigma, label))
        out['recomputed'] = window_fit.closed(nominal_misfit, reported_misfit)
        out['recomputed_after'] = reported_misfit
        if fresh and out['interval']:
            out['fresh'] = fresh_closure(label, model)
    return out


def _closure_bars(bars: BarTable, rows: Sequence[ScoredRow], prefix: str) -> None:
    clear = [r for r in rows if r['closure']['before'] is not None
             and r['closure']['before'] >= CLEAR_MISFIT]
    reported = [r['closure']['reported'] for r in clear]
    if clear:
        bars.judge(f'{prefix}closed fraction, median',
                   float(np.median([0.0 if v is None else v for v in reported])),
                   low=0.99 if not prefix else -np.inf, count=str(len(clear)))
    bars.share(f'{prefix}closed within 0.05 of truth',
               [v is not None and abs(v - r['closure']['true']) <= CLOSE
                for v, r in zip(reported, clear)], 0.95)
    if prefix:
        return
    diagnosed = [r for r in clear if r['verdict'] == 'effect']
    bars.share('closed recomputed within 0.05',
               [r['closure']['recomputed'] is not None
                and abs(r['closure']['reported'] - r['closure']['recomputed']) <= CLOSE
                for r in diagnosed], 0.95)
    covered = [r['closure']['interval'][0] <= r['closure']['fresh']
               <= r['closure']['interval'][1] for r in diagnosed
               if r['closure']['interval'] and r['closure']['fresh'] is not None]
    bars.share('interval covers a new motion', covered, 0.80, 0.97)


def _main_bars(bars: BarTable, rows: Sequence[ScoredRow], stress: bool) -> None:
    """Judge singles and nones; the same figures with other limits under `stress`."""
    prefix = 'stress: ' if stress else ''
    singles = [r for r in rows if r['class'] == 'single']
    bars.share(f'{prefix}location', [r['located'] for r in singles], 0.95 if stress else 0.97)
    bars.share(f'{prefix}top-1', [r['top1'] for r in singles], 0.93 if stress else 0.95)
    bars.share(f'{prefix}top-2', [r['top2'] for r in singles], 0.97 if stress else 0.99)
    bars.share(f'{prefix}none: something found',
               [r['false_alarm'] for r in rows if r['class'] == 'none'],
               high=1 / 30 if stress else 1 / 60)
    pairs = [r for r in rows if r['class'] == 'pair']
    low = -np.inf if stress else 0.88
    bars.share(f'{prefix}pairs, both named', [r['both'] for r in pairs], low)
    if not stress:
        outside_rows = [r for r in rows if r['class'] == 'outside']
        bars.share('outside called unknown', [r['unknown'] for r in outside_rows], 0.90)
        clear = [r for r in outside_rows if r['left'] is None or r['left'] > IMITABLE]
        bars.share('outside, no imitator: unknown', [r['unknown'] for r in clear], 0.90)
        bars.share('outside located', [r['located'] for r in outside_rows], 0.75)
        bars.share('known called unknown', [r['unknown'] for r in singles], high=0.04)
    _closure_bars(bars, [r for r in rows if r['class'] in ('single', 'pair')], prefix)
    bars.share(f'{prefix}sigma within 2 %', [r['sigma_of'] <= SIGMA_NEAR for r in rows
                                             if r['sigma_of'] is not None])


def partial(row: Label) -> str:
    """Return what a label or `row` has instead of a torque and two encoders, '' for nothing."""
    options = row['options']
    return ', '.join(['setpoint'] * (options.get('input', 'torque') != 'torque')
                     + ['one encoder'] * (options.get('encoders', 'both') != 'both'))


def _parameter(label: Label, verdict: Judgement | None) -> tuple[float, float] | None:
    """Return (relative error, error in standard errors) of what ACCURACY judges, if named."""
    name = label['ids'][0] if len(label['ids']) == 1 else ''
    if name not in ACCURACY or not verdict or verdict.get('effect') != name:
        return None
    key, _ = ACCURACY[name]
    true, value = label['effects'][0][key], verdict['params'][name][key]
    error = ((verdict.get('standard_errors') or {}).get(name) or {}).get(key)
    off = abs(value - true)
    return off / true, off / error if error else np.inf


def _partial_bars(bars: BarTable, rows: Sequence[ScoredRow]) -> None:
    """Judge recordings of a setpoint or one encoder: what they cannot tell apart is no miss."""
    what = partial(rows[0])
    singles = [r for r in rows if r['class'] == 'single']
    bars.share(f'{what}: location', [r['located'] for r in singles], 0.92)
    bars.share(f'{what}: top-1', [r['top1'] for r in singles])
    bars.share(f'{what}: top-1 of distinguishable effects',
               [r['top1'] for r in singles if r['top1'] or not r['admitted']], 0.85)
    bars.share(f'{what}: none: something found',
               [r['false_alarm'] for r in rows if r['class'] == 'none'], high=1 / 20)
    bars.share(f'{what}: pairs, both named', [r['both'] for r in rows if r['class'] == 'pair'])
    bars.share(f'{what}: outside called unknown',
               [r['unknown'] for r in rows if r['class'] == 'outside'])
    for name, (key, accuracy) in ACCURACY.items():
        judged = [r for r in singles if r['ids'] == [name] and r['parameter'] is not None]
        bars.share(f'{what}: {key} within {100 * accuracy:.0f} %',
                   [r['parameter'][0] <= accuracy for r in judged], 1.0)
        if judged:
            bars.judge(f'{what}: {key}, median error in %', 100.0 * float(np.median(
                [r['parameter'][0] for r in judged])), count=str(len(judged)))
    deviations = [r['parameter'][1] for r in rows if r['parameter'] is not None]
    bars.share(f'{what}: value within a standard error', [d <= 1.0 for d in deviations])
    bars.share(f'{what}: value within {COVERED:g} standard errors',
               [d <= COVERED for d in deviations], 0.9)
    rivals = ({*draw.DELAYS}, {*draw.COMPLIANCES})
    bars.share(f'{what}: delay against compliance', [
        r['located'] and not {*r['named'].split('+')} & other for r in singles
        for own, other in (rivals, rivals[::-1]) if {*r['ids']} <= own], 0.95)


def _sigma_off(label: Label, verdict: Judgement | None) -> float | None:
    """Return the relative error of the stated noise, None with steps of an encoder."""
    sigma = (verdict or {}).get('sigma')
    if not sigma or any('quantisation' in i for i in label['ids']):
        return None
    return max(abs(s / drawn - 1.0) for s, drawn in zip(sigma, label['sigma']) if s is not None)


def score(labels: Mapping[str, Label], verdicts: Mapping[str, Judgement | None],
          read: Callable[[str], plant.MotionRecord],
          seconds: Mapping[str, float] | None = None, fresh: bool = True,
          progress: Callable[[int, int], object] = lambda done, total: None,
          imitator: Callable[..., dict[str, Any]] | None = None) -> dict[str, Any]:
    """
    Score all verdicts.

    Args:
        labels: by name of the recording.
        verdicts: by name; None: missing.
        read: returns a recording by its name.
        seconds: time of each diagnosis.
        fresh: whether closed fractions are also checked on a new motion.
        progress: called with the numbers of verdicts scored and in all.
        imitator: imitate.best_imitator or None; judges left-out and outside effects.

    Returns:
        All figures as plain data.
    """
    rows = []
    for name, label in labels.items():
        verdict = verdicts.get(name)
        row = {'name': name, 'set': label['set'], 'class': label['class'], 'ids': label['ids'],
               'kind': label['kind'], 'noise': label['noise'], 'd': label['d'],
               'd_each': label['d_each'], 'options': label['options'],
               'smooth': label.get('smooth', False),
               'location': (verdict or {}).get('location'),
               'ranked': ((verdict or {}).get('ranked') or [])[:3],
               'seconds': (seconds or {}).get(name), **judge(label, verdict)}
        recording = read(name)
        row['closure'] = closures(label, verdict, recording, fresh)
        row['sigma_of'] = _sigma_off(label, verdict)
        row['parameter'] = _parameter(label, verdict)
        row['left'] = None
        if label['class'] in ('loo', 'outside') and imitator is not None and not partial(label):
            imitation = imitator(label, recording, _simulated(label, verdict))
            row['left'], row['imitators'] = imitation['left'], imitation['imitators']
        rows.append(row)
        progress(len(rows), len(labels))
    bars = BarTable()
    main = [r for r in rows if r['set'] == 'main' and r['class'] not in ('small', 'loo')]
    if any(partial(r) for r in main):
        _partial_bars(bars, main)
    else:
        _main_bars(bars, main, False)
    stress = [r for r in rows if r['set'] == 'stress' and not r['options']]
    _main_bars(bars, stress, True)
    bars.share('without Coulomb friction: right', [
        r['unknown'] if r['class'] in ('outside', 'loo') else r['top1']
        for r in rows if r['smooth'] and r['class'] != 'small'])
    loo = [r for r in rows if r['class'] == 'loo']
    # Without a computed imitator all count as not imitable: the harder reading.
    clear = [r for r in loo if (r['left'] is None or r['left'] > IMITABLE)
             and not {*r['ids']} & {*TWINS, *TWINS.values()}]
    bars.share('left out, no imitator: unknown', [r['unknown'] for r in clear], 0.90)
    bars.share('left out, no imitator: place', [r['located'] for r in clear], 0.80)
    imitable = [r for r in loo if r not in clear]
    bars.share('left out, imitable: right',
               [r['unknown'] or r['named'] in ['+'.join(sorted(canonical(i)))
                                               for i in r['imitators']]
                for r in imitable])
    if seconds:
        times = [s for s in seconds.values() if s is not None]
        bars.judge('longest diagnosis, CPU s', float(max(times, default=np.inf)), high=MAX_SECONDS,
                   count=str(len(times)))
    missing = [r['name'] for r in rows if r['verdict'] == 'missing']
    bars.judge('verdicts missing', float(len(missing)), high=0.0, count=str(len(rows)))
    singles = [r for r in main if r['class'] == 'single' and r['verdict'] != 'missing']
    return {'rows': rows, 'bars': bars.rows, 'curve': curve(rows),
            'options': option_lines(rows), 'confusion': confusion(main),
            'competition': competition(main),
            'confusable': float(np.mean([r['confusable'] for r in singles])) if singles else None}


def competition(rows: Sequence[ScoredRow]) -> dict[str, float | None]:
    """
    Return the figures of the LiU-ICE diagnosis competition (Jung, Frisk, Krysander 2024).

    detection: share of `rows` with an effect in which one is seen. false_alarm: share of those
    without that are not called free of effects. isolation: mean probability of the true effect
    where a single one is detected; a verdict divides probability equally among the effect that it
    names and those that it calls confusable. unknown_fault: share of effects outside the library
    that are called unknown. None: no such recording.
    """
    def mean(values: list[float]) -> float | None:
        return float(np.mean(values)) if values else None
    faulty = [r for r in rows if r['ids']]
    detected = [r for r in faulty if r['verdict'] not in ('none', 'missing')]
    return {
        'detection': mean([float(r in detected) for r in faulty]),
        'false_alarm': mean([float(r['false_alarm']) for r in rows if not r['ids']]),
        'isolation': mean([r['admitted'] * (r['verdict'] == 'effect') / (1.0 + r['confusable'])
                           for r in detected if r['class'] == 'single']),
        'unknown_fault': mean([float(r['unknown']) for r in rows if r['class'] == 'outside'])}


def curve(rows: Sequence[ScoredRow]) -> list[dict[str, Any]]:
    """Return accuracy against evidence from `rows`: singles of the main set and small ones."""
    out = []
    chosen = [r for r in rows if r['set'] == 'main' and r['class'] in ('single', 'small')
              and r['d'] is not None]
    for low, high in zip(BINS, BINS[1:]):
        members = [r for r in chosen if low <= r['d'] < high]
        if members:
            out.append({'from': low, 'to': None if np.isinf(high) else high, 'n': len(members),
                        **{k: float(np.mean([r[k] for r in members]))
                           for k in ('located', 'top1', 'top2', 'unknown')},
                        'none': float(np.mean([r['verdict'] == 'none' for r in members]))})
    return out


def option_lines(rows: Sequence[ScoredRow]) -> list[dict[str, Any]]:
    """Return counts from `rows` for each set of options of the stress set: shown, not judged."""
    out = []
    for options in sorted({str(r['options']) for r in rows
                           if r['options'] and r['set'] == 'stress'}):
        members = [r for r in rows if str(r['options']) == options]
        singles = [r for r in members if r['class'] == 'single']
        nones = [r for r in members if r['class'] == 'none']
        pairs = [r for r in members if r['class'] == 'pair']
        out.append({'options': options, 'singles': len(singles), 'nones': len(nones),
                    'pairs': len(pairs), 'located': sum(r['located'] for r in singles),
                    'top1': sum(r['top1'] for r in singles),
                    'top2': sum(r['top2'] for r in singles),
                    'both': sum(r['both'] for r in pairs),
                    'false_alarms': sum(r['false_alarm'] for r in nones)})
    return out


def confusion(rows: Sequence[ScoredRow]) -> dict[str, dict[str, int]]:
    """Return {drawn: {named: count}} from `rows` of singles, nones and outside effects."""
    out: dict[str, dict[str, int]] = {}
    for row in rows:
        if row['class'] in ('single', 'none', 'outside'):
            drawn = '+'.join(row['ids']) or 'none'
            out.setdefault(drawn, {})
            out[drawn][row['named']] = out[drawn].get(row['named'], 0) + 1
    return {k: out[k] for k in sorted(out)}


# ---------------------------------------------------------------------- tables

def _percent(value: float) -> str:
    return f'{100 * value:5.0f}'


def missed(row: ScoredRow) -> str | None:
    """Return why a `row` stands in the list of misses, or None."""
    if row['verdict'] == 'missing':
        return 'no verdict'
    if row['class'] == 'none':
        return 'something found' if row['false_alarm'] else None
    if row['class'] in ('outside', 'loo'):
        return None if row['unknown'] and row['located'] else \
            'place' if row['unknown'] else 'not unknown'
    if row['class'] == 'pair':
        return None if row['both'] else 'pair'
    return None if row['top1'] else 'top-2' if row['top2'] else 'effect'


def text(data: Mapping[str, Any]) -> str:
    """Return tables, misses and bars of `data` from score(), at most 80 columns."""
    lines = ['What was named (rows: what was drawn)', '']
    for drawn, counts in data['confusion'].items():
        right = '+'.join(sorted(canonical(drawn))) if drawn != 'none' else 'none'
        total = sum(counts.values())
        good = counts.get('unknown' if drawn in plant.OUTSIDE else right, 0)
        wrong = ', '.join(f'{k} {v}' for k, v in sorted(counts.items())
                          if k != ('unknown' if drawn in plant.OUTSIDE else right))
        lines.append(f'{drawn[:27]:<28}{good:3d}/{total:<3d} {wrong[:44]}'.rstrip())
    if data['curve']:
        lines += ['', 'Accuracy against evidence d, %', '',
                  f'{"d":<20}{"n":>5}{"location":>10}{"top-1":>7}{"top-2":>7}{"unknown":>9}'
                  f'{"none":>6}']
        for row in data['curve']:
            span = f'{row["from"]:.0f} ..' + ('' if row['to'] is None else f' {row["to"]:.0f}')
            lines.append(f'{span:<20}{row["n"]:5d}{_percent(row["located"]):>10}'
                         f'{_percent(row["top1"]):>7}{_percent(row["top2"]):>7}'
                         f'{_percent(row["unknown"]):>9}{_percent(row["none"]):>6}')
    for row in data['options']:
        lines += ['', f'{row["options"]}:', f'  location {row["located"]}/{row["singles"]}, top-1 '
                  f'{row["top1"]}, top-2 {row["top2"]}; pairs {row["both"]}/{row["pairs"]}; '
                  f'none {row["false_alarms"]}/{row["nones"]} false']
    lines += ['', 'As the LiU-ICE competition counts', '',
              ', '.join(f'{name.replace("_", " ")} {100.0 * value:.0f} %'
                        for name, value in data['competition'].items() if value is not None)]
    misses = [(missed(r), r) for r in data['rows'] if missed(r)]
    if misses:
        lines += ['', 'Misses', '']
    for reason, row in misses:
        d = '' if row['d'] is None else f'd {row["d"]:.3g}'
        lines += [f'{row["name"]} {reason:<14} {row["set"]}/{row["class"]} {row["kind"]} {d} '
                  f'noise {100 * row["noise"]:.2g} %',
                  f'  {"+".join(row["ids"]) or "none"} -> {row["named"]}'[:80],
                  f'  {str(row["location"])}, ranked {", ".join(map(str, row["ranked"]))}'[:80]]
    lines.append('')
    if data['confusable'] is not None:
        lines += [f'Ids in `confusable`, mean over single effects: {data["confusable"]:.1f}', '']
    return '\n'.join([*lines, *bar_lines(data['bars'])])
