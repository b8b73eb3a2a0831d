# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings of drives with a known deviation from their model, and the sealed labels.

A recording is a folder of random name with recording.csv (t, u or setpoint, motor, arm) and
drive.yaml (the nominal model that the diagnosis is given). The labels file alone holds what was
drawn.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks.blind import draw, motions, plant, scene, sizing, window_fit
from benchmarks.blind.scene import DT, GAIN_SPREAD, PERIOD
from benchmarks.blind.sizing import LEAST, MOST, NotDrawn
from gearbox_monitor.kernels.types import Array

Spec = Mapping[str, Any]  # set, class, ids, options: what is to be drawn

STRESS = {'scatter': 0.015, 'torque': 0.01}
CORRELATION = 0.005         # s, of coloured noise
JITTER = 1e-4               # s rms, of stamps
TRIES = 30                  # motions, until one moves the drive through its gap


def plan(counts: Mapping[str, int], random: np.random.Generator,
         sets: Sequence[str] = ('main',), options: Mapping[str, Any] | None = None) -> list[Spec]:
    """
    Return specifications of recordings, in random order.

    Args:
        counts: number of recordings by class; classes are single, none, pair, outside, small
            (d < 250) and loo.
        random: source of random numbers.
        sets: main, stress or both.
        options: of the stress set, see make(); effects: ids, to which single effects are limited.
    """
    specs: list[Spec] = []
    chosen: list[list[str]]

    def cycle(names: Iterable[str], count: int) -> list[str]:
        """Return `count` of the `names` in random order, each about as often."""
        ids = list(names)
        out: list[str] = []
        while len(out) < count:
            out += [ids[i] for i in random.permutation(len(ids))]
        return out[:count]
    options = dict(options or {})
    encoders = options.get('encoders', 'both')
    driver = options.get('input', 'torque')
    limited = options.pop('effects', None)
    inside, outside = (plant.shown(ids, encoders, driver)
                       for ids in (plant.EFFECTS, plant.OUTSIDE))
    for name in sets:
        for kind, count in counts.items():
            if kind == 'none':
                chosen = [[]] * count
            elif kind == 'outside':
                chosen = [[i] for i in cycle(outside, count)]
            elif kind == 'pair':
                able = [i for i in inside if i not in draw.NEVER_IN_PAIRS]
                chosen = []
                while len(chosen) < count:
                    a, b = random.choice(able, 2, replace=False)
                    if draw.compatible(a, b):
                        chosen.append([str(a), str(b)])
            else:
                ids = [i for i in inside if kind != 'small'
                       or i not in ('disturbance', *draw.QUANTISATION)]
                ids = [i for i in ids if not limited or i in limited]
                rivals = (count // 3 if kind == 'single' and driver == 'setpoint' and not limited
                          else 0)
                chosen = [[i] for i in (
                    *cycle((*draw.DELAYS, *draw.COMPLIANCES), rivals),
                    *cycle(ids, count - rivals))]
            specs += [{'set': name, 'class': kind, 'ids': ids, 'options': options,
                       'smooth': number % draw.SMOOTH == 0 and not {*ids} & draw.OF_COULOMB}
                      for number, ids in enumerate(chosen)]
    return [specs[i] for i in random.permutation(len(specs))]


def _noise(random: np.random.Generator, n: int, correlation: float | None) -> Array:
    """Return noise [n, 2] of unit variance, coloured where `correlation` (s) is not 0."""
    white = random.standard_normal((n, 2))
    if not correlation:
        return white
    keep = np.exp(-DT / correlation)
    out = np.empty_like(white)
    out[0] = white[0]
    for k in range(1, n):
        out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep * keep) * white[k]
    return out


def make(spec: Spec, seed: Sequence[int]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (recording, label) of `spec`, drawn from `seed`; raises NotDrawn."""
    random = np.random.default_rng(seed)
    options, ids, stressed = spec.get('options', {}), spec['ids'], spec['set'] == 'stress'
    scatter = options.get('scatter', STRESS['scatter']) if stressed else 0.0
    torque = options.get('torque', STRESS['torque']) if stressed else 0.0
    if stressed and 'torque' not in options:
        torque *= random.uniform()
    # Drawn once: motions that are often redrawn would become rare.
    driver = options.get('input', 'torque')
    every = PERIOD if driver == 'setpoint' else 1  # samples of the plant that are read
    kind = str(random.choice(motions.KINDS if every == 1 else motions.SETPOINT_KINDS))
    for _ in range(TRIES):
        place = scene.drawn(ids, kind, random, scatter, torque, driver,
                            spec.get('smooth', False))
        x, _, u, sane = place.run([])
        if sane and scene.moves(x, place.truth['b']):
            break
    else:
        raise NotDrawn('motion')
    n = len(x)
    share = draw.log_uniform(random, 0.002, 0.02)
    sigma = share * x[:, :2].std(axis=0)
    forms = [draw.shape(random, n * DT) for _ in ids]
    low, high = (0.0, LEAST) if spec['class'] == 'small' else (LEAST, 4.0 * MOST)
    wish = (8.0, LEAST) if spec['class'] == 'small' else (1.3 * LEAST, MOST)
    targets = [draw.log_uniform(random, *wish) for _ in ids]
    sizes = [max(draw.log_uniform(random, *draw.SIZES[i]), sizing.least_size(place, i))
             for i in ids]
    read = _columns(options)
    limits = {'peak': float(np.abs(u).max()), 'rms': float(np.sqrt(np.mean(u * u))) + 1e-9,
              'sigma': [float(s) for s in sigma],
              # What is not read is no evidence, and of several samples one counts.
              'read_sigma': [float(s) * np.sqrt(every) if i in read else np.inf
                             for i, s in enumerate(sigma)]}
    noise = sigma * _noise(np.random.default_rng(place.seeds[1]), n,
                           options.get('coloured') and CORRELATION)
    realisation, d, each = sizing.sized(sizing.Subject(place, forms, limits, noise), sizes,
                                        targets, low, high)
    t = np.arange(n) * DT
    recording = {name: value[::every] if np.ndim(value) else value
                 for name, value in realisation.recording.items()}
    t = t[::every]
    if options.get('jitter'):
        t = t + JITTER * np.clip(random.standard_normal(n), -4, 4)
    label = {
        'set': spec['set'], 'class': spec['class'], 'ids': ids, 'effects': realisation.effects,
        'options': options, 'exclude': ids if spec['class'] == 'loo' else [],
        'truth': place.truth, 'told': place.nominal, 'sigma': limits['sigma'], 'noise': share,
        'kind': kind, 'seeds': place.seeds, 'torque': torque, 'samples': n, 'd': d,
        'd_each': each, 'smooth': spec.get('smooth', False), 'scatter': scatter,
        'places': [plant.place_of(i) for i in ids],
        'states': realisation.x[window_fit.cut(n)].tolist()}
    return {**recording, 't': t, 'told': place.nominal, 'tolerance': scatter,
            'read': read}, label


def _columns(options: Mapping[str, Any]) -> list[int]:
    """Return the columns of y that a recording with these `options` has."""
    return {'motor': [0], 'arm': [1]}.get(options.get('encoders', 'both'), [0, 1])


def model_file(nominal: Mapping[str, float], tolerance: float) -> dict[str, Any]:
    """Return the content of a drive.yaml with `nominal` values and their `tolerance`."""
    servo = {'controller': {'kp': nominal['kp'], 'kd': nominal['kd'], 'torque_limit':
                            nominal['limit'], 'tolerance': float(f'{GAIN_SPREAD / 3 ** 0.5:.2g}')}
             } if 'kp' in nominal else {}
    return {'motor_inertia': nominal['m1'], 'arm_inertia': nominal['m2'], 'damping': nominal['D'],
            'viscous_friction': nominal['Cv'], 'coulomb_friction': nominal['Cc'],
            'friction_sharpness': nominal['alpha'], 'position_gain': nominal['Kr'],
            'transmission': {'kind': 'dead_zone', 'stiffness': nominal['K'],
                             'half_gap': nominal['b']},
            'effects': [], 'tolerance': tolerance, **servo}


def write(folder: Path, recording: Mapping[str, Any]) -> None:
    """Write recording.csv and drive.yaml of a `recording` into the new `folder`."""
    folder.mkdir(parents=True)
    read = recording['read']
    driver = 'setpoint' if 'setpoint' in recording else 'u'
    table = np.column_stack([recording['t'], recording[driver], recording['y'][:, read]])
    names = ['t', driver, *(('motor', 'arm')[i] for i in read)]
    np.savetxt(folder / 'recording.csv', table, '%.9g', ',', header=','.join(names), comments='')
    (folder / 'drive.yaml').write_text(yaml.safe_dump(
        model_file(recording['told'], recording['tolerance']), sort_keys=False),
        encoding='utf-8')


def read(folder: str | Path) -> plant.MotionRecord:
    """Return u or setpoint, y and dt of the recording.csv in `folder`, on the nominal grid."""
    path = Path(folder) / 'recording.csv'
    with path.open(encoding='utf-8') as file:
        names = file.readline().strip().split(',')
    table = dict(zip(names, np.loadtxt(path, delimiter=',', skiprows=1).T))
    unread = np.zeros(len(table['t']))
    y = np.column_stack([table.get('motor', unread), table.get('arm', unread)])
    if 'setpoint' in table:
        return {'setpoint': table['setpoint'], 'y': y, 'dt': PERIOD * DT}
    return {'u': table['u'], 'y': y, 'dt': DT}


def _one(arguments: tuple[Spec, int, str, str]) -> tuple[str, dict[str, Any] | None]:
    """Make and write one recording; tries further seeds if nothing could be drawn."""
    spec, seed, base, name = arguments
    for attempt in range(40):
        try:
            recording, label = make(spec, [seed, attempt])
        except NotDrawn:
            if spec['class'] == 'pair' and attempt % 8 == 7:  # this pair may be hopeless
                able = np.random.default_rng([seed, attempt, 1])
                options = spec['options']
                inside = plant.shown(plant.EFFECTS, options.get('encoders', 'both'),
                                     options.get('input', 'torque'))
                while True:
                    ids = [str(i) for i in able.choice(inside, 2, replace=False)]
                    if draw.compatible(*ids):
                        spec = {**spec, 'ids': ids}
                        break
            continue
        write(Path(base) / name, recording)
        return name, {**label, 'attempts': attempt}
    return name, None


def generate(specs: Sequence[Spec], folder: Path, seed: int, jobs: int = 1,
             progress: Callable[[int, int], object] = lambda done, total: None,
             sealed: Path | None = None) -> list[dict[str, Any]]:
    """
    Write all recordings below folder/recordings, and the labels.

    Args:
        specs: what is to be drawn, from plan().
        folder: new directory.
        seed: of all random numbers.
        jobs: processes that draw at once.
        progress: called with the numbers of recordings done and in all.
        sealed: file of the labels; None: folder/labels.json.

    Returns:
        Orders {'name', 'exclude'}: all that the diagnosis may know.
    """
    base = folder / 'recordings'
    base.mkdir(parents=True)
    random = np.random.default_rng([seed, 99])
    names = [random.bytes(6).hex() for _ in specs]
    work = [(spec, int(random.integers(2 ** 31)), str(base), name)
            for spec, name in zip(specs, names)]
    labels: dict[str, dict[str, Any]] = {}
    failed = []
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


def counts_for(n: int) -> dict[str, int]:
    """Return how many of each class make a set of `n` recordings."""
    shares = {'none': 0.30, 'pair': 0.12, 'outside': 0.12, 'small': 0.06}
    counts = {name: max(1, round(share * n)) for name, share in shares.items()}
    return {'single': max(1, n - sum(counts.values())), **counts}
