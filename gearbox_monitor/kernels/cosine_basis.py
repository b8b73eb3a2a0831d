# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Local cosines (Malvar's lapped transform) and masks, of which test functions are made."""
import numpy as np

from gearbox_monitor.kernels.types import Array, Flags


def cosine_basis(hop: int, count: int) -> tuple[Array, Array]:
    """
    Return local cosines [2 hop, M] with a sine window, and their derivatives, 1/samples.

    Args:
        hop: distance of two of them, samples.
        count: number M of frequencies.
    """
    n, order = np.arange(2 * hop) + 0.5, np.arange(count) + 0.5
    phase = np.pi / hop * np.outer(n + hop / 2.0, order)
    window, fall = np.sin(np.pi * n / (2 * hop)), np.cos(np.pi * n / (2 * hop))
    scale, rate = np.sqrt(2.0 / hop), np.pi / hop
    return (scale * window[:, None] * np.cos(phase),
            scale * rate * (0.5 * fall[:, None] * np.cos(phase)
                            - window[:, None] * order * np.sin(phase)))


def motion_mask(still: Flags, width: int) -> Array:
    """
    Return a mask [N], 1 in motion and 0 at rest and about it, with ramps.

    Args:
        still: whether it rests [N].
        width: half width of the ramps, samples.
    """
    ones, bell = np.ones(2 * width + 1), np.hanning(2 * width + 3)[1:-1]
    wide = np.convolve(still, ones, 'same') > 0.5
    return np.asarray(np.clip(1.0 - np.convolve(wide, bell / bell.sum(), 'same'), 0, 1))
