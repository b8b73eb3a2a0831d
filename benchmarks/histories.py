# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Wear over histories of windows: pairs of events at once, single growths, jumps, drifts, health.

The windows of a gearbox are drawn, not fitted: their errors go together as those of a fit do, the
gap, stiffness and friction differ between motions and with temperature. A pair is two events that
fall together, or nearly so; the motion of the beginning returns at the end. Each history is judged
once there: right, if what changed is alerted with its size within 3 deviations, and nothing else
is; open, if it is missing but called not separable or not compared; late or wrong in size, false,
and silent if it is missing under OK. Then +1 % of the gap, 24 times; and healthy days.

usage examples:
  python -m benchmarks histories
  python -m benchmarks histories --pairs 100 --seed 7 --days 3
"""
import argparse
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import json
import math
import time
from typing import Any

import numpy as np

from benchmarks.harness import add_drawn_options, bar_lines, BarTable, finish, require_drawn
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import (
    FRICTION, GAIN, GAP, HYSTERESIS, PRIORS, STIFFNESS, tests_of, VISCOUS_SHARE)
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.health_record import ERRORS_LARGER, HealthSettings, TRUSTED, Window
from gearbox_monitor.health.judgement import accepted, from_data, Health, judge, outcomes, to_data
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

WINDOW = 10 * 10 ** 9
DAY = 8640
INTERVAL = 2000.0  # s
LEARNT = 150
GAP_RAD, STIFF, VISCOUS, COULOMB = 1.2, 5.0, 0.1, 0.27
# Motions: angle (rad), speed (rad/s), load (N m).
HOME, PAYLOAD, FAST = (0.3, 18.0, 3.6), (0.3, 18.0, 8.6), (0.3, 40.0, 3.9)
# Standard deviations of the gap (rad): shared with the stiffness, and its own.
SPREADS = ((0.0097, 0.0035), (0.0067, 0.0030))
JUDGED = (GAP, STIFFNESS, HYSTERESIS, FRICTION, GAIN, VISCOUS_SHARE)
# What is judged: size in deviations; change over its notice that must be found; of a healthy one.
WITHIN, FLOOR, EVIDENT = 3.0, 1e-3, 2.0


@dataclass
class Life:
    """A gearbox whose windows are judged; wear: relative changes by name."""

    seed: int
    parameters: dict[str, Any] = field(default_factory=dict)
    wear: dict[str, float] = field(default_factory=dict)
    zero: dict[str, float] = field(default_factory=dict)
    kelvin: float = 20.0
    motion: tuple[float, float, float] = HOME
    noise: float = 1.0
    false: int = 0

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        self.spread = SPREADS[self.seed % 2]
        self.health = Health(HealthSettings.of(
            EstimatorParameters.from_mapping(self.parameters), DriveModel()))
        self.stamp = 10 ** 18
        draw = self.random.standard_normal
        self.offsets = {motion: {c: PRIORS[c].offset * float(draw()) if motion != HOME else 0.0
                                 for c in (GAP, STIFFNESS, FRICTION)}
                        for motion in (HOME, PAYLOAD, FAST)}
        self.slopes = {c: PRIORS[c].temperature * float(draw()) * (0.5 if c == FRICTION else 1.0)
                       for c in (GAP, STIFFNESS, FRICTION)}

    def window(self) -> Backlash:
        """Return the next window."""
        shared, own, friction, coulomb, loop, gain = self.noise * self.random.standard_normal(6)
        both, alone = self.spread
        angle, speed, load = self.motion
        warm = self.kelvin - 20.0

        def factor(name: str, column: int) -> float:
            return (1.0 + self.wear.get(name, 0.0)) * math.exp(
                self.offsets[self.motion][column] + self.slopes[column] * warm)

        model = VISCOUS * speed + COULOMB
        total = model * factor('friction', FRICTION)
        share = VISCOUS * speed / model + self.wear.get('share', 0.0)
        self.stamp += WINDOW
        return Backlash(
            self.stamp, GAP_RAD * factor('gap', GAP) + both * shared + alone * own,
            1.1 * math.hypot(both, alone), STIFF * factor('stiffness', STIFFNESS) + 0.04 * shared,
            0.044, hysteresis=load * self.wear.get('hysteresis', 0.0) + 0.02 * loop,
            hysteresis_std=0.02, zero=0.0, flank=0.4, coverage=18.0,
            viscous=share * total / speed - VISCOUS + 0.0012 * friction, viscous_std=0.0013,
            coulomb=(1.0 - share) * total - COULOMB + 0.003 * coulomb, coulomb_std=0.003,
            gain=self.wear.get('gain', 0.0) + 0.003 * gain, gain_std=0.003,
            angle=angle, speed=speed, load=load)

    def go(self, windows: int, ramp: Mapping[str, float] | None = None, kelvin: float | None = None
           ) -> int | None:
        """
        Live for so many `windows`; return the window of the first alert among them.

        Args:
            windows: how many.
            ramp: {name: wear at the end}, to which it grows.
            kelvin: temperature at the end.

        """
        begin, warm, first = dict(self.wear), self.kelvin, None
        for k in range(windows):
            part = (k + 1) / windows
            for name, end in (ramp or {}).items():
                self.wear[name] = begin.get(name, 0.0) + part * (end - begin.get(name, 0.0))
            if kelvin is not None:
                self.kelvin = warm + part * (kelvin - warm)
            trust = TRUSTED if self.noise == 1.0 else \
                ERRORS_LARGER - round(2.0 * math.log2(self.noise ** 2))
            self.health = judge(self.health, Window(
                self.window(), trust, self.kelvin, comparable=True, counts_on=True))
            if self.health.alerts and first is None:
                first = k
        return first

    def restart(self) -> None:
        """Go on from the state file."""
        self.health = from_data(
            self.health.settings, json.loads(json.dumps(to_data(self.health))))

    def save(self) -> None:
        """Save the baseline."""
        self.health, _ = accepted(self.health)
        self.zero = dict(self.wear)

    def truth(self) -> dict[int, float]:
        """Return the wear since the baseline was saved, {column: relative}."""
        result = dict.fromkeys(JUDGED, 0.0)
        for name, column in (('gap', GAP), ('stiffness', STIFFNESS), ('friction', FRICTION)):
            result[column] = (1.0 + self.wear.get(name, 0.0)) / (
                1.0 + self.zero.get(name, 0.0)) - 1.0
        for name, column in (('hysteresis', HYSTERESIS), ('share', VISCOUS_SHARE), ('gain', GAIN)):
            result[column] = self.wear.get(name, 0.0) - self.zero.get(name, 0.0)
        return result


def verdict(life: Life) -> tuple[str, str]:
    """Return (right, open, size, false or silent, the features that are not right) of a `life`."""
    health, told = life.health, outcomes(life.health)
    words: list[tuple[str, str]] = []
    for column, true in life.truth().items():
        tests = tests_of(column)
        name, notice = tests[0].key, health.settings.notice(column)
        growth, std = health.growth(column)
        alerts = [health.alerts[t.key] for t in tests if t.key in health.alerts]
        off = abs(growth - true) > WITHIN * std + FLOOR + 0.02 * abs(true)
        detail = f'{name} {100 * true:+.1f} %: {100 * growth:+.1f} % ± {100 * std:.1f} %'
        if alerts and abs(true) < 0.5 * notice:
            words.append(('false', detail))
        elif abs(true) >= EVIDENT * notice and not alerts:
            outcome = told['friction' if column in (FRICTION, GAIN, VISCOUS_SHARE) else 'backlash']
            hidden = outcome.level > Level.OK and any(
                word in outcome.message for word in ('not separable', 'not compared'))
            words.append(('open' if hidden and not off else 'silent', detail))
        elif (alerts or column == GAP) and off:
            words.append(('size', detail))
    for kind in ('silent', 'false', 'size', 'open'):
        if any(word[0] == kind for word in words):
            return kind, '; '.join(text for _, text in words)
    return 'right', ''


def _size(life: Life, low: float = 0.03, high: float = 0.3) -> float:
    return float(math.exp(life.random.uniform(math.log(low), math.log(high))))


def _apart(life: Life) -> int:
    """Return how many windows lie between the events of a pair: none in every second."""
    return int(life.random.choice(np.array([0, int(life.random.integers(1, 40))])))


def gap_and_friction(life: Life) -> None:
    """Widen the gap and lower the friction."""
    life.wear['gap'] = _size(life)
    life.go(_apart(life))
    life.wear['friction'] = -_size(life, 0.12, 0.4)
    life.go(30)


def payload_and_growth(life: Life) -> None:
    """Add a payload, widen the gap, and take the payload away."""
    life.motion = PAYLOAD
    life.go(_apart(life))
    life.wear['gap'] = _size(life)
    life.go(40)
    life.motion = HOME
    life.go(20)


def temperature_and_stiffness(life: Life) -> None:
    """Change the temperature at once, and lose stiffness."""
    life.kelvin += float(life.random.choice([-1, 1])) * life.random.uniform(8.0, 25.0)
    life.go(_apart(life))
    life.wear['stiffness'] = -_size(life, 0.08, 0.4)
    life.go(40)
    life.go(30, kelvin=20.0)
    life.go(12)


def restart_and_growth(life: Life) -> None:
    """Widen the gap before, while and after the node is down."""
    end = _size(life)
    if life.random.random() < 0.5:
        life.go(30, {'gap': 0.5 * end})
    life.restart()
    life.stamp += int(life.random.integers(0, 24)) * 3600 * 10 ** 9
    life.wear['gap'] = 0.5 * end
    life.go(int(life.random.integers(2, 30)), {'gap': end})
    life.restart()
    life.go(20)


def motion_and_growth(life: Life) -> None:
    """Drive a motion that was never driven, widen the gap, and drive the old one."""
    life.motion = FAST
    life.go(_apart(life))
    life.wear['gap'] = _size(life)
    life.go(40)
    life.motion = HOME
    life.go(20)


def sensor_and_growth(life: Life) -> None:
    """Swap the encoder for one with more noise, widen the gap, and swap it back."""
    life.noise = float(life.random.uniform(1.5, 3.0))
    life.go(_apart(life))
    life.wear['gap'] = _size(life, 0.05)
    life.go(40)
    life.noise = 1.0
    life.go(20)


def parameters_and_growth(life: Life) -> None:
    """Change limits and widths of operating points, and widen the gap."""
    parameters = EstimatorParameters.from_mapping({
        'gap_warn': float(life.random.uniform(0.05, 0.2)), 'speed_bin': 1.5,
        'false_alarm_interval': float(life.random.choice([1e7, 1e8]))})
    life.health = replace(life.health, settings=HealthSettings.of(parameters, DriveModel()))
    life.go(_apart(life))
    life.wear['gap'] = _size(life)
    life.go(30)


def repair_and_save(life: Life) -> None:
    """Widen the gap, adjust it, save a baseline, and widen it again."""
    life.wear['gap'] = _size(life, 0.1)
    life.go(40)
    life.wear['gap'] = float(life.random.uniform(-0.1, 0.05))
    life.go(_apart(life) + 3)
    life.save()
    life.go(_apart(life))
    life.wear['gap'] = (1.0 + life.wear['gap']) * (1.0 + _size(life)) - 1.0
    life.go(30)


PAIRS = (gap_and_friction, payload_and_growth, temperature_and_stiffness, restart_and_growth,
         motion_and_growth, sensor_and_growth, parameters_and_growth, repair_and_save)


def single(life: Life) -> tuple[str, str]:
    """Return the verdict of one jump or drift of one feature, up or down."""
    names = ('gap', 'gap', 'stiffness', 'friction', 'gain', 'hysteresis')
    name = names[int(life.random.integers(len(names)))]
    size = {'gap': _size(life, 0.01), 'gain': _size(life, 0.04, 0.15),
            'hysteresis': _size(life, 0.05, 0.15), 'friction': _size(life, 0.12, 0.5)}.get(
                name, _size(life, 0.05, 0.3))
    size *= 1.0 if name == 'gap' else float(life.random.choice([-1.0, 1.0]))
    if life.random.random() < 0.5:
        life.wear[name] = size
    life.go(60, {name: size})
    life.go(20)
    return verdict(life)


def one_percent(seed: int) -> float | None:
    """Return the delay (windows) until +1 % of the gap is alerted, None: not within 60."""
    life = Life(2 * seed)
    life.go(LEARNT)
    life.wear['gap'] = 0.01
    found = life.go(60)
    return None if found is None or 'gap' not in life.health.alerts else found + 1


def healthy(seed: int, windows: int, interval: float | None = None) -> tuple[int, float]:
    """
    Return (alerts, CPU s per window) of a healthy gearbox in motions and temperatures.

    Args:
        seed: of the noise.
        windows: how many.
        interval: false_alarm_interval, s; None: the default. A baseline is saved after each alert.

    """
    life = Life(seed, {} if interval is None else {'false_alarm_interval': interval})
    alerts, before = 0, frozenset[str]()
    clock = time.process_time()
    for k in range(windows):
        if k % 360 == 180:
            life.motion = (HOME, PAYLOAD, FAST)[int(life.random.integers(3))]
        life.kelvin = 20.0 + 6.0 * math.sin(2.0 * math.pi * k / DAY) \
            + 4.0 * math.sin(2.0 * math.pi * k / 1500.0)
        life.go(1)
        now = frozenset(life.health.alerts)
        alerts += len(now - before)
        before = now
        if now and interval is not None:
            life.save()
            before = frozenset()
    return alerts, (time.process_time() - clock) / windows


def evaluate(args: argparse.Namespace, bars: BarTable) -> dict[str, Any]:
    """Return all figures; `bars` collects the bars."""
    result: dict[str, Any] = {'pairs': [], 'singles': []}
    for number in range(args.pairs):
        pair = PAIRS[number % len(PAIRS)]
        life = Life(args.seed * 100_003 + number)
        life.go(LEARNT)
        early = bool(life.health.alerts)
        pair(life)
        kind, text = ('false', 'before any event') if early else verdict(life)
        result['pairs'].append((pair.__name__, kind))
        if kind != 'right':
            print(f'{number:4d} {pair.__name__:26s} {kind:7s} {text}', flush=True)
    for number in range(args.singles):
        life = Life(args.seed * 100_003 + 50_000 + number)
        life.go(LEARNT)
        kind, text = single(life)
        result['singles'].append(kind)
        if kind != 'right':
            print(f'{number:4d} {"single":26s} {kind:7s} {text}', flush=True)
    for name, kinds in (('pairs', [kind for _, kind in result['pairs']]),
                        ('singles', result['singles'])):
        bars.share(f'{name} right', [kind == 'right' for kind in kinds], low=0.95)
        bars.share(f'{name} silently wrong', [kind == 'silent' for kind in kinds], high=0.0)
        print(f'{name}: ' + ', '.join(f'{kinds.count(k)} {k}' for k in (
            'right', 'open', 'size', 'false', 'silent')), flush=True)
    delays = [one_percent(args.seed * 1009 + k) for k in range(24)]
    found = [d for d in delays if d is not None]
    result['delays'] = delays
    bars.share('+1 % found', [d is not None for d in delays], low=1.0)
    bars.judge('windows until +1 % is found, mean', float(np.mean(found)) if found else None,
               high=10.0)
    days = [healthy(args.seed * 77 + k, DAY) for k in range(args.days)]
    if days:
        result['alerts'] = [alerts for alerts, _ in days]
        bars.judge('alerts in healthy days', sum(result['alerts']), high=0,
                   count=f'{args.days} days')
        bars.judge('CPU per window, ms', 1e3 * float(np.mean([cost for _, cost in days])))
    if args.rate_windows:
        # Odds sum up to a martingale: the rate is proportional to the interval, where it is seen.
        alerts = sum(healthy(args.seed * 79 + 553 + k, args.rate_windows // 2, INTERVAL)[0]
                     for k in range(2))
        result['rate'] = alerts * INTERVAL / (args.rate_windows * WINDOW * 1e-9)
        bars.judge('false alarms over those of false_alarm_interval', result['rate'], high=1.0,
                   count=f'{alerts} in {args.rate_windows} windows, one promised in '
                         f'{INTERVAL / (WINDOW * 1e-9):g}')
    return result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    add_drawn_options(parser, 'pairs', 100, 'pairs of events')
    parser.add_argument('--singles', type=int, default=40, help='histories of one change')
    parser.add_argument('--days', type=int, default=1, help='healthy days')
    parser.add_argument('--rate-windows', type=int, default=DAY, help='windows of a healthy '
                        f'gearbox with one false alarm promised in {INTERVAL:g} s')


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_drawn(args, 'pairs')
    bars = BarTable()
    figures = evaluate(args, bars)
    return finish({**figures, 'bars': bars.rows}, '\n'.join(['', *bar_lines(bars.rows)]),
                  args.json)
