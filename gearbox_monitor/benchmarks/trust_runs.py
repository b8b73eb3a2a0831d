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

"""
Simulated running for the benchmark of the trust indicators: drives, faults, and what is said.

A Monitor watches a simulated drive second by second, as the node does. Windows of its innovations
are judged beside it, each by itself.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.benchmarks import paper
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.process_model import pack, TAU_K
from gearbox_monitor.estimation.tune import tuned
from gearbox_monitor.monitoring.checks import covariance, innovation, observability
from gearbox_monitor.monitoring.checks.finding import Level
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.parameters import PlantParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.faults import EncoderFault, Faults, FaultyPlant
from gearbox_monitor.plant.simulate import Noise, simulate

DT, DT_NS, T0 = paper.DT, round(paper.DT * 1e9), paper.T0
WINDOW = 500        # samples that one judgement by itself is made of
BURN_IN = 3.0       # s that are not judged
CHUNK = 60          # s simulated at once
LOAD = 0.5          # rms of the load on the arm over rms of tau_K
TESTS = ('mean', 'whiteness', 'nis', 'covariance', 'observability')


@dataclass(frozen=True)
class SimulatedDrive:
    """A simulated drive: truth `model` and `noise`; the estimator's `assumed` and `parameters`."""

    name: str
    model: DriveModel
    noise: Noise
    assumed: DriveModel
    parameters: dict


@dataclass(frozen=True)
class MonitoredRun:
    """
    What one run gave.

    flags {test: bool [W]} of windows that began `began` [W] s after the start; at [M] s: when
    findings were read, levels {component: int [M]} what they said; windows: Backlash of each
    drift window; tau_k_std: median of the stated deviation, N m.
    """

    flags: dict
    began: np.ndarray
    at: np.ndarray
    levels: dict
    windows: list
    tau_k_std: float

    def any(self):
        """Return bool [W]: flagged by any test."""
        return np.any([self.flags[name] for name in TESTS], axis=0)

    def alarms(self):
        """Return {component: how often it left OK; once, too, when it never was OK}."""
        counts = {}
        for name, levels in self.levels.items():
            raised = int(np.sum((levels[1:] > Level.OK) & (levels[:-1] == Level.OK)))
            counts[name] = raised if (levels == Level.OK).any() else 1
        return counts

    def delay(self, start):
        """Return (s from `start` to the first alarm, its component), (None, None) without."""
        is_before, is_after = self.at <= start, self.at > start
        first_alarms = []
        for name, levels in self.levels.items():
            if not is_before.any() or levels[is_before][-1] != Level.OK:
                continue  # has not been OK: nothing to leave
            raised = np.flatnonzero(is_after & (levels > Level.OK))
            if len(raised):
                first_alarms.append((float(self.at[raised[0]] - start), name))
        return min(first_alarms, default=(None, None))


def loaded(model):
    """Return `model` with gravity and Coulomb friction on the arm, together LOAD of rms tau_K."""
    u = Excitation().torque(DT * np.arange(round(10.0 / DT)))
    size = 0.1
    for _ in range(12):
        loaded_model = model.with_(effects=({'id': 'gravity', 'G': size},
                                            {'id': 'arm_coulomb', 'Cac': size}))
        run = simulate(loaded_model, u, DT)
        size *= (LOAD * np.sqrt(np.mean(run.tau_k ** 2) / np.mean(run.tau_arm ** 2))) ** 0.7
    return loaded_model


def paper_drive(case, with_load, seeds=paper.TUNING_SEEDS, parameters=None):
    """
    Return the SimulatedDrive of a case of the paper.

    Args:
        case: key of paper.CASES.
        with_load: whether gravity and friction act on the arm.
        seeds: of the recordings that R and Q are tuned on, by likelihood.
        parameters: estimator parameters; None: tune them.
    """
    model, noise, u = paper.drive(case)
    start = {
        'arm_load': 'unknown' if with_load else 'none', 'smoother_lag': 0.0,
        'q_std_motor_position': noise.process[0], 'q_std_arm_position': noise.process[1],
        'q_std_motor_speed': noise.process[2], 'q_std_arm_speed': noise.process[3]}
    start = {k: float(v) if k.startswith('q') else v for k, v in start.items()}
    truth = loaded(model) if with_load else model
    estimator_parameters = parameters or tuned(
        model, start, [paper.run_samples(simulate(truth, u, DT, noise, seed)) for seed in seeds])
    return SimulatedDrive(f'{case}, arm load' if with_load else case, truth, noise, model,
                          estimator_parameters)


def packaged_drive():
    """Return the SimulatedDrive that the nodes start with, with an unmeasured load on the arm."""
    plant, model = PlantParameters(), DriveModel()
    noise = Noise(plant.process_noise, plant.measurement_noise)
    return SimulatedDrive('packaged', loaded(model), noise, model, {})


def faults(noise):
    """Return {fault: function of its start (s) that gives Faults}; parameters: see MISTUNED."""
    def encoders(start, joints=('motor', 'arm'), **values):
        return Faults(start, **{joint: EncoderFault(**values) for joint in joints})

    def outliers(start):
        return Faults(start, **{
            joint: EncoderFault(outlier_rate=0.01, outlier_size=5.0 * noise.measurement[i])
            for i, joint in enumerate(('motor', 'arm'))})
    return {
        'noise x1.2': lambda s: encoders(s, noise=1.2),
        'noise x1.5': lambda s: encoders(s, noise=1.5),
        'outliers 1 %': outliers,
        'motor frozen': lambda s: encoders(s, ('motor',), frozen=True),
        'arm frozen': lambda s: encoders(s, ('arm',), frozen=True),
        'motor lost': lambda s: encoders(s, ('motor',), lost=True),
        'arm lost': lambda s: encoders(s, ('arm',), lost=True),
        'motor 5 ms late': lambda s: encoders(s, ('motor',), delay=0.005),
        'arm 5 ms late': lambda s: encoders(s, ('arm',), delay=0.005),
        'arm scale x1.02': lambda s: encoders(s, ('arm',), scale=1.02),
        'Cv x1.2': lambda s: Faults(s, viscous_friction=1.2),
        'Cc x2': lambda s: Faults(s, coulomb_friction=2.0),
        'torque x1.05': lambda s: Faults(s, torque=1.05),
    }


# Not a fault of the drive: how the filter is tuned, from the start on (factor on q_p).
MISTUNED = {'q_p /10': 0.1, 'q_p x10': 10.0}


def watch(drive, seconds, seed, faults=None, parameters=None, reference=None, flags=True,
          progress=lambda: None, stop=None):
    """
    Run `drive` for `seconds` s with the Faults `due` and return what was MonitoredRun.

    parameters: estimator parameters that differ from the drive's. reference: tau_K's usual
    deviation (N m), else that of this run. flags: judge windows, too. stop: called now and then
    with new drift windows; ends the run early when it returns True.
    """
    plant = FaultyPlant(drive.model, drive.noise, seed, faults)
    monitor = Monitor(drive.assumed, {**drive.parameters, **(parameters or {})})
    excitation, n, second = Excitation(), round(seconds / DT), round(1.0 / DT)
    rows, at, levels, windows = [], [], [], []
    for begin in range(0, n, CHUNK * second):
        k = np.arange(begin, min(n, begin + CHUNK * second))
        run = plant.run(excitation.torque(k * DT), DT, begin * DT)
        estimates = []
        for a in range(0, len(k), second):
            part = slice(a, a + second)
            u = np.column_stack([run.u[part], np.full(len(k[part]), np.nan)])
            e = monitor.run(Samples(T0 + k[part] * DT_NS, u, run.y[part]))
            estimates.append(e.rows)
            at.append((k[part][-1] + 1) * DT)
            levels.append({name: int(f.level) for name, f in monitor.findings.items()})
        last = windows[-1].stamp_ns if windows else 0
        new = [w for w in monitor.windows if w.stamp_ns > last]
        windows += new
        if flags:
            rows.append(_judged(np.concatenate(estimates), monitor, at[-1]))
        progress()
        if stop and stop(new):
            break
    at = np.array(at)
    settled = at > BURN_IN + 1.0
    levels = {name: np.array([flags_of[name] for flags_of in levels])[settled]
              for name in (levels[-1] if levels else {})}
    flags_of, began, std = {}, np.empty(0), np.nan
    if flags:
        began = np.concatenate([r['began'] for r in rows])
        keep = began >= BURN_IN - 1e-9
        std = float(np.median(np.concatenate([r['std'] for r in rows])[keep]))
        flags_of = {name: np.concatenate([r[name] for r in rows])[keep] for name in TESTS
                    if name != 'covariance'}
        ratio = np.concatenate([r['std'] for r in rows])[keep] / (reference or std)
        flags_of['covariance'] = (ratio < covariance.LOWER) | (ratio > covariance.UPPER)
        began = began[keep]
    return MonitoredRun(flags_of, began, at[settled], levels, windows, std)


def _judged(rows, monitor, end):
    """Return the tests of windows of WINDOW estimates each, as {name: [W]}, up to `end` s."""
    count = len(rows) // WINDOW
    rows = rows[len(rows) - count * WINDOW:].reshape(count, WINDOW, -1)
    white = [sample_loop.E_WHITE_1, sample_loop.E_WHITE_2]
    results = [innovation.flags(w[:, white], w[:, sample_loop.E_NIS], w[:, sample_loop.E_DOF])
               for w in rows]
    packed, names = pack(monitor.estimator.drive, monitor.parameters), monitor.estimator.names
    columns = [{'tau_arm': sample_loop.E_TAU_ARM, 'tau_e': sample_loop.E_TAU_E}.get(name, i)
               for i, name in enumerate(names)]
    last = rows[:, -round(observability.WINDOW / DT):]
    share = [observability.information_share(
        w[:, columns], w[:, sample_loop.E_DT],
        np.isfinite(w[:, [sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM]]),
        packed)[TAU_K]
        for w in last]
    return {
        'began': end - np.arange(count, 0, -1) * WINDOW * DT,
        **{name: np.array([bool(f[name]) for f in results], bool)
           for name in ('mean', 'whiteness', 'nis')},
        'observability': ~(np.asarray(share) <= observability.UNTRUSTED),
        'std': np.median(rows[:, :, sample_loop.E_STD + TAU_K], axis=1)}
