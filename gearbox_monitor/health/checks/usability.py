# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Whether the samples that came in could be used."""
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
import re

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of
from gearbox_monitor.kernels.types import Values

_WINDOW = 'the last second'

NO_SAMPLE = Condition(
    'input', Level.ERROR, 'no usable sample in the last second', 'no sample gave an estimate',
    _WINDOW, 'check that the source publishes and that its stamps advance', ('rate_hz',))
# Judged by the node, on the clock of its computer: no stamps come that could be judged.
SILENT = Condition(
    'input', Level.ERROR, 'no samples received',
    f'no new stamp between two diagnostics (WARN in the first {LIMITS.start_time:g} s before the '
    'first sample ever); all other components then say WARN: no data', '1 s, at once',
    'check that the source runs and that topic, joint names and domain agree')

TWO_PUBLISHERS = Condition(
    'input', Level.ERROR, 'two publishers of one joint',
    'the numbers of messages with the joint go back twice within 2 s: two publishers deliver it; '
    'nothing is taken from either until one of them has been silent for 2 s',
    '2 s, at once', 'stop one of them or remap its topic', ('messages_of_two_publishers',))


@cache
def key_of(counter: str) -> str:
    """Return the key on /diagnostics of a `counter`, one of sample_loop.REASONS."""
    return re.sub(r'\W+', '_', counter).strip('_')


def _refused(advice: str, *counters: str) -> tuple[Condition, tuple[str, ...]]:
    """Return the Condition that any of `counters` breaks, and the counters."""
    names = ', '.join(counters)
    return Condition('input', Level.WARN, names, 'any of these', _WINDOW, advice,
                     tuple(map(key_of, counters))), counters


REFUSED = (
    _refused('publish effort of the motor joint with every position',
             'samples without effort', 'missing efforts'),
    _refused('stamp each message with the time of its measurement, from one publisher',
             'zero stamps', 'repeated stamps', 'backward stamps', 'stamps after a jump'),
    _refused('check the encoders and the joint names', 'samples without measurement',
             'missing motor positions', 'missing arm positions'),
    _refused('check zero, cables and supply of the encoders; publish positions that do not wrap',
             'positions that jump'),
    _refused('check rate and load of source and network', 'samples missed (by stamps)'),
    _refused('check what the source computes', 'values that are infinite or beyond 1e9',
             'filter restarts after divergence'))
# Judged by the node, which knows the numbers of the messages: recordings do not have them.
LOST = Condition(
    'input', Level.WARN, 'messages lost', 'sequence numbers are missing between two diagnostics: '
    'dropped by the network or by the full queue of the node', '1 s, at once',
    'lower the rate or the load of this machine', ('messages_lost',))
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
    causes = refused(counts)
    # The remedy of what makes all samples unusable, where that is known.
    none = replace(NO_SAMPLE, advice=causes[0].advice) if causes else NO_SAMPLE
    broken = causes if usable else [none, *causes]
    return outcome_of(broken, f'{values["rate_hz"]:.0f} samples/s', values)


def refused(counts: Mapping[str, int]) -> list[Condition]:
    """Return the Conditions of REFUSED that `counts` {counter: how many} break, with numbers."""
    numbered = [(condition, [f'{counts[name]} {name}' for name in counters if counts.get(name)])
                for condition, counters in REFUSED]
    return [replace(condition, says=', '.join(texts)) for condition, texts in numbered if texts]
