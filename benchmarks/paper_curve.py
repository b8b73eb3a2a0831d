# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Beyond the paper: the EKF that learns the curve of the torque, and the mixture of models.

On the drives of "benchmarks paper", from wrong stiffness and gap, without hysteresis; judged on
the second half of each run. Two plants whose curve no stiffness, gap and hysteresis describes show
what a wrong kind of curve costs beside the random walk.
"""
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.tune import tuned
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import LEARNED, MIXED
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, simulate, Trajectory

# Factors on stiffness and half gap of the model that the filter starts from.
STARTS = {'K -30 %, b +30 %': (0.7, 1.3), 'K x 2, b / 2': (2.0, 0.5)}
HARDENING = {'id': 'hardening', 'K3': 5.0}
FLANK_OFFSET = 0.2  # rad
MAX_ERROR = {'A': 0.22, 'B': 0.10}
ONE_SIGMA, TWO_SIGMA, MAX_LOSS = (0.62, 0.75), (0.92, 0.98), 1.02
WALK = 'random walk'


def wrong(model: DriveModel, stiffness: float, half_gap: float) -> DriveModel:
    """
    Return what a user would start from: a dead zone with wrong values.

    Args:
        model: true one.
        stiffness: factor on it.
        half_gap: factor on it.

    Returns:
        The model of the filter.

    """
    shape = model.transmission
    return model.with_(kind='dead_zone', hysteresis_width=0.0, effects=[],
                       stiffness=stiffness * shape.stiffness, half_gap=half_gap * shape.half_gap)


def plants(model: DriveModel) -> dict[str, tuple[DriveModel, float]]:
    """Return {kind of curve: (plant, offset of its flanks in rad)} for the drive `model`."""
    return {'': (model, 0.0), 'hardening': (model.with_(effects=[HARDENING]), 0.0),
            'offset flanks': (model, FLANK_OFFSET)}


def evaluate(drive: tuple[DriveModel, Noise, Array], samples_of: Callable[..., Samples],
             parameters: Mapping[str, Any], tuning_seeds: tuple[int, ...], seeds: int, dt: float,
             progress: Callable[[str], None]) -> dict[str, dict[str, float]]:
    """
    Measure the live error of tau_K, learned and mixed, and how often the deviation covers it.

    How fast tau_K may leave the curve is tuned by the innovation likelihood on other seeds, from
    the first of the wrong starts.

    Args:
        drive: model, noise and motor torque [N] of the case.
        samples_of: turns a Trajectory (and other readings [N, 2]) into Samples.
        parameters: tuned parameters of the estimator.
        tuning_seeds: of the runs that are tuned on.
        seeds: runs.
        dt: sample time, s.
        progress: called with a line of text.

    Returns:
        {run: {figure: mean over the seeds}}: rms error (N m), coverage of one and two deviations,
        and where it is learnt K (N m/rad), b and h (rad) at the end.
    """
    model, noise, u = drive
    figures: dict[str, dict[str, list[float]]] = {}
    learned = tuned(wrong(model, *STARTS['K -30 %, b +30 %']),
                    {**parameters, 'tau_k_model': LEARNED},
                    [samples_of(simulate(model, u, dt, noise, seed)) for seed in tuning_seeds])
    for seed in range(seeds):
        for kind, (plant, offset) in plants(model).items():
            trajectory = simulate(plant, u, dt, noise, seed)
            samples = samples_of(trajectory, trajectory.y + np.array([0.0, offset]))
            for run, changed, factors in (
                    (WALK, parameters, (1.0, 1.0)),
                    *((f'{name}, {start}', {**learned, 'tau_k_model': name}, factors)
                      for name in (LEARNED, MIXED) for start, factors in STARTS.items())):
                estimator = Estimator(wrong(model, *factors), unsmoothed(changed))
                rows = figures.setdefault(', '.join(filter(None, (run, kind))), {})
                for name, value in _measured(estimator, samples, trajectory).items():
                    rows.setdefault(name, []).append(value)
        progress(f'learned curve: {seed + 1} of {seeds} runs')
    return {'parameters': {'q_std_tau_k_deviation': learned['q_std_tau_k_deviation']},
            **{run: {name: float(np.mean(values)) for name, values in rows.items()}
               for run, rows in figures.items()}}


def _measured(estimator: Estimator, samples: Samples, trajectory: Trajectory) -> dict[str, float]:
    estimates = estimator.run(samples)
    k = np.searchsorted(samples.stamp_ns, estimates.stamp_ns)
    late = k >= len(samples.stamp_ns) // 2
    error = (estimates.tau_k - trajectory.tau_k[k])[late]
    ratio = np.abs(error) / estimates.tau_k_std[late]
    result = {'tau': float(np.sqrt(np.mean(error ** 2))), 'one': float(np.mean(ratio < 1.0)),
              'two': float(np.mean(ratio < 2.0))}
    if estimator.learned_curve():
        result.update(K=float(estimates.stiffness[-1]), b=float(estimates.half_gap[-1]),
                      h=float(estimates.hysteresis[-1]))
    return result


def text(figures: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return the `figures` of evaluate() as lines, at most 80 columns."""
    lines = ['beyond the paper, second half: the EKF that learns the curve, and the mixture', '',
             f'{"":<40}{"tau_K":>7}{"1 s":>6}{"2 s":>6}{"K":>7}{"b":>7}{"h":>7}']
    for run, row in figures.items():
        if run != 'parameters':
            learnt = [f'{row[name]:7.3f}' if name in row else f'{"-":>7}' for name in 'Kbh']
            lines.append(f'{run:<40}{row["tau"]:7.3f}{row["one"]:6.2f}{row["two"]:6.2f}'
                         + ''.join(learnt))
    return lines


def bars(case: str, figures: Mapping[str, Mapping[str, float]],
         add: Callable[[str, Any, float, float], None]) -> None:
    """
    Judge the figures of evaluate().

    Args:
        case: name of the case.
        figures: from evaluate().
        add: called with name, value, low and high of each bar.
    """
    for run in (f'{name}, {start}' for name in (LEARNED, MIXED) for start in STARTS):
        add(f'{case} {run}, tau', figures[run]['tau'], -np.inf, MAX_ERROR[case])
        add(f'{case} {run}, 1 sigma', figures[run]['one'], *ONE_SIGMA)
        add(f'{case} {run}, 2 sigma', figures[run]['two'], *TWO_SIGMA)
        for kind in ('hardening', 'offset flanks') if run.startswith(MIXED) else ():
            add(f'{case} {run}, {kind} / random walk',
                figures[f'{run}, {kind}']['tau'] / figures[f'{WALK}, {kind}']['tau'],
                -np.inf, MAX_LOSS)
