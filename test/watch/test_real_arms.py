# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Real arms, which are no part of this project: no alarm without a load, and its mass with one."""
import csv
from itertools import permutations

import numpy as np
import pytest
from six_axis_arm import controller_constants, DATA, samples, UNLOADED

from gearbox_monitor.library.robot import watch_robot

pytestmark = [pytest.mark.system, pytest.mark.skipif(
    not DATA.is_dir(), reason='recordings of others are not here')]
JOINTS = ('shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3')
LOADED, LOAD = 'ur-20_01_31-load', 2.8     # kg
TIMES = 3   # that each recording is repeated: all of them are shorter than what is learnt from


def logs(folder, names):
    """Return logs of the six-axis arm with torques, each TIMES times."""
    paths = []
    for name in names:
        x = samples(name)
        x = x[np.isfinite(x).all(axis=1)]
        path = folder / f'{name}.csv'
        with open(path, 'w', encoding='utf-8') as file:
            writer = csv.writer(file)
            writer.writerow(['t', *(f'{quantity}_{joint}_joint' for quantity in (
                'position', 'effort') for joint in JOINTS)])
            writer.writerows(np.column_stack([
                x[:, 0] - x[0, 0], x[:, 1:7], controller_constants() * x[:, 13:19]]).tolist())
        paths += TIMES * [path]
    return paths


@pytest.mark.parametrize('order', [*permutations(range(3))])
def test_an_arm_with_torque_sensors_raises_nothing(order):
    folder = DATA / 'lwr4'
    watch = watch_robot([folder / f'measurements_{k + 1}.csv.gz' for k in order
                         for _ in range(2 * TIMES)], folder / 'kuka_lwr4.urdf')
    assert watch.phase == 'watch' and not watch.changes


@pytest.mark.parametrize('order', [*permutations(range(4))])
def test_an_arm_with_currents_raises_nothing_and_weighs_its_load(tmp_path, order):
    names = [(*UNLOADED, LOADED)[k] for k in order]
    watch = watch_robot(logs(tmp_path, names), DATA / 'ur10e/ur10e.urdf')
    assert watch.phase == 'watch' and not watch.changes
    if LOADED in (names[0], names[-1]):
        mass = LOAD if names[-1] == LOADED else -LOAD
        assert abs(watch.payloads[-1].mass - mass) < 0.15 * LOAD
