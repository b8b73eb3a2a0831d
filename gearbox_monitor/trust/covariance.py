"""Third trust indicator: the stated uncertainty of tau_K is where it was when all was well."""
from gearbox_monitor.trust.level import Finding, Level

LOWER, UPPER = 0.8, 1.3  # of the reference


def check(std, reference):
    """Return the Finding for the median `std` (N m) of tau_K against its `reference` (N m)."""
    if reference is None:
        return Finding(Level.OK, 'reference for the uncertainty of tau_K not complete yet',
                       {'tau_k_std': std})
    values = {'tau_k_std': std, 'reference': reference,
              'lower_bound': LOWER * reference, 'upper_bound': UPPER * reference}
    if std < LOWER * reference:
        return Finding(Level.WARN, 'uncertainty of tau_K below its usual range: the filter may '
                       'be deaf to its measurements', values)
    if std > UPPER * reference:
        return Finding(Level.WARN, 'uncertainty of tau_K above its usual range: measurements '
                       'missing or slower', values)
    return Finding(Level.OK, 'uncertainty of tau_K in its usual range', values)
