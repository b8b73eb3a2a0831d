# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The recording that all commands read from: what it holds and what is made from it."""
import numpy as np
import pytest

from gearbox_monitor.diagnosis.robot.robot_log import CURRENT, raw_log, SETPOINT
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals import stamps
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


def test_the_longest_part_without_a_dropout_begins_at_zero():
    """On an even grid, positions between readings, the torque as it was held before."""
    random = np.random.default_rng(3)
    for jitter in (0.0, 2e-3):
        t = 5.0 + 0.01 * np.append(np.arange(100), np.arange(200, 500)) + jitter * random.random(
            400)
        clock = stamps.clock(np.rint(1e9 * t).astype(np.int64))
        part = stamps.segment(clock, np.floor(t), np.column_stack([3.0 * t, -t]))
        # Two stamps after a dropout confirm the clock.
        assert part.t[0] == 0.0 and part.begin == pytest.approx(2.02, abs=2 * jitter + 1e-9)
        assert part.dt == pytest.approx(0.01, rel=1e-3)
        assert len(part.t) == pytest.approx(298, abs=1)
        absolute = t[0] + part.begin + part.t
        np.testing.assert_allclose(part.y, np.column_stack([3.0 * absolute, -absolute]), atol=1e-6)
        late = np.flatnonzero(part.u != np.floor(absolute))
        assert np.abs(absolute[late] - np.rint(absolute[late])).max(initial=0.0) < 0.012
        for side in (0, 1):  # of an encoder that is not there the other one stands in
            y = np.full((len(t), 2), np.nan)
            y[:, side] = 3.0 * t
            one = stamps.segment(clock, t, y)
            assert one.channels == (side,)
            np.testing.assert_array_equal(one.y, part.y[:, [0, 0]])
