# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The types of results, for mypy (setup.cfg), which fails where one is another or Any."""
from typing import assert_type

from gearbox_monitor.diagnosis.joint.nominal import Adapted, NominalFit
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.library.estimation import (
    backlash, BacklashWindows, estimate, RecordingEstimates)
from gearbox_monitor.library.identify import adapt, diagnose, Diagnosis, fit, tune, TunedParameters
from gearbox_monitor.library.recording import DriveRecording, load_recording
from gearbox_monitor.library.robot import load_robot, watch_robot
from gearbox_monitor.library.simulator_file import export_model, load_model, SimulatorFile
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.watch.record import Watch


def results(path: str) -> None:
    """Use the public functions as a user does, on the files below `path`."""
    model = assert_type(load_model(path), DriveModel)
    run: DriveRecording = load_recording(path, model)
    estimates: Estimates = assert_type(estimate(run, tau_k_model='mixed'), RecordingEstimates)
    assert_type(estimates.codes.size, int)
    assert_type(backlash(run), BacklashWindows)
    verdict = assert_type(diagnose([run], model), Diagnosis)
    assert_type(verdict.findings[0].effect, str)
    assert_type(verdict.model, DriveModel)
    assert_type(fit(run, verdict.model, ['Cv']), NominalFit)
    assert_type(tune(run), TunedParameters)
    assert_type(adapt([run], model), Adapted)
    assert_type(export_model(verdict.model, 'mjcf', path, joint='elbow'), SimulatorFile)
    assert_type(diagnose(path, load_robot(path)), Diagnosis)
    assert_type(watch_robot([path]), Watch)
