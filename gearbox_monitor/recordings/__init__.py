# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings of every kind, read in one way.

A file goes in: a container becomes a Table of named columns (table), names and units make a
Mapping of it (guess), or a mapping file does (mapping), and out comes a bag (reading:
open_recording), whose joints are a Recording (recording) of a drive or of a robot.
"""
