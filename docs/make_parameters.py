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

"""Write parameters.md from the tables that the nodes declare: python docs/make_parameters.py."""
from pathlib import Path
import sys

import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.parameters import (  # noqa: E402
    AT_ONCE, ESTIMATOR, MODEL, ParameterRow, PLANT, RECORDER, RESTART, ROBOT, Table)

PAGE = ROOT / 'docs/parameters.md'
CHANGES = {AT_ONCE: 'yes', RESTART: 'yes, restarts the filter'}
HEAD = """\
# Parameters

Written by `docs/make_parameters.py` from the tables that the nodes declare; change it there.
Ready files with comments stand in [config/](../config); at run time,
`ros2 param describe /estimator NAME` tells the same. A value out of range is refused, with the
reason. Parameters marked "live" can be changed while the node runs (`ros2 param set`); of the
estimator, every change is in the bag, and replay repeats it.

All values are SI. Values of the motor are referred to the arm side (`gear_ratio` in the model
file). Process noise is spectral, per sqrt(s): the sample rate can change without retuning.
"""
VALUES = """\
Values of the model file: given here, or changed while the node runs, they replace those of the
file. Their defaults are the file's; shown are those of the packaged one.
"""
MODEL_FILE = """
## Model file

The drive itself, read by plant, estimator and replay alike: every key with its unit stands in
[config/drive.yaml](../config/drive.yaml). `model` names another file.
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
    ends = [f'>= {row.low:g}' if row.low > -float('inf') else '',
            f'<= {row.high:g}' if row.high < float('inf') else '']
    return ', '.join(filter(None, ends))


def table(rows: Table) -> str:
    """Return a Markdown table of the parameters.ParameterRow `rows`."""
    lines = ['| name | default | unit | range | live | what |', '|---|---|---|---|---|---|']
    for row in rows:
        cells = (f'`{row.name}`', f'`{shown(row.default)}`', row.unit, bounds(row),
                 CHANGES.get(row.change, ''), row.description)
        lines.append('| ' + ' | '.join(cell.replace('|', '\\|') for cell in cells) + ' |')
    return '\n'.join(lines)


def page() -> str:
    """Return the text of the page."""
    return (f'{HEAD}\n## estimator\n\n{table(ROBOT + ESTIMATOR)}\n\n{VALUES}\n{table(MODEL)}\n\n'
            f'## plant\n\n{table(PLANT)}\n\n'
            f'## recorder\n\n{table(RECORDER)}\n{MODEL_FILE}')


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
