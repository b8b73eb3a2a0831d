# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A servo that takes a setpoint: its closed loop against scipy, its place in a model file."""
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, Simulator
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import fastest_eigenvalue, model_from_dict
from gearbox_monitor.plant.effects import N_MEMORY
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.signals.uniform import UniformRecording

DT = 0.01
T = DT * np.arange(200)
SETPOINT = np.round(1.5 * np.sin(2.0 * np.pi * 0.8 * T) + 0.4 * np.sin(2.0 * np.pi * 2.1 * T), 2)
SERVO = {'kind': 'pd', 'kp': 6.0, 'kd': 0.15, 'torque_limit': 5.0}
EFFECTS = {
    'none': [], 'gain': [{'id': 'servo_gain', 'kp': 4.5}],
    'limit': [{'id': 'servo_limit', 'umax': 2.0}],
    'deadband': [{'id': 'servo_deadband', 'd': 0.05}],
    'integrator': [{'id': 'servo_integrator', 'ki': 12.0}],
    'late': [{'id': 'servo_delay', 'T': 0.012}, {'id': 'servo_integrator', 'ki': 5.0}],
    'delay': [{'id': 'setpoint_delay', 'T': 0.03}], 'lag': [{'id': 'setpoint_lag', 'T': 0.02}],
    'behind': [{'id': 'torque_gain', 'g': -0.2}, {'id': 'torque_offset', 'u0': 0.2},
               {'id': 'cogging', 'A': 0.1, 'N': 5, 'phi': 0.3},
               {'id': 'motor_encoder_eccentricity', 'A': 0.1, 'phi': 0.5}]}


def drive(effects=(), **controller):
    """Return the paper's drive behind a servo."""
    return model_from_dict({'controller': {**SERVO, **controller}, 'effects': list(effects)}, 'm')


def closed_loop(effects, duration, limit=5.0):
    """Return positions and speeds [N, 4] of the closed loop, by scipy."""
    e = {effect['id']: effect for effect in effects}
    m1, m2, damping, cv, cc, k, b, kr = (
        0.006442, 0.023454, 0.01, 0.1, 0.27, 25.0, 0.1, 0.01)
    delay, lag = (e.get(f'setpoint_{name}', {}).get('T', 0.0) for name in ('delay', 'lag'))
    limit = min(limit, e.get('servo_limit', {}).get('umax', 99.0))
    kp = e.get('servo_gain', {}).get('kp', 6.0)
    d = e.get('servo_deadband', {}).get('d', 0.0)
    ki, late = (e.get(name, {}).get(p, 0.0) for name, p in (
        ('servo_integrator', 'ki'), ('servo_delay', 'T')))
    kff, kaff = (e.get(name, {}).get(p, 0.0) for name, p in (
        ('servo_feedforward', 'kff'), ('inertia', 'kaff')))
    gain = 1.0 + e.get('torque_gain', {}).get('g', 0.0)
    u0 = e.get('torque_offset', {}).get('u0', 0.0)

    def clip(value):
        return min(max(value, -limit), limit)
    cog, ecc = ([e.get(name, {}).get(p, 0.0) for p in ('A', 'N', 'phi')] for name in
                ('cogging', 'motor_encoder_eccentricity'))

    def rates(_, state):
        x1, x2, x3, x4, r, integral, low, rate, bent = state
        q = x1 + ecc[0] * math.sin(x1 + ecc[2])
        v = x3 * (1.0 + ecc[0] * math.cos(x1 + ecc[2]))
        error = (r if lag else held) - q
        error = math.copysign(max(abs(error) - d, 0.0), error)
        computed = clip(kp * error + integral - 0.15 * v + ahead)
        u = clip(240.0 * low + 24.0 * late ** 2 * bent - computed) if late else computed
        u = gain * u + u0
        u += cog[0] * math.sin(cog[1] * x1 + cog[2])
        twist = x1 - x2
        tau = k * math.copysign(max(abs(twist) - b, 0.0), twist) + damping * (x3 - x4)
        friction = cv * x3 + cc * 2.0 / math.pi * math.atan(100.0 * x3)
        return [x3, x4, (u - tau - friction - kr * x1) / m1, tau / m2,
                (held - r) / lag if lag else 0.0, ki * error,
                rate, bent, (computed - 120.0 * low - 60.0 * late * rate
                             - 12.0 * late ** 2 * bent) / late ** 3 if late else 0.0]
    state, rows = np.zeros(9), []
    behind = round(delay / DT)
    setpoint = [*np.zeros(behind + 2), *SETPOINT]
    for i, t in enumerate(T[:round(duration / DT)]):  # no step of the setpoint while integrating
        rows.append(state[:4])
        oldest, old, held = setpoint[i:i + 3]
        ahead = kff * (held - old) / DT + kaff * (held - 2.0 * old + oldest) / DT ** 2
        state = solve_ivp(rates, (t, t + DT), state, rtol=1e-9, atol=1e-10,
                          max_step=2e-3).y[:, -1]
    return np.array(rows)


def agrees_with_scipy(name):
    expected = closed_loop(EFFECTS[name], 0.5)
    n = len(expected)
    model = drive(EFFECTS[name])
    fine = Plant(model).run(np.repeat(SETPOINT[:n], 50), DT / 50)
    assert np.ptp(expected[:, 1]) > 1.0
    assert np.abs(fine.x[::50] - expected)[:, :2].max() < 2e-5
    if name != 'none':
        plain = Plant(drive()).run(SETPOINT[:n], DT)
        assert np.abs(plain.x - expected)[:, :2].max() > 0.01
    # Runs of the diagnosis, one after the other and side by side in lanes.
    recording = UniformRecording(T[:n], SETPOINT[:n], expected[:, :2], DT)
    simulator = Simulator(recording, drive())
    window = shooting_windows(recording, n * DT)
    for count in (1, 3):
        y, _ = simulator.run(window.take(np.zeros(count, int)), model, np.zeros((count, 4)),
                             np.zeros((count, N_MEMORY)))
        read = expected[:, 0] + (0.1 * np.sin(expected[:, 0] + 0.5) if name == 'behind' else 0.0)
        assert np.abs(y[0] - np.column_stack([read, expected[:, 1]])).max() < 3e-3


def test_closed_loop_agrees_with_scipy():
    for name in EFFECTS:
        agrees_with_scipy(name)


def test_feedforward_agrees_with_scipy():
    """Its slopes are differences over a sample of the setpoint: so the plant runs at that rate."""
    for ki, limit in ((0.0, 5.0), (12.0, 5.0), (12.0, 50.0)):
        ahead = [{'id': 'servo_feedforward', 'kff': 0.2}, {'id': 'servo_integrator', 'ki': ki}]
        model = drive(ahead, torque_limit=limit, feedforward_inertia=0.004)
        expected = closed_loop([*ahead, {'id': 'inertia', 'kaff': 0.004}], 0.7, limit)
        n = len(expected)
        whole = Plant(model).run(SETPOINT[:n], DT)
        assert np.abs(whole.x - expected)[:, :2].max() < 2e-3
        assert np.abs(Plant(drive(ahead[1:], torque_limit=limit)).run(SETPOINT[:n], DT).x
                      - expected).max() > 0.1
        parts = Plant(model)
        cut = [parts.run(SETPOINT[a:b], DT).x for a, b in ((0, 11), (11, 12), (12, n))]
        np.testing.assert_array_equal(np.concatenate(cut), whole.x)


def agrees_by_hand(late, ki):
    period, n, integral = 2e-3, 140, 0.0
    plant, computed = Plant(model_from_dict({}, 'torque')), [0.0] * (late + 1)
    plant.run(np.zeros(5), period / 10)
    expected = [np.zeros(2)]
    for r in np.repeat(SETPOINT[:n], round(DT / period)):
        x1, _, x3, _ = plant.state[:4]
        computed.append(np.clip(6.0 * (r - x1) + integral - 0.15 * x3, -5.0, 5.0))
        integral = np.clip(integral + period * ki * (r - x1), -5.0, 5.0)
        held = np.full(5, computed[-1 - late])
        plant.run(held, period / 10)
        expected.append(plant.state[:2].copy())
        plant.run(held, period / 10)

    def error(**servo):
        run = Plant(drive(**servo)).run(np.repeat(SETPOINT[:n], 50), DT / 50)
        return np.abs(run.x[::50, :2] - expected[:-1:round(DT / period)]).max()
    stated = error(ki=ki, delay=late * period, rate=1.0 / period)
    assert stated < 4e-3 and stated < 0.5 * error(ki=ki, delay=late * period)


def test_servo_that_computes_at_a_rate():
    """One that is computed by hand at 500 Hz, half a period after the setpoint, and acts later."""
    for late, ki in ((0, 0.0), (3, 10.0)):
        agrees_by_hand(late, ki)


def test_steps_follow_a_stiff_servo():
    assert fastest_eigenvalue(drive(kp=5000.0, kd=20.0)) > 2.0 * fastest_eigenvalue(drive())
    rigid = {'transmission': {'kind': 'rigid'}, 'coulomb_friction': 0.0}
    slow, fast = (fastest_eigenvalue(model_from_dict(
        {**rigid, 'controller': {'kp': kp}}, 'm')) for kp in (10.0, 1000.0))
    assert fast == pytest.approx(10.0 * slow, rel=1e-6)


WRONG = [
    ({'controller': {'kd': 1.0}}, 'controller.kp: missing, expected a number > 0'),
    ({'controller': {'kp': -1.0}}, 'controller: kp: -1.0, expected a number > 0'),
    ({'controller': {'kp': 1.0, 'feedforward': -1.0}}, 'controller: feedforward: -1.0, expected'),
    ({'controller': {'kp': 1.0, 'ki': -1.0}}, 'controller: ki: -1.0, expected a number >= 0'),
    ({'controller': {'kp': 1.0, 'kind': 'pid'}}, "controller.kind: 'pid', expected one of pd"),
    ({'controller': {'kp': 1.0, 'gain': 2.0}}, 'controller.gain: unknown key'),
    ({'effects': [{'id': 'servo_gain', 'kp': 2.0}]}, 'servo_gain: acts on a servo, expected'),
    ({'controller': SERVO, 'effects': [{'id': 'actuator_lag', 'T': 0.01}]},
     'actuator_lag: acts on a recorded torque'),
    ({'controller': SERVO, 'driven_by': 'position', 'process_torque_time': 0.1},
     'driven_by: position, expected torque with a controller')]


def test_messages_name_the_key():
    for data, message in WRONG:
        with pytest.raises(InputError, match='^model.yaml: ') as error:
            model_from_dict(data, 'model.yaml')
        assert message in str(error.value)


def test_model_file_holds_the_servo():
    model = drive()
    assert model_from_dict(model.to_dict(), 'again') == model
    assert 'controller' not in model_from_dict({}, 'plain').to_dict()
    closed = drive(EFFECTS['gain']).folded()
    assert closed.controller.kp == 4.5 and not closed.effects
