# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The balance of a whole robot: rows -> columns -> evidence -> verdict.

Every term of the equation of motion is multiplied by smooth test functions and integrated, so that
no acceleration is formed (weak form). What the model leaves is explained by tolerances, or by
effects of joints and links, or by neither.
"""
