# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Diagnose, fit, tune and adapt: recordings of one drive and its model, in one call."""
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from gearbox_monitor.diagnosis.joint import diagnose as identification
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal, NominalFit
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.errors import expect_whole, InputError, unknown
from gearbox_monitor.library.recording import all_of, Recording
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.plant.effects import library
from gearbox_monitor.signals.recording import at_one_rate, UniformRecording

Recorded = Recording | UniformRecording
Progress = Callable[..., object]


def diagnose(recordings: Recorded | Sequence[Recorded], model: DriveModel, *,
             validate: Recorded | None = None, only: Sequence[str] | None = None,
             exclude: Sequence[str] = (), seed: int = 0, jobs: int = 1,
             progress: Progress | None = None) -> Verdict:
    """
    Return the verdict on recordings of one drive: the effects that its model lacks.

    Every effect of the library is fitted; the likelihood of the recordings decides which of them
    count (docs/science.md).

    Args:
        recordings: of `load_recording`, one or several of one drive; each is evaluated with the
            encoders that it has.
        model: of the drive.
        validate: recording that is used for validation only.
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
        seed: of the intervals; same seed, same answer.
        jobs: number of threads; does not change the answer.
        progress: called with (done, total, text).

    Returns:
        The verdict; its `model` closes the gap as far as is known.

    Raises:
        InputError: unknown ids, recordings that suit no diagnosis or differ in their rate.
        Undecided: free runs of the model are not finite.
    """
    expect_model(model)
    for option, ids in (('only', only), ('exclude', exclude)):
        expect_ids(option, ids)
    expect_whole(jobs, 'jobs', 1)
    expect_whole(seed, 'seed')
    parts, validation, notes = uniform(recordings, model, validate, weigh=True)
    verdict = identification.diagnose(
        parts, model, validate=validation, only=only, exclude=exclude, seed=seed, jobs=jobs,
        progress=progress)
    return replace(verdict, warnings=[*notes, *verdict.warnings])


def fit(recordings: Recorded | Sequence[Recorded], model: DriveModel,
        free: Sequence[str] | None = None, *, validate: Recorded | None = None,
        seconds: float | None = None, progress: Progress | None = None) -> NominalFit:
    """
    Return the values of a model fitted to recordings, and which of them these determine.

    A regression of the torque, then least squares of runs of the model (docs/real_drives.md).

    Args:
        recordings: of `load_recording`, one or several of one drive.
        model: of the drive, right within a factor of about ten.
        free: names of values to fit (m1 m2 D Cv Cc K b kt u0 zero, gains of a servo, ids of
            effects of the model), None for all of this drive but kt.
        validate: recording that is used for validation only.
        seconds: length of the runs that are fitted, s; None: 1 s.
        progress: called with (done, total, text).

    Returns:
        The fit; its `model` has the values.

    Raises:
        InputError: names that this drive does not have, or recordings that suit no fit.
        Undecided: no solution.
    """
    expect_model(model)
    _expect_list('free', free, 'names')
    if seconds is not None and not (isinstance(seconds, (int, float)) and seconds >= 1.0):
        raise InputError(f'seconds: {seconds!r}, expected at least 1 s')
    parts, validation, _ = uniform(recordings, model, validate)
    return fit_nominal(parts, model, free, validate=validation, seconds=seconds,
                       progress=progress)


def uniform(recordings: Recorded | Sequence[Recorded], model: DriveModel,
            validate: Recorded | None = None, weigh: bool = False
            ) -> tuple[list[UniformRecording], UniformRecording | None, list[str]]:
    """
    Return (recordings on even times, checked, at one rate; that for validation; notes).

    Args:
        recordings: one or several.
        model: of the drive.
        validate: recording that is used for validation only.
        weigh: whether a wrong look of channels, signs and units is a doubt, and no refusal.

    Raises:
        InputError: a recording allows no statement about the drive, or validate is not one.
    """
    sources = list(all_of(recordings, model))
    if validate is not None:
        sources += all_of((validate,), model, 'validate')
    parts: list[UniformRecording] = []
    notes: list[str] = []
    for source in sources:
        if isinstance(source, UniformRecording):
            parts.append(source)
            continue
        part, remarks = source.uniform(weigh)
        parts.append(part)
        notes += [*source.limits.notes, *(f'{Path(source.name).name}: {note}' if len(sources) > 1
                                          else note for note in remarks)]
    validation = parts.pop() if validate is not None else None
    return at_one_rate(parts), validation, list(dict.fromkeys(notes))


def expect_ids(option: str, ids: object) -> None:
    """Raise InputError unless `ids`, an argument `option`, are those of effects."""
    effects = library()
    for name in _expect_list(option, ids, 'ids of effects'):
        if name not in effects:
            raise InputError(f'{option}: unknown effect {name!r}, {unknown(name, effects)}')


def _expect_list(option: str, names: Any, what: str) -> Iterable[object]:
    """Return `names`, an argument `option` with a list or None. Raises InputError."""
    if isinstance(names, str) or not isinstance(names, (Sequence, Mapping, Set, type(None))):
        raise InputError(f'{option}: {names!r}, expected a list of {what}')
    return names or ()
