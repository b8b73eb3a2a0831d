# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write messages.md from the tables of signals and values: python docs/make_messages.py."""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.estimation import rts_smoother, sample_loop  # noqa: E402
from gearbox_monitor.interfaces.diagnostic_keys import (  # noqa: E402
    CHANGE_KEYS, DIAGNOSTIC_KEYS)
from gearbox_monitor.interfaces.signals import SIGNALS  # noqa: E402
from gearbox_monitor.monitoring.backlash.change_tests import (  # noqa: E402
    ALONE, size_name, TESTS)

PAGE = ROOT / 'docs/messages.md'
HEAD = """\
# Messages, field by field

`docs/make_messages.py` generates this page from `gearbox_monitor/interfaces/signals.py` and
`gearbox_monitor/interfaces/diagnostic_keys.py`. [Topics](topics.md) explains the topics and
services.

## Estimates

All are sensor_msgs/JointState with the stamp of the measurement (smoothed: of the estimated time),
in rad, rad/s and N m (prismatic axes: m, m/s, N). Values of the joint `motor` are on the motor
side of the gear, all others on the arm side. Fields without an entry are empty; joints without a
measurement are missing.

"""
DIAGNOSTICS = """
## Values on /diagnostics and drift_alerts

Each DiagnosticStatus is called `estimator: COMPONENT` (of the recorder: `recorder: recording`).
Values are texts; unknown values are missing. `KEY_std` is the standard deviation of `KEY`.
[Conditions](conditions.md) lists when a component leaves OK.
"""
CHANGES = """
### Changes

Each test for a change of backlash or friction publishes these keys in its component:

| key | what |
|---|---|
| `TEST_score` | normal score of the test, over all stretches |
| `TEST_score_threshold` | from `false_alarm_interval` |
| `SIZE_warn`, `SIZE_error` | limits for "plan a service" and for ERROR |
| `SIZE`, `SIZE_std`, `SIZE_since` | size of the change, its deviation, its start |
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
    """Return heading and list of the values of `component`; deviations are implied."""
    rows = [row for row in DIAGNOSTIC_KEYS
            if row.component == component and row not in CHANGE_KEYS]
    by_key = {row.key: row for row in rows}
    lines = [f'### {component}', '']
    for row in rows:
        owner = row.key.removesuffix('_threshold')
        if owner != row.key and owner in by_key:
            continue  # stands with the value that it limits
        if '_std' in row.key and row.key.replace('_std', '') in by_key:
            continue  # the page says what it is
        limit = by_key.get(f'{row.key}_threshold')
        words = f'; {limit.description} `{limit.key}`' if limit else ''
        unit = f' ({row.unit})' if row.unit not in ('', '-') else ''
        key, what = f'`{row.key}`{unit}', f': {row.description}{words}'
        if lines[-1].endswith(what):  # one entry of all that are described alike
            lines[-1] = f'{lines[-1].removesuffix(what)}, {key}{what}'
        else:
            lines.append(f'- {key}{what}')
    return '\n'.join(lines)


def changes() -> str:
    """Return the table of the tests for changes: the keys of all are formed alike."""
    lines = [CHANGES, '| TEST | SIZE | component | message |', '|---|---|---|---|']
    lines += [f'| `{test.key}` | {"" if test.key == ALONE else f"`{size_name(test)}`"} '
              f'| {test.component} | {test.words} ... % |' for test in TESTS]
    return '\n'.join(lines) + '\n'


def page() -> str:
    """Return the text of the page."""
    components = dict.fromkeys(value.component for value in DIAGNOSTIC_KEYS)
    return (HEAD + topics() + '\n' + DIAGNOSTICS + '\n'
            + '\n\n'.join(table(component) for component in components) + '\n' + changes())


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
