# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
CPU time against the number of things: windows of a fit.

Each function gives a row's function of a number, on inputs made once; see scale.py.
"""
from pathlib import Path
import time

import numpy as np
from tqdm import tqdm

from gearbox_monitor.diagnosis.joint.shooting import N_MEMORY, shooting_windows, Simulator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.recordings.examples import NOISE
from gearbox_monitor.signals.uniform import UniformRecording

DT = 1e-3  # s
SECONDS = {'windows': 0.5}  # length of one
RECORDED = 20.0  # s that windows are cut from
# Windows: so many that a call by itself does not show.
NUMBERS = {'windows': (512, 1024, 2048, 4096)}


def windows(folder, most):
    """Return a function that runs the model freely over `n` windows, as a diagnosis does."""
    model, t = DriveModel(), DT * np.arange(round(RECORDED / DT))
    drive = simulate(model, Excitation().torque(t), DT, NOISE, 0)
    recording = UniformRecording(t, drive.u, drive.y, DT)
    simulator, parts = Simulator(recording, model), shooting_windows(recording, SECONDS['windows'])
    which = np.arange(most) % len(parts)

    def run(n):
        taken = parts.take(which[:n])
        simulator.run(taken, model, drive.x[taken.begin], np.zeros((n, N_MEMORY)),
                      np.zeros((len(t), 3)))
    return run


AXES = {'windows': windows}


def cpu_times(folder, numbers, rounds):
    """
    Return {axis: {number: CPU s of each round}}; the rounds of all are interleaved.

    folder: an empty one, for files; numbers: {axis: numbers}.
    """
    made = {}
    for axis, many in numbers.items():
        (Path(folder) / axis).mkdir()
        made[axis] = AXES[axis](Path(folder) / axis, max(many))
        made[axis](min(many))  # compiles
    times = {axis: {n: [] for n in many} for axis, many in numbers.items()}
    for _ in tqdm(range(rounds), 'numbers', disable=None, leave=False):
        for axis, many in numbers.items():
            for n in many:
                begin = time.process_time()
                made[axis](n)
                times[axis][n].append(time.process_time() - begin)
    return times
