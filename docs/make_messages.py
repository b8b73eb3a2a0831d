# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write messages.md from the tables of signals and values: python docs/make_messages.py."""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.estimation import rts_smoother, sample_loop  # noqa: E402
from gearbox_monitor.health.backlash.change_tests import size_name, TESTS  # noqa: E402
from gearbox_monitor.recordings.topics import SIGNALS  # noqa: E402
from gearbox_monitor.report.sentences import title  # noqa: E402
from gearbox_monitor.ros.diagnostic_keys import CHANGE_KEYS, DIAGNOSTIC_KEYS  # noqa: E402

PAGE = ROOT / 'docs/messages.md'
HEAD = """\
# Topics and messages

`docs/make_messages.py` generates this page from `gearbox_monitor/recordings/topics.py` and
`gearbox_monitor/ros/diagnostic_keys.py`. SI units; every message carries the stamp of its
measurement.

## Estimator

Inputs, sensor_msgs/JointState:

- `joint_states`: the joints `motor` and `arm` (parameters `motor_joint`, `arm_joint`); positions;
  effort of the motor = commanded torque; effort of the arm = measured load torque, with
  `arm_load: measured`. Missing or NaN = not measured.
- `arm_topic`: the joint `arm`, if it has its own messages:
  [paired by stamp](ros.md#motor-and-arm-on-two-topics).

Outputs, sensor_msgs/JointState ([field by field](#fields)):

- `transmission_state`: twist, its rate and the transmitted torque; `transmission_state_stddev`:
  their standard deviations.
- `transmission_state_smoothed`: the same, smoothed over `smoother_lag`, stamped with the estimated
  time. Use it to plot torque over twist.
- `innovations`: measured less predicted position of each measured encoder; `innovations_stddev`:
  their predicted deviations; `innovation_test_ratios`: squares over those of 5 deviations, 1: a
  reading at the gate.
- `estimated_joint_states`: filtered positions and velocities of motor and arm.
- `paired_joint_states`: with `arm_topic`, the pairs, input of replay.

Outputs, diagnostic_msgs/DiagnosticArray:

- `/diagnostics`: 1 Hz, [values](#values-on-diagnostics-and-drift_alerts). `drift_alerts`:
  [backlash and friction](wear.md#alerts), on change.
- `~/snapshot`: start of [replay](replay.md).

Output, std_msgs/String:

- `~/diagnosis`: [what changed](wear.md#what-changed), as JSON, after an alert; latched.

The effort stamped t_k acts from t_k to t_k+1; otherwise set `effort_delay`. With `gear_ratio` N in
the model file, messages carry motor position and torque on the motor side; parameters refer to the
arm side (angle / N, torque times N). [Several gearboxes](ros.md#several-gearboxes) share the
messages; each has its own `~/NAME/snapshot`, `~/NAME/diagnosis` and services.

| service | type | effect |
|---|---|---|
| `~/reset` | std_srvs/Trigger | the filter restarts with the next sample |
| `~/save_baseline` | std_srvs/Trigger | the present state becomes the [healthy state](\
wear.md#baseline), written to `baseline_file` |
| `~/keep_recording` | std_srvs/Trigger | writes the last `keep_minutes` of `joint_states` as a \
bag [ready to diagnose](recorder.md#keep-the-recording); answers with folder and command |

## Plant

Publishes `joint_states` and, for scoring, the truth `plant/transmission_state`
(sensor_msgs/JointState, joint `transmission`). It publishes `/clock` if it does not run in real
time. Backlash, friction, loads, noise and excitation can change
[at run time](parameters.md#plant).

`arm_plant` publishes the same topics with all motors (`motor1` ... `motor6`) and joints (`joint1`
... `joint6`) of an arm. The [recorder](recorder.md) records all of the above by default, but for
the test ratios.

## Fields

All are sensor_msgs/JointState with the stamp of the measurement (smoothed: of the estimated time),
in rad, rad/s and N m (prismatic axes: m, m/s, N). Values of the joint `motor` are on the motor
side of the gear, all others on the arm side. Fields without an entry are empty; joints without a
measurement are missing.

"""
DIAGNOSTICS = """
## Values on /diagnostics and drift_alerts

Each DiagnosticStatus is called `estimator: COMPONENT` (of the recorder: `recorder: recording`).
`input`, `observability`, `prediction error`, `covariance` and `model` are [trust](trust.md),
`backlash` and `friction` [wear](wear.md), `diagnosis` [what changed](wear.md#what-changed). Values
are texts; unknown values are missing. `KEY_std` is the standard deviation of `KEY`. `hardware_id`
is `gearbox_serial`. Levels are debounced. `gearbox_monitor explain KEY` prints when a component
leaves OK.
"""
CHANGES = """
### Changes

Each test for a change of backlash or friction publishes these keys in its component:

| key | what |
|---|---|
| `TEST_score` | odds of the change, logarithm (base 10) |
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
            cells = ['test ratio' if signal.gated and field else
                     COLUMNS[signal.smoothed][field[i]] if field else ''
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
    lines += [f'| `{test.key}` | `{size_name(test)}` | {test.component} | '
              f'{title(f"{test.key}_1")} |'
              for test in TESTS]
    return '\n'.join(lines) + '\n'


def page() -> str:
    """Return the text of the page."""
    components = dict.fromkeys(value.component for value in DIAGNOSTIC_KEYS)
    return (HEAD + topics() + '\n' + DIAGNOSTICS + '\n'
            + '\n\n'.join(table(component) for component in components) + '\n' + changes())


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
