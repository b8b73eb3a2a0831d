# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Slips of a clutch or loose hub: named with times and sizes, alone and beside another effect."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import Controller, DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.signals.examine import examine
from gearbox_monitor.signals.uniform import prepare, RecordingKind

MODEL, DT, SECONDS = DriveModel(), 2e-3, 14.0
APART, AT_LOAD = 1.5, 4.0  # s; N m
TRIED = ('slip', 'stiffness', 'backlash_gap', 'load_torque', 'torque_offset', 'arm_coulomb',
         'arm_viscous', 'motor_viscous', 'torque_gain', 'arm_inertia', 'disturbance')


def recording(seed, slips, effects=(), gap=1.0, seconds=SECONDS):
    """Return (recording, slips) of a drive that slips so often, at peaks of its load."""
    random = np.random.default_rng(seed)
    t = np.arange(round(seconds / DT)) * DT
    u = Excitation().torque(t)
    peaks = np.flatnonzero(np.diff(np.sign(np.diff(np.abs(u)))) < 0) + 1
    peaks = peaks[(np.abs(u[peaks]) > AT_LOAD) & (t[peaks] > 1.0) & (t[peaks] < seconds - 1.0)]
    planted = []
    while len(planted) < slips:
        k = random.choice(peaks)
        size = np.sign(u[k]) * 0.02 * 15.0 ** random.random()
        if all(abs(t[k] - other['t0']) > APART for other in planted):
            planted.append({'t0': float(t[k]), 'Ds': float(size)})
    planted.sort(key=lambda slip: slip['t0'])
    lasts = random.uniform(0.0, 0.1)  # s, of each slip: in five steps
    steps = [{'id': 'slip', 't0': slip['t0'] + part * lasts, 'Ds': 0.2 * slip['Ds']}
             for slip in planted for part in (-0.5, -0.25, 0.0, 0.25, 0.5)]
    gear = MODEL.transmission
    drive = replace(MODEL, effects=(*effects, *steps),
                    transmission=replace(gear, half_gap=gap * gear.half_gap))
    run = Plant(drive, Noise((0.0, 0.0, 0.0, 0.0), (5e-3, 5e-3)), seed=seed).run(u, DT)
    return run, planted


def verdict_on(run, tried=TRIED):
    return diagnose([prepare(run.t, run.u, run.y)[0]], MODEL, only=tried)


def assert_found(verdict, planted):
    assert len(verdict.slips) == len(planted)
    for slip, true in zip(verdict.slips, planted):
        assert slip['t0'] == pytest.approx(true['t0'], abs=0.08)
        assert slip['size'] == pytest.approx(true['Ds'], abs=4.0 * slip['std'] + 1e-3)


@pytest.mark.system
@pytest.mark.parametrize('seed', range(1, 12))
def test_slips_are_named_with_times_and_sizes(seed):
    run, planted = recording(seed, 1 + seed % 5)
    verdict = verdict_on(run)
    assert (verdict.verdict, verdict.effect) == ('effect', 'slip')
    assert verdict.gap_before > verdict.gap_after and verdict.gap_after < 1.1
    assert_found(verdict, planted)


PAIRS = ({'id': 'stiffness', 'K': 20.0}, {'id': 'load_torque', 'TL': 0.5},
         {'id': 'arm_coulomb', 'Cac': 0.3}, {'id': 'backlash_gap', 'b': 0.14},
         {'id': 'arm_viscous', 'Cav': 0.1})


@pytest.mark.parametrize('number', [0, *(pytest.param(k, marks=pytest.mark.system)
                                         for k in range(1, 5))])
def test_slips_beside_another_effect(number):
    other = PAIRS[number]
    run, planted = recording(20 + number, 2 - number % 2, (other,),
                             seconds=SECONDS if number else 6.0)
    verdict = verdict_on(run, TRIED if number else TRIED[:3])
    assert verdict.verdict == 'effect'
    assert set(verdict.effect.split('+')) == {'slip', other['id']}
    assert_found(verdict, planted)


@pytest.mark.parametrize('seed, gap, effects', [
    (40, 1.0, ()), *(pytest.param(k, g, e, marks=pytest.mark.system) for k, g, e in (
        (41, 1.0, ()), (42, 1.0, ()), (43, 1.1, ()), (44, 1.3, ()), (45, 1.6, ()),
        (46, 1.0, ({'id': 'load_torque', 'TL': 0.5},)), (47, 0.8, ()),
        (48, 1.0, ({'id': 'disturbance', 't0': 8.0, 'duration': 0.1, 'amplitude': 3.0},)),
        (49, 1.0, ({'id': 'torque_offset', 'u0': 0.3},))))])
def test_no_slip_without_one(seed, gap, effects):
    run, _ = recording(seed, 0, effects, gap, SECONDS if seed > 40 else 6.0)
    assert not verdict_on(run).slips


@pytest.mark.system
def test_a_servo_that_slips_in_the_second_of_two_recordings():
    servo, t = replace(MODEL, controller=Controller(kp=40.0, kd=2.0)), np.arange(8000) * DT
    slip, parts = {'id': 'slip', 't0': 7.3, 'Ds': 0.12}, []
    gain = {'id': 'servo_gain', 'kp': 32.0}
    for seed, effects in ((1, (gain,)), (2, (gain, slip))):
        u = 0.5 * np.sin(1.9 * t) + 0.3 * np.sin(5.2 * t + seed)
        run = Plant(replace(servo, effects=effects), Noise((0.0,) * 4, (2e-3, 2e-3)),
                    seed).run(u, DT)
        parts.append(prepare(t, u, run.y, name=f'run {seed}',
                             kind=RecordingKind(setpoint=True))[0])
    verdict = diagnose(parts, servo, only=('slip', 'stiffness', 'backlash_gap', 'servo_gain'))
    assert verdict.verdict == 'effect'
    assert set(verdict.effect.split('+')) == {'slip', 'servo_gain'}
    assert_found(verdict, [slip])
    assert verdict.slips[0]['recording'] == 'run 2'


def test_all_doors_agree():
    """The live node, check and diagnose: one slip, one size, one time."""
    run, _ = recording(60, 0, seconds=24.0)
    y = run.y.copy()
    y[:, 0] += 0.15 * np.clip((run.t - 12.2) / 0.08, 0.0, 1.0)
    stamps = np.rint(run.t * 1e9).astype(np.int64) + 10 ** 18
    samples = Samples(stamps, np.column_stack([run.u, np.full(len(run.u), np.nan)]), y)
    monitor = Monitor(MODEL, {'drift_window': 4.0})
    monitor.run(samples)
    live, = monitor.health.slips
    line, = (line for line in examine(samples, EstimatorParameters(), MODEL).lines
             if line.name == 'slip')
    late = np.where(run.t[:, None] < 1.0, np.nan, y)  # times are those of the log all the same
    verdict = verdict_on(replace(run, y=late), TRIED[:2])
    assert (verdict.verdict, verdict.effect) == ('effect', 'slip')
    assert verdict.gap_before > verdict.gap_after and verdict.gap_after < 1.1
    found, = verdict.slips
    assert live.size == pytest.approx(found['size'], abs=3.0 * live.std)
    assert line.values['slip_rad'] == pytest.approx(found['size'], abs=0.01)
    assert found['size'] == pytest.approx(0.15, abs=4.0 * found['std'] + 1e-3)
    assert found['t0'] == pytest.approx(12.24, abs=0.2)
    for seconds in ((live.stamp_ns - 10 ** 18) * 1e-9, line.values['slip_s']):
        assert seconds == pytest.approx(found['t0'], abs=4.0)
