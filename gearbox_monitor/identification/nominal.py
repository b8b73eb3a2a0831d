# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fit the nominal values of a drive to recordings, and tell which of them the data determine.

Each value moves on a log scale about that of the model file, under a weak prior: values that the
data do not determine stay there. A regression of the torque comes first (torque_regression). A
search begins in its values and in those of the model file; where it does not arrive, or leaves
more than they do on windows that were not fitted, the values of the regression are the result.
How long unexplained torque lasts is that of the likeliest fit.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.identification import (
    closed_model, gauss_newton, innovation_fit, likelihood, window_states)
from gearbox_monitor.identification.candidates import (
    BY_EFFECT, CandidateModel, Coordinate, GAINS, NOT_FITTED, NUISANCES, offered,
    PERIODIC, PHASED, sine_and_cosine, Starts, ZERO)
from gearbox_monitor.identification.innovation_fit import InnovationFit
from gearbox_monitor.identification.innovations import InnovationLikelihood, SPARSE
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.noise_model import noise_floor
from gearbox_monitor.identification.process_noise import noise_weighted_residual
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.shooting import shooting_windows
from gearbox_monitor.identification.smoothed_windows import likeliest, on_windows
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.torque_between_stamps import is_open, read_for
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.identification.torque_regression import torque_regression, TorqueRegression
from gearbox_monitor.identification.windows import misfit_of
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.presentation import Drawn
from gearbox_monitor.quality.recording import concatenated, UniformRecording

WEAK = 1.0         # standard deviation of the prior on the log of a value, or of an offset's scale
WIDE = (1e-3, 1e3)  # bounds of a value over that of the model file
ITERATIONS = 40
READINGS = 2       # of the torque between the stamps of a slow log
LEFT = 0.5         # of the torque, that a regression leaves at most


@dataclass(frozen=True)
class FittedValue:
    """One fitted value: `value` and its standard `error` in `unit`, `start` in the model file."""

    name: str
    unit: str
    start: float
    value: float
    error: float
    determined: bool


@dataclass(frozen=True, repr=False)
class NominalFit(Drawn):
    """
    Result: model, a DriveModel with the values; values; correlated: [(name, name, r)].

    method: 'search', or 'regression' where its values stand for those of a search. covariance
    [P, P] of the errors of the values, in their units and order.
    """

    model: DriveModel
    values: list[FittedValue]
    correlated: list[tuple[str, str, float]]
    gap_before: float | None
    gap_after: float
    validation: dict[str, Any] | None = None
    method: str = 'search'
    covariance: Array | None = field(default=None, compare=False)


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
        jobs: counts for nothing: a fit is one thread.
        progress: callback with (done, total, text).

    Raises:
        InputError: names that this drive does not have; Undecided: neither search nor regression
            is a solution.
    """
    result = _fit(recordings, model, free, validate, seconds, progress)
    if any(is_open(recording, model) for recording in recordings):
        for _ in range(READINGS):  # of the torque between the stamps, by the fit before
            sigma, _ = noise_floor(concatenated(recordings), model)
            recordings = read_for(recordings, result.model, sigma)
            result = _fit(recordings, model, free, validate, seconds, progress)
    return result


@dataclass(frozen=True)
class BalancedValues:
    """
    Values by the balance of momentum alone, without a run of the model.

    values, covariance: see NominalFit. before, after: rms of the torque that the model file and
    the values leave, N m.
    """

    values: list[FittedValue]
    covariance: Array
    before: float
    after: float


def balanced(recordings: Sequence[UniformRecording], model: DriveModel,
             free: Sequence[str] | None = None) -> BalancedValues:
    """
    Return the values `free` by the regression of the torque: seconds where a fit takes minutes.

    Args:
        recordings: of one drive, with its torque.
        model: of the drive.
        free: as of fit_nominal.

    Raises:
        InputError: names that this drive does not have. Undecided: no regression.
    """
    recording = concatenated([driven(r, model) for r in recordings])
    model = stated = model.folded()
    _expect_free(model, free)
    plain = replace(model, tolerance=0.0, zero_tolerance=0.0)
    sigma, _ = noise_floor(recording, model)
    candidate = _free_candidate(Search(recording, plain, sigma), plain, model, free)
    regression = torque_regression(recording, candidate)
    if regression is None:
        raise Undecided(f'{recording.name}: the balance of torques determines no values')
    values, _, covariance = _listed(candidate, regression.z, regression.covariance, stated)
    return BalancedValues(values, covariance, regression.before, regression.after)


def _fit(recordings: Sequence[UniformRecording], model: DriveModel, free: Sequence[str] | None,
         validate: UniformRecording | None, seconds: float | None,
         progress: Callable[..., object] | None) -> NominalFit:
    """Return the fit to recordings as they are read; see fit_nominal."""
    recording = concatenated([driven(r, model) for r in recordings])
    model = stated = model.folded()
    if len(recording.channels) == 1 and model.transmission.kind != 'rigid':
        raise InputError(f'{recording.name}: one encoder, expected both, or a model file with '
                         'transmission.kind: rigid; diagnose takes it')
    model = _with_starts(model, free or ())
    _expect_free(model, free)
    plain = replace(model, tolerance=0.0, zero_tolerance=0.0)
    sigma, _ = noise_floor(recording, model)
    search = Search(recording, plain, sigma)
    gap_before = None
    if not seconds:  # no state of a window holds the zero where the motor's motion is put in
        base = plain if recording.motor is None else model
        gap_before = misfit_of([closed_model.open_loop(driven(r, model), base, sigma, 0.0)
                                for r in recordings])
    candidate = _free_candidate(search, plain, model, free)
    report = progress or (lambda *_: None)
    regression = torque_regression(recording, candidate)
    fitted = _searched(search, candidate, regression, report)
    time = model.process_torque_time
    if fitted is not None and recording.motor is None and _leaves_torque(search, fitted):
        report(0.5, 1.0, 'how long torque lasts')
        time = lasting_time(search, fitted)
    if time != model.process_torque_time:
        plain, candidate = (replace(plain, process_torque_time=time),
                            replace(candidate, nominal=replace(plain, process_torque_time=time)))
        search = Search(recording, plain, sigma)
        fitted = _searched(search, candidate, regression, report)
    data = search.long
    if seconds:
        whole = min(seconds, min(np.diff([*recording.cuts, len(recording.u)])) * recording.dt)
        windows = shooting_windows(recording, whole)
        # Free states would move by many deviations to hide what the model leaves later.
        data = replace(data, windows=windows, train=np.ones(len(windows), bool),
                       fixed_states=fitted is not None and fitted.smooth is not None)
        if fitted is not None:
            report(0.9, 1.0, f'windows of {seconds:g} s')
            fitted = _longer(data, fitted)
    fitted, method = _decided(search, data, candidate, fitted, regression)
    fitted_model = candidate.model(fitted.point.z)
    covariance = (_covariance(data, fitted) if method == 'search' or regression is None
                  else regression.covariance)
    values, correlated, covariance = _listed(candidate, fitted.point.z, covariance, stated)
    gap_after = _gap(data, candidate, fitted.point)
    validation = None
    if validate is not None:
        base = plain if recording.motor is None else replace(model, tolerance=0.0)
        validation = closed_model.validate(validate, base, fitted_model, sigma)
    if model.controller is None:  # filters have a torque constant, but no gain
        fitted_model = fitted_model.with_torque_constant(start_values(fitted_model)['kt'])
    fitted_model = replace(fitted_model.folded(), tolerance=model.tolerance,
                           zero_tolerance=model.zero_tolerance)
    return NominalFit(fitted_model, values, correlated, gap_before, gap_after, validation, method,
                      covariance)


def _expect_free(model: DriveModel, free: Sequence[str] | None) -> None:
    """Raise InputError unless `free` are names of values of a model."""
    names = [*offered(model), *_effects_of(model)]
    for name in free or ():
        if name not in names:
            raise InputError(f'free: {name!r}, expected one of {", ".join(names)}')
        if list(free or ()).count(name) > 1:
            raise InputError(f'free: {name!r} twice, expected each name once')


def _free_candidate(search: Search, plain: DriveModel, model: DriveModel,
                    free: Sequence[str] | None) -> CandidateModel:
    """
    Return the CandidateModel of the values that are free.

    Args:
        search: of the recording.
        plain: model without tolerances.
        model: with them.
        free: names, None for all of the drive.
    """
    own = _effects_of(model)
    scales = {'u0': search.starts.scales.torque, ZERO: max(search.starts.scales.twist, 1e-6)}
    fixed = ('kt', *(GAINS if model.controller and not model.controller.tolerance else ()))
    free = free or [name for name in offered(model) if name not in fixed]
    ids = tuple(name for name in free if name in own)
    coordinates = [_coordinate(name, scales.get(name)) for name in free if name not in own]
    for i, name in enumerate(ids):
        coordinates += _of_effect(search.starts, own[name], i)
    orders = {i: int(own[name]['N']) for i, name in enumerate(ids) if name in PERIODIC}
    return CandidateModel(plain, ids, tuple(coordinates), orders)


def _with_starts(model: DriveModel, free: Sequence[str]) -> DriveModel:
    """Return `model` with a place to begin from for values in `free` that are 0 in it."""
    servo, begin = model.controller, {}
    if servo is not None:
        # Of a servo that damps the error of the speed, and of one that knows its load.
        begin = {'kff': servo.kd or 0.01 * servo.kp,
                 'kaff': model.motor_inertia + model.arm_inertia}
    return model.with_values({
        NUISANCES[name]: value for name, value in begin.items()
        if name in free and not model.value(NUISANCES[name])})


def _searched(search: Search, candidate: CandidateModel, regression: TorqueRegression | None,
              report: Callable[..., object]) -> CandidateFit | None:
    """Return the CandidateFit of a search from both starts, None where it does not arrive."""
    starts = [candidate.start(), *([] if regression is None else [regression.z])]
    try:
        return _settled(search, candidate, starts, report)
    except (Undecided, np.linalg.LinAlgError):
        if regression is None:
            raise
        return None


def _leaves_torque(search: Search, fitted: CandidateFit) -> bool:
    """Return whether the residual of a fit is more than noise, or its torque has noise."""
    chi2 = fitted.point.chi2.sum() / (len(fitted.point.chi2) * search.long.size)
    return fitted.s > 0.0 or bool(chi2 > THRESHOLDS.encoder_noise)


def lasting_time(search: Search, fitted: CandidateFit) -> float:
    """
    Return how long unexplained torque lasts (s) by the likelihood of a fit.

    All times see the same readings. Another than that of the model has to be worth its price.

    Args:
        search: of a recording that the torque drives.
        fitted: fit of the search.
    """
    stated, stride = search.model.process_torque_time, max(1, round(SPARSE / search.recording.dt))

    def likelihood_with(time: float) -> InnovationLikelihood:
        return InnovationLikelihood(
            search.recording, replace(search.model, process_torque_time=time), search.long.sigma,
            search.spans).thinned(stride)
    deviances = innovation_fit.by_time(likelihood_with, fitted.candidate, fitted.point.z,
                                       (stated, 0.0, *innovation_fit.LASTING_TIMES))
    best = min(deviances, key=lambda time: deviances[time])
    price = math.log(likelihood_with(stated).readings)
    return best if deviances[best] + price < deviances[stated] else stated


def _decided(search: Search, data: likelihood.WindowData, candidate: CandidateModel,
             fitted: CandidateFit | None,
             regression: TorqueRegression | None) -> tuple[CandidateFit, str]:
    """
    Return (the fit that stands, 'search' or 'regression').

    The search stands unless the model file or the regression leaves less: of windows that were not
    fitted, where `data` has any, or of the balances, where the motion is put in. A regression
    stands that leaves less of the torque than the model file.

    Args:
        search: of the recording.
        data: windows of readings and how residuals are weighted.
        candidate: model that was fitted.
        fitted: fit of the search, None where it did not arrive.
        regression: of the torque, None without.

    Raises:
        Undecided: neither is a solution.
    """
    unseen = data.train if data.train.all() else ~data.train
    start = (fitted.point if fitted is not None
             else data.evaluate(candidate, likelihood.fresh(data, candidate)))

    def left(z: Array) -> tuple[likelihood.FitPoint, float]:
        """Return where windows stand with the coordinates z, and the gap that decides."""
        if search.balance is not None:
            return (_balanced_point(data, candidate, z),
                    search.balance.run(candidate.model(z), search.balance.first_noise).gap)
        point = window_states.rescue(
            data, candidate, window_states.solved(data, candidate, start.at(z)), [start],
            half_gap=search.half_gap)
        return point, closed_model.gap_of(point.chi2[unseen], data.size)
    _, gap_start = left(candidate.start())
    gap = math.inf if fitted is None else left(fitted.point.z)[1]
    torque = float(np.std(search.recording.torque))
    if regression is not None and regression.after < min(regression.before, LEFT * torque):
        point, gap_regression = left(regression.z)
    else:
        point, gap_regression = start, math.inf
    if fitted is not None and gap <= THRESHOLDS.no_worse * min(gap_start, gap_regression):
        return fitted, 'search'
    if math.isfinite(gap_regression):
        return CandidateFit(candidate, point), 'regression'
    raise Undecided(f'gap after the fit {gap:.4g} standard deviations, of the model file '
                    f'{gap_start:.4g}: no solution; expected a model of this drive (see '
                    'check), or fewer values to fit (--free)')


def _coordinate(name: str, scale: float | None) -> Coordinate:
    if scale is None:
        low, high = WIDE
        return Coordinate(-1, name, 1.0, 1.0, low, high, log=True, prior=WEAK)
    return Coordinate(-1, name, 0.0, scale, prior=WEAK * scale)


def _gap(data: likelihood.WindowData, candidate: CandidateModel,
         point: likelihood.FitPoint) -> float:
    """Return the gap that `point` leaves, in standard deviations of the noise."""
    return closed_model.gap_of(data.evaluate(candidate, point).chi2, data.size)


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


def _settled(search: Search, candidate: CandidateModel, starts: Sequence[Array],
             report: Callable[..., object]) -> CandidateFit:
    """
    Return the CandidateFit on windows of 1 s.

    Args:
        search: of the recording.
        candidate: model to be fitted.
        starts: coordinates [P] to begin with.
        report: progress.
    """
    report(0, 2, 'fit')
    balance = search.balance
    if balance is not None:
        fits = [innovation_fit.fitted(balance, InnovationFit(candidate, z, balance.first_noise),
                                      ITERATIONS) for z in starts]
        z = min(fits, key=lambda f: f.deviance).z
        return search.as_fitted(candidate, _balanced_point(search.long, candidate, z))
    fit = likeliest(search, candidate, starts, ITERATIONS)
    report(1, 2, 'fit, windows of 1 s')
    whole = InnovationLikelihood(search.recording, candidate.nominal, search.long.sigma,
                                 search.spans)
    return on_windows(search, fit, whole, fit.deviance)


def _balanced_point(data: likelihood.WindowData, candidate: CandidateModel,
                    z: Array) -> likelihood.FitPoint:
    """Return where windows without states of their own stand at the coordinates z [P]."""
    return data.evaluate(candidate, likelihood.fresh(data, candidate).at(z))


def _longer(data: likelihood.WindowData, fitted: CandidateFit) -> CandidateFit:
    """
    Return `fitted` on the longer windows of `data`, which begin in its smoothed states.

    Balances have no windows: their fit stands as it is.
    """
    if data.simulator.begins_known:
        return replace(fitted, point=_balanced_point(data, fitted.candidate, fitted.point.z))
    point = likelihood.fresh(data, fitted.candidate).at(fitted.point.z)
    if fitted.smooth is not None:
        states, memory = np.split(fitted.smooth[data.windows.begin], [4], axis=1)
        point = replace(point, states=states, memory=memory)
    return CandidateFit(fitted.candidate, gauss_newton.fit(
        data, fitted.candidate, point, 40, refresh=range(40)))


def _covariance(data: likelihood.WindowData, fitted: CandidateFit) -> Array:
    """
    Return the covariance [P, P] of the coordinates by the linearised fit.

    What is more than encoder noise is no chance of single readings: its sum over each window is
    one number (Liang and Zeger, 1986), or, with few windows, one per window and encoder.
    """
    candidate, point = fitted.candidate, fitted.point
    s = likelihood.Sensitivity(likelihood.state_sensitivity(
        data, candidate.model(point.z), point.states, point.memory, point.residual),
        _central(data, candidate, point))
    residual, whiten = noise_weighted_residual(data, fitted)
    S, _, X, x = likelihood.normal_equations(s, point.residual, data.train.astype(float), whiten)
    misfit = max(1.0, float((residual[data.train] ** 2).mean()))
    prior = np.diag(candidate.prior(point.z)[1])
    count, windows = len(point.z), int(data.train.sum())
    if misfit <= THRESHOLDS.encoder_noise or windows <= 2 * count:
        misfit *= data.windows.length if misfit > THRESHOLDS.encoder_noise else 1.0
        covariance: Array = np.linalg.inv(S / misfit + prior)
        return covariance
    J, states, r = s.Jz, s.Jx, point.residual
    if whiten is not None:
        J, states, r = whiten(J), whiten(states), whiten(r)
    scores = np.einsum('wlp,wl->wp', J - states @ X, r - np.einsum('wlk,wk->wl', states, x))[
        data.train]
    scores -= scores.mean(axis=0)
    unit = float(np.trace(np.linalg.solve(S + prior, scores.T @ scores))) / count
    meat = scores.T @ scores * (windows / (windows - count)) + unit * unit * prior
    inverse: Array = np.linalg.inv(S + unit * prior)
    return inverse @ meat @ inverse


def _listed(candidate: CandidateModel, z: Array, covariance: Array,
            model: DriveModel
            ) -> tuple[list[FittedValue], list[tuple[str, str, float]], Array]:
    """
    Return ([Value], [(name, name, correlation)], covariance of the values [P, P]) of a fit.

    Args:
        candidate: model that was fitted.
        z: its coordinates [P].
        covariance: of these [P, P].
        model: model file.
    """
    jacobian = candidate.wave_jacobian(z)
    covariance = jacobian @ covariance @ jacobian.T
    errors = np.sqrt(np.diag(covariance))
    starts = start_values(model)
    fitted_values = start_values(candidate.model(z))
    (_, own_starts), (_, own_values) = map(candidate.values, (candidate.start(), z))
    values: list[FittedValue] = []
    for c, error, at in zip(candidate.coordinates, errors, z):
        interior = not c.log or math.log(c.low) + 1e-6 < at < math.log(c.high) - 1e-6
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
        determined = interior and error < THRESHOLDS.determined * scale
        values.append(FittedValue(name, on_axis(unit, model.axis), start, value,
                                  float(error * abs(value) if c.log else error), bool(determined)))
    r = covariance / np.outer(errors, errors)
    correlated = [(values[i].name, values[j].name, float(r[i, j])) for i in range(len(values))
                  for j in range(i) if abs(r[i, j]) > THRESHOLDS.correlated]
    sizes = np.array([value.error for value in values])
    return values, correlated, r * np.outer(sizes, sizes)


def _central(data: likelihood.WindowData, candidate: CandidateModel,
             point: likelihood.FitPoint) -> Array:
    """Return d(-residual)/dz [W, C L, P]; one-sided, it would see what is not determined."""
    columns = []
    for i, step in enumerate(candidate.steps()):
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
         'kff': 'N m s/rad', 'kaff': 'kg m^2', 'kt': 'N m/A', 'u0': 'N m', ZERO: 'rad'}
