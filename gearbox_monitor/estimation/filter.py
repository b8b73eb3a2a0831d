# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
One filter by itself, for a loop of one's own: a call per sample, and nothing but the recursion.

No check of stamps and readings, no smoother: those are the Estimator's, whose numbers are the same
as long as neither of them has anything to do.
"""
import math
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.consider import accompany, Companions, restart, variances_of
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.filter_kind import Belief, filter_kind, Reading, Scratch
from gearbox_monitor.estimation.filter_setup import loop_arrays
from gearbox_monitor.estimation.process_model import TAU_K_MODEL_STD, torque_of
from gearbox_monitor.estimation.sample_loop import Chosen
from gearbox_monitor.estimation.step_record import correction, sensitivities
from gearbox_monitor.kernels.kernel import entry, prepared
from gearbox_monitor.kernels.types import Layout, Pair, Values, Vector
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel


@entry
def _call(layout: Layout, chosen: Chosen, belief: Belief, p: Vector, scratch: Scratch,
          record: Vector, companions: Companions, previous: Vector, dt: float, u: float,
          load: float, y1: float, y2: float) -> bool:
    """Step the `chosen` filter; previous [>= n]: scratch."""
    reading = Reading(dt, u, load, y1, y2)
    for i in range(layout.n):
        previous[i] = belief.z[i]
    if not math.isfinite(companions.s[-1]):  # the first step
        sample_loop.aim(layout, belief, reading, p)
    if not sample_loop.filter_step(chosen, layout, belief, reading, p, scratch, record):
        return False
    return accompany(layout, companions, previous, reading,
                     sample_loop.in_use(chosen, belief.memory, p), record)


def _expect_numbers(**values: Any) -> None:
    """Raise InputError for the first of `values` that is not one number."""
    for name, value in values.items():
        if not isinstance(value, (int, float, np.number)):
            raise InputError(f'{name}: {type(value).__name__} {str(value)[:40]!r}, expected one '
                             'number') from None


class Filter:
    """
    The filter that `parameters` choose (names as of Estimator) for the DriveModel `model`.

    names: of the n states. z [n], P [n, n]: belief, x1, x2 in rad, x3, x4 in rad/s, torques in
    N m. innovation [2] (rad), S [3] as s11, s12, s22, K [n, 2]: of the last step.
    Raises InputError as Estimator does, and for a mixture of models, which an Estimator has.
    """

    def __init__(self, model: DriveModel,
                 parameters: EstimatorParameters | Values | None = None) -> None:
        estimator = Estimator(model, unsmoothed(parameters))
        if estimator.members:
            raise InputError('tau_k_model: mixed, expected random_walk, elastic or learned: a '
                             'Filter is one filter, an Estimator mixes several')
        self.names, self.parameters = estimator.names, estimator.parameters
        self._states = estimator.states
        n, kind = len(estimator.names), filter_kind(estimator.parameters.filter)
        self._belief, scratch, state = loop_arrays(kind, n, 1, estimator.drive)
        self._packed, self._companions = estimator.packed, state.companions
        self._record = state.ring[0]
        self.z, self.P = self._belief.z, self._belief.P.reshape(n, n)
        self.z[:] = math.nan  # until start
        self.innovation, self.S, self.K, self._scores = correction(self._record, n)
        self._step = prepared(_call, self._states, sample_loop.CHOICES[kind.name], self._belief,
                              self._packed, scratch, self._record, self._companions, state.saved)

    def start(self, y1: float, y2: float) -> None:
        """Restart at the motor and arm position y1, y2 (rad on the arm side); NaN: unknown."""
        self._belief.memory[:] = 0.0
        restart(self._companions)
        _expect_numbers(y1=y1, y2=y2)
        sample_loop.start(self._states, self._belief, y1, y2, self._packed, self._record)

    def step(self, dt: float, u: float, y1: float, y2: float, load: float = 0.0) -> bool:
        """
        Predict and update.

        Args:
            dt: time since the last step or the start, s.
            u: motor torque over that time, N m.
            y1: motor and arm position at its end, rad on the arm side; NaN: unknown.
            y2: motor and arm position at its end, rad on the arm side; NaN: unknown.
            load: known torque on the arm, N m.

        Returns:
            False if the filter has diverged or is not started: then z and P mean nothing, and
            start() restarts it.

        """
        try:
            return bool(self._step(dt, u, load, y1, y2))
        except Exception:
            _expect_numbers(dt=dt, u=u, y1=y1, y2=y2, load=load)
            raise

    @property
    def tau_k(self) -> float:
        """Transmission torque, N m."""
        return float(self._torque()[0])

    @property
    def tau_k_std(self) -> float:
        """Standard deviation of tau_k, N m."""
        _, _, at_s, _ = sensitivities(len(self.z), len(self._record))
        _, _, of_model = variances_of(self._states, self.z, self._record, at_s, self._packed)
        return math.sqrt(self._torque()[1] + of_model + self._packed[TAU_K_MODEL_STD] ** 2)

    def _torque(self) -> Pair:
        return torque_of(self._states, self.z, self._belief.P, self._packed)

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last step."""
        return float(self._scores[0])
