# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The blind benchmark: its own plant, sealed labels and scores; runner.py is the command."""
