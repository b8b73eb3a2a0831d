# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Localisation: the place where a free signal explains the residual best, and when it acts.

The free signal is an arbitrary input at one place, estimated in each window.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint import basis_functions
from gearbox_monitor.diagnosis.joint.effect_scan import Dependence
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import StateProblems, WindowRuns
from gearbox_monitor.kernels.linear_least_squares import Damping, minimise, solution
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel

SPACING = 0.04      # s between the peaks of the triangles
ITERATIONS = 10
LEAST_GAIN = 1e-4   # of the cost of a window, for another iteration
# Many attempts: a contact of the gap that is lost makes long steps useless.
RULE = Damping(1e-6, 30.0, 1e-4, attempts=8, absolute=1e-9)
TORQUES = ('motor_side', 'arm_side', 'transmission')   # in the order of Simulator.run's extra
SENSORS = ('motor_sensor', 'arm_sensor')
PLACES = (*TORQUES, *SENSORS)


def torque_places(model: DriveModel) -> tuple[str, ...]:
    """Return the places at which a torque can act in the drive of `model`."""
    # In a rigid drive any torque moves both sides alike.
    return TORQUES if model.transmission.kind != 'rigid' else TORQUES[:1]


@dataclass(frozen=True, eq=False)
class InputEstimate:
    """
    A free signal at one place, fitted to all windows.

    signal [W, H] N m or rad at the peaks of the triangles, precision [W, H, H] its inverse
    covariance by sensor noise; chi2 [W] of the rest; freedom [W]: readings less the numbers that
    the signal and the states amount to, by what the readings say of them.
    """

    signal: Array
    precision: Array
    chi2: Array
    freedom: Array

    @property
    def evidence(self) -> Array:
        """Gain in chi2 that each value of the signal brings [W, H]; 1 on average by noise."""
        return self.signal * np.einsum('wij,wj->wi', self.precision, self.signal)


def triangles(length: int, lead: int, dt: float) -> Array:
    """
    Return the basis [lead + length, H]; before the window's first sample the first one holds.

    Rows sum to 1: linear interpolation between values SPACING s apart.

    Args:
        length: samples of a window.
        lead: samples that a run starts before its window.
        dt: sample time, s.
    """
    count = math.ceil((length - 1) * dt / SPACING - 1e-9) + 1
    at = np.clip((np.arange(lead + length) - lead) * dt, 0.0, None)
    at = np.minimum(at / SPACING, count - 1.0)
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(count)))


class InputEstimator(StateProblems):
    """
    Windows of `runs` with a free signal at one place: theta [W, H + 4] is signal and states.

    count: number H of values of the signal.
    """

    def __init__(self, runs: WindowRuns, place: str) -> None:
        super().__init__(runs.data, runs.model, runs.memory)
        self.states = runs.states
        windows, dt = runs.data.windows, runs.recording.dt
        lead = int((windows.first - windows.begin).max(initial=0))
        self.basis = triangles(windows.length, lead, dt)
        self.count = self.basis.shape[1]
        values = runs.recording.torque
        if place in TORQUES:
            # Windows begin in their neighbours: each has a torque of its own.
            rows = windows.begin[:, None] + np.arange(len(self.basis))
            extra = self.data.simulator.extra
            self.extra = extra[np.minimum(rows, len(extra) - 1)]
            shift = (lead - windows.first + windows.begin)[:, None]
            self.at = np.minimum(np.arange(len(self.basis)) + shift, len(self.basis) - 1)
            self.torque = TORQUES.index(place)
        else:
            sensor, channels = SENSORS.index(place), runs.data.channels
            values = runs.recording.y[:, sensor]
            known = np.zeros((windows.length, len(channels), self.count))
            known[:, channels.index(sensor)] = runs.data.white(
                self.basis[None, lead:] / runs.data.sigma[sensor], [sensor])[0]
            self.known = known.reshape(-1, self.count)
        self.scale = max(float(np.std(values)), 1e-9)
        self.steps = np.concatenate([np.full(self.count, 1e-3 * self.scale), self.steps])
        self.gram = np.empty((len(windows), self.count + 4, self.count + 4))

    def residual(self, theta: Array, index: Integers) -> Array:
        """Return the residual [M, L, C] of the windows `index` [M] at `theta` [M, H + 4]."""
        signal, states = np.split(theta, [self.count], axis=1)
        if self.known is not None:
            residual = super().residual(states, index)
            return residual - (signal @ self.known.T).reshape(residual.shape)
        extra = self.extra[index]
        extra[:, :, self.torque] += np.take_along_axis(
            signal @ self.basis.T, self.at[index], axis=1)
        return self.data.residual(self.model, states, self.memory[index], index, extra)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        self.gram[index], pull = super().linearised(theta, residual, index)
        return self.gram[index], pull

    def solve(self) -> InputEstimate:
        """Return the InputEstimate, by Levenberg-Marquardt with a damping for each window."""
        windows, count = len(self.states), self.count
        ridge = np.zeros(count + 4)
        ridge[:count] = self.scale ** -2  # weak: for values that the readings say nothing of
        both, residual, _ = minimise(
            self, np.hstack([np.zeros((windows, count)), self.states]), RULE, LEAST_GAIN,
            RULE.attempts * ITERATIONS, ITERATIONS, np.tile(ridge, (windows, 1)))
        A = self.gram + np.diag(ridge)
        own, cross, inner = A[:, :count, :count], A[:, :count, count:], A[:, count:, count:]
        precision = own - np.diag(ridge[:count]) - cross @ np.linalg.solve(
            inner + 1e-9 * np.eye(4), cross.transpose(0, 2, 1))
        # What the ridge holds is no unknown.
        share = np.linalg.solve(precision + ridge[0] * np.eye(count), precision)
        freedom = residual.shape[1] - 4.0 - np.einsum('wii->w', share)
        return InputEstimate(both[:, :count], precision,
                             np.einsum('wl,wl->w', residual, residual), freedom)


def reduced_chi2(estimates: Sequence[InputEstimate]) -> float:
    """
    Return chi2 per reading that is left, geometric mean of windows: one stuck counts less.

    Args:
        estimates: of a free signal at one place, in each recording.
    """
    per_reading = np.concatenate([np.maximum(free.chi2 / free.freedom, 1e-300)
                                  for free in estimates])
    return float(np.exp(np.mean(np.log(per_reading))))


THIRDS = ('low', 'mid', 'high')
REVERSAL = 0.05     # s around a change of sign of the motor's speed
BANDS = (3.0, 15.0)  # Hz, between low, mid and high frequency
DECIDING = 10     # windows of a single recording that decide on a place
ILLUSTRATING = 6  # windows of each recording, if an effect names the place


def free_forms(runs: WindowRuns, places: Sequence[str]) -> dict[str, InputEstimate]:
    """
    Return {place: InputEstimate} on the windows of one recording, on top of free runs.

    Args:
        runs: of the model that lacks something.
        places: places of the free signals.
    """
    return {place: InputEstimator(runs, place).solve() for place in places}


def laws(runs: WindowRuns, free: InputEstimate,
         moved: Mapping[str, Array]) -> dict[str, basis_functions.Law]:
    """
    Return {name: Law} of a InputEstimate over `moved` {name: values [W, L]}.

    Args:
        runs: of the model that lacks something.
        free: free-form input estimate.
        moved: motion variables by name [W, L].
    """
    basis = triangles(runs.data.windows.length, 0, runs.recording.dt)
    return {name: basis_functions.law(value, free.signal, free.precision, basis,
                                      basis_functions.edges_over(name, value))
            for name, value in moved.items()}


def _motion(runs: WindowRuns) -> tuple[dict[str, Array], Flags]:
    """Return ({quantity: values [W, L]}, whether a reversal is near [W, L]) of a recording."""
    recording, gear, index = runs.recording, runs.model.transmission, runs.data.windows.samples
    moved = basis_functions.motion(runs.positions, recording.dt)
    turns = np.diff(np.sign(moved['speed']), prepend=0.0) != 0
    width = 2 * max(1, round(REVERSAL / recording.dt)) + 1
    moved['speed'] = np.abs(moved['speed'])
    moved['load'] = gear.stiffness * np.maximum(
        np.abs(moved['twist']) - gear.half_gap, 0.0) if recording.arm_torque is None else np.abs(
            recording.arm_torque)
    return ({name: value[index] for name, value in moved.items()},
            scipy.ndimage.maximum_filter1d(turns, width)[index])


def labels(runs: Sequence[WindowRuns]
           ) -> dict[str, tuple[tuple[str, ...], list[Integers]]]:
    """
    Return {region: (names, bin of each sample [W, L] of the windows of each recording)}.

    Thirds hold a third of the samples of all recordings each, where values are spread enough.

    Args:
        runs: without effects, of each recording.
    """
    motions = [_motion(run) for run in runs]
    out: dict[str, tuple[tuple[str, ...], list[Integers]]] = {}
    for name in ('speed', 'angle', 'load', 'time'):
        limits = np.quantile(np.concatenate([moved[name].ravel() for moved, _ in motions]),
                             [1 / 3, 2 / 3])
        out[name] = (THIRDS, [np.searchsorted(limits, moved[name]) for moved, _ in motions])
    out['reversal'] = (('away', 'near'), [closeness.astype(int) for _, closeness in motions])
    b = runs[0].model.transmission.half_gap
    out['twist'] = (('gap', 'upper_flank', 'lower_flank'), [
        np.where(moved['twist'] > b, 1, np.where(moved['twist'] < -b, 2, 0))
        for moved, _ in motions])
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


def region(runs: Sequence[WindowRuns],
           estimates: Sequence[InputEstimate]) -> dict[str, dict[str, Any]]:
    """
    Return {region: {'time', 'residual', 'signal': {bin: share}, 'most': bin}}.

    time: share of the samples; residual: of the power of the residual beyond noise; signal: of the
    evidence for the free signal; most: where it is densest.

    Args:
        runs: without effects, of each recording.
        estimates: free-form input at the place, in each recording.
    """
    powers, strengths = [], []
    band_residual, band_signal, parts = np.zeros(3), np.zeros(3), np.zeros(3)
    for run, free in zip(runs, estimates):
        residual, dt = run.residual, run.recording.dt
        powers.append((residual ** 2).sum(axis=2) - residual.shape[2])
        basis = triangles(run.data.windows.length, 0, dt)
        strengths.append((free.evidence - 1.0) @ (basis / basis.sum(axis=0)).T)
        for channel in range(residual.shape[2]):
            bands, part = _bands(residual[:, :, channel], dt)
            noise = residual.shape[0] * residual.shape[1] * (residual.shape[1] // 2 + 1)
            band_residual += np.clip(bands - noise * part, 0.0, None)
        bands, part = _bands(free.signal @ basis.T, dt)
        band_signal, parts = band_signal + bands, parts + part / len(runs)
    power, strength = (np.concatenate([row.ravel() for row in rows])
                       for rows in (powers, strengths))
    out: dict[str, dict[str, Any]] = {}
    for name, (names, bins) in labels(runs).items():
        label = np.concatenate([row.ravel() for row in bins])
        out[name] = {'time': _shares(np.ones_like(power), label, names),
                     'residual': _shares(power, label, names),
                     'signal': _shares(strength, label, names)}
    out['frequency'] = {
        'time': dict(zip(THIRDS, parts.tolist())),
        'residual': dict(zip(THIRDS, (band_residual / max(band_residual.sum(), 1e-300)).tolist())),
        'signal': dict(zip(THIRDS, (band_signal / max(band_signal.sum(), 1e-300)).tolist()))}
    for shares in out.values():
        ratio = {k: (v or 0.0) / shares['time'][k] for k, v in shares['signal'].items()
                 if shares['time'][k]}
        shares['most'] = max(ratio, key=ratio.__getitem__)
    return out


def _products(free: InputEstimate, columns: Array) -> tuple[Array, Array]:
    """Return the normal equations (gram [C, C], pull [C]) of a signal by columns [W, H, C]."""
    weighted = np.einsum('wij,wjc->wic', free.precision, columns)
    return (np.einsum('wic,wid->cd', columns, weighted),
            np.einsum('wic,wi->c', weighted, free.signal))


def command_or_motion(runs: Sequence[WindowRuns],
                      estimates: Sequence[InputEstimate]) -> dict[str, float]:
    """
    Return the shares of the torque missing on the motor that simple laws explain.

    command: the torque u and its rate; motion: the motor's speed and its sign; constant. An effect
    of the actuator acts where one on the motor does; this tells them apart.

    Args:
        runs: without effects, of each recording.
        estimates: free-form torque on the motor, in each recording.
    """
    sums: dict[str, tuple[Array, Array]] = {}
    total = 1e-300
    for run, free in zip(runs, estimates):
        recording, windows, dt = run.recording, run.data.windows, run.recording.dt
        width = max(3, 2 * round(0.5 * SPACING / dt) + 1)
        speed = basis_functions.slope(recording.positions[:, 0], dt)
        mean = np.ones(width) / width
        s = np.convolve(run.model.friction_side(speed), mean, 'same')
        u = np.convolve(recording.torque, mean, 'same')
        rate = np.gradient(u, dt)
        peaks = np.rint(np.arange(free.signal.shape[1]) * SPACING / dt).astype(int)
        at = np.minimum(windows.first[:, None] + peaks, len(u) - 1)
        total += float(free.evidence.sum())
        for name, columns in (('command', (u[at], rate[at])), ('motion', (speed[at], s[at])),
                              ('constant', (np.ones(at.shape),))):
            gram, pull = _products(free, np.stack(columns, axis=2))
            previous = sums.get(name, (0.0, 0.0))
            sums[name] = gram + previous[0], pull + previous[1]
    out = {}
    for name, (gram, pull) in sums.items():
        out[name] = float(np.clip(solution(gram, pull) @ pull / max(total, 1e-300), 0.0, 1.0))
    return out


def visible_places(runs: WindowRuns) -> tuple[str, ...]:
    """Return the places that drive and encoders of the recording of `runs` tell apart."""
    recording = runs.recording
    # A motion that is put in takes no offset; one encoder alone takes whatever is asked of it.
    sensors = SENSORS if recording.motor is None else SENSORS[1:]
    both = len(recording.channels) == 2
    if runs.model.transmission.kind != 'rigid':
        return (*TORQUES, *sensors) if both or recording.motor is not None else TORQUES
    # Any torque moves both sides alike.
    return ('motor_side', *sensors) if both else ('motor_side',)


NOWHERE: Mapping[str, Any] = {'place': 'none', 'location': 'none', 'places': {}, 'margin': 1.0,
                              'actuator': {}, 'region': {}}


def some_windows(runs: WindowRuns, most: int) -> WindowRuns:
    """
    Return at most so many windows of a recording, evenly spread.

    Where enough windows lack something, only they say where.

    Args:
        runs: of the model that lacks something.
        most: number of windows.
    """
    data = runs.data
    if len(data.windows) <= most:
        return runs
    lacking = np.flatnonzero(runs.chi2 > THRESHOLDS.quiet * data.size)
    if len(lacking) < most:
        lacking = np.arange(len(data.windows))
    return runs.take(lacking[np.linspace(0, len(lacking) - 1, most).round().astype(int)])


def places(runs: Sequence[WindowRuns], illustrates: bool = False) -> dict[str, Any]:
    """
    Return how much of the gap that `runs` leave a free signal at each place explains.

    {'place': the best, 'location': its class, 'places': {place: {'left': chi2 per reading,
    'explained': share}}, 'margin': left of the second best over the best, 'actuator': see
    command_or_motion, 'region': see region}. Effects of the actuator show as motor_side; the
    location is 'actuator' where the torque that is missing there follows the command. What a
    recording cannot tell apart is what all recordings tell.

    Args:
        runs: without effects, of each recording.
        illustrates: whether the place is known otherwise: fewer windows do.
    """
    limit = ILLUSTRATING if illustrates else max(DECIDING // len(runs), ILLUSTRATING)
    runs = [some_windows(run, limit) for run in runs]
    visible = [place for place in PLACES if all(place in visible_places(run) for run in runs)]
    estimates = [free_forms(run, visible) for run in runs]
    chi2_before = sum(float(run.chi2.sum()) for run in runs)
    floor = sum(run.data.size * len(run.chi2) for run in runs)
    table = {}
    for place in visible:
        reduced = reduced_chi2([estimate[place] for estimate in estimates])
        share = (chi2_before - reduced * floor) / max(chi2_before - floor,
                                                      1e-9) if chi2_before > floor else 0.0
        table[place] = {'left': reduced, 'explained': float(np.clip(share, 0.0, 1.0))}
    order = sorted(table, key=lambda p: table[p]['left'])
    shares = command_or_motion(runs, [estimate['motor_side'] for estimate in estimates])
    return {'place': order[0], 'location': _location(order[0], shares), 'places': table,
            'margin': table[order[1]]['left'] / table[order[0]]['left'] if order[1:] else 1.0,
            'actuator': shares,
            'region': region(runs, [estimate[order[0]] for estimate in estimates])}


def _location(place: str, shares: Mapping[str, float]) -> str:
    """Return the location of a free signal at `place`; shares: see command_or_motion."""
    follows = shares['command'] > max(shares['motion'], THRESHOLDS.command_share)
    return 'actuator' if place == 'motor_side' and follows else place


def least_left(free_signal: Mapping[str, Any]) -> float:
    """Return the chi2 per reading that a free signal leaves at the best place of `free_signal`."""
    return float(min(figures['left'] for figures in free_signal['places'].values()))


def tied(free_signal: Mapping[str, Any], dependence: Dependence | None) -> tuple[str, ...]:
    """
    Return the locations at which a free signal explains as much as at the best one, best first.

    A dependence on the motion, if beyond chance, decides between them.

    Args:
        free_signal: result of `places`.
        dependence: of what is explained on the motion, None if there is none.
    """
    chi2 = {place: figures['left'] for place, figures in free_signal['places'].items()}
    limit = THRESHOLDS.place_tie * least_left(free_signal)
    tied_places = [place for place in sorted(chi2, key=chi2.__getitem__) if chi2[place] <= limit]
    if dependence is not None and dependence.beyond_chance and dependence.place in tied_places:
        tied_places = [dependence.place]
    return tuple(_location(place, free_signal['actuator']) for place in tied_places)
