#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Judge the conventions named in logs of random robots: drawn singly, and none in changed robots.

Each seed is one robot of random_robots.py that MuJoCo simulates, healthy or with a change (a
payload, friction, a tilted base ...). Its log is read as it is, and once for each kind of
convention at a joint that is drawn: reversed, effort of the other sign, effort in another unit, a
zero elsewhere, degrees, two joints exchanged. A convention is visible if the true reading explains
the log better than the wrong one by the margin of the check: others change nothing that weight and
inertia show (a zero about the vertical, that of a balanced wrist). A zero of tenths of a radian
is visible if the check does not say that the log may hide it, or that an effect explains it.

usage examples:
  robot_conventions.py --seeds 100 140
  robot_conventions.py --seeds 100 140 --out cases.jsonl
"""
import json
import math
from pathlib import Path
import sys
import time

import mujoco
import numpy as np
import random_robots
from robot_gap import interval
from script import run_script

from gearbox_monitor.diagnosis.robot.conventions import (
    ConventionBalance, LIMITS, log_as_read, named_readings, RobotReading, thinned)
from gearbox_monitor.diagnosis.robot.robot_log import LogSection, RobotLog
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.zeros import zeros_in
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.signals.recording import Convention
from gearbox_monitor.simulators.robot_model import chain_of_compiled

SINGLE = ('reversed', 'effort sign', 'effort unit', 'zero', 'degrees', 'exchanged')
TWO, TURNED = 'two joints', 'turned'
KINDS = (*SINGLE, TURNED, TWO)


def wrong_of(kind, rng, slides):
    """Return the RobotReading that undoes a convention of this kind at joints that are drawn."""
    if kind == TWO:
        joints = {}
        while len(joints) < 2:
            joints |= wrong_of(SINGLE[rng.integers(4)], rng, slides).joints
        return RobotReading(joints)
    count = len(slides)
    hinges = np.flatnonzero(~np.array(slides))
    turns = kind in ('zero', TURNED, 'degrees') and len(hinges)
    j = int(rng.choice(hinges if turns else count))
    if kind == TURNED:
        return RobotReading({j: Convention(zero=float(rng.choice([-1, 1]) * rng.uniform(.1, .8)))})
    c = float(rng.choice([-1, 1]) * rng.uniform(0.35, math.pi))
    c = float(rng.choice([c, math.pi / 2, -math.pi / 2, math.pi]))
    k = float(np.exp(rng.choice([-1, 1]) * rng.uniform(math.log(2.5), math.log(30))))
    convention = {'reversed': Convention(reversed=True), 'effort sign': Convention(effort=-1.0),
                  'effort unit': Convention(effort=k), 'zero': Convention(zero=c),
                  'degrees': Convention(unit=math.pi / 180)}.get(kind)
    if convention is None:
        i, j = sorted(rng.choice(count, 2, False).tolist())
        return RobotReading(swapped=(i, j))
    return RobotReading({j: convention})


def misread(log, reading):
    """Return the log as a driver with another convention writes it."""
    sections = []
    for s in log.sections:
        q, u = s.position.copy(), s.input.copy()
        for j, c in reading.joints.items():
            q[:, j] = (c.sign * q[:, j] + c.zero) / c.unit
            u[:, j] = u[:, j] / (c.sign * c.effort)
        if reading.swapped:
            i, j = reading.swapped
            q[:, [i, j]], u[:, [i, j]] = q[:, [j, i]], u[:, [j, i]]
        sections.append(LogSection(s.t, q, u))
    return RobotLog(log.name, log.joints, log.kind, tuple(sections), log.rate)


def same(named, truth):
    """Return whether a reading says of the same joint the same, a zero to 0.1 rad."""
    if named.swapped or truth.swapped:
        return named.swapped == truth.swapped and not named.joints and not truth.joints
    if set(named.joints) != set(truth.joints):
        return False
    pairs = [(c, truth.joints[j]) for j, c in named.joints.items()]
    turns = [abs((a.zero - b.zero + math.pi) % (2 * math.pi) - math.pi) for a, b in pairs]
    return all(a.reversed == b.reversed and a.unit == b.unit and a.effort * b.effort > 0
               and turn < 0.15 and abs(math.log(a.effort / b.effort)) < 0.3
               for (a, b), turn in zip(pairs, turns))


def judged(found, truth):
    """Return how what was found of a log is right about its convention, the `truth`."""
    if not found:
        return 'none'
    if len(truth.joints) == 2:  # one of two that is named is right as far as it goes
        parts = [[r.joints for r in (n.reading, *n.rivals) if not r.swapped] for n in found]
        single = [any(same(RobotReading(r), RobotReading({j: truth.joints[j] for j in r}))
                      for r in part if set(r) <= set(truth.joints)) for part in parts]
        return 'false' if not all(single) else 'right' if len(found) == 2 else 'half'
    if not any(same(r, truth) for n in found for r in (n.reading, *n.rivals)):
        return 'false'
    return 'right' if len(found) == 1 else 'right and more'


def is_open(log, robot, found, truth):
    """Return whether the check leaves the zero of the `truth` open beside what was `found`."""
    (j, c), = truth.joints.items()
    zeros = zeros_in(log_as_read(log, [n.reading for n in found]), robot)
    return (abs(c.zero) < SETTINGS.zero_shown or j in zeros.hidden
            or zeros.rival is not None and zeros.joint == j)


def words(reading):
    """Return a reading in a few words."""
    if reading.swapped:
        return f'exchanged {reading.swapped[0]} {reading.swapped[1]}'
    return ' '.join(f'{j}={c.rules}' for j, c in reading.joints.items())


def case_of(seed, kinds=KINDS):
    """Return the record of one robot: its log as it is, and with each kind of convention."""
    case = random_robots.make(seed, pair=seed % 3 == 2)
    if len(case.joints) < 2:
        return None
    chain = chain_of_compiled(mujoco.MjModel.from_xml_string(case.xml), Path('robot.xml'))
    robot = RobotModel(chain, np.full(len(case.joints), .05), .05)
    log = random_robots.log(case, 1, 40.0)[0]
    rng, began = np.random.default_rng(seed), time.process_time()
    record = {'seed': seed, 'robot': case.kind, 'joints': len(case.joints),
              'change': [e['kind'] for e in case.truth],
              'as it is': [words(n.reading) for n in named_readings(log, robot)], 'wrong': []}
    for kind in kinds:
        truth = wrong_of(kind, rng, case.slides)
        recorded = misread(log, truth)
        balance = ConventionBalance(robot, thinned(recorded))
        without = [RobotReading({i: truth.joints[i]}) for i in truth.joints] * (kind == TWO)
        without.append(RobotReading())
        gain = min(balance.score(r).deviance for r in without) - balance.score(truth).deviance
        found = named_readings(recorded, robot)
        named = [n.reading for n in found]
        record['wrong'].append({
            'kind': kind, 'truth': words(truth), 'visible': gain > LIMITS.margin
            if kind != TURNED else bool(found) or not is_open(recorded, robot, found, truth),
            'gain': round(gain, 1), 'named': [words(n) for n in named],
            'rivals': [words(r) for n in found for r in n.rivals],
            'how': judged(found, truth)})
    record['cpu'] = round(time.process_time() - began, 1)
    return record


def table(records):
    """Return lines of a summary."""
    lines = [f'as they are: {interval(sum(not r["as it is"] for r in records), len(records))} '
             'without a convention; named in ' + (', '.join(
                 f'{r["seed"]} {r["change"]} {r["as it is"]}' for r in records if r['as it is'])
                 or 'none')]
    for kind in (*KINDS, ''):
        rows = [(r['seed'], w) for r in records for w in r['wrong'] if kind in ('', w['kind'])]
        seen = [(seed, w) for seed, w in rows if w['visible']]
        if seen:
            right = sum(w['how'].startswith('right') for _, w in seen)
            false = sum(w['how'] == 'false' for _, w in rows)
            others = [(seed, w['truth'], w['named']) for seed, w in rows if w['how'] == 'false'
                      or w['visible'] and w['how'] in ('none', 'half')]
            lines.append(f'{kind or "all"}: visible {len(seen)} of {len(rows)}, right '
                         f'{interval(right, len(seen))}; false in all {false}'
                         + (f' {others[:8]}' if kind else ''))
    return lines


def add_arguments(parser):
    parser.add_argument('--seeds', type=int, nargs=2, default=(100, 140), metavar='N')
    parser.add_argument('--kinds', nargs='*', default=KINDS, choices=KINDS)
    parser.add_argument('--out', help='file for one line of JSON per robot')


def run(args):
    """Run the robots and return the exit code: 1 if a bar is missed."""
    records = []
    for seed in range(*args.seeds):
        record = case_of(seed, args.kinds)
        if record is None:
            continue
        records.append(record)
        print(json.dumps(record), flush=True)
        if args.out:
            with open(args.out, 'a', encoding='utf-8') as file:
                file.write(json.dumps(record) + '\n')
    print('\n'.join(table(records)))
    seen = [w for r in records for w in r['wrong'] if w['visible']]
    right = sum(w['how'].startswith('right') for w in seen)
    return int(right < .95 * len(seen) or any(r['as it is'] for r in records))


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
