# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.


"""
Windows that begin in the smoothed states of a filter, instead of in lines through the readings.

A drive that sticks and slips forgets nothing: 1e-5 rad grow some thousandfold within a window of
1 s, so that its best initial state is not found from afar. The smoother knows it to a fraction of
the noise, from all readings before and after.
"""
import numpy as np

from gearbox_monitor.identification import likelihood, window_states
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.innovation_fit import evaluated, fitted
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import FitPoint, WindowData
from gearbox_monitor.identification.shooting import ShootingWindows
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.transmission import DEAD_ZONE, KINDS
from gearbox_monitor.quality.recording import UniformRecording

TORQUE = 0.05  # torque noise to begin with, of the standard deviation of the torque


def filterable(recording: UniformRecording, model: DriveModel) -> bool:
    """
    Return whether the filter of the innovations knows a drive and how it is driven.

    Args:
        recording: recording of the drive.
        model: model of the drive.
    """
    return (recording.motor is None and model.process_torque_time == 0.0
            and KINDS.index(model.transmission.kind) == DEAD_ZONE
            and all(effect['id'] in EFFECTS for effect in model.effects))


def states_of(windows: ShootingWindows, z: Array, smooth: Array) -> FitPoint:
    """
    Return the FitPoint, not evaluated, of windows that begin in smoothed states.

    Args:
        windows: to begin.
        z: coordinates [P].
        smooth: smoothed states [N, N_STATE].
    """
    return FitPoint(z.copy(), smooth[windows.begin, :4].copy(), smooth[windows.begin, 4:].copy())


def smoothed_point(data: WindowData, candidate: CandidateModel, z: Array,
                   smooth: Array) -> FitPoint:
    """
    Return the evaluated FitPoint whose window states are fitted from smoothed ones.

    On the beginnings of the windows first, which get longer.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model with its coordinates.
        z: coordinates [P].
        smooth: smoothed states [N, N_STATE].
    """
    point, model = states_of(data.windows, z, smooth), candidate.model(z)
    index = np.arange(len(data.windows))
    begun = point.states
    for share in window_states.SHARES:
        point.states, chi2 = window_states.solve_states(
            likelihood.shortened(data, share), model, point.states, point.memory, index)
    if len(data.channels) == 1:
        # The beginning of a window says little of a side that no encoder reads.
        states, at_once = window_states.solve_states(data, model, begun, point.memory, index)
        better = at_once < chi2
        point.states[better] = states[better]
    return data.evaluate(candidate, point)


def fitted_point(data: WindowData, candidate: CandidateModel) -> FitPoint:
    """
    Return the evaluated FitPoint of a candidate, fitted from its start with its torque noise.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model with its coordinates.
    """
    filter_ = InnovationLikelihood(data.recording, candidate.nominal, data.sigma,
                                   data.recording.segments)
    torque = np.full(2, TORQUE * max(float(np.std(data.recording.u)), 1e-3))
    fit = fitted(filter_, evaluated(filter_, candidate, candidate.start(), torque))
    run = filter_.run(candidate.model(fit.z), fit.torque)
    return smoothed_point(data, candidate, fit.z, filter_.smoothed(run))
