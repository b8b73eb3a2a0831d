# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a recording suits: findings about stamps, encoders, torque and motion."""
