# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo's law of friction is the one that docs/mujoco.md states, at each integrator."""
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.plant.transmission import dead_zone

mujoco = pytest.importorskip('mujoco')
PAIR = (Path(__file__).parent / 'pair.xml').read_text(encoding='utf-8')
M = np.array([0.006442, 0.023454])
K, B, D, CV, CC, KR = 25.0, 0.1, 0.01, 0.1, 0.27, 0.01


def torque(k, h):
    return 6.0 * np.cos(5.7 * k * h) + 2.0 * np.cos(14.5 * k * h)


def accelerating(x, u, h):
    """Return the torques on motor and arm; friction takes a share of all others, and of M b v."""
    twist = D * (x[2] - x[3]) + K * dead_zone(x[0] - x[1], B)
    other = u - twist - CV * x[2] - KR * x[0]
    d, b = 0.9, 2.0 / (0.95 * max(0.02, 2.0 * h))
    return np.array([other - np.clip(d * (other + M[0] * b * x[2]), -CC, CC), twist])


def advanced(x, u, h, integrator):
    """Return the state after a step of MuJoCo's integrator."""
    if integrator == 'RK4':
        def slope(x):
            return np.concatenate([x[2:], accelerating(x, u, h) / M])
        a = slope(x)
        b = slope(x + 0.5 * h * a)
        c = slope(x + 0.5 * h * b)
        return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(x + h * c))
    damping = np.array([CV, 0.0]) + (D if integrator == 'implicitfast' else 0.0)
    speed = x[2:] + h * accelerating(x, u, h) / (M + h * damping)
    return np.concatenate([x[:2] + h * speed, speed])


def test_closed_form():
    for integrator in ('Euler', 'implicitfast', 'RK4'):
        h = 2e-3
        text = PAIR.replace('timestep="0.0001" integrator="RK4"',
                            f'timestep="{h}" integrator="{integrator}" gravity="0 0 0"')
        m = mujoco.MjModel.from_xml_string(text)
        d, x, worst = mujoco.MjData(m), np.zeros(4), 0.0
        for k in range(round(1.0 / h)):
            worst = max(worst, float(np.abs(d.qpos - x[:2]).max()))
            d.ctrl[0] = torque(k, h)
            mujoco.mj_step(m, d)
            x = advanced(x, torque(k, h), h, integrator)
        assert np.abs(x[:2]).max() > 0.5 and worst < 1e-5
