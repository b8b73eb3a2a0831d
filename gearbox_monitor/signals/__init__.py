# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings in memory, and what their signals say before any model of a drive is asked.

In go stamps, positions and efforts of a drive or a robot; out come a Recording, positions without
jumps, a recording on an even grid, and findings with limit and advice. Nothing here reads a file.
"""
