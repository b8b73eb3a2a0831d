# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
CPU time of the filters' steps and of replay, from one interleaved run, against their bars.

Case A of "benchmarks paper" at 1 kHz, one thread. filterpy's filters take the same model, written
in numpy, as a user would; they come with "pip install filterpy". An EKF in C++ with Eigen is
compiled where a compiler and Eigen 3.3 or newer are found; the bar is set by the usual tangent
I + hA + h^2A^2/2, cheaper than the exact one that our EKF takes. Replay: a simulated recording of
10 minutes (lz4) through the EKF into a Parquet file, per sample: estimates only (to CSV and to a
bag as well), those with the unknown load on the arm that is the default, everything (default);
rosbags decodes the same.
Free runs and their slopes: 16 s. Start-up: a process of its own each time, kernels cached.

usage examples:
  python -m benchmarks speed --json speed.json
  python -m benchmarks speed --eigen path/to/eigen3
"""
import argparse
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

from benchmarks import eigen_reference, filterpy_user, free_run, replay_cost, startup
from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, require_whole
from benchmarks.paper import drive, DT
from benchmarks.replay_cost import FIXED
from benchmarks.steps import cpu_per_step, estimator, stepper
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.plant.simulate import simulate

SAMPLES, FEW = 5000, 300  # of our filters, and of filterpy's
FILTERS: dict[str, dict[str, Any]] = {
    'EKF': {'filter': 'ekf'},
    'EKF, unknown load': {'filter': 'ekf', 'arm_load': 'unknown'},
    'EKF, elastic': {'filter': 'ekf', 'tau_k_model': 'elastic'},
    'EKF, learned': {'filter': 'ekf', 'tau_k_model': 'learned'},
    'UKF': {'filter': 'ukf'},
    'SRUKF': {'filter': 'srukf'},
    'AEKF, 1 theta': {'filter': 'aekf', 'adapt': ['q_std_tau_k']},
    'AEKF, 3 theta': {'filter': 'aekf', 'adapt': ['q_std_tau_k', 'r_std_motor', 'r_std_arm']},
}
LAWS = {'estimates, EKF': 'random_walk', 'estimates, mixed': 'mixed'}
# bar: (value from {name: s per step, or of a start}, lowest, highest)
BARS: dict[str, tuple[Callable[[Mapping[str, float]], float], float, float]] = {
    'EKF elastic / EKF': (lambda t: t['EKF, elastic'] / t['EKF'], 0.0, 1.3),
    'EKF learned / EKF': (lambda t: t['EKF, learned'] / t['EKF'], 0.0, 2.5),
    'three models mixed / EKF, with their estimates': (
        lambda t: t['estimates, mixed'] / t['estimates, EKF'], 0.0, 5.0),
    'EKF / Eigen EKF': (lambda t: t['EKF'] / t['Eigen EKF'], 0.0, 0.9),
    'filterpy EKF / EKF': (lambda t: t['filterpy EKF'] / t['EKF'], 150.0, np.inf),
    'filterpy UKF / UKF': (lambda t: t['filterpy UKF'] / t['UKF'], 150.0, np.inf),
    'filterpy UKF / SRUKF': (lambda t: t['filterpy UKF'] / t['SRUKF'], 150.0, np.inf),
    'AEKF with 1 theta / Eigen EKF': (lambda t: t['AEKF, 1 theta'] / t['Eigen EKF'], 0.0, 2.6),
    'each further theta / Eigen EKF': (
        lambda t: (t['AEKF, 3 theta'] - t['AEKF, 1 theta']) / 2.0 / t['Eigen EKF'], 0.0, 1.3),
    'replay, estimates only, x real time': (
        lambda t: 1.0 / replay_cost.RATE / t['replay, estimates only'], 1500.0, np.inf),
    'rosbags / decoding': (
        lambda t: t['rosbags, decoding'] / t['replay, decoding alone'], 25.0, np.inf),
    'start and first step / import scipy.optimize': (
        lambda t: t['first step'] / t['import scipy.optimize'], 0.0, 3.0),
    'best solve_ivp / simulate': (
        lambda t: min(t[f'solve_ivp {name}'] for name in free_run.SETTINGS) / t['simulate'],
        100.0, np.inf),
    'slopes in 7 parameters / free run': (
        lambda t: t['slopes in 7 parameters'] / t['free run'], 0.0, 2.5),
    'decoding / EKF': (lambda t: t['replay, decoding alone'] / t['EKF'], 0.0, 1.0),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--rounds', type=int, default=15,
                        help='interleaved rounds; medians count (default: 15)')
    parser.add_argument('--eigen', metavar='DIR',
                        help='folder with Eigen/Core (default: '
                        f'{eigen_reference.VARIABLE}, pkg-config, /usr/include/eigen3)')
    add_json_option(parser)


def evaluate(rounds: int, eigen: str | None = None) -> dict[str, Any]:
    """Return all figures over `rounds`; `eigen`: folder of its headers, None: search for it."""
    model, noise, u = drive('A')
    run = simulate(model, u[:SAMPLES], DT, noise, 0)
    y = np.ascontiguousarray(run.y)
    rows: dict[str, Callable[[], object]] = {
        name: stepper(model, {**FIXED, **changes}, run.u, y, DT)
        for name, changes in FILTERS.items()}
    counts: dict[str, float] = {}
    skipped = {}  # {word in a bar's name: why it is skipped}
    with ExitStack() as stack:
        try:
            compiled = stack.enter_context(eigen_reference.library(eigen))
            rows.update(eigen_reference.steppers(compiled, model, FIXED, run.u, y, DT))
        except InputError as error:
            skipped['Eigen'] = str(error)
        counts.update(dict.fromkeys(rows, SAMPLES))
        try:
            filterpy_rows = filterpy_user.steppers(
                model, noise.measurement, run.u[:FEW], y[:FEW], DT)
            counts.update(dict.fromkeys(filterpy_rows, FEW))
            rows.update(filterpy_rows)
        except InputError as error:
            skipped['filterpy'] = str(error)
        for name, law in LAWS.items():
            rows[name] = estimator(model, {**FIXED, 'tau_k_model': law}, run.u, y, DT)
            counts[name] = SAMPLES
        for functions, samples_of in (free_run.steppers(),
                                      stack.enter_context(replay_cost.steppers())):
            rows.update(functions)
            counts.update(samples_of)
        times = cpu_per_step(rows, counts, rounds)
    starts = startup.cpu_seconds(rounds)
    bars = BarTable()
    for bar, (value, low, high) in BARS.items():
        reason = next((text for word, text in skipped.items() if word in bar), None)
        if reason:
            bars.skip(bar, reason)
        else:
            bars.judge(bar, value({**times, **starts}), low or -np.inf, high)
    return {'rounds': rounds, 'seconds_per_step': times, 'seconds_to_start': starts,
            'bars': bars.rows}


def text(data: Mapping[str, Any]) -> str:
    """Return the figures `data` of evaluate() as a table for the terminal."""
    times = data['seconds_per_step']
    lines = ['CPU time per step or sample (median), and as a multiple of a step of the EKF:', '']
    lines += [f'  {name:<24}{1e9 * value:10.0f} ns{value / times["EKF"]:9.2f}'
              for name, value in times.items()] + ['']
    lines += [f'  {name + ", CPU":<24}{value:13.2f} s'
              for name, value in data['seconds_to_start'].items()] + ['']
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--rounds', args.rounds)
    expect_folder_of(args.json)
    if args.eigen:
        eigen_reference.find_eigen(args.eigen)  # what was asked for is not skipped
    data = evaluate(args.rounds, args.eigen)
    return finish(data, text(data), args.json)
