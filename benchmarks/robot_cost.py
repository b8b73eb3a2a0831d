# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
CPU time and memory of the diagnosis of whole robots: beside the file, learnt, as a pair.

Robots of several arms of six joints; their logs are the torque of the model with noise, in the
log that is judged with Coulomb friction of one joint more.

usage examples:
  python -m benchmarks robot_cost
  python -m benchmarks robot_cost --arms 1 --seconds 120 --rate 200
"""
import argparse
from dataclasses import replace
import time
from typing import Any

import numpy as np

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, require_whole
from benchmarks.memory import forget_peak, peak_bytes
from gearbox_monitor.diagnosis.robot.knowledge import learn
from gearbox_monitor.diagnosis.robot.robot_log import checked_log, RawLog, RobotLog
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.verdict import diagnose
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import Chain, inertial, Link
from gearbox_monitor.robot.dynamics import GRAVITY

JOINTS = 6                          # of an arm
TORQUE_NOISE, ENCODER = 0.02, 1e-4  # N m, rad
CHANGE = 1.0                        # N m of Coulomb friction
# CPU s of learning and of a comparison, MB: of one arm, and of several.
BARS = {True: (10.0, 3.0, 500.0), False: (60.0, 60.0, 2000.0)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--arms', metavar='N', type=int, nargs='+', default=[1, 5],
                        help='robots, by their number of arms (default: 1 5)')
    parser.add_argument('--seconds', metavar='S', type=float, default=60.0)
    parser.add_argument('--rate', metavar='HZ', type=float, default=100.0)
    add_json_option(parser)


def robot(arms: int) -> Chain:
    """Return a robot of `arms` arms on one base."""
    links: list[Link] = []
    for arm in range(arms):
        for i in range(JOINTS):
            links.append(Link(
                f'link{arm}_{i}', f'joint{arm}_{i}', len(links) - 1 if i else -1, np.eye(3),
                np.array([0.0, 0.03, 0.2] if i else [float(arm), 0.0, 1.0]),
                np.eye(3)[(2, 1, 0)[i % 3]], False,
                inertial(3.0 * 0.7 ** i, np.array([0.01, 0.0, 0.1]),
                         np.diag([0.02, 0.02, 0.005]))))
    ones = np.ones(len(links))
    return Chain(tuple(links), 0.05 * ones, 0.5 * ones, ones, np.array(GRAVITY),
                 0.0 * ones, 0.0 * ones, 0.0 * ones)


def model_torque(chain: Chain, t: Array, q: Array, v: Array) -> Array:
    """
    Return the torque [N, J] that a motion needs by the model, N m.

    Args:
        chain: of the robot.
        t: times [N], s.
        q: positions [N, J], rad.
        v: speeds [N, J], rad/s.
    """
    momentum, out = chain.armature * v, chain.viscous * v + chain.coulomb * np.tanh(
        v / SETTINGS.slow)
    for r in chain.regressors(q, v):
        theta = chain.links[r.link].theta
        momentum[:, r.joint] += r.p @ theta
        out[:, r.joint] += (r.g - r.k) @ theta
    return np.asarray(out + np.gradient(momentum, t, axis=0))


def recorded(chain: Chain, seed: int, seconds: float, rate: float, change: float) -> RobotLog:
    """Return a log of a motion of sines, with `change` of the friction (N m) of one joint."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, 1.0 / rate)
    count = len(chain.links)
    q, v = np.zeros((len(t), count)), np.zeros((len(t), count))
    for _ in range(5):
        w, phase = 2.0 * np.pi * rng.uniform(0.05, 0.5, count), rng.uniform(0.0, 6.28, count)
        q += 0.25 * np.sin(t[:, None] * w + phase)
        v += 0.25 * w * np.cos(t[:, None] * w + phase)
    torque = model_torque(chain, t, q, v) + TORQUE_NOISE * rng.standard_normal(q.shape)
    torque[:, 2] += change * np.sign(v[:, 2])
    q += ENCODER * rng.standard_normal(q.shape)
    return checked_log(RawLog(f'log{seed}', t, dict(zip(chain.joints, q.T)),
                              dict(zip(chain.joints, torque.T)), 'torque'), chain.joints)


def measured(arms: int, seconds: float, rate: float) -> dict[str, Any]:
    """Return CPU s of each step and the peak of memory (MB) for a robot of `arms` arms."""
    chain = robot(arms)
    reference, log = (recorded(chain, k, seconds, rate, CHANGE * k) for k in range(2))
    count = len(chain.links)
    model = RobotModel(chain, np.full(count, 0.05))
    forget_peak()
    begin = time.process_time()
    diagnose(model, [log])
    beside = time.process_time()
    model = replace(model, tolerance=np.full(count, 0.4), friction_tolerance=0.0, learnt=True)
    knowledge = learn(model, [reference])
    learnt = time.process_time()
    verdict = diagnose(model, [log], knowledge)
    return {'joints': count, 'file': beside - begin, 'learn': learnt - beside,
            'pair': time.process_time() - learnt, 'megabytes': peak_bytes() / 1e6,
            'findings': [[f.effect, f.joint or f.link] for f in verdict.findings]}


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--arms', min(args.arms))
    for option, value in (('--seconds', args.seconds), ('--rate', args.rate)):
        if not 0.0 < value < np.inf:
            raise InputError(f'{option}: {value:g}, expected > 0')
    bars, rows = BarTable(), []
    for arms in args.arms:
        row = measured(arms, args.seconds, args.rate)
        rows.append(row)
        learning, comparing, memory = BARS[arms == 1]
        name = f'{row["joints"]} joints'
        bars.judge(f'{name}: CPU s of learning', row['learn'], high=learning)
        bars.judge(f'{name}: CPU s beside the file', row['file'], high=comparing)
        bars.judge(f'{name}: CPU s of a comparison', row['pair'], high=comparing)
        bars.judge(f'{name}: MB', row['megabytes'], high=memory)
    data = {'seconds': args.seconds, 'rate': args.rate, 'robots': rows, 'bars': bars.rows}
    return finish(data, '\n'.join([f'{r["joints"]} joints: {r["findings"]}' for r in rows]
                                  + bar_lines(bars.rows)), args.json)
