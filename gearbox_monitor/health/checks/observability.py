# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
First trust indicator: the torque can be seen from these measurements, in this motion.

The paper's equation (6) looks at the Jacobian of [f; h] at a point; in raw units it ranks a lost
encoder above a healthy standstill. What decides the level is therefore the information share: how
much of the prior standard deviation of tau_K remains after 100 ms of measurements. It takes the
model for exact within that time: precise encoders then see through the slightest coupling. So what
the filter states, with noise of the process, decides as well: it must know more than the prior.

Before that, `judge_input` says whether the samples that came in could be used at all.
"""
from collections.abc import Mapping
from functools import cache
import math
import re

import numpy as np

from gearbox_monitor.estimation.process_model import (
    K_P, LOAD_AT, P0, Q0, R1, R2, tangent, TAU_K, X1, X2, X3, X4)
from gearbox_monitor.health.alarms import Condition, Level, LIMITS, Outcome, outcome_of
from gearbox_monitor.kernels.kernel import entry, inline
from gearbox_monitor.kernels.types import Array, FlagMatrix, Flags, Matrix, Values, Vector
from gearbox_monitor.plant.drive import (
    arm_load_slopes, D, INVERSE_M1, INVERSE_M2, motor_friction_slope)
from gearbox_monitor.presentation import Said

POSITION_SCALE = 1.0  # rad: prior standard deviation of the positions
ROUNDING = 1e-14
TINY = 1e-300

HIDDEN = Condition('hidden', 'observability', Level.ERROR, ('information_share_tau_k',),
                   ('information_share_threshold',))
UNKNOWN = Condition('uncertain', 'observability', Level.ERROR, ('stated_share_tau_k',),
                    ('stated_share_threshold',))
CONDITIONS = (HIDDEN, UNKNOWN)


@entry
def _gramian(states: Matrix, dts: Vector, measured: FlagMatrix, p: Vector, gramian: Matrix,
             product: Matrix, slope: Matrix) -> None:
    """
    Sum Phi' H' R^-1 H Phi over W samples [W, n], from the first state on.

    Phi by one linearised step per sample (more where k_p makes tau_K stiff), friction of motor and
    arm integrated exactly: within 2 % of the filter's own tangent at a tenth of its cost.
    """
    n = states.shape[1]
    omega = math.sqrt(p[K_P] * (p[INVERSE_M1] + p[INVERSE_M2]))
    for i in range(n):
        for j in range(n):
            product[i, j] = 1.0 if i == j else 0.0
            gramian[i, j] = 0.0
    for k in range(states.shape[0]):
        for c in range(2):
            if measured[k, c]:
                r = p[R1] if c == 0 else p[R2]
                for i in range(n):
                    for j in range(n):
                        gramian[i, j] += product[c, i] * product[c, j] / r
        z = states[k]
        count = 1 + int(dts[k] * omega)
        h = dts[k] / count
        motor_speed, motor_way = _braked(
            h * (motor_friction_slope(z[X3], z[TAU_K], p) + p[D]) * p[INVERSE_M1])
        arm_speed, arm_way = _braked(h * arm_load_slopes(z[X2], z[X4], p)[1] * p[INVERSE_M2])
        for _ in range(count):
            tangent(z, product, p, slope)
            for j in range(n):
                motor, arm = h * slope[X3, j], h * slope[X4, j]
                product[X1, j] += h * (product[X3, j] + 0.5 * motor_way * motor)
                product[X2, j] += h * (product[X4, j] + 0.5 * arm_way * arm)
                product[X3, j] += motor_speed * motor
                product[X4, j] += arm_speed * arm
                product[TAU_K, j] += h * slope[TAU_K, j] + 0.5 * h * p[K_P] * (
                    motor_way * motor - arm_way * arm)
                for i in range(TAU_K + 1, n):
                    product[i, j] += h * slope[i, j]


@inline
def _braked(rate: float) -> tuple[float, float]:
    """Return speed and way under a constant push, over those without friction of that rate."""
    if not abs(rate) > 1e-6:
        return 1.0, 1.0
    speed = (1.0 - math.exp(-rate)) / rate
    return speed, 2.0 * (1.0 - speed) / rate


def _scales(n: int, p: Array) -> Array:
    """Return the typical magnitudes [n] of the states: their prior standard deviations."""
    return np.append([POSITION_SCALE] * X3, np.sqrt(p[P0 + X3:P0 + n]))


def information_share(states: Array, dts: Array, measured: Flags, p: Array) -> Array:
    """
    Return posterior over prior standard deviation of each state after a window of W samples.

    sqrt(diag((S O S + I)^-1)) with the windowed observability Gramian O and prior deviations S.

    Args:
        states: estimates [W, n].
        dts: steps [W], s.
        measured: whether motor and arm were measured [W, 2].
        p: packed parameters, see process_model.pack.

    Returns:
        The shares [n]: 1 = nothing learnt, 0 = known.

    """
    n = states.shape[1]
    information, scale = np.empty((n, n)), _scales(n, p)
    _gramian(states, dts, measured, p, information, np.empty((n, n)), np.empty((n, n)))
    information *= np.outer(scale, scale)
    # With a unit diagonal, and a trace of rounding on it: of fine encoders the elements span more
    # than the digits of a number.
    size = np.sqrt(np.diag(information) + 1.0)
    posterior = np.linalg.inv((information + np.eye(n)) / np.outer(size, size)
                              + ROUNDING * np.eye(n))
    shares: Array = np.sqrt(np.clip(np.diag(posterior), 0.0, size ** 2)) / size
    return shares


def _condition(jacobian: Array) -> float:
    s = np.linalg.svd(jacobian, False)[1]
    ratio: float = s[-1] / max(s[0], TINY)
    return ratio


def paper(state: Array, measured: Flags, p: Array) -> dict[str, float]:
    """
    Return the indicators of equation (6) at `state` [n], `measured` [2] bool: {name: number}.

    condition_eq6: s_min / s_max of the Jacobian of [f; h] with respect to (x, p), p the torques
    that are estimated, in raw units; condition_eq6_scaled: the same with columns scaled by typical
    magnitudes of the states and rows of f by typical derivatives, rows of h by those of the
    positions. condition_eq6_p: with respect to p alone; of a single column it is always 1 and
    tells nothing. signal_eq6_p says what it was meant to: the norm of the column of tau_K, each
    row over its process noise, times the typical tau_K, per sqrt(s).
    """
    n, scale = len(state), _scales(len(state), p)
    jacobian = np.zeros((n + 2, n))
    tangent(state, np.eye(n), p, jacobian[:n])
    jacobian[[n, n + 1], [X1, X2]] = measured
    typical = np.ones(n + 2)
    typical[:n] = scale  # states beyond the drive's: no derivative to speak of
    typical[[X1, X2]] = scale[[X3, X4]]
    typical[[X3, X4]] = scale[TAU_K] * p[[INVERSE_M1, INVERSE_M2]]
    of_torques = jacobian[:, [TAU_K, int(p[LOAD_AT])]]
    return {
        'condition_eq6': _condition(jacobian),
        'condition_eq6_scaled': _condition(jacobian * scale / typical[:, None]),
        'condition_eq6_p': _condition(of_torques) if p[LOAD_AT] > 0.0 else 1.0,
        'signal_eq6_p': scale[TAU_K] * math.hypot(*(
            jacobian[i, TAU_K] / math.sqrt(max(p[Q0 + i], TINY)) for i in (X3, X4)))}


def check(shares: Mapping[str, float], stated: float, eq6: Values) -> Outcome:
    """
    Return the Outcome for the information shares {state: share} and the indicators of eq. (6).

    eq6: see paper. shares: 'tau_k' decides; 'x3' (motor speed) and, where it is
    estimated, 'tau_arm' are reported. stated: standard deviation of tau_K that the filter states,
    over its prior one.
    """
    values = {
        'information_share_tau_k': shares['tau_k'],
        'information_share_threshold': LIMITS.untrusted,
        'information_share_motor_speed': shares['x3'],
        'stated_share_tau_k': stated, 'stated_share_threshold': LIMITS.unknown, **eq6}
    if 'tau_arm' in shares:
        values['information_share_tau_arm'] = shares['tau_arm']
    hidden = [name for name, state in (('speed (standstill)', 'x3'),
                                       ('load on the arm (needs both encoders)', 'tau_arm'))
              if not shares.get(state, 0.0) <= LIMITS.untrusted]
    unobserved = (Said('and_not', {'names': ', '.join(hidden)}),) if hidden else ()
    broken = [condition.said() for condition, is_fine in (  # NaN is untrusted, too
        (HIDDEN, shares['tau_k'] <= LIMITS.untrusted), (UNKNOWN, stated <= LIMITS.unknown))
        if not is_fine]
    return outcome_of(broken, Said('observable', {'hidden': unobserved}), values)


NO_SAMPLE = Condition('no_sample', 'input', Level.ERROR, ('rate_hz',))
# Judged by the node, on the clock of its computer: no stamps come that could be judged.
SILENT = Condition('silent', 'input', Level.ERROR)
TWO_PUBLISHERS = Condition('two_publishers', 'input', Level.ERROR, ('messages_of_two_publishers',))


@cache
def key_of(counter: str) -> str:
    """Return the key on /diagnostics of a `counter`, one of sample_loop.REASONS."""
    return re.sub(r'\W+', '_', counter).strip('_')


def _refused(code: str, *counters: str) -> tuple[Condition, tuple[str, ...]]:
    """Return the Condition `code` that any of `counters` breaks, and the counters."""
    return Condition(code, 'input', Level.WARN, tuple(map(key_of, counters))), counters


REFUSED = (
    _refused('no_effort', 'samples without effort', 'missing efforts'),
    _refused('bad_stamps', 'zero stamps', 'repeated stamps', 'backward stamps',
             'stamps after a jump'),
    _refused('no_position', 'samples without measurement', 'missing motor positions',
             'missing arm positions'),
    _refused('position_jumps', 'positions that jump'),
    _refused('missed', 'samples missed (by stamps)'),
    _refused('bad_values', 'values that are infinite or beyond 1e9',
             'filter restarts after divergence'))
# Judged by the node, which knows the numbers of the messages: recordings do not have them.
LOST = Condition('lost', 'input', Level.WARN, ('messages_lost',))
INPUT_CONDITIONS = (SILENT, TWO_PUBLISHERS, NO_SAMPLE,
                    *(condition for condition, _ in REFUSED), LOST)


def judge_input(counts: Mapping[str, int], usable: int, values: Values) -> Outcome:
    """
    Return the Outcome on the samples of the last second.

    Args:
        counts: {counter of sample_loop.REASONS: how many in this second}.
        usable: number of samples in it that gave an estimate.
        values: {key: value} to publish, with `rate_hz` and the totals of all counters.

    Returns:
        ERROR if no sample was usable, WARN if a counter of REFUSED is not 0.

    """
    broken = refused(counts)
    if not usable:  # the remedy of what makes all samples unusable, where that is known
        broken = [*(said._replace(level=Level.ERROR) for said in broken), NO_SAMPLE.said()]
    return outcome_of(broken, Said('rate', {'rate': values['rate_hz']}), values)


def refused(counts: Mapping[str, int]) -> list[Said]:
    """Return which of REFUSED `counts` {counter: how many} break, with their numbers."""
    numbered = [(condition, [f'{counts[name]} {name}' for name in counters if counts.get(name)])
                for condition, counters in REFUSED]
    return [condition.said(counts=', '.join(texts)) for condition, texts in numbered if texts]
