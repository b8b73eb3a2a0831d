# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Names of version 0.2 that a user may still type, and what to do without them: removed.toml.

`errors.unknown` looks them up, so that every command, option, parameter and key is refused in the
same words. The table goes with the release after 0.3.
"""
from functools import cache
from importlib.resources import files
import tomllib


@cache
def removed() -> dict[str, str]:
    """Return {name as the user types it: what to do instead}."""
    text = files('gearbox_monitor').joinpath('removed.toml').read_text(encoding='utf-8')
    return tomllib.loads(text)


def refusal(word: object) -> str:
    """Return one line about the removed name `word`, '' if it was never a name."""
    advice = removed().get(str(word))
    return f'gone since 0.3; {advice}' if advice else ''
