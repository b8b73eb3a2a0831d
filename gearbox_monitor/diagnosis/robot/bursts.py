# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Energy of what remains: in how few segments it comes, and how it compares with references."""
import numpy as np

from gearbox_monitor.diagnosis.robot.evidence import RobotEvidence, RobotFit
from gearbox_monitor.diagnosis.robot.local_cosines import COVERED
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.types import Array, Flags

LEAST = 10  # segments


def _usable(evidence: RobotEvidence, joint: int) -> tuple[Array, Flags]:
    """Return the share [S] of segments in motion; which [S] say something of a joint's fault."""
    covered = np.concatenate([rows.tests.covered[:, joint] for rows in evidence.recordings])
    strange = np.concatenate([np.zeros(len(rows.tests.starts)) if rows.strange is None else
                              rows.strange[:, joint] for rows in evidence.recordings])
    return covered, (covered > COVERED) & (strange <= 1.0 - SETTINGS.visited)


def _usual(evidence: RobotEvidence, weights: Array, joint: int) -> Array:
    """
    Return the energy [S] that noise leaves in each segment, over its mean.

    The part of the variance 1 / `weights` [C] of each cell of `joint` that comes from the noise of
    the positions follows the square of the inertia, which the posture changes.
    """
    a = evidence.at[joint]
    size = np.concatenate([((rows.inertia[:, joint] * rows.motion.sigma_q) ** 2).sum(axis=1)
                           for rows in evidence.recordings])
    frequency = np.concatenate([rows.tests.frequency for rows in evidence.recordings])[a.order]
    noise = (2.0 * np.pi * frequency) ** 4 * size[a.segment]
    mean = np.array([noise[cell].mean() for cell in a.cells])
    share = np.minimum(mean * weights, 1.0)
    usual = a.spread(1.0 - share) + a.spread(share / np.maximum(mean, 1e-300)) * noise
    return np.bincount(a.segment, usual, evidence.segments) / np.maximum(
        np.bincount(a.segment, minlength=evidence.segments), 1)


def burstiness(evidence: RobotEvidence,
               fit: RobotFit) -> tuple[Array, list[list[tuple[str, float, float]]]]:
    """
    Return how bursty the residual of `fit` is on the recordings of `evidence`.

    Returns:
        Whitened energy of the worst tenth of the segments over the median one, per joint [J]: that
        of noise is near 2; and the (recording, begin, end) of these segments, s.
    """
    out = np.zeros(evidence.joints)
    times: list[list[tuple[str, float, float]]] = []
    seconds = 2.0 * SETTINGS.hop
    where = [(rows.name, float(t), float(t) + seconds) for rows in evidence.recordings
             for t in rows.motion.t[rows.tests.starts]]
    for j, a in enumerate(evidence.at):
        energy = np.bincount(
            a.segment, a.spread(fit.weights[j]) * fit.residual[j] ** 2, evidence.segments
            ) / _usual(evidence, fit.weights[j], j)
        covered, usable = _usable(evidence, j)
        use = np.flatnonzero(usable)
        times.append([])
        if len(use) >= LEAST:
            ranked = use[np.argsort(energy[use] / covered[use])]
            top = ranked[-max(1, len(ranked) // 10):]
            e = energy / np.maximum(covered, 1e-9)
            out[j] = e[top].mean() / np.median(e[use])
            times[j] = [where[s] for s in sorted(top)]
    return out, times


def energy_over(evidence: RobotEvidence, fit: RobotFit, variance: Array) -> Array:
    """
    Return the energy [J] that `fit` leaves, over that of a `variance` [J, bands]; 0 without rows.

    Where references state the level of the noise, even what follows no variable stands out.
    """
    out = np.zeros(evidence.joints)
    for j, a in enumerate(evidence.at):
        covered, usable = _usable(evidence, j)
        usual = a.spread(variance[j][a.band])
        use = usable[a.segment] & (usual > 0.0)
        if use.any():
            out[j] = (fit.residual[j][use] ** 2 / usual[use]).sum() / covered[a.segment][use].sum()
    return out


def worst_segments(evidence: RobotEvidence, fit: RobotFit) -> Array:
    """Return the rms [J], N m, that `fit` leaves in the worst tenth of segments of `evidence`."""
    out = np.zeros(evidence.joints)
    hops = np.concatenate([np.full(len(rows.tests.starts), rows.tests.value.shape[0] / 2.0)
                           for rows in evidence.recordings])
    for j, a in enumerate(evidence.at):
        energy = np.bincount(a.segment, fit.residual[j] ** 2, evidence.segments) / hops
        covered, use = _usable(evidence, j)
        if use.any():
            e = np.sort(energy[use] / covered[use])
            out[j] = np.sqrt(e[-max(1, len(e) // 10):].mean())
    return out
