# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write one page about a recording: the state of the gearbox, and the trust in its estimates.

One HTML file that loads nothing, for a screen, a phone or paper: torque over twist minute by
minute, backlash with alarms, prediction errors with two sigma, NIS, levels of trust over time,
rate and dropouts of the input, parameters and versions. Drag in a chart to zoom.

The estimator is run on the recorded samples, from its recorded snapshots on, as replay does;
--model, --params and --filter replace what is recorded. Signals over time are thinned to envelopes
of lowest and highest value, so that an hour makes a page of some MB.

A recording of several gearboxes gets a page of the robot, one row per joint, the worst first, and
a page of each joint. --topic GEARBOX writes the page of one joint alone; of a bag
without estimates that is --topic joint_states/GEARBOX.

usage examples:
  gearbox_monitor report gearbox_2026_11_21-10_00_00
  gearbox_monitor report BAG --model drive.yaml --params joint3.yaml --out joint3.html
  gearbox_monitor report BAG --filter ukf --out ukf.html
  gearbox_monitor report BAG --json - | jq .gap_rad
"""
from argparse import Namespace
from collections.abc import Iterator, Sequence
from html import unescape
import os
from pathlib import Path
import re
import shlex
from typing import Any, NamedTuple
from urllib.parse import quote
import webbrowser

from gearbox_monitor.cli.options import reading_of, show, warn
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.errors import InputError, most_similar
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.library.recording_report import write_report
from gearbox_monitor.plant.effects import EFFECTS, library, LOCATIONS
from gearbox_monitor.recordings.reading import is_bag
from gearbox_monitor.report.builder import Page, page_summary, render_page, Section
from gearbox_monitor.report.explanation import ALL_CONDITIONS, Explanation, explanations
from gearbox_monitor.report.sentences import title, wrapped
from gearbox_monitor.report.words import counted


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    pages = write_report(args.bag, args.out, topic=args.topic, model=args.model,
                         parameters=args.params, filter=args.filter, reading=reading_of(args))
    warn(args, pages.notes)
    size = pages.page.stat().st_size / 1e6
    show(args, pages.figures,
         lambda: f'{pages.headline}\n{pages.page}: {size:.1f} MB, {pages.extent}')
    return 0


INDEX = 'index.html'
WRITER = '<meta name="generator" content="gearbox_monitor'
HEAD = 20_000  # characters of a page that hold its title and answer
PARTS = ('<title>(.*?)</title>', '<meta name="kind" content="(.*?)">',
         '<meta name="description" content="(.*?)">')


class WrittenPage(NamedTuple):
    """A page: its link from the index, title, kind (good, warn, error or '') and sentence."""

    link: str
    title: str
    kind: str
    headline: str


def open_folder(args: Namespace) -> int:
    """
    Write the index of a folder: its recordings with their reports and diagnoses, and its fleets.

    The page index.html in FOLDER links from a fleet to the report of each recording and on to its
    diagnosis, with the first sentence of each page. A recording without a page has the command
    that writes one. Run it again when there are new files; a browser opens where there is a
    screen.

    usage examples:
      gearbox_monitor open archive
      gearbox_monitor open . --json
    """
    folder = Path(args.folder)
    if not folder.is_dir():
        raise InputError(f'{folder}: no such folder, expected one with recordings or pages')
    recordings = [path.relative_to(folder) for path in _bags(folder)]
    pages = list(_pages(folder))
    if not recordings and not pages:
        raise InputError(f'{folder}: no recording and no page of gearbox_monitor, expected some')
    index = folder / INDEX
    try:
        index.write_text(index_page(folder.resolve().name, recordings, pages), encoding='utf-8')
    except OSError as error:
        raise InputError(f'{index}: {error.strerror}, expected a writable file') from None
    answer = index_summary(recordings, pages).data['headline']
    words = f'{counted(len(recordings), "recording")}, {counted(len(pages), "page")}: {index}'
    if not args.json and (os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY')):
        webbrowser.open(index.resolve().as_uri())
    show(args, {'summary': answer, 'page': str(index), 'recordings': list(map(str, recordings)),
                'pages': [page._asdict() for page in pages]}, lambda: f'{answer}\n{words}')
    return 0


def _bags(folder: Path) -> Iterator[Path]:
    """Yield the bags below `folder`, not the files in them."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith('.'):
            continue
        if path.suffix in ('', '.mcap', '.db3', '.bag') and is_bag(path):
            yield path
        elif path.is_dir() and not path.is_symlink():
            yield from _bags(path)


def _pages(folder: Path) -> Iterator[WrittenPage]:
    """Yield the pages of gearbox_monitor below `folder` but the index."""
    for path in sorted(folder.rglob('*.html')):
        with open(path, encoding='utf-8', errors='replace') as file:
            text = file.read(HEAD)
        parts = [unescape(found[1]) for pattern in PARTS
                 if (found := re.search(pattern, text, re.DOTALL))]
        if WRITER in text and len(parts) == len(PARTS) and path.name != INDEX:
            yield WrittenPage(quote(path.relative_to(folder).as_posix()), *parts)


def index_summary(recordings: Sequence[Path], pages: Sequence[WrittenPage]) -> Section:
    """Return what the worst of `pages` says, or how many `recordings` there are."""
    raised = [page for kind in ('error', 'warn') for page in pages if page.kind == kind]
    return page_summary(raised[0].kind, f'{raised[0].title}: {raised[0].headline}') if raised \
        else page_summary('', f'{counted(len(recordings), "recording")}; no page raises anything.')


def index_page(name: str, recordings: Sequence[Path], pages: Sequence[WrittenPage]) -> str:
    """
    Return the index as HTML.

    Args:
        name: of the folder.
        recordings: paths from the folder.
        pages: in it.

    """
    rows, linked = list[dict[str, Any]](), set[WrittenPage]()
    for path in recordings:
        own = [page for page in pages if page.title.split(' ')[0] != 'Fleet'
               and path.name in re.split('[ ,/]+', page.title)]
        linked.update(own)
        rows.append({'name': str(path), 'pages': own,
                     'command': f'gearbox_monitor report {shlex.quote(str(path))}'})
    return render_page(Page(f'Index of {name}', index_summary(recordings, pages), [
            Section('index.html', {'pages': [p for p in pages if p not in linked], 'rows': ()},
                    'Fleets and other pages'),
            Section('index.html', {'pages': (), 'rows': rows}, 'Recordings')]))


def explain(args: Namespace) -> int:
    """
    Explain an effect, a condition of a component or a level in words.

    Of an effect: its meaning, its signs in data, its rivals and the motion that tells them apart,
    how each simulator expresses it, its first version. Of a condition: when it is raised, the
    values that show it, the remedy. NAME is an id of diagnose, the words of a message, a
    component, a key of /diagnostics that shows a condition, or a level. Without NAME: the list.

    usage examples:
      gearbox_monitor explain
      gearbox_monitor explain stribeck
      gearbox_monitor explain prediction errors biased
      gearbox_monitor explain ljung_box
      gearbox_monitor explain WARN
    """
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
