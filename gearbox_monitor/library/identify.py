# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Diagnose a drive or a robot; fit, tune and adapt a drive: recordings and model, in one call."""
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, cast
import warnings

from gearbox_monitor import __version__
from gearbox_monitor.diagnosis.hypothesis import Finding
from gearbox_monitor.diagnosis.joint import diagnose as identification, nominal
from gearbox_monitor.diagnosis.joint.diagnose import chosen_ids
from gearbox_monitor.diagnosis.joint.nominal import Adapted, fit_nominal, NominalFit, samples_of
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.diagnosis.robot.verdict import RobotVerdict
from gearbox_monitor.errors import expect_list, expect_whole, InputError
from gearbox_monitor.estimation.score import run_score
from gearbox_monitor.estimation.tune import tune as tuned
from gearbox_monitor.files.user_files import model_text, plain, save_model, write_parameters
from gearbox_monitor.library.estimation import estimator_values, expect_recording, Parameters
from gearbox_monitor.library.progress import Progress, reported
from gearbox_monitor.library.recording import all_of, DriveRecording
from gearbox_monitor.library.robot import (
    context_of_robot, diagnosed, Robot, robot_effects)
from gearbox_monitor.parameters import EstimatorParameters, MIXED, resolve
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.presentation import as_written, Paged, Saved, Shown
from gearbox_monitor.recordings.reading import BY_NAMES, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.report.diagnosis_page import context_of, DiagnosisContext
from gearbox_monitor.report.words import headline
from gearbox_monitor.signals.examine import measured_samples
from gearbox_monitor.signals.uniform import at_one_rate, UniformRecording

Recorded = DriveRecording | UniformRecording


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Paged, Saved):
    """
    The diagnosis of a drive, or of a whole robot.

    verdict: with all evidence. data: the same as plain data, as in the JSON. file_text: the model
    file of the drive, or the file of the robot, with the findings; None if it can hold none.
    context: charts and recordings for the page.
    """

    verdict: Verdict | RobotVerdict
    data: dict[str, Any]
    file_text: str | None
    context: Callable[[], DiagnosisContext]

    @property
    def kind(self) -> str:
        """One of diagnosis.hypothesis.KINDS."""
        return self.verdict.kind

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The effects, each with its place or its joint or link."""
        return self.verdict.findings

    @property
    def model(self) -> DriveModel:
        """Model of a drive that closes the gap as far as is known. Raises InputError: a robot."""
        if isinstance(self.verdict, RobotVerdict):
            raise InputError('model: of a whole robot, expected save: its file with the findings')
        return self.verdict.model


def diagnose(logs: Recorded | str | Path | Sequence[Recorded] | Sequence[str | Path],
             model: DriveModel | Robot, *,
             reference: str | Path | Sequence[str | Path] | None = None,
             validate: Recorded | None = None, only: Sequence[str] | None = None,
             exclude: Sequence[str] = (), recorded: Mapping[str, str] | None = None,
             topic: str = JOINT_STATES, reading: ReadOptions = BY_NAMES, seed: int = 0,
             jobs: int = 1, progress: Progress | None = None) -> Diagnosis:
    """
    Return the diagnosis of a drive or a robot: the effects that its model lacks in recordings.

    Every effect of the library is fitted; the likelihood of the recordings decides which of them
    count (docs/science.md).

    Args:
        logs: of a drive what `load_recording` returns, one or several; each is evaluated with the
            encoders that it has. Of a robot the paths of recordings.
        model: of the drive, or the robot of `load_robot`.
        reference: of a robot: logs from before or of the healthy twin, or one file of the command
            learn; None: its file with its tolerances.
        validate: recording of a drive that is used for validation only.
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
        recorded: of a robot, {joint: its name in the log}, where they differ.
        topic: of a robot's joints, in bags.
        reading: of a robot's logs, how columns are read whose names and units do not say it.
        seed: of the intervals; same seed, same answer.
        jobs: number of threads; does not change the answer.
        progress: called with (done, total, text); None shows a bar or, in a pipe, lines.

    Returns:
        The diagnosis; `save` writes the model, or the robot's file, with the findings.

    Raises:
        InputError: unknown ids, recordings that suit no diagnosis or differ in their rate; or the
            reference has another kind of input.
        Undecided: free runs of the model are not finite.
    """
    expect_whole(jobs, 'jobs', 1)
    expect_whole(seed, 'seed')
    if isinstance(model, Robot):
        if validate is not None:
            raise InputError('validate: of a drive, expected a second diagnosis of the robot')
        effects = chosen_ids(only, exclude, effects=sorted(robot_effects())) if (
            only is not None or exclude) else None
        judged, data, closed = diagnosed(
            cast(Any, logs), model, reference=reference, effects=effects, recorded=recorded,
            topic=topic, reading=reading, progress=progress)
        return Diagnosis(judged, data, closed, partial(context_of_robot, judged, model, data))
    expect_model(model)
    for name, given in ('reference', reference), ('recorded', recorded):
        if given is not None:
            raise InputError(f'{name}: of a robot, expected the model of load_robot')
    parts, validation, notes = uniform(cast(Any, logs), model, validate, weigh=True)
    with reported('diagnose', progress) as report:
        verdict = identification.diagnose(
            parts, model, validate=validation, only=only, exclude=exclude, seed=seed, jobs=jobs,
            progress=report)
    verdict = replace(verdict, warnings=[*map(as_written, notes), *verdict.warnings])
    data = plain(verdict.to_dict())
    summary = headline(data)
    names = [part.name for part in parts]
    data = {'summary': summary, **data, 'model': 'drive.yaml', 'options': '', 'joint': '',
            'logs': names, 'closed': None}
    text = model_text(verdict.model, [
        f'Written by gearbox_monitor {__version__} diagnose from {", ".join(names)}.', summary])
    return Diagnosis(verdict, data, text, partial(context_of, verdict, model))


def fit(recordings: Recorded | Sequence[Recorded], model: DriveModel,
        free: Sequence[str] | None = None, *, validate: Recorded | None = None,
        seconds: float | None = None, progress: Progress | None = None) -> NominalFit:
    """
    Return the values of a model fitted to recordings, and which of them these determine.

    A search by the likelihood of innovations, as in `diagnose` (docs/real_drives.md).

    Args:
        recordings: of `load_recording`, one or several of one drive.
        model: of the drive, right within a factor of about ten.
        free: names of values to fit (m1 m2 D Cv Cc K b kt u0 zero, gains of a servo, ids of
            effects of the model), None for all of this drive but kt.
        validate: recording that is used for validation only.
        seconds: length of the runs that are fitted, s; None: 1 s.
        progress: called with (done, total, text); None shows a bar or, in a pipe, lines.

    Returns:
        The fit; its `model` has the values.

    Raises:
        InputError: names that this drive does not have, or recordings that suit no fit.
        Undecided: no solution.
    """
    expect_model(model)
    expect_list('free', free, 'names')
    if seconds is not None and not (isinstance(seconds, (int, float)) and seconds >= 1.0):
        raise InputError(f'seconds: {seconds!r}, expected at least 1 s')
    parts, validation, _ = uniform(recordings, model, validate)
    _warn_of_doubts(parts, recordings)
    with reported('fit', progress) as report:
        return fit_nominal(parts, model, free, validate=validation, seconds=seconds,
                           progress=report)


def uniform(recordings: Recorded | Sequence[Recorded], model: DriveModel,
            validate: Recorded | None = None, weigh: bool = False
            ) -> tuple[list[UniformRecording], UniformRecording | None, list[str]]:
    """
    Return (recordings on even times, checked, at one rate; that for validation; notes).

    Args:
        recordings: one or several.
        model: of the drive.
        validate: recording that is used for validation only.
        weigh: see DriveRecording.uniform.

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


@dataclass(frozen=True, repr=False)
class TunedParameters(Shown, Saved):
    """
    Parameters of a filter as a recording has them.

    parameters: all of them, with the tuned values; before: those in force; model: of the drive;
    figures {name: value}: of the search, as `fit noise --json` prints them.
    """

    parameters: EstimatorParameters
    before: EstimatorParameters
    model: DriveModel
    figures: Mapping[str, Any]

    @property
    def values(self) -> dict[str, Any]:
        """The tuned values by name."""
        return dict(self.figures['parameters'])

    @property
    def errors(self) -> dict[str, float | None]:
        """The relative standard error of each tuned value, None where the search gives none."""
        return {name: self.figures['relative_error'].get(name) for name in self.values}

    @property
    def kept(self) -> bool:
        """Whether nothing is more likely than the parameters before, which are kept."""
        return bool(self.figures['kept'])

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about the search."""
        return tuple(self.figures['notes'])


def tune(recording: DriveRecording, model: DriveModel | None = None, *,
         parameters: Parameters = None, speeds: bool = True,
         progress: Progress | None = None, **changes: object) -> TunedParameters:
    """
    Return R and Q of a filter for a recording, by maximum likelihood of the innovations.

    Args:
        recording: of `load_recording`; with half a second of standstill R comes from there.
        model: of the drive, None for the one of the recording.
        parameters: before, as `estimate` takes them; the result depends on those that it keeps.
        speeds: tune the process noise of the speeds, too.
        progress: called with (done, total); None shows a bar or, in a pipe, lines.
        changes: single parameters by name, such as filter='ukf'. tau_k_model is mixed unless one
            is named.

    Returns:
        The parameters, for `estimate(..., parameters=tuned.parameters)`; `save` writes the file.

    Raises:
        InputError: the recording is too short or does not move, or the filter diverges.
    """
    recording = expect_recording(recording)
    drive = recording.model if model is None else expect_model(model)
    drive, base = resolve(drive, {
        'tau_k_model': MIXED, **estimator_values(parameters, changes)})
    recording = recording.with_model(drive)
    samples, notes = measured_samples(recording.samples(), recording.name)
    try:
        with reported('tune', progress) as report:
            figures = tuned(drive, base, [samples], speeds, lambda share: report(share, 1.0))
    except InputError as error:
        raise InputError(f'{recording.name}: {error}') from None
    figures.update(bag=recording.name, notes=[*figures['notes'], *recording.notes, *notes])
    return TunedParameters(base.replace(**figures['parameters']), base, drive, figures)


def adapt(recordings: Recorded | Sequence[Recorded], model: DriveModel, *,
          parameters: Parameters = None, progress: Progress | None = None,
          **changes: object) -> Adapted:
    """
    Return model and parameters of one unit, from its motion alone, without a torque sensor.

    `fit` and `tune` in one; the tolerances state the remaining uncertainty (docs/tuning.md).

    Args:
        recordings: of `load_recording`, of this unit, with both encoders.
        model: of the drive.
        parameters: of the estimator, as `estimate` takes them.
        progress: called with (done, total, text); None shows a bar or, in a pipe, lines.
        changes: single parameters by name; tau_k_model is mixed unless one is named.

    Returns:
        The adapted model and parameters; where nothing is more likely than those before, these,
        and `kept` says so. `save` writes drive.yaml and params.yaml into a new folder.

    Raises:
        InputError: the recordings do not suit it.
    """
    base = parameters if isinstance(parameters, EstimatorParameters) and not changes else (
        EstimatorParameters.of({'tau_k_model': MIXED, **estimator_values(parameters, changes)}))
    parts, _, _ = uniform(recordings, expect_model(model))
    _warn_of_doubts(parts, recordings)
    with reported('adapt', progress) as report:
        result = replace(nominal.adapt(parts, model, base, report), estimator=base)
    refusal = _kept_before(result, model, base, parts)
    if not refusal:
        return result
    return replace(result, model=model.with_(**{
        name: max(sides) for name, sides in result.tolerances.items()}), parameters={},
        open=[refusal, *result.open], kept=refusal)


def _warn_of_doubts(parts: Iterable[UniformRecording],
                    recordings: Recorded | Sequence[Recorded]) -> None:
    """Warn of recordings that may have to be read otherwise, which commands do by notes."""
    listed = [recordings] if not isinstance(recordings, Sequence) else recordings
    if any(isinstance(recording, UniformRecording) for recording in listed):
        return
    for part in parts:
        if part.doubt is not None:
            warnings.warn(f'{part.name}: {part.doubt.text}', stacklevel=3)


def write_adapted(folder: str | Path, result: Adapted, names: str) -> Path:
    """
    Write drive.yaml and params.yaml into a new folder, and return that. Raises InputError.

    Args:
        folder: that does not exist.
        result: of `adapt`.
        names: of the recordings.
    """
    folder = Path(folder)
    if folder.exists() or not folder.parent.is_dir():
        raise InputError(f'{folder}: expected a new folder in one that exists')
    folder.mkdir()
    save_model(folder / 'drive.yaml', result.model,
               [f'Adapted with gearbox_monitor fit unit to {names}', *result.open])
    figures = {'after': None, 'relative_error': {}, 'filter': result.estimator.filter,
               **result.tuning, 'parameters': result.parameters, 'bag': names,
               'command': 'fit unit'}
    write_parameters(folder / 'params.yaml', result.estimator, (str(folder / 'drive.yaml'), {}),
                     figures)
    return folder


def _kept_before(result: Adapted, model: DriveModel, parameters: EstimatorParameters,
                 recordings: Sequence[UniformRecording]) -> str:
    """Return why model and parameters stay unchanged, '' if `result` is at least as likely."""
    if result.fit is None:
        return ''
    samples = [samples_of(recording) for recording in recordings]
    old_score, new_score = (sum(run_score(drive, values, part).criterion for part in samples)
                            for drive, values in (
        (model, parameters), (result.model, parameters.replace(**result.parameters))))
    if new_score >= old_score:
        return ''
    return ('the adapted values are less likely than model file and parameters before '
            f'(log-likelihood {new_score:.1f}, {old_score:.1f} before): these are kept, with '
            'wider tolerances')
