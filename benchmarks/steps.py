# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Cost of a filter's step: CPU time of the kernel alone, rounds of several filters interleaved."""
from collections.abc import Callable, Mapping
import time

import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.filter_kind import Belief, filter_kind, Reading, Scratch
from gearbox_monitor.estimation.filter_setup import loop_arrays
from gearbox_monitor.estimation.filters.ekf import step as filter_step
from gearbox_monitor.estimation.process_model import layout_of, pack, state_names
from gearbox_monitor.estimation.sample_loop import start
from gearbox_monitor.kernels.kernel import bound, entry, Repeated
from gearbox_monitor.kernels.types import Array, Layout, Matrix, Values, Vector
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel


@entry
def _loop(layout: Layout, belief: Belief, u: Vector, y: Matrix, dt: float, p: Vector,
          scratch: Scratch, record: Vector) -> int:
    """Run the filter bound to filter_step over N samples; return how many steps failed."""
    failed = 0
    for k in range(1, u.shape[0]):
        if not filter_step(layout, belief, Reading(dt, u[k - 1], 0.0, y[k, 0], y[k, 1]), p,
                           scratch, record):
            failed += 1
            start(layout, belief, y[k, 0], y[k, 1], p, record)
            belief.memory[:] = 0.0
    return failed


def stepper(model: DriveModel, parameters: Values, u: Array, y: Array,
            dt: float) -> Callable[[], int]:
    """
    Return a function that runs the kernel of a filter once over a recording.

    Args:
        model: model of the drive.
        parameters: of the estimator; they name the filter.
        u: motor torque [N], N m.
        y: motor and arm position [N, 2], rad.
        dt: sample time, s.

    Returns:
        The function; it returns how many steps failed.
    """
    complete = EstimatorParameters.of(parameters)
    model = model.with_(arm_load=complete.arm_load)
    n, p = len(state_names(model, complete)), pack(model, complete)
    kind, states = filter_kind(complete.filter), layout_of(p, n)
    loop = Repeated(bound(_loop, complete.filter, filter_step=kind.step))

    belief, scratch, state = loop_arrays(kind, n, 1, model)
    start(states, belief, y[0, 0], y[0, 1], p, state.ring[0])
    record = state.ring[0]
    carried = *belief, record, p
    begun = [array.copy() for array in carried]

    def run() -> int:
        for array, first in zip(carried, begun):
            array[:] = first
        return int(loop(states, belief, u, y, dt, p, scratch, record))
    return run


def estimator(model: DriveModel, parameters: Values, u: Array, y: Array,
              dt: float) -> Callable[[], object]:
    """
    Return a function that runs an Estimator without its smoother over a recording.

    model, parameters, u, y, dt: as in stepper().
    """
    samples, one = _samples(u, y, dt), Estimator(model, unsmoothed(parameters))
    length = samples.stamp_ns[-1] + 1_000_000_000  # a jump of the clock restarts the filter

    def run() -> None:
        one.run(samples)
        samples.stamp_ns[:] += length
    return run


def _samples(u: Array, y: Array, dt: float) -> Samples:
    return Samples(np.round((1.0 + dt * np.arange(len(u))) * 1e9).astype(np.int64),
                   np.column_stack([u, np.full(len(u), np.nan)]), y)


def cpu_per_step(steppers: Mapping[str, Callable[[], object]], n: float | Mapping[str, float],
                 rounds: int = 9) -> dict[str, float]:
    """
    Return the median CPU time per step (s) of each of the steppers, by name.

    Every round runs each function once, so that a change in the speed of the machine affects all
    of them alike.

    Args:
        steppers: function by name.
        n: how many steps a call takes, one number for all or a number by name.
        rounds: how many rounds the median is taken of.

    Returns:
        CPU time per step by name, s.
    """
    times: dict[str, list[float]] = {name: [] for name in steppers}
    for run in steppers.values():
        run()  # compiles
    for _ in range(rounds):
        for name, run in steppers.items():
            begin = time.process_time()
            run()
            times[name].append(time.process_time() - begin)
    counts = n if isinstance(n, Mapping) else dict.fromkeys(steppers, n)
    return {name: float(np.median(values)) / counts[name] for name, values in times.items()}
