# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Explain an effect, a condition of a component or a level in words.

Of an effect: its meaning, its signs in data, its rivals and the motion that tells them apart, how
each simulator expresses it, its first version. Of a condition: when it is raised, the values that
show it, the remedy. NAME is an id of diagnose, the words of a message, a
component, a key of /diagnostics that shows a condition, or a level. Without NAME: the list.

usage examples:
  gearbox_monitor explain
  gearbox_monitor explain stribeck
  gearbox_monitor explain prediction errors biased
  gearbox_monitor explain ljung_box
  gearbox_monitor explain WARN
"""
from argparse import Namespace

from gearbox_monitor.cli.options import show, wrapped
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.errors import InputError, most_similar
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.plant.effects import EFFECTS, library, LOCATIONS
from gearbox_monitor.report.explanation import ALL_CONDITIONS, Explanation, explanations
from gearbox_monitor.report.sentences import title


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if not args.name:
        listed = contents()
        show(args, listed, lambda: list_text(listed))
        return 0
    matches = named(' '.join(args.name))
    show(args, [{'title': e.title, **e.parts} for e in matches],
         lambda: '\n\n'.join(text(e) for e in matches))
    return 0


def named(word: str) -> list[Explanation]:
    """Return the Explanations that `word` names. Raises InputError with the most similar name."""
    table: dict[str, list[Explanation]] = {}
    for names, explanation in explanations():
        for name in dict.fromkeys(n.casefold() for n in names):
            table.setdefault(name, []).append(explanation)
    key = word.casefold()
    if key not in table:
        similar = most_similar(key, sorted(table))
        raise InputError(f'{word!r}: ' + (f'did you mean {similar!r}?' if similar else
                                          'expected a name that gearbox_monitor explain lists'))
    return table[key]


def contents() -> dict[str, list[str]]:
    """Return {heading: names} of all that can be explained."""
    listed = {f'effects: {place}': [e.id for e in EFFECTS.values() if e.location == place]
              for place in LOCATIONS}
    listed['effects: anywhere'] = [e.id for e in EFFECTS.values() if not e.location]
    listed['effects: plug-ins'] = [name for name in library() if name not in EFFECTS]
    listed['effects: whole robot'] = list(dict.fromkeys(e.id for e in ROBOT_EFFECTS))
    for condition in ALL_CONDITIONS:
        says = listed.setdefault(f'conditions: {condition.component}', [])
        if title(condition.code) not in says:
            says.append(title(condition.code))
    listed['levels'] = [level.name for level in Level]
    return {heading: names for heading, names in listed.items() if names}


def list_text(listed: dict[str, list[str]]) -> str:
    """Return the names `listed` under their headings as lines."""
    lines: list[str] = []
    for heading, names in listed.items():
        mark = '; ' if heading.startswith('conditions') else ', '
        lines += [heading, *wrapped(mark.join(names), '  ', '  ')]
    return '\n'.join(lines)


def text(explanation: Explanation) -> str:
    """Return an `explanation` as lines of at most 80 columns."""
    lines = wrapped(explanation.title)
    for heading, words in explanation.parts.items():
        lines += ['', heading]
        lines += [line for part in words for line in wrapped(part, '  ', '  ')]
    return '\n'.join(lines)
