# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Figures of merit of the package, against their bars: python -m benchmarks NAME."""
