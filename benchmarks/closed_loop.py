# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a corrected simulator is worth to a controller that is tuned in it.

A drive in MuJoCo deviates from its MJCF file as in `blind --plant mujoco`. A recording of it is
diagnosed with that file as the model, and the finding is exported into the file. One controller
(computed torque with friction compensation, feedback of the motor) is tuned by simulation in the
file, in the patched one and in the true one, and follows other paths in the true one.

usage examples:
  python -m benchmarks closed_loop
  python -m benchmarks closed_loop --drives 12 --seed 5 --json closed_loop.json
"""
import argparse
from collections.abc import Sequence
import math
from pathlib import Path
import tempfile
from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage, optimize

from benchmarks import intervals
from benchmarks.blind import mujoco_drives, real_joints
from benchmarks.blind.draw import log_uniform
from benchmarks.blind.mujoco_drives import DT, Label, OUTSIDE, Values
from benchmarks.blind.mujoco_set import unwarned
from benchmarks.harness import (
    add_drawn_options, bar_lines, BarTable, finish, progress_line, require_drawn)
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.identify import diagnose
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.library.simulator_file import export_model, load_model
from gearbox_monitor.robot.compiled_model import mujoco_module

SECONDS, RAMP = 4.0, 0.5      # s, of a path; over which it begins
EFFORT = 0.6                  # of the recorded peak torque, that a path needs by the file
SLOW, FAST = 0.3, 1.5         # Hz, of the sines of a path
TESTS = 3                     # paths in the true simulator
FILTER = 0.005                # s, of the speed that the controller measures
BANDWIDTH, DAMPING = 12.0, 0.7  # rad/s and ratio, of the feedback before it is tuned
SOFT = 0.05                   # of the largest speed or torque: over which a sign changes
ROUNDS = 6                    # of the tuning
LOST = 10.0                   # sizes of the path: the error of a drive that left it
SIMULATORS = ('nominal', 'patched', 'true')
HIGHEST = 1.1                 # median error of patched over true
REAL, TRIES = 3, 200          # every third drive is a joint of a real robot; draws


class LinkPath(NamedTuple):
    """A path of the link [N]: angle rad, speed rad/s, acceleration rad/s^2."""

    q: Array
    v: Array
    a: Array

    def scaled(self, factor: float) -> 'LinkPath':
        """Return the path of `factor` times the size."""
        return LinkPath(*(factor * part for part in self))


class Command(NamedTuple):
    """What the controller is given [N]: torque N m, angle rad and speed rad/s of the motor."""

    torque: Array
    q: Array
    v: Array


class Tuning(NamedTuple):
    """
    Values of the controller.

    m1, m2: inertias of motor and link, kg m^2; Cv, Cc: friction of the motor, N m s/rad and N m;
    G, H: weight of the link at pi/2 and at 0, N m; c, b: compliance, rad/(N m), and half gap, rad,
    of the gear; lead: s, by which torque goes ahead; kp, kd: feedback of the motor.
    """

    m1: float
    m2: float
    Cv: float
    Cc: float
    G: float
    H: float
    c: float
    b: float
    lead: float
    kp: float
    kd: float

    def command(self, path: LinkPath) -> Command:
        """Return what moves the link along `path`."""
        q, v, a = path
        load = self.m2 * a + self.G * np.sin(q) + self.H * np.cos(q)
        if self.c or self.b:
            # The motor goes ahead of the link by gap and twist; smoothed, it has a speed.
            q = q + self.c * load + self.b * np.tanh(load / (SOFT * np.abs(load).max()))
            q = ndimage.gaussian_filter1d(q, 0.01 / DT)
            v = np.gradient(q, DT)
            a = np.gradient(v, DT)
        torque = (load + self.m1 * a + self.Cv * v
                  + self.Cc * np.tanh(v / (SOFT * np.abs(path.v).max())))
        t = np.arange(len(q)) * DT
        return Command(np.interp(t + self.lead, t, torque), q, v)


LOGARITHMIC = ('m1', 'm2', 'Cv', 'c', 'b', 'kp', 'kd')  # the others change by a unit


class Simulator:
    """An MJCF file of a drive, its encoder, and a controller of the motor."""

    def __init__(self, xml: str, sigma: float, limit: float, gear: float) -> None:
        """
        Compile the file.

        Args:
            xml: its text.
            sigma: noise of the motor's encoder, rad.
            limit: of the torque that the controller commands, N m.
            gear: torque on the joint per control.
        """
        self.model = mujoco_module().MjModel.from_xml_string(xml)
        self.sigma, self.limit, self.gear = sigma, limit, gear
        # The link is the last joint of the drive; what swings at it comes after.
        self.link = int(self.model.ntendon > 0)

    def followed(self, path: LinkPath, tuning: Tuning, seed: Sequence[int]) -> Array:
        """
        Return the error of the link [N], in sizes (rms) of the path.

        Args:
            path: of the link.
            tuning: of the controller.
            seed: of the encoder's noise.
        """
        mujoco, (torque, wish, speed) = mujoco_module(), tuning.command(path)
        noise = self.sigma * np.random.default_rng(seed).standard_normal(len(path.q))
        data, link = mujoco.MjData(self.model), self.link
        data.qpos[0], data.qpos[link] = wish[0], path.q[0]
        steps = round(DT / self.model.opt.timestep)
        share, v, before = 1.0 - math.exp(-DT / FILTER), speed[0], wish[0] + noise[0]
        error, size = np.empty(len(path.q)), float(np.std(path.q))
        step, qpos, control, limit = mujoco.mj_step, data.qpos, data.ctrl, self.limit
        kp, kd = tuning.kp, tuning.kd
        for k, (u, r, w, n) in enumerate(zip(
                torque.tolist(), wish.tolist(), speed.tolist(), noise.tolist())):
            error[k] = qpos[link]
            q = qpos[0] + n
            v += share * ((q - before) / DT - v)
            before = q
            u += kp * (r - q) + kd * (w - v)
            control[0] = min(max(u, -limit), limit) / self.gear
            step(self.model, data, steps)
        error = (error - path.q) / size
        return np.clip(np.nan_to_num(error, nan=LOST), -LOST, LOST)


def start_of(v: Values) -> Tuning:
    """Return the controller by the values `v` of a file."""
    m = v['m1'] + v['m2']
    rigid = 'robot' in v
    return Tuning(v['m1'], v['m2'], v['Cv'], v['Cc'], v['G'] * math.cos(v['phi']),
                  v['G'] * math.sin(v['phi']), 0.0 if rigid else 1.0 / v['K'],
                  0.0 if rigid else v['b'], 0.0, m * BANDWIDTH ** 2, 2.0 * DAMPING * BANDWIDTH * m)


def tuned(simulator: Simulator, path: LinkPath, start: Tuning, seed: Sequence[int]) -> Tuning:
    """
    Return the controller with the least error of the link in a simulator.

    Args:
        simulator: where it is tuned.
        path: that it follows.
        start: the controller before.
        seed: of the encoder's noise.
    """
    # Values that are zero because the drive has no such part stay.
    names = [n for n in Tuning._fields if getattr(start, n) or n not in LOGARITHMIC]
    units = {'Cc': 0.1 * simulator.limit, 'G': 0.1 * simulator.limit, 'H': 0.1 * simulator.limit,
             'lead': 0.005}

    def at(x: Array) -> Tuning:
        return start._replace(**{
            n: getattr(start, n) * math.exp(d) if n in LOGARITHMIC else
            getattr(start, n) + units[n] * d for n, d in zip(names, x)})

    def misses(x: Array) -> Array:
        return simulator.followed(path, at(x), seed)[::5]
    bound = np.array([1.5 if n in LOGARITHMIC else 10.0 for n in names])
    fit = optimize.least_squares(misses, np.zeros(len(names)), bounds=(-bound, bound),
                                 diff_step=0.02, x_scale=np.where(bound > 2.0, 1.0, 0.3),
                                 max_nfev=ROUNDS)
    return at(fit.x)


def shape(random: np.random.Generator) -> LinkPath:
    """Return a path of three sines, by `random`."""
    t = np.arange(round(SECONDS / DT)) * DT
    rates = [log_uniform(random, SLOW, FAST) for _ in range(3)]
    parts = random.uniform(0.4, 1.0, 3) / rates
    s = np.clip(t / RAMP, 0.0, 1.0)
    q = s ** 3 * (10.0 - 15.0 * s + 6.0 * s ** 2) * sum(
        a * np.sin(2.0 * np.pi * f * t + random.uniform(-3.0, 3.0))
        for a, f in zip(parts, rates))
    v = np.gradient(q, DT)
    return LinkPath(q, v, np.gradient(v, DT))


def needing(torque: float, path: LinkPath, tuning: Tuning) -> LinkPath:
    """Return `path` so large that a rigid drive with `tuning` needs `torque` (N m) at most."""
    rigid = tuning._replace(c=0.0, b=0.0)
    low, high = 1e-6, 1e3
    for _ in range(60):
        middle = math.sqrt(low * high)
        peak = np.abs(rigid.command(path.scaled(middle)).torque).max()
        low, high = (middle, high) if peak < torque else (low, middle)
    return path.scaled(low)


def patched(recording: dict[str, Any], real: bool, folder: Path) -> tuple[str, str, list[str]]:
    """
    Return (file with the findings, verdict, what the file cannot express) by the public API.

    Args:
        recording: of mujoco_drives.make.
        real: whether the drive is one joint with one encoder.
        folder: new directory.
    """
    path = folder / 'robot.xml'
    path.write_text(recording['xml'], encoding='utf-8')
    joint, arm = ('joint', None) if real else ('motor', 'arm')
    model = load_model(path, joint, arm_joint=arm)
    y = recording['y']
    table = {'t': np.arange(len(y)) * DT, 'torque': recording['u'], 'motor': y[:, 0]}
    if not real:
        table['arm'] = y[:, 1]
    try:
        verdict = diagnose(load_recording(table, model, joints={'arm': ''} if real else None,
                                          name='recording'), model)
        file = export_model(verdict.model, 'mjcf', path, joint=joint, arm_joint=arm)
    except (InputError, Undecided) as error:
        return recording['xml'], f'refused: {error}', []
    named = '+'.join(f.effect for f in verdict.findings) or verdict.kind
    return file.text, named, [str(row) for row in file.lacking]


def drawn(ids: Sequence[str], number: int, seed: int) -> tuple[dict[str, Any], Label]:
    """Return a recording with the effects `ids` and its label, driven by a torque."""
    for attempt in range(TRIES):
        made = mujoco_drives.make(ids, [seed, number, attempt, 26], number % REAL == 0)
        if made and not made[1].nominal.get('kp'):
            return made
    raise RuntimeError(f'{"+".join(ids)}: not drawn in {TRIES} tries')


def plans(n: int, random: np.random.Generator) -> list[list[str]]:
    """Return the effects of `n` drives that deviate from their file."""
    real = {**real_joints.BOTH, **real_joints.OF_MOTORS}
    kinds = [[ids for ids in mujoco_drives.plan(2 * n + 4, random, list(names)) if ids]
             for names in (real, mujoco_drives.INSIDE)]
    return [kinds[number % REAL > 0].pop() for number in range(n)]


def compared(ids: Sequence[str], number: int, seed: int) -> dict[str, Any]:
    """
    Return the errors of the three controllers in the true simulator of one drive.

    Args:
        ids: its effects.
        number: of the drive.
        seed: of the run.
    """
    recording, label = drawn(ids, number, seed)
    v = label.nominal
    with tempfile.TemporaryDirectory() as folder:
        text, named, lacking = patched(recording, 'robot' in v, Path(folder))
    effort = np.abs(recording['u']).max()
    files = dict(zip(SIMULATORS, (recording['xml'], text, mujoco_drives.xml_of(label.truth))))
    simulators = {name: Simulator(xml, label.sigma[0], float(effort), v.get('gear', 1.0))
                  for name, xml in files.items()}
    random, start = np.random.default_rng([seed, number, 27]), start_of(v)
    paths = [needing(EFFORT * effort, shape(random), start) for _ in range(1 + TESTS)]
    errors = {}
    for name, simulator in simulators.items():
        tuning = tuned(simulator, paths[0], start, [seed, number, 28])
        errors[name] = float(np.sqrt(np.mean([np.mean(np.square(simulators['true'].followed(
            path, tuning, [seed, number, 29, i]))) for i, path in enumerate(paths[1:])])))
    return {'ids': list(ids), 'robot': v.get('robot'), 'named': named, 'lacking': lacking,
            'outside': bool({*ids} & {*OUTSIDE}), 'errors': errors}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    add_drawn_options(parser, 'drives', 30, 'drives that deviate from their file')


def judged(rows: Sequence[dict[str, Any]]) -> BarTable:
    """Return the bars of the `rows` of compared."""
    bars = BarTable()
    for name, kinds in (('of all drives', (False, True)), ('effects in the library', (False,)),
                        ('effects outside', (True,))):
        for simulator in SIMULATORS[:2]:
            ratios = [row['errors'][simulator] / row['errors']['true'] for row in rows
                      if row['outside'] in kinds]
            if ratios:
                whole = simulator == 'patched' and len(kinds) == 2
                bars.judge(f'{simulator} over true, median {name}', float(np.median(ratios)),
                           high=HIGHEST if whole else math.inf,
                           interval=intervals.median(ratios), count=f'{len(ratios)} drives')
    for simulator in SIMULATORS[:2]:
        bars.share(f'{simulator} at most {HIGHEST} of true', [
            row['errors'][simulator] <= HIGHEST * row['errors']['true'] for row in rows])
    return bars


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_drawn(args, 'drives')
    show, rows = progress_line(), []
    with unwarned():
        for number, ids in enumerate(plans(args.drives, np.random.default_rng([args.seed, 26]))):
            show(f'drive {number + 1} of {args.drives}')
            rows.append(compared(ids, number, args.seed))
    show('')
    bars = judged(rows).rows
    lines = [f'{"error / % of the path":<44}' + ''.join(f'{n:>10}' for n in SIMULATORS)]
    for row in rows:
        lines.append(f'{"+".join(row["ids"]) + " -> " + row["named"]:<44.44}' + ''.join(
            f'{100.0 * row["errors"][name]:>10.2f}' for name in SIMULATORS))
    return finish({'drives': args.drives, 'seed': args.seed, 'rows': rows, 'bars': bars},
                  '\n'.join([*lines, '', *bar_lines(bars)]), args.json)
