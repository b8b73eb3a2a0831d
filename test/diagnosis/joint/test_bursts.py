# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bursts: where they are to first order, and the load that they put on a likelihood."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.localisation import (
    InputEstimate, rectangles, SPACING, torque_of, triangles, with_bursts)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.uniform import UniformRecording

WINDOWS, SAMPLES, DT = 12, 1001, 1e-3
BASIS = triangles(SAMPLES, 0, DT)
VALUES = BASIS.shape[1]
PRECISION = np.tile(np.eye(VALUES), (WINDOWS, 1, 1))


def test_a_burst_is_the_interval_of_the_largest_likelihood_ratio():
    signal = 0.3 * np.random.default_rng(0).standard_normal((WINDOWS, VALUES))
    signal[5, 10:13] -= 8.0
    free = InputEstimate(signal, PRECISION, *np.zeros((2, WINDOWS)))
    bursts, windows, gains = rectangles(free, 20.0)
    assert windows.tolist() == [5] and len(bursts) == len(gains) == 1
    begin, duration, amplitude = bursts[0]
    assert begin == pytest.approx(9.5 * SPACING) and duration == pytest.approx(3 * SPACING)
    assert amplitude == pytest.approx(-8.0, abs=0.5)
    assert not len(rectangles(free, 1e4)[0])


def test_a_load_on_a_likelihood_is_that_of_a_recording_with_it():
    model, t = DriveModel(), np.arange(600) * DT
    bare = UniformRecording(t, np.sin(9.0 * t), np.zeros((600, 2)), DT)
    evidence = DriveRecordings((bare, replace(bare, arm_torque=0.1 * t)), model,
                               np.full(2, 1e-3), ())
    theta = np.array([[0.2, 0.1, 0.3], [0.4, 0.05, -0.2], [0.3, 0.1, 0.1]])
    owner, noise = np.array([0, 1, 1]), np.full(2, 0.01)
    beside = with_bursts(evidence, theta, owner).fine.run(model, noise).runs
    for i, (part, run) in enumerate(zip(evidence.fine.parts, beside)):
        loaded = part.changed(simulator=part.simulator.loaded(torque_of(
            theta[owner == i], part.recording))).run(model, noise)
        assert loaded.innovation == pytest.approx(run.innovation, abs=1e-15)
        assert np.abs(loaded.innovation - part.run(model, noise).innovation).max() > 1e-5
