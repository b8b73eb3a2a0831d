# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one exception that a user's input can raise, how several become one, and names that are gone.

removed.toml lists names of version 0.2 that a user may still type; it goes with the release after
0.3. `unknown` looks them up, so that all are refused in the same words.
"""
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Set
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from numbers import Integral
import re
import tomllib
from typing import Any, TypeAlias


@cache
def removed() -> dict[str, str]:
    """Return {name as the user types it: what to do instead}."""
    text = files('gearbox_monitor').joinpath('removed.toml').read_text(encoding='utf-8')
    return tomllib.loads(text)


def refusal(word: object) -> str:
    """Return one line about the removed name `word`, '' if it was never a name."""
    advice = removed().get(str(word))
    return f'gone since 0.3; {advice}' if advice else ''


LONGEST = 800  # characters of one problem: a file may hold anything
# What would end a line, or hide something, on a terminal.
_SPACE = re.compile('[\\s\\x00-\\x1f\\x7f-\\x9f\u2028\u2029\ufeff]+')


class InputError(ValueError):
    """
    Bad input: one line per problem, naming file, field, value and what was expected.

    Command lines print it without a traceback and end with exit code 2.
    """

    def __init__(self, *problems: object) -> None:
        super().__init__(*(_line(problem) for problem in problems))

    def __str__(self) -> str:
        return '\n'.join(self.args)


class Undecided(InputError):
    """
    Input that is in order, but does not decide the question; the text says what would.

    Command lines end with exit code 3.
    """


def expect_whole(value: object, name: str, lowest: int = 0) -> None:
    """Raise InputError if `value`, called `name`, is no whole number from `lowest` on."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < lowest:
        raise InputError(f'{name}: {value!r}, expected a whole number >= {lowest}')


def expect_list(option: str, names: Any, what: str) -> Iterable[object]:
    """
    Return `names`, a list or None. Raises InputError for something else.

    Args:
        option: what the argument is called.
        names: its value.
        what: that it lists.
    """
    if isinstance(names, str) or not isinstance(names, (Sequence, Mapping, Set, type(None))):
        raise InputError(f'{option}: {names!r}, expected a list of {what}')
    return names or ()


def expect_keys(data: object, name: str, source: str, allowed: Collection[str],
                whole: bool = False) -> None:
    """
    Raise InputError if a block of a file is no mapping, or has other keys than its own.

    Args:
        data: the block.
        name: of the block.
        source: of the file.
        allowed: its keys.
        whole: whether the block is the whole file, so that its name is not part of the keys.
    """
    if not isinstance(data, dict):
        raise InputError(f'{source}: {name}: {repr(data)[:40]}, expected keys and values')
    prefix = '' if whole else f'{name}.'
    strange = [key for key in data if key not in allowed]
    if strange:
        raise InputError(*(f'{source}: {prefix}{key}: unknown key, {unknown(key, allowed)}'
                           for key in strange))


def expect_choice(value: Any, name: str, source: str, choices: Collection[str]) -> Any:
    """Return `value` of the key `name` in `source`, one of `choices`. Raises InputError."""
    if value not in choices:
        raise InputError(f'{source}: {name}: {value!r}, expected one of {", ".join(choices)}')
    return value


Check: TypeAlias = Callable[[Any], str]  # of a value: what was expected instead, '' if it is right


def number_check(expected: str = 'a number', right: Callable[[float], bool] | None = None
                 ) -> Check:
    """Return the Check of a finite number, where it must be `right`; `expected`: in words."""
    def check(value: Any) -> str:
        finite = isinstance(value, (int, float)) and not isinstance(value, bool)
        return '' if finite and -1e100 < value < 1e100 and (
            right is None or right(value)) else expected
    return check


def expect(value: Any, name: str, source: str, check: Check) -> None:
    """Raise InputError if a `check` of the `value` of the key `name` in `source` fails."""
    if expected := check(value):
        raise InputError(f'{source}: {name}: {value!r}, expected {expected}')


def expect_values(data: Any, name: str, source: str, checks: Mapping[str, Check],
                  needed: Collection[str] = ()) -> None:
    """
    Raise InputError if a block of a file has other keys or values than it may have.

    Args:
        data: the block.
        name: of the block.
        source: of the file.
        checks: {key: Check of its value}.
        needed: keys that it must have.
    """
    expect_keys(data, name, source, checks)
    for key in dict.fromkeys((*needed, *data)):
        expect(data.get(key), f'{name}.{key}', source, checks[key])


def installed_by(extra: str) -> str:
    """Return the command that installs the packages of an `extra`: the package is on no index."""
    return f"pip install '.[{extra}]' in a checkout"


def _line(problem: object) -> str:
    text = _SPACE.sub(' ', str(problem)).strip().encode('utf-8', 'replace').decode()
    return text if len(text) <= LONGEST else f'{text[:LONGEST - 200]} ... {text[-180:]}'


class Problems:
    """
    Collects the InputErrors of ``with problems:`` blocks, each of which ends at its first.

    `raise_all` raises one InputError with all of them.
    """

    def __init__(self) -> None:
        self.found: list[str] = []

    def __enter__(self) -> 'Problems':
        return self

    def __exit__(self, kind: object, error: object, _: object) -> bool:
        if isinstance(error, InputError):
            self.found += error.args
            return True
        return False

    def raise_all(self) -> None:
        """Raise InputError where there was any."""
        if self.found:
            raise InputError(*self.found)


def unknown(word: object, names: Iterable[object], place: str = '') -> str:
    """
    Return what was expected instead of `word`: the most similar of `names`, or all of them.

    Args:
        word: that the user typed.
        names: that are known there.
        place: command, or command and option, that the word follows; '' without one.
    """
    if gone := refusal(f'{place} {word}'.lstrip()):
        return gone
    words = sorted(map(str, names))
    similar = most_similar(word, words)
    return f'did you mean {similar!r}?' if similar else 'expected one of ' + ', '.join(words)


def most_similar(word: object, names: Iterable[str]) -> str:
    """Return the most similar of `names` to `word`, '' if none is similar."""
    return next(iter(get_close_matches(str(word)[:100], list(names), 1)), '')
