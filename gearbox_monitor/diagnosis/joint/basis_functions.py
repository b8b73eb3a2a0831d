# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Laws of a signal over the motion: over speed, angle, twist and time.

Arrays in, arrays out. Nothing here knows models.
"""
from dataclasses import dataclass

import numpy as np
import scipy

from gearbox_monitor.kernels.types import Array, Flags

BINS = 24
TAIL = 0.5        # percent of the samples on either end that share the outermost bins
FEWEST = 0.002    # share of the samples below which a bin says nothing
SMOOTHING, SLOPES = 2.5e-3, 4.5e-3  # s, standard deviations of Gaussian windows
SMOOTH = 2.0      # knots over which a function is smooth
SIZES = 10.0 ** np.arange(-4.0, 0.1, 0.5)  # of its prior over that of the signal: tried
VAGUE = 4.0       # times the median error, from which on a bin of a Law says nothing


@dataclass(frozen=True)
class Law:
    """
    A signal as a function of a motion variable: edges [B + 1], value [B], standard error [B].

    NaN in bins of which the signal says little. explained: share of the signal beyond noise that
    the law explains beyond its price.
    """

    edges: Array
    value: Array
    error: Array
    explained: float

    @property
    def centers(self) -> Array:
        """Return the middles of the bins [B]."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


def motion(y: Array, dt: float) -> dict[str, Array]:
    """
    Return {'speed', 'angle', 'twist', 'time': [N]} of readings `y`, smoothed.

    Speed of the motor (rad/s), angle of the arm (rad), twist as motor - arm (rad) and time (s).

    Args:
        y: readings of motor and arm [N, 2], rad.
        dt: sample time, s.
    """
    smooth = _smooth(y, max(SMOOTHING / dt, 0.5))
    return {'speed': slope(y[:, 0], dt), 'angle': smooth[:, 1],
            'twist': smooth[:, 0] - smooth[:, 1], 'time': np.arange(len(y)) * dt}


def slope(y: Array, dt: float) -> Array:
    """Return the derivative of `y` [N], smoothed; dt: s."""
    return np.asarray(np.gradient(_smooth(y, max(SLOPES / dt, 1.0)), dt))


def _smooth(y: Array, std: float) -> Array:
    """Return `y` [N] or [N, C], smoothed over `std` samples."""
    n = round(5.0 * std)
    # Reflected about both end points, so that a straight line goes on.
    y = np.pad(y, [(n, n), (0, 0)][:y.ndim], 'reflect', reflect_type='odd')
    return np.asarray(scipy.ndimage.gaussian_filter1d(y, std, axis=0)[n:-n])


def edges_of(x: Array, bins: int = BINS) -> Array:
    """Return edges [bins + 1], evenly spaced over all of x but its tails."""
    low, high = np.percentile(x, [TAIL, 100.0 - TAIL])
    if not high > low:
        low, high = low - 0.5, low + 0.5
    return np.linspace(low, high, bins + 1)


def edges_about_zero(x: Array, bins: int = BINS) -> Array:
    """Return edges [bins + 1] over x that are closest about 0, where friction changes."""
    top = float(np.percentile(np.abs(x), 100.0 - TAIL)) or 0.5
    share = np.linspace(-1.0, 1.0, bins + 1)
    return top * np.sign(share) * share ** 2


def law(x: Array, signal: Array, precision: Array, basis: Array, edges: Array) -> Law:
    """
    Return the Law, a value per bin, that fits a signal best by its own precision.

    x [W, L] in each sample; signal [W, H] at the peaks of the triangles basis [L, H], precision
    [W, H, H] its inverse covariance. Errors are as large as what the law leaves says.

    Args:
        x: motion variable in each sample [W, L].
        signal: free signal [W, H] at the peaks of the triangles, N m or rad.
        precision: inverse covariance of the signal [W, H, H].
        basis: triangles [L, H] that interpolate the signal.
        edges: edges of the bins [B + 1], in the unit of the motion variable.
    """
    bins = len(edges) - 1
    columns, gram, pull, populated = _normal_equations(x, signal, precision, basis, edges)
    value, error, explained = np.full(bins, np.nan), np.full(bins, np.nan), 0.0
    if populated.any():
        value[populated], covariance, gain, price = likeliest_values(
            gram, pull, SIZES * float(np.std(signal)), correlation(len(pull)))
        residual = signal - columns @ value[populated]
        signal_power, residual_power = (np.einsum('wh,whk,wk->', v, precision,
                                                  v) for v in (signal, residual))
        freedom = max(1, signal.size - int(populated.sum()))
        error[populated] = np.sqrt(np.maximum(np.diag(covariance), 0.0)
                                   * max(1.0, residual_power / freedom))
        vague = ~(error <= VAGUE * np.nanmedian(error))
        value[vague], error[vague] = np.nan, np.nan
        if signal_power > signal.size:
            explained = float(np.clip((gain - price) / (signal_power - signal.size), 0.0, 1.0))
    return Law(edges, value, error, explained)


def _normal_equations(x: Array, signal: Array, precision: Array, basis: Array,
                      edges: Array) -> tuple[Array, Array, Array, Flags]:
    """
    Return (columns [W, H, P], gram [P, P], pull [P], which bins [B] they are of).

    Only of bins that the signal determines.
    """
    bins = len(edges) - 1
    at = np.clip(np.searchsorted(edges, x, side='right') - 1, 0, bins - 1)
    spread = (basis / basis.sum(axis=0)).T
    columns = np.stack([spread @ (row[:, None] == np.arange(bins)) for row in at])
    weighted = precision @ columns
    gram, pull = np.einsum('whb,whc->bc', columns, weighted), np.einsum(
        'whb,wh->b', weighted, signal)
    populated = np.bincount(at.ravel(), minlength=bins) >= max(1.0, FEWEST * x.size)
    populated &= np.diag(gram) > 1e-6 * np.diag(gram).max()
    return (columns[:, :, populated], gram[populated][:, populated], pull[populated], populated)


def likeliest_values(gram: Array, pull: Array, sizes: Array,
                     shape: Array) -> tuple[Array, Array, float, float]:
    """
    Return (values [K], their covariance [K, K], gain in chi2, its price).

    The values have a Gaussian prior of the size under which the data are likeliest; the price is
    the Occam factor of that likelihood.

    Args:
        gram: information [K, K] about the values.
        pull: [K] of the data on them.
        sizes: deviations of the prior, tried.
        shape: correlation [K, K] of the prior.
    """
    out = []
    for size in sizes:
        C = size ** 2 * shape
        M = np.eye(len(pull)) + C @ gram
        values = np.linalg.solve(M, C @ pull)
        out.append((values, np.linalg.solve(M, C), float(pull @ values),
                    float(np.linalg.slogdet(M)[1])))
    return max(out, key=lambda row: row[2] - row[3])


def correlation(count: int) -> Array:
    """Return the prior correlation [K, K] of the values of a function at `count` knots."""
    return np.exp(-np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / SMOOTH)
