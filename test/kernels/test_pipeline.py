# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Our use of numba's compiler leaves numba as it was for everybody else."""
import operator

import pytest

pytest.importorskip('numba')
from numba import njit  # noqa: E402, I100
from numba.core.errors import TypingError  # noqa: E402
from numba.core.postproc import PostProcessor  # noqa: E402
from numba.core.registry import cpu_target  # noqa: E402
from numba.core.types import float64, Function, int64, string  # noqa: E402

from gearbox_monitor.kernels import pipeline  # noqa: E402
from gearbox_monitor.kernels.jit import jit_anew  # noqa: E402


def test_a_signature_is_looked_up_once_for_each_set_of_flags(monkeypatch):
    looked_up = []

    def look_up(function, context, args, kws):
        looked_up.append(args)
        return own(function, context, args, kws)
    own = pipeline._look_up
    monkeypatch.setattr(pipeline, '_look_up', look_up)
    monkeypatch.setattr(pipeline, '_signatures', {})
    context = cpu_target.typing_context
    context.refresh()
    add = context.resolve_value_type(operator.add)
    for flags in ('a', 'b', 'a'):
        with pipeline.spared_work(flags):
            for args in ((float64, float64), (int64, float64), (float64, float64)):
                assert add.get_call_type(context, args, {}).return_type == float64
    assert looked_up == [(float64, float64), (int64, float64)] * 2
    assert Function.get_call_type is own


def test_numba_is_itself_again_after_code_that_it_refuses():
    own = Function.get_call_type, PostProcessor.run
    with pytest.raises(TypingError):
        jit_anew(lambda x: x + 1.0).compile((string,))
    assert (Function.get_call_type, PostProcessor.run) == own


def test_a_generator_among_kernels_is_compiled_as_ever():
    @njit
    def powers(x, n):
        y = x
        for _ in range(n):
            yield y
            y *= x

    @jit_anew
    def total(x):
        t = 0.0
        for y in powers(x, 3):
            t += y
        return t
    assert total(2.0) == 14.0
