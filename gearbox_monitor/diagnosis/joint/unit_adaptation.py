# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Adapt a model file to one unit by recordings of its motion alone, without a torque sensor.

The values that the recordings determine are fitted (`nominal.fit_nominal`), the filter is tuned
with them (`estimation.tune`). What stays open goes into the tolerances: a value that is determined
is as uncertain as its deviation says, times the misfit of the fit; the others keep value and
tolerance of the file, or the usual tolerance if that is wider. Where the curve over the twist is
determined, the distance of the torque from it stands in for the missing sensor: friction that no
constant describes shows there. Where nothing is determined, nothing is tuned either: innovations
of a model that does not follow the drive say how wrong it is, not how noisy.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.nominal import fit_nominal, NominalFit
from gearbox_monitor.errors import Undecided
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.interval_smoother import smooth_interval
from gearbox_monitor.estimation.noise_search import widened
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_STD, S_TWIST, S_TWIST_STD, smoother_parameters)
from gearbox_monitor.estimation.tune import tune
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import EstimatorParameters, RANDOM_WALK
from gearbox_monitor.plant.drive import DriveModel, TOLERANCES
from gearbox_monitor.presentation import Saved, Shown
from gearbox_monitor.signals.uniform import UniformRecording

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
    report = progress or (lambda *_: None)
    remarks = list(OPEN)
    free: list[str] | None = None
    fit: NominalFit | None = None
    try:
        while fit is None:
            fit = fit_nominal(recordings, model, free, progress=(
                lambda done, total, text: report(0.6 * done / total, 1.0, text)))
            undetermined = [v.name for v in fit.values if not v.determined]
            free = [v.name for v in fit.values if v.determined]
            remarks += [f'{name}: not identified, as in the model file' for name in undetermined]
            if undetermined:  # what was not determined has moved, too
                fit = None
            if not free:
                raise Undecided('no value is identified')
    except Undecided as error:
        remarks.append(f'model file and parameters stay as they are, but for tolerances: {error}')
    tolerances = {name: (getattr(model, name), value)
                  for name, value in _tolerances(model, fit).items()}
    adapted = (fit.model if fit else model).with_(
        **{name: now for name, (_, now) in tolerances.items()})
    if fit is None:
        return Adapted(adapted, None, tolerances, {}, {}, remarks)
    samples = [samples_of(recording) for recording in recordings]

    def tuning_at(share: float) -> None:
        """Report the `share` of the tuning that is done."""
        report(0.6 + 0.35 * share, 1.0, 'tune')
    tuning = tune(adapted, parameters, samples, speeds=False, progress=tuning_at)
    values = dict(tuning['parameters'])
    if not {'K', 'b'} <= {v.name for v in fit.values}:
        return Adapted(adapted, fit, tolerances, values, tuning, remarks)
    values['tau_k_model_std'] = 0.0
    report(0.95, 1.0, 'torque over twist')
    strays = [_off_the_curve(adapted, parameters.replace(**values), one) for one in samples]
    stray, variance = (np.concatenate(column) for column in zip(*strays))
    values['tau_k_model_std'] = float(f'{widened(stray, variance):.4g}') if len(stray) else 0.0
    return Adapted(adapted, fit, tolerances, values, tuning, remarks)


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
    by_name = {v.name: v for v in fit.values} if fit else {}
    for name, of in VALUES_OF.items():
        values = [by_name[v] for v in of if v in by_name and by_name[v].value > 0.0]
        if fit and values and all(v.determined for v in values):
            # A bound either way whose uniform distribution has the deviation of the fit.
            wide = math.sqrt(3.0) * max(fit.gap_after, 1.0) * max(
                v.error / v.value for v in values)
            result[name] = float(f'{min(max(wide, SMALLEST), result[name]):.3g}')
    return result


def _off_the_curve(model: DriveModel, parameters: EstimatorParameters,
                   samples: Samples) -> tuple[Array, Array]:
    """Return how far the smoothed torque is from the model's dead zone, and its variance."""
    walk = smoother_parameters(parameters.replace(tau_k_model=RANDOM_WALK))
    rows = smooth_interval(model, walk, samples).rows[len(samples.stamp_ns) // 20:]
    shape = model.transmission
    twist, std = rows[:, S_TWIST], rows[:, S_TWIST_STD]
    torque = shape.stiffness * (twist - np.clip(twist, -shape.half_gap, shape.half_gap))
    slope = np.where(np.abs(twist) > shape.half_gap, shape.stiffness, 0.0)
    clear = np.abs(np.abs(twist) - shape.half_gap) > EDGE * std
    return ((rows[:, S_TAU_K] - torque)[clear],
            (rows[:, S_TAU_K_STD] ** 2 + (slope * std) ** 2)[clear])
