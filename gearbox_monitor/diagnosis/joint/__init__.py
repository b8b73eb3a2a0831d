# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnosis of one drive by the innovations of a filter.

In go recordings of the drive on an even grid and its model; out come a verdict, a closed model and
the sizes that the recordings would show. Fits of candidates compete by their likelihood.
"""
