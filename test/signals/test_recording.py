# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The recording that all commands read from: what it holds and what is made from it."""
import numpy as np
import pytest

from gearbox_monitor.diagnosis.robot.robot_log import CURRENT, raw_log, SETPOINT
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.recording import ARM, drive_samples, JointSignals, MOTOR, Recording

STAMPS = np.arange(5) * 10_000_000 + 7
ONES = np.ones(5)


def test_signals_cannot_be_changed_and_must_be_as_long_as_the_stamps():
    joint = JointSignals(STAMPS, position=ONES)
    with pytest.raises(ValueError, match='read-only'):
        joint.position[0] = 2.0
    assert joint.has('position') and not joint.has('effort')
    with pytest.raises(InputError, match='effort: shape'):
        JointSignals(STAMPS, position=ONES, effort=ONES[:4])
    with pytest.raises(InputError, match='effort_is'):
        JointSignals(STAMPS, effort_is='torques')


def test_a_drive_is_referred_to_the_arm_side():
    model = DriveModel(gear_ratio=-50.0, torque_constant=0.2)
    recording = Recording('run', {
        'm': JointSignals(STAMPS, position=100 * ONES, effort=ONES, side=MOTOR),
        'a': JointSignals(STAMPS, position=-2 * ONES, effort=3 * ONES, side=ARM),
        'late': JointSignals(STAMPS + 1)})
    samples = drive_samples(recording, model)
    np.testing.assert_array_equal(samples.stamp_ns, STAMPS)
    np.testing.assert_allclose(samples.y, [[-2.0, -2.0]] * 5)
    np.testing.assert_allclose(samples.u, [[-10.0, 3.0]] * 5)
    with pytest.raises(InputError, match="joint 'late': other stamps"):
        recording.on_one_clock(['m', 'late'])


def test_a_robot_gives_the_columns_of_its_joints_in_the_order_of_the_model():
    recording = Recording('run', {
        f'left_{k}': JointSignals(STAMPS, position=k * ONES, setpoint=-k * ONES,
                                  effort=10 * k * ONES) for k in (1, 2, 3)}, ['a note'])
    names = {'elbow': 'left_3', 'wrist': 'left_1'}
    log = raw_log(recording, names, CURRENT, {'elbow': 2.0, 'wrist': 0.5})
    assert list(log.position) == ['elbow', 'wrist'] and [*map(str, log.notes)] == ['a note']
    assert log.input['elbow'][0] == 60.0 and log.input['wrist'][0] == 5.0
    assert log.t[0] == 0.0 and log.t[1] == pytest.approx(0.01)
    assert raw_log(recording, names, SETPOINT).input['elbow'][0] == -3.0
