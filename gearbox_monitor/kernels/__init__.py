# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Numerics in C from annotated Python: array types, linear algebra, elementary functions.

`kernel` marks kernels and calls compiled ones, `library` finds them, `build` makes them,
`translate` writes their C.
The C is generated and compiled where the package is built, by pip (also -e), colcon and wheels
alike; the repository does not hold it: a second copy could be old, and merges would touch it.
A build needs numpy, as the modules with kernels are imported; pip brings it
into an isolated build, an apt-installed Jazzy has it.

Planned for 1 200 lines of code. It needs more, as the translator to C and the least squares that
all fits share are here, too.

Public names, by module:

    elementary: arctan, cosine, DIFFERENCE_GAIN, exponential, fma, MAD_TO_SIGMA, noise_levels,
        quantisation_step, sine, white_noise_std
    kernel: address_of, apart, bound, called_back, compilable, entry, folded, inline, kernel,
        KERNELS, Repeated
    library: installed
    linalg: add_product, add_transposed_product, carry, multiply, solve_positive,
        transposed_multiply_symmetric
    linear_least_squares: cosine_basis, covariance, damped_solve, damped_step, Damping,
        minimise, motion_mask
    translate.frame: plain
    translate.program: Program
    translate.statements: Function
    translate.values: Array, constant, ELEMENTS, real, stored, Tuple, type_of, Value, View
    types: AnyArray, Array, Block, Bytes, column, Cube, Curve, FlagMatrix, Flags, Four,
        IntegerMatrix, Integers, Layout, Matrix, Numbers, Packed, Pair, Slopes, table, Triple,
        unrolled, Values, Vector, WordMatrix, Words
"""
