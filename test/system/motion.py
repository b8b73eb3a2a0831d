# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How often a suggested motion separates two effects that a recording confused.

Each case: a pair of effects, a drive and a motion drawn at random, and the first effect as small
as that the motion tells it from the second by no more than d s2 = 2 to 15. Allowed is what this
motion took up of torque, speed and travel. Counted are the cases in which any allowed motion comes
above 20: the suggestion itself, or one of many drawn at random that share nothing with it.

usage example:
  .venv/bin/python test/system/motion.py --json motion.json
"""
import sys

import numpy as np
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, require_whole
from gearbox_monitor.diagnosis.joint.isolability import DT, motion_separations, suggest
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.files.yaml_files import expect_folder_of
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.faults import Excitation

PAIRS = (('actuator_lag', 'actuator_delay'), ('motor_viscous', 'motor_coulomb'),
         ('arm_viscous', 'arm_coulomb'), ('motor_viscous', 'arm_viscous'),
         ('motor_viscous', 'viscous_drift'), ('load_torque', 'torque_offset'),
         ('stiffness', 'hardening'), ('torque_gain', 'motor_coulomb'), ('stribeck', 'lugre'),
         ('load_friction', 'motor_coulomb'), ('arm_inertia', 'motor_inertia'),
         ('motor_encoder_eccentricity', 'arm_encoder_eccentricity'),
         ('stiffness', 'backlash_gap'), ('motor_encoder_delay', 'arm_encoder_delay'))
SECONDS = 12.0
SHARE = 0.8  # of the cases that any motion can decide


def add_arguments(parser):
    parser.add_argument('--n', type=int, default=28, metavar='N',
                        help='cases (default: %(default)s)')
    parser.add_argument('--random', type=int, default=60, metavar='M',
                        help='motions drawn for comparison in each (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=0, metavar='S')
    add_json_option(parser)


def drawn_motion(random):
    """Return the torque u [N], N m, of a random motion of peak 1 N m."""
    t = np.arange(round(SECONDS / DT)) * DT
    kind = str(random.choice(['tones', 'chirp', 'square', 'triangle', 'steps']))
    rate = 10.0 ** random.uniform(-1.0, 1.3)
    if kind == 'tones':
        count = int(random.integers(1, 5))
        rates = 10.0 ** random.uniform(-1.0, 1.3, count)
        u = Excitation('multisine', random.uniform(0.2, 1.0, count), rates).torque(t)
    elif kind == 'steps':
        hold = max(1, round(random.uniform(0.02, 1.0) / DT))
        u = np.repeat(random.uniform(-1.0, 1.0, len(t) // hold + 1), hold)[:len(t)]
        u -= u.mean()
    elif kind == 'chirp':
        u = Excitation('chirp', [1.0], sorted([rate, 10.0 ** random.uniform(-1.0, 1.5)]),
                       SECONDS).torque(t)
    else:
        u = Excitation(kind, [1.0], [rate]).torque(t)
    return u / np.abs(u).max()


def drawn_case(random):
    """Return (DriveModel, u [N], sigma [2]) of a case."""
    model = DriveModel(
        motor_inertia=random.uniform(0.004, 0.01), arm_inertia=random.uniform(0.015, 0.04),
        viscous_friction=random.uniform(0.05, 0.15), coulomb_friction=random.uniform(0.1, 0.4),
        transmission=Transmission('dead_zone', random.uniform(15.0, 40.0),
                                  random.uniform(0.02, 0.15)))
    sigma = np.full(2, 10.0 ** random.uniform(-3.0, -2.0))
    return model, random.uniform(2.0, 6.0) * drawn_motion(random), sigma


def sized_to(model, pair, u, sigma, target):
    """Return (values of the first effect with which d s2 is about `target`, Limits), or None."""
    a = pair[0]
    values = _unit(model, a)
    for _ in range(4):
        found, reached = motion_separations(model, {a: values}, u, sigma, [pair])
        if not found or not found[pair] > 0.0:
            return None
        factor = float(np.sqrt(target / found[pair]))
        if 0.9 < factor < 1.1:
            return values, reached
        values = _scaled(model, a, values, min(max(factor, 0.02), 50.0))
    return (values, reached) if 0.5 < factor < 2.0 else None


def _unit(model, name):
    """Return usual values of the effect `name`."""
    table = {'actuator_lag': {'T': 1e-3}, 'stribeck': {'Cs': 0.05, 'vs': 1.0},
             'motor_encoder_delay': {'T': 1e-3}, 'load_torque': {'TL': 0.05},
             'load_friction': {'Cl': 0.05}, 'torque_gain': {'g': 0.05},
             'arm_viscous': {'Cav': 0.005}, 'motor_encoder_eccentricity': {'A': 0.01, 'phi': 1.0}}
    if name in table:
        return table[name]
    base, parameter = _base(model, name)
    return {parameter: 1.1 * base}


def _base(model, name):
    effect = EFFECTS[name]
    t = model.transmission
    where = effect.replaces
    return getattr(t if hasattr(t, where) else model, where), effect.parameters[0].name


def _scaled(model, name, values, factor):
    """Return `values` with the size of the effect times `factor`."""
    first = next(iter(values))
    out = dict(values)
    if EFFECTS[name].replaces:
        base, _ = _base(model, name)
        out[first] = base + min(factor * (values[first] - base), 3.0 * base)
    else:
        out[first] = values[first] * factor
        if name == 'load_friction':
            out[first] = min(out[first], 0.9)
        elif name in ('actuator_lag', 'motor_encoder_delay'):
            out[first] = min(out[first], 0.019)
    return out


def case(pair, random, count):
    """Return the figures of one case, or None where it could not be drawn."""
    model, u, sigma = drawn_case(random)
    target = float(random.uniform(2.0, 15.0))
    sized = sized_to(model, pair, u, sigma, target)
    if sized is None:
        return None
    values, limits = sized
    effects = {pair[0]: values}
    motions = suggest(model, effects, [pair], limits, sigma, SECONDS)
    best = 0.0
    for _ in range(count):
        v = limits.torque * random.uniform(0.2, 1.0) * drawn_motion(random)
        found, reached = motion_separations(model, effects, v, sigma, [pair])
        if (found and reached.speed <= limits.speed and reached.travel <= limits.travel):
            best = max(best, found[pair])
    return {'pair': '|'.join(pair), 'values': values, 'before': target,
            'suggested': motions[0].least if motions else 0.0, 'drawn': best,
            'motion': motions[0].kind if motions else None, 'limits': vars(limits)}


def evaluate(n, count, seed, progress=lambda: None):
    """Return the figures of `n` cases."""
    random = np.random.default_rng(seed)
    rows = []
    for k in range(n):
        row = None
        while row is None:
            row = case(PAIRS[k % len(PAIRS)], random, count)
        rows.append(row)
        progress()
    can = [r for r in rows if max(r['suggested'], r['drawn']) > THRESHOLDS.isolable]
    does = [r for r in can if r['suggested'] > THRESHOLDS.isolable]
    bars = BarTable()
    bars.judge('separated where any motion can', len(does) / len(can) if can else None, low=SHARE,
               count=f'{len(does)}/{len(can)}')
    return {'rows': rows, 'can': len(can), 'does': len(does), 'bars': bars.rows}


def text(data):
    """Return the table for the terminal."""
    lines = [f'{"pair":<52}{"before":>7}{"suggested":>10}{"drawn":>9}']
    lines += [f'{r["pair"][:51]:<52}{r["before"]:7.1f}{r["suggested"]:10.3g}{r["drawn"]:9.3g}'
              for r in data['rows']]
    lines += ['', f'd s2 of the best motion; above {THRESHOLDS.isolable:g} '
              'two effects are distinguishable']
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when the bar is missed."""
    require_whole('--n', args.n)
    require_whole('--random', args.random)
    expect_folder_of(args.json)
    with tqdm(total=args.n, desc='cases', disable=None, leave=False) as bar:
        data = evaluate(args.n, args.random, args.seed, bar.update)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
