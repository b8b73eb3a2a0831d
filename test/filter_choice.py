# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Filters by which tests run a whole monitor: one of them, the others behind the marker."""
import pytest

from gearbox_monitor.parameters import FILTER_NAMES

EACH_FILTER = [name if name == 'ekf' else pytest.param(name, marks=pytest.mark.system)
               for name in FILTER_NAMES]
