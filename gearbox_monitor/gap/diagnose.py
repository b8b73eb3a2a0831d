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

"""
The diagnosis: where the gap between recording and model lies, which effect, how far it goes.

search: the Search with all fits; none, best: Fitted without effect, and the one that is reported;
kind: 'effect', 'none' or 'unknown'; candidate: its Candidate, nuisances: {name: relative change}.
recordings: of one drive; validate: one more, to judge by. only, exclude: ids of effects. lattices:
ids of quantisation; quantum [2]: steps of the encoders, rad. residual [W, L, C]: in sigmas.
phi [2]: see gap.colour. free: what a free torque on the arm would have to be. seed: of the
bootstrap.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from gearbox_monitor.arrays import Array
from gearbox_monitor.drive.effects import EFFECTS, library
from gearbox_monitor.drive.model import DriveModel
from gearbox_monitor.errors import InputError
from gearbox_monitor.gap import close, colour, isolate, lasting, noise, residual
from gearbox_monitor.gap.bursts import found_bursts
from gearbox_monitor.gap.candidate import (
    Candidate, NUISANCES, nuisances_of, PHASED, replaced_value, with_effects, ZERO)
from gearbox_monitor.gap.driven import driven
from gearbox_monitor.gap.pairs import find_pairs, forward_gains
from gearbox_monitor.gap.recording import Recording
from gearbox_monitor.gap.remainder import Remainder, remainder
from gearbox_monitor.gap.search import Fitted, Search

MARGIN = 25.0        # gain in BIC of one effect over none: covers the search over some 35
OWN_MARGIN = 16.0    # gain in -2 log L where the effect is a value that may scatter anyway
BOUND_MARGIN = 10.0  # gain in BIC that a parameter at its bound must bring
ALIKE = 1e-3         # share of the gain by which models are apart that move the drive alike
PAIR_MARGIN = 40.0   # gain in BIC of a second effect
PAIR_HINT = 60.0     # linearised gain of a second effect from which on pairs are fitted
LACK = 0.08          # excess of chi2 that is no matter of the noise level
LACK_RELATIVE = 2e-4  # of the gap: integration is not more accurate
STRUCTURE = 3.8      # standard deviations of the residual in a frequency band (skewed: chi2)
PAIR_STRUCTURE = 2.5  # the same for pairs, which imitate what is in no library
NOISY_STRUCTURE = 6.0  # where torque noise was taken out, to first order
STRUCTURE_RELATIVE = 0.04  # of the gap, as LACK_RELATIVE
BANDS = (0.0, 3.0, 8.0, 20.0, noise.MOTION)  # Hz
REMAINDER = 40.0     # gain in chi2 of a free function of the motion; by chance: at most 29 of 300
REMAINDER_RELATIVE = 5e-5  # of what the fit gains: integration is not more accurate
MAX_SHARPENING = 0.15  # correction of sigma that is believed
FINEST = 1e-4        # of the travel: on a real drive, differences below are no gap
LOOSE = 0.2          # of the torque: more that lasts and is not explained is an unknown effect
QUANTISED = 0.5      # step of a lattice over sigma, from which on rounding matters
ROUGH = 2.0          # the same, from which on it is no white noise any more
ROUGH_LACK, ROUGH_STRUCTURE, ROUGH_MARGIN = 0.2, 30.0, 250.0  # then: as without, and of bursts
SHARE = 0.5          # of what bursts explain, from which on one effect is a part of the answer
TWINS = ('torque_offset', 'coulomb_asymmetry')
ARM_TWINS = ('arm_viscous', 'arm_coulomb', 'arm_inertia', 'load_torque')
UNREPEATABLE = ('disturbance', 'motor_encoder_quantisation', 'arm_encoder_quantisation')


@dataclass
class Verdict:
    """
    What a diagnosis found; see docs/diagnose.md for each field of `data`.

    model: DriveModel with the effect, None where there is none to add.
    """

    data: dict[str, Any]
    model: DriveModel | None = None
    search: Search | None = field(default=None, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, as JSON has it."""
        return self.data


def joined(recordings: Sequence[Recording]) -> Recording:
    """Return one Recording of several of one drive. Raises InputError when rates differ."""
    first = recordings[0]
    if len(recordings) == 1:
        return first
    for other in recordings[1:]:
        if abs(other.dt / first.dt - 1.0) > 1e-3:
            raise InputError(f'{other.name}: {1 / other.dt:g} Hz, expected {1 / first.dt:g} Hz as '
                             f'{first.name}')
        if (other.arm_torque is None) != (first.arm_torque is None):
            raise InputError(f'{other.name}: arm torque: expected in all recordings or in none')
    sizes = [len(r.u) for r in recordings]
    return replace(
        first, t=np.arange(sum(sizes)) * first.dt,
        u=np.concatenate([r.u for r in recordings]), y=np.concatenate([r.y for r in recordings]),
        arm_torque=None if first.arm_torque is None else np.concatenate(
            [r.arm_torque for r in recordings]),
        motor=None if first.motor is None else np.concatenate([r.motor for r in recordings]),
        name=', '.join(r.name for r in recordings), cuts=tuple(np.cumsum([0, *sizes[:-1]])))


def diagnose(recordings: Sequence[Recording], model: DriveModel, *,
             validate: Recording | None = None, only: Sequence[str] | None = None,
             exclude: Sequence[str] = (), seed: int = 0, jobs: int = 1,
             progress: Callable[..., object] | None = None) -> Verdict:
    """
    Return the Verdict on `recordings` (Recording, of one drive) under the DriveModel `model`.

    validate: a further Recording, used for nothing but judging. only, exclude: ids of effects.
    seed: of the bootstrap. jobs: threads. progress(done, total, text). Raises InputError.
    """
    recording = joined([driven(r, model) for r in recordings])
    if recording.motor is not None:
        model = model.folded()  # a closed model is the next one to start from
    ids = [i for i in chosen_ids(only, exclude) if visible(i, model, recording)]
    if not ids:
        raise InputError('effects: none is left that this drive and its encoders show, expected '
                         'at least one')
    sigma, quantum = noise_floor(recording, model)

    def searched(sigma: Array, phi: Array | None = None) -> Search:
        search = Search(recording, model, sigma, ids, jobs, progress, phi)
        search.none()
        search.refine(search.screen())
        return search
    search = searched(sigma)
    best = min(search.fitted.values(), key=lambda f: f.score)
    if (recording.motor is None and (quantum <= QUANTISED * sigma).all()
            and lacks(search, best)):  # where one effect leaves white noise, it is white
        lasts = colour.measure(search, best)
        if lasts is not None:
            search = searched(*lasts)
            colour.settle(search)
            sigma = search.long.sigma
    rough = bool((quantum > ROUGH * sigma).any())
    best, kind = decide(search, rough)
    lattices = [name for i, name in enumerate(('motor_encoder_quantisation',
                                               'arm_encoder_quantisation'))
                if name in ids and quantum[i] > QUANTISED * sigma[i]
                and search.long.weighing is None]
    return report(search, best, kind, lattices, quantum, validate, seed)


def noise_floor(recording: Recording, model: DriveModel) -> tuple[Array, Array]:
    """Return (sigma [2], quantum [2]) of a Recording, rad; sigma not below what matters."""
    sigma, quantum = noise.noise_levels(recording.y)
    if model.process_torque_time > 0.0:
        sigma = np.maximum(sigma, FINEST * np.ptp(recording.y, axis=0))
    return sigma, quantum


def chosen_ids(only: Sequence[str] | None, exclude: Sequence[str]) -> list[str]:
    """Return the ids that may be named. Raises InputError for unknown ones."""
    known = library()
    for name in (*(only or ()), *exclude):
        if name not in known:
            raise InputError(f'effect: {name!r}, expected one of {", ".join(known)}')
    ids = [i for i in known if i not in exclude and (only is None or i in only)]
    if not ids:
        raise InputError('effects: none is left, expected at least one')
    return ids


def visible(name: str, model: DriveModel, recording: Recording) -> bool:
    """Return whether the effect `name` shows in readings of this drive, and under this name."""
    missing = {('motor_sensor', 'arm_sensor')[i] for i in (0, 1) if i not in recording.channels}
    place = location_of(name)
    if place in missing or (missing and name == 'encoder_offset'):
        return False
    if recording.motor is not None and place == 'motor_sensor' and (
            missing or name == 'motor_encoder_quantisation'):
        return False
    if model.axis == 'prismatic' and (name in PHASED or name == 'gravity'):
        return False  # nothing turns with a position in m, and a weight is a constant load
    # In a rigid drive the same on the arm cannot be told from it on the motor.
    return model.transmission.kind != 'rigid' or (
        place != 'transmission' and name not in ARM_TWINS)


# ---------------------------------------------------------------------- which


def gain(search: Search, fitted: Fitted) -> float:
    """Return by how much `fitted` beats none, in BIC."""
    return search.fitted[''].score - fitted.score


def convincing(search: Search, fitted: Fitted) -> bool:
    """Return whether `fitted` (one effect) beats none by more than the search itself explains."""
    names = {EFFECTS[i].parameters[0].name for i in fitted.candidate.ids
             if i in EFFECTS and EFFECTS[i].replaces}
    if 'encoder_offset' in fitted.candidate.ids:
        names.add(ZERO)
    if names & set(nuisances_of(search.model)):
        # Under scatter none may move this value, too: what counts is how far beyond the tolerance.
        penalty = fitted.candidate.n_effect * np.log(search.long.n_train)
        return gain(search, fitted) + penalty > OWN_MARGIN
    return gain(search, fitted) > MARGIN


def spectrum(search: Search, residual: Array) -> tuple[Array, Array, Array]:
    """
    Return (power [W, L, C], frequencies [L] Hz, white [C]) of residuals [W, L, C].

    white: mean power above the frequencies of motion.
    """
    power, at, high = noise.spectrum(residual, search.recording.dt)
    return power, at, power[:, high].mean(axis=(0, 1))


def sharpen_sigma(search: Search, best: Fitted) -> None:
    """Measure sigma anew in what `best` leaves at high frequencies; residuals follow it."""
    length = search.long.windows.length
    _, _, white = spectrum(search, search.long.parted(best.point.residual))
    factor = np.sqrt(white)
    if not (np.abs(factor - 1.0) < MAX_SHARPENING).all():
        return
    sigma = search.long.sigma.copy()
    sigma[search.long.channels] *= factor
    search.long.sigma = sigma
    for fitted in {id(f): f for f in (search.fitted[''], best)}.values():
        for name in ('residual', 'white'):
            owner = fitted.point if name == 'residual' else fitted
            if getattr(owner, name) is not None:
                setattr(owner, name, getattr(owner, name) / np.tile(factor, length))
        fitted.point.chi2 = (fitted.point.residual ** 2).sum(axis=1)


def misfit(search: Search, fitted: Fitted, spared: int = 0) -> tuple[float, float]:
    """
    Return (excess, structure) of what `fitted` leaves on the training windows.

    excess: chi2 per reading - 1. structure: by how many standard deviations the most conspicuous
    frequency band exceeds white noise of the power above BANDS; it does not depend on how well
    sigma is known. spared: how many of the worst windows do not count.
    """
    train = search.long.train
    r = fitted.point.residual if fitted.white is None else fitted.white
    r = search.long.parted(r[train])
    power, at, white = spectrum(search, r)
    structure = -np.inf
    for low, high in zip(BANDS, BANDS[1:]):
        inside = power[:, (at > low) & (at <= high)] / white
        # Without the worst window: one that found no good start is no unknown effect.
        ratio = np.sort(inside.mean(axis=(1, 2)))[:max(1, len(inside) - 1)].mean()
        structure = max(structure, (ratio - 1.0) / np.sqrt(2.0 / inside.size))
    chi2 = np.sort((r ** 2).mean(axis=(1, 2)))
    return float(chi2[:max(1, len(chi2) - spared)].mean() - 1.0), float(structure)


def lacks(search: Search, fitted: Fitted, rough: bool = False) -> bool:
    """Return whether `fitted` leaves more than noise; rough: an encoder has steps above noise."""
    if search.model.process_torque_time > 0.0:
        # No model of a real drive explains everything: the torque that is left tells.
        if fitted.left is not None:
            return bool((fitted.left > LOOSE * lasting.scales(search.recording)).any())
        return bool(fitted.s > LOOSE * np.std(search.recording.u))
    # A hard burst throws the arm to where a free signal does not find it.
    excess, structure = misfit(search, fitted, int('disturbance' in fitted.candidate.ids))
    before, _ = misfit(search, search.fitted[''])
    limit = (ROUGH_STRUCTURE if rough else
             NOISY_STRUCTURE if search.noisy else
             PAIR_STRUCTURE if len(fitted.candidate.ids) > 1 else STRUCTURE)
    return (excess > max(ROUGH_LACK if rough else LACK, LACK_RELATIVE * before)
            or structure > limit + STRUCTURE_RELATIVE * before)


def follows(search: Search, fitted: Fitted) -> Remainder | None:
    """Return what `fitted` leaves as a function of the motion, None where that is chance."""
    if search.noisy or search.recording.motor is not None:
        return None  # not white
    if 'disturbance' in fitted.candidate.ids:
        return None  # a free signal, of which the motion has been asked
    before = (search.fitted[''].point.chi2 - fitted.point.chi2).sum()
    found = remainder(search, fitted)
    return found if found.gain > REMAINDER + REMAINDER_RELATIVE * max(0.0, before) else None


def decide(search: Search, rough: bool = False) -> tuple[Fitted, str]:
    """
    Return (Fitted, 'effect' | 'none' | 'unknown'): what explains the recording best.

    rough: an encoder has steps above its noise.
    """
    known: dict[int, tuple[Fitted, bool]] = {}

    def lack(fitted: Fitted) -> bool:
        if id(fitted) not in known:
            known[id(fitted)] = fitted, lacks(search, fitted, rough) or (
                not rough and follows(search, fitted) is not None)
        return known[id(fitted)][1]

    none = search.fitted['']
    singles = search.ranked()
    if not singles:
        return none, 'unknown' if lack(none) else 'none'
    best = search.fitted[singles[0]]
    explained = by_bursts(search, best, singles, rough, lack)
    if explained is not None:
        return explained, 'effect'
    if convincing(search, best):
        search.challenge(best)
        none = search.fitted['']
    if not convincing(search, best):
        return none, 'unknown' if lack(none) else 'none'
    if lack(best) and not search.noisy:
        search.fitted[best.name] = search.polish(search.grown(best), [best.point])
        search.settle(singles[:2])
        best = search.fitted[search.ranked()[0]]
    best = finer(search, simpler(search, best), lack)
    hints = forward_gains(search, best)
    if lack(best) or max((g for g, _ in hints.values()), default=0.0) > PAIR_HINT:
        best = paired(search, singles, lack)
    best = finer(search, best, lack)
    return best, 'unknown' if lack(best) else 'effect'


def by_bursts(search: Search, best: Fitted, singles: Sequence[str], rough: bool,
              lack: Callable[[Fitted], bool]) -> Fitted | None:
    """
    Return the Fitted of bursts, or of a pair that explains them, None where there are none.

    best: of `singles`, names of effects; rough, lack: as of decide.
    """
    burst = found_bursts(search) if 'disturbance' in search.ids else None
    margin = (ROUGH_MARGIN if rough else MARGIN) + max(0.0, everywhere(search, best))
    if burst is None or gain(search, burst) <= margin or lack(burst):
        return None
    search.fitted['disturbance'] = burst
    if everywhere(search, best) < SHARE * gain(search, burst):
        return burst
    # One effect explains most of the bursts: two may explain them all, with less freedom.
    pairs = find_pairs(search, singles[:2])
    pair = search.fitted[pairs[0]] if pairs else best
    if lack(pair) or everywhere(search, pair) < gain(search, burst):
        return burst
    del search.fitted['disturbance']
    return pair


def paired(search: Search, singles: Sequence[str], lack: Callable[[Fitted], bool]) -> Fitted:
    """
    Return the best Fitted of one effect or two.

    singles: names of the best effects that a second one is added to; lack: as of decide.
    """
    pairs = find_pairs(search, singles[:2])
    careful = pairs[:2] if search.long.weighing is None else pairs
    search.whiten([search.ranked()[0], *careful] if pairs else [])
    pairs = sorted(pairs, key=lambda n: search.fitted[n].score)
    best = search.fitted[search.ranked()[0]]
    pair = search.fitted[pairs[0]] if pairs else best
    if pairs and lack(pair) and not search.noisy:
        # Where many windows are astray, they hold the values back that would free them.
        pair = search.fitted[pair.name] = search.polish(search.grown(pair), [pair.point])
    if best.score - pair.score > PAIR_MARGIN and not search.noisy:
        # What the pair has found for windows is no merit of its second effect.
        best = search.fitted[best.name] = search.polish(search.grown(best), [pair.point])
    if best.score - pair.score > PAIR_MARGIN and (lack(best) or not lack(pair)):
        return pair
    return best


def finer(search: Search, best: Fitted, lack: Callable[[Fitted], bool]) -> Fitted:
    """
    Return `best` on shorter steps, with which `search` then goes on, where it lacks but these.

    Steps are as long as the nominal drive allows; with the effect it may be a faster one, and the
    readings so good that the edges of its gap show. lack: as of decide.
    """
    if not lack(best) or search.noisy or search.recording.motor is not None:
        return best
    shorter = search.on_shorter_steps()
    if shorter is None:
        return best
    simulator, long, none = search.simulator, search.long, search.fitted['']
    search.simulator, search.long = shorter.simulator, shorter
    search.fitted[''] = search.anew(none)
    found = search.anew(best)
    if lack(found):
        search.simulator, search.long, search.fitted[''] = simulator, long, none
        return best
    search.fitted[found.name] = found
    return found


def simpler(search: Search, best: Fitted) -> Fitted:
    """
    Return an effect of fewer parameters instead of `best` that is at a bound and hardly better.

    Only where both move the drive alike, as in the limit: viscous_drift that has drifted from the
    first moment on is motor_viscous.
    """
    if not best.candidate.at_bound(best.point.z):
        return best
    alike = max(2.0 * BOUND_MARGIN, ALIKE * gain(search, best))
    for name in search.ranked()[1:]:
        other = search.fitted[name]
        if other.score - best.score > BOUND_MARGIN:
            break
        apart = ((other.point.residual - best.point.residual)[search.long.train] ** 2).sum()
        if other.candidate.n_effect < best.candidate.n_effect and apart < alike:
            return other
    return best


def everywhere(search: Search, fitted: Fitted) -> float:
    """Return by how much `fitted` beats none in BIC on all windows, held-out ones included."""
    n = search.long.size * len(search.long.windows)
    return float((search.fitted[''].point.chi2 - fitted.point.chi2).sum()
                 - fitted.candidate.n_effect * np.log(n))


# ---------------------------------------------------------------------- report


def location_of(name: str) -> str:
    """Return the location class of the effect `name`."""
    return library()[name].location


def report(search: Search, best: Fitted, kind: str, lattices: list[str], quantum: Array,
           validate: Recording | None, seed: int) -> Verdict:
    """Return the Verdict with all evidence."""
    ids = list(best.candidate.ids)
    weighed, weighed_best, phi = search, best, search.long.colour
    search = lasting.plain(search)
    if search is not weighed:
        best = search.fitted[best.name if ids else '']
    if phi is None:
        sharpen_sigma(search, best)
    judging, left = (search, best) if phi is None else (weighed, weighed_best)
    places = residual.places(judging, judging.fitted[''], judging.jobs)
    excess, structure = misfit(judging, left)
    law = follows(judging, left)
    none = search.fitted['']
    if kind == 'none' and lattices:
        kind, ids = 'effect', lattices[:2]
    elif kind == 'effect' and lattices and len(ids) == 1:
        ids = [*ids, lattices[0]]
    named = ids if kind == 'effect' else []
    locations = [location_of(i) for i in named]
    if kind == 'unknown':
        locations = [places['location']]
    model = None
    nuisances, given = best.candidate.values(best.point.z)
    if ids and set(ids) - set(UNREPEATABLE):
        model = best.candidate.model(best.point.z)
    params = {name: {k: float(v) for k, v in values.items()}
              for name, values in zip(best.candidate.ids, given)}
    for i, name in enumerate(('motor_encoder_quantisation', 'arm_encoder_quantisation')):
        if name in ids:
            params[name] = {'q': float(quantum[i])}
            model = with_effects(model or search.model, [
                *(model or search.model).effects, {'id': name, **params[name]}])
    closure = close.closure(search, none, best if best.candidate.ids else None, seed)
    if phi is not None and closure['standard_errors']:
        closure['standard_errors'], closure['condition'] = close.standard_errors(
            weighed, weighed_best)
    if kind == 'effect' and any(i in UNREPEATABLE for i in ids):
        closure.update(closed_fraction=None, closed_fraction_ci=None)
    ranked = weighed.ranked() + [n for size in (2,) for n in weighed.ranked(size)]
    ranked = sorted(ranked, key=lambda n: weighed.fitted[n].score)
    order = list(dict.fromkeys([*named, *(i for n in ranked for i in n.split('+'))]))
    values = {}
    for name in NUISANCES:
        value = next((replaced_value(search.model, i) for i in EFFECTS if EFFECTS[i].replaces and
                      EFFECTS[i].parameters[0].name == name)) or 0.0
        values[name] = float(value * (1.0 + nuisances.get(name, 0.0)))
    if ZERO in nuisances:
        values[ZERO] = float(nuisances[ZERO])
    times = noise_times(search, phi)
    data = {
        'verdict': kind,
        'effect': '+'.join(named) if named else None,
        'location': ('none' if kind == 'none' else locations[0] if len(locations) == 1
                     else locations),
        'ranked': order,
        'confusable': isolate.confusable(weighed, weighed_best) if kind == 'effect' else [],
        'params': params if kind != 'none' else {},
        **closure,
        'sigma': [float(s) if i in search.long.channels else None
                  for i, s in enumerate(search.long.sigma)],
        'noise_time': times,
        'nominal': values,
        'process_torque': float(best.s),
        # With torque noise only those fitted with it can be compared; the others stand behind.
        'gains': {n: round(gain(weighed, weighed.fitted[n]), 1) for n in ranked
                  if not search.noisy or weighed.fitted[n].white is not None},
        'misfit': {'excess': excess, 'structure': structure,
                   'follows': None if law is None else asdict(law)},
        'where': places,
        'warnings': warnings(search, best, kind, nuisances, times),
    }
    if nuisances:
        data['nominal_shift'] = shifts(best.candidate, nuisances)
    if validate is not None:
        data['validation'] = close.validate(validate, search.model, model or search.model,
                                            search.long.sigma)
    return Verdict(data, model, weighed)


def noise_times(search: Search, phi: Array | None) -> list[float | None]:
    """Return over which time (s) the noise of each encoder is correlated, None: it is white."""
    return [float(-search.recording.dt / np.log(p)) if p > 0.0 else None
            for p in (np.zeros(2) if phi is None else phi)]


def shifts(candidate: Candidate, nuisances: Mapping[str, float]) -> dict[str, float]:
    """Return {name: shift in standard deviations} of the values estimated along."""
    spread = {c.name: c.prior for c in candidate.coordinates if c.owner < 0}
    return {name: float(value / spread[name]) for name, value in nuisances.items()}


def warnings(search: Search, best: Fitted, kind: str, nuisances: Mapping[str, float],
             times: Sequence[float | None]) -> list[str]:
    """Return sentences about what weakens the verdict; times [2]: see noise_times."""
    out = [f'the noise of the {name} encoder lasts {1e3 * time:.2g} ms, as if it were filtered: '
           'it is judged with that' for name, time in zip(('motor', 'arm'), times) if time]
    bound = best.candidate.at_bound(best.point.z)
    if bound and kind != 'none':
        out.append(f'{", ".join(bound)}: at the bound of what is possible')
    if nuisances and best.candidate.penalty(best.point.z) > MARGIN:
        shift = shifts(best.candidate, nuisances)
        far = max(shift, key=lambda n: abs(shift[n]))
        out.append(f'nominal values lie far outside their tolerance (most: {far}, '
                   f'{shift[far]:+.1f} tolerances): the tolerance '
                   'looks too small, or several values have changed')
    return out
