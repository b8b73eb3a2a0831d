# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Results of a demo run of an arm, joint by joint, all from its bag."""
from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbox_monitor.cli.demo_report import diagnostics
from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.replay import replay


def evaluate(reader: BagReader, demo: Any) -> dict[str, Any]:
    """Replay the bag `reader` of `demo` (cli.demo.RobotDemo); return {name: value}."""
    expected, joints, losses = round(demo.duration * demo.rate), {}, 0
    stamps: set[int] = set()
    for name in demo.gearboxes:
        result = replay(reader, topic=name)
        stamps.update(result.recording.samples.stamp_ns.tolist())
        alarms, alerts, losses = diagnostics(reader, result.recording, f'estimator/{name}')
        gap = 2.0 * demo.drives[name].transmission.half_gap
        grown = demo.growth_rate * (demo.duration - demo.growth_start) * (name == demo.faulty)
        joints[name] = {
            **(result.summary or {}), 'alarms': alarms, 'alerts': alerts,
            'true_gap_rad': [gap, gap * (1.0 + grown)],
            'backlash': result.monitor.outcomes['backlash'].message if result.monitor else ''}
    return {
        'bag': str(demo.bag), 'parameters': str(demo.parameter_file), 'filter': demo.filter,
        'duration_s': float(demo.duration), 'rate_hz': demo.rate, 'samples': len(stamps),
        'samples_expected': expected, 'samples_missing': expected - len(stamps),
        'estimates_missing': expected - 1 - reader.count('/transmission_state'),
        'recorder_losses': losses, 'joints': joints, 'planted': demo.faulty * demo.fault,
        'seen': [name for name, joint in joints.items() if _worn(joint)], 'notes': list(
            dict.fromkeys(note for joint in joints.values() for note in joint['notes']))}


def _worn(joint: Mapping[str, Any]) -> bool:
    """Return whether backlash or friction of a `joint` raised an alarm."""
    return any(alarm['component'] in COMPONENTS for alarm in joint['alarms'])


def problems(data: Mapping[str, Any], fault: bool, starved: bool) -> list[str]:
    """
    Return the failures in the results of a run.

    Args:
        data: results of `evaluate`.
        fault: whether the backlash of a joint grew.
        starved: whether a busy machine lost samples at every rate; a missing alarm is then no
            failure.

    Returns:
        A sentence for each failure.

    """
    failures = []
    for name, joint in data['joints'].items():
        if not joint['estimates']:
            failures.append(f'{name}: there are no estimates')
        if joint.get('replay_identical') != 'yes':
            failures.append(f'{name}: replay was not identical: ' + (
                joint.get('comparison', {}).get('first')
                or joint.get('replay_identical', 'not compared')))
        if name in data['seen'] and name != data['planted']:
            failures.append(f'{name}: alarm without a fault')
    if fault and data['planted'] not in data['seen'] and not starved:
        failures.append(f'the backlash of {data["planted"]} grew without a backlash alarm')
    return failures


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` in words."""
    joints = data['joints']
    identical, compared = (sum(joint.get('comparison', {}).get(key, 0)
                               for joint in joints.values()) for key in ('identical', 'compared'))
    lines = [
        f'samples      {data["samples"]} of {data["samples_expected"]} recorded at '
        f'{data["rate_hz"]:g} Hz, {len(joints)} gearboxes, filter {data["filter"]}',
        f'dropped      {data["samples_missing"]} samples, {data["estimates_missing"]} estimates '
        f'(by their stamps); the recorder lost {data["recorder_losses"]} messages']
    for name, joint in joints.items():
        lines.append(f'{name:<12} {_seen(joint)}')
        lines += [f'             {alarm["t"]:.1f} s {alarm["component"]} {alarm["level"]}: '
                  f'{alarm["message"]}' for alarm in joint['alarms']]
    return '\n'.join([
        *lines,
        'fault        ' + (f'planted in {data["planted"]}' if data['planted'] else 'none planted')
        + f', seen in {", ".join(data["seen"]) or "none"}',
        f'bag          {data["bag"]}',
        f'replay       identical: {_verdict(joints)} ({identical} of {compared} messages bit for '
        'bit)',
        f'next         gearbox_monitor report {data["bag"]}',
        f'             gearbox_monitor replay {data["bag"]} --topic '
        f'{data["planted"] or next(iter(joints))}',
        *(f'note         {note}' for note in data['notes'])])


def _seen(joint: Mapping[str, Any]) -> str:
    """Return what was seen of a `joint` in one line."""
    gaps = np.multiply(joint['gap_rad'], 1e3)
    true = np.multiply(joint['true_gap_rad'], 1e3)
    words = (f'gap {gaps[0]:.2f} to {gaps[-1]:.2f} mrad (true: {true[0]:.2f} to {true[1]:.2f})'
             if len(gaps) else joint['backlash'])
    if joint.get('tau_k_error') is not None:
        words += f', tau_K error {joint["tau_k_error"]:.2f} of {joint["tau_k_rms"]:.1f} N m rms'
    return words + ('' if joint['alarms'] else ', no alarm')


def _verdict(joints: Mapping[str, Mapping[str, Any]]) -> str:
    """Return 'yes' if the replay of all `joints` was identical, else what it was of the others."""
    verdicts = {joint.get('replay_identical', 'not compared') for joint in joints.values()}
    return ', '.join(sorted(verdicts - {'yes'})) or 'yes'
