# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""All entries of the package: what installation compiles. Nothing else imports this."""
from gearbox_monitor.estimation import filter, sample_loop, slopes
from gearbox_monitor.estimation.filter_kind import filter_kind
from gearbox_monitor.parameters import FILTER_NAMES
import gearbox_monitor.robot.arm_plant  # noqa: F401

for name in FILTER_NAMES:
    sample_loop.loop_of(filter_kind(name))
    filter.kernel_of(filter_kind(name))
sample_loop.loop_of(slopes.KIND)
