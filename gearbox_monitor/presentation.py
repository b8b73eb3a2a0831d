# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Results that show themselves, as a line, table or page; codes that become sentences.

What they show is made in `library.views`, and the sentence of a code in `report.sentences`. Both
are imported when a result is first shown: the core computes, and neither words nor draws.
"""
from collections.abc import Mapping
from importlib import import_module
import math
from pathlib import Path
import re
from types import MappingProxyType
from typing import Any, NamedTuple, TYPE_CHECKING

from gearbox_monitor.errors import refusal

if TYPE_CHECKING:
    import pandas as pd


def _views() -> Any:
    return import_module('gearbox_monitor.library.views')


def _sentences() -> Any:
    return import_module('gearbox_monitor.report.sentences')


class Said(NamedTuple):
    """
    One thing that a result says: a code of the table of sentences, and its numbers.

    numbers: of the sentence, by name; tuples of Said are parts of it. level: of this alone, as of
    health.alarms.Level.
    """

    code: str
    numbers: Mapping[str, Any] = MappingProxyType({})
    level: int = 0

    def __str__(self) -> str:
        return str(_sentences().phrase(self))

    @property
    def remedy(self) -> str:
        """What to do about it, '' for nothing."""
        return str(_sentences().remedy(self))


def said(code: str, **numbers: object) -> Said:
    """Return a `code` of the table of sentences with its `numbers`."""
    return Said(code, numbers)


def as_written(words: str) -> Said:
    """Return `words` that are made elsewhere, or are the user's, as the others of a result."""
    return Said('as_written', {'text': words})


class Shown:
    """A result with a short repr, more words in print, and a table."""

    def __repr__(self) -> str:
        return str(_views().brief(self))

    def __str__(self) -> str:
        return str(_views().words(self))

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return str(_views().html(self))

    if not TYPE_CHECKING:
        def __getattr__(self, name: str) -> Any:
            raise AttributeError(f'{type(self).__name__}: {name}: {refusal(name)}')

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


class Paged(Shown):
    """A result with a page of its own, which a notebook shows."""

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
EXACT = 0.0  # deviation of a value that states none
UNKNOWN = 'unknown'
FINEST = 1e-3  # of a value: no model of a drive, encoder or clock is truer
DIGITS, ROUGH = 3, 2  # of a value without deviation, and of one that nothing determines
MOST_DECIMALS, LARGEST = 8, 6  # beyond them a power of ten


def on_axis(label: str, axis: str) -> str:
    """
    Return a label with its units as for an axis of DriveModel.axis.

    label: as for a rotary axis, without names that a user has given; axis: 'rotary' leaves it,
    'prismatic' has m, N and kg.
    """
    if axis != 'prismatic':
        return label
    return _WORDS.sub(lambda match: match[1] + PRISMATIC[match[2]] + match[3], label)


class Quantity(NamedTuple):
    """
    A value as people read it: `f'{quantity}'`, with its sign `f'{quantity:+}'`.

    deviation: standard deviation, EXACT where none is stated, None where nothing determines the
    value; unit: '' or '-' for a pure number.
    """

    value: float | None
    deviation: float | None = EXACT
    unit: str = ''

    def __format__(self, spec: str) -> str:
        value, deviation = self.digits(spec)
        if value == UNKNOWN:
            return value
        text = f'{value} ± {deviation}' if deviation else value
        if not deviation and self.deviation != EXACT:
            text = f'about {text}'
        unit = self.unit.strip('-').replace('^2', '²').replace('^3', '³')
        return text + ' ' * (unit not in ('', '°')) + unit

    def __str__(self) -> str:
        return format(self)

    def digits(self, sign: str = '') -> tuple[str, str]:
        """
        Return value and deviation as digits that end at the same place, '' for no deviation.

        The deviation has one digit, or two where the first one is 1; `sign`: '+' states it always.
        """
        value, deviation = self.value, self.deviation
        if value is None or not math.isfinite(value):
            return UNKNOWN, ''
        if deviation == EXACT:
            magnitude = _magnitude(value, DIGITS)
            decimals = DIGITS - 1 - magnitude
            return _rounded(value, max(decimals, 0) if magnitude < LARGEST else decimals, sign), ''
        if deviation is None or not 0.0 < deviation < math.inf:
            return _rounded(value, ROUGH - 1 - _magnitude(value, ROUGH), sign), ''
        leading, _, exponent = f'{deviation:.0e}'.partition('e')
        decimals = (leading == '1') - int(exponent)
        if decimals > MOST_DECIMALS or -decimals > LARGEST:
            count = decimals + _magnitude(max(abs(value), deviation), 1)
            count = min(max(count, 0), MOST_DECIMALS)
            return f'{value:{sign}.{count}e}', f'{deviation:.{leading == "1":d}e}'
        return _rounded(value, decimals, sign), _rounded(deviation, decimals, '')


def _magnitude(value: float, digits: int) -> int:
    """Return the power of ten of a value that is rounded to so many digits."""
    return int(f'{value:.{digits - 1}e}'.partition('e')[2])


def _rounded(value: float, decimals: int, sign: str) -> str:
    """Return a value with so many decimals, or with a power of ten where these are too many."""
    if decimals > MOST_DECIMALS or abs(value) >= 10.0 ** LARGEST:
        digits = max(decimals + _magnitude(value, 1), 0) if value else 0
        return f'{value:{sign}.{digits}e}'
    return f'{round(value, decimals) + 0.0:{sign}.{max(decimals, 0)}f}'


def credible(value: float, deviation: float | None, unit: str = '') -> Quantity:
    """Return a value of a drive whose deviation is FINEST of it at least, whatever noise says."""
    if deviation and math.isfinite(deviation):
        deviation = max(deviation, FINEST * abs(value))
    return Quantity(value, deviation, unit)


def number(value: float | None, unit: str = '') -> str:
    """Return a value that states no deviation, to three digits."""
    return str(Quantity(value, EXACT, unit))


def percent(share: float | None, deviation: float | None = EXACT) -> Quantity:
    """Return the Quantity of a share and its deviation in percent."""
    return Quantity(None if share is None else 100.0 * share,
                    None if deviation is None else 100.0 * deviation, '%')


def change(value: float, nominal: float) -> str:
    """Return the change from `nominal`, which is not 0, to `value` in percent."""
    size = 100.0 * (value - nominal) / abs(nominal)
    return f'{_rounded(size, max(1 - _magnitude(size, 2), 0), "+")} %'


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
