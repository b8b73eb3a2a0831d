# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The section of a page that says what to do next."""
from collections.abc import Sequence
from dataclasses import dataclass

from gearbox_monitor.report.builder import Section


@dataclass(frozen=True)
class NextSteps(Section):
    """Advice, most urgent first."""

    heading = 'What to do next'
    template = 'next.html'
    steps: Sequence[str]
