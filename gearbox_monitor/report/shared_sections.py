# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Sections that several pages have: the summary, what to do next, the verdict as JSON."""
from collections.abc import Sequence
from dataclasses import dataclass

from gearbox_monitor.report.builder import Section


@dataclass(frozen=True)
class NextSteps(Section):
    """Advice, most urgent first."""

    heading = 'What to do next'
    template = 'next.html'
    steps: Sequence[str]


@dataclass(frozen=True)
class PageSummary(Section):
    """
    The answer of a page in one sentence, the main figures, notes.

    kind: colour of the sentence: good, warn or error, '' for none.
    """

    template = 'summary.html'
    kind: str
    headline: str
    facts: Sequence[tuple[str, str]] = ()
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class VerdictNumbers(Section):
    """The verdict as JSON."""

    heading = 'All numbers'
    template = 'numbers.html'
    json: str
