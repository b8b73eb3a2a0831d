# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""All entries of the package: what installation compiles. Nothing else imports this."""
from importlib import import_module

from gearbox_monitor.estimation import filter, sample_loop, slopes
from gearbox_monitor.estimation.filter_kind import filter_kind
from gearbox_monitor.parameters import FILTER_NAMES

MODULES = (
    'estimation.innovation_filter', 'estimation.model_bank', 'estimation.score',
    'health.checks.elastic_curve', 'health.checks.innovation', 'health.checks.observability',
    'health.elastic_regression', 'plant.batch', 'plant.equivalent_torque',
    'recordings.cdr', 'robot.dynamics', 'robot.arm_plant')

for module in MODULES:
    import_module(f'gearbox_monitor.{module}')
for name in FILTER_NAMES:
    sample_loop.loop_of(filter_kind(name))
    filter.kernel_of(filter_kind(name))
sample_loop.loop_of(slopes.KIND)
