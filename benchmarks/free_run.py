# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Cost of free runs: one through a recording, its slopes in seven parameters, SciPy's solvers.

The slopes are those that "diagnose" takes: of the innovations of a filter, by its tangents.
solve_ivp gets the same equations in Python, as a user would write them, and of
several solvers the cheapest settings that end within ERROR of the exact motion; ours ends nearer.
"""
from collections.abc import Callable, Mapping
import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.innovations import (
    coordinate_columns, evaluated, halves, InnovationFit, InnovationLikelihood)
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows, Simulator
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals.uniform import UniformRecording

DT, SECONDS, FEW = 1e-3, 16, 1000  # FEW samples are enough for solve_ivp
ERROR = 1e-3                       # rad, after so many
NOISE = (1e-3, 1e-3)
MODEL = DriveModel(tolerance=0.015)  # then all seven nominal values are fitted
SETTINGS: dict[str, dict[str, Any]] = {
    'RK23': {'method': 'RK23', 'max_step': DT, 'rtol': 1e-3, 'atol': 1e-5},
    'LSODA': {'method': 'LSODA', 'rtol': 1e-6, 'atol': 1e-8},
    'RK45': {'method': 'RK45', 'rtol': 1e-8, 'atol': 1e-10}}


def torque() -> Array:
    """Return the torque of the motor (N m), one value per sample."""
    return Excitation().torque(np.arange(SECONDS * round(1.0 / DT)) * DT)


def steppers() -> tuple[dict[str, Callable[[], Any]], dict[str, float]]:
    """Return ({row: function}, {row: samples that it runs over})."""
    u = torque()
    run = simulate(MODEL, u, DT, Noise(measurement=NOISE))
    recording = UniformRecording(run.t, run.u, run.y, DT)
    simulator, whole = Simulator(recording, MODEL), shooting_windows(recording, float(SECONDS))
    likelihood = InnovationLikelihood(
        recording, MODEL, np.array(NOISE), halves([slice(0, len(u))]))
    candidate = Starts(MODEL, [recording]).none()
    at = evaluated(likelihood, InnovationFit(
        candidate, candidate.start(), likelihood.least_noise))
    rows: dict[str, Callable[[], Any]] = {
        'simulate': lambda: simulate(MODEL, u, DT),
        'free run': lambda: simulator.run(whole, MODEL, np.zeros((1, 4)), np.zeros((1, 4))),
        'slopes in 7 parameters': lambda: coordinate_columns(likelihood, at)}
    counts: dict[str, float] = dict.fromkeys(rows, len(u))
    for name, settings in SETTINGS.items():
        rows[f'solve_ivp {name}'] = _solver(u[:FEW], settings)
        counts[f'solve_ivp {name}'] = FEW
    return rows, counts


def _solver(u: Array, settings: Mapping[str, Any]) -> Callable[[], Any]:
    m1, m2 = MODEL.motor_inertia, MODEL.arm_inertia
    d, cv, cc = MODEL.damping, MODEL.viscous_friction, MODEL.coulomb_friction
    alpha, kr = MODEL.friction_sharpness, MODEL.position_gain
    k, b = MODEL.transmission.stiffness, MODEL.transmission.half_gap
    torques, last = u.tolist(), len(u) - 1

    def rates(t: float, x: Array) -> tuple[float, float, float, float]:
        """Return d/dt of the state `x` at time `t`."""
        twist = x[0] - x[1]
        coupled = k * (twist - min(max(twist, -b), b)) + d * (x[2] - x[3])
        friction = cv * x[2] + cc * 2.0 / math.pi * math.atan(alpha * x[2])
        torque = torques[min(int(t / DT), last)]
        return x[2], x[3], (torque - coupled - friction - kr * x[0]) / m1, coupled / m2

    return lambda: solve_ivp(rates, (0.0, len(u) * DT), np.zeros(4), **settings)
