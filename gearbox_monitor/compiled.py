# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""All entries of the package: what installation compiles. Nothing else imports this."""
from importlib import import_module

MODULES = (
    'estimation.filter', 'estimation.innovation_filter', 'estimation.model_bank',
    'estimation.score', 'health.checks.elastic_curve', 'health.checks.innovation',
    'health.checks.observability', 'health.elastic_regression', 'plant.batch',
    'plant.equivalent_torque', 'recordings.cdr', 'robot.dynamics', 'robot.arm_plant')

for module in MODULES:
    import_module(f'gearbox_monitor.{module}')
