# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Models of other simulators: read the drive in them, and write the closed model into them."""
