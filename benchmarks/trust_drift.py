# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash in simulated runs: accuracy of its estimate, false alarms, delay of detection."""
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.trust_runs import DT, DT_NS, SimulatedDrive, T0, watch
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.sample_loop import E_HALF_GAP, E_HYSTERESIS
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import Level, Outcome
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.health_record import HealthSettings, Window
from gearbox_monitor.health.judgement import folded, Health, judge
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import EstimatorParameters, LEARNED
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation, Faults, FaultyPlant

Features = Backlash | NotExcited
SMOOTHED = {'smoother_lag': 0.1}
PERIOD = 10.0       # s of a drift window
DAY = 86400.0       # s between two false alarms, of the faster setting
BLOCK = 6           # windows that are drawn together: neighbours may depend on each other
FRICTION = 0.1      # relative change of Cv that the gap must not follow
HEALTHY_TIME = 60.0  # s before a change
JUMP_TIME, RAMP_TIME = 600.0, 2400.0  # s after it
SLOW = 0.05 / 3600.0  # 1/s: 5 % in an hour


def true_gap(model: DriveModel) -> float:
    """Return the backlash (rad) of a `model` as benchmarks/README.md defines it."""
    shape = model.transmission
    return 2.0 * (shape.half_gap + (shape.hysteresis_width if shape.kind == 'play' else 0.0))


def half_gap_growth(model: DriveModel, growth: float) -> float:
    """Return the relative growth of half_gap for a `growth` of the backlash of `model`."""
    return growth * true_gap(model) / (2.0 * model.transmission.half_gap)


def measured(windows: Sequence[Features]) -> list[Backlash]:
    """Return those of `windows` that are a Backlash."""
    return [w for w in windows if isinstance(w, Backlash)]


def gaps(windows: Sequence[Features]) -> Array:
    """Return the gaps [N] of `windows`, rad."""
    return np.array([w.gap for w in measured(windows)])


def friction_shift(drive: SimulatedDrive, seconds: float, seed: int) -> float:
    """
    Return the largest relative shift of the mean backlash under +-10 % of Cv, same noise.

    Args:
        drive: simulated drive.
        seconds: length of each run.
        seed: of the noise.

    Returns:
        Largest shift over the mean.
    """
    means = []
    for factor in (1.0, 1.0 + FRICTION, 1.0 - FRICTION):
        run = watch(drive, seconds, seed, Faults(viscous_friction=factor), SMOOTHED, flags=False)
        means.append(gaps(run.windows)[1:].mean())  # the first one begins at rest
    return max(abs(m / means[0] - 1.0) for m in means[1:])


def minute_scatter(gaps: Array) -> float:
    """Return the standard deviation (rad) of means of `gaps` [N], one per PERIOD, over minutes."""
    minutes = len(gaps) // BLOCK
    return float(gaps[:minutes * BLOCK].reshape(minutes, BLOCK).mean(axis=1).std(ddof=1))


def learned_gaps(drive: SimulatedDrive, seconds: float, seed: int) -> Array:
    """
    Return the gap that a filter with the learned curve has every PERIOD [N], rad.

    Args:
        drive: simulated drive.
        seconds: length of the run.
        seed: of the noise.

    """
    plant = FaultyPlant(drive.model, drive.noise, seed)
    estimator = Estimator(drive.assumed, {**drive.parameters, 'tau_k_model': LEARNED})
    excitation, count, length = Excitation(), round(PERIOD / DT), round(seconds / PERIOD)
    play = drive.model.transmission.kind == 'play'
    gaps = np.empty(length)
    for i in range(length):
        k = np.arange(i * count, (i + 1) * count)
        run = plant.run(excitation.torque(k * DT), DT, i * PERIOD)
        u = np.column_stack([run.u, np.full(count, np.nan)])
        row = estimator.run(Samples(T0 + k * DT_NS, u, run.y)).rows[-1]
        gaps[i] = 2.0 * (row[E_HALF_GAP] + (abs(row[E_HYSTERESIS]) if play else 0.0))
    return gaps


def settings(drive: SimulatedDrive, interval: float | None = None) -> HealthSettings:
    """Return Settings for `drive`, by default or for one false alarm every `interval` s."""
    extra = {} if interval is None else {'false_alarm_interval': interval}
    return HealthSettings.of(
        EstimatorParameters.from_mapping({**drive.parameters, **SMOOTHED, **extra}),
        drive.assumed)


def drawn(windows: Sequence[Backlash], count: int, random: np.random.Generator,
          begin_ns: int = T0) -> list[Backlash]:
    """
    Draw windows in blocks with replacement, stamped PERIOD apart (block bootstrap).

    Args:
        windows: to draw from.
        count: how many.
        random: source of random numbers.
        begin_ns: stamp before the first, ns.

    Returns:
        The windows with their new stamps.
    """
    starts = random.integers(0, len(windows) - BLOCK + 1, -(-count // BLOCK))
    at = (starts[:, None] + np.arange(BLOCK)).ravel()[:count]
    return [replace(windows[i], stamp_ns=begin_ns + (k + 1) * round(PERIOD * 1e9))
            for k, i in enumerate(at)]


def trained(windows: Sequence[Features], goal: HealthSettings) -> Health:
    """Return the Health, judged by `goal`, that has learnt from healthy `windows`."""
    return folded(Health(goal), map(Window, windows))


def raised(outcomes: Mapping[str, Outcome]) -> bool:
    """Return whether `outcomes` hold a backlash alarm ("no data yet" is none)."""
    return outcomes['backlash'].level > Level.OK


def false_alarms(health: Health, windows: Sequence[Features]) -> int:
    """Return how often later `windows` raise an alarm of a gearbox with this `health`."""
    alarms = [False]
    for window in windows:
        health = judge(health, Window(window))
        alarms.append(any(x.level > Level.OK for x in judgement.outcomes(health).values()))
    return sum(current and not previous for previous, current in zip(alarms, alarms[1:]))


def later(windows: Sequence[Features], health: Health) -> list[Features]:
    """Return `windows` with stamps that follow those that `health` rests on."""
    shift_ns = health.stamp_ns + round(PERIOD * 1e9) - windows[0].stamp_ns
    return [replace(w, stamp_ns=w.stamp_ns + shift_ns) for w in windows]


def delays(drive: SimulatedDrive, learnt: Mapping[str, Health], growth: float,
           runs: int, seed: int, ramp: bool = False) -> dict[str, list[float | None]]:
    """
    Measure how soon a simulated change of the backlash is detected.

    The change begins at a random time within a window. A run in which an alarm comes before the
    change is drawn again.

    Args:
        drive: simulated drive.
        learnt: Health by name; each run continues from it.
        growth: relative jump, or relative growth per second of a ramp.
        runs: how many.
        seed: of the first run.
        ramp: whether the backlash grows steadily.

    Returns:
        {name: [delay (s) of each run, None: not detected]}.
    """
    delays_of: dict[str, list[float | None]] = {name: [] for name in learnt}
    random = np.random.default_rng(seed)
    relative = half_gap_growth(drive.model, growth)
    for run in range(runs):
        start = HEALTHY_TIME + random.uniform(0.0, PERIOD)
        faults = (Faults(gap_growth_rate=relative, gap_growth_start=start) if ramp else
                  Faults(start, gap=1.0 + relative))
        known = dict(learnt)
        hits: dict[str, float] = {}

        def stop(windows: Sequence[Features], known: dict[str, Health] = known,
                 hits: dict[str, float] = hits, start: float = start) -> bool:
            """Write when each of `known` detects the change of `start` in `windows` to `hits`."""
            for window in windows:
                since = (window.stamp_ns - T0) * 1e-9 - start
                for name in known.keys() - hits.keys():
                    shift_ns = round(learnt[name].stamp_ns - T0)
                    known[name] = judge(known[name], Window(
                        replace(window, stamp_ns=window.stamp_ns + shift_ns)))
                    if raised(judgement.outcomes(known[name])):
                        hits[name] = since
            return len(hits) == len(known)
        watch(drive, start + (RAMP_TIME if ramp else JUMP_TIME), seed + 1 + run, faults, SMOOTHED,
              flags=False, stop=stop)
        for name in known:
            if hits.get(name, 1.0) > 0.0:
                delays_of[name].append(hits.get(name))
    return delays_of
