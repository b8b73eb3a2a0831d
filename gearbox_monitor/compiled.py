# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""All entries of the package: what installation compiles. Nothing else imports this."""
import gearbox_monitor.bag.cdr
import gearbox_monitor.bag.message_block
from gearbox_monitor.estimation import filter, sample_loop, slopes
from gearbox_monitor.estimation.filter_kind import filter_kind
import gearbox_monitor.estimation.innovation_filter
import gearbox_monitor.estimation.model_bank
import gearbox_monitor.estimation.whiteness
import gearbox_monitor.monitoring.checks.elastic_curve
import gearbox_monitor.monitoring.checks.innovation
import gearbox_monitor.monitoring.checks.observability
import gearbox_monitor.monitoring.elastic_regression
from gearbox_monitor.parameters import FILTER_NAMES
import gearbox_monitor.plant.batch
import gearbox_monitor.plant.equivalent_torque
import gearbox_monitor.plant.free_runs
import gearbox_monitor.robot.arm_load
import gearbox_monitor.robot.arm_plant  # noqa: F401

for name in FILTER_NAMES:
    sample_loop.loop_of(filter_kind(name))
    filter.kernel_of(filter_kind(name))
sample_loop.loop_of(slopes.KIND)
