# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write parameters.md from the tables that the nodes declare: python docs/make_parameters.py."""
from pathlib import Path
import sys

import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.parameters import (  # noqa: E402
    ARM_PLANT, AT_ONCE, ESTIMATOR, MODEL, ParameterRow, PLANT, RECORDER, RESTART,
    ROBOT, Table, WATCH_NODE)

PAGE = ROOT / 'docs/parameters.md'
CHANGES = {AT_ONCE: 'live', RESTART: 'live, restart'}
HEAD = """\
# Parameters

`docs/make_parameters.py` generates this page. [config/](../config) contains commented files; at
run time, `ros2 param describe /estimator NAME` shows unit and range. Values out of range are
refused. *live* parameters can change while the node runs (`ros2 param set`), with *restart* the
filter restarts; the bag records every change of the estimator, and replay repeats it.

Each entry: name = default, range. All values are SI. Values of the motor refer to the arm side
(`gear_ratio` in the model file).
Process noise is spectral, per sqrt(s): the sample rate can change without retuning.
"""
VALUES = """\
These parameters replace values of the model file. Their defaults are the values of that file, here
of the packaged one.
"""
MODEL_FILE = """
## Model file

`model` names it. [config/drive.yaml](../config/drive.yaml) explains every key with its unit.
"""


def shown(value: object) -> str:
    """Return `value` as it stands in YAML."""
    plain = list(value) if isinstance(value, tuple) else value
    text = yaml.safe_dump(plain, default_flow_style=True, width=1000)
    return text.removesuffix('\n...\n').strip()


def bounds(row: ParameterRow) -> str:
    """Return what a value of `row` may be, in a few characters."""
    if row.choices:
        return ', '.join(row.choices)
    return f'{row.low:g}..{row.high:g}' if row.low > -float('inf') else ''


def listed(rows: Table) -> str:
    """Return a Markdown list of the parameters.ParameterRow `rows`."""
    lines = []
    for row in rows:
        unit = '' if row.unit in ('', '-') else f' {row.unit}'
        limits = f', {bounds(row)}' if bounds(row) else ''
        change = f', *{CHANGES[row.change]}*' if row.change in CHANGES else ''
        lines.append(f'- `{row.name}` = `{shown(row.default)}`{unit}{limits}{change}: '
                     f'{row.description}')
    return '\n'.join(lines)


def page() -> str:
    """Return the text of the page."""
    return (f'{HEAD}\n## estimator\n\n{listed(ROBOT + ESTIMATOR)}\n\n{VALUES}\n{listed(MODEL)}\n\n'
            f'## plant\n\n{listed(PLANT)}\n\n'
            f'## arm_plant\n\n{listed(ARM_PLANT)}\n\n'
            f'## watch\n\n{listed(WATCH_NODE)}\n\n'
            f'## recorder\n\n{listed(RECORDER)}\n{MODEL_FILE}')


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
