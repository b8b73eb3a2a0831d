# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one table of sentences, from sentences.toml: the meaning of each code of a result.

The core says codes and numbers (presentation.Said). Texts, pages, JSON and /diagnostics print them
by this table, `explain` prints the table itself. Below it the answers of fits, with sizes: one
definition for the terminal, the JSON and repr.
"""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.resources import files
import math
import re
import textwrap
import tomllib
from types import SimpleNamespace
from typing import Any, NamedTuple, TYPE_CHECKING

from gearbox_monitor.estimation.noise_search import BLUNT
from gearbox_monitor.estimation.score import LAGS, MIN_SAMPLES
from gearbox_monitor.health.alarms import Group, LIMITS as ALERT
from gearbox_monitor.health.backlash.change_tests import TESTS, WEAR, WEAR_FEATURES
from gearbox_monitor.health.checks.innovation import LJUNG_BOX_LIMIT, MEAN_LIMIT
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.presentation import (
    change, credible, EXACT, number, on_axis, Quantity, Said, said)
from gearbox_monitor.signals.finding import LIMITS as RECORDING

if TYPE_CHECKING:
    from gearbox_monitor.diagnosis.joint.nominal import Adapted, FittedValue, NominalFit


class Sentence(NamedTuple):
    """
    What a code means.

    says: template of the phrase, with the numbers of the code; remedy: of the user; page: of docs/
    that explains it. For `explain`: when: the exact condition; window: the time that it judges;
    name: the name that users know, '' for the phrase.
    """

    says: str
    remedy: str = ''
    when: str = ''
    window: str = ''
    name: str = ''
    page: str = ''


# What ${test.lags} and its like are in sentences.toml.
KNOWN = {
    'alert': ALERT, 'recording': RECORDING, 'test': SimpleNamespace(
        lags=LAGS, samples=MIN_SAMPLES, ljung_box=LJUNG_BOX_LIMIT, mean=MEAN_LIMIT,
        settled=ALERT.settle + 1.0, twist_width=2 * ALERT.deviations)}
_KNOWN = re.compile(r'\$\{(\w+)\.(\w+):?([^}]*)\}')
_DATA = tomllib.loads(files(__package__).joinpath('sentences.toml').read_text(encoding='utf-8'))
_PAGES, _PIECES = _DATA.pop('page'), _DATA.pop('piece')
# Test for a change -> its phrase, and the remedies of its stages: found, a warning, an error.
CHANGES: dict[str, list[str]] = _DATA.pop('change')


def _filled(text: str) -> str:
    """Return a `text` of sentences.toml with its pieces and limits."""
    def known(match: re.Match[str]) -> str:
        """Return what a ${...} is."""
        if match[1] == 'piece':
            return _filled(_PIECES[match[2]])
        return format(getattr(KNOWN[match[1]], match[2]), match[3] or 'g')
    return _KNOWN.sub(known, text) if '$' in text else text


def _sentence(part: str, row: str | dict[str, str]) -> Sentence:
    fields = {'says': row} if isinstance(row, str) else row
    return Sentence(**{'page': _PAGES[part], **{k: _filled(v) for k, v in fields.items()}})


def _changes() -> Iterator[tuple[str, Sentence]]:
    """Yield the codes and sentences of each change: found, worse, an error, over."""
    for test in TESTS:
        phrase, *remedies = CHANGES[test.key]
        for stage, (limit, remedy) in enumerate(
                zip(WEAR_FEATURES[test.column].limits, remedies), 1):
            sure = 'significant (false_alarm_interval) and ' if stage == 1 else ''
            also = ', or the backlash > gap_limit' \
                if limit == 'gap_error' and test.key == 'gap' else ''
            yield f'{test.key}_{stage}', Sentence(
                f'{phrase} {{size}} since {{since}}{{more}}', remedy,
                f'{sure}change >= {limit}{also}',
                f'since one of the newest {WEAR.horizon} windows' if stage == 1 else
                'since the change', f'{phrase} ... %', _PAGES['change'])
        yield f'{test.key}_over', Sentence(
            f'over: {phrase.replace(" has ", " had ")} {{size}}', page=_PAGES['change'])


PARTS = {part: {code: _sentence(part, row) for code, row in rows.items()}
         for part, rows in _DATA.items()} | {'change': dict(_changes())}
TABLE = {code: sentence for part in PARTS.values() for code, sentence in part.items()}


class _Open:
    """Any number of a template that is shown without numbers."""

    def __getitem__(self, name: str) -> '_Open':
        return self

    def __format__(self, spec: str) -> str:
        return '...'


def title(code: str) -> str:
    """Return the name of a `code`."""
    sentence = TABLE[code]
    return sentence.name or sentence.says.format_map(_Open())


def phrase(said: Said) -> str:
    """Return the phrase of a code, without its remedy; numbers that are Said become phrases."""
    numbers: dict[str, Any] = {
        name: ''.join(map(phrase, value)) if isinstance(value, tuple)
        and all(isinstance(part, Said) for part in value) else value
        for name, value in said.numbers.items()}
    return TABLE[said.code].says.format_map(numbers)


def say(code: str, **numbers: object) -> str:
    """Return the phrase of a `code` with its `numbers`."""
    return phrase(Said(code, numbers))


def remedy(said: Said) -> str:
    """Return what to do about what is `said`, '' for nothing."""
    return TABLE[said.code].remedy.format_map(said.numbers)


def message(groups: Iterable[Group]) -> str:
    """
    Return the message of an outcome: its groups with '; ' between them.

    A group has its phrases, then the remedy of the first one at the highest level, unless that is
    OK.
    """
    return '; '.join(map(_group, groups))


def _group(group: Group) -> str:
    text = ', '.join(map(phrase, group))
    gravest = max(group, key=lambda said: said.level, default=None)
    todo = remedy(gravest) if gravest is not None and gravest.level else ''
    return f'{text}: {todo}' if todo else text


CERTAIN = 3.0  # errors by which a value differs from the model file
UNITS = {row.name: row.unit for row in ESTIMATOR}


def wrapped(words: str, first: str = '', further: str = '') -> list[str]:
    """Return `words` in lines of at most 80 columns, which `first` and `further` begin."""
    return textwrap.wrap(words, 80, initial_indent=first, subsequent_indent=further,
                         break_on_hyphens=False)


def entries(rows: Iterable[tuple[str, str]], wide: int = 13) -> list[str]:
    """Return lines with the words of each of `rows` behind its label of `wide` columns."""
    return [line for label, words in rows if words
            for line in wrapped(words, f'{label:<{wide}s}', ' ' * wide)]


def labelled(says: Iterable[Said], axis: str = 'rotary') -> Iterator[tuple[str, str]]:
    """Yield the rows of `entries` for codes on a drive with `axis`, each label once in a row."""
    before = ''
    for row in says:
        label = on_axis(title(row.code), axis)
        yield ('' if label == before else label), str(row)
        before = label


PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'controller': 'controller', 'actuator': 'actuator', 'motor_sensor': 'motor encoder',
    'arm_sensor': 'arm encoder'}


def told(says: Iterable[Said]) -> dict[str, Any]:
    """Return what a result `says` as plain data: its summary in words, and its codes."""
    listed = list(says)
    return {'summary': ' '.join(map(str, listed)), 'codes': [said.code for said in listed]}


def largest_change(values: 'Iterable[FittedValue]') -> Said:
    """Return which of `values` changed most in its errors."""
    moved = max((v for v in values if v.error and v.value != v.start), default=None,
                key=lambda v: abs(v.value - v.start) / v.error)
    if moved is None or abs(moved.value - moved.start) < CERTAIN * moved.error:
        return said('fit_changes_nothing')
    by = (said('by', change=change(moved.value, moved.start)),) if moved.start else ()
    return said('fit_changes', name=moved.name, start=number(moved.start), by=by,
                size=credible(moved.value, moved.error, moved.unit))


def of_fit(fit: 'NominalFit') -> Sequence[Said]:
    """Return what a `fit` says: what it determines, what changes most, its misfit."""
    sure, count = [v for v in fit.values if v.determined], len(fit.values)
    code = ('fits_it' if sure else 'fits_it_not') if count == 1 else (
        'fits_all' if len(sure) == count else 'fits_part')
    return (said(code, sure=len(sure), count=count), largest_change(sure),
            said('misfit' if fit.gap_before is None else 'misfit_change',
                 before=number(fit.gap_before), misfit=number(fit.gap_after)))


def of_unit(unit: 'Adapted') -> Sequence[Said]:
    """Return what the model of one `unit` says."""
    if unit.fit is None:
        return said('unit_unknown', why='; '.join(unit.open)),
    if unit.kept:
        return said('unit_kept'),
    sure, count = [v for v in unit.fit.values if v.determined], len(unit.fit.values)
    return (said('unit_fits', sure=len(sure), count=f'{count} value{"s" * (count != 1)}'),
            largest_change(sure), said('misfit', misfit=number(unit.fit.gap_after)))


def of_noise(figures: Mapping[str, Any], axis: str = 'rotary') -> Sequence[Said]:
    """Return what the `figures` of a tuned filter of a drive with `axis` say."""
    if figures['kept']:
        return said('noise_kept'),
    start, tuned = figures['before'], figures['after']
    gain = tuned['loglik'] - start['loglik']
    says = [said('noise_likelier' if gain > 0.0 else 'noise_not_likelier', gain=gain,
                 likelihood=tuned['loglik'], nis=tuned['nis'], before=start['nis'])]
    before, errors = figures['before_parameters'], figures['relative_error']
    moved = {name: abs(math.log(value / before[name]))
             for name, value in figures['parameters'].items()
             if isinstance(value, float) and value > 0.0 and (before[name] or 0.0) > 0.0
             and errors.get(name, 0.0) <= BLUNT}
    name = max(moved, key=lambda n: moved[n], default=None)
    if name is not None and moved[name] > 0.0:
        value = figures['parameters'][name]
        size = Quantity(value, value * errors.get(name, EXACT), on_axis(UNITS[name], axis))
        says.append(said('noise_changes', name=name, size=size, start=number(before[name]),
                         change=change(value, before[name])))
    return says
