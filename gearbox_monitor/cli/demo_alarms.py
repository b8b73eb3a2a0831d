# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Alarms and alerts in the recording of a demo."""
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import RecordedSamples
from gearbox_monitor.recordings.topics import DIAGNOSTICS, DRIFT_ALERTS

SECOND = 1e9
Alarms: TypeAlias = list[dict[str, Any]]


def diagnostics(reader: BagReader, recording: RecordedSamples, estimator: str = 'estimator'
                ) -> tuple[Alarms, Alarms, int]:
    """
    Return (alarms, alerts, messages that the recorder lost) of a recording.

    An alarm is a change of a component of the estimator to a worse level while samples come,
    after it was OK for the first time.

    Args:
        reader: the bag.
        recording: its samples.
        estimator: as its diagnostics call it, NODE or NODE/GEARBOX.

    """
    stamps, last = recording.samples.stamp_ns, recording.log_ns.max(initial=0)
    # After the first sample the plant may have waited for its subscribers.
    first = last - (np.ptp(stamps) if len(stamps) else 0)
    alarms: Alarms = []
    alerts: Alarms = []
    losses = 0
    levels: dict[str, Level] = {}
    for topic, log_ns, _, raw in reader.messages([DIAGNOSTICS, '/' + DRIFT_ALERTS]):
        at = round((log_ns - first) / SECOND, 3)
        for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
            node, _, component = status.name.partition(': ')
            level = Level(min(int(status.level), Level.ERROR))
            if topic != DIAGNOSTICS:
                if node != estimator:
                    continue
                alerts.append({'t': at, 'level': level.name, 'message': status.message})
            elif node == 'recorder':
                losses = max(losses, *(int(v.value) for v in status.values
                                       if v.key in ('lost', 'not_written')))
            elif node == estimator and log_ns <= last:
                previous = levels.get(component)
                if previous is None and level != Level.OK:
                    continue  # not evaluated yet
                if previous is not None and level > previous:
                    alarms.append({'t': at, 'component': component, 'level': level.name,
                                   'message': status.message})
                levels[component] = level
    return alarms, alerts, losses
