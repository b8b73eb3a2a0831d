# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Slips: steps of the twist at times of their own, as of a clutch or a loose hub.

A filter in which the zero of the motor's encoder is a state that drifts shows when it has moved,
and by how much, even by a hundredth of the twist. Steps that pay their price are slips. How one
happens is open: no likelihood sees the samples around it; after it the motor counts on. The sizes
are those of the largest likelihood.
"""
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import fitted, InnovationFit
from gearbox_monitor.diagnosis.joint.innovations import JointlyFiltered
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.gearbox import slipped

SOFT = 0.2       # of the torque: noise with which a filter follows the motion after a slip
THINNED = 0.02   # s, from value to value of the zero in which steps are looked for
APART = 1.0      # s, between two slips, and from the begin and the end
SURE = 6.0       # median deviations of the zero beyond which a step is none by chance
MOST = 10        # steps that are looked for in a recording
REFITTED = 6     # iterations of the fit with slips
ROUNDS, REFITS = 3, 2  # searches for slips; fits of their sizes in each
STEP = 1e-4      # rad, of finite differences
NEAR = 0.3       # s, about a step of the zero, where the slip begins
WILD = 9.0       # times the variance of a reading: of one that is not as predicted


@dataclass(frozen=True)
class SlipEvent:
    """One slip: the recording it is in, when (s), size and its deviation (rad), + of the motor."""

    recording: str
    t0: float
    size: float
    std: float


def with_slips(data: DriveRecordings, slips: Array, owner: Integers) -> DriveRecordings:
    """
    Return recordings whose motor counts on over slips; `data` knows none.

    Args:
        data: the recordings.
        slips: time (s) and size (rad) of each [B, 2].
        owner: number of its recording [B].
    """
    order = np.lexsort((slips[:, 0], owner))
    return _moved(replace(data, slips=slips[order], slip_owner=owner[order]), -1.0)


def without_slips(data: DriveRecordings) -> DriveRecordings:
    """Return `data` as the recordings were read, with their slips."""
    return data if not len(data.slips) else replace(
        _moved(data, 1.0), slips=data.slips[:0], slip_owner=data.slip_owner[:0])


def _moved(data: DriveRecordings, sign: float) -> DriveRecordings:
    """Return recordings whose motor, and setpoint, is moved by their slips."""
    recordings = []
    for i, r in enumerate(data.recordings):
        t = np.arange(len(r.u)) * r.dt
        angle = sign * sum((slipped({'t0': t0, 'Ds': size}, t) for t0, size in data.slips[
            data.slip_owner == i]), np.zeros(len(t)))
        recordings.append(replace(
            r, y=r.y + angle[:, None] * (1.0, 0.0),
            u=r.u + angle if data.model.controller is not None else r.u))
    return replace(data, recordings=tuple(recordings))


def slipping(data: DriveRecordings, fit: InnovationFit, price: float) -> DriveRecordings | None:
    """
    Return recordings whose motor counts on over more slips than known, None if there are none.

    Slips that are not known enlarge the torque noise, which blurs others; it shrinks as they are
    found.

    Args:
        data: the recordings, with the slips that are known.
        fit: with them.
        price: -2 log L that each slip has to gain.
    """
    bare, known = without_slips(data), len(data.slips)
    for number in range(ROUNDS + 1):
        slips, owner = _steps(bare, fit) if number < ROUNDS else _begun(
            bare, fit, data.slips, data.slip_owner)
        for _ in range(REFITS if len(slips) else 0):
            data = with_slips(bare, slips, owner)
            fit = fitted(data.whole, fit, REFITTED)
            run, J = _columns(data, fit)
            spread = covariance(J.T @ J)
            slips, owner = data.slips.copy(), data.slip_owner
            slips[:, 1] -= spread @ J.T @ run.residual.ravel()
            pays = slips[:, 1] ** 2 > price * np.diag(spread)
            slips, owner = slips[pays], owner[pays]
        data = with_slips(bare, slips, owner)
        if len(slips) <= known:
            return None
    return data


def _columns(data: DriveRecordings, fit: InnovationFit) -> tuple[JointlyFiltered, Array]:
    """Return (the run of `fit`, derivatives [2 N, B] of its residual by the sizes of slips)."""
    run, bare = data.whole.run(fit.model, fit.torque), without_slips(data)
    J = np.empty((run.variance.size, len(data.slips)))
    for k in range(len(data.slips)):
        moved = data.slips.copy()
        moved[k, 1] += STEP
        change = with_slips(bare, moved, data.slip_owner).whole.run(
            fit.model, fit.torque).innovation - run.innovation
        J[:, k] = (change / np.sqrt(run.variance)).ravel() / STEP
    return run, J


def _steps(data: DriveRecordings, fit: InnovationFit) -> tuple[Array, Integers]:
    """Return the steps ([B, 2], owner [B]) of the zeros of recordings."""
    rows, owner = [], []
    model, torque = fit.model, np.maximum(fit.torque, SOFT * data.torque)
    servo = model.folded().controller
    if servo is not None:  # whose reading moves with the zero
        data = replace(data, model=_without_servo(data.model), recordings=tuple(
            replace(r, u=r.with_servo(servo).torque, servo_torque=None) for r in data.recordings))
        model = _without_servo(model)
    for number, part in enumerate(data.whole.parts):
        if len(part.recording.channels) < 2:
            continue
        zero = part.drift(model, torque)
        every = max(1, round(THINNED / part.recording.dt))
        known = np.flatnonzero(np.isfinite(zero))[::every]
        for k, size in _splits(zero[known], round(APART / (every * part.recording.dt))):
            rows.append((known[k] * part.recording.dt, size))
            owner.append(number)
    return np.array(rows).reshape(-1, 2), np.array(owner, int)


def _without_servo(model: DriveModel) -> DriveModel:
    """Return the model of a drive that takes a torque."""
    return replace(model, controller=None, effects=tuple(
        e for e in model.effects if library()[e['id']].location != 'controller'))


def _begun(data: DriveRecordings, fit: InnovationFit, slips: Array, owner: Integers
           ) -> tuple[Array, Integers]:
    """Return slips that begin where the readings cease to be as predicted, close to `slips`."""
    # Counted on later, so that up to its begin each is as predicted.
    late = with_slips(data, slips + (NEAR, 0.0), owner)
    slips = slips.copy()
    for number, run in enumerate(late.whole.run(fit.model, fit.torque).runs):
        dt = data.recordings[number].dt
        square = (run.residual ** 2).max(axis=1)
        odds = run.read.any(axis=1) * (square * (1.0 - 1.0 / WILD) - np.log(WILD))
        for k in np.flatnonzero(owner == number):
            begin = max(0, round((slips[k, 0] - NEAR) / dt))
            rows = odds[begin:round((slips[k, 0] + NEAR) / dt)]
            slips[k, 0] = (begin + 1 + int(np.argmin(np.cumsum(rows)))) * dt
    return slips, owner


def _splits(x: Array, least: int) -> list[tuple[int, float]]:
    """Return (row, size) of the steps of `x` [N] beyond its scatter about them."""
    edges = [0, len(x)]
    for _ in range(MOST):
        gains = [_best_split(x[a:b], least) for a, b in pairwise(edges)]
        best = max(range(len(gains)), key=lambda i: gains[i][0])
        edges = _settled(x, sorted({*edges, edges[best] + gains[best][1]}), least)
    while True:
        levels = [float(np.median(x[a:b])) for a, b in pairwise(edges)]
        scatter = float(np.median(np.abs(x - np.repeat(levels, np.diff(edges)))))
        sizes = np.diff(levels)
        if (np.abs(sizes) > SURE * scatter).all():
            return list(zip(edges[1:], sizes.tolist()))
        smallest = int(np.argmin(np.abs(sizes)))
        edges = _settled(x, edges[:smallest + 1] + edges[smallest + 2:], least)


def _settled(x: Array, edges: list[int], least: int) -> list[int]:
    """Return `edges` of pieces of `x`, each where it is best between its neighbours."""
    out = list(edges)
    for k in range(1, len(out) - 1):
        out[k] = out[k - 1] + _best_split(x[out[k - 1]:out[k + 1]], least)[1]
    return out


def _best_split(x: Array, least: int) -> tuple[float, int]:
    """Return (decrease of the squares about the means, row) of the best split of `x` [N]."""
    n = len(x)
    k = np.arange(least, n - least + 1)
    if not len(k):
        return 0.0, 0
    total = np.cumsum(x - x.mean())
    gain = total[k - 1] ** 2 * (1.0 / k + 1.0 / (n - k))
    best = int(np.argmax(gain))
    return float(gain[best]), int(k[best])


def slip_events(data: DriveRecordings, fit: InnovationFit) -> tuple[SlipEvent, ...]:
    """Return the slips of `data` in order of time, with deviations of their sizes in `fit`."""
    if not len(data.slips):
        return ()
    _, J = _columns(data, fit)
    std = np.sqrt(np.diag(covariance(J.T @ J)))
    return tuple(SlipEvent(data.recordings[i].name, float(t0), float(size), float(s))
                 for i, (t0, size), s in zip(data.slip_owner, data.slips, std))
