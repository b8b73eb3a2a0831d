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

"""Cost of a filter's step: CPU time of the kernel alone, rounds of several filters interleaved."""
import time

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import batch_score
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator, loop_arrays
from gearbox_monitor.estimation.filter import Filter
from gearbox_monitor.estimation.filter_kind import filter_kind, Reading
from gearbox_monitor.estimation.process_model import markers, pack, state_names
from gearbox_monitor.estimation.sample_loop import filter_step, start
from gearbox_monitor.kernels.jit import bound
from gearbox_monitor.parameters import EstimatorParameters


def _loop(states, belief, u, y, dt, p, scratch, record):
    """Run the filter that filter_step stands for over N samples; return how many steps failed."""
    failed = 0
    for k in range(1, u.shape[0]):
        if not filter_step(states, belief, Reading(dt, u[k - 1], 0.0, y[k, 0], y[k, 1]), p,
                           scratch, record):
            failed += 1
            start(states, belief, y[k, 0], y[k, 1], p, record)
            belief.memory[:] = 0.0
    return failed


def stepper(model, parameters, u, y, dt):
    """Return a function that runs the filter of `parameters` over u [N], y [N, 2] once."""
    parameters = EstimatorParameters.of(parameters)
    model = model.with_(arm_load=parameters.arm_load)
    n, p = len(state_names(model, parameters)), pack(model, parameters)
    kind, states = filter_kind(parameters.filter), markers(p, n)
    loop = bound(_loop, kind.name, filter_step=kind.step)

    def run():
        belief, scratch, state = loop_arrays(kind, n, 1)
        start(states, belief, y[0, 0], y[0, 1], p, state.ring[0])
        return loop(states, belief, u, y, dt, p.copy(), scratch, state.ring[0])
    return run


def caller(model, parameters, u, y, dt):
    """Return a function that runs a Filter over u [N], y [N, 2], one call per sample."""
    single, torques, readings = Filter(model, parameters), u.tolist(), y.tolist()

    def run():
        single.start(*readings[0])
        for torque, (y1, y2) in zip(torques, readings[1:]):
            single.step(dt, torque, y1, y2)
    return run


def bank_stepper(model, parameters, u, y, dt, size):
    """Return a function that runs `size` EKFs of different Q side by side, over u, y once."""
    samples = Samples(np.round((1.0 + dt * np.arange(len(u))) * 1e9).astype(np.int64),
                      np.column_stack([u, np.full(len(u), np.nan)]), y)
    one = Estimator(model, parameters)
    packed = np.array([pack(one.drive, one.parameters.replace(q_std_tau_k=float(q)))
                       for q in one.parameters.q_std_tau_k * np.geomspace(0.2, 5.0, size)])

    def run():
        scores = batch_score.run(packed, one.states, one.settings, samples, 1)
        if not np.isfinite(scores).all():
            raise InputError('a filter of the batch diverged')
    return run


def cpu_per_step(steppers, n, rounds=9):
    """
    Return the median CPU time per step (s) of each of `steppers` {name: function of n steps}.

    n: one number, or {name: number}. Every round runs each once, so that a machine that changes
    its speed hits all alike.
    """
    times = {name: [] for name in steppers}
    for run in steppers.values():
        run()  # compiles
    for _ in range(rounds):
        for name, run in steppers.items():
            begin = time.process_time()
            run()
            times[name].append(time.process_time() - begin)
    counts = n if isinstance(n, dict) else dict.fromkeys(steppers, n)
    return {name: float(np.median(values)) / counts[name] for name, values in times.items()}
