#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Judge PayloadTracker on random robots that take a load in motion and are pushed.

MuJoCo simulates arms, legs, SCARA arms and two-armed torsos of 2 to 7 joints at 50 to 500 Hz, with
masses off by up to 3 % (with --pair by 12 %, friction that no file knows, and two recordings from
before as the reference). After 30 s the last link takes a load; at 50 s all joints are pushed for
1.5 s. Printed: mass error over stated deviation, stated size, and how external torque scatters.

usage examples:
  payload.py --robots 20 --seed 5000
  payload.py --robots 20 --seed 6000 --pair    # with a reference
"""
from concurrent.futures import ProcessPoolExecutor
import sys

import numpy as np
import random_robots
from script import run_script

from gearbox_monitor.diagnosis.robot.knowledge import learn
from gearbox_monitor.diagnosis.robot.payload import PayloadTracker
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.simulators.robot_model import chain_of_compiled

TAKEN, PUSHED, PUSH, END = 30.0, 50.0, 1.5, 60.0  # s
SEEN = 5.0  # stated deviations from which a push counts as seen, and a false one as false


def judge(seed, pair):
    """Return what one robot's tracker said."""
    case = random_robots.make(seed, pair=pair, change=['payload'])
    rng, count = np.random.default_rng(seed + 77), len(case.joints)
    load = case.truth[0]
    load |= {'link': count - 1, 'm': rng.uniform(0.2, 1.0) * case.sizes[-1] / 3.0, 'start': TAKEN}
    push = rng.normal(size=count) * case.sizes * 0.2
    log = random_robots.log(case, 1, END, pushed=lambda t: push * (PUSHED < t < PUSHED + PUSH))[0]
    chain = chain_of_compiled(random_robots.mujoco.MjModel.from_xml_string(case.xml), 'robot.xml')
    model, knowledge = RobotModel(chain, np.full(count, 0.05)), None
    if pair:
        model = RobotModel(chain, np.full(count, 0.4), 0.0, True)
        knowledge = learn(model, [random_robots.log(case, k, END, changed=False)[0]
                                  for k in (3, 4)])
    tracker = PayloadTracker(model, knowledge=knowledge)
    estimates = [e for s in log.sections for t, q, u in zip(s.t, s.position, s.input)
                 for e in tracker.take(round(t * 1e9), q, u)]
    t = np.array([e.stamp_ns * 1e-9 for e in estimates])
    mass, std = (np.array([getattr(e, name) for e in estimates]) for name in ('mass', 'mass_std'))
    external, deviation = (np.array([getattr(e, name) for e in estimates])
                           for name in ('external', 'external_std'))
    z = external / deviation
    quiet = (t > 10.0) & ((t < TAKEN - 1.0) | (t > TAKEN + 4.0)) & (
        (t < PUSHED - 0.5) | (t > PUSHED + PUSH + 2.0))
    during = (t > PUSHED + 0.3) & (t < PUSHED + PUSH - 0.3)
    at = [int(np.searchsorted(t, s)) - 1 for s in (TAKEN - 0.5, TAKEN + 3.0, PUSHED - 1.0)]
    true = np.array([0.0, load['m'], load['m']])
    return {
        'kind': case.kind, 'joints': count, 'rate': case.rate, 'mass': load['m'],
        'z': ((mass[at] - true) / std[at]).tolist(), 'std': (std[at] / load['m']).tolist(),
        'centre': float(np.linalg.norm(estimates[at[2]].centre - load['c'])),
        'false': float(np.mean(np.abs(z[quiet]).max(axis=1) > SEEN)),
        'scatter': float(np.sqrt(np.mean(z[quiet] ** 2))),
        'seen': float(np.mean(np.abs(z[during]).max(axis=1) > SEEN)),
        'push': float(np.abs(external[during].mean(axis=0) - push).max()
                      / np.abs(push).max())}


def add_arguments(parser):
    parser.add_argument('--robots', type=int, default=20)
    parser.add_argument('--seed', type=int, default=5000, help='of the first robot')
    parser.add_argument('--pair', action='store_true', help='with two recordings from before')
    parser.add_argument('--jobs', type=int, default=2)


def run(args):
    with ProcessPoolExecutor(args.jobs) as pool:
        seeds = range(args.seed, args.seed + args.robots)
        rows = []
        for row in pool.map(judge, seeds, [args.pair] * len(seeds)):
            rows.append(row)
            print(f'{row["kind"]:6} {row["joints"]} joints {row["rate"]:3.0f} Hz '
                  f'{row["mass"]:6.3f} kg: z {" ".join(f"{z:+.1f}" for z in row["z"])}, stated '
                  f'{row["std"][2]:.3f} of it; external: scatter {row["scatter"]:.2f}, false '
                  f'{row["false"]:.3f}, push seen {row["seen"]:.2f}', flush=True)
    z = np.array([row['z'] for row in rows])
    for k, name in enumerate(('before', '3 s after', '19 s after')):
        print(f'mass {name:10}: within one stated deviation {np.mean(np.abs(z[:, k]) < 1):.2f}, '
              f'two {np.mean(np.abs(z[:, k]) < 2):.2f}, three {np.mean(np.abs(z[:, k]) < 3):.2f}; '
              f'stated, median {np.median([row["std"][k] for row in rows]):.3f} of the load')
    many = [row for row in rows if row['joints'] >= 5]
    print(f'external torque: scatter over stated, median '
          f'{np.median([row["scatter"] for row in rows]):.2f}; beyond {SEEN:g} deviations without '
          f'a push {np.mean([row["false"] for row in rows]):.4f} of the time; push seen, robots '
          f'of 5 joints and more: {np.mean([row["seen"] for row in many]):.2f} of its time')
    return 0


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
