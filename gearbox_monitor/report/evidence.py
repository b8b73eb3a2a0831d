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

"""What the page of a diagnosis shows, as arrays: overlays, maps, what can be told apart."""
import copy
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.identification import (
    basis_functions, input_estimation, isolability, localisation)
from gearbox_monitor.identification.candidates import NOT_FITTED
from gearbox_monitor.identification.model_overlay import overlay
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.quality.recording import concatenated
from gearbox_monitor.report.words import ids_of

COMPARED = 10  # effects in the table of what can be told apart
QUANTITIES = {'speed': 'speed of the motor (rad/s)', 'angle': 'angle of the arm (rad)',
              'twist': 'twist, motor - arm (rad)', 'time': 'time (s)'}  # and units, rotary
PLANE_BINS = 20


@dataclass(frozen=True)
class Missing:
    """
    The signal that is missing at one place.

    unit: of it; laws {quantity: gap.maps.Law}.
    """

    place: str
    unit: str
    laws: dict


@dataclass(frozen=True)
class Evidence:
    """
    Arrays of a page.

    axis: of the model; labels {quantity: words with unit}; overlay: gap.overlay.Overlay, nominal
    model first; shown: [(words, window)]; maps {quantity: [Map of the residual in sigma, one per
    run]}; planes (name, name, edges, edges, [rms of each run]); missing: Missing or None; matrix:
    (ids, s2 [A, A]) or None; separations: {id: (d, {other: s2})} as of gap.isolate.
    """

    axis: str
    labels: dict
    overlay: object
    shown: tuple
    maps: dict
    planes: tuple
    missing: Missing | None
    matrix: tuple | None
    separations: dict


def gather(verdict, recordings, model, jobs=1):
    """Return the Evidence of a Verdict on `recordings` under the DriveModel `model`."""
    data, search = verdict.data, verdict.search
    recording = concatenated([driven(r, model) for r in recordings])
    models = {'nominal model': model}
    if verdict.model is not None:
        models[closed_name(data)] = verdict.model
    laid = overlay(recording, models, data['sigma'])
    moved = basis_functions.motion(recording.positions, recording.dt, recording.cuts)
    index = laid.windows.first[:, None] + np.arange(laid.windows.length)
    moved = {name: value[index] for name, value in moved.items()
             if name != 'twist' or model.transmission.kind != 'rigid'}
    left = [laid.residual(run) for run in laid.runs]
    edges = {name: basis_functions.edges_of(value) for name, value in moved.items()}
    over = {name: [basis_functions.binned(value, r, edges[name]) for r in left]
            for name, value in moved.items()}
    one, other = 'speed', 'twist' if 'twist' in moved else 'angle'
    columns, rows = (basis_functions.edges_of(moved[name], PLANE_BINS) for name in (one, other))
    planes = (one, other, columns, rows,
              [basis_functions.plane(moved[one], moved[other], r, columns, rows) for r in left])
    missing = None
    if data['verdict'] != 'none':
        missing = missing_signal(search, data['where']['place'], moved, jobs)
    name = '+'.join(i for i in ids_of(data) if i not in NOT_FITTED)
    separations = {}
    if name in search.fitted and name:
        separations = isolability.separations(search, search.fitted[name])
    labels = {name: on_axis(QUANTITIES[name], model.axis) for name in moved}
    return Evidence(model.axis, labels, laid, shown_windows(laid), over, planes, missing,
                    compared(search, data), separations)


def closed_name(data):
    """Return what the model with the effect is called."""
    if data['verdict'] == 'effect':
        return f'with {data["effect"]}'
    return f'nearest: with {"+".join(data.get("params") or {})}'


def shown_windows(laid, held_out=True):
    """Return ((words, window), ...): the typical and the worst, of those held out or of all."""
    held = np.flatnonzero(laid.held)
    held = held if held_out and len(held) else np.arange(len(laid.held))
    order = held[np.argsort(laid.runs[0].chi2[held])]
    typical, worst = int(order[(len(order) - 1) // 2]), int(order[-1])
    if typical == worst:
        return (('window', typical),)
    return ('typical window', typical), ('worst window', worst)


def missing_signal(search, place, moved, jobs=1):
    """Return the Missing signal at `place` on top of the model without effect."""
    free = localisation.free_forms(search, search.fitted[''], jobs, (place,))[place]
    unit = 'N m' if place in input_estimation.TORQUES else 'rad'
    return Missing(place, on_axis(unit, search.model.axis), localisation.laws(search, free, moved))


def compared(search, data):
    """Return (ids, s2) of the effects that did best, None where there is nothing to compare."""
    known = [i for i in data['ranked'] if i in search.ids and i not in NOT_FITTED]
    known = list(dict.fromkeys([*known[:COMPARED - 3],
                                *(i for i in data['confusable'] if i in known), *known]))
    if len(known) < 2:
        return None
    fewer = copy.copy(search)
    fewer.ids = known[:COMPARED]
    ids, s2 = isolability.matrix(fewer)
    return list(ids), s2


def explained_by(name, law):
    """Return a title for the Law over the quantity `name`."""
    if name == 'time':  # the past says nothing of other windows
        return 'over time'
    return f'over {name}: explains {100.0 * law.explained:.0f} %'
