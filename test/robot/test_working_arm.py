# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The working arm: it repeats its program at any rate, and one gap grows."""
import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import GapGrowth, program, WorkingArm

FILE = str(config_path('arm6.urdf'))
ROBOT = load_robot(FILE)


def test_it_repeats_its_program():
    for rate in (250, 1000):
        dt = 1.0 / rate
        period = len(program(dt))
        arm = WorkingArm(ROBOT, dt, seed=1)
        run = arm.run(3 * period)
        assert run.true.arm.shape == (3 * period, 6)
        second, third = (run.true.arm[k * period:(k + 1) * period] for k in (1, 2))
        assert np.abs(third - second).max() < 1e-3 < 0.5 < np.ptp(second, axis=0).min()
        # Light links on stiff joints do not swing by themselves, however long a sample is.
        assert np.abs(run.true.tau_k).max() < 200.0
        noise = run.motor - run.true.motor
        assert np.std(noise) == pytest.approx(arm_plant.ENCODER, rel=0.05)


def test_only_the_gap_of_the_faulty_joint_grows():
    def twist(growth):
        arm = WorkingArm(ROBOT, 1e-3, 1, growth)
        arm.run(100)
        return [arm.run(100) for _ in range(20)][-1]

    healthy, faulty = twist(GapGrowth()), twist(GapGrowth(joint=3, rate=2.0, start=0.1))
    gaps = [abs(run.true.motor - run.true.arm) - abs(run.true.tau_k) / [
        drive.transmission.stiffness for drive in arm_plant.nominal_drives(ROBOT)]
        for run in (healthy, faulty)]
    half = np.array([drive.transmission.half_gap for drive in arm_plant.nominal_drives(ROBOT)])
    widths = [(gap * (run.true.tau_k != 0.0)).max(axis=0) / half
              for gap, run in zip(gaps, (healthy, faulty))]
    loaded = (healthy.true.tau_k != 0.0).any(axis=0) & (faulty.true.tau_k != 0.0).any(axis=0)
    assert loaded[[0, 3]].all()
    expected = np.where(np.arange(6) == 3, 1.0 + 2.0 * 1.9, 1.0)
    np.testing.assert_allclose(widths[0][loaded], 1.0)
    np.testing.assert_allclose(widths[1][loaded], expected[loaded])


@pytest.mark.system
def test_a_growing_gap_is_measured_although_the_filter_expects_another():
    """By 60 % of its width in 30 s: found and followed; the other joint stays healthy."""
    arm = WorkingArm(ROBOT, 1e-3, 1, GapGrowth(joint=0, rate=0.02, start=30.0))
    period = len(program(1e-3))
    monitors = [Monitor(arm.drives[joint], {
        **arm_plant.parameters_of(joint), 'robot_description': FILE,
        'drift_window': period * 1e-3}, robot=ROBOT) for joint in (0, 1)]
    for _ in range(60):
        run = arm.run(1000)
        stamps = 10 ** 18 + np.round(run.true.t * 1e9).astype(np.int64)
        for joint, monitor in enumerate(monitors):
            monitor.run(Samples(
                stamps, np.column_stack([run.true.u[:, joint], np.full(1000, np.nan)]),
                np.column_stack([run.motor[:, joint], run.arm[:, joint]]), run.arm))
    first, other = monitors
    window, change = first.windows[-1], first.health.alerts['gap']
    # On average over a window the gap was that of its middle.
    middle = 1e-9 * (window.stamp_ns - 10 ** 18) - 0.5e-3 * period
    grown = 0.02 * (middle - 30.0)
    # The filter draws the twist towards the gap that it expects.
    assert 0.93 < window.gap / (4e-4 * (1.0 + grown)) < 1.01
    assert 0.5 * grown < change.growth < 1.1 * grown  # of the windows since it was found
    assert set(first.health.alerts) == {'gap'}
    assert first.outcomes['prediction error'].level > Level.OK
    assert not other.health.alerts
    assert all(outcome.level == Level.OK for outcome in other.outcomes.values())
