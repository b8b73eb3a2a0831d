# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write conditions.md from what the checks compare with: python docs/make_conditions.py."""
from collections.abc import Sequence
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.monitoring.alert_limits import LIMITS  # noqa: E402
from gearbox_monitor.monitoring.backlash import change_tests  # noqa: E402
from gearbox_monitor.monitoring.checks.outcome import (  # noqa: E402
    Condition, DEBOUNCE, LEVELS)
from gearbox_monitor.monitoring.monitor import CONDITIONS  # noqa: E402

PAGE = ROOT / 'docs/conditions.md'
HEAD = """\
# When a component leaves OK

`docs/make_conditions.py` generates this page from the conditions of the checks. [Trust](trust.md)
explains the indicators, [parameters](parameters.md) the parameters in the texts,
[messages](messages.md) the values.

Conditions set a raw level once per second of stamps. The published level rises after 3 evaluations
in a row and falls after 5, unless the component states otherwise. If several conditions apply, the
highest level wins, and the message names them all. Before the first evaluation a component is WARN
(no data yet), never OK.

Each entry: level, message (values), condition, window, *remedy*. `gearbox_monitor explain MESSAGE`
prints one.

{levels}
"""
SIGNIFICANT = 'significant (false_alarm_interval) and '
CHANGES = f"""
## Changes of backlash and friction

A change is WARN (watch it) if the best of the newest 1 .. {LIMITS.horizon} windows is significant
(`false_alarm_interval`) and the change reaches the first limit; the other limits apply since the
change.
"""


def evaluations(n: int) -> str:
    """Return `n` evaluations in words."""
    return 'one evaluation' if n == 1 else f'{n} evaluations in a row'


def listed(component: str, conditions: Sequence[Condition]) -> str:
    """Return heading and Markdown list of the `conditions` of `component`."""
    up, down = DEBOUNCE[component]
    lines = [f'## {component}', '']
    if (up, down) != (3, 5):
        lines += [f'Raised after {evaluations(up)}, lowered after {evaluations(down)}.', '']
    for c in conditions:
        keys = f' ({", ".join(f"`{key}`" for key in c.value)})' if c.value else ''
        window = '' if c.window == 'the evaluation' else f', window: {c.window}'
        lines.append(f'- {c.level.name} **{c.says}**{keys}: {c.when}{window}. *{c.advice}*')
    return '\n'.join(lines)


def changes() -> str:
    """Return the table of the changes of the gearbox: three conditions of one message in a row."""
    tests = [c for c in change_tests.CONDITIONS if c.says.endswith('%')]
    lines = [CHANGES, '| message | WARN | WARN, plan a service | ERROR | what to do then |',
             '|---|---|---|---|---|']
    for watch, service, error in zip(*(tests[k::3] for k in range(3)), strict=True):
        assert watch.says == service.says == error.says
        limits = [c.when.removeprefix(SIGNIFICANT).replace('change >= ', '')
                  for c in (watch, service, error)]
        lines.append('| ' + ' | '.join((watch.says, *limits, error.advice)) + ' |')
    return '\n'.join(lines) + '\n'


def page() -> str:
    """Return the text of the page."""
    rows = [*CONDITIONS, *(c for c in change_tests.CONDITIONS if not c.says.endswith('%'))]
    lists = [listed(component, [c for c in rows if c.component == component])
             for component in DEBOUNCE if any(c.component == component for c in rows)]
    levels = '\n'.join(f'- {level.name}: {words.means}. *{words.advice}*'
                       for level, words in LEVELS.items())
    return HEAD.format(levels=levels) + '\n' + '\n\n'.join(lists) + '\n' + changes()


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
