# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Diagnosis of recordings whose measured motor motion drives the model (driven_by: position)."""
from collections.abc import Callable, Sequence
from dataclasses import replace
import math

import numpy as np

from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.likelihood import CandidateFit, FitPoint
from gearbox_monitor.identification.noise_model import noise_floor
from gearbox_monitor.identification.position import window_closure, window_isolability
from gearbox_monitor.identification.position.adequacy import misfit
from gearbox_monitor.identification.position.position_search import PositionSearch
from gearbox_monitor.identification.position.selection import (
    decide, gain, parts, PositionEvidence)
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.verdict import Explained, LATTICES, report, Verdict
from gearbox_monitor.identification.windows import WindowRuns
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects.torque_map import TORQUE_MAP
from gearbox_monitor.quality.recording import concatenated, UniformRecording


def diagnose(recordings: Sequence[UniformRecording], model: DriveModel, ids: Sequence[str],
             exclude: Sequence[str], validate: UniformRecording | None, seed: int,
             progress: Callable[[str], object], jobs: int) -> Verdict:
    """
    Return the verdict on recordings whose measured motion is put in.

    Args:
        recordings: recordings of one drive, with the motion of the motor.
        model: model of the drive.
        ids: effects that may be named.
        exclude: effects that may not.
        validate: recording that is used for validation only.
        seed: seed of the bootstrap.
        progress: called with a text.
        jobs: number of threads.
    """
    recording = concatenated(recordings)
    model = model.folded()  # a closed model is the next one to start from
    with_map = TORQUE_MAP.id in ids
    ids = [i for i in ids if i != TORQUE_MAP.id]  # fitted to the remainder, not as an effect
    sigma, quantum = noise_floor(recording, model)
    rough = bool((quantum > THRESHOLDS.rough_lattice * sigma).any())
    search = PositionSearch(recording, model, sigma, ids, jobs,
                            lambda done, total, text: progress(text))
    evidence = PositionEvidence(search, rough)
    fit, kind = decide(evidence)
    closed = fit
    if kind == 'unknown':
        fit, closed = parts(evidence, fit, with_map)
    lattices = tuple(name for i, name in enumerate(LATTICES)
                     if quantum[i] > THRESHOLDS.lattice * search.long.sigma[i]
                     and search.long.weighing is None and name in ids and name not in exclude)
    return report(_explained(search, fit, closed, kind == 'unknown', (quantum, lattices)),
                  validate, seed)


def _explained(weighed: PositionSearch, fit: CandidateFit, closed: CandidateFit, remains: bool,
               steps: tuple[np.ndarray, tuple[str, ...]]) -> Explained:
    """Return all that a verdict states; steps: of the encoders, rad, and their ids."""
    apart = window_isolability.separations(weighed, fit) if fit.candidate.ids else {}
    rivals = window_isolability.confusable(weighed, fit, apart) if fit.candidate.ids else []
    ranked = [name for size in (1, 2, 3) for name in weighed.ranked(size)]
    gains = {name: gain(weighed, weighed.fitted[name]) for name in ranked}
    search = weighed.in_sensor_units()
    none, own = search.fitted[''], search.fitted.get(fit.name, fit)
    data = search.long

    def run(candidate: CandidateModel, point: FitPoint) -> tuple[WindowRuns]:
        """Return free runs in standard deviations of the noise."""
        return (WindowRuns(data, candidate, data.evaluate(candidate, point)),)
    published = window_closure.published(search, none, own)
    settled = window_closure.settled(search, own, [published])
    closed_runs = run(closed.candidate, closed.point)
    if closed is fit:
        closed_runs = run(settled.candidate, settled.point)
    errors, condition = window_closure.standard_errors(search, settled if closed is fit else (
        replace(closed, point=closed_runs[0].point, white=None)))
    excess, structure = misfit(search, own)
    plain = _published_candidate(search, none)
    return Explained(
        (search.recording,), search.model, data.sigma, None, steps[0], fit.candidate,
        fit.point.z, float(fit.s), closed.candidate, closed.point.z,
        run(plain, published), run(none.candidate, none.point),
        run(own.candidate, settled.point if closed is fit else own.point), closed_runs,
        errors, condition, {n: v for n, v in gains.items() if math.isfinite(v)},
        {name: row[0] for name, row in apart.items()}, apart, rivals,
        lambda names: window_isolability.matrix(weighed, names), excess, structure, None, None,
        remains, lattices=steps[1])


def _published_candidate(search: Search, none: CandidateFit) -> CandidateModel:
    """Return the candidate of the model as published."""
    if not none.candidate.coordinates:
        return none.candidate
    zero = tuple(c for c in none.candidate.coordinates if c.name == 'zero')
    return CandidateModel(search.model, (), zero)
