# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A finding about a recording: how good it is for each purpose, and what to do next."""
from collections.abc import Iterable
from dataclasses import dataclass, field
import enum
from typing import Any

PURPOSES = ('estimation', 'drift', 'diagnosis')


class Grade(enum.IntEnum):
    """How good something is; the worst counts."""

    OK = 0
    WARN = 1
    BAD = 2


OK, WARN, BAD = Grade.OK, Grade.WARN, Grade.BAD


# Faults with which the diagnosis refuses a recording.
FATAL = frozenset({'not_finite', 'rate', 'too_short', 'clipped', 'frozen', 'unexcited'})


@dataclass(frozen=True)
class DataFinding:
    """
    One finding.

    group, name: where it stands; figure: what was found, in words with units; advice: what to do
    next, '' where nothing is; hurts {purpose: Grade}: what it spoils, purposes that are not
    named are fine; values {name: number}: the figure for programs, SI units.
    """

    group: str
    name: str
    figure: str
    advice: str = ''
    hurts: dict[str, Grade] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    code: str = ''

    @property
    def text(self) -> str:
        """The finding as a sentence: figure and advice."""
        return f'{self.figure}: {self.advice}' if self.advice else self.figure

    @property
    def fatal(self) -> bool:
        """Whether a verdict would be about the recording, not about the drive."""
        return self.code in FATAL

    def verdict(self, purposes: Iterable[str] = PURPOSES) -> Grade:
        """Return the worst Grade for any of `purposes`."""
        return max((self.hurts.get(purpose, OK) for purpose in purposes), default=OK)


def hurts(estimation: Grade = OK, drift: Grade = OK, diagnosis: Grade = OK) -> dict[str, Grade]:
    """
    Return {purpose: Grade} of what is not fine.

    Args:
        estimation: grade for estimation.
        drift: grade for drift.
        diagnosis: grade for the diagnosis.
    """
    grades = dict(zip(PURPOSES, (estimation, drift, diagnosis)))
    return {purpose: verdict for purpose, verdict in grades.items() if verdict > OK}


def everything(verdict: Grade) -> dict[str, Grade]:
    """Return {purpose: `verdict`} for all purposes."""
    return hurts(*(verdict for _ in PURPOSES))


def judged(group: str, name: str, figure: str, grades: dict[str, Grade], advice: str = '',
           values: dict[str, Any] | None = None, code: str = '') -> DataFinding:
    """
    Return a DataFinding, with advice and code only where something is spoilt.

    Args:
        group: of the finding.
        name: of the finding.
        figure: what was found, in words.
        grades: what it spoils, {} for nothing.
        advice: what to do then.
        values: the figure for programs.
        code: of the fault.
    """
    return DataFinding(group, name, figure, advice if grades else '', grades, values or {},
                       code if grades else '')
