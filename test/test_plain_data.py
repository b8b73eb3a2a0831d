# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Plain data of frozen values: they read back exactly, and damaged ones raise a known error."""
from dataclasses import dataclass
import json
import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from gearbox_monitor.health.alarms import Level
from gearbox_monitor.plain_data import classes_of, from_data, to_data


class Pair(NamedTuple):
    first: int
    second: Any


@dataclass(frozen=True)
class Whole:
    name: str
    parts: Any
    level: Level = Level.OK


CLASSES = classes_of(Level, Pair, Whole)
VALUE = Whole('a', (
    Pair(2 ** 62 + 1, None), {'b': (0.1 + 0.2, math.inf, True), ('c', 1): Whole('', ())},
    np.arange(6.0).reshape(2, 3)[:, ::-1], np.zeros((0, 3), np.int64), np.float64(1e-300)),
    Level.ERROR)


@pytest.mark.parametrize('apart', [False, True])
def test_a_value_reads_back_exactly(apart):
    arrays = {} if apart else None
    text = json.dumps(to_data(VALUE, arrays))
    assert ('bytes' in text) is not apart and len(arrays or ()) == 2 * apart
    again = from_data(json.loads(text), CLASSES, arrays)
    assert again.level is Level.ERROR and again.parts[:2] == VALUE.parts[:2]
    assert type(again.parts[0]) is Pair and again.parts[4] == 1e-300
    for array, other in zip(again.parts[2:4], VALUE.parts[2:4]):
        np.testing.assert_array_equal(array, other, strict=True)
        assert array.flags.writeable
    assert json.dumps(to_data(again, {} if apart else None)) == text
    assert to_data(VALUE, arrays, leave=('parts', 'level')) == {'=': 'Whole', 'name': 'a'}


def test_what_is_damaged_raises_an_error_that_readers_catch():
    text, random, refused = json.dumps(to_data(VALUE)), np.random.default_rng(0), 0
    for at in random.integers(0, len(text), 400).tolist():
        damaged = text[:at] + chr(33 + int(random.integers(90))) + text[at + 1:]
        try:
            from_data(json.loads(damaged), CLASSES)
        except (KeyError, TypeError, ValueError):
            refused += 1
    assert refused > 200
