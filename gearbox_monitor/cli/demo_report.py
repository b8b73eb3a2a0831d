# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a demo prints at its end, all from its bag: torque error, losses and alarms."""
from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbox_monitor.library.recording_report import write_report
from gearbox_monitor.presentation import number
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.replay import replay

MAX_LOSS = 0.01  # of samples or estimates: a busy machine may miss the alarm
SLOW = 'This machine was too busy and dropped samples or estimates: an alarm may be missing.'


def evaluate(reader: BagReader, demo: Any) -> dict[str, Any]:
    """Replay the bag `reader` of `demo` (cli.demo.Demo), write its page; return {name: value}."""
    expected, joints = round(demo.duration * demo.rate), dict[str, Any]()
    stamps: set[int] = set()
    pages = write_report(demo.bag, demo.out / 'report.html')
    for name in demo.gearboxes:
        result = replay(reader, topic=name or 'joint_states')
        stamps.update(result.recording.samples.stamp_ns.tolist())
        gap = 2.0 * result.estimator.model.transmission.half_gap
        grown = demo.growth_rate * (demo.duration - demo.growth_start) * (
            name == demo.gearboxes[0])
        joints[name] = {
            **(result.summary or {}), 'true_gap_rad': [gap, gap * (1.0 + grown)],
            'alarms': pages.figures.get('joints', {name: pages.figures})[name]['alerts'],
            'backlash': result.monitor.outcomes['backlash'].message if result.monitor else ''}
    missing = expected - len(stamps), expected - 1 - reader.count('/transmission_state')
    return {
        'summary': pages.headline, 'page': str(pages.page), 'bag': str(demo.bag),
        'filter': demo.filter, 'duration_s': float(demo.duration), 'rate_hz': demo.rate,
        'samples': len(stamps), 'samples_expected': expected,
        'samples_missing': missing[0], 'estimates_missing': missing[1],
        'starved': max(missing) >= MAX_LOSS * expected, 'joints': joints,
        'planted': list(demo.gearboxes[:demo.fault]),
        'seen': [name for name, joint in joints.items() if joint['alarms']],
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
        if name in data['seen'] and name not in data['planted']:
            failures.append(f'{place}alarm without a fault')
    return failures


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` in words."""
    joints = data['joints']
    identical, compared = (sum(joint.get('comparison', {}).get(key, 0)
                               for joint in joints.values()) for key in ('identical', 'compared'))
    verdicts = {joint.get('replay_identical', 'not compared') for joint in joints.values()}
    lines = [
        data['summary'], *([SLOW] if data['starved'] else []), '',
        f'samples      {data["samples"]} of {data["samples_expected"]} at {data["rate_hz"]:g} Hz, '
        f'filter {data["filter"]}; dropped: {data["samples_missing"]} samples, '
        f'{data["estimates_missing"]} estimates',
        f'replay       identical: {", ".join(sorted(verdicts - {"yes"})) or "yes"} ({identical} '
        'messages bit for bit' + f'; {compared - identical} follow a loss' * (
            identical < compared) + ')']
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
        error, late, size = (number(joint[f'tau_k_{name}']) for name in (
            'error', 'error_smoothed', 'rms'))
        words += (f'; tau_K error {error}, smoothed {late}, of {size} N m rms; NIS '
                  f'{joint["nis"]:.2f} ({joint["nis_expected"]:.3g} expected)')
    return words + ('' if joint['alarms'] else '; no alarm')
