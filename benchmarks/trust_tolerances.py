# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Coverage of tau_K by its stated deviation when the drive is not quite the model.

Drives are drawn whose values are off by any amount within the tolerances of the packaged model:
friction, damping, inertias, gain and delay of the torque. Each makes three motions, without a load
on the arm and with one that the filter does not know. The packaged model estimates, with the
packaged parameters or with R and Q tuned on a recording of the motion. Coverage is the share of
the samples whose error is within the stated deviation; "noise" is what the filter would state if
its model were exact.
"""
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.harness import BarTable
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_NOISE_STD, S_TAU_K_STD
from gearbox_monitor.estimation.tune import tuned
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.parameters import PlantParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant

DT, DT_NS, T0 = 1e-3, 1_000_000, 1_000_000_000
SECONDS, SETTLED = 12.0, 1.0  # s of a run; s after its start that are not judged
TUNING_SEED = 1001            # never judged on
CONTROL = 5                   # samples between two commands of the position loop
STIFFNESS, DAMPING = 20.0, 0.9  # of that loop, N m/rad and N m s/rad
MOTIONS, LOADS = ('multisine', 'point to point', 'slow'), ('none', 'unknown')
ONE_SIGMA, TWO_SIGMA, MAX_RATIO = (0.60, 0.85), 0.93, 1.8
Row = dict[str, Any]


def other_drive(model: DriveModel, random: np.random.Generator) -> tuple[DriveModel, float, float]:
    """Return a drive within the tolerances of `model`, gain (-) and delay (s) of its torque."""
    tolerances = {'motor_inertia': model.inertia_tolerance, 'arm_inertia': model.inertia_tolerance,
                  'viscous_friction': model.damping_tolerance, 'damping': model.damping_tolerance,
                  'coulomb_friction': model.friction_tolerance}
    drive = replace(model, **{name: getattr(model, name) * (1.0 + random.uniform(-t, t))
                              for name, t in tolerances.items()})
    gain, delay = (random.uniform(-t, t) for t in (
        model.torque_gain_tolerance, model.delay_tolerance))
    return drive, 1.0 + gain, delay


def recording(motion: str, load: str, seed: int) -> tuple[Samples, Array]:
    """
    Return what is recorded of a drive within the tolerances of the packaged model.

    Args:
        motion: one of MOTIONS.
        load: one of LOADS; unknown: gravity and friction act on the arm.
        seed: of the drive, the motion and the noise.

    Returns:
        The samples and the true tau_K [N], N m.

    """
    random, packaged = np.random.default_rng([seed, 11]), PlantParameters()
    drive, gain, delay = other_drive(DriveModel(), random)
    if load == 'unknown':
        drive = drive.with_(effects=({'id': 'gravity', 'G': 1.0},
                                     {'id': 'arm_coulomb', 'Cac': 0.3}))
    plant = Plant(drive, Noise(packaged.process_noise, packaged.measurement_noise), seed)
    t = DT * np.arange(round(SECONDS / DT))
    if motion == 'multisine':
        scale, faster = random.uniform(0.7, 1.3, 2)
        runs = [plant.run(Excitation('multisine', (6.0 * scale, 2.0 * scale),
                                     (0.9 * faster, 2.3 * faster)).torque(t), DT)]
    else:
        runs = list(_controlled(plant, _REFERENCES[motion](t, random)))
    u, y, tau_k = (np.concatenate([getattr(run, name) for run in runs])
                   for name in ('u', 'y', 'tau_k'))
    recorded = np.interp(t + delay, t, u) / gain
    return Samples(T0 + DT_NS * np.arange(len(t)),
                   np.column_stack([recorded, np.full(len(t), np.nan)]), y), tau_k


def _point_to_point(t: Array, random: np.random.Generator) -> Array:
    """Return positions [N] of moves of 0.5 to 0.9 s between rests of up to 2 s."""
    x, begin, at = np.zeros(len(t)), 0.0, 0.5
    while at < t[-1]:
        end, length = random.uniform(-1.6, 1.6), random.uniform(0.5, 0.9)
        s = np.clip((t - at) / length, 0.0, 1.0)
        x = np.where(t >= at, begin + (end - begin) * s ** 3 * (10.0 - 15.0 * s + 6.0 * s * s), x)
        begin, at = end, at + length + random.uniform(0.3, 2.0)
    return x


def _slow(t: Array, random: np.random.Generator) -> Array:
    """Return positions [N] of a slow sine of some rad."""
    wave = np.cos(2.0 * np.pi * random.uniform(0.1, 0.2) * t)
    return random.uniform(3.0, 5.0) * (1.0 - wave)


_REFERENCES = {'point to point': _point_to_point, 'slow': _slow}


def _controlled(plant: Plant, reference: Array) -> Iterator[Any]:
    """Yield Trajectories of a plant whose motor follows `reference` [N] by a PD controller."""
    speed = np.gradient(reference, DT)
    for k in range(0, len(reference), CONTROL):
        x = plant.state
        u = STIFFNESS * (reference[k] - x[0]) + DAMPING * (speed[k] - x[2])
        yield plant.run(np.full(min(CONTROL, len(reference) - k), u), DT, k * DT)


def evaluate(filters: Sequence[str], draws: int, bars: BarTable,
             progress: Callable[[str], None], tune: bool = False) -> list[Row]:
    """
    Measure coverage and size of the stated deviation.

    Args:
        filters: by name.
        draws: drives per motion and load.
        bars: collects the bars.
        progress: called with a line of text.
        tune: whether R and Q are tuned by likelihood on one more drive of each motion.

    Returns:
        One row per filter, load, motion and estimate (filtered, smoothed): coverage of one and two
        deviations, ratio of stated to actual (rms, median over the drives), each also by noise
        alone, and the rms error, N m.

    """
    rows: list[Row] = []
    for load in LOADS:
        for motion in MOTIONS:
            progress(f'tolerances: arm load {load}, {motion}')
            drawn = [recording(motion, load, i) for i in range(draws)]
            for name in filters:
                parameters: Values = {'filter': name, 'arm_load': load}
                if tune:
                    parameters = tuned(DriveModel(), parameters,
                                       [recording(motion, load, TUNING_SEED)[0]])
                estimator = Estimator(DriveModel(), parameters)
                parts: dict[str, list[Array]] = {'filtered': [], 'smoothed': []}
                for samples, tau_k in drawn:
                    estimator.reset()
                    estimates = estimator.run(samples)
                    smoothed = estimates.smoothed
                    for kind, stamps, columns in (
                            ('filtered', estimates.stamp_ns, (
                                estimates.tau_k, estimates.tau_k_std, estimates.tau_k_noise_std)),
                            ('smoothed', estimates.smoothed_stamp_ns, (
                                smoothed[:, S_TAU_K], smoothed[:, S_TAU_K_STD],
                                smoothed[:, S_TAU_K_NOISE_STD]))):
                        k = np.searchsorted(samples.stamp_ns, stamps)
                        late = k * DT >= SETTLED
                        parts[kind].append(np.array([
                            np.abs(columns[0] - tau_k[k]), *columns[1:]])[:, late])
                for kind, runs in parts.items():
                    row = {'filter': name, 'load': load, 'motion': motion, 'estimate': kind,
                           **_figures(runs)}
                    rows.append(row)
                    what = f'{name}, load {load}, {motion}, {kind}'
                    bars.judge(f'{what}: 1 sigma', row['one'], *ONE_SIGMA)
                    bars.judge(f'{what}: 2 sigma', row['two'], low=TWO_SIGMA)
                    bars.judge(f'{what}: stated / actual', row['ratio'], high=MAX_RATIO)
    return rows


def _figures(runs: list[Array]) -> Row:
    """Return the figures of `runs`, each [3, N]: size of the error, stated, by noise alone."""
    error, stated, noise = np.concatenate(runs, axis=1)
    rms = [np.sqrt(np.mean(run ** 2, axis=1)) for run in runs]
    return {'rms': float(np.sqrt(np.mean(error ** 2))),
            **{f'{name}{of}': float(np.mean(error < size * std))
               for of, std in (('', stated), ('_noise', noise))
               for name, size in (('one', 1.0), ('two', 2.0))},
            'ratio': float(np.median([s / e for e, s, _ in rms])),
            'ratio_noise': float(np.median([n / e for e, _, n in rms]))}


def table(rows: list[Row]) -> list[str]:
    """Return the `rows` of evaluate() as lines."""
    lines = ['Drives within the tolerances of the model: coverage of tau_K (by noise alone)', '',
             f'{"filter, load, motion, estimate":<37}{"rms":>5}{"1 sigma":>12}{"2 sigma":>12}'
             f'{"stated/actual":>14}']
    for row in rows:
        figures = ''.join(f'{row[name]:{width}.2f} ({row[name + "_noise"]:.2f})'
                          for name, width in (('one', 5), ('two', 5), ('ratio', 7)))
        lines.append(f'{row["filter"]:<6}{row["load"]:<8}{row["motion"]:<15}{row["estimate"]:<8}'
                     f'{row["rms"]:5.2f}{figures}')
    return lines
