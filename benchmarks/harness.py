# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The frame of all benchmarks: bars, progress, JSON output, exit codes, checks of options.

A bar compares one measured value with its permitted range. :class:`BarTable` collects the bars of
a run, :func:`bar_lines` prints them and :func:`finish` turns them into the exit code.
"""
import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
import json
import math
from pathlib import Path
import sys
import time
from typing import Any

from benchmarks import intervals
from gearbox_monitor.errors import InputError

BarRow = dict[str, Any]  # one bar as it stands in the JSON output
MET, MISSED = 'met', 'MISSED'


class BarTable:
    """
    The bars of one run, in the order in which they were judged.

    rows: one dictionary per bar for the JSON output, with the keys `bar` (name), `value` (number,
    text or None), `expected` (text), `met` (None: skipped), `interval` ([low, high], 95 %
    confidence, or None), `count` (text: events of trials) and `skipped` (reason or None).
    """

    def __init__(self) -> None:
        self.rows: list[BarRow] = []

    def check(self, name: str, value: Any, expected: Any, met: Any,
              interval: Sequence[float] | None = None, count: str = '') -> None:
        """
        Add a bar whose verdict the caller has reached.

        Args:
            name: what was measured.
            value: measured value; numbers are printed with three decimals, texts as they are.
            expected: permitted values, in words.
            met: whether the value is permitted.
            interval: 95 % confidence interval of the value.
            count: events of trials behind the value, as text.
        """
        self.rows.append({
            'bar': name, 'value': value, 'expected': str(expected), 'met': bool(met),
            'interval': None if interval is None else [float(limit) for limit in interval],
            'count': count, 'skipped': None})

    def judge(self, name: str, value: float | None, low: float = -math.inf,
              high: float = math.inf, interval: Sequence[float] | None = None,
              count: str = '') -> None:
        """
        Add a bar that is met by a value from `low` to `high`.

        Args:
            name: what was measured.
            value: measured value; None (nothing to measure) misses the bar.
            low: smallest permitted value; without `low` and `high` the value is only reported.
            high: largest permitted value.
            interval: 95 % confidence interval of the value.
            count: events of trials behind the value, as text.
        """
        self.check(name, None if value is None else float(value), range_text(low, high),
                   value is not None and low <= value <= high, interval, count)

    def share(self, name: str, hits: Iterable[object], low: float = -math.inf,
              high: float = math.inf) -> None:
        """
        Judge a share of trials, with its Wilson interval.

        Args:
            name: what was counted.
            hits: truth value of each trial; without trials no bar is added.
            low: smallest permitted share.
            high: largest permitted share.
        """
        outcomes = [bool(hit) for hit in hits]
        if outcomes:
            total, count = len(outcomes), sum(outcomes)
            self.judge(name, count / total, low, high, intervals.share(count, total),
                       f'{count}/{total}')

    def skip(self, name: str, reason: str, value: float | None = None) -> None:
        """
        Add a bar that cannot be judged; it does not change the exit code.

        Args:
            name: what would have been measured.
            reason: why it cannot be judged.
            value: the value measured all the same, if any.
        """
        self.rows.append({'bar': name, 'value': value, 'expected': '', 'met': None,
                          'interval': None, 'count': '', 'skipped': reason})


def range_text(low: float, high: float) -> str:
    """Return the range from `low` to `high` in words, '' if neither is finite."""
    if math.isfinite(low) and math.isfinite(high):
        return f'{low:.4g} .. {high:.4g}'
    return f'<= {high:.4g}' if math.isfinite(high) else (
        f'>= {low:.4g}' if math.isfinite(low) else '')


def all_met(rows: Iterable[BarRow]) -> bool:
    """Return whether no bar of the `rows` of a BarTable is missed."""
    return all(row['met'] is not False for row in rows)


def interval_text(interval: Sequence[float] | None, digits: int = 3, factor: float = 1.0) -> str:
    """
    Return a confidence interval as text, '' for None.

    Args:
        interval: its two limits.
        digits: decimals.
        factor: multiplies both limits, e.g. 100 for percent.
    """
    if interval is None:
        return ''
    return '[' + ', '.join(f'{factor * limit:.{digits}f}' for limit in interval) + ']'


def _value_text(value: object) -> str:
    if value is None:
        return '-'
    if isinstance(value, float):
        return f'{value:.{4 if abs(value) < 0.1 else 3 if abs(value) < 10.0 else 2}f}'
    return str(value)


def bar_lines(rows: Sequence[BarRow]) -> list[str]:
    """Return a line of text for each of the `rows` of a BarTable, in aligned columns."""
    judged = [row for row in rows if row['met'] is not None]
    columns = [[row['bar'] for row in judged], [_value_text(row['value']) for row in judged],
               [interval_text(row['interval'], 4 if abs(row['value']) < 0.1 else 2)
                if row['interval'] else '' for row in judged],
               [row['count'] for row in judged]]
    widths = [max(map(len, column), default=0) for column in columns]
    # The word takes the place that confidence intervals need.
    word = '' if widths[2] else 'expected '
    lines, cells = [], iter(zip(*columns))
    for row in rows:
        if row['met'] is None:
            value = '' if row['value'] is None else f'{_value_text(row["value"])}, '
            lines.append(f'skipped {row["bar"]}: {value}{row["skipped"]}')
            continue
        name, value, *optional = next(cells)
        verdict = MISSED if not row['met'] else MET if row['expected'] else ''
        texts = [f'{name:<{widths[0]}}', f'{value:>{widths[1]}}',
                 *(f'{cell:<{width}}' for cell, width in zip(optional, widths[2:]) if width)]
        expected = word + row['expected'] if row['expected'] else ''
        lines.append(f'{verdict:<7}' + ' '.join([*texts, expected]).rstrip())
    return lines


def progress_line() -> Callable[[str], None]:
    """
    Return a function that shows its argument and the elapsed time on one line of the terminal.

    An empty text clears the line. If stderr is not a terminal, nothing is written.
    """
    start = time.monotonic()

    def show(text: str) -> None:
        """Show `text` with the elapsed time."""
        if sys.stderr.isatty():
            line = text and f'{time.monotonic() - start:4.0f} s  {text}'
            print(f'\r{line:<72}' + ('' if text else '\r'), end='', file=sys.stderr, flush=True)
    return show


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add the option --json FILE to `parser`."""
    parser.add_argument('--json', metavar='FILE', help='write all figures as JSON')


def add_drawn_options(parser: argparse.ArgumentParser, kind: str, count: int,
                      explanation: str) -> None:
    """
    Add the options of a benchmark that draws its cases.

    Args:
        parser: of the benchmark.
        kind: of what is drawn, in the plural: --KIND says how many; --seed draws others.
        count: default number.
        explanation: of --KIND.
    """
    parser.add_argument(f'--{kind}', type=int, default=count, metavar='N',
                        help=f'{explanation} (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=0, metavar='S',
                        help=f'other {kind} for another seed (default: %(default)s)')
    add_json_option(parser)


def require_drawn(args: argparse.Namespace, kind: str) -> None:
    """Check the options `args` of add_drawn_options for this `kind`. Raises InputError."""
    require_whole(f'--{kind}', getattr(args, kind))
    require_whole('--seed', args.seed, 0)


def require_whole(option: str, value: int, minimum: int = 1) -> None:
    """
    Check an option that counts something.

    Args:
        option: its name, with dashes.
        value: the number that the user gave.
        minimum: smallest permitted number.

    Raises:
        InputError: if the number is too small.
    """
    if value < minimum:
        raise InputError(f'{option}: {value}, expected a whole number >= {minimum}')


def finish(data: Mapping[str, Any], lines: str, path: str | None) -> int:
    """
    Print and store the result of a benchmark.

    Args:
        data: all figures; `data['bars']` are the rows of a BarTable.
        lines: the figures as text for the terminal.
        path: JSON file for `data`, None for none.

    Returns:
        The exit code: 1 if a bar is missed, otherwise 0.
    """
    print(lines)
    write_json(data, path)
    return 0 if all_met(data['bars']) else 1


def write_json(data: object, path: str | None) -> None:
    """Write `data` to the JSON file `path`; None writes nothing."""
    if path:
        Path(path).write_text(json.dumps(data, indent=2) + '\n', encoding='utf-8')
