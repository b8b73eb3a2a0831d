# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Numerics: the compiler switch, array types, linear algebra, elementary functions.

In go arrays and functions written in a subset of Python; out come the same functions, compiled. No
kernel knows a drive.

Public names, by module:

    array_input: column, table
    compilation: announced_compilation, FIRST_START, KernelMissing, only_from_cache
    cosine_basis: cosine_basis, motion_mask
    elementary: arctan, exponential, sine
    jit: bound, CACHE_FOLDER, CACHE_PROBLEM, COMPILED, fma, jit, jit_allocating, jit_anew,
        jit_inline, jit_part, jit_shared, KERNELS
    levenberg_marquardt: damped_solve, damped_step, Damping, minimise
    linalg: add_product, add_transposed_product, carry, multiply, multiply_symmetric,
        solve_positive, transposed_multiply_symmetric
    linear_least_squares: covariance, solution
    sensor_noise: DIFFERENCE_GAIN, MAD_TO_SIGMA, noise_levels, quantisation_step,
        white_noise_std
    types: AnyArray, Array, Curve, Flags, Four, Integers, Packed, Pair, Slopes, States, Triple,
        Values
"""
