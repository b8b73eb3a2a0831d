# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The innovation filter of linear drives against the joint Gaussian of all their readings."""
from dataclasses import dataclass, replace
from functools import cache
import math

import numpy as np
import pytest
from scipy.linalg import block_diag, expm, solve_triangular
from scipy.stats import multivariate_normal

from gearbox_monitor.diagnosis.joint.innovations import InnovationLikelihood
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.signals.uniform import UniformRecording

SIDES, SIGMA = ('motor', 'arm'), np.array([1e-3, 2e-3])
LOOSE = DriveModel(coulomb_friction=0.0, viscous_friction=0.2, damping=0.03, position_gain=0.4,
                   transmission=Transmission(half_gap=0.0))
RIGID = replace(LOOSE, transmission=Transmission(kind='rigid'))
BEGIN = np.array([0.02, 0.05, 0.4, 0.3])  # standard deviations of states where parts begin
SPANS = (slice(2, 25), slice(25, 44), slice(47, 84))  # 84 samples: more than twice the lanes
NOISE, OTHER = (0.3, 0.1), (0.2, 0.25)


@dataclass(frozen=True)
class Case:
    """
    A drive, its encoders, how late they are, and how long unexplained torque lasts (s).

    size: of all motion and noise; small enough, an encoder off centre by `scale` reads x (1 +
    scale).
    """

    model: DriveModel = LOOSE
    channels: tuple[int, ...] = (0, 1)
    late: tuple[float, float] = (0.0, 0.0)
    lasts: float = 0.0
    every: int = 1
    dt: float = 1e-3
    scale: tuple[float, float] = (0.0, 0.0)
    size: float = 1.0

    @property
    def drive(self):
        late = [{'id': f'{side}_encoder_delay', 'T': T} for side, T in zip(SIDES, self.late) if T]
        off = [{'id': f'{side}_encoder_eccentricity', 'A': abs(A),
                'phi': 0.0 if A > 0.0 else math.pi} for side, A in zip(SIDES, self.scale) if A]
        return replace(self.model, process_torque_time=self.lasts, effects=(*late, *off))

    @property
    def sigma(self):
        return self.size * SIGMA


CASES = {
    'loose': Case(), 'one encoder': Case(channels=(1,)), 'rigid': Case(RIGID),
    'late motor': Case(late=(3.4e-3, 0.0), dt=2e-3), 'late arm': Case(late=(0.0, 1.3e-3)),
    'both late': Case(late=(0.7e-3, 2.4e-3), every=3),
    'rigid and late': Case(RIGID, late=(0.0, 4e-4)),
    'lasting': Case(lasts=0.02, every=2), 'lasting and late': Case(late=(6e-4, 0.0), lasts=0.02),
    'rigid, lasting and late': Case(RIGID, late=(0.0, 2.3e-3), lasts=0.02),
    'off centre': Case(late=(7e-4, 0.0), scale=(0.5, -0.3), size=1e-4)}


@cache
def likelihood_of(case):
    """Return the likelihood of noisy readings of a motion of no drive in particular."""
    random = np.random.default_rng(7)
    t = np.arange(SPANS[-1].stop) * case.dt
    u = 2.0 * case.size * random.standard_normal(len(t))
    y = 0.1 * case.size * np.column_stack([np.sin(40.0 * t), np.sin(40.0 * t - 0.3)])
    y += case.sigma * random.standard_normal(y.shape)
    recording = UniformRecording(t, u, y, case.dt,
                                 case.size * random.standard_normal(len(t)),
                                 channels=case.channels)
    states = 0.05 * case.size * random.standard_normal((len(SPANS), 4))
    if case.model is RIGID:
        states = states[:, [0, 0, 2, 2]]
    likelihood = InnovationLikelihood(recording, case.drive, case.sigma, SPANS, finer=8)
    begin = BEGIN if case.model is LOOSE else BEGIN[[0, 0, 2, 2]]
    return likelihood.begun(states, case.size * begin).changed(every=case.every)


@cache
def dynamics(case, span):
    """Return (F [5, 5], inputs [5, 2] of torque on motor and arm): x1, x2, x3, x4, what lasts."""
    m, k, r = case.model, case.model.transmission.stiffness, case.model.position_gain
    A, m1, m2 = np.zeros((6, 6)), m.motor_inertia, m.arm_inertia
    A[0, 2] = A[1, 3] = 1.0
    if case.model is RIGID:
        A[[[2], [3]], [0, 2, 4, 5]] = np.array(
            [-r, -m.viscous_friction, 1.0, 1.0]) / (m1 + m2)
    else:
        A[2] = np.array([-k - r, k, -m.damping - m.viscous_friction, m.damping, 1.0, 0.0]) / m1
        A[3] = np.array([k, -k, m.damping, -m.damping, 0.0, 1.0]) / m2
    step = expm(A * span)
    F = step[:5, :5].copy()
    F[4] = [0.0, 0.0, 0.0, 0.0, math.exp(-span / case.lasts) if case.lasts else 0.0]
    return F, np.vstack([step[:4, 4:], [0.0, 0.0]])


def process_noise(case, F, span, torque):
    """Return the covariance [5, 5] that torque noise adds in a segment."""
    Q, m1, m2 = np.zeros((5, 5)), case.model.motor_inertia, case.model.arm_inertia
    kicks = np.array([torque[0] / m1 * (1.0 + F[2, 2]), 0.0]), np.array(
        [0.0, torque[1] / m2 * (1.0 + F[3, 3])])
    if case.model is RIGID:
        kicks = (np.full(2, torque[0] / (m1 + m2) * (1.0 + F[2, 2])), np.zeros(2))
    for side, kick in enumerate(kicks):
        if side or not case.lasts:
            v = np.outer(kick, kick) * 0.25 * case.dt * span
            Q[:4, :4] += np.kron([[span ** 2 / 3.0, span / 2.0], [span / 2.0, 1.0]], v)
    if case.lasts:
        Q[4, 4] = torque[0] ** 2 * (1.0 - math.exp(-2.0 * span / case.lasts))
    return Q


@dataclass(frozen=True)
class Dense:
    """
    What the readings of a part say together.

    deviance; order: [(sample, channel)] of the readings; white: innovations in their deviations;
    smoothed [K, 5] states.
    """

    deviance: float
    order: list
    white: np.ndarray
    smoothed: np.ndarray


def dense(case, likelihood, part, torque, offset=(0.0, 0.0), load=(0.0, 0.0)):
    """Return the Dense of a part; `offset` (rad) of the encoders and `load` (N m) are added."""
    recording, dt, span = likelihood.recording, case.dt, SPANS[part]
    lag = np.array(case.late) / dt
    whole = np.floor(lag + 1e-9).astype(int)
    at = 1.0 - (lag - whole)
    ends = sorted({*np.round([at[i] for i in case.channels], 9).tolist(), 1.0})
    begin = likelihood.begin_variance[[0, 1, 2, 3]]
    sources = [np.diag([*begin, likelihood._torque ** 2 if case.lasts else 0.0])]
    if case.model is RIGID:
        sources[0][[0, 1, 2, 3], [1, 0, 3, 2]] = begin
    mean = np.array([*likelihood._states[part, :4], 0.0])
    steps = len(ends) * (span.stop - span.start - 1)
    L = np.zeros((5, 5 * (steps + 1)))
    L[:, :5] = np.eye(5)
    rows, expected, order, begun = [], [], [], []
    for k in range(span.start, span.stop):
        begun.append((mean, L))
        if k == span.stop - 1:
            break
        for end, length in zip(ends, np.diff([0.0, *ends]) * dt):
            F, B = dynamics(case, length)
            mean = F @ mean + B @ (np.array([recording.u[k], -recording.arm_torque[k]])
                                   + case.size * np.array(load))
            L = F @ L
            L[:, 5 * len(sources):5 * len(sources) + 5] = np.eye(5)
            sources.append(process_noise(case, F, length, torque))
            for i in case.channels:
                reading = k + 1 + whole[i]
                if (abs(at[i] - end) < 1e-6 and reading < span.stop
                        and reading % case.every == 0):
                    order.append((k, i))
                    rows.append((1.0 + case.scale[i]) * L[i])
                    expected.append((1.0 + case.scale[i]) * mean[i] + case.size * offset[i])
    C, covariance = np.array(rows), block_diag(*sources)
    y = np.array([recording.y[k + 1 + whole[i], i] for k, i in order])
    variance = case.sigma[[i for _, i in order]] ** 2
    S = C @ covariance @ C.T + np.diag(variance)
    deviance = (-2.0 * multivariate_normal(expected, S).logpdf(y)
                - np.sum(1.0 + np.log(2.0 * math.pi * variance)))
    white = solve_triangular(np.linalg.cholesky(S), y - expected, lower=True)
    pull = covariance @ C.T @ np.linalg.solve(S, y - expected)
    return Dense(deviance, order, white, np.array([mean + L @ pull for mean, L in begun]))


def test_innovations_likelihood_and_smoothed_states_are_those_of_the_joint_gaussian():
    """Also after a change of the noise alone: the tangent of a linear drive is exact."""
    for name in CASES:
        case = CASES[name]
        likelihood = likelihood_of(case)
        noise, other = case.size * np.array([NOISE, OTHER])
        run = likelihood.run(case.drive, noise)
        for torque, deviance, innovation, variance in (
                (other, *likelihood.with_noise(run, other)),
                (noise, run.deviance, run.innovation, run.variance)):
            parts = [dense(case, likelihood, part, torque) for part in range(len(SPANS))]
            expected, read = np.zeros_like(run.innovation), np.zeros_like(run.innovation, bool)
            for part in parts:
                at = tuple(np.array(part.order).T)
                expected[at], read[at] = part.white, True
            assert deviance == pytest.approx(sum(part.deviance for part in parts), rel=1e-6)
            np.testing.assert_allclose(innovation / np.sqrt(variance), expected, atol=1e-5)
            assert (run.read == read).all() and (variance[~read] == 1.0).all()
        smoothed = likelihood.smoothed(run)
        for span, part in zip(SPANS, parts):
            np.testing.assert_allclose(smoothed[span, :4], part.smoothed[:, :4],
                                       atol=1e-5 * case.size)
        assert np.isnan(smoothed[44:47]).all() and np.isnan(smoothed[:2]).all()


def test_inputs_and_offsets_change_innovations_as_in_the_joint_gaussian():
    for name in CASES:
        case = CASES[name]
        likelihood = likelihood_of(case)
        noise = case.size * np.array(NOISE)
        run = likelihood.run(case.drive, noise)
        model = replace(case.drive, effects=(
            *case.drive.effects, {'id': 'torque_offset', 'u0': 0.1 * case.size},
            {'id': 'load_torque', 'TL': 0.2 * case.size},
            {'id': 'encoder_offset', 'c': 0.01 * case.size}))
        residual = run.residual + likelihood.change(run, model) / np.sqrt(run.variance)
        for part in range(len(SPANS)):
            moved = dense(case, likelihood, part, noise, (0.0, 0.01), (0.1, -0.2))
            np.testing.assert_allclose(residual[tuple(np.array(moved.order).T)], moved.white,
                                       atol=2e-5)


FAR_OFF = [
    ([0.9e6, 0.9e6], True), ([-0.9e6, -0.9e6], True), ([1.1e6, 0.9e6], False),
    ([0.9e6, 1.1e6], False), ([-1.1e6, -0.9e6], False), ([math.nan, 0.0], False),
    ([0.0, math.nan], False)]


def test_a_filter_that_is_far_off_has_diverged():
    """Of either side; a stiffness of nearly nothing lets each be where it is."""
    for begin, follows in FAR_OFF:
        soft = replace(LOOSE, transmission=Transmission(half_gap=0.0, stiffness=1e-9))
        likelihood = likelihood_of(CASES['loose'])
        states = np.zeros((3, 4))
        states[1, :2] = begin
        run = likelihood.begun(states, np.full(4, 1e-3)).run(soft, NOISE)
        assert math.isfinite(run.deviance) == follows
