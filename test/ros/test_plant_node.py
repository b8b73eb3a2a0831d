# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The simulated drive as a real process: samples, stamps, parameters, commands, end."""
import signal
import time

import numpy as np
import pytest
import yaml

pytest.importorskip('rclpy')
from harness import Graph  # noqa: E402, I100, I202
from processes import refusals  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from gearbox_monitor.files.user_files import config_path, load_model  # noqa: E402
from gearbox_monitor.parameters import PLANT_MODEL, PlantParameters  # noqa: E402
from gearbox_monitor.plant.faults import Excitation  # noqa: E402
from gearbox_monitor.plant.simulate import Noise, Plant, simulate  # noqa: E402

pytestmark = pytest.mark.ros
BLOCK = 10  # samples that the node simulates at once at 1 kHz in real time


class Plants(Graph):
    """Starts plants and keeps what they publish."""

    def __init__(self, tmp_path, monkeypatch):
        super().__init__(tmp_path, monkeypatch)
        self.states, self.truth, self.clock = [], [], []
        for kind, topic, kept in ((JointState, 'joint_states', self.states),
                                  (JointState, 'plant/transmission_state', self.truth),
                                  (Clock, '/clock', self.clock)):
            self.node.create_subscription(kind, topic, kept.append, QoSProfile(depth=10000))

    def start(self, **parameters):
        for topic in ('joint_states', 'plant/transmission_state'):  # a starved test loses nothing
            parameters[f'qos_overrides./{topic}.publisher.depth'] = 50_000
        return super().start('plant_node', **parameters)

    def rest(self):
        """Receive until nothing has come for half a second."""
        count = -1
        while len(self.states) + len(self.truth) > count:
            count = len(self.states) + len(self.truth)
            self.spin(0.5)


@pytest.fixture
def plants(monkeypatch, tmp_path):
    plants = Plants(tmp_path, monkeypatch)
    yield plants
    plants.close()


def stamps(messages):
    return np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages])


def columns(messages, field):
    return np.array([getattr(m, field) for m in messages])


def first_index(y, trajectory):
    """Return the number of the sample whose measured positions are `y`."""
    found = np.flatnonzero((trajectory.y == y).all(axis=1))
    assert len(found) == 1, 'the first sample received is not one of the simulation'
    return found[0]


def assert_same(plants, k, run):
    """Everything received equals the samples from k on of the Trajectory `run`, bit for bit."""
    n = min(len(plants.states), len(run.t) - k)
    part = slice(k, k + n)
    states = plants.states[:n]
    np.testing.assert_array_equal(columns(states, 'position'), run.y[part])
    np.testing.assert_array_equal(columns(states, 'effort')[:, 0], run.u[part])
    assert np.isnan(columns(states, 'effort')[:, 1]).all()
    m = min(len(plants.truth), n)
    offset = (stamps(plants.truth[:1]) - stamps(states[:1]))[0] // 10**6
    part = slice(k + offset, k + offset + m)
    x = run.x[part]
    np.testing.assert_array_equal(columns(plants.truth[:m], 'position')[:, 0], x[:, 0] - x[:, 1])
    np.testing.assert_array_equal(columns(plants.truth[:m], 'velocity')[:, 0], x[:, 2] - x[:, 3])
    np.testing.assert_array_equal(columns(plants.truth[:m], 'effort')[:, 0], run.tau_k[part])


def test_publishes_the_simulation_bit_for_bit(plants):
    process = plants.start(seed=7, process_noise='[0.0, 0.0, 0.0, 0.0]')
    plants.until(lambda: len(plants.states) > 800)
    plants.stop(process)
    u = Excitation().torque(np.arange(60_000) * 1e-3)
    run = simulate(load_model(config_path('drive.yaml')), u, 1e-3,
                   Noise(measurement=(0.005, 0.005)), 7)
    assert_same(plants, first_index(plants.states[0].position, run), run)
    for messages in (plants.states, plants.truth):
        assert set(np.diff(stamps(messages))) == {1_000_000}
    assert plants.states[0].name == ['motor', 'arm']
    assert plants.truth[0].name == ['transmission']
    assert not plants.states[0].velocity


def test_process_noise_and_duration(plants):
    process = plants.start(seed=3, duration=1.5, wait_for_subscribers=2)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    plants.rest()
    plant = Plant(load_model(config_path('drive.yaml')),
                  Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.005)), 3)
    u = Excitation().torque(np.arange(1500) * 1e-3)
    blocks = [plant.run(u[k:k + BLOCK], 1e-3) for k in range(0, 1500, BLOCK)]
    run = type(blocks[0])(*(np.concatenate([getattr(b, name) for b in blocks])
                            for name in ('t', 'u', 'y', 'x', 'tau_k', 'tau_arm')))
    k = first_index(plants.states[0].position, run)
    assert k + len(plants.states) == 1500
    assert_same(plants, k, run)


def test_parameters_change_while_it_runs(plants):
    # Slow enough for a starved machine to keep up.
    plants.start(measurement_noise='[0.0, 0.0]', process_noise='[0.0, 0.0, 0.0, 0.0]', rate=200.0)
    plants.until(lambda: len(plants.truth) > 40)
    assert plants.set('plant', stiffness=400.0)[0].successful
    # By stamps, which are of real time: on a loaded machine older samples are still under way.
    since = time.time_ns() + 50_000_000

    def changed():
        return [m for m in plants.truth
                if m.header.stamp.sec * 10 ** 9 + m.header.stamp.nanosec > since]
    plants.until(lambda: len(changed()) > 230)
    later = changed()
    twist, tau = columns(later, 'position')[:, 0], columns(later, 'effort')[:, 0]
    outside = np.abs(twist) > 0.1
    assert outside.any()
    np.testing.assert_allclose(
        tau[outside], 400.0 * (twist - 0.1 * np.sign(twist))[outside], atol=1e-12)
    assert np.all(tau[~outside] == 0)

    for name, value, reason in (
            ('half_gap', -0.1, 'half_gap'), ('rate', 300.0, 'read-only'),
            ('excitation', 'sawtooth', 'multisine'), ('amplitudes', [1.0], 'frequencies'),
            ('process_noise', [0.1], '4 numbers')):
        result, = plants.set('plant', **{name: value})
        assert not result.successful
        assert reason in result.reason

    assert all(r.successful for r in plants.set('plant', excitation='none', load_constant=0.4))
    plants.until(lambda: plants.states[-1].effort[0] == 0.0)
    # With the load the arm ends on the side of the gap where the transmission carries it.
    plants.until(lambda: abs(plants.truth[-1].effort[0] - 0.4) < 0.02)


def test_growing_gap_faster_than_time(plants):
    process = plants.start(speed=5.0, gap_growth_rate=0.5, gap_growth_start=2.0,
                           gap_growth_max=1.0, duration=10.0, rate=250.0,
                           process_noise='[0.0, 0.0, 0.0, 0.0]')
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    plants.rest()
    stamp = stamps(plants.truth)
    assert set(np.diff(stamp)) == {4_000_000}
    late = stamp > stamp[-1] - 4 * 10**9  # the last 4 s: the gap has doubled
    twist, tau = columns(plants.truth, 'position')[:, 0], columns(plants.truth, 'effort')[:, 0]
    inside = late & (tau == 0)
    assert 0.15 < np.abs(twist[inside]).max() <= 0.2
    clock = np.array([m.clock.sec * 10**9 + m.clock.nanosec for m in plants.clock])
    assert len(clock) > 50
    assert (np.diff(clock) > 0).all()
    assert abs(clock[-1] - stamp[-1]) < 10**9


def test_motor_turns_as_many_times_as_the_gear_says(plants, tmp_path):
    model = tmp_path / 'geared.yaml'
    model.write_text('gear_ratio: 50.0\ntorque_constant: 0.5\n')
    process = plants.start(model=model, measurement_noise='[0.0, 0.0]', amplitudes='[2.0]',
                           frequencies='[0.5]', process_noise='[0.0, 0.0, 0.0, 0.0]')
    amps = -2.0 / (50.0 * 0.5)  # at the end of half a period
    plants.until(lambda: plants.states and plants.states[-1].effort[0] < 0.99 * amps
                 and plants.truth and np.ptp(columns(plants.truth, 'position')[:, 0]) > 0.2)
    plants.stop(process, signal.SIGTERM)
    plants.rest()
    truth = {t: m for t, m in zip(stamps(plants.truth), plants.truth)}
    matched = [(m, truth[t]) for t, m in zip(stamps(plants.states), plants.states) if t in truth]
    y = columns([m for m, _ in matched], 'position')
    twist = columns([t for _, t in matched], 'position')[:, 0]
    np.testing.assert_allclose(y[:, 0] / 50 - y[:, 1], twist, atol=1e-12)
    assert columns(plants.states, 'effort')[:, 0].min() == pytest.approx(amps, rel=0.01)
    assert np.ptp(twist) > 0.1  # it has moved


def test_bad_input_is_one_line(tmp_path):
    said = {
        'model:=no_such.yaml': ['no_such.yaml', 'expected'], 'rate:=5.0': ['rate', '5'],
        'excitation:=sawtooth': ['excitation', 'sawtooth', 'multisine'],
        'process_noise:=[1.0]': ['process_noise', '4 numbers'], 'half_gap:=wide': ['half_gap'],
        "effects:=['gravity G=1']": ['effects', 'write them into its model file']}
    runs = refusals('plant_node', [['-p', parameter] for parameter in said], tmp_path)
    for (code, lines), words in zip(runs, said.values()):
        assert code == 2 and len(lines) == 1, lines
        assert all(word in lines[0] for word in words), lines


def test_the_file_of_defaults_agrees_with_the_table():
    values = yaml.safe_load(config_path('plant.yaml').read_text())['plant']['ros__parameters']
    table = PlantParameters().to_dict()
    assert values == {k: v for k, v in table.items() if k not in PLANT_MODEL}
    model = load_model(config_path('drive.yaml'))
    for name in PLANT_MODEL:
        value = getattr(model, name, None)
        assert table[name] == (getattr(model.transmission, name) if value is None else value)
