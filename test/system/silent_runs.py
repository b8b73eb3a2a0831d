# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Faults of source, encoders and drive in motions of machines: what was said and what was true."""
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_STD, S_TWIST, S_TWIST_STD
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.monitor import COMPONENTS, Monitor
from gearbox_monitor.plant.drive import Controller, DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant

SECONDS, SETTLED = 60, 6  # s of a run; s after its start that are not judged
DT, STEP_NS, T0 = 1e-3, 1_000_000, 1_700_000_000_000_000_000
PER_SECOND = 1000  # samples
SIGMA, SHARE = 3.0, 0.01  # stated standard deviations; share of estimates that may be beyond
SERVO = Controller(kp=20.0, kd=0.9)
NOISE = (0.005, 0.005)  # rad
PROCESS = (0.0, 0.0, 0.4, 0.4)
TRUST = (*COMPONENTS[:4], 'input')
MOTIONS = ('multisine', 'point to point', 'slow')
LOADS = ('none', 'unknown')


@dataclass(frozen=True)
class Source:
    """What a source publishes: stamps int64 [N] ns, effort [N] N m, readings [N, 2] rad."""

    stamp_ns: np.ndarray
    effort: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Fault:
    """
    One fault of a given `size`.

    source(Source, size, Trajectory): what is published instead; plant(DriveModel, size): the drive
    that moves instead. sizes: (low, high) that are drawn from, and the one of the table. healthy:
    whether nothing is to be said.
    """

    name: str
    size: float = 1.0
    sizes: tuple[float, float] = (1.0, 1.0)
    source: Callable | None = None
    plant: Callable | None = None
    healthy: bool = False


# ---------------------------------------------------------------------- motions

def plant_of(motion):
    """Return the DriveModel that moves: the packaged one with the load of the motion."""
    load = {'point to point': [{'id': 'gravity', 'G': 2.3}],
            'slow': [{'id': 'arm_coulomb', 'Cac': 0.6}]}.get(motion, [])
    return DriveModel().with_(effects=load)


def trajectory(motion, model, noise, seed, seconds=SECONDS):
    """Return the Trajectory of `model` in `motion` of so many s; noise: rad of both encoders."""
    random = np.random.default_rng([seed, 3])
    t = DT * np.arange(round(seconds / DT))
    if motion == 'multisine':
        scale, faster = (1.0, 1.0) if not seed else random.uniform(0.7, 1.3, 2)
        u = Excitation('multisine', (6.0 * scale, 2.0 * scale),
                       (0.9 * faster, 2.3 * faster)).torque(t)
        return Plant(model, Noise(PROCESS, noise), seed).run(u, DT)
    reference = (_point_to_point(t, random) if motion == 'point to point'
                 else _slow(t, random))
    return _controlled(model, noise, seed, reference)


def _point_to_point(t, random):
    """Return positions [N] of moves of 0.5 to 0.9 s between rests of up to 2 s."""
    x, begin, at = np.zeros(len(t)), 0.0, 0.5
    while at < t[-1]:
        end, length = random.uniform(-1.6, 1.6), random.uniform(0.5, 0.9)
        s = np.clip((t - at) / length, 0.0, 1.0)
        x = np.where(t >= at, begin + (end - begin) * s ** 3 * (10.0 - 15.0 * s + 6.0 * s * s), x)
        begin, at = end, at + length + random.uniform(0.3, 2.0)
    return x


def _slow(t, random):
    """Return positions [N] of a slow sine of some rad."""
    return random.uniform(3.0, 5.0) * (1.0 - np.cos(2.0 * np.pi * random.uniform(0.1, 0.2) * t))


def _controlled(model, noise, seed, reference):
    """Return the Trajectory whose motor follows `reference` [N]; its u: the servo's torque."""
    setpoint = reference + SERVO.kd / SERVO.kp * np.gradient(reference, DT)
    run = Plant(replace(model, controller=SERVO), Noise(PROCESS, noise), seed).run(setpoint, DT)
    # What acted between two samples: the mean of both ends.
    mean = 0.5 * (run.x + np.vstack([run.x[1:], run.x[-1:]]))
    return replace(run, u=SERVO.torque(setpoint, mean[:, 0], mean[:, 2], DT))


@lru_cache(maxsize=8)
def _healthy(motion, seed, seconds):
    return trajectory(motion, plant_of(motion), NOISE, seed, seconds)


# ---------------------------------------------------------------------- faults

def _effort(change):
    return lambda source, size, run: replace(source, effort=change(source.effort, size))


def _late(values, samples):
    n = round(samples)
    return np.concatenate([np.repeat(values[:1], n, axis=0), values[:len(values) - n]])


def _encoder(joint, change):
    def apply(source, size, run):
        y = source.y.copy()
        y[:, joint] = change(y[:, joint], size)
        return replace(source, y=y)
    return apply


def _clipped(u, share):
    return np.clip(u, -share * np.abs(u).max(), share * np.abs(u).max())


def _noisy(source, size, run):
    return replace(source, y=run.x[:, :2] + size * (source.y - run.x[:, :2]))


def _clock(source, size, run):
    stamps = T0 + np.round((source.stamp_ns - T0) / size).astype(np.int64)
    return replace(source, stamp_ns=stamps)


def _model(**factors):
    def apply(model, size):
        shape = model.transmission
        return model.with_(**{
            name: (getattr(model, name, None) or getattr(shape, name, None)) * (
                size if factor is None else factor) for name, factor in factors.items()})
    return apply


MOTOR, ARM = 0, 1
HEALTHY = Fault('healthy', healthy=True)
FAULTS = (
    HEALTHY,
    Fault('sign of the effort', source=_effort(lambda u, _: -u)),
    Fault('effort x 2', 2.0, (1.3, 3.0), _effort(lambda u, s: s * u)),
    Fault('effort x 0.5', 0.5, (0.3, 0.75), _effort(lambda u, s: s * u)),
    Fault('effort x 1.15', 1.15, (1.05, 1.3), _effort(lambda u, s: s * u)),
    Fault('effort x 0.85', 0.85, (0.75, 0.95), _effort(lambda u, s: s * u)),
    Fault('effort clipped', 0.5, (0.3, 0.8), _effort(_clipped)),
    Fault('effort held 50 ms', 50, (10, 100), _effort(
        lambda u, s: np.repeat(u[::round(s)], round(s))[:len(u)])),
    Fault('effort 20 ms late', 20, (5, 50), _effort(_late)),
    Fault('sign of the motor', source=_encoder(MOTOR, lambda y, _: -y)),
    Fault('sign of the arm', source=_encoder(ARM, lambda y, _: -y)),
    Fault('joints swapped', source=lambda s, _, run: replace(s, y=s.y[:, ::-1].copy())),
    Fault('motor x 1.02', 1.02, (1.005, 1.05), _encoder(MOTOR, lambda y, s: s * y)),
    Fault('arm x 0.98', 0.98, (0.95, 0.995), _encoder(ARM, lambda y, s: s * y)),
    Fault('motor x 2', 2.0, (1.2, 3.0), _encoder(MOTOR, lambda y, s: s * y)),
    Fault('arm x 0.5', 0.5, (0.3, 0.8), _encoder(ARM, lambda y, s: s * y)),
    Fault('both x 0.5', 0.5, (0.3, 0.8), lambda s, size, _: replace(s, y=size * s.y)),
    Fault('both x 2', 2.0, (1.3, 3.0), lambda s, size, _: replace(s, y=size * s.y)),
    Fault('motor 5 ms late', 5, (2, 30), _encoder(MOTOR, _late)),
    Fault('arm 5 ms late', 5, (2, 30), _encoder(ARM, _late)),
    Fault('clock x 2', 2.0, (1.2, 3.0), _clock),
    Fault('clock x 0.5', 0.5, (0.3, 0.8), _clock),
    Fault('Cv x 0.5', 0.5, (0.3, 0.8), plant=_model(viscous_friction=None)),
    Fault('Cv x 1.5', 1.5, (1.2, 2.0), plant=_model(viscous_friction=None)),
    Fault('Cc x 1.5', 1.5, (1.2, 3.0), plant=_model(coulomb_friction=None)),
    Fault('Cv, Cc x 1.5', 1.5, (1.2, 2.0), plant=_model(
        viscous_friction=None, coulomb_friction=None)),
    Fault('noise x 2', 2.0, (1.5, 4.0), _noisy),
    Fault('gap x 1.3', 1.3, (1.1, 2.0), plant=_model(half_gap=None)),
    Fault('stiffness x 0.8', 0.8, (0.6, 0.95), plant=_model(stiffness=None)),
)


# ---------------------------------------------------------------------- runs

@dataclass(frozen=True)
class Outcome:
    """
    What a run gave.

    beyond: shares of the estimates under levels that are all OK that are off by more than
    SIGMA stated deviations, for (tau_K, smoothed tau_K, smoothed twist); told: s until a level is
    not OK, where the run ends, None: never; by: the components that say it; error, stated: rms of
    smoothed tau_K, N m.
    """

    fault: str
    size: float
    motion: str
    load: str
    filter: str
    seed: int
    beyond: tuple[float, float, float]
    told: float | None
    by: tuple[str, ...]
    error: float
    stated: float

    @property
    def silent(self):
        """Whether it breaks the promise: nothing was said, and the estimates were wrong."""
        return self.told is None and max(self.beyond) > SHARE


def simulated(fault, size, motion, seed, seconds=SECONDS):
    """Return (Source, Trajectory) of `seconds` of a drive with `fault` of this size."""
    if fault.plant is None:
        run = _healthy(motion, seed, seconds)
    else:
        run = trajectory(motion, fault.plant(plant_of(motion), size), NOISE, seed, seconds)
    source = Source(T0 + STEP_NS * np.arange(len(run.t)), run.u, run.y)
    return (fault.source(source, size, run) if fault.source else source), run


def run(fault, motion, load, kind='ekf', seed=0, size=None, seconds=SECONDS):
    """
    Return the Outcome of a drive with a fault from the first sample on.

    Args:
        fault: Fault.
        motion: one of MOTIONS.
        load: arm_load of the estimator, one of LOADS; "none": its model has the load of the drive.
        kind: name of the filter.
        seed: of noise and motion.
        size: of the fault, None: that of the table.
        seconds: s that the run lasts unless something is told.

    """
    size = fault.size if size is None else size
    source, truth = simulated(fault, size, motion, seed, seconds)
    model = plant_of(motion) if load == 'none' else DriveModel()
    monitor = Monitor(model, {'arm_load': load, 'filter': kind})
    told, by = None, ()
    rows, smoothed, numbers, smoothed_numbers = [], [], [], []
    # One block per second of motion: diagnostics come once per second.
    for second in range(seconds):
        part = slice(second * PER_SECOND, (second + 1) * PER_SECOND)
        u = np.column_stack([source.effort[part], np.full(len(source.effort[part]), np.nan)])
        found = monitor.run(Samples(source.stamp_ns[part], u, source.y[part]))
        rows.append(found.rows)
        smoothed.append(found.smoothed)
        numbers.append(np.searchsorted(source.stamp_ns, found.stamp_ns))
        smoothed_numbers.append(np.searchsorted(source.stamp_ns, found.smoothed_stamp_ns))
        by = tuple(name for name in TRUST if monitor.outcomes[name].level > Level.OK)
        if by and second >= SETTLED:  # the promise is kept
            told = second + 1.0
            break
    rows, smoothed = np.concatenate(rows), np.concatenate(smoothed)
    at, at_smoothed = np.concatenate(numbers), np.concatenate(smoothed_numbers)
    twist, tau = truth.x[:, 0] - truth.x[:, 1], truth.tau_k
    off = (smoothed[:, S_TAU_K] - tau[at_smoothed])
    errors = (
        (at, (rows[:, 4] - tau[at]) / rows[:, 7 + 4]),
        (at_smoothed, off / smoothed[:, S_TAU_K_STD]),
        (at_smoothed, (smoothed[:, S_TWIST] - twist[at_smoothed]) / smoothed[:, S_TWIST_STD]))
    beyond = tuple(float(np.mean(np.abs(e[n * DT > SETTLED]) > SIGMA)) if len(e) else 0.0
                   for n, e in errors)
    settled = at_smoothed * DT > SETTLED
    return Outcome(
        fault.name, size, motion, load, kind, seed, beyond, told, by if told else (),
        float(np.sqrt(np.mean(off[settled] ** 2))),
        float(np.median(smoothed[settled, S_TAU_K_STD])))
