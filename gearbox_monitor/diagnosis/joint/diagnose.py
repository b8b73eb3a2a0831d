# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The diagnosis: which effects explain the sim-to-real gap, where they act, what remains.

The change of a drive between two recordings, whatever its model file missed before: the earlier
one, the reference, closes the model first, with its effects, its nominal values and the torque
noise that nothing explains. The later one is diagnosed against that model. An effect of it counts
as a change if the reference refutes it at the size that it has now: what the reference did not
show either way may have been there.
"""
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import compress, count
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import EFFECT, kind_of, NONE
from gearbox_monitor.diagnosis.joint.candidates import amplitude, origin, PHASED, with_effects
from gearbox_monitor.diagnosis.joint.decision import (
    decide, Decision, standard_errors, with_level_of_innovations)
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings, evidence_of, is_open
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.innovations import fitted, InnovationFit, unfitted
from gearbox_monitor.diagnosis.joint.parameter_ranges import between_recordings
from gearbox_monitor.diagnosis.joint.torque_domain import driven
from gearbox_monitor.diagnosis.joint.verdict import LATTICES, report, Verdict, without_idle_laws
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.diagnosis.settings import CONTEST, THRESHOLDS
from gearbox_monitor.errors import expect_list, InputError, unknown
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY, ACTUATOR_LAG
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.motor_side import LUGRE
from gearbox_monitor.presentation import on_axis, Said, said
from gearbox_monitor.signals.uniform import at_one_rate, expect_one_rate, UniformRecording

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
    ids, reasons = shown_effects(chosen_ids(only, exclude), model, recordings)
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
    notes = [*doubts(decision, otherwise), *_nuisance_notes(decision)]
    same = _shown_by_each(decision)
    if same is not None:
        decision = same
        notes.append(said('differs_between'))
    coarse = evidence.quantum > THRESHOLDS.lattice * decision.recordings.level
    lattices = list(compress(LATTICES, coarse))
    unnamed = next(filter(exclude.__contains__, lattices), '')
    if unnamed and not decision.ids and not decision.remains:
        decision = replace(decision, remains=True, unnamed=unnamed)
        notes.append(said('is_quantised', effect=unnamed))
    decision = with_level_of_innovations(decision)
    verdict = report(decision, list(filter(ids.__contains__, lattices)), validate, seed, notes)
    return replace(verdict, not_tried=reasons, between_recordings=(
        _differing(decision, recordings) if verdict.verdict == EFFECT else None))


def _differing(decision: Decision, recordings: Sequence[UniformRecording]
               ) -> dict[str, Any] | None:
    """Return by how much values of effects differ between recordings, None of one alone."""
    if len(recordings) < 2:
        return None
    effects = between_recordings(decision.data.recordings if decision.slips else recordings,
                                 decision.fit.candidate, decision.fit.z, decision.recordings.level)
    return {name: {key: asdict(value) for key, value in values.items()}
            for name, values in effects.items()}


def shown_effects(chosen: Sequence[str], model: DriveModel, recordings: Sequence[UniformRecording]
                  ) -> tuple[list[str], dict[str, Said]]:
    """
    Return (ids of the effects that recordings show, {id: why not} of all others).

    Args:
        chosen: ids of the effects to try.
        model: model of the drive.
        recordings: of it.

    Raises:
        InputError: none is shown.
    """
    reasons = {i: reason for i in library() if (reason := said('excluded') if i not in chosen else
                                                hidden_by(i, model, recordings))}
    ids = [i for i in chosen if i not in reasons]
    if not ids:
        raise InputError('effects: none remains that is visible on this drive and its encoders, '
                         'expected at least one')
    return ids, reasons


def _nuisance_notes(decision: Decision) -> list[Said]:
    """Return notes on how recordings were read, and on torque that nothing explains."""
    model, recordings = decision.model, decision.bare.recordings
    notes = [note for r in recordings for note in r.counted_on()]
    stated, lasts = (m.process_torque_time for m in (model, decision.recordings.model))
    if lasts != stated:
        notes.append(said('torque_lasts', seconds=lasts, stated=stated))
    if ACTUATOR_DELAY.id in decision.ids and any(is_open(r, model) for r in recordings):
        notes.append(said('delay_is_open', ms=0.5e3 * recordings[0].dt))
    return notes


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
        fit = fitted(otherwise.fine, unfitted(otherwise.fine, otherwise.starts.none()))
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
        nominal_run = evidence.fine.parts[number].run(closed.model, closed.torque).deviance
        text = '' if recording.doubt is None else recording.doubt.text
        if fit.deviance < nominal_run:
            raise InputError(f'{recording.name}: {text}')
        out.append(said('doubt_refuted', doubt=text))
    return out


def _shown_by_each(decision: Decision) -> Decision | None:
    """Return the decision for the effect that explains each recording by a value of its own."""
    data = decision.data
    fit = next((f for f in decision.fits if len(f.candidate.ids) == 1), None)
    if fit is None or not decision.remains or len(data.recordings) < 2:
        return None
    each = [replace(data, recordings=(r,)) for r in data.recordings]
    if not all(explains_all(one, fitted(one.fine, fit)) for one in each):
        return None
    return replace(decision, fit=fit, closed=fit, remains=False)


def chosen_ids(only: Sequence[str] | None, exclude: Sequence[str],
               options: tuple[str, str] = ('only', 'exclude'),
               effects: Collection[str] | None = None) -> list[str]:
    """
    Return the ids that are tried. Raises InputError for unknown ones, or where none remains.

    Args:
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
        options: what these are called.
        effects: all ids, None for those of a joint.
    """
    effects = library() if effects is None else effects
    for option, names in zip(options, (only, exclude)):
        for name in expect_list(option, names, 'ids of effects'):
            if name not in effects:
                raise InputError(f'{option}: unknown effect {name!r}, {unknown(name, effects)}')
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
    place, put_in = effect.location, recording.motor is not None
    hides = (
        effect.torque_only if model.controller else place == 'controller',
        place in missing or missing and effect.needs_both_encoders,
        put_in and effect.slip_profile is not None,
        put_in and place == 'motor_sensor' and (missing or effect.lattice),
        # Nothing turns with a position in m, and a weight is a constant load.
        model.axis == 'prismatic' and effect.rotary_only,
        # In a rigid drive it is indistinguishable from the same on the motor.
        model.transmission.kind == 'rigid' and (
            place == 'transmission' or effect.merges_if_rigid))
    return not any(hides)


@dataclass(frozen=True)
class ChangedValue:
    """
    One value of an effect that changed: `before` in the reference, `now`, both in `unit`.

    std: standard deviation of their difference, None where the recordings do not determine it.
    relative, relative_std: change over `before`, None where there was nothing before.
    """

    name: str
    unit: str
    before: float
    now: float
    std: float | None
    relative: float | None = None
    relative_std: float | None = None


@dataclass(frozen=True)
class ChangeFinding:
    """An effect that changed: its id, its place (location class), its values."""

    effect: str
    place: str
    values: tuple[ChangedValue, ...]


@dataclass(frozen=True)
class ChangeVerdict:
    """
    The change between a reference and a later recording.

    verdict: one of KINDS, about the change alone. findings: what changed, most evident first.
    remainder: place of a change that no finding explains, None without. held, holds: whether the
    model file explained the reference, and the later recording now; effects_before: what the
    reference showed beyond the model file. torque_noise: N m rms in a sample that neither
    explains. notes: doubts. model: the drive as it is now.
    """

    verdict: str
    findings: tuple[ChangeFinding, ...]
    remainder: str | None
    held: bool
    holds: bool
    effects_before: tuple[str, ...]
    torque_noise: float
    notes: tuple[Said, ...]
    model: DriveModel

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, as JSON has it."""
        return {'verdict': self.verdict, 'findings': [asdict(f) for f in self.findings],
                'remainder': self.remainder, 'model_held': self.held, 'model_holds': self.holds,
                'effects_before': list(self.effects_before), 'torque_noise': self.torque_noise,
                'notes': list(map(str, self.notes))}


class ReferenceFit(NamedTuple):
    """
    What a reference says of the drive.

    model: with all that it shows; held: whether the model file explained it; effects: beyond the
    file; misfit: of a typical window of 1 s, in standard deviations of the encoder noise;
    evidence, fit: of the reference under `model`.
    """

    model: DriveModel
    held: bool
    effects: tuple[str, ...]
    misfit: float
    evidence: DriveRecordings
    fit: InnovationFit


def diagnose_change(reference: UniformRecording, later: UniformRecording, model: DriveModel
                    ) -> ChangeVerdict:
    """
    Return what changed in a drive between two recordings of it.

    Args:
        reference: earlier recording, of the healthy drive.
        later: recording of the drive as it is now.
        model: of the model file, which need not explain the reference.

    Raises:
        InputError: the recordings differ in their rate or load, or the model takes no torque.
        Undecided: free runs are not finite.
    """
    if model.controller is not None or model.driven_by != 'torque':
        raise InputError('model file: controller or driven_by: position, expected a drive whose '
                         'torque is recorded: its changes are not named')
    reference, later = at_one_rate([reference, later])
    expect_one_rate([reference, later])
    if reference.channels != later.channels:
        raise InputError(f'{later.name}: other encoders than {reference.name}, expected the same')
    ids, _ = shown_effects(chosen_ids(None, ()), model, [reference, later])
    nominal = _reference_fit(reference, model, ids)
    evidence = evidence_of([later.as_read() if SLIP.id in ids else later], nominal.model, ids)
    otherwise = read_as_doubted(evidence)
    decision = decide(evidence)
    notes = doubts(decision, otherwise)
    findings = []
    errors, _ = standard_errors(decision.recordings.fine, decision.fit)
    for effect, values in decision.values.items():
        if _refuted(nominal, effect, values):
            findings.append(_finding(nominal, effect, values, errors.get(effect, {})))
        else:
            notes.append(said('baseline_allows', effect=effect))
    # The model of the reference has errors of its own.
    remains = decision.remains and (
        typical_misfit(decision.runs) > THRESHOLDS.misfit * nominal.misfit)
    if decision.remains and not remains:
        notes.append(said('remainder_as_before'))
    kind = kind_of(bool(findings), remains)
    return ChangeVerdict(
        kind, tuple(findings), decision.place if remains else None, nominal.held,
        nominal.held and kind == NONE and not decision.remains, nominal.effects,
        float(decision.fit.torque.max()), tuple(notes), decision.closed.model)


def _reference_fit(recording: UniformRecording, model: DriveModel, ids: Sequence[str]
                   ) -> ReferenceFit:
    """
    Return what a reference says of the drive.

    Args:
        recording: the reference.
        model: of the model file.
        ids: effects that may be there.
    """
    evidence = evidence_of([recording], model, ids)
    plain = _plain_fit(evidence)
    if explains_all(evidence, plain):
        return _closed(recording, plain, model.process_torque, True, ())
    # Torque noise of the drive itself is no effect: as much as the file leaves is allowed.
    noise = max(float(plain.torque.max()), model.process_torque or 0.0)
    decision = decide(evidence_of([recording], replace(model, process_torque=noise), ids))
    fit = decision.closed
    same = replace(decision.recordings.model, process_torque=model.process_torque) == model
    return _closed(recording, fit, float(fit.torque.max()),
                   same and not (decision.ids or decision.remains), decision.ids)


def _plain_fit(evidence: DriveRecordings) -> InnovationFit:
    """Return the fit without effects."""
    return fitted(evidence.fine, unfitted(evidence.fine, evidence.starts.none()))


def _closed(recording: UniformRecording, fit: InnovationFit, noise: float | None, holds: bool,
            effects: tuple[str, ...]) -> ReferenceFit:
    """
    Return the ReferenceFit with the model of a fit, which is exact from then on.

    Args:
        recording: the reference.
        fit: of all that it shows.
        noise: torque noise that is allowed, N m rms in a sample, None: none.
        holds: whether the model file explained it.
        effects: beyond the file.
    """
    model = replace(fit.model.folded(), process_torque=noise, tolerance=0.0)
    evidence = evidence_of([recording], model, ())
    plain = _plain_fit(evidence)
    return ReferenceFit(model, holds, effects, typical_misfit(evidence.runs(plain)), evidence,
                        plain)


def _refuted(nominal: ReferenceFit, effect: str, values: Values) -> bool:
    """
    Return whether the reference refutes an effect of this size.

    Args:
        nominal: what the reference says.
        effect: id.
        values: of its parameters now.
    """
    if library()[effect].is_event:
        return True
    model = with_effects(nominal.model, [{'id': effect, **values}])
    fine, fit = nominal.evidence.fine, nominal.fit
    plain = fine.run(nominal.model, fit.torque).deviance
    return bool(fine.run(model, fit.torque).deviance - plain > THRESHOLDS.isolable)


def _finding(nominal: ReferenceFit, effect: str, values: Values,
             errors: Mapping[str, float]) -> ChangeFinding:
    """
    Return an effect as a change.

    Args:
        nominal: what the reference says.
        effect: id.
        values: of its parameters now.
        errors: standard errors of these.
    """
    earlier, earlier_errors = _earlier(nominal, effect, values)
    rows = []
    for parameter in library()[effect].parameters:
        name = parameter.name
        if name not in values:
            continue
        own, before = errors.get(name), earlier.get(name, 0.0)
        value = ChangedValue(name, on_axis(parameter.unit, nominal.model.axis), before,
                             float(values[name]), None if own is None else math.hypot(
                                 own, earlier_errors.get(name, 0.0)))
        if before and value.std is not None:
            value = replace(value, relative=value.now / before - 1.0,
                            relative_std=value.std / abs(before))
        rows.append(value)
    return ChangeFinding(effect, library()[effect].location, tuple(rows))


def _earlier(nominal: ReferenceFit, effect: str, now: Values
             ) -> tuple[dict[str, float], dict[str, float]]:
    """Return ({parameter: value}, {parameter: standard error}) of an effect in the reference."""
    values = origin(nominal.model, effect, now.get('N'))
    if not values or (effect in PHASED and not values.get(amplitude(effect))):
        return values, {}
    candidate = nominal.evidence.starts.at(effect, values)
    errors, _ = standard_errors(nominal.evidence.fine, InnovationFit(
        candidate, candidate.start(), nominal.fit.torque))
    return values, {k: v for k, v in errors.get(effect, {}).items() if math.isfinite(v)}
