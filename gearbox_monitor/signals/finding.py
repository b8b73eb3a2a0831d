# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A finding about a recording: how good it is for each purpose, and what to do next."""
from collections.abc import Iterable
from dataclasses import dataclass, field
import enum
from typing import Any

from gearbox_monitor.presentation import on_axis, Said

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

    group, name: of its line; says: what was found, as codes of the table of sentences with their
    numbers; hurts {purpose: Grade}: what it spoils, purposes that are not named are fine;
    values {name: number}: for programs, SI units; fault: of a recording, by which the diagnosis
    refuses it, '' where nothing is spoilt; axis: of the drive; open: nothing could be judged, so
    that its line is no OK.
    """

    group: str
    name: str
    says: tuple[Said, ...]
    hurts: dict[str, Grade] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    fault: str = ''
    axis: str = 'rotary'
    open: bool = False

    @property
    def figure(self) -> str:
        """What was found, in words with units."""
        words = ''.join(map(str, self.says)).removeprefix(f'{self.group}: ')  # its line has it
        return on_axis(words, self.axis)

    @property
    def advice(self) -> str:
        """What to do next, '' where nothing is spoilt."""
        remedies = (said.remedy for said in self.says) if self.hurts else ()
        return on_axis(next(filter(None, remedies), ''), self.axis)

    @property
    def text(self) -> str:
        """The finding as a sentence: figure and advice."""
        return f'{self.figure}: {self.advice}' if self.advice else self.figure

    @property
    def fatal(self) -> bool:
        """Whether a verdict would be about the recording, not about the drive."""
        return self.fault in FATAL

    def verdict(self, purposes: Iterable[str] = PURPOSES) -> Grade:
        """Return the worst Grade for any of `purposes`."""
        return max((self.hurts.get(purpose, OK) for purpose in purposes), default=OK)

    def verdict_word(self, purposes: Iterable[str] = PURPOSES) -> str:
        """Return the verdict for `purposes` in a word, - for what could not be judged."""
        return '-' if self.open else self.verdict(purposes).name.lower()


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


def judged(group: str, name: str, says: Said | tuple[Said, ...],
           grades: dict[str, Grade] | None = None, values: dict[str, Any] | None = None,
           fault: str = '') -> DataFinding:
    """
    Return a DataFinding, with the fault only where something is spoilt.

    Args:
        group: of the finding.
        name: of the finding.
        says: what was found.
        grades: what it spoils, None or {} for nothing.
        values: for programs.
        fault: of the recording.
    """
    return DataFinding(group, name, (says,) if isinstance(says, Said) else says, grades or {},
                       values or {}, fault if grades else '')
