# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Motions for recordings: torque alone, or a controller that follows a path."""
from collections.abc import Callable

import numpy as np

from benchmarks.blind.plant import DriveMotion
from gearbox_monitor.kernels.types import Array

KINDS = ('multisine', 'chirp', 'steps', 'rbs', 'trapezoid', 'triangle', 'wide', 'tri_sine')
LIMIT = 8.0  # N m
SETPOINT_KINDS = ('sines', 'steps', 'trapezoid', 'triangle', 'wide')


def _uniform_log(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _held(random: np.random.Generator, n: int, dt: float, shortest: float, longest: float,
          level: Callable[[], float]) -> Array:
    """Return [n] values of level(), each held for a random time."""
    out, k = np.empty(n), 0
    while k < n:
        length = max(1, int(random.uniform(shortest, longest) / dt))
        out[k:k + length] = level()
        k += length
    return out


def _triangle(t: Array, rate: float) -> Array:
    return 1.0 - 4.0 * np.abs(np.mod(t * rate + 0.25, 1.0) - 0.5)


def draw(kind: str, random: np.random.Generator, n: int, dt: float) -> DriveMotion:
    """
    Draw a motion: feed-forward torque [n], controller, reference [n, 2].

    Args:
        kind: one of KINDS.
        random: source of random numbers.
        n: samples.
        dt: sample time, s.

    Raises:
        ValueError: for another kind.
    """
    t = np.arange(n) * dt
    u: Array = np.zeros(n)
    path: Array = np.zeros(n)
    control = [random.uniform(2.0, 8.0), random.uniform(0.05, 0.25), LIMIT, 0]
    amplitude = random.uniform(1.0, 3.5)
    soft = [random.uniform(0.2, 1.5) if random.random() < 0.5 else 0.0, 0.0, LIMIT,
            int(random.random() < 0.3)]
    if kind == 'multisine':
        control = soft
        rates = np.array([_uniform_log(random, 0.4, 6.0) for _ in range(random.integers(2, 5))])
        parts = random.uniform(0.4, 1.0, len(rates))
        parts *= 1.5 * amplitude / parts.sum()
        u = sum(a * np.cos(2 * np.pi * f * t + random.uniform(-0.5, 0.5))
                for a, f in zip(parts, rates))
    elif kind == 'chirp':
        control = soft
        low, high = random.uniform(0.3, 0.8), random.uniform(4.0, 10.0)
        end = t[-1]
        u = amplitude * np.cos(2 * np.pi * (low * t + 0.5 * (high - low) / end * t * t))
    elif kind == 'rbs':
        control = soft
        clock = random.uniform(0.04, 0.15)
        u = amplitude * _held(random, n, dt, clock, 3 * clock,
                              lambda: random.choice([-1.0, 1.0]))
    elif kind == 'steps':
        size = random.uniform(0.6, 2.5)
        path = _held(random, n, dt, 0.3, 1.0, lambda: random.uniform(-size, size))
        control[0] = random.uniform(1.5, 4.0)
    elif kind == 'trapezoid':
        reach, speed, slope = (random.uniform(0.8, 4.0), random.uniform(3.0, 12.0),
                               random.uniform(30.0, 120.0))
        goal = _held(random, n, dt, 0.5, 1.4, lambda: random.uniform(-reach, reach))
        v = 0.0
        for k in range(1, n):  # speed- and acceleration-limited
            distance = goal[k] - path[k - 1]
            wish = np.sign(distance) * min(speed, np.sqrt(2.0 * slope * abs(distance)))
            v += np.clip(wish - v, -slope * dt, slope * dt)
            path[k] = path[k - 1] + v * dt
    elif kind == 'triangle':
        path = random.uniform(1.0, 4.0) * _triangle(t, random.uniform(0.2, 0.7))
    elif kind == 'wide':
        path = random.uniform(3.5, 7.0) * np.sin(2 * np.pi * random.uniform(0.2, 0.5) * t)
        path += random.uniform(0.3, 1.0) * np.sin(2 * np.pi * random.uniform(0.9, 2.0) * t)
    elif kind == 'tri_sine':
        path = random.uniform(1.0, 3.0) * _triangle(t, random.uniform(0.15, 0.4))
        u = 0.6 * amplitude * np.sin(2 * np.pi * random.uniform(1.5, 6.0) * t)
    else:
        raise ValueError(kind)
    kp, kd, limit, channel = control
    return u, (kp, kd, limit, channel), np.column_stack([path, np.gradient(path, dt)])


def setpoint(kind: str, random: np.random.Generator, n: int, dt: float, period: int) -> Array:
    """
    Draw a setpoint [n], rad.

    Args:
        kind: one of SETPOINT_KINDS.
        random: source of random numbers.
        n: samples.
        dt: sample time, s.
        period: samples over which each value is held.
    """
    if kind == 'sines':
        t = np.arange(n) * dt
        rates = np.array([_uniform_log(random, 0.3, 4.0) for _ in range(random.integers(2, 5))])
        parts = random.uniform(0.4, 1.0, len(rates)) / rates
        parts *= random.uniform(0.6, 2.5) / parts.sum()
        path = sum(a * np.sin(2 * np.pi * f * t + random.uniform(-3.0, 3.0))
                   for a, f in zip(parts, rates))
    else:
        path = draw(kind, random, n, dt)[2][:, 0]
    held: Array = np.asarray(path)[np.arange(n) // period * period]
    return held
