# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""Sizes of effects, chosen so that their evidence d in a scene comes near a target."""
from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind import draw, plant, stress, window_fit
from benchmarks.blind.scene import DT, GAIN_SPREAD, moves, Scene
from gearbox_monitor.kernels.types import Array

LEAST, MOST = 250.0, 1e6    # target of the evidence d
PARAMETER_TOLERANCES = 5.0  # smallest change of a nominal value under scatter
LARGER = (1.3, 5.0)         # factors by which an effect is made larger that scatter hides
TRIES = 8                   # changes of the sizes, until the evidence is near its target


class NotDrawn(Exception):
    """These random numbers gave no recording with evidence near its target."""


@dataclass(frozen=True)
class Realisation:
    """Effects in a scene: recording {u, y, dt}, states x [N, 4] and those where runs begin."""

    recording: plant.MotionRecord
    effects: list[dict[str, Any]]
    x: Array
    window_states: Array


@dataclass(frozen=True)
class Subject:
    """
    A Scene whose effects have a form and no size yet.

    forms: from draw.shape(); limits: {'peak', 'rms', 'sigma'} for draw.effect(); noise [N, 2].
    """

    scene: Scene
    forms: list[dict[str, Any]]
    limits: dict[str, Any]
    noise: Array

    def at(self, sizes: Sequence[float]) -> Realisation | None:
        """Return the Realisation with effects of these `sizes`, None if the drive diverges."""
        ids, truth = self.scene.ids, self.scene.truth
        effects = [draw.effect(i, size, form, truth, self.limits)
                   for i, size, form in zip(ids, sizes, self.forms)]
        x, y, u, sane = self.scene.run(effects)
        if not sane or (ids and not moves(x, 0.0)):
            return None
        recording = {'u': u, 'y': plant.quantise(y + self.noise, effects), 'dt': DT}
        if 'kp' in truth:
            recording['setpoint'] = self.scene.motion[2][:, 0]
        starts = np.maximum(window_fit.cut(len(u)) - plant.lead_of(effects, DT), 0)
        return Realisation(recording, effects, x, x[starts])

    def changed(self, sizes: Sequence[float], factors: Sequence[float]) -> list[float]:
        """Return `sizes` changed by `factors`, within the range of draw.SIZES."""
        out = []
        for size, factor, name in zip(sizes, factors, self.scene.ids):
            smallest, largest = draw.SIZES[name]
            out.append(float(np.clip(size * factor, max(smallest, least_size(self.scene, name)),
                                     largest)))
        return out

    def evidence(self, realisation: Realisation, lacking: Container[int],
                 careful: bool = True) -> float:
        """
        Return d of all effects over a model without some of them.

        Args:
            realisation: effects and recording.
            lacking: indices of the effects that the other model lacks.
            careful: start windows of the other model again if they do not fit.
        """
        return window_fit.evidence_of(
            realisation.recording, self.scene.truth, realisation.effects,
            [e for k, e in enumerate(realisation.effects) if k not in lacking],
            self.limits['read_sigma'], realisation.window_states, careful)

    def evidence_of_each(self, realisation: Realisation, careful: bool = True) -> list[float]:
        """Return d of each effect of `realisation` over the others; `careful`: see evidence()."""
        return [self.evidence(realisation, [k], careful)
                for k in range(len(realisation.effects))]


def least_size(scene: Scene, name: str) -> float:
    """Return the size below which the scatter of a `scene` is as large as the effect `name`."""
    if 'kp' in scene.truth:  # gains off by less are no effect, and what acts alike is none either
        change = 4.5 * GAIN_SPREAD  # four deviations beyond what is stated, which is off itself
        return {'servo_gain': change, 'torque_gain': change,
                'motor_viscous': change * scene.truth['kd'] / scene.truth['Cv']}.get(name, 0.0)
    return 1.1 * PARAMETER_TOLERANCES * scene.scatter if name in draw.REPLACES else 0.0


def sized(subject: Subject, sizes: Sequence[float], targets: Sequence[float], low: float,
          high: float) -> tuple[Realisation, float | None, list[float] | None]:
    """
    Size effects so that they are about as visible as their targets.

    Quantisation, which changes the noise, is not sized.

    Args:
        subject: scene and form of the effects.
        sizes: first sizes.
        targets: evidence d of each effect to aim at.
        low: smallest permitted evidence.
        high: largest permitted evidence.

    Returns:
        The Realisation, d of all effects and d of each.

    Raises:
        NotDrawn: if no sizes give that evidence.
    """
    for _ in range(TRIES):
        realisation = subject.at(sizes)
        if realisation is None:
            sizes = [0.6 * s for s in sizes]
            continue
        if not sizes or any(i in draw.QUANTISATION for i in subject.scene.ids):
            return realisation, None, None
        each = subject.evidence_of_each(realisation, careful=False)
        allowed = all(low <= value <= high for value in each)
        if allowed and all(0.2 < value / wish < 5.0 for value, wish in zip(each, targets)):
            break
        previous = sizes
        sizes = subject.changed(sizes, [np.clip(np.sqrt(wish / max(value, 1.0)), 0.1, 10.0)
                                        for value, wish in zip(each, targets)])
        if np.allclose(previous, sizes, rtol=1e-3):
            if allowed:
                break
            raise NotDrawn('evidence')
    else:
        raise NotDrawn('evidence')
    each = subject.evidence_of_each(realisation)
    if not all(low <= value <= high for value in each):
        raise NotDrawn('evidence')
    if subject.scene.scatter:
        realisation, each = _under_scatter(subject, realisation, sizes)
    d = each[0] if len(each) == 1 else subject.evidence(realisation, range(len(each)))
    return realisation, d, each


def _under_scatter(subject: Subject, realisation: Realisation,
                   sizes: Sequence[float]) -> tuple[Realisation, list[float]]:
    """
    Return (Realisation, d of each effect) under scattered nominal values and process torque.

    Effects that these hide are made larger.
    """
    # A changed nominal value has (change / tolerance)^2 at most.
    thresholds = [PARAMETER_TOLERANCES ** 2 if i in draw.REPLACES else LEAST
                  for i in subject.scene.ids]
    for _ in range(TRIES):
        each = stress.Likelihood(
            subject.scene, realisation.recording, realisation.effects, realisation.window_states,
            subject.limits['read_sigma']).evidence()
        if all(value >= low for value, low in zip(each, thresholds)):
            return realisation, each
        factors = [1.0 if value >= low else float(np.clip(np.sqrt(1.5 * low / max(value, 1.0)),
                                                          *LARGER))
                   for value, low in zip(each, thresholds)]
        previous, sizes = sizes, subject.changed(sizes, factors)
        larger = None if sizes == previous else subject.at(sizes)
        if larger is None:
            break
        realisation = larger
    raise NotDrawn('hidden by scatter')
