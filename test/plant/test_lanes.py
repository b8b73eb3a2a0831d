# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Runs side by side: the bits of single runs, and functions that a vector unit can do."""
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.shooting import N_MEMORY, shooting_windows, Simulator
from gearbox_monitor.kernels.elementary import arctan, exponential, sine
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import (
    _run, Noise, packed_drive, Plant, ProcessNoise, read_all, Schedule)
from gearbox_monitor.signals.uniform import UniformRecording

DT = 2e-3
OWN_EQUATIONS = [
    {'id': 'gravity', 'G': 0.3}, {'id': 'arm_coulomb', 'Cac': 0.05},
    {'id': 'stribeck', 'Cs': 0.1, 'vs': 0.5},
    {'id': 'lugre', 'sigma0': 100.0, 'sigma1': 0.5, 'Cs': 0.1, 'vs': 0.3},
    {'id': 'coulomb_asymmetry', 'Ca': 0.05}, {'id': 'viscous_drift', 'r': 0.5, 'T': 3.0},
    {'id': 'cogging', 'A': 0.05, 'N': 6, 'phi': 1.0}, {'id': 'hardening', 'K3': 500.0},
    {'id': 'hysteresis_bouc_wen', 'Th': 0.2, 'dh': 0.03},
    {'id': 'hysteresis_branch', 'h': 0.01, 'ds': 0.03},
    {'id': 'mesh_error', 'A': 0.01, 'N': 7, 'phi': 0.0},
    {'id': 'torque_ripple', 'A': 0.1, 'N': 7, 'phi': 0.3},
    {'id': 'torque_map', 'place': 'arm_side', 'variable': 'angle', 'knots': [-1.0, 0.2, 2.0],
     'values': [0.1, -0.1, 0.3], 'deviations': [0.0, 0.0, 0.0]}]
MAPS = [[{**OWN_EQUATIONS[-1], 'place': place, 'variable': variable}] for place, variable in (
    ('motor_side', 'speed'), ('motor_side', 'torque'), ('transmission', 'twist'))]


def test_arctan():
    x = np.concatenate([np.linspace(-4.0, 4.0, 4001), np.logspace(-300, 300, 601)])
    found = np.array([arctan(v) for v in x])
    np.testing.assert_allclose(found, np.arctan(x), rtol=1e-15)
    np.testing.assert_array_equal([arctan(-v) for v in x], -found)
    assert arctan(math.inf) == 0.5 * math.pi and math.isnan(arctan(math.nan))
    assert arctan(0.0) == 0.0


def test_exponential():
    x = np.concatenate([np.linspace(-99.9, 700.0, 8000), [0.0, 1e-300, -1e-17]])
    np.testing.assert_allclose([exponential(v) for v in x], np.exp(x), rtol=5e-16)
    assert exponential(0.0) == 1.0 and math.isnan(exponential(math.nan))
    assert 0.0 <= exponential(-1e5) <= 4e-44 and 0.0 <= exponential(-math.inf) <= 4e-44


def test_sine():
    x = np.concatenate([np.linspace(-30.0, 30.0, 6001), np.logspace(-300, 12, 700)])
    np.testing.assert_allclose([sine(v) for v in x], np.sin(x), rtol=0.0, atol=3e-16)
    small = np.logspace(-300, 0, 400)
    np.testing.assert_allclose([sine(v) for v in small], np.sin(small), rtol=3e-16)
    assert math.isnan(sine(math.inf)) and math.isnan(sine(math.nan))


CASES = [
    {},
    {'effects': [{'id': 'stiffness', 'K': 31.0}, {'id': 'load_friction', 'Cl': 0.1},
                 {'id': 'arm_viscous', 'Cav': 0.02}, {'id': 'load_torque', 'TL': 0.3}]},
    {'effects': [{'id': 'actuator_lag', 'T': 0.004}, {'id': 'motor_encoder_delay', 'T': 0.003},
                 {'id': 'arm_encoder_eccentricity', 'A': 0.02, 'phi': 1.0}]},
    *({'effects': effects} for effects in MAPS), {'effects': OWN_EQUATIONS},
    # Of these each lane is stepped by itself.
    {'transmission': {'kind': 'play', 'hysteresis_width': 0.05}},
    {'transmission': {'kind': 'rigid'}, 'friction_law': {'kind': 'tanh'}},
    {'friction_law': {'kind': 'mujoco'}, 'timestep': DT, 'integrator': 'implicitfast'},
]


def alone(simulator, windows, model, states, memory, extra):
    """Return what Simulator.run does, window by window as a Plant runs."""
    e, drive = model.pack_effects(), packed_drive(model)
    acting, ends, y = simulator.acting(e), [], np.empty((len(windows), windows.length, 2))
    for w, (begin, first) in enumerate(zip(windows.begin, windows.first)):
        span = slice(begin, first + windows.length)
        state, n = np.concatenate([states[w], memory[w]]), span.stop - span.start
        x, times = np.empty((n, 4)), DT * np.arange(span.start, span.stop)
        _run(state, Schedule(times, acting[span], extra[span], DT), ProcessNoise(
            np.zeros((n, acting.shape[1], 4)), np.zeros(4)), drive, x, np.empty((n, 2)), 0.0)
        read_all(x, first - begin, DT, e, y[w])
        ends.append(state)
    return y, np.array(ends)


def test_lanes_have_the_bits_of_single_runs():
    for case in CASES:
        model = model_from_dict(case, 'test')
        u = Excitation().torque(DT * np.arange(5000))
        run = Plant(model, Noise(measurement=(0.005, 0.005)), 3).run(u, DT)
        recording = UniformRecording(run.t, u, run.y, DT)
        simulator, windows = Simulator(recording, model), shooting_windows(recording, 0.5)
        # Windows in any order, some several times; the first has no lead, others have.
        windows = windows.take(np.array([3, 0, 3, *range(len(windows)), 1]))
        random = np.random.default_rng(1)
        states = run.x[windows.begin] + 1e-3 * random.standard_normal((len(windows), 4))
        if model.transmission.kind == 'rigid':
            states = states[:, [0, 0, 2, 2]]
        states[2, 2] = 1e308  # diverges
        memory = random.standard_normal((len(windows), N_MEMORY))
        extra = 0.05 * random.standard_normal((len(u), 3))
        single = alone(simulator, windows, model, states, memory, extra)
        together = simulator.run(windows, model, states, memory, extra)
        first = simulator.run(windows.take(np.array([0])), model, states[:1], memory[:1], extra)
        for expected, found, one in zip(single, together, first):
            np.testing.assert_array_equal(found, expected)
            np.testing.assert_array_equal(one, expected[:1])
        assert not np.isfinite(single[0][2]).all() and np.isfinite(single[0][3:]).all()
