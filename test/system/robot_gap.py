#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Judge the diagnosis of whole robots on random ones that MuJoCo simulates, with known changes.

Each seed is one robot and one case. A change counts as visible if an oracle that knows its torque
gains 40 in 2 log likelihood, of two each beside the other. One line of JSON per case, then a table
with 90 % intervals.

usage examples:
  robot_gap.py --seeds 5000 5100                 # beside the nominal file
  robot_gap.py --seeds 6000 6060 --pair          # against a reference
  robot_gap.py --seeds 7000 7040 --setpoint --out cases.jsonl
  robot_gap.py --seeds 8000 8020 --both          # torques and setpoints in one log
  robot_gap.py --seeds 9000 9020 --bare          # the file states no friction and no rotors
"""
import json
from pathlib import Path
import sys
import time

import mujoco
import numpy as np
import random_robots
from scipy.stats import beta
from script import run_script

from gearbox_monitor.diagnosis.robot.candidates import Candidate, library
from gearbox_monitor.diagnosis.robot.knowledge import learn
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.servo import with_learnt_servos, with_servos
from gearbox_monitor.diagnosis.robot.verdict import diagnose
from gearbox_monitor.simulators.robot_model import chain_of_compiled

VISIBLE = 40.0
OFFSETS = ('torque_offset', 'coulomb_asymmetry')
BARE = ('motor_coulomb', 'motor_viscous', 'motor_inertia')  # that a file may lack
FIRST_VALUE = {'motor_coulomb': 'Cc_change', 'motor_viscous': 'Cv_change', 'stribeck': 'Cs',
               'motor_inertia': 'm1_change', 'quadratic_friction': 'Cq', 'load_friction': 'Cl',
               'torque_offset': 'u0', 'torque_gain': 'g', 'actuator_delay': 'T', 'gravity': 'G',
               'cogging': 'A', 'payload': 'm'}


def place_of(case, e):
    """Return where a change is."""
    if e['kind'] == 'base_tilt':
        return 'base'
    return case.links[e['link']] if 'link' in e else case.joints[e['joint']]


def gain_of_truth(verdict, case, oracle):
    """Return 2 log likelihood that the least visible change gains an oracle of the others."""
    rows, evidence = verdict.evidence.recordings[0], verdict.evidence
    t, torques = oracle
    begin, truths = rows.motion.t + case.begin, []
    for e, torque in zip(case.truth, torques):
        # Inertia, speed and a servo's damping from the same smoothed motion: the true one would
        # know its error.
        b = {'payload': lambda e: np.r_[e['m'], e['m'] * np.array(e['c'])],
             'base_tilt': lambda e: -9.81 * np.sin(e['angle']) * np.array(
                 [-np.cos(e['phase']), -np.sin(e['phase'])]),
             'motor_inertia': lambda e: np.array([e['size']]),
             'motor_viscous': lambda e: np.array([e['size']])}.get(e['kind'])
        columns = {}
        if b is None:
            columns = {j: rows.tested(j, np.interp(begin, t, x)[:, None])
                       for j, x in enumerate(torque.T) if np.abs(x).max() > 1e-12}
        else:
            for c in library([rows], [e['kind']]):
                if c.place == place_of(case, e):
                    c = c.at_setting(np.array(e['c'])) if e['kind'] == 'payload' else c
                    values = b(e)  # a tilt of two angles: without the change of gravity's size
                    columns = {j: (x[:, :len(values)] @ values)[:, None]
                               for j, x in c.columns.items()}
        if columns:
            truths.append(Candidate('truth', columns))
    if len(truths) < max(len(case.truth), 1):
        return 0.0
    whole = evidence.fit(truths).deviance
    return min(evidence.fit([*truths[:i], *truths[i + 1:]]).deviance - whole
               for i in range(len(truths)))


def case_of(seed, pair=False, setpoint=False, change=None, rate=None, both=False, bare=False):
    """Return the record of one case."""
    case = random_robots.make(seed, pair, change, rate)
    file = mujoco.MjModel.from_xml_string(case.xml)
    if bare:
        file.dof_damping[:] = file.dof_frictionloss[:] = file.dof_armature[:] = 0.0
    chain = chain_of_compiled(file, Path('robot.xml'))
    n = len(case.joints)
    log, oracle, (kp, kd) = random_robots.log(case, 1, 40.0, True, setpoint, '', both)
    case.begin = log.sections[0].t[0]
    reference = random_robots.log(case, 2, 60.0, False, setpoint, '', both)[0] if pair else None
    began = time.process_time()
    knowledge, learnt = None, 0.0
    servo = {'kp': kp, 'kd': kd, 'compensated': True} if setpoint or both else {}
    if pair:
        robot = RobotModel(chain, np.full(n, .4), 0.0, learnt=True, **servo)
        knowledge = with_learnt_servos(learn(robot, [reference]), robot, [reference])
        learnt = time.process_time() - began
    else:
        robot = RobotModel(chain, np.full(n, .05), .05, **servo)
    verdict = diagnose(robot, [log], knowledge)
    servos = with_servos(verdict, robot, [log], knowledge=knowledge).findings[
        len(verdict.findings):] if both else ()
    spent = time.process_time() - began - learnt
    # Friction and rotors that the file lacks are no changes.
    truth = [[e['kind'], place_of(case, e)] for e in case.truth]
    findings = [f for f in verdict.findings
                if not bare or f.effect not in BARE or [f.effect, f.joint] in truth]
    out = {
        'seed': seed, 'robot': case.kind, 'joints': n, 'rate': case.rate, 'uneven': case.uneven,
        'truth': truth,
        'sizes': [float(e.get('size', e.get('m', e.get('angle', 0)))) for e in case.truth],
        'visible': round(gain_of_truth(verdict, case, oracle), 1),
        'verdict': verdict.kind if findings or verdict.kind != 'effect' else 'none',
        'findings': [[f.effect, f.joint or f.link,
                      {k: float(np.round(v, 5)) for k, v in f.values.items()},
                      {k: v and round(v, 5) for k, v in f.deviations.items()},
                      round(f.evidence), list(f.confusable)] for f in findings],
        'remainder': [[r.joint, r.over] for r in verdict.remainders],
        'kinds': [f.effect for f in findings],
        'cautions': len(verdict.cautions),
        'questions': [[q.effect, q.place, q.smallest, q.plausible] for q in verdict.questions],
        'cpu': [round(learnt, 2), round(spent, 2)]}
    if bare:
        out['unstated'] = {f.joint: f.values['Cc'] for f in verdict.findings
                           if f.effect == 'motor_coulomb'}
    if both:
        out['servos'] = [[f.effect, f.joint, f.values.get('kp_factor'),
                          f.deviations.get('kp_factor')] for f in servos]
        out['gains'] = {j: round(x, 3) for j, x in zip(case.joints, case.servo) if x != 1.0}
    if knowledge is not None:
        out['dispersion'] = knowledge.dispersion.round(1).tolist()
        out['shapes'] = len(knowledge.shapes)
    out['how'] = judged(out)
    return out


def same(kind, finding):
    """Return whether a finding names the effect `kind`, by itself or among its equals."""
    names = {finding[0], *finding[5]}
    if kind in OFFSETS:
        return bool(names & set(OFFSETS)) or 'Ca' in finding[2]
    return kind in names


def judged(r):
    """Return 'kind: how' of a record."""
    truth, findings = r['truth'], r['findings']
    if not truth:
        return 'none: ' + ('right' if r['verdict'] == 'none' else r['verdict'] if (
                           r['verdict'] == 'undecided') else
                           'false ' + (findings[0][0] if findings else 'unknown'))
    if truth[0][0] in random_robots.OUTSIDE:
        joints = [x[0] for x in r['remainder']]
        good = r['verdict'] in ('unknown', 'incomplete') and truth[0][1] in joints
        return 'outside: ' + ('right' if good else r['verdict'] if not findings else
                              f'named {findings[0][0]}' + (
                                  '' if findings[0][1] == truth[0][1] else ' elsewhere'))
    kind = 'two' if len(truth) == 2 else 'one'
    hit = [any(same(t[0], f) and f[1] == t[1] or '@'.join(t) in f[5] for f in findings)
           for t in truth]
    if all(hit):
        exact = all(any(t[0] == f[0] and f[1] == t[1] for f in findings) for t in truth)
        return f'{kind}: ' + ('right' if exact else 'confusable') + (
            ' and more' if len(findings) > len(truth) else '')
    if kind == 'two' and any(hit):
        return 'two: one of them'
    if not findings:
        return f'{kind}: {r["verdict"]}'
    places = [t[1] for t in truth]
    return f'{kind}: ' + ('wrong law' if any(f[1] in places for f in findings) else 'wrong joint')


def interval(good, count):
    """Return the 90 % interval of a share (Clopper and Pearson)."""
    low = beta.ppf(.05, good, count - good + 1) if good else 0.0
    high = beta.ppf(.95, good + 1, count - good) if good < count else 1.0
    return f'{good} of {count} ({100 * low:.0f} to {100 * high:.0f} %)'


def table(records):
    """Return lines of a summary."""
    lines, visible = [], [r for r in records if not r['truth'] or r['visible'] >= VISIBLE]
    for kind in ('none', 'one', 'two', 'outside'):
        part = [r for r in visible if r['how'].startswith(kind + ':')]
        if part:
            hows = {}
            for r in part:
                hows.setdefault(r['how'].split(': ')[1], []).append(r['seed'])
            good = sum(len(v) for k, v in hows.items() if k.startswith(('right', 'confusable')))
            lines.append(f'{kind}: {interval(good, len(part))} ' + ', '.join(
                f'{k} {len(v)}' + ('' if k == 'right' else f' {v}') for k, v in hows.items()))
    hidden = [r for r in records if r['truth'] and r['visible'] < VISIBLE]
    lines.append(f'not visible: {len(hidden)}, of which none '
                 f'{sum(r["verdict"] == "none" for r in hidden)}')
    z = []
    for r in visible:
        for t, size in zip(r['truth'], r['sizes']):
            key = FIRST_VALUE.get(t[0])
            for f in r['findings']:
                if f[0] == t[0] and f[1] == t[1] and key in f[2] and f[3].get(key):
                    z.append((abs(f[2][key]) - abs(size)) / f[3][key])
    if z:
        z = np.abs(z)
        lines.append(f'sizes within 1 deviation {interval(int((z < 1).sum()), len(z))}, within 2 '
                     f'{interval(int((z < 2).sum()), len(z))}')
    if any('servos' in r for r in records):
        true = [(r, j, x) for r in records for j, x in r['gains'].items() if abs(x - 1) > .15]
        named = [(x, f) for r, j, x in true for f in r['servos'] if f[:2] == ['servo_gain', j]]
        close = [abs(f[2] - x) < max(3 * (f[3] or np.inf), .1 * x) for x, f in named]
        others = [f'{r["seed"]} {f[0]} {f[1]}' for r in records for f in r['servos']
                  if f[0] != 'servo_gain' or f[1] not in r['gains']]
        lines.append(f'gains of servos named {interval(len(named), len(true))}, sizes right '
                     f'{interval(sum(close), len(close))}, others named: {others or "none"}')
    cpu = np.array([r['cpu'] for r in records])
    lines.append(f'cpu: learn {np.median(cpu[:, 0]):.1f} s (most {cpu[:, 0].max():.1f}), judge '
                 f'{np.median(cpu[:, 1]):.1f} s (most {cpu[:, 1].max():.1f})')
    return lines


def add_arguments(parser):
    parser.add_argument('--seeds', type=int, nargs=2, default=(5000, 5040), metavar='N')
    parser.add_argument('--pair', action='store_true', help='against a reference')
    parser.add_argument('--setpoint', action='store_true', help='logs of setpoints')
    parser.add_argument('--both', action='store_true', help='logs of torques and setpoints')
    parser.add_argument('--bare', action='store_true', help='a file without friction and rotors')
    parser.add_argument('--rate', type=float, help='samples per second of all logs')
    parser.add_argument('--change', nargs='*', help='kinds of all changes; none: healthy')
    parser.add_argument('--out', help='file for one line of JSON per case')


def run(args):
    """Run the cases and return the exit code: 1 if a bar is missed."""
    records = []
    for seed in range(*args.seeds):
        record = case_of(seed, args.pair, args.setpoint, args.change, args.rate, args.both,
                         args.bare)
        records.append(record)
        line = json.dumps(record, default=float)
        print(line if args.out is None else f'{seed} {record["how"]}', flush=True)
        if args.out:
            with open(args.out, 'a', encoding='utf-8') as file:
                file.write(line + '\n')
    print('\n'.join(table(records)))
    wrong = [r for r in records if 'wrong joint' in r['how']]
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
