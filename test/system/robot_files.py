#!/usr/bin/env python3
# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compare MuJoCo's run of every joint in a collection of MJCF files with ours through the same file.

The other joints are locked in the posture of the first keyframe, contacts and ranges are off in
both. The control is a random sum of sines of 10 to 50 % of its range (or of the torque of the
weight) for 1 s. A joint that is read must agree within 2 mrad (0.2 mm) or 0.1 % of its travel.

usage examples:
  robot_files.py mujoco_menagerie
  robot_files.py mujoco_menagerie --seed 7 --json joints.json
"""
import copy
import json
from pathlib import Path
import sys
import time

import mujoco
import numpy as np
from script import run_script

from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.robot.compiled_model import moved_by
from gearbox_monitor.simulators.mjcf_file import compiled_file, drive_in, model_of, read_file
from gearbox_monitor.simulators.user_simulator import joint_readings, SERVO

SECONDS, SINES = 1.0, 3
LOCKED = 1e9            # kg m^2 of armature: what the other joints do in a second is nothing
TOLERANCE = {'hinge': 2e-3, 'slide': 2e-4}
OF_TRAVEL = 1e-3


def locked(m, dof):
    """Return a copy of `m` in which nothing but the degree of freedom `dof` moves."""
    alone = copy.copy(m)
    flags = mujoco.mjtDisableBit
    alone.opt.disableflags |= int(flags.mjDSBL_CONTACT) | int(flags.mjDSBL_LIMIT)
    others = np.arange(m.nv) != dof
    alone.dof_armature[others] = LOCKED
    # What resists there costs the solver its accuracy.
    alone.dof_frictionloss[others] = alone.dof_damping[others] = 0.0
    alone.opt.tolerance = 0.0
    return alone


def control_of(drive, reading, m, random, t, start):
    """Return the control [N] of a joint, or the torque on it where it has no actuator."""
    waves = sum(np.sin(2.0 * np.pi * random.uniform(0.5, 4.0) * t + random.uniform(-3.0, 3.0))
                for _ in range(SINES)) / SINES
    share = random.uniform(0.1, 0.5)
    weight = reading.values.get('weight', 0.0) or 10.0 * (
        reading.values.get('inertia', 0.0) + reading.values.get('armature', 0.0))
    if drive.actuator is None:
        return share * weight * waves
    i = m.actuator_ctrladr[drive.actuator.index]
    low, high = m.actuator_ctrlrange[i] if m.actuator_ctrllimited[i] else (-np.inf, np.inf)
    if reading.control == SERVO:
        half = min((high - low) / 2.0, 1.0)
        return np.clip(start, low + half, high - half) + share * half * waves
    gear = abs(reading.values.get('gear', 1.0) * reading.values.get('gain', 1.0)) or 1.0
    half = (high - low) / 2.0 if np.isfinite(high - low) else weight / gear
    return share * half * waves


def theirs(m, state, drive, u):
    """Return the positions [N] of a joint in MuJoCo."""
    dof, address = int(m.jnt_dofadr[drive.motor.index]), int(m.jnt_qposadr[drive.motor.index])
    alone, data = locked(m, dof), mujoco.MjData(m)
    data.qpos[:] = state
    moved, kinds = moved_by(m, drive.motor.index), mujoco.mjtEq
    for i in range(m.neq):     # a loop that the posture leaves open pulls at what moves it whole
        if kinds(m.eq_type[i]) in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            data.eq_active[i] = moved[m.eq_obj1id[i]] != moved[m.eq_obj2id[i]]
    q = np.empty(len(u))
    for k, value in enumerate(u):
        q[k] = data.qpos[address]
        if drive.actuator is None:
            data.qfrc_applied[dof] = value
        else:
            data.ctrl[m.actuator_ctrladr[drive.actuator.index]] = value
        mujoco.mj_step(alone, data)
    return q


def ours(drive, u, start):
    """Return the positions [N] of a joint by the model that is read from its file."""
    model = model_of(drive)
    scale = 1.0 if model.controller is not None else model.gear_ratio * model.torque_constant
    plant = Plant(model, state=np.array([start, start]))
    return plant.run(scale * u, drive.timestep).x[:, 0]


def joints_of(path, seed):
    """Return a record of each joint in a file: refused, or how far its runs are apart."""
    file = compiled_file(read_file(path), path)
    m = file.compiled
    keyframe = (mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_KEY, 0) or None) if m.nkey else None
    state = m.key_qpos[0] if keyframe else m.qpos0
    random, rows = np.random.default_rng(seed), []
    for reading in joint_readings(file, keyframe):
        row = {'file': str(path), 'joint': reading.name, 'kind': reading.kind,
               'refused': list(reading.refusals)}
        rows.append(row)
        if not reading.read:
            continue
        drive = drive_in(file, (reading.name, None), keyframe)
        start = float(state[m.jnt_qposadr[drive.motor.index]])
        t = np.arange(round(SECONDS / drive.timestep)) * drive.timestep
        u = control_of(drive, reading, m, random, t, start)
        a, b = theirs(m, state, drive, u), ours(drive, u, start)
        travel = float(np.ptp(a))
        row.update(apart=float(np.abs(a - b).max()), travel=travel, control=reading.control,
                   agrees=bool(np.abs(a - b).max() <= max(TOLERANCE[reading.kind],
                                                          OF_TRAVEL * travel)))
    return rows


def add_arguments(parser):
    parser.add_argument('folder', metavar='FOLDER', help='of MJCF files, below it as well')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json', metavar='FILE', help='write a record of each joint')


def run(args):
    """Compare all joints and return the exit code: 1 if one that is read does not agree."""
    rows, files, slow = [], 0, 0.0
    for path in sorted(Path(args.folder).rglob('*.xml')):
        began = time.process_time()
        try:
            if not mujoco_file(path):
                continue
            part = joints_of(path, args.seed)
        except InputError as error:
            print(f'{path}: {error.args[0]}'[:160], flush=True)
            continue
        files += 1
        slow = max(slow, time.process_time() - began)
        rows += part
        bad = [r for r in part if not r.get('agrees', True)]
        apart = ''.join(f'; {r["joint"]} {1e3 * r["apart"]:.2g}e-3 apart' for r in bad)
        print(f'{path}: {sum("apart" in r for r in part)} of {len(part)} read{apart}', flush=True)
    if not files:
        raise InputError(f'{args.folder}: no MJCF file, expected a folder of robots')
    compared = [r for r in rows if 'apart' in r]
    wrong = [r for r in compared if not r['agrees']]
    print(f'{files} files, {len(rows)} joints: {len(compared)} read, {len(wrong)} of them apart; '
          f'largest {1e3 * max((r["apart"] for r in compared), default=0.0):.2g}e-3; '
          f'CPU {slow:.1f} s at most for the runs of a file')
    if args.json:
        Path(args.json).write_text(json.dumps(rows, indent=1) + '\n', encoding='utf-8')
    return 1 if wrong else 0


def mujoco_file(path):
    """Return whether a file is MJCF with joints of its own, no scene around another file."""
    text = path.read_text(encoding='utf-8', errors='replace')
    return '<mujoco' in text and '<joint' in text and '<worldbody' in text


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
