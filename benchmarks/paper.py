# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Tables 1 and 2 and the torque loops of the paper, beside the published numbers.

G. Hovland, "Comparison of different Kalman filters for tracking nonlinear transmission torques".
Two simulated drives, with hysteresis (A, Table 1, Figure 3) and without (B, Table 2, Figure 4).
The paper leaves torque curve, excitation and sample time unsaid; benchmarks/README.md states the
assumptions. R and Q are tuned by innovation likelihood on other seeds, never on the truth.

usage examples:
  python -m benchmarks paper
  python -m benchmarks paper --seeds 25 --json paper.json
"""
import argparse
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks import paper_adaptive, paper_curve
from benchmarks.harness import (
    add_json_option, bar_lines, BarRow, BarTable, finish, progress_line, require_whole)
from benchmarks.steps import cpu_per_step, stepper
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import smoother_parameters
from gearbox_monitor.estimation.tune import tuned as tune
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate, Trajectory

DT, SECONDS, BURN_IN = 1e-3, 20.0, 0.5
T0 = 1_000_000_000
TUNING_SEEDS = (1001, 1002, 1003)  # never judged on
RELATIVE_NOISE = 0.02  # "two percent": of the standard deviation of each state and position

CASES: dict[str, dict[str, Any]] = {
    'A': {'kind': 'play', 'stiffness': 5.0, 'half_gap': 0.3, 'hysteresis_width': 0.3},
    'B': {'kind': 'dead_zone', 'stiffness': 5.0, 'half_gap': 0.6},
}
TITLES = {'A': 'A, with hysteresis (Table 1, Figure 3)', 'B': 'B, without (Table 2, Figure 4)'}
# Published: CPU ratio, e1, e2 (rad), error of tau_K (N m).
PUBLISHED = {
    'A': {'EKF': (1.00, 0.064, 0.086, 1.120), 'UKF': (2.21, 0.118, 0.108, 1.138),
          'SRUKF': (2.25, 0.061, 0.082, 1.117), 'AEKF': (3.44, 0.159, 0.123, 1.133)},
    'B': {'EKF': (1.00, 0.059, 0.066, 0.832), 'UKF': (2.18, 0.112, 0.084, 0.827),
          'SRUKF': (2.25, 0.058, 0.0063, 0.829), 'AEKF': (3.46, 0.098, 0.078, 0.828)},
}
ADAPTED = ['q_std_tau_k', 'r_std_motor', 'r_std_arm']
FILTERS: dict[str, dict[str, Any]] = {
    'EKF': {'filter': 'ekf'},
    'EKF-SL': {'filter': 'ekf', 'friction_linearisation': 'statistical'},
    'UKF': {'filter': 'ukf'},
    'SRUKF': {'filter': 'srukf'},
    'UKF a=1e-3': {'filter': 'ukf', 'ukf_alpha': 1e-3},
    'AEKF': {'filter': 'aekf', 'adapt': ADAPTED},
    'AEKF q,k_p': {'filter': 'aekf', 'adapt': ['q_std_tau_k', 'tau_k_stiffness'],
                   'tau_k_stiffness': 1.0},
}
# Bars of this package: upper bounds of tau_K (N m), e1, e2 (rad); mean NIS.
BARS = {'A': (1.19, 0.0715, 0.0857), 'B': (1.155, 0.0667, 0.0853)}
NIS_BAR = (1.95, 2.06)
SIGMA_POINT_BAR = 0.01
LAG = 0.04  # s, of the fixed-lag smoother
SMOOTHER_BARS = {'A': {'RTS': 0.23, 'lag 40 ms': 0.34}, 'B': {'RTS': 0.20, 'lag 40 ms': 0.34}}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--seeds', type=int, default=25, help='runs per case (default: 25)')
    add_json_option(parser)


def drive(case: str) -> tuple[DriveModel, Noise, Array]:
    """Return (DriveModel, Noise, u [N]) of a `case`; noise scales with the noise-free motion."""
    model = DriveModel().exact().with_(arm_load='none', **CASES[case])
    u = Excitation().torque(DT * np.arange(round(SECONDS / DT)))
    std = simulate(model, u, DT).x.std(axis=0)
    return model, Noise(tuple(RELATIVE_NOISE * std), tuple(RELATIVE_NOISE * std[:2])), u


def run_samples(trajectory: Trajectory, y: Array | None = None) -> Samples:
    """Return the Samples of a simulated `trajectory`, with readings `y` [N, 2] if given."""
    n = len(trajectory.u)
    return Samples(T0 + np.arange(n, dtype=np.int64) * round(DT * 1e9),
                   np.column_stack([trajectory.u, np.full(n, np.nan)]),
                   trajectory.y if y is None else y)


def tuned(case: str) -> dict[str, Any]:
    """Return the parameters of a `case`: process noise as stated, q and R by likelihood."""
    model, noise, u = drive(case)
    start = {
        'arm_load': 'none', 'smoother_lag': 0.0,
        'q_std_motor_position': noise.process[0], 'q_std_arm_position': noise.process[1],
        'q_std_motor_speed': noise.process[2], 'q_std_arm_speed': noise.process[3]}
    recordings = [run_samples(simulate(model, u, DT, noise, seed)) for seed in TUNING_SEEDS]
    return tune(model, start, recordings)


def score(case: str, parameters: Mapping[str, Any], seeds: int,
          progress: Callable[[str], None]) -> dict[str, dict[str, list[float]]]:
    """
    Measure the errors of all filters from BURN_IN on.

    Args:
        case: key of CASES.
        parameters: tuned parameters of the estimator.
        seeds: runs.
        progress: called with a line of text.

    Returns:
        {filter: {figure: [one per seed]}}; e1, e2 (innovations) and f1, f2 (errors) in rad, tau in
        N m, nis.
    """
    model, noise, u = drive(case)
    first = round(BURN_IN / DT)
    figures: dict[str, dict[str, list[float]]] = {name: {} for name in FILTERS}
    for seed in range(seeds):
        trajectory = simulate(model, u, DT, noise, seed)
        samples = run_samples(trajectory)
        for name, changes in FILTERS.items():
            e = Monitor(model, {**parameters, **changes}).run(samples)
            k = (e.stamp_ns - T0) // round(DT * 1e9)
            take = k >= first
            k, rows = k[take], figures[name]
            for figure, error in (
                    ('e1', e.innovation_motor[take]), ('e2', e.innovation_arm[take]),
                    ('f1', e.x1[take] - trajectory.x[k, 0]),
                    ('f2', e.x2[take] - trajectory.x[k, 1]),
                    ('tau', e.tau_k[take] - trajectory.tau_k[k])):
                rows.setdefault(figure, []).append(float(np.sqrt(np.mean(error ** 2))))
            rows.setdefault('nis', []).append(float(e.nis[take].mean()))
        progress(f'case {case}: {seed + 1} of {seeds} runs')
    return figures


def smoothers(case: str, parameters: Mapping[str, Any], seeds: int,
              progress: Callable[[str], None]) -> dict[str, list[float]]:
    """
    Measure the error of tau_K smoothed with all that tells of it (RTS) and with a short lag.

    Returns {smoother: [root mean square error per seed, N m]}. case, parameters, seeds, progress:
    as in score().
    """
    model, noise, u = drive(case)
    smoothing = smoother_parameters(EstimatorParameters.of(parameters))
    figures: dict[str, list[float]] = {'RTS': [], 'lag 40 ms': []}
    for seed in range(seeds):
        trajectory = simulate(model, u, DT, noise, seed)
        samples = run_samples(trajectory)
        for name, chosen in (('RTS', smoothing),
                             ('lag 40 ms', smoothing.replace(smoother_lag=LAG))):
            found = Estimator(model, chosen).run(samples)
            k = (found.smoothed_stamp_ns - T0) // round(DT * 1e9)
            take = k >= round(BURN_IN / DT)
            error = found.smoothed_tau_k[take] - trajectory.tau_k[k[take]]
            figures[name].append(float(np.sqrt(np.mean(error ** 2))))
        progress(f'case {case}: smoothed {seed + 1} of {seeds} runs')
    return figures


def energy(case: str) -> tuple[float, float]:
    """Return the work of coupling and motor torque (J) in one noise-free run of a `case`."""
    model, _, u = drive(case)
    t = simulate(model, u, DT)
    power = t.tau_k * (t.x[:, 2] - t.x[:, 3])
    return float(-np.sum(power) * DT), float(np.sum(t.u * t.x[:, 2]) * DT)


def cpu(case: str, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Return the CPU time per step (s) of each filter in a `case` with tuned `parameters`."""
    model, noise, u = drive(case)
    trajectory = simulate(model, u[:5000], DT, noise, 0)
    y = np.ascontiguousarray(trajectory.y)
    return cpu_per_step({name: stepper(model, {**parameters, **changes}, trajectory.u, y, DT)
                         for name, changes in FILTERS.items()}, len(trajectory.u))


def evaluate(seeds: int,
             progress: Callable[[str], None] = lambda line: None) -> dict[str, Any]:
    """Return all figures of both cases over `seeds` runs; `progress` is called with a line."""
    data: dict[str, Any] = {'seeds': seeds, 'cases': {}}
    for case in CASES:
        progress(f'case {case}: tuning')
        parameters = tuned(case)
        figures_of = score(case, parameters, seeds, progress)
        costs = cpu(case, parameters)
        rows = {}
        for name, figures in figures_of.items():
            difference = np.subtract(figures['tau'], figures_of['EKF']['tau'])
            rows[name] = {
                **{figure: [float(np.mean(v)), float(np.std(v, ddof=1)) if seeds > 1 else 0.0]
                   for figure, v in figures.items()},
                'tau_minus_ekf': [float(difference.mean()),
                                  float(difference.std(ddof=1) / np.sqrt(seeds))
                                  if seeds > 1 else 0.0],
                'cpu': costs[name] / costs['EKF']}
        data['cases'][case] = {
            'parameters': parameters, 'filters': rows, 'energy': energy(case),
            'smoothers': {name: float(np.mean(values)) for name, values in
                          smoothers(case, parameters, seeds, progress).items()},
            'adaptive': paper_adaptive.evaluate(
                drive(case)[:2], run_samples, parameters, seeds, DT, T0, progress),
            'learned': paper_curve.evaluate(
                drive(case), run_samples, parameters, TUNING_SEEDS, seeds, DT, progress),
            'published': PUBLISHED[case]}
    data['bars'] = bars(data)
    return data


def bars(data: Mapping[str, Any]) -> list[BarRow]:
    """Return the rows of a BarTable for the figures `data` of evaluate()."""
    table = BarTable()
    add = table.judge
    for case, content in data['cases'].items():
        rows = content['filters']
        for figure, high in zip(('tau', 'e1', 'e2'), BARS[case]):
            add(f'{case} EKF {figure}', rows['EKF'][figure][0], -np.inf, high)
        add(f'{case} EKF mean NIS', rows['EKF']['nis'][0], *NIS_BAR)
        for name, high in SMOOTHER_BARS[case].items():
            add(f'{case} {name} tau', content['smoothers'][name], -np.inf, high)
        for name in ('UKF', 'SRUKF'):
            add(f'{case} {name} tau / EKF tau', rows[name]['tau'][0] / rows['EKF']['tau'][0],
                1.0 - SIGMA_POINT_BAR, 1.0 + SIGMA_POINT_BAR)
        paper_adaptive.bars(case, content['adaptive'], DriveModel().viscous_friction, add)
        paper_curve.bars(case, content['learned'], add)
    return table.rows


def text(data: Mapping[str, Any]) -> str:
    """Return tables and bars of `data` with conclusions, at most 80 columns."""
    lines: list[str] = []
    for case, content in data['cases'].items():
        lines += [f'Case {TITLES[case]}, {data["seeds"]} runs; published figures in brackets', '',
                  f'{"":<12}{"CPU":>6}{"e1 (rad)":>16}{"e2 (rad)":>16}'
                  f'{"tau_K (N m)":>23}',
                  f'{"":<12}{"/EKF":>6}{"":>16}{"":>16}{"mean +- sd":>23}']
        for name, row in content['filters'].items():
            published = content['published'].get(name)
            e1, e2, tau = (f'({v:.4g})' for v in published[1:]) if published else ('', '', '')
            lines.append(
                f'{name:<12}{row["cpu"]:6.2f}{row["e1"][0]:8.4f}'
                f'{e1:>8}{row["e2"][0]:8.4f}{e2:>8}{row["tau"][0]:8.3f} +-{row["tau"][1]:6.3f}'
                f'{tau:>8}')
        lines += ['', 'tau_K error against the EKF on the same runs (N m, standard error):']
        lines += [f'  {name:<12}{row["tau_minus_ekf"][0]:+8.4f} ({row["tau_minus_ekf"][1]:.4f})'
                  for name, row in content['filters'].items() if name != 'EKF']
        lines += ['', 'tau_K error, smoothed (N m): ' + ', '.join(
            f'{name} {value:.3f}' for name, value in content['smoothers'].items())]
        lines += ['', 'adaptive filter from wrong starts, settled tau_K error (N m):']
        lines += [f'  {name:<20}{np.mean(values):8.4f} +-{np.std(values):7.4f}'
                  for name, values in content['adaptive'].items()]
        lines += ['', *paper_curve.text(content['learned'])]
        gained, motor = content['energy']
        lines += ['', f'work of the coupling in 20 s: {gained:+.0f} J of {motor:.0f} J done by '
                  'the motor', '']
    return '\n'.join([*lines, *bar_lines(data['bars']), '', CONCLUSIONS])


CONCLUSIONS = """\
Reproduced: the size of e1, e2 and of the torque error with hysteresis, read as
one-step prediction errors against the noisy measurement; and that all four
filters track the torque alike once each is tuned.
Not reproduced: Table 2's torque error of 0.83 N m and e2 of 0.066 rad; without
hysteresis the error comes out almost as large as with it.
Cannot be a property of the algorithms: e1 of 0.118 (UKF) against 0.061 (SRUKF)
in Table 1. Both are the same estimator and agree here to all digits shown.
A misprint: e2 of 0.0063 (SRUKF, Table 2) is below the noise of the encoder.
Physics: with the paper's orientation of the hysteresis (lower branch while the
twist grows) the coupling supplies energy in case A, which no gearbox does; a
real one absorbs it (transmission kind passive_play)."""


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--seeds', args.seeds)
    expect_folder_of(args.json)
    progress = progress_line()
    data = evaluate(args.seeds, progress)
    progress('')
    return finish(data, text(data), args.json)
