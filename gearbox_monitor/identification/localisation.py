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
Localisation: the place where a free signal explains the residual best, and when it acts.

Two encoders determine two free signals (window states aside): only at the place of the effect does
one signal explain both encoders.
"""
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.signal import savgol_filter

from gearbox_monitor.identification import basis_functions, likelihood, window_states
from gearbox_monitor.identification.input_estimation import (
    better_of, InputEstimate, InputEstimator, PLACES, QUARTERS, reduced_chi2, SENSORS, SPACING,
    taken_over, TORQUES, triangles)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.shooting import N_MEMORY
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array, Integers

THIRDS = ('low', 'mid', 'high')
REVERSAL = 0.05     # s around a change of sign of the motor's speed
BANDS = (3.0, 15.0)  # Hz, between low, mid and high frequency


def free_forms(search: Search, fitted: CandidateFit, jobs: int = 1,
               places: Sequence[str] = PLACES) -> dict[str, InputEstimate]:
    """
    Return {place: InputEstimate} on the long windows, on top of `fitted`.

    Quarters of the windows first: in them a wrong contact of the gap does not hold the fit.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit without effects.
        jobs: number of threads.
        places: places of the free signals.
    """
    long, point = search.long, fitted.point
    model = fitted.candidate.model(point.z)
    quarters = long.windows.parted(QUARTERS)
    short = replace(long, windows=quarters, train=np.ones(len(quarters), bool), weighing=None)
    states: Array
    memory: Array
    if fitted.smooth is None:
        states, memory = short.raw_states(), np.zeros((len(quarters), N_MEMORY))
    else:
        states, memory = np.split(fitted.smooth[quarters.begin], [4], axis=1)
    index = np.arange(len(quarters))
    states, _ = window_states.solve_states(short, model, states, memory, index)
    start_point = likelihood.FitPoint(point.z, states, memory)

    def one(place: str) -> InputEstimate:
        """Return the input estimate at `place`."""
        brief = InputEstimator(short, model, place, start_point)
        rough = brief.solve(states)
        fit = InputEstimator(long, model, place, point)
        started = taken_over(short.windows, rough.states, long.windows, point.states)
        series = np.zeros(len(search.recording.u))
        for first, values in zip(short.windows.first, rough.signal @ brief.basis[brief.lead:].T):
            series[first:first + short.windows.length] = values
        peaks = np.rint(np.arange(fit.basis.shape[1]) * SPACING / search.recording.dt).astype(int)
        peaks = np.minimum(long.windows.first[:, None] + peaks, len(series) - 1)
        # From nothing as well: over long windows rough values may lead astray.
        return better_of(fit.solve(started, series[peaks]), fit.solve(point.states))
    with ThreadPoolExecutor(jobs) as pool:
        return dict(zip(places, pool.map(one, places)))


def laws(search: Search, free: InputEstimate, moved: Mapping[str, Array],
         ) -> dict[str, basis_functions.Law]:
    """
    Return {name: Law} of a InputEstimate of the long windows over `moved` {name: values [W, L]}.

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
        moved: motion variables by name [W, L].
    """
    basis = triangles(search.long.windows.length, 0, search.recording.dt)
    out = {}
    for name, value in moved.items():
        edges_of = (basis_functions.edges_about_zero if 'speed' in name
                    else basis_functions.edges_of)
        edges = edges_of(value)
        out[name] = basis_functions.law(value, free.signal, free.precision, basis, edges)
    return out


def labels(search: Search, fitted: CandidateFit) -> dict[str, tuple[tuple[str, ...], Integers]]:
    """
    Return {region: (names, bin of each sample [W, L] of the long windows)}.

    Thirds hold a third of the samples each where values are spread enough.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit without effects.
    """
    recording, windows = search.recording, search.long.windows
    model, dt = search.model, recording.dt
    index = windows.first[:, None] + np.arange(windows.length)
    positions = search.long.positions(fitted.candidate.model(fitted.point.z), fitted.point)
    y = savgol_filter(positions, max(5, 2 * round(0.01 / dt) + 1), 2, axis=0)
    speed = np.gradient(savgol_filter(
        positions[:, 0], max(5, 2 * round(0.02 / dt) + 1), 2), dt)
    twist = y[:, 0] - y[:, 1]
    b = model.transmission.half_gap
    if recording.arm_torque is not None:
        load = np.abs(recording.arm_torque)
    else:
        load = model.transmission.stiffness * np.maximum(np.abs(twist) - b, 0.0)
    width = max(1, round(REVERSAL / dt))
    turns = np.flatnonzero(np.diff(np.sign(speed)) != 0)
    distance = np.full(len(speed), len(speed))
    for k in turns:
        distance[max(0, k - width):k + width + 1] = 0
    out: dict[str, tuple[tuple[str, ...], Integers]] = {}
    for name, value in (('speed', np.abs(speed)), ('angle', y[:, 1]), ('load', load),
                        ('time', np.arange(len(speed)) * dt)):
        value = value[index]
        out[name] = (THIRDS, np.searchsorted(np.quantile(value, [1 / 3, 2 / 3]), value))
    out['reversal'] = (('away', 'near'), (distance[index] == 0).astype(int))
    twist = twist[index]
    out['twist'] = (('gap', 'upper_flank', 'lower_flank'),
                    np.where(twist > b, 1, np.where(twist < -b, 2, 0)))
    return out


def _shares(power: Array, label: Integers, names: Sequence[str]) -> dict[str, float | None]:
    """Return {bin: share of power [W, L] in it}, None without power."""
    total = np.array([power[label == k].sum() for k in range(len(names))])
    total = np.clip(total, 0.0, None)
    return {n: float(v / total.sum()) if total.sum() > 0 else None for n, v in zip(names, total)}


def _bands(series: Array, dt: float) -> tuple[Array, Array]:
    """Return the power of series [W, L] in three bands, and the bands' share of frequencies."""
    spectrum = (np.abs(np.fft.rfft(series, axis=1)) ** 2).sum(axis=0)
    band = np.searchsorted(BANDS, np.fft.rfftfreq(series.shape[1], dt))
    return (np.array([spectrum[band == k].sum() for k in range(3)]),
            np.array([(band == k).mean() for k in range(3)]))


def region(search: Search, fitted: CandidateFit, free: InputEstimate) -> dict[str, dict[str, Any]]:
    """
    Return {region: {'time', 'residual', 'signal': {bin: share}, 'most': bin}}.

    time: share of the samples; residual: of the power of the residual of `fitted` beyond noise;
    signal: of the evidence for the InputEstimate `free`; most: where it is densest.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit without effects.
        free: free-form input estimate at the place found.
    """
    long, dt = search.long, search.recording.dt
    residual = long.parted(fitted.point.residual)
    power = (residual ** 2).sum(axis=2) - len(long.channels)
    basis = triangles(long.windows.length, 0, dt)
    strength = (free.evidence - 1.0) @ (basis / basis.sum(axis=0)).T
    out: dict[str, dict[str, Any]] = {}
    for name, (names, label) in labels(search, fitted).items():
        out[name] = {'time': _shares(np.ones_like(power), label, names),
                     'residual': _shares(power, label, names),
                     'signal': _shares(strength, label, names)}
    band_residual = np.zeros(3)
    for channel in range(len(long.channels)):
        bands, part = _bands(residual[:, :, channel], dt)
        noise = residual.shape[0] * residual.shape[1] * (residual.shape[1] // 2 + 1)
        band_residual += np.clip(bands - noise * part, 0.0, None)
    signal, _ = _bands(free.signal @ basis.T, dt)
    out['frequency'] = {
        'time': dict(zip(THIRDS, part.tolist())),
        'residual': dict(zip(THIRDS, (band_residual / max(band_residual.sum(), 1e-300)).tolist())),
        'signal': dict(zip(THIRDS, (signal / max(signal.sum(), 1e-300)).tolist()))}
    for shares in out.values():
        ratio = {k: (v or 0.0) / shares['time'][k] for k, v in shares['signal'].items()
                 if shares['time'][k]}
        shares['most'] = max(ratio, key=ratio.__getitem__)
    return out


def _explained_by(free: InputEstimate, columns: Array) -> float:
    """Return the share of the evidence for `free` that columns [W, H, C] explain."""
    weighted = np.einsum('wij,wjc->wic', free.precision, columns)
    gram = np.einsum('wic,wid->cd', columns, weighted)
    g = np.einsum('wic,wi->c', weighted, free.signal)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    step = scale * np.linalg.lstsq(gram * scale[:, None] * scale, g * scale, rcond=1e-12)[0]
    total = max(free.evidence.sum(), 1e-300)
    return float(np.clip(step @ g / total, 0.0, 1.0))


def command_or_motion(search: Search, free: InputEstimate) -> dict[str, float]:
    """
    Return the shares of the torque of `free` on the motor that simple laws explain.

    command: the torque u and its rate; motion: the motor's speed and its sign; constant. An effect
    of the actuator acts where one on the motor does; this tells them apart.

    Args:
        search: fits of all candidates to one recording.
        free: free-form input estimate.
    """
    recording, windows = search.recording, search.long.windows
    dt, width = recording.dt, max(3, 2 * round(0.5 * SPACING / recording.dt) + 1)
    speed = np.gradient(savgol_filter(recording.positions[:, 0], width, 2), dt)
    mean = np.ones(width) / width
    s = np.convolve(search.model.friction_side(speed), mean, 'same')
    u = np.convolve(recording.torque, mean, 'same')
    rate = np.gradient(u, dt)
    peaks = np.rint(np.arange(free.signal.shape[1]) * SPACING / dt).astype(int)
    at = np.minimum(windows.first[:, None] + peaks, len(u) - 1)
    return {name: _explained_by(free, np.stack(columns, axis=2)) for name, columns in (
        ('command', (u[at], rate[at])), ('motion', (speed[at], s[at])),
        ('constant', (np.ones(at.shape),)))}


def visible_places(search: Search) -> tuple[str, ...]:
    """
    Return the places that this drive and its encoders tell apart.

    Args:
        search: fits of all candidates to one recording.
    """
    # A motion that is put in takes no offset; one encoder alone takes whatever is asked of it.
    sensors = SENSORS if search.recording.motor is None else SENSORS[1:]
    both = len(search.long.channels) == 2
    if search.model.transmission.kind != 'rigid':
        return (*TORQUES, *sensors) if both or search.recording.motor is not None else TORQUES
    # Any torque moves both sides alike.
    return ('motor_side', *sensors) if both else ('motor_side',)


def places(search: Search, fitted: CandidateFit, jobs: int = 1) -> dict[str, Any]:
    """
    Return how much of the gap that `fitted` (none) leaves a free signal at each place explains.

    {'place': the best, 'location': its class, 'places': {place: {'left': chi2 per reading,
    'explained': share}}, 'margin': left of the second best over the best, 'actuator': see
    command_or_motion, 'region': see region}. Effects of the actuator show as motor_side; the
    location is 'actuator' where the torque that is missing there follows the command.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit without effects.
        jobs: number of threads.
    """
    estimates = free_forms(search, fitted, jobs, visible_places(search))
    size = fitted.point.residual.shape[1]
    chi2_before = float(fitted.point.chi2.sum())
    floor = size * len(fitted.point.chi2)
    table = {}
    for place, free in estimates.items():
        reduced = reduced_chi2(free)
        share = (chi2_before - reduced * floor) / max(chi2_before - floor,
                                                      1e-9) if chi2_before > floor else 0.0
        table[place] = {'left': reduced, 'explained': float(np.clip(share, 0.0, 1.0))}
    order = sorted(table, key=lambda p: table[p]['left'])
    laws = command_or_motion(search, estimates['motor_side'])
    actuator = order[0] == 'motor_side' and laws['command'] > max(
        laws['motion'], THRESHOLDS.command_share)
    return {'place': order[0], 'location': 'actuator' if actuator else order[0], 'places': table,
            'margin': table[order[1]]['left'] / table[order[0]]['left'] if order[1:] else 1.0,
            'actuator': laws,
            'region': region(search, fitted, estimates[order[0]])}


def signal_of(place: str) -> str:
    """Return the place at which a free signal stands for `place`."""
    return 'motor_side' if place == 'actuator' else place
