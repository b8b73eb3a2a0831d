# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Wrong channels, signs and units: another reading of the data that explains them.

Every reading (channels swapped or not, signs, factors) is fitted to two equations of smoothed
data,

    u = m1 x1'' + m2 x2'' + friction of motor and arm + gravity + offset
    K dz(x1 - x2, b) + D (x1' - x2') = m2 x2'' + friction of the arm + gravity + offset

with inertias and stiffness within a factor of `loose` of the model's, friction of any size that
brakes, gravity (sine and cosine) and offsets of any size. A reading replaces the one as
recorded by its likelihood ratio over both equations, each with a variance of its own, with as many
independent samples as the autocorrelation of its residual leaves (Bartlett 1946). How much is
unexplained is no evidence by itself.

Swapped encoders turn the twist round: it then points against the arm's acceleration, whatever gap
and stiffness are (below the resonance; above it the likelihood decides).
"""
from collections.abc import Iterator
from itertools import groupby, product
import math
from typing import NamedTuple

import numpy as np
import scipy

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said, said
from gearbox_monitor.signals.finding import DataFinding, everything, judged, LIMITS, WARN
from gearbox_monitor.signals.uniform import rms_of, SmoothedMotion

GAPS = (0.33, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0)  # parts of the half gap that are tried
FEW_GAPS = (0.5, 1.0, 2.0)   # for choosing the readings that are tried with all
REFINED = 3         # readings, likewise
SWINGS = (0.0, 0.25, 0.4, 0.45)  # the same in parts of the twist's swing, if that is searched
ROWS = 1000         # that are fitted
ACCURACY = LIMITS.torque_accuracy, LIMITS.twist_accuracy
SLACK = 1e3         # weight of a bound


class Variant(NamedTuple):
    """How data are read: swapped or not, times `scale` (motor, arm) and `torque`."""

    kind: str
    quantity: str = ''
    swap: bool = False
    scale: tuple[float, float] = (1.0, 1.0)
    torque: float = 1.0


class ReadingFit(NamedTuple):
    """
    Residuals of both equations.

    torque, twist [M] N m; power of the torque, and of the transmitted one; noise [2]: power that
    the encoders' noise leaves in the residuals, whichever encoder is the motor's; scale: the
    smallest one of the positions.
    """

    torque: Array
    twist: Array
    power: float
    transmitted: float
    noise: Array
    scale: float

    @property
    def unexplained(self) -> float:
        """Share of the power of the torque that is unexplained."""
        return float(np.mean(self.torque ** 2)) / self.power

    @property
    def untransmitted(self) -> float:
        """The same of the transmitted torque that the twist does not explain."""
        return float(np.mean(self.twist ** 2)) / self.power


def readings(smooth: SmoothedMotion, model: DriveModel) -> Iterator[Variant]:
    """
    Yield all readings but the one as recorded, simple ones first.

    Args:
        smooth: smoothed motion.
        model: model of the drive.
    """
    for swap, arm_sign, sign in product((False, True), (1.0, -1.0), (1.0, -1.0)):
        if swap or arm_sign < 0.0 or sign < 0.0:
            kind = 'swapped' if swap else 'signs'
            yield Variant(kind, '', swap, (1.0, arm_sign), sign)
    motor, arm = (smooth.p[:, i] - smooth.p[:, i].mean() for i in (0, 1))
    slope, ratio = abs(motor @ arm) / (motor @ motor), abs(model.gear_ratio)
    units = np.array([180 / np.pi, 1e3, 2 * np.pi])
    decades = np.arange(1.1, 4.51, 0.2)  # loads and inertias of a model are off by several times
    factors = {'usual': [*units, *(1 / units)],
               'odd': [*10.0 ** -decades, *10.0 ** decades]}
    for kind, quantity in product(factors, ('both', 'torque', 'motor', 'arm', 'side')):
        extra = {'both': [], 'arm': [1 / slope]}.get(quantity, [slope, ratio, 1 / ratio])
        for f in [*factors[kind], *(f for f in extra if abs(np.log10(f)) > 0.4)]:
            motor_scale = f if quantity in ('motor', 'both', 'side') else 1.0
            arm_scale = f if quantity in ('arm', 'both') else 1.0
            torque = {'torque': f, 'side': 1.0 / f}.get(quantity, 1.0)
            yield Variant(kind, quantity, False, (motor_scale, arm_scale), torque)


def fitted(smooth: SmoothedMotion, model: DriveModel, reading: Variant,
           gaps: tuple[float, ...] = GAPS) -> ReadingFit:
    """
    Return the fit of both equations to the data as read.

    Args:
        smooth: smoothed motion.
        model: model of the drive.
        reading: how the data are read.
        gaps: parts of the half gap that are tried.
    """
    rows = slice(None, None, max(1, len(smooth.u) // ROWS))
    order = (1, 0) if reading.swap else (0, 1)
    p, v, a = (x[rows][:, order] * reading.scale for x in (smooth.p, smooth.v, smooth.a))
    u = smooth.u[rows] * reading.torque
    sign = np.column_stack([model.friction_side(v[:, 0]), model.friction_side(v[:, 1], arm=True)])
    zero, unity, gravity = np.zeros(len(u)), np.ones(len(u)), (np.sin(p[:, 1]), np.cos(p[:, 1]))
    # Columns of the equations of torque and twist, those with a lower bound first.
    columns = np.array([
        [a[:, 0], a[:, 1], zero, v[:, 0], sign[:, 0], v[:, 1], sign[:, 1], unity, zero, *gravity,
         u - model.position_gain * p[:, 0]],
        [zero, a[:, 1], zero, zero, zero, v[:, 1], sign[:, 1], zero, unity, *gravity,
         model.damping * (v[:, 0] - v[:, 1])]])
    t = model.transmission
    nominal = np.array([model.motor_inertia, model.arm_inertia, t.stiffness])
    spread = np.array([LIMITS.loose, LIMITS.loose, 100.0 if model.driven_by == 'position'
                       else LIMITS.loose])
    low = np.concatenate([nominal / spread,
                          [min(0.0, LIMITS.loose * model.viscous_friction), 0, 0, 0]])
    room = nominal * spread - low[:3]
    power = float(u @ u) / len(u)
    bent = np.array([*_bent(p[:, 0] - p[:, 1], np.ptp(p[:, 1]), model, gaps)])
    gram = np.repeat((columns @ columns.transpose(0, 2, 1))[None], len(bent), axis=0)
    cross = -bent @ columns[1].T
    cross[:, 2] = np.sum(bent ** 2, axis=1)
    gram[:, 1, 2] = gram[:, 1, :, 2] = cross
    weight = np.ones((len(bent), 2)) / power
    for _ in range(2):
        x = np.column_stack([-_solutions(np.einsum('be,beij->bij', weight, gram), low, room),
                             np.ones(len(bent))])
        left = (x[:, None, None] @ gram @ x[:, None, :, None])[:, :, 0, 0]
        variance = np.maximum(left, 0.0) / len(u) + np.multiply(ACCURACY, power)
        weight = 1.0 / variance
    k = int(np.log(variance).sum(axis=1).argmin())
    columns[1, 2] = -bent[k]
    torque, twist = x[k] @ columns
    inertial = np.square(smooth.noise_a * np.abs(reading.scale)).max()
    twisted = np.square(smooth.noise * np.abs(reading.scale)).sum() * t.stiffness ** 2
    noise = inertial * np.array([nominal[0] ** 2 + nominal[1] ** 2, nominal[1] ** 2])
    return ReadingFit(torque, twist, power, float(np.mean((x[k, 2] * bent[k]) ** 2)),
                      noise + (0.0, twisted), float(np.abs(reading.scale).min()))


def _bent(twist: Array, travel: float, model: DriveModel,
          parts: tuple[float, ...]) -> Iterator[Array]:
    """Yield the twist beyond a gap for all gaps and zeros that are tried."""
    half_gap = model.transmission.half_gap
    gaps = [part * half_gap for part in (parts if half_gap > 0.0 else (1.0,))]
    low, high = np.percentile(twist, (2, 98))
    if model.driven_by == 'position':  # gap and stiffness are searched in the twist itself
        gaps += [share * min(high - low, 2.0 * LIMITS.own_play * travel) for share in SWINGS]
    for zero, gap in product((0.0, 0.5 * (low + high)), gaps):
        yield twist - zero - np.clip(twist - zero, -gap, gap)


def _solutions(gram: Array, low: Array, room: Array) -> Array:
    """
    Return x [B, P] of bounded least squares (Lawson and Hanson, 1974).

    Args:
        gram: products of the columns [B, P + 1, P + 1], the last one is what they explain; those
            with a lower bound come first.
        low: lower bounds.
        room: from the lower to the upper bound, of the first ones.
    """
    count, bounded, slack = gram.shape[1], len(low), len(room)
    free, at, own = count - 1 - bounded, np.arange(count), np.arange(slack)
    scale = np.sqrt(np.diagonal(gram, axis1=1, axis2=2))
    scale = np.where(scale == 0.0, 1.0, scale)
    order = np.concatenate([at[bounded:-1], at[:bounded], [-1]])
    shift = np.tile(np.eye(count), (len(gram), 1, 1))
    shift[:, :bounded, -1] = -low  # remainder for the other values to explain
    shift[:, :, :-1] /= scale[:, None, :-1]
    moved = (shift.transpose(0, 2, 1) @ gram @ shift)[:, order[:, None], order]
    moved[:, at, at] += 1e-10 * np.maximum(moved[:, at, at], 1.0)
    r = np.linalg.cholesky(moved).transpose(0, 2, 1)
    # A value and its remaining room add up to the room.
    room = room * scale[:, :slack]
    weight = SLACK * np.abs(r[:, free:, -1]).max(axis=1)[:, None] / room
    matrix = np.zeros((len(gram), bounded + 1 + slack, bounded + slack))
    matrix[:, :bounded + 1, :bounded] = r[:, free:, free:-1]
    matrix[:, bounded + 1 + own, own] = matrix[:, bounded + 1 + own, bounded + own] = weight
    right = np.concatenate([r[:, free:, -1], weight * room], axis=1)
    z = np.array([scipy.optimize.nnls(a, b)[0][:bounded] for a, b in zip(matrix, right)])
    x = np.linalg.solve(r[:, :free, :free],
                        r[:, :free, -1:] - r[:, :free, free:-1] @ z[:, :, None])[:, :, 0]
    return np.concatenate([low + z / scale[:, :bounded], x / scale[:, bounded:-1]], axis=1)


def evidence(recorded: ReadingFit, other: ReadingFit) -> Array:
    """
    Return the log of the likelihood ratio of another reading by both equations [2].

    Errors of torque count in units of the torque and errors of twist in units of the positions, as
    they were recorded: a change of unit alone is no evidence.
    """
    result = np.zeros(2)
    for i, units in ((0, [np.sqrt(fit.power) for fit in (recorded, other)]),
                     (1, [recorded.scale, other.scale])):
        power = [float(np.mean((fit.torque, fit.twist)[i] ** 2)) / unit ** 2
                 for fit, unit in zip((recorded, other), units)]
        floor = ACCURACY[i] * max((fit.power, fit.transmitted)[i] / unit ** 2
                                  for fit, unit in zip((recorded, other), units))
        floor += other.noise[i] / units[1] ** 2
        samples = min(LIMITS.model_samples, float(independent((other.torque, other.twist)[i])))
        result[i] = 0.5 * samples * np.log((power[0] + floor) / (power[1] + floor))
    return result


def independent(residual: Array) -> Array:
    """Return how many independent samples residuals [..., M] count for: M over correlation."""
    m = residual.shape[-1]
    length = scipy.fft.next_fast_len(2 * m, real=True)
    r = scipy.fft.irfft(np.abs(scipy.fft.rfft(residual, length)) ** 2, length)[..., :m]
    r = r / np.maximum(r[..., :1], 1e-300)
    alike = np.logical_and.accumulate(r > 0.0, axis=-1)
    return m / (1.0 + 2.0 * np.sum(r[..., 1:] * alike[..., 1:], axis=-1))


def twist_sign(smooth: SmoothedMotion, model: DriveModel, reading: Variant) -> float:
    """
    Return by how many standard errors the twist follows the acceleration of the arm.

    Least squares of the twist on it, on friction, gravity, a zero and a factor between encoders.

    Args:
        smooth: smoothed motion.
        model: model of the drive.
        reading: how the data are read.
    """
    order = (1, 0) if reading.swap else (0, 1)
    p, v, a = (x[:, order] * reading.scale for x in (smooth.p, smooth.v, smooth.a))
    columns = np.column_stack([
        a[:, 1], v[:, 1], model.friction_side(v[:, 1], arm=True), p[:, 1],
        np.sin(p[:, 1]), np.cos(p[:, 1]), np.ones(len(p))])
    columns /= np.maximum(np.abs(columns).max(axis=0), 1e-300)
    twist = p[:, 0] - p[:, 1]
    inverse = np.linalg.pinv(columns.T @ columns)
    slope = inverse @ (columns.T @ twist)
    residual = twist - columns @ slope
    # Noise of the arm is in both: it makes the twist follow the acceleration, which counts less.
    variance = inverse[0, 0] * float(residual @ residual) / independent(residual)
    return float(slope[0] / np.sqrt(max(variance, 1e-300)))


def better(smooth: SmoothedMotion, model: DriveModel,
           kinds: tuple[str, ...] = tuple(LIMITS.margins)
           ) -> tuple[ReadingFit, Variant | None, ReadingFit | None]:
    """
    Return the data's fit as recorded, and the reading that explains them instead with its fit.

    Args:
        smooth: smoothed motion.
        model: model of the drive.
        kinds: of `margins` that are tried.

    Returns:
        Fit as recorded; reading and its fit, None where the recording is read rightly.
    """
    recorded = fitted(smooth, model, Variant('recorded'))
    sign = twist_sign(smooth, model, Variant('recorded'))
    white = np.resize([1e-9, -1e-9], len(recorded.torque))
    ideal = recorded._replace(torque=white, twist=white)
    if sign > -LIMITS.certain and evidence(recorded, ideal).sum() < min(LIMITS.margins.values()):
        return recorded, None, None
    for kind, rivals in groupby(readings(smooth, model), key=lambda reading: reading.kind):
        if kind not in kinds:
            continue
        chosen = sorted(rivals, reverse=True, key=lambda reading: evidence(
            recorded, fitted(smooth, model, reading, FEW_GAPS)).sum())[:REFINED]
        fits = [(reading, fitted(smooth, model, reading)) for reading in chosen]
        reading, fit = max(fits, key=lambda pair: evidence(recorded, pair[1]).sum())
        ratio, margin = evidence(recorded, fit), LIMITS.margins[kind]
        sure = ratio.sum() > margin
        if reading.swap:  # it turns the twist round; without its support, the torque must decide
            sure = sure and ratio[1] > margin / 3.0 or ratio[0] > LIMITS.margins['odd']
            turned = twist_sign(smooth, model, reading)
            sure = sign < -LIMITS.certain and turned > LIMITS.certain or sure and turned > sign
        if sure and fit.unexplained < LIMITS.explained:
            return recorded, reading, fit
    return recorded, None, None


def words(model: DriveModel, reading: Variant) -> tuple[str, Said]:
    """Return (fault, what it says) of a reading of a `model`: what is wrong, if it is right."""
    fault = {'signs': 'sign', 'swapped': 'swapped'}.get(reading.kind, 'units')
    return fault, _unit_said(model, reading) if fault == 'units' else _wiring_said(reading)


def _wiring_said(reading: Variant) -> Said:
    turned = {(True, True): 'motor position', (True, False): 'arm position',
              (False, True): 'torque u'}.get((reading.scale[1] < 0, reading.torque < 0))
    return said('swapped' if not turned else 'swapped_turned' if reading.swap else 'turned',
                signal=turned)


def _unit_said(model: DriveModel, reading: Variant) -> Said:
    """Return by which factor the recorded values differ from the expected ones, and why."""
    quantity = reading.quantity
    factor = 1.0 / (reading.torque if quantity == 'torque' else
                    reading.scale[1] if quantity == 'arm' else reading.scale[0])
    units = [(180 / np.pi, 'in degrees'), (1000.0, 'in thousandths'), (0.5 / np.pi, 'in turns'),
             (1e-3, 'in thousands')]
    if quantity == 'torque':
        units = [(1000.0, 'in mN m'), (1e-3, 'in kN m'), (100.0, 'in N cm'),
                 (1 / 9.80665, 'in kgf m'), (100 / 9.80665, 'in kgf cm')]
    if model.axis == 'prismatic':
        units = [(1000.0, 'in mN'), (1e-3, 'in kN'), (1 / 9.80665, 'in kgf')] \
            if quantity == 'torque' else [(1000.0, 'in mm')]
    ratio = abs(model.gear_ratio)
    if abs(ratio - 1.0) > 0.1:
        side = 'the gear ratio is applied twice or on the wrong side'
        units += [(ratio, side), (1 / ratio, side)]
    if quantity == 'side':
        return said('motor_side', factor=factor, ratio=model.gear_ratio)
    name = {'motor': 'the motor position is', 'arm': 'the arm position is',
            'both': 'both positions are', 'torque': 'the torque u is'}[quantity]
    unit, distance = min(((unit, abs(np.log(factor / value))) for value, unit in units),
                         key=lambda pair: pair[1])
    guesses = []
    if distance < math.log(LIMITS.near):
        guesses.append(said('probably', unit=unit))
    elif abs(ratio - 1.0) <= 0.1 and quantity != 'both':
        guesses.append(said('perhaps_geared'))
    if quantity == 'torque':
        guesses.append(said('perhaps_current'))
    return said('other_unit', signal=name, factor=factor, guesses=tuple(guesses),
                unit='N m' if quantity == 'torque' else 'rad')


# --- what the effort is -------------------------------------------------------------------------
# Motor and twist give the torque a second time, in which the load on the arm has no part:
#
#     tau = M1 x1'' + Cv x1' + Cc (2/pi) atan(alpha x1') + K dz(x1 - x2, b) + D (x1' - x2') + u0
#
# with the values of the model within their tolerances. A torque equals it, a current is a constant
# multiple of it far from 1, and a torque without its share against the weight differs by a sine
# and a cosine of the arm's angle. Least squares with priors; the likelihood takes an error of a
# model for granted and counts only independent samples.
EFFORT_GAPS = (0.5, 0.7, 1.0, 1.4, 2.0)  # parts of the model's half gap that are tried
FACTORS = 10.0 ** np.arange(-3.0, 3.01, 0.05)
(TORQUE, CURRENT, COMPENSATED) = EFFORTS = ('torque', 'current', 'gravity_compensated')


def likelihoods(smooth: SmoothedMotion, model: DriveModel) -> tuple[dict[str, float], float]:
    """
    Return the log-likelihood of each of EFFORTS, and the factor of the current.

    Args:
        smooth: smoothed motion, torque as converted by the model.
        model: model of the drive.

    """
    rows = slice(None, None, max(1, len(smooth.u) // ROWS))
    p, v, a, u = smooth.p[rows], smooth.v[rows], smooth.a[rows], smooth.u[rows]
    rms, weight = rms_of(u), [np.sin(p[:, 1]), np.cos(p[:, 1])]
    side = model.friction_side(v[:, 0])
    curves = [*_bent(p[:, 0] - p[:, 1], float(np.ptp(p[:, 1])), model, EFFORT_GAPS)]
    sizes = np.array([model.motor_inertia, model.viscous_friction, model.coulomb_friction,
                      model.transmission.stiffness])
    stds = np.array([max(LIMITS.effort_model, model.inertia_tolerance), 1.0, 1.0,
                     LIMITS.effort_model]) * sizes
    torque = model.position_gain * p[:, 0] + model.damping * (v[:, 0] - v[:, 1])

    def best(factors: Array, more: list[Array]) -> Array:
        """Return the log-likelihood of effort = factor tau less what `more` columns give [F]."""
        scale = rms / factors[:, None]
        weights = np.hstack([stds / scale, np.ones((len(scale), 1 + len(more)))])
        y = u / factors[:, None] - torque
        tables = [np.column_stack([a[:, 0], v[:, 0], side, curve, np.ones(len(u)), *more])
                  for curve in curves]
        return np.max([_likelihood(columns, weights, (y - columns[:, :4] @ sizes) / scale)
                       for columns in tables], axis=0)

    distant = FACTORS[np.abs(np.log(FACTORS)) > math.log(LIMITS.near)]
    currents = best(distant, [])
    k = int(np.argmax(currents))
    return {TORQUE: float(best(np.ones(1), [])[0]),
            CURRENT: float(currents[k]) - math.log(len(distant)),
            COMPENSATED: float(best(np.ones(1), weight)[0])}, float(distant[k])


def _likelihood(columns: Array, weights: Array, y: Array) -> Array:
    """
    Return the log-likelihoods [F] of `y` by its best fit, with what its parameters cost (Laplace).

    Args:
        columns: [M, P].
        weights: standard deviation of each column's parameter, in the scale of `y` [F, P].
        y: torque less that by the prior means, over its rms as it would be [F, M].

    """
    m = len(columns)
    gram = weights[:, :, None] * (columns.T @ columns / m) * weights[:, None, :]
    right = weights * (y @ columns / m)
    count, floor = np.full((2, len(y)), [[LIMITS.model_samples], [LIMITS.torque_accuracy]])
    for _ in range(3):
        ratio = count / floor
        information = np.eye(columns.shape[1]) + ratio[:, None, None] * gram
        x = np.linalg.solve(information, (ratio[:, None] * right)[:, :, None])[:, :, 0]
        residual = y - (x * weights) @ columns.T
        count = np.clip(independent(residual), 1.0, LIMITS.model_samples)
        floor = LIMITS.torque_accuracy + np.mean(residual ** 2, axis=1)
    return -0.5 * (count * np.log(floor) + np.sum(x ** 2, axis=1)
                   + np.linalg.slogdet(information)[1])


def effort(smooth: SmoothedMotion, model: DriveModel, stated: str) -> DataFinding:
    """
    Return what the effort reads like, against what is stated.

    Args:
        smooth: smoothed motion, torque as converted by the model.
        model: model of the drive.
        stated: parameter effort_is.

    """
    if not (np.isfinite(smooth.u).all() and smooth.u.any()):
        return judged('torque', 'effort', said('no_effort_to_compare'))
    scores, factor = likelihoods(smooth, model)
    first, second = sorted(EFFORTS, key=lambda name: -scores[name])[:2]
    ratio = scores[first] - scores[second]
    values: dict[str, float | str] = {
        f'log_likelihood_{name}': score for name, score in scores.items()}
    if not ratio >= LIMITS.effort_ratio:  # nor does NaN decide
        return judged('torque', 'effort', said('effort_undecided', first=first, second=second,
                                               ratio=ratio), values=values)
    values['effort_is'] = first
    # Where the model converts a current, its torque is what is looked for.
    same = {TORQUE: (TORQUE, 'unknown', CURRENT), COMPENSATED: (COMPENSATED,), CURRENT: ()}[first]
    if first == CURRENT:
        values['factor'] = factor
    return judged('torque', 'effort', said(
        f'effort_{first}', second=second, ratio=ratio, factor=factor,
        constant=model.torque_constant / factor),
        {} if stated in same else everything(WARN), values)
