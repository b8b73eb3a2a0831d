# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Model, parameter and baseline files; the packaged configuration."""
