# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Score verdicts against the sealed labels. Opens the labels; nothing here runs before all verdicts.

What counts: top-1, the verdict is `effect` and names exactly what was drawn; top-2, the drawn id
is among the first two of `ranked` (and the verdict is not `none`); location, the place is right,
whether the effect was named or called unknown. A missing verdict is a miss everywhere.
"""
import numpy as np

from gearbox_monitor.benchmarks.blind import draw, evidence, generate, motions, plant
from gearbox_monitor.benchmarks.harness import bar_lines, BarTable

TWINS = {'coulomb_asymmetry': 'torque_offset'}  # the same torque: one class
PLACES = {'torque_offset': {'motor_side', 'actuator'},
          'encoder_offset': {'arm_sensor', 'motor_sensor'}}
NO_CLOSURE = {'disturbance', *draw.QUANTISATION}
CLOSE = 0.05            # of a closed fraction
SIGMA_NEAR = 0.02
CLEAR_GAP = 1.03        # of the true gap before: above, a closed fraction must be given
FRESH_WINDOWS = 24      # of a new motion, on which an interval is checked
IMITABLE = 40.0         # left by the best imitator, in units of 2 log likelihood
BINS = (8.0, 60.0, 250.0, 1e3, 1e4, 1e5, np.inf)
MAX_SECONDS = 60.0


def canonical(effect):
    """Return the ids of a verdict's `effect` as a set of classes."""
    return frozenset(TWINS.get(i, i) for i in str(effect or '').split('+') if i)


def _places(ids):
    """Return, for each id, the set of places that count as right."""
    return [PLACES.get(TWINS.get(i, i), {plant.place_of(i)}) for i in ids]


def located(location, ids):
    """Return whether `location` (class, or two) is where `ids` act."""
    given = [location] if isinstance(location, str) or location is None else list(location)
    wanted = _places(ids)
    if not wanted:
        return given in (['none'], [None], [])
    # A pair at one place may name it once.
    if len(wanted) == 2 and len(given) == 1:
        given = given * 2
    if len(given) != len(wanted):
        return False
    if len(wanted) == 1:
        return given[0] in wanted[0]
    return any(all(g in w for g, w in zip(order, wanted)) for order in (given, given[::-1]))


def judge(label, verdict):
    """Return what is right in one verdict (None: missing), without simulating anything."""
    ids = label['ids']
    verdict = verdict or {}
    kind = verdict.get('verdict', 'missing')
    named = canonical(verdict.get('effect')) if kind == 'effect' else frozenset()
    truth = canonical('+'.join(ids))
    ranked = [canonical(r) for r in verdict.get('ranked') or []][:2]
    return {
        'verdict': kind, 'named': '+'.join(sorted(named)) if named else kind,
        'top1': named == truth if ids else kind == 'none',
        'top2': bool(ids) and kind not in ('none', 'missing') and (
            named == truth or truth in ranked),
        'located': located(verdict.get('location'), ids) and (kind != 'none' or not ids)
        and kind != 'missing',
        'both': len(ids) == 2 and truth <= named, 'one': bool(truth & named),
        'unknown': kind == 'unknown',
        'false_alarm': not ids and kind != 'none',
        'confusable': len(verdict.get('confusable') or [])}


def reported_model(label, verdict):
    """Return (nominal, effects) that a verdict describes, or None where it gives no effect."""
    params = verdict.get('params') or {}
    ids = [i for i in str(verdict.get('effect') or '').split('+') if i]
    effects = []
    for name in ids:
        if name not in plant.EFFECTS or name not in params:
            return None
        given = {k: v for k, v in params[name].items() if k in plant.EFFECTS[name][1]}
        if set(given) != set(plant.EFFECTS[name][1]):
            return None
        effects.append({'id': name, **{k: float(v) for k, v in given.items()}})
    nominal = dict(label['told'])
    for name, value in (verdict.get('nominal') or {}).items():
        if label['scatter'] and name in nominal and value is not None:
            nominal[name] = float(value)
    return nominal, effects


def _simulated(label, verdict):
    """Return reported_model() of a verdict of effects that repeat, else None."""
    if (verdict or {}).get('verdict') != 'effect' or set(
            verdict['effect'].split('+')) & NO_CLOSURE:
        return None
    return reported_model(label, verdict)


def _held_out_chi2(nominal, effects, recording, sigma, label, true=False):
    starts = evidence.cut(len(recording['u']))
    test = evidence.held_out(len(starts))
    known = np.array(label['states'])[:len(starts)]
    lead = plant.lead_of(effects, recording['dt'])
    known[:, :2] -= lead * recording['dt'] * known[:, 2:]
    carries = {e['id'] for e in effects} & {'lugre', 'hysteresis_bouc_wen', 'hysteresis_branch'}
    if not carries:
        starts, known = starts[test], known[test]
    chi2, *_ = evidence.fit_windows(nominal, effects, recording, np.asarray(sigma), starts,
                                    known if true else None, others=(known,))
    return chi2[test] if carries else chi2


def fresh_closure(label, model):
    """
    Return the closed fraction of `model` on a new motion of the same kind, without noise luck.

    The misfit to noise-free data plus what noise adds on average.
    """
    seeds = label['seeds']
    n = FRESH_WINDOWS * evidence.LENGTH
    random = np.random.default_rng([*seeds, 5])
    sigma = np.array(label['sigma'])
    u, control, reference = motions.draw(label['kind'], random, n, generate.DT)
    effects = label['effects']
    x, y, u = plant.simulate(label['truth'], effects, u, generate.DT, control=control,
                             reference=reference)
    if not np.isfinite(x).all():
        return None
    recording = {'u': u, 'y': y, 'dt': generate.DT}
    starts = evidence.cut(n)
    floor = 2 * evidence.LENGTH - 4
    gaps = []
    for nominal, chosen in ((label['told'], []), model):
        lead = plant.lead_of(chosen, generate.DT)
        chi2, *_ = evidence.fit_windows(nominal, chosen, recording, sigma,
                                        states=x[np.maximum(starts - lead, 0)], rescue=False)
        chi2 = np.minimum(chi2, 1e9)
        gaps.append(evidence.gap(chi2 + floor))
    return evidence.closed(*gaps)


def closures(label, verdict, recording, fresh=True):
    """Return closed fractions: of the true model, as reported, recomputed, on a new motion."""
    out = {'before': None, 'true': None, 'reported': None, 'recomputed': None, 'fresh': None,
           'interval': None}
    if not label['ids'] or set(label['ids']) & NO_CLOSURE or set(label['ids']) & set(
            plant.OUTSIDE) or label['exclude']:
        return out
    verdict = verdict or {}
    # In units of the noise that the verdict found: what is compared are models. How well the noise
    # was found is judged by itself.
    sigma = verdict.get('sigma') or label['sigma']
    before = evidence.gap(_held_out_chi2(label['told'], [], recording, sigma, label))
    after = evidence.gap(_held_out_chi2(label['truth'], label['effects'], recording, sigma,
                                        label, True))
    out['before'], out['true'] = before, evidence.closed(before, after)
    out['reported'], out['interval'] = verdict.get('closed_fraction'), verdict.get(
        'closed_fraction_ci')
    model = _simulated(label, verdict)
    if model is not None and out['reported'] is not None:
        again = evidence.gap(_held_out_chi2(*model, recording, sigma, label))
        out['recomputed'] = evidence.closed(before, again)
        out['recomputed_after'] = again
        if fresh and out['interval']:
            out['fresh'] = fresh_closure(label, model)
    return out


def _closure_bars(bars, rows, prefix):
    clear = [r for r in rows if r['closure']['before'] is not None
             and r['closure']['before'] >= CLEAR_GAP]
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
    given = [r for r in clear if r['verdict'] == 'effect']
    bars.share('closed recomputed within 0.05',
               [r['closure']['recomputed'] is not None
                and abs(r['closure']['reported'] - r['closure']['recomputed']) <= CLOSE
                for r in given], 0.95)
    covered = [r['closure']['interval'][0] <= r['closure']['fresh']
               <= r['closure']['interval'][1] for r in given
               if r['closure']['interval'] and r['closure']['fresh'] is not None]
    bars.share('interval covers a new motion', covered, 0.80, 0.97)


def _main_bars(bars, rows, stress):
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
        outside = [r for r in rows if r['class'] == 'outside']
        bars.share('outside called unknown', [r['unknown'] for r in outside], 0.90)
        clear = [r for r in outside if r['left'] is None or r['left'] > IMITABLE]
        bars.share('outside, no imitator: unknown', [r['unknown'] for r in clear], 0.90)
        bars.share('outside located', [r['located'] for r in outside], 0.75)
        bars.share('known called unknown', [r['unknown'] for r in singles], high=0.04)
    _closure_bars(bars, [r for r in rows if r['class'] in ('single', 'pair')], prefix)
    bars.share(f'{prefix}sigma within 2 %', [r['sigma_off'] <= SIGMA_NEAR for r in rows
                                             if r['sigma_off'] is not None])


def _sigma_off(label, verdict):
    """Return the relative error of the noise that was found, None with steps of an encoder."""
    found = (verdict or {}).get('sigma')
    if not found or any('quantisation' in i for i in label['ids']):
        return None
    return float(np.abs(np.array(found) / label['sigma'] - 1.0).max())


def score(labels, verdicts, read, seconds=None, fresh=True, progress=lambda done, total: None,
          imitator=None):
    """
    Return all figures as plain data.

    labels: {name: label}; verdicts: {name: verdict or None}; read(name): the recording;
    seconds: {name: s}; imitator(label, recording, model reported or None): what the best imitator
    leaves (left out and outside effects), None: not asked.
    """
    rows = []
    for name, label in labels.items():
        verdict = verdicts.get(name)
        row = {'name': name, 'set': label['set'], 'class': label['class'], 'ids': label['ids'],
               'kind': label['kind'], 'noise': label['noise'], 'd': label['d'],
               'd_each': label['d_each'], 'options': label['options'],
               'location': (verdict or {}).get('location'),
               'ranked': ((verdict or {}).get('ranked') or [])[:3],
               'seconds': (seconds or {}).get(name), **judge(label, verdict)}
        recording = read(name)
        row['closure'] = closures(label, verdict, recording, fresh)
        row['sigma_off'] = _sigma_off(label, verdict)
        row['left'] = None
        if label['class'] in ('loo', 'outside') and imitator is not None:
            found = imitator(label, recording, _simulated(label, verdict))
            row['left'], row['imitators'] = found['left'], found['imitators']
        rows.append(row)
        progress(len(rows), len(labels))
    bars = BarTable()
    main = [r for r in rows if r['set'] == 'main' and r['class'] not in ('small', 'loo')]
    _main_bars(bars, main, False)
    stress = [r for r in rows if r['set'] == 'stress' and not r['options']]
    _main_bars(bars, stress, True)
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
        bars.judge('longest diagnosis, s', float(max(times, default=np.inf)), high=MAX_SECONDS,
                   count=str(len(times)))
    missing = [r['name'] for r in rows if r['verdict'] == 'missing']
    bars.judge('verdicts missing', float(len(missing)), high=0.0, count=str(len(rows)))
    named = [r for r in main if r['class'] == 'single' and r['verdict'] != 'missing']
    return {'rows': rows, 'bars': bars.rows, 'curve': curve(rows),
            'options': option_lines(rows), 'confusion': confusion(main),
            'confusable': float(np.mean([r['confusable'] for r in named])) if named else None}


def curve(rows):
    """Return accuracy against evidence, singles of the main set and the small ones."""
    out = []
    chosen = [r for r in rows if r['set'] == 'main' and r['class'] in ('single', 'small')
              and r['d'] is not None]
    for low, high in zip(BINS, BINS[1:]):
        some = [r for r in chosen if low <= r['d'] < high]
        if some:
            out.append({'from': low, 'to': None if np.isinf(high) else high, 'n': len(some),
                        **{k: float(np.mean([r[k] for r in some]))
                           for k in ('located', 'top1', 'top2', 'unknown')},
                        'none': float(np.mean([r['verdict'] == 'none' for r in some]))})
    return out


def option_lines(rows):
    """Return a line per set of options of the stress set: reported, not judged."""
    out = []
    for options in sorted({str(r['options']) for r in rows if r['options']}):
        some = [r for r in rows if str(r['options']) == options]
        singles = [r for r in some if r['class'] == 'single']
        nones = [r for r in some if r['class'] == 'none']
        pairs = [r for r in some if r['class'] == 'pair']
        out.append({'options': options, 'singles': len(singles), 'nones': len(nones),
                    'pairs': len(pairs), 'located': sum(r['located'] for r in singles),
                    'top1': sum(r['top1'] for r in singles),
                    'top2': sum(r['top2'] for r in singles),
                    'both': sum(r['both'] for r in pairs),
                    'false_alarms': sum(r['false_alarm'] for r in nones)})
    return out


def confusion(rows):
    """Return {drawn: {named: count}} of singles, nones and effects outside the library."""
    out = {}
    for row in rows:
        if row['class'] in ('single', 'none', 'outside'):
            drawn = '+'.join(row['ids']) or 'none'
            out.setdefault(drawn, {})
            out[drawn][row['named']] = out[drawn].get(row['named'], 0) + 1
    return {k: out[k] for k in sorted(out)}


# ---------------------------------------------------------------------- tables

def _percent(value):
    return f'{100 * value:5.0f}'


def missed(row):
    """Return why a row stands in the list of misses, or None."""
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


def text(data):
    """Return tables, misses and bars, at most 80 columns."""
    lines = ['What was named (rows: what was drawn)', '']
    for drawn, found in data['confusion'].items():
        right = '+'.join(sorted(canonical(drawn))) if drawn != 'none' else 'none'
        total = sum(found.values())
        good = found.get('unknown' if drawn in plant.OUTSIDE else right, 0)
        wrong = ', '.join(f'{k} {v}' for k, v in sorted(found.items())
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
    misses = [(missed(r), r) for r in data['rows'] if missed(r)]
    if misses:
        lines += ['', 'Misses', '']
    for why, row in misses:
        d = '' if row['d'] is None else f'd {row["d"]:.3g}'
        lines += [f'{row["name"]} {why:<14} {row["set"]}/{row["class"]} {row["kind"]} {d} '
                  f'noise {100 * row["noise"]:.2g} %',
                  f'  {"+".join(row["ids"]) or "none"} -> {row["named"]}'[:80],
                  f'  {str(row["location"])}, ranked {", ".join(map(str, row["ranked"]))}'[:80]]
    lines.append('')
    if data['confusable'] is not None:
        lines += [f'Ids in `confusable`, mean over single effects: {data["confusable"]:.1f}', '']
    return '\n'.join([*lines, *bar_lines(data['bars'])])
