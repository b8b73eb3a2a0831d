# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Random histories of a gearbox through the Monitor: it publishes the wear that there is.

Samples come from a plant of its own: two masses, a dead zone with a passive loop, friction,
process and encoder noise. Each history has 2 to 4 events: gap, stiffness, friction, its viscous
share, torque gain or loop up or down, at once or slowly; temperature, another motion and back,
payload, noise, a lost encoder, a restart, a saved baseline, changed parameters. Before each event
and at the end every feature is judged: size within 3 deviations, stage, level.

With --healthy the drive stays as it is, but for temperature, and also rests; causes are named as
in the node, which looks once per second. One alert may come at most, and nothing be named.

usage examples:
  .venv/bin/python test/system/wear.py --seeds 0 8
  .venv/bin/python test/system/wear.py --healthy 24 --seeds 0 1
"""
from concurrent.futures import wait
from dataclasses import dataclass, field
import json
import math
import sys
import time

import numpy as np
import script

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import COMPONENTS, FEATURES, TESTS
from gearbox_monitor.health.judgement import accepted, to_data
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.change_watch import ChangeNamer, ChangeWatch
from gearbox_monitor.ros.recording_export import RecordingBuffer

DT, SUBSTEPS, T0 = 2e-3, 8, 10 ** 18
HEALTHY = 90          # windows before the first event
MOTIONS = ((1.0, 1.0), (1.6, 0.8), (0.75, 1.3))  # amplitude, frequency
REST = 0.0, 1.0
SEEN = 0.9            # of the windows in motion, that must be compared
WIDTH = 0.01          # rad, of the loop
SETTLED = 12          # windows without an event before a judgement
# What the fit itself may be off.
BIAS = {'gap': 0.006, 'stiffness': 0.01, 'friction': 0.02, 'viscous_share': 0.01}
JUDGED = tuple(BIAS)
HARMLESS = ('temperature', 'motion', 'return', 'noise', 'lost', 'restart', 'save', 'parameters')
KINDS = ('gap', 'stiffness', 'friction', 'viscous_share', 'gain', 'loop', 'payload', *HARMLESS)
LOG_FRICTION = -0.008  # of friction, per K
SPEED = 20.4           # rad/s rms of the first motion, at which viscous_share leaves the friction
NEVER_ALL = 0.985      # of the friction, that is viscous


def integrate(state, u, noise, values):
    """
    Return positions [N, 2] under torques u [N], with semi-implicit Euler; `state` [5] goes on.

    noise [N, 2]: increments of the speeds. values: m1, m2, D, Cv, Cc, Kr, K, b, loop, gain.
    """
    m1, m2, damping, viscous, coulomb, spring, k, b, loop, gain = values
    result = np.empty((len(u), 2))
    h = 2e-3 / 8
    for i in range(len(u)):
        for _ in range(8):
            twist, rate = state[0] - state[1], state[2] - state[3]
            load = 0.0
            if twist > b:
                load = k * (twist - b)
            elif twist < -b:
                load = k * (twist + b)
            state[4] = min(max(state[4] + rate * h / 0.01, -1.0), 1.0)
            tau = load + loop * state[4] + damping * rate
            friction = viscous * state[2] + coulomb * 2.0 / math.pi * math.atan(100.0 * state[2])
            state[2] += h / m1 * (gain * u[i] - spring * state[0] - friction - tau)
            state[3] += h / m2 * tau
            state[0] += h * state[2]
            state[1] += h * state[3]
        state[2] += noise[i, 0]
        state[3] += noise[i, 1]
        result[i, 0], result[i, 1] = state[0], state[1]
    return result


@dataclass(frozen=True)
class Event:
    """What happens at the begin of a `window`; size of it; over how many windows it comes."""

    window: int
    kind: str
    size: float = 0.0
    over: int = 0


@dataclass
class Verdict:
    """What was judged: counts, and the cases that were wrong, in words."""

    judged: int = 0
    right: int = 0
    open: int = 0
    silent: int = 0
    false_alarms: int = 0
    healthy: float = 0.0
    scores: list = field(default_factory=list)
    wrong: list = field(default_factory=list)


def drawn(random, windows):
    """Return the events of a history of so many `windows`, in their order."""
    events = []
    for _ in range(random.integers(2, 5)):
        window, kind = int(random.integers(HEALTHY, windows - SETTLED)), str(random.choice(KINDS))
        size, over = 0.0, 0
        if kind in ('gap', 'stiffness', 'friction'):
            size = float(random.choice([1, -1]) * random.uniform(0.03, 0.5))
        elif kind == 'gain':
            size = float(random.uniform(-0.15, 0.15))
        elif kind == 'viscous_share':
            size = float(random.choice([random.uniform(-0.5, -0.05), random.uniform(0.05, 0.1)]))
        elif kind == 'loop':
            size = float(random.uniform(-0.1, 0.1))
        elif kind == 'temperature':
            size = float(random.uniform(-25.0, 25.0))
        elif kind == 'motion':
            size = float(random.integers(1, len(MOTIONS)))
        elif kind == 'payload':
            size = float(random.uniform(0.0, 0.1))
        if kind in (*JUDGED, 'temperature'):
            over = int(random.choice([0, 60]))
        events.append(Event(window, kind, size, over))
    return sorted(events, key=lambda e: e.window)


class History:
    """A drive that lives through events while a Monitor watches."""

    def __init__(self, seed, windows, length):
        self.random = np.random.default_rng(seed)
        self.events, self.windows, self.length = drawn(self.random, windows), windows, length
        self.model = DriveModel()
        self.monitor = Monitor(self.model, {'arm_load': 'none', 'drift_window': length})
        self.state, self.time, self.phase = np.zeros(5), 0, 0.0
        self.zero = -1  # window before the baseline was saved
        self.verdict = Verdict()
        self.hidden = []  # windows whose samples were lost

    def size(self, kind, window):
        """Return the sum of the events of a `kind` at a `window`; factors multiply."""
        total = 0.0
        for e in self.events:
            if e.kind == kind and window >= e.window:
                share = min((window - e.window) / e.over, 1.0) if e.over else 1.0
                if kind == 'temperature':
                    total += e.size * (1.0 - math.exp(-(window - e.window) / 30.0)
                                       if e.over else 1.0)
                else:
                    total = (1.0 + total) * (1.0 + share * e.size) - 1.0
        return total

    def law(self, window):
        """Return viscous (N m s/rad) and Coulomb friction (N m) at a `window`, cold."""
        viscous, coulomb = self.model.viscous_friction * SPEED, self.model.coulomb_friction
        whole = (viscous + coulomb) * (1.0 + self.size('friction', window))
        share = min(viscous / (viscous + coulomb) + self.size('viscous_share', window), NEVER_ALL)
        return share * whole / SPEED, (1.0 - share) * whole

    def wear(self, name, window):
        """Return the wear of the feature `name` at a `window` since the baseline."""
        if name not in ('friction', 'viscous_share'):
            return (1.0 + self.size(name, window)) / (1.0 + self.size(name, self.zero)) - 1.0
        health = self.monitor.health
        speed = health.data.points[health.point].speed
        (viscous, coulomb), (viscous_0, coulomb_0) = self.law(window), self.law(self.zero)
        whole, whole_0 = viscous * speed + coulomb, viscous_0 * speed + coulomb_0
        if name == 'friction':
            return whole / whole_0 - 1.0
        return viscous * speed / whole - viscous_0 * speed / whole_0

    def motion(self, window):
        result = MOTIONS[0]
        for e in self.events:
            if window >= e.window and e.kind in ('motion', 'return', 'rest'):
                result = REST if e.kind == 'rest' else MOTIONS[int(e.size)]
        return result

    def go(self, window):
        """Live through a `window`."""
        n = round(self.length / DT)
        warmth = self.size('temperature', window)
        viscous, coulomb = (math.exp(LOG_FRICTION * warmth) * c for c in self.law(window))
        model, shape = self.model, self.model.transmission
        values = np.array([
            model.motor_inertia, model.arm_inertia * (1.0 + self.size('payload', window)),
            model.damping, viscous, coulomb, model.position_gain,
            shape.stiffness * (1.0 + self.size('stiffness', window)),
            shape.half_gap * (1.0 + self.size('gap', window)),
            4.0 * max(self.size('loop', window), 0.0), 1.0 + self.size('gain', window)])
        amplitude, pace = self.motion(window)
        t = self.phase + pace * DT * np.arange(n)
        self.phase = t[-1] + pace * DT
        u = amplitude * (6.0 * np.cos(2 * np.pi * 0.9 * t) + 2.0 * np.cos(2 * np.pi * 2.3 * t))
        noisy = any(e.kind == 'noise' and e.window <= window < e.window + 6 for e in self.events)
        lost = any(e.kind == 'lost' and e.window <= window < e.window + 3 for e in self.events)
        y = integrate(self.state, u, 0.4 * math.sqrt(DT) * self.random.standard_normal((n, 2)),
                      values)
        y = y + (0.01 if noisy else 0.005) * self.random.standard_normal((n, 2))
        if lost:
            y[:, 1] = np.nan
        if lost or noisy:
            self.hidden.append(window)
        stamps = T0 + (self.time + np.arange(1, n + 1)) * round(DT * 1e9)
        self.time += n
        self.monitor.temperature = 20.0 + warmth
        effort = np.column_stack([u, np.full(n, np.nan)])
        self.take(Samples(stamps, effort, y))

    def take(self, samples):
        """Let the Monitor take the Samples of a window."""
        self.monitor.run(samples)

    def happen(self, window):
        """Let the events of a `window` happen that are none of the drive."""
        for e in self.events:
            if e.window != window:
                continue
            if e.kind == 'restart':
                known = json.loads(json.dumps(to_data(self.monitor.health)))
                self.monitor = Monitor(self.model, self.monitor.parameters, known)
            elif e.kind == 'save':
                self.monitor.know(accepted(self.monitor.health)[0])
                self.zero = window - 1
            elif e.kind == 'parameters':
                self.monitor.set_parameters({'q_std_tau_k': 1.1 ** (e.size or 1.0) * float(
                    self.monitor.parameters.q_std_tau_k)})

    def judge(self, window):
        """Compare what is published with what there is."""
        verdict, health = self.verdict, self.monitor.health
        for name in JUDGED:
            column = FEATURES.index(name)
            true = self.wear(name, window)
            growth, std = health.growth(column)
            component = 'backlash' if name in ('gap', 'stiffness') else 'friction'
            outcome = judgement.outcome(health, component)
            changes = [(t, health.alerts[t.key]) for t in TESTS
                       if t.column == column and t.key in health.alerts]
            verdict.judged += 1
            if not math.isfinite(growth):
                verdict.open += 1
                continue
            near = 3.0 * std + BIAS[name] * (1.0 + abs(true))
            _, warn, error = health.limits(next(t for t in TESTS if t.column == column))
            stage = changes[0][1].stage if changes else 0
            low, high = abs(true) - near, abs(true) + near
            staged = not (low > error * 1.02 and stage < 3 or low > warn * 1.02 and stage < 2
                          or high < 0.9 * error and stage == 3
                          or high < 0.9 * warn and stage >= 2)
            if name == 'viscous_share':  # friction tells one that is smaller than its own change
                staged |= low < abs(self.wear('friction', window)) + warn
            said = 'not separable' in outcome.message or 'not compared' in outcome.message
            verdict.scores.append((growth - true) / std)
            sized = abs(growth - true) <= near
            if sized and (staged or said):
                verdict.right += 1
                verdict.open += bool(said and not changes)
                continue
            verdict.silent += bool(outcome.level == Level.OK and abs(true) > warn)
            verdict.wrong.append(
                f'window {window}: {name} {true:+.3f}, published {growth:+.3f} +- {std:.3f}, '
                f'stage {stage}, {outcome.level.name}: {outcome.message[:90]}')

    def live(self):
        """Return the Verdict of the whole history."""
        begins = sorted({e.window for e in self.events})
        steady = set(range(HEALTHY))
        for window in range(self.windows):
            self.happen(window)
            self.go(window)
            if window in steady and window < begins[0]:
                self.verdict.healthy += self.length
            if window == begins[0] - 1 and self.monitor.health.alerts:
                self.verdict.false_alarms += 1
            due = window + 1 in begins or window + 1 == self.windows
            since = window - max([e.window + e.over for e in self.events
                                  if e.window <= window], default=0)
            if due and since >= SETTLED and window > HEALTHY - 2 \
                    and not set(range(window - 3, window + 1)) & set(self.hidden):
                self.judge(window)
        return self.verdict


def harmless(random, windows):
    """Return the events of a life without wear of so many `windows`."""
    events, window, warmth, tuned = [], HEALTHY, 0.0, -1.0
    while window < windows - SETTLED:
        kind, size, over = str(random.choice([*HARMLESS, 'rest'])), 0.0, 0
        if kind == 'temperature':
            old, warmth = warmth, float(random.uniform(-25.0, 25.0))
            size, over = warmth - old, 60  # no oil warms within a window
        elif kind == 'motion':
            size = float(random.integers(1, len(MOTIONS)))
        elif kind == 'parameters':  # there and back
            size = tuned = -tuned
        events.append(Event(window, kind, size, over))
        window += int(random.integers(SETTLED, 4 * SETTLED))
    return events


class PromptNamer(ChangeNamer):
    """A ChangeNamer whose jobs are done when they come back: simulated time does not run."""

    def submit(self, order):
        job = super().submit(order)
        wait([job])
        return job


class HealthyLife(History):
    """A drive without wear, looked at once per second as the node does; see History."""

    def __init__(self, args, seed, namer):
        windows = round(3600.0 * args.healthy / args.length)
        super().__init__(seed, windows, args.length)
        self.events, self.namer = harmless(self.random, windows), namer
        self.told, self.moved, self.compared, self.alerts, self.names = {}, 0, 0, 0, 0
        self.begin()

    def begin(self):
        """Watch the Monitor, which is new."""
        self.buffer = RecordingBuffer(60.0 * self.monitor.parameters.keep_minutes)
        self.changes = ChangeWatch(self.monitor, self.buffer, self.namer, None)

    def happen(self, window):
        old = self.monitor
        super().happen(window)
        if self.monitor is not old:
            self.begin()
        if any(e.kind == 'save' and e.window == window for e in self.events):
            self.changes.accept()

    def take(self, samples):
        n = round(1.0 / DT)
        for k in range(0, len(samples.stamp_ns), n):
            stamps, u, y = (v[k:k + n] for v in (samples.stamp_ns, samples.u, samples.y))
            self.monitor.run(Samples(stamps, u, y))
            for stamp, values in zip(stamps.tolist(), np.column_stack([y, u]).tolist()):
                self.buffer.add(stamp, True, tuple(values))
            self.changes.window()
            self.look()

    def look(self):
        outcome, verdict = self.changes.look()
        hour = self.time * DT / 3600.0
        if verdict is not None:
            self.names += bool(verdict['findings'])
            print(f'    {hour:.2f} h: {verdict["alert"]}: {outcome.message}', flush=True)
        stages = {key: stage for tests in self.monitor.health.stages().values()
                  for key, stage in tests.items()}
        new = any(stage > self.told.get(key, 0) for key, stage in stages.items())
        self.told = stages
        if new:
            self.alerts += 1
            print(f'    {hour:.2f} h: alert: ' + '; '.join(
                judgement.outcome(self.monitor.health, component).message
                for component in COMPONENTS), flush=True)

    def live(self):
        for window in range(self.windows):
            self.happen(window)
            self.go(window)
            self.moved += self.motion(window) != REST
            self.compared += self.monitor.health.compared
            if (window + 1) * self.length % 3600.0 < self.length:
                print(f'    {window + 1} windows, {self.moved} in motion, {self.compared} '
                      'compared', flush=True)


def run_healthy(args):
    """Live through healthy hours, one gearbox per seed; returns 1 where anything is told."""
    namer, begin, lives = PromptNamer(), time.process_time(), []
    for seed in range(*args.seeds):
        life = HealthyLife(args, seed, namer)
        life.live()
        lives.append((life.alerts, life.names, life.windows, life.moved, life.compared))
        print(f'seed {seed}: {life.alerts} alerts, {life.names} names, '
              f'{len(life.monitor.health.data.points)} operating points, '
              f'{len(life.events)} events', flush=True)
    alerts, names, windows, moved, compared = np.sum(lives, axis=0).tolist()
    print(f'{alerts} alerts and {names} names in {windows} windows, {moved} of them in motion, '
          f'{compared} compared; {time.process_time() - begin:.0f} s of CPU')
    return int(alerts > 1 or names > 0 or compared < SEEN * moved)


def add_arguments(parser):
    parser.add_argument('--seeds', nargs=2, type=int, default=(0, 4), metavar=('FIRST', 'END'),
                        help='seeds of the histories (default: 0 4)')
    parser.add_argument('--windows', type=int, default=180,
                        help='windows of a history (default: 180, half an hour with 10 s)')
    parser.add_argument('--length', type=float, default=10.0, help='s of a window (default: 10)')
    parser.add_argument('--healthy', type=float, default=0.0, metavar='HOURS',
                        help='so many hours of each gearbox without wear instead')
    parser.add_argument('--share', type=float, default=0.95,
                        help='judgements that must be right (default: 0.95)')


def run(args):
    if args.healthy:
        return run_healthy(args)
    total, begin = Verdict(), time.process_time()
    for seed in range(*args.seeds):
        history = History(seed, args.windows, args.length)
        verdict = history.live()
        for name in ('judged', 'right', 'open', 'silent', 'false_alarms', 'healthy', 'scores'):
            setattr(total, name, getattr(total, name) + getattr(verdict, name))
        total.wrong += verdict.wrong
        print(f'seed {seed}: {verdict.right} of {verdict.judged} right: ' + ', '.join(
            f'{e.kind} {e.size:+.2g} at {e.window}' + (f' over {e.over}' * bool(e.over))
            for e in history.events))
        print(''.join(f'    {text}\n' for text in verdict.wrong), end='', flush=True)
    z = np.array(total.scores)
    actual = float(np.sqrt(np.mean(z ** 2))) if len(z) else math.nan
    print(f'{total.right} of {total.judged} right, {total.open} not separable or not compared, '
          f'{total.silent} silent, {total.false_alarms} false alarms before an event in '
          f'{total.healthy / 3600:.1f} h; error over stated deviation (rms) {actual:.2f}; '
          f'{time.process_time() - begin:.0f} s of CPU')
    missed = (total.right < args.share * total.judged or total.silent
              or total.open > 0.05 * total.judged)
    return int(bool(missed))


if __name__ == '__main__':
    sys.exit(script.run_script(sys.modules[__name__]))
