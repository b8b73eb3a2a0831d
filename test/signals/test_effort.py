# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What an effort reads like, on drives of which the answer is known."""
import numpy as np
import pytest

from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals import wiring
from gearbox_monitor.signals.finding import LIMITS, OK, WARN
from gearbox_monitor.signals.uniform import SmoothedMotion, UniformRecording

MODEL = DriveModel()
DT, WEIGHT = 1e-3, 2.0  # s, N m
T = DT * np.arange(12_000)
SIGMA = np.full(2, 1e-3)


def motion(read, scale=1.0, **values):
    """Return the smoothed motion of a drive with a weight, its effort as `read` by a driver."""
    drive = MODEL.with_(effects=[{'id': 'gravity', 'G': WEIGHT}], **values)
    run = simulate(drive, scale * Excitation().torque(T), DT,
                   Noise((0.0, 0.0, 0.1, 0.1), tuple(SIGMA)))
    return SmoothedMotion(UniformRecording(T, read(run), run.y, DT), SIGMA)


READ = [
    (lambda run: run.u, wiring.TORQUE),
    (lambda run: run.u / 0.06, wiring.CURRENT),
    (lambda run: run.u - WEIGHT * np.sin(run.y[:, 1]), wiring.COMPENSATED)]


def test_each_is_told_from_the_others():
    for read, name in READ:
        for values in ({}, {'motor_inertia': 1.1 * MODEL.motor_inertia,
                            'coulomb_friction': 1.3 * MODEL.coulomb_friction}):
            scores, factor = wiring.likelihoods(motion(read, **values), MODEL)
            assert all(scores[name] > score + LIMITS.effort_ratio
                       for other, score in scores.items() if other != name)
            if name == wiring.CURRENT:
                assert factor == pytest.approx(1.0 / 0.06, rel=0.3)


def test_the_statement_is_compared_and_little_motion_tells_nothing():
    smooth = motion(lambda run: run.u)
    assert wiring.effort(smooth, MODEL, 'unknown').verdict() == OK
    wrong = wiring.effort(smooth, MODEL, wiring.COMPENSATED)
    assert wrong.verdict() == WARN and 'effort_is: torque' in wrong.advice
    assert wrong.values['effort_is'] == wiring.TORQUE and 'factor' not in wrong.values
    current = wiring.effort(motion(lambda run: run.u / 0.06), MODEL, 'unknown')
    assert current.values['factor'] == pytest.approx(1.0 / 0.06, rel=0.3)
    quiet = wiring.effort(motion(lambda run: run.u, 0.02), MODEL, wiring.TORQUE)
    assert 'undecided' in quiet.figure and quiet.verdict() == OK
    nothing = wiring.effort(motion(lambda run: 0.0 * run.u), MODEL, wiring.TORQUE)
    assert nothing.verdict() == OK and 'no torque' in nothing.figure
