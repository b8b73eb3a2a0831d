# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Fits of many hypotheses on long steps by successive halving: many a little, few to the end."""
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeAlias

from gearbox_monitor.diagnosis.joint.effect_scan import joined, Proposal
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import evaluated, fitted, InnovationFit

Rounds: TypeAlias = Sequence[tuple[int, int]]  # how many go on, iterations of each
FIRST: Rounds = ((99, 1), (9, 3), (4, 12))
FURTHER: Rounds = ((16, 2), (6, 4), (3, 12))


def raced(evidence: DriveRecordings, fit: InnovationFit, proposals: Sequence[Proposal],
          score: Callable[[InnovationFit], float]) -> list[InnovationFit]:
    """
    Return `fit` with each of the effects proposed, fitted on long steps, best first.

    After the first round, one start of each effect and order goes on: other starts lead to the
    same optimum.

    Args:
        evidence: the recordings.
        fit: of the effects so far.
        proposals: further effects.
        score: of a fit; smaller is better.
    """
    with ThreadPoolExecutor(evidence.jobs) as pool:
        racing = list(pool.map(partial(_begun, evidence, fit), proposals))
        done: list[InnovationFit] = []
        for number, (survivors, iterations) in enumerate(FURTHER if fit.candidate.ids else FIRST):
            racing.sort(key=score)
            if number:
                racing = _best_of_each(racing, by_order=True)
            done += racing[survivors:]
            racing = list(pool.map(partial(fitted, evidence.coarse, iterations=iterations),
                                   racing[:survivors]))
    return _best_of_each(sorted([*racing, *done], key=score))


def _begun(evidence: DriveRecordings, fit: InnovationFit, proposal: Proposal) -> InnovationFit:
    """Return `fit` with a further effect, at the likeliest point where its fit may begin."""
    return min((evaluated(evidence.coarse, trial).alone()
                for trial in joined(evidence.starts, fit, proposal)), key=lambda f: f.deviance)


def _best_of_each(ranked: Sequence[InnovationFit], by_order: bool = False) -> list[InnovationFit]:
    """
    Return the first of `ranked` fits of each name.

    Args:
        ranked: fits, best first.
        by_order: whether a periodic effect of another order counts as another one.
    """
    best: dict[object, InnovationFit] = {}
    for fit in ranked:
        orders = tuple(fit.candidate.orders.items()) if by_order else ()
        best.setdefault((fit.candidate.key, orders), fit)
    return list(best.values())
