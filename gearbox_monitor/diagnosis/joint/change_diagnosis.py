# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The change of a drive between two recordings of it, whatever its model file missed before.

The earlier recording, the reference, closes the model first: with its effects, its nominal values
and the torque noise that nothing explains. The later one is diagnosed against that model. An
effect of it counts as a change if the reference refutes it at the size that it has now: what the
reference did not show either way may have been there.
"""
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
import math
from typing import Any, NamedTuple

from gearbox_monitor.diagnosis.hypothesis import kind_of, NONE
from gearbox_monitor.diagnosis.joint.candidates import amplitude, PHASED, with_effects
from gearbox_monitor.diagnosis.joint.decision import decide, standard_errors
from gearbox_monitor.diagnosis.joint.diagnose import (
    chosen_ids, doubts, explains_all, hidden_by, read_as_doubted)
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings, evidence_of
from gearbox_monitor.diagnosis.joint.innovation_fit import fitted, InnovationFit, unfitted
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.presentation import on_axis, Said, said
from gearbox_monitor.signals.uniform import at_one_rate, expect_one_rate, UniformRecording


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
    ids = [i for i in chosen_ids(None, ()) if not hidden_by(i, model, [reference, later])]
    nominal = _reference_fit(reference, model, ids)
    evidence = evidence_of([later.as_read() if SLIP.id in ids else later], nominal.model, ids)
    otherwise = read_as_doubted(evidence)
    decision = decide(evidence)
    notes = [*decision.notes, *doubts(decision, otherwise)]
    findings = []
    errors, _ = standard_errors(decision.recordings, decision.fit)
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
    earlier, earlier_errors = _earlier(nominal, effect)
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


def _earlier(nominal: ReferenceFit, effect: str) -> tuple[dict[str, float], dict[str, float]]:
    """Return ({parameter: value}, {parameter: standard error}) of an effect in the reference."""
    entry = EFFECTS.get(effect)
    if entry is not None and entry.replaces:
        value = nominal.model.value(entry.replaces)
        values = {entry.parameters[0].name: value}
    else:
        values = next(({k: float(v) for k, v in e.items() if k != 'id'}
                       for e in nominal.model.effects if e['id'] == effect), {})
    if not values or (effect in PHASED and not values.get(amplitude(effect))):
        return values, {}
    candidate = nominal.evidence.starts.at(effect, values)
    errors, _ = standard_errors(nominal.evidence, InnovationFit(
        candidate, candidate.start(), nominal.fit.torque))
    return values, {k: v for k, v in errors.get(effect, {}).items() if math.isfinite(v)}
