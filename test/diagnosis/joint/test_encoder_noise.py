# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Noise of encoders: its level by innovations; coloured noise as a state of the filter."""
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from scipy.signal import lfilter

from gearbox_monitor.diagnosis.joint.decision import decide, with_level_of_innovations
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.drive_recordings import evidence_of
from gearbox_monitor.diagnosis.joint.innovations import noise_floor, prewhitened
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.signals.uniform import UniformRecording

DT, PHI = 1e-3, np.exp(-1e-3 / 5e-3)
WEAK = {'id': 'arm_coulomb', 'Cac': 0.05}


def noise(phi, *shape, seed=0):
    """Return noise of standard deviation 1 along the axis 1 of `shape`."""
    white = np.random.default_rng(seed).standard_normal(shape)
    white[:, 1:] *= np.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], white, axis=1)


def test_made_white():
    r = prewhitened(np.concatenate([noise(0.8, 200, 500, 1), noise(0.0, 200, 500, 1)], axis=2),
                    np.array([0.8, 0.0]))
    for lag, expected in ((0, 1.0), (1, 0.0), (3, 0.0)):
        found = (r[:, lag:] * r[:, :500 - lag]).mean(axis=(0, 1))
        np.testing.assert_allclose(found, expected, atol=5.0 / np.sqrt(200 * 500))


def test_an_encoder_that_stands_still_has_its_noise_where_it_moves():
    for rows in (1000, 2000, 2001, 3500):
        t = np.arange(4000) * DT
        y = np.sin(6.0 * t)[:, None] + 0.002 * np.random.default_rng(0).standard_normal((4000, 2))
        y[4000 - rows:, 1] = y[4000 - rows, 1]
        sigma, quantum = noise_floor(UniformRecording(t, t, y, DT), DriveModel())
        assert sigma == pytest.approx([0.002, 0.002], rel=0.1) and not quantum.any()


def test_an_encoder_that_is_read_less_often_does_not_stand_still():
    for rows in (1, 4, 5):
        t = np.arange(4000) * DT
        y = np.sin(6.0 * t)[:, None] + 0.002 * np.random.default_rng(0).standard_normal((4000, 2))
        y = np.repeat(y[::rows], rows, axis=0)
        sigma, _ = noise_floor(UniformRecording(t, t, y, DT), DriveModel())
        assert sigma.tolist() == noise_levels(y)[0].tolist()


def test_coloured_noise_is_a_state_of_the_filter():
    """Innovations are white and as large as stated; a moved model moves them as a new run does."""
    t, model = np.arange(4000) * DT, DriveModel()
    u = Excitation('multisine', (4.0, 2.0), (0.5, 1.3)).torque(t)
    y = simulate(model, u, DT).x[:, :2] + 0.004 * noise(PHI, 1, len(t), 2, seed=2)[0]
    white = replace(evidence_of([UniformRecording(t, u, y, DT)], model, ['motor_viscous']),
                    sigma=np.full(2, 0.004))
    coloured = replace(white, colour=np.array([[PHI, 1.0], [PHI, 1.0]]))
    left = {}
    for name, data in (('white', white), ('coloured', coloured)):
        run = data.fine.run(model, data.fine.least_noise)
        r = run.residual[run.read.all(axis=1)]
        left[name] = float((r[1:] * r[:-1]).mean()), float((r ** 2).mean()), run
    assert left['white'][0] > 0.5 and abs(left['coloured'][0]) < 4.0 / np.sqrt(2 * 4000)
    assert left['coloured'][1] == pytest.approx(1.0, abs=0.06)
    run, moved = left['coloured'][2], model.with_(viscous_friction=1.0001 * model.viscous_friction)
    change = coloured.fine.run(moved, coloured.fine.least_noise).innovation - run.innovation
    np.testing.assert_allclose(coloured.fine.change(run, moved), change,
                               atol=0.02 * np.abs(change).max())


@pytest.mark.system
@pytest.mark.parametrize('effects, tolerance', [
    ((), 0.0), ((WEAK,), 0.0), ((), 0.015), ((WEAK,), 0.015)])
def test_verdicts_as_with_white_noise(effects, tolerance):
    """
    With a tolerance, innovations are the evidence; they are made white first.

    White noise of the torque, ten times the torque itself, would explain them otherwise.
    """
    model = DriveModel()
    t = np.arange(10_000) * DT
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.2)).torque(t)
    y = simulate(replace(model, effects=effects), u, DT).x[:, :2]
    y = y + 0.004 * noise(PHI, 1, len(t), 2, seed=2)[0]
    data = diagnose([UniformRecording(t, u, y, DT)], replace(model, tolerance=tolerance),
                    only=['arm_coulomb', 'motor_viscous', 'transmission_damping']).data
    assert data['effect'] == ('arm_coulomb' if effects else None)
    assert data['verdict'] == ('effect' if effects else 'none')
    assert data['noise_time'] == pytest.approx([5e-3, 5e-3], rel=0.25)
    assert data['sigma'] == pytest.approx([4e-3, 4e-3], rel=0.15)
    assert any('lasts' in warning for warning in data['warnings'])
    if effects:
        assert data['params']['arm_coulomb']['Cac'] == pytest.approx(0.05, rel=0.15)
        assert data['standard_errors']['arm_coulomb']['Cac'] < 0.01


def decision_on(sigma, wrong=1.0, effects=(), count=1):
    """Return (decision, deviations of the noise drawn) on 4 s each; its level is `wrong` off."""
    t = np.arange(4000) * DT
    u = Excitation(amplitudes=(1.0, 0.5)).torque(t)
    clean = simulate(DriveModel().with_(effects=effects), u, DT).y
    drawn = [sigma * np.random.default_rng(4 + i).standard_normal(clean.shape)
             for i in range(count)]
    evidence = evidence_of([UniformRecording(t, u, clean + noise, DT) for noise in drawn],
                           DriveModel(), ['motor_viscous'])
    evidence = replace(evidence, sigma=wrong * evidence.sigma)
    return decide(evidence), np.concatenate([
        noise[part.span] for noise, part in zip(drawn, evidence.segments)]).std(axis=0)


def test_the_level_of_white_noise_is_that_of_the_innovations():
    """Of several recordings, fourth differences take the largest level."""
    for count in (1, 2):
        decision, drawn = decision_on(np.array([2e-3, 3e-3]), count=count)
        refined = with_level_of_innovations(decision)
        np.testing.assert_allclose(refined.recordings.sigma, drawn, rtol=4e-3)
        assert np.abs(decision.recordings.sigma / drawn - 1.0).max() > 8e-3
        # In it a right model leaves as much, but for the states in which its runs begin.
        assert typical_misfit(refined.runs) == pytest.approx(1.0, abs=8e-3)
        for run in chain(*refined.compared):  # the gaps before and after count in one level
            np.testing.assert_array_equal(run.data.sigma, refined.recordings.sigma)


@pytest.mark.parametrize('wrong, effects', [
    (1.2, ()), (1.0, ({'id': 'load_torque', 'TL': 0.1},))])
def test_a_level_stays_that_fourth_differences_exclude_or_beside_a_remainder(wrong, effects):
    decision, _ = decision_on(np.array([2e-3, 3e-3]), wrong, effects)
    assert decision.remains == bool(effects)
    np.testing.assert_array_equal(with_level_of_innovations(decision).recordings.sigma,
                                  decision.recordings.sigma)
