# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Motor and arm on two topics, or no arm; several gearboxes in one bag and one file."""
import json

from filter_choice import EACH_FILTER
import numpy as np
import pytest
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.estimation.sample_loop import E_INNOVATION_MOTOR, E_INNOVATION_STD_MOTOR
from gearbox_monitor.files.user_files import load_parameters
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import SETTINGS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, find_input, Joiner, WAIT
from gearbox_monitor.recordings.read import JOINT_STATE, open_bag
from gearbox_monitor.recordings.topics import joint_values, signal_values, SIGNALS
from gearbox_monitor.recordings.write import BagWriter

T0, MS = 1_700_000_000_000_000_000, 1_000_000


def joined(motor, arm, turns, tolerance=MS // 2):
    """Return (what comes out, Joiner) of two streams of stamps, taken in the order of `turns`."""
    joiner, due, queues = Joiner(tolerance), [], (list(motor), list(arm))
    take = joiner.motor, joiner.arm
    for side in turns:
        stamp = queues[side].pop(0)
        due += take[side](stamp, (side, stamp))
    return due, joiner


def test_pairs_do_not_depend_on_the_order_of_arrival():
    random = np.random.default_rng(4)
    stamps = T0 + MS * np.arange(1000)
    motor = stamps[random.random(1000) > 0.05].tolist()
    jitter = random.integers(-MS // 3, MS // 3, 1000)
    arm = (stamps + jitter)[random.random(1000) > 0.05].tolist()
    found = []
    for spread in (1, 30, 300):  # ms by which one may run ahead of the other
        arrival = [stamp + random.integers(0, spread * MS) for stamp in motor + arm]
        for part in (slice(len(motor)), slice(len(motor), None)):
            arrival[part] = sorted(arrival[part])  # a topic keeps its order
        sides = [0] * len(motor) + [1] * len(arm)
        due, joiner = joined(motor, arm, [sides[k] for k in np.argsort(arrival, kind='stable')])
        found.append(due)
    n = min(map(len, found))
    assert n > len(motor) - 2 and found[0][:n] == found[1][:n] == found[2][:n]
    assert [stamp for stamp, _, _ in found[0]] == motor[:len(found[0])]
    pairs = [(stamp, other[1]) for stamp, _, other in found[0] if other]
    assert all(abs(a - b) <= MS // 2 for a, b in pairs)
    # Whoever has a partner gets it.
    near = sum(any(abs(a - m) <= MS // 3 for a in arm) for m in motor)
    assert near - 1 <= len(pairs) <= near and joiner.unpaired == len(found[2]) - len(pairs)


def test_a_silent_arm_holds_nothing_back_for_long():
    stamps = list(range(T0, T0 + 3 * WAIT, MS))
    due, joiner = joined(stamps, [], [0] * len(stamps))
    assert [stamp for stamp, _, _ in due] == stamps[:len(due)]
    assert stamps[-1] - due[-1][0] == WAIT + MS and joiner.unpaired == len(due)
    assert not any(arm for _, _, arm in due)


def test_clock_that_is_set_back_pairs_on_at_once():
    first = [T0 + k * MS for k in range(10)]
    back = [T0 - 3600 * 1000 * MS + k * MS for k in range(10)]
    due, joiner = joined([*first, *back], [*first[:9], *back], [0, 1] * 9 + [0] + [0, 1] * 10)
    assert [stamp for stamp, _, arm in due if arm] == [*first[:9], *back]
    assert [stamp for stamp, _, arm in due if not arm] == [first[9]]
    # An arm message left over from before does not make the motor wait for its time to come.
    due, joiner = joined(back, [*first[:1], *back], [1, *[0, 1] * 10])
    assert [stamp for stamp, _, arm in due if arm] == back and joiner.dropped == 1


def test_zero_stamps_say_nothing_about_when():
    due, joiner = joined([0, T0], [0, T0], [0, 1, 1, 0])
    assert [(stamp, bool(arm)) for stamp, _, arm in due] == [(0, False), (T0, True)]
    assert (joiner.unpaired, joiner.dropped) == (1, 1)


@pytest.fixture
def two_in_one(tmp_path):
    """Return a bag of two estimators that take the same topic, and of a third with its own."""
    types = get_typestore(Stores.ROS2_JAZZY).types
    taken = {'/left/estimator': '/joint_states', '/right/estimator': '/joint_states',
             '/tool/estimator': '/tool/paired_joint_states'}
    with BagWriter(tmp_path / 'bag') as writer:
        for topic in ('/joint_states', '/tool/joint_states', '/tool/paired_joint_states'):
            writer.add_topic(topic, JOINT_STATE)
            for raw in encode_joint_states([T0], ['motor', 'arm'], [[0.0, 0.0]]):
                writer.write(topic, T0, raw)
        for node, topic in taken.items():
            content = {**Monitor(DriveModel()).snapshot(),
                       'topics': json.dumps({'joint_states': topic, 'innovations': '/errors'})}
            status = types['diagnostic_msgs/msg/DiagnosticStatus'](0, '', '', '', [
                types['diagnostic_msgs/msg/KeyValue'](*item) for item in content.items()])
            header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')
            writer.add_topic(f'{node}/snapshot', DIAGNOSTIC_ARRAY)
            writer.write_message(f'{node}/snapshot', T0,
                                 types[DIAGNOSTIC_ARRAY](header, [status]))
    with open_bag(tmp_path / 'bag') as reader:
        yield reader


def test_estimators_of_one_bag_are_told_apart(two_in_one):
    for name in ('/left/estimator', 'left/joint_states'):
        found = find_input(two_in_one, name)
        assert found.topic == '/joint_states' and found.snapshots == '/left/estimator/snapshot'
        assert found.name('innovations') == '/errors'
        assert found.name('transmission_state') == '/left/transmission_state'
    assert find_input(two_in_one, 'tool/joint_states').topic == '/tool/paired_joint_states'
    with pytest.raises(InputError, match='taken by /left/estimator, /right/estimator.* expected '
                                         'one; choose it with --topic /left/estimator'):
        find_input(two_in_one, '/joint_states')


def test_parameter_file_of_several_gearboxes(tmp_path):
    file = tmp_path / 'robot.yaml'
    file.write_text(json.dumps({
        '/left/estimator': {'ros__parameters': {'max_gap': 0.1, 'damping': 0.02}},
        '/right/estimator': {'ros__parameters': {'max_gap': 0.2, 'use_sim_time': True}},
        '/**/estimator': {'ros__parameters': {'max_gap': 0.3, 'arm_load': 'none'}},
        '/**': {'ros__parameters': {'max_gap': 0.4, 'low_space': 1}}}))
    for topic, expected in (('/left/estimator', {'max_gap': 0.1, 'damping': 0.02}),
                            ('right/joint_states', {'max_gap': 0.2})):
        assert load_parameters(file, 'estimator', SETTINGS, topic) == {
            'arm_load': 'none', **expected}
    with pytest.raises(InputError, match='blocks for estimator in /left, /right, expected'):
        load_parameters(file, 'estimator', SETTINGS, 'joint_states')


def test_model_values_change_with_a_restart_and_noise_without():
    monitor = Monitor(DriveModel(), {'arm_load': 'none', 'damping': 0.02})
    assert monitor.model.damping == 0.02
    for k in range(50):
        monitor.step(Sample(T0 + k * MS, (0.1, np.nan), (0.001 * k, 0.001 * k)))
    assert monitor.set_parameters({'q_std_tau_k': 9.0}) is False and monitor.stamp_ns > 0
    assert monitor.set_parameters({'motor_inertia': 0.01, 'q_std_tau_k': 8.0}) is True
    assert monitor.stamp_ns == 0 and monitor.estimator.drive.motor_inertia == 0.01
    assert monitor.estimator.drive.damping == 0.02 and monitor.parameters.q_std_tau_k == 8.0
    before = monitor.snapshot()
    with pytest.raises(InputError, match='motor_inertia'):
        monitor.set_parameters({'motor_inertia': -1.0})
    assert monitor.snapshot() == before


@pytest.mark.parametrize('name', EACH_FILTER)
def test_without_an_arm_encoder_the_torque_is_as_good(name):
    """Gravity acts on the arm, which nobody measures; what nobody knows is not published."""
    n, dt = 6000, 2 * MS
    load = DriveModel().with_(effects=[{'id': 'gravity', 'G': 1.0}])
    drive = simulate(load, Excitation().torque(np.arange(n) * dt * 1e-9), dt * 1e-9,
                     Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=3)
    given = Samples(T0 + np.arange(n) * dt, np.column_stack([drive.u, np.full(n, np.nan)]),
                    np.column_stack([drive.y[:, 0], np.full(n, np.nan)]))
    both = Samples(given.stamp_ns, given.u, drive.y)
    alone = Monitor(DriveModel(), {'filter': name, 'arm_joint': ''})
    estimates = alone.run(given)
    known = Monitor(DriveModel(), {'filter': name}).run(both)
    damping = 0.01 * (drive.x[1:, 2] - drive.x[1:, 3])  # part of what the gearbox transmits

    def error(tau_k, truth):
        return np.sqrt(((tau_k - truth)[1000:] ** 2).mean())
    found = error(estimates.tau_k, drive.tau_k[1:] + damping)
    assert found < 1.1 * error(known.tau_k, drive.tau_k[1:])
    within = np.abs(estimates.tau_k - drive.tau_k[1:] - damping) <= 2.0 * estimates.tau_k_std
    assert within[1000:].mean() > 0.9
    assert all(outcome.level == 0 for outcome in alone.outcomes.values()), alone.outcomes
    window = alone.windows[-1]  # without a reversal of the load at rest, of 10 s
    assert abs(window.gap - 0.2) < 4.0 * window.gap_std < 0.1
    ratios = next(signal for signal in SIGNALS if signal.gated)
    joints, (ratio,), *_ = joint_values(ratios, estimates.rows[-1], {}, 50.0)
    error, std = estimates.rows[-1][[E_INNOVATION_MOTOR, E_INNOVATION_STD_MOTOR]]
    assert joints == ['motor'] and ratio == pytest.approx(error ** 2 / (25.0 * std ** 2))
    assert signal_values(ratios, estimates, 50.0)[1]['position'][-1][0] == pytest.approx(ratio)
    signal = SIGNALS[0]
    joints, twist, rate, torque = joint_values(signal, estimates.rows[-1], {}, 1.0)
    assert joints == ['transmission'] and np.isnan([*twist, *rate]).all()
    assert torque == [estimates.tau_k[-1]] and np.isfinite(estimates.smoothed[:, S_TAU_K]).all()
    with pytest.raises(InputError, match='tau_k_stiffness'):
        alone.set_parameters({'tau_k_stiffness': 1.0})
