"""
Filters with one step signature (see ekf.step), chosen by name.

A filter is a module with ``step``, ``N_VECTORS`` and ``N_MATRICES`` (the scratch it wants).
"""
from gearbox_monitor.filters import ekf

FILTERS = {'ekf': ekf}
