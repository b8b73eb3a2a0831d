# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The verdict of a diagnosis with its evidence, as plain data."""
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from gearbox_monitor.errors import Undecided
from gearbox_monitor.identification import (
    closed_model, isolability, localisation, verdict_parts)
from gearbox_monitor.identification.adequacy import misfit, on_all, residual_law, sharpened
from gearbox_monitor.identification.candidates import (
    CandidateModel, GAINS, NOT_FITTED, NUISANCES, SHAPES, with_effects, ZERO)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.residual_dependence import ResidualDependence
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.selection import gain
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.quality.recording import UniformRecording

# In the order of the encoders.
LATTICES = tuple(name for name, effect in EFFECTS.items() if effect.lattice)


@dataclass(frozen=True)
class DiagnosisVerdict:
    """
    What a diagnosis found; see docs/diagnose.md for each field of `data`.

    model: DriveModel that closes the gap as far as is known; without effect or map, with the
    values of the model that were estimated along.
    """

    data: Mapping[str, Any]
    model: DriveModel
    search: Search = field(repr=False)

    def with_data(self, **entries: Any) -> 'DiagnosisVerdict':
        """Return the verdict with other `entries` of its data."""
        return replace(self, data={**self.data, **entries})

    def warned(self, warning: str) -> 'DiagnosisVerdict':
        """Return the verdict with one more `warning`."""
        return self.with_data(warnings=[*self.data['warnings'], warning])

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, as JSON has it."""
        return dict(self.data)


def location_of(name: str) -> str:
    """Return the location class of the effect `name`."""
    return library()[name].location


def report(search: Search, best_fit: CandidateFit, closed_fit: CandidateFit, kind: str,
           lattices: list[str], quantum: Array, validate: UniformRecording | None,
           seed: int) -> DiagnosisVerdict:
    """
    Return the Verdict with all evidence.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that is reported.
        closed_fit: the same, or with a torque map of its remainder.
        kind: kind of the verdict: effect, none or unknown.
        lattices: ids of the quantisations of the encoders.
        quantum: quantisation steps of the encoders [2], rad.
        validate: recording for validation, or None.
        seed: seed of the random numbers.
    """
    ids = list(best_fit.candidate.ids)
    weighed, weighed_fit, phi = search, best_fit, search.long.colour
    search = weighed.in_sensor_units()
    if search is not weighed:
        best_fit = search.fitted[best_fit.name]
        if phi is None:
            search, best_fit = sharpened(search, best_fit)
    else:
        weighed, weighed_fit = search, best_fit = sharpened(search, best_fit)
    if TORQUE_MAP.id in closed_fit.candidate.ids:
        closed_fit = replace(closed_fit, point=search.long.evaluate(
            closed_fit.candidate, closed_fit.point))
    else:
        closed_fit = best_fit
    judging, judged_fit = (search, best_fit) if phi is None else (weighed, weighed_fit)
    places = localisation.places(judging, judging.fitted[''], judging.jobs)
    whole, left_on_all = on_all(judging, judged_fit)
    excess, structure = misfit(whole, left_on_all)
    law = residual_law(whole, left_on_all)
    none = search.fitted['']
    if kind == 'none' and lattices:
        kind, ids = 'effect', lattices[:2]
    elif kind == 'effect' and lattices and len(ids) == 1:
        ids = [*ids, lattices[0]]
    effects = ids if kind == 'effect' else []
    locations = [location_of(i) for i in effects]
    if kind == 'unknown':
        judged = int(whole.long.train.sum()) * whole.long.size
        reduced_chi2 = 1.0 + excess - (law.gain if law else 0.0) / judged
        places['location'] = nearly_known(judging,
                                          judged_fit) or unknown_place(places, law, reduced_chi2)
        locations = [places['location']]
    nuisances, parameters = closed_fit.candidate.values(closed_fit.point.z)
    model = closed_fit.candidate.model(closed_fit.point.z)
    if set(best_fit.candidate.ids) & set(NOT_FITTED):
        model = none.candidate.model(none.point.z)
    params = {name: {k: float(v) for k, v in values.items()}
              for name, values in zip(best_fit.candidate.ids, parameters)}  # no map
    for i, name in enumerate(LATTICES):
        if name in ids:
            params[name] = {'q': float(quantum[i])}
            model = with_effects(model, [*model.effects, {'id': name, **params[name]}])
    closure = closed_model.closure(
        search, none, closed_fit if closed_fit.candidate.ids else None, seed)
    deviations = list(closure['standard_errors'].pop(TORQUE_MAP.id, {}).values())
    torque_map = next((e for e in model.effects if deviations and e['id'] == TORQUE_MAP.id), None)
    if torque_map is not None:
        torque_map = {**torque_map, 'deviations': deviations}
        model = with_effects(model, [torque_map])
    if phi is not None and closure['standard_errors']:
        closure['standard_errors'], closure['condition'] = closed_model.standard_errors(
            weighed, weighed_fit)
    if kind == 'effect' and any(i in NOT_FITTED for i in ids):
        closure.update(closed_fraction=None, closed_fraction_ci=None)
    ranked = [name for size in (1, 2, 3) for name in weighed.ranked(size)]
    ranked = sorted(ranked, key=lambda n: weighed.fitted[n].score)
    order = list(dict.fromkeys([*effects, *(i for n in ranked for i in n.split('+'))]))
    times = noise_times(search, phi)
    data = {
        'verdict': kind,
        'effect': '+'.join(effects) if effects else None,
        'location': ('none' if kind == 'none' else locations[0] if len(locations) == 1
                     else locations),
        'ranked': order,
        'confusable': isolability.confusable(weighed, weighed_fit) if kind == 'effect' else [],
        'params': params if kind != 'none' else {},
        **closure,
        'sigma': [float(s) if i in search.long.channels else None
                  for i, s in enumerate(search.long.sigma)],
        'noise_time': times,
        'nominal': co_estimated(search.model, nuisances),
        'process_torque': float(best_fit.s),
        # With torque noise only those fitted with it can be compared; the others stand behind.
        'gains': {n: round(gain(weighed, weighed.fitted[n]), 1) for n in ranked
                  if not search.noisy or weighed.fitted[n].white is not None},
        'misfit': {'excess': excess, 'structure': structure,
                   'follows': None if law is None else asdict(law)},
        'where': places,
        'identified': verdict_parts.identified(
            search, closed_fit, params, closure['standard_errors']) if kind != 'none' else [],
        'remainder': verdict_parts.remainder(
            search, best_fit, places['location'], law, torque_map) if kind == 'unknown' else None,
        'warnings': warnings(search, best_fit, kind, nuisances, times),
    }
    if nuisances:
        data['nominal_shift'] = shifts(closed_fit.candidate, nuisances)
    _require_solution(search, data)
    if data['closed_fraction'] is not None and data['closed_fraction'] < 0.0:
        data.update(closed_fraction=None, closed_fraction_ci=None)  # of what is not claimed
    if validate is not None:
        data['validation'] = closed_model.validate(validate, search.model, model,
                                                   search.long.sigma)
    return DiagnosisVerdict(data, model, weighed)


def _require_solution(search: Search, data: Mapping[str, Any]) -> None:
    """Raise Undecided if the figures `data` of a verdict are those of a fit that failed."""
    gaps = data['gap_before'], data['gap_after']
    if not np.isfinite(gaps).all():
        raise Undecided('diagnose: free runs of the model are not finite: no solution; check '
                        'the model file (inertias, stiffness, damping)')
    windows = search.long.windows
    rows = windows.first[:, None] + np.arange(windows.length)
    readings = (search.recording.y / search.long.sigma)[rows][:, :, list(search.long.channels)]
    rest = float(np.sqrt(readings.var(axis=1).mean()))
    if data['gap_after'] > max(rest, THRESHOLDS.motion):
        raise Undecided(f'diagnose: free runs of 1 s miss the readings by {gaps[1]:.4g} standard '
                        f'deviations, one that stood still by {rest:.4g}: no solution; check '
                        'the model file, or fit it with fit-nominal')
    fraction = data['closed_fraction']
    if data['verdict'] == 'effect' and fraction is not None and fraction < 0.0:
        raise Undecided(f'diagnose: {data["effect"]} leaves {gaps[1]:.4g} standard deviations on '
                        f'windows that were not fitted, the model file {gaps[0]:.4g}: no '
                        'solution; record longer, or more kinds of motion')


def unknown_place(places: Mapping[str, Any], law: ResidualDependence | None,
                  reduced_chi2: float) -> str:
    """
    Return the location of an unknown effect for which no known one nearly stands.

    A law decides between places where free signals explain as much, if it leaves about as little.

    Args:
        places: result of `localisation.places`.
        law: dependence of the residual on the motion, None if there is none.
        reduced_chi2: chi2 per reading that the best fit and the law leave.
    """
    free_chi2 = {place: figures['left'] for place, figures in places['places'].items()}
    smallest = min(free_chi2.values())
    if (law is not None and reduced_chi2 < THRESHOLDS.law_tie * smallest
            and free_chi2[localisation.signal_of(law.place)] < THRESHOLDS.place_tie * smallest):
        return law.place
    return str(places['location'])


def nearly_known(search: Search, best_fit: CandidateFit) -> str | None:
    """
    Return the location of the effects of `best` that explain nearly all of the gap, or None.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that is reported.
    """
    classes = {location_of(i) for i in best_fit.candidate.ids}
    none = float(search.fitted[''].point.chi2.sum())
    gap = none - search.long.size * len(search.long.windows)
    explained = none - float(best_fit.point.chi2.sum())
    if search.noisy or len(classes) != 1 or explained < THRESHOLDS.nearly_all * gap:
        return None
    return classes.pop()


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


def noise_times(search: Search, phi: Array | None) -> list[float | None]:
    """
    Return over which time (s) the noise of each encoder is correlated, None: it is white.

    Args:
        search: fits of all candidates to one recording.
        phi: correlation of neighbouring readings of each encoder.
    """
    return [float(-search.recording.dt / np.log(p)) if p > 0.0 else None
            for p in (np.zeros(2) if phi is None else phi)]


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


def warnings(search: Search, best_fit: CandidateFit, kind: str, nuisances: Mapping[str, float],
             times: Sequence[float | None]) -> list[str]:
    """
    Return sentences about what weakens the verdict; times [2]: see noise_times.

    Args:
        search: fits of all candidates to one recording.
        best_fit: fit that is reported.
        kind: kind of the verdict: effect, none or unknown.
        nuisances: relative changes of nominal values by name.
        times: correlation times of the encoder noise [2], s; None: white.
    """
    out = [f'the noise of the {name} encoder lasts {1e3 * time:.2g} ms, as if it were filtered: '
           'it is judged with that' for name, time in zip(('motor', 'arm'), times) if time]
    sharpness = co_estimated(search.model, nuisances)
    out += [f'friction of the {side} has another shape than in the model file: its sharpness is '
            f'{sharpness[name]:.3g}, not {value:.3g} s/rad; its size stands'
            for name, side, value in (('alpha', 'motor', search.model.friction_sharpness),
                                      ('alpha_arm', 'arm', search.model.arm_sharpness))
            if name in nuisances and abs(np.log1p(nuisances[name])) > THRESHOLDS.shape]
    bound = best_fit.candidate.at_bound(best_fit.point.z)
    if (kind == 'unknown' and len(search.long.channels) == 1
            and search.model.transmission.kind != 'rigid'):
        out.append('one encoder: where an unknown effect acts is a guess, record both to know')
    if bound and kind != 'none':
        out.append(f'{", ".join(bound)}: at the bound of what is possible')
    if nuisances and best_fit.candidate.penalty(best_fit.point.z) > THRESHOLDS.effect_gain:
        shift = shifts(best_fit.candidate, nuisances)
        farthest = max(shift, key=lambda n: abs(shift[n]))
        out.append(f'nominal values lie far outside their tolerance (most: {farthest}, '
                   f'{shift[farthest]:+.1f} tolerances): the tolerance '
                   'looks too small, or several values have changed')
    return out
