# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fit the nominal values of a drive to recordings, and tell which of them the data determine.

Each value moves on a log scale about that of the model file, under a weak prior: values that the
data do not determine stay there. It is the fit of a diagnosis without effects, with wide priors:
the search by innovations begins in the values of the model file and in those of the balance of
momentum (torque_domain), to which values that are far off are no obstacle. Values whose free runs
are farther off than those of the model file are no solution. How long unexplained torque lasts is
that of the likeliest fit. Long runs are the same filter with hardly any torque noise.

A model file is adapted to one unit by recordings of its motion alone, without a torque sensor. The
filter is tuned with the values that the recordings determine (`estimation.tune`). What stays open
goes into the tolerances: a value that is determined is as uncertain as its deviation says, times
the misfit of the fit; the others keep value and tolerance of the file, or the usual tolerance if
that is wider. Where the curve over the twist is determined, the distance of the torque from it
stands in for the missing sensor: friction that no constant describes shows there. Where nothing is
determined, nothing is tuned either: innovations of a model that does not follow the drive say how
wrong it is, not how noisy.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint import windows
from gearbox_monitor.diagnosis.joint.candidates import (
    BY_EFFECT, CandidateModel, Coordinate, GAINS, NOT_FITTED, NUISANCES, offered, PERIODIC, Starts,
    ZERO)
from gearbox_monitor.diagnosis.joint.drive_recordings import (
    DriveRecordings, evidence_of, lasting_time, likeliest)
from gearbox_monitor.diagnosis.joint.innovations import (
    coordinate_columns, evaluated, fitted, halves, InnovationFit, InnovationLikelihood,
    JointLikelihood, unfitted)
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows
from gearbox_monitor.diagnosis.joint.torque_domain import driven
from gearbox_monitor.diagnosis.joint.windows import misfit_of, SECONDS
from gearbox_monitor.diagnosis.settings import STATEMENTS
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.noise_search import widened
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_STD, S_TWIST, S_TWIST_STD, smoother_parameters)
from gearbox_monitor.estimation.tune import tune
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.parameters import EstimatorParameters, RANDOM_WALK
from gearbox_monitor.plant.drive import DriveModel, RANGES, TOLERANCES
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.presentation import on_axis, Saved, Shown
from gearbox_monitor.signals.uniform import expect_one_rate, UniformRecording

WEAK = 1.0         # standard deviation of the prior on the log of a value, or of an offset's scale
WIDE = (1e-3, 1e3)  # bounds of a value over that of the model file
ITERATIONS = 40
FIRST = 4          # of them from each start; the likeliest goes on
FIXED = 1e-9       # rad and rad/s: deviation of states in which long runs begin
LEAST = 1.01       # times the least torque noise: a fit that reaches it needs none
BLOCKS = 4         # for each value, at least, whose scores scatter


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
class NominalFit(Shown):
    """
    Result: model, a DriveModel with the values; values; correlated: [(name, name, r)].

    covariance [P, P] of the errors of the values, in their units and order.
    """

    model: DriveModel
    values: list[FittedValue]
    correlated: list[tuple[str, str, float]]
    gap_before: float | None
    gap_after: float
    validation: dict[str, Any] | None = None
    covariance: Array | None = field(default=None, compare=False)


def fit_nominal(recordings: Sequence[UniformRecording], model: DriveModel,
                free: Sequence[str] | None = None, *, validate: UniformRecording | None = None,
                seconds: float | None = None,
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
        progress: callback with (done, total, text).

    Raises:
        InputError: names that this drive does not have; Undecided: no solution.
    """
    report = progress or _quiet
    stated = model.folded()
    recordings, model = _prepared(recordings, model, free or ())
    plain = replace(model, tolerance=0.0, zero_tolerance=0.0)
    evidence = evidence_of(recordings, plain, ())
    candidate = _free_candidate(evidence.starts, plain, model, free)
    report(0, 2, 'fit')
    evidence, fit = _searched(evidence, candidate, report)
    candidate, plain = fit.candidate, evidence.model
    long = _long_runs(evidence, fit, seconds)
    if long is not None:
        report(1, 2, 'long windows')
        fit = fitted(long.likelihood, replace(fit, torque=long.torque), ITERATIONS,
                     free_noise=False)
    fitted_model = fit.model
    report(1.5, 2, 'free runs')
    values, correlated, covariance = _listed(
        candidate, fit.z, _covariance(evidence, fit, long), stated)
    # No state of a window holds the zero of the encoders where the motor's motion is put in.
    base = replace(plain, zero_tolerance=model.zero_tolerance) if evidence.balances else plain
    gap_before = None if seconds else _gap_of(evidence, base)
    gap_after = _gap_of(evidence, fitted_model, seconds or SECONDS)
    # Of balances, windows are no evidence; long runs are what was fitted.
    _expect_no_farther(math.inf if evidence.balances or gap_before is None else gap_before,
                       gap_after)
    validation = None if validate is None else windows.validate(
        validate, base, fitted_model, evidence.sigma)
    if model.controller is None:  # filters have a torque constant, but no gain
        fitted_model = fitted_model.with_torque_constant(start_values(fitted_model)['kt'])
    fitted_model = replace(fitted_model.folded(), tolerance=model.tolerance,
                           zero_tolerance=model.zero_tolerance)
    return NominalFit(fitted_model, values, correlated, gap_before, gap_after, validation,
                      covariance)


def _quiet(done: float, total: float, text: str) -> None:
    """Report nothing."""


def _prepared(recordings: Sequence[UniformRecording], model: DriveModel, free: Sequence[str]
              ) -> tuple[list[UniformRecording], DriveModel]:
    """
    Return recordings as the model wants them, and the model with starts of the values `free`.

    Raises:
        InputError: names that this drive does not have, or one encoder that does not suffice.
    """
    expect_one_rate(recordings)
    for recording in recordings:
        if len(recording.channels) == 1 and model.transmission.kind != 'rigid':
            raise InputError(f'{recording.name}: one encoder, expected both, or a model file with '
                             'transmission.kind: rigid; diagnose takes it')
    recordings = [driven(r, model) for r in recordings]
    model = _with_starts(model.folded(), free)
    names = [*offered(model), *_effects_of(model)]
    for name in free:
        if name not in names:
            raise InputError(f'free: {name!r}, expected one of {", ".join(names)}')
        if list(free).count(name) > 1:
            raise InputError(f'free: {name!r} twice, expected each name once')
    return recordings, model


def _searched(evidence: DriveRecordings, candidate: CandidateModel, report: Callable[..., object]
              ) -> tuple[DriveRecordings, InnovationFit]:
    """Return (recordings, nuisances settled; likeliest fit)."""
    starts = [candidate.start()]
    if not (evidence.balances or evidence.model.controller):
        starts.append(_balanced(evidence.recordings, candidate))
    fit = _likeliest(evidence, candidate, starts)
    for slow in (True, False):  # torque between the stamps
        evidence, fit = likeliest(evidence, fit, slow)
    starts = [fit.z]
    if evidence.balances or not _disturbed(evidence, fit):
        return evidence, fit
    report(0.5, 2, 'how long torque lasts')
    time = lasting_time(evidence, fit, 0.0)
    if time != evidence.model.process_torque_time:
        evidence = evidence.lasting_for(time)
        fit = _likeliest(evidence, replace(candidate, nominal=evidence.model), starts)
    return evidence, fit


def _balanced(recordings: Sequence[UniformRecording], candidate: CandidateModel) -> Array:
    """Return the coordinates [P] of a candidate by the balance of the measured motion."""
    model = replace(candidate.nominal, driven_by='position')
    likelihood = evidence_of([driven(r, model) for r in recordings], model, ()).fine
    return fitted(likelihood, unfitted(likelihood, candidate)).z


def _gap_of(evidence: DriveRecordings, model: DriveModel, seconds: float = SECONDS) -> float:
    """Return the misfit of free runs of a model over windows of so many `seconds`, sigmas."""
    return misfit_of([windows.open_loop(r, model, evidence.sigma, seconds=seconds)
                      for r in evidence.recordings])


def _free_candidate(starts: Starts, plain: DriveModel, model: DriveModel,
                    free: Sequence[str] | None) -> CandidateModel:
    """
    Return the CandidateModel of the values that are free.

    Args:
        starts: of effects in the recordings.
        plain: model without tolerances.
        model: with them.
        free: names, None for all of the drive.
    """
    own = _effects_of(model)
    scales = {'u0': starts.scales.torque, ZERO: max(starts.scales.twist, 1e-6)}
    fixed = ('kt', *(GAINS if model.controller and not model.controller.tolerance else ()))
    free = free or [name for name in offered(model) if name not in fixed]
    ids = tuple(name for name in free if name in own)
    coordinates = [_coordinate(name, scales.get(name)) for name in free if name not in own]
    for i, name in enumerate(ids):
        coordinates += _of_effect(starts, own[name], i)
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


def _likeliest(evidence: DriveRecordings, candidate: CandidateModel,
               starts: Sequence[Array]) -> InnovationFit:
    """Return the likeliest fit of a candidate to the training parts from several starts [P]."""
    likelihood = evidence.fine
    fits = [fitted(likelihood, unfitted(likelihood, candidate, z), FIRST) for z in starts]
    return fitted(likelihood, min(fits, key=lambda fit: fit.deviance), ITERATIONS)


def _disturbed(evidence: DriveRecordings, fit: InnovationFit) -> bool:
    """Return whether a fit needs torque that no model explains, beyond what always remains."""
    return bool((fit.torque > LEAST * evidence.fine.least_noise).any())


@dataclass(frozen=True, eq=False)
class _LongRuns:
    """
    Likelihood of runs that torque noise hardly corrects, so that what drifts slowly weighs.

    torque: that noise [2], N m rms in a sample; readings: in each run.
    """

    likelihood: JointLikelihood
    torque: Array
    readings: int


def _long_runs(evidence: DriveRecordings, fit: InnovationFit, seconds: float | None
               ) -> _LongRuns | None:
    """Return the _LongRuns of so many `seconds`, which begin in the smoothed states of `fit`."""
    if not seconds or evidence.balances:
        return None
    parts, model, length = [], replace(evidence.model, process_torque_time=0.0), 0
    for recording in evidence.recordings:
        whole = InnovationLikelihood(recording, evidence.model, evidence.sigma,
                                     halves([recording.span]))
        smooth = whole.smoothed(whole.run(fit.model, fit.torque))
        windows = shooting_windows(recording, min(seconds, recording.duration))
        part = InnovationLikelihood(recording, model, evidence.sigma, [
            slice(begin, begin + windows.length) for begin in windows.first.tolist()])
        parts.append(part.begun(smooth[windows.first, :4], np.full(4, FIXED)))
        length = max(length, windows.length)
    likelihood = JointLikelihood(parts)
    # White torque moves an inertia by the power 3/2 of the time; the least is that of 1 s.
    share = (SECONDS / (length * evidence.recordings[0].dt)) ** 1.5
    return _LongRuns(likelihood, likelihood.least_noise * share,
                     length * max(len(r.channels) for r in evidence.recordings))


def _expect_no_farther(before: float, after: float) -> None:
    """Raise Undecided if the misfit of free runs `after` a fit exceeds that `before` it."""
    if not (after <= STATEMENTS.no_worse * before or math.isnan(before)):
        raise Undecided(
            f'free runs of the model file leave {before:.3g} times the noise, those of the fit '
            f'{after:.3g}: no solution; expected a model of this drive (see check), or fewer '
            'values to fit (--free)')


def _coordinate(name: str, scale: float | None) -> Coordinate:
    if scale is None:
        low, high = WIDE
        return Coordinate(-1, name, 1.0, 1.0, low, high, log=True, prior=WEAK)
    return Coordinate(-1, name, 0.0, scale, prior=WEAK * scale)


def _effects_of(model: DriveModel) -> dict[str, Values]:
    """Return {id: effect} of `model` whose parameters can be fitted by the effect's id."""
    values = {effect for effect, _ in BY_EFFECT.values()}
    return {e['id']: e for e in model.folded().effects
            if e['id'] not in (*values, *NOT_FITTED, TORQUE_MAP.id)}


def _of_effect(starts: Starts, effect: Values, owner: int) -> list[Coordinate]:
    """Return the Coordinates of `effect` of the model, from its values there."""
    return [replace(c, owner=owner, prior=WEAK * (1.0 if c.log else max(c.scale, abs(c.start))))
            for c in starts.at(effect['id'], effect).of(0)]


def _covariance(evidence: DriveRecordings, fit: InnovationFit, long: _LongRuns | None) -> Array:
    """
    Return the covariance [P, P] of the coordinates, from the derivatives of the innovations.

    A model that is wrong leaves innovations that are not white: their scores are summed in blocks,
    whose scatter counts (Liang and Zeger, 1986). The residual of a long run is one number.

    Args:
        evidence: the recordings.
        fit: of the search.
        long: runs that were fitted, None: the innovations were.
    """
    likelihood, candidate = evidence.fine if long is None else long.likelihood, fit.candidate
    at = evaluated(likelihood, fit)
    J, residual = coordinate_columns(likelihood, at, central=True), at.run.residual.ravel()
    S, prior = J.T @ J, np.diag(candidate.prior(fit.z)[1])
    misfit = max(1.0, float((at.run.residual[at.run.read] ** 2).mean()))
    noise_alone = misfit <= STATEMENTS.encoder_noise and not evidence.balances
    if long is not None or noise_alone and not _disturbed(evidence, fit):
        if long is not None and not noise_alone:
            misfit *= long.readings
        covariance: Array = np.linalg.inv(S / misfit + prior)
        return covariance
    count = len(fit.z)
    seconds = sum(r.duration for r in evidence.recordings)
    blocks = max(round(seconds / SECONDS), BLOCKS * count)
    edges = np.linspace(0, len(J), blocks, endpoint=False).astype(int)
    scores = np.add.reduceat(J * residual[:, None], edges)
    scores -= scores.mean(axis=0)
    unit = float(np.trace(np.linalg.solve(S + prior, scores.T @ scores))) / count
    meat = scores.T @ scores * (blocks / (blocks - count)) + unit * unit * prior
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
            name, unit = c.name, _unit(c.name, model)
            start, value = starts[name], fitted_values[name]
        else:
            effect, name = library()[candidate.ids[c.owner]], candidate.parameter(c)
            scale = 1.0 if name == 'phi' else scale
            start, value = own_starts[c.owner][name], own_values[c.owner][name]
            unit = {p.name: p.unit for p in effect.parameters}[name]
            name = f'{effect.id}.{name}'
        determined = interior and error < STATEMENTS.determined * scale
        values.append(FittedValue(name, on_axis(unit, model.axis), start, value,
                                  float(error * abs(value) if c.log else error), bool(determined)))
    r = covariance / np.outer(errors, errors)
    correlated = [(values[i].name, values[j].name, float(r[i, j])) for i in range(len(values))
                  for j in range(i) if abs(r[i, j]) > STATEMENTS.correlated]
    sizes = np.array([value.error for value in values])
    return values, correlated, r * np.outer(sizes, sizes)


def _unit(name: str, model: DriveModel) -> str:
    """Return the unit of a value of `model`; none of a factor on efforts that are torques."""
    return '' if name == 'kt' and model.torque_constant == 1.0 else UNITS[name]


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


UNITS = {name: RANGES[where].unit for name, where in NUISANCES.items()} | {
    'kt': 'N m/A', 'u0': 'N m', ZERO: 'rad'}


# Tolerance of the model -> the fitted values that it is of.
VALUES_OF = {'friction_tolerance': ('Cc',), 'damping_tolerance': ('Cv', 'D'),
             'inertia_tolerance': ('m1', 'm2')}
SMALLEST = 0.02  # tolerance that is claimed from recordings of one day
EDGE = 3.0       # deviations of the twist within which the edge of a gap is no place to compare
OPEN = ('torque constant: not identifiable without a known load; tau_K, stiffness, inertia and '
        'friction share its scale (torque_gain_tolerance)',
        'delay of the torque: not fitted (delay_tolerance)')


@dataclass(frozen=True, repr=False)
class Adapted(Shown, Saved):
    """
    A model of one unit.

    model: the DriveModel; fit: of its values, None if the recordings determine none; tolerances
    {name: (in the file, now)}; parameters {name: value} tuned, tuning: what tune says of them,
    both empty without a fit; open: what the recordings do not tell, in sentences. estimator: the
    parameters that were in force; kept: why model and parameters stay as they were, '' else.
    """

    model: DriveModel
    fit: NominalFit | None
    tolerances: dict[str, tuple[float, float]]
    parameters: dict[str, Any]
    tuning: dict[str, Any]
    open: list[str]
    estimator: EstimatorParameters = field(default_factory=EstimatorParameters)
    kept: str = ''


def adapt(recordings: Sequence[UniformRecording], model: DriveModel,
          parameters: EstimatorParameters, progress: Callable[..., object] | None = None
          ) -> Adapted:
    """
    Adapt the model of a drive to the unit that was recorded.

    Args:
        recordings: of this unit, both encoders.
        model: of the file.
        parameters: of the estimator, in force.
        progress: called with (done, total, text).

    Returns:
        The adapted model and parameters.

    Raises:
        InputError: the recordings do not suit fit_nominal or tune.

    """
    report = progress or _quiet
    fit, remarks = _determined_fit(recordings, model, report)
    tolerances = {name: (getattr(model, name), value)
                  for name, value in _tolerances(model, fit).items()}
    adapted = (fit.model if fit else model).with_(
        **{name: now for name, (_, now) in tolerances.items()})
    if fit is None:
        return Adapted(adapted, None, tolerances, {}, {}, remarks)
    samples = [samples_of(recording) for recording in recordings]
    tuning = tune(adapted, parameters, samples, speeds=False,
                  progress=lambda share: report(0.6 + 0.35 * share, 1.0, 'tune'))
    values = dict(tuning['parameters'])
    if {'K', 'b'} <= {v.name for v in fit.values}:
        report(0.95, 1.0, 'torque over twist')
        values['tau_k_model_std'] = 0.0
        strays = [_off_the_curve(adapted, parameters.replace(**values), one) for one in samples]
        stray, variance = (np.concatenate(column) for column in zip(*strays))
        if len(stray):
            values['tau_k_model_std'] = float(f'{widened(stray, variance):.4g}')
    return Adapted(adapted, fit, tolerances, values, tuning, remarks)


def _determined_fit(recordings: Sequence[UniformRecording], model: DriveModel,
                    report: Callable[..., object]) -> tuple[NominalFit | None, list[str]]:
    """Return (the fit of the values that recordings determine, None without any; remarks)."""
    free, remarks = None, list(OPEN)
    try:
        while True:
            fit = fit_nominal(recordings, model, free, progress=(
                lambda done, total, text: report(0.6 * done / total, 1.0, text)))
            free = [v.name for v in fit.values if v.determined]
            if len(free) == len(fit.values):  # what is not determined has moved, too
                return fit, remarks
            remarks += [f'{v.name}: not identified, as in the model file'
                        for v in fit.values if not v.determined]
            if not free:
                raise Undecided('no value is identified')
    except Undecided as error:
        remarks.append(f'model file and parameters stay as they are, but for tolerances: {error}')
    return None, remarks


def samples_of(recording: UniformRecording) -> Samples:
    """Return the Samples of a `recording`."""
    load = np.full(len(recording.t), np.nan)
    return Samples(
        1_000_000_000 + np.round(recording.t * 1e9).astype(np.int64),
        np.column_stack([recording.torque, load if recording.arm_torque is None
                         else recording.arm_torque]), recording.y)


def _tolerances(model: DriveModel, fit: NominalFit | None) -> dict[str, float]:
    usual = {f.name: f.default for f in fields(DriveModel) if f.name in TOLERANCES}
    result = {name: max(getattr(model, name), usual[name]) for name in TOLERANCES}
    if fit is None:
        return result
    for name, of in VALUES_OF.items():
        values = [v for v in fit.values if v.name in of and v.value > 0.0]
        if values and all(v.determined for v in values):
            # A bound either way whose uniform distribution has the deviation of the fit.
            wide = math.sqrt(3.0) * max(fit.gap_after, 1.0) * max(
                v.error / v.value for v in values)
            result[name] = float(f'{min(max(wide, SMALLEST), result[name]):.3g}')
    return result


def _off_the_curve(model: DriveModel, parameters: EstimatorParameters,
                   samples: Samples) -> tuple[Array, Array]:
    """Return how far the smoothed torque is from the model's dead zone, and its variance."""
    walk = smoother_parameters(parameters.replace(tau_k_model=RANDOM_WALK))
    rows = Estimator(model, walk).run(samples).smoothed[len(samples.stamp_ns) // 20:]
    shape = model.transmission
    twist, std = rows[:, S_TWIST], rows[:, S_TWIST_STD]
    torque = shape.stiffness * (twist - np.clip(twist, -shape.half_gap, shape.half_gap))
    slope = np.where(np.abs(twist) > shape.half_gap, shape.stiffness, 0.0)
    clear = np.abs(np.abs(twist) - shape.half_gap) > EDGE * std
    return ((rows[:, S_TAU_K] - torque)[clear],
            (rows[:, S_TAU_K_STD] ** 2 + (slope * std) ** 2)[clear])
