# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Indicators of trust: each turns numbers into an outcome."""
