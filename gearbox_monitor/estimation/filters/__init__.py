# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The filters, one module each; its name is what the parameter `filter` chooses it by.

A module here defines FILTER, a filter_kind.FilterKind, and that is all that registers it.
"""
