# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Trust indicators and drift alerts: false alarms, detected faults, and delay of detection.

Simulated drives: A and B of "benchmarks paper" (with and without hysteresis), with R and Q by
likelihood and the fixed EKF, each with and without a load on the arm; and the packaged drive with
the packaged parameters. With DATA, the folder davinci_backend, also the backlash of a real drive
over its 20 recordings. Drives drawn within the tolerances of the model show whether the stated
deviation of tau_K covers its error. benchmarks/README.md explains the tables.

usage examples:
  python -m benchmarks trust
  python -m benchmarks trust --quick
  python -m benchmarks trust --tolerances 100 --filters ekf srukf
  python -m benchmarks trust path/to/davinci_backend --json trust.json
"""
import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from benchmarks import (
    intervals, paper, trust_cost, trust_drift, trust_real, trust_runs, trust_tolerances)
from benchmarks.harness import (
    add_json_option, bar_lines, BarTable, finish, interval_text, progress_line, require_whole)
from benchmarks.steps import cpu_per_step, stepper
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.parameters import FILTER_NAMES
from gearbox_monitor.plant.simulate import simulate

Progress: TypeAlias = Callable[[str], None]
Size: TypeAlias = Mapping[str, Any]  # a value of SIZES
Row: TypeAlias = dict[str, Any]      # figures as plain data

CASES = ('A', 'B')
HEALTHY_SEED, LEARNING_SEED, FAULT_SEED, DELAY_SEED, DRAW_SEED = 1, 50, 100, 1000, 7
ONSET, FAULTY = 12.0, 30.0  # s before a fault, and with it
# Seconds of a run without fault, runs per fault, runs per step and per ramp of the backlash,
# seconds for the shift by friction, seconds that the baseline is learnt from, hours of drift
# windows, recordings for tuning, whether drives with an arm load are tuned separately, drives
# within the tolerances per motion and load.
SIZES: dict[str, Size] = {
    'default': {'healthy': 3600.0, 'faults': 8, 'changes': 24, 'ramps': 6, 'shift': 600.0,
                'learning': 7210.0, 'hours': 72.0, 'tuning': 3, 'tune_load': True, 'drives': 24},
    'quick': {'healthy': 300.0, 'faults': 1, 'changes': 2, 'ramps': 1, 'shift': 200.0,
              'learning': 1200.0, 'hours': 6.0, 'tuning': 1, 'tune_load': False, 'drives': 2},
}
# Bars.
MAX_FLAGGED, MAX_ALARMS = 0.02, 0
MIN_FOUND = {'noise x1.2': 0.80, 'Cv x1.2': 0.98, 'motor frozen': 0.98, 'arm frozen': 0.98}
GAP_STD, GAP_BIAS = {'A': 0.010, 'B': 0.006}, {'A': 2.5, 'B': 1.5}  # rad; %
STATED = 1.5            # stated over empirical deviation, or its inverse
MAX_SHIFT = 0.005       # of the backlash, by 10 % of Cv
GROWTH = 0.01
MAX_DELAY = 180.0                       # s, mean, for GROWTH with the default setting
MAX_DELAY_DAILY = {'A': 110.0, 'B': 60.0}   # s, at one false alarm per day
MAX_COST, MAX_COST_ALL = 1.0, 10.0      # EKF steps


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('data', metavar='DATA', nargs='?',
                        help='folder with the recordings XY.TXT.gz of davinci_backend')
    add_json_option(parser)
    parser.add_argument('--seeds', type=int, metavar='N',
                        help='runs per fault and case (default: 8, quick: 2)')
    parser.add_argument('--quick', action='store_true',
                        help='small samples, about a minute: shows that all works, its verdicts '
                        'are coarse')
    parser.add_argument('--tolerances', type=int, metavar='N',
                        help='only the stated deviations, on N drives within the tolerances of '
                        'the model per motion and load')
    parser.add_argument('--filters', nargs='+', metavar='FILTER', choices=FILTER_NAMES,
                        default=['ekf'], help='filters measured with --tolerances (default: ekf)')
    parser.add_argument('--tune', action='store_true',
                        help='with --tolerances: R and Q tuned by likelihood for each motion')
    parser.add_argument('--full', action='store_true',
                        help='simulate all 72 h of each case instead of drawing their windows '
                        'from an hour; takes an hour')


# ---------------------------------------------------------------------- measurements

def healthy_runs(size: Size, progress: Progress) -> tuple[
        dict[str, trust_runs.SimulatedDrive], dict[str, trust_runs.MonitoredRun]]:
    """Return all drives and their runs without fault by name, of a `size`; tell `progress`."""
    drives: dict[str, trust_runs.SimulatedDrive] = {}
    runs: dict[str, trust_runs.MonitoredRun] = {}
    seeds = paper.TUNING_SEEDS[:size['tuning']]
    for name in (*(f'{case}{load}' for case in CASES for load in ('', ', arm load')), 'packaged'):
        progress(f'{name}: tuning')
        if name == 'packaged':
            drive = trust_runs.packaged_drive()
        elif name in CASES:
            drive = trust_runs.paper_drive(name, False, seeds)
        else:
            case = name[0]
            drive = trust_runs.paper_drive(case, True, seeds, None if size['tune_load'] else {
                **drives[case].parameters, 'arm_load': 'unknown'})
        progress(f'{name}: running without fault')
        drives[drive.name] = drive
        runs[drive.name] = trust_runs.watch(drive, size['healthy'], HEALTHY_SEED,
                                            parameters=trust_drift.SMOOTHED)
    return drives, runs


def healthy_table(runs: Mapping[str, trust_runs.MonitoredRun], size: Size,
                  bars: BarTable) -> list[Row]:
    """
    Count false alarms.

    Args:
        runs: runs without fault, by the name of the drive.
        size: extent of the benchmark.
        bars: collects the bars.

    Returns:
        One row per drive: flagged shares and alarms.
    """
    hours = size['healthy'] / 3600.0
    rows: list[Row] = []
    for name, run in runs.items():
        hits, total = int(run.any().sum()), len(run.began)
        alarms = sum(run.alarms().values())
        rows.append({
            'drive': name, 'windows': total, 'alarms': alarms, 'hours': hours,
            'alarms_of': {k: v for k, v in run.alarms().items() if v},
            'alarms_interval': intervals.rate(alarms, hours),
            **{test: float(run.flags[test].mean()) for test in trust_runs.TESTS},
            'any': hits / total, 'interval': intervals.share(hits, total)})
        bars.judge(f'{name}: windows flagged', hits / total, high=MAX_FLAGGED,
                   interval=rows[-1]['interval'])
        bars.judge(f'{name}: alarms in {hours:.3g} h', alarms, high=MAX_ALARMS,
                   interval=[v * hours for v in rows[-1]['alarms_interval']])
    return rows


def fault_table(drive: trust_runs.SimulatedDrive, reference: float, runs: int, bars: BarTable,
                progress: Progress) -> list[Row]:
    """
    Measure which faults are detected, and how soon.

    Args:
        drive: simulated drive.
        reference: usual deviation of tau_K, N m.
        runs: runs per fault.
        bars: collects the bars.
        progress: called with the name of each fault.

    Returns:
        One row per fault: flagged shares by test, delay of the first alarm.
    """
    rows: list[Row] = []
    makers: dict[str, trust_runs.FaultsAt | None] = {
        **trust_runs.faults(drive.noise), **dict.fromkeys(trust_runs.MISTUNED)}
    for fault, make in makers.items():
        flags_of_runs, delays, components = [], [], []
        for run in range(runs):
            # Anywhere within the second between two evaluations, and in the excitation.
            start = ONSET + run * (1.0 + 1.0 / runs) if make else 0.0
            extra = None if make else {
                'q_std_tau_k': drive.parameters['q_std_tau_k']
                * np.sqrt(trust_runs.MISTUNED[fault])}
            watched = trust_runs.watch(
                drive, start + FAULTY, FAULT_SEED + run, make(start) if make else None, extra,
                reference)
            faulty = watched.began >= start
            flags_of_runs.append(np.array([
                *(watched.flags[t][faulty] for t in trust_runs.TESTS), watched.any()[faulty]]))
            if make:
                delay, name = watched.delay(start)
                if delay is not None:
                    delays.append(delay)
                    components.append(name)
        flags = np.concatenate(flags_of_runs, axis=1)
        hits, total = int(flags[-1].sum()), flags.shape[1]
        rows.append({
            'fault': fault, 'windows': total, 'any': hits / total,
            **{test: float(flags[i].mean()) for i, test in enumerate(trust_runs.TESTS)},
            'interval': intervals.share(hits, total), 'runs': runs if make else 0,
            'found': len(delays), 'delays': delays,
            'delay': float(np.mean(delays)) if delays else None,
            'delay_interval': intervals.mean(delays) if delays else None,
            'first': max(set(components), key=components.count) if components else None})
        if fault in MIN_FOUND:
            bars.judge(f'{drive.name}: {fault}, windows found', hits / total, low=MIN_FOUND[fault],
                       interval=rows[-1]['interval'])
        progress(f'{drive.name}: {fault}')
    return rows


def gap_figures(drive: trust_runs.SimulatedDrive, windows: Sequence[Backlash], size: Size,
                bars: BarTable, progress: Progress) -> Row:
    """
    Compare the estimated backlash with the true one.

    Args:
        drive: simulated drive.
        windows: drift windows of its run without fault.
        size: extent of the benchmark.
        bars: collects the bars.
        progress: called before the long part.

    Returns:
        Bias, deviations, correlation of neighbours, shift by friction, and the scatter of means
        over a minute, of windows and of the gap that the filter learns.
    """
    case, truth = drive.name, trust_drift.true_gap(drive.model)
    gaps = trust_drift.gaps(windows)[1:]  # the first window begins at rest
    if len(gaps) < 3:
        bars.judge(f'{case}: windows with a gap', len(gaps), low=3)
        return {'windows': len(gaps)}
    progress(f'{case}: gap under changed friction')
    stated = float(np.sqrt(np.mean([w.gap_std ** 2 for w in windows[1:]])))
    std, bias = float(gaps.std(ddof=1)), float(gaps.mean() / truth - 1.0)
    neighbours = float(np.corrcoef(gaps[1:], gaps[:-1])[0, 1])
    error = std / np.sqrt(len(gaps)) / truth
    progress(f'{case}: gap that the filter learns')
    minutes = [trust_drift.minute_scatter(v) for v in (gaps, trust_drift.learned_gaps(
        drive, trust_drift.PERIOD * (len(gaps) + 1), HEALTHY_SEED + 3)[1:])]
    shift = trust_drift.friction_shift(drive, size['shift'], HEALTHY_SEED + 1)
    bars.judge(f'{case}: gap, deviation (rad)', std, high=GAP_STD[case],
               interval=intervals.spread(gaps))
    bars.judge(f'{case}: gap, bias (%)', 100 * bias, -GAP_BIAS[case], GAP_BIAS[case],
               interval=[100 * (bias - 2 * error), 100 * (bias + 2 * error)])
    bars.judge(f'{case}: stated / empirical deviation', stated / std, 1 / STATED, STATED,
               interval=[stated / v for v in intervals.spread(gaps)[::-1]])
    bars.judge(f'{case}: gap, shift by 10 % of Cv', shift, high=MAX_SHIFT)
    return {'windows': len(gaps), 'truth': truth, 'mean': float(gaps.mean()), 'std': std,
            'bias': bias, 'stated': stated, 'neighbours': neighbours, 'shift': shift,
            'minute': minutes[0], 'learned_minute': minutes[1]}


def drift_figures(drive: trust_runs.SimulatedDrive, windows: Sequence[Backlash], size: Size,
                  full: bool, bars: BarTable, progress: Progress) -> Row:
    """
    Measure false alarms and delays of the drift alert.

    Args:
        drive: simulated drive.
        windows: drift windows of its run without fault.
        size: extent of the benchmark.
        full: whether all hours are simulated instead of drawn from `windows`.
        bars: collects the bars.
        progress: called before each long part.

    Returns:
        False alarms and, for each change of the backlash, delays.
    """
    case, random = drive.name, np.random.default_rng(DRAW_SEED)
    measured = trust_drift.measured(windows)[1:]
    if len(measured) <= trust_drift.BLOCK:
        bars.judge(f'{case}: windows for drift', len(measured), low=trust_drift.BLOCK + 1)
        return {}
    progress(f'{case}: {size["hours"]:g} h of drift windows')
    # The baseline comes from a separate run: judged windows must be new.
    learnt = trust_runs.watch(drive, size['learning'], LEARNING_SEED, None, trust_drift.SMOOTHED,
                              flags=False).windows[1:]
    known = {name: trust_drift.trained(learnt, trust_drift.settings(drive, interval))
             for name, interval in (('yearly', None), ('daily', trust_drift.DAY))}
    count = round(size['hours'] * 3600.0 / trust_drift.PERIOD)
    days: Sequence[trust_drift.Features]
    if full:
        days = trust_runs.watch(drive, size['hours'] * 3600.0, HEALTHY_SEED + 2, None,
                                trust_drift.SMOOTHED, flags=False).windows
    else:
        days = trust_drift.drawn(measured, count, random)
    alarms = {name: trust_drift.false_alarms(health, trust_drift.later(days, health))
              for name, health in known.items()}
    hours = size['hours']
    bars.judge(f'{case}: drift alarms in {hours:g} h', alarms['yearly'], high=0,
               interval=[v * hours for v in intervals.rate(alarms['yearly'], hours)])
    result: Row = {'hours': hours, 'simulated': full, 'alarms': alarms, 'delays': {}}
    for change, growth, runs, ramp in (
            (f'+{100 * GROWTH:g} %', GROWTH, size['changes'], False),
            ('+2 %', 0.02, size['changes'] // 2, False),
            ('5 %/h', trust_drift.SLOW, size['ramps'], True)):
        progress(f'{case}: gap grows by {change}')
        delays_of = trust_drift.delays(drive, known, growth, runs, DELAY_SEED, ramp)
        for name, delays in delays_of.items():
            detected = [d for d in delays if d is not None]
            result['delays'][f'{change} {name}'] = {
                'runs': len(delays), 'found': len(detected), 'values': delays,
                'mean': float(np.mean(detected)) if detected else None,
                'interval': intervals.mean(detected) if detected else None,
                'worst': max(detected) if detected else None}
    for change, name, high in (('+1 %', 'yearly', MAX_DELAY),
                               ('+1 %', 'daily', MAX_DELAY_DAILY[case])):
        row = result['delays'][f'{change} {name}']
        # A change without an alarm counts as detected at the end.
        mean = float(np.mean([trust_drift.JUMP_TIME if d is None else d for d in row['values']]
                             or [np.inf]))
        bars.judge(f'{case}: {change} found ({name}), s', mean, high=high,
                   interval=row['interval'])
    row = result['delays']['5 %/h yearly']
    bars.judge(f'{case}: ramps of 5 %/h found', row['found'] / max(row['runs'], 1), low=1.0,
               interval=intervals.share(row['found'], row['runs']))
    return result


def costs(drive: trust_runs.SimulatedDrive) -> dict[str, float]:
    """
    Return CPU time per sample of a `drive` over that of an EKF step, medians of rounds.

    trust: see trust_cost; monitor: the whole Monitor with the plain EKF; all: with AEKF, smoother
    and drift, too.
    """
    _, _, u = paper.drive(drive.name)
    trajectory = simulate(drive.model, u, paper.DT, drive.noise, 0)
    samples, n = paper.run_samples(trajectory), len(trajectory.u)
    plain = {**drive.parameters, 'smoother_lag': 0.0}
    everything = {**drive.parameters, **paper.FILTERS['AEKF'], **trust_drift.SMOOTHED}
    costs_of = cpu_per_step({
        'step': stepper(drive.assumed, plain, trajectory.u, np.ascontiguousarray(trajectory.y),
                        paper.DT),
        'monitor': lambda: Monitor(drive.assumed, plain).run(samples),
        'all': lambda: Monitor(drive.assumed, everything).run(samples)}, n)
    return {'step_us': 1e6 * costs_of['step'],
            'trust': trust_cost.cost_ratio(drive.parameters)['ratio'],
            'monitor': costs_of['monitor'] / costs_of['step'],
            'all': costs_of['all'] / costs_of['step']}


def within_tolerances(filters: Sequence[str], drives: int, tune: bool, progress: Progress) -> Row:
    """
    Run the measurement of the stated deviations alone.

    Args:
        filters: by name.
        drives: number per motion and load.
        tune: whether R and Q are tuned for each motion.
        progress: called before each part.

    Returns:
        Figures and bars as plain data.
    """
    bars = BarTable()
    rows = trust_tolerances.evaluate(filters, drives, bars, progress, tune)
    return {'drives': drives, 'tune': tune, 'tolerances': rows, 'bars': bars.rows}


def evaluate(size: Size, full: bool = False, data: str | Path | None = None,
             progress: Progress = lambda line: None) -> Row:
    """
    Run all measurements.

    Args:
        size: extent of the benchmark, see SIZES.
        full: whether the hours of drift windows are simulated instead of drawn.
        data: folder of davinci_backend; None: leave out the real drive.
        progress: called before each long part.

    Returns:
        All figures and bars as plain data.
    """
    bars = BarTable()
    drives, runs = healthy_runs(size, progress)
    result: Row = {'size': size, 'full': full, 'healthy': healthy_table(runs, size, bars),
                   'faults': {}, 'gap': {}, 'drift': {}}
    for case in CASES:
        drive, run = drives[case], runs[case]
        result['faults'][case] = fault_table(drive, run.tau_k_std, size['faults'], bars, progress)
    for case in CASES:
        drive, windows = drives[case], runs[case].windows
        result['gap'][case] = gap_figures(drive, windows, size, bars, progress)
        result['drift'][case] = drift_figures(drive, windows, size, full, bars, progress)
    if data is not None:
        progress('davinci_backend')
        result['real'] = trust_real.figures(data, bars)
    result['tolerances'] = trust_tolerances.evaluate(('ekf',), size['drives'], bars, progress)
    progress('cost')
    result['cost'] = costs(drives['A'])
    bars.judge('trust, EKF steps per sample', result['cost']['trust'], high=MAX_COST)
    bars.judge('all with AEKF and smoother', result['cost']['all'], high=MAX_COST_ALL)
    result['bars'] = bars.rows
    return result


# ---------------------------------------------------------------------- tables

def _percent(row: Values) -> str:
    return ''.join(f'{100 * row[test]:7.1f}' for test in trust_runs.TESTS)


def text(data: Values) -> str:
    """Return the `data` of evaluate() as tables of at most 80 columns."""
    tests = ''.join(f'{name[:6]:>7}' for name in trust_runs.TESTS)
    lines = ['No fault: share of 0.5 s windows flagged (%), debounced alarms', '',
             f'{"drive":<20}{tests}{"any [95 %]":>18}{"alarms":>7}']
    for row in data['healthy']:
        lines.append(f'{row["drive"]:<20}{_percent(row)}{100 * row["any"]:6.1f} '
                     f'{interval_text(row["interval"], 1, 100):<11}{row["alarms"]:7d}')
    for row in data['healthy']:
        if row['alarms']:
            lines.append(f'  {row["drive"]}: ' + ', '.join(
                f'{k} {v}' for k, v in row['alarms_of'].items()))
    lines.append(f'({data["healthy"][0]["windows"]} windows, {data["healthy"][0]["hours"]:.3g} h '
                 'each)')
    for case, rows in data['faults'].items():
        lines += ['', f'Drive {case}: share of 0.5 s windows flagged (%), s to the first alarm',
                  '', f'{"fault":<16}{tests}{"any":>6}{"delay [95 %]":>16}  found']
        for row in rows:
            delay = '-' if row['delay'] is None else \
                f'{row["delay"]:.1f} {interval_text(row["delay_interval"], 1)}'
            figures = f'{row["found"]}/{row["runs"]}' if row['runs'] else ''
            lines.append(f'{row["fault"]:<16}{_percent(row)}{100 * row["any"]:6.1f}{delay:>16}'
                         f'  {figures}')
    lines += ['', 'Gap, windows of 10 s, smoothed', '',
              f'{"drive":<8}{"true":>8}{"mean":>9}{"deviation":>11}{"stated":>9}'
              f'{"shift by 10 % Cv":>18}{"windows":>9}{"r1":>7}']
    for case, row in data['gap'].items():
        if 'mean' in row:
            lines.append(f'{case:<8}{row["truth"]:8.4f}{row["mean"]:9.4f}{row["std"]:11.4f}'
                         f'{row["stated"]:9.4f}{100 * row["shift"]:16.2f} %{row["windows"]:9d}'
                         f'{row["neighbours"]:7.2f}')
    for case, row in data['gap'].items():
        if 'minute' in row:
            windows, learned = (100 * row[k] / row['truth'] for k in ('minute', 'learned_minute'))
            lines.append(f'{case}: means of a minute scatter by {windows:.2f} %, those of the '
                         f'learned gap by {learned:.2f} %')
    for case, row in data['drift'].items():
        if not row:
            continue
        how = 'all simulated' if row['simulated'] else \
            'NOT simulated: windows drawn, minute by minute, from the run above'
        lines += ['', f'Drive {case}: drift alarms in {row["hours"]:g} h', f'  ({how}):',
                  f'  {row["alarms"]["yearly"]} at one false alarm per year (delivered), '
                  f'{row["alarms"]["daily"]} at one per day',
                  f'{"  gap grows by":<20}{"s to the alarm [95 %]":>26}{"worst":>8}   found '
                  '(simulated)']
        for change, figures in row['delays'].items():
            mean = '-' if figures['mean'] is None else \
                f'{figures["mean"]:.0f} {interval_text(figures["interval"], 0)}'
            longest = '-' if figures['worst'] is None else f'{figures["worst"]:.0f}'
            lines.append(f'  {change:<18}{mean:>26}{longest:>8}   '
                         f'{figures["found"]}/{figures["runs"]}')
    if 'real' in data:
        lines += ['', *trust_real.table(data['real'])]
    lines += ['', *trust_tolerances.table(data['tolerances'])]
    cost = data['cost']
    lines += ['', f'Cost per sample, in EKF steps ({cost["step_us"]:.2f} us): trust '
              f'{cost["trust"]:.2f}; Monitor with EKF {cost["monitor"]:.2f},',
              f'with AEKF, smoother and drift {cost["all"]:.2f}', '']
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    if args.seeds is not None:
        require_whole('--seeds', args.seeds)
    if args.quick and args.full:
        raise InputError('--full and --quick exclude each other')
    expect_folder_of(args.json)
    if args.data is not None:
        trust_real.check(args.data)
    if args.tolerances is not None:
        require_whole('--tolerances', args.tolerances)
        progress = progress_line()
        data = within_tolerances(args.filters, args.tolerances, args.tune, progress)
        progress('')
        lines = [*trust_tolerances.table(data['tolerances']), '', *bar_lines(data['bars'])]
        return finish(data, '\n'.join(lines), args.json)
    size = SIZES['quick' if args.quick else 'default']
    if args.seeds is not None:
        size = {**size, 'faults': args.seeds}
    progress = progress_line()
    data = evaluate(size, args.full, args.data, progress)
    progress('')
    return finish(data, text(data), args.json)
