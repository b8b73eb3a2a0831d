# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash and its growth from the motor's torque and encoder alone (arm_joint is empty).

Random geared axes move point to point under a controller, with gravity, Stribeck friction, cogging
and friction on the arm that the model file does not have, and values that differ from it: inertias
by 5 to 10 %, friction and stiffness by 20 %, the gap by 30 % (standard deviations). They are
simulated by the equations of `benchmarks blind`, which share no code with those of the estimator.

Each axis works for ten minutes as new. Then its gap is 20 % or 50 % wider, and the delay until the
alert counts, with the default false_alarm_interval. False alarms are counted over a day that is
drawn from the healthy windows in blocks. Windows scatter by what each one states; within two
deviations of the truth are the widths as texts state them, with the error of the method.

usage examples:
  python -m benchmarks wear
  python -m benchmarks wear --axes 24 --seed 7 --json wear.json
"""
import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np

from benchmarks.blind import plant
from benchmarks.harness import add_drawn_options, bar_lines, BarTable, finish, require_drawn
from benchmarks.trust_drift import drawn, false_alarms, measured
from benchmarks.trust_runs import T0
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.backlash.features import width_of
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, Transmission

DT, DT_NS = 1e-3, 1_000_000
PART = 60.0              # s of work that are simulated at once
HEALTHY = 600.0          # s of work from which the baseline is learnt
GROWTHS = {0.5: 600.0, 0.2: 1800.0}  # growth of the gap -> s within which it must be detected
DAY = 8640               # windows of a day
FASTEST = 2.5            # rad/s
REACH, SHORTEST = 1.2, 0.2  # rad: targets lie within, and so far apart at least
JERK = 20                # samples over which the acceleration is smoothed
MAX_ERROR = 0.2          # of the gap


@dataclass(frozen=True)
class SimulatedAxis:
    """A drive of the blind plant: values and effects, acceleration rad/s^2, noise rad, N m."""

    nominal: dict[str, float]
    effects: list[dict[str, Any]]
    acceleration: float
    noise: float
    torque: float


def _between(random: np.random.Generator, low: float, high: float) -> float:
    """Return a number that is uniform on a logarithmic scale."""
    return float(math.exp(random.uniform(math.log(low), math.log(high))))


def axis(random: np.random.Generator) -> SimulatedAxis:
    """Return a drawn SimulatedAxis."""
    m2 = _between(random, 0.02, 3.0)
    m1 = m2 * _between(random, 0.4, 2.5)
    stiffness = m2 * (2.0 * math.pi * _between(random, 8.0, 25.0)) ** 2
    acceleration = _between(random, 8.0, 30.0)
    load, torque = m2 * acceleration, (m1 + m2) * acceleration
    b = 0.5 * load / stiffness * _between(random, 0.5, 3.0)
    coulomb = torque * random.uniform(0.05, 0.25)
    nominal = {
        'm1': m1, 'm2': m2, 'D': 2.0 * random.uniform(0.03, 0.1) * math.sqrt(stiffness * m2),
        'Cv': torque * random.uniform(0.02, 0.15) / 1.2, 'Cc': coulomb, 'alpha': 100.0, 'Kr': 0.0,
        'K': stiffness, 'b': b}
    effects = [
        {'id': 'stribeck', 'Cs': 0.3 * coulomb * random.uniform(), 'vs': 0.05},
        {'id': 'cogging', 'A': 0.02 * torque * random.uniform(), 'N': int(random.integers(6, 40)),
         'phi': random.uniform(0.0, 6.0)},
        {'id': 'arm_coulomb', 'Cac': load * random.uniform(0.0, 0.15)},
        {'id': 'arm_viscous', 'Cav': load * random.uniform(0.0, 0.1) / 1.2},
        {'id': 'gravity', 'G': load * random.uniform(-0.6, 0.6)}]
    return SimulatedAxis(
        nominal, effects, acceleration, 2.0 * b / _between(random, 30.0, 300.0), torque)


def model_of(drive: SimulatedAxis, random: np.random.Generator) -> DriveModel:
    """Return the model file of a SimulatedAxis `drive`, with values that are off."""
    values = {name: value * math.exp(spread * random.standard_normal()) for (name, value), spread
              in zip(drive.nominal.items(), (0.05, 0.1, 0.3, 0.2, 0.2, 0.0, 0.0, 0.2, 0.3))}
    return file_of(values)


def file_of(values: Mapping[str, float]) -> DriveModel:
    """Return the model file of an axis with these nominal `values`."""
    return DriveModel(
        motor_inertia=values['m1'], arm_inertia=values['m2'], damping=values['D'],
        viscous_friction=values['Cv'], coulomb_friction=values['Cc'], position_gain=0.0,
        transmission=Transmission('dead_zone', values['K'], values['b']))


def _reference(drive: SimulatedAxis, seconds: float, random: np.random.Generator
               ) -> tuple[Array, Array, Array]:
    """Return position [N], speed and acceleration of moves with trapezoidal speed and rests."""
    n, at, q = round(seconds / DT), 0, 0.0
    position, speed = np.zeros(n), np.zeros(n)
    while at < n:
        way = random.uniform(-REACH, REACH) - q
        if abs(way) < SHORTEST:
            continue
        a = drive.acceleration * random.uniform(0.6, 1.0)
        v = min(FASTEST * random.uniform(0.5, 1.0), math.sqrt(0.7 * a * abs(way)))
        length = abs(way) / v + v / a
        t = np.arange(round(length / DT)) * DT
        profile = np.minimum(np.minimum(a * t, v), np.maximum(a * (length - t), 0.0))
        profile = math.copysign(1.0, way) * np.convolve(profile, np.ones(JERK) / JERK)
        end = min(n, at + len(profile))
        speed[at:end] = profile[:end - at]
        position[at:end] = q + np.cumsum(profile)[:end - at] * DT
        q += float(profile.sum()) * DT
        rest = end + round(random.uniform(0.05, 0.6) / DT)
        position[end:rest] = q
        at = rest
    return position, speed, np.gradient(speed, DT)


def work(drive: SimulatedAxis, seconds: float, random: np.random.Generator, growth: float = 0.0,
         begin_ns: int = T0) -> Samples:
    """
    Return what is logged of an axis at work: torque and encoder of the motor.

    Args:
        drive: the axis.
        seconds: length.
        random: source of random numbers.
        growth: of the gap, relative.
        begin_ns: first stamp.

    """
    u, y = logged(drive, seconds, random, {'b': drive.nominal['b'] * (1.0 + growth)})
    n = len(u)
    return Samples(begin_ns + DT_NS * np.arange(n), np.column_stack([u, np.full(n, np.nan)]),
                   np.column_stack([y[:, 0], np.full(n, np.nan)]))


def logged(drive: SimulatedAxis, seconds: float, random: np.random.Generator,
           values: Mapping[str, float], effects: Sequence[dict[str, Any]] = ()
           ) -> tuple[Array, Array]:
    """
    Return torque [N] (N m) and readings of both encoders [N, 2] (rad) of an axis at work.

    Args:
        drive: the axis.
        seconds: length.
        random: source of random numbers.
        values: of the nominal ones, those that differ.
        effects: beside those of the axis.

    """
    nominal = {**drive.nominal, **values}
    position, speed, acceleration = _reference(drive, seconds, random)
    inertia, bandwidth = nominal['m1'] + nominal['m2'], 2.0 * math.pi * 3.0
    feed_forward = (inertia * acceleration + nominal['Cv'] * speed
                    + nominal['Cc'] * np.tanh(speed / 0.05))
    gains = (inertia * bandwidth ** 2, 1.4 * inertia * bandwidth, 4.0 * drive.torque, 0.0)
    _, y, u = plant.simulate_motion(nominal, [*drive.effects, *effects], (
        feed_forward, gains, np.column_stack([position, speed])), DT)
    readings: Array = np.array(y)
    readings[:, 0] += drive.noise * random.standard_normal(len(u))
    return u, readings


def watched(drive: SimulatedAxis, model: DriveModel) -> Monitor:
    """Return the Monitor of an axis `drive` with the model file `model`."""
    return Monitor(model, {'arm_joint': '', 'r_std_motor': drive.noise, 'smoother_lag': 0.0,
                           'q_std_tau_k': 30.0 * drive.torque})


def delay(monitor: Monitor, drive: SimulatedAxis, growth: float, random: np.random.Generator
          ) -> float | None:
    """
    Return the time (s) until a wider gap raises the alert, None if it is not detected in time.

    Args:
        monitor: has learnt the healthy axis; a copy of it goes on.
        drive: the axis.
        growth: of its gap, relative.
        random: source of random numbers.

    """
    monitor = Monitor.restore(monitor.snapshot())
    begin = monitor.stamp_ns + DT_NS
    for part in range(round(GROWTHS[growth] / PART)):
        monitor.run(work(drive, PART, random, growth, begin + round(part * PART * 1e9)))
        if 'gap' in monitor.health.alerts:
            return (monitor.health.alerts['gap'].found_ns - begin) * 1e-9
    return None


def evaluate(axes: int, seed: int, bars: BarTable) -> list[dict[str, Any]]:
    """
    Return one row of figures per axis.

    Args:
        axes: how many.
        seed: of the first one.
        bars: collects the bars.

    """
    rows = []
    for number in range(axes):
        random = np.random.default_rng([seed, number])
        drive = axis(random)
        monitor = watched(drive, model_of(drive, random))
        monitor.run(work(drive, HEALTHY, random))
        windows, true = measured(list(monitor.windows)), 2.0 * drive.nominal['b']
        gaps, stds = (np.array([getattr(w, name) for w in windows]) / true
                      for name in ('gap', 'gap_std'))
        told = np.array([width_of(w.gap, w.gap_std).deviation for w in windows]) / true
        early = 'gap' in monitor.health.alerts
        row: dict[str, Any] = {
            'windows': len(windows), 'gap': float(np.median(gaps)) if windows else None,
            'spread': float(gaps.std()), 'stated': float(np.median(stds)) if windows else None,
            'within_2': float((np.abs(gaps - 1.0) <= 2.0 * told).mean()) if windows else None,
            'early': early, 'false_alarms': false_alarms(monitor.health, drawn(
                windows, DAY, random, monitor.stamp_ns)) if len(windows) > 6 else None}
        for growth in GROWTHS:
            row[f'delay_{growth:g}'] = None if early else delay(monitor, drive, growth, random)
        rows.append(row)
        print(_line(row), flush=True)
    _judge(rows, bars)
    return rows


def _judge(rows: Sequence[dict[str, Any]], bars: BarTable) -> None:
    off = [abs(row['gap'] - 1.0) for row in rows if row['gap'] is not None]
    bars.judge('axes whose gap is within 20 %', sum(v <= MAX_ERROR for v in off) / len(rows),
               low=0.9, count=f'{sum(v <= MAX_ERROR for v in off)} of {len(rows)}')
    for growth, limit in GROWTHS.items():
        delays = [row[f'delay_{growth:g}'] for row in rows]
        hits = sum(value is not None for value in delays)
        bars.judge(f'+{100 * growth:.0f} % detected within {limit / 60.0:.0f} min',
                   hits / len(rows), low=0.95, count=f'{hits} of {len(rows)}')
    alarms = sum((row['false_alarms'] or 0) + row['early'] for row in rows)
    bars.judge('false alarms a day', alarms / len(rows), high=1.0,
               count=f'{alarms} in {len(rows)} days')


def _line(row: dict[str, Any]) -> str:
    """Return a `row` of figures as a line of the table."""
    words = [f'{row["windows"]:7d}']
    for name in ('gap', 'spread', 'stated', 'within_2'):
        words.append('      -' if row[name] is None else f'{row[name]:7.3f}')
    for growth in GROWTHS:
        value = row[f'delay_{growth:g}']
        words.append('      -' if value is None else f'{value:5.0f} s')
    return ' '.join([*words, f'{"-" if row["false_alarms"] is None else row["false_alarms"]:>7}'])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    add_drawn_options(parser, 'axes', 12, 'simulated axes')


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_drawn(args, 'axes')
    bars = BarTable()
    print('windows gap/true spread stated within2   +50 %   +20 %  false a day', flush=True)
    rows = evaluate(args.axes, args.seed, bars)
    return finish({'axes': rows, 'bars': bars.rows}, '\n'.join(['', *bar_lines(bars.rows)]),
                  args.json)
