# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash from the motor's torque and encoder alone: the arm is a hidden state.

While the teeth cross the gap the torque moves the motor alone; behind it the motor moves the arm,
too. Where in the motion that happens tells the gap. Each window is fitted by the innovations of a
filter of the whole drive (diagnosis.joint.innovations): gap, stiffness, inertias, friction and
loads together, with priors that are as wide as these values are usually off. The friction of the
arm is fitted like that of the motor: without it the gap would explain how the free arm slows down.
"""
from collections.abc import Sequence
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, Coordinate, NUISANCES, sine_and_cosine)
from gearbox_monitor.diagnosis.joint.innovations import (
    coordinate_columns, evaluated, FilteredFit, fitted, halves, InnovationFit,
    InnovationLikelihood, noise_floor)
from gearbox_monitor.diagnosis.joint.windows import FLANKS
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.backlash.features import Backlash, NotExcited, sides_of, visits_of
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.actuator import TORQUE_OFFSET
from gearbox_monitor.plant.effects.arm_side import (
    ARM_COULOMB, ARM_VISCOUS, GRAVITY, LOAD_TORQUE)
from gearbox_monitor.plant.effects.gearbox import BACKLASH_GAP
from gearbox_monitor.signals.uniform import prepare, RecordingKind, rms_of, UniformRecording

STEP = 2e-3         # s between the readings of a fit: resonances lie below 100 Hz
LONGEST = 20.0      # s of a window that are fitted, its last ones
FIRST, LATER = 20, 8  # iterations of the fit from the model file, and from the window before
SCAN = (0.35, 0.6, 1.0, 1.6, 2.5)  # of the gap so far: where a fit may begin
# Where fits from the model file begin: the same, and the share of the motor's friction on the arm.
# One leads to the likeliest gap in two of five drives; after a window without a gap, by turns.
STARTS = ((0.5, 0.0), (0.5, 0.4), (1.0, 0.0), (1.0, 0.4), (2.0, 0.0), (2.0, 0.4))
BLOCKS = 20         # parts of a window, whose scatter gives the deviation
SHIFT = (-0.9, 10.0)  # relative, of values of the model
# Relative standard deviations of values of the model file.
SPREAD = {'m1': 0.1, 'm2': 0.3, 'D': 0.5, 'Cv': 0.5, 'Cc': 0.5, 'K': 0.5}
# Effects that are fitted, too: (coordinates, scale, prior), both in the rms of the torque, of
# viscous friction at the rms of the speed.
LOADS = {GRAVITY.id: (('As', 'Ac'), 0.1, 1.0), LOAD_TORQUE.id: (('TL',), 0.1, 1.0),
         ARM_COULOMB.id: (('Cac',), 0.1, 0.3), ARM_VISCOUS.id: (('Cav',), 0.1, 0.3),
         TORQUE_OFFSET.id: (('u0',), 0.05, 0.1)}
NOISE = 0.05        # of the torque's rms: torque noise at the start of the first fit
# What is kept of estimates: torque until then, reading of the motor.
COLUMNS = (sample_loop.E_U, sample_loop.E_READING_MOTOR)
TORQUE, READING = range(len(COLUMNS))


class HiddenArm:
    """
    Fits windows of a drive whose arm nobody measures, each from where the last one ended.

    model: the DriveModel, of which the transmission counts as a dead zone. state: of to_list; None
    at the start.
    """

    def __init__(self, model: DriveModel, state: Sequence[float] | None = None) -> None:
        shape = model.transmission
        play = shape.hysteresis_width if shape.kind == 'play' else 0.0
        servo = [e for e in model.effects  # the servo, whose torque is measured
                 if e['id'] not in EFFECTS or EFFECTS[e['id']].location != 'controller']
        self.model = model.with_(kind='dead_zone', half_gap=shape.half_gap + play,
                                 hysteresis_width=0.0, controller=None, arm_load='none',
                                 effects=servo)
        self._state = np.array([0.0] if state is None else state, float)

    def to_list(self) -> list[float]:
        """Return coordinates and torque noise of the last gap; before it, the number of fits."""
        return [float(v) for v in self._state]

    @staticmethod
    def columns(rows: Array) -> Array:
        """Return a copy [N, 2] of the COLUMNS of estimate `rows` [N, N_ESTIMATE]."""
        return rows[:, COLUMNS]

    def fit(self, stamps: Integers, rows: Array, stamp_ns: int) -> Backlash | NotExcited:
        """
        Return the features of a window.

        Args:
            stamps: int64 [N], ns.
            rows: COLUMNS of the estimates [N, 2].
            stamp_ns: end of the window.

        Returns:
            The features, or NotExcited if the motion does not determine the gap.

        """
        if self.model.driven_by == 'position':
            return NotExcited(stamp_ns, 'prescribed')
        try:
            recording = _recording(stamps, rows)
        except InputError as error:
            return NotExcited(stamp_ns, 'as_written', numbers={'text': str(error)})
        torque, travel = float(np.std(recording.u)), float(np.ptp(recording.y[:, 0]))
        sigma, _ = noise_floor(recording, self.model)
        if not (torque > 0.0 and travel > 10.0 * sigma[0] > 0.0):
            return NotExcited(stamp_ns, 'motor_still')
        candidate = _candidate(self.model, recording)
        likelihood = InnovationLikelihood(recording, self.model, sigma,
                                          halves([slice(0, len(recording.u))]))
        likelihood, fit = self._fit(likelihood, candidate, torque)
        states = fit.run.trace.begin[:-1, 0]
        twist = states[:, 0] - states[:, 1]
        i = [c.name for c in candidate.coordinates].index('b')
        half_gap = math.exp(fit.z[i])
        flank, traversals = visits_of(sides_of(twist, half_gap))
        if traversals < LIMITS.traversals:
            return NotExcited(stamp_ns, 'few_teeth', numbers={'count': traversals})
        P = fit.run.trace.covariance
        sure = half_gap / math.sqrt(float(np.median(P[:, 0, 0] + P[:, 1, 1] - 2.0 * P[:, 0, 1])))
        if sure < LIMITS.contradicted:
            return NotExcited(stamp_ns, 'unclear_flank', numbers={'count': sure})
        covariance = _covariance(likelihood, fit)
        std = np.sqrt(np.diag(covariance))
        if not std[i] < LIMITS.hidden_std:
            return NotExcited(stamp_ns, 'unclear_reversals',
                              numbers={'std': float(min(std[i], 9.99))})
        self._state = np.concatenate([fit.z, fit.torque])
        change, deviation = ({c.name: float(v) for c, v in zip(candidate.coordinates, values)}
                             for values in (fit.z, std))
        model, nan = self.model, math.nan
        viscous, coulomb = model.viscous_friction, model.coulomb_friction
        stiffness = model.transmission.stiffness * (1.0 + change['K'])
        return Backlash(
            stamp_ns=stamp_ns, gap=2.0 * half_gap, gap_std=2.0 * half_gap * float(std[i]),
            stiffness=stiffness, stiffness_std=model.transmission.stiffness * deviation['K'],
            flank=flank, coverage=float(traversals),
            viscous=viscous * change['Cv'] if 'Cv' in change else nan,
            viscous_std=viscous * deviation.get('Cv', nan),
            coulomb=coulomb * change['Cc'] if 'Cc' in change else nan,
            coulomb_std=coulomb * deviation.get('Cc', nan),
            angle=float(recording.y[:, 0].mean()), speed=rms_of(states[:, 2]),
            load=rms_of(stiffness * np.maximum(np.abs(twist) - half_gap, 0.0)))

    def _fit(self, likelihood: InnovationLikelihood, candidate: CandidateModel,
             torque: float) -> tuple[InnovationLikelihood, FilteredFit]:
        """Return the `likelihood` as it begins on the likeliest flanks, and its fit."""
        first = len(self._state) != len(candidate.coordinates) + 2
        if not first:
            z, noise = self._state[:-2], self._state[-2:]
            likelihood = _on_flanks(likelihood, InnovationFit(candidate, z, noise))
            starts = [min((evaluated(likelihood, InnovationFit(
                candidate, self._begin(candidate, z, factor), noise)) for factor in SCAN),
                key=lambda fit: fit.deviance).alone()]
        else:
            tried = self._state[0] if len(self._state) == 1 else 0.0  # else of another model
            turn = int(tried) % len(STARTS)
            self._state = np.array([tried + 1.0])
            starts = [InnovationFit(candidate, self._begin(candidate, candidate.start(), *start),
                                    np.full(2, NOISE * torque))
                      for start in (STARTS[turn:turn + 1] if turn else STARTS)]
        fit = min((fitted(likelihood, start, LATER) for start in starts),
                  key=lambda fit: fit.deviance)
        likelihood = _on_flanks(likelihood, fit)
        return likelihood, evaluated(
            likelihood, fitted(likelihood, fit, FIRST if first else LATER))

    def _begin(self, candidate: CandidateModel, z: Array, factor: float, share: float = 0.0
               ) -> Array:
        """Return `z` [P] with another gap, and a share of the motor's friction on the arm."""
        model = self.model
        moves = {'b': math.log(factor), 'Cv': -share, 'Cc': -share,
                 'Cav': share * model.viscous_friction, 'Cac': share * model.coulomb_friction}
        return candidate.bounded(z + [moves.get(c.name, 0.0) for c in candidate.coordinates])


def _recording(stamps: Integers, rows: Array) -> UniformRecording:
    """Return the end of a window as a recording of the motor. Raises InputError."""
    if len(rows) < 2:
        raise InputError('no estimates')
    newest = stamps >= stamps[-1] - round(LONGEST * sample_loop.SECOND)
    stamps, rows = stamps[newest], rows[newest]
    u = np.append(rows[1:, TORQUE], rows[-1, TORQUE])  # that acts from now on
    y = np.column_stack([rows[:, READING], np.full(len(rows), np.nan)])
    recording, _ = prepare(stamps, u, y, kind=RecordingKind(one_encoder=True))
    stride = max(1, math.floor(STEP / recording.dt + 0.01))
    count = len(recording.u) // stride
    u = recording.u[:count * stride].reshape(count, stride).mean(axis=1)
    return UniformRecording(recording.t[:count * stride:stride], u,
                            recording.y[:count * stride:stride], stride * recording.dt,
                            channels=(0,))


def _candidate(model: DriveModel, recording: UniformRecording) -> CandidateModel:
    """Return what is fitted to the window of a `recording`."""
    torque = float(np.std(recording.u))
    speed = rms_of(np.gradient(recording.y[:, 0], recording.dt))
    ids = [name for name in LOADS if model.axis == 'rotary' or name != GRAVITY.id]
    coordinates = [Coordinate(-1, name, 0.0, spread, *SHIFT, prior=spread)
                   for name, spread in SPREAD.items() if model.value(NUISANCES[name])]
    for i, name in enumerate(ids):
        parameters, scale, prior = LOADS[name]
        own = [sine_and_cosine(name, e) if name == GRAVITY.id else e
               for e in model.effects if e['id'] == name]
        low = 0.0 if name in (ARM_COULOMB.id, ARM_VISCOUS.id) else -math.inf
        size = torque / speed if name == ARM_VISCOUS.id else torque
        coordinates += [Coordinate(i, parameter, sum(e[parameter] for e in own), scale * size,
                                   low, prior=prior * size) for parameter in parameters]
    shape = model.transmission
    smallest = LIMITS.hidden_gap * torque / shape.stiffness
    start = max(shape.half_gap, 100.0 * smallest)
    coordinates.append(Coordinate(len(ids), 'b', start, 0.2, smallest, 1e6 * smallest, True))
    return CandidateModel(model, (*ids, BACKLASH_GAP.id), tuple(coordinates))


def _on_flanks(likelihood: InnovationLikelihood, fit: InnovationFit) -> InnovationLikelihood:
    """
    Return a `likelihood` whose parts begin where a `fit` is likeliest: on a flank or between both.

    A filter that begins on the wrong flank does not return without torque noise.
    """
    gear, std = fit.model.transmission, np.sqrt(likelihood.begin_variance)
    twist = gear.half_gap + 0.5 * float(np.std(likelihood.recording.u)) / gear.stiffness
    begun = likelihood.run(fit.model, fit.torque).trace.begin[likelihood.begin, 0, :4]
    begins = np.repeat(begun[None], len(FLANKS), axis=0)
    begins[:, :, 1] = begun[:, 0] - twist * np.array(FLANKS)[:, None]
    runs = [likelihood.begun(states, std).run(fit.model, fit.torque) for states in begins]
    deviances = np.array([[run.deviances[begin:end].sum() for begin, end in zip(
        likelihood.begin, likelihood.end)] for run in runs])
    likeliest = np.nan_to_num(deviances, nan=np.inf).argmin(axis=0)
    return likelihood.begun(begins[likeliest, np.arange(len(begun))], std)


def _covariance(likelihood: InnovationLikelihood, fit: FilteredFit) -> Array:
    """
    Return the covariance [P, P] of the coordinates of a `fit`.

    By the scatter of the scores over parts of the window, where that is larger than what white
    innovations would give: a model that is wrong leaves ones that are not.
    """
    columns = coordinate_columns(likelihood, fit)
    _, weight = fit.candidate.prior(fit.z)
    inverse = covariance(columns.T @ columns + np.diag(weight))
    scores = columns * fit.run.residual.ravel()[:, None]
    at = np.arange(len(scores)) * BLOCKS // len(scores)
    blocks = np.stack([np.bincount(at, scores[:, i], BLOCKS) for i in range(scores.shape[1])],
                      axis=1)
    scattered = inverse @ (blocks.T @ blocks + np.diag(weight)) @ inverse
    factor = np.sqrt(np.maximum(np.diag(scattered) / np.diag(inverse), 1.0))
    result: Array = inverse * np.outer(factor, factor)
    return result
