# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a demo prints at its end, all from its bag: torque error, losses and alarms."""
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.library.recording_report import write_report
from gearbox_monitor.presentation import number
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import RecordedSamples
from gearbox_monitor.recordings.replay import replay
from gearbox_monitor.recordings.topics import DIAGNOSTICS, DRIFT_ALERTS

NS_PER_SECOND = 1e9
MAX_LOSS = 0.01  # of samples or estimates: a busy machine may miss the alarm
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


def evaluate(reader: BagReader, demo: Any) -> dict[str, Any]:
    """Replay the bag `reader` of `demo` (cli.demo.Demo), write its page; return {name: value}."""
    expected, joints, losses = round(demo.duration * demo.rate), dict[str, Any](), 0
    stamps: set[int] = set()
    for name in demo.gearboxes:
        result = replay(reader, topic=name or 'joint_states')
        stamps.update(result.recording.samples.stamp_ns.tolist())
        alarms, alerts, losses = diagnostics(
            reader, result.recording, f'estimator/{name}'.rstrip('/'))
        gap = 2.0 * result.estimator.model.transmission.half_gap
        grown = demo.growth_rate * (demo.duration - demo.growth_start) * (
            name == demo.gearboxes[0])
        joints[name] = {
            **(result.summary or {}), 'alarms': alarms, 'alerts': alerts,
            'true_gap_rad': [gap, gap * (1.0 + grown)],
            'backlash': result.monitor.outcomes['backlash'].message if result.monitor else ''}
    missing = expected - len(stamps), expected - 1 - reader.count('/transmission_state')
    pages = write_report(demo.bag, demo.out / 'report.html')
    return {
        'summary': pages.headline, 'page': str(pages.page), 'bag': str(demo.bag),
        'filter': demo.filter, 'duration_s': float(demo.duration), 'rate_hz': demo.rate,
        'samples': len(stamps), 'samples_expected': expected,
        'samples_missing': missing[0], 'estimates_missing': missing[1],
        'starved': max(missing) >= MAX_LOSS * expected,
        'recorder_losses': losses, 'joints': joints,
        'planted': list(demo.gearboxes[:demo.fault]), 'seen': [
            name for name, joint in joints.items()
            if any(alarm['component'] in COMPONENTS for alarm in joint['alarms'])],
        'notes': list(dict.fromkeys(n for joint in joints.values() for n in joint['notes']))}


def problems(data: Mapping[str, Any]) -> list[str]:
    """Return the failures in the `data` of a run; a machine that lost samples may miss alarms."""
    failures = []
    for name, joint in data['joints'].items():
        place = f'{name}: ' if name else ''
        if not joint['estimates']:
            failures.append(f'{place}there are no estimates')
        if joint.get('replay_identical') != 'yes':
            failures.append(f'{place}replay was not identical: ' + (
                joint.get('comparison', {}).get('first')
                or joint.get('replay_identical', 'not compared')))
        if name in data['planted'] and name not in data['seen'] and not data['starved']:
            failures.append(f'{place}the backlash grew without a backlash alarm')
        if name not in data['planted'] and (name in data['seen'] or joint['alerts']):
            failures.append(f'{place}alarm without a fault')
    return failures


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` in words."""
    joints = data['joints']
    identical, compared = (sum(joint.get('comparison', {}).get(key, 0)
                               for joint in joints.values()) for key in ('identical', 'compared'))
    verdicts = {joint.get('replay_identical', 'not compared') for joint in joints.values()}
    lines = [
        data['summary'], '',
        f'samples      {data["samples"]} of {data["samples_expected"]} at {data["rate_hz"]:g} Hz, '
        f'filter {data["filter"]}; dropped: {data["samples_missing"]} samples, '
        f'{data["estimates_missing"]} estimates, {data["recorder_losses"]} messages',
        f'replay       identical: {", ".join(sorted(verdicts - {"yes"})) or "yes"} ({identical} '
        f'of {compared} messages bit for bit)']
    for name, joint in joints.items():
        lines.append(f'{name or "gearbox":<12} {_seen(joint)}')
        lines += [f'             {alarm["t"]:.1f} s {alarm["component"]} {alarm["level"]}: '
                  f'{alarm["message"]}' for alarm in joint['alarms']]
    return '\n'.join([*lines, *(f'note         {note}' for note in data['notes']),
                      f'page         {data["page"]}',
                      f'next         gearbox_monitor replay {data["bag"]}'
                      + f' --topic {next(iter(joints))}' * (len(joints) > 1)])


def _seen(joint: Mapping[str, Any]) -> str:
    """Return what was seen of a `joint` in one line."""
    gaps, true = (np.multiply(joint[name], 1e3) for name in ('gap_rad', 'true_gap_rad'))
    words = (f'backlash {number(gaps[0])} to {number(gaps[-1], "mrad")} (true: {number(true[0])} '
             f'to {number(true[1])})' if len(gaps) else joint['backlash'])
    if joint.get('tau_k_error') is not None:
        words += (f'; tau_K error {joint["tau_k_error"]:.2f}, smoothed '
                  f'{joint["tau_k_error_smoothed"]:.2f}, of {joint["tau_k_rms"]:.2f} N m rms; '
                  f'NIS {joint["nis"]:.2f} ({joint["nis_expected"]:.3g} expected)')
    return words + ('' if joint['alarms'] else '; no alarm')
