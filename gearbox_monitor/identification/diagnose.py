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

"""The diagnosis: the effect that explains the sim-to-real gap, its place, what it closes."""
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.identification import coloured_noise
from gearbox_monitor.identification.adequacy import incomplete, leaves_more_than_noise, on_all
from gearbox_monitor.identification.innovation_selection import InnovationEvidence
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.noise_model import MOTION, noise_floor
from gearbox_monitor.identification.position_search import PositionSearch
from gearbox_monitor.identification.random_effects import between_recordings
from gearbox_monitor.identification.search import Search, SETTLING
from gearbox_monitor.identification.selection import (
    decide, Evidence, parts, PositionEvidence)
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.identification.verdict import (
    DiagnosisVerdict, LATTICES, location_of, report)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.quality.recording import concatenated, UniformRecording


def diagnose(recordings: Sequence[UniformRecording], model: DriveModel, *,
             validate: UniformRecording | None = None, only: Sequence[str] | None = None,
             exclude: Sequence[str] = (), seed: int = 0, jobs: int = 1,
             progress: Callable[..., object] | None = None) -> DiagnosisVerdict:
    """
    Return the verdict on recordings of one drive.

    Args:
        recordings: recordings of one drive.
        model: model of the drive.
        validate: recording that is used for validation only.
        only: ids of the effects to try, None for all.
        exclude: ids of effects that are not tried.
        seed: seed of the bootstrap.
        jobs: number of threads.
        progress: callback with (done, total, text).

    Raises:
        InputError: unknown ids, or none that this drive and its encoders show.
    """
    recording = concatenated([driven(r, model) for r in recordings])
    if recording.motor is not None:
        model = model.folded()  # a closed model is the next one to start from
    ids = [i for i in chosen_ids(only, exclude) if visible(i, model, recording)]
    if not ids:
        raise InputError('effects: none remains that is visible on this drive and its encoders, '
                         'expected at least one')
    with_map = TORQUE_MAP.id in ids
    ids = [i for i in ids if i != TORQUE_MAP.id]  # fitted to the remainder, not as an effect
    sigma, quantum = noise_floor(recording, model)
    rough = bool((quantum > THRESHOLDS.rough_lattice * sigma).any())

    def decided(sigma: Array,
                colour: Array | None = None) -> tuple[Evidence, CandidateFit, str]:
        """Return (evidence, fit, kind) with noise of the encoders of the size `sigma` [2]."""
        evidence: Evidence
        if recording.motor is not None:
            evidence = PositionEvidence(
                PositionSearch(recording, model, sigma, ids, jobs, progress), rough)
        else:
            evidence = InnovationEvidence(Search(
                recording, model, sigma, ids, jobs, progress, colour, settling=SETTLING), rough)
        return evidence, *decide(evidence)
    evidence, fitted, kind = decided(sigma)
    if (kind == 'unknown' and recording.motor is None
            and (quantum <= THRESHOLDS.lattice * sigma).all()
            and leaves_more_than_noise(evidence.search, fitted)):
        # Where one effect leaves white noise, it is white.
        for lowest in (MOTION, coloured_noise.FITTED):
            noise = coloured_noise.measure(evidence.search, fitted, lowest)
            if noise is None:
                break
            evidence, fitted, kind = decided(*noise)
    search = evidence.search

    @cache
    def inadequate(candidate_fit: CandidateFit) -> bool:
        """Return whether `candidate_fit` leaves more than noise on all windows."""
        return incomplete(*on_all(search, candidate_fit))
    judged = kind != 'unknown' and not rough
    if judged:
        fitted = search.finer(fitted, inadequate)
    refit_on_all = judged and recording.motor is None and inadequate(fitted)
    if refit_on_all:
        search, fitted, kind = decided_on_all(search)
        evidence = evidence.on(search)
    same = None
    if kind == 'unknown' and len(recordings) > 1 and recording.motor is None:
        # One value for all may fit none: what each recording says alone.
        names = {diagnose([r], model, only=only, exclude=exclude, seed=seed,
                          jobs=jobs).data['effect'] for r in recordings}
        same = search.fitted.get(names.pop() or '-') if len(names) == 1 else None
    if same is not None:
        fitted, kind = same, 'effect'
    closed = fitted
    if kind == 'unknown':
        fitted, closed = parts(evidence, fitted, with_map)
    lattices = [name for i, name in enumerate(LATTICES)
                if quantum[i] > THRESHOLDS.lattice * search.long.sigma[i]
                and search.long.weighing is None]
    steps = next((name for name in lattices if kind == 'none' and name in exclude), None)
    verdict = report(search, fitted, closed, 'unknown' if steps else kind,
                     [name for name in lattices if name in ids], quantum, validate, seed)
    if same is not None:
        verdict = verdict.warned(
            'the effect differs between the recordings, each of which shows it alone: no single '
            'value closes the gap in all')
    if kind == 'effect' and len(recordings) > 1 and verdict.search.recording.motor is None:
        verdict = verdict.with_data(between_recordings={
            name: {key: asdict(value) for key, value in values.items()}
            for name, values in between_recordings(
                recordings, fitted.candidate, fitted.point.z, verdict.search.long.sigma).items()})
    if steps:
        place = {'location': location_of(steps)}
        verdict = verdict.with_data(
            **place, where={**verdict.data['where'], **place},
            remainder={**verdict.data['remainder'], **place},
        ).warned(f'readings stand on steps: {steps}, which is excluded')
    if refit_on_all:
        verdict = verdict.warned(
            'only the held-out windows show the model error: all windows were fitted, so '
            'gap_after is not from unseen ones; validate with a second recording')
    return verdict


def decided_on_all(search: Search) -> tuple[Search, CandidateFit, str]:
    """Return (search, fit, kind): the decision where no window is held out, as they are again."""
    train = search.long.train
    whole = search.trained_on(np.ones_like(train), {})
    fitted, kind = decide(InnovationEvidence(whole))
    return whole.trained_on(train, whole.fitted), fitted, kind


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
    if recording.motor is not None and place == 'motor_sensor' and (missing or effect.lattice):
        return False
    if model.axis == 'prismatic' and effect.rotary_only:
        return False  # nothing turns with a position in m, and a weight is a constant load
    # In a rigid drive it is indistinguishable from the same on the motor.
    return model.transmission.kind != 'rigid' or (
        place != 'transmission' and not effect.merges_if_rigid)
