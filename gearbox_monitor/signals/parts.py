# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Findings about a long recording, examined part by part in bounded memory.

A fault counts in whichever part it is. A part in which the drive stands still says nothing about
motion: only its stamps and readings count.
"""
from collections.abc import Sequence
from dataclasses import replace

from gearbox_monitor.signals import stamps
from gearbox_monitor.signals.examine import Examination, examined
from gearbox_monitor.signals.finding import BAD, DataFinding

SAMPLES = 150_000  # that a part has at least, 300 MB of memory; less than twice that are one
WINDOWS = 2        # of drift, likewise


def joined(parts: Sequence[Examination], drift_window: float) -> Examination:
    """
    Return the Examination of a recording from those of its `parts`, in order.

    Each line is that of the part in which it is worst, of equal ones the first; samples that are
    refused or lost are counted in all parts. drift_window (s): the estimator's.
    """
    if len(parts) == 1:
        return parts[0]
    moving = [part for part in parts if not _rests(part)] or parts
    by_name: dict[tuple[str, str], list[tuple[float, DataFinding]]] = {}
    for part in parts:
        for line in part.lines:
            if part in moving or _of_rest(line):
                by_name.setdefault((line.group, line.name), []).append((part.begin, line))
    lines = {name: _worst(candidates, parts[0].begin,
                          len(parts if _of_rest(candidates[0][1]) else moving))
             for name, candidates in by_name.items()}
    seconds = parts[-1].begin + parts[-1].seconds - parts[0].begin
    length = stamps.length(seconds, drift_window)
    lines[length.group, length.name] = length
    return examined(lines.values(), parts[0].begin, seconds)


def _worst(candidates: Sequence[tuple[float, DataFinding]], start: float, count: int
           ) -> DataFinding:
    """
    Return the worst of [(begin of its part, finding)], the first of equal ones, with its part.

    start: of the recording, s; count: of the parts that could have such a line.
    """
    begin, line = max(candidates, key=lambda pair: pair[1].verdict())
    counted = line.group == 'stamps' and line.name in ('order', 'gaps')
    if counted:
        line = stamps.counted(line, [(part - start, finding) for part, finding in candidates])
    if sum(candidate.verdict() == line.verdict() for _, candidate in candidates) == count:
        return line
    where = f'{"worst in the " if counted else ""}part from {begin - start:.0f} s on'
    return replace(line, figure=f'{line.figure} ({where})',
                   values={**line.values, 'part_from_s': begin - start})


def _rests(part: Examination) -> bool:
    """Return whether neither side moves in a part, by its Examination."""
    travels = [line for line in part.lines if line.name.startswith('travel')]
    return bool(travels) and all(line.verdict() == BAD for line in travels)


def _of_rest(line: DataFinding) -> bool:
    """Return whether a finding says something where the drive stands, too."""
    return line.group == 'stamps' or line.group in ('motor', 'arm') and line.name == 'readings'
