# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Third trust indicator: the filter's uncertainty of tau_K is at its reference.

That of the filter alone: what the tolerances of the model add to it varies with the motion.
"""
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of
from gearbox_monitor.presentation import Said

BELOW = Condition('below', 'covariance', Level.WARN, ('tau_k_noise_std',), ('lower_bound',))
ABOVE = Condition('above', 'covariance', Level.WARN, ('tau_k_noise_std',), ('upper_bound',))
CONDITIONS = (BELOW, ABOVE)


def check(stated: float, std: float, reference: float | None) -> Outcome:
    """
    Return the Outcome for the uncertainty of tau_K.

    Args:
        stated: median stated deviation, N m.
        std: the same by noise alone, which is judged.
        reference: healthy value of `std`; None: not complete yet.

    """
    if reference is None:
        return outcome_of([], Said('no_reference'),
                          {'tau_k_std': stated, 'tau_k_noise_std': std})
    values = {'tau_k_std': stated, 'tau_k_noise_std': std, 'reference': reference,
              'lower_bound': LIMITS.covariance_low * reference,
              'upper_bound': LIMITS.covariance_high * reference}
    broken = []
    if std < LIMITS.covariance_low * reference:
        broken.append(BELOW.said())
    elif not std <= LIMITS.covariance_high * reference:  # NaN is untrusted, too
        broken.append(ABOVE.said())
    return outcome_of(broken, Said('usual'), values)
