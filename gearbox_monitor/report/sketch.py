# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A robot seen from its side: a line per link, a dot per joint, and its findings."""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
import itertools

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.report.svg import View
from gearbox_monitor.robot.chain import Chain

WIDTH, HEIGHT, MARGIN = 460.0, 300.0, 40.0
LINE, LETTER = 17.0, 8.8    # height of a line of text, and width of a bold letter on average


@dataclass(frozen=True)
class Dot:
    """
    A joint in the picture.

    name, lines: written next to it; role: hit, lost, held or calm, sets its colour; r: radius, px.
    needed: whether the text must be there, however full the picture is.
    """

    name: str
    lines: Sequence[str] = ()
    role: str = 'calm'
    r: float = 5.0
    needed: bool = True


@dataclass(frozen=True)
class Box:
    """A rectangle in the picture, px."""

    left: float
    top: float
    right: float
    bottom: float

    def inside(self) -> bool:
        """Return whether it is within the picture."""
        return (self.left >= 0.0 and self.right <= WIDTH and self.top >= 0.0
                and self.bottom <= HEIGHT)

    def hits(self, other: 'Box') -> bool:
        """Return whether it covers a part of an `other` one."""
        return (self.left < other.right and other.left < self.right and self.top < other.bottom
                and other.top < self.bottom)


def sketch(chain: Chain, posture: Array, dots: Mapping[str, Dot]) -> View:
    """
    Return the picture of a robot, which templates/sketch.html draws.

    Args:
        chain: the robot.
        posture: usual positions [J].
        dots: {joint: its dot}, the most important first; others are drawn without text.
    """
    _, places, _, _ = chain.poses(posture[None])
    xy = _seen(np.vstack([np.zeros(3), *(place[0] for place in places)]))
    at = {link.joint: xy[i + 1] for i, link in enumerate(chain.links)}
    taken = [Box(x - 7.0, y - 7.0, x + 7.0, y + 7.0) for x, y in xy]
    views = []
    for joint, dot in dots.items():
        x, y = map(float, at[joint])
        view = {'x': x, 'y': y, 'dot': dot, 'text': None}
        lines = [dot.name, *dot.lines]
        box = next((b for b in _places(x, y, lines, dot)
                    if b.inside() and not any(b.hits(t) for t in taken)), None)
        if box is not None:
            taken.append(box)
            left = box.right < x
            middle = 0.5 * (box.top + box.bottom)
            view['text'] = {'x': box.right if left else box.left, 'left': left, 'middle': middle,
                            'far': abs(middle - y) > LINE,
                            'lines': [(box.top + LINE * (k + 0.8), line)
                                      for k, line in enumerate(lines)]}
        views.append(view)
    top, bottom = min(b.top for b in taken) - 4.0, max(b.bottom for b in taken) + 4.0
    return {'width': WIDTH, 'top': top, 'height': bottom - top, 'dots': views, 'base': xy[0],
            'bones': [(*xy[link.parent + 1], *xy[i + 1]) for i, link in enumerate(chain.links)]}


def _seen(places: Array) -> Array:
    """Return `places` [N, 3] in px [N, 2], seen from the side from which they are widest."""
    flat = places - places.mean(axis=0)
    turned = np.arctan2(*np.linalg.svd(flat[:, :2], full_matrices=False)[2][0][::-1])
    across = flat[:, 0] * np.cos(turned) + flat[:, 1] * np.sin(turned)
    points = np.column_stack([across, -flat[:, 2]])
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    scale = float(min((WIDTH - 2 * MARGIN) / max(size[0], 1e-3),
                      (HEIGHT - 2 * MARGIN) / max(size[1], 1e-3), 600.0))
    out: Array = points * scale + np.array([WIDTH, HEIGHT]) / 2 - scale * (low + size / 2)
    return out


def _places(x: float, y: float, lines: Sequence[str], dot: Dot) -> Iterator[Box]:
    """Yield where the `lines` of a `dot` at (x, y) may be written, the best place first."""
    width, height = LETTER * max(map(len, lines)), LINE * len(lines)
    reach = HEIGHT if dot.needed else 2.0 * LINE
    shifts = sorted(np.arange(-reach, reach + 1.0, 0.25 * LINE).tolist(), key=abs)
    for shift, away in itertools.product(shifts, (dot.r + 8.0, dot.r + 40.0)):
        top = y + shift - 0.5 * height
        yield Box(x + away, top, x + away + width, top + height)
        yield Box(x - away - width, top, x - away, top + height)
