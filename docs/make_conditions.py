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

"""Write conditions.md from what the checks compare with: python docs/make_conditions.py."""
from collections.abc import Sequence
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.monitoring.backlash import change_tests  # noqa: E402
from gearbox_monitor.monitoring.checks.outcome import Condition, DEBOUNCE  # noqa: E402
from gearbox_monitor.monitoring.monitor import CONDITIONS  # noqa: E402

PAGE = ROOT / 'docs/conditions.md'
HEAD = """\
# When a component leaves OK

Written by `docs/make_conditions.py` from the conditions that the checks are made of; change it
there. What the indicators mean and what to do about them: [trust](trust.md); parameters in these
texts: [parameters](parameters.md).

A condition gives a raw level, once per second of stamps. The level that is published follows after
so many evaluations in a row as the heading says; no single evaluation moves it. Several conditions
at once give the highest level, and one message that names them all. Before the first evaluation a
component says WARN: no data yet, never OK.
"""


def evaluations(n: int) -> str:
    """Return `n` evaluations in words."""
    return 'one evaluation' if n == 1 else f'{n} evaluations in a row'


def table(component: str, conditions: Sequence[Condition]) -> str:
    """Return heading and Markdown table of the `conditions` of `component`."""
    up, down = DEBOUNCE[component]
    lines = [f'## {component}', '', f'Raised after {evaluations(up)}, lowered after '
             f'{evaluations(down)}.', '',
             '| level | message | when | window | what to do | values |',
             '|---|---|---|---|---|---|']
    for c in conditions:
        keys = ', '.join(f'`{key}`' for key in (*c.value, *c.threshold))
        cells = (c.level.name, c.says, c.when, c.window, c.advice, keys)
        lines.append('| ' + ' | '.join(cell.replace('|', '\\|') for cell in cells) + ' |')
    return '\n'.join(lines)


def page() -> str:
    """Return the text of the page."""
    rows = [*CONDITIONS, *change_tests.CONDITIONS]
    tables = [table(component, [c for c in rows if c.component == component])
              for component in DEBOUNCE if any(c.component == component for c in rows)]
    return HEAD + '\n' + '\n\n'.join(tables) + '\n'


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
