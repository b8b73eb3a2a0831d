# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Judge the estimates: trust indicators, alarms, backlash and its growth."""
