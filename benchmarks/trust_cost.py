# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Cost of the trust indicators per sample against one EKF step, in one run."""
from collections.abc import Callable, Mapping
import time
from typing import Any

import numpy as np

from benchmarks import paper
from benchmarks.steps import cpu_per_step, stepper
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import simulate

ROUNDS = 9


def cost_ratio(parameters: Mapping[str, Any] | None = None,
               rounds: int = ROUNDS) -> dict[str, float]:
    """
    Return {'step', 'trust', 'ratio'}: CPU time (s) of an EKF step and of trust, per sample.

    Trust is all that a Monitor with these `parameters` does beside filter, smoother and drift:
    keeping the history, judging once per second, debouncing. Medians over `rounds` runs of 20 s at
    1 kHz of case A, the two interleaved, so that a change in the speed of the machine affects both
    alike.
    """
    model, noise, u = paper.drive('A')
    parameters = {'arm_load': 'none', 'smoother_lag': 0.0, **(parameters or {})}
    trajectory = simulate(model, u, paper.DT, noise, 0)
    samples = paper.run_samples(trajectory)
    step = stepper(model, parameters, trajectory.u, np.ascontiguousarray(trajectory.y), paper.DT)
    trust = _trust_cost(model, parameters, samples)
    costs: list[tuple[float, float]] = []
    trust()  # compiles
    for _ in range(rounds):
        costs.append((cpu_per_step({'EKF': step}, len(u), 1)['EKF'], trust() / len(u)))
    of_step, of_trust = np.median(costs, axis=0)
    return {'step': float(of_step), 'trust': float(of_trust),
            'ratio': float(np.median([b / a for a, b in costs]))}


def _trust_cost(model: DriveModel, parameters: Mapping[str, Any],
                samples: Samples) -> Callable[[], float]:
    """Return a function that runs a Monitor over `samples` and returns the CPU time of trust."""
    def run() -> float:
        monitor, spent = Monitor(model, parameters), [0.0]
        replaced = {'_check_backlash': lambda *_: {},
                    **{name: _timed(getattr(monitor, name), spent)
                       for name in ('_remember', '_evaluate')}}
        for name, function in replaced.items():
            setattr(monitor, name, function)
        monitor.run(samples)
        return spent[0]
    return run


def _timed(function: Callable[..., object], spent: list[float]) -> Callable[..., None]:
    def call(*args: Any) -> None:
        begin = time.process_time()
        function(*args)
        spent[0] += time.process_time() - begin
    return call
