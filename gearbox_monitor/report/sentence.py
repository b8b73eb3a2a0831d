# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A row of the table of sentences: what a code means."""
from typing import NamedTuple


class Sentence(NamedTuple):
    """
    What a code means.

    says: template of the phrase, with the numbers of the code; remedy: of the user. For `explain`:
    when: the exact condition; window: the time that it judges; name: the name that users know, ''
    for the phrase.
    """

    says: str
    remedy: str = ''
    when: str = ''
    window: str = ''
    name: str = ''
