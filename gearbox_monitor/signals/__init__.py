# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings in memory, and what their signals say before any model of a drive is asked.

A Recording of a drive or of a robot goes in; segments of regular stamps, noise of encoders,
smoothed motion and findings of the checks come out.
"""
