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
Fit the nominal values of a drive to recordings, and tell which of them the data determine.

Each value moves on a log scale about that of the model file, under a weak prior: values that the
data do not determine stay there. A fit starts there or where a linear regression of the torque
leads, whichever fits better. One that leaves more than the model file on windows that were not
fitted is not a solution.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.identification import closed_model, gauss_newton, likelihood, window_states
from gearbox_monitor.identification.candidates import (
    BY_EFFECT, CandidateModel, Coordinate, GAINS, NOT_FITTED, NUISANCES, offered,
    PERIODIC, PHASED, sine_and_cosine, Starts, ZERO)
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.noise_model import noise_floor
from gearbox_monitor.identification.position.position_search import PositionSearch
from gearbox_monitor.identification.process_noise import noise_weighted_residual
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.shooting import shooting_windows
from gearbox_monitor.identification.smoothed_windows import likeliest, on_windows
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.identification.windows import misfit_of
from gearbox_monitor.kernels.sensor_noise import noise_levels
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.arm_side import GRAVITY
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.quality.recording import concatenated, UniformRecording
from gearbox_monitor.quality.smoothed_motion import SmoothedMotion

WEAK = 1.0         # standard deviation of the prior on the log of a value, or of an offset's scale
WIDE = (1e-3, 1e3)  # bounds of a value over that of the model file
ROUNDS, ITERATIONS = 3, 40


@dataclass
class FittedValue:
    """One fitted value: `value` and its standard `error` in `unit`, `start` in the model file."""

    name: str
    unit: str
    start: float
    value: float
    error: float
    determined: bool


@dataclass
class NominalFit:
    """model: DriveModel with the values; values: [Value]; correlated: [(name, name, r)]."""

    model: DriveModel
    values: list[FittedValue]
    correlated: list[tuple[str, str, float]]
    gap_before: float | None
    gap_after: float
    validation: dict[str, Any] | None = None


def fit_nominal(recordings: Sequence[UniformRecording], model: DriveModel,
                free: Sequence[str] | None = None, *, validate: UniformRecording | None = None,
                seconds: float | None = None, jobs: int = 1,
                progress: Callable[..., object] | None = None) -> NominalFit:
    """
    Return the fit of the values `free` to recordings of one drive.

    Args:
        recordings: recordings of one drive.
        model: model of the drive with its tolerances.
        free: names of candidates.NUISANCES, 'kt' (torque constant; not by default: without a known
            load it shares one scale with the others), 'u0' (torque offset, N m), 'zero' (of the
            encoders, rad), and ids of effects of the model, for all their parameters; None: all
            values of the drive.
        validate: recording that is used for validation only.
        seconds: length of the windows of the last stage, s; long ones weigh drift (inf: the whole
            recording).
        jobs: number of threads.
        progress: callback with (done, total, text).

    Raises:
        InputError: names that this drive does not have; Undecided: the fit is not a solution.
    """
    recording, model = concatenated([driven(r, model) for r in recordings]), model.folded()
    if len(recording.channels) == 1 and model.transmission.kind != 'rigid':
        raise InputError(f'{recording.name}: one encoder, expected both, or a model file with '
                         'transmission.kind: rigid; diagnose takes it')
    names, own = offered(model), _effects_of(model)
    for name in free or ():
        if name not in names and name not in own:
            raise InputError(f'free: {name!r}, expected one of {", ".join([*names, *own])}')
    plain = replace(model, tolerance=0.0, zero_tolerance=0.0)
    sigma, _ = noise_floor(recording, model)
    search: Search = Search(recording, plain, sigma, [], jobs, progress)
    if recording.motor is not None:
        search = PositionSearch(recording, plain, sigma, [], jobs, progress)
    gap_before = None
    if not seconds:  # no state of a window holds the zero where the motor's motion is put in
        base = plain if recording.motor is None else model
        gap_before = misfit_of([closed_model.open_loop(driven(r, model), base, sigma, 0.0)
                                for r in recordings])
    scales = {'u0': search.starts.scales.torque, ZERO: max(search.starts.scales.twist, 1e-6)}
    held = ('kt', *(GAINS if model.controller and not model.controller.tolerance else ()))
    free = free or [name for name in names if name not in held]
    ids = tuple(name for name in free if name in own)
    coordinates = [_coordinate(name, scales.get(name)) for name in free if name not in own]
    for i, name in enumerate(ids):
        coordinates += _of_effect(search.starts, own[name], i)
    orders = {i: int(own[name]['N']) for i, name in enumerate(ids) if name in PERIODIC}
    candidate = CandidateModel(plain, ids, tuple(coordinates), orders)
    report = progress or (lambda *_: None)
    fitted = _settled(search, candidate, report)
    data = search.long
    if seconds:
        whole = min(seconds, min(np.diff([*recording.cuts, len(recording.u)])) * recording.dt)
        squares = data.weighing and replace(data.weighing, robust=False)
        windows = shooting_windows(recording, whole)
        # Free states would move by many deviations to hide what the model leaves later.
        data = replace(data, windows=windows, train=np.ones(len(windows), bool),
                       weighing=squares, fixed_states=fitted.smooth is not None)
        report(0.9, 1.0, f'windows of {seconds:g} s')
        fitted = _longer(data, fitted)
    _require_improvement(search, data, fitted)
    fitted_model = candidate.model(fitted.point.z)
    values, correlated = _known(data, fitted, plain)
    gap_after = _gap(data, candidate, fitted.point)
    validation = None
    if validate is not None:
        base = plain if recording.motor is None else replace(model, tolerance=0.0)
        validation = closed_model.validate(validate, base, fitted_model, sigma)
    if model.controller is None:  # filters have a torque constant, but no gain
        fitted_model = fitted_model.with_torque_constant(start_values(fitted_model)['kt'])
    fitted_model = replace(fitted_model.folded(), tolerance=model.tolerance,
                           zero_tolerance=model.zero_tolerance)
    return NominalFit(fitted_model, values, correlated, gap_before, gap_after, validation)


def _require_improvement(search: Search, data: likelihood.WindowData,
                         fitted: CandidateFit) -> None:
    """
    Raise Undecided if `fitted` leaves more than its start on the windows of `data`.

    Windows that were not fitted decide, where `data` has any.
    """
    candidate = fitted.candidate
    unseen = data.train if data.train.all() else ~data.train
    gaps = []
    for z in (candidate.start(), fitted.point.z):
        trial = window_states.rescue(
            data, candidate, window_states.solved(data, candidate, fitted.point.at(z)),
            [fitted.point], half_gap=search.half_gap)
        gaps.append(closed_model.gap_of(trial.chi2[unseen], data.size))
    if not gaps[1] <= THRESHOLDS.no_worse * gaps[0]:
        raise Undecided(f'gap after the fit {gaps[1]:.4g} standard deviations, of the model file '
                        f'{gaps[0]:.4g}: no solution; expected a model of this drive (see '
                        'check), or fewer values to fit (--free)')


_ABSOLUTE = ('u0', 'As', 'Ac')  # coordinates in N m, those of others are factors


def regressed_start(recording: UniformRecording, candidate: CandidateModel) -> Array:
    """
    Return coordinates [P] where a linear regression of the torque leads, else the start.

    Torque over acceleration, speed, direction and 1, and over sine and cosine of the arm's
    position where gravity is fitted; inertias keep their ratio. What is not fitted counts as in
    the model file. Values that come out negative stay at the start.

    Args:
        recording: recording of the drive.
        candidate: model to be fitted, with its coordinates.
    """
    model, z = candidate.nominal, candidate.start()
    column = recording.channels[0]
    sigma, _ = noise_levels(recording.positions)
    parts = [SmoothedMotion(replace(
        recording, t=recording.t[s], u=recording.u[s], y=recording.positions[s],
        cuts=(0,)), sigma) for s in recording.segments]
    p, v, a = (np.concatenate([getattr(part, name) for part in parts]) for name in 'pva')
    u = np.concatenate([part.u for part in parts]) * (
        start_values(model)['kt'] / model.torque_constant) + start_values(model)['u0']
    names = {c.name for c in candidate.coordinates}
    motor, arm = model.motor_inertia * a[:, column], model.arm_inertia * a[:, -1]
    together = model.transmission.kind == 'rigid' or 'm2' in names or 'm1' not in names
    weight, phase = weight_of(model.effects)
    sine, cosine = np.sin(p[:, -1]), np.cos(p[:, -1])
    columns = {'m1': motor + arm if together else motor,
               'Cv': model.viscous_friction * v[:, column],
               'Cc': model.coulomb_friction * model.friction_side(v[:, column]),
               'As': sine, 'Ac': cosine, 'u0': -np.ones(len(u))}
    places = {c.name: i for i, c in enumerate(candidate.coordinates) if c.name in columns
              and (c.owner < 0 or candidate.ids[c.owner] == GRAVITY.id)}
    rest = u - model.position_gain * p[:, column] - sum(
        (columns[name] for name in ('m1', 'Cv', 'Cc') if name not in places),
        0.0 * u if together else arm)
    if 'As' not in places:
        rest -= weight * np.sin(p[:, -1] + phase)
    free = [columns[name] for name in places]
    if not free or any(
            np.ptp(columns[name]) == 0.0 for name in places if name not in _ABSOLUTE):
        return z
    solution = np.linalg.lstsq(np.column_stack(free), rest, rcond=None)[0]
    for (name, i), value in zip(places.items(), solution):
        coordinate = candidate.coordinates[i]
        if name in _ABSOLUTE:
            z[i] = value
        elif not coordinate.log:
            z[i] *= value
        elif value > 0.0:
            z[i] += math.log(value)
            if name == 'm1':
                for k, other in enumerate(candidate.coordinates):
                    if other.name == 'm2':
                        z[k] += math.log(value)
    return candidate.bounded(z)


def _coordinate(name: str, scale: float | None) -> Coordinate:
    if scale is None:
        low, high = WIDE
        return Coordinate(-1, name, 1.0, 1.0, low, high, log=True, prior=WEAK)
    return Coordinate(-1, name, 0.0, scale, prior=WEAK * scale)


def _gap(data: likelihood.WindowData, candidate: CandidateModel,
         point: likelihood.FitPoint) -> float:
    """Return the gap that `point` leaves, in standard deviations of the noise."""
    plain = data.plain()
    return closed_model.gap_of(plain.evaluate(candidate, point).chi2, data.size)


def _effects_of(model: DriveModel) -> dict[str, Values]:
    """Return {id: effect} of `model` whose parameters can be fitted by the effect's id."""
    values = {effect for effect, _ in BY_EFFECT.values()}
    return {e['id']: e for e in model.folded().effects
            if e['id'] not in (*values, *NOT_FITTED, TORQUE_MAP.id)}


def _of_effect(starts: Starts, effect: Values, owner: int) -> list[Coordinate]:
    """Return the Coordinates of `effect` of the model, from its values there."""
    name, values = effect['id'], dict(effect)
    if name in PHASED:
        values |= sine_and_cosine(name, values)
    own = starts.candidates(name, values.get('N'))[0].coordinates
    return [replace(c, owner=owner, start=values[c.name], prior=WEAK * (1.0 if c.log else max(
        c.scale, abs(values[c.name])))) for c in own if c.owner == 0]


def _settled(search: Search, candidate: CandidateModel,
             report: Callable[..., object]) -> CandidateFit:
    """Return the CandidateFit of `candidate` on windows of 1 s."""
    starts = [candidate.start()]
    if candidate.nominal.controller is None:
        starts.append(regressed_start(search.recording, candidate))
    if not isinstance(search, PositionSearch):
        report(0, 2, 'fit')
        fit = likeliest(search, candidate, starts, ITERATIONS)
        report(1, 2, 'fit, windows of 1 s')
        whole = InnovationLikelihood(search.recording, candidate.nominal, search.long.sigma,
                                     search.spans)
        return on_windows(search, fit, whole, fit.deviance)
    report(0, 1, 'fit, windows of 1 s')
    fresh = likelihood.fresh(search.long, candidate)
    point = min((window_states.solved(search.long, candidate, fresh.at(z)) for z in starts),
                key=lambda p: float(p.chi2.sum()))
    for _ in range(ROUNDS):
        point = gauss_newton.fit(search.long, candidate, point, 8, robust=True, refresh=range(8))
    search.keep(search.as_fitted(candidate, point), '')
    search.settle([''])
    search.weigh_by_error([''])
    return search.fitted['']


def _longer(data: likelihood.WindowData, fitted: CandidateFit) -> CandidateFit:
    """Return `fitted` on the longer windows of `data`, which begin in its smoothed states."""
    point = likelihood.fresh(data, fitted.candidate).at(fitted.point.z)
    if fitted.smooth is not None:
        states, memory = np.split(fitted.smooth[data.windows.begin], [4], axis=1)
        point = replace(point, states=states, memory=memory)
    return CandidateFit(fitted.candidate, gauss_newton.fit(
        data, fitted.candidate, point, 40, refresh=range(40)))


def _known(data: likelihood.WindowData, fitted: CandidateFit,
           model: DriveModel) -> tuple[list[FittedValue], list[tuple[str, str, float]]]:
    """Return ([Value], [(name, name, correlation)]) by the linearised fit."""
    candidate, point = fitted.candidate, fitted.point
    s = likelihood.Sensitivity(likelihood.state_sensitivity(
        data, candidate.model(point.z), point.states, point.memory, point.residual),
        _central(data, candidate, point))
    residual, whiten = noise_weighted_residual(data, fitted)
    S, _, _, _ = likelihood.normal_equations(s, point.residual, data.train.astype(float), whiten)
    # The residual is not encoder noise: it counts as one number per window and encoder.
    misfit = max(1.0, float((residual[data.train] ** 2).mean()))
    if misfit > THRESHOLDS.encoder_noise:
        misfit *= data.windows.length
    prior = candidate.prior(point.z)[1]
    covariance = np.linalg.inv(S / misfit + np.diag(prior))
    jacobian = candidate.wave_jacobian(point.z)
    covariance = jacobian @ covariance @ jacobian.T
    errors = np.sqrt(np.diag(covariance))
    starts = start_values(model)
    fitted_values = start_values(candidate.model(point.z))
    (_, own_starts), (_, own_values) = map(candidate.values, (candidate.start(), point.z))
    values: list[FittedValue] = []
    for c, error, z in zip(candidate.coordinates, errors, point.z):
        inside = not c.log or math.log(c.low) + 1e-6 < z < math.log(c.high) - 1e-6
        scale = 1.0 if c.log else c.scale
        if c.owner < 0:
            name, unit, start, value = c.name, UNITS[c.name], starts[c.name], (
                fitted_values[c.name])
            if name == 'kt' and model.torque_constant == 1.0:
                unit = ''  # a factor on efforts that are torques
        else:
            effect = library()[candidate.ids[c.owner]]
            name = candidate.parameter(c)
            scale = 1.0 if name == 'phi' else scale
            start, value = own_starts[c.owner][name], own_values[c.owner][name]
            unit = next(p.unit for p in effect.parameters if p.name == name)
            name = f'{effect.id}.{name}'
        determined = inside and error < THRESHOLDS.determined * scale
        values.append(FittedValue(name, on_axis(unit, model.axis), start, value,
                                  float(error * abs(value) if c.log else error), bool(determined)))
    r = covariance / np.outer(errors, errors)
    correlated = [(values[i].name, values[j].name, float(r[i, j])) for i in range(len(values))
                  for j in range(i) if abs(r[i, j]) > THRESHOLDS.correlated]
    return values, correlated


def _central(data: likelihood.WindowData, candidate: CandidateModel,
             point: likelihood.FitPoint) -> Array:
    """Return d(-residual)/dz [W, C L, P]; one-sided, it would see what is not determined."""
    columns = []
    for i, step in enumerate(data.simulator.stretch * candidate.steps()):
        sides = []
        for sign in (-1.0, 1.0):
            z = point.z.copy()
            z[i] += 0.02 * sign * step
            sides.append(data.residual(candidate.model(z), point.states, point.memory)[0])
        columns.append((sides[0] - sides[1]) / (0.04 * step))
    return np.stack(columns, axis=2)


def start_values(model: DriveModel) -> dict[str, float]:
    """Return {name: value} of everything that can be fitted, as `model` has it."""
    out = {}
    for name, where in NUISANCES.items():
        out[name] = model.value(where)
    effects = {e['id']: e for e in model.effects}
    by_effect = {name: effects.get(effect, {}).get(parameter, 0.0)
                 for name, (effect, parameter) in BY_EFFECT.items()}
    out['kt'] = model.torque_constant * (1.0 + by_effect['kt'])
    out['u0'] = model.torque_offset + by_effect['u0']
    out[ZERO] = by_effect[ZERO]
    return out


UNITS = {'m1': 'kg m^2', 'm2': 'kg m^2', 'D': 'N m s/rad', 'Cv': 'N m s/rad', 'Cc': 'N m',
         'K': 'N m/rad', 'b': 'rad', 'kp': 'N m/rad', 'kd': 'N m s/rad', 'ki': 'N m/(rad s)',
         'kt': 'N m/A', 'u0': 'N m', ZERO: 'rad'}
