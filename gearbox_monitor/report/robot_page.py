# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The joints of a robot side by side: torque, backlash and trust in one row each, worst first."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.health.backlash.forecast import when
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.report.builder import Page, render_page, Section
from gearbox_monitor.report.live_history import GearboxHistory, is_wear, MOTION_ROWS
from gearbox_monitor.report.recording_page import headline, next_steps, ROLES, trusted_share, wear
from gearbox_monitor.report.shared_sections import advice, page_summary
from gearbox_monitor.report.timeline import LEVELS, Timeline, WindowBacklash
from gearbox_monitor.report.timeline_source import RecordingFacts
from gearbox_monitor.report.words import width_and_std

WIDTH, HEIGHT, MARGIN = 120.0, 24.0, 2.0  # of a sparkline


@dataclass(frozen=True)
class JointRow:
    """
    A joint in the table.

    kind: of ROLES, '' where nothing can be said; message: why; torque: lowest and highest (N m);
    windows: measurements of its backlash; trusted: share of the time, None: not evaluated; link:
    its page; worn: whether the message is about wear.
    """

    name: str
    kind: str
    message: str
    torque: tuple[float, float]
    windows: Sequence[WindowBacklash]
    trusted: float | None
    link: str = ''
    worn: bool = False

    @property
    def level(self) -> int:
        """Number of the level, -1 where nothing can be said."""
        return ROLES.index(self.kind) if self.kind else -1

    @property
    def level_text(self) -> str:
        """The level in words; of a joint with a kind."""
        return LEVELS[self.level]

    @property
    def torque_text(self) -> str:
        """The span of the torque."""
        low, high = self.torque
        return f'{low:.3g} to {high:.3g}' if math.isfinite(low + high) else 'none'

    @property
    def gap_text(self) -> str:
        """The newest backlash; lost motion where backlash is not distinguished from it."""
        if not self.windows:
            return 'not measured'
        newest = self.windows[-1]
        if not newest.separable:
            return f'{newest.lost_motion:.4g} (lost motion)'
        return width_and_std(newest.gap, newest.gap_std, '')

    @property
    def trusted_text(self) -> str:
        """The share of trust."""
        return 'not evaluated' if self.trusted is None else f'{100 * self.trusted:.0f} %'

    @property
    def sparkline(self) -> str:
        """The path of the backlash over time, '' for fewer than two windows."""
        separable = bool(self.windows) and self.windows[-1].separable
        points = np.array([(w.t, w.gap if separable else w.lost_motion) for w in self.windows])
        points = points[np.isfinite(points).all(axis=1)] if len(points) else points
        return _path(*points.T) if len(points) > 1 else ''


def _path(t: Array, value: Array) -> str:
    """Return an SVG path of `value` [N] over `t` [N], the lowest value at the bottom."""
    x = MARGIN + (WIDTH - 2 * MARGIN) * (t - t[0]) / max(float(t[-1] - t[0]), 1e-12)
    span = float(np.ptp(value))
    share = (value - value.min()) / span if span > 0.0 else np.full(len(value), 0.5)
    y = HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * share
    return 'M' + 'L'.join(f'{a:.1f},{b:.1f}' for a, b in zip(x, y))


def worst_rows(rows: Iterable[JointRow]) -> list[JointRow]:
    """Return `rows`, worst first; of the same level, wear comes before a lack of trust."""
    return sorted(rows, key=lambda row: (
        -row.level, not row.worn, 1.0 if row.trusted is None else row.trusted))


def joint_table(rows: Sequence[JointRow]) -> Section:
    """Return the table of all joints with their `rows`, empty for a single one."""
    return Section('robot/joints.html', {'rows': rows if len(rows) > 1 else ()}, 'Joints')


def live_row(gearbox: GearboxHistory, name: str) -> JointRow:
    """Return the row of a `gearbox` that the live page calls `name`."""
    level, component, message = gearbox.worst()
    kind = ROLES[level] if gearbox.levels else ''
    tau_k = gearbox.motion(MOTION_ROWS).tau_k
    tau_k = tau_k[np.isfinite(tau_k)]
    span = (float(tau_k.min()), float(tau_k.max())) if len(tau_k) else (math.nan, math.nan)
    return JointRow(name, kind, f'{component}: {message.split("; ")[0]}' if level else '', span,
                    list(gearbox.windows), trusted_share(gearbox.levels),
                    worn=is_wear(component, message))


def recorded_row(timeline: Timeline, name: str, link: str) -> JointRow:
    """
    Return the row of a joint in a recording.

    Args:
        timeline: what the recording showed of it.
        name: of the gearbox.
        link: to its page.

    """
    words, kind = headline(timeline)
    low, high, _ = timeline.torque.of(0)
    span = (float(np.nanmin(low)), float(np.nanmax(high))) if np.isfinite(low).any() else (
        math.nan, math.nan)
    return JointRow(name, kind, words, span, timeline.windows, trusted_share(timeline.spans),
                    link, bool(wear(timeline)))


def _summary(joints: Mapping[str, tuple[Timeline, RecordingFacts]], rows: Sequence[JointRow]
             ) -> Section:
    """Return the summary of `joints`, whose `rows` begin with the worst."""
    highest, raised = rows[0], sum(row.level > 0 for row in rows)
    text = 'Nothing is raised.' if highest.kind else highest.message
    if raised:
        text = f'{highest.name}: {highest.message}' + f' ({raised - 1} more)' * (raised > 1)
    timelines = [timeline for timeline, _ in joints.values()]
    return page_summary(
        highest.kind, text,
        [('from', when(timelines[0].first_ns or 0)),
         ('duration', f'{max(t.last for t in timelines):.4g} s'), ('joints', str(len(joints))),
         ('alerts', str(sum(len(t.alerts) for t in timelines)))],
        list(dict.fromkeys(note for _, facts in joints.values() for note in facts.notes)))


class RobotPage(NamedTuple):
    """A page and its first sentence."""

    html: str
    headline: str


def robot_page(joints: Mapping[str, tuple[Timeline, RecordingFacts]], links: Mapping[str, str],
               name: str, bags: Mapping[str, str]) -> RobotPage:
    """
    Return the page of a recording of several gearboxes.

    Args:
        joints: {gearbox: what the recording showed, what stands beside it}.
        links: {gearbox: its own page, relative}.
        name: of the recording.
        bags: {gearbox: how a command names its recording}.

    Returns:
        One file that loads nothing and links to the pages of the joints, and its headline.

    """
    rows = worst_rows(recorded_row(timeline, joint, links[joint])
                      for joint, (timeline, _) in joints.items())
    summary, highest = _summary(joints, rows), rows[0].name
    timeline, facts = joints[highest]
    steps = advice([f'{highest}: {step}' for step in next_steps(timeline, bags[highest])])
    return RobotPage(render_page(Page(f'Robot {name}', summary, (steps, joint_table(rows)),
                                      facts.model.axis)), summary.data['headline'])
