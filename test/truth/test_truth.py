# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Results of other programs, stored with the scripts that made them.

filters.csv: EKF and UKF of Hipparchus (Java). dynamics.json: arms by pinocchio (C++).
"""
import json
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.estimation.filter_kind import Belief, Reading, record_size, Scratch, updated
from gearbox_monitor.estimation.filters import ekf, srukf, ukf
from gearbox_monitor.estimation.process_model import EIGENVALUE, layout_of, pack
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.kernels.kernel import Entry
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, substeps
from gearbox_monitor.robot.chain import chain_of
from gearbox_monitor.robot.description import parse
from gearbox_monitor.robot.dynamics import arrays_of, coupled_inertia, move, torque_on

HERE = Path(__file__).parent
DT = 1e-3
MODEL = DriveModel().with_(
    motor_inertia=0.0065, arm_inertia=0.023, damping=0.02, viscous_friction=0.1,
    coulomb_friction=0.27, friction_sharpness=8.0, position_gain=0.01)
PARAMETERS = EstimatorParameters.from_mapping({
    'arm_load': 'none', 'r_std_motor': 0.004, 'r_std_arm': 0.006,
    'q_std_motor_position': 1e-2, 'q_std_arm_position': 1e-2, 'q_std_motor_speed': 0.1 ** 0.5,
    'q_std_arm_speed': 0.2 ** 0.5, 'q_std_tau_k': 10.0,
    'ukf_alpha': 0.7, 'ukf_beta': 2.0, 'ukf_kappa': 1.0})


@pytest.mark.parametrize('module, column, close', [
    (ekf, 3, 1e-12), (ukf, 13, 1e-9), (srukf, 13, 1e-9)])
def test_estimates_are_those_of_hipparchus(module, column, close):
    """Of a drive with friction that turns about: states in deviations, deviations relative."""
    rows = np.loadtxt(HERE / 'filters.csv', delimiter=',')
    p, kind, n, step = pack(MODEL, PARAMETERS), module.FILTER, 5, Entry(module.step)
    assert substeps(DT, p[EIGENVALUE]) == 1
    belief = Belief(np.zeros(n), (0.25 * np.eye(n)).ravel(), np.zeros(kind.memory_size(n)))
    scratch = Scratch(np.zeros((max(kind.n_vectors, 1), n)),
                      np.zeros((max(kind.n_matrices, 5), n * n)))
    record = np.zeros(record_size(n))
    for u, motor, arm, *theirs in rows:
        assert step(layout_of(p, n), belief, Reading(DT, u, 0.0, motor, arm), p, scratch, record)
        (z, P), state, deviation = updated(record, n), *np.reshape(
            theirs[column - 3:column + 7], (2, n))
        np.testing.assert_allclose(z / deviation, state / deviation, rtol=0.0, atol=close)
        np.testing.assert_allclose(np.sqrt(np.diag(P)), deviation, rtol=close)


@pytest.mark.parametrize('name', ['arm', 'slide'])
def test_torques_of_an_arm_are_those_of_pinocchio(name):
    """By Newton-Euler, and by the balance of momentum that the diagnosis uses."""
    text = config_path('arm6.urdf').read_text()
    if name == 'slide':
        text = text.replace('name="joint3" type="revolute"', 'name="joint3" type="prismatic"')
    robot = parse(text, 'arm')
    arrays, chain = arrays_of(robot), chain_of(robot)
    truth = json.loads((HERE / 'dynamics.json').read_text())[name]
    for q, v, a, torque, gravity, inertia in zip(*(map(np.array, truth[k]) for k in (
            'q', 'v', 'a', 'torque', 'gravity', 'inertia'))):
        move(arrays, np.array([q, v, a]))
        np.testing.assert_allclose([torque_on(arrays, i)[0] for i in range(6)], torque,
                                   rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose([[coupled_inertia(arrays, i, j) for j in range(6)]
                                    for i in range(6)], inertia, rtol=1e-9, atol=1e-12)
        weight, momentum = np.zeros((2, 6))
        for r in chain.regressors(q[None], v[None]):
            weight[r.joint] += r.g[0] @ chain.theta[r.link]
            momentum[r.joint] += r.p[0] @ chain.theta[r.link]
        np.testing.assert_allclose(momentum, inertia @ v, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(weight, gravity, rtol=1e-9, atol=1e-9)
