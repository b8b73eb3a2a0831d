# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""How the torque acted between the stamps of a log is found, and effects are right."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal
from gearbox_monitor.diagnosis.joint.shooting import between_stamps
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.examples import ExampleMotion
from gearbox_monitor.signals.examine import admitted

MODEL, FAST, RATE, SECONDS = DriveModel(), 1000.0, 50.0, 8.0


def logged(model, controller_rate):
    """Return a log at RATE of a torque that a controller updates at its own rate."""
    t = np.arange(round(SECONDS * FAST)) / FAST
    plant = Plant(model, Noise(measurement=(5e-3, 5e-3)), 1)
    command = ExampleMotion(SECONDS, kind='varied').command(
        np.floor(t * controller_rate + 1e-9) / controller_rate, model)
    run, every = plant.run(command, 1.0 / FAST), round(FAST / RATE)
    recording, _ = admitted(run.t[::every], run.u[::every], run.y[::every], None, 'log',
                            MODEL, 'model')
    return recording


def test_the_mean_torque_of_a_sampled_one_is_that_of_its_interpolation():
    recording = logged(MODEL, FAST)
    t = np.arange(round(SECONDS * FAST)) / FAST
    true = ExampleMotion(SECONDS, kind='varied').command(t, MODEL).reshape(-1, 5).mean(axis=1)
    mean = between_stamps(replace(recording, shift=0.5 * RATE / FAST), 4)
    assert np.std((mean - true)[8:-8]) < 2e-3 < np.std(np.repeat(recording.u, 4) - true) / 50


@pytest.mark.system
def test_a_healthy_drive_and_a_wider_gap_at_50_hz():
    only = ['backlash_gap', 'motor_viscous', 'lugre']
    for controller_rate in (FAST, RATE):
        assert diagnose([logged(MODEL, controller_rate)], MODEL, only=only).verdict == 'none'
    verdict = diagnose([logged(MODEL.with_(half_gap=0.15), FAST)], MODEL, only=only)
    assert verdict.effect == 'backlash_gap'
    assert verdict.params['backlash_gap']['b'] == pytest.approx(0.15, rel=0.01)
    assert verdict.to_dict()['not_tried']['lugre'] == '50 samples/s do not show it'


def test_values_of_a_model_at_50_hz():
    fit = fit_nominal([logged(MODEL, FAST)], MODEL.with_(viscous_friction=0.15),
                      ['Cv', 'Cc', 'm2'])
    assert {v.name: v.value for v in fit.values} == pytest.approx(
        {'Cv': 0.1, 'Cc': 0.27, 'm2': 0.023454}, rel=0.01)


def test_a_position_half_a_sample_ahead_is_no_gap():
    # Semi-implicit steps as long as a sample: positions lead those of any exact simulator.
    rigid = DriveModel().with_(
        transmission={'kind': 'rigid'}, motor_inertia=0.023, arm_inertia=0.023,
        viscous_friction=0.4, coulomb_friction=0.0, damping=0.0, tolerance=0.05)
    own = rigid.with_(integrator='implicitfast', timestep=1.0 / FAST,
                      friction_law={'kind': 'ode'})
    t = np.arange(round(0.5 * SECONDS * FAST)) / FAST
    run = Plant(own, Noise(measurement=(5e-3, 5e-3)), 1).run(
        ExampleMotion(SECONDS, kind='varied').command(t, own), 1.0 / FAST)
    y = np.column_stack([run.y[:, 0], np.full(len(t), np.nan)])
    recording, _ = admitted(run.t, run.u, y, None, 'log', rigid, 'model')
    verdict = diagnose([recording], rigid, only=['motor_viscous', 'torque_offset'])
    assert verdict.verdict == 'none'


def test_a_motion_that_is_put_in_needs_a_faster_log_and_says_so():
    driven = MODEL.with_(driven_by='position', process_torque_time=0.3)
    with pytest.raises(InputError, match='expected 200 to 4000 with driven_by: position.*log '
                       'faster, or state driven_by: torque'):
        admitted(*_columns(), 'log', driven, 'model')


def _columns():
    t = np.arange(round(SECONDS * 100.0)) / 100.0
    y = np.column_stack([np.sin(3.0 * t), np.sin(3.0 * t)])
    return t, np.cos(3.0 * t), y, None
