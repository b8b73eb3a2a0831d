# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The load by a robot's description in the estimator: what it gains, with the same bits."""
from functools import cache
import json
import math

import numpy as np
import pytest
from robot_arm import worked

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.process_model import TAU_ARM
from gearbox_monitor.estimation.sample_loop import E_LOAD, E_STD, E_TAU_ARM, E_TAU_E, TRANSFER
from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import ArmPlant
from gearbox_monitor.robot.dynamics import (
    ArmLoad, arrays_of, DEVIATION, INERTIA, LAG, LOAD, move, NOISE, torque_on)

FILE = str(config_path('arm6.urdf'))
ARM = load_robot(FILE)
DRIVES = arm_plant.nominal_drives(ARM)
T0 = 1_700_000_000_000_000_000
DT = 1e-3
JOINT = 4


@cache
def work(seed=2):
    """Return (ArmRun, payload, samples of JOINT) of an arm within the tolerances."""
    rng = np.random.default_rng(seed)
    plant = ArmPlant(arm_plant.as_built(ARM, rng, 0.1),
                     arm_plant.drives_as_built(DRIVES, rng), arm_plant.MIDDLE)
    run, payload, motor, arm = worked(plant, rng, 3, DT)
    u = np.column_stack([run.u[:, JOINT], np.full(len(payload), np.nan)])
    return run, payload, Samples(T0 + np.round(run.t * 1e9).astype(np.int64), u,
                                 np.column_stack([motor[:, JOINT], arm[:, JOINT]]), arm)


def estimator(**changes):
    parameters = {**arm_plant.parameters_of(JOINT), 'robot_description': FILE, **changes}
    return Estimator(DRIVES[JOINT], parameters, ARM)


def part(samples, begin, end):
    return Samples(samples.stamp_ns[begin:end], samples.u[begin:end], samples.y[begin:end],
                   samples.joints[begin:end])


def estimated(engine, payload, samples):
    """Return the estimates; the payload is told as it changes."""
    parts = []
    cuts = [0, *np.flatnonzero(np.diff(payload)) + 1, len(payload)]
    for begin, end in zip(cuts, cuts[1:]):
        assert not engine.set_parameters({'payload_mass': float(payload[begin])})
        parts.append(engine.run(part(samples, begin, end)))
    return [np.concatenate([getattr(p, name) for p in parts])
            for name in ('stamp_ns', 'tau_k', 'tau_k_std', 'tau_arm')]


@pytest.mark.system
def test_the_description_halves_the_error_of_the_torque():
    """With an unknown load the error of friction cannot be told from the torque: no such state."""
    powers = {'unknown': 0.0, 'model': 0.0}
    for seed in (2, 3):
        run, payload, samples = work(seed)
        for load, changes in (('unknown', {'friction_error_std': 0.0}), ('model', {})):
            stamps, tau_k, std, _ = estimated(
                estimator(arm_load=load, **changes), payload, samples)
            settled = slice(500, None)
            error = (tau_k - run.tau_k[np.searchsorted(samples.stamp_ns, stamps), JOINT])[settled]
            powers[load] += np.mean(error ** 2)
            assert np.mean(np.abs(error) < 1.96 * std[settled]) > 0.9
    assert powers['model'] < 0.5 ** 2 * powers['unknown']


def test_steps_runs_and_a_snapshot_give_the_same_bits():
    _, _, samples = work()
    whole = estimator().run(part(samples, 0, 900))
    single = estimator()
    rows = [single.step(Sample(int(t), tuple(u), tuple(y), tuple(j))) for t, u, y, j in zip(
        samples.stamp_ns[:900], samples.u, samples.y, samples.joints)]
    np.testing.assert_array_equal([e.row for e in rows if e], whole.rows)
    first = estimator()
    first.run(part(samples, 0, 500))
    snapshot = json.loads(json.dumps(first.snapshot()))
    second = Estimator.restore(snapshot)
    np.testing.assert_array_equal(second.run(part(samples, 500, 900)).rows, whole.rows[499:])


def test_a_payload_interrupts_nothing():
    """Neither the smoother nor what a Monitor has in its windows; the load follows at once."""
    _, _, samples = work()
    monitor = Monitor(DRIVES[JOINT], {**arm_plant.parameters_of(JOINT),
                                      'robot_description': FILE}, robot=ARM)
    parts = [monitor.run(part(samples, 0, 3500))]
    judged = dict(monitor.outcomes)
    assert not monitor.set_parameters({'payload_mass': 3.0}) and monitor.outcomes == judged
    parts.append(monitor.run(part(samples, 3500, 4000)))
    smoothed = np.concatenate([p.smoothed_stamp_ns for p in parts])
    assert (np.diff(smoothed) == round(DT * 1e9)).all()
    step = abs(parts[1].rows[0, E_LOAD] - parts[0].rows[-1, E_LOAD])
    assert step > 1.0
    for k in (0, 20, 50):  # the robot may take it over at any of these samples
        assert parts[1].rows[k, E_STD + E_TAU_ARM] > 0.9 * step * math.exp(-k * DT / TRANSFER)
    values = monitor.outcomes['prediction error'].values
    assert 'twist_range_evaluations' in values
    assert 'elastic_evaluations' not in values  # the filter takes the torque from the twist


@pytest.mark.system
def test_a_payload_reaches_every_filter_of_a_mixture():
    _, _, samples = work()
    engine = estimator(tau_k_model='mixed', tau_k_stiffness=0.0)
    before = engine.run(part(samples, 0, 2000))
    engine.set_parameters({'payload_mass': 3.0})
    after = engine.run(part(samples, 2000, 2001))
    step = abs(after.rows[0, E_LOAD] - before.rows[-1, E_LOAD])
    assert step > 1.0 and engine.members
    for one in (engine, *engine.members):
        assert one._belief.P[TAU_ARM * (len(one.names) + 1)] > (0.5 * step) ** 2, one.names


def test_no_impact_and_no_payload_that_comes_later_is_an_outlier():
    for late in (0, 20):
        _, payload, samples = work(4)
        told = np.append(payload[late:], np.full(late, payload[-1]))
        engine, ratios = estimator(smoother_lag=0.0), []
        cuts = [0, *np.flatnonzero(np.diff(told)) + 1, len(told)]
        for begin, end in zip(cuts, cuts[1:]):
            engine.set_parameters({'payload_mass': float(told[begin])})
            e = engine.run(part(samples, begin, end))
            ratios += [*(e.innovation_motor / e.innovation_std_motor),
                       *(e.innovation_arm / e.innovation_std_arm)]
        assert np.abs(ratios[2000:]).max() < LIMITS.gate


def test_positions_that_are_missing_leave_the_load_unknown():
    """Until they come, and after they went; the estimates go on, and the total has no step."""
    _, payload, samples = work()
    joints = samples.joints[:2000].copy()
    joints[:300, 1] = joints[1000:1600, 2] = np.nan
    e = estimator().run(Samples(samples.stamp_ns[:2000], samples.u[:2000], samples.y[:2000],
                                joints))
    full = estimator().run(part(samples, 0, 2000))
    assert len(e.tau_k) == len(full.tau_k) == 1999
    before, after = slice(900, 1000), slice(1300, 1550)
    np.testing.assert_allclose(e.tau_k[before], full.tau_k[before], atol=0.3)
    assert np.median(e.tau_k_std[after]) > 1.1 * np.median(full.tau_k_std[after])
    step = np.abs(np.diff(e.tau_arm))[400:]
    assert step.max() < 10.0 * np.abs(np.diff(full.tau_arm))[400:].max()


def test_loads_follow_the_motion():
    """Noise-free: within the stated deviation of lag, of the load that the true motion needs."""
    t = np.arange(1500) * DT
    q = np.column_stack([np.sin(2.0 * np.pi * (0.3 + 0.1 * i) * t) for i in range(6)])
    stamps = T0 + np.round(t * 1e9).astype(np.int64)
    inputs = ArmLoad(arrays_of(ARM), 1, 0.005).inputs(stamps, np.zeros((len(t), 2)), q)[:, 2:]
    w = 2.0 * np.pi * (0.3 + 0.1 * np.arange(6))
    exact = np.empty_like(inputs)
    arrays = arrays_of(ARM)
    for k in range(len(t)):
        a = -w ** 2 * q[k]
        a[1] = 0.0
        move(arrays, np.array([q[k], w * np.cos(w * t[k]), a]))
        exact[k, LOAD], _, exact[k, INERTIA] = torque_on(arrays, 1)
    assert np.isnan(inputs[:49]).all() and np.isfinite(inputs[60:]).all()
    error = np.abs(inputs[100:, LOAD] - exact[100:, LOAD])
    assert error.max() < 0.02 * np.ptp(exact[:, LOAD])
    stated = np.sqrt(0.5 * LAG * 0.005 * inputs[100:, NOISE])
    assert np.mean(error < 2.0 * stated) > 0.95 and not inputs[100:, DEVIATION].any()
    np.testing.assert_allclose(inputs[100:, INERTIA], exact[100:, INERTIA], rtol=1e-3)


def test_a_torque_without_the_weight_gets_it_back():
    _, _, samples = work()
    samples, arrays, less = part(samples, 0, 900), arrays_of(ARM), samples.u[:900].copy()
    for k, q in enumerate(samples.joints):
        move(arrays, np.vstack([q, np.zeros((2, 6))]))
        less[k, 0] -= torque_on(arrays, JOINT)[0]
    e = estimator(effort_is='gravity_compensated').run(
        Samples(samples.stamp_ns, less, samples.y, samples.joints))
    whole, unaware = estimator().run(samples), estimator().run(
        Samples(samples.stamp_ns, less, samples.y, samples.joints))
    last = slice(-300, None)
    error, without = (np.abs(x.rows[last, E_TAU_E] - whole.rows[last, E_TAU_E]).max()
                      for x in (e, unaware))
    assert error < 0.05 * without


BAD_PARAMETERS = [
    ({'effort_is': 'current'}, 'effort_is: current, but torque_constant'),
    ({'effort_is': 'gravity_compensated', 'arm_load': 'unknown'}, 'expected arm_load model'),
    ({'arm_joint': 'elbow'}, "no joint 'elbow' \\(arm_joint\\), expected"),
    ({'filter': 'aekf'}, 'filter: aekf, expected one of ekf, ukf'),
    ({'payload_link': 'gripper'}, "payload_link: 'gripper', expected"),
    ({'robot_gravity': [0.0, 9.8]}, 'robot_gravity: .*, expected three numbers')]


def test_bad_parameters_are_named():
    for changes, said in BAD_PARAMETERS:
        with pytest.raises(InputError, match=said):
            estimator(**changes)


def test_without_the_description_at_hand_the_load_is_unknown():
    engine = Estimator(DRIVES[JOINT], {**arm_plant.parameters_of(JOINT),
                                       'robot_description': 'topic:/robot_description'})
    assert 'tau_arm' in engine.names and not engine.robot_joints
    assert any('not at hand' in text for text in engine.warnings)
