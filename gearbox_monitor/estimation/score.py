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

"""Run a filter over samples and say how well it predicts them, and how near the truth it is."""
from dataclasses import dataclass

import numpy as np
from scipy import stats

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.noise_search import BURN_IN, DIVERGED
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_STD
from gearbox_monitor.estimation.sample_loop import SECOND
from gearbox_monitor.monitoring.checks.innovation import LAGS, ljung_box

# What one divergence costs in log-likelihood: more than any good parameter can gain.
DIVERGENCE_COST = 1e4
WHITE_LIMIT = float(stats.chi2.isf(0.025, LAGS))  # two encoders share 5 %


@dataclass(frozen=True)
class Score:
    """
    How well a filter predicted its measurements; the first BURN_IN seconds do not count.

    loglik: sum over `estimates`; nis: mean, with the band [nis_low, nis_high] that holds 95 % of
    such means when the filter is right; mean, ljung_box: [2] of the whitened innovations of motor
    and arm, rms [2]: of the innovations (rad); diverged: how often the filter was restarted.
    """

    filter: str
    estimates: int
    loglik: float
    nis: float
    nis_low: float
    nis_high: float
    rms: tuple
    mean: tuple
    ljung_box: tuple
    diverged: int

    @property
    def criterion(self):
        """The log-likelihood with what divergences cost."""
        if not self.estimates:
            return DIVERGED
        return self.loglik - DIVERGENCE_COST * self.diverged


def settled(stamps, burn_in=BURN_IN):
    """Return a mask of the `stamps` int64 [M] ns later than `burn_in` s after the first."""
    return stamps >= (stamps[0] if len(stamps) else 0) + round(burn_in * SECOND)


def score(estimates, name='', diverged=0, burn_in=BURN_IN):
    """
    Return the Score, called `name`, of `estimates` (Estimates, or anything with their columns).

    diverged: how often the filter failed; burn_in: s at the start that do not count.
    """
    keep = settled(estimates.stamp_ns, burn_in)
    nis, total = estimates.nis[keep], float(estimates.dof[keep].sum())
    n = len(nis)
    if not n or not total:
        return Score(name, 0, DIVERGED, *(np.nan,) * 3, *((np.nan, np.nan),) * 3, diverged)
    channels = []
    for column in (estimates.white_1, estimates.white_2):
        white = column[keep]
        channels.append(white[np.isfinite(white)])
    errors = [e[keep] for e in (estimates.innovation_motor, estimates.innovation_arm)]
    return Score(
        name, n, float(estimates.loglik[keep].sum()), float(nis.mean()),
        float(stats.chi2.ppf(0.025, total) / n), float(stats.chi2.isf(0.025, total) / n),
        tuple(_rms(e[np.isfinite(e)]) for e in errors),
        tuple(float(c.mean()) if len(c) else np.nan for c in channels),
        tuple(ljung_box(c)[0] if len(c) > LAGS else np.nan for c in channels), int(diverged))


def run_score(model, parameters, samples):
    """Return the Score of an Estimator with `model` and `parameters` on `samples`, unsmoothed."""
    estimator = Estimator(model, unsmoothed(parameters))
    with np.errstate(all='ignore'):
        estimates = estimator.run(samples)
    return score(estimates, estimator.parameters.filter,
                 estimator.counts[sample_loop.DIVERGED])


def torque_errors(estimates, stamps, tau_k, burn_in=BURN_IN):
    """
    Return {name: value} of `estimates` against what is known: stamps int64 [T] ns, tau_k [T] N m.

    rms of the known torque; rmse (N m) and coverage (share within the stated deviation) of the
    filtered, rmse_smoothed and coverage_smoothed of the smoothed torque; None where there is none.
    The known torque is interpolated between its stamps. burn_in: see score.
    """
    result = {}
    begin = estimates.stamp_ns[0] + round(burn_in * SECOND) if len(estimates.stamp_ns) else 0
    for suffix, at, value, std in (
            ('', estimates.stamp_ns, estimates.tau_k, estimates.tau_k_std),
            ('_smoothed', estimates.smoothed_stamp_ns, estimates.smoothed[:, S_TAU_K],
             estimates.smoothed[:, S_TAU_K_STD])):
        known, found = known_at(at, stamps, tau_k)
        keep = found & (at >= begin)
        error = value[keep] - known[keep]
        if not suffix:
            result['rms'] = _rms(known[keep])
        result['rmse' + suffix] = _rms(error)
        result['coverage' + suffix] = (
            float((np.abs(error) <= std[keep]).mean()) if len(error) else None)
    return result


def known_at(at, stamps, tau_k):
    """
    Return (tau_k at the stamps `at` [M], mask [M] of where that is known).

    Between samples of stamps int64 [T] ns, tau_k [T] it is interpolated, but not beyond 0.1 s.
    """
    good = np.isfinite(tau_k)
    stamps, index = np.unique(stamps[good], return_index=True)
    tau_k = tau_k[good][index]
    if not len(stamps):
        return np.full(len(at), np.nan), np.zeros(len(at), bool)
    right = np.clip(np.searchsorted(stamps, at), 0, len(stamps) - 1)
    left = np.clip(right - 1, 0, None)
    exact = stamps[right] == at
    inside = (at >= stamps[0]) & (at <= stamps[-1]) & (stamps[right] - stamps[left] < SECOND // 10)
    origin = stamps[0]
    values = np.interp((at - origin) * 1e-9, (stamps - origin) * 1e-9, tau_k)
    values[exact] = tau_k[right[exact]]
    return values, exact | inside


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None
