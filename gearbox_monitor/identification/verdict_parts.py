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

"""The verdict in parts: what each effect explains of the misfit, and what remains of it."""
from collections.abc import Mapping
from dataclasses import replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.identification import window_states
from gearbox_monitor.identification.candidates import NOT_FITTED, with_effects
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.residual_dependence import ResidualDependence
from gearbox_monitor.identification.search import Search
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects import library


def identified(search: Search, fitted: CandidateFit, params: Mapping[str, Mapping[str, float]],
               errors: Mapping[str, Mapping[str, float]]) -> list[dict[str, Any]]:
    """
    Return the effects of `fitted`: where they act, in which reading they show, what they explain.

    explained: share of the squared misfit beyond noise that returns without the effect, the states
    of the windows fitted again; None where nothing is beyond noise.

    Args:
        search: fits of all candidates, residuals in standard deviations of the noise.
        fitted: fit that is reported.
        params: values of each effect by name.
        errors: their standard errors.
    """
    none = search.fitted['']
    beyond = float(none.point.chi2.sum()) - none.point.residual.size
    out = []
    for name in params:
        if name not in fitted.candidate.ids:  # a lattice of the readings
            continue
        lost = _squares(search, _without(search, fitted, name)) - _squares(
            search, fitted.point.residual)
        out.append({
            'effect': name, 'location': library()[name].location,
            'channel': _reading(search, int(np.argmax(lost))),
            'params': dict(params.get(name, {})), 'standard_errors': dict(errors.get(name, {})),
            'explained': float(np.clip(lost.sum() / beyond, 0.0, 1.0)) if beyond > 0.0 else None})
    return out


def remainder(search: Search, fitted: CandidateFit, place: str, law: ResidualDependence | None,
              torque_map: Values | None) -> dict[str, Any]:
    """
    Return what `fitted` leaves: its place, the reading that shows it, its size there, over what.

    Args:
        search: fits of all candidates, residuals in standard deviations of the noise.
        fitted: fit that is reported.
        place: location class of what remains.
        law: dependence of the residual on the motion, None if there is none.
        torque_map: effect that closes a part of it, None if none does.
    """
    reduced = _squares(search, fitted.point.residual) * len(search.long.channels) / (
        fitted.point.residual.size)
    at = int(np.argmax(reduced))
    sigma = float(search.long.sigma[search.long.channels[at]])
    return {'location': place, 'channel': _reading(search, at),
            'size': sigma * math.sqrt(max(0.0, float(reduced[at]) - 1.0)),
            'over': None if law is None else law.over,
            'torque_map': None if torque_map is None else {
                k: v for k, v in torque_map.items() if k != 'id'}}


def _reading(search: Search, number: int) -> str:
    return search.recording.readings[search.long.channels[number]]


def _squares(search: Search, residual: Array) -> Array:
    """Return the square sum [C] of the residual [W, C L] of each encoder."""
    squares: Array = (search.long.parted(residual) ** 2).sum(axis=(0, 1))
    return squares


def _without(search: Search, fitted: CandidateFit, name: str) -> Array:
    """Return the residual [W, C L] of `fitted` without the effect `name`."""
    if len(fitted.candidate.ids) == 1 or name in NOT_FITTED:
        return search.fitted[''].point.residual
    data, point = search.long, fitted.point
    model = fitted.candidate.model(point.z)
    model = with_effects(
        replace(model, effects=tuple(e for e in model.effects if e['id'] != name)),
        [e for e in search.model.effects if e['id'] == name])
    states, _ = window_states.solve_states(data, model, point.states, point.memory,
                                           np.arange(len(data.windows)))
    residual, _ = data.residual(model, states, point.memory)
    return residual
