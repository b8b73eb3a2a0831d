# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Names of version 0.2 that a user may still type, and what to do without them.

`errors.unknown` looks them up, so that every command, option, parameter and key is refused in the
same words. The table goes with the release after 0.3.
"""
# Name as the user types it -> what to do instead.
REMOVED = {
    # commands
    'benchmark': 'run benchmarks from a checkout: python -m benchmarks NAME',
}


def refusal(word: object) -> str:
    """Return one line about the removed name `word`, '' if it was never a name."""
    advice = REMOVED.get(str(word))
    return f'gone since 0.3; {advice}' if advice else ''
