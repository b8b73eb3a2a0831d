# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Whether the samples that came in could be used."""
from collections.abc import Mapping
from functools import cache
import re

from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.presentation import Said

NO_SAMPLE = Condition('no_sample', 'input', Level.ERROR, ('rate_hz',))
# Judged by the node, on the clock of its computer: no stamps come that could be judged.
SILENT = Condition('silent', 'input', Level.ERROR)
TWO_PUBLISHERS = Condition('two_publishers', 'input', Level.ERROR, ('messages_of_two_publishers',))


@cache
def key_of(counter: str) -> str:
    """Return the key on /diagnostics of a `counter`, one of sample_loop.REASONS."""
    return re.sub(r'\W+', '_', counter).strip('_')


def _refused(code: str, *counters: str) -> tuple[Condition, tuple[str, ...]]:
    """Return the Condition `code` that any of `counters` breaks, and the counters."""
    return Condition(code, 'input', Level.WARN, tuple(map(key_of, counters))), counters


REFUSED = (
    _refused('no_effort', 'samples without effort', 'missing efforts'),
    _refused('bad_stamps', 'zero stamps', 'repeated stamps', 'backward stamps',
             'stamps after a jump'),
    _refused('no_position', 'samples without measurement', 'missing motor positions',
             'missing arm positions'),
    _refused('position_jumps', 'positions that jump'),
    _refused('missed', 'samples missed (by stamps)'),
    _refused('bad_values', 'values that are infinite or beyond 1e9',
             'filter restarts after divergence'))
# Judged by the node, which knows the numbers of the messages: recordings do not have them.
LOST = Condition('lost', 'input', Level.WARN, ('messages_lost',))
CONDITIONS = (SILENT, TWO_PUBLISHERS, NO_SAMPLE, *(condition for condition, _ in REFUSED), LOST)


def check(counts: Mapping[str, int], usable: int, values: Values) -> Outcome:
    """
    Return the Outcome on the samples of the last second.

    Args:
        counts: {counter of sample_loop.REASONS: how many in this second}.
        usable: number of samples in it that gave an estimate.
        values: {key: value} to publish, with `rate_hz` and the totals of all counters.

    Returns:
        ERROR if no sample was usable, WARN if a counter of REFUSED is not 0.

    """
    broken = refused(counts)
    if not usable:  # the remedy of what makes all samples unusable, where that is known
        broken = [*(said._replace(level=Level.ERROR) for said in broken), NO_SAMPLE.said()]
    return outcome_of(broken, Said('rate', {'rate': values['rate_hz']}), values)


def refused(counts: Mapping[str, int]) -> list[Said]:
    """Return which of REFUSED `counts` {counter: how many} break, with their numbers."""
    numbered = [(condition, [f'{counts[name]} {name}' for name in counters if counts.get(name)])
                for condition, counters in REFUSED]
    return [condition.said(counts=', '.join(texts)) for condition, texts in numbered if texts]
