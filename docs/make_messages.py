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

"""Write messages.md from the tables of signals and values: python docs/make_messages.py."""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.estimation import rts_smoother, sample_loop  # noqa: E402
from gearbox_monitor.interfaces.diagnostic_keys import DIAGNOSTIC_KEYS  # noqa: E402
from gearbox_monitor.interfaces.signals import SIGNALS  # noqa: E402

PAGE = ROOT / 'docs/messages.md'
HEAD = """\
# Messages, field by field

Written by `docs/make_messages.py` from `gearbox_monitor/interfaces/signals.py` and
`gearbox_monitor/interfaces/diagnostic_keys.py`; change it there. What each topic is for, and the
services: [topics](topics.md).

## Estimates

All are sensor_msgs/JointState with the stamp of the measurement (smoothed: of the time they are
about), rad, rad/s and N m (prismatic axes: m, m/s, N). What is of the joint `motor` is on the
motor's side of the gear, everything else on the arm's. A field that is not named is empty; a joint
that was not measured is left out.

"""
DIAGNOSTICS = """
## Values on /diagnostics and drift_alerts

Each DiagnosticStatus is called `estimator: COMPONENT` (of the recorder: `recorder: recording`).
Values are texts, as ROS wants it; a value that is not known is left out. When a component leaves
OK: [conditions](conditions.md).
"""
E, S = sample_loop, rts_smoother
COLUMNS = {
    False: {
        E.E_X1: 'motor position', E.E_X2: 'arm position', E.E_X3: 'motor speed',
        E.E_X4: 'arm speed', E.E_TWIST: 'twist, motor - arm', E.E_TWIST_RATE: 'its rate',
        E.E_TAU_K: 'tau_K', E.E_TWIST_STD: 'deviation of the twist',
        E.E_TWIST_RATE_STD: 'of its rate', E.E_STD + E.E_TAU_K: 'of tau_K',
        E.E_INNOVATION_MOTOR: 'motor, measured - predicted',
        E.E_INNOVATION_ARM: 'arm, measured - predicted',
        E.E_INNOVATION_STD_MOTOR: 'its predicted deviation, motor',
        E.E_INNOVATION_STD_ARM: 'its predicted deviation, arm'},
    True: {S.S_TWIST: 'twist, motor - arm', S.S_TWIST_RATE: 'its rate', S.S_TAU_K: 'tau_K'}}


def topics() -> str:
    """Return the Markdown table of the signals."""
    lines = ['| topic | joint | position | velocity | effort |', '|---|---|---|---|---|']
    for signal in SIGNALS:
        for i, joint in enumerate(signal.joints):
            cells = [COLUMNS[signal.smoothed][field[i]] if field else ''
                     for field in (signal.position, signal.velocity, signal.effort)]
            lines.append(f'| `{signal.topic}` | `{joint}` | ' + ' | '.join(cells) + ' |')
    return '\n'.join(lines)


def table(component: str) -> str:
    """Return heading and Markdown table of the values of `component`."""
    lines = [f'### {component}', '', '| key | unit | what |', '|---|---|---|']
    lines += [f'| `{row.key}` | {row.unit} | {row.description} |'
              for row in DIAGNOSTIC_KEYS if row.component == component]
    return '\n'.join(lines)


def page() -> str:
    """Return the text of the page."""
    components = dict.fromkeys(value.component for value in DIAGNOSTIC_KEYS)
    return (HEAD + topics() + '\n' + DIAGNOSTICS + '\n'
            + '\n\n'.join(table(component) for component in components) + '\n')


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
