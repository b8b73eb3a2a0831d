# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What recordings say before any fit: scales, encoder noise, and the torque noise allowed."""
import numpy as np
import pytest

from gearbox_monitor.identification.evidence import evidence_of
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.recording import UniformRecording

DT, SIGMA = 1e-3, np.array([1e-3, 3e-3])
MODEL = DriveModel()


def recording(size=1.0, quantum=0.0, seed=0):
    """Return 2 s; `size`: of the motion, `quantum`: step of the motor encoder, rad."""
    t = np.arange(2000) * DT
    motion = size * np.column_stack([np.sin(9.0 * t), 0.8 * np.sin(9.0 * t + 0.1)])
    y = motion + SIGMA * np.random.default_rng(seed).standard_normal(motion.shape)
    if quantum:
        y[:, 0] = quantum * np.rint(y[:, 0] / quantum)
    return UniformRecording(t, 3.0 * size * np.sin(7.0 * t), y, DT)


def evidence(*recordings, model=MODEL, ids=('gravity',)):
    return evidence_of(recordings, model, ids)


def test_scales_are_those_of_all_recordings_together():
    both = evidence(recording(), recording(2.0))
    torque = np.concatenate([r.torque for r in both.recordings])
    assert both.torque == pytest.approx(np.std(torque))
    twist = np.std(recording(2.0).y @ [1.0, -1.0])
    np.testing.assert_allclose(both.scales, [both.torque, twist], rtol=1e-6)
    np.testing.assert_allclose(both.sigma, SIGMA, rtol=0.1)


@pytest.mark.parametrize('changes, share', [
    ({}, 0.0), ({'tolerance': 0.1}, THRESHOLDS.torque_noise),
    ({'process_torque': 1e-3}, THRESHOLDS.torque_noise),
    ({'process_torque_time': 0.5}, THRESHOLDS.lasting_torque)])
def test_torque_noise_is_allowed_where_the_model_file_says_that_it_is_not_exact(changes, share):
    judged = evidence(recording(), model=MODEL.with_(**changes))
    assert judged.noisy == (share > 0.0)
    np.testing.assert_allclose(judged.allowed_noise, np.maximum(
        judged.whole.least_noise, share * judged.torque))


def test_a_stated_torque_noise_is_allowed_in_full():
    np.testing.assert_allclose(
        evidence(recording(), model=MODEL.with_(process_torque=5.0)).allowed_noise, 5.0)


@pytest.mark.parametrize('step, rough', [(0.5, False), (2.0, True)])
def test_an_encoder_is_rough_by_its_step_in_deviations_of_its_noise(step, rough):
    """In units of the threshold; 4 deviations of the white noise are 2.6 of it with rounding."""
    quantum = step * THRESHOLDS.rough_lattice * SIGMA[0]
    assert evidence(recording(quantum=quantum)).rough == rough


def test_a_map_of_the_torque_is_tried_where_it_is_asked_for_and_the_model_has_none():
    asked = ('gravity', 'torque_map')
    other = MODEL.with_(effects=[{'id': 'gravity', 'G': 1.0}])
    tried = evidence(recording(), ids=asked)
    assert tried.with_map and tried.ids == ('gravity',)
    assert evidence(recording(), model=other, ids=asked).with_map
    assert not evidence(recording()).with_map
