# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnosis of effects that it cannot see: recordings of an own simulator, sealed labels, scores.

Every effect of the library, none, two at once, effects outside of the library, and the true
effect taken out of it (leave-one-out); several motions, noise of 0.2 to 2 %. Each recording is
diagnosed by a process of its own; the labels are opened after all verdicts are written. What
was missed is listed.

usage examples:
  python -m benchmarks blind
  python -m benchmarks blind --n 24 --jobs 2 --keep blind/
  python -m benchmarks blind --set stress --json stress.json
  python -m benchmarks blind --encoders motor --n 24
  python -m benchmarks blind --input setpoint --n 24
  python -m benchmarks blind --encoders motor --effects stiffness backlash_gap --n 24
  python -m benchmarks blind --plant mujoco --n 24
"""
import argparse
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import as_completed, ThreadPoolExecutor
import json
import os
from pathlib import Path
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from typing import Any, cast, IO

import numpy as np

from benchmarks.blind import generate, imitate, mujoco_set, plant, scorer
from benchmarks.harness import add_json_option, finish, progress_line, require_whole
from gearbox_monitor.errors import InputError

SETS = ('main', 'stress', 'loo', 'all')
CPU_SECONDS = 300  # of one diagnosis; a limit by the clock would judge the machine's load
# Reported beside the stress set.
OPTIONS = ({'torque': 0.04}, {'scatter': 0.03}, {'coloured': True}, {'jitter': True})


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--n', type=int, default=240, metavar='N',
                        help='recordings of the main set; the others are sized by it '
                        '(default: %(default)s)')
    parser.add_argument('--set', choices=SETS, default='main',
                        help='main: nominal exact; stress: nominal scattered, process torque; '
                        'loo: the true effect taken out of the library (default: %(default)s)')
    parser.add_argument('--encoders', choices=plant.ENCODERS, default='both',
                        help='encoders that the recordings of the main set have '
                        '(default: %(default)s)')
    parser.add_argument('--input', choices=plant.INPUTS, default='torque',
                        help='what drives the recordings of the main set: a torque at 1 kHz, or '
                        'the setpoint of a servo at 100 Hz (default: %(default)s)')
    parser.add_argument('--effects', nargs='+', metavar='ID', help='the main set has single '
                        'effects alone, and only these (default: all, and other classes)')
    parser.add_argument('--plant', choices=('own', 'mujoco'), default='own',
                        help='simulator of the main set; mujoco: 500 Hz, the nominal model is an '
                        'MJCF file, with baselines (default: %(default)s)')
    add_json_option(parser)
    parser.add_argument('--seed', type=int, default=0, metavar='S',
                        help='other recordings for another seed (default: %(default)s)')
    parser.add_argument('--jobs', type=int, default=1, metavar='N',
                        help='recordings made and diagnosed at once (default: %(default)s)')
    parser.add_argument('--keep', metavar='DIR',
                        help='keep recordings, verdicts and, once all verdicts are written, '
                        'labels in this new directory')


def plans(set_name: str, n: int, random: np.random.Generator,
          options: Mapping[str, Any] | None = None) -> list[generate.Spec]:
    """
    Return the specifications of a set, in random order.

    Args:
        set_name: one of SETS.
        n: size of the main set, on which those of the others depend.
        random: source of random numbers.
        options: of the main set: encoders, one of plant.ENCODERS, input, one of plant.INPUTS, and
            effects, ids of single effects to which it is limited.
    """
    specs: list[generate.Spec] = []
    if set_name in ('main', 'all'):
        counts = {'single': n} if (options or {}).get('effects') else generate.counts_for(n)
        specs += generate.plan(counts, random, options=options)
    if set_name in ('stress', 'all'):
        third = max(n // 3, 4)
        specs += generate.plan({'single': third // 2, 'none': third // 2 - third // 6,
                                'pair': third // 6}, random, ('stress',))
        few = max(n // 15, 3)
        for option in OPTIONS:
            specs += generate.plan({'single': few // 2 + 1, 'none': few - few // 2 - 1,
                                    'pair': 1}, random, ('stress',), option)
    if set_name in ('loo', 'all'):
        specs += generate.plan({'loo': max(n // 4, 2)}, random)
    return [specs[i] for i in random.permutation(len(specs))]


def diagnose(folder: str | Path, exclude: Sequence[str],
             command: Sequence[str] | None = None) -> tuple[dict[str, Any] | None, float, str]:
    """
    Diagnose one recording in a process of its own.

    Args:
        folder: of the recording.
        exclude: ids that the diagnosis must not know.
        command: beginning of the command line; None: that of this package.

    Returns:
        The verdict or None, CPU seconds, last line of a failure.
    """
    out = Path(folder) / 'verdict.json'
    line = [*(command or [sys.executable, '-m', 'gearbox_monitor.cli.main', 'diagnose']),
            'recording.csv', '--model',
            *(mujoco_set.model_options(Path(folder)) if (Path(folder) / mujoco_set.MODEL).exists()
              else ['drive.yaml']), '--json', 'verdict.json']
    if exclude:
        line += ['--exclude', *exclude]
    process = subprocess.Popen(line, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    resource.prlimit(process.pid, resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 5))
    with cast(IO[bytes], process.stderr) as pipe:
        said = pipe.read().decode(errors='replace').strip().splitlines()[-1:]
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = usage.ru_utime + usage.ru_stime
    failure = '' if process.returncode in (0, 1) else (
        f'no answer within {CPU_SECONDS} s of CPU time' if process.returncode == -signal.SIGXCPU
        else (said or [f'exit {process.returncode}'])[0])
    try:
        return json.loads(out.read_text(encoding='utf-8')), seconds, failure
    except (OSError, ValueError):
        return None, seconds, failure or 'no readable verdict'


def diagnose_all(recordings: Path, orders: Sequence[dict[str, Any]], jobs: int,
                 progress: Callable[[int, int], object], command: Sequence[str] | None = None
                 ) -> tuple[dict[str, dict[str, Any] | None], dict[str, float], dict[str, str]]:
    """
    Diagnose all recordings.

    Args:
        recordings: folder that holds them.
        orders: name and excluded ids of each.
        jobs: diagnoses that run at once.
        progress: called with the numbers of diagnoses done and in all.
        command: see diagnose().

    Returns:
        Verdict, CPU seconds and failure, each by name of the recording.
    """
    verdicts: dict[str, dict[str, Any] | None] = {}
    seconds: dict[str, float] = {}
    failures: dict[str, str] = {}
    with ThreadPoolExecutor(jobs) as pool:
        futures = {pool.submit(diagnose, Path(recordings) / order['name'], order['exclude'],
                               command): order['name'] for order in orders}
        try:
            for future in as_completed(futures):
                name = futures[future]
                verdicts[name], seconds[name], failure = future.result()
                if verdicts[name] is None:
                    failures[name] = failure
                progress(len(verdicts), len(orders))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return verdicts, seconds, failures


def evaluate(n: int, set_name: str, seed: int, jobs: int, keep: str | Path | None = None,
             progress: Callable[[str, int, int], object] = lambda stage, done, total: None,
             command: Sequence[str] | None = None,
             options: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """
    Generate, diagnose and score a set.

    Args:
        n: size of the main set.
        set_name: one of SETS.
        seed: of all random numbers.
        jobs: processes at once.
        keep: new directory for recordings, verdicts and, at the end, labels.
        progress: called with the stage and the numbers done and in all.
        command: see diagnose().
        options: see plans().

    Returns:
        The figures of scorer.score(), failures and specifications that could not be drawn.
    """
    random = np.random.default_rng([seed, 1])
    # The labels lie where no path from a recording leads, and open to this user alone.
    with tempfile.TemporaryDirectory() as hidden, tempfile.TemporaryDirectory() as open_to_see:
        base = Path(keep or Path(open_to_see) / 'blind')
        sealed = Path(hidden) / 'labels.json'
        orders = generate.generate(plans(set_name, n, random, options), base, seed, jobs,
                                   lambda d, t: progress('recordings', d, t), sealed)
        recordings = base / 'recordings'
        verdicts, seconds, failures = diagnose_all(
            recordings, orders, jobs, lambda d, t: progress('diagnoses', d, t), command)
        drawn = json.loads(sealed.read_text(encoding='utf-8'))
        if keep:
            shutil.copy(sealed, base / 'labels.json')

        data = scorer.score(drawn['labels'], verdicts,
                            lambda name: generate.read(recordings / name), seconds,
                            progress=lambda d, t: progress('scores', d, t),
                            imitator=imitate.best_imitator)
    return {'n': n, 'set': set_name, 'encoders': 'both', 'input': 'torque', **(options or {}),
            'seed': seed, 'failures': failures,
            'not_drawn': drawn['not_drawn'], **data}


def text(data: dict[str, Any]) -> str:
    """Return all tables of `data` from evaluate(), at most 80 columns."""
    lines = [scorer.text(data)]
    for name, failure in data['failures'].items():
        lines.append(f'{name}: {failure}'[:80])
    if data['not_drawn']:
        lines.append(f'could not be drawn: {len(data["not_drawn"])}, '
                     + ', '.join('+'.join(ids) or 'none' for ids in data['not_drawn']))
    times = [r['seconds'] for r in data['rows'] if r['seconds'] is not None]
    if times:
        lines.append(f'{len(times)} diagnoses, median {np.median(times):.0f} CPU s, longest '
                     f'{max(times):.0f} CPU s')
    return '\n'.join(lines)


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns 1 if a bar is missed."""
    require_whole('--n', args.n)
    require_whole('--jobs', args.jobs)
    require_whole('--seed', args.seed, 0)
    if args.json and not Path(args.json).absolute().parent.is_dir():
        raise InputError(f'{args.json}: its directory does not exist, expected one that does')
    if args.keep and Path(args.keep).exists():
        raise InputError(f'{args.keep}: exists, expected a new directory')
    options = {name: getattr(args, name) for name, usual in (
        ('encoders', 'both'), ('input', 'torque'), ('effects', None))
        if getattr(args, name) != usual}
    shown = plant.shown(plant.EFFECTS, args.encoders, args.input)
    for name in args.effects or ():
        if name not in shown:
            raise InputError(f'--effects {name}: expected one of {", ".join(shown)}')
    if options and args.set != 'main':
        name, value = next(iter(options.items()))
        raise InputError(f'--{name} {value}: --set {args.set}, expected --set main')
    show = progress_line()
    if args.plant == 'mujoco':
        if options or args.set != 'main':
            raise InputError('--plant mujoco: expected neither --set, --encoders, --input nor '
                             '--effects')
        data = mujoco_set.evaluate(
            args.n, args.seed, lambda folder, orders, progress: diagnose_all(
                folder, orders, args.jobs, progress), args.keep,
            lambda stage, done, total: show(f'{stage} {done}/{total}'))
        show('')
        return finish(data, mujoco_set.text(data), args.json)
    data = evaluate(args.n, args.set, args.seed, args.jobs, args.keep,
                    lambda stage, done, total: show(f'{stage} {done}/{total}'),
                    options=options)
    show('')
    return finish(data, text(data), args.json)
