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


"""How large effects are: so that their evidence d in a scene is what is wanted."""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.benchmarks.blind import draw, evidence, plant, stress
from gearbox_monitor.benchmarks.blind.scene import DT, moves, Scene

LEAST, MOST = 250.0, 1e6    # wanted evidence d
PARAMETER_TOLERANCES = 5.0  # smallest change of a nominal value under scatter
LARGER = (1.3, 5.0)         # factors by which an effect is made larger that scatter hides
TRIES = 8                   # changes of the sizes, until the evidence is as wanted


class NotDrawn(Exception):
    """No recording with the wanted evidence came out of these random numbers."""


@dataclass(frozen=True)
class Found:
    """Effects in a scene: recording {u, y, dt}, states x [N, 4] and those where runs begin."""

    recording: dict
    effects: list
    x: np.ndarray
    known: np.ndarray


@dataclass(frozen=True)
class Subject:
    """
    A Scene whose effects have a form and no size yet.

    forms: from draw.shape(); limits: {'peak', 'rms', 'sigma'} for draw.effect(); noise [N, 2].
    """

    scene: Scene
    forms: list
    limits: dict
    noise: np.ndarray

    def at(self, sizes):
        """Return Found with effects of `sizes`, None where the drive cannot have them."""
        ids, truth = self.scene.ids, self.scene.truth
        effects = [draw.effect(i, size, form, truth, self.limits)
                   for i, size, form in zip(ids, sizes, self.forms)]
        x, y, u, sane = self.scene.run(effects)
        if not sane or (ids and not moves(x, 0.0)):
            return None
        recording = {'u': u, 'y': plant.quantise(y + self.noise, effects), 'dt': DT}
        starts = np.maximum(evidence.cut(len(u)) - plant.lead_of(effects, DT), 0)
        return Found(recording, effects, x, x[starts])

    def changed(self, sizes, factors):
        """Return sizes changed by factors, within what is drawn."""
        out = []
        for size, factor, name in zip(sizes, factors, self.scene.ids):
            least, most = draw.SIZES[name]
            out.append(float(np.clip(size * factor, max(least, least_size(self.scene, name)),
                                     most)))
        return out

    def evidence(self, found, lacking, careful=True):
        """Return d of the effects over those without the ones numbered in `lacking`."""
        return evidence.evidence_of(
            found.recording, self.scene.truth, found.effects,
            [e for k, e in enumerate(found.effects) if k not in lacking],
            self.limits['sigma'], found.known, careful)

    def evidence_of_each(self, found, careful=True):
        """Return [d of each effect, over the others alone]."""
        return [self.evidence(found, [k], careful) for k in range(len(found.effects))]


def least_size(scene, name):
    """Return the size below which scatter is as large as the effect `name`."""
    return 1.1 * PARAMETER_TOLERANCES * scene.scatter if name in draw.REPLACES else 0.0


def sized(subject, sizes, wanted, low, high):
    """
    Return (Found, d, d of each effect): about as visible as `wanted`, within low and high.

    subject: Subject; sizes, wanted: first sizes and wanted evidence of its effects. Nothing is
    weighed for quantisation, which changes the noise. Raises NotDrawn.
    """
    for _ in range(TRIES):
        found = subject.at(sizes)
        if found is None:
            sizes = [0.6 * s for s in sizes]
            continue
        if not sizes or any(i in draw.QUANTISATION for i in subject.scene.ids):
            return found, None, None
        each = subject.evidence_of_each(found, careful=False)
        allowed = all(low <= value <= high for value in each)
        if allowed and all(0.2 < value / wish < 5.0 for value, wish in zip(each, wanted)):
            break
        before = sizes
        sizes = subject.changed(sizes, [np.clip(np.sqrt(wish / max(value, 1.0)), 0.1, 10.0)
                                        for value, wish in zip(each, wanted)])
        if np.allclose(before, sizes, rtol=1e-3):
            if allowed:
                break
            raise NotDrawn('evidence')
    else:
        raise NotDrawn('evidence')
    each = subject.evidence_of_each(found)
    if not all(low <= value <= high for value in each):
        raise NotDrawn('evidence')
    if subject.scene.scatter:
        found, each = _under_scatter(subject, found, sizes)
    d = each[0] if len(each) == 1 else subject.evidence(found, range(len(each)))
    return found, d, each


def _under_scatter(subject, found, sizes):
    """
    Return (Found, d of each effect) where nominal values scatter and torque noise acts.

    Effects that these hide are made larger.
    """
    # A changed nominal value has (change / tolerance)^2 at most.
    least = [PARAMETER_TOLERANCES ** 2 if i in draw.REPLACES else LEAST
             for i in subject.scene.ids]
    for _ in range(TRIES):
        each = stress.Likelihood(subject.scene, found, subject.limits['sigma']).evidence()
        if all(value >= low for value, low in zip(each, least)):
            return found, each
        before = sizes
        sizes = subject.changed(sizes, [1.0 if value >= low else float(np.clip(
            np.sqrt(1.5 * low / max(value, 1.0)), *LARGER)) for value, low in zip(each, least)])
        found = None if sizes == before else subject.at(sizes)
        if found is None:
            break
    raise NotDrawn('hidden by scatter')
