# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Error of tau_K of a simulated six-axis arm, with its description against an unknown load.

Masses and inertias of the arm are off by up to 10 %, frictions and motor inertias by their
tolerances; it picks and places random payloads, which the estimators are told. Truth: the
simulation. Ratios are of rms errors over all arms. coverage: share of the errors within the stated
95 %.

usage examples:
  .venv/bin/python test/system/robot_arm.py
  .venv/bin/python test/system/robot_arm.py --arms 20 --seed 7 --json arm.json
"""
import sys

import numpy as np
from script import run_script

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.files.user_files import config_path, expect_folder_of, load_robot
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import ArmPlant

T0 = 1_700_000_000_000_000_000
DT, SPREAD, MOVES, SETTLED = 1e-3, 0.1, 4, 0.5  # s, relative, -, s
RATIO, COVERAGE = 0.5, 0.95
PAYLOADS = (1.0, 5.0)  # kg
FILE = str(config_path('arm6.urdf'))
LOADS = {'unknown': {'arm_load': 'unknown', 'friction_error_std': 0.0}, 'model': {}}


def add_arguments(parser):
    parser.add_argument('--arms', type=int, default=10, metavar='N',
                        help='number of arms (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=1, metavar='N',
                        help='seed of the first arm (default: %(default)s)')
    add_json_option(parser)


def worked(plant, rng, moves, dt):
    """Return the ArmRun of `moves`, its payload, kg, and measured positions of motors and arms."""
    references, payload = arm_plant.pick_and_place(
        rng, (arm_plant.LOW, arm_plant.HIGH, arm_plant.SPEED), plant.target, moves, dt, PAYLOADS)
    run = plant.run(references, payload, dt)
    return run, payload, *(true + arm_plant.ENCODER * rng.normal(size=true.shape)
                           for true in (run.motor, run.arm))


def measured(robot, seed):
    """Return {load: [(mean squared error, coverage) of each joint]} of one arm."""
    rng, drives = np.random.default_rng(seed), arm_plant.nominal_drives(robot)
    plant = ArmPlant(arm_plant.as_built(robot, rng, SPREAD),
                     arm_plant.drives_as_built(drives, rng), arm_plant.MIDDLE)
    run, payload, motor, arm = worked(plant, rng, MOVES, DT)
    stamps = T0 + np.round(run.t * 1e9).astype(np.int64)
    cuts = [0, *np.flatnonzero(np.diff(payload)) + 1, len(payload)]
    rows = {load: [] for load in LOADS}
    for joint, drive in enumerate(drives):
        u = np.column_stack([run.u[:, joint], np.full(len(stamps), np.nan)])
        y = np.column_stack([motor[:, joint], arm[:, joint]])
        for load, changes in LOADS.items():
            engine = Estimator(drive, {**arm_plant.parameters_of(joint), 'smoother_lag': 0.0,
                                       'robot_description': FILE, **changes}, robot)
            errors, stated = [], []
            for begin, end in zip(cuts, cuts[1:]):
                engine.set_parameters({'payload_mass': float(payload[begin])})
                e = engine.run(Samples(stamps[begin:end], u[begin:end], y[begin:end],
                                       arm[begin:end]))
                k = np.searchsorted(stamps, e.stamp_ns)
                counted = k > SETTLED / DT
                errors.append((e.tau_k - run.tau_k[k, joint])[counted])
                stated.append(e.tau_k_std[counted])
            error, std = np.concatenate(errors), np.concatenate(stated)
            rows[load].append((float(np.mean(error ** 2)),
                               float(np.mean(np.abs(error) < 1.96 * std))))
    return rows


def text(data):
    """Return the figures as a table for the terminal."""
    lines = ['  joint  rms error unknown  with model   ratio   coverage unknown  with model']
    lines += [f'  {k + 1:5d}{row["unknown"]:13.3f} N m{row["model"]:8.3f} N m{row["ratio"]:8.2f}'
              f'{row["coverage_unknown"]:19.3f}{row["coverage_model"]:12.3f}'
              for k, row in enumerate(data['joints'])]
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    if args.arms < 1:
        raise InputError(f'--arms: {args.arms}, expected >= 1')
    expect_folder_of(args.json)
    robot = load_robot(FILE)
    arms = [measured(robot, args.seed + k) for k in range(args.arms)]
    table, joints = BarTable(), []
    for joint in range(len(robot.joints)):
        rms, covered = ({load: float(f(np.mean([arm[load][joint][i] for arm in arms])))
                         for load in LOADS} for i, f in ((0, np.sqrt), (1, float)))
        ratio = rms['model'] / rms['unknown']
        joints.append({**rms, 'ratio': ratio, **{f'coverage_{k}': v for k, v in covered.items()}})
        table.check(f'joint {joint + 1}: error with the description over unknown', f'{ratio:.2f}',
                    f'<= {RATIO:g}', ratio <= RATIO)
        table.check(f'joint {joint + 1}: coverage with the description',
                    f'{covered["model"]:.3f}', f'>= {COVERAGE:g}', covered['model'] >= COVERAGE)
    data = {'arms': args.arms, 'seed': args.seed, 'joints': joints, 'bars': table.rows}
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
