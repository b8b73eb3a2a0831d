# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Inverse dynamics against MuJoCo; the simulated arm against its own energy and inverse."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import ArmPlant
from gearbox_monitor.robot.description import parse
from gearbox_monitor.robot.dynamics import arrays_of, coupled_inertia, move, Payload, torque_on

ARM = load_robot(str(config_path('arm6.urdf')))


def moved(arrays, q, v, a):
    """Return (torque [n], inertia matrix [n, n]) of the motion."""
    move(arrays, np.array([q, v, a]))
    n = len(q)
    return (np.array([torque_on(arrays, i)[0] for i in range(n)]),
            np.array([[coupled_inertia(arrays, i, j) for j in range(n)] for i in range(n)]))


def test_torques_and_inertias_are_those_of_mujoco():
    """Of an arm, and of one with a sliding joint; MuJoCo reads the same file."""
    mujoco = pytest.importorskip('mujoco')
    text = config_path('arm6.urdf').read_text()
    rng = np.random.default_rng(3)
    for changed in (text, text.replace('name="joint3" type="revolute"',
                                       'name="joint3" type="prismatic"')):
        model = mujoco.MjModel.from_xml_string(changed)
        data = mujoco.MjData(model)
        arrays = arrays_of(parse(changed, 'arm'), gravity=tuple(model.opt.gravity))
        for _ in range(5):
            data.qpos, data.qvel, data.qacc = q, v, a = rng.normal(size=(3, 6))
            mujoco.mj_inverse(model, data)
            dense = np.zeros((6, 6))
            mujoco.mj_fullM(model, data, dense)
            torque, inertia = moved(arrays, q, v, a)
            passive = data.qfrc_passive + data.qfrc_constraint
            np.testing.assert_allclose(torque, data.qfrc_inverse + passive, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(inertia, dense, rtol=1e-9, atol=1e-12)


def test_the_deviation_is_the_spread_of_the_torque():
    """Over masses and inertias drawn within the tolerance, and over payloads."""
    rng = np.random.default_rng(5)
    q, v, a = rng.normal(size=(3, 6))
    stated = arrays_of(ARM, Payload(2.0, 0.5, (0.0, 0.0, 0.1), 'tool'), 0.2)
    move(stated, np.array([q, v, a]))
    torques = []
    for _ in range(1000):
        mass, inertia = 1.0 + 0.2 * rng.uniform(-1.0, 1.0, (2, len(ARM.mass)))
        drawn = arrays_of(replace(ARM, mass=ARM.mass * mass,
                                  inertia=ARM.inertia * inertia[:, None, None]),
                          Payload(2.0 + rng.uniform(-0.5, 0.5), 0.0, (0.0, 0.0, 0.1), 'tool'))
        torques.append(moved(drawn, q, v, a)[0])
    for joint, spread in enumerate(np.std(torques, axis=0)):
        torque, variance, _ = torque_on(stated, joint)
        assert np.sqrt(variance) == pytest.approx(spread, rel=0.1)
        assert torque == pytest.approx(np.mean(torques, axis=0)[joint], abs=0.15 * spread)
        move(stated, np.array([q, v, np.where(np.arange(6) == joint, 0.0, a)]))
        assert torque_on(stated, joint, a[joint])[1] == pytest.approx(variance)
        move(stated, np.array([q, v, a]))


def test_an_arm_without_friction_keeps_its_energy():
    """Motors held by no servo, no payload: springs, links and motors swing, and lose nothing."""
    drives = [drive.with_(coulomb_friction=0.0, viscous_friction=0.0, damping=0.0, half_gap=0.0)
              for drive in arm_plant.nominal_drives(ARM)]
    arrays = arrays_of(ARM)
    plant = ArmPlant(arrays, drives, arm_plant.MIDDLE, bandwidth=1e-6)
    dt, n = 5e-4, 2000
    run = plant.run(np.tile(arm_plant.MIDDLE, (n, 2, 1)) * [[1.0], [0.0]], np.zeros(n), dt)
    speeds = np.gradient(np.stack([run.motor, run.arm]), dt, axis=1)

    def energy(k):
        q, still = run.arm[k], np.zeros(6)
        _, inertia = moved(arrays, q, still, still)
        height = sum(m * arrays.bodies[b, 2] for b, m in enumerate(ARM.mass))
        springs = run.tau_k[k] ** 2 / [d.transmission.stiffness for d in drives]
        return (speeds[1, k] @ inertia @ speeds[1, k] / 2.0 + 9.80665 * height
                + springs.sum() / 2.0 + sum(
                    d.motor_inertia * speeds[0, k, i] ** 2 for i, d in enumerate(drives)) / 2.0)
    energies = np.array([energy(k) for k in range(20, n - 5, 100)])
    kinetic = max(np.abs(speeds[1]).max(), 0.1)
    assert kinetic > 1.0  # it falls
    assert np.ptp(energies) < 0.5  # of hundreds of J that weight and speed exchange
