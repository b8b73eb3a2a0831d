# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Laws of friction: against MuJoCo itself, against their definitions, in plant and filters."""
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.process_model import (
    advance_beside, BESIDE, EIGENVALUE, FACTOR_DELAY, layout_of, N_FACTORS, N_LANE,
    NUMERIC, pack, propagate, propagate_numeric)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import model_from_dict, substeps
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate

EXPORT = Path(__file__).parents[1] / 'simulators'
DT = 2e-3
MUJOCO = {'friction_law': {'kind': 'mujoco'}, 'timestep': 1e-3}


def in_mujoco(text, u):
    """Return the positions of all joints [N, n] under the torques `u`, one each DT."""
    mujoco = pytest.importorskip('mujoco')
    m = mujoco.MjModel.from_xml_string(text)
    d = mujoco.MjData(m)
    rows = []
    for torque in u:
        rows.append(d.qpos.copy())
        d.ctrl[0] = torque
        mujoco.mj_step(m, d, nstep=round(DT / m.opt.timestep))
    return np.array(rows)


def changed(file, h, integrator, *pairs):
    """Return an MJCF file with another timestep (s), integrator and other text."""
    text = (EXPORT / file).read_text(encoding='utf-8')
    for before, after in [(' integrator="RK4"', f' integrator="{integrator}" gravity="0 0 0"'),
                          ('timestep="0.0001"', f'timestep="{h}"'), *pairs]:
        assert before in text
        text = text.replace(before, after)
    return text


def test_mujoco_itself():
    for integrator in ('Euler', 'implicitfast', 'RK4'):
        for h, arm in ((1e-3, 0.0), (2e-3, 0.1)):
            u = Excitation().torque(np.arange(500) * DT)
            text = changed('pair.xml', h, integrator, (
                '<joint name="arm"', f'<joint frictionloss="{arm}" name="arm"'))
            theirs = in_mujoco(text, u)
            model = model_from_dict({**MUJOCO, 'timestep': h, 'integrator': integrator.lower(),
                                     'effects': [{'id': 'arm_coulomb', 'Cac': arm}]}, 'test')
            ours = simulate(model, u, DT).x[:, :2]
            assert np.ptp(theirs) > 0.5
            assert np.sqrt(np.mean((ours - theirs) ** 2)) < 1e-4  # rad over 1 s


def test_one_joint_in_mujoco():
    for integrator in ('Euler', 'implicitfast', 'RK4'):
        u = Excitation().torque(np.arange(500) * DT)
        text = f"""<mujoco><option timestep="0.001" integrator="{integrator}" gravity="0 0 0"/>
    <worldbody><body><joint name="j" axis="0 0 1" armature="0.006442" damping="0.3"
      frictionloss="0.4" solreffriction="0.05 1" solimpfriction="0.7 0.8"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.023454"/></body></worldbody>
    <actuator><motor joint="j"/></actuator></mujoco>"""
        theirs = in_mujoco(text, u)[:, 0]
        model = model_from_dict({
            'friction_law': {'kind': 'mujoco', 'solref': [0.05, 1], 'solimp': [0.7, 0.8]},
            'timestep': 1e-3, 'integrator': integrator.lower(), 'viscous_friction': 0.3,
            'coulomb_friction': 0.25, 'effects': [{'id': 'arm_coulomb', 'Cac': 0.15}],
            'position_gain': 0.0, 'transmission': {'kind': 'rigid'}}, 'test')
        assert np.abs(simulate(model, u, DT).x[:, 0] - theirs).max() < 1e-5


def test_what_the_law_of_the_arctangent_does_to_the_same_file():
    """The bound above is one that a wrong law does not meet."""
    u = Excitation().torque(np.arange(500) * DT)
    runs = [simulate(model_from_dict(changes, 'test'), u, DT).x[:, :2] for changes in (MUJOCO, {})]
    assert np.sqrt(np.mean((runs[0] - runs[1]) ** 2)) > 0.02


def test_stops_within_a_step_and_breaks_away():
    """ODE and PhysX: the joint stands after a step; PhysX holds `static` times as much."""
    values = {'timestep': 1e-3, 'integrator': 'euler', 'transmission': {'kind': 'rigid'},
              'position_gain': 0.0, 'viscous_friction': 0.0, 'coulomb_friction': 1.0}
    ode, physx = (model_from_dict({**values, 'friction_law': law}, 'test') for law in (
        {'kind': 'ode'}, {'kind': 'physx', 'static': 1.5}))
    u = np.array([0.99, 1.3, 0.0, 0.0] * 10)
    x = simulate(ode, u, 1e-3).x[:, 2]
    inertia = ode.motor_inertia + ode.arm_inertia
    np.testing.assert_allclose(x[:4], [0.0, 0.0, 0.3 * 1e-3 / inertia, 0.0], atol=1e-15)
    assert not simulate(physx, u, 1e-3).x[:, 2].any()
    slides = simulate(physx, np.full(3, 1.6), 1e-3).x[:, 2]
    assert slides[1] == pytest.approx(0.6e-3 / inertia)  # once away, dynamic friction acts


def has_the_law(law):
    model = model_from_dict({'friction_law': law, 'timestep': 1e-3, 'effects': [
        {'id': 'arm_coulomb', 'Cac': 0.1}], 'arm_friction_sharpness': 60.0}, 'test')
    run = simulate(model, Excitation().torque(np.arange(200) * 1e-3), 1e-3)
    p = pack(model, EstimatorParameters(tau_k_model='elastic'))
    states, z, n = layout_of(p, 5), np.zeros(5), substeps(1e-3, p[EIGENVALUE])
    lanes = np.ones((2, 5 + N_LANE + N_FACTORS, BESIDE))
    lanes[:, :5] = lanes[:, 5 + N_LANE + FACTOR_DELAY] = 0.0
    for u in run.u[:-1]:
        for one, differ in zip(lanes, (None, True)):
            advance_beside(states, one.reshape(-1), 4, differ, (u, 0.0, 0.0), 1e-3, n, p)
    z[:] = lanes[0, :5, 3]
    np.testing.assert_array_equal(lanes[1, :5, 3], z)
    np.testing.assert_allclose(z[:2], run.x[-1, :2], atol=2e-5)
    if model.friction_law.constraint:
        assert p[NUMERIC]
        return
    exact, differences = np.zeros(25), np.zeros(25)
    z[2] = z[3] = 0.003
    propagate(states, z.copy(), exact, (1.0, 0.0), 1e-3, n, p)
    propagate_numeric(states, z.copy(), differences, (1.0, 0.0), 1e-3, n, p, lanes[0].ravel())
    np.testing.assert_allclose(exact, differences, atol=1e-5)


def test_the_process_model_of_filters_has_the_law():
    """With tau_K from the curve it repeats the simulator, and its tangent is that of its steps."""
    for law in ({'kind': 'tanh'}, MUJOCO['friction_law'], {'kind': 'ode'}):
        has_the_law(law)


def test_sharpness_of_the_arm():
    u = Excitation().torque(np.arange(300) * DT)
    effects = {'effects': [{'id': 'arm_coulomb', 'Cac': 0.2}]}
    same, own, both = (simulate(model_from_dict({**effects, **changes}, 'test'), u, DT).x for
                       changes in ({}, {'arm_friction_sharpness': 100.0},
                                   {'arm_friction_sharpness': 5.0}))
    np.testing.assert_array_equal(same, own)
    assert np.abs(same - both).max() > 0.01


WRONG = [
    ({'friction_law': {'kind': 'mujoco'}},
     r'timestep: missing, expected that of the simulator \(s\) with friction_law: mujoco'),
    ({'integrator': 'euler'}, 'timestep: missing, .* with integrator: euler'),
    ({'friction_law': {'kind': 'dry'}}, "friction_law.kind: 'dry', expected one of atan"),
    ({'friction_law': {'kind': ['physx'], 'static': 2.0}}, r"kind: \['physx'\], expected one of"),
    ({'friction_law': {'kind': 'atan', 'solref': [0.02, 1]}}, 'solref: not of the law atan'),
    ({'friction_law': {'kind': 'mujoco', 'solimp': 0.9}}, 'solimp: 0.9, expected two numbers'),
    ({'friction_law': {'kind': 'physx', 'static': 0.5}}, 'static: 0.5, expected a number >= 1'),
    ({**MUJOCO, 'driven_by': 'position', 'process_torque_time': 0.1}, 'expected atan or tanh')]


def test_what_is_wrong_is_one_line():
    for values, problem in WRONG:
        with pytest.raises(InputError, match=problem):
            model_from_dict(values, 'drive.yaml')


def test_a_model_file_keeps_the_law():
    model = model_from_dict({**MUJOCO, 'integrator': 'implicitfast'}, 'test')
    assert model_from_dict(model.to_dict(), 'test') == model
