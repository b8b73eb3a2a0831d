# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a user imports: from a file or arrays to results. The commands call the same functions."""
