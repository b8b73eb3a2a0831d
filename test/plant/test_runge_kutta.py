# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The Runge-Kutta step of the drive, of single runs and of lanes: the order of its error."""
import numpy as np
from scipy.integrate import solve_ivp

from gearbox_monitor.diagnosis.joint.shooting import N_MEMORY, ShootingWindows, Simulator
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.signals.uniform import UniformRecording

DT, SAMPLES, TORQUE = 0.02, 10, 1.5
START = np.array([0.3, 0.1, 1.0, -0.5])
COGGING = {'id': 'cogging', 'A': 0.4, 'N': 3, 'phi': 0.2}
SMOOTH = {'coulomb_friction': 0.0, 'position_gain': 0.0,
          'transmission': {'stiffness': 5.0, 'half_gap': 0.0}}


def exact(model, cogging):
    """Return the positions [SAMPLES, 2] (rad) by another method, from equation (1)."""
    m1, m2, d = model.motor_inertia, model.arm_inertia, model.damping

    def rates(t, x):
        elastic = model.transmission.stiffness * (x[0] - x[1]) + d * (x[2] - x[3])
        u = TORQUE + cogging * np.sin(COGGING['N'] * x[0] + COGGING['phi'])
        return (x[2], x[3], (u - elastic - model.viscous_friction * x[2]) / m1, elastic / m2)
    t = DT * np.arange(SAMPLES)
    return solve_ivp(rates, (0.0, t[-1]), START, 'DOP853', t, rtol=1e-12, atol=1e-13).y[:2].T


def test_half_the_step_leaves_a_sixteenth_of_the_error():
    for kind in ('dead_zone', 'play'):  # all lanes together, and each by itself
        for effects in ([], [COGGING]):
            model = model_from_dict({**SMOOTH, 'effects': effects}, 'test').with_(kind=kind)
            recording = UniformRecording(DT * np.arange(SAMPLES), np.full(SAMPLES, TORQUE),
                                         np.zeros((SAMPLES, 2)), DT)
            windows = ShootingWindows(np.zeros(1, int), SAMPLES, np.zeros(1, int))
            expected = exact(model, COGGING['A'] if effects else 0.0)
            errors = []
            for finer in (2, 4):
                y, _ = Simulator(recording, model, finer=finer).run(
                    windows, model, START[None], np.zeros((1, N_MEMORY)))
                errors.append(np.abs(y - expected).max())
            assert 1e-10 < errors[1] < 1e-4
            assert 12.0 < errors[0] / errors[1] < 20.0
