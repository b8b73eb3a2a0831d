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

"""Backlash and its drift in simulated running: how well the gap is measured, growth found when."""
import copy
from dataclasses import replace

import numpy as np

from gearbox_monitor.benchmarks.trust_runs import T0, watch
from gearbox_monitor.monitoring.backlash import change
from gearbox_monitor.monitoring.backlash.features import Backlash
from gearbox_monitor.monitoring.checks.level import Level
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.faults import Faults

SMOOTHED = {'smoother_lag': 0.1}
PERIOD = 10.0       # s of a drift window
DAY = 86400.0       # s between two false alarms, of the faster setting
BLOCK = 6           # windows that are drawn together: neighbours may depend on each other
FRICTION = 0.1      # relative change of Cv that the gap must not follow
HEALTHY_TIME = 60.0  # s before a change
JUMP_TIME, RAMP_TIME = 600.0, 2400.0  # s after it
SLOW = 0.05 / 3600.0  # 1/s: 5 % in an hour


def true_gap(model):
    """Return the width of the gap (rad) of a DriveModel as docs/trust_benchmark.md defines it."""
    shape = model.transmission
    return 2.0 * (shape.half_gap + (shape.hysteresis_width if shape.kind == 'play' else 0.0))


def half_gap_growth(model, growth):
    """Return the relative growth of half_gap that lets the gap grow by `growth`."""
    return growth * true_gap(model) / (2.0 * model.transmission.half_gap)


def measured(windows):
    """Return those of `windows` that are a Backlash."""
    return [w for w in windows if isinstance(w, Backlash)]


def gaps(windows):
    """Return the gaps [N] of `windows`, rad."""
    return np.array([w.gap for w in measured(windows)])


def friction_shift(drive, seconds, seed, progress):
    """Return the largest relative shift of the mean gap under +-10 % of Cv, same noise."""
    means = []
    for factor in (1.0, 1.0 + FRICTION, 1.0 - FRICTION):
        run = watch(drive, seconds, seed, Faults(viscous_friction=factor), SMOOTHED, flags=False,
                    progress=progress)
        means.append(gaps(run.windows)[1:].mean())  # the first one begins at rest
    return max(abs(m / means[0] - 1.0) for m in means[1:])


def settings(drive, interval=None):
    """Return change.Settings: as delivered, or with a false alarm every `interval` s."""
    extra = {} if interval is None else {'false_alarm_interval': interval}
    return change.Settings.of(
        EstimatorParameters.from_mapping({**drive.parameters, **SMOOTHED, **extra}),
        drive.assumed)


def drawn(windows, count, random, begin_ns=T0):
    """Return `count` of `windows`, drawn in blocks with replacement, stamped PERIOD apart."""
    starts = random.integers(0, len(windows) - BLOCK + 1, -(-count // BLOCK))
    at = (starts[:, None] + np.arange(BLOCK)).ravel()[:count]
    return [replace(windows[i], stamp_ns=begin_ns + (k + 1) * round(PERIOD * 1e9))
            for k, i in enumerate(at)]


def trained(windows, goal):
    """Return a Tracker that has learnt its baseline from healthy `windows`."""
    tracker = change.Tracker(goal)
    for window in windows:
        tracker.update(window)
    return tracker


def raised(findings):
    """Return whether a backlash alarm is in force ("no data yet" is none)."""
    return findings['backlash'].level > Level.OK


def false_alarms(tracker, windows):
    """Return how often the alarm of a `tracker` was raised by `windows`, which come after."""
    said = [False] + [any(f.level > Level.OK for f in tracker.update(w).values())
                      for w in windows]
    return sum(now and not before for before, now in zip(said, said[1:]))


def later(windows, tracker):
    """Return `windows` with stamps that follow what `tracker` has seen."""
    ahead = tracker.stamp_ns + round(PERIOD * 1e9) - windows[0].stamp_ns
    return [replace(w, stamp_ns=w.stamp_ns + ahead) for w in windows]


def delays(drive, trackers, growth, runs, seed, progress, ramp=False):
    """
    Return {tracker: [delay (s) per run, None = not found]} of a simulated change of the gap.

    A jump by `growth`, or a ramp with `growth` per second, at a random time within a window.
    trackers {name: trained Tracker}; each run continues with copies of them. An alarm from before
    the change is none of its findings: such a run is drawn anew.
    """
    found = {name: [] for name in trackers}
    random = np.random.default_rng(seed)
    relative = half_gap_growth(drive.model, growth)
    for run in range(runs):
        start = HEALTHY_TIME + random.uniform(0.0, PERIOD)
        due = (Faults(gap_growth_rate=relative, gap_growth_start=start) if ramp else
               Faults(start, gap=1.0 + relative))
        asked = {name: copy.deepcopy(tracker) for name, tracker in trackers.items()}
        hits = {}

        def stop(windows, asked=asked, hits=hits, start=start):
            for window in windows:
                since = (window.stamp_ns - T0) * 1e-9 - start
                for name in asked.keys() - hits.keys():
                    ahead = round(trackers[name].stamp_ns - T0)
                    said = asked[name].update(replace(window, stamp_ns=window.stamp_ns + ahead))
                    if raised(said):
                        hits[name] = since
            return len(hits) == len(asked)
        watch(drive, start + (RAMP_TIME if ramp else JUMP_TIME), seed + 1 + run, due, SMOOTHED,
              flags=False, stop=stop)
        for name in asked:
            if hits.get(name, 1.0) > 0.0:
                found[name].append(hits.get(name))
        progress()
    return found


def fresh(tracker):
    """Return a copy of `tracker`."""
    return copy.deepcopy(tracker)
