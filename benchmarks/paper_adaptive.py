# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The adaptive filter from wrong starts, on the drives of "benchmarks paper".

40 s, judged on the last 20 s; encoder noise x 4 in 20 .. 40 s of 60 s, judged there.
"""
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate, Trajectory

SETTLED = (20.0, 40.0)  # s
NOISIER = 4.0
# start -> (parameters, factor on R's deviations, factor on the model's viscous friction)
STARTS: dict[str, tuple[dict[str, Any], float, float]] = {
    'tuned EKF': ({'filter': 'ekf'}, 1.0, 1.0),
    'q_p = 1': ({'filter': 'aekf', 'q_std_tau_k': 1.0}, 1.0, 1.0),
    'q_p = 1, R x 9': ({'filter': 'aekf', 'q_std_tau_k': 1.0}, 3.0, 1.0),
    'q_p = 1e4': ({'filter': 'aekf', 'q_std_tau_k': 100.0}, 1.0, 1.0),
    'q_p = 1e4, R x 9': ({'filter': 'aekf', 'q_std_tau_k': 100.0}, 3.0, 1.0),
    'Cv x 2': ({'filter': 'aekf', 'adapt': ['viscous_friction']}, 1.0, 2.0),
    'q_p, k_p': ({'filter': 'aekf', 'adapt': ['q_std_tau_k', 'tau_k_stiffness'],
                  'tau_k_stiffness': 1.0}, 1.0, 1.0),
}
WRONG_Q = [name for name in STARTS if name.startswith('q_p =')]
MAX_LOSS, MAX_SPREAD, MAX_CV_ERROR, MAX_K_P = 1.02, 0.02, 0.002, 0.66
MAX_NOISIER = {'A': 1.75}


def evaluate(drive: tuple[DriveModel, Noise], samples_of: Callable[..., Samples],
             parameters: Mapping[str, Any], seeds: int, dt: float, t0: int,
             progress: Callable[[str], None]) -> dict[str, list[float]]:
    """
    Measure settled errors of the adaptive filter from each start.

    Args:
        drive: model and noise of the case.
        samples_of: turns a Trajectory (and other readings [N, 2]) into Samples from t0 on.
        parameters: tuned parameters of the estimator.
        seeds: runs.
        dt: sample time, s.
        t0: first stamp, ns.
        progress: called with a line of text.

    Returns:
        Root mean square errors of tau_K (N m) by start, and viscous friction, one per seed.
    """
    model, noise = drive
    u = Excitation().torque(dt * np.arange(round(60.0 / dt)))
    figures: dict[str, list[float]] = {
        name: [] for name in (*STARTS, 'Cv', 'noise x 4, EKF', 'noise x 4, AEKF')}

    def error(estimates: Estimates, trajectory: Trajectory) -> float:
        """Return the settled RMS error of tau_K in `estimates` of a `trajectory`, N m."""
        k = np.round((estimates.stamp_ns - t0) * 1e-9 / dt).astype(int)
        keep = (k * dt >= SETTLED[0]) & (k * dt < SETTLED[1])
        return float(np.sqrt(np.mean((estimates.tau_k - trajectory.tau_k[k])[keep] ** 2)))

    for seed in range(seeds):
        progress(f'adaptive filter, seed {seed + 1} of {seeds}')
        trajectory = simulate(model, u[:round(SETTLED[1] / dt)], dt, noise, seed)
        samples = samples_of(trajectory)
        for name, (changes, r, cv) in STARTS.items():
            own = {key: r * parameters[key] for key in ('r_std_motor', 'r_std_arm')}
            monitor = Monitor(model.with_(viscous_friction=cv * model.viscous_friction),
                              {**parameters, **own, **changes})
            figures[name].append(error(monitor.run(samples), trajectory))
            if 'Cv' in name:
                figures['Cv'].append(monitor.estimator.adapted()['viscous_friction'])
        trajectory = simulate(model, u, dt, noise, seed)
        t = dt * np.arange(len(u))
        louder = np.where((t >= SETTLED[0]) & (t < SETTLED[1]), NOISIER, 1.0)
        y = trajectory.x[:, :2] + louder[:, None] * (trajectory.y - trajectory.x[:, :2])
        samples = samples_of(trajectory, y)
        for name in ('ekf', 'aekf'):
            estimates = Monitor(model, {**parameters, 'filter': name}).run(samples)
            figures[f'noise x 4, {name.upper()}'].append(error(estimates, trajectory))
    return figures


def bars(case: str, figures: Mapping[str, list[float]], viscous_friction: float,
         add: Callable[[str, Any, float, float], None]) -> None:
    """
    Judge the figures of evaluate().

    Args:
        case: name of the case.
        figures: from evaluate().
        viscous_friction: true value, N m s/rad.
        add: called with name, value, low and high of each bar.
    """
    tuned = np.mean(figures['tuned EKF'])
    for name in WRONG_Q:
        add(f'{case} AEKF {name} / EKF', np.mean(figures[name]) / tuned, -np.inf, MAX_LOSS)
        add(f'{case} AEKF {name} spread', np.std(figures[name]), -np.inf, MAX_SPREAD)
    add(f'{case} AEKF Cv from x 2', np.mean(figures['Cv']), viscous_friction - MAX_CV_ERROR,
        viscous_friction + MAX_CV_ERROR)
    add(f'{case} AEKF q_p, k_p tau', np.mean(figures['q_p, k_p']), -np.inf, MAX_K_P)
    if case in MAX_NOISIER:
        add(f'{case} AEKF noise x 4 tau', np.mean(figures['noise x 4, AEKF']), -np.inf,
            MAX_NOISIER[case])
