# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Replay many bags, measure the backlash in each, and report which gearboxes wear.

BAGS are bags, .mcap files, folders of them or patterns. Each is run through the estimator as
"replay" does, with the model and parameters recorded in it, and the backlash fitted on windows of
drift_window seconds. DIR then holds
  bags.parquet  a row per bag: done, failed and why, duplicate of which; features; versions
  fleet.html    the page: backlash of each gearbox over time, the most worn first
  parts/        the row of each bag that is done

With --robots, or the URDF file of a robot as --model, the bags are of whole robots: those of each
folder are folded in order of time, as "watch" does, and a row is a joint.

Each bag runs in a process of its own, or on a Dask cluster. A bag that kills its worker, or
exceeds --max-seconds or --max-memory, gets a row that says so (a Dask cluster limits the memory
itself). The same command continues where an earlier one ended, for whatever reason: bags that are
done are skipped until their files, the model, the parameters or the version change.

usage examples:
  gearbox_monitor fleet archive/ --out fleet
  gearbox_monitor fleet '2026-*/joint3_*' --out fleet --model joint3.yaml --workers 8
  gearbox_monitor fleet archive/ --out fleet --gearbox 'archive/([^/]+)/'
  gearbox_monitor fleet archive/ --out fleet --robots    # archive/arm7/monday, archive/arm8/...
  gearbox_monitor fleet archive/ --out fleet --scheduler tcp://head:8786
  gearbox_monitor fleet archive/ --out fleet --json | jq .gearboxes[0]
"""
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path
import re
import sys
from typing import Any

from gearbox_monitor.cli.main import INTERRUPTED, UNDECIDED
from gearbox_monitor.cli.options import estimator_options, refuse, show
from gearbox_monitor.errors import expect_whole, InputError, installed_by
from gearbox_monitor.files.user_files import expect_outside_of_bag, load_model, read_text
from gearbox_monitor.library.progress import count_bar
from gearbox_monitor.recordings.joint_input import NO_MODEL, NO_SERIAL
from gearbox_monitor.report.sentences import entries, wrapped
from gearbox_monitor.ros.middleware import cores, Interrupt

MAX_SERVICES = 1 << 24  # bytes of a file
PRINTED = 10  # gearboxes, and bags that failed, on the terminal


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    _check(args)
    robots = _of_robots(args)
    try:
        from gearbox_monitor.fleet.fleet_run import (
            at_home, FleetFolder, on_cluster, pending_of, robot_bags, run as run_fleet, run_robots)
        from gearbox_monitor.fleet.job import find_bags
    except ModuleNotFoundError as error:
        raise InputError(f'{error.name} is not installed, expected '
                         f'{installed_by("tables")}') from None
    settings, services = _settings(args, robots), _services(args.serviced)
    bags: Sequence[Any] = find_bags(args.bags)
    folder = FleetFolder(args.out)
    run_each: Any = run_robots if robots else run_fleet
    if robots:
        bags = robot_bags(bags, args.gearbox)
    pending: Sequence[Any] = pending_of(bags, folder, settings.key) if robots else [
        bag for bag in bags if not folder.has(bag, settings.key)]

    def executor(workers: int) -> Any:
        return on_cluster(args.scheduler) if args.scheduler else at_home(
            workers, args.max_memory << 20)
    rows: dict[str, Any] = {}  # of this run, by path; of bags to be tried again
    with Interrupt() as interrupt, count_bar('fleet', len(bags), len(bags) - len(pending)) as bar:
        for bag, row in run_each(pending, settings, executor, args.workers or cores(),
                                 lambda: interrupt.requested):
            rows[bag.path] = row if row['retry'] else None
            if not row['retry']:
                folder.put(bag, row)
            bar.update()
        interrupted = len(rows) < len(pending)
        table = folder.finish([row for row in rows.values() if row])
        mixed = '' if interrupted else _mixed(bags, table)
        if mixed:
            print(f'gearbox_monitor fleet: {mixed}', file=sys.stderr)
            return UNDECIDED
        data = finish(folder, table, settings.key, rows, len(bags) - len(pending), services,
                      robots)
    data['interrupted'] = interrupted
    show(args, data, lambda: text(data))
    if data['interrupted']:
        print('interrupted: what is done is kept, run the same command again to continue',
              file=sys.stderr)
        return INTERRUPTED
    return 1 if data['to_be_tried_again'] else 0


def _of_robots(args: Namespace) -> bool:
    """Return whether the options `args` are about whole robots."""
    return bool(args.robots or Path(args.model or '').suffix == '.urdf')


def _check(args: Namespace) -> None:
    """Raise InputError for options that contradict each other."""
    if args.scheduler and args.workers is not None:
        raise InputError('--workers and --scheduler exclude each other, expected one of them')
    if args.workers is not None:
        expect_whole(args.workers, '--workers', 1)
    if not args.max_seconds > 0.0:
        raise InputError(f'--max-seconds: {args.max_seconds:g}, expected a number > 0 (s)')
    if args.max_memory < 0:
        raise InputError(f'--max-memory: {args.max_memory}, expected a whole number >= 0 (MB)')
    if _of_robots(args):
        refuse(args, ('params', 'serviced'), 'of gearboxes, expected none with robots')
    try:
        groups = re.compile(args.gearbox).groups
    except re.error as error:
        raise InputError(f'--gearbox: {args.gearbox!r}: {error}, expected a regular '
                         'expression') from None
    if args.gearbox and not groups:
        raise InputError(f'--gearbox: {args.gearbox!r} has no group, expected one around the name '
                         "of the gearbox: 'archive/([^/]+)/'")
    expect_outside_of_bag(args.out)


def _mixed(bags: Sequence[Any], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the question which gearbox made which of the `bags`, '' if `rows` tell it."""
    roots = {bag.path: bag.root for bag in bags if bag.root}
    unnamed: dict[str, int] = {}
    for row in rows:
        root = roots.get(row['path'], '')
        if row['status'] == 'done' and not row['named'] and str(Path(row['path']).parent) == root:
            unnamed[root] = unnamed.get(root, 0) + 1
    root, count = max(unnamed.items(), key=lambda item: item[1], default=('', 0))
    return '' if count < 2 else (
        f'{root}: {count} bags name no gearbox: which gearbox made which bag? Put those of each '
        "gearbox into a folder of its name, or name them by --gearbox PATTERN: '([^/]+)_[^/]*$', "
        f"for one gearbox '({Path(root).name})'")


def _services(path: str | None) -> dict[str, list[tuple[int, str]]]:
    """Return {gearbox: (stamp in ns, note) of its services} of the file `path`."""
    services: dict[str, list[tuple[int, str]]] = {}
    try:
        lines = read_text(path, MAX_SERVICES).splitlines() if path else []
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: {getattr(error, "strerror", None) or error}, expected a text '
                         'file of services') from None
    for number, line in enumerate(lines, 1):
        words = line.split(maxsplit=2)
        if not words or words[0].startswith('#'):
            continue
        try:
            date = datetime.fromisoformat(words[1])
        except (IndexError, ValueError):
            raise InputError(f'{path}: line {number}: {line.strip()!r}, expected GEARBOX DATE '
                             'NOTE, as elbow 2026-03-02 gear replaced') from None
        date = date if date.tzinfo else date.replace(tzinfo=timezone.utc)
        services.setdefault(words[0], []).append(
            (round(date.timestamp()) * 10 ** 9, ' '.join(words[2:]).strip()))
    return services


def _settings(args: Namespace, robots: bool) -> Any:
    """Return the JobSettings of the options; `robots`: whether the bags are of robots."""
    from gearbox_monitor.fleet.job import JobSettings
    if robots:
        from gearbox_monitor.library.robot import urdf_in
        return JobSettings(robot=urdf_in(args.model) if args.model else '', topic=args.topic,
                           gearbox=args.gearbox, max_seconds=args.max_seconds)
    parameters, model_file = estimator_options(args)
    return JobSettings(load_model(model_file) if model_file else None, model_file, parameters,
                       args.topic, args.gearbox, args.max_seconds)


def finish(folder: Any, rows: Sequence[dict[str, Any]], key: str, results: Mapping[str, Any],
           skipped: int, services: Mapping[str, Any], robots: bool) -> dict[str, Any]:
    """
    Write the page.

    Args:
        folder: the FleetFolder.
        rows: of the table of bags.
        key: of the settings of this run.
        results: {path: row to be tried again, or None} of this run.
        skipped: bags that were done before.
        services: {gearbox: (stamp in ns, note)}.
        robots: whether the bags are of robots.

    Returns:
        The summary as plain data.

    """
    from gearbox_monitor.fleet.fleet_run import gearboxes, joints
    from gearbox_monitor.report.fleet_page import CSV_NAME, fleet_csv, fleet_page, headline
    boxes = joints(rows) if robots else gearboxes(rows, services)
    status = Counter(row['status'] for row in rows)
    other_settings = sum(row['status'] == 'done' and row['settings'] != key for row in rows)
    written = folder.write_page(fleet_page(boxes, rows, status, other_settings, robots))
    if not robots:
        folder.write_page(fleet_csv(boxes), CSV_NAME)
    failed = [row for row in rows if row['status'] == 'failed']
    answer = headline(boxes, robots, len(failed))
    return {
        'summary': answer, 'out': str(folder.path), 'page': str(written), 'bags': len(rows),
        **{name: sum(row['path'] in results and row['status'] == name for row in rows)
           for name in ('done', 'failed', 'duplicate')}, 'skipped': skipped,
        'to_be_tried_again': sum(bool(row['retry']) for row in failed),
        'without_model': sum(NO_MODEL in (row.get('notes') or '') for row in rows
                             if row['status'] == 'done'),
        'without_serial': sum(NO_SERIAL in (row.get('notes') or '') for row in rows
                              if row['status'] == 'done'),
        'headline': answer, 'other_settings': other_settings,
        'joints' if robots else 'gearboxes': [
            {**box, 'points': len(box['points'])} for box in boxes],
        'failures': [{'path': row['path'], 'reason': row['reason'], 'retry': bool(row['retry'])}
                     for row in failed]}


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` as lines for people."""
    from gearbox_monitor.report.fleet_page import name_of
    from gearbox_monitor.report.words import counted

    def listed(label: str, words: Sequence[str]) -> list[tuple[str, str]]:
        """Return the first of `words`, and how many follow."""
        more = [f'and {len(words) - PRINTED} more'] if len(words) > PRINTED else []
        return [('' if k else label, line) for k, line in enumerate([*words[:PRINTED], *more])]
    return '\n'.join([*wrapped(data['summary']), '', *entries([
        ('bags', f'{data["done"]} done, {data["failed"]} failed, '
         f'{counted(data["duplicate"], "duplicate")}, {data["skipped"]} skipped: done before'),
        ('warning', f'{counted(data["without_model"], "bag")}: {NO_MODEL}' * bool(
            data['without_model'])),
        ('note', f'{counted(data["without_serial"], "bag")}: {NO_SERIAL}' * bool(
            data['without_serial'])),
        *listed('gearboxes', [f'{box["gearbox"]}: {box["summary"]}, {box["points"]} of '
                              f'{counted(box["bags"], "bag")}'
                              for box in data.get('gearboxes', ())]),
        *listed('joints', [f'{name_of(joint)}: {joint["summary"]}'
                           for joint in data.get('joints', ())]),
        *listed('failed', [entry['reason'] + ' (will be tried again)' * entry['retry']
                           for entry in data['failures']]),
        ('written', data['page'])])])
