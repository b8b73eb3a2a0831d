# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled numerics: compiler switch, array types, linear algebra, elementary functions."""
