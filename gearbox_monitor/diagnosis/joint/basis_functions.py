# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Laws of a signal over the motion: over speed, angle, twist and time.

Arrays in, arrays out. Nothing here knows models.
"""
from dataclasses import dataclass

import numpy as np
import scipy

from gearbox_monitor.kernels.types import Array, Flags, Integers

BINS = 24
TAIL = 0.5        # percent of the samples on either end that share the outermost bins
FEWEST = 0.002    # share of the samples below which a bin says nothing
SMOOTHING, SLOPES = 2.5e-3, 4.5e-3  # s, standard deviations of Gaussian windows
FOLDS = 5
STIFFNESSES = (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)  # how hard a Law bends
VAGUE = 4.0       # times the median error, from which on a bin of a Law says nothing


@dataclass(frozen=True)
class Law:
    """
    A signal as a function of a motion variable: edges [B + 1], value [B], standard error [B].

    NaN in bins of which the signal says little. explained: share of the signal beyond noise that
    the law explains in windows it was not fitted to.
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


def edges_over(quantity: str, x: Array) -> Array:
    """Return the edges [B + 1] of a law over the values `x` of a motion variable, by its name."""
    return edges_about_zero(x) if 'speed' in quantity else edges_of(x)


def edges_about_zero(x: Array, bins: int = BINS) -> Array:
    """Return edges [bins + 1] over x that are closest about 0, where friction changes."""
    top = float(np.percentile(np.abs(x), 100.0 - TAIL)) or 0.5
    share = np.linspace(-1.0, 1.0, bins + 1)
    return top * np.sign(share) * share ** 2


def law(x: Array, signal: Array, precision: Array, basis: Array, edges: Array) -> Law:
    """
    Return the Law, a value per bin, that fits a signal best by its own precision.

    How smooth it is, is chosen by what it foretells in windows it was not fitted to.

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
    columns, grams, pulls, populated = _normal_equations(x, signal, precision, basis, edges)
    value, error, explained = np.full(bins, np.nan), np.full(bins, np.nan), 0.0
    if populated.any():
        bend, fold = _bend(grams), np.arange(len(grams)) % min(FOLDS, len(grams))
        foretold, stiffness = max((_foretold(grams, pulls, s * bend, fold).sum(), s)
                                  for s in STIFFNESSES)
        value[populated], inverse = _solve(grams, pulls, stiffness * bend)
        residual = signal - columns @ value[populated]
        signal_power, residual_power = (np.einsum('wh,whk,wk->', v, precision,
                                                  v) for v in (signal, residual))
        freedom = max(1, signal.size - int(populated.sum()))
        error[populated] = np.sqrt(np.maximum(np.diag(inverse),
                                              0.0) * max(1.0, residual_power / freedom))
        vague = ~(error <= VAGUE * np.nanmedian(error))
        value[vague], error[vague] = np.nan, np.nan
        if signal_power > signal.size:
            explained = float(np.clip(foretold / (signal_power - signal.size), 0.0, 1.0))
    return Law(edges, value, error, explained)


def shares_foretold(x: Array, signal: Array, precision: Array, basis: Array, edges: Array,
                    fold: Integers) -> tuple[Array, Array]:
    """
    Return what laws of each of STIFFNESSES explain of windows that they were not fitted to.

    Args:
        x: motion variable in each sample [W, L].
        signal: free signal [W, H].
        precision: its inverse covariance [W, H, H].
        basis: triangles [L, H].
        edges: edges of the bins [B + 1].
        fold: of each window [W], from 0; windows of one fold are left out together.

    Returns:
        Share of the signal in each fold [S, F] and in all windows [S].
    """
    _, grams, pulls, _ = _normal_equations(x, signal, precision, basis, edges)
    gains = np.array([_foretold(grams, pulls, s * _bend(grams), fold) for s in STIFFNESSES])
    power = np.bincount(fold, np.einsum('wh,whk,wk->w', signal, precision, signal)) + 1e-300
    return gains / power, gains.sum(axis=1) / power.sum()


def _normal_equations(x: Array, signal: Array, precision: Array, basis: Array,
                      edges: Array) -> tuple[Array, Array, Array, Flags]:
    """
    Return (columns [W, H, P], grams [W, P, P], pulls [W, P], which bins [B] they are of).

    Only of bins that the signal determines.
    """
    bins = len(edges) - 1
    at = np.clip(np.searchsorted(edges, x, side='right') - 1, 0, bins - 1)
    spread = (basis / basis.sum(axis=0)).T
    columns = np.stack([spread @ (row[:, None] == np.arange(bins)) for row in at])
    weighted = precision @ columns
    grams = columns.transpose(0, 2, 1) @ weighted
    pulls = np.einsum('whb,wh->wb', weighted, signal)
    strength = np.diag(grams.sum(axis=0))
    populated = np.bincount(at.ravel(), minlength=bins) >= max(1.0, FEWEST * x.size)
    populated &= strength > 1e-6 * strength.max()
    return (columns[:, :, populated], grams[:, populated][:, :, populated], pulls[:, populated],
            populated)


def _bend(grams: Array) -> Array:
    """Return the normal matrix [P, P] of second differences, as strong as `grams` [W, P, P]."""
    bend = np.diff(np.eye(grams.shape[1]), 2, axis=0)
    return np.asarray(bend.T @ bend * np.trace(grams.sum(axis=0)) / max(grams.shape[1], 1))


def _solve(grams: Array, pulls: Array, bend: Array) -> tuple[Array, Array]:
    """Return (values [P], covariance [P, P]) from normal equations of windows, bend [P, P]."""
    covariance = np.linalg.pinv(grams.sum(axis=0) + bend, rcond=1e-9, hermitian=True)
    return covariance @ pulls.sum(axis=0), covariance


def _foretold(grams: Array, pulls: Array, bend: Array, fold: Integers) -> Array:
    """Return the gain in chi2 [F] on each fold of windows that a fit without them foretells."""
    gain = np.zeros(fold.max() + 1)
    for k in np.unique(fold) if len(grams) > 1 else ():
        out = fold == k
        values, _ = _solve(grams[~out], pulls[~out], bend)
        gain[k] = 2.0 * values @ pulls[out].sum(axis=0) - values @ grams[out].sum(axis=0) @ values
    return gain
