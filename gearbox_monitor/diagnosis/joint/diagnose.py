# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The diagnosis: which effects explain the sim-to-real gap, where they act, what remains."""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import count

import numpy as np

from gearbox_monitor.diagnosis.contest import CONTEST
from gearbox_monitor.diagnosis.joint.decision import (
    decide, Decision, with_level_of_innovations)
from gearbox_monitor.diagnosis.joint.drive_recordings import (
    DriveRecordings, evidence_of, is_open)
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.innovation_fit import fitted, InnovationFit, unfitted
from gearbox_monitor.diagnosis.joint.parameter_ranges import between_recordings
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.torque_domain import driven
from gearbox_monitor.diagnosis.joint.verdict import (
    LATTICES, location_of, report, Verdict, without_idle_laws)
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY, ACTUATOR_LAG
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.motor_side import LUGRE
from gearbox_monitor.presentation import said, Said
from gearbox_monitor.signals.uniform import expect_one_rate, UniformRecording

# Effects faster than a slow log: what they do within a sample is what its torque is read by.
UNSEEN_BETWEEN = (ACTUATOR_LAG.id, LUGRE.id)


def diagnose(recordings: Sequence[UniformRecording], model: DriveModel, *,
             validate: UniformRecording | None = None, only: Sequence[str] | None = None,
             exclude: Sequence[str] = (), seed: int = 0, jobs: int = 1,
             progress: Callable[..., object] | None = None) -> Verdict:
    """
    Return the verdict on recordings of one drive.

    Args:
        recordings: recordings of one drive; each is evaluated with the encoders that it has.
        model: model of the drive.
        validate: recording that is used for validation only.
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
        seed: seed of the bootstrap.
        jobs: number of threads.
        progress: callback with (done, total, text).

    Raises:
        InputError: unknown ids, none that this drive and its encoders show, or recordings of
            different rates.
        Undecided: free runs are not finite.
    """
    expect_one_rate(recordings)
    recordings = [driven(r, model) for r in recordings]
    chosen = chosen_ids(only, exclude)
    reasons = {i: reason for i in library() if (reason := said('excluded') if i not in chosen else
                                                hidden_by(i, model, recordings))}
    ids = [i for i in chosen if i not in reasons]
    if not ids:
        raise InputError('effects: none remains that is visible on this drive and its encoders, '
                         'expected at least one')
    if SLIP.id in ids:
        recordings = [r.as_read() for r in recordings]
    steps = count(1)

    def reported(text: str) -> None:
        """Report that `text` is under way, one of steps whose number is not known beforehand."""
        if progress is not None:
            progress(done := next(steps), done + 1, text)
    evidence = evidence_of(recordings, model, ids, jobs, reported)
    otherwise = read_as_doubted(evidence)
    decision = without_idle_laws(decide(evidence))
    notes = [*decision.notes, *doubts(decision, otherwise),
             *(note for r in recordings for note in r.counted_on())]
    stated, lasts = (m.process_torque_time for m in (model, decision.recordings.model))
    if lasts != stated:
        notes.append(said('torque_lasts', seconds=lasts, stated=stated))
    if ACTUATOR_DELAY.id in decision.ids and any(is_open(r, model) for r in recordings):
        notes.append(said('delay_is_open', ms=0.5e3 * recordings[0].dt))
    if decision.remains and len(recordings) > 1:
        same = _shown_by_each(decision)
        if same is not None:
            decision = same
            notes.append(said('differs_between'))
    lattices = tuple(name for i, name in enumerate(LATTICES)
                     if evidence.quantum[i] > THRESHOLDS.lattice * decision.recordings.level[i])
    excluded = [name for name in lattices if name in exclude]
    if excluded and not decision.ids and not decision.remains:
        decision = replace(decision, remains=True)
        notes.append(said('is_quantised', effect=excluded[0]))
    decision = with_level_of_innovations(decision)
    verdict = replace(report(decision, [n for n in lattices if n in ids], validate, seed, notes),
                      not_tried=reasons)
    if excluded and verdict.verdict == 'unknown':
        place = location_of(excluded[0])
        verdict = replace(verdict, location=place, where={**verdict.where, 'location': place},
                          remainder={**(verdict.remainder or {}), 'location': place})
    if verdict.verdict == 'effect' and len(recordings) > 1:
        fit = decision.fit
        verdict = replace(verdict, between_recordings={
            name: {key: asdict(value) for key, value in values.items()}
            for name, values in between_recordings(
                decision.data.recordings if decision.slips else recordings, fit.candidate, fit.z,
                decision.recordings.level).items()})
    return verdict


def read_as_doubted(evidence: DriveRecordings) -> dict[int, InnovationFit]:
    """
    Return {number of a recording in doubt: the nominal model fitted to it as the doubt reads it}.

    Args:
        evidence: the recordings.

    Raises:
        InputError: the nominal model leaves nothing but noise of a recording that is read so.
    """
    out = {}
    for number, recording in enumerate(evidence.recordings):
        doubt = recording.doubt
        if doubt is None or recording.motor is not None:
            continue
        sigma = np.abs(evidence.sigma[::-1] if doubt.swap else evidence.sigma) * np.abs(
            np.array(doubt.scale))
        read = recording.read_otherwise(doubt).with_servo(evidence.model.controller)
        otherwise = DriveRecordings((read,), evidence.model, sigma, ())
        fit = fitted(otherwise.whole, unfitted(otherwise.whole, otherwise.starts.none()))
        if explains_all(otherwise, fit):
            raise InputError(f'{recording.name}: {doubt.text}')
        out[number] = fit
    return out


def explains_all(evidence: DriveRecordings, fit: InnovationFit) -> bool:
    """Return whether a `fit` leaves nothing but noise of the evidence."""
    contested = InnovationEvidence(evidence)
    return contested.remains(contested.hypothesis(fit), thorough=True).worth <= CONTEST.margin


def doubts(decision: Decision, otherwise: Mapping[int, InnovationFit]) -> list[Said]:
    """
    Return the doubts of a check of channels, signs and units that effects explain better.

    Args:
        decision: on recordings as they are.
        otherwise: of read_as_doubted.

    Raises:
        InputError: the nominal model is likelier on a recording as the doubt reads it than any
            fit is on it as it stands.
    """
    out, evidence, closed = [], decision.data, decision.closed
    for number, fit in otherwise.items():
        recording = evidence.recordings[number]
        nominal_run = evidence.whole.parts[number].run(closed.model, closed.torque).deviance
        text = '' if recording.doubt is None else recording.doubt.text
        if fit.deviance < nominal_run:
            raise InputError(f'{recording.name}: {text}')
        out.append(said('doubt_refuted', doubt=text))
    return out


def _shown_by_each(decision: Decision) -> Decision | None:
    """Return the decision for the effect that explains each recording by a value of its own."""
    data = decision.data
    fit = next((f for f in decision.fits if len(f.candidate.ids) == 1), None)
    each = [replace(data, recordings=(r,)) for r in data.recordings]
    if fit is None or not all(explains_all(one, fitted(one.fine, fit)) for one in each):
        return None
    return replace(decision, fit=fit, closed=fit, remains=False)


def chosen_ids(only: Sequence[str] | None, exclude: Sequence[str]) -> list[str]:
    """
    Return the ids that may be named. Raises InputError for unknown ones.

    Args:
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
    """
    effects = library()
    for name in (*(only or ()), *exclude):
        if name not in effects:
            raise InputError(f'effect: {name!r}, expected one of {", ".join(effects)}')
    ids = [i for i in effects if i not in exclude and (only is None or i in only)]
    if not ids:
        raise InputError('effects: none remains, expected at least one')
    return ids


def hidden_by(name: str, model: DriveModel, recordings: Sequence[UniformRecording]) -> Said | None:
    """
    Return why no recording shows an effect, None if one does.

    Args:
        name: id of the effect.
        model: model of the drive.
        recordings: of it.
    """
    if not any(visible(name, model, recording) for recording in recordings):
        return said('never_shown')
    if name in UNSEEN_BETWEEN and all(is_open(recording, model) for recording in recordings):
        return said('too_slow', rate=1.0 / recordings[0].dt)
    return None


def visible(name: str, model: DriveModel, recording: UniformRecording) -> bool:
    """
    Return whether the effect `name` shows in readings of this drive, and under this name.

    Args:
        name: id of an effect.
        model: model of the drive.
        recording: recording of the drive.
    """
    missing = {('motor_sensor', 'arm_sensor')[i] for i in (0, 1) if i not in recording.channels}
    effect = library()[name]
    place = effect.location
    if effect.torque_only if model.controller else place == 'controller':
        return False
    if place in missing or (missing and effect.needs_both_encoders):
        return False
    if recording.motor is not None and (effect.slip_profile is not None or (
            place == 'motor_sensor' and (missing or effect.lattice))):
        return False
    if model.axis == 'prismatic' and effect.rotary_only:
        return False  # nothing turns with a position in m, and a weight is a constant load
    # In a rigid drive it is indistinguishable from the same on the motor.
    return model.transmission.kind != 'rigid' or (
        place != 'transmission' and not effect.merges_if_rigid)
