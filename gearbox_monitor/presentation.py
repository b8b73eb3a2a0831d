# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Results that show themselves, as a line, table, picture or page; the names of their units.

What they show is made in `library.views`, which knows words, pictures and pages. It is imported
when a result is first shown: the core computes and draws nothing.
"""
from importlib import import_module
import math
from pathlib import Path
import re
from typing import Any, NamedTuple, TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    import pandas as pd


def _views() -> Any:
    return import_module('gearbox_monitor.library.views')


class Shown:
    """A result with a short repr, more words in print, and a table."""

    def __repr__(self) -> str:
        return str(_views().brief(self))

    def __str__(self) -> str:
        return str(_views().words(self))

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return str(_views().html(self))

    def to_frame(self) -> 'pd.DataFrame':
        """Return the result as a pandas DataFrame. Raises InputError without pandas."""
        return _views().frame(self)


class Saved:
    """What a file can hold."""

    def save(self, path: str | Path) -> Path:
        """Write it to the new file `path`, and return that. Raises InputError."""
        views = _views()
        new = views.expect_path(path, 'path', 'a new file')
        written: Path = views.save(self, new)
        return written


class Drawn(Shown):
    """A result with a picture."""

    def plot(self) -> 'Figure':
        """Return a matplotlib Figure of the result. Raises InputError without matplotlib."""
        figure: Figure = _views().figure(self)
        return figure


class Paged(Drawn):
    """A result with a page of its own."""

    def to_html(self, path: str | Path) -> Path:
        """
        Write the page of the result to the new file `path`, and return it.

        The page is one file that loads nothing. Raises InputError.
        """
        written: Path = _views().write_page(self, path)
        return written


PRISMATIC = {'kg m^2': 'kg', 'N m': 'N', 'rad': 'm', 'angle': 'position', 'torque': 'force'}
# Whole words, perhaps in mN m or torques; parts of ids, as in torque_offset, and options stay.
_WORDS = re.compile(r'(?<![\w-])([mk]?)(kg m\^2|N m|rad|angle|torque)(s?)(?!\w)')


def on_axis(label: str, axis: str) -> str:
    """
    Return a label with its units as for an axis of DriveModel.axis.

    label: as for a rotary axis, without names that a user has given; axis: 'rotary' leaves it,
    'prismatic' has m, N and kg.
    """
    if axis != 'prismatic':
        return label
    return _WORDS.sub(lambda match: match[1] + PRISMATIC[match[2]] + match[3], label)


NO_LIMIT = (-math.inf, math.inf)


class FileLimits(NamedTuple):
    """What a simulator's file says of a recording: ranges (rad) of setpoints and positions."""

    notes: tuple[str, ...] = ()
    setpoints: tuple[float, float] = NO_LIMIT
    travel: tuple[float, float] = NO_LIMIT


NO_LIMITS = FileLimits()


class ModelOrigin(NamedTuple):
    """The file of a model, as messages call it, and the limits in that file."""

    name: str = 'the model'
    limits: FileLimits = NO_LIMITS
