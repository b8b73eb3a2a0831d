# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Runs of simulated drives as the samples that an estimator takes."""
import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

HEALTHY = Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3))


def driven(model, seconds, noise=HEALTHY, seed=3, dt=1e-3):
    """Return the Trajectory of a drive that moves as drives of tests do."""
    return simulate(model, Excitation().torque(dt * np.arange(round(seconds / dt))), dt, noise,
                    seed)


def samples_of(run, dt=1e-3, begin_ns=10 ** 18):
    """Return the Samples of a Trajectory, without a load, stamped from `begin_ns` on."""
    n = len(run.u)
    return Samples(begin_ns + round(1e9 * dt) * np.arange(n),
                   np.column_stack([run.u, np.full(n, np.nan)]), run.y.copy())


def interrupted(count=2000):
    """Return Samples of a healthy drive with dropouts, missing and impossible values."""
    samples = samples_of(driven(DriveModel(), 1e-3 * count), begin_ns=10 ** 9)
    samples.stamp_ns[count // 2:] += 10 ** 8
    samples.stamp_ns[count // 3] = 0
    y = samples.y
    y[200:220, 0], y[210:250, 1], y[400] = np.nan, np.nan, np.inf
    return samples


def part_of(samples, begin, end=None):
    """Return the Samples from number `begin` to `end`."""
    return Samples(*(a[begin:end] for a in (samples.stamp_ns, samples.u, samples.y)))
