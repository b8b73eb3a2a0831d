# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""White noise of an encoder, from fourth differences, and the step of its quantisation."""
import numpy as np

from gearbox_monitor.kernels.types import Array

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
