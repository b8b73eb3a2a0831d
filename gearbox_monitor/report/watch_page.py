# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The page of a watch of a robot.

It shows the answer, the robot with what was found at its joints, states and changes, from the
data of watch_data and the description, live and offline alike.
"""
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.report.builder import Page, render_page, render_section, Section
from gearbox_monitor.report.chart import Chart, Dot, Lane, Panel, sketch, Trace, View
from gearbox_monitor.report.timeline import LEVELS
from gearbox_monitor.report.watch_words import (
    NO_CHANGE, NOT_JUDGED, problem_words, services_words, since_words, STATE_TITLES)
from gearbox_monitor.robot.chain import Chain, chain_of
from gearbox_monitor.robot.description import parse
from gearbox_monitor.watch.record import SECOND

WatchData = Mapping[str, Any]   # of watch_data
SOURCE = 'robot_description'
LEVEL_ROLES = {None: '', 0: 'good', 1: 'warn', 2: 'error'}
LANES, NOTES = 3, 3             # changes over time, sentences below the answer
NAMED, LONG = 12, 9             # joints up to which the sketch names each; letters of a long name
SHORTEST = 600.0                # s that the time line shows
UNITS = ((3 * 86400.0, 86400.0, 'd'), (3 * 3600.0, 3600.0, 'h'), (0.0, 60.0, 'min'))


def watch_page(data: WatchData, description: str, title: str) -> str:
    """
    Return the page of a watch as HTML, one file that loads nothing.

    Args:
        data: of watch_data.
        description: URDF of the robot.
        title: of the page.
    """
    return render_page(Page(title, _whole(data, description, 'watch', ''), ()))


def watch_part(data: WatchData, description: str, node: str, problem: str = '') -> str:
    """
    Return the same as a part of the live page.

    Args:
        data: of watch_data; empty before any came.
        description: URDF of the robot.
        node: name of the node that watches.
        problem: of its stream, in words; what is shown is old then.
    """
    return render_section(_whole(data, description, node, problem), 'rotary')


def _whole(data: WatchData, description: str, node: str, problem: str) -> Section:
    """Return the answer in words, then sketch, table and time line."""
    if problem or not data:
        kind, headline = 'warn', problem_words(problem)
    else:
        kind, headline = LEVEL_ROLES[data['level']], data['summary']
    whole = {'kind': kind, 'headline': headline, 'notes': (), 'rows': (), 'old': bool(problem)}
    if not data:
        return Section('watch.html', whole)
    held = [p['words'] for p in data['payloads'] if p['label']]
    notes = [f'{words}.' for words in (*held, *data['readings'], *data['warnings'])][:NOTES]
    return Section('watch.html', {
        **whole, 'notes': notes, 'sketch': _sketch(data, description),
        'titles': STATE_TITLES.values(), 'rows': [_row(data, name) for name in data['joints']],
        'long': max(map(len, data['joints']), default=0) > LONG, 'changes': _over_time(data),
        'no_change': NO_CHANGE, 'services': services_words(node)})


# --- sketch -------------------------------------------------------------------------------------
def _sketch(data: WatchData, description: str) -> View | None:
    """Return the robot with what was found at its joints; None: there is no description."""
    try:
        chain = chain_of(parse(description, SOURCE))
    except InputError:
        return None
    posture = np.array([(data['joints'].get(link.joint) or {}).get('position') or 0.0
                        for link in chain.links])
    marks = _marks(data, chain)
    names = sorted((link.joint for link in chain.links), key=lambda name: name not in marks)
    return sketch(chain, posture, {
        name: marks.get(name) or Dot(name, needed=False)
        for name in (names if len(names) <= NAMED else marks)})


def _marks(data: WatchData, chain: Chain) -> dict[str, Dot]:
    """Return {joint: its dot} of those at which something is found or held."""
    joint_of = {link.name: link.joint for link in chain.links}
    out = dict[str, Dot]()
    for found in data['findings']:
        joint = found['joint'] or chain.links[0].joint      # the base carries the first one
        before = out.get(joint, Dot(joint, role='hit', r=8.0))
        out[joint] = replace(before, lines=(*before.lines, found['label']))
    for load in data['payloads']:
        joint = joint_of.get(load['link'], '')
        if joint and load['label']:
            before = out.get(joint, Dot(joint, role='held', r=8.0))
            out[joint] = replace(before, lines=(*before.lines, load['label']))
    return out


# --- table --------------------------------------------------------------------------------------
def _row(data: WatchData, name: str) -> dict[str, Any]:
    """Return the row of the joint `name`: level, states in words, what is found, or why not."""
    joint = data['joints'][name]
    found = [f for f in data['findings'] if f['joint'] == name]
    bad = {f['state']: f['share'] for f in found}
    states = {kind: state['words'] for kind, state in joint['states'].items() if state['judged']}
    states |= bad
    cells = [('warn' if kind in bad else '', states.get(kind, '-').removesuffix(' %'))
             for kind in STATE_TITLES]
    level = joint['level']
    return {
        'name': name, 'level': '' if level is None else LEVELS[level], 'kind': LEVEL_ROLES[level],
        'cells': cells, 'found': '; '.join(
            since_words(f['label'], f['since_ns']) for f in found),
        'why': f'{NOT_JUDGED}: {joint["words"]}' if level is None else ''}


# --- changes over time --------------------------------------------------------------------------
def _over_time(data: WatchData) -> Chart | None:
    """Return what changed over time, as lanes, and what was held, as curves; None: nothing."""
    now, changes = data['stamp_ns'], data['changes'][-LANES:]
    loads = [*data['earlier'], *data['payloads']]
    links = [link for link in dict.fromkeys(p['link'] for p in loads)
             if any(p['label'] for p in loads if p['link'] == link)]
    if not changes and not links:
        return None
    begins = [c['since_ns'] for c in (*changes, *(p for p in loads if p['link'] in links))]
    span = max((now - min(begins)) / SECOND * 1.05, SHORTEST)
    _, unit, name = next(u for u in UNITS if span >= u[0])

    def before(stamp_ns: int) -> float:
        """Return the time of a stamp before the newest block."""
        return (stamp_ns - now) / SECOND / unit
    panels: list[Panel | Lane] = [Lane(
        f'{c["joint"] or c["link"]}: {c["label"]}',
        [-span / unit, before(c['since_ns']), *([before(c['over_ns'])] if c['over_ns'] else [])],
        0.0, [0, 1, 0][:3 if c['over_ns'] else 2], [c['words']] * 3) for c in changes]
    for link in links:
        own = [p for p in loads if p['link'] == link]
        edges = np.array([*(before(p['since_ns']) for p in own), 0.0])
        mass, std = (np.array([*(p[key] for p in own), own[-1][key]]) for key in ('m', 'm_std'))
        panels.append(Panel(f'{link} (kg)', [_held(edges, mass, std)], 0.0, 56))
    return Chart('Changes', panels, f'time before the newest block ({name})',
                 span=(-span / unit, 0.0), zoom=False)


def _held(edges: Array, mass: Array, std: Array) -> Trace:
    """Return a curve that keeps each mass until the next edge, with two deviations."""
    return Trace(np.repeat(edges, 2)[1:], np.repeat(mass, 2)[:-1], '', 'closed').around(
        np.repeat(std, 2)[:-1])
