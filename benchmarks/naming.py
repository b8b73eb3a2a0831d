# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Name what changed, as the estimator does after an alert, by 8 s before and 8 s after.

Random geared axes at work (`benchmarks wear`), with both encoders. By turns the model file is
exact; its values are off (inertias 5 to 10 %, friction and stiffness 20 %, gap 30 %); the axis has
Stribeck friction and friction on the arm that the file lacks. Then gap, stiffness, friction or
torque gain is another one, or nothing. A case is right if the effect is named, and nothing beside
it, with a size within 3 deviations or a tenth of the change; and nothing where nothing changed.

usage examples:
  python -m benchmarks naming
  python -m benchmarks naming --cases 12 --seed 7 --json naming.json
"""
import argparse
from collections.abc import Mapping
from dataclasses import replace
import time
from typing import Any

import numpy as np

from benchmarks.harness import add_drawn_options, bar_lines, BarTable, finish, require_drawn
from benchmarks.wear import axis, DT, file_of, logged, model_of, SimulatedAxis
from gearbox_monitor.diagnosis.joint.diagnose import ChangeVerdict, diagnose_change
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.change_watch import COMPARED
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import UniformRecording

CHANGES = ('none', 'gap', 'stiffness', 'friction', 'gain')
FILES = ('exact', 'values off', 'effects missing')
HIDDEN = ('stribeck', 'arm_coulomb')
# What a change may be called: effect -> its parameter.
NAMES = {'none': {}, 'gap': {'backlash_gap': 'b'}, 'stiffness': {'stiffness': 'K'},
         'friction': {'motor_viscous': 'Cv', 'motor_coulomb': 'Cc'}, 'gain': {'torque_gain': 'g'}}
SIZES = {'gap': (0.1, 0.5), 'stiffness': (0.1, 0.3), 'friction': (0.2, 0.8), 'gain': (0.05, 0.15)}
CPU = 40.0  # s


def drawn(change: str, random: np.random.Generator) -> float:
    """Return the relative size of a `change`; friction grows, the others go either way."""
    if change == 'none':
        return 0.0
    size = float(random.uniform(*SIZES[change]))
    return size if change == 'friction' or random.uniform() < 0.5 else -size


def changed(drive: SimulatedAxis, change: str, size: float
            ) -> tuple[dict[str, float], list[dict[str, Any]]]:
    """Return (nominal values, effects) of an axis after a `change` of a relative `size`."""
    keys = {'gap': ('b',), 'stiffness': ('K',), 'friction': ('Cv', 'Cc')}.get(change, ())
    return ({key: drive.nominal[key] * (1.0 + size) for key in keys},
            [{'id': 'torque_gain', 'g': size}] if change == 'gain' else [])


def right(verdict: ChangeVerdict, change: str, size: float) -> bool:
    """Return whether a verdict names a `change` of a relative `size`, and nothing else."""
    names = NAMES[change]
    if bool(verdict.findings) != bool(names) or verdict.remainder is not None:
        return False
    for finding in verdict.findings:
        if finding.effect not in names:
            return False
        value = next(v for v in finding.values if v.name == names[finding.effect])
        if value.std is None:
            return False
        stated, std = (value.now, value.std) if change == 'gain' else (
            value.now / value.before - 1.0, value.std / value.before)
        if abs(stated - size) > max(3.0 * std, 0.1 * abs(size)):
            return False
    return True


def case(number: int, seed: int) -> dict[str, Any]:
    """Return the figures of the case `number` of a `seed`."""
    random = np.random.default_rng([seed, number])
    change, file = CHANGES[number % len(CHANGES)], FILES[number % len(FILES)]
    drive = axis(random)
    model = model_of(drive, random) if file == 'values off' else file_of(drive.nominal)
    drive = replace(drive, effects=[e for e in drive.effects if file == 'effects missing'
                                    and e['id'] in HIDDEN])
    size = drawn(change, random)
    recordings = [recorded(drive, model, name, random, *state) for name, state in (
        ('healthy', ({}, [])), ('later', changed(drive, change, size)))]
    begin = time.process_time()
    row: dict[str, Any] = {'change': change, 'size': size, 'file': file}
    try:
        verdict = diagnose_change(recordings[0], recordings[1], model)
        row |= {'right': right(verdict, change, size), 'verdict': verdict.to_dict()}
    except InputError as error:
        row |= {'right': False, 'verdict': None, 'problem': str(error)}
    return row | {'cpu_s': time.process_time() - begin}


def recorded(drive: SimulatedAxis, model: DriveModel, name: str, random: np.random.Generator,
             values: Mapping[str, float], effects: list[dict[str, Any]]) -> UniformRecording:
    """
    Return a recording of an axis.

    Args:
        drive: the axis.
        model: its model file.
        name: of the recording.
        random: source of random numbers.
        values: nominal ones that differ.
        effects: beside those of the axis.

    """
    u, y = logged(drive, COMPARED, random, values, effects)
    y[:, 1] += drive.noise * random.standard_normal(len(u))
    return admitted(DT * np.arange(len(u)), u, y, None, name, model, 'model')[0]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    add_drawn_options(parser, 'cases', 40, 'changes, a fifth of them none')


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_drawn(args, 'cases')
    rows, bars = [], BarTable()
    case(1, args.seed + 1)  # compiles kernels
    for number in range(args.cases):
        row = case(number, args.seed)
        rows.append(row)
        verdict = row['verdict'] or {'findings': [], 'verdict': row.get('problem')}
        named = '+'.join(f['effect'] for f in verdict['findings']) or verdict['verdict']
        print(f'{row["change"]:9s} {row["size"]:+.2f} {row["file"]:15s} '
              f'{"right" if row["right"] else "WRONG":5s} {row["cpu_s"]:5.1f} s  {named}',
              flush=True)
    bars.share('changes named right', [r['right'] for r in rows if r['change'] != 'none'],
               low=0.9)
    bars.share('nothing named where nothing changed',
               [r['right'] for r in rows if r['change'] == 'none'], low=1.0)
    bars.judge('CPU time of a case, median, s', float(np.median([r['cpu_s'] for r in rows])),
               high=CPU)
    return finish({'cases': rows, 'bars': bars.rows}, '\n'.join(['', *bar_lines(bars.rows)]),
                  args.json)
