# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Traces of what rooms decide on the way: contests, checks of recordings, windows, wear and filters.

A row names what was decided and ends with a digest of all figures behind it: a number that moves
with each of them, by as little as they do.
"""
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import fields, is_dataclass, replace
from functools import partial
import json
import math
from typing import Any, TypeAlias
import zlib

import numpy as np

from benchmarks.histories import DAY, FAST, HOME, Life, PAYLOAD, WINDOW
from benchmarks.regression import drawn
from gearbox_monitor import plain_data
from gearbox_monitor.diagnosis.contest import contest
from gearbox_monitor.diagnosis.hypothesis import Finding, kind_of, of_rival, of_size, Remainder
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_MOTOR_SIDE, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_TWIST_RATE_NOISE_STD, S_U,
    S_X2, S_X3, S_X4)
from gearbox_monitor.health.alarms import Alarm, joined as at_once, Outcome, outcome_of, with_more
from gearbox_monitor.health.backlash.change_tests import FEATURES
from gearbox_monitor.health.backlash.features import (
    Backlash, combine, fit, is_locked, locked_windows, lost_motion_of, NotExcited, reason_of,
    separable_of)
from gearbox_monitor.health.health_record import AT_ODDS, TRUSTED, Window
from gearbox_monitor.health.judgement import (
    figures, folded, from_data, Health, judge, outcomes, serviced, to_data, Zero)
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plain_data import ARRAY, KIND, TABLE
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.presentation import Said
from gearbox_monitor.signals.examine import admitted, examine, GROUPS, joined
from gearbox_monitor.signals.jumps import repeats, strangers, wild_rows, without_jumps
from gearbox_monitor.signals.recording import (
    AS_RECORDED, conventions_of, drive_samples, JointSignals, Recording)
from gearbox_monitor.signals.uniform import at_one_rate, prepare, usable_rows

Row: TypeAlias = list[Any]
Rows: TypeAlias = dict[str, Row]
MODEL = DriveModel()
SERVO = MODEL.with_(controller={'kind': 'pd', 'kp': 20.0})


def numbers(value: Any) -> Iterator[float]:
    """Yield all numbers of plain data, arrays, tuples and dataclasses; words become numbers."""
    if isinstance(value, np.ndarray):
        yield from value.ravel().astype(float).tolist()
    elif isinstance(value, str):
        yield zlib.crc32(value.encode()) * 2.0 ** -32
    elif isinstance(value, (bool, int, float, np.number, np.bool_)):
        yield float(value)
    elif isinstance(value, Mapping) and value.get(KIND) == ARRAY:
        yield from numbers(plain_data.from_data(value, {}))
    elif isinstance(value, Mapping):
        rows = value['rows'] if value.get(KIND) == TABLE else value.items()
        yield from numbers(sorted(rows, key=str))
    elif isinstance(value, (Sequence, Set)):
        for part in sorted(value, key=str) if isinstance(value, Set) else value:
            yield from numbers(part)
    elif is_dataclass(value):
        for part in fields(value):
            yield from numbers(getattr(value, part.name))
    else:
        yield from numbers(type(value).__name__)


def digest(*values: Any) -> float:
    """Return a number that moves with each number of `values`, of whatever size."""
    x = np.clip(np.nan_to_num(np.array([*numbers(values)]), nan=0.37), -1e20, 1e20)
    return float(np.cos(np.arange(1.0, len(x) + 1.0)) @ np.arcsinh(1e9 * x))


def tried(make: Callable[[], Any]) -> Any:
    """Return what `make` gives, or that it is refused."""
    try:
        return make()
    except InputError:
        return 'refused'


# --- diagnosis ----------------------------------------------------------------------------------
def contests() -> Rows:
    """Return what contests on linear regressions find, by which fits; questions and findings."""
    rows: Rows = {}
    for seed in range(100):
        evidence = drawn(seed)
        end = contest(evidence)
        rows[f'problem {seed}'] = [
            end.best.name, end.lawless, end.best.deviance, end.remains.worth, digest(
                evidence.log, [[(h.name, h.deviance, [m.effect for m in (
                    *h.laws, h.function, h.train) if m]) for h in part] for part in (
                        end.rivals, end.first)], len(end.grown), end.remains)]
    where = 'arm_coulomb', 'elbow', 'elbow'
    for time in (3.0, 47.0):
        rows[f'questions after {time:g} s'] = [
            *(digest(of_size(where, (1.5, time), (size, 0.25), 14.0)) for size in (
                0.1, 0.4, 0.9, 3.0)),
            *(digest(of_rival(where, (1.5, time), 'x', lag)) for lag in (-1.0, 0.0, 0.7, 5.0))]
    found = Finding('a', 'b', {'C': 1.0, 'K': 2.0}, {'C': 0.1, 'K': None}, 30.0, joint='j')
    left = Remainder('b', joint='j', times=((1.0, 2.0),), recordings=('r',))
    rows['plain data'] = [*found.undetermined, *(kind_of(a, b) for a in (False, True)
                                                 for b in (False, True)), digest(
        found.to_dict(), left.to_dict(), Remainder('b').to_dict())]
    return rows


# --- signals ------------------------------------------------------------------------------------
def recorded(model: DriveModel = MODEL, torque: float = 1.0) -> Samples:
    """Return ten seconds of a drive, the first of them at rest."""
    t = np.arange(2500) * 4e-3
    u = torque * Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1)).torque(t) * (t > 1.0)
    out = simulate(model, u, 4e-3, Noise(measurement=(5e-3, 4e-3)), seed=1)
    return Samples(10 ** 18 + np.rint(t * 1e9).astype(np.int64),
                   np.column_stack([u, np.full(len(t), np.nan)]), out.y)


SOUND = recorded()


def damaged(**changes: Callable[[Array], object]) -> Samples:
    """Return SOUND after `changes` of its columns stamp_ns, u and y, in place or another."""
    columns = {name: getattr(SOUND, name).copy() for name in ('stamp_ns', 'u', 'y')}
    for name, change in changes.items():
        other = change(columns[name])
        columns[name] = columns[name] if other is None else other
    return Samples(**columns)


def without(keep: Flags) -> Samples:
    """Return the rows of SOUND to keep."""
    return Samples(SOUND.stamp_ns[keep], SOUND.u[keep], SOUND.y[keep])


def at(rows: Any, value: float) -> Callable[[Array], None]:
    """Return what writes a value into `rows` of a column."""
    return lambda x: x.__setitem__(rows, value)


def recordings() -> dict[str, Samples]:
    """Return recordings with one fault each, of stamps, encoders, signs, units and torque."""
    rng, n = np.random.default_rng(4), len(SOUND.u)
    rows, walk = np.arange(n), np.cumsum(rng.standard_normal(n))
    jitter, late = 4e6 * rng.standard_normal(n), 4e5 * walk / np.ptp(walk) * 20.0
    half = np.where(rows[:, None] % 2 == [0, 1], 1.0, np.nan)
    servo = recorded(SERVO, 0.1)
    degrees, still = 180.0 / math.pi, rng.standard_normal((n, 2)) * [5e-3, 4e-3]
    slow = 0.05 * Excitation('triangle', (1.0,), (0.05,)).torque(rows * 4e-3)
    return {
        'sound': SOUND, 'weak': recorded(torque=0.02),
        'loaded': recorded(MODEL.with_(effects=[{'id': 'gravity', 'G': 3.0}])),
        'other drive': recorded(MODEL.with_(stiffness=40.0, half_gap=0.05, arm_inertia=0.05)),
        'repeated stamps': damaged(stamp_ns=lambda t: np.where(rows % 9 == 3, np.roll(t, 1), t)),
        'stamps go back': damaged(stamp_ns=lambda t: t - (rows > 1500) * 3 * 10 ** 9),
        'jitter': damaged(stamp_ns=lambda t: t + (0.3 * jitter).astype(np.int64)),
        'wandering clock': damaged(stamp_ns=lambda t: t + late.astype(np.int64)),
        'bursts': damaged(stamp_ns=lambda t: t[rows // 5 * 5] + rows % 5 * 1000),
        'bursts of two': damaged(stamp_ns=lambda t: t[rows // 2 * 2] + rows % 2 * 1000),
        'fast clock': damaged(stamp_ns=lambda t: t[0] + (t - t[0]) // 10),
        'slow clock': damaged(stamp_ns=lambda t: t[0] + 12 * (t - t[0])),
        'lost': without(rng.random(n) > 0.02), 'holes': without((rows % 700 > 20) | (rows < 300)),
        'a hole of a second': without((rows < 1100) | (rows > 1350)),
        'short': without(rows < 750), 'few': without(rows < 40),
        'held': damaged(y=lambda y: y[rows // 4 * 4]),
        'coarse': damaged(y=lambda y: 0.08 * np.rint(y / 0.08)),
        'missing readings': damaged(y=at(rng.random((n, 2)) < 0.1, np.nan), u=at(
            rng.random(n) < 0.03, np.nan)),
        'one encoder': damaged(y=at((slice(None), 1), np.nan)),
        'alternating encoders': damaged(y=lambda y: y * half),
        'turns': damaged(y=lambda y: np.mod(2.0 * y, 2.0 * np.pi)),
        'outliers': damaged(y=at((rows % 350 == 325, 0), 40.0)),
        'slip of a reading': damaged(y=lambda y: y + 5.0 * (rows > 1250)[:, None] * [1, 0]),
        'slip': damaged(y=lambda y: y + 0.7 * (rows > 1250)[:, None] * [1, 0]),
        'stranger': damaged(y=at(rows % 40 == 7, 9.0)),
        'wild torque': damaged(u=at((slice(350, 353), 0), 3e11)),
        'frozen': damaged(y=at((slice(750, 1000), 1), 0.3)),
        'clipped': damaged(y=lambda y: np.minimum(y, [y[:, 0].max() - 1.0, np.inf])),
        'at rest': damaged(y=lambda y: y[0] + still), 'slow': damaged(y=lambda y: np.stack(
            [slow, slow], axis=1) + still),
        'one way': damaged(y=lambda y: np.stack([rows, rows], axis=1) * 8e-3 + still),
        'swapped': damaged(y=lambda y: y[:, ::-1]),
        'sign of arm': damaged(y=lambda y: y * [1.0, -1.0]),
        'sign of torque': damaged(u=np.negative), 'degrees': damaged(y=lambda y: y * degrees),
        'motor side': damaged(y=lambda y: y * [35.0, 1.0]),
        'current': damaged(u=lambda u: 7.0 * u), 'thousandths': damaged(u=lambda u: 1e3 * u),
        'torque sticks': damaged(u=at((slice(750, 1100), 0), 0.0)),
        'torque at its limit': damaged(u=lambda u: np.clip(u, -3.0, 3.0)),
        'torque late': damaged(u=lambda u: np.roll(u, 4, axis=0)),
        'setpoint': damaged(u=lambda u: np.column_stack([SOUND.y[:, 0], u[:, 1]])),
        'servo sound': servo, 'servo turned': replace(servo, u=-servo.u),
        'servo in degrees': replace(servo, u=degrees * servo.u),
        'servo unrelated': replace(servo, u=servo.u + 9.0 * np.sin(0.4 * rows)[:, None]),
        'two drives': damaged(y=lambda y: np.column_stack([y[:, 0], y[::-1, 1]])),
        'coloured noise': damaged(y=lambda y: y + np.outer(0.02 * np.convolve(
            rng.standard_normal(n), np.ones(20) / 4.0, 'same'), [1.0, 0.5]))}


MODELS = {'none': None, 'drive': MODEL, 'rigid': MODEL.with_(kind='rigid'),
          'gear': MODEL.with_(gear_ratio=35.0),
          'servo': SERVO,
          'held motor': MODEL.with_(driven_by='position')}


def checked() -> Rows:
    """Return each line of the examination of each recording, and what the diagnosis admits."""
    parameters, made = EstimatorParameters(drift_window=2.5, max_gap=0.1), recordings()
    rows: Rows = {}
    pairs: list[tuple[str, str]] = [
        (name, 'none') for name in made if not name.startswith('servo')]
    pairs += [(name, 'drive') for name in ('sound', 'loaded', 'one encoder', 'at rest', 'current')]
    pairs += [(name, 'servo') for name in made if name.startswith(('servo', 'setpoint'))]
    pairs += [('weak', 'rigid'), ('motor side', 'gear'), ('weak', 'held motor')]
    for name, kind in pairs:
        s, model = made[name], MODELS[kind]
        found = tried(partial(examine, s, parameters, model, name == 'setpoint'))
        rows[f'{name}, {kind}'] = [digest(getattr(found, 'suits', found)), digest(
            kind == 'drive' or tried(partial(admitted, s.stamp_ns, s.u[:, 0], s.y, None, 'log',
                                             model or MODEL, 'drive')))]
        for group in GROUPS:
            lines = [line for line in getattr(found, 'lines', ()) if line.group == group]
            if lines:
                rows[f'{name}, {kind}: {group}'] = [' '.join(
                    said.code for line in lines for said in line.says), *map(digest, lines)]
        q, jumps = without_jumps(s.y[:, 0], s.stamp_ns)
        rows[f'{name}: repaired'] = [digest(
            q, jumps, strangers(s.y, s.stamp_ns), wild_rows(s.u[:, 0]), usable_rows(s.stamp_ns),
            repeats(np.column_stack([s.u[:, 0], s.y])))]
    parts = [examine(s, parameters, MODEL) for s in (
        without(np.arange(2500) < 1250), made['at rest'], made['lost'])]
    for line in joined(parts, 2.5).lines:
        rows[f'of three parts: {line.name} ({line.group})'] = [digest(line)]
    s = SOUND
    even = [prepare(s.stamp_ns, s.u[:, 0], s.y, s.u[:, 0])[0],
            prepare(s.stamp_ns // 1000 * 1020, s.u[:, 0], s.y, s.u[:, 0])[0]]
    rows['at one rate'] = [digest(r) for r in at_one_rate(even)]
    signals = {side: JointSignals(s.stamp_ns, s.y[:, k], effort=s.u[:, 0], side=side)
               for k, side in enumerate(('motor', 'arm'))}
    read = conventions_of(['a=deg,reversed,zero:0.3', 'all=effort:-2', 'b=mm'], ['a', 'b'])
    rows['joints'] = [
        digest(drive_samples(Recording('log', signals), MODELS['gear'] or MODEL)),
        *(c.rules for c in (AS_RECORDED, *read.values())),
        digest([(c.position(s.u[:, 0]), c.torque(s.u[:, 0])) for c in read.values()])]
    return rows


# --- health -------------------------------------------------------------------------------------
def lives() -> Rows:
    """Return how Healths of drawn windows go on through wear, motions, warmth, slips, service."""
    rows: Rows = {}

    def note(name: str, life: Life) -> None:
        health, said = life.health, outcomes(life.health)
        rows[name] = [*sorted(health.alerts), *(' '.join(o.codes) for o in said.values()), digest(
            health.wear), digest(health.scores), digest(to_data(health)), digest(
                figures(health), [(o.level, o.says, o.values) for o in said.values()],
                health.coefficients)]

    def lived(name: str, life: Life, *stages: Callable[[Life], object]) -> None:
        life.stamp = 10 ** 10  # beside which a window is long
        for k, stage in enumerate(stages):
            stage(life)
            note(f'{name}, stage {k}', life)
            life.restart()
        named = to_data(life.health) | {'features': ['another', *FEATURES[2:], 'gap']}
        rows[f'{name}, other features'] = [
            digest(to_data(from_data(life.health.settings, named))),
            digest(to_data(serviced(life.health, 0, 'noted late'))),
            digest([folded(health, (), 'bag').earlier for health in (
                life.health, Health(life.health.settings))])]

    def grow(windows: int = 8, kelvin: float | None = None, motion: Any = HOME, **wear: float
             ) -> Callable[[Life], object]:
        def stage(life: Life) -> None:
            life.motion = motion
            life.go(windows, wear, kelvin)
        return stage

    def take(trust: int = TRUSTED, count: int = 3, comparable: bool = True, **changes: Any
             ) -> Callable[[Life], object]:
        def stage(life: Life) -> None:
            for _ in range(count):
                window: Backlash | NotExcited = replace(life.window(), **{
                    k: v for k, v in changes.items() if k != 'reason'})
                if 'reason' in changes:
                    window = NotExcited(life.stamp, changes['reason'], 0.02, 0.001)
                life.health = judge(life.health, Window(
                    window, trust, life.kelvin, comparable, counts_on=True))
        return stage

    lived('gap', Life(1), grow(24), grow(gap=0.02), grow(4, gap=0.3), grow(12), grow(6, gap=0.0))
    lived('ramp', Life(2), grow(20), grow(30, gap=0.2, friction=0.5), Life.save,
          grow(12, gap=0.35), grow(8, stiffness=-0.3))
    lived('motions', Life(3), grow(20), grow(10, motion=PAYLOAD, gap=0.05),
          grow(10, motion=FAST, share=0.2), grow(8, hysteresis=0.2), grow(8, gain=0.1))
    lived('warmth', Life(4, {'temperature_topic': '/t'}), grow(12, 30.0), grow(12, 20.0),
          grow(12, 45.0, gap=0.1), grow(6, 20.0, motion=PAYLOAD))
    lived('limit', Life(5, {'gap_limit': 1.5}), grow(14), grow(6, gap=0.4), lambda life: setattr(
        life, 'health', serviced(life.health, life.stamp, 'new gear')), grow(8, gap=0.0))
    lived('slips', Life(6), grow(12), take(zero=0.9), take(), take(zero=-1.4, gap_std=0.4),
          take(count=30, reason='one_flank'), take(count=2, separable=False, lost_motion=1.4,
                                                   lost_motion_std=0.01))
    lived('doubts', Life(7), grow(16), take(AT_ODDS, 5, gap=1.5), take(AT_ODDS, 5, False),
          take(-3, 8, gap=1.4), take(-2, 4, gap=1.4), take(gap=math.nan), grow(5, gap=0.3))
    lived('smaller', Life(10), grow(16), grow(6, gap=0.1), grow(12, gap=-0.2),
          lambda life: setattr(life, 'stamp', life.stamp + 2 * DAY * WINDOW), grow(4))
    lived('steps', Life(11), grow(12), *(grow(6, gap=0.3 * k) for k in range(1, 9)))
    lived('coarse', Life(8), lambda life: setattr(life, 'spread', (0.3, 0.1)), grow(11), grow(6))
    lived('fine', Life(9), lambda life: setattr(life, 'spread', (4e-4, 2e-4)), grow(8),
          take(AT_ODDS, gap=0.21, gap_std=0.0035), take(AT_ODDS, gap=0.21, gap_std=0.0015))
    zero = Zero(0, 0.0, 0.01, 0.2, 0.05)
    rows['zeros'] = [digest([[zero._replace(value=off, gap=gap).moved(zero, turn) for off in (
        0.05, 0.11, 0.15, 0.3, 0.6, 0.7, 0.9, 1.8, 6.3)] for turn in np.linspace(0.0, 3.0, 31)
    ]) for gap in (0.2, 0.3)]
    levels = np.random.default_rng(0).choice(3, (4, 60), p=(0.5, 0.3, 0.2))
    levels[:, 0] = 2, 1, 2, 1
    for k, run in enumerate(levels):
        alarm, out = Alarm(k + 1, 5 - k), []
        for i, raw in enumerate(run.repeat(k + 1).tolist()):
            out.append(alarm.judge(outcome_of([Said(f'c{i}', {}, raw)] if raw else [], Said('f'), {
                'v': 1.0}), i * 10 ** 9))
            if i % 23 == 22:
                alarm.doubt()
        rows[f'alarm {k}'] = [''.join(str(int(o.level)) for o in out), digest(out), digest(
            at_once(out[3:6]), with_more(out[5], [Said('w', {}, 1)], {'w': 2.0}), out[4].figures,
            [Outcome.of(o.level, 'x', n=1).followed_by('y') for o in out[:3]])]
    return rows


def smoothed(model: DriveModel, seconds: float = 10.0, load: float = 0.0, size: float = 5.0,
             seed: int = 3) -> Array:
    """Return rows as of a smoother, of a simulated drive with a little noise."""
    t = np.arange(0.0, seconds, 2e-3)
    u = load + size * np.cos(5.7 * t) + 0.4 * size * np.cos(14.5 * t)
    out, noise = simulate(model, u, 2e-3, Noise(), seed), np.random.default_rng(seed)
    x, rows = out.x, np.zeros((len(t), N_SMOOTHED))
    rows[:, S_TWIST] = x[:, 0] - x[:, 1] + 1e-3 * noise.standard_normal(len(t))
    rows[:, S_X2], rows[:, S_X3], rows[:, S_X4], rows[:, S_U] = x[:, 1], x[:, 2], x[:, 3], u
    rows[:, S_TAU_K] = out.tau_k + 0.05 * noise.standard_normal(len(t))
    rows[:, S_MOTOR_SIDE] = rows[:, S_TAU_K]
    rows[:, S_TAU_K_NOISE_STD], rows[:, S_TWIST_RATE_NOISE_STD] = 0.05, 0.02
    return rows


def windows() -> Rows:
    """Return the features of windows of smoothed rows, and of tests with a locked input."""
    play = MODEL.with_(kind='play', hysteresis_width=0.05)
    stiff = MODEL.with_(half_gap=0.02)
    open_loop = MODEL.with_(kind='passive_play', hysteresis_width=0.05)
    made = {'sound': (smoothed(MODEL), MODEL), 'play': (smoothed(play), play),
            'open loop': (smoothed(open_loop), open_loop),
            'wide': (smoothed(MODEL.with_(half_gap=0.4)), MODEL),
            'small gap': (smoothed(stiff), stiff),
            'friction': (smoothed(MODEL.with_(coulomb_friction=1.2, viscous_friction=0.3)), MODEL),
            'gain': (smoothed(MODEL, size=6.0) * np.where(np.arange(N_SMOOTHED) == S_U, 0.85, 1.0),
                     MODEL),
            **{f'flank {way:g}': (smoothed(MODEL.with_(effects=[
                {'id': 'load_torque', 'TL': 4.0 * way}]), load=4.0 * way, size=size), MODEL)
               for way, size in ((1.0, 1.0), (-1.0, 0.5))},
            'weak': (smoothed(MODEL, size=0.4), MODEL), 'short': (smoothed(MODEL, 0.08), MODEL),
            'brief': (smoothed(MODEL, 0.6), MODEL), 'wild': (smoothed(MODEL) * 1e9, MODEL),
            'still': (0.0 * smoothed(MODEL), MODEL)}
    found = {name: fit(part, model, 7) for name, (part, model) in made.items()}
    rows: Rows = {name: [getattr(f, 'reason', ''), *(getattr(f, key, math.nan) for key in (
        'gap', 'gap_std', 'stiffness', 'coulomb')), digest(f)] for name, f in found.items()}
    slow = smoothed(MODEL)
    for share, size in ((0.0, 0.2), (0.05, -0.2), (0.3, 0.2)):  # off the direction, by the way
        slow[:, S_TWIST] = 0.3 + size * np.where(
            np.arange(len(slow)) % 50 < 50 * share, 0.0, np.sign(slow[:, S_X4])
        ) + 1e-3 * slow[:, S_U]
        rows[f'lost motion, {share:g} off'] = [*lost_motion_of(slow)]
    gaps = [f for f in found.values() if isinstance(f, Backlash)]
    t = np.arange(0.0, 9.6, 4e-3)  # the last stroke is 0.6 of the first
    torque = 3.0 * np.sin(1.6 * t)
    twist = np.interp(torque, [-3.0, -0.1, 0.1, 3.0], [-0.4, -0.25, 0.25, 0.4])
    noise = np.random.default_rng(1).standard_normal((2, len(t)))
    for name, effort, many in (('locked', torque, 1.0), ('locked, part', torque, 0.3),
                               ('locked, no torque', torque * np.nan, 1.0)):
        part = slice(0, int(many * len(t)))
        y = np.column_stack([1e-4 * noise[0], -twist + 1e-3 * noise[1]])[part]
        s = Samples(np.rint(t[part] * 1e9).astype(np.int64), np.column_stack(
            [0.0 * effort, -effort])[part], y)
        locked = locked_windows(s)
        rows[name] = [*(is_locked(replace(s, y=readings)) for readings in (
            y, y[:, ::-1], y[:150], y * (1.0, 3e-3), y @ ((1.0, 0.0), (0.05, 1.0)),
            y[:, [0, 0]] * (0.01, 1.0))), digest(locked)]
        gaps += [w for w in locked if isinstance(w, Backlash)]
    rows['combined'] = [digest(combine(gaps, name, 0.01)) for name in ('gap', 'stiffness', 'gain')
                        ] + [digest(separable_of(gaps)), digest(reason_of([
                            f for f in found.values() if isinstance(f, NotExcited)]))]
    return rows


# --- estimation ---------------------------------------------------------------------------------
LAWS = [{'id': 'gravity', 'G': 0.4}, {'id': 'arm_coulomb', 'Cac': 0.05}]
FILTERS: Mapping[str, tuple[dict[str, Any], dict[str, Any]]] = {
    'ekf': ({}, {}), 'ekf, no load': ({'arm_load': 'none'}, {'effects': LAWS}),
    'ekf, statistical': ({'friction_linearisation': 'statistical', 'friction_error_std': 0.1}, {}),
    'ekf, held': ({}, {'friction_law': {'kind': 'ode'}, 'timestep': 1e-3}),
    'ekf, tolerance': ({'arm_load': 'none'}, {
        'damping_tolerance': 0.2, 'inertia_tolerance': 0.1, 'torque_gain_tolerance': 0.05}),
    'ekf, mixed': ({'tau_k_model': 'mixed'}, {'kind': 'play', 'hysteresis_width': 0.02}),
    'ekf, elastic': ({'tau_k_model': 'elastic'}, {}),
    'ukf': ({'filter': 'ukf'}, {'effects': LAWS}),
    'ukf, wide': ({'filter': 'ukf', 'ukf_alpha': 1.3, 'ukf_beta': 0.5, 'ukf_kappa': 0.5}, {}),
    'ukf, narrow': ({'filter': 'ukf', 'ukf_alpha': 1e-2, 'arm_load': 'none'}, {}),
    'srukf': ({'filter': 'srukf'}, {'effects': LAWS}),
    'srukf, wide': ({'filter': 'srukf', 'ukf_alpha': 1.3, 'ukf_beta': 0.5, 'ukf_kappa': 0.5}, {}),
    'srukf, narrow': ({'filter': 'srukf', 'ukf_alpha': 1e-2, 'arm_load': 'none'}, {}),
    'aekf': ({'filter': 'aekf', 'arm_load': 'none', 'adapt': [
        'q_std_tau_k', 'r_std_motor', 'coulomb_friction', 'viscous_friction']}, {}),
    'aekf, fast': ({'filter': 'aekf', 'adapt': ['r_std_arm', 'q_std_tau_k'],
                    'adapt_forgetting': 0.9}, {'effects': LAWS})}
CARRIED = ('z', 'P', 'memory', 'sensitivities', 'weights')


def filtered() -> Rows:
    """Return what each filter makes of a damaged stream with each option, fourth by fourth."""
    s = damaged(y=at((slice(420, 432), 1), np.nan), u=at(450, np.nan))
    rows: Rows = {}
    s.y[460:470, 0], s.y[480], s.y[520:, 0] = np.nan, np.nan, s.y[520:, 0] + 3.0
    for name, (parameters, changes) in FILTERS.items():
        estimator = Estimator(MODEL.with_(**changes), {
            'smoother_lag': 0.02, 'arm_load': 'unknown', **parameters})
        for begin in (260, 350, 440, 530):
            part = slice(begin, begin + 90)
            got = estimator.run(Samples(s.stamp_ns[part], s.u[part], s.y[part]))
            state = estimator.snapshot()
            rows[f'{name}: from row {begin}'] = [digest(x) for x in (
                got.rows, got.smoothed, got.codes, state['counts'], *(
                    [float.fromhex(x) for x in json.loads(state[key])] for key in CARRIED))]
        rows[f'{name}: told'] = [len(estimator.warnings), digest(estimator.warnings)]
    return rows


ROOMS: Mapping[str, Callable[[], Rows]] = {
    'contest': contests, 'signals': checked, 'wear': lives, 'windows': windows,
    'filters': filtered}
