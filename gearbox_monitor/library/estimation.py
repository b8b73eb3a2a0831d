# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Estimates of a recording, and its backlash window by window."""
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.files.baselines import earlier
from gearbox_monitor.files.user_files import load_parameters
from gearbox_monitor.health.alarms import LIMITS, Outcome
from gearbox_monitor.health.backlash.features import (
    Backlash, combine, Combined, NotExcited, reason_of, separable_of)
from gearbox_monitor.health.judgement import Health
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.recording import DriveRecording, SECOND
from gearbox_monitor.parameters import EstimatorParameters, SETTINGS, values_of
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.presentation import Paged

Parameters = EstimatorParameters | Mapping[str, object] | str | Path | None


@dataclass(frozen=True, repr=False)
class RecordingEstimates(Estimates, Paged):
    """
    Estimates of a recording, and the outcomes of a Monitor at its end.

    recording; parameters: in force; outcomes {component: Outcome}; health: of the gearbox;
    backlash: of each window of drift_window seconds; notes: sentences about the filter.
    """

    recording: DriveRecording
    parameters: EstimatorParameters
    outcomes: Mapping[str, Outcome]
    health: Health
    backlash: tuple[Backlash, ...]
    notes: tuple[str, ...]

    @property
    def t(self) -> Array:
        """Times [M] of the estimates from the first sample of the recording, s."""
        return (self.stamp_ns - self.recording.stamp_ns.min()) / SECOND

    @property
    def smoothed_t(self) -> Array:
        """Times [L] of the smoothed values, s."""
        return (self.smoothed_stamp_ns - self.recording.stamp_ns.min()) / SECOND

    @property
    def levels(self) -> dict[str, str]:
        """The level of each component at the end of the recording: OK, WARN or ERROR."""
        return {name: outcome.level.name for name, outcome in self.outcomes.items()}


@dataclass(frozen=True, repr=False)
class BacklashWindows(Paged):
    """
    The backlash of a recording: `fits` of its windows, each alone.

    recording: that was cut into windows; model: of its drive, as the estimator had it.
    """

    recording: DriveRecording
    model: DriveModel
    fits: tuple[Backlash | NotExcited, ...] = field(repr=False)

    @cached_property
    def _used(self) -> tuple[list[Backlash], bool]:
        return separable_of(self.fits)  # type: ignore[arg-type]

    @property
    def ends(self) -> Array:
        """End [W] of each window from the first sample of the recording, s."""
        stamps = np.array([fit.stamp_ns for fit in self.fits], np.int64)
        return (stamps - self.recording.stamp_ns.min()) / SECOND

    @property
    def separable(self) -> bool:
        """Whether the motion separates backlash and compliance; if not, the lost motion counts."""
        return self._used[1]

    @property
    def gap(self) -> Combined | None:
        """Gap of all windows with its standard deviation, rad; None where none shows it."""
        return combine(self._used[0], 'gap', LIMITS.gap_error)

    @property
    def stiffness(self) -> Combined | None:
        """Stiffness in contact, N m/rad."""
        return combine(self._used[0], 'stiffness', LIMITS.stiffness_error)

    @property
    def lost_motion(self) -> Combined | None:
        """Lost motion, rad, which needs no torque."""
        return combine(self._used[0] or self.fits, 'lost_motion', LIMITS.gap_error)

    @property
    def reason(self) -> str:
        """Why no window shows the backlash, '' where one does."""
        return '' if self._used[0] else str(reason_of(
            [fit for fit in self.fits if isinstance(fit, NotExcited)]))


def estimate(recording: DriveRecording, model: DriveModel | None = None, *,
             parameters: Parameters = None, **changes: object) -> RecordingEstimates:
    """
    Return torque and twist of the gearbox over a recording, with trust and backlash.

    The same Estimator and Monitor as in the live node: same samples in, same bits out.

    Args:
        recording: of `load_recording`, with torque and at least the motor.
        model: of the drive, None for the one of the recording.
        parameters: of the estimator: EstimatorParameters, {name: value}, or a parameter file.
        changes: single parameters by name (docs/parameters.md), such as tau_k_model='mixed'.

    Returns:
        The estimates: columns by name (tau_k, tau_k_std, twist, nis ...; smoothed_tau_k ...).

    Raises:
        InputError: a parameter is unknown or out of range, or no filter takes the recording.

    >>> import numpy as np, gearbox_monitor as gm
    >>> model, t = gm.DriveModel(), np.arange(3000) * 1e-3
    >>> drive = gm.simulate(model, 4 * np.cos(8 * t), 1e-3)
    >>> est = gm.estimate(gm.load_recording(drive, model))
    >>> est.tau_k.shape == est.tau_k_std.shape == est.t.shape
    True
    >>> error = np.interp(est.smoothed_t, drive.t, drive.tau_k) - est.smoothed_tau_k
    >>> bool(error.std() < 0.1 * drive.tau_k.std())
    True
    """
    monitor, recording, result = _estimated(recording, model, parameters, changes)
    estimator = monitor.estimator
    return RecordingEstimates(
        **{name: getattr(result, name) for name in Estimates.__dataclass_fields__},
        recording=recording, parameters=monitor.parameters, outcomes=dict(monitor.outcomes),
        health=monitor.health,
        backlash=tuple(monitor.windows),
        notes=(*recording.notes, *estimator.warnings, *estimator.divergence_notes()))


def backlash(recording: DriveRecording, model: DriveModel | None = None, *,
             window: float | None = None, parameters: Parameters = None,
             **changes: object) -> BacklashWindows:
    """
    Return the backlash of a recording, from torque over twist in independent windows.

    Args:
        recording: of `load_recording`; the motion must load both flanks.
        model: of the drive, None for the one of the recording.
        window: length of a window, s; None: the parameter drift_window.
        parameters: of the estimator, as `estimate` takes them.
        changes: single parameters by name.

    Returns:
        The windows; `gap`, `stiffness` and `lost_motion` of all of them.

    Raises:
        InputError: as of `estimate`; or no smoother.

    >>> import numpy as np, gearbox_monitor as gm
    >>> model, t = gm.DriveModel(), np.arange(3000) * 2e-3
    >>> u = 5 * np.cos(5.7 * t) + 2 * np.cos(14.5 * t)
    >>> windows = gm.backlash(gm.load_recording(gm.simulate(model, u, 2e-3), model), window=3.0)
    >>> bool(abs(windows.gap.value - 2 * model.transmission.half_gap) < 0.005)
    True
    """
    if window is not None:
        changes = {**changes, 'drift_window': window}
    monitor, recording, _ = _estimated(recording, model, parameters, changes)
    return BacklashWindows(recording, monitor.model, tuple(monitor.all_features()))


def _estimated(recording: Any, model: DriveModel | None, parameters: Parameters,
               changes: Mapping[str, object]) -> tuple[Monitor, DriveRecording, Estimates]:
    """
    Return a Monitor after a recording, the recording as its model reads it, and the estimates.

    The Monitor has the baseline that its parameters name, and no arm where none is measured.
    """
    recording = expect_recording(recording)
    drive = recording.model if model is None else expect_model(model)
    values, readings = estimator_values(parameters, changes), recording.with_model(drive)
    if np.isnan(readings.motor).all():
        raise InputError(f'{recording.name}: motor: never measured, expected its encoder: an '
                         'estimator needs it')
    if np.isnan(readings.arm).all():
        values.setdefault('arm_joint', '')
    monitor = Monitor(drive, values, earlier(values)[0])
    recording = recording.with_model(monitor.model)
    estimates = monitor.run(recording.samples())
    if not len(estimates.stamp_ns):
        raise InputError(f'{recording.name}: no estimate of {len(recording)} samples: their times '
                         'do not increase, or nothing was measured; expected a recording')
    return monitor, recording, estimates


def estimator_values(parameters: Parameters, changes: Mapping[str, object]) -> dict[str, object]:
    """
    Return {name: value} of the parameters of an estimator. Raises InputError.

    Args:
        parameters: complete, a mapping, a parameter file, or None.
        changes: that replace them.
    """
    if isinstance(parameters, (str, Path)):
        parameters = load_parameters(parameters, 'estimator', SETTINGS)
        parameters.pop('model', None)
    return {**values_of(parameters), **changes}


def expect_recording(recording: Any) -> DriveRecording:
    """Return `recording` if `load_recording` gave it. Raises InputError."""
    if isinstance(recording, DriveRecording):
        return recording
    raise InputError(f'recording: {type(recording).__name__} {str(recording)[:40]!r}, expected '
                     'one recording, as load_recording returns it')
