# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The name of a compiled kernel holds all that its machine code depends on."""
from collections import namedtuple
import enum
from itertools import repeat
import sys
from types import FunctionType, ModuleType

import numpy as np
import pytest

from gearbox_monitor.kernels import jit
from gearbox_monitor.kernels.jit import COMPILED

pytestmark = pytest.mark.skipif(not COMPILED, reason='numba is not in use')
ONE, TWO = namedtuple('Pair', 'a b'), namedtuple('Pair', 'b a')
COLOUR, LIGHT = (enum.Enum('Colour', {'RED': value}) for value in (1, 2))
NUMBER = np.arange(5000.0)
VALUE = None


def reader(value):
    """Return a function that reads `value` from its globals."""
    def read(x):
        return x + VALUE
    return FunctionType(read.__code__, {'VALUE': value})


def inside(module):
    """Return a function whose inner function reads a module of the closure."""
    def read(x):
        def moved(y):
            return y + module.SHIFT
        return moved(x)
    return read


def shifted(shift):
    """Return a module."""
    module = ModuleType('settings')
    module.SHIFT = shift
    return module


def by_default(value):
    """Return a function with a default."""
    def read(x, y=value):
        return x + y[2500]
    return read


def scaled(factor):
    """Return a kernel of a closure of a closure."""
    part = jit.jit_part(lambda x: factor * x)
    return jit.jit_part(lambda x: part(x))


@pytest.mark.parametrize('first, second', [
    (reader(ONE(1.0, 2.0)), reader(TWO(1.0, 2.0))),
    (reader(COLOUR.RED), reader(LIGHT.RED)),
    (reader(np.sqrt), reader(np.cbrt)),
    (reader(np.float32(0.5)), reader(np.float64(0.5))),
    (reader(namedtuple('Pair', 'a', defaults=[1])), reader(namedtuple('Pair', 'a', defaults=[2]))),
    (reader(scaled(1.0)), reader(scaled(2.0))),
    (inside(shifted(1.0)), inside(shifted(2.0))),
    (by_default(NUMBER), by_default(np.where(NUMBER == 2500.0, 0.0, NUMBER)))],
    ids=['names', 'member', 'function', 'width', 'field', 'closure', 'module', 'default'])
def test_a_function_that_reads_another_value_is_another(first, second):
    from gearbox_monitor.kernels.kernel_cache import content
    assert content(first) != content(second)


def test_arguments_of_a_class_that_has_moved_are_compiled_for(monkeypatch, tmp_path):
    monkeypatch.setattr(jit, 'CACHE_FOLDER', str(tmp_path))

    def first(pair):
        return pair.a
    for name in ('one', 'two'):
        module = ModuleType(name)
        module.Pair = namedtuple('Pair', 'a b', module=name)
        monkeypatch.setitem(sys.modules, name, module)
        kernel = jit.jit(first)
        assert kernel(module.Pair(1.0, 2.0)) == 1.0
        assert sum(kernel.stats.cache_hits.values()) == 0
        monkeypatch.delitem(sys.modules, name)


def test_closures_that_two_processes_gave_one_number_are_not_confused(monkeypatch):
    from numba.core.bytecode import FunctionIdentity
    monkeypatch.setattr(FunctionIdentity, '_unique_ids', repeat(10 ** 9))
    monkeypatch.setattr(jit, 'CACHE_FOLDER', None)

    def raised(scale):
        """Return a kernel that calls a closure of `scale`."""
        @jit.jit_shared
        def series(x):
            total = 0.0
            for i in range(int(x)):
                total += scale / (1.0 + total * total + i)
                if total > 1e9:
                    total -= 3.0 * scale
            return total

        @jit.jit
        def twice(x):
            return series(x) + series(x + 3.0) * series(x - 1.0)
        return twice(1.0)
    small = raised(1.0)
    assert raised(100.0) > 10.0 * small
