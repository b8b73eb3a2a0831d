# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Second trust indicator: prediction errors are zero-mean, white and as large as predicted.

All tests run on innovations whitened by the Cholesky factor of S. The mean is tested on a short
window, because over whole periods of the excitation a model error averages out.
"""
import numpy as np
from scipy import stats

from gearbox_monitor.trust.level import Finding, Level

MEAN_WINDOW, WINDOW = 0.5, 2.0  # s
MIN_SAMPLES = 100
LAGS = 20
SIGNIFICANCE = 0.001  # of one whole check; two channels share the two-sided parts
MEAN_LIMIT = stats.norm.isf(SIGNIFICANCE / 4)
LJUNG_BOX_LIMIT = stats.chi2.isf(SIGNIFICANCE / 2, LAGS)
# An alarm wants more than significance: with enough samples every model is wrong. So much of an
# innovation must be predictable from those before it (beyond what LAGS / N gives by chance).
PREDICTABLE = 0.2
# ... and so far must the NIS be above its expectation for an error.
GROSS_NIS = 2.0


def ljung_box(e):
    """Return (Q of Ljung and Box over LAGS lags, sum of squared correlations) of `e` [N]."""
    e = e - e.mean()
    n = len(e)
    energy = e @ e
    if not energy > 0.0:
        return 0.0, 0.0  # constant: a matter for the mean
    rho = np.array([e[k:] @ e[:-k] for k in range(1, LAGS + 1)]) / energy
    q = n * (n + 2) * np.sum(rho ** 2 / (n - np.arange(1, LAGS + 1)))
    return float(q), float(rho @ rho)


def check(white, nis, dof, recent):
    """
    Return the Finding for a window.

    white [N, 2] whitened innovations, NaN where not measured; nis, dof [N]; `recent`: how many of
    the newest samples form the window of the mean.
    """
    total = dof.sum()
    if len(nis) < MIN_SAMPLES or total < MIN_SAMPLES:
        return Finding(Level.WARN, f'too few innovations yet ({len(nis)})')
    channels = [white[np.isfinite(white[:, c]), c] for c in range(2)]
    news = [white[-recent:][np.isfinite(white[-recent:, c]), c] for c in range(2)]
    means = [abs(e.mean()) * np.sqrt(len(e)) for e in news if len(e) >= LAGS]
    whiteness = [ljung_box(e) for e in channels if len(e) >= MIN_SAMPLES]
    enough = PREDICTABLE + LAGS / len(nis)
    mean, (box, predictable) = max(means, default=0.0), max(whiteness, default=(0.0, 0.0))
    ratio = float(nis.sum() / total)
    low = stats.chi2.ppf(SIGNIFICANCE / 2, total) / total
    high = stats.chi2.isf(SIGNIFICANCE / 2, total) / total
    values = {
        'mean': float(mean), 'mean_threshold': float(MEAN_LIMIT),
        'ljung_box': box, 'ljung_box_threshold': float(LJUNG_BOX_LIMIT),
        'predictable_share': predictable, 'predictable_share_threshold': enough,
        'nis_over_dof': ratio, 'nis_low': float(low), 'nis_high': float(high),
        'window_samples': len(nis)}
    faults = []
    if mean > MEAN_LIMIT:
        faults.append('biased')
    if box > LJUNG_BOX_LIMIT and predictable > enough:
        faults.append('not white')
    if not low <= ratio <= high:
        faults.append('larger than predicted' if ratio > high else 'smaller than predicted')
    if not faults:
        return Finding(Level.OK, 'prediction errors as predicted', values)
    level = Level.ERROR if ratio > GROSS_NIS else Level.WARN
    return Finding(level, 'prediction errors are ' + ', '.join(faults) +
                   '; check friction, inertia and torque scale of the model, or tune Q and R',
                   values)
