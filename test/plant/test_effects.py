# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every effect: the same equation in two plants, in pieces, switched on in a node, plugged in."""
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
import math
from pathlib import Path
import re
import sys
import tomllib

import numpy as np
import pytest
import scipy
import yaml

from benchmarks.blind import plant as own
from gearbox_monitor.diagnosis.joint.decision import decide
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, Simulator
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_model, save_model
from gearbox_monitor.plant import effects
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.composition import actuator
from gearbox_monitor.plant.faults import Faults, FaultyPlant
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.signals.uniform import UniformRecording

PAGE = Path(__file__).parents[2] / 'docs/extend.md'
DT = 1e-3
T = DT * np.arange(3000)
# Crosses the gap 11 times, and does not dwell at its edges, where small errors would grow.
U = 3.0 * np.sin(2 * np.pi * 0.7 * T) + 1.5 * np.sin(2 * np.pi * 1.9 * T)
BURST = {'t0': 0.8, 'duration': 0.2, 'amplitude': 0.6}
VALUES = {name: values for name, (_, values, _) in own.EFFECTS.items()} | {'disturbance': BURST}
# Those of a servo: test_controller; tables: test_torque_map; slips are below.
LAWS = {name: effect for name, effect in EFFECTS.items()
        if effect.location and effect.slip_profile is None}
ON_TORQUE = [name for name, effect in LAWS.items() if effect.location != 'controller']
ALL_AT_ONCE = ('lugre', 'hysteresis_bouc_wen', 'hysteresis_branch', 'actuator_lag',
               'actuator_delay', 'motor_encoder_delay', 'arm_encoder_delay', 'viscous_drift',
               'disturbance', 'mesh_error', 'arm_encoder_quantisation')


def given(*names):
    return [{'id': name, **VALUES[name]} for name in names]


def drive(*names):
    return model_from_dict({'effects': given(*names)}, 'test')


def half_sine(burst):
    """Return disturbances of one sample each that follow the half sine of the own plant."""
    count = round(burst['duration'] / DT)
    return [{'id': 'disturbance', 't0': burst['t0'] + k * DT, 'duration': DT,
             'amplitude': burst['amplitude'] * math.sin(math.pi * (k + 0.5) / count)}
            for k in range(count)]


# ---------------------------------------------------------------------- agreement of two plants


def test_values_are_given_for_all():
    assert set(ON_TORQUE) == set(own.shown(own.EFFECTS))
    assert set(LAWS) == set(own.EFFECTS)
    for name, effect in LAWS.items():
        assert effect.location == own.place_of(name)
        assert list(VALUES[name]) == [p.name for p in effect.parameters]


@cache
def without():
    """Return the readings of the own plant without an effect."""
    return own.simulate(own.NOMINAL, [], U, DT)[1]


def agrees(name):
    bursts = half_sine(BURST) if name == 'disturbance' else given(name)
    effect = {'id': name, **({'bursts': [BURST]} if name == 'disturbance' else VALUES[name])}
    nominal, (_, y) = without(), own.simulate(own.NOMINAL, [effect], U, DT)
    assert np.ptp(nominal) > 5.0
    # The finest common grid; of two readings near a half quantum, one may round otherwise.
    quantum = VALUES[name].get('q', 0.0)
    model = model_from_dict({'effects': bursts}, 'test')
    fine = Plant(replace(model, timestep=DT / 10)).run(np.repeat(U, 10), DT / 10)
    y = own.quantise(y, [effect])
    influence = np.abs(y - nominal).max()
    assert influence > (5e-4 if quantum else 0.015)
    off = np.abs(fine.y[::10] - y)
    assert (off > 0.5 * quantum).mean() < 0.01 if quantum else off.max() < 2e-4 * influence
    if not (EFFECTS[name].parameters[-1].name in ('ds', 'dh', 'T', 'amplitude')
            or name == 'lugre' or quantum):
        assert off.max() < 1e-11
    if quantum:
        return  # a free run of the diagnosis is not rounded

    coarse = Plant(model).run(U, DT)
    assert np.abs(coarse.y - y).max() < 2e-5
    recording = UniformRecording(T, U, nominal, DT)
    simulator = Simulator(recording, model_from_dict({}, 'test'))
    extra = None
    if name == 'disturbance':  # to a free run a torque from outside
        extra = np.zeros((len(U), 3))
        extra[:, 1] = -effects.arm_profile(model.effects, T, DT)
    rest = np.zeros((1, 4))
    runs, _ = simulator.run(shooting_windows(recording, len(U) * DT), model, rest, rest, extra)
    assert np.abs(runs[0] - y).max() < max(6e-3 * influence, 2e-4)
    assert np.abs(runs[0] - y).max() < 1e-3


def test_agrees_with_a_plant_that_shares_no_code():
    """
    Same equations: with steps of 0.1 ms the two differ by rounding where no memory is in play.

    Samples of 1 ms of the plant come as close as the steps of the other allow; what those of the
    diagnosis cost is bounded, too. The sudden contacts of the gap make it what it is.
    """
    for name in ON_TORQUE:
        agrees(name)


def test_agrees_with_several_effects_at_once():
    for seed in range(2):
        random = np.random.default_rng(seed)
        names = [n for n in ON_TORQUE if n not in ('disturbance', 'stribeck')
                 and 'quantisation' not in n]
        chosen = [str(n) for n in random.choice(names, 4, replace=False)]
        _, y = own.simulate(own.NOMINAL, given(*chosen), U, DT)
        run = Plant(drive(*chosen)).run(np.repeat(U, 10), DT / 10)
        assert np.abs(run.y[::10] - y).max() < 5e-4, chosen


def test_a_slip_moves_the_zero_of_the_twist():
    """By its equation, integrated by another program; however the run is cut into calls."""
    v, slips = own.NOMINAL, ((0.25, 0.15), (0.45, -0.05))  # s, rad

    def rates(t, state):
        x1, x2, x3, x4 = state
        zero = sum(size for t0, size in slips if t > t0)
        delta = x1 - x2 - zero
        twist = v['K'] * (delta - np.clip(delta, -v['b'], v['b'])) + v['D'] * (x3 - x4)
        friction = v['Cv'] * x3 + v['Cc'] * 2.0 / np.pi * np.arctan(v['alpha'] * x3)
        torque = U[min(int(t / DT + 1e-9), len(U) - 1)]
        return [x3, x4, (torque - twist - friction - v['Kr'] * (x1 - zero)) / v['m1'],
                twist / v['m2']]
    state, readings = np.zeros(4), []
    for k in range(600):
        readings.append(state[:2])
        state = scipy.integrate.solve_ivp(
            rates, (k * DT + 1e-12, (k + 1) * DT), state, rtol=1e-9, atol=1e-11).y[:, -1]
    model = model_from_dict({'effects': [
        {'id': 'slip', 't0': t0 - 0.5 * DT, 'Ds': size} for t0, size in slips]},
        'test')
    run = Plant(model).run(U[:600], DT)
    assert np.abs(run.y - np.array(readings)).max() < 1e-4
    plant = Plant(model)
    cut = [plant.run(U[a:b], DT, a * DT).y
           for a, b in ((0, 251), (251, 251), (251, 440), (440, 600))]
    np.testing.assert_array_equal(np.concatenate(cut), run.y)


# ---------------------------------------------------------------------- exact values


def test_actuator_exactly():
    """A ramp comes a delay later; a step is lagged as exp(-t/T) says, in the mean of each part."""
    n, e = 4, effects.pack(given('actuator_delay'))
    u, out = np.concatenate([np.zeros(30), np.arange(100.0)]), np.empty((100, n))
    actuator(u, 30, 0.0, DT, e, out)
    # Mean over each part of the held command, 3.6 samples earlier.
    fine = np.repeat(u, 1000)
    ends = 30_000 + np.arange(100 * n + 1) * 250 - 3600
    exact = np.diff(np.concatenate([[0.0], np.cumsum(fine)])[ends]) / 250
    np.testing.assert_allclose(out.ravel(), exact, atol=1e-9)

    e = effects.pack([*given('actuator_lag'), {'id': 'torque_gain', 'g': 0.5},
                      {'id': 'saturation', 'umax': 2.0}])
    actuator(np.concatenate([np.zeros(30), np.full(100, 7.0)]), 30, 0.0, DT, e, out)
    t = np.arange(100 * n + 1) * DT / n
    reached = 3.0 * (t + 0.004 * np.exp(-t / 0.004))  # its integral
    np.testing.assert_allclose(out.ravel(), np.diff(reached) * n / DT, atol=1e-9)


def test_encoders_exactly():
    plain = Plant(drive()).run(U, DT)
    for name, i in (('motor', 0), ('arm', 1)):
        run = Plant(drive(f'{name}_encoder_eccentricity')).run(U, DT)
        a, phi = VALUES[f'{name}_encoder_eccentricity'].values()
        expected = plain.x[:, :2].copy()
        expected[:, i] += a * np.sin(expected[:, i] + phi)
        np.testing.assert_allclose(run.y, expected, atol=1e-12)

        whole = model_from_dict(
            {'effects': [{'id': f'{name}_encoder_delay', 'T': 0.005}]}, 'test')
        run = Plant(whole).run(U, DT)
        np.testing.assert_allclose(run.y[5:, i], plain.x[:-5, i], atol=1e-12)

        quantum = VALUES[f'{name}_encoder_quantisation']['q']
        noisy = Plant(drive(f'{name}_encoder_quantisation'),
                      Noise(measurement=(0.002, 0.002)), 3).run(U, DT)
        before = Plant(drive(), Noise(measurement=(0.002, 0.002)), 3).run(U, DT)
        steps = noisy.y[:, i] / quantum
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
        assert np.abs(noisy.y - before.y).max() <= 0.5 * quantum * (1 + 1e-9)
        np.testing.assert_array_equal(noisy.y[:, 1 - i], before.y[:, 1 - i])
        np.testing.assert_array_equal(noisy.x, plain.x)  # the truth stays the truth
    run = Plant(drive('encoder_offset')).run(U, DT)
    np.testing.assert_allclose(run.y - plain.x[:, :2], np.tile([0.0, 0.03], (3000, 1)),
                               atol=1e-12)


def test_burst_counts_by_the_part_of_a_sample_that_it_covers():
    run = Plant(model_from_dict({'effects': [
        {'id': 'disturbance', 't0': 0.0102, 'duration': 0.1, 'amplitude': 0.5}]}, 'test'))
    load = run.run(U, DT).tau_arm
    assert load.sum() * DT == pytest.approx(0.05, rel=1e-9)
    assert load[10] == pytest.approx(0.4)
    assert load[110] == pytest.approx(0.1)
    np.testing.assert_allclose(load[11:110], 0.5, rtol=1e-12)


def test_same_numbers_however_a_run_is_cut():
    for plant in (Plant, FaultyPlant):
        noise = Noise((0.0, 0.0, 0.1, 0.1), (1e-3, 1e-3))
        whole = plant(drive(*ALL_AT_ONCE), noise, 4).run(U, DT)
        pieces, other = [], plant(drive(*ALL_AT_ONCE), noise, 4)
        for begin, end in ((0, 1), (1, 8), (8, 790), (790, 803), (803, 1500), (1500, 3000)):
            pieces.append(other.run(U[begin:end], DT, begin * DT))
        for name in ('t', 'y', 'x', 'tau_k', 'tau_arm'):
            np.testing.assert_array_equal(
                np.concatenate([getattr(p, name) for p in pieces]), getattr(whole, name), name)


def test_faults_act_on_replaced_values():
    twice = FaultyPlant(drive('motor_viscous'), faults=Faults(viscous_friction=2.0)).run(U, DT)
    direct = Plant(model_from_dict({'viscous_friction': 0.26}, 'test')).run(U, DT)
    np.testing.assert_array_equal(twice.x, direct.x)


STEEP = [
    {'id': 'lugre', 'sigma0': 500.0, 'sigma1': 30.0, 'Cs': 0.1, 'vs': 0.3},
    {'id': 'lugre', 'sigma0': 5000.0, 'sigma1': 0.3, 'Cs': 0.1, 'vs': 0.3},
    {'id': 'stribeck', 'Cs': 1.0, 'vs': 0.1}]


def test_steep_friction_stays_stable():
    for effect in STEEP:
        _, y = own.simulate(own.NOMINAL, [effect], U, DT)
        run = Plant(model_from_dict({'effects': [effect]}, 'test')).run(U, DT)
        assert np.abs(run.y - y).max() < 5e-3


# ---------------------------------------------------------------------- model file


BAD_EFFECTS = [
    ('[{id: wobble}]', ['wobble', 'gravity', 'stribeck']),
    ('[{id: stribeck, Cs: 0.1}]', ['effects.stribeck.vs', 'None', 'rad/s']),
    ('[{id: stribeck, Cs: 0.1, vs: 0.2, v: 1}]',
     ['line 1', 'effects.stribeck.v: unknown key', "'vs'"]),
    ('[{id: stribeck, Cs: -0.1, vs: 0.2}]', ['effects.stribeck.Cs', '-0.1', '>= 0', 'N m']),
    ('[{id: cogging, A: 0.1, N: 41, phi: 0}]', ['cogging.N', '41', '<= 40']),
    ('[{id: cogging, A: 0.1, N: 2.5, phi: 0}]', ['cogging.N', '2.5', 'whole']),
    ('[{id: gravity, G: .nan}]', ['gravity.G', 'nan', 'finite']),
    ('[{id: gravity, G: yes}]', ['gravity.G', 'True', 'number']),
    ('[{id: stiffness, K: 30}, {id: stiffness, K: 31}]', ['stiffness', 'twice']),
    ('[gravity]', ['gravity', 'unknown id']),
    ('{id: gravity, G: 1}', ['expected a list']),
]


def test_bad_effect_in_a_model_file(tmp_path):
    for text, words in BAD_EFFECTS:
        path = tmp_path / 'drive.yaml'
        path.write_text(f'effects: {text}\n', encoding='utf-8')
        with pytest.raises(InputError) as error:
            load_model(path)
        assert '\n' not in str(error.value)
        for word in ['drive.yaml', *words]:
            assert word in str(error.value)


# ---------------------------------------------------------------------- plug-ins


def install(folder, module, entries):
    """Install `module` (text) as my_effects.py, with the entry points {name: value}."""
    info = folder / 'my_effects-1.0.dist-info'
    info.mkdir()
    (info / 'METADATA').write_text('Metadata-Version: 2.1\nName: my_effects\nVersion: 1.0\n')
    lines = [f'{name} = {value}' for name, value in entries.items()]
    (info / 'entry_points.txt').write_text(
        '\n'.join([f'[{effects.PLUGIN_GROUP}]', *lines, '']), encoding='utf-8')
    (folder / 'my_effects.py').write_text(module, encoding='utf-8')


def blocks(language):
    text = PAGE.read_text(encoding='utf-8').split('## An effect in your own package\n')[1]
    return re.findall(rf'```{language}\n(.*?)```', text.split('\n## ')[0], re.DOTALL)


@contextmanager
def own_plugin(monkeypatch, folder):
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, 'my_effects', raising=False)
    effects.plugins.cache_clear()
    yield folder
    effects.plugins.cache_clear()
    sys.modules.pop('my_effects', None)


@pytest.fixture
def plugin_folder(tmp_path, monkeypatch):
    with own_plugin(monkeypatch, tmp_path) as folder:
        yield folder


@pytest.mark.system
def test_the_plugin_of_the_page(plugin_folder):
    """Simulated as the own plant does it, beside the nominal drive, and found by the search."""
    [module], [toml], [text] = blocks('python'), blocks('toml'), blocks('yaml')
    groups = tomllib.loads(toml)['project']['entry-points']
    assert list(groups) == [effects.PLUGIN_GROUP]
    install(plugin_folder, module, groups[effects.PLUGIN_GROUP])
    (plugin_folder / 'drive.yaml').write_text(text, encoding='utf-8')
    model = load_model(plugin_folder / 'drive.yaml')
    spring = {'id': 'arm_spring', 'k': yaml.safe_load(text)['effects'][0]['S']}
    _, y = own.simulate(own.NOMINAL, [spring], U, DT)
    run = Plant(replace(model, timestep=DT / 10)).run(np.repeat(U, 10), DT / 10)
    assert np.abs(run.y[::10] - y).max() < 1e-11
    # The kernels without it are others, also those on disk.
    nominal = Plant(replace(drive(), timestep=DT / 10)).run(np.repeat(U, 10), DT / 10)
    assert np.abs(nominal.y[::10] - own.simulate(own.NOMINAL, [], U, DT)[1]).max() < 1e-11
    # Switched on while it runs, together with one of the library.
    plant = Plant(drive('gravity'))
    plant.run(U[:500], DT)
    plant.model = plant.model.with_(effects=(*model.effects, *given('gravity')))
    both = plant.run(U[500:510], DT, 0.5)
    np.testing.assert_allclose(both.tau_arm, 0.4 * both.x[:, 1] + 0.5 * np.sin(
        both.x[:, 1] + VALUES['gravity']['phi']))

    t = DT * np.arange(8000)
    u = 3.0 * np.sin(2 * np.pi * 0.7 * t) + 1.5 * np.sin(2 * np.pi * 1.9 * t)
    _, y = own.simulate(own.NOMINAL, [spring], u, DT)
    y = y + 0.003 * np.random.default_rng(1).standard_normal(y.shape)
    decision = decide(DriveRecordings(
        (UniformRecording(t, u, y, DT),), model_from_dict({}, 'test'), np.array([0.003, 0.003]),
        ('arm_spring', 'gravity')))
    assert decision.fit.name == 'arm_spring' and not decision.remains
    gains = {fit.name: decision.gain(fit) for fit in decision.fits}
    assert gains['arm_spring'] > 25.0 + max(gains['gravity'], 0.0)
    _, [values] = decision.fit.candidate.values(decision.fit.z)
    assert values['S'] == pytest.approx(0.4, rel=0.02)


@pytest.mark.system
def test_two_plugins_in_one_model(plugin_folder):
    [module] = blocks('python')
    module += ('\n\ndef push(t, x1, x2, x3, x4, u, tau_k, theta):\n'
               '    return -theta[0] * x1, 0.0, theta[1] * (x3 - x4)\n\n\n'
               "PUSH = Effect('push', 'motor_side', 'k x1, d', (Parameter('k', 'N m/rad'),\n"
               "              Parameter('d', 'N m s/rad')), torques=push, starts=(0.1, 0.1))\n")
    install(plugin_folder, module, {'a': 'my_effects:ARM_SPRING', 'b': 'my_effects:PUSH'})
    model = model_from_dict({'effects': [{'id': 'push', 'k': 0.2, 'd': 0.04},
                                         {'id': 'arm_spring', 'S': 0.3}]}, 'test')
    run = Plant(model).run(U[:1000], DT)
    # What the two are, said otherwise: Kr, D and the other plant's spring.
    _, y = own.simulate({**own.NOMINAL, 'Kr': 0.21, 'D': 0.05}, [{'id': 'arm_spring', 'k': 0.3}],
                        U[:1000], DT)
    assert np.abs(run.y - y).max() < 2e-3
    assert np.abs(run.tau_arm - 0.3 * run.x[:, 1]).max() < 1e-12


BAD_PLUGINS = [
    ("'arm_spring', 'arm_side'", "'gravity', 'arm_side'", ['gravity', 'taken']),
    ("'arm_side'", "'left'", ['location', 'left', 'arm_side']),
    ('ARM_SPRING = Effect', 'ARM_SPRING = str', ['TypeError']),
    ('ARM_SPRING =', 'OTHER =', ['ARM_SPRING']),
    ('from gearbox_monitor', 'import no_such_module\nfrom gearbox_monitor', ['no_such_module']),
    ('starts=(0.1,)', 'starts=()', ['starts', '1 parameters']),
    ('starts=(0.1,)', 'starts=(-1.0,)', ['starts', 'bounds']),
    ('torques=torques, ', '', ['torques']),
    ('tau_k, theta)', 'theta)', ['torques', 'tau_k']),
    ('theta[0] * x2', 'open("file")', ['torques', 'FileNotFoundError']),
    ('return 0.0, theta[0] * x2, 0.0', 'return theta[0] * x2', ['returns', 'three']),
    ('return 0.0, theta[0] * x2, 0.0', 'return 0.0, theta[0] / (x2 - x2), 0.0', ['torques']),
]


def test_bad_plugin_is_named(new_folder, monkeypatch):
    [module] = blocks('python')
    for old, new, words in BAD_PLUGINS:
        assert old in module
        with monkeypatch.context() as patch, own_plugin(patch, new_folder()) as folder:
            install(folder, module.replace(old, new), {'a': 'my_effects:ARM_SPRING'})
            with pytest.raises(InputError) as error:
                model_from_dict({'effects': [{'id': 'arm_spring', 'S': 0.4}]}, 'test')
        for word in ['plug-in my_effects:ARM_SPRING', *words]:
            assert word in str(error.value)
        assert '\n' not in str(error.value)


# ---------------------------------------------------------------------- in the node


@pytest.mark.ros
def test_effects_of_a_plant_that_runs(graph, tmp_path):
    """Those of its model file, in the bits of a run without a node."""
    from rclpy.qos import QoSProfile
    from sensor_msgs.msg import JointState
    from gearbox_monitor.plant.faults import Excitation
    states, truth = [], []
    for topic, rows in (('joint_states', states), ('plant/transmission_state', truth)):
        graph.node.create_subscription(JointState, topic, rows.append, QoSProfile(depth=10000))
    model = model_from_dict({'effects': [
        {'id': 'stiffness', 'K': 32.0}, {'id': 'actuator_lag', 'T': 0.004},
        {'id': 'motor_encoder_delay', 'T': 0.0034}, {'id': 'viscous_drift', 'r': 0.5, 'T': 1.0},
        {'id': 'disturbance', 't0': 0.2, 'duration': 0.3, 'amplitude': 0.5},
        {'id': 'encoder_offset', 'c': 0.5}, {'id': 'arm_encoder_quantisation', 'q': 0.25},
        {'id': 'gravity', 'G': 0.3}]}, 'test')
    save_model(tmp_path / 'drive.yaml', model, ())
    process = graph.start('plant_node', seed=5, process_noise='[0.0, 0.0, 0.0, 0.0]',
                          wait_for_subscribers=2, model=tmp_path / 'drive.yaml')
    graph.until(lambda: min(len(states), len(truth)) > 900, 'samples')
    u = Excitation().torque(DT * np.arange(5000))
    run = Plant(model, Noise(measurement=(0.005, 0.005)), 5).run(u, DT)
    np.testing.assert_array_equal([m.position for m in states[:900]], run.y[:900])
    np.testing.assert_array_equal([m.effort[0] for m in truth[:900]], run.tau_k[:900])
    np.testing.assert_array_equal(run.y[:, 1] * 4, np.round(run.y[:, 1] * 4))
    assert len(np.unique(run.tau_k)) > 4000  # the truth is not read by an encoder
    graph.stop(process)
