# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash from the torque loop, its baselines, growth and forecast."""
