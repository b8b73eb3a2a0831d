# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The physics: equations of motion, library of effects, simulator."""
