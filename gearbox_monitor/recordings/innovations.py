# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Innovations and their variances in a bag, of whatever filter published them.

Two topics of one type belong together where the second is called as the first one, with
`variances` or the like behind it: `innovations` and `innovations_stddev`,
`estimator_innovations` and `estimator_innovation_variances`.
"""
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from itertools import islice
import re
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.read import BagReader

SPREAD = re.compile(r'(.*innovation)s?_(stddev|std|variances?|covariances?)')
MOST = 20_000  # messages that are read
HEADS = ('header', 'stamp', 'timestamp', 'timestamp_sample', 'name')


def innovation_topics(reader: BagReader) -> dict[str, str]:
    """Return {topic of innovations: topic of their deviations or variances} in the bag."""
    pairs = {}
    for topic, (kind, _) in reader.topics.items():
        if (match := SPREAD.fullmatch(topic)) is not None:
            pairs.update({own: topic for own in (match[1], f'{match[1]}s')
                          if own in reader.topics and reader.topics[own][0] == kind})
    return pairs


def nis_of(reader: BagReader, innovations: str, spreads: str) -> dict[str, tuple[float, int]]:
    """
    Return {reading: (mean of its squared innovation over the variance, number)}.

    Args:
        reader: of the bag.
        innovations: topic.
        spreads: topic of their deviations or variances, as innovation_topics gives it.

    """
    match = SPREAD.fullmatch(spreads)
    power = 2 if match and match[2].startswith('std') else 1
    variances = dict(_messages(reader, spreads))
    ratios: dict[str, list[float]] = {}
    for stamp, values in _messages(reader, innovations):
        for name, error in values.items():
            variance = variances.get(stamp, {}).get(name, 0.0) ** power
            if variance > 0.0 and np.isfinite(error):
                ratios.setdefault(name, []).append(error ** 2 / variance)
    return {name: (float(np.mean(own)), len(own)) for name, own in ratios.items()}


def _messages(reader: BagReader, topic: str) -> Iterator[tuple[Any, dict[str, float]]]:
    """Yield (stamp or number, {reading: value}) of the first messages of a `topic`."""
    kind = reader.topics[topic][0]
    for number, (*_, raw) in enumerate(islice(reader.messages((topic,)), MOST)):
        content = reader.decode(kind, raw)
        stamp = getattr(getattr(content, 'header', None), 'stamp', None)
        key = getattr(content, 'timestamp', number) if stamp is None else (
            stamp.sec, stamp.nanosec)
        yield key, dict(_numbers(content, tuple(getattr(content, 'name', ()))))


def _numbers(content: Any, joints: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    """Yield (name, value) of all numbers in a message; joints: names of those of an array."""
    for name in (field.name for field in fields(content)):
        value = getattr(content, name)
        if name in HEADS or name.startswith('__'):
            continue
        if is_dataclass(value):
            yield from ((f'{name}.{part}', number) for part, number in _numbers(value, ()))
        elif isinstance(value, float):
            yield name, value
        elif isinstance(value, np.ndarray) and value.dtype.kind == 'f':
            row: Array = value
            yield from zip(joints if len(joints) == len(row) else (
                f'{name}[{k}]' for k in range(len(row))), map(float, row))
