#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Read the layouts of the tests under other names, in another order and with columns missing.

A mapping is wrong in silence if it asks nothing and gives a role to a column that is something
else, puts columns of two joints into one, takes a role from different signals in different joints,
reads another unit than the true one, or leaves out a joint whose position is there.

usage examples:
  mutated_layouts.py --seed 3
  mutated_layouts.py --seed 3 --only franka --verbose
"""
from collections import Counter
from dataclasses import replace
from pathlib import Path
import re
import sys
import tempfile
import zlib

import numpy as np
from script import run_script

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.guess import Answers, guessed
from gearbox_monitor.recordings.meaning import EFFORT, unit_of_label, units_of
from gearbox_monitor.recordings.reading import file_in
from gearbox_monitor.recordings.roles import with_setpoints
from gearbox_monitor.recordings.table import load_table

sys.path.append(str(Path(__file__).parents[1] / 'recordings'))
driver_layouts, log_layouts = map(__import__, ('driver_layouts', 'log_layouts'))

ALLOWED = 0.005  # of the readings may be wrong in silence
DROPPED = 0.15   # share of the columns that are missing
QUANTITIES = {'motor_position': 'position', 'motor_velocity': 'velocity', 'motor_effort': 'effort',
              'motor_setpoint': 'setpoint', 'arm_position': 'position', 'arm_velocity': 'velocity'}
COMMAND = r'target|desired|_d\b|_d[\[\d]|_des$|goal|SetPos|command|cmd|planned|action|input_pos|' \
          r'demand|reference|setpoint|controller\.|Target|Soll|ctrl'
# What a column that no layout calls true must have in its name, and must not have.
OTHERWISE = {
    'position': (r'pos|angle|Angle|\bq|theta|Position|qpos', COMMAND + r'|TCP|base|ee_|[Ee]rror'),
    'velocity': (r'vel|speed|dq|qd|dtheta|Velo|Speed', COMMAND + r'|TCP|base|[Ee]rror|ddq|dtau'),
    'effort': (r'tau|[Tt]orque|[Cc]urrent|eff|Iq|q_A|pwm|PWM',
               r'ext|fric|grav|contact|d_A|d_current|Current D|Voltage|TCP|dtau|[Ee]rror|temp'),
    'setpoint': (COMMAND, r'vel|speed|dq|tau|[Tt]orque|[Cc]urrent|[Ee]rror')}
SYNONYMS = [
    {'position': 'angle', 'velocity': 'speed', 'torque': 'moment', 'actual': 'measured',
     'target': 'desired', 'pos': 'angle', 'vel': 'speed', 'current': 'amps', 'desired': 'ref',
     'link': 'load', 'motor': 'rotor', 'arm': 'output'},
    {'position': 'pos', 'velocity': 'vel', 'torque': 'trq', 'actual': 'act', 'measured': 'meas',
     'target': 'cmd', 'desired': 'des', 'tau': 'torque', 'link': 'out', 'motor': 'mot',
     'current': 'curr', 'speed': 'velocity', 'angle': 'position'},
    {'position': 'Winkel', 'velocity': 'Drehzahl', 'torque': 'Drehmoment', 'actual': 'ist',
     'measured': 'ist', 'target': 'soll', 'desired': 'soll', 'link': 'Abtrieb', 'pos': 'Lage',
     'current': 'Strom', 'speed': 'Geschwindigkeit'}]


def _words(table):
    """Return a change of names that replaces words by those of `table`."""
    def word(match):
        new = table.get(match[0].lower(), match[0])
        return new.capitalize() if match[0][0].isupper() else new
    return lambda name: re.sub(r'[A-Z]?[a-z]+', word, name)


def _joints(name):
    parts = 'hip', 'thigh', 'calf', 'ankle', 'toe'
    return re.sub(r'(?<=[A-Za-z])(?=\d)|\d+', lambda m: '_' if not m[0] else (
        parts[int(m[0]) % 5] + str(int(m[0]) // 5)), name)


NAMES = {
    'as they are': lambda name: name,
    'camelCase': lambda name: re.sub(r'_(\w)', lambda m: m[1].upper(), name),
    'snake_case': lambda name: re.sub(r'(?<=[a-z])(?=[A-Z])', '_', name).lower(),
    'upper case': str.upper,
    'dots': lambda name: name.replace('_', '.'),
    'spaces': lambda name: re.sub(r'[_.]', ' ', name),
    'prefix': lambda name: f'robot.{name}',
    'writer': lambda name: f'control/{name}',
    'suffix': lambda name: re.sub(r'(?=\s*\[[^\]]*[A-Za-z%°][^\]]*\]$|$)', '_log', name, count=1),
    'no units': lambda name: re.sub(r'\s*[\[(][^\d\])]+[\])]|_(deg|rad|ms|nm)$', '', name),
    'letters': lambda name: re.sub(r'(?<![A-Za-z\d])\d\b', lambda m: 'abcdefghij'[int(m[0])]
                                   + 'joint', name),
    'parts of a leg': _joints,
    'one word': lambda name: re.sub(r'(?<=[a-z])[_ ](?=[A-Za-z])', '', name).lower(),
    **{f'synonyms {k}': _words(table) for k, table in enumerate(SYNONYMS, 1)}}
EFFORTS = units_of(EFFORT)
ORDERS = ('in order', 'some missing', 'shuffled')


def add_arguments(parser):
    parser.add_argument('--seed', type=int, default=0, help='of order and missing columns')
    parser.add_argument('--only', default='', metavar='TEXT', help='layouts whose name has TEXT')
    parser.add_argument('--verbose', action='store_true', help='print each wrong mapping')


def _two_encoders(folder):
    """Write a drive with an encoder at either end of its gear."""
    r = log_layouts.Robot(1, 500.0, seed=60)
    names = ['time [s]', 'motor_position [rad]', 'link_position [rad]', 'motor_velocity [rad/s]',
             'motor_torque [Nm]', 'desired_position [rad]']
    q, wind = r.q[:, 0], r.tau[:, 0] / 800.0
    columns = [r.t, q, q - wind + 1e-5 * np.sin(1e3 * r.t), r.dq[:, 0], r.tau[:, 0],
               r.setpoint[:, 0]]
    return log_layouts.Layout('two encoders', log_layouts.table(
        folder / 'bench.csv', names, columns), {
            'motor_position': names[1:2], 'arm_position': names[2:3], 'velocity': names[3:4],
            'effort': names[4:5], 'setpoint': names[5:6]}, {'position': 'rad', 'effort': 'N m'})


LAYOUTS = (*log_layouts.LAYOUTS, *driver_layouts.LAYOUTS, _two_encoders)


def mutant(table, change, order, random):
    """Return (Table with other names, {new name: old name}), None where it is none."""
    columns = [c for c in table.columns if order != 'some missing' or random.random() > DROPPED]
    if order == 'shuffled':
        random.shuffle(columns)
    names = {c.name: change(c.name) for c in columns}
    if len(set(names.values())) < max(2, len(names)):
        return None
    new = []
    for c in columns:
        unit, factor = c.unit, c.factor
        if c.unit and c.unit == unit_of_label(c.name)[1]:  # stated by the name alone
            factor, unit = unit_of_label(names[c.name])
        new.append(replace(c, name=names[c.name], unit=unit, factor=factor,
                           clock=names.get(c.clock, '')))
    return replace(table, columns=tuple(new), rows=None), {m: n for n, m in names.items()}


def reading(table):
    """Return the Guess of a `table`, 'asked' or 'refused'; a file without a time has 200 Hz."""
    for rate in (None, 200.0):
        try:
            guess = guessed(table, (), Answers(rate=rate))
        except Undecided as error:
            if 'like a time' in str(error) and rate is None:
                continue
            return 'asked'
        except InputError:
            return 'refused'
        return 'asked' if guess.questions else guess
    return 'asked'


def _option(layout, label):
    """Return (quantity, number of the joint) of the column `label` in `layout`, None: neither."""
    beside = label.startswith('setpoint: ')
    label, found = label.removeprefix('setpoint: '), []
    for quantity, own in layout.roles.items():
        if beside != (quantity == 'setpoint') and (beside or own == layout.roles.get('position')):
            continue
        for names in own if isinstance(own, tuple) else (own,):
            found += [(len(name), quantity, k) for k, name in enumerate(names)
                      if label == name or re.match(re.escape(name) + r'(?![\w.])', label)]
    return max(found)[1:] if found else None


def errors(layout, guess, back, stated):
    """
    Return the kinds of error of a `guess`.

    `back` {name: true name} of its columns; `stated`: true names of those whose unit is known.
    """
    kinds, signals = set(), {}
    joints = guess.data.get('joints') or {'': guess.data['signals']}
    for joint, blocks in joints.items():
        numbers = set()
        for role, block in blocks.items():
            label, quantity = back[block['column']], QUANTITIES.get(role, role)
            true = _option(layout, label)
            fitting = true is not None and true[0] in (quantity, role)
            if not fitting:
                has, has_not = OTHERWISE.get(quantity, ('', 'x^'))
                if true is not None or not re.search(has, label) or re.search(has_not, label):
                    kinds.add(f'{quantity}: role')
            else:
                numbers.add(true[1])
                truth = layout.units.get(quantity)
                if truth and label in stated and quantity != 'setpoint' and block.get('unit', {
                        'position': 'rad', 'velocity': 'rad/s', 'effort': 'N m'}[quantity]
                        ) != truth:
                    kinds.add(f'{quantity}: unit')
            signals.setdefault(role, {})[joint] = re.sub(r'\d+', '#', label) if fitting else label
            if fitting and true:
                signals[role][joint] = 'true'
        if len(numbers) > 1:
            kinds.add('two joints in one')
    kinds |= {f'{role}: another signal in each joint' for role, own in signals.items()
              if 'true' in own.values() and set(own.values()) != {'true'}}
    positions = {true[1] for label in back.values() if (true := _option(layout, label))
                 and true[0] == 'position'}
    return kinds | ({'a joint is lost'} if len(positions) > len(joints) else set())


def outcomes(seed, only=''):
    """Yield (layout, names, order, outcome, Guess) of all mutants; outcome '' is right."""
    folder = Path(tempfile.mkdtemp())
    for make in LAYOUTS:
        if only not in make.__name__:
            continue
        own = folder / make.__name__
        own.mkdir()
        layout = make(own)
        table = with_setpoints(load_table(file_in(Path(layout.path)), whole=True))
        for name, change in NAMES.items():
            random = np.random.default_rng([seed, zlib.crc32((make.__name__ + name).encode())])
            for order in ORDERS:
                mutated = mutant(table, change, order, random)
                if mutated is None:
                    continue
                guess = reading(mutated[0])
                # A unit that only the words of a driver imply is not known under other words; nor
                # is that of an effort, which may have any size, without a word of it.
                stated = {c.name for c in table.columns if c.unit and (
                    name != 'no units' or unit_of_label(c.name)[1] not in EFFORTS)}
                outcome = guess if isinstance(guess, str) else ', '.join(
                    sorted(errors(layout, guess, mutated[1], stated)))
                yield make.__name__.strip('_'), name, order, outcome, guess


def run(args):
    """Run the system test; returns 1 when more than ALLOWED are wrong in silence."""
    counts, wrong, kinds, layouts = Counter(), 0, Counter(), Counter()
    for layout, names, order, outcome, guess in outcomes(args.seed, args.only):
        silent = outcome not in ('', 'asked', 'refused')
        counts[outcome if outcome and not silent else 'wrong' if silent else 'right'] += 1
        if silent:
            wrong += 1
            kinds.update(outcome.split(', '))
            layouts[layout] += 1
            if args.verbose:
                print(f'{layout}, {names}, {order}: {outcome}')
                for joint, own in (guess.data.get('joints') or {
                        '': guess.data['signals']}).items():
                    print('   ', joint, {role: f"{block['column']} {block.get('unit', '')}"
                                         for role, block in own.items()})
    total = sum(counts.values())
    print(', '.join(f'{count} {name}' for name, count in counts.most_common()), f'of {total}')
    for table in (kinds, layouts):
        print('\n'.join(f'  {count} {name}' for name, count in table.most_common()))
    return int(wrong > ALLOWED * total)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
