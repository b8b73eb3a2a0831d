# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
From kernels in Python to C99.

In goes a function object with the types of its arguments, out comes C of it and of all that it
calls (Program). Types are inferred forward, one C function is made for each combination of
argument types, and branches on what is known at translation are left out. What C has not is
refused by file and line.

values: types, values and syntax trees. frame: variables and lines of a function. arrays,
expressions, statements: the constructs. program: the C file.
"""
