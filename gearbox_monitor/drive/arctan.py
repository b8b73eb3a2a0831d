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

"""The arc tangent without a call or a branch: a loop over lanes with it fills the vector unit."""
import math

from gearbox_monitor.jit import fma, jit_inline

_EIGHTH, _THREE_EIGHTHS = math.tan(math.pi / 8.0), math.tan(3.0 * math.pi / 8.0)
_QUARTER_TURN, _HALF_TURN = 0.25 * math.pi, 0.5 * math.pi


@jit_inline
def arctan(x: float) -> float:
    """
    Return atan(x) within 1e-15 relative; NaN stays NaN.

    Reduced to |t| <= tan(pi/8); there Chebyshev's approximation of (atan(t)/t - 1)/t^2 in t^2.
    """
    a = abs(x)
    over, under, offset = a, 1.0, 0.0
    if a > _EIGHTH:
        over, under, offset = a - 1.0, a + 1.0, _QUARTER_TURN
    if a > _THREE_EIGHTHS:
        over, under, offset = -1.0, a, _HALF_TURN
    t = over / under
    z = t * t
    # By pairs: a chain of twelve steps would keep a single run waiting.
    z2 = z * z
    z4 = z2 * z2
    low = fma(z2, fma(0.11111111105155447, z, -0.14285714285659828),
              fma(0.19999999999999804, z, -0.3333333333333333))
    mid = fma(z2, fma(0.058789289978203436, z, -0.06666424885737),
              fma(0.07692296375032072, z, -0.09090908753500875))
    high = fma(z2, fma(0.016285756841402314, z, -0.034570561968958594),
               fma(0.045515932201417086, z, -0.052304542705439556))
    q = fma(z4, fma(z4, high, mid), low)
    return math.copysign(offset + fma(t * z, q, t), x)
