# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""
Windows that begin in the smoothed states of a filter, instead of in lines through the readings.

A drive that sticks and slips forgets nothing: 1e-5 rad grow some thousandfold within a window of
1 s, so that its best initial state is not found from afar. The smoother knows it to a fraction of
the noise, from all readings before and after.
"""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.identification import gauss_newton, window_states
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.innovation_fit import fitted, InnovationFit
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.noise_model import white_level
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.windows import smoothed_point
from gearbox_monitor.kernels.types import Array

ROUNDS = 3     # of windows that begin elsewhere and of fits, at most


def likeliest(search: Search, candidate: CandidateModel, starts: Sequence[Array],
              iterations: int = 12) -> InnovationFit:
    """
    Return the likeliest fit of a candidate by the innovations of the training windows.

    Args:
        search: of a recording that is driven by the torque.
        candidate: model with its coordinates.
        starts: coordinates [P] to begin with.
        iterations: of each fit, at most.
    """
    filter_ = InnovationLikelihood(search.recording, candidate.nominal, search.long.sigma,
                                   training_spans(search))
    fits = [fitted(filter_, InnovationFit(candidate, z, filter_.first_noise), iterations)
            for z in starts]
    return min(fits, key=lambda f: f.deviance)


def training_spans(search: Search) -> list[slice]:
    """Return the parts of the recording of `search` before the windows that are held out."""
    if search.long.train.all():
        return search.spans
    return [slice(span.start, cut + n) for cut, n, span in zip(
        search.recording.cuts, search.last, search.spans) if n]


def on_windows(search: Search, fit: InnovationFit, filter_: InnovationLikelihood,
               score: float) -> CandidateFit:
    """
    Return the CandidateFit on the long windows that begins where a fit of innovations was.

    With torque noise, the innovations remain the evidence.

    Args:
        search: of a recording that is driven by the torque.
        fit: by innovations.
        filter_: likelihood of the whole recording.
        score: of `fit`.
    """
    data, candidate = search.long, fit.candidate
    run = filter_.run(candidate.model(fit.z), fit.torque)
    smooth = filter_.smoothed(run)
    point = smoothed_point(data, candidate, fit.z, smooth)
    if search.noisy:
        at = data.windows.first[:, None] + np.arange(data.windows.length) - 1
        white = run.residual[np.maximum(at, 0)][:, :, data.channels]
        if data.colour is not None:  # the filter takes it for white noise of its power at rest
            level = white_level(data.sigma, data.colour) / data.sigma
            white = data.white(white * level[data.channels], data.channels)
        white = white.reshape(len(at), -1)
        if search.model.lasting:  # few are read
            white = point.residual
        return CandidateFit(candidate, point, score, float(fit.torque[0]), white, smooth=smooth)
    point = window_states.rescue(data, candidate, point, half_gap=search.half_gap)
    if candidate.coordinates:
        point = gauss_newton.robust_then_plain(data, candidate, point, (3, 6))
        for _ in range(ROUNDS if len(data.channels) == 1 else 0):
            # A side that no encoder reads may still begin on the wrong flank of the gap.
            rescued = window_states.rescue(data, candidate, point, half_gap=search.half_gap)
            if rescued is point:
                break
            point = gauss_newton.fit(data, candidate, rescued, 6, robust=True)
    return search.as_fitted(candidate, point, smooth)
