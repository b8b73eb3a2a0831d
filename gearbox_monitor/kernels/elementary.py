# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Arc tangent, exponential and sine without a call or a branch, and the instructions they use.

A call keeps the compiler from running lanes side by side; these fill the vector unit.
"""
import ctypes
import math
import struct

import numpy as np

from gearbox_monitor.kernels.kernel import inline, instruction
from gearbox_monitor.kernels.types import Array

_fma = ctypes.CDLL('libm.so.6').fma
_fma.restype, _fma.argtypes = ctypes.c_double, [ctypes.c_double] * 3


@instruction('gm_fma')
def fma(a: float, b: float, c: float) -> float:
    """Return a b + c of float64, rounded once: one instruction, half as many in a product."""
    fused: float = _fma(a, b, c)
    return fused


def _bits(x: float) -> int:
    bits: int = struct.unpack('<Q', struct.pack('<d', x))[0]
    return bits


def _number(bits: int) -> float:
    number: float = struct.unpack('<d', struct.pack('<Q', bits & (2 ** 64 - 1)))[0]
    return number


@instruction('gm_times_power')
def times_power(a: float, t: float) -> float:
    """Return a 2^k, normal numbers both, where t is k + 1.5 2^52: its lowest bits hold k."""
    return _number(_bits(a) + (_bits(t) << 52))


@instruction('gm_signed')
def signed(a: float, t: float) -> float:
    """Return (-1)^k a, where t is k + 1.5 2^52."""
    return _number(_bits(a) ^ (_bits(t) << 63))


_EIGHTH, _THREE_EIGHTHS = math.tan(math.pi / 8.0), math.tan(3.0 * math.pi / 8.0)
_QUARTER_TURN, _HALF_TURN = 0.25 * math.pi, 0.5 * math.pi


@inline
def arctan(x: float) -> float:
    """
    Return atan(x) within 1e-15 relative; NaN stays NaN.

    Reduced to |t| <= tan(pi/8); there Chebyshev's approximation of (atan(t)/t - 1)/t^2 in t^2.
    """
    a = abs(x)
    over, under, offset = a, 1.0, 0.0
    if a > _EIGHTH:
        over, under, offset = a - 1.0, a + 1.0, _QUARTER_TURN
    if a > _THREE_EIGHTHS:
        over, under, offset = -1.0, a, _HALF_TURN
    t = over / under
    z = t * t
    # By pairs: a chain of twelve steps would keep a single run waiting.
    z2 = z * z
    z4 = z2 * z2
    low = fma(z2, fma(0.11111111105155447, z, -0.14285714285659828),
              fma(0.19999999999999804, z, -0.3333333333333333))
    mid = fma(z2, fma(0.058789289978203436, z, -0.06666424885737),
              fma(0.07692296375032072, z, -0.09090908753500875))
    high = fma(z2, fma(0.016285756841402314, z, -0.034570561968958594),
               fma(0.045515932201417086, z, -0.052304542705439556))
    q = fma(z4, fma(z4, high, mid), low)
    return math.copysign(offset + fma(t * z, q, t), x)


@instruction('gm_rounding')
def rounding() -> float:
    """Return what, added to a number, rounds it to an integer, which its lowest bits then hold."""
    return 1.5 * 2.0 ** 52


_LOG2_E, _LN2, _LN2_REST = 1.0 / math.log(2.0), math.log(2.0), 2.3190468138462996e-17
_PI_REST = 1.2246467991473532e-16  # what math.pi lacks
_LEAST = -100.0  # of exponents: products with less end in numbers that are slow to work with


@inline
def exponential(x: float) -> float:
    """
    Return exp(x) within 1e-15 for -100 <= x <= 709, 4e-44 below; NaN stays NaN.

    2^k exp(r), |r| <= ln(2)/2; there Chebyshev's approximation of (exp(r) - 1 - r)/r^2.
    """
    if x < _LEAST:
        x = _LEAST
    t = fma(x, _LOG2_E, rounding())
    k = t - rounding()
    r = fma(k, -_LN2_REST, fma(k, -_LN2, x))
    r2 = r * r
    r4 = r2 * r2
    low = fma(r2, fma(0.16666666666666669, r, 0.5), r)
    mid = fma(r2, fma(0.0001984126986317156, r, 0.0013888888917367081),
              fma(0.008333333333330039, r, 0.041666666666623824))
    high = fma(r2, fma(2.5100472505694996e-08, r, 2.762020159103155e-07),
               fma(2.7557268276905696e-06, r, 2.4801521057868204e-05))
    return times_power(1.0 + fma(r4, fma(r4, high, mid), low), t)


@inline
def sine(x: float) -> float:
    """
    Return sin(x) within 2e-16 for |x| < 1e15; NaN and infinity give NaN.

    +-sin(r), |r| <= pi/2; there Chebyshev's approximation of (sin(r)/r - 1)/r^2 in r^2.
    """
    t = fma(x, 1.0 / math.pi, rounding())
    k = t - rounding()
    r = fma(k, -_PI_REST, fma(k, -math.pi, x))
    z = r * r
    z2 = z * z
    low = fma(z2, fma(2.7557319219115013e-06, z, -0.00019841269841254795),
              fma(0.008333333333333316, z, -0.16666666666666666))
    high = fma(z2, fma(2.7312868913092307e-15, z, -7.643957622560617e-13),
               fma(1.6058976915095007e-10, z, -2.505210761086116e-08))
    return signed(fma(r * z, fma(z2 * z2, high, low), r), t)


@inline
def cosine(x: float) -> float:
    """Return cos(x) within 2e-16 for |x| < 1e6; NaN and infinity give NaN."""
    half = sine(0.5 * x)
    return 1.0 - 2.0 * half * half


# The fourth difference of white noise has 1 + 16 + 36 + 16 + 1 times its variance; motion that is
# smooth over five samples leaves none.
DIFFERENCE_GAIN = np.sqrt(70.0)
MAD_TO_SIGMA = 1.0 / 0.6744897501960817  # of a normal distribution
COARSE = 2.5  # steps in the median difference, below which a lattice shows little of the noise
FEW = 0.1     # share of differences of more than a step to and fro


def noise_levels(y: Array) -> tuple[Array, Array]:
    """
    Return (sigma [2], quantum [2]) of readings y [N, 2], both in rad.

    sigma: standard deviation of white noise, rounding included, from fourth differences: impacts
    and single wild readings do not count. quantum: step of the lattice that all readings stand on,
    0 where there is none. Text of few decimals is a lattice, too: a quantum far below sigma says
    nothing about the encoder.
    """
    y = np.asarray(y, float)
    quantum = np.array([quantisation_step(channel) for channel in y.T])
    return np.array([white_noise_std(channel, q) for channel, q in zip(y.T, quantum)]), quantum


def white_noise_std(y: Array, quantum: float = 0.0) -> float:
    """
    Return the standard deviation (rad) of white noise on y [N] (rad), rounding included.

    Args:
        y: readings of one encoder [N], rad.
        quantum: quantisation step, rad, or 0.
    """
    import scipy
    if len(y) < 5:
        return 0.0
    differences = np.abs(np.diff(y, 4))
    middle = np.median(differences)
    spread = middle * MAD_TO_SIGMA
    longest = 8.0 * quantum  # of one step to and fro
    if middle > COARSE * quantum > 0.0:
        # The median jumps by whole steps: how many differences are within it tells the rest.
        edge = (round(middle / quantum) + 0.5) * quantum
        spread = edge / scipy.special.ndtri(0.5 + 0.5 * np.mean(differences < edge))
    elif np.mean(differences > longest) < FEW:
        spread = np.sqrt(np.mean(np.minimum(differences, longest) ** 2))
    # Slow motion on a coarse lattice: most differences are 0 and say nothing.
    return float(max(spread / DIFFERENCE_GAIN, quantum / np.sqrt(12.0)))


def quantisation_step(y: Array) -> float:
    """Return the step (rad) of the lattice that all of y [N] stand on, 0 where there is none."""
    values = np.unique(y)
    if len(values) < 2:
        return 0.0
    steps = np.diff(values)
    # Rounding in the last bits makes twins of one value.
    twins = 16 * np.spacing(np.abs(values).max())
    steps = steps[steps > twins]
    if not len(steps):
        return 0.0
    count = np.rint(steps / steps.min())
    if count.sum() > 1e12:
        return 0.0
    place = np.concatenate([[0.0], np.cumsum(count)])
    values = values[np.concatenate([[True], np.diff(values) > twins])]
    quantum = (values[-1] - values[0]) / place[-1]  # the whole span: the least error of the step
    off = np.abs(values - values[0] - quantum * place)
    # Values on no lattice stand off it by a quarter step on average.
    return float(quantum) if len(values) > 2 and off.max() < 0.05 * quantum else 0.0
