# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One sample in, one estimate out: four Kalman filters, smoothers, tuning."""
