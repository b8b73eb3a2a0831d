# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnosis of a whole robot by the balance of torques: rows, columns, evidence, verdict.

In go logs of all joints, a chain of links and references; out come findings of joints and links.
Every term of the equation of motion is multiplied by smooth test functions and integrated, so that
no acceleration is formed (weak form).
"""
