# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a demo prints at its end: torque error, losses and alarms."""
from collections.abc import Mapping
from typing import Any, TypeAlias

from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import RecordedSamples
from gearbox_monitor.recordings.replay import Replay, replay
from gearbox_monitor.recordings.topics import DIAGNOSTICS, DRIFT_ALERTS, PLANT_TRANSMISSION_STATE
from gearbox_monitor.report.plots import figure
from gearbox_monitor.report.recording_charts import overview, TrueTrajectory
from gearbox_monitor.report.timeline import RecordedAlert, State, timeline_of

NS_PER_SECOND = 1e9
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
        at = round((log_ns - first) / NS_PER_SECOND, 3)
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


LEVEL_WORDS = {'WARN': 'warning', 'ERROR': 'error'}


def evaluate(reader: BagReader, demo: Any) -> dict[str, Any]:
    """Replay the bag `reader` of `demo` (cli.demo.Demo), draw it; return {name: value}."""
    result = replay(reader)
    data = dict(result.summary or {})
    stamps = result.recording.samples.stamp_ns
    alarms, alerts, losses = diagnostics(reader, result.recording)
    expected = round(demo.duration * demo.rate)
    data.update(
        samples_expected=expected, samples_missing=expected - len(np.unique(stamps)),
        estimates_missing=expected - 1 - reader.count('/transmission_state'),
        recorder_losses=losses, alarms=alarms, alerts=alerts, fault=demo.fault,
        verdict=result.monitor.outcomes['backlash'].message if result.monitor else 'not known',
        duration_s=float(demo.duration), picture=str(demo.out / 'demo.png'))
    if result.monitor:
        picture(reader, result, result.monitor, data, demo).savefig(data['picture'], dpi=110)
    return data


def problems(data: Mapping[str, Any], fault: bool, starved: bool) -> list[str]:
    """
    Return the failures in the results of a run.

    Args:
        data: results of `evaluate`.
        fault: whether the backlash grew.
        starved: whether a busy machine lost samples at every rate; a missing alarm is then no
            failure.

    Returns:
        A sentence for each failure.

    """
    failures = []
    if not data['estimates']:
        failures.append('there are no estimates')
    if data.get('replay_identical') != 'yes':
        comparison = data.get('comparison', {})
        failures.append('replay was not identical: ' + (
            comparison.get('first') or data.get('replay_identical', 'not compared')))
    backlash = [alarm for alarm in data['alarms'] if alarm['component'] == 'backlash']
    if fault and not backlash and not starved:
        failures.append('the backlash grew without a backlash alarm')
    if not fault:
        # Samples dropped by a slow machine have a line of their own: no fault of the gearbox.
        dropped = data['samples_missing'] + data['estimates_missing'] > 0
        failures += [f'alarm without a fault: {alarm["component"]} {alarm["level"]}: '
                     f'{alarm["message"]}' for alarm in data['alarms'] + [
                         {'component': 'drift alert', **alert} for alert in data['alerts']]
                     if not (dropped and alarm['component'] == 'input')]
    return failures


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` in words."""
    comparison = data.get('comparison', {})
    lines = [
        f'samples      {data["samples"]} of {data["samples_expected"]} at '
        f'{data["rate_hz"]:.1f} Hz, filter {data["filter"]}; dropped: '
        f'{data["samples_missing"]} samples, '
        f'{data["estimates_missing"]} estimates, {data["recorder_losses"]} messages']
    if data.get('tau_k_error') is not None:
        lines.append(
            f'tau_K error  {data["tau_k_error"]:.3f} N m rms filtered, '
            f'{data["tau_k_error_smoothed"]:.3f} smoothed; tau_K itself {data["tau_k_rms"]:.3f}; '
            f'{100 * data["coverage_1_sigma"]:.0f} % within 1 sigma (68 % expected); '
            f'NIS {data["nis"]:.3f} (2 expected)')
    gaps = ', '.join(f'{gap:.3f}' for gap in data['gap_rad'])
    lines += [f'alarm        {alarm["t"]:.1f} s {alarm["component"]} {alarm["level"]}: '
              f'{alarm["message"]}' for alarm in data['alarms']
              if alarm['component'] != 'backlash']
    lines += [f'replay       identical: {data.get("replay_identical", "not compared")} '
              f'({comparison.get("identical", 0)} of {comparison.get("compared", 0)} messages bit '
              'for bit)', f'picture      {data["picture"]}']
    lines += [f'note         {note}' for note in data['notes']]
    worn = [alarm for alarm in data['alarms'] if alarm['component'] == 'backlash']
    return '\n'.join([
        *lines, f'backlash     {gaps} rad, window by window' if gaps else
        'backlash     not measured',
        f'verdict      {data["verdict"]}'
        + (f'; first alarm at {worn[0]["t"]:.1f} s' if worn else ''),
        f'next         gearbox_monitor report {data["bag"]}'])


# ---------------------------------------------------------------------- picture

def picture(reader: BagReader, result: Replay, monitor: Monitor, data: Mapping[str, Any],
            demo: Any) -> Figure:
    """
    Return the Figure of a replay, with the truth of the simulated drive.

    Args:
        reader: the bag.
        result: of its replay.
        monitor: at the end of the replay.
        data: results of `evaluate`.
        demo: options of the run, a cli.demo.Demo.

    """
    line = timeline_of(result.estimates, monitor.windows, monitor.outcomes['backlash'].values,
                       monitor.parameters)
    for alarm in data['alarms']:
        if alarm['component'] == 'backlash':
            line.alerts.append(RecordedAlert(
                alarm['t'], State(Level[alarm['level']], 'backlash', alarm['message'])))
    truth = None
    if '/' + PLANT_TRANSMISSION_STATE in reader.topics:
        states = reader.joint_states('/' + PLANT_TRANSMISSION_STATE, ('transmission',))
        t = np.linspace(0.0, demo.duration, 200)
        grown = 1.0 + demo.growth_rate * np.maximum(t - demo.growth_start, 0.0)
        truth = TrueTrajectory(
            line.seconds(states.stamp_ns), states.effort[:, 0], states.position[:, 0],
            (t, 2.0 * monitor.model.transmission.half_gap * grown))
    notes = []
    if data.get('tau_k_error') is not None:
        notes = [f'torque error {data["tau_k_error"]:.2f} N m rms filtered, '
                 f'{data["tau_k_error_smoothed"]:.2f} smoothed, of {data["tau_k_rms"]:.2f}',
                 f'NIS {data["nis"]:.2f} (2 expected)',
                 f'replay identical: {data.get("replay_identical", "not compared")}']
    return figure(overview(line, result.estimates, truth=truth), _title(monitor, data), notes)


def _title(monitor: Monitor, data: Mapping[str, Any]) -> str:
    """Return what the run says of the backlash, with its sizes."""
    gaps = [window.gap for window in monitor.windows]
    if not gaps:
        return 'Demo: no backlash was measured'
    alarms = [f'{LEVEL_WORDS[alarm["level"]]} at {alarm["t"]:.1f} s' for alarm in data['alarms']
              if alarm['component'] == 'backlash']
    if not alarms:
        return f'Demo: backlash {gaps[-1]:.3f} rad, no alarm'
    return f'Demo: backlash {gaps[0]:.3f} to {gaps[-1]:.3f} rad, {", ".join(alarms)}'
