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
Recordings of drives with a known deviation from their model, and the sealed labels.

A recording is a folder of random name with recording.csv (t, u, motor, arm) and drive.yaml (the
nominal model as told to the diagnosis). What was drawn stands in the labels file alone.
"""
from concurrent.futures import ProcessPoolExecutor
import json
from pathlib import Path

import numpy as np
import yaml

from gearbox_monitor.benchmarks.blind import draw, evidence, motions, plant, stress

DT = 1e-3
LEAST, MOST = 250.0, 1e6    # wanted evidence d
STRESS = {'scatter': 0.015, 'torque': 0.01}
PARAMETER_TOLERANCES = 5.0  # smallest change of a nominal value under scatter
LARGER = (1.3, 5.0)         # factors by which an effect is made larger that scatter hides
CORRELATION = 0.005         # s, of coloured noise
JITTER = 1e-4               # s rms, of stamps
MAX_TRAVEL = 60.0           # rad
TRIES = 30                  # motions, until one moves the drive through its gap
SIZINGS = 8                 # changes of an effect's size, until its evidence is as wanted


class NotDrawn(Exception):
    """No recording with the wanted evidence came out of these random numbers."""


def plan(counts, random, sets=('main',), options=None):
    """
    Return specifications, in random order: what is to be drawn.

    counts: {class: number}, classes: single, none, pair, outside, small (d < 250), loo.
    """
    specs = []

    def cycle(ids, count):
        ids = list(ids)
        out = []
        while len(out) < count:
            out += [ids[i] for i in random.permutation(len(ids))]
        return out[:count]
    options = dict(options or {})
    for name in sets:
        for kind, count in counts.items():
            if kind == 'none':
                chosen = [[]] * count
            elif kind == 'outside':
                chosen = [[i] for i in cycle(plant.OUTSIDE, count)]
            elif kind == 'pair':
                able = [i for i in plant.EFFECTS if i not in draw.NEVER_IN_PAIRS]
                chosen = []
                while len(chosen) < count:
                    a, b = random.choice(able, 2, replace=False)
                    if draw.compatible(a, b):
                        chosen.append([str(a), str(b)])
            else:
                ids = [i for i in plant.EFFECTS if kind != 'small'
                       or i not in ('disturbance', *draw.QUANTISATION)]
                chosen = [[i] for i in cycle(ids, count)]
            specs += [{'set': name, 'class': kind, 'ids': ids, 'options': options}
                      for ids in chosen]
    return [specs[i] for i in random.permutation(len(specs))]


def _scene(u, sigma):
    return {'peak': float(np.abs(u).max()), 'rms': float(np.sqrt(np.mean(u * u))) + 1e-9,
            'sigma': [float(s) for s in sigma]}


def _runs(truth, effects, motion, torque, seed):
    u, control, reference = motion
    with np.errstate(all='ignore'):
        x, y, u = plant.simulate(truth, effects, u, DT, torque_std=torque,
                                 rng=np.random.default_rng(seed), control=control,
                                 reference=reference)
    sane = np.isfinite(x).all() and np.abs(x[:, :2]).max() < MAX_TRAVEL
    return x, y, u, sane


def _moves(x, values):
    """Return whether the drive moves, and both flanks of the gap carry load several times."""
    twist = x[:, 0] - x[:, 1]
    side = np.sign(twist) * (np.abs(twist) > values['b'])
    side = side[side != 0]
    return x[:, 1].std() > 0.1 and len(side) > 500 and np.sum(np.diff(side) != 0) >= 6


def _noise(random, n, sigma, correlation):
    white = random.standard_normal((n, 2))
    if correlation:
        keep = np.exp(-DT / correlation)
        out = np.empty_like(white)
        out[0] = white[0]
        for k in range(1, n):
            out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep * keep) * white[k]
        white = out
    return white * sigma


def evidence_of(recording, truth, effects, rival, rival_effects, sigma, states=None,
                careful=False):
    """Return d: 2 Delta log likelihood of the truth over the rival model."""
    right, *_ = evidence.fit_windows(truth, effects, recording, sigma, states=states,
                                     rescue=False, iterations=3)
    wrong, *_ = evidence.fit_windows(rival, rival_effects, recording, sigma, states=states,
                                     rescue=careful, iterations=6 if careful else 4)
    wrong = np.minimum(wrong, 1e9)
    return float(wrong.sum() - right.sum())


def make(spec, seed):
    """Return (recording, label) of a specification; raises NotDrawn."""
    random = np.random.default_rng(seed)
    options = spec.get('options', {})
    scatter = options.get('scatter', STRESS['scatter']) if spec['set'] == 'stress' else 0.0
    torque = options.get('torque', STRESS['torque']) if spec['set'] == 'stress' else 0.0
    if spec['set'] == 'stress' and 'torque' not in options:
        torque *= random.uniform()
    # Drawn once: motions that are often redrawn would become rare.
    kind = str(random.choice(motions.KINDS))
    replaced = {draw.REPLACES[i] for i in spec['ids'] if i in draw.REPLACES}
    for _ in range(TRIES):
        told = draw.nominal(random)
        truth = dict(told)
        for name in stress.SCATTERED if scatter else ():
            shift = scatter * float(np.clip(random.standard_normal(), -3, 3))
            if name not in replaced:  # its change is the effect
                truth[name] *= 1.0 + shift
        duration = float(random.uniform(10.0, 14.0))
        n = int(duration / DT)
        motion = motions.draw(kind, random, n, DT)
        seeds = [int(s) for s in random.integers(2 ** 31, size=2)]
        x, _, u, sane = _runs(truth, [], motion, torque, seeds[0])
        if sane and _moves(x, truth):
            break
    else:
        raise NotDrawn('motion')
    share = draw.log_uniform(random, 0.002, 0.02)
    sigma = share * x[:, :2].std(axis=0)
    scene = _scene(u, sigma)
    ids = spec['ids']
    forms = [draw.shape(i, random, n * DT) for i in ids]
    wanted = [draw.log_uniform(random, *((8.0, LEAST) if spec['class'] == 'small' else
                                         (LEAST * 1.3, MOST))) for _ in ids]
    sizes = [draw.log_uniform(random, *draw.SIZES[i]) for i in ids]
    if scatter:
        sizes = [max(s, PARAMETER_TOLERANCES * scatter * 1.1) if i in draw.REPLACES else s
                 for i, s in zip(ids, sizes)]
    white = _noise(np.random.default_rng(seeds[1]), n, np.ones(2), options.get('coloured')
                   and CORRELATION)
    invisible = any(i in draw.QUANTISATION for i in ids)

    def sized(sizes):
        """Return (recording, effects, states where runs begin), None where it cannot be."""
        effects = [draw.effect(i, s, f, truth, scene) for i, s, f in zip(ids, sizes, forms)]
        x, y, u, sane = _runs(truth, effects, motion, torque, seeds[0])
        if not sane or (ids and not _moves(x, {'b': 0.0})):
            return None
        recording = {'u': u, 'y': plant.quantise(y + white * sigma, effects), 'dt': DT, 'x': x}
        starts = evidence.cut(n)
        return recording, effects, x[np.maximum(starts - plant.lead_of(effects, DT), 0)]

    def larger(sizes, factors):
        """Return sizes changed by factors, within what is drawn."""
        out = []
        for size, factor, name in zip(sizes, factors, ids):
            least, most = draw.SIZES[name]
            if scatter and name in draw.REPLACES:
                least = max(least, PARAMETER_TOLERANCES * scatter * 1.1)
            out.append(float(np.clip(size * factor, least, most)))
        return out

    def evidences(found, careful=False):
        recording, effects, known = found
        return [evidence_of(recording, truth, effects, truth,
                            [e for k, e in enumerate(effects) if k != j], sigma, known, careful)
                for j in range(len(ids))]
    d = each = None
    low, high = (0.0, LEAST) if spec['class'] == 'small' else (LEAST, 4.0 * MOST)
    for sizing in range(SIZINGS):
        found = sized(sizes)
        if found is None:
            sizes = [0.6 * s for s in sizes]
            continue
        if not ids or invisible:
            break
        each = evidences(found)
        wished = all(0.2 < value / wish < 5.0 for value, wish in zip(each, wanted))
        if wished and all(low <= value <= high for value in each):
            break
        previous = list(sizes)
        sizes = larger(sizes, [np.clip(np.sqrt(wish / max(value, 1.0)), 0.1, 10.0)
                               for value, wish in zip(each, wanted)])
        if np.allclose(previous, sizes, rtol=1e-3):
            if all(low <= value <= high for value in each):
                break
            raise NotDrawn('evidence')
    else:
        raise NotDrawn('evidence')
    if each:  # again, with care for windows that stuck
        each = evidences(found, True)
        if not all(low <= value <= high for value in each):
            raise NotDrawn('evidence')
        if scatter:
            each, found = _under_scatter(found, sized, larger, sizes, ids, told, truth, sigma,
                                         scatter)
        d = each[0] if len(ids) == 1 else evidence_of(
            found[0], truth, found[1], truth, [], sigma, found[2], True)
    recording, effects, _ = found
    x = recording.pop('x')
    t = np.arange(n) * DT
    if options.get('jitter'):
        t = t + JITTER * np.clip(random.standard_normal(n), -4, 4)
    label = {
        'set': spec['set'], 'class': spec['class'], 'ids': ids, 'effects': effects,
        'options': options, 'exclude': ids if spec['class'] == 'loo' else [],
        'truth': truth, 'told': told, 'sigma': [float(s) for s in sigma], 'noise': share,
        'kind': kind, 'seeds': seeds, 'torque': torque, 'samples': n, 'd': d, 'd_each': each,
        'places': [plant.place_of(i) for i in ids], 'scatter': scatter,
        'states': x[evidence.cut(n)].tolist()}
    return {**recording, 't': t, 'told': told, 'tolerance': scatter}, label


def _under_scatter(found, sized, larger, sizes, ids, told, truth, sigma, scatter):
    """
    Return (d of each effect, found) where nominal values scatter and torque noise acts.

    Effects that these hide are made larger. found, sized, larger, sizes: see make().
    """
    # A changed nominal value has (change / tolerance)^2 at most.
    least = [PARAMETER_TOLERANCES ** 2 if i in draw.REPLACES else LEAST for i in ids]
    for _ in range(SIZINGS):
        recording, effects, known = found
        likelihood = stress.Likelihood(recording, told, truth, effects, sigma, known, scatter)
        each = likelihood.evidence(truth, effects, known)
        if all(value >= low for value, low in zip(each, least)):
            return each, found
        previous = list(sizes)
        sizes = larger(sizes, [1.0 if value >= low else float(np.clip(
            np.sqrt(1.5 * low / max(value, 1.0)), *LARGER)) for value, low in zip(each, least)])
        found = None if sizes == previous else sized(sizes)
        if found is None:
            break
    raise NotDrawn('hidden by scatter')


def model_file(told, tolerance):
    """Return the mapping of a drive.yaml."""
    return {'motor_inertia': told['m1'], 'arm_inertia': told['m2'], 'damping': told['D'],
            'viscous_friction': told['Cv'], 'coulomb_friction': told['Cc'],
            'friction_sharpness': told['alpha'], 'position_gain': told['Kr'],
            'transmission': {'kind': 'dead_zone', 'stiffness': told['K'],
                             'half_gap': told['b']},
            'effects': [], 'tolerance': tolerance}


def write(folder, recording):
    """Write recording.csv and drive.yaml into `folder`."""
    folder.mkdir(parents=True)
    table = np.column_stack([recording['t'], recording['u'], recording['y']])
    np.savetxt(folder / 'recording.csv', table, '%.9g', ',', header='t,u,motor,arm', comments='')
    (folder / 'drive.yaml').write_text(yaml.safe_dump(
        model_file(recording['told'], recording['tolerance']), sort_keys=False),
        encoding='utf-8')


def read(folder):
    """Return dict of u, y, dt of a recording.csv, on the nominal grid of time."""
    table = np.loadtxt(Path(folder) / 'recording.csv', delimiter=',', skiprows=1)
    return {'u': table[:, 1], 'y': table[:, 2:4], 'dt': DT}


def _one(arguments):
    """Make and write one recording; tries further seeds where nothing could be drawn."""
    spec, seed, base, name = arguments
    for attempt in range(40):
        try:
            recording, label = make(spec, [seed, attempt])
        except NotDrawn:
            if spec['class'] == 'pair' and attempt % 8 == 7:  # this pair may be hopeless
                able = np.random.default_rng([seed, attempt, 1])
                while True:
                    ids = [str(i) for i in able.choice(list(plant.EFFECTS), 2, replace=False)]
                    if draw.compatible(*ids):
                        spec = {**spec, 'ids': ids}
                        break
            continue
        write(Path(base) / name, recording)
        return name, {**label, 'attempts': attempt}
    return name, None


def generate(specs, folder, seed, jobs=1, progress=lambda done, total: None, sealed=None):
    """
    Write all recordings below folder/recordings and the labels; returns orders.

    sealed: the file of the labels, folder/labels.json if None.

    Orders, [{'name', 'exclude'}], are all that the diagnosis may know.
    """
    folder = Path(folder)
    base = folder / 'recordings'
    base.mkdir(parents=True)
    random = np.random.default_rng([seed, 99])
    names = [random.bytes(6).hex() for _ in specs]
    work = [(spec, int(random.integers(2 ** 31)), str(base), name)
            for spec, name in zip(specs, names)]
    labels, failed = {}, []
    pool = ProcessPoolExecutor(jobs) if jobs > 1 else None
    try:
        for name, label in (pool.map(_one, work) if pool else map(_one, work)):
            if label is None:
                failed.append(specs[names.index(name)]['ids'])
            else:
                labels[name] = label
            progress(len(labels) + len(failed), len(specs))
    finally:
        if pool:
            pool.shutdown(cancel_futures=True)
    labels = dict(sorted(labels.items()))
    Path(sealed or folder / 'labels.json').write_text(json.dumps(
        {'labels': labels, 'not_drawn': failed}, indent=1) + '\n', encoding='utf-8')
    return [{'name': name, 'exclude': label['exclude']} for name, label in labels.items()]


def counts_for(n):
    """Return how many of each class make a set of `n` recordings."""
    none, pair, outside, small = (max(1, round(share * n)) for share in (0.30, 0.12, 0.12, 0.06))
    return {'single': max(1, n - none - pair - outside - small), 'none': none, 'pair': pair,
            'outside': outside, 'small': small}
