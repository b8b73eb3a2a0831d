# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulated runs for the benchmark of the trust indicators: drives, faults, and a monitor.

A Monitor watches a simulated drive second by second, as the node does. In addition, the tests are
applied to each window of its innovations separately.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from benchmarks import paper
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.process_model import pack, TAU_K
from gearbox_monitor.estimation.tune import tuned
from gearbox_monitor.health.alarms import Level, LIMITS
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.checks import innovation, observability
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values
from gearbox_monitor.parameters import PlantParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import EncoderFault, Excitation, Faults, FaultyPlant
from gearbox_monitor.plant.simulate import Noise, simulate

DT, DT_NS, T0 = paper.DT, round(paper.DT * 1e9), paper.T0
WINDOW = 500        # samples of one window of innovations
BURN_IN = 3.0       # s that are not judged
CHUNK = 60          # s simulated at once
LOAD = 0.5          # rms of the load on the arm over rms of tau_K
TESTS = ('mean', 'whiteness', 'nis', 'covariance', 'observability')
FaultsAt: TypeAlias = Callable[[float], Faults]  # of the start of the faults, s


@dataclass(frozen=True)
class SimulatedDrive:
    """A simulated drive: truth `model` and `noise`; the estimator's `assumed` and `parameters`."""

    name: str
    model: DriveModel
    noise: Noise
    assumed: DriveModel
    parameters: Values


@dataclass(frozen=True)
class MonitoredRun:
    """
    Result of one run.

    flags {test: bool [W]} of windows that began `began` [W] s after the start; at [M] s: when
    outcomes were read; levels {component: int [M]}: their levels; windows: Backlash of each
    drift window; tau_k_std: median of the stated deviation, N m.
    """

    flags: dict[str, Flags]
    began: Array
    at: Array
    levels: dict[str, Integers]
    windows: list[Backlash]
    tau_k_std: float

    def any(self) -> Flags:
        """Return bool [W]: flagged by any test."""
        return np.logical_or.reduce([self.flags[name] for name in TESTS])

    def alarms(self) -> dict[str, int]:
        """Return {component: how often it left OK}; a component that was never OK counts once."""
        counts = {}
        for name, levels in self.levels.items():
            raised = int(np.sum((levels[1:] > Level.OK) & (levels[:-1] == Level.OK)))
            counts[name] = raised if (levels == Level.OK).any() else 1
        return counts

    def delay(self, start: float) -> tuple[float, str] | tuple[None, None]:
        """Return (s from `start` to the first alarm, its component), or (None, None)."""
        is_before, is_after = self.at <= start, self.at > start
        first_alarms = []
        for name, levels in self.levels.items():
            if not is_before.any() or levels[is_before][-1] != Level.OK:
                continue  # an alarm that was raised already says nothing
            raised = np.flatnonzero(is_after & (levels > Level.OK))
            if len(raised):
                first_alarms.append((float(self.at[raised[0]] - start), name))
        return min(first_alarms, default=(None, None))


def loaded(model: DriveModel) -> DriveModel:
    """
    Return `model` with gravity and Coulomb friction on the arm.

    A fixed-point iteration makes the rms of their sum LOAD times that of tau_K.
    """
    u = Excitation().torque(DT * np.arange(round(10.0 / DT)))
    size = 0.1
    for _ in range(12):
        loaded_model = model.with_(effects=({'id': 'gravity', 'G': size},
                                            {'id': 'arm_coulomb', 'Cac': size}))
        run = simulate(loaded_model, u, DT)
        size *= (LOAD * np.sqrt(np.mean(run.tau_k ** 2) / np.mean(run.tau_arm ** 2))) ** 0.7
    return loaded_model


def paper_drive(case: str, with_load: bool, seeds: Sequence[int] = paper.TUNING_SEEDS,
                parameters: Values | None = None) -> SimulatedDrive:
    """
    Return the SimulatedDrive of a case of the paper.

    Args:
        case: key of paper.CASES.
        with_load: whether gravity and friction act on the arm.
        seeds: of the recordings that R and Q are tuned on, by likelihood.
        parameters: estimator parameters; None: tune them.

    Returns:
        The drive, its noise and the parameters of its estimator.
    """
    model, noise, u = paper.drive(case)
    start: dict[str, Any] = {
        'arm_load': 'unknown' if with_load else 'none', 'smoother_lag': 0.0,
        'q_std_motor_position': noise.process[0], 'q_std_arm_position': noise.process[1],
        'q_std_motor_speed': noise.process[2], 'q_std_arm_speed': noise.process[3]}
    start = {k: float(v) if k.startswith('q') else v for k, v in start.items()}
    truth = loaded(model) if with_load else model
    estimator_parameters = parameters or tuned(
        model, start, [paper.run_samples(simulate(truth, u, DT, noise, seed)) for seed in seeds])
    return SimulatedDrive(f'{case}, arm load' if with_load else case, truth, noise, model,
                          estimator_parameters)


def packaged_drive() -> SimulatedDrive:
    """Return the SimulatedDrive that the nodes start with, with an unmeasured load on the arm."""
    plant, model = PlantParameters(), DriveModel()
    noise = Noise(plant.process_noise, plant.measurement_noise)
    return SimulatedDrive('packaged', loaded(model), noise, model, {})


def faults(noise: Noise) -> dict[str, FaultsAt]:
    """Return a function of the start (s) for each fault of a drive with this `noise`."""
    def encoders(fault: EncoderFault) -> FaultsAt:
        """Return the function for the same `fault` of both encoders."""
        return lambda start: Faults(start, motor=fault, arm=fault)

    outliers = [EncoderFault(outlier_rate=0.01, outlier_size=5.0 * std)
                for std in noise.measurement]
    frozen, missing = EncoderFault(frozen=True), EncoderFault(lost=True)
    delayed = EncoderFault(delay=0.005)
    return {
        'noise x1.2': encoders(EncoderFault(noise=1.2)),
        'noise x1.5': encoders(EncoderFault(noise=1.5)),
        'outliers 1 %': lambda s: Faults(s, motor=outliers[0], arm=outliers[1]),
        'motor frozen': lambda s: Faults(s, motor=frozen),
        'arm frozen': lambda s: Faults(s, arm=frozen),
        'motor lost': lambda s: Faults(s, motor=missing),
        'arm lost': lambda s: Faults(s, arm=missing),
        'motor 5 ms late': lambda s: Faults(s, motor=delayed),
        'arm 5 ms late': lambda s: Faults(s, arm=delayed),
        'arm scale x1.02': lambda s: Faults(s, arm=EncoderFault(scale=1.02)),
        'Cv x1.2': lambda s: Faults(s, viscous_friction=1.2),
        'Cc x2': lambda s: Faults(s, coulomb_friction=2.0),
        'torque x1.05': lambda s: Faults(s, torque=1.05),
    }


# Not faults of the drive but of the filter's tuning, from the start on (factor on q_p).
MISTUNED = {'q_p /10': 0.1, 'q_p x10': 10.0}


def watch(drive: SimulatedDrive, seconds: float, seed: int, faults: Faults | None = None,
          parameters: Values | None = None, reference: float | None = None, flags: bool = True,
          stop: Callable[[list[Backlash]], bool] | None = None) -> MonitoredRun:
    """
    Simulate a drive and watch it with a Monitor.

    Args:
        drive: simulated drive.
        seconds: length of the run.
        seed: of the noise.
        faults: faults of the drive; None: it is healthy.
        parameters: estimator parameters that differ from those of the drive.
        reference: usual deviation of tau_K, N m; None: the median of this run.
        flags: whether the tests are applied to each window of innovations, too.
        stop: called with the new drift windows after each CHUNK; ends the run if it returns True.

    Returns:
        Flags, levels and drift windows after the burn-in.
    """
    plant = FaultyPlant(drive.model, drive.noise, seed, faults)
    monitor = Monitor(drive.assumed, {**drive.parameters, **(parameters or {})})
    excitation, n, second = Excitation(), round(seconds / DT), round(1.0 / DT)
    at: list[float] = []
    levels: list[dict[str, int]] = []
    tests: list[dict[str, Any]] = []
    windows: list[Backlash] = []
    for begin in range(0, n, CHUNK * second):
        k = np.arange(begin, min(n, begin + CHUNK * second))
        run = plant.run(excitation.torque(k * DT), DT, begin * DT)
        estimates = []
        for a in range(0, len(k), second):
            part = slice(a, a + second)
            u = np.column_stack([run.u[part], np.full(len(k[part]), np.nan)])
            estimates.append(monitor.run(Samples(T0 + k[part] * DT_NS, u, run.y[part])).rows)
            at.append((k[part][-1] + 1) * DT)
            levels.append({name: int(f.level) for name, f in monitor.outcomes.items()})
        last = windows[-1].stamp_ns if windows else 0
        new = [w for w in monitor.windows if w.stamp_ns > last]
        windows += new
        if flags:
            tests.append(_judged(np.concatenate(estimates), monitor, at[-1]))
        if stop and stop(new):
            break
    times = np.array(at)
    settled = times > BURN_IN + 1.0
    levels_of = {name: np.array([level_of[name] for level_of in levels])[settled]
                 for name in (levels[-1] if levels else {})}
    flags_of: dict[str, Flags] = {}
    began, std = np.empty(0), np.nan
    if flags:
        values = {name: np.concatenate([r[name] for r in tests]) for name in tests[0]}
        keep = values['began'] >= BURN_IN - 1e-9
        began, stated = values['began'][keep], values['std'][keep]
        std = float(np.median(stated))
        flags_of = {name: values[name][keep] for name in TESTS if name != 'covariance'}
        ratio = stated / (reference or std)
        flags_of['covariance'] = (ratio < LIMITS.covariance_low) | (ratio > LIMITS.covariance_high)
    return MonitoredRun(flags_of, began, times[settled], levels_of, windows, std)


def significant(white: Array, nis: Array, dof: Array) -> dict[str, bool]:
    """
    Return whether significance alone speaks against a window of W samples, by test.

    If the filter's model were exact, each test would flag `error_significance` of windows
    (whiteness: of long ones).

    Args:
        white: whitened innovations [W, 2].
        nis: normalised innovation squared [W].
        dof: its degrees of freedom [W].
    """
    count, (low, high) = len(nis), innovation.nis_limits(float(dof.sum()))
    values = innovation.check(white, nis, dof, white, np.ones(white.shape), count, count).values
    return {'mean': values['mean'] > innovation.MEAN_LIMIT,
            'whiteness': values['ljung_box'] > innovation.LJUNG_BOX_LIMIT,
            'nis': not low <= values['nis_over_dof'] <= high}


def _judged(rows: Array, monitor: Monitor, end: float) -> dict[str, Any]:
    """Return the tests of windows of WINDOW estimates each, as {name: [W]}, up to `end` s."""
    count = len(rows) // WINDOW
    rows = rows[len(rows) - count * WINDOW:].reshape(count, WINDOW, -1)
    white = [sample_loop.E_WHITE_1, sample_loop.E_WHITE_2]
    results = [significant(w[:, white], w[:, sample_loop.E_NIS], w[:, sample_loop.E_DOF])
               for w in rows]
    packed, names = pack(monitor.estimator.drive, monitor.parameters), monitor.estimator.names
    columns = [{'tau_arm': sample_loop.E_TAU_ARM, 'tau_e': sample_loop.E_TAU_E}.get(name, i)
               for i, name in enumerate(names)]
    last = rows[:, -round(LIMITS.information_window / DT):]
    innovations = [sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM]
    share = [observability.information_share(
        np.ascontiguousarray(w[:, columns]), np.ascontiguousarray(w[:, sample_loop.E_DT]),
        np.ascontiguousarray(np.isfinite(w[:, innovations])), packed)[TAU_K]
        for w in last]
    return {
        'began': end - np.arange(count, 0, -1) * WINDOW * DT,
        **{name: np.array([bool(f[name]) for f in results], bool)
           for name in ('mean', 'whiteness', 'nis')},
        'observability': ~(np.asarray(share) <= LIMITS.untrusted),
        'std': np.median(rows[:, :, sample_loop.E_MOTOR_SIDE_NOISE_STD], axis=1)}
