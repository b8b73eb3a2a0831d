# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one judgement of wear: Health and a window in, Health and events out.

The live node folds its windows with `judge`; replay, report, accept and fleet fold the windows
of recordings. A state file and a baseline are a Health as `to_data` writes it.
"""
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

from gearbox_monitor.health.backlash.change import Tracker
from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.health_record import Health, HealthSettings, Window
from gearbox_monitor.health.slip import found_in, Slip, Zero
from gearbox_monitor.kernels.types import Values

KEPT = ('cause', 'recordings', 'earlier', 'slips', 'zeros')  # unchanged by a window
RECORDINGS, SLIPS = 1000, 100  # that are kept


@dataclass(frozen=True)
class Event:
    """The alerts of a `component` have changed to `stages` {test: stage}: raised, worse, over."""

    component: str
    stages: Mapping[str, int]


def judge(health: Health, window: Window) -> tuple[Health, tuple[Event, ...]]:
    """
    Return the Health after one more window, and the alerts that changed with it.

    Args:
        health: before the window; it stays unchanged.
        window: the newest window; one that was judged before changes nothing.
    """
    judged = _following(health, _tracker(health).update(window))
    if isinstance(window.features, Backlash) and window.stamp_ns != health.stamp_ns:
        zeros, slip = found_in(health.zeros if window.counts_on else (), window.features,
                               health.settings.motor_turn)
        judged = replace(judged, zeros=zeros, slips=(
            *judged.slips, slip)[-SLIPS:] if slip else judged.slips)
    if not judged.alerts:
        judged = replace(judged, cause='')
    return judged, events(health, judged)


def events(previous: Health, present: Health) -> tuple[Event, ...]:
    """Return the Events that lead from the `previous` Health to the `present` one."""
    old, new = previous.stages(), present.stages()
    return tuple(Event(component, new[component]) for component in COMPONENTS
                 if new[component] != old[component])


def folded(health: Health, windows: Iterable[Window], recording: str = '') -> Health:
    """Return the Health after all `windows`, in order of time, of the `recording` so called."""
    health = replace(health, earlier=health.earlier or health.baseline_ns > 0)
    after = reduce(lambda known, window: judge(known, window)[0], windows, health)
    names = (*after.recordings, recording)[-RECORDINGS:] if recording else after.recordings
    return replace(after, recordings=names)


def accepted(health: Health) -> tuple[Health, int]:
    """
    Return `health` with the present state as the healthy one, and its number of windows.

    The wear becomes 0 with its deviation, at all operating points; all alerts end.
    """
    tracker, windows = _tracker(health).accept()
    return replace(_following(health, tracker), cause='', earlier=True, slips=()), windows


def serviced(health: Health, stamp_ns: int, note: str) -> Health:
    """
    Return `health` after a service: the next windows are a new baseline.

    Args:
        health: before it.
        stamp_ns: of the service.
        note: on the service, or ''.

    """
    return replace(_following(health, _tracker(health).served(stamp_ns, note)), cause='', slips=())


def under(health: Health, settings: HealthSettings) -> Health:
    """Return `health` as it is judged by other `settings` from now on."""
    return _following(health, _tracker(health).under(settings))


def _tracker(health: Health) -> Tracker:
    return health.tracker or Tracker.of(health.settings)


def _following(health: Health, tracker: Tracker) -> Health:
    return replace(tracker.health(), **{name: getattr(health, name) for name in KEPT})


def to_data(health: Health) -> dict[str, Any]:
    """Return all of `health` that no settings give, as plain data; floats read back exactly."""
    return {'statistics': health.statistics,
            **{name: getattr(health, name) for name in KEPT}}


def from_data(settings: HealthSettings, data: Values | None) -> Health:
    """
    Return the Health that to_data gave; None: nothing is known yet.

    Args:
        settings: for the next judgements.
        data: of to_data.

    Raises:
        KeyError, TypeError, ValueError: `data` are none.
    """
    if data is None:
        return Health(settings)
    health = Health(settings)
    if data['statistics']:  # none before the first window
        health = Tracker.of(settings, data['statistics']).health()
    return replace(health, cause=str(data['cause']), earlier=bool(data['earlier']),
                   recordings=tuple(map(str, data['recordings'])),
                   slips=tuple(Slip(int(s), *map(float, row)) for s, *row in data['slips']),
                   zeros=tuple(Zero(int(s), *map(float, row)) for s, *row in data['zeros']))
