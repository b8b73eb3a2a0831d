# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The verdict of a diagnosis: findings with their values, the remainder, and the evidence."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from itertools import chain
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.hypothesis import (
    Finding, kind_of, NONE, of_rival, Remainder, UNDECIDED, UNKNOWN)
from gearbox_monitor.diagnosis.joint import windows
from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, GAINS, NUISANCES, replaced_value, SHAPES, with_effects, ZERO)
from gearbox_monitor.diagnosis.joint.decision import Decision, standard_errors
from gearbox_monitor.diagnosis.joint.effect_scan import rivals, separations
from gearbox_monitor.diagnosis.joint.innovations import fitted, InnovationFit
from gearbox_monitor.diagnosis.joint.windows import misfit_of, solve_states, WindowRuns
from gearbox_monitor.diagnosis.settings import STATEMENTS, THRESHOLDS
from gearbox_monitor.errors import Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.arm_side import ARM_INERTIA, DISTURBANCE, GRAVITY
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.presentation import Said, said
from gearbox_monitor.signals.uniform import UniformRecording

# In the order of the encoders.
LATTICES = tuple(name for name, effect in EFFECTS.items() if effect.lattice)
ARMS = (0.1, 0.3)  # m: distances at which a payload is stated whose weight is not known


@dataclass(frozen=True, repr=False)
class Verdict:
    """
    The verdict of a diagnosis; docs/diagnose.md explains each field.

    model: DriveModel that closes the gap as far as is known; without effect or map, with the
    values of the model that were estimated along. basis: what the search found. not_tried {effect:
    why} of the library. questions: changes that do not show, or not apart from a rival, with the
    motion that would decide. model_values {effect: {parameter: value of the nominal model}}.
    """

    verdict: str
    effect: str | None
    location: str | list[str]
    findings: tuple[Finding, ...]
    ranked: list[str]
    confusable: list[str]
    params: Mapping[str, Mapping[str, float]]
    gap_before: float
    gap_after: float
    floor: float
    closed_fraction: float | None
    closed_fraction_ci: list[float] | None
    gaps: Sequence[Mapping[str, Any]]
    standard_errors: Mapping[str, Mapping[str, float]]
    condition: float | None
    at_bound: list[str]
    sigma: list[float | None]
    noise_time: list[float | None]
    nominal: Mapping[str, float]
    process_torque: float | None
    gains: Mapping[str, float]
    misfit: Mapping[str, Any]
    remainders: Sequence[Mapping[str, Any]]
    warnings: list[Said]
    bursts: list[Mapping[str, Any]]
    slips: list[Mapping[str, Any]]
    equivalent: list[Said]
    model_values: Mapping[str, Mapping[str, float]]
    model: DriveModel = field(repr=False)
    basis: Decision = field(repr=False)
    nominal_shift: Mapping[str, float] | None = None
    validation: Mapping[str, Any] | None = None
    not_tried: Mapping[str, Said] = field(default_factory=dict)
    questions: list[Mapping[str, Any]] = field(default_factory=list)
    between_recordings: Mapping[str, Any] | None = None

    @property
    def kind(self) -> str:
        """One of KINDS."""
        return self.verdict

    @property
    def data(self) -> dict[str, Any]:
        """The verdict as plain data."""
        return self.to_dict()

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, as JSON has it."""
        data = {f.name: getattr(self, f.name) for f in fields(self)
                if f.name not in ('model', 'basis')}
        data['axis'] = self.basis.model.axis
        data['findings'] = [finding.to_dict() for finding in self.findings]
        data |= {name: list(map(str, data[name])) for name in ('warnings', 'equivalent')}
        data['not_tried'] = {name: str(why) for name, why in self.not_tried.items()}
        for name in ('nominal_shift', 'validation', 'between_recordings'):
            if data[name] is None:
                del data[name]
        return data


def location_of(name: str) -> str:
    """Return the location class of the effect `name`."""
    return library()[name].location


def report(decision: Decision, lattices: Sequence[str], validate: UniformRecording | None,
           seed: int, notes: Sequence[Said] = ()) -> Verdict:
    """
    Return the Verdict with all evidence.

    Args:
        decision: what the search found.
        lattices: ids of quantisations that may be named.
        validate: recording for validation, or None.
        seed: seed of the random numbers.
        notes: on the search.
    """
    data, candidate = decision.data, decision.fit.candidate
    effects = _named(decision, lattices)
    kind = kind_of(bool(effects), decision.remains)
    unseen = decision.outcome.evidence.hidden(decision.outcome.none) if kind == NONE else []
    kind = UNDECIDED if unseen else kind
    params, model = _closed(decision, effects)
    errors, condition = standard_errors(data.fine, decision.closed)
    torque_map = _torque_map(model, decision, errors)
    if torque_map is not None:
        model = with_effects(model, [torque_map])
    errors = {name: errors[name] for name in candidate.ids}
    others = rivals(data, decision.fit, decision.fits,
                    separations(data, decision.fit, decision.fits, decision.orders))
    shares = explained_shares(decision)
    findings = tuple(_finding(decision, name, params.get(name, {}), errors.get(name, {}),
                              shares.get(name, (None, None)), others) for name in effects)
    return Verdict(
        verdict=kind, effect='+'.join(effects) or None, findings=findings,
        confusable=list(dict.fromkeys(chain(*others.values() if effects else ()))),
        params=params, standard_errors=errors, condition=condition,
        at_bound=candidate.at_bound(decision.fit.z),
        remainders=[remainder(decision, torque_map)] if decision.remains else [],
        warnings=[*notes, *warnings(decision, kind)],
        bursts=[*map(asdict, decision.bursts)], slips=[*map(asdict, decision.slips)],
        equivalent=equivalents(findings, decision.model),
        model_values=model_values(params, decision.model), model=model, basis=decision,
        questions=[*map(asdict, unseen), *_questions(decision, findings)],
        validation=None if validate is None else windows.validate(
            validate, decision.model, model, data.level),
        location=_located(decision, kind, effects), **_closure(decision, seed), **_noise(decision),
        **_ranked(decision, effects), **_nominal(decision))


def _questions(decision: Decision, findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """Return which motion would tell findings from their rivals."""
    return [asdict(of_rival(*decision.data.asked(finding.effect), rival, 0.0))
            for finding in findings for rival in finding.confusable]


def _named(decision: Decision, lattices: Sequence[str]) -> list[str]:
    """Return the effects that a decision names, with `lattices` beside one that is alone."""
    effects = [*decision.ids]
    if not decision.remains and len(effects) < 2:
        effects += lattices[:1 if effects else 2]
    return effects


def _located(decision: Decision, kind: str, effects: Sequence[str]) -> str | list[str]:
    """Return the place of each effect, or of what remains without one."""
    places = [decision.place] if kind == UNKNOWN else [location_of(i) for i in effects]
    return places if len(places) > 1 else (*places, NONE)[0]


def _closed(decision: Decision, effects: Sequence[str]
            ) -> tuple[dict[str, dict[str, float]], DriveModel]:
    """Return ({effect: {parameter: value}} of `effects`, the model that closes the gap)."""
    model, params = decision.closed.model, {
        name: {k: float(v) for k, v in values.items()}
        for name, values in decision.values.items() if not library()[name].is_event}
    for name, step in zip(LATTICES, decision.recordings.quantum):
        if name in effects:
            params[name] = {'q': float(step)}
            model = with_effects(model, [*model.effects, {'id': name, **params[name]}])
    return params, model


def _noise(decision: Decision) -> dict[str, Any]:
    """Return the noise of encoders and torque, and what of it remains unexplained."""
    data, remains, follows = decision.data, decision.outcome.remains, decision.follows
    channels = {i for r in data.recordings for i in r.channels}
    worth = {'torque': remains.torque, 'memory': remains.memory}
    return {
        'sigma': [float(s) if i in channels else None for i, s in enumerate(data.level)],
        'noise_time': decision.recordings.noise_time,
        'process_torque': None if data.balances else float(decision.fit.torque[0]),
        'misfit': {name: _finite(value) for name, value in worth.items()} | {
            'follows': follows and {name: getattr(follows, name)
                                    for name in ('place', 'over', 'gain')}}}


def _finite(value: float) -> float | None:
    """Return a number, None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def _ranked(decision: Decision, effects: Sequence[str]) -> dict[str, Any]:
    """Return the gains of all that was scored, and effects by their gains, those named first."""
    gains = decision.gains
    ranked = sorted(gains, key=lambda name: -gains[name])
    return {'ranked': list(dict.fromkeys([
        *effects, *chain.from_iterable(name.split('+') for name in ranked)])),
            'gains': {name: round(gain, 1) for name, gain in gains.items()
                      if math.isfinite(gain)}}


def _nominal(decision: Decision) -> dict[str, Any]:
    """Return the nominal values that were estimated along, and by how many deviations."""
    nuisances = decision.nuisances
    return {'nominal': co_estimated(decision.model, nuisances),
            'nominal_shift': shifts(decision.closed.candidate, nuisances) if nuisances else None}


def _closure(decision: Decision, seed: int) -> dict[str, Any]:
    """Return windows.closure of a decision, without a fraction that is not claimed."""
    runs = decision.compared
    out = windows.closure(runs.published, runs.closed, bool(decision.closed.candidate.ids),
                               seed)
    if out['closed_fraction'] is not None and out['closed_fraction'] < 0.0:
        out.update(closed_fraction=None, closed_fraction_ci=None)
    if not np.isfinite([out['gap_before'], out['gap_after']]).all():
        raise Undecided('free runs of the model are not finite: no solution; check '
                        'the model file (inertias, stiffness, damping)')
    return out


def _torque_map(model: DriveModel, decision: Decision, errors: Mapping[str, Mapping[str, float]]
                ) -> dict[str, Any] | None:
    """Return the torque map of the closed model with its deviations, None without."""
    effect = next((dict(e) for e in model.effects if e['id'] == TORQUE_MAP.id), None)
    if effect is None or TORQUE_MAP.id not in decision.closed.candidate.ids:
        return None
    return {**effect, 'deviations': list(errors.get(TORQUE_MAP.id, {}).values())
            or effect['deviations']}


def _finding(decision: Decision, name: str, values: Mapping[str, float],
             errors: Mapping[str, float], attribution: tuple[str | None, float | None],
             others: Mapping[str, Sequence[str]]) -> Finding:
    """
    Return the effect `name` as a finding.

    attribution: the reading that shows it, its share; others: its rivals, by effect.
    """
    channel, share = attribution
    deviations: dict[str, float | None] = {
        key: errors[key] if _determined(key, value, errors.get(key)) else None
        for key, value in values.items()}
    if name in LATTICES:
        deviations = dict.fromkeys(values, 0.0)
        channel = decision.data.recordings[0].readings[LATTICES.index(name)]
    if library()[name].is_event:
        values = decision.values[name]
        deviations = dict.fromkeys(values)
        if name == SLIP.id:
            deviations['Ds'] = decision.largest_slip.std
    return Finding(name, location_of(name), values, deviations, decision.evidence_for(name), share,
                   channel, confusable=tuple(others.get(name, ())))


def _determined(name: str, value: float, error: float | None) -> bool:
    """Return whether a recording determines a value: better than its size, a phase than 1 rad."""
    size = 1.0 if name == 'phi' else abs(value)
    return error is not None and (error == 0.0 or error < STATEMENTS.undetermined * size)


def explained_shares(decision: Decision) -> dict[str, tuple[str, float | None]]:
    """
    Return {effect: (reading in which it shows, share of the misfit that it explains)}.

    share: of the squared misfit beyond noise that returns without the effect, the states of the
    windows fitted again; None where nothing is beyond noise.
    """
    runs, ids = decision.compared, decision.ids
    total, out = sum(float(run.chi2.sum()) - run.residual.size for run in runs.none), {}
    for name in ids:
        if name in (TORQUE_MAP.id, DISTURBANCE.id):
            continue
        losses = np.zeros(2)
        others = (decision.data.calm(decision.bare.runs(decision.fit))
                  if name == SLIP.id and len(ids) > 1 else runs.none)
        for none, run in zip(others, runs.laws):
            without = none.residual if len(ids) == 1 or name == SLIP.id else _without(
                run, decision.model, name)
            change = (without ** 2).sum(axis=(0, 1)) - (run.residual ** 2).sum(axis=(0, 1))
            losses[run.data.channels] += change
        out[name] = (decision.data.recordings[0].readings[int(np.argmax(losses))],
                     float(np.clip(losses.sum() / total, 0.0, 1.0)) if total > 0.0 else None)
    return out


def without_idle_laws(decision: Decision) -> Decision:
    """
    Return a decision without laws that explain next to nothing of the misfit, against the largest.

    Where something has no known cause, such a law imitates a part of it; free runs deny it, also
    one that stands alone.

    Args:
        decision: of a contest.
    """
    shares = {name: share for name, (_, share) in (
        explained_shares(decision) if decision.remains else {}).items() if share is not None}
    largest = max(shares.values(), default=0.0)
    idle = {name for name in decision.fit.candidate.ids
            if shares.get(name, math.inf) <= THRESHOLDS.idle * largest}
    if not idle:
        return decision

    def reduced(fit: InnovationFit) -> InnovationFit:
        """Return a fit without the idle laws."""
        ids = fit.candidate.ids
        candidate, z = decision.data.starts.reduced(
            fit.candidate, fit.z, [i for i, name in enumerate(ids) if name not in idle])
        return fitted(decision.data.fine, InnovationFit(candidate, z, fit.torque))
    fit = reduced(decision.fit)
    closed = fit if decision.closed is decision.fit else reduced(decision.closed)
    return without_idle_laws(replace(decision, fit=fit, closed=closed))


def _without(run: WindowRuns, nominal: DriveModel, name: str) -> Array:
    """Return the residual [W, L, C] of free runs without the effect `name` beyond the nominal."""
    bare = replace(run.model, effects=(
        *(e for e in run.model.effects if e['id'] != name),
        *(e for e in nominal.effects if e['id'] == name)))
    states, _ = solve_states(run.data, bare, run.states, run.memory)
    return run.data.residual(bare, states, run.memory)


def remainder(decision: Decision, torque_map: Mapping[str, Any] | None) -> dict[str, Any]:
    """
    Return the remainder: its place, the reading that shows it, its size there, over what.

    Args:
        decision: what the search found.
        torque_map: effect that closes a part of it, None if none does.
    """
    squares, counts = np.zeros(2), np.zeros(2)
    for run in decision.compared.laws:
        squares[run.data.channels] += (run.residual ** 2).sum(axis=(0, 1))
        counts[run.data.channels] += run.residual[:, :, 0].size
    reduced = squares / np.maximum(counts, 1)
    at = int(np.argmax(reduced))
    unexplained = Remainder(
        decision.place, decision.data.recordings[0].readings[at],
        float(decision.data.level[at]) * math.sqrt(max(0.0, float(reduced[at]) - 1.0)),
        None if decision.follows is None else decision.follows.over,
        times=tuple((b.t0, b.t0 + b.duration) for b in decision.bursts))
    return unexplained.to_dict() | {'torque_map': None if torque_map is None else {
        k: v for k, v in torque_map.items() if k != 'id'}}


def model_values(effects: Iterable[str], model: DriveModel) -> dict[str, dict[str, float]]:
    """
    Return what the nominal model has in place of effects, {effect: {parameter: value}}.

    Of an effect that replaces a value or adds to one, that value; of one that the model has, its
    parameters; others are left out.

    Args:
        effects: ids.
        model: the nominal one.
    """
    out: dict[str, dict[str, float]] = {}
    present = {e['id']: e for e in model.effects}
    for name in effects:
        effect = library()[name]
        value = model.value(effect.adds_to) if effect.adds_to else replaced_value(model, name)
        if value is not None:
            out[name] = {effect.parameters[0].name: float(value)}
        elif name in present:
            out[name] = {k: float(v) for k, v in present[name].items()
                         if isinstance(v, (int, float))}
    return out


def equivalents(findings: Sequence[Finding], model: DriveModel) -> list[Said]:
    """
    Return what else the values of findings may be called.

    Args:
        findings: of the verdict.
        model: the nominal model.
    """
    values = {finding.effect: finding.values for finding in findings}
    out = []
    if 'torque_gain' in values:
        factor = 1.0 / (1.0 + values['torque_gain']['g'])
        out.append(said('same_scale', factor=factor, gain=1.0 / factor))
    added = values[ARM_INERTIA.id]['m2'] - model.arm_inertia if ARM_INERTIA.id in values else 0.0
    if added > 0.0 and model.axis == 'prismatic':
        out.append(said('same_mass', mass=added))
    elif added > 0.0 and GRAVITY.id in values:
        weight = values[GRAVITY.id]['G'] - weight_of(model.effects)[0]
        if weight > 0.0:
            distance = scipy.constants.g * added / weight
            out.append(said('same_load', mass=added / distance ** 2, distance=distance))
    elif added > 0.0:
        r1, r2 = ARMS
        out.append(said('same_inertia', first=added / r1 ** 2, at=r1, second=added / r2 ** 2,
                        also=r2))
    return out


def co_estimated(model: DriveModel, nuisances: Mapping[str, float]) -> dict[str, float]:
    """
    Return {name: nominal value} as estimated along with the effect.

    Args:
        model: model of the drive.
        nuisances: relative changes of nominal values by name.
    """
    values = {name: float(model.value(where) * (1.0 + nuisances.get(name, 0.0)))
              for name, where in NUISANCES.items() if name not in GAINS or model.controller}
    for name, value in (('alpha', model.friction_sharpness), ('alpha_arm', model.arm_sharpness)):
        if name in nuisances:
            values[name] = float(value * (1.0 + nuisances[name]))
    if ZERO in nuisances:
        values[ZERO] = float(nuisances[ZERO])
    return values


def shifts(candidate: CandidateModel, nuisances: Mapping[str, float]) -> dict[str, float]:
    """
    Return {name: shift in standard deviations} of the values estimated along.

    Args:
        candidate: model to be fitted, with its coordinates.
        nuisances: relative changes of nominal values by name.
    """
    spread = {c.name: c.prior for c in candidate.coordinates if c.owner < 0}
    return {name: float((np.log1p(value) if name in SHAPES else value) / spread[name])
            for name, value in nuisances.items()}


def warnings(decision: Decision, kind: str) -> list[Said]:
    """
    Return what weakens the verdict.

    Args:
        decision: what the search found.
        kind: of the verdict.
    """
    model, candidate, z = decision.model, decision.fit.candidate, decision.fit.z
    nuisances = decision.nuisances
    out = [said('noise_lasts', side=name, ms=1e3 * time)
           for name, time in zip(('motor', 'arm'), decision.recordings.noise_time) if time]
    sharpness = co_estimated(model, nuisances)
    out += [said('friction_shape', side=side, sharpness=sharpness[name], stated=value)
            for name, side, value in (('alpha', 'motor', model.friction_sharpness),
                                      ('alpha_arm', 'arm', model.arm_sharpness))
            if abs(np.log1p(nuisances.get(name, 0.0))) > STATEMENTS.shape]
    law, stated = candidate.nominal.friction_law.kind, model.friction_law.kind
    published, closed = (misfit_of(runs) for runs in (
        decision.compared.published, decision.compared.closed))
    bound = candidate.at_bound(z)
    shift = shifts(candidate, candidate.values(z)[0])
    farthest = max(shift, key=lambda n: abs(shift[n]), default='')
    for applies, note in (
            (law != stated, said('friction_law', law=law, stated=stated)),
            (kind == NONE and published > THRESHOLDS.misfit * closed,
             said('file_misses', misfit=published)),
            (decision.remains and all(map(decision.data.hides, decision.data.recordings)),
             said('one_encoder')),
            (bound and kind != NONE, said('at_bounds', names=', '.join(bound))),
            (nuisances and candidate.penalty(z) > THRESHOLDS.isolable,
             said('beyond_tolerance', name=farthest, shift=shift.get(farthest, 0.0)))):
        out += [note] if applies else []
    return out
