# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The blind benchmark on recordings by MuJoCo: diagnosis and baselines, scored side by side."""
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import json
from pathlib import Path
import shutil
import tempfile
from typing import Any

import numpy as np

from benchmarks.blind import mujoco_baselines, mujoco_drives, plant, real_joints, scorer
from benchmarks.blind.mujoco_drives import INSIDE, OUTSIDE, Values
from benchmarks.harness import bar_lines, BarTable
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.compiled_model import mujoco_module

MODEL = 'robot.xml'  # of each recording
OURS, RIVAL = 'diagnose', 'least squares, BIC'
CLOSE = 0.05
# What a verdict says of an effect -> the value in MuJoCo.
IN_MUJOCO: dict[str, Callable[[float], float]] = {'torque_gain': lambda g: 1.0 + g}


def model_options(folder: Path) -> tuple[str, ...]:
    """Return the model of the recording in `folder`, with its options."""
    text = (folder / MODEL).read_text(encoding='utf-8')
    joints = ('joint',) if 'name="joint"' in text else ('motor', '--model-arm-joint', 'arm')
    return MODEL, '--joint', *joints


def diagnosed_values(nominal: Values, verdict: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return `nominal` values with the effects of a `verdict`, None if MuJoCo lacks one."""
    values = dict(nominal)
    for name in str(verdict.get('effect') or '').split('+'):
        numbers = dict((verdict.get('params') or {}).get(name, {}))
        if name == 'gravity' and 'phi' in numbers:
            values['phi'] = numbers.pop('phi')
        effects = mujoco_drives.names_of(nominal)
        if name not in effects or len(numbers) != 1:
            return None
        key, value = effects[name][0], IN_MUJOCO.get(name, float)(*numbers.values())
        # Without an armature, half of the joint's inertia counts as the motor's.
        rotorless = key == 'm1' and not nominal['m1']
        values[key] = max(value - 0.5 * nominal['m2'], 0.0) if rotorless else value
    return values


def scored(label: Mapping[str, Any], verdict: Mapping[str, Any] | None,
           recording: tuple[Array, Array]) -> dict[str, Any]:
    """
    Return what the diagnosis and each baseline make of one recording.

    Args:
        label: what was drawn, a mujoco_drives.Label.
        verdict: of the diagnosis; None: missing.
        recording: input [N] and readings [N, E].
    """
    ids, nominal, found = label['ids'], label['nominal'], verdict or {}
    outside = bool(ids) and ids[0] in OUTSIDE
    kind = 'outside' if outside else {0: 'none', 1: 'single', 2: 'pair'}[len(ids)]
    judged = scorer.judge({'ids': [] if outside else ids}, verdict)
    if outside:
        place = found.get('location')
        judged['located'] = place in ('arm_side', ['arm_side'])
        judged['top1'] = found.get('verdict') in ('unknown', 'incomplete')
    row = {'ids': ids, 'class': kind, 'evidence': label['evidence'], **{
        k: judged[k] for k in ('named', 'located', 'top1', 'top2')}, 'true': None, OURS: None}
    if kind in ('single', 'pair'):
        row['true'] = mujoco_baselines.closed_of(nominal, label['truth'], *recording)
        values = diagnosed_values(nominal, found) if found.get('verdict') == 'effect' else None
        row[OURS] = values and mujoco_baselines.closed_of(nominal, values, *recording)
    for name, method in mujoco_baselines.BASELINES.items():
        if 'robot' not in nominal or name == RIVAL:  # the others are for two masses
            row[name] = method(nominal, *recording)
    return row


def _outside_right(method: str) -> Callable[[Mapping[str, Any]], bool]:
    """Return whether `method` is right about a recording outside of the library."""
    return lambda row: method == OURS and bool(row['top1'])


def table(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a line for each method from `rows`: what it names, and what it closes."""
    out = []
    for method in (OURS, *mujoco_baselines.BASELINES):
        own = [row for row in rows if method in row]

        def named(row: Mapping[str, Any], method: str = method) -> str | None:
            return row['named'] if method == OURS else row[method]['named']

        def share(kind: str, right: Callable[[Any], bool], own: Sequence[Any] = own) -> str:
            hits = [right(row) for row in own if row['class'] == kind]
            return f'{sum(hits)}/{len(hits)}'
        closed = [row[method] if method == OURS else row[method]['closed'] for row in own
                  if row['class'] in ('single', 'pair')]
        names = method == OURS or any(row[method]['named'] for row in own)
        out.append({
            'method': method,
            'single': share('single', lambda r: named(r) == r['ids'][0]) if names else '-',
            'pair': share('pair', lambda r: set(str(named(r)).split('+')) == set(r['ids']))
            if names else '-',
            'none': share('none', lambda r: named(r) == 'none') if names else '-',
            'outside': share('outside', _outside_right(method))
            if names else '-',
            'closed': float(np.median([max(-1.0, c or 0.0) for c in closed])) if closed else None})
    return out


@contextmanager
def unwarned() -> Iterator[None]:
    """Keep MuJoCo from reporting free runs that diverge, on the terminal and in a file."""
    mujoco = mujoco_module()
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def score(labels: Mapping[str, Any], verdicts: Mapping[str, Mapping[str, Any] | None],
          read: Callable[[str], tuple[Array, Array]],
          progress: Callable[[int, int], object]) -> dict[str, Any]:
    """
    Score all verdicts and run the baselines.

    Args:
        labels: by name of the recording.
        verdicts: by name; None: missing.
        read: returns torque and readings of a recording by its name.
        progress: called with the numbers scored and in all.
    """
    rows: list[dict[str, Any]] = []
    with unwarned():
        for name, label in labels.items():
            rows.append({'name': name, **scored(label, verdicts.get(name), read(name))})
            progress(len(rows), len(labels))
    bars = BarTable()
    of = {kind: [r for r in rows if r['class'] == kind]
          for kind in ('single', 'none', 'pair', 'outside')}
    bars.share('location', [r['located'] for r in of['single']], 0.95)
    bars.share('top-1', [r['top1'] for r in of['single']], 0.88)
    bars.share('none', [r['top1'] for r in of['none']], 29 / 30)
    bars.share('pairs, both named', [r['top1'] for r in of['pair']])
    bars.share('without Coulomb friction: right', [
        r['top1'] for r in rows if not labels[r['name']]['nominal']['Cc']])
    bars.share('joints of real robots: right', [
        r['top1'] for r in rows if 'robot' in labels[r['name']]['nominal']])
    bars.share('outside unknown or in parts', [r['top1'] for r in of['outside']], 0.85)
    bars.share('closed in MuJoCo within 0.05 of the truth',
               [r[OURS] is not None and abs(r[OURS] - r['true']) <= CLOSE
                for r in (*of['single'], *of['pair']) if r['true'] is not None], 0.90)
    return {'rows': rows, 'bars': bars.rows, 'methods': table(rows)}


def read_recording(folder: Path) -> tuple[Array, Array]:
    """Return input [N] and readings [N, E] of the recording in `folder`."""
    rows = np.loadtxt(folder / 'recording.csv', delimiter=',', skiprows=1)
    return rows[:, 1], rows[:, 2:]


def evaluate(n: int, seed: int, diagnose_all: Callable[..., Any], keep: str | None,
             progress: Callable[[str, int, int], object]) -> dict[str, Any]:
    """
    Generate, diagnose and score recordings by MuJoCo.

    Args:
        n: number of recordings.
        seed: of all random numbers.
        diagnose_all: function (recordings, orders, progress) -> verdicts, seconds, failures.
        keep: new directory for recordings, verdicts and, at the end, labels.
        progress: called with the stage and the numbers done and in all.
    """
    with tempfile.TemporaryDirectory() as hidden, tempfile.TemporaryDirectory() as shown:
        base, sealed = Path(keep or Path(shown) / 'blind'), Path(hidden) / 'labels.json'
        with unwarned():
            names = mujoco_drives.generate(n, base, seed, sealed,
                                           lambda d, t: progress('recordings', d, t))
        recordings = base / 'recordings'
        verdicts, seconds, failures = diagnose_all(
            recordings, [{'name': name, 'exclude': []} for name in names],
            lambda d, t: progress('diagnoses', d, t))
        if keep:
            shutil.copy(sealed, base / 'labels.json')
        data = score(json.loads(sealed.read_text(encoding='utf-8')), verdicts,
                     lambda name: read_recording(recordings / name),
                     lambda d, t: progress('scores', d, t))
    return {'n': n, 'plant': 'mujoco', 'seed': seed, 'seconds': seconds, 'failures': failures,
            **data}


def text(data: Mapping[str, Any]) -> str:
    """Return all tables of `data` from evaluate(), at most 80 columns."""
    lines = [f'{"method":<20}{"single":>8}{"pair":>8}{"none":>8}{"outside":>9}{"closed":>9}',
             'right names of recordings with each class; closed: median in MuJoCo', '']
    for row in data['methods']:
        closed = '-' if row['closed'] is None else f'{100 * row["closed"]:.0f} %'
        lines.append(f'{row["method"]:<20}{row["single"]:>8}{row["pair"]:>8}{row["none"]:>8}'
                     f'{row["outside"]:>9}{closed:>9}')
    lines += ['', 'What was named', '']
    for row in data['rows']:
        rival = row[RIVAL]['named']
        lines.append(f'{row["name"]} {"+".join(row["ids"]) or "none"} -> {row["named"]}; least '
                     f'squares {rival}')
    lines += [f'{name}: {failure}'[:80] for name, failure in data['failures'].items()]
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


assert {*INSIDE, *real_joints.INSIDE} <= {*plant.EFFECTS}
