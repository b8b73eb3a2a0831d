# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Faults of the simulated drive: each does what it says, and nothing else changes."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import EncoderFault, Excitation, Faults, FaultyPlant
from gearbox_monitor.plant.simulate import Noise, Plant

DT, N, START = 1e-3, 2000, 0.7
AT = 700
MODEL = DriveModel()
NOISE = Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.004))
U = Excitation().torque(DT * np.arange(N))
HEALTHY = Plant(MODEL, NOISE, 5).run(U, DT)


def run(faults, cuts=()):
    """Return (y, x, tau_k) of the run with `faults`, cut into calls at the samples `cuts`."""
    plant = FaultyPlant(MODEL, NOISE, 5, faults)
    ends = [0, *cuts, N]
    parts = [plant.run(U[a:b], DT, a * DT) for a, b in zip(ends, ends[1:])]
    assert np.array_equal(np.concatenate([p.u for p in parts]), U)
    return tuple(np.concatenate([getattr(p, n) for p in parts]) for n in ('y', 'x', 'tau_k'))


def with_motor(**values):
    return Faults(START, motor=EncoderFault(**values))


def test_no_fault_is_the_plant():
    y, x, tau_k = run(Faults(), cuts=(3, 1000))
    assert np.array_equal(y, HEALTHY.y)
    assert np.array_equal(x, HEALTHY.x)
    assert np.array_equal(tau_k, HEALTHY.tau_k)


ENCODER_FAULTS = [
    ({'frozen': True}, lambda x, y: np.full(N - AT, y[AT - 1])),
    ({'lost': True}, lambda x, y: np.full(N - AT, np.nan)),
    ({'delay': 0.005}, lambda x, y: y[AT - 5:N - 5]),
    ({'scale': 1.01}, lambda x, y: (1.01 * x + (y - x))[AT:]),
    ({'noise': 3.0}, lambda x, y: (x + 3.0 * (y - x))[AT:]),
]


def test_encoder_fault():
    for fault, expected in ENCODER_FAULTS:
        for joint in (0, 1):
            name = ('motor', 'arm')[joint]
            y, x, _ = run(Faults(START, **{name: EncoderFault(**fault)}))
            assert np.array_equal(x, HEALTHY.x)
            assert np.array_equal(y[:, 1 - joint], HEALTHY.y[:, 1 - joint])
            assert np.array_equal(y[:AT], HEALTHY.y[:AT])
            np.testing.assert_allclose(
                y[AT:, joint], expected(x[:, joint], HEALTHY.y[:, joint]), rtol=0, atol=1e-12)


def test_outliers_have_the_stated_rate_and_size():
    y, _, _ = run(with_motor(outlier_rate=0.1, outlier_size=0.3))
    extra = y[:, 0] - HEALTHY.y[:, 0]
    assert not extra[:AT].any()
    hit = extra != 0
    np.testing.assert_allclose(np.abs(extra[hit]), 0.3, atol=1e-12)
    assert 0.07 < hit[AT:].mean() < 0.13
    assert 0.35 < (extra[hit] > 0).mean() < 0.65


def test_a_fault_ends():
    for fault in ({'frozen': True}, {'delay': 0.01}, {'noise': 2.0}):
        y, _, _ = run(replace(with_motor(**fault), duration=0.2))
        assert np.array_equal(y[900:], HEALTHY.y[900:])
        assert not np.array_equal(y[:900], HEALTHY.y[:900])


def test_drive_fault_changes_the_motion_from_its_start_on():
    for name in ('viscous_friction', 'coulomb_friction', 'torque'):
        _, x, _ = run(Faults(START, **{name: 1.3}))
        assert np.array_equal(x[:AT + 1], HEALTHY.x[:AT + 1])
        assert np.abs(x - HEALTHY.x)[AT + 1:].max() > 1e-3


def test_torque_over_twist_follows_stiffness_and_gap():
    faults = Faults(START, stiffness=0.8, gap=1.5)
    _, x, tau_k = run(faults)
    twist = x[:, 0] - x[:, 1]

    def torque(part, stiffness, half_gap):
        return stiffness * np.sign(part) * np.maximum(np.abs(part) - half_gap, 0.0)
    shape = MODEL.transmission
    np.testing.assert_allclose(
        tau_k[:AT], torque(twist[:AT], shape.stiffness, shape.half_gap), atol=1e-12)
    np.testing.assert_allclose(
        tau_k[AT:], torque(twist[AT:], 0.8 * shape.stiffness, 1.5 * shape.half_gap), atol=1e-12)


def test_slow_growth_follows_its_ramp_and_stays():
    faults = Faults(gap_growth_rate=0.5, gap_growth_start=0.5, gap_growth_max=0.4)
    _, x, tau_k = run(faults)
    twist, shape = np.abs(x[:, 0] - x[:, 1]), MODEL.transmission
    loaded = tau_k != 0
    half_gap = (twist - np.abs(tau_k) / shape.stiffness)[loaded] / shape.half_gap
    t = (DT * np.arange(N))[loaded]
    ramp = 1.0 + np.clip(0.5 * (t - 0.5), 0.0, 0.4)
    assert np.abs(half_gap - ramp).max() < 0.5 * 0.01 + 1e-9  # held for 10 ms
    assert half_gap[t > 1.4] == pytest.approx(1.4)


def test_the_same_bits_however_it_is_cut():
    faults = Faults(
        0.4003, 0.9, EncoderFault(delay=0.004, noise=1.5, outlier_rate=0.05, outlier_size=0.1),
        EncoderFault(frozen=True, outlier_rate=0.02, outlier_size=1.0), torque=0.9,
        viscous_friction=1.2, coulomb_friction=2.0, stiffness=0.9, gap=1.1,
        gap_growth_rate=0.05, gap_growth_start=0.3, gap_growth_max=0.03)
    whole = run(faults)
    assert not np.array_equal(whole[0], HEALTHY.y)
    for cuts in ((1, 2, 3, 399, 403), range(7, N, 7), range(1, N), (401, 1299, 1301)):
        for a, b in zip(whole, run(faults, cuts)):
            assert np.array_equal(a, b)


def test_switched_at_run_time():
    plant = FaultyPlant(MODEL, NOISE, 5)
    first = plant.run(U[:500], DT)
    plant.faults = Faults(arm=EncoderFault(frozen=True))
    second = plant.run(U[500:1000], DT, 0.5)
    plant.faults = Faults()
    third = plant.run(U[1000:], DT, 1.0)
    assert (second.y[:, 1] == first.y[-1, 1]).all()
    assert np.array_equal(second.y[:, 0], HEALTHY.y[500:1000, 0])
    assert np.array_equal(third.y, HEALTHY.y[1000:])


@pytest.mark.ros
def test_node_takes_a_fault_while_it_runs(tmp_path, monkeypatch):
    pytest.importorskip('rclpy')
    from harness import Graph
    from rclpy.qos import QoSProfile
    from sensor_msgs.msg import JointState
    graph, received = Graph(tmp_path, monkeypatch), []

    def arm(n=100):
        return np.array([m.position[1] for m in received[-n:]])
    try:
        graph.node.create_subscription(
            JointState, 'joint_states', received.append, QoSProfile(depth=10000))
        graph.start('plant_node', seed=4)
        graph.until(lambda: len(received) > 300, 'samples')
        assert np.ptp(arm()) > 0.01
        assert graph.set('plant', fault_frozen='arm')[0].successful
        graph.until(lambda: np.ptp(arm()) == 0.0, 'a frozen arm')
        assert np.ptp([m.position[0] for m in received[-100:]]) > 0.01
        refused, = graph.set('plant', fault_scale=[1.0])
        assert not refused.successful and '2 numbers' in refused.reason
        assert graph.set('plant', fault_frozen='none')[0].successful
        graph.until(lambda: np.ptp(arm()) > 0.01, 'an arm that moves again')
    finally:
        graph.close()
