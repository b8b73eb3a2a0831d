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

"""Write effects.md from the library of effects: python docs/make_effects.py."""
import math
from pathlib import Path
import sys
import textwrap

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.plant.effects import EFFECTS, LOCATIONS  # noqa: E402

PAGE = ROOT / 'docs/effects.md'
HEAD = """\
# Effects

`docs/make_effects.py` generates this page from `gearbox_monitor/plant/effects/`. An effect is a
behaviour of a drive that the plain model lacks. [`gearbox_monitor diagnose`](diagnose.md)
identifies effects. The simulated plant takes them from the key `effects` of the model file, or at
run time from `ros2 param set /plant effects '["stribeck Cs=0.1 vs=0.2"]'`.

The plain model, everything on the arm side (SI units, N m, rad, s):

    x1' = x3,  x2' = x4                         motor and arm
    m1 x3' = u_act - D (x3 - x4) - tau_K - tau_f - Kr x1,   u_act = u
    m2 x4' = D (x3 - x4) + tau_K - tau_arm,                 tau_arm = 0
    tau_f = Cv x3 + Cc s(x3),       s(v) = (2/pi) atan(alpha v)
    tau_K = K dz(delta, b),         delta = x1 - x2, dz the dead zone of half gap b
    u = clip(kp (r - q) - kd q' + kff r', torque_limit)  of a controller with the setpoint r, q its
                                                encoder
    y1 = x1 + noise,  y2 = x2 + noise           encoders

`'` is the time derivative, t the time since the start of the recording. "replaced": the parameter
replaces the value of the model file. N is the integer number of periods per turn of the motor (on
the arm side). Each entry: id, meaning, equation, parameters.
"""
KNOWN = """\
Simulator and diagnosis support all effects. Filters support those that replace a value of the
model, and
{}; the estimator warns about others."""
TABLE_OF_TORQUE = """\
`diagnose` fits a torque map to what no effect explains. `place` and `variable` select the
quantity; `deviations` are the standard errors of `values`. A model has at most one map."""
OWN = """
[Plug-ins](plugins.md) add effects from other packages.
"""


def default(parameter):
    """Return the default of a parameter that an effect may omit, as words."""
    return '' if parameter.default is None else f', default {parameter.default:g}'


def bounds(parameter):
    """Return the bounds of a Parameter as words, '' for none."""
    if parameter.choices:
        return f', one of {", ".join(parameter.choices)}'
    low, high = (f'{bound:g}' if math.isfinite(bound) else ''
                 for bound in (parameter.low, parameter.high))
    if low and high:
        return f', {low} to {high}'
    return f', >= {low}' if low else f', <= {high}' if high else ''


def entry(effect):
    """Return the entry of the list for an Effect."""
    parameters = '; '.join(f'`{p.name}` ({p.unit}{bounds(p)}{default(p)})'
                           for p in effect.parameters)
    return f'- `{effect.id}`: {effect.meaning}. `{effect.equation}`. {parameters}'


def page():
    """Return the text of the page."""
    names = ', '.join(f'`{name}`' for name, effect in EFFECTS.items() if effect.in_filters)
    lines = [HEAD.rstrip('\n'), '', textwrap.fill(KNOWN.format(names), 99)]
    for location in LOCATIONS:
        lines += ['', f'## {location}', '']
        lines += [entry(effect) for effect in EFFECTS.values() if effect.location == location]
    lines += ['', '## What no law describes', '', TABLE_OF_TORQUE, '']
    lines += [entry(effect) for effect in EFFECTS.values() if not effect.location]
    return '\n'.join(lines) + '\n' + OWN


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
