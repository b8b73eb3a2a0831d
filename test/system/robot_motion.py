#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Judge the motions of suggest --robot on random robots that MuJoCo simulates.

A robot with friction that its file lacks repeats a motion, healthy, on two days. What the
diagnosis of the second log states as the smallest visible payload at the last link is compared:
in a random motion, and in the suggested one of the same length, which takes no more range, speed
and torque of any joint than the random one. Bar: half as large in the median.

usage examples:
  robot_motion.py --seeds 70000 70012
"""
import json
from pathlib import Path
import sys
import time

import mujoco
import numpy as np
import random_robots
from scipy.interpolate import CubicSpline
from script import run_script

from gearbox_monitor.balance.knowledge import learn
from gearbox_monitor.balance.robot_experiment import ALLOWED, design, model_torque, RobotLimits
from gearbox_monitor.balance.rows import RobotModel
from gearbox_monitor.balance.verdict import diagnose
from gearbox_monitor.export.robot_model import chain_of_compiled

HALF = 0.5


def limits_of(chain, path):
    """Return the limits that a motion takes up; a design keeps a margin to what it is given."""
    t, q, v = (x[::20] for x in path)
    low, high = q.min(axis=0), q.max(axis=0)
    edge = 0.5 * (1.0 / ALLOWED - 1.0) * (high - low)
    torque = np.abs(model_torque(chain, t, q, v)).max(axis=0)
    return RobotLimits(low - edge, high + edge, np.abs(v).max(axis=0) / ALLOWED, torque / ALLOWED)


def case_of(seed, seconds):
    """Return the record of one robot."""
    case = random_robots.make(seed, True, [], 100)
    model = mujoco.MjModel.from_xml_string(case.xml)
    chain = chain_of_compiled(model, Path('robot.xml'))
    n, link = len(case.joints), case.links[-1]
    robot = RobotModel(chain, np.full(n, .4), 0.0, learnt=True)
    slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    usual = random_robots.random_path(np.random.default_rng([seed, 1]), n, seconds + 1, slides)
    began = time.process_time()
    motion = design(robot, limits_of(chain, usual), [('payload', None)], link, seconds)
    spent = time.process_time() - began
    t = np.minimum(usual[0], motion.t[-1])
    spline = CubicSpline(motion.t, motion.q)
    designed = usual[0], spline(t), spline(t, 1) * (usual[0] <= motion.t[-1])[:, None]
    sizes, kinds = [], []
    for path in (usual, designed):
        reference, today = (random_robots.log(case, day, seconds, False, path=path)[0]
                            for day in (2, 1))
        verdict = diagnose(robot, [today], learn(robot, [reference]))
        sizes.append(verdict.visible['payload'][link])
        kinds.append(verdict.kind)
    return {'seed': seed, 'robot': case.kind, 'joints': n, 'random': sizes[0],
            'suggested': sizes[1], 'ratio': sizes[1] / sizes[0], 'predicted': 1.0 / motion.gain,
            'kinds': kinds, 'cpu': round(spent, 1)}


def add_arguments(parser):
    parser.add_argument('--seeds', type=int, nargs=2, default=(70000, 70012), metavar='N')
    parser.add_argument('--seconds', type=float, default=20.0, metavar='S')


def run(args):
    """Run all seeds, print the records, and return 1 if the median ratio exceeds HALF."""
    records = []
    for seed in range(*args.seeds):
        records.append(case_of(seed, args.seconds))
        print(json.dumps(records[-1]), flush=True)
    ratios = sorted(r['ratio'] for r in records)
    print(f'smallest visible payload, suggested over random: median {np.median(ratios):.2f}, '
          f'{ratios[0]:.2f} to {ratios[-1]:.2f} of {len(ratios)} robots')
    return int(np.median(ratios) > HALF)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
