# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The sim-to-real gap: where it lies, which effect causes it, how far it closes."""
