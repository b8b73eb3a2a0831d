# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Mix the estimates of filters with different laws of tau_K by the likelihood of their innovations.

The filters run side by side and do not know of each other. Their weights are the probabilities of
their models (Blom and Bar-Shalom 1988, interacting multiple models, without the exchange of
states): between samples a model gives up a share of its probability to the others, at a sample
Bayes' rule applies. The mixed estimate has the mean and the covariance of the mixture. A model
whose curve is wrong predicts worse, and within tenths of a second it counts no more.

The first filter, the random walk, leads: what becomes of a sample is what becomes of it there. A
filter that refuses a sample or diverges is left out until it goes on.
"""
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.estimation.filter_kind import filter_kind
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TAU_K_NOISE_STD, S_TAU_K_STD,
    S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE, S_TWIST_RATE_NOISE_STD, S_TWIST_RATE_STD,
    S_TWIST_STD, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.estimation.sample_loop import (
    E_DOF, E_DT, E_ELASTIC_WEIGHT, E_HYSTERESIS_STD, E_INNOVATION_ARM, E_INNOVATION_COVARIANCE,
    E_INNOVATION_MOTOR, E_INNOVATION_STD_ARM, E_INNOVATION_STD_MOTOR, E_LEARNED_WEIGHT, E_LOAD,
    E_LOGLIK, E_MOTOR_SIDE_NOISE_STD, E_NIS, E_READING_MOTOR, E_STD, E_STIFFNESS, E_TAU_K,
    E_TAU_K_NOISE_STD, E_TWIST, E_TWIST_RATE, E_TWIST_RATE_STD, E_TWIST_STD, E_U, E_WHITE_1,
    E_WHITE_2, ESTIMATE, N_ESTIMATE, Output, SECOND, START, write_innovation)
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import (
    Array, Cube, IntegerMatrix, Integers, Matrix, Pair, Vector)
from gearbox_monitor.parameters import CURVES, EstimatorParameters, MIXED, RANDOM_WALK

MEMBERS = (RANDOM_WALK, *CURVES)
M = len(MEMBERS)
# After so long, s, evidence is forgotten: a gearbox may change. What the wrong models keep by it
# is their share of every estimate, so it is far longer than the tenths of a second that telling
# two models apart takes.
SWITCHING_TIME = 100.0
# The learned curve has diverged where the probability of the random walk, averaged over so
# long (s), is this high: a gap wider than the twist, say, feels nothing that would narrow it. It
# then begins once more.
LOST_AFTER, LOST = 3.0, 0.9
CHUNK = 2048  # samples that are mixed at a time, at most
KEPT = 8192  # weights at hand for the smoother: more than a chunk and its ring of steps
WRITTEN, READ, BEGUN = range(3)
# Columns of a mean and its deviation.
MOMENTS = np.array([*((i, E_STD + i) for i in range(7)), (E_TWIST, E_TWIST_STD),
                    (E_TWIST_RATE, E_TWIST_RATE_STD), (E_TAU_K, E_TAU_K_NOISE_STD),
                    (E_TAU_K, E_MOTOR_SIDE_NOISE_STD)])
SMOOTHED_MOMENTS = np.array([
    (S_TWIST, S_TWIST_STD), (S_TWIST_RATE, S_TWIST_RATE_STD), (S_TAU_K, S_TAU_K_STD),
    (S_TWIST, S_TWIST_NOISE_STD), (S_TWIST_RATE, S_TWIST_RATE_NOISE_STD),
    (S_TAU_K, S_TAU_K_NOISE_STD), (S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD)])


class Mixture(NamedTuple):
    """
    What mixing carries from sample to sample; all arrays are changed in place.

    weights [M]: probability of each model. alone [2]: that of the random walk, averaged, and the
    whole second of the last stamp. stamps int64 [KEPT] and history
    [KEPT, M]: weights of the last samples, in turn; places int64 [3]: how many were written, where
    the smoother reads next, and where the last start stands. prior [M], aligned [M, N_SMOOTHED],
    next_row int64 [M]: scratch.
    """

    weights: Vector
    alone: Vector
    stamps: Integers
    history: Matrix
    places: Integers
    prior: Vector
    aligned: Matrix
    next_row: Integers


class Outputs(NamedTuple):
    """
    What the M filters wrote on up to CHUNK samples.

    codes int64 [M, CHUNK]; rows [M, CHUNK, N_ESTIMATE]; smoothed_stamps int64 [M, L] and smoothed
    [M, L, N_SMOOTHED], of which the first n_smoothed int64 [M] count.
    """

    codes: IntegerMatrix
    rows: Cube
    smoothed_stamps: IntegerMatrix
    smoothed: Cube
    n_smoothed: Integers

    def of(self, i: int) -> Output:
        """Return the Output of filter `i`."""
        return Output(self.codes[i], self.rows[i], self.smoothed_stamps[i], self.smoothed[i])


def member_parameters(parameters: EstimatorParameters) -> list[EstimatorParameters]:
    """
    Return the parameters of the filters beside the leader; [] if nothing is mixed.

    A filter that cannot take a curve leads EKFs that can. Without an arm encoder no curve can be
    followed, and the random walk stays alone.
    """
    if parameters.tau_k_model != MIXED or not parameters.arm_joint:
        return []
    kind = filter_kind(parameters.filter)
    return [parameters.replace(
        tau_k_model=name, tau_k_stiffness=0.0,
        filter=parameters.filter if name in kind.tau_k_models else 'ekf') for name in CURVES]


def mixture(mixed: bool) -> Mixture:
    """Return a Mixture of equally likely models; it keeps past weights only if `mixed`."""
    capacity = KEPT if mixed else 0
    return Mixture(np.full(M, 1.0 / M), np.zeros(2), np.zeros(capacity, np.int64),
                   np.zeros((capacity, M)), np.zeros(3, np.int64), np.zeros(M),
                   np.zeros((M, N_SMOOTHED)), np.zeros(M, np.int64))


def until_second(carried: Mixture, stamps: Integers) -> tuple[int, bool]:
    """
    Return how many samples lie within one whole second, and whether the learned curve is lost.

    It is asked once per second of stamps, so that it does not matter how a stream is cut.

    Args:
        carried: changed in place.
        stamps: of the next samples int64 [N], ns.

    """
    seconds = stamps[:CHUNK] // SECOND
    n = int(np.argmax(seconds != seconds[0])) or len(seconds)
    diverged = bool(seconds[0] != carried.alone[1] and carried.alone[0] > LOST)
    carried.alone[1] = seconds[0]
    if diverged:
        carried.alone[0] = 0.0
    return n, diverged


def outputs(ring: int) -> Outputs:
    """Return room for what M filters write; `ring`: length of a smoother's ring, 0 without."""
    n = CHUNK + ring if ring else 0
    return Outputs(np.zeros((M, CHUNK), np.int64), np.zeros((M, CHUNK, N_ESTIMATE)),
                   np.zeros((M, n), np.int64), np.zeros((M, n, N_SMOOTHED)), np.zeros(M, np.int64))


@inline
def _remember(carried: Mixture, stamp: int) -> None:
    place = carried.places[WRITTEN] % KEPT
    carried.stamps[place] = stamp
    carried.history[place] = carried.weights
    carried.places[WRITTEN] += 1


@entry
def begin(carried: Mixture, stamp: int) -> None:
    """Let the smoother begin at the sample stamped `stamp`, with the weights `carried`."""
    carried.places[:] = 0
    _remember(carried, stamp)


@inline
def _moments(weights: Array, rows: Array, mean: int, std: int) -> Pair:
    """Return mean and standard deviation of a mixture; mean, std: columns of `rows` [M, ...]."""
    first = rows[0, mean]
    if not math.isfinite(first):
        return math.nan, math.nan
    total = square = 0.0
    for m in range(M):
        if weights[m] > 0.0:
            difference, deviation = rows[m, mean] - first, rows[m, std]
            total += weights[m] * difference
            square += weights[m] * (deviation * deviation + difference * difference)
    return first + total, math.sqrt(max(square - total * total, 0.0))


@inline
def _weigh(carried: Mixture, members: Outputs, k: int) -> float:
    """Update prior and weights with sample `k`; return its log-likelihood under the mixture."""
    weights, prior, rows = carried.weights, carried.prior, members.rows
    stay = math.exp(-rows[0, k, E_DT] / SWITCHING_TIME)
    total, highest = 0.0, -math.inf
    for m in range(M):
        prior[m] = 0.0
        if members.codes[m, k] == ESTIMATE:
            prior[m] = stay * weights[m] + (1.0 - stay) / M
            total += prior[m]
            highest = max(highest, rows[m, k, E_LOGLIK])
    likelihood = 0.0
    for m in range(M):
        prior[m] /= total
        weights[m] = prior[m] * math.exp(rows[m, k, E_LOGLIK] - highest) if prior[m] > 0.0 else 0.0
        likelihood += weights[m]
    for m in range(M):
        weights[m] /= likelihood
    carried.alone[0] += (weights[0] - carried.alone[0]) * min(rows[0, k, E_DT] / LOST_AFTER, 1.0)
    return highest + math.log(likelihood)


@inline
def _mix_row(carried: Mixture, rows: Array, row: Array) -> None:
    """Mix the rows [M, N_ESTIMATE] of a sample; `row` has its log-likelihood already."""
    weights, prior = carried.weights, carried.prior
    for i in range(MOMENTS.shape[0]):
        mean, std = MOMENTS[i, 0], MOMENTS[i, 1]
        row[mean], row[std] = _moments(weights, rows, mean, std)
    for column in (E_DOF, E_DT, E_U, E_LOAD, E_READING_MOTOR):
        row[column] = rows[0, column]
    e1, s1 = _moments(prior, rows, E_INNOVATION_MOTOR, E_INNOVATION_STD_MOTOR)
    e2, s2 = _moments(prior, rows, E_INNOVATION_ARM, E_INNOVATION_STD_ARM)
    both = math.isfinite(e1) and math.isfinite(e2)
    s12 = 0.0
    for m in range(M):
        if prior[m] > 0.0:
            s12 += prior[m] * rows[m, E_INNOVATION_COVARIANCE]
            if both:
                s12 += prior[m] * (rows[m, E_INNOVATION_MOTOR] - e1) * (
                    rows[m, E_INNOVATION_ARM] - e2)
    write_innovation(row, e1, e2, s1 * s1, s12, s2 * s2)
    row[E_NIS] = 0.0
    for white in (row[E_WHITE_1], row[E_WHITE_2]):
        if math.isfinite(white):
            row[E_NIS] += white * white
    learned = prior[M - 1] > 0.0
    for column in range(E_STIFFNESS, E_HYSTERESIS_STD + 1):
        row[column] = rows[M - 1, column] if learned else math.nan
    row[E_ELASTIC_WEIGHT], row[E_LEARNED_WEIGHT] = weights[1], weights[2]


@kernel
def mix_smoothed_row(weights: Array, rows: Array, row: Array) -> None:
    """
    Mix the smoothed rows of one sample.

    Args:
        weights: of the M filters [M].
        rows: of the filters [M, N_SMOOTHED].
        row: [N_SMOOTHED], written.

    """
    for j in range(SMOOTHED_MOMENTS.shape[0]):
        mean, std = SMOOTHED_MOMENTS[j, 0], SMOOTHED_MOMENTS[j, 1]
        row[mean], row[std] = _moments(weights, rows, mean, std)
    for mean in (S_X2, S_X4, S_X3):
        row[mean] = _moments(weights, rows, mean, S_TWIST_STD)[0]
    row[S_U] = rows[0, S_U]


@entry
def mix(carried: Mixture, members: Outputs, stamps: Integers, output: Output) -> None:
    """
    Mix what the filters wrote on N samples.

    Args:
        carried: changed in place.
        members: what they wrote; the leader, at 0, gives the codes.
        stamps: of the samples int64 [N], ns.
        output: written, N rows and as many smoothed rows as the leader has.

    """
    weights = carried.weights
    for k in range(stamps.shape[0]):
        code = members.codes[0, k]
        output.codes[k] = code
        if code == START:
            weights[:] = 1.0 / M
            carried.places[BEGUN] = carried.places[WRITTEN]
            _remember(carried, stamps[k])
        elif code == ESTIMATE:
            output.estimates[k, E_LOGLIK] = _weigh(carried, members, k)
            _mix_row(carried, members.rows[:, k], output.estimates[k])
            _remember(carried, stamps[k])


@entry
def mix_smoothed(carried: Mixture, members: Outputs, output: Output) -> None:
    """
    Mix the smoothed rows of the filters, by the weights at their samples.

    Args:
        carried: after mix.
        members: what the filters wrote; a row of the leader goes with those of the same stamp.
        output: written.

    """
    prior, places, aligned = carried.prior, carried.places, carried.aligned
    stamps, n, next_row = members.smoothed_stamps, members.n_smoothed, carried.next_row
    next_row[:] = 0
    for i in range(n[0]):
        stamp = stamps[0, i]
        while places[READ] < places[WRITTEN] and carried.stamps[places[READ] % KEPT] != stamp:
            places[READ] += 1
        total = 0.0
        for m in range(M):
            j = next_row[m]
            while j < n[m] and stamps[m, j] < stamp:
                j += 1
            next_row[m] = j
            prior[m] = 0.0
            if j < n[m] and stamps[m, j] == stamp:
                prior[m] = carried.history[places[READ] % KEPT, m]
                aligned[m] = members.smoothed[m, j]
            total += prior[m]
        for m in range(M):
            prior[m] = prior[m] / total if total > 0.0 else (1.0 if m == 0 else 0.0)
        output.smoothed_stamps[i] = stamp
        mix_smoothed_row(prior, aligned, output.smoothed[i])
    places[READ] = max(places[READ], places[BEGUN])
