# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one table of sentences, from sentences.toml: the meaning of each code of a result.

The core says codes and numbers (presentation.Said). Texts, pages, JSON and /diagnostics print them
by this table, `explain` prints the table itself.
"""
from collections.abc import Iterable, Iterator
from importlib.resources import files
import re
import tomllib
from types import SimpleNamespace
from typing import Any, NamedTuple

from gearbox_monitor.estimation.score import LAGS, MIN_SAMPLES
from gearbox_monitor.health.alert_limits import LIMITS as ALERT
from gearbox_monitor.health.backlash.change_tests import TESTS, WEAR, WEAR_FEATURES
from gearbox_monitor.health.checks.innovation import LJUNG_BOX_LIMIT, MEAN_LIMIT
from gearbox_monitor.health.checks.outcome import Group
from gearbox_monitor.presentation import Said
from gearbox_monitor.signals.recording_limits import LIMITS as RECORDING


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
        settled=ALERT.settle + 1.0, twist_width=2 * ALERT.twist_sure)}
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
