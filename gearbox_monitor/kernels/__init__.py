# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Numerics in C from annotated Python: array types, linear algebra, elementary functions.

`kernel` marks kernels and calls compiled ones, `library` finds them, `build` makes them,
`translate` writes their C.
The C is generated and compiled where the package is built, by pip (also -e), colcon and wheels
alike, and is no file of the repository: it follows from the sources without a second copy that
could be old, and a merge never touches it. A build needs numpy, as the modules with kernels
are imported; pip brings it into an isolated build, an apt-installed Jazzy has it.
"""
