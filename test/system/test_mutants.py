# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Mutants: each is one change of a module, and its tests are there."""
import mutants
import pytest

pytestmark = pytest.mark.benchmark
SOURCE = '''FIRST, STEPS = 0.5, (-1e-3, 7)
RULE = Damping(1e-4, 20.0, attempts=5)
BOTH = 2 * STEPS


def limited(a: float, b: float = 2.0) -> float:
    """Return a number."""
    if a < b and not b == 0:
        return a * 2.0 - b
    return a
'''


def test_each_mutant_is_one_change():
    plain, _ = mutants.mutated(SOURCE, mutants.places(SOURCE))
    lines = [mutants.mutated(SOURCE, at) for at in range(mutants.places(SOURCE))]
    changed = ['\n'.join(line for line in text.splitlines() if line not in plain.splitlines())
               for text, _ in lines]
    assert {line.strip() for line in changed} == {
        'if a >= b and (not b == 0):', 'if a < b and (not b != 0):', 'if a < b and (not b == 1):',
        'if a < b or not b == 0:', 'if not (a < b and (not b == 0)):', 'return a * 4.0 - b',
        'return a / 2.0 - b', 'return a * 2.0 + b', 'BOTH = 3 * STEPS', 'BOTH = 2 / STEPS'}
    assert sorted(line for _, line in lines) == [3] * 2 + [8] * 5 + [9] * 3
    assert 'def limited(a: float, b: float=2.0)' in plain


@pytest.mark.parametrize('room', mutants.ROOMS)
def test_modules_and_their_tests_are_where_they_should_be(room):
    for module, tests in mutants.ROOMS[room].items():
        assert mutants.places((mutants.ROOT / 'gearbox_monitor' / module).read_text()) > 0
        assert all((mutants.ROOT / 'test' / test.partition('::')[0]).exists() for test in tests)
