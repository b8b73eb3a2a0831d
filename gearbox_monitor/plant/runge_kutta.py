# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Integrators of the drive, in one place for its kernels.

The classical Runge-Kutta method of fourth order, and the semi-implicit steps of simulators.
"""
from collections.abc import Callable
from typing import Any, TypeAlias


Four: TypeAlias = tuple[float, float, float, float]


def integrator(derivative: Callable[..., Four], memories: Callable[..., Any],
               brake: Callable[..., tuple[float, float]]) -> Callable[..., tuple[Four, Any]]:
    """
    Return a compiled step: of the classical Runge-Kutta method (Kutta, 1901), or semi-implicit.

    Memories of effects are stiff, and exact for a constant speed: in each stage they are advanced
    by `memories` from the begin of the step at the speed of the stage before.

    A semi-implicit step has the accelerations of its begin, with linear damping at its end, and
    moves with the speeds of its end.

    Args:
        derivative: (t, x, m, inputs) -> (x1', x2', x3', x4') at time t (s), state x, memories m.
        memories: (m, x, x3, x4, h, inputs) -> m after h s from state x at the speeds x3, x4.
        brake: (h, x, m, inputs) -> factors on the accelerations of motor and arm by damping in a
            semi-implicit step; 0.0 for the Runge-Kutta method.

    Returns:
        A function (t, x, m, h, inputs) -> (changes of the four states, m after the step).
    """
    def step(t: float, x: Four, m: Any, h: float, inputs: Any) -> tuple[Four, Any]:
        x1, x2, x3, x4 = x
        half = 0.5 * h
        a1, a2, a3, a4 = derivative(t, x, m, inputs)
        motor, arm = brake(h, x, m, inputs)
        if motor != 0.0:
            v1, v2 = x3 + h * motor * a3, x4 + h * arm * a4
            change = (h * v1, h * v2, h * motor * a3, h * arm * a4)
            return change, memories(m, x, v1, v2, h, inputs)
        b1, b2, b3, b4 = derivative(
            t + half, (x1 + half * a1, x2 + half * a2, x3 + half * a3, x4 + half * a4),
            memories(m, x, a1, a2, half, inputs), inputs)
        c1, c2, c3, c4 = derivative(
            t + half, (x1 + half * b1, x2 + half * b2, x3 + half * b3, x4 + half * b4),
            memories(m, x, b1, b2, half, inputs), inputs)
        d1, d2, d3, d4 = derivative(
            t + h, (x1 + h * c1, x2 + h * c2, x3 + h * c3, x4 + h * c4),
            memories(m, x, c1, c2, h, inputs), inputs)
        v1, v2 = (a1 + 2.0 * b1 + 2.0 * c1 + d1) / 6.0, (a2 + 2.0 * b2 + 2.0 * c2 + d2) / 6.0
        change = (h * v1, h * v2, h / 6.0 * (a3 + 2.0 * b3 + 2.0 * c3 + d3),
                  h / 6.0 * (a4 + 2.0 * b4 + 2.0 * c4 + d4))
        return change, memories(m, x, v1, v2, h, inputs)
    return step
