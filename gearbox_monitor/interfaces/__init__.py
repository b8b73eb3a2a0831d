# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Names that users see: topics, fields, diagnostic keys."""
