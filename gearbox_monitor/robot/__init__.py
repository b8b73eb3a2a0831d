# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A whole robot: its description, dynamics, loads on its joints, and a simulated arm."""
