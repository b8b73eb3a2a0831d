# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash, stiffness and friction of windows: baselines, growth, alerts and forecast."""
