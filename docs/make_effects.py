# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write effects.md from the library of effects: python docs/make_effects.py."""
from pathlib import Path
import re
import sys
import textwrap

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS  # noqa: E402
from gearbox_monitor.plant.effects import EFFECTS, LOCATIONS  # noqa: E402
from gearbox_monitor.report.explanation import explained_effect, explained_robot_effect  # noqa: E402
from gearbox_monitor.simulators.drive_patch import in_urdf  # noqa: E402
from gearbox_monitor.simulators.mjcf import expression_of  # noqa: E402

PAGE = ROOT / 'docs/effects.md'
HEAD = """\
# Effects

`docs/make_effects.py` generates this page from `gearbox_monitor/plant/effects/`. An effect is a
behaviour of a drive beyond the plain model. [`gearbox_monitor diagnose`](diagnose.md)
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

`'` is the time derivative, t the time since the start of the recording. "another": the parameter
replaces the value of the model file. N is the integer number of periods per turn of the motor (on
the arm side). `gearbox_monitor explain ID` prints an entry.
"""
KNOWN = """\
Simulator and diagnosis support all effects. Filters support those that replace a value of the
model, and
{}; the estimator warns about others."""
TABLE_OF_TORQUE = """\
`diagnose` fits a torque map to what no effect explains. `place` and `variable` select the
quantity; `deviations` are the standard errors of `values`. A model has at most one map."""
OF_ROBOTS = """\
[`diagnose`](robot_gap.md) names these in logs of a whole robot, besides effects of one joint."""
IN_SIMULATORS = """\
What `export` makes of each effect. *native*: an attribute or element of MJCF implements it.
*construct*: a combination does, approximately. *refused*: MJCF cannot represent it. A free run of
1 s in MuJoCo (RK4, 0.1 ms) differs from this package's simulator by 0.1 to 1.5 mrad rms, in a
motion of 3 rad rms. "-": no parameter has its law, apply it in your code."""
OWN = """
[Your own package](extend.md#an-effect-in-your-own-package) can add effects.
"""


def entry(explanation, identifier):
    """Return the lines of an Explanation under the heading `identifier`."""
    meaning, *more = explanation.parts['What it is']
    lines = [f'### {identifier}', '', ' '.join([meaning, *(f'`{words}`.' for words in more)]), '']
    for heading, words in list(explanation.parts.items())[1:]:
        if heading == 'In simulators':  # in a table
            continue
        lines.append(f'- *{heading}*: {"; ".join(words).rstrip(".")}.')
    return [*lines, '']


def table():
    """Return the lines of the table of effects and simulators."""
    lines = ['| effect | | MuJoCo | URDF |', '|---|---|---|---|']
    for name, effect in EFFECTS.items():
        mjcf = expression_of(name)
        words = in_urdf(effect)
        urdf = '-' if words.endswith('no parameter has its law: apply it in your code') else words
        lines.append(f'| `{name}` | {mjcf.kind} | {mjcf.words} | {urdf} |')
    return lines


def page():
    """Return the text of the page."""
    names = ', '.join(f'`{name}`' for name, effect in EFFECTS.items() if effect.in_filters)
    lines = [HEAD.rstrip('\n'), '', textwrap.fill(KNOWN.format(names), 99)]
    for location in LOCATIONS:
        lines += ['', f'## {location}', '']
        for effect in EFFECTS.values():
            if effect.location == location:
                lines += entry(explained_effect(effect), effect.id)
    lines += ['', '## What no law describes', '', TABLE_OF_TORQUE, '']
    for effect in EFFECTS.values():
        if not effect.location:
            lines += entry(explained_effect(effect), effect.id)
    lines += ['', '## In simulators', '', IN_SIMULATORS, '', *table()]
    lines += ['', '## whole robot', '', OF_ROBOTS, '']
    for effect in ROBOT_EFFECTS:
        lines += entry(explained_robot_effect(effect), f'{effect.id} {effect.over}'.strip())
    return re.sub('\n{3,}', '\n\n', '\n'.join(lines)).rstrip('\n') + '\n' + OWN


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
