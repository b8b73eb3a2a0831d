# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Coverage of ranges: how often a new simulated drive lies in the 90 % range of others.

Each population has drives whose friction, armature and damping scatter about common values by a
logarithmic deviation of its own, and a delay of the torque. Some of them are simulated with
encoder noise and fitted; then a new drive is drawn.

usage examples:
  python -m benchmarks ranges --populations 40 --drives 6 --seed 1
"""
import argparse
import math
from typing import Any

import numpy as np

from benchmarks.harness import (
    add_json_option, bar_lines, BarTable, finish, progress_line, require_whole)
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.diagnosis.joint.parameter_ranges import ranges_of, UnitEstimate
from gearbox_monitor.errors import Undecided
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, simulate

RATE, SECONDS, NOISE = 500.0, 10.0, 2e-5  # Hz, s, rad
CENTRE = {'m1': 0.03, 'Cv': 0.1, 'Cc': 0.27, 'actuator_delay.T': 0.008}
DEVIATIONS = (0.03, 0.25)  # of the logarithm, between drives: drawn for each population
LIGHT = 1e-6
LOW, HIGH = 0.85, 0.95


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--populations', metavar='N', type=int, default=40)
    parser.add_argument('--drives', metavar='N', type=int, default=6, help='in each population')
    parser.add_argument('--fresh', metavar='N', type=int, default=4,
                        help='new drives of each population')
    parser.add_argument('--seed', metavar='N', type=int, default=0)
    add_json_option(parser)


def drive(values: dict[str, float]) -> DriveModel:
    """Return a rigid drive with `values`."""
    return DriveModel().with_(
        kind='rigid', position_gain=0.0, arm_inertia=LIGHT, motor_inertia=values['m1'],
        viscous_friction=values['Cv'], coulomb_friction=values['Cc'], tolerance=0.3,
        effects=({'id': 'actuator_delay', 'T': values['actuator_delay.T']},))


def identified(values: dict[str, float], rng: np.random.Generator) -> UnitEstimate:
    """Return the estimate of a simulated drive from one recording."""
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    u = np.zeros(len(t))
    for a, f in ((0.9, 0.4), (0.6, 1.3), (0.4, 3.1)):
        u += a * np.sin(2.0 * math.pi * f * t + rng.uniform(0.0, 2.0 * math.pi))
    run = simulate(drive(values), u, 1.0 / RATE, Noise(measurement=(NOISE, NOISE)),
                   int(rng.integers(1 << 31)))
    model = drive(CENTRE)
    recording = load_recording({'t': t, 'torque': u, 'motor': np.full(len(t), np.nan),
                                'arm': run.y[:, 1]}, model, name='drive').uniform()[0]
    fit = fit_nominal([recording], model, ['m1', 'Cv', 'Cc', 'actuator_delay'])
    return UnitEstimate.of('drive', fit.values, fit.covariance)


def population(rng: np.random.Generator, drives: int, fresh: int) -> dict[str, list[bool]]:
    """Return {parameter: whether each new drive is in its range} of one population."""
    low, high = map(math.log, DEVIATIONS)
    deviation = dict(zip(CENTRE, np.exp(rng.uniform(low, high, len(CENTRE)))))

    def drawn() -> dict[str, float]:
        return {name: value * math.exp(deviation[name] * rng.standard_normal())
                for name, value in CENTRE.items()}
    ranges = ranges_of([identified(drawn(), rng) for _ in range(drives)])
    inside: dict[str, list[bool]] = {}
    for _ in range(fresh):
        for name, value in drawn().items():
            i = ranges.index(name)
            if i is not None:
                inside.setdefault(name, []).append(bool(ranges.low[i] <= value <= ranges.high[i]))
    return inside


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--populations', args.populations)
    require_whole('--drives', args.drives, 2)
    require_whole('--fresh', args.fresh)
    require_whole('--seed', args.seed, 0)
    rng, show = np.random.default_rng(args.seed), progress_line()
    shares: dict[str, list[float]] = {name: [] for name in CENTRE}
    undecided = 0
    for k in range(args.populations):
        show(f'population {k + 1} of {args.populations}')
        try:
            inside = population(rng, args.drives, args.fresh)
        except Undecided:
            undecided += 1
            continue
        for name, hits in inside.items():
            shares[name].append(float(np.mean(hits)))
    show('')
    bars, rows = BarTable(), {}
    for name, share in shares.items():
        mean = float(np.mean(share)) if share else math.nan
        # New drives of one population share its ranges: the population is the unit of chance.
        error = (float(np.std(share, ddof=1) / math.sqrt(len(share)))
                 if len(share) > 1 else math.nan)
        rows[name] = {'share': mean, 'low': mean - 1.645 * error, 'high': mean + 1.645 * error}
        bars.judge(f'{name}: share of new drives in the 90 % range', mean, LOW, HIGH)
    data: dict[str, Any] = {'populations': args.populations, 'drives': args.drives,
                            'seed': args.seed, 'undecided': undecided, 'shares': rows,
                            'bars': bars.rows}
    lines = [f'{name:<20}{r["share"]:6.3f}  ({r["low"]:.3f} to {r["high"]:.3f})'
             for name, r in rows.items()]
    return finish(data, '\n'.join([f'{args.populations} populations of {args.drives} drives, '
                                   f'{undecided} undecided; seed {args.seed}', *lines,
                                   *bar_lines(bars.rows)]), args.json)
