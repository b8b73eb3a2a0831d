# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Alerts of a simulated six-axis arm with its description: false ones, and the joint of a fault.

Masses, inertias and frictions of each arm are off within their tolerances. Healthy arms pick and
place random payloads at random poses: every component of a joint that leaves OK is an alert.
Other arms repeat a program; after a while one joint gets a fault (Coulomb friction x 2, gap x 3,
or an encoder late by 10 ms), on PER_ARM copies of each arm: the joint named is the one with most
alerts since, weighted by level.

usage examples:
  .venv/bin/python test/system/robot_trust.py
  .venv/bin/python test/system/robot_trust.py --arms 24 --minutes 60 --cases 60 --jobs 2
"""
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import repeat
from multiprocessing import get_context
import sys

import numpy as np
from script import run_script

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.user_files import config_path, expect_folder_of, load_robot
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import ArmPlant, pick_and_place

T0 = 1_700_000_000_000_000_000
DT, SPREAD, SETTLED, SECOND = 1e-3, 0.1, 6.0, 1000  # s, relative, s, samples
MOVES, HEALTHY, FAULTY = 8, 16, 10  # of a program, repetitions before and after the fault
FAULTS = ('friction', 'backlash', 'encoder')
PER_ARM = 6  # faults of which each begins with the same healthy arm
LATE = 10  # samples
WORKED = []  # the arm of which processes take a copy, with its seed
RIGHT = 0.98
FILE = str(config_path('arm6.urdf'))


def add_arguments(parser):
    parser.add_argument('--arms', type=int, default=2, metavar='N',
                        help='number of healthy arms (default: %(default)s)')
    parser.add_argument('--minutes', type=float, default=10.0, metavar='N',
                        help='how long each works (default: %(default)s)')
    parser.add_argument('--cases', type=int, default=18, metavar='N',
                        help='number of faults (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=1, metavar='N',
                        help='seed of the first arm (default: %(default)s)')
    parser.add_argument('--jobs', type=int, default=1, metavar='N',
                        help='number of arms at a time (default: %(default)s)')
    add_json_option(parser)


class WatchedArm:
    """
    An arm and the Monitor of each joint, which are told of every payload.

    seed: of the arm. changes: of the parameters of all. alerts: {(joint, component): seconds
    beyond OK, weighted by level} since it was last cleared; parts: {what a message says: times}.
    """

    def __init__(self, robot, seed, **changes):
        self.rng, self.late = np.random.default_rng(seed), None
        drives = arm_plant.nominal_drives(robot)
        self.plant = ArmPlant(arm_plant.as_built(robot, self.rng, SPREAD),
                              arm_plant.drives_as_built(drives, self.rng), arm_plant.MIDDLE)
        self.monitors = [Monitor(drive, {
            **arm_plant.parameters_of(joint), 'robot_description': FILE, **changes}, robot=robot)
            for joint, drive in enumerate(drives)]
        self.alerts, self.messages = {}, {}

    def work(self, source, moves):
        """Pick and place, `moves` by the random numbers of `source`; return how long, s."""
        references, payload = pick_and_place(
            source, (arm_plant.LOW, arm_plant.HIGH, arm_plant.SPEED), self.plant.target,
            moves, DT, arm_plant.PAYLOADS)
        run = self.plant.run(references, payload, DT)
        motor, arm = (true + arm_plant.ENCODER * self.rng.normal(size=true.shape)
                      for true in (run.motor, run.arm))
        if self.late is not None:
            arm[LATE:, self.late] = arm[:-LATE, self.late].copy()
        stamps = T0 + np.round(run.t * 1e9).astype(np.int64)
        cuts = sorted({*range(0, len(stamps), SECOND), len(stamps),
                       *(np.flatnonzero(np.diff(payload)) + 1).tolist()})
        for joint, monitor in enumerate(self.monitors):
            u = np.column_stack([run.u[:, joint], np.full(len(stamps), np.nan)])
            y = np.column_stack([motor[:, joint], arm[:, joint]])
            for begin, end in zip(cuts, cuts[1:]):
                if payload[begin] != monitor.parameters.payload_mass:
                    monitor.set_parameters({'payload_mass': float(payload[begin])})
                monitor.run(Samples(stamps[begin:end], u[begin:end], y[begin:end],
                                    arm[begin:end]))
                if run.t[end - 1] > SETTLED and end % SECOND == 0:
                    self._count(joint, monitor)
        return len(stamps) * DT

    def _count(self, joint, monitor):
        for component, outcome in monitor.outcomes.items():
            if component in ('backlash', 'friction') and not monitor.health.alerts:
                continue  # not measured yet is WARN
            if outcome.level:
                key = joint + 1, component
                self.alerts[key] = self.alerts.get(key, 0) + int(outcome.level)
                self.messages.setdefault(key, outcome.message.split(':')[0])

    def named(self):
        """Return the joint with most alerts, None without any."""
        totals = {}
        for (joint, _), weight in self.alerts.items():
            totals[joint] = totals.get(joint, 0) + weight
        return max(totals, key=totals.get) if totals else None


def false_alarms(robot, seed, minutes):
    """Return (s worked, its alerts, what they say) of a healthy arm."""
    arm, worked = WatchedArm(robot, seed), 0.0
    while worked < 60.0 * minutes:
        worked += arm.work(arm.rng, 10)
    return worked, arm.alerts, arm.messages


def planted(robot, seed, cases):
    """Return what became of the faults `cases` (numbers) of an arm, see fault_of."""
    limits, start = (arm_plant.LOW, arm_plant.HIGH, arm_plant.SPEED), arm_plant.MIDDLE
    for _ in range(2):  # from the second time on the program ends where it begins
        references, _ = pick_and_place(np.random.default_rng(seed), limits, start, MOVES, DT)
        start = references[-1, 0]
    arm = WatchedArm(robot, seed, drift_window=len(references) * DT)
    for _ in range(HEALTHY):
        arm.work(np.random.default_rng(seed), MOVES)
    WORKED[:] = [(arm, seed)]
    with get_context('fork').Pool(1, maxtasksperchild=1) as pool:  # each takes a copy of it
        return pool.map(fault_of, cases, chunksize=1)


def fault_of(case):
    """Return what became of a fault of the arm in WORKED, {planted, fault, named, alerts}."""
    (arm, seed), = WORKED
    joint, fault = case // len(FAULTS) % len(arm.monitors), FAULTS[case % len(FAULTS)]
    before = dict(arm.alerts)
    arm.alerts.clear()
    arm.messages.clear()
    drive = arm.plant.drives[joint]
    if fault == 'friction':
        arm.plant.drives[joint] = replace(drive, coulomb_friction=2.0 * drive.coulomb_friction)
    elif fault == 'backlash':
        shape = drive.transmission
        arm.plant.drives[joint] = replace(
            drive, transmission=replace(shape, half_gap=3.0 * shape.half_gap))
    else:
        arm.late = joint
    for _ in range(FAULTY):
        arm.work(np.random.default_rng(seed), MOVES)
    result = {'planted': joint + 1, 'fault': fault, 'named': arm.named(), **{
        name: {f'{j} {component}': weight for (j, component), weight in alerts.items()}
        for name, alerts in (('alerts', arm.alerts), ('before', before))}}
    print(result, flush=True)
    return result


def text(data):
    """Return the figures as a table for the terminal."""
    lines = [f'  healthy: {data["hours"]:.2f} h of an arm, {data["healthy_alerts"]} components '
             'of joints that left OK']
    lines += [f'    joint {row["joint"]}, {row["component"]}: {row["seconds"]} s, '
              f'{row["message"]}' for row in data['healthy']]
    for fault in FAULTS:
        rows = [row for row in data['cases'] if row['fault'] == fault]
        right = sum(row['named'] == row['planted'] for row in rows)
        silent = sum(row['named'] is None for row in rows)
        lines.append(f'  {fault}: {right} of {len(rows)} in the right joint, {silent} without an '
                     'alert')
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    for name, least in (('arms', 0), ('cases', 0), ('minutes', 0.5), ('jobs', 1)):
        if getattr(args, name) < least:
            raise InputError(f'--{name}: {getattr(args, name)}, expected >= {least}')
    expect_folder_of(args.json)
    robot, table = load_robot(FILE), BarTable()
    first = range(0, args.cases, PER_ARM)
    with ProcessPoolExecutor(args.jobs, get_context('fork')) as pool:
        cases = [result for results in pool.map(
            planted, repeat(robot), [args.seed + 1000 + k for k in first],
            [range(k, min(k + PER_ARM, args.cases)) for k in first]) for result in results]
        healthy = list(pool.map(false_alarms, repeat(robot),
                                [args.seed + k for k in range(args.arms)], repeat(args.minutes)))
    rows = [{'joint': joint, 'component': component, 'seconds': seconds,
             'message': messages[joint, component]}
            for _, alerts, messages in healthy for (joint, component), seconds in alerts.items()]
    if healthy:
        table.check('components of healthy joints that left OK', str(len(rows)), '0', not rows)
    if cases:
        share = np.mean([row['named'] == row['planted'] for row in cases])
        table.check('faults in the right joint', f'{share:.3f}', f'>= {RIGHT:g}', share >= RIGHT)
    data = {'seed': args.seed, 'hours': sum(s for s, _, _ in healthy) / 3600.0,
            'healthy': rows, 'healthy_alerts': len(rows), 'cases': cases, 'bars': table.rows}
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
