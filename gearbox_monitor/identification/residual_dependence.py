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
Dependence of the residual on the motion: a law that no effect of the library describes.

White noise is a function of nothing. If a free function of speed, angle, twist or torque reduces
the residual by more than chance, the model is incomplete, however small the residual is.
"""
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import savgol_filter

from gearbox_monitor.identification import (
    basis_functions, input_estimation, likelihood, localisation)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.search import Search
from gearbox_monitor.kernels.types import Array

VALUES = 6       # of a free function, interpolated linearly
TAIL = 1.0       # percent of the samples beyond the outermost value, on either end
PROBE = 1e-2     # of the torque's standard deviation
SMOOTHING = 0.02  # s, of rates
LAWS = (('motor_side', 'speed of the motor'), ('motor_side', 'angle of the motor'),
        ('actuator', 'torque'), ('actuator', 'rate of the torque'),
        ('arm_side', 'speed of the arm'), ('arm_side', 'angle of the arm'),
        ('transmission', 'twist'), ('transmission', 'rate of the twist'),
        ('transmission', 'speed of the motor'), ('transmission', 'angle of the arm'),
        ('motor_sensor', 'angle of the motor'), ('arm_sensor', 'angle of the arm'))
# What repeats with every turn is too fine for VALUES over many of them: as many of a wave.
TURNS = (('motor_side', 'angle of the motor in its turn'),
         ('arm_side', 'angle of the arm in its turn'),
         ('transmission', 'angle of the motor in its turn'),
         ('transmission', 'angle of the arm in its turn'),
         ('motor_sensor', 'angle of the motor in its turn'),
         ('arm_sensor', 'angle of the arm in its turn'))


@dataclass(frozen=True)
class ResidualDependence:
    """A free function at `place` of the quantity `over` lowers chi2 by `gain`, by chance by 6."""

    place: str
    over: str
    gain: float


def strongest_dependence(search: Search, fitted: CandidateFit,
                         modelled: bool = False) -> ResidualDependence:
    """
    Return the dependence with the largest gain beyond `fitted`, its own parameters refitted.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        modelled: whether the motion is that of the model: noise of the readings is part of the
            residual and would correlate with the measured motion.
    """
    data, point = search.long, fitted.point
    candidate = fitted.candidate
    weight = likelihood.weights(data, point.chi2, True)
    own = likelihood.sensitivity(data, candidate, point)
    _, prior = candidate.prior(point.z)
    positions = data.positions(candidate.model(point.z), point)
    moved = motion_of(search, _modelled(search, fitted, positions) if modelled else positions)
    visible = localisation.visible_places(search)

    def gain(place: str, over: str) -> float:
        """Return the gain in chi2 of a free function at `place` of the variable `over`."""
        if place in input_estimation.SENSORS:
            columns = _sensor_columns(search, fitted, place, over)
        else:
            columns = _torque_columns(search, fitted, place, moved[over], over)
        return likelihood.linear_gain(own, columns, point.residual, weight, prior)
    dependences = [ResidualDependence(place, over, gain(localisation.signal_of(place), over))
                   for place, over in (LAWS if search.model.axis == 'prismatic' else LAWS + TURNS)
                   if localisation.signal_of(place) in visible]
    return max(dependences, key=lambda r: r.gain)


def _modelled(search: Search, fitted: CandidateFit, positions: Array) -> Array:
    """Return positions [N, 2] as `fitted` has them; where there is no window, those read."""
    data = search.long
    y, positions = _readings(data, fitted), positions.copy()
    for first, rows in zip(data.windows.first, y):
        positions[first:first + len(rows), data.channels] = rows
    return positions


def _readings(data: likelihood.WindowData, fitted: CandidateFit) -> Array:
    """Return what the encoders would read without noise [W, L, C]."""
    point = fitted.point
    r, _ = data.uncoloured().residual(fitted.candidate.model(point.z), point.states, point.memory)
    return data.y - data.parted(r) * data.sigma[data.channels]


def motion_of(search: Search, positions: Array) -> dict[str, Array]:
    """
    Return {quantity: values [N]} of the motion.

    Args:
        search: fits of all candidates to one recording.
        positions: of motor and arm [N, 2], rad.
    """
    recording = search.recording
    dt = recording.dt
    motor, arm = (basis_functions.motion(positions[:, order], dt, recording.cuts)
                  for order in ([0, 1], [1, 0]))
    width = max(3, 2 * round(0.5 * SMOOTHING / dt) + 1)
    # A servo makes its torque of the position: the noise of that is part of the residual, too.
    torque = replace(recording, y=positions).with_servo(search.model.controller).torque
    return {'speed of the motor': motor['speed'], 'speed of the arm': arm['speed'],
            'angle of the motor': arm['angle'], 'angle of the arm': motor['angle'],
            'angle of the motor in its turn': arm['angle'],
            'angle of the arm in its turn': motor['angle'],
            'twist': motor['twist'], 'rate of the twist': motor['speed'] - arm['speed'],
            'torque': torque,
            'rate of the torque': savgol_filter(torque, width, 2, deriv=1, delta=dt)}


def _values(x: Array, over: str) -> Array:
    """Return x [...] as weights [..., VALUES] of a free function of the quantity `over`."""
    if over.endswith('turn'):
        waves = x[..., None] * np.arange(1, VALUES // 2 + 1)
        return np.concatenate([np.sin(waves), np.cos(waves)], axis=-1)
    if 'speed' in over or 'rate' in over:  # values are closest about 0
        share = np.linspace(-1.0, 1.0, VALUES)
        knots = np.percentile(np.abs(x), 100.0 - TAIL) * np.sign(share) * np.abs(share) ** 1.5
    else:
        knots = np.percentile(x, np.linspace(TAIL, 100.0 - TAIL, VALUES))
    knots = knots + np.arange(VALUES) * (1e-9 * np.ptp(knots) + 1e-12)  # they must rise
    return np.stack([np.interp(x, knots, row) for row in np.eye(VALUES)], axis=-1)


def _torque_columns(search: Search, fitted: CandidateFit, place: str, x: Array,
                    over: str) -> Array:
    """Return d(-residual)/d(values) [W, C L, VALUES] of a torque that is a function of x [N]."""
    data, point = search.long, fitted.point
    model = fitted.candidate.model(point.z)
    step = PROBE * max(float(np.std(search.recording.torque)), 1e-9)
    out = []
    for column in _values(x, over).T:
        extra = data.simulator.extra.copy()
        extra[:, input_estimation.TORQUES.index(place)] += step * column
        r, _ = data.residual(model, point.states, point.memory, extra=extra)
        out.append((point.residual - r) / step)
    return np.stack(out, axis=2)


def _sensor_columns(search: Search, fitted: CandidateFit, place: str, over: str) -> Array:
    """Return d(-residual)/d(values) [W, C L, VALUES] of an offset that is one of the angle."""
    data, point = search.long, fitted.point
    sensor = input_estimation.SENSORS.index(place)
    at = data.channels.index(sensor)
    # Where the model says that it is: the reading's own noise would be part of both.
    angle = _readings(data, fitted)[:, :, at]
    out = np.zeros((*point.residual.shape, VALUES))
    offsets = _values(angle, over) / data.sigma[sensor]
    out[:, at::len(data.channels)] = data.white(offsets, [sensor])
    return out
