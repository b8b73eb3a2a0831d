# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings: rosbag2-compatible MCAP, import of other formats, replay, repair."""
