# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Sections that several pages have: the summary, what to do next, the verdict as JSON."""
from collections.abc import Mapping, Sequence
import json
from typing import Any

from gearbox_monitor.report.builder import Section


def advice(steps: Sequence[str]) -> Section:
    """Return the section of `steps` to take, most urgent first."""
    return Section('next.html', {'steps': steps}, 'What to do next')


def page_summary(kind: str, headline: str, facts: Sequence[tuple[str, str]] = (),
                 notes: Sequence[str] = ()) -> Section:
    """
    Return the answer of a page.

    Args:
        kind: colour of the sentence: good, warn or error, '' for none.
        headline: the answer in one sentence.
        facts: the main figures, (name, text).
        notes: sentences below.
    """
    return Section('summary.html', {'kind': kind, 'headline': headline, 'facts': facts,
                                    'notes': notes})


def verdict_numbers(data: Mapping[str, Any]) -> Section:
    """Return the section with the `data` of a verdict as JSON."""
    return Section('numbers.html', {'json': json.dumps(data, indent=1)}, 'All numbers')
